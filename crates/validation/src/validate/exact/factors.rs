//! Sections 1 to 4: factors and exchange areas with closed forms, mean beam lengths.

use crate::validate::box_scene::BoxScene;
use crate::validate::case::{AcceptanceLimit, CaseOutcome, ValidationCase};
use crate::validate::case_context::CaseContext;
use crate::validate::data::{PrintedNumber, table};
use crate::validate::measures::WallMeans;
use std::f64::consts::PI;
use zonal_exchange::aligned::{Cuboid, geometric_factor};
use zonal_exchange::{AccuracyRequest, ZoneShape, factor};
use zonal_math::{Vec3, vec3};
use zonal_paper::proposition1;
use zonal_report::Failure;
use zonal_scene::Plate;

/// Relative limit for closed forms.
pub(crate) const CLOSED_FORM_TOLERANCE: f64 = 1e-9;
/// Relative tolerance requested of the program.
const REQUESTED_TOLERANCE: f64 = 1e-12;

/// The cases.
pub(crate) const CASES: [ValidationCase; 7] = [
    ValidationCase {
        name: "view-factors",
        group: "1 View factors",
        title: "opposed and perpendicular rectangles",
        about: "Configuration factors of two rectangles (catalogue entries C-11 and C-14) from the exchange area divided by the area. Limit: 10⁻⁹ relative.",
        quick: true,
        needs: None,
        run: view_factors,
    },
    ValidationCase {
        name: "fds-box",
        group: "1 View factors",
        title: "FDS, radiation_in_a_box",
        about: "An element of 0.1 mm on one face of a unit cube, on its diagonal, and the opposite face. The table prints four digits: limit 10⁻⁴.",
        quick: true,
        needs: None,
        run: fds_box,
    },
    ValidationCase {
        name: "fds-plates",
        group: "1 View factors",
        title: "FDS, plate_view_factor and TC_view_factor",
        about: "A plate at 1000 °C, 1 m from a black element, and a bead in a cube of which one half is hot. The closed form of the strip is σT⁴/√2 = 105.34 kW/m², that of the disc σT⁴/2 = 74.49, \
            and that of the square is 82.55: the values printed for the disc and the square are 0.5 % and 0.9 % below them, so these two rows are informational.",
        quick: true,
        needs: None,
        run: fds_plates,
    },
    ValidationCase {
        name: "volumes",
        group: "2 Volume integrals",
        title: "two unit cubes without attenuation, and Proposition 1's constant",
        about: "F(u) = ∬ dV dV/(πr²) for cubes at the offset u; C(u) of Proposition 1; F πu², by which the formula at the centres is off. Limit: 10⁻⁹ relative, or half a unit of the last \
            printed place where that is more.",
        quick: true,
        needs: None,
        run: volumes,
    },
    ValidationCase {
        name: "cube-areas",
        group: "3 Exchange areas of a cube",
        title: "gas and walls of a unit cube, neighbouring cubes",
        about: "All exchange areas of a cube of one medium as single zones, and of two cubes some cells apart. Limit: 10⁻⁹ relative, or half a unit of the last printed place where that is more.",
        quick: true,
        needs: None,
        run: cube_areas,
    },
    ValidationCase {
        name: "hot-cube",
        group: "3 Exchange areas of a cube",
        title: "isothermal hot cube between cold walls, any zoning",
        about: "The sum over zones must reproduce the single zone: the mean flux of the walls of a cube of n³ voxels is gs(K), whatever n, through the whole pipeline by the dense and the spectral engine.",
        quick: true,
        needs: None,
        run: hot_cube,
    },
    ValidationCase {
        name: "beam-lengths",
        group: "4 Mean beam lengths",
        title: "the thin limit 4V/A, and the emissivity of a sphere",
        about: "The thin limit from a cube at KL = 10⁻⁷ and a layer. A sphere is no box: its share of each voxel emits and absorbs, a boundary as soft as a voxel is wide, which costs an error of about \
            (κh)² ln(κh); from 16 to 81 voxels across, extrapolated, to 0.2 %.",
        quick: false,
        needs: None,
        run: beam_lengths,
    },
];

/// The limit of a closed form as it is printed.
pub(crate) fn printed_limit(p: PrintedNumber) -> AcceptanceLimit {
    if p.half > CLOSED_FORM_TOLERANCE * p.value.abs() {
        AcceptanceLimit::Absolute(p.half)
    } else {
        AcceptanceLimit::Relative(CLOSED_FORM_TOLERANCE)
    }
}

fn cube(x: f64, y: f64, z: f64) -> Cuboid {
    let lo = vec3(x, y, z);
    Cuboid::voxel(lo, lo + Vec3::splat(1.0))
}

fn value(a: &Cuboid, b: &Cuboid, kappa: f64) -> f64 {
    geometric_factor(a, b, kappa, REQUESTED_TOLERANCE).bounded.value
}

