//! References: walks on zones with and without continued paths, path-traced means, and repeated solves of the dense engine.

use super::SceneChoice;
use super::reference::{Reference, ReferenceField, ReferenceZone};
use super::scenes::SceneFolder;
use super::zones::SceneLocator;
use crate::harness::Error;
use crate::harness::zone_sampling::{detector, pick};
use std::time::Instant;
use zonal_exchange::pair::PairSettings;
use zonal_io::input;
use zonal_reference::path_tracer::{Detector, PathTracer, TracingAccuracy};
use zonal_scene::{
    Bands, Engine, LightGroup, LightGroupKind, LightGrouping, MAX_CONTINUED_PATCH_SIZES, NoProgress, Scene,
    Solution, Zones,
};
use zonal_solve::relight::relight;
use zonal_solve::{SolveSettings, solve_with_settings};
use zonal_transport::{Transport, build_zones};

/// Memory limit of the solves, bytes.
const MAX_MEMORY: u64 = 8 << 30;
/// Tolerance of the solve that names the light groups.
const COARSE_TOLERANCE: f64 = 0.5;

/// How references are made.
#[derive(clap::Args)]
pub(crate) struct ReferenceRequest {
    #[command(flatten)]
    choice: SceneChoice,
    #[arg(long, value_parser = ["walks", "continued", "dense"], default_value = "walks")]
    method: String,
    /// Number of patches
    #[arg(long, default_value_t = 200)]
    patches: usize,
    /// Number of volume zones
    #[arg(long, default_value_t = 200)]
    voxels: usize,
    /// Relative standard error of walks
    #[arg(long, default_value_t = 0.01)]
    error: f64,
    /// Most paths of a zone
    #[arg(long, default_value_t = 1 << 19)]
    max_paths: u64,
    /// Solves by the dense engine
    #[arg(long, default_value_t = 4)]
    samples: u64,
    /// Their tolerance
    #[arg(long, default_value_t = 0.003)]
    tolerance: f64,
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Light groups to walk for; all by default
    #[arg(long, value_delimiter = ',')]
    groups: Vec<String>,
}

impl ReferenceRequest {
    /// Makes the references that are wanted and not there.
    pub(super) fn run(&self) -> Result<(), Error> {
        let (target, shared) = (&self.choice.references, &self.choice.data.shared);
        std::fs::create_dir_all(target)?;
        for scene in self.choice.chosen()? {
            let file = Reference::file(target, scene.name, &self.method);
            if file.exists() {
                println!("{}: is there", file.display());
                continue;
            }
            let folder = SceneFolder { path: &target.join("scenes"), shared };
            let Some(path) = scene.write_for_walks(&folder)? else {
                println!("{}: skipped, for {} is absent", scene.name, shared.display());
                continue;
            };
            let start = Instant::now();
            let scene_of_file = input::read_scene(&path)?;
            let reference = match self.method.as_str() {
                "walks" => by_walks(&scene_of_file, self, WalkKind::Zonal)?,
                "continued" => by_walks(&scene_of_file, self, WalkKind::Continued)?,
                _ => by_dense(&scene_of_file, self)?,
            };
            reference.write(&file, scene.name)?;
            let seconds = start.elapsed().as_secs_f64();
            println!("{}: {} zones, {seconds:.0} s", file.display(), reference.zones.len());
        }
        Ok(())
    }
}

/// Readings of detectors of both kinds, H and G, in the order of the zones.
fn measure(
    tracer: &PathTracer,
    all: &[Detector],
    patches: usize,
    request: &ReferenceRequest,
    seed: u64,
) -> ReferenceField {
    let (relative, max_paths) = (request.error, request.max_paths);
    let accuracy = TracingAccuracy { relative, max_paths, ..TracingAccuracy::default() };
    let mut readings = tracer.measure(&all[..patches], &accuracy, seed);
    readings.extend(tracer.measure(&all[patches..], &accuracy, seed + 1));
    ReferenceField::of_readings(&readings)
}

/// Where walks go on from.
#[derive(Clone, Copy, PartialEq, Eq)]
enum WalkKind {
    /// A random point of each zone met: the zonal equations.
    Zonal,
    /// The point met, of patches close by, as the rays of the rays engine.
    Continued,
}

