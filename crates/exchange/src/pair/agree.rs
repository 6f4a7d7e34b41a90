//! What pairs may hide whose rays all agree.
//!
//! Facets reach into the hulls of many pairs that are seen in full: where a wall leans by a hair, or a lamp hangs a hair below a ceiling. Of the
//! pairs of a scene that facets may divide, a sample is looked at with the first rays. M of them are seen in part; were the
//! shares of these uniform, then for each that n rays find mixed, (n + 1)/(n − 1) would be partly seen and 1/(n − 1) look free, and as many
//! hidden. So of U pairs that look free the share
//!
//! ```text
//! q = Σ_mixed 1/(n − 1) / U
//! ```
//!
//! is seen in part in truth, each with the missed share of the rule of succession, and √q times that is the standard deviation of what such
//! a pair hides.

use super::Exchange;
use super::rays::{FIRST_RAYS, MORE_RAYS};
use super::zone::{Zone, behind, is_close};
use zonal_math::sequence;

/// Pairs of a kind that are looked at, at most.
const LOOKS: usize = 1024;
/// Pairs that are drawn for that, at most; fewer where zones are few.
const DRAWS: usize = 1 << 16;

/// √q of pairs that look free and of pairs that look hidden, for zones apart and for close ones.
#[derive(Clone, Copy, Debug)]
pub(super) struct Agreement([[f64; 2]; 2]);

impl Default for Agreement {
    fn default() -> Agreement {
        Agreement([[1.0; 2]; 2])
    }
}

impl Agreement {
    /// √q of a pair.
    pub fn doubt(&self, a: &Zone, b: &Zone, blocked: bool) -> f64 {
        self.0[is_close(a, b) as usize][blocked as usize]
    }
}

/// What the looks at one kind of pairs found.
#[derive(Clone, Copy, Default)]
struct Found {
    looks: usize,
    /// Pairs that look free, and those that look hidden.
    agreed: [f64; 2],
    /// Σ 1/(n − 1) of the mixed ones.
    overlooked: f64,
}

impl Found {
    fn doubts(&self) -> [f64; 2] {
        // One more on both sides: with nothing found, q is 1.
        self.agreed.map(|u| ((self.overlooked + 1.0) / (u + 1.0)).min(1.0).sqrt())
    }
}

impl Exchange<'_> {
    /// Looks at a sample of pairs.
    pub(super) fn agreement(&self) -> Agreement {
        if !self.occluders {
            return Agreement::default();
        }
        let (n, mut found) = (self.zones.len(), [Found::default(); 2]);
        let draw = |k: usize| (sequence::hash(self.settings.seed(0, k)) % n as u64) as usize;
        for t in 0..DRAWS.min(n * n / 8) {
            let (i, j) = (draw(2 * t), draw(2 * t + 1));
            let (a, b) = (&*self.items.get(i), &*self.items.get(j));
            let kind = &mut found[is_close(a, b) as usize];
            let apart = i != j && !behind(a, b) && !behind(b, a);
            if kind.looks >= LOOKS || !apart || !self.may_divide(a, b) {
                continue;
            }
            kind.looks += 1;
            let first = if is_close(a, b) { MORE_RAYS } else { FIRST_RAYS };
            let [rays, blocked] = self.first_look(a, b, self.settings.seed(i.max(j), i.min(j)), first);
            if blocked > 0 && blocked < rays {
                kind.overlooked += 1.0 / (rays - 1) as f64;
            } else if rays > 0 {
                kind.agreed[(blocked > 0) as usize] += 1.0;
            }
        }
        Agreement(found.map(|f| f.doubts()))
    }
}
