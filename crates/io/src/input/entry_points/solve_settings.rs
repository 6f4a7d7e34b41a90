//! Settings of a solve from the keys of `[solve]`, in place of those of a scene.

use crate::input::reading::error::InputError;
use crate::input::scene::options::read_options;
use crate::input::toml::node::TomlTable;
use crate::input::toml::source::SourceText;
use zonal_scene::SolveOptions;

/// The settings `base`, with those that the lines of `text` give as in the table `[solve]` of a scene file.
///
/// # Errors
/// The text is not TOML, or has unknown keys or values out of range.
///
/// ```
/// use zonal_scene::{Engine, SolveOptions};
/// let options = zonal_io::input::read_solve_settings("engine = 'dense'", SolveOptions::default())?;
/// assert_eq!((options.engine, options.tolerance), (Engine::Dense, 0.01));
/// # Ok::<(), zonal_io::input::InputError>(())
/// ```
pub fn read_solve_settings(text: &str, base: SolveOptions) -> Result<SolveOptions, InputError> {
    let source = SourceText::new("settings", text);
    let document = source.parse()?;
    read_options(&TomlTable::root(&source, document.get_ref()), base)
}
