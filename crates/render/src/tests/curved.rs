//! Facets with vertex normals: pictures and baked light are those of the curved surface.

use crate::bake::{BakeOptions, bake};
use crate::integrator::node_lattice::Viewpoint;
use crate::integrator::radiance::Integrator;
use crate::integrator::ray_sampler::RaySampler;
use crate::test_scenes::{quad, solution, sun, surface};
use crate::view_ray::ViewRay;
use std::f64::consts::PI;
use zonal_math::{Vec3, low_discrepancy, vec3};
use zonal_scene::{
    Bands, Facet, Light, NoProgress, NormalMap, Plate, SceneParts, ShadingNormals, SidedFacet, Sides,
    Solution, Surroundings, Texture,
};
use zonal_transport::Transport;

/// Reflectance of the ball.
const RHO: f64 = 0.5;

/// The unit ball of 32 triangles, with or without the normals of the ball at its vertices.
fn ball(curved: bool) -> SceneParts {
    let mut facets = Vec::new();
    let mut shading = ShadingNormals::default();
    let mut add = |a: Vec3, b: Vec3, c: Vec3| {
        let facet = Facet { surface: 0, plate: Plate::triangle(a, b, c), uv: [[0.0; 2]; 3] };
        if curved {
            assert_eq!(shading.push(facets.len(), &facet, &[a, b, c, c]), 0);
        }
        facets.push(facet);
    };
    let half = |a: Vec3, b: Vec3| (a + b).normalized();
    for k in 0..8 {
        let sign = |bit: usize| if k >> bit & 1 == 0 { 1.0 } else { -1.0 };
        let (x, y, z) = (vec3(sign(0), 0.0, 0.0), vec3(0.0, sign(1), 0.0), vec3(0.0, 0.0, sign(2)));
        let (x, y) = if sign(0) * sign(1) * sign(2) > 0.0 { (x, y) } else { (y, x) };
        let (xy, yz, zx) = (half(x, y), half(y, z), half(z, x));
        for [a, b, c] in [[x, xy, zx], [xy, y, yz], [zx, yz, z], [xy, yz, zx]] {
            add(a, b, c);
        }
    }
    let mut ball = surface("ball", RHO, 0.0);
    ball.sides = Sides::Front;
    let options = zonal_scene::SolveOptions { patch_size: Some(2.0), ..Default::default() };
    SceneParts { surfaces: vec![ball], facets, shading, options, ..SceneParts::default() }
}

/// Directions from which the ball is seen.
fn directions() -> impl Iterator<Item = Vec3> {
    (0..400).map(|k| {
        let [s, t] = low_discrepancy::r2(k, [0.1, 0.7]);
        let (z, angle) = (2.0 * s - 1.0, 2.0 * PI * t);
        let r = (1.0 - z * z).sqrt();
        vec3(r * angle.cos(), r * angle.sin(), z)
    })
}

/// The largest difference between the irradiance of a ball and that of its picture, over `scale`, W/m².
fn worst(s: &Solution, integrator: &Integrator, exact: impl Fn(Vec3) -> f64, scale: f64) -> f64 {
    let transport = Transport::new(&s.scene);
    directions().fold(0.0, |worst: f64, d| {
        let ray = ViewRay { origin: d * 3.0, dir: -d };
        let hit = transport.closest_hit(ray.origin, ray.dir, 0.0, 10.0).unwrap();
        // The normal between those of the corners differs from the direction by a few degrees on triangles as large as these.
        let at = s.scene.curved_point(SidedFacet { facet: hit.facet, front: true }, [hit.u, hit.v], 0.0);
        let normal = at.map_or(d, |at| at.normal);
        let h = integrator.radiance(ray, RaySampler::of_ray(0, 4, [0.3, 0.6, 0.9])).first() * PI / RHO;
        worst.max((h - exact(normal)).abs() / scale)
    })
}

#[test]
fn sunlight_and_its_terminator_are_those_of_the_ball() {
    let towards = vec3(0.3, -0.5, 0.8).normalized();
    let error = |curved: bool| {
        let parts = SceneParts { lights: vec![sun(-towards, 0.0)], ..ball(curved) };
        let s = solution(parts, |_, _| 0.0, |_| 0.0);
        let transport = Transport::new(&s.scene);
        worst(&s, &Integrator::new(&s, &transport), |n| n.dot(towards).max(0.0), 1.0)
    };
    let (curved, flat) = (error(true), error(false));
    assert!(curved < 1e-6, "{curved:.3}");
    assert!(flat > 0.2, "{flat:.3}");
}

#[test]
fn uniform_surroundings_give_one_irradiance_with_and_without_a_gather() {
    let surroundings = Surroundings { radiance: Bands::splat(2.0), ..Default::default() };
    let s = solution(SceneParts { surroundings, ..ball(true) }, |_, _| 2.0 * PI, |_| 0.0);
    let transport = Transport::new(&s.scene);
    let mut interpolated = Integrator::new(&s, &transport);
    interpolated.look_from(Viewpoint { origin: vec3(0.0, 0.0, 3.0), pixel_angle: 1e-3 });
    let gathered = Integrator::new(&s, &transport).with_gather(16);
    for integrator in [&interpolated, &gathered] {
        let off = worst(&s, integrator, |_| 2.0 * PI, 2.0 * PI);
        assert!(off < 1e-6, "{off:.2e}");
    }
}

