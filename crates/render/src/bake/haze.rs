//! The medium on a grid of points, as fine as memory allows: what a viewer marches through.
//!
//! ```text
//!     B_g(x) = B_ind,g(x) + Ω/4 · G_dir,g(x)
//! ```
//!
//! Where the grid of the voxmap is coarse its cells are divided, alike along each axis: B_ind is the interpolated field of the
//! renderer, and G_dir is gathered anew at points of each part, so that shafts are narrower than cells. Where it is fine the zones' own
//! values serve, and where it is finer than wanted, means over blocks of cells. Points inside solids have what their neighbours have,
//! so that interpolation between points does not darken what lies before a wall.

use super::share::Share;
use crate::voxel_field::VoxelField;
use rayon::prelude::*;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, Light, Progress, Solution, Voxmap, bands};
use zonal_transport::Transport;
use zonal_transport::direct::{Lamp, Receiver};

/// The most points along an axis: what any graphics card takes.
pub const MAX_SIDE: usize = 256;
/// Cells are divided into at most so many along an axis.
const MAX_PARTS: usize = 12;
/// Points of a part at which direct light is asked, a lamp.
const SAMPLES: usize = 4;
/// A sky among other lights takes this many times as many.
const SKY: usize = 8;

/// How many points.
#[derive(Clone, Debug, PartialEq)]
pub struct HazeOptions {
    /// Cells are divided as long as there are no more points than this; 500,000.
    pub divided: usize,
    /// Blocks of cells become one point where there are more cells than this; 1,500,000.
    pub most: usize,
}

impl Default for HazeOptions {
    fn default() -> Self {
        HazeOptions { divided: 500_000, most: 1_500_000 }
    }
}

/// The medium on a regular grid; lists have one entry a point, z fastest, each point in the middle of its part of the box.
#[derive(Clone, Debug, PartialEq)]
pub struct Haze {
    /// Lower corner of the box, m.
    pub min: Vec3,
    /// Upper corner, m.
    pub max: Vec3,
    /// Points along x, y, z.
    pub dims: [usize; 3],
    /// Extinction κ, 1/m a band; one entry where it is the same everywhere.
    pub extinction: Vec<[f32; 3]>,
    /// Radiosity B, direct light included, W/m² a band: `radiosity[group][point]`.
    pub radiosity: Vec<Vec<[f32; 3]>>,
}

/// The medium of a solution; `None` without one, or where it has no extinction.
pub fn haze(solution: &Solution, options: &HazeOptions, progress: &dyn Progress) -> Option<Haze> {
    let map = solution.scene.voxmap()?;
    if solution.zones.voxels.iter().all(|z| z.extinction == [0.0; 3]) {
        return None;
    }
    let transport = Transport::new(&solution.scene);
    let grid = Grid::new(map, options);
    let shares = Share::all(solution);
    progress.begin("medium", shares.len() as u64);
    let places = grid.places(solution, &transport);
    let known: Vec<bool> = places.iter().map(|p| !p.is_empty()).collect();
    let order = spread(&known, grid.dims);
    let extinction = grid.mean(&places, |z, _| solution.zones.voxels[z].extinction);
    let radiosity = shares
        .iter()
        .map(|share| {
            let mut values = one(solution, &transport, share, &grid, &places);
            fill(&mut values, &order);
            progress.advance(1);
            values
        })
        .collect();
    progress.end();
    let (min, max) = (map.min(), map.max());
    Some(Haze { min, max, dims: grid.dims, extinction: even(extinction, &known, &order), radiosity })
}

/// The grid: cells divided, or several cells a point.
struct Grid<'a> {
    map: &'a Voxmap,
    dims: [usize; 3],
    /// Parts of a cell along an axis, or 1.
    parts: usize,
    /// Cells of a point along an axis, or 1.
    block: usize,
}

/// The zones of a point, each with where it is asked.
type Places = Vec<(usize, Vec3)>;

