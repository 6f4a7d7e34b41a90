//! Point lights: illuminances on a plane and in a closed room, after CIE 171:2006.
//!
//! | case | answer |
//! |---|---|
//! | plane at distance h below a light of intensity I(γ) | E = I(γ) cos³γ/h², as the mean over each patch |
//! | closed cube of area A, reflectance ρ, light of flux Φ | mean illuminance Φ/(A (1 − ρ)) |
//!
//! The second holds for any distribution and any zones of one reflectance: the power of all reflections is a geometric series.

use crate::validate::case::{AcceptanceLimit, CaseOutcome, ValidationCase};
use crate::validate::case_context::CaseContext;
use std::fmt::Write as _;
use zonal_report::Failure;
use zonal_scene::Solution;

/// Luminous efficacy of the scenes, lm/W.
const EFFICACY: f64 = 683.0;
/// Height of the lights above the plane, m, and half its edge.
const HEIGHT: f64 = 3.0;
const HALF_EDGE: f64 = 4.0;
/// Intensity straight down, cd.
const CANDELAS: f64 = 1000.0;
/// Points along an edge of a patch for its exact mean.
const POINTS_PER_EDGE: usize = 40;
/// Edge, m, and flux, lm, of the closed cube.
const CUBE_EDGE: f64 = 4.0;
const LUMENS: f64 = 10_000.0;
const REFLECTANCES: [f64; 4] = [0.0, 0.5, 0.9, 0.95];

/// The cases.
pub(crate) const CASES: [ValidationCase; 2] = [
    ValidationCase {
        name: "point-source",
        group: "Lighting",
        title: "illuminance on a plane under a point light",
        about: "A plane of 8 m at 3 m below a light of 1000 cd: in all directions, and 1000 cos²γ from an .ies file in steps of 1°. Inverse square and cosine: I cos³γ/h², as the mean \
            over each patch of 0.5 m. Limit: 0.5 % in every patch, and the stated error twice covers the true one.",
        quick: true,
        needs: None,
        run: run_plane,
    },
    ValidationCase {
        name: "integrating-cube",
        group: "Lighting",
        title: "mean illuminance of a closed cube",
        about: "A cube of 4 m with a light of 10,000 lm, in its middle as in test 5.8 of CIE 171:2006, and a spot beside a wall: the mean illuminance is Φ/(A (1 − ρ)) whatever the \
            distribution. Limit: 10⁻⁶, for direct light is normalized by the power of the light and rows are closed.",
        quick: true,
        needs: None,
        run: run_cube,
    },
];

/// An .ies file of the intensities 1000 cos²γ cd.
fn ies_text() -> String {
    let gammas: Vec<f64> = (0..=90).map(f64::from).collect();
    let mut t = format!("IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 {} 1 1 2 0 0 0\n1 1 1\n", gammas.len());
    let _ = writeln!(t, "{}\n0", gammas.iter().map(|g| format!("{g}")).collect::<Vec<_>>().join(" "));
    for g in gammas {
        let _ = writeln!(t, "{:.6}", CANDELAS * g.to_radians().cos().powi(2));
    }
    t
}

/// Mean illuminance of every patch and its stated error, lx, with the exact mean for the intensity `candelas` of cosγ.
fn illuminances(s: &Solution, candelas: impl Fn(f64) -> f64) -> Vec<[f64; 3]> {
    let place = |k: usize| (k as f64 + 0.5) / POINTS_PER_EDGE as f64;
    let n = POINTS_PER_EDGE * POINTS_PER_EDGE;
    let of = |i: usize| {
        let plate = &s.zones.patches[i].plate;
        let exact = (0..n).map(|k| {
            let p = plate.at(place(k % POINTS_PER_EDGE), place(k / POINTS_PER_EDGE));
            let r2 = p.x * p.x + p.y * p.y + HEIGHT * HEIGHT;
            let cos = HEIGHT / r2.sqrt();
            candelas(cos) * cos / r2
        });
        let found = EFFICACY * s.fields.direct_light(i).first();
        let stated = s.fields.direct_error.get(i).map_or(0.0, |e| EFFICACY * e.first());
        [found, stated, exact.sum::<f64>() / n as f64]
    };
    (0..s.zones.patches.len()).map(of).collect()
}

