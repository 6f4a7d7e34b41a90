//! The nouns: what a scene is made of, the zones it is cut into, and the solution on them.
//!
//! Everything here is inert data and its validation. Below this room nothing touches the file system, the clock,
//! the network or a serialiser; formats live in `zonal-io`, rays in `zonal-transport`.
//!
//! | module | what |
//! |---|---|
//! | [`plate`] | triangles and parallelograms |
//! | [`closed`] | closed parts of a set of plates: bodies and rooms |
//! | [`part`] | the free part of a cut voxel, packed |
//! | [`voxmap`] | the regular voxel grid of a medium |
//! | [`camera`] | pinholes and thin lenses |
//! | [`scene`] | surfaces, panes, lights, cameras, validated once into a [`Scene`] |
//! | [`zones`] | patches, voxel zones and pane zones |
//! | [`solution`] | radiosity, irradiance, fluence on the zones, with the report |
//! | [`light`] | sun, sky, emitters, surroundings |
//! | [`thermal`] | temperatures and net powers that are known, shares of the emission |
//! | [`group`] | the share of each light in a solution |
//! | [`note`] | messages of a report, each with its severity and code |
//! | [`mod@printable`] | text without what steers a terminal |
//! | [`progress`] | how long work tells where it stands |
//! | [`vault`] | where long work leaves what is done |
//!
//! Units: metres, 1/m for extinction, W/m² for radiosity B, irradiance H and fluence G, W/m³ for volumetric sources, each per
//! band. Three bands, called red, green, blue in pictures; thermal users may give all three the same values.

pub mod camera;
pub mod closed;
mod coarser;
pub mod group;
pub mod light;
pub mod note;
pub mod options;
pub mod part;
pub mod plate;
pub mod printable;
pub mod progress;
pub mod scene;
pub mod solution;
pub mod thermal;
pub mod vault;
pub mod voxmap;
pub mod zones;

pub use camera::{Camera, Lens};
pub use group::{Group, Kind, Values};
pub use light::{Light, Surroundings};
pub use note::{Note, Severity};
pub use options::{Engine, Groups, Options};
pub use part::{Part, Sample};
pub use plate::{Plate, PlateKind};
pub use printable::{printable, printable_lines};
pub use progress::{Progress, Quiet};
pub use scene::{Facet, Pane, Scene, SceneError, SceneParts, Sides, Surface, Texture};
pub use solution::{
    Estimate, Fields, Heat, HeatKind, HeatReport, HeatRow, Report, Solution, SolveStatus, Zoning,
};
pub use thermal::{Known, Shares, Thermal};
pub use vault::{NoVault, Vault};
pub use voxmap::Voxmap;
pub use zones::{PaneZone, Patch, VoxelZone, Zones};

/// One value a band.
pub type Bands = [f64; 3];
/// The number of bands.
pub const BANDS: usize = 3;

/// Applies `f` band by band.
pub fn bands(f: impl FnMut(usize) -> f64) -> Bands {
    std::array::from_fn(f)
}
