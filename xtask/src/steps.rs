//! The steps of CI, which developers run too.
//!
//! Every step runs even when an earlier one fails; the result is a failure if any step fails. Each crate is compiled once for clippy and rustdoc
//! and once for tests, with the features that the Python package needs; the demo and all later steps run the binary of the test build, which
//! differs from a release by optimization and assertions alone. Steps that need tools beyond Rust are scripts below `.ci/`: they install what
//! they need where they may, and skip with a message where a tool is missing, except on CI (`CI` set), where a missing tool is a failure.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

/// One step: its name, what it checks, and its command; `{demo}` stands for the output folder and `{zonal}` for the binary.
struct Step {
    name: &'static str,
    checks: &'static str,
    command: &'static [&'static str],
}

const STEPS: [Step; 16] = [
    Step { name: "format", checks: "rustfmt", command: &["cargo", "fmt", "--all", "--", "--check", "-l"] },
    Step {
        name: "lint",
        checks: "clippy, warnings as errors",
        command: &[
            "cargo",
            "clippy",
            "--quiet",
            "--keep-going",
            "--workspace",
            "--exclude",
            "zonal-mpi",
            "--all-targets",
            "--locked",
            "--",
            "-D",
            "warnings",
        ],
    },
    Step {
        name: "docs",
        checks: "rustdoc, warnings as errors",
        command: &[
            "env",
            "RUSTDOCFLAGS=-D warnings",
            "cargo",
            "doc",
            "--quiet",
            "--keep-going",
            "--workspace",
            "--exclude",
            "zonal-mpi",
            "--no-deps",
            "--locked",
        ],
    },
    Step {
        name: "tests",
        checks: "all tests",
        command: &[".ci/cargo.sh", "test", "--no-fail-fast", "--lib", "--bins", "--tests"],
    },
    Step {
        name: "doctests",
        checks: "examples in the documentation",
        command: &[".ci/cargo.sh", "test", "--doc"],
    },
    Step { name: "counts", checks: "structure of the code", command: &["cargo", "xtask", "counts"] },
    Step { name: "commits", checks: "messages of commits", command: &["cargo", "xtask", "commits"] },
    Step { name: "examples", checks: "the library's examples", command: &[".ci/examples.sh", "{zonal}"] },
    Step {
        name: "demo",
        checks: "the demo at small size",
        command: &["{zonal}", "demo", "--size", "small", "-o", "{demo}/demo"],
    },
    Step {
        name: "python",
        checks: "the Python package: wheel, tests, types",
        command: &[".ci/python_package.sh", "{zonal}"],
    },
    Step {
        name: "numpy",
        checks: "the demo's files in numpy",
        command: &[".ci/python.sh", "numpy", ".ci/check_demo.py", "{demo}/demo"],
    },
    Step {
        name: "mpi",
        checks: "distributed solves by MPI: lint, tests, the bytes of one process",
        command: &[".ci/mpi.sh", "{zonal}"],
    },
    Step {
        name: "validate",
        checks: "quick cases with known answers",
        command: &["{zonal}", "validate", "--quick", "--reference", "../shared"],
    },
    Step {
        name: "exports",
        checks: "exports in VTK and the glTF validator",
        command: &[".ci/exports.sh", "{zonal}", "{demo}"],
    },
    Step {
        name: "viewer",
        checks: "the viewer in a browser",
        command: &[".ci/viewer.sh", "{zonal}", "{demo}"],
    },
    Step {
        name: "manual",
        checks: "the manual's site and its internal links",
        command: &[".ci/manual.sh", "{zonal}", "{demo}"],
    },
];

/// The tests of `quick`: those of the crates below the solver.
const QUICK_TESTS: Step = Step {
    name: "quick-tests",
    checks: "tests of the crates below the solver",
    command: &[
        "cargo",
        "test",
        "--quiet",
        "--locked",
        "--lib",
        "--tests",
        "-p",
        "zonal-math",
        "-p",
        "zonal-scene",
        "-p",
        "zonal-io",
        "-p",
        "zonal-gas",
        "-p",
        "zonal-transport",
        "-p",
        "zonal-exchange",
    ],
};
/// The steps of `cargo xtask ci quick`, for every change.
const QUICK: [&str; 5] = ["format", "lint", "counts", "commits", QUICK_TESTS.name];

