//! Selection of an engine by the options of the scene, its geometry, the number of zones and the memory limit.

use super::cost_forecast::CostForecast;
use super::engine_memory::{layered_solve_bytes, spectral_solve_bytes};
use crate::device::basis::BasisOrder;
use crate::engines::layered::layer_stack::{LayerStack, needs_layers};
use crate::engines::problem_size::ProblemSize;
use crate::engines::rays::memory_budget::MemoryBudget;
use crate::engines::spectral::enclosure::BoxEnclosure;
use crate::engines::spectral::kernels;
use zonal_exchange::pair::PairSettings;
use zonal_scene::{Diagnostic, Engine, Scene, SceneError, ZoneBasis, Zones};
use zonal_transport::Transport;

/// Maximum number of zones for which `auto` selects the dense engine, whatever its cost.
pub(crate) const MAX_DENSE_ZONES: usize = 8000;

/// Cost of the dense engine over that of the rays one up to which `auto` takes it: its factors serve other lights, reflectances and temperatures.
const MAX_DENSE_OVER_RAYS_COST: f64 = 1.5;

/// Tolerance from which `auto` takes the rays engine where light varies within zones: below it rays would take minutes for some hundred zones.
const MIN_RAYS_TOLERANCE: f64 = 1e-3;

/// Number of zones above which `auto` prefers the spectral engine: the dense engine took two seconds of one core of 2023 for as many.
const MIN_SPECTRAL_ZONES: usize = 4000;

/// Optical depth across a voxel above which the automatic basis is linear. A linear basis takes five to ten times the time and memory; below this
/// depth it changes the mean of a zone by less than about a thousandth.
pub(crate) const MIN_LINEAR_BASIS_THICKNESS: f64 = 0.1;

/// Maximum number of cells that tables of a linear basis integrate: some minutes of two cores of 2023.
const MAX_LINEAR_TABLE_CELLS: f64 = 5e9;

/// The selected engine.
#[derive(Clone, Debug)]
pub struct EngineChoice {
    /// The engine; never [`Engine::Auto`].
    pub engine: Engine,
    /// The reason for the report.
    pub reason: String,
    /// For the spectral engine: the box enclosure, and the order of the basis inside its zones.
    pub enclosure: Option<(BoxEnclosure, BasisOrder)>,
    /// For the layered engine: the layers.
    pub layers: Option<LayerStack>,
    /// A diagnostic for the report.
    pub note: Option<Diagnostic>,
}

impl EngineChoice {
    /// True for a box of the spectral engine with patches outside it, whose factors are sampled.
    pub(crate) fn has_patches_outside(&self) -> bool {
        self.enclosure.as_ref().is_some_and(|(found, _)| !found.outside.is_empty())
    }
}

/// Criteria of the selection.
struct EngineSelection<'a> {
    scene: &'a Scene,
    zones: &'a Zones,
    size: &'a ProblemSize,
    memory_limit: u64,
    /// Number of processes that share the work.
    ranks: usize,
    /// The engine that the scene requests.
    requested: Engine,
    basis: ZoneBasis,
    /// True if formulas of the paper replace the factors of voxel pairs.
    uses_paper_formulas: bool,
    is_periodic: bool,
    /// True if there are too many zones, or bytes, for all pairs.
    exceeds_dense: bool,
    /// True if a linear basis is requested or useful.
    wants_linear_basis: bool,
}

/// The box enclosure of a scene, or the reason why there is none.
type EnclosureSearch = Result<BoxEnclosure, String>;

/// Formats bytes in GB.
fn gigabytes(bytes: u64) -> String {
    let x = bytes as f64 / 1e9;
    if x < 0.01 { format!("{x:.1e}") } else { format!("{x:.3}") }
}

fn refuse<T>(key: &'static str, what: impl Into<String>) -> Result<T, SceneError> {
    Err(SceneError::new(key, what))
}

