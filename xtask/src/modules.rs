//! The module graph of a crate, and its cycles.
//!
//! A node is a source file; an edge runs from file A to file B where the code of A names an item that B defines. Paths are resolved through `use`
//! declarations and re-exports to the file of the definition; declaring a module (`mod x;`) and re-exporting an item (`pub use`) are no edges.
//! Items behind `#[cfg(test)]` are left out. A cycle is a strongly connected component of more than one file (Tarjan 1972).

use crate::source::{Role, SourceFile, is_test_only};
use proc_macro2::{TokenStream, TokenTree};
use quote::ToTokens;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

/// Longest chain of re-exports that is followed.
const MAX_REEXPORT_DEPTH: usize = 12;

/// One name that a `use` declaration brings into a module.
#[derive(Clone, Debug)]
pub struct Import {
    /// The path as written.
    pub path: Vec<String>,
    /// The name under which it is known; `*` for a glob.
    pub name: String,
    /// Whether the declaration re-exports (`pub`, `pub(crate)`, …).
    pub reexport: bool,
    /// Whether the re-export is fully public.
    pub public: bool,
}

/// One module.
pub struct Module {
    /// Index of its source file.
    pub file: usize,
    /// Index of its parent.
    pub parent: Option<usize>,
    /// Names of the items that it defines, with whether each is `pub`.
    pub items: HashMap<String, bool>,
    /// Child modules by name, with whether each is `pub`.
    pub children: BTreeMap<String, (usize, bool)>,
    /// Its `use` declarations.
    pub imports: Vec<Import>,
    /// Paths in its code, outside of `use` declarations.
    paths: BTreeSet<Vec<String>>,
}

/// All modules of one crate; the first is its root.
pub struct ModuleTree {
    /// The modules.
    pub modules: Vec<Module>,
}

/// The end of a resolved path.
#[derive(Clone, Debug, PartialEq)]
pub enum Target {
    /// An item, by the module that defines it and its name.
    Item(usize, String),
    /// A module.
    Module(usize),
}

impl ModuleTree {
    /// Reads the modules of a crate from its root file; `None` where the crate has no `src/lib.rs` and no `src/main.rs`.
    #[must_use]
    pub fn new(files: &[SourceFile], package: &str) -> Option<ModuleTree> {
        let by_path: HashMap<&str, usize> = files
            .iter()
            .enumerate()
            .filter(|(_, f)| f.role == Role::Library)
            .map(|(i, f)| (f.path.as_str(), i))
            .collect();
        let folder = format!("crates/{package}/src");
        let root = *by_path
            .get(format!("{folder}/lib.rs").as_str())
            .or_else(|| by_path.get(format!("{folder}/main.rs").as_str()))?;
        let mut tree = ModuleTree { modules: Vec::new() };
        tree.read(files, &by_path, &files[root].syntax.items, Place { file: root, parent: None, folder });
        Some(tree)
    }

    fn read(
        &mut self,
        files: &[SourceFile],
        by_path: &HashMap<&str, usize>,
        items: &[syn::Item],
        place: Place,
    ) -> usize {
        let at = self.modules.len();
        self.modules.push(Module {
            file: place.file,
            parent: place.parent,
            items: HashMap::new(),
            children: BTreeMap::new(),
            imports: Vec::new(),
            paths: BTreeSet::new(),
        });
        for item in items.iter().filter(|i| !is_test_only(attributes(i))) {
            match item {
                syn::Item::Mod(m) => {
                    let name = m.ident.to_string();
                    let folder = format!("{}/{name}", place.folder);
                    let child = if let Some((_, inner)) = &m.content {
                        Some(self.read(
                            files,
                            by_path,
                            inner,
                            Place { file: place.file, parent: Some(at), folder },
                        ))
                    } else {
                        let candidates = [format!("{folder}.rs"), format!("{folder}/mod.rs")];
                        candidates.iter().find_map(|c| by_path.get(c.as_str())).map(|&file| {
                            let place = Place { file, parent: Some(at), folder };
                            self.read(files, by_path, &files[file].syntax.items, place)
                        })
                    };
                    if let Some(child) = child {
                        self.modules[at]
                            .children
                            .insert(name, (child, matches!(m.vis, syn::Visibility::Public(_))));
                    }
                }
                syn::Item::Use(u) => {
                    let reexport = !matches!(u.vis, syn::Visibility::Inherited);
                    let public = matches!(u.vis, syn::Visibility::Public(_));
                    flatten(&u.tree, &mut Vec::new(), &mut |path, name| {
                        self.modules[at].imports.push(Import { path, name, reexport, public });
                    });
                }
                _ => {
                    if let Some((name, public)) = defined(item) {
                        self.modules[at].items.insert(name, public);
                    }
                    collect_paths(item.to_token_stream(), &mut self.modules[at].paths);
                }
            }
        }
        at
    }

