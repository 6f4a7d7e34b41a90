//! Notes and warnings as JSON, and back: `{severity, code, location, text}`; the location of a note about the whole is null.

use super::codec::{list_of, printable_text, severity};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;
use zonal_scene::{Diagnostic, Severity, printable};

/// The format of a note.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Diagnostic")]
struct DiagnosticFormat {
    #[serde(with = "severity")]
    severity: Severity,
    #[serde(deserialize_with = "printable_text")]
    code: String,
    #[serde(serialize_with = "null_if_empty", deserialize_with = "empty_if_null")]
    location: String,
    #[serde(deserialize_with = "printable_text")]
    text: String,
}

list_of!(pub(crate) diagnostics, Diagnostic, "DiagnosticFormat");

fn null_if_empty<S: Serializer>(text: &str, s: S) -> Result<S::Ok, S::Error> {
    Some(text).filter(|t| !t.is_empty()).serialize(s)
}

fn empty_if_null<'de, D: Deserializer<'de>>(d: D) -> Result<String, D::Error> {
    Ok(Option::<String>::deserialize(d)?.map(|t| printable(&t).into_owned()).unwrap_or_default())
}

/// Notes as a JSON list of `{severity, code, location, text}`.
pub fn notes_json(notes: &[Diagnostic]) -> Value {
    diagnostics::serialize(notes, serde_json::value::Serializer).unwrap_or_default()
}
