//! Size and sampling of a picture.

/// Size and quality of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    /// Pixels across; 640.
    pub width: usize,
    /// Pixels down; 480.
    pub height: usize,
    /// Rays of every pixel, on a regular grid where it is a square number; 0: one to nine, where neighbours differ; 4.
    pub samples: usize,
    /// Samples of each extended light per ray. Surfaces take this number of suns and emitters and four times this number of skies; the
    /// medium takes one of a sun and half this number of skies and emitters; 4.
    pub light_samples: usize,
    /// Final-gather rays of each surface point; 0: the irradiance of the patches is interpolated; 0.
    pub gather: usize,
}

impl Default for RenderOptions {
    fn default() -> Self {
        RenderOptions { width: 640, height: 480, samples: 4, light_samples: 4, gather: 0 }
    }
}

/// Sampling that the options leave open.
pub(crate) struct RenderParams {
    /// Rays of a pixel behind a lens where `samples` is 0.
    pub lens_rays: usize,
    /// Rays of a pixel from which skies are sampled in the medium; fewer take the fluence of the zones, which has no grain.
    pub sky_rays: usize,
    /// Maximum number of steps of a ray through the deep shadow map of a sun, where a pixel has several rays.
    pub max_sun_steps: usize,
    /// … and where a pixel has one ray or shares it with its neighbours.
    pub max_sun_steps_adaptive: usize,
    /// Spacing of the nodes of optical depth along a ray, edges of a cube with the volume of a voxel.
    pub depth_node_spacing: f64,
}

/// The values in use.
pub(crate) const RENDER_PARAMS: RenderParams = RenderParams {
    lens_rays: 64,
    sky_rays: 64,
    max_sun_steps: 256,
    max_sun_steps_adaptive: 1024,
    depth_node_spacing: 1.5,
};
