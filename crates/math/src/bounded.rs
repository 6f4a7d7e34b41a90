//! Values with error radii: `value ± radius` with the kind of evidence for the radius (midpoint-radius arithmetic).
//!
//! Sums and scalings enlarge the radius by their own rounding errors; a sum has the weaker grade of its terms.

use std::ops::{Add, Mul};

/// Kind of evidence for an error radius, from strong to weak; a sum has the weakest grade of its terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Grade {
    /// A proved bound that covers truncation, quadrature and rounding.
    Proved,
    /// An estimate from the difference of two approximations.
    Estimated,
    /// A standard error of a sample.
    Statistical,
}

impl Grade {
    /// The name in reports and tables.
    pub fn name(self) -> &'static str {
        match self {
            Grade::Proved => "proved",
            Grade::Estimated => "estimated",
            Grade::Statistical => "statistical",
        }
    }
}

/// `value ± radius` with the grade of the evidence; value and radius have the same unit.
///
/// ```
/// use zonal_math::{Bounded, Grade};
/// let sum = Bounded::proved(1.0, 0.1) + Bounded::estimated(2.0, 0.2) * 2.0;
/// assert_eq!((sum.value, sum.grade), (5.0, Grade::Estimated));
/// assert!(sum.contains(5.5) && !sum.contains(5.6));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounded {
    /// The approximation.
    pub value: f64,
    /// The error radius, not negative.
    pub radius: f64,
    /// Evidence for the radius.
    pub grade: Grade,
}

impl Bounded {
    /// Exactly zero, proved.
    pub const ZERO: Bounded = Bounded { value: 0.0, radius: 0.0, grade: Grade::Proved };

    /// A value whose radius is proved.
    pub fn proved(value: f64, radius: f64) -> Bounded {
        Bounded { value, radius, grade: Grade::Proved }
    }
    /// A value whose radius is estimated.
    pub fn estimated(value: f64, radius: f64) -> Bounded {
        Bounded { value, radius, grade: Grade::Estimated }
    }
    /// True when `x` lies within the radius.
    pub fn contains(self, x: f64) -> bool {
        (self.value - x).abs() <= self.radius
    }
}

impl Add for Bounded {
    type Output = Bounded;
    /// The radius includes the rounding of both sums.
    fn add(self, o: Bounded) -> Bounded {
        let value = self.value + o.value;
        let radius = (self.radius + o.radius) * (1.0 + 2.0 * f64::EPSILON) + value.abs() * f64::EPSILON;
        Bounded { value, radius, grade: self.grade.max(o.grade) }
    }
}

impl Mul<f64> for Bounded {
    type Output = Bounded;
    /// Scales by an exact factor; the radius includes the rounding.
    fn mul(self, s: f64) -> Bounded {
        let value = self.value * s;
        let radius = self.radius * s.abs() * (1.0 + 2.0 * f64::EPSILON) + value.abs() * f64::EPSILON;
        Bounded { value, radius, grade: self.grade }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Guards (numbers): a sum has the weakest grade of its terms (proved, estimated, statistical).
    #[test]
    fn the_weaker_grade_wins_in_a_sum() {
        let s = Bounded::proved(1.0, 0.1) + Bounded { value: 2.0, radius: 0.2, grade: Grade::Statistical };
        assert_eq!(s.grade, Grade::Statistical);
        assert!(s.contains(3.3) && !s.contains(3.31));
    }

    #[test]
    fn radius_of_a_sum_includes_rounding() {
        let s = Bounded::proved(1.0, 0.0) + Bounded::proved(1e-17, 0.0);
        assert!(s.radius > 0.0);
    }
}
