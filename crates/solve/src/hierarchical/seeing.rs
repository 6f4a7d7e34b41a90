//! The exchange of all zones along the rays of their [`Views`], as an operator.
//!
//! It is not symmetric: what i sees of j is sampled at i alone. Light is passed on step by step. What arrives in the end is smoothed over
//! the zones around ([`super::smooth`]), which lowers the noise and gives its error.

use super::smooth::Smoother;
use super::views::{Measured, Views};
use crate::columns::total;
use crate::engine::Site;
use crate::groups::response;
use crate::krylov::{self, Ended, Stop, System};
use crate::operator::{Arriving, Operator};
use crate::pipeline::targets;
use crate::surroundings::Escape;
use rayon::prelude::*;
use zonal_exchange::pair::strength;
use zonal_math::Grade;
use zonal_scene::{Bands, Scene, Zones};
use zonal_transport::Transport;

/// Rays of a patch: so many over the square of the tolerance, no fewer and no more than these.
const RAYS: f64 = 1.5;
const FEWEST: f64 = 32.0;
const MOST: f64 = 2048.0;
/// How many more rays are shot than would just do.
const MARGIN: f64 = 1.3;
/// Rays of a volume zone over those of a patch: its neighbours are more.
const VOLUME: f64 = 0.3;
/// Rays of all zones together at most: half a gigabyte.
const ALL: f64 = 1.34e8;
/// Where the rough solution stops.
const STOP: Stop = Stop { residual: 2e-3, iterations: 200 };

/// All zones and what they see.
pub struct Seeing<'a> {
    scene: &'a Scene,
    zones: &'a Zones,
    transport: &'a Transport<'a>,
    views: Views,
    /// c of every zone.
    strength: Vec<Bands>,
}

/// Rays of a patch and of a volume zone for a tolerance.
pub fn rays(zones: &Zones, tolerance: f64) -> [usize; 2] {
    within(zones, RAYS / (tolerance * tolerance))
}

/// Rays with which an error falls by a factor; those at hand where more are not allowed.
pub fn more(zones: &Zones, each: [usize; 2], factor: f64) -> [usize; 2] {
    let wanted = each[0] as f64 * (MARGIN * factor * factor).max(MARGIN);
    if wanted > MOST { each } else { within(zones, wanted).max(each) }
}

fn within(zones: &Zones, wanted: f64) -> [usize; 2] {
    let (p, v) = (zones.voxel_offset() as f64, (zones.len() - zones.voxel_offset()) as f64);
    let fits = (ALL / (p + VOLUME * v).max(1.0)).min(wanted.clamp(FEWEST, MOST));
    [fits.max(1.0) as usize, (VOLUME * fits).max(1.0).ceil() as usize]
}

impl<'a> Seeing<'a> {
    /// Shoots so many rays from every patch, and from every volume zone.
    pub fn new(site: &Site<'a>, each: [usize; 2]) -> Seeing<'a> {
        Seeing {
            scene: site.scene,
            zones: site.zones,
            transport: site.transport,
            views: Views::new(site.scene, site.zones, site.transport, each, site.progress),
            strength: (0..site.zones.len()).into_par_iter().map(|i| strength(site.zones, i)).collect(),
        }
    }

    /// Rays shot.
    pub fn rays(&self) -> u64 {
        self.views.rays()
    }

    /// All groups, passed on along the rays until little is left.
    pub fn solve(&self, site: &Site, escape: &Escape) -> Vec<Ended> {
        let (weights, targets) = (crate::groups::weights(self.zones), targets(self.zones));
        let system = System { operator: self, weights: &weights, targets: &targets };
        krylov::passes(&system, &site.columns(escape), STOP, site.progress)
    }

    /// B of all zones by their strengths.
    fn radiosities(&self, strengths: &[Bands]) -> Vec<[f32; 3]> {
        let over = |s: f64, c: f64| if c > 0.0 { (s / c) as f32 } else { 0.0 };
        let both = strengths.par_iter().zip(&self.strength);
        both.map(|(s, c)| [0, 1, 2].map(|b| over(s[b], c[b]))).collect()
    }

    fn times_measure(&self, v: Vec<Bands>) -> Vec<Bands> {
        v.into_par_iter()
            .enumerate()
            .map(|(i, v)| {
                let measure = response(self.zones, i).1;
                v.map(|x| x * measure)
            })
            .collect()
    }
}

impl Operator for Seeing<'_> {
    fn len(&self) -> usize {
        self.zones.len()
    }
    fn apply(&self, strengths: &[Bands]) -> Vec<Bands> {
        self.times_measure(self.views.arriving(&self.radiosities(strengths)))
    }
    fn arriving(&self, columns: &[Vec<Bands>]) -> Arriving {
        self.look(columns).0
    }
    fn scale(&mut self, _: &[Bands]) {}
    fn grade(&self) -> Grade {
        Grade::Statistical
    }
}

impl Seeing<'_> {
    /// Radiosities in which every group weighs the same: windows that suit them suit all groups, however they are turned up later.
    fn guide(&self, columns: &[Vec<Bands>]) -> Vec<[f32; 3]> {
        let mut out = vec![[0.0f32; 3]; self.len()];
        for s in columns {
            let b = self.radiosities(s);
            let square = b.iter().flatten().map(|x| (*x as f64).powi(2)).sum::<f64>();
            let level = (square / b.len().max(1) as f64).sqrt();
            if level > 0.0 {
                out.iter_mut().zip(&b).for_each(|(o, b)| (0..3).for_each(|k| o[k] += b[k] / level as f32));
            }
        }
        out
    }

    /// What arrives, smoothed; of all columns together before that, P with its standard error; and the relative error where all columns weigh
    /// the same.
    pub fn look(&self, columns: &[Vec<Bands>]) -> (Arriving, Vec<Measured>, f64) {
        let each: Vec<Vec<Bands>> =
            columns.iter().map(|s| self.views.arriving(&self.radiosities(s))).collect();
        let all = total(self.len(), columns);
        let seen: Vec<Measured> = self.views.measured(&self.radiosities(&all));
        let guide = if columns.len() > 1 { Some(self.views.measured(&self.guide(columns))) } else { None };
        let smoother = Smoother::new(self.scene, self.zones, self.transport);
        let (fields, error, even) = smoother.smooth(guide.as_ref().unwrap_or(&seen), &seen, &each);
        let arriving = Arriving {
            columns: fields.into_iter().map(|f| self.times_measure(f)).collect(),
            error: Some(self.times_measure(error)),
        };
        let scaled = |(i, m): (usize, Measured)| {
            let measure = response(self.zones, i).1;
            Measured { value: m.value.map(|v| v * measure), error: m.error.map(|e| e * measure) }
        };
        let raw = seen.into_par_iter().enumerate().map(scaled).collect();
        (arriving, raw, even[0].max(even[1]))
    }
}
