//! Direct light, the surroundings, and the balance of power.

mod common;

use common::{count, mean, patches_of, read, solved, unit_room, with_exchange};
use zonal_reference::{BruteForceScene, radiance};
use zonal_scene::{NoProgress, Solution};
use zonal_solve::surroundings::SurroundingsExchange;
use zonal_transport::{Transport, build_zones};

fn told(name: &str, s: &Solution) -> f64 {
    let e = &s.report.energy;
    let worst = e.residual.iter().fold(0.0f64, |w, r| w.max(r.abs()));
    println!(
        "{name}: residual {worst:.1e}, emitted {:.4}, incoming {:.4}, escaped {:.4}, backs {:.4}, change {:.1e}",
        e.emitted[0],
        e.incoming[0],
        e.escaped[0],
        e.absorbed_backfaces[0],
        s.report.closure.largest_change[0]
    );
    worst
}

const FOG: &str = "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[5,5,5]\nextinction=[0.8,0,2]\nalbedo=0.7\n";
const BLOCK: &str = "[[surface]]\nname=\"block\"\nbox={min=[0.3,0.25,0],max=[0.62,0.55,0.47],rotate_z_degrees=27}\nreflectance=0.5\n";
const PANE: &str =
    "[[pane]]\npolygon=[[0,1,0],[1,1,0],[1,1,1],[0,1,1]]\nthickness=0.01\nextinction=[10,80,0]\nalbedo=0.2\n";
const SUN: &str = "[[light]]\nkind=\"sun\"\ndirection=[0.3,-1,-0.6]\nirradiance=100\n";
const SKY: &str = "[[light]]\nkind=\"sky\"\nradiance=2\n";
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
    for (name, closed, rest, bound) in cases {
        let omit = if closed { "" } else { "omit=[\"y1\"]\n" };
        for closure in ["measure", "restore"] {
            let s = solved(&unit_room(
                &format!("patch_size=0.2\nclosure=\"{closure}\""),
                &format!("{omit}reflectance=0.6\n"),
                &rest,
            ));
            let worst = told(&format!("{name}, {closure}"), &s);
            assert!(worst < if closure == "restore" { bound } else { 0.03 }, "{name}, {closure}: {worst:e}");
        }
    }
}

/// A lamp as direct light and as a zone gives the same H and G.
#[test]
fn emitter_as_direct_light_agrees_with_emitter_as_zone() {
    for medium in ["", FOG] {
        let room = |light: &str| {
            let lamp =
                LAMP.replace("[0,0.2,0],edge2=[0.2,0,0]}", "[0,0.2,0],edge2=[0.2,0,0]}\npatch_size=0.05");
            solved(&unit_room("patch_size=0.2", "reflectance=0.5", &format!("{lamp}{light}{medium}")))
        };
        let (zone, light) = (room(""), room(LAMP_LIGHT));
        let total = |s: &Solution, i: usize| s.fields.incident[i][0] + s.fields.direct[i][0];
        for face in ["z0", "x0", "y1"] {
            let p = patches_of(&zone, face);
            let [a, b] = [&zone, &light].map(|s| {
                let t: Vec<[f64; 3]> = (0..s.zones.len()).map(|i| [total(s, i); 3]).collect();
                mean(s, &t, &p)
            });
            let plate = zone.scene.facets()[zone.zones.patches[p[0]].facet].plate;
            let e = radiance::irradiance(&BruteForceScene::new(&zone.scene), &plate, 0, 400_000, 3);
            println!("{face}: zone {a:.5} light {b:.5}; walks {:.5} ± {:.5}", e.value, e.error);
            assert!((a / b - 1.0).abs() < if medium.is_empty() { 0.01 } else { 0.02 }, "{face}: {a} {b}");
        }
        let floor = patches_of(&zone, "z0");
        let rms = (floor.iter().map(|&i| (total(&light, i) / total(&zone, i) - 1.0).powi(2)).sum::<f64>()
            / floor.len() as f64)
            .sqrt();
        println!("floor patches: {rms:.2e}");
        assert!(rms < 0.02, "{rms}");
        if !medium.is_empty() {
            let n = zone.zones.voxel_offset();
            let off = |i: usize| total(&light, i) / total(&zone, i) - 1.0;
            let rms = ((n..zone.zones.len()).map(|i| off(i).powi(2)).sum::<f64>()
                / (zone.zones.len() - n) as f64)
                .sqrt();
            println!("voxels: {rms:.2e}");
            let w = BruteForceScene::new(&zone.scene);
            let mut worst: Vec<usize> = (n..zone.zones.len()).collect();
            worst.sort_by(|a, b| off(*b).abs().total_cmp(&off(*a).abs()));
            for &i in &worst[..6] {
                let v = &zone.zones.voxels[i - n];
                let map = zone.scene.voxel_grid().unwrap();
                let lo = map.corner(map.coordinates(v.cell));
                let e = radiance::fluence(&w, lo, lo + map.cell(), 0, 100_000, 3);
                println!(
                    "  {:?} of {:.1e}, {} samples: zone {:.4} light {:.4}; walks in the cell {:.4} ± {:.4}",
                    v.centre,
                    v.volume,
                    v.samples.len(),
                    total(&zone, i),
                    total(&light, i),
                    e.value,
                    e.error
                );
            }
            assert!(rms < 0.03, "{rms}");
        }
    }
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
            let t: Vec<[f64; 3]> =
                (0..s.zones.len()).map(|i| [s.fields.incident[i][0] + s.fields.direct[i][0]; 3]).collect();
            mean(s, &t, &p)
        });
        println!("{face}: sky light {x:.5}, surroundings {y:.5}");
        assert!((x / y - 1.0).abs() < 0.02, "{face}: {x} {y}");
    }
    // Sky light on the outer black sides of the walls counts as incoming and as absorbed by backs.
    let (x, y) =
        (a.report.energy.incoming[0] - a.report.energy.absorbed_backfaces[0], b.report.energy.incoming[0]);
    println!("incoming {x} {y}, π L A = {}", 2.0 * std::f64::consts::PI);
    assert!((x / y - 1.0).abs() < 0.02);
}

