//! Time of rays from the zones beforehand: a few of them are shot, and whoever asks takes the time.

use super::budget::Budget;
use super::build::beyond_links;
use super::onward::Lamps;
use super::shooter::{NOWHERE, Shooter};
use crate::direct::{Direct, Lit};
use rayon::prelude::*;
use zonal_scene::{Scene, Zones};
use zonal_transport::Transport;

/// Neighbours of one run of the sample, whose rays find the same parts of the scene at hand as in a solve.
const RUN: usize = 64;
/// Runs of patches, and of volume zones, at most.
const RUNS: usize = 64;
/// Rays of a zone.
const RAYS: usize = 16;
/// What is left of the light when it has been passed on often enough.
const LEFT: f64 = 2e-3;
/// The most often that it is passed on.
const OFTEN: f64 = 200.0;

/// What the sample says of all rays of a solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Trial {
    /// Seconds of all rays from the zones.
    pub seconds: f64,
    /// Places from which rays go on, all together.
    pub onward: f64,
    /// How often the light is passed on.
    pub passes: f64,
}

/// One kind of zones in the sample.
#[derive(Default)]
struct Kind {
    shot: usize,
    steps: usize,
    /// Sum of what the zones met send on.
    sent: f64,
}

/// Shoots a sample of the rays with `each` of every patch and volume zone; `clock` tells seconds.
pub fn trial(
    scene: &Scene,
    zones: &Zones,
    transport: &Transport,
    each: [usize; 2],
    clock: &dyn Fn() -> f64,
) -> Trial {
    let shooter = Shooter::new(scene, zones, transport);
    let onward = beyond_links(zones);
    // Rays that go on ask a light: which one matters little for the time.
    let lit = |_| Lit { fields: vec![[1.0; 3]; zones.voxel_offset()], ..Lit::default() };
    let direct = Direct { lights: scene.lights().iter().filter(|_| onward).map(lit).collect() };
    let lamps = onward.then(|| Lamps::new(scene, &direct));
    let first = zones.voxel_offset();
    let mut out = Trial::default();
    let (mut shot, mut sent) = (0.0, 0.0);
    for (range, each) in [(0..first, each[0]), (first..zones.len(), each[1])] {
        let all = (range.len() * each) as f64;
        if range.is_empty() {
            continue;
        }
        let timed = || {
            let start = clock();
            let kind = sample(&shooter, lamps.as_ref(), range.clone());
            (kind, clock() - start)
        };
        // The first time the scene is not at hand yet.
        let (kind, first) = timed();
        let seconds = timed().1.min(first);
        let share = all / kind.shot as f64;
        out.seconds += seconds * share;
        out.onward += kind.steps as f64 * share;
        (shot, sent) = (shot + all, sent + kind.sent * share);
    }
    let kept = if shot > 0.0 { (sent / shot).clamp(0.0, 1.0) } else { 0.0 };
    out.passes = if kept <= LEFT { 1.0 } else { (LEFT.ln() / kept.ln()).clamp(1.0, OFTEN) };
    out
}

fn sample(shooter: &Shooter, lamps: Option<&Lamps>, range: std::ops::Range<usize>) -> Kind {
    let runs = range.len().div_ceil(RUN).min(RUNS);
    let stride = range.len() / runs;
    let one = |run: usize| {
        let start = range.start + run * stride;
        let mut kind = Kind::default();
        let mut steps = Vec::new();
        let end = (start + RUN.min(stride)).min(range.end);
        let of = |r: usize| (start + r / RAYS, r % RAYS);
        kind.shot = RAYS * (end - start);
        shooter.volley(kind.shot, of, |r, stop| {
            kind.sent += response(shooter.zones, stop.zone);
            if let Some(l) = lamps {
                shooter.follow(l, of(r), stop, &mut steps);
            }
        });
        kind.steps = steps.len();
        kind
    };
    let add =
        |a: Kind, b: Kind| Kind { shot: a.shot + b.shot, steps: a.steps + b.steps, sent: a.sent + b.sent };
    let done: Vec<Kind> = (0..runs).into_par_iter().with_max_len(1).map(one).collect();
    done.into_iter().fold(Kind::default(), add)
}

/// The largest ρ or Ω of a zone that a ray met.
fn response(zones: &Zones, zone: u32) -> f64 {
    let v = match zone {
        NOWHERE.. => return 0.0,
        z if (z as usize) < zones.voxel_offset() => zones.patches[z as usize].reflectance,
        z if (z as usize) < zones.pane_offset() => zones.voxels[z as usize - zones.voxel_offset()].albedo,
        z => zones.panes[z as usize - zones.pane_offset()].albedo,
    };
    v[0].max(v[1]).max(v[2])
}

impl Budget {
    /// Bytes with these rays, where so many go on.
    pub fn with_trial(&self, rays: u64, onward: f64) -> u64 {
        self.fixed + (self.plain * rays as f64 + super::onward::BYTES as f64 * onward) as u64
    }
}
