//! Pairs with a cut voxel: sums over the samples of its free part at small distance, its centroid at large distance.

use super::exchange::Exchange;
use super::pair_factor::{PairCounts, PairFactor};
use super::prepared_zone::{PreparedShape, PreparedZone};
use super::ray_average::ZonePair;
use super::second_moments::SecondMoments;
use super::subcells::{SUBCELL_OFFSETS, whole_samples};
use crate::pair::visibility::ray_samples::{FIRST_RAYS, PARTIAL_RAYS};
use crate::solid_angle_quadrature::{self, DistanceMoments};
use zonal_math::{Bounded, Vec3, vec3};
use zonal_scene::SUBCELLS;
use zonal_scene::voxel_samples::subcell_coordinates;
use zonal_scene::{Plate, VolumeSample};

/// Distance in diameters beyond which a cut voxel is represented by its centroid.
pub(super) const MIN_POINT_DISTANCE: f64 = 3.0;

/// Distance from the rim of a plate, in diagonals of a piece of space, below which the piece is refined.
const MIN_RIM_DISTANCE: f64 = 1.0;

/// Cut share of the volume below which a sub-cell counts as whole.
const MAX_CUT_OF_WHOLE_SUBCELL: f64 = 1e-3;

/// Halvings of a sub-cell along its edges near the rim of a plate, at most.
const MAX_HALVINGS: usize = 4;

