//! The exchange factors of a grid for one extinction, by offset, and their spectra.
//!
//! All entries come from the lattice tables of `zonal_exchange`, with attenuation inside the integrals, each to a proven relative [`TOLERANCE`]
//! (for a linear basis to an estimated [`LINEAR_TOLERANCE`], verified by closure);
//! along periodic axes they are sums over images, each to 2e-13. Their order and scale stand in [`crate::device::spectra`].
//!
//! **Cost.** One table of n³ offsets at a time beside its spectrum: 16 n³ B. Its transforms are n² real lines of N = 2n numbers along each axis,
//! 15 n³ log₂2n operations: small against the table itself, whose entries are integrals.

use super::real_symmetric_fft::{Parity, RealSymmetricFft, permute_axes};
use crate::device::GridPart;
use crate::device::basis::{BasisOrder, KernelLayout};
use crate::device::grid::{BoxGrid, OTHER_AXES};
use crate::device::slabs::Slabs;
use crate::device::spectra::{GridSpectra, KernelSet, KernelSpectrum};
use crate::distribution::part_of;
use crate::distribution::{Blocks, Communicator, Message};
use crate::settings::COMPARISON_TOLERANCE;
use std::ops::Range;
use std::sync::Arc;
use zonal_exchange::aligned::lattice::{
    AxisRelation, ChunkEvaluator, FactorTable, GridTables, LinearBasisPairs, MethodCounts, PeriodicGrid,
    TableAccuracy, TurnedTable,
};
use zonal_math::parallel;

/// Relative radius of every table entry.
pub(crate) const TOLERANCE: f64 = 1e-12;
/// Relative error of the tables of [`BasisOrder::Linear`]; the closure defect is added to it.
const LINEAR_TOLERANCE: f64 = 1e-10;

/// Relative error of the tables of [`BasisOrder::Linear`] with an accuracy.
fn linear_tolerance(accuracy: TableAccuracy) -> f64 {
    match accuracy {
        TableAccuracy::Full => LINEAR_TOLERANCE,
        TableAccuracy::Comparison => COMPARISON_TOLERANCE,
    }
}

/// The kernels of a grid for one extinction.
pub(crate) struct GridKernels {
    /// Their spectra.
    pub spectra: GridSpectra,
    /// The tables that they come from.
    pub tables: TableSummary,
}

/// Counts and accuracy of the tables of one extinction.
pub(crate) struct TableSummary {
    /// Entries of the tables by method.
    pub tally: Vec<(&'static str, MethodCounts)>,
    /// Largest relative radius of an entry.
    pub radius: f64,
}

/// Cost of the sums over images along one axis, in offsets.
const IMAGE_SUM_COST: f64 = 1000.0;

/// Expected number of offsets in the tables of a grid.
pub(crate) fn table_work(grid: &BoxGrid, kappa: f64, order: BasisOrder) -> f64 {
    let images = images(grid, kappa);
    if images.is_periodic() {
        let layouts = order.volume_layout().densities.len() as f64;
        let [all, lines] = [grid.distances().iter().product::<usize>(), grid.distances().iter().sum()];
        let tables = (1 + 2 * grid.walled().count() + grid.corners().count()) as f64;
        return tables * (layouts * all as f64 + IMAGE_SUM_COST * lines as f64);
    }
    if order == BasisOrder::Linear {
        let of = |along| LinearBasisPairs { along, ..linear(grid, kappa, &images) }.cell_count();
        let walls = grid.walled().map(|a| of(axis_relations(&[a]))).sum::<f64>();
        return of(axis_relations(&[]))
            + walls
            + grid.corners().map(|pair| of(axis_relations(&pair))).sum::<f64>();
    }
    let one = grid.distances().iter().map(|n| *n as f64).product::<f64>();
    let [x, y, z] = [0, 1, 2].map(|k| (grid.edges[k], grid.cells[k]));
    if x == y && y == z {
        // By symmetry a sixth of the offsets of voxels, and half of those of walls, which are equal for all axes.
        return one * (1.0 / 6.0 + 0.5 + 0.5);
    }
    one * (1 + grid.walled().count() + grid.corners().count()) as f64
}

fn images(grid: &BoxGrid, kappa: f64) -> PeriodicGrid {
    let period = [0, 1, 2].map(|k| grid.periodic[k].then_some(grid.cells[k]));
    PeriodicGrid::new(period, grid.edges, kappa)
}

/// Relation of two zones along each axis; as many are patches as there are normals.
fn axis_relations(normals: &[usize]) -> [AxisRelation; 3] {
    [0, 1, 2].map(|k| match normals.iter().filter(|&&a| a == k).count() {
        0 => AxisRelation::Extended,
        1 => AxisRelation::OffWall,
        _ => AxisRelation::OppositeWalls,
    })
}

fn linear<'a>(grid: &BoxGrid, kappa: f64, images: &'a PeriodicGrid) -> LinearBasisPairs<'a> {
    LinearBasisPairs {
        edges: grid.edges,
        counts: grid.distances(),
        along: [AxisRelation::Extended; 3],
        kappa,
        images,
        accuracy: TableAccuracy::Full,
    }
}

