//! A second device for the spectral engine: direct sums over all pairs of zones, without transforms of the radiation. It stands in for any other device.

use crate::spectral::{apart, dice, rooms};
use zonal_reference::test_cases::sampled_cases;
use zonal_scene::{Band, NoProgress, Scene, ZoneBasis};
use zonal_solve::device::basis::{BasisOrder, patch_axis};
use zonal_solve::device::grid::{BoxGrid, OTHER_AXES};
use zonal_solve::device::slabs::Slabs;
use zonal_solve::device::spectra::{GridSpectra, KernelSet, KernelSpectrum, KernelTerm, SpectrumHalf};
use zonal_solve::device::{Device, GridConvolution, GridPart, WallValues};
use zonal_solve::distribution::Execution;
use zonal_solve::engines::spectral::SpectralOperator;
use zonal_solve::engines::spectral::cpu::Processor;
use zonal_solve::engines::spectral::enclosure::BoxEnclosure;
use zonal_solve::{ExchangeOperator, SolveSettings, solve_zones};
use zonal_transport::{Transport, build_zones};

/// The device.
struct DirectSums;

impl Device for DirectSums {
    fn convolution<'a>(&self, part: GridPart<'a>) -> Box<dyn GridConvolution + 'a> {
        let is_alone = |slabs: &Slabs| slabs.ranks() == 1;
        assert!(is_alone(&part.slabs), "one process");
        Box::new(DirectConvolution { unknowns: unknowns(&part), part, matrices: Vec::new() })
    }
}

/// All factors between the components of all zones, for each extinction.
struct DirectConvolution<'a> {
    part: GridPart<'a>,
    unknowns: Vec<Unknown>,
    matrices: Vec<Vec<f64>>,
}

impl GridConvolution for DirectConvolution<'_> {
    fn load(&mut self, spectra: GridSpectra) {
        let tables = Tables::new(&self.part.grid, &spectra);
        let rows = self.unknowns.iter().flat_map(|t| self.unknowns.iter().map(|s| tables.factor(t, s)));
        self.matrices.push(rows.collect());
    }
    fn exchange(&self, extinction: usize, voxels: &mut [f64], walls: &WallValues) -> WallValues {
        assert_eq!(voxels.len(), self.part.order.voxel_components() * self.part.own_voxels());
        let sent: Vec<f64> = voxels.iter().chain(walls.iter().flatten().flatten()).copied().collect();
        let rows = self.matrices[extinction].chunks(sent.len());
        let mut met = rows.map(|row| row.iter().zip(&sent).map(|(g, s)| g * s).sum());
        voxels.iter_mut().zip(&mut met).for_each(|(x, y)| *x = y);
        let mut out = self.part.zero_walls();
        out.iter_mut().flatten().flatten().zip(met).for_each(|(x, y)| *x = y);
        out
    }
    fn free_buffers(&self) {}
}

/// A component of a zone.
struct Unknown {
    /// Axis and side of a wall; `None` for a voxel.
    wall: Option<(usize, usize)>,
    component: usize,
    /// The axis of a slope.
    slope: Option<usize>,
    /// Cell along each axis; 0 across a wall.
    at: [usize; 3],
}

/// All unknowns in the order of the arguments of [`GridConvolution::exchange`].
fn unknowns(part: &GridPart) -> Vec<Unknown> {
    let (n, mut out) = (part.grid.cells, Vec::new());
    for component in 0..part.order.voxel_components() {
        let slope = component.checked_sub(1);
        let cells = (0..n[0] * n[1] * n[2]).map(|i| [i / (n[1] * n[2]), i / n[2] % n[1], i % n[2]]);
        out.extend(cells.map(|at| Unknown { wall: None, component, slope, at }));
    }
    for (a, side) in part.grid.walled().flat_map(|a| [(a, 0), (a, 1)]) {
        let [b, c] = OTHER_AXES[a];
        for component in 0..part.order.patch_components() {
            let slope = patch_axis(a, component);
            out.extend((0..n[b] * n[c]).map(|i| {
                let mut at = [0; 3];
                (at[b], at[c]) = (i / n[c], i % n[c]);
                Unknown { wall: Some((a, side)), component, slope, at }
            }));
        }
    }
    out
}

