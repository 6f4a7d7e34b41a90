//! The rules of the house that ARCHITECTURE.md states, read from the files themselves.
//!
//! Each rule is a function from text to complaints, and each is tried on a bad sample too, so that it is known to be able to
//! fail.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The arrows: every crate with exactly those of the others that it depends on.
const ARROWS: [(&str, &[&str]); 9] = [
    ("math", &[]),
    ("scene", &["math"]),
    ("transport", &["math", "scene"]),
    ("exchange", &["math", "scene", "transport"]),
    ("solve", &["math", "scene", "transport", "exchange"]),
    ("render", &["math", "scene", "transport"]),
    ("io", &["math", "scene"]),
    ("reference", &["math", "scene"]),
    ("zonal", &["math", "scene", "transport", "exchange", "solve", "render", "io"]),
];

/// What tests may use beyond their crate's own arrows: the oracle, and scenes written as files.
const FOR_TESTS: [&str; 2] = ["reference", "io"];

/// The crates that know nothing of the outside.
const BELOW_THE_EDGE: [&str; 6] = ["math", "scene", "transport", "exchange", "solve", "render"];

/// Paths in `std` that touch the outside.
const OUTSIDE: [&str; 5] = ["fs", "net", "time", "env", "process"];

/// Other words that do.
const WORDS: [&str; 5] = ["serde", "println!", "eprintln!", "print!", "dbg!"];

const MAX_LINES: usize = 600;
const MAX_ARCHITECTURE: usize = 200;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Rust files below a folder, sorted.
fn sources(folder: &str) -> Vec<(String, String)> {
    let (mut open, mut found) = (vec![root().join(folder)], Vec::new());
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display())) {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let name = path.strip_prefix(root()).unwrap().display().to_string();
                found.push((name, std::fs::read_to_string(&path).unwrap()));
            }
        }
    }
    found.sort();
    found
}

fn none(complaints: Vec<String>) {
    assert!(complaints.is_empty(), "\n{}\n", complaints.join("\n"));
}

// Manifests.

#[derive(Default)]
struct Manifest {
    normal: BTreeSet<String>,
    dev: BTreeSet<String>,
    external: BTreeSet<String>,
    lints: bool,
}

/// The sections that name dependencies, and our crates in them under whatever name.
fn manifest(text: &str) -> Manifest {
    let mut m = Manifest::default();
    let mut section = String::new();
    for line in text.lines().map(|l| l.split('#').next().unwrap_or("").trim()).filter(|l| !l.is_empty()) {
        if line.starts_with('[') {
            section = line.trim_matches(['[', ']']).to_string();
        }
        let kind = section.split('.').find(|s| s.ends_with("dependencies"));
        let Some(kind) = kind else {
            m.lints |= section == "lints" && line.replace(' ', "") == "workspace=true";
            continue;
        };
        // `[dependencies.x]` names x itself, and so does every line of `[dependencies]` before its first `=` or dot.
        let is_header = line.starts_with('[');
        let last = section.rsplit('.').next().unwrap_or("");
        let name = if is_header { last } else { line.split(['=', '.', ' ']).next().unwrap_or("") };
        let words: BTreeSet<&str> =
            line.split(|c: char| !(c.is_alphanumeric() || c == '-' || c == '_')).collect();
        let ours =
            words.iter().filter_map(|w| w.strip_prefix("zonal-").or((*w == "zonal").then_some("zonal")));
        let ours: Vec<String> = ours.map(str::to_string).collect();
        if ours.is_empty() && !name.ends_with("dependencies") && (is_header || last.ends_with("dependencies"))
        {
            m.external.insert(name.trim_matches('"').to_string());
        }
        if kind == "dev-dependencies" { m.dev.extend(ours) } else { m.normal.extend(ours) }
    }
    m
}

fn wrong_arrows(name: &str, text: &str) -> Vec<String> {
    let Some((_, allowed)) = ARROWS.iter().find(|a| a.0 == name) else {
        return vec![format!(
            "{name}: this crate has no place among the arrows; give it one here and in ARCHITECTURE.md"
        )];
    };
    let allowed: BTreeSet<String> = allowed.iter().map(|s| s.to_string()).collect();
    let m = manifest(text);
    let mut out = Vec::new();
    if m.normal != allowed {
        out.push(format!("{name}: depends on {:?}, the arrows say {allowed:?}", m.normal));
    }
    out.extend(m.dev.iter().filter(|d| !allowed.contains(*d) && !FOR_TESTS.contains(&d.as_str())).map(|d| {
        format!("{name}: its tests depend on {d}; they may use what it depends on, and {FOR_TESTS:?}")
    }));
    if !m.lints {
        out.push(format!("{name}: [lints] workspace = true is missing"));
    }
    if BELOW_THE_EDGE.contains(&name)
        && m.external.iter().any(|e| e.starts_with("serde") || e == "log" || e == "tracing")
    {
        out.push(format!("{name}: serialisation and logging stay at the edge: {:?}", m.external));
    }
    out
}

