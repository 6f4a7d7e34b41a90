//! Single scattering of the light of small area lights, free of noise beside the light.
//!
//! Without obstacles the fluence G(x) of an emitter of few facets with uniform emission is known in closed form. Sampled points of the
//! emitter give only the share of it that arrives:
//!
//! ```text
//! L = ∫ κΩ τ_eye G S/(4π) dt      S(t) = Σ_i v_i e^{−r̄ D_i/r_i} g_i / Σ_i g_i      g_i = |cosθ_i|/r_i²
//! ```
//!
//! D_i is the optical depth towards point i and r̄ the mean distance of the emitter, weighted with g over a few points a facet. In a
//! uniform medium S has neither noise nor the bias that a mean of e^{−D_i} over a few points has. v_i is the visibility of point i times
//! the transmittance of panes: borders of shafts stay as exact as in [`crate::lights::lit_intervals`]. 1/r² cancels, so that a ray that
//! passes close to one of the points is no brighter than its neighbour.
//!
//! G (r² + a²), with r the distance from the emitter's centre and a its radius, hardly varies far away. The ray is cut into cells, at
//! the planes of the facets and with lengths of at most about half the distance to the emitter. In each cell this product is a parabola
//! through three Gauss points, and so is r̄². Cells are cut again where medium, visibility or panes change; there G S is linear
//! through two Gauss points, and its integral with τ_eye is exact ([`linear_source_integral`]).
//!
//! One-sided emitters qualify only where all facets lie in one plane: otherwise all sampled points may face away from x while other
//! points do not, and the share would be undefined. Cost: three closed-form evaluations a cell, and one depth a sample and part.

use super::ray_path::{RayPath, VoxelSegment, linear_source_integral};
use super::single_scattering::{SampleAlongRay, SingleScattering};
use crate::lights::lit_intervals::LitIntervals;
use crate::view_ray::ViewRay;
use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_scene::{Band, Bands, Plate, Scene, Sides};
use zonal_transport::lights::{EmissionSample, LightSampler, Receiver};

/// Magnitude of the outer of three Gauss–Legendre points on [−1,1].
const GAUSS_3_OUTER: f64 = 0.774_596_669_241_483_4;
/// The two Gauss–Legendre points on [0,1].
const GAUSS_2: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

// Choice and discretization of analytic area lights.

/// Largest number of facets: beyond, the closed form costs more than samples.
const MAX_FACETS: usize = 8;
/// Length of a cell over the distance to the emitter.
const CELL_LENGTH: f64 = 0.6;
/// Least length of a cell over the radius of the emitter.
const MIN_CELL_LENGTH: f64 = 0.03;
/// Points along each side of a facet for the mean distance of an emitter nearby.
const NEAR_POINTS_PER_SIDE: usize = 4;
/// Length of a part over the distance to the emitter below which one point is enough.
const MAX_ONE_POINT_LENGTH: f64 = 0.08;

/// An emitter whose unoccluded fluence is known in closed form.
#[derive(Clone, Debug)]
pub(crate) struct AnalyticAreaLight {
    plates: Vec<Plate>,
    centre: Vec3,
    /// Half the diagonal of its bounds, m.
    radius: f64,
    /// Points on the facets with their vector areas, m²: few for distant receivers, many for near ones.
    quadrature: [Vec<(Vec3, Vec3)>; 2],
}

/// A part of the ray on which the unoccluded light is smooth.
struct SmoothCell {
    t0: f64,
    t1: f64,
    /// Distance to the emitter at the start, m.
    distance: f64,
    /// Coefficients over [−1,1] of the parabolas; computed on first use.
    parabolas: Option<[SmoothProducts; 3]>,
}

/// G (r² + a²) and r̄², or a coefficient of their parabolas.
type SmoothProducts = (Bands, f64);

/// A sampled point of the emitter and the parts of the ray that it lights.
struct LitEmitterPoint<'a> {
    at: Vec3,
    normal: Vec3,
    both: bool,
    lit: LitIntervals,
    along: SampleAlongRay<'a>,
}

/// One ray and one emitter.
struct LitRay<'a> {
    light: &'a AnalyticAreaLight,
    light_sampler: &'a LightSampler<'a>,
    ray: ViewRay,
    points: Vec<LitEmitterPoint<'a>>,
}

/// The panes before each point; `None` for points in shadow.
type PanesOfPoints = [Option<Vec<(u32, Vec3)>>];

