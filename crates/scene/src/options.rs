//! How to solve a scene: engine, accuracy, size of the zones.

/// How the exchange of all zones is represented.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Engine {
    /// Dense for few zones, for many spectral where that applies, else hierarchical.
    #[default]
    Auto,
    /// Every pair of zones.
    Dense,
    /// Links between clusters of zones.
    Hierarchical,
    /// Every pair of zones of a box on the grid of its medium, by transforms.
    Spectral,
}

impl Engine {
    /// The words that scene files use, in the order of [`Engine::ALL`].
    pub const WORDS: [&str; 4] = ["auto", "dense", "hierarchical", "spectral"];
    /// All of them.
    pub const ALL: [Engine; 4] = [Engine::Auto, Engine::Dense, Engine::Hierarchical, Engine::Spectral];
    /// The word that scene files and reports use.
    pub fn word(self) -> &'static str {
        Engine::WORDS[self as usize]
    }
}

/// Which lights are solved apart, so that they can be turned up and down afterwards.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Groups {
    /// Each, as long as they are few; else all in one sum.
    #[default]
    Auto,
    /// Each.
    Each,
    /// All in one sum.
    All,
}

impl Groups {
    /// The words that scene files use, in the order of [`Groups::ALL`].
    pub const WORDS: [&str; 3] = ["auto", "each", "all"];
    /// All of them.
    pub const ALL: [Groups; 3] = [Groups::Auto, Groups::Each, Groups::All];
    /// The word that scene files use.
    pub fn word(self) -> &'static str {
        Groups::WORDS[self as usize]
    }
}

/// What the patch size limits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PatchRule {
    /// The edge of a square piece; a triangle is at most half of such a square.
    #[default]
    Edge,
    /// The square root of a piece's area. Triangles stay whole up to that area, and up to six times the size long; a wall that
    /// stands on a patch cuts off no less than a tenth of the largest area.
    Area,
    /// Nothing on rectangles along the axes, which are cut along the voxels of the medium; elsewhere the edge.
    Voxels,
}

impl PatchRule {
    /// The words that scene files use, in the order of [`PatchRule::ALL`].
    pub const WORDS: [&str; 3] = ["edge", "area", "voxels"];
    /// All of them.
    pub const ALL: [PatchRule; 3] = [PatchRule::Edge, PatchRule::Area, PatchRule::Voxels];
    /// The word that scene files use.
    pub fn word(self) -> &'static str {
        PatchRule::WORDS[self as usize]
    }
}

/// What is done about voxels through which light passes less than easily: radiosity that is constant in each is then a rough picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ThickZones {
    /// Slopes where voxels are thick and the engine can.
    #[default]
    Auto,
    /// Slopes of radiosity in every zone.
    Linear,
    /// Nothing.
    Constant,
}

impl ThickZones {
    /// The words that scene files use, in the order of [`ThickZones::ALL`].
    pub const WORDS: [&str; 3] = ["auto", "linear", "constant"];
    /// All of them.
    pub const ALL: [ThickZones; 3] = [ThickZones::Auto, ThickZones::Linear, ThickZones::Constant];
    /// The word that scene files use.
    pub fn word(self) -> &'static str {
        ThickZones::WORDS[self as usize]
    }
}

/// How to solve: every setting has a default.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Wanted relative accuracy of the exchange between zones, 0 < tolerance < 1.
    pub tolerance: f64,
    /// Wanted patch edge, m; a thirtieth of the scene's diagonal where not given.
    pub patch_size: Option<f64>,
    /// What the patch size limits.
    pub patch_rule: PatchRule,
    /// Restore closure by symmetric scaling; where not given, in thermal mode alone ([`crate::Scene::restores_closure`]).
    pub restore_closure: Option<bool>,
    /// Largest number of solver iterations.
    pub max_iterations: usize,
    /// Wanted residual of the solver: power not yet distributed, relative to the power that the sources give.
    pub residual: f64,
    /// Exactly so many sweeps of the Neumann series in place of the solver; at least one.
    pub sweeps: Option<usize>,
    /// The engine.
    pub engine: Engine,
    /// The light groups.
    pub groups: Groups,
    /// What is done about thick voxels.
    pub thick_zones: ThickZones,
    /// Whether a second solve, on zones about twice as large, tells what the size of the zones costs; where not given, of heat alone.
    pub zoning_error: Option<bool>,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            tolerance: 1e-2,
            patch_size: None,
            patch_rule: PatchRule::Edge,
            restore_closure: None,
            max_iterations: 500,
            residual: 1e-10,
            sweeps: None,
            engine: Engine::Auto,
            groups: Groups::Auto,
            thick_zones: ThickZones::Auto,
            zoning_error: None,
        }
    }
}
