//! The zones as the judge of pairs sees them: a shape, a normal, a size, and the axis-aligned box where they are one.

use super::spread::{Spread, centroid};
use crate::aligned::Cuboid;
use std::borrow::Cow;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, Plate, Sample, Scene, VoxelZone, Voxmap, Zones};

/// The shape of a zone.
#[derive(Clone)]
pub(super) enum Shape {
    Plate { plate: Plate, pane: Option<usize> },
    Cuboid,
    Part(Vec<Sample>),
}

#[derive(Clone)]
pub(super) struct Zone {
    pub(super) shape: Shape,
    /// The zone as an axis-aligned box or rectangle; of a cut voxel, the whole cell.
    pub(super) aligned: Option<Cuboid>,
    pub(super) normal: Vec3,
    pub(super) centre: Vec3,
    /// The centroid, which may lie in a wall that parts a cut voxel, and the second moments of a volume about it.
    pub(super) middle: Vec3,
    pub(super) spread: Spread,
    pub(super) lo: Vec3,
    pub(super) hi: Vec3,
    pub(super) size: f64,
    /// Area of a patch, volume of a volume zone.
    pub(super) measure: f64,
    /// Optical depth along the size of a voxel; zero for any other zone.
    pub(super) thickness: Bands,
}

impl Zone {
    /// The samples of a cut voxel.
    pub(super) fn samples(&self) -> Option<&[Sample]> {
        if let Shape::Part(s) = &self.shape { Some(s) } else { None }
    }
}

/// All zones: kept ready, or each made when asked for.
pub(super) struct Items<'a> {
    zones: &'a Zones,
    map: Option<&'a Voxmap>,
    kept: Vec<Zone>,
}

impl<'a> Items<'a> {
    pub(super) fn new(scene: &'a Scene, zones: &'a Zones, keep: bool) -> Items<'a> {
        let mut items = Items { zones, map: scene.voxmap(), kept: Vec::new() };
        if keep {
            items.kept = (0..zones.len()).map(|i| items.make(i)).collect();
        }
        items
    }

    /// Zone `i` of the scene.
    pub(super) fn get(&self, i: usize) -> Cow<'_, Zone> {
        match self.kept.get(i) {
            Some(z) => Cow::Borrowed(z),
            None => Cow::Owned(self.make(i)),
        }
    }

    fn make(&self, i: usize) -> Zone {
        let zones = self.zones;
        if i < zones.voxel_offset() {
            plate_zone(zones.patches[i].plate, None)
        } else if i < zones.pane_offset() {
            let map = self.map.expect("voxel zones come from a voxmap");
            voxel_zone(&zones.voxels[i - zones.voxel_offset()], map)
        } else {
            let k = i - zones.pane_offset();
            plate_zone(zones.panes[k].plate, Some(k))
        }
    }
}

fn voxel_zone(z: &VoxelZone, map: &Voxmap) -> Zone {
    let cell = map.cell();
    let lo = map.corner(map.coordinates(z.cell));
    let hi = lo + cell;
    let samples: Vec<Sample> = z.part.iter().collect();
    let middle = if samples.is_empty() { z.centre } else { centroid(&samples) };
    Zone {
        middle,
        spread: if samples.is_empty() {
            Spread::whole(hi - lo)
        } else {
            Spread::of(&samples, middle, hi - lo)
        },
        shape: if samples.is_empty() { Shape::Cuboid } else { Shape::Part(samples) },
        aligned: Some(Cuboid { lo, hi, normal: None }),
        normal: Vec3::ZERO,
        centre: z.centre,
        lo,
        hi,
        size: cell.length(),
        measure: z.volume,
        thickness: z.extinction.map(|k| k * cell.length()),
    }
}

/// What the shares of a zone's power are relative to: A, or 4V/size so that volumes compare with surfaces.
fn weight(z: &Zone) -> f64 {
    match z.shape {
        Shape::Plate { .. } => z.measure,
        _ => 4.0 * z.measure,
    }
}

/// The larger of the two shares of the zones' power that a factor g carries, with extinctions of order one over the size.
pub(super) fn share(factor: f64, a: &Zone, b: &Zone) -> f64 {
    factor / weight(a).min(weight(b))
}

pub(super) fn plate_zone(plate: Plate, pane: Option<usize>) -> Zone {
    let (lo, hi) = plate.bounds();
    let normal = plate.normal();
    Zone {
        aligned: if pane.is_none() { aligned_rectangle(&plate, normal) } else { None },
        shape: Shape::Plate { plate, pane },
        normal,
        centre: plate.centre(),
        middle: plate.centre(),
        spread: Spread::default(),
        lo,
        hi,
        size: plate.diameter(),
        measure: plate.area(),
        thickness: [0.0; 3],
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

pub(super) fn others_vanish(v: Vec3, axis: usize) -> bool {
    let eps = 1e-12 * v[axis].abs();
    (0..3).all(|x| x == axis || v[x].abs() <= eps)
}

/// True where all of `b` lies behind the plane of the patch `a`, or in it.
pub(super) fn behind(a: &Zone, b: &Zone) -> bool {
    let Shape::Plate { plate, pane } = &a.shape else {
        return false;
    };
    let n = a.normal;
    let eps = 1e-10 * (a.size + b.size);
    let height = |p: Vec3| n.dot(p - plate.origin);
    if pane.is_some() {
        // Seen from both sides; only its own plane sees nothing of it.
        return matches!(&b.shape, Shape::Plate { plate: q, .. } if { let (c, m) = q.corners(); c[..m].iter().all(|&p| height(p).abs() <= eps) });
    }
    match &b.shape {
        Shape::Plate { plate: q, .. } => {
            let (c, m) = q.corners();
            c[..m].iter().all(|&p| height(p) <= eps)
        }
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

/// True where two zones nearly touch: a first look of few rays would miss what stands between.
pub(super) fn is_close(a: &Zone, b: &Zone) -> bool {
    (a.centre - b.centre).length() < a.size + b.size
}
