//! The exchange of all zones along the rays of their [`Views`], as an operator.
//!
//! It is not symmetric: what i sees of j is sampled at i alone, so that the equations are solved by stabilised bi-conjugate gradients (`bicgstab.rs`).
//! What arrives in the end is smoothed over the zones around ([`super::smooth`]), which lowers the noise and gives its error.

use super::build::beyond_links;
use super::onward::{Lamps, Own};
use super::smooth::Smoother;
use super::views::{Measured, Shine, Views, Way, shine};
use crate::bicgstab;
use crate::columns::total;
use crate::direct::Direct;
use crate::engine::Site;
use crate::groups::{Source, response};
use crate::krylov::{self, Ended, Stop, System};
use crate::operator::{Arriving, Operator};
use crate::pipeline::targets;
use crate::surroundings::Escape;
use rayon::prelude::*;
use zonal_exchange::pair::strength;
use zonal_math::Grade;
use zonal_scene::{Bands, NoVault, Scene, Zones, bands};
use zonal_transport::Transport;

/// Rays of a patch, in small scenes and in those beyond links: so many over the square of the tolerance, no fewer and no more than these.
const RAYS: [f64; 2] = [1.35, 1.45];
const FEWEST: f64 = 32.0;
const MOST: f64 = 2048.0;
/// How many more rays are shot than would just do.
const MARGIN: f64 = 1.3;
/// Rays of a volume zone over those of a patch: its neighbours are more. Fewer where noisy ones shoot again.
const VOLUME: [f64; 2] = [0.3, 0.17];
/// Rays of all zones together at most: half a gigabyte.
const ALL: f64 = 1.34e8;
/// The equations are solved along one of so many rays first, and along all of them from there.
const FIRST: usize = 4;
/// Where the solution along rays stops: the relative error of the strengths, and the products of a column.
const STOP: Stop = Stop { residual: 2e-4, iterations: 200 };

/// All zones and what they see.
pub struct Seeing<'a> {
    pub(super) scene: &'a Scene,
    pub(super) zones: &'a Zones,
    pub(super) transport: &'a Transport<'a>,
    pub(super) direct: &'a Direct,
    pub(super) views: Views,
    /// True where rays go on.
    pub(super) onward: bool,
    /// c of every zone.
    strength: Vec<Bands>,
    /// Of each group, where rays go on; else empty.
    own: Vec<Own>,
}

/// Rays of a volume zone over those of a patch.
pub fn volume(zones: &Zones) -> f64 {
    VOLUME[usize::from(beyond_links(zones))]
}

/// Rays of a patch and of a volume zone for a tolerance; no more than `most` of all zones together.
pub fn rays(zones: &Zones, tolerance: f64, most: f64) -> [usize; 2] {
    within(zones, RAYS[usize::from(beyond_links(zones))] / (tolerance * tolerance), most)
}

/// Rays with which an error falls by a factor; those at hand where more are not allowed, or where that takes more than are worth it and
/// there are `links` to turn to.
pub fn more(zones: &Zones, each: [usize; 2], factor: f64, most: f64, links: bool) -> [usize; 2] {
    let wanted = each[0] as f64 * (MARGIN * factor * factor).max(MARGIN);
    if wanted > MOST && links { each } else { within(zones, wanted, most).max(each) }
}

/// Rays of all zones, with so many of every patch and volume zone.
pub fn count(zones: &Zones, each: [usize; 2]) -> u64 {
    (each[0] * zones.voxel_offset() + each[1] * (zones.len() - zones.voxel_offset())) as u64
}

fn within(zones: &Zones, wanted: f64, most: f64) -> [usize; 2] {
    let (p, v) = (zones.voxel_offset() as f64, (zones.len() - zones.voxel_offset()) as f64);
    // Numbers of volume zones are rounded up: one ray a zone is left for that.
    let most = (most - v).min(ALL);
    let fits = (most / (p + volume(zones) * v).max(1.0)).min(wanted.clamp(FEWEST, MOST));
    [fits.max(1.0) as usize, (volume(zones) * fits).max(1.0).ceil() as usize]
}

