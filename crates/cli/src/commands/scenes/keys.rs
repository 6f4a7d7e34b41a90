//! `zonal keys`: the reference of all keys of scene files, from the tables by which the reader checks scenes.

use crate::commands::context::Context;
use zonal_io::input::{SceneKey, scene_key_reference};
use zonal_report::{Failure, say};

/// Title and introduction of the page.
const INTRODUCTION: &str = "# Scene keys

Every key of a scene file, with type, unit and default. `zonal keys --markdown` writes this page from the tables by which the reader checks scenes;
[Scene format](scene-format.md) explains the sections.

- *bands* is one number for all bands, or a list of one for each band: `[r, g, b]` by default.
- `NAME[]` stands for the entries of a list of tables, `[[NAME]]` in TOML. Capitals stand for a name that the scene chooses.
- A default of *required* marks a key without a default. An empty default means that the property is absent.
- An unknown key is an error.
";

/// Print the reference of all keys of scene files.
///
/// Each key is listed with its type, unit, default and a description: as text, as a page in Markdown, or with --json as a list.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Print a page in Markdown with one table for each section: docs/reference/scene-keys.md.
    #[arg(long)]
    pub markdown: bool,
}

/// Runs the command.
///
/// # Errors
/// If both formats are requested, or standard output cannot be written.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let keys = scene_key_reference();
    if args.markdown && context.json {
        return Err(Failure::new("--markdown: cannot be combined with --json; give one of them"));
    }
    if args.markdown {
        say(markdown(&keys).trim_end())
    } else if context.json {
        context.say_json(json(&keys))
    } else {
        say(text(&keys).trim_end())
    }
}

/// Section and name of a key: all of its path before the last dot, and the rest.
fn section_and_name(key: &SceneKey) -> (&str, &str) {
    key.path.rsplit_once('.').unwrap_or(("", &key.path))
}

/// One line for each key.
fn text(keys: &[SceneKey]) -> String {
    let line = |k: &SceneKey| {
        let unit = if k.unit.is_empty() { String::new() } else { format!(", {}", k.unit) };
        let default = match k.default {
            "" => String::new(),
            "required" => "; required".into(),
            default => format!("; default {default}"),
        };
        format!("{} ({}{unit}{default}): {}\n", k.path, k.value, k.description)
    };
    keys.iter().map(line).collect()
}

fn json(keys: &[SceneKey]) -> serde_json::Value {
    let entry = |k: &SceneKey| {
        serde_json::json!({
            "path": k.path, "type": k.value, "unit": k.unit, "default": k.default, "description": k.description,
        })
    };
    keys.iter().map(entry).collect()
}

/// The page: a table for each section.
fn markdown(keys: &[SceneKey]) -> String {
    let mut page = String::from(INTRODUCTION);
    for section in keys.chunk_by(|a, b| section_and_name(a).0 == section_and_name(b).0) {
        let title = match section_and_name(&section[0]).0 {
            "" => "Top level".to_string(),
            path => format!("`{path}`"),
        };
        page += &format!(
            "\n## {title}\n\n| key | type | unit | default | description |\n|---|---|---|---|---|\n"
        );
        section.iter().for_each(|k| page += &row(k));
    }
    page
}

/// One row of a table.
fn row(key: &SceneKey) -> String {
    let cell = |text: &str| text.replace('|', "\\|");
    let name = section_and_name(key).1;
    let [value, unit, default, description] = [&key.value, key.unit, key.default, key.description].map(cell);
    format!("| `{name}` | {value} | {unit} | {default} | {description} |\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markdown_lists_every_key_in_a_table_of_its_section() {
        let keys = scene_key_reference();
        let page = markdown(&keys);
        assert!(page.starts_with("# Scene keys\n"));
        assert!(page.contains("\n## `solve`\n"));
        let rows: Vec<&str> = page.lines().filter(|l| l.starts_with("| `")).collect();
        assert_eq!(rows.len(), keys.len());
        assert!(rows.iter().all(|r| r.replace("\\|", "").matches('|').count() == 6));
    }
}
