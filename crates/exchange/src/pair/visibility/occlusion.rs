//! Occlusion between zones: which pairs facets may divide, and visibility rays between the rims of two zones.

use super::ray_samples::pair_kernel;
use crate::pair::prepared_zone::{PreparedShape, PreparedZone};
use zonal_math::{Vec3, vec3};
use zonal_transport::{ShaftEnd, Transport};

/// Distance of rim points from the boundary of their zone, relative to the distance from the centre.
const RIM_INSET: f64 = 0.06;

/// The facets of a scene as occluders.
pub(crate) struct Occlusion<'a> {
    transport: &'a Transport<'a>,
    /// False where no facet can occlude anything.
    pub(crate) has_occluders: bool,
}

/// The common result of visibility rays that all agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RayConsensus {
    Free,
    Blocked,
}

impl RayConsensus {
    /// Blocked if any ray is.
    pub(crate) fn of(blocked: u64) -> RayConsensus {
        if blocked > 0 { RayConsensus::Blocked } else { RayConsensus::Free }
    }
}

/// Counts of the rays between the rims of two zones.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RimVisibility {
    pub rays: u64,
    pub blocked: u64,
}

impl RimVisibility {
    /// True where these rays disagree with each other or with the consensus of others.
    pub(crate) fn disagrees(self, others: RayConsensus) -> bool {
        self.rays > 0 && self.blocked != if others == RayConsensus::Blocked { self.rays } else { 0 }
    }
}

impl<'a> Occlusion<'a> {
    pub(crate) fn new(transport: &'a Transport<'a>) -> Occlusion<'a> {
        Occlusion { transport, has_occluders: transport.has_occluders() }
    }

    /// True where a facet blocks the segment between two points inside a pair.
    pub(crate) fn is_blocked(&self, x: Vec3, y: Vec3) -> bool {
        self.transport.occluded_inside(x, y)
    }

    /// False where no facet can occlude a part of a pair.
    pub(crate) fn may_divide(&self, a: &PreparedZone, b: &PreparedZone) -> bool {
        let (mut p, mut q) = (Vec::new(), Vec::new());
        self.has_occluders && self.transport.may_occlude([shaft_end(a, &mut p), shaft_end(b, &mut q)])
    }

    /// Rays between the rims of two zones. They show whether a pair is partly visible but carry no weight: a decision by weighted rays
    /// would classify almost hidden pairs as hidden and almost visible pairs as visible.
    pub(crate) fn rim_visibility(&self, a: &PreparedZone, b: &PreparedZone) -> RimVisibility {
        let (p, q) = (rim(a), rim(b));
        let mut out = RimVisibility::default();
        for k in 0..4 {
            for turn in [0, 2] {
                let (x, y) = (p[k], q[(k + turn) % 4]);
                if pair_kernel(a, b, x, y) > 0.0 {
                    out.rays += 1;
                    out.blocked += self.transport.occluded_inside(x, y) as u64;
                }
            }
        }
        out
    }
}

/// A zone as an end of the shaft of its rays: rays start at the samples of a cut voxel and anywhere in any other zone.
pub(crate) fn shaft_end<'a>(z: &PreparedZone, points: &'a mut Vec<Vec3>) -> ShaftEnd<'a> {
    let mut front = None;
    match &z.shape {
        PreparedShape::Plate { plate, pane } => {
            let (c, n) = plate.corners();
            points.extend(&c[..n]);
            front = pane.is_none().then_some(z.normal);
        }
        PreparedShape::Voxel => points.extend((0..8).map(|k| {
            let pick = |bit: usize, l: f64, h: f64| if k >> bit & 1 == 1 { h } else { l };
            vec3(pick(0, z.lo.x, z.hi.x), pick(1, z.lo.y, z.hi.y), pick(2, z.lo.z, z.hi.z))
        })),
        PreparedShape::CutVoxel(samples) => points.extend(samples.iter().map(|s| s.point)),
    }
    ShaftEnd { points, front }
}

/// Four points near the rim of a plate, or near four corners of a voxel of which no two share an edge; of a cut voxel the samples
/// farthest towards these corners.
fn rim(z: &PreparedZone) -> [Vec3; 4] {
    let at = |x: Vec3| x + (z.centre - x) * RIM_INSET;
    match &z.shape {
        PreparedShape::Plate { plate, .. } => {
            let (c, n) = plate.corners();
            let last = if n == 3 { (c[1] + c[2]) * 0.5 } else { c[3] };
            [at(c[0]), at(c[1]), at(c[2]), at(last)]
        }
        PreparedShape::Voxel => {
            let (l, h) = (z.lo, z.hi);
            let corners = [l, vec3(h.x, h.y, l.z), vec3(h.x, l.y, h.z), vec3(l.x, h.y, h.z)];
            corners.map(at)
        }
        PreparedShape::CutVoxel(samples) => {
            let towards =
                [vec3(1.0, 1.0, 1.0), vec3(1.0, -1.0, -1.0), vec3(-1.0, 1.0, -1.0), vec3(-1.0, -1.0, 1.0)];
            towards.map(|d| {
                let reach = |x: Vec3| (x - z.centre).dot(d);
                let farther = |best: Vec3, x: Vec3| if reach(x) > reach(best) { x } else { best };
                samples.iter().map(|s| s.point).fold(z.centre, farther)
            })
        }
    }
}
