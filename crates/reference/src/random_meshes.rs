//! Random meshes for view factors: rooms with boxes, plates, triangles, terraces, prisms, cities, extruded cross-sections.
//!
//! A mesh is a function of kind and random numbers alone. Lengths are of the order of 1 m; faces are convex, counter-clockwise from their fronts.

use crate::Rng;
use crate::crossed_strings::Wall;
use std::f64::consts::TAU;
use zonal_math::{Vec3, vec3};

/// The kinds of meshes in space.
pub const MESH_KINDS: [&str; 10] = [
    "empty rooms",
    "boxes in a room",
    "plates",
    "triangles",
    "L-shapes",
    "terraces",
    "tilted polygons",
    "touching and intersecting plates",
    "hollow box",
    "city",
];

/// The kinds of cross-sections that repeat along y.
pub const SECTION_KINDS: [&str; 4] = ["duct", "duct with bodies", "canyon", "sheds in a duct"];

/// Distance of a cover from its floor, m: its effect on factors is of this order.
const COVER_HEIGHT: f64 = 1e-8;

/// Facets of a mesh.
#[derive(Clone, Debug, Default)]
pub struct RandomMesh {
    /// Corners of each facet, m.
    pub facets: Vec<Vec<Vec3>>,
    /// Polygons within solids that stand on a floor, m, just above it. They only hide: what lies within a solid sees no floor, although the bottom
    /// of the solid and the floor coincide.
    pub covers: Vec<Vec<Vec3>>,
}

/// Walls in the x-z plane, fronts to the left, that extend along y without end.
#[derive(Clone, Debug)]
pub struct RandomSection {
    /// The walls, m.
    pub walls: Vec<Wall>,
    /// Period along y, m.
    pub period: f64,
}

impl RandomMesh {
    /// A mesh of a kind.
    ///
    /// # Panics
    /// On a kind beyond the list.
    pub fn new(kind: usize, rng: &mut Rng) -> RandomMesh {
        let mut mesh = RandomMesh::default();
        match MESH_KINDS[kind] {
            "empty rooms" => mesh.cuboid(Vec3::ZERO, random_size(rng, 0.3, 3.0), true),
            "boxes in a room" => mesh.boxes_in_a_room(rng),
            "plates" => (0..4).for_each(|_| mesh.plate(rng, 2)),
            "triangles" => (0..10).for_each(|_| mesh.facets.push(random_polygon(rng, 3, 1.2))),
            "L-shapes" => mesh.l_shape(rng),
            "terraces" => mesh.terrace(rng),
            "tilted polygons" => {
                (0..7).for_each(|k| mesh.facets.push(random_polygon(rng, 3 + k % 6, 1.0)));
            }
            "hollow box" => mesh.hollow_box(rng),
            "touching and intersecting plates" => mesh.touching_plates(rng),
            _ => mesh.city(rng),
        }
        if rng.uniform() < 0.5 {
            mesh.turn(rng);
        }
        mesh
    }

    /// The faces of a box, fronts outwards or inwards.
    fn cuboid(&mut self, lo: Vec3, size: Vec3, inwards: bool) {
        for axis in 0..3 {
            for high in [false, true] {
                let unit = |k: usize| {
                    let mut x = [0.0; 3];
                    x[k] = size.array()[k];
                    Vec3::from_array(x)
                };
                let at = if high { lo + unit(axis) } else { lo };
                let (e, f) = (unit((axis + 1) % 3), unit((axis + 2) % 3));
                let (e, f) = if high != inwards { (e, f) } else { (f, e) };
                self.facets.push(vec![at, at + e, at + e + f, at + f]);
            }
        }
    }

    /// A box seen from both sides, beside another one.
    fn hollow_box(&mut self, rng: &mut Rng) {
        let size = random_size(rng, 0.4, 1.5);
        self.cuboid(Vec3::ZERO, size, rng.uniform() < 0.5);
        let twins: Vec<Vec<Vec3>> = self.facets.iter().map(|c| c.iter().rev().copied().collect()).collect();
        self.facets.extend(twins);
        self.cuboid(vec3(size.x + rng.uniform_in(0.0, 0.5), 0.2, 0.1), random_size(rng, 0.3, 0.8), false);
    }

    fn boxes_in_a_room(&mut self, rng: &mut Rng) {
        self.cuboid(Vec3::ZERO, vec3(3.0, 2.5, 2.0), true);
        for _ in 0..1 + (rng.uniform() * 2.0) as usize {
            let size = random_size(rng, 0.3, 1.2);
            let free = vec3(3.0, 2.5, 2.0) - size;
            let mut lo = vec3(rng.uniform() * free.x, rng.uniform() * free.y, rng.uniform() * free.z);
            if rng.uniform() < 0.5 {
                lo.z = 0.0;
                let corner = |u: f64, v: f64| vec3(lo.x + u * size.x, lo.y + v * size.y, COVER_HEIGHT);
                self.covers.push(vec![
                    corner(0.0, 0.0),
                    corner(1.0, 0.0),
                    corner(1.0, 1.0),
                    corner(0.0, 1.0),
                ]);
            }
            self.cuboid(lo, size, false);
        }
    }

