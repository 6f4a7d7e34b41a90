//! Temperatures and net powers through the zonal equations.
//!
//! With m = 1, a = 1 − ρ, r = ρ, h = H, q (W/m²) for a patch, and m = 4κ, a = 1 − Ω, r = Ω, h = G/4, q (W/m³) for a volume zone, every
//! zone obeys
//!
//! ```text
//!     B_b = a_b w_b(E) + r_b h_b           net power:  Σ_b m_b a_b (w_b(E) − h_b) = q           E = σT⁴
//! ```
//!
//! **Known temperature**: E is given, and the zone emits like any other; q is a result. **Known net power, one band**: a (E − h) = q/m
//! gives B = h + q/m for any a, like a white wall that emits q or a volume of albedo 1 with the source q. One linear solve by any engine
//! therefore solves a grey scene, and E = h + q/(m a) follows. **Known net power, several bands**: E couples the bands, not even linearly if the
//! band fractions depend on T; module `newton` iterates on E. So it does for convection, q = q₀ − h (T − T∞), and for bodies at one temperature.
//!
//! | module | content |
//! |---|---|
//! | `boundary_conditions` | emission and sources of the zones |
//! | `zone_balance` | m, a, r of a zone in one block of bands; its condition |
//! | `spectral_balance` | sums over all bands; E from h |
//! | `linearized_zone` | radiosity of a zone linearized about E |
//! | `nodes` | bodies at one temperature with links |
//! | `newton` | Newton's method for the temperatures |
//! | `coupled_bicgstab` | its linear solve: stabilised bi-conjugate gradients in units of power |
//! | `emissivity` | emissivities that depend on temperature |
//! | `error_propagation` | errors of the incident flux with reflection and reemission |
//! | `recover_temperatures` | temperatures, net powers and their errors |
//! | `heat_table` | sums by name |
//!
//! The zones of a solution have the emission of the temperatures found, (1 − ρ)σT⁴, and no source.

mod boundary_conditions;
mod coupled_bicgstab;
pub(crate) mod emissivity;
mod error_propagation;
mod heat_table;
mod linearized_zone;
pub(crate) mod newton;
mod nodes;
mod recover_temperatures;
mod spectral_balance;
mod zone_balance;

pub use boundary_conditions::apply_boundary_conditions;
pub(crate) use boundary_conditions::check_temperature_level;
pub(crate) use error_propagation::{TemperatureSolve, propagate_errors};
pub(crate) use recover_temperatures::recover_temperatures;

use zonal_scene::{Bands, Scene, ThermalCondition, Zones};

/// Bytes of a zone: its balance, the vectors of the error propagation, those of them that are saved as a stage, temperatures and net powers.
const BYTES_PER_ZONE: u64 = 500 + 5 * 24;

/// Properties of the zones of one block of bands by the scene.
pub(crate) struct ZoneProperties {
    /// Thermal condition of each zone, never the power of a whole surface.
    pub conditions: Vec<ThermalCondition>,
    /// ρ or Ω.
    pub reflectances: Vec<Bands>,
    /// Index of the band fractions in [`zonal_scene::Thermal::all_fractions`].
    pub kinds: Vec<usize>,
}

impl ZoneProperties {
    /// Of the zones of a scene in thermal mode.
    pub(crate) fn of(scene: &Scene, zones: &Zones) -> ZoneProperties {
        let balances = zone_balance::ZoneBalances::new(scene, zones).all(zones);
        ZoneProperties {
            conditions: balances.iter().map(|l| l.condition).collect(),
            reflectances: balances.iter().map(|l| l.reflect).collect(),
            kinds: balances.iter().map(|l| l.kind()).collect(),
        }
    }
}

/// Bytes of a thermal solve beyond those of a light solve.
pub(crate) fn memory_bytes(scene: &Scene, zones: &Zones) -> u64 {
    if scene.thermal().is_some() { BYTES_PER_ZONE * zones.len() as u64 } else { 0 }
}
