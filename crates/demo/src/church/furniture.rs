//! Columns, benches, altar, candles, chandeliers.

use super::model::{ChurchMaterial, ChurchModel};
use std::f64::consts::TAU;
use zonal_math::{Vec3, vec3};

/// Height of the capitals, from which the arcades spring, m.
pub(super) const CAPITAL_HEIGHT: f64 = 5.2;

/// A round column on a square plinth, its abacus at [`CAPITAL_HEIGHT`].
pub(super) fn column(m: &mut ChurchModel, foot: Vec3, sides: usize) {
    let slab = |m: &mut ChurchModel, half: f64, z0: f64, z1: f64| {
        m.block(ChurchMaterial::Dressed, foot + vec3(-half, -half, z0), foot + vec3(half, half, z1));
    };
    slab(m, 0.58, 0.0, 0.22);
    let base = [(0.55, 0.22), (0.55, 0.30), (0.47, 0.36), (0.44, 0.42), (0.47, 0.48), (0.40, 0.54)];
    let capital = [
        (0.38, CAPITAL_HEIGHT - 0.85),
        (0.42, CAPITAL_HEIGHT - 0.82),
        (0.42, CAPITAL_HEIGHT - 0.76),
        (0.39, CAPITAL_HEIGHT - 0.72),
        (0.43, CAPITAL_HEIGHT - 0.5),
        (0.52, CAPITAL_HEIGHT - 0.28),
        (0.57, CAPITAL_HEIGHT - 0.17),
    ];
    let profile: Vec<(f64, f64)> = base.into_iter().chain(capital).collect();
    m.turned(ChurchMaterial::Dressed, foot, &profile, sides);
    slab(m, 0.62, CAPITAL_HEIGHT - 0.17, CAPITAL_HEIGHT);
}

/// A slender shaft before a wall, from `z0` up to `z1`, with a capital.
pub(super) fn shaft(m: &mut ChurchModel, foot: Vec3, z0: f64, z1: f64, sides: usize) {
    let r = 0.13;
    let profile = [
        (0.04, z0 - 0.3),
        (0.2, z0 - 0.05),
        (0.2, z0),
        (r, z0 + 0.06),
        (r, z1 - 0.45),
        (r + 0.03, z1 - 0.42),
        (r, z1 - 0.38),
        (0.24, z1 - 0.1),
        (0.26, z1 - 0.08),
        (0.26, z1),
    ];
    m.turned(ChurchMaterial::Dressed, foot, &profile, sides);
}

/// A bench facing +y, its seat from `x0` to `x1`.
pub(super) fn bench(m: &mut ChurchModel, x0: f64, x1: f64, y: f64) {
    for x in [x0, x1 - 0.06] {
        let side = [
            vec3(x, y, 0.0),
            vec3(x, y + 0.46, 0.0),
            vec3(x, y + 0.46, 0.62),
            vec3(x, y + 0.14, 0.98),
            vec3(x, y, 0.98),
        ];
        m.prism(ChurchMaterial::Oak, &side, vec3(0.06, 0.0, 0.0));
    }
    let inner = (x0 + 0.06, x1 - 0.06);
    m.block(ChurchMaterial::Oak, vec3(inner.0, y + 0.05, 0.42), vec3(inner.1, y + 0.44, 0.46));
    m.block(ChurchMaterial::Oak, vec3(inner.0, y + 0.02, 0.5), vec3(inner.1, y + 0.05, 0.92));
    m.block(ChurchMaterial::Oak, vec3(inner.0, y + 0.08, 0.1), vec3(inner.1, y + 0.12, 0.42));
}

/// A candle that stands at `foot`: wax and flame.
pub(super) fn candle(m: &mut ChurchModel, foot: Vec3, height: f64) {
    m.turned(ChurchMaterial::Wax, foot, &[(0.022, 0.0), (0.02, height)], 6);
    flame(m, foot + vec3(0.0, 0.0, height + 0.012), 0.022, 0.085);
}

