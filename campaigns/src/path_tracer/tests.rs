//! A reduced run of the cases.

use super::PathTracerOptions;
use super::scenes::cornell;
use crate::scenes::cornell::BoxMedium;
use clap::Parser;
use std::path::{Path, PathBuf};
use zonal_math::vec3;
use zonal_reference::path_tracer::{Detector, PathTracer};
use zonal_reference::test_cases::run_all_cases;
use zonal_reference::{BruteForceScene, radiance};
use zonal_scene::{Band, Plate};

fn shared() -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    let present = path.join("data").exists() && path.join("reference").exists();
    if !present {
        println!("skipped: {} is missing", path.display());
    }
    present.then_some(path)
}

#[derive(clap::Parser)]
struct CommandLine {
    #[command(flatten)]
    options: PathTracerOptions,
}

#[test]
fn readings_match_tables_and_pictures() {
    let Some(shared) = shared() else { return };
    let mut words = vec!["path-tracer", "--quick", "--error", "0.02", "--samples", "16", "--shared"];
    words.push(shared.to_str().unwrap());
    if !run_all_cases() {
        let cases = "c0,c9,image_c0,image_c8,cbox_vacuum,cbox_homog_st0.001_argb,sponza_haze_st0.02_a09";
        words.extend(["--cases", cases]);
    }
    assert!(CommandLine::parse_from(words).options.run().unwrap());
}

#[test]
fn smoky_box_has_no_shadow_under_its_ceiling() {
    let Some(shared) = shared() else { return };
    let scene = cornell("cbox_smoke", BoxMedium::Smoke, &shared.join("data")).unwrap();
    let corner = vec3(180.0, 503.0, 559.2);
    let plate = Plate::parallelogram(corner, vec3(0.0, 10.0, 0.0), vec3(60.0, 0.0, 0.0));
    assert!(plate.normal().z < -0.99);
    let ours = PathTracer::new(&scene)
        .measure_one(&Detector::Patch { plate, normal: plate.normal() }, 20_000, 1)
        .total[Band::first()];
    let theirs = radiance::irradiance(&BruteForceScene::new(&scene), &plate, Band::first(), 40_000, 2);
    println!("{ours:?} {theirs:?}");
    assert!((ours.value - theirs.value).abs() < 4.0 * ours.error.hypot(theirs.error), "{ours:?} {theirs:?}");
    assert!(theirs.error < 0.1 * theirs.value, "{theirs:?}");
}
