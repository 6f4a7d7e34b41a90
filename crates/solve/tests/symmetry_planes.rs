//! Scenes with symmetry planes against the whole scenes of which they are parts.

use crate::common;

use common::{read, solve, unlevels};
use zonal_io::input::parse_scene;
use zonal_math::Vec3;
use zonal_scene::{Band, NoProgress, Scene, Solution, Zones};

/// The size of the whole furnace, m, and its cells.
const SIZE: [f64; 3] = [1.2, 0.8, 0.6];
const CELLS: [usize; 3] = [6, 4, 3];

/// A furnace: a box of hot and reflecting walls with a glowing, scattering gas, even about the middle of x and y.
struct Furnace<'a> {
    /// Symmetry planes as lines of `[boundary]`, one of `x0`, `x1` and one of `y0`, `y1`; none for the whole.
    symmetry_planes: &'a str,
    settings: &'a str,
    /// Keys of the walls and of the medium.
    walls: &'a str,
    gas: &'a str,
    /// A part of the middle, beside the gas everywhere.
    middle: &'a str,
    rest: &'a str,
}

impl Furnace<'_> {
    /// Lower and upper corner of the part.
    fn bounds(&self) -> [[f64; 3]; 2] {
        let (mut lo, mut hi) = ([0.0; 3], SIZE);
        for (k, axis) in ["x", "y"].into_iter().enumerate() {
            if self.symmetry_planes.contains(&format!("{axis}0")) {
                lo[k] = 0.5 * SIZE[k];
            }
            if self.symmetry_planes.contains(&format!("{axis}1")) {
                hi[k] = 0.5 * SIZE[k];
            }
        }
        [lo, hi]
    }

    fn text(&self) -> String {
        let [lo, hi] = self.bounds();
        let cells: Vec<usize> =
            (0..3).map(|k| (CELLS[k] as f64 * (hi[k] - lo[k]) / SIZE[k]).round() as usize).collect();
        let omit: Vec<String> = ["x0", "x1", "y0", "y1"]
            .iter()
            .filter(|f| self.symmetry_planes.contains(**f))
            .map(|f| format!("{f:?}"))
            .collect();
        format!(
            "{}\n[boundary]\n{}\n[[surface]]\nname = \"f\"\nroom = {{ min = {lo:?}, max = {hi:?} }}\nomit = [{}]\n{}\n\
             [medium]\nmin = {lo:?}\nmax = {hi:?}\ncells = {cells:?}\n{}\n{}\n{}\n",
            self.settings,
            self.symmetry_planes,
            omit.join(", "),
            self.walls,
            self.gas,
            self.middle,
            self.rest
        )
    }

    fn solve(&self) -> Solution {
        solve(read(&self.text()))
    }
}

/// A furnace in mode "light".
const LIT_FURNACE: Furnace = Furnace {
    symmetry_planes: "",
    settings: "[solve]\npatch_rule = \"voxels\"\nresidual = 1e-13\nengine = \"spectral\"\nzone_basis = \"constant\"",
    walls: "reflectance = [0.4, 0.7, 0.1]\nemission = [1, 2, 0]\nfaces.z0 = { emission = 3, reflectance = 0.2 }",
    gas: "extinction = [0.7, 2.0, 0.0]\nalbedo = [0.6, 0.9, 0.0]\nemission = 0.5",
    middle: "[[medium.region]]\nbox = { min = [0.4, 0.2, 0.2], max = [0.8, 0.6, 0.6] }\nemission = 4",
    rest: "",
};

const HEATED_FURNACE: Furnace = Furnace {
    settings: "mode = \"thermal\"\n[solve]\npatch_rule = \"voxels\"\nresidual = 1e-13\nengine = \"spectral\"\nzone_basis = \"constant\"\ndiscretization_error = false",
    walls: "temperature = 600\nemissivity = 0.8\nfaces.z0 = { temperature = 1300, emissivity = 0.6 }\nfaces.z1 = { heat_flux = 0, emissivity = 0.5 }",
    gas: "absorption = 0.8\nheat_source = 0",
    middle: "[[medium.region]]\nbox = { min = [0.4, 0.2, 0.2], max = [0.8, 0.6, 0.6] }\nheat_source = 5000",
    ..LIT_FURNACE
};

