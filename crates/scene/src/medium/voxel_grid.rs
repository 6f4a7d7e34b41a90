//! The voxel grid of a medium.
//!
//! Cell (i, j, k) is the box min + (i..i+1, j..j+1, k..k+1) ∘ cell. The index runs with k fastest, index = (i·ny + j)·nz + k, the order of a
//! C array `[x][y][z]`. Extinction, albedo and sources are constant within a cell. A property that is equal in all cells is stored once.

use crate::bands::Bands;
use crate::bands::band::Band;
use crate::base::limits::{
    MAX_CELLS, MAX_COORDINATE, MAX_EXTINCTION, MAX_FLUX, MAX_UNIFORM_CELLS, MIN_CELL_EDGE,
};
use crate::base::scene_error::{SceneError, invalid};
use crate::medium::cell_values::{CellValues, MediumValues};
use crate::medium::grid_geometry::GridGeometry;
use crate::thermal::ThermalCondition;
use zonal_math::{Vec3, vec3};

/// A medium on a regular grid.
///
/// ```
/// use zonal_math::{Vec3, vec3};
/// use zonal_scene::{Bands, VoxelGrid};
/// let mut grid = VoxelGrid::new(Vec3::ZERO, vec3(0.5, 0.5, 0.5), [2, 2, 4])?;
/// grid.fill(Bands::splat(0.1), Bands::splat(0.9), Bands::ZERO, Bands::ZERO);
/// grid.set(grid.index([1, 0, 3]), Bands::splat(0.2), Bands::splat(0.5), Bands::ZERO, Bands::ZERO);
/// let grid = grid.seal()?;
/// assert_eq!((grid.len(), grid.max()), (16, vec3(1.0, 1.0, 2.0)));
/// let cell = grid.cell_at(vec3(0.75, 0.25, 1.75)).unwrap();
/// assert_eq!(grid.extinction(grid.index(cell)), Bands::splat(0.2));
/// # Ok::<(), zonal_scene::SceneError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct VoxelGrid {
    geometry: GridGeometry,
    media: MediumValues,
    /// Thermal conditions, in thermal mode.
    heat: Option<CellValues<ThermalCondition>>,
    /// True for cells between which pictures interpolate the extinction.
    interpolated: CellValues<bool>,
    /// True if cells of a grid that is too large for that were set.
    has_too_many_values: bool,
}

impl VoxelGrid {
    /// An empty grid (κ = 0 everywhere) with lower corner `min`, cell edges `cell` (m) and `dims` cells.
    ///
    /// # Errors
    /// If there is no cell, if there are more than [`MAX_UNIFORM_CELLS`](crate::base::limits::MAX_UNIFORM_CELLS), or if the bounds are out of range.
    pub fn new(min: Vec3, cell: Vec3, dims: [usize; 3]) -> Result<VoxelGrid, SceneError> {
        let count = dims.iter().try_fold(1usize, |n, &d| n.checked_mul(d)).unwrap_or(usize::MAX);
        if count == 0 {
            return invalid("medium.cells", "a voxel grid needs at least one cell on each axis");
        }
        if count > MAX_UNIFORM_CELLS {
            let [nx, ny, nz] = dims;
            return invalid(
                "medium.cells",
                format!("{nx} × {ny} × {nz} cells exceed the maximum of {MAX_UNIFORM_CELLS}; use fewer"),
            );
        }
        let edges = vec3(dims[0] as f64, dims[1] as f64, dims[2] as f64);
        let reach = min.max_abs().max((min + cell.scale(edges)).max_abs());
        let shortest = cell.x.min(cell.y).min(cell.z);
        if !(min.is_finite() && cell.is_finite() && shortest >= MIN_CELL_EDGE && reach <= MAX_COORDINATE) {
            return invalid(
                "medium.max",
                format!(
                    "the bounds of a voxel grid must be finite, within {MAX_COORDINATE:e} m, with min below max on each axis"
                ),
            );
        }
        Ok(VoxelGrid {
            geometry: GridGeometry { min, cell, dims },
            media: MediumValues::uniform([Bands::ZERO; 4]),
            heat: None,
            interpolated: CellValues::Uniform(false),
            has_too_many_values: false,
        })
    }

    /// Sets one cell: extinction κ (1/m), albedo Ω, blackbody emissive power E (W/m²), volumetric source q (W/m³).
    /// Call [`VoxelGrid::seal`] after the last one.
    pub fn set(&mut self, index: usize, extinction: Bands, albedo: Bands, emission: Bands, source: Bands) {
        let (len, values) = (self.len(), [extinction, albedo, emission, source]);
        if len > MAX_CELLS {
            self.has_too_many_values |= self.media.each().map(|p| p.get(index)) != values;
            return;
        }
        self.media.each_mut().into_iter().zip(values).for_each(|(own, value)| own.set(index, value, len));
    }

