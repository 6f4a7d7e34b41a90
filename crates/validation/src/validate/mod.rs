//! `zonal validate`: the cases with known answers, computed afresh; a verdict for each quantity, and a page with the evidence.
//!
//! | module | what |
//! |---|---|
//! | `case` | cases, quantities, limits, verdicts |
//! | `case_context`, `box_scene`, `measures` | scenes as texts that a user could run; their solution; quantities of a solution |
//! | `data` | the committed references, as printed, with their provenance |
//! | `richardson` | extrapolation with its uncertainty |
//! | `factors`, `sphere`, `slabs`, `square`, `cube`, `burns`, `furnace`, `series`, `gases`, `gas_slabs`, `thick`, `discretization`, `textbook`, `macbeth`, `lighting`, `daylight`, `laws` | the cases, closed forms first |
//! | `montecarlo` | seven cubes by Monte Carlo, two pictures; the campaign of that name shares the cubes |
//! | `openfoam`, `elmer`, `conduction` | other solvers |
//! | `tables`, `page` | printed tables; `validation.md` with its plots |
//!
//! Each case states its limits in advance. A case whose files are missing is skipped and does not pass.

mod box_scene;
mod case;
mod case_context;
pub mod comparisons;
mod data;
mod exact;
mod gas;
mod light;
mod measures;
mod page;
mod richardson;
mod tables;

use case::{CaseOutcome, CaseResult, ValidationCase, Verdict};
use case_context::CaseContext;
use std::path::{Path, PathBuf};
use std::time::Instant;
use tables::ListFormat;
use zonal_report::{Failure, PageFolder, say};
use zonal_scene::Progress;

/// The cases to run, and where their results go.
#[derive(Clone, Debug, Default)]
pub struct ValidationOptions {
    /// Cases to run, by name or pattern with * and ? (empty: all).
    pub only: Vec<String>,
    /// Run the quick cases alone: a few seconds each at most.
    pub quick: bool,
    /// List the cases and run none.
    pub list: bool,
    /// Folder for the page validation.md and its plots; made if it is not there (`None`: docs when all cases run, else no page).
    pub output: Option<PathBuf>,
    /// Folder of reference files that are not part of the program; cases that need one of them are skipped without (`None`: ../shared).
    pub reference: Option<PathBuf>,
    /// Write every scene that is solved into this folder.
    pub scenes: Option<PathBuf>,
    /// Print JSON instead of tables.
    pub json: bool,
}

/// All cases, in the order of the page.
fn cases() -> impl Iterator<Item = &'static ValidationCase> {
    let parts: [&'static [ValidationCase]; 19] = [
        &exact::factors::CASES,
        &exact::slabs::CASES,
        &exact::square::CASES,
        &exact::cube::CASES,
        &comparisons::burns::CASES,
        &gas::furnace::CASES,
        &exact::series::CASES,
        &gas::gases::CASES,
        &gas::gas_slabs::CASES,
        &comparisons::openfoam::CASES,
        &comparisons::elmer::CASES,
        &comparisons::montecarlo::CASES,
        &comparisons::thick::CASES,
        &comparisons::discretization::CASES,
        &exact::textbook::CASES,
        &comparisons::macbeth::CASES,
        &light::lighting::CASES,
        &light::daylight::CASES,
        &exact::laws::CASES,
    ];
    parts.into_iter().flatten()
}

/// True where a name fits a pattern in which * stands for anything and ? for one letter.
fn matches_pattern(pattern: &[u8], name: &[u8]) -> bool {
    match (pattern.split_first(), name.split_first()) {
        (None, None) => true,
        (Some((b'*', rest)), _) => (0..=name.len()).any(|k| matches_pattern(rest, &name[k..])),
        (Some((b'?', rest)), Some((_, tail))) => matches_pattern(rest, tail),
        (Some((p, rest)), Some((n, tail))) => p == n && matches_pattern(rest, tail),
        _ => false,
    }
}

