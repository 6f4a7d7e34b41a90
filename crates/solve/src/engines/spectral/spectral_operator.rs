//! The operator of the spectral engine and its errors (header of [`super`]).

use super::box_in_blocks;
use super::enclosure::{BoxEnclosure, OPENING};
use super::kernels::{GridKernels, TableSummary};
use super::memory;
use crate::device::basis::BasisOrder;
use crate::device::grid::BoxGrid;
use crate::device::slabs::Slabs;
use crate::device::{Device, GridConvolution, GridPart, WallValues};
use crate::distribution::multivector::{times_scaling, total};
use crate::distribution::sum_order::SumOrder;
use crate::distribution::zone_blocks::ZoneBlocks;
use crate::distribution::{Execution, Message};
use crate::engines::spectral::buffer_pool::BufferPool;
use crate::operator::{ErrorModel, ExchangeOperator, IncidentPower, extend_to_slopes};
use rayon::prelude::*;
use std::borrow::Cow;
use std::ops::Range;
use zonal_exchange::aligned::lattice::MethodCounts;
use zonal_exchange::pair::{closure_target, scaled_radiosity_coefficient};
use zonal_math::Grade;
use zonal_math::parallel;
use zonal_scene::{Band, Bands, NoProgress, PerBand, Zones};

/// Relative error of a transform and its inverse, in units of ε √log₂N.
const TRANSFORM_ROUNDING: f64 = 4.0;
/// Values that a task copies.
const COPIES_OF_TASK: usize = 1 << 12;
/// Closure error over the largest measured defect of a row.
const DEFECT_MULTIPLE: f64 = 2.0;

/// The zones of a vector.
struct VectorLayout<'a> {
    /// Number of patches, which precede the voxels.
    patches: usize,
    /// Number of voxels in vectors: all, or those of this rank.
    voxels: usize,
    /// Order of sums, which knows whether vectors have the voxels of this rank alone.
    sums: SumOrder<'a>,
}

/// The exchange of a box enclosure.
pub struct SpectralOperator<'a> {
    enclosure: BoxEnclosure,
    part: GridPart<'a>,
    layout: VectorLayout<'a>,
    device: &'a dyn Device,
    /// Products on the device, of each distinct extinction.
    convolution: Box<dyn GridConvolution + 'a>,
    /// The tables of each distinct extinction.
    tables: Vec<TableSummary>,
    /// A buffer for the values of the voxels of this rank, reused by every product.
    values: BufferPool<Vec<f64>>,
    /// The extinction group of each band.
    group: PerBand<usize>,
    /// d of g'_ij = d_i g_ij d_j, where closure was restored.
    scaling: Option<Vec<Bands>>,
    /// Relative closure error: [`DEFECT_MULTIPLE`] times the largest defect of a row in a uniform field.
    defect: Bands,
}

