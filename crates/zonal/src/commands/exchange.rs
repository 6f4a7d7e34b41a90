//! `zonal exchange`: the direct exchange areas of all zones of a scene, as arrays.
//!
//! The file holds, with n zones in the order of a solution (patches, voxels, panes) and m matrices (one where the bands do
//! not differ, else one a band): `exchange_areas` [m, n, n] in m², symmetric to the bit; `error_radius` [m, n, n] in m²;
//! `closure` [m, n], what a row sums to in a closed scene: A of a patch, 4κV of a volume, in m².

use super::{Context, check_output};
use crate::failure::say;
use crate::{Failure, meter::Meter};
use rayon::prelude::*;
use std::path::PathBuf;
use zonal_exchange::pair::{Counts, Exchange, Settings, strength, target};
use zonal_io::output::{self, Named};
use zonal_scene::{Progress, Zones};
use zonal_transport::{Transport, build_zones};

/// Exchange areas of a scene.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Scene file (.toml).
    pub scene: PathBuf,
    /// Arrays to write (.npz): exchange_areas, error_radius, closure.
    #[arg(long, short)]
    pub output: PathBuf,
    /// Wanted relative error of the factors of axis-aligned pairs and of two plates, between 0 and 1. What is measured by rays has the scene's tolerance.
    #[arg(long, default_value_t = 1e-9)]
    pub tolerance: f64,
    /// Largest memory for the matrices, GB.
    #[arg(long, default_value_t = 12.0)]
    pub max_memory: f64,
}

/// Bytes of memory an entry and a band: the area and its radius.
const BYTES: u64 = 16;

/// Runs the command.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    if !(args.tolerance > 0.0 && args.tolerance < 1.0) {
        return Err(Failure::new("--tolerance: give a number between 0 and 1"));
    }
    if !(args.max_memory > 0.0 && args.max_memory.is_finite()) {
        return Err(Failure::new("--max-memory: give a positive number of gigabytes"));
    }
    check_output(&args.output, &["npz"])?;
    let scene = zonal_io::input::read_scene(&args.scene)?;
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport).map_err(|e| Failure::in_file(&args.scene, e))?;
    let n = zones.len();
    let bands =
        if (0..n).all(|i| strength(&zones, i).iter().all(|c| *c == strength(&zones, i)[0])) { 1 } else { 3 };
    let bytes = BYTES * (bands * n * n) as u64;
    if bytes as f64 > args.max_memory * 1e9 {
        return Err(Failure::in_file(
            &args.scene,
            format!(
                "{n} zones need {:.3} GB for their matrices, more than the {:.3} GB allowed; use larger patches or fewer cells, or allow more (--max-memory)",
                bytes as f64 / 1e9,
                args.max_memory
            ),
        ));
    }
    let settings = Settings {
        aligned_tolerance: args.tolerance,
        plate_tolerance: args.tolerance,
        ..Settings::default()
    };
    let exchange = Exchange::with_settings(&scene, &zones, &transport, settings);
    let meter = Meter::new(context.quiet);
    let m = matrices(&exchange, &zones, bands, &meter);
    let shape = vec![bands, n, n];
    let named = |name, shape, values| Named { name, shape, values };
    output::write_arrays(
        &args.output,
        &[
            named("exchange_areas", shape.clone(), &m.areas),
            named("error_radius", shape, &m.radii),
            named("closure", vec![bands, n], &m.closure),
        ],
    )?;
    report(args, context, &m, n, bands)
}

/// The matrices of all bands, one after the other.
struct Matrices {
    areas: Vec<f64>,
    radii: Vec<f64>,
    closure: Vec<f64>,
    counts: Counts,
}

fn matrices(exchange: &Exchange, zones: &Zones, bands: usize, meter: &Meter) -> Matrices {
    let n = zones.len();
    meter.begin("exchange areas", (n * n) as u64 / 2);
    let row = |i: usize| {
        let (pairs, mut counts, ci) = (exchange.row(i), Counts::default(), strength(zones, i));
        let mut out = Vec::with_capacity((i + 1) * bands);
        for j in 0..=i {
            let (f, cj) = (exchange.pair_in(&pairs, j, &mut counts), strength(zones, j));
            out.extend((0..bands).map(|b| (f.value[b] * (ci[b] * cj[b]), f.radius[b] * (ci[b] * cj[b]))));
        }
        meter.advance(i as u64 + 1);
        (out, counts)
    };
    let rows: Vec<(Vec<(f64, f64)>, Counts)> = (0..n).into_par_iter().map(row).collect();
    meter.end();
    let mut m = Matrices {
        areas: vec![0.0; bands * n * n],
        radii: vec![0.0; bands * n * n],
        closure: (0..bands * n).map(|k| target(zones, k % n) * strength(zones, k % n)[k / n]).collect(),
        counts: Counts::default(),
    };
    for (i, (row, counts)) in rows.into_iter().enumerate() {
        m.counts.merge(counts);
        for (k, (area, radius)) in row.into_iter().enumerate() {
            let (j, b) = (k / bands, k % bands);
            for at in [(b * n + i) * n + j, (b * n + j) * n + i] {
                (m.areas[at], m.radii[at]) = (area, radius);
            }
        }
    }
    m
}

fn report(args: &Args, context: Context, m: &Matrices, n: usize, bands: usize) -> Result<(), Failure> {
    let defect = (0..bands * n).filter(|&k| m.closure[k] > 0.0).fold(0.0f64, |worst, k| {
        let sum: f64 = m.areas[k * n..(k + 1) * n].iter().sum();
        worst.max((sum / m.closure[k] - 1.0).abs())
    });
    let grade = if m.counts.all_proved() { "proved" } else { "estimated" };
    let path = args.output.display();
    if context.json {
        return say(&format!(
            "{:#}",
            serde_json::json!({
                "zones": n, "matrices": bands, "grade": grade, "largest_row_defect": defect,
                "aligned_pairs": m.counts.aligned, "general_pairs": m.counts.general, "rays": m.counts.rays,
                "written": path.to_string(),
            })
        ));
    }
    say(&format!(
        "{n} zones, {bands} matrix(es), grade {grade}; row sums are off by at most {defect:.1e} (an open scene loses what leaves it)\nwritten: {path}"
    ))
}
