//! Where to look at a model from: points inside it with free space around, found by rays.
//!
//! Candidates lie on a lattice in the bounding box. From each a set of directions, evenly spread over the sphere, is followed to the first surface. A candidate is *inside*
//! if most rays hit something, and free if none hits close by. Its spaciousness is the mean distance of the horizontal hits, where a ray that leaves the model counts as 0:
//! a point in a window is not spacious. The first camera stands at the end of the longest free run through the most spacious point and looks along it; the second looks at
//! that point from the free point farthest from the first camera; the third looks down on it from below the ceiling. A run that leaves the model by a window ends at
//! its last point inside, by the same test. A model without an inside is seen from outside, from three directions; so is one whose rays from inside meet the backs of its
//! faces, such as a figure, unless it holds a light.

use zonal_math::{Vec3, vec3};
use zonal_scene::{Camera, Scene};
use zonal_transport::{Hit, Transport};

/// Candidates along each axis of the bounding box.
const CANDIDATES_PER_AXIS: [usize; 3] = [9, 9, 5];
/// Directions of each candidate.
const DIRECTION_COUNT: usize = 96;
/// Fraction of rays that hit something inside.
const MIN_HIT_FRACTION: f64 = 0.6;
/// Fraction of the clear candidates that are inside, from which the model has an inside.
const MIN_INSIDE_FRACTION: f64 = 0.2;
/// Fraction of the hits from inside on fronts of faces, from which an unlit model has an inside.
const MIN_FRONT_FRACTION: f64 = 0.5;
/// Distance of a free point to the nearest surface over the smallest extent.
const MIN_CLEARANCE: f64 = 0.05;
/// Height of the eye above the floor, m, and its largest fraction of the height of the room.
const EYE_HEIGHT: f64 = 1.6;
const MAX_EYE_FRACTION: f64 = 0.45;
/// Fraction of the free run that a camera steps back, and positions along it that are tried.
const STEP_BACK: f64 = 0.85;
const RUN_STEPS: usize = 24;
/// Angle of view, degrees.
const INSIDE_FOV: f64 = 75.0;
/// Largest sine of the elevation of a horizontal direction.
const MAX_HORIZONTAL_SINE: f64 = 0.25;
/// Width over height of the pictures for which views from outside fit.
const PICTURE_ASPECT: f64 = 4.0 / 3.0;

/// A point with free space around.
#[derive(Clone, Copy, Debug)]
struct FreePoint {
    at: Vec3,
    /// Mean distance of the horizontal hits, m; rays that leave the model count as 0.
    spaciousness: f64,
    /// Fraction of the upward rays that leave the model.
    open_sky: f64,
    /// Fraction of the hits that are on fronts of faces.
    front: f64,
}

/// The inside of a model.
#[derive(Clone, Debug)]
pub(super) struct ModelInside {
    points: Vec<FreePoint>,
    /// The point with most space around it.
    centre: FreePoint,
}

impl ModelInside {
    /// Free points inside the model.
    pub(super) fn points(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.points.iter().map(|p| p.at)
    }
    /// The point with most space around it.
    pub(super) fn centre(&self) -> Vec3 {
        self.centre.at
    }
    /// Fraction of the upward rays from inside that leave the model.
    pub(super) fn open_sky(&self) -> f64 {
        self.points.iter().map(|p| p.open_sky).sum::<f64>() / self.points.len().max(1) as f64
    }
}

/// Evenly spread directions: a spherical Fibonacci lattice.
fn directions() -> impl Iterator<Item = Vec3> {
    let golden = std::f64::consts::TAU * (0.5 * (5f64.sqrt() - 1.0));
    (0..DIRECTION_COUNT).map(move |i| {
        let z = 1.0 - (2 * i + 1) as f64 / DIRECTION_COUNT as f64;
        let (r, phi) = ((1.0 - z * z).sqrt(), golden * i as f64);
        vec3(r * phi.cos(), r * phi.sin(), z)
    })
}

