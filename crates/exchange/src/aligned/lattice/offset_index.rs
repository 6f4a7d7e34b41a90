//! The position of an offset in a table, up to the symmetries of the cell.

/// Offsets folded by the symmetries and numbered: place = plane[s₀] + line[s₁] + s₂ with s the stored offset, whose
/// components are sorted where axes are alike.
#[derive(Clone, Debug)]
pub(super) struct OffsetIndex {
    /// The axis of each stored component.
    axes: [usize; 3],
    /// Number of the last components that are sorted in descending order: 1, 2 or 3.
    alike: usize,
    /// Counts of the stored components.
    counts: [usize; 3],
    plane: Vec<usize>,
    line: Vec<usize>,
    len: usize,
}

impl OffsetIndex {
    /// For cells with these edges: axes with equal edges are alike.
    pub(super) fn of_edges(edges: [f64; 3], counts: [usize; 3]) -> OffsetIndex {
        let [x, y, z] = edges;
        if x == y && y == z {
            OffsetIndex::new([0, 1, 2], 3, counts)
        } else {
            match (0..3).find(|&k| edges[(k + 1) % 3] == edges[(k + 2) % 3]) {
                Some(odd) => OffsetIndex::with_odd_axis(odd, [edges[(odd + 1) % 3]; 2], counts),
                None => OffsetIndex::new([0, 1, 2], 1, counts),
            }
        }
    }

    /// No two axes alike.
    pub(super) fn plain(counts: [usize; 3]) -> OffsetIndex {
        OffsetIndex::new([0, 1, 2], 1, counts)
    }

    /// The axis `odd` is distinct; the other two are alike where their edges are equal.
    pub(super) fn with_odd_axis(odd: usize, edges: [f64; 2], counts: [usize; 3]) -> OffsetIndex {
        let alike = if edges[0] == edges[1] { 2 } else { 1 };
        OffsetIndex::new([odd, (odd + 1) % 3, (odd + 2) % 3], alike, counts)
    }

    fn new(axes: [usize; 3], alike: usize, counts: [usize; 3]) -> OffsetIndex {
        assert!(counts.iter().all(|n| (1..=u16::MAX as usize).contains(n)), "counts {counts:?}");
        let mut n = axes.map(|k| counts[k]);
        n[3 - alike..].sort_by(|a, b| b.cmp(a));
        let mut index = OffsetIndex { axes, alike, counts: n, plane: vec![], line: vec![], len: 0 };
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

    /// Number of values of the component s₂ for a given s₁.
    fn last(&self, s1: usize) -> usize {
        if self.alike > 1 { self.counts[2].min(s1 + 1) } else { self.counts[2] }
    }
    /// Number of values of the component s₁ for a given s₀.
    fn middle(&self, s0: usize) -> usize {
        if self.alike > 2 { self.counts[1].min(s0 + 1) } else { self.counts[1] }
    }

    /// All stored offsets in the order of their positions, components by axis.
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
    /// On an offset outside the table.
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
