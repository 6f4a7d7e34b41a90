//! The position of an offset in a table, up to the symmetries of the cell.

use std::ops::Range;

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

    /// The index of the same places by offsets whose axis `k` is axis `turn[k]` of this index.
    pub(super) fn turned(&self, turn: [usize; 3]) -> OffsetIndex {
        let axis_of = |own: usize| turn.iter().position(|t| *t == own).unwrap_or(own);
        OffsetIndex { axes: self.axes.map(axis_of), ..self.clone() }
    }

    /// Number of stored offsets.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// The stored offsets at some positions, components by axis.
    pub(super) fn offsets(&self, places: Range<usize>) -> Vec<[u16; 3]> {
        let mut out = Vec::with_capacity(places.len());
        // The last plane and the last line that begin at or before the first place.
        let mut s0 = self.plane.partition_point(|first| *first <= places.start).saturating_sub(1);
        let rest = places.start - self.plane[s0];
        let mut s1 = self.line.partition_point(|first| *first <= rest).saturating_sub(1);
        let mut s2 = rest - self.line[s1];
        while out.len() < places.len() {
            if s2 == self.last(s1) {
                (s1, s2) = (s1 + 1, 0);
            }
            if s1 == self.middle(s0) {
                (s0, s1) = (s0 + 1, 0);
            }
            let mut offset = [0; 3];
            for (k, s) in self.axes.into_iter().zip([s0, s1, s2]) {
                offset[k] = s as u16;
            }
            out.push(offset);
            s2 += 1;
        }
        out
    }

    /// The place of an offset.
    ///
    /// # Panics
    /// On an offset outside the table.
    #[inline]
    pub(super) fn place(&self, offset: [i64; 3]) -> usize {
        let [a, b, c] = self.axes.map(|k| offset[k].unsigned_abs() as usize);
        let (high, low) = (b.max(c), b.min(c));
        let s = match self.alike {
            1 => [a, b, c],
            2 => [a, high, low],
            _ => [a.max(high), low.max(a.min(high)), a.min(low)],
        };
        assert!((0..3).all(|k| s[k] < self.counts[k]), "offset {offset:?} outside of the table");
        self.plane[s[0]] + self.line[s[1]] + s[2]
    }
}
