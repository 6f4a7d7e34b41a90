//! Ranges of the physical quantities of a scene.

/// Largest modulus of a coordinate, m.
pub const MAX_COORDINATE: f64 = 1e8;
/// Smallest area of a plate, m².
pub(crate) const MIN_PLATE_AREA: f64 = 1e-24;
/// Smallest edge of a voxel, m.
pub(crate) const MIN_CELL_EDGE: f64 = 1e-9;
/// Largest number of cells of a voxel grid whose values differ from cell to cell: at 100 bytes per cell, the memory of a large machine.
pub const MAX_CELLS: usize = 1 << 25;
/// Largest number of cells of a voxel grid with the same values in all cells, which take no memory: twice those of 512³.
pub const MAX_UNIFORM_CELLS: usize = 1 << 28;
/// Largest extinction, 1/m.
pub const MAX_EXTINCTION: f64 = 1e8;
/// Largest emission, irradiance or radiance, W/m² or W/(m² sr), and largest volumetric source, W/m³.
pub(crate) const MAX_FLUX: f64 = 1e30;
/// Largest temperature, K.
pub const MAX_TEMPERATURE: f64 = 1e6;
/// Largest modulus of a prescribed net power, in W, W/m² or W/m³.
pub const MAX_NET_POWER: f64 = 1e18;
/// Largest number of faces of all mesh files.
pub const MAX_FACES: usize = 1 << 30;
