//! Temperatures and heat by name, as JSON.
//!
//! `report.heat.rows` have `{name, kind, size, temperature_K, temperature_error_K, net_flux, net_flux_error, net_power_W,
//! net_power_error_W}` with `size` in m² of surfaces and m³ of media and panes, and net fluxes per m² or m³; `null` for undefined
//! temperatures. `*_error` is the total error, the sum of `*_exchange_error` (exchange, direct light, solver) and
//! `*_discretization_error` (finite zones): `null` if either is unknown, so also where no second solve estimated the latter, which then is
//! absent. `absorbed_sunlight_W` stands in scenes with sunlight; `emitters_W` is the power of emitters of light, if there are any.

use super::codec::infinite_if_null;
use serde::{Deserialize, Serialize};
use zonal_scene::{DiscretizationError, HeatReport, HeatRow, HeatRowKind, NodeResult, printable_text};

/// The format of the table.
#[derive(Serialize, Deserialize)]
pub(super) struct HeatFormat {
    #[serde(skip_deserializing)]
    temperature_is: &'static str,
    #[serde(skip_deserializing)]
    net_is: &'static str,
    rows: Vec<HeatRowFormat>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    nodes: Vec<NodeFormat>,
    #[serde(rename = "surroundings_W")]
    surroundings: f64,
    #[serde(rename = "absorbed_backfaces_W")]
    absorbed_backfaces: f64,
    #[serde(rename = "emitters_W", default, skip_serializing_if = "is_zero")]
    emitters: f64,
    #[serde(rename = "balance_W", skip_deserializing)]
    balance: f64,
}

fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

/// The format of a node.
#[derive(Serialize, Deserialize)]
struct NodeFormat {
    #[serde(deserialize_with = "printable_text")]
    name: String,
    #[serde(rename = "temperature_K")]
    temperature: Option<f64>,
    #[serde(rename = "temperature_error_K", deserialize_with = "infinite_if_null")]
    temperature_error: f64,
    #[serde(rename = "radiated_W")]
    radiated: f64,
    #[serde(rename = "convected_W")]
    convected: f64,
    #[serde(rename = "conducted_W")]
    conducted: f64,
    #[serde(rename = "supplied_W", skip_deserializing)]
    supplied: f64,
}

impl NodeFormat {
    fn new(n: &NodeResult) -> NodeFormat {
        NodeFormat {
            name: n.name.clone(),
            temperature: n.temperature.is_finite().then_some(n.temperature),
            temperature_error: n.temperature_error,
            radiated: n.radiated,
            convected: n.convected,
            conducted: n.conducted,
            supplied: n.supplied(),
        }
    }
    fn into_node(self) -> NodeResult {
        NodeResult {
            name: self.name,
            temperature: self.temperature.unwrap_or(f64::NAN),
            temperature_error: self.temperature_error,
            radiated: self.radiated,
            convected: self.convected,
            conducted: self.conducted,
        }
    }
}

/// The format of a row. Fields that follow from others are written and not read.
#[derive(Serialize, Deserialize)]
struct HeatRowFormat {
    #[serde(deserialize_with = "printable_text")]
    name: String,
    kind: HeatRowKind,
    size: f64,
    #[serde(skip_deserializing)]
    size_unit: &'static str,
    #[serde(rename = "temperature_K")]
    temperature: Option<f64>,
    #[serde(rename = "temperature_error_K", skip_deserializing)]
    temperature_error: Option<f64>,
    #[serde(rename = "temperature_exchange_error_K")]
    temperature_exchange_error: Option<f64>,
    #[serde(rename = "temperature_discretization_error_K", skip_serializing_if = "Option::is_none")]
    temperature_discretization_error: Option<f64>,
    #[serde(skip_deserializing)]
    net_flux: f64,
    #[serde(skip_deserializing)]
    net_flux_error: f64,
    #[serde(skip_deserializing)]
    net_flux_exchange_error: f64,
    #[serde(skip_deserializing, skip_serializing_if = "Option::is_none")]
    net_flux_discretization_error: Option<f64>,
    #[serde(skip_deserializing)]
    net_flux_unit: &'static str,
    #[serde(rename = "net_power_W")]
    power: f64,
    #[serde(rename = "net_power_error_W", skip_deserializing)]
    power_error: f64,
    #[serde(rename = "net_power_exchange_error_W", deserialize_with = "infinite_if_null")]
    power_exchange_error: f64,
    #[serde(rename = "net_power_discretization_error_W", skip_serializing_if = "Option::is_none")]
    power_discretization_error: Option<f64>,
    #[serde(rename = "absorbed_sunlight_W", default, skip_serializing_if = "Option::is_none")]
    absorbed_sunlight: Option<f64>,
}

