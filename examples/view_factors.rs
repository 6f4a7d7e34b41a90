//! View factors of a mesh: two facing squares and a wall between their edges.
//!
//!     cargo run --release -p zonal --example view_factors

use zonal::prelude::*;

fn main() -> Result<(), Error> {
    // Vertices in metres; faces counter-clockwise as seen from the side that exchanges.
    let vertices = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [1.0, 1.0, 1.0],
        [0.0, 1.0, 1.0],
    ];
    let mesh = |name: &str, faces: &[[usize; 3]]| -> Result<Mesh, Error> {
        Ok(Mesh::from_arrays(&vertices, faces)?.name(name).sides(Sides::Front).reflectance(0.0))
    };
    let scene = Scene::builder()
        .surface(mesh("floor", &[[0, 1, 2], [0, 2, 3]])?)
        .surface(mesh("ceiling", &[[4, 6, 5], [4, 7, 6]])?)
        .surface(mesh("wall", &[[0, 4, 5], [0, 5, 1]])?)
        .patch_size(2.0)
        .build()?;

    let settings = ExchangeAreaSettings { contents: ExchangeAreaContents::Direct, ..Default::default() };
    let areas = ExchangeAreas::compute(&scene, &settings, &NoProgress)?;
    let floor_area = 1.0;
    for to in ["floor", "ceiling", "wall"] {
        if let Some((area, error)) = areas.direct_between("floor", to) {
            println!("F(floor -> {to}) = {:.9} ± {:.1e}", area / floor_area, error / floor_area);
        }
    }
    Ok(())
}
