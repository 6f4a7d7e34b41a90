//! Zones prepared for pairs: shape, normal, diameter, and the axis-aligned box of a zone that is one.

use super::second_moments::{SecondMoments, centroid};
use crate::aligned::Cuboid;
use std::borrow::Cow;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, Plate, Scene, VolumeSample, VoxelGrid, VoxelZone, ZoneRef, Zones};

/// The kind and shape of a zone.
#[derive(Clone)]
pub(super) enum PreparedShape {
    /// A patch, or the pane of that index.
    Plate { plate: Plate, pane: Option<usize> },
    /// A whole voxel.
    Voxel,
    /// The free part of a voxel that walls cut, by its samples.
    CutVoxel(Vec<VolumeSample>),
}

/// A zone with the geometry that its pairs need.
#[derive(Clone)]
pub(super) struct PreparedZone {
    pub(super) shape: PreparedShape,
    /// The zone as an axis-aligned box or rectangle; of a cut voxel, the whole cell.
    pub(super) aligned: Option<Cuboid>,
    pub(super) normal: Vec3,
    pub(super) centre: Vec3,
    /// The centroid, which may lie in a wall that divides a cut voxel, and the second moments of a volume about it.
    pub(super) centroid: Vec3,
    pub(super) second_moments: SecondMoments,
    pub(super) lo: Vec3,
    pub(super) hi: Vec3,
    /// Diameter, m.
    pub(super) diameter: f64,
    /// Area of a patch, volume of a volume zone.
    pub(super) measure: f64,
    /// Optical depth along the diagonal of a voxel; zero for any other zone.
    pub(super) optical_thickness: Bands,
}

impl PreparedZone {
    /// The samples of a cut voxel.
    pub(super) fn samples(&self) -> Option<&[VolumeSample]> {
        if let PreparedShape::CutVoxel(s) = &self.shape { Some(s) } else { None }
    }
}

/// Memory of prepared zones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ZoneCaching {
    /// Every zone is prepared once, about 500 bytes each.
    All,
    /// A zone is prepared at each use.
    None,
}

/// All zones, prepared in advance or each on demand.
pub(super) struct PreparedZones<'a> {
    zones: &'a Zones,
    grid: Option<&'a VoxelGrid>,
    kept: Vec<PreparedZone>,
}

impl<'a> PreparedZones<'a> {
    pub(super) fn new(scene: &'a Scene, zones: &'a Zones, cache: ZoneCaching) -> PreparedZones<'a> {
        let mut prepared = PreparedZones { zones, grid: scene.voxel_grid(), kept: Vec::new() };
        if cache == ZoneCaching::All {
            prepared.kept = (0..zones.len()).map(|i| prepared.make(i)).collect();
        }
        prepared
    }

    /// Zone `i` of the scene.
    pub(super) fn get(&self, i: usize) -> Cow<'_, PreparedZone> {
        match self.kept.get(i) {
            Some(z) => Cow::Borrowed(z),
            None => Cow::Owned(self.make(i)),
        }
    }

    /// Number of zones.
    pub(super) fn len(&self) -> usize {
        self.zones.len()
    }

    fn make(&self, i: usize) -> PreparedZone {
        match self.zones.zone(i) {
            ZoneRef::Patch(p) => prepared_plate(p.plate, None),
            ZoneRef::Voxel(_, z) => {
                let grid = self.grid.expect("voxel zones come from a voxel grid");
                prepared_voxel(z, grid)
            }
            ZoneRef::Pane(k, z) => prepared_plate(z.plate, Some(k)),
        }
    }
}

fn prepared_voxel(z: VoxelZone, grid: &VoxelGrid) -> PreparedZone {
    let cell = grid.cell();
    let lo = grid.corner(grid.coordinates(z.cell));
    let hi = lo + cell;
    let samples: Vec<VolumeSample> = z.samples.iter().collect();
    let middle = if samples.is_empty() { z.centre } else { centroid(&samples) };
    PreparedZone {
        centroid: middle,
        second_moments: if samples.is_empty() {
            SecondMoments::whole(hi - lo)
        } else {
            SecondMoments::of(&samples, middle, hi - lo)
        },
        shape: if samples.is_empty() { PreparedShape::Voxel } else { PreparedShape::CutVoxel(samples) },
        aligned: Some(Cuboid { lo, hi, normal: None }),
        normal: Vec3::ZERO,
        centre: z.centre,
        lo,
        hi,
        diameter: cell.length(),
        measure: z.volume,
        optical_thickness: z.extinction * cell.length(),
    }
}

