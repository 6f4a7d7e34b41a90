//! Exchange areas as arrays, and back as the data of thermal states.

use serde_json::{Value, json};
use std::path::Path;
use zonal_io::output::{self, ArrayFile, FileError, NamedArray};
use zonal_scene::{Band, BandFractions, Bands, FaceMesh, PerBand, SceneError, ThermalCondition};
use zonal_solve::exchange_areas::{AreaMatrices, ExchangeAreas};
use zonal_solve::state::{ExchangeData, SurroundingsData};

/// Writes the arrays.
pub(super) fn write(
    path: &Path,
    areas: &ExchangeAreas,
    state: Option<&ExchangeData>,
) -> Result<(), FileError> {
    let (m, n, k) = (areas.matrices, areas.zone_count(), areas.names.len());
    let named = |name, shape, values| NamedArray { name, shape, values };
    let direct = &areas.direct;
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
    let mut about = json!({
        "names": areas.names, "name_of_zone": areas.name_of_zone, "unit": "m2",
        "order_of_zones": "patches, then voxel zones, then pane zones",
    });
    let Some(data) = state else {
        return output::write_arrays(path, Some(&about.to_string()), &arrays);
    };
    about["state"] = state_header(data);
    let reflectances: Vec<f64> =
        Band::all().flat_map(|b| data.reflectances.iter().map(move |r| r[b])).collect();
    let conditions: Vec<f64> = data.conditions.iter().flat_map(|c| condition_row(*c)).collect();
    let faces: Vec<f64> = data.face_of_zone.iter().map(|f| f.map_or(-1.0, |f| f as f64)).collect();
    let s = &data.surroundings;
    arrays.extend([
        named("zone_size", vec![n], &data.sizes[..]),
        named("reflectance", vec![Band::count(), n], &reflectances),
        named("condition", vec![n, 2], &conditions),
        named("zone_face", vec![n], &faces),
        named("surroundings_areas", vec![m, n], &s.areas),
        named("surroundings_radius", vec![m, n], &s.radii),
        named("backface_areas", vec![m, n], &s.backfaces),
        named("closure_scaling", vec![m, n], &s.scaling),
        named("closure_error", vec![m, n], &s.closure_error),
    ]);
    output::write_arrays(path, Some(&about.to_string()), &arrays)
}

/// The data of states that are no arrays.
fn state_header(data: &ExchangeData) -> Value {
    let meshes: Vec<Value> =
        data.meshes.iter().map(|m| json!({ "name": m.name, "faces": m.faces })).collect();
    let fractions = match &data.band_fractions {
        BandFractions::Grey => Value::Null,
        BandFractions::BlackBody { limits } => {
            // An infinite limit has no number.
            let lists: Vec<[Option<f64>; 2]> =
                limits.iter().map(|l| l.map(|w| w.is_finite().then_some(w))).collect();
            json!({ "black_body_limits_nm": lists })
        }
        BandFractions::GreyGases { coefficients, range, allow_partial, .. } => {
            let lists: Vec<&Vec<f64>> = coefficients.iter().collect();
            json!({ "coefficients": lists, "range": range, "allow_partial": allow_partial })
        }
    };
    json!({
        "patches": data.patches, "meshes": meshes, "band_fractions": fractions,
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
        let what = "this file has no data of a scene in thermal mode; write it by zonal exchange from a scene with mode = \"thermal\" of up to three bands without nodes, convection and lights";
        return Err(file.error("closure_scaling", what));
    }
    let about = file.about()?;
    let wrong = |file: &ArrayFile, key: &str| {
        file.error("about", &format!("'{key}' is damaged; write the exchange areas again"))
    };
    let texts = |v: &Value| {
        v.as_array()?.iter().map(|x| Some(x.as_str()?.to_string())).collect::<Option<Vec<String>>>()
    };
    let indices = |v: &Value| {
        v.as_array()?.iter().map(|x| usize::try_from(x.as_u64()?).ok()).collect::<Option<Vec<usize>>>()
    };
    let names = texts(&about["names"]).ok_or_else(|| wrong(&file, "names"))?;
    let name_of_zone = indices(&about["name_of_zone"]).ok_or_else(|| wrong(&file, "name_of_zone"))?;
    let state = &about["state"];
    let meshes = read_meshes(&state["meshes"]).ok_or_else(|| wrong(&file, "meshes"))?;
    let band_fractions =
        read_fractions(&state["band_fractions"]).ok_or_else(|| wrong(&file, "band_fractions"))?;
    let patches = state["patches"].as_u64().ok_or_else(|| wrong(&file, "patches"))?;
    let mut list = |name: &str| file.array(name).map(|x| x.1);
    let n = name_of_zone.len();
    let conditions = list("condition")?;
    let reflectance = list("reflectance")?;
    let of_band = |k: usize, i: usize| reflectance.get(k * n + i).copied().unwrap_or(f64::NAN);
    let data = ExchangeData {
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
        reflectances: (0..n).map(|i| Bands::from_fn(|b| of_band(b.index(), i))).collect(),
        conditions: conditions.chunks(2).map(read_condition).collect(),
        band_fractions,
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

fn read_fractions(v: &Value) -> Option<BandFractions> {
    if v.is_null() {
        return Some(BandFractions::Grey);
    }
    let numbers = |v: &Value| v.as_array()?.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>();
    if let Some(limits) = v["black_body_limits_nm"].as_array() {
        let limit = |v: &Value| if v.is_null() { Some(f64::INFINITY) } else { v.as_f64() };
        let of_band = |b: Band| {
            let own = limits.get(b.index())?;
            let [low, high] = [limit(&own[0])?, limit(&own[1])?];
            (0.0 <= low && low <= high).then_some([low, high])
        };
        let limits: Vec<[f64; 2]> = Band::all().map(of_band).collect::<Option<_>>()?;
        return Some(BandFractions::BlackBody { limits: PerBand::from_fn(|b| limits[b.index()]) });
    }
    let lists: Vec<Vec<f64>> = v["coefficients"].as_array()?.iter().map(numbers).collect::<Option<_>>()?;
    if lists.len() != Band::count() {
        return None;
    }
    let range = numbers(&v["range"])?;
    Some(BandFractions::GreyGases {
        all_bands: None,
        coefficients: PerBand::from_fn(|b| lists[b.index()].clone()),
        range: [*range.first()?, *range.get(1)?],
        allow_partial: v["allow_partial"].as_bool()?,
    })
}
