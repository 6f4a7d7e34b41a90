//! Public items: those that nothing outside their crate names, those that can be reached from the library `zonal`, and executed doctests.

use crate::modules::{ModuleTree, Target};
use crate::source::{Role, SourceFile, is_test_only};
use proc_macro2::{TokenStream, TokenTree};
use quote::ToTokens;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use syn::visit::{self, Visit};

/// Folders of crates whose public items serve other crates.
pub const INNER_CRATES: [&str; 11] = [
    "math",
    "scene",
    "transport",
    "exchange",
    "paper",
    "solve",
    "render",
    "io",
    "reference",
    "validation",
    "demo",
];

fn identifiers(tokens: TokenStream, out: &mut HashSet<String>) {
    for token in tokens {
        match token {
            TokenTree::Ident(i) => {
                out.insert(i.to_string());
            }
            TokenTree::Group(g) => identifiers(g.stream(), out),
            _ => {}
        }
    }
}

struct PublicItems<'a> {
    path: &'a str,
    found: Vec<(String, String)>,
}

impl PublicItems<'_> {
    fn add(&mut self, visibility: &syn::Visibility, name: &syn::Ident) {
        if matches!(visibility, syn::Visibility::Public(_)) {
            self.found.push((name.to_string(), format!("{}:{}", self.path, name.span().start().line)));
        }
    }
}

impl<'a> Visit<'a> for PublicItems<'_> {
    fn visit_item(&mut self, item: &'a syn::Item) {
        match item {
            syn::Item::Const(i) => self.add(&i.vis, &i.ident),
            syn::Item::Enum(i) => self.add(&i.vis, &i.ident),
            syn::Item::Fn(i) => self.add(&i.vis, &i.sig.ident),
            syn::Item::Static(i) => self.add(&i.vis, &i.ident),
            syn::Item::Struct(i) => self.add(&i.vis, &i.ident),
            syn::Item::Trait(i) => self.add(&i.vis, &i.ident),
            syn::Item::Type(i) => self.add(&i.vis, &i.ident),
            syn::Item::Mod(i) if is_test_only(&i.attrs) => return,
            syn::Item::Mod(i) => self.add(&i.vis, &i.ident),
            _ => {}
        }
        visit::visit_item(self, item);
    }
    fn visit_impl_item(&mut self, item: &'a syn::ImplItem) {
        match item {
            syn::ImplItem::Fn(i) => self.add(&i.vis, &i.sig.ident),
            syn::ImplItem::Const(i) => self.add(&i.vis, &i.ident),
            _ => {}
        }
    }
}

/// Public items of the inner crates whose name occurs nowhere outside the sources of their crate: name and place.
#[must_use]
pub fn unused_public_items(files: &[SourceFile]) -> Vec<(String, String)> {
    let mut unused = Vec::new();
    for package in INNER_CRATES {
        let mut named = HashSet::new();
        let outside = files.iter().filter(|f| f.package != package || f.role == Role::Consumer);
        outside.for_each(|f| identifiers(f.syntax.to_token_stream(), &mut named));
        for file in files.iter().filter(|f| f.package == package && f.role == Role::Library) {
            let mut items = PublicItems { path: &file.path, found: Vec::new() };
            items.visit_file(&file.syntax);
            unused.extend(items.found.into_iter().filter(|(name, _)| !named.contains(name)));
        }
    }
    unused
}

/// The public inherent methods of every type, by crate and type name.
fn methods(files: &[SourceFile]) -> BTreeMap<(String, String), BTreeSet<String>> {
    let mut found: BTreeMap<(String, String), BTreeSet<String>> = BTreeMap::new();
    for file in files.iter().filter(|f| f.role == Role::Library) {
        for item in &file.syntax.items {
            let syn::Item::Impl(block) = item else { continue };
            let (None, syn::Type::Path(of)) = (&block.trait_, &*block.self_ty) else { continue };
            let Some(name) = of.path.segments.last() else { continue };
            for inner in &block.items {
                let (visibility, ident) = match inner {
                    syn::ImplItem::Fn(f) => (&f.vis, &f.sig.ident),
                    syn::ImplItem::Const(c) => (&c.vis, &c.ident),
                    _ => continue,
                };
                if matches!(visibility, syn::Visibility::Public(_)) {
                    found
                        .entry((file.package.clone(), name.ident.to_string()))
                        .or_default()
                        .insert(ident.to_string());
                }
            }
        }
    }
    found
}

