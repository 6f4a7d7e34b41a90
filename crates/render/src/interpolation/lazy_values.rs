//! Values computed on first use, once.
//!
//! A camera sees a small part of a large scene; values that no ray needs are never computed. A value is a function of its index alone,
//! so that the thread that needs it first does not matter.

use std::sync::OnceLock;

/// One value an index, each computed on first use.
pub(crate) struct LazyValues<T>(Vec<OnceLock<Box<T>>>);

impl<T> LazyValues<T> {
    /// `n` values, none computed yet.
    pub(crate) fn new(n: usize) -> LazyValues<T> {
        LazyValues((0..n).map(|_| OnceLock::new()).collect())
    }
    /// Value `i`, computed by `compute` on first use.
    pub(crate) fn get(&self, i: usize, compute: impl FnOnce() -> T) -> &T {
        self.0[i].get_or_init(|| Box::new(compute()))
    }
}
