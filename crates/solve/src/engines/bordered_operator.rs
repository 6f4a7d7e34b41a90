//! Exchange of a box on the grid of its medium with patches beyond its sides.
//!
//! A patch beyond a side of the box stands in no path between zones of the box, which is convex. Their exchange is a convolution still ([`crate::engines::spectral`]), and
//! each patch o outside adds a row of factors of its own, computed as by the dense engine:
//!
//! ```text
//!     P_i = Σ_j∈box g_ij s_j + Σ_o g_io s_o,         P_o = Σ_j g_oj s_j.
//! ```
//!
//! A zone of the box loses what leaves through the openings, which the convolution has, less its exchange with the patches outside; a patch outside loses the
//! rest of its row. Rows so close to rounding, however few rays the sampled factors have, and a uniform field stays uniform. No zone sees the black back of a
//! surface ([`crate::engines::spectral::enclosure`]).
//!
//! **Error.** That of the convolution, plus e_i = √(Σ_o (r_io s_o)²) with the error radii r of the added factors, which are independent.
//!
//! **Cost.** m n factors for m patches outside and n zones, 28 bytes each; a product of 2 m n operations beside that of the convolution.

use crate::context::SolveContext;
use crate::distribution::multivector::times_scaling;
use crate::engines::spectral::SpectralOperator;
use crate::operator::{ErrorModel, ExchangeOperator};
use crate::right_hand_side::surroundings::SurroundingsExchange;
use zonal_exchange::pair::{Exchange, PairCounts, closure_target, scaled_radiosity_coefficient};
use zonal_math::Grade;
use zonal_math::parallel;
use zonal_scene::{Bands, Zones};

/// The exchange of a box and of patches outside it.
pub(crate) struct BorderedOperator<'a> {
    /// The exchange within the box, of constants alone; it leaves the strengths of the patches outside as they are.
    inner: SpectralOperator<'a>,
    /// The patches outside, in ascending order.
    outside: Vec<u32>,
    /// g_oj of every patch outside and every zone.
    rows: Vec<Vec<Bands>>,
    /// Error radii of these, those of the worst band.
    radii: Vec<Vec<f32>>,
    /// True if the added factors are the same in all bands.
    is_grey: bool,
    grade: Grade,
    /// d of g'_ij = d_i g_ij d_j, where closure was restored.
    scaling: Option<Vec<Bands>>,
}

impl<'a> BorderedOperator<'a> {
    /// Computes the factors of the patches `outside` with all zones, with the counts of their pairs.
    pub(crate) fn new(
        context: &SolveContext<'a>,
        inner: SpectralOperator<'a>,
        outside: Vec<u32>,
    ) -> (BorderedOperator<'a>, PairCounts) {
        let (scene, zones, progress) = (context.scene, context.zones, context.settings.progress);
        let exchange =
            Exchange::with_settings(scene, zones, context.transport, context.settings.pair_settings);
        progress.begin("exchange of patches outside the medium", outside.len() as u64);
        let (mut rows, mut radii, mut counts) = (Vec::new(), Vec::new(), PairCounts::default());
        for &o in &outside {
            let pair = |j: usize| {
                let mut counts = PairCounts::default();
                let factor = exchange.pair(o as usize, j, &mut counts);
                (factor, counts)
            };
            let row: Vec<_> = parallel::collect(zones.len(), pair);
            row.iter().for_each(|(_, c)| counts.merge(*c));
            rows.push(row.iter().map(|(f, _)| f.value).collect::<Vec<Bands>>());
            radii.push(row.iter().map(|(f, _)| f.radius.max_element() as f32).collect());
            progress.advance(1);
        }
        progress.end();
        let is_grey = rows.iter().flatten().all(|g| g.is_grey());
        let grade = if counts.rays > 0 { Grade::Statistical } else { Grade::Estimated };
        (BorderedOperator { inner, outside, rows, radii, is_grey, grade, scaling: None }, counts)
    }

    /// Names and values of the counters of the box.
    pub(crate) fn counts(&self) -> Vec<(String, u64)> {
        self.inner.counts()
    }

