//! The cubes of the Monte Carlo tables as scenes.

use crate::harness::{Error, ScratchFolder};
use zonal_io::output;
use zonal_validation::validate::comparisons::montecarlo::cubes::MonteCarloCube;

/// The text of a cube with n³ voxels and the lines `settings` of `[solve]`; writes the densities of its medium into `scratch` where they vary.
pub(crate) fn text(
    cube: &MonteCarloCube,
    n: usize,
    settings: &str,
    tables: &std::path::Path,
    scratch: &ScratchFolder,
) -> Result<String, Error> {
    let density = scratch.join(format!("{}.npy", cube.name));
    if cube.varies() {
        let (shape, values) = cube.extinction(tables)?;
        output::write_array(&density, &shape, &values)?;
    }
    Ok(cube.text(n, settings, &density.display().to_string()))
}
