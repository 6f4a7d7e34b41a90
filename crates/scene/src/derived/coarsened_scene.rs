//! Coarsened and refined scenes, for the discretization error.
//!
//! **Coarsened.** Patches may be twice as long. An axis of n cells gets ⌈n/2⌉ cells over the same extent; with w_c the fraction of a new
//! cell that the old cell c covers,
//!
//! ```text
//!     κ' = Σ w κ      κ'Ω' = Σ w κΩ      κ'(1−Ω')E' = Σ w κ(1−Ω)E      q' = Σ w q
//! ```
//!
//! and likewise T⁴ with the weight w κ(1−Ω), heat sources with w. Each mean is clamped between the least and the largest of its terms, so
//! that equal values keep their bits: weights such as 0.6 and 0.4 would otherwise turn one extinction into several by rounding. If
//! absorbing cells of prescribed temperature and of prescribed heat would merge, the medium is not coarsened.
//!
//! **Refined by m.** An axis of n cells gets mn cells, each with the values of its parent cell; an axis of one cell along which the scene is
//! periodic, or has symmetry planes at both ends, keeps it, because nothing varies along that axis. Patches are at most an m-th as large as the largest of their surface.
//!
//! **Cost:** linear in the number of cells.

use crate::bands::Bands;
use crate::base::scene_error::SceneError;
use crate::geometry::plate::{Plate, PlateKind};
use crate::medium::voxel_grid::VoxelGrid;
use crate::model::options::PatchRule;
use crate::scene::Scene;
use crate::thermal::ThermalCondition;
use crate::zones::Zones;
use zonal_math::vec3;

impl Scene {
    /// The scene on zones about twice as large, as far as the geometry allows.
    ///
    /// # Errors
    /// If the coarsened grid is invalid.
    pub fn coarsened(&self) -> Result<Scene, SceneError> {
        self.map_blocks(|block| block.coarsened_block())
    }

    /// As [`Scene::coarsened`], of one block of bands.
    fn coarsened_block(&self) -> Result<Scene, SceneError> {
        let default = self.patch_size();
        let mut parts = self.clone().into_parts();
        parts.options.patch_size = Some(2.0 * default);
        for surface in &mut parts.surfaces {
            surface.patch_size = surface.patch_size.map(|p| 2.0 * p);
        }
        if let Some(coarsened) = self.voxel_grid().map(VoxelGrid::coarsened).transpose()?.flatten() {
            parts.voxel_grid = Some(coarsened);
            parts.resample_cell_fractions(self.voxel_grid());
        }
        Scene::new(parts)
    }

    /// The scene on zones at most an `n`-th as large across as the largest of its `zones`.
    ///
    /// # Errors
    /// If the refined grid has too many cells.
    pub fn refined(&self, zones: &Zones, n: usize) -> Result<Scene, SceneError> {
        let rule = self.options().patch_rule;
        let mut largest = vec![0.0f64; self.surfaces().len()];
        zones
            .patches
            .iter()
            .for_each(|p| largest[p.surface] = largest[p.surface].max(patch_size(&p.plate, rule)));
        let smallest_pane = zones.panes.iter().fold(f64::INFINITY, |s, p| s.min(patch_size(&p.plate, rule)));
        let default = self.patch_size();
        let refined = |own: f64, limit: f64| if own > 0.0 { own.min(limit) } else { limit } / n as f64;
        self.map_blocks(|block| {
            let mut parts = block.into_parts();
            parts.options.patch_size =
                Some(refined(if smallest_pane.is_finite() { smallest_pane } else { 0.0 }, default));
            for (surface, largest) in parts.surfaces.iter_mut().zip(&largest) {
                surface.patch_size = Some(refined(*largest, surface.patch_size.unwrap_or(default)));
            }
            let endless = self.endless_axes();
            parts.voxel_grid = parts.voxel_grid.as_ref().map(|m| m.refined(endless, n)).transpose()?;
            parts.resample_cell_fractions(self.voxel_grid());
            Scene::new(parts)
        })
    }
}

