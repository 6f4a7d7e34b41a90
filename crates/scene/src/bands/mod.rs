//! Band-indexed numbers with operators, as the spectra of pbrt.
//!
//! [`Bands`] holds one `f64` for each spectral band, [`PerBand`] one `T`. All operations act element by element in the order of the bands,
//! so that an expression on [`Bands`] returns the bits of the same expression on its elements; [`Bands::sum`] adds in ascending order.
//! Code outside this module and `band` uses [`Band::all`], [`Bands::from_fn`] and the iterators, and does not depend on the number of
//! bands or on the storage.

pub(crate) mod band;
pub(crate) mod band_set;
pub(crate) mod black_body_bands;

use crate::bands::band::{BAND_COUNT, Band, BandCountError, PerBand, band_array};
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, DivAssign, Index, IndexMut, Mul, MulAssign, Neg, Sub, SubAssign};

/// One `f64` for each band.
///
/// ```
/// use zonal_scene::Bands;
/// let reflectance = Bands::from_rgb([0.5, 0.25, 0.0]);
/// let irradiance = Bands::splat(8.0);
/// let emission = Bands::from_rgb([0.0, 0.0, 1.0]);
/// let radiosity = emission + reflectance * irradiance;
/// assert_eq!(radiosity.to_rgb(), [4.0, 2.0, 1.0]);
/// assert_eq!((radiosity.sum(), radiosity.max_element()), (7.0, 4.0));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bands {
    values: [f64; BAND_COUNT],
}

impl Bands {
    /// Zero in every band.
    pub const ZERO: Bands = Bands::splat(0.0);
    /// One in every band.
    pub const ONE: Bands = Bands::splat(1.0);

