//! Enclosures with obstacles: isothermal ones are uniform, walls are opaque, and results do not depend on the number of threads.

use crate::common;

use common::{add, on_threads, read, solve, solved, surface, tetrahedron, unit_room, unlevel, unlevel_rms};
use std::f64::consts::PI;
use zonal_math::{Vec3, vec3};
use zonal_reference::test_cases::sampled_cases;
use zonal_scene::{Band, Scene, Solution};

/// Emissive power of the isothermal rooms, W/m².
const EMISSIVE_POWER: f64 = 3.0;

fn isothermal_room(options: &str, rest: &str) -> String {
    let medium = format!(
        "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[5,5,5]\nextinction=[0.8,0,3]\nalbedo=[0.5,0.2,0.9]\nemission={EMISSIVE_POWER}\n"
    );
    let walls = format!(
        "reflectance=[0.3,0.6,0]\nemission=[{},{},{}]",
        0.7 * EMISSIVE_POWER,
        0.4 * EMISSIVE_POWER,
        EMISSIVE_POWER
    );
    let rest = rest.replace("LOOK", &format!("reflectance=0.5\nemission={}", 0.5 * EMISSIVE_POWER));
    unit_room(
        &format!("patch_size=0.2\nengine=\"dense\"\nresidual=1e-13\n{options}"),
        &walls,
        &format!("{rest}\n{medium}"),
    )
}

fn report(name: &str, s: &Solution) -> (f64, f64) {
    let (h, g) = unlevel(s, EMISSIVE_POWER);
    let c = &s.report.closure;
    println!(
        "{name}: {} zones, H {h:.2e}, G {g:.2e}, rms {:.2e} {:.2e}; closure worst {:.2e} rms {:.2e}, change {:.2e}, after {:?}, balance {:.1e}, {:?}",
        s.zones.len(),
        unlevel_rms(s, EMISSIVE_POWER).0,
        unlevel_rms(s, EMISSIVE_POWER).1,
        c.worst.first(),
        c.rms.first(),
        c.largest_change.first(),
        c.residual_defect,
        s.report.energy.residual.first(),
        s.report.status[Band::first()]
    );
    let far = |i: usize| {
        (s.fields.incident[i].first()
            / if i < s.zones.voxel_offset() { EMISSIVE_POWER } else { 4.0 * EMISSIVE_POWER }
            - 1.0)
            .abs()
    };
    let i = (0..s.zones.len()).max_by(|&a, &b| far(a).total_cmp(&far(b))).unwrap_or(0);
    if i < s.zones.voxel_offset() {
        let p = &s.zones.patches[i];
        println!(
            "    worst {:.2e}: patch {:?} area {:.2e} {:?}",
            far(i),
            s.scene.surfaces()[p.surface].name,
            p.area,
            p.plate
        );
    } else {
        let v = s.zones.voxels.at(i - s.zones.voxel_offset());
        println!(
            "    worst {:.2e}: voxel {} at {:?}, volume {:.2e}, {} samples",
            far(i),
            v.cell,
            v.centre,
            v.volume,
            v.samples.len()
        );
    }
    (h, g)
}

fn with_tetrahedron(options: &str) -> Scene {
    let mut parts = read(&isothermal_room(options, "")).into_parts();
    add(
        &mut parts,
        surface("stone", 0.5, 0.5 * EMISSIVE_POWER, true),
        &tetrahedron(vec3(0.52, 0.49, 0.47), 0.31),
    );
    Scene::new(parts).unwrap()
}

const BLOCK: &str =
    "[[surface]]\nname=\"block\"\nbox={min=[0.3,0.25,0],max=[0.62,0.55,0.47],rotate_z_degrees=27}\nLOOK";
const HANGING: &str =
    "[[surface]]\nname=\"block\"\nbox={min=[0.3,0.25,0.2],max=[0.62,0.55,0.57],rotate_z_degrees=27}\nLOOK";
