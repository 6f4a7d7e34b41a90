//! One answer from two: what links say arrives, and what rays say.
//!
//! Links err alike over many zones and their estimate may miss that; rays err by noise, each zone for itself, which is known well. Both
//! are independent, so over the zones of a cluster
//!
//! ```text
//! Σ (a − b)² ≈ f² Σ e_a² + Σ e_b²
//! ```
//!
//! tells by what factor f ≥ 1 the estimate of the links falls short there, and likewise over all patches and over all volumes; b and e_b are
//! what the rays of each zone say by themselves, as smoothing may bend them. With that the mean of the links and of the smoothed rays,
//! weighted by their inverse squares, has the error of both together.

use super::tree::Tree;
use super::views::Measured;
use zonal_scene::{Bands, bands};

/// Leaves of a cluster.
const CLUSTER: usize = 256;
/// Times the noise that differences over a cluster, and over all zones of a kind, may show before they count against the links.
const NOISE: [f64; 2] = [1.4, 1.1];
/// Errors of links are told larger by this at least.
const CAUTION: f64 = 1.5;

/// The share of the links in the mean, and its error, a zone, of which the first `patches` are patches: by what links say with its error, what
/// rays say by themselves, and the error of that smoothed.
pub fn joint(
    tree: &Tree,
    patches: usize,
    links: (&[Bands], &[Bands]),
    raw: &[Measured],
    smooth: &[Bands],
) -> Vec<(f64, Bands)> {
    let (of, count) = tree.clusters(CLUSTER);
    let square = |v: &Bands| v.iter().map(|x| x * x).sum::<f64>();
    let terms = |i: usize| {
        let d = square(&bands(|b| links.0[i][b] - raw[i].value[b]));
        [d, square(&links.1[i]), square(&raw[i].error)]
    };
    let (mut own, mut kinds) = (vec![[0.0f64; 3]; count], [[0.0f64; 3]; 2]);
    for (i, &c) in of.iter().enumerate() {
        let t = terms(i);
        for s in [&mut own[c as usize], &mut kinds[usize::from(i >= patches)]] {
            (0..3).for_each(|k| s[k] += t[k]);
        }
    }
    let short = |[d, a, b]: [f64; 3], noise: f64| {
        if a > 0.0 { ((d - noise * b) / a).max(CAUTION * CAUTION).sqrt() } else { CAUTION }
    };
    let factor: Vec<f64> = own.iter().map(|s| short(*s, NOISE[0])).collect();
    let overall = kinds.map(|s| short(s, NOISE[1]));
    (0..of.len())
        .map(|i| {
            let f = factor[of[i] as usize].max(overall[usize::from(i >= patches)]);
            let (a, b) = (links.1[i].map(|e| f * e), smooth[i]);
            let (x, y) = (square(&a), square(&b));
            let share = if x + y > 0.0 { y / (x + y) } else { 1.0 };
            (share, bands(|k| (share * a[k]).hypot((1.0 - share) * b[k])))
        })
        .collect()
}
