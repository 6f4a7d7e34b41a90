//! A grid of an OpenVDB file onto the cells of the medium.
//!
//! Cell c gets the density Σ_v d_v |v ∩ c| / Σ_v |v ∩ c| over the active voxels v, in the share Σ_v |v ∩ c| / |c| of its
//! volume: the integral of the density stays as it is. Where the grid's axes lie along those of the scene, the overlaps are
//! exact; else a voxel is halved until its parts are no longer than half a cell, and each part stands as a cube of its
//! volume about its centre, so that the integral is kept there too.
//!
//! A level set with distance d and voxels of edge h stands for the density 1 in the share ½ − d/h (0 to 1) of each voxel.

use super::tree::Block;
use super::{VdbGrid, bytes, open};
use crate::input::density::Filling;
use crate::input::error::{Fault, InputError};
use crate::input::medium::Grid;
use crate::input::mesh::place::turned;
use crate::input::node::Table;
use zonal_math::{Vec3, vec3};
use zonal_scene::Bands;

/// Axes count as parallel, or as square to each other, up to this share of their lengths.
const STRAIGHT: f64 = 1e-9;
/// Work is refused above this many steps a cell of the medium and a value of the file: no sound grid comes near.
const STEPS_A_CELL: u64 = 512;
const STEPS_A_VALUE: u64 = 64;
/// A share of the integral outside the medium that is worth a note.
const OUTSIDE: f64 = 1e-6;

/// What the scene says of a grid and its place.
pub(crate) struct Placing {
    /// The box that the active voxels are to fill.
    bounds: Option<(Vec3, Vec3)>,
    grid: Option<String>,
    /// The images of the file's unit vectors, m.
    axes: [Vec3; 3],
    translate: Vec3,
    level_set: bool,
}

impl Placing {
    /// Reads the keys that only OpenVDB files know.
    pub(crate) fn read(t: &Table<'_>, bounds: Option<(Vec3, Vec3)>) -> Result<Placing, InputError> {
        if let (Some(_), Some(n)) = (bounds, t.get("unit").or_else(|| t.get("translate"))) {
            return Err(n.error("min and max already place the grid; remove them, or this key"));
        }
        let unit = t.read("unit", |n| n.positive())?.unwrap_or(1.0);
        Ok(Placing {
            bounds,
            grid: t.read("grid", |n| n.text())?.map(str::to_string),
            axes: turned(t, unit)?,
            translate: t.read("translate", |n| n.vector())?.unwrap_or_default(),
            level_set: t.read("level_set", |n| n.boolean())?.unwrap_or(false),
        })
    }
}

/// Fills the medium; gives the number of cells met, and a note where part of the grid lies outside.
pub(crate) fn fill(
    file: &str,
    bytes: &[u8],
    placing: &Placing,
    scale: Bands,
    filling: &Filling<'_>,
    medium: &mut Grid,
) -> Result<(usize, Option<String>), Fault> {
    let (name, grid) = open(file, bytes, placing.grid.as_deref())?;
    let refused = |what: String| Fault::new(file, format!("grid '{name:.60}'"), what);
    let rule = Rule::of(&grid, placing.level_set, filling.of).map_err(|e| refused(e.to_string()))?;
    let turn = |v: Vec3| placing.axes[0] * v.x + placing.axes[1] * v.y + placing.axes[2] * v.z;
    let axes = grid.map.axes.map(turn);
    let origin = turn(grid.map.origin) + placing.translate - (axes[0] + axes[1] + axes[2]) * 0.5;
    let lattice = Lattice { origin, axes };
    let lattice = match placing.bounds {
        None => lattice,
        Some((min, max)) => {
            let Some(extent) = extent(&grid, &rule)? else {
                return Err(refused("this grid is empty; name another one".into()));
            };
            lattice.fitted(extent, min, max).map_err(|e| refused(e.to_string()))?
        }
    };
    let mut sums = Sums::new(medium);
    let straight = lattice.straight();
    if straight.is_none() && !lattice.square() {
        return Err(refused("its transform shears, which is not read; resample the grid without it".into()));
    }
    grid.scan(&mut |block| {
        check(file, block, &rule, filling.word)?;
        let done = match &straight {
            Some(s) => sums.add_straight(s, block, &rule, lattice.voxel()),
            None => sums.add_turned(&lattice, block, &rule),
        };
        done.map_err(|e| refused(e.to_string()))
    })?;
    let note = sums.outside().map(|share| {
        format!(
            "density {file}, grid '{name:.60}': {:.3} % of it lies outside the medium and is left out",
            100.0 * share
        )
    });
    Ok((sums.fill(scale, filling), note))
}

