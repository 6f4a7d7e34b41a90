//! Where walks begin: everything that emits in a band, with its power.

use super::ground::Ground;
use super::tally::Optics;
use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_scene::{Light, Sides, Zones};

/// A source.
#[derive(Clone, Copy, Debug)]
pub(super) enum Take {
    /// The front or the back of a facet.
    Facet(u32, bool),
    /// A zone.
    Zone(usize),
    /// A cell of the medium: as much a cubic metre where it is free.
    Cell(usize),
    /// A plate of a pane.
    Plate(usize),
    /// A sun: the way towards it, and the cosine of its angular radius.
    Sun(Vec3, f64),
    /// All around.
    Around,
}

/// All sources of a band.
pub(super) struct Sources {
    list: Vec<(Take, f64)>,
    /// Sums of moduli, W.
    upto: Vec<f64>,
    /// All of them, W.
    pub power: f64,
    /// Those of the medium, W.
    pub medium: f64,
}

impl Sources {
    /// Collects them: of `zones`, or of the scene itself.
    pub(super) fn new(ground: &Ground, optics: &Optics, zones: Option<&Zones>, b: usize) -> Sources {
        let scene = ground.scene;
        let mut list: Vec<(Take, f64)> = Vec::new();
        match zones {
            Some(z) => {
                // A surface that is direct light emits as a zone all the same: its light is even on each.
                for (i, p) in z.patches.iter().enumerate() {
                    list.push((Take::Zone(i), optics.surface(p.surface).sends[b] * p.area));
                }
                for (k, v) in z.voxels.iter().enumerate() {
                    list.push((Take::Zone(z.voxel_offset() + k), optics.cell(v.cell).sends[b] * v.volume));
                }
                for (k, p) in z.panes.iter().enumerate() {
                    let power = optics.pane(p.pane).sends[b] * p.area * p.thickness;
                    list.push((Take::Zone(z.pane_offset() + k), power));
                }
            }
            None => {
                for (k, f) in (0u32..).zip(scene.facets()) {
                    let power = optics.surface(f.surface).sends[b] * f.plate.area();
                    list.push((Take::Facet(k, true), power));
                    if scene.surfaces()[f.surface].sides == Sides::Both {
                        list.push((Take::Facet(k, false), power));
                    }
                }
                if let Some(map) = scene.voxmap() {
                    let volume = map.cell().product();
                    list.extend((0..map.len()).map(|c| (Take::Cell(c), optics.cell(c).sends[b] * volume)));
                }
                for (k, (pane, q)) in ground.plates.iter().enumerate() {
                    let power = optics.pane(*pane).sends[b] * q.area() * scene.panes()[*pane].thickness;
                    list.push((Take::Plate(k), power));
                }
            }
        }
        let (_, r) = ground.ball();
        let mut around = match scene.thermal() {
            Some(t) => t.surroundings_radiance()[b],
            None => scene.surroundings().radiance[b],
        };
        for light in scene.lights() {
            match light {
                Light::Sun { direction, irradiance, angular_diameter, .. } => {
                    let cos = (0.5 * angular_diameter).cos();
                    let flux = 2.0 * irradiance[b] / (1.0 + cos);
                    list.push((Take::Sun(-*direction, cos), flux * PI * r * r));
                }
                Light::Sky { radiance, .. } => around += radiance[b],
                Light::Emitter { .. } => {}
            }
        }
        list.push((Take::Around, around * PI * 4.0 * PI * r * r));
        list.retain(|s| s.1 != 0.0);
        let voxels = zones.map_or(0..0, |z| z.voxel_offset()..z.pane_offset());
        let within = |t: &Take| match t {
            Take::Cell(_) => true,
            Take::Zone(i) => voxels.contains(i),
            _ => false,
        };
        let medium = list.iter().filter(|s| within(&s.0)).map(|s| s.1.abs()).sum();
        let mut sum = 0.0;
        let upto = list
            .iter()
            .map(|s| {
                sum += s.1.abs();
                sum
            })
            .collect();
        Sources { list, upto, power: sum, medium }
    }

    /// The source at a share of the power, and its sign.
    pub(super) fn at(&self, u: f64) -> (Take, f64) {
        let k = self.upto.partition_point(|&x| x <= u * self.power).min(self.list.len() - 1);
        (self.list[k].0, self.list[k].1.signum())
    }
}
