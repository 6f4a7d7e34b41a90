//! The path tracer against conservation laws, closed forms, and brute force.

use std::f64::consts::PI;
use zonal_math::{Vec3, vec3};
use zonal_reference::brute_force::FacetHit;
use zonal_reference::path_tracer::bvh::{BinaryBvh, RayHit};
use zonal_reference::path_tracer::{
    Detector, DetectorReading, PathTracer, SubcellPart, SurfacePlate, TracingAccuracy,
};
use zonal_reference::{BruteForceScene, Rng, SampleEstimate, radiance};
use zonal_scene::{
    Band, Bands, Camera, Facet, Light, Pane, Plate, Scene, SceneParts, Surface, Texture, VoxelGrid,
};

/// Largest |z| of a comparison: exceeded by chance once in fifteen thousand.
const MAX_Z_SCORE: f64 = 4.0;

fn surface(name: &str, reflectance: Bands, emission: Bands) -> Surface {
    Surface { name: name.into(), reflectance, emission, ..Surface::default() }
}

fn facet(surface: usize, plate: Plate) -> Facet {
    Facet { surface, plate, uv: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]] }
}

/// The six walls of the unit cube, fronts inward, in the order x0, x1, y0, …
fn room() -> [Plate; 6] {
    let e = [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0)];
    std::array::from_fn(|k| {
        let (a, b) = (e[(k / 2 + 1) % 3], e[(k / 2 + 2) % 3]);
        let low = Plate::parallelogram(Vec3::ZERO, a, b);
        if k % 2 == 0 { low } else { Plate::parallelogram(e[k / 2], b, a) }
    })
}

fn patch(plate: Plate) -> Detector {
    Detector::Patch { plate, normal: plate.normal() }
}

fn medium(n: usize, mut of: impl FnMut(usize) -> (Bands, Bands, Bands, Bands)) -> VoxelGrid {
    let mut map = VoxelGrid::new(Vec3::ZERO, Vec3::splat(1.0 / n as f64), [n; 3]).unwrap();
    for i in 0..map.len() {
        let (k, o, e, q) = of(i);
        map.set(i, k, o, e, q);
    }
    map.seal().unwrap()
}

fn assert_agrees(what: &str, ours: SampleEstimate, exact: f64, finest: f64) {
    let z = ours.z(exact, 1e-9 * exact.abs());
    assert!(
        z < MAX_Z_SCORE,
        "{what}: {} ± {} where {exact} was expected, {z:.1} standard errors",
        ours.value,
        ours.error
    );
    assert!(ours.error < finest * exact.abs().max(1e-300), "{what}: too coarse, ± {}", ours.error);
}

fn both(r: &DetectorReading, b: Band) -> [SampleEstimate; 2] {
    [r.total[b], r.incident[b]]
}

fn assert_same_facet(ours: Option<RayHit>, theirs: Option<FacetHit>) {
    assert_eq!(ours.map(|m| (m.id as usize, m.front)), theirs.map(|s| (s.facet, s.front)));
}

