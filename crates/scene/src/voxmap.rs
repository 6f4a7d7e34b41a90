//! The voxmap: the regular voxel grid of a medium.
//!
//! Cell (i, j, k) is the box min + (i..i+1, j..j+1, k..k+1) ∘ cell; the index runs with k fastest:
//! index = (i·ny + j)·nz + k, the order of a C array `[x][y][z]`. Within a cell extinction, albedo and sources are constant.

use crate::scene::{LARGEST_EXTINCTION, LARGEST_FLUX, LARGEST_LENGTH, SceneError};
use crate::{Bands, Known, bands};
use zonal_math::{Vec3, vec3};

/// The most cells a voxmap may have: at 100 bytes a cell this is what a large machine holds.
pub const MAX_CELLS: usize = 1 << 25;
/// The smallest edge of a cell, m.
const SMALLEST_EDGE: f64 = 1e-9;

/// A medium on a regular grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Voxmap {
    min: Vec3,
    cell: Vec3,
    dims: [usize; 3],
    extinction: Values<Bands>,
    albedo: Values<Bands>,
    emission: Values<Bands>,
    source: Values<Bands>,
    /// In thermal mode.
    heat: Option<Values<Known>>,
}

/// A value a cell: one for all, or one each.
#[derive(Clone, Debug, PartialEq)]
enum Values<T> {
    Same(T),
    Each(Vec<T>),
}

impl<T: Copy + PartialEq> Values<T> {
    fn get(&self, index: usize) -> T {
        match self {
            Values::Same(v) => *v,
            Values::Each(list) => list[index],
        }
    }
    fn set(&mut self, index: usize, value: T, len: usize) {
        match self {
            Values::Same(v) if *v == value => {}
            Values::Same(v) => {
                let mut list = vec![*v; len];
                list[index] = value;
                *self = Values::Each(list);
            }
            Values::Each(list) => list[index] = value,
        }
    }
    /// One value where all are the same.
    fn seal(&mut self) {
        if let Values::Each(list) = self
            && list.iter().all(|v| *v == list[0])
        {
            *self = Values::Same(list[0]);
        }
    }
}

impl Voxmap {
    /// An empty grid (κ = 0 everywhere) with lower corner `min`, cell edges `cell` (m) and `dims` cells.
    pub fn new(min: Vec3, cell: Vec3, dims: [usize; 3]) -> Result<Voxmap, SceneError> {
        let count = dims.iter().try_fold(1usize, |n, &d| n.checked_mul(d)).unwrap_or(usize::MAX);
        if count == 0 {
            return Err(SceneError::new("medium.cells", "a voxmap needs at least one cell on each axis"));
        }
        if count > MAX_CELLS {
            return Err(SceneError::new(
                "medium.cells",
                format!(
                    "{} × {} × {} cells are more than the {MAX_CELLS} that a voxmap may have; use fewer",
                    dims[0], dims[1], dims[2]
                ),
            ));
        }
        let edges = vec3(dims[0] as f64, dims[1] as f64, dims[2] as f64);
        let reach = min.max_abs().max((min + cell.scale(edges)).max_abs());
        let least = cell.x.min(cell.y).min(cell.z);
        if !(min.is_finite() && cell.is_finite() && least >= SMALLEST_EDGE && reach <= LARGEST_LENGTH) {
            return Err(SceneError::new(
                "medium.max",
                format!(
                    "the bounds of a voxmap must be finite, within {LARGEST_LENGTH:e} m, with min below max on each axis"
                ),
            ));
        }
        Ok(Voxmap {
            min,
            cell,
            dims,
            extinction: Values::Same([0.0; 3]),
            albedo: Values::Same([0.0; 3]),
            emission: Values::Same([0.0; 3]),
            source: Values::Same([0.0; 3]),
            heat: None,
        })
    }

    /// Sets one cell: extinction κ (1/m), albedo Ω, black emissive power E (W/m²), source q (W/m³), each a band.
    /// Call [`Voxmap::seal`] after the last one.
    pub fn set(&mut self, index: usize, extinction: Bands, albedo: Bands, emission: Bands, source: Bands) {
        let len = self.len();
        self.extinction.set(index, extinction, len);
        self.albedo.set(index, albedo, len);
        self.emission.set(index, emission, len);
        self.source.set(index, source, len);
    }

