//! Section 11: a weighted sum of grey gases.

use crate::validate::box_scene::BoxScene;
use crate::validate::case::{AcceptanceLimit, CaseOutcome, ValidationCase};
use crate::validate::case_context::CaseContext;
use crate::validate::data::table;
use zonal_math::exponential_integral::e3;
use zonal_report::Failure;

/// The cases.
pub(crate) const CASES: [ValidationCase; 1] = [ValidationCase {
    name: "wsgg",
    group: "11 Weighted sum of grey gases",
    title: "weights of Smith, Shen and Friedman (1982), and a layer of three gases",
    about: "Weights must not be negative, nor their sum above 1, between 600 and 2400 K. An isothermal layer of 1 m of the mixture at 1 atm cm and at 0.1 atm m: its three gases are the three bands of one solve, \
        whose fluxes must add up to Σ aᵢ(T)(1 − 2E₃(kᵢpL)) σT⁴, limit 10⁻⁹.",
    quick: true,
    needs: None,
    run,
}];

fn run(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let table = table!("wsgg.csv")?;
    let mut gases = Vec::new();
    for row in table.rows() {
        let b = [row.number("b0")?, row.number("b1")?, row.number("b2")?, row.number("b3")?];
        gases.push((row.number("kappa")?, b));
    }
    let weights = |t: f64| -> Vec<f64> {
        gases.iter().map(|(_, b)| b[0] + t * (b[1] + t * (b[2] + t * b[3]))).collect()
    };
    let (mut least, mut most) = (f64::INFINITY, 0.0f64);
    for k in 0..=180 {
        let w = weights(600.0 + 10.0 * k as f64);
        least = w.iter().fold(least, |m, x| m.min(*x));
        most = most.max(w.iter().sum());
    }
    out.error("weights below 0, 600 to 2400 K", (-least).max(0.0), 0.0);
    out.error("sum of the weights above 1", (most - 1.0).max(0.0), 0.0);
    for (pressure, t) in [(0.01, 1000.0), (0.1, 1000.0), (0.1, 2000.0)] {
        let w = weights(t);
        let kappa: Vec<f64> = gases.iter().map(|g| g.0 * pressure).collect();
        let name = format!("wsgg-{pressure}-{t}");
        let room = BoxScene::layer(0.0, 4)
            .medium(&format!("extinction = {kappa:?}\nemission = {w:?}"))
            .solve("engine = \"spectral\"");
        let s = bench.solve(&name, &room.text(&name))?;
        let wall = s.zones.patches.iter().position(|p| s.scene.surfaces()[p.surface].name.ends_with("z0"));
        let ours: f64 = wall.map_or(f64::NAN, |i| s.fields.incident[i].sum());
        let exact: f64 = w.iter().zip(&kappa).map(|(a, k)| a * (1.0 - 2.0 * e3(*k))).sum();
        out.check(
            format!("p = {pressure} atm, {t} K: emissivity of the layer"),
            exact,
            ours,
            AcceptanceLimit::Relative(1e-9),
        );
    }
    Ok(out)
}
