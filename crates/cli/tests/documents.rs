//! Documents agree with the workspace: paths, pages written by `cargo xtask`, lengths.

use std::path::{Path, PathBuf};
use xtask::{documents, guards, versions};

/// Most lines of ARCHITECTURE.md.
const MAX_ARCHITECTURE_LINES: usize = 110;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

// Guards (documents): ARCHITECTURE.md is a short map that names every crate.
#[test]
fn architecture_is_a_short_map_of_all_crates() {
    let document = read("ARCHITECTURE.md");
    let lines = document.lines().count();
    assert!(
        lines <= MAX_ARCHITECTURE_LINES,
        "ARCHITECTURE.md has {lines} lines; {MAX_ARCHITECTURE_LINES} are allowed"
    );
    for entry in std::fs::read_dir(root().join("crates")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(document.contains(&format!("`{name}`")), "{name} is not in ARCHITECTURE.md");
    }
}

// Guards (documents): paths that documents name exist.
#[test]
fn paths_in_documents_exist() {
    for document in ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md"] {
        let text = read(document);
        let missing = documents::missing_paths(&text, |path| root().join(path).exists());
        assert!(missing.is_empty(), "{document} names paths that do not exist: {missing:?}");
    }
}

// Guards (documents): docs/guards.md contains the guards of the sources.
#[test]
fn register_of_guards_is_up_to_date() {
    let found = guards::guards(&root()).unwrap();
    assert!(
        guards::page(&found) == read(guards::PAGE),
        "run `cargo xtask guards` and commit {}",
        guards::PAGE
    );
}

// Guards (documents): every file that names the version of the release has the one of Cargo.toml.
#[test]
fn versions_in_all_files_are_equal() {
    let found = versions::differences(|file| Ok(read(file))).unwrap();
    assert!(found.is_empty(), "run `cargo xtask version X.Y.Z`:\n{}", found.join("\n"));
}

// Guards (documents): docs/index.md has the scope of README.md.
#[test]
fn first_page_of_the_manual_has_the_scope_of_the_readme() {
    let page = read("docs/index.md");
    let expected = documents::page_with_scope(&page, &read("README.md"));
    assert!(expected.as_ref() == Some(&page), "run `cargo xtask scope` and commit docs/index.md");
}

// Guards (documents): README.md begins with its title, then the commands of the demo and of the tests.
#[test]
fn readme_begins_with_its_title_then_demo_and_test() {
    /// Lines of a first screen.
    const FIRST_SCREEN: usize = 24;
    let readme = read("README.md");
    assert!(readme.starts_with("# zonal\n"));
    let shown = readme.lines().take(FIRST_SCREEN).filter(|l| l.starts_with("    "));
    let mut commands = shown.map(|l| l.split('#').next().unwrap_or("").trim());
    assert_eq!(commands.next(), Some("cargo run --release -- demo"));
    assert_eq!(commands.next(), Some("cargo test"));
}
