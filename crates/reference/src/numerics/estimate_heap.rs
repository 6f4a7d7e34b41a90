//! Items ordered by a number, the largest first out of a heap.

use std::cmp::Ordering;

/// An item with its key.
pub(crate) struct Largest<T> {
    pub key: f64,
    pub item: T,
}

impl<T> PartialEq for Largest<T> {
    fn eq(&self, o: &Largest<T>) -> bool {
        self.cmp(o).is_eq()
    }
}
impl<T> Eq for Largest<T> {}
impl<T> PartialOrd for Largest<T> {
    fn partial_cmp(&self, o: &Largest<T>) -> Option<Ordering> {
        Some(self.cmp(o))
    }
}
impl<T> Ord for Largest<T> {
    fn cmp(&self, o: &Largest<T>) -> Ordering {
        self.key.total_cmp(&o.key)
    }
}