    /// The same value in every band.
    ///
    /// ```
    /// use zonal_scene::Bands;
    /// assert_eq!(Bands::splat(2.0), Bands::ONE * 2.0);
    /// ```
    #[inline]
    pub const fn splat(value: f64) -> Bands {
        Bands { values: [value; BAND_COUNT] }
    }
    /// Evaluates `f` for each band, ascending.
    ///
    /// ```
    /// use zonal_scene::Bands;
    /// let b = Bands::from_fn(|band| 10.0 * band.index() as f64);
    /// assert_eq!(b.as_slice(), [0.0, 10.0, 20.0]);
    /// ```
    #[inline]
    pub fn from_fn(f: impl FnMut(Band) -> f64) -> Bands {
        Bands { values: PerBand::from_fn(f).into_rgb() }
    }
    /// The bands of a red-green-blue triple of a file or picture.
    ///
    /// ```
    /// use zonal_scene::Bands;
    /// assert_eq!(Bands::from_rgb([0.25, 0.5, 1.0]).to_rgb(), [0.25, 0.5, 1.0]);
    /// ```
    #[inline]
    pub const fn from_rgb(rgb: [f64; 3]) -> Bands {
        Bands { values: rgb }
    }
    /// The red-green-blue triple of a file or picture.
    #[inline]
    pub const fn to_rgb(self) -> [f64; 3] {
        self.values
    }
    /// The values, ascending by band.
    #[inline]
    pub fn as_slice(&self) -> &[f64] {
        &self.values
    }
    /// Applies `f` to each value.
    ///
    /// ```
    /// use zonal_scene::Bands;
    /// assert_eq!(Bands::from_rgb([1.0, 4.0, 9.0]).map(f64::sqrt).to_rgb(), [1.0, 2.0, 3.0]);
    /// ```
    #[inline]
    pub fn map(self, f: impl FnMut(f64) -> f64) -> Bands {
        Bands { values: self.values.map(f) }
    }
    /// Combines the values of each band by `f`.
    ///
    /// ```
    /// use zonal_scene::Bands;
    /// let ratio = Bands::from_rgb([1.0, 2.0, 0.0])
    ///     .zip_map(Bands::from_rgb([2.0, 2.0, 0.0]), |a, b| if b > 0.0 { a / b } else { 0.0 });
    /// assert_eq!(ratio.to_rgb(), [0.5, 1.0, 0.0]);
    /// ```
    #[inline]
    pub fn zip_map(self, other: Bands, mut f: impl FnMut(f64, f64) -> f64) -> Bands {
        Bands { values: std::array::from_fn(|k| f(self.values[k], other.values[k])) }
    }
    /// One `T` for each band, computed from its value.
    ///
    /// ```
    /// use zonal_scene::Bands;
    /// let positive = Bands::from_rgb([0.0, 1.0, 2.0]).map_to(|x| x > 0.0);
    /// assert!(positive.any(|p| *p) && !positive.all(|p| *p));
    /// ```
    #[inline]
    pub fn map_to<T>(self, f: impl FnMut(f64) -> T) -> PerBand<T> {
        PerBand::from_rgb(self.values.map(f))
    }
    /// The values, ascending by band.
    #[inline]
    pub fn iter(&self) -> std::slice::Iter<'_, f64> {
        self.values.iter()
    }
    /// The values for modification, ascending by band.
    ///
    /// ```
    /// use zonal_scene::Bands;
    /// let mut b = Bands::ONE;
    /// b.iter_mut().for_each(|x| *x *= 3.0);
    /// assert_eq!(b, Bands::splat(3.0));
    /// ```
    #[inline]
    pub fn iter_mut(&mut self) -> std::slice::IterMut<'_, f64> {
        self.values.iter_mut()
    }
    /// Sum over the bands, ascending from the first value.
    ///
    /// ```
    /// use zonal_scene::Bands;
    /// let x = [0.1, 0.2, 0.3];
    /// assert_eq!(Bands::from_rgb(x).sum().to_bits(), (x[0] + x[1] + x[2]).to_bits());
    /// ```
    #[inline]
    pub fn sum(self) -> f64 {
        self.values.iter().sum()
    }
    /// Mean over the bands: the sum over the number of bands.
    ///
    /// ```
    /// use zonal_scene::Bands;
    /// assert_eq!(Bands::from_rgb([1.0, 2.0, 6.0]).mean(), 3.0);
    /// ```
    #[inline]
    pub fn mean(self) -> f64 {
        self.sum() / BAND_COUNT as f64
    }
    /// Largest value; NaN values are ignored unless all are NaN.
    #[inline]
    pub fn max_element(self) -> f64 {
        self.values.iter().copied().fold(f64::NAN, f64::max)
    }
    /// Smallest value; NaN values are ignored unless all are NaN.
    ///
    /// ```
    /// use zonal_scene::Bands;
    /// let b = Bands::from_rgb([2.0, -1.0, f64::NAN]);
    /// assert_eq!((b.min_element(), b.max_element()), (-1.0, 2.0));
    /// ```
    #[inline]
    pub fn min_element(self) -> f64 {
        self.values.iter().copied().fold(f64::NAN, f64::min)
    }
    /// Modulus of each value.
    #[inline]
    pub fn abs(self) -> Bands {
        self.map(f64::abs)
    }
    /// Larger value of each band, as [`f64::max`].
    ///
    /// ```
    /// use zonal_scene::Bands;
    /// let (a, b) = (Bands::from_rgb([1.0, -5.0, 0.0]), Bands::from_rgb([0.0, 2.0, 0.0]));
    /// assert_eq!(a.max(b).to_rgb(), [1.0, 2.0, 0.0]);
    /// assert_eq!(a.min(b).to_rgb(), [0.0, -5.0, 0.0]);
    /// assert_eq!(a.abs().to_rgb(), [1.0, 5.0, 0.0]);
    /// ```
    #[inline]
    pub fn max(self, other: Bands) -> Bands {
        self.zip_map(other, f64::max)
    }
    /// Smaller value of each band, as [`f64::min`].
    #[inline]
    pub fn min(self, other: Bands) -> Bands {
        self.zip_map(other, f64::min)
    }
    /// Square root of each value.
    #[inline]
    pub fn sqrt(self) -> Bands {
        self.map(f64::sqrt)
    }
    /// Exponential of each value.
    #[inline]
    pub fn exp(self) -> Bands {
        self.map(f64::exp)
    }
    /// √(a² + b²) of the values of each band, as [`f64::hypot`].
    ///
    /// ```
    /// use zonal_scene::Bands;
    /// assert_eq!(Bands::splat(3.0).hypot(Bands::splat(4.0)), Bands::splat(5.0));
    /// ```
    #[inline]
    pub fn hypot(self, other: Bands) -> Bands {
        self.zip_map(other, f64::hypot)
    }
    /// The value of the first band: of a grey quantity, its value.
    #[inline]
    pub fn first(self) -> f64 {
        self.values[0]
    }
    /// True if all bands have the same value.
    ///
    /// ```
    /// use zonal_scene::Bands;
    /// assert!(Bands::splat(0.5).is_grey() && !Bands::from_rgb([0.5, 0.5, 0.6]).is_grey());
    /// ```
    #[inline]
    pub fn is_grey(self) -> bool {
        self.values.windows(2).all(|w| w[0] == w[1])
    }
    /// True if no value is NaN or infinite.
    ///
    /// ```
    /// use zonal_scene::Bands;
    /// assert!(Bands::ONE.is_finite() && !(Bands::ONE / 0.0).is_finite());
    /// ```
    #[inline]
    pub fn is_finite(self) -> bool {
        self.all(f64::is_finite)
    }
    /// True if `predicate` holds in any band.
    #[inline]
    pub fn any(self, predicate: impl FnMut(f64) -> bool) -> bool {
        self.values.into_iter().any(predicate)
    }
    /// True if `predicate` holds in all bands.
    ///
    /// ```
    /// use zonal_scene::Bands;
    /// let b = Bands::from_rgb([0.0, 0.5, 1.0]);
    /// assert!(b.all(|x| (0.0..=1.0).contains(&x)) && b.any(|x| x == 1.0));
    /// ```
    #[inline]
    pub fn all(self, predicate: impl FnMut(f64) -> bool) -> bool {
        self.values.into_iter().all(predicate)
    }
}