fn parity_of(is_odd: bool) -> Parity {
    if is_odd { Parity::Odd } else { Parity::Even }
}

/// True if the kernels of two pairs of adjacent walls are equal.
pub(super) fn shares_adjacent(
    grid: &BoxGrid,
    order: BasisOrder,
    pair: [usize; 2],
    other: [usize; 2],
) -> bool {
    order == BasisOrder::Constant && grid.permutation(&pair, &other).is_some()
}

/// The tables' chunks, shared by the processes.
struct SharedChunks<'a>(&'a dyn Communicator);

impl ChunkEvaluator for SharedChunks<'_> {
    fn is_alone(&self) -> bool {
        self.0.size() == 1
    }
    fn evaluate(&self, chunks: usize, chunk: &(dyn Fn(usize) -> Vec<f64> + Sync)) -> Vec<Vec<f64>> {
        Blocks::new(self.0, chunks, 1).map_unequal_lists(self.0, chunk)
    }
}

/// Computes the tables and transforms them to spectra.
struct KernelBuilder<'a> {
    slabs: Slabs<'a>,
    grid: &'a BoxGrid,
    kappa: f64,
    order: BasisOrder,
    accuracy: TableAccuracy,
    images: PeriodicGrid,
    transforms: [RealSymmetricFft; 3],
    counts: [usize; 3],
    /// Finished tables of walls, by the axes of their normals.
    wall_tables: Vec<(Vec<usize>, Arc<FactorTable>)>,
    /// The same for a linear basis.
    linear_tables: Vec<LinearBasisTables>,
    /// Tables of a small grid for a linear basis that no kernel has used, by normals.
    prepared: Vec<(Vec<usize>, Vec<Vec<f64>>)>,
    /// A buffer for the next table: each kernel needs one beside its own spectrum.
    spare: Vec<f64>,
    /// What is known of the finished tables.
    tables: TableSummary,
}

/// The tables of walls for a linear basis.
struct LinearBasisTables {
    normals: Vec<usize>,
    densities: Vec<[usize; 3]>,
    /// One for each of the densities, by offset.
    tables: Vec<Vec<f64>>,
}

/// A table for permuted axes: axis k of an offset is axis `permutation[k]` of the table.
struct PermutedTable {
    table: Arc<FactorTable>,
    permutation: [usize; 3],
}

impl PermutedTable {
    fn values(&self) -> TurnedTable<'_> {
        self.table.turned(self.permutation)
    }
}

