//! Light of a small lamp scattered towards the eye, free of noise beside the lamp.
//!
//! Without obstacles the fluence G(x) of an evenly emitting lamp of few facets is known in closed form; its sampled points say only
//! which share of it arrives:
//!
//! ```text
//! L = ∫ κΩ τ_eye G S/(4π) dt      S(t) = Σ_i v_i e^{−r̄ D_i/r_i} g_i / Σ_i g_i      g_i = |cosθ_i|/r_i²
//! ```
//!
//! D_i is the depth towards point i, r̄ the mean distance of the lamp, weighted with g over a few points a facet: so that in
//! even fog S has neither noise nor the bias that a mean of e^{−D_i} over a few points has. v_i is 1 where point i is seen and
//! the panes' transmittance behind panes: borders of shafts stay as exact as in [`crate::shadow`]. 1/r² cancels, so a ray
//! that passes close by one of the points is no brighter than its neighbour.
//!
//! G (r² + a²), r the distance from the lamp's centre and a its radius, hardly varies far away. The ray is cut into cells, at
//! the planes of the facets and so that none is much longer than half the distance to the lamp; in each this product is a
//! parabola through three Gauss points, and so is r̄². Cells are cut again where medium, visibility or panes change; there
//! G S is linear through two Gauss points, and its integral with τ_eye exact ([`emitted`]).
//!
//! One-sided lamps are taken this way only where all facets lie in one plane: of any other, all sampled points may be turned
//! away from x while others are not, and nothing would be known of the share.

use crate::path::{Path, Piece, emitted};
use crate::shadow::Lit;
use crate::shafts::{Beam, Shafts};
use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_scene::{Bands, Light, Plate, Scene, Sides, bands};
use zonal_transport::direct::{Lamp, Receiver, Source};

/// The outer Gauss points of three on [−1,1].
const OUTER: f64 = 0.774_596_669_241_483_4;
/// Where two Gauss points lie on [0,1].
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];
/// A lamp of more facets is sampled only: the closed form would cost more than the samples.
const MOST_FACETS: usize = 8;
/// Length of a cell over the distance to the lamp.
const CELL: f64 = 0.6;
/// Least length of a cell over the lamp's radius.
const LEAST: f64 = 0.03;
/// Points along each side of a facet for its mean distance from close by.
const CLOSE: usize = 4;
/// A part shorter than this, over the distance to the lamp, takes one point.
const SHORT: f64 = 0.08;

/// A lamp whose unhindered light is known.
#[derive(Clone, Debug)]
pub(crate) struct Even {
    plates: Vec<Plate>,
    centre: Vec3,
    /// Half the diagonal of its bounds, m.
    radius: f64,
    /// Points all over it and the areas they stand for, as vectors, m²: a few and many.
    spots: [Vec<(Vec3, Vec3)>; 2],
}

/// A part of the ray on which the unhindered light is smooth.
struct Cell {
    t0: f64,
    t1: f64,
    /// Distance to the lamp at its start, m.
    distance: f64,
    /// Parabolas of G (r² + a²) and of r̄² over [−1,1], once known.
    light: Option<[[f64; 4]; 3]>,
}

/// A sampled point of the lamp and what of the ray it reaches.
struct Point<'a> {
    at: Vec3,
    normal: Vec3,
    both: bool,
    lit: Lit,
    beam: Beam<'a>,
}

/// One ray and one lamp.
struct Ray<'a> {
    even: &'a Even,
    lamp: &'a Lamp<'a>,
    origin: Vec3,
    dir: Vec3,
    points: Vec<Point<'a>>,
}

impl Even {
    /// `None` for a light that is better sampled.
    pub(crate) fn new(scene: &Scene, lamp: &Lamp) -> Option<Even> {
        let Light::Emitter { surface, .. } = lamp.light() else {
            return None;
        };
        let own = scene.facets().iter().filter(|f| f.surface == *surface);
        let plates: Vec<Plate> = own.map(|f| f.plate).collect();
        let first = *plates.first()?;
        let (lo, hi) = plates.iter().map(Plate::bounds).reduce(|x, y| (x.0.min(y.0), x.1.max(y.1)))?;
        let (centre, radius) = ((lo + hi) * 0.5, 0.5 * (hi - lo).length());
        let normal = first.normal();
        let level = |p: &Plate| {
            let height = (p.centre() - first.centre()).dot(normal).abs();
            normal.dot(p.normal()) > 1.0 - 1e-9 && height < 1e-6 * radius
        };
        let whole = scene.surfaces()[*surface].sides == Sides::Both || plates.iter().all(level);
        let known = lamp.unhindered(first.centre() + normal * radius, Receiver::Free);
        let taken = whole && plates.len() <= MOST_FACETS && known != [0.0; 3];
        let few = GAUSS.iter().flat_map(|u| GAUSS.map(|v| [*u, v]));
        let many =
            (0..CLOSE * CLOSE).map(|i| [i % CLOSE, i / CLOSE].map(|k| (k as f64 + 0.5) / CLOSE as f64));
        let spots = [few.collect::<Vec<_>>(), many.collect()].map(|grid| {
            let spot = |p: &Plate, s: &[f64; 2]| {
                let [u, v] = p.warp(*s);
                (p.at(u, v), p.normal() * (p.area() / grid.len() as f64))
            };
            plates.iter().flat_map(|p| grid.iter().map(move |s| spot(p, s))).collect()
        });
        taken.then_some(Even { plates, centre, radius, spots })
    }

