//! `zonal exchange`: direct and total exchange areas of all pairs of zones of a scene, as arrays.
//!
//! With n zones in the order of a solution (patches, voxel zones, pane zones), k names, and m matrices (one if the bands do not differ, else one for
//! each band), the file holds, all in m² and symmetric to the bit:
//!
//! | array | shape | contents |
//! |---|---|---|
//! | `exchange_areas`, `error_radius` | [m, n, n] | direct exchange areas F: without reflection and scattering |
//! | `closure` | [m, n] | row sums of F in a closed scene: A of a patch, 4κV of a volume |
//! | `total_exchange_areas`, `total_error_radius` | [m, n, n] | total exchange areas T: net power from i to j per unit of σT_i⁴ − σT_j⁴ |
//! | `total_closure` | [m, n] | row sums of T in a closed scene: εA, 4κ_aV |
//! | `named_exchange_areas`, `named_error_radius` | [m, k, k] | sums of T over surfaces, medium and panes |
//! | `about` | bytes | JSON: `names`, in the order of these sums; `name_of_zone`, an index for each zone; units |

use super::context::{Context, check_tolerance, memory_limit};
use std::path::PathBuf;
use zonal_io::output::{self, NamedArray};
use zonal_report::{Failure, check_output, say};
use zonal_scene::printable;
use zonal_solve::exchange_areas::{AreaMatrices, ExchangeAreaContents, ExchangeAreaSettings, ExchangeAreas};

/// Write the exchange areas of all pairs of zones of a scene.
///
/// Direct exchange areas leave out reflection and scattering. Total exchange areas include them: with T in m2, zone i gives zone j the net power
/// T sigma (T_i^4 - T_j^4).
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Scene file (.toml).
    pub scene: PathBuf,
    /// Arrays to write (.npz): direct and total exchange areas, error radii, row sums of closed scenes, sums over names; m2.
    #[arg(long, short, value_name = "AREAS.npz")]
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
    check_output(&args.output, &["npz"])?;
    let scene = zonal_io::input::read_scene(&args.scene)?;
    let contents =
        if args.direct_only { ExchangeAreaContents::Direct } else { ExchangeAreaContents::DirectAndTotal };
    let settings = ExchangeAreaSettings { tolerance: args.tolerance, memory_limit, contents };
    let areas = ExchangeAreas::compute(&scene, &settings, &context.progress())
        .map_err(|e| Failure::in_file(&args.scene, e))?;
    write(args, &areas)?;
    report(args, &areas, context)
}

/// Writes the arrays.
fn write(args: &Args, areas: &ExchangeAreas) -> Result<(), Failure> {
    let (m, n, k) = (areas.matrices, areas.zone_count(), areas.names.len());
    let named = |name, shape, values| NamedArray { name, shape, values };
    let direct = &areas.direct;
    let mut arrays = vec![
        named("exchange_areas", vec![m, n, n], &direct.areas[..]),
        named("error_radius", vec![m, n, n], &direct.radii),
        named("closure", vec![m, n], &direct.closure),
    ];
    let Some(total) = &areas.total else {
        return Ok(output::write_arrays(&args.output, None, &arrays)?);
    };
    let [by_name, by_name_radii] = [&total.areas, &total.radii].map(|x| areas.by_name(x));
    arrays.extend([
        named("total_exchange_areas", vec![m, n, n], &total.areas[..]),
        named("total_error_radius", vec![m, n, n], &total.radii),
        named("total_closure", vec![m, n], &total.closure),
        named("named_exchange_areas", vec![m, k, k], &by_name),
        named("named_error_radius", vec![m, k, k], &by_name_radii),
    ]);
    let about = serde_json::json!({
        "names": areas.names, "name_of_zone": areas.name_of_zone, "unit": "m2",
        "order_of_zones": "patches, then voxel zones, then pane zones",
    });
    Ok(output::write_arrays(&args.output, Some(&about.to_string()), &arrays)?)
}

/// Prints counts, grade and closure.
fn report(args: &Args, areas: &ExchangeAreas, context: Context) -> Result<(), Failure> {
    let (n, matrices, grade) = (areas.zone_count(), areas.matrices, areas.grade().name());
    let defect = areas.direct.largest_row_defect();
    let total_defect = areas.total.as_ref().map(AreaMatrices::largest_row_defect);
    let path = args.output.display();
    if context.json {
        let counts = &areas.counts;
        let json = serde_json::json!({
            "zones": n, "matrices": matrices, "grade": grade, "largest_row_defect": defect,
            "largest_total_row_defect": total_defect,
            "aligned_pairs": counts.aligned, "general_pairs": counts.general, "rays": counts.rays,
            "written": path.to_string(), "warnings": output::notes_json(&areas.diagnostics),
        });
        say(&format!("{json:#}"))?;
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
