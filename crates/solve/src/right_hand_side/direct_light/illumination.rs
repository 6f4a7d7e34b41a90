//! Direct light by shadow rays, normalized to the power of the light.
//!
//! Shadow rays from points of the zones give the fields H_dir and G_dir (`shadow_rays`). Rays from the light give the power that it sends
//! in and loses (`light_power`). With P the power that the zones receive by the fields, P' the power by rays from the light, σ and σ'
//! their standard errors (σ from the independent errors of the zones) and D = P'/P − 1, normalization multiplies the fields by
//!
//! ```text
//! f = 1 + αD,      α = σ²/(σ² + σ'²)
//! ```
//!
//! the mean by inverse variances. It adds the relative error α σ'/P, which all zones have in common. The excess of |D| over
//! 2 √(σ² + σ'²)/P is significant and is added to the common error, with or without normalization.

use super::light_field::{DirectLight, LightField};
use super::light_power::LightPower;
use super::shadow_rays::{GatheredLight, gather};
use crate::distribution::Execution;
use crate::distribution::multivector;
use crate::settings::zone_power::interception_area;
use zonal_scene::{Band, Bands, Scene, Zones};
use zonal_transport::Transport;

/// Relative disagreement with the power of the light above which the fields are not normalized, because the cause is not noise.
const MAX_NORMALIZATION: f64 = 0.12;
/// Number of standard errors above which a disagreement is significant.
const SIGNIFICANT_DEVIATION: f64 = 2.0;

/// Whether fields are normalized to the power of the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PowerNormalization {
    /// Fields are left as gathered.
    None,
    /// Fields are multiplied by f (module header).
    InverseVariance,
}

impl PowerNormalization {
    /// Normalization if the scene restores closure.
    #[must_use]
    pub fn of(scene: &Scene) -> PowerNormalization {
        if scene.restores_closure() { PowerNormalization::InverseVariance } else { PowerNormalization::None }
    }
}

/// Direct light of all lights of a scene.
#[must_use]
pub fn illuminate(
    zones: &Zones,
    transport: &Transport,
    normalization: PowerNormalization,
    execution: Execution,
) -> DirectLight {
    let one = |l: usize| illuminate_by(zones, transport, l, normalization, execution);
    DirectLight { lights: (0..transport.scene().lights().len()).map(one).collect() }
}

/// Direct light of light number `index` of the scene.
pub(crate) fn illuminate_by(
    zones: &Zones,
    transport: &Transport,
    index: usize,
    normalization: PowerNormalization,
    execution: Execution,
) -> LightField {
    let scene = transport.scene();
    let light = &scene.lights()[index];
    let name = light.name(scene.surfaces()).to_string();
    // Sample both sides: shadow rays from the zones, rays from the light.
    let GatheredLight { mut fields, mut error, rays, worst_error, max_samples } =
        gather(zones, transport, light, execution);
    let mut power = LightPower::measure(zones, transport, light);
    // Compare them, and normalize the fields unless they disagree too much.
    let agreement = compare(zones, &fields, &error, &power, normalization);
    let largest = |v: Bands| v.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let off = largest(agreement.significant_difference);
    let disagrees = off > MAX_NORMALIZATION;
    let normalizes = normalization == PowerNormalization::InverseVariance && !disagrees;
    if normalizes {
        let factor = 1.0 + agreement.change;
        for list in [&mut fields, &mut error] {
            list.iter_mut().for_each(|x| *x *= factor);
        }
        power.reconcile(received_power(zones, &fields), light);
    }
    let mut warning = disagrees.then(|| disagreement_text(&name, off));
    let tolerance = scene.options().tolerance;
    if warning.is_none() && worst_error > tolerance {
        warning = Some(sampling_text(&name, worst_error, max_samples, tolerance));
    }
    let (emitted, incoming) =
        if light.is_inside() { (power.sent, Bands::ZERO) } else { (Bands::ZERO, power.sent) };
    LightField {
        name,
        fields,
        error,
        common_error: agreement.common_error,
        rays,
        incoming,
        emitted,
        escaped: power.escaped,
        absorbed_backfaces: power.absorbed_backfaces,
        power_error: power.error,
        largest_change: if normalizes { largest(agreement.change) } else { 0.0 },
        warning,
        ..LightField::default()
    }
}

fn disagreement_text(name: &str, off: f64) -> String {
    format!(
        "light '{name}': the power received by the zones and the power sent by the light differ by {:.0} %; the fields are not normalized. Look for surfaces that coincide",
        100.0 * off
    )
}

fn sampling_text(name: &str, error: f64, samples: usize, tolerance: f64) -> String {
    format!(
        "light '{name}': shadow rays on the zones leave an error of {error:.1e} of its root mean square, more than the tolerance, {tolerance:.1e}; they are limited to {samples} a zone. The stated errors include it; use smaller patches at the edges of its shadows, or a larger tolerance"
    )
}

/// Power received by the zones according to the fields, W.
fn received_power(zones: &Zones, fields: &[Bands]) -> Bands {
    multivector::sum(fields.len(), |i| interception_area(zones, i) * fields[i])
}

/// Comparison of the fields of a light with its power.
#[derive(Clone, Copy, Default)]
struct PowerAgreement {
    /// Relative difference where it is significant, else 0.
    significant_difference: Bands,
    /// Relative change of the fields by normalization.
    change: Bands,
    /// Relative error that all zones have in common after it.
    common_error: Bands,
}

/// Compares fields with their errors to the power of the light; formulas in the module header.
fn compare(
    zones: &Zones,
    fields: &[Bands],
    error: &[Bands],
    power: &LightPower,
    normalization: PowerNormalization,
) -> PowerAgreement {
    let received = received_power(zones, fields);
    let square: Bands =
        multivector::sum(fields.len(), |i| (interception_area(zones, i) * error[i]).map(|e| e.powi(2)));
    let mut out = PowerAgreement::default();
    for b in Band::all() {
        let want = power.sent[b] - power.escaped[b] - power.absorbed_backfaces[b];
        if received[b] <= 0.0 || want <= 0.0 {
            continue;
        }
        let (own, other) = (square[b].sqrt() / received[b], power.received_error[b] / received[b]);
        let off = want / received[b] - 1.0;
        let both = own.hypot(other);
        let weight = if both > 0.0 { (own / both).powi(2) } else { 1.0 };
        out.change[b] = weight * off;
        out.common_error[b] = (off.abs() - SIGNIFICANT_DEVIATION * both).max(0.0);
        if out.common_error[b] > 0.0 {
            out.significant_difference[b] = off;
        }
        if normalization == PowerNormalization::InverseVariance {
            out.common_error[b] += weight * other;
        }
    }
    out
}
