//! Keys of TOML formats, each defined once: name, type, unit, default and description, and how its value is read.
//!
//! A table of keys is a struct with a field for each key, which [`keys!`] makes. Readers take values by field, so that a key without a definition
//! does not compile; unknown keys of a file are refused by the same definitions, and manuals list them.

use super::key_specs::{KeySpec, ValueType};
use super::node::{TomlNode, TomlTable};
use super::source::SourceText;
use crate::input::reading::error::InputError;

/// Reads a value of type T where it stands.
pub(crate) type Read<T> = for<'a> fn(&TomlNode<'a>) -> Result<T, InputError>;

/// Type and unit of the values of a key in words, and their reader.
pub(crate) struct Kind<T> {
    pub(crate) value: ValueType,
    pub(crate) unit: &'static str,
    pub(crate) read: Read<T>,
}

impl<T> Kind<T> {
    pub(crate) const fn new(value: &'static str, read: Read<T>) -> Kind<T> {
        Kind { value: ValueType::Described(value), unit: "", read }
    }
    /// The same values in a unit.
    pub(crate) const fn in_unit(self, unit: &'static str) -> Kind<T> {
        Kind { value: self.value, unit, read: self.read }
    }
    /// The same values under another description, for limits that depend on other keys.
    pub(crate) const fn described(self, value: &'static str) -> Kind<T> {
        Kind { value: ValueType::Described(value), unit: self.unit, read: self.read }
    }
}

/// A key whose values have the type T.
pub(crate) struct Key<T> {
    pub(crate) spec: KeySpec,
    read: Read<T>,
}

impl<T> Key<T> {
    pub(crate) const fn new(
        name: &'static str,
        kind: Kind<T>,
        default: &'static str,
        description: &'static str,
        example: &'static str,
    ) -> Key<T> {
        let name = plain_name(name);
        let spec = KeySpec { name, value: kind.value, unit: kind.unit, default, description, example };
        Key { spec, read: kind.read }
    }
    /// The value of a node of this key.
    pub(crate) fn read(&self, node: &TomlNode<'_>) -> Result<T, InputError> {
        (self.read)(node)
    }
    /// The default, which the definition must state as a value.
    pub(crate) fn default(&self) -> Result<T, InputError> {
        let text = format!("{} = {}", self.spec.name, self.spec.default);
        let source = SourceText::new("the default", &text);
        let document = source.parse()?;
        TomlTable::root(&source, document.get_ref()).required(self)
    }
}

impl<T> AsRef<str> for Key<T> {
    fn as_ref(&self) -> &str {
        self.spec.name
    }
}

/// The name of a field without the mark of names that are words of Rust.
const fn plain_name(name: &'static str) -> &'static str {
    match name.as_bytes() {
        [b'r', b'#', ..] => name.split_at(2).1,
        _ => name,
    }
}

impl<'a> TomlTable<'a> {
    /// The node of a key that must be there.
    pub(crate) fn require<T>(&self, key: &Key<T>) -> Result<TomlNode<'a>, InputError> {
        let spec = key.spec;
        self.get(key).ok_or_else(|| self.missing(spec.name, &format!("{} = {}", spec.name, spec.example)))
    }
    /// The value of a key, if it is given.
    pub(crate) fn value<T>(&self, key: &Key<T>) -> Result<Option<T>, InputError> {
        self.get(key).map(|n| key.read(&n)).transpose()
    }
    /// The value of a key that must be there.
    pub(crate) fn required<T>(&self, key: &Key<T>) -> Result<T, InputError> {
        key.read(&self.require(key)?)
    }
    /// The value of a key, or the default of its definition.
    pub(crate) fn or_default<T>(&self, key: &Key<T>) -> Result<T, InputError> {
        self.value(key)?.map_or_else(|| key.default(), Ok)
    }
    /// The entries of `[[key]]`; none if it is absent.
    pub(crate) fn list(&self, key: &Key<()>) -> Result<Vec<TomlNode<'a>>, InputError> {
        match self.get(key) {
            None => Ok(Vec::new()),
            Some(node) if node.is_list() => node.list(),
            Some(node) => {
                let name = key.spec.name;
                Err(node
                    .error(format!("this is not a list; write [[{name}]] with two brackets on each side")))
            }
        }
    }
}

/// Defines tables of keys. `NAME: Type = [Groups] { key: T = KIND, "default", "description", "example"; }` makes the struct `Type` of its keys, their
/// definitions `NAME`, the list `Type::ALL` of them, and `Type::TABLE`, the keys of the table with those of other structs. The example is for required keys.
macro_rules! keys {
    ($($(#[$doc:meta])* $name:ident: $type:ident = [$($group:ident),*] {
        $($key:ident: $t:ty = $kind:expr, $default:expr, $description:expr $(, $example:literal)?;)*
    })*) => {$(
        $(#[$doc])*
        pub(crate) struct $type { $(pub(crate) $key: $crate::input::toml::keys::Key<$t>,)* }
        impl $type {
            pub(crate) const ALL: &'static [$crate::input::toml::key_specs::KeySpec] = &[$($name.$key.spec,)*];
            #[allow(dead_code)] // Groups that only other tables include.
            pub(crate) const TABLE: $crate::input::toml::key_specs::KeyGroups = &[$($group::ALL),*];
        }
        pub(crate) const $name: $type = $type {
            $($key: $crate::input::toml::keys::Key::new(
                stringify!($key), $kind, $default, $description, concat!($($example)?)),)*
        };
    )*};
}
pub(crate) use keys;
