//! Exchange areas, view factors and factors of pairs.
//!
//! | module | contents |
//! |---|---|
//! | [`exchange_areas`] | exchange areas of all pairs of zones in files |
//! | [`state_update`] | states of a geometry from stored exchange areas |
//! | [`view_factors`] | facets, files and warnings of view factors |
//! | [`pair_table`] | factors of a table of pairs |

pub mod exchange_areas;
pub mod pair_table;
pub mod state_update;
pub mod view_factors;

use zonal_report::Failure;

/// Checks a relative tolerance that is no option of a scene.
///
/// # Errors
/// If the tolerance is not between 0 and 1.
pub fn check_tolerance(tolerance: f64) -> Result<(), Failure> {
    if tolerance > 0.0 && tolerance < 1.0 {
        return Ok(());
    }
    Err(Failure::new("--tolerance: give a number between 0 and 1"))
}
