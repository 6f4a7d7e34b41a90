//! Area sources, diffuse reflection and daylight after CIE 171:2006, against closed forms.
//!
//! The irradiance of a point of normal n by a polygon of uniform radiosity M is E = M F with Lambert's contour sum over its edges,
//!
//! ```text
//! F = |Σ θ_k n·(v_k × v_{k+1})/|v_k × v_{k+1}|| / (2π)      θ_k the angle between the vertices v_k and v_{k+1} as seen from the point
//! ```
//!
//! | case | test of the report | answer |
//! |---|---|---|
//! | luminous ceiling | area sources | E = M F |
//! | diffuse reflection | 5.6 | ρ E₀ F: parallel light on a diffuse surface, which lights a wall |
//! | diffuse reflection with an obstruction | 5.7 | ρ E₀ F of the part that the wall sees over a screen |
//! | sky component | 5.9, 5.11 | ∫ L(ω) cosθ dω over a roof opening or a window, with L by CIE S 011 |
//!
//! The report is sold, so that its drawings and tables are not reproduced here: dimensions are our own, the answers closed forms and quadratures. Its table of test 5.7 contains errors according to errata
//! of I. Ashdown (Lighting Analysts); the closed form takes its place. Patches have their exact means by midpoints.

use crate::validate::case::{CaseOutcome, ValidationCase};
use crate::validate::case_context::CaseContext;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Write as _;
use zonal_math::{Vec3, vec3};
use zonal_report::Failure;
use zonal_scene::{Patch, Solution};

/// Points along an edge of a patch for its exact mean.
const POINTS_PER_EDGE: usize = 12;
/// Points along an edge of an opening for the light through it.
const POINTS_OF_OPENING: usize = 48;
/// Cells along the angle from the zenith and around it for the irradiance of a whole sky.
const SKY_CELLS: usize = 400;
/// Largest differences of patches and of their mean, over the root mean square of the exact values.
const LIMITS: [f64; 2] = [5e-3, 5e-3];
/// Stated error that counts as rounding and as the error of the midpoints.
const MIN_STATED: f64 = 1e-4;
/// Radiosity of the ceiling and irradiance of the reflecting surface, W/m².
const FLUX: f64 = 100.0;
/// Reflectance of that surface.
const REFLECTANCE: f64 = 0.7;
/// Distance, m, of the screen from the wall, and its height.
const SCREEN: [f64; 2] = [0.5, 0.6];
/// Radiance of the zenith, W/(m² sr), and reflectance of the ground.
const ZENITH: f64 = 10.0;
const GROUND: f64 = 0.3;
/// Angle between the sun and the zenith, radians; it stands over x.
const SUN_ZENITH: f64 = 0.9;
/// Types of the sky with their parameters a, b, c, d, e.
const SKIES: [(usize, [f64; 5]); 5] = [
    (1, [4.0, -0.70, 0.0, -1.0, 0.0]),
    (4, [1.1, -0.8, 2.0, -1.5, 0.15]),
    (8, [0.0, -1.0, 10.0, -3.0, 0.45]),
    (12, [-1.0, -0.32, 10.0, -3.0, 0.45]),
    (15, [-1.0, -0.15, 24.0, -2.8, 0.15]),
];

/// The cases.
pub(crate) const CASES: [ValidationCase; 4] = [
    case(
        "luminous-ceiling",
        "illuminance below a luminous ceiling",
        "A black room of 4 m × 4 m × 3 m with a ceiling of uniform emission, as the area sources of CIE 171:2006, whose dimensions are not public. Lambert's contour sum, as the mean over each patch of floor and \
         walls. Limit: 0.5 % of the root mean square.",
        luminous_ceiling,
    ),
    case(
        "diffuse-reflection",
        "light reflected by a diffuse surface onto a wall",
        "Parallel light falls on a level surface of reflectance 0.7, which lights a black wall, as in test 5.6 of CIE 171:2006; dimensions are our own. Limit: 0.5 % of the root mean square.",
        |bench| reflection(bench, "diffuse-reflection", false),
    ),
    case(
        "diffuse-reflection-obstruction",
        "the same over a screen",
        "A black screen between surface and wall hides a part of the surface, as in test 5.7 of CIE 171:2006, whose printed table contains errors (errata of I. Ashdown); the closed form of the visible part takes its \
         place. Dimensions are our own. Limit: 0.5 % of the root mean square.",
        |bench| reflection(bench, "diffuse-reflection-obstruction", true),
    ),
    ValidationCase {
        quick: false,
        ..case(
            "sky-component",
            "sky component of openings for CIE skies",
            "A black room of 4 m × 4 m × 3 m with an opening of 1 m × 1 m and of 4 m × 4 m in the roof (test 5.9 of CIE 171:2006), or of 2 m × 1 m in a wall with light of the ground on the ceiling (5.11), under types 1, 4, 8, \
         12 and 15 of ISO 15469. Glazed openings and masks (5.10, 5.12 to 5.14) are left out: their glass and dimensions are not public. Quadrature over the opening. Limits: 0.5 % of the root \
         mean square, and twice the stated error.",
            sky_component,
        )
    },
];

