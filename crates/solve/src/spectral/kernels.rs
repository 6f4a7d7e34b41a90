//! The exchange factors of a grid for one extinction, by offset, and their spectra.
//!
//! | kernel | of | kept as |
//! |---|---|---|
//! | V(d₀, d₁, d₂) | two voxels | one octant of its real, even spectrum |
//! | S₀(d₀; d₁, d₂) | a voxel d₀ cells from a wall across the first axis | spectra along the wall, one for each d₀ |
//! | S₁, S₂ | the same for walls across the other axes | one octant; extended evenly across the wall, which nothing ever reads |
//! | O(d_b, d_c) | opposite walls | one quadrant |
//! | Q(i_a, i_b; d_c) | adjacent walls across a and b | spectra along their edge, a matrix for each frequency |
//!
//! All entries come from the lattice tables of `zonal_exchange`, attenuation inside the integrals, each to a proven relative [`TOLERANCE`]
//! (those for radiosity that varies inside a zone to [`LINEAR_TOLERANCE`], estimated, and measured by closure);
//! along axes that repeat themselves they are sums over images, each to 2e-13. The scale 1/(N₀N₁N₂) of the transforms is in the spectra.
//! Of radiosity that varies there is a kernel for each pair of components (`basis.rs`), odd along some axes.

use super::basis::{Array, Layout, Set, Variation};
use super::even::{Even, turned};
use super::grid::{Grid, OTHERS};
use std::sync::Arc;
use zonal_exchange::aligned::lattice::{Along, Images, Linear, OffsetTable, Tally, WallTable};

/// Relative radius of every table entry.
pub const TOLERANCE: f64 = 1e-12;
/// Relative error of the tables of [`Variation::Linear`]; what closure misses beyond comes on top of it.
pub const LINEAR_TOLERANCE: f64 = 1e-10;

/// Spectra of all kernels of a grid.
pub struct Kernels {
    /// V by `[f₁][f₂][f₀]`.
    pub volume: Set,
    /// S₀ by `[f₁][f₂][d₀]`; S₁ and S₂ by `[f₁][f₂][f₀]`; empty across periodic axes.
    pub walls: [Set; 3],
    /// O of the walls across each axis by `[f_c][f_b]`.
    pub opposite: [Set; 3],
    /// Q by `[f_c][i_a][i_b]` for the pairs of axes (0, 1), (0, 2), (1, 2).
    pub adjacent: [Set; 3],
    /// Entries of the tables by method.
    pub tally: Vec<(&'static str, Tally)>,
    /// Largest relative radius of an entry.
    pub radius: f64,
}

/// Offsets that the sums over images along one axis take as long as.
const PROFILE: f64 = 1000.0;

/// Offsets that the tables of a grid compute, about.
pub fn work(grid: &Grid, kappa: f64, variation: Variation) -> f64 {
    let images = images(grid, kappa);
    if images.any() {
        let layouts = variation.volume().densities.len() as f64;
        let [all, lines] = [grid.distances().iter().product::<usize>(), grid.distances().iter().sum()];
        let tables = (1 + 2 * grid.walled().count() + grid.corners().count()) as f64;
        return tables * (layouts * all as f64 + PROFILE * lines as f64);
    }
    if variation == Variation::Linear {
        let of = |along| Linear { along, ..linear(grid, kappa, &images) }.work();
        let walls = grid.walled().map(|a| of(lie(&[a]))).sum::<f64>();
        return of(lie(&[])) + walls + grid.corners().map(|pair| of(lie(&pair))).sum::<f64>();
    }
    let one = grid.distances().iter().map(|n| *n as f64).product::<f64>();
    let [x, y, z] = [0, 1, 2].map(|k| (grid.edges[k], grid.cells[k]));
    if x == y && y == z {
        // A sixth of the offsets of voxels, half of those of walls, which are the same for all.
        return one * (1.0 / 6.0 + 0.5 + 0.5);
    }
    one * (1 + grid.walled().count() + grid.corners().count()) as f64
}

fn images(grid: &Grid, kappa: f64) -> Images {
    let period = [0, 1, 2].map(|k| grid.periodic[k].then_some(grid.cells[k]));
    Images::new(period, grid.edges, kappa)
}

/// How two zones lie, of which as many are patches as there are normals.
fn lie(normals: &[usize]) -> [Along; 3] {
    [0, 1, 2].map(|k| match normals.iter().filter(|&&a| a == k).count() {
        0 => Along::Between,
        1 => Along::Depth,
        _ => Along::Across,
    })
}

fn linear<'a>(grid: &Grid, kappa: f64, images: &'a Images) -> Linear<'a> {
    Linear { edges: grid.edges, counts: grid.distances(), along: [Along::Between; 3], kappa, images }
}

