//! The text of a scene in other sizes.

use std::fmt::Write as _;

/// The text with what `of` makes of the value on every line `key = …`; an error where there is none.
pub(super) fn with(
    text: &str,
    key: &str,
    of: impl Fn(&str) -> Result<String, Box<dyn std::error::Error>>,
) -> Result<String, Box<dyn std::error::Error>> {
    let (mut found, mut out) = (false, String::new());
    for line in text.lines() {
        let _ = match line.split_once('=').filter(|(k, _)| k.trim() == key) {
            Some((_, value)) => {
                found = true;
                writeln!(out, "{key} = {}", of(value.split('#').next().unwrap_or("").trim())?)
            }
            None => writeln!(out, "{line}"),
        };
    }
    if found { Ok(out) } else { Err(format!("the scene needs a line '{key} = …' to be sized by").into()) }
}
