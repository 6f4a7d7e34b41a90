//! The description of one key, and lookups in tables of keys.

/// A key of a TOML format: what a reader accepts and what a manual prints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct KeySpec {
    /// Its name.
    pub(crate) name: &'static str,
    /// The type of its value.
    pub(crate) value: &'static str,
    /// The unit; empty for none.
    pub(crate) unit: &'static str,
    /// The default, or `required`; empty if an absent key does not apply.
    pub(crate) default: &'static str,
    /// One line.
    pub(crate) description: &'static str,
}

/// The keys of a table, in groups that tables share.
pub(crate) type KeyGroups = &'static [&'static [KeySpec]];

/// A key by name, type, unit, default and description.
pub(crate) const fn key(
    name: &'static str,
    value: &'static str,
    unit: &'static str,
    default: &'static str,
    description: &'static str,
) -> KeySpec {
    KeySpec { name, value, unit, default, description }
}

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
