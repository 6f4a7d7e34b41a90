//! Typed reading of a TOML document. Every value carries its key and its place.

use super::keys::{KeyGroups, knows, names};
use super::light_keys::SPECTRUM;
use super::source::SourceText;
use crate::input::reading::error::InputError;
use crate::input::reading::suggestion::suggest;
use crate::input::tables::spectrum::Spectrum;
use std::ops::Range;
use std::rc::Rc;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use zonal_math::Vec3;
use zonal_scene::Bands;

/// Keys of which values by temperature have one.
const TEMPERATURE_KEYS: [&str; 2] = ["temperatures", "by_temperature"];
/// Keys of which a spectrum has one.
pub(crate) const SPECTRUM_KEYS: [&str; 3] = ["spectrum", "illuminant", "black_body"];

/// A value with its key and place.
#[derive(Clone)]
pub(crate) struct TomlNode<'a> {
    source: &'a SourceText<'a>,
    value: &'a DeValue<'a>,
    span: Range<usize>,
    pub(crate) key: String,
}

/// A table.
pub(crate) struct TomlTable<'a> {
    pub(crate) source: &'a SourceText<'a>,
    map: &'a DeTable<'a>,
    offset: usize,
    pub(crate) key: String,
}

/// Words of earlier versions, and those that stand for them.
const RENAMED_WORDS: [(&str, &str); 2] = [("rays", "rays"), ("symmetry", "symmetry")];

