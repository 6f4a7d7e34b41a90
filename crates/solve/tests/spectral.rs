//! The spectral engine against the dense engine and against physical laws.

use crate::common;

use common::{solved_zones as solved, surface, wall};
use zonal_math::{Vec3, vec3};
use zonal_scene::{
    Band, Bands, Engine, Facet, Fields, NoProgress, PatchRule, Scene, SceneParts, SolveOptions, Surroundings,
    Texture, VoxelGrid, ZoneBasis, Zones,
};
use zonal_solve::device::basis::BasisOrder;
use zonal_solve::distribution::Execution;
use zonal_solve::engines::problem_size::{ProblemSize, is_open};
use zonal_solve::engines::selection::{EngineChoice, select_engine};
use zonal_solve::engines::spectral::SpectralOperator;
use zonal_solve::engines::spectral::cpu::Processor;
use zonal_solve::engines::spectral::enclosure::BoxEnclosure;
use zonal_solve::{ExchangeOperator, SolveSettings, solve_zones};
use zonal_transport::{Transport, build_zones};

/// Pseudo-random numbers in [0, 1).
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
    fn bands(&mut self) -> Bands {
        Bands::from_fn(|_| self.next())
    }
}

/// Pseudo-random strengths.
pub(crate) fn dice(n: usize, seed: u64) -> Vec<Bands> {
    let mut dice = Dice(seed);
    (0..n).map(|_| dice.bands()).collect()
}

/// A box of cells with random textures on the walls, and random albedo, emission and sources in the cells.
#[derive(Clone)]
pub(crate) struct Room {
    cells: [usize; 3],
    edges: [f64; 3],
    kappa: Bands,
    pub(crate) periodic: [bool; 3],
    omit: Vec<usize>,
    engine: Engine,
}

impl Room {
    fn new(cells: [usize; 3], edges: [f64; 3], kappa: Bands) -> Room {
        Room { cells, edges, kappa, periodic: [false; 3], omit: Vec::new(), engine: Engine::Spectral }
    }
    pub(crate) fn parts(&self) -> SceneParts {
        let size = Vec3::from_array([0, 1, 2].map(|k| self.cells[k] as f64 * self.edges[k]));
        let min = vec3(-0.3, 0.7, 2.0);
        let mut dice = Dice(7);
        let mut parts = SceneParts {
            options: SolveOptions {
                patch_rule: PatchRule::Voxels,
                engine: self.engine,
                residual: 1e-14,
                zone_basis: ZoneBasis::Constant,
                ..SolveOptions::default()
            },
            periodic: self.periodic,
            ..SceneParts::default()
        };
        for face in (0..6).filter(|f| !self.periodic[f / 2] && !self.omit.contains(f)) {
            let mut texture = || Texture {
                width: 5,
                height: 4,
                pixels: (0..20).map(|_| dice.bands().to_rgb().map(|x| x as f32)).collect(),
            };
            parts.textures.extend([texture(), texture()]);
            let n = parts.textures.len();
            let mut s = surface(&format!("wall{face}"), 0.9, 3.0, false);
            (s.reflectance_texture, s.emission_texture) = (Some(n - 2), Some(n - 1));
            parts.surfaces.push(s);
            parts.facets.push(Facet {
                surface: parts.surfaces.len() - 1,
                plate: wall(face, min, size),
                uv: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            });
        }
        let mut map = VoxelGrid::new(min, Vec3::from_array(self.edges), self.cells).unwrap();
        for i in 0..map.len() {
            let source = dice.bands().map(|x| if x > 0.7 { x } else { 0.0 });
            map.set(i, self.kappa, 0.95 * dice.bands(), dice.bands(), source * self.kappa.min(Bands::ONE));
        }
        parts.voxel_grid = Some(map.seal().unwrap());
        parts
    }
    pub(crate) fn scene(&self) -> Scene {
        Scene::new(self.parts()).unwrap_or_else(|e| panic!("{e}"))
    }
    fn with(&self, engine: Engine) -> Room {
        Room { engine, ..self.clone() }
    }
}

fn operator(scene: &Scene) -> (Zones, SpectralOperator<'static>) {
    let transport = Transport::new(scene);
    let zones = build_zones(scene, &transport).unwrap();
    let found = BoxEnclosure::find(scene, &zones).unwrap_or_else(|e| panic!("{e}"));
    let s =
        SpectralOperator::new(found, &zones, BasisOrder::Constant, &Processor, Execution::alone(&NoProgress));
    (zones, s)
}

/// Largest relative difference of the incident fields and of the radiosities.
pub(crate) fn apart(a: &Fields, b: &Fields) -> f64 {
    let of = |a: &[Bands], b: &[Bands]| {
        let pairs = a.iter().flatten().zip(b.iter().flatten());
        pairs.fold(0.0f64, |m, (x, y)| m.max((x - y).abs() / y.abs().max(1e-300)))
    };
    of(&a.incident, &b.incident).max(of(&a.radiosity, &b.radiosity))
}

