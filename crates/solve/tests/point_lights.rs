//! Point lights against closed forms, the path tracer and the balance of power.

use crate::common;

use common::solved;
use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_reference::path_tracer::{Detector, PathTracer, TracingAccuracy};
use zonal_scene::{Bands, Patch, Photometry, Solution};

const SPOT: &str = "[[light]]\nkind = \"spot\"\nposition = [1.1, 0.6, 1.8]\ndirection = [-0.2, 0.4, -1]\ninner_angle = 20\n\
    outer_angle = 35\nintensity = [30, 20, 10]\n";

/// The midpoint rule over a parallelogram patch.
fn mean_over(patch: &Patch, f: impl Fn(Vec3) -> f64) -> f64 {
    let n = 60;
    let at = |k: usize| (k as f64 + 0.5) / n as f64;
    (0..n * n).map(|k| f(patch.plate.at(at(k % n), at(k / n)))).sum::<f64>() / (n * n) as f64
}

fn floor(rest: &str) -> Solution {
    solved(&format!(
        "[solve]\ntolerance = 0.003\npatch_size = 0.5\n[[surface]]\nname = \"floor\"\n\
         rectangle = {{ origin = [-2, -2, 0], edge1 = [4, 0, 0], edge2 = [0, 4, 0] }}\nreflectance = 0\n{rest}"
    ))
}

#[test]
fn a_floor_receives_the_intensity_times_cos_cubed_over_the_squared_height() {
    let (h, i0) = (1.5, 100.0);
    let lamp = format!("[[light]]\nkind = \"point\"\nposition = [0.2, 0.1, {h}]\nintensity = {i0}\n");
    let fog =
        "[medium]\nmin = [-2, -2, 0]\nmax = [2, 2, 2]\ncells = [4, 4, 2]\nextinction = 0.7\nalbedo = 0\n";
    for (rest, kappa, most) in [(lamp.clone(), 0.0, 2e-4), (lamp + fog, 0.7, 2e-3)] {
        let s = floor(&rest);
        let mut worst = 0.0f64;
        for (i, p) in s.zones.patches.iter().enumerate() {
            let exact = mean_over(p, |x| {
                let r = (x - Vec3::from_array([0.2, 0.1, h])).length();
                i0 * (h / r).powi(3) / (h * h) * (-kappa * r).exp()
            });
            let found = s.fields.direct_light(i).first();
            worst = worst.max((found / exact - 1.0).abs());
            let stated = s.fields.direct_error[i].first() + 1e-5 * exact;
            assert!((found - exact).abs() < 2.0 * stated, "{kappa}: {found} ± {stated}, {exact}");
        }
        println!("extinction {kappa}: largest relative difference {worst:.1e}");
        assert!(worst < most, "{kappa}: {worst}");
        let e = &s.report.energy;
        assert!((e.emitted.first() / (4.0 * PI * i0) - 1.0).abs() < 1e-9, "{}", e.emitted.first());
        // Without normalization shadow rays and rays from the light are independent.
        assert!(e.residual.first().abs() < 1e-3, "{}", e.residual.first());
    }
}

/// ∫ dV/r² over the box of half-edges a, b, c about the light, by Gauss's theorem: ∇·(x/r²) = 1/r².
fn box_about_light(half: [f64; 3]) -> f64 {
    let n = 400;
    let at = |k: usize, edge: f64| edge * (2.0 * (k as f64 + 0.5) / n as f64 - 1.0);
    (0..3)
        .map(|k| {
            let (h, a, b) = (half[k], half[(k + 1) % 3], half[(k + 2) % 3]);
            let cell = 4.0 * a * b / (n * n) as f64;
            let one = |i: usize| cell * h / (h * h + at(i % n, a).powi(2) + at(i / n, b).powi(2));
            2.0 * (0..n * n).map(one).sum::<f64>()
        })
        .sum()
}

