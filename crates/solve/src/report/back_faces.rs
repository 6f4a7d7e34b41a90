//! Power on the black, cold backs of one-sided surfaces in heat mode, by surface.
//!
//! The total is measured with the surroundings. The backs that receive it follow from rays: a cosine-distributed ray from a back meets the radiosity B of a
//! zone or of the surroundings, so that the surface receives about A · mean B. The medium between is left out; these powers are shares of the total alone.

use zonal_math::direction_sampling::cosine_hemisphere;
use zonal_math::low_discrepancy::{r2, sobol_2d};
use zonal_scene::{Bands, Diagnostic, Fields, HeatReport, Report, Sides, Zones};
use zonal_transport::Transport;
use zonal_transport::patch_locator::facet_side_locator;

/// Lost power over the exchanged power above which it is reported.
const MAX_LOST_SHARE: f64 = 1e-3;
/// Number of rays in all, and the least and the most of one facet.
const RAYS: usize = 1 << 15;
const RAYS_PER_FACET: [usize; 2] = [1, 1024];
/// Start of a ray over the diagonal of the scene.
const RAY_START: f64 = 1e-9;
/// Maximum number of surfaces in the diagnostic, and the smallest share of one.
const MAX_NAMES: usize = 4;
const MIN_SHARE: f64 = 0.02;

/// The diagnostic of power on backs beyond its stated error; none in light mode.
pub(crate) fn lost_on_backs(
    zones: &Zones,
    transport: &Transport,
    fields: &Fields,
    report: &Report,
) -> Option<Diagnostic> {
    let heat = report.heat.as_ref()?;
    let (lost, error) = (heat.absorbed_backfaces, report.energy_error.absorbed_backfaces.sum());
    if lost <= MAX_LOST_SHARE * exchanged_power(heat) || lost <= error {
        return None;
    }
    let received = received_by_backs(zones, transport, fields);
    let all: f64 = received.iter().sum();
    let mut names: Vec<(f64, &str)> = received
        .iter()
        .zip(transport.scene().surfaces())
        .filter(|(w, _)| **w > MIN_SHARE * all)
        .map(|(w, s)| (w / all, s.name.as_str()))
        .collect();
    names.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(b.1)));
    let more = names.len().saturating_sub(MAX_NAMES);
    names.truncate(MAX_NAMES);
    let mut listed: Vec<String> =
        names.iter().map(|(share, name)| format!("{name} (about {:.3} W)", share * lost)).collect();
    listed.extend((more > 0).then(|| format!("{more} more")));
    let at = if listed.is_empty() { String::new() } else { format!(": {}", listed.join(", ")) };
    let text = format!(
        "{lost:.4} W end on the backs of one-sided surfaces, which are black and have 0 K{at}; give these surfaces sides = \"both\", or close the gaps before their backs"
    );
    Some(Diagnostic::warning("black-backs", text))
}

/// The larger of the powers given and taken by the parts and the surroundings, W.
fn exchanged_power(heat: &HeatReport) -> f64 {
    let powers = heat.rows.iter().map(|r| r.power).chain([heat.surroundings, -heat.absorbed_backfaces]);
    let [given, taken] = powers.fold([0.0f64; 2], |[g, t], q| [g + q.max(0.0), t - q.min(0.0)]);
    given.max(taken)
}

/// Power on the backs of each surface without that of the medium, W.
fn received_by_backs(zones: &Zones, transport: &Transport, fields: &Fields) -> Vec<f64> {
    let scene = transport.scene();
    let patches = facet_side_locator(scene, zones);
    let sky = scene.surroundings().radiosity();
    let has_back = |s: usize| scene.surfaces()[s].sides == Sides::Front && !scene.surfaces()[s].solid;
    let facets = scene.facets();
    let [least, most] = RAYS_PER_FACET;
    let rays = (RAYS / facets.len().max(1)).clamp(least, most);
    let length = scene.diagonal();
    let mut out = vec![0.0; scene.surfaces().len()];
    for (number, f) in facets.iter().enumerate().filter(|(_, f)| has_back(f.surface)) {
        let normal = f.plate.normal();
        let mut sum = Bands::ZERO;
        for k in number * rays..(number + 1) * rays {
            let [u, v] = f.plate.warp(r2(k, [0.0; 2]));
            let dir = cosine_hemisphere(-normal, sobol_2d(k as u32, [0, 0]));
            let hit = transport.closest_hit(f.plate.at(u, v), dir, RAY_START * length, f64::INFINITY);
            sum += match hit {
                None => sky,
                Some(h) => {
                    patches.locate(h.side(), [h.u, h.v]).map_or(Bands::ZERO, |p| fields.radiosity[p as usize])
                }
            };
        }
        out[f.surface] += f.plate.area() * sum.sum() / rays as f64;
    }
    out
}
