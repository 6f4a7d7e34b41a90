//! `zonal update`: fluxes and temperatures of a geometry for other temperatures, powers or emissivities, from the exchange areas of `zonal exchange`.
//!
//! | rows of a table | meaning |
//! |---|---|
//! | by zone | one value for each zone, in the order of the exchange areas; emissivities for each patch |
//! | by face | one value for each face of the meshes, in the order of the mesh files |
//! | by name | a name of a surface, of the medium or of a pane, or its part before a dot or a slash, and a value; other names keep theirs |
//!
//! The output has the rows of the first table: zones, faces, or all names.

use super::exchange::npz::read_state;
use crate::commands::context::Context;
use serde_json::json;
use std::fmt::Write as _;
use std::path::PathBuf;
use zonal_io::input::{Quantity, RowKeys, ValueTable, read_values};
use zonal_io::output;
use zonal_report::{Failure, check_output, say};
use zonal_scene::{ThermalCondition, printable};
use zonal_solve::state::{ExchangeData, StatePart, StateSolver, ThermalState};

/// Compute fluxes and temperatures for other temperatures, powers or emissivities from stored exchange areas.
///
/// The geometry is not computed again: the areas of `zonal exchange` (.npz, of a scene in thermal mode) hold all that is needed. Zones without a new value keep
/// that of the scene.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Exchange areas (.npz) of a scene in thermal mode, written by `zonal exchange`.
    pub factors: PathBuf,
    /// Temperatures, K (.csv, .npy, .vtu, .vtp).
    #[arg(long, value_name = "FILE")]
    pub temperatures: Option<PathBuf>,
    /// Net powers that leave, W: of a zone, a face, or all zones of a name.
    #[arg(long, value_name = "FILE")]
    pub powers: Option<PathBuf>,
    /// Net fluxes that leave, W/m2 (W/m3 of volumes).
    #[arg(long, value_name = "FILE")]
    pub heat_flux: Option<PathBuf>,
    /// Emissivities of surfaces, 0 to 1, in all bands but that of sunlight.
    #[arg(long, value_name = "FILE")]
    pub emissivities: Option<PathBuf>,
    /// Temperature of the surroundings, K.
    #[arg(long, value_name = "K")]
    pub surroundings_temperature: Option<f64>,
    /// Column of the tables by name or number [default: the only one, or the one named like the quantity].
    #[arg(long, value_name = "NAME")]
    pub column: Option<String>,
    /// What the rows of the tables stand for [default: names in the first column, or the number of rows decides].
    #[arg(long, value_name = "ROWS")]
    pub by: Option<Rows>,
    /// Table to write: .csv, or .npy (an array of the columns of numbers).
    #[arg(long, short, value_name = "Q.csv")]
    pub output: PathBuf,
}

/// What the rows of a table stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Rows {
    /// Zones.
    Zone,
    /// Faces of the meshes.
    Face,
    /// Names of surfaces, medium and panes.
    Name,
}

/// Columns of numbers in the output.
const COLUMNS: [&str; 11] = [
    "size",
    "net_power_W",
    "net_power_exchange_error_W",
    "net_flux",
    "net_flux_exchange_error",
    "temperature_K",
    "temperature_exchange_error_K",
    "incident_flux_W_m2",
    "incident_flux_exchange_error_W_m2",
    "radiosity_W_m2",
    "radiosity_exchange_error_W_m2",
];

/// Runs the command.
///
/// # Errors
/// For tables and exchange areas that are not valid or do not agree, states that are not determined, and outputs that cannot be written.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    check_output(&args.output, &["csv", "npy"])?;
    let data = read_state(&args.factors)?;
    let refused = |e: zonal_scene::SceneError| Failure::in_file(&args.factors, e);
    let mut solver = StateSolver::new(data).map_err(refused)?;
    let mut layout = args.by;
    let tables = [
        (&args.temperatures, Quantity::Temperature),
        (&args.powers, Quantity::NetPower),
        (&args.heat_flux, Quantity::HeatFlux),
        (&args.emissivities, Quantity::Emissivity),
    ];
    for (path, quantity) in tables {
        let Some(path) = path else { continue };
        let keys = match args.by {
            Some(Rows::Name) => RowKeys::Name,
            Some(_) => RowKeys::Position,
            None => RowKeys::NameOrPosition,
        };
        let table = read_values(path, args.column.as_deref(), quantity, keys)?;
        let rows = NewValues { table: &table, quantity, by: args.by }.apply(&mut solver)?;
        layout = layout.or(Some(rows));
    }
    if let Some(t) = args.surroundings_temperature {
        solver
            .set_surroundings_temperature(Some(t))
            .map_err(|e| Failure::new(format!("--{}: {}", "surroundings-temperature", e.message())))?;
    }
    let state = solver.solve().map_err(refused)?;
    let table = StateTable::new(solver.data(), &state, layout.unwrap_or(Rows::Name));
    table.write(args)?;
    report(args, solver.data(), &state, context)
}

