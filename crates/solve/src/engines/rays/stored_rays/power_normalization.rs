//! The power balance of a solution by rays, and its normalization: one factor for each light group and band.
//!
//! Every ray ends once, so the rows of the exchange matrix close. Its column sums are correct in the mean only, and the iteration stops
//! at a finite residual. The power of a group is therefore not conserved exactly, and no scaling of single zones restores it without
//! an error in some of them. All incident radiation of a group in a band would have to be scaled by
//!
//! ```text
//! f = 1 + (emitted power − absorbed power) / power absorbed from the incident radiation
//! ```
//!
//! which leaves the ratios between zones unchanged. |f − 1| is added to the error of every zone, whether it is scaled or not: in white rooms, which repeat
//! it at every reflection, it is the error that all zones have in common. A factor beyond the tolerance in some band indicates another error; then nothing is
//! scaled in any band.

use crate::distribution::sum_order::SharedZones;
use crate::settings::zone_power::absorbed_power;
use zonal_math::parallel;
use zonal_scene::EnergyBalance;
use zonal_scene::{Bands, Zones};

/// f − 1 of each band, for the incident radiation of a group (H and G without direct light, W/m²) and `energy`, the balance computed from it.
pub(crate) fn imbalance(zones: &Zones, energy: &EnergyBalance, incident: &[Bands]) -> Bands {
    let all = absorbed_power(SharedZones::alone(zones), |i| incident[i]);
    let off = energy.residual * (energy.emitted + energy.incoming);
    off.zip_map(all, |off, all| if all > 0.0 { off / all } else { 0.0 })
}

/// Scales the incident radiation of a group so that its balance closes. Returns false where nothing is changed.
pub(crate) fn normalize_power(change: Bands, incident: &mut [Bands], tolerance: f64) -> bool {
    // A factor on some bands alone would tint the light.
    let is_small = change.all(|f| f.abs() <= tolerance);
    if is_small {
        parallel::for_each(incident, |_, h| *h *= 1.0 + change);
    }
    is_small
}
