//! Light groups: the contribution of each light to a solution, stored separately so that lights can be scaled after the solve.
//!
//! The zonal equations are linear: with H_g the irradiance due to group g alone and a factor f_g a band,
//!
//! ```text
//!     H = Σ_g f_g H_g        H_dir = Σ_g f_g H_dir,g        B = Σ_g f_g E_g + ρ (H + H_dir)
//! ```
//!
//! is the solution for lights of f_g times the power. A group is a light of the scene, an emitting surface, the medium, all panes or the
//! surroundings.

use crate::bands::Bands;
use crate::bands::band::PerBand;
use crate::solution::energy_balance::EnergyBalance;
use crate::solution::solve_status::SolveStatus;
use crate::zones::{ZoneKind, Zones};

/// Name of the group of emission and volumetric source of the medium.
pub const MEDIUM_GROUP: &str = "medium";
/// Name of the group of the panes' emission.
pub const PANES_GROUP: &str = "panes";
/// Name of the single group if lights are solved in one sum.
pub const ALL_LIGHTS_GROUP: &str = "all";

/// The source of a light group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightGroupKind {
    /// A direct light, by index.
    Light(usize),
    /// The emission of a surface's zones, by index of the surface.
    Surface(usize),
    /// The emission of the voxels.
    Medium,
    /// The emission of the panes.
    Panes,
    /// The radiance of the surroundings.
    Surroundings,
    /// All sources.
    #[default]
    All,
}

impl LightGroupKind {
    /// True if the emission of zone `i` belongs to the group.
    pub fn emits(self, zones: &Zones, i: usize) -> bool {
        match self {
            LightGroupKind::All => true,
            LightGroupKind::Surface(s) => zones.patches.get(i).is_some_and(|p| p.surface == s),
            LightGroupKind::Medium => zones.kind(i) == ZoneKind::Voxel,
            LightGroupKind::Panes => zones.kind(i) == ZoneKind::Pane,
            LightGroupKind::Light(_) | LightGroupKind::Surroundings => false,
        }
    }
    /// True if light number `l` of the scene belongs to the group.
    pub fn has_light(self, l: usize) -> bool {
        self == LightGroupKind::All || self == LightGroupKind::Light(l)
    }
}

/// Values of all zones in double or single precision, three bands each; an empty list stands for zeros.
#[derive(Clone, Debug, PartialEq)]
pub enum ZoneValues {
    /// Double precision.
    Double(Vec<Bands>),
    /// Single precision: relative rounding error 6e-8.
    Single(Vec<PerBand<f32>>),
}

impl Default for ZoneValues {
    fn default() -> ZoneValues {
        ZoneValues::Double(Vec::new())
    }
}

impl ZoneValues {
    /// Number of zones; 0 for zeros.
    pub fn len(&self) -> usize {
        match self {
            ZoneValues::Double(v) => v.len(),
            ZoneValues::Single(v) => v.len(),
        }
    }
    /// True for zeros.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// The value of zone `i`.
    pub fn at(&self, i: usize) -> Bands {
        match self {
            ZoneValues::Double(v) => v.get(i).copied().unwrap_or_default(),
            ZoneValues::Single(v) => v.get(i).map_or(Bands::ZERO, |x| x.map(f64::from)),
        }
    }
    /// Adds `scale` times the values to `out`, zone by zone.
    pub fn add_to(&self, out: &mut [Bands], scale: Bands) {
        match self {
            ZoneValues::Double(v) => {
                out.iter_mut().zip(v).for_each(|(o, x)| *o += scale * x);
            }
            ZoneValues::Single(v) => {
                out.iter_mut().zip(v).for_each(|(o, x)| *o += scale * x.map(f64::from));
            }
        }
    }
    /// The values normalized by the largest modulus of each band in single precision, and these moduli as factors.
    ///
    /// ```
    /// use zonal_scene::{Bands, ZoneValues};
    /// let (values, scale) = ZoneValues::to_single_precision(&[[1e30, 0.5, 0.0], [5e29, 1.0, 0.0]].map(Bands::from_rgb));
    /// assert_eq!(scale.to_rgb(), [1e30, 1.0, 1.0]);
    /// assert_eq!(values.at(1).to_rgb(), [0.5, 1.0, 0.0]);
    /// ```
    pub fn to_single_precision(values: &[Bands]) -> (ZoneValues, Bands) {
        let largest = values.iter().fold(Bands::ZERO, |m, x| m.max(x.abs()));
        let scale = largest.map(|m| if m > 0.0 && m.is_finite() { m } else { 1.0 });
        let rounded = |x: &Bands| (x / scale).map(|x| x as f32);
        (ZoneValues::Single(values.iter().map(rounded).collect()), scale)
    }
}

