//! A camera ray cut into segments of one voxel zone each, with the transmittance before each.
//!
//! L = Σ_k τ_k ∫₀^{ℓ_k} κ e^{−κs} B(s)/π ds + Σ_panes τ (1 − e^{−κt/|cosθ|}) B/π + τ_end L_end. Within a segment B is linear in s,
//! through two Gauss points, and the integral is exact:
//!
//! ```text
//! ∫₀^ℓ κ e^{−κs} (a + b s) ds = a (1 − e^{−x}) + (b/κ)(1 − e^{−x}(1 + x)),   x = κℓ
//! ```

use zonal_scene::Bands;

/// A part of a ray inside one voxel zone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VoxelSegment {
    /// Start, m along the ray.
    pub t0: f64,
    /// End, m.
    pub t1: f64,
    /// Index among the voxel zones.
    pub zone: usize,
    /// Extinction κ, 1/m.
    pub extinction: Bands,
    /// Scattering coefficient κ Ω, 1/m.
    pub scattering: Bands,
    /// Transmittance from the origin to `t0`.
    pub transmittance: Bands,
}

impl VoxelSegment {
    /// Transmittance from the origin to `t` inside the segment.
    pub(crate) fn transmittance_at(&self, t: f64) -> Bands {
        self.transmittance * (-self.extinction * (t - self.t0)).exp()
    }
}

/// A ray up to its end.
#[derive(Clone, Debug, Default)]
pub(crate) struct RayPath {
    pub segments: Vec<VoxelSegment>,
    /// Radiance of the panes along the ray, attenuated, W/(m² sr).
    pub pane_radiance: Bands,
    /// Transmittance of the whole path.
    pub transmittance: Bands,
}

impl RayPath {
    /// The range of distances, m, from the first scattering segment to the last; `None` where nothing scatters.
    pub(crate) fn scattering_range(&self) -> Option<(f64, f64)> {
        let active = |p: &&VoxelSegment| p.scattering.any(|s| s > 0.0);
        let first = self.segments.iter().find(active)?;
        let last = self.segments.iter().rfind(active)?;
        Some((first.t0, last.t1))
    }
}

/// ∫₀^ℓ κ e^{−κs} (a + b s) ds.
pub(crate) fn linear_source_integral(kappa: f64, length: f64, a: f64, b: f64) -> f64 {
    let x = kappa * length;
    let constant = -(-x).exp_m1();
    let linear = if x < 1e-2 {
        length * x * (0.5 - x * (1.0 / 3.0 - x * (0.125 - x / 30.0)))
    } else {
        (constant - x * (1.0 - constant)) / kappa
    };
    a * constant + b * linear
}

/// (1 − e^{−x})/x, 1 at 0; also for x < 0.
pub(crate) fn mean_exp(x: f64) -> f64 {
    if x.abs() < 1e-5 { 1.0 - 0.5 * x } else { -(-x).exp_m1() / x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_source_integral_agrees_with_midpoint_rule() {
        for kappa in [1e-6, 1e-3, 0.04, 0.3, 3.0, 40.0] {
            let (a, b, length) = (2.0, -1.5, 0.25);
            let n = 20000;
            let h = length / n as f64;
            let sum: f64 = (0..n)
                .map(|i| (i as f64 + 0.5) * h)
                .map(|s| kappa * (-kappa * s).exp() * (a + b * s) * h)
                .sum();
            assert!((linear_source_integral(kappa, length, a, b) / sum - 1.0).abs() < 1e-6, "{kappa}");
        }
        assert_eq!(linear_source_integral(0.0, 1.0, 1.0, 1.0), 0.0);
        assert!(
            (mean_exp(1e-6) - (1.0 - 0.5e-6)).abs() < 1e-12 && (mean_exp(2.0) - 0.43233235838).abs() < 1e-10
        );
    }
}
