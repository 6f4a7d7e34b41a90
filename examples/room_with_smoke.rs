//! A room with a lamp and smoke: density from an array, irradiance of the floor, the solution as a file.
//!
//!     cargo run --release -p zonal --example room_with_smoke

use zonal::prelude::*;

fn main() -> Result<(), Error> {
    let (min, max, cells) = ([0.0; 3], [4.0, 4.0, 3.0], [12, 12, 9]);
    // A plume of smoke that thins out towards the walls: extinction in 1/m, voxel (x, y, z) at (x ny + y) nz + z.
    let mut extinction = Vec::new();
    for x in 0..cells[0] {
        for y in 0..cells[1] {
            for _z in 0..cells[2] {
                let (dx, dy) = (x as f64 - 5.5, y as f64 - 5.5);
                extinction.push(0.8 * (-(dx * dx + dy * dy) / 12.0).exp());
            }
        }
    }
    let lamp = Mesh::rectangle([1.8, 1.8, 2.95], [0.0, 0.4, 0.0], [0.4, 0.0, 0.0]);
    let scene = Scene::builder()
        .surface(Mesh::room(min, max).name("room").reflectance([0.7, 0.6, 0.5]).patch_size(0.5))
        .surface(lamp.name("lamp").emission([900.0, 850.0, 750.0]).sides(Sides::Front))
        .medium(Medium::grid(min, max, cells).extinction(extinction).albedo(0.9))
        .build()?;

    let solution = Solver::new(&scene).tolerance(0.05).solve()?;
    for surface in solution.surfaces() {
        println!("{}: absorbs {:.1?} W in red, green, blue", surface.name, surface.absorbed.to_rgb());
    }
    println!("engine {}: {}", solution.report.engine, solution.report.reason);
    let path = std::env::temp_dir().join("room_with_smoke.npz");
    zonal::io::write_npz(&path, &solution)?;
    println!("written: {}", path.display());
    Ok(())
}
