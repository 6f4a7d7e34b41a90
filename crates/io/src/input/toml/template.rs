//! A scene as a template: numbers of its text that are replaced by others, the rest unchanged.
//!
//! A number is named by its path: `medium.heat_source`, `surface.wall.temperature` (the table `[[surface]]` with `name = "wall"`), `surface.0.emissivity`
//! (the first one), `medium.max.2` (an element of an array), `surface.*.emissivity` (all of them, which get the same value). Names with dots
//! stand in double quotes: `surface."left.wall".temperature`.

use super::source::SourceText;
use crate::input::reading::error::InputError;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The part of a path that stands for every entry.
const EVERY_ENTRY: &str = "*";

/// The text of a scene with numbers to replace.
#[derive(Clone, Debug)]
pub(crate) struct TextTemplate {
    text: String,
    /// Places of the numbers of each path.
    places: Vec<Vec<Range<usize>>>,
}

impl TextTemplate {
    /// Finds the numbers at `paths` in the text of the scene `file`.
    ///
    /// # Errors
    /// The text is not TOML, a path leads to no number, or two lead to the same.
    pub(crate) fn new(file: &str, text: &str, paths: &[String]) -> Result<TextTemplate, InputError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let source = SourceText::new(file, text);
        let document = source.parse()?;
        let mut found = TextTemplate { text: text.into(), places: Vec::new() };
        for path in paths {
            let mut places = Vec::new();
            let parts = split_path(path);
            in_table(document.get_ref(), &parts, &mut places)
                .map_err(|(offset, what)| source.error(offset, path, what))?;
            if places.is_empty() {
                return Err(source.error(0, path, "nothing matches '*'; name an entry of the scene"));
            }
            if let Some(twice) = places.iter().find(|p| found.places.iter().flatten().any(|q| q == *p)) {
                return Err(source.error(twice.start, path, "this number is varied twice; keep one"));
            }
            found.places.push(places);
        }
        Ok(found)
    }
    /// The text with other numbers, one for each path.
    pub(crate) fn text_with(&self, values: &[f64]) -> String {
        let places = self.places.iter().zip(values);
        let mut all: Vec<(&Range<usize>, f64)> =
            places.flat_map(|(places, x)| places.iter().map(|p| (p, *x))).collect();
        all.sort_by_key(|p| p.0.start);
        let mut out = self.text.clone();
        all.iter().rev().for_each(|(place, x)| out.replace_range((*place).clone(), &number(*x)));
        out
    }
}

/// A number in TOML; whole numbers are integers, which keys of counts require.
fn number(x: f64) -> String {
    const MAX_WHOLE: f64 = 1e15;
    if x.fract() == 0.0 && x.abs() < MAX_WHOLE { format!("{x:.0}") } else { format!("{x:?}") }
}

/// The parts of a path between its dots; dots in double quotes are part of a name.
fn split_path(path: &str) -> Vec<String> {
    let (mut parts, mut is_quoted) = (vec![String::new()], false);
    for c in path.chars() {
        match c {
            '"' => is_quoted = !is_quoted,
            '.' if !is_quoted => parts.push(String::new()),
            _ => parts.iter_mut().last().into_iter().for_each(|p| p.push(c)),
        }
    }
    parts
}

/// The offset of an error and its message.
type Search = Result<(), (usize, String)>;
/// Places of numbers.
type Places = Vec<Range<usize>>;

fn in_table(table: &DeTable, parts: &[String], out: &mut Places) -> Search {
    let Some((part, rest)) = parts.split_first() else {
        return Err((0, "this is a table; name a number in it".into()));
    };
    if part == EVERY_ENTRY {
        return table.iter().try_for_each(|(_, value)| in_value(value, rest, out));
    }
    match table.get(part.as_str()) {
        Some(value) => in_value(value, rest, out),
        None => Err((
            table.iter().next().map_or(0, |(key, _)| key.span().start),
            format!("there is no '{part}' here; write it in the template with a number"),
        )),
    }
}