const CORNERS: [&str; 4] = [
    "x0 = \"symmetry\"\ny0 = \"symmetry\"",
    "x1 = \"symmetry\"\ny1 = \"symmetry\"",
    "x1 = \"symmetry\"",
    "y0 = \"symmetry\"",
];

fn centre(zones: &Zones, i: usize) -> (Vec3, Vec3) {
    match i.checked_sub(zones.voxel_offset()) {
        None => (zones.patches[i].plate.centre(), zones.patches[i].normal),
        Some(v) => match v.checked_sub(zones.voxels.len()) {
            None => (zones.voxels.at(v).centre, Vec3::ZERO),
            Some(p) => (zones.panes[p].plate.centre(), zones.panes[p].normal),
        },
    }
}

/// The zone of the whole at each zone of a part.
fn same_zones(part: &Solution, whole: &Solution) -> Vec<usize> {
    let at = |i: usize| {
        let (c, n) = centre(&part.zones, i);
        let near = |j: &usize| {
            let (d, m) = centre(&whole.zones, *j);
            (c - d).length() < 1e-7 && (n - m).length() < 1e-7
        };
        (0..whole.zones.len()).find(near).unwrap_or_else(|| panic!("no zone of the whole at {c:?}"))
    };
    (0..part.zones.len()).map(at).collect()
}

/// Largest relative difference of radiosity and incident flux of a part and its whole.
fn apart(part: &Solution, whole: &Solution) -> f64 {
    let mut worst = 0.0f64;
    for (i, j) in same_zones(part, whole).into_iter().enumerate() {
        for (a, b) in [
            (&part.fields.incident, &whole.fields.incident),
            (&part.fields.radiosity, &whole.fields.radiosity),
        ] {
            worst = a[i]
                .iter()
                .zip(b[j].iter())
                .fold(worst, |m, (x, y)| m.max((x - y).abs() / y.abs().max(1e-300)));
        }
    }
    worst
}

/// Root mean square over the zones of the difference of the incident fluxes of part and whole, over the whole's, and the same of the stated errors.
fn differs_by(part: &Solution, whole: &Solution) -> [f64; 2] {
    let (mut off, mut stated, mut all) = (0.0, 0.0, 0.0);
    for (i, j) in same_zones(part, whole).into_iter().enumerate() {
        let (x, y) = (
            part.fields.incident[i] + part.fields.direct_light(i),
            whole.fields.incident[j] + whole.fields.direct_light(j),
        );
        for b in Band::all() {
            off += (x[b] - y[b]).powi(2);
            stated += (part.fields.total_error(i)[b] + whole.fields.total_error(j)[b]).powi(2);
            all += y[b].powi(2);
        }
    }
    [(off / all).sqrt(), (stated / all).sqrt()]
}

/// Compares the powers of a part, times its images, with those of the whole.
fn assert_same_powers(part: &Solution, whole: &Solution, tolerance: f64) {
    let images = whole.zones.voxels.len() as f64 / part.zones.voxels.len() as f64;
    let (p, w) = (&part.report.energy, &whole.report.energy);
    for (x, y) in [
        (p.emitted, w.emitted),
        (p.incoming, w.incoming),
        (p.absorbed_volumes, w.absorbed_volumes),
        (p.absorbed_panes, w.absorbed_panes),
        (p.escaped, w.escaped),
    ] {
        for b in Band::all() {
            let scale = w.emitted[b] + w.incoming[b];
            assert!((images * x[b] - y[b]).abs() <= tolerance * scale, "{x:?} {y:?}");
        }
    }
}