const fn case(
    name: &'static str,
    title: &'static str,
    about: &'static str,
    run: fn(&CaseContext) -> Result<CaseOutcome, Failure>,
) -> ValidationCase {
    ValidationCase { name, group: "Lighting", title, about, quick: true, needs: None, run }
}

/// F of a polygon seen from a point with the unit normal `n`, which faces all of it.
fn configuration_factor(point: Vec3, n: Vec3, polygon: &[Vec3]) -> f64 {
    let edge = |k: usize| {
        let [a, b] = [polygon[k], polygon[(k + 1) % polygon.len()]].map(|v| (v - point).normalized());
        let across = a.cross(b);
        let length = across.length();
        if length > 0.0 { length.atan2(a.dot(b)) * n.dot(across) / length } else { 0.0 }
    };
    (0..polygon.len()).map(edge).sum::<f64>().abs() / TAU
}

/// The mean of `f` over a patch by midpoints.
fn mean_over(patch: &Patch, f: impl Fn(Vec3) -> f64) -> f64 {
    let n = POINTS_PER_EDGE;
    let at = |k: usize| (k as f64 + 0.5) / n as f64;
    (0..n * n).map(|k| f(patch.plate.at(at(k % n), at(k / n)))).sum::<f64>() / (n * n) as f64
}

/// Compares the irradiances of the patches of the surfaces `names` with `exact` of a point and its normal: single patches and their mean over the area, each with its limit over the
/// root mean square.
fn compare(
    out: &mut CaseOutcome,
    title: &str,
    s: &Solution,
    names: &[&str],
    [limit, mean_limit]: [f64; 2],
    exact: impl Fn(Vec3, Vec3) -> f64,
) {
    let (mut off, mut stated, mut level, mut sum, mut count) = (0.0f64, 0.0f64, 0.0f64, 0.0, 0.0f64);
    let own = |p: &&Patch| names.contains(&s.scene.surfaces()[p.surface].name.as_str());
    for (i, p) in s.zones.patches.iter().enumerate().filter(|(_, p)| own(p)) {
        let expected = mean_over(p, |x| exact(x, p.normal));
        let found = (s.fields.incident[i] + s.fields.direct_light(i)).first();
        let error = s.fields.error[i].first() + s.fields.direct_error.get(i).map_or(0.0, |e| e.first());
        (off, stated) = (off + (found - expected).powi(2), stated + error * error);
        (level, sum, count) = (level + expected * expected, sum + found - expected, count + 1.0);
    }
    let scale = level.sqrt().max(f64::MIN_POSITIVE);
    let (off, stated) = (off.sqrt() / scale, (stated.sqrt() / scale).max(MIN_STATED));
    out.error(format!("{title}: root mean square difference of {count} patches"), off, limit);
    out.error(format!("{title}: the same over the stated error, {stated:.1e}"), off / stated, 2.0);
    out.error(format!("{title}: difference of the mean"), sum / count.sqrt() / scale, mean_limit);
}

fn luminous_ceiling(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let text = format!(
        "name = \"luminous-ceiling\"\n\n[solve]\npatch_size = 0.5\n\n[[surface]]\nname = \"room\"\nroom = {{ min = [0, 0, 0], max = [4, 4, 3] }}\n\
         reflectance = 0\nfaces.z1 = {{ emission = {FLUX:?} }}\n\n[[light]]\nkind = \"emitter\"\nsurface = \"room.z1\"\n"
    );
    let s = bench.solve("luminous-ceiling", &text)?;
    let ceiling = rectangle(vec3(0.0, 0.0, 3.0), vec3(4.0, 0.0, 0.0), vec3(0.0, 4.0, 0.0));
    let exact = |x: Vec3, n: Vec3| FLUX * configuration_factor(x, n, &ceiling);
    compare(&mut out, "floor", &s, &["room.z0"], LIMITS, exact);
    compare(&mut out, "walls", &s, &["room.x0", "room.x1", "room.y0", "room.y1"], LIMITS, exact);
    Ok(out)
}

