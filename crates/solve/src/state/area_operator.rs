//! Exchange areas of all pairs as an operator on strengths s = c B, for measurement and restoration of closure.
//!
//! g_ij = F_ij/(c_i c_j), hence P_i = (1/c_i) Σ_j F_ij s_j/c_j; zones with c = 0 exchange nothing.

use super::cholesky::dot;
use crate::exchange_areas::ExchangeAreas;
use crate::operator::ExchangeOperator;
use rayon::prelude::*;
use zonal_exchange::pair::scaled_radiosity_coefficient;
use zonal_scene::{Band, Bands};

/// Direct exchange areas with a symmetric scaling.
pub(super) struct AreaOperator<'a> {
    areas: &'a ExchangeAreas,
    /// c of every zone, 1 or κ.
    coefficients: Vec<Bands>,
    /// d of every zone.
    pub(super) scaling: Vec<Bands>,
}

impl<'a> AreaOperator<'a> {
    pub(super) fn new(areas: &'a ExchangeAreas) -> AreaOperator<'a> {
        let n = areas.zone_count();
        let coefficients = (0..n).map(|i| scaled_radiosity_coefficient(&areas.zones, i)).collect();
        AreaOperator { areas, coefficients, scaling: vec![Bands::ONE; n] }
    }
}

/// x/c, 0 for a zone without exchange.
fn over(x: f64, c: f64) -> f64 {
    if c > 0.0 { x / c } else { 0.0 }
}

impl ExchangeOperator for AreaOperator<'_> {
    fn len(&self) -> usize {
        self.coefficients.len()
    }

    fn apply(&self, strengths: &[Bands]) -> Vec<Bands> {
        let n = self.len();
        let mut out = vec![Bands::ZERO; n];
        for (k, b) in Band::all().enumerate() {
            let matrix = &self.areas.direct.areas[k.min(self.areas.matrices - 1) * n * n..][..n * n];
            let x: Vec<f64> =
                (0..n).map(|j| self.scaling[j][b] * over(strengths[j][b], self.coefficients[j][b])).collect();
            out.par_iter_mut().zip(matrix.par_chunks(n)).enumerate().for_each(|(i, (p, row))| {
                p[b] = self.scaling[i][b] * over(dot(row, &x), self.coefficients[i][b]);
            });
        }
        out
    }

    fn scale(&mut self, d: &[Bands]) {
        self.scaling.iter_mut().zip(d).for_each(|(s, d)| *s *= d);
    }
}
