//! Report of a solve: method, convergence, closure, balances and error estimates.

use crate::bands::Bands;
use crate::bands::band::PerBand;
use crate::base::diagnostic::Diagnostic;
use crate::solution::energy_balance::EnergyBalance;
use crate::solution::heat_report::HeatReport;
use crate::solution::solve_status::SolveStatus;
use std::fmt::{Display, Formatter};
use zonal_math::Grade;

/// Defect of the closure relation Σ_j F_ij = A_i or 4 κ_i V_i, with the exchange to surroundings and back faces in the sum.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClosureDefect {
    /// Largest relative defect before restoration, a band.
    pub worst: Bands,
    /// Root mean square of the relative defect before restoration, a band.
    pub rms: Bands,
    /// Largest relative change of a factor by the restoration; zero without.
    pub largest_change: Bands,
    /// Largest relative defect after the restoration, a band.
    pub residual_defect: Bands,
    /// True if closure was restored.
    pub restored: bool,
}

impl ClosureDefect {
    /// Records that the incident flux of a light group was scaled by 1 + `change`, a band.
    pub fn record_normalization(&mut self, change: Bands) {
        self.largest_change = self.largest_change.max(change.abs());
        self.restored = true;
    }
}

/// Parts of the stated error of the zones of one kind, without unit: each over the root of the sum of squares of their incident radiation, in its worst band.
/// The parts are independent; the error is the root of the sum of their squares.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorParts {
    /// Sampling of the incident radiation; grade statistical.
    pub sampling: f64,
    /// Noise of the radiosities that the samples read, and the power by which the balance misses; grade statistical.
    pub radiosities: f64,
    /// Radiation of the surroundings, and reflected direct light; grade statistical.
    pub direct: f64,
    /// Light that is constant on zones; grade estimated. Of the rays engine it is direct light and textures, 0 where they are read at points; of the dense
    /// engine also light that surfaces near one another exchange.
    pub zoning: f64,
    /// The same error of zones whose direct light and textures are read at points, which removes it; 0 elsewhere.
    pub zoning_removed: f64,
}

impl ErrorParts {
    /// The larger of each part.
    #[must_use]
    pub fn max(self, other: ErrorParts) -> ErrorParts {
        ErrorParts {
            sampling: self.sampling.max(other.sampling),
            radiosities: self.radiosities.max(other.radiosities),
            direct: self.direct.max(other.direct),
            zoning: self.zoning.max(other.zoning),
            zoning_removed: self.zoning_removed.max(other.zoning_removed),
        }
    }
}

impl Display for ErrorParts {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let ErrorParts { sampling, radiosities, direct, zoning, zoning_removed } = *self;
        write!(f, "sampling {sampling:.1e}, radiosities {radiosities:.1e}, direct {direct:.1e}, ")?;
        if zoning_removed > 0.0 {
            write!(f, "zoning removed ({zoning_removed:.1e})")
        } else {
            write!(f, "zoning {zoning:.1e}")
        }
    }
}

/// Estimated error of a whole solution, a band: the root mean square of the estimated error of `incident` over that of `incident`, or the
/// same of the total incident flux (direct light included), whichever is larger.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorEstimate {
    /// Over the patches: of H.
    pub patches: Bands,
    /// Over voxel zones and pane zones: of G.
    pub volumes: Bands,
    /// Grade of the estimate.
    pub grade: Grade,
    /// Its parts for the patches, and for voxel zones and pane zones, where the engine tells them apart.
    pub parts: Option<[ErrorParts; 2]>,
}

/// Sums over zones of the squares of fields and of their errors, W²/m⁴.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SquareSums {
    /// Of the errors of the incident field without direct light.
    pub error: Bands,
    /// Of the incident field without direct light.
    pub incident: Bands,
    /// Of the errors of all incident light.
    pub total_error: Bands,
    /// Of all incident light.
    pub total: Bands,
}