/// Everything that can be named from the library `zonal`: modules, types, traits, functions, constants (`crate::Name`) and the public
/// inherent methods of the types (`crate::Type::method`).
#[must_use]
pub fn reachable_items(files: &[SourceFile]) -> BTreeSet<String> {
    let packages: BTreeSet<&str> = files.iter().map(|f| f.package.as_str()).collect();
    let trees: HashMap<&str, ModuleTree> =
        packages.iter().filter_map(|p| ModuleTree::new(files, p).map(|t| (*p, t))).collect();
    let mut reach =
        Reach { trees: &trees, methods: methods(files), found: BTreeSet::new(), seen: HashSet::new() };
    reach.module("zonal", 0);
    reach.found
}

struct Reach<'a> {
    trees: &'a HashMap<&'a str, ModuleTree>,
    methods: BTreeMap<(String, String), BTreeSet<String>>,
    found: BTreeSet<String>,
    seen: HashSet<(String, usize)>,
}

impl Reach<'_> {
    fn module(&mut self, package: &str, at: usize) {
        if !self.seen.insert((package.to_string(), at)) {
            return;
        }
        let Some(tree) = self.trees.get(package) else { return };
        let module = &tree.modules[at];
        for (name, _) in module.items.iter().filter(|(_, public)| **public) {
            self.item(package, name);
        }
        for (name, &(child, _)) in module.children.iter().filter(|(_, (_, public))| *public) {
            self.found.insert(format!("{package}::{name}"));
            self.module(package, child);
        }
        for import in module.imports.iter().filter(|i| i.public) {
            self.path(package, at, &import.path, import.name == "*");
        }
    }

    fn path(&mut self, package: &str, at: usize, path: &[String], glob: bool) {
        let other = path.first().and_then(|p| p.strip_prefix("zonal_")).map(str::to_string);
        let (package, start, whole) = match other {
            Some(other) => {
                let mut whole = path.to_vec();
                whole[0] = "crate".into();
                (other, 0, whole)
            }
            None => (package.to_string(), at, path.to_vec()),
        };
        let Some(tree) = self.trees.get(package.as_str()) else { return };
        match tree.resolve(start, &whole) {
            Some(Target::Item(_, name)) => self.item(&package, &name),
            Some(Target::Module(module)) => {
                if !glob {
                    self.found.insert(format!("{package}::{}", whole.join("::")));
                }
                self.module(&package, module);
            }
            // A re-export of another crate's item by an inner crate.
            None => {
                if let Some((last, head)) = whole.split_last()
                    && let Some(Target::Module(module)) = tree.resolve(start, head)
                    && let Some(import) = tree.modules[module].imports.iter().find(|i| i.name == *last)
                    && import.path.first().is_some_and(|p| p.starts_with("zonal_"))
                {
                    self.path(&package, module, &import.path, false);
                }
            }
        }
    }

    fn item(&mut self, package: &str, name: &str) {
        self.found.insert(format!("{package}::{name}"));
        for method in self.methods.get(&(package.to_string(), name.to_string())).into_iter().flatten() {
            self.found.insert(format!("{package}::{name}::{method}"));
        }
    }
}

/// Number of code blocks in documentation comments that `cargo test` compiles and runs.
#[must_use]
pub fn executed_doctests(files: &[SourceFile]) -> usize {
    files.iter().filter(|f| f.role == Role::Library).map(|f| doctests(&f.text)).sum()
}

fn doctests(text: &str) -> usize {
    let (mut count, mut open) = (0, false);
    for line in text.lines().map(str::trim_start) {
        let Some(doc) = line.strip_prefix("///").or_else(|| line.strip_prefix("//!")) else {
            open = false;
            continue;
        };
        let Some(fence) = doc.trim().strip_prefix("```") else { continue };
        if !open {
            let tags: Vec<&str> = fence.split([',', ' ']).filter(|t| !t.is_empty()).collect();
            count += usize::from(tags.iter().all(|t| ["rust", "should_panic"].contains(t)));
        }
        open = !open;
    }
    count
}

#[cfg(test)]
mod tests {
    use super::doctests;

    #[test]
    fn doctests_exclude_text_and_ignored_blocks() {
        let text =
            "/// ```\n/// f();\n/// ```\n//! ```text\n//! x\n//! ```\n/// ```no_run\n/// g();\n/// ```\n";
        assert_eq!(doctests(text), 1);
    }
}
