//! Relighting: one solve, then lamps on dimmers without another solve.
//!
//!     cargo run --release -p zonal --example relighting

use zonal::prelude::*;

fn main() -> Result<(), Error> {
    let lamp = |name: &str, x: f64| {
        Mesh::rectangle([x, 1.3, 2.4], [0.0, 0.4, 0.0], [0.4, 0.0, 0.0])
            .name(name)
            .emission(500.0)
            .sides(Sides::Front)
    };
    let scene = Scene::builder()
        .surface(Mesh::room([0.0; 3], [4.0, 3.0, 2.5]).name("room").reflectance(0.6))
        .surface(lamp("left", 0.8))
        .surface(lamp("right", 2.8))
        .patch_size(0.4)
        .build()?;
    let solution = Solver::new(&scene).tolerance(0.02).solve()?;

    let absorbed = |s: &Solution| s.surface("room").map_or(0.0, |room| room.absorbed.mean());
    println!("both lamps:       {:.1} W", absorbed(&solution));
    for (left, right) in [(1.0, 0.0), (0.25, 1.0)] {
        let relit = zonal::relight(solution.clone(), &[("left", left), ("right", right)])?;
        println!("left {left}, right {right}: {:.1} W", absorbed(&relit));
    }
    Ok(())
}
