//! Arrays in npz files: a zip of npy files, stored uncompressed.
//!
//! Reader and writer are written here rather than taken from a crate (`npyz`, `ndarray-npy`): the reader charges every allocation against
//! a budget that the file pays for, refuses packed data that declares more, and names the entry in every error; the writer streams from
//! iterators without holding an array, and the bytes of its headers are part of the format.

pub(crate) mod arrays;
pub(crate) mod npy;
pub(crate) mod reader;
pub(crate) mod writer;