/// Walks on zones for every light group, and beside zonal walks path-traced means.
fn by_walks(scene: &Scene, request: &ReferenceRequest, kind: WalkKind) -> Result<Reference, Error> {
    let mut parts = parts_by_group(scene)?;
    if !request.groups.is_empty() {
        parts.retain(|(name, _)| request.groups.contains(name));
    }
    let transport = Transport::new(scene);
    let zones = build_zones(scene, &transport)?;
    let picked = picked(&zones, request);
    let patches = picked.partition_point(|i| *i < zones.voxel_offset());
    let detectors: Vec<Detector> = picked.iter().map(|&i| detector(scene, &zones, i)).collect();
    let locator = SceneLocator::new(scene, &zones, &transport);
    let seed = request.seed.wrapping_mul(64);
    let (max_continued_patch_sizes, points) = match kind {
        WalkKind::Zonal => (0.0, ""),
        WalkKind::Continued => (MAX_CONTINUED_PATCH_SIZES, ", continued from patches close by"),
    };
    let mut fields = Vec::new();
    for (k, (name, lit)) in parts.iter().enumerate() {
        let start = Instant::now();
        let tracer = PathTracer::new(lit).on_zones(locator.walk_zones(max_continued_patch_sizes));
        fields.push(measure(&tracer, &detectors, patches, request, seed + 4 * k as u64));
        println!("  walks of {name}: {:.0} s", start.elapsed().as_secs_f64());
    }
    let traced = || measure(&PathTracer::new(scene), &detectors, patches, request, seed + 63);
    Ok(Reference {
        zones: picked.iter().map(|&i| ReferenceZone::new(scene, &zones, i)).collect(),
        zone_count: zones.len(),
        groups: parts.into_iter().map(|p| p.0).collect(),
        fields,
        traced: (kind == WalkKind::Zonal).then(traced),
        method: format!("walks on zones, {} relative{points}", request.error),
    })
}

fn picked(zones: &Zones, request: &ReferenceRequest) -> Vec<usize> {
    let mut picked = pick(0..zones.voxel_offset(), request.patches, request.seed);
    picked.extend(pick(zones.voxel_offset()..zones.len(), request.voxels, request.seed + 1));
    picked
}

/// The light groups of a scene, each with the scene in which it alone shines.
fn parts_by_group(scene: &Scene) -> Result<Vec<(String, Scene)>, Error> {
    let coarse = solve_with_groups(scene, Engine::Rays, COARSE_TOLERANCE, 0)?;
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

fn solve_with_groups(scene: &Scene, engine: Engine, tolerance: f64, sample: u64) -> Result<Solution, Error> {
    let mut options = scene.options().clone();
    (options.engine, options.tolerance, options.light_grouping) = (engine, tolerance, LightGrouping::Each);
    let settings = SolveSettings {
        pair_settings: PairSettings { sample, ..PairSettings::default() },
        ..SolveSettings::new(MAX_MEMORY, &NoProgress)
    };
    Ok(solve_with_settings(scene.clone().with_options(options)?, &settings)?)
}

/// The mean of independent samples of the dense engine on all zones, with its standard error.
fn by_dense(scene: &Scene, request: &ReferenceRequest) -> Result<Reference, Error> {
    let mut all = Vec::new();
    for sample in 1..=request.samples {
        let start = Instant::now();
        all.push(solve_with_groups(scene, Engine::Dense, request.tolerance, sample)?);
        println!("  sample {sample}: {:.0} s", start.elapsed().as_secs_f64());
    }
    let (zones, groups) = (&all[0].zones, &all[0].groups);
    let n = all.len() as f64;
    let field = |g: usize| {
        let of = |s: &Solution, i: usize| s.groups[g].incident.at(i) * s.groups[g].incident_scale;
        let mean = |i: usize| all.iter().map(|s| of(s, i)).sum::<Bands>() / n;
        let error = |i: usize| {
            let m = mean(i);
            let squares = all.iter().map(|s| (of(s, i) - m) * (of(s, i) - m)).sum::<Bands>();
            (squares / (n * (n - 1.0).max(1.0))).map(f64::sqrt)
        };
        ReferenceField {
            value: (0..zones.len()).map(mean).collect(),
            error: (0..zones.len()).map(error).collect(),
        }
    };
    Ok(Reference {
        zones: (0..zones.len()).map(|i| ReferenceZone::new(scene, zones, i)).collect(),
        zone_count: zones.len(),
        groups: groups.iter().map(|g| g.name.clone()).collect(),
        fields: (0..groups.len()).map(field).collect(),
        traced: None,
        method: format!("{} samples of the dense engine at {}", all.len(), request.tolerance),
    })
}
