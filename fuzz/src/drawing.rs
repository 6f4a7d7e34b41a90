//! Everything that reads a solution: pictures, the viewer's package, relighting.

use zonal_app::pages::html_report;
use zonal_app::pages::viewer::package::{PackageDetail, package};
use zonal_io::output;
use zonal_render::{ItemBuffer, PaneVisibility, RenderOptions, render};
use zonal_scene::{Bands, Camera, NoProgress, Scene, Solution};

/// Most zones of a scene that is solved, and of a solution that is used.
pub const MAX_ZONES: usize = 160;
/// Most zones of a solution that is packed for the viewer.
const MAX_ZONES_PACKED: usize = 24;
/// Most facets, pane plates and voxels of a scene.
const MAX_PARTS: usize = 64;
/// Most direct lights.
const MAX_LIGHTS: usize = 4;

/// True for a scene of few parts and lights.
pub fn is_small(scene: &Scene) -> bool {
    scene.facets().len() <= MAX_PARTS
        && scene.panes().iter().map(|p| p.plates.len()).sum::<usize>() <= MAX_PARTS
        && scene.voxel_grid().is_none_or(|v| v.len() <= MAX_PARTS)
        && scene.lights().len() <= MAX_LIGHTS
}

/// Up to two cameras of the scene, or one near its centre.
fn cameras(scene: &Scene) -> Vec<Camera> {
    let mut cameras: Vec<Camera> = scene.cameras().iter().take(2).cloned().collect();
    if cameras.is_empty() {
        let (lo, hi) = scene.bounds();
        let middle = Camera::look_at((lo * 0.4 + hi * 0.6).array(), hi.array());
        cameras.push(Camera { up: zonal_math::vec3(0.0, 0.1, 1.0), fov: 70.0, ..middle });
    }
    cameras.retain(|c| c.check().is_ok());
    cameras
}

/// Runs everything that only reads a solution; returns the pictures.
pub fn draw(solution: &Solution) -> Vec<Vec<[f32; 3]>> {
    let _ = html_report::page(solution, "run.npz", &[]);
    output::report_json(solution).to_string();
    let mut out = Vec::new();
    for (i, camera) in cameras(&solution.scene).iter().enumerate() {
        let options = RenderOptions { width: 3, height: 2, samples: i, light_samples: 1, gather: 2 * i };
        out.push(render(solution, camera, &options, &NoProgress).pixels);
        let mut seen = ItemBuffer::new(solution, camera, 3, 2, PaneVisibility::Opaque);
        if solution.scene.voxel_grid().is_some() {
            seen = seen.with_slice(i, solution.scene.bounds().0.z);
        }
        seen.zones(&NoProgress);
    }
    out
}

/// Packs a solution of few zones for the viewer.
pub fn pack(solution: &Solution) {
    if solution.zones.len() <= MAX_ZONES_PACKED {
        let _ =
            package(solution, &PackageDetail { max_vertices: 200, ..PackageDetail::default() }, &NoProgress);
    }
}

/// Whether a solution is packed for the viewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packing {
    /// The solution is packed.
    Packed,
    /// The solution is not packed, which saves time.
    Skipped,
}

/// Draws, relights and packs a solution from an untrusted file.
pub fn use_solution(solution: Solution, packing: Packing) {
    let s = &solution.scene;
    let size = s.diagonal();
    if solution.zones.len() > MAX_ZONES || !is_small(s) || !(size > 1e-6 && size < 1e6) {
        return;
    }
    draw(&solution);
    if packing == Packing::Packed {
        pack(&solution);
    }
    if let Some(name) = solution.groups.first().map(|g| g.name.clone())
        && let Ok(relit) =
            zonal_solve::relight::relight(solution, &[(name, Bands::from_rgb([0.5, 2.0, 0.0]))])
    {
        let _ = output::solution_bytes(&relit);
    }
}
