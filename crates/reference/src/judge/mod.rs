//! An independent judge of whole scenes: irradiance, fluence and pictures by paths of light, with standard errors.
//!
//! ```text
//! H = π ∫ L cosθ/π dω, the mean over a patch        G = 4π ∫ L/(4π) dω, the mean over the free part of a cell
//! ```
//!
//! Paths start at the receiver and run backwards; there are no zones, no factors and no equations. Surfaces are diffuse, one- or
//! two-sided (a side that does not take part is black, cold and opaque); media and panes scatter evenly in all directions. What a
//! scene lists as lights is ordinary emission here and is only told apart in the sums: [`Reading::incident`] leaves direct light out,
//! as a solution's field of that name does.
//!
//! | module | what |
//! |---|---|
//! | [`tree`] | the facets in a binary tree of boxes |
//! | [`space`] | what lies along a ray: facets, cells, panes |
//! | [`lamps`] | suns, sky and emitting facets |
//! | [`path`] | one path |
//! | [`picture`] | pictures of a camera |
//!
//! Unlike the other oracles of this crate it is made for scenes of any size; the tree is checked against the walk over every facet.
//! Every number drawn is a function of seed, receiver, replicate and path: the same bits for any number of threads.

pub mod lamps;
pub mod path;
pub mod picture;
pub mod space;
pub mod tree;

pub use picture::Picture;
pub use space::{Space, Vertex};

use crate::{Dice, Estimate, Tally};
use lamps::Lamps;
use path::{Draws, Found, Paths};
use rayon::prelude::*;
use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_scene::zones::SUBCELLS;
use zonal_scene::{Bands, Patch, Plate, Sample, Scene, VoxelZone, Voxmap};

/// Independent replicates of a mean: their spread gives its standard error to about nine per cent.
pub const REPLICATES: usize = 64;
/// Paths of the first look at a receiver in each replicate.
const PILOT: usize = 48;
/// The first look's own error makes the paths that it asks for uncertain: ask for this many times as many.
const MARGIN: f64 = 1.2;
/// Numbers of a path that are spread evenly over the paths of a replicate.
const SPREAD: usize = 9;
/// Tries to draw a point of a sub-cell that its sample sees.
const TRIES: usize = 200;

/// Where light is received.
#[derive(Clone, Debug)]
pub enum Receiver {
    /// The side of a plate that `normal` points to: H, the mean over its area.
    Patch {
        /// Shape.
        plate: Plate,
        /// Unit normal of the side that receives.
        normal: Vec3,
    },
    /// A point in free space: G there.
    Point(Vec3),
    /// A box without obstacles: G, the mean over its volume.
    Cell {
        /// Lower corner, m.
        lo: Vec3,
        /// Upper corner, m.
        hi: Vec3,
    },
    /// The free part of a cell that walls cut: boxes, each with its share of the volume and a point. The points of a box that see
    /// its point belong to the part.
    Part(Vec<Piece>),
    /// A piece of a pane: G, the mean over its volume.
    Pane {
        /// Index of the pane.
        pane: usize,
        /// Shape of the middle plane.
        plate: Plate,
    },
}

/// A box of a cut cell.
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// Lower corner, m.
    pub lo: Vec3,
    /// Upper corner, m.
    pub hi: Vec3,
    /// A point of the part.
    pub point: Vec3,
    /// Free volume, m³.
    pub volume: f64,
}

impl Receiver {
    /// The side of a patch that exchanges.
    pub fn patch(p: &Patch) -> Receiver {
        Receiver::Patch { plate: p.plate, normal: p.normal }
    }

    /// A voxel zone.
    pub fn voxel(z: &VoxelZone, map: &Voxmap) -> Receiver {
        let c = map.coordinates(z.cell);
        let (lo, edge) = (map.corner(c), map.cell());
        if z.part.is_empty() {
            return Receiver::Cell { lo, hi: lo + edge };
        }
        let small = edge / SUBCELLS as f64;
        let piece = |s: Sample| {
            let k = s.subcell as usize;
            let at = [k / (SUBCELLS * SUBCELLS), k / SUBCELLS % SUBCELLS, k % SUBCELLS].map(|i| i as f64);
            let lo = lo + small.scale(Vec3::from_array(at));
            Piece { lo, hi: lo + small, point: s.point, volume: s.volume }
        };
        Receiver::Part(z.part.iter().map(piece).collect())
    }

