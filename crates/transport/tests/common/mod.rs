//! Scenes and numbers that several tests share.
#![allow(dead_code, missing_docs)]

use zonal_math::{Vec3, sequence::unit, vec3};
use zonal_scene::{Facet, Plate, Scene, SceneParts, Sides, Surface, Voxmap};

/// Deterministic numbers in [0, 1).
pub(crate) struct Dice(pub u64);

impl Dice {
    pub(crate) fn roll(&mut self) -> f64 {
        self.0 += 1;
        unit(self.0)
    }
    pub(crate) fn point(&mut self) -> Vec3 {
        vec3(self.roll(), self.roll(), self.roll())
    }
}

pub(crate) fn surface(name: &str) -> Surface {
    Surface {
        name: name.into(),
        reflectance: [0.5, 0.4, 0.3],
        emission: [1.0, 2.0, 3.0],
        reflectance_texture: None,
        emission_texture: None,
        sides: Sides::Front,
        patch_size: None,
        solid: false,
    }
}

pub(crate) fn facet(surface: usize, plate: Plate) -> Facet {
    Facet { surface, plate, uv: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]] }
}

pub(crate) fn scene(surfaces: Vec<Surface>, facets: Vec<Facet>, voxmap: Option<Voxmap>) -> Scene {
    Scene::new(SceneParts { surfaces, facets, voxmap, ..SceneParts::default() }).unwrap()
}

/// A scene of plates that all belong to one surface.
pub(crate) fn plain(plates: &[Plate], voxmap: Option<Voxmap>) -> Scene {
    let facets = plates.iter().map(|p| facet(0, *p)).collect();
    scene(vec![surface("all")], facets, voxmap)
}

/// Six faces of the box [lo, hi] that look inward.
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

/// Six faces of the box [lo, hi] that look outward.
pub(crate) fn solid_box(lo: Vec3, hi: Vec3) -> Vec<Plate> {
    room(lo, hi).iter().map(Plate::flipped).collect()
}

/// The same plates turned by fixed angles about `c`.
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

/// A voxmap on the unit cube with the same κ everywhere.
pub(crate) fn fog(n: usize, kappa: f64) -> Voxmap {
    let h = 1.0 / n as f64;
    let mut v = Voxmap::new(Vec3::ZERO, Vec3::splat(h), [n; 3]).unwrap();
    for i in 0..v.len() {
        v.set(i, [kappa, 2.0 * kappa, 0.0], [0.5; 3], [1.0; 3], [0.0; 3]);
    }
    v.seal().unwrap()
}
