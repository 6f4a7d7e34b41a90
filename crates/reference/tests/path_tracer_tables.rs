//! The path tracer against independent Monte Carlo tables and Mitsuba pictures: a reduced run of the example `path_tracer`.

use std::path::{Path, PathBuf};
use zonal_reference::path_tracer::{Detector, PathTracer, TracingAccuracy};
use zonal_reference::test_cases::sampled_cases;
use zonal_reference::{BruteForceScene, SampleEstimate, radiance};
use zonal_scene::{Band, Scene};

#[allow(dead_code)]
#[path = "../../validation/examples/path_tracer/scenes.rs"]
mod scenes;
use scenes::{CORNELL_CASES, CUBES, ZScores, blocks, cornell, receiver, sponza};

/// Largest root mean square of a few dozen z scores.
const MAX_RMS_Z_SCORE: f64 = 1.45;
/// Largest |z| of a comparison.
const MAX_Z_SCORE: f64 = 5.0;
/// Pixels of the reference along the edge of a block, which is one traced pixel.
const PIXELS_PER_BLOCK: usize = 8;

fn shared_file(path: &str) -> Option<PathBuf> {
    let p = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared").join(path);
    if !p.exists() {
        println!("skipped: {} is missing", p.display());
    }
    p.exists().then_some(p)
}

fn assert_consistent(what: &str, s: &ZScores) {
    println!("{what}: {s:.3?}");
    assert!(
        s.n >= 14 && s.rms < MAX_RMS_Z_SCORE && s.rms > 0.6 && s.max < MAX_Z_SCORE && s.mean.abs() < 0.6,
        "{what}: {s:?}"
    );
}

#[test]
fn readings_match_tables_of_cubes() {
    let Some(folder) = shared_file("reference/montecarlo") else { return };
    let accuracy = TracingAccuracy { relative: 0.02, ..TracingAccuracy::default() };
    for c in sampled_cases(&CUBES, &[0, 5]) {
        let scene = c.read(&folder).unwrap();
        let tracer = PathTracer::new(&scene);
        for (quantity, step) in [("H", 19), ("G", 37), ("Hocc", 5)] {
            if quantity == "Hocc" && !c.block {
                continue;
            }
            let theirs = c.table(&folder, &format!("{quantity}_exp")).unwrap();
            let errors = c.table(&folder, &format!("{quantity}_exp_se")).unwrap();
            let entries: Vec<usize> = (0..theirs.len()).step_by(step).filter(|&k| errors[k] > 0.0).collect();
            let receivers: Vec<Detector> = entries.iter().map(|&k| receiver(quantity, k)).collect();
            let ours = tracer.measure(&receivers, &accuracy, 5);
            let pairs = entries.iter().zip(&ours);
            let score = ZScores::new(pairs.map(|(&k, r)| {
                (r.total[Band::first()], SampleEstimate { value: theirs[k], error: errors[k] })
            }));
            assert_consistent(&format!("{} {quantity}", c.name), &score);
        }
    }
}

#[test]
fn pictures_inside_cubes_match_references() {
    let Some(folder) = shared_file("reference/montecarlo") else { return };
    for c in [&CUBES[0], &CUBES[4]] {
        let scene = c.read(&folder).unwrap();
        let file = folder.join(format!("image_{}_inside_64.npz", c.file));
        let (shape, theirs) = zonal_io::output::read_array(&file, "img").unwrap();
        let errors = zonal_io::output::read_array(&file, "se").unwrap().1;
        let theirs = blocks(&theirs, &errors, shape[1], PIXELS_PER_BLOCK);
        let size = [shape[1] / PIXELS_PER_BLOCK, shape[0] / PIXELS_PER_BLOCK];
        compare(
            c.name,
            &scene,
            PictureSetup { size, samples: 4096, band: Band::first(), first_row: 0 },
            theirs,
        );
    }
}

/// Compares the traced picture, one pixel per block, with the blocks of the reference from block row `first_row` down.
fn compare(name: &str, scene: &Scene, setup: PictureSetup, theirs: Vec<SampleEstimate>) {
    let PictureSetup { size, samples, band, first_row } = setup;
    let ours = PathTracer::new(scene).picture(&scene.cameras()[0], size[0], size[1], samples, 3);
    let ours =
        ours.mean.iter().zip(&ours.error).map(|(m, e)| SampleEstimate { value: m[band], error: e[band] });
    assert_consistent(name, &ZScores::new(ours.zip(theirs).skip(first_row * size[0])));
}

/// A picture to trace, and the block row from which it is compared.
struct PictureSetup {
    size: [usize; 2],
    samples: usize,
    band: Band,
    first_row: usize,
}

/// Compares one band of a traced picture with a Mitsuba picture from block row `first_row` down.
fn compare_with_mitsuba(name: &str, scene: &Scene, samples: usize, band: Band, first_row: usize) {
    let Some(folder) = shared_file("data/mitsuba-refs") else { return };
    let read = |end: &str| zonal_io::output::read_exr(&folder.join(format!("{name}{end}.exr"))).unwrap();
    let (mean, error) = (read(""), read("_stderr"));
    let of = |p: &zonal_io::output::RgbImage| -> Vec<f64> {
        p.pixels.iter().map(|x| f64::from(x[band.index()])).collect()
    };
    let theirs = blocks(&of(&mean), &of(&error), mean.width, PIXELS_PER_BLOCK);
    let size = [mean.width / PIXELS_PER_BLOCK, mean.height / PIXELS_PER_BLOCK];
    compare(name, scene, PictureSetup { size, samples, band, first_row }, theirs);
}

#[test]
fn cornell_boxes_match_mitsuba() {
    let Some(data) = shared_file("data") else { return };
    let cases = CORNELL_CASES.iter().zip(Band::all().cycle());
    for (name, band) in sampled_cases(cases, &[0, 2]) {
        let scene = cornell(name, &data).unwrap();
        // The upper rows of the smoke are compared in the test of its ceiling.
        let first_row = if *name == "cbox_smoke" { scenes::SMOKE_ROWS / PIXELS_PER_BLOCK } else { 0 };
        compare_with_mitsuba(name, &scene, 1024, band, first_row);
    }
}

#[test]
fn sponza_matches_mitsuba() {
    let Some(data) = shared_file("data") else { return };
    compare_with_mitsuba("sponza_haze_st0.02_a09", &sponza(&data).unwrap(), 512, Band::first(), 0);
}

#[test]
fn smoky_box_has_no_shadow_under_its_ceiling() {
    let Some(data) = shared_file("data") else { return };
    let scene = cornell("cbox_smoke", &data).unwrap();
    let corner = zonal_math::vec3(180.0, 503.0, 559.2);
    let edges = (zonal_math::vec3(0.0, 10.0, 0.0), zonal_math::vec3(60.0, 0.0, 0.0));
    let plate = zonal_scene::Plate::parallelogram(corner, edges.0, edges.1);
    assert!(plate.normal().z < -0.99);
    let ours = PathTracer::new(&scene)
        .measure_one(&Detector::Patch { plate, normal: plate.normal() }, 20_000, 1)
        .total[Band::first()];
    let theirs = radiance::irradiance(&BruteForceScene::new(&scene), &plate, Band::first(), 40_000, 2);
    println!("{ours:?} {theirs:?}");
    assert!((ours.value - theirs.value).abs() < 4.0 * ours.error.hypot(theirs.error), "{ours:?} {theirs:?}");
    assert!(theirs.error < 0.1 * theirs.value, "{theirs:?}");
}
