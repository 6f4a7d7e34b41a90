//! The one operator that every engine implements.
//!
//! In: the strengths s_j = c_j B_j (W/m² for patches, W/m³ for volume zones), c = 1 for patches and κ for volumes.
//! Out: P_i = Σ_j g_ij s_j with g_ij = F_ij/(c_i c_j), so that H_i = P_i/A_i and G_i = P_i/V_i (in a pane V = A t).

use crate::columns::total;
use zonal_math::Grade;
use zonal_scene::Bands;

/// Gives every slope what its zone has: `values` are of the zones, `slopes` as [`Operator::slopes`] tells them.
pub fn extend_to_slopes<T: Copy>(values: &mut Vec<T>, slopes: &[u32]) {
    values.reserve_exact(slopes.len());
    slopes.iter().for_each(|&i| values.push(values[i as usize]));
}

/// What arrives in the end.
pub struct Arriving {
    /// P of every column.
    pub columns: Vec<Vec<Bands>>,
    /// Estimated error of their sum; `None` where the engine's errors are relative to the rows.
    pub error: Option<Vec<Bands>>,
}

/// Radiosities in, arriving power out.
pub trait Operator {
    /// Number of unknowns: the zones, then their slopes, if it has any ([`Operator::slopes`]).
    fn len(&self) -> usize;
    /// True without zones.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// The zone of every unknown beyond the zones: where radiosity varies inside a zone, its further components, with the weight and target of the
    /// zone.
    fn slopes(&self) -> Vec<u32> {
        Vec::new()
    }
    /// P = g s, band by band, of all unknowns or of the zones alone, as many as there are strengths.
    fn apply(&self, strengths: &[Bands]) -> Vec<Bands>;
    /// P = g s for many columns of strengths; the same bits as one after the other.
    fn apply_many(&self, columns: &[Vec<Bands>]) -> Vec<Vec<Bands>> {
        columns.iter().map(|s| self.apply(s)).collect()
    }
    /// True where all bands have the same factors and [`Operator::apply_band`] costs a third of [`Operator::apply`]: bands that also shine
    /// and reflect alike are then solved once.
    fn one_band(&self) -> bool {
        false
    }
    /// P = g s in the first band.
    fn apply_band(&self, strengths: &[[f64; 1]]) -> Vec<[f64; 1]> {
        let all: Vec<Bands> = strengths.iter().map(|s| [s[0]; 3]).collect();
        self.apply(&all).iter().map(|p| [p[0]]).collect()
    }
    /// Estimated error of [`Operator::apply`], in the unit of P, where the engine keeps one a link; `None` where its errors are
    /// relative to the rows.
    fn error(&self, _strengths: &[Bands]) -> Option<Vec<Bands>> {
        None
    }
    /// What arrives by the strengths of a solution: the product with each column, or better where the engine knows better.
    fn arriving(&self, columns: &[Vec<Bands>]) -> Arriving {
        Arriving { columns: self.apply_many(columns), error: self.error(&total(self.len(), columns)) }
    }
    /// Replaces g_ij by d_i g_ij d_j.
    fn scale(&mut self, d: &[Bands]);
    /// The weakest grade among the factors.
    fn grade(&self) -> Grade;
}
