//! The questions a solver asks of a scene.
//!
//! ```text
//! τ = e^{−δ},   δ = Σ_cells κ ℓ + Σ_panes κ t/|cosθ|
//! ```
//!
//! exact for an extinction κ that is constant in each cell. Inside a closed solid there is no medium, but no free segment
//! runs through one, so the walk does not ask. Lengths in metres, κ in 1/m, optical depths without unit.

use crate::bvh::Bvh;
use crate::meet::Tolerance;
use crate::shaft::{End, Shaft};
use crate::solid::Solids;
use crate::{hull, walk};
use zonal_math::Vec3;
use zonal_scene::{Bands, Plate, Scene, Zones, bands};

/// The first facet on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray, m.
    pub t: f64,
    /// Index of the facet.
    pub facet: usize,
    /// First parameter of the point on the facet's plate.
    pub u: f64,
    /// Second parameter.
    pub v: f64,
    /// True when the ray comes from the front.
    pub front: bool,
}

/// A segment's crossing of a pane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaneHit {
    /// Distance from the segment's start, m.
    pub t: f64,
    /// Index of the pane.
    pub pane: usize,
    /// Index of the plate within the pane.
    pub plate: usize,
    /// |cosθ| between segment and normal, above 0.
    pub cos: f64,
}

/// A scene made ready for rays.
#[derive(Clone, Debug)]
pub struct Transport<'a> {
    scene: &'a Scene,
    tol: Tolerance,
    all: Bvh,
    /// The facets that can block between points of the scene; `None` when that is all of them.
    dividing: Option<Bvh>,
    solids: Solids,
    panes: Bvh,
    /// The pane plates that can lie between points of the scene; `None` when that is all of them.
    between: Option<Bvh>,
    pane_of: Vec<(u32, u32)>,
}

impl<'a> Transport<'a> {
    /// Builds the trees.
    pub fn new(scene: &'a Scene) -> Transport<'a> {
        let tol = Tolerance::of(scene);
        let bounds = scene.bounds();
        let facets: Vec<(u32, Plate)> = (0u32..).zip(scene.facets()).map(|(k, f)| (k, f.plate)).collect();
        let all = Bvh::new(&facets, bounds);
        let pane_of: Vec<(u32, u32)> = (0u32..)
            .zip(scene.panes())
            .flat_map(|(p, pane)| (0..pane.plates.len() as u32).map(move |k| (p, k)))
            .collect();
        let plates = scene.panes().iter().flat_map(|p| &p.plates);
        let panes: Vec<(u32, Plate)> = (0u32..).zip(plates.copied()).collect();

        let some = |list: &[(u32, Plate)]| {
            let bare: Vec<Plate> = list.iter().map(|x| x.1).collect();
            let divides = hull::dividing(scene, &bare, &all, &tol);
            let kept: Vec<(u32, Plate)> = list.iter().zip(divides).filter(|x| x.1).map(|x| *x.0).collect();
            (kept.len() < list.len()).then(|| Bvh::new(&kept, bounds))
        };
        let dividing = some(&facets);
        let between = some(&panes);
        Transport {
            scene,
            tol,
            solids: Solids::new(scene, &tol),
            panes: Bvh::new(&panes, bounds),
            dividing,
            between,
            all,
            pane_of,
        }
    }

    /// The scene.
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }
    /// The length below which points coincide, m: 10⁻⁹ of the scene's diagonal.
    pub fn epsilon(&self) -> f64 {
        self.tol.plane
    }
    /// A point on the ray `origin + t dir` well outside the scene: the far end of a segment towards the sun or the sky.
    pub fn beyond(&self, origin: Vec3, dir: Vec3) -> Vec3 {
        let (lo, hi) = self.scene.bounds();
        let away = ((lo + hi) * 0.5 - origin).length();
        origin + dir * (away + 2.0 * self.scene.diagonal())
    }

    /// True when a facet crosses the open segment a–b. A facet on which an end lies, or in whose plane the segment runs, does not.
    #[inline]
    pub fn blocked(&self, a: Vec3, b: Vec3) -> bool {
        self.all.any(a, b, &self.tol)
    }
    /// [`Transport::blocked`] for two points of the scene itself (on its surfaces, or in its voxmap): asks only the facets that
    /// can lie between such points.
    #[inline]
    pub fn blocked_inside(&self, a: Vec3, b: Vec3) -> bool {
        self.dividing.as_ref().unwrap_or(&self.all).any(a, b, &self.tol)
    }
    /// True when a facet or a pane stands between two points of the scene itself.
    pub fn parted_inside(&self, a: Vec3, b: Vec3) -> bool {
        self.blocked_inside(a, b) || self.has_panes_between() && self.pane_depth_inside(a, b) != [0.0; 3]
    }
    /// False when no facet can stand between any point of one zone and any of the other, both zones of the scene: then
    /// [`Transport::blocked_inside`] is false for all of them. True says nothing.
    pub fn may_divide(&self, ends: [End; 2]) -> bool {
        self.dividing.as_ref().unwrap_or(&self.all).any_in(&Shaft::new(ends), &self.tol)
    }
    /// The same of panes.
    pub fn pane_may_divide(&self, ends: [End; 2]) -> bool {
        self.between.as_ref().unwrap_or(&self.panes).any_in(&Shaft::new(ends), &self.tol)
    }
    /// True when some facet can lie between two points of the scene.
    pub fn has_occluders(&self) -> bool {
        self.occluder_count() > 0
    }
    /// Number of facets that can lie between two points of the scene.
    pub fn occluder_count(&self) -> usize {
        self.dividing.as_ref().unwrap_or(&self.all).len()
    }
    /// True when some pane can lie between two points of the scene.
    pub fn has_panes_between(&self) -> bool {
        self.between.as_ref().unwrap_or(&self.panes).len() > 0
    }

