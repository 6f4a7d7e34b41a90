//! Single scattering: direct light of one light sample scattered towards the eye along a ray, ∫ κΩ τ_eye(t) G_dir(t)/(4π) dt.
//!
//! (B = ΩG/4, and κB/π is the radiance that a volume sends per length.) The lit intervals come from [`crate::lights::lit_intervals`],
//! exact. They are cut again at voxel borders and at equally spaced nodes, at which the optical depth D towards the light is computed;
//! between nodes D is linear. On such a part both transmittances are exponentials of t, and for a distant light of fluence G
//!
//! ```text
//! ∫_a^b κΩ τ_a G e^{−D_a} e^{−x (t−a)/(b−a)} dt = κΩ (b−a) τ_a G e^{−D_a} (1 − e^{−x})/x,   x = κ(b−a) + D_b − D_a
//! ```
//!
//! For a point of an emitter, or a point light, at the distance δ from the ray's line, nearest at t_c, dt/r² = dθ/δ with t = t_c + δ tanθ (equiangular
//! sampling: Kulla & Fajardo, EGSR 2012). The factor 1/r² is integrated exactly and the rest, smooth in θ, by the midpoint rule in
//! steps of at most 0.3 rad, and of a quarter of the angle over which the intensity of a point light changes; D/r is linear between nodes then. Emitters of few facets: see [`super::analytic_area_light`],
//! which does not depend on the choice of the point. Cost: one depth a node and light sample, one exponential a part.

use super::ray_path::{RayPath, VoxelSegment, mean_exp};
use crate::lights::lit_intervals::{LitIntervals, ShadowCasters};
use crate::lights::sun_depth_cache::SunDepthCache;
use crate::view_ray::ViewRay;
use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_scene::{Bands, Scene};
use zonal_transport::Transport;
use zonal_transport::lights::EmissionSample;

/// Largest step of the equiangular midpoint rule, rad.
const MAX_EQUIANGULAR_STEP: f64 = 0.3;
/// Least and largest number of intervals between the nodes of optical depth along a ray.
const DEPTH_INTERVALS: (usize, usize) = (4, 48);

/// Steps over which the intensity of a point light changes, and the smallest of them, rad.
const STEPS_OVER_RESOLUTION: f64 = 4.0;
const MIN_EQUIANGULAR_STEP: f64 = 0.01;

/// Largest step of the equiangular midpoint rule for a light, rad.
fn max_equiangular_step(source: &EmissionSample) -> f64 {
    match source {
        EmissionSample::Intensity { distribution, .. } => (distribution.angular_resolution()
            / STEPS_OVER_RESOLUTION)
            .clamp(MIN_EQUIANGULAR_STEP, MAX_EQUIANGULAR_STEP),
        EmissionSample::Point { .. } | EmissionSample::Distant { .. } => MAX_EQUIANGULAR_STEP,
    }
}

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

/// Scene data for single scattering.
pub(crate) struct SingleScattering<'a> {
    pub scene: &'a Scene,
    pub transport: &'a Transport<'a>,
    pub casters: ShadowCasters,
    /// Spacing of the nodes of optical depth, m.
    pub node_spacing: f64,
}

/// One light sample along one ray, with the optical depths towards it at the nodes.
pub(crate) struct SampleAlongRay<'a> {
    scattering: &'a SingleScattering<'a>,
    ray: ViewRay,
    source: &'a EmissionSample<'a>,
    /// Cached depths towards a distant source.
    sun_depths: Option<&'a SunDepthCache<'a>>,
    lo: f64,
    step: f64,
    nodes: Vec<Option<Bands>>,
    /// Largest step of the equiangular midpoint rule, rad.
    max_step: f64,
}

/// A part of a ray inside one voxel segment and between the nodes `node` and `node` + 1.
struct NodePart<'p> {
    segment: &'p VoxelSegment,
    node: usize,
    /// The part, m along the ray.
    a: f64,
    b: f64,
}

