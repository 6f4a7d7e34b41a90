//! The linear system s = s⁰ + w g s of the zonal equations, its stopping criterion, and the result of one right-hand side.

use crate::distribution::sum_order::SumOrder;
use crate::operator::ExchangeOperator;
use std::borrow::Cow;
use zonal_scene::{Bands, PerBand, SolveStatus};

/// The equations without their sources.
#[derive(Clone)]
pub(crate) struct LinearSystem<'a> {
    /// g.
    pub operator: &'a dyn ExchangeOperator,
    /// w of every unknown: c ρ/A of a patch, c Ω/(4V) of a volume zone.
    pub weights: Cow<'a, [Bands]>,
    /// t of every unknown: A of a patch (m²), 4V of a volume zone (m³).
    pub targets: &'a [f64],
    /// Order of sums over the unknowns.
    pub sums: SumOrder<'a>,
}

/// When an iteration ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StoppingCriterion {
    /// Largest relative residual R/P.
    pub residual: f64,
    /// Maximum number of iterations.
    pub max_iterations: usize,
}

/// Result of the iteration for one right-hand side.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct IterationResult {
    /// Strengths of all unknowns.
    pub strengths: Vec<Bands>,
    /// Status of each band.
    pub status: PerBand<SolveStatus>,
    /// R/P before the first and after each iteration, for each band.
    pub residuals: PerBand<Vec<f64>>,
    /// P, W per band.
    pub power: Bands,
}

/// P = Σ t |s⁰|, W per band.
pub(crate) fn source_power(targets: &[f64], source: &[Bands], sums: SumOrder) -> Bands {
    sums.sum(source.len(), |i| source[i].map(|s| targets[i] * s.abs()))
}
