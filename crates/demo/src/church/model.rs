//! The mesh of the church: one mesh per material, and the operations that add to it.
//!
//! Coordinates are metres, z up, the nave along y from west to east. The front of a face is where its corners run counter-clockwise; the caller
//! gives a point in front of each face, which fixes its orientation. Texture coordinates are metres over the picture's side.

use super::body::{ConvexCell, cut_by_plane};
use std::f64::consts::TAU;
use zonal_math::{Vec3, vec3};

/// A material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum ChurchMaterial {
    /// Courses of ashlar: walls.
    Ashlar,
    /// Dressed stone: columns, ribs, tracery, reveals.
    Dressed,
    /// Plastered webs of the vaults.
    Web,
    /// Floor tiles.
    Tiles,
    /// Oak: benches, door.
    Oak,
    /// Iron and lead: cames, chandeliers.
    Iron,
    /// Linen on the altar.
    Linen,
    /// The carpet along the aisle.
    Carpet,
    /// Wax of candles.
    Wax,
    /// Their flames.
    Flame,
    /// Glass of one of the hues of [`super::glass::HUES`].
    Glass(usize),
}

/// A mesh of triangles with texture coordinates.
#[derive(Clone, Debug, Default)]
pub(crate) struct MaterialMesh {
    /// Corners, m.
    pub positions: Vec<Vec3>,
    /// Texture coordinates, one a corner.
    pub uv: Vec<[f64; 2]>,
    /// Three corners each, counter-clockwise from the front.
    pub triangles: Vec<[u32; 3]>,
}

/// Meshes by material.
#[derive(Clone, Debug, Default)]
pub struct ChurchModel {
    /// In the order of [`ChurchMaterial`].
    pub(crate) meshes: std::collections::BTreeMap<ChurchMaterial, MaterialMesh>,
    /// Half-spaces n·x ≥ level that bodies of revolution and bars are cut to.
    keep: Vec<(Vec3, f64)>,
}

impl ChurchModel {
    /// Adds with `build`, bodies of revolution and bars cut to the half-spaces n·x ≥ level: flush with the walls they stand at.
    pub(crate) fn within(&mut self, half_spaces: &[(Vec3, f64)], build: impl FnOnce(&mut ChurchModel)) {
        let before = self.keep.len();
        self.keep.extend(half_spaces);
        build(self);
        self.keep.truncate(before);
    }

    /// A body of convex cells, clipped to the current half-spaces.
    fn body(&mut self, stuff: ChurchMaterial, cells: Vec<ConvexCell>) {
        let keep = self.keep.clone();
        let inside = |c: ConvexCell| keep.iter().try_fold(c, |c, (n, level)| cut_by_plane(c, *n, *level));
        for cell in cells.into_iter().filter_map(inside) {
            for (face, front) in &cell {
                front.iter().for_each(|f| self.polygon(stuff, face, *f));
            }
        }
    }

    /// A convex polygon in one plane, seen from `front`; texture coordinates by `flat_uv`.
    pub(crate) fn polygon(&mut self, stuff: ChurchMaterial, corners: &[Vec3], front: Vec3) {
        let normal = area_vector(corners).normalized();
        let seen = normal.dot(front - corners[0]) > 0.0;
        let normal = if seen { normal } else { -normal };
        let with_uv: Vec<(Vec3, [f64; 2])> = corners.iter().map(|&p| (p, flat_uv(p, normal))).collect();
        self.textured(stuff, &with_uv, front);
    }

    /// As `polygon`, with given texture coordinates.
    pub(crate) fn textured(&mut self, stuff: ChurchMaterial, corners: &[(Vec3, [f64; 2])], front: Vec3) {
        let points: Vec<Vec3> = corners.iter().map(|c| c.0).collect();
        let normal = area_vector(&points);
        if points.len() < 3 || normal.length() < 1e-7 {
            return;
        }
        let flip = normal.dot(front - points[0]) < 0.0;
        let mesh = self.meshes.entry(stuff).or_default();
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(&points);
        mesh.uv.extend(corners.iter().map(|c| c.1));
        for k in 1..points.len() as u32 - 1 {
            let corner = |a: u32| points[a as usize];
            let area = (corner(k) - corner(0)).cross(corner(k + 1) - corner(0)).length();
            if area > 1e-7 {
                let (b, c) = if flip { (k + 1, k) } else { (k, k + 1) };
                mesh.triangles.push([first, first + b, first + c]);
            }
        }
    }