fn flame(m: &mut ChurchModel, foot: Vec3, radius: f64, height: f64) {
    let tip = foot + vec3(0.0, 0.0, height);
    let belly = |k: usize| {
        let (sin, cos) = (TAU * k as f64 / 4.0 + 0.4).sin_cos();
        foot + vec3(radius * cos, radius * sin, 0.35 * height)
    };
    for k in 0..4 {
        let (a, b) = (belly(k), belly(k + 1));
        let out = foot + ((a + b) * 0.5 - foot) * 20.0;
        m.polygon(ChurchMaterial::Flame, &[a, b, tip], out);
        m.polygon(ChurchMaterial::Flame, &[a, b, foot], out);
    }
}

/// An altar with its cloth and six candles, its middle at `at`.
pub(super) fn altar(m: &mut ChurchModel, at: Vec3) {
    m.block(ChurchMaterial::Dressed, at + vec3(-1.15, -0.42, 0.0), at + vec3(1.15, 0.42, 0.92));
    m.block(ChurchMaterial::Dressed, at + vec3(-1.3, -0.52, 0.92), at + vec3(1.3, 0.52, 1.02));
    m.block(ChurchMaterial::Linen, at + vec3(-1.32, -0.36, 1.02), at + vec3(1.32, 0.36, 1.03));
    for x in [-1.1, -0.8, -0.5, 0.5, 0.8, 1.1] {
        candle(m, at + vec3(x, 0.12, 1.03), 0.42 - 0.1 * f64::abs(x));
    }
}

/// A ring with candles that hangs from the vault at `top`.
pub(super) fn chandelier(m: &mut ChurchModel, centre: Vec3, top: f64, candles: usize) {
    let (radius, n) = (0.75, 24);
    let at = |k: usize, r: f64, z: f64| {
        let (sin, cos) = (TAU * (k % n) as f64 / n as f64).sin_cos();
        centre + vec3(r * cos, r * sin, z)
    };
    for k in 0..n {
        let base = [
            at(k, radius, 0.0),
            at(k + 1, radius, 0.0),
            at(k + 1, radius + 0.03, 0.0),
            at(k, radius + 0.03, 0.0),
        ];
        m.prism(ChurchMaterial::Iron, &base, vec3(0.0, 0.0, 0.07));
    }
    let knot = centre + vec3(0.0, 0.0, 1.1);
    let thin = [[-0.008, -0.008], [0.008, -0.008], [0.008, 0.008], [-0.008, 0.008]];
    for k in 0..3 {
        let from = at(8 * k, radius + 0.015, 0.07);
        let side = (knot - from).cross(vec3(0.0, 0.0, 1.0)).normalized();
        m.sweep(ChurchMaterial::Iron, &[from, knot], side, &thin);
    }
    m.sweep(ChurchMaterial::Iron, &[knot, vec3(centre.x, centre.y, top)], vec3(1.0, 0.0, 0.0), &thin);
    for k in 0..candles {
        let (sin, cos) = (TAU * k as f64 / candles as f64).sin_cos();
        candle(m, centre + vec3((radius + 0.015) * cos, (radius + 0.015) * sin, 0.07), 0.2);
    }
}

/// A tall candlestick with five candles.
pub(super) fn candelabrum(m: &mut ChurchModel, foot: Vec3) {
    m.turned(
        ChurchMaterial::Iron,
        foot,
        &[(0.22, 0.0), (0.2, 0.05), (0.03, 0.12), (0.03, 1.35), (0.06, 1.38)],
        8,
    );
    m.block(ChurchMaterial::Iron, foot + vec3(-0.5, -0.02, 1.38), foot + vec3(0.5, 0.02, 1.42));
    for k in 0..5 {
        candle(
            m,
            foot + vec3(0.23 * (k as f64 - 2.0), 0.0, 1.42),
            0.24 + 0.05 * (2.0 - (k as f64 - 2.0).abs()),
        );
    }
}
