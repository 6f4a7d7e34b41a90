//! Light that arrives, smoothed over the zones around: linear fits as wide as the light itself allows.
//!
//! What the rays of one zone say is noisy; light that comes from other zones varies little from a zone to the next. At zone i, over a
//! window of zones j around it,
//!
//! ```text
//! Σ_j (R_j − a − g·(x_j − x_i))² → min      a = Σ_j l_j R_j      e_a² = ē² Σ_j l_j²      ē² the mean of e_j² over the window
//! ```
//!
//! and a is the value. Windows grow; the widest is taken whose interval a ± Γ e_a still meets those of all narrower ones (the rule of the
//! intersection of confidence intervals), and, wider, that of the zone's own rays. The weights l_j
//! are the same for all bands and light groups, so sums stay sums.

use super::views::Measured;
use super::windows::{Window, Windows};
use rayon::prelude::*;
use zonal_scene::{Bands, Scene, Zones, bands};
use zonal_transport::Transport;

/// Γ: half width of the intervals over their standard error.
const WIDTH: f64 = 0.5;
/// The same of what the rays of the zone itself say: few, but its own.
const ALONE: f64 = 2.0;
/// Share of the error of the next narrower window by which a fit may be bent without showing.
const UNSEEN: f64 = 0.35;
/// What fits leave out, and what the light that rays meet errs by itself: the errors told are larger by this.
pub const CAUTION: f64 = 2.2;
/// Zones of one task.
const BLOCK: usize = 1024;

/// The window chosen for a zone.
struct Chosen {
    /// None: the zone alone.
    window: Option<Window>,
    error: Bands,
    /// Squares of the guide's error and value.
    guide: [f64; 2],
}

/// Smooths what arrives.
pub struct Smoother<'a> {
    zones: &'a Zones,
    windows: Windows<'a>,
}

impl<'a> Smoother<'a> {
    /// Finds what is connected.
    pub fn new(scene: &'a Scene, zones: &'a Zones, transport: &Transport) -> Smoother<'a> {
        Smoother { zones, windows: Windows::new(scene, zones, transport) }
    }

    /// The columns smoothed by windows that suit `guide`, the error of what all of them bring together, and the relative error of the guide
    /// itself over patches and over volumes.
    pub fn smooth(
        &self,
        guide: &[Measured],
        all: &[Measured],
        columns: &[Vec<Bands>],
    ) -> (Vec<Vec<Bands>>, Vec<Bands>, [f64; 2]) {
        let n = all.len();
        let mut squares = [[0.0; 2]; 2];
        let mut out: Vec<Vec<Bands>> = columns.iter().map(|_| vec![[0.0; 3]; n]).collect();
        let mut error = vec![[0.0; 3]; n];
        let blocks = n.div_ceil(BLOCK);
        let done: Vec<Vec<(Chosen, Vec<Bands>)>> = (0..blocks)
            .into_par_iter()
            .map(|block| {
                let range = block * BLOCK..((block + 1) * BLOCK).min(n);
                range.map(|i| self.one(i, guide, all, columns)).collect()
            })
            .collect();
        for (i, (chosen, values)) in done.into_iter().flatten().enumerate() {
            error[i] = chosen.error.map(|e| CAUTION * e);
            let kind = &mut squares[usize::from(i >= self.zones.voxel_offset())];
            *kind = [kind[0] + chosen.guide[0], kind[1] + chosen.guide[1]];
            out.iter_mut().zip(values).for_each(|(o, v)| o[i] = v);
        }
        let over = squares.map(|[e, v]| if v > 0.0 { CAUTION * (e / v).sqrt() } else { 0.0 });
        (out, error, over)
    }

    fn one(
        &self,
        i: usize,
        guide: &[Measured],
        all: &[Measured],
        columns: &[Vec<Bands>],
    ) -> (Chosen, Vec<Bands>) {
        let chosen = self.choose(i, guide, all);
        let value = |c: &Vec<Bands>| {
            let Some(window) = &chosen.window else { return c[i].map(|v| v.max(0.0)) };
            let mut sum = [0.0; 3];
            window.each(|j, l| sum = bands(|b| sum[b] + l * c[j][b]));
            sum.map(|v| v.max(0.0))
        };
        let values = columns.iter().map(value).collect();
        (Chosen { window: None, ..chosen }, values)
    }

    fn choose(&self, i: usize, guide: &[Measured], all: &[Measured]) -> Chosen {
        let whole = |v: &Bands| v.iter().sum::<f64>();
        let own = [whole(&guide[i].error).powi(2), whole(&guide[i].value).powi(2)];
        let mut best = Chosen { window: None, error: all[i].error, guide: own };
        if i >= self.zones.pane_offset() {
            return best;
        }
        let mut narrower = best.error;
        // Of each band: light of another colour is another light.
        let mut interval = [[f64::NEG_INFINITY; 3], [f64::INFINITY; 3]];
        let mut first = true;
        for level in 0..self.windows.levels(i) {
            let Some(window) = self.windows.window(i, level) else { continue };
            let (mut value, mut spread) = ([0.0; 3], 0.0);
            window.each(|j, l| {
                let v = &guide[j].value;
                value = bands(|b| value[b] + l * v[b]);
                spread += l * l;
            });
            let noise = pooled(&window, guide);
            let error = if std::ptr::eq(guide, all) { noise } else { pooled(&window, all) };
            if first {
                let v = &guide[i].value;
                interval = [-1.0, 1.0].map(|s| bands(|b| v[b] + s * ALONE * noise[b]));
                best.error = bands(|b| best.error[b].max(error[b]));
                (narrower, first) = (best.error, false);
                // What none of its own rays found lit lies in the dark; light around it is that of another room.
                if whole(v) == 0.0 {
                    break;
                }
            }
            let half = noise.map(|e| WIDTH * e * spread.sqrt());
            let [low, high] = interval;
            interval =
                [bands(|b| low[b].max(value[b] - half[b])), bands(|b| high[b].min(value[b] + half[b]))];
            if (0..3).any(|b| interval[0][b] > interval[1][b]) {
                break;
            }
            let error = error.map(|p| p * spread.sqrt());
            let told = bands(|b| error[b].hypot(UNSEEN * narrower[b]));
            narrower = error;
            let guide = [(whole(&noise) * spread.sqrt()).powi(2), whole(&value).powi(2)];
            best = Chosen { window: Some(window), error: told, guide };
        }
        best
    }
}

/// Root mean square of the errors over a window.
fn pooled(window: &Window, of: &[Measured]) -> Bands {
    let mut square = [0.0; 3];
    window.each(|j, _| {
        let e = &of[j].error;
        square = bands(|b| square[b] + e[b] * e[b]);
    });
    square.map(|s| (s / window.len() as f64).sqrt())
}
