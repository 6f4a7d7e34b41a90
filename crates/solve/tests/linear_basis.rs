//! The linear basis: exact refinement, physical laws, and problems with known solutions.

use crate::common;

use common::{solved_zones as solved, surface, wall};
use zonal_math::{Vec3, vec3};
use zonal_scene::{
    Bands, Engine, Facet, NoProgress, PatchRule, Report, Scene, SceneParts, SolveOptions, Surroundings,
    VoxelGrid, ZoneBasis, Zones,
};
use zonal_solve::device::basis::BasisOrder;
use zonal_solve::distribution::Execution;
use zonal_solve::engines::spectral::SpectralOperator;
use zonal_solve::engines::spectral::cpu::Processor;
use zonal_solve::engines::spectral::enclosure::BoxEnclosure;
use zonal_solve::{ExchangeOperator, SolveSettings, solve_zones};
use zonal_transport::{Transport, build_zones};

/// A box with one emitting wall and black cold ones, and a scattering medium or one in radiative equilibrium.
#[derive(Clone)]
struct Room {
    cells: [usize; 3],
    edges: [f64; 3],
    kappa: f64,
    albedo: f64,
    reflectance: f64,
    periodic: [bool; 3],
    omit: Vec<usize>,
    thick: ZoneBasis,
}

impl Room {
    fn cube(n: usize, kappa: f64) -> Room {
        Room {
            cells: [n; 3],
            edges: [1.0 / n as f64; 3],
            kappa,
            albedo: 1.0,
            reflectance: 0.0,
            periodic: [false; 3],
            omit: Vec::new(),
            thick: ZoneBasis::Linear,
        }
    }
    fn parts(&self) -> SceneParts {
        let size = Vec3::from_array([0, 1, 2].map(|k| self.cells[k] as f64 * self.edges[k]));
        let mut parts = SceneParts {
            options: SolveOptions {
                patch_rule: PatchRule::Voxels,
                engine: Engine::Spectral,
                residual: 1e-13,
                zone_basis: self.thick,
                ..SolveOptions::default()
            },
            periodic: self.periodic,
            ..SceneParts::default()
        };
        for face in (0..6).filter(|f| !self.periodic[f / 2] && !self.omit.contains(f)) {
            let mut s = surface(&format!("wall{face}"), self.reflectance, 0.0, false);
            s.emission = Bands::splat(f64::from(u8::from(face == 4)));
            parts.surfaces.push(s);
            parts.facets.push(Facet {
                surface: parts.surfaces.len() - 1,
                plate: wall(face, vec3(0.0, 0.0, 0.0), size),
                uv: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            });
        }
        let mut map = VoxelGrid::new(vec3(0.0, 0.0, 0.0), Vec3::from_array(self.edges), self.cells).unwrap();
        map.fill(Bands::splat(self.kappa), Bands::splat(self.albedo), Bands::ZERO, Bands::ZERO);
        parts.voxel_grid = Some(map.seal().unwrap());
        parts
    }
    fn scene(&self) -> Scene {
        Scene::new(self.parts()).unwrap_or_else(|e| panic!("{e}"))
    }
    /// Twice as many cells along each axis.
    fn halved(&self) -> Room {
        Room { cells: self.cells.map(|n| 2 * n), edges: self.edges.map(|e| 0.5 * e), ..self.clone() }
    }
}

/// Pseudo-random numbers in [−1, 1).
fn dice(n: usize, mut seed: u64) -> Vec<Bands> {
    let mut next = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    (0..n).map(|_| Bands::from_fn(|_| next())).collect()
}

fn operator(room: &Room) -> (Zones, SpectralOperator<'static>) {
    let scene = room.scene();
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport).unwrap();
    let found = BoxEnclosure::find(&scene, &zones).unwrap_or_else(|e| panic!("{e}"));
    let s =
        SpectralOperator::new(found, &zones, BasisOrder::Linear, &Processor, Execution::alone(&NoProgress));
    (zones, s)
}

/// Centre, normal (zero of voxels) and the axes of the slopes of every zone.
fn places(room: &Room, zones: &Zones) -> Vec<(Vec3, Vec3, Vec<usize>)> {
    let patch = |p: &zonal_scene::Patch| {
        let (lo, hi) = p.plate.bounds();
        let axis = (0..3).find(|&k| p.normal[k].abs() > 0.5).unwrap();
        ((lo + hi) * 0.5, p.normal, (0..3).filter(|&k| k != axis).collect())
    };
    let voxel = |i: usize| {
        let [_, ny, nz] = room.cells;
        let at = [i / (ny * nz), i / nz % ny, i % nz];
        let c = [0, 1, 2].map(|k| (at[k] as f64 + 0.5) * room.edges[k]);
        (Vec3::from_array(c), vec3(0.0, 0.0, 0.0), vec![0, 1, 2])
    };
    let mut out: Vec<_> = zones.patches.iter().map(patch).collect();
    out.extend((0..zones.voxels.len()).map(voxel));
    out
}

