//! A hall with columns in 200,000 triangles, and segments in it.

use zonal_math::{Vec3, low_discrepancy::hash_to_unit, vec3};
use zonal_scene::{Facet, Plate, Scene, SceneParts, Surface, VoxelGrid};

/// Segments of a set.
pub(crate) const SEGMENT_COUNT: usize = 400_000;
/// Edges of the hall, m.
pub(crate) const HALL: Vec3 = vec3(40.0, 20.0, 12.0);

/// A rectangle as n × m × 2 triangles.
fn mesh(o: Vec3, edges: [Vec3; 2], [n, m]: [usize; 2], out: &mut Vec<Plate>) {
    let (u, v) = (edges[0] / n as f64, edges[1] / m as f64);
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
        let q = o + u * i as f64 + v * j as f64;
        out.extend([Plate::triangle(q, q + u, q + u + v), Plate::triangle(q, q + u + v, q + v)]);
    }
}

/// A hall with two rows of ten columns, twelve-sided.
pub(crate) fn plates() -> Vec<Plate> {
    let mut out = Vec::new();
    let (x, y, z) = (vec3(HALL.x, 0.0, 0.0), vec3(0.0, HALL.y, 0.0), vec3(0.0, 0.0, HALL.z));
    let (nx, ny, nz) = (168, 84, 50);
    for (u, v, cells) in [(x, y, [nx, ny]), (y, z, [ny, nz]), (z, x, [nz, nx])] {
        mesh(Vec3::ZERO, [u, v], cells, &mut out);
        mesh(HALL, [-v, -u], [cells[1], cells[0]], &mut out);
    }
    for k in 0..20 {
        let centre = vec3(2.0 + 4.0 * (k % 10) as f64, if k < 10 { 6.0 } else { 14.0 }, 0.0);
        let corner = |s: usize| {
            let angle = std::f64::consts::TAU * s as f64 / 12.0;
            centre + vec3(0.7 * angle.cos(), 0.7 * angle.sin(), 0.0)
        };
        (0..12).for_each(|s| mesh(corner(s), [corner(s + 1) - corner(s), z], [4, 49], &mut out));
    }
    out
}

/// The scene of plates, with a medium or without.
pub(crate) fn scene(plates: &[Plate], voxel_grid: Option<VoxelGrid>) -> Scene {
    let surface = Surface { name: "all".into(), ..Surface::default() };
    let facets = plates.iter().map(|p| Facet { surface: 0, plate: *p, uv: [[0.0; 2]; 3] }).collect();
    let parts = SceneParts { surfaces: vec![surface], facets, voxel_grid, ..SceneParts::default() };
    Scene::new(parts).expect("a scene")
}

/// Ends of segments in the volume of a scene.
pub(crate) fn in_volume(scene: &Scene) -> Vec<Vec3> {
    let (lo, hi) = scene.bounds();
    let unit = |i: u64| vec3(hash_to_unit(3 * i), hash_to_unit(3 * i + 1), hash_to_unit(3 * i + 2));
    (0..2 * SEGMENT_COUNT as u64).map(|i| lo + unit(i).scale(hi - lo)).collect()
}

/// Ends of segments on plates.
pub(crate) fn on_surfaces(plates: &[Plate]) -> Vec<Vec3> {
    let point = |i: u64| {
        let p = &plates[(hash_to_unit(3 * i) * plates.len() as f64) as usize];
        let [u, v] = p.warp([hash_to_unit(3 * i + 1), hash_to_unit(3 * i + 2)]);
        p.at(u, v)
    };
    (0..2 * SEGMENT_COUNT as u64).map(point).collect()
}