    /// A rectangle with one or two fronts.
    fn plate(&mut self, rng: &mut Rng, sides: usize) {
        let at = rng.point_in_box(Vec3::ZERO, Vec3::splat(1.5));
        let (e, f) = rng.unit_vector().frame();
        let (e, f) = (e * rng.uniform_in(0.2, 1.2), f * rng.uniform_in(0.2, 1.2));
        let c = vec![at, at + e, at + e + f, at + f];
        if sides == 2 {
            self.facets.push(c.iter().rev().copied().collect());
        }
        self.facets.push(c);
    }

    /// A prism over an L, its top in two parts, on a ground.
    fn l_shape(&mut self, rng: &mut Rng) {
        let (a, b) = (rng.uniform_in(0.3, 0.9), rng.uniform_in(0.3, 0.9));
        let h = rng.uniform_in(0.2, 1.5);
        let outline = [[0.0, 0.0], [1.4, 0.0], [1.4, b], [a, b], [a, 1.2], [0.0, 1.2]];
        for k in 0..6 {
            let ([x, y], [u, v]) = (outline[k], outline[(k + 1) % 6]);
            self.facets.push(vec![vec3(x, y, 0.0), vec3(u, v, 0.0), vec3(u, v, h), vec3(x, y, h)]);
        }
        self.horizontal([0.0, 1.4], [0.0, b], h);
        self.horizontal([0.0, a], [b, 1.2], h);
        self.horizontal([1.4, 2.5], [0.0, 1.2], 0.0);
        self.horizontal([a, 1.4], [b, 1.2], 0.0);
    }

    fn horizontal(&mut self, [x, u]: [f64; 2], [y, v]: [f64; 2], z: f64) {
        self.facets.push(vec![vec3(x, y, z), vec3(u, y, z), vec3(u, v, z), vec3(x, v, z)]);
    }

    /// Steps along x, under a slab.
    fn terrace(&mut self, rng: &mut Rng) {
        let width = rng.uniform_in(0.5, 2.0);
        let (mut x, mut z) = (0.0, 0.0);
        for _ in 0..4 {
            let (run, rise) = (rng.uniform_in(0.2, 0.8), rng.uniform_in(-0.2, 0.5));
            self.horizontal([x, x + run], [0.0, width], z);
            x += run;
            let c = [vec3(x, 0.0, z), vec3(x, 0.0, z + rise), vec3(x, width, z + rise), vec3(x, width, z)];
            self.facets.push(c.to_vec());
            z += rise;
        }
        let (low, high) = (rng.uniform_in(0.0, 1.0), rng.uniform_in(1.2, 2.5));
        let c = [[low, 0.0], [low, width], [high, width], [high, 0.0]].map(|[x, y]| vec3(x, y, 2.2));
        self.facets.push(c.to_vec());
    }

    /// Plates with a common edge, one that crosses them, one that touches with a corner.
    fn touching_plates(&mut self, rng: &mut Rng) {
        let angle = rng.uniform_in(0.3, 2.5);
        let edge = vec3(0.0, rng.uniform_in(0.5, 1.5), 0.0);
        let (e, f) = (vec3(1.0, 0.0, 0.0), vec3(angle.cos(), 0.0, angle.sin()));
        self.facets.push(vec![Vec3::ZERO, e, e + edge, edge]);
        self.facets.push(vec![Vec3::ZERO, edge, edge + f, f]);
        let y = rng.uniform_in(0.1, 0.4);
        let crossing =
            [vec3(0.2, y, -0.3), vec3(0.9, y, -0.3), vec3(0.9, y + 0.2, 0.8), vec3(0.2, y + 0.2, 0.8)];
        self.facets.push(crossing.iter().rev().copied().collect());
        self.facets.push(crossing.to_vec());
        let tip = e * 0.5 + edge * 0.7;
        let triangle = [tip, tip + vec3(0.3, 0.2, 0.7), tip + vec3(-0.3, 0.1, 0.6)];
        self.facets.push(triangle.iter().rev().copied().collect());
        self.facets.push(triangle.to_vec());
        self.plate(rng, 1);
    }

    /// Two boxes on a ground of four parts.
    fn city(&mut self, rng: &mut Rng) {
        for (x, y) in [(0.0, 0.0), (2.0, 0.0)] {
            let size = vec3(rng.uniform_in(0.6, 1.4), rng.uniform_in(0.6, 1.4), rng.uniform_in(0.3, 2.0));
            self.cuboid(vec3(x + 0.3, y + 0.3, 0.0), size, false);
            self.facets.remove(self.facets.len() - 2);
        }
        for (x, y) in [(0.0, -1.5), (2.0, -1.5), (0.0, 2.0), (2.0, 2.0)] {
            self.horizontal([x, x + 2.0], [y, y + 1.5], 0.0);
        }
    }

