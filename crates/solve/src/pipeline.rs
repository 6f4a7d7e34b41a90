//! A scene in, a solution out: zones, direct light, surroundings, the engine with closure, iteration, balance.
//!
//! What takes long is a stage that a [`Vault`] may keep: each light, the surroundings, the engine's factors, the state of the solver.
//! Everything else is computed again in no time, and comes out the same to the bit.

use crate::consistency;
use crate::direct::{self, Direct, Lit};
use crate::direct_error;
use crate::emitters;
use crate::energy::{self, Found};
use crate::engine::{self, Built, Site};
use crate::finite;
use crate::forecast::{self, Forecast};
use crate::groups::{self, Source, emission, response};
use crate::hierarchical::build::tells_escape;
use crate::hierarchical::even::even;
use crate::krylov::{self, Ended, Stop, System};
use crate::notes;
use crate::operator::{Arriving, extend_to_slopes};
use crate::radii;
use crate::stage::{Pen, Reader};
use crate::surroundings::Escape;
use crate::thermal;
use crate::zoning;
use rayon::prelude::*;
use zonal_exchange::pair::{Settings, strength, target};
use zonal_math::Grade;
use zonal_scene::solution::Energy;
use zonal_scene::{
    Bands, Engine, Estimate, Fields, Group, NoVault, Note, Progress, Report, Scene, SceneError, Solution,
    SolveStatus, Values, Vault, Zones, bands,
};
use zonal_transport::zoning::left_out;
use zonal_transport::{Transport, build_zones};

/// Largest memory of a solve unless the caller says otherwise, bytes.
pub const DEFAULT_MEMORY: u64 = 12 << 30;

/// Share of the largest incident flux by which a zone may be below zero without a word.
const UNDERSHOOT: f64 = 1e-6;

/// Residual, over the tolerance, with which an engine is content whose links err by the tolerance: far below what they leave.
const CONTENT: f64 = 1e-4;

/// How a scene is solved, beside what it says itself.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// Largest memory, bytes: of the exchange areas of pairs, of all that the hierarchical engine holds.
    pub memory: u64,
    /// How the exchange of pairs is computed.
    pub settings: Settings,
    /// Keeper of what is done.
    pub vault: &'a dyn Vault,
    /// Listener.
    pub progress: &'a dyn Progress,
    /// Light groups of an earlier solution on the same zones, from which the solver starts; none for a start from nothing.
    pub initial: &'a [Group],
}

impl<'a> Job<'a> {
    /// A job with the default settings that keeps nothing.
    pub fn new(memory: u64, progress: &'a dyn Progress) -> Job<'a> {
        Job { memory, settings: Settings::default(), vault: &NoVault, progress, initial: &[] }
    }
}

/// Rays a zone that measure what escapes; four times as many where as much light comes in that way.
pub(crate) fn escape_rays(scene: &Scene) -> usize {
    let tolerance = scene.options().tolerance;
    let shining = scene.surroundings().shine();
    ((0.05 / (tolerance * tolerance)) as usize).clamp(256, 4096) * if shining { 4 } else { 1 }
}

/// Solves a scene with the engine that it asks for; refuses with a reason when that would need more than `memory` bytes.
pub fn solve(scene: Scene, memory: u64, progress: &dyn Progress) -> Result<Solution, SceneError> {
    solve_job(scene, &Job::new(memory, progress))
}

/// Solves a scene as a job says.
pub fn solve_job(scene: Scene, job: &Job) -> Result<Solution, SceneError> {
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport)?;
    let left_out = left_out(&scene, &transport, &zones)?;
    let (zones, Solved { fields, groups, mut report, slopes }) = settled(&scene, transport, zones, job)?;
    report.warnings.splice(0..0, left_out);
    if zoning::wanted(&scene) {
        zoning::estimate(&scene, (&zones, &fields), slopes, &mut report, job);
    }
    Ok(Solution {
        zones,
        fields,
        groups,
        report,
        scene_hash: String::new(),
        version: env!("CARGO_PKG_VERSION").to_string(),
        scene,
    })
}

