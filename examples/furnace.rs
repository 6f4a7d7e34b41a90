//! A furnace: walls of known temperature, a gas with a heat source, the gas temperature and the wall fluxes with errors.
//!
//!     cargo run --release -p zonal --example furnace

use zonal::prelude::*;

fn main() -> Result<(), Error> {
    let (min, max) = ([0.0; 3], [2.0, 2.0, 4.0]);
    let walls = Mesh::room_walls(min, max).map(|wall| match wall.given_name() {
        Some("z0") => wall.temperature(1200.0).emissivity(0.85),
        Some("z1") => wall.temperature(400.0).emissivity(0.7),
        _ => wall.temperature(900.0).emissivity(0.7),
    });
    // One value for each voxel is possible too: `.heat_source(vec![…])`.
    let gas = Medium::grid(min, max, [4, 4, 8]).extinction(0.5).heat_source(5000.0);
    let options = SolveOptions { patch_rule: PatchRule::Voxels, ..SolveOptions::default() };
    let scene = Scene::builder().surfaces(walls).medium(gas).options(options).build()?;

    let solution = Solver::new(&scene).solve()?;
    for wall in solution.surfaces() {
        let error = wall.total_error().unwrap_or(f64::INFINITY);
        println!("{}: {:9.1} ± {:.1} W ({:.0} W/m²)", wall.name, wall.net_power, error, wall.net_flux());
    }
    if let Some(heat) = &solution.fields.heat {
        let voxels = &heat.temperature[solution.zones.voxel_offset()..];
        let hottest = voxels.iter().copied().fold(0.0, f64::max);
        println!("hottest voxel: {hottest:.1} K");
    }
    Ok(())
}
