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
/// Engines, and what they do inside zones.
const VARIANTS: [(&str, &str); 4] =
    [("dense", "constant"), ("hierarchical", "constant"), ("spectral", "constant"), ("spectral", "linear")];

/// What a quantity is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A sum by name: power absorbed, net power, temperature.
    Name,
    /// H or G, temperature or net power of a zone.
    Zone,
}

/// A quantity beside its reference.
#[derive(Clone, Debug)]
pub struct Quantity {
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
    pub fn difference(&self) -> f64 {
        (self.value - self.truth).abs()
    }
    /// True where nothing is stated.
    pub fn unknown(&self) -> bool {
        !self.stated.is_finite()
    }
    /// True where the difference is at most `times` the stated error and three standard errors of the reference.
    pub fn covered(&self, times: f64) -> bool {
        !self.unknown() && self.difference() <= times * self.stated + 3.0 * self.sigma
    }
}

/// Reads a model, its meshes written into `folder`.
pub fn read(model: &Model, lines: &str, folder: &Path) -> Result<Scene, String> {
    let (text, files) = model.texts(lines);
    for (name, text) in files {
        std::fs::write(folder.join(&name), text).map_err(|e| format!("{name}: {e}"))?;
    }
    input::parse_scene(&text, Some(folder), "scene.toml").map_err(|e| e.to_string())
}

/// Reads and solves a model; `Ok(None)` where the engine does not apply.
pub fn solved(model: &Model, engine: &str, basis: &str, folder: &Path) -> Result<Option<Solution>, String> {
    let lines = format!("engine = \"{engine}\"\nthick_zones = \"{basis}\"");
    let scene = read(model, &lines, folder)?;
    match zonal::solve::solve(scene, MEMORY, &Quiet) {
        Ok(s) => Ok(Some(s)),
        Err(e) if engine != "dense" || model.periodic != [false; 3] => {
            let known = ["does not apply", "periodic", "spectral", "hierarchical"];
            let said = e.to_string();
            if known.iter().any(|k| said.contains(k)) { Ok(None) } else { Err(said) }
        }
        Err(e) => Err(e.to_string()),
    }
}

/// Which surfaces of a scene are closed parts.
pub fn closed(model: &Model, scene: &Scene) -> Closed {
    let whole = |name: &str| {
        let own = |s: &super::model::Surface| matches!(s.shape, super::model::Shape::Mesh { .. }) && name.starts_with(&s.name);
        model.surfaces.iter().any(own)
    };
    Closed { surfaces: scene.surfaces().iter().map(|s| whole(&s.name)).collect(), room: model.closed_room }
}

/// All quantities of a scene.
pub struct Measured {
    pub quantities: Vec<Quantity>,
    /// Engines that applied.
    pub engines: Vec<&'static str>,
    /// What went wrong, as text.
    pub failures: Vec<String>,
    pub solutions: Vec<(usize, Solution)>,
}

/// Solves a model by every engine that applies and compares.
pub fn measure(model: &Model, index: u64, seed: u64, walks: usize, folder: &Path) -> Measured {
    let mut out = Measured { quantities: Vec::new(), engines: Vec::new(), failures: Vec::new(), solutions: Vec::new() };
    let mut truths: Option<(Answer, Option<Answer>)> = None;
    for (k, (engine, basis)) in VARIANTS.iter().enumerate() {
        let begun = std::time::Instant::now();
        let s = match solved(model, engine, basis, folder) {
            Ok(Some(s)) => s,
            Ok(None) => continue,
            Err(e) => {
                out.failures.push(format!("{engine}, {basis}: {e}"));
                continue;
            }
        };
        let enclosing = closed(model, &s.scene);
        if std::env::var_os("TIMES").is_some() {
            eprintln!("{engine} {basis} {} zones {:.2} s", s.zones.len(), begun.elapsed().as_secs_f64());
        }
        let begun = std::time::Instant::now();
        let (by_name, by_zone) = truths.get_or_insert_with(|| {
            let names = answer(&s.scene, &enclosing, None, walks, 2 * seed);
            (names, Some(answer(&s.scene, &enclosing, Some(&s.zones), walks, 2 * seed + 1)))
        });
        if std::env::var_os("TIMES").is_some() {
            eprintln!("walks {:.2} s", begun.elapsed().as_secs_f64());
        }
        let word = ["dense", "hierarchical", "spectral", "spectral, slopes"][k];
        out.engines.push(word);
        let mut list = names(&s, by_name);
        // Walks on zones know no slopes, and the zones of the first engine.
        if *basis == "constant"
            && let Some(zones) = by_zone
            && zones.zones.len() == s.zones.len()
        {
            list.extend(self::zones(&s, zones));
        }
        let warned = stated::warned(&s.report);
        let proved = s.report.grade == zonal::math::Grade::Proved;
        out.quantities.extend(list.into_iter().map(|q| Quantity { scene: index, engine: word, warned, proved, ..q }));
        out.solutions.push((k, s));
    }
    out
}