#[test]
fn indirect_light_varies_over_the_ball_as_over_a_sphere() {
    // Light from above alone, whose irradiance of a sphere is 1 + n_z; the mean over a facet is that of its own normal.
    let error = |curved: bool, patch_size: f64| {
        let mut parts = ball(curved);
        parts.options.patch_size = Some(patch_size);
        let s = solution(parts, |_, n| 1.0 + n.z, |_| 0.0);
        let transport = Transport::new(&s.scene);
        worst(&s, &Integrator::new(&s, &transport), |n| 1.0 + n.z, 1.0)
    };
    // One patch a facet, and many; the facets span 45 degrees.
    for size in [2.0, 0.15] {
        let (curved, flat) = (error(true, size), error(false, size));
        assert!(curved < 0.25 && curved < 0.5 * flat, "{size}: {curved:.3}, flat {flat:.3}");
    }
}

// Guards (pictures): no picture shows light through a wall.
#[test]
fn no_light_comes_through_a_wall_with_tilted_normals() {
    let wall = quad(0, vec3(-1.0, -1.0, 0.0), vec3(2.0, 0.0, 0.0), vec3(0.0, 2.0, 0.0));
    let mut shading = ShadingNormals::default();
    let tilted = vec3(0.8, 0.0, 0.6);
    assert_eq!(shading.push(0, &wall, &[tilted; 4]), 0);
    let towards = vec3(0.9, 0.0, -0.4).normalized();
    let parts = SceneParts {
        surfaces: vec![surface("wall", RHO, 0.0)],
        facets: vec![wall],
        shading,
        lights: vec![sun(-towards, 0.0)],
        ..SceneParts::default()
    };
    let s = solution(parts, |_, _| 0.0, |_| 0.0);
    let transport = Transport::new(&s.scene);
    let integrator = Integrator::new(&s, &transport);
    for k in 0..200 {
        let [x, y] = low_discrepancy::r2(k, [0.0; 2]).map(|x| 1.8 * x - 0.9);
        let ray = ViewRay { origin: vec3(x, y, 1.0), dir: vec3(0.0, 0.0, -1.0) };
        let l = integrator.radiance(ray, RaySampler::of_ray(0, 1, [0.5; 3]));
        assert_eq!(l, Bands::ZERO, "the sun is behind the wall: {x} {y}");
    }
}

#[test]
fn baked_vertices_have_the_normals_and_the_light_of_the_ball() {
    let towards = vec3(0.3, -0.5, 0.8).normalized();
    let light = |curved: bool| {
        let parts = SceneParts { lights: vec![sun(-towards, 0.0)], ..ball(curved) };
        bake(&solution(parts, |_, _| 0.0, |_| 0.0), &BakeOptions::default(), &NoProgress).surfaces
    };
    let error = |curved: bool| {
        let mesh = light(curved);
        let vertices = mesh.positions.iter().zip(&mesh.irradiance[0]).map(|(p, h)| {
            let n = Vec3::from_array(p.map(f64::from)).normalized();
            (f64::from(h[0]) - n.dot(towards).max(0.0)).abs()
        });
        vertices.fold(0.0, f64::max)
    };
    let (curved, flat) = (error(true), error(false));
    assert!(curved < 0.1 && flat > 0.3, "{curved:.3} {flat:.3}");
    let mesh = light(true);
    for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
        let [p, n] = [p, n].map(|v| Vec3::from_array(v.map(f64::from)));
        assert!(n.dot(p.normalized()) > 0.98, "{p:?} {n:?}");
    }
}

#[test]
fn a_normal_map_turns_direct_light() {
    let plate = Facet {
        uv: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        ..quad(0, Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0))
    };
    let radiance = |maps: Vec<NormalMap>| {
        let texture = Texture { width: 1, height: 1, pixels: vec![[0.8, 0.5, 0.9]] };
        let parts = SceneParts {
            surfaces: vec![surface("plate", RHO, 0.0)],
            facets: vec![plate],
            textures: vec![texture],
            shading: {
                let mut s = ShadingNormals::default();
                s.maps = maps;
                s
            },
            lights: vec![Light::Sun {
                name: "sun".into(),
                direction: vec3(-0.6, 0.0, -0.8),
                irradiance: Bands::ONE,
                angular_diameter: 0.0,
            }],
            ..SceneParts::default()
        };
        let s = solution(parts, |_, _| 0.0, |_| 0.0);
        let transport = Transport::new(&s.scene);
        let ray = ViewRay { origin: vec3(0.4, 0.3, 1.0), dir: vec3(0.0, 0.0, -1.0) };
        let l = Integrator::new(&s, &transport).radiance(ray, RaySampler::of_ray(0, 1, [0.5; 3]));
        l.first() * PI / RHO
    };
    // The vector of the map is (0.6, 0, 0.8): that of the sun.
    assert!((radiance(Vec::new()) - 0.8).abs() < 1e-6);
    let turned = radiance(vec![NormalMap { surface: 0, texture: 0, scale: 1.0 }]);
    assert!((turned - 1.0).abs() < 1e-6, "{turned}");
}
