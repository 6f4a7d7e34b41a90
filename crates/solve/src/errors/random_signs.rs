//! Reflected errors that are independent from zone to zone.
//!
//! With δ the error of the field of a zone and L a product with the exchange areas, for one reflection or for all of them, the reflected light errs by L(cρδ)
//! if all errors have one sign. Random signs ε = ±1 give L(cρεδ), whose mean square over zones and draws is that of the error of independent δ. With r the
//! ratio of the root mean squares of both over a kind of zones (patches, volumes),
//!
//! ```text
//!     e = min( L(cρδ), max( rms over draws of L(cρεδ), 2 r L(cρδ) ) )
//! ```
//!
//! Cost: one product for each draw.

use crate::distribution::multivector;
use zonal_exchange::pair::scaled_radiosity_coefficient;
use zonal_math::low_discrepancy;
use zonal_math::parallel;
use zonal_scene::{Bands, Zones};

/// Number of draws of signs; one for more than [`MAX_ZONES_FOR_DRAWS`] zones.
const SIGN_DRAWS: usize = 2;
const MAX_ZONES_FOR_DRAWS: usize = 100_000;
/// Bound of the error of a zone in multiples of the standard error.
pub(crate) const ERROR_MULTIPLE: f64 = 2.0;

/// The reflection of the errors of a field.
pub(crate) struct ErrorReflection<'a> {
    pub zones: &'a Zones,
    /// Unknowns of the product, zones first.
    pub unknowns: usize,
    /// δ, W/m².
    pub error: &'a [Bands],
    /// L: incident powers for the strengths of the unknowns.
    pub reflect: &'a dyn Fn(Vec<Bands>) -> Vec<Bands>,
}

impl ErrorReflection<'_> {
    /// |L(cρεδ)| over A or V, W/m², with equal signs for draw 0.
    pub(crate) fn of_draw(&self, draw: u64) -> Vec<Bands> {
        let (zones, n) = (self.zones, self.zones.len());
        let mut s: Vec<Bands> = parallel::collect(n, |i| {
            let signed = |k: usize| {
                let is_negative = draw > 0 && low_discrepancy::split_mix64(draw << 48 | k as u64) & 1 == 1;
                if is_negative { -self.error[k] } else { self.error[k] }
            };
            scaled_radiosity_coefficient(zones, i) * zones.scattered(i, signed)
        });
        s.resize(self.unknowns, Bands::ZERO);
        let mut p = (self.reflect)(s);
        p.truncate(n);
        parallel::for_each(&mut p, |i, p| *p = p.abs() / zones.response(i).1);
        p
    }

    /// Limits the errors `first` of equal signs by draws of random signs (module header).
    pub(crate) fn limit_by_random_signs(&self, first: &mut [Bands]) {
        let (zones, n) = (self.zones, self.zones.len());
        let draws = if n > MAX_ZONES_FOR_DRAWS { 1 } else { SIGN_DRAWS };
        let mut mean = vec![Bands::ZERO; n];
        for k in 1..=draws {
            let one = self.of_draw(k as u64);
            parallel::for_each_pair(&mut mean, &one, |m, x| *m += x * x / draws as f64);
        }
        for range in [0..zones.patches.len(), zones.patches.len()..n] {
            let start = range.start;
            let [means, squares]: [Bands; 2] = multivector::sum(range.len(), |k| {
                let (m, l) = (mean[start + k], first[start + k]);
                [m, l * l]
            });
            let ratio = means.zip_map(squares, |m, l| if l > 0.0 { (m / l).sqrt() } else { 0.0 });
            parallel::for_each(&mut first[range], |k, l| {
                let m = mean[start + k];
                *l = l.min(m.sqrt().max(ERROR_MULTIPLE * ratio * *l));
            });
        }
    }
}
