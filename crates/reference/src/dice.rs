//! Random numbers, points and directions.

use std::f64::consts::TAU;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Plate, PlateKind};

/// Xorshift64* (Marsaglia 2003, Vigna 2016), seeded.
#[derive(Clone, Debug)]
pub struct Dice(u64);

impl Dice {
    /// A stream of numbers of its own for each seed.
    pub fn new(seed: u64) -> Dice {
        let mut d = Dice(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0xD1B5_4A32_D192_ED03);
        if d.0 == 0 {
            d.0 = 1;
        }
        (0..16).for_each(|_| {
            d.roll();
        });
        d
    }
    /// Uniform in [0, 1).
    pub fn roll(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64
    }
    /// Uniform in [lo, hi).
    pub fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.roll()
    }
    /// Uniform in a box.
    pub fn in_box(&mut self, lo: Vec3, hi: Vec3) -> Vec3 {
        let u = vec3(self.roll(), self.roll(), self.roll());
        lo + (hi - lo).scale(u)
    }
    /// Uniform on a plate.
    pub fn on_plate(&mut self, p: &Plate) -> Vec3 {
        let (mut u, mut v) = (self.roll(), self.roll());
        if p.kind == PlateKind::Triangle && u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        p.origin + p.e1 * u + p.e2 * v
    }
    /// Uniform over the sphere.
    pub fn direction(&mut self) -> Vec3 {
        let z = 2.0 * self.roll() - 1.0;
        let turn = TAU * self.roll();
        let r = (1.0 - z * z).max(0.0).sqrt();
        vec3(r * turn.cos(), r * turn.sin(), z)
    }
    /// Of cosine density about the unit vector `n`: a uniform direction added to n (Lambert's sphere).
    pub fn cosine(&mut self, n: Vec3) -> Vec3 {
        loop {
            let d = n + self.direction();
            if d.length2() > 1e-12 {
                return d / d.length();
            }
        }
    }
}
