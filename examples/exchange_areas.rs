//! Exchange areas computed once and used for ten temperatures of one wall.
//!
//!     cargo run --release -p zonal --example exchange_areas

use zonal::prelude::*;

/// Stefan-Boltzmann constant, W/(m² K⁴).
const SIGMA: f64 = 5.670_374_419e-8;

fn main() -> Result<(), Error> {
    let (min, max) = ([0.0; 3], [1.0, 1.0, 2.0]);
    let walls = Mesh::room_walls(min, max).map(|wall| wall.reflectance(0.3));
    let gas = Medium::grid(min, max, [3, 3, 6]).extinction(1.0);
    let options = SolveOptions { patch_rule: PatchRule::Voxels, ..SolveOptions::default() };
    let scene = Scene::builder().surfaces(walls).medium(gas).options(options).build()?;

    // All reflections and all absorption by the gas are in the total exchange areas.
    let areas = ExchangeAreas::compute(&scene, &ExchangeAreaSettings::default(), &NoProgress)?;
    let temperature = |name: &str, bottom: f64| match name {
        "z0" => bottom,
        "medium" => 1400.0,
        _ => 600.0,
    };
    for step in 0..10 {
        let bottom = 600.0 + 100.0 * f64::from(step);
        let (mut power, mut error) = (0.0, 0.0);
        for other in &areas.names {
            if let Some((area, radius)) = areas.total_between("z0", other) {
                let difference = SIGMA * (bottom.powi(4) - temperature(other, bottom).powi(4));
                power += area * difference;
                error += radius * difference.abs();
            }
        }
        println!("bottom at {bottom:4.0} K gives {power:10.1} ± {error:.1e} W");
    }
    Ok(())
}