#[test]
fn arrows() {
    let mut found: Vec<String> = std::fs::read_dir(root().join("crates"))
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .filter(|n| root().join("crates").join(n).join("Cargo.toml").exists())
        .collect();
    found.sort();
    assert_eq!(found.len(), ARROWS.len(), "{found:?}");
    none(found.iter().flat_map(|n| wrong_arrows(n, &read(format!("crates/{n}/Cargo.toml")))).collect());
    // The names mean what they say.
    let workspace = read("Cargo.toml");
    for (name, _) in ARROWS.iter().filter(|a| a.0 != "zonal") {
        assert!(workspace.contains(&format!("zonal-{name} = {{ path = \"crates/{name}\" }}")), "{name}");
        assert!(
            read(format!("crates/{name}/Cargo.toml")).contains(&format!("name = \"zonal-{name}\"")),
            "{name}"
        );
    }
    assert!(workspace.contains("unsafe_code = \"forbid\""));
}

#[test]
fn wrong_arrows_are_noticed() {
    const SOUND: &str = "[package]\nname = \"zonal-scene\"\n[lints]\nworkspace = true\n[dependencies]\nzonal-math = { workspace = true }\n";
    assert!(wrong_arrows("scene", SOUND).is_empty());
    let with = |more: &str| wrong_arrows("scene", &format!("{SOUND}{more}\n")).len();
    assert_eq!(with("zonal-solve = { workspace = true }"), 1);
    assert_eq!(with("zonal-solve.workspace = true"), 1);
    assert_eq!(with("harmless = { package = \"zonal-solve\", path = \"../solve\" }"), 1);
    assert_eq!(with("harmless = { path = \"../zonal\" }"), 1);
    assert_eq!(with("[dependencies.zonal-io]\nworkspace = true"), 1);
    assert_eq!(with("[target.'cfg(unix)'.dependencies]\nzonal-io = { workspace = true }"), 1);
    assert_eq!(with("[build-dependencies]\nzonal-io = { workspace = true }"), 1);
    assert_eq!(with("[dev-dependencies]\nzonal-solve = { workspace = true }"), 1);
    assert_eq!(with("[dev-dependencies]\nzonal-reference = { workspace = true }"), 0);
    assert_eq!(with("zonal-reference = { workspace = true }"), 1);
    assert_eq!(with("serde = \"1\""), 1);
    assert_eq!(with("[dependencies.serde_json]\nversion = \"1\""), 1);
    assert_eq!(wrong_arrows("scene", &SOUND.replace("zonal-math", "# zonal-math")).len(), 1);
    assert_eq!(wrong_arrows("scene", &SOUND.replace("[lints]\nworkspace = true", "")).len(), 1);
    assert_eq!(wrong_arrows("newcomer", SOUND).len(), 1);
}

// Sources.

/// Code without its comments, on one line.
fn code(text: &str) -> String {
    let lines = text.lines().map(|l| l.split("//").next().unwrap_or(""));
    lines.flat_map(|l| [l.trim(), " "]).collect()
}

/// What follows `word` wherever it stands on its own.
fn after<'t>(code: &'t str, word: &str) -> Vec<&'t str> {
    let alone = |at: &usize| !code[..*at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
    code.match_indices(word).map(|(at, _)| at).filter(alone).map(|at| &code[at + word.len()..]).collect()
}

/// The outermost names of a list in braces whose opening brace is already read.
fn listed(text: &str) -> Vec<String> {
    let (mut depth, mut names) = (0, vec![String::new()]);
    for c in text.chars() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => names.push(String::new()),
            c if depth == 0 && !c.is_whitespace() => names.last_mut().unwrap().push(c),
            _ => {}
        }
    }
    names
}

