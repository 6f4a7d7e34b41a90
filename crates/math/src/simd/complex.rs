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

/// The bytes of complex numbers, real and imaginary parts in turn, in the order of the machine.
///
/// ```
/// let z = [pulp::c64::new(1.0, 2.0)];
/// assert_eq!(zonal_math::simd::complex_bytes(&z)[8..], 2.0f64.to_ne_bytes());
/// ```
pub fn complex_bytes(z: &[Complex64]) -> &[u8] {
    pulp::bytemuck::cast_slice(z)
}

/// As [`complex_bytes`], to be changed.
///
/// ```
/// let mut z = [pulp::c64::new(1.0, 2.0)];
/// zonal_math::simd::complex_bytes_mut(&mut z)[..8].copy_from_slice(&5.0f64.to_ne_bytes());
/// assert_eq!(z[0].re, 5.0);
/// ```
pub fn complex_bytes_mut(z: &mut [Complex64]) -> &mut [u8] {
    pulp::bytemuck::cast_slice_mut(z)
}
