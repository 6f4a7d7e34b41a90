//! Walls with openings, cut into strips that meet without gaps.
//!
//! A wall stands in a [`WallFrame`]: x along it, z up, its normal into the church. It reaches from a lower to an upper border, both straight
//! between points; an opening is left out by strips beside, below and above it. What meets a border must have the same points, or light
//! comes in between.

use super::arch::PointedArch;
use super::model::{ChurchMaterial, ChurchModel};
use zonal_math::{Vec3, vec3};

/// A vertical plane with axes of its own.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallFrame {
    /// The point x = 0, z = 0, m.
    pub origin: Vec3,
    /// Unit vector along the wall.
    pub along: Vec3,
    /// Unit normal, into the church.
    pub inward: Vec3,
}

impl WallFrame {
    /// A frame whose x runs along `along`; `inward` tells the side.
    pub(super) fn new(origin: Vec3, along: Vec3, inward: Vec3) -> WallFrame {
        WallFrame { origin, along: along.normalized(), inward: inward.normalized() }
    }
    /// The point (x, z), `depth` behind the plane, m.
    pub(super) fn at(&self, x: f64, z: f64, depth: f64) -> Vec3 {
        self.origin + self.along * x + vec3(0.0, 0.0, z) - self.inward * depth
    }
}

/// An opening with a pointed head, or a round one.
#[derive(Clone, Copy, Debug)]
pub(super) enum WallOpening {
    /// Jambs from the sill to the springing, a pointed arch above.
    Pointed {
        /// x of its axis, m.
        centre: f64,
        /// Height of the sill, m.
        sill: f64,
        /// Height of the springing, m.
        spring: f64,
        /// Head.
        head: PointedArch,
    },
    /// A circle.
    Round {
        /// x of the centre, m.
        centre: f64,
        /// Height of the centre, m.
        height: f64,
        /// Radius, m.
        radius: f64,
        /// Sides of the polygon that stands for it.
        sides: usize,
    },
}

impl WallOpening {
    /// x from where to where.
    fn span(&self) -> (f64, f64) {
        match *self {
            WallOpening::Pointed { centre, head, .. } => (centre - head.half, centre + head.half),
            WallOpening::Round { centre, radius, .. } => (centre - radius, centre + radius),
        }
    }
    /// Its outline (x, z), counter-clockwise seen with x to the right, from the lower left.
    pub(super) fn outline(&self) -> Vec<[f64; 2]> {
        match *self {
            WallOpening::Pointed { centre, sill, spring, head } => {
                let mut out = vec![[centre - head.half, sill], [centre + head.half, sill]];
                out.extend(head.points().into_iter().rev().map(|[x, z]| [centre + x, spring + z]));
                out
            }
            WallOpening::Round { centre, height, radius, sides } => (0..sides)
                .map(|k| {
                    let (sin, cos) = (std::f64::consts::TAU * k as f64 / sides as f64).sin_cos();
                    [centre + radius * cos, height + radius * sin]
                })
                .collect(),
        }
    }
    /// Where its lower and upper borders have corners.
    fn corners(&self) -> Vec<f64> {
        let mut xs: Vec<f64> = self.outline().iter().map(|p| p[0]).collect();
        xs.sort_by(f64::total_cmp);
        xs.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        xs
    }
    /// Heights of the outline at `x`, lowest and highest.
    fn heights(&self, x: f64) -> (f64, f64) {
        let outline = self.outline();
        let edges = (0..outline.len()).map(|i| (outline[i], outline[(i + 1) % outline.len()]));
        let mut found = (f64::INFINITY, f64::NEG_INFINITY);
        for (p, q) in edges {
            let (l, r) = if p[0] < q[0] { (p, q) } else { (q, p) };
            if x < l[0] - 1e-9 || x > r[0] + 1e-9 {
                continue;
            }
            let at = |t: f64| l[1] + (r[1] - l[1]) * t.clamp(0.0, 1.0);
            let ends = if r[0] - l[0] < 1e-9 { [l[1], r[1]] } else { [at((x - l[0]) / (r[0] - l[0])); 2] };
            found = (found.0.min(ends[0]).min(ends[1]), found.1.max(ends[0]).max(ends[1]));
        }
        found
    }
}

/// Smallest height of an undivided field, m.
const MIN_FIELD_HEIGHT: f64 = 0.3;

/// A border: straight between points with ascending x.
#[derive(Clone, Debug)]
pub(super) struct BorderLine(pub Vec<[f64; 2]>);

