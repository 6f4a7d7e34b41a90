//! Exchange with the surroundings: directions in which nothing is hit, above and below the horizon, independent of the pairs of facets.
//!
//! The sphere of directions is divided into cells on the faces of a cube. For a node of facets and a cell, the occluders along the
//! rays from the node into the cell are listed; without any, the cell's part is A ω⊥/π exactly; with one that hides the whole cell, zero. The
//! partly hidden cells of a facet are integrated together over the facet, their visible parts in closed form for each point
//! ([`zonal_exchange::polygon::visible::obstructed_sky`]). A cell with very many occluders is divided first.

use crate::bounds::direction_cell::DirectionCell;
use crate::bounds::shaft::SkyShaft;
use crate::geometry::blocking::Hull;
use crate::geometry::occluder_list::{self, OccluderNode};
use crate::geometry::{Geometry, PreparedFacet};
use crate::periods::PeriodicImages;
use crate::settings::ErrorGoal;
use zonal_exchange::polygon::visible::{IntegrationRequest, OccludedView, obstructed_sky, unobstructed_sky};
use zonal_math::{Bounded, Vec3};

/// Cells along an edge of the cube of directions; even, so that no cell crosses the horizon.
const CELLS_PER_EDGE: usize = 4;
/// Occluders of a cell above which it is divided, and the depth of division.
const MAX_CELL_OCCLUDERS: usize = 24;
const MAX_CELL_DEPTH: u32 = 3;
/// Occluders of a cell, the largest first, that are tested for hiding others.
const MAX_HIDING_OCCLUDERS: usize = 8;
/// Requested radius of a sky factor relative to that of a pair.
pub(crate) const SKY_GOAL: f64 = 40.0;
/// Requested radius of the exchange in unresolved directions: relative to that of a pair, and to the value.
const UNRESOLVED_GOAL: f64 = 0.2;
const UNRESOLVED_RELATIVE_GOAL: f64 = 0.25;
/// Evaluations of visible cells for a facet, at most.
const MAX_SKY_EVALUATIONS: u64 = 80_000;

/// Part of the surroundings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Region {
    Sky,
    Ground,
    /// Directions above and below the horizon whose rays may leave all represented images of a periodic geometry unseen (`periods.rs`).
    UnresolvedSky,
    UnresolvedGround,
}

/// The exchange of one facet with the surroundings, m².
#[derive(Clone, Copy, Debug)]
pub(crate) struct SkyExchange {
    pub sky: Bounded,
    pub ground: Bounded,
    /// Upper bound of the exchange in unresolved directions, which the radii of sky and ground contain.
    pub unresolved: f64,
}

impl SkyExchange {
    const ZERO: SkyExchange = SkyExchange { sky: Bounded::ZERO, ground: Bounded::ZERO, unresolved: 0.0 };
}

/// An occluder before a cell of directions.
struct NearOccluder {
    occluder: usize,
    shift: Vec3,
    centre: Vec3,
    /// Square of its radius over the distance.
    extent: f64,
}

/// The recursion for some facets.
pub(crate) struct SkyTraversal<'a> {
    geometry: &'a Geometry,
    images: &'a PeriodicImages,
    goal: ErrorGoal,
    up: usize,
    /// Exact parts of each facet, and its partly hidden cells.
    free: Vec<(u32, Region, Bounded)>,
    partial: std::collections::BTreeMap<(u32, Region), Vec<OccludedView>>,
}

/// All cells of directions, divided at the limits of unresolved ones.
pub(crate) fn direction_cells(images: &PeriodicImages) -> Vec<DirectionCell> {
    let split = |cell: DirectionCell, k: usize| -> Vec<DirectionCell> {
        let cut = images.cut(cell.axis, (cell.axis + 1 + k) % 3);
        let [low, high] = cell.range[k];
        let cuts = [-cut, cut].into_iter().filter(|s| low < *s && *s < high);
        let ends: Vec<f64> = std::iter::once(low).chain(cuts).chain(std::iter::once(high)).collect();
        let part = |w: &[f64]| {
            let mut part = cell;
            part.range[k] = [w[0], w[1]];
            part
        };
        ends.windows(2).map(part).collect()
    };
    let cells = DirectionCell::sphere(CELLS_PER_EDGE).into_iter();
    cells.flat_map(|c| split(c, 0)).flat_map(|c| split(c, 1)).collect()
}

