//! Colours of values: a range, a colour map, a linear or logarithmic scale.
//!
//! With t the position on the scale, from 0 at the low end to 1 at the high end,
//!
//! ```text
//! t = (v − low)/(high − low)          t = ln(v/low)/ln(high/low)          t = ½ + ½ v/max(|low|, |high|)
//! ```
//!
//! for a linear scale, a logarithmic scale, and a signed quantity, whose zero is in the middle of the map. Values beyond an end have its colour.

use AxisScale::{Linear, Logarithmic};
use zonal_io::output::{ColourMap, NO_VALUE_COLOUR};
use zonal_report::plot::AxisScale;

/// Half the width of the range of a single value, relative to its modulus.
const SINGLE_VALUE_HALF_WIDTH: f64 = 0.01;
/// Largest number of decades of an automatic logarithmic range, as in the viewer.
const MAX_DECADES: i32 = 3;

/// A range of values and their colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ColourScale {
    /// Value at the low end.
    pub(super) low: f64,
    /// Value at the high end.
    pub(super) high: f64,
    /// Colour map.
    pub(super) map: ColourMap,
    /// Linear or logarithmic; both ends of a logarithmic scale are above 0.
    pub(super) axis: AxisScale,
}

impl ColourScale {
    /// The scale of all finite values, of the positive ones if it is logarithmic; differences up to `rounding` count as none. `None` without such a
    /// value.
    pub(super) fn of_values(
        values: impl Iterator<Item = f64>,
        map: ColourMap,
        axis: AxisScale,
        rounding: f64,
    ) -> Option<ColourScale> {
        let (mut low, mut high) = finite_range(values.filter(|v| axis == Linear || *v > 0.0))?;
        if map == ColourMap::Diverging {
            (low, high) = (low.min(0.0), high.max(0.0));
        }
        if axis == Logarithmic {
            low = low.max(high * 10f64.powi(-MAX_DECADES));
        }
        if high - low <= rounding.max(1e-9 * high.abs()) {
            let half_width = SINGLE_VALUE_HALF_WIDTH * low.abs().max(high.abs()).max(rounding).max(1e-30);
            (low, high) = (low - half_width, high + half_width);
        }
        Some(ColourScale { low, high, map, axis })
    }

    /// Position of a value on the scale: 0 at the low end, 1 at the high end.
    pub(super) fn position(&self, v: f64) -> f64 {
        if self.axis == Logarithmic {
            return (v.max(f64::MIN_POSITIVE) / self.low).ln() / (self.high / self.low).ln();
        }
        (v - self.low) / (self.high - self.low)
    }
    /// The value at a position.
    pub(super) fn value_at(&self, position: f64) -> f64 {
        if self.axis == Logarithmic {
            return self.low * (self.high / self.low).powf(position);
        }
        self.low + position * (self.high - self.low)
    }
    /// Linear colour of a value; grey for NaN.
    pub(super) fn colour(&self, v: f64) -> [f32; 3] {
        if v.is_nan() {
            return NO_VALUE_COLOUR;
        }
        self.map.colour(match self.map {
            ColourMap::Sequential => self.position(v),
            ColourMap::Diverging => 0.5 + 0.5 * v / self.low.abs().max(self.high.abs()),
        })
    }

    /// Round values on the scale, about `count` of them.
    pub(super) fn ticks(&self, count: usize) -> Vec<f64> {
        match self.axis {
            Logarithmic => self.logarithmic_ticks(count),
            Linear => self.linear_ticks(count),
        }
    }
    fn linear_ticks(&self, count: usize) -> Vec<f64> {
        let first = ((self.high - self.low) / count.max(1) as f64).log10().floor() as i32 - 1;
        // Parsed from text, so that a tick is the double nearest to the decimal number.
        let power = |s: i64, e: i32| format!("{s}e{e}").parse::<f64>().unwrap_or(f64::NAN);
        let range = |(digit, e): &(i64, i32)| {
            let step = power(*digit, *e);
            ((self.low / step - 1e-9).ceil() as i64, (self.high / step + 1e-9).floor() as i64)
        };
        let mut steps = (first..first + 4).flat_map(|e| [(1, e), (2, e), (5, e)]);
        let few = |s: &(i64, i32)| range(s).1 - range(s).0 <= count as i64;
        let (digit, e) = steps.find(few).unwrap_or((1, first + 4));
        let (from, to) = range(&(digit, e));
        let round = |k: i64| format!("{}e{e}", k * digit).parse().unwrap_or(f64::NAN);
        (from..=to).map(round).collect()
    }
    fn logarithmic_ticks(&self, count: usize) -> Vec<f64> {
        let decades = (self.high / self.low).log10();
        if decades < 0.7 {
            return self.linear_ticks(count);
        }
        let digits: &[u32] = match decades {
            d if d > 4.0 => &[1],
            d if d > 1.5 => &[1, 3],
            _ => &[1, 2, 5],
        };
        let all = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
        let every = (decades / count.max(1) as f64).ceil().max(1.0) as i32;
        all.filter(|e| decades <= 4.0 || e.rem_euclid(every) == 0)
            .flat_map(|e| digits.iter().map(move |d| format!("{d}e{e}").parse().unwrap_or(f64::NAN)))
            .filter(|x| (-1e-9..=1.0 + 1e-9).contains(&self.position(*x)))
            .collect()
    }
}

