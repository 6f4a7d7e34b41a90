//! Bands that temperatures couple: Newton's method against a fixed-point iteration.

use crate::common;

use common::{gas, read, solve};
use zonal_math::{Vec3, vec3};
use zonal_scene::thermal::blackbody_emissive_power;
use zonal_scene::{
    Band, BandFractions, Bands, PerBand, Scene, SceneParts, SolveStatus, ThermalCondition, VoxelGrid,
};

/// A cube with one hot wall, a cold one, an adiabatic one and a gas with sources; a wall is one patch.
fn gas_room(shares: BandFractions) -> SceneParts {
    let mut parts = read(
        "mode = \"thermal\"\n[solve]\npatch_size = 1.0\nengine = \"dense\"\nresidual = 1e-12\n[[surface]]\nname = \"room\"\nroom = { min = [0,0,0], max = [1,1,1] }\ntemperature = 700\nemissivity = 0.8\nfaces.z0.temperature = 1800\nfaces.x1.heat_flux = 0\nfaces.y0.heat_flux = 3000\n[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [3, 3, 3]\nextinction = 1\nheat_source = 2000\n",
    )
    .into_parts();
    for (k, s) in parts.surfaces.iter_mut().enumerate() {
        s.reflectance = Bands::from_rgb([0.2, 0.1 + 0.05 * k as f64, 0.4]);
    }
    let mut map = VoxelGrid::new(Vec3::ZERO, vec3(1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0), [3, 3, 3]).unwrap();
    for i in 0..map.len() {
        map.set(
            i,
            Bands::from_rgb([0.4, 2.5, 0.0]),
            Bands::from_rgb([0.1, 0.3, 0.0]),
            Bands::ZERO,
            Bands::ZERO,
        );
        map.set_heat(
            i,
            ThermalCondition::Flux(if i % 2 == 0 { 2000.0 } else { 0.0 }),
            ThermalCondition::Flux(0.0),
        );
    }
    parts.voxel_grid = Some(map.seal().unwrap());
    parts.thermal.as_mut().unwrap().band_fractions = shares;
    parts
}

/// Temperature of a zone with absorption weights m a, incident flux h and net power q, by bisection: Σ m a (a_b σT⁴ − h) = q.
fn temperature_in_balance(shares: &BandFractions, weights: Bands, h: Bands, q: f64) -> f64 {
    let (mut low, mut high) = (1.0f64, 5000.0f64);
    for _ in 0..100 {
        let t = 0.5 * (low + high);
        let net = (weights * (shares.grey_gas_weights(t) * blackbody_emissive_power(t) - h)).sum();
        if net < q { low = t } else { high = t }
    }
    0.5 * (low + high)
}

/// The scene in light mode with the emission of walls and cells at the given temperatures.
fn emitting_scene(parts: &SceneParts, walls: &[f64], cells: &[f64]) -> Scene {
    let shares = &parts.thermal.as_ref().unwrap().band_fractions;
    let map = parts.voxel_grid.as_ref().unwrap();
    let mut light = parts.clone();
    light.thermal = None;
    for (s, t) in light.surfaces.iter_mut().zip(walls) {
        s.emission = (1.0 - s.reflectance) * shares.grey_gas_weights(*t) * blackbody_emissive_power(*t);
    }
    let mut emitting = VoxelGrid::new(map.min(), map.cell(), map.dims()).unwrap();
    for i in 0..map.len() {
        let e = shares.grey_gas_weights(cells[i]) * blackbody_emissive_power(cells[i]);
        emitting.set(i, map.extinction(i), map.albedo(i), e, Bands::ZERO);
    }
    light.voxel_grid = Some(emitting.seal().unwrap());
    Scene::new(light).unwrap()
}

/// Temperatures of the same room by a fixed-point iteration in light mode: emit, solve each band, update every temperature.
fn temperatures_by_fixed_point(parts: &SceneParts) -> Vec<f64> {
    let thermal = parts.thermal.clone().unwrap();
    let shares = &thermal.band_fractions;
    let map = parts.voxel_grid.clone().unwrap();
    let known = |c: &ThermalCondition| if let ThermalCondition::Temperature(t) = c { *t } else { 1200.0 };
    let mut walls: Vec<f64> = thermal.surfaces.iter().map(known).collect();
    let mut cells: Vec<f64> = vec![1200.0; map.len()];
    for _ in 0..2000 {
        let s = solve(emitting_scene(parts, &walls, &cells));
        let mut moved: f64 = 0.0;
        for (i, p) in s.zones.patches.iter().enumerate() {
            if let ThermalCondition::Flux(q) = thermal.surfaces[p.surface] {
                let t = temperature_in_balance(shares, 1.0 - p.reflectance, s.fields.incident[i], q);
                moved = moved.max((t - walls[p.surface]).abs());
                walls[p.surface] = t;
            }
        }
        for (k, v) in s.zones.voxels.iter().enumerate() {
            let g = s.fields.incident[s.zones.voxel_offset() + k];
            let Some(ThermalCondition::Flux(q)) = map.heat(v.cell) else { unreachable!() };
            let t = temperature_in_balance(shares, 4.0 * v.extinction * (1.0 - v.albedo), 0.25 * g, q);
            moved = moved.max((t - cells[v.cell]).abs());
            cells[v.cell] = t;
        }
        if moved < 1e-8 {
            walls.extend(cells);
            return walls;
        }
    }
    panic!("the fixed-point iteration did not converge");
}

// Guards (numbers): coupled bands agree with a fixed-point iteration.
#[test]
fn coupled_bands_match_a_fixed_point_iteration() {
    for shares in [gas(), BandFractions::constant(Bands::from_rgb([0.25, 0.35, 0.4]))] {
        let parts = gas_room(shares.clone());
        let want = temperatures_by_fixed_point(&parts);
        let s = solve(Scene::new(parts).unwrap());
        let kelvin = &s.fields.heat.as_ref().unwrap().temperature;
        assert_eq!(s.zones.patches.len(), 6);
        for (i, (t, w)) in kelvin.iter().zip(&want).enumerate() {
            assert!((t - w).abs() < 1e-6, "zone {i}: {t} K, by fixed-point iteration {w} K");
        }
        assert_eq!(s.report.status, PerBand::splat(SolveStatus::Converged));
        let steps = s.report.residuals[Band::first()].len();
        assert!(steps <= if shares.is_constant() { 1 } else { 8 }, "{steps} steps");
        let heat = s.report.heat.as_ref().unwrap();
        let turnover: f64 = heat.rows.iter().map(|r| r.power.abs()).sum();
        let balance = heat.balance() / turnover;
        assert!(balance.abs() < 1e-10, "{balance:e}");
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let heat = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solve(Scene::new(gas_room(gas())).unwrap()).fields.heat.unwrap())
    };
    assert_eq!(heat(1), heat(3));
}
