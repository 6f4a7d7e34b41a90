//! All pairs of facets by a recursion over pairs of nodes.
//!
//! A pair of nodes whose facets face away from each other, or that one occluder hides from each other, has no exchange. Any other is divided
//! until single facets remain. The list of occluders in the shaft shrinks along the way. Two facets then have
//!
//! - nothing between them: 𝓕 by rules and contours, proved;
//! - one occluder over all segments between them: 𝓕 = 0;
//! - else: the visible parts, integrated adaptively, estimated.

use crate::bounds::Bounds;
use crate::bounds::shaft::BoxShaft;
use crate::geometry::blocking::Hull;
use crate::geometry::occluder_list::{self, OccluderNode};
use crate::geometry::{Geometry, PreparedFacet};
use crate::matrix::image_sum::{self, ImageFunction, SumGoal};
use crate::periods::{ImageBlock, PeriodicImages};
use crate::settings::ErrorGoal;
use std::f64::consts::PI;
use zonal_exchange::polygon::visible::{
    ConvexPolygon, IntegrationRequest, OccludedView, add_shaft_planes, obstructed_exchange,
};
use zonal_math::{Bounded, Vec3};

/// Share of the requested radius below which a pair is left out: its factors are zero in the result, and their sum is part of the defects.
const OMITTED_SHARE: f64 = 0.1;

/// Parts of the requested radius of a pair that repeats, for its images.
const IMAGE_SHARES: f64 = 16.0;
/// Evaluations of an image, at most, that is not near.
const MAX_FAR_EVALUATIONS: u64 = 500;
/// Rows of images, at most, that are summed one by one where all occluders are endless along both axes.
const MAX_SINGLE_ROWS: i32 = 4096;
/// Share of the requested relative radius for one image.
const RELATIVE_IMAGE_SHARE: f64 = 0.5;

/// A pair of nodes with its potential occluders; the second node stands for its images in a block.
#[derive(Clone, Debug)]
pub(crate) struct NodePair {
    pub a: u32,
    pub b: u32,
    pub block: ImageBlock,
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

zonal_math::counters!(TreatmentCounts of u64: node_pairs, unobstructed, hidden, partial, facet_pairs);

/// Adds the images of each pair of facets.
pub(crate) fn merge_images(found: &mut Vec<PairExchange>) {
    let key = |p: &PairExchange| (p.i.min(p.j), p.i.max(p.j));
    found.sort_by_key(key);
    found.dedup_by(|next, sum| {
        let is_same = key(next) == key(sum);
        if is_same {
            sum.value += next.value;
            sum.radius = (sum.radius + next.radius).next_up();
        }
        is_same
    });
}

/// The recursion over pairs, and its results.
pub(crate) struct PairTraversal<'a> {
    geometry: &'a Geometry,
    images: &'a PeriodicImages,
    goal: ErrorGoal,
    pub found: Vec<PairExchange>,
    pub counts: TreatmentCounts,
    /// Occluders near the current leaves.
    near: Vec<(usize, Vec3)>,
    planes: Vec<(Vec3, f64)>,
    view: OccludedView,
}