/// What a value stands for.
enum Rule {
    /// Active values are densities, or stand for this function of them.
    Fog(fn(f64) -> f64),
    /// Distances, and the edge of a voxel in the same unit.
    Inside(f64),
}

impl Rule {
    fn of(grid: &VdbGrid<'_>, inside: bool, of: fn(f64) -> f64) -> Result<Rule, &'static str> {
        let [a, b, c] = grid.map.axes;
        match (grid.level_set, inside) {
            (false, false) => Ok(Rule::Fog(of)),
            (true, true) => Ok(Rule::Inside(a.cross(b).dot(c).abs().cbrt())),
            (true, false) => Err("this is a level set (distances to a surface), not a density; \
                                  write level_set = true for the density 1 inside it, or convert it to fog"),
            (false, true) => Err("this is no level set; remove level_set"),
        }
    }
    /// The share of a voxel that is filled, and the density there; none where nothing is.
    fn part(&self, value: f64, active: bool) -> Option<(f64, f64)> {
        match self {
            Rule::Fog(of) => active.then(|| (1.0, of(value))),
            Rule::Inside(h) => {
                let share = (0.5 - value / h).clamp(0.0, 1.0);
                (share > 0.0).then_some((share, 1.0))
            }
        }
    }
}

/// Refuses values that stand for nothing.
fn check(file: &str, block: &Block<'_>, rule: &Rule, word: &str) -> Result<(), Fault> {
    let wrong = |i: usize, v: f64| match rule {
        Rule::Fog(_) => bytes::bit(block.active, i) && !(v >= 0.0 && v <= f64::from(f32::MAX)),
        Rule::Inside(_) => v.is_nan(),
    };
    let Some(i) = (0..block.values.len()).find(|i| wrong(*i, block.values[*i])) else {
        return Ok(());
    };
    let [x, y, z] = [i / (block.count * block.count), i / block.count % block.count, i % block.count];
    let [a, b, c] = block.origin;
    let place = format!("[{}, {}, {}]", a + x as i64, b + y as i64, c + z as i64);
    let what = format!("{} is no {word}; give finite values from 0", block.values[i]);
    Err(Fault::new(file, place, what))
}

/// First indices, and those after the last.
type Extent = ([i64; 3], [i64; 3]);

/// Where something is filled; none where nothing is.
fn extent(grid: &VdbGrid<'_>, rule: &Rule) -> Result<Option<Extent>, Fault> {
    let (mut first, mut end) = ([i64::MAX; 3], [i64::MIN; 3]);
    grid.scan(&mut |block| {
        let n = block.count;
        for i in 0..n * n * n {
            if rule.part(block.values[i], bytes::bit(block.active, i)).is_some() {
                for (k, j) in [i / (n * n), i / n % n, i % n].into_iter().enumerate() {
                    let at = block.origin[k] + j as i64 * block.edge;
                    first[k] = first[k].min(at);
                    end[k] = end[k].max(at + block.edge);
                }
            }
        }
        Ok(())
    })?;
    Ok((first[0] < end[0]).then_some((first, end)))
}

/// Voxels in the scene: index i fills origin + Σ axes_k [i_k, i_k + 1].
#[derive(Clone, Copy)]
struct Lattice {
    origin: Vec3,
    axes: [Vec3; 3],
}

/// A lattice along the scene's axes: the planes of index axis k lie at start_k + i step_k along the scene's axis `axis_k`.
struct Straight {
    axis: [usize; 3],
    start: [f64; 3],
    step: [f64; 3],
}

impl Lattice {
    fn voxel(&self) -> f64 {
        self.axes[0].cross(self.axes[1]).dot(self.axes[2]).abs()
    }
    fn straight(&self) -> Option<Straight> {
        let axis = self.axes.map(|a| {
            let long = (0..3).max_by(|i, j| a[*i].abs().total_cmp(&a[*j].abs())).unwrap_or(0);
            let rest = (0..3).filter(|i| *i != long).all(|i| a[i].abs() <= STRAIGHT * a[long].abs());
            rest.then_some(long)
        });
        let axis = [axis[0]?, axis[1]?, axis[2]?];
        let different = axis[0] != axis[1] && axis[1] != axis[2] && axis[2] != axis[0];
        different.then(|| Straight {
            axis,
            start: axis.map(|a| self.origin[a]),
            step: [0, 1, 2].map(|k| self.axes[k][axis[k]]),
        })
    }
    fn square(&self) -> bool {
        let near = |a: Vec3, b: Vec3| a.dot(b).abs() <= 1e3 * STRAIGHT * a.length() * b.length();
        let [a, b, c] = self.axes;
        near(a, b) && near(b, c) && near(c, a)
    }
    /// Moved and stretched so that the indices first … end fill the box.
    fn fitted(&self, (first, end): Extent, min: Vec3, max: Vec3) -> Result<Lattice, &'static str> {
        let Some(s) = self.straight() else {
            return Err("its axes do not lie along the scene's, so min and max cannot place it; turn it by \
                        rotate_degrees, or place it by unit and translate");
        };
        let (mut origin, mut axes) = ([0.0; 3], [[0.0; 3]; 3]);
        for k in 0..3 {
            let a = s.axis[k];
            let step = (max[a] - min[a]) / (end[k] - first[k]) as f64;
            let backward = s.step[k] < 0.0;
            axes[k][a] = if backward { -step } else { step };
            origin[a] =
                if backward { min[a] + step * end[k] as f64 } else { min[a] - step * first[k] as f64 };
        }
        Ok(Lattice { origin: Vec3::from_array(origin), axes: axes.map(Vec3::from_array) })
    }
}

