//! Plates whose corners carry rounding noise: the radius holds and is about the noise times the length of the edges, not many orders more.

use zonal_exchange::{AccuracyRequest, ZoneShape, factor};
use zonal_math::{Vec3, vec3};
use zonal_scene::Plate;

/// Two perpendicular squares of side 0.1 with a common edge: A F (Howell's C-14), m².
const EXACT_FACTOR: f64 = 0.01 * 0.200_043_776_075_403_16;

/// Noise from −1 to 1 of a fixed sequence.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// The two squares as 32 triangles each, whose corners at the common edge lie up to `noise` m beside the other's plane, `off` m from the origin.
fn squares(noise: f64, off: Vec3) -> [Vec<ZoneShape>; 2] {
    const N: usize = 4;
    let mut dice = Noise(7);
    let hair: Vec<f64> = (0..=N).map(|_| noise * dice.next()).collect();
    let corner = |wall: bool, i: usize, j: usize| {
        let (x, y) = (0.1 * i as f64 / N as f64, 0.1 * j as f64 / N as f64);
        let y = if j == 0 { hair[i] } else { y };
        off + if wall { vec3(x, 0.0, y) } else { vec3(x, y, 0.0) }
    };
    [false, true].map(|wall| {
        let mut out = Vec::new();
        for i in 0..N {
            for j in 0..N {
                let [a, b, c, d] =
                    [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|[i, j]| corner(wall, i, j));
                let mut push = |p: Vec3, q: Vec3, r: Vec3| {
                    // Fronts face each other.
                    let plate = if wall { Plate::triangle(p, r, q) } else { Plate::triangle(p, q, r) };
                    out.push(ZoneShape::Plate(plate));
                };
                push(a, b, c);
                push(a, c, d);
            }
        }
        out
    })
}

// Guards (numbers): rounded corners widen the radii of plates by about the rounding times the edges.
/// Reproduction: trial of 2026 (`plates01.toml`). Noise of 1e-13 made the radius ten million times too wide.
#[test]
fn rounded_corners_widen_radii_by_about_the_rounding() {
    for off in [Vec3::ZERO, vec3(1000.0, -1000.0, 500.0)] {
        // The corners of a scene a kilometre away are rounded to 1e-13 m themselves.
        let rounding = 1e-16 + f64::EPSILON * off.max_abs();
        for noise in [0.0, 1e-16, 1e-15, 1e-14, 1e-13, 3e-13, 1e-12, 1e-11, 1e-10] {
            let [floor, wall] = squares(noise, off);
            let (mut value, mut radius) = (0.0, 0.0);
            for a in &floor {
                for b in &wall {
                    let f = factor(a, b, 0.0, AccuracyRequest::relative(1e-10)).bounded;
                    (value, radius) = (value + f.value, radius + f.radius);
                }
            }
            // The noise changes at most a strip along the edge of 0.1 m on both squares.
            let moved = 2.0 * 0.1 * (noise + rounding);
            let off_by = (value - EXACT_FACTOR).abs();
            assert!(off_by <= radius + moved + 2e-13, "noise {noise:e}: {value} ± {radius:e}");
            assert!(
                radius <= 1e-9 * EXACT_FACTOR + 10.0 * moved,
                "noise {noise:e} at {off:?}: radius {radius:e}"
            );
        }
    }
}
