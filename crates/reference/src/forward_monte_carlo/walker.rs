//! Random walks from the sources and their scores.

use super::emission_sampling::{EmissionElement, EmissionTable, leave_light};
use super::optics::{ElementOptics, WalkOptics};
use super::problem::ForwardProblem;
use super::score::{ScoreLayout, band_score, reemission_score};
use super::walk_scene::{TrackLocation, WalkEnd, WalkScene, WalkStart};
use crate::path_tracer::bvh::RayHit;
use crate::rng::{Rng, hash, select_band};
use zonal_math::Vec3;
use zonal_scene::voxel_samples::subcell_coordinates;
use zonal_scene::{
    Band, MAX_CONTINUED_PATCH_SIZES, Plate, PlateKind, SUBCELLS, Scene, Sides, VolumeSample, VoxelZone,
    ZoneRef, Zones,
};

/// Independent batches of a mean.
pub(super) const BATCH_COUNT: usize = 32;
/// A walk whose weight falls below this fraction of its initial weight undergoes Russian roulette.
const ROULETTE_WEIGHT_SHARE: f64 = 0.1;
/// Events after which a walk is abandoned.
const MAX_EVENTS: usize = 2_000_000;
/// Most trials to draw a point of a sub-cell that its sample point sees.
const MAX_POINT_TRIALS: usize = 200;

/// The scene, the zones if any, and the layout of the scores.
pub(super) struct Walker<'a> {
    walk_scene: WalkScene<'a>,
    pub optics: WalkOptics,
    zones: Option<&'a Zones>,
    /// True where light to patches close by leaves from the point met.
    divides: bool,
    pub layout: ScoreLayout,
    /// The patches of each facet.
    patches: Option<Vec<Vec<usize>>>,
}

/// The ends of a flight that count.
#[derive(Clone, Copy)]
enum FlightEnds {
    All,
    /// Patches nearer than a distance, m.
    PatchesWithin(f64),
    /// All others.
    OthersThanPatchesWithin(f64),
}

impl FlightEnds {
    /// True where the end of a flight counts, `patch` being the length of the flight where it ends on a patch.
    fn counts(self, patch: Option<f64>) -> bool {
        let within = |r: f64| patch.is_some_and(|length| length < r);
        match self {
            FlightEnds::All => true,
            FlightEnds::PatchesWithin(r) => within(r),
            FlightEnds::OthersThanPatchesWithin(r) => !within(r),
        }
    }
}

/// The state of a walk.
#[derive(Clone, Copy)]
struct WalkState {
    start: WalkStart,
    /// The ends of its next flight that count.
    ends: FlightEnds,
    direction: Vec3,
    weight: f64,
    band: Band,
    /// True after its first event, or when it began on an element.
    counted: bool,
}

/// The slot of an element and the zone, if any, that an event scores on.
#[derive(Clone, Copy)]
struct ScoreTarget {
    slot: usize,
    zone: Option<usize>,
}

/// The patches of each facet.
fn patches_by_facet(zones: &Zones) -> Vec<Vec<usize>> {
    let mut out = vec![Vec::new(); zones.patches.iter().map(|p| p.facet + 1).max().unwrap_or(0)];
    zones.patches.iter().enumerate().for_each(|(i, p)| out[p.facet].push(i));
    out
}

