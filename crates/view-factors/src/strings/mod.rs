//! Extruded geometries: exact factors by crossed strings in the cross-section.
//!
//! If every facet is a parallelogram as long as a period, with two edges along it, and every obstruction adjoins its images along it, the geometry and the exchange with all
//! images along that axis are those of the cross-section:
//!
//! ```text
//! A_i F_ij = P X_ij,      X_ij = ½ ∫∫ dτ ds over the visible directions from i to j      (H. C. Hottel's crossed strings)
//! ```
//!
//! | module | content |
//! |---|---|
//! | `section` | the cross-section in pieces that do not cross |
//! | `visible` | the visible wedges, integrated in closed form |
//!
//! Along a second period, columns are added until the exchange U_i with what lies beyond meets the tolerance, or the work its limit. X_ij lies between
//! max(X_ij, X_ji) of the columns and min(X_ij + U_i, X_ji + U_j).
//!
//! Source: H. C. Hottel and A. F. Sarofim, Radiative Transfer, 1967, section 2.3.

mod section;
#[cfg(test)]
mod tests;
mod visible;

use crate::geometry::contact_distance;
use crate::geometry::endless::sides_along;
use crate::geometry::occluders::merged_plates;
use crate::matrix::pairs::{PairExchange, round_up};
use crate::settings::ViewFactorSettings;
use crate::sky::SkyExchange;
use rayon::prelude::*;
use section::{Line, Section, SectionPiece};
use visible::{PieceView, Row};
use zonal_exchange::polygon::visible::ConvexPolygon;
use zonal_math::Bounded;
use zonal_scene::{Progress, SceneError};

/// Facets of a cross-section, at most: the work grows as their third power.
const MAX_LINES: usize = 200;
/// Columns on each side at first, and their growth.
const FIRST_COLUMNS: i32 = 4;
const COLUMN_GROWTH: i32 = 4;
/// Points that are visited, at most, for all facets together.
const MAX_WORK: u64 = 400_000_000;
/// Growth of the work with that of the columns.
const WORK_GROWTH: u64 = 24;
/// Rounding errors relative to the sum of moduli of all terms.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
/// Change of X for a displacement of the ends of the lines.
const STRINGS_OF_VERTEX: f64 = 8.0;
/// Sine below which lines are parallel.
const PARALLEL: f64 = 1e-12;

/// The exchange of an extruded geometry, m².
pub(crate) struct StringExchange {
    /// Surface of each facet of the cross-section, and the areas of these facets.
    pub surface: Vec<u32>,
    pub areas: Vec<f64>,
    pub pairs: Vec<PairExchange>,
    pub surroundings: Vec<(u32, SkyExchange)>,
}

/// The cross-section of the facets, and the length along the axis.
struct Extrusion {
    lines: Vec<Line>,
    /// Surface and length of each facet.
    surface: Vec<u32>,
    lengths: Vec<f64>,
    section: Section,
    period: f64,
}

/// The exchange of surfaces made of polygons; None if the geometry is not extruded along a period, or too large.
pub(crate) fn exchange(
    polygons: &[ConvexPolygon],
    surface: &[u32],
    obstructions: &[ConvexPolygon],
    settings: &ViewFactorSettings,
    progress: &dyn Progress,
) -> Result<Option<StringExchange>, SceneError> {
    for k in 0..2 {
        if let Some(extrusion) = Extrusion::along(k, polygons, surface, obstructions, settings) {
            let Some(rows) = extrusion.rows(settings, progress)? else { continue };
            return Ok(Some(extrusion.exchange(&rows)));
        }
    }
    Ok(None)
}