/// The reference of a zone's power shares: A of a plate, 4V of a volume.
fn power_reference(z: &PreparedZone) -> f64 {
    match z.shape {
        PreparedShape::Plate { .. } => z.measure,
        _ => 4.0 * z.measure,
    }
}

/// The larger share of both zones' power that a factor g carries.
pub(super) fn power_share(factor: f64, a: &PreparedZone, b: &PreparedZone) -> f64 {
    factor / power_reference(a).min(power_reference(b))
}

/// A patch, or the pane of index `pane`.
pub(super) fn prepared_plate(plate: Plate, pane: Option<usize>) -> PreparedZone {
    let (lo, hi) = plate.bounds();
    let normal = plate.normal();
    PreparedZone {
        aligned: if pane.is_none() { aligned_rectangle(&plate, normal) } else { None },
        shape: PreparedShape::Plate { plate, pane },
        normal,
        centre: plate.centre(),
        centroid: plate.centre(),
        second_moments: SecondMoments::default(),
        lo,
        hi,
        diameter: plate.diameter(),
        measure: plate.area(),
        optical_thickness: Bands::ZERO,
    }
}

/// The plate as an axis-aligned rectangle, if it is one to within rounding.
pub(super) fn aligned_rectangle(p: &Plate, normal: Vec3) -> Option<Cuboid> {
    if p.kind != zonal_scene::PlateKind::Parallelogram {
        return None;
    }
    let along = |v: Vec3| (0..3).find(|&x| v[x].abs() >= v.length() * (1.0 - 1e-14) && others_vanish(v, x));
    let (x, y) = (along(p.e1)?, along(p.e2)?);
    if x == y {
        return None;
    }
    let axis = 3 - x - y;
    let (lo, hi) = p.bounds();
    let level = p.origin[axis];
    let set = |v: Vec3| {
        let mut a = v.array();
        a[axis] = level;
        Vec3::from_array(a)
    };
    Some(Cuboid { lo: set(lo), hi: set(hi), normal: Some((axis, if normal[axis] > 0.0 { 1 } else { -1 })) })
}

fn others_vanish(v: Vec3, axis: usize) -> bool {
    let eps = 1e-12 * v[axis].abs();
    (0..3).all(|x| x == axis || v[x].abs() <= eps)
}

/// True where all of `b` lies behind the plane of the patch `a`, or in it.
pub(super) fn is_behind(a: &PreparedZone, b: &PreparedZone) -> bool {
    let PreparedShape::Plate { plate, pane } = &a.shape else {
        return false;
    };
    let n = a.normal;
    let eps = 1e-10 * (a.diameter + b.diameter);
    let height = |p: Vec3| n.dot(p - plate.origin);
    if pane.is_some() {
        // A pane emits to both sides; only zones in its own plane exchange nothing with it.
        let PreparedShape::Plate { plate: q, .. } = &b.shape else { return false };
        let (c, m) = q.corners();
        return c[..m].iter().all(|&p| height(p).abs() <= eps);
    }
    match &b.shape {
        PreparedShape::Plate { plate: q, .. } => q.is_behind(plate.origin, n, eps),
        _ => {
            let far = vec3(
                if n.x > 0.0 { b.hi.x } else { b.lo.x },
                if n.y > 0.0 { b.hi.y } else { b.lo.y },
                if n.z > 0.0 { b.hi.z } else { b.lo.z },
            );
            height(far) <= eps
        }
    }
}

/// True where two zones nearly touch, so that few rays would miss occluders between them.
pub(super) fn is_close(a: &PreparedZone, b: &PreparedZone) -> bool {
    (a.centre - b.centre).length() < a.diameter + b.diameter
}
