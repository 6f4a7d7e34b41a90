//! `density = { file, … }`: extinction = scale × a field from a file, averaged over the volume of each voxel.
//!
//! Arrays (npy, Mitsuba's vol) fill the box min … max; of an OpenVDB grid only the active voxels fill. Either way ∫ extinction dV over the
//! part inside the medium is that of the file.
//!
//! The elements of an array of densities are samples at their centres, between which the field is trilinear; beyond the outermost centres it is constant. With
//! the hat functions h of the samples along each axis, a voxel of the edges a … b along an axis gets
//!
//! ```text
//! κ = scale Σ_ijk w_i w_j w_k f_ijk,   w_i = ∫_a^b h_i(x) dx / (b − a)
//! ```
//!
//! per axis: the exact mean of the trilinear field. Arrays whose elements are the voxels themselves, all other quantities, and `interpolation = "constant"` have boxes
//! for h. In pictures the extinction of the voxels that an interpolated density fills is interpolated too (`VoxelGrid::mark_interpolated`).

use super::voxel_field::VoxelField;
use super::voxel_grid::VoxelGridBuilder;
use crate::input::grids::{vdb, vol};
use crate::input::memory_arrays;
use crate::input::mesh_files::converters::{self, FileContents};
use crate::input::reading::error::{FileFault, InputError};
use crate::input::reading::npy::{self, ScalarArray};
use crate::input::scene::media::resample::{self, GridPlacement, ResampledField};
use crate::input::scene::scene_reader::SceneReader;
use crate::input::scene::shapes;
use crate::input::toml::medium_keys::{DENSITY_FILE, DensityFile, VOXEL_FILE, Vdb, VoxelFile as FileKeys};
use crate::input::toml::node::{TomlNode, TomlTable};
use std::path::Path;
use zonal_math::Vec3;
use zonal_scene::{Bands, Diagnostic};

/// Distance between the planes of elements and those of voxels, in voxels, below which the elements are the voxels.
const SAME_CELLS_TOLERANCE: f64 = 1e-6;

/// Refuses keys of OpenVDB files for other arrays.
fn refuse_vdb_keys(t: &TomlTable<'_>) -> Result<(), InputError> {
    match Vdb::ALL.iter().find_map(|k| t.get(k.name)) {
        Some(n) => Err(n.error("only OpenVDB files know this key; remove it and give min and max")),
        None => Ok(()),
    }
}

/// Reads the file and fills it in; returns the number of voxels that it overlaps.
pub(crate) fn read_density(
    node: &TomlNode<'_>,
    grid: &mut VoxelGridBuilder,
    field: &VoxelField<'_>,
    reader: &mut SceneReader<'_>,
) -> Result<usize, InputError> {
    let t = node.table(if field.is_density { DensityFile::TABLE } else { FileKeys::TABLE })?;
    let has_bounds = t.get(&VOXEL_FILE.min).or_else(|| t.get(&VOXEL_FILE.max)).is_some();
    let bounds = has_bounds.then(|| shapes::read_bounds(&t)).transpose()?;
    let scale = t.or_default(&VOXEL_FILE.scale)?;
    let scale = scale.map(|s| s.powi(field.scale_exponent));
    let interpolated = read_interpolation(&t, field)?;
    let file = t.require(&VOXEL_FILE.file)?;
    let (path, _) = file.named_file()?;
    let name = path.display().to_string();
    if let Some(memory) = reader.context.files.array(&path) {
        refuse_vdb_keys(&t)?;
        let array = memory_arrays::grid(&memory, &name, field.noun).map_err(|f| file.error(f.to_string()))?;
        let bounds = bounds.or(field.default_bounds).map_or_else(|| shapes::read_bounds(&t), Ok)?;
        let colours = &Bands::from_rgb;
        return Ok(ArrayFill { arrays: &[array], bounds, scale, colours, interpolated }.fill(field, grid));
    }
    let contents = file.once(|| read_contents(&t, bounds, &path, field, reader, grid))?;
    let PlacedArrays { arrays, bounds: own_bounds, note } = match &*contents {
        VoxelFile::Resampled(resampled) => {
            let cells = resampled.fill(scale, field, grid);
            if interpolated {
                grid.mark_interpolated(&cells);
            }
            let note = resampled.note.iter();
            note.for_each(|text| reader.note(Diagnostic::note("grid-outside", text.as_str())));
            return Ok(cells.len());
        }
        VoxelFile::Arrays(arrays) => arrays,
    };
    note.iter().for_each(|text| reader.note(Diagnostic::note("trailing-bytes", text.as_str())));
    // Resample an array.
    // Without any bounds the error names the missing key.
    let bounds =
        bounds.or(*own_bounds).or(field.default_bounds).map_or_else(|| shapes::read_bounds(&t), Ok)?;
    check_channels(arrays.len(), field, reader).map_err(|e| file.error(format!("{name}: {e}")))?;
    let source = &reader.source;
    let colours = |rgb| source.bands().from_rgb(source.block(), rgb).unwrap_or(Bands::from_rgb(rgb));
    Ok(ArrayFill { arrays, bounds, scale, colours: &colours, interpolated }.fill(field, grid))
}

