//! What lies along a ray: facets, cells of the medium, panes.
//!
//! A flight is cut into legs of constant extinction: cells of the voxmap (planes taken from the cell's index, so that nothing drifts)
//! and crossings of panes, whose optical depth is κ t/|cosθ|. With β the throughput that a path brings, a band h is drawn with
//! probability p_h = β_h/Σβ and an optical distance from e^{−δ} in it; then
//!
//! ```text
//! collision:  weight_b = κ_b e^{−δ_b} / Σ_c p_c κ_c e^{−δ_c}      end of the ray:  weight_b = e^{−δ_b} / Σ_c p_c e^{−δ_c}
//! ```
//!
//! which has the right mean in every band and is 1 in a grey medium. Light that the legs themselves send is not sampled but
//! summed up, Σ e^{−δ}(1 − e^{−κℓ}) S with S = (1 − Ω)E + q/(4κ), over the whole ray.

use super::tree::{Met, Tree};
use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_scene::{Bands, Scene, Voxmap, bands};

/// A point at which light is received or scattered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Vertex {
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

impl Vertex {
    /// Position, m.
    pub fn at(&self) -> Vec3 {
        match *self {
            Vertex::Surface { at, .. } | Vertex::Free { at } | Vertex::Pane { at, .. } => at,
        }
    }
    /// The density with which light from direction `d` is scattered, per steradian: cosθ/π or 1/(4π).
    pub fn density(&self, d: Vec3) -> f64 {
        match *self {
            Vertex::Surface { normal, .. } => normal.dot(d).max(0.0) / PI,
            _ => 0.25 / PI,
        }
    }
    fn facet(&self) -> Option<u32> {
        if let Vertex::Surface { facet, .. } = *self { facet } else { None }
    }
}

/// How a flight ends.
#[derive(Clone, Copy, Debug)]
pub enum Fate {
    /// Nothing was met.
    Escaped,
    /// A facet.
    Facet(Met),
    /// A collision in the medium or in a pane, with the albedo there.
    Collision(Vertex, Bands),
}

/// A flight: its end, the weight of each band, and the radiance that the legs sent.
#[derive(Clone, Copy, Debug)]
pub struct Flight {
    /// How it ends.
    pub fate: Fate,
    /// Weight of each band.
    pub weight: Bands,
    /// Radiance of the medium and the panes along the whole ray, W/(m² sr).
    pub sent: Bands,
}

/// A leg of a ray.
struct Leg {
    from: f64,
    to: f64,
    depth: Bands,
    source: Bands,
    /// None where it has to be looked up at the point.
    albedo: Option<Bands>,
    /// For a pane: its index, unit normal and the thickness that is left on each side of the vertex in it.
    pane: Option<(usize, Vec3, Range2)>,
}

/// Depths in a pane between which a leg runs, in its direction.
type Range2 = [f64; 2];

/// A scene with its trees.
pub struct Space<'a> {
    /// The scene.
    pub scene: &'a Scene,
    facets: Tree,
    panes: Tree,
    pane_of: Vec<(u32, Vec3)>,
    near: f64,
    emits: bool,
}

/// Points nearer than this share of the scene's diagonal coincide.
const NEAR: f64 = 1e-9;

