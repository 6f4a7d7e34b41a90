//! Direct light, the surroundings, and the balance of power.

use crate::common;

use common::{count, mean, patches_of, read, sheet_over_floor, solved, unit_room, with_exchange};
use zonal_reference::test_cases::sampled_cases;
use zonal_scene::{Bands, NoProgress, Solution};
use zonal_solve::distribution::Execution;
use zonal_solve::right_hand_side::direct_light::illumination::{PowerNormalization, illuminate};
use zonal_solve::right_hand_side::direct_light::{DirectLight, LightField};
use zonal_solve::right_hand_side::surroundings::SurroundingsExchange;
use zonal_transport::{Transport, build_zones};

fn told(name: &str, s: &Solution) -> f64 {
    let e = &s.report.energy;
    let worst = e.residual.iter().fold(0.0f64, |w, r| w.max(r.abs()));
    println!(
        "{name}: residual {worst:.1e}, emitted {:.4}, incoming {:.4}, escaped {:.4}, backs {:.4}, change {:.1e}",
        e.emitted.first(),
        e.incoming.first(),
        e.escaped.first(),
        e.absorbed_backfaces.first(),
        s.report.closure.largest_change.first()
    );
    worst
}

const FOG: &str = "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[4,4,4]\nextinction=[0.8,0,2]\nalbedo=0.7\n";
const BLOCK: &str = "[[surface]]\nname=\"block\"\nbox={min=[0.3,0.25,0],max=[0.62,0.55,0.47],rotate_z_degrees=27}\nreflectance=0.5\n";
const PANE: &str =
    "[[pane]]\npolygon=[[0,1,0],[1,1,0],[1,1,1],[0,1,1]]\nthickness=0.01\nextinction=[10,80,0]\nalbedo=0.2\n";
const SUN: &str = "[[light]]\nname=\"sun\"\nkind=\"sun\"\ndirection=[0.3,-1,-0.6]\nirradiance=100\n";
const SKY: &str = "[[light]]\nname=\"sky\"\nkind=\"sky\"\nradiance=2\n";
const LAMP: &str = "[[surface]]\nname=\"lamp\"\nrectangle={origin=[0.4,0.4,0.99],edge1=[0,0.2,0],edge2=[0.2,0,0]}\nemission=10\nreflectance=0.1\n";
const LAMP_LIGHT: &str = "[[light]]\nkind=\"emitter\"\nsurface=\"lamp\"\n";

#[test]
fn power_balances_with_restoration() {
    let cases = [
        ("closed, lamp as a zone", true, format!("{LAMP}{BLOCK}{FOG}"), 1e-6),
        ("closed, lamp as a light", true, format!("{LAMP}{LAMP_LIGHT}{BLOCK}{FOG}"), 1e-6),
        ("open, sun", false, format!("{SUN}{BLOCK}{FOG}"), 1e-3),
        ("window, sun and sky", false, format!("{PANE}{SUN}{SKY}{BLOCK}{FOG}"), 1e-3),
        ("open, surroundings", false, format!("{PANE}{BLOCK}{FOG}[surroundings]\nradiance=2\n"), 1e-3),
        ("open, lamp", false, format!("{LAMP}{LAMP_LIGHT}{FOG}"), 1e-3),
    ];
    let pairs = cases.iter().flat_map(|case| ["measure", "restore"].map(|closure| (case, closure)));
    for (&(name, closed, ref rest, bound), closure) in sampled_cases(pairs, &[3, 6, 7]) {
        let omit = if closed { "" } else { "omit=[\"y1\"]\n" };
        let s = solved(&unit_room(
            &format!("patch_size=0.25\nengine=\"dense\"\nclosure=\"{closure}\""),
            &format!("{omit}reflectance=0.6\n"),
            rest,
        ));
        let worst = told(&format!("{name}, {closure}"), &s);
        assert!(worst < if closure == "restore" { bound } else { 0.03 }, "{name}, {closure}: {worst:e}");
    }
}

/// The direct light of a scene is the sum of that of its lights, and each light is the same in any company.
#[test]
fn fields_of_several_lights_add_up() {
    let lit = |lights: &str| -> (DirectLight, usize) {
        let scene = read(&unit_room("patch_size=0.25", "omit=[\"y1\"]", &format!("{FOG}{lights}")));
        let transport = Transport::new(&scene);
        let zones = build_zones(&scene, &transport).unwrap();
        (illuminate(&zones, &transport, PowerNormalization::None, Execution::alone(&NoProgress)), zones.len())
    };
    let (both, zones) = lit(&format!("{SUN}{SKY}"));
    let [sun, sky]: [LightField; 2] = [SUN, SKY].map(|light| lit(light).0.lights.swap_remove(0));
    assert_eq!(both.lights, [sun.clone(), sky.clone()]);
    for (i, sum) in both.fields(zones).into_iter().enumerate() {
        assert_eq!(sum, sun.fields[i] + sky.fields[i], "zone {i}");
        assert!(sun.error_of(i).all(|e| e >= 0.0));
    }
}

