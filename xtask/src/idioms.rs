//! Idioms that make a signature or a branch harder to read than plain Rust: parameters that are tuples, `match` on booleans, thread-local state, and
//! arithmetic on the first index of a range of zones.
//!
//! Shipped code alone is searched: `crates/*/src`, `python/src` and `mpi/src` without tests. The bodies of macros are not parsed.

use crate::shape::is_test_file;
use crate::source::{Role, SourceFile, is_test_only};
use std::collections::BTreeSet;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

/// Methods of the zones of a scene that return the first index of a range.
const ZONE_RANGE_STARTS: [&str; 2] = ["voxel_offset", "pane_offset"];

/// The places of the idioms in the shipped code, each "path:line", with the name of the function where it has one.
#[derive(Default)]
pub struct Idioms {
    /// Parameters of functions whose pattern is a tuple, or whose type is a tuple of two or more values, under a name of its own or not, or a
    /// reference to one. Closures do not count, nor do methods of trait implementations, whose signature the trait states.
    pub tuple_parameters: Vec<String>,
    /// `match` expressions all of whose patterns are made of `true`, `false`, names and tuples of these, and `match ()`, whose guards are conditions.
    pub bool_matches: Vec<String>,
    /// Uses of `thread_local!`.
    pub thread_locals: Vec<String>,
    /// Calls of `ZONE_RANGE_STARTS`.
    pub zone_range_starts: Vec<String>,
}

/// Finds the idioms of all shipped code among the files.
#[must_use]
pub fn find(files: &[SourceFile]) -> Idioms {
    let mut idioms = Idioms::default();
    let shipped: Vec<&SourceFile> = files.iter().filter(|f| is_shipped(f)).collect();
    let aliases = shipped.iter().flat_map(|f| tuple_aliases(f)).collect();
    for file in shipped {
        Search { path: &file.path, aliases: &aliases, found: &mut idioms }.visit_file(&file.syntax);
    }
    idioms
}

/// Names of the types at the root of a file that stand for a tuple.
fn tuple_aliases(file: &SourceFile) -> Vec<String> {
    let alias = |item: &syn::Item| match item {
        syn::Item::Type(alias) if is_tuple(&alias.ty, &BTreeSet::new()) => Some(alias.ident.to_string()),
        _ => None,
    };
    file.syntax.items.iter().filter_map(alias).collect()
}

fn is_shipped(file: &SourceFile) -> bool {
    let source = file.role == Role::Library
        || file.path.starts_with("python/src/")
        || file.path.starts_with("mpi/src/");
    source && !is_test_file(&file.path)
}

struct Search<'a> {
    path: &'a str,
    /// Names that stand for a tuple.
    aliases: &'a BTreeSet<String>,
    found: &'a mut Idioms,
}

impl Search<'_> {
    fn place(&self, spanned: &impl Spanned) -> String {
        format!("{}:{}", self.path, spanned.span().start().line)
    }

    fn signature(&mut self, signature: &syn::Signature) {
        for input in &signature.inputs {
            if let syn::FnArg::Typed(parameter) = input
                && (matches!(&*parameter.pat, syn::Pat::Tuple(_)) || is_tuple(&parameter.ty, self.aliases))
            {
                self.found.tuple_parameters.push(format!("{} {}", self.place(parameter), signature.ident));
            }
        }
    }
}

/// True for a tuple of two or more types, a name that stands for one, and a reference to one.
fn is_tuple(ty: &syn::Type, aliases: &BTreeSet<String>) -> bool {
    match ty {
        syn::Type::Tuple(tuple) => tuple.elems.len() > 1,
        syn::Type::Reference(reference) => is_tuple(&reference.elem, aliases),
        syn::Type::Paren(inner) => is_tuple(&inner.elem, aliases),
        syn::Type::Path(path) => {
            path.path.segments.last().is_some_and(|s| aliases.contains(&s.ident.to_string()))
        }
        _ => false,
    }
}

/// The number of `true`, `false` and `()` in a pattern made of them, names and tuples; `None` for another pattern.
fn constants(pattern: &syn::Pat) -> Option<usize> {
    match pattern {
        syn::Pat::Lit(literal) => matches!(literal.lit, syn::Lit::Bool(_)).then_some(1),
        syn::Pat::Wild(_) => Some(0),
        syn::Pat::Ident(name) => name.subpat.is_none().then_some(0),
        syn::Pat::Tuple(tuple) if tuple.elems.is_empty() => Some(1),
        syn::Pat::Tuple(tuple) => tuple.elems.iter().map(constants).sum(),
        syn::Pat::Or(or) => or.cases.iter().map(constants).sum(),
        syn::Pat::Paren(inner) => constants(&inner.pat),
        _ => None,
    }
}

