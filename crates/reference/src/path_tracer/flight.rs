//! Flights between path vertices through facets, cells of the medium and panes.
//!
//! A flight is cut into segments of constant extinction: cells of the voxel grid (planes computed from the index of the cell, so that
//! errors do not accumulate) and crossings of panes, whose optical depth is κ t/|cosθ|. With the throughput β of the path, a band h is
//! drawn with probability p_h = β_h/Σβ and an optical distance from e^{−δ} in it; then
//!
//! ```text
//! collision:  weight_b = κ_b e^{−δ_b} / Σ_c p_c κ_c e^{−δ_c}      end of the ray:  weight_b = e^{−δ_b} / Σ_c p_c e^{−δ_c}
//! ```
//!
//! (spectral multiple importance sampling), which has the right mean in every band and is 1 in a grey medium. Emission of the
//! segments is not sampled but summed, Σ e^{−δ}(1 − e^{−κℓ}) S with S = (1 − Ω)E + q/(4κ), or q ℓ/4 where κ = 0, over the whole ray.

use super::bvh::{BinaryBvh, RayHit};
use crate::rng::select_band;
use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_scene::{Band, Bands, Scene, VoxelGrid};

/// A point at which light is received or scattered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PathVertex {
    /// On a surface.
    Surface {
        /// Position, m.
        at: Vec3,
        /// Unit normal of the side that receives.
        normal: Vec3,
        /// The facet, if it is one of the scene's.
        facet: Option<u32>,
    },
    /// In free space or in the medium.
    Free {
        /// Position, m.
        at: Vec3,
    },
    /// In a pane.
    Pane {
        /// Position, m.
        at: Vec3,
        /// Unit normal.
        normal: Vec3,
        /// Index of the pane.
        pane: usize,
        /// Depth in the pane, m: 0 on the side that the normal points away from, the thickness on the other.
        height: f64,
    },
}

impl PathVertex {
    /// Position, m.
    pub(crate) fn at(&self) -> Vec3 {
        match *self {
            PathVertex::Surface { at, .. } | PathVertex::Free { at } | PathVertex::Pane { at, .. } => at,
        }
    }
    /// The density with which light from direction `d` is scattered, per steradian: cosθ/π or 1/(4π).
    pub(crate) fn density(&self, d: Vec3) -> f64 {
        match *self {
            PathVertex::Surface { normal, .. } => normal.dot(d).max(0.0) / PI,
            _ => 0.25 / PI,
        }
    }
    fn facet(&self) -> Option<u32> {
        if let PathVertex::Surface { facet, .. } = *self { facet } else { None }
    }
}

/// The end of a flight.
#[derive(Clone, Copy, Debug)]
pub(crate) enum FlightEnd {
    /// The ray leaves the scene.
    Escaped,
    /// A facet is hit.
    Facet(RayHit),
    /// A collision in the medium or in a pane, with the albedo there.
    Collision(PathVertex, Bands),
}

/// A flight: its end, the weight of each band, and the emission along the ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flight {
    /// Its end.
    pub end: FlightEnd,
    /// Weight of each band.
    pub weight: Bands,
    /// Radiance of the medium and the panes along the whole ray, W/(m² sr).
    pub emitted: Bands,
}

/// A segment of a ray with constant extinction.
struct FlightSegment {
    from: f64,
    to: f64,
    depth: Bands,
    source: Bands,
    /// q/4 in bands without extinction, W/m³.
    transparent: Bands,
    /// `None` where it varies along the segment.
    albedo: Option<Bands>,
    /// For a pane: its index, unit normal and range of depths.
    pane: Option<(usize, Vec3, DepthRange)>,
}

/// Depths in a pane at the start and the end of a segment, m.
type DepthRange = [f64; 2];

/// A scene with its BVHs.
pub(crate) struct RayScene<'a> {
    /// The scene.
    pub scene: &'a Scene,
    facets: BinaryBvh,
    panes: BinaryBvh,
    pane_of: Vec<(u32, Vec3)>,
    near: f64,
    emits: bool,
}

/// Points nearer than this fraction of the scene's diagonal coincide.
const COINCIDENCE_SHARE_OF_DIAGONAL: f64 = 1e-9;

