//! Relative intensities over C-planes and γ, bilinear between the nodes.
//!
//! C is the angle of a half-plane about the axis of the luminaire, γ the angle from the axis, 0 at the aim (CIE 121:1996; type C of ANSI/IES LM-63).
//! Planes that the symmetry of the luminaire implies are filled in on construction, so that the planes cover the whole circle. Outside the range of γ the intensity
//! is zero.
//!
//! In one interval of γ of centre m and width h, with the values a and b at its ends and y = h/2,
//!
//! ```text
//! ∫ I sinγ dγ = a S₀ + (b − a) S₁      S₀ = 2 sin m sin y      S₁ = S₀/2 + (cos m/y) (sin y − y cos y)
//! ```
//!
//! The integral over γ is linear in C between two planes, so that trapezoids are exact. Directions are drawn by the exact inverse: C from its piecewise linear density, then γ
//! by bisection.

use std::f64::consts::{PI, TAU};

/// Largest number of values of a table before symmetric planes are filled in.
const MAX_TABLE_VALUES: usize = 1 << 20;
/// Least step of angles, degrees: smaller ones are lost in rounding.
const MIN_ANGLE_STEP_DEGREES: f64 = 1e-4;
/// Angles beyond the end of their range by this, degrees, are rounding.
const ANGLE_ROUNDING_DEGREES: f64 = 1e-6;
/// Bisections for γ of a sample: to the last bit of an interval.
const BISECTIONS: usize = 50;
/// Half-width of an interval, radians, below which sin y − y cos y is summed as a series.
const SERIES_HALF_WIDTH: f64 = 0.1;

/// Symmetry of the planes of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlaneSymmetry {
    /// One plane stands for all.
    Rotational,
    /// Planes from 0° to 90° stand for all quadrants.
    Quadrants,
    /// Planes from 0° to 180° are mirrored in the plane through C = 0° and 180°.
    AboutC0,
    /// Planes from 90° to 270° are mirrored in the plane through C = 90° and 270°.
    AboutC90,
    /// Planes over the whole circle; that of 360° may be omitted.
    None,
}

impl PlaneSymmetry {
    /// The range of the planes, degrees.
    fn range(self) -> [f64; 2] {
        match self {
            PlaneSymmetry::Rotational | PlaneSymmetry::None => [0.0, 360.0],
            PlaneSymmetry::Quadrants => [0.0, 90.0],
            PlaneSymmetry::AboutC0 => [0.0, 180.0],
            PlaneSymmetry::AboutC90 => [90.0, 270.0],
        }
    }

    /// The angles of a plane and of its images, degrees.
    fn images(self, c: f64) -> Vec<f64> {
        match self {
            PlaneSymmetry::Rotational => vec![0.0],
            PlaneSymmetry::Quadrants => vec![c, 180.0 - c, 180.0 + c, 360.0 - c],
            PlaneSymmetry::AboutC0 => vec![c, 360.0 - c],
            PlaneSymmetry::AboutC90 => vec![c, (540.0 - c).rem_euclid(360.0)],
            PlaneSymmetry::None => vec![c],
        }
    }
}

/// Relative intensities over C-planes and γ.
#[derive(Clone, Debug, PartialEq)]
pub struct IntensityTable {
    /// Angles of the planes in [0, 2π), ascending, radians.
    planes: Vec<f64>,
    /// γ of the nodes, ascending, radians.
    gammas: Vec<f64>,
    /// Values, those of one plane together.
    values: Vec<f64>,
    /// Of each plane the running sums of ∫ I sinγ dγ over the intervals of γ, from 0.
    sums: Vec<f64>,
    /// Running sums of ∫∫ I sinγ dγ dC over the intervals of C, sr.
    sectors: Vec<f64>,
    /// Largest value of each γ over the planes.
    largest: Vec<f64>,
}

