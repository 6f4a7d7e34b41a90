//! Emissivities by temperature, and those of the back of a surface with two sides.

use super::thermal::{SceneMode, read_reflectance, read_solar};
use crate::files::FileSource;
use crate::input::reading::error::InputError;
use crate::input::scene::quantities::surface_properties::BackProperties;
use crate::input::scene::scene_reader::SceneReader;
use crate::input::tables::{ColumnFile, Quantity, RowKeys, WantedColumn};
use crate::input::toml::node::{TomlNode, TomlTable};
use crate::input::toml::surface_keys::SURFACE_PROPERTIES;
use crate::input::toml::thermal_keys::{
    BACK, Back, EMISSIVITY_BY_TEMPERATURE as BY_TEMPERATURE, EmissivityByTemperature,
};
use std::path::Path;
use std::rc::Rc;
use zonal_scene::{Bands, EmissivityTable};

/// The `emissivity` of a table, if it depends on temperature: its index among the tables of the reader.
pub(crate) fn read_emissivity_table(
    t: &TomlTable<'_>,
    reader: &mut SceneReader<'_>,
) -> Result<Option<usize>, InputError> {
    let Some(node) = t.get(&SURFACE_PROPERTIES.emissivity).filter(TomlNode::is_by_temperature) else {
        return Ok(None);
    };
    if reader.mode() == SceneMode::Light {
        return Err(node.error(
            "an emissivity by temperature belongs to thermal mode; write mode = \"thermal\" at the top of the file, or give numbers",
        ));
    }
    if t.get(&SURFACE_PROPERTIES.reflectance).is_some() {
        return Err(node.error("emissivity and reflectance are both given, and sum to 1; keep one of them"));
    }
    let own = node.table(EmissivityByTemperature::TABLE)?;
    let points = match own.get(&BY_TEMPERATURE.by_temperature) {
        Some(file) => {
            if let Some(n) = own.get(&BY_TEMPERATURE.temperatures).or(own.get(&BY_TEMPERATURE.values)) {
                return Err(n.error("a file and lists are both given; keep one of them"));
            }
            points_of_file(&file, &own, reader)?
        }
        None => points_of_lists(&own)?,
    };
    let table = EmissivityTable::new(&points).map_err(|e| node.error(e.message().to_string()))?;
    reader.emissivity_tables.push(table);
    Ok(Some(reader.emissivity_tables.len() - 1))
}

fn points_of_lists(own: &TomlTable<'_>) -> Result<Vec<[f64; 2]>, InputError> {
    if let Some(n) = own.get(&BY_TEMPERATURE.column) {
        return Err(n.error("columns are of files; give by_temperature, or remove this key"));
    }
    let temperatures = own.required(&BY_TEMPERATURE.temperatures)?;
    let values = own.required(&BY_TEMPERATURE.values)?;
    if temperatures.len() != values.len() {
        let (rows, found) = (temperatures.len(), values.len());
        return Err(own.error(format!("{rows} temperatures have {found} values; give one for each")));
    }
    Ok(temperatures.into_iter().zip(values).map(|(t, e)| [t, e]).collect())
}

fn points_of_file(
    file: &TomlNode<'_>,
    own: &TomlTable<'_>,
    reader: &SceneReader<'_>,
) -> Result<Vec<[f64; 2]>, InputError> {
    let (path, _) = file.named_file()?;
    let points = file.once(|| read_points(file, own, &path, reader.context.files))?;
    Ok(Rc::unwrap_or_clone(points))
}

/// Temperatures (K) and emissivities of a file.
fn read_points(
    file: &TomlNode<'_>,
    own: &TomlTable<'_>,
    path: &Path,
    files: FileSource<'_>,
) -> Result<Vec<[f64; 2]>, InputError> {
    let name = path.display().to_string();
    let table = ColumnFile::read(files, path, &name).map_err(|f| file.error(f.to_string()))?;
    let read = |column: &str, quantity: Quantity| {
        table.column(WantedColumn { column: Some(column), quantity, rows: RowKeys::Position })
    };
    let values = own.or_default(&BY_TEMPERATURE.column)?;
    let temperatures = read("1", Quantity::Temperature).map_err(|f| file.error(f.to_string()))?;
    let emissivities = read(&values, Quantity::Emissivity);
    let emissivities = emissivities
        .map_err(|f| own.get(&BY_TEMPERATURE.column).as_ref().unwrap_or(file).error(f.to_string()))?;
    Ok(temperatures.values().iter().zip(emissivities.values()).map(|(t, e)| [*t, *e]).collect())
}

/// Reflectances that stand for a table: those at `kelvin`, or in the middle of the table; NaN in the band of sunlight.
pub(crate) fn representative(reader: &SceneReader<'_>, table: usize, kelvin: Option<f64>) -> Bands {
    let table = &reader.emissivity_tables[table];
    let points = table.points();
    let middle = 0.5 * (points[0][0] + points[points.len() - 1][0]);
    let own = Bands::splat(1.0 - table.at(kelvin.unwrap_or(middle)));
    reader.parts.bands.with_solar_value(reader.parts.block, own, f64::NAN)
}

/// The `back` of a surface's table.
pub(crate) fn read_back(
    t: &TomlTable<'_>,
    reader: &mut SceneReader<'_>,
) -> Result<Option<BackProperties>, InputError> {
    let Some(node) = t.get(&SURFACE_PROPERTIES.back) else { return Ok(None) };
    let own = node.table(Back::TABLE)?;
    let emissivity = own.require(&BACK.emissivity)?;
    if emissivity.is_value_file() {
        return Err(emissivity.error("the back has no values by face; give a number"));
    }
    let table = read_emissivity_table(&own, reader)?;
    let given = match table {
        Some(k) => Some(representative(reader, k, None)),
        None => read_reflectance(&own)?,
    };
    let mut reflectance = given.unwrap_or(Bands::ZERO);
    if let Some(a) = read_solar(&own, &BACK.solar_absorptance)? {
        reflectance = reader.parts.bands.with_solar_value(reader.parts.block, reflectance, 1.0 - a);
    }
    if reflectance.any(f64::is_nan) {
        return Err(own
            .error("the emissivity in the infrared has no value for sunlight; add solar_absorptance = 0.3"));
    }
    Ok(Some(BackProperties { reflectance, table }))
}
