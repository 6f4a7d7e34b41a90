//! The error of a value by its difference in two solves, with a margin for what the second solve itself errs by.
//!
//! The second solve ends at a looser residual, and has less accurate factors, than the first one. With r the residual (the undistributed over the emitted
//! power) and τ the relative error of the factors, a power errs by (r + τ) P at most, P the emitted and incoming power of all zones. A
//! temperature errs by a quarter of the relative error of its emission; r + τ of it are added. Where rows are not restored, the imbalance of heat is added to each power.

use crate::settings::COMPARISON_TOLERANCE;
use zonal_scene::{Band, Report, SolveStatus};

/// Relative differences below which two numbers differ by rounding.
const ROUNDING: f64 = 1e-12;

/// Errors of the values of a second solve, without that of its zones.
#[derive(Clone, Copy, Debug)]
pub(super) struct SecondSolveMargin {
    /// Of a power, W.
    power: f64,
    /// Of a temperature, over it.
    temperature: f64,
}

impl SecondSolveMargin {
    /// Of a solve with the reports of all blocks of bands, which temperatures couple.
    pub(super) fn of(reports: &[Report]) -> SecondSolveMargin {
        let relative = COMPARISON_TOLERANCE + reports.iter().map(undistributed_fraction).fold(0.0, f64::max);
        let exchanged = |r: &Report| (r.energy.emitted + r.energy.incoming).abs().sum();
        let power = relative * reports.iter().map(exchanged).sum::<f64>();
        // Rows that are not restored create or lose power. The first block has the table of heat.
        let imbalance = match reports.first().and_then(|r| r.heat.as_ref()) {
            Some(heat) if !reports.iter().all(|r| r.closure.restored) => heat.balance().abs(),
            _ => 0.0,
        };
        SecondSolveMargin { power: power + imbalance, temperature: relative }
    }

    /// Of the difference of the values of two solves.
    pub(super) fn plus(self, other: SecondSolveMargin) -> SecondSolveMargin {
        SecondSolveMargin {
            power: self.power + other.power,
            temperature: self.temperature + other.temperature,
        }
    }
}

/// Errors from the differences of two solves; 0 where a difference is rounding.
pub(super) struct DifferenceError {
    /// The error over the difference.
    pub factor: f64,
    pub margin: SecondSolveMargin,
}

/// The largest residual of a solve; a fixed number of orders has none.
fn undistributed_fraction(report: &Report) -> f64 {
    let of_band = |b: Band| match report.status[b] {
        SolveStatus::FixedOrder => 0.0,
        _ => report.residuals[b].last().copied().unwrap_or(0.0),
    };
    Band::all().map(of_band).fold(0.0, f64::max)
}

impl DifferenceError {
    /// Of temperatures a and b, K.
    pub(super) fn of_temperatures(&self, a: f64, b: f64) -> f64 {
        self.with_margin(difference(a, b), self.margin.temperature * a.abs())
    }

    /// Of powers a and b, W.
    pub(super) fn of_powers(&self, a: f64, b: f64) -> f64 {
        self.with_margin(difference(a, b), self.margin.power)
    }

    fn with_margin(&self, difference: f64, margin: f64) -> f64 {
        if difference == 0.0 { 0.0 } else { (difference + margin) * self.factor }
    }
}

/// |a − b|, or 0 if that is rounding.
fn difference(a: f64, b: f64) -> f64 {
    let d = (a - b).abs();
    if d > ROUNDING * a.abs().max(b.abs()) { d } else { 0.0 }
}