    /// Marks a cell between which and its marked neighbours pictures interpolate the extinction: it samples a smooth field. Solves do not depend on it.
    pub fn mark_interpolated(&mut self, index: usize) {
        self.set_interpolated(index, true);
    }

    /// Takes the mark of [`VoxelGrid::mark_interpolated`] from a cell.
    pub fn unmark_interpolated(&mut self, index: usize) {
        self.set_interpolated(index, false);
    }

    fn set_interpolated(&mut self, index: usize, interpolated: bool) {
        let len = self.len();
        if len <= MAX_CELLS {
            self.interpolated.set(index, interpolated, len);
        }
    }

    /// True for a cell of [`VoxelGrid::mark_interpolated`].
    pub fn is_interpolated(&self, index: usize) -> bool {
        self.interpolated.get(index)
    }

    /// True if some cell is one of [`VoxelGrid::mark_interpolated`].
    pub fn has_interpolated_cells(&self) -> bool {
        self.interpolated != CellValues::Uniform(false)
    }

    /// Sets all cells to the same values, without memory for each cell; otherwise as [`VoxelGrid::set`].
    pub fn fill(&mut self, extinction: Bands, albedo: Bands, emission: Bands, source: Bands) {
        self.media = MediumValues::uniform([extinction, albedo, emission, source]);
    }

    /// Sets the thermal condition of one cell: temperature (K) or heat source (W/m³). The first call gives all other cells the condition
    /// `others`. Call [`VoxelGrid::seal`] after the last one.
    pub fn set_heat(&mut self, index: usize, condition: ThermalCondition, others: ThermalCondition) {
        let len = self.len();
        if len > MAX_CELLS {
            self.has_too_many_values = true;
            return;
        }
        self.heat.get_or_insert(CellValues::Uniform(others)).set(index, condition, len);
    }

    /// Sets the thermal condition of all cells.
    pub fn fill_heat(&mut self, condition: ThermalCondition) {
        self.heat = Some(CellValues::Uniform(condition));
    }

    /// Removes all thermal conditions.
    pub fn clear_heat(&mut self) {
        self.heat = None;
    }

    /// Multiplies emission and source of every cell by a factor per band. Call [`VoxelGrid::seal`] afterwards.
    pub fn scale_sources(&mut self, factor: Bands) {
        let scaled = |v: Bands| v * factor;
        for values in [&mut self.media.emission, &mut self.media.source] {
            match values {
                CellValues::Uniform(v) => *v = scaled(*v),
                CellValues::PerCell(list) => list.iter_mut().for_each(|v| *v = scaled(*v)),
            }
        }
    }

    /// Replaces the albedo of every cell. Call [`VoxelGrid::seal`] afterwards.
    pub fn set_albedo(&mut self, albedo: Bands) {
        self.media.albedo = CellValues::Uniform(albedo);
    }

    /// Validates all cells and merges equal values.
    ///
    /// # Errors
    /// If a value is out of range; the message states the cell.
    pub fn seal(mut self) -> Result<VoxelGrid, SceneError> {
        if self.has_too_many_values {
            let what = format!(
                "values that differ from cell to cell are for at most {MAX_CELLS} cells, and there are {}; use fewer",
                self.len()
            );
            return invalid("medium.cells", what);
        }
        for i in self.distinct_cells() {
            self.check_cell(i)?;
        }
        self.media.each_mut().into_iter().for_each(CellValues::seal);
        self.interpolated.seal();
        if let Some(heat) = &mut self.heat {
            heat.seal();
        }
        self.check_heat()?;
        Ok(self)
    }

    /// The cells to validate: one cell of a uniform grid, else all.
    pub(crate) fn distinct_cells(&self) -> std::ops::Range<usize> {
        0..if self.is_uniform() { 1 } else { self.len() }
    }

    /// Validates ranges of one cell.
    fn check_cell(&self, i: usize) -> Result<(), SceneError> {
        let fail = |key: &str, fault: &str, value: f64| {
            let [x, y, z] = self.coordinates(i);
            invalid(key, format!("{fault} is {value} in cell ({x}, {y}, {z})"))
        };
        for b in Band::all() {
            let (k, o, e, q) =
                (self.extinction(i)[b], self.albedo(i)[b], self.emission(i)[b], self.source(i)[b]);
            let ranges = [
                ("extinction", k, MAX_EXTINCTION),
                ("albedo", o, 1.0),
                ("emission", e, MAX_FLUX),
                ("source", q, MAX_FLUX),
            ];
            if let Some((key, x, max)) = ranges.into_iter().find(|r| !(0.0..=r.2).contains(&r.1)) {
                return fail(
                    &format!("medium.{key}"),
                    &format!("the {key} must lie between 0 and {max:e}, but"),
                    x,
                );
            }
        }
        Ok(())
    }

