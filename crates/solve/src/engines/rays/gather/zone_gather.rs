//! Samples of the incident radiation of one zone from known radiosities.
//!
//! The incident radiation is an integral over the points x of the zone and the directions ω of its kernel,
//!
//! ```text
//! H_i = ⟨v(x, ω)⟩        v = Σ_k (l_k − l_{k+1}) B_k + l(T) B(y)          (`expected_path`; y the surface point at the end of the ray)
//! ```
//!
//! and G_i = 4⟨v⟩. The surface at the end is sampled in two ways: by the ray itself, with the density p = ⟨kernel⟩ of its direction, and by a
//! connection to a point y of a patch j chosen with the probability p_j (`patch_lights`). With K the density of the ray over the area at y,
//!
//! ```text
//! K = cos θ_x cos θ_y/(π r²) on a patch      cos θ_y/(4π r²) in a volume      |cos θ_x| cos θ_y/(2π r²) in a pane
//! ray: l (β + (B_j − β) K/(K + p_j/A_j))     connection: l V (B_j − β) K/(K + p_j/A_j)
//! ```
//!
//! are the two samples joined by the balance heuristic (Veach 1997). Neither exceeds B_j, so nothing diverges where zones touch. β is a typical
//! radiosity of the patches, which rays alone collect: in an enclosure of one radiosity every sample is exact. Only patches brighter than β have a
//! probability.
//!
//! Where the result contains the radiation of the surroundings, rays that leave the scene bring it, joined with connections through panes
//! (`pane_openings`).
//!
//! Where patch j is close to a patch, B_j is that of a path that continues from y (`ray::path_continuation`), as the radiosity varies within the patch.

use super::expected_path::{CollectedZones, ExpectedPath, Pieces, WeightedZone, weighted_zone};
use super::pane_openings::PaneOpenings;
use super::patch_lights::{LightCut, PatchLight, PatchLightTree, ReceiverBall};
use super::point_light::{
    CONNECTION_PART, LightPlace, PointChange, PointLights, RAY_PART, SampledZones, SurfacePoint,
};
use super::single_precision::{self, SingleBands};
use crate::engines::rays::stored_rays::padded_bands::{LANES, PaddedBands, padded, widened};
use crate::engines::rays::stored_rays::path_continuation::{
    PathField, PathLights, PathVertex, VertexSource, vertex_index,
};
use crate::engines::rays::stored_rays::ray_tracer::{ESCAPED, FIRST_CODE, RayEnd, RayNumber, RayTracer};
use crate::right_hand_side::surroundings::zone_rays::{
    WeightedRay, pane_ray_weight, point_in_zone, ray_from_point,
};
use std::f64::consts::PI;
use std::ops::Range;
use zonal_math::parallel;
use zonal_math::{Vec3, low_discrepancy, scrambled_sobol};
use zonal_scene::{Bands, PerBand, ZoneRef, Zones};

/// Seed that separates these samples from all other random numbers.
const GATHER_SEED: u64 = 0x2d35_8dcc_aa6c_78a5;
/// Seed of the rays that only find out whether they leave the scene.
const ESCAPE_SEED: u64 = 0x6a09_e667_f3bc_c908;
/// Part of the numbers of a sample that chooses the connection through a pane.
const OPENINGS_PART: u32 = 6;
/// Bit of the number of a continued ray that separates it from the rays of the table.
const GATHER_RAY: usize = 1 << 24;
/// Bit that separates the path from the end of a connection from that of the ray.
const CONNECTION: usize = 1 << 25;
/// Smallest cosine at the end of a connection.
const MIN_COSINE: f64 = 1e-6;
/// Seed of the estimates of what nothing hides, and their number.
const UNHIDDEN_SEED: u64 = 0x3c6e_f372_fe94_f82b;
const UNHIDDEN_SAMPLES: usize = 32;
/// Most nodes of the cut by which connections through panes are aimed.
const NODES_OF_OPENINGS: usize = 32;

/// The known radiation that a gather reads.
pub(crate) struct GatherField<'a> {
    /// Radiosities of the zones, one column for each quantity, W/m².
    pub columns: Vec<Vec<PaddedBands>>,
    /// β of every column, W/m².
    pub typical: Vec<PaddedBands>,
    /// Source terms at path vertices of every column; empty where paths do not continue.
    pub sources: Vec<&'a VertexSource>,
    /// The surroundings; `None` where the result does not contain them.
    pub sky: Option<&'a GatheredSky>,
    /// The lights that can be read at points; `None` without such lights, or where paths do not continue.
    pub points: Option<PointLights>,
}

