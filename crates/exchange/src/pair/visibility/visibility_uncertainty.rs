//! Undetected partial occlusion of pairs whose visibility rays all agree.
//!
//! Facets reach into the hulls of many fully visible pairs: a wall that leans slightly, a lamp just below a ceiling. A sample of the pairs that
//! facets may divide is tested with the first rays. M of them are partly visible. If their visible fractions were uniform, each pair that n rays
//! find mixed would stand for (n + 1)/(n − 1) partly visible pairs, of which 1/(n − 1) appear free and as many hidden. So of U pairs that appear
//! free the fraction
//!
//! ```text
//! q = Σ_mixed 1/(n − 1) / U
//! ```
//!
//! is partly visible, each with the undetected fraction of the rule of succession (Laplace). √q times that fraction is the standard deviation of
//! the hidden part of such a pair.

use super::occlusion::{Occlusion, RayConsensus, RimVisibility};
use super::ray_samples::{FIRST_RAYS, PARTIAL_RAYS, PairPoints};
use crate::pair::prepared_zone::{PreparedZone, PreparedZones, is_behind, is_close};
use crate::pair::settings::PairSettings;
use zonal_math::low_discrepancy;

/// Pairs of a kind that are tested, at most.
const MAX_TESTED_PAIRS: usize = 1024;
/// Pairs that are drawn for these tests, at most; fewer where zones are few.
const MAX_DRAWN_PAIRS: usize = 1 << 16;

/// Pseudo-counts of the rule of succession: one ray on each side.
pub const SUCCESSION_PSEUDO_COUNTS: f64 = 2.0;

/// √q of pairs that appear free and of pairs that appear hidden, for distant and for close zones.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VisibilityUncertainty([[f64; 2]; 2]);

/// Rays of all tests of one kind of pairs.
#[derive(Clone, Copy, Default)]
struct TestCounts {
    tested: usize,
    /// Pairs that appear free, and pairs that appear hidden.
    agreed: [f64; 2],
    /// Σ 1/(n − 1) of the mixed pairs.
    overlooked: f64,
}

impl TestCounts {
    fn deviations(&self) -> [f64; 2] {
        // One more on both sides: without any mixed pair q is 1.
        self.agreed.map(|u| ((self.overlooked + 1.0) / (u + 1.0)).min(1.0).sqrt())
    }
}

impl VisibilityUncertainty {
    /// Tests a sample of pairs.
    pub(crate) fn sampled(
        zones: &PreparedZones,
        occlusion: &Occlusion,
        settings: &PairSettings,
    ) -> VisibilityUncertainty {
        if !occlusion.has_occluders {
            return VisibilityUncertainty([[1.0; 2]; 2]);
        }
        let (n, mut counts) = (zones.len(), [TestCounts::default(); 2]);
        let draw = |k: usize| (low_discrepancy::split_mix64(settings.seed(0, k)) % n as u64) as usize;
        for t in 0..MAX_DRAWN_PAIRS.min(n * n / 8) {
            let (i, j) = (draw(2 * t), draw(2 * t + 1));
            let (a, b) = (&*zones.get(i), &*zones.get(j));
            let kind = &mut counts[is_close(a, b) as usize];
            let apart = i != j && !is_behind(a, b) && !is_behind(b, a);
            if kind.tested >= MAX_TESTED_PAIRS || !apart || !occlusion.may_divide(a, b) {
                continue;
            }
            kind.tested += 1;
            let first = if is_close(a, b) { PARTIAL_RAYS } else { FIRST_RAYS };
            let points = PairPoints::new(settings.seed(i.max(j), i.min(j)));
            let [rays, blocked] = first_rays(occlusion, [a, b], &points, first);
            if blocked > 0 && blocked < rays {
                kind.overlooked += 1.0 / (rays - 1) as f64;
            } else if rays > 0 {
                kind.agreed[(blocked > 0) as usize] += 1.0;
            }
        }
        VisibilityUncertainty(counts.map(|c| c.deviations()))
    }

    /// √q of a pair by the consensus of its rays.
    pub(crate) fn deviation(&self, a: &PreparedZone, b: &PreparedZone, rays: RayConsensus) -> f64 {
        self.0[is_close(a, b) as usize][(rays == RayConsensus::Blocked) as usize]
    }
}

/// Number of the first rays and rim rays of a pair, and of the blocked ones among them.
fn first_rays(
    occlusion: &Occlusion,
    [a, b]: [&PreparedZone; 2],
    points: &PairPoints,
    first: usize,
) -> [u64; 2] {
    let rim = occlusion.rim_visibility(a, b);
    let hidden = |k: &usize| {
        let (x, y) = points.both(a, b, *k);
        occlusion.is_blocked(x, y)
    };
    [first as u64 + rim.rays, (0..first).filter(hidden).count() as u64 + rim.blocked]
}

/// The fraction that `n` rays of one consensus may leave undetected, by the rule of succession; rim rays count where they agree.
pub(crate) fn succession_bound(n: f64, rim: RimVisibility, consensus: RayConsensus) -> f64 {
    let more = if rim.disagrees(consensus) { 0 } else { rim.rays };
    1.0 / (n + more as f64 + SUCCESSION_PSEUDO_COUNTS)
}