/// The contents of the file that a table names.
fn read_contents(
    t: &TomlTable<'_>,
    bounds: Option<(Vec3, Vec3)>,
    path: &Path,
    field: &VoxelField<'_>,
    reader: &SceneReader<'_>,
    grid: &VoxelGridBuilder,
) -> Result<VoxelFile, InputError> {
    let file = t.require(&VOXEL_FILE.file)?;
    let name = path.display().to_string();
    let refused = |f: FileFault| file.error(f.to_string());
    let bytes = read_voxel_file(path, reader).map_err(|e| file.error(format!("{name}: {e}")))?;
    if !vdb::is_vdb(&bytes) {
        refuse_vdb_keys(t)?;
        return Ok(VoxelFile::Arrays(parse_arrays(&name, &bytes, field).map_err(refused)?));
    }
    let placement = GridPlacement::read(t, bounds)?;
    let resampled = resample::resample(&name, &bytes, &placement, field, grid).map_err(refused)?;
    Ok(VoxelFile::Resampled(resampled))
}

/// The bytes of a file of voxels; an error states the defect and the remedy.
fn read_voxel_file(path: &Path, reader: &SceneReader<'_>) -> Result<Vec<u8>, String> {
    match converters::conversion_hint(path, FileContents::Voxels) {
        Some(hint) => Err(hint),
        None => reader.context.files.read(path, npy::MAX_ARRAY_FILE_BYTES),
    }
}

/// Contents of a file of voxels, the same for all bands.
enum VoxelFile {
    Arrays(PlacedArrays),
    /// A sparse grid on the voxels of the medium.
    Resampled(ResampledField),
}

/// The arrays of a file.
struct PlacedArrays {
    arrays: Vec<ScalarArray<'static>>,
    /// The box that the file gives them, m.
    bounds: Option<(Vec3, Vec3)>,
    /// A note on bytes after the array.
    note: Option<String>,
}

/// The arrays of a volume or npy file.
fn parse_arrays(name: &str, bytes: &[u8], field: &VoxelField<'_>) -> Result<PlacedArrays, FileFault> {
    if vol::is_vol(bytes) {
        let (arrays, own) = vol::parse(name, bytes, field.noun)?;
        return Ok(PlacedArrays { arrays, bounds: Some(own), note: None });
    }
    let array = npy::parse(name, bytes, field.noun)?;
    Ok(PlacedArrays { arrays: vec![array], bounds: None, note: npy::trailing_note(name, bytes) })
}

/// True if the values are samples of a field that is interpolated: those of densities, unless the table says otherwise.
fn read_interpolation(t: &TomlTable<'_>, field: &VoxelField<'_>) -> Result<bool, InputError> {
    Ok(field.is_density && t.or_default(&DENSITY_FILE.interpolation)? == 0)
}

/// Refuses three channels of a quantity that has one value in all bands, and in bands of which no colour is known.
fn check_channels(count: usize, field: &VoxelField<'_>, reader: &SceneReader<'_>) -> Result<(), String> {
    let bands = reader.source.bands();
    if count == 1 {
        return Ok(());
    }
    if !field.has_bands {
        return Err(format!("three channels are no {}; save the volume with one channel", field.noun));
    }
    // Three numbered bands take one channel each.
    if bands.from_rgb(reader.source.block(), [1.0, 0.5, 0.0]).is_some() || bands.count() == count {
        Ok(())
    } else {
        Err("its channels are red, green and blue, which have no meaning in bands without wavelengths; save the volume with one channel, or give bands = [[from, to], …] in nm".into())
    }
}

/// Dense arrays in a box: one of values for all bands, or three of red, green and blue.
struct ArrayFill<'a> {
    arrays: &'a [ScalarArray<'a>],
    bounds: (Vec3, Vec3),
    scale: Bands,
    /// The values of the bands of red, green and blue.
    colours: &'a dyn Fn([f64; 3]) -> Bands,
    /// True if the elements are samples of a trilinear field.
    interpolated: bool,
}

