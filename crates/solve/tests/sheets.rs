//! Sheets that transmit diffusely: closed forms, balance of power, engines against each other and against the path tracer.

use crate::common;

use common::{read, solve, solved};
use zonal_reference::path_tracer::{Detector, PathTracer, TracingAccuracy};
use zonal_scene::{Band, Bands, Solution};

/// Two chambers of a box of 1 × 1 × 2 m that a sheet divides at z = 1.
fn chambers(engine: &str, sheet: &str, [lower, upper]: [&str; 2]) -> String {
    let room = |name: &str, z: usize, walls: &str, open: &str| {
        format!(
            "[[surface]]\nname = \"{name}\"\nroom = {{ min = [0,0,{z}], max = [1,1,{}] }}\nomit = [\"{open}\"]\n{walls}\n",
            z + 1
        )
    };
    format!(
        "[solve]\ntolerance = 0.003\npatch_size = 0.25\nengine = \"{engine}\"\n{}{}[[surface]]\nname = \"sheet\"\n\
         rectangle = {{ origin = [0,0,1], edge1 = [1,0,0], edge2 = [0,1,0] }}\n{sheet}\n",
        room("lower", 0, lower, "z1"),
        room("upper", 1, upper, "z0")
    )
}

fn incident(s: &Solution, i: usize) -> Bands {
    s.fields.incident[i] + s.fields.direct_light(i)
}

/// The power that the walls of a name absorb, W.
fn absorbed(s: &Solution, name: &str) -> Bands {
    let rows = s.report.energy.absorbed_surfaces.iter();
    rows.filter(|r| r.0.starts_with(name)).map(|r| r.1).sum()
}

#[test]
fn a_sheet_between_black_chambers_has_closed_forms() {
    for (engine, most) in [("dense", 2e-4), ("rays", 6e-3)] {
        let sheet = "reflectance = [0.3, 0.05, 0]\ntransmittance = [0.3, 0.8, 1]";
        let s = solved(&chambers(engine, sheet, ["reflectance = 0\nemission = 1", "reflectance = 0"]));
        // H is 1 below the sheet and 0 above it: the sheet sees black walls alone.
        let (rho, tau) = (Bands::from_rgb([0.3, 0.05, 0.0]), Bands::from_rgb([0.3, 0.8, 1.0]));
        let close = |name: &str, found: Bands, exact: Bands| {
            let off = (found - exact).abs().max_element();
            assert!(off < most, "{engine}: {name} {found:?} for {exact:?}");
        };
        close("upper", absorbed(&s, "upper"), tau);
        close("sheet", absorbed(&s, "sheet"), 1.0 - rho - tau);
        for (i, p) in
            s.zones.patches.iter().enumerate().filter(|(_, p)| p.facet == s.scene.facets().len() - 1)
        {
            let below = p.normal.z < 0.0;
            close("H", incident(&s, i), if below { Bands::ONE } else { Bands::ZERO });
            close("B", s.fields.radiosity[i], if below { rho } else { tau });
        }
        assert!(s.report.energy.residual.all(|r| r.abs() < most), "{engine}: {:?}", s.report.energy.residual);
    }
}

#[test]
fn an_isothermal_enclosure_with_a_sheet_is_uniform() {
    // E = (1 − ρ − τ) of the sheet, (1 − ρ) of the walls.
    let walls = ["reflectance = 0.6\nemission = 0.4", "reflectance = 0.1\nemission = 0.9"];
    for (engine, most) in [("dense", 1e-4), ("rays", 6e-3)] {
        for [rho, tau] in [[0.2, 0.7], [0.45, 0.45], [0.6, 0.1], [0.1, 0.9]] {
            let sheet = format!(
                "reflectance = {rho}\ntransmittance = {tau}\nemission = {}",
                f64::max(1.0 - rho - tau, 0.0)
            );
            let s = solved(&chambers(engine, &sheet, walls));
            assert!(
                s.report.status.iter().all(|x| x.name() == "converged"),
                "{engine}: {:?}",
                s.report.status
            );
            for (i, b) in s.fields.radiosity.iter().enumerate() {
                assert!((b.first() - 1.0).abs() < most, "{engine} {rho} {tau}: zone {i} has {b:?}");
            }
        }
    }
}