const EDGES: [f64; 3] = [0.11, 0.17, 0.07];

fn like_dense(room: &Room) {
    let [(_, spectral, report), (_, dense, pairs)] =
        [Engine::Spectral, Engine::Dense].map(|e| solved(&room.with(e).scene()));
    assert_eq!((report.engine.as_str(), pairs.engine.as_str()), ("spectral", "dense"));
    let off = apart(&spectral, &dense);
    assert!(off < 1e-10, "{:?}: {off:e}", room.periodic);
    // The residual of the balance, and the stated error, which covers it.
    assert!(report.energy.residual.iter().all(|r| r.abs() < 1e-11), "{:?}", report.energy.residual);
    for i in 0..dense.incident.len() {
        let stated = spectral.error[i] + 3e-11 * dense.incident[i];
        let difference = (spectral.incident[i] - dense.incident[i]).abs();
        assert!(Band::all().all(|b| difference[b] <= stated[b]), "{i}: {difference:?} {stated:?}");
    }
}

// Guards (numbers): the spectral engine equals the dense one to 1e-10 on every zone, periodic or not.
#[test]
fn cuboid_zones_agree_with_the_dense_engine() {
    like_dense(&Room::new([12, 9, 7], EDGES, Bands::from_rgb([1.5, 1.5, 4.0])));
}

#[test]
fn cubic_zones_agree_with_the_dense_engine() {
    like_dense(&Room::new([6, 6, 6], [0.25; 3], Bands::from_rgb([0.7, 2.0, 0.0])));
}

// Guards (numbers): the spectral engine equals the dense one to 1e-10 on every zone, periodic or not.
#[test]
fn periodic_zones_agree_with_the_dense_engine() {
    for periodic in [[true, false, false], [false, true, false], [false, false, true]] {
        like_dense(&Room { periodic, ..Room::new([12, 9, 7], EDGES, Bands::splat(7.0)) });
    }
    for periodic in [[true, true, false], [true, false, true], [false, true, true]] {
        like_dense(&Room { periodic, ..Room::new([5, 4, 3], EDGES, Bands::from_rgb([20.0, 20.0, 30.0])) });
    }
    // Almost no medium, and none.
    for periodic in [[true, false, false], [false, true, true]] {
        like_dense(&Room { periodic, ..Room::new([5, 4, 3], EDGES, Bands::from_rgb([1e-4, 0.0, 1e-12])) });
    }
}

/// Closed, open, periodic rooms, with an odd and a single cell among their counts.
pub(crate) fn rooms() -> Vec<Room> {
    let plain = Room::new([7, 10, 5], EDGES, Bands::from_rgb([1.5, 6.0, 1.5]));
    vec![
        plain.clone(),
        Room { omit: vec![1, 2], ..plain.clone() },
        Room::new([1, 6, 3], [0.3, 0.1, 0.2], Bands::splat(2.0)),
        Room { periodic: [true, false, false], ..plain.clone() },
        Room {
            periodic: [false, true, true],
            ..Room::new([6, 5, 8], EDGES, Bands::from_rgb([9.0, 9.0, 12.0]))
        },
        Room { periodic: [true, true, false], ..Room::new([1, 1, 12], [0.5, 0.5, 0.1], Bands::splat(3.0)) },
    ]
}

// Guards (numbers): reciprocity, closure and the isothermal enclosure hold to 1e-12 in the spectral engine.
#[test]
fn reciprocity_and_closure() {
    for room in rooms() {
        let scene = room.scene();
        let (zones, s) = operator(&scene);
        let [x, y] = [11, 12].map(|seed| dice(zones.len(), seed));
        let (gx, gy) = (s.apply(&x), s.apply(&y));
        for b in Band::all() {
            let dot = |a: &[Bands], c: &[Bands]| a.iter().zip(c).map(|(a, c)| a[b] * c[b]).sum::<f64>();
            let (left, right) = (dot(&x, &gy), dot(&gx, &y));
            assert!((left - right).abs() < 1e-12 * left, "{left} {right}");
        }
        let strength: Vec<Bands> =
            (0..zones.len()).map(|i| zonal_exchange::pair::scaled_radiosity_coefficient(&zones, i)).collect();
        let (rows, open) = (s.apply(&strength), s.opening_factors());
        for i in 0..zones.len() {
            let t = zonal_exchange::pair::closure_target(&zones, i);
            let row = rows[i] + open[i];
            assert!((row / t - 1.0).abs().all(|x| x < 1e-12), "{:?} {i}: {row:?} {t}", room.periodic);
        }
    }
}

