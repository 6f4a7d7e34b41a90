//! Scenes and measures shared by several tests.
#![allow(dead_code, missing_docs)]

pub(crate) mod lit_rooms;
pub(crate) mod thread_ranks;

use zonal_exchange::pair::{Exchange, PairCounts};
use zonal_io::input::parse_scene;
use zonal_math::{Vec3, vec3};
use zonal_scene::{
    BandFractions, Bands, Facet, Fields, NoProgress, PerBand, Plate, Report, Scene, SceneParts, Solution,
    Surface, Zones,
};
use zonal_solve::context::SolveContext;
use zonal_solve::distribution::{Communicator, Execution};
use zonal_solve::right_hand_side::direct_light::illumination::{PowerNormalization, illuminate};
use zonal_solve::right_hand_side::light_groups::{SourceGroup, select_groups};
use zonal_solve::right_hand_side::surroundings::SurroundingsExchange;
use zonal_solve::{SolveSettings, solve_zones};
use zonal_transport::{Transport, build_zones};

pub(crate) fn read(text: &str) -> Scene {
    parse_scene(text, None, "test.toml").unwrap_or_else(|e| panic!("{e}"))
}

pub(crate) fn solve(scene: Scene) -> Solution {
    zonal_solve::solve(scene, 4 << 30, &NoProgress).unwrap_or_else(|e| panic!("{e}"))
}

pub(crate) fn solved(text: &str) -> Solution {
    solve(read(text))
}

/// Zones, fields and report of a scene.
pub(crate) fn solved_zones(scene: &Scene) -> (Zones, Fields, Report) {
    let transport = Transport::new(scene);
    let zones = build_zones(scene, &transport).unwrap();
    let (fields, _, report) =
        solve_zones(scene, &zones, &transport, &SolveSettings::new(4 << 30, &NoProgress))
            .unwrap_or_else(|e| panic!("{e}"));
    (zones, fields, report)
}

/// Wall `face` (x low, x high, y low, …) of the box at `min` of this size, looking inwards.
pub(crate) fn wall(face: usize, min: Vec3, size: Vec3) -> Plate {
    let (axis, high) = (face / 2, face % 2 == 1);
    let [b, c] = if high { [(axis + 2) % 3, (axis + 1) % 3] } else { [(axis + 1) % 3, (axis + 2) % 3] };
    let along = |k: usize| {
        let mut e = [0.0; 3];
        e[k] = size[k];
        Vec3::from_array(e)
    };
    let origin = if high { min + along(axis) } else { min };
    Plate::parallelogram(origin, along(b), along(c))
}

/// The unit room with equal walls.
pub(crate) fn unit_room(solve: &str, walls: &str, rest: &str) -> String {
    format!(
        "[solve]\n{solve}\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\n{walls}\n{rest}\n"
    )
}

/// A lamp over a floor, and a sheet 5 cm above the floor, too high for the mesher to cut the floor along its shadow: a square of
/// 0.2 m about the centre of the floor, turned by 30°.
const SHEET_OVER_FLOOR: &str = r#"
[[surface]]
name = "lamp"
rectangle = { origin = [-1,-1,2], edge1 = [0,2,0], edge2 = [2,0,0] }
reflectance = 0
emission = 1
sides = "front"
[[light]]
kind = "emitter"
surface = "lamp"
[[surface]]
name = "floor"
rectangle = { origin = [-0.4,-0.4,0], edge1 = [0.8,0,0], edge2 = [0,0.8,0] }
reflectance = 0.8
sides = "front"
patch_size = FLOOR
[[surface]]
name = "sheet"
rectangle = { origin = [-0.0366,-0.1366,0.05], edge1 = [-0.1,0.1732,0], edge2 = [0.1732,0.1,0] }
reflectance = 0.8
sides = "both"
patch_size = 0.05
"#;

/// A lamp, a floor of this patch size and a sheet over it, for the dense engine.
pub(crate) fn sheet_over_floor(floor: &str) -> Scene {
    read(&format!(
        "[solve]\nengine = \"dense\"\nclosure = \"measure\"\n{}",
        SHEET_OVER_FLOOR.replace("FLOOR", floor)
    ))
}

/// Largest relative distance of H from `m` on patches and of G from 4 `m` in volumes and panes, over all bands.
pub(crate) fn unlevel(s: &Solution, m: f64) -> (f64, f64) {
    let all = unlevels(s, m);
    let worst = |x: &[f64]| x.iter().fold(0.0f64, |w, x| if x.is_nan() { f64::NAN } else { w.max(*x) });
    let (h, g) = all.split_at(s.zones.voxel_offset());
    (worst(h), worst(g))
}

/// The same for each zone, of the worst band.
pub(crate) fn unlevels(s: &Solution, m: f64) -> Vec<f64> {
    let want = |i: usize| if i < s.zones.voxel_offset() { m } else { 4.0 * m };
    let off = |(i, x): (usize, &Bands)| {
        x.iter().fold(0.0f64, |w, x| if x.is_nan() { *x } else { w.max((x / want(i) - 1.0).abs()) })
    };
    s.fields.incident.iter().enumerate().map(off).collect()
}

