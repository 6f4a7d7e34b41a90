//! `gas = { model, h2o, co2, soot, pressure }` of a medium or region: a gas model by name.
//!
//! A scene has one model. Its grey gases are the bands. Composition and pressure may vary from voxel to voxel; a voxel that is filled in part takes the
//! mean over its volume. κ of the bands and their fractions of the emission follow from the composition of each voxel. Surfaces and volumes outside
//! the medium have the fractions of the mean composition; a surface next to the medium those of the voxel in front of it.

use super::voxel_grid::VoxelGridBuilder;
use crate::input::error::InputError;
use crate::input::scene_reader::SceneReader;
use crate::input::toml::key_tables::GAS;
use crate::input::toml::node::{TomlNode, TomlTable};
use std::collections::{BTreeSet, HashMap};
use zonal_gas::{GasModel, GasState, GreyGasFit};
use zonal_scene::{BandFractions, Bands, CellFractions, Diagnostic, SceneError, ThermalCondition};

/// The quantities of a composition, in the order of [`Composition`].
pub(super) const GAS_QUANTITIES: [&str; 4] = ["h2o", "co2", "soot", "pressure"];

/// Rounding error of a sum of two values in single precision.
const SINGLE_PRECISION: f64 = 2.0 * f32::EPSILON as f64;

/// Mole fractions of H2O and CO2, volume fraction of soot, and pressure in Pa.
pub(super) type Composition = [f64; 4];

/// The quantities of a composition that a table gives as numbers.
pub(crate) type GasValues = [Option<f64>; 4];

/// The gas model of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SceneGas {
    pub(crate) model: GasModel,
    /// True if some part of the medium has soot.
    pub(crate) has_soot: bool,
}

impl SceneGas {
    /// Number of bands.
    pub(super) fn bands(self) -> usize {
        self.model.gas_count(self.has_soot)
    }
}

/// The gas model of a document: that of the medium and of all its regions; none without a key `gas`.
pub(super) fn find_gas(root: &TomlTable<'_>) -> Result<Option<SceneGas>, InputError> {
    let Some(medium) = root.get("medium").filter(TomlNode::is_table) else { return Ok(None) };
    let medium = medium.any_table()?;
    let mut tables = vec![medium.get("gas")];
    if let Some(regions) = medium.get("region").filter(TomlNode::is_list) {
        for region in regions.list()?.iter().filter(|n| n.is_table()) {
            tables.push(region.any_table()?.get("gas"));
        }
    }
    let mut found: Option<SceneGas> = None;
    for node in tables.into_iter().flatten() {
        let t = node.table(GAS)?;
        let names = GasModel::VARIANTS.map(GasModel::name);
        let model = t.read("model", |n| Ok((GasModel::VARIANTS[n.choice(&names)?], n.offset())))?;
        let has_soot = t.get("soot").is_some_and(|n| n.is_table() || n.number().is_ok_and(|x| x != 0.0));
        match (&mut found, model) {
            (None, Some((model, _))) => found = Some(SceneGas { model, has_soot }),
            (None, None) => {
                t.require("model", "model = \"wsgg-bordbar-2020\"")?;
            }
            (Some(gas), Some((model, _))) if model != gas.model => {
                let message = format!(
                    "a scene has one gas model, and this one differs from {}; give the same",
                    gas.model.name()
                );
                return Err(t.get("model").map_or_else(|| t.error(&message), |n| n.error(&message)));
            }
            (Some(gas), _) => gas.has_soot |= has_soot,
        }
    }
    Ok(found)
}

/// The numbers of the key `gas` of a table of the medium; none without the key.
pub(super) fn read_gas_values(t: &TomlTable<'_>) -> Result<Option<GasValues>, InputError> {
    let Some(node) = t.get("gas") else { return Ok(None) };
    let gas = node.table(GAS)?;
    if let Some(n) = ["extinction", "absorption", "albedo", "density"].iter().find_map(|k| t.get(k)) {
        return Err(n.error("the gas gives the absorption, and nothing scatters; remove this key or the gas"));
    }
    let mut out = [None; 4];
    for (value, key) in out.iter_mut().zip(GAS_QUANTITIES) {
        let Some(n) = gas.get(key).filter(|n| !n.is_table()) else { continue };
        let x = n.number()?;
        check_quantity(key, x).map_err(|message| n.error(message))?;
        *value = Some(x);
    }
    Ok(Some(out))
}

/// Refuses a value that no composition has.
fn check_quantity(key: &str, x: f64) -> Result<(), String> {
    let valid = if key == "pressure" { x > 0.0 } else { (0.0..=1.0).contains(&x) };
    let wanted = if key == "pressure" { "pascals above 0" } else { "a fraction from 0 to 1" };
    if valid { Ok(()) } else { Err(format!("{x} is out of range; give {wanted}")) }
}

/// The composition of a voxel before anything fills it: no absorbing gas at one atmosphere.
pub(super) fn no_gas() -> Composition {
    [0.0, 0.0, 0.0, GasState::default().pressure]
}

/// The state of a composition. Mole fractions of arrays in single precision may sum to 1 and a rounding error, which is divided out.
fn state_of([h2o, co2, soot, pressure]: Composition) -> GasState {
    let sum = h2o + co2;
    let [h2o, co2] =
        if sum > 1.0 && sum <= 1.0 + SINGLE_PRECISION { [h2o / sum, co2 / sum] } else { [h2o, co2] };
    GasState { h2o, co2, soot, pressure, ..GasState::default() }
}

/// Sets κ of every voxel and the band fractions of the scene by the compositions of the voxels.
pub(super) fn apply_gas(
    grid: &mut VoxelGridBuilder,
    gas: SceneGas,
    reader: &mut SceneReader<'_>,
) -> Result<(), InputError> {
    let fits = FitTable::new(grid, gas).map_err(|e| reader.source.scene_error(&e))?;
    set_extinction(grid, &fits, reader).map_err(|e| reader.source.scene_error(&e))?;
    let (bands, triple) = (reader.parts.bands.clone(), reader.parts.triple);
    let fractions = |fit: &GreyGasFit| {
        let weights: Vec<Vec<f64>> = fit.gases.iter().map(|g| g.weight.clone()).collect();
        BandFractions::of_polynomials(&bands, triple, &weights, fit.temperature_range)
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
    let window = reader.parts.bands.window(reader.parts.triple);
    let last = window.end - 1;
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
            let g = &fit.gases[band.min(last)];
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
