//! Smoothing of the sampled incident radiation by local linear regression with adaptive windows.
//!
//! The rays of one zone give a noisy value R_j; incident radiation varies little from a zone to the next. At zone i, over a window of
//! zones j,
//!
//! ```text
//! Σ_j (R_j − a − g·(x_j − x_i))² → min      a = Σ_j l_j R_j      e_a² = ē² Σ_j l_j²      ē² the mean of e_j² over the window
//! ```
//!
//! and a is the value. Windows grow; the widest is taken whose interval a ± Γ e_a still intersects those of all narrower windows and, with
//! a larger Γ, that of the zone's own rays (intersection of confidence intervals, Goldenshluger & Nemirovski). The weights l_j are the
//! same for all bands and light groups, so sums of columns remain sums.
//!
//! **Cost.** A few windows of up to 125 zones per zone.

use super::ray_table::IncidentEstimate;
use super::regression_windows::{RegressionWindow, RegressionWindows};
use rayon::prelude::*;
use zonal_scene::{Band, Bands, Scene, Zones};
use zonal_transport::Transport;

/// Widths of confidence intervals and factors of stated errors.
///
/// With these values the estimated error of the engine is 1.9 to 7.7 times the true one in the median of seven small scenes, and 97.5 to 100 % of the
/// zones lie within twice their own estimate (`cargo run --release --example against_dense -- c0 c9 c8 random1 random2 demo cornell
/// --dense 0.003`; `docs/hierarchical.md`).
pub(crate) struct SmoothingParams {
    /// Γ: half width of the interval of a window, in its standard errors.
    pub window_half_width: f64,
    /// Half width of the interval of the zone's own rays, in their standard errors.
    pub own_rays_half_width: f64,
    /// Undetected bias of a fit, as a share of the error of the next narrower window.
    pub undetected_bias_share: f64,
    /// Stated error over the computed one: covers the bias of fits and the error of the radiosities that the rays meet.
    pub stated_error_factor: f64,
}

/// The values in use.
pub(crate) const SMOOTHING_PARAMS: SmoothingParams = SmoothingParams {
    window_half_width: 0.5,
    own_rays_half_width: 2.0,
    undetected_bias_share: 0.35,
    stated_error_factor: 2.2,
};

/// Zones of one task.
const ZONES_PER_TASK: usize = 1024;

/// The window chosen for a zone.
struct ChosenWindow {
    /// `None` for the zone alone.
    window: Option<RegressionWindow>,
    error: Bands,
    /// Squares of the guide's error and value.
    guide_squares: [f64; 2],
}

/// The smoothed incident radiation.
pub(crate) struct SmoothedIncident {
    /// H or G of every column.
    pub columns: Vec<Vec<Bands>>,
    /// Stated error of the sum of the columns.
    pub error: Vec<Bands>,
    /// Relative error of the guide over patches, and over volume zones.
    pub guide_error: [f64; 2],
}

/// Smooths incident radiation over the zones of a scene.
pub(crate) struct Smoother<'a> {
    zones: &'a Zones,
    windows: RegressionWindows<'a>,
}

