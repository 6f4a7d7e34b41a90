//! `zonal view-factors`: view factors of the facets of a mesh or of an input file of View3D, without a medium.

mod args;
pub mod diagnostics;
pub mod geometry;
mod report;

pub use args::{Args, FacetSides, OutputFormat};

use crate::commands::context::{Context, check_tolerance, memory_limit};
use geometry::FactorGeometry;
use std::path::Path;
use std::time::Instant;
use zonal_io::output::{
    self, CheckpointFolder, CheckpointKeys, CheckpointState, ViewFactorFormat, ViewFactorTable,
    write_view_factors,
};
use zonal_math::Bounded;
use zonal_report::{Failure, check_output, note};
use zonal_scene::{CheckpointStore, NoCheckpoints};
use zonal_view_factors::{
    FacetSet, FactorRows, Openness, RowClosing, ScriptFactors, ViewFactorSettings, ViewFactors,
};

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
    let mut geometry = geometry::read(&args.input, args.obstructions.as_deref())?;
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
    let by_file = geometry.controls.as_ref().map(geometry::format_of);
    let format = choose_format(&args.output, args.format, by_file)?;
    let report = report::FactorReport::of(&geometry, &factors, &settings);
    let closed = settings.surroundings == Openness::Closed;
    write(args, &geometry, factors, format, closed)?;
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

/// The format of the output: the one asked for, else by the extension, else the one of a file of View3D.
///
/// # Errors
/// If the extension has another format than the one asked for.
pub fn choose_format(
    output: &Path,
    asked: Option<OutputFormat>,
    by_file: Option<ViewFactorFormat>,
) -> Result<ViewFactorFormat, Failure> {
    let extension = output.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    let by_extension = match extension.as_deref() {
        Some("npz") => Some(ViewFactorFormat::Npz),
        Some("csv") => Some(ViewFactorFormat::Csv),
        Some("mtx") => Some(ViewFactorFormat::MatrixMarket),
        Some("bin") => Some(ViewFactorFormat::View3dBinary),
        _ => None,
    };
    let chosen = asked.map(|f| match f {
        OutputFormat::Text => ViewFactorFormat::View3dText,
        OutputFormat::Binary => ViewFactorFormat::View3dBinary,
        OutputFormat::Sparse => ViewFactorFormat::SparseText,
    });
    if by_extension.is_some_and(|e| chosen.is_some_and(|c| c != e)) {
        return Err(Failure::new(
            "--format: this extension has a format of its own; write .txt or .out, or leave the option out",
        ));
    }
    Ok(chosen.or(by_extension).or(by_file).unwrap_or(ViewFactorFormat::View3dText))
}

/// Identity of the batches of a computation in a folder.
#[must_use]
pub fn checkpoint_keys(set: &FacetSet, settings: &ViewFactorSettings) -> CheckpointKeys {
    CheckpointKeys::of_numbers("view factors", set.checkpoint_numbers(settings))
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
    let sky = write_factors(&args.output, format, (factors, script.as_ref()), &labels)?;
    if let Some(path) = &args.sky {
        let lines: String = sky.iter().map(|s| format!("{s:.8}\n")).collect();
        output::write_bytes(path, format!("# sky view factors\n{lines}").as_bytes())?;
    }
    Ok(())
}

/// Names and emissivities of the surfaces, written into a file of factors.
#[derive(Clone, Copy, Debug)]
pub struct FactorLabels<'a> {
    /// Name of each surface.
    pub names: &'a [String],
    /// Emissivity of each surface.
    pub emissivities: &'a [f64],
    /// True if the surfaces form an enclosure.
    pub enclosure: bool,
}

/// Writes view factors, or total exchange factors in their place; returns the factors to the sky.
///
/// # Errors
/// If the file cannot be written.
pub fn write_factors(
    path: &Path,
    format: ViewFactorFormat,
    (factors, script): (ViewFactors, Option<&ScriptFactors>),
    labels: &FactorLabels<'_>,
) -> Result<Vec<f64>, Failure> {
    let mut rows = factors.into_rows();
    if let Some(script) = script {
        replace_by_script_factors(&mut rows, script);
    }
    let part = |b: &[Bounded], f: fn(&Bounded) -> f64| b.iter().map(f).collect::<Vec<f64>>();
    let sky = part(&rows.sky, |b| b.value);
    let table = ViewFactorTable {
        areas: &rows.areas,
        emissivities: labels.emissivities,
        names: labels.names,
        row_starts: &rows.row_starts,
        columns: &rows.columns,
        values: &rows.values,
        radii: &rows.radii,
        sky: &sky,
        sky_radii: &part(&rows.sky, |b| b.radius),
        ground: &part(&rows.ground, |b| b.value),
        ground_radii: &part(&rows.ground, |b| b.radius),
        defects: &rows.defects,
        enclosure: labels.enclosure,
        scripted: script.is_some(),
    };
    write_view_factors(path, format, &table)?;
    Ok(sky)
}

/// Dense rows of total exchange factors in place of view factors.
fn replace_by_script_factors(rows: &mut FactorRows, script: &ScriptFactors) {
    let n = rows.areas.len();
    rows.row_starts = (0..=n).map(|i| (i * n) as u64).collect();
    rows.columns = (0..n * n).map(|k| (k % n) as u32).collect();
    let all = || (0..n * n).map(|k| script.get(k / n, k % n));
    rows.values = all().map(|b| b.value).collect();
    rows.radii = all().map(|b| (b.radius as f32).next_up()).collect();
}
