//! All pairs of facets by a recursion over pairs of nodes.
//!
//! A pair of nodes whose facets face away from each other, or that one occluder hides from each other, has no exchange. Any other is divided
//! until single facets remain. The list of occluders in the shaft shrinks along the way. Two facets then have
//!
//! - nothing between them: 𝓕 by rules and contours, proved;
//! - one occluder over all segments between them: 𝓕 = 0;
//! - else: the visible parts, integrated adaptively, estimated.

use crate::blocking::Hull;
use crate::bounds::Bounds;
use crate::geometry::{Geometry, PreparedFacet};
use crate::occluder_list::{self, OccluderNode, Shifts};
use crate::settings::ErrorGoal;
use crate::shaft::BoxShaft;
use zonal_exchange::polygon::visible::{
    ConvexPolygon, IntegrationRequest, OccludedView, add_shaft_planes, obstructed_exchange,
};
use zonal_math::Vec3;

/// Share of the requested radius below which a pair is left out: its factors are zero in the result, and their sum is part of the defects.
const OMITTED_SHARE: f64 = 0.1;

/// A pair of nodes with its potential occluders; the second node is displaced by a period.
#[derive(Clone, Debug)]
pub(crate) struct NodePair {
    pub a: u32,
    pub b: u32,
    pub shift: u32,
    pub occluders: Vec<OccluderNode>,
}

/// 𝓕 of two facets, m².
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairExchange {
    pub i: u32,
    pub j: u32,
    pub value: f64,
    pub radius: f32,
}

/// Numbers of pairs by treatment.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TreatmentCounts {
    pub node_pairs: u64,
    pub unobstructed: u64,
    pub hidden: u64,
    pub partial: u64,
    pub facet_pairs: u64,
}

impl TreatmentCounts {
    pub(crate) fn numbers(&self) -> [u64; 5] {
        [self.node_pairs, self.unobstructed, self.hidden, self.partial, self.facet_pairs]
    }

    pub(crate) fn from_numbers(n: [u64; 5]) -> TreatmentCounts {
        TreatmentCounts {
            node_pairs: n[0],
            unobstructed: n[1],
            hidden: n[2],
            partial: n[3],
            facet_pairs: n[4],
        }
    }

    pub(crate) fn add(&mut self, o: &TreatmentCounts) {
        self.node_pairs += o.node_pairs;
        self.unobstructed += o.unobstructed;
        self.hidden += o.hidden;
        self.partial += o.partial;
        self.facet_pairs += o.facet_pairs;
    }
}

/// The recursion over pairs, and its results.
pub(crate) struct PairTraversal<'a> {
    geometry: &'a Geometry,
    shifts: &'a Shifts,
    goal: ErrorGoal,
    pub found: Vec<PairExchange>,
    pub counts: TreatmentCounts,
    /// Occluders near the current leaves.
    near: Vec<(usize, Vec3)>,
    planes: Vec<(Vec3, f64)>,
    view: OccludedView,
}

