//! Tubes against the closed form of a diffuse line and the path tracer.

use crate::common;

use common::solved;
use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_reference::path_tracer::{Detector, PathTracer, TracingAccuracy};
use zonal_scene::Band;

const HEIGHT: f64 = 1.5;
const LENGTH: f64 = 1.2;
const POWER: f64 = 36.0;

/// Irradiance of a level floor by a diffuse line along x at [`HEIGHT`]: with d the distance from the axis and l along it, Φ/(π² L) (h/d) [½ l/(l² + d²) + ½ atan(l/d)/d].
fn line_irradiance(x: Vec3) -> f64 {
    let d = x.y.hypot(HEIGHT);
    let primitive = |l: f64| 0.5 * (l / (l * l + d * d) + (l / d).atan() / d);
    let both = primitive(0.5 * LENGTH - x.x) - primitive(-0.5 * LENGTH - x.x);
    POWER / (PI * PI * LENGTH) * HEIGHT / d * both
}

fn tube(radius: f64) -> String {
    let half = 0.5 * LENGTH;
    format!(
        "[[light]]\nkind = \"tube\"\nname = \"lamp\"\nstart = [{}, 0, {HEIGHT}]\nend = [{half}, 0, {HEIGHT}]\nradius = {radius}\npower = {POWER}\nreflectance = 0\n",
        -half
    )
}

#[test]
fn a_thin_tube_has_the_light_of_a_diffuse_line() {
    for engine in ["dense", "rays"] {
        let s = solved(&format!(
            "[solve]\ntolerance = 0.005\npatch_size = 0.5\nengine = \"{engine}\"\n[[surface]]\nname = \"floor\"\nreflectance = 0\n\
             rectangle = {{ origin = [-2, -2, 0], edge1 = [4, 0, 0], edge2 = [0, 4, 0] }}\n{}",
            tube(0.008)
        ));
        let mut worst = 0.0f64;
        for (i, p) in s.zones.patches.iter().enumerate().filter(|(_, p)| p.surface == 0) {
            let n = 20;
            let at = |k: usize| (k as f64 + 0.5) / n as f64;
            let exact = (0..n * n).map(|k| line_irradiance(p.plate.at(at(k % n), at(k / n)))).sum::<f64>()
                / (n * n) as f64;
            let found = (s.fields.incident[i] + s.fields.direct_light(i)).first();
            worst = worst.max((found / exact - 1.0).abs());
        }
        let emitted = s.report.energy.emitted.first();
        println!("{engine}: largest relative difference {worst:.1e}, emitted {emitted}");
        assert!(worst < 0.012, "{engine}: {worst}");
        assert!((emitted / POWER - 1.0).abs() < 1e-6, "{emitted}");
    }
}

#[test]
fn light_of_a_thick_tube_agrees_with_the_path_tracer() {
    let s = solved(&format!(
        "[solve]\ntolerance = 0.01\npatch_size = 0.5\nengine = \"rays\"\n[[surface]]\nname = \"room\"\nroom = {{ min = [-1, -1, 0], max = [1, 1, 2] }}\n\
         reflectance = 0.5\n[[surface]]\nname = \"block\"\nbox = {{ min = [-0.3, 0.2, 0.4], max = [0.4, 0.6, 0.7] }}\n{}",
        tube(0.1)
    ));
    let list: Vec<usize> =
        (0..s.zones.patches.len()).filter(|i| s.zones.patches[*i].surface < 7).step_by(5).collect();
    let detectors: Vec<Detector> = list.iter().map(|&i| Detector::patch(&s.zones.patches[i])).collect();
    let accuracy = TracingAccuracy { relative: 0.01, max_paths: 1 << 15, ..TracingAccuracy::default() };
    let readings = PathTracer::new(&s.scene).measure(&detectors, &accuracy, 7);
    let (mut off, mut level) = (0.0, 0.0);
    for (&i, reading) in list.iter().zip(&readings) {
        let exact = reading.total[Band::first()].value;
        let found = (s.fields.incident[i] + s.fields.direct_light(i)).first();
        (off, level) = (off + (found - exact).powi(2), level + exact * exact);
    }
    let relative = f64::sqrt(off / level);
    println!("{} readings: root mean square difference {relative:.1e}", list.len());
    assert!(list.len() > 15 && relative < 0.025, "{relative}");
}
