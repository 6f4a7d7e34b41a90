//! The medium on a grid of points, as fine as memory allows, for viewers that march through it.
//!
//! ```text
//!     B_g(x) = B_ind,g(x) + Ω/4 · G_dir,g(x)
//! ```
//!
//! A coarse voxel grid is refined by one factor along all axes: B_ind is the interpolated field of the renderer, and G_dir is sampled at
//! points of each part, so that shafts are narrower than cells. On a fine grid the values of the zones serve, and on a grid that is too
//! fine their means over blocks of cells. Points inside solids take the mean of their neighbours, so that interpolation does not
//! darken the medium before a wall. Direct light of suns may be left to viewers ([`SunlightMode`]). Cost: four shadow rays a part and light (32 for a sky that shares a group).

use super::baked::SunlightMode;
use super::group_fields::GroupField;
use super::lit_scene::LitScene;
use crate::medium::radiosity_field::RadiosityField;
use rayon::prelude::*;
use std::f64::consts::PI;
use zonal_math::parallel;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, Light, PerBand, Progress, Solution, VoxelGrid};
use zonal_transport::Transport;
use zonal_transport::lights::{LightSampler, Receiver};

/// Largest number of points along an axis: the least maximum size of 3D textures in WebGL 2.
const MAX_POINTS_PER_AXIS: usize = 256;
/// Largest number of parts of a cell along an axis.
const MAX_PARTS_PER_CELL: usize = 12;
/// Points of a part at which direct light is sampled.
const DIRECT_LIGHT_POINTS: usize = 4;
/// Samples at each point of a sky that shares a group.
const SKY_SAMPLES: usize = 8;

/// Size of the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeGridOptions {
    /// Largest number of points of a grid finer than the voxels; 500,000.
    pub max_refined_points: usize,
    /// Largest number of points of the grid: with more voxels, blocks of them become one point; 1,500,000.
    pub max_points: usize,
    /// Direct light of suns; baked.
    pub sunlight: SunlightMode,
}

impl Default for VolumeGridOptions {
    fn default() -> Self {
        let sunlight = SunlightMode::Baked;
        VolumeGridOptions { max_refined_points: 500_000, max_points: 1_500_000, sunlight }
    }
}

/// The medium on a regular grid; lists have one entry a point, z fastest, each point in the centre of its part of the box.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeGrid {
    /// Lower corner of the box, m.
    pub min: Vec3,
    /// Upper corner, m.
    pub max: Vec3,
    /// Points along x, y, z.
    pub dims: [usize; 3],
    /// Extinction κ, red, green and blue, 1/m; one entry where it is the same everywhere.
    pub extinction: Vec<[f32; 3]>,
    /// Scattering albedo Ω, red, green and blue; one entry where it is the same everywhere.
    pub albedo: Vec<[f32; 3]>,
    /// Radiosity B, direct light included but that of separate suns, red, green and blue, W/m²: `radiosity[group][point]`.
    pub radiosity: Vec<Vec<[f32; 3]>>,
}

