//! Skies given by a formula: the CIE standard general sky and the Perez all-weather sky.
//!
//! With Z the angle between a direction and up and χ that between the direction and the sun, the radiance above the horizon is proportional to
//!
//! ```text
//! φ(Z) f(χ)      φ(Z) = 1 + a exp(b/cos Z)      f(χ) = k + c exp(d χ) + e cos²χ
//! ```
//!
//! the gradation and the indicatrix; negative values count as 0.
//!
//! | sky | a, b, c, d, e | k |
//! |---|---|---|
//! | CIE standard general sky, types 1 to 15 (CIE S 011/E:2003, ISO 15469:2004) | table | 1 − c exp(dπ/2) |
//! | Perez all-weather (Perez, Seals, Michalsky, Solar Energy 50 (1993) 235) | by the clearness ε, the brightness Δ and Z of the sun | 1 |
//!
//! ```text
//! ε = (1 + E_n/E_d + 1.041 Z³)/(1 + 1.041 Z³)      Δ = m E_d/E_0
//! ```
//!
//! with E_n the direct normal and E_d the diffuse horizontal irradiance, E_0 the extraterrestrial normal irradiance and m the relative air mass (Kasten, Young, Applied
//! Optics 28 (1989) 4735).
//!
//! Relative values are normalized to those of the uniform sky of the same irradiance on a horizontal plane: ∫ f cos Z dω = π above the horizon. Below the horizon
//! the ground reflects this irradiance diffusely: f is its reflectance.

use super::direction_table::{DirectionTable, TableSample};
use super::sky_frame::SkyFrame;
use std::f64::consts::{FRAC_PI_2, PI};
use zonal_math::Vec3;
use zonal_math::gauss_legendre;

/// a, b, c, d, e of the types 1 to 15.
const CIE_PARAMETERS: [[f64; 5]; 15] = [
    [4.0, -0.70, 0.0, -1.0, 0.0],
    [4.0, -0.70, 2.0, -1.5, 0.15],
    [1.1, -0.8, 0.0, -1.0, 0.0],
    [1.1, -0.8, 2.0, -1.5, 0.15],
    [0.0, -1.0, 0.0, -1.0, 0.0],
    [0.0, -1.0, 2.0, -1.5, 0.15],
    [0.0, -1.0, 5.0, -2.5, 0.30],
    [0.0, -1.0, 10.0, -3.0, 0.45],
    [-1.0, -0.55, 2.0, -1.5, 0.15],
    [-1.0, -0.55, 5.0, -2.5, 0.30],
    [-1.0, -0.55, 10.0, -3.0, 0.45],
    [-1.0, -0.32, 10.0, -3.0, 0.45],
    [-1.0, -0.32, 16.0, -3.0, 0.30],
    [-1.0, -0.15, 16.0, -3.0, 0.30],
    [-1.0, -0.15, 24.0, -2.8, 0.15],
];
/// Upper ends of the classes of the clearness but the last.
const CLEARNESS_LIMITS: [f64; 7] = [1.065, 1.23, 1.5, 1.95, 2.8, 4.5, 6.2];
/// Of each class of the clearness x₁ … x₄ of a, b, c, d and e, with x = x₁ + x₂ Z + Δ (x₃ + x₄ Z).
const PEREZ_COEFFICIENTS: [[[f64; 4]; 5]; 8] = [
    [
        [1.3525, -0.2576, -0.2690, -1.4366],
        [-0.7670, 0.0007, 1.2734, -0.1233],
        [2.8000, 0.6004, 1.2375, 1.0000],
        [1.8734, 0.6297, 0.9738, 0.2809],
        [0.0356, -0.1246, -0.5718, 0.9938],
    ],
    [
        [-1.2219, -0.7730, 1.4148, 1.1016],
        [-0.2054, 0.0367, -3.9128, 0.9156],
        [6.9750, 0.1774, 6.4477, -0.1239],
        [-1.5798, -0.5081, -1.7812, 0.1080],
        [0.2624, 0.0672, -0.2190, -0.4285],
    ],
    [
        [-1.1000, -0.2515, 0.8952, 0.0156],
        [0.2782, -0.1812, -4.5000, 1.1766],
        [24.7219, -13.0812, -37.7000, 34.8438],
        [-5.0000, 1.5218, 3.9229, -2.6204],
        [-0.0156, 0.1597, 0.4199, -0.5562],
    ],
    [
        [-0.5484, -0.6654, -0.2672, 0.7117],
        [0.7234, -0.6219, -5.6812, 2.6297],
        [33.3389, -18.3000, -62.2500, 52.0781],
        [-3.5000, 0.0016, 1.1477, 0.1062],
        [0.4659, -0.3296, -0.0876, -0.0329],
    ],
    [
        [-0.6000, -0.3566, -2.5000, 2.3250],
        [0.2937, 0.0496, -5.6812, 1.8415],
        [21.0000, -4.7656, -21.5906, 7.2492],
        [-3.5000, -0.1554, 1.4062, 0.3988],
        [0.0032, 0.0766, -0.0656, -0.1294],
    ],
    [
        [-1.0156, -0.3670, 1.0078, 1.4051],
        [0.2875, -0.5328, -3.8500, 3.3750],
        [14.0000, -0.9999, -7.1406, 7.5469],
        [-3.4000, -0.1078, -1.0750, 1.5702],
        [-0.0672, 0.4016, 0.3017, -0.4844],
    ],
    [
        [-1.0000, 0.0211, 0.5025, -0.5119],
        [-0.3000, 0.1922, 0.7023, -1.6317],
        [19.0000, -5.0000, 1.2438, -1.9094],
        [-4.0000, 0.0250, 0.3844, 0.2656],
        [1.0468, -0.3788, -2.4517, 1.4656],
    ],
    [
        [-1.0500, 0.0289, 0.4260, 0.3590],
        [-0.3250, 0.1156, 0.7781, 0.0025],
        [31.0625, -14.5000, -46.1148, 55.3750],
        [-7.2312, 0.4050, 13.3500, 0.6234],
        [1.5000, -0.6426, 1.8564, 0.5636],
    ],
];
/// Points of the quadrature along Z, on each side of the sun, and around the axis.
const QUADRATURE_POINTS: usize = 48;
/// Rows and columns of the table of directions: cells of 2° by 3°.
const TABLE_ROWS: usize = 90;
const TABLE_COLUMNS: usize = 120;
/// Share of the mean weight that every cell above the horizon has at least, so that no light is missed.
const MIN_CELL_SHARE: f64 = 1e-3;

