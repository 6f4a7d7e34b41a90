//! Counts of a campaign of view factors, by kind and by tolerance.

use super::FactorCheck;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Share of the estimated radii that may be exceeded.
const MAX_EXCEEDED: f64 = 1e-3;
/// Ratio that no estimated radius may exceed.
const MAX_RATIO: f64 = 3.0;

/// Counts of some factors.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counts {
    pub factors: u64,
    pub sharp: u64,
    pub proved: u64,
    pub proved_exceeded: u64,
    pub estimated_exceeded: u64,
    pub threefold: u64,
    pub largest: f64,
}

impl Counts {
    fn add(&mut self, c: &FactorCheck) {
        let ratio = c.ratio();
        self.factors += 1;
        self.sharp += u64::from(c.is_sharp());
        self.proved += u64::from(c.proved);
        self.proved_exceeded += u64::from(c.proved && ratio > 1.0);
        self.estimated_exceeded += u64::from(!c.proved && ratio > 1.0);
        self.threefold += u64::from(!c.proved && ratio > MAX_RATIO);
        self.largest = self.largest.max(ratio);
    }

    fn row(&self, name: &str) -> String {
        format!(
            "| {name} | {} | {} | {} | {} | {} | {} | {:.2} |\n",
            self.factors,
            self.sharp,
            self.proved,
            self.proved_exceeded,
            self.estimated_exceeded,
            self.threefold,
            self.largest
        )
    }
}

/// Counts of a campaign.
#[derive(Clone, Debug, Default)]
pub(crate) struct Summary {
    pub all: Counts,
    by_kind: BTreeMap<String, Counts>,
    by_tolerance: BTreeMap<String, Counts>,
}

impl Summary {
    /// Counts all factors.
    pub(crate) fn new(checks: &[FactorCheck]) -> Summary {
        let mut s = Summary::default();
        for c in checks {
            s.all.add(c);
            s.by_kind.entry(c.kind.clone()).or_default().add(c);
            s.by_tolerance.entry(format!("{:.0e}", c.tolerance)).or_default().add(c);
        }
        s
    }

    /// True if all requirements hold.
    pub(crate) fn holds(&self) -> bool {
        let estimated = self.all.factors - self.all.proved;
        self.all.proved_exceeded == 0
            && self.all.threefold == 0
            && self.all.estimated_exceeded as f64 <= MAX_EXCEEDED * estimated as f64
    }

    /// Tables in Markdown.
    pub(crate) fn tables(&self) -> String {
        const HEAD: &str = "factors | reference sharp | proved | proved exceeded | estimated exceeded | threefold | largest ratio |\n|---|---:|---:|---:|---:|---:|---:|---:|\n";
        let verdict = if self.holds() { "pass" } else { "FAIL" };
        let mut t = format!(
            "No proved radius exceeded, at most 0.1 % of the estimated ones, none threefold: **{verdict}**\n\n"
        );
        let mut table = |title: &str, list: &BTreeMap<String, Counts>| {
            let _ = write!(t, "| {title} | {HEAD}");
            list.iter().rev().for_each(|(name, c)| t += &c.row(name));
            t += &self.all.row("all");
            t.push('\n');
        };
        table("tolerance", &self.by_tolerance);
        table("mesh", &self.by_kind);
        t
    }
}