impl<'a> Space<'a> {
    /// Builds the trees.
    pub fn new(scene: &'a Scene) -> Space<'a> {
        let (lo, hi) = scene.bounds();
        let size = scene.diagonal() + lo.max_abs().max(hi.max_abs());
        let plates =
            || scene.panes().iter().enumerate().flat_map(|(k, p)| p.plates.iter().map(move |q| (k, *q)));
        let map_emits = scene.voxmap().is_some_and(|m| {
            (0..m.len()).any(|c| {
                m.source(c) != [0.0; 3] || (0..3).any(|b| m.emission(c)[b] * (1.0 - m.albedo(c)[b]) > 0.0)
            })
        });
        Space {
            scene,
            facets: Tree::new((0u32..).zip(scene.facets().iter().map(|f| f.plate)), size),
            panes: Tree::new((0u32..).zip(plates().map(|p| p.1)), size),
            pane_of: plates().map(|(k, p)| (k as u32, p.normal())).collect(),
            near: NEAR * scene.diagonal(),
            emits: map_emits || scene.panes().iter().any(|p| p.emission != [0.0; 3]),
        }
    }

    /// The first facet on a ray from `o`.
    pub fn first(&self, o: Vec3, d: Vec3) -> Option<Met> {
        self.facets.nearest(o, d, self.near..f64::INFINITY, None)
    }

    /// True when no facet lies between two points.
    pub fn sees(&self, a: Vec3, b: Vec3) -> bool {
        let r = (b - a).length();
        r <= self.near || !self.facets.any(a, (b - a) / r, 0.0..r, [None; 2])
    }

    /// Transmittance from a vertex along `d` to distance `limit`, where facet `end` may lie; none behind a facet.
    pub fn transmittance(&self, v: &Vertex, d: Vec3, limit: f64, end: Option<u32>) -> Option<Bands> {
        if self.facets.any(v.at(), d, self.near..limit - self.near, [v.facet(), end]) {
            return None;
        }
        let mut depth = [0.0; 3];
        self.legs(v, d, limit, false, &mut |leg| {
            depth = bands(|b| depth[b] + leg.depth[b]);
            true
        });
        Some(depth.map(|x| (-x).exp()))
    }

    /// A flight from a vertex along `d`, for a path of throughput `beta` (some band above 0), with two numbers of [0, 1).
    pub fn fly(&self, v: &Vertex, d: Vec3, beta: Bands, u: [f64; 2]) -> Flight {
        let met = self.facets.nearest(v.at(), d, self.near..f64::INFINITY, v.facet());
        let limit = met.map_or(f64::INFINITY, |m| m.t);
        let total: f64 = beta.iter().sum();
        let share = beta.map(|x| x / total);
        let band = if u[0] < share[0] {
            0
        } else if u[0] < share[0] + share[1] {
            1
        } else {
            2
        };
        let band = if share[band] > 0.0 { band } else { (0..3).find(|&b| share[b] > 0.0).unwrap_or(0) };
        let mut rest = -(1.0 - u[1]).ln();
        let (mut depth, mut sent) = ([0.0f64; 3], [0.0; 3]);
        let mut fate: Option<(Vertex, Bands, Bands)> = None;
        self.legs(v, d, limit, self.emits, &mut |leg| {
            if self.emits {
                sent = bands(|b| sent[b] - (-depth[b]).exp() * (-leg.depth[b]).exp_m1() * leg.source[b] / PI);
            }
            if fate.is_none() && leg.depth[band] > rest {
                let part = rest / leg.depth[band];
                // κ in each band up to a factor that cancels.
                let density = bands(|b| leg.depth[b] * (-depth[b] - leg.depth[b] * part).exp());
                let vertex = place(v, d, leg, part);
                let albedo = leg.albedo.unwrap_or_else(|| self.albedo(vertex.at()));
                fate = Some((vertex, albedo, weights(density, share)));
            }
            rest -= leg.depth[band];
            depth = bands(|b| depth[b] + leg.depth[b]);
            self.emits || fate.is_none()
        });
        match (fate, met) {
            (Some((vertex, albedo, weight)), _) => {
                Flight { fate: Fate::Collision(vertex, albedo), weight, sent }
            }
            (None, end) => {
                let weight = weights(depth.map(|x| (-x).exp()), share);
                Flight { fate: end.map_or(Fate::Escaped, Fate::Facet), weight, sent }
            }
        }
    }

    /// Calls `each` with the legs from a vertex to `limit` in order until it says false. `fine`: cells that differ in their sources
    /// are legs of their own even where the extinction is uniform.
    fn legs(&self, v: &Vertex, d: Vec3, limit: f64, fine: bool, each: &mut impl FnMut(&Leg) -> bool) {
        if let Vertex::Pane { normal, pane, height, .. } = *v {
            let p = &self.scene.panes()[pane];
            let cos = normal.dot(d);
            let to = if cos > 0.0 { p.thickness } else { 0.0 };
            if !each(&self.pane_leg(pane, normal, [height, to], cos, 0.0)) {
                return;
            }
        }
        let o = v.at();
        if self.panes.is_empty() {
            self.cells(o, d, 0.0, limit, fine, each);
            return;
        }
        let mut from = 0.0;
        for met in self.panes.all(o, d, self.near..limit - self.near) {
            if !self.cells(o, d, from, met.t, fine, each) {
                return;
            }
            let (pane, normal) = self.pane_of[met.id as usize];
            let cos = normal.dot(d);
            let thickness = self.scene.panes()[pane as usize].thickness;
            let run = if cos > 0.0 { [0.0, thickness] } else { [thickness, 0.0] };
            if !each(&self.pane_leg(pane as usize, normal, run, cos, met.t)) {
                return;
            }
            from = met.t;
        }
        self.cells(o, d, from, limit, fine, each);
    }

    fn pane_leg(&self, pane: usize, normal: Vec3, run: Range2, cos: f64, t: f64) -> Leg {
        let p = &self.scene.panes()[pane];
        let length = (run[1] - run[0]).abs() / cos.abs().max(1e-12);
        Leg {
            from: t,
            to: t,
            depth: p.extinction.map(|k| k * length),
            source: bands(|b| (1.0 - p.albedo[b]) * p.emission[b]),
            albedo: Some(p.albedo),
            pane: Some((pane, normal, run)),
        }
    }

    /// The legs in the voxmap between two distances; false when `each` said so.
    fn cells(
        &self,
        o: Vec3,
        d: Vec3,
        from: f64,
        to: f64,
        fine: bool,
        each: &mut impl FnMut(&Leg) -> bool,
    ) -> bool {
        let Some(map) = self.scene.voxmap() else { return true };
        let Some((from, to)) = clip(map, o, d, from, to) else { return true };
        if let Some(kappa) = map.uniform_extinction()
            && !fine
        {
            // The albedo may still vary: it is looked up where a collision falls.
            if kappa == [0.0; 3] {
                return true;
            }
            let mut leg = Leg::empty(from, to);
            leg.depth = kappa.map(|k| k * (to - from));
            return each(&leg);
        }
        walk(map, o, d, from, to, |cell, a, b| {
            let kappa = map.extinction(cell);
            let mut leg = Leg::empty(a, b);
            leg.depth = kappa.map(|k| k * (b - a));
            let albedo = map.albedo(cell);
            leg.albedo = Some(albedo);
            if fine {
                leg.source = bands(|k| {
                    let e = (1.0 - albedo[k]) * map.emission(cell)[k];
                    if kappa[k] > 0.0 { e + map.source(cell)[k] / (4.0 * kappa[k]) } else { 0.0 }
                });
            }
            each(&leg)
        })
    }

    /// The albedo of the medium at a point.
    pub fn albedo(&self, p: Vec3) -> Bands {
        self.scene.voxmap().map_or([0.0; 3], |m| {
            let c = [0, 1, 2].map(|k| {
                let x = ((p[k] - m.min()[k]) / m.cell()[k]).floor();
                x.clamp(0.0, m.dims()[k] as f64 - 1.0) as usize
            });
            m.albedo(m.index(c))
        })
    }
}

impl Leg {
    fn empty(from: f64, to: f64) -> Leg {
        Leg { from, to, depth: [0.0; 3], source: [0.0; 3], albedo: None, pane: None }
    }
}

/// The vertex at a share of a leg.
fn place(v: &Vertex, d: Vec3, leg: &Leg, part: f64) -> Vertex {
    let at = v.at() + d * (leg.from + (leg.to - leg.from) * part);
    match leg.pane {
        None => Vertex::Free { at },
        Some((pane, normal, run)) => {
            Vertex::Pane { at, normal, pane, height: run[0] + (run[1] - run[0]) * part }
        }
    }
}

fn weights(density: Bands, share: Bands) -> Bands {
    let mean: f64 = (0..3).map(|b| share[b] * density[b]).sum();
    density.map(|x| if mean > 0.0 { x / mean } else { 0.0 })
}

/// The part of a ray in the voxmap.
pub(crate) fn clip(map: &Voxmap, o: Vec3, d: Vec3, mut from: f64, mut to: f64) -> Option<(f64, f64)> {
    for k in 0..3 {
        let (a, b) = ((map.min()[k] - o[k]) / d[k], (map.max()[k] - o[k]) / d[k]);
        if d[k] == 0.0 {
            if o[k] < map.min()[k] || o[k] > map.max()[k] {
                return None;
            }
            continue;
        }
        from = from.max(a.min(b));
        to = to.min(a.max(b));
    }
    (from < to).then_some((from, to))
}

/// Calls `each` with the cells of a ray between two distances within the voxmap, in order, until it says false.
pub(crate) fn walk(
    map: &Voxmap,
    o: Vec3,
    d: Vec3,
    from: f64,
    to: f64,
    mut each: impl FnMut(usize, f64, f64) -> bool,
) -> bool {
    let (min, edge, dims) = (map.min(), map.cell(), map.dims());
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

/// A direction in which a vertex scatters, with the density of [`Vertex::density`], from two numbers of [0, 1).
pub fn scattered(v: &Vertex, u: [f64; 2]) -> Vec3 {
    let (axis, z) = match *v {
        Vertex::Surface { normal, .. } => (normal, (1.0 - u[0]).sqrt()),
        _ => (Vec3::from_array([0.0, 0.0, 1.0]), 1.0 - 2.0 * u[0]),
    };
    around(axis, z, u[1])
}

/// The unit vector at cosine `z` with `axis`, turned by a share of a full turn.
pub fn around(axis: Vec3, z: f64, turn: f64) -> Vec3 {
    let (a, b) = axis.frame();
    let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    (axis * z + (a * cos + b * sin) * r).normalized()
}