/// Largest length of a pattern, bytes.
const MAX_PATTERN_LENGTH: usize = 80;
/// Largest number of stars in a pattern: matching takes time exponential in it.
const MAX_PATTERN_STARS: usize = 4;

/// The patterns of `--only`, trimmed; empty ones are ignored.
fn patterns(options: &ValidationOptions) -> Result<Vec<&str>, Failure> {
    let list: Vec<&str> = options.only.iter().map(|p| p.trim()).filter(|p| !p.is_empty()).collect();
    if list.is_empty() && !options.only.is_empty() {
        return Err(Failure::new("--only: no case is named; `zonal validate --list` names them"));
    }
    Ok(list)
}

fn chosen_cases(options: &ValidationOptions) -> Result<Vec<&'static ValidationCase>, Failure> {
    let only = patterns(options)?;
    for pattern in &only {
        if pattern.len() > MAX_PATTERN_LENGTH || pattern.matches('*').count() > MAX_PATTERN_STARS {
            let what = "is too long for a pattern, or has too many stars";
            return Err(Failure::new(format!(
                "--only: '{pattern}' {what}; `zonal validate --list` names the cases"
            )));
        }
        if !cases().any(|c| matches_pattern(pattern.as_bytes(), c.name.as_bytes())) {
            return Err(Failure::new(format!(
                "--only: no case is called '{pattern}'; `zonal validate --list` names them"
            )));
        }
    }
    let wanted = |c: &&ValidationCase| {
        only.is_empty() || only.iter().any(|p| matches_pattern(p.as_bytes(), c.name.as_bytes()))
    };
    let all: Vec<&ValidationCase> = cases().filter(wanted).filter(|c| c.quick || !options.quick).collect();
    if all.is_empty() {
        return Err(Failure::new(
            "--quick: none of the cases of --only is a quick one; leave one of the two out",
        ));
    }
    Ok(all)
}

/// The folder of reference files: one that was asked for has to be there.
fn reference(options: &ValidationOptions) -> Result<&Path, Failure> {
    match &options.reference {
        Some(folder) if !folder.is_dir() => Err(Failure::new(format!(
            "--reference: {} is no folder; give that of the reference files, or leave the option out",
            folder.display()
        ))),
        Some(folder) => Ok(folder),
        None => Ok(Path::new("../shared")),
    }
}

/// Runs the chosen cases and prints their tables to standard output.
///
/// # Errors
/// Bad options, a folder that cannot be read or written, a case that cannot be solved; a verdict that does not hold.
pub fn run(options: &ValidationOptions, progress: &dyn Progress) -> Result<(), Failure> {
    let cases = chosen_cases(options)?;
    let reference = reference(options)?;
    if options.list {
        return say(&tables::list(&cases, if options.json { ListFormat::Json } else { ListFormat::Text }));
    }
    let (done, page) = run_cases(options, cases, reference, progress)?;
    say(&if options.json {
        tables::json(&done, page.as_deref())
    } else {
        tables::end(&done, page.as_deref())
    })?;
    verdict(&done)
}

/// Runs the chosen cases without printing; returns their verdicts as JSON, and whether every verdict holds and some case ran.
///
/// # Errors
/// As [`run`], but for verdicts that do not hold.
pub fn results(options: &ValidationOptions, progress: &dyn Progress) -> Result<(String, bool), Failure> {
    let silent = ValidationOptions { json: true, ..options.clone() };
    let cases = chosen_cases(options)?;
    if options.list {
        return Ok((tables::list(&cases, ListFormat::Json), true));
    }
    let (done, page) = run_cases(&silent, cases, reference(options)?, progress)?;
    Ok((tables::json(&done, page.as_deref()), verdict(&done).is_ok()))
}

