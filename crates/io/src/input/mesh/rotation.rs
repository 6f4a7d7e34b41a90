//! Rotations of placed meshes and grids.

use zonal_math::{Vec3, vec3};

/// Images of vectors of one length along x, y, z under rotations by degrees about x, then y, then z.
pub(crate) fn rotated_axes(degrees: Vec3, length: f64) -> [Vec3; 3] {
    let [(sx, cx), (sy, cy), (sz, cz)] = degrees.array().map(|a| a.to_radians().sin_cos());
    let rotate = |v: Vec3| {
        let v = vec3(v.x, cx * v.y - sx * v.z, sx * v.y + cx * v.z);
        let v = vec3(cy * v.x + sy * v.z, v.y, cy * v.z - sy * v.x);
        vec3(cz * v.x - sz * v.y, sz * v.x + cz * v.y, v.z)
    };
    [vec3(length, 0.0, 0.0), vec3(0.0, length, 0.0), vec3(0.0, 0.0, length)].map(rotate)
}
