//! Procedural textures of stone, tiles and wood: periodic and deterministic.
//!
//! Noise is a sum of octaves of smooth interpolation between hashed values on a lattice that repeats with the picture. All values are linear
//! and multiply the material's reflectance; they are about 1 at most.

use zonal_math::low_discrepancy::hash_to_unit;
use zonal_scene::Texture;

fn lattice(x: i64, y: i64, n: i64, seed: u64) -> f64 {
    let (x, y) = (x.rem_euclid(n) as u64, y.rem_euclid(n) as u64);
    hash_to_unit(seed.wrapping_mul(0x9e37_79b9).wrapping_add(y * 8191 + x))
}

/// Value noise of `n` cells across the picture, 0 to 1; (u, v) in 0…1.
fn smooth(u: f64, v: f64, n: i64, seed: u64) -> f64 {
    let (x, y) = (u * n as f64, v * n as f64);
    let (i, j) = (x.floor() as i64, y.floor() as i64);
    let ease = |t: f64| t * t * (3.0 - 2.0 * t);
    let (s, t) = (ease(x - x.floor()), ease(y - y.floor()));
    let row = |j: i64| lattice(i, j, n, seed) * (1.0 - s) + lattice(i + 1, j, n, seed) * s;
    row(j) * (1.0 - t) + row(j + 1) * t
}

/// Octaves of noise about 0, −1 to 1.
fn cloudy(u: f64, v: f64, n: i64, octaves: u32, seed: u64) -> f64 {
    let octave = |k: u32| (smooth(u, v, n << k, seed + k as u64) - 0.5) * 0.5f64.powi(k as i32);
    (0..octaves).map(octave).sum()
}

fn picture(side: usize, colour: impl Fn(f64, f64) -> [f64; 3]) -> Texture {
    let at = |i: usize| {
        let (x, y) = (i % side, i / side);
        let c = colour((x as f64 + 0.5) / side as f64, (y as f64 + 0.5) / side as f64);
        c.map(|x| x.clamp(0.02, 1.0) as f32)
    };
    Texture { width: side, height: side, pixels: (0..side * side).map(at).collect() }
}

/// Distance to the nearest border of a cell of 0…1, in cells.
fn rim(f: f64) -> f64 {
    f.min(1.0 - f)
}

/// Courses of blocks: `rows` rows of `columns` blocks, every other row set off by half a block; depth of the joint's shade.
fn courses(side: usize, rows: f64, columns: f64, shade: f64, spread: f64, joint: f64) -> Texture {
    picture(side, |u, v| {
        let row = (v * rows).floor();
        let shift = if row as i64 % 2 == 0 { 0.0 } else { 0.5 };
        let x = u * columns + shift;
        let block = lattice(x.floor() as i64, row as i64, columns as i64, 7 + row as u64);
        let warmth = lattice(x.floor() as i64, row as i64, columns as i64, 91 + row as u64) - 0.5;
        let edge = (rim(x - x.floor()) / columns).min(rim(v * rows - row) / rows);
        let mortar = (1.0 - edge / joint).clamp(0.0, 1.0);
        let grain = 0.16 * cloudy(u, v, 8, 5, 3)
            + 0.05 * (lattice((u * side as f64) as i64, (v * side as f64) as i64, side as i64, 5) - 0.5);
        let tone = (0.9 + spread * (block - 0.5) + grain) * (1.0 - shade * mortar);
        [tone * (1.0 + 0.06 * warmth), tone, tone * (1.0 - 0.09 * warmth)]
    })
}

/// Ashlar, 3.2 m a side.
pub(super) fn ashlar() -> Texture {
    courses(512, 8.0, 4.0, 0.34, 0.22, 0.004)
}

/// Webs of vaults: small courses under limewash, 3 m a side.
pub(super) fn web() -> Texture {
    courses(256, 16.0, 8.0, 0.13, 0.08, 0.004)
}

/// Dressed stone: grain only, 1.5 m a side.
pub(super) fn dressed() -> Texture {
    picture(256, |u, v| {
        let tone = 0.92 + 0.14 * cloudy(u, v, 6, 5, 21) + 0.05 * (smooth(u, v, 128, 77) - 0.5);
        [tone, tone * 0.995, tone * 0.985]
    })
}

/// Floor: light and dark squares set diagonally, small dark insets at the corners, worn; 2 m a side.
pub(super) fn tiles() -> Texture {
    picture(512, |u, v| {
        let (a, b) = ((u + v) * 4.0, (u - v) * 4.0);
        let dark = (a.floor() + b.floor()).rem_euclid(2.0) > 0.5;
        let (fa, fb) = (a - a.floor(), b - b.floor());
        let joint = (1.0 - rim(fa).min(rim(fb)) / 0.022).clamp(0.0, 1.0);
        let inset = rim(fa) + rim(fb) < 0.2;
        let own = lattice(a.floor() as i64, b.floor() as i64, 64, 13) - 0.5;
        let worn = 0.18 * cloudy(u, v, 4, 6, 31);
        let base = if inset {
            [0.23, 0.11, 0.09]
        } else if dark {
            [0.34, 0.30, 0.28]
        } else {
            [0.93, 0.87, 0.76]
        };
        base.map(|x: f64| x * (1.0 + 0.16 * own + worn) * (1.0 - 0.4 * joint))
    })
}

/// Oak with its grain along v, 1 m a side.
pub(super) fn oak() -> Texture {
    picture(256, |u, v| {
        let bend = 0.02 * cloudy(u, v, 3, 3, 41);
        let grain = 0.5 * (smooth(u + bend, v * 0.25, 48, 43) - 0.5)
            + 0.3 * (smooth(u + bend, v * 0.5, 96, 47) - 0.5);
        let plank = 0.1 * (lattice((u * 6.0) as i64, 0, 6, 51) - 0.5);
        let tone = 0.78 + 0.45 * grain + plank;
        [tone, tone * 0.93, tone * 0.85]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_are_periodic_and_in_range() {
        for t in [ashlar(), web(), dressed(), tiles(), oak()] {
            assert!(t.pixels.iter().flatten().all(|x| (0.02..=1.0).contains(x)));
            let mean = t.pixels.iter().map(|p| p[1] as f64).sum::<f64>() / t.pixels.len() as f64;
            assert!((0.4..0.98).contains(&mean), "{mean}");
        }
        assert!((smooth(0.0, 0.3, 8, 1) - smooth(1.0, 0.3, 8, 1)).abs() < 1e-12);
    }
}
