//! A model solved by every engine that applies, and its quantities beside what walks from the sources find.

use super::model::Model;
use super::stated;
use std::path::Path;
use zonal::io::input;
use zonal::scene::thermal::temperature;
use zonal::scene::{Quiet, Scene, Solution};
use zonal_reference::Estimate;
use zonal_reference::forward::{Answer, Closed, answer};

/// The largest memory of a solve, bytes.
const MEMORY: u64 = 2 << 30;
/// Differences below this share of the largest quantity of their kind are rounding.
const ROUNDING: f64 = 1e-9;
/// Zones at which the reference's standard error is a larger share of its value are not compared: so few walks have come by that their
/// spread does not tell it.
const ROUGH: f64 = 0.04;
/// So many times as often a scene is walked again of which a sum by name is not covered, or a zone is far off.
const AGAIN: usize = 10;
/// What counts as far: beyond so many stated errors, and so many standard errors of the reference; of some hundred thousand quantities
/// whose stated error is next to nothing a few are beyond 3σ by chance.
const FAR: (f64, f64) = (10.0, 6.0);
/// Words by which an engine says that it does not serve a scene.
const REFUSALS: [&str; 4] = ["does not apply", "images", "periodic", "is for the spectral engine"];
/// Engines, and what they do inside zones.
pub(crate) const VARIANTS: [(&str, &str); 4] =
    [("dense", "constant"), ("hierarchical", "constant"), ("spectral", "constant"), ("spectral", "linear")];

/// The same in words.
pub(crate) const WORDS: [&str; 4] = ["dense", "hierarchical", "spectral", "spectral, slopes"];

/// What a quantity is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
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
    pub kind: Kind,
    /// What it is.
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
    /// True where nothing is stated.
    pub(crate) fn unknown(&self) -> bool {
        !self.stated.is_finite()
    }
    /// What a difference may be: the stated error and 3σ of the reference, of zones twice the stated error.
    pub(crate) fn limit(&self) -> f64 {
        let times = if self.kind == Kind::Name { 1.0 } else { 2.0 };
        times * self.stated + 3.0 * self.sigma
    }
    /// Covered as asked.
    pub(crate) fn holds(&self) -> bool {
        !self.unknown() && self.difference() <= self.limit()
    }
    /// Beyond ten times the stated error.
    pub(crate) fn far(&self) -> bool {
        !self.unknown() && self.difference() > FAR.0 * self.stated + FAR.1 * self.sigma
    }
    /// True where the difference is no noise of the reference.
    pub(crate) fn shows(&self) -> bool {
        self.difference() > 3.0 * self.sigma
    }
}

/// Reads a model, its meshes written into `folder`.
pub(crate) fn read(model: &Model, lines: &str, folder: &Path) -> Result<Scene, String> {
    let (text, files) = model.texts(lines);
    for (name, text) in files {
        std::fs::write(folder.join(&name), text).map_err(|e| format!("{name}: {e}"))?;
    }
    input::parse_scene(&text, Some(folder), "scene.toml").map_err(|e| e.to_string())
}

/// Reads and solves a model; `Ok(None)` where the engine does not apply.
pub(crate) fn solved(
    model: &Model,
    engine: &str,
    basis: &str,
    folder: &Path,
) -> Result<Option<Solution>, String> {
    let lines = format!("engine = \"{engine}\"\nthick_zones = \"{basis}\"");
    let scene = read(model, &lines, folder)?;
    match zonal::solve::solve(scene, MEMORY, &Quiet) {
        Ok(s) => Ok(Some(s)),
        Err(e) => {
            let said = e.to_string();
            if REFUSALS.iter().any(|k| said.contains(k)) { Ok(None) } else { Err(said) }
        }
    }
}

/// Which surfaces of a scene are closed parts.
pub(crate) fn closed(model: &Model, scene: &Scene) -> Closed {
    let whole = |name: &str| {
        let own = |s: &super::model::Surface| {
            matches!(s.shape, super::model::Shape::Mesh { .. }) && name.starts_with(&s.name)
        };
        model.surfaces.iter().any(own)
    };
    Closed { surfaces: scene.surfaces().iter().map(|s| whole(&s.name)).collect(), room: model.closed_room }
}

/// All quantities of a scene.
pub(crate) struct Measured {
    pub quantities: Vec<Quantity>,
    /// Engines that applied.
    pub engines: Vec<&'static str>,
    /// What went wrong, as text.
    pub failures: Vec<String>,
    pub solutions: Vec<(usize, Solution)>,
}