impl Extrusion {
    /// The cross-section perpendicular to a period.
    fn along(
        k: usize,
        polygons: &[ConvexPolygon],
        surface: &[u32],
        obstructions: &[ConvexPolygon],
        settings: &ViewFactorSettings,
    ) -> Option<Extrusion> {
        let period = settings.periods[k]?;
        let axes = settings.horizontal_axes();
        let all: Vec<&ConvexPolygon> = polygons.iter().chain(obstructions).collect();
        let contact = contact_distance(&all);
        let line = |p: &ConvexPolygon, facet: Option<u32>| {
            let [a, b, _, d] = sides_along(p.corners(), axes[k], contact)?;
            let length = (b - a).array()[axes[k]].abs();
            let fits = length >= period - contact && (facet.is_none() || length <= period + contact);
            let flat = |x: zonal_math::Vec3| [x.array()[axes[1 - k]], x.array()[settings.up]];
            let ([a, d], n) = ([flat(a), flat(d)], flat(p.normal()));
            let is_left = (d[0] - a[0]) * n[1] - (d[1] - a[1]) * n[0] > 0.0;
            let (a, b) = if is_left { (a, d) } else { (d, a) };
            fits.then_some(Line { a, b, facet })
        };
        let (mut lines, mut facets) = (Vec::new(), Vec::new());
        let mut members: std::collections::BTreeMap<u32, Vec<ConvexPolygon>> = Default::default();
        surface.iter().zip(polygons).for_each(|(s, p)| members.entry(*s).or_default().push(p.clone()));
        for (s, parts) in members {
            let parts = if parts.len() > 1 { merged_plates(parts, contact) } else { parts };
            for p in &parts {
                lines.push(line(p, Some(facets.len() as u32))?);
                facets.push(s);
                if lines.len() > MAX_LINES {
                    return None;
                }
            }
        }
        for p in merged_plates(obstructions.to_vec(), contact) {
            lines.push(line(&p, None)?);
        }
        if lines.len() > MAX_LINES {
            return None;
        }
        let section = Section::new(&lines, settings.periods[1 - k], contact)?;
        let lengths =
            lines[..facets.len()].iter().map(|l| (l.b[0] - l.a[0]).hypot(l.b[1] - l.a[1])).collect();
        Some(Extrusion { lines, surface: facets, lengths, section, period })
    }

    /// X of every facet with as many columns as the tolerance needs; None if the first columns cost too much.
    fn rows(
        &self,
        settings: &ViewFactorSettings,
        progress: &dyn Progress,
    ) -> Result<Option<Vec<Row>>, SceneError> {
        let mut columns = FIRST_COLUMNS;
        let mut best: Option<Vec<Row>> = None;
        loop {
            let (rows, work) = self.rows_of_columns(columns, progress);
            if progress.is_interrupted() {
                return Err(SceneError::interrupted());
            }
            let is_complete = (0..rows.len()).all(|i| rows[i].left_out <= 1e-9 * self.lengths[i]);
            if !is_complete {
                return Ok(best);
            }
            let meets = self.meets(&rows, settings.tolerance);
            best = Some(rows);
            if meets || self.section.period.is_none() || work.saturating_mul(WORK_GROWTH) > MAX_WORK {
                return Ok(best);
            }
            columns *= COLUMN_GROWTH;
        }
    }

    /// X of every facet with this number of columns on each side, and the work.
    fn rows_of_columns(&self, columns: i32, progress: &dyn Progress) -> (Vec<Row>, u64) {
        let n = self.surface.len();
        let sides: Vec<(&SectionPiece, usize, usize)> = self
            .section
            .pieces
            .iter()
            .flat_map(|p| [0, 1].map(|side| (p, side)))
            .filter_map(|(p, side)| p.facets[side].map(|f| (p, side, f as usize)))
            .collect();
        let share = MAX_WORK / sides.len().max(1) as u64;
        let run = |(piece, side, facet): &(&SectionPiece, usize, usize)| {
            let (mut row, mut work) = (Row::new(n), share);
            if !progress.is_interrupted() {
                PieceView::new(&self.section, piece, *side, columns).add_to(&mut row, &mut work);
            }
            (*facet, row, share - work)
        };
        let found: Vec<(usize, Row, u64)> = sides.par_iter().with_max_len(1).map(run).collect();
        let (mut rows, mut total) = (vec![Row::new(n); n], 0);
        for (facet, row, work) in found {
            rows[facet].add(&row);
            total += work;
        }
        (rows, total)
    }

