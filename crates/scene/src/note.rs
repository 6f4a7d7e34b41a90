//! What a user should know of a scene or a solution, beside its numbers.

use std::fmt;

/// How much a [`Note`] matters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The numbers hold as they are stated; the note tells how they came about or how to get better ones.
    #[default]
    Note,
    /// A stated number may be wrong, an error is unknown or misses the tolerance, or something in the input has no effect.
    Warning,
}

impl Severity {
    /// All of them, by rising severity.
    pub const ALL: [Severity; 2] = [Severity::Note, Severity::Warning];
    /// The word that reports use.
    pub fn word(self) -> &'static str {
        ["note", "warning"][self as usize]
    }
}

/// A message of a report: severity, a code that scripts may rely on, where it belongs, and a sentence for people.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Note {
    /// How much it matters.
    pub severity: Severity,
    /// A short identifier in kebab case, the same for every message of a kind: `open-scene`, `heat-balance`.
    pub code: String,
    /// What it is about: a file, a key of the scene, a surface by name; empty where it is about the whole.
    pub location: String,
    /// What there is to know, and what helps, in one sentence.
    pub text: String,
}

impl Note {
    /// A plain note.
    pub fn new(code: &str, text: impl Into<String>) -> Note {
        Note { severity: Severity::Note, code: code.into(), text: text.into(), ..Note::default() }
    }
    /// A warning.
    pub fn warning(code: &str, text: impl Into<String>) -> Note {
        Note { severity: Severity::Warning, ..Note::new(code, text) }
    }
    /// The same note about a place.
    pub fn at(self, location: impl Into<String>) -> Note {
        Note { location: location.into(), ..self }
    }
    /// The note as a line of a report: `SEVERITY: LOCATION: TEXT`.
    pub fn line(&self) -> String {
        format!("{}: {self}", self.severity.word())
    }
    /// True of a warning.
    pub fn is_warning(&self) -> bool {
        self.severity == Severity::Warning
    }
    /// True where its text holds these words.
    pub fn contains(&self, words: &str) -> bool {
        self.text.contains(words)
    }
}

impl fmt::Display for Note {
    /// `LOCATION: TEXT`, or the text alone.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.location.is_empty() {
            true => write!(f, "{}", self.text),
            false => write!(f, "{}: {}", self.location, self.text),
        }
    }
}

impl From<String> for Note {
    fn from(text: String) -> Note {
        Note::new("general", text)
    }
}

impl From<&str> for Note {
    fn from(text: &str) -> Note {
        Note::from(text.to_string())
    }
}