// Guards (numbers): a voxel that holds a point light has the mean of its unbounded fluence.
#[test]
fn a_voxel_that_holds_or_touches_the_light_has_its_mean_fluence() {
    // The light in the middle of the middle cell, on a corner of eight cells, and in the middle of a face.
    for (position, cells, halves) in [
        ([0.0, 0.0, 0.0], [3, 3, 3], vec![([1, 1, 1], [0.5, 0.5, 0.5], 1.0)]),
        ([0.0, 0.0, 0.0], [2, 2, 2], vec![([0, 1, 0], [1.0, 1.0, 1.0], 0.125)]),
        (
            [0.5, 0.0, 0.0],
            [3, 3, 3],
            vec![([1, 1, 1], [1.0, 0.5, 0.5], 0.5), ([2, 1, 1], [1.0, 0.5, 0.5], 0.5)],
        ),
    ] {
        let size = cells.map(|n: usize| if n == 3 { 1.5 } else { 1.0 });
        let text = format!(
            "[solve]\ntolerance = 0.01\n[medium]\nmin = {:?}\nmax = {size:?}\ncells = {cells:?}\nextinction = 1e-6\n\
             [[light]]\nkind = \"point\"\nposition = {position:?}\nintensity = 10\n",
            size.map(|x: f64| -x)
        );
        let s = solved(&text);
        let grid = s.scene.voxel_grid().unwrap();
        for (cell, half, share) in halves {
            let i = s.zones.voxel_zones_of_cell(grid.index(cell)).next().unwrap() + s.zones.voxel_offset();
            let exact = 10.0 * share * box_about_light(half) / grid.cell().product();
            let (found, error) = (s.fields.direct_light(i).first(), s.fields.direct_error[i].first());
            println!("{position:?} {cell:?}: {found} ± {error}, exact {exact}");
            assert!(
                (found - exact).abs() < 2.0 * error && error < 0.02 * exact,
                "{found} ± {error}, {exact}"
            );
        }
    }
}

// Guards (numbers): rooms lit by a point light have the power of the light to rounding.
/// A closed room of 4 m with a light of 10,000 lm in the middle: the mean illuminance is Φ/(A (1 − ρ)).
#[test]
fn mean_illuminance_of_an_integrating_cube_is_exact() {
    let lamps = [
        format!("kind = \"point\"\nposition = [2, 2, 2]\npower = {}\n", 10_000.0 / 683.0),
        format!(
            "kind = \"spot\"\nposition = [1.2, 2.3, 3.1]\ndirection = [0.3, 0, -1]\ninner_angle = 10\nouter_angle = 30\npower = {}\n",
            10_000.0 / 683.0
        ),
    ];
    for lamp in lamps {
        for (rho, engine) in [(0.0, "dense"), (0.5, "dense"), (0.5, "rays"), (0.9, "dense")] {
            let s = solved(&format!(
                "[solve]\npatch_size = 0.5\nresidual = 1e-10\nclosure = \"restore\"\nengine = \"{engine}\"\n[[surface]]\nname = \"room\"\n\
                 room = {{ min = [0, 0, 0], max = [4, 4, 4] }}\nreflectance = {rho}\n[[light]]\n{lamp}"
            ));
            let power: f64 = (s.zones.patches.iter().enumerate())
                .map(|(i, p)| p.area * (s.fields.incident[i] + s.fields.direct_light(i)).first())
                .sum();
            let (found, exact) = (683.0 * power / 96.0, 10_000.0 / 96.0 / (1.0 - rho));
            println!("reflectance {rho}, {engine}: {found} lx, exact {exact} lx");
            assert!((found / exact - 1.0).abs() < 1e-6, "{rho} {engine}: {found} {exact}");
            let rows = Photometry::new(&s, 683.0).unwrap().surfaces();
            let flux: f64 = rows.iter().map(|r| r.flux()).sum();
            assert!(rows.len() == 6 && (flux / 96.0 / exact - 1.0).abs() < 1e-6, "{flux}");
            assert!(
                rows.iter().all(|r| r.range[0] <= r.mean && r.mean <= r.range[1] && r.uniformity() <= 1.0)
            );
            let e = &s.report.energy;
            assert!((683.0 * e.emitted.first() / 10_000.0 - 1.0).abs() < 1e-9);
            assert!(e.residual.first().abs() < 1e-6 && e.incoming == Bands::ZERO, "{}", e.residual.first());
        }
    }
}

