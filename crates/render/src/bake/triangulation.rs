//! From the cells of patches to triangles.
//!
//! A cell without a hanging vertex on its edges is one triangle, or two along the diagonal that agrees better with its centre; any
//! other is a fan about its centre. Patches of one side of a facet share the vertices on their common border where their light
//! agrees there.

use super::baked::{SurfaceMesh, single_vector};
use super::edge_matching::match_edges;
use super::group_fields::GroupField;
use super::patch_quadtree::{LatticePoint, PatchQuadtree, QuadtreeCell, centre, corners};
use super::vertex_lighting::{VertexLighting, interpolated};
use crate::image::to_single_precision;
use crate::surface::patch_field::TileField;
use rayon::prelude::*;
use std::collections::HashMap;
use zonal_math::Vec3;
use zonal_math::parallel;
use zonal_scene::{Band, Bands, Patch, PerBand, PlateKind, SidedFacet, Solution};

/// Relative difference of the light below which two vertices at one position are merged.
const MAX_MERGED_DIFFERENCE: f32 = 0.02;
/// Steps of a facet's parameters, per unit, within which two vertices are at one position.
const POSITION_STEPS: f64 = (1u64 << 26) as f64;

/// A vertex at a lattice point of a patch.
#[derive(Clone, Copy)]
struct PatchVertex {
    patch: u32,
    place: LatticePoint,
}

/// The mesh of one side of a facet.
#[derive(Default)]
struct SheetMesh {
    vertices: Vec<PatchVertex>,
    /// The values at each vertex, one after the other.
    values: Vec<PerBand<f32>>,
    triangles: Vec<[u32; 3]>,
    zones: Vec<u32>,
}

/// The mesh of all patches, from their trees.
pub(super) fn mesh_patches(
    lighting: &VertexLighting,
    groups: &[GroupField],
    mut trees: Vec<PatchQuadtree>,
) -> SurfaceMesh {
    match_edges(lighting, &mut trees);
    // Group the patches by sheet.
    let tiles = lighting.topology.tiles();
    let mut sheets: Vec<Vec<PatchQuadtree>> = Vec::new();
    let mut order: Vec<Option<PatchQuadtree>> = trees.into_iter().map(Some).collect();
    let mut by_sheet: Vec<usize> = (0..order.len()).collect();
    by_sheet.sort_by_key(|&i| (tiles[i].sheet, i));
    let mut last = usize::MAX;
    for i in by_sheet {
        if tiles[i].sheet != last {
            sheets.push(Vec::new());
            last = tiles[i].sheet;
        }
        sheets.last_mut().unwrap().extend(order[i].take());
    }
    let sheets: Vec<SheetMesh> = sheets.into_par_iter().map(|trees| mesh_sheet(lighting, trees)).collect();
    join_sheets(lighting, groups, sheets)
}

/// Triangulates the patches of one sheet.
fn mesh_sheet(lighting: &VertexLighting, trees: Vec<PatchQuadtree>) -> SheetMesh {
    let mut out = SheetMesh::default();
    let mut shared = HashMap::new();
    for tree in &trees {
        let mut known: HashMap<LatticePoint, u32> = HashMap::new();
        for cell in &tree.cells {
            for triangle in triangulate_cell(lighting, tree, cell) {
                let ids = triangle.map(|place| {
                    *known.entry(place).or_insert_with(|| out.vertex(lighting, tree, place, &mut shared))
                });
                out.triangles.push(ids);
                out.zones.push(tree.patch as u32);
            }
        }
    }
    out
}

impl SheetMesh {
    /// The vertex at a lattice point of a patch: an existing one whose light agrees, or a new one.
    fn vertex(
        &mut self,
        lighting: &VertexLighting,
        tree: &PatchQuadtree,
        place: LatticePoint,
        shared: &mut HashMap<[i64; 2], Vec<u32>>,
    ) -> u32 {
        let n = lighting.value_count();
        let values = tree.evaluated(n, place);
        let facet = &lighting.solution.scene.facets()[lighting.solution.zones.patches[tree.patch].facet];
        let point = lighting.point(tree.patch, PatchQuadtree::parameters(place));
        let key = facet.plate.parameters(point).map(|x| (x * POSITION_STEPS).round() as i64);
        let list = shared.entry(key).or_default();
        let agrees = |i: &&u32| {
            let there = &self.values[**i as usize * n..][..n];
            (0..n).all(|k| light_agrees(there[k], values[k]))
        };
        if let Some(i) = list.iter().find(agrees) {
            return *i;
        }
        let i = self.vertices.len() as u32;
        self.vertices.push(PatchVertex { patch: tree.patch as u32, place });
        self.values.extend_from_slice(values);
        list.push(i);
        i
    }
}

fn light_agrees(a: PerBand<f32>, b: PerBand<f32>) -> bool {
    let largest = a.iter().chain(&b).fold(0.0f32, |m, x| m.max(*x));
    Band::all().all(|k| (a[k] - b[k]).abs() <= MAX_MERGED_DIFFERENCE * largest)
}