    /// Sets the losses of all zones and their errors; those in `surroundings` are the openings of the box, or none.
    pub(crate) fn set_losses(&self, zones: &Zones, surroundings: &mut SurroundingsExchange) {
        let n = zones.len();
        let coefficients: Vec<Bands> = (0..n).map(|i| scaled_radiosity_coefficient(zones, i)).collect();
        let sky = &mut surroundings.sky;
        sky.resize(n, Bands::ZERO);
        self.outside.iter().for_each(|o| sky[*o as usize] = Bands::splat(closure_target(zones, *o as usize)));
        let others = self.border_product(&coefficients);
        parallel::for_each_pair(sky, &others, |loss, other| *loss = (*loss - *other).max(Bands::ZERO));
        surroundings.error = self.border_error(&coefficients);
    }

    /// Σ g s over the added factors of every zone.
    fn border_product(&self, s: &[Bands]) -> Vec<Bands> {
        let of_zone = |i: usize| {
            let terms = self.outside.iter().zip(&self.rows);
            terms.fold(Bands::ZERO, |sum, (o, row)| sum + row[i] * s[*o as usize])
        };
        let mut out: Vec<Bands> = parallel::collect(s.len(), of_zone);
        for (o, row) in self.outside.iter().zip(&self.rows) {
            out[*o as usize] = row.iter().zip(s).fold(Bands::ZERO, |sum, (g, s)| sum + g * s);
        }
        out
    }

    /// √(Σ (r s)²) over the added factors of every zone.
    fn border_error(&self, s: &[Bands]) -> Vec<Bands> {
        let square = |r: f32, s: Bands| (s * f64::from(r)).map(|x| x * x);
        let of_zone = |i: usize| {
            let terms = self.outside.iter().zip(&self.radii);
            terms.fold(Bands::ZERO, |sum, (o, row)| sum + square(row[i], s[*o as usize])).sqrt()
        };
        let mut out: Vec<Bands> = parallel::collect(s.len(), of_zone);
        for (o, row) in self.outside.iter().zip(&self.radii) {
            let all = row.iter().zip(s).fold(Bands::ZERO, |sum, (r, s)| sum + square(*r, *s));
            out[*o as usize] = all.sqrt();
        }
        out
    }

    fn scaled(&self, s: &[Bands]) -> Vec<Bands> {
        times_scaling(&self.scaling, s)
    }
}

impl ExchangeOperator for BorderedOperator<'_> {
    fn len(&self) -> usize {
        self.inner.len()
    }

    fn apply(&self, s: &[Bands]) -> Vec<Bands> {
        let x = self.scaled(s);
        let mut out = self.inner.apply(&x);
        self.outside.iter().for_each(|o| out[*o as usize] = Bands::ZERO);
        parallel::for_each_pair(&mut out, &self.border_product(&x), |p, more| *p += more);
        self.scaled(&out)
    }

    fn has_identical_bands(&self) -> bool {
        self.is_grey && self.scaling.is_none() && self.inner.has_identical_bands()
    }

    fn apply_band(&self, s: &[[f64; 1]]) -> Vec<[f64; 1]> {
        let mut out = self.inner.apply_band(s);
        parallel::for_each(&mut out, |i, p| {
            let terms = self.outside.iter().zip(&self.rows);
            p[0] += terms.fold(0.0, |sum, (o, row)| sum + row[i].first() * s[*o as usize][0]);
        });
        for (o, row) in self.outside.iter().zip(&self.rows) {
            out[*o as usize][0] = row.iter().zip(s).fold(0.0, |sum, (g, s)| sum + g.first() * s[0]);
        }
        out
    }

    fn scale(&mut self, d: &[Bands]) {
        self.scaling = Some(times_scaling(&self.scaling, d));
    }
}

impl ErrorModel for BorderedOperator<'_> {
    fn error(&self, strengths: &[Bands]) -> Option<Vec<Bands>> {
        let x = self.scaled(strengths);
        let mut inner = self.inner.error(&x)?;
        self.outside.iter().for_each(|o| inner[*o as usize] = Bands::ZERO);
        let both: Vec<Bands> = inner.iter().zip(self.border_error(&x)).map(|(a, b)| *a + b).collect();
        Some(self.scaled(&both))
    }

    fn grade(&self) -> Grade {
        self.grade
    }
}
