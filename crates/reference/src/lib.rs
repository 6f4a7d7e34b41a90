//! Slow independent oracles, for tests.
//!
//! Nothing here is shared with the engines it checks: no tree, no quadrature, no walk from cell to cell, no cache. Every ray asks
//! every facet; integrals over scenes are means over random samples with their standard errors, and seeds make all of it repeatable.
//! Only [`judge`] and [`forward`], for whole scenes, have a tree, their own, checked against the walk over every facet.
//! Factors of aligned boxes come from closed forms along rays and a tanh–sinh rule, with an error of their own.
//!
//! | module | what |
//! |---|---|
//! | [`dice`] | random numbers, points and directions |
//! | [`world`] | a scene asked by brute force: the first facet, the medium and the panes along a ray |
//! | [`exchange`] | g_ij of two bodies: by pairs of points, or by rays from the one that score on the other |
//! | [`factors`] | aligned boxes and rectangles, attenuated or not, to thirteen digits |
//! | [`closed`] | aligned rectangles without a medium, corner sums in twice the precision |
//! | [`tanh_sinh`], [`wide`] | the rule and the numbers of 106 bits that they stand on |
//! | [`plane`] | view factors of walls in the plane, one behind the other, exactly |
//! | [`radiance`] | H of a plate and G in a box by random walks of light, without any zones |
//! | [`forward`] | power by name and by zone, temperatures too, by walks from the sources: of the continuous problem, or of the zones' own equations |
//! | [`judge`] | the same for scenes of any size, and pictures: an own tree, lights asked at every bounce |

pub mod closed;
pub mod dice;
pub mod exchange;
pub mod factors;
pub mod forward;
pub mod judge;
pub mod plane;
pub mod radiance;
pub mod tanh_sinh;
pub mod wide;
pub mod world;

pub use dice::Dice;
pub use exchange::Body;
pub use world::World;

/// A mean over random samples and its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// Mean.
    pub value: f64,
    /// Standard error of the mean.
    pub error: f64,
}

impl Estimate {
    /// The distance of `x` from the mean in standard errors, an extra absolute `slack` apart.
    pub fn z(&self, x: f64, slack: f64) -> f64 {
        let d = ((x - self.value).abs() - slack).max(0.0);
        if d == 0.0 { 0.0 } else { d / self.error.max(1e-300) }
    }
}

/// Sums that become an [`Estimate`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    n: f64,
    sum: f64,
    squares: f64,
}

impl Tally {
    /// Adds a sample.
    pub fn add(&mut self, x: f64) {
        self.n += 1.0;
        self.sum += x;
        self.squares += x * x;
    }
    /// The mean so far, times `scale`.
    pub fn estimate(&self, scale: f64) -> Estimate {
        let mean = self.sum / self.n;
        let variance = (self.squares / self.n - mean * mean).max(0.0) / (self.n - 1.0).max(1.0);
        Estimate { value: mean * scale, error: variance.sqrt() * scale.abs() }
    }
}
