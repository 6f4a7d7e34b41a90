//! Settings of a solve: engine, accuracy, size and basis of the zones.

use crate::base::named_enum::named_enum;

/// Representation of the exchange between all zones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Engine {
    /// Spectral for many zones if applicable, else dense or rays by the forecast costs. Layered for slabs of varying extinction.
    #[default]
    Auto,
    /// Every pair of zones.
    Dense,
    /// Stored rays of every zone, then a final gather.
    Rays,
    /// Every pair of zones of a box on the grid of its medium, by fast Fourier transforms.
    Spectral,
    /// Every pair of zones of a slab of layers, periodic along two axes, by integrals over the layers.
    Layered,
}

named_enum!(Engine: Auto "auto", Dense "dense", Rays "rays", Spectral "spectral", Layered "layered");

/// The lights that are solved separately, so that they can be scaled after the solve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum LightGrouping {
    /// Each light if they are few, else all in one sum.
    #[default]
    Auto,
    /// Each light.
    Each,
    /// All in one sum.
    All,
}

named_enum!(LightGrouping: Auto "auto", Each "each", All "all");

/// The measure of a patch that the patch size limits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PatchRule {
    /// The edge of a square patch; a triangle is at most half of such a square.
    #[default]
    Edge,
    /// The square root of the area of a patch. Triangles up to that area stay whole, up to six times the size long; a wall that
    /// stands on a patch cuts off at least a tenth of the largest area.
    Area,
    /// None on rectangles along the axes, which are cut along the voxels of the medium; elsewhere the edge.
    Voxels,
}

named_enum!(PatchRule: Edge "edge", Area "area", Voxels "voxels");

/// Basis of the radiosity inside a zone. A constant is a coarse approximation inside optically thick voxels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum ZoneBasis {
    /// Linear if voxels are optically thick and the engine supports it, else constant.
    #[default]
    Auto,
    /// Linear in every zone.
    Linear,
    /// Constant in every zone.
    Constant,
}

named_enum!(ZoneBasis: Auto "auto", Linear "linear", Constant "constant");

/// Settings of a solve; each has a default.
///
/// ```
/// use zonal_scene::{Engine, SolveOptions};
/// let options = SolveOptions { tolerance: 1e-3, ..SolveOptions::default() };
/// assert_eq!((options.engine, options.max_iterations), (Engine::Auto, 500));
/// ```
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
pub struct SolveOptions {
    /// Relative tolerance of the exchange between zones, 0 < tolerance < 1.
    pub tolerance: f64,
    /// Largest patch edge, m; a thirtieth of the scene's diagonal if `None`.
    pub patch_size: Option<f64>,
    /// The measure that the patch size limits.
    pub patch_rule: PatchRule,
    /// Whether closure is restored by symmetric scaling; if `None`, in thermal mode only ([`crate::Scene::restores_closure`]).
    pub restore_closure: Option<bool>,
    /// Largest number of solver iterations.
    pub max_iterations: usize,
    /// Tolerance of the solver's residual: undistributed power relative to the power of the sources.
    pub residual: f64,
    /// Number of terms of the Neumann series to compute in place of the iterative solution; at least one.
    pub scattering_orders: Option<usize>,
    /// The engine.
    pub engine: Engine,
    /// The light groups.
    #[serde(rename = "light_groups")]
    pub light_grouping: LightGrouping,
    /// The basis of the radiosity inside zones.
    pub zone_basis: ZoneBasis,
    /// Whether a second solve on zones about twice as large estimates the discretization error; if `None`, that of heat only.
    pub discretization_error: Option<bool>,
}

impl Default for SolveOptions {
    fn default() -> Self {
        SolveOptions {
            tolerance: 1e-2,
            patch_size: None,
            patch_rule: PatchRule::Edge,
            restore_closure: None,
            max_iterations: 500,
            residual: 1e-10,
            scattering_orders: None,
            engine: Engine::Auto,
            light_grouping: LightGrouping::Auto,
            zone_basis: ZoneBasis::Auto,
            discretization_error: None,
        }
    }
}
