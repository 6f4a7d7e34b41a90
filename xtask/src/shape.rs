//! Lengths of functions, numbers and kinds of their parameters, names of constants and of types.

use crate::source::{Role, SourceFile, is_test_only};
use std::collections::{BTreeMap, BTreeSet};
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

/// One function.
#[derive(Debug)]
pub struct Function {
    /// Path and line.
    pub place: String,
    /// Its name.
    pub name: String,
    /// Lines from `fn` to its closing brace.
    pub lines: usize,
    /// Number of parameters, `self` counted.
    pub parameters: usize,
    /// Number of parameters of type `bool`.
    pub bools: usize,
    /// Whether it is `pub`.
    pub public: bool,
    /// Whether it is a method whose one parameter beside `self` is a `bool`.
    pub setter: bool,
}

struct Functions<'a> {
    path: &'a str,
    found: Vec<Function>,
}

impl Functions<'_> {
    fn push(&mut self, signature: &syn::Signature, visibility: &syn::Visibility, end: usize) {
        let start = signature.fn_token.span().start().line;
        let is_bool = |a: &&syn::FnArg| matches!(a, syn::FnArg::Typed(t) if matches!(&*t.ty, syn::Type::Path(p) if p.path.is_ident("bool")));
        let bools = signature.inputs.iter().filter(is_bool).count();
        self.found.push(Function {
            place: format!("{}:{start}", self.path),
            name: signature.ident.to_string(),
            lines: end.max(start) - start + 1,
            parameters: signature.inputs.len(),
            bools,
            public: matches!(visibility, syn::Visibility::Public(_)),
            setter: signature.receiver().is_some() && signature.inputs.len() == 2 && bools == 1,
        });
    }
}

impl<'a> Visit<'a> for Functions<'_> {
    fn visit_item_fn(&mut self, f: &'a syn::ItemFn) {
        self.push(&f.sig, &f.vis, f.block.brace_token.span.close().end().line);
        visit::visit_item_fn(self, f);
    }
    fn visit_impl_item_fn(&mut self, f: &'a syn::ImplItemFn) {
        self.push(&f.sig, &f.vis, f.block.brace_token.span.close().end().line);
        visit::visit_impl_item_fn(self, f);
    }
    fn visit_trait_item_fn(&mut self, f: &'a syn::TraitItemFn) {
        let end = f.default.as_ref().map_or(0, |b| b.brace_token.span.close().end().line);
        self.push(&f.sig, &syn::Visibility::Inherited, end);
        visit::visit_trait_item_fn(self, f);
    }
}

/// All functions of a file, tests among them.
#[must_use]
pub fn functions(file: &SourceFile) -> Vec<Function> {
    let mut functions = Functions { path: &file.path, found: Vec::new() };
    functions.visit_file(&file.syntax);
    functions.found
}

struct Constants<'a> {
    path: &'a str,
    found: Vec<(String, String)>,
}

impl<'a> Visit<'a> for Constants<'_> {
    fn visit_item_const(&mut self, c: &'a syn::ItemConst) {
        self.found.push((c.ident.to_string(), format!("{}:{}", self.path, c.ident.span().start().line)));
        visit::visit_item_const(self, c);
    }
    fn visit_impl_item_const(&mut self, c: &'a syn::ImplItemConst) {
        self.found.push((c.ident.to_string(), format!("{}:{}", self.path, c.ident.span().start().line)));
    }
    fn visit_item_static(&mut self, c: &'a syn::ItemStatic) {
        self.found.push((c.ident.to_string(), format!("{}:{}", self.path, c.ident.span().start().line)));
    }
}

/// Constants of a file whose whole name is in the word list: name and place.
#[must_use]
pub fn vague_constants(file: &SourceFile, words: &BTreeSet<String>) -> Vec<(String, String)> {
    let mut constants = Constants { path: &file.path, found: Vec::new() };
    constants.visit_file(&file.syntax);
    constants.found.retain(|(name, _)| words.contains(name));
    constants.found
}

struct Types<'a> {
    place: &'a str,
    found: &'a mut BTreeMap<String, BTreeSet<String>>,
}

impl<'a> Types<'a> {
    fn add(&mut self, name: &syn::Ident) {
        self.found.entry(name.to_string()).or_default().insert(self.place.to_string());
    }
}

impl<'a> Visit<'a> for Types<'_> {
    fn visit_item_mod(&mut self, m: &'a syn::ItemMod) {
        if !is_test_only(&m.attrs) {
            visit::visit_item_mod(self, m);
        }
    }
    fn visit_item_struct(&mut self, s: &'a syn::ItemStruct) {
        self.add(&s.ident);
    }
    fn visit_item_enum(&mut self, s: &'a syn::ItemEnum) {
        self.add(&s.ident);
    }
    fn visit_item_trait(&mut self, s: &'a syn::ItemTrait) {
        self.add(&s.ident);
        visit::visit_item_trait(self, s);
    }
    fn visit_item_type(&mut self, s: &'a syn::ItemType) {
        self.add(&s.ident);
    }
    fn visit_item_union(&mut self, s: &'a syn::ItemUnion) {
        self.add(&s.ident);
    }
}

/// The files that define a type of each name, over the libraries of the workspace.
#[must_use]
pub fn type_names(files: &[SourceFile]) -> BTreeMap<String, BTreeSet<String>> {
    let mut found = BTreeMap::new();
    for file in files.iter().filter(|f| f.role == Role::Library && !is_test_file(&f.path)) {
        Types { place: &file.path, found: &mut found }.visit_file(&file.syntax);
    }
    found
}

/// True for files of unit tests below `src/`: `tests.rs`, `…_tests.rs` and what lies in a folder `tests/`.
#[must_use]
pub fn is_test_file(path: &str) -> bool {
    path.ends_with("/tests.rs") || path.ends_with("_tests.rs") || path.contains("/tests/")
}
