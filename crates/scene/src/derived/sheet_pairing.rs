//! The pairs of sides of sheets among the patches of a scene.

use crate::bands::Bands;
use crate::scene::Scene;
use crate::zones::Patch;
use crate::zones::sheet_sides::{NO_PARTNER, SheetSides};

/// Distance of the centres of two sides of one piece over the root of its area, at most.
const MAX_CENTRE_DISTANCE: f64 = 1e-6;
/// Samples of a patch along each parameter where τ or ρ has a texture.
const SAMPLES_PER_SIDE: usize = 4;

impl SheetSides {
    /// The sides of the sheets of a scene among its patches.
    #[must_use]
    pub fn of(scene: &Scene, patches: &[Patch]) -> SheetSides {
        if scene.surfaces().iter().all(|s| s.transmission.is_none()) {
            return SheetSides::default();
        }
        let mut out = SheetSides {
            opposite: vec![NO_PARTNER; patches.len()],
            transmittance: vec![Bands::ZERO; patches.len()],
        };
        for (i, pair) in patches.windows(2).enumerate() {
            let [a, b] = [&pair[0], &pair[1]];
            let close = MAX_CENTRE_DISTANCE * a.area.sqrt();
            let are_sides = a.facet == b.facet
                && scene.surfaces()[a.surface].transmission.is_some()
                && a.normal.dot(b.normal) < 0.0
                && (a.plate.centre() - b.plate.centre()).length() <= close;
            if !are_sides || out.opposite[i] != NO_PARTNER {
                continue;
            }
            (out.opposite[i], out.opposite[i + 1]) = (i as u32 + 1, i as u32);
            let limit = 1.0 - a.reflectance.max(b.reflectance);
            let transmittance = mean_transmittance(scene, a).min(limit);
            out.transmittance[i..i + 2].fill(transmittance);
        }
        out
    }
}

/// The mean of τ over a patch.
fn mean_transmittance(scene: &Scene, patch: &Patch) -> Bands {
    let plate = &scene.facets()[patch.facet].plate;
    let n = SAMPLES_PER_SIDE;
    let mut sum = Bands::ZERO;
    for i in 0..n * n {
        let cell = |k: usize| (k as f64 + 0.5) / n as f64;
        // The factors move samples of a triangle off its folding diagonal.
        let [u, v] = patch.plate.warp([cell(i / n), cell(i % n) * 0.98 + 0.007]);
        let [u, v] = plate.parameters(patch.plate.at(u, v)).map(|x| x.clamp(0.0, 1.0));
        sum += scene.transmittance_at(patch.facet, u, v);
    }
    sum / (n * n) as f64
}
