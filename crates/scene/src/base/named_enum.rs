//! Variants of enums without data, and their names in files and reports.

/// Gives an enum all its variants and their names, both in the order listed.
macro_rules! named_enum {
    ($type:ident: $($variant:ident $name:literal),+) => {
        impl $type {
            /// All variants.
            pub const VARIANTS: [$type; [$($name),+].len()] = [$($type::$variant),+];
            /// The names in files and reports, in the order of the variants.
            pub const NAMES: [&str; [$($name),+].len()] = [$($name),+];
            /// The name in files and reports.
            pub fn name(self) -> &'static str {
                match self {
                    $($type::$variant => $name),+
                }
            }
        }
        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
                s.serialize_str(self.name())
            }
        }
        impl<'de> serde::Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(d: D) -> Result<$type, D::Error> {
                let word = <String as serde::Deserialize>::deserialize(d)?;
                let found = $type::VARIANTS.into_iter().find(|x| x.name() == word);
                let names = || format!("must be one of {}", $type::NAMES.join(", "));
                found.ok_or_else(|| serde::de::Error::custom(names()))
            }
        }
    };
}
pub(crate) use named_enum;
