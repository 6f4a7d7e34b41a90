//! Exchange areas as arrays, and back as the data of thermal states.

use super::fractions::{fractions_json, read_kinds};
use serde_json::{Value, json};
use std::path::Path;
use zonal_io::output::{self, ArrayFile, FileError, NamedArray};
use zonal_scene::{FaceMesh, MAX_BANDS, SceneError, ThermalCondition};
use zonal_solve::areas::exchange_areas::{AreaMatrices, ExchangeAreas};
use zonal_solve::state::{ExchangeData, LightData, SurroundingsData, ZoneFractions};

/// Writes the arrays.
pub(super) fn write(
    path: &Path,
    areas: &ExchangeAreas,
    state: Option<&ExchangeData>,
) -> Result<(), FileError> {
    let (m, n, k) = (areas.matrices, areas.zone_count(), areas.names.len());
    let named = |name, shape, values| NamedArray { name, shape, values };
    // Those of thermal states have closed rows.
    let direct = state.map_or(&areas.direct, |s| &s.direct);
    let mut arrays = vec![
        named("exchange_areas", vec![m, n, n], &direct.areas[..]),
        named("error_radius", vec![m, n, n], &direct.radii),
        named("closure", vec![m, n], &direct.closure),
    ];
    let by_name = areas.total.as_ref().map(|t| [&t.areas, &t.radii].map(|x| areas.by_name(x)));
    if let (Some(total), Some([sums, radii])) = (&areas.total, &by_name) {
        arrays.extend([
            named("total_exchange_areas", vec![m, n, n], &total.areas[..]),
            named("total_error_radius", vec![m, n, n], &total.radii),
            named("total_closure", vec![m, n], &total.closure),
            named("named_exchange_areas", vec![m, k, k], sums),
            named("named_error_radius", vec![m, k, k], radii),
        ]);
    }
    let mut about = header(areas);
    let Some(data) = state else {
        return output::write_arrays(path, Some(&about.to_string()), &arrays);
    };
    about["state"] = state_header(data);
    let conditions: Vec<f64> = data.conditions.iter().flat_map(|c| condition_row(*c)).collect();
    let faces: Vec<f64> = data.face_of_zone.iter().map(|f| f.map_or(-1.0, |f| f as f64)).collect();
    let s = &data.surroundings;
    arrays.extend([
        named("zone_size", vec![n], &data.sizes[..]),
        named("reflectance", vec![data.bands, n], &data.reflectances),
        named("condition", vec![n, 2], &conditions),
        named("zone_face", vec![n], &faces),
        named("surroundings_areas", vec![m, n], &s.areas),
        named("surroundings_radius", vec![m, n], &s.radii),
        named("backface_areas", vec![m, n], &s.backfaces),
        named("closure_scaling", vec![m, n], &s.scaling),
        named("closure_error", vec![m, n], &s.closure_error),
    ]);
    arrays.extend(light_arrays(data));
    let kinds: Vec<f64> = data.band_fractions.kind_of_zone.iter().map(|k| *k as f64).collect();
    if !kinds.is_empty() {
        arrays.push(named("zone_fractions", vec![n], &kinds));
    }
    output::write_arrays(path, Some(&about.to_string()), &arrays)
}

/// Names and units.
fn header(areas: &ExchangeAreas) -> Value {
    json!({
        "names": areas.names, "name_of_zone": areas.name_of_zone, "unit": "m2",
        "order_of_zones": "patches, then voxel zones, then pane zones",
    })
}

/// The arrays of direct light; none without lights.
fn light_arrays(data: &ExchangeData) -> Vec<NamedArray<'_>> {
    let (bands, n, light) = (data.bands, data.zone_count(), &data.light);
    if light.incident.is_empty() {
        return Vec::new();
    }
    let powers = light.powers.len() / bands;
    [
        ("light_incident", n, &light.incident),
        ("light_error", n, &light.error),
        ("light_power", powers, &light.powers),
    ]
    .map(|(name, columns, values)| NamedArray { name, shape: vec![bands, columns], values })
    .into()
}

/// The data of states that are no arrays.
fn state_header(data: &ExchangeData) -> Value {
    let meshes: Vec<Value> =
        data.meshes.iter().map(|m| json!({ "name": m.name, "faces": m.faces })).collect();
    let kinds: Vec<Value> = data.band_fractions.kinds.iter().map(|k| fractions_json(k, data.bands)).collect();
    json!({
        "patches": data.patches, "meshes": meshes, "band_fractions": kinds[0],
        "further_band_fractions": kinds[1..], "solar_band": data.has_solar_band,
        "surroundings_temperature": data.surroundings_temperature,
    })
}

fn condition_row(c: ThermalCondition) -> [f64; 2] {
    match c {
        ThermalCondition::Temperature(t) => [1.0, t],
        ThermalCondition::Flux(q) | ThermalCondition::Power(q) => [2.0, q],
    }
}

