//! A model solved by every applicable engine, its quantities compared with forward Monte Carlo.

use super::model::SceneModel;
use super::stated;
use std::path::Path;
use zonal_io::input;
use zonal_reference::SampleEstimate;
use zonal_reference::forward_monte_carlo::{ClosedSurfaces, ForwardProblem, ForwardSolution, trace_forward};
use zonal_scene::thermal::blackbody_temperature;
use zonal_scene::{Band, Bands, NoProgress, Report, Scene, Severity, Solution, ZoneRef};

/// The largest memory of a solve, bytes.
const MAX_MEMORY: u64 = 2 << 30;
/// Differences below this share of the largest quantity of their kind are rounding.
const ROUNDING_SHARE: f64 = 1e-9;
/// Zones whose reference has a larger relative standard error are not compared: too few walks to estimate it.
const MAX_REFERENCE_NOISE: f64 = 0.04;
/// Factor of the number of walks in the second run of a scene with an uncovered sum or a zone that is far off.
const EXTRA_WALKS_FACTOR: usize = 10;
/// A quantity is far off beyond this many stated errors plus [`FAR_STANDARD_ERRORS`] of the reference.
const FAR_STATED_ERRORS: f64 = 10.0;
/// Standard errors of the reference that are granted besides: of some hundred thousand quantities whose stated error is negligible a few are
/// beyond 3σ by chance.
const FAR_STANDARD_ERRORS: f64 = 6.0;
/// Phrases of errors by which an engine declines a scene.
const REFUSALS: [&str; 4] = ["does not apply", "images", "periodic", "is for the spectral engine"];
/// Engines with their zone basis.
pub(crate) const VARIANTS: [(&str, &str); 4] =
    [("dense", "constant"), ("rays", "constant"), ("spectral", "constant"), ("spectral", "linear")];

/// Names of [`VARIANTS`].
pub(crate) const VARIANT_NAMES: [&str; 4] = ["dense", "rays", "spectral", "spectral, slopes"];

/// Kind of a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum QuantityKind {
    /// A sum by name: power absorbed, net power, temperature.
    Name,
    /// H or G, temperature or net power of a zone.
    Zone,
}

/// A quantity beside its reference.
#[derive(Clone, Debug)]
pub(crate) struct Quantity {
    pub scene: u64,
    /// Engine and basis.
    pub engine: &'static str,
    pub kind: QuantityKind,
    /// Name.
    pub what: String,
    pub value: f64,
    pub stated: f64,
    pub truth: f64,
    pub sigma: f64,
    /// True where the grade of the exchange is proved.
    pub proved: bool,
    /// True where the report warns of something.
    pub warned: bool,
}

impl Quantity {
    /// |difference|.
    pub(crate) fn difference(&self) -> f64 {
        (self.value - self.truth).abs()
    }
    /// True where no error is stated.
    pub(crate) fn is_unknown(&self) -> bool {
        !self.stated.is_finite()
    }
    /// Largest covered difference: the stated error and 3σ of the reference, of zones twice the stated error.
    pub(crate) fn limit(&self) -> f64 {
        let times = if self.kind == QuantityKind::Name { 1.0 } else { 2.0 };
        times * self.stated + 3.0 * self.sigma
    }
    /// True if the stated error covers the difference.
    pub(crate) fn is_covered(&self) -> bool {
        !self.is_unknown() && self.difference() <= self.limit()
    }
    /// Beyond ten times the stated error.
    pub(crate) fn is_far(&self) -> bool {
        !self.is_unknown()
            && self.difference() > FAR_STATED_ERRORS * self.stated + FAR_STANDARD_ERRORS * self.sigma
    }
    /// True where the difference exceeds the noise of the reference.
    pub(crate) fn is_significant(&self) -> bool {
        self.difference() > 3.0 * self.sigma
    }
}

/// Reads a model, its meshes written into `folder`.
pub(crate) fn read(model: &SceneModel, lines: &str, folder: &Path) -> Result<Scene, String> {
    let (text, files) = model.texts(lines);
    for (name, text) in files {
        std::fs::write(folder.join(&name), text).map_err(|e| format!("{name}: {e}"))?;
    }
    input::parse_scene(&text, Some(folder), "scene.toml").map_err(|e| e.to_string())
}

impl SceneModel {
    /// The scene that the reference traces, where it is not the scene of the solution: without flaws, or of the model `truth`.
    fn reference(&self, folder: &Path) -> Result<Option<Scene>, String> {
        if self.flaws.is_empty() && self.truth.is_none() {
            return Ok(None);
        }
        let mut clean = self.truth.as_deref().unwrap_or(self).clone();
        clean.flaws.clear();
        let folder = folder.join("reference");
        std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        read(&clean, "", &folder).map(Some)
    }
}

