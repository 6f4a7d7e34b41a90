//! The structure that ARCHITECTURE.md describes, checked on the files of the workspace.
//!
//! Each rule is a function from text to violations, and is also applied to a bad sample, which it must detect.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use xtask::source::SourceFile;

/// Every crate with exactly the other crates on which it depends.
const DEPENDENCIES: [(&str, &[&str]); 18] = [
    ("math", &[]),
    ("fourier", &[]),
    ("scene", &["math"]),
    ("transport", &["math", "scene"]),
    ("exchange", &["math", "scene", "transport"]),
    ("gas", &[]),
    ("view-factors", &["math", "scene", "exchange"]),
    ("paper", &["math", "scene", "exchange"]),
    ("solve", &["math", "fourier", "scene", "transport", "exchange"]),
    ("render", &["math", "scene", "transport"]),
    ("io", &["math", "scene", "gas"]),
    ("reference", &["math", "scene"]),
    ("zonal", &["scene", "solve", "render", "io"]),
    ("report", &["scene", "io"]),
    ("demo", &["math", "scene", "io"]),
    (
        "validation",
        &["math", "scene", "transport", "exchange", "paper", "solve", "render", "io", "report", "demo"],
    ),
    (
        "app",
        &[
            "math",
            "scene",
            "transport",
            "exchange",
            "gas",
            "view-factors",
            "paper",
            "solve",
            "render",
            "io",
            "report",
        ],
    ),
    (
        "cli",
        &[
            "app",
            "math",
            "scene",
            "gas",
            "view-factors",
            "solve",
            "render",
            "io",
            "report",
            "demo",
            "validation",
        ],
    ),
];

/// The native module of the Python package, in the folder `python`, with the crates on which it depends.
const PYTHON_MODULE: (&str, &[&str]) = (
    "python",
    &["math", "scene", "gas", "view-factors", "solve", "render", "io", "report", "validation", "app", "cli"],
);

/// The command of distributed solves, in the folder `mpi`, with the crates on which it depends.
const MPI_COMMAND: (&str, &[&str]) = ("mpi", &["cli", "math", "report", "solve"]);

/// Crates on which all tests may depend in addition: the reference solutions, and the scene format.
const TEST_DEPENDENCIES: [&str; 2] = ["reference", "io"];

/// Further crates on which the tests of one crate may depend.
const TEST_DEPENDENCIES_OF: [(&str, &str); 3] =
    [("paper", "transport"), ("solve", "paper"), ("demo", "transport")];

/// External crates that a crate of the library may use by an optional feature.
const OPTIONAL_IN_THE_LIBRARY: [(&str, &str); 2] = [("scene", "clap"), ("app", "clap")];

/// The font of legends, and the crate that draws them.
const FONT: (&str, &str) = ("app", "noto-sans-mono-bitmap");

/// External crates of the command, on which the library must not depend.
const NOT_IN_THE_LIBRARY: [&str; 6] =
    ["clap", "indicatif", "plotters", "noto-sans-mono-bitmap", "ctrlc", "nix"];

/// Crates without access to the operating system.
const CORE_CRATES: [&str; 10] =
    ["math", "fourier", "scene", "transport", "exchange", "gas", "view-factors", "paper", "solve", "render"];

/// Core crates whose types have serde's attributes; `io` alone encodes them.
const DESCRIBED_CRATES: [&str; 2] = ["math", "scene"];

/// Modules of `std` that access the operating system.
const SYSTEM_MODULES: [&str; 5] = ["fs", "net", "time", "env", "process"];

/// Other words that are not allowed in core crates: formats of files and printing.
const FORBIDDEN_WORDS: [&str; 6] = ["serde_json", "toml::", "println!", "eprintln!", "print!", "dbg!"];

/// Most lines of a source file.
const MAX_FILE_LINES: usize = 700;

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

fn assert_none(violations: Vec<String>) {
    assert!(violations.is_empty(), "\n{}\n", violations.join("\n"));
}

// Manifests.

#[derive(Default)]
struct Manifest {
    normal: BTreeSet<String>,
    dev: BTreeSet<String>,
    external: BTreeSet<String>,
    optional: BTreeSet<String>,
    lints: bool,
}

/// The dependencies of a manifest; crates of the workspace are found under any name.
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
        let inner =
            words.iter().filter_map(|w| w.strip_prefix("zonal-").or((*w == "zonal").then_some("zonal")));
        let inner: Vec<String> = inner.map(str::to_string).collect();
        if inner.is_empty()
            && !name.ends_with("dependencies")
            && (is_header || last.ends_with("dependencies"))
        {
            let name = name.trim_matches('"').to_string();
            if line.contains("optional = true") {
                m.optional.insert(name)
            } else {
                m.external.insert(name)
            };
        }
        if kind == "dev-dependencies" { m.dev.extend(inner) } else { m.normal.extend(inner) }
    }
    m
}