// Guards (numbers): the part of a scene between symmetry planes has the solution of the whole, to 1e-10 by the spectral and the dense engine.
#[test]
fn parts_of_a_furnace_equal_the_whole_by_the_spectral_engine() {
    let open =
        Furnace { walls: "reflectance = 0.4\nemission = 1\nfaces.z1 = { emission = 0 }", ..LIT_FURNACE };
    for furnace in [LIT_FURNACE, open] {
        let whole = furnace.solve();
        for symmetry_planes in CORNERS {
            let part = Furnace { symmetry_planes, ..furnace }.solve();
            assert_eq!(part.report.engine, "spectral");
            let off = apart(&part, &whole);
            assert!(off < 1e-10, "{symmetry_planes}: {off:e}");
            assert_same_powers(&part, &whole, 1e-11);
            assert!(
                part.report.warnings.iter().any(|w| w.code == "symmetry-planes"),
                "{:?}",
                part.report.warnings
            );
            assert_eq!(part.report.counts[0], ("zones".to_string(), part.zones.len() as u64));
        }
    }
}

// Guards (numbers): the part of a scene between symmetry planes has the temperatures of the whole.
#[test]
fn parts_have_the_temperatures_of_the_whole() {
    let power = Furnace {
        walls: "temperature = 600\nemissivity = 0.8\nfaces.z0 = { net_power = 3000, emissivity = 0.6 }",
        ..HEATED_FURNACE
    };
    for (furnace, images_of_power) in [(HEATED_FURNACE, 1.0), (power, 4.0)] {
        let whole = furnace.solve();
        for symmetry_planes in [CORNERS[0], CORNERS[1]] {
            let walls = furnace.walls.replace("3000", &format!("{}", 3000.0 / images_of_power));
            let part = Furnace { symmetry_planes, walls: &walls, ..furnace }.solve();
            let [a, b] = [&part, &whole].map(|s| s.fields.heat.as_ref().unwrap());
            for (i, j) in same_zones(&part, &whole).into_iter().enumerate() {
                assert!((a.temperature[i] / b.temperature[j] - 1.0).abs() < 1e-10, "{symmetry_planes} {i}");
            }
            let [p, w] = [&part, &whole].map(|s| s.report.heat.as_ref().unwrap());
            for (x, y) in p
                .rows
                .iter()
                .filter(|r| !r.name.ends_with('0') || r.name.ends_with("z0"))
                .map(|r| (r, w.rows.iter().find(|q| q.name == r.name).unwrap()))
            {
                // Walls across x and y of the whole have two sides of which the part has one.
                let images = if x.name.contains("f.x") || x.name.contains("f.y") { 2.0 } else { 4.0 };
                assert!(
                    (images * x.power / y.power - 1.0).abs() < 1e-9 || y.power.abs() < 1e-6,
                    "{}: {} {}",
                    x.name,
                    x.power,
                    y.power
                );
            }
        }
    }
}

/// Bands coupled by temperature are solved by Newton's method.
#[test]
fn parts_with_coupled_bands_have_the_temperatures_of_the_whole() {
    let gas = Furnace {
        settings: "mode = \"thermal\"\n[solve]\npatch_rule = \"voxels\"\nresidual = 1e-12\nengine = \"dense\"\ndiscretization_error = false\n[thermal]\nweights = [[0.3], [0.5], \"rest\"]\nrange = [200, 3000]",
        gas: "absorption = [0.3, 2.0, 0.0]\nheat_source = 0",
        ..HEATED_FURNACE
    };
    let [part, whole] = [CORNERS[1], ""].map(|symmetry_planes| Furnace { symmetry_planes, ..gas }.solve());
    let [a, b] = [&part, &whole].map(|s| s.fields.heat.as_ref().unwrap());
    for (i, j) in same_zones(&part, &whole).into_iter().enumerate() {
        assert!((a.temperature[i] / b.temperature[j] - 1.0).abs() < 1e-9, "{i}");
    }
}

#[test]
fn linear_basis_keeps_the_symmetry() {
    let settings = LIT_FURNACE.settings.replace("constant", "linear");
    let linear = Furnace {
        settings: &settings,
        gas: "extinction = [4.0, 9.0, 0.5]\nalbedo = 0.7\nemission = 0.5",
        ..LIT_FURNACE
    };
    let [part, whole] = [CORNERS[1], ""].map(|symmetry_planes| Furnace { symmetry_planes, ..linear }.solve());
    let off = apart(&part, &whole);
    assert!(off < 1e-10, "{off:e}");
}

