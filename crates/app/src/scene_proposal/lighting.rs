//! The light of a scene: that of the model, with small emitting surfaces as direct light. Where it reaches too little of the model (`own_light`), or there is none: sun
//! and sky where the sky is seen from inside or where the model is a body, otherwise lamps below the ceiling.
//!
//! The sun stands where it reaches the largest number of free points inside. Lamps are squares a little below the ceiling, at free points far from each other.

use super::viewpoints::{ModelInside, free_distance};
use zonal_math::{Vec3, vec3};
use zonal_scene::Scene;
use zonal_transport::Transport;

/// Fraction of the upward rays from inside that leave the model, from which sun and sky light it.
const MIN_OPEN_SKY: f64 = 0.02;
/// Elevations of the sun that are tried, degrees, and number of azimuths.
const SUN_ELEVATIONS: [f64; 3] = [45.0, 60.0, 30.0];
const SUN_AZIMUTHS: usize = 12;
/// Direction of the sun's light on a body: from behind the camera `corner`, to the left.
const SUN_ON_BODY: Vec3 = Vec3 { x: -0.35, y: 0.8, z: -0.75 };
/// Edge of a lamp over the mean distance of the walls, its distance to the ceiling over the height above the point, and most lamps.
const LAMP_EDGE: f64 = 0.12;
const LAMP_DROP: f64 = 0.04;
const MAX_LAMPS: usize = 4;
/// Area of a surface over that of all, below which its emission is direct light, and most of such surfaces.
const MAX_EMITTER_AREA_FRACTION: f64 = 0.05;
const MAX_EMITTERS: usize = 32;
/// Smallest distance of two lamps over the height of the room.
const MIN_LAMP_DISTANCE: f64 = 1.6;

/// The light that a scene gets.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ProposedLight {
    /// Surfaces of the model that emit and have a small area, by name, whose light is direct; `None` of a model without light.
    pub(super) of_model: Option<Vec<String>>,
    /// Light that is added where the model has none, or too little.
    pub(super) added: Option<AddedLight>,
}

/// Light beside that of the model.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum AddedLight {
    /// Sun and sky; the direction of the sun's light.
    SunAndSky(Vec3),
    /// Square lamps that face down: a corner and the edge, m.
    Lamps(Vec<(Vec3, f64)>),
}

impl ProposedLight {
    /// A name for reports.
    pub(super) fn name(&self) -> String {
        let added = self.added.as_ref().map(|added| match added {
            AddedLight::SunAndSky(_) => "sun and sky",
            AddedLight::Lamps(_) => "lamps below the ceiling",
        });
        match (&self.of_model, added) {
            (_, None) => "that of the model".into(),
            (None, Some(added)) => added.into(),
            (Some(_), Some(added)) => format!("that of the model, which lights little of it, and {added}"),
        }
    }
}

/// The light for a model: its own if it has any, and another where its own reaches too little of it (`own_light`).
pub(super) fn propose(transport: &Transport, inside: Option<&ModelInside>, is_lit: bool) -> ProposedLight {
    let of_model = emitting_surfaces(transport.scene());
    let added = (!is_lit).then(|| match inside {
        None => AddedLight::SunAndSky(SUN_ON_BODY.normalized()),
        Some(inside) if inside.open_sky() >= MIN_OPEN_SKY => {
            AddedLight::SunAndSky(sun_into(transport, inside))
        }
        Some(inside) => AddedLight::Lamps(lamps(transport, inside)),
    });
    ProposedLight { of_model, added }
}

/// The names of the surfaces that emit and are small, from the brightest on; `None` of a model without light.
fn emitting_surfaces(scene: &Scene) -> Option<Vec<String>> {
    let mut areas = vec![0.0; scene.surfaces().len()];
    scene.facets().iter().for_each(|f| areas[f.surface] += f.plate.area());
    let all: f64 = areas.iter().sum();
    let mut emitting: Vec<(f64, usize)> = scene
        .surfaces()
        .iter()
        .enumerate()
        .map(|(i, s)| (areas[i] * s.emission.max_element(), i))
        .filter(|(power, _)| *power > 0.0)
        .collect();
    if emitting.is_empty() && scene.lights().is_empty() {
        return None;
    }
    emitting.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let small = emitting.into_iter().map(|(_, i)| i).filter(|i| areas[*i] < MAX_EMITTER_AREA_FRACTION * all);
    Some(small.take(MAX_EMITTERS).map(|i| scene.surfaces()[i].name.clone()).collect())
}

/// The direction of sunlight that reaches most free points, or the floor below them.
fn sun_into(transport: &Transport, inside: &ModelInside) -> Vec3 {
    let candidates = SUN_ELEVATIONS.into_iter().flat_map(|elevation| {
        let (sine, cosine) = elevation.to_radians().sin_cos();
        (0..SUN_AZIMUTHS).map(move |k| {
            let (s, c) = (std::f64::consts::TAU * (k as f64 + 0.35) / SUN_AZIMUTHS as f64).sin_cos();
            vec3(cosine * c, cosine * s, -sine)
        })
    });
    let reached = |light: Vec3| {
        inside.points().filter(|p| free_distance(transport, *p, light * -1.0).is_none()).count()
    };
    // Of directions that reach as many points, the first.
    let mut best = (SUN_ON_BODY.normalized(), 0);
    for light in candidates {
        let count = reached(light);
        if count > best.1 {
            best = (light, count);
        }
    }
    best.0
}

/// Lamps below the ceiling above free points that lie apart.
fn lamps(transport: &Transport, inside: &ModelInside) -> Vec<(Vec3, f64)> {
    let up = vec3(0.0, 0.0, 1.0);
    let mut found: Vec<(Vec3, f64)> = Vec::new();
    let mut centres: Vec<Vec3> = Vec::new();
    for p in std::iter::once(inside.centre()).chain(inside.points()) {
        let (Some(rise), Some(fall)) =
            (free_distance(transport, p, up), free_distance(transport, p, up * -1.0))
        else {
            continue;
        };
        let height = rise + fall;
        let far = |c: &Vec3| vec3(c.x - p.x, c.y - p.y, 0.0).length() > MIN_LAMP_DISTANCE * height;
        if found.len() == MAX_LAMPS || !centres.iter().all(far) {
            continue;
        }
        let edge = LAMP_EDGE * height.min(inside_width(transport, p));
        let centre = p + up * (rise - LAMP_DROP * height);
        found.push((centre - vec3(0.5 * edge, 0.5 * edge, 0.0), edge));
        centres.push(p);
    }
    found
}

/// The smallest free distance along the horizontal axes, both ways together, m.
fn inside_width(transport: &Transport, p: Vec3) -> f64 {
    let run = |d: Vec3| free_distance(transport, p, d).unwrap_or(f64::INFINITY);
    let across = [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)].map(|d| run(d) + run(d * -1.0));
    across[0].min(across[1])
}
