use super::offset_index::OffsetIndex;
use super::*;
use crate::Factor;
use crate::aligned::{Cuboid, method_selection, reduced_pair};
use zonal_math::{Bounded, Vec3, vec3};

/// By another path: the reduced integral in cells.
fn reference_by_cells(a: &Cuboid, b: &Cuboid, kappa: f64) -> Bounded {
    reduced_pair::reduce(a, b)
        .map_or(Factor::NOT_VISIBLE, |p| method_selection::factor_by_cells(&p, kappa, 1e-13))
        .bounded
}

fn agree(f: Bounded, want: Bounded, tolerance: f64, what: &str) {
    assert!(f.radius <= tolerance * f.value, "{what}: {f:?}");
    assert!((f.value - want.value).abs() <= f.radius + want.radius, "{what}: {f:?} {want:?}");
}

/// The cell at an index, its lower corner at index · edges.
fn cell(edges: [f64; 3], index: [i64; 3]) -> Cuboid {
    let at = |d: i64| Vec3::from_array(std::array::from_fn(|k| (index[k] + d) as f64 * edges[k]));
    Cuboid::voxel(at(0), at(1))
}

#[test]
fn numbers_of_distinct_offsets() {
    assert_eq!(OffsetIndex::of_edges([1.0; 3], [115; 3]).len(), 260_130);
    assert_eq!(OffsetIndex::of_edges([1.0, 1.0, 2.0], [10, 10, 4]).len(), 55 * 4);
    assert_eq!(OffsetIndex::of_edges([1.0, 3.0, 2.0], [10, 9, 4]).len(), 360);
    assert_eq!(OffsetIndex::with_odd_axis(2, [1.0; 2], [115; 3]).len(), 6670 * 115);
}

#[test]
fn offset_positions_are_unique_and_symmetric() {
    let cases = [
        OffsetIndex::of_edges([1.0; 3], [7, 3, 5]),
        OffsetIndex::of_edges([1.0, 2.0, 1.0], [4, 5, 6]),
        OffsetIndex::of_edges([1.0, 2.0, 3.0], [4, 5, 6]),
        OffsetIndex::with_odd_axis(1, [1.0; 2], [6, 4, 3]),
    ];
    for index in cases {
        for (i, o) in index.offsets(0..index.len()).into_iter().enumerate() {
            assert_eq!(index.offsets(i..i + 1), [o]);
            let o = o.map(|x| x as i64);
            assert_eq!(index.place(o), i);
            assert_eq!(index.place(o.map(|x| -x)), i);
        }
    }
    // Counts differ: the sorted triple lies inside although its order does not.
    let index = OffsetIndex::of_edges([1.0; 3], [7, 3, 5]);
    assert_eq!(index.place([0, 2, 4]), index.place([4, 0, 2]));
}

#[test]
fn voxel_tables_agree_with_cell_integration() {
    for (edges, counts) in
        [([0.7; 3], [9, 8, 7]), ([1.0, 1.0, 0.4], [6, 6, 9]), ([2.0, 0.1, 0.5], [5, 30, 8])]
    {
        for (kappa, tolerance) in [(0.0, 1e-10), (0.0, 1e-3), (0.15, 1e-10), (2.5, 1e-8)] {
            let table = GridTables::new(edges, counts, kappa, tolerance).voxels();
            assert_eq!(table.method_counts().total(), table.len());
            let offsets = table.index.offsets(0..table.len());
            for o in offsets.iter().step_by(offsets.len() / 40).chain(&offsets[..12]) {
                let o = o.map(|x| x as i64);
                let want = reference_by_cells(&cell(edges, [0; 3]), &cell(edges, o), kappa);
                agree(table.get(o), want, tolerance, &format!("{edges:?} {o:?} {kappa} {tolerance}"));
            }
        }
    }
}

#[test]
fn moment_series_serves_most_entries() {
    let table = GridTables::new([1.0; 3], [30; 3], 0.0, 1e-10).voxels();
    assert!(table.method_counts().moments + 40 > table.len(), "{:?}", table.method_counts());
    let far = table.get([29, 28, 27]);
    assert!(far.radius > 0.0 && far.radius < 1e-10 * far.value);
}

#[test]
fn wall_tables_agree_with_cell_integration() {
    let (edges, counts) = ([0.5, 0.5, 0.3], [6, 5, 9]);
    for (kappa, tolerance) in [(0.0, 1e-10), (0.2, 1e-9), (0.0, 1e-3)] {
        for axis in 0..3 {
            let floor = cell(edges, [0; 3]).walls()[2 * axis];
            let voxels = GridTables::new(edges, counts, kappa, tolerance).wall(axis);
            let opposite = GridTables::new(edges, counts, kappa, tolerance).opposite(axis);
            for o in [[0, 0, 0], [1, 0, 0], [0, 3, 1], [2, 2, 2], [5, 4, 8], [-3, -2, 4], [4, 0, 7]] {
                let mut o: [i64; 3] = o;
                o[axis] = o[axis].abs();
                let want = reference_by_cells(&floor, &cell(edges, o), kappa);
                agree(voxels.get(o), want, tolerance, &format!("voxel {axis} {o:?} {kappa}"));
                o[axis] = counts[axis] as i64 - 1;
                let want = reference_by_cells(&floor, &cell(edges, o).walls()[2 * axis + 1], kappa);
                o[axis] = 0;
                agree(opposite.get(o), want, tolerance, &format!("opposite {axis} {o:?} {kappa}"));
            }
        }
        for axes in [[0, 1], [2, 1], [0, 2]] {
            let table = GridTables::new(edges, counts, kappa, tolerance).adjacent(axes);
            for o in [[0, 0, 0], [1, 0, 0], [0, 3, 1], [2, 2, 2], [5, 4, 8], [3, 0, 8]] {
                // A patch of the first wall at `o` along the second's axis, and the other way round.
                let (mut first, mut second): ([i64; 3], [i64; 3]) = ([0; 3], o);
                (first[axes[1]], second[axes[1]]) = (o[axes[1]], 0);
                let (a, b) =
                    (cell(edges, first).walls()[2 * axes[0]], cell(edges, second).walls()[2 * axes[1]]);
                agree(
                    table.get(o),
                    reference_by_cells(&a, &b, kappa),
                    tolerance,
                    &format!("adjacent {axes:?} {o:?} {kappa}"),
                );
            }
        }
    }
}

