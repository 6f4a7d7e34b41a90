//! Windows: tracery, coloured glass in cames, saddle bars; and the rose.
//!
//! A pointed window of two lights has a mullion, an arch over each light and an oculus above; the spandrels are stone. Each of these openings is
//! convex, so its glass is a grid of cells, cut along the opening's outline: borders of two alternating hues, a ground of two more, and
//! medallions. Cames are strips along the lines of the grid, a few millimetres in front of the glass.

use super::arch::PointedArch;
use super::convex_polygons::{Point2, clip_segment, difference, intersection};
use super::model::{ChurchMaterial, ChurchModel};
use super::plan::ChurchPlan;
use super::wall::{WallFrame, WallOpening, reveal};
use std::f64::consts::TAU;
use zonal_scene::Bands;

/// A hue of glass: name and transmittance.
pub struct GlassHue {
    /// Name.
    pub name: &'static str,
    /// Transmittance square to the pane.
    pub transmittance: Bands,
}

/// The hues of the glass.
pub const HUES: [GlassHue; 10] = [
    GlassHue { name: "ruby", transmittance: Bands::from_rgb([0.66, 0.02, 0.03]) },
    GlassHue { name: "gold", transmittance: Bands::from_rgb([0.88, 0.58, 0.06]) },
    GlassHue { name: "cobalt", transmittance: Bands::from_rgb([0.03, 0.10, 0.66]) },
    GlassHue { name: "azure", transmittance: Bands::from_rgb([0.16, 0.46, 0.80]) },
    GlassHue { name: "emerald", transmittance: Bands::from_rgb([0.04, 0.50, 0.12]) },
    GlassHue { name: "violet", transmittance: Bands::from_rgb([0.40, 0.06, 0.55]) },
    GlassHue { name: "rose", transmittance: Bands::from_rgb([0.82, 0.28, 0.40]) },
    GlassHue { name: "amber", transmittance: Bands::from_rgb([0.84, 0.32, 0.03]) },
    GlassHue { name: "turquoise", transmittance: Bands::from_rgb([0.05, 0.56, 0.52]) },
    GlassHue { name: "clear", transmittance: Bands::from_rgb([0.80, 0.80, 0.72]) },
];
const RUBY: usize = 0;
const GOLD: usize = 1;
const COBALT: usize = 2;
const AZURE: usize = 3;
const EMERALD: usize = 4;
const VIOLET: usize = 5;
const ROSE: usize = 6;
const AMBER: usize = 7;
const TURQUOISE: usize = 8;
const COLOURLESS: usize = 9;

/// The hues of a window: border, ground, medallions; two each.
pub(super) struct GlassScheme {
    border: [usize; 2],
    ground: [usize; 2],
    medallion: [usize; 2],
}

/// Schemes that neighbouring windows take in turn.
pub(super) const GLASS_SCHEMES: [GlassScheme; 6] = [
    GlassScheme { border: [RUBY, GOLD], ground: [COBALT, AZURE], medallion: [GOLD, RUBY] },
    GlassScheme { border: [EMERALD, COLOURLESS], ground: [GOLD, AMBER], medallion: [RUBY, ROSE] },
    GlassScheme { border: [COBALT, COLOURLESS], ground: [VIOLET, ROSE], medallion: [AZURE, GOLD] },
    GlassScheme { border: [AMBER, RUBY], ground: [EMERALD, TURQUOISE], medallion: [GOLD, COLOURLESS] },
    GlassScheme { border: [AZURE, GOLD], ground: [RUBY, AMBER], medallion: [COBALT, COLOURLESS] },
    GlassScheme { border: [VIOLET, COLOURLESS], ground: [TURQUOISE, AZURE], medallion: [ROSE, AMBER] },
];

/// Depth of the glass behind the wall's inner face, m.
const GLASS_DEPTH: f64 = 0.3;
/// The strips of a reveal: before the glass and behind it, as far as a wall's openings reach in, m.
const REVEAL_DEPTHS: [f64; 3] = [0.0, GLASS_DEPTH, 0.4];
/// Half width of a came and its distance in front of the glass, m.
const CAME_HALF_WIDTH_AND_OFFSET: (f64, f64) = (0.009, 0.004);

/// A bar of rectangular section in a frame's plane: half its depth and half its breadth, m. Its flanks are parted in the middle, where
/// the glass is: no face is lit from both sides of it.
fn section(half_depth: f64, half_breadth: f64) -> [[f64; 2]; 6] {
    let (d, b) = (half_depth, half_breadth);
    [[-d, -b], [0.0, -b], [d, -b], [d, b], [0.0, b], [-d, b]]
}

