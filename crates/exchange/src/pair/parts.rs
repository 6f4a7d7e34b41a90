//! Pairs with a cut voxel: sums over the samples of its part, or its centre from afar.

use super::rays::{FIRST_RAYS, MORE_RAYS};
use super::spread::Spread;
use super::zone::{Shape, Zone};
use super::{Counts, Exchange, PairFactor};
use crate::aligned::{Cuboid, FactorCache};
use crate::general::{self, Moments};
use zonal_math::{Vec3, vec3};
use zonal_scene::part::coordinates;
use zonal_scene::zones::SUBCELLS;
use zonal_scene::{Plate, Sample};

/// Beyond this many diameters a cut voxel is seen as a point.
pub(super) const PART_FAR: f64 = 3.0;

/// Pieces of space not as many of their diagonals from a plate's rim as this are beside it, and so are pieces that it may divide.
const BESIDE: f64 = 1.0;

/// A sub-cell whose sample stands for all of its volume up to this share is whole.
const WHOLE: f64 = 1e-3;

/// Times that a sub-cell is halved along its edges: once where it is cut or near a plate, further beside it.
const HALVINGS: usize = 4;

/// Offsets of sub-cells between two cells that touch.
pub(super) const SUB_SPAN: usize = 2 * SUBCELLS;

