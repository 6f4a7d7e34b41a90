//! The scenes of `zonal demo`: a chapel as a template of a scene file, a church generated from parameters.

mod chapel;
pub mod church;

pub use chapel::chapel_text;

/// Resolution of a scene of the demo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// For tests: seconds for the chapel, two bays of the church.
    Small,
    /// The chapel as the paper's figure 10, the church as its figures 11 and 12.
    Full,
}
