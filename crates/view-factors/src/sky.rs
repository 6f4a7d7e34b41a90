//! Exchange with the surroundings: directions in which nothing is hit, above and below the horizon, independent of the pairs of facets.
//!
//! The sphere of directions is divided into cells on the faces of a cube. For a node of facets and a cell, the occluders along the
//! rays from the node into the cell are listed; without any, the cell's part is A ω⊥/π exactly; with one that hides the whole cell, zero. The
//! partly hidden cells of a facet are integrated together over the facet, their visible parts in closed form for each point
//! ([`zonal_exchange::polygon::visible::obstructed_sky`]). A cell with very many occluders is divided first.

use crate::direction_cell::DirectionCell;
use crate::geometry::{Geometry, PreparedFacet};
use crate::occluder_list::{self, OccluderNode};
use crate::periods::PeriodicImages;
use crate::settings::ErrorGoal;
use crate::shaft::SkyShaft;
use zonal_exchange::polygon::visible::{
    ConvexPolygon, IntegrationRequest, ObstructedCone, obstructed_sky, unobstructed_sky,
};
use zonal_math::{Bounded, Vec3};

/// Cells along an edge of the cube of directions; even, so that no cell crosses the horizon.
const CELLS_PER_EDGE: usize = 4;
/// Occluders of a cell above which it is divided, and the depth of division.
const MAX_CELL_OCCLUDERS: usize = 24;
const MAX_CELL_DEPTH: u32 = 3;
/// Occluders of a cell, the largest first, that are tested for hiding others.
const MAX_HIDING_OCCLUDERS: usize = 8;
/// Requested radius of a sky factor relative to that of a pair.
const SKY_GOAL: f64 = 40.0;
/// Evaluations of visible cells for a facet, at most.
const MAX_SKY_EVALUATIONS: u64 = 20_000;

/// Part of the surroundings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Region {
    Sky,
    Ground,
    /// Directions that may pass all images of a periodic geometry (`periods.rs`).
    Grazing,
}

/// The exchange of one facet with the surroundings, m².
#[derive(Clone, Copy, Debug)]
pub(crate) struct SkyExchange {
    pub sky: Bounded,
    pub ground: Bounded,
}

/// An occluder cut to the space in front of a facet.
struct CutOccluder {
    occluder: usize,
    shift: Vec3,
    polygon: ConvexPolygon,
    centre: Vec3,
    /// Area over the square of the distance.
    extent: f64,
}

/// The mean of points.
fn middle(points: &[Vec3]) -> Vec3 {
    points.iter().fold(Vec3::ZERO, |s, c| s + *c) / points.len() as f64
}

/// The recursion for some facets.
pub(crate) struct SkyTraversal<'a> {
    geometry: &'a Geometry,
    images: &'a PeriodicImages,
    goal: ErrorGoal,
    up: usize,
    /// Exact parts of each facet, and its partly hidden cells.
    free: Vec<(u32, Region, Bounded)>,
    partial: std::collections::BTreeMap<(u32, Region), Vec<ObstructedCone>>,
}