/// Bakes the medium of a solution; `None` without one, or where it has no extinction.
///
/// ```
/// use zonal_render::bake::volume_grid::{VolumeGridOptions, bake_volume_grid};
/// # use zonal_math::{Vec3, vec3};
/// # use zonal_scene::{
/// #     Bands, Camera, Facet, Fields, Lens, NoProgress, Plate, Report, Scene, SceneParts, Sides, Solution,
/// #     Surface, VoxelGrid,
/// # };
/// # use zonal_transport::{Transport, build_zones};
/// # let wall = Surface {
/// #     name: "wall".into(),
/// #     reflectance: Bands::ZERO,
/// #     emission: Bands::ONE,
/// #     sides: Sides::Both,
/// #     ..Surface::default()
/// # };
/// # let plate = Plate::parallelogram(vec3(-9.0, 2.0, -9.0), vec3(18.0, 0.0, 0.0), vec3(0.0, 0.0, 18.0));
/// # let wall_facet = Facet { surface: 0, plate, uv: [[0.0; 2]; 3] };
/// # let mut grid = VoxelGrid::new(vec3(-1.0, 0.0, -1.0), vec3(1.0, 1.0, 1.0), [2, 2, 2]).unwrap();
/// # (0..8).for_each(|i| grid.set(i, Bands::splat(0.5), Bands::ZERO, Bands::ZERO, Bands::ZERO));
/// # let scene = Scene::new(SceneParts {
/// #     surfaces: vec![wall],
/// #     facets: vec![wall_facet],
/// #     voxel_grid: Some(grid.seal().unwrap()),
/// #     ..SceneParts::default()
/// # })
/// # .unwrap();
/// # let zones = build_zones(&scene, &Transport::new(&scene)).unwrap();
/// # let emission: Vec<Bands> = (0..zones.len()).map(|i| zones.emission(i)).collect();
/// # let zero = vec![Bands::ZERO; zones.len()];
/// # let mut fields = Fields::default();
/// # (fields.radiosity, fields.incident) = (emission, zero.clone());
/// # (fields.direct, fields.error) = (zero.clone(), zero);
/// # let (groups, report) = (Vec::new(), Report::default());
/// # let (scene_hash, version) = (String::new(), String::new());
/// # let solution = Solution { scene, zones, fields, groups, report, further_blocks: Vec::new(), scene_hash, version };
/// let options = VolumeGridOptions { max_refined_points: 64, ..VolumeGridOptions::default() };
/// let grid = bake_volume_grid(&solution, &options, &NoProgress).unwrap();
/// assert_eq!(grid.dims, [4, 4, 4]);
/// assert_eq!(grid.radiosity[0].len(), 64);
/// ```
pub fn bake_volume_grid(
    solution: &Solution,
    options: &VolumeGridOptions,
    progress: &dyn Progress,
) -> Option<VolumeGrid> {
    let map = solution.scene.voxel_grid()?;
    if solution.zones.voxels.distinct_media().all(|z| z.extinction == Bands::ZERO) {
        return None;
    }
    let transport = Transport::new(&solution.scene);
    let lit = LitScene::of(&solution.scene, options.sunlight);
    let shadow_rays = Transport::new(&lit.scene);
    let grid = PointGrid::new(map, options);
    let groups = GroupField::of_solution(solution);
    progress.begin("medium", groups.len() as u64);
    // Find the zones of each point, and the points inside solids that take values of their neighbours.
    let zones = grid.zones_of_points(solution, &transport);
    let known: Vec<bool> = zones.iter().map(|p| !p.is_empty()).collect();
    let order = extrapolation_order(&known, grid.dims);
    // Evaluate extinction and, group by group, radiosity.
    let extinction = grid.mean(&zones, |z| solution.zones.voxels.at(z).extinction);
    let albedo = grid.mean(&zones, |z| solution.zones.voxels.at(z).albedo);
    let source = GridSource {
        solution,
        transport: &transport,
        lit: &lit,
        shadow_rays: &shadow_rays,
        grid: &grid,
        zones: &zones,
    };
    let radiosity = groups
        .iter()
        .map(|group| {
            let mut values = source.radiosity(group);
            extrapolate(&mut values, &order);
            progress.advance(1);
            to_rgb(values)
        })
        .collect();
    progress.end();
    let (min, max) = (map.min(), map.max());
    let [extinction, albedo] = [extinction, albedo].map(|v| collapse_uniform(v, &known, &order));
    Some(VolumeGrid { min, max, dims: grid.dims, extinction, albedo, radiosity })
}

/// The grid: several points per cell, or several cells a point.
struct PointGrid<'a> {
    map: &'a VoxelGrid,
    dims: [usize; 3],
    /// Parts of a cell along an axis, or 1.
    parts: usize,
    /// Cells of a point along an axis, or 1.
    block: usize,
}

/// The zones of a point, each with the position at which it is evaluated.
type PointZones = Vec<(usize, Vec3)>;

