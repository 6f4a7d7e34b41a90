//! The paper's test (section 4.2), one thread, in process: factors of one voxel with a block of voxels, 6-D Gauss against the strip series.
//!
//! `cargo run --release -p zonal-paper --example paper_test`
//!
//! Geometry: unit voxels; the block begins at x = 0. "axis": V_i in the lattice column beside the block's axis, three free voxels between. "corner":
//! the same in the block's corner column. "touching": V_i is the block's neighbour, near pairs by the exact integral. Strips: 16 × 16 of them of the length
//! given, along the line of sight (axial) or across it (transverse), and one alone with its set-up. The baseline evaluates m⁶ times a pair, tables of differences
//! shared, eight lanes, no error bound; the series chooses axis, references and orders itself and gives a proved radius for each factor. Medians of several runs.

use std::time::Instant;
use zonal_exchange::aligned::Cuboid;
use zonal_math::{Vec3, vec3};
use zonal_paper::gauss_6d;
use zonal_paper::voxel_strips::{MomentQuadrature, StripAccuracy, StripFactors, UniformGrid, formfact};

const TIMED_RUNS: usize = 9;

fn seconds<R>(mut work: impl FnMut() -> R) -> (f64, R) {
    let mut last = work();
    let mut times: Vec<f64> = (0..TIMED_RUNS)
        .map(|_| {
            let t = Instant::now();
            last = work();
            t.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    (times[TIMED_RUNS / 2], last)
}

fn unit(x: f64, y: f64, z: f64) -> Cuboid {
    Cuboid::voxel(vec3(x, y, z), vec3(x + 1.0, y + 1.0, z + 1.0))
}

/// A tolerance, and the points of the 6-D rule that is compared with it.
struct TimedComparison {
    tolerance: f64,
    m: usize,
}

/// Whether the series with six-dimensional moments is timed too.
#[derive(Clone, Copy, PartialEq)]
enum SixDimensionalMoments {
    Timed,
    Skipped,
}

impl TimedComparison {
    fn row(
        &self,
        name: &str,
        v: &Cuboid,
        dims: [usize; 3],
        corner: [f64; 3],
        moments: SixDimensionalMoments,
    ) {
        let TimedComparison { tolerance, m } = *self;
        let origin = vec3(corner[0], corner[1], corner[2]);
        let grid = UniformGrid { origin, cell: Vec3::splat(1.0), dims };
        let (base, gauss) = seconds(|| gauss_6d::grid_baseline(v, &grid, m));
        let (time, f) =
            seconds(|| formfact(v, &grid, StripAccuracy::Tolerance(tolerance), MomentQuadrature::Reduced));
        let with_six = if moments == SixDimensionalMoments::Timed {
            let (t, _) = seconds(|| {
                formfact(v, &grid, StripAccuracy::Tolerance(tolerance), MomentQuadrature::SixDimensional(m))
            });
            format!("{:.2} ms, {:.1}×", 1e3 * t, base / t)
        } else {
            String::from("–")
        };
        let off = |f: &StripFactors| {
            let one = |i: usize| (gauss[i].value / f.values[i] - 1.0).abs();
            (0..grid.len()).map(one).fold(0.0, f64::max)
        };
        let worst = (0..grid.len()).map(|i| f.radii[i] / f.values[i]).fold(0.0, f64::max);
        println!(
            "| {name} | {tolerance:e} | {:.3} ms | {:.3} ms | **{:.1}×** | {with_six} | {:.1e} | {:.1e} | {} / {} / {} / {} |",
            1e3 * base,
            1e3 * time,
            base / time,
            worst,
            off(&f),
            f.counts.series,
            f.counts.references,
            f.counts.direct,
            f.counts.exact,
        );
    }

    /// Cubic blocks in front of the voxel, beside it and around it.
    fn blocks(&self) {
        for n in [10usize, 20] {
            let half = (n / 2) as f64;
            let dims = [n; 3];
            self.row(
                &format!("{n}³, axis"),
                &unit(-4.0, half, half),
                dims,
                [0.0; 3],
                SixDimensionalMoments::Timed,
            );
            self.row(
                &format!("{n}³, corner"),
                &unit(-4.0, 0.0, 0.0),
                dims,
                [0.0; 3],
                SixDimensionalMoments::Timed,
            );
        }
        self.row("10³, touching", &unit(-1.0, 5.0, 5.0), [10; 3], [0.0; 3], SixDimensionalMoments::Skipped);
        self.row(
            "3³ around it, near",
            &unit(1.0, 1.0, 1.0),
            [3; 3],
            [0.0; 3],
            SixDimensionalMoments::Skipped,
        );
    }

    /// Bundles of strips by length and distance, and single strips.
    fn strips(&self) {
        for length in [5usize, 10, 20, 40, 80] {
            let l = length as f64;
            self.row(
                &format!("16² strips of {length}, axial"),
                &unit(-4.0, 8.0, 8.0),
                [length, 16, 16],
                [0.0; 3],
                SixDimensionalMoments::Skipped,
            );
            let corner = [0.0, -(l / 2.0).floor(), 0.0];
            self.row(
                &format!("16² strips of {length}, transverse"),
                &unit(-4.0, 0.0, 8.0),
                [16, length, 16],
                corner,
                SixDimensionalMoments::Skipped,
            );
        }
        for length in [5usize, 10, 20, 40, 80] {
            self.row(
                &format!("one strip of {length}, axial, set-up inside"),
                &unit(-4.0, 0.0, 0.0),
                [length, 1, 1],
                [0.0; 3],
                SixDimensionalMoments::Skipped,
            );
        }
        for gap in [2.0, 5.0, 10.0, 40.0] {
            self.row(
                &format!("16² strips of 20, {gap} voxels off"),
                &unit(-gap - 1.0, 8.0, 8.0),
                [20, 16, 16],
                [0.0; 3],
                SixDimensionalMoments::Skipped,
            );
        }
    }
}

fn main() {
    println!(
        "| one voxel to | tolerance | 6-D Gauss (m = 4, 5) | strip series | speed-up | series with 6-D moments | largest radius | Gauss off by | series / references / direct / exact |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for (tolerance, m) in [(1e-6, 4), (1e-9, 5)] {
        let comparison = TimedComparison { tolerance, m };
        comparison.blocks();
        comparison.strips();
    }
}