impl Index<Band> for Bands {
    type Output = f64;
    #[inline]
    fn index(&self, band: Band) -> &f64 {
        &self.values[band.index()]
    }
}

impl IndexMut<Band> for Bands {
    #[inline]
    fn index_mut(&mut self, band: Band) -> &mut f64 {
        &mut self.values[band.index()]
    }
}

/// Implements a binary operator for two [`Bands`] and for [`Bands`] with a number, by value and by reference, and its assigning form.
macro_rules! elementwise {
    ($operator:ident, $method:ident, $assigning:ident, $assign_method:ident, $symbol:tt) => {
        impl $operator for Bands {
            type Output = Bands;
            #[inline]
            fn $method(self, other: Bands) -> Bands {
                self.zip_map(other, |a, b| a $symbol b)
            }
        }
        impl $operator<f64> for Bands {
            type Output = Bands;
            #[inline]
            fn $method(self, other: f64) -> Bands {
                self.map(|a| a $symbol other)
            }
        }
        impl $operator<Bands> for f64 {
            type Output = Bands;
            #[inline]
            fn $method(self, other: Bands) -> Bands {
                other.map(|b| self $symbol b)
            }
        }
        impl $operator<&Bands> for Bands {
            type Output = Bands;
            #[inline]
            fn $method(self, other: &Bands) -> Bands {
                self $symbol *other
            }
        }
        impl $operator<Bands> for &Bands {
            type Output = Bands;
            #[inline]
            fn $method(self, other: Bands) -> Bands {
                *self $symbol other
            }
        }
        impl $operator<&Bands> for &Bands {
            type Output = Bands;
            #[inline]
            fn $method(self, other: &Bands) -> Bands {
                *self $symbol *other
            }
        }
        impl $operator<f64> for &Bands {
            type Output = Bands;
            #[inline]
            fn $method(self, other: f64) -> Bands {
                *self $symbol other
            }
        }
        impl $operator<&Bands> for f64 {
            type Output = Bands;
            #[inline]
            fn $method(self, other: &Bands) -> Bands {
                self $symbol *other
            }
        }
        impl $assigning<&Bands> for Bands {
            #[inline]
            fn $assign_method(&mut self, other: &Bands) {
                *self = *self $symbol *other;
            }
        }
        impl $assigning for Bands {
            #[inline]
            fn $assign_method(&mut self, other: Bands) {
                *self = *self $symbol other;
            }
        }
        impl $assigning<f64> for Bands {
            #[inline]
            fn $assign_method(&mut self, other: f64) {
                *self = *self $symbol other;
            }
        }
    };
}

