//! What was found on a scene.

/// Kind of a quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum QuantityKind {
    /// A sum by name: power absorbed, net power, temperature.
    #[default]
    Name,
    /// H or G, temperature or net power of a zone.
    Zone,
}

/// A quantity of a scene beside its reference.
#[derive(Clone, Debug, Default)]
pub(super) struct Quantity {
    /// Engine and basis.
    pub engine: &'static str,
    pub kind: QuantityKind,
    /// Name.
    pub what: String,
    pub value: f64,
    pub stated: f64,
    pub truth: f64,
    pub sigma: f64,
    /// True where the grade of the exchange is proved.
    pub proved: bool,
    /// True where the report warns of something.
    pub warned: bool,
}

/// A quantity is far off beyond this many stated errors plus [`FAR_STANDARD_ERRORS`] of the reference.
const FAR_STATED_ERRORS: f64 = 10.0;
/// Standard errors of the reference that are granted besides: of some hundred thousand quantities whose stated error is negligible a few are
/// beyond 3σ by chance.
const FAR_STANDARD_ERRORS: f64 = 6.0;

impl Quantity {
    /// |difference|.
    pub(super) fn difference(&self) -> f64 {
        (self.value - self.truth).abs()
    }
    /// True where no error is stated.
    pub(super) fn is_unknown(&self) -> bool {
        !self.stated.is_finite()
    }
    /// Largest covered difference: the stated error and 3σ of the reference, of zones twice the stated error.
    pub(super) fn limit(&self) -> f64 {
        let times = if self.kind == QuantityKind::Name { 1.0 } else { 2.0 };
        times * self.stated + 3.0 * self.sigma
    }
    /// True if the stated error covers the difference.
    pub(super) fn is_covered(&self) -> bool {
        !self.is_unknown() && self.difference() <= self.limit()
    }
    /// Beyond ten times the stated error.
    pub(super) fn is_far(&self) -> bool {
        !self.is_unknown()
            && self.difference() > FAR_STATED_ERRORS * self.stated + FAR_STANDARD_ERRORS * self.sigma
    }
    /// True where the difference exceeds the noise of the reference.
    pub(super) fn is_significant(&self) -> bool {
        self.difference() > 3.0 * self.sigma
    }
}

/// Result of comparing a scene with its other form.
#[derive(Clone, Debug, Default)]
pub(super) struct InvarianceOutcome {
    pub name: &'static str,
    pub compared: usize,
    pub unknown: usize,
    /// Sums on which both forms disagree, in words.
    pub broken: Vec<String>,
    pub failure: Option<String>,
}

/// A scene and what was found.
#[derive(Clone, Debug, Default)]
pub(super) struct SceneResult {
    pub index: u64,
    pub features: Vec<&'static str>,
    /// Engines that applied.
    pub engines: Vec<&'static str>,
    pub quantities: Vec<Quantity>,
    pub invariance: Option<InvarianceOutcome>,
    /// Errors, as text.
    pub failures: Vec<String>,
}

impl SceneResult {
    /// Sums by name that are not covered, and zones that are not by twice their error.
    fn missed(&self) -> impl Iterator<Item = &Quantity> {
        self.quantities.iter().filter(|q| !q.is_unknown() && !q.is_covered())
    }

    /// True where something is wrong.
    pub(super) fn failed(&self) -> bool {
        self.missed().next().is_some()
            || !self.failures.is_empty()
            || self.invariance.as_ref().is_some_and(|o| !o.broken.is_empty() || o.failure.is_some())
    }

    /// Failures, a line each.
    pub(super) fn complaints(&self) -> Vec<String> {
        let missed = self.missed().take(12).map(|q| {
            let Quantity { engine, what, value, stated, truth, sigma, .. } = q;
            let (off, warned) = (q.difference(), if q.warned { " (warned)" } else { "" });
            format!(
                "{engine}: {what} = {value:.6e} ± {stated:.1e}, reference {truth:.6e}, σ {sigma:.1e}, off by {off:.1e}{warned}"
            )
        });
        let unknown: Vec<&Quantity> = self.quantities.iter().filter(|q| q.is_unknown()).collect();
        let more = unknown.len().saturating_sub(1);
        let unknown =
            unknown.first().map(|q| format!("{}: {} and {more} more are unknown", q.engine, q.what));
        let mut lines: Vec<String> = missed.chain(unknown).chain(self.failures.iter().cloned()).collect();
        if let Some(o) = &self.invariance {
            lines.extend(o.failure.iter().chain(o.broken.iter().take(6)).map(|b| format!("{}, {b}", o.name)));
        }
        lines.iter().map(|line| format!("scene {}, {line}", self.index)).collect()
    }
}