/// All cells of directions, divided at the slopes below which directions are unresolved.
pub(crate) fn direction_cells(images: &PeriodicImages, up: usize) -> Vec<DirectionCell> {
    let split = |cell: DirectionCell| -> Vec<DirectionCell> {
        let slope = images.grazing_slope[cell.axis];
        if cell.axis == up || slope == 0.0 {
            return vec![cell];
        }
        // The coordinate along `up` is the first or the second range of the cell.
        let k = if (cell.axis + 1) % 3 == up { 0 } else { 1 };
        let [low, high] = cell.range[k];
        let cuts = [-slope, slope].into_iter().filter(|s| low < *s && *s < high);
        let ends: Vec<f64> = std::iter::once(low).chain(cuts).chain(std::iter::once(high)).collect();
        let part = |w: &[f64]| {
            let mut part = cell;
            part.range[k] = [w[0], w[1]];
            part
        };
        ends.windows(2).map(part).collect()
    };
    DirectionCell::sphere(CELLS_PER_EDGE).into_iter().flat_map(split).collect()
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
        let root = |k: usize| OccluderNode { node: 0, shift: k as u32 };
        let all: Vec<OccluderNode> = (0..self.images.shifts.len()).map(root).collect();
        cells.iter().for_each(|c| self.visit(node, c, &all));
        let facets = self.geometry.facets_of(node);
        let none = SkyExchange { sky: Bounded::ZERO, ground: Bounded::ZERO };
        let mut sums: std::collections::BTreeMap<u32, SkyExchange> =
            facets.iter().map(|f| (*f, none)).collect();
        for ((facet, region), cones) in &self.partial {
            let p = self.geometry.facets[*facet as usize].polygon();
            let request = IntegrationRequest {
                relative: 0.0,
                absolute: SKY_GOAL * self.goal.absolute * p.area(),
                max_evaluations: MAX_SKY_EVALUATIONS,
            };
            self.free.push((*facet, *region, obstructed_sky(p, cones, &request)));
        }
        for (facet, region, b) in &self.free {
            let sum = sums.entry(*facet).or_insert(none);
            match region {
                Region::Sky => sum.sky = sum.sky + *b,
                Region::Ground => sum.ground = sum.ground + *b,
                Region::Grazing => sum.sky = sum.sky + Bounded::estimated(b.value, b.value + b.radius),
            }
        }
        sums.into_iter().collect()
    }

    fn region(&self, cell: &DirectionCell) -> Region {
        let d = cell.centre().array();
        if d[self.up].abs() < self.images.grazing_slope[cell.axis] {
            Region::Grazing
        } else if d[self.up] > 0.0 {
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
        occluder_list::filter(
            g,
            &self.images.shifts,
            list,
            n.bounds.radius(),
            |o| shaft.excludes(o),
            &mut near,
        );
        if near.is_empty() {
            for f in g.facets_of(node) {
                let whole = unobstructed_sky(g.facets[*f as usize].polygon(), &corners);
                self.free.push((*f, self.region(cell), whole));
            }
            return;
        }
        let (from, to) = (n.bounds.centre(), cell.centre());
        let hidden = near.iter().any(|e| {
            let Some(k) = occluder_list::single(g, *e) else { return false };
            let shift = self.images.shifts[e.shift as usize];
            g.occluders[k].crosses(from, to, 0.0, shift)
                && g.hides(k, &n.bounds.corners(), &corners, 0.0, shift)
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
        occluder_list::filter(g, &self.images.shifts, list, 0.0, |o| shaft.excludes(o), &mut near);
        let Some(cut) = self.occluders(p, &corners, &near) else { return };
        if cut.is_empty() {
            self.free.push((f, self.region(cell), unobstructed_sky(p, &corners)));
            return;
        }
        let foremost = self.foremost(facet, cut);
        if foremost.len() > MAX_CELL_OCCLUDERS && depth < MAX_CELL_DEPTH {
            cell.quarters().iter().for_each(|c| self.facet(f, c, &near, depth + 1));
            return;
        }
        let cone = ObstructedCone { corners: corners.to_vec(), obstructions: foremost };
        self.partial.entry((f, self.region(cell))).or_default().push(cone);
    }

    /// The occluders without those that lie wholly behind another one; large and near ones first, so that later ones find little left to hide.
    fn foremost(&self, facet: &PreparedFacet, mut cut: Vec<CutOccluder>) -> Vec<ConvexPolygon> {
        cut.iter_mut().for_each(|o| {
            o.centre = middle(o.polygon.corners());
            o.extent = o.polygon.area() / (o.centre - facet.centre).length2();
        });
        cut.sort_by(|a, b| b.extent.total_cmp(&a.extent));
        let mut kept: Vec<CutOccluder> = Vec::with_capacity(cut.len());
        for o in cut {
            let behind = kept.iter().take(MAX_HIDING_OCCLUDERS).any(|k| {
                self.geometry.occluders[k.occluder].crosses(facet.centre, o.centre, 1.0, k.shift)
                    && self.geometry.hides(
                        k.occluder,
                        facet.polygon().corners(),
                        o.polygon.corners(),
                        1.0,
                        k.shift,
                    )
            });
            if !behind {
                kept.push(o);
            }
        }
        kept.into_iter().map(|o| o.polygon).collect()
    }

    /// The occluders between a facet and a cell, cut to the space in front of the facet; None if one hides all of it.
    fn occluders(&self, p: &ConvexPolygon, cell: &[Vec3], near: &[OccluderNode]) -> Option<Vec<CutOccluder>> {
        let g = self.geometry;
        let (from, to) = (middle(p.corners()), middle(cell));
        let mut cut = Vec::new();
        for e in near {
            let Some(k) = occluder_list::single(g, *e) else { continue };
            let shift = self.images.shifts[e.shift as usize];
            if g.occluders[k].crosses(from, to, 0.0, shift) && g.hides(k, p.corners(), cell, 0.0, shift) {
                return None;
            }
            let o = &g.occluders[k].polygon;
            let placed = if shift == Vec3::ZERO { Some(o.clone()) } else { o.translated(shift) };
            let Some(placed) = placed.and_then(|o| o.in_front_of(p, g.contact)) else { continue };
            // The facet and all directions on one side of its plane.
            let side = |sign: f64| {
                p.corners().iter().all(|c| sign * placed.height(*c) >= -g.contact)
                    && cell.iter().all(|d| sign * placed.normal().dot(*d) >= 0.0)
            };
            if !side(1.0) && !side(-1.0) {
                cut.push(CutOccluder {
                    occluder: k,
                    shift,
                    polygon: placed,
                    centre: Vec3::ZERO,
                    extent: 0.0,
                });
            }
        }
        Some(cut)
    }
}