/// Poses, solves and settles zones.
pub(crate) fn settled(
    scene: &Scene,
    transport: Transport,
    mut zones: Zones,
    job: &Job,
) -> Result<(Zones, Solved), SceneError> {
    thermal::pose(scene, &mut zones);
    let mut s = solved(scene, &zones, &transport, job)?;
    drop(transport);
    thermal::settle(scene, &mut zones, &mut s.fields, &mut s.groups, &mut s.report);
    s.report.warnings.extend(notes::of_heat(scene, &zones, &s.fields, &s.report));
    finite::check(scene, &zones, &mut s.fields, &mut s.groups, &mut s.report)?;
    Ok((zones, s))
}

/// Solves given zones, posed by [`thermal::pose`] where they have temperatures: the fields of all light together, those of each light group,
/// and what there is to say.
pub fn solve_zones(
    scene: &Scene,
    zones: &Zones,
    transport: &Transport,
    job: &Job,
) -> Result<(Fields, Vec<Group>, Report), SceneError> {
    let Solved { fields, groups, report, .. } = solved(scene, zones, transport, job)?;
    Ok((fields, groups, report))
}

/// What [`solve_zones`] gives.
pub(crate) struct Solved {
    pub fields: Fields,
    pub groups: Vec<Group>,
    pub report: Report,
    /// Whether radiosity has slopes inside the zones.
    pub slopes: bool,
}

fn solved(scene: &Scene, zones: &Zones, transport: &Transport, job: &Job) -> Result<Solved, SceneError> {
    let forecast = Forecast::new(scene, zones, transport);
    let memory = job.memory.saturating_sub(thermal::bytes(scene, zones));
    let choice = engine::choose(scene, zones, transport, &forecast, job.settings, memory)?;
    let (engine, reason) = (choice.engine, choice.reason.clone());
    let by_exchange = |l: usize| emitters::surface(scene, zones, engine, job.settings, l);
    let mut direct = Direct::default();
    for l in 0..scene.lights().len() {
        direct.lights.push(match by_exchange(l) {
            Some(_) => Lit::default(),
            None => illuminate(scene, zones, transport, l, job),
        });
    }
    let mut escape = surroundings(scene, zones, transport, engine, job);
    let (sources, note) = groups::chosen(scene, zones);
    let site = Site {
        scene,
        zones,
        transport,
        direct: &direct,
        sources: &sources,
        settings: job.settings,
        memory,
        vault: job.vault,
        progress: job.progress,
    };
    let mut built = engine::build(choice, &site, &mut escape)?;
    let sampled = |l: usize| illuminate(scene, zones, transport, l, job);
    let complete = emitters::complete(&site, &built, &escape, by_exchange, sampled);
    let site = Site { direct: complete.as_ref().unwrap_or(&direct), ..site };
    thermal::check_level(scene, zones, &escape)?;
    let coupled = match thermal::coupled::needed(scene) {
        true => Some(thermal::coupled::solve(&site, &built, &escape)?),
        false => None,
    };
    let (site, (mut ended, arriving)) = match (&coupled, built.solved.take()) {
        (Some(c), _) => {
            built.counts.push(("products with all bands".into(), c.products as u64));
            (Site { zones: &c.zones, ..site }, (vec![c.ended.clone()], None))
        }
        (None, Some((ended, arriving))) => (site, (ended, Some(arriving))),
        (None, None) => {
            let ended = iterate(&site, &built, &escape, engine, job);
            (site, (ended, None))
        }
    };
    let (mut fields, groups) = fields(&site, &mut built, &escape, &mut ended, arriving, engine);
    if scene.thermal().is_some() {
        thermal::spread(&site, &built, &mut fields, coupled.is_some());
    }
    let mut energy = Energy::default();
    groups.iter().for_each(|g| energy.add(&g.energy));
    let mut lost = escape_error(zones, &escape, &ended);
    lost = direct_error::of_lights(site.direct).iter().fold(lost, |s, e| bands(|b| s[b].hypot(e[b])));
    // Heat is balanced where its temperatures are found.
    if scene.thermal().is_none() && scene.options().sweeps.is_none() {
        consistency::balance(zones, &energy, lost, &mut fields);
    }
    let mut report = report(&site, &built, &escape, (&fields, energy), &ended, forecast.thickness);
    report.energy_error = match scene.thermal() {
        Some(_) => Energy { escaped: lost, ..Energy::default() },
        None => {
            let mut error = consistency::of_powers(zones, &report.energy, &fields, |i| fields.error[i]);
            direct_error::add_to_powers(zones, &report.energy, site.direct, &mut error);
            error
        }
    };
    (report.engine, report.reason) = (engine.word().into(), reason);
    report.warnings.extend(note);
    let wanted = scene.options().tolerance;
    let estimate = report.estimate.patches.into_iter().chain(report.estimate.volumes).fold(0.0f64, f64::max);
    let told = report.warnings.iter().any(|n| n.code == "tolerance");
    if engine != Engine::Spectral && estimate > wanted && !told {
        let mend = match engine {
            Engine::Dense => {
                "rays that measure pairs that are partly hidden, and what escapes, are not enough for it here"
            }
            _ => "give a smaller tolerance",
        };
        let text = format!("the estimated error, {estimate:.2e}, misses the tolerance, {wanted:.2e}: {mend}");
        report.warnings.push(Note::warning("tolerance", text));
    }
    Ok(Solved { fields, groups, report, slopes: built.operator.len() > zones.len() })
}

