//! Normals of curved surfaces at the corners of their facets, and normal maps: shading of pictures only.
//!
//! The solver sees flat facets. A picture of a facet with corner normals n_k and weights w_k(u, v), linear on a triangle and bilinear on a parallelogram, is shaded
//! at a point p with
//!
//! ```text
//! n(u, v) = Σ_k w_k n_k / |Σ_k w_k n_k|        p' = p + n_f max(0, Σ_k w_k (c_k − p)·n_k n_k·n_f)
//! ```
//!
//! with n_f the normal of the facet. n takes its place. p' lies about on a curved surface through the corners c_k with those normals, so that shadow rays towards a light close to the horizon do not
//! meet the neighbours of the facet (after J. Hanika, "Hacking the shadow terminator", in *Ray Tracing Gems II*, 2021). Normals that are tilted alike, as of a wall, raise nothing: Σ w_k c_k = p. A normal map turns n by a
//! texture t in the frame of the texture coordinates, with its red and green parts times a scale.

use crate::model::surface::{Facet, Texture};
use zonal_math::Vec3;

/// Least cosine between a normal of a corner and that of its facet: cos 80°. A normal farther off is an error of its file, and that of the facet takes its place.
const MIN_CORNER_COSINE: f64 = 0.173_648_177_666_930_35;
/// Largest difference of a normal of a corner from that of its facet below which the facet counts as flat.
const FLAT_TOLERANCE: f64 = 1e-4;

/// The unit normals at the corners of a plate, in the order of [`crate::Plate::corners`]; the fourth of a triangle is the third.
pub type CornerNormals = [[f32; 3]; 4];

/// A normal map of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalMap {
    /// Index of the surface.
    pub surface: usize,
    /// Index of the texture: its values x stand for the components 2x − 1 of the normal along u, against v and along the normal of the surface.
    pub texture: usize,
    /// Factor of the first two components.
    pub scale: f64,
}

/// Normals for the shading of pictures. Facets without an entry are flat.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShadingNormals {
    /// Facets with corner normals, ascending.
    facets: Vec<u32>,
    /// Their normals.
    corners: Vec<CornerNormals>,
    /// The normal maps, ascending by surface.
    pub maps: Vec<NormalMap>,
}

impl ShadingNormals {
    /// True without any normals.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.facets.is_empty() && self.maps.is_empty()
    }

    /// Appends the normals of a facet, which follows those that have normals already; normals that equal that of the facet are left out. Returns the number of corners whose normals are
    /// more than 80° from that of the facet, and not used.
    pub fn push(&mut self, facet: usize, of: &Facet, corners: &[Vec3; 4]) -> usize {
        let flat = of.plate.normal();
        let turned = corners.iter().all(|n| n.dot(flat) < 0.0);
        let (mut own, mut wrong) = ([flat; 4], 0);
        for (k, n) in corners.iter().enumerate() {
            // A file whose normals all point to the back of a face orients the face the other way.
            let n = if turned { -n.normalized() } else { n.normalized() };
            let is_usable = n.dot(flat) >= MIN_CORNER_COSINE;
            own[k] = if is_usable { n } else { flat };
            wrong += usize::from(!is_usable && k < of.plate.corners().1);
        }
        if own.iter().any(|n| (*n - flat).length() > FLAT_TOLERANCE) {
            self.push_checked(facet as u32, own.map(|n| n.array().map(|x| x as f32)));
        }
        wrong
    }

    /// Appends the corner normals of a facet as they are; [`crate::Scene::new`] checks them.
    pub fn push_checked(&mut self, facet: u32, corners: CornerNormals) {
        self.facets.push(facet);
        self.corners.push(corners);
    }

    /// The facets with corner normals, ascending, and their normals.
    pub fn facets(&self) -> impl ExactSizeIterator<Item = (usize, &CornerNormals)> {
        self.facets.iter().map(|f| *f as usize).zip(&self.corners)
    }

    /// The corner normals of a facet; `None` of a flat one.
    #[must_use]
    pub fn of_facet(&self, facet: usize) -> Option<[Vec3; 4]> {
        let place = self.facets.binary_search(&u32::try_from(facet).ok()?).ok()?;
        Some(self.corners[place].map(|n| Vec3::from_array(n.map(f64::from))))
    }

    /// The normal map of a surface.
    #[must_use]
    pub fn map_of(&self, surface: usize) -> Option<NormalMap> {
        let place = self.maps.binary_search_by_key(&surface, |m| m.surface).ok()?;
        Some(self.maps[place])
    }

    /// True if all entries are of facets, surfaces and textures that exist, in order, and all normals are unit vectors before their facets.
    pub(crate) fn is_valid(&self, facets: &[Facet], surfaces: usize, textures: usize) -> bool {
        let unit = |f: &Facet, n: &[f32; 3]| {
            let n = Vec3::from_array(n.map(f64::from));
            (n.length2() - 1.0).abs() < 1e-5 && n.dot(f.plate.normal()) > 0.5 * MIN_CORNER_COSINE
        };
        let is_usable =
            |(f, n): (usize, &CornerNormals)| facets.get(f).is_some_and(|f| n.iter().all(|n| unit(f, n)));
        let map = |m: &NormalMap| m.surface < surfaces && m.texture < textures && m.scale.is_finite();
        self.facets.is_sorted_by(|a, b| a < b)
            && self.facets.len() == self.corners.len()
            && self.facets().all(is_usable)
            && self.maps.is_sorted_by(|a, b| a.surface < b.surface)
            && self.maps.iter().all(map)
    }
}

