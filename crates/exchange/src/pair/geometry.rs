//! The geometric factor of two zones alone, for engines that measure visibility and attenuation their own way.

use super::parts::part_plate;
use super::zone::{Shape, behind};
use super::{Exchange, PLATE_ABSOLUTE};
use crate::general::Moments;

/// Optical depth of the larger zone above which the spread of the distances of two oblique plates matters.
const DEEP: f64 = 0.05;

impl Exchange<'_> {
    /// 𝓕 of zones `i` and `j` with nothing between them and the moments of their distance: m² (ss), m³ (sv), m⁴ (vv). Plates in a general
    /// position to the relative radius `tolerance`; pieces of panes as plates seen from both sides, without their own share; a pane or
    /// a patch with itself: zero.
    pub fn geometry(&self, i: usize, j: usize, tolerance: f64) -> Moments {
        let (i, j) = if i < j { (j, i) } else { (i, j) };
        let (a, b) = (self.items.get(i), self.items.get(j));
        if i == j {
            return match &a.shape {
                Shape::Plate { .. } => Moments::ZERO,
                Shape::Cuboid => self.moments(&a, &a),
                Shape::Part(samples) => self.subcell_sum([0; 3], samples, samples),
            };
        }
        if behind(&a, &b) || behind(&b, &a) {
            return Moments::ZERO;
        }
        match (&a.shape, &b.shape) {
            (Shape::Part(_), Shape::Plate { plate, pane }) => part_plate(&a, plate, pane.is_some(), true),
            (Shape::Plate { plate, pane }, Shape::Part(_)) => part_plate(&b, plate, pane.is_some(), true),
            (Shape::Part(_), _) | (_, Shape::Part(_)) => self.part_volume(&a, &b),
            _ if i < self.zones.voxel_offset() && (a.aligned.is_none() || b.aligned.is_none()) => {
                let thin = self.uniform.is_some_and(|k| k.iter().all(|k| k * a.size.max(b.size) < DEEP));
                let factor = self.plates.pair(i, j, tolerance, PLATE_ABSOLUTE.max(1e-3 * tolerance)).bounded;
                if thin {
                    Moments { factor, mean: (a.centre - b.centre).length(), ..Moments::ZERO }
                } else {
                    Moments { factor, ..self.moments(&a, &b) }
                }
            }
            _ => self.moments(&a, &b),
        }
    }
}