/// Everything between tables and spectra.
struct Maker<'a> {
    grid: &'a Grid,
    kappa: f64,
    variation: Variation,
    images: Images,
    even: [Even; 3],
    counts: [usize; 3],
    /// Tables of walls that are made, by the axes of their normals.
    made: Vec<(Vec<usize>, Arc<WallTable>)>,
    /// The same of zones with slopes.
    sloped: Vec<Sloped>,
}

/// The tables of walls of zones with slopes.
struct Sloped {
    normals: Vec<usize>,
    densities: Vec<[usize; 3]>,
    /// One for each of the densities, by offset.
    tables: Vec<Vec<f64>>,
}

/// A table whose axes are those of the grid exchanged: axis k of an offset is axis `turn[k]` of the table's.
struct Turned {
    table: Arc<WallTable>,
    turn: [usize; 3],
}

impl Turned {
    fn value(&self, offset: [i64; 3]) -> f64 {
        let mut at = [0; 3];
        (0..3).for_each(|k| at[self.turn[k]] = offset[k]);
        self.table.get(at).value
    }
}

impl Kernels {
    /// The kernels of a grid with extinction `kappa` ≥ 0 (1/m).
    pub fn new(grid: &Grid, kappa: f64, variation: Variation) -> Kernels {
        let mut maker = Maker {
            grid,
            kappa,
            variation,
            images: images(grid, kappa),
            even: grid.lengths().map(Even::new),
            counts: grid.distances(),
            made: Vec::new(),
            sloped: Vec::new(),
        };
        let mut out = Kernels {
            volume: Set::default(),
            walls: Default::default(),
            opposite: Default::default(),
            adjacent: Default::default(),
            tally: Vec::new(),
            radius: match variation {
                Variation::Linear if maker.images.any() => TOLERANCE,
                Variation::Linear => LINEAR_TOLERANCE,
                Variation::Constant => 0.0,
            },
        };
        out.volume = maker.volume(&mut out);
        for a in grid.walled() {
            out.walls[a] = maker.wall(a, &mut out);
        }
        maker.made.clear();
        maker.sloped.clear();
        for a in grid.walled() {
            out.opposite[a] = maker.opposite(a, &mut out);
        }
        for pair in grid.corners() {
            out.adjacent[pair[0] + pair[1] - 1] = maker.adjacent(pair, &mut out);
        }
        out
    }

    fn note(&mut self, what: &'static str, tally: Tally, radius: f64) {
        self.tally.push((what, tally));
        self.radius = self.radius.max(radius);
    }
}

