//! Closure of the rows: Σ_j g_ij c_j + g_i,sky + g_i,backs = A_i (patch), 4V_i (voxel), 4 A t (pane).
//!
//! **Restoration** of the dense engine is that of [`super::least_squares_closure`]: it knows the error of each factor. Engines with tables find d with Σ_j d_i g_ij d_j c_j + d_i (g_i,sky + g_i,backs) = target, a symmetric scaling: reciprocity stays exact, and
//! the factors of the surroundings are scaled with those of the zones. Method: the damped Sinkhorn–Knopp iteration d ← d √(target/row).
//! Rows without any exchange are left unchanged. Cost: one product an iteration.

use crate::distribution::multivector;
use crate::distribution::sum_order::{SharedZones, SumOrder};
use crate::operator::{ExchangeOperator, extend_to_slopes};
use crate::right_hand_side::surroundings::SurroundingsExchange;
use zonal_exchange::pair::{closure_target, scaled_radiosity_coefficient};
use zonal_math::parallel;
use zonal_scene::{Band, Bands, ClosureDefect, Zones};

/// Relative defect below which rows close to rounding and are not restored.
pub(super) const ROUNDING_DEFECT: f64 = 1e-11;
/// Maximum number of iterations of the restoration.
const MAX_SCALING_ITERATIONS: usize = 400;
/// Relative defect at which the restoration has converged.
const CONVERGED_DEFECT: f64 = 1e-13;
/// Row sum, over its target, at and below which a row has no exchange.
const EMPTY_ROW: f64 = 1e-12;

/// Closure of all rows of an operator.
pub(crate) struct RowClosure {
    /// Summary for the report.
    pub summary: ClosureDefect,
    /// Relative defect of every zone before restoration. After restoration: the relative change of its row, plus its residual defect; negative if
    /// the row falls short of its target.
    pub defects: Vec<Bands>,
    /// Relative error of the sum of every row that reflections amplify: the defect after restoration, or the part of a measured defect that the row
    /// causes; `None` where the unexplained part of `defects` counts.
    pub residuals: Option<Vec<Bands>>,
}

impl RowClosure {
    /// Rows without a measurement.
    pub(crate) fn unmeasured(zones: &Zones) -> RowClosure {
        RowClosure {
            summary: ClosureDefect::default(),
            defects: vec![Bands::ZERO; zones.len()],
            residuals: None,
        }
    }
}

/// The incident power of all zones in a uniform field, without that from the surroundings.
fn uniform_rows(operator: &dyn ExchangeOperator, zones: &Zones) -> Vec<Bands> {
    let c: Vec<Bands> = parallel::collect(zones.len(), |i| scaled_radiosity_coefficient(zones, i));
    operator.apply(&c)
}

/// Relative defects (row − target)/target of all zones, from the incident power `rows` in a uniform field.
fn row_defects(mut rows: Vec<Bands>, zones: &Zones, surroundings: &SurroundingsExchange) -> Vec<Bands> {
    parallel::for_each(&mut rows, |i, row| {
        let (t, sky, backs) =
            (closure_target(zones, i), surroundings.sky_of(i), surroundings.backfaces_of(i));
        *row = (*row + sky + backs - t) / t;
    });
    rows
}

fn max_abs(d: &[Bands], order: SumOrder) -> Bands {
    let own = parallel::reduce(d.len(), Bands::ZERO, |i| d[i].abs(), Bands::max);
    order.over_processes(own, Bands::max)
}

fn root_mean_square(d: &[Bands], zones: SharedZones) -> Bands {
    let n = zones.total().max(1) as f64;
    let mean: Bands = zones.sum(|i| d[i] * d[i] / n);
    mean.sqrt()
}

/// Measures the closure of an operator without changing it.
pub(crate) fn measure(
    operator: &dyn ExchangeOperator,
    zones: SharedZones,
    surroundings: &SurroundingsExchange,
) -> RowClosure {
    measure_rows(uniform_rows(operator, &zones), zones, surroundings)
}

