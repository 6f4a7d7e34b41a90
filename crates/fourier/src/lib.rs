//! Plans of fast Fourier transforms in double precision, by the crates rustfft and realfft.
//!
//! With ω = exp(−2πi/n), the forward transform of x_0 … x_{n−1} is X_k = Σ_j x_j ω^{jk}, and the inverse one Σ_k X_k ω^{−jk}, n times x_j; neither is scaled. The
//! transform of real values has the entries k = 0 … ⌊n/2⌋ alone.
//!
//! The planners of those crates are generic, and are compiled anew in each crate that calls them. Here they are compiled once.

pub use realfft::{ComplexToReal, RealToComplex};
pub use rustfft::Fft;
pub use rustfft::num_complex::Complex64;

use realfft::RealFftPlanner;
use rustfft::FftPlanner;
use std::sync::Arc;

/// Plans of transforms; those of one length share their tables.
pub struct Planner {
    complex: FftPlanner<f64>,
    real: RealFftPlanner<f64>,
}

impl Default for Planner {
    fn default() -> Planner {
        Planner { complex: FftPlanner::new(), real: RealFftPlanner::new() }
    }
}

impl Planner {
    /// The transform of `length` complex values.
    ///
    /// ```
    /// use zonal_fourier::{Complex64, Planner};
    /// let mut x = [1.0, 2.0, 4.0].map(Complex64::from);
    /// Planner::default().forward(3).process(&mut x);
    /// assert_eq!(x[0], Complex64::new(7.0, 0.0));
    /// ```
    pub fn forward(&mut self, length: usize) -> Arc<dyn Fft<f64>> {
        self.complex.plan_fft_forward(length)
    }
    /// The inverse transform of `length` complex values, times `length`.
    pub fn inverse(&mut self, length: usize) -> Arc<dyn Fft<f64>> {
        self.complex.plan_fft_inverse(length)
    }
    /// The transform of `length` real values.
    pub fn real_forward(&mut self, length: usize) -> Arc<dyn RealToComplex<f64>> {
        self.real.plan_fft_forward(length)
    }
    /// The inverse transform to `length` real values, times `length`.
    pub fn real_inverse(&mut self, length: usize) -> Arc<dyn ComplexToReal<f64>> {
        self.real.plan_fft_inverse(length)
    }
}