fn view_factors(_: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    for row in table!("view_factors.csv")?.rows() {
        let [a, b, c] = [row.number("a")?, row.number("b")?, row.number("c")?];
        let kind = row.text("kind")?;
        let (p, q) = if kind == "C-11" {
            let at = |z: f64, sign| Cuboid::patch(vec3(0.0, 0.0, z), vec3(a, b, z), 2, sign);
            (at(0.0, 1), at(c, -1))
        } else {
            let floor = Cuboid::patch(Vec3::ZERO, vec3(b, c, 0.0), 2, 1);
            (floor, Cuboid::patch(Vec3::ZERO, vec3(0.0, c, a), 0, 1))
        };
        let f = value(&p, &q, 0.0) / p.measure();
        let names = if kind == "C-11" { ["a", "b", "c"] } else { ["h", "w", "l"] };
        out.check(
            format!("{kind}, {} = {a}, {} = {b}, {} = {c}", names[0], names[1], names[2]),
            row.number("value")?,
            f,
            printed_limit(row.printed("value")?),
        );
    }
    Ok(out)
}

/// Edge of an element, m.
const ELEMENT_EDGE: f64 = 1e-4;

fn fds_box(_: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let face = Cuboid::patch(vec3(1.0, 0.0, 0.0), vec3(1.0, 1.0, 1.0), 0, -1);
    for row in table!("fds_box.csv")?.rows() {
        let at = row.number("at")?;
        let (lo, hi) = (at - 0.5 * ELEMENT_EDGE, at + 0.5 * ELEMENT_EDGE);
        let element = Cuboid::patch(vec3(0.0, lo, lo), vec3(0.0, hi, hi), 0, 1);
        let f = value(&element, &face, 0.0) / element.measure();
        out.check(
            format!("element at y = z = {at}"),
            row.number("value")?,
            f,
            AcceptanceLimit::Absolute(1e-4),
        );
    }
    Ok(out)
}

/// kW/m² of a black plate at 1273.15 K.
fn hot_plate() -> f64 {
    STEFAN_BOLTZMANN * 1273.15f64.powi(4) / 1e3
}

/// The Stefan–Boltzmann constant, W/(m² K⁴).
pub(crate) const STEFAN_BOLTZMANN: f64 = 5.670374419184429e-8;

fn fds_plates(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let half = 0.5 * ELEMENT_EDGE;
    let element = Cuboid::patch(vec3(-half, -half, 0.0), vec3(half, half, 0.0), 2, 1);
    let rectangle = |x: f64, y: f64| Cuboid::patch(vec3(-x, -y, 1.0), vec3(x, y, 1.0), 2, -1);
    let flux = |f: f64| hot_plate() * f / element.measure();
    // The disc as triangles about its centre, seen from below.
    const DISC_TRIANGLES: usize = 720;
    let rim = |k: usize| {
        let turn = 2.0 * PI * k as f64 / DISC_TRIANGLES as f64;
        vec3(turn.cos(), turn.sin(), 1.0)
    };
    let demand = AccuracyRequest { tolerance: 1e-8, max_evaluations: 1_000_000 };
    let disc: f64 = (0..DISC_TRIANGLES)
        .map(|k| {
            let part = Plate::triangle(vec3(0.0, 0.0, 1.0), rim(k + 1), rim(k));
            factor(&ZoneShape::Box(element), &ZoneShape::Plate(part), 0.0, demand).bounded.value
        })
        .sum();
    let bead = bead(bench)?;
    for row in table!("fds.csv")?.rows() {
        let (name, p) = (row.text("quantity")?, row.printed("value")?);
        let exactly = AcceptanceLimit::Absolute(p.half);
        let (ours, limit) = match name {
            "strip 2 m wide" => (flux(value(&element, &rectangle(1.0, 1e4), 0.0)), exactly),
            "square 2 m x 2 m" => (flux(value(&element, &rectangle(1.0, 1.0), 0.0)), AcceptanceLimit::None),
            "disc 2 m across" => (flux(disc), AcceptanceLimit::None),
            _ => (bead, exactly),
        };
        let unit = if name.starts_with("bead") { "°C" } else { "kW/m²" };
        out.check(format!("{name}, {unit}"), p.value, ours, limit);
    }
    Ok(out)
}

