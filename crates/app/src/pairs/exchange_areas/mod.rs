//! Direct and total exchange areas of all pairs of zones of a scene, as arrays.
//!
//! With n zones in the order of a solution (patches, voxel zones, pane zones), k names, and m matrices (one if the bands do not differ, else one for
//! each band), the file holds, all in m² and symmetric to the bit:
//!
//! | array | shape | contents |
//! |---|---|---|
//! | `exchange_areas`, `error_radius` | [m, n, n] | direct exchange areas F: without reflection and scattering |
//! | `closure` | [m, n] | row sums of F in a closed scene: A of a patch, 4κV of a volume |
//! | `total_exchange_areas`, `total_error_radius` | [m, n, n] | total exchange areas T: net power from i to j per unit of σT_i⁴ − σT_j⁴ |
//! | `total_closure` | [m, n] | row sums of T in a closed scene: εA, 4κ_aV |
//! | `named_exchange_areas`, `named_error_radius` | [m, k, k] | sums of T over surfaces, medium and panes |
//! | `about` | bytes | JSON: `names`, in the order of these sums; `name_of_zone`, an index for each zone; units; meshes, band fractions |
//!
//! and in thermal mode, for [`super::state_update`]:
//!
//! | array | shape | contents |
//! |---|---|---|
//! | `zone_size` | `n` | A in m², V in m³ |
//! | `reflectance` | [bands, n] | ρ of patches, Ω of volumes |
//! | `condition` | [n, 2] | 1 and T (K), or 2 and the flux that leaves (W/m², W/m³) |
//! | `zone_face` | `n` | face among the faces of all meshes, −1 for none |
//! | `surroundings_areas`, `surroundings_radius`, `backface_areas` | [m, n] | exchange with the surroundings, its standard error, and with black backs, scaled with the rows |
//! | `closure_scaling` | [m, n] | d of the rows: the areas of a state are d_i F_ij d_j; 1, since `exchange_areas` of a thermal scene are those after restoration of closure |
//! | `closure_error` | [m, n] | error of the incident power by closure, relative to it |
//! | `light_incident`, `light_error` | [bands, n] | direct light H of patches, G/4 of volumes, and its error, W/m²; with lights |
//! | `light_power` | [bands, 5] | power sent in, emitted, escaping and on black backs unscattered, and the error of all these, W; with lights |
//! | `zone_fractions` | `n` | band fractions of each zone among those of `about`; where they differ |

mod fractions;
mod npz;
mod text;

pub use npz::read_state;

use crate::Error;
use std::path::{Path, PathBuf};
use zonal_scene::{Progress, Scene};
use zonal_solve::areas::exchange_areas::ExchangeAreas;
use zonal_solve::state::ExchangeData;

/// Writes exchange areas in the format of the extension (npz, csv, mtx); returns the paths of all files.
///
/// # Errors
/// If a file cannot be written.
pub fn write(
    output: &Path,
    scene: &Scene,
    areas: &ExchangeAreas,
    progress: &dyn Progress,
) -> Result<Vec<PathBuf>, Error> {
    let extension = output.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("csv") => Ok(text::write_csv(output, areas)?),
        Some("mtx") => Ok(text::write_mtx(output, areas)?),
        _ => {
            // Most scenes in thermal mode also have the data of other states.
            let has_state = ExchangeData::refusal(scene).is_none();
            let state = has_state.then(|| ExchangeData::new(scene, areas, progress)).transpose()?;
            npz::write(output, areas, state.as_ref())?;
            Ok(vec![output.to_path_buf()])
        }
    }
}
