//! Closure: Σ_j g_ij c_j + g_i,sky + g_i,backs = A_i (patch), 4V_i (voxel), 4 A t (pane).
//!
//! **Restoration** looks for d with Σ_j d_i g_ij d_j c_j + d_i (g_i,sky + g_i,backs) = target, a symmetric scaling: reciprocity
//! stays exact, and the surroundings move with the zones. The iteration d ← d √(target/row) is the damped form of Sinkhorn and
//! Knopp's; zones that see nothing are left alone.

use crate::operator::{Operator, extend_to_slopes};
use crate::surroundings::Escape;
use rayon::prelude::*;
use zonal_exchange::pair::{strength, target};
use zonal_scene::solution::Closure;
use zonal_scene::{Bands, Zones, bands};

/// Defect below which rows close but for rounding: there is nothing to restore.
const ROUNDED: f64 = 1e-11;
/// Sweeps of the restoration.
const SWEEPS: usize = 400;
/// Defect at which the restoration is content.
const GOAL: f64 = 1e-13;

/// Relative defects (row − target)/target of every zone.
pub fn defects(operator: &dyn Operator, zones: &Zones, escape: &Escape) -> Vec<Bands> {
    let c: Vec<Bands> = (0..zones.len()).into_par_iter().map(|i| strength(zones, i)).collect();
    let mut rows = operator.apply(&c);
    drop(c);
    rows.par_iter_mut().enumerate().for_each(|(i, row)| {
        let (t, sky, backs) = (target(zones, i), escape.sky_of(i), escape.backs_of(i));
        *row = bands(|b| (row[b] + sky[b] + backs[b] - t) / t);
    });
    rows
}

fn worst(d: &[Bands]) -> Bands {
    d.iter().fold([0.0; 3], |w, d| bands(|b| w[b].max(d[b].abs())))
}

fn rms(d: &[Bands]) -> Bands {
    let n = d.len().max(1) as f64;
    d.iter().fold([0.0; 3], |s, d| bands(|b| s[b] + d[b] * d[b] / n)).map(f64::sqrt)
}

/// Measures closure; no change.
pub fn measure(operator: &dyn Operator, zones: &Zones, escape: &Escape) -> (Closure, Vec<Bands>) {
    let d = defects(operator, zones, escape);
    let closure = Closure { worst: worst(&d), rms: rms(&d), after: worst(&d), ..Closure::default() };
    (closure, d)
}

/// Restores closure by symmetric scaling of all factors, those of the surroundings included. With it, of every zone the share of a level field by
/// which its row was changed, |d_i − 1| + Σ_j g_ij c_j |d_j − 1| / target, and is off still: the factors that were right were changed too, for those
/// that were wrong. It is negative where the row misses something.
pub fn restore(operator: &mut dyn Operator, zones: &Zones, escape: &mut Escape) -> (Closure, Vec<Bands>) {
    let (mut closure, measured) = measure(operator, zones, escape);
    let n = zones.len();
    if closure.worst.iter().all(|w| *w <= ROUNDED) {
        closure.restored = true;
        return (closure, measured);
    }
    let c: Vec<Bands> = (0..n).map(|i| strength(zones, i)).collect();
    let mut d = vec![[1.0; 3]; n];
    for _ in 0..SWEEPS {
        let dc: Vec<Bands> = (0..n).map(|i| bands(|b| d[i][b] * c[i][b])).collect();
        let rows = operator.apply(&dc);
        let mut off: f64 = 0.0;
        for i in 0..n {
            let t = target(zones, i);
            for b in 0..3 {
                let row = d[i][b] * (rows[i][b] + escape.sky_of(i)[b] + escape.backs_of(i)[b]);
                if row > 1e-12 * t {
                    off = off.max((row / t - 1.0).abs());
                    d[i][b] *= (t / row).sqrt();
                }
            }
        }
        if off < GOAL {
            break;
        }
    }
    closure.largest_change = {
        let low = d.iter().fold([1.0f64; 3], |m, d| bands(|b| m[b].min(d[b])));
        let high = d.iter().fold([1.0f64; 3], |m, d| bands(|b| m[b].max(d[b])));
        bands(|b| (high[b] * high[b] - 1.0).max(1.0 - low[b] * low[b]))
    };
    let off: Vec<Bands> = d.iter().map(|d| d.map(|d| (d - 1.0).abs())).collect();
    let others = operator.apply(&crate::columns::times(&c, &off));
    let mut all = d.clone();
    extend_to_slopes(&mut all, &operator.slopes());
    escape.scale(&all);
    operator.scale(&d);
    let left = defects(operator, zones, escape);
    closure.after = worst(&left);
    closure.restored = true;
    let sum = |i: usize, b: usize| {
        let change = off[i][b] + others[i][b] / target(zones, i);
        // Rows that are off by rounding are right.
        if left[i][b].abs() <= ROUNDED { change } else { (change + left[i][b].abs()).copysign(left[i][b]) }
    };
    (closure, (0..n).map(|i| bands(|b| sum(i, b))).collect())
}