/// Light number `l` of the scene by shadow rays, a stage.
fn illuminate(scene: &Scene, zones: &Zones, transport: &Transport, l: usize, job: &Job) -> Lit {
    let stage = format!("light-{l}");
    let kept = job.vault.load(&stage).and_then(|b| Lit::restored(&b, zones.len()));
    kept.unwrap_or_else(|| {
        let normalise = scene.restores_closure();
        let lit = direct::light(scene, zones, transport, l, normalise, job.progress);
        if job.vault.keeps() {
            job.vault.save(&stage, &lit.kept());
        }
        lit
    })
}

/// What escapes, a stage.
fn surroundings(scene: &Scene, zones: &Zones, transport: &Transport, engine: Engine, job: &Job) -> Escape {
    const STAGE: &str = "surroundings";
    if engine::knows_escape(engine, scene) {
        return Escape::default();
    }
    if engine == Engine::Hierarchical && tells_escape(scene, zones) {
        return Escape::untold(zones);
    }
    let restored = |bytes: Vec<u8>| {
        let mut r = Reader::new(&bytes);
        let [sky, backs, error] = [r.triples()?, r.triples()?, r.triples()?];
        let (n, rays) = (zones.len(), r.int()? as u64);
        let fits = sky.len() == n && backs.len() == n && (error.is_empty() || error.len() == n);
        fits.then_some(Escape { sky, backs, error, rays })
    };
    job.vault.load(STAGE).and_then(restored).unwrap_or_else(|| {
        let sampled = (escape_rays(scene), job.settings.sample);
        let escape = Escape::measure(scene, zones, transport, sampled, job.progress);
        if job.vault.keeps() {
            let mut pen = Pen::default();
            pen.triples(&escape.sky);
            pen.triples(&escape.backs);
            pen.triples(&escape.error);
            pen.int(escape.rays as usize);
            job.vault.save(STAGE, &pen.bytes());
        }
        escape
    })
}

/// A of a patch, 4V of a volume zone.
pub fn targets(zones: &Zones) -> Vec<f64> {
    (0..zones.len()).into_par_iter().map(|i| target(zones, i)).collect()
}

