//! Baked data: triangles of patches and panes with their light, and cell values of the medium.
//!
//! Values of all bands are stored as red, green and blue in single precision, as the files of viewers hold them.

use zonal_math::Vec3;

/// Whether the direct light of suns is part of baked light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SunlightMode {
    /// It is baked as that of all other lights.
    #[default]
    Baked,
    /// It is left out of patches and medium, and described by [`BakedSun`]s for viewers that draw shadow maps; wide suns and those of scenes with
    /// symmetry planes are baked. Panes and [`BakedMedium`] contain it always.
    Separate,
}

/// Resolution of a baked solution.
#[derive(Clone, Debug, PartialEq)]
pub struct BakeOptions {
    /// Cells with no edge longer than this are not split, m; a thousandth of the scene's diagonal where not given.
    pub min_edge: Option<f64>,
    /// Largest error of linear interpolation, relative to the light nearby; 0.05.
    pub tolerance: f64,
    /// Largest number of vertices on patches, without those that match edges, unless the corners of the patches alone are more; 2,000,000.
    pub max_vertices: usize,
    /// Samples of each sun and emitter at a vertex, and a sixteenth of those of a sky that shares a group; 16.
    pub light_samples: usize,
    /// Direct light of suns; baked.
    pub sunlight: SunlightMode,
}

impl Default for BakeOptions {
    fn default() -> Self {
        let sunlight = SunlightMode::Baked;
        BakeOptions { min_edge: None, tolerance: 0.05, max_vertices: 2_000_000, light_samples: 16, sunlight }
    }
}

/// A solution on triangles and on the grid of its medium.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BakedSolution {
    /// Names of the light groups, in the solution's order; the single name `all` where it has no groups.
    pub groups: Vec<String>,
    /// For each surface of the scene the group of its emission; `None` where it has none.
    pub emission_groups: Vec<Option<u32>>,
    /// The patches.
    pub surfaces: SurfaceMesh,
    /// The panes.
    pub panes: PaneMesh,
    /// The medium; `None` without one.
    pub medium: Option<BakedMedium>,
    /// The suns whose direct light is separate.
    pub suns: Vec<BakedSun>,
}

/// A sun whose direct light a viewer draws.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedSun {
    /// Index of its light group.
    pub group: u32,
    /// Unit vector towards it.
    pub towards: Vec3,
    /// Irradiance on a plane normal to its direction, outside of the medium and of panes, W/m² per band.
    pub irradiance: [f32; 3],
    /// Angular diameter, rad.
    pub angular_diameter: f64,
    /// Optical depths of the medium towards it; `None` where they are zero.
    pub depths: Option<SunDepths>,
}

/// Optical depths of the medium towards a sun, at nodes that divide the box of the voxel grid evenly, from face to face.
#[derive(Clone, Debug, PartialEq)]
pub struct SunDepths {
    /// Nodes along x, y, z; at least 2.
    pub dims: [usize; 3],
    /// Depth a band, z fastest: index (i·ny + j)·nz + k.
    pub values: Vec<[f32; 3]>,
}

/// The patches as triangles. All lists but the last two have one entry per vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceMesh {
    /// Position, m.
    pub positions: Vec<[f32; 3]>,
    /// Unit normal of the side that takes part in the exchange; on a facet with vertex normals the normal between these.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates, v down.
    pub uvs: Vec<[f32; 2]>,
    /// Index of the surface.
    pub surfaces: Vec<u32>,
    /// Irradiance H + H_dir without that of separate suns, W/m² per band: `irradiance[group][vertex]`.
    pub irradiance: Vec<Vec<[f32; 3]>>,
    /// The part H_dir of `irradiance`; empty for a group without direct light.
    pub direct: Vec<Vec<[f32; 3]>>,
    /// Emitted flux E, W/m² per band, of the group in `emission_groups`.
    pub emission: Vec<[f32; 3]>,
    /// Estimated error of the zone's indirect irradiance, all groups together, W/m² per band.
    pub error: Vec<[f32; 3]>,
    /// Corners of each triangle, counter-clockwise as seen from that side.
    pub triangles: Vec<[u32; 3]>,
    /// The patch zone of each triangle.
    pub zones: Vec<u32>,
}

/// The panes as triangles, visible from both sides. All lists but the last two have one entry per vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PaneMesh {
    /// Position, m.
    pub positions: Vec<[f32; 3]>,
    /// Unit normal of the front.
    pub normals: Vec<[f32; 3]>,
    /// Index of the pane in the scene.
    pub panes: Vec<u32>,
    /// Optical depth κt a band: the transmittance at an angle θ to the normal is e^{−κt/|cosθ|}.
    pub depth: Vec<[f32; 3]>,
    /// Radiosity B, direct light included, W/m² per band: `radiosity[group][vertex]`. The visible radiance is (1 − e^{−κt/|cosθ|}) B/π.
    pub radiosity: Vec<Vec<[f32; 3]>>,
    /// Estimated error of the zone's fluence, W/m² per band.
    pub error: Vec<[f32; 3]>,
    /// Corners of each triangle, counter-clockwise as seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// The pane zone of each triangle, counted among all zones.
    pub zones: Vec<u32>,
}

/// The medium on the voxel grid of the scene; lists have one entry per cell, z fastest: index (i·ny + j)·nz + k. Values of cells with several zones are
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
    /// Extinction κ, 1/m per band.
    pub extinction: Vec<[f32; 3]>,
    /// Scattering albedo Ω a band.
    pub albedo: Vec<[f32; 3]>,
    /// Radiosity B, direct light included, W/m² per band: `radiosity[group][cell]`. The source of radiance is κB/π per metre.
    pub radiosity: Vec<Vec<[f32; 3]>>,
    /// Fluence G + G_dir, W/m² per band: `fluence[group][cell]`.
    pub fluence: Vec<Vec<[f32; 3]>>,
}

/// A vector in single precision.
pub(super) fn single_vector(v: Vec3) -> [f32; 3] {
    v.array().map(|x| x as f32)
}