impl Scene {
    /// The scene with the patches of some surfaces and panes at most an `n`-th as large across as their largest in `zones`; the patches of the others stay.
    ///
    /// # Errors
    /// If a patch size is not valid.
    pub fn with_divided_patches(
        &self,
        zones: &Zones,
        [surfaces, panes]: [&[bool]; 2],
        n: usize,
    ) -> Result<Scene, SceneError> {
        let (rule, default) = (self.options().patch_rule, self.patch_size());
        let mut largest = vec![0.0f64; self.surfaces().len()];
        for p in &zones.patches {
            largest[p.surface] = largest[p.surface].max(patch_size(&p.plate, rule));
        }
        let divided_panes = zones.panes.iter().filter(|p| panes.get(p.pane) == Some(&true));
        let pane = divided_panes.map(|p| patch_size(&p.plate, rule)).fold(f64::INFINITY, f64::min);
        self.map_blocks(|block| {
            let mut parts = block.into_parts();
            parts.options.patch_size = Some(default.min(pane / n as f64));
            for (k, surface) in parts.surfaces.iter_mut().enumerate() {
                let own = surface.patch_size.unwrap_or(default);
                let divides = surfaces.get(k) == Some(&true) && largest[k] > 0.0;
                surface.patch_size = Some(if divides { own.min(largest[k] / n as f64) } else { own });
            }
            Scene::new(parts)
        })
    }
}

/// The measure of a patch that a rule limits, m.
fn patch_size(p: &Plate, rule: PatchRule) -> f64 {
    let longest = p.e1.length().max(p.e2.length());
    match (rule, p.kind) {
        (PatchRule::Area, PlateKind::Triangle) => p.area().sqrt(),
        (_, PlateKind::Triangle) => {
            let longest = longest.max((p.e2 - p.e1).length());
            (2.0 * p.area()).sqrt().max(longest * std::f64::consts::FRAC_1_SQRT_2)
        }
        (_, PlateKind::Parallelogram) => longest,
    }
}

/// For each new cell of an axis, the old cells that it covers and their fractions of it.
fn covered_fractions(old: usize, new: usize) -> Vec<Vec<(usize, f64)>> {
    let edge = old as f64 / new as f64;
    let covered_by = |k: usize| {
        let (from, to) = (k as f64 * edge, ((k + 1) as f64 * edge).min(old as f64));
        let covered = from.floor() as usize..(to.ceil() as usize).min(old);
        let fraction = |c: usize| ((to.min((c + 1) as f64) - from.max(c as f64)) / edge).max(0.0);
        covered.map(|c| (c, fraction(c))).filter(|x| x.1 > 0.0).collect()
    };
    (0..new).map(covered_by).collect()
}

/// A mean clamped to the range of its terms, which removes rounding beyond them; unchanged without terms.
fn clamp_to_terms(mean: f64, terms: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = terms.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    if low <= high { mean.clamp(low, high) } else { mean }
}

/// A cell to be merged: its thermal condition, its fraction of the new cell, and the fraction times its absorption coefficient.
type MergedCell = (ThermalCondition, f64, f64);

/// The thermal condition of a cell that merges others; `None` if absorbing cells have both temperatures and heat sources.
fn merged_condition(cells: &[MergedCell]) -> Option<ThermalCondition> {
    let absorbed = cells.iter().map(|c| c.2).sum::<f64>();
    let weight = |c: &MergedCell| if absorbed > 0.0 { c.2 } else { c.1 };
    let (mut temperature_weight, mut fourth_powers) = (0.0, 0.0);
    let (mut heat_weight, mut heat_source) = (0.0, 0.0);
    for c in cells {
        match c.0 {
            ThermalCondition::Temperature(t) => {
                (temperature_weight, fourth_powers) =
                    (temperature_weight + weight(c), fourth_powers + weight(c) * t.powi(4));
            }
            ThermalCondition::Flux(q) | ThermalCondition::Power(q) => {
                (heat_weight, heat_source) = (heat_weight + weight(c), heat_source + c.1 * q);
            }
        }
    }
    if temperature_weight <= 0.0 {
        let heat = cells.iter().map(|c| c.0.prescribed_power());
        return Some(ThermalCondition::Flux(clamp_to_terms(heat_source, heat)));
    }
    // Cells that do not absorb have no weight.
    if heat_weight > 0.0 && absorbed > 0.0 {
        return None;
    }
    let kelvin = cells.iter().filter_map(|c| match c.0 {
        ThermalCondition::Temperature(t) if weight(c) > 0.0 => Some(t),
        _ => None,
    });
    let mean = (fourth_powers / temperature_weight).sqrt().sqrt();
    Some(ThermalCondition::Temperature(clamp_to_terms(mean, kelvin)))
}