impl<'a> SkyTraversal<'a> {
    pub(crate) fn new(
        geometry: &'a Geometry,
        images: &'a PeriodicImages,
        goal: ErrorGoal,
        up: usize,
    ) -> SkyTraversal<'a> {
        SkyTraversal {
            geometry,
            images,
            goal,
            up,
            free: Vec::new(),
            partial: std::collections::BTreeMap::new(),
        }
    }

    /// The exchange of the facets of `node`, by facet.
    pub(crate) fn run(mut self, node: u32, cells: &[DirectionCell]) -> Vec<(u32, SkyExchange)> {
        let all = occluder_list::all(self.geometry, self.images);
        cells.iter().for_each(|c| self.visit(node, c, &all));
        let facets = self.geometry.facets_of(node);
        let mut sums: std::collections::BTreeMap<u32, SkyExchange> =
            facets.iter().map(|f| (*f, SkyExchange::ZERO)).collect();
        for ((facet, region), mut cones) in std::mem::take(&mut self.partial) {
            let p = self.geometry.facets[facet as usize].polygon();
            let (relative, share) = match region {
                Region::Sky | Region::Ground => (0.0, SKY_GOAL),
                Region::UnresolvedSky | Region::UnresolvedGround => {
                    (UNRESOLVED_RELATIVE_GOAL, UNRESOLVED_GOAL)
                }
            };
            let request = IntegrationRequest {
                relative,
                absolute: share * self.goal.absolute * p.area(),
                max_evaluations: MAX_SKY_EVALUATIONS,
            };
            self.free.push((facet, region, obstructed_sky(p, &mut cones, &request)));
        }
        for (facet, region, b) in &self.free {
            let sum = sums.entry(*facet).or_insert(SkyExchange::ZERO);
            // An unresolved ray meets an image that is not represented, or nothing.
            let most = b.value + b.radius;
            let either = Bounded::estimated(0.5 * most, 0.5 * most);
            match region {
                Region::Sky => sum.sky = sum.sky + *b,
                Region::Ground => sum.ground = sum.ground + *b,
                Region::UnresolvedSky => sum.sky = sum.sky + either,
                Region::UnresolvedGround => sum.ground = sum.ground + either,
            }
            if matches!(region, Region::UnresolvedSky | Region::UnresolvedGround) {
                sum.unresolved += most;
            }
        }
        sums.into_iter().collect()
    }

    fn region(&self, facet: u32, cell: &DirectionCell) -> Region {
        let is_above = cell.centre().array()[self.up] > 0.0;
        let rise = self.images.rise_from(&self.geometry.facets[facet as usize].bounds, is_above);
        if self.images.is_unresolved_within(cell, rise) {
            if is_above { Region::UnresolvedSky } else { Region::UnresolvedGround }
        } else if is_above {
            Region::Sky
        } else {
            Region::Ground
        }
    }

    fn visit(&mut self, node: u32, cell: &DirectionCell, list: &[OccluderNode]) {
        let (g, corners) = (self.geometry, cell.corners());
        if !g.may_face_directions(node, &corners) {
            return;
        }
        let n = g.node(node);
        let shaft = SkyShaft::new(&n.bounds, cell, g.contact);
        let mut near = Vec::new();
        occluder_list::filter(g, self.images, list, n.bounds.radius(), |o| shaft.excludes(o), &mut near);
        if near.is_empty() {
            for f in g.facets_of(node) {
                let whole = unobstructed_sky(g.facets[*f as usize].polygon(), &corners);
                self.free.push((*f, self.region(*f, cell), whole));
            }
            return;
        }
        let from = Hull { middle: n.bounds.centre(), corners: &n.bounds.corners() };
        let to = Hull { middle: cell.centre(), corners: &corners };
        let hidden = near.iter().any(|e| {
            let Some(k) = occluder_list::single(g, *e) else { return false };
            g.hides(k, from, to, 0.0, self.images.shift(&e.block))
        });
        if hidden {
            return;
        }
        match n.children {
            Some(children) => children.iter().for_each(|c| self.visit(*c, cell, &near)),
            None => g.facets_of(node).iter().for_each(|f| self.facet(*f, cell, &near, 0)),
        }
    }

    fn facet(&mut self, f: u32, cell: &DirectionCell, list: &[OccluderNode], depth: u32) {
        let g = self.geometry;
        let (facet, corners) = (&g.facets[f as usize], cell.corners());
        let p = facet.polygon();
        if corners.iter().all(|d| p.normal().dot(*d) <= 0.0) {
            return;
        }
        let shaft = SkyShaft::new(&facet.bounds, cell, g.contact);
        let mut near = Vec::new();
        occluder_list::filter(g, self.images, list, 0.0, |o| shaft.excludes(o), &mut near);
        let Some(mut before) = self.occluders(facet, &corners, &near) else { return };
        if before.is_empty() {
            self.free.push((f, self.region(f, cell), unobstructed_sky(p, &corners)));
            return;
        }
        self.keep_foremost(facet, &mut before);
        if before.len() > MAX_CELL_OCCLUDERS && depth < MAX_CELL_DEPTH {
            cell.quarters().iter().for_each(|c| self.facet(f, c, &near, depth + 1));
            return;
        }
        let Some(mut view) = OccludedView::of_directions(p, &corners) else { return };
        before.iter().for_each(|o| view.add(&g.occluders[o.occluder].placed(o.shift)));
        self.partial.entry((f, self.region(f, cell))).or_default().push(view);
    }

    /// Orders occluders, large and near ones first, so that later ones find little left to hide; removes those that lie wholly behind another one.
    fn keep_foremost(&self, facet: &PreparedFacet, before: &mut Vec<NearOccluder>) {
        before.sort_by(|a, b| b.extent.total_cmp(&a.extent));
        let mut kept: Vec<NearOccluder> = Vec::with_capacity(before.len());
        for o in before.drain(..) {
            let bounds = self.geometry.occluders[o.occluder].bounds.shifted(o.shift);
            let corners = bounds.corners();
            let to = Hull { middle: o.centre, corners: &corners };
            let behind = kept
                .iter()
                .take(MAX_HIDING_OCCLUDERS)
                .any(|k| self.geometry.hides(k.occluder, facet.hull(), to, 1.0, k.shift));
            if !behind {
                kept.push(o);
            }
        }
        *before = kept;
    }

    /// The occluders between a facet and a cell; None if one hides all of it.
    fn occluders(
        &self,
        facet: &PreparedFacet,
        cell: &[Vec3],
        near: &[OccluderNode],
    ) -> Option<Vec<NearOccluder>> {
        let (g, p) = (self.geometry, facet.polygon());
        let to = Hull { middle: cell.iter().fold(Vec3::ZERO, |s, c| s + *c), corners: cell };
        let mut before = Vec::new();
        for e in near {
            let Some(k) = occluder_list::single(g, *e) else { continue };
            let (o, shift) = (&g.occluders[k], self.images.shift(&e.block));
            if g.hides(k, facet.hull(), to, 0.0, shift) {
                return None;
            }
            let is_behind = o.body.corners().iter().all(|c| p.height(*c + shift) <= g.contact);
            if !is_behind && !o.is_beside(p.corners(), cell, 0.0, shift, g.contact) {
                let centre = o.centre + shift;
                let extent = o.radius * o.radius / (centre - facet.centre).length2();
                before.push(NearOccluder { occluder: k, shift, centre, extent });
            }
        }
        Some(before)
    }
}
