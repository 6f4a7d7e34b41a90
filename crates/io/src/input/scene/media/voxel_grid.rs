//! The voxel grid of the medium while it is filled.
//!
//! A voxel that is filled in part gets volume means that conserve power: of the extinction κ, of the scattering coefficient κΩ, of the
//! emitted power κ_a E with κ_a = κ(1 − Ω), of the source, and of κ_a T⁴.

use crate::input::scene::quantities::gas_composition::Composition;
use crate::input::scene::quantities::medium_properties::MediumProperties;
use zonal_math::Vec3;
use zonal_scene::{Bands, ThermalCondition, VoxelGrid};

/// The condition of a voxel of which none is given yet.
pub(crate) const NO_CONDITION: ThermalCondition = ThermalCondition::Flux(f64::NAN);

/// Distance to a voxel's face, in voxels, below which a coordinate counts as on the face.
const FACE_TOLERANCE: f64 = 1e-9;

/// The state of one voxel: κ, Ω, E, q, and its thermal condition.
#[derive(Clone, Copy, Debug)]
struct VoxelState {
    extinction: Bands,
    albedo: Bands,
    emission: Bands,
    source: Bands,
    condition: ThermalCondition,
}

impl VoxelState {
    /// Absorption coefficient, 1/m.
    fn absorption(&self) -> Bands {
        self.extinction * (1.0 - self.albedo)
    }
    /// Fills a fraction f of the volume, 0 ≤ f ≤ 1, with other properties.
    fn fill(&mut self, f: f64, m: &MediumProperties) {
        let old = *self;
        let new = VoxelState {
            extinction: m.extinction.unwrap_or(old.extinction),
            albedo: m.albedo.unwrap_or(old.albedo),
            emission: m.emission.unwrap_or(old.emission),
            source: m.source.unwrap_or(old.source),
            condition: m.condition.unwrap_or(old.condition),
        };
        if f >= 1.0 {
            *self = new;
            return;
        }
        let mix = |a: f64, b: f64| a + f * (b - a);
        // The mean of a and b weighted with their volumes and with wa and wb; the volume mean if both weights vanish.
        let weighted = |a: f64, wa: f64, b: f64, wb: f64| {
            let (wa, wb) = ((1.0 - f) * wa, f * wb);
            if a == b || wa + wb <= 0.0 { mix(a, b) } else { a + (b - a) * (wb / (wa + wb)) }
        };
        let weighted_bands = |a: Bands, wa: Bands, b: Bands, wb: Bands| {
            Bands::from_fn(|band| weighted(a[band], wa[band], b[band], wb[band]))
        };
        *self = VoxelState {
            extinction: old.extinction.zip_map(new.extinction, mix),
            albedo: weighted_bands(old.albedo, old.extinction, new.albedo, new.extinction),
            emission: weighted_bands(old.emission, old.absorption(), new.emission, new.absorption()),
            source: old.source.zip_map(new.source, mix),
            condition: match (old.condition, new.condition) {
                (a, b) if a == b => a,
                (ThermalCondition::Temperature(a), ThermalCondition::Temperature(b)) => {
                    let (wa, wb) = (old.absorption().sum(), new.absorption().sum());
                    let fourth_power = weighted(a.powi(4), wa, b.powi(4), wb);
                    ThermalCondition::Temperature(fourth_power.powf(0.25))
                }
                (ThermalCondition::Flux(a), ThermalCondition::Flux(b)) if a.is_finite() && b.is_finite() => {
                    ThermalCondition::Flux(mix(a, b))
                }
                (ThermalCondition::Flux(a), b) if a.is_nan() => b,
                // A temperature and a heat source: the condition of the larger part.
                (a, b) => {
                    if f >= 0.5 {
                        b
                    } else {
                        a
                    }
                }
            },
        };
    }
}

/// The voxel grid while it is filled.
pub(crate) struct VoxelGridBuilder {
    /// Smallest corner, m.
    pub(crate) min: Vec3,
    /// Edges of a voxel, m.
    pub(crate) cell: Vec3,
    /// Voxels along each axis.
    pub(crate) dims: [usize; 3],
    pub(crate) grid: VoxelGrid,
    /// The composition of the gas in each voxel; empty without a gas model.
    pub(crate) gas: Vec<Composition>,
}

impl VoxelGridBuilder {
    /// The compositions of the gas in all voxels.
    pub(crate) fn compositions(&self) -> impl Iterator<Item = Composition> + '_ {
        self.gas.iter().copied()
    }
    /// Fills a fraction of a voxel with properties.
    pub(crate) fn fill(&mut self, cell: [usize; 3], fraction: f64, properties: &MediumProperties) {
        let v = &mut self.grid;
        let i = v.index(cell);
        if let Some(composition) = self.gas.get_mut(i) {
            for (old, new) in composition.iter_mut().zip(properties.gas) {
                *old = new.map_or(*old, |x| if fraction >= 1.0 { x } else { *old + fraction * (x - *old) });
            }
        }
        let mut state = VoxelState {
            extinction: v.extinction(i),
            albedo: v.albedo(i),
            emission: v.emission(i),
            source: v.source(i),
            condition: v.heat(i).unwrap_or(NO_CONDITION),
        };
        state.fill(fraction, properties);
        // An extinction that is no sample of a field has the borders of its shape.
        if properties.extinction.is_some() {
            v.unmark_interpolated(i);
        }
        v.set(i, state.extinction, state.albedo, state.emission, state.source);
        if v.is_thermal() {
            v.set_heat(i, state.condition, NO_CONDITION);
        }
    }
    /// Marks voxels, by index, whose extinction is interpolated between them in pictures.
    pub(crate) fn mark_interpolated(&mut self, cells: &[usize]) {
        cells.iter().for_each(|i| self.grid.mark_interpolated(*i));
    }
    /// The voxels along an axis that [lo, hi] overlaps, each with the fraction of its edge that is overlapped.
    pub(crate) fn overlaps(&self, axis: usize, lo: f64, hi: f64) -> Vec<(usize, f64)> {
        let (n, size) = (self.dims[axis], self.cell[axis]);
        let to_cell = |x: f64| (x - self.min[axis]) / size;
        let (a, b) = (to_cell(lo), to_cell(hi));
        // Snap to faces, so that rounding leaves no sliver of a neighbour.
        let snap = |x: f64| {
            if (x - x.round()).abs() < FACE_TOLERANCE { x.round() } else { x }
        };
        let (a, b) = (snap(a).max(0.0), snap(b).min(n as f64));
        if b <= a || a.is_nan() || b.is_nan() {
            return Vec::new();
        }
        (a.floor() as usize..(b.ceil() as usize).min(n))
            .map(|i| (i, b.min(i as f64 + 1.0) - a.max(i as f64)))
            .filter(|(_, fraction)| *fraction > 0.0)
            .collect()
    }
    /// Smallest and largest corner, m.
    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        (self.min, self.grid.max())
    }
    /// Fills the part of each voxel that a box overlaps; returns the number of overlapped voxels.
    pub(crate) fn fill_box(&mut self, min: Vec3, max: Vec3, properties: &MediumProperties) -> usize {
        let [x, y, z] = [0, 1, 2].map(|axis| self.overlaps(axis, min[axis], max[axis]));
        for &(i, fx) in &x {
            for &(j, fy) in &y {
                for &(k, fz) in &z {
                    self.fill([i, j, k], fx * fy * fz, properties);
                }
            }
        }
        x.len() * y.len() * z.len()
    }
}
