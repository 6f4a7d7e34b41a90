//! Richardson extrapolation with its uncertainty.
//!
//! Of values v_k at n_k zones along an edge, h_k = 1/n_k, one assumes v = v* + C h^p. Three of them give p and v*:
//!
//! ```text
//! (v_1 − v_2)/(v_2 − v_3) = (h_1^p − h_2^p)/(h_2^p − h_3^p),        v* = v_3 + (v_3 − v_2) h_3^p/(h_2^p − h_3^p).
//! ```
//!
//! The value is that of the three finest. Its uncertainty is the larger of two changes: to the triple before, and to the finest pair with the
//! order of the triple before; where there are only three, a quarter of what was extrapolated (the margin of Roache's grid convergence
//! index). It is an estimate, no bound. A sequence that is not monotone, that moves no more than rounding or has no order between
//! [`MIN_ORDER`] and [`MAX_ORDER`] is not extrapolated, with a reason.

/// Smallest accepted order.
pub(crate) const MIN_ORDER: f64 = 0.4;
/// Largest accepted order.
pub(crate) const MAX_ORDER: f64 = 8.0;
/// Relative differences below this are rounding and the solver's residual.
const MIN_RELATIVE_CHANGE: f64 = 1e-11;

/// Values at growing resolution.
#[derive(Clone, Debug)]
pub(crate) struct ResolutionSequence {
    /// Name of the quantity.
    pub name: String,
    /// Zones along an edge and the value there, from coarse to fine.
    pub steps: Vec<(f64, f64)>,
    /// The reference, where there is one, and by how much it is uncertain. A reference of 0 makes errors of the values.
    pub reference: Option<(f64, f64)>,
    /// The extrapolation, or why there is none.
    pub limit: Result<Extrapolation, String>,
}

impl ResolutionSequence {
    /// A sequence, extrapolated where that is possible.
    pub(crate) fn new(
        name: impl Into<String>,
        steps: Vec<(f64, f64)>,
        reference: Option<(f64, f64)>,
    ) -> ResolutionSequence {
        let limit = extrapolate(&steps);
        ResolutionSequence { name: name.into(), steps, reference, limit }
    }

    /// The extrapolated value; not a number where there is none, so that no verdict can rest on it.
    pub(crate) fn value(&self) -> f64 {
        self.limit.as_ref().map_or(f64::NAN, |e| e.value)
    }
}

/// The extrapolated limit of a sequence.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Extrapolation {
    /// v*.
    pub value: f64,
    /// Its estimated uncertainty.
    pub uncertainty: f64,
    /// The observed order of each triple, from coarse to fine.
    pub orders: Vec<f64>,
}

impl Extrapolation {
    /// The order of the finest triple.
    pub(crate) fn order(&self) -> f64 {
        self.orders.last().copied().unwrap_or(f64::NAN)
    }
}

/// Extrapolates (n, v), n growing.
pub(crate) fn extrapolate(steps: &[(f64, f64)]) -> Result<Extrapolation, String> {
    if steps.len() < 3 {
        return Err(format!("{} resolutions; three are needed", steps.len()));
    }
    // From the finest triple back, as long as they have an order.
    let mut found: Vec<(f64, f64)> = Vec::new();
    for triple in steps.windows(3).rev() {
        match observed_order(triple) {
            Ok(p) => found.push((p, extrapolate_pair([triple[1], triple[2]], p))),
            Err(why) if found.is_empty() => return Err(why),
            Err(_) => break,
        }
    }
    let (_, value) = found[0];
    let [.., before, last] = steps else { return Err("two resolutions are needed".into()) };
    let uncertainty = match found.get(1) {
        Some(&(p, other)) => (other - value).abs().max((extrapolate_pair([*before, *last], p) - value).abs()),
        None => 0.25 * (value - last.1).abs(),
    };
    Ok(Extrapolation { value, uncertainty, orders: found.iter().rev().map(|f| f.0).collect() })
}

/// The limit of two steps (n, v) whose error is of order p.
fn extrapolate_pair(steps: [(f64, f64); 2], p: f64) -> f64 {
    let [(n1, v1), (n2, v2)] = steps;
    v2 + (v2 - v1) / ((n2 / n1).powf(p) - 1.0)
}

