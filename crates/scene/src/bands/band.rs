//! Spectral bands as indices, and one value of any type for each band.

use std::ops::{Index, IndexMut};

/// Number of bands: red, green and blue in pictures.
pub(crate) const BAND_COUNT: usize = 3;

/// Index of a spectral band.
///
/// ```
/// use zonal_scene::{Band, Bands};
/// let power = Bands::from_rgb([1.0, 2.0, 4.0]);
/// let indices: Vec<usize> = Band::all().map(Band::index).collect();
/// assert_eq!(indices, [0, 1, 2]);
/// assert_eq!(Band::all().map(|b| power[b]).fold(0.0, f64::max), 4.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Band(usize);

impl Band {
    /// The band with this index, if there is one.
    ///
    /// ```
    /// use zonal_scene::Band;
    /// assert_eq!(Band::new(1).map(Band::index), Some(1));
    /// assert_eq!(Band::new(Band::count()), None);
    /// ```
    #[inline]
    pub fn new(index: usize) -> Option<Band> {
        (index < BAND_COUNT).then_some(Band(index))
    }
    /// The first band, which stands for all bands of a grey scene.
    #[inline]
    pub const fn first() -> Band {
        Band(0)
    }
    /// Number of bands.
    #[inline]
    pub fn count() -> usize {
        BAND_COUNT
    }
    /// All bands, ascending.
    #[inline]
    pub fn all() -> impl DoubleEndedIterator<Item = Band> + ExactSizeIterator + Clone {
        (0..BAND_COUNT).map(Band)
    }
    /// Position of the band, from 0.
    #[inline]
    pub fn index(self) -> usize {
        self.0
    }
}

/// One `T` for each band.
///
/// ```
/// use zonal_scene::{Band, PerBand};
/// let mut residuals: PerBand<Vec<f64>> = PerBand::default();
/// for band in Band::all() {
///     residuals[band].push(0.5);
/// }
/// let lengths = residuals.as_ref().map(Vec::len);
/// assert!(lengths.all(|n| n == 1));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct PerBand<T> {
    pub(super) values: [T; BAND_COUNT],
}

