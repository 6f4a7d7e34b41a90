//! Closure of the rows by the least change of the factors relative to their errors.
//!
//! The rows of a matrix of factors g with radii r, and the loss g_i,out of each zone to the surroundings and to black backs with the standard error r_i,out,
//! should sum to the targets t_i:
//!
//! ```text
//!     Σ_j (g_ij + δ_ij) c_j + g_i,out + δ_i,out = t_i,        Σ_{i≤j} δ_ij²/w_ij + Σ_i δ_i,out²/r_i,out² → min,
//! ```
//!
//! with the weights w_ij = min(r_ij, g_ij)²: a pair behind a wall exchanges nothing afterwards either. The symmetric changes
//! δ_ij = w_ij (λ_i c_j + λ_j c_i), δ_i,out = r_i,out² λ_i solve this, with multipliers λ of the symmetric system
//!
//! ```text
//!     (v_i + r_i,out²) λ_i + c_i Σ_j w_ij c_j λ_j = −d_i,     v_i = Σ_j w_ij c_j²,   d_i: defect of row i.
//! ```
//!
//! Least-squares smoothing of exchange areas (Larsen and Howell 1986), weighted by the errors: factors in closed form stay, sampled ones move. Where all
//! factors of a zone are exact, the whole defect goes to its loss, which then is the target less the others, with the sum of their radii as its error.
//! No factor loses more than half of itself in a round, so that all stay positive, or gains more than some roots of its weight; a few rounds follow each other.
//!
//! Cost: some twenty products of the weights, one byte an entry, and one pass over the factors in each round.

use super::closure::{self, RowClosure};
use crate::distribution::multivector;
use crate::distribution::sum_order::SharedZones;
use crate::operator::AdjustableExchange;
use crate::right_hand_side::surroundings::SurroundingsExchange;
use zonal_exchange::pair::{closure_target, scaled_radiosity_coefficient};
use zonal_math::parallel;
use zonal_scene::{Bands, ClosureDefect, Zones};

/// Rounds of changes, at most.
const MAX_ROUNDS: usize = 8;
/// Iterations of the multipliers of a round, at most, and their residual relative to the defects.
const MAX_ITERATIONS: usize = 80;
const RELATIVE_RESIDUAL: f64 = 1e-7;
/// Relative defect at which a row is closed.
const CLOSED_ROW: f64 = 1e-13;
/// Reduction of the largest defect below which another round does not help.
const MIN_REDUCTION: f64 = 0.9;
/// Standard error of the sum of an exact row, over its target: defects below are rounding and move nothing.
const ROUNDING_OF_ROW: f64 = 1e-12;
/// Relative weight on the diagonal for rows whose defects contradict each other, such as two that see only one another.
const REGULARIZATION: f64 = 1e-7;
/// Error of a row without its loss, over its target, up to which the loss follows from the row alone.
const EXACT_ROW: f64 = 1e-7;
/// Multiple of the error of a loss up to which a defect is attributed to it.
const EXPLAINED_DEVIATION: f64 = 2.0;
/// Negative loss, over the target, that is rounding.
const ROUNDING_OF_LOSS: f64 = 1e-10;

