//! Light of skies without grain: on surfaces the hemisphere is divided where the sky begins, in the medium the zones have it.
//!
//! With ω(u, v) the map of the unit square to directions of cosine density, the irradiance of skies of radiance L is
//!
//! ```text
//! H = π ∫∫ τ(ω(u, v)) L du dv
//! ```
//!
//! with τ = 0 behind a facet. A sky that is not uniform has the map of the light sampler, half of it by the table of its radiance, and the weights of that map. The square has n × n cells, each with one sample; a cell whose value differs from that of a neighbour is sampled again at
//! k × k points. The boundary of what is visible is thereby resolved to 1/(n k), and a window of 1 % of the hemisphere is known to a few per cent with
//! a few hundred rays. Where little is visible n is doubled. The values are those of nodes (`node_lattice`), the same for all rays of a picture.
//!
//! In the medium the fluence G of a sky varies over distances of its openings. The solution has the mean of every voxel zone, and the light that is
//! scattered once, ΩG/4, is interpolated between the zones like indirect light. No ray samples the sky there.

use super::node_lattice::{NodeLattice, Viewpoint};
use crate::interpolation::lazy_values::LazyValues;
use crate::surface::shading::ReceiverPoint;
use zonal_math::{Vec3, low_discrepancy};
use zonal_scene::{Band, Bands, LightGroup, Solution};
use zonal_transport::Transport;
use zonal_transport::lights::{LightSampler, Receiver};

/// Pixels between nodes, and most intervals along an edge.
const PIXELS_PER_NODE: f64 = 4.0;
const MAX_INTERVALS: usize = 64;
/// n, and k.
const CELLS: usize = 16;
const SAMPLES_OF_DIVIDED_CELL: usize = 4;
/// Visible share of the sky below which n is doubled.
const MIN_VISIBLE_SHARE: f64 = 0.05;
/// Samples along each side of the unit square for the light of a sky that is not uniform, without obstacles.
const UNOBSTRUCTED_SAMPLES: usize = 8;
/// Difference between neighbouring cells, over the unobstructed sky, above which they are divided.
const MAX_DIFFERENCE: f64 = 0.1;

/// The irradiance of all skies of a scene, for one camera.
pub(crate) struct SkyField<'a> {
    solution: &'a Solution,
    transport: &'a Transport<'a>,
    skies: Vec<LightSampler<'a>>,
    viewpoint: Viewpoint,
    lattices: LazyValues<Option<NodeLattice>>,
}

/// The fluence of all skies at the volume zones, as the solution has it.
pub(crate) struct StoredSkies<'a> {
    solution: &'a Solution,
    groups: Vec<&'a LightGroup>,
}

impl<'a> StoredSkies<'a> {
    /// `None` for a scene without skies, and where the solution lacks the direct light of one apart.
    pub(crate) fn of(s: &'a Solution) -> Option<StoredSkies<'a>> {
        let lights = s.scene.lights().iter().enumerate();
        let skies = lights.filter(|(_, l)| l.fills_sphere()).map(|(l, _)| l);
        let groups = skies.map(|l| s.group_with_direct_light(l)).collect::<Option<Vec<_>>>()?;
        (!groups.is_empty()).then_some(StoredSkies { solution: s, groups })
    }

    /// Radiosity by light of the skies that voxel zone `zone` scatters once, ΩG/4, W/m².
    pub(crate) fn scattered(&self, zone: usize) -> Bands {
        let zones = &self.solution.zones;
        let fluence: Bands = self.groups.iter().map(|g| g.direct_at(zones.voxel_index(zone))).sum();
        zones.voxels.at(zone).albedo * fluence / 4.0
    }
}

impl<'a> SkyField<'a> {
    /// `None` for a scene without skies.
    pub(crate) fn new(s: &'a Solution, transport: &'a Transport<'a>, viewpoint: Viewpoint) -> Option<Self> {
        let skies = s.scene.lights().iter().filter(|l| l.fills_sphere());
        let skies: Vec<LightSampler> = skies.map(|l| LightSampler::new(&s.scene, l)).collect();
        let lattices = LazyValues::new(s.zones.patches.len());
        (!skies.is_empty()).then_some(SkyField { solution: s, transport, skies, viewpoint, lattices })
    }

    /// H of the skies at a point of patch `i`, W/m²; `None` where the camera does not resolve the patch.
    pub(crate) fn irradiance(&self, i: usize, point: Vec3) -> Option<Bands> {
        let patch = &self.solution.zones.patches[i];
        let lattice = self.lattices.get(i, || {
            let n = self.viewpoint.intervals(&patch.plate, PIXELS_PER_NODE, MAX_INTERVALS);
            (n > 0).then(|| NodeLattice::new(n))
        });
        let node = |at: Vec3| {
            let surface = ReceiverPoint::without_map(self.transport, patch.facet, at, patch.normal);
            self.gather(surface.point, surface.normal)
        };
        lattice.as_ref().map(|l| l.at(&patch.plate, point, Bands::ZERO, &node))
    }