/// Solves all groups side by side; what a zone has holds for its slopes too.
fn iterate(site: &Site, built: &Built, escape: &Escape, engine: Engine, job: &Job) -> Vec<Ended> {
    let slopes = built.operator.slopes();
    let (mut weights, mut targets) = (groups::weights(site.zones), targets(site.zones));
    extend_to_slopes(&mut weights, &slopes);
    extend_to_slopes(&mut targets, &slopes);
    let zones = site.zones.len();
    let mut columns = site.columns(escape);
    let warm = initial(site, &columns, job.initial).map(|mut columns| {
        columns.iter_mut().for_each(|c| c.resize(targets.len(), [0.0; 3]));
        columns
    });
    for (source, column) in site.sources.iter().zip(&mut columns) {
        let sky = source.sky(site.scene);
        let of_slope = |k: usize| {
            let ([arrives, _], w) = (escape.incoming(k, sky), weights[k]);
            let lights = site.direct.lights.iter().enumerate().filter(|(l, _)| source.has_light(*l));
            let direct = lights.filter_map(|(_, l)| l.slopes.get(k - zones));
            let arrives = direct.fold(arrives, |a, d| bands(|b| a[b] + d[b]));
            bands(|b| w[b] * arrives[b])
        };
        column.extend((zones..targets.len()).map(of_slope));
    }
    let system = System { operator: built.operator.as_ref(), weights: &weights, targets: &targets };
    let options = site.scene.options();
    if let Some(n) = options.sweeps {
        return krylov::sweeps(&system, &columns, n, job.vault, job.progress);
    }
    let content = if engine == Engine::Hierarchical { CONTENT * options.tolerance } else { 0.0 };
    let stop = Stop { residual: options.residual.max(content), iterations: options.max_iterations };
    krylov::solve(&system, &columns, warm.as_deref(), stop, job.vault, job.progress)
}

/// Strengths that earlier groups of the same names stand for; those of the sources where there was none.
fn initial(site: &Site, columns: &[Vec<Bands>], earlier: &[Group]) -> Option<Vec<Vec<Bands>>> {
    let zones = site.zones;
    let fits = |g: &&Group| g.incident.len() == zones.len();
    let of = |name: &str| earlier.iter().find(|g| g.name == name).filter(fits);
    if !site.sources.iter().any(|s| of(&s.name).is_some()) {
        return None;
    }
    let one = |(source, column): (&Source, &Vec<Bands>)| {
        let mut out = column.clone();
        if let Some(g) = of(&source.name) {
            let mut incident = vec![[0.0; 3]; zones.len()];
            g.incident.add_to(&mut incident, g.incident_scale);
            for (i, o) in out.iter_mut().enumerate() {
                let (c, (rho, _)) = (strength(zones, i), response(zones, i));
                *o = bands(|b| o[b] + c[b] * rho[b] * incident[i][b]);
            }
        }
        out
    };
    Some(site.sources.iter().zip(columns).map(one).collect())
}