fn in_value(value: &Spanned<DeValue>, parts: &[String], out: &mut Places) -> Search {
    let (place, start) = (value.span(), value.span().start);
    match value.get_ref() {
        DeValue::Table(table) if parts.is_empty() => {
            let key = table.iter().next().map_or("key", |(key, _)| key.get_ref().as_ref());
            Err((start, format!("this is a table; name a number in it, such as '{key}'")))
        }
        DeValue::Table(table) => in_table(table, parts, out),
        DeValue::Array(list) if !parts.is_empty() => {
            let (part, rest) = (&parts[0], &parts[1..]);
            let is_chosen = |(k, entry): (usize, &Spanned<DeValue>)| {
                let name = entry.get_ref().as_table().and_then(|t| t.get("name")?.get_ref().as_str());
                part == EVERY_ENTRY || name == Some(part) || part.parse() == Ok(k)
            };
            let chosen: Vec<&Spanned<DeValue>> =
                list.iter().enumerate().filter(|e| is_chosen(*e)).map(|e| e.1).collect();
            if chosen.is_empty() {
                let what = format!("no entry has the name or the number '{part}'; numbers begin with 0");
                return Err((start, what));
            }
            chosen.into_iter().try_for_each(|entry| in_value(entry, rest, out))
        }
        DeValue::Integer(n) if parts.is_empty() => push_number(n.as_str(), place, out),
        DeValue::Float(x) if parts.is_empty() => push_number(x.as_str(), place, out),
        _ if parts.is_empty() => Err((start, "this is no number; only numbers can be varied".into())),
        _ => Err((start, format!("there is no '{}' in this value; name a number of the scene", parts[0]))),
    }
}

fn push_number(text: &str, place: Range<usize>, out: &mut Places) -> Search {
    if text.replace('_', "").parse::<f64>().is_err() {
        return Err((place.start, "this is no decimal number; write it in decimal".into()));
    }
    out.push(place);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = "[medium]\nmax = [1, 1, 2.5] # m\nheat_source = 5_000\n[[surface]]\nname = \"a.b\"\nfaces.z0 = { temperature = 1e3 }\n[[surface]]\nname = \"c\"\nfaces.z0 = { temperature = 900 }\n";

    fn varied(paths: &[&str], values: &[f64]) -> Result<String, String> {
        let paths: Vec<String> = paths.iter().map(|p| p.to_string()).collect();
        let template = TextTemplate::new("t.toml", SCENE, &paths).map_err(|e| e.to_string())?;
        assert!(DeTable::parse(&template.text_with(&vec![0.5; paths.len()])).is_ok());
        Ok(template.text_with(values))
    }

    #[test]
    fn numbers_are_replaced_and_the_rest_stays() {
        let text = varied(&["medium.max.2", "surface.\"a.b\".faces.z0.temperature"], &[3.0, 1.5e-7]).unwrap();
        assert_eq!(text, SCENE.replace("2.5]", "3]").replace("1e3", "1.5e-7"));
        let text = varied(&["surface.*.faces.z0.temperature", "medium.heat_source"], &[777.25, 0.0]).unwrap();
        assert_eq!(text, SCENE.replace("1e3", "777.25").replace("900", "777.25").replace("5_000", "0"));
        assert_eq!(varied(&["surface.1.faces.z0.temperature"], &[1.0]).unwrap(), SCENE.replace("900", "1"));
    }

    #[test]
    fn paths_without_a_number_are_refused_by_name() {
        for (paths, message) in [
            (&["medium.heat"][..], "medium.heat: there is no 'heat' here"),
            (&["medium"], "medium: this is a table; name a number in it, such as 'heat_source'"),
            (&["surface.d.x"], "no entry has the name or the number 'd'"),
            (&["surface.c.name"], "this is no number"),
            (&["medium.heat_source.x"], "there is no 'x' in this value"),
            (&["surface.c.faces.z0.temperature", "surface.*.faces.z0.temperature"], "varied twice"),
        ] {
            let error = varied(paths, &[1.0; 2]).unwrap_err();
            assert!(error.starts_with("t.toml:") && error.contains(message), "{error}");
        }
    }
}
