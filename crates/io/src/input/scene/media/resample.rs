//! Conservative resampling of an OpenVDB grid onto the voxels of the medium.
//!
//! Cell c gets the density Σ_v d_v |v ∩ c| / Σ_v |v ∩ c| over the active voxels v, in the fraction Σ_v |v ∩ c| / |c| of its volume, so
//! that the integral of the density is conserved. For a grid along the axes of the scene the overlaps are exact. Voxels of a rotated grid
//! are halved until their parts are no longer than half a cell, and each part is replaced by a cube of its volume about its centre.
//!
//! A level set with distance d and voxels of edge h stands for the density 1 in the fraction ½ − d/h (0 to 1) of each voxel.
//!
//! Cost: the number of overlaps of voxels and cells, bounded by `MAX_STEPS_PER_CELL` and `MAX_STEPS_PER_VALUE`.

use crate::input::grids::vdb::bytes;
use crate::input::grids::vdb::grid::{VdbGrid, open_grid};
use crate::input::grids::vdb::tree::ValueBlock;
use crate::input::mesh::rotation::rotated_axes;
use crate::input::reading::error::{FileFault, InputError};
use crate::input::scene::media::voxel_field::VoxelField;
use crate::input::scene::media::voxel_grid::VoxelGridBuilder;
use crate::input::toml::medium_keys::VDB;
use crate::input::toml::node::TomlTable;
use zonal_math::{Vec3, vec3};
use zonal_scene::Bands;

/// Largest deviation of parallel axes, relative to their lengths.
const ALIGNMENT_TOLERANCE: f64 = 1e-9;
/// Largest number of steps for each cell of the medium and for each value of the file; valid grids stay far below.
const MAX_STEPS_PER_CELL: u64 = 512;
const MAX_STEPS_PER_VALUE: u64 = 64;
/// Fraction of the integral outside the medium above which a note is given.
const OUTSIDE_FRACTION_NOTED: f64 = 1e-6;

/// The grid that a scene names, and its placement.
pub(crate) struct GridPlacement {
    /// The box that the active voxels are fitted to.
    bounds: Option<(Vec3, Vec3)>,
    grid: Option<String>,
    /// The images of the file's unit vectors, m.
    axes: [Vec3; 3],
    translate: Vec3,
    /// Reads a level set as the density 1 inside its surface.
    level_set: bool,
}

impl GridPlacement {
    /// Reads the keys that only OpenVDB files know.
    pub(crate) fn read(t: &TomlTable<'_>, bounds: Option<(Vec3, Vec3)>) -> Result<GridPlacement, InputError> {
        if let (Some(_), Some(n)) = (bounds, t.get(&VDB.unit).or_else(|| t.get(&VDB.translate))) {
            return Err(n.error("min and max already place the grid; remove them, or this key"));
        }
        Ok(GridPlacement {
            bounds,
            grid: t.value(&VDB.grid)?,
            axes: rotated_axes(t.or_default(&VDB.rotate_degrees)?, t.or_default(&VDB.unit)?),
            translate: t.or_default(&VDB.translate)?,
            level_set: t.or_default(&VDB.level_set)?,
        })
    }
}

/// Fills the medium; returns the overlapped cells, and a note if part of the grid lies outside.
pub(crate) fn resample(
    file: &str,
    bytes: &[u8],
    placement: &GridPlacement,
    field: &VoxelField<'_>,
    medium: &VoxelGridBuilder,
) -> Result<ResampledField, FileFault> {
    let (name, grid) = open_grid(file, bytes, placement.grid.as_deref())?;
    let refused = |message: String| FileFault::new(file, format!("grid '{name:.60}'"), message);
    let quantity = VoxelQuantity::of(&grid, placement, field).map_err(|e| refused(e.to_string()))?;
    let rotate = |v: Vec3| placement.axes[0] * v.x + placement.axes[1] * v.y + placement.axes[2] * v.z;
    let axes = grid.transform.axes.map(rotate);
    let origin = rotate(grid.transform.origin) + placement.translate - (axes[0] + axes[1] + axes[2]) * 0.5;
    let lattice = IndexLattice { origin, axes };
    let lattice = match placement.bounds {
        None => lattice,
        Some((min, max)) => {
            let Some(extent) = filled_extent(&grid, &quantity)? else {
                return Err(refused("this grid is empty; name another one".into()));
            };
            lattice.fitted(extent, min, max).map_err(|e| refused(e.to_string()))?
        }
    };
    let mut cells = CellAccumulator::new(medium);
    let aligned = lattice.axis_aligned();
    if aligned.is_none() && !lattice.is_orthogonal() {
        return Err(refused("its transform shears, which is not read; resample the grid without it".into()));
    }
    grid.scan(&mut |block| {
        check_values(file, block, &quantity, field.noun)?;
        let added = match &aligned {
            Some(s) => cells.add_aligned(s, block, &quantity, lattice.voxel_volume()),
            None => cells.add_rotated(&lattice, block, &quantity),
        };
        added.map_err(|e| refused(e.to_string()))
    })?;
    let note = cells.fraction_outside().map(|fraction| {
        format!(
            "density {file}, grid '{name:.60}': {:.3} % of it lies outside the medium and is left out",
            100.0 * fraction
        )
    });
    Ok(ResampledField { fraction: cells.fraction, density: cells.density, note })
}

