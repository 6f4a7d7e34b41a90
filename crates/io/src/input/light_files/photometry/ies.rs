//! ANSI/IES LM-63: labels, `TILT=`, then numbers in one stream.
//!
//! ```text
//! lamps  lumens  multiplier  vertical angles  horizontal angles  type  units  width length height
//! ballast factor   ballast-lamp photometric factor   watts
//! vertical angles …   horizontal angles …   candelas, one horizontal angle after the other
//! ```
//!
//! An intensity is the candelas of the file times the multiplier, the ballast factor and, in files of 1986 and 1991, the ballast-lamp photometric factor;
//! later editions keep other data in its place. Lumens of −1 mark absolute photometry, which needs no other treatment. Factors of `TILT=INCLUDE` belong to the angle between the
//! aim and straight down; where the lamp lies across the luminaire (geometry 2 and 3) that angle alone does not determine its position. Tables of type B and A become tables of
//! type C (`type_c`).

use super::luminous_table::{AngleTable, LuminousTable, MAX_ANGLES, TiltFactors};
use super::type_c::{GoniometerType, to_type_c};
use crate::input::reading::error::FileFault;
use zonal_scene::PlaneSymmetry;

/// Deviation of the ends of the planes from 0, 90, 180, 270 and 360 that counts as rounding, degrees.
const END_ROUNDING: f64 = 0.01;
/// Largest product of the factors of a file.
const MAX_FACTOR: f64 = 1e9;

/// Reads the text of a file.
pub(super) fn parse(file: &str, text: &str) -> Result<LuminousTable, FileFault> {
    let mut numbers = NumberStream::after_labels(file, text)?;
    let has_photometric_factor = numbers.has_photometric_factor;
    let tilt = numbers.tilt_factors()?;
    // Counts and factors.
    let _lamps = numbers.next("the number of lamps")?;
    let _lumens = numbers.next("the lumens per lamp")?;
    let multiplier = numbers.next("the multiplier")?;
    let vertical = numbers.count("the number of vertical angles")?;
    let horizontal = numbers.count("the number of horizontal angles")?;
    let kind = numbers.next("the photometric type")?;
    for what in ["the units", "the width", "the length", "the height"] {
        numbers.next(what)?;
    }
    let ballast = numbers.next("the ballast factor")?;
    let photometric = numbers.next("the ballast-lamp photometric factor")?;
    numbers.next("the watts")?;
    let factor = multiplier * ballast * if has_photometric_factor { photometric } else { 1.0 };
    if !(factor > 0.0 && factor <= MAX_FACTOR) {
        return Err(numbers.fault(format!(
            "multiplier times ballast factors is {factor}; give factors above 0, whose product is at most {MAX_FACTOR:e}"
        )));
    }
    // Angles and candelas.
    let gammas = numbers.list(vertical, "a vertical angle")?;
    let planes = numbers.list(horizontal, "a horizontal angle")?;
    let values = numbers.list(vertical * horizontal, "an intensity")?;
    let candelas = values.iter().map(|v| v * factor).collect();
    let table = AngleTable { planes, gammas, candelas };
    let whole = |message: String| FileFault::new(file, "", message);
    let read = match kind {
        1.0 => {
            let symmetry = symmetry_of(&table.planes).map_err(whole)?;
            table.normalized(symmetry).map_err(whole)
        }
        2.0 => to_type_c(&table, GoniometerType::B).map_err(whole),
        3.0 => to_type_c(&table, GoniometerType::A).map_err(whole),
        other => {
            Err(whole(format!("the photometric type is {other}; give 1 (type C), 2 (type B) or 3 (type A)")))
        }
    };
    read.map(|read| LuminousTable { tilt, ..read })
}

/// The symmetry that the first and the last plane of type C imply.
fn symmetry_of(planes: &[f64]) -> Result<PlaneSymmetry, String> {
    let (first, last) = match planes {
        [_] => return Ok(PlaneSymmetry::Rotational),
        [first, .., last] => (*first, *last),
        [] => return Err("there are no horizontal angles; give at least one".into()),
    };
    let is = |x: f64, wanted: f64| (x - wanted).abs() <= END_ROUNDING;
    if is(first, 0.0) && is(last, 90.0) {
        Ok(PlaneSymmetry::Quadrants)
    } else if is(first, 0.0) && is(last, 180.0) {
        Ok(PlaneSymmetry::AboutC0)
    } else if is(first, 90.0) && is(last, 270.0) {
        Ok(PlaneSymmetry::AboutC90)
    } else if is(first, 0.0) && last > 180.0 && last <= 360.0 + END_ROUNDING {
        Ok(PlaneSymmetry::None)
    } else {
        Err(format!(
            "horizontal angles from {first} to {last} degrees have no meaning in type C; give 0, or 0 to 90, 180 or 360, or 90 to 270"
        ))
    }
}