impl SingleScattering<'_> {
    /// Radiance, W/(m² sr), that one light sample adds along the path; `sun_depths` has the depths towards a distant one.
    pub(crate) fn inscattered(
        &self,
        ray: ViewRay,
        path: &RayPath,
        source: &EmissionSample,
        sun_depths: Option<&SunDepthCache>,
    ) -> Bands {
        let mut out = Bands::ZERO;
        let Some((lo, hi)) = path.scattering_range() else {
            return out;
        };
        let lit = self.casters.lit_intervals(ray, source, lo, hi);
        if lit.intervals.is_empty() {
            return out;
        }
        let mut sample = self.sample_along(ray, source, sun_depths, lo, hi);
        let mut cuts = Vec::new();
        for &(a, b) in &lit.intervals {
            // Cut the lit interval where panes begin and end.
            cuts.clear();
            cuts.extend([a, b]);
            cuts.extend(lit.tints.iter().flat_map(|t| [t.0, t.1]).filter(|t| *t > a && *t < b));
            cuts.sort_by(f64::total_cmp);
            for pair in cuts.windows(2) {
                sample.add_lit(path, &lit, pair[0], pair[1], &mut out);
            }
        }
        out
    }

    /// A light sample along lo..hi, without any depth yet.
    pub(crate) fn sample_along<'a>(
        &'a self,
        ray: ViewRay,
        source: &'a EmissionSample<'a>,
        sun_depths: Option<&'a SunDepthCache<'a>>,
        lo: f64,
        hi: f64,
    ) -> SampleAlongRay<'a> {
        let (least, most) = DEPTH_INTERVALS;
        let count = (((hi - lo) / self.node_spacing).ceil() as usize).clamp(least, most);
        let nodes = vec![None; count + 1];
        SampleAlongRay {
            scattering: self,
            ray,
            source,
            sun_depths,
            lo,
            step: (hi - lo) / count as f64,
            nodes,
            max_step: max_equiangular_step(source),
        }
    }
}