/// A sparse grid on the voxels of a medium.
pub(crate) struct ResampledField {
    /// Filled fraction of each cell.
    fraction: Vec<f64>,
    /// Density × filled fraction of each cell.
    density: Vec<f64>,
    /// A note on what lies outside the medium.
    pub(crate) note: Option<String>,
}

impl ResampledField {
    /// Fills the cells of the medium; returns them.
    pub(crate) fn fill(
        &self,
        scale: Bands,
        field: &VoxelField<'_>,
        medium: &mut VoxelGridBuilder,
    ) -> Vec<usize> {
        let [_, ny, nz] = medium.dims;
        let mut filled = Vec::new();
        for (i, (&fraction, &density)) in self.fraction.iter().zip(&self.density).enumerate() {
            // Cubes of a rotated voxel may overlap slightly: the integral is kept, and the fraction is cut to 1.
            let fraction = fraction.min(1.0);
            if fraction > 0.0 {
                let properties = (field.properties)(scale * density / fraction);
                medium.fill([i / (ny * nz), i / nz % ny, i % nz], fraction, &properties);
                filled.push(i);
            }
        }
        filled
    }
}

/// The quantity that values stand for.
enum VoxelQuantity {
    /// Densities of active voxels, averaged through a function.
    Density(fn(f64) -> f64),
    /// Distances to a surface, and the edge of a voxel in the same unit.
    LevelSet(f64),
}

impl VoxelQuantity {
    fn of(
        grid: &VdbGrid<'_>,
        placement: &GridPlacement,
        field: &VoxelField<'_>,
    ) -> Result<VoxelQuantity, &'static str> {
        let [a, b, c] = grid.transform.axes;
        if placement.level_set && !grid.level_set {
            return Err("this is no level set; remove level_set");
        }
        if placement.level_set {
            return Ok(VoxelQuantity::LevelSet(a.cross(b).dot(c).abs().cbrt()));
        }
        if grid.level_set {
            return Err("this is a level set (distances to a surface), not a density; \
                        write level_set = true for the density 1 inside it, or convert it to fog");
        }
        Ok(VoxelQuantity::Density(field.averaged))
    }
    /// The filled fraction of a voxel, and the density there; none of an empty voxel.
    fn filled(&self, value: f64, active: bool) -> Option<(f64, f64)> {
        match self {
            VoxelQuantity::Density(of) => active.then(|| (1.0, of(value))),
            VoxelQuantity::LevelSet(h) => {
                let fraction = (0.5 - value / h).clamp(0.0, 1.0);
                (fraction > 0.0).then_some((fraction, 1.0))
            }
        }
    }
}

/// Refuses negative densities and values that are not numbers.
fn check_values(
    file: &str,
    block: &ValueBlock<'_>,
    quantity: &VoxelQuantity,
    noun: &str,
) -> Result<(), FileFault> {
    let is_invalid = |i: usize, v: f64| match quantity {
        VoxelQuantity::Density(_) => bytes::bit(block.active, i) && !(v >= 0.0 && v <= f64::from(f32::MAX)),
        VoxelQuantity::LevelSet(_) => v.is_nan(),
    };
    let Some(i) = (0..block.values.len()).find(|i| is_invalid(*i, block.values[*i])) else {
        return Ok(());
    };
    let [x, y, z] = [i / (block.count * block.count), i / block.count % block.count, i % block.count];
    let [a, b, c] = block.origin;
    let place = format!("[{}, {}, {}]", a + x as i64, b + y as i64, c + z as i64);
    let message = format!("{} is no {noun}; give finite values from 0", block.values[i]);
    Err(FileFault::new(file, place, message))
}

/// First indices, and those after the last.
type IndexExtent = ([i64; 3], [i64; 3]);

