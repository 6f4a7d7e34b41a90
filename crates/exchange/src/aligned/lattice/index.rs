//! From an offset to its place in a table.

/// Offsets folded by the symmetries and numbered: place = plane[s₀] + line[s₁] + s₂ with s the stored offset, whose
/// components are sorted where axes are alike.
#[derive(Clone, Debug)]
pub(super) struct Index {
    /// The axis of each stored component.
    axes: [usize; 3],
    /// How many of the last components are sorted, downwards: 1, 2 or 3.
    alike: usize,
    /// Counts of the stored components.
    counts: [usize; 3],
    plane: Vec<usize>,
    line: Vec<usize>,
    len: usize,
}

impl Index {
    /// For cells with these edges: axes with equal edges are alike.
    pub(super) fn of_edges(edges: [f64; 3], counts: [usize; 3]) -> Index {
        let [x, y, z] = edges;
        if x == y && y == z {
            Index::new([0, 1, 2], 3, counts)
        } else {
            match (0..3).find(|&k| edges[(k + 1) % 3] == edges[(k + 2) % 3]) {
                Some(odd) => Index::odd(odd, true, counts),
                None => Index::new([0, 1, 2], 1, counts),
            }
        }
    }

    /// No two axes alike.
    pub(super) fn plain(counts: [usize; 3]) -> Index {
        Index::new([0, 1, 2], 1, counts)
    }

    /// The axis `odd` apart, the other two alike or not.
    pub(super) fn odd(odd: usize, alike: bool, counts: [usize; 3]) -> Index {
        Index::new([odd, (odd + 1) % 3, (odd + 2) % 3], if alike { 2 } else { 1 }, counts)
    }

    fn new(axes: [usize; 3], alike: usize, counts: [usize; 3]) -> Index {
        assert!(counts.iter().all(|n| (1..=u16::MAX as usize).contains(n)), "counts {counts:?}");
        let mut n = axes.map(|k| counts[k]);
        n[3 - alike..].sort_by(|a, b| b.cmp(a));
        let mut index = Index { axes, alike, counts: n, plane: vec![], line: vec![], len: 0 };
        let mut lines = 0;
        for s1 in 0..n[1] {
            index.line.push(lines);
            lines += index.last(s1);
        }
        index.line.push(lines);
        for s0 in 0..n[0] {
            index.plane.push(index.len);
            index.len += index.line[index.middle(s0)];
        }
        index
    }

    /// How many values the component s₂ has beside s₁.
    fn last(&self, s1: usize) -> usize {
        if self.alike > 1 { self.counts[2].min(s1 + 1) } else { self.counts[2] }
    }
    /// How many values the component s₁ has beside s₀.
    fn middle(&self, s0: usize) -> usize {
        if self.alike > 2 { self.counts[1].min(s0 + 1) } else { self.counts[1] }
    }

    /// All kept offsets in the order of their places, components by axis.
    pub(super) fn offsets(&self) -> Vec<[u16; 3]> {
        let mut out = Vec::with_capacity(self.len);
        for s0 in 0..self.counts[0] {
            for s1 in 0..self.middle(s0) {
                for s2 in 0..self.last(s1) {
                    let mut offset = [0; 3];
                    for (k, s) in self.axes.into_iter().zip([s0, s1, s2]) {
                        offset[k] = s as u16;
                    }
                    out.push(offset);
                }
            }
        }
        out
    }

    /// The place of an offset.
    ///
    /// # Panics
    /// On an offset that the table does not hold.
    pub(super) fn place(&self, offset: [i64; 3]) -> usize {
        let mut s = self.axes.map(|k| offset[k].unsigned_abs() as usize);
        let swap = |s: &mut [usize; 3], i: usize, j: usize| {
            if s[i] < s[j] {
                s.swap(i, j);
            }
        };
        if self.alike > 1 {
            swap(&mut s, 1, 2);
        }
        if self.alike > 2 {
            swap(&mut s, 0, 1);
            swap(&mut s, 1, 2);
        }
        assert!((0..3).all(|k| s[k] < self.counts[k]), "offset {offset:?} outside of the table");
        self.plane[s[0]] + self.line[s[1]] + s[2]
    }
}