    /// A box, closed.
    pub(crate) fn block(&mut self, stuff: ChurchMaterial, lo: Vec3, hi: Vec3) {
        self.prism(
            stuff,
            &[vec3(lo.x, lo.y, lo.z), vec3(hi.x, lo.y, lo.z), vec3(hi.x, hi.y, lo.z), vec3(lo.x, hi.y, lo.z)],
            vec3(0.0, 0.0, hi.z - lo.z),
        );
    }

    /// A convex polygon pushed along a vector: a closed body.
    pub(crate) fn prism(&mut self, stuff: ChurchMaterial, base: &[Vec3], along: Vec3) {
        let n = base.len();
        let middle = base.iter().fold(Vec3::ZERO, |s, &p| s + p) / n as f64;
        let outside = |p: Vec3| p + (p - (middle + along * 0.5)) * 1e-3;
        self.polygon(stuff, base, middle - along);
        let top: Vec<Vec3> = base.iter().map(|&p| p + along).collect();
        self.polygon(stuff, &top, middle + along * 2.0);
        for i in 0..n {
            let (a, b) = (base[i], base[(i + 1) % n]);
            let face = [a, b, b + along, a + along];
            let centre = face.iter().fold(Vec3::ZERO, |s, &p| s + p) * 0.25;
            let normal = (b - a).cross(along).normalized();
            let way = if normal.dot(centre - middle - along * 0.5) < 0.0 { -normal } else { normal };
            self.polygon(stuff, &face, outside(centre) + way);
        }
    }

    /// A body of revolution about the vertical through `foot`: radii r at heights z, from below, closed by discs.
    pub(crate) fn turned(&mut self, stuff: ChurchMaterial, foot: Vec3, profile: &[(f64, f64)], sides: usize) {
        let at = |k: usize, (r, z): (f64, f64)| {
            let angle = TAU * (k % sides) as f64 / sides as f64;
            foot + vec3(r * angle.cos(), r * angle.sin(), z)
        };
        let ring = |p: (f64, f64)| (0..sides).map(|k| at(k, p)).collect::<Vec<_>>();
        let last = profile.len() - 1;
        let disc = |k: usize, out: f64| {
            let end = if out < 0.0 { k == 0 } else { k == last };
            (ring(profile[k]), end.then(|| foot + vec3(0.0, 0.0, profile[k].1 + out)))
        };
        let cell = |(i, pair): (usize, &[(f64, f64)])| {
            let widest = pair[0].0.max(pair[1].0);
            let side = |k: usize| {
                let angle = TAU * (k as f64 + 0.5) / sides as f64;
                let (dr, dz) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
                let middle =
                    foot + vec3(widest * angle.cos(), widest * angle.sin(), 0.5 * (pair[0].1 + pair[1].1));
                let front = middle + (vec3(angle.cos(), angle.sin(), 0.0) * dz - vec3(0.0, 0.0, dr)) * 10.0;
                (vec![at(k, pair[0]), at(k + 1, pair[0]), at(k + 1, pair[1]), at(k, pair[1])], Some(front))
            };
            [disc(i, -1.0), disc(i + 1, 1.0)].into_iter().chain((0..sides).map(side)).collect()
        };
        self.body(stuff, profile.windows(2).enumerate().map(cell).collect());
    }