/// What walks find, and whether it was walked again.
type Walked = (Answer, bool);

/// Solves a model by every engine that applies, or by the first that does from number `first` on, and compares.
pub(crate) fn measure(
    model: &Model,
    index: u64,
    seed: u64,
    walks: usize,
    first: Option<usize>,
    folder: &Path,
) -> Measured {
    let mut out =
        Measured { quantities: Vec::new(), engines: Vec::new(), failures: Vec::new(), solutions: Vec::new() };
    // By name and by zone.
    let mut truths: Option<(Walked, Option<Walked>)> = None;
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
        let enclosing = closed(model, &s.scene);
        // Walks on zones know no slopes, and the zones of the first engine.
        let (by_name, by_zone) = truths
            .get_or_insert_with(|| ((answer(&s.scene, &enclosing, None, walks, 2 * seed), false), None));
        let mut list = names(&s, &by_name.0);
        if !by_name.1 && list.iter().any(|q| !q.unknown() && !q.holds()) {
            *by_name = (answer(&s.scene, &enclosing, None, AGAIN * walks, 2 * seed + AGAIN as u64), true);
            list = names(&s, &by_name.0);
        }
        if basis == "constant" {
            let walk = |walks: usize, seed: u64| answer(&s.scene, &enclosing, Some(&s.zones), walks, seed);
            let by_zone = by_zone.get_or_insert_with(|| (walk(walks, 2 * seed + 1), false));
            if by_zone.0.zones.len() == s.zones.len() {
                let mut met = zones(&s, &by_zone.0);
                if !by_zone.1 && met.iter().any(Quantity::far) {
                    *by_zone = (walk(AGAIN * walks, 2 * seed + 1 + AGAIN as u64), true);
                    met = zones(&s, &by_zone.0);
                }
                list.extend(met);
            }
        }
        let engine = WORDS[k];
        out.engines.push(engine);
        let warned = stated::warned(&s.report);
        let proved = s.report.grade == zonal::math::Grade::Proved;
        out.quantities.extend(list.into_iter().map(|q| Quantity {
            scene: index,
            engine,
            warned,
            proved,
            ..q
        }));
        out.solutions.push((k, s));
    }
    out
}

fn quantity(kind: Kind, what: String, value: f64, stated: f64, truth: Estimate, scale: f64) -> Quantity {
    let sigma = truth.error + ROUNDING * scale / 3.0;
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
fn kelvin(e: Estimate) -> Estimate {
    let t = temperature(e.value.max(0.0));
    Estimate { value: t, error: temperature(e.value.max(0.0) + e.error) - t }
}

/// A sum by name as a report has it.
#[derive(Clone, Debug)]
pub(crate) struct Sum {
    /// What it is.
    pub what: String,
    /// Of whom, without the band.
    pub of: Of,
    pub value: f64,
    pub stated: f64,
}

/// What a sum is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Of {
    /// Net power of row so and so of the heat.
    Power(usize),
    /// Temperature of row so and so.
    Temperature(usize),
    /// Power absorbed by a surface in a band.
    Surface(usize, usize),
    /// By the medium.
    Medium(usize),
    /// By panes.
    Panes(usize),
    /// Escaped.
    Escaped(usize),
}

/// The sums by name of a solution; not what is given.
pub(crate) fn sums(s: &Solution) -> Vec<Sum> {
    let mut out = Vec::new();
    if let Some(heat) = &s.report.heat {
        for (k, (row, [kelvin, watt])) in heat.rows.iter().zip(stated::heat(s)).enumerate() {
            let (what, of) = (format!("net power of {}", row.name), Of::Power(k));
            out.push(Sum { what, of, value: row.power, stated: watt });
            if let Some(value) = row.temperature {
                let (what, of) = (format!("temperature of {}", row.name), Of::Temperature(k));
                out.push(Sum { what, of, value, stated: kelvin });
            }
        }
        return out;
    }
    let (e, errors) = (&s.report.energy, stated::energy(s));
    let mut add = |what: &str, of: &dyn Fn(usize) -> Of, own: [f64; 3], stated: [f64; 3]| {
        for b in 0..3 {
            out.push(Sum { what: format!("{what}, band {b}"), of: of(b), value: own[b], stated: stated[b] });
        }
    };
    for (k, (name, own)) in e.absorbed_surfaces.iter().enumerate() {
        let stated = errors.absorbed_surfaces[k].1;
        add(&format!("absorbed by {name}"), &|b| Of::Surface(k, b), *own, stated);
    }
    if s.scene.voxmap().is_some() {
        add("absorbed by the medium", &Of::Medium, e.absorbed_volumes, errors.absorbed_volumes);
    }
    if !s.scene.panes().is_empty() {
        add("absorbed by panes", &Of::Panes, e.absorbed_panes, errors.absorbed_panes);
    }
    if s.scene.lights().is_empty() && stated::ESCAPED {
        add("escaped", &Of::Escaped, e.escaped, errors.escaped);
    }
    out
}

