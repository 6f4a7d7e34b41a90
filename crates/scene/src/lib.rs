//! Domain types: the scene, the zones into which it is divided, and the solution on them.
//!
//! All types are data with validation. This crate and those above it except `zonal-io` and the command access neither files nor clock nor
//! network; formats are in `zonal-io`, ray tracing in `zonal-transport`.
//!
//! | folder | contents |
//! |---|---|
//! | `builder` | scenes from code |
//! | `derived` | topology, sides of sheets, the scene on other zones, even extensions |
//! | `solution` | fields, light groups, reports and results by surface and face |
//! | `scene` | the parts of a scene, their validation, the validated [`Scene`] |
//! | `zones` | patches, voxel zones and pane zones |
//! | `model` | surfaces, panes, lights, surroundings, cameras, settings |
//! | `medium` | the voxel grid |
//! | [`thermal`] | prescribed temperatures and net powers, band fractions of the emission, networks of nodes |
//! | `bands` | number, names and wavelengths of the bands; three bands as indices; band-indexed values with operators |
//! | `geometry` | triangles and parallelograms, and meshes of them |
//! | `base` | errors and notes, ranges of quantities, observers and checkpoints |
//!
//! A folder uses the folders below it in this table alone.
//!
//! Units: m, 1/m for extinction, W/m² for radiosity B, irradiance H and fluence G, W/m³ for volumetric sources, each per band. Bands
//! are stored three at a time; by default they are red, green and blue. Grey thermal scenes have equal values in all three.

mod bands;
mod base;
mod builder;
mod derived;
mod geometry;
mod medium;
mod model;
mod scene;
mod solution;
pub mod thermal;
mod zones;

pub use base::{checkpoint_store, limits};
pub use derived::topology;
pub use geometry::shells;
pub use medium::voxel_samples;
pub use solution::light_group;

pub use bands::Bands;
pub use bands::band::{Band, BandCountError, PerBand};
pub use bands::band_set::{BandSet, MAX_BANDS};
pub use bands::encoding;
pub use base::checkpoint_store::{CheckpointStore, NoCheckpoints};
pub use base::diagnostic::{Diagnostic, Severity};
pub use base::printable::{printable, printable_lines, printable_text};
pub use base::progress::{NoProgress, Progress, in_stage};
pub use base::scene_error::{SceneError, SceneErrorKind};
pub use builder::SceneBuilder;
pub use builder::lights::{GlassPane, Planet, PointLight, Sky, Sun};
pub use builder::medium::Medium;
pub use builder::mesh::Mesh;
pub use builder::values::{BandValues, VoxelValues};
pub use derived::even_extension::{EvenExtension, ZoneImages};
pub use geometry::plate::{Plate, PlateKind};
pub use medium::voxel_grid::VoxelGrid;
pub use medium::voxel_samples::{SUBCELLS, VolumeSample, VoxelSamples};
pub use model::camera::{Camera, Lens};
pub use model::face_table::{FaceMesh, FaceTable, FacetValues};
pub use model::intensity_distribution::{IntensityDistribution, IntensityTable, PlaneSymmetry};
pub use model::light::{Light, Surroundings};
pub use model::options::{Engine, LightGrouping, PatchRule, SolveOptions, ZoneBasis};
pub use model::shading::{CornerNormals, NormalMap, ShadedPoint, ShadingNormals, SidedFacet};
pub use model::sky_distribution::{SkyDistribution, SkyIrradiance, SkyPlacement};
pub use model::sun_position::{SunPosition, UniversalTime};
pub use model::surface::{DEFAULT_REFLECTANCE, Facet, Pane, Sides, Surface, Texture, Transmission};
pub use scene::Scene;
pub use scene::scene_parts::SceneParts;
pub use solution::Solution;
pub use solution::energy_balance::EnergyBalance;
pub use solution::face_results::FaceResult;
pub use solution::fields::{FieldList, Fields, ThermalFields};
pub use solution::heat_report::{HeatReport, HeatRow, HeatRowKind, NodeResult};
pub use solution::light_group::{LightGroup, LightGroupKind, ZoneValues};
pub use solution::photometry::{Photometry, SurfaceIlluminance};
pub use solution::report::{
    ClosureDefect, DiscretizationError, ErrorEstimate, ErrorParts, Report, SquareSums,
};
pub use solution::results::SurfaceResult;
pub use solution::solve_status::SolveStatus;
pub use thermal::emissivity::{EmissivityTable, SideEmissivity, SurfaceEmissivity};
pub use thermal::thermal_network::{
    Convection, LinkLaw, NodeCondition, NodeLink, ThermalNetwork, ThermalNode,
};
pub use thermal::{BandFractions, CellFractions, Thermal, ThermalCondition};
pub use zones::merged_patches::MergedPatches;
pub use zones::sheet_sides::SheetSides;
pub use zones::voxel_zones::{VoxelPlace, VoxelZone, VoxelZones};
pub use zones::{MAX_CONTINUED_PATCH_SIZES, PaneZone, Patch, ZoneKind, ZoneRef, Zones};
