//! Counts of the structure of code and documents, each with its limit.
//!
//! Guards (structure): functions are short and have few parameters, names of constants and types say what they mean, no public item is unused,
//!     folders form no cycle and have few entries, and lines of prose are short.

use crate::source::{Role, SourceFile, load};
use crate::{documents, idioms, modules, shape, surface};
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// Longest function, lines.
const MAX_FUNCTION_LINES: usize = 80;
/// Length from which a function counts as long, lines.
const LONG_FUNCTION_LINES: usize = 50;
/// Most functions that may be long.
const MAX_LONG_FUNCTIONS: usize = 20;
/// Most parameters of a function, `self` counted.
const MAX_PARAMETERS: usize = 7;
/// Most parameters that are tuples.
const MAX_TUPLE_PARAMETERS: usize = 15;
/// Most matches on booleans.
const MAX_BOOL_MATCHES: usize = 0;
/// Most uses of thread-local state.
const MAX_THREAD_LOCALS: usize = 0;
/// Most calls that return the first index of a range of zones.
const MAX_ZONE_RANGE_STARTS: usize = 51;
/// Most items, methods included, that can be named from the library `zonal`.
const MAX_REACHABLE_ITEMS: usize = 300;
/// Most lines of the library crate `zonal`.
const MAX_FACADE_LINES: usize = 300;
/// Fewest executed doctests.
const MIN_DOCTESTS: usize = 40;
/// Most type names that two modules share.
const MAX_SHARED_TYPE_NAMES: usize = 10;
/// Type names that any number of modules may use.
const EXEMPT_TYPE_NAMES: [&str; 2] = ["Args", "Error"];
/// Crates that the library must not pull in: command line, plots, fonts.
const FORBIDDEN_DEPENDENCIES: [&str; 7] =
    ["clap", "ctrlc", "indicatif", "nix", "noto-sans-mono-bitmap", "plotters", "console"];

/// One count against its limit.
pub struct Count {
    /// The thing counted.
    pub title: &'static str,
    /// The count.
    pub value: usize,
    /// The limit.
    pub limit: Limit,
    /// The places counted.
    pub places: Vec<String>,
}

/// A limit of a count.
#[derive(Clone, Copy)]
pub enum Limit {
    /// No more than this.
    AtMost(usize),
    /// No fewer than this.
    AtLeast(usize),
}

impl Count {
    /// Whether the count keeps its limit.
    #[must_use]
    pub fn holds(&self) -> bool {
        match self.limit {
            Limit::AtMost(n) => self.value <= n,
            Limit::AtLeast(n) => self.value >= n,
        }
    }

    fn of(title: &'static str, limit: usize, places: Vec<String>) -> Count {
        Count { title, value: places.len(), limit: Limit::AtMost(limit), places }
    }
}

/// Words that say nothing as the whole name of a constant: adjectives, quantifiers, adverbs.
fn vague_words() -> BTreeSet<String> {
    include_str!("../vague_constant_names.txt")
        .lines()
        .filter(|l| !l.starts_with('#'))
        .flat_map(str::split_whitespace)
        .map(str::to_uppercase)
        .collect()
}

/// All counts of a workspace.
#[must_use]
pub fn count(root: &Path) -> Vec<Count> {
    let files = load(root);
    let mut counts = Vec::from(cycle_counts(&files));
    counts.push(folder_count(&files));
    counts.extend(surface_counts(&files));
    counts.extend(function_counts(&files));
    counts.extend(idiom_counts(&files));
    counts.push(constant_count(&files));
    counts.extend(type_counts(&files));
    counts.push(dependency_count(root));
    let long_lines = documents::places_of_long_lines(root);
    counts.push(Count::of("lines of prose above 160 characters in documents", 0, long_lines));
    counts
}

/// The cycles of a crate, each a list of its edges.
type Cycles<'a> = &'a dyn Fn(&[SourceFile], &str) -> Vec<Vec<String>>;

fn cycle_counts(files: &[SourceFile]) -> [Count; 2] {
    let packages: BTreeSet<&str> = files.iter().map(|f| f.package.as_str()).collect();
    let count = |name: &'static str, find: Cycles| {
        let cycles = packages.iter().flat_map(|p| find(files, p));
        let places =
            cycles.map(|c| format!("cycle of {} edges:\n      {}", c.len(), c.join("\n      "))).collect();
        Count::of(name, 0, places)
    };
    [
        count("cycles of modules inside crates", &modules::cycles),
        count("cycles of folders inside crates", &modules::folder_cycles),
    ]
}

/// Most entries of a folder.
const MAX_ENTRIES: usize = 18;

fn folder_count(files: &[SourceFile]) -> Count {
    let full = modules::entries_of_folders(files).into_iter().filter(|(_, entries)| *entries > MAX_ENTRIES);
    let places = full.map(|(folder, entries)| format!("{folder}: {entries} entries")).collect();
    Count::of("folders of source of more than 18 entries", 0, places)
}