/// The closure of an operator whose incident power in a uniform field is `rows`.
pub(crate) fn measure_rows(
    rows: Vec<Bands>,
    zones: SharedZones,
    surroundings: &SurroundingsExchange,
) -> RowClosure {
    let defects = row_defects(rows, &zones, surroundings);
    let worst = max_abs(&defects, zones.order());
    let summary = ClosureDefect {
        worst,
        rms: root_mean_square(&defects, zones),
        residual_defect: worst,
        ..ClosureDefect::default()
    };
    RowClosure { summary, defects, residuals: None }
}

/// Restores closure by symmetric scaling of all factors, those of the surroundings included; `closure` is that before it.
///
/// The defect of a zone becomes the relative change of its row in a uniform field, |d_i − 1| + Σ_j g_ij c_j |d_j − 1| / target, plus its
/// residual defect: the scaling changes correct factors too in order to compensate the wrong ones.
pub(crate) fn restore(
    operator: &mut dyn ExchangeOperator,
    zones: SharedZones,
    surroundings: &mut SurroundingsExchange,
    mut closure: RowClosure,
) -> RowClosure {
    let n = zones.len();
    if closure.summary.worst.all(|w| w <= ROUNDING_DEFECT) {
        closure.summary.restored = true;
        closure.residuals = Some(Vec::new());
        return closure;
    }
    let c: Vec<Bands> = (0..n).map(|i| scaled_radiosity_coefficient(&zones, i)).collect();
    let d = symmetric_scaling(operator, zones, surroundings, &c);
    let summary = &mut closure.summary;
    summary.largest_change = zones.order().over_processes(largest_change(&d), Bands::max);
    // Apply the scaling.
    let off: Vec<Bands> = d.iter().map(|d| (*d - 1.0).abs()).collect();
    let others = operator.apply(&multivector::times(&c, &off));
    let mut all = d.clone();
    extend_to_slopes(&mut all, &operator.slope_zones());
    surroundings.scale(&all);
    operator.scale(&d);
    // Measure the residual defects.
    let left = row_defects(uniform_rows(operator, &zones), &zones, surroundings);
    summary.residual_defect = max_abs(&left, zones.order());
    summary.restored = true;
    let sum = |i: usize, b: Band| {
        let change = off[i][b] + others[i][b] / closure_target(&zones, i);
        if left[i][b].abs() <= ROUNDING_DEFECT {
            change
        } else {
            (change + left[i][b].abs()).copysign(left[i][b])
        }
    };
    closure.defects = (0..n).map(|i| Bands::from_fn(|b| sum(i, b))).collect();
    closure.residuals = Some(left);
    closure
}

/// The scaling d of the damped Sinkhorn–Knopp iteration.
fn symmetric_scaling(
    operator: &dyn ExchangeOperator,
    zones: SharedZones,
    surroundings: &SurroundingsExchange,
    c: &[Bands],
) -> Vec<Bands> {
    let n = zones.len();
    let mut d = vec![Bands::ONE; n];
    for _ in 0..MAX_SCALING_ITERATIONS {
        let dc: Vec<Bands> = (0..n).map(|i| d[i] * c[i]).collect();
        let rows = operator.apply(&dc);
        let mut off: f64 = 0.0;
        for i in 0..n {
            let t = closure_target(&zones, i);
            for b in Band::all() {
                let row =
                    d[i][b] * (rows[i][b] + surroundings.sky_of(i)[b] + surroundings.backfaces_of(i)[b]);
                if row > EMPTY_ROW * t {
                    off = off.max((row / t - 1.0).abs());
                    d[i][b] *= (t / row).sqrt();
                }
            }
        }
        if zones.order().over_processes(off, f64::max) < CONVERGED_DEFECT {
            break;
        }
    }
    d
}

/// Largest relative change of a factor, d_i d_j − 1.
fn largest_change(d: &[Bands]) -> Bands {
    let low = d.iter().fold(Bands::ONE, |m, d| m.min(*d));
    let high = d.iter().fold(Bands::ONE, |m, d| m.max(*d));
    (high * high - 1.0).max(1.0 - low * low)
}