/// The fields of all light and of each group.
fn fields(
    site: &Site,
    built: &mut Built,
    escape: &Escape,
    ended: &mut [Ended],
    arriving: Option<Arriving>,
    engine: Engine,
) -> (Fields, Vec<Group>) {
    let zones = site.zones;
    let n = zones.len();
    // Lent to the operator and given back: fields of a large scene are not copied without need.
    let strengths: Vec<Vec<Bands>> = ended.iter_mut().map(|e| std::mem::take(&mut e.strengths)).collect();
    // Rays gave the answer: rows close as they are, the balance of power does not.
    let options = site.scene.options();
    let uneven = arriving.is_some() && site.scene.restores_closure() && options.sweeps.is_none();
    let mut changed = vec![[0.0; 3]; n * usize::from(uneven)];
    let missed: Vec<Bands> = radii::untold(zones, built, escape);
    let arriving = arriving.unwrap_or_else(|| built.operator.arriving(&strengths));
    let Arriving { columns: mut arriving, mut error } = arriving;
    ended.iter_mut().zip(strengths).for_each(|(e, s)| e.strengths = s);
    // An expansion may undershoot where next to nothing arrives; the means of zones with slopes keep their sign, and with it the power.
    let least = if built.operator.len() > n { f64::NEG_INFINITY } else { 0.0 };
    // A solution tells of means; slopes count in what escapes.
    arriving.iter_mut().chain(&mut error).for_each(|a| a.truncate(n));
    let mut f = Fields { incident: vec![[0.0; 3]; n], direct: vec![[0.0; 3]; n], ..Fields::default() };
    let mut list = Vec::new();
    for ((source, ended), incident) in site.sources.iter().zip(&*ended).zip(&mut arriving) {
        let (own, sky) = (source.direct(site.direct), source.sky(site.scene));
        incident.par_iter_mut().enumerate().for_each(|(i, h)| {
            let (_, measure) = response(zones, i);
            let [incoming, _] = escape.incoming(i, sky);
            // `max` would make nothing of what is not a number.
            let raised = |x: f64| if x < least { least } else { x };
            *h = bands(|b| raised((h[b] + incoming[b]) / measure));
        });
        let balance = |incident: &[Bands]| {
            let found = Found { incident, direct: &own, strengths: &ended.strengths };
            energy::balance(site.scene, zones, source, &found, escape, site.direct)
        };
        let mut energy = balance(incident);
        if uneven {
            let change = even(zones, &energy, incident, site.scene.options().tolerance);
            built.closure.0.evened(change);
            changed
                .iter_mut()
                .zip(&*incident)
                .for_each(|(c, h)| *c = bands(|b| c[b] + change[b].abs() * h[b]));
            energy = balance(incident);
        }
        f.incident.par_iter_mut().zip(&*incident).for_each(|(f, h)| *f = bands(|b| f[b] + h[b]));
        own.iter().zip(&mut f.direct).for_each(|(d, f)| *f = bands(|b| f[b] + d[b]));
        let mut group = group(source, ended, energy, std::mem::take(incident), own, engine);
        let off = direct_error::of_group(source, site.direct);
        if !off.is_empty() {
            f.direct_error.resize(n, [0.0; 3]);
            f.direct_error.iter_mut().zip(&off).for_each(|(f, e)| *f = bands(|b| f[b] + e[b]));
            group.direct_error = like(&group.direct, &off, group.direct_scale);
        }
        list.push(group);
    }
    f.radiosity = (0..n)
        .into_par_iter()
        .map(|i| {
            let (e, (rho, _)) = (emission(zones, i), response(zones, i));
            bands(|b| e[b] + rho[b] * (f.incident[i][b] + f.direct[i][b]))
        })
        .collect();
    f.error = match error {
        Some(mut errors) => {
            errors.par_iter_mut().enumerate().for_each(|(i, e)| *e = e.map(|e| e / response(zones, i).1));
            errors
        }
        None => by_rows(site, built, &missed, ended, &mut list),
    };
    direct_error::reach(site, built.operator.as_ref(), &mut f, &mut list);
    consistency::closure(&missed, &mut f);
    consistency::steps(zones, &list, &mut f);
    f.error.iter_mut().zip(changed).for_each(|(e, c)| *e = bands(|b| e[b] + c[b]));
    if !escape.error.is_empty() {
        let sky = site.scene.surroundings().radiosity();
        let part = |i| escape.incoming(i, sky)[1].map(|e| e / response(zones, i).1);
        f.surroundings_error = (0..n).into_par_iter().map(part).collect();
        let both = f.error.par_iter_mut().zip(&f.surroundings_error);
        both.for_each(|(e, part)| *e = bands(|b| e[b].hypot(part[b])));
    }
    if !takes_power(zones) {
        consistency::negative_flux(&mut f);
    }
    (f, list)
}