/// How samples read direct light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DirectReading {
    /// As the means of zones.
    OfZones,
    /// At the points that they meet (`point_light`).
    AtPoints,
}

impl DirectReading {
    /// The number that stands for it in a checkpoint.
    pub(crate) fn number(self) -> usize {
        match self {
            DirectReading::OfZones => 0,
            DirectReading::AtPoints => 1,
        }
    }
    /// The reading of [`DirectReading::number`].
    pub(crate) fn from_number(number: usize) -> Option<DirectReading> {
        [DirectReading::OfZones, DirectReading::AtPoints].into_iter().find(|d| d.number() == number)
    }
}

/// The surroundings of a gather.
pub(crate) struct GatheredSky {
    /// Radiosity, W/m².
    pub radiosity: Bands,
    /// The column of which they are a source.
    pub column: usize,
    /// Share of the rays of every zone that leave the scene.
    pub shares: Vec<f64>,
}

/// The surroundings in a sample.
pub(crate) struct SampledSky {
    /// What they bring, W/m².
    pub radiosity: Bands,
    /// Weight of the ray of the sample that leaves the scene; 0 where it does not.
    pub escaped: Bands,
}

/// Everything that a gather reads in common.
pub(crate) struct Gatherer<'a> {
    zones: &'a Zones,
    tracer: &'a RayTracer<'a>,
    path: ExpectedPath<'a>,
    /// Lights at path vertices; `None` where paths do not continue.
    lights: Option<PathLights<'a>>,
    patch_lights: PatchLightTree,
    openings: Option<PaneOpenings<'a>>,
    /// ρ of the patches where paths continue; otherwise empty.
    reflectance: Vec<PaddedBands>,
    field: GatherField<'a>,
}

/// Sum and sum of squares of the samples of one quantity.
#[derive(Clone, Copy, Default)]
pub(crate) struct SampleSums {
    sum: SingleBands,
    squares: SingleBands,
}

impl SampleSums {
    /// Σ v.
    pub(crate) fn sum(&self) -> Bands {
        single_precision::to_double(self.sum)
    }

    /// Σ v².
    pub(crate) fn squares(&self) -> Bands {
        single_precision::to_double(self.squares)
    }

    /// Words of the sums in a checkpoint.
    pub(crate) const ENCODED_WORDS: usize = 6;

    /// The sums as words.
    pub(crate) fn words(&self) -> [u32; 6] {
        let [[a, b, c], [d, e, f]] = [self.sum, self.squares].map(single_precision::words);
        [a, b, c, d, e, f]
    }

    /// The sums of these words.
    pub(crate) fn from_words([a, b, c, d, e, f]: [u32; 6]) -> SampleSums {
        let [sum, squares] = [[a, b, c], [d, e, f]].map(single_precision::from_words);
        SampleSums { sum, squares }
    }

    /// Adds sums of further samples.
    pub(crate) fn add(&mut self, [sum, squares]: [Bands; 2]) {
        single_precision::add_to(&mut self.sum, sum);
        single_precision::add_to(&mut self.squares, squares);
    }
}

/// Memory of a task, used again from sample to sample.
#[derive(Default)]
pub(crate) struct GatherScratch {
    cut: LightCut,
    openings_cut: LightCut,
    collected: CollectedZones,
    vertices: Vec<PathVertex>,
    paths: Vec<(u32, PaddedBands)>,
    points: Vec<PointChange>,
    ends: Vec<SurfacePoint>,
    /// Zones with the changes of their weights by textures, and the same of continued paths.
    textured: Vec<WeightedZone>,
    textured_paths: Vec<(u32, PaddedBands)>,
    ray: Option<WeightedRay>,
    /// Weight of β.
    typical: Bands,
    /// Weight of the surroundings, and the part of it that the ray brings.
    sky: Bands,
    escaped: Bands,
}

/// The samples of a zone to take.
#[derive(Clone)]
pub(crate) struct SampleRange {
    /// The zone.
    pub zone: usize,
    /// 0 or 1: the independent sequence.
    pub half: usize,
    /// Numbers of the samples.
    pub numbers: Range<usize>,
    /// How they read direct light.
    pub direct: DirectReading,
}

