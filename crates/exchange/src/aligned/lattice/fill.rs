//! Values and radii of a family of pairs that differ in their offset alone, eight at a time.
//!
//! A batch takes the cheapest method that is proved for **all** of its offsets: the moments' series (κ = 0), else Gauss rules of
//! the density. Offsets nearer than D/RATIO, and any whose radius came out above the tolerance, go one by one to the judge of single pairs.

use crate::Method;
use crate::aligned::cube::{self, Cube};
use crate::aligned::density::{Grid, Hint};
use crate::aligned::judge::{self, SHARE};
use crate::aligned::moments::{self, Far, Shape};
use crate::aligned::reduced::{AxisDensity, Reduced};
use crate::aligned::{FINEST, integrate};
use rayon::prelude::*;
use zonal_math::simd::{self, LANES};

/// Entries of a table by the method that served them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// By the moments' series.
    pub moments: usize,
    /// By the closed form of two rectangles.
    pub closed: usize,
    /// By Gauss rules.
    pub gauss: usize,
    /// By pyramid coordinates.
    pub pyramid: usize,
    /// By sums of Gaussians.
    pub gaussians: usize,
    /// Patches that do not see each other.
    pub unseen: usize,
}

impl Tally {
    /// The sum over the methods.
    pub fn total(&self) -> usize {
        self.moments + self.closed + self.gauss + self.pyramid + self.gaussians + self.unseen
    }
    fn count(&mut self, method: Method, n: usize) {
        *match method {
            Method::Moments => &mut self.moments,
            Method::Closed => &mut self.closed,
            Method::Pyramid => &mut self.pyramid,
            Method::Unseen => &mut self.unseen,
            _ => &mut self.gauss,
        } += n;
    }
    pub(super) fn plus(self, o: Tally) -> Tally {
        Tally {
            moments: self.moments + o.moments,
            closed: self.closed + o.closed,
            gauss: self.gauss + o.gauss,
            pyramid: self.pyramid + o.pyramid,
            gaussians: self.gaussians + o.gaussians,
            unseen: self.unseen + o.unseen,
        }
    }
}

/// Entries of a parallel piece of work: whole batches.
const CHUNK: usize = 512 * LANES;

/// Pairs of boxes whose centre offsets are (i + shift) · step.
pub(super) struct Family {
    extents: [(f64, f64); 3],
    step: [f64; 3],
    shift: [f64; 3],
    kappa: f64,
    tolerance: f64,
    shape: Shape,
    grid: Grid,
    /// The edge where all boxes are equal cubes without a medium, with the series' constants.
    cube: Option<(f64, &'static Cube)>,
    /// Squared distance from which a batch serves, m².
    far2: f64,
}

/// A list of offsets to fill.
struct Fill<'a> {
    family: &'a Family,
    offsets: &'a [[u16; 3]],
    values: &'a mut [f64],
    radii: &'a mut [f64],
    tally: &'a mut Tally,
}

impl simd::Work for Fill<'_> {
    type Output = ();
    #[inline(always)]
    fn go(self) {
        self.family.batches(self.offsets, self.values, self.radii, self.tally);
    }
}

impl Family {
    /// Boxes of these extents an axis (equal, or one or both zero), m.
    pub(super) fn new(
        extents: [(f64, f64); 3],
        step: [f64; 3],
        shift: [f64; 3],
        kappa: f64,
        tolerance: f64,
    ) -> Family {
        assert!(step.iter().all(|e| *e > 0.0 && e.is_finite()), "edges {step:?}");
        assert!(kappa >= 0.0 && kappa.is_finite(), "extinction {kappa} 1/m");
        assert!(tolerance > 0.0, "tolerance {tolerance}");
        let shape = Shape::new(extents);
        let far2 = shape.least_distance().powi(2) * (1.0 + 1e-9);
        let tolerance = tolerance.clamp(FINEST, 0.1);
        let edge = extents[0].0;
        let cubes = kappa == 0.0 && extents == [(edge, edge); 3];
        let cube = cubes.then(|| (edge, cube::constants()));
        let grid = Grid::new(extents, kappa);
        Family { extents, step, shift, kappa, tolerance, shape, grid, cube, far2 }
    }

    /// The reduced pair at an offset.
    fn pair(&self, offset: [u16; 3]) -> Reduced {
        Reduced(std::array::from_fn(|k| {
            let at = |d: f64| (offset[k] as f64 + self.shift[k] + d) * self.step[k];
            let (long, short) = self.extents[k];
            let p = match (long > 0.0, short > 0.0) {
                (false, _) => [at(0.0); 4],
                (true, false) => [at(-0.5), at(-0.5), at(0.5), at(0.5)],
                (true, true) => [at(-1.0), at(0.0), at(0.0), at(1.0)],
            };
            AxisDensity { long, short, p }
        }))
    }

    /// All offsets on rayon's threads.
    pub(super) fn fill_parallel(&self, offsets: &[[u16; 3]]) -> (Vec<f64>, Vec<f64>, Tally) {
        let (mut values, mut radii) = (vec![0.0; offsets.len()], vec![0.0; offsets.len()]);
        let tally = (offsets.par_chunks(CHUNK), values.par_chunks_mut(CHUNK), radii.par_chunks_mut(CHUNK))
            .into_par_iter()
            .map(|(o, v, r)| self.fill(o, v, r))
            .reduce(Tally::default, Tally::plus);
        (values, radii, tally)
    }

