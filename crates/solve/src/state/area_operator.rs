//! Exchange areas of all pairs in one block of bands as an operator on strengths s = c B, for closure and for the light of emitters.
//!
//! g_ij = F_ij/(c_i c_j), hence P_i = (1/c_i) Σ_j F_ij s_j/c_j; zones with c = 0 exchange nothing. With the radii δF of independent errors,
//! δP_i = (1/c_i) √(Σ_j (δF_ij s_j/c_j)²).
//!
//! Closure is restored as by the dense engine, with radii in the same precision.

use super::cholesky::{dot, dot_of_squares};
use crate::areas::exchange_areas::ExchangeAreas;
use crate::engines::dense::pair_radii::{radius_code, squared_radii};
use crate::operator::{AdjustableExchange, ErrorModel, ExchangeOperator, adjusted_factor};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::OnceLock;
use zonal_exchange::pair::scaled_radiosity_coefficient;
use zonal_math::Grade;
use zonal_math::parallel;
use zonal_scene::{Band, Bands, Zones};

/// Direct exchange areas with a symmetric scaling.
pub(super) struct AreaOperator<'a> {
    areas: &'a ExchangeAreas,
    /// Number of bands before the block.
    first_band: usize,
    /// c of every zone, 1 or κ.
    coefficients: Vec<Bands>,
    /// d of every zone.
    pub(super) scaling: Vec<Bands>,
    /// The matrices of the block after a restoration of closure.
    pub(super) adjusted: Option<Vec<f64>>,
    /// Codes of the radii δF_ij/(c_i c_j), row by row, where an adjustment needed them.
    codes: OnceLock<Vec<u8>>,
    /// Codes of the roots of the weights of an adjustment, while there is one.
    weights: Option<Vec<u8>>,
}

impl<'a> AreaOperator<'a> {
    /// Of block number `block`, whose zones are `zones`.
    pub(super) fn new(areas: &'a ExchangeAreas, zones: &Zones, block: usize) -> AreaOperator<'a> {
        let n = zones.len();
        let coefficients = (0..n).map(|i| scaled_radiosity_coefficient(zones, i)).collect();
        let first_band = block * Band::count();
        AreaOperator {
            areas,
            first_band,
            coefficients,
            scaling: vec![Bands::ONE; n],
            adjusted: None,
            codes: OnceLock::new(),
            weights: None,
        }
    }

    /// The matrix of a band out of those of the block.
    fn matrix<'b>(&self, matrices: &'b [f64], band: Band) -> &'b [f64] {
        let n = self.len();
        let index = band.index().min(self.matrices().len() - 1);
        &matrices[index * n * n..][..n * n]
    }

    /// The numbers of the matrices of the block among those of all bands.
    pub(super) fn matrices(&self) -> Range<usize> {
        let first = self.first_band.min(self.areas.matrices - 1);
        first..(self.first_band + Band::count()).min(self.areas.matrices).max(first + 1)
    }

    /// The entries of the matrices of the block among those of all bands.
    pub(super) fn entries(&self) -> Range<usize> {
        let (matrices, n) = (self.matrices(), self.len());
        matrices.start * n * n..matrices.end * n * n
    }

    /// The areas of the block.
    fn direct(&self) -> &[f64] {
        match &self.adjusted {
            Some(own) => own,
            None => &self.areas.direct.areas[self.entries()],
        }
    }

    /// Codes of the radii of all pairs, those of the worst band.
    fn codes(&self) -> &[u8] {
        self.codes.get_or_init(|| {
            let (n, radii) = (self.len(), &self.areas.direct.radii[self.entries()]);
            let code = |k: usize| {
                let [i, j] = [k / n, k % n].map(|z| self.coefficients[z]);
                let radius = |b: Band| over(self.matrix(radii, b)[k], i[b] * j[b]);
                radius_code(Band::all().map(radius).fold(0.0, f64::max))
            };
            parallel::collect(n * n, code)
        })
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
            parallel::for_each(&mut out, |i, p| {
                let row = &matrix[i * n..(i + 1) * n];
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
        self.products(self.direct(), strengths, dot)
    }

    fn scale(&mut self, d: &[Bands]) {
        self.scaling.iter_mut().zip(d).for_each(|(s, d)| *s *= d);
    }
}

impl AdjustableExchange for AreaOperator<'_> {
    fn variance_product(&self, x: &[Bands]) -> Vec<Bands> {
        squared_product(self.codes(), x)
    }

    fn prepare_weights(&mut self) {
        let (n, areas) = (self.len(), self.direct());
        let limited = |(k, code): (usize, &u8)| {
            let [i, j] = [k / n, k % n].map(|z| self.coefficients[z]);
            // Zones that are transparent in a band have no factor there.
            let factor = |b: Band| match i[b] * j[b] {
                0.0 => f64::INFINITY,
                scale => self.matrix(areas, b)[k] / scale,
            };
            match *code {
                0 => 0,
                code => code.min(radius_code(Band::all().map(factor).fold(f64::INFINITY, f64::min))),
            }
        };
        self.weights = Some(self.codes().par_iter().enumerate().map(limited).collect());
    }

    fn weight_product(&self, x: &[Bands]) -> Vec<Bands> {
        squared_product(self.weights.as_deref().unwrap_or(self.codes()), x)
    }

    fn drop_weights(&mut self) {
        self.weights = None;
    }

    fn adjust(&mut self, multipliers: &[Bands], coefficients: &[Bands]) {
        let (n, squares) = (self.len(), squared_radii());
        let mut areas = self.adjusted.take().unwrap_or_else(|| self.direct().to_vec());
        let (codes, matrices) = (self.weights.as_deref().unwrap_or(self.codes()), self.matrices());
        parallel::chunks(&mut areas, n.max(1), |k, row| {
            // The first band of the matrix.
            let band = Band::all()
                .nth(k / n + matrices.start - self.first_band.min(matrices.start))
                .unwrap_or(Band::first());
            let i = k % n;
            let at = |z: usize| (multipliers[z][band], coefficients[z][band]);
            let (own, c) = at(i);
            for (j, (f, code)) in row.iter_mut().zip(&codes[i * n..]).enumerate().filter(|x| *x.1.1 > 0) {
                let (other, d) = at(j);
                let (w, scale) = (squares[*code as usize], c * d);
                *f = adjusted_factor(*f, w * (own * d + other * c) * scale, w * scale * scale);
            }
        });
        self.adjusted = Some(areas);
    }
}

/// Σ_j r_ij² x_j for the rows of a matrix of codes.
fn squared_product(codes: &[u8], x: &[Bands]) -> Vec<Bands> {
    let squares = squared_radii();
    let row = |codes: &[u8]| {
        let used = codes.iter().zip(x).filter(|c| *c.0 > 0);
        used.fold(Bands::ZERO, |s, (code, x)| s + squares[*code as usize] * *x)
    };
    parallel::collect(codes.len() / x.len().max(1), |i| row(&codes[i * x.len()..(i + 1) * x.len()]))
}

impl ErrorModel for AreaOperator<'_> {
    fn error(&self, strengths: &[Bands]) -> Option<Vec<Bands>> {
        let norm = |row: &[f64], x: &[f64]| dot_of_squares(row, x).sqrt();
        Some(self.products(&self.areas.direct.radii[self.entries()], strengths, norm))
    }

    fn grade(&self) -> Grade {
        self.areas.grade()
    }
}
