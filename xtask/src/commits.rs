//! Messages of commits: an area and a colon, a short subject, one change, and a body with the reason.
//!
//! The check begins after the commit that added this file, which git finds by the file's history; earlier messages stay as they are.
//!
//! Guards (structure): commits have an area, a short subject of one change, and a body with the reason.

use std::path::Path;
use std::process::Command;

/// Most characters of a subject.
const MAX_SUBJECT: usize = 60;
/// This file, whose first commit is where the check begins.
const THIS_FILE: &str = "xtask/src/commits.rs";

/// The rules that a message breaks, each in one phrase.
#[must_use]
pub fn violations(message: &str) -> Vec<String> {
    let mut lines = message.trim_end().lines();
    let subject = lines.next().unwrap_or("");
    let mut found = Vec::new();
    let area = subject.split_once(": ").filter(|(area, change)| is_area(area) && !change.trim().is_empty());
    if area.is_none() {
        found.push("the subject has no area: write `area: what changes`".to_string());
    }
    let length = subject.chars().count();
    if length > MAX_SUBJECT {
        found.push(format!("the subject has {length} characters, more than {MAX_SUBJECT}"));
    }
    if subject.contains(';') {
        found.push("the subject is a list with semicolons: one change for each commit".to_string());
    }
    if lines.next().is_some_and(|l| !l.trim().is_empty()) {
        found.push("no empty line follows the subject".to_string());
    }
    if !lines.any(|l| !l.trim().is_empty() && !is_trailer(l)) {
        found.push("there is no body: give the reason, and the numbers that changed".to_string());
    }
    found
}

/// An area: names of crates, folders or documents, separated by commas.
fn is_area(area: &str) -> bool {
    area.split(", ").all(|name| {
        let part_of_name = |c: char| c.is_alphanumeric() || "-_./ ".contains(c);
        name.starts_with(|c: char| c.is_alphanumeric() || c == '.') && name.chars().all(part_of_name)
    })
}

/// A line such as `Signed-off-by: NAME`.
fn is_trailer(line: &str) -> bool {
    line.split_once(": ").is_some_and(|(key, _)| key.ends_with("-by") && !key.contains(' '))
}

/// Standard output of a git command in the workspace, or the reason why there is none.
fn git(root: &Path, arguments: &[&str]) -> Result<String, String> {
    let output = Command::new("git").arg("-C").arg(root).args(arguments).output();
    let output = output.map_err(|e| format!("git could not be started: {e}"))?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr)
            .lines()
            .next()
            .unwrap_or("git failed")
            .to_string());
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Hash and message of every commit that descends from the first one of this file, merges left out; `Err` says why there are none to check.
fn messages(root: &Path) -> Result<Vec<(String, String)>, String> {
    if git(root, &["rev-parse", "--is-shallow-repository"])?.trim() == "true" {
        return Err("this clone is shallow".to_string());
    }
    let added = git(root, &["log", "--diff-filter=A", "--reverse", "--format=%H", "--", THIS_FILE])?;
    let first = added.lines().next().ok_or("no commit adds the check yet")?;
    let since = format!("{first}..HEAD");
    let log = git(root, &["log", "--no-merges", "--ancestry-path", "--format=%h%x1f%B%x1e", &since])?;
    let entries = log.split('\u{1e}').filter_map(|entry| entry.trim_start().split_once('\u{1f}'));
    Ok(entries.map(|(hash, message)| (hash.to_string(), message.to_string())).collect())
}

/// Checks the messages and prints the violations; returns whether there are none. Without git, or in a shallow clone, the check is skipped.
#[must_use]
pub fn report(root: &Path) -> bool {
    let messages = match messages(root) {
        Ok(messages) => messages,
        Err(reason) => {
            println!("skipped: messages of commits are not checked: {reason}");
            return true;
        }
    };
    let mut bad = 0;
    for (hash, message) in &messages {
        let found = violations(message);
        bad += usize::from(!found.is_empty());
        for violation in found {
            println!("{hash} {}\n      {violation}", message.lines().next().unwrap_or(""));
        }
    }
    println!("{} commits, {bad} with wrong messages", messages.len());
    bad == 0
}

#[cfg(test)]
mod tests {
    use super::violations;

    #[test]
    fn good_messages_have_no_violations() {
        for good in [
            "io: limit nesting of tables\n\nA file of 1 kB took 4 GB.\n",
            "cli, validation: at most 18 entries\n\nNo number changes.\n\nSigned-off-by: A <a@b.c>\n",
            "README: begins with its title\n\n- the first screen shows two commands",
            ".ci: one environment for all steps\n\nIt was installed twice.",
            "view-factors: sky: bounds of images\n\nRadii grow by 1e-9.",
        ] {
            assert_eq!(violations(good), Vec::<String>::new(), "{good}");
        }
    }

    #[test]
    fn each_violation_is_found() {
        for (bad, word) in [
            ("Limit nesting\n\nA reason.", "no area"),
            ("io:limit nesting\n\nA reason.", "no area"),
            (": limit nesting\n\nA reason.", "no area"),
            ("io: \n\nA reason.", "no area"),
            ("io: a; b\n\nA reason.", "semicolons"),
            ("io: limit nesting", "no body"),
            ("io: limit nesting\n\n\n  \n", "no body"),
            ("io: limit nesting\n\nSigned-off-by: A <a@b.c>", "no body"),
            ("io: limit nesting\nof tables\n\nA reason.", "no empty line"),
            ("", "no area"),
        ] {
            let found = violations(bad);
            assert!(found.iter().any(|v| v.contains(word)), "{bad:?}: {found:?}");
        }
    }

    #[test]
    fn length_of_subjects_counts_characters() {
        let message = |n: usize| format!("io: {}\n\nA reason.", "ü".repeat(n - 4));
        assert!(violations(&message(60)).is_empty());
        assert_eq!(violations(&message(61)).len(), 1);
    }
}
