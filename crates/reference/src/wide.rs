//! Numbers of about 106 bits: an unevaluated sum of two doubles (Dekker 1971; Knuth's two-sum, products with one fused
//! multiply–add), and the few functions that closed forms need. Slow and plain; for abscissae, corner sums and exact differences.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// hi + lo, |lo| ≤ ulp(hi)/2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wide {
    /// The number, rounded.
    pub hi: f64,
    /// What the rounding left.
    pub lo: f64,
}

/// ln 2 to 107 bits.
const LN_2: Wide = Wide { hi: std::f64::consts::LN_2, lo: 2.319_046_813_846_299_6e-17 };
/// π to 107 bits.
pub const PI: Wide = Wide { hi: std::f64::consts::PI, lo: 1.224_646_799_147_353_2e-16 };

/// a + b exactly.
pub fn sum(a: f64, b: f64) -> Wide {
    let s = a + b;
    let v = s - a;
    Wide { hi: s, lo: (a - (s - v)) + (b - v) }
}

/// a − b exactly.
pub fn difference(a: f64, b: f64) -> Wide {
    sum(a, -b)
}

fn settled(hi: f64, lo: f64) -> Wide {
    let s = hi + lo;
    Wide { hi: s, lo: lo - (s - hi) }
}

impl Wide {
    /// Zero.
    pub const ZERO: Wide = Wide { hi: 0.0, lo: 0.0 };

    /// The nearest double.
    pub fn rounded(self) -> f64 {
        self.hi + self.lo
    }
    /// True above zero.
    pub fn is_positive(self) -> bool {
        self.hi > 0.0
    }
    /// Times a power of two.
    fn scaled(self, s: f64) -> Wide {
        Wide { hi: self.hi * s, lo: self.lo * s }
    }
    /// The larger of two.
    pub fn max(self, o: Wide) -> Wide {
        if (self - o).hi >= 0.0 { self } else { o }
    }
    /// The smaller of two.
    pub fn min(self, o: Wide) -> Wide {
        if (self - o).hi <= 0.0 { self } else { o }
    }
    /// The square root of a number that is not negative.
    pub fn sqrt(self) -> Wide {
        if self.hi <= 0.0 {
            return Wide::ZERO;
        }
        let r = self.hi.sqrt();
        let rest = self - Wide::from(r) * Wide::from(r);
        settled(r, rest.hi / (2.0 * r))
    }
    /// e^x, |x| < 700: x = k ln 2 + 64 y, e^y − 1 by Taylor's series, six squarings of 1 + m as m → 2m + m².
    pub fn exp(self) -> Wide {
        let k = (self.hi / LN_2.hi).round();
        let y = (self - LN_2 * Wide::from(k)).scaled(1.0 / 64.0);
        let (mut term, mut m) = (y, y);
        for n in 2..=14 {
            term = term * y / Wide::from(n as f64);
            m = m + term;
        }
        for _ in 0..6 {
            m = m.scaled(2.0) + m * m;
        }
        let e = Wide::from(1.0) + m;
        let half = 2f64.powi((k * 0.5) as i32);
        e.scaled(half).scaled(2f64.powi(k as i32 - (k * 0.5) as i32))
    }
    /// The natural logarithm of a positive number: one step of Newton from the double's.
    pub fn ln(self) -> Wide {
        let l = Wide::from(self.hi.ln());
        let d = self * (-l).exp() - Wide::from(1.0);
        l + d - (d * d).scaled(0.5)
    }
    /// (cos, sin) of a double, |x| < 4: Taylor's series of x/32, the angle doubled five times (1 − cos is what is carried).
    fn cos_sin(x: f64) -> (Wide, Wide) {
        let y = Wide::from(x / 32.0);
        let y2 = y * y;
        let (mut sin, mut versed) = (y, y2.scaled(0.5));
        let (mut ts, mut tc) = (y, y2.scaled(0.5));
        for n in 1..=9 {
            let n = n as f64;
            ts = -ts * y2 / Wide::from(2.0 * n * (2.0 * n + 1.0));
            tc = -tc * y2 / Wide::from((2.0 * n + 1.0) * (2.0 * n + 2.0));
            (sin, versed) = (sin + ts, versed + tc);
        }
        let one = Wide::from(1.0);
        for _ in 0..5 {
            (sin, versed) = ((sin * (one - versed)).scaled(2.0), (sin * sin).scaled(2.0));
        }
        (one - versed, sin)
    }
    /// The angle of the point (x, self), x ≥ 0, in [−π/2, π/2]: the double's angle and the small rest.
    pub fn atan2(self, x: Wide) -> Wide {
        if self.hi == 0.0 {
            return Wide::ZERO;
        }
        let a = self.hi.atan2(x.hi);
        let (c, s) = Wide::cos_sin(a);
        let (up, along) = (self * c - x * s, x * c + self * s);
        Wide::from(a) + up / along
    }
}