fn rectangle(origin: Vec3, edge1: Vec3, edge2: Vec3) -> [Vec3; 4] {
    [origin, origin + edge1, origin + edge1 + edge2, origin + edge2]
}

/// A level surface from x = 1 to 3 m before a wall at x = 0, and with `screened` a wide screen between them.
fn reflection(bench: &CaseContext, name: &str, screened: bool) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let [distance, height] = SCREEN;
    let mut text = format!(
        "name = \"{name}\"\n\n[solve]\npatch_size = 0.25\ntolerance = 0.003\n\n[[surface]]\nname = \"level\"\nreflectance = {REFLECTANCE:?}\n\
         rectangle = {{ origin = [1, -1.5, 0], edge1 = [2, 0, 0], edge2 = [0, 3, 0] }}\n\n[[surface]]\nname = \"wall\"\nreflectance = 0\n\
         rectangle = {{ origin = [0, -1.5, 0.05], edge1 = [0, 3, 0], edge2 = [0, 0, 2.5] }}\n\n[[light]]\nkind = \"sun\"\ndirection = [0, 0, -1]\n\
         angular_diameter = 0\nirradiance = {FLUX:?}\n"
    );
    if screened {
        let _ = write!(
            text,
            "\n[[surface]]\nname = \"screen\"\nreflectance = 0\nsides = \"both\"\npatch_size = 2\n\
             rectangle = {{ origin = [{distance:?}, -6, 0], edge1 = [0, 12, 0], edge2 = [0, 0, {height:?}] }}\n"
        );
    }
    let s = bench.solve(name, &text)?;
    let exact = |x: Vec3, n: Vec3| {
        // Behind the screen the surface begins where the line of sight over its edge meets it.
        if screened && x.z <= height {
            return 0.0;
        }
        let first = if screened { (distance * x.z / (x.z - height)).max(1.0) } else { 1.0 };
        if first >= 3.0 {
            return 0.0;
        }
        let seen = rectangle(vec3(first, -1.5, 0.0), vec3(3.0 - first, 0.0, 0.0), vec3(0.0, 3.0, 0.0));
        REFLECTANCE * FLUX * configuration_factor(x, n, &seen)
    };
    compare(&mut out, "wall", &s, &["wall"], LIMITS, exact);
    Ok(out)
}

/// An opening of the room.
struct Opening {
    name: &'static str,
    /// Corner, m, and edges.
    origin: Vec3,
    edges: [Vec3; 2],
    /// The parts of the roof or of the wall around it: corners and edges of rectangles that face the room.
    around: &'static [[[f64; 3]; 3]],
    /// The face of the room that it lies in, and the faces that are compared.
    face: &'static str,
    compared: &'static [&'static str],
}

const OPENINGS: [Opening; 3] = [
    Opening {
        name: "roof, 1 m x 1 m",
        origin: vec3(1.5, 1.5, 3.0),
        edges: [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)],
        around: &[
            [[0.0, 0.0, 3.0], [0.0, 4.0, 0.0], [1.5, 0.0, 0.0]],
            [[2.5, 0.0, 3.0], [0.0, 4.0, 0.0], [1.5, 0.0, 0.0]],
            [[1.5, 0.0, 3.0], [0.0, 1.5, 0.0], [1.0, 0.0, 0.0]],
            [[1.5, 2.5, 3.0], [0.0, 1.5, 0.0], [1.0, 0.0, 0.0]],
        ],
        face: "z1",
        compared: &["room.z0"],
    },
    Opening {
        name: "roof, 4 m x 4 m",
        origin: vec3(0.0, 0.0, 3.0),
        edges: [vec3(4.0, 0.0, 0.0), vec3(0.0, 4.0, 0.0)],
        around: &[],
        face: "z1",
        compared: &["room.z0"],
    },
    Opening {
        name: "wall, 2 m x 1 m",
        origin: vec3(4.0, 1.0, 1.0),
        edges: [vec3(0.0, 2.0, 0.0), vec3(0.0, 0.0, 1.0)],
        around: &[
            [[4.0, 0.0, 0.0], [0.0, 0.0, 3.0], [0.0, 1.0, 0.0]],
            [[4.0, 3.0, 0.0], [0.0, 0.0, 3.0], [0.0, 1.0, 0.0]],
            [[4.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 2.0, 0.0]],
            [[4.0, 1.0, 2.0], [0.0, 0.0, 1.0], [0.0, 2.0, 0.0]],
        ],
        face: "x1",
        compared: &["room.z0", "room.z1"],
    },
];