/// Selects the engine for a scene and `ranks` processes, within the memory limit of each.
///
/// # Errors
/// If the engine exceeds the memory limit, or if only another engine can solve the scene.
pub fn select_engine(
    scene: &Scene,
    zones: &Zones,
    transport: &Transport,
    size: &ProblemSize,
    settings: PairSettings,
    memory_limit: u64,
    ranks: usize,
) -> Result<EngineChoice, SceneError> {
    let selection =
        EngineSelection { ranks, ..EngineSelection::new(scene, zones, size, settings, memory_limit) };
    selection.check_basis()?;
    if selection.requested == Engine::Layered || needs_layers(scene) {
        let out = selection.layered_engine()?;
        selection.check_memory(&out, transport)?;
        return Ok(out);
    }
    let found = selection.needs_enclosure().then(|| BoxEnclosure::find(scene, zones));
    if selection.is_periodic {
        check_periodic(&selection, found.as_ref())?;
    }
    let (engine, reason) = selection.engine(found.as_ref())?;
    let mut out = EngineChoice { engine, reason, enclosure: None, layers: None, note: None };
    if let (Engine::Spectral, Some(Ok(found))) = (engine, found) {
        let (order, note) = selection.basis_order(&found);
        (out.enclosure, out.note) = (Some((found, order)), note.or_else(|| selection.note_of_beams()));
    }
    selection.check_transparent_sources(out.engine)?;
    selection.check_memory(&out, transport)?;
    Ok(out)
}