    /// H of the skies at a point with the unit normal `normal`, W/m².
    fn gather(&self, point: Vec3, normal: Vec3) -> Bands {
        let receiver = Receiver::Surface(normal);
        let arrived = |s: [f64; 2]| -> Bands {
            let sample = [s[0], s[1], 0.5];
            let of = |sky: &LightSampler| {
                let light = sky.sample_at(self.transport, point, receiver, sample)?;
                sky.attenuated(self.transport, point, &light)
            };
            self.skies.iter().filter_map(of).sum()
        };
        let whole: Bands = self.skies.iter().map(|sky| self.unobstructed(sky, point, receiver)).sum();
        let coarse = divided_mean(CELLS, whole, &arrived);
        let share = Band::all().fold(0.0f64, |m, b| m.max(coarse[b] / whole[b].max(f64::MIN_POSITIVE)));
        if share >= MIN_VISIBLE_SHARE { coarse } else { divided_mean(2 * CELLS, whole, &arrived) }
    }

    /// Light of a sky without obstacles, W/m²: that of one sample if the sky is uniform, else a mean.
    fn unobstructed(&self, sky: &LightSampler, point: Vec3, receiver: Receiver) -> Bands {
        let of = |s: [f64; 2]| {
            let sample = sky.sample_at(self.transport, point, receiver, [s[0], s[1], 0.5]);
            sample.map_or(Bands::ZERO, |s| s.flux)
        };
        if !sky.light().is_varying_sky() {
            return of([0.5; 2]);
        }
        let n = UNOBSTRUCTED_SAMPLES;
        let at = |k: usize| (k as f64 + 0.5) / n as f64;
        (0..n * n).map(|k| of([at(k / n), at(k % n)])).sum::<Bands>() / (n * n) as f64
    }
}

/// The mean of `f` over the unit square by n × n cells, divided where neighbours differ by more than a share of `scale`. The second coordinate is a
/// turn, so that the first and the last column are neighbours.
fn divided_mean(n: usize, scale: Bands, f: &dyn Fn([f64; 2]) -> Bands) -> Bands {
    let place = |cell: usize, k: usize, parts: usize| {
        let jitter =
            low_discrepancy::r2(k, [0, 1].map(|m| low_discrepancy::hash_to_unit((2 * cell + m) as u64)));
        let (x, y, parts_f) = (cell / n, cell % n, parts as f64);
        let at = |cell: usize, part: usize, j: f64| (cell as f64 + (part as f64 + j) / parts_f) / n as f64;
        [at(x, k / parts, jitter[0]), at(y, k % parts, jitter[1])]
    };
    let values: Vec<Bands> = (0..n * n).map(|c| f(place(c, 0, 1))).collect();
    let differ = |a: usize, b: usize| {
        let d = (values[a] - values[b]).abs();
        Band::all().any(|k| d[k] > MAX_DIFFERENCE * scale[k])
    };
    let is_divided = |c: usize| {
        let (x, y) = (c / n, c % n);
        let (before, after) = (x * n + (y + n - 1) % n, x * n + (y + 1) % n);
        (x > 0 && differ(c, c - n))
            || (x + 1 < n && differ(c, c + n))
            || differ(c, before)
            || differ(c, after)
    };
    let parts = SAMPLES_OF_DIVIDED_CELL;
    let value = |c: usize| {
        if is_divided(c) {
            (0..parts * parts).map(|k| f(place(c, k, parts))).sum::<Bands>() / (parts * parts) as f64
        } else {
            values[c]
        }
    };
    (0..n * n).map(value).sum::<Bands>() / (n * n) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_resolved_beyond_the_cells() {
        // A square of 1 % of the domain at many places: sixteen squared samples alone have errors of tens of per cent.
        let size = 0.1;
        let (mut worst, mut square) = (0.0f64, 0.0);
        for k in 0..64 {
            let [x, y] = low_discrepancy::r2(k, [0.0; 2]).map(|u| u * (1.0 - size));
            let inside = |s: [f64; 2]| (x..x + size).contains(&s[0]) && (y..y + size).contains(&s[1]);
            let f = |s: [f64; 2]| if inside(s) { Bands::ONE } else { Bands::ZERO };
            let off = divided_mean(2 * CELLS, Bands::ONE, &f).first() / (size * size) - 1.0;
            (worst, square) = (worst.max(off.abs()), square + off * off / 64.0);
        }
        assert!(square.sqrt() < 0.04 && worst < 0.12, "{:.3} {worst:.3}", square.sqrt());
        let all = divided_mean(CELLS, Bands::ONE, &|_| Bands::ONE);
        assert_eq!(all, Bands::ONE);
    }
}
