//! Documents: lengths of lines, paths, and the statement of scope that README.md and the first page of the manual share.

use crate::source::files_below;
use std::path::Path;

/// Most characters of a line of prose.
pub const MAX_PROSE_LINE: usize = 160;

/// Folders and files with documents written by hand.
const DOCUMENTS: [&str; 10] = [
    "README.md",
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "SECURITY.md",
    "docs",
    "peers",
    "crates/zonal/README.md",
    "fuzz/README.md",
    "python/README.md",
];

/// Pages that programs write.
const GENERATED: [&str; 9] = [
    "docs/cornell.md",
    "docs/coverage-view-factors.md",
    "docs/coverage.md",
    "docs/error-against-cost.md",
    "docs/guards.md",
    "docs/reference/python.md",
    "docs/reference/scene-keys.md",
    "docs/reproduction/README.md",
    "docs/validation.md",
];

/// Lines of prose of a document that are too long. Headings of tables, rows, code, comments, and the targets of links do not count.
#[must_use]
pub fn long_lines(text: &str) -> Vec<usize> {
    let mut found = Vec::new();
    let (mut fenced, mut in_comment, mut in_code, mut in_list, mut blank) =
        (false, false, false, false, true);
    for (k, line) in text.lines().enumerate() {
        let trimmed = line.trim_start();
        let fence = trimmed.starts_with("```");
        let begins_comment = trimmed.starts_with("<!--");
        let is_item = trimmed.starts_with("- ") || trimmed.starts_with("* ") || ordered(trimmed);
        let is_top = !line.starts_with(' ') && !line.is_empty();
        in_list = if is_top { is_item } else { in_list };
        in_code = line.starts_with("    ") && !in_list && (blank || in_code);
        let prose = !(fenced || fence || in_comment || begins_comment || in_code || trimmed.starts_with('|'));
        if prose && without_targets(line).chars().count() > MAX_PROSE_LINE {
            found.push(k + 1);
        }
        fenced ^= fence;
        in_comment = (in_comment || begins_comment) && !line.contains("-->");
        blank = line.trim().is_empty();
    }
    found
}

/// True for a line such as `12. text`.
fn ordered(line: &str) -> bool {
    line.split_once(". ").is_some_and(|(n, _)| !n.is_empty() && n.chars().all(|c| c.is_ascii_digit()))
}

/// A line with `[text]` in place of `[text](target)`.
fn without_targets(line: &str) -> String {
    let mut parts = line.split("](");
    let mut out = parts.next().unwrap_or("").to_string();
    for part in parts {
        out.push(']');
        out.push_str(part.split_once(')').map_or("", |(_, rest)| rest));
    }
    out
}

/// `path:line` of every line of prose that is too long.
#[must_use]
pub fn places_of_long_lines(root: &Path) -> Vec<String> {
    let mut paths = Vec::new();
    DOCUMENTS.iter().for_each(|document| files_below(&root.join(document), &mut paths));
    paths.sort();
    let mut found = Vec::new();
    for path in paths.iter().filter(|p| p.extension().is_some_and(|e| e == "md")) {
        let name = path.strip_prefix(root).unwrap_or(path).to_string_lossy().replace('\\', "/");
        if !GENERATED.contains(&name.as_str()) {
            let text = std::fs::read_to_string(path).unwrap_or_default();
            found.extend(long_lines(&text).iter().map(|line| format!("{name}:{line}")));
        }
    }
    found
}

/// Folders at the root of the workspace whose paths documents name.
const FOLDERS: [&str; 14] = [
    ".ci",
    "benches",
    "campaigns",
    "crates",
    "docs",
    "examples",
    "fuzz",
    "mpi",
    "peers",
    "python",
    "scenes",
    "scripts",
    "viewer",
    "xtask",
];

