//! Factors where the medium varies: a thousand random pairs in random voxmaps, panes among them, against a Monte Carlo
//! with the exact walk (`zonal_reference::exchange::by_rays`: every plane between cells cuts the ray, every pane takes Beer's law at its
//! crossing angle, every facet hides). Seeded; each pair has its z = (ours − Monte Carlo)/√(standard error² + radius²).

use rayon::prelude::*;
use zonal_exchange::pair::{Counts, Exchange};
use zonal_math::{Vec3, vec3};
use zonal_reference::exchange::by_rays;
use zonal_reference::{Body, Dice, Estimate, World};
use zonal_scene::{Facet, Options, Pane, Plate, Scene, SceneParts, Sides, Surface, Voxmap};
use zonal_transport::{Transport, build_zones};

const SCENES: u64 = 50;
const PAIRS: usize = 20;
/// Rays from each of the two ends of a pair.
const RAYS: usize = 32_000;

/// A room with a voxmap of two to four cells an axis whose extinctions spread over a contrast of up to 100, black walls, every third scene with
/// a pane across it, every fifth with a screen.
fn room(seed: u64) -> Scene {
    let mut dice = Dice::new(1000 + seed);
    let size = vec3(1.0, dice.between(0.7, 1.3), dice.between(0.7, 1.3));
    let dims = [0; 3].map(|_| 2 + (3.0 * dice.roll()) as usize);
    let cell = vec3(size.x / dims[0] as f64, size.y / dims[1] as f64, size.z / dims[2] as f64);
    let mut map = Voxmap::new(Vec3::ZERO, cell, dims).unwrap();
    // κ of a cell between base/contrast and base; the room is up to a few mean free paths wide.
    let (base, contrast) = (10f64.powf(dice.between(-0.5, 0.8)), 100f64.powf(dice.roll()));
    for i in 0..map.len() {
        let k = [0; 3].map(|_| base * contrast.powf(-dice.roll()));
        map.set(i, k, [0.5; 3], [0.0; 3], [0.0; 3]);
    }
    let mut parts = SceneParts {
        surfaces: vec![Surface {
            name: "wall".into(),
            reflectance: [0.0; 3],
            emission: [0.0; 3],
            reflectance_texture: None,
            emission_texture: None,
            sides: Sides::Front,
            patch_size: Some(0.5),
            solid: false,
        }],
        voxmap: Some(map.seal().unwrap()),
        options: Options { patch_size: Some(0.5), ..Options::default() },
        ..SceneParts::default()
    };
    let (x, y, z) = (vec3(size.x, 0.0, 0.0), vec3(0.0, size.y, 0.0), vec3(0.0, 0.0, size.z));
    let mut wall = |o: Vec3, u: Vec3, v: Vec3| {
        let plate = Plate::parallelogram(o, u, v);
        parts.facets.push(Facet { surface: 0, plate, uv: [[0.0; 2]; 3] });
    };
    wall(Vec3::ZERO, x, y);
    wall(z, y, x);
    wall(Vec3::ZERO, y, z);
    wall(x, z, y);
    wall(Vec3::ZERO, z, x);
    wall(y, x, z);
    if has_screen(seed) {
        let at = dice.between(0.3, 0.7) * size.z + 1e-3;
        let (o, u) = (vec3(0.2, 0.2, at), vec3(0.5, 0.05, 0.02));
        wall(o, u, vec3(0.0, 0.4, 0.0));
    }
    if seed.is_multiple_of(3) {
        let at = dice.between(0.2, 0.8) * size.y;
        parts.panes.push(Pane {
            name: "pane".into(),
            plates: vec![Plate::parallelogram(
                vec3(0.0, at, 0.0),
                x,
                vec3(0.0, dice.between(-0.1, 0.1), size.z),
            )],
            thickness: 0.01,
            extinction: [0; 3].map(|_| 10f64.powf(dice.between(0.0, 2.0))),
            albedo: [0.0; 3],
            emission: [0.0; 3],
        });
    }
    Scene::new(parts).unwrap()
}

fn has_screen(seed: u64) -> bool {
    seed % 5 == 4
}

/// One band of one pair.
#[derive(Clone, Copy, Debug)]
struct Check {
    scene: u64,
    pair: (usize, usize),
    kind: [char; 2],
    value: f64,
    radius: f64,
    truth: Estimate,
}

impl Check {
    fn told(&self) -> String {
        let Check { scene, pair, kind: [a, b], value, radius, truth } = self;
        format!("z {:6.2} scene {scene} {a}{b} {pair:?}: {value:e} ± {radius:e} against {truth:?}", self.z())
    }

    fn z(&self) -> f64 {
        (self.value - self.truth.value) / self.truth.error.hypot(self.radius)
    }
}