    /// The first facet on the ray with t_min < t < t_max (m, may be infinite); `dir` has unit length. A facet in whose plane
    /// the ray starts or runs is not met.
    pub fn nearest(&self, origin: Vec3, dir: Vec3, t_min: f64, t_max: f64) -> Option<Hit> {
        let (id, [t, u, v], front) = self.all.nearest(origin, dir, (t_min, t_max), &self.tol)?;
        let facet = id as usize;
        Some(Hit { t, facet, u, v, front })
    }

    /// Calls `each` with every facet that the segment a–b crosses, in no order. A facet on which an end lies is not crossed.
    pub fn facet_crossings(&self, a: Vec3, b: Vec3, each: &mut impl FnMut(Hit)) {
        let length = (b - a).length();
        self.all.all(a, b, &self.tol, |id, [t, u, v], along| {
            each(Hit { t: t * length, facet: id as usize, u, v, front: along < 0.0 });
        });
    }

    /// Ids of the facets whose boxes overlap [lo, hi], ascending.
    pub(crate) fn facets_near(&self, lo: Vec3, hi: Vec3) -> Vec<u32> {
        let mut ids = Vec::new();
        self.all.overlapping(lo, hi, |id| ids.push(id));
        ids.sort_unstable();
        ids
    }

    pub(crate) fn tolerance(&self) -> &Tolerance {
        &self.tol
    }

    /// Calls `each` with (cell, t0, t1) for every voxmap cell on the segment a–b in order, t in metres from a.
    #[inline]
    pub fn walk(&self, a: Vec3, b: Vec3, each: &mut impl FnMut(usize, f64, f64)) {
        if let Some(map) = self.scene.voxmap() {
            walk::walk(map, a, b, each);
        }
    }

    /// Calls `each` with the panes that the segment a–b crosses, by ascending t. A pane on which an end lies is not crossed.
    pub fn pane_crossings(&self, a: Vec3, b: Vec3, each: &mut impl FnMut(PaneHit)) {
        self.crossings(&self.panes, a, b, each);
    }

    fn crossings(&self, panes: &Bvh, a: Vec3, b: Vec3, each: &mut impl FnMut(PaneHit)) {
        if panes.len() == 0 {
            return;
        }
        let length = (b - a).length();
        let mut hits: Vec<(PaneHit, bool)> = Vec::new();
        panes.all(a, b, &self.tol, |id, [t, u, v], along| {
            let (pane, plate) = self.pane_of[id as usize];
            let hit = PaneHit {
                t: t * length,
                pane: pane as usize,
                plate: plate as usize,
                cos: along.abs() / length,
            };
            // On the edge of a plate the neighbouring one is met too.
            let edge = [u, v, 1.0 - u, 1.0 - v, 1.0 - u - v];
            hits.push((hit, edge.iter().any(|e| e.abs() < 1e-9)));
        });
        hits.sort_by(|x, y| {
            let order = x.0.t.total_cmp(&y.0.t);
            order.then((x.0.pane, x.0.plate).cmp(&(y.0.pane, y.0.plate)))
        });
        let mut last: Option<(PaneHit, bool)> = None;
        for h in hits {
            let same = last.is_some_and(|l| {
                l.1 && h.1 && h.0.t - l.0.t <= self.tol.plane / h.0.cos && (h.0.cos - l.0.cos).abs() < 1e-9
            });
            if !same {
                each(h.0);
            }
            last = Some(h);
        }
    }

    /// ∫ κ ds over voxmap and panes along a–b, a band. A pane adds κ t/|cosθ|, unless a or b lies on it.
    #[inline]
    pub fn optical_depth(&self, a: Vec3, b: Vec3) -> Bands {
        self.depth(&self.panes, a, b)
    }
    /// [`Transport::optical_depth`] for two points of the scene itself: asks only the panes that can lie between such points.
    #[inline]
    pub fn optical_depth_inside(&self, a: Vec3, b: Vec3) -> Bands {
        self.depth(self.between.as_ref().unwrap_or(&self.panes), a, b)
    }

