//! Samples of a point light on one zone.
//!
//! A sample is a point x of the zone with a weight w and a share σ ≤ 1, so that H or G is the mean of w σ τ. With f ≤ M the relative intensity over the zone,
//! I₀ the unit intensity, r the distance and Ω the solid angle of a plate, or of a box of chords ℓ and diagonal d, samples have
//!
//! | directions | w | σ |
//! |---|---|---|
//! | patch: uniform over its solid angle | I₀ M Ω/A | f/M |
//! | near voxel: uniform over the solid angle of its cell, x uniform on the chord | I₀ M Ω ℓ/V | f/M, 0 outside the zone |
//! | narrow beam: density f/∫f dω | I₀ ∫f dω/A, or d/V in the place of 1/A | 1 on the patch, ℓ/d in the zone, else 0 |
//! | far voxel: to points uniform over the zone | I₀ M/r² | f/M |
//!
//! The weights are bounded also where the zone contains or touches the light. A beam is narrow where ∫f dω < M Ω. σ counts as a transmittance: the edge of a beam
//! is a shadow boundary, and the errors of `zone_sampler` hold.

use crate::right_hand_side::surroundings::zone_rays::voxel_point;
use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_scene::{IntensityDistribution, Patch, Plate, VoxelGrid, VoxelZone, ZoneRef, Zones};
use zonal_transport::Transport;
use zonal_transport::lights::{BoxChord, BoxView, PlateView};

/// A voxel whose centre is farther from the light than this multiple of half its diagonal is far.
const FAR_HALF_DIAGONALS: f64 = 4.0;

/// A sample of a point light on a zone.
pub(super) struct PointLightSample {
    /// The point of the zone, m.
    pub at: Vec3,
    /// w over the unit intensity, 1/m².
    pub weight: f64,
    /// σ.
    pub share: f64,
}

/// The scene of the zones that a point light shines on.
#[derive(Clone, Copy)]
pub(super) struct LitZones<'a> {
    pub(super) zones: &'a Zones,
    pub(super) transport: &'a Transport<'a>,
    pub(super) grid: Option<&'a VoxelGrid>,
}

/// How the points of a zone are chosen.
enum ZonePoints<'a> {
    /// On a patch, by its solid angle.
    Patch { view: PlateView, weight: f64 },
    /// On a patch, along the beam.
    PatchInBeam { view: PlateView, weight: f64 },
    /// In the cell of a near voxel zone, by its solid angle.
    NearVoxel { view: BoxView, index: usize, zone: VoxelZone<'a>, weight: f64 },
    /// In the cell of a voxel zone, along the beam.
    VoxelInBeam { view: BoxView, index: usize, zone: VoxelZone<'a>, weight: f64, diagonal: f64 },
    /// In a far voxel zone, uniform.
    FarVoxel { index: usize },
}

/// A point light as seen from one zone.
pub(super) struct PointLightOnZone<'a> {
    scene: LitZones<'a>,
    position: Vec3,
    distribution: &'a IntensityDistribution,
    /// M.
    bound: f64,
    points: ZonePoints<'a>,
}

impl<'a> PointLightOnZone<'a> {
    /// The light on zone `i`; `None` where it sends nothing there.
    pub(super) fn new(
        scene: LitZones<'a>,
        position: Vec3,
        distribution: &'a IntensityDistribution,
        i: usize,
    ) -> Option<PointLightOnZone<'a>> {
        let (bound, points) = match scene.zones.zone(i) {
            ZoneRef::Patch(patch) => patch_points(patch, position, distribution)?,
            ZoneRef::Voxel(index, zone) => voxel_points(scene.grid?, index, zone, position, distribution)?,
            ZoneRef::Pane(..) => return None,
        };
        Some(PointLightOnZone { scene, position, distribution, bound, points })
    }

    /// The sample at `s` ∈ [0,1)³.
    pub(super) fn sample(&self, s: [f64; 3]) -> Option<PointLightSample> {
        let plane = [s[0], s[1]];
        match &self.points {
            ZonePoints::Patch { view, weight } => Some(self.towards(view.sample(plane)?, *weight)),
            ZonePoints::PatchInBeam { view, weight } => {
                let hit = view.hit(self.distribution.sample_direction(plane));
                let share = if hit.is_some() { 1.0 } else { 0.0 };
                Some(PointLightSample { at: hit.unwrap_or(self.position), weight: *weight, share })
            }
            ZonePoints::NearVoxel { view, index, zone, weight } => {
                let chord = view.sample(plane)?;
                let one = self.towards(self.point_of(&chord, s[2]), weight * chord.length);
                let share = if self.contains(*index, zone, one.at) { one.share } else { 0.0 };
                Some(PointLightSample { share, ..one })
            }
            ZonePoints::VoxelInBeam { view, index, zone, weight, diagonal } => {
                let chord = view.chord(self.distribution.sample_direction(plane));
                let at = chord.map_or(self.position, |c| self.point_of(&c, s[2]));
                let inside = chord.filter(|_| self.contains(*index, zone, at));
                let share = inside.map_or(0.0, |c| (c.length / diagonal).min(1.0));
                Some(PointLightSample { at, weight: *weight, share })
            }
            ZonePoints::FarVoxel { index } => {
                let at = voxel_point(self.scene.transport, self.scene.zones, *index, s);
                Some(self.towards(at, self.bound / (at - self.position).length2()))
            }
        }
    }

    /// A sample whose direction does not follow the distribution.
    fn towards(&self, at: Vec3, weight: f64) -> PointLightSample {
        let f = self.distribution.relative((at - self.position).normalized());
        PointLightSample { at, weight, share: (f / self.bound).min(1.0) }
    }

    fn point_of(&self, chord: &BoxChord, s: f64) -> Vec3 {
        self.position + chord.direction * (chord.near + s * chord.length)
    }

    /// True where a point of the cell of a voxel zone belongs to the zone.
    fn contains(&self, index: usize, zone: &VoxelZone, at: Vec3) -> bool {
        zone.samples.sample_at(0.0).is_none()
            || self.scene.transport.volume_zone_at(self.scene.zones, zone.cell, at) == Some(index)
    }
}