/// The first surface.
fn first_hit(transport: &Transport, from: Vec3, towards: Vec3) -> Option<Hit> {
    transport.closest_hit(from, towards, 0.0, f64::INFINITY)
}

/// Distance to the first surface, m.
pub(super) fn free_distance(transport: &Transport, from: Vec3, towards: Vec3) -> Option<f64> {
    first_hit(transport, from, towards).map(|hit| hit.t)
}

/// The inside of a scene; `None` of a body that is seen from outside.
pub(super) fn find_inside(transport: &Transport, is_lit: bool) -> Option<ModelInside> {
    let (low, high) = transport.scene().bounds();
    let size = high - low;
    let clearance = MIN_CLEARANCE * size.x.min(size.y).min(size.z);
    let (mut clear, mut points) = (0usize, Vec::new());
    let [nx, ny, nz] = CANDIDATES_PER_AXIS;
    for k in 0..nx * ny * nz {
        let [i, j, l] = [k / (ny * nz), k / nz % ny, k % nz];
        let fraction =
            vec3((i as f64 + 0.5) / nx as f64, (j as f64 + 0.5) / ny as f64, (l as f64 + 0.5) / nz as f64);
        let at = low + size.scale(fraction);
        if transport.inside_solid(at) {
            continue;
        }
        let Some((point, hits)) = explore(transport, at, clearance) else { continue };
        clear += 1;
        if hits >= MIN_HIT_FRACTION {
            points.push(point);
        }
    }
    let front = points.iter().map(|p| p.front).sum::<f64>() / points.len().max(1) as f64;
    let is_inside =
        points.len() as f64 > MIN_INSIDE_FRACTION * clear as f64 && (is_lit || front >= MIN_FRONT_FRACTION);
    let centre = points.iter().copied().max_by(|a, b| a.spaciousness.total_cmp(&b.spaciousness))?;
    is_inside.then_some(ModelInside { points, centre })
}

/// A candidate and the fraction of its rays that hit something; `None` close to a surface.
fn explore(transport: &Transport, at: Vec3, clearance: f64) -> Option<(FreePoint, f64)> {
    let (mut hits, mut fronts, mut up, mut sky) = (0usize, 0usize, 0usize, 0usize);
    let (mut horizontal, mut sum) = (0usize, 0.0);
    for d in directions() {
        up += usize::from(d.z > 0.0);
        horizontal += usize::from(d.z.abs() < MAX_HORIZONTAL_SINE);
        let Some(hit) = first_hit(transport, at, d) else {
            sky += usize::from(d.z > 0.0);
            continue;
        };
        if hit.t < clearance {
            return None;
        }
        hits += 1;
        fronts += usize::from(hit.front);
        if d.z.abs() < MAX_HORIZONTAL_SINE {
            sum += hit.t;
        }
    }
    let spaciousness = sum / horizontal.max(1) as f64;
    let open_sky = sky as f64 / up.max(1) as f64;
    let front = fronts as f64 / hits.max(1) as f64;
    Some((FreePoint { at, spaciousness, open_sky, front }, hits as f64 / DIRECTION_COUNT as f64))
}

/// Three cameras for a scene with this inside, or for a body.
pub(super) fn cameras(scene: &Scene, transport: &Transport, inside: Option<&ModelInside>) -> Vec<Camera> {
    match inside {
        Some(inside) => cameras_inside(transport, inside),
        None => {
            let (low, high) = scene.bounds();
            let view =
                |name: &str, forward: Vec3| Camera::framing(low, high, forward, PICTURE_ASPECT).name(name);
            vec![
                view("corner", vec3(-1.0, 1.4, -0.8)),
                view("front", vec3(0.0, 1.0, -0.15)),
                view("side", vec3(-1.0, 0.0, -0.15)),
            ]
        }
    }
}

