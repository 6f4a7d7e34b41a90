//! The sources of walks: every element that emits in a band, with its power, and the rays of lights.

use super::optics::WalkOptics;
use super::walk_scene::WalkScene;
use crate::path_tracer::flight::direction_about;
use crate::rng::Rng;
use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_scene::{Band, Light, Sides, Zones};

/// Most trials to draw a direction of a light: its beam would fill less than a millionth of the sphere.
const MAX_DIRECTION_TRIALS: usize = 1 << 22;

/// A source.
#[derive(Clone, Copy, Debug)]
pub(super) enum EmissionElement {
    /// A facet, and whether its front emits or its back.
    Facet(u32, bool),
    /// A zone.
    Zone(usize),
    /// A cell of the medium, with uniform emission where it is free.
    Cell(usize),
    /// A plate of a pane.
    Plate(usize),
    /// A sun, a point light or a sky that is not uniform, by its number among the lights of the scene, in a band.
    Light(usize, Band),
    /// Uniform skies and surroundings.
    Surroundings,
}

/// All sources of a band.
pub(super) struct EmissionTable {
    list: Vec<(EmissionElement, f64)>,
    /// Running sums of the magnitudes, W.
    cumulative: Vec<f64>,
    /// Sum of the magnitudes, W.
    pub power: f64,
    /// Sum over the medium, W.
    pub medium: f64,
}

impl EmissionTable {
    /// Collects the sources of band `b`: of `zones`, or of the scene itself.
    pub(super) fn new(
        walk_scene: &WalkScene,
        optics: &WalkOptics,
        zones: Option<&Zones>,
        b: Band,
    ) -> EmissionTable {
        let mut list = match zones {
            Some(z) => zone_sources(z, optics, b),
            None => scene_sources(walk_scene, optics, b),
        };
        list.extend(light_sources(walk_scene, b));
        list.retain(|s| s.1 != 0.0);
        let voxels = zones.map_or(0..0, |z| z.voxel_offset()..z.pane_offset());
        let in_medium = |t: &EmissionElement| match t {
            EmissionElement::Cell(_) => true,
            EmissionElement::Zone(i) => voxels.contains(i),
            _ => false,
        };
        let medium = list.iter().filter(|s| in_medium(&s.0)).map(|s| s.1.abs()).sum();
        let mut sum = 0.0;
        let cumulative = list
            .iter()
            .map(|s| {
                sum += s.1.abs();
                sum
            })
            .collect();
        EmissionTable { list, cumulative, power: sum, medium }
    }

    /// The source at the fraction `u` of the power, and its sign.
    pub(super) fn at(&self, u: f64) -> (EmissionElement, f64) {
        let k = self.cumulative.partition_point(|&x| x <= u * self.power).min(self.list.len() - 1);
        (self.list[k].0, self.list[k].1.signum())
    }
}

/// The emission of zones. Surfaces that are direct light emit as zones as well: their emission is uniform on each.
fn zone_sources(z: &Zones, optics: &WalkOptics, b: Band) -> Vec<(EmissionElement, f64)> {
    let mut list = Vec::new();
    for (i, p) in z.patches.iter().enumerate() {
        list.push((EmissionElement::Zone(i), optics.surfaces[p.surface].emission[b] * p.area));
    }
    for (k, v) in z.voxels.iter().enumerate() {
        let power = optics.cells[v.cell].emission[b] * v.volume;
        list.push((EmissionElement::Zone(z.voxel_index(k)), power));
    }
    for (k, p) in z.panes.iter().enumerate() {
        let power = optics.panes[p.pane].emission[b] * p.area * p.thickness;
        list.push((EmissionElement::Zone(z.pane_index(k)), power));
    }
    list
}