impl AnalyticAreaLight {
    /// The closed form of an emitter; `None` for a light that is better sampled.
    pub(crate) fn new(scene: &Scene, light_sampler: &LightSampler) -> Option<AnalyticAreaLight> {
        let surface = light_sampler.light().surface()?;
        let own = scene.facets().iter().filter(|f| f.surface == surface);
        let plates: Vec<Plate> = own.map(|f| f.plate).collect();
        let first = *plates.first()?;
        let (lo, hi) = plates.iter().map(Plate::bounds).reduce(|x, y| (x.0.min(y.0), x.1.max(y.1)))?;
        let (centre, radius) = ((lo + hi) * 0.5, 0.5 * (hi - lo).length());
        let normal = first.normal();
        let coplanar = |p: &Plate| {
            let height = (p.centre() - first.centre()).dot(normal).abs();
            normal.dot(p.normal()) > 1.0 - 1e-9 && height < 1e-6 * radius
        };
        let share_defined = scene.surfaces()[surface].sides == Sides::Both || plates.iter().all(coplanar);
        let unoccluded = light_sampler.unoccluded(first.centre() + normal * radius, Receiver::Free);
        let qualifies = share_defined && plates.len() <= MAX_FACETS && unoccluded != Bands::ZERO;
        let quadrature = quadrature(&plates);
        qualifies.then_some(AnalyticAreaLight { plates, centre, radius, quadrature })
    }

    /// Radiance, W/(m² sr), that the emitter adds along the path, from a few of its points.
    pub(crate) fn inscattered(
        &self,
        scattering: &SingleScattering,
        light_sampler: &LightSampler,
        ray: ViewRay,
        path: &RayPath,
        sources: &[EmissionSample],
    ) -> Bands {
        let mut out = Bands::ZERO;
        let Some((lo, hi)) = path.scattering_range() else {
            return out;
        };
        let points = points_along(scattering, ray, sources, lo, hi);
        if points.iter().all(|p| p.lit.intervals.is_empty()) {
            return out;
        }
        // Cut the ray where visibility or panes change, and into cells on which the unoccluded light is smooth.
        let mut cuts = vec![lo, hi];
        for p in &points {
            cuts.extend(p.lit.intervals.iter().flat_map(|i| [i.0, i.1]));
            cuts.extend(p.lit.tints.iter().flat_map(|i| [i.0, i.1]));
        }
        cuts.sort_by(f64::total_cmp);
        let mut cells = self.cells(ray, lo, hi);
        // Add the parts between successive cuts, cells and voxel borders.
        let mut lit_ray = LitRay { light: self, light_sampler, ray, points };
        let (mut c, mut k) = (0, 0);
        for segment in path.segments.iter().filter(|p| p.scattering != Bands::ZERO) {
            let mut t = segment.t0;
            while t < segment.t1 {
                while c + 1 < cells.len() && cells[c].t1 <= t {
                    c += 1;
                }
                while k < cuts.len() && cuts[k] <= t {
                    k += 1;
                }
                let border = cells[c].t1.min(cuts.get(k).copied().unwrap_or(hi));
                let next = if border > t { border.min(segment.t1) } else { segment.t1 };
                lit_ray.add_part(segment, &mut cells[c], t, next, &mut out);
                t = next;
            }
        }
        out
    }

    /// Cuts lo..hi into cells.
    fn cells(&self, ray: ViewRay, lo: f64, hi: f64) -> Vec<SmoothCell> {
        let ViewRay { origin, dir } = ray;
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
                let least = MIN_CELL_LENGTH * self.radius;
                let length = (CELL_LENGTH * distance).max(least).max(1e-6 * (hi - lo));
                let t1 = if t0 + 1.3 * length < end { t0 + length } else { end };
                cells.push(SmoothCell { t0, t1, distance, parabolas: None });
                t0 = t1;
            }
        }
        cells
    }

    /// Approximate distance to the nearest facet, m.
    fn distance(&self, x: Vec3) -> f64 {
        let to = |p: &Plate| {
            let [u, v] = p.parameters(x).map(|s| s.clamp(0.0, 1.0));
            (p.at(u, v) - x).length()
        };
        self.plates.iter().map(to).fold(f64::INFINITY, f64::min)
    }

    /// r̄², the square of the emitter's mean distance; with many points for a near receiver.
    fn mean_distance2(&self, x: Vec3, near: bool) -> f64 {
        let (mut sum, mut weight) = (0.0, 0.0);
        for (at, area) in &self.quadrature[usize::from(near)] {
            let from_point = x - *at;
            let r2 = from_point.length2() + 1e-4 * area.length();
            let w = from_point.dot(*area).abs() / r2;
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

/// Points of the plates with their vector areas, m²: 2 × 2 a facet, and a finer grid.
fn quadrature(plates: &[Plate]) -> [Vec<(Vec3, Vec3)>; 2] {
    let side = NEAR_POINTS_PER_SIDE;
    let few = GAUSS_2.iter().flat_map(|u| GAUSS_2.map(|v| [*u, v]));
    let many = (0..side * side).map(|i| [i % side, i / side].map(|k| (k as f64 + 0.5) / side as f64));
    [few.collect::<Vec<_>>(), many.collect()].map(|grid| {
        let point = |p: &Plate, s: &[f64; 2]| {
            let [u, v] = p.warp(*s);
            (p.at(u, v), p.normal() * (p.area() / grid.len() as f64))
        };
        plates.iter().flat_map(|p| grid.iter().map(move |s| point(p, s))).collect()
    })
}

/// The sampled points of an emitter with the parts of lo..hi on the ray that they light.
fn points_along<'a>(
    scattering: &'a SingleScattering<'a>,
    ray: ViewRay,
    sources: &'a [EmissionSample],
    lo: f64,
    hi: f64,
) -> Vec<LitEmitterPoint<'a>> {
    let point = |source: &'a EmissionSample| match *source {
        EmissionSample::Point { position: at, normal, two_sided: both, .. } => Some(LitEmitterPoint {
            at,
            normal,
            both,
            lit: scattering.casters.lit_intervals(ray, source, lo, hi),
            along: scattering.sample_along(ray, source, None, lo, hi),
        }),
        EmissionSample::Distant { .. } | EmissionSample::Intensity { .. } => None,
    };
    sources.iter().filter_map(point).collect()
}