/// A sky by the formula of the module header.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SkyModel {
    frame: SkyFrame,
    /// Unit vector towards the sun.
    sun: Vec3,
    /// a, b.
    gradation: [f64; 2],
    /// k, c, d, e.
    indicatrix: [f64; 4],
    /// Relative radiance below the horizon.
    ground: f64,
    /// Factor that normalizes the values.
    scale: f64,
    table: DirectionTable,
}

/// Sun, axis and ground of a sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkyPlacement {
    /// Vector towards the sun, of any length; the sun is above the horizon.
    pub sun: Vec3,
    /// Vector towards the zenith, of any length.
    pub up: Vec3,
    /// Reflectance of the ground, 0 to 1, below the horizon.
    pub ground_reflectance: f64,
}

/// Irradiances on which the Perez sky depends, W/m².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkyIrradiance {
    /// Direct normal irradiance.
    pub direct_normal: f64,
    /// Diffuse horizontal irradiance, above 0.
    pub diffuse_horizontal: f64,
    /// Extraterrestrial normal irradiance.
    pub extraterrestrial: f64,
}

impl SkyModel {
    /// The CIE standard general sky of a type from 1 to 15.
    pub(super) fn cie(kind: usize, placement: SkyPlacement) -> Result<SkyModel, String> {
        let Some(&[a, b, c, d, e]) = kind.checked_sub(1).and_then(|k| CIE_PARAMETERS.get(k)) else {
            return Err(format!("{kind} is no type of the CIE standard general sky; give 1 to 15"));
        };
        SkyModel::new(placement, [a, b], [1.0 - c * (d * FRAC_PI_2).exp(), c, d, e])
    }

