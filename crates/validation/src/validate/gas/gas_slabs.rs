//! Slabs of real gases: the weighted sum of grey gases of Bordbar et al. (2020) beside RadLib's own, and beside line-by-line spectra.
//!
//! RadLib's solver has been refined until its fluxes change by less than 0.05 %. Q = −dq/dx is compared over the cells of its profiles:
//!
//! ```text
//!     off = √(mean of (Q − Q')²) / max |Q'|
//! ```

use crate::validate::case::{AcceptanceLimit, CaseOutcome, ValidationCase};
use crate::validate::case_context::CaseContext;
use crate::validate::data::table;
use crate::validate::measures::net_flux;
use std::f64::consts::PI;
use zonal_report::Failure;
use zonal_scene::Solution;
use zonal_scene::thermal::blackbody_emissive_power;

/// Layers of each slab, three for each cell of the profiles.
const LAYERS: usize = 300;
const LAYERS_PER_CELL: usize = 3;

/// The models of the cases.
const WEIGHTED_SUM: &str = "wsgg-bordbar-2020";
const SUPERPOSITION: &str = "wsgg-cassol-2014";
/// Flux at the far wall of B3 by superposition, kW/m², of an independent slab code, to its printed digits.
const SUPERPOSITION_FLUX: f64 = 86.0;

/// The cases.
pub(crate) const CASES: [ValidationCase; 1] = [ValidationCase {
    name: "gas-slabs",
    group: "Gases",
    title: "slabs of H2O and CO2 (S1 to S5, B3): RadLib and line-by-line spectra",
    about: "Layers of varying temperature and composition, model wsgg-bordbar-2020. Limits against RadLib's weighted sum of grey gases: 0.2 % of wall fluxes, 0.5 % of the largest source in the root mean square. B3 by superposition (wsgg-cassol-2014): the printed digits of an independent slab code. \
        The difference from line-by-line spectra (digitized from figures) is the error of the model, and informational.",
    quick: true,
    needs: None,
    run,
}];

/// A slab of gas between two walls.
struct GasSlab {
    case: &'static str,
    /// Length, m.
    length: f64,
    /// True with cold walls.
    cold: bool,
}

const SLABS: [GasSlab; 6] = [
    GasSlab { case: "S1", length: 1.5, cold: true },
    GasSlab { case: "S2", length: 1.5, cold: true },
    GasSlab { case: "S3", length: 1.0, cold: false },
    GasSlab { case: "S4", length: 0.3, cold: false },
    GasSlab { case: "S5", length: 2.0, cold: false },
    GasSlab { case: "B3", length: 1.0, cold: false },
];

/// Temperature in K and mole fractions of H2O and CO2 at x, m.
fn state(case: &str, x: f64) -> [f64; 3] {
    let (parabola, sine) = (x * (1.0 - x), (PI * x).sin().powi(2));
    match case {
        "S1" => [if x < 0.5 { 2000.0 } else { 300.0 }, 0.2, 0.1],
        "S2" => [1000.0, 0.0, if x < 0.5 { 0.4 } else { 0.1 }],
        "S3" => [800.0 + 4000.0 * parabola, 0.12 + 0.8 * parabola, 0.0],
        "S4" => [(2500.0 - 2000.0 * (x - 0.15).abs() / 0.05).max(500.0), 0.1, 0.0],
        "S5" => [1000.0 + 500.0 * (0.5 * PI * x).cos(), 0.1, 0.0],
        _ => [400.0 + 1400.0 * sine, 1e-4 + 0.9999 * sine, 0.9999 * (1.0 - sine)],
    }
}

fn solve(bench: &CaseContext, slab: &GasSlab, model: &str) -> Result<Solution, Failure> {
    let &GasSlab { case, length, cold } = slab;
    let step = length / LAYERS as f64;
    let of = |k: usize| {
        let values: Vec<f64> = (0..LAYERS).map(|i| state(case, (i as f64 + 0.5) * step)[k]).collect();
        bench.array(&format!("slab-{case}-{}", ["t", "h2o", "co2"][k]), &[1, 1, LAYERS], &values)
    };
    let [t, h2o, co2] = [of(0)?, of(1)?, of(2)?];
    let wall = |x: f64| if cold { 1e-3 } else { state(case, x)[0] };
    let text = format!(
        "mode = \"thermal\"\nboundary = {{ x = \"periodic\", y = \"periodic\" }}\n[solve]\npatch_rule = \"voxels\"\n[[surface]]\nname = \"w\"\nroom = {{ min = [0, 0, 0], max = [1, 1, {length}] }}\nomit = [\"x0\", \"x1\", \"y0\", \"y1\"]\nemissivity = 1\ntemperature = {:?}\nfaces.z1.temperature = {:?}\n[medium]\nmin = [0, 0, 0]\nmax = [1, 1, {length}]\ncells = [1, 1, {LAYERS}]\ntemperature = {{ file = \"{t}\" }}\ngas = {{ model = \"{model}\", h2o = {{ file = \"{h2o}\" }}, co2 = {{ file = \"{co2}\" }} }}\n",
        wall(0.0),
        wall(length)
    );
    bench.solve(&format!("slab-{case}-{model}"), &text)
}

