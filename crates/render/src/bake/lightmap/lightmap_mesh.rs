//! The facets as triangles with coordinates in their textures and in the lightmap.

use super::charts::FlatChart;
use super::lightmap_data::LightmapMesh;
use super::packing::PackedAtlas;
use crate::bake::baked::single_vector;
use zonal_math::Vec3;
use zonal_scene::{PlateKind, Scene};

/// The mesh of all charts.
pub(super) fn mesh_facets(scene: &Scene, charts: &[FlatChart], atlas: &PackedAtlas) -> LightmapMesh {
    let mut mesh = LightmapMesh::default();
    for (chart, place) in charts.iter().zip(&atlas.places) {
        let lightmap_uv = |p: Vec3| {
            let texels = place.texels(atlas.texel, chart.project(p));
            let uv = |k: usize, size: usize| ((place.at[k] as f64 + texels[k]) / size as f64) as f32;
            [uv(0, atlas.width), uv(1, atlas.height)]
        };
        for &side in &chart.sides {
            let facet = &scene.facets()[side / 2];
            let first = mesh.positions.len() as u32;
            let corners: &[[f64; 2]] = match facet.plate.kind {
                PlateKind::Triangle => &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
                PlateKind::Parallelogram => &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
            };
            for &[u, v] in corners {
                let p = facet.plate.at(u, v);
                mesh.positions.push(single_vector(p));
                mesh.normals.push(single_vector(chart.normal));
                mesh.uvs.push(facet.uv_at(u, v).map(|x| x as f32));
                mesh.lightmap_uvs.push(lightmap_uv(p));
                mesh.surfaces.push(facet.surface as u32);
            }
            for k in 2..corners.len() as u32 {
                let t = [0, k - 1, k].map(|i| first + i);
                mesh.triangles.push(if side.is_multiple_of(2) { t } else { [t[0], t[2], t[1]] });
            }
        }
    }
    mesh
}