impl<'a> PointGrid<'a> {
    fn new(map: &'a VoxelGrid, options: &VolumeGridOptions) -> PointGrid<'a> {
        let cells = map.dims();
        let fits = |n: [usize; 3], max_points: usize| {
            n.iter().product::<usize>() <= max_points && n.iter().all(|&x| x <= MAX_POINTS_PER_AXIS)
        };
        let refines = |k: &usize| fits(cells.map(|n| n * k), options.max_refined_points);
        let parts = (2..=MAX_PARTS_PER_CELL).rev().find(refines).unwrap_or(1);
        let max_points = options.max_points.max(1);
        let block = (1..).find(|m| fits(cells.map(|n| n.div_ceil(*m)), max_points)).unwrap_or(1);
        let dims = cells.map(|n| (n * parts).div_ceil(block));
        PointGrid { map, dims, parts, block }
    }

    fn coordinates(&self, i: usize) -> [usize; 3] {
        let [_, ny, nz] = self.dims;
        [i / (ny * nz), i / nz % ny, i % nz]
    }

    fn zones_of_points(&self, s: &Solution, transport: &Transport) -> Vec<PointZones> {
        let n = self.dims.iter().product();
        let of = |i: usize| {
            let at = self.coordinates(i);
            if self.parts == 1 { self.zones_of_block(s, at) } else { self.zone_of_part(s, transport, at) }
        };
        parallel::collect(n, of)
    }

    /// All zones of the cells of a point.
    fn zones_of_block(&self, s: &Solution, at: [usize; 3]) -> PointZones {
        let range = |k: usize| at[k] * self.block..((at[k] + 1) * self.block).min(self.map.dims()[k]);
        let mut out = Vec::new();
        for x in range(0) {
            for y in range(1) {
                for z in range(2) {
                    out.extend(
                        s.zones
                            .voxel_zones_of_cell(self.map.index([x, y, z]))
                            .map(|i| (i, s.zones.voxels.at(i).centre)),
                    );
                }
            }
        }
        out
    }

    /// The zone in the centre of a part of a cell.
    fn zone_of_part(&self, s: &Solution, transport: &Transport, at: [usize; 3]) -> PointZones {
        let cell = self.map.index(at.map(|x| x / self.parts));
        let p = self.point(at, vec3(0.5, 0.5, 0.5));
        if transport.may_lack_medium() && !transport.has_medium_at(p) {
            return Vec::new();
        }
        transport.volume_zone_at(&s.zones, cell, p).map(|z| (z, p)).into_iter().collect()
    }

    /// A point of a part; `offset` is in edges of the part.
    fn point(&self, at: [usize; 3], offset: Vec3) -> Vec3 {
        let edge = self.map.cell() * (self.block as f64 / self.parts as f64);
        self.map.min() + edge.scale(vec3(at[0] as f64, at[1] as f64, at[2] as f64) + offset)
    }

    /// Means over the zones of each point.
    fn mean(&self, zones: &[PointZones], value: impl Fn(usize) -> Bands + Sync) -> Vec<PerBand<f32>> {
        let of = |list: &PointZones| {
            let mut sum = Bands::ZERO;
            for &(zone, _) in list {
                sum += value(zone) / list.len() as f64;
            }
            sum.map(|x| x as f32)
        };
        parallel::map(zones, of)
    }
}

/// The data from which the values of the grid are computed.
struct GridSource<'a> {
    solution: &'a Solution,
    transport: &'a Transport<'a>,
    lit: &'a LitScene<'a>,
    /// Shadow rays in the lit scene.
    shadow_rays: &'a Transport<'a>,
    grid: &'a PointGrid<'a>,
    /// The zones of each point.
    zones: &'a [PointZones],
}