fn bar(
    m: &mut ChurchModel,
    frame: &WallFrame,
    line: &[Point2],
    stuff: ChurchMaterial,
    depth: f64,
    section: &[[f64; 2]],
) {
    let line: Vec<_> = line.iter().map(|p| frame.at(p[0], p[1], depth)).collect();
    m.sweep(stuff, &line, frame.inward, section);
}

/// A round bar of stone with a radius and a number of straight pieces.
fn ring(
    m: &mut ChurchModel,
    frame: &WallFrame,
    at: Point2,
    radius: f64,
    pieces: usize,
    section: &[[f64; 2]],
) {
    let point = |k: usize| {
        let (sin, cos) = (TAU * k as f64 / pieces as f64).sin_cos();
        [at[0] + radius * cos, at[1] + radius * sin]
    };
    let line: Vec<Point2> = (0..pieces).map(point).chain([point(0)]).collect();
    bar(m, frame, &line, ChurchMaterial::Dressed, GLASS_DEPTH, section);
}

/// A window of one light or two.
pub(super) struct ChurchWindow<'a> {
    /// Its wall.
    pub frame: WallFrame,
    /// x of its axis, m.
    pub centre: f64,
    /// Height of the sill, m.
    pub sill: f64,
    /// Height of the springing, m.
    pub spring: f64,
    /// Its head.
    pub head: PointedArch,
    /// One light or two.
    pub lights: usize,
    /// Side of a cell of glass, m.
    pub cell: f64,
    /// True with cames and saddle bars.
    pub leaded: bool,
    /// Hues.
    pub scheme: &'a GlassScheme,
}

/// Half the breadth of a mullion, m.
const MULLION_HALF_WIDTH: f64 = 0.055;

