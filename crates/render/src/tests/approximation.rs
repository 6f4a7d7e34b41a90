//! Approximations of the renderer against exact evaluation: many lights, adaptive sampling, final gather.
//!
//! Guards (pictures): approximations of the renderer agree with exact evaluation: many lights, adaptive pictures, final gather.

use crate::integrator::radiance::Integrator;
use crate::test_scenes::{camera, furnace, medium, quad, size, solution, sun, surface, walls, worst};
use crate::view_ray::ViewRay;
use crate::{RenderOptions, render};
use std::f64::consts::PI;
use zonal_math::{Vec3, low_discrepancy, vec3};
use zonal_scene::{Bands, Facet, Pane, SceneParts, Sides, Surface};
use zonal_scene::{
    Light, LightGroup, LightGroupKind, NoProgress, Plate, SkyDistribution, Solution, ZoneValues,
};
use zonal_transport::Transport;
use zonal_transport::lights::{LightSampler, Receiver};

/// A room full of fog with candles of eight facets each, a shelf, a pane and a sun through a hole of the ceiling.
fn candle_room(candles: usize, sunny: bool) -> SceneParts {
    let (lo, hi) = (vec3(-2.0, -2.0, 0.0), vec3(2.0, 2.0, 2.5));
    let mut facets = walls(lo, hi);
    facets.remove(1);
    for (x, w) in [(-2.0, 1.6), (0.4, 1.6)] {
        facets.push(quad(0, vec3(x, -2.0, 2.5), vec3(0.0, 4.0, 0.0), vec3(w, 0.0, 0.0)));
    }
    facets.push(quad(0, vec3(0.1, -0.5, 0.9), vec3(0.8, 0.0, 0.0), vec3(0.0, 0.8, 0.0)));
    for i in 0..candles {
        let [x, y, z] = low_discrepancy::r3(i, [0.2, 0.7, 0.4]);
        let c = vec3(3.0 * x - 1.5, 3.0 * y - 1.5, 0.6 + 1.2 * z);
        let (a, b, h) = (vec3(0.02, 0.0, 0.0), vec3(0.0, 0.02, 0.0), vec3(0.0, 0.0, 0.05));
        for (p, q) in [(a, b), (b, -a), (-a, -b), (-b, a)] {
            for (plate, _) in
                [(Plate::triangle(c + p, c + q, c + h), 0), (Plate::triangle(c + q, c + p, c - h), 1)]
            {
                facets.push(Facet { surface: 1, plate, uv: [[0.0; 2]; 3] });
            }
        }
    }
    let flame = Surface { sides: Sides::Front, ..surface("flame", 0.0, 400.0) };
    let mut lights = vec![Light::Emitter { surface: 1, name: None }];
    if sunny {
        lights.push(sun(vec3(0.3, 0.1, -1.0), 0.02));
    }
    SceneParts {
        surfaces: vec![surface("wall", 0.5, 0.0), flame],
        facets,
        panes: vec![Pane {
            name: "glass".into(),
            plates: vec![Plate::parallelogram(
                vec3(-0.4, -2.0, 2.5),
                vec3(0.0, 2.0, 0.0),
                vec3(0.8, 0.0, 0.0),
            )],
            thickness: 0.01,
            extinction: Bands::from_rgb([50.0, 0.0, 10.0]),
            albedo: Bands::ZERO,
            emission: Bands::ZERO,
        }],
        voxel_grid: Some(medium(lo, hi, [16, 16, 10], 0.25, 0.8)),
        lights,
        ..SceneParts::default()
    }
}

/// Means of the first band over blocks of 8 × 8 pixels.
fn blocks(pixels: &[f64], width: usize) -> Vec<f64> {
    let across = width / 8;
    let mut out = vec![0.0; across * (pixels.len() / width / 8)];
    pixels.iter().enumerate().for_each(|(i, x)| out[i / width / 8 * across + i % width / 8] += x / 64.0);
    out
}

