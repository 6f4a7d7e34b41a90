//! Typed reading of a TOML document in which every value knows its key and place.

use super::error::{InputError, nearest};
use super::source::Source;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use zonal_math::Vec3;
use zonal_scene::Bands;

/// A value with its key and place.
#[derive(Clone)]
pub(crate) struct Node<'a> {
    source: &'a Source<'a>,
    value: &'a DeValue<'a>,
    span: Range<usize>,
    pub(crate) key: String,
}

/// A table whose keys are all known.
pub(crate) struct Table<'a> {
    pub(crate) source: &'a Source<'a>,
    map: &'a DeTable<'a>,
    offset: usize,
    pub(crate) key: String,
}

impl<'a> Node<'a> {
    pub(crate) fn offset(&self) -> usize {
        self.span.start
    }
    /// An error here. `what` says what is wrong and, after a semicolon, what to do.
    pub(crate) fn error(&self, what: impl Into<String>) -> InputError {
        self.source.error(self.span.start, &self.key, what)
    }
    fn mismatch<T>(&self, wanted: &str) -> Result<T, InputError> {
        Err(self.error(format!("this is {}; give {wanted}", kind(self.value))))
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
    /// One of these words.
    pub(crate) fn choice(&self, words: &[&str]) -> Result<usize, InputError> {
        let word = self.text()?;
        if let Some(i) = words.iter().position(|w| *w == word) {
            return Ok(i);
        }
        Err(self.error(format!("'{word}' is not known; {}", suggestion(word, words))))
    }
    pub(crate) fn list(&self) -> Result<Vec<Node<'a>>, InputError> {
        let DeValue::Array(array) = self.value else {
            return self.mismatch("a list in [ ]");
        };
        let node = |(i, v): (usize, &'a Spanned<DeValue<'a>>)| Node {
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
    pub(crate) fn is_table(&self) -> bool {
        self.value.is_table()
    }
    fn triple<T>(
        &self,
        wanted: &str,
        read: impl Fn(&Node<'a>) -> Result<T, InputError>,
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
        self.triple("[x, y, z]", Node::number).map(Vec3::from_array)
    }
    /// Three whole numbers from 1.
    pub(crate) fn counts(&self) -> Result<[usize; 3], InputError> {
        self.triple("three whole numbers [nx, ny, nz]", Node::count)
    }
    /// One number for all axes, or one an axis; all above zero.
    pub(crate) fn lengths(&self) -> Result<Vec3, InputError> {
        if self.is_list() {
            self.triple("a number or [x, y, z]", Node::positive).map(Vec3::from_array)
        } else {
            self.positive().map(Vec3::splat)
        }
    }
    /// One number for all bands or one a band, each from 0 to `max`.
    pub(crate) fn bands(&self, max: f64) -> Result<Bands, InputError> {
        let one = |n: &Node<'a>| {
            let x = n.number()?;
            if (0.0..=max).contains(&x) {
                return Ok(x);
            }
            Err(n.error(if max.is_finite() {
                format!("{x} is out of range; give a value from 0 to {max}")
            } else {
                format!("{x} is negative; give 0 or more")
            }))
        };
        if self.is_list() {
            self.triple("a number or [red, green, blue]", one)
        } else {
            one(self).map(|x| [x; 3])
        }
    }
    /// A table with no other keys than these.
    pub(crate) fn table(&self, known: &[&str]) -> Result<Table<'a>, InputError> {
        let table = self.any_table()?;
        table.check(known)?;
        Ok(table)
    }
    /// A table with any keys.
    pub(crate) fn any_table(&self) -> Result<Table<'a>, InputError> {
        match self.value {
            DeValue::Table(map) => {
                Ok(Table { source: self.source, map, offset: self.span.start, key: self.key.clone() })
            }
            _ => self.mismatch("a table { key = value, … }"),
        }
    }
}

impl<'a> Table<'a> {
    /// The whole document.
    pub(crate) fn root(source: &'a Source<'a>, map: &'a DeTable<'a>) -> Table<'a> {
        Table { source, map, offset: 0, key: String::new() }
    }
    pub(crate) fn offset(&self) -> usize {
        self.offset
    }
    /// Notes where this table and its name stand, under the key that errors of the scene use. A later table of the same
    /// name takes the place: it is the one to rename.
    pub(crate) fn remember(&self) {
        self.source.remember(self.key.as_str(), self.offset);
        // Reading a key notes its place.
        let _ = self.get("name");
    }
    /// Refuses keys that are not among these, first in the file first.
    pub(crate) fn check(&self, known: &[&str]) -> Result<(), InputError> {
        let unknown = self.map.iter().map(|(k, _)| k);
        let unknown = unknown.filter(|k| !known.contains(&&**k.get_ref()));
        match unknown.min_by_key(|k| k.span().start) {
            None => Ok(()),
            Some(k) => {
                let what = format!("unknown key; {}", suggestion(k.get_ref(), known));
                Err(self.source.error(k.span().start, &self.key_of(k.get_ref()), what))
            }
        }
    }
    fn key_of(&self, name: &str) -> String {
        if self.key.is_empty() { name.to_string() } else { format!("{}.{name}", self.key) }
    }
    /// An error about this table as a whole.
    pub(crate) fn error(&self, what: impl Into<String>) -> InputError {
        self.source.error(self.offset, &self.key, what)
    }
    pub(crate) fn get(&self, name: &str) -> Option<Node<'a>> {
        let value = self.map.get(name)?;
        let key = self.key_of(name);
        self.source.remember(key.as_str(), value.span().start);
        Some(Node { source: self.source, value: value.get_ref(), span: value.span(), key })
    }
    /// A key that must be there; `example` is what to write.
    pub(crate) fn need(&self, name: &str, example: &str) -> Result<Node<'a>, InputError> {
        self.get(name).ok_or_else(|| {
            self.source.error(
                self.offset,
                &self.key_of(name),
                format!("this key is missing; write {example}"),
            )
        })
    }
    /// Reads a key where it is given.
    pub(crate) fn read<T>(
        &self,
        name: &str,
        read: impl FnOnce(Node<'a>) -> Result<T, InputError>,
    ) -> Result<Option<T>, InputError> {
        self.get(name).map(read).transpose()
    }
    /// All entries, in the order of the file, as nodes with their names.
    pub(crate) fn entries(&self) -> Vec<(&'a str, Node<'a>)> {
        let mut all: Vec<_> =
            self.map.iter().filter_map(|(k, _)| Some((&**k.get_ref(), self.get(k.get_ref())?))).collect();
        all.sort_by_key(|(_, n)| n.span.start);
        all
    }
    /// The entries of `[[name]]`; none where it is absent.
    pub(crate) fn list(&self, name: &str) -> Result<Vec<Node<'a>>, InputError> {
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

fn kind(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "a truth value",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}

/// `did you mean 'x'?`, or the list of what is known.
pub(crate) fn suggestion(word: &str, known: &[&str]) -> String {
    match nearest(word, known.iter().copied()) {
        Some(k) => format!("did you mean '{k}'?"),
        None => format!("known here: {}", known.join(", ")),
    }
}