    /// A bar of a convex profile swept along a line, closed at its ends unless the line returns to its start. A profile point (a, b) lies
    /// a along `side` and b along the direction square to side and line.
    pub(crate) fn sweep(&mut self, stuff: ChurchMaterial, line: &[Vec3], side: Vec3, profile: &[[f64; 2]]) {
        let n = line.len();
        let closed = (line[0] - line[n - 1]).length() < 1e-9;
        let tangent = |i: usize| {
            let before =
                if i > 0 { Some(line[i] - line[i - 1]) } else { closed.then(|| line[n - 1] - line[n - 2]) };
            let after =
                if i + 1 < n { Some(line[i + 1] - line[i]) } else { closed.then(|| line[1] - line[0]) };
            let unit = |v: Option<Vec3>| v.map_or(Vec3::ZERO, Vec3::normalized);
            (unit(before) + unit(after)).normalized()
        };
        let rings: Vec<Vec<Vec3>> = (0..n)
            .map(|i| {
                let up = tangent(i).cross(side).normalized();
                profile.iter().map(|p| line[i] + side * p[0] + up * p[1]).collect()
            })
            .collect();
        let middle = |r: &[Vec3]| r.iter().fold(Vec3::ZERO, |s, &p| s + p) / r.len() as f64;
        let end = |i: usize, at_end: bool, way: f64| {
            (rings[i].clone(), (at_end && !closed).then(|| line[i] + tangent(i) * way))
        };
        let cell = |i: usize| {
            let (a, b) = (&rings[i], &rings[i + 1]);
            let axis = (middle(a) + middle(b)) * 0.5;
            let mut faces = vec![end(i, i == 0, -1.0), end(i + 1, i + 2 == n, 1.0)];
            for k in 0..profile.len() {
                let l = (k + 1) % profile.len();
                for face in [[a[k], a[l], b[l]], [a[k], b[l], b[k]]] {
                    let centre = (face[0] + face[1] + face[2]) / 3.0;
                    faces.push((face.to_vec(), Some(centre + (centre - axis) * 100.0)));
                }
            }
            faces
        };
        self.body(stuff, (0..n - 1).map(cell).collect());
    }
}

/// Twice the area of a polygon, along its normal.
pub(super) fn area_vector(corners: &[Vec3]) -> Vec3 {
    let from = |k: usize| corners[k] - corners[0];
    (1..corners.len().max(2) - 1).fold(Vec3::ZERO, |s, k| s + from(k).cross(from(k + 1)))
}

/// Texture coordinates, m, on a plane: along it and downwards on walls, along x and y on floors.
pub(super) fn flat_uv(p: Vec3, normal: Vec3) -> [f64; 2] {
    if normal.z.abs() > 0.8 {
        return [p.x, p.y];
    }
    let along = vec3(-normal.y, normal.x, 0.0).normalized();
    [p.dot(along), -p.z]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume(m: &MaterialMesh) -> f64 {
        let p = |i: u32| m.positions[i as usize];
        m.triangles.iter().map(|t| p(t[0]).cross(p(t[1])).dot(p(t[2])) / 6.0).sum()
    }

    #[test]
    fn bodies_are_closed_with_outward_faces() {
        let mut m = ChurchModel::default();
        m.block(ChurchMaterial::Oak, vec3(1.0, 2.0, 3.0), vec3(2.0, 4.0, 6.0));
        assert!((volume(&m.meshes[&ChurchMaterial::Oak]) - 6.0).abs() < 1e-12);
        m.turned(ChurchMaterial::Wax, vec3(5.0, 0.0, 1.0), &[(1.0, 0.0), (1.0, 2.0)], 64);
        let cylinder = 2.0 * 0.5 * 64.0 * (TAU / 64.0).sin();
        assert!((volume(&m.meshes[&ChurchMaterial::Wax]) - cylinder).abs() < 1e-12);
        let square = [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]];
        m.sweep(
            ChurchMaterial::Iron,
            &[Vec3::ZERO, vec3(0.0, 1.0, 0.0), vec3(0.0, 3.0, 0.0)],
            vec3(1.0, 0.0, 0.0),
            &square,
        );
        assert!((volume(&m.meshes[&ChurchMaterial::Iron]) - 0.12).abs() < 1e-12);
        m.turned(
            ChurchMaterial::Flame,
            vec3(0.0, 0.0, 0.0),
            &[(0.2, 0.0), (0.5, 0.0), (0.5, 0.3), (0.1, 0.3), (0.1, 1.0)],
            16,
        );
        assert!(volume(&m.meshes[&ChurchMaterial::Flame]) > 0.0);
        // Flush with two walls, a quarter of it is left, closed.
        let walls = [(vec3(1.0, 0.0, 0.0), 5.0), (vec3(0.0, -1.0, 0.0), 0.0)];
        m.within(&walls, |m| {
            m.turned(ChurchMaterial::Tiles, vec3(5.0, 0.0, 1.0), &[(1.0, 0.0), (1.0, 2.0)], 64)
        });
        assert!((volume(&m.meshes[&ChurchMaterial::Tiles]) - cylinder / 4.0).abs() < 1e-9);
    }
}
