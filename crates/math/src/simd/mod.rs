//! SIMD: loops over lanes on the widest vectors of the processor, with the same bits on all processors.
//!
//! | module | contents |
//! |---|---|
//! | `dispatch` | choice of the instruction set at run time |
//! | `exponential`, `logarithm` | e^x and ln x for lane arrays, in double precision |
//! | `complex` | complex arrays as arrays of their parts |
//! | [`f32x8`] | eight single-precision lanes with comparisons |

mod complex;
mod dispatch;
mod exponential;
pub mod f32x8;
mod logarithm;

pub use complex::{complex_bytes, complex_bytes_mut, complex_parts, complex_parts_mut};
pub use dispatch::{LANES, SimdKernel, dispatch, run};
pub use exponential::exp;
pub use logarithm::ln;
