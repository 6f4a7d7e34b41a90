//! Optically thick zones: gain by linear basis functions inside zones (`zone_basis = "linear"`).

use super::montecarlo::{TABLES_FOLDER, spectral};
use crate::validate::box_scene::BoxScene;
use crate::validate::case::{AcceptanceLimit, CaseOutcome, ValidationCase};
use crate::validate::case_context::CaseContext;
use crate::validate::data::table;
use crate::validate::exact::cube::{CONSTANT_BASIS, LINEAR_BASIS, fluxes, solve};
use crate::validate::measures::WallMeans;
use crate::validate::richardson::ResolutionSequence;
use zonal_report::Failure;

const CASE_GROUP: &str = "Thick zones";

/// The cases.
pub(crate) const CASES: [ValidationCase; 3] = [
    ValidationCase {
        name: "thick-cube",
        group: CASE_GROUP,
        title: "cube in radiative equilibrium, optical depth 10, with slopes",
        about: "The hot wall's net flux against 0.4483(1) of section 7: with slopes at most 0.7 % off at 21³ and 2 % at 9³ (one radiosity a zone: 3.7 % and 14.5 %). At all depths of section 7 slopes may not be farther from the \
            extrapolated value than none, beyond its bracket.",
        quick: false,
        needs: None,
        run: cube,
    },
    ValidationCase {
        name: "thick-slab",
        group: CASE_GROUP,
        title: "slabs in radiative equilibrium, cells of up to ten optical depths, with slopes",
        about: "Ψ of section 5 for τ = 10 on 12 to 96 cells: 10⁻⁴ at 48 and extrapolated. And the diffusion limit: τ = 50 in 5 cells of ten optical depths each, where one radiosity a cell is of no use; limit 2 %.",
        quick: true,
        needs: None,
        run: slab,
    },
    ValidationCase {
        name: "thick-tables",
        group: CASE_GROUP,
        title: "Monte Carlo tables with slopes",
        about: "c5 (κL = 5): at 40³ RMS of H and G at most 0.4 %, the table's noise left in, and the error at 20³ cut at least threefold. No other table gets worse: the ratio of the errors at 10³ without and with slopes is \
            at least 0.98, since what is left is noise.",
        quick: false,
        needs: Some(TABLES_FOLDER),
        run: tables,
    },
];

fn cube(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let (mut steps, mut without) = (Vec::new(), Vec::new());
    for row in table!("cube.csv")?.rows() {
        let (tau, exact, bracket) = (row.number("tau")?, row.number("hot")?, row.number("bracket")?);
        for n in [5, 9, 13, 21, 32] {
            let hot = |settings| Ok::<f64, Failure>(fluxes(&solve(bench, tau, n, settings)?)[0]);
            let (sloped, plain) = (hot(LINEAR_BASIS)?, hot(CONSTANT_BASIS)?);
            if tau == 10.0 {
                let limit = match n {
                    9 => AcceptanceLimit::Relative(0.02),
                    21 => AcceptanceLimit::Relative(0.007),
                    _ => AcceptanceLimit::None,
                };
                out.check(format!("τ = 10, {n}³, slopes: q_hot"), exact, sloped, limit);
                out.informational(format!("τ = 10, {n}³, none: q_hot"), exact, plain);
                steps.push((n as f64, sloped));
                without.push((n as f64, plain));
            }
            let worse = (sloped - exact).abs() - (plain - exact).abs();
            out.error(format!("τ = {tau}, {n}³: by how much slopes are worse"), worse.max(0.0), bracket);
        }
    }
    let limit = Some((0.4483, 1e-4));
    out.sequences.push(ResolutionSequence::new("τ = 10: q_hot, slopes", steps, limit));
    out.sequences.push(ResolutionSequence::new("τ = 10: q_hot, none", without, limit));
    Ok(out)
}

fn psi(bench: &CaseContext, tau: f64, n: usize, settings: &str) -> Result<f64, Failure> {
    let name = format!("thick-slab-{tau}-{n}-{}", if settings == LINEAR_BASIS { "slopes" } else { "none" });
    let room = BoxScene::layer(tau, n)
        .medium("albedo = 1")
        .wall(4, 0.0, 1.0)
        .solve(&format!("engine = \"spectral\"\n{settings}"));
    Ok(WallMeans::of(&bench.solve(&name, &room.text(&name))?, "z0").net())
}

fn slab(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let exact = 0.11674511;
    let (mut steps, mut without) = (Vec::new(), Vec::new());
    for n in [6, 12, 24, 48, 96] {
        let sloped = psi(bench, 10.0, n, LINEAR_BASIS)?;
        let limit = if n == 48 { AcceptanceLimit::Absolute(1e-4) } else { AcceptanceLimit::None };
        out.check(format!("τ = 10, {n} cells, slopes: Ψ"), exact, sloped, limit);
        let plain = psi(bench, 10.0, n, CONSTANT_BASIS)?;
        out.informational(format!("τ = 10, {n} cells, none: Ψ"), exact, plain);
        steps.push((n as f64, sloped));
        without.push((n as f64, plain));
    }
    let sequence = ResolutionSequence::new("τ = 10: Ψ, slopes", steps, Some((exact, 5e-9)));
    out.check("τ = 10, slopes, extrapolated: Ψ", exact, sequence.value(), AcceptanceLimit::Absolute(1e-4));
    out.sequences.push(sequence);
    out.sequences.push(ResolutionSequence::new("τ = 10: Ψ, none", without, Some((exact, 5e-9))));
    let diffusion = crate::validate::exact::laws::diffusion(50.0);
    out.check(
        "τ = 50, 5 cells, slopes: Ψ",
        diffusion,
        psi(bench, 50.0, 5, LINEAR_BASIS)?,
        AcceptanceLimit::Relative(0.02),
    );
    out.informational("τ = 50, 5 cells, none: Ψ", diffusion, psi(bench, 50.0, 5, CONSTANT_BASIS)?);
    Ok(out)
}

fn tables(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let errors = |name: &str, n: usize, settings: &str| -> Result<[f64; 2], Failure> {
        let (_, d) = spectral(bench, name, n, settings)?;
        Ok([d.h.all.0, d.g.all.0])
    };
    for (what, e) in ["H", "G"].into_iter().zip(errors("c5", 40, LINEAR_BASIS)?) {
        out.error(format!("c5, 40³, slopes: {what}, RMS of the relative difference"), e, 0.4e-2);
    }
    let (sloped, plain) = (errors("c5", 20, LINEAR_BASIS)?, errors("c5", 20, CONSTANT_BASIS)?);
    for (k, what) in ["H", "G"].into_iter().enumerate() {
        out.informational(format!("c5, 20³, slopes: {what}, RMS of the relative difference"), 0.0, sloped[k]);
        out.informational(format!("c5, 20³, none: {what}, RMS of the relative difference"), 0.0, plain[k]);
        out.check(
            format!("c5, 20³: {what}, error without over error with slopes"),
            0.0,
            plain[k] / sloped[k],
            AcceptanceLimit::AtLeast(3.0),
        );
    }
    for name in ["c0", "c1", "c3", "c10"] {
        let (sloped, plain) = (errors(name, 10, LINEAR_BASIS)?, errors(name, 10, CONSTANT_BASIS)?);
        for (k, what) in ["H", "G"].into_iter().enumerate() {
            let ratio = plain[k] / sloped[k];
            out.check(
                format!("{name}, 10³: {what}, error without over error with slopes"),
                0.0,
                ratio,
                AcceptanceLimit::AtLeast(0.98),
            );
        }
    }
    Ok(out)
}
