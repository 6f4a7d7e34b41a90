//! Periodic scenes without a medium: ducts of infinite length.

use crate::common;

use common::{read, solve, solved};
use zonal_io::input::parse_scene;
use zonal_reference::crossed_strings::{Wall, view_factors};
use zonal_scene::thermal::blackbody_emissive_power;
use zonal_scene::{NoProgress, Solution};
use zonal_solve::areas::exchange_areas::{ExchangeAreaContents, ExchangeAreaSettings, ExchangeAreas};

/// The period along y, m.
const LENGTH: f64 = 0.7;

/// A wall from (x, z) to (x, z) that extends along y, as a surface; its front is to the left.
fn strip(name: &str, [p, q]: Wall, keys: &str) -> String {
    format!(
        "[[surface]]\nname = \"{name}\"\nrectangle = {{ origin = [{}, 0, {}], edge1 = [{}, 0, {}], edge2 = [0, {LENGTH}, 0] }}\n{keys}\n",
        p[0],
        p[1],
        q[0] - p[0],
        q[1] - p[1],
    )
}

/// A trapezoidal duct with a plate in the middle and a prism, as walls of the plane.
fn duct() -> Vec<(String, Wall)> {
    let ring = [[0.0, 0.0], [2.0, 0.0], [1.5, 1.0], [0.0, 1.2]];
    let mut walls: Vec<(String, Wall)> =
        (0..4).map(|k| (format!("wall{k}"), [ring[k], ring[(k + 1) % 4]])).collect();
    let prism = [[0.3, 0.3], [0.4, 0.6], [0.6, 0.35]];
    walls.extend((0..3).map(|k| (format!("prism{k}"), [prism[k], prism[(k + 1) % 3]])));
    walls.push(("plate".into(), [[0.9, 0.2], [1.0, 0.7]]));
    walls.push(("other side".into(), [[1.0, 0.7], [0.9, 0.2]]));
    walls
}

fn scene(walls: &[(String, Wall)], settings: &str, keys: impl Fn(&str) -> String) -> String {
    let walls: String = walls.iter().map(|(n, w)| strip(n, *w, &keys(n))).collect();
    format!("{settings}\n[boundary]\ny = \"periodic\"\nmin = [-1, 0, -1]\nmax = [3, {LENGTH}, 3]\n{walls}")
}

// Guards (numbers): a duct of infinite length has crossed strings, with obstructions.
#[test]
fn duct_areas_equal_crossed_strings() {
    let walls = duct();
    let want = view_factors(&walls.iter().map(|w| w.1).collect::<Vec<_>>());
    for size in [3.0, 0.4] {
        let text = scene(&walls, &format!("[solve]\npatch_size = {size}"), |_| String::new());
        let settings = ExchangeAreaSettings {
            contents: ExchangeAreaContents::Direct,
            ..ExchangeAreaSettings::default()
        };
        let areas = ExchangeAreas::compute(&read(&text), &settings, &NoProgress).unwrap();
        for (i, (from, [p, q])) in walls.iter().enumerate() {
            let length = (p[0] - q[0]).hypot(p[1] - q[1]);
            for (j, (to, _)) in walls.iter().enumerate() {
                let (got, radius) = areas.direct_between(from, to).unwrap();
                let want = LENGTH * length * want[i][j];
                assert!((got - want).abs() < 1e-10 && radius < 1e-9, "{from} {to}: {got} ± {radius} {want}");
            }
        }
        assert!(areas.direct.largest_row_defect() < 1e-9);
    }
    // The ends of a rectangular duct of 2 × 1 m: crossed strings by hand.
    let duct =
        [("f", [[0.0, 0.0], [2.0, 0.0]]), ("c", [[2.0, 1.0], [0.0, 1.0]])].map(|(n, w)| (n.to_string(), w));
    let text = scene(&duct, "[solve]\npatch_size = 9.0", |_| String::new());
    let areas = ExchangeAreas::compute(&read(&text), &ExchangeAreaSettings::default(), &NoProgress).unwrap();
    let (got, _) = areas.direct_between("f", "c").unwrap();
    assert!((got / LENGTH - (5f64.sqrt() - 1.0)).abs() < 1e-12, "{got}");
}

fn row(s: &Solution, name: &str) -> [f64; 2] {
    let rows = &s.report.heat.as_ref().unwrap().rows;
    rows.iter().find(|r| r.name == name).unwrap_or_else(|| panic!("no row {name}")).flux()
}

/// Two black plates of 2 m, 1 m apart, in cold surroundings.
#[test]
fn open_duct_loses_the_power_that_no_wall_receives() {
    let plates = [("hot", [[0.0, 0.0], [2.0, 0.0]]), ("cold", [[2.0, 1.0], [0.0, 1.0]])]
        .map(|(n, w)| (n.to_string(), w));
    let keys = |n: &str| format!("emissivity = 1\ntemperature = {}", if n == "hot" { 1000 } else { 500 });
    let s = solved(&scene(
        &plates,
        "mode = \"thermal\"\n[solve]\npatch_size = 0.3\ndiscretization_error = false",
        keys,
    ));
    assert_eq!(s.report.engine, "dense");
    let view = 0.5 * (5f64.sqrt() - 1.0);
    let [hot, cold] = [1000.0, 500.0].map(blackbody_emissive_power);
    for (name, want) in [("hot", hot - view * cold), ("cold", cold - view * hot)] {
        let [q, e] = row(&s, name);
        assert!((q - want).abs() <= 1e-9 * hot && e < 1e-6 * hot, "{name}: {q} ± {e}, {want}");
    }
    let escaped = s.report.energy.escaped.first() / (LENGTH * 2.0);
    assert!((escaped - (1.0 - view) * (hot + cold)).abs() < 1e-9 * hot, "{escaped}");
}