impl<'a> EngineSelection<'a> {
    fn new(
        scene: &'a Scene,
        zones: &'a Zones,
        size: &'a ProblemSize,
        settings: PairSettings,
        memory_limit: u64,
    ) -> EngineSelection<'a> {
        let basis = scene.options().zone_basis;
        EngineSelection {
            scene,
            zones,
            size,
            memory_limit,
            ranks: 1,
            requested: scene.options().engine,
            basis,
            uses_paper_formulas: settings.volume_factors.is_some(),
            is_periodic: scene.is_periodic(),
            exceeds_dense: size.zones_by_pairs() > MAX_DENSE_ZONES || size.bytes > memory_limit,
            wants_linear_basis: basis == ZoneBasis::Linear
                || (basis == ZoneBasis::Auto && size.thickness > MIN_LINEAR_BASIS_THICKNESS),
        }
    }

    /// Refuses sources in voxels without extinction for an engine whose rays end where the medium absorbs.
    fn check_transparent_sources(&self, engine: Engine) -> Result<(), SceneError> {
        if engine == Engine::Rays && self.zones.has_transparent_sources() {
            refuse(
                "medium.source",
                "some cells with a source have no extinction, where the rays of the rays engine do not find it; use larger patches and voxels with engine = \"dense\"",
            )
        } else {
            Ok(())
        }
    }

    /// Refuses a linear basis for engines without one.
    fn check_basis(&self) -> Result<(), SceneError> {
        let other = self.uses_paper_formulas || !matches!(self.requested, Engine::Auto | Engine::Spectral);
        if self.basis == ZoneBasis::Linear && other {
            refuse(
                "solve.zone_basis",
                "slopes inside zones are for the spectral engine; use that, or \"constant\"",
            )
        } else {
            Ok(())
        }
    }

    /// The layered engine, if it is requested, or if the extinction of a slab varies, which no other engine can solve.
    fn layered_engine(&self) -> Result<EngineChoice, SceneError> {
        if self.uses_paper_formulas {
            return refuse("boundary", "formulas of the paper are for one extinction; use --factors exact");
        }
        if !matches!(self.requested, Engine::Auto | Engine::Layered) {
            let name = self.requested.name();
            return refuse(
                "solve.engine",
                format!(
                    "{name} has no periodic images of panes and of layers of different extinction; use \"layered\", or \"auto\""
                ),
            );
        }
        if self.basis == ZoneBasis::Linear {
            return refuse(
                "solve.zone_basis",
                "slopes inside zones are for one extinction in each band; use \"constant\" and more layers",
            );
        }
        let stack = LayerStack::find(self.scene, self.zones).or_else(|why| {
            refuse("solve.engine", format!("layered, the engine of periodic layers, does not apply: {why}"))
        })?;
        let reason = match self.requested {
            Engine::Layered => "as requested".to_string(),
            _ => {
                let panes =
                    if stack.panes > 0 { format!(" and {} panes", stack.panes) } else { String::new() };
                format!("{} layers of different extinction{panes}, periodic along two axes", stack.layers)
            }
        };
        Ok(EngineChoice { engine: Engine::Layered, reason, enclosure: None, layers: Some(stack), note: None })
    }

    /// True where exchange among zones misses how light varies within them, and rays do not: in light mode, with surfaces that hide others, or with lights whose
    /// shadows and beams are sharp in a medium; where the rays engine is possible and reaches the tolerance.
    fn has_light_within_zones(&self) -> bool {
        let (scene, options) = (self.scene, self.scene.options());
        let is_possible = scene.thermal().is_none()
            && !self.is_periodic
            && self.basis != ZoneBasis::Linear
            && options.scattering_orders.is_none()
            && options.tolerance >= MIN_RAYS_TOLERANCE
            && !self.zones.has_transparent_sources();
        let has_beams = || !self.zones.voxels.is_empty() && scene.lights().iter().any(|l| !l.fills_sphere());
        is_possible && (self.size.occluders > 0 || has_beams())
    }

    /// True if the spectral engine is preferable to all pairs in a box.
    fn prefers_spectral(&self) -> bool {
        self.zones.total() > MIN_SPECTRAL_ZONES
            || self.exceeds_dense
            || self.is_periodic
            || self.wants_linear_basis
    }

    /// True if `auto` takes the spectral engine for a box: not for few zones in which light varies.
    fn takes_spectral(&self) -> bool {
        self.prefers_spectral() && (self.zones.total() > MAX_DENSE_ZONES || !self.has_light_within_zones())
    }

    /// A note on light that varies within the zones of the spectral engine.
    fn note_of_beams(&self) -> Option<Diagnostic> {
        let note = "light of suns or lamps varies within the zones of the medium, and the stated error does not contain it; compare with smaller cells, or with engine = \"rays\"";
        self.has_light_within_zones().then(|| Diagnostic::note("light-within-zones", note))
    }

    /// True if the selection depends on whether the scene is a box.
    fn needs_enclosure(&self) -> bool {
        let auto = self.requested == Engine::Auto && self.prefers_spectral();
        self.requested == Engine::Spectral || self.is_periodic || auto
    }

    /// The engine and the reason.
    fn engine(&self, found: Option<&EnclosureSearch>) -> Result<(Engine, String), SceneError> {
        match self.requested {
            Engine::Rays | Engine::Spectral if self.uses_paper_formulas => refuse(
                "solve.engine",
                "formulas of the paper are for pairs; use the dense engine, or --factors exact",
            ),
            Engine::Auto => self.automatic_engine(found),
            Engine::Spectral => match found {
                Some(Err(why)) => refuse(
                    "solve.engine",
                    format!("spectral does not apply: {why}; use another engine, or \"auto\""),
                ),
                _ => Ok((Engine::Spectral, "as requested".into())),
            },
            requested => Ok((requested, "as requested".into())),
        }
    }

    /// The engine of `auto` and the reason: formulas of the paper by pairs, boxes by the spectral engine, many zones by the rays engine, else
    /// the cheaper one.
    fn automatic_engine(&self, found: Option<&EnclosureSearch>) -> Result<(Engine, String), SceneError> {
        let n = self.zones.total();
        if self.uses_paper_formulas {
            return Ok((Engine::Dense, "formulas of the paper are for pairs".into()));
        }
        match found {
            Some(Err(why)) if self.basis == ZoneBasis::Linear => refuse(
                "solve.zone_basis",
                format!(
                    "slopes inside zones are for the spectral engine, which does not apply: {why}; use \"constant\""
                ),
            ),
            Some(Ok(found)) if self.takes_spectral() => {
                let kind = if self.is_periodic { "a periodic box" } else { "a box" };
                let of = if self.wants_linear_basis { " and thick voxels" } else { "" };
                let beside = match found.outside.len() {
                    0 => String::new(),
                    count => format!(", and {count} patches outside"),
                };
                let why = format!(
                    "{n} zones{of} in {kind} on the grid of its medium, with one extinction a band{beside}"
                );
                Ok((Engine::Spectral, why))
            }
            found if self.exceeds_dense => {
                let why = if self.size.zones_by_pairs() > MAX_DENSE_ZONES {
                    format!("{n} zones are more than {MAX_DENSE_ZONES}")
                } else {
                    "every pair would need more memory than allowed".to_string()
                };
                let not = match found {
                    Some(Err(why)) => format!("; spectral does not apply: {why}"),
                    _ => String::new(),
                };
                Ok((Engine::Rays, format!("{why}{not}")))
            }
            _ if self.zones.has_transparent_sources() => Ok((
                Engine::Dense,
                "cells with a source have no extinction, so that rays would not find it".into(),
            )),
            _ if self.has_light_within_zones() => Ok((
                Engine::Rays,
                "light varies within zones by shadows, beams or contacts, which rays follow and exchange among zones does not".into(),
            )),
            _ => Ok(self.cheaper_engine()),
        }
    }

    /// The dense or the rays engine by the forecast of their costs. Rays have no images of a periodic scene.
    fn cheaper_engine(&self) -> (Engine, String) {
        let forecast = CostForecast::new(self.scene, self.zones, self.size);
        let [dense, rays] = [forecast.dense, forecast.rays].map(|s| format!("{s:.1} s"));
        let tolerance = self.scene.options().tolerance;
        if self.is_periodic || forecast.dense <= MAX_DENSE_OVER_RAYS_COST * forecast.rays {
            return (
                Engine::Dense,
                format!("all pairs of {} zones take about {dense} of one core", self.zones.len()),
            );
        }
        let reason = format!(
            "rays take about {rays} of one core at the tolerance {tolerance}, all pairs of {} zones {dense}",
            self.zones.len()
        );
        (Engine::Rays, reason)
    }

    /// The order of the basis inside the zones of a box, with a diagnostic: an automatic linear basis must be affordable.
    fn basis_order(&self, found: &BoxEnclosure) -> (BasisOrder, Option<Diagnostic>) {
        // Patches outside a box exchange with constants alone.
        if !self.wants_linear_basis || !found.outside.is_empty() {
            return (BasisOrder::Constant, None);
        }
        let few = |k: &f64| kernels::table_work(&found.grid, *k, BasisOrder::Linear) < MAX_LINEAR_TABLE_CELLS;
        let fits = || {
            self.spectral_bytes(found, BasisOrder::Linear) <= self.memory_limit
                && found.extinction_groups().1.iter().all(few)
        };
        if self.basis != ZoneBasis::Auto || fits() {
            return (BasisOrder::Linear, None);
        }
        let note = "voxels are thick, but slopes inside them would need more memory or time than allowed";
        (BasisOrder::Constant, Some(Diagnostic::warning("no-slopes", note)))
    }

    /// Bytes of a solve by the spectral engine.
    fn spectral_bytes(&self, found: &BoxEnclosure, order: BasisOrder) -> u64 {
        spectral_solve_bytes(self.scene, self.zones, self.size, found, order, self.ranks)
    }

    /// Refuses an engine that exceeds the memory limit.
    fn check_memory(&self, choice: &EngineChoice, transport: &Transport) -> Result<(), SceneError> {
        let (scene, zones) = (self.scene, self.zones);
        let (bytes, what) = match choice.engine {
            Engine::Rays => {
                let least = MemoryBudget::new(scene, zones, transport, self.memory_limit).min_bytes(zones);
                (least, "for the minimum number of rays")
            }
            Engine::Spectral => {
                let of = |(e, v): &(BoxEnclosure, BasisOrder)| self.spectral_bytes(e, *v);
                (choice.enclosure.as_ref().map_or(0, of), "for their spectra and fields")
            }
            Engine::Layered => {
                let of = |s: &LayerStack| layered_solve_bytes(self.size, s);
                (choice.layers.as_ref().map_or(0, of), "for the exchange areas of their layers")
            }
            Engine::Dense | Engine::Auto => (self.size.bytes, "for their exchange areas"),
        };
        if bytes <= self.memory_limit {
            return Ok(());
        }
        let message = format!(
            "{} zones need {} GB {what}, more than the {} GB allowed; use larger patches or fewer cells, or allow more (--max-memory)",
            zones.total(),
            gigabytes(bytes),
            gigabytes(self.memory_limit)
        );
        Err(SceneError::out_of_memory("solve.patch_size", message))
    }
}

