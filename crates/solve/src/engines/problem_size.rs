//! Counts and memory of a solve before it starts, and diagnostics of the scene.

use crate::engines::dense::band_groups::{BandGroups, InteriorPanes, matrix_bytes};
use crate::engines::layered::layer_stack::{LayerStack, needs_layers};
use crate::engines::spectral::enclosure::BoxEnclosure;
use crate::right_hand_side::direct_light::light_power::LIGHT_RAYS;
use crate::right_hand_side::direct_light::shadow_rays;
use crate::right_hand_side::surroundings::SurroundingsExchange;
use crate::settings::unobstructed_cells::UnobstructedCells;
use std::cell::OnceCell;
use zonal_exchange::pair::StripImages;
use zonal_scene::{Diagnostic, Light, PaneZone, Patch, Scene, ZoneBasis, ZoneImages, Zones};
use zonal_transport::Transport;

/// Counts and memory of a solve.
#[derive(Clone, Debug, PartialEq)]
pub struct ProblemSize {
    /// Surface zones.
    pub patches: usize,
    /// Volume zones of the voxel grid.
    pub voxels: usize,
    /// Volume zones that are parts of cut voxels.
    pub cut: usize,
    /// Volume zones of the panes.
    pub panes: usize,
    /// Pairs of zones.
    pub pairs: u64,
    /// Matrices that distinct bands need.
    pub groups: usize,
    /// Bytes of the exchange areas.
    pub bytes: u64,
    /// Facets that can stand between two zones.
    pub occluders: usize,
    /// Bytes of the zones themselves.
    pub zone_bytes: u64,
    /// Bytes of direct light, surroundings, iteration and fields, whatever the engine.
    pub field_bytes: u64,
    /// Largest optical depth across a voxel zone: [`zonal_scene::VoxelZones::max_thickness`].
    pub thickness: f64,
}

/// Bytes a zone while a solve runs: fields (radiosity, incident, direct, error), surroundings and backs, sources and weights, and the
/// vectors of the iteration, three bands of eight bytes each.
const FIELD_BYTES_PER_ZONE: u64 = (4 + 2 + 2 + 4) * 24;
/// Bytes a zone and light: field, error, what the group keeps.
const LIGHT_BYTES_PER_ZONE: u64 = 24 + 8 + 24;
/// Zones of each kind that are sampled for the expected number of shadow rays of a light, at most and at least, and pairs of zones and lights altogether: the time of a
/// forecast does not grow with the number of lights.
const SAMPLED_ZONES: [usize; 2] = [4096, 64];
const SAMPLED_PAIRS: usize = 1 << 14;

/// Microseconds of a ray with its shading on one core of 2023: a constant, and a part for each level of the BVH.
fn ray_microseconds(facets: usize) -> f64 {
    0.1 + 0.02 * (1.0 + facets as f64).log2()
}

/// Expected number of shadow rays of all lights, and seconds of these and of the rays from the lights on `threads` threads.
pub fn direct_light_cost(scene: &Scene, zones: &Zones, transport: &Transport, threads: usize) -> (f64, f64) {
    let lights = scene.lights();
    let zones_of_light = (SAMPLED_PAIRS / lights.len().max(1)).clamp(SAMPLED_ZONES[1], SAMPLED_ZONES[0]);
    let cells = OnceCell::new();
    let one = |light: &Light| {
        let found = || scene.voxel_grid().map(|grid| UnobstructedCells::new(grid, zones, transport));
        let cells = (!light.has_narrow_penumbra()).then(|| cells.get_or_init(found).as_ref()).flatten();
        shadow_rays::expected_rays(zones, transport, light, zones_of_light, cells)
    };
    // Of many lights of a kind, evenly spaced ones stand for all.
    let mut of_kinds: Vec<(std::mem::Discriminant<Light>, Vec<&Light>)> = Vec::new();
    for light in lights {
        let kind = std::mem::discriminant(light);
        match of_kinds.iter_mut().find(|k| k.0 == kind) {
            Some(own) => own.1.push(light),
            None => of_kinds.push((kind, vec![light])),
        }
    }
    let most = SAMPLED_PAIRS / SAMPLED_ZONES[1];
    let of_kind = |list: &[&Light]| {
        let step = list.len().div_ceil(most).max(1);
        let sampled = list.iter().step_by(step);
        let count = sampled.len() as f64;
        sampled.map(|l| one(l)).sum::<f64>() * (list.len() as f64 / count.max(1.0))
    };
    // An empty sum is −0.
    let rays: f64 = of_kinds.iter().map(|k| of_kind(&k.1)).sum::<f64>() + 0.0;
    let all = rays + (scene.lights().len() * LIGHT_RAYS) as f64;
    (rays, all * 1e-6 * ray_microseconds(scene.facets().len()) / threads.max(1) as f64)
}

/// Bytes of the zones themselves.
pub(crate) fn zone_bytes(zones: &Zones) -> u64 {
    let bytes = zones.patches.len() * size_of::<Patch>()
        + zones.voxels.bytes()
        + zones.panes.len() * size_of::<PaneZone>();

    bytes as u64
}