/// Source −dq/dx of each layer, kW/m³, in the order of x.
fn sources(s: &Solution) -> Vec<f64> {
    let mut out = vec![f64::NAN; LAYERS];
    let net = s.fields.heat.as_ref().map_or(&[][..], |h| &h.net);
    for (k, v) in s.zones.voxels.iter().enumerate() {
        out[v.cell] = -net.get(s.zones.voxel_offset() + k).copied().unwrap_or(f64::NAN) / 1e3;
    }
    out
}

fn run(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    for slab in &SLABS {
        let &GasSlab { case, length, cold } = slab;
        let s = solve(bench, slab, WEIGHTED_SUM)?;
        // Net fluxes that leave the walls, kW/m²; RadLib's are in the direction of x.
        let ours = [net_flux(&s, "z0") / 1e3, -net_flux(&s, "z1") / 1e3];
        for row in table!("radlib_walls.csv")?.rows() {
            let second = row.number("length2")?;
            if row.text("case")? != case || cold && second != length - 0.5 {
                continue;
            }
            for (column, ours) in ["q0", "qL"].into_iter().zip(ours) {
                let q = row.number(column)?;
                let limit = AcceptanceLimit::Relative(2e-3);
                out.check(format!("{case}: {column}, kW/m², RadLib"), q, ours, limit);
            }
        }
        let source = sources(&s);
        profile(&mut out, case, length, &source)?;
        lines(&mut out, slab, &source, ours)?;
    }
    superposition(bench, &mut out)?;
    Ok(out)
}

/// The flux at the far wall of B3 by superposition of the species.
fn superposition(bench: &CaseContext, out: &mut CaseOutcome) -> Result<(), Failure> {
    let s = solve(bench, &SLABS[SLABS.len() - 1], SUPERPOSITION)?;
    let limit = AcceptanceLimit::Absolute(0.05);
    out.check(
        format!("B3: qL, kW/m², {SUPERPOSITION}"),
        SUPERPOSITION_FLUX,
        -net_flux(&s, "z1") / 1e3,
        limit,
    );
    Ok(())
}

/// The source against RadLib's profile, if there is one.
fn profile(out: &mut CaseOutcome, case: &str, length: f64, source: &[f64]) -> Result<(), Failure> {
    let table = table!("radlib_profiles.csv")?;
    let mut flux = Vec::new();
    for row in table.rows() {
        if row.text("case")? == case {
            flux.push(row.number("q")?);
        }
    }
    let cells = flux.len().saturating_sub(1);
    if cells * LAYERS_PER_CELL != LAYERS {
        return Ok(());
    }
    let width = length / cells as f64;
    let of_cell = |i: usize| {
        source[LAYERS_PER_CELL * i..][..LAYERS_PER_CELL].iter().sum::<f64>() / LAYERS_PER_CELL as f64
    };
    let theirs = |i: usize| (flux[i] - flux[i + 1]) / width;
    let square: f64 = (0..cells).map(|i| (of_cell(i) - theirs(i)).powi(2)).sum();
    let largest = (0..cells).map(|i| theirs(i).abs()).fold(0.0, f64::max);
    out.error(
        format!("{case}: source, RMS over its maximum, RadLib"),
        (square / cells as f64).sqrt() / largest,
        5e-3,
    );
    Ok(())
}

/// The difference of the source, kW/m³, and of the fluxes of the walls, kW/m², from line-by-line spectra.
fn lines(out: &mut CaseOutcome, slab: &GasSlab, source: &[f64], walls: [f64; 2]) -> Result<(), Failure> {
    let &GasSlab { case, length, .. } = slab;
    let mut points = Vec::new();
    for row in table!("slabs_lbl.csv")?.rows() {
        if row.text("case")? == case {
            points.push((row.number("x")?, row.number("value")?));
        }
    }
    let step = length / LAYERS as f64;
    match case {
        "S1" | "S2" => {
            let power = blackbody_emissive_power(state(case, 0.0)[0]) / 1e3;
            let nearest = points.iter().min_by(|a, b| (a.0 - 1.0).abs().total_cmp(&(b.0 - 1.0).abs()));
            if let Some((_, value)) = nearest {
                out.informational(
                    format!("{case}: flux at the far wall over σT⁴, line by line"),
                    *value,
                    walls[1] / power,
                );
            }
        }
        "B3" => {
            let end = points.iter().max_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, value)) = end {
                out.informational("B3: flux at the far wall, kW/m², line by line", *value, walls[1]);
            }
        }
        _ => {
            // Linear between the midpoints of layers.
            let at = |x: f64| {
                let place = (x / step - 0.5).clamp(0.0, (LAYERS - 1) as f64);
                let k = (place as usize).min(LAYERS - 2);
                source[k] + (place - k as f64) * (source[k + 1] - source[k])
            };
            let square: f64 = points.iter().map(|(x, q)| (at(*x) - q).powi(2)).sum();
            let largest = points.iter().fold(0.0f64, |m, p| m.max(p.1.abs()));
            let off = (square / points.len().max(1) as f64).sqrt() / largest;
            out.informational(format!("{case}: source, RMS over its maximum, line by line"), 0.0, off);
        }
    }
    Ok(())
}
