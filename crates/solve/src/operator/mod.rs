//! The exchange operator and its error model: the interface of every engine.
//!
//! Input: strengths s_j = c_j B_j (W/m² for patches, W/m³ for volume zones) with c = 1 for patches and c = κ for volumes.
//! Output: incident powers P_i = Σ_j g_ij s_j with g_ij = F_ij/(c_i c_j), hence H_i = P_i/A_i and G_i = P_i/V_i (V = A t in a pane).

pub(crate) mod mixed_sides;

use crate::distribution::multivector;
use crate::distribution::zone_blocks::ZoneBlocks;
use zonal_math::Grade;
use zonal_scene::Bands;

/// The product of strengths with the exchange areas of all zones.
pub trait ExchangeOperator: Sync {
    /// Number of unknowns: the zones, followed by the higher-order unknowns of [`ExchangeOperator::slope_zones`].
    fn len(&self) -> usize;
    /// True if the operator has no unknowns.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// The zone of every higher-order unknown (slope of the radiosity inside a zone), in the order of the unknowns; empty for a constant basis.
    fn slope_zones(&self) -> Vec<u32> {
        Vec::new()
    }
    /// P = g s in each band. `strengths` covers all unknowns, or the zones alone; the result has the same length.
    fn apply(&self, strengths: &[Bands]) -> Vec<Bands>;
    /// P = g s for each vector of a multivector; bit-identical to one product after the other.
    fn apply_many(&self, columns: &[Vec<Bands>]) -> Vec<Vec<Bands>> {
        columns.iter().map(|s| self.apply(s)).collect()
    }
    /// Replaces each vector of a multivector by its product; the bits are those of [`ExchangeOperator::apply_many`].
    fn replace_many(&self, columns: &mut Vec<Vec<Bands>>) {
        *columns = self.apply_many(columns);
    }
    /// True if all bands have the same factors and [`ExchangeOperator::apply_band`] costs a third of [`ExchangeOperator::apply`].
    fn has_identical_bands(&self) -> bool {
        false
    }
    /// P = g s in the first band.
    fn apply_band(&self, strengths: &[[f64; 1]]) -> Vec<[f64; 1]> {
        let all: Vec<Bands> = strengths.iter().map(|s| Bands::splat(s[0])).collect();
        self.apply(&all).iter().map(|p| [p.first()]).collect()
    }
    /// Replaces strengths in the first band by their product; the bits are those of [`ExchangeOperator::apply_band`].
    fn replace_band(&self, strengths: &mut Vec<[f64; 1]>) {
        *strengths = self.apply_band(strengths);
    }
    /// Replaces g_ij by d_i g_ij d_j.
    fn scale(&mut self, d: &[Bands]);
}

/// The errors of an exchange operator.
pub(crate) trait ErrorModel: ExchangeOperator {
    /// Estimated error of [`ExchangeOperator::apply`], in the unit of P; `None` if the operator has no error estimate of its own.
    fn error(&self, _strengths: &[Bands]) -> Option<Vec<Bands>> {
        None
    }
    /// Incident power of the strengths of a solution, with the error of the sum of all columns.
    fn incident_power(&self, columns: &[Vec<Bands>]) -> IncidentPower {
        let sum = multivector::total(self.len(), columns);
        IncidentPower { columns: self.apply_many(columns), error: self.error(&sum), ..Default::default() }
    }
    /// As [`ErrorModel::incident_power`], in the memory of the strengths; these are returned if the errors need them. The error takes the memory of
    /// `spare`.
    fn incident_power_in_place(
        &self,
        columns: Vec<Vec<Bands>>,
        _spare: Vec<Bands>,
    ) -> Result<IncidentPower, Vec<Vec<Bands>>> {
        Err(columns)
    }
    /// Error of the sum of all columns, from their incident power alone, in the memory of `spare`, which is given back if the errors need the
    /// strengths.
    fn error_of_power(&self, _incident: &[Vec<Bands>], spare: Vec<Bands>) -> Result<Vec<Bands>, Vec<Bands>> {
        Err(spare)
    }
    /// Blocks of zones and the exchange of these as zones, if the equations on blocks shorten the iteration.
    fn in_blocks(&self) -> Option<(ZoneBlocks, Box<dyn ExchangeOperator + '_>)> {
        None
    }
    /// The weakest grade among the factors.
    fn grade(&self) -> Grade;
}

/// Exchange factors g_ij of single pairs with error radii r_ij, which an adjustment may change by weights w_ij = min(r_ij, g_ij)²: a pair without exchange,
/// such as one behind a wall, has none after it either.
pub(crate) trait AdjustableExchange: ErrorModel {
    /// Σ_j r_ij² x_j of every zone.
    fn variance_product(&self, x: &[Bands]) -> Vec<Bands>;
    /// Computes the weights from the present factors, the smallest of all bands; before [`AdjustableExchange::weight_product`] and [`AdjustableExchange::adjust`].
    fn prepare_weights(&mut self);
    /// Σ_j w_ij x_j of every zone.
    fn weight_product(&self, x: &[Bands]) -> Vec<Bands>;
    /// Adds w_ij (λ_i c_j + λ_j c_i) to g_ij, for `multipliers` λ and `coefficients` c; a factor loses and gains no more than [`adjusted_factor`] allows.
    fn adjust(&mut self, multipliers: &[Bands], coefficients: &[Bands]);
    /// Frees the memory of the weights.
    fn drop_weights(&mut self);
}

/// Largest relative decrease of a factor in one adjustment, which keeps factors positive.
const MAX_LOSS_OF_FACTOR: f64 = 0.5;
/// Largest increase of a factor in one adjustment, over the root of its weight: small factors do not take the defects of large ones.
const MAX_GAIN_OVER_WEIGHT: f64 = 8.0;

/// The factor `g` of weight `w` after a change, within [`MAX_LOSS_OF_FACTOR`] and [`MAX_GAIN_OVER_WEIGHT`].
pub(crate) fn adjusted_factor(g: f64, change: f64, w: f64) -> f64 {
    g + change.max(-MAX_LOSS_OF_FACTOR * g).min(MAX_GAIN_OVER_WEIGHT * w.sqrt())
}

/// Incident power of every column of a multivector of strengths.
#[derive(Default)]
pub(crate) struct IncidentPower {
    /// P of every column.
    pub columns: Vec<Vec<Bands>>,
    /// Estimated error of the sum of the columns; `None` if it follows from the closure defects of the rows.
    pub error: Option<Vec<Bands>>,
    /// Estimated error of every column; empty if unknown.
    pub column_errors: Vec<Vec<Bands>>,
}

/// Appends the value of its zone for every higher-order unknown; `slope_zones` as [`ExchangeOperator::slope_zones`] gives them.
pub(crate) fn extend_to_slopes<T: Copy>(values: &mut Vec<T>, slope_zones: &[u32]) {
    values.reserve_exact(slope_zones.len());
    slope_zones.iter().for_each(|&i| values.push(values[i as usize]));
}
