//! Errors of a gather, from two independent halves of its samples.
//!
//! Zone i has the means a_i and b_i of two sequences that were scrambled independently; its value is v = (a + b)/2. Two estimates of the variance
//! of v complement each other:
//!
//! ```text
//! d_i² = (a_i − b_i)²/4          true in the mean, with one degree of freedom
//! s_i²                           variance of the samples over their number: precise, but without the gain of the sequences
//! ```
//!
//! The gain is much the same in neighbouring zones. Over a group of these (`zone_groups`), with c zones' worth of the ratio of all zones of a kind,
//!
//! ```text
//! q = (Σ d² + c q_all ŝ²)/(Σ s² + c ŝ²)          ŝ² = Σ s⁴/Σ s²          e_i² = (1 − w) q_i s_i² + w q s̄²
//! ```
//!
//! with s̄² the mean of s² over the group, and ŝ² that of the zones that hold most of it: a zone whose few samples all agree has a share w of the
//! group's variance. q_i is q but for dim zones, those of s_i² < ŝ²/10, of which the group has k: their samples meet light seldom, and gain less.
//! The halves of few zones may agree by chance: of m zones that hold the variance of a kind,
//!
//! ```text
//! q_all = (m Σ d²/Σ s² + 1)/(m + 1)          m = (Σ s²)²/Σ s⁴
//! q_i   = (Σ_dim d²/s² + 2)/(k + 2)          for dim zones
//! ```

use super::zone_groups::{ZONES_PER_GROUP, ZoneGroups};
use rayon::prelude::*;
use zonal_scene::Bands;

/// Stated error over the estimated standard error.
pub(super) const STATED_ERROR_FACTOR: f64 = 1.6;

/// Relative error of an equally weighted sum of the light groups over the wanted one of their sum: relit solutions may have this multiple.
pub(super) const EQUAL_WEIGHT_MULTIPLE: f64 = 2.0;

/// How errors are pooled.
struct PoolingParams {
    /// c: zones' worth of the ratio over all zones in that of a group.
    prior_zones: f64,
    /// w: share of the group's variance in that of a zone.
    group_share: f64,
    /// s²/ŝ² below which a zone is dim.
    dim: f64,
    /// Dim zones' worth of a ratio of one.
    prior_dim_zones: f64,
}

const POOLING_PARAMS: PoolingParams =
    PoolingParams { prior_zones: 8.0, group_share: 0.1, dim: 0.1, prior_dim_zones: 2.0 };

/// Share of the group's variance in that of a zone by few rays.
const GROUP_SHARE_OF_FEW_RAYS: f64 = 0.6;

/// The two variances of a zone.
#[derive(Clone, Copy, Default)]
pub(crate) struct ZoneVariances {
    /// d².
    pub of_halves: Bands,
    /// s².
    pub of_samples: Bands,
}

/// Standard errors of the zones of a kind, in the order of their groups.
pub(crate) fn standard_errors(variances: &[ZoneVariances]) -> Vec<Bands> {
    let mut out = vec![Bands::ZERO; variances.len()];
    let ratio_of_all = ratio_of_all(variances);
    let groups = variances.par_chunks(ZONES_PER_GROUP).zip(out.par_chunks_mut(ZONES_PER_GROUP));
    groups.for_each(|(group, errors)| pool(group, ratio_of_all, errors));
    out
}

/// ŝ²: the variance of the zones that hold most of it; `sum` is that of all.
fn typical_variance(zones: &[ZoneVariances], sum: Bands) -> Bands {
    zones.iter().map(|z| z.of_samples * z.of_samples).sum::<Bands>().zip_map(sum, ratio)
}

/// q_all; 1 without a variance.
fn ratio_of_all(variances: &[ZoneVariances]) -> Bands {
    let all = sums(variances);
    let effective = all.of_samples.zip_map(typical_variance(variances, all.of_samples), ratio);
    (effective * all.of_halves.zip_map(all.of_samples, ratio) + Bands::ONE)
        .zip_map(effective + Bands::ONE, ratio)
}

/// `a`/`b`; 0 where b is not positive.
pub(crate) fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}

