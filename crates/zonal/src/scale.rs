//! From a value to its colour: a range, a map, linear or logarithmic.
//!
//! ```text
//! t = (v − low)/(high − low)          t = ln(v/low)/ln(high/low)          t = ½ + ½ v/max(|low|, |high|)
//! ```
//!
//! linear, logarithmic, and about zero for what has a sign. t goes to the map; beyond the range the colour is that of its end.

use zonal_io::output::{ColourMap, NO_VALUE};

/// How much of its modulus a range has on either side of a value that is the only one.
const ALONE: f64 = 0.01;
/// Decades that a logarithmic range has at most, where the values decide; as in the viewer.
const DECADES: i32 = 3;

/// A range of values and their colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The least value that has a colour of its own.
    pub low: f64,
    /// The largest.
    pub high: f64,
    /// The colours.
    pub map: ColourMap,
    /// Logarithmic; both ends are above 0 then.
    pub log: bool,
}

impl Scale {
    /// A scale for values; what is not finite among them is left aside. Differences up to `floor` are no differences. `None` where no
    /// value serves.
    pub fn of(values: impl Iterator<Item = f64>, map: ColourMap, log: bool, floor: f64) -> Option<Scale> {
        let (mut low, mut high) = ends(values.filter(|v| !log || *v > 0.0))?;
        if map == ColourMap::Signed {
            (low, high) = (low.min(0.0), high.max(0.0));
        }
        if log {
            low = low.max(high * 10f64.powi(-DECADES));
        }
        if high - low <= floor.max(1e-9 * high.abs()) {
            let room = ALONE * low.abs().max(high.abs()).max(floor).max(1e-30);
            (low, high) = (low - room, high + room);
        }
        Some(Scale { low, high, map, log })
    }

    /// The place of a value on the scale, 0 at the low end and 1 at the high one.
    pub fn place(&self, v: f64) -> f64 {
        if self.log {
            return (v.max(f64::MIN_POSITIVE) / self.low).ln() / (self.high / self.low).ln();
        }
        (v - self.low) / (self.high - self.low)
    }
    /// The value at a place.
    pub fn at(&self, place: f64) -> f64 {
        if self.log {
            return self.low * (self.high / self.low).powf(place);
        }
        self.low + place * (self.high - self.low)
    }
    /// The colour of a value, linear; grey where it is not a number.
    pub fn colour(&self, v: f64) -> [f32; 3] {
        if v.is_nan() {
            return NO_VALUE;
        }
        self.map.colour(match self.map {
            ColourMap::Plain => self.place(v),
            ColourMap::Signed => 0.5 + 0.5 * v / self.low.abs().max(self.high.abs()),
        })
    }

    /// Round values on the scale, some `count` of them.
    pub fn ticks(&self, count: usize) -> Vec<f64> {
        if self.log { self.powers(count) } else { self.steps(count) }
    }
    fn steps(&self, count: usize) -> Vec<f64> {
        let first = ((self.high - self.low) / count.max(1) as f64).log10().floor() as i32 - 1;
        // From text, so that a tick is the double next to the decimal number.
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
    fn powers(&self, count: usize) -> Vec<f64> {
        let decades = (self.high / self.low).log10();
        if decades < 0.7 {
            return self.steps(count);
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
            .filter(|x| (-1e-9..=1.0 + 1e-9).contains(&self.place(*x)))
            .collect()
    }
}

/// The least and the largest of what is finite among values; `None` where nothing is.
pub fn ends(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|v| v.is_finite()).fold(None, |e, v| {
        let (low, high) = e.unwrap_or((v, v));
        Some((low.min(v), high.max(v)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_io::output::ColourMap::{Plain, Signed};

    fn of(values: &[f64], map: ColourMap, log: bool) -> Option<Scale> {
        Scale::of(values.iter().copied(), map, log, 0.0)
    }

    #[test]
    fn ranges_are_those_of_the_values() {
        let s = of(&[1200.0, f64::NAN, 400.0, 900.0], Plain, false).unwrap();
        assert_eq!((s.low, s.high), (400.0, 1200.0));
        assert_eq!((s.place(400.0), s.place(1200.0), s.place(800.0)), (0.0, 1.0, 0.5));
        // What has a sign is about zero, whatever its ends.
        let s = of(&[-20.0, 50.0], Signed, false).unwrap();
        assert_eq!((s.low, s.high, s.colour(0.0)), (-20.0, 50.0, Signed.colour(0.5)));
        assert_eq!(s.colour(50.0), Signed.colour(1.0));
        assert_eq!(s.colour(-20.0), Signed.colour(0.3));
        let s = of(&[3.0, 5.0], Signed, false).unwrap();
        assert_eq!((s.low, s.high), (0.0, 5.0));
        // One value alone, rounding, nothing.
        let s = of(&[900.0], Plain, false).unwrap();
        assert!(s.low < 900.0 && s.high > 900.0 && s.place(900.0) == 0.5);
        let s = Scale::of([1e-9, -2e-9].into_iter(), Signed, false, 1e-3).unwrap();
        assert!(s.place(1e-9) > 0.4 && s.place(1e-9) < 0.6);
        let s = of(&[0.0], Signed, false).unwrap();
        assert!(s.low < 0.0 && s.high > 0.0);
        assert_eq!(of(&[f64::NAN], Plain, false), None);
        assert_eq!(of(&[0.0, -1.0], Plain, true), None);
        let s = of(&[0.0, 1e-9, 10.0], Plain, true).unwrap();
        assert!((s.low - 0.01).abs() < 1e-12 && s.high == 10.0);
        assert!((s.place(s.at(0.3)) - 0.3).abs() < 1e-12);
        assert_eq!(s.colour(0.0), Plain.colour(0.0));
    }

    #[test]
    fn what_is_beyond_has_the_colour_of_the_end_and_what_is_no_number_is_grey() {
        for map in [Plain, Signed] {
            let s = Scale { low: -2.0, high: 2.0, map, log: false };
            assert_eq!((s.colour(-9.0), s.colour(9.0)), (map.colour(0.0), map.colour(1.0)));
            assert_eq!((s.colour(f64::NEG_INFINITY), s.colour(f64::NAN)), (map.colour(0.0), NO_VALUE));
        }
    }

    #[test]
    fn ticks_are_round_and_within() {
        let ticks = |low, high, log, n| Scale { low, high, map: Plain, log }.ticks(n);
        assert_eq!(ticks(400.0, 1200.0, false, 5), [400.0, 600.0, 800.0, 1000.0, 1200.0]);
        assert_eq!(ticks(-24.26, 53.92, false, 5), [-20.0, 0.0, 20.0, 40.0]);
        assert_eq!(ticks(1e5, 9e5, false, 3), [2e5, 4e5, 6e5, 8e5]);
        assert_eq!(ticks(0.1, 0.72, false, 5), [0.2, 0.4, 0.6]);
        assert_eq!(ticks(3.0, 400.0, true, 5), [3.0, 10.0, 30.0, 100.0, 300.0]);
        assert_eq!(ticks(1e-8, 1.0, true, 4), [1e-8, 1e-6, 1e-4, 1e-2, 1.0]);
        assert_eq!(ticks(900.0, 1100.0, true, 4), [900.0, 950.0, 1000.0, 1050.0, 1100.0]);
        for n in 2..9 {
            let t = ticks(957.3, 1103.2, false, n);
            assert!(!t.is_empty() && t.len() <= n + 1, "{n}: {t:?}");
        }
    }
}