    /// Turns the mesh to a random position.
    fn turn(&mut self, rng: &mut Rng) {
        let z = rng.unit_vector();
        let (x, y) = z.frame();
        let at = rng.point_in_box(Vec3::splat(-3.0), Vec3::splat(3.0));
        for c in self.facets.iter_mut().chain(&mut self.covers).flatten() {
            *c = at + x * c.x + y * c.y + z * c.z;
        }
    }
}

fn random_size(rng: &mut Rng, low: f64, high: f64) -> Vec3 {
    vec3(rng.uniform_in(low, high), rng.uniform_in(low, high), rng.uniform_in(low, high))
}

/// A polygon inscribed in an ellipse.
fn random_polygon(rng: &mut Rng, corners: usize, spread: f64) -> Vec<Vec3> {
    let at = rng.point_in_box(Vec3::ZERO, Vec3::splat(spread));
    let (e, f) = rng.unit_vector().frame();
    let (e, f, start) = (e * rng.uniform_in(0.2, 0.8), f * rng.uniform_in(0.2, 0.8), rng.uniform());
    let corner = |k: usize| {
        let a = TAU * (start + k as f64 / corners as f64);
        at + e * a.cos() + f * a.sin()
    };
    (0..corners).map(corner).collect()
}

impl RandomSection {
    /// A section of a kind; its period is a hundredth to a hundred times its size.
    ///
    /// # Panics
    /// On a kind beyond the list.
    pub fn new(kind: usize, rng: &mut Rng) -> RandomSection {
        let height = 10f64.powf(rng.uniform_in(-2.0, 2.0));
        let period = height.max(1.0) * 10f64.powf(rng.uniform_in(-2.0, 2.0));
        let mut walls = Vec::new();
        let name = SECTION_KINDS[kind];
        let lean = rng.uniform_in(-0.2, 0.2);
        let ring = [[0.0, 0.0], [1.0, 0.0], [1.0 + lean, height], [lean, height]];
        let parts = if name == "canyon" { 3 } else { 4 };
        // A canyon is open above; the third side is its sky.
        let sides = [0, 1, 3, 2];
        for side in sides.into_iter().take(parts) {
            walls.push([ring[side], ring[(side + 1) % 4]]);
        }
        let at = |u: f64, v: f64| [u + lean * v, v * height];
        match name {
            "duct with bodies" => {
                let (u, v, r) =
                    (rng.uniform_in(0.3, 0.7), rng.uniform_in(0.3, 0.7), rng.uniform_in(0.05, 0.25));
                let body = [at(u - r, v - r), at(u, v + r), at(u + r, v - 0.3 * r)];
                (0..3).for_each(|k| walls.push([body[k], body[(k + 1) % 3]]));
            }
            "canyon" => {
                let v = rng.uniform_in(0.3, 0.9);
                let sheet = [at(rng.uniform_in(0.1, 0.4), v), at(rng.uniform_in(0.5, 0.9), v)];
                walls.extend([sheet, [sheet[1], sheet[0]]]);
            }
            "sheds in a duct" => {
                for k in 0..3 {
                    let u = 0.1 + 0.3 * f64::from(k);
                    let sheet = [at(u, 0.2), at(u + rng.uniform_in(-0.05, 0.2), rng.uniform_in(0.4, 0.8))];
                    walls.extend([sheet, [sheet[1], sheet[0]]]);
                }
            }
            _ => {}
        }
        RandomSection { walls, period }
    }

    /// The walls over one period as rectangles, or, with `parts`, each as two triangles.
    pub fn facets(&self, parts: bool) -> Vec<Vec<Vec3>> {
        let mut out = Vec::new();
        for [p, q] in &self.walls {
            let at = |c: &[f64; 2], y: f64| vec3(c[0], y, c[1]);
            // The front of a wall is to the left of p → q for an observer who sees x to the right and z up, thus looks along +y.
            let c = [at(p, 0.0), at(p, self.period), at(q, self.period), at(q, 0.0)];
            let c = [c[3], c[2], c[1], c[0]];
            if parts {
                out.extend([vec![c[0], c[1], c[2]], vec![c[0], c[2], c[3]]]);
            } else {
                out.push(c.to_vec());
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fronts_of_sections_are_to_the_left() {
        let section = RandomSection { walls: vec![[[0.0, 0.0], [1.0, 0.0]]], period: 2.0 };
        let c = &section.facets(false)[0];
        // The front of a floor from left to right looks up.
        assert!((c[1] - c[0]).cross(c[2] - c[0]).z > 0.0, "{c:?}");
    }

    #[test]
    fn every_kind_has_flat_facets() {
        let mut rng = Rng::new(3);
        for kind in 0..MESH_KINDS.len() {
            for c in RandomMesh::new(kind, &mut rng).facets {
                let n = (c[1] - c[0]).cross(c[2] - c[0]).normalized();
                assert!(c.iter().all(|p| n.dot(*p - c[0]).abs() < 1e-12), "{kind}: {c:?}");
            }
        }
    }
}
