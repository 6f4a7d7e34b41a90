//! The text of a scene, and where in it everything stands.

use super::error::InputError;
use std::cell::RefCell;
use std::collections::HashMap;
use toml::Spanned;
use toml::de::DeTable;
use zonal_scene::SceneError;

/// The text of a scene, its name in messages, and where each key that was read stands.
pub(crate) struct Source<'a> {
    file: &'a str,
    text: &'a str,
    places: RefCell<HashMap<String, usize>>,
}

impl<'a> Source<'a> {
    pub(crate) fn new(file: &'a str, text: &'a str) -> Source<'a> {
        Source { file, text, places: RefCell::default() }
    }
    /// Line and column (in characters) of a byte offset, both from 1.
    fn place(&self, offset: usize) -> (usize, usize) {
        let mut offset = offset.min(self.text.len());
        while !self.text.is_char_boundary(offset) {
            offset -= 1;
        }
        let before = &self.text[..offset];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        let line = before.bytes().filter(|b| *b == b'\n').count() + 1;
        (line, before[line_start..].chars().count() + 1)
    }
    pub(crate) fn error(&self, offset: usize, key: &str, what: impl Into<String>) -> InputError {
        InputError::new(self.file, Some(self.place(offset)), key, what)
    }
    /// Notes where `key`, as it appears in a [`SceneError`], stands.
    pub(crate) fn remember(&self, key: impl Into<String>, offset: usize) {
        self.places.borrow_mut().insert(key.into(), offset);
    }
    /// `key` stands where `at` stands, unless it has a place of its own.
    pub(crate) fn alias(&self, key: &str, at: &str) {
        let mut places = self.places.borrow_mut();
        if let Some(offset) = places.get(at).copied() {
            places.entry(key.to_string()).or_insert(offset);
        }
    }
    /// Puts a scene's error on the line of its key, or of the nearest key above it that was read.
    pub(crate) fn scene_error(&self, error: &SceneError) -> InputError {
        let places = self.places.borrow();
        let mut key = error.key();
        let place = loop {
            match places.get(key) {
                Some(offset) => break Some(self.place(*offset)),
                None => match key.rfind('.') {
                    Some(dot) => key = &key[..dot],
                    None => break None,
                },
            }
        };
        InputError::new(self.file, place.or(Some((1, 1))), error.key(), mend(error.what()))
    }
    /// Parses the text; `parse` keeps the table alive for the caller.
    pub(crate) fn parse(&self) -> Result<Spanned<DeTable<'a>>, InputError> {
        DeTable::parse(self.text).map_err(|e| {
            let at = e.span().map_or(0, |s| s.start);
            let what = e.message().trim().replace('\n', ", ");
            self.error(at, "", format!("this is not TOML: {what}; mend the syntax near here"))
        })
    }
}

/// Every message ends with what to do.
fn mend(what: &str) -> String {
    if what.contains(';') { what.to_string() } else { format!("{what}; change this value") }
}
