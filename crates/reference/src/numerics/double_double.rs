//! Double-double arithmetic: numbers of about 106 bits as an unevaluated sum of two doubles.
//!
//! Sums use Knuth's two-sum, products one fused multiply–add (Dekker 1971). The functions are those that the closed forms need. Slow
//! and plain; for abscissae, corner sums and exact differences.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// hi + lo, |lo| ≤ ulp(hi)/2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DoubleDouble {
    /// The number, rounded.
    pub hi: f64,
    /// The remainder of the rounding.
    pub lo: f64,
}

/// ln 2 to 107 bits.
const LN_2: DoubleDouble = DoubleDouble { hi: std::f64::consts::LN_2, lo: 2.319_046_813_846_299_6e-17 };
/// π to 107 bits.
pub(crate) const PI_DD: DoubleDouble =
    DoubleDouble { hi: std::f64::consts::PI, lo: 1.224_646_799_147_353_2e-16 };

/// a + b exactly.
pub(crate) fn sum(a: f64, b: f64) -> DoubleDouble {
    let s = a + b;
    let v = s - a;
    DoubleDouble { hi: s, lo: (a - (s - v)) + (b - v) }
}

/// a − b exactly.
pub(crate) fn difference(a: f64, b: f64) -> DoubleDouble {
    sum(a, -b)
}

/// Renormalizes hi + lo.
fn renormalized(hi: f64, lo: f64) -> DoubleDouble {
    let s = hi + lo;
    DoubleDouble { hi: s, lo: lo - (s - hi) }
}

impl DoubleDouble {
    /// Zero.
    pub(crate) const ZERO: DoubleDouble = DoubleDouble { hi: 0.0, lo: 0.0 };

    /// The nearest double.
    pub(crate) fn rounded(self) -> f64 {
        self.hi + self.lo
    }
    /// True above zero.
    pub(crate) fn is_positive(self) -> bool {
        self.hi > 0.0
    }
    /// Times a power of two.
    fn scaled(self, s: f64) -> DoubleDouble {
        DoubleDouble { hi: self.hi * s, lo: self.lo * s }
    }
    /// The larger of two.
    pub(crate) fn max(self, o: DoubleDouble) -> DoubleDouble {
        if (self - o).hi >= 0.0 { self } else { o }
    }
    /// The smaller of two.
    pub(crate) fn min(self, o: DoubleDouble) -> DoubleDouble {
        if (self - o).hi <= 0.0 { self } else { o }
    }
    /// The square root of a number that is not negative.
    pub(crate) fn sqrt(self) -> DoubleDouble {
        if self.hi <= 0.0 {
            return DoubleDouble::ZERO;
        }
        let r = self.hi.sqrt();
        let rest = self - DoubleDouble::from(r) * DoubleDouble::from(r);
        renormalized(r, rest.hi / (2.0 * r))
    }
    /// e^x for |x| < 700: x = k ln 2 + 64 y, e^y − 1 by Taylor's series, six squarings of 1 + m as m → 2m + m².
    pub(crate) fn exp(self) -> DoubleDouble {
        let k = (self.hi / LN_2.hi).round();
        let y = (self - LN_2 * DoubleDouble::from(k)).scaled(1.0 / 64.0);
        let (mut term, mut m) = (y, y);
        for n in 2..=14 {
            term = term * y / DoubleDouble::from(n as f64);
            m = m + term;
        }
        for _ in 0..6 {
            m = m.scaled(2.0) + m * m;
        }
        let e = DoubleDouble::from(1.0) + m;
        let half = 2f64.powi((k * 0.5) as i32);
        e.scaled(half).scaled(2f64.powi(k as i32 - (k * 0.5) as i32))
    }
    /// The natural logarithm of a positive number: one Newton step from the logarithm of the nearest double.
    pub(crate) fn ln(self) -> DoubleDouble {
        let l = DoubleDouble::from(self.hi.ln());
        let d = self * (-l).exp() - DoubleDouble::from(1.0);
        l + d - (d * d).scaled(0.5)
    }
    /// (cos, sin) of a double, |x| < 4: Taylor's series of x/32, then the angle is doubled five times in terms of sin and 1 − cos.
    fn cos_sin(x: f64) -> (DoubleDouble, DoubleDouble) {
        let y = DoubleDouble::from(x / 32.0);
        let y2 = y * y;
        let (mut sin, mut versed) = (y, y2.scaled(0.5));
        let (mut ts, mut tc) = (y, y2.scaled(0.5));
        for n in 1..=9 {
            let n = n as f64;
            ts = -ts * y2 / DoubleDouble::from(2.0 * n * (2.0 * n + 1.0));
            tc = -tc * y2 / DoubleDouble::from((2.0 * n + 1.0) * (2.0 * n + 2.0));
            (sin, versed) = (sin + ts, versed + tc);
        }
        let one = DoubleDouble::from(1.0);
        for _ in 0..5 {
            (sin, versed) = ((sin * (one - versed)).scaled(2.0), (sin * sin).scaled(2.0));
        }
        (one - versed, sin)
    }
    /// The angle of the point (x, self), x ≥ 0, in [−π/2, π/2]: the angle in double precision and a small correction.
    pub(crate) fn atan2(self, x: DoubleDouble) -> DoubleDouble {
        if self.hi == 0.0 {
            return DoubleDouble::ZERO;
        }
        let a = self.hi.atan2(x.hi);
        let (c, s) = DoubleDouble::cos_sin(a);
        let (up, along) = (self * c - x * s, x * c + self * s);
        DoubleDouble::from(a) + up / along
    }
}