/// A group as a solution keeps it: what a dense solve found to the bit, what a hierarchical one found in single precision, far
/// finer than its tolerance.
fn group(
    source: &Source,
    ended: &Ended,
    energy: Energy,
    incident: Vec<Bands>,
    direct: Vec<Bands>,
    engine: Engine,
) -> Group {
    let kept = |v: Vec<Bands>| match engine {
        Engine::Hierarchical if !v.is_empty() => Values::compact(&v),
        _ => (Values::Double(v), [1.0; 3]),
    };
    let ((incident, incident_scale), (direct, direct_scale)) = (kept(incident), kept(direct));
    Group {
        name: source.name.clone(),
        kind: source.kind,
        incident,
        incident_scale,
        direct,
        direct_error: Values::default(),
        direct_scale,
        energy,
        status: ended.status,
        residual: [0, 1, 2].map(|b| ended.residuals[b].last().copied().unwrap_or(0.0)),
        error: Values::default(),
    }
}

/// Standard error of the power that escapes, from rays of their own of each zone, W a band.
fn escape_error(zones: &Zones, escape: &Escape, ended: &[Ended]) -> Bands {
    if escape.closed() || escape.rays == 0 {
        return [0.0; 3];
    }
    let one = |i: usize| {
        let (t, sent) =
            (target(zones, i), ended.iter().fold([0.0; 3], |s, e| bands(|b| s[b] + e.strengths[i][b])));
        let spread = escape.spread(i, t);
        bands(|b| (spread[b] * t * sent[b]).powi(2))
    };
    crate::columns::sum::<3>(zones.len(), one).map(f64::sqrt)
}

/// Estimated error of what arrives at every zone, W/m², from the errors of the factors, group by group; put into the groups, and their sum,
/// which is no less than the error of all together. A row misses closure by the error of what escapes, which brings no light, and by what the
/// factors have in common, which no sum of squares tells: what it misses beyond twice the former counts as the same share of all that arrives.
/// Where closure was restored, the whole change of the row does.
fn by_rows(
    site: &Site,
    built: &Built,
    missed: &[Bands],
    ended: &[Ended],
    groups: &mut [Group],
) -> Vec<Bands> {
    let zones = site.zones;
    let mut sum = vec![[0.0; 3]; zones.len()];
    for (group, ended) in groups.iter_mut().zip(ended) {
        let spread = built.operator.error(&ended.strengths).unwrap_or_else(|| vec![[0.0; 3]; zones.len()]);
        let one = |i: usize| {
            let (e, incident) = (spread[i].map(|e| e / response(zones, i).1), group.incident.at(i));
            bands(|b| e[b] + radii::of_share(missed[i][b], incident[b] * group.incident_scale[b]))
        };
        let error: Vec<Bands> = (0..zones.len()).into_par_iter().map(one).collect();
        sum.iter_mut().zip(&error).for_each(|(s, e)| *s = bands(|b| s[b] + e[b]));
        group.error = like(&group.incident, &error, group.incident_scale);
    }
    sum
}

/// Errors over `scale`, in the precision of `values`.
pub(crate) fn like(values: &Values, errors: &[Bands], scale: Bands) -> Values {
    let own = |e: &Bands| bands(|b| e[b] / scale[b]);
    match values {
        Values::Double(_) => Values::Double(errors.iter().map(own).collect()),
        Values::Single(_) => Values::Single(errors.iter().map(|e| own(e).map(|x| x as f32)).collect()),
    }
}

