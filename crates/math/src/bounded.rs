//! A value, how far it may be from the truth, and how we know.

use std::ops::{Add, Mul};

/// The evidence behind an error radius. Ordered from strong to weak: in a sum the weaker one wins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Grade {
    /// The radius is a theorem: truncation, quadrature and rounding are all inside it.
    Proved,
    /// The radius comes from comparing two approximations.
    Estimated,
    /// The radius is a standard error of a sample.
    Statistical,
}

impl Grade {
    /// The word that reports and tables use.
    pub fn word(self) -> &'static str {
        match self {
            Grade::Proved => "proved",
            Grade::Estimated => "estimated",
            Grade::Statistical => "statistical",
        }
    }
}

/// `value ± radius`, with the grade of the evidence; value and radius share their unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounded {
    /// The approximation.
    pub value: f64,
    /// The error radius, not negative.
    pub radius: f64,
    /// How the radius is known.
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
    /// A value whose radius is a standard error.
    pub fn statistical(value: f64, radius: f64) -> Bounded {
        Bounded { value, radius, grade: Grade::Statistical }
    }
    /// True when `x` lies within the radius.
    pub fn contains(self, x: f64) -> bool {
        (self.value - x).abs() <= self.radius
    }
}

impl Add for Bounded {
    type Output = Bounded;
    /// The rounding of the two sums is inside the radius.
    fn add(self, o: Bounded) -> Bounded {
        let value = self.value + o.value;
        let radius = (self.radius + o.radius) * (1.0 + 2.0 * f64::EPSILON) + value.abs() * f64::EPSILON;
        Bounded { value, radius, grade: self.grade.max(o.grade) }
    }
}

impl Mul<f64> for Bounded {
    type Output = Bounded;
    /// Scales by an exact factor; the rounding is inside the radius.
    fn mul(self, s: f64) -> Bounded {
        let value = self.value * s;
        let radius = self.radius * s.abs() * (1.0 + 2.0 * f64::EPSILON) + value.abs() * f64::EPSILON;
        Bounded { value, radius, grade: self.grade }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weaker_grade_wins_in_a_sum() {
        let s = Bounded::proved(1.0, 0.1) + Bounded::statistical(2.0, 0.2);
        assert_eq!(s.grade, Grade::Statistical);
        assert!(s.contains(3.3) && !s.contains(3.31));
    }

    #[test]
    fn rounding_of_a_sum_is_inside() {
        let s = Bounded::proved(1.0, 0.0) + Bounded::proved(1e-17, 0.0);
        assert!(s.radius > 0.0);
    }
}