/// The temperature of a small black box in the middle of a cube of which the half x < ½ has 293.15 K and the other 773.15 K, °C.
fn bead(bench: &CaseContext) -> Result<f64, Failure> {
    let mut text = String::from("name = \"bead\"\n\n[solve]\npatch_size = 1\nengine = \"dense\"\n");
    for (k, t) in [293.15f64, 773.15].into_iter().enumerate() {
        let (lo, hi) = (0.5 * k as f64, 0.5 * (k + 1) as f64);
        let gone = if k == 0 { "x1" } else { "x0" };
        text += &format!(
            "\n[[surface]]\nname = \"half{k}\"\nroom = {{ min = [{lo:?}, 0, 0], max = [{hi:?}, 1, 1] }}\nomit = [\"{gone}\"]\nreflectance = 0\nemission = {:?}\n",
            STEFAN_BOLTZMANN * t.powi(4)
        );
    }
    text += "\n[[surface]]\nname = \"bead\"\nbox = { min = [0.499, 0.499, 0.499], max = [0.501, 0.501, 0.501] }\nreflectance = 0\n";
    let s = bench.solve("fds-bead", &text)?;
    Ok((WallMeans::of(&s, "bead").incident / STEFAN_BOLTZMANN).powf(0.25) - 273.15)
}

fn volumes(_: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    for row in table!("volumes.csv")?.rows() {
        let u = [row.number("x")?, row.number("y")?, row.number("z")?];
        let f = value(&cube(0.0, 0.0, 0.0), &cube(u[0], u[1], u[2]), 0.0);
        let name = format!("({}, {}, {})", u[0], u[1], u[2]);
        let p = row.printed("factor")?;
        out.check(format!("F{name}"), p.value, f, printed_limit(p));
        let c = row.printed("constant")?;
        let ours = proposition1::centre_constant(u.map(|x| x as i32)).value;
        out.check(format!("C{name}"), c.value, ours, printed_limit(c));
        if let Some(p) = row.optional("point")? {
            let square: f64 = u.iter().map(|x| x * x).sum();
            out.check(format!("F πu² {name}"), p.value, f * PI * square, printed_limit(p));
        }
    }
    Ok(out)
}

fn cube_areas(_: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let gas = cube(0.0, 0.0, 0.0);
    let walls = gas.walls();
    for row in table!("cube_areas.csv")?.rows() {
        let k = row.number("K")?;
        let gs = k * value(&gas, &walls[0], k);
        let ours = [
            ("gg", k * k * value(&gas, &gas, k)),
            ("gs", gs),
            ("opposite", value(&walls[0], &walls[1], k)),
            ("adjacent", value(&walls[0], &walls[2], k)),
            ("beam", -(-gs).ln_1p() / k),
        ];
        for (column, value) in ours {
            let p = row.printed(column)?;
            out.check(format!("K = {k}: {column}"), p.value, value, printed_limit(p));
        }
    }
    for row in table!("neighbours.csv")?.rows() {
        let k = row.number("K")?;
        let u = [row.number("x")?, row.number("y")?, row.number("z")?];
        let ours = k * k * value(&gas, &cube(u[0], u[1], u[2]), k);
        let p = row.printed("gg")?;
        out.check(format!("K = {k}: gg ({}, {}, {})", u[0], u[1], u[2]), p.value, ours, printed_limit(p));
    }
    Ok(out)
}

fn hot_cube(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    for row in table!("cube_areas.csv")?.rows() {
        let (k, p) = (row.number("K")?, row.printed("gs")?);
        if ![0.1, 1.0, 5.0].contains(&k) {
            continue;
        }
        for (n, engine) in [(1, "dense"), (5, "dense"), (5, "spectral"), (16, "spectral")] {
            let name = format!("hot-cube-{k}-{n}-{engine}");
            let room = BoxScene::new([1.0; 3], [n; 3], k)
                .medium("emission = 1")
                .solve(&format!("engine = \"{engine}\""));
            let s = bench.solve(&name, &room.text(&name))?;
            let ours = WallMeans::of(&s, "").incident;
            out.check(
                format!("K = {k}, {n}³ voxels, {engine}: wall flux/σT⁴"),
                p.value,
                ours,
                printed_limit(p),
            );
        }
    }
    Ok(out)
}

fn beam_lengths(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    const THIN_EXTINCTION: f64 = 1e-7;
    let mut out = CaseOutcome::default();
    let gas = cube(0.0, 0.0, 0.0);
    let length = |e: f64| -(-e).ln_1p() / THIN_EXTINCTION;
    let gs = THIN_EXTINCTION * value(&gas, &gas.walls()[0], THIN_EXTINCTION);
    out.check("cube, thin: Lm/L", 2.0 / 3.0, length(gs), AcceptanceLimit::Absolute(1e-6));
    let layer = bench.solve(
        "thin-layer",
        &BoxScene::layer(THIN_EXTINCTION, 1).medium("emission = 1").text("thin-layer"),
    )?;
    out.check(
        "layer, thin: Lm/L",
        2.0,
        length(WallMeans::of(&layer, "z0").incident),
        AcceptanceLimit::Absolute(1e-5),
    );
    super::sphere::check(bench, &mut out)?;
    Ok(out)
}
