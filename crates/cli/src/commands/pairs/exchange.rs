//! `zonal exchange`: direct and total exchange areas of all pairs of zones of a scene, as arrays.

use crate::commands::context::{Context, memory_limit};
use std::path::PathBuf;
use zonal_app::pairs::check_tolerance;
use zonal_app::pairs::exchange_areas::write;
use zonal_app::timeline::READING;
use zonal_io::output;
use zonal_report::{Failure, check_output, say};
use zonal_scene::printable;
use zonal_solve::areas::exchange_areas::{
    AreaMatrices, ExchangeAreaContents, ExchangeAreaSettings, ExchangeAreas,
};

/// Write the exchange areas of all pairs of zones of a scene.
///
/// Direct exchange areas leave out reflection and scattering. Total exchange areas include them: with T in m2, zone i gives zone j the net power
/// T sigma (T_i^4 - T_j^4).
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Scene file (.toml).
    pub scene: PathBuf,
    /// File to write, m2: .npz (all arrays, also for `zonal update`), .csv (a line for each pair of zones that exchange), or .mtx (MatrixMarket: the total
    /// areas, or with --direct-only the direct ones, and their errors beside, as NAME.error.mtx).
    #[arg(long, short, value_name = "AREAS")]
    pub output: PathBuf,
    /// Relative tolerance of the factors of axis-aligned pairs and of pairs of plates, 0 < T < 1. Factors that are measured by rays have the tolerance of
    /// the scene.
    #[arg(long, default_value_t = 1e-9, value_name = "T")]
    pub tolerance: f64,
    /// Memory limit of the matrices, GB.
    #[arg(long, default_value_t = 12.0, value_name = "GB")]
    pub max_memory: f64,
    /// Leave out the total exchange areas, whose time grows with the cube of the number of zones.
    #[arg(long)]
    pub direct_only: bool,
}

/// Runs the command.
///
/// # Errors
/// For options and scenes that are not valid, matrices beyond the memory limit, and outputs that cannot be written.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    check_tolerance(args.tolerance)?;
    let memory_limit = memory_limit(args.max_memory)?;
    check_output(&args.output, &["npz", "csv", "mtx"])?;
    let scene = context.in_stage(READING, || zonal_io::input::read_scene(&args.scene))?;
    let contents =
        if args.direct_only { ExchangeAreaContents::Direct } else { ExchangeAreaContents::DirectAndTotal };
    let settings = ExchangeAreaSettings { tolerance: args.tolerance, memory_limit, contents };
    let areas = ExchangeAreas::compute(&scene, &settings, &context.progress())
        .map_err(|e| Failure::in_file(&args.scene, e))?;
    let written =
        write(&args.output, &scene, &areas, &context.progress()).map_err(|e| e.in_scene(&args.scene))?;
    report(&written, &areas, context)
}

/// Prints counts, grade and closure.
fn report(written: &[PathBuf], areas: &ExchangeAreas, context: Context) -> Result<(), Failure> {
    let (n, matrices, grade) = (areas.zone_count(), areas.matrices, areas.grade().name());
    let defect = areas.direct.largest_row_defect();
    let total_defect = areas.total.as_ref().map(AreaMatrices::largest_row_defect);
    let names: Vec<String> = written.iter().map(|p| p.display().to_string()).collect();
    let path = names.join(", ");
    if context.json {
        let counts = &areas.counts;
        let json = serde_json::json!({
            "zones": n, "matrices": matrices, "grade": grade, "largest_row_defect": defect,
            "largest_total_row_defect": total_defect,
            "aligned_pairs": counts.aligned, "general_pairs": counts.general, "rays": counts.rays,
            "written": names[0], "beside": names[1..], "warnings": output::notes_json(&areas.diagnostics),
        });
        context.say_json(json)?;
        return context.check_warnings(&areas.diagnostics);
    }
    let total = total_defect.map_or(String::new(), |d| format!(", of total areas {d:.1e}"));
    say(&format!(
        "{n} zones, {matrices} matrix(es), grade {grade}; largest relative closure defect of a row {defect:.1e}{total} (power leaves an open scene)\nwritten: {path}"
    ))?;
    for d in &areas.diagnostics {
        say(&format!("  {}", printable(&d.line())))?;
    }
    context.check_warnings(&areas.diagnostics)
}
