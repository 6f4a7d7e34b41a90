//! Measures the rate of ray queries and of zoning: `cargo run --release -p zonal-transport --example rate [zones]`.

use std::time::Instant;
use zonal_math::{Vec3, low_discrepancy::hash_to_unit, vec3};
use zonal_scene::{Bands, Facet, Plate, Scene, SceneParts, Sides, Surface, VoxelGrid};
use zonal_transport::{Transport, build_zones};

fn surface() -> Surface {
    Surface {
        name: "all".into(),
        reflectance: Bands::splat(0.5),
        emission: Bands::ZERO,
        reflectance_texture: None,
        emission_texture: None,
        transmission: None,
        sides: Sides::Front,
        patch_size: None,
        solid: false,
    }
}

/// Appends a triangulated sphere.
fn add_sphere(c: Vec3, r: f64, n: usize, out: &mut Vec<Plate>) {
    let at = |i: usize, j: usize| {
        let (a, b) = (std::f64::consts::PI * i as f64 / n as f64, std::f64::consts::PI * j as f64 / n as f64);
        c + vec3(a.sin() * b.cos(), a.sin() * b.sin(), a.cos()) * r
    };
    for i in 0..n {
        for j in 0..2 * n {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            for t in [Plate::triangle(a, b, c), Plate::triangle(a, c, d)] {
                if t.area() > 1e-12 {
                    out.push(t);
                }
            }
        }
    }
}

