//! Scenes and random numbers shared by the tests.
#![allow(dead_code, missing_docs)]

use zonal_math::{Vec3, low_discrepancy::hash_to_unit, vec3};
use zonal_scene::{Bands, Facet, Plate, Scene, SceneParts, Surface, VoxelGrid};

/// Deterministic random numbers in [0, 1).
pub(crate) struct TestRng(pub u64);

impl TestRng {
    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 += 1;
        hash_to_unit(self.0)
    }
    pub(crate) fn point(&mut self) -> Vec3 {
        vec3(self.uniform(), self.uniform(), self.uniform())
    }
}

pub(crate) fn surface(name: &str) -> Surface {
    Surface {
        name: name.into(),
        reflectance: Bands::from_rgb([0.5, 0.4, 0.3]),
        emission: Bands::from_rgb([1.0, 2.0, 3.0]),
        ..Surface::default()
    }
}

pub(crate) fn facet(surface: usize, plate: Plate) -> Facet {
    Facet { surface, plate, uv: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]] }
}

pub(crate) fn scene(surfaces: Vec<Surface>, facets: Vec<Facet>, voxel_grid: Option<VoxelGrid>) -> Scene {
    Scene::new(SceneParts { surfaces, facets, voxel_grid, ..SceneParts::default() }).unwrap()
}

/// A scene of plates that all belong to one surface.
pub(crate) fn plain(plates: &[Plate], voxel_grid: Option<VoxelGrid>) -> Scene {
    let facets = plates.iter().map(|p| facet(0, *p)).collect();
    scene(vec![surface("all")], facets, voxel_grid)
}

/// The six faces of the box [lo, hi], normals inward.
pub(crate) fn room(lo: Vec3, hi: Vec3) -> Vec<Plate> {
    let e = hi - lo;
    let (x, y, z) = (vec3(e.x, 0.0, 0.0), vec3(0.0, e.y, 0.0), vec3(0.0, 0.0, e.z));
    vec![
        Plate::parallelogram(lo, x, y),
        Plate::parallelogram(lo, y, z),
        Plate::parallelogram(lo, z, x),
        Plate::parallelogram(hi, -y, -x),
        Plate::parallelogram(hi, -z, -y),
        Plate::parallelogram(hi, -x, -z),
    ]
}

/// The six faces of the box [lo, hi], normals outward.
pub(crate) fn solid_box(lo: Vec3, hi: Vec3) -> Vec<Plate> {
    room(lo, hi).iter().map(Plate::flipped).collect()
}

/// The plates rotated about `c` by `angle` about z and 0.7 `angle` about x.
pub(crate) fn turned(plates: &[Plate], c: Vec3, angle: f64) -> Vec<Plate> {
    let (s, k) = angle.sin_cos();
    let turn = |v: Vec3| {
        let v = vec3(k * v.x - s * v.y, s * v.x + k * v.y, v.z);
        let (s, k) = (0.7 * angle).sin_cos();
        vec3(v.x, k * v.y - s * v.z, s * v.y + k * v.z)
    };
    plates
        .iter()
        .map(|p| Plate { origin: c + turn(p.origin - c), e1: turn(p.e1), e2: turn(p.e2), kind: p.kind })
        .collect()
}

/// A parallelogram as 2 n² triangles.
pub(crate) fn mesh(p: &Plate, n: usize) -> Vec<Plate> {
    let at = |i: usize, j: usize| p.at(i as f64 / n as f64, j as f64 / n as f64);
    let mut out = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            out.push(Plate::triangle(a, b, c));
            out.push(Plate::triangle(a, c, d));
        }
    }
    out
}

/// A voxel grid on the unit cube with uniform κ.
pub(crate) fn fog(n: usize, kappa: f64) -> VoxelGrid {
    let h = 1.0 / n as f64;
    let mut v = VoxelGrid::new(Vec3::ZERO, Vec3::splat(h), [n; 3]).unwrap();
    for i in 0..v.len() {
        v.set(i, Bands::from_rgb([kappa, 2.0 * kappa, 0.0]), Bands::splat(0.5), Bands::ONE, Bands::ZERO);
    }
    v.seal().unwrap()
}