fn surface_counts(files: &[SourceFile]) -> [Count; 4] {
    let reachable: Vec<String> = surface::reachable_items(files).into_iter().collect();
    let unused = surface::unused_public_items(files).into_iter().map(|(n, p)| format!("{p} {n}")).collect();
    let facade = files.iter().filter(|f| f.package == "zonal" && f.role == Role::Library);
    let doctests = surface::executed_doctests(files);
    [
        Count::of("items and methods reachable from crate zonal", MAX_REACHABLE_ITEMS, reachable),
        Count::of("pub items that nothing outside their crate names", 0, unused),
        Count {
            title: "lines of crate zonal",
            value: facade.map(|f| f.text.lines().count()).sum(),
            limit: Limit::AtMost(MAX_FACADE_LINES),
            places: Vec::new(),
        },
        Count {
            title: "executed doctests",
            value: doctests,
            limit: Limit::AtLeast(MIN_DOCTESTS),
            places: Vec::new(),
        },
    ]
}

fn function_counts(files: &[SourceFile]) -> [Count; 4] {
    let all: Vec<shape::Function> = files.iter().flat_map(shape::functions).collect();
    let places = |keep: &dyn Fn(&shape::Function) -> bool, measure: &dyn Fn(&shape::Function) -> usize| {
        let mut kept: Vec<&shape::Function> = all.iter().filter(|f| keep(f)).collect();
        kept.sort_by_key(|f| std::cmp::Reverse(measure(f)));
        kept.iter().map(|f| format!("{} {} ({})", f.place, f.name, measure(f))).collect::<Vec<_>>()
    };
    let lines = |f: &shape::Function| f.lines;
    [
        Count::of("functions above 80 lines", 0, places(&|f| f.lines > MAX_FUNCTION_LINES, &lines)),
        Count::of(
            "functions above 50 lines",
            MAX_LONG_FUNCTIONS,
            places(&|f| f.lines > LONG_FUNCTION_LINES, &lines),
        ),
        Count::of(
            "functions of more than seven parameters",
            0,
            places(&|f| f.parameters > MAX_PARAMETERS, &|f| f.parameters),
        ),
        Count::of(
            "bool parameters of public functions",
            0,
            places(&|f| f.public && f.bools > 0 && !f.setter, &|f| f.bools),
        ),
    ]
}

fn idiom_counts(files: &[SourceFile]) -> [Count; 4] {
    let idioms = idioms::find(files);
    [
        Count::of("tuple-typed parameters", MAX_TUPLE_PARAMETERS, idioms.tuple_parameters),
        Count::of("match on a bool", MAX_BOOL_MATCHES, idioms.bool_matches),
        Count::of("thread_local in shipped code", MAX_THREAD_LOCALS, idioms.thread_locals),
        Count::of("arithmetic on range starts of zones", MAX_ZONE_RANGE_STARTS, idioms.zone_range_starts),
    ]
}

fn constant_count(files: &[SourceFile]) -> Count {
    let words = vague_words();
    let found = files.iter().flat_map(|f| shape::vague_constants(f, &words));
    Count::of("constants named by a vague word", 0, found.map(|(n, p)| format!("{p} {n}")).collect())
}

fn type_counts(files: &[SourceFile]) -> [Count; 2] {
    let names = shape::type_names(files);
    let shared = |least: usize, most: usize| {
        let kept = names.iter().filter(|(name, places)| {
            !EXEMPT_TYPE_NAMES.contains(&name.as_str()) && places.len() >= least && places.len() <= most
        });
        kept.map(|(n, p)| format!("{n}: {}", p.iter().cloned().collect::<Vec<_>>().join(" "))).collect()
    };
    [
        Count::of("type names in three or more modules", 0, shared(3, usize::MAX)),
        Count::of("type names in two modules", MAX_SHARED_TYPE_NAMES, shared(2, 2)),
    ]
}

fn dependency_count(root: &Path) -> Count {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let tree = Command::new(cargo)
        .args(["tree", "-p", "zonal", "-e", "normal", "--prefix", "none", "--locked", "--offline"])
        .current_dir(root)
        .output();
    let found = match tree {
        Ok(out) if out.status.success() => {
            let text = String::from_utf8_lossy(&out.stdout).into_owned();
            let names: BTreeSet<&str> = text.lines().filter_map(|l| l.split(' ').next()).collect();
            FORBIDDEN_DEPENDENCIES.iter().filter(|d| names.contains(**d)).map(|d| d.to_string()).collect()
        }
        Ok(out) => vec![format!("cargo tree failed: {}", String::from_utf8_lossy(&out.stderr).trim())],
        Err(e) => vec![format!("cargo tree could not be started: {e}")],
    };
    Count::of("command-line, plot and font crates below crate zonal", 0, found)
}

/// Prints all counts; with `list` every place. Returns whether all limits are kept.
#[must_use]
pub fn report(root: &Path, list: bool) -> bool {
    let counts = count(root);
    for c in &counts {
        let limit = match c.limit {
            Limit::AtMost(n) => format!("at most {n}"),
            Limit::AtLeast(n) => format!("at least {n}"),
        };
        let verdict = if c.holds() { "pass" } else { "FAIL" };
        println!("{verdict}  {:>5}  {limit:<12}  {}", c.value, c.title);
        if list || !c.holds() {
            c.places.iter().for_each(|p| println!("      {p}"));
        }
    }
    counts.iter().all(Count::holds)
}
