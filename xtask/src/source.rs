//! Loads the Rust sources of the workspace and parses them.

use std::path::{Path, PathBuf};

/// The kind of target to which a source file belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Below `src/` of a crate.
    Library,
    /// Below `tests/` or `examples/` of a crate, of the campaigns, of the benchmarks, or of the fuzz harness.
    Consumer,
}

/// One parsed source file.
pub struct SourceFile {
    /// Name of the crate's folder, e.g. `solve`.
    pub package: String,
    /// Path relative to the root of the workspace.
    pub path: String,
    /// Library or consumer of libraries.
    pub role: Role,
    /// The text.
    pub text: String,
    /// The syntax tree.
    pub syntax: syn::File,
}

/// The root of the workspace, from the place of this crate.
#[must_use]
pub fn workspace_root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().map_or_else(|| here.to_path_buf(), Path::to_path_buf)
}

/// Adds a file, or all files below a folder in any order, to a list; folders of packages that npm installed are left out.
pub(crate) fn files_below(path: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(path) else {
        found.extend(path.is_file().then(|| path.to_path_buf()));
        return;
    };
    let inner = entries.flatten().map(|e| e.path());
    inner.filter(|p| !p.ends_with("node_modules")).for_each(|p| files_below(&p, found));
}

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut files = Vec::new();
    files_below(folder, &mut files);
    found.extend(files.into_iter().filter(|path| path.extension().is_some_and(|e| e == "rs")));
}

/// Parses every Rust source below `benches/`, `campaigns/`, `crates/`, `mpi/`, `python/` and `fuzz/`, sorted by path.
///
/// # Panics
/// If a file cannot be read or parsed.
#[must_use]
pub fn load(root: &Path) -> Vec<SourceFile> {
    let mut paths = Vec::new();
    rust_files(&root.join("crates"), &mut paths);
    rust_files(&root.join("benches"), &mut paths);
    rust_files(&root.join("campaigns"), &mut paths);
    rust_files(&root.join("fuzz/src"), &mut paths);
    rust_files(&root.join("fuzz/fuzz_targets"), &mut paths);
    rust_files(&root.join("examples"), &mut paths);
    rust_files(&root.join("python/src"), &mut paths);
    rust_files(&root.join("mpi/src"), &mut paths);
    paths.sort();
    paths.iter().map(|path| parse(root, path)).collect()
}

fn parse(root: &Path, path: &Path) -> SourceFile {
    let relative = path.strip_prefix(root).unwrap_or(path).to_string_lossy().replace('\\', "/");
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{relative}: {e}"));
    SourceFile::from_text(relative, text)
}

impl SourceFile {
    /// Parses the text of a file; `path` is relative to the root of the workspace.
    ///
    /// # Panics
    /// If the text cannot be parsed.
    #[must_use]
    pub fn from_text(path: String, text: String) -> SourceFile {
        let syntax = syn::parse_file(&text).unwrap_or_else(|e| panic!("{path}: {e}"));
        let mut parts = path.split('/');
        let first = parts.next().unwrap_or("").to_string();
        let (package, folder) = if first == "crates" {
            (parts.next().unwrap_or("").to_string(), parts.next().unwrap_or("").to_string())
        } else {
            (first, String::new())
        };
        let role = if folder == "src" { Role::Library } else { Role::Consumer };
        SourceFile { package, path, role, text, syntax }
    }
}

/// True for an item behind `#[cfg(test)]`.
#[must_use]
pub fn is_test_only(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|a| {
        a.path().is_ident("cfg")
            && matches!(&a.meta, syn::Meta::List(list) if list.tokens.to_string().split(|c: char| !c.is_alphanumeric()).any(|w| w == "test"))
    })
}