/// The values of a table.
struct NewValues<'a> {
    table: &'a ValueTable,
    quantity: Quantity,
    by: Option<Rows>,
}

impl NewValues<'_> {
    /// Sets the values; returns what the rows stand for.
    fn apply(&self, solver: &mut StateSolver) -> Result<Rows, Failure> {
        let data = solver.data();
        let (rows, zones_of_row) = match self.table.names() {
            Some(names) => (Rows::Name, self.zones_by_name(names, data)?),
            None => self.zones_by_position(data)?,
        };
        for (row, zones) in zones_of_row.iter().enumerate() {
            let size: f64 = zones.iter().map(|i| solver.data().sizes[*i]).sum();
            for &i in zones {
                self.set(solver, i, self.table.values()[row], size)
                    .map_err(|e| self.table.error(row, e.message()))?;
            }
        }
        Ok(rows)
    }

    /// Sets the value of zone `i` of a row whose zones have the size `size`.
    fn set(
        &self,
        solver: &mut StateSolver,
        i: usize,
        x: f64,
        size: f64,
    ) -> Result<(), zonal_scene::SceneError> {
        match self.quantity {
            Quantity::Temperature => solver.set_condition(i, ThermalCondition::Temperature(x)),
            Quantity::NetPower => solver.set_condition(i, ThermalCondition::Flux(x / size)),
            Quantity::HeatFlux => solver.set_condition(i, ThermalCondition::Flux(x)),
            _ => solver.set_reflectance(i, &[1.0 - x]),
        }
    }

    /// The zones of each row of names.
    fn zones_by_name(&self, names: &[String], data: &ExchangeData) -> Result<Vec<Vec<usize>>, Failure> {
        const MAX_LISTED_NAMES: usize = 24;
        let mut row_of_name: Vec<Option<usize>> = vec![None; data.names.len()];
        for (row, name) in names.iter().enumerate() {
            let belongs = |s: &str| {
                s.strip_prefix(name.as_str()).is_some_and(|r| r.is_empty() || r.starts_with(['.', '/']))
            };
            let mut found = false;
            for (k, own) in data.names.iter().enumerate().filter(|(_, n)| belongs(n)) {
                if row_of_name[k].replace(row).is_some() {
                    return Err(self.table.error(row, &format!("'{own}' has two rows; keep one")).into());
                }
                found = true;
            }
            if !found {
                let known = data.names[..data.names.len().min(MAX_LISTED_NAMES)].join(", ");
                return Err(self
                    .table
                    .error(row, &format!("there is no '{}'; the names are: {known}", printable(name)))
                    .into());
            }
        }
        let mut zones = vec![Vec::new(); names.len()];
        for i in self.zones(data) {
            if let Some(row) = row_of_name[data.name_of_zone[i]] {
                zones[row].push(i);
            }
        }
        Ok(zones)
    }

    /// The zones that can have the quantity: emissivities belong to patches.
    fn zones(&self, data: &ExchangeData) -> std::ops::Range<usize> {
        0..if self.quantity == Quantity::Emissivity { data.patches } else { data.zone_count() }
    }

    /// The zones of each row by position, and whether rows are zones or faces.
    fn zones_by_position(&self, data: &ExchangeData) -> Result<(Rows, Vec<Vec<usize>>), Failure> {
        let (rows, zones, faces) = (self.table.values().len(), self.zones(data), data.face_count());
        let same_order = || (0..zones.len()).all(|i| data.face_of_zone[i] == Some(i));
        let by = match self.by {
            Some(by) => by,
            None if rows == zones.len() && rows == faces && !same_order() => {
                let what = format!(
                    "there are {rows} zones and {rows} faces, in different orders; add --by zone or --by face"
                );
                return Err(self.table.error(0, &what).into());
            }
            None if rows == zones.len() && rows != faces => Rows::Zone,
            None if rows == faces || faces > 0 => Rows::Face,
            None => Rows::Zone,
        };
        let (count, things) = match by {
            Rows::Face => (faces, "faces in the meshes".to_string()),
            _ => (zones.len(), format!("zones (and {faces} faces)")),
        };
        if rows != count {
            return Err(self.table.count_error(count, &things).into());
        }
        if by != Rows::Face {
            return Ok((by, zones.map(|i| vec![i]).collect()));
        }
        let mut of_face = vec![Vec::new(); faces];
        zones.for_each(|i| data.face_of_zone[i].into_iter().for_each(|f| of_face[f].push(i)));
        Ok((by, of_face))
    }
}

