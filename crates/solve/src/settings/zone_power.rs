//! Powers of single zones: what a zone intercepts, absorbs and reflects of the incident field, and the coefficients of the zonal equations.
//!
//! The incident field is the irradiance H of a patch or the fluence G of a volume zone, W/m².

use crate::distribution::sum_order::SharedZones;
use zonal_exchange::pair::{closure_target, scaled_radiosity_coefficient};
use zonal_math::parallel;
use zonal_scene::{Bands, Zones};

/// Intercepted power of zone `i` per unit incident field, m² per band: the area of a patch, κV of a volume zone.
pub(crate) fn interception_area(zones: &Zones, i: usize) -> Bands {
    let measure = zones.response(i).1;
    scaled_radiosity_coefficient(zones, i) * measure
}

/// Absorbed power of zone `i` per unit incident field, m² per band: (1 − ρ − τ) A of a patch, κ (1 − Ω) V of a volume zone.
pub(crate) fn absorption_area(zones: &Zones, i: usize) -> Bands {
    let (intercepted, reflected) = (interception_area(zones, i), reflected_fraction(zones, i));
    (1.0 - reflected) * intercepted
}

/// Fraction of the intercepted power of zone `i` that is not absorbed: ρ + τ of a patch, Ω of a volume zone, whose response is Ω/4.
pub(crate) fn reflected_fraction(zones: &Zones, i: usize) -> Bands {
    fluence_factor(zones, i) * zones.response(i).0 + zones.sheets.transmittance(i)
}

/// Incident field over radiosity in a cavity without losses: H = B of patches, G = 4 B of volume zones.
pub(crate) fn fluence_factor(zones: &Zones, i: usize) -> f64 {
    if i < zones.patches.len() { 1.0 } else { 4.0 }
}

/// Absorbed power of all zones for an incident field (W/m²), W per band.
pub(crate) fn absorbed_power(zones: SharedZones, field: impl Fn(usize) -> Bands + Sync) -> Bands {
    zones.sum(|i| {
        let (a, h) = (absorption_area(&zones, i), field(i));
        // A zone without absorption contributes nothing, also where its field is infinite.
        a.zip_map(h, |a, h| if a == 0.0 { 0.0 } else { a * h })
    })
}

/// Closure targets t of all zones: A of a patch (m²), 4V of a volume zone (m³).
pub(crate) fn closure_targets(zones: &Zones) -> Vec<f64> {
    parallel::collect(zones.len(), |i| closure_target(zones, i))
}

/// Weights w of all zones in s = s⁰ + w g s: c ρ/A of a patch, (ρ + τ)/A of the side of a transmitting sheet ([`crate::operator::mixed_sides`]), c Ω/(4V) of a volume zone, with s = c B the scaled radiosity, s⁰ its emitted
/// part, g the exchange factors, and c = 1 for a patch, κ for a volume zone.
pub(crate) fn reflection_weights(zones: &Zones) -> Vec<Bands> {
    let one = |i: usize| {
        let (c, (rho, measure)) = (scaled_radiosity_coefficient(zones, i), zones.response(i));
        c * (rho + zones.sheets.transmittance(i)) / measure
    };
    parallel::collect(zones.len(), one)
}