/// Variables of every step: colours off, no debug information, no incremental compilation. Scripts share the virtual environment in the folder
/// `ZONAL_CI_FOLDER`.
const ENVIRONMENT: [(&str, &str); 5] = [
    ("CARGO_INCREMENTAL", "0"),
    ("CARGO_PROFILE_DEV_DEBUG", "0"),
    ("CARGO_PROFILE_TEST_DEBUG", "0"),
    ("CARGO_PROFILE_RELEASE_DEBUG", "0"),
    ("CARGO_TERM_COLOR", "never"),
];

/// Prints the steps.
pub fn list() {
    println!("quick     for every change: {}", QUICK.join(", "));
    for step in STEPS.iter().chain([&QUICK_TESTS]) {
        println!("{:<9} {}\n          {}", step.name, step.checks, step.command.join(" "));
    }
}

/// Runs the named steps, those of `quick`, or all; returns whether all passed.
#[must_use]
pub fn run(root: &Path, names: &[&str]) -> bool {
    let names = if names == ["quick"] { &QUICK } else { names };
    let known = || STEPS.iter().chain([&QUICK_TESTS]);
    if let Some(unknown) = names.iter().find(|n| known().all(|s| s.name != **n)) {
        eprintln!("error: there is no step `{unknown}`; `cargo xtask steps` lists them");
        return false;
    }
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    let zonal = target.join("debug/zonal");
    let output = std::env::temp_dir().join(format!("zonal-ci-{}", std::process::id()));
    if let Err(e) = std::fs::create_dir_all(&output) {
        eprintln!("error: {}: {e}", output.display());
        return false;
    }
    let begin = Instant::now();
    // A full run installs packages while it compiles; the step that needs them waits, and installs what is missing.
    let mut preparation = match names.is_empty() {
        true => Command::new("nice")
            .args(["-n", "19", ".ci/prepare.sh"])
            .env("ZONAL_CI_FOLDER", &output)
            .current_dir(root)
            .spawn()
            .ok(),
        false => None,
    };
    let selected = known().filter(|s| match names {
        [] => s.name != QUICK_TESTS.name,
        names => names.contains(&s.name),
    });
    let failed: Vec<&str> =
        selected.filter(|s| !run_step(root, s, &zonal, &output)).map(|s| s.name).collect();
    // No step waits for the preparation any more.
    if let Some(p) = &mut preparation {
        let _ = p.kill();
        let _ = p.wait();
    }
    // The folder is temporary; what cannot be removed does no harm.
    let _ = std::fs::remove_dir_all(&output);
    let seconds = begin.elapsed().as_secs();
    if failed.is_empty() {
        println!("\nall passed in {seconds} s");
    } else {
        println!("\nFAILED after {seconds} s: {}", failed.join(", "));
    }
    failed.is_empty()
}

fn run_step(root: &Path, step: &Step, zonal: &Path, output: &Path) -> bool {
    let fill = |s: &&str| {
        s.replace("{zonal}", &zonal.display().to_string()).replace("{demo}", &output.display().to_string())
    };
    let words: Vec<String> = step.command.iter().map(fill).collect();
    println!("\n=== {}: {}\n    {}", step.name, step.checks, words.join(" "));
    let begin = Instant::now();
    let status = Command::new(&words[0])
        .args(&words[1..])
        .envs(ENVIRONMENT)
        .env("ZONAL_CI_FOLDER", output)
        .current_dir(root)
        .status();
    let seconds = begin.elapsed().as_secs();
    match status {
        Ok(status) if status.success() => {
            println!("=== {}: passed in {seconds} s", step.name);
            true
        }
        Ok(status) => {
            println!("=== {}: FAILED after {seconds} s ({status})", step.name);
            false
        }
        Err(e) => {
            println!("=== {}: FAILED, {} could not be started: {e}", step.name, words[0]);
            false
        }
    }
}