const TOO_MUCH: &str =
    "its voxels are too long for their width, or far too large for the medium; check unit, min and max";

/// What has come to each cell so far.
struct Sums<'a> {
    medium: &'a mut Grid,
    /// Of each cell: the share that is filled.
    share: Vec<f64>,
    /// Of each cell: density × share.
    density: Vec<f64>,
    /// ∫ density dV over everything, in the medium or not.
    total: f64,
    steps: u64,
    allowed: u64,
}

impl<'a> Sums<'a> {
    fn new(medium: &'a mut Grid) -> Sums<'a> {
        let n = medium.dims.iter().product();
        let allowed = n as u64 * STEPS_A_CELL;
        Sums { medium, share: vec![0.0; n], density: vec![0.0; n], total: 0.0, steps: 0, allowed }
    }
    fn strides(&self) -> [usize; 3] {
        let [_, ny, nz] = self.medium.dims;
        [ny * nz, nz, 1]
    }
    fn work(&mut self, steps: usize) -> Result<(), &'static str> {
        self.steps += steps as u64;
        if self.steps > self.allowed { Err(TOO_MUCH) } else { Ok(()) }
    }
    /// Spreads a value over the cells whose numbers and overlapped shares are given an axis.
    fn spread(&mut self, cells: [&[(usize, f64)]; 3], share: f64, density: f64) -> Result<(), &'static str> {
        self.work(cells[0].len() * cells[1].len() * cells[2].len())?;
        for &(i, fx) in cells[0] {
            for &(j, fy) in cells[1] {
                for &(k, fz) in cells[2] {
                    let filled = fx * fy * fz * share;
                    self.share[i + j + k] += filled;
                    self.density[i + j + k] += filled * density;
                }
            }
        }
        Ok(())
    }
    fn add_straight(
        &mut self,
        s: &Straight,
        block: &Block<'_>,
        rule: &Rule,
        voxel: f64,
    ) -> Result<(), &'static str> {
        let n = block.count;
        let counts = |i| rule.part(block.values[i], bytes::bit(block.active, i)).is_some();
        if !(0..n * n * n).any(counts) {
            return Ok(());
        }
        let strides = self.strides();
        let cells: [Vec<Vec<(usize, f64)>>; 3] = [0, 1, 2].map(|k| {
            let plane = |j: usize| s.start[k] + s.step[k] * (block.origin[k] + j as i64 * block.edge) as f64;
            let along = |j: usize| {
                let (a, b) = (plane(j), plane(j + 1));
                let mut cells = self.medium.overlaps(s.axis[k], a.min(b), a.max(b));
                cells.iter_mut().for_each(|c| c.0 *= strides[s.axis[k]]);
                cells
            };
            (0..n).map(along).collect()
        });
        let volume = voxel * (block.edge as f64).powi(3);
        for i in 0..n * n * n {
            let Some((share, density)) = rule.part(block.values[i], bytes::bit(block.active, i)) else {
                continue;
            };
            self.total += volume * share * density;
            self.allowed += STEPS_A_VALUE;
            let at = [&cells[0][i / (n * n)][..], &cells[1][i / n % n], &cells[2][i % n]];
            self.spread(at, share, density)?;
        }
        Ok(())
    }
    fn add_turned(&mut self, lattice: &Lattice, block: &Block<'_>, rule: &Rule) -> Result<(), &'static str> {
        let n = block.count;
        let axes = lattice.axes.map(|a| a * block.edge as f64);
        for i in 0..n * n * n {
            let Some((share, density)) = rule.part(block.values[i], bytes::bit(block.active, i)) else {
                continue;
            };
            let at = [i / (n * n), i / n % n, i % n];
            let along = |k: usize| lattice.axes[k] * (block.origin[k] + at[k] as i64 * block.edge) as f64;
            self.total += lattice.voxel() * (block.edge as f64).powi(3) * share * density;
            self.allowed += STEPS_A_VALUE;
            self.halve(lattice.origin + along(0) + along(1) + along(2), axes, share, density)?;
        }
        Ok(())
    }
    /// Halves a parallelepiped until its edges are no longer than half a cell; its parts become cubes.
    fn halve(&mut self, corner: Vec3, axes: [Vec3; 3], share: f64, density: f64) -> Result<(), &'static str> {
        self.work(1)?;
        let g = &self.medium;
        let max = g.min + vec3(g.dims[0] as f64, g.dims[1] as f64, g.dims[2] as f64).scale(g.cell);
        let zero = Vec3::default();
        let lo = axes.iter().fold(corner, |p, a| p + a.min(zero));
        let hi = axes.iter().fold(corner, |p, a| p + a.max(zero));
        // Not a number is outside.
        if !(0..3).all(|k| lo[k] < max[k] && hi[k] > g.min[k]) {
            return Ok(());
        }
        let limit = 0.5 * g.cell.x.min(g.cell.y).min(g.cell.z);
        let long = (0..3).max_by(|i, j| axes[*i].length2().total_cmp(&axes[*j].length2())).unwrap_or(0);
        if axes[long].length() > limit {
            let mut half = axes;
            half[long] = axes[long] * 0.5;
            self.halve(corner, half, share, density)?;
            return self.halve(corner + half[long], half, share, density);
        }
        let edge = axes[0].cross(axes[1]).dot(axes[2]).abs().cbrt();
        let centre = corner + (axes[0] + axes[1] + axes[2]) * 0.5;
        let strides = self.strides();
        let cells = [0, 1, 2].map(|k| {
            let mut cells = self.medium.overlaps(k, centre[k] - 0.5 * edge, centre[k] + 0.5 * edge);
            cells.iter_mut().for_each(|c| c.0 *= strides[k]);
            cells
        });
        self.spread([&cells[0], &cells[1], &cells[2]], share, density)
    }
    /// The share of the integral that is not in the medium, where it is worth a note.
    fn outside(&self) -> Option<f64> {
        let inside: f64 = self.density.iter().sum::<f64>() * self.medium.cell.product();
        let share = 1.0 - inside / self.total;
        (share > OUTSIDE).then_some(share)
    }
    /// Fills the cells; gives their number.
    fn fill(self, scale: Bands, filling: &Filling<'_>) -> usize {
        let [_, ny, nz] = self.medium.dims;
        let mut met = 0;
        for (i, (&share, &density)) in self.share.iter().zip(&self.density).enumerate() {
            // Cubes that stand for turned parts may overlap a little: what comes to the cell is kept, not its share.
            let share = share.min(1.0);
            if share > 0.0 {
                let matter = (filling.matter)(scale.map(|s| s * density / share));
                self.medium.fill([i / (ny * nz), i / nz % ny, i % nz], share, &matter);
                met += 1;
            }
        }
        met
    }
}
