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
    };
}
pub(crate) use named_enum;
