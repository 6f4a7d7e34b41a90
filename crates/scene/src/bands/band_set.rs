//! The spectral bands of a scene: their number, names and wavelengths.
//!
//! Scenes have 1 to [`MAX_BANDS`] bands. They are solved in blocks of three: block b holds the bands 3b, 3b+1 and 3b+2 in the
//! three values of [`crate::Bands`]. A scene of N bands has ⌈N/3⌉ blocks, which share its geometry
//! ([`crate::Scene::blocks`]). The values of the last block beyond the last band are copies of the last band. They have no emission in thermal
//! mode and appear in no result.
//!
//! A scene in thermal mode with lights has a last band for sunlight, which no temperature of the scene emits: surfaces and media have properties of
//! their own in it, and all lights send their power in it, except the infrared of planets.

use crate::bands::Bands;
use crate::base::scene_error::{SceneError, invalid};

/// Largest number of bands.
pub const MAX_BANDS: usize = 128;

/// Number of bands of a block.
pub(crate) const BANDS_PER_BLOCK: usize = 3;

/// Wavelengths between blue and green and between green and red, nm: where two primaries of sRGB contribute equally to the colour of a narrow band.
pub(crate) const COLOUR_LIMITS: [f64; 2] = [492.0, 577.0];

/// Range of wavelengths that bands may have, nm.
const WAVELENGTH_RANGE: [f64; 2] = [10.0, 1e6];

/// Number, names and wavelengths of the bands of a scene.
///
/// ```
/// use zonal_scene::BandSet;
/// let rgb = BandSet::default();
/// assert_eq!((rgb.count(), rgb.block_count(), rgb.name(2).as_str()), (3, 1, "blue"));
/// let gas = BandSet::numbered(5)?;
/// assert_eq!((gas.block_count(), gas.name(4).as_str()), (2, "band 4"));
/// assert_eq!(gas.window(1), 3..5);
/// let light = BandSet::by_wavelength(vec![[400.0, 500.0], [500.0, 600.0]])?;
/// assert_eq!(light.name(1), "500-600 nm");
/// assert!(BandSet::numbered(200).is_err());
/// # Ok::<(), zonal_scene::SceneError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct BandSet {
    count: usize,
    /// Limits of each band, nm; empty for bands without wavelengths.
    wavelengths: Vec<[f64; 2]>,
    /// True for the bands red, green and blue.
    is_rgb: bool,
    /// True if the last band is that of sunlight.
    has_solar_band: bool,
}

impl Default for BandSet {
    /// Red, green and blue.
    fn default() -> BandSet {
        BandSet { count: BANDS_PER_BLOCK, wavelengths: Vec::new(), is_rgb: true, has_solar_band: false }
    }
}

impl BandSet {
    /// The one band of a grey scene.
    ///
    /// ```
    /// use zonal_scene::BandSet;
    /// assert_eq!((BandSet::grey().count(), BandSet::grey().name(0).as_str()), (1, "grey"));
    /// ```
    pub fn grey() -> BandSet {
        BandSet { count: 1, wavelengths: Vec::new(), is_rgb: false, has_solar_band: false }
    }
    /// `count` bands without wavelengths.
    ///
    /// # Errors
    /// If `count` is 0 or above [`MAX_BANDS`].
    pub fn numbered(count: usize) -> Result<BandSet, SceneError> {
        if !(1..=MAX_BANDS).contains(&count) {
            return invalid("bands", format!("{count} bands are out of range; give 1 to {MAX_BANDS}"));
        }
        Ok(BandSet { count, wavelengths: Vec::new(), is_rgb: false, has_solar_band: false })
    }

    /// Bands between wavelengths [from, to] in nm, ascending and without overlap.
    ///
    /// # Errors
    /// If there are none or too many, or if a band is empty, out of range or overlaps the one before.
    pub fn by_wavelength(wavelengths: Vec<[f64; 2]>) -> Result<BandSet, SceneError> {
        let set = BandSet::numbered(wavelengths.len())?;
        let [least, most] = WAVELENGTH_RANGE;
        for (b, [from, to]) in wavelengths.iter().enumerate() {
            if !(*from >= least && from < to && *to <= most) {
                let message = format!(
                    "[{from}, {to}] is no range of wavelengths; give nanometres from {least} to {most:e}, the lower first"
                );
                return invalid(format!("bands[{b}]"), message);
            }
            if b > 0 && *from < wavelengths[b - 1][1] {
                let message = format!(
                    "begins at {from} nm, before the end of the band before it; give bands in ascending order without overlap"
                );
                return invalid(format!("bands[{b}]"), message);
            }
        }
        Ok(BandSet { wavelengths, ..set })
    }

    /// These bands of thermal emission, and a last one for sunlight.
    ///
    /// ```
    /// use zonal_scene::BandSet;
    /// let bands = BandSet::numbered(1)?.with_solar_band()?;
    /// assert_eq!((bands.count(), bands.infrared_count()), (2, 1));
    /// assert_eq!((bands.name(0).as_str(), bands.name(1).as_str()), ("infrared", "solar"));
    /// assert_eq!(bands.in_solar_band(0, 800.0).to_rgb(), [0.0, 800.0, 0.0]);
    /// # Ok::<(), zonal_scene::SceneError>(())
    /// ```
    ///
    /// # Errors
    /// If the bands have wavelengths, or if there are too many.
    pub fn with_solar_band(self) -> Result<BandSet, SceneError> {
        if !self.wavelengths.is_empty() {
            let what = "bands with wavelengths have no separate sunlight; give the number of infrared bands, or remove the lights";
            return invalid("bands", what);
        }
        Ok(BandSet { has_solar_band: true, ..BandSet::numbered(self.count + 1)? })
    }

