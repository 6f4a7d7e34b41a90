//! Quality: one word for tolerance, patch size and sampling.
//!
//! | | draft | normal | fine |
//! |---|---|---|---|
//! | tolerance of a solve | 0.5, or that of the scene if larger | that of the scene | a third of it |
//! | patch size | twice that of the scene | that of the scene | half of it |
//! | rays of a picture | one in each pixel | adaptive | 16 in each pixel, 64 for the indirect light of each |

use zonal_render::RenderOptions;
use zonal_scene::{Scene, SolveOptions};

/// Number of samples that stands for adaptive sampling.
const ADAPTIVE_SAMPLES: usize = 0;

/// Accuracy against time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Quality {
    /// A first look: larger patches, a tolerance of 0.5, one ray in each pixel.
    Draft,
    /// The scene as it is.
    #[default]
    Normal,
    /// Patches of half the size, a third of the tolerance, many rays.
    Fine,
}

/// Tolerance of a draft.
const DRAFT_TOLERANCE: f64 = 0.5;
/// Patch size of a draft over that of the scene.
const DRAFT_PATCH_FACTOR: f64 = 2.0;
/// Tolerance and patch size of a fine solve over those of the scene.
const FINE_TOLERANCE_FACTOR: f64 = 1.0 / 3.0;
const FINE_PATCH_FACTOR: f64 = 0.5;
/// Rays of a pixel of a fine picture, and rays for the indirect light of a point.
const FINE_SAMPLES: usize = 16;
const FINE_GATHER_RAYS: usize = 64;

impl Quality {
    /// The name in options and progress.
    #[must_use]
    pub fn name(self) -> &'static str {
        ["draft", "normal", "fine"][self as usize]
    }

    /// The settings of a scene at this quality.
    #[must_use]
    pub fn of_solve(self, scene: &Scene) -> SolveOptions {
        let o = scene.options().clone();
        let resized = |factor: f64| Some(factor * scene.patch_size());
        match self {
            Quality::Draft => SolveOptions {
                tolerance: o.tolerance.max(DRAFT_TOLERANCE),
                patch_size: resized(DRAFT_PATCH_FACTOR),
                ..o
            },
            Quality::Normal => o,
            Quality::Fine => SolveOptions {
                tolerance: FINE_TOLERANCE_FACTOR * o.tolerance,
                patch_size: resized(FINE_PATCH_FACTOR),
                ..o
            },
        }
    }

    /// Options of the renderer for a picture of this size, pixels across and down.
    #[must_use]
    pub fn of_picture(self, size: (usize, usize)) -> RenderOptions {
        let (width, height) = size;
        let [samples, gather] = match self {
            Quality::Draft => [1, 0],
            Quality::Normal => [ADAPTIVE_SAMPLES, 0],
            Quality::Fine => [FINE_SAMPLES, FINE_GATHER_RAYS],
        };
        RenderOptions { width, height, samples, gather, ..RenderOptions::default() }
    }
}
