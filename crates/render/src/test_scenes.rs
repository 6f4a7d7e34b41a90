//! Scenes and solutions for the tests of the renderer.

use crate::{Image, RenderOptions};
use std::f64::consts::PI;
use zonal_math::{Vec3, vec3};
use zonal_scene::Fields;
use zonal_scene::{Bands, Camera, Light, Plate, Report, Solution, Surroundings, VoxelGrid};
use zonal_scene::{Facet, Pane, Scene, SceneParts, Sides, SolveOptions, Surface};
use zonal_transport::{Transport, build_zones};

pub(crate) fn surface(name: &str, rho: f64, emission: f64) -> Surface {
    Surface {
        name: name.into(),
        reflectance: Bands::splat(rho),
        emission: Bands::splat(emission),
        sides: Sides::Both,
        ..Surface::default()
    }
}

pub(crate) fn quad(surface: usize, o: Vec3, e1: Vec3, e2: Vec3) -> Facet {
    Facet { surface, plate: Plate::parallelogram(o, e1, e2), uv: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]] }
}

/// The six walls of a box, fronts inwards.
pub(crate) fn walls(lo: Vec3, hi: Vec3) -> Vec<Facet> {
    let d = hi - lo;
    let (x, y, z) = (vec3(d.x, 0.0, 0.0), vec3(0.0, d.y, 0.0), vec3(0.0, 0.0, d.z));
    vec![
        quad(0, lo, x, y),
        quad(0, lo + z, y, x),
        quad(0, lo, y, z),
        quad(0, lo + x, z, y),
        quad(0, lo, z, x),
        quad(0, lo + y, x, z),
    ]
}

pub(crate) fn medium(lo: Vec3, hi: Vec3, dims: [usize; 3], kappa: f64, albedo: f64) -> VoxelGrid {
    let d = hi - lo;
    let cell = vec3(d.x / dims[0] as f64, d.y / dims[1] as f64, d.z / dims[2] as f64);
    let mut map = VoxelGrid::new(lo, cell, dims).unwrap();
    (0..map.len())
        .for_each(|i| map.set(i, Bands::splat(kappa), Bands::splat(albedo), Bands::ZERO, Bands::ZERO));
    map.seal().unwrap()
}

/// A pane of optical depth 0.5, 0 and 0.1 at normal incidence.
pub(crate) fn glass(plate: Plate) -> Pane {
    Pane {
        name: "glass".into(),
        plates: vec![plate],
        thickness: 0.01,
        extinction: Bands::from_rgb([50.0, 0.0, 10.0]),
        albedo: Bands::ZERO,
        emission: Bands::ZERO,
    }
}

pub(crate) fn camera(origin: Vec3, target: Vec3, fov: f64) -> Camera {
    Camera { up: vec3(0.01, 0.02, 1.0), fov, ..Camera::look_at(origin.array(), target.array()) }
}

pub(crate) fn size(width: usize, height: usize) -> RenderOptions {
    RenderOptions { width, height, ..RenderOptions::default() }
}

/// A solution with prescribed indirect fields: H of a patch (centre, normal), B_ind of a volume (centre).
pub(crate) fn solution(
    parts: SceneParts,
    h: impl Fn(Vec3, Vec3) -> f64,
    b: impl Fn(Vec3) -> f64,
) -> Solution {
    solution_of(parts, &h, &b)
}

/// Compiled once, where [`solution`] has a copy for each pair of closures.
fn solution_of(parts: SceneParts, h: &dyn Fn(Vec3, Vec3) -> f64, b: &dyn Fn(Vec3) -> f64) -> Solution {
    let parts = SceneParts {
        options: SolveOptions {
            patch_size: Some(parts.options.patch_size.unwrap_or(0.25)),
            ..parts.options.clone()
        },
        ..parts
    };
    let scene = Scene::new(parts).unwrap();
    let zones = build_zones(&scene, &Transport::new(&scene)).unwrap();
    let mut fields = Fields::default();
    let mut push = |radiosity: f64, incident: f64| {
        fields.radiosity.push(Bands::splat(radiosity));
        fields.incident.push(Bands::splat(incident));
        fields.direct.push(Bands::ZERO);
        fields.error.push(Bands::ZERO);
    };
    for p in &zones.patches {
        let x = h(p.plate.centre(), p.normal);
        push(p.emission.first() + p.reflectance.first() * x, x);
    }
    zones.voxels.iter().for_each(|v| push(b(v.centre), 4.0 * b(v.centre)));
    zones.panes.iter().for_each(|p| push(b(p.plate.centre()), 0.0));
    Solution {
        scene,
        zones,
        fields,
        groups: Vec::new(),
        report: Report::default(),
        further_blocks: Vec::new(),
        scene_hash: String::new(),
        version: String::new(),
    }
}

/// Largest relative deviation of the pixels from a radiance.
pub(crate) fn worst(image: &Image, expected: f64) -> f64 {
    image.pixels.iter().flatten().fold(0.0, |m, x| (*x as f64 / expected - 1.0).abs().max(m))
}

/// An isothermal enclosure of radiosity 1 with a medium and an inner wall.
pub(crate) fn furnace() -> SceneParts {
    let (lo, hi) = (vec3(-1.0, -1.0, 0.0), vec3(1.0, 1.0, 1.5));
    let mut facets = walls(lo, hi);
    // An oblique wall inside, which divides voxels.
    facets.push(quad(0, vec3(-0.6, -0.3, 0.2), vec3(0.9, 0.5, 0.1), vec3(0.1, 0.0, 0.8)));
    SceneParts {
        surfaces: vec![surface("wall", 0.4, 0.6)],
        facets,
        voxel_grid: Some(medium(lo, hi, [7, 6, 5], 1.3, 0.5)),
        surroundings: Surroundings { radiance: Bands::splat(1.0 / PI), ..Default::default() },
        ..SceneParts::default()
    }
}

pub(crate) fn sun(direction: Vec3, angular_diameter: f64) -> Light {
    Light::Sun {
        name: "sun".into(),
        direction: direction.normalized(),
        irradiance: Bands::from_rgb([1.0, 2.0, 3.0]),
        angular_diameter,
    }
}
