//! Notes and warnings as JSON.

use serde_json::Value;
use zonal_scene::Diagnostic;

/// Notes as a JSON list of `{severity, code, location, text}`; the location of a note about the whole is null.
pub fn notes_json(notes: &[Diagnostic]) -> Value {
    serde_json::to_value(notes).unwrap_or_default()
}
