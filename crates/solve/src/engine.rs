//! The choice of an engine, and what it hands to the rest of the solve.
//!
//! An engine is built from the zones, what escapes and what shines; everything after it asks [`Operator`] alone.

use crate::closure;
use crate::dense::{self, Dense};
use crate::direct::Direct;
use crate::forecast::Forecast;
use crate::groups::{self, Source};
use crate::hierarchical;
use crate::hierarchical::budget::Budget;
use crate::krylov::Ended;
use crate::operator::{Arriving, Operator};
use crate::spectral::Spectral;
use crate::spectral::basis::Variation;
use crate::spectral::enclosure::Enclosure;
use crate::spectral::kernels;
use crate::surroundings::Escape;
use rayon::prelude::*;
use zonal_exchange::pair::{Counts, Exchange, Settings, VoxelFactors};
use zonal_scene::scene::ThickZones;
use zonal_scene::solution::Closure;
use zonal_scene::{Bands, Engine, Note, Progress, Scene, SceneError, Vault, Zones};
use zonal_transport::Transport;

/// Zones up to which `auto` takes every pair: 3700 zones with a shelf among them took 25 seconds of one core of 2023, and 2 by links
/// whose error was ten times as large.
pub const DENSE_ZONES: usize = 8000;

/// Zones from which on `auto` takes transforms where they apply: all pairs of as many took two seconds of one core of 2023.
pub const SPECTRAL_ZONES: usize = 4000;

/// Optical depth across a voxel beyond which radiosity varies inside it, unless the scene says otherwise: slopes take five to ten times the time
/// and memory, and below it they change the mean of a zone by less than a thousandth or so.
pub const THIN: f64 = 0.1;

/// Cells that tables of slopes may integrate: some minutes of two cores of 2023.
const MOST_CELLS: f64 = 5e9;

/// What an engine is built from.
pub struct Site<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its zones.
    pub zones: &'a Zones,
    /// What rays meet.
    pub transport: &'a Transport<'a>,
    /// Direct light on the zones.
    pub direct: &'a Direct,
    /// The light groups.
    pub sources: &'a [Source],
    /// Formulas of pairs.
    pub settings: Settings,
    /// Largest memory, bytes.
    pub memory: u64,
    /// Keeper of what is done.
    pub vault: &'a dyn Vault,
    /// Listener.
    pub progress: &'a dyn Progress,
}

impl Site<'_> {
    /// The strengths s⁰ of every group, W/m² and W/m³.
    pub fn columns(&self, escape: &Escape) -> Vec<Vec<Bands>> {
        let one = |s: &Source| groups::strengths(s, self.scene, self.zones, escape, &s.direct(self.direct));
        self.sources.iter().map(one).collect()
    }
}

/// An engine, ready.
pub struct Built<'a> {
    /// The exchange of all zones.
    pub operator: Box<dyn Operator + 'a>,
    /// Closure, and the relative defect of every zone before any restoration; where [`closure::restore`] restored it, by how much that changed its row.
    pub closure: (Closure, Vec<Bands>),
    /// Name and count of what was counted.
    pub counts: Vec<(String, u64)>,
    /// What a user should know.
    pub warnings: Vec<Note>,
    /// The solution, where building the engine found it: how each group ended, and what arrives.
    pub solved: Option<(Vec<Ended>, Arriving)>,
}

/// What was chosen for a scene.
#[derive(Clone, Debug)]
pub struct Choice {
    /// The engine; never [`Engine::Auto`].
    pub engine: Engine,
    /// Why.
    pub reason: String,
    /// For the spectral engine: the box that the scene is, and how radiosity varies inside its zones.
    pub boxed: Option<(Enclosure, Variation)>,
    /// What a user should know of it.
    pub note: Option<Note>,
}

/// What the choice is made from.
struct Wish<'a> {
    scene: &'a Scene,
    zones: &'a Zones,
    forecast: &'a Forecast,
    memory: u64,
    /// What the scene asks for.
    asked: Engine,
    slopes: ThickZones,
    /// The voxels' factors are formulas of the paper.
    paper: bool,
    periodic: bool,
    /// Too many zones, or bytes, for every pair.
    many: bool,
    /// Slopes inside zones are wanted.
    thick: bool,
}

/// What a look for a box found: the box, or why there is none.
type Found = Result<Enclosure, String>;

