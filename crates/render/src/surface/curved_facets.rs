//! Means of patches on facets that stand for a curved surface, as that surface has them.
//!
//! The patches of a facet share its normal, so that a field of irradiances steps from facet to facet. With M_f the mean of the field over facet f, V_k the mean of M over the facets that
//! share vertex k and the normal there, weighted by their angles at the vertex, and w_k the weights of the corners of f at the centre c of a patch, the mean of the patch becomes
//!
//! ```text
//! H' = H + Σ_k w_k(c) V_k − M_f
//! ```
//!
//! The sum is continuous from facet to facet. Facets of one patch stay: the interpolation between patches has the same effect there.

use std::collections::{BTreeMap, HashMap};
use zonal_math::Vec3;
use zonal_scene::{Bands, PlateKind, SidedFacet, Solution};
use zonal_transport::patch_locator::side_of_patch;

/// Least cosine between normals at a vertex that are of one surface: cos 20°.
const MIN_COS_SMOOTH: f64 = 0.939_692_620_785_908_4;
/// Distance over the scene's diagonal within which two vertices are one.
const VERTEX_TOLERANCE: f64 = 1e-8;

/// A side of a facet with its patches.
struct SidePatches {
    patches: Vec<u32>,
    /// The vertices of its corners; empty of a facet that stays as it is.
    vertices: Vec<u32>,
    /// For each patch the weights of the corners at its centre.
    weights: Vec<[f64; 4]>,
}

/// The facets of a solution that stand for curved surfaces.
#[derive(Default)]
pub(crate) struct CurvedFacets {
    sides: Vec<SidePatches>,
    /// For each vertex the sides that share it, with their angles.
    shares: Vec<Vec<(u32, f64)>>,
    /// Areas of the patches, m².
    areas: Vec<f64>,
}

/// A vertex in steps of the tolerance.
type VertexKey = [i64; 3];

/// The corners of a side of a facet: positions, normals and angles.
fn corners(s: &Solution, sheet: usize) -> Vec<(Vec3, Vec3, f64)> {
    let side = SidedFacet::of_number(sheet);
    let plate = &s.scene.facets()[side.facet].plate;
    let (at, n) = plate.corners();
    let flat = if side.front { plate.normal() } else { -plate.normal() };
    let uvs = [[0.0, 0.0], [1.0, 0.0], if n == 3 { [0.0, 1.0] } else { [1.0, 1.0] }, [0.0, 1.0]];
    let corner = |k: usize| {
        let normal = s.scene.curved_point(side, uvs[k], 0.0).map_or(flat, |p| p.normal);
        let (a, b) = ((at[(k + 1) % n] - at[k]).normalized(), (at[(k + n - 1) % n] - at[k]).normalized());
        (at[k], normal, a.dot(b).clamp(-1.0, 1.0).acos())
    };
    (0..n).map(corner).collect()
}

impl CurvedFacets {
    /// The curved facets of a solution, and the facets beside them.
    pub(crate) fn of(s: &Solution) -> CurvedFacets {
        let mut out = CurvedFacets::default();
        if s.scene.shading().facets().len() == 0 {
            return out;
        }
        out.areas = s.zones.patches.iter().map(|p| p.area).collect();
        let mut patches: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
        for (i, p) in s.zones.patches.iter().enumerate() {
            patches.entry(side_of_patch(&s.scene, p)).or_default().push(i as u32);
        }
        let step = (VERTEX_TOLERANCE * s.scene.diagonal()).max(f64::MIN_POSITIVE);
        let key = |p: Vec3| p.array().map(|x| (x / step).round() as i64);
        // The vertices of the curved facets, apart where their normals differ.
        let mut known: HashMap<VertexKey, Vec<(u32, Vec3)>> = HashMap::new();
        let is_smooth = |a: Vec3, b: Vec3| a.dot(b) >= MIN_COS_SMOOTH;
        let (mut count, mut sheets) = (0, Vec::new());
        for (sheet, own) in patches {
            let is_curved = own.len() > 1 && s.scene.shading().of_facet(sheet / 2).is_some();
            let mut side = SidePatches { patches: own, vertices: Vec::new(), weights: Vec::new() };
            if is_curved {
                for (p, normal, _) in corners(s, sheet) {
                    let list = known.entry(key(p)).or_default();
                    let found = list.iter().find(|(_, n)| is_smooth(*n, normal)).map(|(v, _)| *v);
                    side.vertices.push(found.unwrap_or_else(|| {
                        list.push((count, normal));
                        count += 1;
                        count - 1
                    }));
                }
                side.weights = weights_of_patches(s, sheet / 2, &side.patches);
            }
            out.sides.push(side);
            sheets.push(sheet);
        }
        // The sides that share them, in order.
        out.shares = vec![Vec::new(); count as usize];
        for (i, sheet) in sheets.into_iter().enumerate() {
            for (p, normal, angle) in corners(s, sheet) {
                let list = known.get(&key(p)).into_iter().flatten();
                let own = list.filter(|(_, n)| is_smooth(*n, normal));
                own.for_each(|(v, _)| out.shares[*v as usize].push((i as u32, angle)));
            }
        }
        out
    }

    /// Turns the means of patches, one a zone or patch, into those on the curved surfaces.
    pub(crate) fn adjust(&self, values: &mut [Bands]) {
        if self.shares.is_empty() {
            return;
        }
        let mean = |side: &SidePatches| {
            let area: f64 = side.patches.iter().map(|i| self.areas[*i as usize]).sum();
            let of = |i: &u32| values[*i as usize] * self.areas[*i as usize];
            side.patches.iter().map(of).sum::<Bands>() / area
        };
        let means: Vec<Bands> = self.sides.iter().map(mean).collect();
        let vertex = |shares: &Vec<(u32, f64)>| {
            let sum: Bands = shares.iter().map(|(i, w)| means[*i as usize] * *w).sum();
            sum / shares.iter().map(|(_, w)| w).sum::<f64>().max(f64::MIN_POSITIVE)
        };
        let vertices: Vec<Bands> = self.shares.iter().map(vertex).collect();
        for (side, mean) in self.sides.iter().zip(&means) {
            for (i, weights) in side.patches.iter().zip(&side.weights) {
                let at = |(v, w): (&u32, &f64)| vertices[*v as usize] * *w;
                let smooth: Bands = side.vertices.iter().zip(weights).map(at).sum();
                let value = &mut values[*i as usize];
                *value = (*value + smooth - *mean).max(Bands::ZERO);
            }
        }
    }
}

/// The weights of the corners of a facet at the centres of its patches.
fn weights_of_patches(s: &Solution, facet: usize, patches: &[u32]) -> Vec<[f64; 4]> {
    let plate = &s.scene.facets()[facet].plate;
    let of = |i: &u32| {
        let [u, v] = plate.parameters(s.zones.patches[*i as usize].plate.centre());
        match plate.kind {
            PlateKind::Triangle => [1.0 - u - v, u, v, 0.0],
            PlateKind::Parallelogram => [(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v],
        }
    };
    patches.iter().map(of).collect()
}