// Guards (numbers): the part of a scene between symmetry planes has the solution of the whole, to 1e-10 by the spectral and the dense engine.
#[test]
fn parts_of_a_furnace_equal_the_whole_by_the_dense_engine() {
    let settings = LIT_FURNACE.settings.replace("spectral", "dense");
    let dense = Furnace { settings: &settings, ..LIT_FURNACE };
    let whole = dense.solve();
    let spectral = Furnace { symmetry_planes: CORNERS[1], ..LIT_FURNACE }.solve();
    for symmetry_planes in [CORNERS[0], CORNERS[1]] {
        let part = Furnace { symmetry_planes, ..dense }.solve();
        assert_eq!(part.report.engine, "dense");
        let off = apart(&part, &whole);
        assert!(off < 1e-10, "{symmetry_planes}: {off:e}");
        assert_same_powers(&part, &whole, 1e-10);
        if symmetry_planes == CORNERS[1] {
            let off = apart(&part, &spectral);
            assert!(off < 1e-10, "{off:e}");
        }
    }
}

// Guards (numbers): the part of a scene between symmetry planes has the solution of the whole within the stated errors of the rays engine.
/// A block stands in the middle of the furnace, below a pane; the part has a quarter of both, which the symmetry planes cut.
#[test]
fn parts_with_obstacles_equal_the_whole_within_the_stated_errors() {
    for engine in ["dense", "rays"] {
        let settings = format!("[solve]\npatch_size = 0.3\nengine = \"{engine}\"\ntolerance = 0.02");
        let block = |hi: [f64; 3]| {
            format!(
                "[[surface]]\nname = \"block\"\nbox = {{ min = [0.45, 0.25, 0.1], max = {hi:?} }}\nreflectance = 0.3\nemission = 2\n\
                 [[pane]]\npolygon = [[0.3, 0.2, 0.45], [{x}, 0.2, 0.45], [{x}, {y}, 0.45], [0.3, {y}, 0.45]]\nthickness = 0.01\nextinction = 80\nemission = 1\n",
                // The pane above the block ends at the symmetry planes too.
                x = if hi[0] < 0.7 { 0.6 } else { 0.9 },
                y = if hi[1] < 0.5 { 0.4 } else { 0.6 },
            )
        };
        let [quarter, all] = [block([0.6, 0.4, 0.35]), block([0.75, 0.55, 0.35])];
        let furnace = Furnace { settings: &settings, ..LIT_FURNACE };
        let whole = Furnace { rest: &all, ..furnace }.solve();
        let part = Furnace { rest: &quarter, symmetry_planes: CORNERS[1], ..furnace }.solve();
        assert_eq!(part.report.engine, engine);
        let block = |s: &Solution| {
            let k = s.scene.surfaces().iter().position(|x| x.name == "block").unwrap();
            s.zones.patches.iter().filter(|p| p.surface == k).map(|p| p.area).sum::<f64>()
        };
        assert!(
            (4.0 * block(&part) / block(&whole) - 1.0).abs() < 1e-9,
            "the cuts of the block are no walls"
        );
        let power = |s: &Solution| {
            let rows = s.report.energy.absorbed_surfaces.iter().zip(&s.report.energy_error.absorbed_surfaces);
            let (value, error) = { rows }.find(|r| r.0.0 == "f.z0").map(|(v, e)| (v.1, e.1)).unwrap();
            (value, error)
        };
        let ((x, dx), (y, dy)) = (power(&part), power(&whole));
        for b in Band::all() {
            assert!(
                (4.0 * x[b] - y[b]).abs() <= 4.0 * dx[b] + dy[b],
                "{engine}: {x:?} ± {dx:?}, {y:?} ± {dy:?}"
            );
            assert!(4.0 * dx[b] < 0.05 * y[b], "{engine}: {x:?} ± {dx:?}");
        }
        assert_same_powers(&part, &whole, 0.02);
    }
}