/// The emission of facets, cells and panes.
fn scene_sources(walk_scene: &WalkScene, optics: &WalkOptics, b: Band) -> Vec<(EmissionElement, f64)> {
    let scene = walk_scene.scene;
    let mut list = Vec::new();
    for (k, f) in (0u32..).zip(scene.facets()) {
        let power = optics.surfaces[f.surface].emission[b] * f.plate.area();
        list.push((EmissionElement::Facet(k, true), power));
        if scene.surfaces()[f.surface].sides == Sides::Both {
            list.push((EmissionElement::Facet(k, false), power));
        }
    }
    if let Some(grid) = scene.voxel_grid() {
        let volume = grid.cell().product();
        list.extend(
            (0..grid.len()).map(|c| (EmissionElement::Cell(c), optics.cells[c].emission[b] * volume)),
        );
    }
    for (k, (pane, q)) in walk_scene.plates.iter().enumerate() {
        let power = optics.panes[*pane].emission[b] * q.area() * scene.panes()[*pane].thickness;
        list.push((EmissionElement::Plate(k), power));
    }
    list
}

/// The power of point lights, and of suns, skies and surroundings through a sphere around the scene.
fn light_sources(walk_scene: &WalkScene, b: Band) -> Vec<(EmissionElement, f64)> {
    let scene = walk_scene.scene;
    let mut list = Vec::new();
    let (_, r) = walk_scene.bounding_sphere();
    let mut radiance = match scene.thermal() {
        Some(t) => t.surroundings_radiance()[b],
        None => scene.surroundings().radiance[b],
    };
    for (l, light) in scene.lights().iter().enumerate() {
        match light {
            Light::Sun { irradiance, angular_diameter, .. } => {
                let cos = (0.5 * angular_diameter).cos();
                let flux = 2.0 * irradiance[b] / (1.0 + cos);
                list.push((EmissionElement::Light(l, b), flux * PI * r * r));
            }
            Light::Sky { radiance: sky, distribution, .. } if distribution.is_uniform() => radiance += sky[b],
            Light::Sky { radiance: sky, distribution, .. } => {
                let fluence = sky[b] * distribution.solid_angle_integral()[b];
                list.push((EmissionElement::Light(l, b), fluence * PI * r * r));
            }
            Light::Point { intensity, distribution, .. } => {
                let power = intensity[b] * distribution.solid_angle_integral();
                list.push((EmissionElement::Light(l, b), power));
            }
            Light::Emitter { .. } => {}
        }
    }
    list.push((EmissionElement::Surroundings, radiance * PI * 4.0 * PI * r * r));
    list
}

/// A random start and direction of a ray of a light: a sun or a sky has starts before the scene. `None` for an emitter, and if no direction is found.
pub(super) fn leave_light(
    light: &Light,
    band: Band,
    walk_scene: &WalkScene,
    rng: &mut Rng,
) -> Option<(Vec3, Vec3)> {
    match light {
        Light::Sun { direction, angular_diameter, .. } => {
            let cos = (0.5 * angular_diameter).cos();
            let d = -direction_about(-*direction, 1.0 - rng.uniform() * (1.0 - cos), rng.uniform());
            Some((on_disc(walk_scene, d, rng), d))
        }
        Light::Sky { distribution, .. } => {
            let most = distribution.upper_bound()[band];
            let d = -draw_direction(most, |d| distribution.relative(d)[band], rng)?;
            Some((on_disc(walk_scene, d, rng), d))
        }
        Light::Point { position, distribution, .. } => {
            let most = distribution.upper_bound(Vec3::from_array([0.0, 0.0, 1.0]), PI);
            Some((*position, draw_direction(most, |d| distribution.relative(d), rng)?))
        }
        Light::Emitter { .. } => None,
    }
}

/// A direction of density f ≤ `most` by rejection, independent of tables and closed forms of the distribution.
fn draw_direction(most: f64, f: impl Fn(Vec3) -> f64, rng: &mut Rng) -> Option<Vec3> {
    (0..MAX_DIRECTION_TRIALS).find_map(|_| {
        let d = rng.unit_vector();
        (rng.uniform() * most < f(d)).then_some(d)
    })
}

/// A point of a disc before the scene, normal to the direction `d` of travel.
fn on_disc(walk_scene: &WalkScene, d: Vec3, rng: &mut Rng) -> Vec3 {
    let (centre, r) = walk_scene.bounding_sphere();
    let (a, b) = d.frame();
    let (radius, turn) = (r * rng.uniform().sqrt(), rng.uniform_in(0.0, std::f64::consts::TAU));
    centre - d * (2.0 * r) + (a * turn.cos() + b * turn.sin()) * radius
}
