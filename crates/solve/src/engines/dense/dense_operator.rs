//! The operator of the dense engine: one product reads every stored exchange area once.
//!
//! Bands with equal extinctions share one packed symmetric matrix over patches and voxels. Rows of panes differ in every band; they come last
//! and are stored for each band. Memory: 8 bytes × n(n+1)/2 for each group of bands, and n(n+1)/2 bytes for the errors.

use super::packed_symmetric::PackedSymmetric;
use crate::distribution::Communicator;
use crate::distribution::multivector::{times, times_scaling};
use crate::engines::dense::pair_radii::{PairRadii, squared_radii};
use crate::operator::{AdjustableExchange, ErrorModel, ExchangeOperator, IncidentPower, adjusted_factor};
use zonal_math::Grade;
use zonal_math::parallel;
use zonal_scene::{Band, Bands, PerBand};

/// Exchange areas of all pairs of zones.
pub(crate) struct DenseOperator<'a> {
    /// The processes that share the rows.
    pub(super) communicator: &'a dyn Communicator,
    pub(super) n: usize,
    /// Number of zones before the panes.
    pub(super) shared: usize,
    /// One matrix a group of bands with equal extinctions, over patches and voxels.
    pub(super) matrices: Vec<PackedSymmetric>,
    /// The group of each band.
    pub(super) group: PerBand<usize>,
    /// Rows of the panes over all zones up to and including themselves: `panes[b][k][j]`.
    pub(super) panes: PerBand<Vec<Vec<f64>>>,
    /// d of g'_ij = d_i g_ij d_j, if closure was restored; for each band, also where bands share a matrix.
    pub(super) scaling: Option<Vec<Bands>>,
    /// Error radii of the pairs, those of the worst band.
    pub(super) radii: PairRadii,
    /// Roots of the weights of an adjustment, while there is one.
    pub(super) weights: Option<PairRadii>,
    pub(super) grade: Grade,
}

/// Numbers of vectors (columns and bands) that one product of a matrix serves.
const PRODUCT_WIDTHS: [usize; 5] = [12, 6, 3, 2, 1];

impl DenseOperator<'_> {
    /// Products of all matrices; each reads its entries once for up to a dozen columns and bands.
    fn apply_shared(&self, x: &[&[Bands]], out: &mut [Vec<Bands>]) {
        for (g, m) in self.matrices.iter().enumerate() {
            let bands_of = Band::all().filter(|&b| self.group[b] == g);
            let list: Vec<(usize, Band)> = bands_of.flat_map(|b| (0..x.len()).map(move |c| (c, b))).collect();
            let mut rest = &list[..];
            while !rest.is_empty() {
                let k = PRODUCT_WIDTHS.into_iter().find(|&k| k <= rest.len()).unwrap_or(1);
                let (now, later) = rest.split_at(k);
                match k {
                    12 => self.apply_block::<12>(m, x, now, out),
                    6 => self.apply_block::<6>(m, x, now, out),
                    3 => self.apply_block::<3>(m, x, now, out),
                    2 => self.apply_block::<2>(m, x, now, out),
                    _ => self.apply_block::<1>(m, x, now, out),
                }
                rest = later;
            }
        }
    }

    /// One product for the `K` pairs of column and band in `list`.
    fn apply_block<const K: usize>(
        &self,
        m: &PackedSymmetric,
        x: &[&[Bands]],
        list: &[(usize, Band)],
        out: &mut [Vec<Bands>],
    ) {
        let gathered: Vec<[f64; K]> =
            (0..self.shared).map(|i| std::array::from_fn(|k| x[list[k].0][i][list[k].1])).collect();
        for (i, y) in m.apply_on_ranks(&gathered, self.communicator).iter().enumerate() {
            (0..K).for_each(|k| out[list[k].0][i][list[k].1] = y[k]);
        }
    }

    fn apply_slices(&self, columns: &[&[Bands]]) -> Vec<Vec<Bands>> {
        assert!(columns.iter().all(|s| s.len() == self.n));
        let scaled: Option<Vec<Vec<Bands>>> =
            self.scaling.as_ref().map(|d| columns.iter().map(|s| times(s, d)).collect());
        let x: Vec<&[Bands]> = match &scaled {
            Some(s) => s.iter().map(Vec::as_slice).collect(),
            None => columns.to_vec(),
        };
        let mut out = vec![vec![Bands::ZERO; self.n]; columns.len()];
        self.apply_shared(&x, &mut out);
        for (x, out) in x.iter().zip(&mut out) {
            self.apply_panes(x, out);
        }
        match &self.scaling {
            Some(d) => out.iter().map(|o| times(o, d)).collect(),
            None => out,
        }
    }

    fn apply_panes(&self, x: &[Bands], out: &mut [Bands]) {
        for b in Band::all() {
            for (k, row) in self.panes[b].iter().enumerate() {
                let i = self.shared + k;
                let mut own = row[i] * x[i][b];
                for j in 0..i {
                    own += row[j] * x[j][b];
                    out[j][b] += row[j] * x[i][b];
                }
                out[i][b] += own;
            }
        }
    }

    /// Gives a matrix of its own to every band whose `vectors` differ from those of the first band of its group.
    fn separate_bands(&mut self, vectors: [&[Bands]; 2]) {
        let equal = |a: Band, b: Band| vectors.iter().all(|v| v.iter().all(|x| x[a] == x[b]));
        let former = self.group;
        for b in Band::all() {
            let mut others = Band::all().filter(|&a| a < b && former[a] == former[b]);
            let (first, twin) = (others.clone().next(), others.find(|&a| equal(a, b)));
            self.group[b] = match (first, twin) {
                (None, _) => former[b],
                (_, Some(twin)) => self.group[twin],
                (Some(first), None) => {
                    self.matrices.push(self.matrices[former[first]].clone());
                    self.matrices.len() - 1
                }
            };
        }
    }
}

