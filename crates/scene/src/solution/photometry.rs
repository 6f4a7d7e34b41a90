//! Illuminances of a solution.
//!
//! With η the luminous efficacy, lm/W, and H_b the irradiance in band b of n, direct light included, the illuminance is
//!
//! ```text
//! E_v = η (1/n) Σ_b H_b
//! ```
//!
//! the inverse of what photometric quantities of lights become: a number of lumens over η in every band, times a tint of mean 1. Volume zones have the spherical illuminance, by their fluence. Errors of
//! indirect and direct light add up; those of a surface are means over its area.

use crate::base::scene_error::{SceneError, invalid};
use crate::{Bands, Fields, Solution};

/// Photometric quantities of a solution in light mode.
#[derive(Clone, Copy, Debug)]
pub struct Photometry<'a> {
    solution: &'a Solution,
    efficacy: f64,
}

/// Illuminance of a surface, lx: means and extremes over its patches.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SurfaceIlluminance {
    /// Name of the surface.
    pub name: String,
    /// Area of its patches, m².
    pub area: f64,
    /// Mean illuminance, lx.
    pub mean: f64,
    /// Its error, lx; infinite where it is unknown.
    pub error: f64,
    /// Smallest and largest illuminance of a patch, lx.
    pub range: [f64; 2],
}

impl SurfaceIlluminance {
    /// Luminous flux that arrives, lm.
    #[must_use]
    pub fn flux(&self) -> f64 {
        self.area * self.mean
    }

    /// Uniformity: smallest over mean illuminance; 0 in the dark.
    #[must_use]
    pub fn uniformity(&self) -> f64 {
        if self.mean > 0.0 { self.range[0] / self.mean } else { 0.0 }
    }
}

impl<'a> Photometry<'a> {
    /// The photometric quantities of a solution for a luminous efficacy, lm/W.
    ///
    /// # Errors
    /// A thermal solution, bands with wavelengths, whose light has no common efficacy, or an efficacy that is no number above 0.
    pub fn new(solution: &'a Solution, efficacy: f64) -> Result<Photometry<'a>, SceneError> {
        if solution.scene.thermal().is_some() {
            return invalid("mode", "photometric quantities belong to light mode; this solution is thermal");
        }
        if solution.scene.bands().wavelengths().is_some() {
            return invalid(
                "bands",
                "bands with wavelengths have no common luminous efficacy; solve in bands without wavelengths",
            );
        }
        if !(efficacy.is_finite() && efficacy > 0.0) {
            return invalid("efficacy", "the luminous efficacy is a number above 0, in lm/W");
        }
        Ok(Photometry { solution, efficacy })
    }

    /// η times the mean over the bands of a field of one zone.
    fn of(&self, field: impl Fn(&Fields) -> Bands) -> f64 {
        let s = self.solution;
        let count = s.scene.bands().count() as f64;
        let sum: f64 = s.all_bands(|t| field(&t.fields)).into_iter().sum();
        self.efficacy * sum / count
    }

    /// Illuminance of zone `i` and its error, lx.
    #[must_use]
    pub fn illuminance(&self, i: usize) -> [f64; 2] {
        let at = |list: &[Bands]| list.get(i).copied().unwrap_or_default();
        let value = self.of(|f| at(&f.incident) + at(&f.direct));
        [value, self.of(|f| at(&f.error) + at(&f.direct_error))]
    }

    /// Luminous exitance of zone `i`, lm/m².
    #[must_use]
    pub fn exitance(&self, i: usize) -> f64 {
        self.of(|f| f.radiosity.get(i).copied().unwrap_or_default())
    }

    /// Illuminances of all surfaces with patches, in the order of the scene.
    #[must_use]
    pub fn surfaces(&self) -> Vec<SurfaceIlluminance> {
        let surfaces = self.solution.scene.surfaces();
        let row = |name: &String| SurfaceIlluminance {
            name: name.clone(),
            area: 0.0,
            mean: 0.0,
            error: 0.0,
            range: [f64::INFINITY, 0.0],
        };
        let mut rows: Vec<SurfaceIlluminance> = surfaces.iter().map(|s| row(&s.name)).collect();
        for (i, p) in self.solution.zones.patches.iter().enumerate() {
            let ([value, error], row) = (self.illuminance(i), &mut rows[p.surface]);
            row.area += p.area;
            row.mean += p.area * value;
            row.error += p.area * error;
            row.range = [row.range[0].min(value), row.range[1].max(value)];
        }
        rows.retain(|r| r.area > 0.0);
        for r in &mut rows {
            (r.mean, r.error) = (r.mean / r.area, r.error / r.area);
        }
        rows
    }
}
