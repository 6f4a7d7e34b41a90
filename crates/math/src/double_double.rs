//! Double-double arithmetic: about 106 bits in unevaluated sums of two doubles (Dekker 1971).
//!
//! Sums by Knuth's TwoSum, products by a fused multiply-add, each renormalised to |lo| ≤ ulp(hi)/2.

/// An unevaluated sum hi + lo of two doubles, |lo| ≤ ulp(hi)/2.
///
/// ```
/// use zonal_math::double_double::DoubleDouble;
/// let third = DoubleDouble::new(1.0).div(DoubleDouble::new(3.0));
/// let error = third.mul(DoubleDouble::new(3.0)).sub(DoubleDouble::new(1.0));
/// assert_eq!(third.hi, 1.0 / 3.0);
/// assert!(error.hi.abs() < 1e-31);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct DoubleDouble {
    /// The value rounded to a double.
    pub hi: f64,
    /// The rounding error of `hi`.
    pub lo: f64,
}

// Methods in place of operators: each step costs several operations.
#[allow(clippy::should_implement_trait)]
impl DoubleDouble {
    /// The exact value of a double.
    pub fn new(x: f64) -> DoubleDouble {
        DoubleDouble { hi: x, lo: 0.0 }
    }
    fn renormalized(hi: f64, lo: f64) -> DoubleDouble {
        let s = hi + lo;
        DoubleDouble { hi: s, lo: lo - (s - hi) }
    }
    /// The sum.
    pub fn add(self, o: DoubleDouble) -> DoubleDouble {
        let s = self.hi + o.hi;
        let v = s - self.hi;
        let e = (self.hi - (s - v)) + (o.hi - v);
        DoubleDouble::renormalized(s, e + self.lo + o.lo)
    }
    /// The difference.
    pub fn sub(self, o: DoubleDouble) -> DoubleDouble {
        self.add(DoubleDouble { hi: -o.hi, lo: -o.lo })
    }
    /// The product.
    pub fn mul(self, o: DoubleDouble) -> DoubleDouble {
        let p = self.hi * o.hi;
        let e = self.hi.mul_add(o.hi, -p);
        DoubleDouble::renormalized(p, e + (self.hi * o.lo + self.lo * o.hi))
    }
    /// The quotient.
    pub fn div(self, o: DoubleDouble) -> DoubleDouble {
        let q = self.hi / o.hi;
        let remainder = self.sub(o.mul(DoubleDouble::new(q)));
        DoubleDouble::renormalized(q, remainder.hi / o.hi)
    }
}