    /// Sets all cells alike, in no time and no memory; otherwise as [`Voxmap::set`].
    pub fn fill(&mut self, extinction: Bands, albedo: Bands, emission: Bands, source: Bands) {
        self.extinction = Values::Same(extinction);
        self.albedo = Values::Same(albedo);
        self.emission = Values::Same(emission);
        self.source = Values::Same(source);
    }

    /// Sets what is known of one cell in thermal mode: its temperature (K), or the heat that it gives (W/m³); of all the others
    /// `rest` where nothing was known before. Call [`Voxmap::seal`] after the last one.
    pub fn set_heat(&mut self, index: usize, known: Known, rest: Known) {
        let len = self.len();
        self.heat.get_or_insert(Values::Same(rest)).set(index, known, len);
    }

    /// Sets what is known of all cells in thermal mode.
    pub fn fill_heat(&mut self, known: Known) {
        self.heat = Some(Values::Same(known));
    }

    /// Forgets temperatures and heat.
    pub fn clear_heat(&mut self) {
        self.heat = None;
    }

    /// Multiplies emission and source of every cell by a factor a band. Call [`Voxmap::seal`] afterwards.
    pub fn scale_sources(&mut self, factor: Bands) {
        let scaled = |v: Bands| bands(|b| v[b] * factor[b]);
        for values in [&mut self.emission, &mut self.source] {
            match values {
                Values::Same(v) => *v = scaled(*v),
                Values::Each(list) => list.iter_mut().for_each(|v| *v = scaled(*v)),
            }
        }
    }

    /// Replaces the albedo of every cell. Call [`Voxmap::seal`] afterwards.
    pub fn set_albedo(&mut self, albedo: Bands) {
        self.albedo = Values::Same(albedo);
    }

    /// Validates every cell and notes whether the extinction is uniform.
    pub fn seal(mut self) -> Result<Voxmap, SceneError> {
        for i in 0..if self.is_uniform() { 1 } else { self.len() } {
            let bad = |key: &str, what: &str, value: f64| {
                let [x, y, z] = self.coordinates(i);
                Err(SceneError::new(key, format!("{what} is {value} in cell ({x}, {y}, {z})")))
            };
            for b in 0..3 {
                let (k, o, e, q) =
                    (self.extinction(i)[b], self.albedo(i)[b], self.emission(i)[b], self.source(i)[b]);
                let ranges = [
                    ("extinction", k, LARGEST_EXTINCTION),
                    ("albedo", o, 1.0),
                    ("emission", e, LARGEST_FLUX),
                    ("source", q, LARGEST_FLUX),
                ];
                if let Some((key, x, max)) = ranges.into_iter().find(|r| !(0.0..=r.2).contains(&r.1)) {
                    return bad(
                        &format!("medium.{key}"),
                        &format!("the {key} must lie between 0 and {max:e}, but"),
                        x,
                    );
                }
                if q > 0.0 && k == 0.0 {
                    return bad(
                        "medium.source",
                        "a source needs a medium (extinction above 0) to come from; the source",
                        q,
                    );
                }
            }
        }
        for values in [&mut self.extinction, &mut self.albedo, &mut self.emission, &mut self.source] {
            values.seal();
        }
        if let Some(heat) = &mut self.heat {
            heat.seal();
        }
        self.check_heat()?;
        Ok(self)
    }

