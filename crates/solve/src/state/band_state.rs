//! The solution of one band for given sources, with errors.

use super::band_system::{BandFactor, MatrixData};
use crate::errors::closure_error::error_of_fraction;

/// The equations of one band with their sources.
pub(super) struct BandProblem<'a> {
    pub m: MatrixData<'a>,
    pub factor: &'a BandFactor,
    /// d of each zone and its error, W/m²; empty without lights.
    pub light: [&'a [f64]; 2],
    /// Error of the powers of the lights, W.
    pub light_power_error: f64,
    /// s of each zone, W/m².
    pub sources: Vec<f64>,
    /// Radiosity of the surroundings, W/m².
    pub sky: f64,
}

/// The solution of one band.
pub(super) struct BandState {
    /// h and its error, W/m².
    pub incident: Vec<f64>,
    pub error: Vec<f64>,
    pub radiosity: Vec<f64>,
    /// Power from and to the surroundings by the zonal exchange, and to black backs, W; error of the escaping power with that of the lights.
    pub incoming: f64,
    pub escaped: f64,
    pub backfaces: f64,
    pub escaped_error: f64,
}

impl BandProblem<'_> {
    /// h without direct light of all zones for sources s, W/m², which are sent out in addition to what is reflected: (1/c) (I − F D)⁻¹ F s.
    pub(super) fn response(&self, sources: &[f64]) -> Vec<f64> {
        self.per_area(self.factor.solve(&self.m, self.m.apply(sources)))
    }

    /// x/c of each zone; 0 for a zone without exchange.
    fn per_area(&self, mut x: Vec<f64>) -> Vec<f64> {
        x.iter_mut().zip(self.m.c).for_each(|(x, c)| *x = if *c > 0.0 { *x / c } else { 0.0 });
        x
    }

    /// h without direct light of all zones, W/m².
    pub(super) fn reflected_incident(&self) -> Vec<f64> {
        let mut sources = self.sources.clone();
        let reflected = &self.factor.key.reflected;
        let lit = sources.iter_mut().zip(self.light[0]).zip(reflected);
        lit.for_each(|((s, d), r)| *s += r * d);
        let mut b = self.m.apply(&sources);
        b.iter_mut().zip(self.m.surroundings).for_each(|(b, s)| *b += s * self.sky);
        // `max` would drop a NaN.
        let positive = |x: f64| if x < 0.0 { 0.0 } else { x };
        let power = self.factor.solve(&self.m, b);
        self.per_area(power).into_iter().map(positive).collect()
    }

    /// The solution of the band.
    pub(super) fn solve(&self) -> BandState {
        let exchanged = self.reflected_incident();
        let mut incident = exchanged.clone();
        incident.iter_mut().zip(self.light[0]).for_each(|(h, d)| *h += d);
        let mut radiosity = self.sources.clone();
        let reflected = radiosity.iter_mut().zip(&self.factor.key.reflected).zip(&incident);
        reflected.for_each(|((b, r), h)| *b += r * h);
        let total = |areas: &[f64]| areas.iter().zip(&radiosity).map(|(f, b)| f * b).sum::<f64>();
        let squares = self.m.surroundings_radii.iter().zip(&radiosity).map(|(r, b)| (r * b).powi(2));
        BandState {
            incoming: self.m.surroundings.iter().map(|f| f * self.sky).sum(),
            escaped: total(self.m.surroundings),
            backfaces: total(self.m.backfaces),
            escaped_error: squares.sum::<f64>().sqrt().hypot(self.light_power_error),
            error: self.incident_errors(&exchanged, &radiosity),
            incident,
            radiosity,
        }
    }

    /// Errors of the incident flux with their reflection, W/m²; `exchanged` is the incident flux without direct light.
    fn incident_errors(&self, exchanged: &[f64], radiosity: &[f64]) -> Vec<f64> {
        let (m, n) = (&self.m, exchanged.len());
        let factors = m.factor_errors(radiosity);
        let own = |i: usize| {
            let closure = error_of_fraction(m.closure_error[i], m.c[i] * exchanged[i]);
            let light = self.light[1].get(i).map_or(0.0, |e| m.c[i] * e);
            (factors[i] + closure).hypot(m.surroundings_radii[i] * self.sky) + light
        };
        let mut errors: Vec<f64> = (0..n).map(own).collect();
        let diagonal = self.factor.diagonal();
        // An unknown error of a zone that reflects is unknown everywhere.
        if (0..n).any(|i| !errors[i].is_finite() && diagonal[i] > 0.0) {
            return vec![f64::INFINITY; n];
        }
        let sent: Vec<f64> =
            (0..n).map(|i| if diagonal[i] > 0.0 { diagonal[i] * errors[i] } else { 0.0 }).collect();
        let more = self.factor.solve(m, m.apply(&sent));
        errors.iter_mut().zip(more).for_each(|(e, more)| *e += more.abs());
        self.per_area(errors)
    }
}
