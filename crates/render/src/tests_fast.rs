//! What is fast against what is exact.

use super::tests::*;
use super::*;
use std::f64::consts::PI;
use zonal_math::vec3;
use zonal_scene::scene::{Facet, Pane, SceneParts, Sides, Surface};
use zonal_scene::{Group, Kind, Light, Plate, Quiet, Solution, Values};

/// A fog room with candles of eight facets each, a shelf, a pane and a sun through a hole of the ceiling.
fn candle_room(candles: usize, sunny: bool) -> SceneParts {
    let (lo, hi) = (vec3(-2.0, -2.0, 0.0), vec3(2.0, 2.0, 2.5));
    let mut facets = walls(lo, hi);
    facets.remove(1);
    for (x, w) in [(-2.0, 1.6), (0.4, 1.6)] {
        facets.push(quad(0, vec3(x, -2.0, 2.5), vec3(0.0, 4.0, 0.0), vec3(w, 0.0, 0.0)));
    }
    facets.push(quad(0, vec3(0.1, -0.5, 0.9), vec3(0.8, 0.0, 0.0), vec3(0.0, 0.8, 0.0)));
    for i in 0..candles {
        let [x, y, z] = sequence::r3(i, [0.2, 0.7, 0.4]);
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
            extinction: [50.0, 0.0, 10.0],
            albedo: [0.0; 3],
            emission: [0.0; 3],
        }],
        voxmap: Some(medium(lo, hi, [16, 16, 10], 0.25, 0.8)),
        lights,
        ..SceneParts::default()
    }
}

/// Means of blocks of 8 × 8 pixels, their first band.
fn blocks(pixels: &[f64], width: usize) -> Vec<f64> {
    let across = width / 8;
    let mut out = vec![0.0; across * (pixels.len() / width / 8)];
    pixels.iter().enumerate().for_each(|(i, x)| out[i / width / 8 * across + i % width / 8] += x / 64.0);
    out
}

/// Direct light of the lamp on every zone, as a solution with light groups keeps it.
fn own_group(s: &Solution, lamp: &zonal_transport::direct::Lamp, transport: &Transport) -> Group {
    let free = zonal_transport::direct::Receiver::Free;
    let volume = |z: &zonal_scene::VoxelZone| lamp.gather(transport, z.centre, free, 64, 7);
    let mut direct = vec![[0.0; 3]; s.zones.voxel_offset()];
    direct.extend(s.zones.voxels.iter().map(volume));
    Group {
        kind: Kind::Light(0),
        direct: Values::Double(direct),
        direct_scale: [2.0, 1.0, 0.5],
        ..Group::default()
    }
}

#[test]
fn light_of_many_flames_in_fog_is_that_of_their_points() {
    let s = solution(candle_room(30, false), |_, _| 0.0, |_| 0.0);
    let transport = Transport::new(&s.scene);
    let lamp = zonal_transport::direct::Lamp::new(&s.scene, &s.scene.lights()[0]);
    assert!((30..36).contains(&lamp.clusters().len()), "every flame is one cluster, or two");
    let mut kept = s.clone();
    kept.groups = vec![own_group(&s, &lamp, &transport)];
    let slow = View::new(&s, &transport).sampled_only();
    let way = |i: u64| {
        let unit = |k: u64| sequence::unit(6 * i + k);
        let at = |k: u64| vec3(3.8 * unit(k) - 1.9, 3.8 * unit(k + 1) - 1.9, 2.4 * unit(k + 2) + 0.05);
        (at(0), at(3))
    };
    let exact: Vec<f64> = (0..40).map(way).map(|(from, to)| slow.scattered(from, to, 3000)[1]).collect();
    let mean = exact.iter().sum::<f64>() / 40.0;
    for s in [&s, &kept] {
        let fast = View::new(s, &transport);
        let found: Vec<f64> = (0..40).map(way).map(|(from, to)| fast.scattered(from, to, 4)[1]).collect();
        let off = found.iter().sum::<f64>() / 40.0 / mean - 1.0;
        assert!(off.abs() < 0.03, "{off}");
        // Rays that pass a flame closer than it is wide are the rest.
        let square = found.iter().zip(&exact).map(|(f, e)| (f - e).powi(2) / 40.0).sum::<f64>();
        assert!(square.sqrt() < 0.3 * mean, "{} {mean}", square.sqrt());
    }
    // What is far from every flame is the group's own, as it was turned up and down.
    let (plain, turned) = (View::new(&s, &transport), View::new(&kept, &transport));
    let ratio = |b: usize| {
        let sum = |v: &View| (0..40).map(way).map(|(from, to)| v.scattered(from, to, 4)[b]).sum::<f64>();
        sum(&turned) / sum(&plain)
    };
    assert!(ratio(0) > 1.02 && ratio(2) < 0.99, "{} {}", ratio(0), ratio(2));
}

#[test]
fn adaptive_pictures_have_the_block_means_of_exhaustive_ones() {
    let s = solution(candle_room(20, true), |p, _| 0.3 + 0.1 * p.x, |p| 0.2 + 0.05 * p.z);
    let (w, h) = (112, 80);
    let cam = camera(vec3(-1.7, -1.6, 1.4), vec3(0.4, 0.3, 1.2), 75.0);
    let pixels = |samples: usize| {
        let image = render(&s, &cam, &RenderOptions { samples, ..size(w, h) }, &Quiet);
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

#[test]
fn a_gather_in_a_furnace_finds_the_furnace() {
    let s = solution(furnace(), |_, _| 1.0, |_| 1.0);
    let cam = camera(vec3(0.3, -0.8, 0.7), vec3(0.0, 0.1, 0.6), 80.0);
    let options = RenderOptions { gather: 8, ..size(32, 24) };
    let image = render(&s, &cam, &options, &Quiet);
    assert!(worst(&image, 1.0 / PI) < 1e-6, "{}", worst(&image, 1.0 / PI));
}

#[test]
fn rough_light_of_many_flames_is_that_of_their_facets() {
    let s = solution(candle_room(20, false), |_, _| 0.0, |_| 0.0);
    let transport = Transport::new(&s.scene);
    let lamp = zonal_transport::direct::Lamp::new(&s.scene, &s.scene.lights()[0]);
    let receiver = zonal_transport::direct::Receiver::Surface(vec3(0.0, 0.0, 1.0));
    for i in 0..8 {
        let [x, y, _] = sequence::r3(i, [0.5; 3]);
        let (p, n) = (vec3(3.6 * x - 1.8, 3.6 * y - 1.8, 0.0), 4000);
        let at = |i: usize| sequence::r3(i, [0.1, 0.2, 0.3]);
        let exact = lamp.gather_at(&transport, p, receiver, n, at)[0];
        let rough: f64 = (0..n)
            .filter_map(|i| lamp.rough_beam(&transport, p, receiver, at(i)))
            .filter_map(|(b, _)| lamp.lit(&transport, p, &b))
            .map(|l| l[0] / n as f64)
            .sum();
        assert!((rough / exact - 1.0).abs() < 0.03, "{p:?}: {rough} {exact}");
    }
}