/// Bytes in GB, to be read.
fn gigabytes(bytes: u64) -> String {
    let x = bytes as f64 / 1e9;
    if x < 0.01 { format!("{x:.1e}") } else { format!("{x:.3}") }
}

fn wrong<T>(key: &'static str, what: impl Into<String>) -> Result<T, SceneError> {
    Err(SceneError::new(key, what))
}

/// The engine for a scene. The error says what would not fit into `memory` bytes, or what only another engine can do.
pub fn choose(
    scene: &Scene,
    zones: &Zones,
    transport: &Transport,
    forecast: &Forecast,
    settings: Settings,
    memory: u64,
) -> Result<Choice, SceneError> {
    let wish = Wish::new(scene, zones, forecast, settings, memory);
    wish.check_slopes()?;
    let found = wish.looks_for_a_box().then(|| Enclosure::find(scene, zones));
    if wish.periodic {
        check_periodic(&wish, found.as_ref())?;
    }
    let (engine, reason) = wish.engine(found.as_ref())?;
    let mut out = Choice { engine, reason, boxed: None, note: None };
    if let (Engine::Spectral, Some(Ok(found))) = (engine, found) {
        let (variation, note) = wish.variation(&found);
        (out.boxed, out.note) = (Some((found, variation)), note);
    }
    wish.check_memory(&out, transport)?;
    Ok(out)
}

impl<'a> Wish<'a> {
    fn new(
        scene: &'a Scene,
        zones: &'a Zones,
        forecast: &'a Forecast,
        settings: Settings,
        memory: u64,
    ) -> Wish<'a> {
        let slopes = scene.options().thick_zones;
        Wish {
            scene,
            zones,
            forecast,
            memory,
            asked: scene.options().engine,
            slopes,
            paper: settings.voxels != VoxelFactors::Exact,
            periodic: scene.is_periodic(),
            many: zones.len() > DENSE_ZONES || forecast.bytes > memory,
            thick: slopes == ThickZones::Linear || (slopes == ThickZones::Auto && forecast.thickness > THIN),
        }
    }

    /// Refuses slopes of engines that have none.
    fn check_slopes(&self) -> Result<(), SceneError> {
        let other = self.paper || !matches!(self.asked, Engine::Auto | Engine::Spectral);
        match self.slopes == ThickZones::Linear && other {
            true => wrong(
                "solve.thick_zones",
                "slopes inside zones are for the spectral engine; use that, or \"constant\"",
            ),
            false => Ok(()),
        }
    }

    /// True where transforms are better than every pair, if the scene is a box.
    fn prefers_transforms(&self) -> bool {
        self.zones.len() > SPECTRAL_ZONES || self.many || self.periodic || self.thick
    }

    /// True where it counts whether the scene is a box: it is looked for nowhere else.
    fn looks_for_a_box(&self) -> bool {
        let auto = self.asked == Engine::Auto && self.prefers_transforms();
        self.asked == Engine::Spectral || self.periodic || auto
    }

    /// The engine and why.
    fn engine(&self, found: Option<&Found>) -> Result<(Engine, String), SceneError> {
        match self.asked {
            Engine::Hierarchical | Engine::Spectral if self.paper => wrong(
                "solve.engine",
                "formulas of the paper are for pairs; use the dense engine, or --factors exact",
            ),
            Engine::Auto => self.best(found),
            Engine::Spectral => match found {
                Some(Err(why)) => wrong(
                    "solve.engine",
                    format!("spectral does not apply: {why}; use another engine, or \"auto\""),
                ),
                _ => Ok((Engine::Spectral, "as asked".into())),
            },
            asked => Ok((asked, "as asked".into())),
        }
    }

    /// The engine that `auto` takes, and why: formulas of the paper by pairs, boxes by transforms, many zones by links, else every pair.
    fn best(&self, found: Option<&Found>) -> Result<(Engine, String), SceneError> {
        let n = self.zones.len();
        if self.paper {
            return Ok((Engine::Dense, "formulas of the paper are for pairs".into()));
        }
        match found {
            Some(Err(why)) if self.slopes == ThickZones::Linear => wrong(
                "solve.thick_zones",
                format!(
                    "slopes inside zones are for the spectral engine, which does not apply: {why}; use \"constant\""
                ),
            ),
            Some(Ok(_)) if self.prefers_transforms() => {
                let kind = if self.periodic { "a periodic box" } else { "a box" };
                let of = if self.thick { " and thick voxels" } else { "" };
                let why =
                    format!("{n} zones{of} in {kind} on the grid of its medium, with one extinction a band");
                Ok((Engine::Spectral, why))
            }
            found if self.many => {
                let why = match n > DENSE_ZONES {
                    true => format!("{n} zones are more than {DENSE_ZONES}"),
                    false => "every pair would need more memory than allowed".to_string(),
                };
                let not = match found {
                    Some(Err(why)) => format!("; spectral does not apply: {why}"),
                    _ => String::new(),
                };
                Ok((Engine::Hierarchical, format!("{why}{not}")))
            }
            _ => Ok((Engine::Dense, format!("{n} zones are no more than {DENSE_ZONES}"))),
        }
    }

    /// How radiosity varies inside the zones of a box, and what a user should know of that: slopes that nobody insists on have to fit.
    fn variation(&self, found: &Enclosure) -> (Variation, Option<Note>) {
        if !self.thick {
            return (Variation::Constant, None);
        }
        let few = |k: &f64| kernels::work(&found.grid, *k, Variation::Linear) < MOST_CELLS;
        let fits = || {
            spectral_bytes(self.scene, self.zones, self.forecast, found, Variation::Linear) <= self.memory
                && found.groups().1.iter().all(few)
        };
        if self.slopes != ThickZones::Auto || fits() {
            return (Variation::Linear, None);
        }
        let note = "voxels are thick, but slopes inside them would need more memory or time than allowed";
        (Variation::Constant, Some(Note::warning("no-slopes", note)))
    }

    /// Refuses an engine that does not fit.
    fn check_memory(&self, choice: &Choice, transport: &Transport) -> Result<(), SceneError> {
        let (scene, zones) = (self.scene, self.zones);
        let (bytes, what) = match choice.engine {
            Engine::Hierarchical => {
                let least = Budget::new(scene, zones, transport, self.memory).least(zones);
                (least, "for the fewest rays that are worth shooting")
            }
            Engine::Spectral => {
                let of = |(e, v): &(Enclosure, Variation)| spectral_bytes(scene, zones, self.forecast, e, *v);
                (choice.boxed.as_ref().map_or(0, of), "for their spectra and fields")
            }
            Engine::Dense | Engine::Auto => (self.forecast.bytes, "for their exchange areas"),
        };
        if bytes <= self.memory {
            return Ok(());
        }
        wrong(
            "solve.patch_size",
            format!(
                "{} zones need {} GB {what}, more than the {} GB allowed; use larger patches or fewer cells, or allow more (--max-memory)",
                zones.len(),
                gigabytes(bytes),
                gigabytes(self.memory)
            ),
        )
    }
}

