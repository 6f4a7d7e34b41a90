use super::*;
use std::f64::consts::PI;
use zonal_math::directions::cosine;
use zonal_math::vec3;
use zonal_scene::Quiet;
use zonal_transport::{Hit, build_zones};

const ROOM: &str = "name = \"room\"\n[solve]\ntolerance = 0.03\npatch_size = 0.25\n\
    [[surface]]\nname = \"room\"\nroom = { min = [0, 0, 0], max = [2, 2, 2] }\nOMIT\n\
    [[surface]]\nname = \"block\"\nbox = { min = [0.7, 0.6, 0.5], max = [1.3, 1.4, 0.9], rotate_z_degrees = 20 }\n\
    [medium]\nmin = [0, 0, 0]\nmax = [2, 2, 2]\ncells = [14, 14, 14]\nextinction = 0.2\nalbedo = 0.5\n";
const LAMP: &str = "[[surface]]\nname = \"lamp\"\nrectangle = { origin = [0.6, 0.7, 1.95], edge1 = [0, 0.6, 0], edge2 = [0.8, 0, 0] }\n\
    emission = 10\n[[light]]\nkind = \"emitter\"\nsurface = \"lamp\"\n";
const SUN: &str =
    "[[light]]\nkind = \"sun\"\ndirection = [0.3, 0.2, -1]\nirradiance = 100\nangular_diameter = 2\n";
const SKY: &str = "[[light]]\nkind = \"sky\"\nradiance = 1\n";

/// What is gathered of a light, against thousands of samples a zone.
fn check(light: &str, omit: &str, limit: f64) {
    let text = ROOM.replace("OMIT", omit) + light;
    let scene = zonal_io::input::parse_scene(&text, None, "room").unwrap();
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport).unwrap();
    let g = Gatherer::new(&scene, &zones, &transport, &scene.lights()[0]);
    let found = gather(&scene, &zones, &transport, &scene.lights()[0], &Quiet);
    let (mut off, mut all, mut within, mut n) = (0.0, 0.0, 0, 0);
    for i in (0..zones.pane_offset()).step_by(7) {
        let truth = largest(g.look(i, 0..4096).value());
        let d = (found.fields[i][0] - truth).abs();
        (off, all, n) = (off + d * d, all + truth * truth, n + 1);
        within += usize::from(d <= 2.0 * largest(found.error[i]) + 1e-3 * truth);
    }
    let l2 = (off / all).sqrt();
    assert!(l2 < limit && within as f64 > 0.9 * n as f64, "{light}: {l2:.2e}, {within} of {n} within twice");
    assert!(found.rays < 256 * zones.len() as u64);
}

#[test]
fn gathered_light_is_as_good_as_it_says() {
    check(LAMP, "", 0.03);
    check(SUN, "omit = [\"z1\"]", 0.03);
    // Of a sky all around the room few samples come through the opening: they run out first.
    check(SKY, "omit = [\"z1\"]", 0.05);
}

/// A lamp as large as the ceiling, and screens that end 3 cm below it: behind them most of it is hidden, and what is not is close
/// and seen at a grazing angle.
const SCREENS: &str = "name = \"screens\"\n[solve]\ntolerance = 0.05\npatch_size = 0.2\n\
    [[surface]]\nname = \"room\"\nroom = { min = [0, 0, 0], max = [6, 2, 1] }\n\
    [[surface]]\nname = \"low\"\nrectangle = { origin = [1.5, 0, 0], edge1 = [0, 2, 0], edge2 = [0, 0, 0.93] }\nsides = \"both\"\n\
    [[surface]]\nname = \"lid\"\nrectangle = { origin = [1.5, 0.5, 0.93], edge1 = [3.5, 0, 0], edge2 = [0, 1.5, 0] }\nsides = \"both\"\n\
    [[surface]]\nname = \"lamp\"\nrectangle = { origin = [0.01, 0.01, 0.96], edge1 = [0, 1.98, 0], edge2 = [5.98, 0, 0] }\n\
    emission = 10\n[[light]]\nkind = \"emitter\"\nsurface = \"lamp\"\n\
    [medium]\nmin = [0, 0, 0]\nmax = [6, 2, 1]\ncells = [30, 10, 7]\nextinction = 0.1\nalbedo = 0.5\n";

