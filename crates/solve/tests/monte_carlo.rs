//! Four Monte Carlo tables at their resolution: clear, scattering, heterogeneous, with a block.
//!
//! The tables are in `shared/reference/montecarlo` beside the checkout; without them the tests report that and pass.

use crate::common;

use common::{read, solve};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use zonal_io::output::read_array;
use zonal_scene::{Bands, Scene, SceneParts, Solution, VoxelGrid};

const N: usize = 10;

/// A table, or `None` without the reference data.
fn table(file: &str, name: &str) -> Option<Vec<f64>> {
    let file: PathBuf =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/reference/montecarlo").join(file);
    file.exists().then(|| read_array(&file, name).ok().map(|a| a.1)).flatten()
}

/// The symmetrised table where there is one.
fn best(file: &str, quantity: &str) -> Option<Vec<f64>> {
    table(file, &format!("{quantity}_sym")).or_else(|| table(file, &format!("{quantity}_exp")))
}

fn room(kappa: f64, albedo: f64, rho: f64, block: bool) -> Scene {
    let mut t = format!(
        "[solve]\nengine = \"dense\"\npatch_size = {}\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\n\
         reflectance = {rho}\nfaces.x0 = {{ emission = 1 }}\n",
        1.0 / N as f64
    );
    if block {
        t.push_str("[[surface]]\nname = \"block\"\nbox = { min = [0.4,0.3,0.2], max = [0.7,0.6,0.6] }\nreflectance = 0.5\npatch_size = 0.026\n");
    }
    let _ = write!(
        t,
        "[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [{N},{N},{N}]\nextinction = {kappa}\nalbedo = {albedo}\n"
    );
    read(&t)
}

/// The same room with the extinctions of a table.
fn with_extinction(scene: Scene, sigma: &[f64], albedo: f64) -> Scene {
    let old = scene.voxel_grid().unwrap().clone();
    let mut map = VoxelGrid::new(old.min(), old.cell(), old.dims()).unwrap();
    for (i, s) in sigma.iter().enumerate() {
        map.set(i, Bands::splat(*s), Bands::splat(albedo), Bands::ZERO, Bands::ZERO);
    }
    Scene::new(SceneParts { voxel_grid: Some(map.seal().unwrap()), ..scene.into_parts() }).unwrap()
}

/// Means over cells of `h` on the faces of a box, by surface name and face: 6 × n × n.
fn on_faces(s: &Solution, name: &str, origin: [f64; 3], size: [f64; 3], n: usize, inward: bool) -> Vec<f64> {
    let (mut sum, mut area) = (vec![0.0; 6 * n * n], vec![0.0; 6 * n * n]);
    for (i, p) in s.zones.patches.iter().enumerate() {
        if !s.scene.surfaces()[p.surface].name.starts_with(name) {
            continue;
        }
        let axis = (0..3).max_by(|&a, &b| p.normal[a].abs().total_cmp(&p.normal[b].abs())).unwrap();
        let face = 2 * axis + ((p.normal[axis] > 0.0) != inward) as usize;
        // A patch is spread over the cells that it overlaps.
        let (lo, hi) = p.plate.bounds();
        let across: Vec<usize> = (0..3).filter(|&k| k != axis).collect();
        for cell in 0..n * n {
            let overlap = |k: usize, index: usize| {
                let unit = n as f64 / size[k];
                let (l, h) = ((lo[k] - origin[k]) * unit, (hi[k] - origin[k]) * unit);
                (h.min(index as f64 + 1.0) - l.max(index as f64)).max(0.0)
            };
            let w = overlap(across[0], cell / n) * overlap(across[1], cell % n);
            if w > 1e-9 {
                sum[face * n * n + cell] += w * s.fields.incident[i].first();
                area[face * n * n + cell] += w;
            }
        }
    }
    sum.iter().zip(&area).map(|(s, a)| s / a).collect()
}

/// Fluence of each cell, the mean over its zones; zero in solids.
fn in_cells(s: &Solution) -> Vec<f64> {
    (0..s.scene.voxel_grid().unwrap().len())
        .map(|c| {
            let zones = s.zones.voxel_zones_of_cell(c);
            let volume: f64 = zones.clone().map(|z| s.zones.voxels.at(z).volume).sum();
            let sum: f64 = zones
                .map(|z| s.zones.voxels.at(z).volume * s.fields.incident[s.zones.voxel_offset() + z].first())
                .sum();
            if volume > 0.0 { sum / volume } else { 0.0 }
        })
        .collect()
}

fn rms(ours: &[f64], table: &[f64]) -> f64 {
    assert_eq!(ours.len(), table.len());
    let d: Vec<f64> = ours.iter().zip(table).filter(|x| *x.1 > 0.0).map(|(o, t)| o / t - 1.0).collect();
    (d.iter().map(|x| x * x).sum::<f64>() / d.len() as f64).sqrt()
}

fn compare(file: &str, kappa: f64, albedo: f64, rho: f64, block: bool) {
    let (Some(h), Some(g)) = (best(file, "H"), best(file, "G")) else {
        println!("{file}: skipped, the table is not at hand");
        return;
    };
    let mut scene = room(kappa, albedo, rho, block);
    if let Some(sigma) = table(file, "sigma_t").filter(|_| kappa == 0.0) {
        scene = with_extinction(scene, &sigma, albedo);
    }
    let s = solve(scene);
    let (hr, gr) = (rms(&on_faces(&s, "room", [0.0; 3], [1.0; 3], N, true), &h), rms(&in_cells(&s), &g));
    println!("{file}: H {:.2} %, G {:.2} %", 100.0 * hr, 100.0 * gr);
    assert!(hr < 1.3e-2 && gr < 1.3e-2, "{file}: H {hr}, G {gr}");
    if block {
        let want = table(file, "Hocc_exp").expect("the block's table");
        let r = rms(&on_faces(&s, "block", [0.4, 0.3, 0.2], [0.3, 0.3, 0.4], 4, false), &want);
        println!("{file}: on the block {:.2} %", 100.0 * r);
        assert!(r < 1.3e-2, "{file}: block {r}");
    }
}

#[test]
fn thin_clear_room_agrees_with_monte_carlo() {
    compare("c1_K0.1_a0_r0.npz", 0.1, 0.0, 0.0, false);
}

#[test]
fn scattering_room_agrees_with_monte_carlo() {
    compare("c3_K1_a0.50_r0.npz", 1.0, 0.5, 0.0, false);
}

#[test]
fn heterogeneous_room_agrees_with_monte_carlo() {
    compare("c8_het_a0.90_r0.5.npz", 0.0, 0.9, 0.5, false);
}

#[test]
fn room_with_a_block_agrees_with_monte_carlo() {
    compare("c9_occ_K1_a0.50_r0.5.npz", 1.0, 0.5, 0.5, true);
}
