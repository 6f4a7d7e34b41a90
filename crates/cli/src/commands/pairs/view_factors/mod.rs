//! `zonal view-factors`: view factors of the facets of a mesh or of an input file of View3D, without a medium.

mod args;
mod report;

pub use args::Args;

use crate::commands::context::{Context, memory_limit};
use args::FacetSides;
use std::path::Path;
use std::time::Instant;
use zonal_app::pairs::check_tolerance;
use zonal_app::pairs::view_factors::geometry::{FactorGeometry, read};
use zonal_app::pairs::view_factors::{FactorLabels, checkpoint_keys, choose_format, write_factors};
use zonal_app::timeline::{READING, WRITING};
use zonal_io::output::{self, CheckpointFolder, CheckpointState, ViewFactorFormat};
use zonal_report::{Failure, check_output, note};
use zonal_scene::{CheckpointStore, NoCheckpoints};
use zonal_view_factors::{Openness, RowClosing, ViewFactorSettings, ViewFactors};

/// Runs the command.
///
/// # Errors
/// For options and files that are not valid, results beyond the memory limit, and outputs that cannot be written.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let begin = Instant::now();
    check_tolerance(args.tolerance)?;
    check_output(&args.output, &["npz", "csv", "mtx", "txt", "out", "bin"])?;
    if let Some(sky) = &args.sky {
        check_output(sky, &["txt"])?;
    }
    let mut geometry = context.in_stage(READING, || read(&args.input, args.obstructions.as_deref()))?;
    if args.sides == FacetSides::Both {
        geometry.add_backs();
    }
    let settings = settings(args, &geometry)?;
    let folder = args.cache.as_deref().map(|path| open_cache(path, &geometry, &settings)).transpose()?;
    let checkpoints = folder.as_ref().map_or(&NoCheckpoints as &dyn CheckpointStore, |f| f);
    let factors = geometry
        .set
        .compute(&settings, &context.progress(), checkpoints)
        .map_err(|e| Failure::in_file(&args.input, e))?;
    if let Some(e) = folder.as_ref().and_then(CheckpointFolder::failure) {
        note(&format!("the cache could not be written: {e}"));
    }
    let asked = args.format.map(ViewFactorFormat::from);
    let format = choose_format(&args.output, asked, geometry.format())?;
    let report = report::FactorReport::of(&geometry, &factors, &settings);
    let closed = settings.surroundings == Openness::Closed;
    context.in_stage(WRITING, || write(args, &geometry, factors, format, closed))?;
    report.print(args, begin.elapsed().as_secs_f64(), context)
}

fn settings(args: &Args, geometry: &FactorGeometry) -> Result<ViewFactorSettings, Failure> {
    let closed = args.enclosure || geometry.is_enclosure();
    let up = args.up as usize;
    if up != 2 && (args.period_x.is_some() || args.period_y.is_some()) {
        return Err(Failure::new("--period-x, --period-y: these need --up z; turn the geometry"));
    }
    Ok(ViewFactorSettings {
        tolerance: args.tolerance,
        closure: if args.no_closing { RowClosing::Keep } else { RowClosing::Restore },
        surroundings: if closed { Openness::Closed } else { Openness::Open },
        up,
        periods: [args.period_x, args.period_y],
        memory_limit: memory_limit(args.max_memory)?,
    })
}

/// The folder of finished batches: emptied if they belong to other facets or settings.
fn open_cache(
    path: &Path,
    geometry: &FactorGeometry,
    settings: &ViewFactorSettings,
) -> Result<CheckpointFolder, Failure> {
    let folder = CheckpointFolder::new(path, checkpoint_keys(&geometry.set, settings));
    if folder.open_shared()? == CheckpointState::Mismatched {
        note(&format!("{}: this cache belonged to other facets or settings; it begins anew", path.display()));
    }
    Ok(folder)
}

fn write(
    args: &Args,
    geometry: &FactorGeometry,
    factors: ViewFactors,
    format: ViewFactorFormat,
    enclosure: bool,
) -> Result<(), Failure> {
    let scripted = args.script_f || geometry.controls.as_ref().is_some_and(|c| c.emittances);
    let script = scripted.then(|| factors.script_factors(&geometry.emissivities)).transpose();
    let script = script.map_err(|e| Failure::in_file(&args.input, e))?;
    let labels = FactorLabels { names: &geometry.names, emissivities: &geometry.emissivities, enclosure };
    let sky = write_factors(&args.output, format, factors, script.as_ref(), &labels)?;
    if let Some(path) = &args.sky {
        let lines: String = sky.iter().map(|s| format!("{s:.8}\n")).collect();
        output::write_bytes(path, format!("# sky view factors\n{lines}").as_bytes())?;
    }
    Ok(())
}
