//! Tables of goniometers of type A and B as tables of type C.
//!
//! With f the direction of aim, u up and r to the right, a direction of the angles H and V is
//!
//! ```text
//! type A, vertical polar axis:    cosV cosH f + cosV sinH r + sinV u
//! type B, horizontal polar axis:  cosH cosV f + cosH sinV u + sinH r
//! ```
//!
//! (ANSI/IES LM-75). In type C the aim is γ = 0, u lies in the plane C = 0° and r in C = 270°, as seen from behind a luminaire that is aimed horizontally. The table
//! is interpolated bilinearly at steps of at most those of the file; directions behind the luminaire and outside the angles of the file are dark.

use super::luminous_table::{AngleTable, LuminousTable};
use zonal_scene::PlaneSymmetry;

/// Range of the steps of γ, degrees, and the step of C.
const GAMMA_STEPS: [f64; 2] = [0.25, 2.5];
const PLANE_STEP: f64 = 5.0;
/// Deviation of an angle from its end that counts as rounding, degrees.
const END_ROUNDING: f64 = 0.01;

/// The axes of a goniometer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum GoniometerType {
    /// Vertical polar axis.
    A,
    /// Horizontal polar axis.
    B,
}

impl GoniometerType {
    /// H and V, degrees, of the direction of γ and C, degrees.
    fn angles(self, gamma: f64, c: f64) -> [f64; 2] {
        let (across, f) = gamma.to_radians().sin_cos();
        let (sin, u) = c.to_radians().sin_cos();
        let (r, u) = (-across * sin, across * u);
        let [h, v] = match self {
            GoniometerType::A => [r.atan2(f), u.clamp(-1.0, 1.0).asin()],
            GoniometerType::B => [r.clamp(-1.0, 1.0).asin(), u.atan2(f)],
        };
        [h.to_degrees(), v.to_degrees()]
    }
}

/// The table of type C; horizontal angles from 0 are mirrored.
pub(super) fn to_type_c(table: &AngleTable, kind: GoniometerType) -> Result<LuminousTable, String> {
    check(table)?;
    let is_mirrored = table.planes[0].abs() <= END_ROUNDING;
    let finest = |list: &[f64]| list.windows(2).fold(GAMMA_STEPS[1], |m, w| m.min(w[1] - w[0]));
    let step = finest(&table.planes).min(finest(&table.gammas)).max(GAMMA_STEPS[0]);
    let steps = (90.0 / step).ceil() as usize;
    let gammas: Vec<f64> = (0..=steps).map(|k| 90.0 * k as f64 / steps as f64).collect();
    let planes: Vec<f64> = (0..(360.0 / PLANE_STEP) as usize).map(|k| PLANE_STEP * k as f64).collect();
    let value = |c: f64, gamma: f64| {
        let [h, v] = kind.angles(gamma, c);
        interpolated(table, if is_mirrored { h.abs() } else { h }, v)
    };
    let candelas = planes.iter().flat_map(|c| gammas.iter().map(|g| value(*c, *g)).collect::<Vec<_>>());
    let candelas = candelas.collect();
    AngleTable { planes, gammas, candelas }.normalized(PlaneSymmetry::None)
}

/// Checks the angles of a table of type A or B.
fn check(table: &AngleTable) -> Result<(), String> {
    for (name, list) in [("horizontal", &table.planes), ("vertical", &table.gammas)] {
        let ascend = list.windows(2).all(|w| w[0] < w[1]);
        let within = list.iter().all(|x| (-180.0..=180.0).contains(x));
        if list.len() < 2 || !ascend || !within {
            return Err(format!(
                "the {name} angles of a table of type A or B must ascend within -180 to 180 degrees, two or more; correct them, or convert the file to type C"
            ));
        }
    }
    if table.gammas[0] > -END_ROUNDING {
        return Err(
            "the vertical angles of a table of type A or B must begin below 0; convert the file to type C"
                .into(),
        );
    }
    match table.candelas.iter().find(|v| **v < 0.0) {
        Some(v) => Err(format!("the intensity {v} is negative; correct the table")),
        None => Ok(()),
    }
}

/// The intensity at H and V, degrees; 0 outside the table.
fn interpolated(table: &AngleTable, h: f64, v: f64) -> f64 {
    let place = |list: &[f64], x: f64| {
        let k = list.partition_point(|a| *a <= x + END_ROUNDING).min(list.len() - 1);
        let inside = x >= list[0] - END_ROUNDING && x <= list[list.len() - 1] + END_ROUNDING;
        let k = k.max(1);
        inside.then(|| (k, ((x - list[k - 1]) / (list[k] - list[k - 1])).clamp(0.0, 1.0)))
    };
    let (Some((j, s)), Some((k, t))) = (place(&table.planes, h), place(&table.gammas, v)) else { return 0.0 };
    let n = table.gammas.len();
    let at = |plane: usize| {
        let (a, b) = (table.candelas[plane * n + k - 1], table.candelas[plane * n + k]);
        a + (b - a) * t
    };
    at(j - 1) * (1.0 - s) + at(j) * s
}
