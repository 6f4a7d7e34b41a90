//! `[medium]`: the voxmap, its background and its regions.

use super::build::Builder;
use super::error::InputError;
use super::node::{Node, Table};
use super::{arrays, region, shapes, thermal};
use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, Known, SceneError, Voxmap, bands, voxmap::MAX_CELLS};

/// The keys of what fills a place.
pub(crate) const MATTER: [&str; 7] =
    ["extinction", "albedo", "emission", "source", "absorption", "temperature", "heat_source"];

/// What fills a place: κ (1/m), Ω, E (W/m²), q (W/m³), temperature or heat; what is not given stays as it was there.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Matter {
    pub(crate) extinction: Option<Bands>,
    pub(crate) albedo: Option<Bands>,
    pub(crate) emission: Option<Bands>,
    pub(crate) source: Option<Bands>,
    /// In thermal mode.
    pub(crate) heat: Option<Known>,
}

impl Matter {
    /// What a table says in numbers; arrays from files are for [`super::arrays`].
    pub(crate) fn read(t: &Table<'_>, b: &Builder<'_>) -> Result<Matter, InputError> {
        thermal::check_mode(t, b.thermal())?;
        let [extinction, albedo] = thermal::extinction(t)?;
        let emission = match t.get("emission") {
            Some(n) if !n.is_table() => Some(n.bands(f64::INFINITY)?),
            _ => None,
        };
        Ok(Matter {
            extinction,
            albedo,
            emission,
            source: t.read("source", |n| n.bands(f64::INFINITY))?,
            heat: thermal::volume(t)?,
        })
    }
}

/// Nothing is known yet of a cell's heat.
const UNKNOWN: Known = Known::Flux(f64::NAN);

/// One cell: κ, Ω, E, q, and what is known of its heat in thermal mode.
#[derive(Clone, Copy, Debug)]
struct Cell {
    extinction: Bands,
    albedo: Bands,
    emission: Bands,
    source: Bands,
    heat: Known,
}

impl Cell {
    /// The cell with a share of it, 0 ≤ f ≤ 1, filled anew. Extinction, scattering κΩ, emitted power κ_a E and source
    /// are means over the volume, so that what is mixed keeps its power; so are κ_a T⁴ and heat. Where a temperature meets a heat source, the
    /// larger part says which of them the cell has.
    fn fill(&mut self, f: f64, m: &Matter) {
        let old = *self;
        let new = Cell {
            extinction: m.extinction.unwrap_or(old.extinction),
            albedo: m.albedo.unwrap_or(old.albedo),
            emission: m.emission.unwrap_or(old.emission),
            source: m.source.unwrap_or(old.source),
            heat: m.heat.unwrap_or(old.heat),
        };
        if f >= 1.0 {
            *self = new;
            return;
        }
        let mix = |a: f64, b: f64| a + f * (b - a);
        // The mean of a and b weighted with their shares and with wa and wb; the plain mean where both weights vanish.
        let weighted = |a: f64, wa: f64, b: f64, wb: f64| {
            let (wa, wb) = ((1.0 - f) * wa, f * wb);
            if a == b || wa + wb <= 0.0 { mix(a, b) } else { a + (b - a) * (wb / (wa + wb)) }
        };
        let absorption = |c: &Cell, k: usize| c.extinction[k] * (1.0 - c.albedo[k]);
        *self = Cell {
            extinction: bands(|k| mix(old.extinction[k], new.extinction[k])),
            albedo: bands(|k| weighted(old.albedo[k], old.extinction[k], new.albedo[k], new.extinction[k])),
            emission: bands(|k| {
                weighted(old.emission[k], absorption(&old, k), new.emission[k], absorption(&new, k))
            }),
            source: bands(|k| mix(old.source[k], new.source[k])),
            heat: match (old.heat, new.heat) {
                (a, b) if a == b => a,
                (Known::Temperature(a), Known::Temperature(b)) => {
                    let whole = |c: &Cell| (0..3).map(|k| absorption(c, k)).sum::<f64>();
                    Known::Temperature(weighted(a.powi(4), whole(&old), b.powi(4), whole(&new)).powf(0.25))
                }
                (Known::Flux(a), Known::Flux(b)) if a.is_finite() && b.is_finite() => Known::Flux(mix(a, b)),
                (Known::Flux(a), b) if a.is_nan() => b,
                (a, b) => {
                    if f >= 0.5 {
                        b
                    } else {
                        a
                    }
                }
            },
        };
    }
}

/// The voxmap while it is filled.
pub(crate) struct Grid {
    pub(crate) min: Vec3,
    pub(crate) cell: Vec3,
    pub(crate) dims: [usize; 3],
    voxmap: Voxmap,
}