/// The kernels in space.
struct Tables<'a> {
    grid: &'a BoxGrid,
    spectra: &'a GridSpectra,
    volume: Vec<Table>,
    walls: [Vec<Table>; 3],
    opposite: [Vec<Table>; 3],
    adjacent: [Vec<Table>; 3],
}

impl<'a> Tables<'a> {
    fn new(grid: &'a BoxGrid, spectra: &'a GridSpectra) -> Tables<'a> {
        let list = |set: &KernelSet, order: &[usize], transformed: [bool; 3]| -> Vec<Table> {
            set.arrays.iter().map(|array| Table::new(grid, array, order, transformed)).collect()
        };
        let but = |a: usize| [0, 1, 2].map(|k| k != a);
        let all = [true; 3];
        let [s0, s1, s2] = &spectra.walls;
        Tables {
            volume: list(&spectra.volume, &[1, 2, 0], all),
            walls: [list(s0, &[1, 2, 0], but(0)), list(s1, &[1, 2, 0], all), list(s2, &[1, 2, 0], all)],
            opposite: [0, 1, 2]
                .map(|a| list(&spectra.opposite[a], &[OTHER_AXES[a][1], OTHER_AXES[a][0]], but(a))),
            adjacent: [[0, 1], [0, 2], [1, 2]].map(|[a, b]| {
                let c = 3 - a - b;
                list(&spectra.adjacent[a + b - 1], &[c, a, b], [0, 1, 2].map(|k| k == c))
            }),
            grid,
            spectra,
        }
    }

    /// The factor between a component of a target and one of a source.
    fn factor(&self, target: &Unknown, source: &Unknown) -> f64 {
        let (set, tables, [p, q]) = match (target.wall, source.wall) {
            (None, None) => (&self.spectra.volume, &self.volume, [target, source]),
            (None, Some((a, _))) => (&self.spectra.walls[a], &self.walls[a], [target, source]),
            (Some((a, _)), None) => (&self.spectra.walls[a], &self.walls[a], [source, target]),
            (Some(t), Some(s)) if t == s => return 0.0,
            (Some((a, _)), Some((b, _))) if a == b => {
                (&self.spectra.opposite[a], &self.opposite[a], [target, source])
            }
            (Some((a, _)), Some((b, _))) => {
                let (i, pair) = (a + b - 1, if a < b { [target, source] } else { [source, target] });
                (&*self.spectra.adjacent[i], &self.adjacent[i], pair)
            }
        };
        let has = |u: &Unknown, k: usize| u.wall.is_some_and(|(a, _)| a == k);
        let (mut index, mut sign, mut turns) = ([0; 3], 1.0, 0);
        for k in 0..3 {
            let (n, length) = (self.grid.cells[k], self.grid.lengths()[k]);
            match (has(target, k), has(source, k)) {
                (true, true) => {}
                (false, false) => {
                    index[k] = (length + target.at[k] - source.at[k]) % length;
                    // A quarter turn for each slope along a transformed axis.
                    turns += usize::from(source.slope == Some(k)) + 3 * usize::from(target.slope == Some(k));
                }
                (is_target, _) => {
                    let (wall, other) = if is_target { (target, source) } else { (source, target) };
                    let is_high = wall.wall.is_some_and(|(_, side)| side == 1);
                    index[k] = if is_high { n - 1 - other.at[k] } else { other.at[k] };
                    sign *= if is_high && other.slope == Some(k) { -1.0 } else { 1.0 };
                }
            }
        }
        let is_own = |t: &&KernelTerm| (t.p, t.q) == (p.component, q.component);
        let table = &tables[set.terms.iter().find(is_own).map_or(0, |t| t.array)];
        turns += table.odd.iter().filter(|odd| **odd).count();
        assert!(turns % 2 == 0, "a real factor");
        sign * if turns % 4 == 2 { -1.0 } else { 1.0 } * table.get(index)
    }
}

/// A kernel by offset, period N, or distance, along each axis.
struct Table {
    odd: [bool; 3],
    sizes: [usize; 3],
    values: Vec<f64>,
}

