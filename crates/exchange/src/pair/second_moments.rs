//! Centroid and second moments of the free part of a voxel, from its samples.

use zonal_math::Vec3;
use zonal_scene::SUBCELLS;
use zonal_scene::VolumeSample;

/// The centroid of samples.
pub(super) fn centroid(samples: &[VolumeSample]) -> Vec3 {
    let all: f64 = samples.iter().map(|s| s.volume).sum();
    samples.iter().fold(Vec3::ZERO, |c, s| c + s.point * (s.volume / all))
}

/// Second moments of a part about its centre: xx, yy, zz, xy, yz, zx, m².
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SecondMoments([f64; 6]);

impl SecondMoments {
    /// Second moments of a whole cell with these edges.
    pub(super) fn whole(cell: Vec3) -> SecondMoments {
        let [x, y, z] = cell.scale(cell).array().map(|e| e / 12.0);
        SecondMoments([x, y, z, 0.0, 0.0, 0.0])
    }
    /// Second moments of samples about `centre`; each sample represents one sub-cell.
    pub(super) fn of(samples: &[VolumeSample], centre: Vec3, cell: Vec3) -> SecondMoments {
        let (mut sum, mut all) = ([0.0; 6], 0.0);
        for s in samples {
            let x = s.point - centre;
            let products = [x.x * x.x, x.y * x.y, x.z * x.z, x.x * x.y, x.y * x.z, x.z * x.x];
            (0..6).for_each(|k| sum[k] += s.volume * products[k]);
            all += s.volume;
        }
        let own = SecondMoments::whole(cell * (1.0 / SUBCELLS as f64));
        SecondMoments(std::array::from_fn(|k| sum[k] / all + own.0[k]))
    }
    /// Second moments of the differences between points of two independent parts.
    pub(super) fn sum(self, o: SecondMoments) -> SecondMoments {
        SecondMoments(std::array::from_fn(|k| self.0[k] + o.0[k]))
    }
    /// ⟨1/|d + x|²⟩ d² − 1 to the second order: (4 d̂·C d̂ − tr C)/d².
    pub(super) fn inverse_square_correction(self, d: Vec3) -> f64 {
        let [xx, yy, zz, xy, yz, zx] = self.0;
        let along = d.x * d.x * xx
            + d.y * d.y * yy
            + d.z * d.z * zz
            + 2.0 * (d.x * d.y * xy + d.y * d.z * yz + d.z * d.x * zx);
        let d2 = d.length2();
        (4.0 * along / d2 - xx - yy - zz) / d2
    }
    /// The largest departure from a multiple of the unit matrix, m².
    pub(super) fn anisotropy(self) -> f64 {
        let mean = (self.0[0] + self.0[1] + self.0[2]) / 3.0;
        let (own, mixed) = self.0.split_at(3);
        own.iter().map(|x| (x - mean).abs()).chain(mixed.iter().map(|x| x.abs())).fold(0.0, f64::max)
    }
}