impl<'a> Grid<'a> {
    fn new(map: &'a Voxmap, options: &HazeOptions) -> Grid<'a> {
        let cells = map.dims();
        let fits = |n: [usize; 3], most: usize| {
            n.iter().product::<usize>() <= most && n.iter().all(|&x| x <= MAX_SIDE)
        };
        let parts = (2..=MAX_PARTS).rev().find(|k| fits(cells.map(|n| n * k), options.divided)).unwrap_or(1);
        let block = (1..).find(|m| fits(cells.map(|n| n.div_ceil(*m)), options.most.max(1))).unwrap_or(1);
        let dims = cells.map(|n| (n * parts).div_ceil(block));
        Grid { map, dims, parts, block }
    }

    fn coordinates(&self, i: usize) -> [usize; 3] {
        let [_, ny, nz] = self.dims;
        [i / (ny * nz), i / nz % ny, i % nz]
    }

    fn places(&self, s: &Solution, transport: &Transport) -> Vec<Places> {
        let n = self.dims.iter().product();
        let of = |i: usize| {
            let at = self.coordinates(i);
            if self.parts == 1 { self.block_of(s, at) } else { self.part_of(s, transport, at) }
        };
        (0..n).into_par_iter().map(of).collect()
    }

    /// All zones of the cells of a point.
    fn block_of(&self, s: &Solution, at: [usize; 3]) -> Places {
        let range = |k: usize| at[k] * self.block..((at[k] + 1) * self.block).min(self.map.dims()[k]);
        let mut out = Vec::new();
        for x in range(0) {
            for y in range(1) {
                for z in range(2) {
                    out.extend(
                        s.zones.of_cell(self.map.index([x, y, z])).map(|i| (i, s.zones.voxels[i].centre)),
                    );
                }
            }
        }
        out
    }

    /// The zone in the middle of a part of a cell.
    fn part_of(&self, s: &Solution, transport: &Transport, at: [usize; 3]) -> Places {
        let cell = self.map.index(at.map(|x| x / self.parts));
        let p = self.point(at, vec3(0.5, 0.5, 0.5));
        if transport.has_places_without_medium() && !transport.holds_medium(p) {
            return Vec::new();
        }
        transport.zone_in(&s.zones, cell, p).map(|z| (z, p)).into_iter().collect()
    }

    /// A point of a part, its share of the part's edges given.
    fn point(&self, at: [usize; 3], share: Vec3) -> Vec3 {
        let edge = self.map.cell() * (self.block as f64 / self.parts as f64);
        self.map.min() + edge.scale(vec3(at[0] as f64, at[1] as f64, at[2] as f64) + share)
    }

    /// Means over the zones of each point.
    fn mean(&self, places: &[Places], value: impl Fn(usize, Vec3) -> Bands + Sync) -> Vec<[f32; 3]> {
        let of = |list: &Places| {
            let mut sum = [0.0; 3];
            for &(zone, p) in list {
                let x = value(zone, p);
                sum = bands(|b| sum[b] + x[b] / list.len() as f64);
            }
            sum.map(|x| x as f32)
        };
        places.par_iter().map(of).collect()
    }
}

/// B of one group.
fn one(s: &Solution, transport: &Transport, share: &Share, grid: &Grid, places: &[Places]) -> Vec<[f32; 3]> {
    let (offset, voxels) = (s.zones.voxel_offset(), &s.zones.voxels);
    if grid.parts == 1 {
        return grid.mean(places, |z, _| share.radiosity(offset + z));
    }
    let sampled = !share.is_smooth();
    let lamps: Vec<Lamp> = s
        .scene
        .lights()
        .iter()
        .enumerate()
        .filter(|(l, _)| sampled && share.kind.has_light(*l))
        .map(|(_, l)| Lamp::new(&s.scene, l))
        .collect();
    let rest = |i: usize| {
        let (b, direct) = (share.radiosity(offset + i), share.direct(offset + i));
        bands(|k| b[k] - if lamps.is_empty() { 0.0 } else { voxels[i].albedo[k] * direct[k] / 4.0 })
    };
    let Some(field) = VoxelField::of(s, transport, (0..voxels.len()).into_par_iter().map(rest).collect())
    else {
        return Vec::new();
    };
    let at = |(i, list): (usize, &Places)| {
        let Some(&(zone, p)) = list.first() else { return [0.0; 3] };
        let (b, at) = (field.at(zone, p), grid.coordinates(i));
        let mut direct = [0.0; 3];
        for lamp in &lamps {
            let g = gathered(s, transport, lamp, grid, at, zone);
            direct = bands(|k| direct[k] + g[k]);
        }
        bands(|k| b[k] + voxels[zone].albedo[k] * direct[k] / 4.0).map(|x| x as f32)
    };
    places.par_iter().enumerate().map(at).collect()
}

/// G_dir of a lamp, the mean over points of a part that lie in the same zone: the middles of every second of its eighths.
fn gathered(
    s: &Solution,
    transport: &Transport,
    lamp: &Lamp,
    grid: &Grid,
    at: [usize; 3],
    zone: usize,
) -> Bands {
    const CORNERS: [[f64; 3]; SAMPLES] =
        [[0.25, 0.25, 0.25], [0.75, 0.75, 0.25], [0.75, 0.25, 0.75], [0.25, 0.75, 0.75]];
    let cell = s.zones.voxels[zone].cell;
    let samples = if matches!(lamp.light(), Light::Sky { .. }) { SKY } else { 1 };
    let (mut sum, mut n) = ([0.0; 3], 0.0);
    for (i, [x, y, z]) in CORNERS.into_iter().enumerate() {
        let p = grid.point(at, vec3(x, y, z));
        if transport.zone_in(&s.zones, cell, p) == Some(zone) {
            let g = lamp.gather(transport, p, Receiver::Free, samples, i as u64);
            sum = bands(|b| sum[b] + g[b]);
            n += 1.0;
        }
    }
    if n > 0.0 {
        sum.map(|x| x / n)
    } else {
        lamp.gather(transport, grid.point(at, vec3(0.5, 0.5, 0.5)), Receiver::Free, samples, 0)
    }
}

/// Points without a zone beside others that have a value, in the order in which they are given one: each with those it is the mean of.
fn spread(known: &[bool], dims: [usize; 3]) -> Vec<(usize, Vec<usize>)> {
    let step = [dims[1] * dims[2], dims[2], 1];
    let mut have = known.to_vec();
    let mut order: Vec<(usize, Vec<usize>)> = Vec::new();
    for _ in 0..2 {
        let start = order.len();
        for i in (0..have.len()).filter(|&i| !have[i]) {
            let at = [i / step[0], i / step[1] % dims[1], i % dims[2]];
            let around = (0..3).flat_map(|k| {
                let below = (at[k] > 0).then(|| i - step[k]);
                [below, (at[k] + 1 < dims[k]).then(|| i + step[k])]
            });
            let list: Vec<usize> = around.flatten().filter(|&j| have[j]).collect();
            if !list.is_empty() {
                order.push((i, list));
            }
        }
        order[start..].iter().for_each(|(i, _)| have[*i] = true);
    }
    order
}

fn fill(values: &mut [[f32; 3]], order: &[(usize, Vec<usize>)]) {
    for (i, from) in order {
        values[*i] = [0, 1, 2].map(|b| from.iter().map(|&j| values[j][b]).sum::<f32>() / from.len() as f32);
    }
}

/// One entry where all points with a zone agree, else all.
fn even(mut values: Vec<[f32; 3]>, known: &[bool], order: &[(usize, Vec<usize>)]) -> Vec<[f32; 3]> {
    let mut own = values.iter().zip(known).filter(|(_, k)| **k).map(|(v, _)| *v);
    if let Some(first) = own.next()
        && own.all(|v| v == first)
    {
        return vec![first];
    }
    fill(&mut values, order);
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{furnace, medium, quad, solution, surface};
    use zonal_scene::Quiet;
    use zonal_scene::scene::SceneParts;

    fn with(divided: usize, most: usize) -> HazeOptions {
        HazeOptions { divided, most }
    }

    /// Fluence 4 and albedo ½, no emission: B = ½.
    #[test]
    fn a_furnace_is_even_however_finely_it_is_asked() {
        let s = solution(furnace(), |_, _| 1.0, |_| 1.0);
        for (options, dims) in [
            (with(6000, 1000), [21, 18, 15]),
            (with(0, 1000), [7, 6, 5]),
            (with(0, 100), [4, 3, 3]),
            (with(0, 1), [1, 1, 1]),
        ] {
            let h = haze(&s, &options, &Quiet).unwrap();
            assert_eq!(h.dims, dims);
            assert_eq!((h.radiosity.len(), h.extinction.len()), (1, 1));
            assert!(h.radiosity[0].iter().flatten().all(|b| (b - 0.5).abs() < 1e-6));
            assert!(h.extinction[0].iter().all(|k| (k - 1.3).abs() < 1e-6));
        }
    }

    #[test]
    fn a_shaft_is_as_narrow_as_what_lets_it_through() {
        let (lo, hi) = (vec3(0.0, 0.0, 0.0), vec3(2.0, 2.0, 2.0));
        let parts = SceneParts {
            surfaces: vec![surface("board", 0.0, 0.0)],
            facets: vec![quad(0, vec3(-1.0, -1.0, 1.5), vec3(1.75, 0.0, 0.0), vec3(0.0, 4.0, 0.0))],
            lights: vec![Light::Sun {
                name: "sun".into(),
                direction: vec3(0.0, 0.0, -1.0),
                irradiance: [8.0; 3],
                angular_diameter: 0.0,
            }],
            voxmap: Some(medium(lo, hi, [2, 2, 2], 0.1, 0.5)),
            ..SceneParts::default()
        };
        let s = solution(parts, |_, _| 0.0, |_| 0.0);
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| haze(&s, &with(4096, 4096), &Quiet).unwrap())
        };
        let h = run(1);
        assert_eq!(h, run(3));
        assert_eq!(h.dims, [16; 3]);
        let own = s.zones.emission(s.zones.voxel_offset())[0];
        for (i, b) in h.radiosity[0].iter().enumerate() {
            let [x, _, z] = [i / 256, i / 16 % 16, i % 16].map(|k| (k as f64 + 0.5) / 8.0);
            let lit = if x < 0.75 && z < 1.5 { 0.0 } else { 8.0 * (-0.1 * (2.0 - z)).exp() };
            let expected = own + 0.5 / 4.0 * lit;
            assert!((b[0] as f64 - expected).abs() < 1e-4, "{x} {z}: {} {expected}", b[0]);
        }
    }
}