#[test]
fn isothermal_enclosure_is_uniform() {
    for room in rooms() {
        let mut parts = room.parts();
        for s in &mut parts.surfaces {
            (s.reflectance_texture, s.emission_texture) = (None, None);
            (s.reflectance, s.emission) =
                (Bands::from_rgb([0.25, 0.5, 0.75]), Bands::from_rgb([0.75, 0.5, 0.25]));
        }
        parts.surroundings =
            Surroundings { radiance: Bands::splat(std::f64::consts::FRAC_1_PI), ..Surroundings::default() };
        let map = parts.voxel_grid.as_mut().unwrap();
        map.fill(room.kappa, Bands::from_rgb([0.6, 0.0, 1.0]), Bands::ONE, Bands::ZERO);
        let (zones, fields, report) = solved(&Scene::new(parts).unwrap());
        for (i, x) in fields.incident.iter().enumerate() {
            let want = if i < zones.voxel_offset() { 1.0 } else { 4.0 };
            assert!(x.iter().all(|x| (x / want - 1.0).abs() < 1e-12), "{:?} {i}: {x:?}", room.periodic);
        }
        assert!(report.energy.residual.iter().all(|r| r.abs() < 1e-12), "{:?}", report.energy.residual);
    }
}

#[test]
fn light_has_the_symmetry_of_the_room() {
    // Equal walls, cubic cells and a uniform medium have 48 symmetries, permutations and reversals of the axes.
    let mut parts = Room::new([6; 3], [0.2; 3], Bands::splat(2.0)).parts();
    for s in &mut parts.surfaces {
        (s.reflectance_texture, s.emission_texture) = (None, None);
    }
    parts.voxel_grid.as_mut().unwrap().fill(
        Bands::splat(2.0),
        Bands::splat(0.7),
        Bands::splat(0.4),
        Bands::ZERO,
    );
    let (zones, fields, _) = solved(&Scene::new(parts).unwrap());
    let g = |c: [usize; 3]| fields.incident[zones.voxel_offset() + (c[0] * 6 + c[1]) * 6 + c[2]].first();
    for c in [[0, 1, 2], [1, 1, 0], [2, 0, 0]] {
        let [x, y, z] = c;
        for other in [[y, z, x], [x, z, y], [5 - x, y, z], [x, 5 - y, 5 - z], [5 - z, x, 5 - y]] {
            assert!((g(c) / g(other) - 1.0).abs() < 1e-12, "{c:?} {other:?}");
        }
    }
}

// Guards (determinism): solutions of the spectral engine do not depend on the number of threads (on one machine: transforms use its instruction set).
#[test]
fn threads_do_not_change_a_bit() {
    let scene = Room::new([9, 20, 6], EDGES, Bands::from_rgb([1.5, 4.0, 1.5])).scene();
    let one = common::on_threads(&scene, 1);
    let four = common::on_threads(&scene, 4);
    assert!(one.0 == four.0 && one.1 == four.1);
}

#[test]
fn unsuitable_scenes_are_refused_with_a_reason() {
    let room = Room::new([3, 4, 5], EDGES, Bands::ONE);
    let refused = |change: &dyn Fn(&mut SceneParts)| {
        let mut parts = room.parts();
        change(&mut parts);
        let scene = Scene::new(parts).unwrap();
        let transport = Transport::new(&scene);
        let zones = build_zones(&scene, &transport).unwrap();
        solve_zones(&scene, &zones, &transport, &SolveSettings::new(4 << 30, &NoProgress))
            .unwrap_err()
            .to_string()
    };
    let told = refused(&|p| {
        let map = p.voxel_grid.as_mut().unwrap();
        map.set(7, Bands::from_rgb([1.0, 2.0, 1.0]), Bands::splat(0.5), Bands::ZERO, Bands::ZERO);
        *map = map.clone().seal().unwrap();
    });
    assert!(told.contains("spectral does not apply: the extinction varies in band 1"), "{told}");
    let told = refused(&|p| p.voxel_grid = None);
    assert!(told.contains("there is no medium"), "{told}");
    let told = refused(&|p| p.options.patch_rule = PatchRule::Edge);
    assert!(told.contains("'wall0'") && told.contains("patch_rule = \"voxels\""), "{told}");
    let told = refused(&|p| p.facets.push(Facet { surface: 2, ..p.facets[0] }));
    assert!(told.contains("lies on another") || told.contains("no face of a voxel"), "{told}");
    // Insufficient memory is reported before the computation.
    let scene = Room::new([20, 20, 20], EDGES, Bands::ONE).scene();
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport).unwrap();
    let told = solve_zones(&scene, &zones, &transport, &SolveSettings::new(1 << 20, &NoProgress))
        .unwrap_err()
        .to_string();
    assert!(told.contains("--max-memory"), "{told}");
}

