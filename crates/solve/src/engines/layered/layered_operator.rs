//! The operator of the layered engine and its errors (header of [`super`]).

use super::layer_stack::LayerStack;
use crate::distribution::multivector::{times, times_scaling};
use crate::engines::dense::band_groups::BandGroups;
use crate::engines::dense::packed_symmetric::PackedSymmetric;
use crate::engines::dense::row_blocks::packed_length;
use crate::operator::{ErrorModel, ExchangeOperator};
use zonal_exchange::layers::LayerFactors;
use zonal_math::Grade;
use zonal_math::parallel;
use zonal_scene::{Band, Bands, PerBand, Progress};

/// The exchange of the zones of a stack of layers.
pub struct LayeredOperator {
    stack: LayerStack,
    /// Factors of the elements, m², m³ and m⁴, for each group of bands.
    matrices: Vec<PackedSymmetric>,
    /// Relative radii of the factors, with the rounding of a product, for each group of bands.
    radii: Vec<f64>,
    /// Number of nodes of the integrals of all groups.
    nodes: usize,
    group: PerBand<usize>,
    /// d of g'_ij = d_i g_ij d_j, where closure was restored.
    scaling: Option<Vec<Bands>>,
}

impl LayeredOperator {
    /// Computes the factors of a stack.
    pub fn new(stack: LayerStack, progress: &dyn Progress) -> LayeredOperator {
        let BandGroups { group, firsts } = stack.band_groups();
        let (mut matrices, mut radii, mut nodes) = (Vec::new(), Vec::new(), 0);
        progress.begin("exchange areas of layers", firsts.len() as u64);
        for b in firsts {
            let extinction: Vec<f64> = stack.extinction.iter().map(|k| k[b]).collect();
            let factors = LayerFactors::new(&extinction, &stack.thickness);
            let mut matrix = PackedSymmetric::zeros(factors.elements());
            parallel::for_each(&mut matrix.rows_mut(), |i, row| {
                factors.row(i, row);
                row.iter_mut().for_each(|x| *x *= stack.area);
            });
            matrices.push(joined(&stack, matrix));
            radii.push(factors.relative_radius() + factors.elements() as f64 * f64::EPSILON);
            nodes += factors.nodes();
            progress.advance(1);
        }
        progress.end();
        LayeredOperator { stack, matrices, radii, nodes, group, scaling: None }
    }

    /// Bytes of the operator while it is built.
    pub(crate) fn bytes(stack: &LayerStack) -> u64 {
        let groups = stack.band_groups().firsts.len() as u64;
        let joins = u64::from(stack.panes > 0);
        (groups + joins) * 8 * packed_length(stack.extinction.len() + 2) as u64
            + LayerFactors::bytes(stack.extinction.len(), stack.smallest_depth())
    }

    /// Names and values of the counters.
    pub(crate) fn counts(&self) -> Vec<(String, u64)> {
        let n = self.stack.element.len() as u64;
        [
            ("pairs", n * (n + 1) / 2),
            ("layers", (self.stack.layers + self.stack.panes) as u64),
            ("nodes of integrals", self.nodes as u64),
        ]
        .map(|(what, n)| (what.to_string(), n))
        .to_vec()
    }

    /// Incident power for a radiosity of one at the openings: the factors of the surroundings, m² and m³.
    pub(crate) fn opening_factors(&self) -> Vec<Bands> {
        let last = self.stack.layers + 1;
        let mut open = vec![Bands::ZERO; self.stack.elements()];
        for (element, is_open) in [0, last].into_iter().zip(self.stack.open) {
            if is_open {
                open[element] = Bands::ONE;
            }
        }
        self.spread(&self.exchange(&open))
    }

    /// Incident power of the elements, for their mean strengths.
    fn exchange(&self, strengths: &[Bands]) -> Vec<Bands> {
        let mut out = vec![Bands::ZERO; strengths.len()];
        for b in Band::all() {
            let own: Vec<[f64; 1]> = strengths.iter().map(|s| [s[b]]).collect();
            let found = self.matrices[self.group[b]].apply(&own);
            out.iter_mut().zip(found).for_each(|(o, [x])| o[b] = x);
        }
        out
    }

    /// The share of each zone in the power of its element.
    fn spread(&self, power: &[Bands]) -> Vec<Bands> {
        let of = |(e, share): (&u32, &f64)| power[*e as usize] * *share;
        self.stack.element.iter().zip(&self.stack.share).map(of).collect()
    }

    fn product(&self, s: &[Bands]) -> Vec<Bands> {
        assert_eq!(s.len(), self.len(), "one strength for each zone");
        let mut means = vec![Bands::ZERO; self.stack.elements()];
        for ((e, share), s) in self.stack.element.iter().zip(&self.stack.share).zip(s) {
            means[*e as usize] += *s * *share;
        }
        self.spread(&self.exchange(&means))
    }
}

/// The factors of the elements from those of their sheets: factors of volumes add up.
fn joined(stack: &LayerStack, mut sheets: PackedSymmetric) -> PackedSymmetric {
    if stack.panes == 0 {
        return sheets;
    }
    let mut out = PackedSymmetric::zeros(stack.elements());
    let mut rows: Vec<&mut [f64]> = out.rows_mut();
    for (i, row) in sheets.rows_mut().into_iter().enumerate() {
        for (j, x) in row.iter().enumerate() {
            let [a, b] = [i, j].map(|k| stack.element_of_sheet[k] as usize);
            // Two sheets of one element exchange in both directions.
            rows[a.max(b)][a.min(b)] += if a == b && i != j { 2.0 * x } else { *x };
        }
    }
    out
}

impl ExchangeOperator for LayeredOperator {
    fn len(&self) -> usize {
        self.stack.element.len()
    }
    fn apply(&self, s: &[Bands]) -> Vec<Bands> {
        match &self.scaling {
            Some(d) => times(&self.product(&times(s, d)), d),
            None => self.product(s),
        }
    }
    fn scale(&mut self, d: &[Bands]) {
        self.scaling = Some(times_scaling(&self.scaling, d));
    }
}

impl ErrorModel for LayeredOperator {
    fn error(&self, strengths: &[Bands]) -> Option<Vec<Bands>> {
        let absolute: Vec<Bands> = strengths.iter().map(|s| s.abs()).collect();
        let radius = self.group.map(|g| self.radii[g]);
        Some(self.apply(&absolute).into_iter().map(|p| radius * p).collect())
    }
    fn grade(&self) -> Grade {
        Grade::Proved
    }
}
