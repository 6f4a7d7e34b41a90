//! References: path-traced means over zones and surfaces at random, in two independent halves, for each light group alone.
//!
//! A pilot run gives the variance s² of the paths of each zone. With n_i paths of zone i the square of the noise of the L2 over a kind, the mean of that by count
//! and that by size w, is
//!
//! ```text
//! ε² = Σ_i S_i/n_i        S_i = s_i²/2 [1/Σ_j H_j² + w_i/Σ_j w_j H_j²]        n_i = √S_i Σ_j √S_j / ε²
//! ```
//!
//! where the last gives the wanted ε by the fewest paths (Neyman 1934). Where they would take more than the processor time that is left, all are reduced in
//! proportion: such a reference depends on the speed of the machine.

use super::SceneChoice;
use super::reference::{Reference, ReferenceField, ReferenceZone};
use super::scenes::SceneFolder;
use crate::harness::Error;
use crate::harness::process::own_processor_time;
use crate::harness::zone_sampling::{detector, pick};
use zonal_io::input;
use zonal_reference::path_tracer::{Detector, DetectorReading, PathTracer};
use zonal_scene::{
    Band, Bands, Engine, LightGroup, LightGroupKind, LightGrouping, NoProgress, Scene, Solution, Zones,
};
use zonal_solve::relight::relight;
use zonal_solve::{SolveSettings, solve_with_settings};
use zonal_transport::{Transport, build_zones};

/// Memory limit of the solve that names the light groups, bytes.
const MAX_MEMORY: u64 = 8 << 30;
/// Its tolerance.
const COARSE_TOLERANCE: f64 = 0.5;
/// Paths of the pilot run of a zone.
const PILOT_PATHS: u64 = 1024;
/// A zone with little variance in its pilot run counts as if its root were this share of the mean root.
const MIN_SHARE_OF_ROOT: f64 = 0.1;
/// Processor time of the zones of a kind, over that of a surface.
const SHARE_OF_KIND: f64 = 8.0;
/// Largest difference of the absorptances of patches whose surface counts as uniform.
const MAX_ABSORPTANCE_DIFFERENCE: f64 = 1e-9;

/// How references are made.
#[derive(clap::Args)]
pub(crate) struct ReferenceRequest {
    #[command(flatten)]
    choice: SceneChoice,
    /// Number of patches
    #[arg(long, default_value_t = 150)]
    patches: usize,
    /// Number of volume zones
    #[arg(long, default_value_t = 150)]
    voxels: usize,
    /// Number of surfaces
    #[arg(long, default_value_t = 8)]
    surfaces: usize,
    /// Noise of the L2 over a kind of zones, and of the mean over a surface
    #[arg(long, default_value_t = 0.01)]
    error: f64,
    /// Most paths of a zone
    #[arg(long, default_value_t = 1 << 20)]
    max_paths: u64,
    /// Processor time of a scene, s
    #[arg(long, default_value_t = 600.0)]
    limit: f64,
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

impl ReferenceRequest {
    /// Makes the references that are wanted and not there.
    pub(super) fn run(&self) -> Result<(), Error> {
        let (target, shared) = (&self.choice.references, &self.choice.data.shared);
        std::fs::create_dir_all(target)?;
        for scene in self.choice.chosen()? {
            let file = Reference::file(target, scene.name);
            if file.exists() {
                println!("{}: is there", file.display());
                continue;
            }
            let folder = SceneFolder { path: &target.join("scenes"), shared };
            let Some(path) = scene.write_for_paths(&folder)? else {
                println!("{}: skipped, for {} is absent", scene.name, shared.display());
                continue;
            };
            let start = own_processor_time();
            let reference = self.trace(&input::read_scene(&path)?)?;
            reference.write(&file, scene.name)?;
            let (zones, all, seconds) =
                (reference.zones.len(), reference.zone_count, own_processor_time() - start);
            println!("{}: {zones} of {all} zones, {seconds:.0} s", file.display());
        }
        Ok(())
    }