#[test]
fn direct_light_has_mirror_images() {
    let lamp = |lo: [f64; 2], size: [f64; 2]| {
        format!(
            "[[surface]]\nname = \"lamp\"\nrectangle = {{ origin = [{}, {}, 0.5], edge1 = [0, {}, 0], edge2 = [{}, 0, 0] }}\nemission = 30\n[[light]]\nkind = \"emitter\"\nsurface = \"lamp\"\n",
            lo[0], lo[1], size[1], size[0]
        )
    };
    let sun = |k: usize, d: [f64; 3]| {
        format!("[[light]]\nkind = \"sun\"\nname = \"sun{k}\"\ndirection = {d:?}\nirradiance = 2\n")
    };
    let sky = "[[light]]\nkind = \"sky\"\nname = \"sky\"\nradiance = 0.3\n";
    // The roof is missing; a sun stands in the plane of the symmetry plane y1, so that it has two images.
    let suns: String = (0..2).map(|k| sun(k, [[0.4, -0.4][k], 0.0, -1.0])).collect();
    for engine in ["dense", "rays"] {
        let settings = format!("[solve]\npatch_size = 0.2\nengine = \"{engine}\"\ntolerance = 0.02");
        let open = Furnace {
            settings: &settings,
            walls: "reflectance = 0.4\nemission = 0",
            gas: "extinction = 0.4\nalbedo = 0.7",
            middle: "",
            ..LIT_FURNACE
        };
        let all = [lamp([0.4, 0.2], [0.4, 0.4]), suns.clone(), sky.to_string()].concat();
        let own = [lamp([0.4, 0.2], [0.2, 0.2]), sun(0, [0.4, 0.0, -1.0]), sky.to_string()].concat();
        let roofless = |f: Furnace| {
            let text = f.text().replace("omit = [", "omit = [\"z1\", ").replace(", ]", "]");
            solve(read(&text))
        };
        let whole = roofless(Furnace { rest: &all, ..open });
        let part = roofless(Furnace { rest: &own, symmetry_planes: CORNERS[1], ..open });
        let [off, stated] = differs_by(&part, &whole);
        assert!(off <= stated && stated < 0.1, "{engine}: {off:e} {stated:e}");
        let tolerance = 0.02;
        assert_same_powers(&part, &whole, tolerance);
        let of_suns = |s: &Solution| -> f64 { s.report.energy.incoming.first() };
        assert!((4.0 * of_suns(&part) / of_suns(&whole) - 1.0).abs() < tolerance);
    }
}

// Guards (numbers): isothermal parts between symmetry planes are uniform to 1e-12.
/// Uniform emission makes the radiation in a closed part uniform; rows of exchange areas close and are symmetric by construction.
#[test]
fn isothermal_parts_are_uniform() {
    let both = "x = \"symmetry\"\ny0 = \"symmetry\"";
    for engine in ["spectral", "dense"] {
        for symmetry_planes in [CORNERS[0], CORNERS[1], both] {
            let settings = LIT_FURNACE.settings.replace("spectral", engine);
            let text = Furnace {
                symmetry_planes,
                settings: &settings,
                walls: "reflectance = 0.5\nemission = 1",
                gas: "extinction = [0.0, 0.3, 4.0]\nalbedo = 0.6\nemission = 2",
                middle: "",
                ..LIT_FURNACE
            }
            .text()
            .replace("omit = [\"y0\"]", "omit = [\"x0\", \"x1\", \"y0\"]");
            let s = solve(read(&text));
            let off = unlevels(&s, 2.0).iter().fold(0.0f64, |m, x| m.max(*x));
            let limit = if engine == "spectral" { 1e-12 } else { 1e-10 };
            assert!(off < limit, "{engine} {symmetry_planes}: {off:e}");
            assert!(s.report.closure.worst.iter().all(|d| *d < limit), "{:?}", s.report.closure);
        }
    }
}

