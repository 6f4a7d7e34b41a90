//! The dense engine of a scene with symmetry planes: sums over the images of a zone in the even extension,
//!
//! ```text
//!     F_ij = Σ_g F'(i, g·j),
//! ```
//!
//! a matrix of the scene's n zones in place of one of the |G| n zones of the extension; |G| n²/2 pairs are computed. As an operator on the extension
//! it is Eᵀ F E/|G| with the mean over images E: exact for even strengths, and symmetric.

use super::dense_operator::DenseOperator;
use crate::operator::{AdjustableExchange, ErrorModel, ExchangeOperator, IncidentPower};
use zonal_exchange::pair::{Exchange, PairCounts, PairFactor, PairRow};
use zonal_math::Grade;
use zonal_scene::{Bands, ZoneImages};

/// Exchange of the zones of a scene; with symmetry planes, sums over images.
pub(crate) struct ImageSums<'a> {
    /// The exchange of the extension, or of the scene without symmetry planes.
    pub exchange: &'a Exchange<'a>,
    /// The images; `None` without symmetry planes.
    pub images: Option<&'a ZoneImages>,
}

/// A zone whose pairs are computed one after the other.
pub(crate) struct ImageRow {
    /// Its last image in the extension.
    zone: usize,
    row: PairRow,
}

impl ImageSums<'_> {
    /// The work that all pairs of zone `i` share.
    pub(crate) fn row(&self, i: usize) -> ImageRow {
        let last = |images: &ZoneImages| images.of(i).iter().max().map_or(i, |k| *k as usize);
        let zone = self.images.map_or(i, last);
        ImageRow { zone, row: self.exchange.row(zone) }
    }

    /// g of the row's zone and all images of zone `j`, which is no later in the scene.
    pub(crate) fn pair_in_row(&self, row: &ImageRow, j: usize, counts: &mut PairCounts) -> PairFactor {
        let Some(images) = self.images else { return self.exchange.pair_in_row(&row.row, j, counts) };
        let mut sum = PairFactor::default();
        for k in images.of(j).iter().map(|k| *k as usize) {
            let f = if k <= row.zone {
                self.exchange.pair_in_row(&row.row, k, counts)
            } else {
                self.exchange.pair(row.zone, k, counts)
            };
            sum = PairFactor { value: sum.value + f.value, radius: sum.radius + f.radius };
        }
        sum
    }
}

/// A dense operator over the zones of a scene as an operator over those of its even extension.
pub(crate) struct ImageSumOperator<'a> {
    operator: DenseOperator<'a>,
    images: &'a ZoneImages,
}

impl<'a> ImageSumOperator<'a> {
    pub(crate) fn new(operator: DenseOperator<'a>, images: &'a ZoneImages) -> ImageSumOperator<'a> {
        ImageSumOperator { operator, images }
    }
}

impl ExchangeOperator for ImageSumOperator<'_> {
    fn len(&self) -> usize {
        self.images.zone_count() * self.images.image_count()
    }
    fn apply(&self, strengths: &[Bands]) -> Vec<Bands> {
        self.images.extended(&self.operator.apply(&self.images.mean(strengths)))
    }
    fn apply_many(&self, columns: &[Vec<Bands>]) -> Vec<Vec<Bands>> {
        let means: Vec<Vec<Bands>> = columns.iter().map(|s| self.images.mean(s)).collect();
        self.operator.apply_many(&means).iter().map(|p| self.images.extended(p)).collect()
    }
    fn scale(&mut self, d: &[Bands]) {
        self.operator.scale(&self.images.mean(d));
    }
}

impl AdjustableExchange for ImageSumOperator<'_> {
    fn variance_product(&self, x: &[Bands]) -> Vec<Bands> {
        self.images.extended(&self.operator.variance_product(&self.images.mean(x)))
    }
    fn prepare_weights(&mut self) {
        self.operator.prepare_weights();
    }
    fn weight_product(&self, x: &[Bands]) -> Vec<Bands> {
        self.images.extended(&self.operator.weight_product(&self.images.mean(x)))
    }
    fn drop_weights(&mut self) {
        self.operator.drop_weights();
    }
    fn adjust(&mut self, multipliers: &[Bands], coefficients: &[Bands]) {
        self.operator.adjust(&self.images.mean(multipliers), &self.images.mean(coefficients));
    }
}

impl ErrorModel for ImageSumOperator<'_> {
    fn error(&self, strengths: &[Bands]) -> Option<Vec<Bands>> {
        let error = self.operator.error(&self.images.mean(strengths));
        error.map(|e| self.images.extended(&e))
    }
    fn incident_power(&self, columns: &[Vec<Bands>]) -> IncidentPower {
        // As the dense operator without symmetry planes.
        IncidentPower { columns: self.apply_many(columns), ..IncidentPower::default() }
    }
    fn grade(&self) -> Grade {
        self.operator.grade()
    }
}
