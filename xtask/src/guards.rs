//! The register of invariants: each stands as a comment above the test, lint or script that guards it, and this module writes them on one page.
//!
//! ```text
//! // Guards (numbers): a sum has the weaker grade of its terms.
//! #[test]
//! fn the_weaker_grade_wins_in_a_sum() {
//! ```
//!
//! The topic is one of `TOPICS`. Lines that are indented further continue the sentence. Several tests with the same sentence share one row of the
//! page. A comment that stands above no function, test or key, such as a line of a module header, names the whole file.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// The page, relative to the root of the workspace.
pub const PAGE: &str = "docs/guards.md";

/// Topics of invariants in the order of the page: the word in the comment, and the title.
const TOPICS: [(&str, &str); 7] = [
    ("structure", "Structure"),
    ("numbers", "Numbers"),
    ("determinism", "Determinism"),
    ("pictures", "Pictures and pages"),
    ("files", "Files and errors"),
    ("python", "Python package"),
    ("documents", "Documents"),
];

const PAGE_HEAD: &str = "\
# Invariants and their guards

Written by `cargo xtask guards` from the comments `Guards (TOPIC): …` above tests, lints and scripts; a test compares.
`CONTRIBUTING.md` says how to add one.
";

/// Folders and files with guards.
const SOURCES: [&str; 10] = [
    "Cargo.toml",
    "campaigns/src",
    "crates",
    "xtask/src",
    "mpi/src",
    "python/src",
    "python/tests",
    "viewer/test",
    "scripts",
    ".ci",
];

/// Where comments stand, by extension: the beginnings of a line of comment.
const COMMENTS: [(&str, &[&str]); 5] =
    [("rs", &["//!", "//"]), ("mjs", &["//"]), ("py", &["#"]), ("sh", &["#"]), ("toml", &["#"])];

/// An invariant and one guard of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Guard {
    /// The topic, a word of the list above.
    pub topic: String,
    /// The invariant, one sentence.
    pub invariant: String,
    /// Path of the file, and the name of the test or key where there is one: `crates/a/tests/b.rs::name`.
    pub place: String,
}

/// The guards of a file in the order of its lines.
///
/// # Errors
/// A comment without a topic of the list, or without a sentence.
pub fn guards_of(path: &str, text: &str) -> Result<Vec<Guard>, String> {
    let extension = path.rsplit('.').next().unwrap_or("");
    let Some((_, marks)) = COMMENTS.iter().find(|c| c.0 == extension) else { return Ok(Vec::new()) };
    let comment = |line: &'_ str| {
        let line = line.trim_start().to_string();
        marks.iter().find_map(|m| line.strip_prefix(m).map(|rest| (rest.to_string(), *m)))
    };
    let lines: Vec<&str> = text.lines().collect();
    let mut found = Vec::new();
    for (k, line) in lines.iter().enumerate() {
        let Some((rest, mark)) = comment(line) else { continue };
        let Some(rest) = rest.trim_start().strip_prefix("Guards (") else { continue };
        let place = format!("{path}:{}", k + 1);
        let (topic, sentence) = rest
            .split_once("): ")
            .ok_or_else(|| format!("{place}: write `Guards (TOPIC): the invariant`"))?;
        if TOPICS.iter().all(|t| t.0 != topic) {
            let known: Vec<&str> = TOPICS.iter().map(|t| t.0).collect();
            return Err(format!("{place}: no topic `{topic}`; topics are {}", known.join(", ")));
        }
        let mut invariant = sentence.trim().to_string();
        let mut next = k + 1;
        while let Some(more) = lines.get(next).and_then(|l| comment(l)).filter(|c| c.0.starts_with("   ")) {
            invariant = format!("{invariant} {}", more.0.trim());
            next += 1;
        }
        let named = if mark == "//!" { None } else { name_below(&lines[next..], extension, marks) };
        let place = named.map_or_else(|| path.to_string(), |name| format!("{path}::{name}"));
        found.push(Guard { topic: topic.to_string(), invariant, place });
    }
    Ok(found)
}

/// The function or key that the first line below comments, attributes and decorators begins.
fn name_below(lines: &[&str], extension: &str, marks: &[&str]) -> Option<String> {
    let above = |l: &&&str| {
        let l = l.trim_start();
        marks.iter().any(|m| l.starts_with(m)) || l.starts_with("#[") || l.starts_with('@')
    };
    let line = lines.iter().find(|l| !above(l))?.trim_start();
    let word =
        |rest: &str| rest.split(|c: char| !(c.is_alphanumeric() || c == '_')).next().map(str::to_string);
    match extension {
        "rs" => word(line.trim_start_matches("pub ").strip_prefix("fn ")?),
        "py" => word(line.strip_prefix("def ")?),
        "toml" => word(line.split_once(" = ")?.0),
        _ => None,
    }
}

