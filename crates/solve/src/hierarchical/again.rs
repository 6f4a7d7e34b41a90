//! More rays where those at hand, smoothed, leave too much open.
//!
//! Zones that see something bright through a gap, or stand alone among others, stay noisy however wide a window others allow. Where the
//! error told exceeds a share of the tolerance times what arrives, direct light included (no less than a part of its mean over the zones
//! of the kind, and no more than a part of its root mean square: errors of bright zones count in full), the zone shoots again:
//! (e/wanted)² times as many rays as it has, e the error of its own rays; all wishes shrink alike where they are too many, and zones that so
//! few would not serve stay as they are. (To serve the worst first was tried: it costs the others more than it gains them.) What all its
//! rays say then stands for it, unsmoothed.

use super::onward::Lamps;
use super::seeing::Seeing;
use super::shooter::Shooter;
use super::smooth::CAUTION;
use super::views::{Measured, Shine, Views};
use rayon::prelude::*;
use zonal_scene::{Bands, bands};

/// Error wanted over tolerance and what arrives, of a patch and of a volume zone.
const SHARE: [f64; 2] = [1.75, 2.2];
/// What arrives counts as no less than this part of its mean.
const DARK: f64 = 0.1;
/// And as no more than this part of its root mean square.
const BRIGHT: f64 = 0.5;
/// Rays over those at hand: of a zone at least and at most, and of all zones together at most.
const TIMES: [f64; 2] = [1.0, 12.0];
const ALL: f64 = 0.3;

/// Zones whose rays are shot together.
const TOGETHER: usize = 32;

/// A zone that shoots again, and how many rays.
struct Wish {
    zone: usize,
    rays: usize,
}

/// A zone whose error is above what is wanted.
struct Noisy {
    zone: usize,
    /// Rays that it wishes for over those that it has.
    times: f64,
    /// Rays over those that it has with which these alone, old and new, are as good as the smoothed field.
    least: f64,
}

/// The light of a zone, its bands together.
fn whole(v: &Bands) -> f64 {
    v.iter().sum()
}

/// Which zones shoot again, by what arrives and the error told.
fn wishes(
    views: &Views,
    seen: &[Measured],
    values: &[Vec<Bands>],
    told: &[Bands],
    direct: &[Bands],
    tolerance: f64,
) -> Vec<Wish> {
    let (n, first) = (told.len(), views.patches());
    let value = |i: usize| values.iter().map(|c| whole(&c[i])).sum::<f64>() + whole(&direct[i]);
    let mut out: Vec<Noisy> = Vec::new();
    for (range, share) in [0..first, first..n].into_iter().zip(SHARE) {
        let own = |k: usize| value(range.start + k);
        let [sum, squares, _] = crate::columns::sum(range.len(), |k| [own(k), own(k).powi(2), 0.0]);
        let count = range.len().max(1) as f64;
        let (dark, bright) = (DARK * sum / count, BRIGHT * (squares / count).sqrt());
        let one = |i: usize| {
            let wanted = share * tolerance * value(i).max(dark).min(bright);
            let raw = CAUTION * whole(&seen[i].error);
            let more = whole(&told[i]) > wanted && wanted > 0.0;
            let times = (raw / wanted).powi(2).clamp(TIMES[0], TIMES[1]);
            more.then(|| Noisy { zone: i, times, least: (raw / whole(&told[i])).powi(2) })
        };
        out.extend(range.into_par_iter().filter_map(one).collect::<Vec<_>>());
    }
    share_out(out, &|zone| views.of(zone).len(), ALL * views.rays()[0] as f64)
}

/// No more than so many rays for zones that have some.
fn share_out(mut list: Vec<Noisy>, rays_of: &dyn Fn(usize) -> usize, most: f64) -> Vec<Wish> {
    let asked = |list: &[Noisy]| list.iter().map(|z| z.times * rays_of(z.zone) as f64).sum::<f64>();
    let share = |list: &[Noisy]| (most / asked(list).max(1.0)).min(1.0);
    // What those leave over that it would not serve goes to the others.
    let all = share(&list);
    list.retain(|z| 1.0 + all * z.times > z.least);
    let all = share(&list);
    let wish = |z: Noisy| Wish { zone: z.zone, rays: (all * z.times * rays_of(z.zone) as f64) as usize };
    list.into_iter().map(wish).collect()
}