impl VoxelGrid {
    /// The medium on half as many cells along each axis, at least one; `None` if a new cell would have both temperature and heat source.
    fn coarsened(&self) -> Result<Option<VoxelGrid>, SceneError> {
        let (old, extent) = (self.dims(), self.max() - self.min());
        let dims = old.map(|n| n.div_ceil(2));
        let edge = vec3(extent.x / dims[0] as f64, extent.y / dims[1] as f64, extent.z / dims[2] as f64);
        let mut out = VoxelGrid::new(self.min(), edge, dims)?;
        if self.is_uniform() {
            out.fill(self.extinction(0), self.albedo(0), self.emission(0), self.source(0));
            self.heat(0).into_iter().for_each(|k| out.fill_heat(k));
            return out.seal().map(Some);
        }
        let axes = [0, 1, 2].map(|a| covered_fractions(old[a], dims[a]));
        for index in 0..out.len() {
            let [i, j, k] = out.coordinates(index);
            let mut covered = Vec::new();
            for &(x, u) in &axes[0][i] {
                for &(y, v) in &axes[1][j] {
                    covered.extend(axes[2][k].iter().map(|&(z, w)| (self.index([x, y, z]), u * v * w)));
                }
            }
            if !self.merge(&covered, &mut out, index) {
                return Ok(None);
            }
        }
        out.seal().map(Some)
    }

    /// The medium on `n` times as many cells along each axis, except axes of one cell along which the scene is `endless`.
    fn refined(&self, endless: [bool; 3], n: usize) -> Result<VoxelGrid, SceneError> {
        let (old, extent) = (self.dims(), self.max() - self.min());
        let split: [usize; 3] = std::array::from_fn(|a| if old[a] == 1 && endless[a] { 1 } else { n });
        let dims: [usize; 3] = std::array::from_fn(|a| old[a].saturating_mul(split[a]));
        let edge = vec3(extent.x / dims[0] as f64, extent.y / dims[1] as f64, extent.z / dims[2] as f64);
        let mut out = VoxelGrid::new(self.min(), edge, dims)?;
        out.fill(self.extinction(0), self.albedo(0), self.emission(0), self.source(0));
        self.heat(0).into_iter().for_each(|k| out.fill_heat(k));
        if self.is_uniform() {
            return out.seal();
        }
        for index in 0..out.len() {
            let at = out.coordinates(index);
            let c = self.index(std::array::from_fn(|a| at[a] / split[a]));
            out.set(index, self.extinction(c), self.albedo(c), self.emission(c), self.source(c));
            self.heat(c).into_iter().for_each(|k| out.set_heat(index, k, ThermalCondition::Flux(0.0)));
        }
        out.seal()
    }