/// The unknowns of every zone: its own, then its slopes.
fn unknowns(s: &SpectralOperator) -> Vec<Vec<usize>> {
    let mut out: Vec<Vec<usize>> = (0..s.zones()).map(|i| vec![i]).collect();
    for (k, zone) in s.slope_zones().into_iter().enumerate() {
        out[zone as usize].push(s.zones() + k);
    }
    out
}

fn rooms() -> Vec<Room> {
    let plain = Room {
        cells: [3, 4, 2],
        edges: [0.22, 0.34, 0.14],
        kappa: 4.0,
        reflectance: 0.4,
        albedo: 0.7,
        ..Room::cube(2, 1.0)
    };
    vec![
        plain.clone(),
        Room { omit: vec![0, 3, 5], ..plain.clone() },
        Room { kappa: 0.0, ..plain.clone() },
        Room { kappa: 15.0, periodic: [true, false, false], ..plain.clone() },
        Room { kappa: 15.0, periodic: [false, true, true], ..plain.clone() },
        Room { cells: [2, 1, 3], kappa: 9.0, periodic: [true, true, false], ..plain },
    ]
}

// Guards (numbers): a linear field is invariant under halving of cells.
/// A linear function on a cell is linear on its octants: the incident power of a cell is that of its octants combined.
#[test]
fn linear_field_is_invariant_under_halved_cells() {
    // Slopes along a period of one cell are omitted.
    let single = |r: &Room| (0..3).any(|k| r.periodic[k] && r.cells[k] == 1);
    for room in rooms().into_iter().filter(|r| !single(r)) {
        let ((coarse, s), fine_room) = (operator(&room), room.halved());
        let (fine, t) = operator(&fine_room);
        let (at, parts) = (places(&room, &coarse), places(&fine_room, &fine));
        let (of, of_parts) = (unknowns(&s), unknowns(&t));
        // The parent cell of every octant, and its side of the centre.
        let parent = |(c, n, axes): &(Vec3, Vec3, Vec<usize>)| {
            let near = |p: &(Vec3, Vec3, Vec<usize>)| {
                p.1 == *n && (0..3).all(|k| (p.0[k] - c[k]).abs() < 0.4 * room.edges[k])
            };
            let i = at.iter().position(near).unwrap();
            let sides: Vec<f64> = axes.iter().map(|&k| (c[k] - at[i].0[k]).signum()).collect();
            (i, sides)
        };
        let parents: Vec<(usize, Vec<f64>)> = parts.iter().map(parent).collect();
        let root = 0.75f64.sqrt();
        let x = dice(s.len(), 3);
        let mut y = vec![Bands::ZERO; t.len()];
        for ((i, sides), own) in parents.iter().zip(&of_parts) {
            y[own[0]] = x[*i];
            for (k, side) in sides.iter().enumerate() {
                y[own[0]] += side * root * x[of[*i][k + 1]];
                y[own[k + 1]] = 0.5 * x[of[*i][k + 1]];
            }
        }
        let (got, from) = (s.apply(&x), t.apply(&y));
        let mut want = vec![Bands::ZERO; s.len()];
        for ((i, sides), own) in parents.iter().zip(&of_parts) {
            want[*i] += from[own[0]];
            for (k, side) in sides.iter().enumerate() {
                want[of[*i][k + 1]] += side * root * from[own[0]] + 0.5 * from[own[k + 1]];
            }
        }
        let scale = got.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
        for (i, (got, want)) in got.iter().zip(&want).enumerate() {
            let is_near = (got - want).abs().all(|d| d < 1e-10 * scale);
            assert!(is_near, "{i} of {}: {got:?} {want:?}", s.zones());
        }
    }
}

#[test]
fn reciprocity_and_closure() {
    for room in rooms() {
        let (zones, s) = operator(&room);
        let (x, y) = (dice(s.len(), 1), dice(s.len(), 2));
        let (gx, gy) = (s.apply(&x), s.apply(&y));
        let dot = |a: &[Bands], b: &[Bands]| a.iter().zip(b).map(|(a, b)| (a * b).to_rgb()[1]).sum::<f64>();
        let size: f64 = gy.iter().map(|g| g.to_rgb()[1].abs()).sum();
        assert!((dot(&x, &gy) - dot(&gx, &y)).abs() < 1e-12 * size);
        // A uniform field has zero incident power on slopes and the closure target on zones.
        let mut level: Vec<Bands> =
            (0..s.zones()).map(|i| zonal_exchange::pair::scaled_radiosity_coefficient(&zones, i)).collect();
        level.resize(s.len(), Bands::ZERO);
        let (rows, open) = (s.apply(&level), s.opening_factors());
        for (i, row) in rows.iter().enumerate() {
            let zone = if i < s.zones() { i } else { s.slope_zones()[i - s.zones()] as usize };
            let target = zonal_exchange::pair::closure_target(&zones, zone);
            let want = if i < s.zones() { target } else { 0.0 };
            assert!(((row + open[i]).first() - want).abs() < 1e-9 * target, "{i}: {row:?} {want}");
        }
    }
}