#[test]
fn tree_queries_match_brute_force() {
    let mut rng = Rng::new(5);
    let facets: Vec<Facet> = (0..300)
        .map(|k| {
            let size = if k % 10 == 0 { 1.0 } else { 0.1 };
            let (o, a, b) =
                (rng.point_in_box(Vec3::ZERO, Vec3::ONE), rng.unit_vector() * size, rng.unit_vector() * size);
            facet(
                0,
                if k % 2 == 0 { Plate::triangle(o, o + a, o + b) } else { Plate::parallelogram(o, a, b) },
            )
        })
        .collect();
    let tree = BinaryBvh::new((0u32..).zip(facets.iter().map(|f| f.plate)), 3.0);
    let surfaces = vec![surface("all", Bands::splat(0.5), Bands::ZERO)];
    let scene = Scene::new(SceneParts { surfaces, facets, ..SceneParts::default() }).unwrap();
    let world = BruteForceScene::new(&scene);
    let mut hits = 0;
    for k in 0..4000 {
        let o = rng.point_in_box(Vec3::splat(-0.2), Vec3::splat(1.2));
        // Every seventh ray is axis-parallel.
        let d = if k % 7 == 0 { vec3(0.0, 0.0, -1.0) } else { rng.unit_vector() };
        let ours = tree.nearest(o, d, world.near..f64::INFINITY, None);
        let theirs = world.first_hit(o, d);
        assert_same_facet(ours, theirs);
        if let (Some(a), Some(b)) = (ours, theirs) {
            hits += 1;
            assert!((a.t - b.t).abs() < 1e-12);
            assert!(!tree.any(o, d, world.near..a.t * (1.0 - 1e-9), [None; 2]));
            assert!(tree.any(o, d, world.near..a.t * (1.0 + 1e-9), [None; 2]));
            let all = tree.all(o, d, world.near..f64::INFINITY);
            assert_eq!(all[0].id, a.id);
            let second = tree.nearest(o, d, world.near..f64::INFINITY, Some(a.id));
            assert_eq!(second.map(|m| m.id), all.get(1).map(|m| m.id));
        }
    }
    assert!(hits > 1000);
}

/// Coloured walls, a lamp, a pane and a coloured medium at one temperature, open to surroundings of the same.
fn isothermal() -> Scene {
    let hot = Bands::from_rgb([1.0, 2.0, 5.0]);
    let mirror = |rho: Bands| (1.0 - rho) * hot;
    let rho = [Bands::from_rgb([0.5, 0.2, 0.9]), Bands::from_rgb([0.0, 0.7, 0.3])];
    let surfaces = vec![surface("a", rho[0], mirror(rho[0])), surface("b", rho[1], mirror(rho[1]))];
    let facets = room()[..5].iter().enumerate().map(|(k, p)| facet(k % 2, *p)).collect();
    let (kappa, albedo) = (Bands::from_rgb([0.5, 1.5, 4.0]), Bands::from_rgb([0.9, 0.0, 0.5]));
    let map = medium(3, |i| (kappa * (i % 3) as f64, albedo, hot, Bands::ZERO));
    let pane = Pane {
        name: "glass".into(),
        plates: vec![Plate::parallelogram(vec3(0.0, 0.0, 0.55), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0))],
        thickness: 0.01,
        extinction: Bands::from_rgb([5.0, 50.0, 200.0]),
        albedo: Bands::from_rgb([0.2, 0.5, 0.8]),
        emission: hot,
    };
    Scene::new(SceneParts {
        surfaces,
        facets,
        panes: vec![pane],
        voxel_grid: Some(map),
        lights: vec![Light::Emitter { surface: 1, name: None }],
        surroundings: zonal_scene::Surroundings { radiance: hot / PI, name: None },
        ..SceneParts::default()
    })
    .unwrap()
}

#[test]
fn isothermal_enclosure_has_uniform_radiance() {
    let scene = isothermal();
    let tracer = PathTracer::new(&scene);
    let hot = Bands::from_rgb([1.0, 2.0, 5.0]);
    let cell = Detector::Cell { lo: Vec3::splat(0.3), hi: Vec3::splat(0.5) };
    let (lo, hi) = (Vec3::splat(0.7), Vec3::splat(0.8));
    let part =
        Detector::Part(vec![SubcellPart { lo, hi, point: (lo + hi) * 0.5, volume: (hi - lo).product() }]);
    let pane = Detector::Pane { pane: 0, plate: scene.panes()[0].plates[0] };
    let places = [
        (patch(room()[0]), 1.0),
        (patch(room()[4].quarters()[2]), 1.0),
        (cell, 4.0),
        (pane, 4.0),
        (part, 4.0),
    ];
    for (k, (receiver, factor)) in places.iter().enumerate() {
        let r = tracer.measure_one(receiver, 20_000, 7 + k as u64);
        for b in Band::all() {
            assert_agrees("isothermal", r.total[b], factor * hot[b], 0.01);
        }
        let [incident, total] = [r.incident, r.total].map(|e| e[Band::first()].value);
        assert!(incident < 0.95 * total, "emission of listed lights is direct");
    }
    let camera = Camera { up: vec3(0.0, 1.0, 0.0), ..Camera::look_at([0.4, 0.5, 0.2], [0.5, 0.3, 0.9]) };
    let picture = tracer.picture(&camera, 4, 3, 3000, 1);
    for (mean, error) in picture.mean.iter().zip(&picture.error) {
        for b in Band::all() {
            assert_agrees("picture", SampleEstimate { value: mean[b], error: error[b] }, hot[b] / PI, 0.05);
        }
    }
}