impl Opening {
    /// The scene of a type of sky.
    fn scene(&self, kind: usize) -> String {
        let (sin, cos) = SUN_ZENITH.sin_cos();
        let mut text = format!(
            "name = \"sky-component\"\n\n[solve]\npatch_size = 0.5\ntolerance = 0.003\n\n[[surface]]\nname = \"room\"\n\
             room = {{ min = [0, 0, 0], max = [4, 4, 3] }}\nomit = [\"{}\"]\nreflectance = 0\n\n[[light]]\nkind = \"cie-sky\"\ntype = {kind}\n\
             zenith_radiance = {ZENITH:?}\nground_reflectance = {GROUND:?}\ndirection = [{:?}, 0, {:?}]\n",
            self.face, -sin, -cos
        );
        for (k, [origin, edge1, edge2]) in self.around.iter().enumerate() {
            let _ = write!(
                text,
                "\n[[surface]]\nname = \"around{k}\"\nreflectance = 0\nsides = \"both\"\nrectangle = {{ origin = {origin:?}, edge1 = {edge1:?}, edge2 = {edge2:?} }}\n"
            );
        }
        text
    }

    /// Irradiance of a point of unit normal `n` through the opening, W/m².
    fn irradiance(&self, point: Vec3, n: Vec3, radiance: impl Fn(Vec3) -> f64) -> f64 {
        let count = POINTS_OF_OPENING;
        let at = |k: usize| (k as f64 + 0.5) / count as f64;
        let across = self.edges[0].cross(self.edges[1]);
        let one = |k: usize| {
            let to = self.origin + self.edges[0] * at(k % count) + self.edges[1] * at(k / count) - point;
            let r2 = to.length2();
            let d = to / r2.sqrt();
            radiance(d) * n.dot(d).max(0.0) * across.dot(d).abs() / r2
        };
        (0..count * count).map(one).sum::<f64>() / (count * count) as f64
    }
}

/// The radiance of the sky above the horizon by CIE S 011, W/(m² sr).
fn cie_radiance([a, b, c, d, e]: [f64; 5], direction: Vec3) -> f64 {
    let gradation = |cos: f64| 1.0 + a * (b / cos).exp();
    let indicatrix = |x: f64| 1.0 + c * ((d * x).exp() - (d * FRAC_PI_2).exp()) + e * x.cos().powi(2);
    let sun = vec3(SUN_ZENITH.sin(), 0.0, SUN_ZENITH.cos());
    let from_sun = direction.dot(sun).clamp(-1.0, 1.0).acos();
    ZENITH * indicatrix(from_sun) * gradation(direction.z) / (indicatrix(SUN_ZENITH) * gradation(1.0))
}

/// Irradiance of an unobstructed horizontal plane, W/m².
fn horizontal_irradiance(parameters: [f64; 5]) -> f64 {
    let n = SKY_CELLS;
    let mut sum = 0.0;
    for i in 0..n {
        let (sin, cos) = (FRAC_PI_2 * (i as f64 + 0.5) / n as f64).sin_cos();
        let of = |j: usize| {
            let (s, c) = (TAU * (j as f64 + 0.5) / n as f64).sin_cos();
            cie_radiance(parameters, vec3(sin * c, sin * s, cos))
        };
        sum += sin * cos * (0..n).map(of).sum::<f64>();
    }
    sum * FRAC_PI_2 * TAU / (n * n) as f64
}

fn sky_component(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    for (number, opening) in OPENINGS.iter().enumerate() {
        for (kind, parameters) in SKIES {
            let s = bench.solve(&format!("sky-component-{number}-{kind}"), &opening.scene(kind))?;
            let ground = GROUND * horizontal_irradiance(parameters) / PI;
            let radiance = |d: Vec3| if d.z > 0.0 { cie_radiance(parameters, d) } else { ground };
            let title = format!("{}, type {kind}", opening.name);
            compare(&mut out, &title, &s, opening.compared, LIMITS, |x, n| {
                opening.irradiance(x, n, radiance)
            });
        }
    }
    Ok(out)
}
