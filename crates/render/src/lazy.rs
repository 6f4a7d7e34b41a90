//! Values that are computed when first asked for, once.
//!
//! A camera sees a small part of a large scene; what rays never ask of a field is never prepared. A value is a function of its index alone,
//! so it does not matter which thread asks first.

use std::sync::OnceLock;

/// One value an index, each made when first asked for.
pub(crate) struct Lazy<T>(Vec<OnceLock<Box<T>>>);

impl<T> Lazy<T> {
    /// `n` values, none made yet.
    pub(crate) fn new(n: usize) -> Lazy<T> {
        Lazy((0..n).map(|_| OnceLock::new()).collect())
    }
    /// Value `i`, made by `make` unless it is there.
    pub(crate) fn get(&self, i: usize, make: impl FnOnce() -> T) -> &T {
        self.0[i].get_or_init(|| Box::new(make()))
    }
}
