//! Direct light by shadow rays.

mod coverage;
#[path = "../../../../../tests/common/lit_rooms.rs"]
mod lit_rooms;

use super::params::MAX_SAMPLES_PER_ZONE;
use super::zone_sampler::{ZoneLightSampler, largest};
use super::{expected_rays, gather};
use crate::distribution::Execution;
use crate::right_hand_side::direct_light::illumination::{PowerNormalization, illuminate_by};
use crate::right_hand_side::surroundings::zone_rays::voxel_point;
use crate::settings::unobstructed_cells::UnobstructedCells;
use lit_rooms::{LAMP, SKY, SUN};
use std::f64::consts::PI;
use zonal_math::direction_sampling::cosine_hemisphere;
use zonal_math::{low_discrepancy, vec3};
use zonal_scene::NoProgress;
use zonal_transport::{Hit, Transport, build_zones};

const ROOM: &str = "name = \"room\"\n[solve]\ntolerance = 0.03\npatch_size = 0.25\n\
    [[surface]]\nname = \"room\"\nroom = { min = [0, 0, 0], max = [2, 2, 2] }\nOMIT\n\
    [[surface]]\nname = \"block\"\nbox = { min = [0.7, 0.6, 0.5], max = [1.3, 1.4, 0.9], rotate_z_degrees = 20 }\n\
    [medium]\nmin = [0, 0, 0]\nmax = [2, 2, 2]\ncells = [14, 14, 14]\nextinction = 0.2\nalbedo = 0.5\n";

/// Gathered light against thousands of samples per zone.
fn check(light: &str, omit: &str, limit: f64) {
    let text = ROOM.replace("OMIT", omit) + light;
    let scene = zonal_io::input::parse_scene(&text, None, "room").unwrap();
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport).unwrap();
    let g = ZoneLightSampler::new(&zones, &transport, &scene.lights()[0]);
    let found = gather(&zones, &transport, &scene.lights()[0], Execution::alone(&NoProgress));
    let (mut off, mut all, mut within, mut n) = (0.0, 0.0, 0, 0);
    for i in (0..zones.pane_offset()).step_by(7) {
        let truth = largest(g.sample_zone(i, 0..4096).value());
        let d = (found.fields[i].first() - truth).abs();
        (off, all, n) = (off + d * d, all + truth * truth, n + 1);
        within += usize::from(d <= 2.0 * largest(found.error[i]) + 1e-3 * truth);
    }
    let l2 = (off / all).sqrt();
    assert!(l2 < limit && within as f64 > 0.9 * n as f64, "{light}: {l2:.2e}, {within} of {n} within twice");
    assert!(found.rays < (MAX_SAMPLES_PER_ZONE * zones.len()) as u64);
}

#[test]
fn gathered_light_is_within_its_stated_error() {
    check(LAMP, "", 0.03);
    check(SUN, "omit = [\"z1\"]", 0.03);
    // Of a sky around the room few samples pass the opening, so that the maximum number of samples limits the accuracy.
    check(SKY, "omit = [\"z1\"]", 0.05);
}

/// A lamp as large as the ceiling, and screens that end 3 cm below it: behind them most of the lamp is hidden, and the rest is close and at a grazing
/// angle.
const SCREENS: &str = "name = \"screens\"\n[solve]\ntolerance = 0.05\npatch_size = 0.2\n\
    [[surface]]\nname = \"room\"\nroom = { min = [0, 0, 0], max = [6, 2, 1] }\n\
    [[surface]]\nname = \"low\"\nrectangle = { origin = [1.5, 0, 0], edge1 = [0, 2, 0], edge2 = [0, 0, 0.93] }\nsides = \"both\"\n\
    [[surface]]\nname = \"lid\"\nrectangle = { origin = [1.5, 0.5, 0.93], edge1 = [3.5, 0, 0], edge2 = [0, 1.5, 0] }\nsides = \"both\"\n\
    [[surface]]\nname = \"lamp\"\nrectangle = { origin = [0.01, 0.01, 0.96], edge1 = [0, 1.98, 0], edge2 = [5.98, 0, 0] }\n\
    emission = 10\n[[light]]\nkind = \"emitter\"\nsurface = \"lamp\"\n\
    [medium]\nmin = [0, 0, 0]\nmax = [6, 2, 1]\ncells = [30, 10, 7]\nextinction = 0.1\nalbedo = 0.5\n";