/// H or G of zone `i` with direct light, first band.
fn total(s: &Solution, i: usize) -> f64 {
    (s.fields.incident[i] + s.fields.direct_light(i)).first()
}

/// A lamp as direct light and as a zone gives the same H and G.
#[test]
fn emitter_as_direct_light_agrees_with_emitter_as_zone() {
    for medium in sampled_cases(["", FOG], &[1]) {
        let room = |light: &str| {
            let lamp =
                LAMP.replace("[0,0.2,0],edge2=[0.2,0,0]}", "[0,0.2,0],edge2=[0.2,0,0]}\npatch_size=0.05");
            solved(&unit_room(
                "patch_size=0.2\nengine=\"dense\"",
                "reflectance=0.5",
                &format!("{lamp}{light}{medium}"),
            ))
        };
        let (zone, light) = (room(""), room(LAMP_LIGHT));
        for face in ["z0", "x0", "y1"] {
            let p = patches_of(&zone, face);
            let [a, b] = [&zone, &light].map(|s| {
                let t: Vec<Bands> = (0..s.zones.len()).map(|i| Bands::splat(total(s, i))).collect();
                mean(s, &t, &p)
            });
            assert!((a / b - 1.0).abs() < if medium.is_empty() { 0.01 } else { 0.02 }, "{face}: {a} {b}");
        }
        let rms = relative_difference(&zone, &light, &patches_of(&zone, "z0"));
        println!("floor patches: {rms:.2e}");
        assert!(rms < 0.02, "{rms}");
        if !medium.is_empty() {
            let voxels: Vec<usize> = (zone.zones.voxel_offset()..zone.zones.len()).collect();
            let rms = relative_difference(&zone, &light, &voxels);
            println!("voxels: {rms:.2e}");
            assert!(rms < 0.03, "{rms}");
        }
    }
}

/// Root mean square of the relative difference of two solutions over some zones.
fn relative_difference(a: &Solution, b: &Solution, zones: &[usize]) -> f64 {
    let square = |&i: &usize| (total(b, i) / total(a, i) - 1.0).powi(2);
    (zones.iter().map(square).sum::<f64>() / zones.len() as f64).sqrt()
}

/// A sky as direct light and surroundings as a zone give the same light.
#[test]
fn sky_light_agrees_with_surroundings_of_equal_radiance() {
    let room = |rest: &str| {
        solved(&unit_room("patch_size=0.2", "omit=[\"y1\"]\nreflectance=0.5", &format!("{rest}{FOG}")))
    };
    let (a, b) = (room(SKY), room("[surroundings]\nradiance=2\n"));
    for face in ["z0", "y0", "x1"] {
        let p = patches_of(&a, face);
        let [x, y] = [&a, &b].map(|s| {
            let t: Vec<Bands> = (0..s.zones.len())
                .map(|i| Bands::splat(s.fields.incident[i].first() + s.fields.direct_light(i).first()))
                .collect();
            mean(s, &t, &p)
        });
        println!("{face}: sky light {x:.5}, surroundings {y:.5}");
        assert!((x / y - 1.0).abs() < 0.02, "{face}: {x} {y}");
    }
    // Sky light on the outer black sides of the walls counts as incoming and as absorbed by backs.
    let (x, y) = (
        a.report.energy.incoming.first() - a.report.energy.absorbed_backfaces.first(),
        b.report.energy.incoming.first(),
    );
    println!("incoming {x} {y}, π L A = {}", 2.0 * std::f64::consts::PI);
    assert!((x / y - 1.0).abs() < 0.02);
}

/// The sky factor of the walls of a convex room is the remainder of their mutual factors, within the stated error; without a medium it has a closed
/// form. Backs replace the sky below a roof over the window.
#[test]
fn sky_fraction_is_the_closure_remainder() {
    const WALLS: &str = "[solve]\npatch_size=0.5\ntolerance=0.01\n[surroundings]\nradiance=1\n[[surface]]\nname=\"room\"\nroom={min=[0,0,0],max=[2,1,1]}\nomit=[\"z1\"]\nreflectance=0.5\n[[surface]]\nname=\"roof\"\nrectangle={origin=[0,0,1],edge1=[0,1,0],edge2=[1.5,0,0]}\nreflectance=0.5\n";
    const CANOPY: &str = "[[surface]]\nname=\"over\"\nrectangle={origin=[-1,-1,1.3],edge1=[2.8,0,0],edge2=[0,3,0]}\nreflectance=0.5\n";
    for (name, scene) in [("open", WALLS.to_string()), ("half covered", format!("{WALLS}{CANOPY}"))] {
        let scene = read(&scene);
        with_exchange(&scene, |zones, transport, exchange| {
            let escape =
                SurroundingsExchange::measure(zones, transport, 256, 0, Execution::alone(&NoProgress), None);
            let inside: Vec<usize> =
                (0..zones.len()).filter(|&i| zones.patches[i].plate.centre().z <= 1.0).collect();
            let mut count = count();
            let level: f64 = escape.sky.iter().map(|s| s.first().powi(2)).sum();
            let (mut off, mut told) = (0.0, 0.0);
            for &i in &inside {
                let seen: f64 = inside.iter().map(|&j| exchange.pair(i, j, &mut count).value.first()).sum();
                let left = zones.patches[i].area - seen;
                let escaped = (escape.sky[i] + escape.backfaces[i]).first();
                off += (escaped - left).powi(2);
                told += escape.error[i].first().powi(2);
            }
            let [off, told] = [off, told].map(|x: f64| (x / level).sqrt());
            println!("{name}: {off:.5} off, {told:.5} told, {} rays", escape.rays);
            assert!(told < 0.006 && off < 1.5 * told, "{name}: {off} {told}");
        });
    }
}