/// One side of a facet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SidedFacet {
    /// Index of the facet.
    pub facet: usize,
    /// True of its front.
    pub front: bool,
}

impl SidedFacet {
    /// The side of a number in the order front and back of the first facet, of the second, and so on.
    #[must_use]
    pub fn of_number(number: usize) -> SidedFacet {
        SidedFacet { facet: number / 2, front: number.is_multiple_of(2) }
    }
}

/// A point of a picture's surface with the normal that shades it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadedPoint {
    /// The point on the curved surface, m, above the facet or on it.
    pub point: Vec3,
    /// Unit normal of the curved surface, on the side that is seen.
    pub normal: Vec3,
}

/// The point at parameters (u, v) of a facet with the corner normals `normals`, on the curved surface as its front or its back sees it, and the normal of the front.
pub(crate) fn curved_point(facet: &Facet, normals: &[Vec3; 4], front: bool, [u, v]: [f64; 2]) -> ShadedPoint {
    let (corners, n) = facet.plate.corners();
    let weights = match n {
        3 => [1.0 - u - v, u, v, 0.0],
        _ => [(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v],
    };
    let p = facet.plate.at(u, v);
    let side = if front { 1.0 } else { -1.0 };
    let flat = facet.plate.normal();
    let (mut normal, mut rise) = (Vec3::ZERO, 0.0);
    for k in 0..n {
        normal += normals[k] * weights[k];
        rise += weights[k] * side * (corners[k] - p).dot(normals[k]) * normals[k].dot(flat);
    }
    let point = p + flat * (side * rise.max(0.0));
    ShadedPoint { point, normal: normal.normalized() }
}

/// The normal `normal` turned by a normal map at a point of a facet.
pub(crate) fn mapped_normal(
    facet: &Facet,
    normal: Vec3,
    uv: [f64; 2],
    texture: &Texture,
    scale: f64,
) -> Vec3 {
    let [a, b] = [1, 2].map(|k| [facet.uv[k][0] - facet.uv[0][0], facet.uv[k][1] - facet.uv[0][1]]);
    let det = a[0] * b[1] - a[1] * b[0];
    if det == 0.0 || !det.is_finite() {
        return normal;
    }
    // The directions in which u grows, and v falls (v points down), in the plane across the normal.
    let along_u = (facet.plate.e1 * b[1] - facet.plate.e2 * a[1]) / det;
    let against_v = (facet.plate.e1 * b[0] - facet.plate.e2 * a[0]) / det;
    let tangent = (along_u - normal * along_u.dot(normal)).normalized();
    let bitangent = normal.cross(tangent);
    let bitangent = if bitangent.dot(against_v) < 0.0 { -bitangent } else { bitangent };
    let [x, y, z] = texture.sample(uv).to_rgb().map(|x| 2.0 * x - 1.0);
    let turned = tangent * (scale * x) + bitangent * (scale * y) + normal * z.max(0.0);
    let turned = turned.normalized();
    // A vector below the horizon of the facet would be black: it is raised to the horizon of the corner normals.
    let flat = facet.plate.normal();
    let low = MIN_CORNER_COSINE - turned.dot(flat);
    if turned.length2().is_nan() || turned.length2() <= 0.5 {
        return normal;
    }
    if low > 0.0 { (turned + flat * low).normalized() } else { turned }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::plate::Plate;
    use zonal_math::vec3;

    fn facet() -> Facet {
        let plate = Plate::triangle(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
        Facet { surface: 0, plate, uv: [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]] }
    }

    #[test]
    fn corner_normals_of_a_sphere_are_interpolated_and_raise_the_point_to_the_sphere() {
        let f = facet();
        let (c, _) = f.plate.corners();
        let mut shading = ShadingNormals::default();
        assert_eq!(shading.push(0, &f, &c), 0);
        let normals = shading.of_facet(0).unwrap();
        let middle = curved_point(&f, &normals, true, [1.0 / 3.0; 2]);
        assert!((middle.normal - vec3(1.0, 1.0, 1.0).normalized()).length() < 1e-6);
        assert!(middle.point.length() > 0.9 && middle.point.length() < 1.2, "{:?}", middle.point);
        let corner = curved_point(&f, &normals, true, [1.0, 0.0]);
        let back = curved_point(&f, &normals, false, [1.0 / 3.0; 2]);
        assert!((back.point - f.plate.centre()).length() < 1e-9, "the inside of the sphere does not rise");
        assert!((corner.normal - c[1]).length() < 1e-6 && (corner.point - c[1]).length() < 1e-9);
    }

    #[test]
    fn flat_and_wrong_normals_leave_the_facet_flat() {
        let f = facet();
        let flat = f.plate.normal();
        let mut shading = ShadingNormals::default();
        assert_eq!(shading.push(0, &f, &[flat; 4]), 0);
        assert_eq!(shading.push(0, &f, &[-flat; 4]), 0, "a face that the file turns around");
        let across = f.plate.e1.normalized();
        assert_eq!(shading.push(0, &f, &[flat, across, flat, flat]), 1);
        assert!(shading.is_empty());
        assert_eq!(shading.push(0, &f, &[Vec3::ZERO; 4]), 3);
        assert!(shading.is_empty());
    }

    #[test]
    fn normal_maps_turn_along_the_texture_coordinates() {
        let plate = Plate::triangle(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        // v points down: it falls along the second edge.
        let f = Facet { surface: 0, plate, uv: [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]] };
        let up = vec3(0.0, 0.0, 1.0);
        let map = |rgb: [f32; 3]| Texture { width: 1, height: 1, pixels: vec![rgb] };
        let at = |rgb, scale| mapped_normal(&f, up, [0.0; 2], &map(rgb), scale);
        assert!((at([0.5, 0.5, 1.0], 1.0) - up).length() < 1e-12);
        assert!((at([1.0, 0.5, 1.0], 1.0) - vec3(1.0, 0.0, 1.0).normalized()).length() < 1e-12);
        assert!((at([0.5, 1.0, 1.0], 0.5) - vec3(0.0, 0.5, 1.0).normalized()).length() < 1e-12);
        assert!(at([1.0, 0.5, 0.5], 1.0).z > 0.1, "no normal lies below the horizon");
    }
}
