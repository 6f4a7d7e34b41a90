//! Forward Monte Carlo: powers and temperatures by surface and zone, by random walks that start at the sources.
//!
//! A walk begins at a point of an emitter, or on its way in from sun, sky and surroundings, with the weight P/N for a power P (W) and
//! N walks. It flies straight until it hits a facet or an exponential optical depth is spent, is weighted by reflectance or albedo,
//! and continues in a new direction. Its weight scores along the whole path (path-length estimator):
//!
//! ```text
//!     surface:  absorbed += w (1 − ρ)        A H += w          volume:  absorbed += w κ(1 − Ω) ℓ        V G += w ℓ     over lengths ℓ
//! ```
//!
//! **Three problems.** For the *continuous* problem a walk continues from the point of its event. For the equations of the *zones* it
//! restarts at a uniformly random point of the zone that it hits: the mean score of these walks on the zones is the exact solution of
//! the zonal equations with exact exchange areas. A pane has no depth in either: walks restart at any height in it.
//!
//! Rays of the rays engine go on from the point x that they meet on a patch j nearer than R = 1.5 √A_j, which resolves the radiosity within j. So the light
//! that j sends to patches nearer than R is that of x, and all other light is the mean over j. A walk that meets j divides: one part leaves from x and counts where it
//! meets a patch within R, the other part leaves from a random point of j and counts elsewhere. The weight stays, as the two parts count once in the mean.
//!
//! **Heat.** An element of known temperature emits a_b(1 − ρ_b)σT⁴ in band b (4κ_b(1 − Ω_b) a_b σT⁴ for a volume). An element of known
//! net power q re-emits its absorbed power in bands drawn by a_b(1 − ρ_b), and emits q, which may be negative: a weight below 0. Then
//!
//! ```text
//!     Σ_b a_b (1 − ρ_b) ∫σT⁴ dA = absorbed + ∫q dA          Σ_b 4 κ_b (1 − Ω_b) a_b ∫σT⁴ dV = absorbed + ∫q dV
//! ```
//!
//! The part of a surface that solids touch or enclose is excluded: a known power is that of the rest. Band fractions that depend on
//! the temperature are supported for scenes of given temperatures only.
//!
//! Every result is a mean over 32 independent batches, with their spread as standard error, and a function of
//! the seed.
//!
//! | module | content |
//! |---|---|
//! | `walker` | random walks and their scores |
//! | `problem` | the problem that walks solve |
//! | `walk_scene` | flights through facets, cells, panes and periodic images |
//! | `optics` | absorption and emission of surfaces, cells and panes |
//! | `emission_sampling` | the sources of a band |
//! | `score` | from scores to powers and temperatures |
//! | `grazing_error` | error of unsampled grazing directions in thin periodic layers |
//! | `solution` | the results |

mod emission_sampling;
mod grazing_error;
mod optics;
mod problem;
mod score;
mod solution;
mod walk_scene;
mod walker;

pub use problem::ForwardProblem;
pub use solution::{ForwardSolution, HeatBalance};
pub use walk_scene::ClosedSurfaces;

use crate::rng::hash;
use emission_sampling::EmissionTable;
use optics::WalkOptics;
use score::{ScoreLayout, ScoreReader};
use walk_scene::WalkScene;
use walker::{BATCH_COUNT, Walker};
use zonal_math::parallel;
use zonal_scene::{Bands, Scene, Zones};

/// Computes powers and temperatures by `walks` walks for each band.
///
/// # Panics
/// If the scene has symmetry planes.
pub fn trace_forward(
    scene: &Scene,
    closed: &ClosedSurfaces,
    problem: ForwardProblem,
    walks: usize,
    seed: u64,
) -> ForwardSolution {
    let zones = problem.zones();
    assert!(
        !scene.has_symmetry_planes(),
        "walks are not reflected by symmetry planes; trace the whole scene"
    );
    // Measure areas and volumes, and collect the sources.
    let walk_scene = WalkScene::new(scene, closed);
    let (areas, volumes) = match zones {
        None => (walk_scene.areas(hash(seed, 4)), walk_scene.volumes(hash(seed, 3))),
        Some(z) => (patch_areas(scene, z), Vec::new()),
    };
    let optics = WalkOptics::new(scene, &areas);
    let layout = ScoreLayout::new(scene, zones);
    let sources: Vec<EmissionTable> =
        optics.simulated_bands().map(|b| EmissionTable::new(&walk_scene, &optics, zones, b)).collect();
    // Run the batches.
    let walker = Walker::new(walk_scene, optics, problem, layout);
    let sums: Vec<Vec<f64>> = parallel::collect(BATCH_COUNT, |k| {
        let mut sums = vec![0.0; walker.layout.score_count()];
        for (source, b) in sources.iter().zip(walker.optics.simulated_bands()) {
            let batch_seed = hash(hash(seed, k as u64), b.index() as u64);
            walker.run_batch(source, b, walks.div_ceil(BATCH_COUNT), batch_seed, &mut sums);
        }
        sums
    });
    // Convert the scores; the power of one walk bounds the error of rarely hit elements from below.
    let walk_power = Bands::from_fn(|b| {
        let source = sources.get(walker.optics.simulated_band(b).index());
        source.map_or(0.0, |s| s.power.abs() / walks.max(1) as f64)
    });
    let reader = ScoreReader {
        scene,
        zones,
        optics: &walker.optics,
        layout: &walker.layout,
        areas: &areas,
        volumes: &volumes,
        sums: &sums,
        walk_power,
    };
    let mut solution = reader.solution();
    grazing_error::widen_errors(
        &mut solution,
        grazing_error::unsampled_fluence(scene, &sources, walks),
        scene,
        zones,
    );
    solution
}

/// The area of the patches of each surface, m².
fn patch_areas(scene: &Scene, zones: &Zones) -> Vec<f64> {
    let mut areas = vec![0.0; scene.surfaces().len()];
    zones.patches.iter().for_each(|p| areas[p.surface] += p.area);
    areas
}