const SHEET: &str = "[[surface]]\nname=\"sheet\"\nrectangle={origin=[0.2,0.3,0.1],edge1=[0.5,0.3,0.1],edge2=[-0.1,0.2,0.6]}\nsides=\"both\"\nLOOK";

#[test]
fn isothermal_rooms_with_oblique_solids_are_uniform_to_the_tolerance() {
    for (name, scene) in
        [("block on the floor", read(&isothermal_room("", BLOCK))), ("tetrahedron", with_tetrahedron(""))]
    {
        let s = solve(scene);
        // The tolerance holds in the mean over areas; single slivers beside a block have larger errors.
        let ((h, g), (hr, gr)) = (report(name, &s), unlevel_rms(&s, EMISSIVE_POWER));
        assert!(h < 0.2 && g < 0.1 && hr < 1.2e-2 && gr < 1.2e-2, "{name}");
        assert!(s.report.closure.rms.iter().all(|x| *x < 0.015), "{name}: {:?}", s.report.closure.rms);
    }
}

#[test]
fn restored_isothermal_rooms_with_oblique_solids_are_uniform_to_nine_digits() {
    let o = "closure=\"restore\"\ntolerance=0.03";
    let cases = [
        ("block on the floor", read(&isothermal_room(o, BLOCK))),
        ("hanging block", read(&isothermal_room(o, HANGING))),
        ("sheet", read(&isothermal_room(o, SHEET))),
        ("tetrahedron", with_tetrahedron(o)),
    ];
    for (name, scene) in sampled_cases(cases, &[0, 2, 3]) {
        let s = solve(scene);
        let (h, g) = report(name, &s);
        if name == "block on the floor" {
            // A narrow strip of a floor patch lies below the block and exchanges with its black inside.
            let (hr, gr) = unlevel_rms(&s, EMISSIVE_POWER);
            assert!(hr < 2e-3 && gr < 2e-3, "{name}: {hr} {gr}");
        } else {
            assert!(h < 1e-9 && g < 1e-9, "{name}");
        }
        assert!(
            s.report.energy.residual.iter().all(|x| x.abs() < 1e-9),
            "{name}: {:?}",
            s.report.energy.residual
        );
    }
}

#[test]
fn open_rooms_in_isothermal_surroundings_are_uniform() {
    let open = |options: &str| {
        let t = isothermal_room(options, BLOCK).replace(
            "[[surface]]\nname = \"room\"",
            "[surroundings]\nradiance = RADIANCE\n[[surface]]\nname = \"room\"\nomit=[\"y0\"]",
        );
        t.replace("RADIANCE", &format!("{}", EMISSIVE_POWER / PI))
    };
    for (closure, bound) in sampled_cases([("measure", 1.5e-2), ("restore", 2e-3)], &[1]) {
        let s = solved(&open(&format!("closure=\"{closure}\"")));
        report(&format!("open, {closure}"), &s);
        let (hr, gr) = unlevel_rms(&s, EMISSIVE_POWER);
        assert!(hr < bound && gr < bound, "{closure}: {hr} {gr}");
    }
}

/// A room divided by a wall without thickness, through voxels and patches, lit on one side.
fn divided(wall: &str, medium: &str) -> Solution {
    let wall = format!("[[surface]]\nname=\"wall\"\n{wall}\nsides=\"both\"\nreflectance=0.5\n");
    solved(&unit_room(
        "patch_size=0.25\nengine=\"dense\"",
        "reflectance=0.5\nfaces.x0={emission=1}",
        &format!("{wall}{medium}"),
    ))
}

