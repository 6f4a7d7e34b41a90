//! Plates whose bounds hold a point, by a hierarchy of their boxes.
//!
//! The cost of a query grows with the logarithm of the number of plates, whatever their sizes.

use crate::bvh::Bvh;
use zonal_math::Vec3;
use zonal_scene::Plate;

/// Widening of the bounds of a plate, as a fraction of its diameter.
const PAD_SHARE: f64 = 1e-6;

/// Bounds of plates in a hierarchy.
///
/// ```
/// use zonal_math::vec3;
/// use zonal_scene::Plate;
/// use zonal_transport::plate_boxes::PlateBoxes;
///
/// let unit = |x: f64| Plate::parallelogram(vec3(x, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
/// let boxes = PlateBoxes::new(&[unit(0.0), unit(1.0), unit(5.0)]);
/// let mut found = Vec::new();
/// boxes.at(vec3(1.0, 0.5, 0.0), &mut found);
/// assert_eq!(found, [0, 1]);
/// ```
pub struct PlateBoxes {
    tree: Bvh,
    /// Widened lower and upper corner of the bounds of each plate.
    bounds: Vec<[Vec3; 2]>,
    /// Largest widening, m.
    largest_pad: f64,
}

impl PlateBoxes {
    /// The bounds of the plates, widened by 10⁻⁶ of their diameters.
    #[must_use]
    pub fn new(plates: &[Plate]) -> PlateBoxes {
        let padded = |p: &Plate| {
            let ((lo, hi), pad) = (p.bounds(), PAD_SHARE * p.diameter());
            ([lo - Vec3::splat(pad), hi + Vec3::splat(pad)], pad)
        };
        let (bounds, pads): (Vec<[Vec3; 2]>, Vec<f64>) = plates.iter().map(padded).unzip();
        let joined = |a: [Vec3; 2], b: [Vec3; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        let [lo, hi] = bounds.iter().copied().reduce(joined).unwrap_or([Vec3::ZERO; 2]);
        let numbered: Vec<(u32, Plate)> = (0..).zip(plates.iter().copied()).collect();
        let largest_pad = pads.into_iter().fold(0.0, f64::max);
        PlateBoxes { tree: Bvh::new(&numbered, lo, hi), bounds, largest_pad }
    }

    /// Fills `found` with the indices of the plates whose widened bounds hold `p`, ascending.
    pub fn at(&self, p: Vec3, found: &mut Vec<u32>) {
        found.clear();
        let pad = Vec3::splat(self.largest_pad);
        self.tree.overlapping(p - pad, p + pad, |id| {
            let [lo, hi] = self.bounds[id as usize];
            if (0..3).all(|k| lo[k] <= p[k] && p[k] <= hi[k]) {
                found.push(id);
            }
        });
        found.sort_unstable();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::low_discrepancy::r3;

    #[test]
    fn all_plates_of_very_different_sizes_are_found() {
        let vector = |i: usize, scale: f64| {
            let [x, y, z] = r3(i, [0.1, 0.5, 0.7]);
            Vec3::from_array([x - 0.5, y - 0.5, z - 0.5]) * scale
        };
        let plate = |i: usize| {
            let size = 10f64.powi(-((i % 6) as i32));
            Plate::triangle(
                vector(i, 2.0),
                vector(i, 2.0) + vector(i + 7, size),
                vector(i, 2.0) + vector(i + 11, size),
            )
        };
        let plates: Vec<Plate> = (0..600).map(plate).collect();
        let boxes = PlateBoxes::new(&plates);
        let (mut found, mut total) = (Vec::new(), 0);
        for p in plates.iter().flat_map(|p| [p.at(0.0, 0.0), p.at(0.5, 0.5), p.centre()]) {
            boxes.at(p, &mut found);
            let holds = |i: &u32| {
                let (plate, pad) = (&plates[*i as usize], Vec3::splat(PAD_SHARE));
                let ((lo, hi), pad) = (plate.bounds(), pad * plate.diameter());
                (0..3).all(|k| (lo - pad)[k] <= p[k] && p[k] <= (hi + pad)[k])
            };
            let expected: Vec<u32> = (0..600).filter(holds).collect();
            assert_eq!(found, expected);
            total += found.len();
        }
        assert!(total > 1800, "{total}");
        PlateBoxes::new(&[]).at(Vec3::ZERO, &mut found);
        assert!(found.is_empty());
    }
}