#[test]
fn periodic_scenes_require_engines_with_images() {
    let room = Room { periodic: [true, false, false], ..Room::new([3, 4, 5], EDGES, Bands::splat(9.0)) };
    let refused = |room: &Room| {
        let scene = room.scene();
        let transport = Transport::new(&scene);
        let zones = build_zones(&scene, &transport).unwrap();
        let job = SolveSettings::new(4 << 30, &NoProgress);
        solve_zones(&scene, &zones, &transport, &job).unwrap_err().to_string()
    };
    assert!(refused(&room.with(Engine::Rays)).contains("boundary"));
    assert!(refused(&Room { omit: vec![2], ..room.with(Engine::Dense) }).contains("boundary"));
    // Walls across periodic axes are refused.
    let mut parts = Room { periodic: [false; 3], ..room.clone() }.parts();
    parts.periodic = [true, false, false];
    let scene = Scene::new(parts).unwrap();
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport).unwrap();
    let told = solve_zones(&scene, &zones, &transport, &SolveSettings::new(4 << 30, &NoProgress))
        .unwrap_err()
        .to_string();
    assert!(told.contains("'wall0' stands across"), "{told}");
}

#[test]
fn auto_selects_spectral_for_many_zones_or_gives_the_reason() {
    let room = Room::new([18, 18, 18], [0.1; 3], Bands::ONE).with(Engine::Auto);
    let chosen = |parts: SceneParts| {
        let scene = Scene::new(parts).unwrap();
        let transport = Transport::new(&scene);
        let zones = build_zones(&scene, &transport).unwrap();
        let forecast = ProblemSize::new(&scene, &zones, &transport);
        select_engine(&scene, &zones, &transport, &forecast, Default::default(), 4 << 30, 1).unwrap()
    };
    let told = |c: EngineChoice| (c.engine, c.reason);
    let (engine, why) = told(chosen(room.parts()));
    assert!(engine == Engine::Spectral && why.contains("7776 zones in a box"), "{why}");
    let mut parts = Room { cells: [20; 3], ..room.clone() }.parts();
    let map = parts.voxel_grid.take().unwrap();
    let mut map = map.clone();
    map.set(5, Bands::from_rgb([2.0, 1.0, 1.0]), Bands::splat(0.5), Bands::ZERO, Bands::ZERO);
    parts.voxel_grid = Some(map.seal().unwrap());
    let (engine, why) = told(chosen(parts));
    assert_eq!(engine, Engine::Rays);
    assert!(why.contains("spectral does not apply: the extinction varies in band 0"), "{why}");
    // A periodic box is open where walls are missing, not where its images are.
    for (omit, open) in [(vec![], false), (vec![2], true)] {
        let scene =
            Room { omit, periodic: [true, false, false], ..Room::new([4; 3], [0.1; 3], Bands::ONE) }.scene();
        let transport = Transport::new(&scene);
        let zones = build_zones(&scene, &transport).unwrap();
        assert_eq!(is_open(&scene, &zones, &transport), open);
    }
    // Few zones of a periodic box too.
    let few = Room { periodic: [true, false, false], ..Room::new([4; 3], [0.1; 3], Bands::ONE) };
    assert_eq!(chosen(few.with(Engine::Auto).parts()).engine, Engine::Spectral);
}

#[test]
fn slabs_match_the_closed_forms() {
    // VALIDATION 5 (b): between black plates, the medium in radiative equilibrium.
    let slab = |n: usize, tau: f64| {
        let room = Room::new([1, 1, n], [1.0 / n as f64; 3], Bands::splat(tau));
        let mut parts = Room { periodic: [true, true, false], ..room }.parts();
        for (k, s) in parts.surfaces.iter_mut().enumerate() {
            (s.reflectance_texture, s.emission_texture) = (None, None);
            (s.reflectance, s.emission) = (Bands::ZERO, Bands::splat(f64::from(u8::from(k == 0))));
        }
        parts.voxel_grid.as_mut().unwrap().fill(Bands::splat(tau), Bands::ONE, Bands::ZERO, Bands::ZERO);
        let (zones, fields, _) = solved(&Scene::new(parts).unwrap());
        assert_eq!(zones.patches.len(), 2);
        fields.incident[1].first()
    };
    for (tau, flux) in [(0.1, 0.91570287), (1.0, 0.55340599), (10.0, 0.11674511)] {
        let (rough, fine) = (slab(50, tau), slab(100, tau));
        assert!((fine - flux).abs() < 3e-5 * (1.0 + tau), "{tau}: {fine}");
        // The error falls with the square of the cells' size.
        let better = fine + (fine - rough) / 3.0;
        assert!((better - flux).abs() < 1e-5, "{tau}: {better}");
    }
}
