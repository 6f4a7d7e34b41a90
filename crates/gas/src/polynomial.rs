//! Polynomials, coefficients ascending, and clamping to the range of a model.
//!
//! Weights are polynomials of the temperature in K for any fixed composition: mixtures interpolate and multiply them.

/// Σ c_i xⁱ by Horner's rule.
pub(crate) fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// The value of the range nearest to `x`; one that differs adds a note.
pub(crate) fn clamp_with_note(
    x: f64,
    [low, high]: [f64; 2],
    what: &str,
    unit: &str,
    notes: &mut Vec<String>,
) -> f64 {
    let clamped = x.clamp(low, high);
    if clamped != x {
        notes.push(format!(
            "{what} {} is outside the range of the model, {low} to {high}{unit}; the coefficients are those at {clamped}{unit}",
            if x.is_finite() { format!("{x:.6}{unit}") } else { "infinite".into() }
        ));
    }
    clamped
}

/// The coefficients in x of a polynomial in x/`unit`.
pub(crate) fn in_units(coefficients: &[f64], unit: f64) -> Vec<f64> {
    coefficients.iter().enumerate().map(|(i, c)| c / unit.powi(i as i32)).collect()
}

/// (1 − t) a + t b.
pub(crate) fn interpolated(a: &[f64], b: &[f64], t: f64) -> Vec<f64> {
    let at = |p: &[f64], i: usize| p.get(i).copied().unwrap_or(0.0);
    (0..a.len().max(b.len())).map(|i| (1.0 - t) * at(a, i) + t * at(b, i)).collect()
}

/// The product of two polynomials.
pub(crate) fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; (a.len() + b.len()).saturating_sub(1)];
    for (i, x) in a.iter().enumerate() {
        for (j, y) in b.iter().enumerate() {
            out[i + j] += x * y;
        }
    }
    out
}