impl<'a> SpectralOperator<'a> {
    /// Computes the kernels of an enclosure with these zones, shared by the processes of `execution`; `device` computes the products. Vectors have
    /// the voxels of `zones`: all, or those of the planes of this rank.
    pub fn new(
        enclosure: BoxEnclosure,
        zones: &Zones,
        order: BasisOrder,
        device: &'a dyn Device,
        execution: Execution<'a>,
    ) -> SpectralOperator<'a> {
        let part = GridPart::new(enclosure.grid, order, execution.communicator);
        SpectralOperator::of_part(enclosure, zones, part, device, execution)
    }

    /// As [`SpectralOperator::new`], for the part of this process in the grid.
    pub(crate) fn of_part(
        enclosure: BoxEnclosure,
        zones: &Zones,
        part: GridPart<'a>,
        device: &'a dyn Device,
        execution: Execution<'a>,
    ) -> SpectralOperator<'a> {
        let layout = VectorLayout {
            patches: zones.patches.len(),
            voxels: zones.voxels.len(),
            sums: SumOrder::of_zones(zones, execution.communicator),
        };
        SpectralOperator::with_layout(enclosure, layout, part, device, execution)
    }

    /// As [`SpectralOperator::new`], for vectors of a layout.
    fn with_layout(
        enclosure: BoxEnclosure,
        layout: VectorLayout<'a>,
        part: GridPart<'a>,
        device: &'a dyn Device,
        execution: Execution<'a>,
    ) -> SpectralOperator<'a> {
        let progress = execution.progress;
        let (group, kappa) = enclosure.extinction_groups();
        progress.begin("exchange areas by offset", kappa.len() as u64);
        let mut convolution = device.convolution(part);
        let mut spare = Vec::new();
        let tables = kappa
            .iter()
            .map(|&kappa| {
                let kernels = GridKernels::new(&part, kappa, &mut spare);
                convolution.load(kernels.spectra);
                progress.advance(1);
                kernels.tables
            })
            .collect();
        progress.end();
        let values = BufferPool::default();
        values.give(spare);
        SpectralOperator {
            enclosure,
            part,
            layout,
            device,
            convolution,
            tables,
            values,
            group,
            scaling: None,
            defect: Bands::ZERO,
        }
    }

    /// The grid.
    pub(crate) fn grid(&self) -> &BoxGrid {
        &self.enclosure.grid
    }

    /// Names and values of the counters of the tables.
    pub(crate) fn counts(&self) -> Vec<(String, u64)> {
        let all: Vec<_> = self.tables.iter().flat_map(|k| &k.tally).collect();
        let sum = |of: fn(&MethodCounts) -> usize| all.iter().map(|(_, t)| of(t) as u64).sum::<u64>();
        let n = (self.layout.patches + self.grid().count()) as u64;
        let [of_patches, of_voxels] =
            [self.part.order.patch_components() - 1, self.part.order.voxel_components() - 1];
        let slopes = (of_patches * self.layout.patches + of_voxels * self.grid().count()) as u64;
        [
            ("pairs", n * (n + 1) / 2),
            ("slopes of radiosity", slopes),
            ("offsets in tables", sum(MethodCounts::total)),
            ("offsets by series of moments", sum(|t| t.moments)),
            ("offsets by Gauss rules", sum(|t| t.gauss)),
            ("offsets by pyramid coordinates", sum(|t| t.pyramid)),
            ("offsets in closed form", sum(|t| t.closed)),
            ("offsets by sums of Gaussians", sum(|t| t.gaussians)),
        ]
        .into_iter()
        .filter(|x| x.1 > 0)
        .map(|(what, n)| (what.to_string(), n))
        .collect()
    }

    /// Bytes of the engine of one of `ranks` processes for a grid with a number of distinct extinctions.
    pub(crate) fn bytes(grid: &BoxGrid, extinctions: usize, order: BasisOrder, ranks: usize) -> u64 {
        let of_blocks = box_in_blocks::grid_of_blocks(grid).map_or(0, |blocks| {
            SpectralOperator::bytes_without_blocks(&blocks, extinctions, BasisOrder::Constant, 1)
                + box_in_blocks::bytes_of_vectors(grid, &blocks)
        });
        SpectralOperator::bytes_without_blocks(grid, extinctions, order, ranks) + of_blocks
    }

    fn bytes_without_blocks(grid: &BoxGrid, extinctions: usize, order: BasisOrder, ranks: usize) -> u64 {
        let slabs = Slabs::of_rank(grid, 0, ranks);
        // During the construction two stages of a spectrum exist at a time; with slopes, the tables of all kernels on every rank. Messages take as much again.
        let tables = match order {
            BasisOrder::Constant => 0,
            BasisOrder::Linear => {
                8 * order.volume_layout().densities.len() as u64
                    * grid.distances().iter().map(|n| *n as u64).product::<u64>()
            }
        };
        let messages = if ranks > 1 { 2 } else { 0 };
        let spectrum = grid.halves().iter().map(|h| *h as u64).product::<u64>() / ranks as u64;
        let making = 8 * spectrum * (2 + messages) + tables;
        let vectors = 8 * (order.voxel_components() * grid.count() / ranks) as u64;
        memory::spectra_bytes(grid, order, &slabs) * extinctions as u64
            + (memory::work_bytes(grid, order, &slabs) + vectors).max(making)
    }

    /// Number of zones; [`ExchangeOperator::len`] counts their slopes too.
    pub fn zones(&self) -> usize {
        self.layout.patches + self.layout.voxels
    }

    /// True if vectors have exactly the voxels of this rank.
    fn has_own_voxels(&self) -> bool {
        self.layout.sums.is_divided() || self.part.slabs.ranks() == 1
    }

    /// The voxels of this rank among those of a vector.
    fn own_voxels(&self) -> Range<usize> {
        if self.layout.sums.is_divided() {
            return 0..self.layout.voxels;
        }
        let plane = self.grid().cells[1] * self.grid().cells[2];
        let planes = self.part.slabs.planes();
        planes.start * plane..planes.end * plane
    }

    /// Values of the voxels of a vector by component, from those of this rank.
    fn all_voxels<'b>(&self, own: &'b [f64]) -> Cow<'b, [f64]> {
        if self.has_own_voxels() {
            return Cow::Borrowed(own);
        }
        let mut bytes = Vec::with_capacity(8 * own.len());
        own.iter().for_each(|x| x.put(&mut bytes));
        let all = self.part.slabs.communicator.all_gather(bytes);
        let parts = self.part.order.voxel_components();
        let mut out = Vec::with_capacity(parts * self.layout.voxels);
        for p in 0..parts {
            let of_rank = |bytes: &Vec<u8>| bytes.len() / parts * p..bytes.len() / parts * (p + 1);
            let values = all.iter().flat_map(|bytes| bytes[of_rank(bytes)].chunks_exact(8));
            out.extend(values.map(f64::get));
        }
        Cow::Owned(out)
    }

    /// Index of the first unknown of component `q` of the patches.
    fn patch_offset(&self, q: usize) -> usize {
        if q == 0 { 0 } else { self.zones() + (q - 1) * self.layout.patches }
    }

    /// Index of the first unknown of component `p` of the voxels.
    fn voxel_offset(&self, p: usize) -> usize {
        match p {
            0 => self.layout.patches,
            _ => {
                self.zones()
                    + (self.part.order.patch_components() - 1) * self.layout.patches
                    + (p - 1) * self.layout.voxels
            }
        }
    }

    /// Index in the values of the wall, and unknown, of every component of the patches of a wall.
    fn wall_unknowns<'b>(&'b self, zones: &'b [u32]) -> impl Iterator<Item = (usize, usize)> + 'b {
        (0..self.part.order.patch_components()).flat_map(move |q| {
            let all = zones.iter().enumerate().filter(|(_, z)| **z != OPENING);
            all.map(move |(i, z)| (q * zones.len() + i, self.patch_offset(q) + *z as usize))
        })
    }

    /// Incident power for a radiosity of one at the openings: the factors of the surroundings, m² and m³.
    pub fn opening_factors(&self) -> Vec<Bands> {
        let mut out = vec![Bands::ZERO; self.len()];
        let mut faces = self.part.zero_walls();
        for (face, zones) in faces.iter_mut().flatten().zip(self.enclosure.faces.iter().flatten()) {
            face.iter_mut().zip(zones).for_each(|(x, z)| *x = f64::from(u8::from(*z == OPENING)));
        }
        let mut voxels = self.take_values();
        for g in 0..self.tables.len() {
            parallel::for_each(&mut voxels, |_, x| *x = 0.0);
            let met = self.convolution.exchange(g, &mut voxels, &faces);
            let of: Vec<Band> = Band::all().filter(|&b| self.group[b] == g).collect();
            let all = self.all_voxels(&voxels);
            self.scatter(&all, &met, &mut out, |o, x| of.iter().for_each(|&b| o[b] = x));
        }
        self.values.give(voxels);
        // Negative rounding errors of the transforms are cut off.
        out[..self.zones()].iter_mut().flatten().for_each(|x| *x = x.max(0.0));
        out
    }

    /// Measures the closure of all rows, slopes included, with the factors of the `openings` (by unknown, empty for none). [`DEFECT_MULTIPLE`] times the
    /// largest defect is added to the relative error of the factors. Returns the incident power of the zones in the uniform field.
    pub(crate) fn measure_defect(&mut self, zones: &Zones, openings: &[Bands]) -> Vec<Bands> {
        let (n, slopes) = (self.zones(), self.slope_zones());
        let level = |i: usize| if i < n { scaled_radiosity_coefficient(zones, i) } else { Bands::ZERO };
        let mut rows: Vec<Bands> = parallel::collect(self.len(), level);
        self.replace(&mut rows);
        let off = |i: usize| {
            // Patches outside have rows elsewhere.
            if self.enclosure.outside.binary_search(&(i as u32)).is_ok() {
                return Bands::ZERO;
            }
            let zone = if i < self.zones() { i } else { slopes[i - self.zones()] as usize };
            let (whole, open) = (closure_target(zones, zone), openings.get(i).copied().unwrap_or_default());
            let want = if i < self.zones() { whole } else { 0.0 };
            ((rows[i] + open - want) / whole).abs()
        };
        let worst = |x: Bands, y: Bands| x.zip_map(y, |x, y| if y <= x { x } else { y });
        let found = (0..rows.len()).into_par_iter().map(off).reduce(|| Bands::ZERO, worst);
        let found = self.layout.sums.over_processes(found, worst);
        self.defect = found.map(|d| if d.is_finite() { DEFECT_MULTIPLE * d } else { f64::INFINITY });
        rows.truncate(n);
        rows
    }

    /// Values on the walls of a vector over the unknowns; 0 at openings.
    fn wall_values(&self, at: impl Fn(usize) -> f64) -> WallValues {
        let mut faces = self.part.zero_walls();
        for (face, zones) in faces.iter_mut().flatten().zip(self.enclosure.faces.iter().flatten()) {
            self.wall_unknowns(zones).for_each(|(i, unknown)| face[i] = at(unknown));
        }
        faces
    }

    /// Writes values of voxels and walls into a vector over the unknowns: `put` stores a value in an entry.
    fn scatter<T: Send>(
        &self,
        voxels: &[f64],
        faces: &WallValues,
        out: &mut [T],
        put: impl Fn(&mut T, f64) + Sync,
    ) {
        for (face, zones) in faces.iter().flatten().zip(self.enclosure.faces.iter().flatten()) {
            for (i, unknown) in self.wall_unknowns(zones) {
                put(&mut out[unknown], face[i]);
            }
        }
        for (p, voxels) in voxels.chunks(self.layout.voxels.max(1)).enumerate() {
            let out = &mut out[self.voxel_offset(p)..][..voxels.len()];
            parallel::for_each_pair(out, voxels, |o, x| put(o, *x));
        }
    }

    /// A buffer for the values of the voxels of this rank by component and cell, with any content.
    fn take_values(&self) -> Vec<f64> {
        let mut values = self.values.take();
        parallel::set_length(&mut values, self.part.order.voxel_components() * self.part.own_voxels());
        values
    }

    /// Frees the buffers of products; the next product allocates them again.
    fn free_buffers(&self) {
        self.values.clear();
        self.convolution.free_buffers();
    }

    /// Copies the values of the voxels of this rank by component and cell.
    fn copy_voxels(&self, own: &mut [f64], at: impl Fn(usize) -> f64 + Sync) {
        let voxels = self.own_voxels();
        parallel::chunks(own, voxels.len().max(1), |p, own| {
            let first = self.voxel_offset(p) + voxels.start;
            parallel::chunks(own, COPIES_OF_TASK, |k, own| {
                own.iter_mut().zip(first + k * COPIES_OF_TASK..).for_each(|(x, i)| *x = at(i));
            });
        });
    }

    /// True if `holds` for the entries of all processes.
    fn all(&self, s: &[Bands], holds: impl Fn(&Bands) -> bool + Sync) -> bool {
        self.layout.sums.over_processes(parallel::all(s, &holds), |a, b| a && b)
    }

    /// Replaces strengths by their product without scaling, band by band.
    fn replace_unscaled(&self, s: &mut [Bands]) {
        assert_eq!(s.len(), self.len(), "one strength for each unknown");
        let mut products: Vec<Vec<Band>> = Vec::new();
        let mut done = PerBand::splat(false);
        for b in Band::all() {
            if done[b] {
                continue;
            }
            // Bands with equal extinctions and strengths share a product.
            let same = |c: &Band| {
                *c == b
                    || (self.group[*c] == self.group[b] && self.all(s, |x| x[*c].to_bits() == x[b].to_bits()))
            };
            let of: Vec<Band> = Band::all().filter(|c| *c >= b && !done[*c]).filter(same).collect();
            of.iter().for_each(|&c| done[c] = true);
            // Bands without light, such as those that fill up the last block, need no product.
            if self.all(s, |x| x[b] == 0.0) {
                parallel::for_each(s, |_, x| of.iter().for_each(|&b| x[b] = 0.0));
                continue;
            }
            products.push(of);
        }
        let product = |of: &Vec<Band>, s: &[Bands]| {
            let (b, mut voxels) = (of[0], self.take_values());
            self.copy_voxels(&mut voxels, |i| s[i][b]);
            let walls = self.convolution.exchange(self.group[b], &mut voxels, &self.wall_values(|i| s[i][b]));
            (voxels, walls)
        };
        let scatter = |of: &Vec<Band>, (voxels, walls): (Vec<f64>, WallValues), s: &mut [Bands]| {
            self.scatter(&self.all_voxels(&voxels), &walls, s, |o, x| of.iter().for_each(|&b| o[b] = x));
            self.values.give(voxels);
        };
        if memory::runs_bands_together(self.grid(), self.part.slabs.ranks()) {
            let made = parallel::collect_tasks(products.len(), |k| product(&products[k], s));
            products.iter().zip(made).for_each(|(of, made)| scatter(of, made, s));
        } else {
            for of in &products {
                let made = product(of, s);
                scatter(of, made, s);
            }
        }
    }

    /// Replaces strengths of all unknowns by their product.
    fn replace(&self, s: &mut [Bands]) {
        let scale = |s: &mut [Bands]| {
            if let Some(d) = &self.scaling {
                parallel::for_each_pair(s, d, |s, d| *s *= d);
            }
        };
        scale(s);
        self.replace_unscaled(s);
        scale(s);
    }

    /// Error of the incident power, in the memory of `out`: the radii of the factors, and the rounding of the transforms.
    fn incident_error(&self, arriving: &[Bands], mut out: Vec<Bands>) -> Vec<Bands> {
        // The unknowns of all processes.
        let further = (self.grid().count() - self.layout.voxels) * self.part.order.voxel_components();
        let n = (arriving.len() + further).max(1) as f64;
        let square = |x: &[Bands]| -> Bands { self.layout.sums.sum(x.len(), |i| x[i] * x[i]) };
        let rms = (square(arriving) / n).sqrt();
        let length: usize = self.grid().lengths().iter().product();
        let rounding = TRANSFORM_ROUNDING * f64::EPSILON * (length as f64).log2().max(1.0).sqrt();
        let radius = self.group.map(|g| self.tables[g].radius) + self.defect;
        out.resize(arriving.len(), Bands::ZERO);
        parallel::for_each_pair(&mut out, arriving, |e, p| *e = radius * p.abs() + rounding * rms);
        out
    }
}