    /// The Perez all-weather sky.
    pub(super) fn perez(e: SkyIrradiance, placement: SkyPlacement) -> Result<SkyModel, String> {
        let SkyIrradiance { direct_normal: direct, diffuse_horizontal: diffuse, extraterrestrial } = e;
        let valid = |x: f64| x.is_finite() && x > 0.0;
        if !(valid(diffuse) && valid(extraterrestrial) && direct.is_finite() && direct >= 0.0) {
            return Err("the Perez sky needs a diffuse irradiance above 0 and a direct one from 0".into());
        }
        let z = placement.zenith_angle()?;
        let z3 = 1.041 * z.powi(3);
        let clearness = (1.0 + direct / diffuse + z3) / (1.0 + z3);
        let brightness = relative_air_mass(z) * diffuse / extraterrestrial;
        let class = CLEARNESS_LIMITS.partition_point(|l| *l <= clearness);
        let list = PEREZ_COEFFICIENTS[class];
        let linear = |[x1, x2, x3, x4]: [f64; 4]| x1 + x2 * z + brightness * (x3 + x4 * z);
        let [a, b, mut c, mut d, e] = list.map(linear);
        if class == 0 {
            let [_, _, [c1, c2, c3, c4], [d1, d2, d3, d4], _] = list;
            c = (brightness * (c1 + c2 * z)).powf(c3).exp() - c4;
            d = -(brightness * (d1 + d2 * z)).exp() + d3 + brightness * d4;
        }
        SkyModel::new(placement, [a, b.min(0.0)], [1.0, c, d, e])
    }

    fn new(placement: SkyPlacement, gradation: [f64; 2], indicatrix: [f64; 4]) -> Result<SkyModel, String> {
        placement.zenith_angle()?;
        let (up, sun) = (placement.up.normalized(), placement.sun.normalized());
        if !(0.0..=1.0).contains(&placement.ground_reflectance) {
            return Err("the reflectance of the ground must lie between 0 and 1".into());
        }
        SkyModel::of_frame(
            SkyFrame::towards(up, sun),
            sun,
            gradation,
            indicatrix,
            placement.ground_reflectance,
        )
        .ok_or_else(|| "this sky is dark; give other irradiances".into())
    }

    /// The model of checked parameters; `None` if no light comes from above.
    fn of_frame(
        frame: SkyFrame,
        sun: Vec3,
        gradation: [f64; 2],
        indicatrix: [f64; 4],
        ground: f64,
    ) -> Option<SkyModel> {
        let table = DirectionTable::new(vec![1.0, -1.0], 1, |_, _| 1.0);
        let mut out = SkyModel { frame, sun, gradation, indicatrix, ground, scale: 1.0, table };
        let horizontal = out.integral(|z| z);
        if !(horizontal.is_finite() && horizontal > 0.0) {
            return None;
        }
        out.scale = PI / horizontal;
        out.table = out.cells();
        Some(out)
    }

    /// The table of directions.
    fn cells(&self) -> DirectionTable {
        let edges = DirectionTable::edges_of_equal_angles(TABLE_ROWS);
        let least = MIN_CELL_SHARE;
        DirectionTable::new(edges.clone(), TABLE_COLUMNS, |r, c| {
            if edges[r] <= 0.0 {
                return self.ground;
            }
            // The mean over nine points, those at the edges included.
            let at = |k: usize| k as f64 / 2.0;
            let value = |k: usize| {
                let z = edges[r] + (edges[r + 1] - edges[r]) * at(k / 3);
                self.above(z, (c as f64 + at(k % 3)) / TABLE_COLUMNS as f64)
            };
            least + (1.0 - least) * (0..9).map(value).sum::<f64>() / 9.0
        })
    }

    /// φ f above the horizon, normalized, at a height z and a turn.
    fn above(&self, z: f64, turn: f64) -> f64 {
        self.value_above(z, self.frame.direction(z, turn).dot(self.sun))
    }

    /// φ f above the horizon, normalized, at the height z and the cosine with the sun.
    fn value_above(&self, z: f64, cos: f64) -> f64 {
        let ([a, b], [k, c, d, e]) = (self.gradation, self.indicatrix);
        let gradation = if z > 0.0 { 1.0 + a * (b / z).exp() } else { 1.0 };
        let cos = cos.clamp(-1.0, 1.0);
        self.scale * (gradation * (k + c * (d * cos.acos()).exp() + e * cos * cos)).max(0.0)
    }

    /// Relative radiance in the unit direction `direction`.
    pub(super) fn relative(&self, direction: Vec3) -> f64 {
        let z = direction.dot(self.frame.up);
        if z > 0.0 { self.value_above(z, direction.dot(self.sun)) } else { self.ground }
    }

    /// Relative radiance at the zenith.
    pub(super) fn zenith(&self) -> f64 {
        self.relative(self.frame.up)
    }