/// The reason why a periodic scene is refused that is no box on the grid of its medium.
fn no_box(why: &str) -> String {
    let remedy = if why == "there are panes" {
        ": with periods or facing symmetry planes along two axes panes across the third are solved; along one, end the scene by walls, or give one end a symmetry plane"
    } else {
        ""
    };
    format!("a periodic scene must be a box on the grid of its medium, but {why}{remedy}")
}

/// Refuses periodic scenes for engines without periodic images: only the dense engine in a closed box and the spectral engine have them.
fn check_periodic(selection: &EngineSelection, found: Option<&EnclosureSearch>) -> Result<(), SceneError> {
    if selection.scene.strip_axis().is_some() {
        return check_strips(selection);
    }
    let what = match (selection.requested, found) {
        (Engine::Rays, _) => "rays have no images of a periodic scene; use the spectral engine".to_string(),
        (_, Some(Err(why))) => no_box(why),
        (Engine::Auto | Engine::Dense, _) if selection.uses_paper_formulas => {
            "formulas of the paper have no images of a periodic scene; use --factors exact".to_string()
        }
        (Engine::Dense, Some(Ok(e))) if e.is_open() => {
            "a periodic scene with openings is for the spectral engine; use that, or close the walls"
                .to_string()
        }
        _ => return Ok(()),
    };
    Err(SceneError::new("boundary", what))
}