/// The sky factor of the walls of a convex room is the remainder of their mutual factors, within the stated error; without a medium it has a closed
/// form. Backs replace the sky below a roof over the window.
#[test]
fn sky_fraction_is_the_closure_remainder() {
    const WALLS: &str = "[solve]\npatch_size=0.5\ntolerance=0.01\n[surroundings]\nradiance=1\n[[surface]]\nname=\"room\"\nroom={min=[0,0,0],max=[2,1,1]}\nomit=[\"z1\"]\nreflectance=0.5\n[[surface]]\nname=\"roof\"\nrectangle={origin=[0,0,1],edge1=[0,1,0],edge2=[1.5,0,0]}\nreflectance=0.5\n";
    const OVER: &str = "[[surface]]\nname=\"over\"\nrectangle={origin=[-1,-1,1.3],edge1=[2.8,0,0],edge2=[0,3,0]}\nreflectance=0.5\n";
    for (name, scene) in [("open", WALLS.to_string()), ("half covered", format!("{WALLS}{OVER}"))] {
        let scene = read(&scene);
        with_exchange(&scene, |zones, transport, exchange| {
            let escape = SurroundingsExchange::measure(&scene, zones, transport, (256, 0), &NoProgress);
            let inside: Vec<usize> =
                (0..zones.len()).filter(|&i| zones.patches[i].plate.centre().z <= 1.0).collect();
            let mut count = count();
            let level: f64 = escape.sky.iter().map(|s| s[0].powi(2)).sum();
            let (mut off, mut told) = (0.0, 0.0);
            for &i in &inside {
                let seen: f64 = inside.iter().map(|&j| exchange.pair(i, j, &mut count).value[0]).sum();
                let left = zones.patches[i].area - seen;
                let escaped = escape.sky[i][0] + escape.backfaces[i][0];
                off += (escaped - left).powi(2);
                told += escape.error[i][0].powi(2);
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
            SurroundingsExchange::measure(&scene, &zones, &transport, (256, sample), &NoProgress),
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
            let level = rms(&mut range.clone().map(|i| truth.sky[i][0]));
            let error = rms(&mut range.clone().map(|i| ours.error[i][0])) / level;
            let off = rms(&mut range.clone().map(|i| ours.sky[i][0] - truth.sky[i][0])) / level;
            println!("tolerance {tolerance}: {error:.4} told, {off:.4} off");
            assert!(off < 1.5 * error && error < 6.0 * off, "{tolerance}: {error} told, {off} off");
            told.push(error);
        }
    }
    assert!(told[2] < 0.6 * told[0] && told[3] < 0.6 * told[1], "{told:?}");
}
