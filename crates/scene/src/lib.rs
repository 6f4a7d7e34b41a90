//! Domain types: the scene, the zones into which it is divided, and the solution on them.
//!
//! All types are data with validation. This crate and those above it except `zonal-io` and the command access neither files nor clock nor
//! network; formats are in `zonal-io`, ray tracing in `zonal-transport`.
//!
//! | module | contents |
//! |---|---|
//! | `plate`, `weld`, [`shells`], `t_junctions`, [`topology`] | triangles and parallelograms; coincident corners; open shells, solids and enclosures; defects of meshes |
//! | `surface`, `light`, `camera`, `voxel_grid` | surfaces and panes; lights and surroundings; cameras; the medium |
//! | `intensity_distribution` | radiant intensity of point lights over directions: spots, photometric tables |
//! | `sky_distribution`, `sun_position` | radiance of skies over directions; the sun by place and time |
//! | `face_table`, `face_results` | faces of mesh files, values and results by face |
//! | [`thermal`] | prescribed temperatures and net powers, band fractions of the emission |
//! | `options` | settings of a solve |
//! | `scene_parts`, `validation`, `scene` | the parts of a scene, their validation, the validated [`Scene`] |
//! | `coarsened_scene` | the scene on larger or smaller zones |
//! | `even_extension` | scenes with mirrors as parts of their even extensions |
//! | `grid_geometry`, `cell_values` | position and size of the cells of a grid; values stored once if they are equal |
//! | `zones`, `sheet_sides`, `sheet_pairing`, `voxel_zones`, [`voxel_samples`] | patches and pane zones; sides of transmitting sheets; voxel zones; samples of cut voxels |
//! | `fields`, [`light_group`], `energy_balance`, `heat_report`, `report`, `solution` | results |
//! | `photometry` | illuminances of a solution |
//! | `diagnostic`, `scene_error` | notes and warnings; validation errors |
//! | `progress`, [`checkpoint_store`] | observers and checkpoints of long computations |
//! | [`limits`] | ranges of physical quantities |
//! | `band_set`, `band`, `bands` | number, names and wavelengths of the bands; three bands as indices; band-indexed values with operators |
//!
//! Units: m, 1/m for extinction, W/m² for radiosity B, irradiance H and fluence G, W/m³ for volumetric sources, each per band. Bands
//! are stored three at a time; by default they are red, green and blue. Grey thermal scenes have equal values in all three.

mod band;
mod band_set;
mod bands;
mod black_body_bands;
mod builder;
mod camera;
mod cell_values;
pub mod checkpoint_store;
mod coarsened_scene;
mod diagnostic;
mod emissivity;
mod energy_balance;
mod even_extension;
mod face_results;
mod face_table;
mod fields;
mod grid_geometry;
mod heat_report;
mod intensity_distribution;
mod light;
pub mod light_group;
pub mod limits;
mod merged_patches;
mod mirror_validation;
mod options;
mod photometry;
mod plate;
mod printable;
mod progress;
mod report;
mod results;
mod scene;
mod scene_error;
mod scene_parts;
mod shading;
mod sheet_pairing;
mod sheet_sides;
pub mod shells;
mod sky_distribution;
mod solution;
mod solve_status;
mod sun_position;
mod surface;
mod t_junctions;
pub mod thermal;
mod thermal_network;
mod thermal_validation;
pub mod topology;
mod validation;
mod voxel_grid;
pub mod voxel_samples;
mod voxel_zones;
mod weld;
mod zones;

pub use band::{Band, BandCountError, PerBand};
pub use band_set::{BandSet, MAX_BANDS};
pub use bands::Bands;
pub use builder::{
    BandValues, GlassPane, Medium, Mesh, Planet, PointLight, SceneBuilder, Sky, Sun, VoxelValues,
};
pub use camera::{Camera, Lens};
pub use checkpoint_store::{CheckpointStore, NoCheckpoints};
pub use diagnostic::{Diagnostic, Severity};
pub use emissivity::{EmissivityTable, SideEmissivity, SurfaceEmissivity};
pub use energy_balance::EnergyBalance;
pub use even_extension::{EvenExtension, ZoneImages};
pub use face_results::FaceResult;
pub use face_table::{FaceMesh, FaceTable, FacetValues};
pub use fields::{Fields, ThermalFields};
pub use heat_report::{HeatReport, HeatRow, HeatRowKind, NodeResult};
pub use intensity_distribution::{IntensityDistribution, IntensityTable, PlaneSymmetry};
pub use light::{Light, Surroundings};
pub use light_group::{LightGroup, LightGroupKind, ZoneValues};
pub use merged_patches::MergedPatches;
pub use options::{Engine, LightGrouping, PatchRule, SolveOptions, ZoneBasis};
pub use photometry::{Photometry, SurfaceIlluminance};
pub use plate::{Plate, PlateKind};
pub use printable::{printable, printable_lines};
pub use progress::{NoProgress, Progress};
pub use report::{ClosureDefect, DiscretizationError, ErrorEstimate, Report, SquareSums};
pub use results::SurfaceResult;
pub use scene::Scene;
pub use scene_error::{SceneError, SceneErrorKind};
pub use scene_parts::SceneParts;
pub use shading::{CornerNormals, NormalMap, ShadedPoint, ShadingNormals};
pub use sheet_sides::SheetSides;
pub use sky_distribution::{SkyDistribution, SkyIrradiance, SkyPlacement};
pub use solution::Solution;
pub use solve_status::SolveStatus;
pub use sun_position::{SunPosition, UniversalTime};
pub use surface::{DEFAULT_REFLECTANCE, Facet, Pane, Sides, Surface, Texture, Transmission};
pub use thermal::{BandFractions, CellFractions, Thermal, ThermalCondition};
pub use thermal_network::{Convection, LinkLaw, NodeCondition, NodeLink, ThermalNetwork, ThermalNode};
pub use voxel_grid::VoxelGrid;
pub use voxel_samples::{SUBCELLS, VolumeSample, VoxelSamples};
pub use voxel_zones::{VoxelPlace, VoxelZone, VoxelZones};
pub use zones::{MAX_CONTINUED_PATCH_SIZES, PaneZone, Patch, Zones};