/// All guards of the workspace, in the order of their paths.
///
/// # Errors
/// A file that cannot be read, or a comment without topic or sentence.
pub fn guards(root: &Path) -> Result<Vec<Guard>, String> {
    let mut paths = Vec::new();
    SOURCES.iter().for_each(|source| crate::source::files_below(&root.join(source), &mut paths));
    paths.sort();
    let mut found = Vec::new();
    for path in paths.iter().filter(|p| COMMENTS.iter().any(|c| p.extension().is_some_and(|e| e == c.0))) {
        let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let relative = path.strip_prefix(root).unwrap_or(path).to_string_lossy().replace('\\', "/");
        found.extend(guards_of(&relative, &text)?);
    }
    Ok(found)
}

/// The page with one table for each topic and one row for each invariant.
#[must_use]
pub fn page(guards: &[Guard]) -> String {
    let mut text = PAGE_HEAD.to_string();
    for (topic, title) in TOPICS {
        let mut order: Vec<&str> = Vec::new();
        let mut places: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for guard in guards.iter().filter(|g| g.topic == topic) {
            let of_invariant = places.entry(&guard.invariant).or_default();
            if of_invariant.is_empty() {
                order.push(&guard.invariant);
            }
            of_invariant.push(&guard.place);
        }
        if order.is_empty() {
            continue;
        }
        let _ = write!(text, "\n## {title}\n\n| invariant | guard |\n|---|---|\n");
        for invariant in order {
            let sentence = invariant.trim_end_matches('.').replace('|', "\\|");
            let _ = writeln!(text, "| {} | `{}` |", capitalized(&sentence), places[invariant].join("`, `"));
        }
    }
    text
}

fn capitalized(sentence: &str) -> String {
    let mut characters = sentence.chars();
    characters.next().map_or_else(String::new, |c| c.to_uppercase().chain(characters).collect())
}

/// Writes the page; returns whether it could.
#[must_use]
pub fn write(root: &Path) -> bool {
    let written = guards(root).and_then(|found| {
        let invariants: std::collections::BTreeSet<_> =
            found.iter().map(|g| (&g.topic, &g.invariant)).collect();
        println!("{PAGE}: {} invariants, {} guards", invariants.len(), found.len());
        std::fs::write(root.join(PAGE), page(&found)).map_err(|e| format!("{PAGE}: {e}"))
    });
    written.inspect_err(|e| eprintln!("error: {e}")).is_ok()
}

#[cfg(test)]
mod tests {
    use super::{guards_of, page};

    fn places(path: &str, text: &str) -> Vec<(String, String)> {
        guards_of(path, text).unwrap().into_iter().map(|g| (g.invariant, g.place)).collect()
    }

    fn pair(invariant: &str, place: &str) -> (String, String) {
        (invariant.to_string(), place.to_string())
    }

    #[test]
    fn comments_name_the_test_below_them() {
        let mark = "// Guards";
        let text = format!(
            "{mark} (numbers): one.\n{mark} (files): two,\n//     continued.\n/// A doc.\n#[test]\nfn first() {{}}\n\nuse x;\n\
             {mark} (numbers): three.\npub fn second() {{}}\n{mark} (numbers): of the file.\nuse y;\n"
        );
        let expected = [
            pair("one.", "a.rs::first"),
            pair("two, continued.", "a.rs::first"),
            pair("three.", "a.rs::second"),
            pair("of the file.", "a.rs"),
        ];
        assert_eq!(places("a.rs", &text), expected);
    }

    #[test]
    fn headers_scripts_and_keys_are_guards() {
        assert_eq!(places("a.rs", "//! H.\n//! Guards (files): x.\nfn f() {}"), [pair("x.", "a.rs")]);
        let python =
            "# Guards (files): x.\n@mark\ndef test_x(a):\n    pass\n\n# Guards (files): y.\nimport z\n";
        assert_eq!(places("a.py", python), [pair("x.", "a.py::test_x"), pair("y.", "a.py")]);
        assert_eq!(places("a.toml", "# Guards (files): x.\nkey = 1"), [pair("x.", "a.toml::key")]);
        assert_eq!(places("a.sh", "# Guards (files): x.\nset -e"), [pair("x.", "a.sh")]);
        assert!(places("a.md", "# Guards (files): x.").is_empty());
    }

    #[test]
    fn wrong_comments_are_refused_with_their_place() {
        assert!(
            guards_of("a.rs", "\n// Guards (colours): x.")
                .unwrap_err()
                .starts_with("a.rs:2: no topic `colours`")
        );
        assert!(guards_of("a.rs", "// Guards (files) x").unwrap_err().starts_with("a.rs:1: write"));
    }

    #[test]
    fn tests_of_one_invariant_share_a_row() {
        let text = "// Guards (files): x | y.\nfn f() {}\n// Guards (files): z.\nfn g() {}\n// Guards (files): x | y.\nfn h() {}";
        let page = page(&guards_of("a.rs", text).unwrap());
        assert!(page.contains("## Files and errors") && !page.contains("## Numbers"), "{page}");
        assert!(page.contains("| X \\| y | `a.rs::f`, `a.rs::h` |\n| Z | `a.rs::g` |\n"), "{page}");
    }
}