fn wrong_dependencies(name: &str, text: &str) -> Vec<String> {
    let Some((_, allowed)) = DEPENDENCIES.iter().chain([&PYTHON_MODULE, &MPI_COMMAND]).find(|a| a.0 == name)
    else {
        return vec![format!(
            "{name}: this crate is not in the list of dependencies; add it here and to ARCHITECTURE.md"
        )];
    };
    let allowed: BTreeSet<String> = allowed.iter().map(|s| s.to_string()).collect();
    let m = manifest(text);
    let mut out = Vec::new();
    if m.normal != allowed {
        out.push(format!("{name}: depends on {:?}, declared are {allowed:?}", m.normal));
    }
    let for_tests = |d: &str| TEST_DEPENDENCIES.contains(&d) || TEST_DEPENDENCIES_OF.contains(&(name, d));
    out.extend(m.dev.iter().filter(|d| !allowed.contains(*d) && !for_tests(d)).map(|d| {
        format!("{name}: its tests depend on {d}; they may use what it depends on, and {TEST_DEPENDENCIES:?}")
    }));
    if !["cli", "report", "python", "mpi"].contains(&name) {
        let of_command = |e: &&String| NOT_IN_THE_LIBRARY.contains(&e.as_str()) && (name, e.as_str()) != FONT;
        let outside = m.external.iter().filter(of_command);
        out.extend(outside.map(|e| format!("{name}: {e} belongs to the command")));
        let wrong = m.optional.iter().filter(|e| !OPTIONAL_IN_THE_LIBRARY.contains(&(name, e.as_str())));
        out.extend(wrong.map(|e| format!("{name}: {e} is not among the optional dependencies")));
    }
    if name == "zonal" && text.contains("features = [\"clap\"]") {
        out.push(format!("{name}: the library must not enable the feature clap"));
    }
    if !m.lints {
        out.push(format!("{name}: [lints] workspace = true is missing"));
    }
    let encodes = |e: &String| match e.as_str() {
        "serde" => !DESCRIBED_CRATES.contains(&name),
        e => e.starts_with("serde_") || e == "log" || e == "tracing",
    };
    if CORE_CRATES.contains(&name) && m.external.iter().any(encodes) {
        out.push(format!("{name}: serialisation and logging stay at the edge: {:?}", m.external));
    }
    out
}

// Guards (structure): crates depend on one another as ARCHITECTURE.md draws it: transport not on exchange factors, exchange not on solvers, render
//     not on solvers or exchange, io not on rays or solvers, no crate on the command.
// Guards (structure): `reference` is a dependency of tests alone; tests may also read scene files (io).
// Guards (structure): every crate takes the lints of the workspace, which forbid unsafe code; only the macros of pyo3 expand to it.
#[test]
fn crate_dependencies_are_as_declared() {
    let mut found: Vec<String> = std::fs::read_dir(root().join("crates"))
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .filter(|n| root().join("crates").join(n).join("Cargo.toml").exists())
        .collect();
    found.sort();
    assert_eq!(found.len(), DEPENDENCIES.len(), "{found:?}");
    assert_none(
        found.iter().flat_map(|n| wrong_dependencies(n, &read(format!("crates/{n}/Cargo.toml")))).collect(),
    );
    // Names of crates agree with their folders.
    let workspace = read("Cargo.toml");
    for (name, _) in DEPENDENCIES.iter().filter(|a| a.0 != "zonal") {
        assert!(workspace.contains(&format!("zonal-{name} = {{ path = \"crates/{name}\"")), "{name}");
        assert!(
            read(format!("crates/{name}/Cargo.toml")).contains(&format!("name = \"zonal-{name}\"")),
            "{name}"
        );
    }
    assert!(workspace.contains("unsafe_code = \"forbid\""));
}

// Guards (structure): the Python module and the command of MPI are no default members, so that `cargo test` needs neither Python nor MPI.
#[test]
fn the_python_module_and_the_command_of_mpi_are_no_default_members() {
    assert_none(wrong_dependencies("python", &read("python/Cargo.toml")));
    assert_none(wrong_dependencies("mpi", &read("mpi/Cargo.toml")));
    let workspace = read("Cargo.toml");
    assert!(
        workspace
            .contains("members = [\"benches\", \"campaigns\", \"crates/*\", \"mpi\", \"python\", \"xtask\"]")
    );
    assert!(workspace.contains("default-members = [\"crates/*\"]"));
    for folder in ["python/src", "mpi/src"] {
        assert_none(sources(folder).iter().flat_map(|(name, text)| unfinished(name, text)).collect());
    }
}