/// Smallest and largest finite value; `None` without one.
pub(super) fn finite_range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|v| v.is_finite()).fold(None, |e, v| {
        let (low, high) = e.unwrap_or((v, v));
        Some((low.min(v), high.max(v)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_io::output::ColourMap::{Diverging, Sequential};

    fn scale_of(values: &[f64], map: ColourMap, axis: AxisScale) -> Option<ColourScale> {
        ColourScale::of_values(values.iter().copied(), map, axis, 0.0)
    }

    #[test]
    fn range_is_that_of_the_values() {
        let s = scale_of(&[1200.0, f64::NAN, 400.0, 900.0], Sequential, Linear).unwrap();
        assert_eq!((s.low, s.high), (400.0, 1200.0));
        assert_eq!((s.position(400.0), s.position(1200.0), s.position(800.0)), (0.0, 1.0, 0.5));
        // A signed scale has zero in its middle, whatever its ends.
        let s = scale_of(&[-20.0, 50.0], Diverging, Linear).unwrap();
        assert_eq!((s.low, s.high, s.colour(0.0)), (-20.0, 50.0, Diverging.colour(0.5)));
        assert_eq!(s.colour(50.0), Diverging.colour(1.0));
        assert_eq!(s.colour(-20.0), Diverging.colour(0.3));
        let s = scale_of(&[3.0, 5.0], Diverging, Linear).unwrap();
        assert_eq!((s.low, s.high), (0.0, 5.0));
        // A single value, rounding, zero, no value.
        let s = scale_of(&[900.0], Sequential, Linear).unwrap();
        assert!(s.low < 900.0 && s.high > 900.0 && s.position(900.0) == 0.5);
        let s = ColourScale::of_values([1e-9, -2e-9].into_iter(), Diverging, Linear, 1e-3).unwrap();
        assert!(s.position(1e-9) > 0.4 && s.position(1e-9) < 0.6);
        let s = scale_of(&[0.0], Diverging, Linear).unwrap();
        assert!(s.low < 0.0 && s.high > 0.0);
        assert_eq!(scale_of(&[f64::NAN], Sequential, Linear), None);
        assert_eq!(scale_of(&[0.0, -1.0], Sequential, Logarithmic), None);
        let s = scale_of(&[0.0, 1e-9, 10.0], Sequential, Logarithmic).unwrap();
        assert!((s.low - 0.01).abs() < 1e-12 && s.high == 10.0);
        assert!((s.position(s.value_at(0.3)) - 0.3).abs() < 1e-12);
        assert_eq!(s.colour(0.0), Sequential.colour(0.0));
    }

    #[test]
    fn values_out_of_range_have_the_colour_of_the_end_and_nan_is_grey() {
        for map in [Sequential, Diverging] {
            let s = ColourScale { low: -2.0, high: 2.0, map, axis: Linear };
            assert_eq!((s.colour(-9.0), s.colour(9.0)), (map.colour(0.0), map.colour(1.0)));
            assert_eq!((s.colour(f64::NEG_INFINITY), s.colour(f64::NAN)), (map.colour(0.0), NO_VALUE_COLOUR));
        }
    }

    #[test]
    fn ticks_are_round_and_in_range() {
        let ticks = |low, high, axis, n| ColourScale { low, high, map: Sequential, axis }.ticks(n);
        assert_eq!(ticks(400.0, 1200.0, Linear, 5), [400.0, 600.0, 800.0, 1000.0, 1200.0]);
        assert_eq!(ticks(-24.26, 53.92, Linear, 5), [-20.0, 0.0, 20.0, 40.0]);
        assert_eq!(ticks(1e5, 9e5, Linear, 3), [2e5, 4e5, 6e5, 8e5]);
        assert_eq!(ticks(0.1, 0.72, Linear, 5), [0.2, 0.4, 0.6]);
        assert_eq!(ticks(3.0, 400.0, Logarithmic, 5), [3.0, 10.0, 30.0, 100.0, 300.0]);
        assert_eq!(ticks(1e-8, 1.0, Logarithmic, 4), [1e-8, 1e-6, 1e-4, 1e-2, 1.0]);
        assert_eq!(ticks(900.0, 1100.0, Logarithmic, 4), [900.0, 950.0, 1000.0, 1050.0, 1100.0]);
        for n in 2..9 {
            let t = ticks(957.3, 1103.2, Linear, n);
            assert!(!t.is_empty() && t.len() <= n + 1, "{n}: {t:?}");
        }
    }
}
