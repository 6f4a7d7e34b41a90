//! The layered engine: slabs whose extinction varies from layer to layer, periodic along two axes.
//!
//! The medium varies along the third axis alone, panes lie across it and fill the period, and the walls at its ends, if there are any, fill the period. Then all zones of a layer have equal
//! radiosities, and the exchange of two zones is that of their layers times their shares s of the area A of the period:
//!
//! ```text
//!     g_ij = s_i s_j A g(layer of i, layer of j)
//! ```
//!
//! with the factors g of infinite layers of [`zonal_exchange::layers`], all with a proved relative radius, at any extinction and 0. Cost: N² for N
//! layers in time and memory, for each group of bands with equal extinctions.
//!
//! | module | content |
//! |---|---|
//! | `layer_stack` | where the engine applies, and why not |
//! | `layered_operator` | the operator |

pub(crate) mod layer_stack;
mod layered_operator;

pub use layer_stack::LayerStack;
pub use layered_operator::LayeredOperator;