impl Table {
    /// From a spectrum with the axes in `order`, which is transformed along some of them.
    fn new(grid: &BoxGrid, array: &KernelSpectrum, order: &[usize], transformed: [bool; 3]) -> Table {
        let (lengths, halves, cells) = (grid.lengths(), grid.halves(), grid.cells);
        let size = |k: usize| match transformed[k] {
            _ if !order.contains(&k) => 1,
            true => lengths[k],
            false => cells[k],
        };
        let sizes = [0, 1, 2].map(size);
        let stored = |at: [usize; 3]| {
            let (mut index, mut sign) = (0, 1.0);
            for &k in order {
                let (f, n) = (at[k], lengths[k]);
                if transformed[k] {
                    index = index * halves[k] + f.min(n - f);
                    sign *= array.sign(k, SpectrumHalf::of(f, n));
                } else {
                    index = index * cells[k] + f;
                }
            }
            sign * array.data[index]
        };
        let values = all(sizes).map(stored).collect();
        let mut out = Table { odd: array.odd, sizes, values };
        (0..3).filter(|&k| transformed[k] && order.contains(&k)).for_each(|k| out.transform(k));
        out
    }

    fn get(&self, at: [usize; 3]) -> f64 {
        self.values[(at[0] * self.sizes[1] + at[1]) * self.sizes[2] + at[2]]
    }

    /// The inverse transform along an axis, term by term.
    fn transform(&mut self, k: usize) {
        let n = self.sizes[k];
        let one = |d: [usize; 3]| {
            let term = |f: usize| {
                let mut at = d;
                at[k] = f;
                let angle = std::f64::consts::TAU * ((f * d[k]) % n) as f64 / n as f64;
                self.get(at) * if self.odd[k] { angle.sin() } else { angle.cos() }
            };
            (0..n).map(term).sum()
        };
        self.values = all(self.sizes).map(one).collect();
    }
}

/// All indices below `sizes`, the last one fastest.
fn all(sizes: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    let [_, n1, n2] = sizes;
    (0..sizes.iter().product()).map(move |i| [i / (n1 * n2), i / n2 % n1, i % n2])
}

// Guards (numbers): another device of the spectral engine gives the products of the processor to 1e-13.
#[test]
fn products_of_another_device_agree_to_rounding() {
    for (room, order) in rooms().iter().flat_map(|r| [(r, BasisOrder::Constant), (r, BasisOrder::Linear)]) {
        let scene = room.scene();
        let zones = build_zones(&scene, &Transport::new(&scene)).unwrap();
        let product = |device: &dyn Device| {
            let found = BoxEnclosure::find(&scene, &zones).unwrap();
            let s = SpectralOperator::new(found, &zones, order, device, Execution::alone(&NoProgress));
            s.apply(&dice(s.len(), 5))
        };
        let (processor, other) = (product(&Processor), product(&DirectSums));
        for b in Band::all() {
            let largest = processor.iter().fold(0.0f64, |m, x| m.max(x[b].abs()));
            let off = processor.iter().zip(&other).fold(0.0f64, |m, (x, y)| m.max((x[b] - y[b]).abs()));
            assert!(off <= 1e-13 * largest, "{:?} {order:?}: {off:e} of {largest:e}", room.periodic);
        }
    }
}

// Guards (numbers): another device of the spectral engine gives the solutions of the processor to 1e-11.
#[test]
fn solutions_by_another_device_agree_to_rounding() {
    let both = |room| [(room, ZoneBasis::Constant), (room, ZoneBasis::Linear)];
    for (room, basis) in sampled_cases(rooms().iter().flat_map(both), &[0, 3]) {
        let mut parts = room.parts();
        parts.options.zone_basis = basis;
        let scene = Scene::new(parts).unwrap();
        let transport = Transport::new(&scene);
        let zones = build_zones(&scene, &transport).unwrap();
        let settings = SolveSettings::new(4 << 30, &NoProgress);
        let solved = |device| solve_zones(&scene, &zones, &transport, &SolveSettings { device, ..settings });
        let ((processor, _, report), (other, ..)) =
            (solved(None).unwrap(), solved(Some(&DirectSums as &dyn Device)).unwrap());
        let off = apart(&other, &processor);
        assert!(off < 1e-11, "{:?} {basis:?}: {off:e}", room.periodic);
        assert_eq!(report.engine, "spectral");
    }
}
