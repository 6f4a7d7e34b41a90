//! Division of a mesh into blocks, each developed about one reference.

use super::development::KernelSeries;
use super::error_constants::{POINT_ROUNDINGS, RADIUS_SLACK};
use super::mesh::{CellFactor, MeshFactors, ParametricMesh};
use super::plate_geometry::{coordinate_scale, edge_skew};
use super::power_series::MAX_ORDER;
use super::reference::{Reference, remainder};
use super::surface::SmoothSurface;
use super::visibility::{HORIZON_DEPTH, Visibility, cell_visibility};
use crate::rounding::UNIT_ROUNDOFF;
use std::f64::consts::PI;
use std::ops::Range;
use zonal_exchange::{AccuracyRequest, Factor, Method};
use zonal_math::Bounded;
use zonal_scene::Plate;

/// 𝓕 of `plate` and every cell of the mesh of `surface`, m², by developments of total degree `order`.
///
/// # Panics
/// On an order of zero or above [`MAX_ORDER`].
pub fn mesh_factors(
    surface: &SmoothSurface,
    mesh: &ParametricMesh,
    plate: &Plate,
    order: usize,
    demand: &AccuracyRequest,
) -> MeshFactors {
    assert!((1..=MAX_ORDER).contains(&order), "order {order}");
    let [n, m] = mesh.cells();
    let row = MeshFactors { cells: vec![CellFactor::Near; n * m], references: 0, evaluations: 0 };
    let largest = |e: &[f64]| e[0].abs().max(e[e.len() - 1].abs());
    let shake = edge_skew(plate)
        * POINT_ROUNDINGS
        * UNIT_ROUNDOFF
        * (surface.magnitude(largest(&mesh.u), largest(&mesh.v)) + coordinate_scale(plate));
    let mut development = MeshDevelopment { surface, mesh, plate, order, demand, shake, row };
    development.classify(0..n, 0..m);
    development.develop_block(0..n, 0..m);
    development.row
}

struct MeshDevelopment<'a> {
    surface: &'a SmoothSurface,
    mesh: &'a ParametricMesh,
    plate: &'a Plate,
    order: usize,
    demand: &'a AccuracyRequest,
    /// Error of a point by rounding, m.
    shake: f64,
    row: MeshFactors,
}