/// Direct light of a spot in haze behind a pane and beside a block, against the path tracer.
#[test]
fn direct_light_agrees_with_the_path_tracer() {
    let text = format!(
        "[solve]\ntolerance = 0.01\npatch_size = 0.5\n[[surface]]\nname = \"room\"\nroom = {{ min = [0, 0, 0], max = [2, 2, 2] }}\n\
         reflectance = [0.5, 0.2, 0]\n[[surface]]\nname = \"block\"\nbox = {{ min = [0.5, 0.8, 0], max = [0.9, 1.3, 0.6], rotate_z_degrees = 30 }}\n\
         [[pane]]\npolygon = [[0.1, 0.1, 1.4], [1.2, 0.1, 1.4], [1.2, 1.8, 1.4], [0.1, 1.8, 1.4]]\nthickness = 0.01\nextinction = [20, 40, 80]\n\
         [medium]\nmin = [0, 0, 0]\nmax = [2, 2, 2]\ncells = [4, 4, 4]\nextinction = [0.3, 0.6, 0]\nalbedo = 0.5\n{SPOT}"
    );
    let s = solved(&text);
    let tracer = PathTracer::new(&s.scene).with_max_bounces(0);
    let list: Vec<usize> = (0..s.zones.pane_offset()).step_by(7).collect();
    let detectors: Vec<Detector> = list
        .iter()
        .map(|&i| match s.zones.patches.get(i) {
            Some(p) => Detector::patch(p),
            None => {
                let grid = s.scene.voxel_grid().unwrap();
                Detector::voxel(s.zones.voxels.at(i - s.zones.voxel_offset()), grid)
            }
        })
        .collect();
    let accuracy = TracingAccuracy { relative: 0.004, max_paths: 1 << 18, ..TracingAccuracy::default() };
    let readings = tracer.measure(&detectors, &accuracy, 5);
    let (mut lit, mut off, mut level, mut beyond) = (0, 0.0, 0.0, 0);
    for (&i, reading) in list.iter().zip(&readings) {
        for b in zonal_scene::Band::all() {
            let (total, rest) = (reading.total[b], reading.incident[b]);
            let exact = total.value - rest.value;
            let error = total.error.hypot(rest.error);
            let (found, stated) = (s.fields.direct_light(i)[b], s.fields.direct_error[i][b]);
            lit += usize::from(exact > 0.1);
            (off, level) = (off + (found - exact).powi(2), level + exact * exact);
            beyond += usize::from((found - exact).abs() > 2.0 * stated + 4.0 * error + 1e-9);
        }
    }
    let relative = (off / level).sqrt();
    println!(
        "{lit} lit readings of {}: root mean square difference {relative:.1e}, {beyond} beyond",
        3 * list.len()
    );
    assert!(lit > 20 && relative < 0.01 && beyond <= 3 * list.len() / 20, "{lit} {relative} {beyond}");
}

#[test]
fn a_part_between_symmetry_planes_has_the_light_of_the_whole() {
    let room = |max_x: f64, lamps: &str, head: &str, omit: &str| {
        solved(&format!(
            "[solve]\ntolerance = 0.003\npatch_size = 0.5\nengine = \"dense\"\n{head}[[surface]]\nname = \"room\"\n\
             room = {{ min = [0, 0, 0], max = [{max_x}, 2, 2] }}\n{omit}reflectance = 0.5\n{lamps}"
        ))
    };
    let lamp = |x: f64, dx: f64| {
        format!(
            "[[light]]\nkind = \"spot\"\nposition = [{x}, 0.7, 1.6]\ndirection = [{dx}, 0.2, -1]\ninner_angle = 10\nouter_angle = 50\nintensity = 10\n"
        )
    };
    let whole = room(2.0, &(lamp(0.6, 0.3) + &lamp(1.4, -0.3)), "", "");
    let mirror = "[boundary]\nmin = [0, 0, 0]\nmax = [1, 2, 2]\nx1 = \"symmetry\"\n";
    let part = room(1.0, &lamp(0.6, 0.3), mirror, "omit = [\"x1\"]\n");
    let mut compared = 0;
    for (i, p) in part.zones.patches.iter().enumerate() {
        let same = |q: &Patch| (q.plate.centre() - p.plate.centre()).length() < 1e-9;
        let Some(j) = whole.zones.patches.iter().position(same) else { continue };
        let [a, b] =
            [(&part, i), (&whole, j)].map(|(s, k)| (s.fields.incident[k] + s.fields.direct_light(k)).first());
        assert!((a / b - 1.0).abs() < 0.01, "{a} {b}");
        compared += 1;
    }
    assert!(compared > 30, "{compared}");
    let [a, b] = [&part, &whole].map(|s| s.report.energy.emitted.first());
    assert!((2.0 * a / b - 1.0).abs() < 1e-9, "{a} {b}");
}

#[test]
fn lamps_heat_a_room_in_thermal_mode() {
    let s = solved(
        "mode = \"thermal\"\n[solve]\npatch_size = 1\nclosure = \"restore\"\n[[surface]]\nname = \"room\"\nroom = { min = [0, 0, 0], max = [2, 2, 2] }\n\
         temperature = 300\nemissivity = 0.9\nsolar_absorptance = 0.3\n[[light]]\nkind = \"point\"\nposition = [0.5, 0.7, 1.2]\npower = 60\n",
    );
    let heat = s.report.heat.as_ref().unwrap();
    let absorbed: f64 = heat.rows.iter().filter_map(|r| r.absorbed_sunlight).sum();
    assert!((absorbed / 60.0 - 1.0).abs() < 1e-6, "{absorbed}");
}