/// The light group of light 0 with its direct light on every zone by `samples` shadow rays, and a scale.
fn own_group(s: &Solution, transport: &Transport, samples: usize, direct_scale: Bands) -> LightGroup {
    let (light, free) = (LightSampler::new(&s.scene, &s.scene.lights()[0]), Receiver::Free);
    let volume = |z: zonal_scene::VoxelZone| light.gather(transport, z.centre, free, samples, 7);
    let mut direct = vec![Bands::ZERO; s.zones.voxel_offset()];
    direct.extend(s.zones.voxels.iter().map(volume));
    LightGroup {
        kind: LightGroupKind::Light(0),
        direct: ZoneValues::Double(direct),
        direct_scale,
        ..LightGroup::default()
    }
}

#[test]
fn many_lights_in_fog_agree_with_sampled_points() {
    let s = solution(candle_room(30, false), |_, _| 0.0, |_| 0.0);
    let transport = Transport::new(&s.scene);
    let lamp = LightSampler::new(&s.scene, &s.scene.lights()[0]);
    assert!((30..36).contains(&lamp.clusters().len()), "one or two clusters a flame");
    let mut kept = s.clone();
    kept.groups = vec![own_group(&s, &transport, 64, Bands::from_rgb([2.0, 1.0, 0.5]))];
    let reference = Integrator::new(&s, &transport).with_sampled_lights_only();
    let ends = |i: u64| {
        let unit = |k: u64| low_discrepancy::hash_to_unit(6 * i + k);
        let at = |k: u64| vec3(3.8 * unit(k) - 1.9, 3.8 * unit(k + 1) - 1.9, 2.4 * unit(k + 2) + 0.05);
        (at(0), at(3))
    };
    let scattered = |v: &Integrator, i: u64, count: usize| {
        let (from, to): (Vec3, Vec3) = ends(i);
        let ray = ViewRay { origin: from, dir: (to - from).normalized() };
        v.scattered(ray, (to - from).length(), count)
    };
    let green = |x: Bands| x.to_rgb()[1];
    let exact: Vec<f64> = (0..40).map(|i| green(scattered(&reference, i, 3000))).collect();
    let mean = exact.iter().sum::<f64>() / 40.0;
    for s in [&s, &kept] {
        let fast = Integrator::new(s, &transport);
        let found: Vec<f64> = (0..40).map(|i| green(scattered(&fast, i, 4))).collect();
        let off = found.iter().sum::<f64>() / 40.0 / mean - 1.0;
        assert!(off.abs() < 0.03, "{off}");
        // The difference comes from rays that pass a flame at less than its width.
        let square = found.iter().zip(&exact).map(|(f, e)| (f - e).powi(2) / 40.0).sum::<f64>();
        assert!(square.sqrt() < 0.3 * mean, "{} {mean}", square.sqrt());
    }
    // Far from every flame the light is that of the group, with its scale.
    let (plain, scaled) = (Integrator::new(&s, &transport), Integrator::new(&kept, &transport));
    let sum = |v: &Integrator| (0..40).map(|i| scattered(v, i, 4)).sum::<Bands>();
    let [red, _, blue] = (sum(&scaled) / sum(&plain)).to_rgb();
    assert!(red > 1.02 && blue < 0.99, "{red} {blue}");
}

#[test]
fn adaptive_pictures_have_the_block_means_of_exhaustive_ones() {
    let s = solution(candle_room(20, true), |p, _| 0.3 + 0.1 * p.x, |p| 0.2 + 0.05 * p.z);
    let (w, h) = (80, 56);
    let cam = camera(vec3(-1.7, -1.6, 1.4), vec3(0.4, 0.3, 1.2), 75.0);
    let pixels = |samples: usize| {
        let image = render(&s, &cam, &RenderOptions { samples, ..size(w, h) }, &NoProgress);
        image.pixels.iter().map(|p| p[0] as f64).collect::<Vec<_>>()
    };
    let (adaptive, exact) = (blocks(&pixels(0), w), blocks(&pixels(9), w));
    let differences: Vec<f64> = adaptive.iter().zip(&exact).map(|(a, e)| (a / e - 1.0).abs()).collect();
    let mean = differences.iter().sum::<f64>() / differences.len() as f64;
    let worst = differences.iter().fold(0.0, |m: f64, d| m.max(*d));
    let all = adaptive.iter().sum::<f64>() / exact.iter().sum::<f64>() - 1.0;
    assert!(mean < 0.01 && all.abs() < 0.003, "{mean} {all}");
    assert!(worst < 0.15, "{worst}");
}