/// Reads and solves a model; `Ok(None)` where the engine does not apply.
pub(crate) fn solved(
    model: &SceneModel,
    engine: &str,
    basis: &str,
    folder: &Path,
) -> Result<Option<Solution>, String> {
    let lines = format!("engine = \"{engine}\"\nzone_basis = \"{basis}\"");
    let scene = read(model, &lines, folder)?;
    match zonal_solve::solve(scene, MAX_MEMORY, &NoProgress) {
        Ok(s) => Ok(Some(s)),
        Err(e) => {
            let said = e.to_string();
            if REFUSALS.iter().any(|k| said.contains(k)) { Ok(None) } else { Err(said) }
        }
    }
}

/// Which surfaces of a scene are closed parts.
pub(crate) fn closed(model: &SceneModel, scene: &Scene) -> ClosedSurfaces {
    let whole = |name: &str| {
        let own = |s: &super::model::ModelSurface| {
            matches!(s.shape, super::model::ModelShape::Mesh { .. }) && name.starts_with(&s.name)
        };
        model.surfaces.iter().any(own)
    };
    ClosedSurfaces {
        surfaces: scene.surfaces().iter().map(|s| whole(&s.name)).collect(),
        room: model.closed_room,
    }
}

/// All quantities of a scene.
pub(crate) struct SceneMeasurement {
    pub quantities: Vec<Quantity>,
    /// Engines that applied.
    pub engines: Vec<&'static str>,
    /// Errors, as text.
    pub failures: Vec<String>,
    pub solutions: Vec<(usize, Solution)>,
}

impl SceneMeasurement {
    /// Records a failure unless the report warns in these words.
    fn expect_warning(&mut self, engine: &str, words: &str, report: &Report) {
        if !report.warnings.iter().any(|w| w.severity == Severity::Warning && w.text.contains(words)) {
            self.failures.push(format!("{engine}: no warning says that the scene is {words}"));
        }
    }

    /// Adds the quantities of a solution of scene number `scene` with the report of that solution.
    fn add(&mut self, scene: u64, engine: &'static str, list: Vec<Quantity>, report: &Report) {
        let (warned, proved) = (stated::warned(report), report.grade == zonal_math::Grade::Proved);
        let of_solution = |q: Quantity| Quantity { scene, engine, warned, proved, ..q };
        self.quantities.extend(list.into_iter().map(of_solution));
    }
}

/// A Monte Carlo result, and whether it is the longer second run.
type Walked = (ForwardSolution, bool);

/// The Monte Carlo results of a scene, each run where it is needed.
#[derive(Default)]
struct Truths {
    named: Option<Walked>,
    /// On the zones of the first engine.
    by_zone: Option<Walked>,
    /// The same with rays that go on from patches close by.
    by_ray: Option<Walked>,
}

/// The equations on its zones that a solution solves: those of rays that go on from patches close by, or those of the zones.
pub(crate) fn zone_problem(s: &Solution) -> ForwardProblem<'_> {
    if s.report.engine.starts_with("rays") && !s.scene.couples_bands() {
        ForwardProblem::ContinuedRays(&s.zones)
    } else {
        ForwardProblem::Zones(&s.zones)
    }
}

/// Quantities of a solution by name, and by zone without slopes; runs the reference where it is missing, and longer where it differs.
fn compare_with_reference(
    model: &SceneModel,
    s: &Solution,
    basis: &str,
    (walks, seed): (usize, u64),
    truth: Option<&Scene>,
    truths: &mut Truths,
) -> Vec<Quantity> {
    let enclosing = closed(model, &s.scene);
    let traced = truth.unwrap_or(&s.scene);
    let traced_enclosing = closed(model.truth.as_deref().unwrap_or(model), traced);
    let by_name = |walks: usize, seed: u64| {
        trace_forward(traced, &traced_enclosing, ForwardProblem::Continuous, walks, seed)
    };
    // Walks on zones exclude slopes and use the zones of the first engine.
    let named = truths.named.get_or_insert_with(|| (by_name(walks, 2 * seed), false));
    let mut list = names(s, &named.0);
    if !named.1 && list.iter().any(|q| !q.is_unknown() && !q.is_covered()) {
        *named = (by_name(EXTRA_WALKS_FACTOR * walks, 2 * seed + EXTRA_WALKS_FACTOR as u64), true);
        list = names(s, &named.0);
    }
    // Walks are not reflected by symmetry planes, and the zones of another model are others.
    if basis == "constant" && !s.scene.has_symmetry_planes() {
        let problem = zone_problem(s);
        let by_zone = match problem {
            ForwardProblem::ContinuedRays(_) => &mut truths.by_ray,
            _ => &mut truths.by_zone,
        };
        let walk = |walks: usize, seed: u64| trace_forward(&s.scene, &enclosing, problem, walks, seed);
        let by_zone = by_zone.get_or_insert_with(|| (walk(walks, 2 * seed + 1), false));
        if by_zone.0.zones.len() == s.zones.len() {
            let mut met = zones(s, &by_zone.0);
            if !by_zone.1 && met.iter().any(Quantity::is_far) {
                *by_zone = (walk(EXTRA_WALKS_FACTOR * walks, 2 * seed + 1 + EXTRA_WALKS_FACTOR as u64), true);
                met = zones(s, &by_zone.0);
            }
            list.extend(met);
        }
    }
    list
}