/// Largest incident radiation beyond the plane n·x = c and mean before it, of patches and of volume zones.
fn dark_maximum_and_lit_mean(s: &Solution, n: Vec3, c: f64) -> [(f64, f64); 2] {
    let mut out = [(0.0f64, 0.0, 0.0); 2];
    for (i, f) in s.fields.incident.iter().enumerate() {
        let (k, at) = if i < s.zones.voxel_offset() {
            let p = &s.zones.patches[i];
            // Patches of the wall belong to the side that they face.
            (0, p.plate.centre() + p.normal * 1e-3)
        } else {
            (1, s.zones.voxels.at(i - s.zones.voxel_offset()).centre)
        };
        if n.dot(at) > c {
            out[k].0 = out[k].0.max(f.first());
        } else {
            out[k].1 += f.first();
            out[k].2 += 1.0;
        }
    }
    out.map(|(d, l, n)| (d, l / f64::max(n, 1.0)))
}

const FOG: &str = "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[4,4,4]\nextinction=1\nalbedo=0.8";

#[test]
fn no_light_passes_a_thin_wall() {
    let upright = "rectangle={origin=[0.5,0,0],edge1=[0,1,0],edge2=[0,0,1]}";
    // From (0.3, y, 0) to (0.72, y, 1).
    let leaning = "rectangle={origin=[0.3,0,0],edge1=[0,1,0],edge2=[0.42,0,1]}";
    let turned = "rectangle={origin=[0.25,0,0],edge1=[0.47,1,0],edge2=[0,0,1]}";
    let walls = [
        ("upright", upright, vec3(1.0, 0.0, 0.0), 0.5),
        ("leaning", leaning, vec3(1.0, 0.0, -0.42), 0.3),
        ("turned", turned, vec3(1.0, -0.47, 0.0), 0.25),
    ];
    let media = [("vacuum", ""), ("fog", FOG)];
    let cases = walls.into_iter().flat_map(|wall| media.map(|medium| (wall, medium)));
    for ((name, wall, n, c), (what, medium)) in sampled_cases(cases, &[1, 2, 5]) {
        let s = divided(wall, medium);
        let [(hd, hl), (gd, gl)] = dark_maximum_and_lit_mean(&s, n, c);
        println!(
            "{name}, {what}: H {hd:.1e} behind {hl:.3}, G {gd:.1e} behind {gl:.3}, closure {:.2e}",
            s.report.closure.worst.first()
        );
        assert!(hd <= 1e-3 * hl, "{name}, {what}: H {hd} behind {hl}");
        assert!(gd <= 1e-3 * gl, "{name}, {what}: G {gd} behind {gl}");
    }
}

