//! What pairs may hide whose rays all agree.
//!
//! Facets reach into the hulls of many pairs that are seen in full: where a wall leans by a hair, or a lamp hangs a hair below a ceiling. Of the
//! pairs of a scene that facets may divide, a sample is looked at with the first rays. M of them are seen in part; were the
//! shares of these uniform, then for each that n rays find mixed, (n + 1)/(n − 1) would be partly seen and 1/(n − 1) look free, and as many
//! hidden. So of U pairs that look free the share
//!
//! ```text
//! q = Σ_mixed 1/(n − 1) / U
//! ```
//!
//! is seen in part in truth, each with the missed share of the rule of succession, and √q times that is the standard deviation of what such
//! a pair hides.

use super::Exchange;
use super::rays::{FIRST_RAYS, MORE_RAYS, Points, SUCCESSION, kernel};
use super::zone::{Shape, Zone, behind, is_close};
use zonal_math::{Vec3, sequence, vec3};

/// Pairs of a kind that are looked at, at most.
const LOOKS: usize = 1024;
/// Pairs that are drawn for that, at most; fewer where zones are few.
const DRAWS: usize = 1 << 16;

/// √q of pairs that look free and of pairs that look hidden, for zones apart and for close ones.
#[derive(Clone, Copy, Debug)]
pub(super) struct Agreement([[f64; 2]; 2]);

impl Default for Agreement {
    fn default() -> Agreement {
        Agreement([[1.0; 2]; 2])
    }
}

impl Agreement {
    /// √q of a pair.
    pub(super) fn doubt(&self, a: &Zone, b: &Zone, blocked: bool) -> f64 {
        self.0[is_close(a, b) as usize][blocked as usize]
    }
}

/// What the looks at one kind of pairs found.
#[derive(Clone, Copy, Default)]
struct Found {
    looks: usize,
    /// Pairs that look free, and those that look hidden.
    agreed: [f64; 2],
    /// Σ 1/(n − 1) of the mixed ones.
    overlooked: f64,
}

impl Found {
    fn doubts(&self) -> [f64; 2] {
        // One more on both sides: with nothing found, q is 1.
        self.agreed.map(|u| ((self.overlooked + 1.0) / (u + 1.0)).min(1.0).sqrt())
    }
}

impl Exchange<'_> {
    /// Looks at a sample of pairs.
    pub(super) fn agreement(&self) -> Agreement {
        if !self.occluders {
            return Agreement::default();
        }
        let (n, mut found) = (self.zones.len(), [Found::default(); 2]);
        let draw = |k: usize| (sequence::hash(self.settings.seed(0, k)) % n as u64) as usize;
        for t in 0..DRAWS.min(n * n / 8) {
            let (i, j) = (draw(2 * t), draw(2 * t + 1));
            let (a, b) = (&*self.items.get(i), &*self.items.get(j));
            let kind = &mut found[is_close(a, b) as usize];
            let apart = i != j && !behind(a, b) && !behind(b, a);
            if kind.looks >= LOOKS || !apart || !self.may_divide(a, b) {
                continue;
            }
            kind.looks += 1;
            let first = if is_close(a, b) { MORE_RAYS } else { FIRST_RAYS };
            let [rays, blocked] = self.first_look(a, b, self.settings.seed(i.max(j), i.min(j)), first);
            if blocked > 0 && blocked < rays {
                kind.overlooked += 1.0 / (rays - 1) as f64;
            } else if rays > 0 {
                kind.agreed[(blocked > 0) as usize] += 1.0;
            }
        }
        Agreement(found.map(|f| f.doubts()))
    }

    /// The first rays of a pair and those between its rims: how many, and how many are blocked.
    fn first_look(&self, a: &Zone, b: &Zone, seed: u64, first: usize) -> [u64; 2] {
        let points = Points::new(seed);
        let outer = self.outer_rays(a, b);
        let hidden = |k: &usize| {
            let (x, y) = points.both(a, b, *k);
            self.transport.blocked_inside(x, y)
        };
        [first as u64 + outer.rays, (0..first).filter(hidden).count() as u64 + outer.blocked]
    }

    /// Rays between the rims of two zones. They say whether a pair is seen in part, but do not count: a decision by the rays that
    /// count would take pairs that are hardly seen for hidden, and those that are hardly hidden for seen.
    pub(super) fn outer_rays(&self, a: &Zone, b: &Zone) -> Outer {
        let (p, q) = (rim(a), rim(b));
        let mut out = Outer::default();
        for k in 0..4 {
            for turn in [0, 2] {
                let (x, y) = (p[k], q[(k + turn) % 4]);
                if kernel(a, b, x, y) > 0.0 {
                    out.rays += 1;
                    out.blocked += self.transport.blocked_inside(x, y) as u64;
                }
            }
        }
        out
    }
}

/// What [`Exchange::outer_rays`] saw.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Outer {
    pub rays: u64,
    pub blocked: u64,
}

impl Outer {
    /// True where these rays differ among themselves, or from others that were all `blocked` or all free.
    pub(super) fn disagrees(self, blocked: bool) -> bool {
        self.rays > 0 && self.blocked != if blocked { self.rays } else { 0 }
    }
}

/// The share that `n` rays, all `blocked` or all free, may have missed; the outer rays count where they say the same.
pub(super) fn missed(n: f64, outer: Outer, blocked: bool) -> f64 {
    let more = if outer.disagrees(blocked) { 0 } else { outer.rays };
    1.0 / (n + more as f64 + SUCCESSION)
}

/// Four points near the rim of a plate, or near four corners of a voxel no two of which share an edge; of a cut voxel the samples that
/// lie farthest towards these.
fn rim(z: &Zone) -> [Vec3; 4] {
    const INWARD: f64 = 0.06;
    let at = |x: Vec3| x + (z.centre - x) * INWARD;
    match &z.shape {
        Shape::Plate { plate, .. } => {
            let (c, n) = plate.corners();
            let last = if n == 3 { (c[1] + c[2]) * 0.5 } else { c[3] };
            [at(c[0]), at(c[1]), at(c[2]), at(last)]
        }
        Shape::Cuboid => {
            let (l, h) = (z.lo, z.hi);
            let corners = [l, vec3(h.x, h.y, l.z), vec3(h.x, l.y, h.z), vec3(l.x, h.y, h.z)];
            corners.map(at)
        }
        Shape::Part(samples) => {
            let towards =
                [vec3(1.0, 1.0, 1.0), vec3(1.0, -1.0, -1.0), vec3(-1.0, 1.0, -1.0), vec3(-1.0, -1.0, 1.0)];
            towards.map(|d| {
                let reach = |x: Vec3| (x - z.centre).dot(d);
                let farther = |best: Vec3, x: Vec3| if reach(x) > reach(best) { x } else { best };
                samples.iter().map(|s| s.point).fold(z.centre, farther)
            })
        }
    }
}
