//! A table of factors by offset: values and radii in the order of an [`OffsetIndex`].

use super::offset_family::{MethodCounts, OffsetFamily};
use super::offset_index::OffsetIndex;
use zonal_math::Bounded;

/// Values and radii of a family's distinct offsets.
#[derive(Clone, Debug)]
pub(super) struct FactorTable {
    pub index: OffsetIndex,
    pub values: Vec<f64>,
    pub radii: Vec<f64>,
    /// Entries by method.
    pub counts: MethodCounts,
    /// Largest relative radius weighted by the entry's share of a row sum, for tables whose entries have no common relative radius.
    pub worst_relative: Option<f64>,
}

impl FactorTable {
    /// Computes all offsets of `index` on rayon's threads.
    pub(super) fn new(index: OffsetIndex, family: &OffsetFamily) -> FactorTable {
        let (values, radii, counts) = family.fill_parallel(&index.offsets());
        FactorTable { index, values, radii, counts, worst_relative: None }
    }
    /// Value and radius at an offset.
    ///
    /// # Panics
    /// On an offset outside the table.
    pub(super) fn get(&self, offset: [i64; 3]) -> Bounded {
        let i = self.index.place(offset);
        Bounded::proved(self.values[i], self.radii[i])
    }
    /// Largest relative radius.
    pub(super) fn worst_relative_radius(&self) -> f64 {
        if let Some(worst) = self.worst_relative {
            return worst;
        }
        let of = |(v, r): (&f64, &f64)| if *v > 0.0 { r / v } else { 0.0 };
        self.values.iter().zip(&self.radii).map(of).fold(0.0, f64::max)
    }
}