impl<T> PerBand<T> {
    /// Evaluates `f` for each band, ascending.
    ///
    /// ```
    /// use zonal_scene::PerBand;
    /// let names = PerBand::from_fn(|band| format!("band {}", band.index()));
    /// assert_eq!(names.iter().last().unwrap(), "band 2");
    /// ```
    #[inline]
    pub fn from_fn(mut f: impl FnMut(Band) -> T) -> PerBand<T> {
        PerBand { values: [f(Band(0)), f(Band(1)), f(Band(2))] }
    }
    /// The same value in every band.
    ///
    /// ```
    /// use zonal_scene::Bands;
    /// assert_eq!(Bands::splat(2.0), Bands::ONE * 2.0);
    /// ```
    #[inline]
    pub const fn splat(value: T) -> PerBand<T>
    where
        T: Copy,
    {
        PerBand { values: [value; BAND_COUNT] }
    }
    /// The values of the triple of a file or picture.
    ///
    /// ```
    /// use zonal_scene::Bands;
    /// assert_eq!(Bands::from_rgb([0.25, 0.5, 1.0]).to_rgb(), [0.25, 0.5, 1.0]);
    /// ```
    #[inline]
    pub const fn from_rgb(rgb: [T; 3]) -> PerBand<T> {
        PerBand { values: rgb }
    }
    /// The triple of a file or picture.
    ///
    /// ```
    /// use zonal_scene::PerBand;
    /// assert_eq!(PerBand::from_rgb([1u8, 2, 3]).into_rgb(), [1, 2, 3]);
    /// ```
    #[inline]
    pub fn into_rgb(self) -> [T; 3] {
        self.values
    }
    /// The values, ascending by band.
    #[inline]
    pub fn as_slice(&self) -> &[T] {
        &self.values
    }
    /// References to the values.
    #[inline]
    pub fn as_ref(&self) -> PerBand<&T> {
        PerBand { values: self.values.each_ref() }
    }
    /// Mutable references to the values.
    #[inline]
    pub fn as_mut(&mut self) -> PerBand<&mut T> {
        PerBand { values: self.values.each_mut() }
    }
    /// Applies `f` to each value.
    ///
    /// ```
    /// use zonal_scene::Bands;
    /// assert_eq!(Bands::from_rgb([1.0, 4.0, 9.0]).map(f64::sqrt).to_rgb(), [1.0, 2.0, 3.0]);
    /// let positive = Bands::from_rgb([0.0, 1.0, 2.0]).map(|x| x > 0.0);
    /// assert!(positive.any(|p| p) && !positive.all(|p| p));
    /// ```
    #[inline]
    pub fn map<U>(self, mut f: impl FnMut(T) -> U) -> PerBand<U> {
        let [a, b, c] = self.values;
        PerBand { values: [f(a), f(b), f(c)] }
    }
    /// Combines the values of each band by `f`.
    ///
    /// ```
    /// use zonal_scene::PerBand;
    /// use zonal_scene::Bands;
    /// let ratio = Bands::from_rgb([1.0, 2.0, 0.0])
    ///     .zip_map(Bands::from_rgb([2.0, 2.0, 0.0]), |a, b| if b > 0.0 { a / b } else { 0.0 });
    /// assert_eq!(ratio.to_rgb(), [0.5, 1.0, 0.0]);
    /// let both = PerBand::from_rgb([true, true, false])
    ///     .zip_map(PerBand::from_rgb([true, false, false]), |a, b| a && b);
    /// assert_eq!(both.into_rgb(), [true, false, false]);
    /// ```
    #[inline]
    pub fn zip_map<U, V>(self, other: PerBand<U>, mut f: impl FnMut(T, U) -> V) -> PerBand<V> {
        let ([a, b, c], [x, y, z]) = (self.values, other.values);
        PerBand { values: [f(a, x), f(b, y), f(c, z)] }
    }
    /// The values, ascending by band.
    #[inline]
    pub fn iter(&self) -> std::slice::Iter<'_, T> {
        self.values.iter()
    }
    /// The values for modification, ascending by band.
    #[inline]
    pub fn iter_mut(&mut self) -> std::slice::IterMut<'_, T> {
        self.values.iter_mut()
    }
    /// True if `predicate` holds in any band.
    #[inline]
    pub fn any(self, predicate: impl FnMut(T) -> bool) -> bool {
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
    pub fn all(self, predicate: impl FnMut(T) -> bool) -> bool {
        self.values.into_iter().all(predicate)
    }
}

impl<T> Index<Band> for PerBand<T> {
    type Output = T;
    #[inline]
    fn index(&self, band: Band) -> &T {
        &self.values[band.0]
    }
}

impl<T> IndexMut<Band> for PerBand<T> {
    #[inline]
    fn index_mut(&mut self, band: Band) -> &mut T {
        &mut self.values[band.0]
    }
}

impl<T: Copy> TryFrom<&[T]> for PerBand<T> {
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
    fn try_from(values: &[T]) -> Result<PerBand<T>, BandCountError> {
        let error = |_| BandCountError { found: values.len(), expected: BAND_COUNT };
        values.try_into().map(|values| PerBand { values }).map_err(error)
    }
}

impl<T> IntoIterator for PerBand<T> {
    type Item = T;
    type IntoIter = std::array::IntoIter<T, BAND_COUNT>;
    #[inline]
    fn into_iter(self) -> Self::IntoIter {
        self.values.into_iter()
    }
}

impl<'a, T> IntoIterator for &'a PerBand<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;
    #[inline]
    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<'a, T> IntoIterator for &'a mut PerBand<T> {
    type Item = &'a mut T;
    type IntoIter = std::slice::IterMut<'a, T>;
    #[inline]
    fn into_iter(self) -> Self::IntoIter {
        self.iter_mut()
    }
}

/// The number of values of a slice differs from the number of bands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BandCountError {
    /// Number of values of the slice.
    pub found: usize,
    /// Number of bands.
    pub expected: usize,
}

impl std::fmt::Display for BandCountError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} values for {} bands", self.found, self.expected)
    }
}

impl std::error::Error for BandCountError {}
