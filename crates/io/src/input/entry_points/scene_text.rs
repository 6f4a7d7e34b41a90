//! A scene from its text: the bands first, then each block of bands as a scene of its own.

use crate::files::FileSource;
use crate::input::reading::error::InputError;
use crate::input::scene;
use crate::input::scene::scene_reader::ReadContext;
use crate::input::toml::node::TomlTable;
use crate::input::toml::source::SourceText;
use std::path::Path;
use zonal_scene::{Scene, limits::MAX_UNIFORM_CELLS};

/// Largest scene text, bytes.
pub(crate) const MAX_SCENE_TEXT_BYTES: u64 = 64 << 20;

/// Files on disk, relative to the folder `base`.
pub(crate) fn on_disk(base: Option<&Path>) -> ReadContext<'_> {
    ReadContext { base, files: FileSource::DISK, max_cells: MAX_UNIFORM_CELLS }
}

/// Reads the scene of a text. `file` stands for the file in messages; `name` is the default name of the scene.
pub(crate) fn parse_named(
    text: &str,
    context: ReadContext<'_>,
    file: &str,
    name: &str,
) -> Result<Scene, InputError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let source = SourceText::new(file, text).with_files(context.base, context.files);
    let document = source.parse()?;
    let (bands, gas) = scene::bands::read_bands(&TomlTable::root(&source, document.get_ref()))?;
    // Each block of bands is read as a scene of its own.
    let read_block = |block: usize| {
        let source = source.with_block(bands.clone(), block);
        scene::read_document(TomlTable::root(&source, document.get_ref()), context, gas, name)
    };
    let blocks = (0..bands.block_count()).map(read_block).collect::<Result<Vec<_>, _>>()?;
    Scene::from_blocks(blocks).map_err(|e| source.scene_error(&e))
}