impl<'a> PairTraversal<'a> {
    pub(crate) fn new(geometry: &'a Geometry, shifts: &'a Shifts, goal: ErrorGoal) -> PairTraversal<'a> {
        PairTraversal {
            geometry,
            shifts,
            goal,
            found: Vec::new(),
            counts: TreatmentCounts::default(),
            near: Vec::new(),
            planes: Vec::new(),
            view: OccludedView::default(),
        }
    }

    fn bounds_of_second(&self, pair: &NodePair) -> Bounds {
        self.geometry.node(pair.b).bounds.shifted(self.shifts[pair.shift as usize])
    }

    /// The parts of a pair that may exchange, or None for a pair of leaves.
    pub(crate) fn divide(&mut self, pair: &NodePair) -> Option<Vec<NodePair>> {
        let g = self.geometry;
        let (a, b) = (g.node(pair.a), g.node(pair.b));
        let mut parts = Vec::with_capacity(3);
        let same = pair.a == pair.b && pair.shift == 0;
        match (a.children, b.children) {
            (None, None) => return None,
            (Some([left, right]), _) if same => {
                parts.extend([(left, left), (left, right), (right, right)]);
            }
            (Some(children), None) => parts.extend(children.map(|c| (c, pair.b))),
            (Some(children), Some(_)) if a.bounds.radius() >= b.bounds.radius() => {
                parts.extend(children.map(|c| (c, pair.b)));
            }
            (_, Some(children)) => parts.extend(children.map(|c| (pair.a, c))),
        }
        let list = &pair.occluders;
        Some(parts.into_iter().filter_map(|(x, y)| self.part(x, y, pair.shift, list)).collect())
    }

    /// A pair of nodes with the occluders of its shaft; None if it has no exchange.
    fn part(&mut self, a: u32, b: u32, shift: u32, list: &[OccluderNode]) -> Option<NodePair> {
        self.counts.node_pairs += 1;
        let g = self.geometry;
        if a == b && shift == 0 {
            return Some(NodePair { a, b, shift, occluders: list.to_vec() });
        }
        let by = self.shifts[shift as usize];
        let (first, second) = (g.node(a).bounds, g.node(b).bounds.shifted(by));
        if !g.may_face(a, &second) || !g.may_face(b, &first.shifted(-by)) {
            return None;
        }
        let shaft = BoxShaft::new(&first, &second, g.contact);
        let size = first.radius().max(second.radius());
        let mut occluders = Vec::new();
        occluder_list::filter(g, self.shifts, list, size, |o| shaft.excludes(o), &mut occluders);
        let hidden = self.is_hidden(&first, &second, &occluders);
        (!hidden).then_some(NodePair { a, b, shift, occluders })
    }

    /// True if one occluder hides two boxes from each other.
    fn is_hidden(&self, a: &Bounds, b: &Bounds, occluders: &[OccluderNode]) -> bool {
        let corners = (a.corners(), b.corners());
        let (from, to) = (
            Hull { middle: a.centre(), corners: &corners.0 },
            Hull { middle: b.centre(), corners: &corners.1 },
        );
        occluders.iter().any(|e| {
            let Some(k) = occluder_list::single(self.geometry, *e) else { return false };
            self.geometry.hides(k, from, to, 1.0, self.shifts[e.shift as usize])
        })
    }

    /// All exchange of a pair of nodes.
    pub(crate) fn visit(&mut self, pair: &NodePair) {
        match self.divide(pair) {
            Some(parts) => parts.iter().for_each(|p| self.visit(p)),
            None => self.leaves(pair),
        }
    }

    fn leaves(&mut self, pair: &NodePair) {
        let g = self.geometry;
        let shaft = BoxShaft::new(&g.node(pair.a).bounds, &self.bounds_of_second(pair), g.contact);
        let mut near = Vec::new();
        occluder_list::filter(g, self.shifts, &pair.occluders, 0.0, |o| shaft.excludes(o), &mut near);
        self.near.clear();
        for e in near {
            if let Some(k) = occluder_list::single(g, e) {
                self.near.push((k, self.shifts[e.shift as usize]));
            }
        }
        let same = pair.a == pair.b && pair.shift == 0;
        for (n, &i) in g.facets_of(pair.a).iter().enumerate() {
            let others = &g.facets_of(pair.b)[if same { n + 1 } else { 0 }..];
            for &j in others {
                self.facets(i, j, pair.shift);
            }
        }
    }

    fn facets(&mut self, i: u32, j: u32, shift: u32) {
        let by = self.shifts[shift as usize];
        let contact = self.geometry.contact;
        let moved;
        let a = &self.geometry.facets[i as usize];
        let b = &self.geometry.facets[j as usize];
        let b = if shift == 0 {
            b
        } else {
            moved = b.shifted(by);
            &moved
        };
        let rises = |p: &ConvexPolygon, q: &ConvexPolygon| q.corners().iter().any(|c| p.height(*c) > contact);
        if !rises(a.polygon(), b.polygon()) || !rises(b.polygon(), a.polygon()) {
            return;
        }
        self.counts.facet_pairs += 1;
        let absolute = self.goal.absolute * a.polygon().area().min(b.polygon().area());
        let bounded = match self.occluders_between(a, b) {
            Obstruction::Nothing => {
                self.counts.unobstructed += 1;
                a.prepared.exchange(&b.prepared, self.goal.relative, absolute)
            }
            Obstruction::Everything => {
                self.counts.hidden += 1;
                return;
            }
            Obstruction::Parts(outer) => {
                self.counts.partial += 1;
                let request = IntegrationRequest {
                    relative: self.goal.relative,
                    absolute,
                    max_evaluations: self.goal.max_evaluations,
                };
                obstructed_exchange(&outer, &mut self.view, &request)
            }
        };
        if bounded.value + bounded.radius > OMITTED_SHARE * absolute {
            let (value, radius) = (bounded.value, round_up(bounded.radius));
            self.found.push(PairExchange { i, j, value, radius });
        }
    }

    /// False if an occluder is beside the segments between two facets.
    fn may_be_between(&self, (k, shift): (usize, Vec3), a: &PreparedFacet, b: &PreparedFacet) -> bool {
        let o = &self.geometry.occluders[k];
        let (axis, from_a) = (b.centre - a.centre, o.centre + shift - a.centre);
        // The hull of the two bounding spheres lies within this distance of the segment of their centres.
        let reach = a.radius.max(b.radius) + o.radius;
        let t = (from_a.dot(axis) / axis.length2()).clamp(0.0, 1.0);
        let (p, q) = (a.polygon().corners(), b.polygon().corners());
        (from_a - axis * t).length2() < reach * reach && !o.is_beside(p, q, 1.0, shift, self.geometry.contact)
    }

    /// The occluders between two facets, in `self.view`.
    fn occluders_between(&mut self, a: &PreparedFacet, b: &PreparedFacet) -> Obstruction {
        self.planes.clear();
        let (p, q, contact) = (a.polygon(), b.polygon(), self.geometry.contact);
        let mut parts: Option<[ConvexPolygon; 2]> = None;
        for place in 0..self.near.len() {
            let (k, shift) = self.near[place];
            if !self.may_be_between((k, shift), a, b) {
                continue;
            }
            let o = &self.geometry.occluders[k];
            if self.geometry.hides(k, a.hull(), b.hull(), 1.0, shift) {
                // What hides this pair may hide the next one.
                self.near.swap(0, place);
                return Obstruction::Everything;
            }
            if self.planes.is_empty() {
                add_shaft_planes(p, q, contact, &mut self.planes);
            }
            if self.planes.iter().any(|(n, c)| o.is_beyond((*n, c - contact), shift)) {
                continue;
            }
            if parts.is_none() {
                // Without a part in front there is nothing to see.
                let Some(ends) = ordered_parts(p, q, contact) else { return Obstruction::Everything };
                self.view.set_polygon(&ends[0], &ends[1]);
                parts = Some(ends);
            }
            let Some([outer, target]) = &parts else { continue };
            let placed = o.placed(shift);
            if placed.corners().iter().all(|c| outer.height(*c) <= contact) {
                continue;
            }
            let Some(cut) = placed.in_front_of(target, contact) else { continue };
            let is_outside = |(n, c): &(Vec3, f64)| cut.corners().iter().all(|x| n.dot(*x) >= c - contact);
            if cut.corners().len() == placed.corners().len() || !self.planes.iter().any(is_outside) {
                self.view.add(&cut);
            }
        }
        match parts {
            Some([outer, _]) if self.view.obstructions() > 0 => Obstruction::Parts(outer),
            _ => Obstruction::Nothing,
        }
    }
}

/// The part of each polygon in front of the other, the smaller one first.
fn ordered_parts(p: &ConvexPolygon, q: &ConvexPolygon, contact: f64) -> Option<[ConvexPolygon; 2]> {
    let (p, q) = (p.in_front_of(q, contact)?, q.in_front_of(p, contact)?);
    Some(if p.area() <= q.area() { [p, q] } else { [q, p] })
}

/// What is between two facets.
enum Obstruction {
    Nothing,
    Everything,
    /// Bodies that may hide parts; the smaller facet's part in front of the other.
    Parts(ConvexPolygon),
}

/// A radius in single precision that is not smaller.
pub(crate) fn round_up(radius: f64) -> f32 {
    let r = radius as f32;
    if f64::from(r) < radius { r.next_up() } else { r }
}