/// Light through a small window is within its stated error, which falls with the tolerance.
#[test]
fn error_of_the_surroundings_is_stated() {
    const ROOM: &str = "patch_size=0.25\ntolerance=TOL\n[surroundings]\nradiance=[1,2,3]\n[[surface]]\nname=\"room\"\nroom={min=[0,0,0],max=[1,1,1]}\nomit=[\"z1\"]\nreflectance=0.5\n";
    const ROOF: &str = "[[surface]]\nname=\"roof\"\nrectangle={origin=[0,0,1],edge1=[0,1,0],edge2=[0.8,0,0]}\nreflectance=0.5\n[[surface]]\nname=\"rest\"\nrectangle={origin=[0.8,0,1],edge1=[0,0.7,0],edge2=[0.2,0,0]}\nreflectance=0.5\n[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[4,4,4]\nextinction=0.5\nalbedo=0.5\n";
    let found = |tolerance: &str, sample: u64| {
        let scene = read(&format!("[solve]\n{ROOM}{ROOF}").replace("TOL", tolerance));
        let transport = Transport::new(&scene);
        let zones = build_zones(&scene, &transport).unwrap_or_else(|e| panic!("{e}"));
        (
            SurroundingsExchange::measure(
                &zones,
                &transport,
                256,
                sample,
                Execution::alone(&NoProgress),
                None,
            ),
            zones.voxel_offset(),
        )
    };
    let rms = |of: &mut dyn Iterator<Item = f64>| {
        let all: Vec<f64> = of.collect();
        (all.iter().map(|x| x * x).sum::<f64>() / all.len() as f64).sqrt()
    };
    let (truth, patches) = found("0.001", 9);
    let mut told = Vec::new();
    for tolerance in ["0.2", "0.05"] {
        let (ours, _) = found(tolerance, 0);
        for range in [0..patches, patches..truth.sky.len()] {
            let level = rms(&mut range.clone().map(|i| truth.sky[i].first()));
            let error = rms(&mut range.clone().map(|i| ours.error[i].first())) / level;
            let off = rms(&mut range.clone().map(|i| (ours.sky[i] - truth.sky[i]).first())) / level;
            println!("tolerance {tolerance}: {error:.4} told, {off:.4} off");
            assert!(off < 1.5 * error && error < 6.0 * off, "{tolerance}: {error} told, {off} off");
            told.push(error);
        }
    }
    assert!(told[2] < 0.6 * told[0] && told[3] < 0.6 * told[1], "{told:?}");
}

/// A lamp of 324 patches over a floor of one patch, and a sheet that hides a fifteenth of it. Few rays of each pair meet the sheet; a mean by rays whose
/// number depends on what they meet would miss most of it.
#[test]
fn pairs_of_which_a_small_part_is_hidden_are_dimmed_by_it() {
    let s = common::solve(sheet_over_floor("0.8"));
    // The mean over the floor of the irradiance by the lamp, by the midpoint rule.
    let n = 32;
    let points = |half: f64| (0..n).map(move |k| half * ((2 * k + 1) as f64 / n as f64 - 1.0));
    let mut sum = 0.0;
    for (a, b) in points(0.4).flat_map(|a| points(0.4).map(move |b| (a, b))) {
        for (c, d) in points(1.0).flat_map(|c| points(1.0).map(move |d| (c, d))) {
            let at = |from: f64, to: f64| from + 0.025 * (to - from);
            // The point in the plane of the sheet, from its corner, along its edges of 0.2 m.
            let [x, y] = [at(a, c) + 0.0366, at(b, d) + 0.1366];
            let along = [[-0.1, 0.1732], [0.1732, 0.1]].map(|e| (e[0] * x + e[1] * y) / 0.04);
            let hidden = along.iter().all(|u| (0.0..1.0).contains(u));
            let r2 = (c - a).powi(2) + (d - b).powi(2) + 4.0;
            sum += if hidden { 0.0 } else { 4.0 / (std::f64::consts::PI * r2 * r2) };
        }
    }
    let want = 4.0 * sum / (n * n * n * n) as f64;
    let floor = patches_of(&s, "floor");
    assert_eq!(floor.len(), 1);
    let [h, e] = [s.fields.direct_light(floor[0]), s.fields.direct_error[floor[0]]].map(|x| x.first());
    assert!((h / want - 1.0).abs() < 0.01, "{h} ± {e}, {want}");
    assert!((h - want).abs() < 3.0 * e + 1e-3 * want, "{h} ± {e}, {want}");
}