    /// Sets cell `index` of `out` to the merged cells `covered` of this grid, each with its fraction; false if they cannot be merged.
    fn merge(&self, covered: &[(usize, f64)], out: &mut VoxelGrid, index: usize) -> bool {
        // Optical properties: weighted sums over the covered cells.
        let cells = CoveredCells { covered };
        let plain_mean =
            |property: CellProperty| cells.mean(property, &|_| Bands::ONE, cells.sum(property), Bands::ONE);
        let (extinction, absorption) =
            (cells.sum(&|c| self.extinction(c)), cells.sum(&|c| self.absorption(c)));
        let scattering = |c: usize| self.extinction(c) * self.albedo(c);
        let emitted = |c: usize| self.absorption(c) * self.emission(c);
        let scattering_albedo =
            cells.mean(&|c| self.albedo(c), &|c| self.extinction(c), cells.sum(&scattering), extinction);
        let mean_albedo = plain_mean(&|c| self.albedo(c));
        let albedo =
            Bands::from_fn(|b| if extinction[b] > 0.0 { scattering_albedo[b] } else { mean_albedo[b] });
        let emission =
            cells.mean(&|c| self.emission(c), &|c| self.absorption(c), cells.sum(&emitted), absorption);
        let source = plain_mean(&|c| self.source(c));
        out.set(index, plain_mean(&|c| self.extinction(c)), albedo, emission, source);
        // Thermal conditions.
        let conditions: Vec<MergedCell> = covered
            .iter()
            .filter_map(|&(c, w)| Some((self.heat(c)?, w, w * self.absorption(c).sum())))
            .collect();
        if conditions.is_empty() {
            return true;
        }
        let merged = merged_condition(&conditions);
        merged.into_iter().for_each(|k| out.set_heat(index, k, ThermalCondition::Flux(0.0)));
        merged.is_some()
    }

    /// Absorption coefficient κ(1 − Ω) of a cell, 1/m.
    fn absorption(&self, c: usize) -> Bands {
        self.extinction(c) * (1.0 - self.albedo(c))
    }
}

/// A property of a cell, by its index.
type CellProperty<'a> = &'a dyn Fn(usize) -> Bands;

/// The cells that a new cell covers, each with its fraction of the new cell.
struct CoveredCells<'a> {
    covered: &'a [(usize, f64)],
}

