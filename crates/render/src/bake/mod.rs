//! A solution on triangles: what viewers and other engines draw, from anywhere, without rays.
//!
//! Light groups stay apart, so that lights can be turned in the viewer. At a vertex x of a patch with normal n, of group g,
//!
//! ```text
//!     H_g(x) = H_ind,g(x) + H_dir,g(x, n)            B(x) = Σ_g f_g (E_g(x) + ρ(x) H_g(x))
//! ```
//!
//! H_ind is the interpolated field of the renderer, H_dir is gathered anew; direct light of skies, which is smooth, is interpolated with
//! H_ind where its group is its own. E belongs to one group a surface, and ρ stays with the surface (factor times texture), so that
//! viewers may texture each pixel.
//!
//! Each patch is halved both ways where the light between the points of a piece is not what linear interpolation says (`tree`,
//! `refine`): the difference of edge middles and centre from it, relative to what is there, against `tolerance`. The pieces that err most are
//! halved first when vertices run out. Triangles fit edge to edge within a patch and where patches share a whole edge. Elsewhere a vertex may
//! lie on an edge of a neighbour.
//!
//! Memory: about 70 bytes and 12 more a group of sampled lights for each point tried (nine a patch and four a piece), then 72 bytes
//! and 12 a group for each vertex; in the medium 36 bytes and 24 a group for each cell. One group is interpolated at a time.
//!
//! | module | what |
//! |---|---|
//! | `share` | the groups of a solution, zone by zone |
//! | `light` | light at a point of a patch |
//! | `tree` | one patch, halved |
//! | `refine` | which pieces to halve |
//! | `seams` | common edges of patches have common vertices |
//! | `mesh` | from pieces to triangles |
//! | `rest` | panes and medium |
//! | [`haze`] | the medium on a finer grid, with crisp shafts |
//!
//! The same bits for any number of threads: patches are independent, and what is chosen among them is put in order first.

pub mod haze;
mod light;
mod mesh;
mod refine;
mod rest;
mod seams;
mod share;
mod tree;

use light::Lights;
use share::Share;
use zonal_math::Vec3;
use zonal_scene::{Progress, Solution};
use zonal_transport::Transport;

/// How finely to bake.
#[derive(Clone, Debug, PartialEq)]
pub struct BakeOptions {
    /// Pieces with no edge longer than this are not halved, m; a thousandth of the scene's diagonal where not given.
    pub finest: Option<f64>,
    /// Difference from linear interpolation that is left, relative to the light about; 0.05.
    pub tolerance: f64,
    /// The most vertices on patches before those that close seams, unless the patches' corners alone are more; 2,000,000.
    pub vertices: usize,
    /// Points of each sun and emitter that a vertex asks, and a sixteenth of those of a sky that shares a group; 16.
    pub light_samples: usize,
}

impl Default for BakeOptions {
    fn default() -> Self {
        BakeOptions { finest: None, tolerance: 0.05, vertices: 2_000_000, light_samples: 16 }
    }
}

/// A solution on triangles and on the grid of its medium.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Baked {
    /// Names of the light groups, in the solution's order; one, `all`, where it kept none apart.
    pub groups: Vec<String>,
    /// For each surface of the scene the group that its emission belongs to; `None` where it has none.
    pub emission_groups: Vec<Option<u32>>,
    /// The patches.
    pub surfaces: SurfaceMesh,
    /// The panes.
    pub panes: PaneMesh,
    /// The medium; `None` without a voxmap.
    pub medium: Option<BakedMedium>,
}

/// The patches as triangles. All lists but the last two have one entry a vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceMesh {
    /// Position, m.
    pub positions: Vec<[f32; 3]>,
    /// Unit normal of the side that exchanges.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates, v down.
    pub uvs: Vec<[f32; 2]>,
    /// Index of the surface.
    pub surfaces: Vec<u32>,
    /// Irradiance H + H_dir, W/m² a band: `irradiance[group][vertex]`.
    pub irradiance: Vec<Vec<[f32; 3]>>,
    /// Emitted flux E, W/m² a band, of the group that `emission_groups` tells.
    pub emission: Vec<[f32; 3]>,
    /// Estimated error of the indirect irradiance, all groups together, W/m² a band: that of the zone.
    pub error: Vec<[f32; 3]>,
    /// Corners of each triangle, counter-clockwise as seen from the side that exchanges.
    pub triangles: Vec<[u32; 3]>,
    /// The patch zone of each triangle.
    pub zones: Vec<u32>,
}

/// The panes as triangles, to be seen from both sides. All lists but the last two have one entry a vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PaneMesh {
    /// Position, m.
    pub positions: Vec<[f32; 3]>,
    /// Unit normal of the front.
    pub normals: Vec<[f32; 3]>,
    /// Index of the pane in the scene.
    pub panes: Vec<u32>,
    /// Optical depth κt a band: light at an angle θ to the normal passes as e^{−κt/|cosθ|}.
    pub depth: Vec<[f32; 3]>,
    /// Radiosity B, direct light included, W/m² a band: `radiosity[group][vertex]`. What is seen of it is (1 − e^{−κt/|cosθ|}) B/π.
    pub radiosity: Vec<Vec<[f32; 3]>>,
    /// Estimated error of the fluence, W/m² a band: that of the zone.
    pub error: Vec<[f32; 3]>,
    /// Corners of each triangle, counter-clockwise as seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// The pane zone of each triangle, counted among all zones.
    pub zones: Vec<u32>,
}

/// The medium on the voxmap's grid; lists have one entry a cell, z fastest: index (i·ny + j)·nz + k. Values of cells with several zones are
/// means by volume.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedMedium {
    /// Lower corner, m.
    pub min: Vec3,
    /// Edges of a cell, m.
    pub cell: Vec3,
    /// Cells along x, y, z.
    pub dims: [usize; 3],
    /// Free volume, m³; zero marks cells without a zone.
    pub volume: Vec<f32>,
    /// Extinction κ, 1/m a band.
    pub extinction: Vec<[f32; 3]>,
    /// Scattering albedo Ω a band.
    pub albedo: Vec<[f32; 3]>,
    /// Radiosity B, direct light included, W/m² a band: `radiosity[group][cell]`. The medium shines with κB/π a metre.
    pub radiosity: Vec<Vec<[f32; 3]>>,
    /// Fluence G + G_dir, W/m² a band: `fluence[group][cell]`.
    pub fluence: Vec<Vec<[f32; 3]>>,
}

/// Bakes a solution.
pub fn bake(solution: &Solution, options: &BakeOptions, progress: &dyn Progress) -> Baked {
    let transport = Transport::new(&solution.scene);
    let shares: Vec<Share> = Share::all(solution).into_iter().map(Share::calmed).collect();
    let lights = Lights::new(solution, &transport, &shares, options.light_samples);
    let surfaces = mesh::surfaces(solution, &lights, &shares, options, progress);
    let owner = |s| shares.iter().position(|g| g.owns_surface(&solution.scene, s)).map(|g| g as u32);
    Baked {
        groups: shares.iter().map(|g| g.name.to_string()).collect(),
        emission_groups: (0..solution.scene.surfaces().len()).map(owner).collect(),
        surfaces,
        panes: rest::panes(solution, &shares),
        medium: rest::medium(solution, &shares),
    }
}

fn single(v: Vec3) -> [f32; 3] {
    v.array().map(|x| x as f32)
}

#[cfg(test)]
mod tests;