/// Paths in code spans of a document that begin at the root of the workspace and do not exist. Words with blanks, wildcards or placeholders are no
/// paths.
#[must_use]
pub fn missing_paths(text: &str, exists: impl Fn(&str) -> bool) -> Vec<&str> {
    let lines = text.lines().filter(|line| !line.starts_with("    "));
    let quoted = lines.flat_map(|line| line.split('`').skip(1).step_by(2));
    let is_path = |q: &&str| {
        let first = q.split_once('/').map(|(first, _)| first);
        first.is_some_and(|f| FOLDERS.contains(&f)) && !q.contains([' ', '*', '…', '<'])
    };
    quoted.filter(is_path).filter(|q| !exists(q)).collect()
}

/// The lines before and after a statement of scope.
const SCOPE_MARKS: [&str; 2] = ["<!-- scope -->\n", "<!-- end of scope -->\n"];

/// The text before, between and after the marks.
fn around_scope(text: &str) -> Option<[&str; 3]> {
    let (before, rest) = text.split_once(SCOPE_MARKS[0])?;
    let (scope, after) = rest.split_once(SCOPE_MARKS[1])?;
    Some([before, scope, after])
}

/// The first page of the manual with the scope of the README, whose links begin at the root of the workspace; `None` without the marks.
#[must_use]
pub fn page_with_scope(page: &str, readme: &str) -> Option<String> {
    let [before, _, after] = around_scope(page)?;
    let scope = around_scope(readme)?[1].replace("](docs/", "](");
    Some([before, SCOPE_MARKS[0], &scope, SCOPE_MARKS[1], after].concat())
}

/// Copies the scope of the README into the first page of the manual; returns whether it could.
#[must_use]
pub fn write_scope(root: &Path) -> bool {
    let read = |name: &str| std::fs::read_to_string(root.join(name)).map_err(|e| format!("{name}: {e}"));
    let page = read("README.md").and_then(|readme| {
        let page = page_with_scope(&read("docs/index.md")?, &readme);
        page.ok_or_else(|| "README.md and docs/index.md need the marks of the scope".to_string())
    });
    let written = page.and_then(|p| {
        std::fs::write(root.join("docs/index.md"), p).map_err(|e| format!("docs/index.md: {e}"))
    });
    written.inspect_err(|e| eprintln!("error: {e}")).is_ok()
}

#[cfg(test)]
mod tests {
    use super::{MAX_PROSE_LINE, long_lines, missing_paths, page_with_scope};

    #[test]
    fn long_lines_of_prose_are_found() {
        let long = "word ".repeat(MAX_PROSE_LINE / 5) + "end";
        for prose in [long.clone(), format!("# {long}"), format!("- {long}"), format!("- a\n\n    {long}")] {
            assert_eq!(long_lines(&prose).len(), 1, "{prose}");
        }
        let exempt = [
            format!("| {long} |"),
            format!("```sh\n{long}\n```"),
            format!("text\n\n    {long}\n    {long}"),
            format!("<!-- test: shell\n{long}\n-->"),
            format!("[link](https://a.b/{})", "x".repeat(MAX_PROSE_LINE)),
            "ü".repeat(MAX_PROSE_LINE),
        ];
        for text in exempt {
            assert_eq!(long_lines(&text), Vec::<usize>::new(), "{text}");
        }
        assert_eq!(long_lines(&format!("```\n{long}\n```\n{long}\n<!-- {long} -->\n{long}")), [4, 6]);
    }

    #[test]
    fn missing_paths_are_found() {
        let text = "`crates/a/src/b.rs`, `crates/gone`, `b.rs`, `cargo run`, `docs/*.md`\n\n    `docs/code`\n`docs/also`";
        assert_eq!(missing_paths(text, |p| p == "crates/a/src/b.rs"), ["crates/gone", "docs/also"]);
    }

    #[test]
    fn the_scope_is_copied_with_its_links() {
        let readme = "a\n<!-- scope -->\n[x](docs/x.md)\n<!-- end of scope -->\nb";
        let expected = "c\n<!-- scope -->\n[x](x.md)\n<!-- end of scope -->\nd";
        for old in ["", "old\n"] {
            let page = format!("c\n<!-- scope -->\n{old}<!-- end of scope -->\nd");
            assert_eq!(page_with_scope(&page, readme).as_deref(), Some(expected));
        }
        assert_eq!(page_with_scope("no marks", readme), None);
    }
}