impl<'a> Visit<'a> for Search<'_> {
    fn visit_item_mod(&mut self, module: &'a syn::ItemMod) {
        if !is_test_only(&module.attrs) {
            visit::visit_item_mod(self, module);
        }
    }
    fn visit_item_fn(&mut self, function: &'a syn::ItemFn) {
        if !is_test_only(&function.attrs) {
            self.signature(&function.sig);
            visit::visit_item_fn(self, function);
        }
    }
    fn visit_item_impl(&mut self, block: &'a syn::ItemImpl) {
        if is_test_only(&block.attrs) {
            return;
        }
        for item in &block.items {
            if let (syn::ImplItem::Fn(method), None) = (item, &block.trait_)
                && !is_test_only(&method.attrs)
            {
                self.signature(&method.sig);
            }
        }
        visit::visit_item_impl(self, block);
    }
    fn visit_impl_item_fn(&mut self, method: &'a syn::ImplItemFn) {
        if !is_test_only(&method.attrs) {
            visit::visit_impl_item_fn(self, method);
        }
    }
    fn visit_trait_item_fn(&mut self, method: &'a syn::TraitItemFn) {
        self.signature(&method.sig);
        visit::visit_trait_item_fn(self, method);
    }
    fn visit_expr_match(&mut self, expression: &'a syn::ExprMatch) {
        let counts: Option<Vec<usize>> = expression.arms.iter().map(|arm| constants(&arm.pat)).collect();
        if counts.is_some_and(|c| c.iter().sum::<usize>() > 0) {
            self.found.bool_matches.push(self.place(&expression.match_token));
        }
        visit::visit_expr_match(self, expression);
    }
    fn visit_macro(&mut self, invocation: &'a syn::Macro) {
        if invocation.path.segments.last().is_some_and(|s| s.ident == "thread_local") {
            self.found.thread_locals.push(self.place(&invocation.path));
        }
    }
    fn visit_expr_method_call(&mut self, call: &'a syn::ExprMethodCall) {
        if ZONE_RANGE_STARTS.iter().any(|name| call.method == name) {
            self.found.zone_range_starts.push(self.place(&call.method));
        }
        visit::visit_expr_method_call(self, call);
    }
}

#[cfg(test)]
mod tests {
    use super::find;
    use crate::source::SourceFile;

    fn idioms(text: &str) -> [usize; 4] {
        let found = find(&[SourceFile::from_text("crates/a/src/lib.rs".into(), text.into())]);
        [found.tuple_parameters, found.bool_matches, found.thread_locals, found.zone_range_starts]
            .map(|places| places.len())
    }

    #[test]
    fn tuples_in_signatures_are_found_and_closures_units_and_trait_implementations_are_not() {
        assert_eq!(idioms("fn f((a, b): (u8, u8), c: &(u8, u8), d: Vec<(u8, u8)>) {}")[0], 2);
        assert_eq!(idioms("type P = (u8, u8); fn f(a: P, b: &P, c: &[P]) {}")[0], 2);
        assert_eq!(idioms("fn f(a: ()) { let g = |(a, b): (u8, u8)| a + b; }")[0], 0);
        assert_eq!(idioms("trait T { fn f(a: (u8, u8)); } impl T for u8 { fn f(a: (u8, u8)) {} }")[0], 1);
        assert_eq!(idioms("#[cfg(test)] mod tests { fn f(a: (u8, u8)) {} }")[0], 0);
    }

    #[test]
    fn matches_on_booleans_are_found_and_matches_on_other_values_beside_them_are_not() {
        assert_eq!(idioms("fn f(a: bool) -> u8 { match a { true => 1, false => 0 } }")[1], 1);
        assert_eq!(idioms("fn f(a: bool, b: bool) -> u8 { match (a, b) { (true, _) => 1, _ => 0 } }")[1], 1);
        assert_eq!(
            idioms("fn f(a: bool, b: Option<u8>) -> u8 { match (a, b) { (true, Some(b)) => b, _ => 0 } }")[1],
            0
        );
        assert_eq!(idioms("fn f(a: u8) -> u8 { match a { 0 => 1, n => n } }")[1], 0);
        assert_eq!(idioms("fn f(a: u8) -> u8 { match a { n if n > 3 => 1, _ => 0 } }")[1], 0);
        assert_eq!(idioms("fn f(a: bool) -> u8 { match () { () if a => 1, () => 0 } }")[1], 1);
        assert_eq!(idioms("fn f(a: Option<u8>) -> u8 { match a { None => 1, _ => 0 } }")[1], 0);
    }

    #[test]
    fn thread_locals_and_starts_of_zone_ranges_are_found() {
        assert_eq!(
            idioms("thread_local! { static A: u8 = 0; } fn f() { thread_local! { static B: u8 = 0; } }")[2],
            2
        );
        assert_eq!(
            idioms("fn f(z: &Zones, i: usize) -> bool { i < z.voxel_offset() || i < z.pane_offset() }")[3],
            2
        );
    }
}