impl From<f64> for DoubleDouble {
    fn from(x: f64) -> DoubleDouble {
        DoubleDouble { hi: x, lo: 0.0 }
    }
}
impl Neg for DoubleDouble {
    type Output = DoubleDouble;
    fn neg(self) -> DoubleDouble {
        DoubleDouble { hi: -self.hi, lo: -self.lo }
    }
}
impl Add for DoubleDouble {
    type Output = DoubleDouble;
    fn add(self, o: DoubleDouble) -> DoubleDouble {
        let (s, t) = (sum(self.hi, o.hi), sum(self.lo, o.lo));
        let s = renormalized(s.hi, s.lo + t.hi);
        renormalized(s.hi, s.lo + t.lo)
    }
}
impl Sub for DoubleDouble {
    type Output = DoubleDouble;
    fn sub(self, o: DoubleDouble) -> DoubleDouble {
        self + -o
    }
}
impl Mul for DoubleDouble {
    type Output = DoubleDouble;
    fn mul(self, o: DoubleDouble) -> DoubleDouble {
        let p = self.hi * o.hi;
        let e = self.hi.mul_add(o.hi, -p);
        renormalized(p, e + (self.hi * o.lo + self.lo * o.hi))
    }
}
impl Div for DoubleDouble {
    type Output = DoubleDouble;
    fn div(self, o: DoubleDouble) -> DoubleDouble {
        let q = self.hi / o.hi;
        let rest = self - o * DoubleDouble::from(q);
        let q1 = rest.hi / o.hi;
        let rest = rest - o * DoubleDouble::from(q1);
        renormalized(q, q1) + DoubleDouble::from(rest.hi / o.hi)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn relative_error(a: DoubleDouble, b: DoubleDouble) -> f64 {
        ((a - b) / b).hi.abs()
    }

    #[test]
    fn inverse_functions_agree_to_thirty_digits() {
        for x in [1e-3, 0.37, 1.0, 5.5, 300.0] {
            let w = DoubleDouble::from(x) / DoubleDouble::from(3.0);
            assert!(relative_error(w.sqrt() * w.sqrt(), w) < 1e-31);
            assert!(relative_error(w.exp().ln(), w) < 1e-28, "{x}");
            assert!(relative_error(w.exp() * (-w).exp(), DoubleDouble::from(1.0)) < 1e-29, "{x}");
        }
    }

    #[test]
    fn arctangent_and_logarithm_satisfy_addition_theorems() {
        let one = DoubleDouble::from(1.0);
        assert!(relative_error(one.atan2(one), PI_DD.scaled(0.25)) < 1e-31);
        // Machin: π/4 = 4 atan(1/5) − atan(1/239).
        let fifth = one.atan2(DoubleDouble::from(5.0));
        let small = one.atan2(DoubleDouble::from(239.0));
        assert!(relative_error(fifth.scaled(4.0) - small, PI_DD.scaled(0.25)) < 1e-31);
        // ln 2 + ln 3 = ln 6.
        let ln = |x: f64| DoubleDouble::from(x).ln();
        assert!(relative_error(ln(2.0) + ln(3.0), ln(6.0)) < 1e-31);
    }

    #[test]
    fn differences_are_exact() {
        let d = difference(1.0, 1e-20);
        assert_eq!((d.hi, d.lo), (1.0, -1e-20));
    }
}