/// Root mean square of [`unlevels`], weighted by area among patches and by volume among the others.
pub(crate) fn unlevel_rms(s: &Solution, m: f64) -> (f64, f64) {
    let off = unlevels(s, m);
    let n = s.zones.voxel_offset();
    let size = |i: usize| {
        if i < n {
            s.zones.patches[i].area
        } else if i < s.zones.pane_offset() {
            s.zones.voxels.at(i - n).volume
        } else {
            let p = &s.zones.panes[i - s.zones.pane_offset()];
            p.area * p.thickness
        }
    };
    let rms = |from: usize, to: usize| {
        let all: f64 = (from..to).map(size).sum();
        ((from..to).map(|i| size(i) * off[i] * off[i]).sum::<f64>() / all.max(1e-300)).sqrt()
    };
    (rms(0, n), rms(n, s.zones.len()))
}

/// Indices of the patches of the surface whose name ends so.
pub(crate) fn patches_of(s: &Solution, name: &str) -> Vec<usize> {
    (0..s.zones.patches.len())
        .filter(|&i| s.scene.surfaces()[s.zones.patches[i].surface].name.ends_with(name))
        .collect()
}

/// Area mean of the first band of a field over patches.
pub(crate) fn mean(s: &Solution, field: &[Bands], patches: &[usize]) -> f64 {
    let area: f64 = patches.iter().map(|&i| s.zones.patches[i].area).sum();
    patches.iter().map(|&i| field[i].first() * s.zones.patches[i].area).sum::<f64>() / area
}

pub(crate) fn surface(name: &str, rho: f64, emission: f64, solid: bool) -> Surface {
    Surface {
        name: name.into(),
        reflectance: Bands::splat(rho),
        emission: Bands::splat(emission),
        solid,
        ..Surface::default()
    }
}

/// Adds a surface made of plates.
pub(crate) fn add(parts: &mut SceneParts, s: Surface, plates: &[Plate]) {
    let surface = parts.surfaces.len();
    parts.surfaces.push(s);
    parts.facets.extend(plates.iter().map(|p| Facet {
        surface,
        plate: *p,
        uv: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
    }));
}

/// A tilted tetrahedron, normals outward.
pub(crate) fn tetrahedron(c: Vec3, size: f64) -> Vec<Plate> {
    let p = [vec3(0.9, 0.2, -0.5), vec3(-0.6, 0.8, -0.3), vec3(-0.4, -0.9, -0.2), vec3(0.1, 0.1, 1.0)]
        .map(|v| c + v * size);
    [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].map(|[i, j, k]| Plate::triangle(p[i], p[j], p[k])).to_vec()
}

/// The owned parts of a scene, for queries of its factors.
pub(crate) fn with_exchange<T>(scene: &Scene, ask: impl FnOnce(&Zones, &Transport, &Exchange) -> T) -> T {
    let transport = Transport::new(scene);
    let zones = build_zones(scene, &transport).unwrap();
    let exchange = Exchange::new(scene, &zones, &transport);
    ask(&zones, &transport, &exchange)
}

/// Fields and report with a number of threads.
pub(crate) fn on_threads(scene: &Scene, threads: usize) -> (Fields, Report) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let transport = Transport::new(scene);
        let zones = build_zones(scene, &transport).unwrap();
        let (fields, _, report) =
            solve_zones(scene, &zones, &transport, &SolveSettings::new(4 << 30, &NoProgress)).unwrap();
        (fields, report)
    })
}

pub(crate) fn count() -> PairCounts {
    PairCounts::default()
}

/// Calls `use_it` with a context without escaping power.
pub(crate) fn with_site(scene: &Scene, use_it: impl FnOnce(&SolveContext, &SurroundingsExchange)) {
    let transport = Transport::new(scene);
    let zones = build_zones(scene, &transport).unwrap_or_else(|e| panic!("{e}"));
    let escape = SurroundingsExchange::unmeasured(&zones);
    let sources: Vec<SourceGroup> = select_groups(scene, &zones).0;
    let direct = illuminate(&zones, &transport, PowerNormalization::None, Execution::alone(&NoProgress));
    let site = SolveContext {
        scene,
        zones: &zones,
        transport: &transport,
        images: None,
        direct: &direct,
        sources: &sources,
        settings: SolveSettings::new(1 << 30, &NoProgress),
    };
    use_it(&site, &escape);
}

/// Three bands of water vapour and carbon dioxide: polynomials after Smith, Shen and Friedman, the third band as the remainder.
pub(crate) fn gas() -> BandFractions {
    let a = vec![6.508e-1, -5.551e-4, 3.029e-7, -5.353e-11];
    let b = vec![-0.2504e-1, 6.112e-4, -3.882e-7, 6.528e-11];
    let mut rest: Vec<f64> = a.iter().zip(&b).map(|(a, b)| -a - b).collect();
    rest[0] += 1.0;
    BandFractions::GreyGases {
        all_bands: None,
        coefficients: PerBand::from_rgb([a, b, rest]),
        range: [600.0, 2400.0],
        allow_partial: false,
    }
}