/// Solves a model by every applicable engine, or by the first one from number `first` on, and compares.
pub(crate) fn measure(
    model: &SceneModel,
    index: u64,
    seed: u64,
    walks: usize,
    first: Option<usize>,
    folder: &Path,
) -> SceneMeasurement {
    let mut out = SceneMeasurement {
        quantities: Vec::new(),
        engines: Vec::new(),
        failures: Vec::new(),
        solutions: Vec::new(),
    };
    let truth = match model.reference(folder) {
        Ok(t) => t,
        Err(e) => {
            out.failures.push(format!("the scene of the reference: {e}"));
            return out;
        }
    };
    let mut truths = Truths::default();
    let order = (0..VARIANTS.len()).map(|k| (k + first.unwrap_or(0)) % VARIANTS.len());
    for k in order {
        if first.is_some() && !out.solutions.is_empty() {
            break;
        }
        let (engine, basis) = VARIANTS[k];
        let s = match solved(model, engine, basis, folder) {
            Ok(Some(s)) => s,
            Ok(None) => continue,
            Err(e) => {
                out.failures.push(format!("{engine}, {basis}: {e}"));
                continue;
            }
        };
        let engine = VARIANT_NAMES[k];
        out.engines.push(engine);
        if let Some(words) = model.expected_warning {
            out.expect_warning(engine, words, &s.report);
            continue;
        }
        let list = compare_with_reference(model, &s, basis, (walks, seed), truth.as_ref(), &mut truths);
        out.add(index, engine, list, &s.report);
        out.solutions.push((k, s));
    }
    out
}

fn quantity(
    kind: QuantityKind,
    what: String,
    value: f64,
    stated: f64,
    truth: SampleEstimate,
    scale: f64,
) -> Quantity {
    let sigma = truth.error + ROUNDING_SHARE * scale / 3.0;
    let (engine, scene) = ("", 0);
    Quantity {
        scene,
        engine,
        kind,
        what,
        value,
        stated,
        truth: truth.value,
        sigma,
        proved: false,
        warned: false,
    }
}

/// T and its standard error from a mean of σT⁴.
fn kelvin(e: SampleEstimate) -> SampleEstimate {
    let t = blackbody_temperature(e.value.max(0.0));
    SampleEstimate { value: t, error: blackbody_temperature(e.value.max(0.0) + e.error) - t }
}

/// A sum by name as a report has it.
#[derive(Clone, Debug)]
pub(crate) struct NamedSum {
    /// Name.
    pub what: String,
    /// Of whom, without the band.
    pub of: SumSubject,
    pub value: f64,
    pub stated: f64,
}

/// Subject of a sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SumSubject {
    /// Net power of a row of the heat report.
    Power(usize),
    /// Temperature of a row.
    Temperature(usize),
    /// Power absorbed by a surface in a band.
    Surface(usize, Band),
    /// By the medium.
    Medium(Band),
    /// By panes.
    Panes(Band),
    /// Escaped.
    Escaped(Band),
}

/// The named sums of a solution.
pub(crate) fn sums(s: &Solution) -> Vec<NamedSum> {
    let mut out = Vec::new();
    if let Some(heat) = &s.report.heat {
        for (k, (row, [kelvin, watt])) in heat.rows.iter().zip(stated::heat(s)).enumerate() {
            let (what, of) = (format!("net power of {}", row.name), SumSubject::Power(k));
            out.push(NamedSum { what, of, value: row.power, stated: watt });
            if let Some(value) = row.temperature {
                let (what, of) = (format!("temperature of {}", row.name), SumSubject::Temperature(k));
                out.push(NamedSum { what, of, value, stated: kelvin });
            }
        }
        return out;
    }
    let (e, errors) = (&s.report.energy, stated::energy(s));
    let mut add = |what: &str, of: &dyn Fn(Band) -> SumSubject, own: Bands, stated: Bands| {
        for b in Band::all() {
            out.push(NamedSum {
                what: format!("{what}, band {}", b.index()),
                of: of(b),
                value: own[b],
                stated: stated[b],
            });
        }
    };
    for (k, (name, own)) in e.absorbed_surfaces.iter().enumerate() {
        let stated = errors.absorbed_surfaces[k].1;
        add(&format!("absorbed by {name}"), &|b| SumSubject::Surface(k, b), *own, stated);
    }
    if s.scene.voxel_grid().is_some() {
        add("absorbed by the medium", &SumSubject::Medium, e.absorbed_volumes, errors.absorbed_volumes);
    }
    if !s.scene.panes().is_empty() {
        add("absorbed by panes", &SumSubject::Panes, e.absorbed_panes, errors.absorbed_panes);
    }
    if s.scene.lights().is_empty() && stated::ESCAPED_POWER_HAS_ERROR {
        add("escaped", &SumSubject::Escaped, e.escaped, errors.escaped);
    }
    out
}