/// Sums over zones of the products of an error by two halves of samples, A and B, in which their noise drops out, and the variance of the sum where the error is 0:
/// Σ A B and Σ s⁴, with s² = (A − B)²/2 and a mean fourth power of a normal deviate of three times that of its square.
#[derive(Clone, Copy, Default)]
pub(crate) struct HalfProducts {
    product: Bands,
    variance: Bands,
}

impl HalfProducts {
    /// Adds a zone.
    pub(crate) fn add(&mut self, a: Bands, b: Bands) {
        let square = 0.5 * (a - b) * (a - b);
        self.product += a * b;
        self.variance += square * square / 3.0;
    }
    /// The squared relative error from above, for the sum of squares `level` of the field; 0 without a field.
    pub(crate) fn square_from_above(&self, level: Bands) -> Bands {
        (self.product.map(|p| p.max(0.0)) + self.variance.sqrt()).zip_map(level, ratio)
    }
    /// The squared relative error, which may be negative, and its standard error.
    pub(crate) fn square_and_noise(&self, level: Bands) -> [Bands; 2] {
        [self.product, self.variance.sqrt()].map(|x| x.zip_map(level, ratio))
    }
}

fn sums(zones: &[ZoneVariances]) -> ZoneVariances {
    zones.iter().fold(ZoneVariances::default(), |s, z| ZoneVariances {
        of_halves: s.of_halves + z.of_halves,
        of_samples: s.of_samples + z.of_samples,
    })
}

fn pool(group: &[ZoneVariances], ratio_of_all: Bands, errors: &mut [Bands]) {
    let p = &POOLING_PARAMS;
    let all = sums(group);
    let mean = all.of_samples / group.len() as f64;
    let typical = typical_variance(group, all.of_samples);
    let prior = p.prior_zones * typical;
    let gain = (all.of_halves + prior * ratio_of_all).zip_map(all.of_samples + prior, ratio);
    let is_dim = |zone: &ZoneVariances| {
        zone.of_samples.zip_map(typical, |s, typical| if s < p.dim * typical { 1.0 } else { 0.0 })
    };
    let dim = group.iter().fold([Bands::splat(p.prior_dim_zones); 2], |[sum, count], zone| {
        let has_variance = zone.of_samples.map(|s| if s > 0.0 { 1.0 } else { 0.0 });
        let counted = is_dim(zone) * has_variance;
        [sum + counted * zone.of_halves.zip_map(zone.of_samples, ratio), count + counted]
    });
    let gain_of_dim = dim[0].zip_map(dim[1], ratio);
    for (zone, error) in group.iter().zip(errors) {
        let own_gain = gain + is_dim(zone) * (gain_of_dim - gain);
        let variance = (1.0 - p.group_share) * own_gain * zone.of_samples + p.group_share * gain * mean;
        *error = variance.sqrt();
    }
}

/// Error of radiosities that a gather reads, of the zones of a kind in the order of their groups, from the gather `noise` of one realization of it: per zone, half the mean
/// square of its group, and half that of all zones in proportion to the squared value.
pub(crate) fn inherited_errors(noise: &[Bands], value: &[Bands]) -> Vec<Bands> {
    let mut out = vec![Bands::ZERO; noise.len()];
    let square = |list: &[Bands]| list.iter().fold(Bands::ZERO, |s, x| s + x * x);
    let relative = square(noise).zip_map(square(value), ratio);
    let groups = noise.par_chunks(ZONES_PER_GROUP).zip(value.par_chunks(ZONES_PER_GROUP));
    groups.zip(out.par_chunks_mut(ZONES_PER_GROUP)).for_each(|((noise, value), out)| {
        let own = square(noise) / noise.len() as f64;
        for (v, e) in value.iter().zip(out) {
            *e = (0.5 * own + 0.5 * relative * (v * v)).sqrt();
        }
    });
    out
}