/// The order of three values, by bisection: the ratio grows with p.
fn observed_order(triple: &[(f64, f64)]) -> Result<f64, String> {
    let &[(n1, v1), (n2, v2), (n3, v3)] = triple else { return Err("three values are needed".into()) };
    let (first, second) = (v1 - v2, v2 - v3);
    let size = v1.abs().max(v2.abs()).max(v3.abs());
    if first.abs().max(second.abs()) <= MIN_RELATIVE_CHANGE * size {
        return Err("the values do not change: nothing is left to extrapolate".into());
    }
    let ratio = first / second;
    if !(ratio.is_finite() && ratio > 0.0) {
        return Err("the values are not monotone".into());
    }
    // (h1^p − h2^p)/(h2^p − h3^p), divided by h2^p above and below.
    let of = |p: f64| ((n2 / n1).powf(p) - 1.0) / (1.0 - (n2 / n3).powf(p));
    if !(of(MIN_ORDER)..=of(MAX_ORDER)).contains(&ratio) {
        return Err(format!("no order between {MIN_ORDER} and {MAX_ORDER} fits"));
    }
    let (mut low, mut high) = (MIN_ORDER, MAX_ORDER);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if of(middle) < ratio { low = middle } else { high = middle }
    }
    Ok(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(n: &[f64], v: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        n.iter().map(|&n| (n, v(1.0 / n))).collect()
    }

    #[test]
    fn pure_power_is_extrapolated_to_its_limit() {
        for p in [0.5, 1.0, 1.8, 2.0, 4.0] {
            for n in [&[4.0, 8.0, 16.0][..], &[5.0, 9.0, 13.0, 17.0, 21.0], &[10.0, 30.0, 40.0]] {
                let e = extrapolate(&steps(n, |h| 0.7 + 0.3 * h.powf(p))).unwrap();
                assert!((e.order() - p).abs() < 1e-6, "{p}: {e:?}");
                assert!((e.value - 0.7).abs() < 1e-9, "{p}: {e:?}");
                assert_eq!(e.orders.len(), n.len() - 2);
                if n.len() > 3 {
                    assert!(e.uncertainty < 1e-8, "{e:?}");
                } else {
                    let last = 0.3 * n[2].powf(-p);
                    assert!((e.uncertainty / last - 0.25).abs() < 1e-5, "{e:?}");
                }
            }
        }
    }

    /// A second term of higher order: the uncertainty holds the limit.
    #[test]
    fn uncertainty_contains_the_limit() {
        for (p, q) in [(1.0, 2.0), (1.8, 2.0), (2.0, 3.0), (2.0, 4.0)] {
            for c in [-0.5, 0.5, 1.5] {
                let all = steps(&[8.0, 16.0, 32.0, 64.0], |h| 1.0 + h.powf(p) + c * h.powf(q));
                let e = extrapolate(&all).unwrap();
                assert!((e.value - 1.0).abs() <= e.uncertainty, "{p} {q} {c}: {e:?}");
                assert!(e.uncertainty < 0.25 * (all[3].1 - 1.0).abs(), "{p} {q} {c}: {e:?}");
            }
        }
    }

    #[test]
    fn sequence_without_order_is_not_extrapolated() {
        let refused = |v: [f64; 3]| extrapolate(&[(4.0, v[0]), (8.0, v[1]), (16.0, v[2])]).unwrap_err();
        assert!(refused([1.0, 0.9, 0.95]).contains("monotone"));
        assert!(refused([1.0, 1.0, 1.0]).contains("do not change"));
        assert!(refused([1.0, 0.9, 0.7]).contains("no order"));
        assert!(refused([1.0, f64::NAN, 0.7]).contains("monotone"));
        assert!(extrapolate(&[(1.0, 1.0), (2.0, 2.0)]).unwrap_err().contains("three"));
        // A coarse value off the line is left out, not the whole sequence.
        let e = extrapolate(&[(2.0, 0.0), (4.0, 1.25), (8.0, 1.0625), (16.0, 1.015625)]).unwrap();
        assert!((e.value - 1.0).abs() < 1e-9 && e.orders.len() == 1);
    }
}
