//! Connections of a gather to the surroundings through panes.
//!
//! A ray of a zone rarely finds a small window. A connection goes through a point y of a pane zone j instead, chosen with the probability p_j
//! (`patch_lights`, with the power that the pane lets in), and counts where it leaves the scene. One direction may cross several panes, and a connection
//! may find it through any of them; over the solid angle its density, and the sample of it joined with those of the rays by the balance heuristic, are
//!
//! ```text
//! p(ω) = Σ_j p_j r_j²/(A_j |cos θ_j|)        ray: τ B K/(K + p)        connection: τ B K/(K + p)        K the density of the ray, 1/sr
//! ```
//!
//! with r_j the distance and θ_j the angle of incidence of each pane crossed, τ the transmittance out of the scene and B the radiosity of the surroundings.
//! Where a ray leaves the scene without crossing a pane, p = 0 and the ray counts fully.

use super::patch_lights::{LightCut, PatchLight, PatchLightTree, ReceiverBall};
use crate::engines::rays::stored_rays::ray_tracer::RayTracer;
use zonal_math::Vec3;
use zonal_scene::{Bands, ZoneRef, Zones};

/// Share of the surroundings that each pane sees at least: few rays measure it.
const MIN_SKY_SHARE: f64 = 0.02;

/// The panes as openings to the surroundings.
pub(crate) struct PaneOpenings<'a> {
    tracer: &'a RayTracer<'a>,
    tree: PatchLightTree,
}

impl<'a> PaneOpenings<'a> {
    /// The openings; `sky_shares` holds the share of the emission of every pane zone that leaves the scene. Without light where none does.
    pub(crate) fn new(tracer: &'a RayTracer<'a>, sky_shares: &[f64]) -> PaneOpenings<'a> {
        let panes = &tracer.zones.panes;
        let sees_sky = sky_shares.iter().any(|s| *s > 0.0);
        let light = |(k, share): (usize, &f64)| {
            let p = &panes[k];
            let pass = (-(p.extinction * p.thickness)).exp().mean();
            PatchLight {
                patch: k as u32,
                centre: p.plate.centre(),
                radius: 0.5 * p.plate.diameter(),
                normal: Vec3::ZERO,
                power: if sees_sky { p.area * pass * share.max(MIN_SKY_SHARE) } else { 0.0 },
            }
        };
        let list = sky_shares.iter().enumerate().map(light).collect();
        PaneOpenings { tracer, tree: PatchLightTree::new(list, panes.len()) }
    }

    fn zones(&self) -> &Zones {
        self.tracer.zones
    }

    /// Prepares the connections of a receiver, with a cut of at most `nodes` nodes.
    pub(crate) fn aim(&self, receiver: &ReceiverBall, nodes: usize, cut: &mut LightCut) {
        self.tree.cut(receiver, nodes, cut);
    }

    /// p(ω) of the ray from `origin`, 1/sr.
    pub(crate) fn density(&self, cut: &LightCut, origin: Vec3, dir: Vec3) -> f64 {
        let mut sum = 0.0;
        if cut.is_dark() {
            return sum;
        }
        let far = self.tracer.transport.exterior_point(origin, dir);
        self.tracer.transport.pane_crossings(origin, far, &mut |hit| {
            let zone = self.tracer.pane_zone(&hit, origin + dir * hit.t);
            if let Some(ZoneRef::Pane(k, pane)) = zone.map(|i| self.zones().zone(i)) {
                sum += self.tree.probability(cut, k as u32) * hit.t * hit.t / (pane.area * hit.cos);
            }
        });
        sum
    }

    /// A direction from `x` through a pane and the transmittance out of the scene; `None` where it does not leave the scene.
    pub(crate) fn sample(&self, cut: &LightCut, x: Vec3, u: [f64; 3]) -> Option<(Vec3, Bands)> {
        let (k, _) = self.tree.sample(cut, u[0])?;
        let plate = &self.zones().panes[k as usize].plate;
        let [s, t] = plate.warp([u[1], u[2]]);
        let dir = (plate.at(s, t) - x).normalized();
        if !dir.is_finite() {
            return None;
        }
        let transport = self.tracer.transport;
        Some((dir, transport.transmittance(x, transport.exterior_point(x, dir))?))
    }
}