/// Rows of the output.
struct StateTable<'a> {
    data: &'a ExchangeData,
    rows: Rows,
    parts: Vec<StatePart>,
}

impl StateTable<'_> {
    fn new<'a>(data: &'a ExchangeData, state: &ThermalState, rows: Rows) -> StateTable<'a> {
        let parts = match rows {
            Rows::Zone => state.sums(&data.sizes, data.zone_count(), Some),
            Rows::Face => state.by_face(data),
            Rows::Name => state.by_name(data),
        };
        StateTable { data, rows, parts }
    }

    fn numbers(part: &StatePart) -> [f64; COLUMNS.len()] {
        let ([p, dp], [q, dq], [t, dt]) = (part.power, part.flux(), part.temperature);
        let ([h, dh], [b, db]) = (part.incident, part.radiosity);
        [part.size, p, dp, q, dq, t, dt, h, dh, b, db]
    }

    fn write(&self, args: &Args) -> Result<(), Failure> {
        if args.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("npy")) {
            let values: Vec<f64> = self.parts.iter().flat_map(Self::numbers).collect();
            return Ok(output::write_array(&args.output, &[self.parts.len(), COLUMNS.len()], &values)?);
        }
        let mut out = String::from(match self.rows {
            Rows::Zone => "zone,name",
            Rows::Face => "mesh,face",
            Rows::Name => "name",
        });
        COLUMNS.iter().for_each(|c| out.extend([",", c]));
        out.push('\n');
        let keys = self.keys();
        for (key, part) in keys.iter().zip(&self.parts) {
            out.push_str(key);
            for x in Self::numbers(part) {
                // A text never fails to grow.
                let _ = if x.is_nan() { write!(out, ",") } else { write!(out, ",{x}") };
            }
            out.push('\n');
        }
        Ok(output::write_bytes(&args.output, out.as_bytes())?)
    }

    /// The first columns of each row.
    fn keys(&self) -> Vec<String> {
        let d = self.data;
        let cell = |name: &str| output::csv_name(name);
        match self.rows {
            Rows::Zone => {
                let names: Vec<String> = d.names.iter().map(|n| cell(n)).collect();
                d.name_of_zone.iter().enumerate().map(|(i, k)| format!("{i},{}", names[*k])).collect()
            }
            Rows::Face => {
                let faces = d.meshes.iter().map(|m| (cell(&m.name), m.faces));
                faces.flat_map(|(name, n)| (0..n).map(move |f| format!("{name},{f}"))).collect()
            }
            Rows::Name => d.names.iter().map(|n| cell(n)).collect(),
        }
    }
}

/// Prints powers and temperatures by name, and the balance.
fn report(args: &Args, data: &ExchangeData, state: &ThermalState, context: Context) -> Result<(), Failure> {
    const MAX_PRINTED_ROWS: usize = 40;
    let parts = state.by_name(data);
    let (path, balance) = (args.output.display().to_string(), state.balance(data));
    if context.json {
        // An unknown number is null.
        let rows: Vec<_> = data
            .names
            .iter()
            .zip(&parts)
            .map(|(name, p)| {
                json!({ "name": name, "size": p.size, "net_power": p.power[0], "net_power_exchange_error": p.power[1],
                    "temperature": p.temperature[0], "temperature_exchange_error": p.temperature[1] })
            })
            .collect();
        let json = json!({
            "zones": data.zone_count(), "parts": rows, "surroundings": state.surroundings,
            "absorbed_backfaces": state.absorbed_backfaces, "emitters": state.emitters, "balance": balance, "written": path,
        });
        return say(&format!("{json:#}"));
    }
    for (name, p) in data.names.iter().zip(&parts).take(MAX_PRINTED_ROWS) {
        let known = |x: f64| if x.is_finite() { format!("{x:.4}") } else { "unknown".into() };
        let ([t, dt], [q, dq]) = (p.temperature, p.power);
        say(&format!(
            "  {:<26} {} ± {} K   {} ± {} W",
            printable(name),
            known(t),
            known(dt),
            known(q),
            known(dq)
        ))?;
    }
    if parts.len() > MAX_PRINTED_ROWS {
        say(&format!("  {} more", parts.len() - MAX_PRINTED_ROWS))?;
    }
    let emitters =
        if state.emitters > 0.0 { format!(", from emitters {:.4} W", state.emitters) } else { String::new() };
    say(&format!(
        "  from the surroundings, less escaped power {:.4} W{emitters}; balance {balance:.1e} W\n{} zones; written: {path}",
        state.surroundings,
        data.zone_count()
    ))
}
