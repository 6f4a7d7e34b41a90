//! From scores to powers and temperatures.

use super::optics::{ElementOptics, WalkOptics};
use super::solution::{ForwardSolution, HeatBalance};
use crate::estimate::{SampleEstimate, SampleStatistics};
use zonal_scene::{Band, Bands, PerBand, Scene, ZoneKind, ZoneRef, Zones};

/// Layout of the scores: for each element (surface, medium, pane, loss) and zone one number per band and ∫σT⁴ of re-emission.
pub(super) struct ScoreLayout {
    /// Slot of the medium.
    pub medium: usize,
    /// Slot of the first pane.
    pub panes: usize,
    /// Slot of the escaped power.
    pub escaped: usize,
    /// Slot of the power absorbed by backs.
    pub backs: usize,
    /// Slot of the first zone.
    pub zones: usize,
    /// Number of slots.
    pub len: usize,
}

impl ScoreLayout {
    /// The layout of a scene, with or without zones.
    pub(super) fn new(scene: &Scene, zones: Option<&Zones>) -> ScoreLayout {
        let medium = scene.surfaces().len();
        let escaped = medium + 1 + scene.panes().len();
        let first = escaped + 2;
        let len = first + zones.map_or(0, Zones::len);
        ScoreLayout { medium, panes: medium + 1, escaped, backs: escaped + 1, zones: first, len }
    }
    /// Number of scores.
    pub(super) fn score_count(&self) -> usize {
        scores_per_slot() * self.len
    }
}

fn scores_per_slot() -> usize {
    Band::count() + 1
}

/// Index of the score of a slot in a band.
pub(super) fn band_score(slot: usize, band: Band) -> usize {
    scores_per_slot() * slot + band.index()
}

/// Index of the score ∫σT⁴ of re-emission of a slot.
pub(super) fn reemission_score(slot: usize) -> usize {
    scores_per_slot() * slot + Band::count()
}

/// The scores of all batches with the data that convert them.
pub(super) struct ScoreReader<'a> {
    pub scene: &'a Scene,
    pub zones: Option<&'a Zones>,
    pub optics: &'a WalkOptics,
    pub layout: &'a ScoreLayout,
    /// Area of each surface, m².
    pub areas: &'a [f64],
    /// Volume of each cell, m³; empty with zones.
    pub volumes: &'a [f64],
    /// The scores of each batch.
    pub sums: &'a [Vec<f64>],
    /// Power of one walk, W per band.
    pub walk_power: Bands,
}

/// An estimate whose error is at least `floor`.
fn floored(e: SampleEstimate, floor: f64) -> SampleEstimate {
    SampleEstimate { error: e.error.hypot(floor), ..e }
}

