//! Periodic scenes without a medium: the exchange of a patch with all images of another is that of infinitely long strips.
//!
//! Every patch extends along the whole period L of one axis ([`Scene`] refuses others), so that its images form a strip and the areas follow from the
//! cross-section ([`crate::strips`]): F_ij = L f_ij, with f the exchange per length. What a row lacks of the patch's area goes to black backs of
//! one-sided walls, the exchange with their segments, and to the surroundings.

use super::pair_factor::{PairCounts, PairFactor};
use crate::strips::{Segment, exchange_per_length};
use zonal_math::Vec3;
use zonal_scene::{Bands, Patch, Plate, Scene, Sides, Zones};

/// Error radius over the area of the smaller patch: rounding.
const RADIUS_OVER_AREA: f64 = 1e-11;
/// Share of a patch's area below which the remainder of its row is rounding.
const CLOSED_SHARE: f64 = 1e-9;

/// The cross-section of a periodic scene without a medium.
pub struct StripImages {
    /// The period, m.
    length: f64,
    /// The segment of each patch, its front to the left.
    patches: Vec<Segment>,
    areas: Vec<f64>,
    /// All facets, which obstruct with both sides.
    walls: Vec<Segment>,
    /// Backs of facets that do not exchange, their black side to the left.
    backs: Vec<Segment>,
}

impl StripImages {
    /// The cross-section of a scene; `None` unless it is periodic along one axis and has no medium.
    #[must_use]
    pub fn of(scene: &Scene, zones: &Zones) -> Option<StripImages> {
        let axis = scene.strip_axis()?;
        let (lo, hi) = scene.boundary_box()?;
        let segment = |p: &Plate, normal: Vec3| segment(p, normal, axis);
        let one_sided = |s: usize| {
            let s = &scene.surfaces()[s];
            s.sides == Sides::Front && !s.solid
        };
        let facets = scene.facets();
        let backs = facets.iter().filter(|f| one_sided(f.surface));
        Some(StripImages {
            length: hi[axis] - lo[axis],
            patches: zones.patches.iter().map(|p: &Patch| segment(&p.plate, p.normal)).collect(),
            areas: zones.patches.iter().map(|p| p.area).collect(),
            walls: facets.iter().map(|f| segment(&f.plate, f.plate.normal())).collect(),
            backs: backs.map(|f| segment(&f.plate, -f.plate.normal())).collect(),
        })
    }

    /// F_ij with its radius, m².
    pub(super) fn pair(&self, i: usize, j: usize, counts: &mut PairCounts) -> PairFactor {
        if i == j {
            return PairFactor::default();
        }
        let (f, obstructed) = exchange_per_length(self.patches[i], self.patches[j], &self.walls);
        counts.general += 1;
        counts.estimated += u64::from(obstructed);
        counts.partial += u64::from(obstructed);
        let radius = if f > 0.0 { RADIUS_OVER_AREA * self.areas[i].min(self.areas[j]) } else { 0.0 };
        PairFactor { value: Bands::splat(self.length * f), radius: Bands::splat(radius) }
    }

    /// The exchange of patch `i` with the surroundings and with black backs, m².
    #[must_use]
    pub fn losses(&self, i: usize) -> [f64; 2] {
        let to = |s: &Segment| self.length * exchange_per_length(self.patches[i], *s, &self.walls).0;
        let others = self.patches.iter().enumerate().filter(|(j, _)| *j != i);
        let row: f64 = others.map(|(_, s)| to(s)).sum();
        let backs: f64 = self.backs.iter().map(to).sum();
        let rounding = CLOSED_SHARE * self.areas[i];
        let kept = |x: f64| if x > rounding { x } else { 0.0 };
        [kept(self.areas[i] - row - backs), kept(backs)]
    }
}

/// The cross-section of a plate that extends along `axis`, with the side of `normal` to the left.
fn segment(p: &Plate, normal: Vec3, axis: usize) -> Segment {
    let [b, c] = [(axis + 1) % 3, (axis + 2) % 3];
    let across = if p.e1[axis].abs() > p.e2[axis].abs() { p.e2 } else { p.e1 };
    let from = [p.origin[b], p.origin[c]];
    let to = [from[0] + across[b], from[1] + across[c]];
    let left = [-(to[1] - from[1]), to[0] - from[0]];
    if left[0] * normal[b] + left[1] * normal[c] > 0.0 { [from, to] } else { [to, from] }
}
