//! Baking: a solution on triangles, which viewers and other engines draw from anywhere without tracing rays.
//!
//! Light groups stay separate, so that a viewer can scale lights. At a vertex x of a patch with normal n, of group g,
//!
//! ```text
//!     H_g(x) = H_ind,g(x) + H_dir,g(x, n)            B(x) = Σ_g f_g (E_g(x) + ρ(x) H_g(x))
//! ```
//!
//! H_ind is the interpolated field of the renderer, H_dir is sampled at the vertex. Direct light of skies, which is smooth, is interpolated
//! with H_ind where its group is its own; that of suns may be left to viewers ([`SunlightMode`]). E belongs to one group a surface, and ρ stays with the surface (factor times texture), so that
//! viewers may texture each pixel.
//!
//! Each patch is a quadtree whose cells are split where the light inside differs from linear interpolation (`patch_quadtree`,
//! `refinement`): the error at edge midpoints and centre, relative to the values nearby, against `tolerance`. Cells with the largest
//! error are split first when vertices run out. Triangles match within a patch and where patches share a whole edge. Elsewhere a vertex
//! may lie on an edge of a neighbour.
//!
//! Memory: about 70 bytes and 12 more a group of sampled lights for each tested point (nine a patch and four a cell), then 72 bytes
//! and 12 a group for each vertex; in the medium 36 bytes and 24 a group for each cell. One group is interpolated at a time.
//!
//! | module | contents |
//! |---|---|
//! | `baked` | options and results |
//! | `group_fields` | the light groups of a solution, zone by zone |
//! | `lit_scene` | the scene in which direct light is sampled |
//! | `separate_suns` | suns whose direct light viewers draw |
//! | `vertex_lighting` | light at a point of a patch |
//! | `patch_quadtree` | one patch and its cells |
//! | `refinement` | selection of the cells to split |
//! | `edge_matching` | common vertices on common edges of patches |
//! | `triangulation` | from cells to triangles |
//! | `panes`, `medium_cells` | panes, and the medium on the voxel grid |
//! | [`corner_light`] | light at the corners of patches and panes |
//! | [`irradiance_volume`] | incident radiance on a grid of points, in spherical harmonics |
//! | [`lightmap`] | surfaces as one texture with the same light |
//! | [`volume_grid`] | the medium on a finer grid, with sharp shafts |
//!
//! The same bits for any number of threads: patches are independent, and candidates among them are sorted first.

mod baked;
pub mod corner_light;
mod edge_matching;
mod group_fields;
pub mod irradiance_volume;
pub mod lightmap;
mod lit_scene;
mod medium_cells;
mod panes;
mod patch_quadtree;
mod refinement;
mod separate_suns;
mod triangulation;
mod vertex_lighting;
pub mod volume_grid;

pub use baked::{
    BakeOptions, BakedMedium, BakedSolution, BakedSun, PaneMesh, SunDepths, SunlightMode, SurfaceMesh,
};

pub use separate_suns::has_separate_suns;

use group_fields::GroupField;
use lit_scene::LitScene;
use std::convert::Infallible;
use vertex_lighting::VertexLighting;
use zonal_scene::{Progress, Solution};
use zonal_transport::Transport;

