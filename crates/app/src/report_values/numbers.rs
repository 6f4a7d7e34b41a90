//! Numbers as text, with the digits that their errors leave.

/// A number with enough digits for a table.
#[must_use]
pub fn number(x: f64) -> String {
    if x == 0.0 {
        "0".into()
    } else if !x.is_finite() {
        "unknown".into()
    } else if (1e-3..1e5).contains(&x.abs()) {
        format!("{x:.4}").trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        format!("{x:.2e}")
    }
}

/// As [`number`], with one decimal up to 1e12.
#[must_use]
pub fn large_number(x: f64) -> String {
    if (1e5..1e12).contains(&x.abs()) { format!("{x:.1}") } else { number(x) }
}

/// Number of decimals that shows two digits of an error.
fn error_decimals(e: f64) -> usize {
    (1.0 - e.log10().floor()).clamp(0.0, 12.0) as usize
}

/// An error to two digits.
#[must_use]
pub fn two_digits(e: f64) -> String {
    if e == 0.0 {
        "0".into()
    } else if (1e-3..1e5).contains(&e) {
        format!("{e:.0$}", error_decimals(e))
    } else {
        format!("{e:.1e}")
    }
}

/// A value and its error; digits of the value below those of the error are left out.
#[must_use]
pub fn value_with_error(x: f64, e: f64) -> String {
    if e <= 0.0 {
        return large_number(x);
    }
    if !e.is_finite() {
        format!("{} ± unknown", large_number(x))
    } else if e >= 1e-3 && (1e-3..1e12).contains(&x.abs()) {
        format!("{x:.0$} ± {1}", error_decimals(e), two_digits(e))
    } else {
        format!("{} ± {}", large_number(x), two_digits(e))
    }
}

/// A value and the sum of two errors, of the exchange and of the zones; where one of them is unknown, the other is named beside it.
#[must_use]
pub fn value_with_errors(x: f64, errors: [f64; 2]) -> String {
    let text = value_with_error(x, errors[0] + errors[1]);
    match errors {
        [e, z] if e > 0.0 && e.is_finite() && !z.is_finite() => {
            format!("{text} (exchange {})", two_digits(e))
        }
        [e, z] if z > 0.0 && z.is_finite() && !e.is_finite() => format!("{text} (zones {})", two_digits(z)),
        _ => text,
    }
}

/// A whole number with spaces between groups of three digits.
#[must_use]
pub fn thousands(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (k, d) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            out.push(' ');
        }
        out.push(d);
    }
    out
}
