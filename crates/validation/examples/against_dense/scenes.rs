//! The scenes on which the engines are compared.

#[path = "../common/cornell.rs"]
mod cornell;
#[path = "../common/sized.rs"]
mod sized;

use crate::random;
use std::path::{Path, PathBuf};
use zonal_io::{input, output};
use zonal_scene::Scene;

/// The scenes that have a name, with their size where none is asked for: cells along an edge, or the longest.
pub(crate) const NAMED_SCENES: [(&str, usize); 7] =
    [("c0", 10), ("c9", 10), ("c8", 10), ("demo", 7), ("cornell", 14), ("random1", 11), ("random2", 11)];
const DENSITY_TABLE: &str = "reference/montecarlo/c8_het_a0.90_r0.5.npz";
const MESHES_FOLDER: &str = "data/cornell/mitsuba-cbox/meshes";
const BLOCK_SURFACE: &str =
    "[[surface]]\nname = \"block\"\nbox = { min = [0.4,0.3,0.2], max = [0.7,0.6,0.6] }\nreflectance = 0.5\n";

fn room(n: usize, kappa: f64, albedo: f64, extra: &str) -> String {
    format!(
        "name = \"room\"\n[solve]\npatch_size = {}\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\nreflectance = 0.5\nfaces.x0 = {{ emission = 1 }}\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [{n},{n},{n}]\nextinction = {kappa}\nalbedo = {albedo}\n{extra}",
        1.0 / n as f64
    )
}

/// The demo with patches and cells as given, or in step with 0.9 m and 7 × 12 × 5 cells.
fn demo(n: usize) -> String {
    let of = |k: f64| (k * n as f64 / 7.0).round();
    zonal_demo::CHAPEL_TEMPLATE
        .replace("PATCH", &format!("{}", 0.9 * 7.0 / n as f64))
        .replace("CELLS", &format!("[{n}, {}, {}]", of(12.0), of(5.0)))
}

/// The unit room with the density of the table of c8, copied to a file.
fn varying(n: usize, shared: &Path, file: &Path) -> Result<String, Box<dyn std::error::Error>> {
    let (shape, values) = output::read_array(&shared.join(DENSITY_TABLE), "sigma_t")?;
    output::write_array(file, &shape, &values)?;
    let place = format!(
        "[[medium.region]]\ndensity = {{ file = {:?}, min = [0,0,0], max = [1,1,1], scale = 1.0 }}\nalbedo = 0.9\n",
        file.display().to_string()
    );
    Ok(room(n, 0.0, 0.9, &place))
}

/// The Cornell box in haze, each of its cells as wide as a patch.
fn boxes(n: usize, shared: &Path) -> String {
    let solve = format!("patch_size = {}", 560.0 / n as f64);
    cornell::cornell("cornell", &shared.join(MESHES_FOLDER), cornell::BoxContents::Boxes, &solve)
        + &cornell::haze(0.002, "0.8", n)
}

/// The scene of a file, with a given number of cells along each edge of its medium if any.
fn of_file(file: &Path, cells: Option<usize>) -> Result<Scene, Box<dyn std::error::Error>> {
    let Some(n) = cells else { return Ok(input::read_scene(file)?) };
    let text = sized::with(&std::fs::read_to_string(file)?, "cells", |_| Ok(format!("{:?}", [n; 3])))?;
    let name = file.file_stem().and_then(|s| s.to_str()).unwrap_or("scene");
    Ok(input::parse_scene(&text, file.parent(), name)?)
}

/// The scene of a name, or of a file; `size` cells along an edge.
pub(crate) fn scene(
    name: &str,
    size: Option<usize>,
    shared: &Path,
) -> Result<Scene, Box<dyn std::error::Error>> {
    let default = NAMED_SCENES.iter().find(|s| s.0 == name).map_or(11, |s| s.1);
    let n = size.unwrap_or(default);
    if !(1..=1000).contains(&n) {
        return Err(format!("--size {n}: give 1 to 1000").into());
    }
    let file: PathBuf = std::env::temp_dir().join(format!("zonal-{name}-{}.npy", std::process::id()));
    let seed = name.strip_prefix("random").and_then(|s| s.parse().ok());
    let text = match name {
        "c0" => room(n, 1.0, 0.9, ""),
        "c9" => room(n, 1.0, 0.5, BLOCK_SURFACE),
        "c8" => varying(n, shared, &file)?,
        "demo" => demo(n),
        "cornell" => boxes(n, shared),
        _ => match seed {
            Some(seed) => random::scene(seed, n, &file)?,
            None => return of_file(Path::new(name), size),
        },
    };
    let scene = input::parse_scene(&text, Some(&std::env::temp_dir()), name);
    if file.exists() {
        std::fs::remove_file(&file)?;
    }
    Ok(scene?)
}