    /// Heat comes from cells that absorb, and kelvin are above 0.
    fn check_heat(&self) -> Result<(), SceneError> {
        if self.heat.is_none() {
            return Ok(());
        }
        for i in 0..if self.is_uniform() { 1 } else { self.len() } {
            let [x, y, z] = self.coordinates(i);
            let at =
                |e: SceneError| SceneError::new(e.key(), format!("in cell ({x}, {y}, {z}) {}", e.what()));
            let Some(known) = self.heat(i) else { continue };
            known
                .check(|k| format!("medium.{}", if k == "temperature" { k } else { "heat_source" }))
                .map_err(at)?;
            let (k, o) = (self.extinction(i), self.albedo(i));
            let absorbs = (0..3).any(|b| k[b] * (1.0 - o[b]) > 0.0);
            if matches!(known, Known::Flux(q) | Known::Power(q) if q != 0.0) && !absorbs {
                let what = "heat needs a medium that absorbs to come from; raise the extinction, lower the albedo, or give 0";
                return Err(at(SceneError::new("medium.heat_source", what)));
            }
        }
        Ok(())
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.dims[0] * self.dims[1] * self.dims[2]
    }
    /// Never true: a voxmap has cells.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Lower corner, m.
    pub fn min(&self) -> Vec3 {
        self.min
    }
    /// Upper corner, m.
    pub fn max(&self) -> Vec3 {
        self.min + self.cell.scale(vec3(self.dims[0] as f64, self.dims[1] as f64, self.dims[2] as f64))
    }
    /// Cell edges, m.
    pub fn cell(&self) -> Vec3 {
        self.cell
    }
    /// Cells along each axis.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }
    /// Index of a cell.
    pub fn index(&self, c: [usize; 3]) -> usize {
        (c[0] * self.dims[1] + c[1]) * self.dims[2] + c[2]
    }
    /// Cell of an index.
    pub fn coordinates(&self, index: usize) -> [usize; 3] {
        let (ny, nz) = (self.dims[1], self.dims[2]);
        [index / (ny * nz), index / nz % ny, index % nz]
    }
    /// Lower corner of a cell.
    pub fn corner(&self, c: [usize; 3]) -> Vec3 {
        self.min + self.cell.scale(vec3(c[0] as f64, c[1] as f64, c[2] as f64))
    }
    /// Centre of a cell.
    pub fn centre(&self, c: [usize; 3]) -> Vec3 {
        self.corner(c) + self.cell * 0.5
    }
    /// The cell that holds `p`, if any.
    pub fn cell_at(&self, p: Vec3) -> Option<[usize; 3]> {
        let mut c = [0; 3];
        for axis in 0..3 {
            let t = (p[axis] - self.min[axis]) / self.cell[axis];
            if !(t >= 0.0 && t <= self.dims[axis] as f64) {
                return None;
            }
            c[axis] = (t as usize).min(self.dims[axis] - 1);
        }
        Some(c)
    }
    /// Extinction κ of a cell, 1/m.
    pub fn extinction(&self, index: usize) -> Bands {
        self.extinction.get(index)
    }
    /// Scattering albedo Ω of a cell.
    pub fn albedo(&self, index: usize) -> Bands {
        self.albedo.get(index)
    }
    /// Black emissive power E of a cell, W/m².
    pub fn emission(&self, index: usize) -> Bands {
        self.emission.get(index)
    }
    /// Volumetric source q of a cell, W/m³.
    pub fn source(&self, index: usize) -> Bands {
        self.source.get(index)
    }
    /// What is known of a cell in thermal mode; none in light mode.
    pub fn heat(&self, index: usize) -> Option<Known> {
        self.heat.as_ref().map(|h| h.get(index))
    }
    /// True where cells know temperatures or heat sources.
    pub fn is_thermal(&self) -> bool {
        self.heat.is_some()
    }
    /// True where all cells are alike in everything.
    pub fn is_uniform(&self) -> bool {
        let same = |v: &Values<Bands>| matches!(v, Values::Same(_));
        [&self.extinction, &self.albedo, &self.emission, &self.source].into_iter().all(same)
            && !matches!(self.heat, Some(Values::Each(_)))
    }
    /// The extinction, where it is the same in every cell.
    pub fn uniform_extinction(&self) -> Option<Bands> {
        if let Values::Same(k) = self.extinction { Some(k) } else { None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_and_points_agree() {
        let v = Voxmap::new(vec3(-1.0, 0.0, 2.0), vec3(0.5, 0.25, 1.0), [4, 3, 2]).unwrap();
        for i in 0..v.len() {
            let c = v.coordinates(i);
            assert_eq!(v.index(c), i);
            assert_eq!(v.cell_at(v.centre(c)), Some(c));
        }
        assert_eq!(v.cell_at(v.max()), Some([3, 2, 1]));
        assert_eq!(v.cell_at(vec3(5.0, 0.0, 2.0)), None);
    }

    #[test]
    fn too_many_cells_are_refused_before_they_are_allocated() {
        assert!(Voxmap::new(Vec3::ZERO, Vec3::ONE, [10_000, 10_000, 10_000]).is_err());
        assert!(Voxmap::new(Vec3::ZERO, Vec3::ONE, [usize::MAX, 2, 2]).is_err());
        assert!(Voxmap::new(Vec3::ZERO, Vec3::ZERO, [2, 2, 2]).is_err());
    }

    #[test]
    fn a_bad_cell_is_named() {
        let mut v = Voxmap::new(Vec3::ZERO, Vec3::ONE, [2, 2, 2]).unwrap();
        v.set(3, [1.0, -1.0, 1.0], [0.5; 3], [0.0; 3], [0.0; 3]);
        let e = v.seal().unwrap_err();
        assert!(e.to_string().contains("(0, 1, 1)"), "{e}");
    }
}