#[test]
fn sunlight_through_medium_and_pane_follows_beers_law() {
    let towards = vec3(0.0, -0.6, 0.8);
    let irradiance = Bands::from_rgb([1.0, 2.0, 4.0]);
    let pane = Pane {
        name: "glass".into(),
        plates: vec![Plate::parallelogram(vec3(-9.0, -9.0, 1.5), vec3(18.0, 0.0, 0.0), vec3(0.0, 18.0, 0.0))],
        thickness: 0.02,
        extinction: Bands::from_rgb([10.0, 0.0, 20.0]),
        albedo: Bands::ZERO,
        emission: Bands::ZERO,
    };
    let map = medium(2, |i| {
        (Bands::from_rgb([0.3 + (i % 2) as f64, 0.0, 1.0]), Bands::ZERO, Bands::ZERO, Bands::ZERO)
    });
    let floor = Plate::parallelogram(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
    let scene = Scene::new(SceneParts {
        surfaces: vec![surface("floor", Bands::ZERO, Bands::ZERO)],
        facets: vec![facet(0, floor)],
        panes: vec![pane],
        voxel_grid: Some(map),
        lights: vec![Light::Sun {
            name: "sun".into(),
            direction: -towards,
            irradiance,
            angular_diameter: 0.0,
        }],
        ..SceneParts::default()
    })
    .unwrap();
    let tracer = PathTracer::new(&scene);
    // From the middle of the upper edge of the floor the beam leaves through the roof of the medium: 1.25 m of it.
    let strip = Plate::parallelogram(vec3(0.4, 0.9, 0.0), vec3(0.1, 0.0, 0.0), vec3(0.0, 0.1, 0.0));
    let depth = Bands::from_rgb([0.8 * 1.25 + 0.2 / 0.8, 0.0, 1.25 + 0.4 / 0.8]);
    let r = tracer.measure_one(&patch(strip), 64, 1);
    let g = tracer.measure_one(&Detector::Point(vec3(0.45, 0.95, 1e-6)), 64, 1);
    for b in Band::all() {
        let exact = irradiance[b] * f64::exp(-depth[b]);
        assert!((r.total[b].value / (0.8 * exact) - 1.0).abs() < 1e-9, "{:?}", r.total);
        assert!((g.total[b].value / exact - 1.0).abs() < 1e-5, "{:?}", g.total);
        assert_eq!(r.incident[b].value, 0.0);
    }
}

#[test]
fn hot_cube_between_cold_walls_emits_its_exchange_area() {
    // gs of a face of the unit cube at K = 1 and 5, from the exact three-dimensional reduction.
    let exact = [0.446027456455, 0.842328957831];
    let facets: Vec<Facet> = room().iter().map(|p| facet(0, *p)).collect();
    // In the last band a source 4κ replaces the emission 1.
    let extinction = Bands::from_rgb([1.0, 5.0, 1.0]);
    let (emission, source) = (Bands::from_rgb([1.0, 1.0, 0.0]), Bands::from_rgb([0.0, 0.0, 4.0]));
    let map = medium(3, |_| (extinction, Bands::ZERO, emission, source));
    let surfaces = vec![surface("walls", Bands::ZERO, Bands::ZERO)];
    let scene =
        Scene::new(SceneParts { surfaces, facets, voxel_grid: Some(map), ..SceneParts::default() }).unwrap();
    let r = PathTracer::new(&scene).measure_one(&patch(room()[3]), 20_000, 3);
    let [thin, thick, source] = r.total.into_rgb();
    assert_agrees("K = 1", thin, exact[0], 0.005);
    assert_agrees("K = 5", thick, exact[1], 0.005);
    assert_agrees("a source", source, exact[0], 0.005);
}

#[test]
fn bounce_limit_truncates_the_neumann_series() {
    let (e, rho) = (3.0, 0.6);
    let facets: Vec<Facet> = room().iter().map(|p| facet(0, *p)).collect();
    let surfaces = vec![surface("walls", Bands::splat(rho), Bands::splat(e))];
    let scene = Scene::new(SceneParts { surfaces, facets, ..SceneParts::default() }).unwrap();
    for max_bounces in [0, 1, 2, 5] {
        let exact: f64 = (0..=max_bounces).map(|k| e * rho.powi(k as i32)).sum();
        let r = PathTracer::new(&scene).with_max_bounces(max_bounces).measure_one(&patch(room()[2]), 8000, 3);
        assert_agrees("bounces", r.total[Band::first()], exact, 0.01);
    }
}

/// A room with all features: textures, a lamp, a screen with a black back, a coloured heterogeneous medium and a pane.
fn complex_room() -> Scene {
    let texture = Texture { width: 2, height: 1, pixels: vec![[0.2, 0.9, 0.5], [1.0, 0.1, 0.7]] };
    let mut surfaces = vec![
        surface("walls", Bands::from_rgb([0.6, 0.8, 0.3]), Bands::ZERO),
        surface("hot", Bands::splat(0.3), Bands::from_rgb([1.0, 0.5, 2.0])),
        surface("lamp", Bands::splat(0.5), Bands::from_rgb([30.0, 40.0, 10.0])),
        surface("screen", Bands::from_rgb([0.7, 0.2, 0.4]), Bands::ZERO),
    ];
    surfaces[0].reflectance_texture = Some(0);
    surfaces[1].emission_texture = Some(0);
    let mut facets: Vec<Facet> =
        room().iter().enumerate().map(|(k, p)| facet(usize::from(k == 1), *p)).collect();
    facets.push(facet(2, Plate::triangle(vec3(0.3, 0.3, 0.8), vec3(0.4, 0.6, 0.8), vec3(0.6, 0.3, 0.8))));
    facets
        .push(facet(3, Plate::parallelogram(vec3(0.2, 0.7, 0.1), vec3(0.5, 0.0, 0.1), vec3(0.0, 0.1, 0.4))));
    let map = medium(4, |i| {
        let x = (i * 7 % 11) as f64 / 5.0;
        let (extinction, albedo) = ([x, 0.5 * x, 3.0 * x], [0.9, 0.5, x / 4.0]);
        let (emission, source) = ([0.3, 0.1, 0.0], [0.0, 0.0, 0.2 * x]);
        [extinction, albedo, emission, source].map(Bands::from_rgb).into()
    });
    let pane = Pane {
        name: "glass".into(),
        plates: vec![Plate::triangle(vec3(0.1, 0.1, 0.5), vec3(0.8, 0.1, 0.4), vec3(0.2, 0.9, 0.6))],
        thickness: 0.02,
        extinction: Bands::from_rgb([20.0, 60.0, 5.0]),
        albedo: Bands::from_rgb([0.9, 0.5, 0.1]),
        emission: Bands::from_rgb([0.5, 0.0, 1.0]),
    };
    let lights = vec![Light::Emitter { surface: 2, name: None }];
    Scene::new(SceneParts {
        surfaces,
        facets,
        textures: vec![texture],
        panes: vec![pane],
        voxel_grid: Some(map),
        lights,
        ..SceneParts::default()
    })
    .unwrap()
}

#[test]
fn readings_match_brute_force_walks_without_light_sampling() {
    // The reference tests every facet, one band at a time, and hits lights by chance only.
    let scene = complex_room();
    let (tracer, world) = (PathTracer::new(&scene), BruteForceScene::new(&scene));
    let (lo, hi) = (vec3(0.5, 0.25, 0.25), vec3(0.75, 0.5, 0.5));
    for band in Band::all() {
        for (k, plate) in [room()[0], room()[4].quarters()[1]].into_iter().enumerate() {
            let theirs = radiance::irradiance(&world, &plate, band, 40_000, 11 + k as u64);
            let ours = tracer.measure_one(&patch(plate), 20_000, 3).total[band];
            let z = (ours.value - theirs.value) / ours.error.hypot(theirs.error);
            assert!(z.abs() < MAX_Z_SCORE, "H {k} in {band:?}: {ours:?} {theirs:?}");
            assert!(ours.error < 0.02 * ours.value, "{ours:?}");
        }
        let theirs = radiance::fluence(&world, lo, hi, band, 40_000, 21);
        let ours = tracer.measure_one(&Detector::Cell { lo, hi }, 20_000, 5).total[band];
        let z = (ours.value - theirs.value) / ours.error.hypot(theirs.error);
        assert!(z.abs() < MAX_Z_SCORE, "G in {band:?}: {ours:?} {theirs:?}");
    }
}

#[test]
fn readings_are_bitwise_reproducible_and_meet_the_accuracy() {
    let scene = complex_room();
    let tracer = PathTracer::new(&scene);
    let receivers: Vec<Detector> = room().iter().map(|p| patch(p.quarters()[0])).collect();
    let accuracy = TracingAccuracy { relative: 0.02, ..TracingAccuracy::default() };
    let with = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| tracer.measure(&receivers, &accuracy, 9))
    };
    let (one, three) = (with(1), with(3));
    let mut sum = 0.0;
    for (a, b) in one.iter().zip(&three) {
        for k in Band::all() {
            assert_eq!(both(a, k), both(b, k));
            // The pilot run underestimates a few errors by less than a factor of two.
            assert!(a.total[k].error < 0.04 * a.total[k].value, "{a:?}");
            sum += a.total[k].error / a.total[k].value / (Band::count() * one.len()) as f64;
        }
    }
    assert!(sum < 0.022, "{sum}");
}

