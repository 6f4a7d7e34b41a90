//! Groups of patches that share one radiosity.
//!
//! A patch is never larger than its facet, so that the patches of a fine mesh cannot grow. For a solve on larger zones, patches of neighbouring facets are
//! merged: with the areas A_i of the patches of a group and A = Σ A_i, every patch sends out the mean B = Σ A_i B_i / A, and receives A_i/A of the power that
//! arrives on the group. Exchange areas are additive, so that the equations of the groups are those of larger zones of the same geometry.

/// Groups of patches; patches without a group keep their own radiosity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MergedPatches {
    groups: Vec<Vec<u32>>,
}

impl MergedPatches {
    /// Groups of indices of patches; no patch is in two of them.
    #[must_use]
    pub fn new(groups: Vec<Vec<u32>>) -> MergedPatches {
        MergedPatches { groups }
    }

    /// True if no patches are merged.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// The patches of each group.
    #[must_use]
    pub fn groups(&self) -> &[Vec<u32>] {
        &self.groups
    }

    /// Number of zones that the merging removes.
    #[must_use]
    pub fn removed(&self) -> usize {
        self.groups.iter().map(|g| g.len().saturating_sub(1)).sum()
    }

    /// The same groups in `count` images of `patches` patches each.
    #[must_use]
    pub(crate) fn repeated(&self, count: usize, patches: usize) -> MergedPatches {
        let moved = |image: usize| {
            let shift = (image * patches) as u32;
            self.groups.iter().map(move |g| g.iter().map(|i| i + shift).collect())
        };
        MergedPatches { groups: (0..count).flat_map(moved).collect() }
    }
}