/// Net flux of the hot wall of a unit cube, the others cold, whose medium is in radiative equilibrium.
fn hot_wall(room: &Room) -> (f64, f64) {
    let (zones, fields, report) = solved(&room.scene());
    let hot = zones.patches.iter().zip(&fields.incident).filter(|(p, _)| p.emission.first() > 0.0);
    let (area, back) = hot.fold((0.0, 0.0), |(a, h), (p, i)| (a + p.area, h + p.area * i.first()));
    (1.0 - back / area, report.energy.residual.first())
}

// Guards (numbers): thick cubes and slabs have their known fluxes with few voxels.
#[test]
fn thick_cube_converges_with_few_voxels() {
    // Optical depth 10: VALIDATION section 7 has 0.4483, and 0.513363 and 0.465052 where radiosity is constant in 9³ and 21³ voxels.
    for (n, plain, limit) in [(9, 0.513363, 0.02), (21, 0.465052, 0.007)] {
        let (flux, residual) = hot_wall(&Room { thick: ZoneBasis::Constant, ..Room::cube(n, 10.0) });
        assert!((flux - plain).abs() < 5e-7 && residual.abs() < 1e-11, "{n}: {flux}");
        let (flux, residual) = hot_wall(&Room::cube(n, 10.0));
        println!("{n}: {flux} {:+.3} %", 100.0 * (flux / 0.4483 - 1.0));
        assert!((flux / 0.4483 - 1.0).abs() < limit && residual.abs() < 1e-9, "{n}: {flux} {residual}");
    }
}

// Guards (numbers): thick cubes and slabs have their known fluxes with few voxels.
#[test]
fn slab_of_any_thickness_has_its_flux() {
    // VALIDATION section 5 (b): ten cells, up to one optical depth each; diffusion with jumps at the walls beyond.
    let slab = |tau: f64| {
        let room =
            Room { cells: [1, 1, 10], edges: [0.1; 3], periodic: [true, true, false], ..Room::cube(10, tau) };
        hot_wall(&room).0
    };
    for (tau, flux) in [(0.1, 0.91570287), (1.0, 0.55340599), (3.0, 0.30164472), (10.0, 0.11674511)] {
        let got = slab(tau);
        println!("{tau}: {got} {:+.4} %", 100.0 * (got / flux - 1.0));
        assert!((got / flux - 1.0).abs() < 2e-3, "{tau}: {got}");
    }
    for tau in [100.0, 1000.0] {
        let (got, diffusion) = (slab(tau), 1.0 / (0.75 * tau + 1.0657));
        println!("{tau}: {got} {:+.4} %", 100.0 * (got / diffusion - 1.0));
        assert!((got / diffusion - 1.0).abs() < 0.02, "{tau}: {got} {diffusion}");
    }
}

#[test]
fn isothermal_rooms_are_uniform() {
    for room in rooms().into_iter().filter(|r| r.omit.is_empty() && r.kappa > 0.0) {
        let mut parts = room.parts();
        parts.surfaces.iter_mut().for_each(|s| s.emission = Bands::splat(2.0 * (1.0 - room.reflectance)));
        parts.voxel_grid.as_mut().unwrap().fill(
            Bands::splat(room.kappa),
            Bands::splat(0.7),
            Bands::splat(2.0),
            Bands::ZERO,
        );
        let (zones, fields, report) = solved(&Scene::new(parts).unwrap());
        let n = zones.patches.len();
        for (i, incident) in fields.incident.iter().enumerate() {
            let off = incident.first() / if i < n { 2.0 } else { 8.0 } - 1.0;
            assert!(off.abs() < 1e-9, "{:?} {i} of {n}: {off:e}", room.cells);
        }
        assert!(report.counts.iter().any(|c| c.0 == "slopes of radiosity"));
    }
}