#[test]
fn wrong_crate_dependencies_are_detected() {
    const VALID: &str = "[package]\nname = \"zonal-scene\"\n[lints]\nworkspace = true\n[dependencies]\nzonal-math = { workspace = true }\n";
    assert!(wrong_dependencies("scene", VALID).is_empty());
    let with = |more: &str| wrong_dependencies("scene", &format!("{VALID}{more}\n")).len();
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
    assert_eq!(with("serde = \"1\""), 0);
    assert_eq!(with("serde_json = \"1\""), 1);
    let serde_in_gas = VALID.replace("zonal-math = { workspace = true }", "serde = \"1\"");
    assert_eq!(wrong_dependencies("gas", &serde_in_gas).len(), 1);
    assert_eq!(with("clap = \"4\""), 1);
    assert_eq!(with("clap = { version = \"4\", optional = true }"), 0);
    assert_eq!(with("plotters = { version = \"0.3\", optional = true }"), 1);
    assert_eq!(with("[dependencies.serde_json]\nversion = \"1\""), 1);
    assert_eq!(wrong_dependencies("scene", &VALID.replace("zonal-math", "# zonal-math")).len(), 1);
    assert_eq!(wrong_dependencies("scene", &VALID.replace("[lints]\nworkspace = true", "")).len(), 1);
    assert_eq!(wrong_dependencies("unlisted", VALID).len(), 1);
    let library = read("crates/zonal/Cargo.toml");
    let enabled = library.replace(
        "zonal-scene = { workspace = true",
        "zonal-scene = { workspace = true, features = [\"clap\"]",
    );
    assert!(enabled != library && wrong_dependencies("zonal", &enabled).len() == 1);
}

// Sources.

/// Code without its comments, on one line.
fn code(text: &str) -> String {
    let lines = text.lines().map(|l| l.split("//").next().unwrap_or(""));
    lines.flat_map(|l| [l.trim(), " "]).collect()
}

/// The text after each occurrence of `word` as a whole word.
fn after<'t>(code: &'t str, word: &str) -> Vec<&'t str> {
    let alone = |at: &usize| !code[..*at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
    code.match_indices(word).map(|(at, _)| at).filter(alone).map(|at| &code[at + word.len()..]).collect()
}

/// The outermost names of a list in braces, from the text after its opening brace.
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

fn system_use(file: &str, text: &str) -> Vec<String> {
    let code = code(text);
    let mut found: Vec<String> =
        FORBIDDEN_WORDS.iter().filter(|w| !after(&code, w).is_empty()).map(|w| w.to_string()).collect();
    let is_described = DESCRIBED_CRATES.iter().any(|c| file.starts_with(&format!("crates/{c}/")));
    found.extend((!is_described && !after(&code, "serde::").is_empty()).then(|| "serde".to_string()));
    for rest in after(&code, "std::") {
        let names = rest.strip_prefix('{').map_or_else(|| vec![rest.to_string()], listed);
        for name in names {
            let first = name.split(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or("");
            found.extend(SYSTEM_MODULES.contains(&first).then(|| format!("std::{first}")));
        }
    }
    found.iter().map(|w| format!("{file}: {w} is not allowed in core crates")).collect()
}

// Guards (structure): the core crates (math, fourier, scene, transport, exchange, gas, view-factors, paper, solve, render) use no file system, network,
//     clock, environment, format of a file or printing, and serde's attributes stand at types of scene and vectors alone; progress goes through the trait
//     `Progress`.
#[test]
fn core_crates_use_no_operating_system() {
    let files = CORE_CRATES.iter().flat_map(|c| sources(&format!("crates/{c}/src")));
    assert_none(files.flat_map(|(name, text)| system_use(&name, &text)).collect());
}

/// Names of the command and of its parser in a source file.
fn command_use(file: &str, text: &str) -> Vec<String> {
    let code = code(text);
    let named = ["zonal_cli", "clap::"].into_iter().filter(|word| !after(&code, word).is_empty());
    named.map(|word| format!("{file}: {word} belongs to the command")).collect()
}

// Guards (structure): the Python package knows the command in its entry point alone, and fuzz targets do not know it.
#[test]
fn only_entry_points_know_the_command() {
    /// The entry point of the command in the Python package.
    const ENTRY_POINT: &str = "python/src/command.rs";
    let files = ["python/src", "fuzz/src"].into_iter().flat_map(sources);
    assert_none(files.filter(|f| f.0 != ENTRY_POINT).flat_map(|f| command_use(&f.0, &f.1)).collect());
    assert_eq!(command_use("bad.rs", "use zonal_cli::table;\nuse clap::Parser;").len(), 2);
}

#[test]
fn operating_system_use_is_detected() {
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
        assert_eq!(system_use("bad.rs", bad).len(), count, "{bad}");
    }
    for good in [
        "// nothing of std::fs here",
        "/// No std::time, no serde.",
        "use std::{fmt, f64::consts::PI};",
        "let x = env!(\"CARGO_PKG_VERSION\");",
        "mod timefs; use std::io_time::x;",
        "use std::collections::{fs_like, time_like};",
    ] {
        assert!(system_use("good.rs", good).is_empty(), "{good}");
    }
}