    /// Resolves a path that is written in a module to the item or module of this crate that it names.
    #[must_use]
    pub fn resolve(&self, from: usize, path: &[String]) -> Option<Target> {
        self.resolve_at(from, path, 0)
    }

    fn resolve_at(&self, from: usize, path: &[String], depth: usize) -> Option<Target> {
        if depth > MAX_REEXPORT_DEPTH {
            return None;
        }
        let mut at = from;
        let mut rest = path;
        match path.first()?.as_str() {
            "crate" => (at, rest) = (0, &path[1..]),
            "self" => rest = &path[1..],
            "super" => {
                while rest.first().is_some_and(|s| s == "super") {
                    at = self.modules[at].parent?;
                    rest = &rest[1..];
                }
            }
            _ => {}
        }
        while let Some(name) = rest.first() {
            let module = &self.modules[at];
            if module.items.contains_key(name) {
                return Some(Target::Item(at, name.clone()));
            }
            if let Some(&(child, _)) = module.children.get(name) {
                (at, rest) = (child, &rest[1..]);
                continue;
            }
            for import in module.imports.iter().filter(|i| i.name == *name || i.name == "*") {
                let mut whole = import.path.clone();
                if import.name == "*" {
                    whole.push(name.clone());
                }
                if whole == path && at == from {
                    continue;
                }
                whole.extend_from_slice(&rest[1..]);
                if let Some(found) = self.resolve_at(at, &whole, depth + 1) {
                    return Some(found);
                }
            }
            return None;
        }
        Some(Target::Module(at))
    }

    /// The edges between files: for each pair of file indices, the names taken.
    #[must_use]
    pub fn edges(&self) -> BTreeMap<(usize, usize), BTreeSet<String>> {
        let mut edges: BTreeMap<(usize, usize), BTreeSet<String>> = BTreeMap::new();
        for (at, module) in self.modules.iter().enumerate() {
            let named: HashSet<&String> = module.paths.iter().filter_map(|p| p.first()).collect();
            let imported =
                module.imports.iter().filter(|i| !i.reexport || named.contains(&i.name)).map(|i| &i.path);
            for path in imported.chain(&module.paths) {
                if let Some(Target::Item(to, name)) = self.resolve(at, path) {
                    let (a, b) = (module.file, self.modules[to].file);
                    if a != b {
                        edges.entry((a, b)).or_default().insert(name);
                    }
                }
            }
        }
        edges
    }
}

struct Place {
    file: usize,
    parent: Option<usize>,
    folder: String,
}

/// The strongly connected components of more than one file, each as edges with the names taken.
#[must_use]
pub fn cycles(files: &[SourceFile], package: &str) -> Vec<Vec<String>> {
    cycles_of_parts(files, package, &|path| Some(path.to_owned()))
}

/// Every folder below `src` of every crate with the number of its entries: files and folders, of which `x.rs` and `x` are one.
#[must_use]
pub fn entries_of_folders(files: &[SourceFile]) -> BTreeMap<String, usize> {
    let mut entries: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for file in files {
        let Some((root, below)) = file.path.split_once("/src/") else { continue };
        let mut folder = format!("{root}/src");
        for part in below.split('/') {
            let name = part.trim_end_matches(".rs").to_owned();
            entries.entry(folder.clone()).or_default().insert(name);
            folder = format!("{folder}/{part}");
        }
    }
    entries.into_iter().map(|(folder, names)| (folder, names.len())).collect()
}

/// The strongly connected components among the entries of a folder, each as edges with the names taken, for every folder of the crate. A file belongs to the entry
/// through which its path passes; a file `x.rs` and a folder `x` are one entry.
#[must_use]
pub fn folder_cycles(files: &[SourceFile], package: &str) -> Vec<Vec<String>> {
    let start = format!("crates/{package}/src/");
    let folders = entries_of_folders(files).into_keys().map(|folder| folder + "/");
    let among_entries = |folder: &String| {
        let entry = |path: &str| {
            let below = path.strip_prefix(folder.as_str())?;
            Some(below.split(['/', '.']).next().unwrap_or(below).to_owned())
        };
        cycles_of_parts(files, package, &entry)
    };
    folders.filter(|f| f.starts_with(&start)).flat_map(|f| among_entries(&f)).collect()
}

