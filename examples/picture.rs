//! A picture: a box in a room with dusty air and sunlight through an opening, as PNG.
//!
//!     cargo run --release -p zonal --example picture

use zonal::prelude::*;

fn main() -> Result<(), Error> {
    let (min, max) = ([0.0; 3], [4.0, 5.0, 3.0]);
    // The wall y1 is left out: sunlight comes in there.
    let walls = Mesh::room_walls(min, max).into_iter().filter(|w| w.given_name() != Some("y1"));
    let scene = Scene::builder()
        .surfaces(walls.map(|wall| wall.reflectance([0.75, 0.7, 0.6])))
        .surface(Mesh::cuboid([1.2, 2.5, 0.0], [2.2, 3.5, 1.2]).name("box").reflectance([0.3, 0.4, 0.7]))
        .medium(Medium::grid(min, max, [16, 20, 12]).extinction(0.1).albedo(0.95))
        .light(Sun::new([0.3, -1.0, -0.6]).irradiance([1000.0, 950.0, 850.0]))
        .camera(Camera::look_at([3.6, 0.3, 1.6], [1.6, 4.0, 1.0]).name("corner").field_of_view_degrees(75.0))
        .patch_size(0.4)
        .build()?;

    let solution = Solver::new(&scene).tolerance(0.05).solve()?;
    let options = RenderOptions { width: 320, height: 240, ..RenderOptions::default() };
    let image = zonal::render::render(&solution, &scene.cameras()[0], &options, &NoProgress);
    let path = std::env::temp_dir().join("picture.png");
    zonal::io::write_png(&path, &image)?;
    println!("written: {}", path.display());
    Ok(())
}