    /// Radiance, W/(m² sr), that the lamp adds along the path, from a few of its points.
    pub(crate) fn scattered(
        &self,
        shafts: &Shafts,
        lamp: &Lamp,
        (origin, dir): (Vec3, Vec3),
        path: &Path,
        sources: &[Source],
    ) -> Bands {
        let mut out = [0.0; 3];
        let Some((lo, hi)) = path.scattering() else {
            return out;
        };
        let points: Vec<Point> = sources
            .iter()
            .filter_map(|source| match *source {
                Source::Point { at, normal, both, .. } => Some(Point {
                    at,
                    normal,
                    both,
                    lit: shafts.shadows.lit(origin, dir, source, lo, hi),
                    beam: shafts.beam((origin, dir), source, None, (lo, hi)),
                }),
                Source::Distant { .. } => None,
            })
            .collect();
        if points.iter().all(|p| p.lit.intervals.is_empty()) {
            return out;
        }
        let mut cuts = vec![lo, hi];
        for p in &points {
            cuts.extend(p.lit.intervals.iter().flat_map(|i| [i.0, i.1]));
            cuts.extend(p.lit.tints.iter().flat_map(|i| [i.0, i.1]));
        }
        cuts.sort_by(f64::total_cmp);
        let mut cells = self.cells(origin, dir, lo, hi);
        let mut ray = Ray { even: self, lamp, origin, dir, points };
        let (mut c, mut k) = (0, 0);
        for piece in path.pieces.iter().filter(|p| p.scatter != [0.0; 3]) {
            let mut t = piece.t0;
            while t < piece.t1 {
                while c + 1 < cells.len() && cells[c].t1 <= t {
                    c += 1;
                }
                while k < cuts.len() && cuts[k] <= t {
                    k += 1;
                }
                let border = cells[c].t1.min(cuts.get(k).copied().unwrap_or(hi));
                let next = if border > t { border.min(piece.t1) } else { piece.t1 };
                ray.part(piece, &mut cells[c], t, next, &mut out);
                t = next;
            }
        }
        out
    }

    /// lo..hi in cells.
    fn cells(&self, origin: Vec3, dir: Vec3, lo: f64, hi: f64) -> Vec<Cell> {
        let crossing = |p: &Plate| (p.origin - origin).dot(p.normal()) / dir.dot(p.normal());
        let mut planes: Vec<f64> = self.plates.iter().map(crossing).collect();
        planes.retain(|t| *t > lo && *t < hi);
        planes.push(hi);
        planes.sort_by(f64::total_cmp);
        let mut cells = Vec::new();
        let mut t0 = lo;
        for end in planes {
            while t0 < end {
                let distance = self.distance(origin + dir * t0);
                let length = (CELL * distance).max(LEAST * self.radius).max(1e-6 * (hi - lo));
                let t1 = if t0 + 1.3 * length < end { t0 + length } else { end };
                let light = None;
                cells.push(Cell { t0, t1, distance, light });
                t0 = t1;
            }
        }
        cells
    }

    /// About the distance to the nearest facet, m.
    fn distance(&self, x: Vec3) -> f64 {
        let to = |p: &Plate| {
            let [u, v] = p.parameters(x).map(|s| s.clamp(0.0, 1.0));
            (p.at(u, v) - x).length()
        };
        self.plates.iter().map(to).fold(f64::INFINITY, f64::min)
    }