impl Exchange<'_> {
    /// Pairs with a cut voxel: sums over its samples where it is near, the centres where it is far.
    pub(super) fn with_part(&self, a: &Zone, b: &Zone, seed: u64, counts: &mut Counts) -> PairFactor {
        let near = (a.centre - b.centre).length() < PART_FAR * (a.size.max(b.size));
        let rays = if near { MORE_RAYS } else { FIRST_RAYS };
        let (plate, pane, part) = match (&a.shape, &b.shape) {
            (Shape::Plate { plate, pane }, _) => (plate, pane, b),
            (_, Shape::Plate { plate, pane }) => (plate, pane, a),
            _ => return self.average(a, b, self.part_volume(a, b), seed, rays, counts),
        };
        if !near {
            let (once, off) = (std::iter::once((part.middle, part.measure)), far_error(part, plate));
            let m = general::points_plate(plate, once, pane.is_some(), off);
            return self.average(a, b, m, seed, rays, counts);
        }
        let (finer, off) = self.beside(part, plate);
        let (a, b) = if std::ptr::eq(part, a) { (&finer, b) } else { (a, &finer) };
        let points = finer.samples().unwrap_or_default().iter().map(|s| (s.point, s.volume));
        let m = general::points_plate(plate, points, pane.is_some(), off);
        self.average(a, b, m, seed, rays, counts)
    }

    /// A cut voxel with more samples near a plate, finer ones beside it, where its solid angle varies from nothing to 2π over a sub-cell. A grid
    /// of points takes the place of each sample, those that it sees. With the relative error of all together.
    fn beside(&self, z: &Zone, plate: &Plate) -> (Zone, f64) {
        let edges = (z.hi - z.lo) * (1.0 / SUBCELLS as f64);
        let free = |x: Vec3, y: Vec3| !self.transport.blocked(x, y);
        let h = edges.length() / 3.0f64.sqrt();
        let mut all = Vec::new();
        let mut points = Vec::new();
        let (mut off, mut weights) = (0.0, 0.0);
        for s in z.samples().unwrap_or_default() {
            let lo = z.lo + edges.scale(coordinates(s.subcell));
            let cut = (1.0 - s.volume / edges.product()).max(0.0);
            let (whole, near) = (cut < WHOLE, beside(plate, lo + edges * 0.5, edges));
            let d = (s.point - plate.centre()).length().max(0.5 * h);
            let weight = s.volume / (d + 0.4 * plate.diameter()).powi(2);
            weights += weight;
            off += weight * sample_error(cut, h, d, plate, near);
            if !near {
                // The sample of a cut sub-cell is the centroid of what is free there.
                all.push(Sample { point: if whole { lo + edges * 0.5 } else { s.point }, ..*s });
                continue;
            }
            points.clear();
            grid(plate, (lo, edges), (s.point, s.volume), &free, 0, &mut points);
            all.extend(points.iter().map(|&(point, volume)| Sample { point, volume, ..*s }));
        }
        (Zone { shape: Shape::Part(all), ..z.clone() }, off / weights)
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
        // The kernel about the centres of the free parts instead of those of the cells, to the second order.
        let whole = Spread::whole(cell);
        let (parts, cells) = (a.spread.and(b.spread), whole.and(whole));
        let (d, between) = (b.middle - a.middle, (b.lo + b.hi - a.lo - a.hi) * 0.5);
        let (bent, even) = (parts.bend(d), cells.bend(between));
        let shift = between.length2() / d.length2();
        let share = a.measure * b.measure / cell.product().powi(2);
        let mean = c.mean_distance / shift.sqrt();
        let value = c.factor.value * share * shift * (1.0 + bent) / (1.0 + even);
        // What follows is smaller in turn.
        let factor = zonal_math::Bounded::estimated(value, value * (bent - even).abs());
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

/// True where a piece of space of these edges is not told by its middle. The solid angle of a plate is a harmonic function of the point as
/// long as the plate does not divide the piece, and varies over the distance d from its rim: the middle of a cube of edge h then tells the
/// mean up to 0.04 (h/d)⁴, however near the plate itself is.
fn beside(plate: &Plate, middle: Vec3, edges: Vec3) -> bool {
    let (d, n, size) = (middle - plate.centre(), plate.normal(), edges.length());
    let far = d.length() - 0.5 * plate.diameter();
    if far > BESIDE * size {
        return false;
    }
    let reach = 0.5 * (0..3).map(|k| n[k].abs() * edges[k]).sum::<f64>();
    let height = d.dot(n).abs();
    if height < 0.999 * reach {
        return height.max(far) < BESIDE * size;
    }
    let (corners, count) = plate.corners();
    (0..count).any(|i| from_segment(corners[i], corners[(i + 1) % count], middle) < BESIDE * size)
}

/// Distance of a point from the line between two others.
fn from_segment(a: Vec3, b: Vec3, x: Vec3) -> f64 {
    let (along, to) = (b - a, x - a);
    let t = (to.dot(along) / along.length2()).clamp(0.0, 1.0);
    (to - along * t).length()
}

/// Relative error of a part taken at its centre: the solid angle is harmonic, so that only the uneven spread counts, with second
/// derivatives of about 4/d² in it.
fn far_error(part: &Zone, plate: &Plate) -> f64 {
    2.0 * part.spread.uneven() / (part.middle - plate.centre()).length2()
}

/// Relative error of a sub-cell of edge h of which a share was cut off, d away from the middle of a plate. At its centroid: what its
/// uneven spread, about h²/12 of the share, makes of second derivatives; by a grid beside the plate: pieces a quarter as wide lie off
/// their middles by half that share. A whole one errs by 0.04 (h/d)⁴, at most by what halving leaves.
fn sample_error(cut: f64, h: f64, d: f64, plate: &Plate, beside: bool) -> f64 {
    let reach = d + 0.4 * plate.diameter();
    let (spread, even) = (cut * h * h / (6.0 * reach * reach), 0.04 * (h / d).powi(4).min(1.0 / 9.0));
    even + spread + if beside { 0.25 * cut.min(0.25) * h / reach } else { 0.0 }
}

/// Points of a grid over a piece of a voxel that are `free` from `from`, each with its share of the `volume`; finer beside the plate.
fn grid(
    plate: &Plate,
    (lo, edges): (Vec3, Vec3),
    (from, volume): (Vec3, f64),
    free: &impl Fn(Vec3, Vec3) -> bool,
    depth: usize,
    out: &mut Vec<(Vec3, f64)>,
) {
    let piece = edges * 0.5;
    let corner = |k: usize| lo + piece.scale(vec3((k >> 2) as f64, (k >> 1 & 1) as f64, (k & 1) as f64));
    let centre = |k: usize| corner(k) + piece * 0.5;
    let open: Vec<usize> = (0..8).filter(|&k| free(from, centre(k))).collect();
    if open.is_empty() {
        out.push((from, volume));
    }
    for &k in &open {
        let (at, volume) = (centre(k), volume / open.len() as f64);
        if depth + 1 < HALVINGS && beside(plate, at, piece) {
            grid(plate, (corner(k), piece), (at, volume), free, depth + 1, out);
        } else {
            out.push((at, volume));
        }
    }
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

#[cfg(test)]
mod tests {
    use super::super::spread::centroid;
    use super::*;

    #[test]
    fn a_small_plate_beside_samples_sees_what_is_there() {
        let (lo, cell) = (vec3(-0.4, 0.2, 0.0), vec3(0.8, 0.9, 0.7));
        let edges = cell * (1.0 / SUBCELLS as f64);
        // Narrow, level with a row of samples or a little off it, in the middle or askew, one- and two-sided.
        for (x, lean, two_sided) in [
            (0.1001, 0.0, false),
            (0.0999, 0.0, false),
            (0.15, 0.0, true),
            (0.02, 0.4, false),
            (-0.1, -0.7, true),
        ] {
            let up = vec3(lean, 0.0, 1.0).normalized() * 0.3;
            let plate = Plate::parallelogram(vec3(x, 0.5, 0.2), vec3(0.0, 0.05, 0.0), up);
            let exact = general::plate_cuboid(&plate, lo, lo + cell, two_sided, 1e-3);
            let mut points = Vec::new();
            for s in whole_samples(cell) {
                let lo = lo + edges.scale(coordinates(s.subcell));
                grid(&plate, (lo, edges), (lo + edges * 0.5, s.volume), &|_, _| true, 0, &mut points);
            }
            let volume: f64 = points.iter().map(|p| p.1).sum();
            assert!((volume / cell.product() - 1.0).abs() < 1e-12);
            let ours = general::points_plate(&plate, points.into_iter(), two_sided, 0.0);
            let off = ours.factor.value / exact.factor.value - 1.0;
            assert!(
                off.abs() < 0.015 && (ours.mean / exact.mean - 1.0).abs() < 0.02,
                "x {x} lean {lean}: {off}"
            );
        }
    }

    #[test]
    fn parts_from_afar_are_known_to_their_radius() {
        let cell = vec3(1.0, 0.9, 1.2);
        let mut dice = (0u64..).map(|k| zonal_math::sequence::unit(k + 7));
        let mut roll = || dice.next().unwrap_or(0.5);
        let (mut worst, mut sum) = (0.0f64, 0.0);
        const CASES: usize = 60;
        for case in 0..CASES {
            // Whole cells beyond planes of any direction, as samples.
            let mut part = |lo: Vec3| {
                let n = vec3(roll() - 0.5, roll() - 0.5, roll() - 0.5).normalized();
                let level = (roll() - 0.6) * 0.8;
                let mut s = whole_samples(cell);
                s.retain(|s| n.dot(s.point - cell * 0.5) > level);
                s.iter_mut().for_each(|s| s.point += lo);
                s
            };
            let offset = [2.0 + (case % 3) as f64, (case % 4) as f64, -((case % 2) as f64)];
            let lo = cell.scale(Vec3::from_array(offset));
            let (p, q) = (part(Vec3::ZERO), part(lo));
            if p.is_empty() || q.is_empty() {
                continue;
            }
            let centre = |s: &[Sample]| {
                let all: f64 = s.iter().map(|s| s.volume).sum();
                (centroid(s), all)
            };
            let ((a, va), (b, vb)) = (centre(&p), centre(&q));
            let own = Spread::whole(cell * (1.0 / SUBCELLS as f64));
            let kernel = |s: &Sample, t: &Sample| {
                let d = t.point - s.point;
                s.volume * t.volume / d.length2() * (1.0 + own.and(own).bend(d))
            };
            let exact: f64 = p.iter().flat_map(|s| q.iter().map(move |t| kernel(s, t))).sum();
            let (d, whole) = (b - a, Spread::whole(cell));
            let (bent, even) =
                (Spread::of(&p, a, cell).and(Spread::of(&q, b, cell)).bend(d), whole.and(whole).bend(lo));
            let ours = va * vb / d.length2() * (1.0 + bent);
            let off = (ours / exact - 1.0).abs();
            worst = worst.max(off);
            sum += (off / (bent - even).abs().max(1e-4)).min(9.0);
        }
        assert!(worst < 0.02 && sum / (CASES as f64) < 1.0, "{worst} {sum}");
    }

    #[test]
    fn only_what_a_sample_sees_stands_for_it() {
        let plate = Plate::parallelogram(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        let mut points = Vec::new();
        let above = |_: Vec3, y: Vec3| y.z > 0.0;
        let piece = (vec3(0.3, 0.3, -0.12), vec3(0.2, 0.2, 0.2));
        grid(&plate, piece, (vec3(0.4, 0.4, 0.04), 1.0), &above, 0, &mut points);
        assert!(points.iter().all(|p| p.0.z > 0.0));
        assert!((points.iter().map(|p| p.1).sum::<f64>() - 1.0).abs() < 1e-12);
        points.clear();
        grid(&plate, piece, (vec3(0.4, 0.4, 0.04), 1.0), &|_, _| false, 0, &mut points);
        assert_eq!(points, [(vec3(0.4, 0.4, 0.04), 1.0)]);
    }
}