/// The triangles of a cell, counter-clockwise in the plate's parameters.
fn triangulate_cell(
    lighting: &VertexLighting,
    tree: &PatchQuadtree,
    cell: &QuadtreeCell,
) -> Vec<[LatticePoint; 3]> {
    let outline = tree.outline(cell);
    let corners = corners(tree.kind, cell);
    if outline.len() > corners.len() {
        let c = centre(tree.kind, cell);
        return (0..outline.len()).map(|k| [c, outline[k], outline[(k + 1) % outline.len()]]).collect();
    }
    if tree.kind == PlateKind::Triangle {
        return vec![[corners[0], corners[1], corners[2]]];
    }
    let n = lighting.value_count();
    let sum = |p: LatticePoint| tree.evaluated(n, p).iter().flatten().map(|x| *x as f64).sum::<f64>();
    let [a, b, c, d, m] = [corners[0], corners[1], corners[2], corners[3], centre(tree.kind, cell)].map(sum);
    let error = |x: f64, y: f64| (0.5 * (x + y) - m).abs();
    let [p, q, r, s] = [corners[0], corners[1], corners[2], corners[3]];
    if error(a, c) <= error(b, d) { vec![[p, q, r], [p, r, s]] } else { vec![[p, q, s], [q, r, s]] }
}

/// All sheets as one mesh, with the light of each group.
fn join_sheets(lighting: &VertexLighting, groups: &[GroupField], sheets: Vec<SheetMesh>) -> SurfaceMesh {
    let s = lighting.solution;
    // Concatenate vertices and triangles.
    let mut all = SheetMesh::default();
    for c in sheets {
        let first = all.vertices.len() as u32;
        all.triangles.extend(c.triangles.iter().map(|t| t.map(|i| first + i)));
        all.zones.extend(c.zones);
        all.vertices.extend(c.vertices);
        all.values.extend(c.values);
    }
    // Evaluate the geometry and the emission at the vertices.
    let vertices = &all.vertices;
    let patch = |v: &PatchVertex| &s.zones.patches[v.patch as usize];
    let facet = |v: &PatchVertex| &s.scene.facets()[patch(v).facet];
    let point = |v: &PatchVertex| lighting.point(v.patch as usize, PatchQuadtree::parameters(v.place));
    let on_facet = |v: &PatchVertex| facet(v).plate.parameters(point(v));
    let uv = |v: &PatchVertex| {
        let [a, b] = on_facet(v);
        facet(v).uv_at(a, b).map(|x| x as f32)
    };
    let emission = |v: &PatchVertex| {
        let [a, b] = on_facet(v);
        to_single_precision(s.scene.emission_at(patch(v).facet, a, b))
    };
    let normal = |v: &PatchVertex| single_vector(shading_normal(s, patch(v), on_facet(v)));
    let error = |v: &PatchVertex| to_single_precision(s.fields.total_error(v.patch as usize));
    // Evaluate the irradiance of each group.
    let groups = || groups.iter().zip(&lighting.slots);
    SurfaceMesh {
        positions: parallel::map(vertices, |v| single_vector(point(v))),
        normals: parallel::map(vertices, normal),
        uvs: parallel::map(vertices, uv),
        surfaces: vertices.iter().map(|v| patch(v).surface as u32).collect(),
        irradiance: groups().map(|(group, slot)| group_irradiance(lighting, group, *slot, &all)).collect(),
        direct: groups().map(|(group, slot)| group_direct(lighting, group, *slot, &all)).collect(),
        emission: parallel::map(vertices, emission),
        error: vertices.iter().map(error).collect(),
        triangles: all.triangles,
        zones: all.zones,
    }
}

/// The normal on a patch at a point of its facet: that of the curved surface for which the facet stands, or of the patch.
fn shading_normal(s: &Solution, patch: &Patch, on_facet: [f64; 2]) -> Vec3 {
    let front = s.scene.facets()[patch.facet].plate.normal().dot(patch.normal) > 0.0;
    let curved = s.scene.curved_point(SidedFacet { facet: patch.facet, front }, on_facet, 0.0);
    curved.map_or(patch.normal, |at| at.normal)
}

/// H_dir of one group at the vertices; empty where it has none, or only that of separate suns.
fn group_direct(
    lighting: &VertexLighting,
    group: &GroupField,
    slot: Option<usize>,
    SheetMesh { vertices, values, .. }: &SheetMesh,
) -> Vec<[f32; 3]> {
    let (patches, n) = (lighting.solution.zones.patches.len(), lighting.value_count());
    match slot {
        Some(k) => (0..vertices.len()).map(|i| values[i * n + k].into_rgb()).collect(),
        None if group.is_smooth() => {
            let field = lighting.field_unless_zero((0..patches).map(|i| group.direct(i)).collect());
            parallel::map(vertices, |v| to_single_precision(at_vertex(&field, lighting, v)))
        }
        None => Vec::new(),
    }
}

/// A field, zero where there is none, at a vertex.
fn at_vertex(field: &Option<TileField>, lighting: &VertexLighting, v: &PatchVertex) -> Bands {
    let at = |f: &TileField| f.at(&lighting.topology, v.patch as usize, PatchQuadtree::parameters(v.place));
    field.as_ref().map(at).unwrap_or_default()
}

/// H + H_dir of one group at the vertices.
fn group_irradiance(
    lighting: &VertexLighting,
    group: &GroupField,
    slot: Option<usize>,
    SheetMesh { vertices, values, .. }: &SheetMesh,
) -> Vec<[f32; 3]> {
    let patches = lighting.solution.zones.patches.len();
    let means: Vec<Bands> = parallel::collect(patches, |i| interpolated(group, i));
    let (field, n) = (lighting.field_unless_zero(means), lighting.value_count());
    let one = |(i, v): (usize, &PatchVertex)| {
        let h = at_vertex(&field, lighting, v);
        let direct = slot.map_or(PerBand::default(), |k| values[i * n + k]);
        PerBand::from_fn(|b| h[b] as f32 + direct[b]).into_rgb()
    };
    vertices.par_iter().enumerate().map(one).collect()
}