#[test]
fn walls_slightly_inside_the_voxel_grid_do_not_change_the_result() {
    // As in the Cornell box, the voxel grid extends beyond the walls by a thousandth on each side.
    let walls = format!("reflectance=0.5\nemission={}", 0.5 * EMISSIVE_POWER);
    let medium = format!(
        "[medium]\nmin=[-0.001,-0.001,-0.001]\nmax=[1.001,1.001,1.001]\ncells=[3,3,3]\nextinction=[0.5,0,2]\nalbedo=0.4\nemission={EMISSIVE_POWER}"
    );
    let worst_deviation = |options: &str| {
        let s = solved(&unit_room(
            &format!("patch_size=0.34\nengine=\"dense\"\nresidual=1e-13\n{options}"),
            &walls,
            &medium,
        ));
        // Slivers beyond the walls exchange with no emitter of the room and are excluded.
        let inside = |i: usize| {
            i < s.zones.voxel_offset() || {
                let c = s.zones.voxels.at(i - s.zones.voxel_offset()).centre;
                c.min(Vec3::ONE) == c && c.max(Vec3::ZERO) == c
            }
        };
        let mut worst = 0.0f64;
        for i in (0..s.zones.len()).filter(|&i| inside(i)) {
            let want = if i < s.zones.voxel_offset() { EMISSIVE_POWER } else { 4.0 * EMISSIVE_POWER };
            worst = s.fields.incident[i].iter().fold(worst, |w, x| w.max((x / want - 1.0).abs()));
        }
        println!(
            "{} voxel zones of 27 cells, off {worst:.2e}, closure {:?}",
            s.zones.voxels.len(),
            s.report.closure.rms
        );
        worst
    };
    for (closure, bound) in sampled_cases([("measure", 0.03), ("restore", 1e-8)], &[1]) {
        assert!(worst_deviation(&format!("closure=\"{closure}\"")) < bound, "{closure}");
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let text = unit_room(
        "patch_size=0.5\ntolerance=0.1\nclosure=\"restore\"",
        "omit=[\"y1\"]\nreflectance=0.6\nfaces.z1={emission=1}",
        "[[surface]]\nname=\"block\"\nbox={min=[0.3,0.25,0],max=[0.62,0.55,0.47],rotate_z_degrees=27}\n\
         [[pane]]\npolygon=[[0.1,0.8,0.1],[0.9,0.8,0.1],[0.9,0.8,0.9],[0.1,0.8,0.9]]\nthickness=0.02\nextinction=[5,10,0]\nalbedo=0.3\n\
         [medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[2,2,2]\nextinction=[0.5,1,0]\nalbedo=0.5\n\
         [[medium.region]]\nbox={min=[0,0,0],max=[0.4,0.4,0.4]}\nextinction=2\n\
         [[light]]\nkind=\"sun\"\ndirection=[0.2,-1,-0.7]\nirradiance=10\n\
         [[light]]\nkind=\"sky\"\nradiance=[1,2,3]\n\
         [[light]]\nkind=\"emitter\"\nsurface=\"room.z1\"\n[surroundings]\nradiance=0.2",
    );
    let scene = read(&text);
    let (a, b) = (on_threads(&scene, 1), on_threads(&scene, 2));
    assert_eq!(a.0, b.0);
    assert_eq!(a.1, b.1);
}

/// A body on the floor of a black room, sunk into it or floating above it by less than a contact: it radiates into the room with five faces, not into the void.
#[test]
fn a_body_in_contact_with_a_floor_has_no_gap() {
    let heat = |gap: f64, scale: f64| {
        let at = |x: f64| x * scale;
        let text = format!(
            "mode = 'thermal'\n[[surface]]\nname = 'room'\nroom = {{ min = [0,0,0], max = [{0},{0},{0}] }}\nemissivity = 1\ntemperature = 300\npatch_size = {1}\n\
             [[surface]]\nname = 'body'\nbox = {{ min = [{2},{2},{gap}], max = [{3},{3},{4}] }}\nemissivity = 0.5\ntemperature = 800\npatch_size = {5}\n",
            at(1.0),
            at(0.5),
            at(0.3),
            at(0.7),
            at(0.2) + gap,
            at(0.2)
        );
        let s = solve(read(&text));
        let heat = s.report.heat.as_ref().unwrap();
        let of =
            |name: &str| heat.rows.iter().filter(|r| r.name.starts_with(name)).map(|r| r.power).sum::<f64>();
        [of("body"), of("room")]
    };
    let black_body = 0.5 * 5.670374419e-8 * (800f64.powi(4) - 300f64.powi(4));
    // Five faces and four sides shorter by the depth, or six faces.
    for scale in [1.0, 1000.0] {
        let gaps = [-1e-3f64, -1e-5, -1e-6, -2e-7, 0.0, 5e-7, 1e-6].map(|g| g * scale);
        let sample: &[usize] = if scale == 1.0 { &[0, 2, 4, 6] } else { &[3, 5] };
        for gap in sampled_cases(gaps, sample) {
            let exact = black_body * (0.48 * scale * scale + 1.6 * scale * gap.min(0.0));
            let [body, room] = heat(gap, scale);
            assert!((body - exact).abs() < 5e-3 * exact, "gap {gap}: body {body} W, exact {exact} W");
            assert!((room + exact).abs() < 5e-3 * exact, "gap {gap}: room {room} W, exact {exact} W");
        }
        let exact = black_body * 0.64 * scale * scale;
        let [body, _] = heat(4e-6 * scale, scale);
        assert!((body - exact).abs() < 5e-3 * exact, "gap 4e-6: body {body} W, exact {exact} W");
    }
}
