//! Buffers that computations at the same time take and give back.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Buffers that are not in use.
pub(crate) struct BufferPool<T>(Mutex<Vec<T>>);

impl<T> Default for BufferPool<T> {
    fn default() -> BufferPool<T> {
        BufferPool(Mutex::new(Vec::new()))
    }
}

impl<T: Default> BufferPool<T> {
    fn spare(&self) -> MutexGuard<'_, Vec<T>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
    /// The buffer that was given back last, with its content, or a new one.
    pub(crate) fn take(&self) -> T {
        self.spare().pop().unwrap_or_default()
    }
    /// Gives a buffer back.
    pub(crate) fn give(&self, buffer: T) {
        self.spare().push(buffer);
    }
    /// Frees all buffers.
    pub(crate) fn clear(&self) {
        self.spare().clear();
    }
}