impl BorderLine {
    /// The same height everywhere.
    pub(super) fn level(z: f64) -> BorderLine {
        BorderLine(vec![[0.0, z]])
    }
    /// An arch on its springing line at `z`, with level ends.
    pub(super) fn arch(head: &PointedArch, z: f64) -> BorderLine {
        BorderLine(head.points().into_iter().map(|[x, h]| [x, z + h]).collect())
    }
    fn at(&self, x: f64) -> f64 {
        let k = self.0.partition_point(|p| p[0] <= x);
        match (k.checked_sub(1).map(|i| self.0[i]), self.0.get(k)) {
            (Some(p), Some(q)) => p[1] + (q[1] - p[1]) * (x - p[0]) / (q[0] - p[0]),
            (Some(p), None) => p[1],
            (None, Some(q)) => q[1],
            (None, None) => 0.0,
        }
    }
}

/// A wall between two borders, less an opening.
pub(super) struct WallSection {
    /// Where it stands.
    pub frame: WallFrame,
    /// x of its ends, m.
    pub ends: (f64, f64),
    /// Lower border.
    pub lower: BorderLine,
    /// Upper border.
    pub upper: BorderLine,
    /// The opening, if any.
    pub opening: Option<WallOpening>,
}

impl WallSection {
    /// Adds the wall.
    pub(super) fn build(&self, m: &mut ChurchModel) {
        let (lower, upper) = (|x| self.lower.at(x), |x| self.upper.at(x));
        let Some(o) = self.opening else {
            return self.strips(m, self.ends.0, self.ends.1, &[], &lower, &upper);
        };
        let (a, b) = o.span();
        let own = o.corners();
        self.strips(m, self.ends.0, a, &[], &lower, &upper);
        self.strips(m, b, self.ends.1, &[], &lower, &upper);
        self.strips(m, a, b, &own, &lower, &|x| o.heights(x).0);
        // At its ends an opening with jambs is as high as these.
        let above = |x: f64| o.heights(x.clamp(a + 1e-7, b - 1e-7)).1;
        self.strips(m, a, b, &own, &above, &upper);
    }

    /// From a lower to an upper border over x from `a` to `b`: one field where both allow it, strips below and above it.
    fn strips(
        &self,
        m: &mut ChurchModel,
        a: f64,
        b: f64,
        more: &[f64],
        lower: &dyn Fn(f64) -> f64,
        upper: &dyn Fn(f64) -> f64,
    ) {
        let inside = |x: &f64| *x > a + 1e-6 && *x < b - 1e-6;
        let corners = self.lower.0.iter().chain(&self.upper.0).map(|p| p[0]);
        let mut xs = vec![a, b];
        xs.extend(corners.chain(more.iter().copied()).filter(inside));
        xs.sort_by(f64::total_cmp);
        xs.dedup_by(|x, y| (*x - *y).abs() < 1e-6);
        let highest = xs.iter().fold(f64::NEG_INFINITY, |h, x| h.max(lower(*x)));
        let lowest = xs.iter().fold(f64::INFINITY, |l, x| l.min(upper(*x)));
        if lowest < highest + MIN_FIELD_HEIGHT {
            return self.quads(m, &xs, lower, upper);
        }
        self.quads(m, &xs, lower, &|_| highest);
        self.quads(m, &[a, b], &|_| highest, &|_| lowest);
        self.quads(m, &xs, &|_| lowest, upper);
    }

    fn quads(&self, m: &mut ChurchModel, xs: &[f64], lower: &dyn Fn(f64) -> f64, upper: &dyn Fn(f64) -> f64) {
        for w in xs.windows(2) {
            let at = |x: f64, z: f64| self.frame.at(x, z, 0.0);
            let quad =
                [at(w[0], lower(w[0])), at(w[1], lower(w[1])), at(w[1], upper(w[1])), at(w[0], upper(w[0]))];
            m.polygon(ChurchMaterial::Ashlar, &quad, quad[0] + self.frame.inward);
        }
    }
}

/// Faces of an opening's outline, pushed into the wall in strips between these `depths`, m.
pub(super) fn reveal(m: &mut ChurchModel, frame: &WallFrame, opening: &WallOpening, depths: &[f64]) {
    let outline = opening.outline();
    let n = outline.len();
    let middle = outline.iter().fold([0.0; 2], |s, p| [s[0] + p[0] / n as f64, s[1] + p[1] / n as f64]);
    for i in 0..n {
        let (a, b) = (outline[i], outline[(i + 1) % n]);
        for d in depths.windows(2) {
            let face = [
                frame.at(a[0], a[1], d[0]),
                frame.at(b[0], b[1], d[0]),
                frame.at(b[0], b[1], d[1]),
                frame.at(a[0], a[1], d[1]),
            ];
            m.polygon(ChurchMaterial::Dressed, &face, frame.at(middle[0], middle[1], 0.5 * (d[0] + d[1])));
        }
    }
}
