//! The independent path tracer: solutions, tables and pictures against paths of light.
//!
//! ```text
//! path_tracer [SCENE.toml] --solution RUN.npz [--patches 200] [--voxels 200] [--panes 0] [--error 0.01] [--seed 1]
//!       [--pick uniform|area] [--max-paths N] [--json] [--table FILE.csv]
//! path_tracer SCENE.toml --picture CAMERA [--size WxH] [--samples N] [--max-bounces K] [--seed 1] -o OUT.exr
//! path_tracer [--cases c0,c8,image_c0,cbox_smoke,…] [--quick] [--shared ../shared] [--seed 1]
//! ```
//!
//! The first form picks zones of a solution at random, measures H and G on them without any zones, and reports the difference from the solution
//! is: L2 = RMS of the difference / RMS of the reference; pointwise = RMS of the relative difference over zones above a tenth of the
//! mean; and how many zones lie within twice their own estimate. The second draws a camera's picture with its standard error
//! (`OUT.exr`, `OUT_stderr.exr`). The third compares the path tracer itself with Monte Carlo tables and Mitsuba's pictures and ends with 1
//! where it does not stand.

mod cases;
mod draw;
mod scenes;
mod solution;
#[path = "../common/zone_sampling.rs"]
mod zone_sampling;

use std::process::ExitCode;

/// The command line: `--name value` pairs, flags and positional arguments.
pub struct CommandArguments(Vec<String>);

/// Options that stand alone.
const FLAGS: [&str; 2] = ["--json", "--quick"];

impl CommandArguments {
    /// The text after `--name`.
    pub fn text(&self, name: &str) -> Option<&str> {
        let at = self.0.iter().position(|a| a == name)?;
        self.0.get(at + 1).map(String::as_str)
    }
    /// The number after `--name`, or a default.
    pub fn number<T: std::str::FromStr>(&self, name: &str, default: T) -> Result<T, String> {
        let Some(text) = self.text(name) else { return Ok(default) };
        text.parse().map_err(|_| format!("{name} {text}: give a number"))
    }
    /// True where the flag is given.
    pub fn flag(&self, name: &str) -> bool {
        self.0.iter().any(|a| a == name)
    }
    /// The first word that belongs to no option.
    pub fn plain(&self) -> Option<&str> {
        let mut k = 0;
        while let Some(word) = self.0.get(k) {
            if !word.starts_with('-') {
                return Some(word);
            }
            k += if FLAGS.contains(&word.as_str()) { 1 } else { 2 };
        }
        None
    }
}

/// Any error, in a sentence.
pub type CommandOutcome = Result<bool, Box<dyn std::error::Error>>;

fn main() -> ExitCode {
    let arguments = CommandArguments(std::env::args().skip(1).collect());
    let outcome = if arguments.text("--solution").is_some() {
        solution::run(&arguments)
    } else if arguments.text("--picture").is_some() {
        draw::draw(&arguments)
    } else {
        cases::run(&arguments)
    };
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(e) => {
            eprintln!("path_tracer: {e}");
            ExitCode::from(2)
        }
    }
}
