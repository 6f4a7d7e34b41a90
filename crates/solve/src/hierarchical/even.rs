//! Closure restored for an answer by rays.
//!
//! Every ray ends once, so the rows close whatever the rays are. What is off is the other sum: all rays together end in zone j as often
//! as its area says in the mean only, and light is passed on until little is left, not nothing. Power is therefore not kept exactly, and
//! no scaling of zones mends that without making single zones worse. Scaled is all that arrives of a light group in a band, by one number,
//!
//! ```text
//! f = 1 + (power given − power taken) / power taken from what arrives
//! ```
//!
//! so that the balance of the group closes. No zone's share among the others changes; |f − 1| is told, and is added to the error of
//! every zone. Where it would exceed the tolerance, something else is wrong, and all stays as it is.

use crate::energy::absorbed;
use rayon::prelude::*;
use zonal_scene::solution::Energy;
use zonal_scene::{Bands, Zones, bands};

/// Scales what arrives of a group, H and G without direct light, so that the balance `energy`, made with it, closes; f − 1, a band,
/// zero where nothing was changed.
pub fn even(zones: &Zones, energy: &Energy, incident: &mut [Bands], tolerance: f64) -> Bands {
    let all = absorbed(zones, |i| incident[i]);
    let change = bands(|b| {
        let off = energy.residual[b] * (energy.emitted[b] + energy.incoming[b]);
        let f = if all[b] > 0.0 { off / all[b] } else { 0.0 };
        if f.abs() <= tolerance { f } else { 0.0 }
    });
    incident.par_iter_mut().for_each(|h| *h = bands(|b| h[b] * (1.0 + change[b])));
    change
}
