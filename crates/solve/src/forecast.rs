//! What a solve will take, said beforehand, and what looks wrong with a scene.

use crate::direct::BEAM_RAYS;
use crate::spectral::enclosure::Enclosure;
use crate::surroundings::Escape;
use crate::{dense, gather};
use rayon::prelude::*;
use zonal_scene::{Light, Note, PaneZone, Patch, Scene, VoxelZone, Zones};
use zonal_transport::Transport;

/// Counts, memory and time of a solve.
#[derive(Clone, Debug, PartialEq)]
pub struct Forecast {
    /// Surface zones.
    pub patches: usize,
    /// Volume zones of the voxmap.
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
    /// Largest optical depth across a voxel zone: [`thickness`].
    pub thickness: f64,
}

/// Bytes a zone while a solve runs: fields (radiosity, incident, direct, error), surroundings and backs, sources and weights, and the
/// vectors of the iteration, three bands of eight bytes each.
const FIELDS: u64 = (4 + 2 + 2 + 4) * 24;
/// Bytes a zone and light: field, error, what the group keeps.
const LIGHT: u64 = 24 + 8 + 24;
/// Zones of each kind that are looked at to forecast the rays of direct light.
const LOOKS: usize = 4096;

/// Microseconds of a ray, light along it included, on one core of 2023: a part for itself and one for each halving of the facets.
fn ray_microseconds(facets: usize) -> f64 {
    0.1 + 0.02 * (1.0 + facets as f64).log2()
}

/// Shadow rays of direct light on all zones, from a look at some, and the seconds that they and the rays from the lights take on so many threads.
pub fn direct_light(scene: &Scene, zones: &Zones, transport: &Transport, threads: usize) -> (f64, f64) {
    let one = |light| gather::rays(scene, zones, transport, light, LOOKS);
    // No lights sum to −0.
    let rays: f64 = scene.lights().iter().map(one).sum::<f64>() + 0.0;
    let all = rays + (scene.lights().len() * BEAM_RAYS) as f64;
    (rays, all * 1e-6 * ray_microseconds(scene.facets().len()) / threads.max(1) as f64)
}

/// Bytes of the zones themselves.
pub(crate) fn zone_bytes(zones: &Zones) -> u64 {
    let parts: usize = zones.voxels.par_iter().map(|z| z.part.bytes()).sum();
    let bytes = zones.patches.len() * size_of::<Patch>()
        + zones.voxels.len() * size_of::<VoxelZone>()
        + zones.panes.len() * size_of::<PaneZone>()
        + zones.first.len() * size_of::<u32>()
        + parts;
    bytes as u64
}

impl Forecast {
    /// Looks at the zones of a scene.
    pub fn new(scene: &Scene, zones: &Zones, transport: &Transport) -> Forecast {
        let n = zones.len();
        let (_, groups) = dense::groups(scene, transport.has_panes_between());
        Forecast {
            patches: zones.patches.len(),
            voxels: zones.voxels.len(),
            cut: zones.voxels.par_iter().filter(|z| !z.part.is_empty()).count(),
            panes: zones.panes.len(),
            pairs: (n as u64 * (n as u64 + 1)) / 2,
            groups,
            bytes: dense::bytes(n, zones.panes.len(), groups),
            occluders: transport.occluder_count(),
            zone_bytes: zone_bytes(zones),
            field_bytes: n as u64 * (FIELDS + LIGHT * scene.lights().len() as u64),
            thickness: thickness(scene, zones),
        }
    }

    /// Seconds on so many threads: nanoseconds a pair measured on two cores of 2023, by the kind of pair that prevails.
    pub fn seconds(&self, threads: usize) -> f64 {
        let ns = if self.occluders > 0 { 1500.0 } else { 200.0 };
        self.pairs as f64 * ns * 1e-9 / threads.max(1) as f64
    }
}

/// Optical thickness of a zone beyond which constant radiosity is a rough approximation.
pub const THICK: f64 = 0.3;

/// Optical thickness of a zone beyond which slopes are rough too, beside edges where walls of different radiosity meet: a cube of optical depth 10
/// is 2 % off there, one of 100 in voxels of 6 is 7 %.
pub const STEEP: f64 = 2.0;

/// Facets smaller than this share of the scene's diagonal across are tiny.
const TINY: f64 = 1e-4;

/// Largest optical depth across a voxel zone, along the longest edge of a cell.
pub fn thickness(scene: &Scene, zones: &Zones) -> f64 {
    let Some(map) = scene.voxmap() else { return 0.0 };
    let edge = map.cell().max_abs();
    let worst = |z: &VoxelZone| z.extinction.iter().fold(0.0f64, |m, k| m.max(k * edge));
    zones.voxels.par_iter().map(worst).reduce(|| 0.0, f64::max)
}

/// What a user should know of a scene: notes of the reader, and voxels, so many optical depths across, too thick for radiosity that is
/// `constant` in each.
pub fn warnings(scene: &Scene, thick: f64, constant: bool) -> Vec<Note> {
    let mut out: Vec<Note> = scene.notes().to_vec();
    out.extend(sky_in_medium(scene));
    let least = (TINY * scene.diagonal()).powi(2);
    let tiny = scene.facets().iter().filter(|f| f.plate.area() < least).count();
    if tiny > 0 {
        let text = format!("{tiny} facet(s) are tiny: smaller than {TINY:e} of the scene across");
        out.push(Note::new("tiny-facets", text));
    }
    if constant && thick > THICK {
        out.push(Note::new("thick-voxels", format!(
            "voxels are up to {thick:.2e} optical depths across; below {THICK} is better: use more cells, or, in a box on the grid of its medium, thick_zones = \"linear\""
        )));
    }
    if !constant && thick > STEEP {
        out.push(Note::new("thick-voxels", format!(
            "voxels are up to {thick:.2e} optical depths across: slopes inside them carry light that changes along one direction, but beside edges where hot walls meet cold ones below {STEEP} is better: use more cells"
        )));
    }
    out
}

/// The warning of sky light in a medium that scatters: pictures sample it at few points of the sky along each ray.
pub fn sky_in_medium(scene: &Scene) -> Option<Note> {
    let map = scene.voxmap()?;
    let sky = scene.lights().iter().find_map(|l| match l {
        Light::Sky { name, radiance } if *radiance != [0.0; 3] => Some(name),
        _ => None,
    })?;
    let scatters = |c: usize| (0..3).any(|b| map.extinction(c)[b] * map.albedo(c)[b] > 0.0);
    (0..map.len()).any(scatters).then(|| {
        let text = format!(
            "light '{sky}': sky light in a medium that scatters is sampled; single pixels of pictures have noise of 10 % and more, which no stated error has in it: draw with more --samples"
        );
        Note::warning("sky-noise", text)
    })
}

/// True where rays leave the scene, or end on black backs, from some zone; a few rays for each of up to a thousand zones. Rays know no
/// images: a periodic box tells by its walls.
pub fn is_open(scene: &Scene, zones: &Zones, transport: &Transport) -> bool {
    if scene.is_periodic() {
        return Enclosure::find(scene, zones).is_ok_and(|e| e.is_open());
    }
    let step = zones.len().div_ceil(1000).max(1);
    !Escape::sample(scene, zones, transport, 16, step).closed()
}