/// The largest power of a solution's sums, W.
pub(crate) fn scale(list: &[NamedSum]) -> f64 {
    list.iter()
        .filter(|s| !matches!(s.of, SumSubject::Temperature(_)))
        .map(|s| s.value.abs())
        .fold(0.0, f64::max)
}

/// Sums by name beside the reference.
pub(crate) fn names(s: &Solution, truth: &ForwardSolution) -> Vec<Quantity> {
    let list = sums(s);
    let powers = truth.heat.iter().map(|h| h.power.value.abs());
    let scale =
        powers.chain(truth.surfaces.iter().flatten().map(|e| e.value.abs())).fold(scale(&list), f64::max);
    let mut out: Vec<Quantity> = Vec::new();
    for x in list {
        let (truth, scale) = match x.of {
            SumSubject::Power(k) => (truth.heat[k].power, scale),
            SumSubject::Temperature(k) => match truth.heat[k].emissive {
                Some(e) => (kelvin(e), x.value),
                None => continue,
            },
            SumSubject::Surface(k, b) => (truth.surfaces[k][b], scale),
            SumSubject::Medium(b) => (truth.medium[b], scale),
            SumSubject::Panes(b) => (truth.panes[b], scale),
            SumSubject::Escaped(b) => (truth.escaped[b], scale),
        };
        // Given values are not compared.
        let given = truth.error <= ROUNDING_SHARE * scale
            && (x.value - truth.value).abs() <= ROUNDING_SHARE * scale
            && x.stated == 0.0;
        let again =
            out.last().is_some_and(|q| q.truth == truth.value && q.value == x.value && q.stated == x.stated);
        if !given && !again {
            out.push(quantity(QuantityKind::Name, x.what, x.value, x.stated, truth, scale));
        }
    }
    out
}

/// Incident flux, temperatures and net powers of zones.
pub(crate) fn zones(s: &Solution, truth: &ForwardSolution) -> Vec<Quantity> {
    let mut out = Vec::new();
    let h = |i: usize| s.fields.incident[i] + s.fields.direct_light(i);
    let grey = s.scene.thermal().is_some_and(|t| t.band_fractions.is_grey());
    let scale = (0..s.zones.len()).map(|i| h(i).abs()).fold(Bands::ZERO, Bands::max);
    let word = |i: usize| match s.zones.zone(i) {
        ZoneRef::Patch(p) => format!("H of patch {i} of {}", s.scene.surfaces()[p.surface].name),
        ZoneRef::Voxel(k, _) => format!("G of voxel zone {k}"),
        ZoneRef::Pane(k, _) => format!("G of pane zone {k}"),
    };
    for i in 0..s.zones.len() {
        let t = &truth.zones[i];
        let stated = stated::zone(s, i);
        let same = grey || (h(i).is_grey() && t.iter().all(|e| *e == t[Band::first()]));
        for b in Band::all().take(if same { 1 } else { Band::count() }) {
            if t[b].error > MAX_REFERENCE_NOISE * t[b].value
                || (t[b].value == 0.0 && h(i)[b] > ROUNDING_SHARE * scale[b])
            {
                continue;
            }
            let what = format!("{}, band {}", word(i), b.index());
            out.push(quantity(QuantityKind::Zone, what, h(i)[b], stated[b], t[b], scale[b]));
        }
    }
    if let Some(heat) = &s.fields.heat {
        for i in 0..s.zones.len() {
            let (t, te) = (heat.temperature[i], heat.temperature_error[i]);
            if let Some(e) = truth.zone_heat[i].emissive
                && t.is_finite()
                && te > 0.0
                && e.error <= MAX_REFERENCE_NOISE * e.value
            {
                out.push(quantity(QuantityKind::Zone, format!("T beside {}", word(i)), t, te, kelvin(e), t));
            }
        }
    }
    out
}
