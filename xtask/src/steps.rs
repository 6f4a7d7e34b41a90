//! The steps of CI, which developers run too.
//!
//! Every step runs even when an earlier one fails; the result is a failure if any step fails. Each crate is compiled once for clippy and rustdoc
//! and once for tests, with the features that the Python package needs; the demo and all later steps run the binary of the test build, which
//! differs from a release by optimization and assertions alone. Steps that compile most run one after the other; the later ones are two lists that run
//! beside each other. Steps that need tools beyond Rust are scripts below `.ci/`: they install what they need where they may, and skip with a message
//! where a tool is missing, except on CI (`CI` set), where a missing tool is a failure.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

/// One step: its name, what it checks, and its command; `{demo}` stands for the output folder and `{zonal}` for the binary.
struct Step {
    name: &'static str,
    checks: &'static str,
    command: &'static [&'static str],
}

/// The steps that run one after the other, since each uses all cores.
const COMPILATION: [Step; 4] = [
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
        command: &[".ci/cargo.sh", "test", "--no-fail-fast", "--lib", "--bins", "--tests", "--examples"],
    },
];

/// The steps that need the compiled command: the two lists run beside each other. The first compiles a little more, and the second waits for browsers and networks.
const LISTS: [&[Step]; 2] = [
    &[
        Step {
            name: "doctests",
            checks: "examples in the documentation",
            command: &[".ci/cargo.sh", "test", "--doc"],
        },
        Step { name: "counts", checks: "structure of the code", command: &["cargo", "xtask", "counts"] },
        Step { name: "commits", checks: "messages of commits", command: &["cargo", "xtask", "commits"] },
        Step {
            name: "packages",
            checks: "packages of a release: versions, files, workflow",
            command: &[".ci/packages.sh"],
        },
        Step { name: "examples", checks: "the library's examples", command: &[".ci/examples.sh", "{zonal}"] },
        Step {
            name: "python",
            checks: "the Python package: wheel, tests, types",
            command: &[".ci/python_package.sh", "{zonal}"],
        },
        Step {
            name: "mpi",
            checks: "distributed solves by MPI: lint, tests, the bytes of one process",
            command: &[".ci/mpi.sh", "{zonal}"],
        },
    ],
    &[
        Step {
            name: "demo",
            checks: "the demo at small size",
            command: &["{zonal}", "demo", "--size", "small", "-o", "{demo}/demo"],
        },
        Step {
            name: "numpy",
            checks: "the demo's files in numpy",
            command: &[".ci/python.sh", "numpy", ".ci/check_demo.py", "{demo}/demo"],
        },
        Step {
            name: "viewer",
            checks: "the viewer in a browser",
            command: &[".ci/viewer.sh", "{zonal}", "{demo}"],
        },
        Step {
            name: "exports",
            checks: "exports in VTK and the glTF validator",
            command: &[".ci/exports.sh", "{zonal}", "{demo}"],
        },
        Step {
            name: "validate",
            checks: "quick cases with known answers",
            command: &["{zonal}", "validate", "--quick", "--reference", "../shared"],
        },
        Step {
            name: "manual",
            checks: "the manual's site and its internal links",
            command: &[".ci/manual.sh", "{zonal}", "{demo}"],
        },
    ],
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

/// All steps.
fn all_steps() -> impl Iterator<Item = &'static Step> {
    COMPILATION.iter().chain(LISTS.into_iter().flatten()).chain([&QUICK_TESTS])
}

/// Prints the steps.
pub fn list() {
    println!("quick     for every change: {}", QUICK.join(", "));
    for step in all_steps() {
        println!("{:<9} {}\n          {}", step.name, step.checks, step.command.join(" "));
    }
}

/// Runs the named steps, those of `quick`, or all; returns whether all passed.
#[must_use]
pub fn run(root: &Path, names: &[&str]) -> bool {
    let names = if names == ["quick"] { &QUICK } else { names };
    if let Some(unknown) = names.iter().find(|n| all_steps().all(|s| s.name != **n)) {
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
    let mut install = Command::new("nice");
    install.args(["-n", "19", ".ci/prepare.sh"]).env("ZONAL_CI_FOLDER", &output).current_dir(root);
    let mut preparation = names.is_empty().then(|| install.spawn().ok()).flatten();
    let is_selected = |s: &&Step| match names {
        [] => s.name != QUICK_TESTS.name,
        names => names.contains(&s.name),
    };
    let failures = |list: &'static [Step], are_alone: bool| -> Vec<&str> {
        let selected = list.iter().filter(is_selected);
        selected.filter(|s| !run_step(root, s, &zonal, &output, are_alone)).map(|s| s.name).collect()
    };
    let mut failed = failures(&COMPILATION, true);
    failed.extend(failures(&[QUICK_TESTS], true));
    std::thread::scope(|scope| {
        let lists = LISTS.map(|list| scope.spawn(|| failures(list, false)));
        lists.into_iter().for_each(|list| failed.extend(list.join().expect("a list of steps ends")));
    });
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

/// Runs a step; returns whether it passed. A step that is not alone has its words printed at its end.
fn run_step(root: &Path, step: &Step, zonal: &Path, output: &Path, is_alone: bool) -> bool {
    let fill = |s: &&str| {
        s.replace("{zonal}", &zonal.display().to_string()).replace("{demo}", &output.display().to_string())
    };
    let words: Vec<String> = step.command.iter().map(fill).collect();
    println!("\n=== {}: {}\n    {}", step.name, step.checks, words.join(" "));
    let begin = Instant::now();
    let log = output.join(format!("{}.log", step.name));
    let mut command = Command::new(&words[0]);
    // Scripts share the virtual environments in the folder.
    command
        .args(&words[1..])
        .env("ZONAL_CI_FOLDER", output)
        .env("CARGO_TERM_COLOR", "never")
        .current_dir(root);
    let status = if is_alone {
        command.status()
    } else {
        File::create(&log).and_then(|file| command.stdout(file.try_clone()?).stderr(file).status())
    };
    let seconds = begin.elapsed().as_secs();
    let (passed, end) = match status {
        Ok(status) if status.success() => (true, format!("passed in {seconds} s")),
        Ok(status) => (false, format!("FAILED after {seconds} s ({status})")),
        Err(e) => (false, format!("FAILED, {} could not be started: {e}", words[0])),
    };
    let said = std::fs::read(&log).unwrap_or_default();
    println!("{}=== {}: {end}", String::from_utf8_lossy(&said), step.name);
    passed
}

/// Makes the packages of a release and tries them (`scripts/packages.py`); returns whether all parts passed.
#[must_use]
pub fn package(root: &Path, parts: &[&str]) -> bool {
    let status = Command::new("python3").arg("scripts/packages.py").args(parts).current_dir(root).status();
    status.inspect_err(|e| eprintln!("error: python3 could not be started: {e}")).is_ok_and(|s| s.success())
}