/// The worst end of all groups, and the power that all together have not distributed.
fn together(ended: &[Ended]) -> ([SolveStatus; 3], [Vec<f64>; 3]) {
    let rank = |s: SolveStatus| SolveStatus::ALL.iter().position(|x| *x == s);
    let worst = |b: usize| ended.iter().map(|e| e.status[b]).max_by_key(|s| rank(*s));
    let status = [0, 1, 2].map(|b| worst(b).unwrap_or(SolveStatus::Converged));
    let residuals = [0, 1, 2].map(|b| {
        let steps = ended.iter().map(|e| e.residuals[b].len()).max().unwrap_or(0);
        let power: f64 = ended.iter().map(|e| e.power[b]).sum();
        let at =
            |e: &Ended, k: usize| e.residuals[b].get(k).or(e.residuals[b].last()).copied().unwrap_or(0.0);
        let left = |k: usize| ended.iter().map(|e| at(e, k) * e.power[b]).sum::<f64>();
        (0..steps).map(|k| if power > 0.0 { left(k) / power } else { 0.0 }).collect()
    });
    (status, residuals)
}

fn report(
    site: &Site,
    built: &Built,
    escape: &Escape,
    (fields, energy): (&Fields, Energy),
    ended: &[Ended],
    thickness: f64,
) -> Report {
    let mut warnings = forecast::warnings(site.scene, thickness, built.operator.len() == site.zones.len());
    warnings.extend(built.warnings.iter().cloned());
    warnings.extend(undershoot(site, fields));
    if !escape.closed() {
        let text = "the scene is open: power escapes to the surroundings or onto black backs";
        warnings.push(Note::new("open-scene", text));
    }
    warnings.extend(site.direct.warnings());
    if site.scene.thermal().is_none() {
        let short = ended.iter().flat_map(|e| e.status).any(|s| s == SolveStatus::Budget);
        warnings.extend(notes::of_light(&energy, site.scene.options(), site.scene.restores_closure(), short));
    }
    let (status, residuals) = together(ended);
    let mut closure = built.closure.0.clone();
    closure.largest_change = closure.largest_change.map(|c| c.max(site.direct.largest_change()));
    // The spectral engine knows what escapes without a ray.
    let measured = escape.rays > 0 && !escape.closed();
    let grade = if measured { Grade::Statistical } else { built.operator.grade() };
    let sampled = site.direct.lights.iter().any(|l| !l.by_exchange);
    let of_light = if sampled { Grade::Statistical } else { Grade::Estimated };
    Report {
        status,
        residuals,
        estimate: Estimate::of(fields, site.zones.voxel_offset(), grade.max(of_light)),
        closure,
        energy,
        counts: counts(site.zones, built, escape),
        warnings,
        grade,
        ..Report::default()
    }
}

/// True where powers are taken away from zones, which may leave less than nothing to arrive.
fn takes_power(zones: &Zones) -> bool {
    (0..zones.len()).into_par_iter().any(|i| emission(zones, i).iter().any(|e| *e < 0.0))
}

/// What a user should know of zones whose slopes are steeper than what they hold.
fn undershoot(site: &Site, fields: &Fields) -> Option<Note> {
    let most = fields.incident.iter().flatten().fold(0.0f64, |m, x| m.max(*x));
    if most <= 0.0 || takes_power(site.zones) {
        return None;
    }
    let below = || fields.incident.iter().filter(|h| h.iter().any(|x| *x < -UNDERSHOOT * most));
    let least = below().flatten().fold(0.0f64, |m, x| m.min(*x));
    (least < 0.0).then(|| {
        let text = format!(
            "less than nothing arrives at {} zone(s), down to {:.1e} of the most: light falls off too steeply for these voxels, use more cells",
            below().count(),
            least / most
        );
        Note::warning("negative-flux", text)
    })
}

fn counts(zones: &Zones, built: &Built, escape: &Escape) -> Vec<(String, u64)> {
    let first = [
        ("zones", zones.len()),
        ("patches", zones.patches.len()),
        ("voxel zones", zones.voxels.len()),
        ("pane zones", zones.panes.len()),
    ];
    let mut out: Vec<(String, u64)> = first.into_iter().map(|(k, v)| (k.to_string(), v as u64)).collect();
    out.extend(built.counts.iter().cloned());
    out.extend((escape.rays > 0).then(|| ("rays to the surroundings".into(), escape.rays)));
    out
}
