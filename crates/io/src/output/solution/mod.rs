//! A solution as one `.npz`: a zip of numpy arrays, and a JSON header.
//!
//! ```python
//! import json, numpy as np
//! z = np.load("room.npz")
//! header = json.loads(bytes(z["header.json"]))        # names, lights, cameras, options, report, provenance
//! B = z["radiosity"]                                   # [zones, bands], W/m²; patches, then voxels, then panes
//! ```
//!
//! | arrays | shape | contents |
//! |---|---|---|
//! | `radiosity`, …: the names of [`zonal_scene::Fields::LISTS`] | [zones, bands]; [0, bands] of optional ones without values | the fields |
//! | `temperature`, `temperature_error`, `net`, `net_error` | \[zones\] | in thermal mode: K, and the net power that leaves a zone, W/m² of patches, W/m³ of the others; undefined temperatures are NaN |
//! | `group_0_incident`, `group_0_direct`, … | [zones, bands], `<f8` or `<f4`; [0, bands] for none | the part of each light group, times `incident_scale` and `direct_scale` in `report.light_groups` of the header |
//! | `group_0_error`, … | [zones, bands] | its part of `error`, times `incident_scale`, if errors are known for each group |
//! | `group_0_direct_error`, … | [zones, bands] | its part of `direct_error`, times `direct_scale`, if it has direct light |
//! | `patch_origin`, `_e1`, `_e2`, `_kind`, `_normal`, `_area`, `_facet`, `_surface`, `_reflectance`, `_emission` | [patches, …] | surface zones; kind 0 triangle, 1 parallelogram |
//! | `voxel_cell`, `_centre`, `_volume`, `_extinction`, `_albedo`, `_emission`, `_source` | [voxels, …] | volume zones |
//! | `voxel_part_first`, `part_subcell`, `part_packed` | CSR | samples of cut voxels, if there are any: zone i has the rows `first[i]` to `first[i+1]`; `part_packed.view("<u2").reshape(-1, 4)` is the position in the sub-cell and the fraction of the volume, in 2⁻¹⁶ |
//! | `pane_zone_*` | [pane zones, …] | pane zones |
//! | `facet_origin`, `_e1`, `_e2`, `_kind`, `_surface`, `_uv` | [facets, …] | the scene's surfaces |
//! | `pane_plate_*`, `pane_plate_pane` | [plates, …] | the scene's panes |
//! | `texture_0` … | [height, width, 3] f32 | linear textures |
//! | `sky_0` … | [height, width, 3] f32 | pictures of skies, by the number of the light |
//! | `voxmap_extinction`, `_albedo`, `_emission`, `_source` | [nx, ny, nz, bands] | the medium |
//! | `voxmap_interpolated` | \[cells\], or \[1\] for all | where a density samples a smooth field: 1 for cells between which pictures interpolate the extinction |
//! | `voxmap_heat` | [nx, ny, nz, 3] | in thermal mode: 1, T, 0 for a given temperature (K), else 0, 0, Q (W/m³) |
//!
//! Arrays of bands have one column for each band of `header["bands"]`; files without it have red, green and blue. `cell_fraction_kind` [cells] and
//! `cell_fraction_polynomials` [kinds, bands, powers] give band fractions that differ from cell to cell. The textures of further blocks of bands are
//! `texture_0_block_1` and so on.
//!
//! A quantity of patches, voxels, pane zones or cells whose rows are all equal is one row, of shape [1, …] or [1, 1, 1, …], which numpy
//! broadcasts. An array whose three bands are equal everywhere has one column, of shape [zones, 1], in scenes without colours. Nothing is compressed. Files of other versions of the format (`header.rs`) are refused.
//!
//! Reals are `<f8`, indices `<i8`, kinds and sub-cells `|u1`.

mod faces;
pub(in crate::output) mod header;
mod read;
mod shading;
#[cfg(test)]
mod tests;
pub(in crate::output) mod write;

pub use read::{read_solution, read_solution_from_bytes};
pub use write::{CollectZones, collect_solution, solution_bytes, write_divided_solution, write_solution};