/// The point of a zone at which a ray starts.
struct RayStart {
    /// The point, m.
    point: Vec3,
    /// The random number that chooses the side of a pane.
    side: f64,
}

/// A point as it is seen from another one.
#[derive(Clone, Copy)]
struct SeenPoint {
    /// Distance, m.
    distance: f64,
    /// Direction to it.
    dir: Vec3,
    /// Cosine of its surface; 1 without one.
    towards: f64,
}

impl SeenPoint {
    /// The point `y`, of a surface of this normal, from `x`.
    fn new(x: Vec3, y: Vec3, normal: Option<Vec3>) -> SeenPoint {
        let distance = (y - x).length();
        let dir = (y - x) / distance.max(f64::MIN_POSITIVE);
        SeenPoint { distance, dir, towards: normal.map_or(1.0, |n| -n.dot(dir)) }
    }

    /// Density of rays over the area at the point, 1/m², for the density of their directions `kernel`, 1/sr.
    fn density(&self, kernel: f64) -> f64 {
        kernel * self.towards / (self.distance * self.distance)
    }
}

/// The balance heuristic a/(a + b) of positive densities, of which a may be infinite.
fn balance(a: f64, b: f64) -> f64 {
    if b > 0.0 { 1.0 / (1.0 + b / a) } else { 1.0 }
}

/// The ball about the bounding box of the centres of zones that receive from all sides.
fn enclosing_ball(balls: impl Iterator<Item = ReceiverBall>) -> ReceiverBall {
    let infinite = Vec3::splat(f64::INFINITY);
    let (lo, hi, radius) = balls.fold((infinite, -infinite, 0.0f64), |(lo, hi, radius), b| {
        (lo.min(b.centre), hi.max(b.centre), radius.max(b.radius))
    });
    let centre = (lo + hi) * 0.5;
    ReceiverBall { centre, radius: radius + (hi - centre).length(), normal: None }
}

/// The point at the end of a ray, connection or path that has this weight there.
fn surface_point(ray: RayNumber, end: &RayEnd, weight: Bands, texture: Bands) -> SurfacePoint {
    let part = if ray.number & CONNECTION == 0 { RAY_PART } else { CONNECTION_PART };
    SurfacePoint { zone: weighted_zone(end.zone, weight), at: end.position, texture, part }
}

/// A sample in its scratch memory.
pub(crate) struct ZoneSample<'a, 'b> {
    gatherer: &'a Gatherer<'b>,
    scratch: &'a GatherScratch,
}

impl ZoneSample<'_, '_> {
    /// The value of column `c` with direct light as the means of zones, W/m².
    pub(crate) fn value(&self, c: usize) -> PaddedBands {
        self.gatherer.value(c, self.scratch)
    }
    /// Its change by direct light at points, W/m²; 0 where it is not read.
    pub(crate) fn change(&self, c: usize) -> PaddedBands {
        self.gatherer.change(c, self.scratch)
    }
    /// The surroundings in it.
    pub(crate) fn sky(&self) -> SampledSky {
        SampledSky { radiosity: self.gatherer.sky_value(self.scratch), escaped: self.scratch.escaped }
    }
}