impl Exchange<'_> {
    /// A pair with a cut voxel: sums over its samples at small distance, the centroid at large distance.
    pub(super) fn cut_voxel_pair(&self, pair: ZonePair, counts: &mut PairCounts) -> PairFactor {
        let ZonePair { a, b, .. } = pair;
        let near = (a.centre - b.centre).length() < MIN_POINT_DISTANCE * (a.diameter.max(b.diameter));
        let rays = if near { PARTIAL_RAYS } else { FIRST_RAYS };
        let (plate, pane, part) = match (&a.shape, &b.shape) {
            (PreparedShape::Plate { plate, pane }, _) => (plate, pane, b),
            (_, PreparedShape::Plate { plate, pane }) => (plate, pane, a),
            _ => return self.ray_average(pair, self.volume_moments(a, b), rays, counts),
        };
        if !near {
            let (once, off) = (std::iter::once((part.centroid, part.measure)), far_error(part, plate));
            let m = solid_angle_quadrature::plate_and_points(
                plate,
                once,
                solid_angle_quadrature::sides_of_pane(*pane),
                off,
            );
            return self.ray_average(pair, m, rays, counts);
        }
        let (finer, off) = self.refined_near_plate(part, plate);
        let (a, b) = if std::ptr::eq(part, a) { (&finer, b) } else { (a, &finer) };
        let points = finer.samples().unwrap_or_default().iter().map(|s| (s.point, s.volume));
        let m = solid_angle_quadrature::plate_and_points(
            plate,
            points,
            solid_angle_quadrature::sides_of_pane(*pane),
            off,
        );
        self.ray_average(ZonePair { a, b, ..pair }, m, rays, counts)
    }

    /// A cut voxel with refined samples near a plate, whose solid angle varies from 0 to 2π over a sub-cell. A grid of points visible from
    /// a sample replaces it. Returns the relative error of all samples as well.
    fn refined_near_plate(&self, z: &PreparedZone, plate: &Plate) -> (PreparedZone, f64) {
        let edges = (z.hi - z.lo) * (1.0 / SUBCELLS as f64);
        let free = |x: Vec3, y: Vec3| !self.transport.occluded(x, y);
        let mut refinement = SampleRefinement { plate, free, points: Vec::new() };
        let h = edges.length() / 3.0f64.sqrt();
        let mut all = Vec::new();
        let (mut off, mut weights) = (0.0, 0.0);
        for s in z.samples().unwrap_or_default() {
            let lo = z.lo + edges.scale(subcell_coordinates(s.subcell));
            let cut = (1.0 - s.volume / edges.product()).max(0.0);
            let (whole, near) = (cut < MAX_CUT_OF_WHOLE_SUBCELL, is_near_rim(plate, lo + edges * 0.5, edges));
            let d = (s.point - plate.centre()).length().max(0.5 * h);
            let weight = s.volume / (d + 0.4 * plate.diameter()).powi(2);
            weights += weight;
            off += weight * sample_error(cut, h, d, plate, near);
            if !near {
                // The sample of a cut sub-cell is the centroid of its free part.
                all.push(VolumeSample { point: if whole { lo + edges * 0.5 } else { s.point }, ..*s });
                continue;
            }
            refinement.add_points(lo, edges, s.point, s.volume, 0);
            all.extend(refinement.points.drain(..).map(|(point, volume)| VolumeSample {
                point,
                volume,
                ..*s
            }));
        }
        (PreparedZone { shape: PreparedShape::CutVoxel(all), ..z.clone() }, off / weights)
    }

    /// Two volume zones, at least one of them cut.
    pub(super) fn volume_moments(&self, a: &PreparedZone, b: &PreparedZone) -> DistanceMoments {
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
        let whole = SecondMoments::whole(cell);
        let (parts, cells) = (a.second_moments.sum(b.second_moments), whole.sum(whole));
        let (d, between) = (b.centroid - a.centroid, (b.lo + b.hi - a.lo - a.hi) * 0.5);
        let (part_correction, cell_correction) =
            (parts.inverse_square_correction(d), cells.inverse_square_correction(between));
        let shift = between.length2() / d.length2();
        let share = a.measure * b.measure / cell.product().powi(2);
        let mean_distance = c.mean_distance / shift.sqrt();
        let value = c.factor.value * share * shift * (1.0 + part_correction) / (1.0 + cell_correction);
        // Terms of higher order are smaller than the second.
        let factor = Bounded::estimated(value, value * (part_correction - cell_correction).abs());
        DistanceMoments { factor, mean_distance, variance: c.variance, third_cumulant: c.third_cumulant }
    }

    /// Σ over the sub-cells of two parts whose cells lie `offset` apart, at most one cell on an axis.
    pub(super) fn subcell_sum(
        &self,
        offset: [i64; 3],
        a: &[VolumeSample],
        b: &[VolumeSample],
    ) -> DistanceMoments {
        let s = SUBCELLS as i64;
        let volume = self.sub_volume();
        let at = |k: u8| [k as i64 / (s * s), k as i64 / s % s, k as i64 % s];
        let mut sums = [0.0; 4];
        for p in a {
            let pa = at(p.subcell);
            for q in b {
                let qb = at(q.subcell);
                let d = [0, 1, 2].map(|x| (offset[x] * s + qb[x] - pa[x]).unsigned_abs() as usize);
                let [value, r, rr, rrr] =
                    self.subcells[(d[0] * SUBCELL_OFFSETS + d[1]) * SUBCELL_OFFSETS + d[2]];
                let w = value * (p.volume / volume) * (q.volume / volume);
                sums = [sums[0] + w, sums[1] + w * r, sums[2] + w * rr, sums[3] + w * rrr];
            }
        }
        DistanceMoments::from_power_sums(sums, self.tolerance * sums[0])
    }

    pub(super) fn sub_volume(&self) -> f64 {
        let z = self.prepared.get(self.zones.voxel_index(0));
        (z.hi - z.lo).product() / (SUBCELLS * SUBCELLS * SUBCELLS) as f64
    }
}

