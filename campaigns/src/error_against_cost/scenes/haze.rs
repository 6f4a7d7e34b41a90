//! Small rooms with haze and smoke, and their lamps and windows.

use super::SceneFolder;
use super::rooms::{lamp, wall_with_opening};
use crate::harness::Error;
use zonal_io::output;

/// A lamp of 1 m² in the haze of a room of 4 m × 4 m × 3 m in cells of `cell` metres.
pub(super) fn lamp_in_haze(name: &str, cell: f64) -> String {
    format!(
        "name = \"{name}\"\n[solve]\ntolerance = 0.05\npatch_size = 0.5\n\
         [[surface]]\nname = \"room\"\nroom = {{ min = [0, 0, 0], max = [4, 4, 3] }}\nreflectance = [0.5, 0.48, 0.45]\n\
         {}[medium]\nmin = [0, 0, 0]\nmax = [4, 4, 3]\ncell_size = {cell}\nextinction = 0.15\nalbedo = 0.9\n\
         [[camera]]\nname = \"corner\"\norigin = [0.3, 0.4, 1.6]\ntarget = [2.4, 2.4, 1.5]\nfov = 75\n",
        lamp([1.2, 1.7, 2.35], 1.0, "[300, 270, 220]")
    )
}

/// Cells of the smoke along the axes.
const SMOKE_CELLS: [usize; 3] = [8, 8, 14];

/// A rising column of smoke whose axis bends: its extinction in cell (i, j, k), 1/m.
fn smoke([i, j, k]: [usize; 3]) -> f64 {
    let part = |i: usize, axis: usize| (i as f64 + 0.5) / SMOKE_CELLS[axis] as f64;
    let (x, y, z) = (part(i, 0), part(j, 1), part(k, 2));
    let (along, across) = (x - 0.5 - 0.15 * (5.0 * z).sin(), y - 0.5 - 0.1 * (4.0 * z).cos());
    let radius = 0.12 + 0.18 * z;
    2.5 * (-(along * along + across * across) / (radius * radius)).exp() * (1.0 - 0.6 * z)
}

/// A room with a column of smoke beside a window, through which the sun shines.
pub(super) fn smoke_by_window(folder: &SceneFolder) -> Result<String, Error> {
    let [nx, ny, nz] = SMOKE_CELLS;
    let cell = |m: usize| [m / (ny * nz), m / nz % ny, m % nz];
    let densities: Vec<f64> = (0..nx * ny * nz).map(|m| smoke(cell(m))).collect();
    let file = "smoke-window.npy";
    output::write_array(&folder.path.join(file), &SMOKE_CELLS, &densities)?;
    let mut t = String::from(
        "name = \"smoke-window\"\n[solve]\ntolerance = 0.05\npatch_size = 0.4\n\
         [[surface]]\nname = \"room\"\nroom = { min = [0, 0, 0], max = [4, 3.5, 2.8] }\nreflectance = [0.6, 0.58, 0.55]\nomit = [\"x1\"]\n\
         faces.z0 = { reflectance = [0.4, 0.32, 0.25] }\n",
    );
    t += &wall_with_opening(4.0, [3.5, 2.8], [[1.0, 2.5], [0.9, 2.3]], "[0.6, 0.58, 0.55]");
    t += &format!(
        "[medium]\nmin = [1.9, 0.9, 0]\nmax = [3.5, 2.5, 2.8]\ncells = {SMOKE_CELLS:?}\n\
         [[medium.region]]\ndensity = {{ file = \"{file}\", min = [1.9, 0.9, 0], max = [3.5, 2.5, 2.8], scale = 1 }}\nalbedo = [0.9, 0.9, 0.92]\n\
         [[light]]\nkind = \"sun\"\nname = \"sun\"\ndirection = [-0.8, 0.15, -0.55]\nirradiance = [900, 840, 740]\n\
         [[light]]\nkind = \"sky\"\nname = \"sky\"\nradiance = [25, 32, 45]\n\
         [[camera]]\nname = \"door\"\norigin = [0.3, 0.4, 1.6]\ntarget = [3.2, 2, 1.2]\nfov = 75\n"
    );
    Ok(t)
}