/// H or G of zone `i` and its standard error, from rays that leave the zone all ways: what meets the front of the lamp counts.
fn brute(g: &Gatherer, i: usize, n: usize) -> [f64; 2] {
    const RADIANCE: f64 = 10.0 / PI;
    let scene = g.transport.scene();
    let sent = |k: usize| {
        let [u, v, w, a, b, _] = sequence::r6(k, sequence::shift(i as u64));
        let (x, dir, weight) = match g.zones.patches.get(i) {
            Some(p) => {
                let [u, v] = p.plate.warp([u, v]);
                (p.plate.at(u, v), cosine(p.normal, [a, b]), PI)
            }
            None => {
                let z = 1.0 - 2.0 * a;
                let (sin, cos) = (2.0 * PI * b).sin_cos();
                let dir = vec3(cos, sin, 0.0) * (1.0 - z * z).sqrt() + vec3(0.0, 0.0, z);
                let zone = &g.zones.voxels[i - g.zones.voxel_offset()];
                (voxel_point(zone, g.cell, [u, v, w]), dir, 4.0 * PI)
            }
        };
        let lamp = |h: &Hit| {
            h.front
                && matches!(g.lamp.light(), Light::Emitter { surface, .. } if scene.facets()[h.facet].surface == *surface)
        };
        let hit = g.transport.nearest(x, dir, 1e-9, 100.0).filter(lamp);
        hit.map_or(0.0, |h| weight * RADIANCE * (-g.transport.optical_depth(x, x + dir * h.t)[0]).exp())
    };
    let (mut sum, mut square) = (0.0, 0.0);
    for w in (0..n).map(sent) {
        (sum, square) = (sum + w, square + w * w);
    }
    let mean = sum / n as f64;
    [mean, ((square / n as f64 - mean * mean).max(0.0) / n as f64).sqrt()]
}

#[test]
fn beside_a_large_lamp_that_is_partly_hidden_nothing_is_missed() {
    let scene = zonal_io::input::parse_scene(SCREENS, None, "screens").unwrap();
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport).unwrap();
    let light = &scene.lights()[0];
    let g = Gatherer::new(&scene, &zones, &transport, light);
    let found = gather(&scene, &zones, &transport, light, &Quiet);
    let (patches, n) = (zones.voxel_offset(), zones.pane_offset());
    for (range, step) in [(0..patches, 5), (patches..n, 11)] {
        let limit = scene.options().tolerance;
        let (mut off, mut all, mut within, mut count, mut noise) = (0.0, 0.0, 0, 0, 0.0);
        for i in range.step_by(step) {
            let [truth, se] = brute(&g, i, 1 << 14);
            let d = (found.fields[i][0] - truth).abs();
            (off, all, noise) = (off + d * d, all + truth * truth, noise + se * se);
            within += usize::from(d <= 2.0 * largest(found.error[i]).hypot(se) + 1e-3 * truth);
            count += 1;
        }
        let (l2, noise) = ((off / all).sqrt(), (noise / all).sqrt());
        assert!(noise < 0.5 * limit && l2 < limit + noise, "{l2:.3}, noise {noise:.3}");
        assert!(within as f64 > 0.93 * count as f64, "{within} of {count}");
    }
    // And all of its power is met.
    let lit = crate::direct::light(&scene, &zones, &transport, 0, true, &Quiet);
    assert!(lit.warning.is_none() && lit.largest_change < 0.01, "{:?} {}", lit.warning, lit.largest_change);
}

#[test]
fn rays_are_foretold_within_a_factor_of_two() {
    let scene = zonal_io::input::parse_scene(&(ROOM.replace("OMIT", "") + LAMP), None, "room").unwrap();
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport).unwrap();
    let light = &scene.lights()[0];
    let told = rays(&scene, &zones, &transport, light, 500);
    let taken = gather(&scene, &zones, &transport, light, &Quiet).rays as f64;
    assert!((0.5..2.0).contains(&(told / taken)), "{told} for {taken}");
}