    /// The reference of a scene.
    fn trace(&self, scene: &Scene) -> Result<Reference, Error> {
        let parts = parts_by_group(scene)?;
        let transport = Transport::new(scene);
        let zones = build_zones(scene, &transport)?;
        let kinds = [
            pick(0..zones.voxel_offset(), self.patches, self.seed),
            pick(zones.voxel_offset()..zones.len(), self.voxels, self.seed.wrapping_add(1)),
        ];
        let surfaces = self.surfaces(scene, &zones);
        let lists: Vec<ReceiverList> = kinds
            .iter()
            .filter(|k| !k.is_empty())
            .map(|k| ReceiverList::of_zones(scene, &zones, k))
            .chain(surfaces.iter().map(|&k| ReceiverList::of_surface(&zones, k)))
            .collect();
        let shares: f64 = lists.iter().map(|l| l.share).sum();
        let mut budget =
            TimeBudget { end: own_processor_time() + self.limit, shares: parts.len() as f64 * shares };
        let mut fields = Vec::new();
        for (g, (name, lit)) in parts.iter().enumerate() {
            let (tracer, start) = (PathTracer::new(lit), own_processor_time());
            let mut field = ReferenceField::default();
            for (k, list) in lists.iter().enumerate() {
                let seed = self.seed.wrapping_mul(1 << 20).wrapping_add(((g << 10) + 4 * k) as u64);
                field.append(list.trace(&tracer, self, &mut budget, seed));
            }
            println!("  {name}: {:.0} s", own_processor_time() - start);
            fields.push(field);
        }
        Ok(Reference {
            zones: kinds.concat().into_iter().map(|i| ReferenceZone::new(&zones, i)).collect(),
            surfaces: surfaces.iter().map(|&k| scene.surfaces()[k].name.clone()).collect(),
            zone_count: zones.len(),
            groups: parts.into_iter().map(|p| p.0).collect(),
            fields,
            method: format!("paths, {} of L2, at most {} s", self.error, self.limit),
        })
    }

    /// Surfaces at random among those whose patches absorb one and the same share of light, so that absorbed power tells their mean irradiance.
    fn surfaces(&self, scene: &Scene, zones: &Zones) -> Vec<usize> {
        let mut ranges: Vec<Option<[Bands; 2]>> = vec![None; scene.surfaces().len()];
        for (i, p) in zones.patches.iter().enumerate() {
            let absorbed = Bands::ONE - p.reflectance - zones.sheets.transmittance(i);
            let [lo, hi] = ranges[p.surface].unwrap_or([absorbed; 2]);
            ranges[p.surface] = Some([lo.min(absorbed), hi.max(absorbed)]);
        }
        let uniform = |k: &usize| {
            ranges[*k].is_some_and(|[lo, hi]| {
                lo.min_element() > MAX_ABSORPTANCE_DIFFERENCE
                    && (hi - lo).max_element() < MAX_ABSORPTANCE_DIFFERENCE
            })
        };
        let all: Vec<usize> = (0..ranges.len()).filter(uniform).collect();
        pick(0..all.len(), self.surfaces, self.seed.wrapping_add(2)).into_iter().map(|k| all[k]).collect()
    }
}

/// The light that counts in a mean.
#[derive(Clone, Copy, PartialEq, Eq)]
enum CountedLight {
    /// All but direct light.
    Indirect,
    /// All light.
    All,
}

/// The receivers of one L2.
struct ReceiverList {
    detectors: Vec<Detector>,
    /// Areas or volumes, m² or m³.
    sizes: Vec<f64>,
    light: CountedLight,
    /// Its share of the processor time, relative to other lists.
    share: f64,
}

impl ReceiverList {
    fn of_zones(scene: &Scene, zones: &Zones, picked: &[usize]) -> ReceiverList {
        ReceiverList {
            detectors: picked.iter().map(|&i| detector(scene, zones, i)).collect(),
            sizes: picked.iter().map(|&i| zones.response(i).1).collect(),
            light: CountedLight::Indirect,
            share: SHARE_OF_KIND,
        }
    }

    fn of_surface(zones: &Zones, surface: usize) -> ReceiverList {
        let patches = zones.patches.iter().filter(|p| p.surface == surface);
        ReceiverList {
            detectors: vec![Detector::surface(patches)],
            sizes: vec![1.0],
            light: CountedLight::All,
            share: 1.0,
        }
    }

