//! `zonal validate`: the cases with known answers, computed afresh; a verdict for each quantity, and a page with the evidence.
//!
//! | module | what |
//! |---|---|
//! | `case` | what a case is; rows, limits, verdicts |
//! | `bench` | scenes as texts that a user could run, solved and measured |
//! | `data` | the committed references, as printed, with where they come from |
//! | `richardson` | extrapolation with its uncertainty |
//! | `factors`, `sphere`, `slabs`, `square`, `cube`, `burns`, `furnace`, `series`, `gases`, `thick`, `laws` | the cases, closed forms first |
//! | `montecarlo` | seven cubes by Monte Carlo, two pictures; the example of that name shares them |
//! | `openfoam`, `elmer`, `conduction` | other solvers |
//! | `listing`, `page` | what is printed, and `validation.md` with its plots |
//!
//! A limit is stated with its case and never fitted to what comes out. A case whose files are missing is skipped, which is not passing.

mod bench;
mod burns;
mod case;
mod conduction;
mod cube;
mod data;
mod elmer;
mod factors;
mod furnace;
mod gases;
mod laws;
mod listing;
pub mod montecarlo;
mod openfoam;
mod page;
mod richardson;
mod series;
mod slabs;
mod sphere;
mod square;
mod thick;
mod zoning;

use super::Context;
use super::reproduce::Folder;
use crate::failure::say;
use crate::{Failure, meter::Meter};
use bench::Bench;
use case::{Case, Done, Outcome, Verdict};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Check the program against known answers.
///
/// Exit codes: 0 every verdict holds, 1 a verdict does not hold or every chosen case was skipped, 2 bad options, a reference folder that is not
/// there, or a folder that cannot be written.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Cases to run, by name or pattern with * and ?, separated by commas (default: all).
    #[arg(long, value_name = "CASES", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Run the quick cases alone: a few seconds each at most.
    #[arg(long)]
    pub quick: bool,
    /// List the cases and run none.
    #[arg(long)]
    pub list: bool,
    /// Folder for the page validation.md and its plots; made if it is not there (default: docs when all cases run, else no page).
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Folder of reference files that are not part of the program; cases that need one of them are skipped without (default: ../shared).
    #[arg(long, value_name = "DIR")]
    pub reference: Option<PathBuf>,
    /// Write every scene that is solved into this folder, for `zonal solve`.
    #[arg(long, value_name = "DIR")]
    pub scenes: Option<PathBuf>,
}

/// All cases, in the order of the page.
fn cases() -> impl Iterator<Item = &'static Case> {
    let parts: [&'static [Case]; 14] = [
        &factors::CASES,
        &slabs::CASES,
        &square::CASES,
        &cube::CASES,
        &burns::CASES,
        &furnace::CASES,
        &series::CASES,
        &gases::CASES,
        &openfoam::CASES,
        &elmer::CASES,
        &montecarlo::CASES,
        &thick::CASES,
        &zoning::CASES,
        &laws::CASES,
    ];
    parts.into_iter().flatten()
}

/// True where a name fits a pattern in which * stands for anything and ? for one letter.
fn fits(pattern: &[u8], name: &[u8]) -> bool {
    match (pattern.split_first(), name.split_first()) {
        (None, None) => true,
        (Some((b'*', rest)), _) => (0..=name.len()).any(|k| fits(rest, &name[k..])),
        (Some((b'?', rest)), Some((_, tail))) => fits(rest, tail),
        (Some((p, rest)), Some((n, tail))) => p == n && fits(rest, tail),
        _ => false,
    }
}

/// The longest pattern, and the most stars in it.
const PATTERN: (usize, usize) = (80, 4);

/// The patterns of `--only`, without the space around them; what is empty, as after a last comma, is none.
fn patterns(args: &Args) -> Result<Vec<&str>, Failure> {
    let list: Vec<&str> = args.only.iter().map(|p| p.trim()).filter(|p| !p.is_empty()).collect();
    if list.is_empty() && !args.only.is_empty() {
        return Err(Failure::new("--only: no case is named; `zonal validate --list` names them"));
    }
    Ok(list)
}

fn chosen(args: &Args) -> Result<Vec<&'static Case>, Failure> {
    let only = patterns(args)?;
    for pattern in &only {
        if pattern.len() > PATTERN.0 || pattern.matches('*').count() > PATTERN.1 {
            let what = "is too long for a pattern, or has too many stars";
            return Err(Failure::new(format!(
                "--only: '{pattern}' {what}; `zonal validate --list` names the cases"
            )));
        }
        if !cases().any(|c| fits(pattern.as_bytes(), c.name.as_bytes())) {
            return Err(Failure::new(format!(
                "--only: no case is called '{pattern}'; `zonal validate --list` names them"
            )));
        }
    }
    let wanted = |c: &&Case| only.is_empty() || only.iter().any(|p| fits(p.as_bytes(), c.name.as_bytes()));
    let all: Vec<&Case> = cases().filter(wanted).filter(|c| c.quick || !args.quick).collect();
    if all.is_empty() {
        return Err(Failure::new(
            "--quick: none of the cases of --only is a quick one; leave one of the two out",
        ));
    }
    Ok(all)
}