    /// Validates thermal conditions.
    fn check_heat(&self) -> Result<(), SceneError> {
        if self.heat.is_none() {
            return Ok(());
        }
        for i in self.distinct_cells() {
            let [x, y, z] = self.coordinates(i);
            let in_cell =
                |e: SceneError| SceneError::new(e.key(), format!("in cell ({x}, {y}, {z}) {}", e.message()));
            let Some(condition) = self.heat(i) else { continue };
            condition
                .check(|k| format!("medium.{}", if k == "temperature" { k } else { "heat_source" }))
                .map_err(in_cell)?;
        }
        Ok(())
    }

    /// The medium doubled along some `axes`: its mirror image follows, or precedes it along the axes of `low`.
    ///
    /// # Errors
    /// If it has too many cells.
    pub(crate) fn evenly_extended(&self, axes: [bool; 3], low: [bool; 3]) -> Result<VoxelGrid, SceneError> {
        let old = self.geometry.dims;
        let dims = [0, 1, 2].map(|k| if axes[k] { old[k].saturating_mul(2) } else { old[k] });
        let shift = |k: usize| if low[k] { old[k] as f64 * self.geometry.cell[k] } else { 0.0 };
        let mut out =
            VoxelGrid::new(self.geometry.min - vec3(shift(0), shift(1), shift(2)), self.geometry.cell, dims)?;
        let cells = if self.is_uniform() { Vec::new() } else { self.cells_of_extension(axes, low, &out) };
        let cells = || cells.iter().copied();
        out.media = self.media.gathered(cells());
        out.heat = self.heat.as_ref().map(|h| h.gathered(cells()));
        if !self.is_uniform() {
            out.interpolated = self.interpolated.gathered(cells());
        }
        Ok(out)
    }

    /// For each cell of the grid `extended` of [`VoxelGrid::evenly_extended`], the cell that it is an image of.
    pub(crate) fn cells_of_extension(
        &self,
        axes: [bool; 3],
        low: [bool; 3],
        extended: &VoxelGrid,
    ) -> Vec<usize> {
        let old = self.geometry.dims;
        let from = |k: usize, c: usize| {
            let precedes = axes[k] && low[k];
            if precedes {
                if c < old[k] { old[k] - 1 - c } else { c - old[k] }
            } else if c >= old[k] {
                2 * old[k] - 1 - c
            } else {
                c
            }
        };
        let image = |i: usize| {
            let c = extended.coordinates(i);
            self.index([0, 1, 2].map(|k| from(k, c[k])))
        };
        (0..extended.len()).map(image).collect()
    }

