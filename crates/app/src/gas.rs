//! Grey gases and total emissivity of a gas model.

use serde_json::{Value, json};
use zonal_gas::{GasModel, GasState, GreyGasMixture};
use zonal_report::Failure;
use zonal_report::plot::{AxisScale, LegendPlacement, Plot, SeriesMark};

/// Default path lengths of the table, m.
const DEFAULT_LENGTHS: [f64; 13] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0];
/// Path lengths of the plot, m, and its points.
const PLOT_LENGTHS: [f64; 2] = [1e-3, 1e2];
const PLOT_POINTS: usize = 201;
/// Largest number of gases that the plot draws as separate curves.
const MAX_PLOTTED_GASES: usize = 6;
/// Largest path length, m.
const MAX_LENGTH: f64 = 1e9;

/// The grey gases of a state, and the emissivities of uniform paths.
pub struct GasTable {
    /// The model.
    pub model: GasModel,
    /// The state of the gas.
    pub state: GasState,
    /// Its grey gases.
    pub mixture: GreyGasMixture,
    /// Path lengths, m.
    pub lengths: Vec<f64>,
}

impl GasTable {
    /// The table of a model by name; 0.01 to 100 m where no lengths are given.
    ///
    /// # Errors
    /// For unknown models, and for properties and lengths out of range.
    pub fn new(model: &str, state: GasState, mut lengths: Vec<f64>) -> Result<GasTable, Failure> {
        let model = GasModel::from_name(model).ok_or_else(|| unknown_model(model))?;
        if let Some(bad) = lengths.iter().find(|l| !(0.0..=MAX_LENGTH).contains(*l)) {
            return Err(Failure::new(format!("--length: {bad} must be between 0 and {MAX_LENGTH:e} m")));
        }
        if lengths.is_empty() {
            lengths = DEFAULT_LENGTHS.to_vec();
        }
        let mixture = model.evaluate(&state).map_err(|e| Failure::new(format!("--{e}")))?;
        Ok(GasTable { model, state, mixture, lengths })
    }

    /// The table as JSON; no file is written.
    #[must_use]
    pub fn json(&self) -> Value {
        let GasTable { model, state, mixture, lengths } = self;
        let gases: Vec<_> = (mixture.gases.iter())
            .map(|g| json!({ "absorption": g.absorption, "weight": g.weight }))
            .collect();
        let emissivity: Vec<_> =
            (lengths.iter()).map(|&l| json!({ "length": l, "emissivity": mixture.emissivity(l) })).collect();
        json!({
            "model": model.name(), "source": model.source(), "verification": model.verification(),
            "temperature": state.temperature, "pressure": state.pressure,
            "h2o": state.h2o, "co2": state.co2, "soot": state.soot,
            "gases": gases, "planck_mean": mixture.planck_mean(), "emissivity": emissivity,
            "model_error": null, "notes": mixture.notes, "written": null,
        })
    }

    /// Emissivity of the mixture against path length, and the contribution of each gas if they are at most `MAX_PLOTTED_GASES`.
    #[must_use]
    pub fn plot(&self) -> Plot {
        let GasTable { model, state, mixture, .. } = self;
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
        let curve =
            |m: &GreyGasMixture| (0..PLOT_POINTS).map(|i| (length(i), m.emissivity(length(i)))).collect();
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
}

fn unknown_model(name: &str) -> Failure {
    let names: Vec<&str> = GasModel::VARIANTS.iter().map(|m| m.name()).collect();
    Failure::new(format!("'{name}' is not a gas model; the models are {}", names.join(", ")))
}

/// All models with their sources as JSON.
#[must_use]
pub fn models_json() -> Value {
    let model =
        |m: &GasModel| json!({ "name": m.name(), "source": m.source(), "verification": m.verification() });
    GasModel::VARIANTS.iter().map(model).collect()
}
