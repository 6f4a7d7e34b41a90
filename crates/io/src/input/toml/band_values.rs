//! Values of bands: one number for all, one for each, or a spectrum.

use super::node::{SPECTRUM_KEYS, TomlNode, TomlTable};
use super::spectrum_keys::{SPECTRUM, Spectrum as SpectrumKeys};
use crate::input::reading::error::InputError;
use crate::input::tables::spectrum::Spectrum;
use std::rc::Rc;
use zonal_scene::Bands;

impl<'a> TomlNode<'a> {
    /// A property: one number for all bands, one per band, each from 0 to `max`, or the means of a spectrum.
    pub(crate) fn bands(&self, max: f64) -> Result<Bands, InputError> {
        let Some((table, spectrum)) = self.spectrum()? else { return self.numbers_of_bands(max) };
        let scale = table.or_default(&SPECTRUM.scale)?;
        if let Some(n) = table.get(&SPECTRUM.total) {
            return Err(n.error("a property has no total; give scale, or remove this key"));
        }
        let mean = |band: [f64; 2]| scale * spectrum.integral(band) / (band[1] - band[0]);
        let values: Vec<f64> = self.covered_bands(&spectrum)?.iter().map(|b| mean(*b)).collect();
        match values.iter().find(|x| **x > max) {
            Some(x) => Err(self.error(format!(
                "the mean over a band is {x}, and at most {max} is possible; give smaller values"
            ))),
            None => self.block_of_bands(&values, "").map(Bands::from_rgb),
        }
    }
    /// A flux: one number for all bands or one per band, each from 0, or the integrals of a spectrum.
    pub(crate) fn flux_bands(&self) -> Result<Bands, InputError> {
        let Some((table, spectrum)) = self.spectrum()? else { return self.numbers_of_bands(f64::INFINITY) };
        let bands = self.covered_bands(&spectrum)?;
        let integrals: Vec<f64> = bands.iter().map(|b| spectrum.integral(*b)).collect();
        let factor = match (table.get(&SPECTRUM.total), table.value(&SPECTRUM.scale)?) {
            (Some(n), Some(_)) => return Err(n.error("total and scale are both given; keep one of them")),
            (Some(n), None) => {
                let sum: f64 = integrals.iter().sum();
                if sum <= 0.0 {
                    return Err(n.error("the spectrum is 0 in all bands and has no total; give other bands or another spectrum"));
                }
                SPECTRUM.total.read(&n)? / sum
            }
            (None, scale) if table.get(&SPECTRUM.spectrum).is_some() => {
                scale.map_or_else(|| SPECTRUM.scale.default(), Ok)?
            }
            (None, _) => {
                return Err(
                    table.error("this spectrum is relative; give total, the sum over the bands of the scene")
                );
            }
        };
        let values: Vec<f64> = integrals.iter().map(|x| factor * x).collect();
        self.block_of_bands(&values, "").map(Bands::from_rgb)
    }
    /// A flux of light: in the bands of the scene, or in the band of sunlight.
    pub(crate) fn light(&self) -> Result<Bands, InputError> {
        let Some(in_solar_band) = self.solar_band() else { return self.flux_bands() };
        if self.is_list() {
            Err(self.error("in thermal mode sunlight has one band; give a number"))
        } else {
            self.non_negative().map(in_solar_band)
        }
    }
    /// The spectrum that a table names; none for other values.
    fn spectrum(&self) -> Result<Option<(TomlTable<'a>, Spectrum)>, InputError> {
        if !self.is_table() || self.is_value_file() {
            return Ok(None);
        }
        let t = self.table(SpectrumKeys::TABLE)?;
        let given: Vec<TomlNode> = SPECTRUM_KEYS.iter().filter_map(|k| t.get(k)).collect();
        if let [_, other, ..] = given.as_slice() {
            return Err(
                other.error("a spectrum has one source; keep one of spectrum, illuminant, black_body")
            );
        }
        let found = if let Some(kelvin) = t.value(&SPECTRUM.black_body)? {
            Spectrum::black_body(kelvin)
        } else if t.value(&SPECTRUM.illuminant)?.is_some() {
            Spectrum::d65()
        } else {
            let file = t.require(&SPECTRUM.spectrum)?;
            let column = t.or_default(&SPECTRUM.column)?;
            let (path, files) = file.named_file()?;
            let read = file.once(|| {
                let read = Spectrum::read(files, &path, &column);
                read.map_err(|f| t.get(&SPECTRUM.column).unwrap_or_else(|| file.clone()).error(f.to_string()))
            });
            Rc::unwrap_or_clone(read?)
        };
        Ok(Some((t, found)))
    }
    /// The limits of the bands, nm, all within the range of a spectrum.
    fn covered_bands(&self, spectrum: &Spectrum) -> Result<&'a [[f64; 2]], InputError> {
        let Some(bands) = self.source.bands().wavelengths() else {
            return Err(self.error("the bands of the scene have no wavelengths; write bands = [[400, 450], …] (nm), or give numbers"));
        };
        let [first, last] = spectrum.range();
        match bands.iter().find(|b| b[0] < first || b[1] > last) {
            Some([from, to]) => Err(self.error(format!(
                "the spectrum reaches from {first} to {last} nm, and a band from {from} to {to} nm; extend the spectrum or narrow the band"
            ))),
            None => Ok(bands),
        }
    }
    /// One number for all bands or one per band, each from 0 to `max`.
    fn numbers_of_bands(&self, max: f64) -> Result<Bands, InputError> {
        if !self.is_list() {
            return self.number_up_to(max).map(Bands::splat);
        }
        self.block_of_bands(&self.numbers_up_to(max)?, "a number or ").map(Bands::from_rgb)
    }
    /// As [`TomlNode::bands`]. A list may lack the value of the band of sunlight, which is then `solar`.
    pub(crate) fn bands_or_infrared(&self, max: f64, solar: f64) -> Result<Bands, InputError> {
        let bands = self.source.bands();
        if !bands.has_solar_band() || !self.is_list() {
            return self.bands(max);
        }
        let mut values = self.numbers_up_to(max)?;
        if values.len() == bands.infrared_count() {
            values.push(solar);
        }
        self.block_of_bands(&values, "a number or ").map(Bands::from_rgb)
    }
    fn numbers_up_to(&self, max: f64) -> Result<Vec<f64>, InputError> {
        self.list()?.iter().map(|n| n.number_up_to(max)).collect()
    }
    /// The values of the block of bands that is read, out of one value for each band; `also` names what may stand for the list in an error.
    pub(crate) fn block_of_bands<T: Clone + PartialEq>(
        &self,
        values: &[T],
        also: &str,
    ) -> Result<[T; 3], InputError> {
        let bands = self.source.bands();
        // Red, green and blue of a grey scene are one value.
        if let ([first, second, third], 1) = (values, bands.count()) {
            if first == second && second == third {
                return Ok([first.clone(), first.clone(), first.clone()]);
            }
            let what =
                "the bands differ, but a grey scene has one; give one number, or [thermal] band_fractions";
            return Err(self.error(what));
        }
        bands.of_block(self.source.block(), values).ok_or_else(|| {
            let wanted = if bands.is_rgb() {
                "[red, green, blue]".to_string()
            } else {
                let last = if bands.has_solar_band() { ", the last for sunlight" } else { "" };
                format!("a list of {} values, one for each band{last}", bands.count())
            };
            self.error(format!("this list has {} values; give {also}{wanted}", values.len()))
        })
    }
    /// The number of bands that emit by temperature, and those of them that the block that is read holds.
    pub(crate) fn band_window(&self) -> (usize, std::ops::Range<usize>) {
        let (bands, count) = (self.source.bands(), self.source.bands().infrared_count());
        let window = bands.window(self.source.block());
        (count, window.start.min(count)..window.end.min(count))
    }
    /// Puts a flux in the band of sunlight of the block that is read; none in scenes without that band.
    pub(crate) fn solar_band(&self) -> Option<impl FnOnce(f64) -> Bands + use<'a>> {
        let source = self.source;
        source
            .bands()
            .has_solar_band()
            .then_some(move |flux| source.bands().in_solar_band(source.block(), flux))
    }
}