    /// Two independent halves.
    fn trace(
        &self,
        tracer: &PathTracer,
        request: &ReferenceRequest,
        budget: &mut TimeBudget,
        seed: u64,
    ) -> ReferenceField {
        let time = budget.take(self.share);
        let start = own_processor_time();
        let pilots = tracer.measure_with(&self.detectors, &vec![PILOT_PATHS; self.detectors.len()], seed);
        let pilot_time = own_processor_time() - start;
        let wanted = self.paths(&pilots, request.error);
        let pilot_paths: u64 = pilots.iter().map(|r| r.paths).sum();
        let predicted = pilot_time * wanted.iter().sum::<f64>() / pilot_paths as f64;
        let reduction = ((time - pilot_time).max(0.0) / predicted.max(f64::MIN_POSITIVE)).min(1.0);
        let most = request.max_paths as f64;
        let paths: Vec<u64> =
            wanted.iter().map(|n| (0.5 * (n * reduction).min(most)).ceil() as u64).collect();
        let halves = [1, 2].map(|k| tracer.measure_with(&self.detectors, &paths, seed.wrapping_add(k)));
        let value = |r: &DetectorReading| Bands::from_fn(|b| self.reading(r, b).0);
        let error = |k: usize| {
            let of = |h: usize, b: Band| self.reading(&halves[h][k], b).1;
            Bands::from_fn(|b| 0.5 * of(0, b).hypot(of(1, b)))
        };
        ReferenceField {
            halves: [0, 1].map(|h: usize| halves[h].iter().map(value).collect()),
            error: (0..paths.len()).map(error).collect(),
        }
    }

    /// Mean and standard error of the light that counts.
    fn reading(&self, r: &DetectorReading, b: Band) -> (f64, f64) {
        let e = if self.light == CountedLight::All { r.total[b] } else { r.incident[b] };
        (e.value, e.error)
    }

