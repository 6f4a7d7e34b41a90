//! Complex arrays as arrays of real and imaginary parts, so that products with real numbers are loops without shuffles.

use pulp::num_complex::Complex64;

/// The real and the imaginary part of each number in turn.
///
/// ```
/// let z = [pulp::c64::new(1.0, 2.0), pulp::c64::new(3.0, 4.0)];
/// assert_eq!(zonal_math::simd::complex_parts(&z), [1.0, 2.0, 3.0, 4.0]);
/// ```
#[inline(always)]
pub fn complex_parts(z: &[Complex64]) -> &[f64] {
    pulp::bytemuck::cast_slice(z)
}

/// As [`complex_parts`], to be changed.
///
/// ```
/// let mut z = [pulp::c64::new(1.0, 2.0)];
/// zonal_math::simd::complex_parts_mut(&mut z)[1] = 5.0;
/// assert_eq!(z[0].im, 5.0);
/// ```
#[inline(always)]
pub fn complex_parts_mut(z: &mut [Complex64]) -> &mut [f64] {
    pulp::bytemuck::cast_slice_mut(z)
}