/// I₀ M Ω/A of a plate over I₀, 1/m²: a bound of its mean irradiance from a light that is seen.
pub(super) fn irradiance_bound(plate: &Plate, position: Vec3, distribution: &IntensityDistribution) -> f64 {
    let Some(view) = PlateView::new(plate, position) else { return 0.0 };
    let (bound, _) = bound_over_ball(distribution, position, bounding_ball(plate));
    bound * view.solid_angle() / plate.area()
}

/// A ball that holds a zone, m.
struct Ball {
    centre: Vec3,
    radius: f64,
}

fn bounding_ball(plate: &Plate) -> Ball {
    let (corners, n) = plate.corners();
    let centre = corners[..n].iter().fold(Vec3::ZERO, |sum, c| sum + *c) / n as f64;
    Ball { centre, radius: corners[..n].iter().fold(0.0f64, |m, c| m.max((*c - centre).length())) }
}

/// M over a ball, and the solid angle of the ball, sr.
fn bound_over_ball(distribution: &IntensityDistribution, position: Vec3, ball: Ball) -> (f64, f64) {
    let Ball { centre, radius } = ball;
    let offset = centre - position;
    let distance = offset.length();
    if distance <= radius {
        return (distribution.upper_bound(Vec3::from_array([0.0, 0.0, 1.0]), PI), 4.0 * PI);
    }
    let half_angle = (radius / distance).asin();
    let solid_angle = 2.0 * PI * (1.0 - half_angle.cos());
    (distribution.upper_bound(offset / distance, half_angle), solid_angle)
}

/// M and the points of a patch.
fn patch_points<'a>(
    patch: &Patch,
    position: Vec3,
    distribution: &IntensityDistribution,
) -> Option<(f64, ZonePoints<'a>)> {
    let plate = &patch.plate;
    if (position - plate.origin).dot(patch.normal) <= 0.0 {
        return None;
    }
    let (bound, _) = bound_over_ball(distribution, position, bounding_ball(plate));
    if bound <= 0.0 {
        return None;
    }
    let view = PlateView::new(plate, position)?;
    let (beam, all) = (distribution.solid_angle_integral(), bound * view.solid_angle());
    let area = plate.area();
    Some((
        bound,
        if beam < all {
            ZonePoints::PatchInBeam { view, weight: beam / area }
        } else {
            ZonePoints::Patch { view, weight: all / area }
        },
    ))
}

/// M and the points of a voxel zone.
fn voxel_points<'a>(
    grid: &VoxelGrid,
    index: usize,
    zone: VoxelZone<'a>,
    position: Vec3,
    distribution: &IntensityDistribution,
) -> Option<(f64, ZonePoints<'a>)> {
    let [x, y, z] = grid.coordinates(zone.cell);
    let (lo, hi) = (grid.corner([x, y, z]), grid.corner([x + 1, y + 1, z + 1]));
    let (centre, radius) = ((lo + hi) * 0.5, 0.5 * (hi - lo).length());
    let (bound, ball) = bound_over_ball(distribution, position, Ball { centre, radius });
    if bound <= 0.0 {
        return None;
    }
    let beam = distribution.solid_angle_integral();
    let is_far = (centre - position).length() > FAR_HALF_DIAGONALS * radius;
    if is_far && beam >= bound * ball {
        return Some((bound, ZonePoints::FarVoxel { index }));
    }
    let view = BoxView::new(lo, hi, position);
    let volume = zone.volume;
    let all = bound * view.solid_angle();
    Some((
        bound,
        if beam < all {
            let diagonal = 2.0 * radius;
            ZonePoints::VoxelInBeam { view, index, zone, weight: beam * diagonal / volume, diagonal }
        } else {
            ZonePoints::NearVoxel { view, index, zone, weight: all / volume }
        },
    ))
}