impl From<f64> for Wide {
    fn from(x: f64) -> Wide {
        Wide { hi: x, lo: 0.0 }
    }
}
impl Neg for Wide {
    type Output = Wide;
    fn neg(self) -> Wide {
        Wide { hi: -self.hi, lo: -self.lo }
    }
}
impl Add for Wide {
    type Output = Wide;
    fn add(self, o: Wide) -> Wide {
        let (s, t) = (sum(self.hi, o.hi), sum(self.lo, o.lo));
        let s = settled(s.hi, s.lo + t.hi);
        settled(s.hi, s.lo + t.lo)
    }
}
impl Sub for Wide {
    type Output = Wide;
    fn sub(self, o: Wide) -> Wide {
        self + -o
    }
}
impl Mul for Wide {
    type Output = Wide;
    fn mul(self, o: Wide) -> Wide {
        let p = self.hi * o.hi;
        let e = self.hi.mul_add(o.hi, -p);
        settled(p, e + (self.hi * o.lo + self.lo * o.hi))
    }
}
impl Div for Wide {
    type Output = Wide;
    fn div(self, o: Wide) -> Wide {
        let q = self.hi / o.hi;
        let rest = self - o * Wide::from(q);
        let q1 = rest.hi / o.hi;
        let rest = rest - o * Wide::from(q1);
        settled(q, q1) + Wide::from(rest.hi / o.hi)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn off(a: Wide, b: Wide) -> f64 {
        ((a - b) / b).hi.abs()
    }

    #[test]
    fn functions_undo_each_other_to_thirty_digits() {
        for x in [1e-3, 0.37, 1.0, 5.5, 300.0] {
            let w = Wide::from(x) / Wide::from(3.0);
            assert!(off(w.sqrt() * w.sqrt(), w) < 1e-31);
            assert!(off(w.exp().ln(), w) < 1e-28, "{x}");
            assert!(off(w.exp() * (-w).exp(), Wide::from(1.0)) < 1e-29, "{x}");
        }
    }

    #[test]
    fn the_quarter_of_pi_and_an_addition_theorem() {
        let one = Wide::from(1.0);
        assert!(off(one.atan2(one), PI.scaled(0.25)) < 1e-31);
        // Machin: π/4 = 4 atan(1/5) − atan(1/239).
        let fifth = one.atan2(Wide::from(5.0));
        let small = one.atan2(Wide::from(239.0));
        assert!(off(fifth.scaled(4.0) - small, PI.scaled(0.25)) < 1e-31);
        // ln 2 + ln 3 = ln 6.
        let ln = |x: f64| Wide::from(x).ln();
        assert!(off(ln(2.0) + ln(3.0), ln(6.0)) < 1e-31);
    }

    #[test]
    fn differences_are_exact() {
        let d = difference(1.0, 1e-20);
        assert_eq!((d.hi, d.lo), (1.0, -1e-20));
    }
}