fn outside(file: &str, text: &str) -> Vec<String> {
    let code = code(text);
    let mut found: Vec<String> =
        WORDS.iter().filter(|w| !after(&code, w).is_empty()).map(|w| w.to_string()).collect();
    for rest in after(&code, "std::") {
        let names = rest.strip_prefix('{').map_or_else(|| vec![rest.to_string()], listed);
        for name in names {
            let first = name.split(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or("");
            found.extend(OUTSIDE.contains(&first).then(|| format!("std::{first}")));
        }
    }
    found.iter().map(|w| format!("{file}: {w} has no place below the edge")).collect()
}

#[test]
fn below_the_edge_nothing_knows_the_outside() {
    let files = BELOW_THE_EDGE.iter().flat_map(|c| sources(&format!("crates/{c}/src")));
    none(files.flat_map(|(name, text)| outside(&name, &text)).collect());
}

#[test]
fn the_outside_is_noticed() {
    for (bad, count) in [
        ("use std::fs;", 1),
        ("let t = std::time::Instant::now();", 1),
        ("use std::{fmt, net::TcpStream};", 1),
        ("use std::{\n    collections::{BTreeMap, HashMap},\n    fs::{self, File},\n    time,\n};", 2),
        ("use ::std::env::var;", 1),
        ("println!(\"{x}\");", 1),
        ("eprintln!();", 1),
        ("#[derive(serde::Serialize)]", 1),
        ("use serde_json::Value;", 1),
        ("dbg!(x)", 1),
    ] {
        assert_eq!(outside("bad.rs", bad).len(), count, "{bad}");
    }
    for good in [
        "// nothing of std::fs here",
        "/// No std::time, no serde.",
        "use std::{fmt, f64::consts::PI};",
        "let x = env!(\"CARGO_PKG_VERSION\");",
        "mod timefs; use std::io_time::x;",
        "use std::collections::{fs_like, time_like};",
    ] {
        assert!(outside("good.rs", good).is_empty(), "{good}");
    }
}

/// Tests switched off, work left undone, files too long.
fn unfinished(file: &str, text: &str) -> Vec<String> {
    let code = code(text);
    let mut out = Vec::new();
    for word in [concat!("#[", "ignore"), concat!("todo", "!"), concat!("unimplemented", "!")] {
        if !after(&code, word).is_empty() {
            out.push(format!("{file}: {word}"));
        }
    }
    let lines = text.lines().count();
    if lines > MAX_LINES {
        out.push(format!("{file}: {lines} lines, more than {MAX_LINES}; divide it"));
    }
    out
}

#[test]
fn no_test_is_switched_off_and_no_file_is_too_long() {
    none(sources("crates").iter().flat_map(|(name, text)| unfinished(name, text)).collect());
}

/// The viewer's page is small files too.
#[test]
fn no_file_of_the_page_is_too_long() {
    for folder in ["viewer/src", "viewer/test/unit", "viewer/test/browser"] {
        for entry in std::fs::read_dir(root().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let lines = std::fs::read_to_string(&path).unwrap().lines().count();
            assert!(
                lines <= MAX_LINES,
                "{}: {lines} lines, more than {MAX_LINES}; divide it",
                path.display()
            );
        }
    }
}

#[test]
fn unfinished_work_is_noticed() {
    assert_eq!(unfinished("a.rs", concat!("#[", "ignore = \"slow\"]\n#[test]\nfn f() {}")).len(), 1);
    assert_eq!(unfinished("a.rs", concat!("fn f() { todo", "!() }")).len(), 1);
    assert_eq!(unfinished("a.rs", concat!("fn f() { unimplemented", "!(\"later\") }")).len(), 1);
    assert_eq!(unfinished("a.rs", &"x\n".repeat(MAX_LINES + 1)).len(), 1);
    assert!(unfinished("a.rs", &"x\n".repeat(MAX_LINES)).is_empty());
}

// Documents.

/// Guards are written `path/to/file.rs::test_name`, relative to `crates`; a name without a file is of this one.
fn missing_guards(document: &str, text_of: impl Fn(&str) -> Option<String>) -> Vec<String> {
    let quoted = document.split('`').skip(1).step_by(2);
    let guards = quoted.filter_map(|q| q.split_once(".rs::"));
    guards
        .filter(|(file, test)| {
            let holds = |t: String| t.contains(&format!("fn {test}("));
            !text_of(&format!("crates/{file}.rs")).is_some_and(holds)
        })
        .map(|(file, test)| format!("ARCHITECTURE.md names a guard that is not there: {file}.rs::{test}"))
        .collect()
}

#[test]
fn the_map_is_short_and_its_guards_exist() {
    let document = read("ARCHITECTURE.md");
    let lines = document.lines().count();
    assert!(lines <= MAX_ARCHITECTURE, "ARCHITECTURE.md has {lines} lines; {MAX_ARCHITECTURE} are allowed");
    assert!(document.matches(".rs::").count() >= 10, "ARCHITECTURE.md names hardly any guards");
    none(missing_guards(&document, |p| std::fs::read_to_string(root().join(p)).ok()));
    for (name, _) in ARROWS {
        assert!(
            document.contains(&format!("`{name}`")) || document.contains(&format!("crates/{name}")),
            "{name} is not on the map"
        );
    }
}

#[test]
fn missing_guards_are_noticed() {
    let file = |path: &str| (path == "crates/a.rs").then(|| "fn there() {}".to_string());
    assert!(missing_guards("`a.rs::there` and `b`", file).is_empty());
    assert_eq!(missing_guards("`a.rs::gone` or `b.rs::there`", file).len(), 2);
}

#[test]
fn the_readme_begins_with_its_two_commands() {
    let readme = read("README.md");
    let mut lines = readme.lines().map(|l| l.split('#').next().unwrap_or("").trim());
    assert_eq!(lines.next(), Some("cargo run --release -- demo"));
    assert_eq!(lines.next(), Some("cargo test"));
}