/// Bytes of a spectral solve, all that it holds: the engine, the zones, and the larger of what the iteration and the fields need.
pub(crate) fn spectral_bytes(
    scene: &Scene,
    zones: &Zones,
    forecast: &Forecast,
    e: &Enclosure,
    variation: Variation,
) -> u64 {
    let kappa = e.groups().1.len();
    let columns = groups::chosen(scene, zones).0.len() as u64;
    let alike = |v: Bands| v[0] == v[1] && v[1] == v[2];
    let grey = kappa == 1
        && zones.patches.par_iter().all(|p| alike(p.reflectance) && alike(p.emission))
        && zones.voxels.par_iter().all(|v| alike(v.albedo) && alike(v.emission) && alike(v.source));
    // Sources, weights, targets; of each group what comes in and the seven vectors of the iteration, in one band or three.
    let bands = if grey { 1 } else { 3 };
    let solving = 24 + 8 + columns * (24 + 7 * 8 * bands);
    // Radiosity, incident, direct, error; of each group its strengths and what arrives; direct light of each light.
    let fields = 4 * 24 + columns * 48;
    let more = 24 * u64::from(e.is_open()) + 120 * scene.lights().len() as u64;
    let [voxel, patch] = [variation.voxel() - 1, variation.patch() - 1].map(|n| n as u64);
    let slopes = voxel * zones.voxels.len() as u64 + patch * zones.patches.len() as u64;
    // Of slopes: what the zones have in the iteration, and to which zone they belong.
    let unknowns = zones.len() as u64 * (solving.max(fields) + more) + slopes * (solving + 4);
    Spectral::bytes(&e.grid, kappa, variation) + forecast.zone_bytes + unknowns
}

/// Why a periodic scene that is no box on the grid of its medium is refused.
fn no_box(why: &str) -> String {
    format!("a periodic scene must be a box on the grid of its medium, but {why}")
}

