//! One answer from two: what links say arrives, a, and what rays say, smoothed, s.
//!
//! Both have their estimates, e_a and e_s, and err independently. Over the zones of a set (a cluster, all patches, all volumes) then
//!
//! ```text
//! Σ (a − b)² ≈ f² Σ e_a² + Σ e_b²          f² Σ e_a² + g² Σ e_s² ≈ Σ (a − s)²
//! ```
//!
//! with b, e_b what the rays of each zone say by themselves, which is noisy but straight. Where links err by more than they know, they
//! differ by it from both: f ≥ 1 is what the **smaller** of the two excesses asks for. One alone tells nothing: few rays miss what is
//! bright and small and then claim too little noise, and smoothing bends where light changes within a window, behind what hides it above
//! all. What else there is between a and s is the smoothed rays' own: g ≥ 1. The mean of a and s weighted by their inverse squares then
//! has the error of both together, and a zone where they differ by more than both claim is told so much worse.

use super::tree::Tree;
use super::views::Measured;
use zonal_scene::{Bands, bands};

/// Leaves of a cluster.
const CLUSTER: usize = 256;
/// Times the noise that differences over a cluster, and over all zones of a kind, may show before they count against the links.
const NOISE: [f64; 2] = [1.4, 1.1];
/// Where links are made, light is uneven and few rays do not serve: errors of smoothed rays count so much more.
const BENT: f64 = 1.3;

/// Σ (a − b)², Σ e_a², Σ e_b², Σ (a − s)², Σ e_s² of a set.
type Sums = [f64; 5];

/// f and g of a set: by how much the errors of links and of smoothed rays are larger than they claim.
fn short([by_rays, links, rays, by_smooth, smooth]: Sums, noise: f64) -> [f64; 2] {
    let over = |x: f64, of: f64| if of > 0.0 { (x / of).max(1.0) } else { 1.0 };
    let f = over((by_rays - noise * rays).min(by_smooth - smooth), links);
    [f.sqrt(), over(by_smooth - f * links, smooth).sqrt()]
}

/// The share of the links in the mean, and its error, a zone, of which the first `patches` are patches: by what links say with its error, what
/// rays say by themselves, and what they say smoothed with its error.
pub fn joint(
    tree: &Tree,
    patches: usize,
    links: (&[Bands], &[Bands]),
    raw: &[Measured],
    smooth: (&[Bands], &[Bands]),
) -> Vec<(f64, Bands)> {
    let (of, count) = tree.clusters(CLUSTER);
    let square = |v: &Bands| v.iter().map(|x| x * x).sum::<f64>();
    let apart = |a: &Bands, b: &Bands| square(&bands(|k| a[k] - b[k]));
    let terms = |i: usize| -> Sums {
        [
            apart(&links.0[i], &raw[i].value),
            square(&links.1[i]),
            square(&raw[i].error),
            apart(&links.0[i], &smooth.0[i]),
            square(&smooth.1[i]),
        ]
    };
    let (mut own, mut kinds) = (vec![[0.0f64; 5]; count], [[0.0f64; 5]; 2]);
    for (i, &c) in of.iter().enumerate() {
        let t = terms(i);
        for s in [&mut own[c as usize], &mut kinds[usize::from(i >= patches)]] {
            (0..5).for_each(|k| s[k] += t[k]);
        }
    }
    let factor: Vec<[f64; 2]> = own.iter().map(|s| short(*s, NOISE[0])).collect();
    let overall = kinds.map(|s| short(s, NOISE[1]));
    (0..of.len())
        .map(|i| {
            let (here, all) = (factor[of[i] as usize], overall[usize::from(i >= patches)]);
            let [f, g] = [0, 1].map(|k| here[k].max(all[k]));
            let (a, b) = (links.1[i].map(|e| f * e), smooth.1[i].map(|e| BENT * g * e));
            let (x, y) = (square(&a), square(&b));
            let share = if x + y > 0.0 { y / (x + y) } else { 1.0 };
            let differ = apart(&links.0[i], &smooth.0[i]);
            let worse = if differ > x + y && x + y > 0.0 { (differ / (x + y)).sqrt() } else { 1.0 };
            (share, bands(|k| worse * (share * a[k]).hypot((1.0 - share) * b[k])))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Zones whose links err by A, whose rays err by R and whose smoothed rays err by S.
    fn sums(a: f64, claimed: f64, r: f64, s: f64, bent: f64) -> Sums {
        [a * a + r * r, claimed * claimed, r * r, a * a + s * s + bent * bent, s * s]
    }

    #[test]
    fn what_one_alone_shows_does_not_count_against_the_links() {
        // All as claimed; rays noisier than they know; smoothing that bends: the links are not to blame.
        for s in [sums(1.0, 1.0, 3.0, 2.0, 0.0), sums(1.0, 1.0, 3.0, 2.0, 9.0)] {
            assert_eq!(short(s, 1.4)[0], 1.0);
        }
        let mut noisy = sums(1.0, 1.0, 3.0, 2.0, 0.0);
        noisy[0] += 1000.0;
        assert!(short(noisy, 1.4)[0] < 1.01);
        // What bends is told of the smoothed rays.
        let [f, g] = short(sums(1.0, 1.0, 3.0, 2.0, 9.0), 1.4);
        assert_eq!(f, 1.0);
        assert!((g - (85.0f64 / 4.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn links_that_differ_from_both_fall_short() {
        let [f, g] = short(sums(10.0, 1.0, 3.0, 2.0, 0.0), 1.0);
        assert!((f - 10.0).abs() < 1e-12 && g < 1.0 + 1e-12, "{f} {g}");
    }
}