    /// Position and size of the cells.
    pub(crate) fn geometry(&self) -> &GridGeometry {
        &self.geometry
    }
    /// Extinction, albedo, emission and source of the cells.
    pub(crate) fn media(&self) -> &MediumValues {
        &self.media
    }
    /// Heap memory, bytes.
    pub fn bytes(&self) -> usize {
        let heat = self.heat.as_ref().map_or(0, CellValues::bytes);
        self.media.bytes() + heat + self.interpolated.bytes()
    }
    /// Number of cells.
    pub fn len(&self) -> usize {
        self.geometry.len()
    }
    /// Always false: a grid has at least one cell.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Lower corner, m.
    pub fn min(&self) -> Vec3 {
        self.geometry.min
    }
    /// Upper corner, m.
    pub fn max(&self) -> Vec3 {
        self.geometry.corner(self.geometry.dims)
    }
    /// Cell edges, m.
    pub fn cell(&self) -> Vec3 {
        self.geometry.cell
    }
    /// Cells along each axis.
    pub fn dims(&self) -> [usize; 3] {
        self.geometry.dims
    }
    /// Index of a cell by its coordinates.
    pub fn index(&self, c: [usize; 3]) -> usize {
        self.geometry.index(c)
    }
    /// Coordinates of a cell by its index.
    pub fn coordinates(&self, index: usize) -> [usize; 3] {
        self.geometry.coordinates(index)
    }
    /// Lower corner of a cell, m.
    pub fn corner(&self, c: [usize; 3]) -> Vec3 {
        self.geometry.corner(c)
    }
    /// Centre of a cell, m.
    pub fn centre(&self, c: [usize; 3]) -> Vec3 {
        self.geometry.centre(c)
    }
    /// The cell that contains `p`, if any.
    pub fn cell_at(&self, p: Vec3) -> Option<[usize; 3]> {
        let mut c = [0; 3];
        for axis in 0..3 {
            let t = (p[axis] - self.geometry.min[axis]) / self.geometry.cell[axis];
            if !(t >= 0.0 && t <= self.geometry.dims[axis] as f64) {
                return None;
            }
            c[axis] = (t as usize).min(self.geometry.dims[axis] - 1);
        }
        Some(c)
    }
    /// Extinction κ of a cell, 1/m.
    pub fn extinction(&self, index: usize) -> Bands {
        self.media.extinction.get(index)
    }
    /// Scattering albedo Ω of a cell.
    pub fn albedo(&self, index: usize) -> Bands {
        self.media.albedo.get(index)
    }
    /// Blackbody emissive power E of a cell, W/m².
    pub fn emission(&self, index: usize) -> Bands {
        self.media.emission.get(index)
    }
    /// Volumetric source q of a cell, W/m³.
    pub fn source(&self, index: usize) -> Bands {
        self.media.source.get(index)
    }
    /// Thermal condition of a cell; `None` in light mode.
    pub fn heat(&self, index: usize) -> Option<ThermalCondition> {
        self.heat.as_ref().map(|h| h.get(index))
    }
    /// True if cells have thermal conditions.
    pub fn is_thermal(&self) -> bool {
        self.heat.is_some()
    }
    /// True if all cells are equal in all properties.
    pub fn is_uniform(&self) -> bool {
        self.media.is_uniform() && !matches!(self.heat, Some(CellValues::PerCell(_)))
    }
    /// The extinction, if it is equal in all cells.
    pub fn uniform_extinction(&self) -> Option<Bands> {
        if let CellValues::Uniform(k) = self.media.extinction { Some(k) } else { None }
    }
    /// True if the extinction is uniform, or varies only along the one axis that is not among two `periodic` ones.
    pub(crate) fn has_extinction_of_layers(&self, periodic: [bool; 3]) -> bool {
        let mut across = (0..3).filter(|&k| !periodic[k]);
        let (Some(axis), None) = (across.next(), across.next()) else {
            return self.uniform_extinction().is_some();
        };
        let first = |i: usize| {
            let mut of = [0; 3];
            of[axis] = self.coordinates(i)[axis];
            self.index(of)
        };
        self.uniform_extinction().is_some()
            || (0..self.len()).all(|i| self.extinction(i) == self.extinction(first(i)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cell_indices_and_points_are_consistent() {
        let v = VoxelGrid::new(vec3(-1.0, 0.0, 2.0), vec3(0.5, 0.25, 1.0), [4, 3, 2]).unwrap();
        for i in 0..v.len() {
            let c = v.coordinates(i);
            assert_eq!(v.index(c), i);
            assert_eq!(v.cell_at(v.centre(c)), Some(c));
        }
        assert_eq!(v.cell_at(v.max()), Some([3, 2, 1]));
        assert_eq!(v.cell_at(vec3(5.0, 0.0, 2.0)), None);
    }

    #[test]
    fn excessive_grids_are_refused_before_allocation() {
        assert!(VoxelGrid::new(Vec3::ZERO, Vec3::ONE, [10_000, 10_000, 10_000]).is_err());
        assert!(VoxelGrid::new(Vec3::ZERO, Vec3::ONE, [usize::MAX, 2, 2]).is_err());
        assert!(VoxelGrid::new(Vec3::ZERO, Vec3::ZERO, [2, 2, 2]).is_err());
    }

    #[test]
    fn large_grids_are_uniform() {
        let mut grid = VoxelGrid::new(Vec3::ZERO, Vec3::ONE, [512, 512, 512]).unwrap();
        grid.fill(Bands::ONE, Bands::ZERO, Bands::ZERO, Bands::ZERO);
        grid.set(7, Bands::ONE, Bands::ZERO, Bands::ZERO, Bands::ZERO);
        assert!(grid.clone().seal().is_ok());
        grid.set(7, Bands::ONE, Bands::ZERO, Bands::ONE, Bands::ZERO);
        assert_eq!(grid.bytes(), 0);
        assert!(grid.seal().unwrap_err().message().contains("differ from cell to cell"));
    }

    #[test]
    fn error_of_an_invalid_cell_states_its_coordinates() {
        let mut v = VoxelGrid::new(Vec3::ZERO, Vec3::ONE, [2, 2, 2]).unwrap();
        v.set(3, Bands::from_rgb([1.0, -1.0, 1.0]), Bands::splat(0.5), Bands::ZERO, Bands::ZERO);
        let e = v.seal().unwrap_err();
        assert!(e.to_string().contains("(0, 1, 1)"), "{e}");
    }
}
