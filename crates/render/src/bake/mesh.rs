//! From the pieces of patches to triangles.
//!
//! A piece without a foreign corner on its edges is one triangle, or two along the diagonal that agrees better with its centre; any other
//! is a fan about its centre. Patches of one side of a facet share the vertices on their common border where they agree about the
//! light there.

use super::light::{Lights, interpolated};
use super::refine::refine;
use super::share::Share;
use super::tree::{Piece, Place, Tree, centre, corners};
use super::{BakeOptions, SurfaceMesh, seams, single};
use crate::patch_field::Layer;
use rayon::prelude::*;
use std::collections::HashMap;
use zonal_scene::{Bands, PlateKind, Progress, Solution};

/// Vertices whose light differs by less than this share of the larger are one.
const SAME: f32 = 0.02;
/// Steps of a facet's parameters within which two vertices are at the same place.
const STEPS: f64 = (1u64 << 26) as f64;

/// The mesh of one side of a facet.
#[derive(Default)]
struct Chunk {
    /// Patch and place of each vertex.
    vertices: Vec<(u32, Place)>,
    /// The values at each vertex, one after the other.
    values: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    zones: Vec<u32>,
}

/// The mesh of all patches.
pub(super) fn surfaces(
    s: &Solution,
    lights: &Lights,
    shares: &[Share],
    options: &BakeOptions,
    progress: &dyn Progress,
) -> SurfaceMesh {
    let mut trees = refine(lights, shares, options, progress);
    seams::close(lights, &mut trees);
    let tiles = lights.shape.tiles();
    let mut sheets: Vec<Vec<Tree>> = Vec::new();
    let mut order: Vec<Option<Tree>> = trees.into_iter().map(Some).collect();
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
    let chunks: Vec<Chunk> = sheets.into_par_iter().map(|trees| chunk(lights, trees)).collect();
    join(s, lights, shares, chunks)
}

fn chunk(lights: &Lights, trees: Vec<Tree>) -> Chunk {
    let mut out = Chunk::default();
    let mut shared = HashMap::new();
    for tree in &trees {
        let mut known: HashMap<Place, u32> = HashMap::new();
        for piece in &tree.pieces {
            for triangle in triangles(lights, tree, piece) {
                let ids = triangle.map(|place| {
                    *known.entry(place).or_insert_with(|| out.vertex(lights, tree, place, &mut shared))
                });
                out.triangles.push(ids);
                out.zones.push(tree.patch as u32);
            }
        }
    }
    out
}

impl Chunk {
    /// The vertex at a place of a patch: one that is there already and agrees, or a new one.
    fn vertex(
        &mut self,
        lights: &Lights,
        tree: &Tree,
        place: Place,
        shared: &mut HashMap<[i64; 2], Vec<u32>>,
    ) -> u32 {
        let n = lights.values();
        let values = tree.known(n, place);
        let facet = &lights.s.scene.facets()[lights.s.zones.patches[tree.patch].facet];
        let point = lights.place(tree.patch, Tree::parameters(place));
        let key = facet.plate.parameters(point).map(|x| (x * STEPS).round() as i64);
        let list = shared.entry(key).or_default();
        let same = |i: &&u32| {
            let there = &self.values[**i as usize * n..][..n];
            (0..n).all(|k| agree(there[k], values[k]))
        };
        if let Some(i) = list.iter().find(same) {
            return *i;
        }
        let i = self.vertices.len() as u32;
        self.vertices.push((tree.patch as u32, place));
        self.values.extend_from_slice(values);
        list.push(i);
        i
    }
}

fn agree(a: [f32; 3], b: [f32; 3]) -> bool {
    let most = a.iter().chain(&b).fold(0.0f32, |m, x| m.max(*x));
    (0..3).all(|k| (a[k] - b[k]).abs() <= SAME * most)
}