impl ArrayFill<'_> {
    /// Fills the voxels that the arrays overlap; returns their number.
    fn fill(&self, field: &VoxelField<'_>, grid: &mut VoxelGridBuilder) -> usize {
        let Some(array) = self.arrays.first() else { return 0 };
        let (min, max) = self.bounds;
        // Elements that are the voxels keep their values.
        let is_same = |axis: usize| {
            let to_voxels = |x: f64| (x - grid.min[axis]) / grid.cell[axis];
            let step = (max[axis] - min[axis]) / array.shape[axis] as f64 / grid.cell[axis];
            let off = to_voxels(min[axis]) - to_voxels(min[axis]).round();
            off.abs().max((step - 1.0).abs() * array.shape[axis] as f64) < SAME_CELLS_TOLERANCE
        };
        let hats = self.interpolated && !(0..3).all(is_same);
        let overlaps =
            [0, 1, 2].map(|axis| axis_overlaps(grid, axis, min[axis], max[axis], array.shape[axis], hats));
        let [nx, ny, nz] = [0, 1, 2].map(|axis| overlaps[axis].len());
        for x in &overlaps[0] {
            for y in &overlaps[1] {
                for z in &overlaps[2] {
                    let fraction = x.fraction * y.fraction * z.fraction;
                    let mean = |array: &ScalarArray<'_>| {
                        let elements: [&[(usize, f64)]; 3] = [&x.elements, &y.elements, &z.elements];
                        weighted_sum(array, elements, field.averaged) / fraction
                    };
                    let values = match self.arrays {
                        [red, green, blue] => {
                            self.scale * (self.colours)([mean(red), mean(green), mean(blue)])
                        }
                        _ => self.scale * mean(array),
                    };
                    let properties = (field.properties)(values);
                    grid.fill([x.cell, y.cell, z.cell], fraction.min(1.0), &properties);
                    if self.interpolated {
                        grid.mark_interpolated(&[grid.grid.index([x.cell, y.cell, z.cell])]);
                    }
                }
            }
        }
        nx * ny * nz
    }
}

/// A voxel that the array overlaps along one axis.
struct AxisOverlap {
    cell: usize,
    /// Overlapped fraction of the voxel's edge.
    fraction: f64,
    /// The array's elements in it, each with its fraction of the voxel's edge.
    elements: Vec<(usize, f64)>,
}

/// The voxels along one axis that an array of `n` elements from lo to hi overlaps; the weights of the elements are those of hat functions where `hats` says so.
fn axis_overlaps(
    grid: &VoxelGridBuilder,
    axis: usize,
    lo: f64,
    hi: f64,
    n: usize,
    hats: bool,
) -> Vec<AxisOverlap> {
    let step = (hi - lo) / n as f64;
    let cells = grid.overlaps(axis, lo, hi).into_iter().map(|(cell, _)| {
        let start = grid.min[axis] + cell as f64 * grid.cell[axis];
        // The voxel in units of the array's elements.
        let (a, b) = ((start - lo) / step, (start + grid.cell[axis] - lo) / step);
        let (a, b) = (a.max(0.0), b.min(n as f64));
        let to_cell = step / grid.cell[axis];
        // A hat reaches half an element farther.
        let reach = if hats { 0.5 } else { 0.0 };
        let first = (a - reach).floor().max(0.0) as usize;
        let elements: Vec<(usize, f64)> = (first..((b + reach).ceil().max(0.0) as usize).min(n))
            .map(|i| {
                let own =
                    |x: f64| if hats { hat_integral(x, i, n) } else { x.clamp(i as f64, i as f64 + 1.0) };
                (i, (own(b) - own(a)) * to_cell)
            })
            .filter(|(_, w)| *w > 0.0)
            .collect();
        AxisOverlap { cell, fraction: elements.iter().map(|(_, w)| w).sum(), elements }
    });
    cells.filter(|c| c.fraction > 0.0).collect()
}

/// Integral from 0 to `x` of the hat function of element `i` of `n`, in units of elements: 1 at its centre i + ½, 0 at those beside it; those of the first and
/// the last element are 1 up to the border.
fn hat_integral(x: f64, i: usize, n: usize) -> f64 {
    let d = x - (i as f64 + 0.5);
    let below = match i {
        0 => (d + 0.5).clamp(0.0, 0.5),
        _ => 0.5 * (d + 1.0).clamp(0.0, 1.0).powi(2),
    };
    let above = if i + 1 == n { d.clamp(0.0, 0.5) } else { 0.5 - 0.5 * (1.0 - d).clamp(0.0, 1.0).powi(2) };
    if d <= 0.0 { below } else { below + above }
}

/// Σ f(value) × weights over the elements of one voxel.
fn weighted_sum(array: &ScalarArray<'_>, [x, y, z]: [&[(usize, f64)]; 3], f: fn(f64) -> f64) -> f64 {
    let mut sum = 0.0;
    for &(i, wx) in x {
        for &(j, wy) in y {
            let along: f64 = z.iter().map(|&(k, wz)| wz * f(array.at(i, j, k))).sum();
            sum += wx * wy * along;
        }
    }
    sum
}