impl<'a> PairTraversal<'a> {
    pub(crate) fn new(
        geometry: &'a Geometry,
        images: &'a PeriodicImages,
        goal: ErrorGoal,
    ) -> PairTraversal<'a> {
        PairTraversal {
            geometry,
            images,
            goal,
            found: Vec::new(),
            counts: TreatmentCounts::default(),
            near: Vec::new(),
            planes: Vec::new(),
            view: OccludedView::default(),
        }
    }

    /// The parts of a pair that may exchange, or None for a pair of leaves whose images need no division.
    pub(crate) fn divide(&mut self, pair: &NodePair) -> Option<Vec<NodePair>> {
        let g = self.geometry;
        let (a, b) = (g.node(pair.a), g.node(pair.b));
        let list = &pair.occluders;
        if let Some(blocks) = self.divided_block(pair) {
            let part = |block| self.part(pair.a, pair.b, block, list);
            return Some(blocks.into_iter().filter_map(part).collect());
        }
        let mut parts = Vec::with_capacity(3);
        let same = pair.a == pair.b && pair.block == ImageBlock::ORIGIN;
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
        Some(parts.into_iter().filter_map(|(x, y)| self.part(x, y, pair.block, list)).collect())
    }

    /// The parts of a block of images that cannot be summed as one: an occluder in the shaft is not endless along an axis of the block, or the block
    /// has few rows.
    fn divided_block(&self, pair: &NodePair) -> Option<[ImageBlock; 2]> {
        if pair.block.is_single() {
            return None;
        }
        let is_long = [0, 1].map(|k| pair.block.first[k] < pair.block.last[k]);
        let varies =
            |k: usize| is_long[k] && !pair.occluders.iter().all(|o| occluder_list::endless_axes(o.tree)[k]);
        // The axis with finitely many images first: the other one may be summed.
        let [k, l] = self.images.counts;
        let order = if l < k { [1, 0] } else { [0, 1] };
        let axis = order.into_iter().find(|k| varies(*k));
        let second = order.into_iter().find(|k| is_long[*k] && self.images.counts[*k] <= MAX_SINGLE_ROWS);
        let axis = axis.or(if is_long == [true; 2] { second } else { None });
        axis.map(|k| pair.block.divided(k))
    }

    /// A pair of nodes with the occluders of its shaft; None if it has no exchange.
    fn part(&mut self, a: u32, b: u32, block: ImageBlock, list: &[OccluderNode]) -> Option<NodePair> {
        self.counts.node_pairs += 1;
        let g = self.geometry;
        if a == b && block == ImageBlock::ORIGIN {
            return Some(NodePair { a, b, block, occluders: list.to_vec() });
        }
        let (first, second) = (g.node(a).bounds, self.images.bounds(&g.node(b).bounds, &block));
        let opposite = ImageBlock { first: block.last.map(|n| -n), last: block.first.map(|n| -n) };
        if !g.may_face(a, &second) || !g.may_face(b, &self.images.bounds(&first, &opposite)) {
            return None;
        }
        let shaft = BoxShaft::new(&first, &second, g.contact);
        let size = first.radius().max(second.radius());
        let mut occluders = Vec::new();
        occluder_list::filter(g, self.images, list, size, |o| shaft.excludes(o), &mut occluders);
        let hidden = self.is_hidden(&first, &second, &occluders);
        (!hidden).then_some(NodePair { a, b, block, occluders })
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
            self.geometry.hides(k, from, to, 1.0, self.images.shift(&e.block))
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
        let second = self.images.bounds(&g.node(pair.b).bounds, &pair.block);
        let shaft = BoxShaft::new(&g.node(pair.a).bounds, &second, g.contact);
        let mut near = Vec::new();
        occluder_list::filter(g, self.images, &pair.occluders, 0.0, |o| shaft.excludes(o), &mut near);
        self.near.clear();
        for e in near {
            if let Some(k) = occluder_list::single(g, e) {
                self.near.push((k, self.images.shift(&e.block)));
            }
        }
        let same = pair.a == pair.b && pair.block == ImageBlock::ORIGIN;
        for (n, &i) in g.facets_of(pair.a).iter().enumerate() {
            let others = &g.facets_of(pair.b)[if same { n + 1 } else { 0 }..];
            for &j in others {
                self.facets(i, j, &pair.block);
            }
        }
    }

    fn facets(&mut self, i: u32, j: u32, block: &ImageBlock) {
        let (a, b) = (&self.geometry.facets[i as usize], &self.geometry.facets[j as usize]);
        let absolute = self.goal.absolute * a.polygon().area().min(b.polygon().area());
        let repeats = self.images.any();
        let request = IntegrationRequest {
            relative: if repeats { RELATIVE_IMAGE_SHARE } else { 1.0 } * self.goal.relative,
            absolute: if repeats { absolute / IMAGE_SHARES } else { absolute },
            max_evaluations: self.goal.max_evaluations,
        };
        let bounded = if block.is_single() {
            self.exchange(a, b, self.images.shift(block), &request)
        } else {
            self.sum_of_images([a, b], block, &request)
        };
        let omitted = OMITTED_SHARE * absolute / self.images.finite_count();
        if bounded.value + bounded.radius > omitted {
            let (value, radius) = (bounded.value, round_up(bounded.radius));
            self.found.push(PairExchange { i, j, value, radius });
        }
    }

    /// Σ 𝓕 of a facet and the images of another one in a block, between which all occluders are endless along the block.
    fn sum_of_images(
        &mut self,
        facets: [&'a PreparedFacet; 2],
        block: &ImageBlock,
        request: &IntegrationRequest,
    ) -> Bounded {
        let goal = SumGoal { relative: request.relative, absolute: request.absolute };
        let long: Vec<usize> = (0..2).filter(|k| block.first[*k] < block.last[*k]).collect();
        let mut at = block.first;
        long.iter().for_each(|k| at[*k] = 0);
        let base = self.images.shift(&ImageBlock { first: at, last: at });
        let (outer, inner) = (long[0], *long.last().unwrap_or(&long[0]));
        let (step, rows) = (self.images.step(outer), self.images.step(inner));
        let has_rows = outer != inner;
        let polygons = facets.map(PreparedFacet::polygon);
        let rest = RestBound::new(polygons, base, step, has_rows.then(|| rows.length()));
        let (request, total) = (*request, 0.0);
        let mut images = FacetImages { traversal: self, facets, base, step, request, rest, total };
        let [first, last] = [block.first[outer], block.last[outer]];
        if !has_rows {
            return image_sum::sum(first, last, goal, &mut images);
        }
        let range = [block.first[inner], block.last[inner]];
        image_sum::sum(first, last, goal, &mut FacetRows { images, rows, range })
    }

    /// 𝓕 of two facets, the second one displaced, with the occluders of `self.near` between them.
    fn exchange(
        &mut self,
        a: &PreparedFacet,
        b: &PreparedFacet,
        shift: Vec3,
        request: &IntegrationRequest,
    ) -> Bounded {
        let contact = self.geometry.contact;
        let moved;
        let b = if shift == Vec3::ZERO {
            b
        } else {
            moved = b.shifted(shift);
            &moved
        };
        let rises = |p: &ConvexPolygon, q: &ConvexPolygon| q.corners().iter().any(|c| p.height(*c) > contact);
        if !rises(a.polygon(), b.polygon()) || !rises(b.polygon(), a.polygon()) {
            return Bounded::ZERO;
        }
        self.counts.facet_pairs += 1;
        match self.occluders_between(a, b) {
            Obstruction::Nothing => {
                self.counts.unobstructed += 1;
                a.prepared.exchange(&b.prepared, request.relative, request.absolute)
            }
            Obstruction::Everything => {
                self.counts.hidden += 1;
                Bounded::ZERO
            }
            Obstruction::Parts(outer) => {
                self.counts.partial += 1;
                obstructed_exchange(&outer, &mut self.view, request)
            }
        }
    }

    /// False if occluder `k`, displaced by `shift`, is beside the segments between two facets.
    fn may_be_between(&self, k: usize, shift: Vec3, a: &PreparedFacet, b: &PreparedFacet) -> bool {
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
            if !self.may_be_between(k, shift, a, b) {
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
            if self.planes.iter().any(|(n, c)| o.is_beyond(*n, c - contact, shift)) {
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

/// The exchange of a facet with the images of another one along an axis; all occluders between are endless along it.
struct FacetImages<'s, 'a> {
    traversal: &'s mut PairTraversal<'a>,
    facets: [&'a PreparedFacet; 2],
    /// Displacement of the image zero, and of one period.
    base: Vec3,
    step: Vec3,
    request: IntegrationRequest,
    rest: RestBound,
    /// The sum of nearer images, m².
    total: f64,
}

impl ImageFunction for FacetImages<'_, '_> {
    fn value(&mut self, displacement: f64, weight: f64) -> Bounded {
        let [a, b] = self.facets;
        let goal = SumGoal { relative: self.request.relative, absolute: self.request.absolute };
        let absolute = goal.beside(self.total).absolute / (IMAGE_SHARES * weight.max(1.0));
        let is_near = displacement.abs() <= 1.0 + 2.0 * self.scale();
        let most = if is_near { self.request.max_evaluations } else { MAX_FAR_EVALUATIONS };
        let max_evaluations = self.request.max_evaluations.min(most);
        let request = IntegrationRequest { absolute, max_evaluations, ..self.request };
        self.traversal.exchange(a, b, self.base + self.step * displacement, &request)
    }

    fn rest(&self, n: i32) -> f64 {
        self.rest.from(n)
    }

    fn scale(&self) -> f64 {
        self.rest.gap / self.rest.period
    }

    fn set_total(&mut self, total: f64) {
        self.total = total;
    }
}

/// The exchange of a facet with rows of images of another one; all occluders between are endless along both axes.
struct FacetRows<'s, 'a> {
    /// The rows, one for each period.
    images: FacetImages<'s, 'a>,
    /// One period within a row.
    rows: Vec3,
    /// The images of a row.
    range: [i32; 2],
}

impl ImageFunction for FacetRows<'_, '_> {
    fn value(&mut self, displacement: f64, weight: f64) -> Bounded {
        let FacetImages { traversal, facets, base, step, request, .. } = &mut self.images;
        let absolute = request.absolute / (IMAGE_SHARES * weight.max(1.0));
        let request = IntegrationRequest { absolute, ..*request };
        let (facets, base) = (*facets, *base + *step * displacement);
        let rest = RestBound::new(facets.map(PreparedFacet::polygon), base, self.rows, None);
        let goal = SumGoal { relative: request.relative, absolute };
        let mut row = FacetImages { traversal, facets, base, step: self.rows, request, rest, total: 0.0 };
        image_sum::sum(self.range[0], self.range[1], goal, &mut row)
    }

    fn rest(&self, n: i32) -> f64 {
        self.images.rest(n)
    }

    fn scale(&self) -> f64 {
        self.images.scale()
    }

    fn set_total(&mut self, _: f64) {}
}

/// A bound of the exchange with all images from the n-th on: with R the least distance of the n-th image, g its part perpendicular to the axis, x along it,
///
/// ```text
/// Σ 𝓕 ≤ A_a A_b c_a c_b/π Σ_{m≥n} 1/R_m²,      Σ 1/R_m² ≤ 1/R² + min(1/x, π/2g)/P,      c = |normal·axis| + h/R,
/// ```
///
/// where h is the largest height of the one over the plane of the other without the displacement along the axis. For rows of images with period Q, 1/R² becomes 1/R² + π/(Q R);
/// their normals are perpendicular to both axes.
struct RestBound {
    scale: f64,
    /// |normal·axis| and h, m, of both facets.
    slopes: [[f64; 2]; 2],
    period: f64,
    extent: f64,
    gap: f64,
    /// Period within rows, m.
    row_period: Option<f64>,
}

impl RestBound {
    fn new([a, b]: [&ConvexPolygon; 2], base: Vec3, step: Vec3, row_period: Option<f64>) -> RestBound {
        let period = step.length();
        let axis = step / period;
        let differences: Vec<Vec3> =
            a.corners().iter().flat_map(|x| b.corners().iter().map(|y| *y + base - *x)).collect();
        let largest = |f: &dyn Fn(Vec3) -> f64| differences.iter().fold(0.0f64, |s, d| s.max(f(*d)));
        let slopes = [a, b].map(|p| {
            let along = p.normal().dot(axis);
            [along.abs(), largest(&|d| (p.normal().dot(d) - along * axis.dot(d)).abs())]
        });
        // The perpendicular differences of all points lie in the box of those of the corners.
        let box_of = Bounds::of(&differences);
        let apart = |lo: f64, hi: f64| lo.max(-hi).max(0.0);
        let gaps: Vec<f64> = (0..3)
            .filter(|k| axis.array()[*k] == 0.0)
            .map(|k| apart(box_of.lo.array()[k], box_of.hi.array()[k]))
            .collect();
        let gap = gaps.iter().map(|g| g * g).sum::<f64>().sqrt();
        let gap = if row_period.is_some() { 0.0 } else { gap };
        let extent = largest(&|d| axis.dot(d).abs());
        RestBound { scale: a.area() * b.area() / PI, slopes, period, extent, gap, row_period }
    }

    fn from(&self, n: i32) -> f64 {
        let along = f64::from(n) * self.period - self.extent;
        let distance = along.max(0.0).hypot(self.gap);
        if distance <= 0.0 {
            return f64::INFINITY;
        }
        let beyond = if along > 0.0 { 1.0 / along } else { f64::INFINITY };
        let integral = beyond.min(0.5 * PI / self.gap) / self.period;
        // The images before the first one that is beyond the extent are as near as the gap.
        let near = if along > 0.0 { 1.0 } else { 1.0 - along / self.period };
        let cosine = |[along, height]: [f64; 2]| (along + height / distance).min(1.0);
        let cosines = self.scale * cosine(self.slopes[0]) * cosine(self.slopes[1]);
        match self.row_period {
            None => cosines * (near / (distance * distance) + integral),
            // Terms fall as the third power of the distance: their sum is at most the first and half an integral.
            Some(_) if self.slopes.iter().any(|s| s[0] > 1e-9) => f64::INFINITY,
            Some(q) => {
                let row = cosines * (1.0 / (distance * distance) + PI / (q * distance));
                row * (1.0 + 0.5 * distance / self.period)
            }
        }
    }
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
