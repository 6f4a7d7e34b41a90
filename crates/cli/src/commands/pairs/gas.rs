//! `zonal gas`: grey gases and total emissivity of a gas model.

use crate::commands::context::Context;
use std::path::PathBuf;
use zonal_gas::{GasModel, GasState, GasStateError, GreyGasMixture};
use zonal_report::plot::{AxisScale, LegendPlacement, Plot, SeriesMark};
use zonal_report::{Failure, check_output, note, say};

/// Default path lengths of the table, m.
const DEFAULT_LENGTHS: [f64; 13] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0];
/// Path lengths of the plot, m, and its points.
const PLOT_LENGTHS: [f64; 2] = [1e-3, 1e2];
const PLOT_POINTS: usize = 201;
/// Largest number of gases that the plot draws as separate curves.
const MAX_PLOTTED_GASES: usize = 6;
/// Largest path length, m.
const MAX_LENGTH: f64 = 1e9;

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
    let (model, state, mixture, lengths) = evaluate(name, args)?;
    if let Some(path) = &args.output {
        emissivity_plot(model, &state, &mixture).write(path)?;
    }
    if context.json {
        say(&format!("{:#}", json(model, &state, &mixture, &lengths, args)))?;
    } else {
        say(text(model, &mixture, &lengths, args).trim_end())?;
        mixture.notes.iter().for_each(|n| note(n));
    }
    match context.strict && !mixture.notes.is_empty() {
        true => Err(Failure::verdict("the state is outside the range of the model (--strict)")),
        false => Ok(()),
    }
}

/// The JSON report of the command, without a plot.
///
/// # Errors
/// As [`run`].
pub fn report(args: &Args) -> Result<serde_json::Value, Failure> {
    let Some(name) = &args.model else { return Ok(list_json()) };
    let (model, state, mixture, lengths) = evaluate(name, args)?;
    Ok(json(model, &state, &mixture, &lengths, args))
}

/// The model, the state of the gas, its grey gases, and the path lengths.
#[allow(clippy::type_complexity)]
fn evaluate(name: &str, args: &Args) -> Result<(GasModel, GasState, GreyGasMixture, Vec<f64>), Failure> {
    let model = GasModel::from_name(name).ok_or_else(|| unknown_model(name))?;
    if let Some(path) = &args.output {
        check_output(path, &["svg"])?;
    }
    if let Some(bad) = args.length.iter().find(|l| !(0.0..=MAX_LENGTH).contains(*l)) {
        return Err(Failure::new(format!("--length: {bad} must be between 0 and {MAX_LENGTH:e} m")));
    }
    let state = GasState {
        temperature: args.temperature,
        pressure: args.pressure,
        h2o: args.h2o,
        co2: args.co2,
        soot: args.soot,
    };
    let mixture = model.evaluate(&state).map_err(out_of_range)?;
    let lengths = if args.length.is_empty() { DEFAULT_LENGTHS.to_vec() } else { args.length.clone() };
    Ok((model, state, mixture, lengths))
}

fn unknown_model(name: &str) -> Failure {
    let names: Vec<&str> = GasModel::VARIANTS.iter().map(|m| m.name()).collect();
    Failure::new(format!("'{name}' is not a gas model; the models are {}", names.join(", ")))
}

fn out_of_range(error: GasStateError) -> Failure {
    Failure::new(format!("--{error}"))
}

/// Lists the models.
fn list(context: Context) -> Result<(), Failure> {
    if context.json {
        return say(&format!("{:#}", list_json()));
    }
    let line = |m: &GasModel| {
        format!("{:<26}{}\n{:<26}coefficients: {}\n", m.name(), m.source(), "", m.verification())
    };
    say(GasModel::VARIANTS.iter().map(line).collect::<String>().trim_end())
}

fn list_json() -> serde_json::Value {
    let model = |m: &GasModel| serde_json::json!({ "name": m.name(), "source": m.source(), "verification": m.verification() });
    GasModel::VARIANTS.iter().map(model).collect()
}

fn text(model: GasModel, mixture: &GreyGasMixture, lengths: &[f64], args: &Args) -> String {
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

fn json(
    model: GasModel,
    state: &GasState,
    mixture: &GreyGasMixture,
    lengths: &[f64],
    args: &Args,
) -> serde_json::Value {
    let gases: Vec<_> = (mixture.gases.iter())
        .map(|g| serde_json::json!({ "absorption": g.absorption, "weight": g.weight }))
        .collect();
    let emissivity: Vec<_> = (lengths.iter())
        .map(|&l| serde_json::json!({ "length": l, "emissivity": mixture.emissivity(l) }))
        .collect();
    serde_json::json!({
        "model": model.name(),
        "source": model.source(),
        "verification": model.verification(),
        "temperature": state.temperature,
        "pressure": state.pressure,
        "h2o": state.h2o,
        "co2": state.co2,
        "soot": state.soot,
        "gases": gases,
        "planck_mean": mixture.planck_mean(),
        "emissivity": emissivity,
        "model_error": null,
        "notes": mixture.notes,
        "written": args.output.as_ref().map(|p| p.display().to_string()),
    })
}

/// Emissivity of the mixture against path length, and the contribution of each gas if they are at most [`MAX_PLOTTED_GASES`].
fn emissivity_plot(model: GasModel, state: &GasState, mixture: &GreyGasMixture) -> Plot {
    let soot = if state.soot > 0.0 { format!(", soot {:e}", state.soot) } else { String::new() };
    let title = format!(
        "{}: {} K, {} Pa, H2O {}, CO2 {}{soot}",
        model.name(),
        state.temperature,
        state.pressure,
        state.h2o,
        state.co2
    );
    let [first, last] = PLOT_LENGTHS;
    let length = |i: usize| first * (last / first).powf(i as f64 / (PLOT_POINTS - 1) as f64);
    let curve = |m: &GreyGasMixture| (0..PLOT_POINTS).map(|i| (length(i), m.emissivity(length(i)))).collect();
    let scales = [AxisScale::Logarithmic, AxisScale::Linear];
    let mut plot = Plot::new(&title, "path length, m", "total emissivity", scales);
    plot.legend = LegendPlacement::Beside;
    plot.add("mixture", SeriesMark::Line, 0, curve(mixture));
    let absorbing: Vec<_> = mixture.gases.iter().filter(|g| g.absorption > 0.0).collect();
    if absorbing.len() <= MAX_PLOTTED_GASES {
        for (k, gas) in absorbing.into_iter().enumerate() {
            let alone = GreyGasMixture { gases: vec![*gas], notes: Vec::new() };
            plot.add(
                &format!("grey gas, κ = {:.3} 1/m", gas.absorption),
                SeriesMark::Dashed,
                k + 1,
                curve(&alone),
            );
        }
    }
    plot
}