#[test]
fn light_through_openings_excites_slopes() {
    // A uniform sky on a conservative room gives a uniform field.
    let room = Room { reflectance: 1.0, albedo: 1.0, omit: vec![1, 2], ..rooms()[0].clone() };
    let mut parts = room.parts();
    parts.surfaces.iter_mut().for_each(|s| s.emission = Bands::ZERO);
    parts.surroundings = Surroundings { name: None, radiance: Bands::ONE };
    let (zones, fields, _) = solved(&Scene::new(parts).unwrap());
    let (n, pi) = (zones.patches.len(), std::f64::consts::PI);
    for (i, incident) in fields.incident.iter().enumerate() {
        let want = if i < n { pi } else { 4.0 * pi };
        assert!((incident.first() / want - 1.0).abs() < 1e-8, "{i}: {incident:?}");
    }
}

/// Power leaves through an opening by means and slopes and is conserved.
#[test]
fn open_rooms_conserve_power() {
    let slab = |tau: f64, n: usize| Room {
        cells: [1, 1, n],
        edges: [1.0, 1.0, 1.0 / n as f64],
        periodic: [true, true, false],
        omit: vec![5],
        ..Room::cube(n, tau)
    };
    // A black bottom and a conservative medium transmit (4/3)/(τ + 1.42089), to the accuracy of diffusion.
    for (tau, n) in [(0.5, 2), (8.0, 8), (80.0, 8)] {
        let (_, _, report) = solved(&slab(tau, n).scene());
        let e = &report.energy;
        assert!(e.residual.first().abs() < 1e-9, "{tau}: {e:?}");
        let through = 4.0 / 3.0 / (tau + 1.42089);
        assert!((e.escaped.first() / through - 1.0).abs() < 0.02, "{tau}: {e:?} {through}");
    }
    let open = Room { omit: vec![1, 2], ..rooms()[0].clone() };
    for restore_closure in [false, true] {
        let mut parts = open.parts();
        parts.options.restore_closure = Some(restore_closure);
        parts.surroundings = Surroundings { name: None, radiance: Bands::from_rgb([0.3, 1.0, 0.0]) };
        let (_, _, report) = solved(&Scene::new(parts).unwrap());
        let off = report.energy.residual.iter().fold(0.0f64, |m, r| m.max(r.abs()));
        assert!(off < 1e-8, "{:?}", report.energy);
    }
}

/// Early termination is reported, and the stated errors include the remainder.
#[test]
fn early_termination_is_in_the_stated_errors() {
    let solve = |iterations: usize| {
        let mut parts = Room::cube(6, 20.0).parts();
        parts.options.max_iterations = iterations;
        solved(&Scene::new(parts).unwrap())
    };
    let ((_, rough, told), (_, exact, full)) = (solve(12), solve(2000));
    let warned = |r: &Report| r.warnings.iter().any(|w| w.contains("max_iterations"));
    assert!(warned(&told) && !warned(&full));
    for (i, (a, b)) in rough.incident.iter().zip(&exact.incident).enumerate() {
        assert!(
            (a - b).first().abs() <= (rough.error[i] + exact.error[i]).first(),
            "{i}: {a:?} {b:?} {:?}",
            rough.error[i]
        );
    }
}

#[test]
fn linear_basis_is_refused_for_other_engines() {
    let told = |change: &dyn Fn(&mut SceneParts)| {
        let mut parts = Room::cube(2, 1.0).parts();
        change(&mut parts);
        let scene = Scene::new(parts).unwrap();
        let transport = Transport::new(&scene);
        let zones = build_zones(&scene, &transport).unwrap();
        solve_zones(&scene, &zones, &transport, &SolveSettings::new(4 << 30, &NoProgress)).map(|x| x.2)
    };
    let message = |change: &dyn Fn(&mut SceneParts)| told(change).unwrap_err().to_string();
    let dense = message(&|p| p.options.engine = Engine::Dense);
    assert!(dense.contains("solve.zone_basis") && dense.contains("spectral engine"), "{dense}");
    let varying = |p: &mut SceneParts| {
        p.options.engine = Engine::Auto;
        let mut map = p.voxel_grid.take().unwrap();
        map.set(1, Bands::splat(2.0), Bands::splat(0.5), Bands::ZERO, Bands::ZERO);
        p.voxel_grid = Some(map.seal().unwrap());
    };
    let why = message(&varying);
    assert!(why.contains("the extinction varies"), "{why}");
    // The automatic basis is linear for thick voxels only.
    for (kappa, want) in [(10.0, true), (0.1, false)] {
        let auto = |p: &mut SceneParts| {
            p.options.zone_basis = ZoneBasis::Auto;
            p.voxel_grid.as_mut().unwrap().fill(
                Bands::splat(kappa),
                Bands::splat(0.5),
                Bands::ZERO,
                Bands::ZERO,
            );
        };
        let report = told(&auto).unwrap();
        assert_eq!(report.counts.iter().any(|c| c.0 == "slopes of radiosity"), want, "{kappa}");
    }
}
