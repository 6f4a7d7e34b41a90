//! Power normalization: one factor for each light group and band restores the power balance of a solution by rays.
//!
//! Every ray ends once, so the rows of the exchange matrix close. Its column sums are correct in the mean only, and the iteration stops
//! at a finite residual. The power of a group is therefore not conserved exactly, and no scaling of single zones restores it without
//! an error in some of them. All incident radiation of a group in a band is scaled by
//!
//! ```text
//! f = 1 + (emitted power − absorbed power) / power absorbed from the incident radiation
//! ```
//!
//! which leaves the ratios between zones unchanged. |f − 1| is reported and added to the error of every zone. A factor beyond the
//! tolerance in some band indicates another error; then nothing is changed in any band.

use crate::distribution::sum_order::SharedZones;
use crate::settings::zone_power::absorbed_power;
use zonal_math::parallel;
use zonal_scene::EnergyBalance;
use zonal_scene::{Bands, Zones};

/// Scales the incident radiation of a group (H and G without direct light, W/m²) so that `energy`, the balance computed from it, closes.
/// Returns f − 1 of each band, zero where nothing is changed.
pub(crate) fn normalize_power(
    zones: &Zones,
    energy: &EnergyBalance,
    incident: &mut [Bands],
    tolerance: f64,
) -> Bands {
    let all = absorbed_power(SharedZones::alone(zones), |i| incident[i]);
    let off = energy.residual * (energy.emitted + energy.incoming);
    let change = off.zip_map(all, |off, all| if all > 0.0 { off / all } else { 0.0 });
    // A factor on some bands alone would tint the light.
    if !change.all(|f| f.abs() <= tolerance) {
        return Bands::ZERO;
    }
    parallel::for_each(incident, |_, h| *h *= 1.0 + change);
    change
}
