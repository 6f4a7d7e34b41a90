//! Zones, cost and diagnostics of a scene before a solve.

use std::time::Instant;
use zonal_exchange::pair::PairSettings;
use zonal_math::Vec3;
use zonal_scene::{Diagnostic, Scene, SceneError, ZoneBasis, ZoneImages, Zones};
use zonal_solve::engines::problem_size::{self, ProblemSize};
use zonal_solve::forecast::time_and_memory::{self, CostEstimate, CostModelInput};
use zonal_solve::pipeline::symmetry_planes::{self, SymmetricSolve};
use zonal_transport::{Transport, build_zones};

/// The machine of the estimated solve.
#[derive(Clone, Copy, Debug)]
pub struct CheckSettings {
    /// Memory limit, bytes.
    pub memory_limit: u64,
    /// Number of processes that share the solve, each with the threads of this process.
    pub ranks: usize,
    /// When the reading of the scene began.
    pub start: Instant,
}

/// Counts, cost and diagnostics of a scene.
pub struct SceneCheck<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Numbers of zones and pairs.
    pub size: ProblemSize,
    /// Number of threads of a process.
    pub threads: usize,
    /// Number of processes.
    pub ranks: usize,
    /// Expected number of shadow rays.
    pub shadow_rays: f64,
    /// Expected seconds of direct light.
    direct_light_seconds: f64,
    /// Expected seconds of all exchange areas, if known.
    pub exchange_seconds: Option<f64>,
    /// The estimate of a solve, or the reason why it would be refused.
    pub estimate: Result<CostEstimate, SceneError>,
    /// Notes and warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// The scene that is solved: itself, or its even extension where it has symmetry planes.
struct SolvedScene<'a> {
    scene: &'a Scene,
    zones: &'a Zones,
    transport: &'a Transport<'a>,
    images: Option<&'a ZoneImages>,
}

impl<'a> SceneCheck<'a> {
    /// Divides a scene into zones and estimates the cost of a solve.
    ///
    /// # Errors
    /// If the scene cannot be divided into zones. A solve that would be refused is an estimate without success.
    pub fn new(scene: &'a Scene, settings: &CheckSettings) -> Result<SceneCheck<'a>, SceneError> {
        // Divide it into zones.
        let transport = Transport::new(scene);
        let mut zones = build_zones(scene, &transport)?;
        let mut excluded = symmetry_planes::excluded_parts_of(scene, &transport, &zones)?;
        let (scenes, own) = (std::slice::from_ref(scene), std::slice::from_mut(&mut zones));
        zonal_solve::thermal::apply_boundary_conditions(scenes, own);
        // Estimate the cost of a solve; a scene with symmetry planes is solved on its even extension.
        let mirrored = SymmetricSolve::of(scene, &zones)?;
        excluded
            .extend(mirrored.as_ref().map(|m| symmetry_planes::symmetry_note(scene, m.images.image_count())));
        let Some(m) = &mirrored else {
            let solved = SolvedScene { scene, zones: &zones, transport: &transport, images: None };
            return Ok(SceneCheck::of_solved(scene, &solved, excluded, settings));
        };
        let (scene_of_solve, zones, images) = (&m.extension.scene, &m.zones, Some(&m.images));
        let transport = &Transport::new(scene_of_solve);
        let solved = SolvedScene { scene: scene_of_solve, zones, transport, images };
        Ok(SceneCheck::of_solved(scene, &solved, excluded, settings))
    }

    /// Counts, cost and diagnostics of `solved`; counts and names of surfaces are those of `scene`.
    fn of_solved(
        scene: &'a Scene,
        solved: &SolvedScene<'_>,
        excluded: Vec<Diagnostic>,
        settings: &CheckSettings,
    ) -> SceneCheck<'a> {
        let SolvedScene { scene: scene_of_solve, zones, transport, images } = *solved;
        let CheckSettings { memory_limit, ranks, start } = *settings;
        let reading_seconds = start.elapsed().as_secs_f64();
        let clock = || start.elapsed().as_secs_f64();
        let threads = rayon::current_num_threads();
        let size = ProblemSize::new(scene_of_solve, zones, transport).with_images(images);
        let mut diagnostics = excluded;
        diagnostics.extend(zonal_scene::topology::survey(scene_of_solve));
        if problem_size::is_open(scene_of_solve, zones, transport) {
            let text =
                "the scene is open: some rays leave it; the surroundings take part in the exchange as a zone";
            diagnostics.push(Diagnostic::note("open-scene", text));
        }
        let (shadow_rays, direct_light_seconds) =
            problem_size::direct_light_cost(scene_of_solve, zones, transport, threads);
        let input = CostModelInput {
            scene: scene_of_solve,
            zones,
            transport,
            size: &size,
            pair_settings: PairSettings::default(),
            memory_limit,
            threads,
            ranks,
        };
        let estimate = CostEstimate::new(&input, &clock)
            .map(|e| e.for_bands(scene_of_solve).with_reading_time(reading_seconds));
        let basis = estimate.as_ref().map_or(ZoneBasis::Constant, CostEstimate::basis);
        diagnostics.extend(problem_size::scene_diagnostics(scene_of_solve, zones, size.thickness, basis));
        diagnostics.extend(estimate.iter().flat_map(|e| e.notes.iter().cloned()));
        let exchange_seconds = time_and_memory::exchange_areas_cost(&input, &clock);
        SceneCheck {
            scene,
            size,
            threads,
            ranks,
            shadow_rays,
            direct_light_seconds,
            exchange_seconds,
            estimate,
            diagnostics,
        }
    }

    /// The check as JSON.
    #[must_use]
    pub fn json(&self) -> serde_json::Value {
        let (scene, size, e) = (self.scene, &self.size, self.estimate.as_ref().ok());
        let (lower, upper) = scene.bounds();
        let extent = [lower, upper].map(Vec3::array);
        let phases = |e: &CostEstimate| {
            e.parts.iter().map(|(k, s)| serde_json::json!({"phase": k, "seconds": s})).collect::<Vec<_>>()
        };
        serde_json::json!({
            "verdict": if e.is_some() { "valid" } else { "refused" },
            "extent": extent,
            "scene": scene.name(), "surfaces": scene.surfaces().len(), "facets": scene.facets().len(),
            "patches": size.patches, "voxel_zones": size.voxels, "cut_voxel_zones": size.cut, "pane_zones": size.panes,
            "pairs": size.pairs, "distinct_bands": size.groups, "dense_bytes": size.bytes,
            "engine": e.map(|e| e.engine.name()), "reason": e.map(|e| e.reason.clone()),
            "seconds": e.map(|e| e.seconds), "memory_bytes": e.map(|e| e.bytes), "ranks": self.ranks,
            "sent_bytes": e.and_then(|e| e.traffic).map(|t| t.total), "sent_bytes_of_product": e.and_then(|e| e.traffic).map(|t| t.product), "phases": e.map(phases),
            "exchange_areas_seconds": self.exchange_seconds,
            "zone_bytes": size.zone_bytes, "shadow_rays": self.shadow_rays, "direct_light_seconds": self.direct_light_seconds,
            "occluders": size.occluders, "lights": scene.lights().len(),
            "cameras": scene.cameras().iter().map(|c| c.name.clone()).collect::<Vec<_>>(),
            "warnings": zonal_io::output::notes_json(&self.diagnostics),
        })
    }
}