impl Seeing<'_> {
    /// Shoots again for the zones that need it: sets what arrives of every column of radiosities `shine`, and its error. Returns the
    /// number of rays.
    pub fn again(
        &self,
        shine: &[Vec<Shine>],
        raw: &[Vec<Bands>],
        seen: &[Measured],
        values: &mut [Vec<Bands>],
        told: &mut [Bands],
    ) -> u64 {
        let direct = self.direct.fields(told.len());
        let list = wishes(&self.views, seen, values, told, &direct, self.scene.options().tolerance);
        let shooter = Shooter::new(self.scene, self.zones, self.transport);
        let lamps = self.onward.then(|| Lamps::new(self.scene, self.direct));
        let some = |wishes: &[Wish]| -> Vec<(usize, Vec<Bands>, Bands)> {
            // The wish that each ray serves, and its number among the rays of the zone.
            let mut serves: Vec<(usize, usize)> = Vec::new();
            for (w, wish) in wishes.iter().enumerate() {
                let have = self.views.of(wish.zone).len();
                serves.extend((have..have + wish.rays).map(|k| (w, k)));
            }
            let of = |r: usize| (wishes[serves[r].0].zone, serves[r].1);
            let mut steps = Vec::new();
            let mut sums = vec![vec![[0.0; 3]; shine.len()]; wishes.len()];
            let mut squares = vec![[0.0; 3]; wishes.len()];
            shooter.volley(serves.len(), of, |r, stop| {
                let (w, worth) = (serves[r].0, stop.worth);
                steps.clear();
                let met = lamps.as_ref().map_or(stop.zone, |l| shooter.follow(l, of(r), stop, &mut steps));
                let mut all = [0.0; 3];
                for (c, b) in shine.iter().enumerate() {
                    let v = self.views.brings(&steps, met, worth, b, self.way(c)).map(f64::from);
                    sums[w][c] = bands(|x| sums[w][c][x] + v[x]);
                    all = bands(|x| all[x] + v[x]);
                }
                squares[w] = bands(|x| squares[w][x] + all[x] * all[x]);
            });
            let joined = |((wish, sums), square): ((&Wish, Vec<Bands>), Bands)| {
                let (i, have) = (wish.zone, self.views.of(wish.zone).len());
                let (m, unit) = (wish.rays as f64, self.views.unit(i));
                let (old, new) = (have as f64, have as f64 + m);
                let all = sums.iter().fold([0.0; 3], |s, v| bands(|x| s[x] + v[x]));
                // Sums of squares about the means of either part, as errors of the whole.
                let error = bands(|x| {
                    let own = (square[x] - all[x] * all[x] / m.max(1.0)).max(0.0) * unit * unit;
                    let before = (seen[i].error[x] * old).powi(2);
                    CAUTION * (own + before).sqrt() / new
                });
                let value = |c: usize| {
                    let within = self.views.within(i, &shine[c]);
                    bands(|x| (raw[c][i][x] * old + unit * (sums[c][x] + m * within[x])) / new)
                };
                (i, (0..shine.len()).map(value).collect(), error)
            };
            wishes.iter().zip(sums).zip(squares).map(joined).collect()
        };
        let done: Vec<_> = list.par_chunks(TOGETHER).flat_map_iter(some).collect();
        for (i, own, error) in done {
            told[i] = error;
            own.into_iter().zip(values.iter_mut()).for_each(|(v, to)| to[i] = v);
        }
        list.iter().map(|w| w.rays as u64).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_go_where_they_serve() {
        let noisy = |zone, times, least| Noisy { zone, times, least };
        // Of 100 rays each: 400 are asked for and 200 allowed. Half a wish would leave the second worse than smoothing does.
        let list = vec![noisy(3, 2.0, 1.5), noisy(5, 2.0, 2.5)];
        let wishes = share_out(list, &|_| 100, 200.0);
        assert_eq!(wishes.iter().map(|w| (w.zone, w.rays)).collect::<Vec<_>>(), [(3, 200)]);
        // Where all have what they wish for, all are served.
        let list = vec![noisy(3, 2.0, 1.5), noisy(5, 2.0, 2.5)];
        assert_eq!(share_out(list, &|_| 100, 400.0).len(), 2);
    }
}
