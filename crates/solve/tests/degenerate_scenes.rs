//! Degenerate scenes: no panic, no NaN, balanced power.

use crate::common;

use common::{solved, unit_room};
use zonal_scene::{Band, Solution};

fn sane(name: &str, s: &Solution, balance: f64) {
    let f = &s.fields;
    for (what, field) in [("B", &f.radiosity), ("in", &f.incident), ("dir", &f.direct), ("err", &f.error)] {
        let bad = field.iter().position(|x| x.any(|x| !x.is_finite() || x < 0.0));
        assert!(bad.is_none(), "{name}: {what} of zone {bad:?} is {:?}", bad.map(|i| field[i]));
    }
    let r = s.report.energy.residual;
    println!(
        "{name}: {} zones, residual {r:?}, closure {:?}, {:?}",
        s.zones.len(),
        s.report.closure.worst,
        s.report.status[Band::first()]
    );
    assert!(r.iter().all(|x| x.abs() < balance), "{name}: {r:?}");
}

#[test]
fn degenerate_scenes_are_solved_without_nan() {
    let room = "[[surface]]\nname=\"room\"\nroom={min=[0,0,0],max=[1,1,1]}\nreflectance=0.5\nfaces.x0={emission=1}\n";
    let cases: Vec<(&str, String, f64)> = vec![
        ("a medium alone", "[surroundings]\nradiance=1\n[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[3,3,3]\nextinction=[1,0,100]\nemission=1\nalbedo=0.5\n".into(), 0.05),
        ("one cell", "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[1,1,1]\nextinction=1\nemission=1\n".into(), 0.05),
        ("one triangle", "[surroundings]\nradiance=1\n[[surface]]\ntriangle={corners=[[0,0,0],[1,0,0],[0,1,0.3]]}\nemission=1\nsides=\"both\"\n".into(), 0.01),
        ("nothing emits", format!("[solve]\npatch_size=0.5\n{}", room.replace("faces.x0={emission=1}", "")), 0.01),
        ("voxmap beyond the room", format!("[solve]\npatch_size=0.5\n{room}[medium]\nmin=[-0.5,-0.5,-0.5]\nmax=[1.5,1.5,1.5]\ncells=[4,4,4]\nextinction=1\nalbedo=0.5\nemission=0.1\n"), 0.05),
        ("voxmap in a corner of the room", format!("[solve]\npatch_size=0.5\n{room}[medium]\nmin=[0.2,0.2,0.2]\nmax=[0.6,0.6,0.6]\ncells=[2,2,2]\nextinction=3\nalbedo=0.5\n"), 0.05),
        ("voxmap apart from the room", format!("[solve]\npatch_size=0.5\n{room}[medium]\nmin=[5,5,5]\nmax=[6,6,6]\ncells=[2,2,2]\nextinction=3\nalbedo=0.5\nemission=1\n"), 0.05),
        ("dense beside empty", format!("[solve]\npatch_size=0.34\n{room}[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[3,3,3]\nextinction=0\nalbedo=0.9\n[[medium.region]]\nbox={{min=[0.34,0.34,0.34],max=[0.66,0.66,0.66]}}\nextinction=[30,1000,1e6]\nalbedo=0.9\n"), 0.05),
        ("thick", format!("[solve]\npatch_size=0.5\n{room}[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[2,2,2]\nextinction=[100,1e4,1e7]\nalbedo=0.5\nemission=0.3\n"), 0.01),
        ("far from the origin", format!("[solve]\npatch_size=0.5\n{}", room.replace("min=[0,0,0],max=[1,1,1]", "min=[10000,20000,-5000],max=[10001,20001,-4999]")), 1e-6),
        ("tiny", format!("[solve]\npatch_size=5e-7\n{}", room.replace("max=[1,1,1]", "max=[1e-6,1e-6,1e-6]")), 1e-6),
        ("huge", format!("[solve]\npatch_size=5e6\n{}", room.replace("max=[1,1,1]", "max=[1e7,1e7,1e7]")), 1e-6),
        ("flat", format!("[solve]\npatch_size=0.5\n{}", room.replace("max=[1,1,1]", "max=[1,1,1e-4]")), 1e-6),
        ("pane across voxels", format!("[solve]\npatch_size=0.5\n{room}[[pane]]\npolygon=[[0.3,0,0],[0.7,1,0],[0.7,1,1],[0.3,0,1]]\nthickness=0.02\nextinction=[5,1e5,0]\nalbedo=0.9\n[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[3,3,3]\nextinction=1\nalbedo=0.5\n"), 0.1),
        ("triangular pane outside", format!("[solve]\npatch_size=0.5\n{room}[[pane]]\npolygon=[[2,0,0],[3,1,0],[3,1,1]]\nthickness=0.02\nextinction=[5,1e5,0]\nalbedo=0.9\n[[light]]\nkind=\"sky\"\nradiance=1\n"), 0.05),
    ];
    for (name, text, balance) in &cases {
        sane(name, &solved(text), *balance);
    }
}

#[test]
fn voxel_grid_larger_than_a_closed_room_changes_nothing() {
    let room = |min: &str, max: &str, n: usize| {
        let medium = format!(
            "[medium]\nmin=[{min},{min},{min}]\nmax=[{max},{max},{max}]\ncells=[{n},{n},{n}]\nextinction=1\nalbedo=0.5"
        );
        let solve = "patch_size=0.25\nzone_basis=\"constant\"\nengine=\"dense\"";
        solved(&unit_room(solve, "reflectance=0.5\nfaces.x0={emission=1}", &medium))
    };
    // Cells coincide inside the room.
    let (a, b) = (room("0", "1", 4), room("-0.5", "1.5", 8));
    let off = (0..a.zones.patches.len())
        .map(|i| (a.fields.incident[i].first() / b.fields.incident[i].first() - 1.0).abs())
        .fold(0.0, f64::max);
    println!("H differs by {off:.2e}");
    assert!(off < 1e-2, "{off}");
}
