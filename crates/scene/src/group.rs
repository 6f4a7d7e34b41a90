//! Light groups: the share of each light in a solution, kept apart so that lights can be turned up and down afterwards.
//!
//! The zonal equations are linear: with H_g the irradiance that group g alone gives, f_g a factor a band,
//!
//! ```text
//!     H = Σ_g f_g H_g        H_dir = Σ_g f_g H_dir,g        B = Σ_g f_g E_g + ρ (H + H_dir)
//! ```
//!
//! is the solution for lights that shine f_g times as strongly. A group is a light of the scene, an emitting surface, or one of the
//! names below.

use crate::solution::Energy;
use crate::{Bands, SolveStatus, Zones, bands};

/// The group of what voxels emit: emission and volumetric source of the medium.
pub const MEDIUM: &str = "medium";
/// The group of what panes emit.
pub const PANES: &str = "panes";
/// The group of the radiance that comes in from the surroundings' zone.
pub const SURROUNDINGS: &str = "surroundings";
/// The one group of everything, where groups were not kept apart.
pub const ALL: &str = "all";

/// What a group consists of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// Light number so and so of the scene.
    Light(usize),
    /// What surface number so and so emits as zones.
    Surface(usize),
    /// What the voxels emit.
    Medium,
    /// What the panes emit.
    Panes,
    /// What comes in from the surroundings' zone.
    Surroundings,
    /// Everything.
    #[default]
    All,
}

impl Kind {
    /// True where the own emission of zone `i` belongs to the group.
    pub fn emits(self, zones: &Zones, i: usize) -> bool {
        match self {
            Kind::All => true,
            Kind::Surface(s) => i < zones.voxel_offset() && zones.patches[i].surface == s,
            Kind::Medium => (zones.voxel_offset()..zones.pane_offset()).contains(&i),
            Kind::Panes => i >= zones.pane_offset(),
            Kind::Light(_) | Kind::Surroundings => false,
        }
    }
    /// True where light number `l` of the scene belongs to the group.
    pub fn has_light(self, l: usize) -> bool {
        self == Kind::All || self == Kind::Light(l)
    }
}

/// Values over zones in double or single precision, three bands each; an empty list stands for zeros.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// As computed.
    Double(Vec<Bands>),
    /// Rounded to 6e-8 of each value.
    Single(Vec<[f32; 3]>),
}

impl Default for Values {
    fn default() -> Values {
        Values::Double(Vec::new())
    }
}

impl Values {
    /// Number of zones; 0 for zeros.
    pub fn len(&self) -> usize {
        match self {
            Values::Double(v) => v.len(),
            Values::Single(v) => v.len(),
        }
    }
    /// True for zeros.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// The value of zone `i`.
    pub fn at(&self, i: usize) -> Bands {
        match self {
            Values::Double(v) => v.get(i).copied().unwrap_or_default(),
            Values::Single(v) => v.get(i).map_or([0.0; 3], |x| x.map(f64::from)),
        }
    }
    /// Adds `scale` times the values to `out`, zone by zone.
    pub fn add_to(&self, out: &mut [Bands], scale: Bands) {
        match self {
            Values::Double(v) => {
                out.iter_mut().zip(v).for_each(|(o, x)| *o = bands(|b| o[b] + scale[b] * x[b]));
            }
            Values::Single(v) => {
                out.iter_mut().zip(v).for_each(|(o, x)| *o = bands(|b| o[b] + scale[b] * x[b] as f64));
            }
        }
    }
    /// The values of `zones` zones.
    pub fn expanded(&self, zones: usize) -> Vec<Bands> {
        let mut out = vec![[0.0; 3]; zones];
        self.add_to(&mut out, [1.0; 3]);
        out
    }
    /// The same in single precision, with the factor a band that brings them back: values over the largest of the band.
    pub fn compact(values: &[Bands]) -> (Values, Bands) {
        let most = values.iter().fold([0.0f64; 3], |m, x| bands(|b| m[b].max(x[b].abs())));
        let scale = most.map(|m| if m > 0.0 && m.is_finite() { m } else { 1.0 });
        let rounded = |x: &Bands| [0, 1, 2].map(|b| (x[b] / scale[b]) as f32);
        (Values::Single(values.iter().map(rounded).collect()), scale)
    }
}

/// What one group of lights does.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Its name: that of a light or of a surface, or one of this module's.
    pub name: String,
    /// What it consists of.
    pub kind: Kind,
    /// H of patches, G of volume zones, W/m², without direct light; times `incident_scale`.
    pub incident: Values,
    /// Estimated error of `incident` without what the surroundings' own adds, W/m²; times `incident_scale`. Empty where errors are known of
    /// all groups together only.
    pub error: Values,
    /// Factor of `incident` and `error`, a band.
    pub incident_scale: Bands,
    /// H_dir, G_dir, W/m²; times `direct_scale`. Empty where the group has no direct light.
    pub direct: Values,
    /// Estimated error of `direct`, W/m²; times `direct_scale`. Empty where the group has no direct light.
    pub direct_error: Values,
    /// Factor of `direct` and `direct_error`, a band.
    pub direct_scale: Bands,
    /// Its own balance, W.
    pub energy: Energy,
    /// How its iteration ended, a band.
    pub status: [SolveStatus; 3],
    /// Its last residual, relative to the power that its sources give, a band.
    pub residual: Bands,
}

impl Default for Group {
    fn default() -> Group {
        Group {
            name: ALL.into(),
            kind: Kind::All,
            incident: Values::default(),
            error: Values::default(),
            incident_scale: [1.0; 3],
            direct: Values::default(),
            direct_error: Values::default(),
            direct_scale: [1.0; 3],
            energy: Energy::default(),
            status: [SolveStatus::Converged; 3],
            residual: [0.0; 3],
        }
    }
}

impl Group {
    /// Turns the group up or down by a factor a band.
    pub fn scale(&mut self, factor: Bands) {
        self.incident_scale = bands(|b| self.incident_scale[b] * factor[b]);
        self.direct_scale = bands(|b| self.direct_scale[b] * factor[b]);
        self.energy.scale(factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_precision_holds_its_promise_for_any_magnitude() {
        let values: Vec<Bands> = (0..50).map(|i| [1e30 / (1.0 + i as f64), 1e-40 * i as f64, 0.0]).collect();
        let (v, scale) = Values::compact(&values);
        let mut back = vec![[0.0; 3]; 50];
        v.add_to(&mut back, scale);
        for (x, y) in values.iter().flatten().zip(back.iter().flatten()) {
            assert!((x - y).abs() <= 6e-8 * x, "{x:e} {y:e}");
        }
        assert_eq!(Values::default().expanded(2), [[0.0; 3]; 2]);
    }
}