/// Reads the data of thermal states.
///
/// # Errors
/// If the file is damaged, or does not hold exchange areas of a scene in thermal mode.
pub fn read_state(path: &Path) -> Result<ExchangeData, FileError> {
    let mut file = ArrayFile::open(path)?;
    if !file.has("closure_scaling") {
        let what = "this file has no data of a scene in thermal mode; write it by zonal exchange from a scene with mode = \"thermal\" without nodes and convection, which only zonal solve knows";
        return Err(file.error("closure_scaling", what));
    }
    let about = file.about()?;
    let wrong = |file: &ArrayFile, key: &str| {
        file.error("about", &format!("'{key}' is damaged; write the exchange areas again"))
    };
    let names = texts(&about["names"]).ok_or_else(|| wrong(&file, "names"))?;
    let name_of_zone = indices(&about["name_of_zone"]).ok_or_else(|| wrong(&file, "name_of_zone"))?;
    let state = &about["state"];
    let meshes = read_meshes(&state["meshes"]).ok_or_else(|| wrong(&file, "meshes"))?;
    let patches = state["patches"].as_u64().ok_or_else(|| wrong(&file, "patches"))?;
    let has_solar_band = state["solar_band"].as_bool().ok_or_else(|| wrong(&file, "solar_band"))?;
    let n = name_of_zone.len();
    let reflectances = file.array("reflectance")?.1;
    let bands = (reflectances.len() / n.max(1)).min(MAX_BANDS);
    let kinds = read_kinds(state, bands).ok_or_else(|| wrong(&file, "band_fractions"))?;
    let (light, kind_of_zone) = read_optional(&mut file)?;
    let mut list = |name: &str| file.array(name).map(|x| x.1);
    let conditions = list("condition")?;
    let data = ExchangeData {
        bands,
        has_solar_band,
        light,
        matrices: list("closure")?.len() / n.max(1),
        patches: usize::try_from(patches).unwrap_or(usize::MAX),
        direct: AreaMatrices {
            areas: list("exchange_areas")?,
            radii: list("error_radius")?,
            closure: list("closure")?,
        },
        surroundings: SurroundingsData {
            areas: list("surroundings_areas")?,
            radii: list("surroundings_radius")?,
            backfaces: list("backface_areas")?,
            scaling: list("closure_scaling")?,
            closure_error: list("closure_error")?,
        },
        sizes: list("zone_size")?,
        reflectances,
        conditions: conditions.chunks(2).map(read_condition).collect(),
        band_fractions: ZoneFractions { kinds, kind_of_zone },
        surroundings_temperature: state["surroundings_temperature"].as_f64(),
        names,
        name_of_zone,
        meshes,
        face_of_zone: list("zone_face")?.iter().map(|f| (*f >= 0.0).then_some(*f as usize)).collect(),
    };
    data.check().map_err(|e: SceneError| file.error(e.key(), e.message()))?;
    Ok(data)
}

/// A condition from its row; a damaged row gives a temperature that is refused.
fn read_condition(row: &[f64]) -> ThermalCondition {
    match row {
        [kind, q] if *kind == 2.0 => ThermalCondition::Flux(*q),
        [kind, t] if *kind == 1.0 => ThermalCondition::Temperature(*t),
        _ => ThermalCondition::Temperature(0.0),
    }
}

/// Largest number of faces that a file may declare.
const MAX_FACES: u64 = 1 << 27;

fn read_meshes(v: &Value) -> Option<Vec<FaceMesh>> {
    let mesh = |m: &Value| {
        let faces = m["faces"].as_u64().filter(|n| *n <= MAX_FACES)?;
        Some(FaceMesh { name: m["name"].as_str()?.to_string(), faces: faces as usize })
    };
    let meshes: Vec<FaceMesh> = v.as_array()?.iter().map(mesh).collect::<Option<_>>()?;
    let all = meshes.iter().fold(0u64, |n, m| n.saturating_add(m.faces as u64));
    (all <= MAX_FACES).then_some(meshes)
}

fn texts(v: &Value) -> Option<Vec<String>> {
    v.as_array()?.iter().map(|x| Some(x.as_str()?.to_string())).collect()
}

fn indices(v: &Value) -> Option<Vec<usize>> {
    v.as_array()?.iter().map(|x| usize::try_from(x.as_u64()?).ok()).collect()
}

/// Direct light, and the kind of band fractions of each zone; empty where the file has none.
fn read_optional(file: &mut ArrayFile) -> Result<(LightData, Vec<usize>), FileError> {
    let has_lights = file.has("light_incident");
    let mut list = |name: &str| if has_lights { file.array(name).map(|x| x.1) } else { Ok(Vec::new()) };
    let light = LightData {
        incident: list("light_incident")?,
        error: list("light_error")?,
        powers: list("light_power")?,
    };
    let kinds = if file.has("zone_fractions") { file.array("zone_fractions")?.1 } else { Vec::new() };
    Ok((light, kinds.into_iter().map(index).collect()))
}

/// An index from a number of an array; one that does not exist for a number that is none.
fn index(x: f64) -> usize {
    if x >= 0.0 && x.fract() == 0.0 { x as usize } else { usize::MAX }
}