impl ExchangeOperator for SpectralOperator<'_> {
    fn len(&self) -> usize {
        self.layout.patches * self.part.order.patch_components()
            + self.layout.voxels * self.part.order.voxel_components()
    }
    fn apply(&self, s: &[Bands]) -> Vec<Bands> {
        if s.len() < self.len() {
            let mut all = Vec::with_capacity(self.len());
            all.extend_from_slice(s);
            all.resize(self.len(), Bands::ZERO);
            self.replace(&mut all);
            all.truncate(s.len());
            return all;
        }
        let mut out = s.to_vec();
        self.replace(&mut out);
        out
    }
    fn replace_many(&self, columns: &mut Vec<Vec<Bands>>) {
        columns.iter_mut().for_each(|s| self.replace(s));
    }
    fn has_identical_bands(&self) -> bool {
        self.tables.len() == 1 && self.scaling.is_none()
    }
    fn apply_band(&self, s: &[[f64; 1]]) -> Vec<[f64; 1]> {
        let mut out = s.to_vec();
        self.replace_band(&mut out);
        out
    }
    fn replace_band(&self, s: &mut Vec<[f64; 1]>) {
        let faces = self.wall_values(|i| s[i][0]);
        // The constants alone are stored in the order of the transforms and need no copies.
        match self.part.order {
            BasisOrder::Constant if self.has_own_voxels() => {
                let walls =
                    self.convolution.exchange(0, &mut s.as_flattened_mut()[self.layout.patches..], &faces);
                self.scatter(&[], &walls, s, |o, x| o[0] = x);
            }
            _ => {
                let mut voxels = self.take_values();
                self.copy_voxels(&mut voxels, |i| s[i][0]);
                let walls = self.convolution.exchange(0, &mut voxels, &faces);
                self.scatter(&self.all_voxels(&voxels), &walls, s, |o, x| o[0] = x);
                self.values.give(voxels);
            }
        }
    }
    fn slope_zones(&self) -> Vec<u32> {
        let patches = (1..self.part.order.patch_components()).flat_map(|_| 0..self.layout.patches);
        let voxels = (1..self.part.order.voxel_components()).flat_map(|_| self.layout.patches..self.zones());
        patches.chain(voxels).map(|i| i as u32).collect()
    }
    fn scale(&mut self, d: &[Bands]) {
        let mut d = d.to_vec();
        extend_to_slopes(&mut d, &self.slope_zones());
        self.scaling = Some(times_scaling(&self.scaling, &d));
    }
}

