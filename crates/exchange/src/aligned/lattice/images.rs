//! Grids that repeat themselves: the factor of an offset d is the sum over its images,
//!
//! ```text
//!     Σ_m 𝓕(d + m ∘ n),      m an integer along each periodic axis, n the cells of a period.
//! ```
//!
//! **Tail.** Left out are images with a gap of more than the reach R. All radiation that arrives at a zone from beyond R has passed κR: summed
//! over all zones, what is left out of a row is at most e^{−κR} of the row's sum, A of a patch and 4V of a voxel (times the strengths of a
//! level field). So R = 36/κ leaves 2·10⁻¹⁶ of a row.
//!
//! **A period of one cell.** The images of a cell are the cells of a row: together one box, as long as it need be, and one factor instead of a sum.
//!
//! **Tolerance.** Rows are sums over shells whose weight falls as e^{−κr}; a shell at r may err by e^{κr/2} times the relative tolerance, and
//! the sum of all errs by twice the tolerance: ∫ κ e^{−κr/2} dr = 2. The families of [`RUNGS`] tolerances serve, half of it each.

use super::fill::{Family, Tally};
use super::index::Index;
use super::{Table, integer};
use rayon::prelude::*;

/// How a grid repeats itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Images {
    /// Cells of a period along each axis; `None` where the grid ends.
    pub period: [Option<usize>; 3],
    /// Edges of a cell, m.
    pub edges: [f64; 3],
    /// Extinction, 1/m.
    pub kappa: f64,
    /// Gap beyond which images are left out, m.
    pub reach: f64,
}

/// Families by tolerance, and the factor from one to the next.
const RUNGS: usize = 4;
const RUNG: f64 = 100.0;
/// Offsets that are computed together.
const TOGETHER: usize = 4096;
/// Mean free paths after which an image is left out.
pub const DEPTH: f64 = 36.0;

impl Images {
    /// Of a grid with extinction `kappa` > 0 (1/m).
    pub fn new(period: [Option<usize>; 3], edges: [f64; 3], kappa: f64) -> Images {
        Images { period, edges, kappa, reach: DEPTH / kappa }
    }

    /// True where an axis repeats itself.
    pub fn any(&self) -> bool {
        self.period.iter().any(Option::is_some)
    }

    /// Distances in cells along an axis of the images of `offset` that may lie within reach.
    pub fn distances(&self, axis: usize, offset: usize) -> Vec<usize> {
        let Some(period) = self.period[axis].filter(|p| *p > 1) else { return vec![offset] };
        let most = (self.reach / self.edges[axis]).ceil() as usize + 1;
        let up = (offset..=most).step_by(period);
        let down = (1..).map(|m| (m * period).abs_diff(offset)).zip(1..);
        // Below the offset itself first: m periods back.
        let down = down.take_while(|(d, m)| m * period < offset || *d <= most).map(|(d, _)| d);
        up.chain(down).collect()
    }

    /// Offsets that a table with these `counts` of distinct offsets computes, about: the box around what is within reach. Infinitely many
    /// where that is further than tables count cells.
    pub fn work(&self, counts: [usize; 3]) -> f64 {
        let along = |k: usize| match self.period[k] {
            Some(1) => 1.0,
            Some(_) => match (self.reach / self.edges[k]).ceil() + 2.0 {
                cells if cells < f64::from(u16::MAX) => cells,
                _ => f64::INFINITY,
            },
            None => counts[k] as f64,
        };
        (0..3).map(along).product()
    }

    /// The table over an index of distinct offsets.
    pub(super) fn table(&self, index: Index, make: impl Fn(f64) -> Family, tolerance: f64) -> Table {
        let families: [Family; RUNGS] =
            std::array::from_fn(|k| make((0.5 * tolerance * RUNG.powi(k as i32)).min(1e-3)));
        let sums: Vec<([f64; 2], Tally)> = index
            .offsets()
            .into_par_iter()
            .with_max_len(1)
            .map(|offset| self.sum(offset, &families))
            .collect();
        let tally = sums.iter().fold(Tally::default(), |t, s| t.plus(s.1));
        let part = |k: usize| sums.iter().map(|s| s.0[k]).collect();
        Table { index, values: part(0), radii: part(1), tally }
    }