impl GridKernels {
    /// The kernels of a grid with extinction `kappa` ≥ 0 (1/m). `spare` is a buffer, and is one of the size of a spectrum afterwards.
    pub(crate) fn new(part: &GridPart, kappa: f64, spare: &mut Vec<f64>) -> GridKernels {
        let (grid, order, slabs) = (&part.grid, part.order, part.slabs);
        let mut builder = KernelBuilder {
            slabs,
            grid,
            kappa,
            order,
            accuracy: part.accuracy,
            images: images(grid, kappa),
            transforms: grid.lengths().map(RealSymmetricFft::new),
            counts: grid.distances(),
            wall_tables: Vec::new(),
            linear_tables: Vec::new(),
            prepared: Vec::new(),
            spare: std::mem::take(spare),
            tables: TableSummary { tally: Vec::new(), radius: 0.0 },
        };
        builder.tables.radius = match order {
            BasisOrder::Linear if builder.images.is_periodic() => TOLERANCE,
            BasisOrder::Linear => linear_tolerance(part.accuracy),
            BasisOrder::Constant => 0.0,
        };
        if order == BasisOrder::Linear && slabs.ranks() == 1 && grid.count() <= MAX_VOXELS_OF_TABLES_TOGETHER
        {
            builder.prepare_tables();
        }
        let mut spectra = GridSpectra { first: slabs.stored().start, ..GridSpectra::default() };
        spectra.volume = builder.volume();
        for a in grid.walled() {
            spectra.walls[a] = builder.wall(a);
        }
        builder.wall_tables.clear();
        builder.linear_tables.clear();
        for a in grid.walled() {
            spectra.opposite[a] = builder.opposite(a);
        }
        spectra.adjacent = builder.all_adjacent();
        *spare = builder.spare;
        GridKernels { spectra, tables: builder.tables }
    }
}

impl TableSummary {
    fn note(&mut self, what: &'static str, tally: MethodCounts, radius: f64) {
        self.tally.push((what, tally));
        self.radius = self.radius.max(radius);
    }
}

/// Most voxels of a grid whose tables for a linear basis are computed at the same time: each of them has few planes.
const MAX_VOXELS_OF_TABLES_TOGETHER: usize = 1 << 15;

/// Offsets along an edge of a tile.
const TILE: usize = 8;