/// H or G of zone `i` and its standard error, from rays of the zone in all directions that hit the front of the lamp.
fn brute_force(g: &ZoneLightSampler, i: usize, n: usize) -> [f64; 2] {
    const RADIANCE: f64 = 10.0 / PI;
    let scene = g.transport.scene();
    let sent = |k: usize| {
        let [u, v, w, a, b, _] = low_discrepancy::r6(k, low_discrepancy::random_shift(i as u64));
        let (x, dir, weight) = match g.zones.patches.get(i) {
            Some(p) => {
                let [u, v] = p.plate.warp([u, v]);
                (p.plate.at(u, v), cosine_hemisphere(p.normal, [a, b]), PI)
            }
            None => {
                let z = 1.0 - 2.0 * a;
                let (sin, cos) = (2.0 * PI * b).sin_cos();
                let dir = vec3(cos, sin, 0.0) * (1.0 - z * z).sqrt() + vec3(0.0, 0.0, z);
                let zone = i - g.zones.voxel_offset();
                (voxel_point(g.transport, g.zones, zone, [u, v, w]), dir, 4.0 * PI)
            }
        };
        let lamp = |h: &Hit| h.front && g.light.light().surface() == Some(scene.facets()[h.facet].surface);
        let hit = g.transport.closest_hit(x, dir, 1e-9, 100.0).filter(lamp);
        hit.map_or(0.0, |h| weight * RADIANCE * (-g.transport.optical_depth(x, x + dir * h.t).first()).exp())
    };
    let (mut sum, mut square) = (0.0, 0.0);
    for w in (0..n).map(sent) {
        (sum, square) = (sum + w, square + w * w);
    }
    let mean = sum / n as f64;
    [mean, ((square / n as f64 - mean * mean).max(0.0) / n as f64).sqrt()]
}

#[test]
fn partly_hidden_lamp_beside_a_zone_is_unbiased() {
    let scene = zonal_io::input::parse_scene(SCREENS, None, "screens").unwrap();
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport).unwrap();
    let light = &scene.lights()[0];
    let g = ZoneLightSampler::new(&zones, &transport, light);
    let found = gather(&zones, &transport, light, Execution::alone(&NoProgress));
    let (patches, n) = (zones.voxel_offset(), zones.pane_offset());
    for (range, step) in [(0..patches, 5), (patches..n, 11)] {
        let limit = scene.options().tolerance;
        let (mut off, mut all, mut within, mut count, mut noise) = (0.0, 0.0, 0, 0, 0.0);
        for i in range.step_by(step) {
            let [truth, se] = brute_force(&g, i, 1 << 14);
            let d = (found.fields[i].first() - truth).abs();
            (off, all, noise) = (off + d * d, all + truth * truth, noise + se * se);
            within += usize::from(d <= 2.0 * largest(found.error[i]).hypot(se) + 1e-3 * truth);
            count += 1;
        }
        let (l2, noise) = ((off / all).sqrt(), (noise / all).sqrt());
        assert!(noise < 0.5 * limit && l2 < limit + noise, "{l2:.3}, noise {noise:.3}");
        assert!(within as f64 > 0.93 * count as f64, "{within} of {count}");
    }
    // The power balance of the lamp closes.
    let lit = illuminate_by(
        &zones,
        &transport,
        0,
        PowerNormalization::InverseVariance,
        Execution::alone(&NoProgress),
    );
    assert!(lit.warning.is_none() && lit.largest_change < 0.01, "{:?} {}", lit.warning, lit.largest_change);
}

#[test]
fn expected_rays_are_within_a_factor_of_two() {
    let scene = zonal_io::input::parse_scene(&(ROOM.replace("OMIT", "") + LAMP), None, "room").unwrap();
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport).unwrap();
    let light = &scene.lights()[0];
    let cells = UnobstructedCells::new(scene.voxel_grid().unwrap(), &zones, &transport);
    let expected = expected_rays(&zones, &transport, light, 500, Some(&cells));
    let taken = gather(&zones, &transport, light, Execution::alone(&NoProgress)).rays as f64;
    assert!((0.5..2.0).contains(&(expected / taken)), "{expected} for {taken}");
}