impl ErrorModel for SpectralOperator<'_> {
    fn error(&self, strengths: &[Bands]) -> Option<Vec<Bands>> {
        Some(self.incident_error(&self.apply(strengths), Vec::new()))
    }
    fn incident_power(&self, columns: &[Vec<Bands>]) -> IncidentPower {
        let found = self.incident_power_in_place(columns.to_vec(), Vec::new());
        found.unwrap_or_else(|columns| IncidentPower { columns, ..IncidentPower::default() })
    }
    fn incident_power_in_place(
        &self,
        columns: Vec<Vec<Bands>>,
        spare: Vec<Bands>,
    ) -> Result<IncidentPower, Vec<Vec<Bands>>> {
        let mut found = columns;
        self.replace_many(&mut found);
        let error = self.error_of_power(&found, spare).ok();
        Ok(IncidentPower { columns: found, error, column_errors: Vec::new() })
    }
    fn error_of_power(&self, incident: &[Vec<Bands>], spare: Vec<Bands>) -> Result<Vec<Bands>, Vec<Bands>> {
        // The buffers of the products would lie beside the fields of the solution.
        self.free_buffers();
        Ok(match incident {
            [one] => self.incident_error(one, spare),
            all => self.incident_error(&total(self.len(), all), spare),
        })
    }
    fn in_blocks(&self) -> Option<(ZoneBlocks, Box<dyn ExchangeOperator + '_>)> {
        let own = &self.layout;
        let planes = if own.sums.is_divided() { self.part.slabs.planes() } else { 0..self.grid().cells[0] };
        let (enclosure, blocks) = box_in_blocks::divide(&self.enclosure, planes, own.patches)?;
        // Each process has all blocks.
        let layout = VectorLayout {
            patches: blocks.patch_sizes.len(),
            voxels: enclosure.grid.count(),
            sums: SumOrder::plain(),
        };
        let execution = Execution::alone(&NoProgress);
        let part = GridPart::new(enclosure.grid, BasisOrder::Constant, execution.communicator);
        let operator = SpectralOperator::with_layout(enclosure, layout, part, self.device, execution);
        Some((blocks, Box::new(operator)))
    }
    fn grade(&self) -> Grade {
        Grade::Estimated
    }
}

#[cfg(test)]
mod tests;
