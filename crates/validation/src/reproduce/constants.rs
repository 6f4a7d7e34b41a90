//! Proposition 1: its constant C(u), and what taking the transmittance out of the integral costs.

use zonal_exchange::aligned::{Cuboid, FactorCache, geometric_factor};
use zonal_math::{Vec3, vec3};
use zonal_report::Failure;
use zonal_report::plot::{LOG_LOG, Plot, SeriesMark};
use zonal_report::{PageFolder, markdown, number, percent};

/// The paper's two values.
const PRINTED_CONSTANTS: [([i32; 3], f64); 2] = [([1, 0, 0], -0.100917), ([100, 0, 0], 0.005045)];

fn cube(u: [i32; 3]) -> Cuboid {
    let lo = vec3(u[0] as f64, u[1] as f64, u[2] as f64);
    Cuboid::voxel(lo, lo + Vec3::splat(1.0))
}

fn length(u: [i32; 3]) -> f64 {
    u.iter().map(|x| (x * x) as f64).sum::<f64>().sqrt()
}

/// C(u) = ⟨1/r⟩/⟨1/r²⟩ − |u|, the mean distance under the kernel less that of the centres.
fn constant(cache: &FactorCache, u: [i32; 3]) -> f64 {
    cache.get_cumulants(&cube([0; 3]), &cube(u)).mean_distance - length(u)
}

/// (exact − τ(d)𝓕)/exact for unit voxels of optical thickness `depth`.
fn error(cache: &FactorCache, u: [i32; 3], depth: f64) -> f64 {
    let (a, b) = (cube([0; 3]), cube(u));
    let exact = geometric_factor(&a, &b, depth, 1e-12).bounded.value;
    1.0 - (-depth * length(u)).exp() * cache.get(&a, &b, 0.0).value / exact
}

/// The constants and the errors of pairs; the page's section.
pub(super) fn write(folder: &PageFolder) -> Result<String, Failure> {
    let cache = FactorCache::new(1e-12);
    Ok(table_of_constants(folder, &cache)? + &errors_of_pairs(folder, &cache)?)
}

fn table_of_constants(folder: &PageFolder, cache: &FactorCache) -> Result<String, Failure> {
    let offsets = [
        [0, 0, 0],
        [1, 0, 0],
        [1, 1, 0],
        [1, 1, 1],
        [2, 0, 0],
        [2, 1, 0],
        [3, 0, 0],
        [5, 0, 0],
        [10, 0, 0],
        [30, 0, 0],
        [100, 0, 0],
    ];
    let (mut rows, mut shown) = (Vec::new(), Vec::new());
    for u in offsets {
        let c = constant(cache, u);
        let printed =
            PRINTED_CONSTANTS.iter().find(|p| p.0 == u).map(|p| format!("{:+.6}", p.1)).unwrap_or_default();
        let far = if u == [0; 3] { String::new() } else { format!("{:+.9}", -1.0 / (6.0 * length(u))) };
        let name = format!("({}, {}, {})", u[0], u[1], u[2]);
        rows.push(vec![name.clone(), format!("{c:+.12}"), far, printed.clone()]);
        shown.push(vec![name, format!("{c:+.9}"), if printed.is_empty() { "–".into() } else { printed }]);
    }
    folder.table("constants.csv", &["u", "C", "minus_1_over_6u", "printed_in_the_paper"], &rows)?;
    plot_constants(folder, cache)?;
    Ok(format!(
        "## 1. The constant of Proposition 1\n\n\
Geometry: two equal cubes of edge ℓ on a voxel grid, offset u voxels, one homogeneous medium. C(u) = ⟨1/r⟩/⟨1/r²⟩ − |u|.\n\n\
{}\n\
![C(u)](constants.svg) · [constants.csv](constants.csv)\n\n\
Both values that the paper prints are wrong. The second cannot be right in sign: 1/r² favours the near parts of the two \
voxels, so the mean distance under it is below the distance of the centres, and C(u) → −1/(6|u|). The largest modulus \
among distinct voxels is the face neighbour's, as the paper says; the voxel with itself, which the sums of the \
zonal equations include, has a C of the other sign and nearly twice the size. The paper's last step also loses a sign: the relative error \
(exact − approximation)/exact is −κℓ C(u), to first order.\n\n",
        markdown(&["u", "C(u)", "printed"], &shown)
    ))
}

