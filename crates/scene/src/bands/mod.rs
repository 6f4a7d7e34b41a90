//! Band-indexed numbers with operators, as the spectra of pbrt.
//!
//! [`PerBand`] holds one `T` for each spectral band, [`Bands`] one `f64`. All operations act element by element in the order of the bands,
//! so that an expression on [`Bands`] returns the bits of the same expression on its elements; [`Bands::sum`] adds in ascending order.
//! Code outside this module and `band` uses [`Band::all`], [`Bands::from_fn`] and the iterators, and does not depend on the number of
//! bands or on the storage.

pub(crate) mod band;
pub(crate) mod band_set;
pub(crate) mod black_body_bands;
pub mod encoding;

use crate::bands::band::{BAND_COUNT, PerBand};
use crate::base::scene_error::{SceneError, invalid};
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// One `f64` for each band, with operators.
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
pub type Bands = PerBand<f64>;

impl Bands {
    /// Zero in every band.
    pub const ZERO: Bands = Bands::splat(0.0);
    /// One in every band.
    pub const ONE: Bands = Bands::splat(1.0);

    /// Refuses values that are negative, above `max` or not numbers; `key` is that of the error.
    pub(crate) fn check(self, key: &str, max: f64) -> Result<(), SceneError> {
        match self.iter().find(|x| !(0.0..=max).contains(*x)) {
            Some(x) => invalid(key, format!("{x:e} is out of range; give values from 0 to {max:e}")),
            None => Ok(()),
        }
    }
    /// The red-green-blue triple of a file or picture.
    #[inline]
    pub const fn to_rgb(self) -> [f64; 3] {
        self.values
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

impl AsRef<[f64]> for Bands {
    #[inline]
    fn as_ref(&self) -> &[f64] {
        self.as_slice()
    }
}
