//! What manuals print of a key, and the names of the keys of a table.

/// The type of a value in words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ValueType {
    Described(&'static str),
    /// One of these texts.
    OneOf(&'static [&'static str]),
}

impl ValueType {
    /// The type as manuals print it.
    pub(crate) fn text(self) -> String {
        match self {
            ValueType::Described(text) => text.to_string(),
            ValueType::OneOf(words) => {
                words.iter().map(|w| format!("\"{w}\"")).collect::<Vec<_>>().join(" | ")
            }
        }
    }
}

/// A key without the reader of its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct KeySpec {
    pub(crate) name: &'static str,
    pub(crate) value: ValueType,
    /// The unit; empty for none.
    pub(crate) unit: &'static str,
    /// The default, or `required`; empty if an absent key does not apply.
    pub(crate) default: &'static str,
    /// One line.
    pub(crate) description: &'static str,
    /// A value as messages about a missing key show it.
    pub(crate) example: &'static str,
}

/// The keys of a table, in groups that tables share.
pub(crate) type KeyGroups = &'static [&'static [KeySpec]];

/// All keys of a table.
pub(crate) fn all(groups: KeyGroups) -> impl Iterator<Item = &'static KeySpec> {
    groups.iter().copied().flatten()
}

/// The names of all keys of a table.
pub(crate) fn names(groups: KeyGroups) -> Vec<&'static str> {
    all(groups).map(|k| k.name).collect()
}

/// True if a word is the name of a key.
pub(crate) fn knows(groups: KeyGroups, word: &str) -> bool {
    all(groups).any(|k| k.name == word)
}