/// Restores the rows whose closure is `measured`, the losses in `surroundings` included, whose errors become those of the changed losses.
///
/// The defect of a zone becomes the relative change of the other factors of its row, plus its residual defect.
pub(crate) fn restore(
    operator: &mut dyn AdjustableExchange,
    zones: SharedZones,
    surroundings: &mut SurroundingsExchange,
    mut measured: RowClosure,
) -> RowClosure {
    let n = zones.len();
    measured.summary.restored = true;
    measured.residuals = Some(Vec::new());
    if surroundings.is_closed() && measured.summary.worst.all(|w| w <= closure::ROUNDING_DEFECT) {
        return measured;
    }
    operator.prepare_weights();
    let rows = RowSystem::new(operator, &zones, surroundings);
    let before: Vec<Bands> = (0..n).map(|i| surroundings.total_of(i)).collect();
    let mut moved = vec![Bands::ZERO; n];
    let mut defects = measured.defects.clone();
    for _ in 0..MAX_ROUNDS {
        let worst = largest(&defects);
        if worst.all(|w| w <= CLOSED_ROW) {
            break;
        }
        let multipliers = rows.multipliers(operator, &defects);
        let sizes: Vec<Bands> = multipliers.iter().map(|m| m.abs()).collect();
        moved.iter_mut().zip(rows.changes(operator, &sizes)).for_each(|(m, c)| *m += c);
        operator.adjust(&multipliers, &rows.coefficients);
        rows.change_losses(surroundings, |i| rows.loss_variance[i] * multipliers[i]);
        defects = closure::measure(operator, zones, surroundings).defects;
        let left = largest(&defects) / worst.max(Bands::splat(CLOSED_ROW));
        if left.all(|ratio| ratio > MIN_REDUCTION) {
            break;
        }
    }
    operator.drop_weights();
    rows.give_rests_to_losses(surroundings, &defects);
    let left = closure::measure(operator, zones, surroundings);
    rows.update_errors(&zones, surroundings, &before);
    let changes: Vec<Bands> = moved.iter().zip(&rows.targets).map(|(m, t)| *m / *t).collect();
    restored(measured, &changes, left)
}

/// The closure with the relative `changes` of the rows and what is `left` of their defects.
fn restored(mut closure: RowClosure, changes: &[Bands], left: RowClosure) -> RowClosure {
    let summary = &mut closure.summary;
    summary.residual_defect = left.summary.worst;
    summary.largest_change = changes.iter().fold(summary.largest_change, |m, c| m.max(*c));
    // What was moved is part of the closed row; only what is left is missing.
    let of_row = |(change, rest): (&Bands, &Bands)| {
        change.zip_map(*rest, |change, rest| match rest.abs() {
            r if r <= closure::ROUNDING_DEFECT => change,
            r => (change + r).copysign(rest),
        })
    };
    closure.defects = changes.iter().zip(&left.defects).map(of_row).collect();
    closure.residuals = Some(left.defects);
    closure
}

/// As [`restore`]; what is left of the defects a symmetric scaling removes, which changes exact factors too: for scenes that request closure.
pub(crate) fn restore_fully(
    operator: &mut dyn AdjustableExchange,
    zones: SharedZones,
    surroundings: &mut SurroundingsExchange,
    measured: RowClosure,
) -> RowClosure {
    let closed = restore(operator, zones, surroundings, measured);
    let left = ClosureDefect { worst: closed.summary.residual_defect, ..closed.summary.clone() };
    let rest = RowClosure { summary: left, defects: Vec::new(), residuals: None };
    let scaled = closure::restore(operator, zones, surroundings, rest);
    if scaled.defects.is_empty() {
        return closed;
    }
    let summary = ClosureDefect {
        largest_change: closed.summary.largest_change + scaled.summary.largest_change,
        residual_defect: scaled.summary.residual_defect,
        ..closed.summary
    };
    let both = |(a, b): (&Bands, &Bands)| (a.abs() + b.abs()).zip_map(*a, f64::copysign);
    let defects = closed.defects.iter().zip(&scaled.defects).map(both).collect();
    RowClosure { summary, defects, residuals: scaled.residuals }
}

