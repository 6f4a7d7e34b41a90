//! Scenes with mirrors against the whole scenes of which they are parts.

mod common;

use common::{read, solve, unlevels};
use zonal_math::Vec3;
use zonal_scene::{Band, Bands, Scene, Solution, Zones};

/// The size of the whole furnace, m, and its cells.
const SIZE: [f64; 3] = [1.2, 0.8, 0.6];
const CELLS: [usize; 3] = [6, 4, 3];

/// A furnace: a box of hot and reflecting walls with a glowing, scattering gas, even about the middle of x and y.
struct Furnace<'a> {
    /// Mirrors as lines of `[boundary]`, one of `x0`, `x1` and one of `y0`, `y1`; none for the whole.
    mirrors: &'a str,
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
            if self.mirrors.contains(&format!("{axis}0")) {
                lo[k] = 0.5 * SIZE[k];
            }
            if self.mirrors.contains(&format!("{axis}1")) {
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
            .filter(|f| self.mirrors.contains(**f))
            .map(|f| format!("{f:?}"))
            .collect();
        format!(
            "{}\n[boundary]\n{}\n[[surface]]\nname = \"f\"\nroom = {{ min = {lo:?}, max = {hi:?} }}\nomit = [{}]\n{}\n\
             [medium]\nmin = {lo:?}\nmax = {hi:?}\ncells = {cells:?}\n{}\n{}\n{}\n",
            self.settings,
            self.mirrors,
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
const LIGHT: Furnace = Furnace {
    mirrors: "",
    settings: "[solve]\npatch_rule = \"voxels\"\nresidual = 1e-13\nengine = \"spectral\"\nzone_basis = \"constant\"",
    walls: "reflectance = [0.4, 0.7, 0.1]\nemission = [1, 2, 0]\nfaces.z0 = { emission = 3, reflectance = 0.2 }",
    gas: "extinction = [0.7, 2.0, 0.0]\nalbedo = [0.6, 0.9, 0.0]\nemission = 0.5",
    middle: "[[medium.region]]\nbox = { min = [0.4, 0.2, 0.2], max = [0.8, 0.6, 0.6] }\nemission = 4",
    rest: "",
};

const THERMAL: Furnace = Furnace {
    settings: "mode = \"thermal\"\n[solve]\npatch_rule = \"voxels\"\nresidual = 1e-13\nengine = \"spectral\"\nzone_basis = \"constant\"\ndiscretization_error = false",
    walls: "temperature = 600\nemissivity = 0.8\nfaces.z0 = { temperature = 1300, emissivity = 0.6 }\nfaces.z1 = { heat_flux = 0, emissivity = 0.5 }",
    gas: "absorption = 0.8\nheat_source = 0",
    middle: "[[medium.region]]\nbox = { min = [0.4, 0.2, 0.2], max = [0.8, 0.6, 0.6] }\nheat_source = 5000",
    ..LIGHT
};

const CORNERS: [&str; 4] = [
    "x0 = \"mirror\"\ny0 = \"mirror\"",
    "x1 = \"mirror\"\ny1 = \"mirror\"",
    "x1 = \"mirror\"",
    "y0 = \"mirror\"",
];

fn centre(zones: &Zones, i: usize) -> (Vec3, Vec3) {
    match i.checked_sub(zones.voxel_offset()) {
        None => (zones.patches[i].plate.centre(), zones.patches[i].normal),
        Some(v) => match v.checked_sub(zones.voxels.len()) {
            None => (zones.voxels[v].centre, Vec3::ZERO),
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
            part.fields.incident[i] + part.fields.direct[i],
            whole.fields.incident[j] + whole.fields.direct[j],
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
        (p.escaped, w.escaped),
    ] {
        for b in Band::all() {
            let scale = w.emitted[b] + w.incoming[b];
            assert!((images * x[b] - y[b]).abs() <= tolerance * scale, "{x:?} {y:?}");
        }
    }
}

#[test]
fn parts_of_a_furnace_equal_the_whole_by_the_spectral_engine() {
    let open = Furnace { walls: "reflectance = 0.4\nemission = 1\nfaces.z1 = { emission = 0 }", ..LIGHT };
    for furnace in [LIGHT, open] {
        let whole = furnace.solve();
        for mirrors in CORNERS {
            let part = Furnace { mirrors, ..furnace }.solve();
            assert_eq!(part.report.engine, "spectral");
            let off = apart(&part, &whole);
            assert!(off < 1e-10, "{mirrors}: {off:e}");
            assert_same_powers(&part, &whole, 1e-11);
            assert!(part.report.warnings.iter().any(|w| w.code == "mirrors"), "{:?}", part.report.warnings);
            assert_eq!(part.report.counts[0], ("zones".to_string(), part.zones.len() as u64));
        }
    }
}
