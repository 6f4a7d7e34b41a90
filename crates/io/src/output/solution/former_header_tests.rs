//! Solution files of format version 5.

use super::tests::{document, folder, replace_entry, thermal_solution};
use super::{read_solution, write_solution};
use crate::output::npz::npy::{ElementType, header};
use std::fs;

/// Renames the fields of a header to those of format version 5.
fn former_names(v: &serde_json::Value) -> serde_json::Value {
    use serde_json::Value;
    const NAMES: [(&str, &str); 10] = [
        ("scattering_orders", "sweeps"),
        ("zone_basis", "thick_zones"),
        ("absorbed_backfaces", "backs"),
        ("absorbed_backfaces_W", "backs_W"),
        ("residual_defect", "after"),
        ("light_groups", "groups"),
        ("band_fractions", "shares"),
        ("allow_partial", "left_out"),
        ("temperature_discretization_error_K", "temperature_zoning_error_K"),
        ("net_power_discretization_error_W", "net_power_zoning_error_W"),
    ];
    // The error without an adjective was that of the exchange.
    let exchange_error = |map: &serde_json::Map<String, Value>, k: &str| {
        let own = match k {
            "temperature_error_K" => "temperature_exchange_error_K",
            "net_power_error_W" => "net_power_exchange_error_W",
            _ => return None,
        };
        map.get(own).cloned()
    };
    match v {
        Value::Object(map) => Value::Object(
            map.iter()
                .filter(|(k, _)| !k.contains("_exchange_error"))
                .map(|(k, x)| {
                    if let Some(error) = exchange_error(map, k) {
                        return (k.clone(), error);
                    }
                    let former = NAMES.iter().find(|n| n.0 == k).map_or(k.as_str(), |n| n.1);
                    let former = match (former, x.is_object()) {
                        ("discretization_error", true) => "zoning",
                        ("discretization_error", false) => "zoning_error",
                        (name, _) => name,
                    };
                    (former.to_string(), former_names(x))
                })
                .collect(),
        ),
        Value::Array(list) => list.iter().map(former_names).collect(),
        Value::String(s) if s == "max_iterations" => "budget".into(),
        Value::String(s) if s == "transport_rays" => "rays of views".into(),
        other => other.clone(),
    }
}

#[test]
fn headers_of_format_version_5_are_read() {
    let dir = folder("former");
    let path = dir.join("a.npz");
    let s = thermal_solution();
    write_solution(&path, &s).unwrap();
    let mut old = former_names(&document(&s));
    old["format_version"] = 5.into();
    old["provenance"]["scene_hash"] = "d228cb696f1a8caf78912b704e4a8964".into();
    let text = old.to_string();
    assert!(text.contains("budget") && text.contains("backs_W") && text.contains("zoning_error_K"), "{text}");
    let entry = [header(ElementType::U8, &[text.len()]), text.into_bytes()].concat();
    replace_entry(&path, "header.json.npy", &entry, zip::CompressionMethod::Stored);
    let back = read_solution(&path).unwrap();
    assert_eq!(format!("{:?}", s.report), format!("{:?}", back.report));
    assert_eq!(format!("{:?}", s.scene), format!("{:?}", back.scene));
    assert_eq!(back.scene_hash, "d228cb696f1a8caf78912b704e4a8964");
    // Both names at once are an error.
    old["options"]["scattering_orders"] = 3.into();
    let text = old.to_string();
    let entry = [header(ElementType::U8, &[text.len()]), text.into_bytes()].concat();
    replace_entry(&path, "header.json.npy", &entry, zip::CompressionMethod::Stored);
    assert!(read_solution(&path).unwrap_err().to_string().contains("duplicate field"));
    fs::remove_dir_all(&dir).unwrap();
}
