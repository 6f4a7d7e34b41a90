//! Direct light scattered towards the eye along a ray: ∫ κΩ τ_eye(t) G_dir(t)/(4π) dt.
//!
//! (B = ΩG/4 and κB/π is what a volume sends per length and solid angle.) The lit intervals come from [`crate::shadow`], exact. They are
//! cut again at voxel borders and at evenly spaced nodes, at which the optical depth D towards the light is known; between
//! nodes D is linear. On such a part both transmittances are exponentials of t, and for a distant light of fluence G
//!
//! ```text
//! ∫_a^b κΩ τ_a G e^{−D_a} e^{−x (t−a)/(b−a)} dt = κΩ (b−a) τ_a G e^{−D_a} (1 − e^{−x})/x,   x = κ(b−a) + D_b − D_a
//! ```
//!
//! For a point of an emitter at distance δ from the ray's line, nearest at t_c, dt/r² = dθ/δ with t = t_c + δ tanθ (equiangular): the 1/r²
//! is integrated exactly and the rest, smooth in θ, taken at the middle of steps of at most 0.3 rad; what is linear between nodes
//! is then D/r. For evenly emitting lamps of few facets see [`crate::lamplight`], which does not jump with the choice of point.

use crate::path::{Path, Piece, mean_exp};
use crate::shadow::{Lit, Shadows};
use crate::towards::Towards;
use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_scene::{Bands, Scene, bands};
use zonal_transport::Transport;
use zonal_transport::direct::Source;

const MAX_ANGLE: f64 = 0.3;
/// The angle between the directions to two points of a line at `x` and `y` > `x` from the foot of the perpendicular `delta`, rad.
fn angle_between(x: f64, y: f64, delta: f64) -> f64 {
    let (sin, cos) = (delta * (y - x), delta * delta + x * y);
    if cos > 0.0 && sin < 0.05 * cos {
        let t = sin / cos;
        t * (1.0 - t * t * (1.0 / 3.0 - t * t * 0.2))
    } else {
        sin.atan2(cos)
    }
}

const MAX_NODES: usize = 48;

/// What the shafts need to know of the scene.
pub(crate) struct Shafts<'a> {
    pub scene: &'a Scene,
    pub transport: &'a Transport<'a>,
    pub shadows: Shadows,
    /// Spacing of the nodes, m.
    pub step: f64,
}

/// One light sample and one ray.
pub(crate) struct Beam<'a> {
    shafts: &'a Shafts<'a>,
    origin: Vec3,
    dir: Vec3,
    source: &'a Source,
    /// Depths towards a distant source, where they are kept.
    towards: Option<&'a Towards<'a>>,
    lo: f64,
    step: f64,
    nodes: Vec<Option<Bands>>,
}

impl Shafts<'_> {
    /// Radiance, W/(m² sr), that one light sample adds along the path; `towards` knows depths in the direction of a distant one.
    pub(crate) fn scattered(
        &self,
        (origin, dir): (Vec3, Vec3),
        path: &Path,
        source: &Source,
        towards: Option<&Towards>,
    ) -> Bands {
        let mut out = [0.0; 3];
        let Some((lo, hi)) = path.scattering() else {
            return out;
        };
        let lit = self.shadows.lit(origin, dir, source, lo, hi);
        if lit.intervals.is_empty() {
            return out;
        }
        let mut beam = self.beam((origin, dir), source, towards, (lo, hi));
        let mut cuts = Vec::new();
        for &(a, b) in &lit.intervals {
            cuts.clear();
            cuts.extend([a, b]);
            cuts.extend(lit.tints.iter().flat_map(|t| [t.0, t.1]).filter(|t| *t > a && *t < b));
            cuts.sort_by(f64::total_cmp);
            for pair in cuts.windows(2) {
                beam.add(path, &lit, pair[0], pair[1], &mut out);
            }
        }
        out
    }

    /// A light sample along lo..hi, no depth known yet.
    pub(crate) fn beam<'a>(
        &'a self,
        (origin, dir): (Vec3, Vec3),
        source: &'a Source,
        towards: Option<&'a Towards<'a>>,
        (lo, hi): (f64, f64),
    ) -> Beam<'a> {
        let count = (((hi - lo) / self.step).ceil() as usize).clamp(4, MAX_NODES);
        Beam {
            shafts: self,
            origin,
            dir,
            source,
            towards,
            lo,
            step: (hi - lo) / count as f64,
            nodes: vec![None; count + 1],
        }
    }
}