/// The extent of the filled voxels; none if all are empty.
fn filled_extent(grid: &VdbGrid<'_>, quantity: &VoxelQuantity) -> Result<Option<IndexExtent>, FileFault> {
    let (mut first, mut end) = ([i64::MAX; 3], [i64::MIN; 3]);
    grid.scan(&mut |block| {
        let n = block.count;
        for i in 0..n * n * n {
            if quantity.filled(block.values[i], bytes::bit(block.active, i)).is_some() {
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
struct IndexLattice {
    origin: Vec3,
    axes: [Vec3; 3],
}

/// A lattice along the scene's axes: the planes of index axis k lie at start_k + i step_k along the scene's axis `axis_k`.
struct AxisAlignedLattice {
    axis: [usize; 3],
    start: [f64; 3],
    step: [f64; 3],
}

impl IndexLattice {
    /// Volume of a voxel, m³.
    fn voxel_volume(&self) -> f64 {
        self.axes[0].cross(self.axes[1]).dot(self.axes[2]).abs()
    }
    /// The lattice along the scene's axes; none if it is rotated.
    fn axis_aligned(&self) -> Option<AxisAlignedLattice> {
        let axis = self.axes.map(|a| {
            let long = (0..3).max_by(|i, j| a[*i].abs().total_cmp(&a[*j].abs())).unwrap_or(0);
            let rest =
                (0..3).filter(|i| *i != long).all(|i| a[i].abs() <= ALIGNMENT_TOLERANCE * a[long].abs());
            rest.then_some(long)
        });
        let axis = [axis[0]?, axis[1]?, axis[2]?];
        let different = axis[0] != axis[1] && axis[1] != axis[2] && axis[2] != axis[0];
        different.then(|| AxisAlignedLattice {
            axis,
            start: axis.map(|a| self.origin[a]),
            step: [0, 1, 2].map(|k| self.axes[k][axis[k]]),
        })
    }
    /// True if the axes are orthogonal.
    fn is_orthogonal(&self) -> bool {
        let orthogonal =
            |a: Vec3, b: Vec3| a.dot(b).abs() <= 1e3 * ALIGNMENT_TOLERANCE * a.length() * b.length();
        let [a, b, c] = self.axes;
        orthogonal(a, b) && orthogonal(b, c) && orthogonal(c, a)
    }
    /// Translated and scaled so that the indices first … end fill the box.
    fn fitted(&self, (first, end): IndexExtent, min: Vec3, max: Vec3) -> Result<IndexLattice, &'static str> {
        let Some(s) = self.axis_aligned() else {
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
        Ok(IndexLattice { origin: Vec3::from_array(origin), axes: axes.map(Vec3::from_array) })
    }
}

/// The message about a grid whose resampling would exceed the bound on work.
const TOO_MANY_STEPS: &str =
    "its voxels are too long for their width, or far too large for the medium; check unit, min and max";

/// Sums over the voxels read so far, for each cell of the medium.
struct CellAccumulator<'a> {
    medium: &'a VoxelGridBuilder,
    /// Filled fraction of each cell.
    fraction: Vec<f64>,
    /// Density × filled fraction of each cell.
    density: Vec<f64>,
    /// ∫ density dV over all voxels, inside the medium or not.
    total: f64,
    steps: u64,
    max_steps: u64,
}

impl<'a> CellAccumulator<'a> {
    fn new(medium: &'a VoxelGridBuilder) -> CellAccumulator<'a> {
        let n = medium.dims.iter().product();
        let max_steps = n as u64 * MAX_STEPS_PER_CELL;
        CellAccumulator {
            medium,
            fraction: vec![0.0; n],
            density: vec![0.0; n],
            total: 0.0,
            steps: 0,
            max_steps,
        }
    }
    fn strides(&self) -> [usize; 3] {
        let [_, ny, nz] = self.medium.dims;
        [ny * nz, nz, 1]
    }
    /// Counts steps; refuses more than the bound.
    fn count_steps(&mut self, steps: usize) -> Result<(), &'static str> {
        self.steps += steps as u64;
        if self.steps > self.max_steps { Err(TOO_MANY_STEPS) } else { Ok(()) }
    }
    /// Adds a value to cells, given by the index and the overlapped fraction along each axis.
    fn add(&mut self, cells: [&[(usize, f64)]; 3], fraction: f64, density: f64) -> Result<(), &'static str> {
        self.count_steps(cells[0].len() * cells[1].len() * cells[2].len())?;
        for &(i, fx) in cells[0] {
            for &(j, fy) in cells[1] {
                for &(k, fz) in cells[2] {
                    let filled = fx * fy * fz * fraction;
                    self.fraction[i + j + k] += filled;
                    self.density[i + j + k] += filled * density;
                }
            }
        }
        Ok(())
    }
    /// Adds a block of a lattice along the scene's axes.
    fn add_aligned(
        &mut self,
        s: &AxisAlignedLattice,
        block: &ValueBlock<'_>,
        quantity: &VoxelQuantity,
        voxel_volume: f64,
    ) -> Result<(), &'static str> {
        let n = block.count;
        let is_filled = |i| quantity.filled(block.values[i], bytes::bit(block.active, i)).is_some();
        if !(0..n * n * n).any(is_filled) {
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
        let volume = voxel_volume * (block.edge as f64).powi(3);
        for i in 0..n * n * n {
            let Some((fraction, density)) = quantity.filled(block.values[i], bytes::bit(block.active, i))
            else {
                continue;
            };
            self.total += volume * fraction * density;
            self.max_steps += MAX_STEPS_PER_VALUE;
            let at = [&cells[0][i / (n * n)][..], &cells[1][i / n % n], &cells[2][i % n]];
            self.add(at, fraction, density)?;
        }
        Ok(())
    }
    /// Adds a block of a rotated lattice.
    fn add_rotated(
        &mut self,
        lattice: &IndexLattice,
        block: &ValueBlock<'_>,
        quantity: &VoxelQuantity,
    ) -> Result<(), &'static str> {
        let n = block.count;
        let axes = lattice.axes.map(|a| a * block.edge as f64);
        for i in 0..n * n * n {
            let Some((fraction, density)) = quantity.filled(block.values[i], bytes::bit(block.active, i))
            else {
                continue;
            };
            let at = [i / (n * n), i / n % n, i % n];
            let along = |k: usize| lattice.axes[k] * (block.origin[k] + at[k] as i64 * block.edge) as f64;
            self.total += lattice.voxel_volume() * (block.edge as f64).powi(3) * fraction * density;
            self.max_steps += MAX_STEPS_PER_VALUE;
            self.add_halved(lattice.origin + along(0) + along(1) + along(2), axes, fraction, density)?;
        }
        Ok(())
    }
    /// Halves a parallelepiped until its edges are no longer than half a cell, and adds its parts as cubes.
    fn add_halved(
        &mut self,
        corner: Vec3,
        axes: [Vec3; 3],
        fraction: f64,
        density: f64,
    ) -> Result<(), &'static str> {
        self.count_steps(1)?;
        let g = &self.medium;
        let max = g.min + vec3(g.dims[0] as f64, g.dims[1] as f64, g.dims[2] as f64).scale(g.cell);
        let zero = Vec3::default();
        let lo = axes.iter().fold(corner, |p, a| p + a.min(zero));
        let hi = axes.iter().fold(corner, |p, a| p + a.max(zero));
        // The negation counts NaN as outside.
        if !(0..3).all(|k| lo[k] < max[k] && hi[k] > g.min[k]) {
            return Ok(());
        }
        let limit = 0.5 * g.cell.x.min(g.cell.y).min(g.cell.z);
        let long = (0..3).max_by(|i, j| axes[*i].length2().total_cmp(&axes[*j].length2())).unwrap_or(0);
        if axes[long].length() > limit {
            let mut half = axes;
            half[long] = axes[long] * 0.5;
            self.add_halved(corner, half, fraction, density)?;
            return self.add_halved(corner + half[long], half, fraction, density);
        }
        let edge = axes[0].cross(axes[1]).dot(axes[2]).abs().cbrt();
        let centre = corner + (axes[0] + axes[1] + axes[2]) * 0.5;
        let strides = self.strides();
        let cells = [0, 1, 2].map(|k| {
            let mut cells = self.medium.overlaps(k, centre[k] - 0.5 * edge, centre[k] + 0.5 * edge);
            cells.iter_mut().for_each(|c| c.0 *= strides[k]);
            cells
        });
        self.add([&cells[0], &cells[1], &cells[2]], fraction, density)
    }
    /// The fraction of the integral outside the medium, if it is above the threshold of the note.
    fn fraction_outside(&self) -> Option<f64> {
        let inside: f64 = self.density.iter().sum::<f64>() * self.medium.cell.product();
        let fraction = 1.0 - inside / self.total;
        (fraction > OUTSIDE_FRACTION_NOTED).then_some(fraction)
    }
}