impl KernelBuilder<'_> {
    /// A buffer of any length with the capacity of a spectrum.
    fn buffer(&mut self) -> Vec<f64> {
        let mut out = std::mem::take(&mut self.spare);
        let least = self.grid.halves().iter().product::<usize>() / self.slabs.ranks();
        if out.capacity() < least {
            parallel::set_length(&mut out, least);
        }
        out
    }

    /// Keeps one of two buffers for the next table, and returns the other one without what it has in excess.
    fn keep_spare(&mut self, mut data: Vec<f64>, spare: Vec<f64>) -> Vec<f64> {
        if spare.capacity() > self.spare.capacity() {
            self.spare = spare;
        }
        data.shrink_to_fit();
        data
    }

    /// Values at the offsets below `counts`, of which those of the first component are `rows`.
    fn array(
        &mut self,
        [rows, m1, m2]: [Range<usize>; 3],
        value: impl Fn([i64; 3]) -> f64 + Sync,
    ) -> Vec<f64> {
        let mut out = self.buffer();
        let (first, [n0, n1, n2]) = ([rows.start, m1.start, m2.start], [rows, m1, m2].map(|r| r.len()));
        parallel::set_length(&mut out, n0 * n1 * n2);
        // Tiles with near offsets: a table folds the axes, and the values of a row lie far apart in it.
        let tile = |from: usize, all: usize| from..(from + TILE).min(all);
        parallel::chunks(&mut out, TILE * n1 * n2, |t, planes| {
            let near = t * TILE;
            for (j0, k0) in (0..n1).step_by(TILE).flat_map(|j| (0..n2).step_by(TILE).map(move |k| (j, k))) {
                for (i, plane) in planes.chunks_mut(n1 * n2).enumerate() {
                    for j in tile(j0, n1) {
                        let line = &mut plane[j * n2..][tile(k0, n2)];
                        for (x, k) in line.iter_mut().zip(k0..) {
                            let at = [near + i + first[0], j + first[1], k + first[2]];
                            *x = value(at.map(|d| d as i64));
                        }
                    }
                }
            }
        });
        out
    }

    /// The offsets of this rank: its part along the first axis.
    fn own_offsets(&self) -> [Range<usize>; 3] {
        let [m0, m1, m2] = self.counts;
        [self.slabs.own_part(m0), 0..m1, 0..m2]
    }

    /// The spectra of all kernels of a layout; across the normals' axes none is odd.
    fn linear_kernels(
        &mut self,
        what: &'static str,
        normals: &[usize],
        layout: KernelLayout,
        spectrum: impl Fn(&mut Self, Vec<f64>, [bool; 3]) -> Vec<f64>,
    ) -> KernelSet {
        let along = axis_relations(normals);
        let tables = self.tables_of_layout(what, normals, &layout);
        let one = |(data, densities): (Vec<f64>, &[usize; 3])| {
            let odd = [0, 1, 2].map(|k| along[k] == AxisRelation::Extended && densities[k] == 1);
            KernelSpectrum { odd, data: spectrum(self, data, odd) }
        };
        let arrays = tables.into_iter().zip(&layout.densities).map(one).collect();
        KernelSet { terms: layout.terms, arrays }
    }

    /// The tables of a layout; those of other walls with permuted axes if the grid is equal along these.
    fn tables_of_layout(
        &mut self,
        what: &'static str,
        normals: &[usize],
        layout: &KernelLayout,
    ) -> Vec<Vec<f64>> {
        let dims = |normals: &[usize]| {
            let along = axis_relations(normals);
            [0, 1, 2].map(|k| if along[k] == AxisRelation::OppositeWalls { 1 } else { self.counts[k] })
        };
        for LinearBasisTables { normals: made, densities, tables } in &self.linear_tables {
            let Some(turn) = self.grid.permutation(normals, made) else { continue };
            let other = |d: &[usize; 3]| {
                let mut of = [0; 3];
                (0..3).for_each(|k| of[turn[k]] = d[k]);
                densities.iter().position(|x| *x == of).unwrap_or(0)
            };
            return layout.densities.iter().map(|d| permuted(&tables[other(d)], dims(made), turn)).collect();
        }
        let known = self.prepared.iter().position(|(made, _)| made == normals);
        let tables = match known {
            Some(k) => self.prepared.swap_remove(k).1,
            None => self.new_tables(normals, layout),
        };
        let count = tables.iter().map(Vec::len).sum();
        let tally = if self.images.is_periodic() {
            MethodCounts { gaussians: count, ..MethodCounts::default() }
        } else {
            MethodCounts { gauss: count, ..MethodCounts::default() }
        };
        self.tables.tally.push((what, tally));
        // Other walls may use them; tables of voxel pairs are used once.
        if !normals.is_empty() {
            let (normals, densities) = (normals.to_vec(), layout.densities.clone());
            self.linear_tables.push(LinearBasisTables { normals, densities, tables: tables.clone() });
        }
        tables
    }

    fn new_tables(&self, normals: &[usize], layout: &KernelLayout) -> Vec<Vec<f64>> {
        let along = axis_relations(normals);
        let pairs = LinearBasisPairs {
            along,
            accuracy: self.accuracy,
            ..linear(self.grid, self.kappa, &self.images)
        };
        pairs.tables(&layout.densities, &SharedChunks(self.slabs.communicator))
    }

    /// Computes the tables of voxels and of all walls that are not equal, at the same time.
    fn prepare_tables(&mut self) {
        let (grid, order) = (self.grid, self.order);
        let walls = grid.walled().map(|a| (vec![a], order.wall_layout(a)));
        let opposite = grid.walled().map(|a| (vec![a, a], order.opposite_layout(a)));
        let adjacent = grid.corners().map(|pair| (pair.to_vec(), order.adjacent_layout(pair)));
        let mut list = vec![(Vec::new(), order.volume_layout())];
        for next in walls.chain(opposite).chain(adjacent) {
            if !list.iter().any(|(made, _)| grid.permutation(&next.0, made).is_some()) {
                list.push(next);
            }
        }
        let tables = parallel::collect_tasks(list.len(), |k| self.new_tables(&list[k].0, &list[k].1));
        self.prepared = list.into_iter().map(|(normals, _)| normals).zip(tables).collect();
    }

    /// Kernels of a constant basis.
    fn constant_kernel(&self, layout: KernelLayout, data: Vec<f64>) -> KernelSet {
        KernelSet { terms: layout.terms, arrays: vec![KernelSpectrum { odd: [false; 3], data }] }
    }

    fn volume(&mut self) -> KernelSet {
        let layout = self.order.volume_layout();
        if self.order == BasisOrder::Linear {
            return self.linear_kernels("voxel and voxel", &[], layout, |m, data, odd| {
                let data = m.own_rows(data);
                m.spectrum(data, true, odd)
            });
        }
        let (edges, chunks) = (self.grid.edges, SharedChunks(self.slabs.communicator));
        let table = if self.images.is_periodic() {
            FactorTable::repeated(self.counts, &[], &self.images, &chunks)
        } else {
            GridTables::new(edges, self.counts, self.kappa, TOLERANCE).by(&chunks).voxels()
        };
        self.tables.note("voxel and voxel", table.method_counts(), table.worst_relative_radius());
        let values = table.turned([0, 1, 2]);
        let data = self.array(self.own_offsets(), |d| values.value(d));
        drop(table);
        let data = self.spectrum(data, true, [false; 3]);
        self.constant_kernel(layout, data)
    }

    /// The table of walls across the axes `normals`, or one with permuted axes if the grid is equal along these.
    fn table(&mut self, what: &'static str, normals: &[usize]) -> PermutedTable {
        for (made, table) in &self.wall_tables {
            if let Some(turn) = self.grid.permutation(normals, made) {
                return PermutedTable { table: table.clone(), permutation: turn };
            }
        }
        let table = Arc::new(self.new_table(normals));
        self.tables.note(what, table.method_counts(), table.worst_relative_radius());
        self.wall_tables.push((normals.to_vec(), table.clone()));
        PermutedTable { table, permutation: [0, 1, 2] }
    }

    fn new_table(&self, normals: &[usize]) -> FactorTable {
        let (counts, chunks) = (self.counts, SharedChunks(self.slabs.communicator));
        let tables = GridTables::new(self.grid.edges, counts, self.kappa, TOLERANCE).by(&chunks);
        match *normals {
            _ if self.images.is_periodic() => FactorTable::repeated(counts, normals, &self.images, &chunks),
            [a] => tables.wall(a),
            [a, b] if a == b => tables.opposite(a),
            [a, b] => tables.adjacent([a, b]),
            _ => unreachable!("one wall or two"),
        }
    }

    fn wall(&mut self, a: usize) -> KernelSet {
        const WHAT: &str = "voxel and wall";
        let layout = self.order.wall_layout(a);
        if self.order == BasisOrder::Linear {
            return self.linear_kernels(WHAT, &[a], layout, |m, data, odd| {
                let data = m.own_rows(data);
                m.spectrum(data, a != 0, odd)
            });
        }
        let table = self.table(WHAT, &[a]);
        let values = table.values();
        let data = self.array(self.own_offsets(), |d| values.value(d));
        let data = self.spectrum(data, a != 0, [false; 3]);
        self.constant_kernel(layout, data)
    }

    /// The rows of this rank of a table by `[d₀][d₁][d₂]`.
    fn own_rows(&self, mut data: Vec<f64>) -> Vec<f64> {
        let ([rows, ..], row) = (self.own_offsets(), self.counts[1] * self.counts[2]);
        if rows.len() < self.counts[0] {
            data = data[rows.start * row..rows.end * row].to_vec();
        }
        data
    }

    /// `[d₀][d₁][d₂]` of the own rows to `[f₁][f₂][f₀]`, or to `[f₁][f₂][d₀]`, of the own frequencies.
    fn spectrum(&mut self, mut data: Vec<f64>, along_first: bool, odd: [bool; 3]) -> Vec<f64> {
        let ([m0, m1, m2], [_, h1, h2]) = (self.counts, self.grid.halves());
        let [n0, n1, n2] = self.grid.lengths().map(|n| 1.0 / n as f64);
        let rows = self.slabs.own_part(m0).len();
        let mut other = self.buffer();
        self.transforms[2].lines(&data, m2, parity_of(odd[2]), n2, &mut other);
        permute_axes(&other, [rows, m1, h2], [0, 2, 1], &mut data);
        self.transforms[1].lines(&data, m1, parity_of(odd[1]), n1, &mut other);
        match self.slabs.ranks() {
            1 => permute_axes(&other, [m0, h2, h1], [2, 1, 0], &mut data),
            _ => self.exchange_rows(&other, &mut data),
        }
        if !along_first {
            return self.keep_spare(data, other);
        }
        self.transforms[0].lines(&data, m0, parity_of(odd[0]), n0, &mut other);
        self.keep_spare(other, data)
    }

    /// `[d₀][f₂][f₁]` of the own rows to `[f₁][f₂][d₀]` of the own frequencies.
    fn exchange_rows(&self, data: &[f64], out: &mut Vec<f64>) {
        let ([m0, ..], [_, h1, h2], slabs) = (self.counts, self.grid.halves(), self.slabs);
        let message = |rank: usize| {
            let stored = slabs.stored_of(rank);
            let mut bytes = Vec::with_capacity(data.len() / h1.max(1) * stored.len() * 8);
            for line in data.chunks(h1) {
                line[stored.clone()].iter().for_each(|x| x.put(&mut bytes));
            }
            bytes
        };
        let received = slabs.communicator.all_to_all((0..slabs.ranks()).map(message).collect());
        let stored = slabs.stored().len();
        out.clear();
        out.resize(stored * h2 * m0, 0.0);
        for (rank, bytes) in received.iter().enumerate() {
            let rows = part_of(m0, rank, slabs.ranks());
            for (i, line) in bytes.chunks((8 * stored).max(1)).enumerate() {
                let (d0, f2) = (rows.start + i / h2, i % h2);
                line.chunks_exact(8)
                    .enumerate()
                    .for_each(|(f1, x)| out[(f1 * h2 + f2) * m0 + d0] = f64::get(x));
            }
        }
    }

    fn opposite(&mut self, a: usize) -> KernelSet {
        const WHAT: &str = "opposite walls";
        let layout = self.order.opposite_layout(a);
        if self.order == BasisOrder::Linear {
            return self
                .linear_kernels(WHAT, &[a, a], layout, |m, data, odd| m.opposite_spectrum(a, data, odd));
        }
        let table = self.table(WHAT, &[a, a]);
        let values = table.values();
        let [b, c] = OTHER_AXES[a];
        let data = self.array([0..1, 0..self.counts[b], 0..self.counts[c]], |d| {
            let mut at = [0; 3];
            (at[b], at[c]) = (d[1], d[2]);
            values.value(at)
        });
        let data = self.opposite_spectrum(a, data, [false; 3]);
        self.constant_kernel(layout, data)
    }

    /// `[d_b][d_c]` of the walls across `a` to `[f_c][f_b]`.
    fn opposite_spectrum(&mut self, a: usize, mut data: Vec<f64>, odd: [bool; 3]) -> Vec<f64> {
        let [b, c] = OTHER_AXES[a];
        let (counts, lengths) = (self.counts, self.grid.lengths());
        let scale = |k: usize| 1.0 / lengths[k] as f64;
        // Its capacity is that of a wall, and the spare buffer remains for the tables of volumes.
        let mut other = Vec::new();
        self.transforms[c].lines(&data, counts[c], parity_of(odd[c]), scale(c), &mut other);
        permute_axes(&other, [1, counts[b], self.grid.halves()[c]], [0, 2, 1], &mut data);
        self.transforms[b].lines(&data, counts[b], parity_of(odd[b]), scale(b), &mut other);
        self.keep_spare(other, data)
    }

    /// The kernels of all pairs of adjacent walls, equal ones once.
    fn all_adjacent(&mut self) -> [Arc<KernelSet>; 3] {
        let mut out: [Arc<KernelSet>; 3] = Default::default();
        let mut made: Vec<[usize; 2]> = Vec::new();
        for pair in self.grid.corners() {
            let equal = made.iter().find(|m| shares_adjacent(self.grid, self.order, pair, **m));
            out[pair[0] + pair[1] - 1] = match equal {
                Some([a, b]) => out[a + b - 1].clone(),
                None => Arc::new(self.adjacent(pair)),
            };
            made.push(pair);
        }
        out
    }

    fn adjacent(&mut self, [a, b]: [usize; 2]) -> KernelSet {
        const WHAT: &str = "adjacent walls";
        let (layout, c) = (self.order.adjacent_layout([a, b]), 3 - a - b);
        if self.order == BasisOrder::Linear {
            return self.linear_kernels(WHAT, &[a, b], layout, |m, data, odd| {
                let (rows, line) = (m.slabs.own_part(m.counts[a]), m.counts[b] * m.counts[c]);
                let turned = permuted(&data, m.counts, [a, b, c]);
                m.edge_spectrum([a, b], turned[rows.start * line..rows.end * line].to_vec(), odd)
            });
        }
        let table = self.table(WHAT, &[a, b]);
        let values = table.values();
        // The transform along the edge is of single lines: every rank has all of its frequencies, and keeps its part.
        let rows = self.slabs.own_part(self.counts[a]);
        let data = self.array([rows, 0..self.counts[b], 0..self.counts[c]], |d| {
            let mut at = [0; 3];
            (at[a], at[b], at[c]) = (d[0], d[1], d[2]);
            values.value(at)
        });
        let data = self.edge_spectrum([a, b], data, [false; 3]);
        self.constant_kernel(layout, data)
    }

    /// `[i_a][i_b][d_c]` of the own rows i_a to `[f_c][i_a][i_b]` of the own frequencies.
    fn edge_spectrum(&mut self, [a, b]: [usize; 2], mut data: Vec<f64>, odd: [bool; 3]) -> Vec<f64> {
        let c = 3 - a - b;
        let scale = 1.0 / self.grid.lengths()[c] as f64;
        let (rows, h) = (self.slabs.own_part(self.counts[a]), self.grid.halves()[c]);
        let mut other = self.buffer();
        self.transforms[c].lines(&data, self.counts[c], parity_of(odd[c]), scale, &mut other);
        permute_axes(&other, [rows.len(), self.counts[b], h], [2, 0, 1], &mut data);
        if self.slabs.ranks() > 1 {
            data = self.exchange_edge_rows([a, b], &data);
        }
        self.keep_spare(data, other)
    }

    /// `[f_c][i_a][i_b]` of the own rows i_a and all frequencies to all rows and the own frequencies.
    fn exchange_edge_rows(&self, [a, b]: [usize; 2], data: &[f64]) -> Vec<f64> {
        let (slabs, [na, nb], h) =
            (self.slabs, [self.counts[a], self.counts[b]], self.grid.halves()[3 - a - b]);
        let plane = slabs.own_part(na).len() * nb;
        let message = |rank: usize| {
            let f = part_of(h, rank, slabs.ranks());
            let mut bytes = Vec::with_capacity(8 * f.len() * plane);
            data[f.start * plane..f.end * plane].iter().for_each(|x| x.put(&mut bytes));
            bytes
        };
        let received = slabs.communicator.all_to_all((0..slabs.ranks()).map(message).collect());
        let mut out = vec![0.0; slabs.own_part(h).len() * na * nb];
        for (rank, bytes) in received.iter().enumerate() {
            let rows = part_of(na, rank, slabs.ranks());
            let planes = bytes.chunks((8 * rows.len() * nb).max(1)).enumerate();
            for (f, plane) in planes {
                let to = &mut out[(f * na + rows.start) * nb..(f * na + rows.end) * nb];
                to.iter_mut().zip(plane.chunks_exact(8)).for_each(|(o, x)| *o = f64::get(x));
            }
        }
        out
    }
}

/// The array with permuted axes ([`permute_axes`]).
fn permuted(data: &[f64], dims: [usize; 3], order: [usize; 3]) -> Vec<f64> {
    let mut out = Vec::new();
    permute_axes(data, dims, order, &mut out);
    out
}