impl HeatFormat {
    /// The table of a report; errors of zones that no second solve estimated are unknown.
    pub(super) fn new(r: &HeatReport, discretization: Option<&DiscretizationError>) -> HeatFormat {
        let error_of =
            |i: usize| discretization.map(|d| d.heat.get(i).copied().unwrap_or([f64::INFINITY; 2]));
        HeatFormat {
            temperature_is: "fourth root of the mean of T^4 over area or volume",
            net_is: "net radiative power that leaves",
            rows: r.rows.iter().enumerate().map(|(i, x)| HeatRowFormat::new(x, error_of(i))).collect(),
            nodes: r.nodes.iter().map(NodeFormat::new).collect(),
            surroundings: r.surroundings,
            absorbed_backfaces: r.absorbed_backfaces,
            emitters: r.emitters,
            balance: r.balance(),
        }
    }

    /// The table, and the discretization errors of its rows: temperature in K, NaN without a temperature, and net power in W; infinite
    /// if unknown.
    pub(super) fn into_report(self) -> (HeatReport, Vec<[f64; 2]>) {
        let errors = self.rows.iter().map(HeatRowFormat::discretization_errors).collect();
        let report = HeatReport {
            rows: self.rows.into_iter().map(HeatRowFormat::into_row).collect(),
            nodes: self.nodes.into_iter().map(NodeFormat::into_node).collect(),
            surroundings: self.surroundings,
            absorbed_backfaces: self.absorbed_backfaces,
            emitters: self.emitters,
        };
        (report, errors)
    }
}

impl HeatRowFormat {
    fn new(x: &HeatRow, discretization: Option<[f64; 2]>) -> HeatRowFormat {
        let [net_flux, net_flux_exchange_error] = x.flux();
        let is_surface = x.kind == HeatRowKind::Surface;
        let [temperature_error, net_flux_error, power_error] = x.errors(discretization);
        HeatRowFormat {
            name: x.name.clone(),
            kind: x.kind,
            size: x.size,
            size_unit: if is_surface { "m2" } else { "m3" },
            temperature: x.temperature,
            temperature_error: x.temperature_error.map(|_| temperature_error),
            temperature_exchange_error: x.temperature_error,
            temperature_discretization_error: discretization.map(|d| d[0]),
            net_flux,
            net_flux_error,
            net_flux_exchange_error,
            net_flux_discretization_error: discretization.map(|d| x.over_size(d[1])),
            net_flux_unit: if is_surface { "W/m2" } else { "W/m3" },
            power: x.power,
            power_error,
            power_exchange_error: x.power_error,
            power_discretization_error: discretization.map(|d| d[1]),
            absorbed_sunlight: x.absorbed_sunlight,
        }
    }

    fn discretization_errors(&self) -> [f64; 2] {
        let unknown = if self.temperature.is_none() { f64::NAN } else { f64::INFINITY };
        [
            self.temperature_discretization_error.unwrap_or(unknown),
            self.power_discretization_error.unwrap_or(f64::INFINITY),
        ]
    }

    fn into_row(self) -> HeatRow {
        HeatRow {
            name: self.name,
            kind: self.kind,
            size: self.size,
            temperature: self.temperature,
            temperature_error: self
                .temperature
                .map(|_| self.temperature_exchange_error.unwrap_or(f64::INFINITY)),
            power: self.power,
            power_error: self.power_exchange_error,
            absorbed_sunlight: self.absorbed_sunlight,
        }
    }
}