impl Beam<'_> {
    /// What the medium between the ray at `t` and a point of an emitter lets pass over `distance`.
    pub(crate) fn arriving(&mut self, t: f64, distance: f64) -> Bands {
        self.depth(self.interval(t), t).map(|d| (-d * distance).exp())
    }

    /// Adds the lit interval a..b, behind the same panes all along.
    fn add(&mut self, path: &Path, lit: &Lit, a: f64, b: f64, out: &mut Bands) {
        let tints = lit.panes_at(0.5 * (a + b));
        self.parts(path, a, b, |beam, piece, k, t, next| beam.part(piece, &tints, k, t, next, out));
    }

    /// Adds a..b of a distant light with the same tint all along.
    pub(crate) fn add_tinted(&mut self, path: &Path, tint: Bands, a: f64, b: f64, out: &mut Bands) {
        self.parts(path, a, b, |beam, piece, k, t, next| beam.distant(piece, tint, k, t, next, out));
    }

    /// The parts of a..b that scatter, each within one piece and between the nodes k, k + 1.
    fn parts(
        &mut self,
        path: &Path,
        a: f64,
        b: f64,
        mut each: impl FnMut(&mut Self, &Piece, usize, f64, f64),
    ) {
        let first = path.pieces.partition_point(|p| p.t1 <= a);
        for piece in path.pieces[first..].iter().take_while(|p| p.t0 < b) {
            if piece.scatter == [0.0; 3] {
                continue;
            }
            let (mut t, end) = (piece.t0.max(a), piece.t1.min(b));
            while t < end {
                let k = self.interval(t);
                let border = self.lo + (k + 1) as f64 * self.step;
                let next = if k + 2 >= self.nodes.len() || border >= end { end } else { border };
                if next > t {
                    each(self, piece, k, t, next);
                }
                t = if next > t { next } else { end };
            }
        }
    }

    /// A part of a piece between two nodes.
    fn distant(&mut self, piece: &Piece, tint: Bands, k: usize, a: f64, b: f64, out: &mut Bands) {
        let Source::Distant { fluence, .. } = *self.source else {
            return;
        };
        let (da, db, tau) = (self.depth(k, a), self.depth(k, b), piece.tau_at(a));
        for i in 0..3 {
            let x = piece.kappa[i] * (b - a) + db[i] - da[i];
            // From the end that is less deep: e^{−x} may be more than a number can hold.
            let least = da[i] + x.min(0.0);
            let light = fluence[i] * tint[i] * (-least).exp() / (4.0 * PI);
            out[i] += piece.scatter[i] * (b - a) * tau[i] * light * mean_exp(x.abs());
        }
    }

    fn interval(&self, t: f64) -> usize {
        (((t - self.lo) / self.step * (1.0 + 1e-12) + 1e-9) as usize).min(self.nodes.len() - 2)
    }

    /// Depth of the medium from the node towards the light; for a point of an emitter per metre, which stays smooth near it.
    fn node(&mut self, k: usize) -> Bands {
        if let Some(d) = self.nodes[k] {
            return d;
        }
        let x = self.origin + self.dir * (self.lo + k as f64 * self.step);
        let d = match *self.source {
            Source::Distant { towards, .. } => {
                if let Some(known) = self.towards {
                    let d = known.depth(x);
                    self.nodes[k] = Some(d);
                    return d;
                }
                let end = self.shafts.transport.beyond(x, towards);
                self.shafts.transport.medium_depth(x, end)
            }
            Source::Point { at, .. } => {
                let r = (at - x).length().max(1e-12);
                self.shafts.transport.medium_depth(x, at).map(|d| d / r)
            }
        };
        self.nodes[k] = Some(d);
        d
    }

    /// What [`Beam::node`] gives, at t in the interval of nodes k, k + 1.
    fn depth(&mut self, k: usize, t: f64) -> Bands {
        let (p, q) = (self.node(k), self.node(k + 1));
        let f = (t - self.lo) / self.step - k as f64;
        bands(|b| p[b] + f * (q[b] - p[b]))
    }

    /// What panes let pass of light from the unit direction `towards`.
    pub(crate) fn tint(&self, tints: &[(u32, Vec3)], towards: Vec3) -> Bands {
        let mut depth = [0.0; 3];
        for (pane, normal) in tints {
            let p = &self.shafts.scene.panes()[*pane as usize];
            let slant = p.thickness / normal.dot(towards).abs().max(1e-9);
            (0..3).for_each(|b| depth[b] += p.extinction[b] * slant);
        }
        depth.map(|d| (-d).exp())
    }

    fn part(&mut self, piece: &Piece, tints: &[(u32, Vec3)], k: usize, a: f64, b: f64, out: &mut Bands) {
        match *self.source {
            Source::Distant { towards, .. } => {
                let tint = self.tint(tints, towards);
                self.distant(piece, tint, k, a, b, out);
            }
            Source::Point { at, normal, both, power, .. } => {
                let centre = (at - self.origin).dot(self.dir);
                let delta = (self.origin + self.dir * centre - at).length().max(1e-6 * self.step);
                let span = angle_between(a - centre, b - centre, delta);
                let n = (span / MAX_ANGLE).ceil().max(1.0) as usize;
                let start = if n > 1 { ((a - centre) / delta).atan() } else { 0.0 };
                for j in 0..n {
                    let t = if n > 1 {
                        let theta = start + span * (j as f64 + 0.5) / n as f64;
                        (centre + delta * theta.tan()).clamp(a, b)
                    } else {
                        0.5 * (a + b)
                    };
                    let way = at - self.origin - self.dir * t;
                    let (r, towards) = (way.length(), way.normalized());
                    let slope = -normal.dot(towards);
                    let leaving = if both { slope.abs() } else { slope.max(0.0) };
                    if leaving == 0.0 {
                        continue;
                    }
                    let (tau, d, tint) = (piece.tau_at(t), self.depth(k, t), self.tint(tints, towards));
                    let weight = leaving * span / (n as f64 * delta) / (4.0 * PI);
                    for i in 0..3 {
                        out[i] += piece.scatter[i] * tau[i] * power[i] * weight * tint[i] * (-d[i] * r).exp();
                    }
                }
            }
        }
    }
}