    /// ∫ φ f w(cos Z) dω above the horizon: Gauss rules in Z on both sides of the sun and in the root of the turn away from it, since f has a kink at the sun.
    fn integral(&self, weight: impl Fn(f64) -> f64) -> f64 {
        let rule = gauss_legendre::rule(QUADRATURE_POINTS);
        let nodes = || rule.nodes.iter().zip(&rule.weights);
        let sun = self.sun.dot(self.frame.up).clamp(0.0, 1.0).acos();
        let mut sum = 0.0;
        for [lo, hi] in [[0.0, sun], [sun, FRAC_PI_2]] {
            for (x, w) in nodes() {
                let (sin, z) = (lo + (hi - lo) * x).sin_cos();
                // The two halves are alike: the turn is t²/2 on each.
                let around: f64 = nodes().map(|(t, v)| 2.0 * v * t * self.above(z, 0.5 * t * t)).sum();
                sum += w * (hi - lo) * sin * weight(z) * 2.0 * PI * around;
            }
        }
        sum
    }

    /// ∫ f dω over all directions, sr.
    pub(super) fn solid_angle_integral(&self) -> f64 {
        self.integral(|_| 1.0) + 2.0 * PI * self.ground
    }

    /// An upper bound of f.
    pub(super) fn upper_bound(&self) -> f64 {
        let ([a, b], [k, c, d, e]) = (self.gradation, self.indicatrix);
        let gradation = (1.0 + a * b.exp()).max(1.0);
        let indicatrix = k + (c * (d * PI).exp().max(1.0)).max(0.0) + e.max(0.0);
        (self.scale * gradation * indicatrix).max(self.ground)
    }

    /// An upper bound of ∫ f cosθ⁺ dω about a unit vector, sr.
    pub(super) fn irradiance_bound(&self, normal: Vec3) -> f64 {
        let (z, turn) = self.frame.coordinates(normal);
        self.table.cosine_bound(z, turn)
    }

    /// The direction at a point of the unit square and its density, 1/sr.
    pub(super) fn sample(&self, u: [f64; 2]) -> (Vec3, f64) {
        let TableSample { z, turn, density } = self.table.sample(u);
        (self.frame.direction(z, turn), density)
    }

    /// Density of a direction, 1/sr.
    pub(super) fn density(&self, direction: Vec3) -> f64 {
        let (z, turn) = self.frame.coordinates(direction);
        self.table.density(z, turn)
    }

    /// The numbers that determine the model.
    pub(super) fn numbers(&self) -> Vec<f64> {
        let own = [self.sun.x, self.sun.y, self.sun.z, self.ground];
        self.frame.numbers().chain(own).chain(self.gradation).chain(self.indicatrix).collect()
    }

    /// The model of its numbers.
    pub(super) fn from_numbers(numbers: &[f64]) -> Option<SkyModel> {
        let (frame, rest) = numbers.split_at_checked(SkyFrame::NUMBERS)?;
        let [x, y, z, ground, a, b, k, c, d, e] = *rest else { return None };
        let (frame, sun) = (SkyFrame::from_numbers(frame)?, Vec3::from_array([x, y, z]));
        let valid = rest.iter().all(|v| v.is_finite())
            && b <= 0.0
            && (0.0..=1.0).contains(&ground)
            && (sun.length() - 1.0).abs() < 1e-6;
        valid.then(|| SkyModel::of_frame(frame, sun, [a, b], [k, c, d, e], ground)).flatten()
    }
}

impl SkyPlacement {
    /// Angle between the sun and the zenith, radians; refused below the horizon.
    fn zenith_angle(&self) -> Result<f64, String> {
        let cos = self.sun.normalized().dot(self.up.normalized());
        let has_lengths = [self.sun, self.up].iter().all(|v| v.is_finite() && v.length() > 0.0);
        match cos.clamp(-1.0, 1.0).acos() {
            z if has_lengths && cos >= 0.0 => Ok(z),
            z if has_lengths => Err(format!(
                "the sun stands {:.2} degrees below the horizon; these skies are those of the day",
                z.to_degrees() - 90.0
            )),
            _ => Err("the vectors up and towards the sun need a length".into()),
        }
    }
}

/// Relative air mass at the angle `z` from the zenith, radians (Kasten, Young 1989).
fn relative_air_mass(z: f64) -> f64 {
    1.0 / (z.cos() + 0.50572 * (96.07995 - z.to_degrees()).powf(-1.6364))
}