fn quantity(kind: Kind, what: String, value: f64, stated: f64, truth: Estimate, scale: f64) -> Quantity {
    let sigma = truth.error + ROUNDING * scale / 3.0;
    let (engine, scene) = ("", 0);
    Quantity { scene, engine, kind, what, value, stated, truth: truth.value, sigma, proved: false, warned: false }
}

/// T and its standard error from a mean of σT⁴.
fn kelvin(e: Estimate) -> Estimate {
    let t = temperature(e.value.max(0.0));
    Estimate { value: t, error: if e.value > 0.0 { 0.25 * t * e.error / e.value } else { 0.0 } }
}

/// Sums by name.
pub fn names(s: &Solution, truth: &Answer) -> Vec<Quantity> {
    let mut out = Vec::new();
    if let Some(heat) = &s.report.heat {
        let errors = stated::heat(s);
        let scale = truth.heat.iter().map(|h| h.power.value.abs()).fold(0.0, f64::max);
        for ((row, errors), h) in heat.rows.iter().zip(errors).zip(&truth.heat) {
            // What is given is no quantity.
            if row.power_error > 0.0 || (row.power - h.power.value).abs() > ROUNDING * scale {
                out.push(quantity(Kind::Name, format!("net power of {}", row.name), row.power, errors[1], h.power, scale));
            }
            if let (Some(t), Some(e)) = (row.temperature, h.emissive) {
                let truth = kelvin(e);
                if errors[0] > 0.0 || (t - truth.value).abs() > ROUNDING * t {
                    out.push(quantity(Kind::Name, format!("temperature of {}", row.name), t, errors[0], truth, t));
                }
            }
        }
        return out;
    }
    let (e, errors) = (&s.report.energy, stated::energy(s));
    let scale = (0..3).map(|b| e.emitted[b] + e.incoming[b]).fold(0.0, f64::max);
    let mut add = |what: &str, own: [f64; 3], stated: [f64; 3], truth: &[Estimate; 3]| {
        let same = own[0] == own[1] && own[1] == own[2] && truth[0] == truth[1] && truth[1] == truth[2];
        for b in 0..if same { 1 } else { 3 } {
            let what = format!("{what}, band {b}");
            out.push(quantity(Kind::Name, what, own[b], stated[b], truth[b], scale));
        }
    };
    for (k, (name, own)) in e.absorbed_surfaces.iter().enumerate() {
        add(&format!("absorbed by {name}"), *own, errors.absorbed_surfaces[k].1, &truth.surfaces[k]);
    }
    if s.scene.voxmap().is_some() {
        add("absorbed by the medium", e.absorbed_volumes, errors.absorbed_volumes, &truth.medium);
    }
    if !s.scene.panes().is_empty() {
        add("absorbed by panes", e.absorbed_panes, errors.absorbed_panes, &truth.panes);
    }
    if s.scene.lights().is_empty() && stated::ESCAPED {
        add("escaped", e.escaped, errors.escaped, &truth.escaped);
    }
    out
}

/// What arrives at zones; temperatures and net powers of zones.
pub fn zones(s: &Solution, truth: &Answer) -> Vec<Quantity> {
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
        let same = grey || ((0..3).all(|b| h(i, b) == h(i, 0)) && t[0] == t[1] && t[1] == t[2]);
        for b in 0..if same { 1 } else { 3 } {
            let what = format!("{}, band {b}", word(i));
            out.push(quantity(Kind::Zone, what, h(i, b), s.fields.error[i][b], t[b], scale[b]));
        }
    }
    if let Some(heat) = &s.fields.heat {
        for i in 0..s.zones.len() {
            let (t, te) = (heat.temperature[i], heat.temperature_error[i]);
            if let Some(e) = truth.zone_heat[i].emissive
                && t.is_finite()
                && te > 0.0
            {
                out.push(quantity(Kind::Zone, format!("T beside {}", word(i)), t, te, kelvin(e), t));
            }
        }
    }
    out
}