/// The triangles of a piece, counter-clockwise in the plate's parameters.
fn triangles(lights: &Lights, tree: &Tree, piece: &Piece) -> Vec<[Place; 3]> {
    let outline = tree.outline(piece);
    let corners = corners(tree.kind, piece);
    if outline.len() > corners.len() {
        let c = centre(tree.kind, piece);
        return (0..outline.len()).map(|k| [c, outline[k], outline[(k + 1) % outline.len()]]).collect();
    }
    if tree.kind == PlateKind::Triangle {
        return vec![[corners[0], corners[1], corners[2]]];
    }
    let n = lights.values();
    let sum = |p: Place| tree.known(n, p).iter().flatten().map(|x| *x as f64).sum::<f64>();
    let [a, b, c, d, m] = [corners[0], corners[1], corners[2], corners[3], centre(tree.kind, piece)].map(sum);
    let off = |x: f64, y: f64| (0.5 * (x + y) - m).abs();
    let [p, q, r, s] = [corners[0], corners[1], corners[2], corners[3]];
    if off(a, c) <= off(b, d) { vec![[p, q, r], [p, r, s]] } else { vec![[p, q, s], [q, r, s]] }
}

/// All chunks as one mesh, with the light of each group.
fn join(s: &Solution, lights: &Lights, shares: &[Share], chunks: Vec<Chunk>) -> SurfaceMesh {
    let mut mesh = SurfaceMesh::default();
    let mut vertices: Vec<(u32, Place)> = Vec::with_capacity(chunks.iter().map(|c| c.vertices.len()).sum());
    let mut values: Vec<[f32; 3]> = Vec::with_capacity(chunks.iter().map(|c| c.values.len()).sum());
    for c in chunks {
        let first = vertices.len() as u32;
        mesh.triangles.extend(c.triangles.iter().map(|t| t.map(|i| first + i)));
        mesh.zones.extend(c.zones);
        vertices.extend(c.vertices);
        values.extend(c.values);
    }
    let patch = |v: &(u32, Place)| &s.zones.patches[v.0 as usize];
    let on_facet = |v: &(u32, Place)| {
        let facet = &s.scene.facets()[patch(v).facet];
        facet.plate.parameters(lights.place(v.0 as usize, Tree::parameters(v.1)))
    };
    mesh.positions =
        vertices.par_iter().map(|v| single(lights.place(v.0 as usize, Tree::parameters(v.1)))).collect();
    mesh.normals = vertices.par_iter().map(|v| single(patch(v).normal)).collect();
    mesh.uvs = vertices
        .par_iter()
        .map(|v| {
            let [a, b] = on_facet(v);
            s.scene.facets()[patch(v).facet].uv_at(a, b).map(|x| x as f32)
        })
        .collect();
    mesh.surfaces = vertices.iter().map(|v| patch(v).surface as u32).collect();
    mesh.emission = vertices
        .par_iter()
        .map(|v| {
            let [a, b] = on_facet(v);
            s.scene.emission_at(patch(v).facet, a, b).map(|x| x as f32)
        })
        .collect();
    mesh.error = vertices.iter().map(|v| s.fields.error_of_all(v.0 as usize).map(|x| x as f32)).collect();
    mesh.irradiance = shares
        .iter()
        .zip(&lights.slots)
        .map(|(share, slot)| irradiance(lights, share, *slot, &vertices, &values))
        .collect();
    mesh
}

/// H + H_dir of one group at the vertices.
fn irradiance(
    lights: &Lights,
    share: &Share,
    slot: Option<usize>,
    vertices: &[(u32, Place)],
    values: &[[f32; 3]],
) -> Vec<[f32; 3]> {
    let patches = lights.s.zones.patches.len();
    let means: Vec<Bands> = (0..patches).into_par_iter().map(|i| interpolated(share, i)).collect();
    let (layer, n) = (Layer::new(means), lights.values());
    let one = |(i, v): (usize, &(u32, Place))| {
        let h = layer.at(&lights.shape, v.0 as usize, Tree::parameters(v.1));
        let direct = slot.map_or([0.0; 3], |k| values[i * n + k]);
        [0, 1, 2].map(|b| h[b] as f32 + direct[b])
    };
    vertices.par_iter().enumerate().map(one).collect()
}
