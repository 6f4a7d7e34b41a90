//! The judge against Monte Carlo tables and pictures of Mitsuba that others made; a short cut of what the example `judge` runs.

use std::path::{Path, PathBuf};
use zonal_reference::judge::{Accuracy, Judge, Receiver};
use zonal_reference::{Estimate, World, radiance};
use zonal_scene::Scene;

#[allow(dead_code)]
#[path = "../../zonal/examples/judge/scenes.rs"]
mod scenes;
use scenes::{BOXES, CUBES, Score, blocks, cornell, receiver, sponza};

/// Wider than this a mean of a few dozen squares of z is no chance.
const WIDE: f64 = 1.45;
/// Farther than this a z is no chance.
const FAR: f64 = 5.0;
/// Pixels along the edge of a block, which is one pixel of ours.
const BLOCK: usize = 8;

fn shared(path: &str) -> Option<PathBuf> {
    let p = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared").join(path);
    if !p.exists() {
        println!("skipped: {} is missing", p.display());
    }
    p.exists().then_some(p)
}

fn stands(what: &str, s: &Score) {
    println!("{what}: {s:.3?}");
    assert!(s.n >= 14 && s.rms < WIDE && s.rms > 0.6 && s.max < FAR && s.mean.abs() < 0.6, "{what}: {s:?}");
}

#[test]
fn cubes() {
    let Some(folder) = shared("reference/montecarlo") else { return };
    let accuracy = Accuracy { relative: 0.02, ..Accuracy::default() };
    for c in &CUBES {
        let scene = c.read(&folder).unwrap();
        let judge = Judge::new(&scene);
        for (quantity, step) in [("H", 19), ("G", 37), ("Hocc", 5)] {
            if quantity == "Hocc" && !c.block {
                continue;
            }
            let theirs = c.table(&folder, &format!("{quantity}_exp")).unwrap();
            let errors = c.table(&folder, &format!("{quantity}_exp_se")).unwrap();
            let entries: Vec<usize> = (0..theirs.len()).step_by(step).filter(|&k| errors[k] > 0.0).collect();
            let receivers: Vec<Receiver> = entries.iter().map(|&k| receiver(quantity, k)).collect();
            let ours = judge.measure(&receivers, &accuracy, 5);
            let pairs = entries.iter().zip(&ours);
            let score = Score::new(
                pairs.map(|(&k, r)| (r.total[0], Estimate { value: theirs[k], error: errors[k] })),
            );
            stands(&format!("{} {quantity}", c.name), &score);
        }
    }
}

#[test]
fn pictures_inside_cubes() {
    let Some(folder) = shared("reference/montecarlo") else { return };
    for c in [&CUBES[0], &CUBES[4]] {
        let scene = c.read(&folder).unwrap();
        let file = folder.join(format!("image_{}_inside_64.npz", c.file));
        let (shape, theirs) = zonal_io::output::read_array(&file, "img").unwrap();
        let errors = zonal_io::output::read_array(&file, "se").unwrap().1;
        let theirs = blocks(&theirs, &errors, shape[1], BLOCK);
        compare(c.name, &scene, [shape[1] / BLOCK, shape[0] / BLOCK], 4096, 0, 0, theirs);
    }
}

/// Our picture in blocks' resolution against their blocks, from block row `first` down.
fn compare(
    name: &str,
    scene: &Scene,
    size: [usize; 2],
    samples: usize,
    band: usize,
    first: usize,
    theirs: Vec<Estimate>,
) {
    let ours = Judge::new(scene).picture(&scene.cameras()[0], size[0], size[1], samples, 3);
    let ours = ours.mean.iter().zip(&ours.error).map(|(m, e)| Estimate { value: m[band], error: e[band] });
    stands(name, &Score::new(ours.zip(theirs).skip(first * size[0])));
}

fn mitsuba(name: &str, scene: &Scene, samples: usize, band: usize, first: usize) {
    let Some(folder) = shared("data/mitsuba-refs") else { return };
    let read = |end: &str| zonal_io::output::read_exr(&folder.join(format!("{name}{end}.exr"))).unwrap();
    let (mean, error) = (read(""), read("_stderr"));
    let of =
        |p: &zonal_io::output::Picture| -> Vec<f64> { p.pixels.iter().map(|x| f64::from(x[band])).collect() };
    let theirs = blocks(&of(&mean), &of(&error), mean.width, BLOCK);
    compare(name, scene, [mean.width / BLOCK, mean.height / BLOCK], samples, band, first, theirs);
}

#[test]
fn cornell_boxes_of_mitsuba() {
    let Some(data) = shared("data") else { return };
    for (k, name) in BOXES.iter().enumerate() {
        let scene = cornell(name, &data).unwrap();
        // The upper rows of the smoke: see the test below.
        let first = if *name == "cbox_smoke" { scenes::SMOKE_ROWS / BLOCK } else { 0 };
        mitsuba(name, &scene, 1024, k % 3, first);
    }
}

#[test]
fn sponza_of_mitsuba() {
    let Some(data) = shared("data") else { return };
    mitsuba("sponza_haze_st0.02_a09", &sponza(&data).unwrap(), 512, 0, 0);
}

#[test]
fn no_shadow_falls_under_the_ceiling_of_the_smoky_box() {
    let Some(data) = shared("data") else { return };
    let scene = cornell("cbox_smoke", &data).unwrap();
    let corner = zonal_math::vec3(180.0, 503.0, 559.2);
    let edges = (zonal_math::vec3(0.0, 10.0, 0.0), zonal_math::vec3(60.0, 0.0, 0.0));
    let plate = zonal_scene::Plate::parallelogram(corner, edges.0, edges.1);
    assert!(plate.normal().z < -0.99);
    let ours = Judge::new(&scene).one(&Receiver::Patch { plate, normal: plate.normal() }, 20_000, 1).total[0];
    let theirs = radiance::irradiance(&World::new(&scene), &plate, 0, 40_000, 2);
    println!("{ours:?} {theirs:?}");
    assert!((ours.value - theirs.value).abs() < 4.0 * ours.error.hypot(theirs.error), "{ours:?} {theirs:?}");
    assert!(theirs.error < 0.1 * theirs.value, "{theirs:?}");
}