/// Bakes a solution. The same bits for any number of threads.
///
/// ```
/// use zonal_render::bake::{BakeOptions, bake};
/// # use zonal_math::{Vec3, vec3};
/// # use zonal_scene::{
/// #     Bands, Camera, Facet, Fields, Lens, NoProgress, Plate, Report, Scene, SceneParts, Sides, Solution,
/// #     Surface, VoxelGrid,
/// # };
/// # use zonal_transport::{Transport, build_zones};
/// # let wall = Surface {
/// #     name: "wall".into(),
/// #     reflectance: Bands::ZERO,
/// #     emission: Bands::ONE,
/// #     sides: Sides::Both,
/// #     ..Surface::default()
/// # };
/// # let plate = Plate::parallelogram(vec3(-9.0, 2.0, -9.0), vec3(18.0, 0.0, 0.0), vec3(0.0, 0.0, 18.0));
/// # let wall_facet = Facet { surface: 0, plate, uv: [[0.0; 2]; 3] };
/// # let mut grid = VoxelGrid::new(vec3(-1.0, 0.0, -1.0), vec3(1.0, 1.0, 1.0), [2, 2, 2]).unwrap();
/// # (0..8).for_each(|i| grid.set(i, Bands::splat(0.5), Bands::ZERO, Bands::ZERO, Bands::ZERO));
/// # let scene = Scene::new(SceneParts {
/// #     surfaces: vec![wall],
/// #     facets: vec![wall_facet],
/// #     voxel_grid: Some(grid.seal().unwrap()),
/// #     ..SceneParts::default()
/// # })
/// # .unwrap();
/// # let zones = build_zones(&scene, &Transport::new(&scene)).unwrap();
/// # let emission: Vec<Bands> = (0..zones.len()).map(|i| zones.emission(i)).collect();
/// # let zero = vec![Bands::ZERO; zones.len()];
/// # let mut fields = Fields::default();
/// # (fields.radiosity, fields.incident) = (emission, zero.clone());
/// # (fields.direct, fields.error) = (zero.clone(), zero);
/// # let (groups, report) = (Vec::new(), Report::default());
/// # let (scene_hash, version) = (String::new(), String::new());
/// # let solution = Solution { scene, zones, fields, groups, report, further_blocks: Vec::new(), scene_hash, version };
/// let baked = bake(&solution, &BakeOptions::default(), &NoProgress);
/// assert_eq!(baked.groups, ["all"]);
/// assert_eq!(baked.surfaces.triangles.len(), baked.surfaces.zones.len());
/// assert!(baked.surfaces.emission.iter().all(|e| *e == [1.0; 3]));
/// ```
pub fn bake(solution: &Solution, options: &BakeOptions, progress: &dyn Progress) -> BakedSolution {
    let mut last = None;
    let result: Result<(), Infallible> = bake_in_steps(solution, options, &[], progress, |baked, _| {
        last = Some(baked);
        Ok(())
    });
    match (result, last) {
        (Ok(()), Some(baked)) => baked,
        _ => unreachable!("the last step is always made"),
    }
}

/// Bakes a solution on meshes that become finer: with about as many vertices as each of `steps` allows, where more would refine the mesh, and last with all that the options
/// allow. `publish` gets each result, and whether it is the last; its first error ends the bake and is returned. The last mesh may differ from that of [`bake`],
/// since a step with few vertices splits other cells first.
///
/// # Errors
/// Those of `publish`.
pub fn bake_in_steps<E>(
    solution: &Solution,
    options: &BakeOptions,
    steps: &[usize],
    progress: &dyn Progress,
    mut publish: impl FnMut(BakedSolution, bool) -> Result<(), E>,
) -> Result<(), E> {
    let transport = Transport::new(&solution.scene);
    let lit = LitScene::of(&solution.scene, options.sunlight);
    let extended = lit.is_extended().then(|| Transport::new(&lit.scene));
    let shadow_rays = extended.as_ref().unwrap_or(&transport);
    // Separate the light groups and denoise their irradiances.
    let groups = GroupField::denoised_of_solution(solution);
    // Prepare panes and medium.
    let owner = |s| groups.iter().position(|g| g.owns_surface(&solution.scene, s)).map(|g| g as u32);
    let mut baked = BakedSolution {
        groups: groups.iter().map(|g| g.name.to_string()).collect(),
        emission_groups: (0..solution.scene.surfaces().len()).map(owner).collect(),
        surfaces: SurfaceMesh::default(),
        panes: panes::mesh_panes(solution, &groups),
        medium: medium_cells::average_cells(solution, &groups),
        suns: separate_suns::bake_suns(&solution.scene, &transport, &groups, lit.is_separate()),
    };
    // Mesh the patches, refined where the light varies.
    let lighting =
        VertexLighting::new(solution, &transport, &lit, shadow_rays, &groups, options.light_samples);
    let mut trees = refinement::plant(&lighting, &groups, options, progress);
    for (k, max_vertices) in steps.iter().copied().filter(|n| *n < options.max_vertices).enumerate() {
        let is_finer = refinement::refine(&mut trees, &lighting, &groups, options, max_vertices);
        if (k == 0 || is_finer) && refinement::can_refine(&trees, &lighting, options) {
            let surfaces = triangulation::mesh_patches(&lighting, &groups, trees.clone());
            publish(BakedSolution { surfaces, ..baked.clone() }, false)?;
        }
    }
    refinement::refine(&mut trees, &lighting, &groups, options, options.max_vertices);
    baked.surfaces = triangulation::mesh_patches(&lighting, &groups, trees);
    publish(baked, true)
}

#[cfg(test)]
mod conservation_tests;
