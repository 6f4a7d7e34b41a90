//! The text of a scene, and the place of every key in it.

use crate::files::FileSource;
use crate::input::reading::error::InputError;
use std::any::{Any, TypeId};
use std::cell::RefCell;
use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;
use toml::Spanned;
use toml::de::DeTable;
use zonal_scene::{BandSet, SceneError};

/// The text of a scene, its name in messages, and the place of each key that was read.
pub(crate) struct SourceText<'a> {
    file: &'a str,
    text: &'a str,
    places: RefCell<HashMap<String, usize>>,
    /// The bands of the scene, and the block of them that is read.
    bands: (BandSet, usize),
    /// Folder and storage of the files that values refer to.
    files: Option<(&'a Path, FileSource<'a>)>,
    shared: Rc<SharedValues>,
}

/// Values that do not depend on the bands, read once for all blocks of bands: by place in the document, or by name of an image.
#[derive(Default)]
struct SharedValues {
    values: RefCell<HashMap<(String, TypeId), Rc<dyn Any>>>,
}

impl<'a> SourceText<'a> {
    pub(crate) fn new(file: &'a str, text: &'a str) -> SourceText<'a> {
        SourceText {
            file,
            text,
            places: RefCell::default(),
            bands: (BandSet::default(), 0),
            files: None,
            shared: Rc::default(),
        }
    }
    /// The same text with files in a folder.
    pub(crate) fn with_files(self, folder: Option<&'a Path>, files: FileSource<'a>) -> SourceText<'a> {
        SourceText { files: folder.map(|f| (f, files)), ..self }
    }
    /// The same text, of which one block of bands is read.
    pub(crate) fn with_block(&self, bands: BandSet, block: usize) -> SourceText<'a> {
        let shared = self.shared.clone();
        SourceText {
            bands: (bands, block),
            files: self.files,
            shared,
            ..SourceText::new(self.file, self.text)
        }
    }
    /// The value of `read`, which must not depend on the block of bands: computed for the first block, and kept for the others. `key` is unique for its type.
    pub(crate) fn once<T: 'static, E>(
        &self,
        key: impl Into<String>,
        read: impl FnOnce() -> Result<T, E>,
    ) -> Result<Rc<T>, E> {
        if self.bands().block_count() == 1 {
            return read().map(Rc::new);
        }
        let key = (key.into(), TypeId::of::<T>());
        let known = self.shared.values.borrow().get(&key).cloned();
        if let Some(known) = known.and_then(|v| v.downcast::<T>().ok()) {
            return Ok(known);
        }
        let value = Rc::new(read()?);
        self.shared.values.borrow_mut().insert(key, value.clone());
        Ok(value)
    }
    /// Folder and storage of the files that values refer to; none for a text without a folder.
    pub(crate) fn files(&self) -> Option<(&'a Path, FileSource<'a>)> {
        self.files
    }
    /// The bands of the scene.
    pub(crate) fn bands(&self) -> &BandSet {
        &self.bands.0
    }
    /// The block of bands that is read.
    pub(crate) fn block(&self) -> usize {
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