impl ChurchWindow<'_> {
    /// The opening that the wall leaves.
    pub(super) fn opening(&self) -> WallOpening {
        WallOpening::Pointed { centre: self.centre, sill: self.sill, spring: self.spring, head: self.head }
    }

    /// Adds reveals, tracery, glass and bars.
    pub(super) fn build(&self, m: &mut ChurchModel) {
        let outline = self.opening().outline();
        reveal(m, &self.frame, &self.opening(), &REVEAL_DEPTHS);
        if self.lights == 1 {
            self.glaze(m, &outline, self.centre, self.sill, self.head.half);
            return self.saddles(m, self.centre, self.head.half);
        }
        let half = 0.5 * (self.head.half - MULLION_HALF_WIDTH);
        let sub = PointedArch::new(half, 1.55 * half, self.head.pieces);
        let (lift, radius) = (0.6 * self.head.rise, 0.26 * self.head.rise);
        let sides = 4 * self.head.pieces;
        let oculus = WallOpening::Round { centre: self.centre, height: self.spring + lift, radius, sides };
        let centres = [-1.0, 1.0].map(|s| self.centre + s * (MULLION_HALF_WIDTH + half));
        let light =
            |c: f64| WallOpening::Pointed { centre: c, sill: self.sill, spring: self.spring, head: sub };
        let regions = [light(centres[0]).outline(), light(centres[1]).outline(), oculus.outline()];
        let mut stone = vec![outline];
        for r in &regions {
            stone = stone.iter().flat_map(|p| difference(p, r)).collect();
        }
        for piece in &stone {
            let corners: Vec<_> = piece.iter().map(|p| self.frame.at(p[0], p[1], GLASS_DEPTH)).collect();
            m.polygon(ChurchMaterial::Dressed, &corners, corners[0] + self.frame.inward);
        }
        self.tracery(m, &centres, sub, lift, radius);
        for (r, c) in regions.iter().zip(&centres) {
            self.glaze(m, r, *c, self.sill, half);
            self.saddles(m, *c, half);
        }
        self.wheel(m, lift, radius);
    }

    fn tracery(&self, m: &mut ChurchModel, centres: &[f64; 2], sub: PointedArch, lift: f64, radius: f64) {
        let thick = section(0.085, MULLION_HALF_WIDTH);
        let top = self.spring + lift - radius;
        bar(
            m,
            &self.frame,
            &[[self.centre, self.sill], [self.centre, top]],
            ChurchMaterial::Dressed,
            GLASS_DEPTH,
            &thick,
        );
        for c in centres {
            let line: Vec<Point2> = sub.points().into_iter().map(|[x, z]| [c + x, self.spring + z]).collect();
            bar(m, &self.frame, &line, ChurchMaterial::Dressed, GLASS_DEPTH, &section(0.07, 0.04));
        }
        let middle = [self.centre, self.spring + lift];
        ring(m, &self.frame, middle, radius, 4 * self.head.pieces, &section(0.075, 0.045));
    }

    fn saddles(&self, m: &mut ChurchModel, centre: f64, half: f64) {
        if !self.leaded {
            return;
        }
        let count = ((self.spring - self.sill) / 0.9).round().max(1.0) as usize;
        for k in 1..=count {
            let z = self.sill + (self.spring - self.sill) * k as f64 / count as f64;
            let line = [[centre - half, z], [centre + half, z]];
            bar(m, &self.frame, &line, ChurchMaterial::Iron, GLASS_DEPTH - 0.03, &section(0.012, 0.012));
        }
    }

    /// A grid of cells: a border column on each side, an odd number between.
    fn glaze(&self, m: &mut ChurchModel, region: &[Point2], centre: f64, foot: f64, half: f64) {
        let border = 0.5 * self.cell;
        let inner = 2.0 * (half - border);
        let fields = (((inner / self.cell - 1.0) * 0.5).round().max(0.0) as usize) * 2 + 1;
        let mut xs: Vec<f64> = vec![centre - half];
        xs.extend((0..=fields).map(|k| centre - half + border + inner * k as f64 / fields as f64));
        xs.push(centre + half);
        let top = region.iter().fold(foot, |t, p| t.max(p[1]));
        let rows = ((top - foot) / self.cell).round().max(1.0) as usize;
        let zs: Vec<f64> = (0..=rows).map(|k| foot + (top - foot) * k as f64 / rows as f64).collect();
        for row in 0..rows {
            for column in 0..fields + 2 {
                let (a, b) = ([xs[column], zs[row]], [xs[column + 1], zs[row + 1]]);
                let cell = intersection(&[a, [b[0], a[1]], b, [a[0], b[1]]], region);
                if !cell.is_empty() {
                    self.pane(m, &cell, self.hue(row, column, fields));
                }
            }
        }
        for x in &xs[1..=fields + 1] {
            self.came(m, region, [*x, foot - 1.0], [*x, top + 1.0]);
        }
        for z in &zs[1..rows] {
            self.came(m, region, [centre - half - 1.0, *z], [centre + half + 1.0, *z]);
        }
    }

    fn hue(&self, row: usize, column: usize, fields: usize) -> usize {
        let s = self.scheme;
        if column == 0 || column == fields + 1 {
            return s.border[row % 2];
        }
        let (across, up) = (column as isize - 1 - (fields / 2) as isize, row as isize % 6 - 3);
        let reach = across.abs() + up.abs();
        match reach {
            0 => s.medallion[0],
            1 => s.medallion[1],
            _ => s.ground[(row + column) % 2],
        }
    }

    fn pane(&self, m: &mut ChurchModel, cell: &[Point2], hue: usize) {
        let corners: Vec<_> = cell.iter().map(|p| self.frame.at(p[0], p[1], GLASS_DEPTH)).collect();
        m.polygon(ChurchMaterial::Glass(hue), &corners, corners[0] + self.frame.inward);
    }

    fn came(&self, m: &mut ChurchModel, region: &[Point2], a: Point2, b: Point2) {
        match clip_segment(region, a, b) {
            Some((p, q)) if self.leaded => came(m, &self.frame, p, q),
            _ => {}
        }
    }

    /// The oculus: a ring of wedges about a disc.
    fn wheel(&self, m: &mut ChurchModel, lift: f64, radius: f64) {
        let s = self.scheme;
        let wheel = GlassWheel {
            centre: [self.centre, self.spring + lift],
            radii: &[0.0, 0.42 * radius, radius],
            wedges: 8,
            pieces: self.head.pieces.div_ceil(2),
            leaded: self.leaded,
        };
        wheel.build(m, &self.frame, |ring, k| match ring {
            0 => s.medallion[0],
            _ => [s.border[0], s.ground[0]][k % 2],
        });
    }
}

/// A strip of lead on both sides of the line from `p` to `q`, before the glass.
fn came(m: &mut ChurchModel, frame: &WallFrame, p: Point2, q: Point2) {
    let length = ((q[0] - p[0]).powi(2) + (q[1] - p[1]).powi(2)).sqrt();
    if length < 0.04 {
        return;
    }
    let (dx, dz) = (
        (q[0] - p[0]) / length * CAME_HALF_WIDTH_AND_OFFSET.0,
        (q[1] - p[1]) / length * CAME_HALF_WIDTH_AND_OFFSET.0,
    );
    let corner = |p: Point2, s: f64| {
        frame.at(p[0] - s * dz, p[1] + s * dx, GLASS_DEPTH - CAME_HALF_WIDTH_AND_OFFSET.1)
    };
    let strip = [corner(p, -1.0), corner(q, -1.0), corner(q, 1.0), corner(p, 1.0)];
    m.polygon(ChurchMaterial::Iron, &strip, strip[0] + frame.inward);
}