    /// Value and radius of the images of an offset together.
    fn sum(&self, offset: [u16; 3], families: &[Family; RUNGS]) -> ([f64; 2], Tally) {
        let [x, y, z] = [0, 1, 2].map(|k| self.distances(k, offset[k] as usize));
        let gap = |k: usize, d: usize| self.edges[k] * d.saturating_sub(1) as f64;
        let mut waiting: [Vec<[u16; 3]>; RUNGS] = Default::default();
        let mut found = ([0.0; 2], Tally::default());
        // Cells in a row are one box, which ends out of reach.
        let beyond = [0, 1, 2].map(|k| match self.period[k] {
            Some(1) => ((self.reach / self.edges[k]).ceil() + 1.0) * self.edges[k],
            _ => 0.0,
        });
        let rows = beyond != [0.0; 3];
        for &i in &x {
            for &j in &y {
                let g2 = gap(0, i).powi(2) + gap(1, j).powi(2);
                for &k in &z {
                    let g = (g2 + gap(2, k).powi(2)).sqrt();
                    if g > self.reach {
                        continue;
                    }
                    if rows {
                        let (value, radius) =
                            families[0].merged([i, j, k].map(integer), beyond, &mut found.1);
                        found.0 = [found.0[0] + value, found.0[1] + radius];
                        continue;
                    }
                    let rung = ((0.5 * self.kappa * g) / RUNG.ln()) as usize;
                    let rung = rung.min(RUNGS - 1);
                    waiting[rung].push([i, j, k].map(integer));
                    if waiting[rung].len() == TOGETHER {
                        add(&mut found, &families[rung], &mut waiting[rung]);
                    }
                }
            }
        }
        (0..RUNGS).for_each(|r| add(&mut found, &families[r], &mut waiting[r]));
        found
    }
}

/// Adds the factors of the offsets in a list, and empties it.
fn add(found: &mut ([f64; 2], Tally), family: &Family, list: &mut Vec<[u16; 3]>) {
    let (mut values, mut radii) = (vec![0.0; list.len()], vec![0.0; list.len()]);
    let tally = family.fill(list, &mut values, &mut radii);
    found.0[0] += values.iter().sum::<f64>();
    found.0[1] += radii.iter().sum::<f64>();
    found.1 = found.1.plus(tally);
    list.clear();
}

#[cfg(test)]
mod tests {
    use super::super::{OffsetTable, WallTable};
    use super::*;

    #[test]
    fn images_are_counted_once() {
        let images = Images::new([Some(5), None, Some(1)], [1.0; 3], 3.0);
        let mut d = images.distances(0, 2);
        d.sort_unstable();
        assert_eq!(d, [2, 3, 7, 8, 12, 13]);
        let mut d = images.distances(0, 0);
        d.sort_unstable();
        assert_eq!(d, [0, 5, 5, 10, 10]);
        assert_eq!(images.distances(1, 4), [4]);
        assert_eq!(images.distances(2, 0), [0], "a row is one box");
    }

    #[test]
    fn sums_are_those_of_the_plain_tables() {
        let (edges, kappa) = ([0.5, 0.4, 0.3], 9.0);
        let images = Images::new([Some(4), Some(3), None], edges, kappa);
        let table = OffsetTable::repeated(edges, [3, 2, 5], &images, kappa, 1e-12);
        let plain = OffsetTable::new(edges, [14, 15, 5], kappa, 1e-12);
        for (d, e) in [([0, 0, 0], [0, 0, 0]), ([2, 1, 4], [2, 1, 4]), ([1, 0, 2], [1, 0, 2])] {
            let mut sum = 0.0;
            for m in -3i64..=3 {
                for k in -4i64..=4 {
                    let at = [d[0] + 4 * m, d[1] + 3 * k, d[2]];
                    if at[0].abs() < 14 && at[1].abs() < 15 {
                        sum += plain.get(at).value;
                    }
                }
            }
            let got = table.get(e);
            assert!((got.value - sum).abs() < 4e-12 * sum, "{d:?}: {got:?} {sum}");
        }
    }

    #[test]
    fn a_row_of_images_is_one_box() {
        // A period of one cell against the sum over cells of a period of two, of which every second is at an odd distance.
        let (edges, kappa) = ([0.5, 0.4, 0.3], 9.0);
        let one = Images::new([Some(1), None, None], edges, kappa);
        let two = Images::new([Some(2), None, None], edges, kappa);
        let a = OffsetTable::repeated(edges, [1, 3, 3], &one, kappa, 1e-12);
        let b = OffsetTable::repeated(edges, [2, 3, 3], &two, kappa, 1e-12);
        for at in [[0, 0, 0], [0, 1, 0], [0, 2, 2]] {
            let sum = b.get(at).value + b.get([1, at[1], at[2]]).value;
            assert!((a.get(at).value / sum - 1.0).abs() < 4e-12, "{at:?}: {:?} {sum}", a.get(at));
        }
    }

    #[test]
    fn a_slab_closes() {
        // One cell wide both ways: the wall below sees voxels and the wall above, and nothing else.
        let (edges, kappa, n) = ([0.7, 1.1, 0.25], 1.5, 6);
        let images = Images::new([Some(1), Some(1), None], edges, kappa);
        let voxels = WallTable::repeated(edges, [1, 1, n], &[2], &images, kappa, 1e-12);
        let opposite = WallTable::repeated(edges, [1, 1, n], &[2, 2], &images, kappa, 1e-12);
        let gas: f64 = (0..n as i64).map(|k| kappa * voxels.get([0, 0, k]).value).sum();
        let all = gas + opposite.get([0, 0, 0]).value;
        assert!((all / (edges[0] * edges[1]) - 1.0).abs() < 1e-12, "{all}");
    }
}