impl<'a> RayScene<'a> {
    /// Builds the BVHs.
    pub(crate) fn new(scene: &'a Scene) -> RayScene<'a> {
        let (lo, hi) = scene.bounds();
        let size = scene.diagonal() + lo.max_abs().max(hi.max_abs());
        let plates =
            || scene.panes().iter().enumerate().flat_map(|(k, p)| p.plates.iter().map(move |q| (k, *q)));
        let medium_emits = scene.voxel_grid().is_some_and(|m| {
            (0..m.len())
                .any(|c| m.source(c) != Bands::ZERO || (m.emission(c) * (1.0 - m.albedo(c))).any(|e| e > 0.0))
        });
        RayScene {
            scene,
            facets: BinaryBvh::new((0u32..).zip(scene.facets().iter().map(|f| f.plate)), size),
            panes: BinaryBvh::new((0u32..).zip(plates().map(|p| p.1)), size),
            pane_of: plates().map(|(k, p)| (k as u32, p.normal())).collect(),
            near: COINCIDENCE_SHARE_OF_DIAGONAL * scene.diagonal(),
            emits: medium_emits || scene.panes().iter().any(|p| p.emission != Bands::ZERO),
        }
    }

    /// True when no facet lies between two points.
    pub(crate) fn visible(&self, a: Vec3, b: Vec3) -> bool {
        let r = (b - a).length();
        r <= self.near || !self.facets.any(a, (b - a) / r, 0.0..r, [None; 2])
    }

    /// Transmittance per band from a vertex along `d` to distance `limit`, where facet `end` may lie; `None` behind a facet.
    pub(crate) fn transmittance(
        &self,
        v: &PathVertex,
        d: Vec3,
        limit: f64,
        end: Option<u32>,
    ) -> Option<Bands> {
        if self.facets.any(v.at(), d, self.near..limit - self.near, [v.facet(), end]) {
            return None;
        }
        let mut depth = Bands::ZERO;
        self.visit_segments(v, d, limit, false, &mut |segment| {
            depth += segment.depth;
            true
        });
        Some((-depth).exp())
    }

    /// A flight from a vertex along `d`, for a path of throughput `beta` (some band above 0), with two numbers of [0, 1).
    pub(crate) fn sample_flight(&self, v: &PathVertex, d: Vec3, beta: Bands, u: [f64; 2]) -> Flight {
        // Choose the band and the optical distance.
        let hit = self.facets.nearest(v.at(), d, self.near..f64::INFINITY, v.facet());
        let limit = hit.map_or(f64::INFINITY, |m| m.t);
        let probability = beta / beta.sum();
        let band = select_band(probability, u[0]);
        let positive = |b: &Band| probability[*b] > 0.0;
        let band = if positive(&band) { band } else { Band::all().find(positive).unwrap_or(Band::first()) };
        let mut rest = -(1.0 - u[1]).ln();
        // Sum the emission and find the collision.
        let (mut depth, mut emitted) = (Bands::ZERO, Bands::ZERO);
        let mut collision: Option<(PathVertex, Bands, Bands)> = None;
        self.visit_segments(v, d, limit, self.emits, &mut |segment| {
            if self.emits {
                emitted -= (-depth).exp() * (-segment.depth).map(f64::exp_m1) * segment.source / PI;
                emitted += (-depth).exp() * segment.transparent * ((segment.to - segment.from) / PI);
            }
            if collision.is_none() && segment.depth[band] > rest {
                let part = rest / segment.depth[band];
                // κ e^{−δ} in each band up to a factor that cancels.
                let density = segment.depth * (-depth - segment.depth * part).exp();
                let vertex = vertex_in(v, d, segment, part);
                let albedo = segment.albedo.unwrap_or_else(|| self.albedo(vertex.at()));
                collision = Some((vertex, albedo, balance_weights(density, probability)));
            }
            rest -= segment.depth[band];
            depth += segment.depth;
            self.emits || collision.is_none()
        });
        match (collision, hit) {
            (Some((vertex, albedo, weight)), _) => {
                Flight { end: FlightEnd::Collision(vertex, albedo), weight, emitted }
            }
            (None, end) => {
                let weight = balance_weights((-depth).exp(), probability);
                Flight { end: end.map_or(FlightEnd::Escaped, FlightEnd::Facet), weight, emitted }
            }
        }
    }

    /// Calls `each` with the segments from a vertex to `limit` in order until it returns false. `per_cell`: every cell is a segment of
    /// its own, with its source, even where the extinction is uniform.
    fn visit_segments(
        &self,
        v: &PathVertex,
        d: Vec3,
        limit: f64,
        per_cell: bool,
        each: &mut impl FnMut(&FlightSegment) -> bool,
    ) {
        if let PathVertex::Pane { normal, pane, height, .. } = *v {
            let p = &self.scene.panes()[pane];
            let cos = normal.dot(d);
            let to = if cos > 0.0 { p.thickness } else { 0.0 };
            if !each(&self.pane_segment(pane, normal, [height, to], cos, 0.0)) {
                return;
            }
        }
        let o = v.at();
        if self.panes.is_empty() {
            self.visit_cells(o, d, [0.0, limit], per_cell, each);
            return;
        }
        let mut from = 0.0;
        for hit in self.panes.all(o, d, self.near..limit - self.near) {
            if !self.visit_cells(o, d, [from, hit.t], per_cell, each) {
                return;
            }
            let (pane, normal) = self.pane_of[hit.id as usize];
            let cos = normal.dot(d);
            let thickness = self.scene.panes()[pane as usize].thickness;
            let run = if cos > 0.0 { [0.0, thickness] } else { [thickness, 0.0] };
            if !each(&self.pane_segment(pane as usize, normal, run, cos, hit.t)) {
                return;
            }
            from = hit.t;
        }
        self.visit_cells(o, d, [from, limit], per_cell, each);
    }

    fn pane_segment(&self, pane: usize, normal: Vec3, run: DepthRange, cos: f64, t: f64) -> FlightSegment {
        let p = &self.scene.panes()[pane];
        let length = (run[1] - run[0]).abs() / cos.abs().max(1e-12);
        FlightSegment {
            from: t,
            to: t,
            depth: p.extinction * length,
            source: (1.0 - p.albedo) * p.emission,
            transparent: Bands::ZERO,
            albedo: Some(p.albedo),
            pane: Some((pane, normal, run)),
        }
    }

    /// Calls `each` with the segments in the voxel grid between two distances; false when it returned false.
    fn visit_cells(
        &self,
        o: Vec3,
        d: Vec3,
        [from, to]: [f64; 2],
        per_cell: bool,
        each: &mut impl FnMut(&FlightSegment) -> bool,
    ) -> bool {
        let Some(grid) = self.scene.voxel_grid() else { return true };
        let Some((from, to)) = clip_to_grid(grid, o, d, from, to) else { return true };
        if let Some(kappa) = grid.uniform_extinction()
            && !per_cell
        {
            // The albedo may still vary: it is evaluated at the collision.
            if kappa == Bands::ZERO {
                return true;
            }
            let mut segment = FlightSegment::empty(from, to);
            segment.depth = kappa * (to - from);
            return each(&segment);
        }
        traverse_grid(grid, o, d, [from, to], |cell, a, b| {
            let kappa = grid.extinction(cell);
            let mut segment = FlightSegment::empty(a, b);
            segment.depth = kappa * (b - a);
            let albedo = grid.albedo(cell);
            segment.albedo = Some(albedo);
            if per_cell {
                let emission = (1.0 - albedo) * grid.emission(cell) + grid.source(cell) / (4.0 * kappa);
                segment.source = emission.zip_map(kappa, |e, k| if k > 0.0 { e } else { 0.0 });
                segment.transparent =
                    grid.source(cell).zip_map(kappa, |q, k| if k > 0.0 { 0.0 } else { 0.25 * q });
            }
            each(&segment)
        })
    }

    /// The albedo of the medium at a point.
    pub(crate) fn albedo(&self, p: Vec3) -> Bands {
        self.scene.voxel_grid().map_or(Bands::ZERO, |m| {
            let c = [0, 1, 2].map(|k| {
                let x = ((p[k] - m.min()[k]) / m.cell()[k]).floor();
                x.clamp(0.0, m.dims()[k] as f64 - 1.0) as usize
            });
            m.albedo(m.index(c))
        })
    }
}

impl FlightSegment {
    fn empty(from: f64, to: f64) -> FlightSegment {
        FlightSegment {
            from,
            to,
            depth: Bands::ZERO,
            source: Bands::ZERO,
            transparent: Bands::ZERO,
            albedo: None,
            pane: None,
        }
    }
}

/// The vertex at the fraction `part` of a segment.
fn vertex_in(v: &PathVertex, d: Vec3, segment: &FlightSegment, part: f64) -> PathVertex {
    let at = v.at() + d * (segment.from + (segment.to - segment.from) * part);
    match segment.pane {
        None => PathVertex::Free { at },
        Some((pane, normal, run)) => {
            PathVertex::Pane { at, normal, pane, height: run[0] + (run[1] - run[0]) * part }
        }
    }
}

/// Density of each band over the mean density.
fn balance_weights(density: Bands, probability: Bands) -> Bands {
    let mean = (probability * density).sum();
    density.map(|x| if mean > 0.0 { x / mean } else { 0.0 })
}

/// The part of a ray in the voxel grid.
pub(crate) fn clip_to_grid(
    grid: &VoxelGrid,
    o: Vec3,
    d: Vec3,
    mut from: f64,
    mut to: f64,
) -> Option<(f64, f64)> {
    for k in 0..3 {
        let (a, b) = ((grid.min()[k] - o[k]) / d[k], (grid.max()[k] - o[k]) / d[k]);
        if d[k] == 0.0 {
            if o[k] < grid.min()[k] || o[k] > grid.max()[k] {
                return None;
            }
            continue;
        }
        from = from.max(a.min(b));
        to = to.min(a.max(b));
    }
    (from < to).then_some((from, to))
}

/// Calls `each` with the cells of a ray between two distances within the voxel grid, in order, until it returns false.
pub(crate) fn traverse_grid(
    grid: &VoxelGrid,
    o: Vec3,
    d: Vec3,
    [from, to]: [f64; 2],
    mut each: impl FnMut(usize, f64, f64) -> bool,
) -> bool {
    let (min, edge, dims) = (grid.min(), grid.cell(), grid.dims());
    let mut cell = [0i64; 3];
    let p = o + d * from;
    for k in 0..3 {
        cell[k] = (((p[k] - min[k]) / edge[k]).floor() as i64).clamp(0, dims[k] as i64 - 1);
    }
    let plane = |k: usize, cell: i64| {
        if d[k] == 0.0 {
            return f64::INFINITY;
        }
        let next = if d[k] > 0.0 { cell + 1 } else { cell };
        (min[k] + next as f64 * edge[k] - o[k]) / d[k]
    };
    let mut next = [plane(0, cell[0]), plane(1, cell[1]), plane(2, cell[2])];
    let mut t = from;
    loop {
        let axis = (1..3).fold(0, |b, k| if next[k] < next[b] { k } else { b });
        let end = next[axis].min(to);
        let index = (cell[0] as usize * dims[1] + cell[1] as usize) * dims[2] + cell[2] as usize;
        if end > t && !each(index, t, end) {
            return false;
        }
        t = t.max(end);
        if next[axis] >= to {
            return true;
        }
        cell[axis] += if d[axis] > 0.0 { 1 } else { -1 };
        if cell[axis] < 0 || cell[axis] >= dims[axis] as i64 {
            return true;
        }
        next[axis] = plane(axis, cell[axis]);
    }
}

/// A scattered direction of density [`PathVertex::density`], from two numbers of [0, 1).
pub(crate) fn sample_scattering(v: &PathVertex, u: [f64; 2]) -> Vec3 {
    let (axis, z) = match *v {
        PathVertex::Surface { normal, .. } => (normal, (1.0 - u[0]).sqrt()),
        _ => (Vec3::from_array([0.0, 0.0, 1.0]), 1.0 - 2.0 * u[0]),
    };
    direction_about(axis, z, u[1])
}

/// The unit vector at cosine `z` with `axis`, rotated by the fraction `turn` of a full turn.
pub(crate) fn direction_about(axis: Vec3, z: f64, turn: f64) -> Vec3 {
    let (a, b) = axis.frame();
    let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    (axis * z + (a * cos + b * sin) * r).normalized()
}
