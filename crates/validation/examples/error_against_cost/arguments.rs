//! The command line: words, `--name value` pairs and flags.

use crate::scenes::Error;

/// Options that stand alone.
const FLAGS: [&str; 3] = ["--quick", "--slow", "--json"];

/// The arguments behind the name of the program.
pub(crate) struct Arguments(Vec<String>);

impl Arguments {
    /// Of these words.
    pub(crate) fn new(words: Vec<String>) -> Arguments {
        Arguments(words)
    }

    /// The text behind `--name`.
    pub(crate) fn text(&self, name: &str) -> Option<&str> {
        let at = self.0.iter().position(|a| a == name)?;
        self.0.get(at + 1).map(String::as_str)
    }

    /// The number behind `--name`, or a default.
    pub(crate) fn number<T: std::str::FromStr>(&self, name: &str, default: T) -> Result<T, Error> {
        let Some(text) = self.text(name) else { return Ok(default) };
        text.parse().map_err(|_| format!("{name} {text}: give a number").into())
    }

    /// True where the flag is given.
    pub(crate) fn flag(&self, name: &str) -> bool {
        self.0.iter().any(|a| a == name)
    }

    /// The parts of the list behind `--name`, separated by commas.
    pub(crate) fn list(&self, name: &str) -> Option<Vec<&str>> {
        Some(self.text(name)?.split(',').filter(|s| !s.is_empty()).collect())
    }

    /// The word of an index among those that belong to no option.
    pub(crate) fn word(&self, index: usize) -> Option<&str> {
        let (mut k, mut found) = (0, 0);
        while let Some(word) = self.0.get(k) {
            if !word.starts_with('-') {
                if found == index {
                    return Some(word);
                }
                found += 1;
                k += 1;
            } else {
                k += if FLAGS.contains(&word.as_str()) { 1 } else { 2 };
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::Arguments;

    #[test]
    fn words_and_options_are_told_apart() {
        let words = "references --scenes a,b --quick DIR --limit 5";
        let arguments = Arguments::new(words.split(' ').map(String::from).collect());
        assert_eq!(arguments.word(0), Some("references"));
        assert_eq!(arguments.word(1), Some("DIR"));
        assert_eq!(arguments.word(2), None);
        assert_eq!(arguments.list("--scenes"), Some(vec!["a", "b"]));
        assert!(arguments.flag("--quick") && !arguments.flag("--slow"));
        assert_eq!(arguments.number("--limit", 1.0).ok(), Some(5.0));
        assert!(arguments.number::<f64>("--scenes", 1.0).is_err());
    }
}
