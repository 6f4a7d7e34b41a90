//! Escaping of characters that control a terminal or change the direction of writing.

use std::borrow::Cow;

/// True for control characters and for characters that reorder adjacent text.
fn is_terminal_control(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{061c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// The text with every control character escaped as `\\u` and four hexadecimal digits, as in JSON.
///
/// ```
/// use zonal_scene::printable;
/// assert_eq!(printable("east wall"), "east wall");
/// assert_eq!(printable("\u{1b}[2J"), "\\u001b[2J");
/// ```
pub fn printable(text: &str) -> Cow<'_, str> {
    escape(text, is_terminal_control)
}

/// As [`printable`] for a text of several lines: line breaks are kept.
pub fn printable_lines(text: &str) -> Cow<'_, str> {
    escape(text, |c| c != '\n' && is_terminal_control(c))
}

/// A text of a document with its control characters escaped, for serde's `deserialize_with`.
///
/// # Errors
/// If the value is no text.
pub fn printable_text<'de, D: serde::Deserializer<'de>>(d: D) -> Result<String, D::Error> {
    Ok(printable(&<String as serde::Deserialize>::deserialize(d)?).into_owned())
}

fn escape(text: &str, is_escaped: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_escaped) {
        return Cow::Borrowed(text);
    }
    let escaped = |c: char| if is_escaped(c) { format!("\\u{:04x}", u32::from(c)) } else { c.to_string() };
    Cow::Owned(text.chars().map(escaped).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    // Guards (files): names cannot control a terminal and are no spreadsheet formulas.
    #[test]
    fn control_characters_are_escaped_and_other_text_is_unchanged() {
        assert!(matches!(printable("Wände, 壁 <&>"), Cow::Borrowed(_)));
        assert_eq!(printable("a\u{1b}[31m\r\n\u{9b}\u{202e}b"), "a\\u001b[31m\\u000d\\u000a\\u009b\\u202eb");
        assert_eq!(printable_lines("a\n\u{7}"), "a\n\\u0007");
    }
}
