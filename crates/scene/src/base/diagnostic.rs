//! Diagnostics: notes and warnings about a scene or a solution.

use crate::base::named_enum::named_enum;
use crate::base::printable::{printable, printable_text};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// Severity of a [`Diagnostic`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The stated numbers are valid; the note explains their origin or how to improve them.
    #[default]
    Note,
    /// A stated number may be wrong, an error is unknown or exceeds the tolerance, or an input has no effect.
    Warning,
}

named_enum!(Severity: Note "note", Warning "warning");

/// A message of a report: severity, a stable code, the location and a sentence.
///
/// ```
/// use zonal_scene::Diagnostic;
/// let warning = Diagnostic::warning("open-scene", "the enclosure is open").at("surface 'wall'");
/// assert!(warning.is_warning());
/// assert_eq!(warning.line(), "warning: surface 'wall': the enclosure is open");
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
pub struct Diagnostic {
    /// Severity.
    pub severity: Severity,
    /// An identifier in kebab case that scripts may rely on, equal for all messages of a kind: `open-scene`, `heat-balance`.
    #[serde(deserialize_with = "printable_text")]
    pub code: String,
    /// The subject: a file, a key of the scene or the name of a surface; empty for the whole scene.
    #[serde(serialize_with = "null_if_empty", deserialize_with = "empty_if_null")]
    pub location: String,
    /// The message and a remedy, in one sentence.
    #[serde(deserialize_with = "printable_text")]
    pub text: String,
}

fn null_if_empty<S: Serializer>(text: &str, s: S) -> Result<S::Ok, S::Error> {
    Some(text).filter(|t| !t.is_empty()).serialize(s)
}

fn empty_if_null<'de, D: Deserializer<'de>>(d: D) -> Result<String, D::Error> {
    Ok(Option::<String>::deserialize(d)?.map(|t| printable(&t).into_owned()).unwrap_or_default())
}

impl Diagnostic {
    /// A note without location.
    pub fn note(code: &str, text: impl Into<String>) -> Diagnostic {
        Diagnostic { severity: Severity::Note, code: code.into(), text: text.into(), ..Diagnostic::default() }
    }
    /// A warning without location.
    pub fn warning(code: &str, text: impl Into<String>) -> Diagnostic {
        Diagnostic { severity: Severity::Warning, ..Diagnostic::note(code, text) }
    }
    /// The same diagnostic with a location.
    pub fn at(self, location: impl Into<String>) -> Diagnostic {
        Diagnostic { location: location.into(), ..self }
    }
    /// The line of a report: `SEVERITY: LOCATION: TEXT`.
    pub fn line(&self) -> String {
        format!("{}: {self}", self.severity.name())
    }
    /// True for a warning.
    pub fn is_warning(&self) -> bool {
        self.severity == Severity::Warning
    }
    /// True if the text contains `words`.
    pub fn contains(&self, words: &str) -> bool {
        self.text.contains(words)
    }
}

impl fmt::Display for Diagnostic {
    /// `LOCATION: TEXT`, or the text alone.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if self.location.is_empty() {
            write!(f, "{}", self.text)
        } else {
            write!(f, "{}: {}", self.location, self.text)
        }
    }
}

impl From<String> for Diagnostic {
    fn from(text: String) -> Diagnostic {
        Diagnostic::note("general", text)
    }
}

impl From<&str> for Diagnostic {
    fn from(text: &str) -> Diagnostic {
        Diagnostic::from(text.to_string())
    }
}