impl GridSource<'_> {
    /// B of one group.
    fn radiosity(&self, group: &GroupField) -> Vec<PerBand<f32>> {
        let s = self.solution;
        let voxels = &s.zones.voxels;
        // On a grid no finer than the voxels take the values of the zones.
        let has_separate_sun = self.lit.has_separate_sun(group.kind);
        if self.grid.parts == 1 && !has_separate_sun {
            return self.grid.mean(self.zones, |z| group.radiosity(s.zones.voxel_index(z)));
        }
        // Leave out the direct light that is sampled, and that of separate suns.
        let light_samplers = self.sampled_lights(group);
        let leaves_direct_out = has_separate_sun || !light_samplers.is_empty();
        let indirect = |i: usize| {
            let zone = s.zones.voxel_index(i);
            let (b, direct) = (group.radiosity(zone), group.direct(zone));
            b - if leaves_direct_out { voxels.at(i).albedo * direct / 4.0 } else { Bands::ZERO }
        };
        if self.grid.parts == 1 {
            return self.grid.mean(self.zones, |z| indirect(z) + self.direct_of_zone(&light_samplers, z));
        }
        let means = parallel::collect(voxels.len(), indirect);
        let Some(field) = RadiosityField::from_means(s, self.transport, means) else {
            return Vec::new();
        };
        // Add the direct light, sampled in each part.
        let at = |(i, list): (usize, &PointZones)| {
            let Some(&(zone, p)) = list.first() else { return PerBand::default() };
            let (b, at) = (field.at(zone, p), self.grid.coordinates(i));
            let direct: Bands = light_samplers.iter().map(|l| self.direct_fluence(l, at, zone)).sum();
            (b + voxels.at(zone).albedo * direct / 4.0).map(|x| x as f32)
        };
        self.zones.par_iter().enumerate().map(at).collect()
    }

    /// Ω/4 · G_dir of lights in the centre of a zone, W/m².
    fn direct_of_zone(&self, light_samplers: &[LightSampler], zone: usize) -> Bands {
        let v = self.solution.zones.voxels.at(zone);
        let fluence = |l: &LightSampler| {
            let samples = if l.light().fills_sphere() { SKY_SAMPLES } else { DIRECT_LIGHT_POINTS };
            l.gather(self.shadow_rays, v.centre, Receiver::Free, samples, 0) * self.softening(l, v.centre)
        };
        v.albedo * light_samplers.iter().map(fluence).sum::<Bands>() / 4.0
    }

    /// The lights of a group, unless the values of the zones are smooth enough.
    fn sampled_lights(&self, group: &GroupField) -> Vec<LightSampler<'_>> {
        if group.is_smooth() {
            return Vec::new();
        }
        self.lit.lights_of(group.kind).map(|l| LightSampler::new(&self.lit.scene, l)).collect()
    }

    /// G_dir of a light, W/m²: the mean over points of a part that lie in the same zone, the centres of every second of its eighths.
    fn direct_fluence(&self, light_sampler: &LightSampler, at: [usize; 3], zone: usize) -> Bands {
        const OCTANT_CENTRES: [[f64; 3]; DIRECT_LIGHT_POINTS] =
            [[0.25, 0.25, 0.25], [0.75, 0.75, 0.25], [0.75, 0.25, 0.75], [0.25, 0.75, 0.75]];
        let (s, transport) = (self.solution, self.transport);
        let cell = s.zones.voxels.at(zone).cell;
        let samples = if light_sampler.light().fills_sphere() { SKY_SAMPLES } else { 1 };
        let softened = |p: Vec3| self.softening(light_sampler, p);
        let (mut sum, mut n) = (Bands::ZERO, 0.0);
        for (i, [x, y, z]) in OCTANT_CENTRES.into_iter().enumerate() {
            let p = self.grid.point(at, vec3(x, y, z));
            if transport.volume_zone_at(&s.zones, cell, p) == Some(zone) {
                let one = light_sampler.gather(self.shadow_rays, p, Receiver::Free, samples, i as u64);
                sum += one * softened(p);
                n += 1.0;
            }
        }
        if n > 0.0 {
            sum / n
        } else {
            let p = self.grid.point(at, vec3(0.5, 0.5, 0.5));
            light_sampler.gather(self.shadow_rays, p, Receiver::Free, samples, 0) * softened(p)
        }
    }

    /// [`softening`] at a point that stands for a part of a cell.
    fn softening(&self, light_sampler: &LightSampler, p: Vec3) -> f64 {
        let volume = self.grid.map.cell().product() / (self.grid.parts as f64).powi(3);
        softening(light_sampler.light(), p, volume)
    }
}

/// Factor of the fluence of a light at a point that stands for a volume, m³: beside a light without extent 1/r² is at most its mean over the ball of the volume
/// about the light, 3/R².
pub(super) fn softening(light: &Light, p: Vec3, volume: f64) -> f64 {
    let Some((position, ..)) = light.point() else { return 1.0 };
    let ball = (volume * 3.0 / (4.0 * PI)).powf(2.0 / 3.0) / 3.0;
    ((p - position).length2() / ball).min(1.0)
}

/// Points without a zone beside others that have a value, in the order of extrapolation, each with the points of which it takes the mean.
pub(super) fn extrapolation_order(known: &[bool], dims: [usize; 3]) -> Vec<(usize, Vec<usize>)> {
    let step = [dims[1] * dims[2], dims[2], 1];
    let mut have = known.to_vec();
    let mut order: Vec<(usize, Vec<usize>)> = Vec::new();
    for _ in 0..2 {
        let start = order.len();
        for i in (0..have.len()).filter(|&i| !have[i]) {
            let at = [i / step[0], i / step[1] % dims[1], i % dims[2]];
            let around = (0..3).flat_map(|k| {
                let below = (at[k] > 0).then(|| i - step[k]);
                [below, (at[k] + 1 < dims[k]).then(|| i + step[k])]
            });
            let list: Vec<usize> = around.flatten().filter(|&j| have[j]).collect();
            if !list.is_empty() {
                order.push((i, list));
            }
        }
        order[start..].iter().for_each(|(i, _)| have[*i] = true);
    }
    order
}

