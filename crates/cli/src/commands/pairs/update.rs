//! `zonal update`: fluxes and temperatures of a geometry for other temperatures, powers or emissivities, from the exchange areas of `zonal exchange`.

use crate::commands::context::Context;
use serde_json::json;
use std::path::PathBuf;
use zonal_app::pairs::exchange_areas::read_state;
use zonal_app::pairs::state_update::{Rows, StateChanges, UpdatedState};
use zonal_io::input::Quantity;
use zonal_report::{Failure, check_output, say};
use zonal_scene::printable;

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

/// Runs the command.
///
/// # Errors
/// For tables and exchange areas that are not valid or do not agree, states that are not determined, and outputs that cannot be written.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    check_output(&args.output, &["csv", "npy"])?;
    let tables = [
        (Quantity::Temperature, &args.temperatures),
        (Quantity::NetPower, &args.powers),
        (Quantity::HeatFlux, &args.heat_flux),
        (Quantity::Emissivity, &args.emissivities),
    ];
    let changes = StateChanges {
        tables: tables.into_iter().filter_map(|(q, path)| Some((q, path.clone()?))).collect(),
        column: args.column.clone(),
        rows: args.by,
        surroundings_temperature: args.surroundings_temperature,
    };
    let updated = changes.apply(read_state(&args.factors)?).map_err(|e| e.in_scene(&args.factors))?;
    updated.write(&args.output)?;
    report(args, &updated, context)
}

/// Prints powers and temperatures by name, and the balance.
fn report(args: &Args, updated: &UpdatedState, context: Context) -> Result<(), Failure> {
    const MAX_PRINTED_ROWS: usize = 40;
    let (data, state) = (updated.data(), &updated.state);
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
        return context.say_json(json);
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