/// Median over the pixels of the second difference along rows, over the value: grain.
fn grain(pixels: &[f64], width: usize) -> f64 {
    let rows = pixels.chunks(width);
    let of_row = |row: &[f64]| -> Vec<f64> {
        row.windows(3).map(|p| (p[0] - 2.0 * p[1] + p[2]).abs() / (6.0f64.sqrt() * p[1])).collect()
    };
    let mut all: Vec<f64> = rows.flat_map(of_row).collect();
    all.sort_by(f64::total_cmp);
    all[all.len() / 2]
}

#[test]
fn sky_light_of_zones_agrees_with_sampled_directions() {
    let mut parts = candle_room(1, false);
    parts.surfaces[1].emission = Bands::ZERO;
    parts.lights = vec![Light::Sky {
        name: "sky".into(),
        radiance: Bands::ONE,
        distribution: SkyDistribution::uniform(),
    }];
    let s = solution(parts, |_, _| 0.02, |_| 0.0);
    let transport = Transport::new(&s.scene);
    let mut apart = s.clone();
    apart.groups = vec![own_group(&s, &transport, 400, Bands::ONE)];
    let (w, h) = (56, 40);
    let cam = camera(vec3(-1.7, -1.6, 1.4), vec3(0.4, 0.3, 1.2), 75.0);
    let pixels = |s: &Solution, samples: usize| {
        let image = render(s, &cam, &RenderOptions { samples, ..size(w, h) }, &NoProgress);
        image.pixels.iter().map(|p| p[0] as f64).collect::<Vec<_>>()
    };
    let (of_zones, sampled, exact) = (pixels(&apart, 0), pixels(&s, 0), pixels(&apart, 64));
    let (found, wanted) = (blocks(&of_zones, w), blocks(&exact, w));
    let mut off: Vec<f64> = found.iter().zip(&wanted).map(|(a, e)| (a / e - 1.0).abs()).collect();
    off.sort_by(f64::total_cmp);
    let all = found.iter().sum::<f64>() / wanted.iter().sum::<f64>() - 1.0;
    assert!(off[off.len() / 2] < 0.01 && off[off.len() - 1] < 0.06 && all.abs() < 0.01, "{off:?} {all}");
    let [less, more] = [grain(&of_zones, w), grain(&sampled, w)];
    assert!(less < 0.005 && more > 2.0 * less, "{less} {more}");
    assert!(crate::sky_noise(&apart, &size(w, h)).is_none());
    assert!(crate::sky_noise(&s, &size(w, h)).is_some_and(|d| d.to_string().contains("'sky'")));
}

#[test]
fn final_gather_in_furnace_has_its_radiance() {
    let s = solution(furnace(), |_, _| 1.0, |_| 1.0);
    let cam = camera(vec3(0.3, -0.8, 0.7), vec3(0.0, 0.1, 0.6), 80.0);
    let options = RenderOptions { gather: 8, ..size(32, 24) };
    let image = render(&s, &cam, &options, &NoProgress);
    assert!(worst(&image, 1.0 / PI) < 1e-6, "{}", worst(&image, 1.0 / PI));
}

#[test]
fn clustered_light_agrees_with_facet_samples() {
    let s = solution(candle_room(20, false), |_, _| 0.0, |_| 0.0);
    let transport = Transport::new(&s.scene);
    let lamp = LightSampler::new(&s.scene, &s.scene.lights()[0]);
    let receiver = Receiver::Surface(vec3(0.0, 0.0, 1.0));
    for i in 0..8 {
        let [x, y, _] = low_discrepancy::r3(i, [0.5; 3]);
        let (p, n) = (vec3(3.6 * x - 1.8, 3.6 * y - 1.8, 0.0), 4000);
        let at = |i: usize| low_discrepancy::r3(i, [0.1, 0.2, 0.3]);
        let exact = lamp.gather_with(&transport, p, receiver, n, at).first();
        let rough: f64 = (0..n)
            .filter_map(|i| lamp.sample_approximate(&transport, p, receiver, at(i)))
            .filter_map(|(b, _)| lamp.attenuated(&transport, p, &b))
            .map(|l| l.first() / n as f64)
            .sum();
        assert!((rough / exact - 1.0).abs() < 0.03, "{p:?}: {rough} {exact}");
    }
}
