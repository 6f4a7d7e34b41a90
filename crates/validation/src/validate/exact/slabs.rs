//! Section 5: layers between plates, periodic along x and y.

use super::factors::{STEFAN_BOLTZMANN, printed_limit};
use crate::validate::box_scene::BoxScene;
use crate::validate::case::{AcceptanceLimit, CaseOutcome, ValidationCase};
use crate::validate::case_context::CaseContext;
use crate::validate::data::table;
use crate::validate::measures::{WallMeans, net_flux, voxel_temperature};
use crate::validate::richardson::ResolutionSequence;
use zonal_report::Failure;

/// Absolute limit of Ψ.
const FLUX_TOLERANCE: f64 = 1e-4;
/// Layers of the sequences.
const RESOLUTIONS: [usize; 5] = [12, 24, 48, 96, 192];

/// The cases.
pub(crate) const CASES: [ValidationCase; 2] = [
    ValidationCase {
        name: "layer",
        group: "5 Slabs",
        title: "isothermal layer between cold black walls",
        about: "1 − 2E₃(τ), from one cell and from ten: a sum of exact exchange areas, hence to all printed digits. Limit: 10⁻⁹ relative, or half a unit of the last printed place where that is \
            more. FDS's own figures for its case radiation_plane_layer and for its two-flux model stand below for information.",
        quick: true,
        needs: None,
        run: layer,
    },
    ValidationCase {
        name: "equilibrium-slab",
        group: "5 Slabs",
        title: "radiative equilibrium between plates",
        about: "Thermal mode: walls of 1000 K and 500 K, a medium without heat source; Ψ = q/σ(T₁⁴ − T₂⁴). Radiosity is constant in each of the layer's cells, so the flux converges as the \
            cells shrink: its value on the finest grid and the extrapolated one are both held to 10⁻⁴ absolute. As a second way a layer that scatters all and absorbs nothing, light mode, which must give \
            the same. Grey plates by Ψ = Ψ_b/[1 + Ψ_b(1/ε₁ + 1/ε₂ − 2)].",
        quick: false,
        needs: None,
        run: equilibrium,
    },
];

fn layer(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    for row in table!("layer.csv")?.rows() {
        let (tau, p) = (row.number("tau")?, row.printed("emissivity")?);
        let mut ours = 0.0;
        for n in [1, 10] {
            let name = format!("layer-{tau}-{n}");
            let room = BoxScene::layer(tau, n).medium("emission = 1").solve("engine = \"spectral\"");
            ours = WallMeans::of(&bench.solve(&name, &room.text(&name))?, "z0").incident;
            out.check(format!("τ = {tau}, {n} cell(s): q/σT⁴"), p.value, ours, printed_limit(p));
        }
        let exact = 1.0 - 2.0 * zonal_math::exponential_integral::e3(tau);
        out.check(format!("τ = {tau}: against 1 − 2E₃"), exact, ours, AcceptanceLimit::Relative(1e-9));
        let Some(watts) = row.optional("watts")? else { continue };
        // Their constant, 5.67e-8.
        let flux = 5.67e-8 * 1273.15f64.powi(4) / 1e3 * ours;
        out.check(
            format!("τ = {tau}: kW/m² at 1273.15 K"),
            watts.value,
            flux,
            AcceptanceLimit::Absolute(watts.half),
        );
        for (column, what) in [
            ("fds3d", "FDS 3-D, 20 angles"),
            ("fds6", "FDS, 6 bands"),
            ("fds2d", "FDS 2-D"),
            ("fds150", "FDS, 150 angles"),
            ("twoflux", "FDS, two-flux"),
        ] {
            if let Some(p) = row.optional(column)? {
                out.informational(format!("τ = {tau}: {what}, kW/m²"), p.value, flux);
            }
        }
    }
    Ok(out)
}

/// Temperatures of the hot and of the cold wall, K.
const HOT_WALL_KELVIN: f64 = 1000.0;
const COLD_WALL_KELVIN: f64 = 500.0;