fn cameras_inside(transport: &Transport, inside: &ModelInside) -> Vec<Camera> {
    let centre = at_eye_height(transport, inside.centre.at);
    let run = |d: Vec3| inside_run(transport, centre, d);
    // The longest free run through the point, forwards and backwards.
    let level = (0..16).map(|k| {
        let (s, c) = (std::f64::consts::TAU * k as f64 / 16.0).sin_cos();
        vec3(c, s, 0.0)
    });
    let runs: Vec<(Vec3, f64)> = level.map(|d| (d, run(d))).collect();
    let opposite = |k: usize| runs[(k + 8) % 16].1;
    let length = |k: &usize| runs[*k].1 + opposite(*k);
    let best = (0..16).max_by(|a, b| length(a).total_cmp(&length(b))).unwrap_or(0);
    let best = if runs[best].1 < opposite(best) { (best + 8) % 16 } else { best };
    let (along, ahead, behind) = (runs[best].0, runs[best].1, opposite(best));
    let stand = centre - along * behind;
    let first = Camera::look_at(stand.array(), (stand + along).array()).name("along");
    // The free point farthest from there that sees the centre.
    let sees = |p: &Vec3| !transport.occluded(*p, centre) && is_inside(transport, *p);
    let eyes = inside.points().map(|p| at_eye_height(transport, p)).filter(sees);
    let farthest = eyes.max_by(|a, b| (*a - stand).length2().total_cmp(&(*b - stand).length2()));
    let across = farthest.filter(|p| (*p - centre).length() > 0.1 * inside.centre.spaciousness);
    let second = across.unwrap_or(centre + along * ahead);
    let target = if (second - centre).length() > 0.0 { centre } else { stand };
    let second = Camera::look_at(second.array(), target.array()).name("across");
    // From below the ceiling.
    let rise = inside_run(transport, stand, vec3(0.0, 0.0, 1.0));
    let top = stand + vec3(0.0, 0.0, rise);
    let floor = centre + along * (0.35 * ahead) - vec3(0.0, 0.0, 0.5 * EYE_HEIGHT.min(rise));
    let third = Camera::look_at(top.array(), floor.array()).name("above");
    [first, second, third].map(|c| c.field_of_view_degrees(INSIDE_FOV)).into()
}

/// The length that a camera may move from a point inside, m: a part of the free run, at whose end it is still inside.
fn inside_run(transport: &Transport, from: Vec3, towards: Vec3) -> f64 {
    let free = free_distance(transport, from, towards);
    let run = STEP_BACK * free.unwrap_or_else(|| distance_to_bounds(transport, from, towards));
    let mut lengths = (0..RUN_STEPS).map(|k| run * (RUN_STEPS - k) as f64 / RUN_STEPS as f64);
    lengths.find(|t| is_inside(transport, from + towards * *t)).unwrap_or(0.0)
}

/// True of a point in no solid, from which most rays hit something.
fn is_inside(transport: &Transport, at: Vec3) -> bool {
    !transport.inside_solid(at)
        && explore(transport, at, 0.0).is_some_and(|(_, hits)| hits >= MIN_HIT_FRACTION)
}

/// Distance from a point to the end of the bounding box of the scene, m.
fn distance_to_bounds(transport: &Transport, from: Vec3, towards: Vec3) -> f64 {
    let (low, high) = transport.scene().bounds();
    let ends = (0..3).map(|k| match towards[k] {
        d if d > 0.0 => (high[k] - from[k]) / d,
        d if d < 0.0 => (low[k] - from[k]) / d,
        _ => f64::INFINITY,
    });
    ends.fold(f64::INFINITY, f64::min).max(0.0)
}

/// The point at the height of the eye above the floor below it.
fn at_eye_height(transport: &Transport, p: Vec3) -> Vec3 {
    let down = free_distance(transport, p, vec3(0.0, 0.0, -1.0));
    let up = free_distance(transport, p, vec3(0.0, 0.0, 1.0));
    match (down, up) {
        (Some(down), Some(up)) => {
            let eye = EYE_HEIGHT.min(MAX_EYE_FRACTION * (down + up));
            p + vec3(0.0, 0.0, eye - down)
        }
        (Some(down), None) => p + vec3(0.0, 0.0, EYE_HEIGHT.min(down) - down),
        _ => p,
    }
}
