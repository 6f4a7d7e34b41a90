//! Suggestions for misspelt words: the known word at the smallest Levenshtein distance (crate strsim).

/// Characters of a word that are compared, so that the cost of hostile input stays bounded.
const MAX_COMPARED_CHARS: usize = 64;

/// `did you mean 'x'?`, or the list of known words.
pub(crate) fn suggest(word: &str, known: &[&str]) -> String {
    match nearest(word, known.iter().copied()) {
        Some(k) => format!("did you mean '{k}'?"),
        None => format!("known here: {}", known.join(", ")),
    }
}

/// The nearest of `known` to a misspelt `word`: at most one edit, and another for every four characters of the longer word.
fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase();
    known
        .into_iter()
        .map(|k| (edit_distance(&word, &k.to_lowercase()), k))
        .filter(|(d, k)| *d <= 1 + k.chars().count().max(word.chars().count()) / 4)
        .min_by_key(|(d, _)| *d)
        .map(|(_, k)| k)
}

fn edit_distance(a: &str, b: &str) -> usize {
    let cut = |s: &str| s.chars().take(MAX_COMPARED_CHARS).collect::<String>();
    strsim::levenshtein(&cut(a), &cut(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspelt_words_find_the_nearest_known_word() {
        let known = ["reflectance", "emission", "sides"];
        assert_eq!(nearest("reflectanse", known), Some("reflectance"));
        assert_eq!(nearest("Emision", known), Some("emission"));
        assert_eq!(nearest("colour", known), None);
    }
}
