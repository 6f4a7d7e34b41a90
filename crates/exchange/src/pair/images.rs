//! Scenes that repeat themselves: the exchange of two zones is that of one with all images of the other.
//!
//! Images with a gap beyond [`DEPTH`] mean free paths are left out; what a row misses is told in `aligned/lattice/images.rs`.

use crate::aligned::lattice::DEPTH;
use crate::aligned::{Cuboid, FactorCache};
use zonal_math::{Bounded, Vec3};
use zonal_scene::Scene;

/// The period along each axis, m; zero where there is none.
pub(super) struct Images {
    period: Vec3,
}

/// Images of a zone that a pair adds up at most: 1 where a scene does not repeat itself.
pub fn images(scene: &Scene) -> f64 {
    let (Some(images), Some(map)) = (Images::of(scene), scene.voxmap()) else { return 1.0 };
    let least = map.extinction(0).into_iter().fold(f64::INFINITY, f64::min);
    images.most(DEPTH / least).iter().map(|m| (2 * m + 1) as f64).product()
}

impl Images {
    /// Images to either side along each axis that may lie within `reach`, m.
    fn most(&self, reach: f64) -> [i64; 3] {
        [0, 1, 2].map(|k| match self.period[k] {
            p if p > 0.0 => (reach / p).ceil() as i64 + 1,
            _ => 0,
        })
    }

    /// Of a scene that repeats itself.
    pub(super) fn of(scene: &Scene) -> Option<Images> {
        let map = scene.voxmap().filter(|_| scene.is_periodic())?;
        let extent = (map.max() - map.min()).array();
        let period = [0, 1, 2].map(|k| if scene.periodic()[k] { extent[k] } else { 0.0 });
        Some(Images { period: Vec3::from_array(period) })
    }

    /// The factor of `a` with all images of `b`, for extinction `kappa` > 0 (1/m).
    pub(super) fn sum(&self, cache: &FactorCache, a: &Cuboid, b: &Cuboid, kappa: f64) -> Bounded {
        let reach = DEPTH / kappa;
        let most = self.most(reach);
        let (mut value, mut radius) = (0.0, 0.0);
        for i in -most[0]..=most[0] {
            for j in -most[1]..=most[1] {
                for k in -most[2]..=most[2] {
                    let shift = self.period.scale(Vec3::from_array([i, j, k].map(|m| m as f64)));
                    let image = Cuboid { lo: b.lo + shift, hi: b.hi + shift, normal: b.normal };
                    let gap = (image.lo - a.hi).max(a.lo - image.hi).max(Vec3::ZERO);
                    if gap.length() <= reach {
                        let f = cache.get(a, &image, kappa);
                        value += f.value;
                        radius += f.radius;
                    }
                }
            }
        }
        Bounded::proved(value, radius)
    }
}
