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

// Sampling that the options leave open.

/// Rays of a pixel behind a lens where `samples` is 0.
pub(crate) const LENS_RAYS: usize = 64;
/// Rays of a pixel from which skies are sampled in the medium; fewer take the fluence of the zones, which has no grain.
pub(crate) const SKY_RAYS: usize = 64;
/// Maximum number of steps of a ray through the deep shadow map of a sun, where a pixel has several rays.
pub(crate) const MAX_SUN_STEPS: usize = 256;
/// … and where a pixel has one ray or shares it with its neighbours.
pub(crate) const MAX_SUN_STEPS_ADAPTIVE: usize = 1024;
/// Spacing of the nodes of optical depth along a ray, edges of a cube with the volume of a voxel.
pub(crate) const DEPTH_NODE_SPACING: f64 = 1.5;
