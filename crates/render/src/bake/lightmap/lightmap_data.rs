//! Options and results of lightmaps.

/// Texels around a chart that belong to it alone.
pub(super) const CHART_MARGIN: usize = 2;

/// Resolution of a lightmap.
#[derive(Clone, Debug, PartialEq)]
pub struct LightmapOptions {
    /// Edge of a texel, m; the smallest that fits into the atlas where not given.
    pub texel: Option<f64>,
    /// Largest width and height of the atlas, texels, up to 16,384; 1024.
    pub max_side: usize,
    /// Samples of each sun and emitter at a texel, and a sixteenth of those of a sky that shares a group; 16.
    pub light_samples: usize,
}

impl Default for LightmapOptions {
    fn default() -> Self {
        LightmapOptions { texel: None, max_side: 1024, light_samples: 16 }
    }
}

/// A lightmap, and the facets with their coordinates in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Lightmap {
    /// Texels across.
    pub width: usize,
    /// Texels down.
    pub height: usize,
    /// Edge of a texel, m.
    pub texel: f64,
    /// Irradiance, direct light included, red, green and blue, W/m², row by row, row 0 on top; zero outside of the charts.
    pub irradiance: Vec<[f32; 3]>,
    /// Number of charts.
    pub charts: usize,
    /// Texels whose centre lies on a facet.
    pub covered: usize,
    /// The facets.
    pub mesh: LightmapMesh,
}

/// The facets as triangles, one side each. All lists but the last have one entry a vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightmapMesh {
    /// Position, m.
    pub positions: Vec<[f32; 3]>,
    /// Unit normal of the side.
    pub normals: Vec<[f32; 3]>,
    /// Coordinates in the textures of the surface, v down.
    pub uvs: Vec<[f32; 2]>,
    /// Coordinates in the lightmap, 0 to 1, v down.
    pub lightmap_uvs: Vec<[f32; 2]>,
    /// Index of the surface.
    pub surfaces: Vec<u32>,
    /// Corners of each triangle, counter-clockwise as seen from that side.
    pub triangles: Vec<[u32; 3]>,
}

/// The charts do not fit into the atlas.
#[derive(Clone, Debug, PartialEq)]
pub struct AtlasTooSmall {
    /// Number of charts.
    pub charts: usize,
    /// Largest width and height that was allowed, texels.
    pub max_side: usize,
    /// Texels of all charts with their margins.
    pub texels: f64,
}