impl<'a> Walker<'a> {
    pub(super) fn new(
        walk_scene: WalkScene<'a>,
        optics: WalkOptics,
        problem: ForwardProblem<'a>,
        layout: ScoreLayout,
    ) -> Walker<'a> {
        let (zones, divides) = (problem.zones(), matches!(problem, ForwardProblem::ContinuedRays(_)));
        Walker { walk_scene, optics, zones, divides, layout, patches: zones.map(patches_by_facet) }
    }

    /// Runs `walks` walks of a band and adds their scores to `sums`.
    pub(super) fn run_batch(
        &self,
        sources: &EmissionTable,
        band: Band,
        walks: usize,
        seed: u64,
        sums: &mut [f64],
    ) {
        if sources.power == 0.0 {
            return;
        }
        let mut rng = Rng::new(hash(seed, u64::MAX));
        let shift = rng.uniform();
        for j in 0..walks {
            let u = (j as f64 + shift) / walks as f64;
            let (source, sign) = sources.at(u);
            let weight = sign * sources.power / walks as f64;
            if let Some((start, direction, counted)) = self.begin(source, &mut rng) {
                let ends = FlightEnds::All;
                self.run(WalkState { start, ends, direction, weight, band, counted }, &mut rng, sums);
            }
        }
    }

    /// A random point and direction of a source, and whether the walk begins on an element; `None` where the point is not in free
    /// space.
    fn begin(&self, source: EmissionElement, rng: &mut Rng) -> Option<(WalkStart, Vec3, bool)> {
        let scene = self.walk_scene.scene;
        match source {
            EmissionElement::Facet(f, front) => {
                let p = &scene.facets()[f as usize].plate;
                let normal = if front { p.normal() } else { -p.normal() };
                let at = rng.point_on_plate(p);
                Some((WalkStart { at, facet: Some(f), pane: None }, rng.cosine_direction(normal), true))
            }
            EmissionElement::Zone(i) => {
                let zones = self.zones?;
                if let ZoneRef::Patch(p) = zones.zone(i) {
                    let at = rng.point_on_plate(&p.plate);
                    let start = WalkStart { at, facet: Some(p.facet as u32), pane: None };
                    return Some((start, rng.cosine_direction(p.normal), true));
                }
                Some((self.point_in_zone(i, rng)?, rng.unit_vector(), true))
            }
            EmissionElement::Cell(c) => {
                let grid = scene.voxel_grid()?;
                let lo = grid.corner(grid.coordinates(c));
                let at = rng.point_in_box(lo, lo + grid.cell());
                self.walk_scene
                    .is_free(at, rng)
                    .then(|| (WalkStart { at, facet: None, pane: None }, rng.unit_vector(), true))
            }
            EmissionElement::Plate(k) => Some((self.start_in_pane(k, None, rng), rng.unit_vector(), true)),
            EmissionElement::Light(l, band) => {
                let (at, direction) = leave_light(&scene.lights()[l], band, &self.walk_scene, rng)?;
                Some((WalkStart { at, facet: None, pane: None }, direction, false))
            }
            EmissionElement::Surroundings => {
                let (centre, r) = self.walk_scene.bounding_sphere();
                let n = rng.unit_vector();
                let start = WalkStart { at: centre + n * r, facet: None, pane: None };
                Some((start, rng.cosine_direction(-n), false))
            }
        }
    }

    /// A point of a pane plate, at a random height in the pane.
    fn start_in_pane(&self, plate: usize, at: Option<Vec3>, rng: &mut Rng) -> WalkStart {
        let (pane, q) = &self.walk_scene.plates[plate];
        let at = at.unwrap_or_else(|| rng.point_on_plate(q));
        let height = rng.uniform() * self.walk_scene.scene.panes()[*pane].thickness;
        WalkStart { at, facet: None, pane: Some((plate, height)) }
    }

    /// A random point of volume or pane zone `i`.
    fn point_in_zone(&self, i: usize, rng: &mut Rng) -> Option<WalkStart> {
        match self.zones?.zone(i) {
            ZoneRef::Patch(_) => None,
            ZoneRef::Voxel(_, z) => {
                let grid = self.walk_scene.scene.voxel_grid()?;
                let lo = grid.corner(grid.coordinates(z.cell));
                let at = self.point_in_voxel_zone(i, z, lo, grid.cell(), rng);
                Some(WalkStart { at, facet: None, pane: None })
            }
            ZoneRef::Pane(_, z) => {
                let at = rng.point_on_plate(&z.plate);
                let own = |p: &(usize, Plate)| p.0 == z.pane;
                let candidates = self.walk_scene.plates.iter().enumerate().filter(|(_, p)| own(p));
                let nearest = candidates
                    .min_by(|a, b| parameter_excess(&a.1.1, at).total_cmp(&parameter_excess(&b.1.1, at)));
                Some(self.start_in_pane(nearest?.0, Some(at), rng))
            }
        }
    }

    /// A random point of volume zone `i`: a sub-cell by its volume, in it a point of the zone that its sample point sees.
    fn point_in_voxel_zone(&self, i: usize, z: VoxelZone, lo: Vec3, edge: Vec3, rng: &mut Rng) -> Vec3 {
        if z.samples.is_empty() {
            return rng.point_in_box(lo, lo + edge);
        }
        let mut rest = rng.uniform() * z.samples.iter().map(|s| s.volume).sum::<f64>();
        let mut chosen = None;
        for s in z.samples.iter() {
            rest -= s.volume;
            chosen = Some(s);
            if rest <= 0.0 {
                break;
            }
        }
        let Some(s) = chosen else { return rng.point_in_box(lo, lo + edge) };
        let small = edge / SUBCELLS as f64;
        let lo = lo + small.scale(subcell_coordinates(s.subcell));
        (0..MAX_POINT_TRIALS)
            .map(|_| rng.point_in_box(lo, lo + small))
            .find(|x| self.walk_scene.visible(s.point, *x) && self.volume_zone_at(z.cell, *x) == Some(i))
            .unwrap_or(s.point)
    }

    /// True where the walk starts on a covered part of a facet.
    fn starts_covered(&self, w: &WalkState) -> bool {
        w.start.facet.is_some_and(|f| {
            let side = w.start_normal(self.walk_scene.scene, f);
            self.walk_scene.is_excluded(w.start.at, side, f)
        })
    }

    /// Follows a walk and its parts to their ends.
    fn run(&self, w: WalkState, rng: &mut Rng, sums: &mut [f64]) {
        let initial = w.weight.abs();
        let mut parts = vec![w];
        while let Some(w) = parts.pop() {
            self.follow(w, initial, &mut parts, rng, sums);
        }
    }

    /// Follows a part of a walk to its end and appends the parts that leave it; `initial` is the weight of the walk.
    fn follow(
        &self,
        mut w: WalkState,
        initial: f64,
        parts: &mut Vec<WalkState>,
        rng: &mut Rng,
        sums: &mut [f64],
    ) {
        if self.starts_covered(&w) {
            // A covered part is excluded; a patch that is covered in part loses its emission there.
            if self.zones.is_some() {
                sums[band_score(self.layout.backs, w.band)] += w.weight;
            }
            return;
        }
        for _ in 0..MAX_EVENTS {
            // Fly to the next event and score the lengths on the way.
            let tau = -(1.0 - rng.uniform()).ln();
            let (band, weight) = (w.band, w.weight);
            let scores_lengths = w.ends.counts(None);
            let end = self.walk_scene.fly(&w.start, w.direction, band, tau, &mut |location, length| {
                if scores_lengths {
                    self.score_length(location, weight * length, band, sums);
                }
            });
            if !self.scatter(end, &mut w, rng, sums) {
                return;
            }
            if let Some(part) = self.divide(end, &mut w, rng) {
                parts.push(part);
            }
            w.counted = true;
            if self.zones.is_some() && self.starts_covered(&w) {
                sums[band_score(self.layout.backs, w.band)] += w.weight;
                return;
            }
            // Russian roulette.
            if w.weight.abs() < ROULETTE_WEIGHT_SHARE * initial {
                let survival = w.weight.abs() / (ROULETTE_WEIGHT_SHARE * initial);
                if rng.uniform() >= survival {
                    return;
                }
                w.weight /= survival;
            }
        }
    }

    /// Scores the end of a flight and continues the walk from it; false where the walk ends.
    fn scatter(&self, end: WalkEnd, w: &mut WalkState, rng: &mut Rng, sums: &mut [f64]) -> bool {
        if !matches!(end, WalkEnd::Facet(..)) && !std::mem::replace(&mut w.ends, FlightEnds::All).counts(None)
        {
            return false;
        }
        match end {
            WalkEnd::Escaped => {
                if w.counted {
                    sums[band_score(self.layout.escaped, w.band)] += w.weight;
                }
                false
            }
            WalkEnd::Facet(hit, at, length) => self.scatter_at_facet(hit, at, length, w, rng, sums),
            WalkEnd::Cell(cell, at) => {
                if !absorb(&self.optics.cells[cell], w, rng) {
                    return false;
                }
                w.start = match self.volume_zone_at(cell, at).and_then(|i| self.point_in_zone(i, rng)) {
                    Some(start) => start,
                    None => WalkStart { at, facet: None, pane: None },
                };
                w.direction = rng.unit_vector();
                true
            }
            WalkEnd::Pane(pane, plate, at) => {
                if !absorb(&self.optics.panes[pane], w, rng) {
                    return false;
                }
                w.start = match self.pane_zone_at(pane, at).and_then(|i| self.point_in_zone(i, rng)) {
                    Some(start) => start,
                    None => self.start_in_pane(plate, Some(at), rng),
                };
                w.direction = rng.unit_vector();
                true
            }
        }
    }

    /// Scores a hit of a facet at the point `at`, `length` from the start of the flight, and reflects the walk; false where the walk ends.
    fn scatter_at_facet(
        &self,
        hit: RayHit,
        at: Vec3,
        length: f64,
        w: &mut WalkState,
        rng: &mut Rng,
        sums: &mut [f64],
    ) -> bool {
        let scene = self.walk_scene.scene;
        let facet = &scene.facets()[hit.id as usize];
        let two_sided = scene.surfaces()[facet.surface].sides == Sides::Both;
        let normal = if hit.front { facet.plate.normal() } else { -facet.plate.normal() };
        let is_lost = (!hit.front && !two_sided) || self.walk_scene.is_covered(at, normal, hit.id);
        if !std::mem::replace(&mut w.ends, FlightEnds::All).counts((!is_lost).then_some(length)) {
            return false;
        }
        if is_lost {
            sums[band_score(self.layout.backs, w.band)] += w.weight;
            return false;
        }
        let zone = self.patch_at(hit.id, normal, at);
        let optics = &self.optics.surfaces[facet.surface];
        let target = ScoreTarget { slot: facet.surface, zone };
        let absorbed = w.weight * optics.absorptance[w.band];
        self.score(optics, target, [w.weight, absorbed], w.band, sums);
        if !absorb(optics, w, rng) {
            return false;
        }
        let at = match (self.zones, zone) {
            (Some(z), Some(i)) => rng.point_on_plate(&z.patches[i].plate),
            _ => at,
        };
        w.start = WalkStart { at, facet: Some(hit.id), pane: None };
        w.direction = rng.cosine_direction(normal);
        true
    }

    /// Divides a walk that leaves a patch: the part that is returned leaves from the point where its flight ended, and counts on patches close by; the other one
    /// counts elsewhere. `None` where rays do not go on from the patch.
    fn divide(&self, end: WalkEnd, w: &mut WalkState, rng: &mut Rng) -> Option<WalkState> {
        let WalkEnd::Facet(hit, at, _) = end else { return None };
        let zones = self.zones.filter(|_| self.divides)?;
        let plate = &self.walk_scene.scene.facets()[hit.id as usize].plate;
        let normal = if hit.front { plate.normal() } else { -plate.normal() };
        let i = self.patch_at(hit.id, normal, at)?;
        if zones.sheets.opposite(i).is_some() {
            return None;
        }
        let reach = MAX_CONTINUED_PATCH_SIZES * zones.patches[i].area.sqrt();
        w.ends = FlightEnds::OthersThanPatchesWithin(reach);
        Some(WalkState {
            start: WalkStart { at, facet: Some(hit.id), pane: None },
            ends: FlightEnds::PatchesWithin(reach),
            direction: rng.cosine_direction(normal),
            counted: true,
            ..*w
        })
    }

    /// Scores a weighted length in the medium or in a pane.
    fn score_length(&self, location: TrackLocation, length: f64, band: Band, sums: &mut [f64]) {
        let (optics, slot, zone) = match location {
            TrackLocation::Cell(c, at) => {
                (&self.optics.cells[c], self.layout.medium, self.volume_zone_at(c, at))
            }
            TrackLocation::Pane(p, at) => {
                (&self.optics.panes[p], self.layout.panes + p, self.pane_zone_at(p, at))
            }
        };
        let absorbed = length * optics.absorptance[band] * optics.extinction[band];
        self.score(optics, ScoreTarget { slot, zone }, [length, absorbed], band, sums);
    }

    /// Adds the incident weight to the zone, and the absorbed weight to the element and the zone.
    fn score(
        &self,
        optics: &ElementOptics,
        target: ScoreTarget,
        [incident, absorbed]: [f64; 2],
        band: Band,
        sums: &mut [f64],
    ) {
        let reemitted = absorbed / optics.total_weight;
        if optics.reemits {
            sums[reemission_score(target.slot)] += reemitted;
        } else {
            sums[band_score(target.slot, band)] += absorbed;
        }
        if let Some(i) = target.zone {
            sums[band_score(self.layout.zones + i, band)] += incident;
            if optics.reemits {
                sums[reemission_score(self.layout.zones + i)] += reemitted;
            }
        }
    }

    /// The patch zone at a point of a facet's side.
    fn patch_at(&self, facet: u32, normal: Vec3, at: Vec3) -> Option<usize> {
        let (zones, lists) = (self.zones?, self.patches.as_ref()?);
        let own = lists.get(facet as usize)?.iter().filter(|&&i| zones.patches[i].normal.dot(normal) > 0.0);
        own.min_by(|&&a, &&b| {
            let excess = |i: usize| parameter_excess(&zones.patches[i].plate, at);
            excess(a).total_cmp(&excess(b))
        })
        .copied()
    }

    /// The volume zone at a point of a cell.
    fn volume_zone_at(&self, cell: usize, at: Vec3) -> Option<usize> {
        let zones = self.zones?;
        let range = zones.voxel_zones_of_cell(cell);
        let k = match range.len() {
            0 => return None,
            1 => range.start,
            _ => self.visible_part(zones, range, at)?,
        };
        Some(zones.voxel_index(k))
    }

    /// The part of a divided cell that holds a point: among those with a sample in the sub-cell of the point that sees it, the one with the most volume there;
    /// else that of the nearest sample that sees it.
    fn visible_part(&self, zones: &Zones, range: std::ops::Range<usize>, at: Vec3) -> Option<usize> {
        let grid = self.walk_scene.scene.voxel_grid()?;
        let lo = grid.corner(grid.coordinates(zones.voxels.at(range.start).cell));
        let subcell = [0, 1, 2].map(|k| {
            let share = (at[k] - lo[k]) / grid.cell()[k];
            (share * SUBCELLS as f64).floor().clamp(0.0, SUBCELLS as f64 - 1.0)
        });
        let samples = range.flat_map(|k| zones.voxels.at(k).samples.iter().map(move |s| (k, s)));
        let mut samples: Vec<(usize, VolumeSample)> = samples.collect();
        samples.sort_by(|a, b| b.1.volume.total_cmp(&a.1.volume));
        let sees = |s: &VolumeSample| self.walk_scene.visible(s.point, at);
        let is_near = |s: &VolumeSample| subcell_coordinates(s.subcell) == Vec3::from_array(subcell);
        if let Some(own) = samples.iter().find(|(_, s)| is_near(s) && sees(s)) {
            return Some(own.0);
        }
        samples.sort_by(|a, b| (a.1.point - at).length2().total_cmp(&(b.1.point - at).length2()));
        samples.iter().find(|(_, s)| sees(s)).or(samples.first()).map(|x| x.0)
    }

    /// The pane zone at a point of a pane.
    fn pane_zone_at(&self, pane: usize, at: Vec3) -> Option<usize> {
        let zones = self.zones?;
        let own = (0..zones.panes.len()).filter(|&k| zones.panes[k].pane == pane);
        let excess = |k: usize| parameter_excess(&zones.panes[k].plate, at);
        let k = own.min_by(|&a, &b| excess(a).total_cmp(&excess(b)))?;
        Some(zones.pane_index(k))
    }
}

/// Applies absorption at an event: reduces the weight, or re-emits the walk in another band; false where the walk ends.
fn absorb(optics: &ElementOptics, w: &mut WalkState, rng: &mut Rng) -> bool {
    let albedo = 1.0 - optics.absorptance[w.band];
    if !optics.reemits {
        w.weight *= albedo;
        return w.weight != 0.0;
    }
    if rng.uniform() >= albedo {
        // Absorbed and re-emitted.
        let weights = optics.band_weights;
        w.band = select_band(weights, rng.uniform() * weights.sum());
        if weights[w.band] == 0.0 {
            return false;
        }
    }
    true
}

impl WalkState {
    /// The normal of the side of its facet that it starts from.
    fn start_normal(&self, scene: &Scene, facet: u32) -> Vec3 {
        let n = scene.facets()[facet as usize].plate.normal();
        if n.dot(self.direction) >= 0.0 { n } else { -n }
    }
}

/// Excess of the parameters of a point over those of a plate; negative within.
fn parameter_excess(p: &Plate, at: Vec3) -> f64 {
    let [u, v] = p.parameters(at);
    let far = if p.kind == PlateKind::Triangle { u + v - 1.0 } else { u.max(v) - 1.0 };
    far.max(-u).max(-v)
}
