//! EULUMDAT: one value a line.
//!
//! | line | value |
//! |---|---|
//! | 3, 4, 6 | symmetry, number of C-planes Mc, number of angles Ng |
//! | 24 | factor of the intensities |
//! | 26 | number of sets of lamps n, then six lines for each: number of lamps, type, lumens of the set, colour, colour rendering, watts |
//! | 27 + 6n | ten direct ratios, Mc angles C, Ng angles γ, then the intensities in cd for 1000 lm, plane by plane |
//!
//! An intensity in cd is that of the file times the lumens of the first set over 1000. The light output ratio is in it already. Symmetry 1 lists one plane, 2 those from
//! 0° to 180°, 3 those from 270° over 0° to 90°, 4 those from 0° to 90°, 0 all.

use super::luminous_table::{AngleTable, LuminousTable, MAX_ANGLES};
use crate::input::reading::error::FileFault;
use zonal_scene::PlaneSymmetry;

/// Largest number of sets of lamps.
const MAX_LAMP_SETS: usize = 100;
/// Lines of a set of lamps, and of direct ratios.
const LINES_OF_SET: usize = 6;
const DIRECT_RATIOS: usize = 10;

/// Reads the text of a file.
pub(super) fn parse(file: &str, text: &str) -> Result<LuminousTable, FileFault> {
    let lines: Vec<&str> = text.trim_start_matches('\u{feff}').lines().map(str::trim).collect();
    let lines = ValueLines { file, lines };
    let symmetry = lines.count(3, 0, 4, "the symmetry")?;
    let mc = lines.count(4, 1, MAX_ANGLES, "the number of C-planes")?;
    let ng = lines.count(6, 2, MAX_ANGLES, "the number of angles γ")?;
    let factor = match lines.number(24, "the factor of the intensities")? {
        x if x > 0.0 => x,
        x => return Err(lines.fault(24, format!("the factor of the intensities is {x}; give one above 0"))),
    };
    let sets = lines.count(26, 1, MAX_LAMP_SETS, "the number of sets of lamps")?;
    let lumens = match lines.number(29, "the lumens of the lamps")? {
        x if x > 0.0 => x,
        x => return Err(lines.fault(29, format!("the lumens of the lamps are {x}; give a number above 0"))),
    };
    let first = 27 + LINES_OF_SET * sets + DIRECT_RATIOS;
    let all = lines.list(first, mc, "an angle C")?;
    let gammas = lines.list(first + mc, ng, "an angle γ")?;
    let (planes, symmetry) = listed_planes(&all, symmetry).map_err(|message| lines.fault(4, message))?;
    let values = lines.list(first + mc + ng, planes.len() * ng, "an intensity")?;
    let candelas = values.iter().map(|v| v * factor * lumens / 1000.0).collect();
    let table = in_ascending_order(AngleTable { planes, gammas, candelas }, symmetry);
    table.normalized(symmetry).map_err(|message| FileFault::new(file, "", message))
}

/// The planes whose intensities a file lists, in its order, degrees.
fn listed_planes(all: &[f64], symmetry: usize) -> Result<(Vec<f64>, PlaneSymmetry), String> {
    let mc = all.len();
    let parts = [1, 1, 2, 4, 4][symmetry.min(4)];
    if !mc.is_multiple_of(parts) {
        return Err(format!(
            "symmetry {symmetry} needs a number of C-planes that {parts} divides, and there are {mc}; give all planes of the circle"
        ));
    }
    Ok(match symmetry {
        1 => (vec![0.0], PlaneSymmetry::Rotational),
        2 => (closed(all, 0..=mc / 2), PlaneSymmetry::AboutC0),
        3 => {
            // The mirror images of 270° over 0° to 90° are 270° to 90°.
            let listed = closed(all, 3 * mc / 4..=3 * mc / 4 + mc / 2);
            (listed.into_iter().map(|c| (540.0 - c).rem_euclid(360.0)).collect(), PlaneSymmetry::AboutC90)
        }
        4 => (closed(all, 0..=mc / 4), PlaneSymmetry::Quadrants),
        _ => (all.to_vec(), PlaneSymmetry::None),
    })
}

/// The planes of a range of indices on the circle.
fn closed(all: &[f64], range: std::ops::RangeInclusive<usize>) -> Vec<f64> {
    let mc = all.len();
    range.map(|k| all[k % mc]).collect()
}

/// The table with ascending planes: those of symmetry 3 descend.
fn in_ascending_order(table: AngleTable, symmetry: PlaneSymmetry) -> AngleTable {
    if symmetry != PlaneSymmetry::AboutC90 {
        return table;
    }
    let n = table.gammas.len();
    let candelas = table.candelas.chunks(n).rev().flatten().copied().collect();
    AngleTable { planes: table.planes.into_iter().rev().collect(), candelas, ..table }
}

/// The lines of a file, from 1.
struct ValueLines<'a> {
    file: &'a str,
    lines: Vec<&'a str>,
}

impl ValueLines<'_> {
    fn fault(&self, line: usize, message: impl std::fmt::Display) -> FileFault {
        FileFault::new(self.file, line, message)
    }

    /// The number of a line, with a decimal point or comma.
    fn number(&self, line: usize, what: &str) -> Result<f64, FileFault> {
        let Some(text) = line.checked_sub(1).and_then(|k| self.lines.get(k)) else {
            let last = self.lines.len();
            return Err(self.fault(last, format!("the file ends before {what}; give the whole file")));
        };
        match text.replace(',', ".").parse::<f64>() {
            Ok(x) if x.is_finite() => Ok(x),
            _ => Err(self.fault(line, format!("'{text}' stands where {what} belongs; give a number"))),
        }
    }

    /// A whole number within limits.
    fn count(&self, line: usize, least: usize, most: usize, what: &str) -> Result<usize, FileFault> {
        match self.number(line, what)? {
            x if x >= least as f64 && x <= most as f64 && x.fract() == 0.0 => Ok(x as usize),
            x => Err(self.fault(line, format!("{what} is {x}; give a whole number from {least} to {most}"))),
        }
    }

    /// `count` numbers from a line on; memory grows with what the file holds, not with the count.
    fn list(&self, first: usize, count: usize, what: &str) -> Result<Vec<f64>, FileFault> {
        (first..first.saturating_add(count)).map(|line| self.number(line, what)).collect()
    }
}