/// Gives each point of the list the mean of its neighbours.
pub(super) fn extrapolate(values: &mut [PerBand<f32>], order: &[(usize, Vec<usize>)]) {
    for (i, from) in order {
        values[*i] =
            PerBand::from_fn(|b| from.iter().map(|&j| values[j][b]).sum::<f32>() / from.len() as f32);
    }
}

/// One entry where all points with a zone agree, else all points.
fn collapse_uniform(
    mut values: Vec<PerBand<f32>>,
    known: &[bool],
    order: &[(usize, Vec<usize>)],
) -> Vec<[f32; 3]> {
    let mut own = values.iter().zip(known).filter(|(_, k)| **k).map(|(v, _)| *v);
    if let Some(first) = own.next()
        && own.all(|v| v == first)
    {
        return vec![first.into_rgb()];
    }
    extrapolate(&mut values, order);
    to_rgb(values)
}

fn to_rgb(values: Vec<PerBand<f32>>) -> Vec<[f32; 3]> {
    values.into_iter().map(PerBand::into_rgb).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{furnace, medium, quad, solution, surface};
    use zonal_scene::{NoProgress, SceneParts};

    fn options(max_refined_points: usize, max_points: usize) -> VolumeGridOptions {
        VolumeGridOptions { max_refined_points, max_points, ..VolumeGridOptions::default() }
    }

    /// Fluence 4 and albedo ½, no emission: B = ½.
    #[test]
    fn furnace_is_uniform_at_every_resolution() {
        let s = solution(furnace(), |_, _| 1.0, |_| 1.0);
        for (size, dims) in [
            (options(6000, 1000), [21, 18, 15]),
            (options(0, 1000), [7, 6, 5]),
            (options(0, 100), [4, 3, 3]),
            (options(0, 1), [1, 1, 1]),
        ] {
            let h = bake_volume_grid(&s, &size, &NoProgress).unwrap();
            assert_eq!(h.dims, dims);
            assert_eq!((h.radiosity.len(), h.extinction.len()), (1, 1));
            assert!(h.radiosity[0].iter().flatten().all(|b| (b - 0.5).abs() < 1e-6));
            assert!(h.extinction[0].iter().all(|k| (k - 1.3).abs() < 1e-6));
        }
    }

    #[test]
    fn shaft_is_as_narrow_as_its_opening() {
        let (lo, hi) = (vec3(0.0, 0.0, 0.0), vec3(2.0, 2.0, 2.0));
        let parts = SceneParts {
            surfaces: vec![surface("board", 0.0, 0.0)],
            facets: vec![quad(0, vec3(-1.0, -1.0, 1.5), vec3(1.75, 0.0, 0.0), vec3(0.0, 4.0, 0.0))],
            lights: vec![Light::Sun {
                name: "sun".into(),
                direction: vec3(0.0, 0.0, -1.0),
                irradiance: Bands::splat(8.0),
                angular_diameter: 0.0,
            }],
            voxel_grid: Some(medium(lo, hi, [2, 2, 2], 0.1, 0.5)),
            ..SceneParts::default()
        };
        let s = solution(parts, |_, _| 0.0, |_| 0.0);
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| bake_volume_grid(&s, &options(4096, 4096), &NoProgress).unwrap())
        };
        let h = run(1);
        assert_eq!(h, run(3));
        assert_eq!(h.dims, [16; 3]);
        let own = s.zones.emission(s.zones.voxel_offset()).first();
        for (i, b) in h.radiosity[0].iter().enumerate() {
            let [x, _, z] = [i / 256, i / 16 % 16, i % 16].map(|k| (k as f64 + 0.5) / 8.0);
            let lit = if x < 0.75 && z < 1.5 { 0.0 } else { 8.0 * (-0.1 * (2.0 - z)).exp() };
            let expected = own + 0.5 / 4.0 * lit;
            assert!((b[0] as f64 - expected).abs() < 1e-4, "{x} {z}: {} {expected}", b[0]);
        }
    }
}
