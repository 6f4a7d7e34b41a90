//! `zonal exchange`: the direct and the total exchange areas of all zones of a scene, as arrays.
//!
//! The file holds, with n zones in the order of a solution (patches, voxels, panes) and m matrices (one where the bands do
//! not differ, else one a band), all in m² and symmetric to the bit:
//!
//! | array | shape | what |
//! |---|---|---|
//! | `exchange_areas`, `error_radius` | [m, n, n] | direct: without reflection and scattering |
//! | `closure` | [m, n] | what a row sums to in a closed scene: A of a patch, 4κV of a volume |
//! | `total_exchange_areas`, `total_error_radius` | [m, n, n] | net watts from i to j per W/m² of σT_i⁴ − σT_j⁴, with all reflections and scattering |
//! | `total_closure` | [m, n] | what a row of these sums to in a closed scene: εA, 4κ_aV |
//! | `named_exchange_areas`, `named_error_radius` | [m, k, k] | sums of the total ones over named surfaces, the medium and panes |
//! | `about` | bytes | JSON: `names`, in the order of these sums; `name_of_zone`, a number for each zone; units |

use super::{Context, check_output};
use crate::failure::say;
use crate::{Failure, meter::Meter};
use rayon::prelude::*;
use std::path::PathBuf;
use zonal_exchange::pair::{Counts, Exchange, Settings, strength, target};
use zonal_io::output::{self, Named};
use zonal_scene::{Bands, Note, Progress, Scene, Zones, printable};
use zonal_solve::engine::{self, THIN};
use zonal_solve::forecast;
use zonal_solve::total;
use zonal_transport::zoning::left_out;
use zonal_transport::{Transport, build_zones};

/// Exchange areas of a scene. Direct ones leave out reflection and scattering; total ones are net watts from zone to zone per W/m2 of σT⁴ that they differ.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Scene file (.toml).
    pub scene: PathBuf,
    /// Arrays to write (.npz): direct and total exchange areas, their error radii, what rows sum to, sums over names.
    #[arg(long, short)]
    pub output: PathBuf,
    /// Wanted relative error of the factors of axis-aligned pairs and of two plates, between 0 and 1. What is measured by rays has the scene's tolerance.
    #[arg(long, default_value_t = 1e-9)]
    pub tolerance: f64,
    /// Largest memory for the matrices, GB.
    #[arg(long, default_value_t = 12.0)]
    pub max_memory: f64,
    /// Leave out the total exchange areas, which take time with the cube of the zones.
    #[arg(long)]
    pub direct_only: bool,
}