/// A box in a transparent medium has sums over images, without one it has strips.
#[test]
fn strips_equal_sums_over_images_in_a_transparent_medium() {
    let room = |rest: &str| {
        format!(
            "[solve]\nresidual = 1e-13\nengine = \"dense\"\n{rest}\n[[surface]]\nname = \"r\"\nroom = {{ min = [0,0,0], max = [0.8,{LENGTH},0.6] }}\nomit = [\"y0\", \"y1\"]\nreflectance = 0.6\nemission = 1\nfaces.x0 = {{ emission = 5 }}\n"
        )
    };
    let boundary = format!("[boundary]\ny = \"periodic\"\nmin = [0,0,0]\nmax = [0.8,{LENGTH},0.6]");
    let medium = format!(
        "patch_rule = \"voxels\"\n[boundary]\ny = \"periodic\"\n[medium]\nmin = [0,0,0]\nmax = [0.8,{LENGTH},0.6]\ncells = [4, 1, 3]\nextinction = 0"
    );
    let strips = solved(&room(&format!("patch_size = 0.2\n{boundary}")));
    let images = solved(&room(&medium));
    let n = strips.zones.patches.len();
    assert_eq!((n, images.zones.patches.len(), strips.report.engine.as_str()), (14, 14, "dense"));
    for i in 0..n {
        let j = (0..n)
            .find(|&j| {
                (strips.zones.patches[i].plate.centre() - images.zones.patches[j].plate.centre()).length()
                    < 1e-9
            })
            .unwrap();
        let (x, y) = (strips.fields.incident[i].first(), images.fields.incident[j].first());
        assert!((x / y - 1.0).abs() < 1e-10, "{i}: {x} {y}");
        let stated = strips.fields.error[i].first() + images.fields.error[j].first();
        assert!((x - y).abs() <= stated && stated < 1e-6 * y, "{i}: {x} {y} ± {stated}");
    }
}

/// Half a duct with a symmetry plane is the whole.
#[test]
fn symmetry_planes_and_periods_combine() {
    let keys = |n: &str| format!("reflectance = 0.3\nemission = {}", if n == "floor" { 4 } else { 1 });
    let wall = |n: &str, w: Wall| (n.to_string(), w);
    let whole = [
        wall("floor", [[-1.0, 0.0], [1.0, 0.0]]),
        wall("right", [[1.0, 0.0], [1.0, 1.0]]),
        wall("ceiling", [[1.0, 1.0], [-1.0, 1.0]]),
        wall("left", [[-1.0, 1.0], [-1.0, 0.0]]),
    ];
    let half = [
        wall("floor", [[0.0, 0.0], [1.0, 0.0]]),
        whole[1].clone(),
        wall("ceiling", [[1.0, 1.0], [0.0, 1.0]]),
    ];
    let settings = "[solve]\npatch_size = 0.25\nresidual = 1e-13";
    let a = solve(read(&scene(&whole, settings, keys)));
    let text = scene(&half, settings, keys).replace("[boundary]\n", "[boundary]\nx0 = \"symmetry\"\n");
    let b = solve(read(&text.replace("min = [-1,", "min = [0,")));
    let p =
        |s: &Solution| s.report.energy.absorbed_surfaces.iter().find(|x| x.0 == "ceiling").unwrap().1.first();
    assert!((2.0 * p(&b) / p(&a) - 1.0).abs() < 1e-11, "{} {}", p(&a), p(&b));
}

#[test]
fn scenes_that_are_no_ducts_are_refused() {
    let refusal = |text: &str| parse_scene(text, None, "test.toml").map(|_| ()).unwrap_err().to_string();
    let walls = duct();
    let plain = |n: &str| if n == "plate" { "sides = \"both\"".to_string() } else { String::new() };
    let text = scene(&walls, "", plain);
    assert!(read(&text).strip_axis() == Some(1));
    let e = refusal(&text.replace("y = \"periodic\"", "x = \"periodic\""));
    assert!(e.contains("along the whole period") && e.contains("surface 'wall0'"), "{e}");
    let e = refusal(&text.replace("y = \"periodic\"", "x = \"periodic\"\ny = \"periodic\""));
    assert!(e.contains("extinction may be 0"), "{e}");
    let e = refusal(&format!("{text}[[light]]\nkind = \"sky\"\nname = \"s\"\nradiance = 1\n"));
    assert!(e.contains("no periodic images"), "{e}");
    let e = refusal(&text.replace("min = [-1, 0, -1]\nmax = [3, 0.7, 3]\n", ""));
    assert!(e.contains("boundary.min"), "{e}");
    for (engine, want) in [("rays", "use the dense engine"), ("spectral", "there is no medium")] {
        let scene = read(&scene(&walls, &format!("[solve]\nengine = \"{engine}\""), |_| String::new()));
        let e = zonal_solve::solve(scene, 1 << 30, &NoProgress).unwrap_err().to_string();
        assert!(e.contains(want), "{e}");
    }
}
