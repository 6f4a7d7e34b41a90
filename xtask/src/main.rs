//! The command `cargo xtask`.

use std::process::ExitCode;

const USAGE: &str = "\
cargo xtask ci [STEP…]      runs the steps of CI (all, or those named), every one even when an earlier one fails
cargo xtask ci quick        the steps for every change: format, lint, counts, commits, tests of the crates below the solver
cargo xtask steps           lists the steps
cargo xtask counts [--list] counts of the structure of the code against their limits; --list names every place
cargo xtask commits         checks the messages of commits
cargo xtask guards          writes docs/guards.md, the register of invariants
cargo xtask scope           copies the scope in README.md to docs/index.md
cargo xtask version [X.Y.Z] compares the versions in all files with Cargo.toml, or writes a new one into them
cargo xtask version --tag T what the tag T lacks for a release
cargo xtask package [PART]  makes the packages of a release and tries them: crates, sdist, wheel, or all three; `list` compiles nothing";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let root = xtask::source::workspace_root();
    let passed = match words.as_slice() {
        ["ci", names @ ..] => xtask::steps::run(&root, names),
        ["steps"] => {
            xtask::steps::list();
            true
        }
        ["counts"] => xtask::counts::report(&root, false),
        ["commits"] => xtask::commits::report(&root),
        ["guards"] => xtask::guards::write(&root),
        ["scope"] => xtask::documents::write_scope(&root),
        ["version"] => xtask::versions::report(&root, None),
        ["version", "--tag", tag] => xtask::versions::report(&root, Some(tag)),
        ["version", version] => xtask::versions::write(&root, version),
        ["package", parts @ ..] => xtask::steps::package(&root, parts),
        ["counts", "--list"] => xtask::counts::report(&root, true),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