impl IntensityTable {
    /// A table of values at the angles `planes` (C) and `gammas` (γ) in degrees, those of one plane together.
    ///
    /// # Errors
    /// What is wrong, and the remedy: angles that do not ascend or lie outside their range, values that are negative or not finite, or zero throughout.
    pub fn new(
        planes: &[f64],
        gammas: &[f64],
        values: &[f64],
        symmetry: PlaneSymmetry,
    ) -> Result<IntensityTable, String> {
        check_angles("C", planes, symmetry.range())?;
        check_angles("γ", gammas, [0.0, 180.0])?;
        let count = planes.len().checked_mul(gammas.len());
        if count != Some(values.len()) || values.len() > MAX_TABLE_VALUES || gammas.len() < 2 {
            return Err(format!(
                "{} planes and {} angles γ need as many values as their product, at least 2 angles γ and at most {MAX_TABLE_VALUES} values; {} are given",
                planes.len(),
                gammas.len(),
                values.len()
            ));
        }
        if let Some(v) = values.iter().find(|v| !(v.is_finite() && **v >= 0.0)) {
            return Err(format!("the intensity {v} is no finite number from 0; correct the table"));
        }
        let (planes, values) = unfolded(planes, gammas.len(), values, symmetry);
        let gammas = gammas.iter().map(|g| g.clamp(0.0, 180.0).to_radians()).collect();
        let out = IntensityTable::with_sums(planes, gammas, values);
        if out.solid_angle_integral() > 0.0 {
            Ok(out)
        } else {
            Err("all intensities are zero; give a table of a lamp that emits".into())
        }
    }

    fn with_sums(planes: Vec<f64>, gammas: Vec<f64>, values: Vec<f64>) -> IntensityTable {
        let n = gammas.len();
        let mut sums = Vec::with_capacity(values.len());
        for plane in values.chunks(n) {
            let mut sum = 0.0;
            sums.push(sum);
            for k in 1..n {
                sum += interval_integral([gammas[k - 1], gammas[k]], [plane[k - 1], plane[k]]);
                sums.push(sum);
            }
        }
        let largest = (0..n).map(|k| values.chunks(n).fold(0.0f64, |m, p| m.max(p[k]))).collect();
        let mut out = IntensityTable { planes, gammas, values, sums, sectors: Vec::new(), largest };
        let mut sum = 0.0;
        out.sectors = (0..out.planes.len())
            .map(|j| {
                let [a, b] = [j, out.next_plane(j)].map(|p| out.plane_integral(p));
                sum += 0.5 * (a + b) * out.sector_width(j);
                sum
            })
            .collect();
        out
    }

    /// ∫ I sinγ dγ of a plane.
    fn plane_integral(&self, plane: usize) -> f64 {
        self.sums[(plane + 1) * self.gammas.len() - 1]
    }

    fn next_plane(&self, j: usize) -> usize {
        if j + 1 < self.planes.len() { j + 1 } else { 0 }
    }

    /// Width of the interval of C after plane `j`, radians.
    fn sector_width(&self, j: usize) -> f64 {
        let next = if j + 1 < self.planes.len() { self.planes[j + 1] } else { self.planes[0] + TAU };
        next - self.planes[j]
    }

    /// The interval of C that contains `c`, its next plane, and the place within it from 0 to 1.
    fn sector_at(&self, c: f64) -> (usize, usize, f64) {
        let after = self.planes.partition_point(|p| *p <= c);
        // Before the first plane: the interval across C = 0.
        let (j, c) = if after == 0 { (self.planes.len() - 1, c + TAU) } else { (after - 1, c) };
        (j, self.next_plane(j), ((c - self.planes[j]) / self.sector_width(j)).clamp(0.0, 1.0))
    }

    /// Relative intensity at γ in [0, π] and C in [0, 2π), radians.
    pub(super) fn relative(&self, gamma: f64, c: f64) -> f64 {
        let n = self.gammas.len();
        if !(gamma >= self.gammas[0] && gamma <= self.gammas[n - 1]) {
            return 0.0;
        }
        let k = self.gammas.partition_point(|g| *g <= gamma).clamp(1, n - 1);
        let t = (gamma - self.gammas[k - 1]) / (self.gammas[k] - self.gammas[k - 1]);
        let (j, next, s) = self.sector_at(c);
        let at = |plane: usize| {
            let v = &self.values[plane * n + k - 1..=plane * n + k];
            v[0] + (v[1] - v[0]) * t
        };
        at(j) * (1.0 - s) + at(next) * s
    }

