//! Panes: Beer's law, energy balance, agreement with resolved voxels and with Monte Carlo.

use crate::common;

use common::{mean, patches_of, read, solve, solved, unit_room, unlevel};
use std::f64::consts::PI;
use zonal_math::vec3;
use zonal_reference::test_cases::sampled_cases;
use zonal_reference::{BruteForceScene, radiance};
use zonal_scene::{Band, Plate, Scene};

const SKYLIGHT: &str =
    "[[pane]]\npolygon=[[0,0,1],[1,0,1],[1,1,1],[0,1,1]]\nthickness=0.01\nextinction=[50,100,0]\n";

#[test]
fn sunlight_through_a_pane_obeys_beers_law() {
    for degrees in [0.0f64, 60.0] {
        let (s, c) = degrees.to_radians().sin_cos();
        let sun = format!(
            "[[light]]\nkind=\"sun\"\ndirection=[{s},0,{}]\nirradiance=100\nangular_diameter=0\n",
            -c
        );
        let x = solved(&unit_room(
            "patch_size=0.25",
            "omit=[\"z1\"]\nreflectance=0",
            &format!("{SKYLIGHT}{sun}"),
        ));
        // At 60° the sun reaches the wall x1 only.
        let (name, cos) = if degrees == 0.0 { ("z0", 1.0) } else { ("x1", s) };
        let i = patches_of(&x, name)[0];
        let lit = patches_of(&x, name)
            .into_iter()
            .max_by(|a, b| x.fields.direct_light(*a).first().total_cmp(&x.fields.direct_light(*b).first()))
            .unwrap_or(i);
        for (b, k) in Band::all().zip([50.0f64, 100.0, 0.0]) {
            let want = 100.0 * cos * (-k * 0.01 / c).exp();
            let got = x.fields.direct_light(lit)[b];
            assert!((got / want - 1.0).abs() < 1e-9, "{degrees}°, {b:?}: {got} against {want}");
        }
        let e = &x.report.energy;
        for (b, k) in Band::all().zip([50.0f64, 100.0, 0.0]) {
            let want = 100.0 * c * (1.0 - (-k * 0.01 / c).exp());
            println!(
                "{degrees}° {b:?}: pane {} against {want}; incoming {}; residual {:.1e}",
                e.absorbed_panes[b], e.incoming[b], e.residual[b]
            );
            assert!((e.absorbed_panes[b] - want).abs() < 1e-6 * 100.0, "{degrees}° {b:?}");
            assert!(e.residual[b].abs() < 1.2e-2, "{degrees}° {b:?}: {}", e.residual[b]);
        }
    }
}

#[test]
fn isothermal_rooms_with_panes_are_uniform() {
    let pane = |o: &str| {
        format!(
            "[[pane]]\nname=\"mid\"\npolygon=[[0.5,0,0],[0.5,1,0],[0.5,1,1],[0.5,0,1]]\n{o}\nemission=2\nalbedo=0.3\n"
        )
    };
    let walls = "reflectance=0.4\nemission=1.2";
    let fog =
        "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[2,2,2]\nextinction=[0.5,0,2]\nalbedo=0.5\nemission=2";
    let coloured = "thickness=0.01\nextinction=[20,100,0]";
    let extreme = "thickness=0.001\nextinction=[1e-3,5000,1]";
    let cases = [
        (coloured, "", "measure", 0.1),
        (coloured, "", "restore", 1e-9),
        (coloured, fog, "restore", 1e-9),
        (extreme, "", "measure", 0.1),
        (extreme, "", "restore", 1e-9),
        (extreme, fog, "restore", 1e-9),
    ];
    for (look, medium, closure, bound) in sampled_cases(cases, &[2, 3]) {
        let s = solved(&unit_room(
            &format!("patch_size=0.25\nresidual=1e-13\ntolerance=0.03\nclosure=\"{closure}\""),
            walls,
            &format!("{}{medium}", pane(look)),
        ));
        let (h, g) = unlevel(&s, 2.0);
        println!("{closure} {look:?}: H {h:.2e} G {g:.2e} closure {:?}", s.report.closure.worst);
        assert!(h < bound && g < bound, "{closure}, {look}: H {h:e} G {g:e}");
    }
}