/// Appends the walls of the unit cube, normals inward, each as n × n parts.
fn add_walls(n: usize, out: &mut Vec<Plate>) {
    let (x, y, z) = (vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
    let (o, e) = (Vec3::ZERO, Vec3::ONE);
    for (p, u, v) in [(o, x, y), (o, y, z), (o, z, x), (e, -y, -x), (e, -z, -y), (e, -x, -z)] {
        let (u, v) = (u / n as f64, v / n as f64);
        for i in 0..n {
            for j in 0..n {
                let q = p + u * i as f64 + v * j as f64;
                if n == 1 {
                    out.push(Plate::parallelogram(q, u, v));
                } else {
                    out.push(Plate::triangle(q, q + u, q + u + v));
                    out.push(Plate::triangle(q, q + u + v, q + v));
                }
            }
        }
    }
}

fn main() {
    if std::env::args().any(|a| a == "zones") {
        return measure_zoning();
    }
    let mut cases: Vec<(&str, Vec<Plate>)> = Vec::new();
    for (name, wall, balls, fine) in [
        ("room, 6 plates", 1, 0, 0),
        ("room and 1 ball, 100 triangles", 1, 1, 5),
        ("room and 20 balls, 10k", 1, 20, 12),
        ("fine room and 20 balls, 200k", 90, 20, 26),
        ("fine room and 500 balls, 200k", 60, 500, 10),
    ] {
        let mut plates = Vec::new();
        add_walls(wall, &mut plates);
        for k in 0..balls {
            let u = |i: u64| 0.1 + 0.8 * hash_to_unit(k * 3 + i);
            add_sphere(vec3(u(0), u(1), u(2)), 0.35 / (balls as f64).cbrt() * 0.5, fine, &mut plates);
        }
        cases.push((name, plates));
    }
    for (name, plates) in cases {
        measure_queries(name, &plates);
    }
    measure_zoning();
}

/// Measures the query rates in a scene of these plates.
fn measure_queries(name: &str, plates: &[Plate]) {
    let facets = plates.iter().map(|p| Facet { surface: 0, plate: *p, uv: [[0.0; 2]; 3] }).collect();
    let mut map = VoxelGrid::new(Vec3::ZERO, Vec3::splat(1.0 / 32.0), [32; 3]).expect("a map");
    for i in 0..map.len() {
        map.set(i, Bands::splat(hash_to_unit(i as u64)), Bands::splat(0.5), Bands::ZERO, Bands::ZERO);
    }
    let scene = Scene::new(SceneParts {
        surfaces: vec![surface()],
        facets,
        voxel_grid: Some(map.seal().expect("a medium")),
        ..SceneParts::default()
    })
    .expect("a scene");
    let start = Instant::now();
    let t = Transport::new(&scene);
    println!(
        "{name}: {} plates, built in {:.0} ms, {} occluders",
        plates.len(),
        start.elapsed().as_secs_f64() * 1e3,
        t.occluder_count()
    );
    let count = 400_000;
    let points: Vec<Vec3> = (0..2 * count)
        .map(|i| vec3(hash_to_unit(3 * i), hash_to_unit(3 * i + 1), hash_to_unit(3 * i + 2)))
        .collect();
    let on: Vec<Vec3> = (0..2 * count)
        .map(|i| {
            let p = &plates[(hash_to_unit(3 * i) * plates.len() as f64) as usize];
            let [u, v] = p.warp([hash_to_unit(3 * i + 1), hash_to_unit(3 * i + 2)]);
            p.at(u, v)
        })
        .collect();
    let rate = |label: &str, query: &dyn Fn(Vec3, Vec3) -> bool, from: &[Vec3]| {
        let start = Instant::now();
        let hits = from.chunks_exact(2).filter(|x| query(x[0], x[1])).count();
        let each = start.elapsed().as_secs_f64() / count as f64;
        println!(
            "  {label:<28} {:7.1} ns {:6.2} M/s   {:4.1} % true",
            each * 1e9,
            1e-6 / each,
            100.0 * hits as f64 / count as f64
        );
    };
    rate("occluded, volume pairs", &|a, b| t.occluded(a, b), &points);
    rate("occluded, surface pairs", &|a, b| t.occluded(a, b), &on);
    rate("occluded_inside, volume", &|a, b| t.occluded_inside(a, b), &points);
    rate("occluded_inside, surface", &|a, b| t.occluded_inside(a, b), &on);
    let closest = |a: Vec3, b: Vec3| t.closest_hit(a, (b - a).normalized(), 1e-9, f64::INFINITY).is_some();
    rate("closest hit", &closest, &points);
    rate("optical depth, 32³", &|a, b| t.optical_depth(a, b).first() > 1.0, &points);
}

/// Measures the zoning of a 115³ voxel grid with up to 200 solid balls in a room.
fn measure_zoning() {
    for (balls, fine) in [(0, 0), (20, 12), (200, 12)] {
        let mut plates = Vec::new();
        add_walls(1, &mut plates);
        for k in 0..balls {
            let u = |i: u64| 0.1 + 0.8 * hash_to_unit(k * 3 + i);
            add_sphere(vec3(u(0), u(1), u(2)), 0.08, fine, &mut plates);
        }
        let facets = (0..plates.len()).map(|k| Facet {
            surface: (k >= 6) as usize,
            plate: plates[k],
            uv: [[0.0; 2]; 3],
        });
        let ball = Surface { name: "ball".into(), solid: true, ..surface() };
        let n = 115;
        let scene = Scene::new(SceneParts {
            surfaces: vec![surface(), ball],
            facets: facets.collect(),
            voxel_grid: Some(VoxelGrid::new(Vec3::ZERO, Vec3::splat(1.0 / n as f64), [n; 3]).expect("a map")),
            ..SceneParts::default()
        })
        .expect("a scene");
        let t = Transport::new(&scene);
        let start = Instant::now();
        let z = build_zones(&scene, &t).expect("zones");
        let cut = z.voxels.iter().filter(|v| !v.samples.is_empty()).count();
        let volume: f64 = z.voxels.iter().map(|v| v.volume).sum();
        println!(
            "zones of {} facets: {:.2} s, {} patches, {} voxel zones, {cut} of them cut, volume {volume:.5}",
            plates.len(),
            start.elapsed().as_secs_f64(),
            z.patches.len(),
            z.voxels.len(),
        );
    }
}