    /// Number of bands.
    pub fn count(&self) -> usize {
        self.count
    }
    /// True if the last band is that of sunlight.
    pub fn has_solar_band(&self) -> bool {
        self.has_solar_band
    }
    /// Number of bands without that of sunlight.
    pub fn infrared_count(&self) -> usize {
        self.count - usize::from(self.has_solar_band)
    }
    /// A flux in the band of sunlight, as values of a block; 0 in all other bands.
    pub fn in_solar_band(&self, block: usize, flux: f64) -> Bands {
        let own = |k: usize| self.has_solar_band && BANDS_PER_BLOCK * block + k + 1 == self.count;
        Bands::from_fn(|b| if own(b.index()) { flux } else { 0.0 })
    }
    /// Values of a block with another property in the band of sunlight.
    pub fn with_solar_value(&self, block: usize, values: Bands, solar: f64) -> Bands {
        // What fills up the last block is a copy of the last band.
        let own = |k: usize| self.has_solar_band && BANDS_PER_BLOCK * block + k + 1 >= self.count;
        Bands::from_fn(|b| if own(b.index()) { solar } else { values[b] })
    }
    /// Number of blocks that hold the bands.
    pub fn block_count(&self) -> usize {
        self.count.div_ceil(BANDS_PER_BLOCK)
    }
    /// The bands of a block.
    pub fn window(&self, block: usize) -> std::ops::Range<usize> {
        let first = BANDS_PER_BLOCK * block;
        first.min(self.count)..(first + BANDS_PER_BLOCK).min(self.count)
    }
    /// Limits of each band in nm, ascending; `None` for bands without wavelengths.
    pub fn wavelengths(&self) -> Option<&[[f64; 2]]> {
        (!self.wavelengths.is_empty()).then_some(self.wavelengths.as_slice())
    }
    /// True for the bands red, green and blue.
    pub fn is_rgb(&self) -> bool {
        self.is_rgb
    }
    /// Name of a band: a colour, a range of wavelengths, `grey` of one band without wavelengths, or its number from 0.
    pub fn name(&self, band: usize) -> String {
        match self.wavelengths.get(band) {
            Some([from, to]) => format!("{from}-{to} nm"),
            None if self.has_solar_band && band + 1 == self.count => "solar".into(),
            None if self.has_solar_band && self.count == 2 => "infrared".into(),
            None if self.is_rgb && band < BANDS_PER_BLOCK => ["red", "green", "blue"][band].into(),
            None if self.count == 1 => "grey".into(),
            None => format!("band {band}"),
        }
    }
    /// The values of the bands of a block for the colour of a file or picture; `None` if the bands have neither colours nor wavelengths and the colour is
    /// not grey. With wavelengths, blue, green and red stand for the spectrum below, between and above 492 nm and 577 nm.
    ///
    /// ```
    /// use zonal_scene::{BandSet, Bands};
    /// assert_eq!(BandSet::default().from_rgb(0, [0.1, 0.2, 0.3]), Some(Bands::from_rgb([0.1, 0.2, 0.3])));
    /// let light = BandSet::by_wavelength(vec![[400.0, 450.0], [550.0, 595.0]])?;
    /// let orange = light.from_rgb(0, [1.0, 0.5, 0.0]).unwrap().to_rgb();
    /// assert!(orange[0] == 0.0 && (orange[1] - 0.75).abs() < 0.1);
    /// assert_eq!(BandSet::numbered(5)?.from_rgb(0, [1.0, 0.5, 0.0]), None);
    /// # Ok::<(), zonal_scene::SceneError>(())
    /// ```
    pub fn from_rgb(&self, block: usize, rgb: [f64; 3]) -> Option<Bands> {
        if self.is_rgb {
            return Some(Bands::from_rgb(rgb));
        }
        let [red, green, blue] = rgb;
        if red == green && green == blue {
            return Some(Bands::splat(red));
        }
        let [low, high] = COLOUR_LIMITS;
        let of_band = |[from, to]: [f64; 2]| {
            let within = |a: f64, b: f64| (to.min(b) - from.max(a)).max(0.0) / (to - from);
            blue * within(0.0, low) + green * within(low, high) + red * within(high, f64::INFINITY)
        };
        let values: Vec<f64> = self.wavelengths.iter().map(|w| of_band(*w)).collect();
        self.of_block(block, &values).map(Bands::from_rgb)
    }
    /// The values of one block out of a list of one value for each band; the last band fills up the last block.
    ///
    /// ```
    /// use zonal_scene::BandSet;
    /// let bands = BandSet::numbered(4)?;
    /// assert_eq!(bands.of_block(1, &[1, 2, 3, 4]), Some([4, 4, 4]));
    /// assert_eq!(bands.of_block(0, &[1, 2, 3]), None);
    /// # Ok::<(), zonal_scene::SceneError>(())
    /// ```
    pub fn of_block<T: Clone>(&self, block: usize, values: &[T]) -> Option<[T; BANDS_PER_BLOCK]> {
        let last = self.count - 1;
        (values.len() == self.count)
            .then(|| std::array::from_fn(|k| values[(BANDS_PER_BLOCK * block + k).min(last)].clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlapping_empty_and_missing_bands_are_refused() {
        for list in [vec![], vec![[500.0, 400.0]], vec![[400.0, 500.0], [450.0, 600.0]], vec![[0.0, 5.0]]] {
            assert!(BandSet::by_wavelength(list).is_err());
        }
        assert!(BandSet::numbered(0).is_err() && BandSet::numbered(MAX_BANDS).is_ok());
    }
}
