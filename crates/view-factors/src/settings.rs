//! Settings of a computation, and the error radii that follow from its tolerance.

use zonal_scene::SceneError;

/// Requested absolute radius of a factor, relative to the tolerance.
pub(crate) const ABSOLUTE_SHARE: f64 = 0.02;
/// Evaluations of the visible part for a pair, at most, in large meshes or at small tolerances.
const MIN_PAIR_LIMIT: f64 = 3e3;
/// The same for few facets, and the evaluations of all their pairs that it allows.
const MAX_PAIR_LIMIT: f64 = 3e4;
const ALL_PAIRS_LIMIT: f64 = 3e7;
/// Tolerance below which the limit of a pair falls in proportion: at the cost of many evaluations little is gained there.
const FULL_LIMIT_TOLERANCE: f64 = 1e-4;

/// Version of the stages: others are computed again.
const STAGE_VERSION: f64 = 3.0;

/// Whether rows are made to sum to one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RowClosing {
    /// Restore the sums by the smallest change, relative to the error radii, that keeps reciprocity.
    #[default]
    Restore,
    /// Leave the computed values.
    Keep,
}

/// Whether rays may leave the geometry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Openness {
    /// Facets see the sky and the space below the horizon where nothing hides them.
    #[default]
    Open,
    /// The facets form an enclosure: the surroundings are not computed, and rows are closed without them.
    Closed,
}

/// Settings of [`crate::ViewFactors::compute`].
#[derive(Clone, Debug)]
pub struct ViewFactorSettings {
    /// Tolerance τ, 0 < τ < 1: the requested radius of a factor F is max(τ F, τ/50), that of a sky factor 0.8 τ. A pair that cannot meet it has a
    /// larger stated radius. Default 1e-3.
    pub tolerance: f64,
    /// Row closure.
    pub closure: RowClosing,
    /// Whether sky and ground are computed.
    pub surroundings: Openness,
    /// Axis that points to the zenith: 0, 1 or 2. Default 2.
    pub up: usize,
    /// Periods along the two axes after `up` (cyclic), m: the geometry repeats without end. Default none.
    pub periods: [Option<f64>; 2],
    /// Largest memory of the results, bytes. Default 12 GB.
    pub memory_limit: u64,
}

impl Default for ViewFactorSettings {
    fn default() -> ViewFactorSettings {
        ViewFactorSettings {
            tolerance: 1e-3,
            closure: RowClosing::default(),
            surroundings: Openness::default(),
            up: 2,
            periods: [None; 2],
            memory_limit: 12_000_000_000,
        }
    }
}

impl ViewFactorSettings {
    pub(crate) fn check(&self) -> Result<(), SceneError> {
        if !(self.tolerance > 0.0 && self.tolerance < 1.0) {
            return Err(SceneError::new("tolerance", "give a number between 0 and 1"));
        }
        if self.up > 2 {
            return Err(SceneError::new("up", "give the axis 0, 1 or 2"));
        }
        if self.periods.iter().flatten().any(|p| !(*p > 0.0 && p.is_finite())) {
            return Err(SceneError::new("periods", "give positive lengths in metres"));
        }
        Ok(())
    }

    /// Numbers on which the stages of a computation depend.
    pub(crate) fn checkpoint_numbers(&self) -> [f64; 6] {
        let open = f64::from(u8::from(self.surroundings == Openness::Open));
        let [first, second] = self.periods.map(|p| p.unwrap_or(0.0));
        [STAGE_VERSION, self.tolerance, self.up as f64, first, second, open]
    }

    /// The goal of a pair among this number of facets.
    pub(crate) fn goal(&self, facets: usize) -> ErrorGoal {
        let absolute = ABSOLUTE_SHARE * self.tolerance;
        let share = (self.tolerance / FULL_LIMIT_TOLERANCE).min(1.0);
        let of_mesh = (ALL_PAIRS_LIMIT / (facets as f64).powi(2)).min(MAX_PAIR_LIMIT);
        let max_evaluations = (share * of_mesh).max(MIN_PAIR_LIMIT) as u64;
        ErrorGoal { relative: self.tolerance, absolute, max_evaluations }
    }

    /// The axes along which `periods` repeat.
    pub(crate) fn horizontal_axes(&self) -> [usize; 2] {
        [(self.up + 1) % 3, (self.up + 2) % 3]
    }
}

/// The requested radius of one factor 𝓕: max(`relative` 𝓕, `absolute` · the smaller area).
#[derive(Clone, Copy, Debug)]
pub(crate) struct ErrorGoal {
    pub relative: f64,
    pub absolute: f64,
    pub max_evaluations: u64,
}