    /// Largest value between two γ, radians.
    pub(super) fn upper_bound(&self, from: f64, to: f64) -> f64 {
        let n = self.gammas.len();
        if to < self.gammas[0] || from > self.gammas[n - 1] {
            return 0.0;
        }
        let first = self.gammas.partition_point(|g| *g <= from).saturating_sub(1);
        let last = self.gammas.partition_point(|g| *g < to).min(n - 1);
        self.largest[first..=last].iter().fold(0.0, |m: f64, v| m.max(*v))
    }

    /// ∫ I dω, sr times the unit of the values.
    pub(super) fn solid_angle_integral(&self) -> f64 {
        self.sectors.last().copied().unwrap_or(0.0)
    }

    /// Smallest step of γ, radians.
    pub(super) fn finest_gamma_step(&self) -> f64 {
        self.gammas.windows(2).fold(PI, |m, g| m.min(g[1] - g[0]))
    }

    /// γ and C, radians, of density ∝ I sinγ at a point of the unit square.
    pub(super) fn sample_angles(&self, u: [f64; 2]) -> [f64; 2] {
        // C: the interval by its share, then the inverse of a linear density.
        let wanted = u[1] * self.solid_angle_integral();
        let j = self.sectors.partition_point(|s| *s <= wanted).min(self.planes.len() - 1);
        let before = if j > 0 { self.sectors[j - 1] } else { 0.0 };
        let next = self.next_plane(j);
        let [a, b] = [j, next].map(|p| self.plane_integral(p));
        let share = ((wanted - before) / (self.sectors[j] - before)).clamp(0.0, 1.0);
        let s = inverse_of_linear_density([a, b], share);
        let c = (self.planes[j] + s * self.sector_width(j)).rem_euclid(TAU);
        // γ in the mean of the two planes.
        let n = self.gammas.len();
        let mean = |list: &[f64], k: usize| list[j * n + k] * (1.0 - s) + list[next * n + k] * s;
        let wanted = u[0] * mean(&self.sums, n - 1);
        let (mut lo, mut hi) = (0, n - 1);
        while hi - lo > 1 {
            let middle = (lo + hi) / 2;
            if mean(&self.sums, middle) <= wanted { lo = middle } else { hi = middle }
        }
        let rest = wanted - mean(&self.sums, lo);
        let ends = [mean(&self.values, lo), mean(&self.values, hi)];
        [gamma_of_integral([self.gammas[lo], self.gammas[hi]], ends, rest), c]
    }

    /// The table of [`IntensityTable::append_numbers`]; `None` for other numbers.
    pub(super) fn from_numbers(mut numbers: &[f64]) -> Option<IntensityTable> {
        let mut list = || {
            let (count, rest) = numbers.split_first()?;
            let is_count = *count >= 1.0 && *count <= rest.len() as f64 && count.fract() == 0.0;
            let (list, rest) = rest.split_at_checked(if is_count { *count as usize } else { usize::MAX })?;
            numbers = rest;
            Some(list.to_vec())
        };
        let (planes, gammas, values) = (list()?, list()?, list()?);
        let ascend = |list: &[f64], end: f64| {
            list.windows(2).all(|w| w[0] < w[1]) && list[0] >= 0.0 && list[list.len() - 1] <= end
        };
        let fits = planes.len().checked_mul(gammas.len()) == Some(values.len()) && gammas.len() >= 2;
        let valid = values.iter().all(|v| v.is_finite() && *v >= 0.0) && values.iter().any(|v| *v > 0.0);
        let ordered = ascend(&planes, TAU) && ascend(&gammas, PI);
        (numbers.is_empty() && fits && valid && ordered)
            .then(|| IntensityTable::with_sums(planes, gammas, values))
    }