impl SampleAlongRay<'_> {
    /// Transmittance of the medium from the ray at `t` over `distance`, m, with the mean extinction towards a point of an emitter.
    pub(crate) fn transmittance_over(&mut self, t: f64, distance: f64) -> Bands {
        (-self.depth(self.interval(t), t) * distance).exp()
    }

    /// Adds the lit interval a..b, behind the same panes throughout.
    fn add_lit(&mut self, path: &RayPath, lit: &LitIntervals, a: f64, b: f64, out: &mut Bands) {
        let tints = lit.panes_at(0.5 * (a + b));
        self.for_each_part(path, a, b, |sample, part| match *sample.source {
            EmissionSample::Distant { direction: towards, .. } => {
                let tint = sample.pane_transmittance(&tints, towards);
                sample.add_distant(&part, tint, out);
            }
            EmissionSample::Point { .. } | EmissionSample::Intensity { .. } => {
                sample.add_point(&part, &tints, out);
            }
        });
    }

    /// Adds the interval a..b of a distant light with the transmittance `tint` of panes throughout.
    pub(crate) fn add_tinted(&mut self, path: &RayPath, tint: Bands, a: f64, b: f64, out: &mut Bands) {
        self.for_each_part(path, a, b, |sample, part| sample.add_distant(&part, tint, out));
    }

    /// Calls `each` for the scattering parts of a..b.
    fn for_each_part(&mut self, path: &RayPath, a: f64, b: f64, mut each: impl FnMut(&mut Self, NodePart)) {
        let first = path.segments.partition_point(|p| p.t1 <= a);
        for segment in path.segments[first..].iter().take_while(|p| p.t0 < b) {
            if segment.scattering == Bands::ZERO {
                continue;
            }
            let (mut t, end) = (segment.t0.max(a), segment.t1.min(b));
            while t < end {
                let node = self.interval(t);
                let border = self.lo + (node + 1) as f64 * self.step;
                let next = if node + 2 >= self.nodes.len() || border >= end { end } else { border };
                if next > t {
                    each(self, NodePart { segment, node, a: t, b: next });
                }
                t = if next > t { next } else { end };
            }
        }
    }

    /// Adds a part lit by a distant light.
    fn add_distant(&mut self, part: &NodePart, tint: Bands, out: &mut Bands) {
        let EmissionSample::Distant { fluence, .. } = *self.source else {
            return;
        };
        let &NodePart { segment, node, a, b } = part;
        let (da, db, tau) = (self.depth(node, a), self.depth(node, b), segment.transmittance_at(a));
        let x = segment.extinction * (b - a) + db - da;
        // Start from the end of lesser depth: e^{−x} may overflow.
        let least = da + x.min(Bands::ZERO);
        let light = fluence * tint * (-least).exp() / (4.0 * PI);
        *out += segment.scattering * (b - a) * tau * light * x.abs().map(mean_exp);
    }

    /// Adds a part lit by a point of an emitter or a point light, by the equiangular midpoint rule.
    fn add_point(&mut self, part: &NodePart, tints: &[(u32, Vec3)], out: &mut Bands) {
        let Some((at, _)) = self.source.intensity_towards(self.ray.origin) else { return };
        let &NodePart { segment, node, a, b } = part;
        let ViewRay { origin, dir } = self.ray;
        let centre = (at - origin).dot(dir);
        let delta = (origin + dir * centre - at).length().max(1e-6 * self.step);
        let span = angle_between(a - centre, b - centre, delta);
        let n = (span / self.max_step).ceil().max(1.0) as usize;
        let start = if n > 1 { ((a - centre) / delta).atan() } else { 0.0 };
        for j in 0..n {
            let t = if n > 1 {
                let theta = start + span * (j as f64 + 0.5) / n as f64;
                (centre + delta * theta.tan()).clamp(a, b)
            } else {
                0.5 * (a + b)
            };
            let to_light = at - origin - dir * t;
            let (r, towards) = (to_light.length(), to_light.normalized());
            let Some((_, intensity)) = self.source.intensity_towards(at - to_light) else { continue };
            if intensity == Bands::ZERO {
                continue;
            }
            let (tau, d) = (segment.transmittance_at(t), self.depth(node, t));
            let tint = self.pane_transmittance(tints, towards);
            let weight = span / (n as f64 * delta) / (4.0 * PI);
            *out += segment.scattering * tau * intensity * weight * tint * (-d * r).exp();
        }
    }

    /// Index of the node interval that contains `t`.
    fn interval(&self, t: f64) -> usize {
        (((t - self.lo) / self.step * (1.0 + 1e-12) + 1e-9) as usize).min(self.nodes.len() - 2)
    }

    /// Depth of the medium from node `k` towards the light; for a point per metre, which stays smooth near it.
    fn node(&mut self, k: usize) -> Bands {
        if let Some(d) = self.nodes[k] {
            return d;
        }
        let x = self.ray.at(self.lo + k as f64 * self.step);
        let transport = self.scattering.transport;
        let d = match *self.source {
            EmissionSample::Distant { direction: towards, .. } => match self.sun_depths {
                Some(cache) => cache.depth(x),
                None => transport.medium_depth(x, transport.exterior_point(x, towards)),
            },
            EmissionSample::Point { position: at, .. } | EmissionSample::Intensity { position: at, .. } => {
                let r = (at - x).length().max(1e-12);
                transport.medium_depth(x, at) / r
            }
        };
        self.nodes[k] = Some(d);
        d
    }

    /// The depth of [`SampleAlongRay::node`], interpolated to t between the nodes k and k + 1.
    fn depth(&mut self, k: usize, t: f64) -> Bands {
        let (p, q) = (self.node(k), self.node(k + 1));
        let f = (t - self.lo) / self.step - k as f64;
        p + f * (q - p)
    }

    /// Transmittance of panes for light from the unit direction `towards`.
    pub(crate) fn pane_transmittance(&self, tints: &[(u32, Vec3)], towards: Vec3) -> Bands {
        let mut depth = Bands::ZERO;
        for (pane, normal) in tints {
            let p = &self.scattering.scene.panes()[*pane as usize];
            let slant = p.thickness / normal.dot(towards).abs().max(1e-9);
            depth += p.extinction * slant;
        }
        (-depth).exp()
    }
}