    /// The paths of each receiver by which the L2 has a noise, the mean over the bands.
    fn paths(&self, pilots: &[DetectorReading], noise: f64) -> Vec<f64> {
        let mut squares = vec![0.0; pilots.len()];
        for b in Band::all() {
            let value = |i: usize| self.reading(&pilots[i], b).0;
            let sum = |weight: &dyn Fn(usize) -> f64| {
                (0..pilots.len()).map(|i| weight(i) * value(i).powi(2)).sum::<f64>()
            };
            let (by_count, by_size) = (sum(&|_| 1.0), sum(&|i| self.sizes[i]));
            if by_count > 0.0 {
                for (i, r) in pilots.iter().enumerate() {
                    let variance = r.paths as f64 * self.reading(r, b).1.powi(2);
                    let weight = 0.5 * (1.0 / by_count + self.sizes[i] / by_size);
                    squares[i] += variance * weight / Band::count() as f64;
                }
            }
        }
        let mut roots: Vec<f64> = squares.into_iter().map(f64::sqrt).collect();
        let least = MIN_SHARE_OF_ROOT * roots.iter().sum::<f64>() / roots.len().max(1) as f64;
        roots.iter_mut().for_each(|r| *r = r.max(least));
        let sum: f64 = roots.iter().sum();
        roots.into_iter().map(|r| r * sum / (noise * noise)).collect()
    }
}

/// The processor time of a scene, divided among the lists to come.
struct TimeBudget {
    /// Processor time of this process at the end, s.
    end: f64,
    /// Sum of the shares of all lists to come.
    shares: f64,
}

impl TimeBudget {
    /// The time of a list, s.
    fn take(&mut self, share: f64) -> f64 {
        let time = (self.end - own_processor_time()).max(0.0) * share / self.shares;
        self.shares -= share;
        time
    }
}

/// The light groups of a scene, each with the scene in which it alone shines.
fn parts_by_group(scene: &Scene) -> Result<Vec<(String, Scene)>, Error> {
    let coarse = solve_coarsely(scene)?;
    let names: Vec<String> = coarse.groups.iter().map(|g| g.name.clone()).collect();
    let whole = |g: &[LightGroup]| g.len() <= 1 || g.iter().any(|g| g.kind == LightGroupKind::All);
    if whole(&coarse.groups) {
        return Ok(vec![(names.first().cloned().unwrap_or("all".into()), scene.clone())]);
    }
    let alone = |name: &String| -> Result<(String, Scene), Error> {
        let others: Vec<(String, Bands)> =
            names.iter().filter(|n| *n != name).map(|n| (n.clone(), Bands::ZERO)).collect();
        Ok((name.clone(), relight(coarse.clone(), &others)?.scene))
    };
    names.iter().map(alone).collect()
}

fn solve_coarsely(scene: &Scene) -> Result<Solution, Error> {
    let mut options = scene.options().clone();
    (options.engine, options.tolerance, options.light_grouping) =
        (Engine::Rays, COARSE_TOLERANCE, LightGrouping::Each);
    let settings = SolveSettings::new(MAX_MEMORY, &NoProgress);
    Ok(solve_with_settings(scene.clone().with_options(options)?, &settings)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::harness::SharedData;
    use std::path::PathBuf;
    use zonal_reference::SampleEstimate;
    use zonal_scene::PerBand;

    /// A room with walls of emissive power 3 W/m² and reflectance 0.4: everywhere H = 3/(1 − 0.4).
    const FURNACE: &str = "name = \"furnace\"\n[[surface]]\nname = \"room\"\nroom = { min = [0, 0, 0], max = [2, 1, 1] }\nreflectance = 0.4\nemission = 3\n";

    fn request(error: f64, limit: f64) -> ReferenceRequest {
        let data = SharedData { shared: PathBuf::new() };
        let choice = SceneChoice { scenes: Vec::new(), slow: false, data, references: PathBuf::new() };
        ReferenceRequest {
            choice,
            patches: 4,
            voxels: 4,
            surfaces: 4,
            error,
            max_paths: 1 << 20,
            limit,
            seed: 3,
        }
    }

    #[test]
    fn halves_of_a_furnace_are_independent_and_exact_within_their_errors() {
        let scene = input::parse_scene(FURNACE, None, "furnace").unwrap();
        let reference = request(0.02, 60.0).trace(&scene).unwrap();
        // Each wall is a light group and a surface.
        assert_eq!((reference.zones.len(), reference.surfaces.len(), reference.groups.len()), (4, 4, 6));
        let field = ReferenceField::sum(reference.fields.iter().map(|f| (f, 1.0)));
        assert_eq!(field.error.len(), 8);
        for i in 0..8 {
            let [a, b] = [0, 1].map(|h: usize| field.halves[h][i].first());
            let error = field.error[i].first();
            assert!(a != b && (0.5 * (a + b) - 5.0).abs() < 4.0 * error, "{i}: {a} {b} ± {error}");
            assert!(error > 0.0 && error < 0.02 * 5.0, "{i}: {error}");
        }
        // Without time, paths are few.
        let short = request(0.02, 0.0).trace(&scene).unwrap();
        let short = ReferenceField::sum(short.fields.iter().map(|f| (f, 1.0)));
        let sum = |f: &ReferenceField| f.error.iter().map(|e| e.first()).sum::<f64>();
        assert!(sum(&short) > 1.5 * sum(&field), "{} {}", sum(&short), sum(&field));
    }

    #[test]
    fn paths_go_where_they_reduce_the_noise_and_reach_it() {
        let reading = |value: f64, error: f64| DetectorReading {
            incident: PerBand::splat(SampleEstimate { value, error }),
            paths: 100,
            ..DetectorReading::default()
        };
        let pilots = [reading(1.0, 0.1), reading(1.0, 0.4), reading(2.0, 0.1)];
        let list = ReceiverList {
            detectors: Vec::new(),
            sizes: vec![1.0, 1.0, 8.0],
            light: CountedLight::Indirect,
            share: 1.0,
        };
        let paths = list.paths(&pilots, 0.01);
        assert!((paths[1] / paths[0] - 4.0).abs() < 1e-9 && paths[2] > paths[0], "{paths:?}");
        // The squares of both L2 noises have the mean of the wanted one.
        let squares = [[1.0, 1.0, 1.0], [1.0, 1.0, 8.0]].map(|weights| {
            let noise =
                |i: usize| weights[i] * 100.0 * pilots[i].incident[Band::first()].error.powi(2) / paths[i];
            let whole = weights[0] + weights[1] + 4.0 * weights[2];
            (0..3).map(noise).sum::<f64>() / whole
        });
        assert!((0.5 * (squares[0] + squares[1]) / 1e-4 - 1.0).abs() < 1e-9, "{squares:?}");
    }
}