/// Bytes of memory an entry and a band: the area and its radius.
const BYTES: u64 = 16;
/// Bytes of an entry of one band while the total areas are computed.
const WORK: u64 = 8 * (total::NUMBERS - 2);

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
    let mut notes = scene.notes().to_vec();
    notes.extend(left_out(&scene, &transport, &zones).map_err(|e| Failure::in_file(&args.scene, e))?);
    notes.extend(constant(&scene, &zones));
    engine::check_pairs(&scene, &zones).map_err(|e| Failure::in_file(&args.scene, e))?;
    let n = zones.len();
    let alike = |v: Bands| v[0] == v[1] && v[1] == v[2];
    let grey = (0..n).all(|i| alike(strength(&zones, i)));
    let reflecting = (0..n).all(|i| alike(zones.response(i).0));
    // Where the bands differ in what reflects alone, each has a matrix of its own all the same.
    let bands = if grey && (reflecting || args.direct_only) { 1 } else { 3 };
    let bytes = match args.direct_only {
        true => BYTES * (bands * n * n) as u64,
        false => (2 * BYTES * bands as u64 + WORK) * (n * n) as u64,
    };
    if bytes as f64 > args.max_memory * 1e9 {
        return Err(Failure::in_file(
            &args.scene,
            format!(
                "{n} zones need {:.3} GB for their matrices, more than the {:.3} GB allowed; use larger patches or fewer cells, or allow more (--max-memory){}",
                bytes as f64 / 1e9,
                args.max_memory,
                if args.direct_only { "" } else { ", or leave out the total ones (--direct-only)" }
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
    if !m.areas.iter().chain(&m.closure).all(|x| x.is_finite()) || m.radii.iter().any(|r| r.is_nan()) {
        let what = "an exchange area is not a finite number: lengths or extinctions are too far apart for double precision; bring them closer together";
        return Err(Failure::in_file(&args.scene, what));
    }
    let shape = vec![bands, n, n];
    let named = |name, shape, values| Named { name, shape, values };
    let mut list = vec![
        named("exchange_areas", shape.clone(), &m.areas[..]),
        named("error_radius", shape.clone(), &m.radii),
        named("closure", vec![bands, n], &m.closure),
    ];
    if args.direct_only {
        output::write_arrays(&args.output, None, &list)?;
        return report(args, context, &m, (n, bands), None, &notes);
    }
    meter.begin("total exchange areas", bands as u64);
    let names = Names::new(&scene, &zones);
    let t = totals(&m, &zones, bands, &names, &meter).ok_or_else(|| {
        let what = "nothing in a closed scene absorbs, so that total exchange areas have no end; lower a reflectance or albedo, or leave them out (--direct-only)";
        Failure::in_file(&args.scene, what)
    })?;
    meter.end();
    let k = names.list.len();
    list.extend([
        named("total_exchange_areas", shape.clone(), &t.areas[..]),
        named("total_error_radius", shape, &t.radii),
        named("total_closure", vec![bands, n], &t.closure),
        named("named_exchange_areas", vec![bands, k, k], &t.by_name),
        named("named_error_radius", vec![bands, k, k], &t.by_name_radii),
    ]);
    let about = serde_json::json!({
        "names": names.list, "name_of_zone": names.of, "unit": "m2",
        "order_of_zones": "patches, then voxel zones, then pane zones",
    });
    output::write_arrays(&args.output, Some(&about.to_string()), &list)?;
    report(args, context, &m, (n, bands), Some(&t), &notes)
}

/// The names that zones belong to: surfaces, the medium, panes.
struct Names {
    list: Vec<String>,
    of: Vec<usize>,
}

impl Names {
    fn new(scene: &Scene, zones: &Zones) -> Names {
        let mut list: Vec<String> = scene.surfaces().iter().map(|s| s.name.clone()).collect();
        let mut of: Vec<usize> = zones.patches.iter().map(|p| p.surface).collect();
        if !zones.voxels.is_empty() {
            of.extend(std::iter::repeat_n(list.len(), zones.voxels.len()));
            list.push("medium".into());
        }
        of.extend(zones.panes.iter().map(|p| list.len() + p.pane));
        list.extend(scene.panes().iter().map(|p| p.name.clone()));
        Names { list, of }
    }
}

/// Total areas of all bands, one after the other.
#[derive(Default)]
struct Totals {
    areas: Vec<f64>,
    radii: Vec<f64>,
    closure: Vec<f64>,
    by_name: Vec<f64>,
    by_name_radii: Vec<f64>,
}

/// None where nothing absorbs in some band.
fn totals(m: &Matrices, zones: &Zones, bands: usize, names: &Names, meter: &Meter) -> Option<Totals> {
    let n = zones.len();
    let room = || Vec::with_capacity(bands * n * n);
    let mut out = Totals { areas: room(), radii: room(), ..Totals::default() };
    for b in 0..bands {
        let (rows, pairs) = (b * n..(b + 1) * n, b * n * n..(b + 1) * n * n);
        // ρ of a patch; of a volume Ω/4 stands in the response.
        let reflect: Vec<f64> = (0..n)
            .map(|i| zones.response(i).0[b] * if i < zones.voxel_offset() { 1.0 } else { 4.0 })
            .collect();
        let c = &m.closure[rows];
        let t = total::total(&m.areas[pairs.clone()], &m.radii[pairs], c, &reflect)?;
        out.closure.extend(c.iter().zip(&reflect).map(|(c, r)| c * (1.0 - r)));
        out.by_name.extend(total::by_group(&t.areas, &names.of, names.list.len()));
        out.by_name_radii.extend(total::by_group(&t.radii, &names.of, names.list.len()));
        out.areas.extend(t.areas);
        out.radii.extend(t.radii);
        meter.advance(1);
    }
    Some(out)
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

/// Largest relative distance of a row's sum from what it is in a closed scene.
fn worst_row(areas: &[f64], closure: &[f64], n: usize) -> f64 {
    (0..closure.len()).filter(|&k| closure[k] > 0.0).fold(0.0f64, |worst, k| {
        let sum: f64 = areas[k * n..(k + 1) * n].iter().sum();
        worst.max((sum / closure[k] - 1.0).abs())
    })
}

/// What a user should know of thick voxels: areas are of zones of one radiosity each.
fn constant(scene: &Scene, zones: &Zones) -> Option<Note> {
    let thick = forecast::thickness(scene, zones);
    (thick > THIN).then(|| {
        Note::new("thick-voxels", format!(
            "voxels are up to {thick:.2e} optical depths across, and these are the areas of zones of one radiosity each; `solve` takes slopes inside such voxels where it can (thick_zones), and its fluxes are then better than theirs"
        ))
    })
}

fn report(
    args: &Args,
    context: Context,
    m: &Matrices,
    (n, bands): (usize, usize),
    totals: Option<&Totals>,
    notes: &[Note],
) -> Result<(), Failure> {
    let defect = worst_row(&m.areas, &m.closure, n);
    let total = totals.map(|t| worst_row(&t.areas, &t.closure, n));
    let grade = if m.counts.all_proved() { "proved" } else { "estimated" };
    let path = args.output.display();
    if context.json {
        say(&format!(
            "{:#}",
            serde_json::json!({
                "zones": n, "matrices": bands, "grade": grade, "largest_row_defect": defect,
                "largest_total_row_defect": total,
                "aligned_pairs": m.counts.aligned, "general_pairs": m.counts.general, "rays": m.counts.rays,
                "written": path.to_string(), "warnings": output::notes_json(notes),
            })
        ))?;
        return context.judge(notes);
    }
    let also = total.map_or(String::new(), |d| format!(", of total areas by {d:.1e}"));
    say(&format!(
        "{n} zones, {bands} matrix(es), grade {grade}; row sums are off by at most {defect:.1e}{also} (an open scene loses what leaves it)\nwritten: {path}"
    ))?;
    for n in notes {
        say(&format!("  {}", printable(&n.line())))?;
    }
    context.judge(notes)
}