    /// ∫ κ ds over the panes alone that lie between two points of the scene itself.
    #[inline]
    pub fn pane_depth_inside(&self, a: Vec3, b: Vec3) -> Bands {
        self.pane_depth(self.between.as_ref().unwrap_or(&self.panes), a, b)
    }

    #[inline]
    fn depth(&self, panes: &Bvh, a: Vec3, b: Vec3) -> Bands {
        let (medium, panes) = (self.medium_depth(a, b), self.pane_depth(panes, a, b));
        bands(|k| medium[k] + panes[k])
    }

    #[inline]
    fn pane_depth(&self, panes: &Bvh, a: Vec3, b: Vec3) -> Bands {
        let mut sum = [0.0; 3];
        self.crossings(panes, a, b, &mut |h| {
            let depth = self.slant_depth(&h);
            (0..3).for_each(|k| sum[k] += depth[k]);
        });
        sum
    }

    /// κt/c of the pane that a segment meets, c the cosine of how it does.
    #[inline]
    pub fn slant_depth(&self, hit: &PaneHit) -> Bands {
        let p = &self.scene.panes()[hit.pane];
        p.extinction.map(|k| k * p.thickness / hit.cos)
    }

    /// The volume zone, an index into `zones.voxels`, of a cell in which a point lies: where walls part the cell, the one with the nearest
    /// sample that the point sees.
    pub fn zone_in(&self, zones: &Zones, cell: usize, p: Vec3) -> Option<usize> {
        let range = zones.of_cell(cell);
        if range.len() <= 1 {
            return range.into_iter().next();
        }
        let nearest = |z: usize| {
            let part = zones.voxels[z].part.iter().map(|s| ((s.point - p).length2(), z, s.point));
            part.min_by(|a, b| a.0.total_cmp(&b.0))
        };
        let mut near: Vec<(f64, usize, Vec3)> = range.filter_map(nearest).collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        let seen = near.iter().find(|n| !self.blocked(p, n.2));
        seen.or(near.first()).map(|n| n.1)
    }

    /// ∫ κ ds over the voxmap alone.
    #[inline]
    pub fn medium_depth(&self, a: Vec3, b: Vec3) -> Bands {
        let mut sum = [0.0; 3];
        let Some(map) = self.scene.voxmap() else {
            return sum;
        };
        if let Some(kappa) = map.uniform_extinction() {
            if kappa == [0.0; 3] {
                return sum;
            }
            let length = walk::within(map, a, b).map_or(0.0, |(_, t0, t1)| t1 - t0);
            return kappa.map(|k| k * length);
        }
        walk::walk(map, a, b, &mut |cell, t0, t1| {
            let kappa = map.extinction(cell);
            for k in 0..3 {
                sum[k] += kappa[k] * (t1 - t0);
            }
        });
        sum
    }

    /// e^{−δ} along a–b, a band; `None` when a facet blocks.
    #[inline]
    pub fn transmittance(&self, a: Vec3, b: Vec3) -> Option<Bands> {
        if self.blocked(a, b) {
            return None;
        }
        let depth = self.optical_depth(a, b);
        Some(bands(|k| (-depth[k]).exp()))
    }
    /// [`Transport::transmittance`] for two points of the scene itself.
    #[inline]
    pub fn transmittance_inside(&self, a: Vec3, b: Vec3) -> Option<Bands> {
        if self.blocked_inside(a, b) {
            return None;
        }
        let depth = self.optical_depth_inside(a, b);
        Some(bands(|k| (-depth[k]).exp()))
    }

    /// True when some surface bounds closed solids.
    pub fn has_solids(&self) -> bool {
        self.solids.any()
    }
    /// True when `p` lies in the material of a closed solid.
    pub fn inside_solid(&self, p: Vec3) -> bool {
        self.solids.inside(p)
    }
    /// The facet through which a way leaves the solid in which `p` lies, an index; `None` where it lies in none.
    pub fn solid_around(&self, p: Vec3) -> Option<usize> {
        self.solids.around(p)
    }
    /// True where the medium outside the closed rooms touches nothing else, so that it has no zones.
    pub fn void_outside_rooms(&self) -> bool {
        self.solids.void_outside()
    }
    /// True when `p` lies outside every closed room.
    pub fn outside_rooms(&self, p: Vec3) -> bool {
        self.solids.outside_rooms(p)
    }
    /// True when some part of the voxmap may hold no medium.
    pub fn has_places_without_medium(&self) -> bool {
        self.has_solids() || self.void_outside_rooms()
    }
    /// True when the medium at `p` takes part: `p` lies in no solid, nor outside the closed rooms where nothing else is.
    pub fn holds_medium(&self, p: Vec3) -> bool {
        !(self.inside_solid(p) || self.void_outside_rooms() && self.outside_rooms(p))
    }
}
