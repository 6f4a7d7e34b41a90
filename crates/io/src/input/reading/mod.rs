//! Reading of text and bytes: messages with a place and a remedy, notes, numbers one after the other, NumPy arrays.
//!
//! | module | contents |
//! |---|---|
//! | `text` | files as text |
//! | `number_cursor` | numbers of a text or of binary data, one after the other |
//! | `npy` | arrays of NumPy |
//! | `error`, `suggestion` | errors with place and remedy; suggestions for misspelt words |
//! | `notes` | notes with repetitions merged |

pub(crate) mod error;
pub(crate) mod notes;
pub(crate) mod npy;
pub(crate) mod number_cursor;
pub(crate) mod suggestion;
pub(crate) mod text;
