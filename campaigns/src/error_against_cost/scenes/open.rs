//! Open scenes under sun and sky.

use super::SceneFolder;
use super::mesh::{BodySide, MeshText, SeededNumbers};
use crate::harness::Error;
use std::f64::consts::TAU;
use std::fmt::Write as _;

const SUN_AND_SKY: &str = "[[light]]\nkind = \"sun\"\nname = \"sun\"\ndirection = [-0.5, 0.35, -0.7]\nirradiance = [900, 860, 780]\n\
    [[light]]\nkind = \"sky\"\nname = \"sky\"\nradiance = [25, 32, 45]\n";

/// Blocks of the city along an edge.
const CITY_BLOCKS: usize = 8;

/// A city: 64 boxes of different heights on a ground of 200 m, under sun and sky.
pub(super) fn city(_: &SceneFolder) -> Result<String, Error> {
    let mut t = String::from(
        "name = \"city\"\n[solve]\ntolerance = 0.05\npatch_size = 7\n\
         [[surface]]\nname = \"ground\"\nrectangle = { origin = [0, 0, 0], edge1 = [200, 0, 0], edge2 = [0, 200, 0] }\nreflectance = [0.3, 0.3, 0.28]\n",
    );
    let mut numbers = SeededNumbers(64);
    for k in 0..CITY_BLOCKS * CITY_BLOCKS {
        let at = [k % CITY_BLOCKS, k / CITY_BLOCKS].map(|i| 6.0 + 24.0 * i as f64);
        let (wide, deep) = (numbers.between(12.0, 18.0), numbers.between(12.0, 18.0));
        let height = 8.0 + 40.0 * numbers.uniform().powi(2);
        let white = numbers.between(0.3, 0.7);
        let _ = write!(
            t,
            "[[surface]]\nname = \"house {k}\"\nbox = {{ min = [{:.3}, {:.3}, 0], max = [{:.3}, {:.3}, {height:.3}] }}\nreflectance = [{:.3}, {:.3}, {:.3}]\n",
            at[0],
            at[1],
            at[0] + wide,
            at[1] + deep,
            white,
            0.95 * white,
            0.88 * white
        );
    }
    t += SUN_AND_SKY;
    t += "[[camera]]\nname = \"above\"\norigin = [-60, -60, 90]\ntarget = [90, 90, 0]\nfov = 60\n";
    Ok(t)
}

/// Cells of the terrain along an edge: two triangles each.
const TERRAIN_CELLS: usize = 57;

/// Height of the terrain, m: waves of four lengths.
fn height(x: f64, y: f64, phases: &[[f64; 3]]) -> f64 {
    let wave = |(k, p): (usize, &[f64; 3])| {
        let length = 60.0 / f64::from(1 << (k / 3));
        let (sin, cos) = p[0].sin_cos();
        0.11 * length * p[2] * (std::f64::consts::TAU * (cos * x + sin * y) / length + p[1]).sin()
    };
    phases.iter().enumerate().map(wave).sum()
}

/// An open height field of 6,498 triangles.
pub(super) fn terrain(folder: &SceneFolder) -> Result<String, Error> {
    let mut numbers = SeededNumbers(57);
    let phases: Vec<[f64; 3]> = (0..12)
        .map(|_| [numbers.between(0.0, TAU), numbers.between(0.0, TAU), numbers.between(0.4, 1.0)])
        .collect();
    let n = TERRAIN_CELLS + 1;
    let vertex = |k: usize| {
        let [x, y] = [k % n, k / n].map(|i| 100.0 * i as f64 / TERRAIN_CELLS as f64);
        [x, y, height(x, y, &phases)]
    };
    let vertices: Vec<[f64; 3]> = (0..n * n).map(vertex).collect();
    let faces: Vec<[usize; 3]> = (0..TERRAIN_CELLS * TERRAIN_CELLS)
        .flat_map(|k| {
            let a = k / TERRAIN_CELLS * n + k % TERRAIN_CELLS;
            [[a, a + 1, a + n + 1], [a, a + n + 1, a + n]]
        })
        .collect();
    let mut mesh = MeshText::default();
    mesh.part(&vertices, &faces);
    let mut t = String::from(
        "name = \"terrain\"\n[solve]\ntolerance = 0.05\npatch_size = 5\npatch_rule = \"area\"\n",
    );
    t += &folder.mesh_surface("terrain", "terrain", &mesh)?;
    t += "sides = \"front\"\nreflectance = [0.4, 0.45, 0.3]\n";
    t += SUN_AND_SKY;
    t += "[[camera]]\nname = \"above\"\norigin = [-20, -20, 45]\ntarget = [50, 50, 0]\nfov = 60\n";
    Ok(t)
}

/// A ball of 2,000 triangles that lies on a floor, under a lamp and the sky.
pub(super) fn ball(folder: &SceneFolder) -> Result<String, Error> {
    let mut mesh = MeshText::default();
    mesh.sphere([0.0, 0.0, 0.5], 0.5, [40, 26], BodySide::Outside);
    let mut t = String::from(
        "name = \"ball\"\n[solve]\ntolerance = 0.05\npatch_size = 0.12\n\
         [[surface]]\nname = \"floor\"\nrectangle = { origin = [-2, -2, 0], edge1 = [4, 0, 0], edge2 = [0, 4, 0] }\nreflectance = [0.6, 0.58, 0.55]\n\
         [[surface]]\nname = \"lamp\"\nrectangle = { origin = [0.8, -0.9, 2.4], edge1 = [0, 0.5, 0], edge2 = [0.5, 0, 0] }\nreflectance = 0.5\nemission = [900, 800, 650]\n\
         [[light]]\nkind = \"emitter\"\nname = \"lamp\"\nsurface = \"lamp\"\n\
         [[light]]\nkind = \"sky\"\nname = \"sky\"\nradiance = [20, 25, 32]\n",
    );
    t += &folder.mesh_surface("ball", "ball", &mesh)?;
    t += "reflectance = [0.7, 0.25, 0.2]\n[[camera]]\nname = \"side\"\norigin = [2.2, -2.4, 0.9]\ntarget = [0, 0, 0.35]\nfov = 45\n";
    Ok(t)
}
