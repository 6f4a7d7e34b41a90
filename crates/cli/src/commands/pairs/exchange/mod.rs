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
//! | `about` | bytes | JSON: `names`, in the order of these sums; `name_of_zone`, an index for each zone; units; meshes, band fractions |
//!
//! and in thermal mode, for [`super::update`]:
//!
//! | array | shape | contents |
//! |---|---|---|
//! | `zone_size` | `n` | A in m², V in m³ |
//! | `reflectance` | [bands, n] | ρ of patches, Ω of volumes |
//! | `condition` | [n, 2] | 1 and T (K), or 2 and the flux that leaves (W/m², W/m³) |
//! | `zone_face` | `n` | face among the faces of all meshes, −1 for none |
//! | `surroundings_areas`, `surroundings_radius`, `backface_areas` | [m, n] | exchange with the surroundings, its standard error, and with black backs, scaled with the rows |
//! | `closure_scaling` | [m, n] | d of the rows: the areas of a state are d_i F_ij d_j; 1, since `exchange_areas` of a thermal scene are those after restoration of closure |
//! | `closure_error` | [m, n] | error of the incident power by closure, relative to it |
//! | `light_incident`, `light_error` | [bands, n] | direct light H of patches, G/4 of volumes, and its error, W/m²; with lights |
//! | `light_power` | [bands, 5] | power sent in, emitted, escaping and on black backs unscattered, and the error of all these, W; with lights |
//! | `zone_fractions` | `n` | band fractions of each zone among those of `about`; where they differ |

mod fractions;
pub mod npz;
mod text;

use crate::commands::context::{Context, check_tolerance, memory_limit};
use std::path::{Path, PathBuf};
use zonal_io::output;
use zonal_report::{Failure, check_output, say};
use zonal_scene::{Progress, Scene, SceneError, printable};
use zonal_solve::areas::exchange_areas::{
    AreaMatrices, ExchangeAreaContents, ExchangeAreaSettings, ExchangeAreas,
};
use zonal_solve::state::ExchangeData;

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
    let scene = zonal_io::input::read_scene(&args.scene)?;
    let contents =
        if args.direct_only { ExchangeAreaContents::Direct } else { ExchangeAreaContents::DirectAndTotal };
    let settings = ExchangeAreaSettings { tolerance: args.tolerance, memory_limit, contents };
    let areas = ExchangeAreas::compute(&scene, &settings, &context.progress())
        .map_err(|e| Failure::in_file(&args.scene, e))?;
    let written =
        write(&args.output, &scene, &areas, &context.progress()).map_err(|e| e.prefixed(&args.scene))?;
    report(&written, &areas, context)
}

/// Writes exchange areas in the format of the extension (npz, csv, mtx); returns the paths of all files.
///
/// # Errors
/// If a file cannot be written.
pub fn write(
    output: &Path,
    scene: &Scene,
    areas: &ExchangeAreas,
    progress: &dyn Progress,
) -> Result<Vec<PathBuf>, WriteFailure> {
    let extension = output.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("csv") => Ok(text::write_csv(output, areas)?),
        Some("mtx") => Ok(text::write_mtx(output, areas)?),
        _ => {
            // Most scenes in thermal mode also have the data of other states.
            let has_state = ExchangeData::refusal(scene).is_none();
            let state = has_state.then(|| ExchangeData::new(scene, areas, progress)).transpose()?;
            npz::write(output, areas, state.as_ref())?;
            Ok(vec![output.to_path_buf()])
        }
    }
}

/// Why exchange areas were not written.
#[derive(Debug)]
pub enum WriteFailure {
    /// The scene has no data of thermal states.
    Scene(SceneError),
    /// A file cannot be written.
    File(Failure),
}

impl WriteFailure {
    /// The failure of a command that read the scene from a file.
    #[must_use]
    pub fn prefixed(self, scene: &Path) -> Failure {
        match self {
            WriteFailure::Scene(e) => Failure::in_file(scene, e),
            WriteFailure::File(e) => e,
        }
    }
}

impl From<SceneError> for WriteFailure {
    fn from(e: SceneError) -> WriteFailure {
        WriteFailure::Scene(e)
    }
}

impl From<Failure> for WriteFailure {
    fn from(e: Failure) -> WriteFailure {
        WriteFailure::File(e)
    }
}

impl From<output::FileError> for WriteFailure {
    fn from(e: output::FileError) -> WriteFailure {
        WriteFailure::File(e.into())
    }
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
