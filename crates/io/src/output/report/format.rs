//! The fields of a report in JSON, described once for writing and reading (serde).

use super::codec::{decode_at, error_bands, grade, residual_lists, unknown_energy_errors};
use super::heat::HeatFormat;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;
use zonal_math::Grade;
use zonal_scene::encoding::nan_bands;
use zonal_scene::{
    Bands, ClosureDefect, Diagnostic, DiscretizationError, EnergyBalance, ErrorEstimate, ErrorParts,
    HeatReport, PerBand, Report, SolveStatus, printable_text,
};

/// The format of a report. The table of heat is added by [`encode_report`], since it includes discretization errors.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Report")]
struct ReportFormat {
    #[serde(deserialize_with = "printable_text")]
    engine: String,
    #[serde(deserialize_with = "printable_text")]
    reason: String,
    status: PerBand<SolveStatus>,
    #[serde(deserialize_with = "residual_lists")]
    residuals: PerBand<Vec<f64>>,
    #[serde(with = "EstimateFormat")]
    estimate: ErrorEstimate,
    #[serde(with = "ClosureFormat")]
    closure: ClosureDefect,
    #[serde(with = "EnergyFormat")]
    energy: EnergyBalance,
    #[serde(with = "energy_errors")]
    energy_error: EnergyBalance,
    #[serde(skip)]
    heat: Option<HeatReport>,
    #[serde(with = "discretization", default)]
    discretization_error: Option<DiscretizationError>,
    #[serde(with = "counts")]
    counts: Vec<(String, u64)>,
    warnings: Vec<Diagnostic>,
    #[serde(with = "grade")]
    grade: Grade,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "ErrorEstimate")]
struct EstimateFormat {
    #[serde(deserialize_with = "error_bands")]
    patches: Bands,
    #[serde(deserialize_with = "error_bands")]
    volumes: Bands,
    #[serde(with = "grade")]
    grade: Grade,
    #[serde(with = "error_parts", default)]
    parts: Option<[ErrorParts; 2]>,
}

/// Parts of an error, infinite if unknown.
#[derive(Serialize, Deserialize)]
#[serde(remote = "ErrorParts")]
struct PartsFormat {
    #[serde(deserialize_with = "super::codec::infinite_if_null")]
    sampling: f64,
    #[serde(deserialize_with = "super::codec::infinite_if_null")]
    radiosities: f64,
    #[serde(deserialize_with = "super::codec::infinite_if_null")]
    direct: f64,
    #[serde(deserialize_with = "super::codec::infinite_if_null")]
    zoning: f64,
    #[serde(deserialize_with = "super::codec::infinite_if_null")]
    zoning_removed: f64,
}

/// The parts of the errors of patches and of volume zones, or null.
mod error_parts {
    use super::*;

    #[derive(Serialize, Deserialize)]
    #[serde(transparent)]
    struct Entry(#[serde(with = "PartsFormat")] ErrorParts);

    pub(super) fn serialize<S: Serializer>(x: &Option<[ErrorParts; 2]>, s: S) -> Result<S::Ok, S::Error> {
        x.map(|kinds| kinds.map(Entry)).serialize(s)
    }
    pub(super) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Option<[ErrorParts; 2]>, D::Error> {
        Ok(Option::<[Entry; 2]>::deserialize(d)?.map(|kinds| kinds.map(|e| e.0)))
    }
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "ClosureDefect")]
struct ClosureFormat {
    #[serde(deserialize_with = "nan_bands")]
    worst: Bands,
    #[serde(deserialize_with = "nan_bands")]
    rms: Bands,
    #[serde(deserialize_with = "nan_bands")]
    largest_change: Bands,
    #[serde(deserialize_with = "nan_bands")]
    residual_defect: Bands,
    restored: bool,
}

/// The format of an energy balance, W.
#[derive(Serialize, Deserialize)]
#[serde(remote = "EnergyBalance")]
pub(crate) struct EnergyFormat {
    #[serde(deserialize_with = "nan_bands")]
    emitted: Bands,
    #[serde(deserialize_with = "nan_bands")]
    incoming: Bands,
    #[serde(with = "named_powers")]
    absorbed_surfaces: Vec<(String, Bands)>,
    #[serde(deserialize_with = "nan_bands")]
    absorbed_volumes: Bands,
    #[serde(deserialize_with = "nan_bands")]
    absorbed_panes: Bands,
    #[serde(deserialize_with = "nan_bands")]
    escaped: Bands,
    #[serde(deserialize_with = "nan_bands")]
    absorbed_backfaces: Bands,
    #[serde(deserialize_with = "nan_bands")]
    residual: Bands,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "DiscretizationError")]
