//! Meshes in Wavefront's format, built from closed bodies and open sheets.
//!
//! Bodies have outward normals: each face runs counter-clockwise seen from outside. A body is a separate part of the mesh: no vertex is shared
//! between two of them.

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use zonal_math::low_discrepancy::hash_to_unit;

/// A mesh under construction.
#[derive(Default)]
pub(super) struct MeshText {
    vertices: usize,
    /// The text of the file.
    pub(super) text: String,
}

/// A point of the profile of a body of revolution: radius and height, m.
pub(super) type ProfilePoint = [f64; 2];

impl MeshText {
    /// The faces that follow have this material.
    pub(super) fn material(&mut self, name: &str) -> &mut MeshText {
        let _ = writeln!(self.text, "usemtl {name}");
        self
    }

    /// Adds vertices and faces, whose indices count from 0 among these vertices.
    pub(super) fn part<const N: usize>(
        &mut self,
        vertices: &[[f64; 3]],
        faces: &[[usize; N]],
    ) -> &mut MeshText {
        for [x, y, z] in vertices {
            let _ = writeln!(self.text, "v {x:.7} {y:.7} {z:.7}");
        }
        for face in faces {
            self.text.push('f');
            for k in face {
                let _ = write!(self.text, " {}", self.vertices + k + 1);
            }
            self.text.push('\n');
        }
        self.vertices += vertices.len();
        self
    }

    /// A box of twelve triangles, turned by `turn` radians about the vertical through its centre.
    pub(super) fn cuboid(&mut self, lo: [f64; 3], hi: [f64; 3], turn: f64) -> &mut MeshText {
        let centre = [0.5 * (lo[0] + hi[0]), 0.5 * (lo[1] + hi[1])];
        let (sin, cos) = turn.sin_cos();
        let corner = |k: usize| {
            let p = [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { hi[axis] } else { lo[axis] });
            let d = [p[0] - centre[0], p[1] - centre[1]];
            [centre[0] + cos * d[0] - sin * d[1], centre[1] + sin * d[0] + cos * d[1], p[2]]
        };
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let faces: Vec<[usize; 3]> =
            quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        self.part(&(0..8).map(corner).collect::<Vec<_>>(), &faces)
    }

    /// A body of revolution about the vertical through `axis`, closed by a point at each end: its profile runs from the lower end to the
    /// upper one, both of radius 0. Its normals point to the side `facing`.
    pub(super) fn revolution(
        &mut self,
        axis: [f64; 2],
        profile: &[ProfilePoint],
        segments: usize,
        facing: BodySide,
    ) -> &mut MeshText {
        let rings = &profile[1..profile.len() - 1];
        let (bottom, top) = (profile[0], profile[profile.len() - 1]);
        let mut vertices = vec![[axis[0], axis[1], bottom[1]]];
        for [r, z] in rings {
            vertices.extend((0..segments).map(|k| {
                let (sin, cos) = (TAU * k as f64 / segments as f64).sin_cos();
                [axis[0] + r * cos, axis[1] + r * sin, *z]
            }));
        }
        vertices.push([axis[0], axis[1], top[1]]);
        let at = |ring: usize, k: usize| 1 + ring * segments + k % segments;
        let (last, end) = (rings.len() - 1, vertices.len() - 1);
        let mut faces = Vec::new();
        for k in 0..segments {
            faces.push([0, at(0, k + 1), at(0, k)]);
            for ring in 0..last {
                let (a, b, c, d) = (at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k));
                faces.extend([[a, b, c], [a, c, d]]);
            }
            faces.push([at(last, k), at(last, k + 1), end]);
        }
        if facing == BodySide::Inside {
            faces.iter_mut().for_each(|f| f.swap(1, 2));
        }
        self.part(&vertices, &faces)
    }

    /// A sphere of 2 × `segments` × (`bands` − 1) triangles.
    pub(super) fn sphere(
        &mut self,
        centre: [f64; 3],
        radius: f64,
        cuts: [usize; 2],
        facing: BodySide,
    ) -> &mut MeshText {
        let [segments, bands] = cuts;
        let point = |k: usize| {
            let angle = PI * k as f64 / bands as f64;
            let r = if k == 0 || k == bands { 0.0 } else { radius * angle.sin() };
            [r, centre[2] - radius * angle.cos()]
        };
        let profile: Vec<ProfilePoint> = (0..=bands).map(point).collect();
        self.revolution([centre[0], centre[1]], &profile, segments, facing)
    }

    /// A vertical cylinder.
    pub(super) fn cylinder(
        &mut self,
        axis: [f64; 2],
        radius: f64,
        z: [f64; 2],
        segments: usize,
    ) -> &mut MeshText {
        let profile = [[0.0, z[0]], [radius, z[0]], [radius, z[1]], [0.0, z[1]]];
        self.revolution(axis, &profile, segments, BodySide::Outside)
    }
}

/// The side of a closed body to which its normals point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BodySide {
    /// A solid.
    Outside,
    /// A room.
    Inside,
}

/// Numbers that look random, functions of a seed: splitmix64.
pub(super) struct SeededNumbers(pub(super) u64);

impl SeededNumbers {
    /// The next number in [0, 1).
    pub(super) fn uniform(&mut self) -> f64 {
        let number = hash_to_unit(self.0);
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        number
    }

    /// The next number between two.
    pub(super) fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.uniform()
    }
}