/// The folder of reference files: one that was asked for has to be there.
fn reference(args: &Args) -> Result<&Path, Failure> {
    match &args.reference {
        Some(folder) if !folder.is_dir() => Err(Failure::new(format!(
            "--reference: {} is no folder; give that of the reference files, or leave the option out",
            folder.display()
        ))),
        Some(folder) => Ok(folder),
        None => Ok(Path::new("../shared")),
    }
}

/// Runs the command.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let cases = chosen(args)?;
    let reference = reference(args)?;
    if args.list {
        return say(&listing::list(&cases, context.json));
    }
    let whole = args.only.is_empty() && !args.quick;
    let output = args.output.clone().or(whole.then(|| PathBuf::from("docs")));
    let plots = match &output {
        Some(folder) => {
            Folder::make(folder)?;
            Some(Folder::make(&folder.join("validation"))?)
        }
        None => None,
    };
    let meter = Meter::new(context.quiet || context.json);
    let pictures = plots.as_ref().map(|f| f.path(""));
    let bench = Bench::new(reference, pictures.as_deref(), args.scenes.as_deref(), &meter)?;
    let mut done = Vec::new();
    for case in cases {
        let one = timed(case, &bench)?;
        if !context.json {
            say(&listing::table(&one))?;
        }
        done.push(one);
    }
    let page = match (&output, &plots) {
        (Some(folder), Some(plots)) => Some(page::write(folder, plots, &done)?),
        _ => None,
    };
    say(&if context.json {
        listing::json(&done, page.as_deref())
    } else {
        listing::end(&done, page.as_deref())
    })?;
    verdict(&done)
}

fn timed(case: &'static Case, bench: &Bench) -> Result<Done, Failure> {
    let start = Instant::now();
    let missing = case.needs.filter(|file| !bench.reference.join(file).exists());
    let outcome = match missing {
        Some(file) => Outcome::skipped(format!(
            "there is no {}; give its folder with --reference",
            bench.reference.join(file).display()
        )),
        None => (case.run)(bench).map_err(|e| Failure::new(format!("case {}: {e}", case.name)))?,
    };
    Ok(Done { case, outcome, seconds: start.elapsed().as_secs_f64() })
}

/// A failure with an exit code of its own where a verdict does not hold, or nothing was checked.
fn verdict(done: &[Done]) -> Result<(), Failure> {
    let failed: Vec<String> = (done.iter())
        .map(|d| (d.case.name, d.outcome.count(Verdict::Fails)))
        .filter(|f| f.1 > 0)
        .map(|(name, count)| format!("{name} ({count})"))
        .collect();
    if failed.is_empty() {
        return match done.iter().all(|d| d.outcome.skipped.is_some()) {
            true => Err(Failure::verdict(
                "nothing was checked: every chosen case was skipped; give the folder of their files with --reference",
            )),
            false => Ok(()),
        };
    }
    Err(Failure::verdict(format!("verdicts that do not hold, by case: {}", failed.join(", "))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use case::Limit;
    use std::collections::BTreeSet;

    #[test]
    fn patterns() {
        let fits = |p: &str, n: &str| fits(p.as_bytes(), n.as_bytes());
        assert!(fits("cube", "cube") && fits("c*", "cube") && fits("*", "cube") && fits("c?b*e", "cube"));
        assert!(!fits("cub", "cube") && !fits("cube?", "cube") && !fits("", "cube") && !fits("d*", "cube"));
        assert!(fits("*-c?*", "mc-c10") && !fits("*-c??", "mc-c0"));
    }

    #[test]
    fn every_case_has_a_name_of_its_own() {
        let names: BTreeSet<&str> = cases().map(|c| c.name).collect();
        assert_eq!(names.len(), cases().count());
        assert!(cases().all(|c| !c.about.is_empty() && !c.title.is_empty()));
    }

    #[test]
    fn a_verdict_that_does_not_hold_is_a_failure_with_its_own_code() {
        let of = |reference: f64| {
            let mut outcome = Outcome::default();
            outcome.check("two", reference, 2.0, Limit::Relative(1e-9));
            let case = cases().next().unwrap();
            verdict(&[Done { case, outcome, seconds: 0.0 }])
        };
        assert!(of(2.0).is_ok());
        let e = of(2.1).unwrap_err();
        assert_eq!(e.code(), 1);
        assert!(e.to_string().contains("view-factors (1)"), "{e}");
    }
}
