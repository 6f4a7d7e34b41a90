//! Colours of single values: one map for what has a least and a largest value, one for what has a sign.
//!
//! A map is a line through stations in Oklab (Ottosson, 2020), walked at an even pace, so that equal steps of the value look equally
//! large. The plain one is the viewer's (`viewer/src/colour.js` has the same stations): its lightness rises all the way from a dark violet
//! over blue and green to a light yellow, so that it reads in grey and with any kind of colour vision. The one with a sign goes from
//! blue over a light grey, its middle, to red; its halves have a pace of their own and are equally dark at their ends.

use std::f64::consts::PI;

/// A colour map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColourMap {
    /// From dark to light.
    Plain,
    /// From blue by light grey, the middle, to red.
    Signed,
}

/// Lightness, chroma, hue in degrees.
type Station = [f64; 3];

const PLAIN: [Station; 8] = [
    [0.24, 0.1, 300.0],
    [0.36, 0.13, 285.0],
    [0.48, 0.1, 252.0],
    [0.58, 0.09, 210.0],
    [0.68, 0.115, 165.0],
    [0.78, 0.15, 140.0],
    [0.87, 0.17, 118.0],
    [0.95, 0.13, 104.0],
];
const BELOW: [Station; 4] =
    [[0.37, 0.13, 264.0], [0.55, 0.13, 254.0], [0.76, 0.08, 245.0], [0.93, 0.0, 245.0]];
const ABOVE: [Station; 4] = [[0.93, 0.0, 45.0], [0.77, 0.1, 45.0], [0.57, 0.16, 32.0], [0.37, 0.14, 25.0]];

/// The colour, linear, of zones that have no value.
pub const NO_VALUE: [f32; 3] = [0.24; 3];

impl ColourMap {
    /// Linear sRGB of the map at t, 0 to 1, within what a screen shows; beyond, that of the end.
    pub fn colour(self, t: f64) -> [f32; 3] {
        let lab = match self {
            ColourMap::Plain => walk(&PLAIN, t),
            ColourMap::Signed if t < 0.5 => walk(&BELOW, 2.0 * t),
            ColourMap::Signed => walk(&ABOVE, 2.0 * t - 1.0),
        };
        linear(lab).map(|x| x.clamp(0.0, 1.0) as f32)
    }
}

/// Oklab of a station.
fn lab([l, chroma, hue]: Station) -> [f64; 3] {
    let angle = hue * PI / 180.0;
    [l, chroma * angle.cos(), chroma * angle.sin()]
}

/// Oklab at the share t of a line through stations.
fn walk(stations: &[Station], t: f64) -> [f64; 3] {
    let leg = |pair: &[Station]| {
        let (p, q) = (lab(pair[0]), lab(pair[1]));
        (p, q, (0..3).map(|k| (q[k] - p[k]).powi(2)).sum::<f64>().sqrt())
    };
    let legs = stations.windows(2).map(leg);
    let mut left = t.clamp(0.0, 1.0) * legs.clone().map(|l| l.2).sum::<f64>();
    let mut end = lab(stations[0]);
    for (p, q, length) in legs {
        let f = (left / length).min(1.0);
        end = [0, 1, 2].map(|k| p[k] + f * (q[k] - p[k]));
        if left <= length {
            break;
        }
        left -= length;
    }
    end
}

/// Oklab to linear sRGB.
fn linear([l, a, b]: [f64; 3]) -> [f64; 3] {
    let x = (l + 0.3963377774 * a + 0.2158037573 * b).powi(3);
    let y = (l - 0.1055613458 * a - 0.0638541728 * b).powi(3);
    let z = (l - 0.0894841775 * a - 1.291485548 * b).powi(3);
    [
        4.0767416621 * x - 3.3077115913 * y + 0.2309699292 * z,
        -1.2684380046 * x + 2.6097574011 * y - 0.3413193965 * z,
        -0.0041960863 * x - 0.7034186147 * y + 1.707614701 * z,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::tone::luminance;

    /// The viewer's page has the same stations.
    #[test]
    fn the_plain_map_is_the_viewer_s() {
        let source = include_str!("../../../../viewer/src/colour.js");
        let list = source.split("STATIONS = [").nth(1).and_then(|s| s.split("];").next()).unwrap();
        let numbers: Vec<f64> = list
            .split(['[', ']', ',', ' ', '\n'])
            .filter(|w| !w.is_empty())
            .map(|w| w.parse().unwrap())
            .collect();
        assert_eq!(numbers, PLAIN.as_flattened());
    }

    #[test]
    fn maps_stay_within_the_screen_and_keep_their_order() {
        for stations in [&PLAIN[..], &BELOW, &ABOVE] {
            for k in 0..=200 {
                let c = linear(walk(stations, k as f64 / 200.0));
                assert!(c.iter().all(|x| (-0.012..=1.012).contains(x)), "{k}: {c:?}");
            }
        }
        let light = |m: ColourMap, t: f64| luminance(m.colour(t));
        for k in 0..200 {
            let (t, u) = (k as f64 / 200.0, (k + 1) as f64 / 200.0);
            assert!(light(ColourMap::Plain, t) < light(ColourMap::Plain, u));
            let rises = light(ColourMap::Signed, t) < light(ColourMap::Signed, u);
            assert_eq!(rises, k < 100, "{t}");
        }
        for m in [ColourMap::Plain, ColourMap::Signed] {
            assert_eq!((m.colour(-3.0), m.colour(7.0)), (m.colour(0.0), m.colour(1.0)));
        }
        // Equal modulus, about equal darkness.
        for t in [0.0, 0.1, 0.25] {
            let (a, b) = (light(ColourMap::Signed, t), light(ColourMap::Signed, 1.0 - t));
            assert!((a / b - 1.0).abs() < 0.35, "{t}: {a} {b}");
        }
    }
}
