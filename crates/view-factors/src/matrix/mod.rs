//! Sparse symmetric exchange areas by rows.

pub(crate) mod closing;
pub(crate) mod image_sum;
pub(crate) mod pairs;

use zonal_math::{Bounded, Grade};

/// Exchange areas in m², rows sorted by column, both halves stored; the surroundings of each row apart.
#[derive(Clone, Debug)]
pub(crate) struct ExchangeRows {
    /// Index of the first entry of each row, and the number of all entries.
    pub starts: Vec<u64>,
    /// Column of each entry.
    pub columns: Vec<u32>,
    /// Value of each entry, m².
    pub values: Vec<f64>,
    /// Error radius of each entry, m².
    pub radii: Vec<f32>,
    /// Exchange with the directions above the horizon that meet nothing, m².
    pub sky: Vec<Bounded>,
    /// Exchange with the directions below the horizon that meet nothing, m².
    pub ground: Vec<Bounded>,
}

impl ExchangeRows {
    /// The rows of `n` facets from pairs (i, j), i ≠ j, in a fixed order; pairs that occur several times add up.
    pub(crate) fn new(n: usize, pairs: impl Iterator<Item = ((u32, u32), Bounded)> + Clone) -> ExchangeRows {
        let mut starts = vec![0u64; n + 1];
        for ((i, j), _) in pairs.clone() {
            starts[i as usize + 1] += 1;
            starts[j as usize + 1] += 1;
        }
        (0..n).for_each(|i| starts[i + 1] += starts[i]);
        let count = starts[n] as usize;
        let mut next = starts.clone();
        let (mut columns, mut values, mut radii) =
            (vec![0u32; count], vec![0.0f64; count], vec![0.0f32; count]);
        for ((i, j), b) in pairs {
            for (row, column) in [(i, j), (j, i)] {
                let at = next[row as usize] as usize;
                next[row as usize] += 1;
                (columns[at], values[at], radii[at]) =
                    (column, b.value, crate::matrix::pairs::round_up(b.radius));
            }
        }
        let empty = vec![Bounded::ZERO; n];
        let mut rows = ExchangeRows { starts, columns, values, radii, sky: empty.clone(), ground: empty };
        rows.sort_and_merge();
        rows
    }

    /// Sorts every row by column and adds equal ones.
    fn sort_and_merge(&mut self) {
        let mut write = 0;
        let mut scratch: Vec<(u32, f64, f32)> = Vec::new();
        for i in 0..self.starts.len() - 1 {
            let range = self.range(i);
            scratch.clear();
            scratch.extend(range.map(|k| (self.columns[k], self.values[k], self.radii[k])));
            // Stable: equal columns add in the order of the pairs, the same in both halves.
            scratch.sort_by_key(|e| e.0);
            self.starts[i] = write as u64;
            let first = write;
            for &(column, value, radius) in &scratch {
                if write > first && self.columns[write - 1] == column {
                    self.values[write - 1] += value;
                    self.radii[write - 1] = (self.radii[write - 1] + radius).next_up();
                } else {
                    (self.columns[write], self.values[write], self.radii[write]) = (column, value, radius);
                    write += 1;
                }
            }
            // The next row still begins where it stood; its start is replaced in its turn.
        }
        let n = self.starts.len() - 1;
        self.starts[n] = write as u64;
        self.columns.truncate(write);
        self.values.truncate(write);
        self.radii.truncate(write);
    }

    fn range(&self, i: usize) -> std::ops::Range<usize> {
        self.starts[i] as usize..self.starts[i + 1] as usize
    }

    /// Number of stored entries.
    pub(crate) fn len(&self) -> usize {
        self.columns.len()
    }

    /// The entries of row i: column and exchange area.
    pub(crate) fn entries(&self, i: usize) -> impl Iterator<Item = (usize, Bounded)> + '_ {
        self.range(i).map(|k| {
            let b =
                Bounded { value: self.values[k], radius: f64::from(self.radii[k]), grade: Grade::Estimated };
            (self.columns[k] as usize, b)
        })
    }

    /// Σ_j S_ij + surroundings, m².
    pub(crate) fn sum(&self, i: usize) -> f64 {
        self.values[self.range(i)].iter().sum::<f64>() + self.sky[i].value + self.ground[i].value
    }

    /// Σ of the radii of row i with its surroundings, m².
    pub(crate) fn sum_of_radii(&self, i: usize) -> f64 {
        let pairs: f64 = self.radii[self.range(i)].iter().map(|r| f64::from(*r)).sum();
        pairs + self.sky[i].radius + self.ground[i].radius
    }

    /// Changes every entry; the function must give the same for (i, j) and (j, i).
    pub(crate) fn change_pairs(&mut self, mut change: impl FnMut(usize, usize, &mut Bounded)) {
        for i in 0..self.starts.len() - 1 {
            for k in self.range(i) {
                let j = self.columns[k] as usize;
                let (value, radius) = (self.values[k], f64::from(self.radii[k]));
                let mut b = Bounded { value, radius, grade: Grade::Estimated };
                change(i.min(j), i.max(j), &mut b);
                self.values[k] = b.value;
                self.radii[k] = crate::matrix::pairs::round_up(b.radius);
            }
        }
    }

    /// Entries of column I × column J of a partition, added: rows of unions of facets.
    pub(crate) fn combined(&self, group: &[u32], groups: usize) -> ExchangeRows {
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); groups];
        group.iter().enumerate().for_each(|(i, g)| members[*g as usize].push(i));
        let mut made = ExchangeRows {
            starts: vec![0],
            columns: Vec::new(),
            values: Vec::new(),
            radii: Vec::new(),
            sky: vec![Bounded::ZERO; groups],
            ground: vec![Bounded::ZERO; groups],
        };
        for (g, rows) in members.iter().enumerate() {
            let mut sums: std::collections::BTreeMap<u32, Bounded> = std::collections::BTreeMap::new();
            for &i in rows {
                made.sky[g] = made.sky[g] + self.sky[i];
                made.ground[g] = made.ground[g] + self.ground[i];
                for (j, b) in self.entries(i) {
                    let sum = sums.entry(group[j]).or_insert(Bounded::ZERO);
                    *sum = *sum + b;
                }
            }
            for (column, b) in sums {
                made.columns.push(column);
                made.values.push(b.value);
                made.radii.push(crate::matrix::pairs::round_up(b.radius));
            }
            made.starts.push(made.columns.len() as u64);
        }
        made
    }
}
