//! Typed reading of a TOML document. Every value carries its key and its place.

use super::key_specs::{KeyGroups, knows, names};
use super::source::SourceText;
use crate::files::FileSource;
use crate::input::reading::error::InputError;
use crate::input::reading::suggestion::suggest;
use std::ops::Range;
use std::path::PathBuf;
use std::rc::Rc;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use zonal_math::Vec3;

/// Keys of which values by temperature have one.
const TEMPERATURE_KEYS: [&str; 2] = ["temperatures", "by_temperature"];
/// Keys of which a spectrum has one.
pub(crate) const SPECTRUM_KEYS: [&str; 3] = ["spectrum", "illuminant", "black_body"];

/// A value with its key and place.
#[derive(Clone)]
pub(crate) struct TomlNode<'a> {
    pub(super) source: &'a SourceText<'a>,
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
const RENAMED_WORDS: [(&str, &str); 2] = [("hierarchical", "rays"), ("mirror", "symmetry")];

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
    /// The path of the file that this value names, and the storage to read it from.
    pub(crate) fn named_file(&self) -> Result<(PathBuf, FileSource<'a>), InputError> {
        let name = self.text()?;
        let refused = || {
            self.error("this scene is a text without a folder and cannot refer to files; save it as a file")
        };
        let (folder, files) = self.source.files().ok_or_else(refused)?;
        Ok((folder.join(name), files))
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
    /// A direction as a unit vector.
    pub(crate) fn unit_vector(&self) -> Result<Vec3, InputError> {
        let d = self.vector()?;
        // Divide by the largest component first, so that the square neither overflows nor vanishes.
        let unit = (d / d.max_abs()).normalized();
        let refused =
            || self.error("this direction has no length; give the way along which the light travels");
        unit.is_finite().then_some(unit).ok_or_else(refused)
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
        let name = table.get("name").map(|n| n.text().map(str::to_string)).transpose()?;
        let name = name.unwrap_or_else(|| format!("{kind}{}", index + 1));
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
    /// The node of a key; its place is recorded.
    pub(crate) fn get(&self, key: impl AsRef<str>) -> Option<TomlNode<'a>> {
        let value = self.map.get(key.as_ref())?;
        let (key, span) = (self.key_of(key.as_ref()), value.span());
        self.source.record_place(key.as_str(), span.start);
        Some(TomlNode { source: self.source, value: value.get_ref(), span, key })
    }
    /// The error of a key that is missing; `example` shows what to write.
    pub(crate) fn missing(&self, name: &str, example: &str) -> InputError {
        let message = format!("this key is missing; write {example}");
        self.source.error(self.offset, &self.key_of(name), message)
    }
    /// All entries, in the order of the file, as nodes with their names.
    pub(crate) fn entries(&self) -> Vec<(&'a str, TomlNode<'a>)> {
        let mut all: Vec<_> =
            self.map.iter().filter_map(|(k, _)| Some((&**k.get_ref(), self.get(k.get_ref())?))).collect();
        all.sort_by_key(|(_, n)| n.span.start);
        all
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
