//! Pseudo-random numbers, points and directions.

use std::f64::consts::TAU;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Band, Bands, Plate, PlateKind};

/// Xorshift64* (Marsaglia 2003, Vigna 2016), seeded.
#[derive(Clone, Debug)]
pub struct Rng(u64);

impl Rng {
    /// The generator of a seed.
    pub fn new(seed: u64) -> Rng {
        let mut rng = Rng(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0xD1B5_4A32_D192_ED03);
        if rng.0 == 0 {
            rng.0 = 1;
        }
        (0..16).for_each(|_| {
            rng.uniform();
        });
        rng
    }
    /// A number uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64
    }
    /// A number uniform in [lo, hi).
    pub fn uniform_in(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.uniform()
    }
    /// A point uniform in the box [lo, hi].
    pub fn point_in_box(&mut self, lo: Vec3, hi: Vec3) -> Vec3 {
        let u = vec3(self.uniform(), self.uniform(), self.uniform());
        lo + (hi - lo).scale(u)
    }
    /// A point uniform on a plate.
    pub(crate) fn point_on_plate(&mut self, p: &Plate) -> Vec3 {
        let (mut u, mut v) = (self.uniform(), self.uniform());
        if p.kind == PlateKind::Triangle && u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        p.origin + p.e1 * u + p.e2 * v
    }
    /// A unit vector uniform over the sphere.
    pub fn unit_vector(&mut self) -> Vec3 {
        let z = 2.0 * self.uniform() - 1.0;
        let turn = TAU * self.uniform();
        let r = (1.0 - z * z).max(0.0).sqrt();
        vec3(r * turn.cos(), r * turn.sin(), z)
    }
    /// A unit vector of cosine density about the unit vector `n`: the normalized sum of `n` and a uniform unit vector.
    pub fn cosine_direction(&mut self, n: Vec3) -> Vec3 {
        loop {
            let d = n + self.unit_vector();
            if d.length2() > 1e-12 {
                return d / d.length();
            }
        }
    }
}

/// The first band whose running sum of the weights exceeds `u`; the last band if there is none.
pub(crate) fn select_band(weights: Bands, u: f64) -> Band {
    let (mut selected, mut sum) = (Band::first(), 0.0);
    for b in Band::all() {
        selected = b;
        sum += weights[b];
        if u < sum {
            break;
        }
    }
    selected
}

/// Mixes two numbers into one (the finalizer of SplitMix64; Steele, Lea and Flood 2014).
pub(crate) fn hash(a: u64, b: u64) -> u64 {
    let mut z = a.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(b).wrapping_add(0x9E37_79B9_7F4A_7C15);
    for _ in 0..2 {
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
    }
    z
}
