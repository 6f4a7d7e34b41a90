//! Text that a terminal shows as it is: control characters and those that turn the direction of writing are spelled out.

use std::borrow::Cow;

/// True for characters that steer a terminal or reorder what is beside them.
pub fn steers(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{061c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// The text with every such character as `\\u` and four hexadecimal digits, as JSON writes it.
pub fn printable(text: &str) -> Cow<'_, str> {
    spelled(text, steers)
}

/// The same for a text of several lines: line breaks stay.
pub fn printable_lines(text: &str) -> Cow<'_, str> {
    spelled(text, |c| c != '\n' && steers(c))
}

fn spelled(text: &str, spell: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&spell) {
        return Cow::Borrowed(text);
    }
    let one = |c: char| if spell(c) { format!("\\u{:04x}", u32::from(c)) } else { c.to_string() };
    Cow::Owned(text.chars().map(one).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_steers_is_spelled_out_and_the_rest_stays() {
        assert!(matches!(printable("Wände, 壁 <&>"), Cow::Borrowed(_)));
        assert_eq!(printable("a\u{1b}[31m\r\n\u{9b}\u{202e}b"), "a\\u001b[31m\\u000d\\u000a\\u009b\\u202eb");
        assert_eq!(printable_lines("a\n\u{7}"), "a\n\\u0007");
    }
}
