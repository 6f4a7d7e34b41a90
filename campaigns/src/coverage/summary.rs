//! Summary of a campaign with its verdicts.

use super::invariance::INVARIANCES;
use super::measure::VARIANTS;
use super::result::{Quantity, QuantityKind, SceneResult};
use std::collections::BTreeMap;

/// Shares of covered quantities, and errors.
#[derive(Clone, Debug, Default)]
pub(super) struct CoverageCounts {
    pub scenes: usize,
    pub names: usize,
    pub names_covered: usize,
    pub zones: usize,
    pub zones_covered: usize,
    pub unknown: usize,
    /// Beyond ten times the stated error, without and with a warning.
    pub far: [usize; 2],
}

impl CoverageCounts {
    fn add(&mut self, q: &Quantity) {
        let (all, covered) = match q.kind {
            QuantityKind::Name => (&mut self.names, &mut self.names_covered),
            QuantityKind::Zone => (&mut self.zones, &mut self.zones_covered),
        };
        *all += 1;
        *covered += usize::from(q.is_covered());
        self.unknown += usize::from(q.is_unknown());
        if q.is_far() {
            self.far[usize::from(q.warned)] += 1;
        }
    }
    /// A share in per cent.
    pub(super) fn percent(part: usize, of: usize) -> f64 {
        if of == 0 { 100.0 } else { 100.0 * part as f64 / of as f64 }
    }
}

/// Everything.
pub(super) struct CampaignSummary {
    pub all: CoverageCounts,
    pub by_engine: BTreeMap<&'static str, CoverageCounts>,
    pub by_feature: BTreeMap<&'static str, CoverageCounts>,
    /// Median of stated over true where the difference shows, and over how many.
    pub median: (f64, usize),
    /// Of each invariance: scenes, sums compared, unknown, broken.
    pub invariances: BTreeMap<&'static str, [usize; 4]>,
    /// Scenes that no engine took.
    pub refused: usize,
    pub failures: usize,
}

impl CampaignSummary {
    /// Of a campaign.
    pub(super) fn new(done: &[SceneResult]) -> CampaignSummary {
        let mut out = CampaignSummary {
            all: CoverageCounts::default(),
            by_engine: VARIANTS.iter().map(|v| (v.name, CoverageCounts::default())).collect(),
            by_feature: BTreeMap::new(),
            median: (f64::NAN, 0),
            invariances: INVARIANCES.iter().map(|w| (*w, [0; 4])).collect(),
            refused: 0,
            failures: 0,
        };
        let mut shares = Vec::new();
        for d in done {
            out.refused += usize::from(d.engines.is_empty());
            out.failures += d.failures.len();
            let features = || d.features.iter().copied();
            out.all.scenes += 1;
            d.engines.iter().for_each(|e| out.by_engine.entry(e).or_default().scenes += 1);
            features().for_each(|f| out.by_feature.entry(f).or_default().scenes += 1);
            for q in &d.quantities {
                out.all.add(q);
                out.by_engine.entry(q.engine).or_default().add(q);
                features().for_each(|f| out.by_feature.entry(f).or_default().add(q));
                // Proved errors are as large as their proof; named sums also have the estimated discretization error.
                if q.is_significant() && !q.is_unknown() && (q.kind == QuantityKind::Name || !q.proved) {
                    shares.push(q.stated / q.difference());
                }
            }
            if let Some(o) = &d.invariance {
                let line = out.invariances.entry(o.name).or_default();
                let more = [1, o.compared, o.unknown, o.broken.len()];
                (0..4).for_each(|k| line[k] += more[k]);
                out.failures += usize::from(o.failure.is_some());
            }
        }
        shares.sort_by(f64::total_cmp);
        if !shares.is_empty() {
            out.median = (shares[shares.len() / 2], shares.len());
        }
        out
    }

    /// Requirement, result and verdict.
    pub(super) fn verdicts(&self) -> Vec<(&'static str, String, bool)> {
        let a = &self.all;
        let names = CoverageCounts::percent(a.names_covered, a.names);
        let zones = CoverageCounts::percent(a.zones_covered, a.zones);
        let unknown = CoverageCounts::percent(a.unknown, a.names + a.zones);
        let broken: usize = self.invariances.values().map(|l| l[3]).sum();
        vec![
            ("sums by name covered: at least 99 %", format!("{names:.2} %"), names >= 99.0),
            ("zones covered by twice their error: at least 97 %", format!("{zones:.2} %"), zones >= 97.0),
            (
                "beyond ten times the stated error without a warning: none",
                a.far[0].to_string(),
                a.far[0] == 0,
            ),
            ("unknown errors: at most 2 %", format!("{unknown:.2} %"), unknown <= 2.0),
            (
                "median of stated over true, where the difference shows: at most 3",
                format!("{:.2} ({} quantities)", self.median.0, self.median.1),
                self.median.0.is_nan() || self.median.0 <= 3.0,
            ),
            (
                "sums that an invariance changes by more than the stated errors: none",
                broken.to_string(),
                broken == 0,
            ),
            ("solves that end with an error: none", self.failures.to_string(), self.failures == 0),
        ]
    }
}