    /// r̄², the square of the lamp's mean distance.
    fn mean_distance2(&self, x: Vec3, close: bool) -> f64 {
        let (mut sum, mut weight) = (0.0, 0.0);
        for (at, area) in &self.spots[usize::from(close)] {
            let way = x - *at;
            let r2 = way.length2() + 1e-4 * area.length();
            let w = way.dot(*area).abs() / r2;
            (sum, weight) = (sum + w, weight + w / r2.sqrt());
        }
        let mean = if weight > 0.0 { sum / weight } else { (x - self.centre).length() };
        mean * mean
    }

    /// r² + a².
    fn spread(&self, x: Vec3) -> f64 {
        (x - self.centre).length2() + self.radius * self.radius
    }
}

impl Ray<'_> {
    /// Adds a..b of a piece, inside one cell and between two cuts.
    fn part(&mut self, piece: &Piece, cell: &mut Cell, a: f64, b: f64, out: &mut Bands) {
        let middle = 0.5 * (a + b);
        let x = self.origin + self.dir * middle;
        let behind = |p: &Point| !p.both && p.normal.dot(x - p.at) <= 0.0;
        if self.points.iter().all(behind) {
            return;
        }
        let seen: Vec<Option<Vec<(u32, Vec3)>>> =
            self.points.iter().map(|p| p.lit.at(middle).then(|| p.lit.panes_at(middle))).collect();
        if seen.iter().all(Option::is_none) {
            return;
        }
        let length = b - a;
        let (start, slope) = if length < SHORT * cell.distance {
            (self.light(cell, &seen, middle), [0.0; 3])
        } else {
            let [p, q] = GAUSS.map(|g| self.light(cell, &seen, a + g * length));
            let slope = bands(|i| (q[i] - p[i]) / ((GAUSS[1] - GAUSS[0]) * length));
            (bands(|i| (p[i] - slope[i] * GAUSS[0] * length).max(0.0)), slope)
        };
        let tau = if a > piece.t0 { piece.tau_at(a) } else { piece.tau };
        for i in (0..3).filter(|&i| piece.scatter[i] > 0.0) {
            let albedo = piece.scatter[i] / piece.kappa[i];
            out[i] += tau[i] * albedo * emitted(piece.kappa[i], length, start[i], slope[i]) / (4.0 * PI);
        }
    }

    /// G S at `t`, W/m².
    fn light(&mut self, cell: &mut Cell, seen: &[Option<Vec<(u32, Vec3)>>], t: f64) -> Bands {
        let x = self.origin + self.dir * t;
        let (all, distance) = self.unhindered(cell, t, x);
        let (mut sent, mut arrived) = (0.0, [0.0; 3]);
        for (p, panes) in self.points.iter_mut().zip(seen) {
            let way = p.at - x;
            let r2 = way.length2().max(1e-24);
            let slope = -p.normal.dot(way);
            let leaving = if p.both { slope.abs() } else { slope.max(0.0) };
            let share = leaving / (r2 * r2.sqrt());
            sent += share;
            if let Some(panes) = panes.as_ref().filter(|_| share > 0.0) {
                let mut passed = p.beam.arriving(t, distance);
                if !panes.is_empty() {
                    let tint = p.beam.tint(panes, way.normalized());
                    passed = bands(|b| passed[b] * tint[b]);
                }
                arrived = bands(|b| arrived[b] + share * passed[b]);
            }
        }
        if sent > 0.0 { bands(|b| all[b] * arrived[b] / sent) } else { [0.0; 3] }
    }

    /// G at `t`, W/m², with nothing between, and r̄, m.
    fn unhindered(&self, cell: &mut Cell, t: f64, x: Vec3) -> (Bands, f64) {
        let (middle, half) = (0.5 * (cell.t0 + cell.t1), 0.5 * (cell.t1 - cell.t0));
        let distance = cell.distance;
        let [constant, linear, square] = *cell.light.get_or_insert_with(|| {
            let [p, q, r] = [-OUTER, 0.0, OUTER].map(|s| {
                let x = self.origin + self.dir * (middle + s * half);
                let spread = self.even.spread(x);
                let [red, green, blue] = self.lamp.unhindered(x, Receiver::Free).map(|g| g * spread);
                [red, green, blue, self.even.mean_distance2(x, distance < self.even.radius)]
            });
            let k = [0, 1, 2, 3];
            let linear = k.map(|k| (r[k] - p[k]) / (2.0 * OUTER));
            let square = k.map(|k| (r[k] - 2.0 * q[k] + p[k]) / (2.0 * OUTER * OUTER));
            [q, linear, square]
        });
        let s = (t - middle) / half;
        let at = |k: usize| (constant[k] + s * (linear[k] + s * square[k])).max(0.0);
        let spread = self.even.spread(x);
        (bands(|b| at(b) / spread), at(3).sqrt())
    }
}
