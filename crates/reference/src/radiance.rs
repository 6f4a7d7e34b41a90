//! H of a plate and G in a box by backward random walks: no zones, no factors, no equations.
//!
//! A walk is absorbed at each event with the probability of absorption and collects emission on its way: E on a wall,
//! (1 − Ω)E + q/(4κ) at a collision in the medium, (1 − Ω)E in a pane, π L of the surroundings. H is the mean over walks that start
//! with cosine density, G four times the mean over uniform directions. Direct lights are ignored.

use crate::brute_force::{BruteForceScene, FacetHit};
use crate::estimate::{SampleEstimate, SampleStatistics};
use crate::rng::Rng;
use std::f64::consts::PI;
use zonal_math::Vec3;
use zonal_scene::{Band, Pane, Plate, Sides};

/// H of the front of a plate in a band, W/m².
pub fn irradiance(w: &BruteForceScene, plate: &Plate, band: Band, n: usize, seed: u64) -> SampleEstimate {
    let (mut rng, mut statistics) = (Rng::new(seed), SampleStatistics::default());
    for _ in 0..n {
        let (o, d) = (rng.point_on_plate(plate), rng.cosine_direction(plate.normal()));
        statistics.add(walk(w, o, d, band, &mut rng));
    }
    statistics.estimate(1.0)
}

/// G in the box [lo, hi] in a band, W/m².
pub fn fluence(w: &BruteForceScene, lo: Vec3, hi: Vec3, band: Band, n: usize, seed: u64) -> SampleEstimate {
    let (mut rng, mut statistics) = (Rng::new(seed), SampleStatistics::default());
    for _ in 0..n {
        let (o, d) = (rng.point_in_box(lo, hi), rng.unit_vector());
        statistics.add(walk(w, o, d, band, &mut rng));
    }
    statistics.estimate(4.0)
}

/// The next event on a ray.
enum WalkEvent {
    /// The ray leaves the scene.
    Escape,
    /// A facet is hit.
    Wall(FacetHit),
    /// A collision in a cell at a distance, m.
    Medium(f64, usize),
    /// A collision in a pane at a distance, m.
    Pane(f64, usize),
}

/// Samples the next event: an optical distance is spent segment by segment.
fn next_event(w: &BruteForceScene, o: Vec3, d: Vec3, band: Band, rng: &mut Rng) -> WalkEvent {
    let hit = w.first_hit(o, d);
    let limit = hit.map_or(w.far, |s| s.t);
    let mut rest = -(1.0 - rng.uniform()).ln();
    for segment in w.segments(o, d, limit) {
        if let Some((pane, depth)) = segment.pane {
            if rest < depth[band] {
                return WalkEvent::Pane(segment.from, pane);
            }
            rest -= depth[band];
        }
        let kappa = w.extinction(&segment)[band];
        if rest < kappa * (segment.to - segment.from) {
            let cell = segment.cell.expect("a medium has a cell");
            return WalkEvent::Medium(segment.from + rest / kappa, cell);
        }
        rest -= kappa * (segment.to - segment.from);
    }
    hit.map_or(WalkEvent::Escape, WalkEvent::Wall)
}

/// ρ + τ of the wall hit, its emission, and whether what is not absorbed goes through it.
fn scattering_of_wall(w: &BruteForceScene, hit: &FacetHit, band: Band, rng: &mut Rng) -> (f64, f64, bool) {
    let [u, v] = hit.uv;
    let rho = w.scene.reflectance_at(hit.facet, u, v)[band];
    let tau = w.scene.transmittance_at(hit.facet, u, v)[band];
    let emission = w.scene.emission_at(hit.facet, u, v)[band];
    (rho + tau, emission, tau > 0.0 && rng.uniform() * (rho + tau) < tau)
}

/// The emission that one walk collects, as a radiosity, W/m².
fn walk(w: &BruteForceScene, mut o: Vec3, mut d: Vec3, band: Band, rng: &mut Rng) -> f64 {
    let mut sum = 0.0;
    loop {
        let event = next_event(w, o, d, band, rng);
        // Albedo and emission at the event; panes are traversed by a walk of their own.
        let (albedo, emission, transmitted) = match event {
            WalkEvent::Escape => return sum + PI * w.scene.surroundings().radiance[band],
            WalkEvent::Wall(hit) => {
                let facet = &w.scene.facets()[hit.facet];
                if !hit.front && w.scene.surfaces()[facet.surface].sides == Sides::Front {
                    return sum;
                }
                scattering_of_wall(w, &hit, band, rng)
            }
            WalkEvent::Medium(_, cell) => {
                let grid = w.scene.voxel_grid().expect("a cell belongs to a grid");
                let source = grid.source(cell)[band] / (4.0 * grid.extinction(cell)[band]);
                let albedo = grid.albedo(cell)[band];
                (albedo, (1.0 - albedo) * grid.emission(cell)[band] + source, false)
            }
            WalkEvent::Pane(t, pane) => {
                let pane = &w.scene.panes()[pane];
                let n = pane.plates[0].normal();
                let n = if n.dot(d) > 0.0 { n } else { -n };
                match walk_in_pane(pane, band, n.dot(d), rng, &mut sum) {
                    None => return sum,
                    Some((cos, sin)) => {
                        o += d * t;
                        d = cos * n + sin * tangent(n, rng);
                        continue;
                    }
                }
            }
        };
        sum += emission;
        if rng.uniform() >= albedo {
            return sum;
        }
        // Scatter.
        if let WalkEvent::Wall(hit) = event {
            let n = w.scene.facets()[hit.facet].plate.normal();
            o += d * hit.t;
            d = rng.cosine_direction(if hit.front != transmitted { n } else { -n });
        } else if let WalkEvent::Medium(t, _) = event {
            o += d * t;
            d = rng.unit_vector();
        }
    }
}

/// A random unit vector perpendicular to `n`.
fn tangent(n: Vec3, rng: &mut Rng) -> Vec3 {
    let a =
        if n.x.abs() < 0.6 { Vec3::from_array([1.0, 0.0, 0.0]) } else { Vec3::from_array([0.0, 1.0, 0.0]) };
    let t = a.cross(n).normalized();
    let turn = std::f64::consts::TAU * rng.uniform();
    t * turn.cos() + n.cross(t) * turn.sin()
}

/// Walk within a pane that is entered at cosine `c` and collides at least once. Returns the cosine with the forward normal at the
/// exit, and the sine; `None` when the walk is absorbed inside. Collects emission in `sum`.
fn walk_in_pane(pane: &Pane, band: Band, c: f64, rng: &mut Rng, sum: &mut f64) -> Option<(f64, f64)> {
    let kappa = pane.extinction[band];
    let all = kappa * pane.thickness / c;
    // The first collision, conditional on there being one.
    let first = -(1.0 - rng.uniform() * (1.0 - (-all).exp())).ln();
    let mut depth = first / kappa * c;
    loop {
        *sum += (1.0 - pane.albedo[band]) * pane.emission[band];
        if rng.uniform() >= pane.albedo[band] {
            return None;
        }
        let cos = 2.0 * rng.uniform() - 1.0;
        depth -= (1.0 - rng.uniform()).ln() / kappa * cos;
        if depth < 0.0 || depth > pane.thickness {
            return Some((cos, (1.0 - cos * cos).sqrt()));
        }
    }
}
