//! Structs of counters.

/// Gives a struct of counters its sum with another one, and its numbers as an array in the order listed. A counter that is not listed does not compile.
///
/// ```
/// #[derive(Clone, Copy)]
/// struct Pairs {
///     hidden: u64,
///     seen: u64,
/// }
/// zonal_math::counters!(Pairs of u64: hidden, seen);
/// let mut sum = Pairs { hidden: 1, seen: 2 };
/// sum.merge(Pairs::from_numbers([3, 4]));
/// assert_eq!(sum.numbers(), [4, 6]);
/// ```
#[macro_export]
macro_rules! counters {
    ($type:ident of $number:ty: $($field:ident),+) => {
        impl $type {
            /// Number of counters.
            pub const LEN: usize = [$(stringify!($field)),+].len();
            /// The counters as an array.
            pub fn numbers(&self) -> [$number; Self::LEN] {
                [$(self.$field),+]
            }
            /// The counters of an array.
            pub fn from_numbers([$($field),+]: [$number; Self::LEN]) -> $type {
                $type { $($field),+ }
            }
            /// Adds other counters.
            pub fn merge(&mut self, other: $type) {
                $(self.$field += other.$field;)+
            }
        }
    };
}
