//! Skies whose radiance varies against quadratures, the path tracer and the balance of power.

use crate::common;

use common::{read, solve, solved};
use std::f64::consts::{PI, TAU};
use zonal_math::{Vec3, vec3};
use zonal_reference::path_tracer::{Detector, PathTracer, TracingAccuracy};
use zonal_scene::{Band, Bands, Light, Scene, SkyDistribution, Solution, Texture};

/// Three walls in the open, black on both sides: one level, one upright, one inclined.
const PLATES: &str = "[solve]\ntolerance = 0.004\npatch_size = 1\n[[surface]]\nname = \"level\"\n\
    rectangle = { origin = [0, 0, 0], edge1 = [1, 0, 0], edge2 = [0, 1, 0] }\nreflectance = 0\n[[surface]]\nname = \"upright\"\n\
    rectangle = { origin = [0, 0, -50], edge1 = [0, 0, 1], edge2 = [1, 0, 0] }\nreflectance = 0\n[[surface]]\nname = \"inclined\"\n\
    rectangle = { origin = [0, 0, -99], edge1 = [1, 0, 1], edge2 = [0, 1, 0.2] }\nreflectance = 0\n";
const PEREZ: &str = "[[light]]\nkind = \"perez-sky\"\nname = \"sky\"\ndirect_normal = 700\ndiffuse_horizontal = 110\n\
    latitude = 48.1\nlongitude = 11.6\ntime = 2026-03-21T09:30:00+01:00\nground_reflectance = 0.2\n";

fn cie(kind: usize) -> String {
    format!(
        "[[light]]\nkind = \"cie-sky\"\nname = \"sky\"\ntype = {kind}\nhorizontal_irradiance = 100\ndirection = [-0.5, 0.9, -0.8]\n"
    )
}

/// The irradiance of a plane of normal `n` by the sky of a scene, W/m², by midpoints in the height and the turn.
fn irradiance(sky: &Light, n: Vec3) -> f64 {
    let Light::Sky { radiance, distribution, .. } = sky else { panic!("{sky:?}") };
    let (rows, columns) = (400, 400);
    let mut sum = 0.0;
    for i in 0..rows {
        let z: f64 = 1.0 - (2.0 * i as f64 + 1.0) / rows as f64;
        let across = (1.0 - z * z).sqrt();
        for j in 0..columns {
            let turn = TAU * (j as f64 + 0.5) / columns as f64;
            let d = vec3(across * turn.cos(), across * turn.sin(), z);
            sum += distribution.relative(d).first() * n.dot(d).max(0.0);
        }
    }
    radiance.first() * sum * 4.0 * PI / (rows * columns) as f64
}

#[test]
fn open_plates_receive_the_irradiance_of_the_sky() {
    for text in [cie(1), cie(8), cie(13), cie(15), PEREZ.to_string()] {
        let s = solved(&format!("{PLATES}{text}"));
        for (i, p) in s.zones.patches.iter().enumerate() {
            let exact = irradiance(&s.scene.lights()[0], p.normal);
            let (found, stated) = (s.fields.direct_light(i).first(), s.fields.direct_error[i].first());
            let name = &s.scene.surfaces()[p.surface].name;
            println!("{name}: {found} ± {stated}, exact {exact}");
            assert!(
                (found - exact).abs() < 2.0 * stated + 3e-3 * exact && stated < 0.02 * exact,
                "{name} {text}"
            );
            if name == "level" {
                let given = if text == PEREZ { 110.0 } else { 100.0 };
                assert!((exact / given - 1.0).abs() < 2e-3, "{exact}");
            }
        }
    }
}

/// A room of 2 m without a ceiling, with a block, and the sky of the scene replaced if one is given.
fn court(rest: &str, sky: Option<SkyDistribution>) -> Solution {
    let text = format!(
        "[solve]\ntolerance = 0.01\npatch_size = 0.5\n[[surface]]\nname = \"room\"\nroom = {{ min = [0, 0, 0], max = [2, 2, 2] }}\n\
         omit = [\"z1\"]\nreflectance = [0.5, 0.2, 0]\n[[surface]]\nname = \"block\"\nbox = {{ min = [0.5, 0.8, 0], max = [0.9, 1.3, 0.6], rotate_z_degrees = 30 }}\n{rest}"
    );
    let Some(distribution) = sky else { return solved(&text) };
    let mut parts = read(&text).into_parts();
    parts.lights = vec![Light::Sky { name: "sky".into(), radiance: Bands::splat(10.0), distribution }];
    solve(Scene::new(parts).unwrap())
}

