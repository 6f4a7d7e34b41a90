//! A table with one line for each zone, for spreadsheets.
//!
//! Columns: zone (global index), kind (patch, voxel, pane), of (name of the surface or pane, index of the voxel),
//! x, y, z (centre, m), size (area in m² of patches and panes, free volume in m³ of voxels), then per band b = 0, 1, …: radiosity_b,
//! incident_b (H of patches, fluence G of the others, without direct light), direct_b, error_b (of incident), direct_error_b (of
//! direct), all W/m². In thermal mode also temperature_K, temperature_error_K (empty if undefined), net, net_error (net radiative flux
//! that leaves: W/m² of patches, W/m³ of the others).

use super::atomic::write_atomic;
use super::error::FileError;
use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::Write;
use std::path::Path;
use zonal_math::Vec3;
use zonal_scene::{Fields, Photometry, Solution, printable};

/// A cell that no spreadsheet interprets as a formula: an apostrophe precedes a text that begins with `=`, `+`, `-`, `@`, a tab or a line
/// break and is neither a number nor a direction (`+x`).
///
/// ```
/// assert_eq!(zonal_io::output::csv_cell("=A1"), "'=A1");
/// assert_eq!(zonal_io::output::csv_cell("-1.5"), "-1.5");
/// ```
pub fn csv_cell(text: &str) -> Cow<'_, str> {
    let formula = text.starts_with(['=', '+', '-', '@', '\t', '\r', '\n']);
    let direction = matches!(text.trim().as_bytes(), [b'+' | b'-', b'x' | b'y' | b'z']);
    let plain = direction || text.trim().parse::<f64>().is_ok();
    if formula && !plain { Cow::Owned(format!("'{text}")) } else { Cow::Borrowed(text) }
}

/// The cell of a name: without control characters, never a formula, in quotes if it needs them.
///
/// ```
/// assert_eq!(zonal_io::output::csv_name("lid, hot"), "\"lid, hot\"");
/// ```
#[must_use]
pub fn csv_name(name: &str) -> String {
    let name = printable(name);
    let name = csv_cell(&name);
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.into_owned()
    }
}

/// The line of column names.
fn heading(bands: usize, thermal: bool) -> String {
    let mut line = String::from("zone,kind,of,x,y,z,size");
    for field in Fields::in_tables() {
        for band in 0..bands {
            let _ = write!(line, ",{}_{band}", field.name);
        }
    }
    if thermal {
        line.push_str(",temperature_K,temperature_error_K,net,net_error");
    }
    line
}

/// Kind, owner, centre and size of a zone.
fn describe(s: &Solution, i: usize) -> (&'static str, String, Vec3, f64) {
    let z = &s.zones;
    if i < z.voxel_offset() {
        let p = &z.patches[i];
        ("patch", csv_name(&s.scene.surfaces()[p.surface].name), p.plate.centre(), p.area)
    } else if i < z.pane_offset() {
        let v = z.voxels.at(i - z.voxel_offset());
        ("voxel", v.cell.to_string(), v.centre, v.volume)
    } else {
        let p = &z.panes[i - z.pane_offset()];
        ("pane", csv_name(&s.scene.panes()[p.pane].name), p.plate.centre(), p.area)
    }
}

/// Writes the table of zones in photometric units; columns: zone, kind, of, x, y, z, size, illuminance_lx and its error illuminance_error_lx (spherical illuminance of volumes, direct light
/// included), luminous_exitance_lm_m2.
///
/// # Errors
///
/// The file cannot be written.
pub fn write_photometric_csv(
    path: impl AsRef<Path>,
    s: &Solution,
    photometry: &Photometry<'_>,
) -> Result<(), FileError> {
    write_atomic(path.as_ref(), |out| {
        writeln!(out, "zone,kind,of,x,y,z,size,illuminance_lx,illuminance_error_lx,luminous_exitance_lm_m2")?;
        for i in 0..s.zones.len() {
            let (kind, of, c, size) = describe(s, i);
            let ([lux, error], exitance) = (photometry.illuminance(i), photometry.exitance(i));
            writeln!(out, "{i},{kind},{of},{},{},{},{size},{lux},{error},{exitance}", c.x, c.y, c.z)?;
        }
        Ok(())
    })
}

/// Writes the table of zones; columns: zone, kind, of, x, y, z, size, then radiosity, incident, direct, error and direct_error of each
/// band in W/m², and in thermal mode temperature_K, temperature_error_K, net, net_error.
///
/// # Errors
///
/// The file cannot be written.
pub fn write_zones_csv(path: impl AsRef<Path>, s: &Solution) -> Result<(), FileError> {
    let path = path.as_ref();
    let f = &s.fields;
    write_atomic(path, |out| {
        writeln!(out, "{}", heading(s.scene.bands().count(), f.heat.is_some()))?;
        for i in 0..s.zones.len() {
            let (kind, of, c, size) = describe(s, i);
            write!(out, "{i},{kind},{of},{},{},{},{size}", c.x, c.y, c.z)?;
            for field in Fields::in_tables() {
                for x in s.all_bands(|t| (field.of)(&t.fields).get(i).copied().unwrap_or_default()) {
                    write!(out, ",{x}")?;
                }
            }
            if let Some(h) = &f.heat {
                for x in [h.temperature[i], h.temperature_error[i], h.net[i], h.net_error[i]] {
                    write!(out, ",")?;
                    if !x.is_nan() {
                        write!(out, "{x}")?;
                    }
                }
            }
            writeln!(out)?;
        }
        Ok(())
    })
}