/// A black cube with a grey floor, of which a vertical sun lights the strip x < 0.3: the mean over a surface of two walls, one of them halved, is that of the
/// walls by their areas, and differs from each of them.
#[test]
fn a_surface_receives_the_mean_of_its_plates() {
    let mut plates = room();
    plates[5] = Plate::parallelogram(vec3(0.3, 0.0, 1.0), vec3(0.0, 1.0, 0.0), vec3(0.7, 0.0, 0.0));
    let lit = Light::Sun {
        name: "sun".into(),
        direction: vec3(0.0, 0.0, -1.0),
        irradiance: Bands::ONE,
        angular_diameter: 0.01,
    };
    let parts = SceneParts {
        surfaces: vec![
            surface("walls", Bands::ZERO, Bands::ZERO),
            surface("floor", Bands::splat(0.5), Bands::ZERO),
        ],
        facets: (0..6).map(|k| facet(usize::from(k == 4), plates[k])).collect(),
        lights: vec![lit],
        ..SceneParts::default()
    };
    let scene = Scene::new(parts).unwrap();
    let half = Plate { e1: plates[1].e1 * 0.5, ..plates[1] };
    let walls = [(plates[0], 1.0), (half, 1.5)];
    let surface = walls.map(|(plate, area_up_to)| SurfacePlate { plate, normal: plate.normal(), area_up_to });
    let all = [patch(plates[0]), patch(half), Detector::Surface(surface.to_vec())];
    let readings = PathTracer::new(&scene).measure_with(&all, &[400_000; 3], 3);
    let [lit, far, mean] = [0, 1, 2].map(|k: usize| readings[k].incident[Band::first()]);
    assert!(lit.value > 1.5 * far.value, "{lit:?} {far:?}");
    assert_agrees("both walls", mean, (2.0 * lit.value + far.value) / 3.0, 0.004);
    assert!(lit.z(mean.value, 0.0) > MAX_Z_SCORE && far.z(mean.value, 0.0) > MAX_Z_SCORE);
}
