//! Thermal mode in JSON: what is known of a scene, and what its solution reports.
//!
//! `thermal`: `{shares, surfaces, panes, surroundings}`, each known value `{temperature: K}`, `{heat: W/m² or W/m³}` or `{net_power: W}`.
//! `report.heat`: rows `{name, kind, size, temperature_K, temperature_error_K, net_flux, net_flux_error, net_power_W, net_power_error_W}` with
//! `size` in m² of surfaces and m³ of media and panes, and net fluxes per m² or m³; `null` where no temperature is defined. `*_error` is of the
//! exchange; where a second solve was asked for, `temperature_zoning_error_K`, `net_flux_zoning_error` and
//! `net_power_zoning_error_W` say it, `null` where it is unknown. `temperature_total_error_K`, `net_flux_total_error` and `net_power_total_error_W` are
//! both together: what a value is known to; `null` where either is unknown or nobody asked for the errors of the zones.

use super::header::each;
use super::report::{list, real, text};
use serde_json::{Value, json};
use zonal_scene::{HeatKind, HeatReport, HeatRow, Known, Scene, Shares, Thermal, Zoning};

/// What is known of a scene; null in light mode.
pub(super) fn thermal_out(scene: &Scene) -> Value {
    let Some(t) = scene.thermal() else { return Value::Null };
    let shares = match &t.shares {
        Shares::Grey => Value::Null,
        Shares::Weights { coefficients, range, left_out } => {
            json!({"coefficients": coefficients, "range": range, "left_out": left_out})
        }
    };
    let all = |k: &[Known]| k.iter().map(known_out).collect::<Vec<_>>();
    json!({
        "shares": shares, "surfaces": all(&t.surfaces), "panes": all(&t.panes), "surroundings": t.surroundings,
    })
}

fn known_out(k: &Known) -> Value {
    match k {
        Known::Temperature(t) => json!({"temperature": t}),
        Known::Flux(q) => json!({"heat": q}),
        Known::Power(p) => json!({"net_power": p}),
    }
}

/// What [`thermal_out`] wrote at the key `thermal`.
pub(super) fn thermal_in(h: &Value) -> Result<Option<Thermal>, String> {
    let v = &h["thermal"];
    if v.is_null() {
        return Ok(None);
    }
    let number = |v: &Value| v.as_f64().ok_or("thermal: a number is missing".to_string());
    let reals = |v: &Value| -> Result<Vec<f64>, String> {
        v.as_array().ok_or("thermal: a list is missing")?.iter().map(number).collect()
    };
    let shares = match &v["shares"] {
        Value::Null => Shares::Grey,
        s => {
            let c = list(s, "coefficients")?.iter().map(reals).collect::<Result<Vec<_>, _>>()?;
            let range = reals(&s["range"])?;
            Shares::Weights {
                coefficients: c.try_into().map_err(|_| "thermal: there must be three bands")?,
                range: range.try_into().map_err(|_| "thermal: a range has two ends")?,
                left_out: s["left_out"].as_bool().unwrap_or(false),
            }
        }
    };
    Ok(Some(Thermal {
        shares,
        surfaces: each(v, "surfaces", known_in)?,
        panes: each(v, "panes", known_in)?,
        surroundings: if v["surroundings"].is_null() { None } else { Some(real(v, "surroundings")?) },
    }))
}

fn known_in(v: &Value) -> Result<Known, String> {
    let of = |key: &str| v[key].as_f64();
    match (of("temperature"), of("heat"), of("net_power")) {
        (Some(t), ..) => Ok(Known::Temperature(t)),
        (_, Some(q), _) => Ok(Known::Flux(q)),
        (.., Some(p)) => Ok(Known::Power(p)),
        _ => Err("neither temperature nor heat is given".into()),
    }
}

/// The table by name; null in light mode.
pub(super) fn report_out(r: Option<&HeatReport>, zoning: Option<&Zoning>) -> Value {
    let Some(r) = r else { return Value::Null };
    let row = |(i, x): (usize, &HeatRow)| {
        let [flux, error] = x.flux();
        let unit = if x.kind == HeatKind::Surface { ["m2", "W/m2"] } else { ["m3", "W/m3"] };
        let mut out = json!({
            "name": x.name, "kind": x.kind.word(), "size": x.size, "size_unit": unit[0],
            "temperature_K": x.temperature, "temperature_error_K": x.temperature_error,
            "net_flux": flux, "net_flux_error": error, "net_flux_unit": unit[1],
            "net_power_W": x.power, "net_power_error_W": x.power_error,
        });
        let [mut kelvin, mut watts] = [f64::INFINITY; 2];
        if let Some(zoning) = zoning {
            [kelvin, watts] = zoning.heat.get(i).copied().unwrap_or([f64::INFINITY; 2]);
            out["temperature_zoning_error_K"] = json!(kelvin);
            out["net_flux_zoning_error"] = json!(x.over_size(watts));
            out["net_power_zoning_error_W"] = json!(watts);
        }
        let watts = x.power_error + watts;
        out["temperature_total_error_K"] = json!(x.temperature_error.map(|e| e + kelvin));
        out["net_flux_total_error"] = json!(if watts.is_finite() { x.over_size(watts) } else { watts });
        out["net_power_total_error_W"] = json!(watts);
        out
    };
    json!({
        "temperature_is": "fourth root of the mean of T^4 over area or volume",
        "net_is": "given: positive where heat leaves",
        "rows": r.rows.iter().enumerate().map(row).collect::<Vec<_>>(),
        "surroundings_W": r.surroundings, "backs_W": r.backs, "balance_W": r.balance(),
    })
}

/// What [`report_out`] wrote.
pub(super) fn report_in(v: &Value) -> Result<Option<HeatReport>, String> {
    if v.is_null() {
        return Ok(None);
    }
    let maybe = |x: &Value, key: &str| x[key].as_f64();
    let row = |x: &Value| -> Result<HeatRow, String> {
        let kind = text(x, "kind")?;
        Ok(HeatRow {
            name: text(x, "name")?,
            kind: *HeatKind::ALL.iter().find(|k| k.word() == kind).ok_or("kind: is not known")?,
            size: real(x, "size")?,
            temperature: maybe(x, "temperature_K"),
            temperature_error: maybe(x, "temperature_K")
                .map(|_| maybe(x, "temperature_error_K").unwrap_or(f64::INFINITY)),
            power: real(x, "net_power_W")?,
            power_error: maybe(x, "net_power_error_W").unwrap_or(f64::INFINITY),
        })
    };
    Ok(Some(HeatReport {
        rows: each(v, "rows", row)?,
        surroundings: real(v, "surroundings_W")?,
        backs: real(v, "backs_W")?,
    }))
}

/// The errors of zones that [`report_out`] wrote, infinite where they are unknown and not a number where there is no temperature; empty in
/// light mode.
pub(super) fn zoning_in(v: &Value) -> Result<Vec<[f64; 2]>, String> {
    if v.is_null() {
        return Ok(Vec::new());
    }
    let row = |x: &Value| {
        let none = if x["temperature_K"].is_null() { f64::NAN } else { f64::INFINITY };
        let kelvin = x["temperature_zoning_error_K"].as_f64().unwrap_or(none);
        Ok([kelvin, x["net_power_zoning_error_W"].as_f64().unwrap_or(f64::INFINITY)])
    };
    each(v, "rows", row)
}
