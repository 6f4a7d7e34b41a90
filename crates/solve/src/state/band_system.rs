//! The equations of one band, with the factor of (I − √D F √D) and the products with F' = d F d (header of [`super`]).

use super::cholesky::{Cholesky, dot, dot_of_squares};
use super::exchange_data::ExchangeData;
use rayon::prelude::*;
use zonal_math::parallel;

/// Rows of a task of a product.
const ROWS_PER_TASK: usize = 64;

/// The arrays of one matrix of [`ExchangeData`].
#[derive(Clone, Copy, PartialEq)]
pub(super) struct MatrixData<'a> {
    pub areas: &'a [f64],
    pub radii: &'a [f64],
    pub c: &'a [f64],
    pub scaling: &'a [f64],
    pub surroundings: &'a [f64],
    pub surroundings_radii: &'a [f64],
    pub backfaces: &'a [f64],
    pub closure_error: &'a [f64],
}

impl<'a> MatrixData<'a> {
    pub(super) fn of(data: &'a ExchangeData, matrix: usize) -> MatrixData<'a> {
        let n = data.zone_count();
        let (rows, pairs) = (matrix * n..(matrix + 1) * n, matrix * n * n..(matrix + 1) * n * n);
        let s = &data.surroundings;
        MatrixData {
            areas: &data.direct.areas[pairs.clone()],
            radii: &data.direct.radii[pairs],
            c: &data.direct.closure[rows.clone()],
            scaling: &s.scaling[rows.clone()],
            surroundings: &s.areas[rows.clone()],
            surroundings_radii: &s.radii[rows.clone()],
            backfaces: &s.backfaces[rows.clone()],
            closure_error: &s.closure_error[rows],
        }
    }

    /// F' x.
    pub(super) fn apply(&self, x: &[f64]) -> Vec<f64> {
        let scaled: Vec<f64> = x.iter().zip(self.scaling).map(|(x, d)| x * d).collect();
        let mut out = product(self.areas, &scaled, dot);
        out.iter_mut().zip(self.scaling).for_each(|(y, d)| *y *= d);
        out
    }

    /// √(Σ_j (δF_ij B_j)²) of every zone.
    pub(super) fn factor_errors(&self, radiosity: &[f64]) -> Vec<f64> {
        product(self.radii, radiosity, dot_of_squares).into_iter().map(f64::sqrt).collect()
    }
}

/// The products of the rows of a square matrix with x.
fn product(matrix: &[f64], x: &[f64], of_row: fn(&[f64], &[f64]) -> f64) -> Vec<f64> {
    let n = x.len();
    let mut out = vec![0.0; n];
    let tasks = out.par_chunks_mut(ROWS_PER_TASK).zip(matrix.par_chunks(n * ROWS_PER_TASK));
    tasks.for_each(|(out, rows)| {
        out.iter_mut().zip(rows.chunks_exact(n)).for_each(|(y, row)| *y = of_row(row, x));
    });
    out
}

/// The arguments of a factor.
#[derive(PartialEq)]
pub(super) struct FactorKey {
    /// The matrix of the data.
    pub matrix: usize,
    /// r̂ of every zone.
    pub reflected: Vec<f64>,
}

/// The factor of one band for given r̂.
pub(super) struct BandFactor {
    pub key: FactorKey,
    /// √(r̂/c), 0 for a zone without exchange.
    root: Vec<f64>,
    /// None where nothing is reflected.
    cholesky: Option<Cholesky>,
}

impl BandFactor {
    /// Factors the system of the matrix `m` of a key; none if no power is absorbed or lost.
    pub(super) fn new(m: &MatrixData, key: FactorKey) -> Option<BandFactor> {
        let reflected = &key.reflected;
        let n = reflected.len();
        let root: Vec<f64> =
            m.c.iter().zip(reflected).map(|(c, r)| if *c > 0.0 { (r / c).sqrt() } else { 0.0 }).collect();
        if root.iter().all(|r| *r == 0.0) {
            return Some(BandFactor { key, root, cholesky: None });
        }
        let side: Vec<f64> = root.iter().zip(m.scaling).map(|(r, d)| r * d).collect();
        let mut system = vec![0.0; n * n];
        parallel::chunks(&mut system, n, |i, row| {
            let (areas, own) = (&m.areas[i * n..i * n + i + 1], -side[i]);
            row.iter_mut().zip(areas).zip(&side).for_each(|((x, f), s)| *x = own * f * s);
            row[i] += 1.0;
        });
        Some(BandFactor { key, root, cholesky: Some(Cholesky::new(system, n)?) })
    }

    /// P = (I − F' D)⁻¹ b.
    pub(super) fn solve(&self, m: &MatrixData, b: Vec<f64>) -> Vec<f64> {
        let Some(cholesky) = &self.cholesky else { return b };
        let mut y: Vec<f64> = b.iter().zip(&self.root).map(|(b, r)| b * r).collect();
        cholesky.solve(&mut y);
        y.iter_mut().zip(&self.root).for_each(|(y, r)| *y *= r);
        let more = m.apply(&y);
        b.iter().zip(more).map(|(b, p)| b + p).collect()
    }

    /// r̂/c of every zone.
    pub(super) fn diagonal(&self) -> Vec<f64> {
        self.root.iter().map(|r| r * r).collect()
    }
}