impl MeshDevelopment<'_> {
    fn index(&self, j: usize, k: usize) -> usize {
        j * self.mesh.cells()[1] + k
    }

    /// Classifies the cells of a block by visibility, all at once where possible.
    fn classify(&mut self, js: Range<usize>, ks: Range<usize>) {
        let cell = js.len() * ks.len() == 1;
        let depth = if cell { 0 } else { HORIZON_DEPTH };
        let open = Factor { bounded: Bounded::ZERO, evaluations: 0, method: Method::Proximity };
        let word =
            match cell_visibility(self.surface, self.mesh.part(&js, &ks), self.plate, self.shake, depth) {
                Visibility::Whole => CellFactor::Factor(open),
                Visibility::Nothing => CellFactor::Factor(Factor::NOT_VISIBLE),
                Visibility::Part if cell => CellFactor::PartlyVisible,
                Visibility::Part => {
                    let middle = |r: &Range<usize>| (r.start + r.end) / 2;
                    if js.len() >= ks.len() {
                        let at = middle(&js);
                        self.classify(js.start..at, ks.clone());
                        self.classify(at..js.end, ks);
                    } else {
                        let at = middle(&ks);
                        self.classify(js.clone(), ks.start..at);
                        self.classify(js, at..ks.end);
                    }
                    return;
                }
            };
        for j in js {
            for k in ks.clone() {
                self.set(j, k, word);
            }
        }
    }

    /// Cells of a block without a value.
    fn unset_cells(&self, js: &Range<usize>, ks: &Range<usize>) -> Vec<(usize, usize)> {
        let all = js.clone().flat_map(|j| ks.clone().map(move |k| (j, k)));
        let open = |c: &CellFactor| matches!(c, CellFactor::Factor(f) if f.method == Method::Proximity);
        all.filter(|(j, k)| open(&self.row.cells[self.index(*j, *k)])).collect()
    }

    fn develop_block(&mut self, js: Range<usize>, ks: Range<usize>) {
        let cells = self.unset_cells(&js, &ks);
        if cells.is_empty() {
            return;
        }
        let reference = Reference::new(self.surface, self.plate, self.mesh.part(&js, &ks), self.shake);
        let done = self.develop(&reference, &cells);
        if done || js.len() * ks.len() == 1 {
            return;
        }
        // The longer extent is halved.
        let reach = |r: [f64; 2]| reference.local.majorant(r).displacement;
        let along = reach([reference.half[0], 0.0]) >= reach([0.0, reference.half[1]]);
        if js.len() > 1 && (along || ks.len() == 1) {
            let middle = (js.start + js.end) / 2;
            self.develop_block(js.start..middle, ks.clone());
            self.develop_block(middle..js.end, ks);
        } else {
            let middle = (ks.start + ks.end) / 2;
            self.develop_block(js.clone(), ks.start..middle);
            self.develop_block(js, middle..ks.end);
        }
    }

    /// Develops about a reference and sets the cells; false, with nothing set, if a cell fails and smaller blocks may succeed.
    fn develop(&mut self, r: &Reference, cells: &[(usize, usize)]) -> bool {
        let single = cells.len() == 1;
        let typical = self.kernel_at_centre(r);
        let discs = r.discs();
        let truncation = |tau: f64| remainder(&discs, tau, self.order);
        let wanted = 0.25 * self.demand.tolerance * typical;
        let m = r.local.majorant(r.half);
        if discs.is_empty() || m.displacement >= r.near || (!single && exceeds(truncation(1.0), wanted)) {
            if single {
                cells.iter().for_each(|(j, k)| self.set(*j, *k, CellFactor::Near));
            }
            return false;
        }
        let (points, quadrature) = r.points(self.plate, &m, wanted);
        let quadrature = quadrature + r.clamp(&m, self.shake);
        if self.row.evaluations >= self.demand.max_evaluations {
            cells.iter().for_each(|(j, k)| self.set(*j, *k, CellFactor::Near));
            return true;
        }
        let sum = KernelSeries::new(r, self.surface, self.plate, self.order, points);
        self.row.evaluations += (points * points) as u64;
        let share = (points * points).div_ceil(cells.len()) as u64;
        let area = self.plate.area();
        let mut done = Vec::with_capacity(cells.len());
        for (j, k) in cells {
            let patch = self.mesh.patch(*j, *k);
            let (value, rounding, tau, size) = sum.over(r, patch);
            let radius = area * RADIUS_SLACK * (size * (truncation(tau) + quadrature) + rounding);
            let bounded = Bounded::proved(
                value * area,
                radius + POINT_ROUNDINGS * UNIT_ROUNDOFF * edge_skew(self.plate) * (value * area).abs(),
            );
            if !single && exceeds(bounded.radius, self.demand.radius(bounded.value)) {
                return false;
            }
            done.push(Factor { bounded, evaluations: share, method: Method::Proximity });
        }
        for ((j, k), f) in cells.iter().zip(done) {
            let good = f.bounded.radius <= f.bounded.value;
            self.set(*j, *k, if good { CellFactor::Factor(f) } else { CellFactor::Near });
        }
        self.row.references += 1;
        true
    }

    fn set(&mut self, j: usize, k: usize, cell: CellFactor) {
        let at = self.index(j, k);
        self.row.cells[at] = cell;
    }

    /// K at the reference and B's centre: the scale of the bounds before a value is known.
    fn kernel_at_centre(&self, r: &Reference) -> f64 {
        let d = r.s - self.plate.centre();
        self.plate.normal().dot(d).max(0.0) * (-r.normal.dot(d)).max(0.0) / (PI * d.length2().powi(2))
    }
}

/// True unless `x` is a number not above `limit`.
fn exceeds(x: f64, limit: f64) -> bool {
    x.partial_cmp(&limit).is_none_or(|o| o.is_gt())
}