    /// All offsets on this thread.
    pub(super) fn fill(&self, offsets: &[[u16; 3]], values: &mut [f64], radii: &mut [f64]) -> Tally {
        let mut tally = Tally::default();
        simd::run(Fill { family: self, offsets, values, radii, tally: &mut tally });
        tally
    }

    #[inline(always)]
    fn batches(&self, offsets: &[[u16; 3]], values: &mut [f64], radii: &mut [f64], tally: &mut Tally) {
        let mut hint = Hint::default();
        for (i, o) in offsets.chunks(LANES).enumerate() {
            let lanes = i * LANES..i * LANES + o.len();
            self.batch(o, &mut values[lanes.clone()], &mut radii[lanes], tally, &mut hint);
        }
    }

    #[inline(always)]
    fn batch(
        &self,
        offsets: &[[u16; 3]],
        values: &mut [f64],
        radii: &mut [f64],
        tally: &mut Tally,
        hint: &mut Hint,
    ) {
        let mut centre = [[0.0; LANES]; 3];
        // The last batch of a chunk repeats its first offset.
        let mut padded = [offsets[0]; LANES];
        padded[..offsets.len()].copy_from_slice(offsets);
        for k in 0..3 {
            for l in 0..LANES {
                centre[k][l] = (padded[l][k] as f64 + self.shift[k]) * self.step[k];
            }
        }
        let mut nearest = f64::INFINITY;
        let mut r2 = [0.0; LANES];
        for l in 0..LANES {
            r2[l] = centre[0][l] * centre[0][l] + centre[1][l] * centre[1][l] + centre[2][l] * centre[2][l];
            nearest = if r2[l] < nearest { r2[l] } else { nearest };
        }
        if nearest < self.far2 {
            return self.mixed(offsets, centre, r2, values, radii, tally);
        }
        self.keep(offsets, self.serve(&centre, nearest, hint), [true; LANES], values, radii, tally);
    }

    /// A batch with offsets that are too near: they give their lanes to a far one, if there is any.
    #[inline(never)]
    fn mixed(
        &self,
        offsets: &[[u16; 3]],
        mut centre: [[f64; LANES]; 3],
        r2: [f64; LANES],
        values: &mut [f64],
        radii: &mut [f64],
        tally: &mut Tally,
    ) {
        let far = r2.map(|r2| r2 >= self.far2);
        let mut served = None;
        if let Some(some) = (0..LANES).find(|&l| far[l]) {
            for l in (0..LANES).filter(|&l| !far[l]) {
                for k in 0..3 {
                    centre[k][l] = centre[k][some];
                }
            }
            let nearest = (0..LANES).filter(|&l| far[l]).map(|l| r2[l]).fold(f64::INFINITY, f64::min);
            served = self.serve(&centre, nearest, &mut Hint::default());
        }
        self.keep(offsets, served, far, values, radii, tally);
    }

    /// Writes what is as good as asked; the rest goes to the judge of single pairs.
    #[inline(always)]
    fn keep(
        &self,
        offsets: &[[u16; 3]],
        served: Option<([f64; LANES], [f64; LANES], Method)>,
        far: [bool; LANES],
        values: &mut [f64],
        radii: &mut [f64],
        tally: &mut Tally,
    ) {
        let n = offsets.len();
        let mut good = [false; LANES];
        let mut count = 0;
        if let Some((value, radius, method)) = &served {
            for l in 0..LANES {
                good[l] = far[l] & (radius[l] <= self.tolerance * value[l]) & (value[l] > integrate::TINY);
            }
            for l in 0..n {
                (values[l], radii[l]) = (value[l], radius[l]);
                count += good[l] as usize;
            }
            tally.count(*method, count);
        }
        if count < n {
            for l in (0..n).filter(|&l| !good[l]) {
                (values[l], radii[l]) = self.single(offsets[l], tally);
            }
        }
    }

    /// The cheapest method that is proved for the whole batch; `nearest` its least squared distance, m².
    #[inline(always)]
    fn serve(
        &self,
        centre: &[[f64; LANES]; 3],
        nearest: f64,
        hint: &mut Hint,
    ) -> Option<([f64; LANES], [f64; LANES], Method)> {
        if let Some((edge, constants)) = self.cube {
            if let Some(order) = constants.order(edge * edge / nearest, SHARE * self.tolerance) {
                let (value, radius) = constants.factors(order, edge, centre);
                return Some((value, radius, Method::Moments));
            }
        } else if self.kappa == 0.0 {
            let far = Far::new(&self.shape, centre);
            if let Some((order, left)) = moments::order(&self.shape, &far, SHARE * self.tolerance) {
                let (value, radius) = far.finish(&self.shape, order, &left);
                return Some((value, radius, Method::Moments));
            }
        }
        let plan = self.grid.plan_near(centre, SHARE * self.tolerance, hint)?;
        let (value, radius) = self.grid.integrate(centre, &plan);
        Some((value, radius, Method::Gauss))
    }

    #[inline(never)]
    fn single(&self, offset: [u16; 3], tally: &mut Tally) -> (f64, f64) {
        let pair = self.pair(offset);
        let f = if pair.sees() {
            judge::factor_of(&pair, self.kappa, self.tolerance)
        } else {
            crate::Factor::UNSEEN
        };
        tally.count(f.method, 1);
        (f.bounded.value, f.bounded.radius)
    }
}