    /// Appends angles and values.
    pub(super) fn append_numbers(&self, out: &mut Vec<f64>) {
        for list in [&self.planes, &self.gammas, &self.values] {
            out.push(list.len() as f64);
            out.extend(list);
        }
    }
}

/// Checks that angles ascend within their range, degrees.
fn check_angles(name: &str, angles: &[f64], [lo, hi]: [f64; 2]) -> Result<(), String> {
    let slack = ANGLE_ROUNDING_DEGREES;
    let Some(first) = angles.first() else {
        return Err(format!("there are no angles {name}; give a table"));
    };
    if let Some(a) = angles.iter().find(|a| !(**a >= lo - slack && **a <= hi + slack)) {
        return Err(format!("the angle {name} = {a} lies outside {lo} to {hi} degrees; correct the table"));
    }
    let steps = angles.windows(2).find(|w| w[1] - w[0] < MIN_ANGLE_STEP_DEGREES);
    match steps {
        Some(w) => Err(format!("angles {name} must ascend: {} follows {}; sort the table", w[1], w[0])),
        None if first.is_finite() => Ok(()),
        None => Err(format!("an angle {name} is no number; correct the table")),
    }
}

/// The planes over the whole circle in [0, 2π), radians, with their values.
fn unfolded(planes: &[f64], n: usize, values: &[f64], symmetry: PlaneSymmetry) -> (Vec<f64>, Vec<f64>) {
    let mut all: Vec<(f64, usize)> = Vec::new();
    for (j, c) in
        planes.iter().enumerate().take(if symmetry == PlaneSymmetry::Rotational { 1 } else { planes.len() })
    {
        let images = symmetry.images(*c).into_iter().map(|c| c.rem_euclid(360.0));
        all.extend(images.map(|c| (if 360.0 - c < ANGLE_ROUNDING_DEGREES { 0.0 } else { c }, j)));
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    all.dedup_by(|a, b| (a.0 - b.0).abs() < 0.5 * MIN_ANGLE_STEP_DEGREES);
    let values = all.iter().flat_map(|(_, j)| values[j * n..(j + 1) * n].iter().copied()).collect();
    (all.iter().map(|a| a.0.to_radians()).collect(), values)
}

/// ∫ I sinγ dγ over an interval with linear I.
fn interval_integral([lo, hi]: [f64; 2], [a, b]: [f64; 2]) -> f64 {
    let (m, y) = (0.5 * (lo + hi), 0.5 * (hi - lo));
    if y <= 0.0 {
        return 0.0;
    }
    let s0 = 2.0 * m.sin() * y.sin();
    let y2 = y * y;
    let over_y = if y < SERIES_HALF_WIDTH {
        y2 * (1.0 / 3.0 - y2 * (1.0 / 30.0 - y2 * (1.0 / 840.0 - y2 / 45360.0)))
    } else {
        y.sin() / y - y.cos()
    };
    (a * s0 + (b - a) * (0.5 * s0 + m.cos() * over_y)).max(0.0)
}

/// γ up to which the integral from the lower end is `wanted`.
fn gamma_of_integral([lo, hi]: [f64; 2], [a, b]: [f64; 2], wanted: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..BISECTIONS {
        let t = 0.5 * (low + high);
        let below = interval_integral([lo, lo + (hi - lo) * t], [a, a + (b - a) * t]);
        if below <= wanted { low = t } else { high = t }
    }
    lo + (hi - lo) * 0.5 * (low + high)
}

/// The place in [0, 1] up to which a density that is linear from `a` to `b` has the share `share`.
fn inverse_of_linear_density([a, b]: [f64; 2], share: f64) -> f64 {
    // (b − a)/2 s² + a s = share (a + b)/2.
    let want = share * (a + b);
    let root = (a * a + (b - a) * want).max(0.0).sqrt();
    if a + root > 0.0 { (want / (a + root)).clamp(0.0, 1.0) } else { 0.5 }
}
