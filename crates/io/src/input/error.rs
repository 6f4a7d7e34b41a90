//! What is wrong with an input, where, and how to mend it.

use std::fmt;

/// Why a scene was refused: file, line, column, key, what is wrong and what to do.
///
/// Displays as `FILE:LINE:COLUMN: KEY: what is wrong; what to do`. Where a referenced file is at fault, the place is the
/// line of the scene that refers to it, and the text names that file and the place in it.
#[derive(Clone, PartialEq, Eq)]
pub struct InputError(Box<Inner>);

#[derive(Clone, PartialEq, Eq)]
struct Inner {
    file: String,
    place: Option<(usize, usize)>,
    key: String,
    what: String,
}

impl InputError {
    /// `place` is (line, column), both from 1; none where the file as a whole is at fault.
    pub(crate) fn new(
        file: &str,
        place: Option<(usize, usize)>,
        key: impl Into<String>,
        what: impl Into<String>,
    ) -> InputError {
        InputError(Box::new(Inner { file: file.to_string(), place, key: key.into(), what: what.into() }))
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Inner { file, place, key, what } = &*self.0;
        write!(f, "{file}")?;
        if let Some((line, column)) = place {
            write!(f, ":{line}:{column}")?;
        }
        if !key.is_empty() {
            write!(f, ": {key}")?;
        }
        write!(f, ": {what}")
    }
}

impl fmt::Debug for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

impl std::error::Error for InputError {}

/// A fault in a referenced file: its name, the place in it, what is wrong and what to do. The reader of the scene adds
/// the line that refers to it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Fault(String);

impl Fault {
    /// A fault at `place` (a line number, `accessor 3`, …; empty for the whole file) of `file`.
    pub(crate) fn new(file: &str, place: impl fmt::Display, what: impl fmt::Display) -> Fault {
        let place = place.to_string();
        Fault(if place.is_empty() { format!("{file}: {what}") } else { format!("{file}:{place}: {what}") })
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// The nearest of `known` to a misspelt `word`, where one is near enough.
pub(crate) fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase();
    known
        .into_iter()
        .map(|k| (distance(&word, &k.to_lowercase()), k))
        .filter(|(d, k)| *d <= 1 + k.chars().count().max(word.chars().count()) / 4)
        .min_by_key(|(d, _)| *d)
        .map(|(_, k)| k)
}

/// Edits (insert, delete, replace) between two words; long words are cut, so that the cost stays small.
fn distance(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.chars().take(64).collect();
    let b: Vec<char> = b.chars().take(64).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replace = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replace.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspelt_words_find_their_neighbour() {
        let known = ["reflectance", "emission", "sides"];
        assert_eq!(nearest("reflectanse", known), Some("reflectance"));
        assert_eq!(nearest("Emision", known), Some("emission"));
        assert_eq!(nearest("colour", known), None);
    }
}