/// The weight of a body's rays and what a ray may score on it, roughly.
fn weight_and_score(b: &Body) -> (f64, f64) {
    match b {
        Body::Patch(p) => (p.area(), 1.0),
        Body::Volume { lo, hi, .. } => {
            let e = *hi - *lo;
            (4.0 * e.product(), 2.0 * e.product() / (e.x * e.y + e.y * e.z + e.z * e.x))
        }
        Body::Pane { plate, thickness, .. } => (4.0 * plate.area() * thickness, 2.0 * thickness),
    }
}

/// The two directions of a pair together. Their weights follow from the bodies alone, never from the samples: a run with few hits
/// takes itself for precise.
fn both_ways(w: &World, a: &Body, b: &Body, seed: u64) -> [Estimate; 3] {
    let (p, q) = (by_rays(w, a, b, RAYS, seed), by_rays(w, b, a, RAYS, !seed));
    let ((wa, sa), (wb, sb)) = (weight_and_score(a), weight_and_score(b));
    let s = wb * sa / (wb * sa + wa * sb);
    std::array::from_fn(|k| Estimate {
        value: s * p[k].value + (1.0 - s) * q[k].value,
        error: (s * p[k].error).hypot((1.0 - s) * q[k].error),
    })
}

fn checks(seed: u64) -> Vec<Check> {
    let scene = room(seed);
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport).unwrap();
    let exchange = Exchange::new(&scene, &zones, &transport);
    let (world, mut counts) = (World::new(&scene), Counts::default());
    let kind = |i: usize| match i {
        i if i < zones.voxel_offset() => 's',
        i if i < zones.pane_offset() => 'v',
        _ => 'p',
    };
    let whole = |i: usize| kind(i) != 'v' || zones.voxels[i - zones.voxel_offset()].part.is_empty();
    let (mut dice, mut out, mut pairs) = (Dice::new(7 * seed + 3), vec![], 0);
    while pairs < PAIRS {
        let (i, j) =
            ((dice.roll() * zones.len() as f64) as usize, (dice.roll() * zones.len() as f64) as usize);
        if i == j || !whole(i) || !whole(j) {
            continue;
        }
        let f = exchange.pair(i, j, &mut counts);
        if f.value == [0.0; 3] {
            continue;
        }
        pairs += 1;
        let (a, b) = (Body::of(&scene, &zones, i), Body::of(&scene, &zones, j));
        let truth = both_ways(&world, &a, &b, seed << 32 | pairs as u64);
        for k in 0..3 {
            out.push(Check {
                scene: seed,
                pair: (i, j),
                kind: [kind(i), kind(j)],
                value: f.value[k],
                radius: f.radius[k],
                truth: truth[k],
            });
        }
    }
    out
}

fn median(mut x: Vec<f64>) -> f64 {
    x.sort_by(f64::total_cmp);
    x[x.len() / 2]
}

#[test]
fn a_thousand_pairs_agree_with_the_exact_walk() {
    let all: Vec<Check> = (0..SCENES).into_par_iter().flat_map_iter(checks).collect();
    assert_eq!(all.len(), 3 * PAIRS * SCENES as usize);
    // Where fewer than a few dozen rays arrive, their standard error is no measure.
    let sound: Vec<&Check> = all.iter().filter(|c| c.truth.error < 0.15 * c.truth.value).collect();
    let n = sound.len() as f64;
    let teeth = median(sound.iter().map(|c| c.truth.error / c.truth.value).collect());
    let radius = median(sound.iter().map(|c| c.radius / c.value).collect());
    let mean = sound.iter().map(|c| c.z()).sum::<f64>() / n;
    let square = sound.iter().map(|c| c.z().powi(2)).sum::<f64>() / n;
    let beyond = |x: f64| sound.iter().filter(|c| c.z().abs() > x).count() as f64 / n;
    println!(
        "{} bands of pairs, {n} with hits enough: standard error {teeth:.4}, radius {radius:.4} (medians), z mean {mean:.3}, \
         square {square:.3}, beyond 2 {:.4}, beyond 3 {:.4}",
        all.len(),
        beyond(2.0),
        beyond(3.0)
    );
    let mut worst = sound.clone();
    worst.sort_by(|a, b| b.z().abs().total_cmp(&a.z().abs()));
    for c in &worst[..12] {
        println!("{}", c.told());
    }
    assert!(n > 0.85 * all.len() as f64 && teeth < 0.03, "{n} {teeth}");
    assert!(worst[0].z().abs() <= 5.0, "{}", worst[0].told());
    assert!(beyond(2.0) <= 0.05 && mean.abs() <= 0.1, "{} {mean}", beyond(2.0));
}
