//! Blend of two estimates of the incident power: a by links and s by smoothed rays (inverse-variance weighting).
//!
//! Both have error estimates e_a and e_s, and their errors are independent. Over the zones of a set (a cluster, all patches, all volumes)
//!
//! ```text
//! Σ (a − b)² ≈ f² Σ e_a² + Σ e_b²          f² Σ e_a² + g² Σ e_s² ≈ Σ (a − s)²
//! ```
//!
//! with b, e_b the unsmoothed rays of each zone, which are noisy but unbiased. Where the links err by more than they state, they differ by it
//! from both: f ≥ 1 follows from the **smaller** of the two excesses. One excess alone proves nothing: few rays miss small bright sources and
//! then underestimate their noise, and smoothing is biased where the incident radiation changes within a window, above all at shadow
//! boundaries. The rest of the difference of a and s is an error of the smoothed rays: g ≥ 1. The mean of a and s weighted by the inverse squares
//! then has the error of both together; where they differ by more than both errors, the stated error grows by the ratio.

use crate::cluster::tree::ClusterTree;
use crate::ray::ray_table::IncidentEstimate;
use zonal_scene::Bands;

/// How errors are corrected before the estimates are blended.
struct BlendParams {
    /// Most leaves of a cluster over which errors are compared.
    max_leaves_of_cluster: usize,
    /// Squared noise of the rays that differences over a cluster, and over all zones of a kind, may contain before they count against the
    /// links, over its estimate.
    noise_allowance: [f64; 2],
    /// Factor on the errors of smoothed rays where links are made: the radiation is uneven there and rays are few.
    smoothing_bias_factor: f64,
}

const BLEND_PARAMS: BlendParams =
    BlendParams { max_leaves_of_cluster: 256, noise_allowance: [1.4, 1.1], smoothing_bias_factor: 1.3 };

/// Incident power by rays.
pub(crate) struct RayEstimate {
    /// Smoothed, for every group, W.
    pub columns: Vec<Vec<Bands>>,
    /// Estimated error of their sum.
    pub error: Vec<Bands>,
    /// Their sum before smoothing, with its standard error.
    pub raw: Vec<IncidentEstimate>,
}

/// Incident power by links.
pub(crate) struct LinkEstimate {
    /// For every group, W.
    pub columns: Vec<Vec<Bands>>,
    /// Estimated error of their sum.
    pub error: Vec<Bands>,
}

/// An estimate of every zone with its error.
#[derive(Clone, Copy)]
pub(crate) struct ZoneEstimate<'a> {
    /// Value.
    pub value: &'a [Bands],
    /// Error.
    pub error: &'a [Bands],
}

/// The share of the links in the blend of a zone, and the error of the blend.
#[derive(Clone, Copy)]
pub(crate) struct BlendedZone {
    /// 0 … 1.
    pub link_share: f64,
    /// Estimated error.
    pub error: Bands,
}

/// Σ (a − b)², Σ e_a², Σ e_b², Σ (a − s)², Σ e_s² of a set.
type SquareSums = [f64; 5];

/// f and g of a set: factors by which the errors of links and of smoothed rays exceed their estimates.
fn error_factors([raw_difference, links, raw, difference, smooth]: SquareSums, allowance: f64) -> [f64; 2] {
    let ratio = |x: f64, of: f64| if of > 0.0 { (x / of).max(1.0) } else { 1.0 };
    let f = ratio((raw_difference - allowance * raw).min(difference - smooth), links);
    [f.sqrt(), ratio(difference - f * links, smooth).sqrt()]
}

fn square(v: Bands) -> f64 {
    (v * v).sum()
}

fn squared_difference(a: Bands, b: Bands) -> f64 {
    square(a - b)
}

/// The blend of every zone, of which the first `patches` are patches: by the links, the rays of each zone alone, and the smoothed rays.
pub(crate) fn blend(
    tree: &ClusterTree,
    patches: usize,
    links: ZoneEstimate,
    raw: &[IncidentEstimate],
    smooth: ZoneEstimate,
) -> Vec<BlendedZone> {
    // Sum squares over every cluster, and over patches and volumes.
    let (part, count) = tree.partition(BLEND_PARAMS.max_leaves_of_cluster);
    let terms = |i: usize| -> SquareSums {
        [
            squared_difference(links.value[i], raw[i].value),
            square(links.error[i]),
            square(raw[i].error),
            squared_difference(links.value[i], smooth.value[i]),
            square(smooth.error[i]),
        ]
    };
    let (mut of_part, mut of_kind) = (vec![[0.0f64; 5]; count], [[0.0f64; 5]; 2]);
    for (i, &c) in part.iter().enumerate() {
        let t = terms(i);
        for s in [&mut of_part[c as usize], &mut of_kind[usize::from(i >= patches)]] {
            (0..5).for_each(|k| s[k] += t[k]);
        }
    }
    let [by_part, by_kind] = BLEND_PARAMS.noise_allowance;
    let part_factors: Vec<[f64; 2]> = of_part.iter().map(|s| error_factors(*s, by_part)).collect();
    let kind_factors = of_kind.map(|s| error_factors(s, by_kind));
    // Weight by the inverse squares of the corrected errors.
    let one = |i: usize| {
        let (here, all) = (part_factors[part[i] as usize], kind_factors[usize::from(i >= patches)]);
        let [f, g] = [0, 1].map(|k| here[k].max(all[k]));
        let a = f * links.error[i];
        let b = BLEND_PARAMS.smoothing_bias_factor * g * smooth.error[i];
        let (x, y) = (square(a), square(b));
        let share = if x + y > 0.0 { y / (x + y) } else { 1.0 };
        let difference = squared_difference(links.value[i], smooth.value[i]);
        let excess = if difference > x + y && x + y > 0.0 { (difference / (x + y)).sqrt() } else { 1.0 };
        let error = excess * (share * a).hypot((1.0 - share) * b);
        BlendedZone { link_share: share, error }
    };
    (0..part.len()).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Zones whose links err by `a`, whose rays err by `r` and whose smoothed rays err by `s` and a bias.
    fn square_sums(a: f64, stated: f64, r: f64, s: f64, bias: f64) -> SquareSums {
        [a * a + r * r, stated * stated, r * r, a * a + s * s + bias * bias, s * s]
    }

    #[test]
    fn difference_from_one_estimate_does_not_increase_the_error_of_the_links() {
        // All errors as stated, and biased smoothing: the links keep their error.
        for s in [square_sums(1.0, 1.0, 3.0, 2.0, 0.0), square_sums(1.0, 1.0, 3.0, 2.0, 9.0)] {
            assert_eq!(error_factors(s, 1.4)[0], 1.0);
        }
        // Rays noisier than stated.
        let mut noisy = square_sums(1.0, 1.0, 3.0, 2.0, 0.0);
        noisy[0] += 1000.0;
        assert!(error_factors(noisy, 1.4)[0] < 1.01);
        // The bias counts for the smoothed rays.
        let [f, g] = error_factors(square_sums(1.0, 1.0, 3.0, 2.0, 9.0), 1.4);
        assert_eq!(f, 1.0);
        assert!((g - (85.0f64 / 4.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn difference_from_both_estimates_increases_the_error_of_the_links() {
        let [f, g] = error_factors(square_sums(10.0, 1.0, 3.0, 2.0, 0.0), 1.0);
        assert!((f - 10.0).abs() < 1e-12 && g < 1.0 + 1e-12, "{f} {g}");
    }
}
