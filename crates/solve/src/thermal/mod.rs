//! Temperatures and net powers through the same equations as light.
//!
//! With m = 1, a = 1 − ρ, r = ρ, h = H, q (W/m²) for a patch, and m = 4κ, a = 1 − Ω, r = Ω, h = G/4, q (W/m³) for a volume zone, every
//! zone obeys
//!
//! ```text
//!     B_b = a_b w_b(E) + r_b h_b           net power:  Σ_b m_b a_b (w_b(E) − h_b) = q           E = σT⁴
//! ```
//!
//! **Known temperature**: E is given, and it is a zone like any other; q is what comes out. **Known net power, one band**: a (E − h) = q/m
//! leaves B = h + q/m whatever a may be: a white wall that emits q, a volume of albedo 1 with the source q. So one linear solve by any
//! engine gives all of a grey scene, and E = h + q/(m a) follows. **Known net power, several bands** couples them: E stands in each, and where
//! shares depend on T not even linearly. Module [`coupled`] iterates on E then.
//!
//! | module | what |
//! |---|---|
//! | `local` | m, a, r, q of a zone; E from h |
//! | [`coupled`] | Newton's iteration over temperatures, a linear solve of all bands each |
//! | `linear` | that linear solve: stabilised bi-conjugate gradients in units of power |
//! | `settle` | temperatures, net powers and their errors; the table by name |
//!
//! The zones of a solution are those of the temperatures found: a (1 − ρ)σT⁴ that emits, and no source.

pub mod coupled;
mod linear;
mod local;
mod settle;

use crate::surroundings::Escape;
use local::Locals;
use zonal_scene::{Bands, Known, Scene, SceneError, Zones, bands};

pub(crate) use settle::{settle, spread};

/// Turns zones of a thermal scene into those of the linear equations: known temperatures shine, known powers are white with a source.
/// In light mode nothing changes.
pub fn pose(scene: &Scene, zones: &mut Zones) {
    if scene.thermal().is_none() {
        return;
    }
    let locals = Locals::new(scene, zones);
    let all: Vec<(Known, Bands)> = (0..zones.len()).map(|i| locals.posed(zones, i)).collect();
    let mut list = all.into_iter();
    for (p, (known, own)) in zones.patches.iter_mut().zip(&mut list) {
        p.emission = own;
        if !matches!(known, Known::Temperature(_)) {
            p.reflectance = [1.0; 3];
        }
    }
    for (v, (known, own)) in zones.voxels.iter_mut().zip(&mut list) {
        match known {
            Known::Temperature(_) => v.emission = own,
            _ => (v.albedo, v.emission, v.source) = ([1.0; 3], [0.0; 3], own),
        }
    }
    for (p, (known, own)) in zones.panes.iter_mut().zip(&mut list) {
        match known {
            Known::Temperature(_) => p.emission = own,
            _ => (p.albedo, p.emission) = ([1.0; 3], [0.0; 3]),
        }
    }
}

/// Zones of the scene's own optical properties that emit `emissive(i)` = w(E) of zone `i`.
fn physical(scene: &Scene, zones: &mut Zones, emissive: &[Bands]) {
    let locals = Locals::new(scene, zones);
    let own: Vec<_> = (0..zones.len()).map(|i| locals.of(zones, i)).collect();
    let (voxels, panes) = (zones.voxel_offset(), zones.pane_offset());
    for (i, p) in zones.patches.iter_mut().enumerate() {
        p.reflectance = own[i].reflect;
        p.emission = bands(|b| (own[i].absorb[b] * emissive[i][b]).max(0.0));
    }
    for (k, v) in zones.voxels.iter_mut().enumerate() {
        let i = voxels + k;
        (v.albedo, v.source) = (own[i].reflect, [0.0; 3]);
        v.emission = emissive[i].map(|w| w.max(0.0));
    }
    for (k, p) in zones.panes.iter_mut().enumerate() {
        let i = panes + k;
        (p.albedo, p.emission) = (own[i].reflect, emissive[i].map(|w| w.max(0.0)));
    }
}

/// Bytes a zone: its part in the equations, the vectors of the errors' solve, those of them that are kept as a stage, temperatures and net powers.
const BYTES: u64 = 500 + 5 * 24;

/// Bytes that temperatures take beside what light would.
pub fn bytes(scene: &Scene, zones: &Zones) -> u64 {
    if scene.thermal().is_some() { BYTES * zones.len() as u64 } else { 0 }
}

/// Refuses a scene in which nothing fixes the level of temperatures: closed, and of no zone that absorbs is the temperature known.
pub(crate) fn check_level(scene: &Scene, zones: &Zones, escape: &Escape) -> Result<(), SceneError> {
    if scene.thermal().is_none() || !escape.closed() {
        return Ok(());
    }
    let locals = Locals::new(scene, zones);
    let fixes = |i: usize| {
        let l = locals.of(zones, i);
        matches!(l.known, Known::Temperature(_)) && (0..3).any(|b| l.weight[b] * l.absorb[b] > 0.0)
    };
    if (0..zones.len()).any(fixes) {
        return Ok(());
    }
    Err(SceneError::new(
        "mode",
        "nothing fixes the level of the temperatures: the scene is closed and nothing in it that absorbs has a known one; give some surface or medium a temperature",
    ))
}
