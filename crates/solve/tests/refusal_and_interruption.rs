//! Solves that end with an error: interrupted by the observer, or refused for lack of memory.

use crate::common;

use common::{read, unit_room};
use std::collections::HashMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use zonal_scene::{CheckpointStore, NoProgress, Progress, Scene, SceneError, SceneErrorKind, Solution};
use zonal_solve::areas::exchange_areas::{ExchangeAreaSettings, ExchangeAreas};
use zonal_solve::engines::problem_size::ProblemSize;
use zonal_solve::{SolveSettings, solve_with_settings};
use zonal_transport::{Transport, build_zones};

/// An observer that interrupts the solve from its `first`-th query on.
struct InterruptingObserver {
    queries: AtomicUsize,
    first: usize,
}

impl InterruptingObserver {
    fn new(first: usize) -> InterruptingObserver {
        InterruptingObserver { queries: AtomicUsize::new(0), first }
    }
}

impl Progress for InterruptingObserver {
    fn begin(&self, _: &str, _: u64) {}
    fn advance(&self, _: u64) {}
    fn end(&self) {}
    fn is_interrupted(&self) -> bool {
        self.queries.fetch_add(1, Ordering::Relaxed) >= self.first
    }
}

/// A checkpoint store in memory.
#[derive(Default)]
struct MemoryStore(Mutex<HashMap<String, Vec<u8>>>);

impl CheckpointStore for MemoryStore {
    fn load(&self, stage: &str) -> Option<Vec<u8>> {
        self.0.lock().unwrap().get(stage).cloned()
    }
    fn save(&self, stage: &str, bytes: &[u8]) {
        self.0.lock().unwrap().insert(stage.into(), bytes.to_vec());
    }
}

fn solve_in(store: &MemoryStore, scene: &Scene, progress: &dyn Progress) -> Result<Solution, SceneError> {
    let settings = SolveSettings { checkpoints: store, ..SolveSettings::new(4 << 30, progress) };
    solve_with_settings(scene.clone(), &settings)
}

/// A room with a sun, a lamp, a medium and surroundings.
fn lit_room(engine: &str) -> Scene {
    read(&unit_room(
        &format!(
            "patch_size = 0.34\nengine = '{engine}'\nresidual = 1e-12\nzone_basis = 'constant'\ntolerance = 0.1"
        ),
        "omit = ['y1']\nreflectance = 0.7\nfaces.z1 = { emission = 2 }",
        "[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [3,3,3]\nextinction = [0.5, 1, 2]\nalbedo = 0.6\n\
         [[light]]\nkind = 'sun'\ndirection = [0.3,-1,-0.6]\nirradiance = 10\n\
         [surroundings]\nradiance = 0.2",
    ))
}

/// A room whose temperatures couple the bands, on few zones.
fn coupled_room() -> Scene {
    read(
        "mode = 'thermal'\n[solve]\npatch_size = 1.0\nengine = 'dense'\nresidual = 1e-10\ndiscretization_error = false\n\
         [thermal]\nweights = [[0.65, -5.5e-4, 3e-7, -5.3e-11], [-0.025, 6.1e-4, -3.9e-7, 6.5e-11], 'rest']\nrange = [600, 2400]\n\
         [[surface]]\nname = 'room'\nroom = { min = [0,0,0], max = [1,1,1] }\ntemperature = 700\nemissivity = [0.2, 0.1, 0.3]\n\
         faces.z0 = { temperature = 1800, emissivity = [0.8, 0.3, 0.1] }\nfaces.x1.heat_flux = 0\n\
         [medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [3,3,3]\nextinction = [0.4, 2.5, 1]\nalbedo = [0.1, 0.3, 0]\nheat_source = 2000\n",
    )
}

/// Interrupts the solve at its first queries and at some later ones. The error is of kind `Interrupted`, and a solve that resumes from the store
/// equals the uninterrupted one to the bit, so that the store holds no incomplete stage.
#[test]
fn interrupted_solve_is_an_error_and_resumes_to_the_bit() {
    for (name, scene) in
        [("dense", lit_room("dense")), ("rays", lit_room("rays")), ("coupled bands", coupled_room())]
    {
        let straight = solve_in(&MemoryStore::default(), &scene, &NoProgress).unwrap();
        let mut interruptions = 0;
        for first in [0, 1, 2, 3, 4, 6, 9, 13, 19, 28, 41, 60, 88, 129] {
            let store = MemoryStore::default();
            let Err(error) = solve_in(&store, &scene, &InterruptingObserver::new(first)) else { break };
            assert_eq!(error.kind(), SceneErrorKind::Interrupted, "{name}, query {first}: {error}");
            interruptions += 1;
            let resumed = solve_in(&store, &scene, &NoProgress).unwrap();
            assert_eq!(resumed.fields, straight.fields, "{name}, query {first}");
            assert_eq!(resumed.report, straight.report, "{name}, query {first}");
        }
        assert!(interruptions >= 5, "{name}: {interruptions}");
    }
}

#[test]
fn refused_solve_is_an_error_of_kind_memory() {
    let kind = |scene: Scene, limit: u64| {
        let error = zonal_solve::solve(scene, limit, &NoProgress).expect_err("the limit is too small");
        assert!(error.message().contains("--max-memory"), "{error}");
        error.kind()
    };
    for engine in ["dense", "rays"] {
        assert_eq!(kind(lit_room(engine), 1 << 10), SceneErrorKind::Memory, "{engine}");
    }
    // Enough for the exchange areas, too little for the iteration over temperatures.
    let scene = coupled_room();
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport).unwrap();
    let areas = ProblemSize::new(&scene, &zones, &transport).bytes;
    drop(transport);
    assert_eq!(kind(scene, areas + 700 * zones.len() as u64), SceneErrorKind::Memory);
    // Matrices of exchange areas.
    let settings = ExchangeAreaSettings { memory_limit: 1 << 10, ..ExchangeAreaSettings::default() };
    let error = ExchangeAreas::compute(&lit_room("dense"), &settings, &NoProgress)
        .expect_err("the limit is too small");
    assert_eq!(error.kind(), SceneErrorKind::Memory, "{error}");
}
