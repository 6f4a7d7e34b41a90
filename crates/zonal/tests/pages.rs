//! The blocks of Rust in the pages, compiled and run: the functions below contain them line by line.

use zonal::prelude::*;

/// Code without comments, blanks and commas, which rustfmt may set otherwise than a page.
fn bare(code: &str) -> String {
    let lines = code.lines().map(|l| l.split("//").next().unwrap_or(""));
    lines.flat_map(str::chars).filter(|c| !c.is_whitespace() && *c != ',').collect()
}

/// The blocks of Rust in a page.
fn blocks(page: &str) -> Vec<&str> {
    page.split("```rust\n").skip(1).map(|rest| rest.split("```").next().unwrap_or("")).collect()
}

// Guards (documents): every block of code of the manual runs, in order and in an empty folder, or says why not.
#[test]
fn blocks_of_the_pages_are_those_of_this_file() {
    let here = bare(include_str!("pages.rs"));
    let pages = [include_str!("../../../README.md"), include_str!("../../../docs/tutorials/library.md")];
    let all: Vec<&str> = pages.iter().flat_map(|page| blocks(page)).collect();
    assert_eq!(all.len(), 4);
    for block in all {
        let code = block.replace("use zonal::prelude::*;", "");
        assert!(here.contains(&bare(&code)), "crates/zonal/tests/pages.rs lacks the block\n{code}");
    }
}

/// The block of the README. References to vertices and faces are those of the page.
#[allow(clippy::needless_borrow)]
fn block_of_the_readme(vertices: &[[f64; 3]], faces: &[[usize; 3]]) -> Result<(), Error> {
    let scene = Scene::builder()
        .surface(Mesh::from_arrays(&vertices, &faces)?.name("wall").reflectance(0.5))
        .medium(Medium::grid([0.0; 3], [4.0, 4.0, 8.0], [8, 8, 16]).extinction(0.5).albedo(0.9))
        .light(Sun::new([0.0, 1.0, -1.0]).irradiance(1000.0))
        .build()?;
    let solution = Solver::new(&scene).tolerance(1e-3).solve()?;

    assert!(solution.fields.radiosity.iter().any(|b| b.max_element() > 0.0));
    Ok(())
}

#[test]
fn block_of_the_readme_runs() {
    let vertices = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    block_of_the_readme(&vertices, &[[0, 1, 2]]).unwrap();
}

/// The blocks of the tutorial, one after the other.
fn blocks_of_the_tutorial() -> Result<(), Error> {
    let progress = NoProgress;
    let (min, max) = ([0.0; 3], [2.0, 2.0, 4.0]);
    let walls = Mesh::room_walls(min, max).map(|wall| match wall.given_name() {
        Some("z0") => wall.temperature(1200.0).emissivity(0.85),
        Some("z1") => wall.temperature(400.0).emissivity(0.7),
        _ => wall.temperature(900.0).emissivity(0.7),
    });
    let gas = Medium::grid(min, max, [4, 4, 8]).extinction(0.5).heat_source(5000.0);
    let scene = Scene::builder().surfaces(walls).patch_size(0.5).medium(gas).build()?;

    let solution = Solver::new(&scene)
        .tolerance(1e-3)
        .memory_limit(Bytes::gib(8))
        .checkpoint("run.checkpoint")
        .observer(&progress)
        .solve()?;

    for row in solution.surfaces() {
        let error = row.total_error().unwrap_or(f64::INFINITY);
        println!("{} {} ± {error} W", row.name, row.net_power);
    }
    let bottom = solution.surface("z0").unwrap();
    println!("{} W/m², error of the exchange alone {} W", bottom.net_flux(), bottom.exchange_error);
    assert!(bottom.total_error().is_some_and(|e| e > bottom.exchange_error && e < 0.05 * bottom.net_power));
    Ok(())
}

#[test]
fn blocks_of_the_tutorial_run() {
    let folder = std::env::temp_dir().join(format!("zonal-pages-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::env::set_current_dir(&folder).unwrap();
    blocks_of_the_tutorial().unwrap();
    assert!(!folder.join("run.checkpoint").exists());
    std::env::set_current_dir(std::env::temp_dir()).unwrap();
    std::fs::remove_dir_all(folder).unwrap();
}