fn run_plane(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let file = bench.text_file("cosine-squared.ies", &ies_text())?;
    let isotropic =
        format!("kind = \"point\"\nposition = [0, 0, {HEIGHT:?}]\nintensity = {:?}\n", CANDELAS / EFFICACY);
    let luminaire = format!("kind = \"luminaire\"\nposition = [0, 0, {HEIGHT:?}]\nfile = \"{file}\"\n");
    let flat: fn(f64) -> f64 = |_| CANDELAS;
    let squared: fn(f64) -> f64 = |cos| CANDELAS * cos * cos;
    for (name, light, candelas) in [("isotropic", isotropic, flat), ("cosine-squared", luminaire, squared)] {
        let edge = 2.0 * HALF_EDGE;
        let text = format!(
            "name = \"{name}\"\n\n[solve]\npatch_size = 0.5\n\n[[surface]]\nname = \"plane\"\nreflectance = 0\n\
             rectangle = {{ origin = [{:?}, {:?}, 0], edge1 = [{edge:?}, 0, 0], edge2 = [0, {edge:?}, 0] }}\n\n[[light]]\n{light}",
            -HALF_EDGE, -HALF_EDGE
        );
        let s = bench.solve(&format!("point-source-{name}"), &text)?;
        let list = illuminances(&s, candelas);
        let worst = list.iter().fold(0.0f64, |m, [found, _, exact]| m.max((found / exact - 1.0).abs()));
        out.error(format!("{name}: largest relative difference of a patch"), worst, 5e-3);
        let beyond =
            list.iter().filter(|[found, stated, exact]| (found - exact).abs() > 2.0 * stated + 1e-3 * exact);
        out.error(
            format!("{name}: share of patches beyond twice the stated error"),
            beyond.count() as f64 / list.len() as f64,
            0.05,
        );
        let total = |k: usize| list.iter().map(|v| v[k]).sum::<f64>() / list.len() as f64;
        out.check(
            format!("{name}: mean illuminance, lx"),
            total(2),
            total(0),
            AcceptanceLimit::Relative(1e-3),
        );
    }
    Ok(out)
}

fn run_cube(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let power = LUMENS / EFFICACY;
    let lights = [
        ("isotropic", format!("kind = \"point\"\nposition = [2, 2, 2]\npower = {power:?}\n")),
        (
            "spot",
            format!(
                "kind = \"spot\"\nposition = [0.5, 2.2, 3.1]\ndirection = [0.4, 0.1, -1]\ninner_angle = 15\nouter_angle = 35\npower = {power:?}\n"
            ),
        ),
    ];
    let area = 6.0 * CUBE_EDGE * CUBE_EDGE;
    for (name, light) in &lights {
        for rho in REFLECTANCES {
            let text = format!(
                "name = \"{name}\"\n\n[solve]\npatch_size = 0.5\nresidual = 1e-12\nclosure = \"restore\"\n\n[[surface]]\nname = \"walls\"\n\
                 room = {{ min = [0, 0, 0], max = [{CUBE_EDGE:?}, {CUBE_EDGE:?}, {CUBE_EDGE:?}] }}\nreflectance = {rho:?}\n\n[[light]]\n{light}"
            );
            let s = bench.solve(&format!("integrating-cube-{name}-{rho}"), &text)?;
            let watts = s
                .zones
                .patches
                .iter()
                .enumerate()
                .map(|(i, p)| p.area * (s.fields.incident[i] + s.fields.direct_light(i)).first());
            out.check(
                format!("{name}, reflectance {rho}: mean illuminance, lx"),
                LUMENS / (area * (1.0 - rho)),
                EFFICACY * watts.sum::<f64>() / area,
                AcceptanceLimit::Relative(1e-6),
            );
        }
    }
    Ok(out)
}
