//! Pairs with a cut voxel: sums over the samples of its part, or its centre from afar.

use super::rays::{FIRST_RAYS, MORE_RAYS};
use super::zone::{Shape, Zone};
use super::{Counts, Exchange, PairFactor};
use crate::aligned::{Cuboid, FactorCache};
use crate::general::{self, Moments};
use zonal_math::{Vec3, vec3};
use zonal_scene::zones::SUBCELLS;
use zonal_scene::{Plate, Sample};

/// Beyond this many diameters a cut voxel is seen as a point.
pub(super) const PART_FAR: f64 = 3.0;

/// Offsets of sub-cells between two cells that touch.
pub(super) const SUB_SPAN: usize = 2 * SUBCELLS;

impl Exchange<'_> {
    /// Pairs with a cut voxel: sums over its samples where it is near, the centres where it is far.
    pub(super) fn with_part(&self, a: &Zone, b: &Zone, seed: u64, counts: &mut Counts) -> PairFactor {
        let near = (a.centre - b.centre).length() < PART_FAR * (a.size.max(b.size));
        let m = match (&a.shape, &b.shape) {
            (Shape::Plate { plate, pane }, _) => part_plate(b, plate, pane.is_some(), near),
            (_, Shape::Plate { plate, pane }) => part_plate(a, plate, pane.is_some(), near),
            _ => self.part_volume(a, b),
        };
        let rays = if near { MORE_RAYS } else { FIRST_RAYS };
        self.average(a, b, m, seed, rays, counts)
    }

    /// Two volume zones, at least one of them cut.
    pub(super) fn part_volume(&self, a: &Zone, b: &Zone) -> Moments {
        let cell = a.hi - a.lo;
        let offset = [0, 1, 2].map(|x| ((b.lo[x] - a.lo[x]) / cell[x]).round() as i64);
        if offset.iter().all(|o| o.abs() <= 1) {
            let whole;
            let (sa, sb) = match (a.samples(), b.samples()) {
                (Some(p), Some(q)) => (p, q),
                (Some(p), None) => {
                    whole = whole_samples(cell);
                    (p, &whole[..])
                }
                (None, Some(q)) => {
                    whole = whole_samples(cell);
                    (&whole[..], q)
                }
                (None, None) => unreachable!("one of the two is cut"),
            };
            return self.subcell_sum(offset, sa, sb);
        }
        let (p, q) = (a.aligned.as_ref().expect("aligned"), b.aligned.as_ref().expect("aligned"));
        let c = self.cache.get_cumulants(p, q);
        // The kernel at the centres of the free parts instead of those of the cells.
        let d2 = (a.centre - b.centre).length2();
        let cells = ((a.lo + a.hi) * 0.5 - (b.lo + b.hi) * 0.5).length2();
        let shift = cells / d2;
        let share = a.measure * b.measure / cell.product().powi(2);
        let mean = c.mean_distance / shift.sqrt();
        let value = c.factor.value * share * shift;
        let factor = zonal_math::Bounded::estimated(value, value * (1.0 - shift).abs().min(1.0));
        Moments { factor, mean, variance: c.variance, third: c.third }
    }

    /// Σ over the sub-cells of two parts whose cells lie `offset` apart, at most one cell on an axis.
    pub(super) fn subcell_sum(&self, offset: [i64; 3], a: &[Sample], b: &[Sample]) -> Moments {
        let s = SUBCELLS as i64;
        let volume = self.sub_volume();
        let at = |k: u8| [k as i64 / (s * s), k as i64 / s % s, k as i64 % s];
        let mut sums = [0.0; 4];
        for p in a {
            let pa = at(p.subcell);
            for q in b {
                let qb = at(q.subcell);
                let d = [0, 1, 2].map(|x| (offset[x] * s + qb[x] - pa[x]).unsigned_abs() as usize);
                let [value, r, rr, rrr] = self.subcells[(d[0] * SUB_SPAN + d[1]) * SUB_SPAN + d[2]];
                let w = value * (p.volume / volume) * (q.volume / volume);
                sums = [sums[0] + w, sums[1] + w * r, sums[2] + w * rr, sums[3] + w * rrr];
            }
        }
        general::moments_of(sums, self.tolerance * sums[0])
    }

    pub(super) fn sub_volume(&self) -> f64 {
        let z = self.items.get(self.zones.voxel_offset());
        (z.hi - z.lo).product() / (SUBCELLS * SUBCELLS * SUBCELLS) as f64
    }
}

/// A cut voxel and a plate: Σ over samples of the solid angle, or the centre where `near` is false.
pub(super) fn part_plate(z: &Zone, plate: &Plate, two_sided: bool, near: bool) -> Moments {
    let Shape::Part(samples) = &z.shape else {
        return whole_plate(z, plate, two_sided);
    };
    if near {
        general::points_plate(plate, samples.iter().map(|s| (s.point, s.volume)), two_sided)
    } else {
        general::points_plate(plate, std::iter::once((z.centre, z.measure)), two_sided)
    }
}

pub(super) fn whole_plate(z: &Zone, plate: &Plate, two_sided: bool) -> Moments {
    general::plate_cuboid(plate, z.lo, z.hi, two_sided, 1e-2)
}

/// The samples of a whole cell, at the centres of its sub-cells, relative to its corner.
pub(super) fn whole_samples(cell: Vec3) -> Vec<Sample> {
    let n = SUBCELLS;
    let volume = cell.product() / (n * n * n) as f64;
    (0..n * n * n)
        .map(|k| {
            let c = [k / (n * n), k / n % n, k % n].map(|c| (c as f64 + 0.5) / n as f64);
            Sample { point: cell.scale(Vec3::from_array(c)), volume, subcell: k as u8 }
        })
        .collect()
}

/// 𝓕, ⟨r⟩, ⟨r²⟩ and ⟨r³⟩ of two sub-cells by their offset, |offset| < 2·SUBCELLS on each axis.
pub(super) fn subcell_table(cell: Vec3, cache: &FactorCache) -> Vec<[f64; 4]> {
    let n = SUB_SPAN;
    let a = Cuboid { lo: Vec3::ZERO, hi: cell, normal: None };
    (0..n * n * n)
        .map(|k| {
            let d = vec3((k / (n * n)) as f64, (k / n % n) as f64, (k % n) as f64);
            let lo = cell.scale(d);
            let c = cache.get_cumulants(&a, &Cuboid { lo, hi: lo + cell, normal: None });
            let (m, v) = (c.mean_distance, c.variance);
            [c.factor.value, m, m * m + v, c.third + m * (3.0 * v + m * m)]
        })
        .collect()
}