impl<'a> Seeing<'a> {
    /// Shoots so many rays from every patch, and from every volume zone; where `onward`, those that end close by go on.
    pub fn new(site: &Site<'a>, each: [usize; 2], onward: bool) -> Seeing<'a> {
        let lamps = onward.then(|| Lamps::new(site.scene, site.direct));
        let views = Views::new(
            site.scene,
            site.zones,
            site.transport,
            each,
            lamps.as_ref(),
            site.vault,
            site.progress,
        );
        Seeing {
            scene: site.scene,
            zones: site.zones,
            transport: site.transport,
            direct: site.direct,
            views,
            onward,
            strength: (0..site.zones.len()).into_par_iter().map(|i| strength(site.zones, i)).collect(),
            own: Vec::new(),
        }
    }

    /// Rays shot, and those that went on.
    pub fn rays(&self) -> [u64; 2] {
        self.views.rays()
    }

    /// What leaves the zones for good, by the same rays.
    pub fn escape(&self, escape: &mut Escape) {
        self.views.escape(self.zones, escape);
    }

    /// All groups, solved along the rays, or passed on so many times as the scene says.
    pub fn solve(&mut self, site: &Site, escape: &Escape) -> Vec<Ended> {
        let (weights, targets) = (crate::groups::weights(self.zones), targets(self.zones));
        let mut columns = site.columns(escape);
        if self.rays()[1] > 0 {
            self.own = columns.iter().zip(site.sources).map(|(c, s)| self.own(site, s, c)).collect();
            for (column, own) in columns.iter_mut().zip(&self.own) {
                let dark = vec![[0.0; 4]; self.len()];
                let lit = self.times_measure(self.views.arriving(&dark, Way::With(own), 1));
                let add = |i: usize, s: &mut Bands| *s = bands(|b| s[b] + weights[i][b] * lit[i][b]);
                column.par_iter_mut().enumerate().for_each(|(i, s)| add(i, s));
            }
        }
        let solved = |share: usize, initial| {
            let operator = &Onward { seeing: self, share };
            let system = System { operator, weights: &weights, targets: &targets };
            bicgstab::solve(&system, &columns, initial, STOP, site.progress)
        };
        if let Some(count) = site.scene.options().sweeps {
            let system =
                System { operator: &Onward { seeing: self, share: 1 }, weights: &weights, targets: &targets };
            return krylov::sweeps(&system, &columns, count, &NoVault, site.progress);
        }
        let near = solved(FIRST, None);
        solved(1, Some(near.into_iter().map(|e| e.strengths).collect()))
    }

    /// The light that patches have of their own in a group of the strengths `column`: all but that of the lights.
    fn own(&self, site: &Site, source: &Source, column: &[Bands]) -> Own {
        let direct = source.direct(site.direct);
        let one = |(i, s): (usize, &Bands)| {
            let (c, p) = (self.strength[i], &self.zones.patches[i]);
            let lit = direct.get(i).copied().unwrap_or_default();
            let all = |b: usize| if c[b] > 0.0 { s[b] / c[b] } else { 0.0 };
            shine(bands(|b| (all(b) - p.reflectance[b] * lit[b]).max(0.0)))
        };
        let counts = |l: usize| if source.has_light(l) { 1.0 } else { 0.0 };
        Own {
            zones: column[..self.zones.voxel_offset()].par_iter().enumerate().map(one).collect(),
            lights: (0..site.direct.lights.len()).map(counts).collect(),
        }
    }

    /// How rays are followed for column `c`.
    pub(super) fn way(&self, c: usize) -> Way<'_> {
        self.own.get(c).map_or(Way::Ends, Way::With)
    }

    /// B of all zones by their strengths.
    fn radiosities(&self, strengths: &[Bands]) -> Vec<Shine> {
        let over = |s: f64, c: f64| if c > 0.0 { s / c } else { 0.0 };
        let both = strengths.par_iter().zip(&self.strength);
        both.map(|(s, c)| shine(bands(|b| over(s[b], c[b])))).collect()
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
        self.times_measure(self.views.arriving(&self.radiosities(strengths), Way::Ends, 1))
    }
    fn arriving(&self, columns: &[Vec<Bands>]) -> Arriving {
        self.look(columns).arriving
    }
    fn scale(&mut self, _: &[Bands]) {}
    fn grade(&self) -> Grade {
        Grade::Statistical
    }
}