/// The errors of the rows without their losses, for a closure that is measured only: they lose or create power in every reflection.
///
/// With the standard errors S of the sum of a row and σ of its loss, the part of a defect d that the row causes is |d| S²/(S² + σ²), with the error
/// S σ/√(S² + σ²); it is no less than the excess of |d| over 2σ.
pub(crate) fn state_row_errors(
    operator: &dyn AdjustableExchange,
    zones: &Zones,
    surroundings: &SurroundingsExchange,
    measured: &mut RowClosure,
) {
    let squares: Vec<Bands> =
        (0..zones.len()).map(|i| scaled_radiosity_coefficient(zones, i).map(|c| c * c)).collect();
    let variance = operator.variance_product(&squares);
    let of_row = |i: usize| {
        let target = closure_target(zones, i);
        let (row, loss) = (variance[i].sqrt() / target, surroundings.loss_error(i, target) / target);
        Bands::from_fn(|b| {
            let (d, s, loss) = (measured.defects[i][b], row[b], loss[b]);
            let excess = (d.abs() - EXPLAINED_DEVIATION * loss).max(0.0);
            let both = s.hypot(loss);
            let caused = if s > 0.0 { (d.abs() * s / both + loss) * s / both } else { 0.0 };
            caused.max(excess).copysign(d)
        })
    };
    measured.residuals = Some(parallel::collect(zones.len(), of_row));
}

fn largest(defects: &[Bands]) -> Bands {
    defects.iter().fold(Bands::ZERO, |w, d| w.max(d.abs()))
}

/// True if the variance of the sum of a row without its loss is negligible beside its target `t`.
fn is_exact(variance: f64, t: f64) -> bool {
    variance.sqrt() <= EXACT_ROW * t
}

/// The system of the multipliers.
struct RowSystem {
    /// t, m² or m³.
    targets: Vec<f64>,
    /// c, 1 or 1/m.
    coefficients: Vec<Bands>,
    /// Σ_j r_ij² c_j²: the variance of the sum of a row without its loss.
    variance: Vec<Bands>,
    /// v.
    weights: Vec<Bands>,
    /// r_out²; 0 for a zone that loses nothing.
    loss_variance: Vec<Bands>,
    /// v + r_out² of the system, with the rounding of a row.
    diagonal: Vec<Bands>,
}

impl RowSystem {
    fn new(
        operator: &dyn AdjustableExchange,
        zones: &Zones,
        surroundings: &SurroundingsExchange,
    ) -> RowSystem {
        let n = zones.len();
        let coefficients: Vec<Bands> = (0..n).map(|i| scaled_radiosity_coefficient(zones, i)).collect();
        let targets: Vec<f64> = (0..n).map(|i| closure_target(zones, i)).collect();
        let squares: Vec<Bands> = coefficients.iter().map(|c| c * c).collect();
        let variance = operator.variance_product(&squares);
        let loss_variance: Vec<Bands> = (0..n)
            .map(|i| {
                let (t, total) = (targets[i], surroundings.total_of(i));
                let sampled = surroundings.loss_error(i, t).map(|e| e * e);
                let open = !surroundings.is_closed();
                Bands::from_fn(|b| {
                    if open && is_exact(variance[i][b], t) {
                        // The row alone gives the loss.
                        t * t
                    } else if total[b] > 0.0 {
                        sampled[b]
                    } else {
                        // Samples of other factors say nothing about a loss that no ray found.
                        0.0
                    }
                })
            })
            .collect();
        let weights = operator.weight_product(&squares);
        let diagonal =
            (0..n).map(|i| weights[i] + loss_variance[i] + (ROUNDING_OF_ROW * targets[i]).powi(2)).collect();
        RowSystem { targets, coefficients, variance, weights, loss_variance, diagonal }
    }

    /// c_i Σ_j w_ij c_j x_j.
    fn coupling(&self, operator: &dyn AdjustableExchange, x: &[Bands]) -> Vec<Bands> {
        multivector::times(
            &self.coefficients,
            &operator.weight_product(&multivector::times(&self.coefficients, x)),
        )
    }

    /// Σ_j w_ij (x_i c_j + x_j c_i) c_j: the change of each row without its loss by multipliers x, m² or m³.
    fn changes(&self, operator: &dyn AdjustableExchange, x: &[Bands]) -> Vec<Bands> {
        let others = self.coupling(operator, x);
        others.iter().zip(x).zip(&self.weights).map(|((o, x), v)| *o + *v * *x).collect()
    }

