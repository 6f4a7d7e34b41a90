//! `zonal gas`: grey gases and total emissivity of a gas model.

use crate::commands::context::Context;
use std::path::PathBuf;
use zonal_app::gas::{GasTable, models_json};
use zonal_gas::{GasModel, GasState};
use zonal_report::{Failure, check_output, note, say};

/// Print the grey gases of a gas model and the total emissivity against path length.
///
/// Without a model, lists the models with their sources. The emissivity of a uniform path of length L is the sum of a (1 - exp(-kappa L)) over the grey
/// gases. The model's own error is not known and not included.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Name of the model, such as wsgg-bordbar-2020.
    pub model: Option<String>,
    /// Mole fraction of water vapour, 0 to 1.
    #[arg(long, value_name = "X", default_value_t = 0.0)]
    pub h2o: f64,
    /// Mole fraction of carbon dioxide, 0 to 1.
    #[arg(long, value_name = "Y", default_value_t = 0.0)]
    pub co2: f64,
    /// Volume fraction of soot, 0 to 1.
    #[arg(long, value_name = "FV", default_value_t = 0.0)]
    pub soot: f64,
    /// Temperature, K.
    #[arg(long, value_name = "T", default_value_t = 1000.0)]
    pub temperature: f64,
    /// Total pressure, Pa.
    #[arg(long, value_name = "P", default_value_t = 101_325.0)]
    pub pressure: f64,
    /// Path length, m; may be given several times [default: 0.01 to 100].
    #[arg(long, value_name = "L")]
    pub length: Vec<f64>,
    /// Plot to write (.svg).
    #[arg(long, short, value_name = "PLOT.svg")]
    pub output: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// For unknown models, properties out of range, and a plot that cannot be written.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let Some(name) = &args.model else { return list(context) };
    if let Some(path) = &args.output {
        check_output(path, &["svg"])?;
    }
    let state = GasState {
        temperature: args.temperature,
        pressure: args.pressure,
        h2o: args.h2o,
        co2: args.co2,
        soot: args.soot,
    };
    let table = GasTable::new(name, state, args.length.clone())?;
    if let Some(path) = &args.output {
        table.plot().write(path)?;
    }
    let notes = &table.mixture.notes;
    if context.json {
        let mut json = table.json();
        json["written"] = args.output.as_ref().map(|p| p.display().to_string()).into();
        context.say_json(json)?;
    } else {
        say(text(&table, args).trim_end())?;
        notes.iter().for_each(|n| note(n));
    }
    if context.strict && !notes.is_empty() {
        return Err(Failure::verdict("the state is outside the range of the model (--strict)"));
    }
    Ok(())
}

/// Lists the models.
fn list(context: Context) -> Result<(), Failure> {
    if context.json {
        return context.say_json(models_json());
    }
    let line = |m: &GasModel| {
        format!("{:<26}{}\n{:<26}coefficients: {}\n", m.name(), m.source(), "", m.verification())
    };
    say(GasModel::VARIANTS.iter().map(line).collect::<String>().trim_end())
}

fn text(table: &GasTable, args: &Args) -> String {
    let GasTable { model, mixture, lengths, .. } = table;
    let mut out = format!("model {}, {}\n", model.name(), model.source());
    out += "gas    absorption coefficient, 1/m    weight\n";
    for (j, g) in mixture.gases.iter().enumerate() {
        out += &format!("{j:>3}    {:>27.6e}    {:>9.6}\n", g.absorption, g.weight);
    }
    out += &format!("Planck-mean absorption coefficient  {:.6e} 1/m\n", mixture.planck_mean());
    out += "path length, m    total emissivity\n";
    for l in lengths {
        out += &format!("{l:>14}    {:>16.6}\n", mixture.emissivity(*l));
    }
    out += "the error of the model itself is not known\n";
    if let Some(path) = &args.output {
        out += &format!("written: {}\n", path.display());
    }
    out
}
