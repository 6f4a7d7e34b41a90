//! `density = { file, … }`: extinction = scale × a field from a file, the mean over each cell of what lies in it.
//!
//! Arrays (npy, Mitsuba's vol) fill the box min … max; of an OpenVDB grid only the active voxels fill, the rest stays as it
//! was there. Either way ∫ extinction dV of what lies in the medium is that of the file.

use super::build::Builder;
use super::error::{Fault, InputError};
use super::medium::{Grid, Matter};
use super::node::Node;
use super::npy::{self, Array};
use super::vdb::{self, fill};
use super::{shapes, vol};
use zonal_math::Vec3;
use zonal_scene::{Bands, Known, Note, bands};

/// The keys that place a grid of an OpenVDB file.
const VDB_KEYS: [&str; 5] = ["grid", "unit", "translate", "rotate_degrees", "level_set"];

/// What a file's values become.
pub(crate) struct Filling<'a> {
    /// What is averaged over a cell, of a value.
    pub(crate) of: fn(f64) -> f64,
    /// The power of `scale` that belongs to it.
    pub(crate) power: i32,
    /// The matter of a mean × scale.
    pub(crate) matter: &'a dyn Fn(Bands) -> Matter,
    /// Where an array lies that has no place of its own.
    pub(crate) place: Option<(Vec3, Vec3)>,
    /// What a value is, for messages.
    pub(crate) word: &'static str,
}

impl<'a> Filling<'a> {
    /// Of the values themselves.
    pub(crate) fn plain(matter: &'a dyn Fn(Bands) -> Matter) -> Filling<'a> {
        Filling { of: |x| x, power: 1, matter, place: None, word: "density" }
    }
}

/// Reads the file and fills it in; gives the number of cells met.
pub(crate) fn read_density(
    node: &Node<'_>,
    grid: &mut Grid,
    filling: &Filling<'_>,
    b: &mut Builder<'_>,
) -> Result<usize, InputError> {
    let mut known = vec!["file", "min", "max", "scale"];
    known.extend(VDB_KEYS);
    let t = node.table(&known)?;
    let bounds = match (t.get("min"), t.get("max")) {
        (None, None) => None,
        _ => Some(shapes::bounds(node, &known[..])?),
    };
    let scale = t.read("scale", |n| n.bands(f64::INFINITY))?.unwrap_or([1.0; 3]);
    let scale = scale.map(|s| s.powi(filling.power));
    let file = t.need("file", "file = \"smoke.npy\" (or .vdb, .vol)")?;
    let path = b.resolve(&file)?;
    let name = path.display().to_string();
    let bytes = b.place.files.read(&path, npy::MAX_FILE).map_err(|e| file.error(format!("{name}: {e}")))?;
    let refused = |f: Fault| file.error(f.to_string());
    if vdb::is_vdb(&bytes) {
        let placing = fill::Placing::read(&t, bounds)?;
        let (cells, note) = fill::fill(&name, &bytes, &placing, scale, filling, grid).map_err(refused)?;
        if let Some(note) = note {
            b.note(Note::new("grid-outside", note));
        }
        return Ok(cells);
    }
    if let Some(n) = VDB_KEYS.iter().find_map(|k| t.get(k)) {
        return Err(n.error("only OpenVDB files know this key; remove it and give min and max"));
    }
    let (array, own) = if vol::is_vol(&bytes) {
        let (array, own) = vol::parse(&name, &bytes, filling.word).map_err(refused)?;
        (array, Some(own))
    } else {
        (npy::parse(&name, &bytes, filling.word).map_err(refused)?, None)
    };
    drop(bytes);
    // Without a place of its own the array needs one, and the refusal says so.
    let (min, max) = match bounds.or(own).or(filling.place) {
        Some(bounds) => bounds,
        None => shapes::bounds(node, &known)?,
    };
    Ok(fill_array(&array, min, max, scale, filling, grid))
}

fn fill_array(
    array: &Array,
    min: Vec3,
    max: Vec3,
    scale: Bands,
    filling: &Filling<'_>,
    grid: &mut Grid,
) -> usize {
    let weights = [0, 1, 2].map(|axis| Weights::new(grid, axis, min[axis], max[axis], array.shape[axis]));
    let [nx, ny, nz] = [0, 1, 2].map(|axis| weights[axis].cells.len());
    for x in &weights[0].cells {
        for y in &weights[1].cells {
            for z in &weights[2].cells {
                let share = x.share * y.share * z.share;
                let mean = mean(array, [&x.parts, &y.parts, &z.parts], filling.of) / share;
                let matter = (filling.matter)(scale.map(|s| s * mean));
                grid.fill([x.cell, y.cell, z.cell], share.min(1.0), &matter);
            }
        }
    }
    nx * ny * nz
}

/// The matter of a density: sources only where there is something to come from.
pub(crate) fn smoke(matter: &Matter, extinction: Bands) -> Matter {
    let source = matter.source.map(|q| bands(|k| if extinction[k] > 0.0 { q[k] } else { 0.0 }));
    let heat = match matter.heat {
        Some(Known::Flux(_)) if extinction == [0.0; 3] => Some(Known::Flux(0.0)),
        heat => heat,
    };
    Matter { extinction: Some(extinction), source, heat, ..*matter }
}

/// Along one axis: the grid's cells that the array overlaps.
struct Weights {
    cells: Vec<CellShare>,
}

struct CellShare {
    cell: usize,
    /// The share of the cell that is overlapped.
    share: f64,
    /// The array's elements in it, each with its share of the cell.
    parts: Vec<(usize, f64)>,
}

impl Weights {
    fn new(grid: &Grid, axis: usize, lo: f64, hi: f64, n: usize) -> Weights {
        let step = (hi - lo) / n as f64;
        let cells = grid.overlaps(axis, lo, hi).into_iter().map(|(cell, _)| {
            let start = grid.min[axis] + cell as f64 * grid.cell[axis];
            // The cell in units of the array's elements.
            let (a, b) = ((start - lo) / step, (start + grid.cell[axis] - lo) / step);
            let (a, b) = (a.max(0.0), b.min(n as f64));
            let to_cell = step / grid.cell[axis];
            let parts: Vec<(usize, f64)> = (a.floor() as usize..(b.ceil().max(0.0) as usize).min(n))
                .map(|i| (i, (b.min(i as f64 + 1.0) - a.max(i as f64)) * to_cell))
                .filter(|(_, w)| *w > 0.0)
                .collect();
            CellShare { cell, share: parts.iter().map(|(_, w)| w).sum(), parts }
        });
        Weights { cells: cells.filter(|c| c.share > 0.0).collect() }
    }
}

/// Σ of what the array's values stand for times their shares of a cell.
fn mean(array: &Array, [x, y, z]: [&[(usize, f64)]; 3], of: fn(f64) -> f64) -> f64 {
    let [_, ny, nz] = array.shape;
    let mut sum = 0.0;
    for &(i, wx) in x {
        for &(j, wy) in y {
            let row = &array.values[(i * ny + j) * nz..][..nz];
            let along: f64 = z.iter().map(|&(k, wz)| wz * of(f64::from(row[k]))).sum();
            sum += wx * wy * along;
        }
    }
    sum
}
