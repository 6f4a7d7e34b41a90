//! The final gather: indirect light of a surface point by rays, in the place of the patches' own.
//!
//! ```text
//! H = π/N Σ_i L(ω_i),   ω_i of cosine density:   L = Σ_k τ_k ∫ κ e^{−κs} B/π ds + Σ_panes + τ_end B_end/π
//! ```
//!
//! B is the radiosity of the zones that a ray passes and at which it ends, direct light included, interpolated; the radiance of the
//! surroundings where there is none. Skies and shining surfaces that count as lights are no part of it: their light is direct. What the patches
//! know in the mean, the rays know at the point: creases and the shadows of things that stand close by are crisp, and no light
//! comes from behind a wall. The rays of a point are a shifted R₂ sequence, the shift a hash of the pixel.

use crate::march::{Draw, View, patch_field};
use crate::patch_field::PatchField;
use crate::voxel_field::VoxelField;
use std::f64::consts::PI;
use zonal_math::{Vec3, directions, sequence};
use zonal_scene::{Bands, Sides, Solution, bands};
use zonal_transport::Transport;

/// A piece of a smaller optical depth has its zone's mean.
const THIN: f64 = 0.1;

/// What gathering rays look up.
pub(crate) struct Gather<'a> {
    rays: usize,
    surfaces: PatchField<'a>,
    medium: Option<VoxelField<'a>>,
    /// B of the voxel zones, W/m².
    means: &'a [Bands],
}

impl<'a> Gather<'a> {
    /// Ready for so many rays a point.
    pub(crate) fn new(s: &'a Solution, transport: &'a Transport<'a>, rays: usize) -> Gather<'a> {
        let (first, last) = (s.zones.voxel_offset(), s.zones.pane_offset());
        let radiosity = &s.fields.radiosity;
        Gather {
            rays,
            surfaces: patch_field(s, transport, radiosity),
            medium: VoxelField::of(s, transport, radiosity[first..last].to_vec()),
            means: &radiosity[first..last],
        }
    }

    /// Radiance, W/(m² sr), that a piece of a ray in a voxel zone sends, at its own border: that of the zone's mean where the piece is thin.
    fn sent(&self, zone: usize, kappa: Bands, length: f64, middle: Vec3) -> Bands {
        if kappa == [0.0; 3] {
            return kappa;
        }
        let thin = kappa.iter().all(|k| k * length < THIN);
        let radiosity = match self.medium.as_ref().filter(|_| !thin) {
            Some(field) => field.at(zone, middle),
            None => self.means[zone],
        };
        let passed = passing(kappa, length);
        bands(|b| radiosity[b] * (1.0 - passed[b]) / PI)
    }
}

impl View<'_> {
    /// H without direct light, W/m², at a surface point with the unit normal `normal`.
    pub(crate) fn gathered(&self, gather: &Gather, point: Vec3, normal: Vec3, draw: Draw) -> Bands {
        let ray = draw.first / draw.count;
        let mut sum = [0.0; 3];
        for i in 0..gather.rays {
            let at = sequence::r2(ray * gather.rays + i, [draw.shift[1], draw.shift[2]]);
            let l = self.zonal_radiance(gather, point, directions::cosine(normal, at));
            sum = bands(|b| sum[b] + l[b]);
        }
        sum.map(|l| l * PI / gather.rays as f64)
    }

    /// Radiance, W/(m² sr), of the zones along a ray.
    fn zonal_radiance(&self, gather: &Gather, origin: Vec3, dir: Vec3) -> Bands {
        let scene = &self.s.scene;
        let hit = self.transport.nearest(origin, dir, 0.0, f64::INFINITY);
        let end = hit.map_or_else(|| (self.transport.beyond(origin, dir) - origin).length(), |h| h.t);
        let seen = match hit {
            None => scene.surroundings().radiance,
            Some(h)
                if !h.front && scene.surfaces()[scene.facets()[h.facet].surface].sides == Sides::Front =>
            {
                [0.0; 3]
            }
            Some(h) => {
                let b =
                    gather.surfaces.at(2 * h.facet + usize::from(!h.front), [h.u, h.v], origin + dir * h.t);
                b.unwrap_or([0.0; 3]).map(|b| b / PI)
            }
        };
        let at = |t: f64| origin + dir * t;
        let panes = self.panes_between(origin, at(end));
        if !panes.is_empty() {
            let path = self.path((origin, dir), (0.0, end), panes);
            let mut out = bands(|b| path.tau[b] * seen[b] + path.glow[b]);
            for p in &path.pieces {
                let sent = gather.sent(p.zone, p.kappa, p.t1 - p.t0, at(0.5 * (p.t0 + p.t1)));
                out = bands(|b| out[b] + p.tau[b] * sent[b]);
            }
            return out;
        }
        let (mut out, mut tau) = ([0.0; 3], [1.0; 3]);
        self.transport.walk(origin, at(end), &mut |cell, t0, t1| {
            let middle = at(0.5 * (t0 + t1));
            if let Some(zone) = self.transport.zone_in(&self.s.zones, cell, middle) {
                let kappa = self.s.zones.voxels[zone].extinction;
                let sent = gather.sent(zone, kappa, t1 - t0, middle);
                let passed = passing(kappa, t1 - t0);
                out = bands(|b| out[b] + tau[b] * sent[b]);
                tau = bands(|b| tau[b] * passed[b]);
            }
        });
        bands(|b| out[b] + tau[b] * seen[b])
    }
}

/// e^{−κℓ}.
fn passing(kappa: Bands, length: f64) -> Bands {
    if kappa[0] == kappa[1] && kappa[0] == kappa[2] {
        return [(-kappa[0] * length).exp(); 3];
    }
    kappa.map(|k| (-k * length).exp())
}