impl Maker<'_> {
    /// The offsets below `counts`, with their values.
    fn array(&self, counts: [usize; 3], value: impl Fn([i64; 3]) -> f64 + Sync) -> Vec<f64> {
        use rayon::prelude::*;
        let [_, m1, m2] = counts;
        let mut out = vec![0.0; counts.iter().product()];
        out.par_chunks_mut(m1 * m2).enumerate().for_each(|(i, plane)| {
            for (jk, x) in plane.iter_mut().enumerate() {
                *x = value([i, jk / m2, jk % m2].map(|d| d as i64));
            }
        });
        out
    }

    /// The tables of a layout by offset, each made a spectrum: across the normals' axes nothing is odd.
    fn set(
        &mut self,
        what: &'static str,
        normals: &[usize],
        layout: Layout,
        out: &mut Kernels,
        spectrum: impl Fn(&Self, Vec<f64>, [bool; 3]) -> Vec<f64>,
    ) -> Set {
        let along = lie(normals);
        let tables = self.sloped(what, normals, &layout, out);
        let one = |(data, densities): (Vec<f64>, &[usize; 3])| {
            let odd = [0, 1, 2].map(|k| along[k] == Along::Between && densities[k] == 1);
            Array { odd, data: spectrum(self, data, odd) }
        };
        let arrays = tables.into_iter().zip(&layout.densities).map(one).collect();
        Set { terms: layout.terms, arrays }
    }

    /// The tables of a layout: those of other walls with axes exchanged, where the grid looks the same along these.
    fn sloped(
        &mut self,
        what: &'static str,
        normals: &[usize],
        layout: &Layout,
        out: &mut Kernels,
    ) -> Vec<Vec<f64>> {
        let dims = |normals: &[usize]| {
            let along = lie(normals);
            [0, 1, 2].map(|k| if along[k] == Along::Across { 1 } else { self.counts[k] })
        };
        for Sloped { normals: made, densities, tables } in &self.sloped {
            let Some(turn) = self.turn(normals, made) else { continue };
            let other = |d: &[usize; 3]| {
                let mut of = [0; 3];
                (0..3).for_each(|k| of[turn[k]] = d[k]);
                densities.iter().position(|x| *x == of).unwrap_or(0)
            };
            return layout.densities.iter().map(|d| turned(&tables[other(d)], dims(made), turn)).collect();
        }
        let along = lie(normals);
        let pairs = Linear { along, ..linear(self.grid, self.kappa, &self.images) };
        let tables = pairs.tables(&layout.densities);
        let count = tables.iter().map(Vec::len).sum();
        let tally = match self.images.any() {
            true => Tally { gaussians: count, ..Tally::default() },
            false => Tally { gauss: count, ..Tally::default() },
        };
        out.tally.push((what, tally));
        // Other walls may want them; voxels with voxels come once.
        if !normals.is_empty() {
            let (normals, densities) = (normals.to_vec(), layout.densities.clone());
            self.sloped.push(Sloped { normals, densities, tables: tables.clone() });
        }
        tables
    }

    /// How axes are exchanged that look the same, so that walls across `normals` are those across `made`.
    fn turn(&self, normals: &[usize], made: &[usize]) -> Option<[usize; 3]> {
        const TURNS: [[usize; 3]; 6] = [[0, 1, 2], [1, 0, 2], [2, 1, 0], [0, 2, 1], [1, 2, 0], [2, 0, 1]];
        let g = self.grid;
        let alike = |k: usize, l: usize| {
            (g.edges[k], g.cells[k], g.periodic[k]) == (g.edges[l], g.cells[l], g.periodic[l])
        };
        let fits = |turn: &[usize; 3]| {
            (0..3).all(|k| alike(k, turn[k])) && normals.iter().map(|&a| turn[a]).eq(made.iter().copied())
        };
        TURNS.into_iter().find(fits)
    }

    /// The set of a single kernel.
    fn single(&self, layout: Layout, data: Vec<f64>) -> Set {
        Set { terms: layout.terms, arrays: vec![Array { odd: [false; 3], data }] }
    }

    fn volume(&mut self, out: &mut Kernels) -> Set {
        let layout = self.variation.volume();
        if self.variation == Variation::Linear {
            return self.set("voxel and voxel", &[], layout, out, |m, data, odd| m.spectrum(data, true, odd));
        }
        let edges = self.grid.edges;
        let table = match self.images.any() {
            true => OffsetTable::repeated(self.counts, &self.images),
            false => OffsetTable::new(edges, self.counts, self.kappa, TOLERANCE),
        };
        out.note("voxel and voxel", table.tally(), table.worst());
        let data = self.array(self.counts, |d| table.get(d).value);
        drop(table);
        self.single(layout, self.spectrum(data, true, [false; 3]))
    }

    /// The table of walls across these axes: one made before where the grid looks the same along axes that are exchanged.
    fn table(&mut self, what: &'static str, normals: &[usize], out: &mut Kernels) -> Turned {
        for (made, table) in &self.made {
            if let Some(turn) = self.turn(normals, made) {
                return Turned { table: table.clone(), turn };
            }
        }
        let table = Arc::new(self.new_table(normals));
        out.note(what, table.tally(), table.worst());
        self.made.push((normals.to_vec(), table.clone()));
        Turned { table, turn: [0, 1, 2] }
    }

    fn new_table(&self, normals: &[usize]) -> WallTable {
        let (edges, counts, kappa) = (self.grid.edges, self.counts, self.kappa);
        match *normals {
            _ if self.images.any() => WallTable::repeated(counts, normals, &self.images),
            [a] => WallTable::voxels(edges, counts, a, kappa, TOLERANCE),
            [a, b] if a == b => WallTable::opposite(edges, counts, a, kappa, TOLERANCE),
            [a, b] => WallTable::adjacent(edges, counts, [a, b], kappa, TOLERANCE),
            _ => unreachable!("one wall or two"),
        }
    }

    fn wall(&mut self, a: usize, out: &mut Kernels) -> Set {
        const WHAT: &str = "voxel and wall";
        let layout = self.variation.wall(a);
        if self.variation == Variation::Linear {
            return self.set(WHAT, &[a], layout, out, |m, data, odd| m.spectrum(data, a != 0, odd));
        }
        let table = self.table(WHAT, &[a], out);
        let data = self.array(self.counts, |d| table.value(d));
        self.single(layout, self.spectrum(data, a != 0, [false; 3]))
    }

    /// `[d₀][d₁][d₂]` to `[f₁][f₂][f₀]`, or to `[f₁][f₂][d₀]`.
    fn spectrum(&self, data: Vec<f64>, along_first: bool, odd: [bool; 3]) -> Vec<f64> {
        let ([m0, m1, m2], [_, h1, h2]) = (self.counts, self.grid.halves());
        let [n0, n1, n2] = self.grid.lengths().map(|n| 1.0 / n as f64);
        let data = self.even[2].lines(&data, m2, odd[2], n2);
        let data = turned(&data, [m0, m1, h2], [0, 2, 1]);
        let data = self.even[1].lines(&data, m1, odd[1], n1);
        let data = turned(&data, [m0, h2, h1], [2, 1, 0]);
        if along_first { self.even[0].lines(&data, m0, odd[0], n0) } else { data }
    }

    fn opposite(&mut self, a: usize, out: &mut Kernels) -> Set {
        const WHAT: &str = "opposite walls";
        let layout = self.variation.opposite(a);
        if self.variation == Variation::Linear {
            return self.set(WHAT, &[a, a], layout, out, |m, data, odd| m.facing(a, data, odd));
        }
        let table = self.table(WHAT, &[a, a], out);
        let [b, c] = OTHERS[a];
        let data = self.array([1, self.counts[b], self.counts[c]], |d| {
            let mut at = [0; 3];
            (at[b], at[c]) = (d[1], d[2]);
            table.value(at)
        });
        self.single(layout, self.facing(a, data, [false; 3]))
    }

    /// `[d_b][d_c]` of the walls across `a` to `[f_c][f_b]`.
    fn facing(&self, a: usize, data: Vec<f64>, odd: [bool; 3]) -> Vec<f64> {
        let [b, c] = OTHERS[a];
        let (counts, lengths) = (self.counts, self.grid.lengths());
        let data = self.even[c].lines(&data, counts[c], odd[c], 1.0 / lengths[c] as f64);
        let data = turned(&data, [1, counts[b], self.grid.halves()[c]], [0, 2, 1]);
        self.even[b].lines(&data, counts[b], odd[b], 1.0 / lengths[b] as f64)
    }

    fn adjacent(&mut self, [a, b]: [usize; 2], out: &mut Kernels) -> Set {
        const WHAT: &str = "adjacent walls";
        let (layout, c) = (self.variation.adjacent([a, b]), 3 - a - b);
        if self.variation == Variation::Linear {
            return self.set(WHAT, &[a, b], layout, out, |m, data, odd| {
                m.edge([a, b], turned(&data, m.counts, [a, b, c]), odd)
            });
        }
        let table = self.table(WHAT, &[a, b], out);
        let data = self.array([self.counts[a], self.counts[b], self.counts[c]], |d| {
            let mut at = [0; 3];
            (at[a], at[b], at[c]) = (d[0], d[1], d[2]);
            table.value(at)
        });
        self.single(layout, self.edge([a, b], data, [false; 3]))
    }

    /// `[i_a][i_b][d_c]` to `[f_c][i_a][i_b]`.
    fn edge(&self, [a, b]: [usize; 2], data: Vec<f64>, odd: [bool; 3]) -> Vec<f64> {
        let c = 3 - a - b;
        let data = self.even[c].lines(&data, self.counts[c], odd[c], 1.0 / self.grid.lengths()[c] as f64);
        turned(&data, [self.counts[a], self.counts[b], self.grid.halves()[c]], [2, 0, 1])
    }
}