impl<'a> Smoother<'a> {
    /// Finds the neighbours of all zones.
    pub(crate) fn new(scene: &'a Scene, zones: &'a Zones, transport: &Transport) -> Smoother<'a> {
        Smoother { zones, windows: RegressionWindows::new(scene, zones, transport) }
    }

    /// Smooths `columns` over windows that are chosen by `guide`; `all` is the estimate of their sum.
    pub(crate) fn smooth(
        &self,
        guide: &[IncidentEstimate],
        all: &[IncidentEstimate],
        columns: &[Vec<Bands>],
    ) -> SmoothedIncident {
        let n = all.len();
        let mut squares = [[0.0; 2]; 2];
        let mut out: Vec<Vec<Bands>> = columns.iter().map(|_| vec![Bands::ZERO; n]).collect();
        let mut error = vec![Bands::ZERO; n];
        let done: Vec<Vec<(ChosenWindow, Vec<Bands>)>> = (0..n.div_ceil(ZONES_PER_TASK))
            .into_par_iter()
            .map(|task| {
                let range = task * ZONES_PER_TASK..((task + 1) * ZONES_PER_TASK).min(n);
                range.map(|i| self.smooth_zone(i, guide, all, columns)).collect()
            })
            .collect();
        let factor = SMOOTHING_PARAMS.stated_error_factor;
        for (i, (chosen, values)) in done.into_iter().flatten().enumerate() {
            error[i] = factor * chosen.error;
            let kind = &mut squares[usize::from(i >= self.zones.voxel_offset())];
            *kind = [kind[0] + chosen.guide_squares[0], kind[1] + chosen.guide_squares[1]];
            out.iter_mut().zip(values).for_each(|(o, v)| o[i] = v);
        }
        let guide_error = squares.map(|[e, v]| if v > 0.0 { factor * (e / v).sqrt() } else { 0.0 });
        SmoothedIncident { columns: out, error, guide_error }
    }

    /// Chooses the window of zone `i` and applies it to every column.
    fn smooth_zone(
        &self,
        i: usize,
        guide: &[IncidentEstimate],
        all: &[IncidentEstimate],
        columns: &[Vec<Bands>],
    ) -> (ChosenWindow, Vec<Bands>) {
        let chosen = self.choose_window(i, guide, all);
        let value = |c: &Vec<Bands>| {
            let Some(window) = &chosen.window else { return c[i].map(|v| v.max(0.0)) };
            let mut sum = Bands::ZERO;
            window.for_each(|j, l| sum += l * c[j]);
            sum.map(|v| v.max(0.0))
        };
        let values = columns.iter().map(value).collect();
        (ChosenWindow { window: None, ..chosen }, values)
    }

    /// The widest window of zone `i` whose interval intersects all narrower ones.
    fn choose_window(&self, i: usize, guide: &[IncidentEstimate], all: &[IncidentEstimate]) -> ChosenWindow {
        let guide_squares = [guide[i].error.sum().powi(2), guide[i].value.sum().powi(2)];
        let mut best = ChosenWindow { window: None, error: all[i].error, guide_squares };
        if i >= self.zones.pane_offset() {
            return best;
        }
        let mut narrower_error = best.error;
        // One interval for each band: differently coloured radiation differs in a single band.
        let mut interval = [f64::NEG_INFINITY, f64::INFINITY].map(Bands::splat);
        let mut first = true;
        for level in 0..self.windows.levels(i) {
            // Fit the guide over the window.
            let Some(window) = self.windows.window(i, level) else { continue };
            let (value, squared_weights) = fit(&window, guide);
            let noise = rms_error(&window, guide);
            let error = if std::ptr::eq(guide, all) { noise } else { rms_error(&window, all) };
            // Start from the interval of the zone's own rays.
            if first {
                let v = guide[i].value;
                interval = [-1.0, 1.0].map(|s| v + s * SMOOTHING_PARAMS.own_rays_half_width * noise);
                best.error = best.error.max(error);
                (narrower_error, first) = (best.error, false);
                // A zone none of whose rays meets light is dark: lit neighbours are separated from it.
                if v.sum() == 0.0 {
                    break;
                }
            }
            // Intersect the intervals; stop where the intersection is empty.
            let half = SMOOTHING_PARAMS.window_half_width * noise * squared_weights.sqrt();
            let [low, high] = interval;
            interval = [low.max(value - half), high.min(value + half)];
            if Band::all().any(|b| interval[0][b] > interval[1][b]) {
                break;
            }
            // Accept the window, with its noise and the undetected bias.
            let error = error * squared_weights.sqrt();
            let stated = error.hypot(SMOOTHING_PARAMS.undetected_bias_share * narrower_error);
            narrower_error = error;
            let guide_squares = [(noise.sum() * squared_weights.sqrt()).powi(2), value.sum().powi(2)];
            best = ChosenWindow { window: Some(window), error: stated, guide_squares };
        }
        best
    }
}

/// The fit of the guide at the centre of a window, and the sum of the squared weights.
fn fit(window: &RegressionWindow, guide: &[IncidentEstimate]) -> (Bands, f64) {
    let (mut value, mut squared_weights) = (Bands::ZERO, 0.0);
    window.for_each(|j, l| {
        value += l * guide[j].value;
        squared_weights += l * l;
    });
    (value, squared_weights)
}

/// Root mean square of the standard errors over a window.
fn rms_error(window: &RegressionWindow, estimates: &[IncidentEstimate]) -> Bands {
    let mut square = Bands::ZERO;
    window.for_each(|j, _| {
        let e = estimates[j].error;
        square += e * e;
    });
    (square / window.len() as f64).sqrt()
}