    /// True where the result is an irradiance.
    fn is_surface(&self) -> bool {
        matches!(self, Receiver::Patch { .. })
    }
}

/// How well to measure.
#[derive(Clone, Copy, Debug)]
pub struct Accuracy {
    /// Wanted standard error, relative to the receiver's mean in each band.
    pub relative: f64,
    /// A receiver whose mean is below this share of the mean over all receivers is measured as if it had that much.
    pub floor: f64,
    /// The most paths of a receiver.
    pub max_paths: u64,
}

impl Default for Accuracy {
    fn default() -> Self {
        Accuracy { relative: 0.01, floor: 0.1, max_paths: 1 << 22 }
    }
}

/// H or G of a receiver, W/m².
#[derive(Clone, Copy, Debug, Default)]
pub struct Reading {
    /// All light.
    pub total: [Estimate; 3],
    /// All but direct light.
    pub incident: [Estimate; 3],
    /// Paths that were run.
    pub paths: u64,
}

/// A scene made ready to be judged.
pub struct Judge<'a> {
    paths: Paths<'a>,
    /// The numbers by which the well spread ones advance from path to path.
    steps: [f64; SPREAD],
}

impl<'a> Judge<'a> {
    /// Builds the trees and collects the lights.
    pub fn new(scene: &'a Scene) -> Judge<'a> {
        let paths = Paths { space: Space::new(scene), lamps: Lamps::new(scene), max_bounces: usize::MAX - 1 };
        Judge { paths, steps: steps() }
    }

    /// The same, but light that was scattered more than `bounces` times counts for nothing.
    pub fn with_max_bounces(mut self, bounces: usize) -> Judge<'a> {
        self.paths.max_bounces = bounces;
        self
    }