impl ScoreReader<'_> {
    /// Mean over the batches of a function of their scores.
    fn mean(&self, of: impl Fn(&[f64]) -> f64) -> SampleEstimate {
        let mut statistics = SampleStatistics::default();
        self.sums.iter().for_each(|s| statistics.add(of(s)));
        statistics.estimate(1.0)
    }

    /// The power of a slot per band, W.
    fn power(&self, slot: usize) -> PerBand<SampleEstimate> {
        PerBand::from_fn(|b| {
            let band = self.optics.simulated_band(b);
            floored(self.mean(|s| s[band_score(slot, band)]), self.walk_power[band])
        })
    }

    /// The results.
    pub(super) fn solution(&self) -> ForwardSolution {
        let scene = self.scene;
        let panes = |b: Band| {
            let band = self.optics.simulated_band(b);
            let sum = |s: &[f64]| {
                (0..scene.panes().len()).map(|p| s[band_score(self.layout.panes + p, band)]).sum()
            };
            floored(self.mean(sum), self.walk_power[band])
        };
        let mut out = ForwardSolution {
            surfaces: (0..scene.surfaces().len()).map(|i| self.power(i)).collect(),
            medium: self.power(self.layout.medium),
            panes: PerBand::from_fn(panes),
            escaped: self.power(self.layout.escaped),
            backs: self.power(self.layout.backs),
            ..ForwardSolution::default()
        };
        if let Some(z) = self.zones {
            out.zones = (0..z.len()).map(|i| self.zone_light(z, i)).collect();
        }
        if scene.thermal().is_some() {
            out.heat = self.element_heat();
            if let Some(z) = self.zones {
                out.zone_heat = (0..z.len()).map(|i| self.zone_heat(z, i)).collect();
            }
        }
        out
    }

    /// H or G of zone `i`, W/m² per band.
    fn zone_light(&self, z: &Zones, i: usize) -> PerBand<SampleEstimate> {
        let (_, measure) = z.response(i);
        PerBand::from_fn(|b| {
            let band = self.optics.simulated_band(b);
            let e = self.mean(|s| s[band_score(self.layout.zones + i, band)] / measure);
            floored(e, self.walk_power[band] / measure)
        })
    }

    /// Heat of surfaces, the medium and panes.
    fn element_heat(&self) -> Vec<HeatBalance> {
        let (optics, unit) = (self.optics, Bands::ONE);
        let mut out = Vec::new();
        for (i, k) in optics.surfaces.iter().enumerate() {
            out.push(self.heat(i, unit, &[(k, self.areas[i])]));
        }
        if self.scene.voxel_grid().is_some() {
            let parts: Vec<(&ElementOptics, f64)> = match self.zones {
                None => optics.cells.iter().zip(self.volumes.iter().copied()).collect(),
                Some(z) => z.voxels.iter().map(|v| (&optics.cells[v.cell], v.volume)).collect(),
            };
            out.push(self.heat(self.layout.medium, unit, &parts));
        }
        for (i, k) in optics.panes.iter().enumerate() {
            let p = &self.scene.panes()[i];
            let volume = p.thickness * p.plates.iter().map(|q| q.area()).sum::<f64>();
            out.push(self.heat(self.layout.panes + i, unit, &[(k, volume)]));
        }
        out
    }

    /// Heat of zone `i`.
    fn zone_heat(&self, z: &Zones, i: usize) -> HeatBalance {
        let (_, measure) = z.response(i);
        let zone = z.zone(i);
        let k = match zone {
            ZoneRef::Patch(p) => &self.optics.surfaces[p.surface],
            ZoneRef::Voxel(_, v) => &self.optics.cells[v.cell],
            ZoneRef::Pane(_, p) => &self.optics.panes[p.pane],
        };
        let is_patch = zone.kind() == ZoneKind::Patch;
        let absorbed = if is_patch { k.absorptance } else { k.absorptance * k.extinction };
        self.heat(self.layout.zones + i, absorbed, &[(k, measure)])
    }

    /// Heat of a slot that consists of elements, each with its area (m²) or volume (m³); `factor` converts scores to absorbed power.
    fn heat(&self, slot: usize, factor: Bands, parts: &[(&ElementOptics, f64)]) -> HeatBalance {
        let one = self.walk_power;
        let all = if self.optics.one_band { one.first() } else { one.sum() };
        // Size of the elements that have a temperature, and ∫σT⁴ from known temperatures and known powers.
        let warm = parts.iter().filter(|(k, _)| k.emissive_power.is_some() || k.total_weight > 0.0);
        let size: f64 = warm.map(|p| p.1).sum();
        let known = |(k, size): &(&ElementOptics, f64)| match k.emissive_power {
            Some(e) => e * size,
            None if k.total_weight > 0.0 => k.net_power * size / k.total_weight,
            None => 0.0,
        };
        let base: f64 = parts.iter().map(known).sum();
        // Emitted power: emission of known temperatures, net power of the others.
        let emitted: f64 = parts
            .iter()
            .map(|(k, size)| size * if k.emissive_power.is_some() { k.emission.sum() } else { k.net_power })
            .sum();
        // Scores of elements hold the power absorbed at known temperatures, those of zones the incident power.
        let absorbed = |s: &[f64]| Band::all().map(|b| factor[b] * s[band_score(slot, b)]).sum::<f64>();
        let absorbs = slot < self.layout.zones || parts.iter().all(|p| p.0.emissive_power.is_some());
        HeatBalance {
            emissive: (size > 0.0).then(|| {
                let weights = parts.iter().map(|p| p.0.total_weight);
                let min_weight = weights.filter(|e| *e > 0.0).fold(f64::INFINITY, f64::min);
                let sampled = parts.iter().any(|p| p.0.reemits) && min_weight.is_finite();
                let e = self.mean(|s| (base + s[reemission_score(slot)]) / size);
                floored(e, if sampled { all / (min_weight * size) } else { 0.0 })
            }),
            power: {
                let e = self.mean(|s| emitted - if absorbs { absorbed(s) } else { 0.0 });
                floored(e, if absorbs { all } else { 0.0 })
            },
        }
    }
}