/// The largest power of a solution's sums, W.
pub(crate) fn scale(list: &[Sum]) -> f64 {
    list.iter().filter(|s| !matches!(s.of, Of::Temperature(_))).map(|s| s.value.abs()).fold(0.0, f64::max)
}

/// Sums by name beside the reference.
pub(crate) fn names(s: &Solution, truth: &Answer) -> Vec<Quantity> {
    let list = sums(s);
    let powers = truth.heat.iter().map(|h| h.power.value.abs());
    let scale =
        powers.chain(truth.surfaces.iter().flatten().map(|e| e.value.abs())).fold(scale(&list), f64::max);
    let mut out: Vec<Quantity> = Vec::new();
    for x in list {
        let (truth, scale) = match x.of {
            Of::Power(k) => (truth.heat[k].power, scale),
            Of::Temperature(k) => match truth.heat[k].emissive {
                Some(e) => (kelvin(e), x.value),
                None => continue,
            },
            Of::Surface(k, b) => (truth.surfaces[k][b], scale),
            Of::Medium(b) => (truth.medium[b], scale),
            Of::Panes(b) => (truth.panes[b], scale),
            Of::Escaped(b) => (truth.escaped[b], scale),
        };
        // What is given is no quantity.
        let given = truth.error <= ROUNDING * scale
            && (x.value - truth.value).abs() <= ROUNDING * scale
            && x.stated == 0.0;
        let again =
            out.last().is_some_and(|q| q.truth == truth.value && q.value == x.value && q.stated == x.stated);
        if !given && !again {
            out.push(quantity(Kind::Name, x.what, x.value, x.stated, truth, scale));
        }
    }
    out
}

/// What arrives at zones; temperatures and net powers of zones.
pub(crate) fn zones(s: &Solution, truth: &Answer) -> Vec<Quantity> {
    let mut out = Vec::new();
    let h = |i: usize, b: usize| s.fields.incident[i][b] + s.fields.direct[i][b];
    let grey = s.scene.thermal().is_some_and(|t| t.shares.grey());
    let scale: Vec<f64> =
        (0..3).map(|b| (0..s.zones.len()).map(|i| h(i, b).abs()).fold(0.0, f64::max)).collect();
    let word = |i: usize| {
        if i < s.zones.voxel_offset() {
            format!("H of patch {i} of {}", s.scene.surfaces()[s.zones.patches[i].surface].name)
        } else if i < s.zones.pane_offset() {
            format!("G of voxel zone {}", i - s.zones.voxel_offset())
        } else {
            format!("G of pane zone {}", i - s.zones.pane_offset())
        }
    };
    for i in 0..s.zones.len() {
        let t = &truth.zones[i];
        let stated = stated::zone(s, i);
        let same = grey || ((0..3).all(|b| h(i, b) == h(i, 0)) && t[0] == t[1] && t[1] == t[2]);
        for b in 0..if same { 1 } else { 3 } {
            if t[b].error > ROUGH * t[b].value || (t[b].value == 0.0 && h(i, b) > ROUNDING * scale[b]) {
                continue;
            }
            let what = format!("{}, band {b}", word(i));
            out.push(quantity(Kind::Zone, what, h(i, b), stated[b], t[b], scale[b]));
        }
    }
    if let Some(heat) = &s.fields.heat {
        for i in 0..s.zones.len() {
            let (t, te) = (heat.temperature[i], heat.temperature_error[i]);
            if let Some(e) = truth.zone_heat[i].emissive
                && t.is_finite()
                && te > 0.0
                && e.error <= ROUGH * e.value
            {
                out.push(quantity(Kind::Zone, format!("T beside {}", word(i)), t, te, kelvin(e), t));
            }
        }
    }
    out
}
