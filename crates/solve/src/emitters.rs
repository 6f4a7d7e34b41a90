//! Direct light of emitters from exchange areas.
//!
//! What an emitter without texture sends to a zone before any reflection is the product of the zones' exchange areas F with the emission E of its
//! patches j:
//!
//! ```text
//!     H_dir,i A_i = Σ_j F_ij E_j        G_dir,i κ_i V_i = Σ_j F_ij E_j        escaped = Σ_j F_j,sky E_j
//! ```
//!
//! the same quantity that shadow rays estimate. The dense and the spectral engine have F: closed forms and rules with error bounds where nothing stands
//! between, measured visibility elsewhere. One application of the operator, and its error is that of the factors. Where this error is within the share
//! of the tolerance that shadow rays aim at, no ray is shot; otherwise both are computed, and the one with the smaller error over all zones is taken.

use crate::direct::{Direct, Lit};
use crate::energy::section;
use crate::engine::{Built, Site};
use crate::gather::SHARE;
use crate::groups::response;
use crate::radii;
use crate::surroundings::Escape;
use zonal_exchange::pair::{Settings, VoxelFactors, target};
use zonal_scene::{Bands, Engine, Light, Scene, Sides, Zones, bands};

/// Relative difference between the area of an emitter's facets and that of its patches: rounding.
const SAME_AREA: f64 = 1e-6;

/// The surface of light number `l` where exchange areas tell its direct light: an emitter without texture all of which is patches, with an engine
/// that has the areas of its patches by themselves.
pub(crate) fn surface(
    scene: &Scene,
    zones: &Zones,
    engine: Engine,
    settings: Settings,
    l: usize,
) -> Option<usize> {
    let Light::Emitter { surface, .. } = &scene.lights()[l] else { return None };
    let own = &scene.surfaces()[*surface];
    if engine == Engine::Hierarchical
        || settings.voxels != VoxelFactors::Exact
        || own.emission_texture.is_some()
    {
        return None;
    }
    let sides = if own.sides == Sides::Both && !own.solid { 2.0 } else { 1.0 };
    let facets = scene.facets().iter().filter(|f| f.surface == *surface);
    let shining: f64 = sides * facets.map(|f| f.plate.area()).sum::<f64>();
    let found: f64 = zones.patches.iter().filter(|p| p.surface == *surface).map(|p| p.area).sum();
    ((found - shining).abs() <= SAME_AREA * shining).then_some(*surface)
}

/// Light number `l`, the emitter `surface`, from the exchange areas of an engine.
pub(crate) fn light(site: &Site, built: &Built, escape: &Escape, (l, surface): (usize, usize)) -> Lit {
    let (scene, zones) = (site.scene, site.zones);
    let n = zones.len();
    let emission = scene.surfaces()[surface].emission;
    let mut strengths = vec![[0.0; 3]; built.operator.len()];
    let own = zones.patches.iter().enumerate().filter(|(_, p)| p.surface == surface);
    let (mut emitted, mut escaped, mut backs, mut square) = ([0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3]);
    for (j, p) in own {
        strengths[j] = emission;
        let (sky, back) = (escape.sky_of(j), escape.backs_of(j));
        let spread = if escape.rays > 0 { escape.spread(j, target(zones, j)) } else { [0.0; 3] };
        for b in 0..3 {
            emitted[b] += emission[b] * p.area;
            escaped[b] += emission[b] * sky[b];
            backs[b] += emission[b] * back[b];
            square[b] += (emission[b] * spread[b] * p.area).powi(2);
        }
    }
    let mut arriving = built.operator.apply(&strengths);
    let spread = built.operator.error(&strengths).unwrap_or_default();
    let slopes = arriving.split_off(n);
    let untold = radii::untold(zones, built, escape);
    let (mut fields, mut error) = (arriving, vec![[0.0; 3]; n]);
    for i in 0..n {
        let measure = response(zones, i).1;
        fields[i] = fields[i].map(|p| (p / measure).max(0.0));
        let e = spread.get(i).copied().unwrap_or_default();
        error[i] = bands(|b| e[b] / measure + radii::of_share(untold[i][b], fields[i][b]));
    }
    let lost = square.map(f64::sqrt);
    Lit {
        name: scene.lights()[l].name(scene).to_string(),
        fields,
        error,
        by_exchange: true,
        slopes,
        emitted,
        escaped,
        backs,
        power_error: [[0.0; 3], lost, if backs == [0.0; 3] { [0.0; 3] } else { lost }],
        ..Lit::default()
    }
}

/// The larger of the relative errors of patches and of volume zones: root mean squares of the power that errs and of the power met.
fn relative(zones: &Zones, lit: &Lit) -> f64 {
    let of = |range: std::ops::Range<usize>| {
        let [e, f] = range.fold([0.0; 2], |[e, f], i| {
            let w = section(zones, i);
            let square = |x: Bands| (0..3).map(|b| (w[b] * x[b]).powi(2)).sum::<f64>();
            [e + square(lit.error_of(i)), f + square(lit.fields[i])]
        });
        if e > 0.0 { (e / f).sqrt() } else { 0.0 }
    };
    of(0..zones.voxel_offset()).max(of(zones.voxel_offset()..zones.len()))
}

/// The lights with those from exchange areas in their places, where `by_exchange` says the surface of any; `sampled` gives a light by shadow rays.
pub(crate) fn complete(
    site: &Site,
    built: &Built,
    escape: &Escape,
    by_exchange: impl Fn(usize) -> Option<usize>,
    sampled: impl Fn(usize) -> Lit,
) -> Option<Direct> {
    if !(0..site.direct.lights.len()).any(|l| by_exchange(l).is_some()) {
        return None;
    }
    let aim = SHARE[0] * site.scene.options().tolerance;
    let mut lights = site.direct.lights.clone();
    for (l, lit) in lights.iter_mut().enumerate() {
        let Some(surface) = by_exchange(l) else { continue };
        *lit = light(site, built, escape, (l, surface));
        let error = relative(site.zones, lit);
        if error > aim {
            let other = sampled(l);
            if relative(site.zones, &other) < error {
                *lit = other;
            }
        }
    }
    Some(Direct { lights })
}