impl LitRay<'_> {
    /// Adds a..b of a segment, inside one cell and between two cuts.
    fn add_part(&mut self, segment: &VoxelSegment, cell: &mut SmoothCell, a: f64, b: f64, out: &mut Bands) {
        let middle = 0.5 * (a + b);
        let x = self.ray.at(middle);
        let behind = |p: &LitEmitterPoint| !p.both && p.normal.dot(x - p.at) <= 0.0;
        if self.points.iter().all(behind) {
            return;
        }
        let panes: Vec<Option<Vec<(u32, Vec3)>>> =
            self.points.iter().map(|p| p.lit.contains(middle).then(|| p.lit.panes_at(middle))).collect();
        if panes.iter().all(Option::is_none) {
            return;
        }
        let length = b - a;
        let (start, slope) = if length < MAX_ONE_POINT_LENGTH * cell.distance {
            (self.arriving_fluence(cell, &panes, middle), Bands::ZERO)
        } else {
            let [p, q] = GAUSS_2.map(|g| self.arriving_fluence(cell, &panes, a + g * length));
            let slope = (q - p) / ((GAUSS_2[1] - GAUSS_2[0]) * length);
            ((p - slope * GAUSS_2[0] * length).max(Bands::ZERO), slope)
        };
        let tau = if a > segment.t0 { segment.transmittance_at(a) } else { segment.transmittance };
        for i in Band::all().filter(|i| segment.scattering[*i] > 0.0) {
            let kappa = segment.extinction[i];
            let albedo = segment.scattering[i] / kappa;
            let integral = linear_source_integral(kappa, length, start[i], slope[i]);
            out[i] += tau[i] * albedo * integral / (4.0 * PI);
        }
    }

    /// G S at `t`, W/m².
    fn arriving_fluence(&mut self, cell: &mut SmoothCell, panes: &PanesOfPoints, t: f64) -> Bands {
        let x = self.ray.at(t);
        let (unoccluded, distance) = self.unoccluded(cell, t, x);
        let (mut emitted, mut arrived) = (0.0, Bands::ZERO);
        for (p, panes) in self.points.iter_mut().zip(panes) {
            let to_point = p.at - x;
            let r2 = to_point.length2().max(1e-24);
            let cos_r = -p.normal.dot(to_point);
            let emitted_cos_r = if p.both { cos_r.abs() } else { cos_r.max(0.0) };
            let weight = emitted_cos_r / (r2 * r2.sqrt());
            emitted += weight;
            if let Some(panes) = panes.as_ref().filter(|_| weight > 0.0) {
                let mut passed = p.along.transmittance_over(t, distance);
                if !panes.is_empty() {
                    passed *= p.along.pane_transmittance(panes, to_point.normalized());
                }
                arrived += weight * passed;
            }
        }
        if emitted > 0.0 { unoccluded * arrived / emitted } else { Bands::ZERO }
    }

    /// Unoccluded G at `t`, W/m², and r̄, m.
    fn unoccluded(&self, cell: &mut SmoothCell, t: f64, x: Vec3) -> (Bands, f64) {
        let (middle, half) = (0.5 * (cell.t0 + cell.t1), 0.5 * (cell.t1 - cell.t0));
        let distance = cell.distance;
        let [constant, linear, square] = *cell.parabolas.get_or_insert_with(|| {
            let [p, q, r] = [-GAUSS_3_OUTER, 0.0, GAUSS_3_OUTER].map(|s| {
                let x = self.ray.at(middle + s * half);
                let spread = self.light.spread(x);
                let fluence = self.light_sampler.unoccluded(x, Receiver::Free) * spread;
                (fluence, self.light.mean_distance2(x, distance < self.light.radius))
            });
            let (h, h2) = (2.0 * GAUSS_3_OUTER, 2.0 * GAUSS_3_OUTER * GAUSS_3_OUTER);
            let linear = ((r.0 - p.0) / h, (r.1 - p.1) / h);
            let square = ((r.0 - 2.0 * q.0 + p.0) / h2, (r.1 - 2.0 * q.1 + p.1) / h2);
            [q, linear, square]
        });
        let s = (t - middle) / half;
        let fluence = (constant.0 + s * (linear.0 + s * square.0)).max(Bands::ZERO);
        let distance2 = (constant.1 + s * (linear.1 + s * square.1)).max(0.0);
        (fluence / self.light.spread(x), distance2.sqrt())
    }
}