// Module graphs.

/// Cycles of the module graph of a crate.
fn module_cycles(files: &[SourceFile], package: &str) -> Vec<String> {
    let cycles = xtask::modules::cycles(files, package);
    cycles.iter().map(|c| format!("{package}: modules in a cycle\n    {}", c.join("\n    "))).collect()
}

// Guards (structure): the modules of a crate form no cycle.
#[test]
fn module_graphs_have_no_cycles() {
    let files = xtask::source::load(&root());
    assert_none(DEPENDENCIES.iter().flat_map(|(name, _)| module_cycles(&files, name)).collect());
}

#[test]
fn module_cycles_are_detected() {
    let file = |name: &str, text: &str| {
        SourceFile::from_text(format!("crates/sample/src/{name}.rs"), text.to_string())
    };
    let library = || file("lib", "mod a;\nmod b;\nmod c;\npub use a::f;");
    let c = || file("c", "pub(crate) fn h() {}\n#[cfg(test)]\nmod tests { use crate::a::f; }");
    let a = || file("a", "use crate::b::g;\npub fn f() { g(); crate::c::h() }");
    let acyclic = [library(), a(), file("b", "use crate::c::h;\npub(crate) fn g() { h() }"), c()];
    assert_none(module_cycles(&acyclic, "sample"));
    let cyclic = [library(), a(), file("b", "pub(crate) fn g() { if false { crate::a::f() } }"), c()];
    let found = module_cycles(&cyclic, "sample");
    assert!(found.len() == 1 && found[0].contains("a.rs") && found[0].contains("b.rs"), "{found:?}");
    assert!(!found[0].contains("c.rs"), "{found:?}");
}

/// Ignored tests, unfinished code, long files.
fn unfinished(file: &str, text: &str) -> Vec<String> {
    let code = code(text);
    let mut out = Vec::new();
    for word in [concat!("#[", "ignore"), concat!("todo", "!"), concat!("unimplemented", "!")] {
        if !after(&code, word).is_empty() {
            out.push(format!("{file}: {word}"));
        }
    }
    let lines = text.lines().count();
    if lines > MAX_FILE_LINES {
        out.push(format!("{file}: {lines} lines, more than {MAX_FILE_LINES}; divide it"));
    }
    out
}

// Guards (structure): no test is ignored, no unfinished code remains, and no file is long.
#[test]
fn no_ignored_tests_unfinished_code_or_long_files() {
    assert_none(sources("crates").iter().flat_map(|(name, text)| unfinished(name, text)).collect());
}

#[test]
fn viewer_sources_are_short() {
    for folder in ["viewer/src", "viewer/test/unit", "viewer/test/browser"] {
        for entry in std::fs::read_dir(root().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let lines = std::fs::read_to_string(&path).unwrap().lines().count();
            assert!(
                lines <= MAX_FILE_LINES,
                "{}: {lines} lines, more than {MAX_FILE_LINES}; divide it",
                path.display()
            );
        }
    }
}

#[test]
fn unfinished_code_is_detected() {
    assert_eq!(unfinished("a.rs", concat!("#[", "ignore = \"slow\"]\n#[test]\nfn f() {}")).len(), 1);
    assert_eq!(unfinished("a.rs", concat!("fn f() { todo", "!() }")).len(), 1);
    assert_eq!(unfinished("a.rs", concat!("fn f() { unimplemented", "!(\"later\") }")).len(), 1);
    assert_eq!(unfinished("a.rs", &"x\n".repeat(MAX_FILE_LINES + 1)).len(), 1);
    assert!(unfinished("a.rs", &"x\n".repeat(MAX_FILE_LINES)).is_empty());
}
