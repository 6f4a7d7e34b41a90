//! Quantities of a solution with their stated errors, beside forward Monte Carlo.

use super::result::{Quantity, QuantityKind};
use zonal_reference::SampleEstimate;
use zonal_reference::forward_monte_carlo::{ForwardProblem, ForwardSolution};
use zonal_scene::thermal::blackbody_temperature;
use zonal_scene::{Band, Bands, EnergyBalance, Report, Severity, Solution, ZoneRef};

/// Differences below this share of the largest quantity of their kind are rounding.
const ROUNDING_SHARE: f64 = 1e-9;
/// Zones whose reference has a larger relative standard error are not compared: too few walks to estimate it.
const MAX_REFERENCE_NOISE: f64 = 0.04;

/// True where the report warns.
pub(super) fn warned(report: &Report) -> bool {
    report.warnings.iter().any(|w| w.severity == Severity::Warning)
}

/// Stated errors of temperature (K) and net power (W) of each row of heat: of the exchange and of the zones.
fn stated_heat(s: &Solution) -> Vec<[f64; 2]> {
    let zoning = s.report.discretization_error.as_ref();
    let of_zones = |k: usize, q: usize| zoning.and_then(|z| z.heat.get(k)).map_or(f64::INFINITY, |e| e[q]);
    let rows = s.report.heat.iter().flat_map(|h| &h.rows).enumerate();
    rows.map(|(k, r)| [r.temperature_error.unwrap_or(0.0) + of_zones(k, 0), r.power_error + of_zones(k, 1)])
        .collect()
}

/// Stated errors of the powers by name in light mode, W: of the exchange and of the zones.
fn stated_energy(s: &Solution) -> EnergyBalance {
    let own = &s.report.energy_error;
    match &s.report.discretization_error {
        Some(z) => own.zip_map(&z.energy, |a, b| a + b),
        None => own.zip_map(own, |_, _| f64::INFINITY),
    }
}

/// The equations on its zones that a solution solves: those of rays that go on from patches close by, or those of the zones.
pub(super) fn zone_problem(s: &Solution) -> ForwardProblem<'_> {
    if s.report.engine.starts_with("rays") && !s.scene.couples_bands() {
        ForwardProblem::ContinuedRays(&s.zones)
    } else {
        ForwardProblem::Zones(&s.zones)
    }
}

/// A sum by name as a report has it.
#[derive(Clone, Debug)]
pub(super) struct NamedSum {
    /// Name.
    pub what: String,
    /// Of whom, without the band.
    pub of: SumSubject,
    pub value: f64,
    pub stated: f64,
}

/// Subject of a sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SumSubject {
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

impl SumSubject {
    pub(super) fn is_temperature(self) -> bool {
        matches!(self, SumSubject::Temperature(_))
    }
}

/// The named sums of a solution.
pub(super) fn sums(s: &Solution) -> Vec<NamedSum> {
    let mut out = Vec::new();
    if let Some(heat) = &s.report.heat {
        for (k, (row, [kelvin, watt])) in heat.rows.iter().zip(stated_heat(s)).enumerate() {
            let (what, of) = (format!("net power of {}", row.name), SumSubject::Power(k));
            out.push(NamedSum { what, of, value: row.power, stated: watt });
            if let Some(value) = row.temperature {
                let (what, of) = (format!("temperature of {}", row.name), SumSubject::Temperature(k));
                out.push(NamedSum { what, of, value, stated: kelvin });
            }
        }
        return out;
    }
    let (e, errors) = (&s.report.energy, stated_energy(s));
    let mut add = |what: &str, of: &dyn Fn(Band) -> SumSubject, own: Bands, stated: Bands| {
        out.extend(Band::all().map(|b| NamedSum {
            what: format!("{what}, band {}", b.index()),
            of: of(b),
            value: own[b],
            stated: stated[b],
        }));
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
    if s.scene.lights().is_empty() {
        add("escaped", &SumSubject::Escaped, e.escaped, errors.escaped);
    }
    out
}

/// The largest power of a solution's sums, W.
pub(super) fn scale(list: &[NamedSum]) -> f64 {
    list.iter().filter(|s| !s.of.is_temperature()).map(|s| s.value.abs()).fold(0.0, f64::max)
}

/// A value with its stated error beside its reference, whose error includes the rounding of a quantity of this scale.
fn quantity(
    kind: QuantityKind,
    what: String,
    [value, stated]: [f64; 2],
    truth: SampleEstimate,
    scale: f64,
) -> Quantity {
    let sigma = truth.error + ROUNDING_SHARE * scale / 3.0;
    Quantity { kind, what, value, stated, truth: truth.value, sigma, ..Quantity::default() }
}

/// T and its standard error from a mean of σT⁴.
fn kelvin(e: SampleEstimate) -> SampleEstimate {
    let t = blackbody_temperature(e.value.max(0.0));
    SampleEstimate { value: t, error: blackbody_temperature(e.value.max(0.0) + e.error) - t }
}

/// Sums by name beside the reference.
pub(super) fn names(s: &Solution, truth: &ForwardSolution) -> Vec<Quantity> {
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
        let rounding = ROUNDING_SHARE * scale;
        let given = truth.error <= rounding && (x.value - truth.value).abs() <= rounding && x.stated == 0.0;
        let again =
            out.last().is_some_and(|q| q.truth == truth.value && q.value == x.value && q.stated == x.stated);
        if !given && !again {
            out.push(quantity(QuantityKind::Name, x.what, [x.value, x.stated], truth, scale));
        }
    }
    out
}

/// Incident flux, temperatures and net powers of zones.
pub(super) fn zones(s: &Solution, truth: &ForwardSolution) -> Vec<Quantity> {
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
        let (t, stated) = (&truth.zones[i], s.fields.total_error(i));
        let same = grey || (h(i).is_grey() && t.iter().all(|e| *e == t[Band::first()]));
        for b in Band::all().take(if same { 1 } else { Band::count() }) {
            let unseen = t[b].value == 0.0 && h(i)[b] > ROUNDING_SHARE * scale[b];
            if t[b].error <= MAX_REFERENCE_NOISE * t[b].value && !unseen {
                let what = format!("{}, band {}", word(i), b.index());
                out.push(quantity(QuantityKind::Zone, what, [h(i)[b], stated[b]], t[b], scale[b]));
            }
        }
    }
    for (i, heat) in (0..s.zones.len()).filter_map(|i| Some((i, s.fields.heat.as_ref()?))) {
        let (t, te) = (heat.temperature[i], heat.temperature_error[i]);
        if let Some(e) = truth.zone_heat[i].emissive
            && t.is_finite()
            && te > 0.0
            && e.error <= MAX_REFERENCE_NOISE * e.value
        {
            out.push(quantity(QuantityKind::Zone, format!("T beside {}", word(i)), [t, te], kelvin(e), t));
        }
    }
    out
}