/// Runs cases and writes the page; prints a table of each case unless the output is JSON.
fn run_cases(
    options: &ValidationOptions,
    cases: Vec<&'static ValidationCase>,
    reference: &Path,
    progress: &dyn Progress,
) -> Result<(Vec<CaseResult>, Option<PathBuf>), Failure> {
    let whole = options.only.is_empty() && !options.quick;
    let output = options.output.clone().or(whole.then(|| PathBuf::from("docs")));
    let plots = match &output {
        Some(folder) => {
            PageFolder::create(folder)?;
            Some(PageFolder::create(&folder.join("validation"))?)
        }
        None => None,
    };
    let pictures = plots.as_ref().map(|f| f.path(""));
    let bench = CaseContext::new(reference, pictures.as_deref(), options.scenes.as_deref(), progress)?;
    let mut done = Vec::new();
    for case in cases {
        let one = run_timed(case, &bench)?;
        if !options.json {
            say(&tables::table(&one))?;
        }
        done.push(one);
    }
    let page = match (&output, &plots) {
        (Some(folder), Some(plots)) => Some(page::write(folder, plots, &done)?),
        _ => None,
    };
    Ok((done, page))
}

fn run_timed(case: &'static ValidationCase, bench: &CaseContext) -> Result<CaseResult, Failure> {
    let start = Instant::now();
    let missing = case.needs.filter(|file| !bench.reference.join(file).exists());
    let outcome = match missing {
        Some(file) => CaseOutcome::skipped(format!(
            "there is no {}; give its folder with --reference",
            bench.reference.join(file).display()
        )),
        None => (case.run)(bench).map_err(|e| Failure::new(format!("case {}: {e}", case.name)))?,
    };
    Ok(CaseResult { case, outcome, seconds: start.elapsed().as_secs_f64() })
}

/// A failure with an exit code of its own where a verdict does not hold, or nothing was checked.
fn verdict(done: &[CaseResult]) -> Result<(), Failure> {
    let failed: Vec<String> = (done.iter())
        .map(|d| (d.case.name, d.outcome.count(Verdict::Fail)))
        .filter(|f| f.1 > 0)
        .map(|(name, count)| format!("{name} ({count})"))
        .collect();
    if failed.is_empty() {
        if done.iter().all(|d| d.outcome.skipped.is_some()) {
            return Err(Failure::verdict(
                "nothing was checked: every chosen case was skipped; give the folder of their files with --reference",
            ));
        }
        return Ok(());
    }
    Err(Failure::verdict(format!("failing verdicts by case: {}", failed.join(", "))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use case::AcceptanceLimit;
    use std::collections::BTreeSet;

    #[test]
    fn patterns_match_names() {
        let fits = |p: &str, n: &str| matches_pattern(p.as_bytes(), n.as_bytes());
        assert!(fits("cube", "cube") && fits("c*", "cube") && fits("*", "cube") && fits("c?b*e", "cube"));
        assert!(!fits("cub", "cube") && !fits("cube?", "cube") && !fits("", "cube") && !fits("d*", "cube"));
        assert!(fits("*-c?*", "mc-c10") && !fits("*-c??", "mc-c0"));
    }

    #[test]
    fn case_names_are_unique() {
        let names: BTreeSet<&str> = cases().map(|c| c.name).collect();
        assert_eq!(names.len(), cases().count());
        assert!(cases().all(|c| !c.about.is_empty() && !c.title.is_empty()));
    }

    #[test]
    fn failing_verdict_has_its_own_exit_code() {
        let of = |reference: f64| {
            let mut outcome = CaseOutcome::default();
            outcome.check("two", reference, 2.0, AcceptanceLimit::Relative(1e-9));
            let case = cases().next().unwrap();
            verdict(&[CaseResult { case, outcome, seconds: 0.0 }])
        };
        assert!(of(2.0).is_ok());
        let e = of(2.1).unwrap_err();
        assert_eq!(e.code(), 1);
        assert!(e.to_string().contains("view-factors (1)"), "{e}");
    }
}