/// Glass in rings about a centre, each divided into wedges.
struct GlassWheel<'a> {
    /// Centre in the wall.
    centre: Point2,
    /// Radii of the circles that bound the rings, m.
    radii: &'a [f64],
    /// Number of wedges of a ring.
    wedges: usize,
    /// Number of straight pieces of the arc of a wedge.
    pieces: usize,
    /// True with cames.
    leaded: bool,
}

impl GlassWheel<'_> {
    /// Adds the wheel; `hue` of ring and wedge.
    fn build(&self, m: &mut ChurchModel, frame: &WallFrame, hue: impl Fn(usize, usize) -> usize) {
        let at = |r: f64, k: f64| {
            let (sin, cos) = (TAU * k / self.wedges as f64).sin_cos();
            [self.centre[0] + r * cos, self.centre[1] + r * sin]
        };
        for (ring, r) in self.radii.windows(2).enumerate() {
            for k in 0..self.wedges {
                for part in 0..self.pieces {
                    let (a, b) = (
                        k as f64 + part as f64 / self.pieces as f64,
                        k as f64 + (part + 1) as f64 / self.pieces as f64,
                    );
                    let mut cell = vec![at(r[0], a), at(r[1], a), at(r[1], b)];
                    if r[0] > 0.0 {
                        cell.push(at(r[0], b));
                    }
                    let corners: Vec<_> = cell.iter().map(|p| frame.at(p[0], p[1], GLASS_DEPTH)).collect();
                    m.polygon(ChurchMaterial::Glass(hue(ring, k)), &corners, corners[0] + frame.inward);
                }
                if r[0] > 0.0 && self.leaded {
                    came(m, frame, at(r[0], k as f64), at(r[1], k as f64));
                    (0..self.pieces).for_each(|j| {
                        let (a, b) = (
                            k as f64 + j as f64 / self.pieces as f64,
                            k as f64 + (j + 1) as f64 / self.pieces as f64,
                        );
                        came(m, frame, at(r[0], a), at(r[0], b));
                    });
                }
            }
        }
    }
}

/// The rose: petals about a hub, small circles outside.
pub(super) fn rose(m: &mut ChurchModel, frame: &WallFrame, opening: &WallOpening, plan: &ChurchPlan) {
    let WallOpening::Round { centre, height, radius, sides } = *opening else {
        return;
    };
    let leaded = plan.fine;
    reveal(m, frame, opening, &REVEAL_DEPTHS);
    let (c, petals) = ([centre, height], if leaded { 12 } else { 6 });
    let shares: &[f64] = if leaded {
        &[0.0, 0.11, 0.22, 0.36, 0.50, 0.64, 0.76, 0.88, 1.02]
    } else {
        &[0.0, 0.22, 0.43, 0.64, 0.83, 1.02]
    };
    let radii: Vec<f64> = shares.iter().map(|r| r * radius).collect();
    let ground = [RUBY, COBALT, AMBER, AZURE];
    let wheel = GlassWheel { centre: c, radii: &radii, wedges: 2 * petals, pieces: 2, leaded };
    wheel.build(m, frame, |ring, k| match ring {
        0 => GOLD,
        1 => [RUBY, GOLD][k % 2],
        2 | 3 => ground[(k / 2 + ring) % 4],
        4 => [ROSE, TURQUOISE][k / 2 % 2],
        5 => [VIOLET, EMERALD][k % 2],
        6 => [COBALT, COLOURLESS][k % 2],
        _ => [RUBY, EMERALD, GOLD, COBALT][k % 4],
    });
    ring(m, frame, c, 0.22 * radius, sides, &section(0.09, 0.05));
    ring(m, frame, c, 0.64 * radius, sides, &section(0.08, 0.04));
    for k in 0..petals {
        let at = |r: f64, k: f64| {
            let (sin, cos) = (TAU * k / petals as f64).sin_cos();
            [c[0] + r * cos, c[1] + r * sin]
        };
        let spoke = [at(0.22 * radius, k as f64), at(radius, k as f64)];
        bar(m, frame, &spoke, ChurchMaterial::Dressed, GLASS_DEPTH, &section(0.08, 0.04));
        let small = at(0.81 * radius, k as f64 + 0.5);
        ring(m, frame, small, 0.16 * radius, sides / 2, &section(0.06, 0.03));
    }
}
