//! The text of a scene, and the place of every key in it.

use crate::files::FileSource;
use crate::input::reading::error::InputError;
use std::cell::RefCell;
use std::collections::HashMap;
use std::path::Path;
use toml::Spanned;
use toml::de::DeTable;
use zonal_scene::{BandSet, SceneError};

/// The text of a scene, its name in messages, and the place of each key that was read.
pub(crate) struct SourceText<'a> {
    file: &'a str,
    text: &'a str,
    places: RefCell<HashMap<String, usize>>,
    /// The bands of the scene, and the triple of them that is read.
    bands: (BandSet, usize),
    /// Folder and storage of the files that values refer to.
    files: Option<(&'a Path, FileSource<'a>)>,
}

impl<'a> SourceText<'a> {
    pub(crate) fn new(file: &'a str, text: &'a str) -> SourceText<'a> {
        SourceText { file, text, places: RefCell::default(), bands: (BandSet::default(), 0), files: None }
    }
    /// The same text with files in a folder.
    pub(crate) fn with_files(self, folder: Option<&'a Path>, files: FileSource<'a>) -> SourceText<'a> {
        SourceText { files: folder.map(|f| (f, files)), ..self }
    }
    /// The same text, of which one triple of bands is read.
    pub(crate) fn with_triple(&self, bands: BandSet, triple: usize) -> SourceText<'a> {
        SourceText { bands: (bands, triple), files: self.files, ..SourceText::new(self.file, self.text) }
    }
    /// Folder and storage of the files that values refer to; none for a text without a folder.
    pub(crate) fn files(&self) -> Option<(&'a Path, FileSource<'a>)> {
        self.files
    }
    /// The bands of the scene.
    pub(crate) fn bands(&self) -> &BandSet {
        &self.bands.0
    }
    /// The triple of bands that is read.
    pub(crate) fn triple(&self) -> usize {
        self.bands.1
    }
    /// Line and column (in characters) of a byte offset, both from 1.
    pub(crate) fn line_and_column(&self, offset: usize) -> (usize, usize) {
        let mut offset = offset.min(self.text.len());
        while !self.text.is_char_boundary(offset) {
            offset -= 1;
        }
        let before = &self.text[..offset];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        let line = before.bytes().filter(|b| *b == b'\n').count() + 1;
        (line, before[line_start..].chars().count() + 1)
    }
    pub(crate) fn error(&self, offset: usize, key: &str, message: impl Into<String>) -> InputError {
        InputError::new(self.file, Some(self.line_and_column(offset)), key, message)
    }
    /// Records the place of `key`, spelt as in a [`SceneError`].
    pub(crate) fn record_place(&self, key: impl Into<String>, offset: usize) {
        self.places.borrow_mut().insert(key.into(), offset);
    }
    /// Gives `key` the place of `other`, unless it has a place already.
    pub(crate) fn inherit_place(&self, key: &str, other: &str) {
        let mut places = self.places.borrow_mut();
        if let Some(offset) = places.get(other).copied() {
            places.entry(key.to_string()).or_insert(offset);
        }
    }
    /// Places a scene's error on the line of its key, or of the nearest enclosing key that was read.
    pub(crate) fn scene_error(&self, error: &SceneError) -> InputError {
        let places = self.places.borrow();
        let mut key = error.key();
        let place = loop {
            match places.get(key) {
                Some(offset) => break Some(self.line_and_column(*offset)),
                None => match key.rfind('.') {
                    Some(dot) => key = &key[..dot],
                    None => break None,
                },
            }
        };
        InputError::new(self.file, place.or(Some((1, 1))), error.key(), with_remedy(error.message()))
    }
    /// Parses the text; the caller keeps the returned table alive while it is read.
    pub(crate) fn parse(&self) -> Result<Spanned<DeTable<'a>>, InputError> {
        DeTable::parse(self.text).map_err(|e| {
            let at = e.span().map_or(0, |s| s.start);
            let message = e.message().trim().replace('\n', ", ");
            self.error(at, "", format!("this is not TOML: {message}; mend the syntax near here"))
        })
    }
}

/// A message that ends with a remedy.
fn with_remedy(message: &str) -> String {
    if message.contains(';') { message.to_string() } else { format!("{message}; change this value") }
}