/// A room with a lamp, sunlight, a tilted sheet of two triangles and fog.
const ROOM: &str = "[[surface]]\nname = \"room\"\nroom = { min = [0,0,0], max = [2,2,2] }\nreflectance = [0.7, 0.5, 0.3]\nomit = [\"z1\"]\n\
    [[surface]]\nname = \"lamp\"\nrectangle = { origin = [0.2,0.2,0.3], edge1 = [0.5,0,0], edge2 = [0,0.5,0] }\nreflectance = 0\nemission = [5, 9, 14]\n\
    [[surface]]\nname = \"leaf\"\ntriangle = { corners = [[0.3,0.4,1.2], [1.7,0.5,1.0], [0.8,1.8,1.4]] }\nreflectance = [0.1, 0.4, 0.05]\ntransmittance = [0.2, 0.5, 0.9]\n\
    [[light]]\nkind = \"sun\"\ndirection = [0.3, 0.2, -1]\nirradiance = [10, 9, 7]\n\
    [medium]\nmin = [0,0,0]\nmax = [2,2,2]\ncells = [4,4,4]\nextinction = [0.02, 0.05, 0.1]\nalbedo = 0.7\n";

#[test]
fn sheets_agree_with_the_path_tracer_in_all_engines_and_groups() {
    let text =
        |engine: &str| format!("[solve]\ntolerance = 0.01\npatch_size = 0.4\nengine = \"{engine}\"\n{ROOM}");
    let all: Vec<Solution> = ["dense", "rays"].map(|e| solve(read(&text(e)))).into();
    let s = &all[0];
    let leaf = s.scene.surfaces().iter().position(|x| x.name == "leaf").unwrap();
    // Both sides of the leaf, and the floor below it, as sums over zones.
    let part = |i: usize| {
        let p = &s.zones.patches[i];
        match () {
            () if p.surface == leaf => Some(usize::from(p.normal.z > 0.0)),
            () if p.normal.z > 0.9 && p.plate.centre().z == 0.0 => Some(2),
            () => None,
        }
    };
    let tracer = PathTracer::new(&s.scene);
    let accuracy = TracingAccuracy { relative: 0.008, max_paths: 4_000, ..TracingAccuracy::default() };
    let parts: Vec<(usize, usize)> = (0..s.zones.patches.len()).filter_map(|i| Some((i, part(i)?))).collect();
    let detectors: Vec<Detector> = parts.iter().map(|(i, _)| Detector::patch(&s.zones.patches[*i])).collect();
    let mut sums = [[Bands::ZERO; 4]; 3];
    for ((i, k), reading) in parts.into_iter().zip(tracer.measure(&detectors, &accuracy, 7)) {
        let (p, total) = (&s.zones.patches[i], reading.total);
        sums[k][0] += p.area * Bands::from_fn(|b| total[b].value);
        sums[k][1] += p.area * p.area * Bands::from_fn(|b| total[b].error.powi(2));
        for (x, s) in sums[k][2..].iter_mut().zip(&all) {
            *x += p.area * incident(s, i);
        }
    }
    for (k, [traced, square, dense, rays]) in sums.into_iter().enumerate() {
        for b in Band::all() {
            let most = 0.02 * traced[b] + 2.0 * square[b].sqrt();
            for found in [dense, rays] {
                assert!((found[b] - traced[b]).abs() < most, "{k} {b:?}: {} for {}", found[b], traced[b]);
            }
        }
    }
    for s in &all {
        let e = &s.report.energy;
        assert!(e.residual.all(|r| r.abs() < 0.01), "{:?}", e.residual);
        // Groups sum to the whole, the sun and the lamp.
        let groups: Bands = s.groups.iter().map(|g| g.incident.at(0) * g.incident_scale).sum();
        let off = (groups - s.fields.incident[0]).abs().max_element();
        assert!(s.groups.len() == 2 && off < 1e-5 * groups.max_element(), "{off}");
    }
}

#[test]
fn impossible_sheets_are_refused() {
    let refused = |keys: &str| {
        let text = format!(
            "[[surface]]\nname = \"leaf\"\nrectangle = {{ origin = [0,0,0], edge1 = [1,0,0], edge2 = [0,1,0] }}\n{keys}\n"
        );
        let read = zonal_io::input::parse_scene(&text, None, "test.toml");
        read.map(|_| ()).unwrap_err().to_string()
    };
    assert!(refused("reflectance = 0.6\ntransmittance = 0.5").contains("exceeds 1"));
    assert!(
        refused("reflectance = 0.3\ntransmittance = 0.5\nsides = \"front\"").contains("sides = \"both\"")
    );
    assert!(refused("reflectance = 0.3\ntransmittance = 1.5").contains("transmittance"));
}