impl ErrorEstimate {
    /// The parts of the patches, and of the volume zones and panes, the largest of several estimates; `None` where one of them has none.
    pub(crate) fn largest_parts<'a>(
        estimates: impl Iterator<Item = &'a ErrorEstimate>,
    ) -> Option<[ErrorParts; 2]> {
        let larger = |[a, b]: [ErrorParts; 2], [c, d]: [ErrorParts; 2]| [a.max(c), b.max(d)];
        estimates.map(|e| e.parts).reduce(|a, b| Some(larger(a?, b?)))?
    }

    /// The estimate from the sums over patches and over volume zones: the larger of the relative errors without and with direct light.
    ///
    /// ```
    /// use zonal_scene::{Bands, ErrorEstimate, SquareSums};
    /// let [error, value] = [1.0, 100.0].map(Bands::splat);
    /// let sums = SquareSums { error, incident: value, total_error: error, total: value };
    /// let estimate = ErrorEstimate::of_sums([sums, SquareSums::default()], zonal_math::Grade::Estimated);
    /// assert_eq!((estimate.patches, estimate.volumes), (Bands::splat(0.1), Bands::ZERO));
    /// ```
    pub fn of_sums(sums: [SquareSums; 2], grade: Grade) -> ErrorEstimate {
        let ratio = |e: Bands, h: Bands| e.zip_map(h, relative_error).sqrt();
        let [patches, volumes] = sums.map(|s| ratio(s.error, s.incident).max(ratio(s.total_error, s.total)));
        ErrorEstimate { patches, volumes, grade, parts: None }
    }
}

impl Default for ErrorEstimate {
    fn default() -> ErrorEstimate {
        ErrorEstimate { patches: Bands::ZERO, volumes: Bands::ZERO, grade: Grade::Estimated, parts: None }
    }
}

/// `error`/`value` of numbers from 0: 0 for 0/0, infinite for a positive error of 0 and for NaN.
fn relative_error(error: f64, value: f64) -> f64 {
    if error.is_nan() || value.is_nan() {
        f64::INFINITY
    } else if value > 0.0 {
        error / value
    } else if error == 0.0 {
        0.0
    } else {
        f64::INFINITY
    }
}

/// Discretization error, estimated from a second solve on zones about twice as large (Richardson's comparison). With Q of the given zones,
/// Q' of zones `ratio` times as large across, and an error that is proportional to the size of the zones or falls faster, the error of Q
/// is at most |Q − Q'|/(ratio − 1).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DiscretizationError {
    /// Number of zones of the second solve.
    pub zones: usize,
    /// Ratio of the zone sizes, above 1.
    pub ratio: f64,
    /// Errors of temperature (K) and net power (W) of each row of [`HeatReport`]; 0 for prescribed values, empty in light mode.
    pub heat: Vec<[f64; 2]>,
    /// Errors of the powers in [`Report::energy`], W per band; its residual is 0.
    pub energy: EnergyBalance,
    /// Zones that the estimate does not cover, and why.
    pub notes: Vec<Diagnostic>,
}

/// Report of a solve.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// The engine: `dense`, `rays` or `spectral`.
    pub engine: String,
    /// The reason for the choice of the engine.
    pub reason: String,
    /// Final status of the iteration, a band; the worst of all light groups.
    pub status: PerBand<SolveStatus>,
    /// Undistributed power before the first and after each iteration, relative to the power of the sources, a band.
    pub residuals: PerBand<Vec<f64>>,
    /// Estimated error of the whole solution.
    pub estimate: ErrorEstimate,
    /// Closure defect.
    pub closure: ClosureDefect,
    /// Energy balance.
    pub energy: EnergyBalance,
    /// Stated errors of the powers in `energy`, W per band: of the exchange, of direct light, of the solver, and the unexplained residual.
    /// Infinite where unknown; the residual is 0.
    pub energy_error: EnergyBalance,
    /// Temperatures and net powers by name; `None` in light mode.
    pub heat: Option<HeatReport>,
    /// Discretization error, if requested and available.
    pub discretization_error: Option<DiscretizationError>,
    /// Names and values of counters: pairs by method, rays, tables.
    pub counts: Vec<(String, u64)>,
    /// Notes and warnings: thick zones, open enclosures, dropped triangles.
    pub warnings: Vec<Diagnostic>,
    /// The weakest grade of the exchange areas used.
    pub grade: Grade,
}

impl Default for Report {
    fn default() -> Report {
        Report {
            engine: "dense".into(),
            reason: String::new(),
            status: PerBand::splat(SolveStatus::Converged),
            residuals: PerBand::default(),
            estimate: ErrorEstimate::default(),
            closure: ClosureDefect::default(),
            energy: EnergyBalance::default(),
            energy_error: EnergyBalance::default(),
            heat: None,
            discretization_error: None,
            counts: Vec::new(),
            warnings: Vec::new(),
            grade: Grade::Estimated,
        }
    }
}
