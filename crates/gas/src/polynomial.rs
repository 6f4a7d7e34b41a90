//! Polynomials, coefficients ascending, and clamping to the range of a model.

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