/// Engines that know of images: all pairs of a closed box, and transforms.
fn check_periodic(wish: &Wish, found: Option<&Found>) -> Result<(), SceneError> {
    let what = match (wish.asked, found) {
        (Engine::Hierarchical, _) => {
            "rays know no images of a periodic scene; use the spectral engine".to_string()
        }
        (_, Some(Err(why))) => no_box(why),
        (Engine::Auto | Engine::Dense, _) if wish.paper => {
            "formulas of the paper know no images of a periodic scene; use --factors exact".to_string()
        }
        (Engine::Dense, Some(Ok(e))) if e.is_open() => {
            "a periodic scene with openings is for the spectral engine; use that, or close the walls"
                .to_string()
        }
        _ => return Ok(()),
    };
    Err(SceneError::new("boundary", what))
}

/// Refuses periodic scenes whose pairs [`Exchange`] does not know: all that are no box on the grid of their medium.
pub fn check_pairs(scene: &Scene, zones: &Zones) -> Result<(), SceneError> {
    match scene.is_periodic().then(|| Enclosure::find(scene, zones)) {
        Some(Err(why)) => wrong("boundary", no_box(&why)),
        _ => Ok(()),
    }
}

/// True where no ray is needed to know what escapes: transforms tell it, and a periodic box of all pairs is closed.
pub(crate) fn knows_escape(engine: Engine, scene: &Scene) -> bool {
    engine == Engine::Spectral || scene.is_periodic()
}

/// Builds an engine. Closure is measured, or restored where the scene asks for it, which may scale `escape` too.
pub fn build<'a>(choice: Choice, site: &Site<'a>, escape: &mut Escape) -> Result<Built<'a>, SceneError> {
    match (choice.engine, choice.boxed) {
        (Engine::Hierarchical, _) => hierarchical::build::build(site, escape),
        (Engine::Spectral, Some((enclosure, variation))) => {
            Ok(spectral(site, enclosure, variation, choice.note, escape))
        }
        _ => Ok(dense(site, escape)),
    }
}

/// Every pair of a box by transforms; what leaves through its openings is what would arrive there.
fn spectral(
    site: &Site,
    enclosure: Enclosure,
    variation: Variation,
    note: Option<Note>,
    escape: &mut Escape,
) -> Built<'static> {
    let (scene, zones) = (site.scene, site.zones);
    let open = enclosure.is_open();
    let mut operator = Spectral::new(enclosure, zones.patches.len(), variation, site.progress);
    if open {
        escape.sky = operator.openings();
    }
    operator.measure(zones, &escape.sky);
    let closure = if scene.restores_closure() {
        closure::restore(&mut operator, zones, escape)
    } else {
        closure::measure(&operator, zones, escape)
    };
    let counts = operator.counts();
    let warnings = note.into_iter().collect();
    Built { operator: Box::new(operator), closure, counts, warnings, solved: None }
}

/// Every pair of zones.
pub(crate) fn dense(site: &Site, escape: &mut Escape) -> Built<'static> {
    let (scene, zones) = (site.scene, site.zones);
    let exchange = Exchange::with_settings(scene, zones, site.transport, site.settings);
    let group = dense::groups(scene, site.transport.has_panes_between());
    let (mut operator, pairs) = Dense::assemble(&exchange, zones, group, site.vault, site.progress);
    drop(exchange);
    let closure = if scene.restores_closure() {
        closure::restore(&mut operator, zones, escape)
    } else {
        closure::measure(&operator, zones, escape)
    };
    let mut warnings = Vec::new();
    if pairs.paper > 0 {
        let text = "the factors of two voxels are those of the paper, for comparison: the errors stated here leave out what that costs";
        warnings.push(Note::warning("paper-factors", text));
    }
    let counts = counts(&pairs);
    Built { operator: Box::new(operator), closure, counts, warnings, solved: None }
}

fn counts(c: &Counts) -> Vec<(String, u64)> {
    let list = [
        ("aligned pairs", c.aligned),
        ("voxel pairs by a formula of the paper", c.paper),
        ("pairs with a plate in any position", c.general),
        ("pairs with a cut voxel", c.cut),
        ("pairs with a pane", c.pane),
        ("pairs that face away", c.facing_away),
        ("pairs partly visible", c.partial),
        ("rays between zones", c.rays),
    ];
    list.into_iter().map(|(k, v)| (k.to_string(), v)).collect()
}