/// The fields and the energy balance of one group of lights.
#[derive(Clone, Debug, PartialEq)]
pub struct LightGroup {
    /// Name: that of a light or of a surface, or a name of this module.
    pub name: String,
    /// The source.
    pub kind: LightGroupKind,
    /// H of patches, G of volume zones, W/m², without direct light; times `incident_scale`.
    pub incident: ZoneValues,
    /// Estimated error of `incident` without the part due to the surroundings, W/m²; times `incident_scale`. Empty if errors are known only
    /// for all groups together.
    pub error: ZoneValues,
    /// Factor of `incident` and `error`, a band.
    pub incident_scale: Bands,
    /// H_dir, G_dir, W/m²; times `direct_scale`. Empty without direct light.
    pub direct: ZoneValues,
    /// Estimated error of `direct`, W/m²; times `direct_scale`. Empty without direct light.
    pub direct_error: ZoneValues,
    /// Factor of `direct` and `direct_error`, a band.
    pub direct_scale: Bands,
    /// Energy balance of the group, W.
    pub energy: EnergyBalance,
    /// Final status of the iteration, a band.
    pub status: PerBand<SolveStatus>,
    /// Final residual relative to the power of the group's sources, a band.
    pub residual: Bands,
}

impl Default for LightGroup {
    fn default() -> LightGroup {
        LightGroup {
            name: ALL_LIGHTS_GROUP.into(),
            kind: LightGroupKind::All,
            incident: ZoneValues::default(),
            error: ZoneValues::default(),
            incident_scale: Bands::ONE,
            direct: ZoneValues::default(),
            direct_error: ZoneValues::default(),
            direct_scale: Bands::ONE,
            energy: EnergyBalance::default(),
            status: PerBand::splat(SolveStatus::Converged),
            residual: Bands::ZERO,
        }
    }
}

impl LightGroup {
    /// H or G of zone `i` without direct light, W/m².
    pub fn incident_at(&self, i: usize) -> Bands {
        self.incident.at(i) * self.incident_scale
    }
    /// H_dir or G_dir of zone `i`, W/m².
    pub fn direct_at(&self, i: usize) -> Bands {
        self.direct.at(i) * self.direct_scale
    }
    /// Estimated error of H or G of all zones, W/m²; zeros if it is not known.
    pub fn errors(&self, zones: usize) -> Vec<Bands> {
        let mut out = vec![Bands::ZERO; zones];
        self.error.add_to(&mut out, self.incident_scale);
        out
    }
    /// Multiplies the power of the group by a factor per band.
    ///
    /// ```
    /// use zonal_scene::{Bands, LightGroup};
    /// let mut group = LightGroup::default();
    /// group.scale(Bands::from_rgb([2.0, 1.0, 0.0]));
    /// group.scale(Bands::from_rgb([2.0, 1.0, 1.0]));
    /// assert_eq!(group.incident_scale.to_rgb(), [4.0, 1.0, 0.0]);
    /// assert_eq!(group.direct_scale, group.incident_scale);
    /// ```
    pub fn scale(&mut self, factor: Bands) {
        self.incident_scale *= factor;
        self.direct_scale *= factor;
        self.energy.scale(factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_precision_has_its_relative_error_at_any_magnitude() {
        let value = |i: usize| Bands::from_rgb([1e30 / (1.0 + i as f64), 1e-40 * i as f64, 0.0]);
        let values: Vec<Bands> = (0..50).map(value).collect();
        let (v, scale) = ZoneValues::to_single_precision(&values);
        let mut restored = vec![Bands::ZERO; 50];
        v.add_to(&mut restored, scale);
        for (x, y) in values.iter().flatten().zip(restored.iter().flatten()) {
            assert!((x - y).abs() <= 6e-8 * x, "{x:e} {y:e}");
        }
        let mut zeros = [Bands::ZERO; 2];
        ZoneValues::default().add_to(&mut zeros, Bands::ONE);
        assert_eq!(zeros, [Bands::ZERO; 2]);
    }
}