    /// The multipliers for relative defects of the rows: conjugate gradients, preconditioned by the diagonal.
    fn multipliers(&self, operator: &dyn AdjustableExchange, defects: &[Bands]) -> Vec<Bands> {
        let n = defects.len();
        let root: Vec<Bands> = self.diagonal.iter().map(|d| d.map(|d| 1.0 / d.sqrt())).collect();
        let product = |y: &[Bands]| -> Vec<Bands> {
            let scaled = multivector::times(&root, y);
            let others = self.coupling(operator, &scaled);
            parallel::collect(n, |i| root[i] * others[i] + (1.0 + REGULARIZATION) * y[i])
        };
        let dot = |a: &[Bands], b: &[Bands]| multivector::sum(n, |i| a[i] * b[i]);
        let mut y = vec![Bands::ZERO; n];
        let mut r: Vec<Bands> = (0..n).map(|i| root[i] * defects[i] * (-self.targets[i])).collect();
        let (mut p, mut rr) = (r.clone(), dot(&r, &r));
        let end = rr * (RELATIVE_RESIDUAL * RELATIVE_RESIDUAL);
        let ratio = |a: Bands, b: Bands| a.zip_map(b, |a, b| if b > 0.0 { a / b } else { 0.0 });
        for _ in 0..MAX_ITERATIONS {
            if (rr - end).all(|excess| excess <= 0.0) {
                break;
            }
            let q = product(&p);
            let step = ratio(rr, dot(&p, &q));
            for i in 0..n {
                y[i] += step * p[i];
                r[i] -= step * q[i];
            }
            let next = dot(&r, &r);
            let turn = ratio(next, rr);
            p.iter_mut().zip(&r).for_each(|(p, r)| *p = *r + turn * *p);
            rr = next;
        }
        multivector::times(&root, &y)
    }

    /// Adds `change` to the loss of every zone, which does not become negative.
    fn change_losses(&self, surroundings: &mut SurroundingsExchange, change: impl Fn(usize) -> Bands) {
        if surroundings.is_closed() {
            return;
        }
        for i in 0..self.targets.len() {
            let least = -ROUNDING_OF_LOSS * self.targets[i];
            let total = surroundings.total_of(i) + change(i);
            surroundings.set_loss(i, total.map(|x| if x < least { 0.0 } else { x }));
        }
    }

    /// Gives what is left of the defects to the losses, where that is within their errors, or rounding.
    fn give_rests_to_losses(&self, surroundings: &mut SurroundingsExchange, defects: &[Bands]) {
        self.change_losses(surroundings, |i| {
            let rest = defects[i] * -self.targets[i];
            let rounding = closure::ROUNDING_DEFECT * self.targets[i];
            rest.zip_map(
                self.loss_variance[i],
                |rest, v| {
                    if rest.abs() < v.sqrt().max(rounding) { rest } else { 0.0 }
                },
            )
        });
    }

    /// The errors of the changed losses: that of the rays where the rest of the row is uncertain, else that of the rest of the row, whose errors may have
    /// one sign. Rays still divide a loss between the surroundings and black backs.
    fn update_errors(&self, zones: &Zones, surroundings: &mut SurroundingsExchange, before: &[Bands]) {
        if surroundings.is_closed() {
            return;
        }
        let count = (zones.len() as f64).sqrt();
        let error = |i: usize| {
            let (t, backs) = (self.targets[i], surroundings.backfaces_of(i));
            let (sampled, change) =
                (surroundings.loss_error(i, t), (surroundings.total_of(i) - before[i]).abs());
            Bands::from_fn(|b| {
                let v = self.variance[i][b];
                let rest = v.sqrt() * count + ROUNDING_OF_ROW * t;
                if backs[b] > 0.0 {
                    sampled[b]
                } else if is_exact(v, t) {
                    rest
                } else {
                    (sampled[b].max(change[b]) * rest / rest.hypot(sampled[b])).min(sampled[b])
                }
            })
        };
        surroundings.error = (0..zones.len()).map(error).collect();
    }
}
