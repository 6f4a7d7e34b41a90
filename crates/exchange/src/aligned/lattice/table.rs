//! A table of factors by offset: values and radii in the order of its index.

use super::chunk_evaluator::ChunkEvaluator;
use super::offset_family::{MethodCounts, OFFSETS_PER_CHUNK, OffsetFamily};
use super::offset_index::OffsetIndex;
use zonal_math::{Bounded, parallel};

/// Factors of the cells of a grid by offset: of two voxels (m⁴), of voxels and wall patches (m³) or of patches of two walls (m²). Patches are the outer
/// faces of cells, looking inwards.
///
/// An offset has a component an axis: along a wall's normal the number of whole cells between the wall and the near side of
/// the voxel or patch (0 for a zone on the wall), along any other axis the difference of the cells' indices, of any sign.
///
/// ```
/// use zonal_exchange::aligned::lattice::GridTables;
/// let table = GridTables::new([0.1; 3], [20, 20, 20], 0.0, 1e-10).voxels();
/// let f = table.get([3, -1, 2]);
/// assert!(f.radius <= 1e-10 * f.value && f == table.get([-2, 3, 1]));
/// ```
#[derive(Clone, Debug)]
pub struct FactorTable {
    pub(super) index: OffsetIndex,
    pub(super) values: Vec<f64>,
    /// Empty where processes shared the table: then `worst_relative` bounds all radii.
    pub(super) radii: Vec<f64>,
    /// Entries by method.
    pub(super) counts: MethodCounts,
    /// Largest relative radius weighted by the entry's share of a row sum, for tables whose entries have no common relative radius.
    pub(super) worst_relative: Option<f64>,
}

impl FactorTable {
    /// Computes all offsets of `index`.
    pub(super) fn new(
        index: OffsetIndex,
        family: &OffsetFamily,
        evaluator: &dyn ChunkEvaluator,
    ) -> FactorTable {
        if evaluator.is_alone() {
            let (values, radii, counts) = family.fill_parallel(&index);
            return FactorTable { index, values, radii, counts, worst_relative: None };
        }
        // Values, the counts of the methods, and the largest relative radius of each chunk.
        let chunk = |k: usize| {
            let first = k * OFFSETS_PER_CHUNK;
            let own = index.offsets(first..(first + OFFSETS_PER_CHUNK).min(index.len()));
            let (mut values, mut radii) = (vec![0.0; own.len()], vec![0.0; own.len()]);
            let counts = family.fill(&own, &mut values, &mut radii);
            let worst = worst_relative_radius(&values, &radii);
            values.extend(counts.numbers().map(|n| n as f64));
            values.push(worst);
            values
        };
        let chunks = index.len().div_ceil(OFFSETS_PER_CHUNK);
        let (mut all, mut counts, mut worst) =
            (Vec::with_capacity(index.len()), MethodCounts::default(), 0.0f64);
        for mut values in evaluator.evaluate(chunks, &chunk) {
            worst = worst.max(values.pop().unwrap_or(f64::INFINITY));
            let of_methods = values.split_off(values.len() - MethodCounts::LEN);
            counts.merge(MethodCounts::from_numbers(std::array::from_fn(|k| of_methods[k] as usize)));
            all.extend(values);
        }
        FactorTable { index, values: all, radii: Vec::new(), counts, worst_relative: Some(worst) }
    }
    /// The factor at an offset.
    ///
    /// # Panics
    /// On an offset outside the table.
    pub fn get(&self, offset: [i64; 3]) -> Bounded {
        let i = self.index.place(offset);
        let worst = || self.worst_relative.unwrap_or(f64::INFINITY) * self.values[i];
        Bounded::proved(self.values[i], self.radii.get(i).copied().unwrap_or_else(worst))
    }
    /// The values by offsets whose axis `k` is axis `turn[k]` of the table.
    pub fn turned(&self, turn: [usize; 3]) -> TurnedTable<'_> {
        TurnedTable { index: self.index.turned(turn), values: &self.values }
    }
    /// Number of distinct offsets.
    pub fn len(&self) -> usize {
        self.values.len()
    }
    /// False: a table has at least one offset.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }
    /// Number of entries by method.
    pub fn method_counts(&self) -> MethodCounts {
        self.counts
    }
    /// Largest relative radius; of a periodic grid weighted by the share of a row sum.
    pub fn worst_relative_radius(&self) -> f64 {
        if let Some(worst) = self.worst_relative {
            return worst;
        }
        worst_relative_radius(&self.values, &self.radii)
    }
}

/// The values of a table by offsets with permuted axes.
pub struct TurnedTable<'a> {
    index: OffsetIndex,
    values: &'a [f64],
}

impl TurnedTable<'_> {
    /// The value at an offset.
    ///
    /// # Panics
    /// On an offset outside the table.
    #[inline]
    pub fn value(&self, offset: [i64; 3]) -> f64 {
        self.values[self.index.place(offset)]
    }
}

/// The largest radius over its value.
fn worst_relative_radius(values: &[f64], radii: &[f64]) -> f64 {
    let of = |i: usize| if values[i] > 0.0 { radii[i] / values[i] } else { 0.0 };
    parallel::reduce(values.len().min(radii.len()), 0.0, of, f64::max)
}