/// The same exchange along one of so many rays of every zone, which go on.
struct Onward<'a, 'b> {
    seeing: &'a Seeing<'b>,
    share: usize,
}

impl Operator for Onward<'_, '_> {
    fn len(&self) -> usize {
        self.seeing.len()
    }
    fn apply(&self, strengths: &[Bands]) -> Vec<Bands> {
        let (s, b) = (self.seeing, self.seeing.radiosities(strengths));
        s.times_measure(s.views.arriving(&b, Way::On, self.share))
    }
    fn scale(&mut self, _: &[Bands]) {}
    fn grade(&self) -> Grade {
        Grade::Statistical
    }
}

impl Seeing<'_> {
    /// Radiosities in which every group weighs the same: windows that suit them suit all groups, however they are turned up later.
    fn guide(&self, columns: &[Vec<Bands>]) -> (Vec<Shine>, Own) {
        let mut out = vec![[0.0f32; 4]; self.len()];
        let mut own = Own::default();
        for (c, s) in columns.iter().enumerate() {
            let b = self.radiosities(s);
            let square = b.iter().flatten().map(|x| (*x as f64).powi(2)).sum::<f64>();
            let level = (square / b.len().max(1) as f64).sqrt();
            if level > 0.0 {
                out.iter_mut().zip(&b).for_each(|(o, b)| (0..3).for_each(|k| o[k] += b[k] / level as f32));
                self.own.get(c).into_iter().for_each(|o| own.add(o, 1.0 / level as f32));
            }
        }
        (out, own)
    }

    /// What rays measure of radiosities `b`, and of the own light of the same.
    fn measured(&self, b: &[Shine], own: &Own) -> Vec<Measured> {
        let way = if self.own.is_empty() { Way::Ends } else { Way::With(own) };
        self.views.measured(b, way)
    }

    /// What arrives, and how well that is known.
    pub fn look(&self, columns: &[Vec<Bands>]) -> Looked {
        let shine: Vec<Vec<Shine>> = columns.iter().map(|s| self.radiosities(s)).collect();
        let mut own = Own::default();
        self.own.iter().for_each(|o| own.add(o, 1.0));
        let all = self.radiosities(&total(self.len(), columns));
        let seen: Vec<Measured> = self.measured(&all, &own);
        // Of one column that is all already.
        let one = |(c, b): (usize, &Vec<Shine>)| match columns.len() {
            1 => seen.iter().map(|m| m.value).collect(),
            _ => self.views.arriving(b, self.way(c), 1),
        };
        let each: Vec<Vec<Bands>> = shine.iter().enumerate().map(one).collect();
        let guide = (columns.len() > 1).then(|| {
            let (b, own) = self.guide(columns);
            self.measured(&b, &own)
        });
        let smoother = Smoother::new(self.scene, self.zones, self.transport);
        let (mut fields, mut error, even) = smoother.smooth(guide.as_ref().unwrap_or(&seen), &seen, &each);
        drop(smoother);
        let again = match beyond_links(self.zones) {
            true => self.again(&shine, &each, &seen, &mut fields, &mut error),
            false => 0,
        };
        let arriving = Arriving {
            columns: fields.into_iter().map(|f| self.times_measure(f)).collect(),
            error: Some(self.times_measure(error)),
        };
        let scaled = |(i, m): (usize, Measured)| {
            let measure = response(self.zones, i).1;
            Measured { value: m.value.map(|v| v * measure), error: m.error.map(|e| e * measure) }
        };
        let raw = seen.into_par_iter().enumerate().map(scaled).collect();
        Looked { arriving, raw, even: even[0].max(even[1]), again }
    }
}

/// What [`Seeing::look`] finds.
pub struct Looked {
    /// What arrives, smoothed, P.
    pub arriving: Arriving,
    /// P of all columns together before that, with its standard error.
    pub raw: Vec<Measured>,
    /// The relative error where all columns weigh the same.
    pub even: f64,
    /// Rays shot again.
    pub again: u64,
}
