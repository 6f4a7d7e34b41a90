//! How long work tells where it stands, without knowing who listens.

/// A listener to long work. Calls come from any thread; implementations must be cheap.
pub trait Progress: Sync {
    /// A stage begins that will take `total` steps.
    fn begin(&self, stage: &str, total: u64);
    /// `steps` more steps are done.
    fn advance(&self, steps: u64);
    /// The stage is over.
    fn end(&self);
}

/// Nobody listens.
pub struct Quiet;

impl Progress for Quiet {
    fn begin(&self, _: &str, _: u64) {}
    fn advance(&self, _: u64) {}
    fn end(&self) {}
}
