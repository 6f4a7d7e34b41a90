//! Cost estimates before a solve, and the memory limit.

use crate::common;

use common::{read, unit_room};
use zonal_exchange::pair::PairSettings;
use zonal_scene::{Engine, NoProgress, Scene, SceneError, Solution};
use zonal_solve::report::cost_estimate::problem_size::ProblemSize;
use zonal_solve::report::cost_estimate::time_and_memory::{CostEstimate, CostModelInput};
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
    let scene = room(Engine::Hierarchical, 0.1);
    let estimate = look(&scene, 1 << 30).unwrap();
    let s = solved(&scene, 1 << 30).unwrap();
    assert_eq!(estimate.engine, Engine::Hierarchical);
    let stated = estimate.parts.iter().find_map(|p| p.0.strip_suffix(" rays from the zones")).unwrap();
    let (stated, shot) = (stated.parse::<u64>().unwrap(), count(&s, "transport_rays"));
    // More rays may follow after the first estimate of the error.
    assert!(stated > 0 && stated <= shot && shot <= 3 * stated, "{stated} {shot}");
    // Rays are mostly sufficient at this tolerance; links may be needed.
    assert!(estimate.seconds[0] > 0.0 && estimate.seconds[1] > estimate.seconds[0]);
    assert!(estimate.bytes[0] > 0 && estimate.bytes[1] >= estimate.bytes[0]);
    // Below it links are expected, more for smaller tolerances.
    let links = |t: f64| look(&room(Engine::Hierarchical, t), 1 << 30).unwrap();
    let (some, many) = (links(0.03), links(0.01));
    assert!(some.parts.iter().any(|p| p.0.contains("links")), "{:?}", some.parts);
    assert!(many.bytes[0] > some.bytes[0] && many.bytes[0] > estimate.bytes[0]);
}

#[test]
fn dense_engine_is_predicted() {
    let estimate = look(&room(Engine::Auto, 0.01), 1 << 30).unwrap();
    assert_eq!(estimate.engine, Engine::Dense);
    assert!(estimate.parts.iter().any(|p| p.0 == "exchange areas" && p.1 > 0.0));
    assert_eq!(estimate.seconds[0], estimate.seconds[1]);
}

#[test]
fn memory_limit_reduces_rays_or_refuses() {
    let scene = room(Engine::Hierarchical, 0.1);
    let plenty = look(&scene, 1 << 30).unwrap();
    let stated = plenty.parts.iter().find_map(|p| p.0.strip_suffix(" rays from the zones")).unwrap();
    // Four bytes a ray, and twelve since the bands differ.
    let (plenty, views) = (plenty.bytes[0], 16.0 * stated.parse::<f64>().unwrap());
    let whole = solved(&scene, 1 << 30).unwrap();
    let mut last = count(&whole, "transport_rays");
    assert!(whole.report.warnings.iter().all(|w| !w.contains("--max-memory")), "{:?}", whole.report.warnings);
    for share in [0.3, 0.6] {
        let memory = plenty - (share * views) as u64;
        let estimate = look(&scene, memory).unwrap();
        let s = solved(&scene, memory).unwrap();
        let rays = count(&s, "transport_rays");
        assert!(rays > 0 && rays < last && 16.0 * rays as f64 <= (1.0 - share) * views, "{rays} of {last}");
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

#[test]
fn links_beyond_the_memory_limit_are_omitted() {
    let scene = room(Engine::Hierarchical, 0.01);
    let free = solved(&scene, 1 << 30).unwrap();
    assert!(count(&free, "links, each direction") > 0);
    let s = solved(&scene, 32_000_000).unwrap();
    assert_eq!(count(&s, "links, each direction"), 0);
    assert!(
        s.report.warnings.iter().any(|w| w.contains("does not allow the links")),
        "{:?}",
        s.report.warnings
    );
}
