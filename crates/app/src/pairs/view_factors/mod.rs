//! View factors of the facets of a mesh or of an input file of View3D, without a medium: facets, files, warnings.

pub mod diagnostics;
pub mod geometry;

use std::path::Path;
use zonal_io::output::{CheckpointKeys, ViewFactorFormat, ViewFactorTable, write_view_factors};
use zonal_math::Bounded;
use zonal_report::Failure;
use zonal_view_factors::{FacetSet, FactorRows, ScriptFactors, ViewFactorSettings, ViewFactors};

/// The format of the output: the one asked for, else by the extension, else the one of a file of View3D.
///
/// # Errors
/// If the extension has another format than the one asked for.
pub fn choose_format(
    output: &Path,
    asked: Option<ViewFactorFormat>,
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
    if by_extension.is_some_and(|e| asked.is_some_and(|a| a != e)) {
        return Err(Failure::new(
            "--format: this extension has a format of its own; write .txt or .out, or leave the option out",
        ));
    }
    Ok(asked.or(by_extension).or(by_file).unwrap_or(ViewFactorFormat::View3dText))
}

/// Identity of the batches of a computation in a folder.
#[must_use]
pub fn checkpoint_keys(set: &FacetSet, settings: &ViewFactorSettings) -> CheckpointKeys {
    CheckpointKeys::of_numbers("view factors", set.checkpoint_numbers(settings))
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
    factors: ViewFactors,
    script: Option<&ScriptFactors>,
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
