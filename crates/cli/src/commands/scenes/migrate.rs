//! `zonal migrate`: replaces former keys of a scene file by their present names.

use crate::commands::context::Context;
use std::io::Read;
use std::path::{Path, PathBuf};
use zonal_io::input::{KeyChange, migrate_scene_text, open_file};
use zonal_io::output::{check_writable, write_bytes};
use zonal_report::{Failure, say};

/// Largest scene file, bytes.
const MAX_SCENE_BYTES: u64 = 64 << 20;

/// The name of the text in messages of [`migrate_scene_text`].
const TEXT_NAME: &str = "scene";

/// Replace former keys of a scene file by their present names.
///
/// Without --write the changes are printed and the file is not changed. Comments and layout are kept. Scenes with former keys can still be read; each
/// gives a warning.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Scene file (.toml).
    pub scene: PathBuf,
    /// Rewrite the file. It is replaced as a whole or not at all.
    #[arg(long)]
    pub write: bool,
}

/// Runs the command.
///
/// # Errors
/// For a file that cannot be read or written or is not TOML, and for a key that is given under both names.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let path = &args.scene;
    let old = read(path)?;
    let (new, changes) = migrate_scene_text(&old).map_err(|e| {
        let message = e.to_string();
        let place = message.strip_prefix(TEXT_NAME).map(|rest| format!("{}{rest}", path.display()));
        Failure::new(place.unwrap_or(message))
    })?;
    let writes = args.write && !changes.is_empty();
    if writes {
        check_writable(path)?;
        write_bytes(path, new.as_bytes())?;
    }
    if context.json {
        return print_json(&changes, writes);
    }
    print_changes(path, &changes, writes)
}

/// The text of a scene file.
fn read(path: &Path) -> Result<String, Failure> {
    let mut text = String::new();
    open_file(path, MAX_SCENE_BYTES)?.read_to_string(&mut text).map_err(|e| Failure::in_file(path, e))?;
    Ok(text)
}

fn print_json(changes: &[KeyChange], written: bool) -> Result<(), Failure> {
    let change = |c: &KeyChange| serde_json::json!({ "line": c.line, "old": c.old, "new": c.new });
    let changes: Vec<serde_json::Value> = changes.iter().map(change).collect();
    say(&format!("{:#}", serde_json::json!({ "changes": changes, "written": written })))
}

fn print_changes(path: &Path, changes: &[KeyChange], written: bool) -> Result<(), Failure> {
    let path = path.display();
    for c in changes {
        say(&format!("{path}:{}: {} -> {}", c.line, c.old, c.new))?;
    }
    match (changes.len(), written) {
        (0, _) => say(&format!("{path}: no former keys")),
        (n, true) => say(&format!("{n} key(s) renamed; written: {path}")),
        (n, false) => say(&format!("{n} key(s) to rename; --write rewrites the file")),
    }
}
