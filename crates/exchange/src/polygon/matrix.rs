//! All pairs of many plates without a medium: each plate prepared once, rows in parallel, the same bits for any number of threads.

use super::plates::{self, Goal};
use super::prepared::Prepared;
use crate::{Factor, Method};
use rayon::prelude::*;
use std::collections::BTreeMap;
use zonal_math::Bounded;
use zonal_scene::Plate;

/// Plates made ready for many pairs.
#[derive(Clone, Debug)]
pub struct Plates(Vec<Prepared>);

impl Plates {
    /// Makes plates ready.
    ///
    /// # Panics
    /// On a plate without area or with corners that are not finite.
    pub fn new(plates: &[Plate]) -> Plates {
        plates.iter().for_each(plates::check);
        Plates(plates.iter().map(Prepared::new).collect())
    }
    /// 𝓕 of plates `i` and `j` in m², without a medium and with nothing between them: radius at most
    /// max(`relative` · 𝓕, `absolute` · the smaller area) where rounding allows. The same bits in either order.
    pub fn pair(&self, i: usize, j: usize, relative: f64, absolute: f64) -> Factor {
        let (a, b) = (&self.0[i.min(j)], &self.0[i.max(j)]);
        plates::plain(a, b, Goal { relative, absolute: absolute * a.area.min(b.area) })
    }
}

/// The geometric factors of all unordered pairs of n plates (a plate does not see itself), with what they took.
#[derive(Clone, Debug)]
pub struct Matrix {
    size: usize,
    /// Below the diagonal, row by row: (1,0), (2,0), (2,1), …
    pairs: Vec<Bounded>,
    methods: Vec<Method>,
    /// Pairs by method.
    pub counts: BTreeMap<Method, u64>,
    /// Evaluations of kernels and logarithms.
    pub evaluations: u64,
}

impl Matrix {
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
    /// On an index that is no plate's.
    pub fn get(&self, i: usize, j: usize) -> Bounded {
        self.index(i, j).map_or(Bounded::ZERO, |k| self.pairs[k])
    }
    /// How it was computed.
    ///
    /// # Panics
    /// On an index that is no plate's.
    pub fn method(&self, i: usize, j: usize) -> Method {
        self.index(i, j).map_or(Method::Unseen, |k| self.methods[k])
    }
    /// Σ_j 𝓕_ij, m²: the area of plate i in a closed convex enclosure.
    pub fn row_sum(&self, i: usize) -> Bounded {
        (0..self.size).fold(Bounded::ZERO, |s, j| s + self.get(i, j))
    }
}

/// The factors of all pairs with radii of at most max(`relative` · 𝓕, `absolute` · the smaller area), grade proved.
///
/// Plates do not hide one another here.
///
/// # Panics
/// On a plate without area or with corners that are not finite, on tolerances that are not positive.
pub fn matrix(plates: &[Plate], relative: f64, absolute: f64) -> Matrix {
    assert!(relative > 0.0 && absolute > 0.0, "tolerances {relative}, {absolute}");
    let ready = Plates::new(plates);
    let size = plates.len();
    let row = |i: usize| (0..i).map(|j| ready.pair(i, j, relative, absolute)).collect();
    let rows: Vec<Vec<Factor>> = (0..size).into_par_iter().map(row).collect();
    let count = size * size.saturating_sub(1) / 2;
    let mut made = Matrix {
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