/// The numbers behind the labels, with their lines.
struct NumberStream<'a> {
    file: &'a str,
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    rest: &'a str,
    /// Number of the current line, from 1.
    line: usize,
    /// What follows `TILT=`.
    tilt: &'a str,
    /// True in editions with a ballast-lamp photometric factor.
    has_photometric_factor: bool,
}

impl<'a> NumberStream<'a> {
    /// The stream behind the line `TILT=`.
    fn after_labels(file: &'a str, text: &'a str) -> Result<NumberStream<'a>, FileFault> {
        let mut lines = text.trim_start_matches('\u{feff}').lines().enumerate();
        let mut has_photometric_factor = true;
        while let Some((k, line)) = lines.next() {
            let line = line.trim();
            let first = k == 0 && ["IESNA:LM-63", "IES:LM-63"].iter().any(|p| line.starts_with(p));
            if first {
                has_photometric_factor = false;
            }
            if let Some((key, tilt)) = line.split_once('=')
                && key.trim().eq_ignore_ascii_case("TILT")
            {
                return Ok(NumberStream {
                    file,
                    lines,
                    rest: "",
                    line: k + 1,
                    tilt: tilt.trim(),
                    has_photometric_factor,
                });
            }
        }
        Err(FileFault::new(file, "", "there is no line TILT=; give a file of IES LM-63"))
    }

    /// The factors of tilted lamps.
    fn tilt_factors(&mut self) -> Result<Option<TiltFactors>, FileFault> {
        if self.tilt.eq_ignore_ascii_case("NONE") {
            return Ok(None);
        }
        if !self.tilt.eq_ignore_ascii_case("INCLUDE") {
            return Err(self.fault(format!(
                "TILT={} refers to another file; write TILT=NONE, or TILT=INCLUDE and the factors",
                self.tilt
            )));
        }
        let geometry = self.next("the geometry of the lamp")?;
        if ![1.0, 2.0, 3.0].contains(&geometry) {
            return Err(self.fault(format!("the geometry of the lamp is {geometry}; give 1, 2 or 3")));
        }
        let count = self.count("the number of tilt angles")?;
        let angles = self.list(count, "a tilt angle")?;
        let factors = self.list(count, "a tilt factor")?;
        TiltFactors::new(geometry == 1.0, angles, factors).map(Some).map_err(|e| self.fault(e))
    }

    fn fault(&self, message: impl std::fmt::Display) -> FileFault {
        FileFault::new(self.file, self.line, message)
    }

    /// The next number.
    fn next(&mut self, what: &str) -> Result<f64, FileFault> {
        let separates = |c: char| c.is_whitespace() || c == ',';
        loop {
            self.rest = self.rest.trim_start_matches(separates);
            if !self.rest.is_empty() {
                break;
            }
            let Some((k, line)) = self.lines.next() else {
                return Err(self.fault(format!("the file ends before {what}; give the whole file")));
            };
            (self.line, self.rest) = (k + 1, line);
        }
        let end = self.rest.find(separates).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        match word.parse::<f64>() {
            Ok(x) if x.is_finite() => Ok(x),
            _ => Err(self.fault(format!("'{word}' stands where {what} belongs; give a number"))),
        }
    }

    /// A number of angles.
    fn count(&mut self, what: &str) -> Result<usize, FileFault> {
        match self.next(what)? {
            x if x >= 1.0 && x <= MAX_ANGLES as f64 && x.fract() == 0.0 => Ok(x as usize),
            x => Err(self.fault(format!("{what} is {x}; give a whole number from 1 to {MAX_ANGLES}"))),
        }
    }

    /// The next `count` numbers; memory grows with what the file holds, not with the count.
    fn list(&mut self, count: usize, what: &str) -> Result<Vec<f64>, FileFault> {
        (0..count).map(|_| self.next(what)).collect()
    }
}