/// C(u) along three directions, its asymptote and the printed values.
fn plot_constants(folder: &PageFolder, cache: &FactorCache) -> Result<(), Failure> {
    let steps: Vec<i32> = (1..=20).chain([25, 30, 40, 50, 60, 80, 100]).collect();
    let along = |d: [i32; 3]| -> Vec<(f64, f64)> {
        steps.iter().map(|k| d.map(|x| x * k)).map(|u| (length(u), -constant(cache, u))).collect()
    };
    let mut plot = Plot::new(
        "The constant of Proposition 1 against distance (unit voxels)",
        "distance of the centres |u|, voxels",
        "−C(u), voxels",
        LOG_LOG,
    );
    plot.add("along an axis", SeriesMark::LineWithPoints, 0, along([1, 0, 0]));
    plot.add("along a diagonal of a face", SeriesMark::LineWithPoints, 2, along([1, 1, 0]));
    plot.add("along a diagonal of the cube", SeriesMark::LineWithPoints, 3, along([1, 1, 1]));
    plot.add(
        "1/(6|u|)",
        SeriesMark::Dashed,
        7,
        steps.iter().map(|&k| (k as f64, 1.0 / (6.0 * k as f64))).collect(),
    );
    plot.add("|C| as printed in the paper", SeriesMark::Dots, 1, vec![(1.0, 0.100917), (100.0, 0.005045)]);
    folder.plot("constants.svg", &plot)
}

/// Numbers of voxels along an edge of the enclosure, κ = 1/L.
const DIVISIONS: [i32; 10] = [10, 20, 30, 40, 50, 60, 70, 80, 90, 100];

/// The pairs of the comparison, by offset in voxels.
const COMPARED_PAIRS: [([i32; 3], &str); 5] = [
    ([0, 0, 0], "self"),
    ([1, 0, 0], "face"),
    ([1, 1, 0], "edge"),
    ([1, 1, 1], "corner"),
    ([3, 0, 0], "three off"),
];

/// Writes the table and the plot of the errors by the number of voxels.
fn tabulate_errors(folder: &PageFolder, cache: &FactorCache) -> Result<(), Failure> {
    let (mut rows, mut plot) = (
        Vec::new(),
        Plot::new(
            "Taking the transmittance out of the integral, κ = 1/L, ℓ = L/N",
            "N, voxels along an edge of the enclosure",
            "relative error of the factor (modulus)",
            LOG_LOG,
        ),
    );
    for (k, (u, name)) in COMPARED_PAIRS.into_iter().enumerate() {
        let c = constant(cache, u);
        let (mut exact, mut first) = (Vec::new(), Vec::new());
        for n in DIVISIONS {
            let depth = 1.0 / n as f64;
            let (e, l) = (error(cache, u, depth), -depth * c);
            rows.push(vec![
                name.into(),
                n.to_string(),
                format!("{e:+.6e}"),
                format!("{l:+.6e}"),
                format!("{:+.6e}", e - l),
            ]);
            exact.push((n as f64, e.abs()));
            first.push((n as f64, l.abs()));
        }
        plot.add(name, SeriesMark::LineWithPoints, k, exact);
        plot.add("", SeriesMark::Dashed, k, first);
    }
    plot.add("one per cent", SeriesMark::Dashed, 7, vec![(10.0, 0.01), (100.0, 0.01)]);
    folder.table("pairs.csv", &["pair", "N", "error", "first_order", "rest"], &rows)?;
    folder.plot("pairs.svg", &plot)
}

fn errors_of_pairs(folder: &PageFolder, cache: &FactorCache) -> Result<String, Failure> {
    tabulate_errors(folder, cache)?;
    let at = |u, n: i32| percent(error(cache, u, 1.0 / n as f64).abs());
    let below = |u| (1..1000).find(|&n| error(cache, u, 1.0 / n as f64).abs() < 0.01).unwrap_or(1000);
    let thick: Vec<Vec<String>> = [0.03, 0.1, 0.3, 1.0, 3.0]
        .iter()
        .map(|&d| {
            let mut row = vec![number(d, 2)];
            row.extend([[0, 0, 0], [1, 0, 0], [3, 0, 0], [10, 0, 0]].map(|u| percent(error(cache, u, d))));
            row
        })
        .collect();
    Ok(format!(
        "## 2. “The error is below 1 %”\n\n\
Geometry: as above; the optical thickness of a voxel is κℓ = 1/N. Full lines: the error itself, from factors proved to \
1e-12; dashed: its first order |C|/N.\n\n\
![errors of pairs](pairs.svg) · [pairs.csv](pairs.csv)\n\n\
At N = 30, the paper's typical value, a face neighbour errs by {} and a voxel with itself by {}; at N = 10 by {} and {}. The error \
is below 1 % for distinct voxels from N = {} on, and for the self factor from N = {} on. It is a claim about thin voxels only:\n\n{}\n",
        at([1, 0, 0], 30),
        at([0, 0, 0], 30),
        at([1, 0, 0], 10),
        at([0, 0, 0], 10),
        below([1, 0, 0]),
        below([0, 0, 0]),
        markdown(&["κℓ", "self", "(1,0,0)", "(3,0,0)", "(10,0,0)"], &thick)
    ))
}
