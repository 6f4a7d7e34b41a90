//! One answer from two: what links say arrives, and what rays say.
//!
//! Links err alike over many zones and their estimate may miss that; rays err by noise, each zone for itself, which is known well. Both
//! are independent, so over the zones of a cluster
//!
//! ```text
//! Σ (a − b)² ≈ f² Σ e_a² + Σ e_b²
//! ```
//!
//! tells by what factor f ≥ 1 the estimate of the links falls short there, and likewise over all patches and over all volumes. A few zones
//! may show three times the noise expected by chance, all together one and a half. With that the mean of both, weighted by their inverse squares, has the error of both together.

use super::tree::Tree;
use zonal_scene::{Bands, bands};

/// Leaves of a cluster.
const CLUSTER: usize = 256;
/// Times the noise that differences over a cluster, and over all zones of a kind, may show before they count against the links.
const NOISE: [f64; 2] = [3.0, 1.5];
/// Errors of links are told larger by this at least.
const CAUTION: f64 = 1.25;

/// Values with estimated errors.
#[derive(Clone, Copy)]
pub struct Said<'a> {
    /// One a zone.
    pub value: &'a [Bands],
    /// Likewise.
    pub error: &'a [Bands],
}

/// The share of the links in the mean, and its error, a zone, of which the first `patches` are patches; `caution` is what errors of the
/// rays are told larger by.
pub fn joint(tree: &Tree, patches: usize, links: Said, rays: Said, caution: f64) -> Vec<(f64, Bands)> {
    let (of, count) = tree.clusters(CLUSTER);
    let square = |v: &Bands| v.iter().map(|x| x * x).sum::<f64>();
    let terms = |i: usize| {
        let d = square(&bands(|b| links.value[i][b] - rays.value[i][b]));
        [d, square(&links.error[i]), square(&rays.error[i]) / (caution * caution)]
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
            let (a, b) = (links.error[i].map(|e| f * e), rays.error[i]);
            let (x, y) = (square(&a), square(&b));
            let share = if x + y > 0.0 { y / (x + y) } else { 1.0 };
            (share, bands(|k| (share * a[k]).hypot((1.0 - share) * b[k])))
        })
        .collect()
}
