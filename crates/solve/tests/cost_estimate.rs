//! Cost estimates before a solve, and the memory limit.

use crate::common;

use common::{read, unit_room};
use zonal_exchange::pair::PairSettings;
use zonal_scene::{Engine, NoProgress, Scene, SceneError, Solution};
use zonal_solve::engines::problem_size::ProblemSize;
use zonal_solve::forecast::time_and_memory::{CostEstimate, CostModelInput};
use zonal_solve::{SolveSettings, solve_with_settings};
use zonal_transport::{Transport, build_zones};

const GAS: &str =
    "[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [8,8,8]\nextinction = [1, 1, 2]\nalbedo = 0.8\n";

fn room(engine: Engine, tolerance: f64) -> Scene {
    let walls = "reflectance = 0.5\nfaces.x0 = { emission = 1 }";
    let scene = read(&unit_room("patch_size = 0.125\nzone_basis = \"constant\"", walls, GAS));
    let mut o = scene.options().clone();
    (o.engine, o.tolerance) = (engine, tolerance);
    scene.with_options(o).unwrap()
}

/// Cost estimate with a clock that advances by a second at every reading.
fn look(scene: &Scene, memory: u64) -> Result<CostEstimate, SceneError> {
    let transport = Transport::new(scene);
    let zones = build_zones(scene, &transport).unwrap();
    let forecast = ProblemSize::new(scene, &zones, &transport);
    let plan = CostModelInput {
        scene,
        zones: &zones,
        transport: &transport,
        size: &forecast,
        pair_settings: PairSettings::default(),
        memory_limit: memory,
        threads: 1,
        ranks: 1,
    };
    let now = std::cell::Cell::new(0.0);
    CostEstimate::new(&plan, &|| now.replace(now.get() + 1.0))
}

fn solved(scene: &Scene, memory: u64) -> Result<Solution, SceneError> {
    solve_with_settings(scene.clone(), &SolveSettings::new(memory, &NoProgress))
}

fn count(s: &Solution, name: &str) -> u64 {
    s.report.counts.iter().find(|c| c.0 == name).map_or(0, |c| c.1)
}

#[test]
fn expected_rays_equal_traced_rays() {
    let scene = room(Engine::Rays, 0.1);
    let estimate = look(&scene, 1 << 30).unwrap();
    let s = solved(&scene, 1 << 30).unwrap();
    assert_eq!(estimate.engine, Engine::Rays);
    let stated = estimate.parts.iter().find_map(|p| p.0.strip_suffix(" rays from the zones")).unwrap();
    let (stated, shot) = (stated.parse::<u64>().unwrap(), count(&s, "transport_rays"));
    assert!(stated > 0 && stated == shot, "{stated} {shot}");
    assert!(estimate.seconds[0] > 0.0 && estimate.seconds[1] > estimate.seconds[0]);
    assert!(estimate.bytes[0] > 0 && estimate.bytes[1] >= estimate.bytes[0]);
    // Smaller tolerances need more samples.
    let gather = |t: f64| {
        let estimate = look(&room(Engine::Rays, t), 1 << 30).unwrap();
        let part = estimate.parts.into_iter().find(|p| p.0.starts_with("final gather"));
        part.expect("the gather is expected").1
    };
    assert!(gather(0.01) > 3.0 * gather(0.1));
}

#[test]
fn dense_engine_is_predicted() {
    let estimate = look(&room(Engine::Auto, 0.01), 1 << 30).unwrap();
    assert_eq!(estimate.engine, Engine::Dense);
    assert!(estimate.parts.iter().any(|p| p.0 == "exchange areas" && p.1 > 0.0));
    assert_eq!(estimate.seconds[0], estimate.seconds[1]);
}

// Guards (files): the memory limit bounds rays, and the report says so.
#[test]
fn memory_limit_reduces_rays_or_refuses() {
    let scene = room(Engine::Rays, 0.1);
    let plenty = look(&scene, 1 << 30).unwrap();
    let stated = plenty.parts.iter().find_map(|p| p.0.strip_suffix(" rays from the zones")).unwrap();
    // Four bytes a ray, twelve since the bands differ, and a quarter of a path vertex of 36 bytes.
    const BYTES_PER_RAY: f64 = 25.0;
    let (plenty, views) = (plenty.bytes[0], BYTES_PER_RAY * stated.parse::<f64>().unwrap());
    let whole = solved(&scene, 1 << 30).unwrap();
    let mut last = count(&whole, "transport_rays");
    assert!(whole.report.warnings.iter().all(|w| !w.contains("--max-memory")), "{:?}", whole.report.warnings);
    for share in [0.3, 0.6] {
        let memory = plenty - (share * views) as u64;
        let estimate = look(&scene, memory).unwrap();
        let s = solved(&scene, memory).unwrap();
        let rays = count(&s, "transport_rays");
        assert!(
            rays > 0 && rays < last && BYTES_PER_RAY * rays as f64 <= (1.0 - share) * views,
            "{rays} of {last}"
        );
        for words in [&s.report.warnings, &estimate.notes] {
            assert!(words.iter().any(|w| w.contains("the tolerance may be missed")), "{words:?}");
        }
        assert!(estimate.bytes[0] <= memory, "{} of {memory}", estimate.bytes[0]);
        last = rays;
    }
    let none = plenty - views as u64;
    for refused in [look(&scene, none).err(), solved(&scene, none).err()] {
        let words = refused.map(|e| e.to_string()).unwrap_or_default();
        assert!(words.contains("--max-memory") && words.contains("rays"), "{words}");
    }
}