    /// The scene with its trees.
    pub fn space(&self) -> &Space<'a> {
        &self.paths.space
    }

    /// Measures receivers of one kind (all H, or all G): a first look says how many paths each deserves, then these are run anew, so
    /// that what the first look found by chance biases nothing.
    pub fn measure(&self, receivers: &[Receiver], accuracy: &Accuracy, seed: u64) -> Vec<Reading> {
        let pilots = self.run(receivers, &vec![PILOT as u64; receivers.len()], hash(seed, 1));
        let n = receivers.len().max(1) as f64;
        let overall = [0, 1, 2].map(|b| pilots.iter().map(|r| r.total[b].value).sum::<f64>() / n);
        let most = accuracy.max_paths.div_ceil(REPLICATES as u64).max(PILOT as u64);
        let counts: Vec<u64> = pilots
            .iter()
            .map(|r| {
                let excess = (0..3).map(|b| {
                    let wanted = accuracy.relative * r.total[b].value.max(accuracy.floor * overall[b]);
                    if r.total[b].error > 0.0 { (r.total[b].error / wanted).powi(2) } else { 0.0 }
                });
                let excess = excess.fold(0.0, f64::max);
                ((PILOT as f64 * excess * MARGIN).ceil() as u64).clamp(PILOT as u64, most)
            })
            .collect();
        self.run(receivers, &counts, hash(seed, 2))
    }

    /// Measures one receiver with a given number of paths, rounded up to whole replicates.
    pub fn one(&self, receiver: &Receiver, paths: u64, seed: u64) -> Reading {
        let count = paths.div_ceil(REPLICATES as u64).max(1);
        self.run(std::slice::from_ref(receiver), &[count], seed)[0]
    }

    /// Runs `counts[i]` paths in each replicate of receiver i.
    fn run(&self, receivers: &[Receiver], counts: &[u64], seed: u64) -> Vec<Reading> {
        let means: Vec<[Bands; 2]> = (0..receivers.len() * REPLICATES)
            .into_par_iter()
            .map(|k| {
                let i = k / REPLICATES;
                self.replicate(&receivers[i], counts[i], hash(hash(seed, i as u64), (k % REPLICATES) as u64))
            })
            .collect();
        let reading = |i: usize| {
            let part = &means[i * REPLICATES..(i + 1) * REPLICATES];
            let estimate = |which: usize, b: usize| {
                let mut tally = Tally::default();
                part.iter().for_each(|m| tally.add(m[which][b]));
                tally.estimate(1.0)
            };
            Reading {
                total: [0, 1, 2].map(|b| estimate(0, b)),
                incident: [0, 1, 2].map(|b| estimate(1, b)),
                paths: counts[i] * REPLICATES as u64,
            }
        };
        (0..receivers.len()).map(reading).collect()
    }

    /// Means of all light and of indirect light over `count` paths.
    fn replicate(&self, receiver: &Receiver, count: u64, seed: u64) -> [Bands; 2] {
        let mut dice = Dice::new(hash(seed, u64::MAX));
        let shift: [f64; SPREAD] = std::array::from_fn(|_| dice.roll());
        let scale = (if receiver.is_surface() { PI } else { 4.0 * PI }) / count as f64;
        let mut sums = [[0.0; 3]; 2];
        for j in 0..count {
            let spread = (0..SPREAD).map(|k| (shift[k] + j as f64 * self.steps[k]).fract()).collect();
            let mut draws = Draws { spread, dice: Dice::new(hash(seed, j)) };
            let vertex = self.start(receiver, &mut draws);
            let Found { total, direct } = self.paths.received(vertex, &mut draws);
            for b in 0..3 {
                sums[0][b] += scale * total[b];
                sums[1][b] += scale * (total[b] - direct[b]);
            }
        }
        sums
    }

    /// A point of the receiver.
    fn start(&self, receiver: &Receiver, draws: &mut Draws) -> Vertex {
        let u: [f64; 3] = draws.some();
        match receiver {
            Receiver::Patch { plate, normal } => {
                let [s, t] = plate.warp([u[0], u[1]]);
                Vertex::Surface { at: plate.at(s, t), normal: *normal, facet: None }
            }
            Receiver::Point(at) => Vertex::Free { at: *at },
            Receiver::Cell { lo, hi } => Vertex::Free { at: *lo + (*hi - *lo).scale(Vec3::from_array(u)) },
            Receiver::Part(pieces) => Vertex::Free { at: self.point_of(pieces, u[0], &mut draws.dice) },
            Receiver::Pane { pane, plate } => {
                let [s, t] = plate.warp([u[0], u[1]]);
                let height = u[2] * self.paths.space.scene.panes()[*pane].thickness;
                Vertex::Pane { at: plate.at(s, t), normal: plate.normal(), pane: *pane, height }
            }
        }
    }

    /// A point of a cut cell: a box by its volume, in it a point that its own point sees.
    fn point_of(&self, pieces: &[Piece], u: f64, dice: &mut Dice) -> Vec3 {
        let mut rest = u * pieces.iter().map(|p| p.volume).sum::<f64>();
        let chosen = pieces.iter().find(|p| {
            rest -= p.volume;
            rest <= 0.0
        });
        let p = chosen.unwrap_or(&pieces[pieces.len() - 1]);
        (0..TRIES)
            .map(|_| dice.in_box(p.lo, p.hi))
            .find(|x| self.paths.space.sees(p.point, *x))
            .unwrap_or(p.point)
    }
}

/// φ^{−k} with φ the positive root of x^{d+1} = x + 1: a lattice for d numbers at once (Roberts 2018).
fn steps() -> [f64; SPREAD] {
    let d = SPREAD as i32;
    let mut phi = 1.5f64;
    for _ in 0..60 {
        phi -= (phi.powi(d + 1) - phi - 1.0) / ((d + 1) as f64 * phi.powi(d) - 1.0);
    }
    std::array::from_fn(|k| phi.powi(-(k as i32 + 1)))
}

/// A well mixed number of two (the finaliser of SplitMix64).
pub(crate) fn hash(a: u64, b: u64) -> u64 {
    let mut z = a.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(b).wrapping_add(0x9E37_79B9_7F4A_7C15);
    for _ in 0..2 {
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
    }
    z
}
