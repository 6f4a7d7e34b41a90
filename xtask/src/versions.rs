//! The version of a release: `[workspace.package]` in `Cargo.toml` has it, and every other file that names it agrees.
//!
//! One table says where a file names the version ([`places`]); the check compares these places, and the command that raises the version writes
//! them. The Python package takes its version from its native module.

use std::ops::Range;
use std::path::Path;

/// The manifest of the workspace, whose version counts.
const MANIFEST: &str = "Cargo.toml";
const CHANGELOG: &str = "CHANGELOG.md";
const CITATION: &str = "CITATION.cff";
const PYTHON_PACKAGE: &str = "python/pyproject.toml";
/// Files that name the version.
const FILES: [&str; 5] = [MANIFEST, "Cargo.lock", "fuzz/Cargo.lock", CITATION, CHANGELOG];
/// The end of the changelog's heading before a release; afterwards the date stands there.
const NOT_RELEASED: &str = "not released";

/// The bytes of a file in which the version stands.
#[must_use]
pub fn places(file: &str, text: &str) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let (mut start, mut section, mut previous) = (0, "", "");
    for line in text.split_inclusive('\n') {
        let bare = line.trim_end();
        section = if bare.starts_with('[') { bare } else { section };
        let mark = match file {
            MANIFEST if section == "[workspace.package]" => bare.starts_with("version = ").then_some("\""),
            MANIFEST => (section == "[workspace.dependencies]" && bare.starts_with("zonal-"))
                .then_some("version = \"="),
            CITATION => bare.starts_with("version: ").then_some("version: "),
            CHANGELOG => (bare.starts_with("## ") && found.is_empty()).then_some("## "),
            // A lock file: the line after the name of a package of this workspace.
            _ => (is_name_of_ours(previous) && bare.starts_with("version = ")).then_some("\""),
        };
        if let Some(at) = mark.and_then(|mark| bare.find(mark).map(|at| at + mark.len())) {
            let length = bare[at..].find(|c: char| "\", ".contains(c)).unwrap_or(bare.len() - at);
            found.push(start + at..start + at + length);
        }
        start += line.len();
        previous = bare;
    }
    found
}

/// Whether a line of a lock file names a package of the workspace; the package of the fuzz targets is a workspace of its own.
fn is_name_of_ours(line: &str) -> bool {
    let name = line.strip_prefix("name = \"").and_then(|rest| rest.strip_suffix('"')).unwrap_or("");
    name == "xtask" || name == "zonal" || (name.starts_with("zonal-") && name != "zonal-fuzz")
}

/// The version of the workspace.
fn version_of(manifest: &str) -> Option<&str> {
    places(MANIFEST, manifest).into_iter().next().map(|place| &manifest[place])
}

/// Every place that differs from the version of the workspace, by a function that returns the text of a file.
///
/// # Errors
/// The reason why a file cannot be read.
pub fn differences(read: impl Fn(&str) -> Result<String, String>) -> Result<Vec<String>, String> {
    let manifest = read(MANIFEST)?;
    let version = version_of(&manifest).ok_or("Cargo.toml: [workspace.package] has no version")?;
    let mut found = Vec::new();
    for file in FILES {
        let text = read(file)?;
        let all = places(file, &text);
        if all.is_empty() {
            found.push(format!("{file}: no version, expected {version}"));
        }
        for place in all.into_iter().filter(|place| &text[place.clone()] != version) {
            let line = text[..place.start].matches('\n').count() + 1;
            found.push(format!("{file}:{line}: version {}, expected {version}", &text[place]));
        }
    }
    if !read(PYTHON_PACKAGE)?.contains("dynamic = [\"version\"]") {
        found.push(format!("{PYTHON_PACKAGE}: the version is not dynamic"));
    }
    Ok(found)
}

/// The missing entries of a release with the tag `vX.Y.Z`: the number, dates, and the address of the repository.
///
/// # Errors
/// The reason why a file cannot be read.
pub fn unready_for_tag(
    tag: &str,
    read: impl Fn(&str) -> Result<String, String>,
) -> Result<Vec<String>, String> {
    let mut found = differences(&read)?;
    let manifest = read(MANIFEST)?;
    let version = version_of(&manifest).unwrap_or_default();
    if tag.strip_prefix('v') != Some(version) {
        found.push(format!("the tag is {tag}, the version is v{version}"));
    }
    if !manifest.lines().any(|l| l.starts_with("repository = ")) {
        found.push(format!("{MANIFEST}: [workspace.package] has no repository, which binstall needs"));
    }
    let changelog = read(CHANGELOG)?;
    let heading = changelog.lines().find(|l| l.starts_with("## ")).unwrap_or_default();
    if heading.ends_with(NOT_RELEASED) {
        found.push(format!("{CHANGELOG}: `{heading}` has no date"));
    }
    if !read(CITATION)?.lines().any(|l| l.starts_with("date-released: ")) {
        found.push(format!("{CITATION}: no date-released"));
    }
    Ok(found)
}

/// The text of a file with another version. A changelog whose first section is released gets a new one.
fn with_version(file: &str, text: &str, version: &str) -> String {
    let mut out = text.to_string();
    if file == CHANGELOG
        && let Some(at) = text.find("## ")
        && !text[at..].lines().next().unwrap_or_default().ends_with(NOT_RELEASED)
    {
        out.insert_str(at, &format!("## {version}, {NOT_RELEASED}\n\n"));
    }
    for place in places(file, &out).into_iter().rev() {
        out.replace_range(place, version);
    }
    out
}