impl<'a> Gatherer<'a> {
    /// Prepares a gather. `power` holds the mean radiosity of every patch that connections are aimed by.
    pub(crate) fn new(
        tracer: &'a RayTracer<'a>,
        lights: Option<PathLights<'a>>,
        field: GatherField<'a>,
        brightness: &[f64],
    ) -> Gatherer<'a> {
        let zones = tracer.zones;
        let light = |(j, b): (usize, &f64)| {
            let p = &zones.patches[j];
            let centre = p.plate.centre();
            PatchLight {
                patch: j as u32,
                centre,
                radius: 0.5 * p.plate.diameter(),
                normal: p.normal,
                power: p.area * b,
            }
        };
        let list = brightness.iter().take(zones.patches.len()).enumerate().map(light).collect();
        let reflectance = match lights {
            Some(_) => parallel::map(&zones.patches, |p| padded(p.reflectance)),
            None => Vec::new(),
        };
        Gatherer {
            zones,
            tracer,
            path: ExpectedPath::new(tracer),
            lights,
            patch_lights: PatchLightTree::new(list, zones.patches.len()),
            openings: field.sky.map(|sky| PaneOpenings::new(tracer, &sky.shares[zones.pane_index(0)..])),
            reflectance,
            field,
        }
    }

    /// Prepares the connections of consecutive zones, with a cut of at most `nodes` nodes.
    pub(crate) fn aim(&self, together: Range<usize>, nodes: usize, scratch: &mut GatherScratch) {
        let receiver = match together.len() {
            1 => self.receiver(together.start),
            _ => enclosing_ball(together.map(|i| self.receiver(i))),
        };
        self.patch_lights.cut(&receiver, nodes, &mut scratch.cut);
        if let Some(openings) = &self.openings {
            openings.aim(&receiver, NODES_OF_OPENINGS.min(nodes), &mut scratch.openings_cut);
        }
    }

    fn receiver(&self, i: usize) -> ReceiverBall {
        let zone = self.zones.zone(i);
        let (radius, normal) = match zone {
            ZoneRef::Patch(p) => (0.5 * p.plate.diameter(), Some(p.normal)),
            ZoneRef::Voxel(_, v) => (0.5 * v.volume.cbrt(), None),
            ZoneRef::Pane(_, p) => (0.5 * p.plate.diameter(), None),
        };
        ReceiverBall { centre: zone.centre(), radius, normal }
    }

    /// Takes samples of a zone that [`Gatherer::aim`] has prepared; `each` receives them.
    pub(crate) fn samples(
        &self,
        range: SampleRange,
        scratch: &mut GatherScratch,
        mut each: impl FnMut(&ZoneSample),
    ) {
        let i = range.zone;
        let points = self.field.points.as_ref().filter(|_| range.direct == DirectReading::AtPoints);
        let seeds = low_discrepancy::split_mix64((i as u64) << 1 | range.half as u64 ^ GATHER_SEED);
        let seed = seeds as u32;
        for k in range.numbers.clone() {
            let u = scrambled_sobol::point(k, seed);
            scratch.collected.clear();
            scratch.vertices.clear();
            scratch.paths.clear();
            scratch.points.clear();
            scratch.ends.clear();
            scratch.textured.clear();
            scratch.textured_paths.clear();
            (scratch.typical, scratch.sky, scratch.escaped) = (Bands::ZERO, Bands::ZERO, Bands::ZERO);
            let from = self.start(i, [u[2], u[3], u[7]]);
            let ray = RayNumber { zone: i, number: k | GATHER_RAY | range.half << 23 };
            self.follow_ray(ray, &from, [u[0], u[1], u[6]], range.direct, scratch);
            let connection = RayNumber { number: ray.number | CONNECTION, ..ray };
            self.connect(connection, from.point, [u[4], u[5], u[6]], range.direct, scratch);
            if let Some(openings) = self.openings.as_ref().filter(|_| !scratch.openings_cut.is_dark()) {
                let [v0, v1, v2, _] = scrambled_sobol::further_dimensions(k, OPENINGS_PART, seed);
                self.connect_through(openings, i, from.point, [v0, v1, v2], scratch);
            }
            if let (Some(points), Some(place), Some(ray)) = (points, self.light_place(), &scratch.ray) {
                let GatherScratch { collected, ends, points: lit, .. } = scratch;
                let met = SampledZones { ray, collected, ends, path: &self.path, number: k, seed };
                points.add_points(place, &met, lit);
            }
            each(&ZoneSample { gatherer: self, scratch });
        }
    }

    /// Radiosity of the surroundings in column `c`, W/m².
    fn sky_radiosity(&self, c: usize) -> Bands {
        self.field.sky.filter(|sky| sky.column == c).map_or(Bands::ZERO, |sky| sky.radiosity)
    }

    /// The largest radiosity of every one of the first `columns`, the surroundings included, W/m².
    pub(crate) fn brightest(&self, columns: usize) -> Vec<Bands> {
        let of_column = |(c, b): (usize, &Vec<PaddedBands>)| {
            let most = |m: PaddedBands, b: &PaddedBands| std::array::from_fn(|k| m[k].max(b[k]));
            widened(b.iter().fold([0.0; LANES], most)).max(self.sky_radiosity(c))
        };
        self.field.columns[..columns].iter().enumerate().map(of_column).collect()
    }

    /// The mean radiosity that zone `i` would meet in its directions if nothing hid anything, in every one of the first `columns`, W/m²: the larger of two
    /// estimates, by patches as connections are aimed and by any zones; each is limited to the radiosity of the zone that it meets.
    pub(crate) fn unhidden_light(&self, i: usize, columns: usize, scratch: &mut GatherScratch) -> Vec<Bands> {
        let n = self.zones.len();
        let seed = low_discrepancy::split_mix64((i as u64) << 1 ^ UNHIDDEN_SEED) as u32;
        self.aim(i..i + 1, UNHIDDEN_SAMPLES, scratch);
        let mut sums = [vec![Bands::ZERO; columns], vec![Bands::ZERO; columns]];
        for k in 0..UNHIDDEN_SAMPLES {
            let u = scrambled_sobol::point(k, seed);
            let x = self.start(i, [u[2], u[3], u[7]]).point;
            let any = ((u[6] * n as f64) as usize).min(n - 1);
            let aimed = self.patch_lights.sample(&scratch.cut, u[0]);
            for (sum, chosen) in sums.iter_mut().zip([aimed, Some((any as u32, 1.0 / n as f64))]) {
                let Some((j, probability)) = chosen else { continue };
                let share = (self.unhidden_share(i, x, j as usize, [u[1], u[4]]) / probability).min(1.0);
                for (c, sum) in sum.iter_mut().enumerate() {
                    *sum += share * widened(self.field.columns[c][j as usize]).map(|b| b.max(0.0));
                }
            }
        }
        let [aimed, any] = sums;
        let larger =
            |(c, (a, b)): (usize, (Bands, Bands))| a.max(b) / UNHIDDEN_SAMPLES as f64 + self.sky_radiosity(c);
        aimed.into_iter().zip(any).enumerate().map(larger).collect()
    }

    /// Share of the directions of zone `i` at its point `x` in which a point of zone `j` stands for all of that, without what hides it.
    fn unhidden_share(&self, i: usize, x: Vec3, j: usize, u: [f64; 2]) -> f64 {
        let (y, normal, area) = if let Some(p) = self.zones.patches.get(j) {
            let [s, t] = p.plate.warp(u);
            (p.plate.at(s, t), Some(p.normal), p.area)
        } else {
            let ball = self.receiver(j);
            (ball.centre, None, PI * ball.radius * ball.radius)
        };
        let seen = SeenPoint::new(x, y, normal);
        // Points of one plane are in front of each other by rounding alone.
        if j != i && seen.distance > self.tracer.transport.epsilon() && seen.towards > MIN_COSINE {
            area * seen.density(self.kernel(i, seen.dir))
        } else {
            0.0
        }
    }

    /// Sum over rays of a zone that [`Gatherer::aim`] has prepared of the weight with which they leave the scene.
    pub(crate) fn escapes(&self, range: SampleRange, scratch: &GatherScratch) -> Bands {
        let (zones, transport, i) = (self.zones, self.tracer.transport, range.zone);
        let mut sum = Bands::ZERO;
        let Some(openings) = &self.openings else { return sum };
        let seed = low_discrepancy::split_mix64((i as u64) << 1 | range.half as u64 ^ ESCAPE_SEED) as u32;
        for k in range.numbers {
            let u = scrambled_sobol::point(k, seed);
            let from = self.start(i, [u[2], u[3], u[7]]);
            let ray = ray_from_point(zones, i, from.point, from.side, [u[0], u[1]]);
            let WeightedRay { origin, dir, weight } = ray;
            if let Some(transmittance) =
                transport.transmittance(origin, transport.exterior_point(origin, dir))
            {
                let density = openings.density(&scratch.openings_cut, origin, dir);
                sum += weight * transmittance * balance(self.kernel(i, dir), density);
            }
        }
        sum
    }

    /// The sum of column `c` over the zones and paths of a sample.
    #[inline]
    fn value(&self, c: usize, scratch: &GatherScratch) -> PaddedBands {
        let (typical, weight) = (self.field.typical[c], padded(scratch.typical));
        let mut sum: PaddedBands = std::array::from_fn(|k| weight[k] * typical[k]);
        if self.field.sky.is_some_and(|sky| sky.column == c) {
            let sky = padded(self.sky_value(scratch));
            (0..LANES).for_each(|k| sum[k] += sky[k]);
        }
        self.add_zones(c, &scratch.collected.zones, &mut sum);
        self.add_paths(c, &scratch.paths, &scratch.vertices, &mut sum);
        sum
    }

    /// Adds the radiosities of weighted zones in column `c`.
    #[inline]
    fn add_zones(&self, c: usize, zones: &[WeightedZone], sum: &mut PaddedBands) {
        for z in zones {
            let b = &self.field.columns[c][z.zone as usize];
            (0..LANES).for_each(|k| sum[k] += z.weight[k] * b[k]);
        }
    }

    /// Adds what weighted paths transport in column `c`.
    #[inline]
    fn add_paths(
        &self,
        c: usize,
        paths: &[(u32, PaddedBands)],
        vertices: &[PathVertex],
        sum: &mut PaddedBands,
    ) {
        let radiosity = &self.field.columns[c];
        for (end, weight) in paths {
            let Some(first) = vertex_index(*end) else { continue };
            let source = self.field.sources.get(c).copied();
            let field = PathField { vertices, reflectance: &self.reflectance, radiosity, source };
            let v = field.transported(first, *weight);
            (0..LANES).for_each(|k| sum[k] += v[k]);
        }
    }

    /// The change of column `c` in a sample by direct light at points.
    fn change(&self, c: usize, scratch: &GatherScratch) -> PaddedBands {
        let Some(points) = &self.field.points else { return [0.0; LANES] };
        let mut sum = points.change(c, &scratch.points);
        self.add_zones(c, &scratch.textured, &mut sum);
        self.add_paths(c, &scratch.textured_paths, &scratch.vertices, &mut sum);
        sum
    }

    /// Adds to the radiosities of column `c`, W/m².
    pub(crate) fn add_radiosity(&mut self, c: usize, more: &[PaddedBands]) {
        parallel::for_each_pair(&mut self.field.columns[c], more, |b, m| {
            (0..LANES).for_each(|k| b[k] += m[k]);
        });
    }

    /// True if direct light can be read at points.
    pub(crate) fn can_read_points(&self) -> bool {
        self.field.points.is_some()
    }

    /// The point of zone `i` for a point of the unit cube.
    fn start(&self, i: usize, u: [f64; 3]) -> RayStart {
        RayStart { point: point_in_zone(self.zones, self.tracer.transport, i, u), side: u[2] }
    }

    /// Follows one ray from a point of the zone in the direction of the first two numbers; the third places points in the medium.
    fn follow_ray(
        &self,
        ray: RayNumber,
        from: &RayStart,
        [d0, d1, jitter]: [f64; 3],
        direct: DirectReading,
        scratch: &mut GatherScratch,
    ) {
        let (i, tracer) = (ray.zone, self.tracer);
        let start = ray_from_point(self.zones, i, from.point, from.side, [d0, d1]);
        let WeightedRay { origin, dir, weight } = start;
        let end = tracer.first_surface(origin, dir);
        let pieces = match direct {
            DirectReading::AtPoints => Pieces::Kept,
            DirectReading::OfZones => Pieces::Dropped,
        };
        let left = weight * self.path.collect(&start, end.distance, jitter, pieces, &mut scratch.collected);
        scratch.ray = Some(start);
        if end.zone >= FIRST_CODE {
            if let Some(openings) = self.openings.as_ref().filter(|_| end.zone == ESCAPED) {
                let density = openings.density(&scratch.openings_cut, origin, dir);
                scratch.escaped = left * balance(self.kernel(i, dir), density);
                scratch.sky += scratch.escaped;
            }
            return;
        }
        let j = end.zone as usize;
        let towards = self.zones.patches[j].normal.dot(dir).abs().max(MIN_COSINE);
        let density = self.kernel(i, dir) * towards / (end.distance * end.distance).max(f64::MIN_POSITIVE);
        let share = balance(density, self.connection_density(&scratch.cut, i, j));
        self.add_surface(ray, end, left * share, direct, scratch);
        scratch.typical += left * (1.0 - share);
    }

    /// Adds the surface at the end of a ray or connection; paths go on from patches close by.
    fn add_surface(
        &self,
        ray: RayNumber,
        end: RayEnd,
        weight: Bands,
        direct: DirectReading,
        scratch: &mut GatherScratch,
    ) {
        let continues = ray.zone < self.zones.patches.len()
            && self.zones.patches[end.zone as usize].continues_rays(end.distance)
            && self.zones.sheets.opposite(end.zone as usize).is_none();
        let texture = match direct {
            DirectReading::AtPoints => self.tracer.texture_ratio(end.zone as usize, end.position),
            DirectReading::OfZones => Bands::ONE,
        };
        let of_texture = (texture != Bands::ONE).then(|| (texture - Bands::ONE) * weight);
        match self.lights.as_ref().filter(|_| continues) {
            Some(lights) => {
                let before = scratch.vertices.len();
                let (first, last) = self.tracer.continue_path(lights, ray, end, &mut scratch.vertices);
                scratch.paths.push((first, padded(weight)));
                scratch.textured_paths.extend(of_texture.map(|change| (first, padded(change))));
                if direct == DirectReading::AtPoints && last.zone < FIRST_CODE {
                    let passed = |w: Bands, v: &PathVertex| w * v.passed_on(&self.zones.patches);
                    let weight = scratch.vertices[before..].iter().fold(texture * weight, passed);
                    scratch.ends.push(surface_point(ray, &last, weight, Bands::ONE));
                }
            }
            None => {
                scratch.collected.zones.push(weighted_zone(end.zone, weight));
                scratch.textured.extend(of_texture.map(|change| weighted_zone(end.zone, change)));
                if direct == DirectReading::AtPoints {
                    scratch.ends.push(surface_point(ray, &end, weight, texture));
                }
            }
        }
    }

    /// The lights and what lies before them.
    fn light_place(&self) -> Option<LightPlace<'_>> {
        let (zones, transport) = (self.zones, self.tracer.transport);
        self.lights.as_ref().map(|lights| LightPlace { lights, transport, zones })
    }

    /// Connects the point `x` of zone `i` with the surroundings through a pane.
    fn connect_through(
        &self,
        openings: &PaneOpenings,
        i: usize,
        x: Vec3,
        u: [f64; 3],
        scratch: &mut GatherScratch,
    ) {
        let Some((dir, transmittance)) = openings.sample(&scratch.openings_cut, x, u) else { return };
        let kernel = self.kernel(i, dir);
        if kernel > 0.0 {
            let density = openings.density(&scratch.openings_cut, x, dir);
            scratch.sky += self.ray_weight(i, dir) * transmittance * (kernel / (kernel + density));
        }
    }

    /// Weight of a ray of zone `i`.
    fn ray_weight(&self, i: usize, dir: Vec3) -> Bands {
        match self.zones.zone(i) {
            ZoneRef::Pane(_, p) => pane_ray_weight(p, dir),
            _ => Bands::ONE,
        }
    }

    /// The radiation of the surroundings of the present sample, W/m².
    fn sky_value(&self, scratch: &GatherScratch) -> Bands {
        self.field.sky.map_or(Bands::ZERO, |sky| scratch.sky * sky.radiosity)
    }

    /// Density of the directions of zone `i`, 1/sr.
    fn kernel(&self, i: usize, dir: Vec3) -> f64 {
        match self.zones.zone(i) {
            ZoneRef::Patch(p) => p.normal.dot(dir).max(0.0) / PI,
            ZoneRef::Voxel(..) => 1.0 / (4.0 * PI),
            ZoneRef::Pane(_, p) => p.normal.dot(dir).abs() / (2.0 * PI),
        }
    }

    /// p_j/A_j of a connection of zone `i`, 1/m².
    fn connection_density(&self, cut: &LightCut, i: usize, j: usize) -> f64 {
        if i == j { 0.0 } else { self.patch_lights.probability(cut, j as u32) / self.zones.patches[j].area }
    }

    /// Connects the point `x` of zone `i` with a patch.
    fn connect(
        &self,
        ray: RayNumber,
        x: Vec3,
        u: [f64; 3],
        direct: DirectReading,
        scratch: &mut GatherScratch,
    ) {
        let (zones, i) = (self.zones, ray.zone);
        let Some((j, probability)) = self.patch_lights.sample(&scratch.cut, u[0]) else { return };
        let patch = &zones.patches[j as usize];
        if j as usize == i {
            return;
        }
        let [s, t] = patch.plate.warp([u[1], u[2]]);
        let y = patch.plate.at(s, t);
        let seen = SeenPoint::new(x, y, Some(patch.normal));
        let SeenPoint { distance, dir, towards } = seen;
        let kernel = self.kernel(i, dir);
        if !(towards > MIN_COSINE && kernel > 0.0 && distance > self.tracer.transport.epsilon()) {
            return;
        }
        let Some(transmittance) = self.tracer.transport.transmittance_inside(x, y) else { return };
        let share = balance(seen.density(kernel), probability / patch.area);
        let weight = self.ray_weight(i, dir) * transmittance * share;
        let end = RayEnd { zone: j, weight: PerBand::splat(1.0), distance, position: y };
        self.add_surface(ray, end, weight, direct, scratch);
        scratch.typical -= weight;
    }
}