/// The strongly connected components of the parts to which files belong, `part` being the part of a path; files without one are left out.
fn cycles_of_parts(
    files: &[SourceFile],
    package: &str,
    part: &dyn Fn(&str) -> Option<String>,
) -> Vec<Vec<String>> {
    let Some(tree) = ModuleTree::new(files, package) else { return Vec::new() };
    let edges = tree.edges();
    let part_of = |file: usize| part(&files[file].path);
    let mut forward: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for &(a, b) in edges.keys() {
        if let (Some(a), Some(b)) = (part_of(a), part_of(b))
            && a != b
        {
            forward.entry(a).or_default().insert(b);
        }
    }
    let reach = |from: &String| {
        let (mut open, mut seen) = (vec![from], BTreeSet::new());
        while let Some(at) = open.pop() {
            for to in forward.get(at).into_iter().flatten() {
                if seen.insert(to) {
                    open.push(to);
                }
            }
        }
        seen
    };
    let reached: BTreeMap<&String, BTreeSet<&String>> = forward.keys().map(|a| (a, reach(a))).collect();
    let (mut found, mut placed) = (Vec::new(), BTreeSet::new());
    for (&a, from_a) in &reached {
        if !from_a.contains(a) || placed.contains(a) {
            continue;
        }
        let component: BTreeSet<&String> =
            from_a.iter().copied().filter(|b| reached.get(b).is_some_and(|r| r.contains(a))).collect();
        let inner = edges.iter().filter(|((x, y), _)| {
            let (x, y) = (part_of(*x), part_of(*y));
            let inside = |p: &Option<String>| p.as_ref().is_some_and(|p| component.contains(p));
            x != y && inside(&x) && inside(&y)
        });
        found.push(
            inner
                .map(|((x, y), names)| {
                    let names: Vec<&str> = names.iter().map(String::as_str).collect();
                    format!("{} -> {}: {}", files[*x].path, files[*y].path, names.join(", "))
                })
                .collect(),
        );
        placed.extend(component);
    }
    found
}

fn attributes(item: &syn::Item) -> &[syn::Attribute] {
    match item {
        syn::Item::Const(i) => &i.attrs,
        syn::Item::Enum(i) => &i.attrs,
        syn::Item::Fn(i) => &i.attrs,
        syn::Item::Impl(i) => &i.attrs,
        syn::Item::Macro(i) => &i.attrs,
        syn::Item::Mod(i) => &i.attrs,
        syn::Item::Static(i) => &i.attrs,
        syn::Item::Struct(i) => &i.attrs,
        syn::Item::Trait(i) => &i.attrs,
        syn::Item::Type(i) => &i.attrs,
        syn::Item::Use(i) => &i.attrs,
        _ => &[],
    }
}

/// The name that an item defines, and whether it is `pub`.
#[must_use]
pub fn defined(item: &syn::Item) -> Option<(String, bool)> {
    let (ident, visibility) = match item {
        syn::Item::Const(i) => (&i.ident, &i.vis),
        syn::Item::Enum(i) => (&i.ident, &i.vis),
        syn::Item::Fn(i) => (&i.sig.ident, &i.vis),
        syn::Item::Static(i) => (&i.ident, &i.vis),
        syn::Item::Struct(i) => (&i.ident, &i.vis),
        syn::Item::Trait(i) => (&i.ident, &i.vis),
        syn::Item::Type(i) => (&i.ident, &i.vis),
        syn::Item::Union(i) => (&i.ident, &i.vis),
        syn::Item::Macro(i) => return i.ident.as_ref().map(|n| (n.to_string(), false)),
        _ => return None,
    };
    Some((ident.to_string(), matches!(visibility, syn::Visibility::Public(_))))
}

fn flatten(tree: &syn::UseTree, prefix: &mut Vec<String>, take: &mut impl FnMut(Vec<String>, String)) {
    let joined = |prefix: &[String], last: &str| {
        let mut path = prefix.to_vec();
        if last != "self" {
            path.push(last.to_string());
        }
        path
    };
    match tree {
        syn::UseTree::Path(p) => {
            prefix.push(p.ident.to_string());
            flatten(&p.tree, prefix, take);
            prefix.pop();
        }
        syn::UseTree::Name(n) => {
            let path = joined(prefix, &n.ident.to_string());
            let name = path.last().cloned().unwrap_or_default();
            take(path, name);
        }
        syn::UseTree::Rename(r) => take(joined(prefix, &r.ident.to_string()), r.rename.to_string()),
        syn::UseTree::Glob(_) => take(prefix.clone(), "*".into()),
        syn::UseTree::Group(g) => g.items.iter().for_each(|t| flatten(t, prefix, take)),
    }
}

/// Collects the paths `a::b::c` and single identifiers of a token stream, inside macros too.
pub fn collect_paths(tokens: TokenStream, out: &mut BTreeSet<Vec<String>>) {
    let mut path: Vec<String> = Vec::new();
    let mut colons = 0;
    for token in tokens {
        match token {
            TokenTree::Ident(i) => {
                if colons != 2 && !path.is_empty() {
                    out.insert(std::mem::take(&mut path));
                }
                path.push(i.to_string());
                colons = 0;
            }
            TokenTree::Punct(p) if p.as_char() == ':' => colons += 1,
            other => {
                if !path.is_empty() {
                    out.insert(std::mem::take(&mut path));
                }
                colons = 0;
                if let TokenTree::Group(g) = other {
                    collect_paths(g.stream(), out);
                }
            }
        }
    }
    if !path.is_empty() {
        out.insert(path);
    }
}
