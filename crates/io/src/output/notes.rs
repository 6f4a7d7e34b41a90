//! Notes of a scene or a report as JSON, and back: `{severity, code, location, text}`; the location is null of a note about the whole.

use serde_json::{Value, json};
use zonal_scene::{Note, Severity, printable};

/// A note as a JSON object.
pub fn note_json(n: &Note) -> Value {
    let location = (!n.location.is_empty()).then_some(&n.location);
    json!({"severity": n.severity.word(), "code": n.code, "location": location, "text": n.text})
}

/// Notes as a JSON list.
pub fn notes_json(notes: &[Note]) -> Value {
    notes.iter().map(note_json).collect()
}

/// The note in what [`note_json`] wrote.
pub(super) fn note_in(v: &Value) -> Result<Note, String> {
    let text = |key: &str| {
        v[key].as_str().map(|t| printable(t).into_owned()).ok_or(format!("a note's {key} is no text"))
    };
    let severity = text("severity")?;
    Ok(Note {
        severity: Severity::ALL
            .into_iter()
            .find(|s| s.word() == severity)
            .ok_or("a note's severity is neither note nor warning")?,
        code: text("code")?,
        location: if v["location"].is_null() { String::new() } else { text("location")? },
        text: text("text")?,
    })
}