/// A slab between two pairs of symmetry planes is a slab of infinite extent, as the periodic one.
#[test]
fn symmetry_planes_at_both_ends_equal_a_period_of_twice_the_extent() {
    let room = |engine: &str, boundary: &str, length: f64, cells: usize| {
        read(&format!(
            "[solve]\npatch_rule = \"voxels\"\nresidual = 1e-13\nengine = \"{engine}\"\nzone_basis = \"constant\"\n[boundary]\nx = \"{boundary}\"\n\
             [[surface]]\nname = \"d\"\nroom = {{ min = [0,0,0], max = [{length},0.8,0.6] }}\nomit = [\"x0\", \"x1\"]\nreflectance = 0.4\nemission = 1\n\
             [medium]\nmin = [0,0,0]\nmax = [{length},0.8,0.6]\ncells = [{cells},4,3]\nextinction = [0.7, 0.0, 3.0]\nalbedo = 0.5\n\
             [[medium.region]]\nbox = {{ min = [0,0,0], max = [0.2,0.4,0.4] }}\nemission = 5\n\
             {}",
            // The mirror image of the region.
            match length > 2.0 {
                true => "[[medium.region]]\nbox = { min = [2,0,0], max = [2.2,0.4,0.4] }\nemission = 5\n",
                false => "",
            }
        ))
    };
    let whole = solve(room("spectral", "periodic", 2.2, 22));
    for engine in ["spectral", "dense"] {
        let part = solve(room(engine, "symmetry", 1.1, 11));
        let off = apart(&part, &whole);
        assert!(off < 1e-10, "{engine}: {off:e}");
    }
    let refused = zonal_solve::solve(room("rays", "symmetry", 1.1, 11), 4 << 30, &NoProgress).unwrap_err();
    assert_eq!(refused.key(), "boundary");
    assert!(refused.message().contains("symmetry planes that face each other"), "{refused}");
}

#[test]
fn checkpoints_and_threads_keep_the_bits() {
    let furnace = Furnace { symmetry_planes: CORNERS[0], ..LIT_FURNACE };
    let scene: Scene = read(&furnace.text());
    let [(a, _), (b, _)] = [1, 3].map(|n| common::on_threads(&scene, n));
    assert_eq!(a, b);
}

fn refusal(text: &str) -> String {
    parse_scene(text, None, "test.toml").unwrap_err().to_string()
}

#[test]
fn invalid_symmetry_planes_are_refused() {
    let plate = |x: f64| {
        format!(
            "[[surface]]\nname = \"p\"\nrectangle = {{ origin = [{x},0,0], edge1 = [0,1,0], edge2 = [0,0,1] }}\n"
        )
    };
    let boundary = "[boundary]\nx0 = \"symmetry\"\n";
    let vacuum = "min = [0,0,0]\nmax = [1,1,1]\n";
    for (text, want) in [
        (format!("{boundary}{}", plate(0.5)), "boundary.min"),
        (format!("{boundary}{vacuum}{}", plate(-0.5)), "reaches beyond the symmetry plane"),
        (format!("{boundary}{vacuum}{}", plate(0.0)), "lies in the symmetry plane"),
        (format!("{boundary}x = \"periodic\"\n{vacuum}{}", plate(0.5)), "add a [medium]"),
        (format!("[boundary]\nx = \"symmetry\"\n{vacuum}{}", plate(0.5)), "between two symmetry planes"),
        (format!("[boundary]\n{vacuum}{}", plate(0.5)), "no end is a symmetry plane"),
        (format!("[boundary]\nx0 = \"symmetry\"\nmin = [0,0,0]\n{}", plate(0.5)), "both corners"),
        (
            format!("[boundary]\nx0 = \"symmetry\"\nmin = [0,0,0]\nmax = [0,1,1]\n{}", plate(0.5)),
            "min below max",
        ),
        (
            format!(
                "{boundary}{vacuum}{}[[light]]\nkind = \"sun\"\nname = \"s\"\ndirection = [1, 0, -1]\nirradiance = 1\n",
                plate(0.5)
            ),
            "behind the symmetry plane",
        ),
        (format!("[boundary]\nx0 = \"miror\"\n{}", plate(0.5)), "symmetry"),
    ] {
        let got = refusal(&text);
        assert!(got.contains(want) && got.contains("test.toml"), "{text}\n{got}");
    }
}
