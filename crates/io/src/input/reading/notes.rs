//! Notes of reading, with repetitions merged.

use std::collections::{HashMap, HashSet};
use zonal_scene::Diagnostic;

/// Names listed in a note that stands for several.
const MAX_NAMES_IN_NOTE: usize = 3;
/// Names listed in a warning about materials without a value of their own, which are to be given one each.
const MAX_NAMES_IN_MATERIAL_WARNING: usize = 24;

/// Names listed in a note about properties of materials that are not read.
const MAX_NAMES_IN_MATERIAL_NOTE: usize = 8;

/// A note, the names that its repetitions differ in, and their number.
struct MergedNote {
    note: Diagnostic,
    names: Vec<String>,
    known_names: HashSet<String>,
    count: usize,
}

/// Names in quotation marks: the first `most`, and the number of the others.
pub(crate) fn quoted_list<S: AsRef<str>>(names: &[S], most: usize) -> String {
    let shown: Vec<String> = names.iter().take(most).map(|n| format!("'{}'", n.as_ref())).collect();
    match names.len().saturating_sub(most) {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}

/// Merges notes that are equal or differ in one quoted name: the first names are listed, the rest is counted.
pub(crate) fn merge_notes(notes: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let mut merged: Vec<MergedNote> = Vec::new();
    let mut index_of: HashMap<String, usize> = HashMap::new();
    for note in notes {
        let name = first_quoted_name(&note.text).to_string();
        let at = *index_of.entry(merge_key(&note, &name)).or_insert_with(|| {
            merged.push(MergedNote { note, names: Vec::new(), known_names: HashSet::new(), count: 0 });
            merged.len() - 1
        });
        let m = &mut merged[at];
        m.count += 1;
        if m.known_names.insert(name.clone()) {
            m.names.push(name);
        }
    }
    merged.into_iter().map(MergedNote::into_note).collect()
}

/// The first name in single quotes; empty if there is none.
fn first_quoted_name(text: &str) -> &str {
    let quoted = text.split('\'').nth(1).filter(|_| text.matches('\'').count() >= 2);
    quoted.unwrap_or_default()
}

/// Code and text of a note without its name and without line numbers.
fn merge_key(note: &Diagnostic, name: &str) -> String {
    // The name in quotes, so that the text around a short name is unchanged.
    let text = match name {
        "" => note.text.clone(),
        _ => note.text.replace(&format!("'{name}'"), "\0").replace(&format!("\"{name}\""), "\0"),
    };
    let is_line = |part: &&str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
    let parts: Vec<&str> = text.split(':').filter(|part| !is_line(part)).collect();
    format!("{} {}", note.code, parts.join(":"))
}

impl MergedNote {
    fn into_note(self) -> Diagnostic {
        let MergedNote { note, names, count, .. } = self;
        let listed_names = match note.code.as_str() {
            "default-material" => MAX_NAMES_IN_MATERIAL_WARNING,
            "mesh" | "material-limit" => MAX_NAMES_IN_MATERIAL_NOTE,
            _ => MAX_NAMES_IN_NOTE,
        };
        let suffix = match (count, names.len()) {
            (1, _) => String::new(),
            (n, 1) => format!(" ({n} times)"),
            _ => {
                format!(" (likewise {})", quoted_list(&names[1..], listed_names - 1))
            }
        };
        Diagnostic { text: note.text + &suffix, ..note }
    }
}