impl ProblemSize {
    /// Counts the zones of a scene.
    pub fn new(scene: &Scene, zones: &Zones, transport: &Transport) -> ProblemSize {
        let n = zones.total();
        let groups = BandGroups::of_scene(scene, InteriorPanes::of(transport)).firsts.len();
        ProblemSize {
            patches: zones.patches.len(),
            voxels: zones.voxels.total(),
            cut: zones.voxels.cut_count(),
            panes: zones.panes.len(),
            pairs: (n as u64 * (n as u64 + 1)) / 2,
            groups,
            bytes: matrix_bytes(n, zones.panes.len(), groups),
            occluders: transport.occluder_count(),
            zone_bytes: zone_bytes(zones),
            field_bytes: n as u64
                * (FIELD_BYTES_PER_ZONE + LIGHT_BYTES_PER_ZONE * scene.lights().len() as u64),
            thickness: zones.voxels.max_thickness(scene.voxel_grid()),
        }
    }
}

impl ProblemSize {
    /// The size of a problem whose zones have images in an even extension: counts are those of the scene, and the dense engine stores its pairs alone.
    #[must_use]
    pub fn with_images(self, images: Option<&ZoneImages>) -> ProblemSize {
        let Some(images) = images else { return self };
        let (n, count) = (images.zone_count(), images.image_count());
        ProblemSize {
            pairs: count as u64 * (n as u64 * (n as u64 + 1)) / 2,
            bytes: matrix_bytes(n, self.panes / count, self.groups),
            patches: self.patches / count,
            voxels: self.voxels / count,
            cut: self.cut / count,
            panes: self.panes / count,
            ..self
        }
    }

    /// The number of zones of which all pairs are as many.
    pub(crate) fn zones_by_pairs(&self) -> usize {
        ((2 * self.pairs) as f64).sqrt() as usize
    }
}

/// Optical depth of a zone above which a constant radiosity is a rough approximation.
const MAX_CONSTANT_BASIS_THICKNESS: f64 = 0.3;

/// Optical depth of a zone above which a linear basis is rough too, beside edges where walls of different radiosity meet: there the error is 2 % for a
/// cube of optical depth 10, and 7 % for one of 100 with voxels of 6.
const MAX_LINEAR_BASIS_THICKNESS: f64 = 2.0;

/// Size of tiny facets over the diagonal of the scene.
const TINY_FACET_SIZE: f64 = 1e-4;

/// Diagnostics of a scene: those of its reader, tiny facets, and voxels of optical depth `thickness` that are too thick for the basis.
#[must_use]
pub fn scene_diagnostics(scene: &Scene, zones: &Zones, thickness: f64, basis: ZoneBasis) -> Vec<Diagnostic> {
    let mut out: Vec<Diagnostic> = scene.notes().to_vec();
    let least = (TINY_FACET_SIZE * scene.diagonal()).powi(2);
    let tiny = scene.facets().iter().filter(|f| f.plate.area() < least).count();
    if tiny > 0 {
        let text = format!(
            "{tiny} facet(s) are tiny: smaller than {TINY_FACET_SIZE:e} of the diagonal of the scene"
        );
        out.push(Diagnostic::note("tiny-facets", text));
    }
    if basis != ZoneBasis::Linear && thickness > MAX_CONSTANT_BASIS_THICKNESS {
        let finer = (thickness / MAX_CONSTANT_BASIS_THICKNESS).ceil();
        let linear = match BoxEnclosure::find(scene, zones) {
            Ok(found) if found.outside.is_empty() => ", or zone_basis = \"linear\"",
            _ => "",
        };
        out.push(Diagnostic::note("thick-voxels", format!(
            "voxels are up to {thickness:.2e} optical depths across; below {MAX_CONSTANT_BASIS_THICKNESS} is better: use {finer} times as many cells along each axis{linear}"
        )));
    }
    if basis == ZoneBasis::Linear && thickness > MAX_LINEAR_BASIS_THICKNESS {
        out.push(Diagnostic::note("thick-voxels", format!(
            "voxels are up to {thickness:.2e} optical depths across: a linear basis resolves light that varies along one direction, but beside edges where hot walls meet cold ones below {MAX_LINEAR_BASIS_THICKNESS} is better: use more cells"
        )));
    }
    out
}

/// Zones and rays of each that are sampled for openings.
const OPENNESS_ZONES: usize = 1000;
const OPENNESS_RAYS: usize = 16;

/// True if rays leave the scene, or end on black backs, from some zone: `OPENNESS_RAYS` rays for each of up to `OPENNESS_ZONES` zones. For a
/// periodic box its walls decide, since rays have no periodic images.
pub fn is_open(scene: &Scene, zones: &Zones, transport: &Transport) -> bool {
    if let Some(strips) = StripImages::of(scene, zones) {
        let step = zones.len().div_ceil(OPENNESS_ZONES).max(1);
        return (0..zones.len()).step_by(step).any(|i| strips.losses(i) != [0.0; 2]);
    }
    if scene.is_periodic() {
        return if needs_layers(scene) {
            LayerStack::find(scene, zones).is_ok_and(|s| s.is_open())
        } else {
            BoxEnclosure::find(scene, zones).is_ok_and(|e| e.is_open())
        };
    }
    let step = zones.len().div_ceil(OPENNESS_ZONES).max(1);
    !SurroundingsExchange::sample(zones, transport, OPENNESS_RAYS, step).is_closed()
}