impl<'a> TomlNode<'a> {
    pub(crate) fn offset(&self) -> usize {
        self.span.start
    }
    /// The value of `read` at this place, computed once for all blocks of bands ([`SourceText::once`]).
    pub(crate) fn once<T: 'static>(
        &self,
        read: impl FnOnce() -> Result<T, InputError>,
    ) -> Result<Rc<T>, InputError> {
        self.source.once(format!("@{}", self.span.start), read)
    }
    /// An error here. The message states the defect and, after a semicolon, the remedy.
    pub(crate) fn error(&self, message: impl Into<String>) -> InputError {
        self.source.error(self.span.start, &self.key, message)
    }
    fn mismatch<T>(&self, wanted: &str) -> Result<T, InputError> {
        Err(self.error(format!("this is {}; give {wanted}", type_name(self.value))))
    }
    /// A finite number.
    pub(crate) fn number(&self) -> Result<f64, InputError> {
        let x = match self.value {
            DeValue::Integer(i) => i128::from_str_radix(i.as_str(), i.radix()).ok().map(|x| x as f64),
            DeValue::Float(f) => f.as_str().parse().ok(),
            _ => return self.mismatch("a number"),
        };
        match x {
            Some(x) if x.is_finite() => Ok(x),
            _ => Err(self.error("this number is not finite; give a finite one")),
        }
    }
    /// A finite number above zero.
    pub(crate) fn positive(&self) -> Result<f64, InputError> {
        match self.number()? {
            x if x > 0.0 => Ok(x),
            x => Err(self.error(format!("{x} is out of range; give a number above 0"))),
        }
    }
    /// A finite number from zero.
    pub(crate) fn non_negative(&self) -> Result<f64, InputError> {
        match self.number()? {
            x if x >= 0.0 => Ok(x),
            x => Err(self.error(format!("{x} is out of range; give a number from 0"))),
        }
    }
    /// A whole number from 1.
    pub(crate) fn count(&self) -> Result<usize, InputError> {
        let DeValue::Integer(i) = self.value else {
            return self.mismatch("a whole number");
        };
        match i128::from_str_radix(i.as_str(), i.radix()) {
            Ok(n) if n >= 1 && n <= usize::MAX as i128 => Ok(n as usize),
            _ => Err(self.error(format!("{} is out of range; give a whole number from 1", i.as_str()))),
        }
    }
    pub(crate) fn boolean(&self) -> Result<bool, InputError> {
        match self.value {
            DeValue::Boolean(b) => Ok(*b),
            _ => self.mismatch("true or false"),
        }
    }
    /// A text that is not empty.
    pub(crate) fn text(&self) -> Result<&'a str, InputError> {
        match self.value {
            DeValue::String(s) if s.trim().is_empty() => {
                Err(self.error("this text is empty; write something between the quotes"))
            }
            DeValue::String(s) => Ok(s),
            _ => self.mismatch("a text in quotes"),
        }
    }
    /// A date, a time and an offset from universal time, as a text or as they are.
    pub(crate) fn date_time(&self) -> Result<toml_datetime::Datetime, InputError> {
        match self.value {
            DeValue::Datetime(d) => Ok(*d),
            DeValue::String(s) => s.trim().parse().map_err(|_| {
                self.error(format!("'{s}' is no moment; write it like \"2026-06-21T12:00:00+02:00\""))
            }),
            _ => self.mismatch("a date and time such as 2026-06-21T12:00:00+02:00"),
        }
    }
    /// The index of one of these words.
    pub(crate) fn choice(&self, words: &[&str]) -> Result<usize, InputError> {
        let word = self.text()?;
        if let Some(i) = words.iter().position(|w| *w == word) {
            return Ok(i);
        }
        let renamed = RENAMED_WORDS.iter().find(|(former, now)| *former == word && words.contains(now));
        Err(self.error(match renamed {
            Some((_, now)) => format!("'{word}' has another name; write \"{now}\""),
            None => format!("'{word}' is not known; {}", suggest(word, words)),
        }))
    }
    pub(crate) fn list(&self) -> Result<Vec<TomlNode<'a>>, InputError> {
        let DeValue::Array(array) = self.value else {
            return self.mismatch("a list in [ ]");
        };
        let node = |(i, v): (usize, &'a Spanned<DeValue<'a>>)| TomlNode {
            source: self.source,
            value: v.get_ref(),
            span: v.span(),
            key: format!("{}[{i}]", self.key),
        };
        Ok(array.iter().enumerate().map(node).collect())
    }
    pub(crate) fn is_list(&self) -> bool {
        self.value.is_array()
    }
    pub(crate) fn is_text(&self) -> bool {
        self.value.is_str()
    }
    pub(crate) fn is_table(&self) -> bool {
        self.value.is_table()
    }
    fn triple<T>(
        &self,
        wanted: &str,
        read: impl Fn(&TomlNode<'a>) -> Result<T, InputError>,
    ) -> Result<[T; 3], InputError> {
        if !self.is_list() {
            return self.mismatch(wanted);
        }
        let items = self.list()?;
        let [a, b, c] = items.as_slice() else {
            let n = items.len();
            return Err(self.error(format!("this list has {n} values; give {wanted}")));
        };
        Ok([read(a)?, read(b)?, read(c)?])
    }
    /// A point or direction `[x, y, z]`.
    pub(crate) fn vector(&self) -> Result<Vec3, InputError> {
        self.triple("[x, y, z]", TomlNode::number).map(Vec3::from_array)
    }
    /// Three whole numbers from 1.
    pub(crate) fn counts(&self) -> Result<[usize; 3], InputError> {
        self.triple("three whole numbers [nx, ny, nz]", TomlNode::count)
    }
    /// One number for all axes, or one per axis; all above zero.
    pub(crate) fn lengths(&self) -> Result<Vec3, InputError> {
        if self.is_list() {
            self.triple("a number or [x, y, z]", TomlNode::positive).map(Vec3::from_array)
        } else {
            self.positive().map(Vec3::splat)
        }
    }
    /// A number from 0 to `max`.
    pub(crate) fn number_up_to(&self, max: f64) -> Result<f64, InputError> {
        let x = self.number()?;
        if (0.0..=max).contains(&x) {
            return Ok(x);
        }
        Err(self.error(if max.is_finite() {
            format!("{x} is out of range; give a value from 0 to {max}")
        } else {
            format!("{x} is negative; give 0 or more")
        }))
    }
    /// A property: one number for all bands, one per band, each from 0 to `max`, or the means of a spectrum.
    pub(crate) fn bands(&self, max: f64) -> Result<Bands, InputError> {
        let Some((table, spectrum)) = self.spectrum()? else { return self.numbers_of_bands(max) };
        let scale = table.read("scale", |n| n.non_negative())?.unwrap_or(1.0);
        if let Some(n) = table.get("total") {
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
        let factor = match (table.get("total"), table.get("scale")) {
            (Some(_), Some(n)) => return Err(n.error("total and scale are both given; keep one of them")),
            (Some(n), None) => {
                let sum: f64 = integrals.iter().sum();
                if sum <= 0.0 {
                    return Err(n.error("the spectrum is 0 in all bands and has no total; give other bands or another spectrum"));
                }
                n.non_negative()? / sum
            }
            (None, scale) if table.get("spectrum").is_some() => {
                scale.map(|n| n.non_negative()).transpose()?.unwrap_or(1.0)
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
    /// The spectrum that a table names; none for other values.
    fn spectrum(&self) -> Result<Option<(TomlTable<'a>, Spectrum)>, InputError> {
        if !self.is_table() || self.is_value_file() {
            return Ok(None);
        }
        let t = self.table(SPECTRUM)?;
        let given: Vec<TomlNode> = SPECTRUM_KEYS.iter().filter_map(|k| t.get(k)).collect();
        if let [_, other, ..] = given.as_slice() {
            return Err(
                other.error("a spectrum has one source; keep one of spectrum, illuminant, black_body")
            );
        }
        let found = if let Some(n) = t.get("black_body") {
            match n.positive()? {
                t if (100.0..=1e5).contains(&t) => Spectrum::black_body(t),
                t => return Err(n.error(format!("{t} K is out of range; give 100 to 100000"))),
            }
        } else if let Some(n) = t.get("illuminant") {
            n.choice(&["D65"])?;
            Spectrum::d65()
        } else {
            let file = t.require("spectrum", "spectrum = \"paint.csv\"")?;
            let Some((folder, files)) = self.source.files() else {
                return Err(file.error(
                    "this scene is a text without a folder and cannot refer to files; save it as a file",
                ));
            };
            let column = t.get("column").map(|n| {
                if n.is_text() { n.text().map(String::from) } else { n.count().map(|k| k.to_string()) }
            });
            let column = column.transpose()?.unwrap_or_else(|| "2".into());
            let path = folder.join(file.text()?);
            let read = file.once(|| {
                let read = Spectrum::read(files, &path, &column);
                read.map_err(|f| t.get("column").unwrap_or_else(|| file.clone()).error(f.to_string()))
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
    /// True for a table that is no spectrum: values by face or by voxel from a file.
    pub(crate) fn is_value_file(&self) -> bool {
        let is_spectrum = |t: TomlTable<'_>| SPECTRUM_KEYS.iter().any(|k| t.map.contains_key(*k));
        self.is_table() && !self.any_table().is_ok_and(is_spectrum) && !self.is_by_temperature()
    }
    /// True for a table of values by temperature.
    pub(crate) fn is_by_temperature(&self) -> bool {
        let has_key = |t: TomlTable<'_>| TEMPERATURE_KEYS.iter().any(|k| t.map.contains_key(*k));
        self.is_table() && self.any_table().is_ok_and(has_key)
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
    /// A table with no other keys than these.
    pub(crate) fn table(&self, keys: KeyGroups) -> Result<TomlTable<'a>, InputError> {
        let table = self.any_table()?;
        table.check(keys)?;
        Ok(table)
    }
    /// Entry `index` of a list of named tables: its name, or `surface2` and the like without one, and the table, not yet checked.
    pub(crate) fn named_table(
        &self,
        kind: &str,
        index: usize,
    ) -> Result<(String, TomlTable<'a>), InputError> {
        let mut table = self.any_table()?;
        table.key = format!("{kind} #{}", index + 1);
        let name = table.read("name", |n| n.text())?;
        let name = name.map_or_else(|| format!("{kind}{}", index + 1), str::to_string);
        Ok((name, table))
    }
    /// A table with any keys.
    pub(crate) fn any_table(&self) -> Result<TomlTable<'a>, InputError> {
        match self.value {
            DeValue::Table(map) => {
                let (source, key) = (self.source, self.key.clone());
                Ok(TomlTable { source, map, offset: self.span.start, key })
            }
            _ => self.mismatch("a table { key = value, … }"),
        }
    }
}

impl<'a> TomlTable<'a> {
    /// The whole document.
    pub(crate) fn root(source: &'a SourceText<'a>, map: &'a DeTable<'a>) -> TomlTable<'a> {
        TomlTable { source, map, offset: 0, key: String::new() }
    }
    pub(crate) fn offset(&self) -> usize {
        self.offset
    }
    /// Records the place of this table and of its name under the key that errors of the scene use. A later table of the same name
    /// replaces the place, since that is the one to rename.
    pub(crate) fn record_place(&self) {
        self.source.record_place(self.key.as_str(), self.offset);
        // Looking a key up records its place.
        let _ = self.get("name");
    }
    /// Refuses unknown keys, the first one in the file first.
    pub(crate) fn check(&self, keys: KeyGroups) -> Result<(), InputError> {
        let unknown = self.map.iter().map(|(k, _)| k).filter(|k| !knows(keys, k.get_ref()));
        if let Some(k) = unknown.min_by_key(|k| k.span().start) {
            let message = format!("unknown key; {}", suggest(k.get_ref(), &names(keys)));
            return Err(self.source.error(k.span().start, &self.key_of(k.get_ref()), message));
        }
        Ok(())
    }
    fn key_of(&self, name: &str) -> String {
        if self.key.is_empty() { name.to_string() } else { format!("{}.{name}", self.key) }
    }
    /// An error about this table as a whole.
    pub(crate) fn error(&self, message: impl Into<String>) -> InputError {
        self.source.error(self.offset, &self.key, message)
    }
    /// The value of a key; its place is recorded.
    pub(crate) fn get(&self, name: &str) -> Option<TomlNode<'a>> {
        let value = self.map.get(name)?;
        let (key, span) = (self.key_of(name), value.span());
        self.source.record_place(key.as_str(), span.start);
        Some(TomlNode { source: self.source, value: value.get_ref(), span, key })
    }
    /// A key that must be there; `example` shows how to write it.
    pub(crate) fn require(&self, name: &str, example: &str) -> Result<TomlNode<'a>, InputError> {
        self.get(name).ok_or_else(|| {
            self.source.error(
                self.offset,
                &self.key_of(name),
                format!("this key is missing; write {example}"),
            )
        })
    }
    /// Reads a key if it is given.
    pub(crate) fn read<T>(
        &self,
        name: &str,
        read: impl FnOnce(TomlNode<'a>) -> Result<T, InputError>,
    ) -> Result<Option<T>, InputError> {
        self.get(name).map(read).transpose()
    }
    /// All entries, in the order of the file, as nodes with their names.
    pub(crate) fn entries(&self) -> Vec<(&'a str, TomlNode<'a>)> {
        let mut all: Vec<_> =
            self.map.iter().filter_map(|(k, _)| Some((&**k.get_ref(), self.get(k.get_ref())?))).collect();
        all.sort_by_key(|(_, n)| n.span.start);
        all
    }
    /// The entries of `[[name]]`; none if it is absent.
    pub(crate) fn list(&self, name: &str) -> Result<Vec<TomlNode<'a>>, InputError> {
        match self.get(name) {
            None => Ok(Vec::new()),
            Some(node) if node.is_list() => node.list(),
            Some(node) => {
                Err(node
                    .error(format!("this is not a list; write [[{name}]] with two brackets on each side")))
            }
        }
    }
}

fn type_name(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "a truth value",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}