#[test]
fn voxel_block_agrees_with_single_pairs() {
    for (edges, first, counts) in [
        ([1.0; 3], [3.0, -2.5, -2.5], [4, 6, 6]),
        ([1.0; 3], [3.0, 0.0, 0.0], [6, 6, 6]),
        ([1.0; 3], [-1.0, -3.0, 0.0], [3, 5, 4]),
        ([0.5, 0.7, 0.7], [3.0, -2.0, -1.5], [3, 4, 4]),
    ] {
        for (kappa, tolerance) in [(0.0, 1e-6), (0.0, 1e-9), (0.3, 1e-9)] {
            let block = voxel_block(edges, first, counts, kappa, tolerance);
            assert_eq!(block.method_counts.total(), block.distinct);
            assert!(
                block.values.len() == counts.iter().product::<usize>()
                    && block.distinct <= block.values.len()
            );
            for i in (0..block.values.len()).step_by(5) {
                let (x, y, z) = (i / (counts[1] * counts[2]), i / counts[2] % counts[1], i % counts[2]);
                let at: [f64; 3] = std::array::from_fn(|k| (first[k] + [x, y, z][k] as f64) * edges[k]);
                let (o, e) = (Vec3::from_array(at), Vec3::from_array(edges));
                let want = reference_by_cells(&Cuboid::voxel(Vec3::ZERO, e), &Cuboid::voxel(o, o + e), kappa);
                let f = Bounded::proved(block.values[i], block.radii[i]);
                // The corners o + e of the reference are rounded.
                let want = Bounded::proved(want.value, want.radius + 1e-15 * want.value);
                agree(f, want, tolerance, &format!("{edges:?} {first:?} {i} {kappa} {tolerance}"));
            }
        }
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| GridTables::new([1.0, 1.0, 0.5], [40, 30, 30], 0.05, 1e-8).voxels())
    };
    let (one, three) = (run(1), run(3));
    assert!(one.values == three.values && one.radii == three.radii && one.counts == three.counts);
}

#[test]
#[should_panic(expected = "outside of the table")]
fn offset_outside_table_panics() {
    GridTables::new([1.0; 3], [4, 4, 2], 0.0, 1e-3).voxels().get([2, 2, 3]);
}

#[test]
fn single_pairs_hold_by_every_method() {
    use crate::Method;
    // Extreme aspect ratios and offsets: moments, closed forms and densities against the cells.
    let mut met = std::collections::BTreeMap::new();
    for i in 0..400u32 {
        let u = |k: u32| {
            let x = (i * 31 + k * 101 + 7).wrapping_mul(2_654_435_761);
            (x ^ (x >> 15)).wrapping_mul(2_246_822_519) as f64 / u32::MAX as f64
        };
        let size = |k: u32| 10f64.powf(-2.0 * u(k));
        let (ea, eb) = (vec3(size(0), size(1), size(2)), vec3(size(3), size(4), size(5)));
        let eb = if i % 3 == 0 { ea } else { eb };
        let shift = vec3(u(6), u(7), u(8)) * (4.0 * u(9));
        let shift = if i % 5 == 0 { vec3(ea.x, 0.0, shift.z) } else { shift };
        let (a, b) = (Cuboid::voxel(Vec3::ZERO, ea), Cuboid::voxel(shift, shift + eb));
        let (a, b) = match i % 4 {
            0 => (a, b),
            1 => (a.walls()[5 - (i / 4 % 3 * 2) as usize], b),
            _ => (a.walls()[(i / 4 % 6) as usize], b.walls()[(i / 24 % 6) as usize]),
        };
        let kappa = if i % 7 < 5 { 0.0 } else { 3.0 * u(10) };
        let Some(pair) = reduced_pair::reduce(&a, &b) else { continue };
        let want = method_selection::factor_by_cells(&pair, kappa, 1e-13).bounded;
        for tolerance in [1e-3, 1e-6, 1e-9, 1e-12] {
            let f = method_selection::factor_of(&pair, kappa, tolerance);
            *met.entry(f.method).or_insert(0) += 1;
            agree(f.bounded, want, tolerance, &format!("{a:?} {b:?} {kappa} {tolerance} {:?}", f.method));
        }
    }
    for method in [Method::Moments, Method::ClosedForm, Method::Gauss, Method::Pyramid] {
        assert!(met.get(&method).is_some_and(|n| *n > 20), "{met:?}");
    }
}