/// Adds w_ij (λ_i c_j + λ_j c_i) to the entries of row i, whose weights have the codes `codes`.
fn adjust_row(row: &mut [f64], codes: &[u8], squares: &[f64], [multipliers, coefficients]: [&[f64]; 2]) {
    let i = row.len() - 1;
    let (own, c) = (multipliers[i], coefficients[i]);
    for (j, (g, code)) in row.iter_mut().zip(codes).enumerate().filter(|x| *x.1.1 > 0) {
        let w = squares[*code as usize];
        *g = adjusted_factor(*g, w * (own * coefficients[j] + multipliers[j] * c), w);
    }
}

impl AdjustableExchange for DenseOperator<'_> {
    fn variance_product(&self, x: &[Bands]) -> Vec<Bands> {
        self.radii.squared_product(x, self.communicator)
    }

    fn prepare_weights(&mut self) {
        let smallest = |i: usize, j: usize| match i.checked_sub(self.shared) {
            Some(k) => Band::all().map(|b| self.panes[b][k][j]).fold(f64::INFINITY, f64::min),
            None => self.matrices.iter().map(|m| m.row(i)[j]).fold(f64::INFINITY, f64::min),
        };
        self.weights = Some(self.radii.limited(smallest));
    }

    fn weight_product(&self, x: &[Bands]) -> Vec<Bands> {
        self.weights.as_ref().unwrap_or(&self.radii).squared_product(x, self.communicator)
    }

    fn drop_weights(&mut self) {
        self.weights = None;
    }

    fn adjust(&mut self, multipliers: &[Bands], coefficients: &[Bands]) {
        self.separate_bands([multipliers, coefficients]);
        let squares = squared_radii();
        let of_band =
            |b: Band| [multipliers, coefficients].map(|v| v.iter().map(|x| x[b]).collect::<Vec<f64>>());
        for (g, matrix) in self.matrices.iter_mut().enumerate() {
            let Some(band) = Band::all().find(|&b| self.group[b] == g) else { continue };
            let [m, c] = of_band(band);
            let radii = self.weights.as_ref().unwrap_or(&self.radii);
            parallel::for_each(&mut matrix.rows_mut(), |_, row| {
                let codes = radii.row(row.len() - 1);
                adjust_row(row, codes, &squares, [&m, &c]);
            });
        }
        for b in Band::all() {
            let [m, c] = of_band(b);
            let weights = self.weights.as_ref().unwrap_or(&self.radii);
            for (row, codes) in self.panes[b].iter_mut().zip(weights.panes()) {
                adjust_row(row, codes, &squares, [&m, &c]);
            }
        }
    }
}

impl ExchangeOperator for DenseOperator<'_> {
    fn len(&self) -> usize {
        self.n
    }
    fn apply(&self, s: &[Bands]) -> Vec<Bands> {
        self.apply_slices(&[s]).pop().unwrap_or_default()
    }
    fn apply_many(&self, columns: &[Vec<Bands>]) -> Vec<Vec<Bands>> {
        self.apply_slices(&columns.iter().map(Vec::as_slice).collect::<Vec<_>>())
    }
    fn has_identical_bands(&self) -> bool {
        self.matrices.len() == 1 && self.n == self.shared && self.scaling.is_none()
    }
    fn apply_band(&self, s: &[[f64; 1]]) -> Vec<[f64; 1]> {
        self.matrices[0].apply_on_ranks(s, self.communicator)
    }
    fn scale(&mut self, d: &[Bands]) {
        self.scaling = Some(times_scaling(&self.scaling, d));
    }
}

impl ErrorModel for DenseOperator<'_> {
    fn error(&self, strengths: &[Bands]) -> Option<Vec<Bands>> {
        Some(self.radii.propagate(strengths, self.communicator))
    }
    fn incident_power(&self, columns: &[Vec<Bands>]) -> IncidentPower {
        // Errors are combined with the closure defects of the rows, group by group.
        IncidentPower { columns: self.apply_many(columns), ..IncidentPower::default() }
    }
    fn grade(&self) -> Grade {
        self.grade
    }
}
