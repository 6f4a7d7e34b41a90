//! Random coverage of view factors: stated radii against true errors.
//!
//! ```text
//! coverage --view-factors N --seed S [--tolerance T]… [--index K] [--page FILE.md]
//! ```
//!
//! N random meshes in turn of every kind (`zonal_reference::random_meshes`), at each tolerance. Meshes in space have the reference
//! `zonal_reference::visible_views` (exact views from points, integrated adaptively, with an error of its own; the rows of two facets check each other), cross-sections that repeat along their
//! axis have crossed strings, exact to rounding. A factor **exceeds** its radius if |difference| > radius + error of the reference. A factor that
//! is left out counts as zero with the radius that the documentation states. With `--index`, mesh K alone, each factor a line.
//!
//! Requirements: no proved radius exceeded; at most 0.1 % of the estimated ones, none threefold.

mod compare;
mod summary;

pub(crate) use compare::{CampaignCase, FactorCheck, check};
pub(crate) use summary::Summary;

use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The tolerances of a campaign.
pub(crate) const TOLERANCES: [f64; 5] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7];

/// A campaign.
#[derive(Clone, Debug)]
pub(crate) struct FactorCampaign {
    pub meshes: u64,
    pub seed: u64,
    pub tolerances: Vec<f64>,
    /// One mesh alone.
    pub only: Option<u64>,
}

impl FactorCampaign {
    /// Runs all meshes; results in their order. `told` receives the number of finished meshes.
    pub(crate) fn run(&self, told: impl Fn(usize) + Sync) -> Vec<FactorCheck> {
        let cases: Vec<CampaignCase> = self
            .only
            .map_or(0..self.meshes, |k| k..k + 1)
            .map(|index| CampaignCase::new(self.seed, index))
            .collect();
        let finished = AtomicUsize::new(0);
        let one = |c: &CampaignCase| {
            let checks = check(c, &self.tolerances);
            told(finished.fetch_add(1, Ordering::Relaxed) + 1);
            checks
        };
        cases.par_iter().with_max_len(1).map(one).collect::<Vec<_>>().concat()
    }
}

/// The page of a campaign.
pub(crate) fn page(campaign: &FactorCampaign, tables: &str) -> String {
    let (n, seed) = (campaign.meshes, campaign.seed);
    format!(
        "# View factors: stated against true errors\n\n\
        Written by\n\n<!-- test: skip: it takes an hour of processor time -->\n\n    cargo run --release -p zonal-validation --example coverage -- --view-factors {n} --seed {seed} --page docs/coverage-view-factors.md\n\n\
        {n} random meshes, each at several tolerances. Meshes in space are compared with exact views from points, integrated adaptively over each facet; where the integrals over two\n\
        facets contradict each other, the errors of both contain the difference. Cross-sections that repeat along their axis are compared with crossed strings. The reference of meshes in space serves down to 1e-4, that of empty rooms to 1e-7; cross-sections as triangles, which take long,\n\
        are computed below 1e-4 in one turn of five. A radius is *exceeded* if the difference is larger than the radius and the error of the\n\
        reference together; *threefold* means three radii and that error. The reference is *sharp* if its error is at most the radius, or 2 % of the tolerance. A factor that is left out counts as zero\n\
        with the radius T/500 of the smaller facet.\n\n{tables}"
    )
}
