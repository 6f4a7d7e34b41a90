//! Replacement of former keys in the text of a scene. Every byte outside of the keys stays, comments and layout included.

use super::key_tables::SCENE_TABLES;
use super::keys::all;
use super::source::SourceText;
use crate::input::reading::error::InputError;
use std::ops::Range;
use toml::de::DeTable;

/// The name that a migrated text has in error messages.
const TEXT_NAME: &str = "scene";

/// A key that was renamed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyChange {
    /// Line of the key, from 1.
    pub line: usize,
    /// Former path, such as `solve.sweeps`.
    pub old: String,
    /// Present path.
    pub new: String,
}

/// Replaces the former keys of a scene's text by the present ones; gives the text and the changes by line.
///
/// # Errors
///
/// The text is not TOML, or a key is given under both names. Messages call the text `scene`.
///
/// ```
/// let (text, changes) = zonal_io::input::migrate_scene_text("[solve]\nsweeps = 3  # orders\n")?;
/// assert_eq!(text, "[solve]\nscattering_orders = 3  # orders\n");
/// assert_eq!((changes[0].line, changes[0].new.as_str()), (2, "solve.scattering_orders"));
/// # Ok::<(), zonal_io::input::InputError>(())
/// ```
pub fn migrate_scene_text(text: &str) -> Result<(String, Vec<KeyChange>), InputError> {
    let body = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mark = &text[..text.len() - body.len()];
    let source = SourceText::new(TEXT_NAME, body);
    let document = source.parse()?;
    let mut found: Vec<(Range<usize>, &'static str, KeyChange)> = Vec::new();
    for (path, groups) in SCENE_TABLES {
        let Some(table) = table_at(document.get_ref(), path) else { continue };
        for spec in all(groups) {
            let Some(former) = spec.former_name else { continue };
            let Some((key, _)) = table.get_key_value(former) else { continue };
            let (old, new) = (format!("{path}.{former}"), format!("{path}.{}", spec.name));
            let start = key.span().start;
            if table.contains_key(spec.name) {
                return Err(source.error(start, &old, both_names(spec.name)));
            }
            let line = source.line_and_column(start).0;
            found.push((key.span(), spec.name, KeyChange { line, old, new }));
        }
    }
    found.sort_by_key(|f| f.0.start);
    let mut out = body.to_string();
    for (span, name, _) in found.iter().rev() {
        out.replace_range(span.clone(), name);
    }
    Ok((format!("{mark}{out}"), found.into_iter().map(|f| f.2).collect()))
}

/// The message about a key that is given under its former and its present name.
pub(super) fn both_names(present: &str) -> String {
    format!("this is the former name of '{present}', which is given too; keep '{present}'")
}

/// The table at a dotted path of plain tables; none if the text has none there.
fn table_at<'a, 'i>(root: &'a DeTable<'i>, path: &str) -> Option<&'a DeTable<'i>> {
    let parts = path.split('.').filter(|p| !p.is_empty());
    parts.into_iter().try_fold(root, |table, part| table.get(part)?.get_ref().as_table())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn migrated(text: &str) -> (String, Vec<String>) {
        let (text, changes) = migrate_scene_text(text).unwrap();
        (text, changes.into_iter().map(|c| format!("{}: {} -> {}", c.line, c.old, c.new)).collect())
    }

    #[test]
    fn every_former_key_is_replaced_and_the_rest_stays() {
        let old = "\u{feff}# groups = not a key\r\nmode = 'thermal'\n\n[solve] # settings\n  groups   = \"each\" # groups\n\
            thick_zones='linear'\n\"zoning_error\" = true\nsweeps = 3\n[thermal]\nshares = [ 1,\n  0, 0 ]\nleft_out = false\n";
        let (new, changes) = migrated(old);
        let expected = "\u{feff}# groups = not a key\r\nmode = 'thermal'\n\n[solve] # settings\n  light_groups   = \"each\" # groups\n\
            zone_basis='linear'\ndiscretization_error = true\nscattering_orders = 3\n[thermal]\nband_fractions = [ 1,\n  0, 0 ]\nallow_partial = false\n";
        assert_eq!(new.replace('"', "'"), expected.replace('"', "'"));
        assert_eq!(changes.len(), 6);
        assert_eq!(changes[0], "5: solve.groups -> solve.light_groups");
        assert_eq!(migrated(&new), (new.clone(), Vec::new()));
    }

    #[test]
    fn dotted_and_inline_keys_are_replaced() {
        assert_eq!(migrated("solve.sweeps = 2 # a\n").0, "solve.scattering_orders = 2 # a\n");
        assert_eq!(
            migrated("solve = { sweeps = 2, groups = 'all' }").0,
            "solve = { scattering_orders = 2, light_groups = 'all' }"
        );
    }

    #[test]
    fn a_key_under_both_names_is_an_error() {
        let e = migrate_scene_text("[solve]\nsweeps = 2\nscattering_orders = 3\n").unwrap_err().to_string();
        assert_eq!(
            e,
            "scene:2:1: solve.sweeps: this is the former name of 'scattering_orders', which is given too; keep 'scattering_orders'"
        );
        assert!(migrate_scene_text("[solve").is_err());
    }
}