impl Grid {
    /// Fills a share of a cell anew.
    pub(crate) fn fill(&mut self, cell: [usize; 3], share: f64, matter: &Matter) {
        let v = &mut self.voxmap;
        let i = v.index(cell);
        let mut c = Cell {
            extinction: v.extinction(i),
            albedo: v.albedo(i),
            emission: v.emission(i),
            source: v.source(i),
            heat: v.heat(i).unwrap_or(UNKNOWN),
        };
        c.fill(share, matter);
        v.set(i, c.extinction, c.albedo, c.emission, c.source);
        if v.is_thermal() {
            v.set_heat(i, c.heat, UNKNOWN);
        }
    }
    /// The cells along an axis that [lo, hi] overlaps, each with its overlapped share.
    pub(crate) fn overlaps(&self, axis: usize, lo: f64, hi: f64) -> Vec<(usize, f64)> {
        let (n, size) = (self.dims[axis], self.cell[axis]);
        let to_cell = |x: f64| (x - self.min[axis]) / size;
        let (a, b) = (to_cell(lo), to_cell(hi));
        // Rounding must not leave a hair's breadth of a neighbour.
        let snap = |x: f64| {
            if (x - x.round()).abs() < 1e-9 { x.round() } else { x }
        };
        let (a, b) = (snap(a).max(0.0), snap(b).min(n as f64));
        if b <= a || a.is_nan() || b.is_nan() {
            return Vec::new();
        }
        (a.floor() as usize..(b.ceil() as usize).min(n))
            .map(|i| (i, b.min(i as f64 + 1.0) - a.max(i as f64)))
            .filter(|(_, share)| *share > 0.0)
            .collect()
    }
    /// The medium's corners.
    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        (self.min, self.voxmap.max())
    }
    /// Fills the part of each cell that a box overlaps; gives the number of cells met.
    pub(crate) fn fill_box(&mut self, min: Vec3, max: Vec3, m: &Matter) -> usize {
        let [x, y, z] = [0, 1, 2].map(|axis| self.overlaps(axis, min[axis], max[axis]));
        for &(i, fx) in &x {
            for &(j, fy) in &y {
                for &(k, fz) in &z {
                    self.fill([i, j, k], fx * fy * fz, m);
                }
            }
        }
        x.len() * y.len() * z.len()
    }
}

/// Reads `[medium]`.
pub(crate) fn read_medium(node: &Node<'_>, b: &mut Builder<'_>) -> Result<Voxmap, InputError> {
    let mut known = vec!["min", "max", "cells", "cell_size", "region"];
    known.extend(MATTER);
    let (min, max) = shapes::bounds(node, &known)?;
    let t = node.any_table()?;
    let dims = cells(&t, max - min)?;
    let count = dims.iter().fold(1usize, |n, d| n.saturating_mul(*d));
    if count > b.place.most_cells && count <= MAX_CELLS {
        let what =
            format!("{count} cells are more than the {} that are read here; use fewer", b.place.most_cells);
        return Err(b.source.scene_error(&SceneError::new("medium.cells", what)));
    }
    let size = max - min;
    let cell = vec3(size.x / dims[0] as f64, size.y / dims[1] as f64, size.z / dims[2] as f64);
    let refused = |e: zonal_scene::SceneError| b.source.scene_error(&e);
    let mut grid = Grid { min, cell, dims, voxmap: Voxmap::new(min, cell, dims).map_err(refused)? };
    let background = Matter::read(&t, b)?;
    let regions = t.list("region")?;
    if background.extinction.is_none() && regions.is_empty() && b.fills.is_empty() {
        let what = "nothing fills the medium; write extinction = 0.1 (1/m) or add a [[medium.region]]";
        return Err(node.error(what));
    }
    let of = |x: Option<Bands>| x.unwrap_or_default();
    let Matter { extinction, albedo, emission, source, heat } = background;
    grid.voxmap.fill(of(extinction), of(albedo), of(emission), of(source));
    if b.thermal() {
        grid.voxmap.fill_heat(heat.unwrap_or(UNKNOWN));
    }
    arrays::read_arrays(&t, &mut grid, (min, max), b)?;
    for region in &regions {
        region::read_region(region, &mut grid, b)?;
    }
    for fill in std::mem::take(&mut b.fills) {
        region::fill_inside(&mut grid, &fill.plates, &fill.matter);
    }
    if b.thermal() {
        check_known(&mut grid.voxmap).map_err(|e| b.source.scene_error(&e))?;
    }
    grid.voxmap.seal().map_err(|e| b.source.scene_error(&e))
}

/// Refuses cells that absorb and of which nothing is known; the others are in equilibrium.
fn check_known(map: &mut Voxmap) -> Result<(), SceneError> {
    for i in 0..if map.is_uniform() { 1 } else { map.len() } {
        if !map.heat(i).is_some_and(|k| matches!(k, Known::Flux(q) if q.is_nan())) {
            continue;
        }
        if map.extinction(i) != [0.0; 3] {
            let [x, y, z] = map.coordinates(i);
            let what = format!(
                "nothing is known of the medium in cell ({x}, {y}, {z}); write temperature (K) or heat_source (W/m3), 0 for radiative equilibrium"
            );
            return Err(SceneError::new("medium.temperature", what));
        }
        match map.is_uniform() {
            true => map.fill_heat(Known::Flux(0.0)),
            false => map.set_heat(i, Known::Flux(0.0), UNKNOWN),
        }
    }
    Ok(())
}

/// `cells = [nx, ny, nz]` or `cell_size`, rounded to whole cells.
fn cells(t: &Table<'_>, size: Vec3) -> Result<[usize; 3], InputError> {
    match (t.get("cells"), t.get("cell_size")) {
        (Some(n), None) => n.counts(),
        (None, Some(n)) => {
            let wanted = n.lengths()?;
            // What overflows becomes usize::MAX and is refused by the voxmap, on the line of this key.
            t.source.remember("medium.cells", n.offset());
            Ok([0, 1, 2].map(|axis| ((size[axis] / wanted[axis]).round() as usize).max(1)))
        }
        (Some(_), Some(n)) => Err(n.error("cells and cell_size are both given; keep one of them")),
        (None, None) => {
            Err(t
                .error("neither cells nor cell_size is given; write cells = [20, 30, 15] or cell_size = 0.2"))
        }
    }
}
