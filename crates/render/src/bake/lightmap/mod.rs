//! Lightmap: the irradiance of all surfaces as one texture, with a second set of texture coordinates.
//!
//! Coplanar facets of a surface that share edges form a chart: a flat map in metres, divided into square texels of edge h. The texel with its centre at the point
//! x of a facet has
//!
//! ```text
//!     T = Σ_g H_g(x) = Σ_g (H_ind,g(x) + H_dir,g(x, n))            W/m²
//! ```
//!
//! by the function that gives the vertices of [`super::bake`] their light. A viewer shows the radiance (E + ρT)/π. Texels beside a chart, of which bilinear
//! filtering takes a part, have the irradiance of the nearest point of the chart; further ones, and those of parts of facets without patches, take the mean of
//! their neighbours (dilation). Charts are `CHART_MARGIN` texels apart from each other's interior on all sides, so that no filter mixes two of them, nor the next
//! coarser level of a mipmap. The charts are packed by the crate guillotiere, the tallest first.
//!
//! | module | contents |
//! |---|---|
//! | `lightmap_data` | options and results |
//! | `charts` | from facets to flat charts |
//! | `packing` | places of the charts in the atlas |
//! | `texels` | light of the texels, dilation |
//! | `lightmap_mesh` | facets as triangles with both sets of texture coordinates |
//!
//! Cost: one evaluation of the light a texel that a chart covers or touches. The same bits for any number of threads.

mod charts;
mod lightmap_data;
mod lightmap_mesh;
mod packing;
mod texels;

pub use lightmap_data::{AtlasTooSmall, Lightmap, LightmapMesh, LightmapOptions};

use super::baked::SunlightMode;
use super::group_fields::GroupField;
use super::lit_scene::LitScene;
use super::vertex_lighting::VertexLighting;
use zonal_scene::{Progress, Solution};
use zonal_transport::Transport;

/// Bakes the lightmap of a solution. The same bits for any number of threads.
///
/// # Errors
/// If the charts do not fit into the atlas.
///
/// ```
/// use zonal_render::bake::lightmap::{LightmapOptions, bake_lightmap};
/// # use zonal_math::{Vec3, vec3};
/// # use zonal_scene::{
/// #     Bands, Facet, Fields, NoProgress, Plate, Report, Scene, SceneParts, Solution, Surface,
/// # };
/// # use zonal_transport::{Transport, build_zones};
/// # let wall = Surface {
/// #     name: "wall".into(),
/// #     reflectance: Bands::ZERO,
/// #     emission: Bands::ONE,
/// #     ..Surface::default()
/// # };
/// # let plate = Plate::parallelogram(Vec3::ZERO, vec3(2.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
/// # let scene = Scene::new(SceneParts {
/// #     surfaces: vec![wall],
/// #     facets: vec![Facet { surface: 0, plate, uv: [[0.0; 2]; 3] }],
/// #     ..SceneParts::default()
/// # })
/// # .unwrap();
/// # let zones = build_zones(&scene, &Transport::new(&scene)).unwrap();
/// # let zero = vec![Bands::ZERO; zones.len()];
/// # let incident = vec![Bands::splat(3.0); zones.len()];
/// # let mut fields = Fields::default();
/// # (fields.radiosity, fields.incident) = (vec![Bands::ONE; zones.len()], incident);
/// # (fields.direct, fields.error) = (zero.clone(), zero);
/// # let (groups, report) = (Vec::new(), Report::default());
/// # let (scene_hash, version) = (String::new(), String::new());
/// # let solution = Solution { scene, zones, fields, groups, report, further_blocks: Vec::new(), scene_hash, version };
/// // A rectangle of 2 × 1 m with the irradiance 3 W/m².
/// let options = LightmapOptions { texel: Some(0.1), ..LightmapOptions::default() };
/// let lightmap = bake_lightmap(&solution, &options, &NoProgress).unwrap();
/// assert_eq!(lightmap.covered, 20 * 10);
/// assert!(lightmap.irradiance.iter().all(|h| *h == [3.0; 3] || *h == [0.0; 3]));
/// ```
pub fn bake_lightmap(
    solution: &Solution,
    options: &LightmapOptions,
    progress: &dyn Progress,
) -> Result<Lightmap, AtlasTooSmall> {
    let charts = charts::flat_charts(solution);
    let atlas = packing::pack(&charts, options)?;
    // Prepare the light as for vertices.
    let transport = Transport::new(&solution.scene);
    let lit = LitScene::of(&solution.scene, SunlightMode::Baked);
    let shadow_rays = Transport::new(&lit.scene);
    let groups = GroupField::denoised_of_solution(solution);
    let lighting =
        VertexLighting::new(solution, &transport, &lit, &shadow_rays, &groups, options.light_samples);
    // Evaluate the texels chart by chart.
    let (irradiance, covered) = texels::light_texels(&lighting, &charts, &atlas, progress);
    let mesh = lightmap_mesh::mesh_facets(&solution.scene, &charts, &atlas);
    let (width, height) = (atlas.width, atlas.height);
    Ok(Lightmap { width, height, texel: atlas.texel, irradiance, charts: charts.len(), covered, mesh })
}

#[cfg(test)]
mod tests;
