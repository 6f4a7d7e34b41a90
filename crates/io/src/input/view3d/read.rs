//! Reading of a file, line by line.

use super::controls::ControlReader;
use super::fields::LineFields;
use super::model::View3dFile;
use super::surface_lines::{SurfaceForm, SurfaceReader};
use crate::files;
use crate::input::reading::error::{FileFault, InputError};
use std::path::Path;

/// Largest file, bytes.
const MAX_VIEW3D_FILE_BYTES: u64 = 1 << 30;

/// Reads an input file of View3D.
///
/// # Errors
///
/// The file cannot be read, or a line violates the format; the error names it.
///
/// ```
/// let path = std::env::temp_dir().join(format!("zonal-doc-view3d-{}.vs3", std::process::id()));
/// std::fs::write(&path, "C encl=1\nF 3\nV 1 0 0 0\nV 2 1 0 0\nV 3 0 1 0\nS 1 1 2 3 0 0 0 0.9 floor\nEnd\n")?;
/// let file = zonal_io::input::read_view3d(&path)?;
/// assert_eq!((file.surfaces[0].corners.len(), file.surfaces[0].name.as_str()), (3, "floor"));
/// assert!(file.controls.enclosure);
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_view3d(path: &Path) -> Result<View3dFile, InputError> {
    let file = path.display().to_string();
    let bytes =
        files::read(path, MAX_VIEW3D_FILE_BYTES).map_err(|e| FileFault::new(&file, "", e).into_error())?;
    read_view3d_from_bytes(&bytes, &file)
}

/// As [`read_view3d`], from bytes in memory; `name_for_messages` stands for the file in messages.
///
/// # Errors
///
/// As [`read_view3d`].
pub fn read_view3d_from_bytes(bytes: &[u8], name_for_messages: &str) -> Result<View3dFile, InputError> {
    let file = name_for_messages;
    if bytes.contains(&0) {
        let fault = FileFault::new(file, "", "this is not a text of View3D; give a .vs3 file");
        return Err(fault.into_error());
    }
    let text = String::from_utf8_lossy(bytes);
    read_text(file, text.trim_start_matches('\u{feff}')).map_err(FileFault::into_error)
}

/// The elements of a text, one a line.
fn read_text(file: &str, text: &str) -> Result<View3dFile, FileFault> {
    let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line));
    let mut title = String::new();
    let mut controls = ControlReader::default();
    let mut surfaces = SurfaceReader::new(file);
    let mut ended = false;
    while let Some((number, line)) = lines.next() {
        let mut fields = LineFields::new(file, number, line);
        let Some(word) = fields.next_word() else { continue };
        match word.as_bytes()[0].to_ascii_uppercase() {
            b'T' => title = line.trim_start()[word.len()..].trim().to_string(),
            b'C' => controls.read_line(fields)?,
            b'F' => surfaces.set_form(SurfaceForm::read(&mut fields)?, &fields)?,
            b'V' if surfaces.form_is(SurfaceForm::Vertices) => surfaces.read_vertex(fields)?,
            b'S' | b'M' | b'N' | b'O' => surfaces.read_surface(word, fields, &mut lines)?,
            b'V' => surfaces.require_form(&fields)?,
            b'E' | b'*' => {
                ended = true;
                break;
            }
            // View3D has no more than the letter of coordinate transformations.
            b'X' => {}
            _ => surfaces.count_unknown_line(number),
        }
    }
    let (surfaces, mut notes) = surfaces.finish()?;
    let (controls, control_notes) = controls.finish(file, &surfaces)?;
    notes.extend(control_notes);
    if !ended {
        notes.push(format!("{file}: there is no end line (E or *); all lines were read"));
    }
    Ok(View3dFile { title, controls, surfaces, notes })
}
