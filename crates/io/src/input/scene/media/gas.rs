//! A gas model in a filled voxel grid.
//! κ of the bands and their fractions of the emission follow from the composition of each voxel. Surfaces and volumes outside
//! the medium have the fractions of the mean composition; a surface next to the medium those of the voxel in front of it.

use super::voxel_grid::VoxelGridBuilder;
use crate::input::reading::error::InputError;
use crate::input::scene::quantities::gas_composition::{Composition, SceneGas};
use crate::input::scene::scene_reader::SceneReader;
use std::collections::{BTreeSet, HashMap};
use zonal_gas::{GasState, GreyGasFit};
use zonal_scene::{BandFractions, Bands, CellFractions, Diagnostic, SceneError, ThermalCondition};

/// Rounding error of a sum of two values in single precision.
const SINGLE_PRECISION: f64 = 2.0 * f32::EPSILON as f64;

/// The state of a composition. Mole fractions of arrays in single precision may sum to 1 and a rounding error, which is divided out.
fn state_of([h2o, co2, soot, pressure]: Composition) -> GasState {
    let sum = h2o + co2;
    let [h2o, co2] =
        if sum > 1.0 && sum <= 1.0 + SINGLE_PRECISION { [h2o / sum, co2 / sum] } else { [h2o, co2] };
    GasState { h2o, co2, soot, pressure, ..GasState::default() }
}

/// Sets κ of every voxel and the band fractions of the scene by the compositions of the voxels.
pub(crate) fn apply_gas(
    grid: &mut VoxelGridBuilder,
    gas: SceneGas,
    reader: &mut SceneReader<'_>,
) -> Result<(), InputError> {
    let fits = FitTable::new(grid, gas).map_err(|e| reader.source.scene_error(&e))?;
    set_extinction(grid, &fits, reader).map_err(|e| reader.source.scene_error(&e))?;
    let (bands, block) = (reader.parts.bands.clone(), reader.parts.block);
    let fractions = |fit: &GreyGasFit| {
        let weights: Vec<Vec<f64>> = fit.gases.iter().map(|g| g.weight.clone()).collect();
        BandFractions::of_polynomials(&bands, block, &weights, fit.temperature_range)
    };
    let Some(thermal) = &mut reader.parts.thermal else { return Ok(()) };
    thermal.band_fractions = fractions(&fits.mean);
    if fits.kinds.len() > 1 {
        let kinds = fits.kinds.iter().map(fractions).collect();
        thermal.cell_fractions = Some(CellFractions { kinds, kind_of_cell: fits.kind_of_cell });
    }
    for note in &fits.notes {
        reader.note(Diagnostic::warning("gas-range", format!("{}: {note}", gas.model.name())));
    }
    let text = format!(
        "{}: the stated errors do not contain the error of the gas model, which is 5 to 30 % of heat fluxes in comparisons with line-by-line spectra",
        gas.model.name()
    );
    reader.note(Diagnostic::note("gas-model", text));
    if bands.has_solar_band() {
        reader.note(Diagnostic::note("gas-solar", "the gas is transparent to sunlight"));
    }
    Ok(())
}

/// The grey gases of the compositions of a medium.
struct FitTable {
    /// One fit for each composition that occurs.
    kinds: Vec<GreyGasFit>,
    /// The fit of each voxel.
    kind_of_cell: Vec<u32>,
    /// The fit of the mean composition.
    mean: GreyGasFit,
    notes: BTreeSet<String>,
}

impl FitTable {
    fn new(grid: &VoxelGridBuilder, gas: SceneGas) -> Result<FitTable, SceneError> {
        let fit = |c: Composition| {
            let refused = |e: zonal_gas::GasStateError| {
                SceneError::new(format!("medium.gas.{}", e.property()), format!("{e}; change this value"))
            };
            // Superposition has gases of soot only where there is some.
            let c = if gas.has_soot { [c[0], c[1], c[2].max(f64::MIN_POSITIVE), c[3]] } else { c };
            gas.model.fit(&state_of(c)).map_err(refused)
        };
        let mut kind_of: HashMap<[u64; 4], u32> = HashMap::new();
        let (mut kinds, mut kind_of_cell, mut notes) = (Vec::new(), Vec::new(), BTreeSet::new());
        let mut sum = [0.0; 4];
        for c in grid.compositions() {
            sum = [0, 1, 2, 3].map(|k| sum[k] + c[k]);
            let kind = match kind_of.get(&c.map(f64::to_bits)) {
                Some(kind) => *kind,
                None => {
                    let own = fit(c)?;
                    notes.extend(own.notes.iter().cloned());
                    kinds.push(own);
                    kind_of.insert(c.map(f64::to_bits), kinds.len() as u32 - 1);
                    kinds.len() as u32 - 1
                }
            };
            kind_of_cell.push(kind);
        }
        let mean = fit(sum.map(|s| s / kind_of_cell.len().max(1) as f64))?;
        let mean = if let [only] = kinds.as_slice() { only.clone() } else { mean };
        Ok(FitTable { kinds, kind_of_cell, mean, notes })
    }
}

/// Sets κ of every voxel.
fn set_extinction(
    builder: &mut VoxelGridBuilder,
    fits: &FitTable,
    reader: &SceneReader<'_>,
) -> Result<(), SceneError> {
    let bands = &reader.parts.bands;
    let window = bands.window(reader.parts.block);
    let (last, count) = (window.end - 1, bands.infrared_count());
    let grid = &mut builder.grid;
    let cells = if grid.is_uniform() && fits.kinds.len() == 1 { 1 } else { grid.len() };
    for i in 0..cells {
        let fit = &fits.kinds[fits.kind_of_cell[i] as usize];
        let temperature = match grid.heat(i) {
            Some(ThermalCondition::Temperature(t)) => t,
            _ if fit.absorption_depends_on_temperature() => {
                let [x, y, z] = grid.coordinates(i);
                let message = format!(
                    "soot absorbs in proportion to its temperature, which is unknown in cell ({x}, {y}, {z}); give a temperature, or a model without grey soot"
                );
                return Err(SceneError::new("medium.temperature", message));
            }
            _ => 0.0,
        };
        let kappa = |band: usize| {
            if bands.has_solar_band() && band >= count {
                return 0.0;
            }
            let g = &fit.gases[band.min(last).min(count - 1)];
            g.absorption + g.absorption_per_kelvin * temperature
        };
        let extinction = Bands::from_fn(|b| kappa(window.start + b.index()));
        match cells {
            1 => grid.fill(extinction, Bands::ZERO, Bands::ZERO, Bands::ZERO),
            _ => grid.set(i, extinction, Bands::ZERO, Bands::ZERO, Bands::ZERO),
        }
    }
    Ok(())
}