/// True where the solid angle at the centre of a piece of space of these edges does not represent its mean. The solid angle of a plate is a
/// harmonic function of the point as
/// long as the plate does not divide the piece, and varies over the distance d from its rim: the centre of a cube of edge h then gives the
/// mean up to 0.04 (h/d)⁴, however near the plate itself is.
fn is_near_rim(plate: &Plate, middle: Vec3, edges: Vec3) -> bool {
    let (d, n, size) = (middle - plate.centre(), plate.normal(), edges.length());
    let far = d.length() - 0.5 * plate.diameter();
    if far > MIN_RIM_DISTANCE * size {
        return false;
    }
    let reach = 0.5 * (0..3).map(|k| n[k].abs() * edges[k]).sum::<f64>();
    let height = d.dot(n).abs();
    if height < 0.999 * reach {
        return height.max(far) < MIN_RIM_DISTANCE * size;
    }
    let (corners, count) = plate.corners();
    (0..count).any(|i| from_segment(corners[i], corners[(i + 1) % count], middle) < MIN_RIM_DISTANCE * size)
}

/// Distance of a point from the line between two others.
fn from_segment(a: Vec3, b: Vec3, x: Vec3) -> f64 {
    let (along, to) = (b - a, x - a);
    let t = (to.dot(along) / along.length2()).clamp(0.0, 1.0);
    (to - along * t).length()
}

/// Relative error of a part represented by its centroid: the solid angle is harmonic, so that only the anisotropy of the second moments
/// counts, with second derivatives of about 4/d².
fn far_error(part: &PreparedZone, plate: &Plate) -> f64 {
    2.0 * part.second_moments.anisotropy() / (part.centroid - plate.centre()).length2()
}

/// Relative error of a sub-cell of edge h of which a share was cut off, d away from the middle of a plate. At its centroid: its
/// anisotropy, about h²/12 of the share, times second derivatives; by a grid beside the plate: pieces a quarter as wide lie off
/// their middles by half that share. A whole one errs by 0.04 (h/d)⁴, at most by the error after halving.
fn sample_error(cut: f64, h: f64, d: f64, plate: &Plate, beside: bool) -> f64 {
    let reach = d + 0.4 * plate.diameter();
    let (spread, even) = (cut * h * h / (6.0 * reach * reach), 0.04 * (h / d).powi(4).min(1.0 / 9.0));
    even + spread + if beside { 0.25 * cut.min(0.25) * h / reach } else { 0.0 }
}

/// The refinement of samples of a voxel near a plate: each becomes points of a grid that are finer beside the plate.
struct SampleRefinement<'a, F> {
    plate: &'a Plate,
    /// True where the second point is visible from the first.
    free: F,
    /// The points, each with the volume that it represents, m³.
    points: Vec<(Vec3, f64)>,
}