/// Reads a file of the workspace.
fn reader(root: &Path) -> impl Fn(&str) -> Result<String, String> {
    |file| std::fs::read_to_string(root.join(file)).map_err(|e| format!("{file}: {e}"))
}

/// Prints the differences, and what a tag lacks; returns whether there is none.
#[must_use]
pub fn report(root: &Path, tag: Option<&str>) -> bool {
    let found = match tag {
        Some(tag) => unready_for_tag(tag, reader(root)),
        None => differences(reader(root)),
    };
    let found = found.unwrap_or_else(|e| vec![e]);
    found.iter().for_each(|line| println!("{line}"));
    println!("{} differences in versions", found.len());
    found.is_empty()
}

/// Writes a version into every place; returns whether it could.
#[must_use]
pub fn write(root: &Path, version: &str) -> bool {
    let is_number = |part: &str| !part.is_empty() && part.chars().all(|c| c.is_ascii_digit());
    if version.split('.').count() != 3 || !version.split('.').all(is_number) {
        eprintln!("error: `{version}` is no version: write three numbers, as 0.2.0");
        return false;
    }
    let read = reader(root);
    let written = FILES.iter().try_for_each(|file| {
        let text = with_version(file, &read(file)?, version);
        std::fs::write(root.join(file), text).map_err(|e| format!("{file}: {e}"))
    });
    written.inspect_err(|e| eprintln!("error: {e}")).is_ok()
}

#[cfg(test)]
mod tests {
    use super::{FILES, differences, places, unready_for_tag, with_version};

    const MANIFEST: &str = "[workspace.package]\nversion = \"1.2.3\"\nrepository = \"r\"\n\n[workspace.dependencies]\n\
        zonal-math = { path = \"crates/math\", version = \"=1.2.3\" }\nrayon = \"1.12\"\nzonal-reference = { path = \"r\" }\n";
    const LOCK: &str = "[[package]]\nname = \"zonal-math\"\nversion = \"1.2.3\"\n\n[[package]]\nname = \"rayon\"\nversion = \"1.12.0\"\n\
        [[package]]\nname = \"zonal-fuzz\"\nversion = \"0.0.0\"\n";

    fn text_of(file: &str) -> String {
        let text = match file {
            "Cargo.toml" => MANIFEST,
            "CITATION.cff" => "cff-version: 1.2.0\nversion: 1.2.3\ndate-released: 2030-01-02\n",
            "CHANGELOG.md" => "# Changelog\n\n## 1.2.3, 2030-01-02\n\nText.\n\n## 1.2.2, 2029-01-02\n",
            "python/pyproject.toml" => "dynamic = [\"version\"]\n",
            _ => LOCK,
        };
        text.to_string()
    }

    #[test]
    fn equal_versions_have_no_differences() {
        assert_eq!(differences(|file| Ok(text_of(file))).unwrap(), Vec::<String>::new());
        assert_eq!(unready_for_tag("v1.2.3", |file| Ok(text_of(file))).unwrap(), Vec::<String>::new());
    }

    #[test]
    fn each_difference_is_found() {
        for file in FILES {
            for k in 0..places(file, &text_of(file)).len() {
                let mut bad = text_of(file);
                bad.replace_range(places(file, &bad)[k].clone(), "9.9.9");
                let read = |name: &str| Ok(if name == file { bad.clone() } else { text_of(name) });
                assert!(!differences(read).unwrap().is_empty(), "{file}, place {k}");
            }
        }
        let fixed = |file: &str| Ok(text_of(file).replace("dynamic", "version"));
        assert_eq!(differences(fixed).unwrap().len(), 1);
    }

    #[test]
    fn an_unready_tag_is_refused() {
        let changed = |from: &'static str, to: &'static str| {
            unready_for_tag("v1.2.3", move |file| Ok(text_of(file).replace(from, to))).unwrap().len()
        };
        assert_eq!(changed("## 1.2.3, 2030-01-02", "## 1.2.3, not released"), 1);
        assert_eq!(changed("date-released", "date"), 1);
        assert_eq!(changed("repository = ", "repo = "), 1);
        assert_eq!(unready_for_tag("v1.2.4", |file| Ok(text_of(file))).unwrap().len(), 1);
        assert_eq!(unready_for_tag("1.2.3", |file| Ok(text_of(file))).unwrap().len(), 1);
    }

    #[test]
    fn a_raised_version_stands_in_every_place() {
        let raised = |file: &str| Ok(with_version(file, &text_of(file), "2.0.0"));
        assert_eq!(differences(raised).unwrap(), Vec::<String>::new());
        let changelog = with_version("CHANGELOG.md", &text_of("CHANGELOG.md"), "2.0.0");
        assert!(changelog.contains("## 2.0.0, not released\n\n## 1.2.3, 2030-01-02\n"), "{changelog}");
        let again = with_version("CHANGELOG.md", &changelog, "2.0.1");
        assert!(again.contains("## 2.0.1, not released\n\n## 1.2.3, 2030-01-02\n"), "{again}");
        assert!(with_version("Cargo.lock", LOCK, "2.0.0").contains("name = \"rayon\"\nversion = \"1.12.0\""));
    }
}