elementwise!(Add, add, AddAssign, add_assign, +);
elementwise!(Sub, sub, SubAssign, sub_assign, -);
elementwise!(Mul, mul, MulAssign, mul_assign, *);
elementwise!(Div, div, DivAssign, div_assign, /);

impl Neg for Bands {
    type Output = Bands;
    #[inline]
    fn neg(self) -> Bands {
        self.map(|x| -x)
    }
}

impl Neg for &Bands {
    type Output = Bands;
    #[inline]
    fn neg(self) -> Bands {
        -*self
    }
}

impl Sum for Bands {
    /// Adds the terms in order to zero.
    ///
    /// ```
    /// use zonal_scene::Bands;
    /// let total: Bands = [Bands::ONE, Bands::splat(2.0)].into_iter().sum();
    /// assert_eq!(total, Bands::splat(3.0));
    /// ```
    #[inline]
    fn sum<I: Iterator<Item = Bands>>(terms: I) -> Bands {
        terms.fold(Bands::ZERO, Add::add)
    }
}

impl<'a> Sum<&'a Bands> for Bands {
    #[inline]
    fn sum<I: Iterator<Item = &'a Bands>>(terms: I) -> Bands {
        terms.copied().sum()
    }
}

impl TryFrom<&[f64]> for Bands {
    type Error = BandCountError;
    /// The values of a slice, ascending by band.
    ///
    /// # Errors
    /// If the number of values is not the number of bands.
    ///
    /// ```
    /// use zonal_scene::Bands;
    /// assert_eq!(Bands::try_from(&[1.0, 2.0, 3.0][..]), Ok(Bands::from_rgb([1.0, 2.0, 3.0])));
    /// assert_eq!(Bands::try_from(&[1.0][..]).unwrap_err().to_string(), "1 values for 3 bands");
    /// ```
    #[inline]
    fn try_from(values: &[f64]) -> Result<Bands, BandCountError> {
        band_array(values).map(|values| Bands { values })
    }
}

impl AsRef<[f64]> for Bands {
    #[inline]
    fn as_ref(&self) -> &[f64] {
        self.as_slice()
    }
}

impl IntoIterator for Bands {
    type Item = f64;
    type IntoIter = std::array::IntoIter<f64, BAND_COUNT>;
    #[inline]
    fn into_iter(self) -> Self::IntoIter {
        self.values.into_iter()
    }
}

impl<'a> IntoIterator for &'a Bands {
    type Item = &'a f64;
    type IntoIter = std::slice::Iter<'a, f64>;
    #[inline]
    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<'a> IntoIterator for &'a mut Bands {
    type Item = &'a mut f64;
    type IntoIter = std::slice::IterMut<'a, f64>;
    #[inline]
    fn into_iter(self) -> Self::IntoIter {
        self.iter_mut()
    }
}

impl From<Bands> for PerBand<f64> {
    #[inline]
    fn from(bands: Bands) -> PerBand<f64> {
        PerBand::from_rgb(bands.values)
    }
}

impl From<PerBand<f64>> for Bands {
    #[inline]
    fn from(values: PerBand<f64>) -> Bands {
        Bands::from_rgb(values.into_rgb())
    }
}

impl<T> PerBand<T> {
    /// Applies `f` to each value to obtain numbers.
    ///
    /// ```
    /// use zonal_scene::{Bands, PerBand};
    /// assert_eq!(PerBand::from_rgb([1u64, 2, 3]).map_to_bands(|n| n as f64).sum(), 6.0);
    /// ```
    #[inline]
    pub fn map_to_bands(self, f: impl FnMut(T) -> f64) -> Bands {
        Bands::from_rgb(self.into_rgb().map(f))
    }
}
