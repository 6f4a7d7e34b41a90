//! Entries of published tables, and scenes of published pictures.

use crate::harness::Error;
use crate::scenes::cornell::{self, BoxMedium};
use std::path::Path;
use zonal_io::input;
use zonal_math::{Vec3, vec3};
use zonal_reference::path_tracer::Detector;
use zonal_scene::{Plate, Scene};

/// Cells of the tables along an edge.
pub(super) const CELLS: usize = 10;
/// Cells of the table on a face of the block.
const BLOCK_CELLS: usize = 4;
const BLOCK_CORNERS: [Vec3; 2] = [vec3(0.4, 0.3, 0.2), vec3(0.7, 0.6, 0.6)];

/// Cell (i, j) of n × n on face `wall` (x0, x1, y0, …) of a box, with its normal inward, or outward.
fn face([lo, hi]: [Vec3; 2], wall: usize, cell: [usize; 2], n: usize, inward: bool) -> Detector {
    let (axis, upper) = (wall / 2, wall % 2 == 1);
    let [a, b] = [[1, 2], [0, 2], [0, 1]][axis];
    let unit = |k: usize, length: f64| Vec3::from_array([0, 1, 2].map(|j| if j == k { length } else { 0.0 }));
    let edge = |k: usize| unit(k, (hi - lo)[k] / n as f64);
    let mut origin = lo.array();
    origin[axis] = if upper { hi[axis] } else { lo[axis] };
    let origin = Vec3::from_array(origin) + edge(a) * cell[0] as f64 + edge(b) * cell[1] as f64;
    let normal = unit(axis, if upper == inward { -1.0 } else { 1.0 });
    let plate = Plate::parallelogram(origin, edge(a), edge(b));
    Detector::Patch { plate: if plate.normal().dot(normal) > 0.0 { plate } else { plate.flipped() }, normal }
}

/// Entry k of the tables: H on the walls, H on the block, G.
pub(super) fn receiver(quantity: &str, k: usize) -> Detector {
    let on = |corners, n, inward| face(corners, k / (n * n), [k / n % n, k % n], n, inward);
    match quantity {
        "H" => on([Vec3::ZERO, Vec3::ONE], CELLS, true),
        "Hocc" => on(BLOCK_CORNERS, BLOCK_CELLS, false),
        _ => {
            let step = 1.0 / CELLS as f64;
            let cell = [k / (CELLS * CELLS), k / CELLS % CELLS, k % CELLS];
            let lo = Vec3::from_array(cell.map(|i| i as f64 * step));
            Detector::Cell { lo, hi: lo + Vec3::splat(step) }
        }
    }
}

/// One of Mitsuba's Cornell boxes, its walls of two sides.
pub(super) fn cornell(name: &str, medium: BoxMedium, data: &Path) -> Result<Scene, Error> {
    let walls = "solid = false\nsides = \"both\"";
    let text = cornell::room(name, data, medium, "", walls)
        + &cornell::medium(medium, data, 1, cornell::SMOKE_FILE_CELLS);
    Ok(input::parse_scene(&text, Some(data), name)?)
}

/// The arcade of `mitsuba-refs/sponza_haze_st0.02_a09`.
pub(super) fn sponza(data: &Path) -> Result<Scene, Error> {
    let file = data.join("sponza-dabrovic/sponza-dabrovic.glb");
    let t = format!(
        "name = \"sponza\"\n[[surface]]\nname = \"hall\"\nmesh = {{ file = {:?} }}\nsolid = false\nsides = \"both\"\nreflectance = 0.7\n\
         [[surface]]\nname = \"sky\"\nrectangle = {{ origin = [-12, 15.2, -3], edge1 = [24, 0, 0], edge2 = [0, 0, 6] }}\nreflectance = 0\nemission = {}\nsides = \"front\"\n\
         [medium]\nmin = [-17.413, -0.917, -7.809]\nmax = [17.427, 15.663, 7.811]\ncells = [1, 1, 1]\nextinction = 0.02\nalbedo = 0.9\n\
         [[camera]]\nname = \"aisle\"\norigin = [-13, 1.7, 0]\ntarget = [12, 5, 0]\nup = [0, 1, 0]\nfov = 75\n",
        file.display().to_string(),
        10.0 * std::f64::consts::PI
    );
    Ok(input::parse_scene(&t, Some(data), "sponza")?)
}