const HAZE: &str = "[medium]\nmin = [0, 0, 0]\nmax = [2, 2, 2]\ncells = [4, 4, 4]\nextinction = [0.3, 0.6, 0]\nalbedo = 0.5\n";

/// A picture with a bright and a red region.
fn picture() -> SkyDistribution {
    let (w, h) = (32, 16);
    let pixel = |k: usize| match (k % w, k / w) {
        (5..8, 2..4) => [20.0, 18.0, 15.0],
        (20..28, 3..8) => [3.0, 0.5, 0.2],
        (_, 8..) => [0.1; 3],
        _ => [0.4, 0.6, 1.0],
    };
    let picture = Texture { width: w, height: h, pixels: (0..w * h).map(pixel).collect() };
    SkyDistribution::picture(picture, vec3(0.0, 0.1, 1.0), 0.4).unwrap()
}

fn assert_agrees_with_paths(s: &Solution, name: &str) {
    let tracer = PathTracer::new(&s.scene).with_max_bounces(0);
    let list: Vec<usize> = (0..s.zones.pane_offset()).step_by(7).collect();
    let detector = |i: &usize| match s.zones.patches.get(*i) {
        Some(p) => Detector::patch(p),
        None => {
            let grid = s.scene.voxel_grid().unwrap();
            Detector::voxel(s.zones.voxels.at(i - s.zones.voxel_offset()), grid)
        }
    };
    let detectors: Vec<Detector> = list.iter().map(detector).collect();
    let accuracy = TracingAccuracy { relative: 0.01, max_paths: 1 << 15, ..TracingAccuracy::default() };
    let readings = tracer.measure(&detectors, &accuracy, 5);
    let (mut off, mut level, mut beyond) = (0.0, 0.0, 0);
    for (&i, reading) in list.iter().zip(&readings) {
        for b in Band::all() {
            let (total, rest) = (reading.total[b], reading.incident[b]);
            let exact = total.value - rest.value;
            let error = total.error.hypot(rest.error);
            let (found, stated) = (s.fields.direct_light(i)[b], s.fields.direct_error[i][b]);
            (off, level) = (off + (found - exact).powi(2), level + exact * exact);
            beyond += usize::from((found - exact).abs() > 2.0 * stated + 4.0 * error + 1e-9);
        }
    }
    let relative = (off / level).sqrt();
    println!(
        "{name}: {} readings, root mean square difference {relative:.1e}, {beyond} beyond",
        3 * list.len()
    );
    assert!(relative < 0.025 && beyond <= 3 * list.len() / 20, "{name} {relative} {beyond}");
}

#[test]
fn direct_light_of_skies_agrees_with_the_path_tracer() {
    assert_agrees_with_paths(&court(&cie(12), None), "clear sky");
    assert_agrees_with_paths(&court(&format!("{HAZE}{PEREZ}"), None), "Perez sky in haze");
    let own = court(&format!("{HAZE}{}", cie(1)), Some(picture()));
    assert_agrees_with_paths(&own, "picture in haze");
    // Energy: what enters is absorbed or leaves.
    let e = &own.report.energy;
    assert!(e.incoming.all(|x| x > 0.0) && (e.residual / e.incoming).abs().all(|x| x < 0.02), "{e:?}");
}

#[test]
fn a_picture_of_one_value_is_the_uniform_sky() {
    let flat = Texture { width: 32, height: 16, pixels: vec![[1.0; 3]; 512] };
    let flat = SkyDistribution::picture(flat, vec3(0.3, 0.0, 1.0), 0.0).unwrap();
    let [a, b] = [flat, SkyDistribution::uniform()].map(|sky| court(&cie(1), Some(sky)));
    for i in 0..a.zones.len() {
        let [(x, dx), (y, dy)] = [&a, &b].map(|s| {
            (
                (s.fields.incident[i] + s.fields.direct_light(i)).first(),
                s.fields.error[i].first() + s.fields.direct_error[i].first(),
            )
        });
        assert!((x - y).abs() < 2.0 * (dx + dy) + 0.004 * y, "{x} ± {dx}, {y} ± {dy}");
    }
    let [x, y] = [&a, &b].map(|s| s.report.energy.incoming.first());
    assert!((x / y - 1.0).abs() < 0.01, "{x} {y}");
}