/// One hot wall and a pane across the middle: H on the walls against Monte Carlo.
#[test]
fn pane_between_two_halves_agrees_with_monte_carlo() {
    let text = |pane: &str, size: f64| {
        unit_room(&format!("patch_size={size}"), "reflectance=0.3\nfaces.x0={emission=1}", pane)
    };
    let pane = "[[pane]]\npolygon=[[0.6,0,0],[0.6,1,0],[0.6,1,1],[0.6,0,1]]\nthickness=0.01\nextinction=70\nalbedo=0.6\n";
    for (what, pane) in sampled_cases([("nothing", ""), ("pane", pane)], &[1]) {
        // First order in the patches' size: two sizes, extrapolated.
        let (s, t) = (solved(&text(pane, 0.2)), solved(&text(pane, 0.1)));
        let w = BruteForceScene::new(&s.scene);
        for face in ["x0", "x1", "y0"] {
            let p = patches_of(&s, face);
            let plate = s.scene.facets()[s.zones.patches[p[0]].facet].plate;
            let e = radiance::irradiance(&w, &plate, Band::first(), 400_000, 7);
            let (coarse, fine) =
                (mean(&s, &s.fields.incident, &p), mean(&t, &t.fields.incident, &patches_of(&t, face)));
            let h = 2.0 * fine - coarse;
            println!(
                "{what}, {face}: {coarse:.5} {fine:.5} → {h:.5} against {:.5} ± {:.5}",
                e.value, e.error
            );
            assert!(e.z(h, 0.01 * e.value) < 4.0, "{face}: {h} against {e:?}");
        }
    }
}

#[test]
fn thick_pane_agrees_with_resolved_voxels() {
    let room =
        |rest: &str| solved(&unit_room("patch_size=0.1", "reflectance=0.3\nfaces.x0={emission=1}", rest));
    // A layer of a tenth at x = 0.4…0.5, optical depth 0.5.
    let voxels = room("[medium]\nmin=[0.4,0,0]\nmax=[0.5,1,1]\ncells=[2,10,10]\nextinction=5\nalbedo=0.5");
    let pane = room(
        "[[pane]]\npolygon=[[0.45,0,0],[0.45,1,0],[0.45,1,1],[0.45,0,1]]\nthickness=0.1\nextinction=5\nalbedo=0.5",
    );
    for face in ["x0", "x1", "y0"] {
        let [a, b] = [&voxels, &pane].map(|s| mean(s, &s.fields.incident, &patches_of(s, face)));
        println!("{face}: voxels {a:.5}, pane {b:.5}");
        assert!((b / a - 1.0).abs() < 0.05, "{face}: {a} {b}");
    }
}

#[test]
fn scene_of_panes_alone_is_solved() {
    let s = solved(
        "[solve]\npatch_size=0.5\n[surroundings]\nradiance=1\n[[pane]]\npolygon=[[0,0,0],[1,0,0],[1,1,0],[0,1,0]]\nthickness=0.01\nextinction=[10,100,0]\nalbedo=0.5\n\
         [[pane]]\npolygon=[[0,0,1],[1,0,1],[1,1,1],[0,1,1]]\nthickness=0.01\nextinction=[10,100,0]\nemission=2\n\
         [[light]]\nkind=\"sun\"\ndirection=[0,0.6,-0.8]\nirradiance=5\n",
    );
    assert!(s.fields.incident.iter().flatten().all(|x| x.is_finite() && *x > 0.0), "{:?}", s.fields.incident);
    let e = &s.report.energy;
    println!("{:?}", e.residual);
    assert!(e.residual.iter().all(|r| r.abs() < 0.05), "{e:?}");
}

/// A window in the opening of a wall transmits π L A τ̄ of the light of the surroundings.
#[test]
fn small_window_transmits_all_its_light() {
    let (w, l) = (0.25, 3.0);
    let mut parts = read(&format!("[solve]\npatch_size=0.5\n[surroundings]\nradiance={l}\n[[surface]]\nname=\"room\"\nroom={{min=[0,0,0],max=[4,6,3]}}\nomit=[\"y1\"]\nreflectance=0.2\n")).into_parts();
    // The wall y = 6 around an opening of w × w.
    let (x0, z0) = (1.9, 1.3);
    let piece = |x: [f64; 2], z: [f64; 2]| {
        Plate::parallelogram(vec3(x[0], 6.0, z[0]), vec3(x[1] - x[0], 0.0, 0.0), vec3(0.0, 0.0, z[1] - z[0]))
    };
    let frame = [
        piece([0.0, x0], [0.0, 3.0]),
        piece([x0 + w, 4.0], [0.0, 3.0]),
        piece([x0, x0 + w], [0.0, z0]),
        piece([x0, x0 + w], [z0 + w, 3.0]),
    ];
    common::add(&mut parts, common::surface("frame", 0.2, 0.0, false), &frame);
    let s = solve(Scene::new(parts).unwrap());
    let want = PI * l * w * w;
    let e = &s.report.energy;
    println!("incoming {} against {want}; residual {}", e.incoming.first(), e.residual.first());
    assert!((e.incoming.first() / want - 1.0).abs() < 0.1, "{} against {want}", e.incoming.first());
}