impl CoveredCells<'_> {
    /// Sum of a property, weighted by the fractions.
    fn sum(&self, property: CellProperty) -> Bands {
        self.covered.iter().fold(Bands::ZERO, |s, &(c, w)| s + w * property(c))
    }

    /// `total`/`weight`, clamped to the values of `property` in cells of positive `cell_weight`; 0 without weight.
    fn mean(&self, property: CellProperty, cell_weight: CellProperty, total: Bands, weight: Bands) -> Bands {
        Bands::from_fn(|b| {
            let terms =
                self.covered.iter().filter(|&&(c, _)| cell_weight(c)[b] > 0.0).map(|&(c, _)| property(c)[b]);
            if weight[b] > 0.0 { clamp_to_terms(total[b] / weight[b], terms) } else { 0.0 }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::Vec3;

    #[test]
    fn covered_fractions_sum_to_one_and_cover_the_axis() {
        for (old, new) in [(9, 5), (4, 2), (3, 2), (1, 1), (7, 4), (115, 58)] {
            let all = covered_fractions(old, new);
            for list in &all {
                assert!((list.iter().map(|x| x.1).sum::<f64>() - 1.0).abs() < 1e-12, "{old} {list:?}");
            }
            let covered: f64 = all.iter().flatten().map(|x| x.1).sum::<f64>() * old as f64 / new as f64;
            assert!((covered - old as f64).abs() < 1e-9);
        }
    }

    #[test]
    fn coarsened_cells_conserve_powers() {
        let mut map = VoxelGrid::new(Vec3::ZERO, vec3(0.5, 0.25, 1.0), [3, 5, 2]).unwrap();
        for i in 0..map.len() {
            let x = i as f64;
            let extinction = Bands::from_rgb([0.1 * x, 0.2, 1.0]);
            let albedo = Bands::from_rgb([0.01 * x, 0.5, 0.9]);
            let emission = Bands::from_rgb([x, 1.0, 2.0 + x]);
            map.set(i, extinction, albedo, emission, Bands::from_rgb([0.0, 0.1 * x, 1.0]));
            map.set_heat(i, ThermalCondition::Flux(x), ThermalCondition::Flux(0.0));
        }
        let map = map.seal().unwrap();
        let half = map.coarsened().unwrap().unwrap();
        assert_eq!(half.dims(), [2, 3, 1]);
        let totals = |m: &VoxelGrid| {
            let volume = m.cell().x * m.cell().y * m.cell().z;
            let (mut bands, mut heat) = ([Bands::ZERO; 4], 0.0);
            for i in 0..m.len() {
                let (k, o, e, q) = (m.extinction(i), m.albedo(i), m.emission(i), m.source(i));
                bands[0] += volume * k;
                bands[1] += volume * k * o;
                bands[2] += volume * k * (1.0 - o) * e;
                bands[3] += volume * q;
                let Some(ThermalCondition::Flux(q)) = m.heat(i) else { panic!("heat") };
                heat += volume * q;
            }
            bands.into_iter().flatten().chain([heat]).collect::<Vec<f64>>()
        };
        for (a, b) in totals(&map).into_iter().zip(totals(&half)) {
            assert!((a - b).abs() <= 1e-12 * a.abs(), "{a} {b}");
        }
    }

    #[test]
    fn equal_values_keep_their_bits_when_coarsened() {
        for n in [3, 5, 7, 11, 13] {
            let mut map = VoxelGrid::new(Vec3::ZERO, vec3(0.4, 0.3, 0.1), [n, n, 2 * n]).unwrap();
            let (extinction, albedo) = (Bands::from_rgb([0.1, 0.7, 1.3]), Bands::from_rgb([0.3, 0.1, 0.9]));
            let (emission, source) = (Bands::splat(10.0 / 3.0), Bands::splat(0.7));
            for i in 0..map.len() {
                // Temperatures vary, so that the grid is not uniform.
                map.set(i, extinction, albedo, emission, source);
                map.set_heat(i, ThermalCondition::Temperature(300.0 + i as f64), ThermalCondition::Flux(0.0));
            }
            let half = map.seal().unwrap().coarsened().unwrap().unwrap();
            assert_eq!(half.uniform_extinction(), Some(extinction), "{n}");
            for i in 0..half.len() {
                assert_eq!(half.albedo(i), albedo);
                assert_eq!(half.emission(i), emission);
                assert_eq!(half.source(i), source);
            }
        }
    }

    #[test]
    fn refined_cells_have_the_values_of_their_parents() {
        let mut map = VoxelGrid::new(Vec3::ZERO, vec3(0.5, 0.25, 1.0), [3, 1, 1]).unwrap();
        for i in 0..map.len() {
            map.set(i, Bands::splat(0.1 * i as f64), Bands::splat(0.5), Bands::ONE, Bands::ZERO);
            map.set_heat(i, ThermalCondition::Flux(i as f64), ThermalCondition::Flux(0.0));
        }
        let fine = map.seal().unwrap().refined([true, true, false], 2).unwrap();
        assert_eq!((fine.dims(), fine.max()), ([6, 1, 2], vec3(1.5, 0.25, 1.0)));
        for i in 0..fine.len() {
            let x = fine.coordinates(i)[0] / 2;
            assert_eq!(fine.extinction(i), Bands::splat(0.1 * x as f64));
            assert_eq!(fine.heat(i), Some(ThermalCondition::Flux(x as f64)));
        }
    }

    #[test]
    fn absorbing_cells_determine_the_merged_condition() {
        let hot = (ThermalCondition::Temperature(1000.0), 0.25, 2.0);
        let clear = (ThermalCondition::Flux(0.0), 0.75, 0.0);
        assert_eq!(merged_condition(&[hot, clear]), Some(ThermalCondition::Temperature(1000.0)));
        assert_eq!(merged_condition(&[clear, clear]), Some(ThermalCondition::Flux(0.0)));
        let source = (ThermalCondition::Flux(8.0), 0.75, 3.0);
        assert_eq!(
            merged_condition(&[source, (ThermalCondition::Temperature(300.0), 0.25, 0.0)]),
            Some(ThermalCondition::Flux(6.0))
        );
        assert_eq!(merged_condition(&[hot, source]), None);
        let Some(ThermalCondition::Temperature(t)) =
            merged_condition(&[hot, (ThermalCondition::Temperature(500.0), 0.5, 2.0)])
        else {
            panic!()
        };
        assert!((t.powi(4) - 0.5 * (1e12 + 6.25e10)).abs() < 1.0);
    }
}