struct DiscretizationFormat {
    zones: usize,
    /// Null without a second solve.
    #[serde(deserialize_with = "super::codec::infinite_if_null")]
    ratio: f64,
    #[serde(skip)]
    heat: Vec<[f64; 2]>,
    #[serde(with = "energy_errors")]
    energy: EnergyBalance,
    notes: Vec<Diagnostic>,
}

/// A discretization error, or null.
mod discretization {
    use super::*;

    #[derive(Serialize, Deserialize)]
    #[serde(transparent)]
    struct Entry(#[serde(with = "DiscretizationFormat")] DiscretizationError);

    pub(super) fn serialize<S: Serializer>(x: &Option<DiscretizationError>, s: S) -> Result<S::Ok, S::Error> {
        x.clone().map(Entry).serialize(s)
    }
    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        d: D,
    ) -> Result<Option<DiscretizationError>, D::Error> {
        Ok(Option::<Entry>::deserialize(d)?.map(|e| e.0))
    }
}

/// Errors of an energy balance, infinite if unknown.
mod energy_errors {
    use super::*;

    pub(super) fn serialize<S: Serializer>(x: &EnergyBalance, s: S) -> Result<S::Ok, S::Error> {
        EnergyFormat::serialize(x, s)
    }
    pub(super) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<EnergyBalance, D::Error> {
        EnergyFormat::deserialize(d).map(unknown_energy_errors)
    }
}

/// Powers by name, as `{name, power}`.
mod named_powers {
    use super::*;

    #[derive(Serialize, Deserialize)]
    struct NamedPower {
        #[serde(deserialize_with = "printable_text")]
        name: String,
        #[serde(deserialize_with = "nan_bands")]
        power: Bands,
    }

    pub(super) fn serialize<S: Serializer>(list: &[(String, Bands)], s: S) -> Result<S::Ok, S::Error> {
        s.collect_seq(list.iter().map(|(name, power)| NamedPower { name: name.clone(), power: *power }))
    }
    pub(super) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Vec<(String, Bands)>, D::Error> {
        let list = Vec::<NamedPower>::deserialize(d)?;
        Ok(list.into_iter().map(|p| (p.name, p.power)).collect())
    }
}

/// Counts by name, as `{name, count}`.
mod counts {
    use super::*;

    #[derive(Serialize, Deserialize)]
    struct NamedCount {
        #[serde(deserialize_with = "printable_text")]
        name: String,
        count: u64,
    }

    pub(super) fn serialize<S: Serializer>(list: &[(String, u64)], s: S) -> Result<S::Ok, S::Error> {
        s.collect_seq(list.iter().map(|(name, count)| NamedCount { name: name.clone(), count: *count }))
    }
    pub(super) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Vec<(String, u64)>, D::Error> {
        let list = Vec::<NamedCount>::deserialize(d)?;
        Ok(list.into_iter().map(|c| (c.name, c.count)).collect())
    }
}

/// A report as [`encode_report`] writes it; an error names the field.
pub(super) fn decode_report(v: &Value) -> Result<Report, String> {
    #[derive(Deserialize)]
    #[serde(transparent)]
    struct Entry(#[serde(with = "ReportFormat")] Report);

    let Entry(mut report) = decode_at("report", v)?;
    if let Some(heat) = decode_at::<Option<HeatFormat>>("report.heat", &v["heat"])? {
        let (table, errors) = heat.into_report();
        report.heat = Some(table);
        if let Some(d) = &mut report.discretization_error {
            d.heat = errors;
        }
    }
    Ok(report)
}

/// A report as JSON.
pub(super) fn encode_report(r: &Report) -> Value {
    // Serialisation into a JSON value fails only for maps with keys that are no texts; there are none.
    let mut v = ReportFormat::serialize(r, serde_json::value::Serializer).unwrap_or_default();
    let heat = r.heat.as_ref().map(|h| HeatFormat::new(h, r.discretization_error.as_ref()));
    v["heat"] = serde_json::to_value(heat).unwrap_or_default();
    for energy in ["energy", "energy_error"] {
        add_unit(&mut v[energy]);
    }
    if r.discretization_error.is_some() {
        v["discretization_error"]["grade"] = Grade::Estimated.name().into();
        add_unit(&mut v["discretization_error"]["energy"]);
    }
    v
}

/// Adds the unit to an energy balance.
pub(super) fn add_unit(energy: &mut Value) {
    energy["unit"] = "W".into();
}
