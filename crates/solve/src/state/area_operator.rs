//! Exchange areas of all pairs in one triple of bands as an operator on strengths s = c B, for closure and for the light of emitters.
//!
//! g_ij = F_ij/(c_i c_j), hence P_i = (1/c_i) Σ_j F_ij s_j/c_j; zones with c = 0 exchange nothing. With the radii δF of independent errors,
//! δP_i = (1/c_i) √(Σ_j (δF_ij s_j/c_j)²).

use super::cholesky::{dot, dot_of_squares};
use crate::exchange_areas::ExchangeAreas;
use crate::operator::{ErrorModel, ExchangeOperator};
use rayon::prelude::*;
use zonal_exchange::pair::scaled_radiosity_coefficient;
use zonal_math::Grade;
use zonal_scene::{Band, Bands, Zones};

/// Direct exchange areas with a symmetric scaling.
pub(super) struct AreaOperator<'a> {
    areas: &'a ExchangeAreas,
    /// Number of bands before the triple.
    first_band: usize,
    /// c of every zone, 1 or κ.
    coefficients: Vec<Bands>,
    /// d of every zone.
    pub(super) scaling: Vec<Bands>,
}

impl<'a> AreaOperator<'a> {
    /// Of triple number `triple`, whose zones are `zones`.
    pub(super) fn new(areas: &'a ExchangeAreas, zones: &Zones, triple: usize) -> AreaOperator<'a> {
        let n = zones.len();
        let coefficients = (0..n).map(|i| scaled_radiosity_coefficient(zones, i)).collect();
        let first_band = triple * Band::count();
        AreaOperator { areas, first_band, coefficients, scaling: vec![Bands::ONE; n] }
    }

    /// The matrix of a band of the triple out of those of all bands.
    fn matrix<'b>(&self, matrices: &'b [f64], band: Band) -> &'b [f64] {
        let n = self.len();
        let index = (self.first_band + band.index()).min(self.areas.matrices - 1);
        &matrices[index * n * n..][..n * n]
    }

    /// Σ_j of the products of the rows of a matrix with d s/c in each band, times d/c.
    fn products(
        &self,
        matrices: &[f64],
        strengths: &[Bands],
        row_product: fn(&[f64], &[f64]) -> f64,
    ) -> Vec<Bands> {
        let n = self.len();
        let mut out = vec![Bands::ZERO; n];
        for b in Band::all() {
            let matrix = self.matrix(matrices, b);
            let x: Vec<f64> =
                (0..n).map(|j| self.scaling[j][b] * over(strengths[j][b], self.coefficients[j][b])).collect();
            out.par_iter_mut().zip(matrix.par_chunks(n)).enumerate().for_each(|(i, (p, row))| {
                p[b] = self.scaling[i][b] * over(row_product(row, &x), self.coefficients[i][b]);
            });
        }
        out
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
        self.products(&self.areas.direct.areas, strengths, dot)
    }

    fn scale(&mut self, d: &[Bands]) {
        self.scaling.iter_mut().zip(d).for_each(|(s, d)| *s *= d);
    }
}

impl ErrorModel for AreaOperator<'_> {
    fn error(&self, strengths: &[Bands]) -> Option<Vec<Bands>> {
        let norm = |row: &[f64], x: &[f64]| dot_of_squares(row, x).sqrt();
        Some(self.products(&self.areas.direct.radii, strengths, norm))
    }

    fn grade(&self) -> Grade {
        self.areas.grade()
    }
}