    /// Radius of all X of a row for rounding, moved ends and what was left out, m.
    fn noise(&self, row: &Row) -> f64 {
        ROUNDING * row.terms + STRINGS_OF_VERTEX * self.section.moved + row.left_out
    }

    /// X of two facets, m.
    fn pair(&self, rows: &[Row], i: usize, j: usize) -> Bounded {
        let (x, y) = (rows[i].facets[j], rows[j].facets[i]);
        let most = |row: &Row| if self.may_face(i, j) { row.unresolved.iter().sum() } else { 0.0 };
        let low = x.max(y);
        let high = (x + most(&rows[i])).min(y + most(&rows[j]));
        let noise = self.noise(&rows[i]).max(self.noise(&rows[j]));
        // Both sides of the pair agree within rounding.
        Bounded::estimated(0.5 * (low + high), 0.5 * (high - low).abs() + noise)
    }

    /// False if no displacement along the second period makes two facets face each other.
    fn may_face(&self, i: usize, j: usize) -> bool {
        let direction = |k: usize| {
            let l = &self.lines[k];
            [l.b[0] - l.a[0], l.b[1] - l.a[1]].map(|x| x / self.lengths[k])
        };
        let (d, e) = (direction(i), direction(j));
        let is_parallel = (d[0] * e[1] - d[1] * e[0]).abs() <= PARALLEL;
        let is_same = is_parallel && d[0] * e[0] + d[1] * e[1] > 0.0;
        let rises = |i: usize, j: usize| {
            let (l, d) = (&self.lines[i], direction(i));
            let height = |p: [f64; 2]| d[0] * (p[1] - l.a[1]) - d[1] * (p[0] - l.a[0]);
            d[1].abs() > PARALLEL || [self.lines[j].a, self.lines[j].b].into_iter().any(|p| height(p) > 0.0)
        };
        !is_same && rises(i, j) && rises(j, i)
    }

    /// The surroundings of a row, m.
    fn surroundings(&self, row: &Row) -> SkyExchange {
        let part = |known: f64, unresolved: f64| {
            let half = 0.5 * unresolved;
            Bounded::estimated(known + half, half + self.noise(row))
        };
        let [below, above] = row.unresolved;
        SkyExchange { sky: part(row.sky, above), ground: part(row.ground, below), unresolved: above + below }
    }

    /// True if all radii are within the tolerance.
    fn meets(&self, rows: &[Row], tolerance: f64) -> bool {
        let n = rows.len();
        let absolute = |i: usize| crate::settings::ABSOLUTE_SHARE * tolerance * self.lengths[i];
        let pair = |i: usize, j: usize| {
            let x = self.pair(rows, i, j);
            x.radius <= (tolerance * x.value).max(absolute(i).min(absolute(j)))
        };
        (0..n).all(|i| {
            let s = self.surroundings(&rows[i]);
            s.sky.radius.max(s.ground.radius) <= crate::sky::SKY_GOAL * absolute(i)
                && (i + 1..n).all(|j| pair(i, j))
        })
    }

    fn exchange(self, rows: &[Row]) -> StringExchange {
        let n = rows.len();
        let mut pairs = Vec::new();
        for i in 0..n {
            for j in i + 1..n {
                let x = self.pair(rows, i, j);
                let is_seen = rows[i].facets[j] > 0.0 || rows[j].facets[i] > 0.0;
                if is_seen || x.value > 0.0 {
                    let (value, radius) = (x.value.max(0.0) * self.period, round_up(x.radius * self.period));
                    pairs.push(PairExchange { i: i as u32, j: j as u32, value, radius });
                }
            }
        }
        let surroundings = (0..n as u32).map(|i| {
            let s = self.surroundings(&rows[i as usize]);
            let scaled = SkyExchange {
                sky: s.sky * self.period,
                ground: s.ground * self.period,
                unresolved: s.unresolved * self.period,
            };
            (i, scaled)
        });
        let surroundings = surroundings.collect();
        let areas = self.lengths.iter().map(|l| l * self.period).collect();
        StringExchange { surface: self.surface, areas, pairs, surroundings }
    }
}