/// Net flux of the hot wall over σ(T₁⁴ − T₂⁴) for walls of these emissivities, and (T⁴ − T₂⁴)/(T₁⁴ − T₂⁴) in the middle.
fn psi(bench: &CaseContext, tau: f64, n: usize, emissivity: [f64; 2]) -> Result<[f64; 2], Failure> {
    let name = format!("equilibrium-slab-{tau}-{n}-{}-{}", emissivity[0], emissivity[1]);
    let room = BoxScene::layer(tau, n)
        .warm(1.0, COLD_WALL_KELVIN)
        .wall(4, emissivity[0], HOT_WALL_KELVIN)
        .wall(5, emissivity[1], COLD_WALL_KELVIN)
        .medium("heat_source = 0")
        .solve(&format!("engine = \"spectral\"\n{}", super::cube::CONSTANT_BASIS));
    let s = bench.solve(&name, &room.text(&name))?;
    let drop = HOT_WALL_KELVIN.powi(4) - COLD_WALL_KELVIN.powi(4);
    let middle = |k: usize| (voxel_temperature(&s, [0, 0, k]).powi(4) - COLD_WALL_KELVIN.powi(4)) / drop;
    Ok([net_flux(&s, "z0") / (STEFAN_BOLTZMANN * drop), 0.5 * (middle(n / 2) + middle((n - 1) / 2))])
}

/// Net flux of the hot wall of the same layer between black walls as one that scatters all.
fn analogue(bench: &CaseContext, tau: f64, n: usize) -> Result<f64, Failure> {
    let name = format!("scattering-slab-{tau}-{n}");
    let room = BoxScene::layer(tau, n)
        .medium("albedo = 1")
        .wall(4, 0.0, 1.0)
        .solve(&format!("engine = \"spectral\"\n{}", super::cube::CONSTANT_BASIS));
    Ok(WallMeans::of(&bench.solve(&name, &room.text(&name))?, "z0").net())
}

/// Compares the layer with one that scatters all, and with layers between grey walls, by Ψ as printed and with the finest cells.
fn compare_variants(
    bench: &CaseContext,
    out: &mut CaseOutcome,
    tau: f64,
    printed: f64,
    finest: f64,
) -> Result<(), Failure> {
    let other = analogue(bench, tau, 192)?;
    out.error(
        format!("τ = {tau}: the layer as one that scatters all, difference of Ψ"),
        other - finest,
        1e-9,
    );
    for (e1, e2) in [(0.8, 0.5), (0.2, 0.9)] {
        let grey = printed / (1.0 + printed * (1.0 / e1 + 1.0 / e2 - 2.0));
        let [flux, _] = psi(bench, tau, 192, [e1, e2])?;
        out.check(
            format!("τ = {tau}, ε = {e1}, {e2}: Ψ"),
            grey,
            flux,
            AcceptanceLimit::Absolute(FLUX_TOLERANCE),
        );
    }
    Ok(())
}

fn equilibrium(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    for row in table!("equilibrium.csv")?.rows() {
        let (tau, p) = (row.number("tau")?, row.printed("value")?);
        let mut steps = Vec::new();
        let mut middle = 0.0;
        for n in RESOLUTIONS {
            let [flux, source] = psi(bench, tau, n, [1.0; 2])?;
            steps.push((n as f64, flux));
            middle = source;
        }
        let finest = steps.last().map_or(f64::NAN, |s| s.1);
        let sequence = ResolutionSequence::new(format!("τ = {tau}: Ψ"), steps, Some((p.value, p.half)));
        out.check(
            format!("τ = {tau}, 192 cells: Ψ"),
            p.value,
            finest,
            AcceptanceLimit::Absolute(FLUX_TOLERANCE),
        );
        out.check(
            format!("τ = {tau}, extrapolated: Ψ"),
            p.value,
            sequence.value(),
            AcceptanceLimit::Absolute(FLUX_TOLERANCE),
        );
        out.check(
            format!("τ = {tau}: T⁴ in the middle, of the walls'"),
            0.5,
            middle,
            AcceptanceLimit::Absolute(1e-9),
        );
        if [0.1, 1.0, 10.0].contains(&tau) {
            compare_variants(bench, &mut out, tau, p.value, finest)?;
        }
        out.sequences.push(sequence);
    }
    Ok(out)
}