/// Refuses periodic scenes without a medium for engines other than the dense one, which has strips.
fn check_strips(selection: &EngineSelection) -> Result<(), SceneError> {
    match selection.requested {
        Engine::Rays => {
            refuse("boundary", "rays have no images of a periodic scene; use the dense engine, or \"auto\"")
        }
        Engine::Auto if selection.exceeds_dense => refuse(
            "boundary",
            format!(
                "a periodic scene without a medium is for the dense engine, which does not hold {} zones; use larger patches",
                selection.zones.len()
            ),
        ),
        _ => Ok(()),
    }
}

/// Refuses periodic scenes that are no box on the grid of their medium; [`zonal_exchange::pair::Exchange`] has no images for them.
///
/// # Errors
/// The reason why the scene is no such box.
pub(crate) fn check_periodic_pairs(scene: &Scene, zones: &Zones) -> Result<(), SceneError> {
    match (scene.is_periodic() && scene.strip_axis().is_none()).then(|| BoxEnclosure::find(scene, zones)) {
        Some(Err(why)) => refuse("boundary", no_box(&why)),
        _ => Ok(()),
    }
}

/// True if the escaping power is known without rays: the spectral and the layered engine compute it, a periodic box of all pairs is closed, and strips
/// are exact.
pub(crate) fn knows_escaping_power(engine: Engine, scene: &Scene) -> bool {
    engine == Engine::Spectral || scene.is_periodic()
}
