//! Colour maps of scalar values: sequential and diverging.
//!
//! A map is a polyline through control points in Oklab (Ottosson 2020), parametrised by arc length, so that equal steps of the value are
//! perceptually equal. The sequential map is the viewer's (`viewer/src/colour.js` has the same points): its lightness increases from a dark
//! violet over blue and green to a light yellow, so that it is legible in grey and with any colour vision. The diverging map goes from
//! blue over a light grey in the middle to red; each half has its own arc length, and both ends are equally dark.

use std::f64::consts::PI;

/// A colour map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColourMap {
    /// From dark to light.
    Sequential,
    /// From blue through light grey in the middle to red.
    Diverging,
}

/// Lightness, chroma, hue in degrees.
type ControlPoint = [f64; 3];

const SEQUENTIAL_POINTS: [ControlPoint; 8] = [
    [0.24, 0.1, 300.0],
    [0.36, 0.13, 285.0],
    [0.48, 0.1, 252.0],
    [0.58, 0.09, 210.0],
    [0.68, 0.115, 165.0],
    [0.78, 0.15, 140.0],
    [0.87, 0.17, 118.0],
    [0.95, 0.13, 104.0],
];
const DIVERGING_LOWER_POINTS: [ControlPoint; 4] =
    [[0.37, 0.13, 264.0], [0.55, 0.13, 254.0], [0.76, 0.08, 245.0], [0.93, 0.0, 245.0]];
const DIVERGING_UPPER_POINTS: [ControlPoint; 4] =
    [[0.93, 0.0, 45.0], [0.77, 0.1, 45.0], [0.57, 0.16, 32.0], [0.37, 0.14, 25.0]];

/// Linear colour of zones without a value.
pub const NO_VALUE_COLOUR: [f32; 3] = [0.24; 3];

impl ColourMap {
    /// Linear sRGB at t, 0 to 1, within the gamut; t is clamped.
    pub fn colour(self, t: f64) -> [f32; 3] {
        let oklab = match self {
            ColourMap::Sequential => interpolate(&SEQUENTIAL_POINTS, t),
            ColourMap::Diverging if t < 0.5 => interpolate(&DIVERGING_LOWER_POINTS, 2.0 * t),
            ColourMap::Diverging => interpolate(&DIVERGING_UPPER_POINTS, 2.0 * t - 1.0),
        };
        oklab_to_linear_srgb(oklab).map(|x| x.clamp(0.0, 1.0) as f32)
    }
}

/// Oklab of a control point.
fn control_point_to_oklab([l, chroma, hue]: ControlPoint) -> [f64; 3] {
    let angle = hue * PI / 180.0;
    [l, chroma * angle.cos(), chroma * angle.sin()]
}

/// Oklab at the fraction t of the arc length of a polyline.
fn interpolate(points: &[ControlPoint], t: f64) -> [f64; 3] {
    let segment = |pair: &[ControlPoint]| {
        let (p, q) = (control_point_to_oklab(pair[0]), control_point_to_oklab(pair[1]));
        (p, q, (0..3).map(|k| (q[k] - p[k]).powi(2)).sum::<f64>().sqrt())
    };
    let segments = points.windows(2).map(segment);
    let mut left = t.clamp(0.0, 1.0) * segments.clone().map(|l| l.2).sum::<f64>();
    let mut end = control_point_to_oklab(points[0]);
    for (p, q, length) in segments {
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
fn oklab_to_linear_srgb([l, a, b]: [f64; 3]) -> [f64; 3] {
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
    use super::super::tone::luminance;
    use super::*;

    // Guards (pictures): false colours have the colour map of the viewer.
    /// The viewer has the same control points.
    #[test]
    fn the_sequential_map_equals_that_of_the_viewer() {
        let source = include_str!("../../../../../viewer/src/colour.js");
        let list = source.split("STATIONS = [").nth(1).and_then(|s| s.split("];").next()).unwrap();
        let numbers: Vec<f64> = list
            .split(['[', ']', ',', ' ', '\n'])
            .filter(|w| !w.is_empty())
            .map(|w| w.parse().unwrap())
            .collect();
        assert_eq!(numbers, SEQUENTIAL_POINTS.as_flattened());
    }

    #[test]
    fn maps_stay_within_the_gamut_and_are_monotone_in_lightness() {
        for points in [&SEQUENTIAL_POINTS[..], &DIVERGING_LOWER_POINTS, &DIVERGING_UPPER_POINTS] {
            for k in 0..=200 {
                let c = oklab_to_linear_srgb(interpolate(points, k as f64 / 200.0));
                assert!(c.iter().all(|x| (-0.012..=1.012).contains(x)), "{k}: {c:?}");
            }
        }
        let light = |m: ColourMap, t: f64| luminance(m.colour(t));
        for k in 0..200 {
            let (t, u) = (k as f64 / 200.0, (k + 1) as f64 / 200.0);
            assert!(light(ColourMap::Sequential, t) < light(ColourMap::Sequential, u));
            let rises = light(ColourMap::Diverging, t) < light(ColourMap::Diverging, u);
            assert_eq!(rises, k < 100, "{t}");
        }
        for m in [ColourMap::Sequential, ColourMap::Diverging] {
            assert_eq!((m.colour(-3.0), m.colour(7.0)), (m.colour(0.0), m.colour(1.0)));
        }
        // Equal modulus, about equal darkness.
        for t in [0.0, 0.1, 0.25] {
            let (a, b) = (light(ColourMap::Diverging, t), light(ColourMap::Diverging, 1.0 - t));
            assert!((a / b - 1.0).abs() < 0.35, "{t}: {a} {b}");
        }
    }
}