impl<F: Fn(Vec3, Vec3) -> bool> SampleRefinement<'_, F> {
    /// Adds the points of a grid over the piece from `lo` with these edges that are free from `from`, each with its share of the `volume`.
    fn add_points(&mut self, lo: Vec3, edges: Vec3, from: Vec3, volume: f64, depth: usize) {
        let piece = edges * 0.5;
        let corner = |k: usize| lo + piece.scale(vec3((k >> 2) as f64, (k >> 1 & 1) as f64, (k & 1) as f64));
        let centre = |k: usize| corner(k) + piece * 0.5;
        let open: Vec<usize> = (0..8).filter(|&k| (self.free)(from, centre(k))).collect();
        if open.is_empty() {
            self.points.push((from, volume));
        }
        for &k in &open {
            let (at, volume) = (centre(k), volume / open.len() as f64);
            if depth + 1 < MAX_HALVINGS && is_near_rim(self.plate, at, piece) {
                self.add_points(corner(k), piece, at, volume, depth + 1);
            } else {
                self.points.push((at, volume));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::second_moments::centroid;
    use super::*;

    #[test]
    fn refined_samples_resolve_small_plate_in_voxel() {
        let (lo, cell) = (vec3(-0.4, 0.2, 0.0), vec3(0.8, 0.9, 0.7));
        let edges = cell * (1.0 / SUBCELLS as f64);
        // Narrow plates, level with a row of samples or slightly off, centred or tilted, one- and two-sided.
        use zonal_scene::Sides::{Both, Front};
        for (x, lean, sides) in [
            (0.1001, 0.0, Front),
            (0.0999, 0.0, Front),
            (0.15, 0.0, Both),
            (0.02, 0.4, Front),
            (-0.1, -0.7, Both),
        ] {
            let up = vec3(lean, 0.0, 1.0).normalized() * 0.3;
            let plate = Plate::parallelogram(vec3(x, 0.5, 0.2), vec3(0.0, 0.05, 0.0), up);
            let exact = solid_angle_quadrature::plate_cuboid(&plate, lo, lo + cell, sides, 1e-3);
            let mut refinement = SampleRefinement { plate: &plate, free: |_, _| true, points: Vec::new() };
            for s in whole_samples(cell) {
                let lo = lo + edges.scale(subcell_coordinates(s.subcell));
                refinement.add_points(lo, edges, lo + edges * 0.5, s.volume, 0);
            }
            let points = refinement.points;
            let volume: f64 = points.iter().map(|p| p.1).sum();
            assert!((volume / cell.product() - 1.0).abs() < 1e-12);
            let ours = solid_angle_quadrature::plate_and_points(&plate, points.into_iter(), sides, 0.0);
            let off = ours.factor.value / exact.factor.value - 1.0;
            assert!(
                off.abs() < 0.015 && (ours.mean_distance / exact.mean_distance - 1.0).abs() < 0.02,
                "x {x} lean {lean}: {off}"
            );
        }
    }

    #[test]
    fn distant_cut_voxels_stay_within_radius() {
        let cell = vec3(1.0, 0.9, 1.2);
        let mut dice = (0u64..).map(|k| zonal_math::low_discrepancy::hash_to_unit(k + 7));
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
            let centre = |s: &[VolumeSample]| {
                let all: f64 = s.iter().map(|s| s.volume).sum();
                (centroid(s), all)
            };
            let ((a, va), (b, vb)) = (centre(&p), centre(&q));
            let own = SecondMoments::whole(cell * (1.0 / SUBCELLS as f64));
            let kernel = |s: &VolumeSample, t: &VolumeSample| {
                let d = t.point - s.point;
                s.volume * t.volume / d.length2() * (1.0 + own.sum(own).inverse_square_correction(d))
            };
            let exact: f64 = p.iter().flat_map(|s| q.iter().map(move |t| kernel(s, t))).sum();
            let (d, whole) = (b - a, SecondMoments::whole(cell));
            let (bent, even) = (
                SecondMoments::of(&p, a, cell)
                    .sum(SecondMoments::of(&q, b, cell))
                    .inverse_square_correction(d),
                whole.sum(whole).inverse_square_correction(lo),
            );
            let ours = va * vb / d.length2() * (1.0 + bent);
            let off = (ours / exact - 1.0).abs();
            worst = worst.max(off);
            sum += (off / (bent - even).abs().max(1e-4)).min(9.0);
        }
        assert!(worst < 0.02 && sum / (CASES as f64) < 1.0, "{worst} {sum}");
    }

    #[test]
    fn refined_points_are_visible_from_their_sample() {
        let plate = Plate::parallelogram(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        let (lo, edges, sample) = (vec3(0.3, 0.3, -0.12), vec3(0.2, 0.2, 0.2), vec3(0.4, 0.4, 0.04));
        let above = |_: Vec3, y: Vec3| y.z > 0.0;
        let mut refinement = SampleRefinement { plate: &plate, free: above, points: Vec::new() };
        refinement.add_points(lo, edges, sample, 1.0, 0);
        let points = refinement.points;
        assert!(points.iter().all(|p| p.0.z > 0.0));
        assert!((points.iter().map(|p| p.1).sum::<f64>() - 1.0).abs() < 1e-12);
        let mut refinement = SampleRefinement { plate: &plate, free: |_, _| false, points: Vec::new() };
        refinement.add_points(lo, edges, sample, 1.0, 0);
        assert_eq!(refinement.points, [(sample, 1.0)]);
    }
}