/// Errors of incident radiation that is not gathered, as a gather would state them: from the standard error `of_rays` of every zone by its own rays, and the incident
/// radiation `noise` of one realization of the noise of the radiosities, of which each value `own` has its share of `all`.
pub(crate) fn stated_errors(
    groups: &ZoneGroups,
    of_rays: &[Bands],
    noise: &[Bands],
    [own, all]: [&[Bands]; 2],
) -> Vec<Bands> {
    let mut out = vec![Bands::ZERO; of_rays.len()];
    for kind in 0..3 {
        let order = groups.order_of_kind(kind);
        let list = |v: &[Bands]| -> Vec<Bands> { order.iter().map(|i| v[*i as usize]).collect() };
        let mut squares: Vec<Bands> = list(of_rays).into_iter().map(|e| e * e).collect();
        // The variance among few rays says little: none of them may meet what is bright.
        for group in squares.chunks_mut(ZONES_PER_GROUP) {
            let mean = group.iter().sum::<Bands>() / group.len() as f64;
            group.iter_mut().for_each(|s| *s = *s + GROUP_SHARE_OF_FEW_RAYS * (mean - *s));
        }
        let variances: Vec<ZoneVariances> =
            squares.into_iter().map(|s| ZoneVariances { of_halves: s, of_samples: s }).collect();
        let inherited = inherited_errors(&list(noise), &list(all));
        for ((i, e), inherited) in order.iter().zip(standard_errors(&variances)).zip(inherited) {
            let i = *i as usize;
            out[i] = STATED_ERROR_FACTOR * e.hypot(inherited * own[i].zip_map(all[i], ratio));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::low_discrepancy::hash_to_unit;

    #[test]
    fn standard_errors_follow_the_gain_of_the_sequences() {
        // Samples vary by s = 1 + i/100; the halves differ by a tenth of that. The normal deviate is a sum of twelve uniform numbers.
        let n = 640;
        let normal = |i: usize| (0..12).map(|k| hash_to_unit((i * 12 + k) as u64)).sum::<f64>() - 6.0;
        let s = |i: usize| 1.0 + i as f64 / 100.0;
        let variances: Vec<ZoneVariances> = (0..n)
            .map(|i| ZoneVariances {
                of_halves: Bands::splat((0.1 * s(i) * normal(i)).powi(2)),
                of_samples: Bands::splat(s(i) * s(i)),
            })
            .collect();
        let errors = standard_errors(&variances);
        for (i, e) in errors.iter().enumerate() {
            let expected = 0.1 * s(i);
            assert!((e.first() / expected - 1.0).abs() < 0.35, "{i}: {} {expected}", e.first());
        }
    }

    #[test]
    fn dim_zones_have_a_gain_of_their_own() {
        let bright = ZoneVariances { of_halves: Bands::splat(1e-4), of_samples: Bands::ONE };
        let dim = ZoneVariances { of_halves: Bands::splat(1e-4), of_samples: Bands::splat(1e-4) };
        let mut variances = vec![bright; 64];
        variances[..8].fill(dim);
        let errors = standard_errors(&variances);
        let (dim, bright) = (errors[3].first(), errors[40].first());
        assert!(dim > 0.009 && dim < 0.02 && bright > 0.01 && bright < 0.2, "{dim} {bright}");
    }

    #[test]
    fn halves_of_one_zone_that_agree_by_chance_do_not_hide_its_variance() {
        let mut variances = vec![ZoneVariances::default(); 64];
        variances[5] = ZoneVariances { of_halves: Bands::splat(1e-6), of_samples: Bands::ONE };
        let errors = standard_errors(&variances);
        assert!(errors[5].first() > 0.5 && errors[5].first() < 1.0, "{:?}", errors[5]);
    }

    #[test]
    fn zones_without_samples_that_differ_share_the_error_of_their_group() {
        let mut variances =
            vec![ZoneVariances { of_halves: Bands::splat(1.0), of_samples: Bands::splat(1.0) }; 64];
        variances[7] = ZoneVariances::default();
        let errors = standard_errors(&variances);
        assert!(errors[7].first() > 0.25 * errors[8].first(), "{:?}", errors[7]);
        assert_eq!(standard_errors(&[ZoneVariances::default(); 64])[3], Bands::ZERO);
    }
}
