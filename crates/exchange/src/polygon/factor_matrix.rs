//! The factors of all pairs of many plates without a medium. Each plate is prepared once and rows are computed in parallel; results do not
//! depend on the number of threads.

use super::mapped_zone::assert_valid_plate;
use super::plate_geometry::PlateGeometry;
use super::plate_pair::{self, RadiusGoal};
use crate::{Factor, Method};
use std::collections::BTreeMap;
use zonal_math::Bounded;
use zonal_math::parallel;
use zonal_scene::Plate;

/// Plates prepared for many pairs.
#[derive(Clone, Debug)]
pub struct PreparedPlates(Vec<PlateGeometry>);

impl PreparedPlates {
    /// Prepares plates.
    ///
    /// # Panics
    /// On a plate without area or with corners that are not finite.
    pub fn new(plates: &[Plate]) -> PreparedPlates {
        plates.iter().for_each(assert_valid_plate);
        PreparedPlates(plates.iter().map(PlateGeometry::new).collect())
    }
    /// 𝓕 of plates `i` and `j` in m², without a medium and with nothing between them: radius at most
    /// max(`relative` · 𝓕, `absolute` · the smaller area) where rounding allows. The same bits in either order.
    pub fn pair(&self, i: usize, j: usize, relative: f64, absolute: f64) -> Factor {
        let (a, b) = (&self.0[i.min(j)], &self.0[i.max(j)]);
        plate_pair::factor_without_medium(
            a,
            b,
            RadiusGoal { relative, absolute: absolute * a.area.min(b.area) },
        )
    }
}

/// The geometric factors of all unordered pairs of n plates (a plane plate has no factor with itself), with methods and cost.
#[derive(Clone, Debug)]
pub struct FactorMatrix {
    size: usize,
    /// Below the diagonal, row by row: (1,0), (2,0), (2,1), …
    pairs: Vec<Bounded>,
    methods: Vec<Method>,
    /// Pairs by method.
    pub counts: BTreeMap<Method, u64>,
    /// Evaluations of kernels and logarithms.
    pub evaluations: u64,
}

impl FactorMatrix {
    /// Number of plates.
    pub fn size(&self) -> usize {
        self.size
    }
    fn index(&self, i: usize, j: usize) -> Option<usize> {
        assert!(i < self.size && j < self.size, "pair ({i}, {j}) of {} plates", self.size);
        let (hi, lo) = (i.max(j), i.min(j));
        (hi > lo).then(|| hi * (hi - 1) / 2 + lo)
    }
    /// 𝓕 of plates i and j, m², in either order.
    ///
    /// # Panics
    /// On an index out of range.
    pub fn get(&self, i: usize, j: usize) -> Bounded {
        self.index(i, j).map_or(Bounded::ZERO, |k| self.pairs[k])
    }
    /// How it was computed.
    ///
    /// # Panics
    /// On an index out of range.
    pub fn method(&self, i: usize, j: usize) -> Method {
        self.index(i, j).map_or(Method::NotVisible, |k| self.methods[k])
    }
    /// Σ_j 𝓕_ij, m²: the area of plate i in a closed convex enclosure.
    pub fn row_sum(&self, i: usize) -> Bounded {
        (0..self.size).fold(Bounded::ZERO, |s, j| s + self.get(i, j))
    }
}

/// The factors of all pairs with radii of at most max(`relative` · 𝓕, `absolute` · the smaller area), grade proved.
///
/// Occlusion by other plates is not considered.
///
/// ```
/// use zonal_exchange::polygon::factor_matrix;
/// use zonal_math::vec3;
/// use zonal_scene::Plate;
/// let floor = Plate::parallelogram(vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
/// let top = Plate::parallelogram(vec3(0.0, 0.0, 1.0), vec3(0.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0));
/// let f = factor_matrix(&[floor, top], 1e-10, 1e-12);
/// assert!((f.get(0, 1).value - 0.199_824_895_698).abs() < 1e-10 && f.get(0, 1) == f.get(1, 0));
/// ```
///
/// # Panics
/// On a plate without area or with corners that are not finite, on tolerances that are not positive.
pub fn factor_matrix(plates: &[Plate], relative: f64, absolute: f64) -> FactorMatrix {
    assert!(relative > 0.0 && absolute > 0.0, "tolerances {relative}, {absolute}");
    let ready = PreparedPlates::new(plates);
    let size = plates.len();
    let row = |i: usize| (0..i).map(|j| ready.pair(i, j, relative, absolute)).collect();
    let rows: Vec<Vec<Factor>> = parallel::collect(size, row);
    let count = size * size.saturating_sub(1) / 2;
    let mut made = FactorMatrix {
        size,
        pairs: Vec::with_capacity(count),
        methods: Vec::with_capacity(count),
        counts: BTreeMap::new(),
        evaluations: 0,
    };
    for f in rows.iter().flatten() {
        made.pairs.push(f.bounded);
        made.methods.push(f.method);
        *made.counts.entry(f.method).or_default() += 1;
        made.evaluations += f.evaluations;
    }
    made
}
