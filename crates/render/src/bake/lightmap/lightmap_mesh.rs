//! The facets as triangles with coordinates in their textures and in the lightmap.
//!
//! Where a corner of another facet lies inside an edge (a T-junction), the edge gets a vertex there, so that rasterization leaves no gaps; the facet is then a
//! fan about its centroid.

use super::charts::FlatChart;
use super::lightmap_data::LightmapMesh;
use super::packing::PackedAtlas;
use crate::bake::baked::single_vector;
use std::collections::{BTreeSet, HashMap, HashSet};
use zonal_math::Vec3;
use zonal_scene::{Scene, SidedFacet};

/// Distance over the scene's diagonal within which a corner lies on an edge.
const EDGE_TOLERANCE: f64 = 1e-7;
/// Cells of the grid of corners along the scene's diagonal.
const CELLS_ALONG_DIAGONAL: f64 = 64.0;

/// The mesh of all charts.
pub(super) fn mesh_facets(scene: &Scene, charts: &[FlatChart], atlas: &PackedAtlas) -> LightmapMesh {
    let mut mesh = LightmapMesh::default();
    let corners = CornerGrid::new(scene, charts);
    for (chart, place) in charts.iter().zip(&atlas.places) {
        let lightmap_uv = |p: Vec3| {
            let texels = place.texels(atlas.texel, chart.project(p));
            let uv = |k: usize, size: usize| ((place.at[k] as f64 + texels[k]) / size as f64) as f32;
            [uv(0, atlas.width), uv(1, atlas.height)]
        };
        for &side in &chart.sides {
            let facet = &scene.facets()[side / 2];
            let (own, n) = facet.plate.corners();
            let mut outline = corners.outline(&own[..n]);
            let first = mesh.positions.len() as u32;
            let count = outline.len() as u32;
            let triangles: Vec<[u32; 3]> = if outline.len() == n {
                (2..count).map(|k| [0, k - 1, k]).collect()
            } else {
                outline.push(facet.plate.centre());
                (0..count).map(|k| [count, k, (k + 1) % count]).collect()
            };
            for p in outline {
                let [u, v] = facet.plate.parameters(p);
                mesh.positions.push(single_vector(p));
                let curved = scene.curved_point(SidedFacet::of_number(side), [u, v], 0.0);
                mesh.normals.push(single_vector(curved.map_or(chart.normal, |at| at.normal)));
                mesh.uvs.push(facet.uv_at(u, v).map(|x| x as f32));
                mesh.lightmap_uvs.push(lightmap_uv(p));
                mesh.surfaces.push(facet.surface as u32);
            }
            let is_front = side.is_multiple_of(2);
            let turned = |t: [u32; 3]| if is_front { t } else { [t[0], t[2], t[1]] };
            mesh.triangles.extend(triangles.into_iter().map(|t| turned(t.map(|i| first + i))));
        }
    }
    mesh
}

/// The corners of all facets in a hash grid, each position once.
struct CornerGrid {
    cells: HashMap<[i64; 3], Vec<Vec3>>,
    /// Edge of a cell, m.
    cell: f64,
    /// Distance within which a corner lies on an edge, m.
    tolerance: f64,
}

impl CornerGrid {
    fn new(scene: &Scene, charts: &[FlatChart]) -> CornerGrid {
        let diagonal = scene.diagonal().max(f64::MIN_POSITIVE);
        let (cell, tolerance) = (diagonal / CELLS_ALONG_DIAGONAL, EDGE_TOLERANCE * diagonal);
        let (mut cells, mut known) = (HashMap::<[i64; 3], Vec<Vec3>>::new(), HashSet::new());
        for side in charts.iter().flat_map(|c| &c.sides) {
            let (corners, n) = scene.facets()[side / 2].plate.corners();
            for p in corners.into_iter().take(n).filter(|p| known.insert(cell_of(*p, tolerance))) {
                cells.entry(cell_of(p, cell)).or_default().push(p);
            }
        }
        CornerGrid { cells, cell, tolerance }
    }

    /// The corners of a plate, and those of others between them, in order.
    fn outline(&self, corners: &[Vec3]) -> Vec<Vec3> {
        let mut out = Vec::with_capacity(corners.len());
        for (k, &a) in corners.iter().enumerate() {
            out.push(a);
            out.extend(self.inside_edge(a, corners[(k + 1) % corners.len()]));
        }
        out
    }

    /// Corners inside an edge, from its start.
    fn inside_edge(&self, a: Vec3, b: Vec3) -> Vec<Vec3> {
        let length = (b - a).length();
        let along = (b - a) / length.max(f64::MIN_POSITIVE);
        // The cells about points on the edge, half a cell apart.
        let steps = (2.0 * length / self.cell).ceil() as usize + 1;
        let mut near = BTreeSet::new();
        for k in 0..=steps {
            let c = cell_of(a + (b - a) * (k as f64 / steps as f64), self.cell);
            for n in 0..27i64 {
                near.insert([c[0] + n / 9 - 1, c[1] + n / 3 % 3 - 1, c[2] + n % 3 - 1]);
            }
        }
        let place = |p: &Vec3| (*p - a).dot(along);
        let is_inside = |p: &&Vec3| {
            let t = place(p);
            t > 2.0 * self.tolerance
                && t < length - 2.0 * self.tolerance
                && (**p - a - along * t).length() <= self.tolerance
        };
        let mut found: Vec<Vec3> =
            near.iter().filter_map(|c| self.cells.get(c)).flatten().filter(is_inside).copied().collect();
        found.sort_by(|p, q| place(p).total_cmp(&place(q)));
        found.dedup_by(|p, q| place(p) - place(q) <= 2.0 * self.tolerance);
        found
    }
}

/// The cell, of edge `cell` (m), that contains a point.
fn cell_of(p: Vec3, cell: f64) -> [i64; 3] {
    p.array().map(|x| (x / cell).floor() as i64)
}
