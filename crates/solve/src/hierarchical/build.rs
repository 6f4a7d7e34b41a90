//! From a scene to an engine that meets its tolerance: rays from every zone first, more of them while few are missing, then links.

use super::budget::Budget;
use super::closure;
use super::seeing::{Looked, Seeing};
use super::views::Measured;
use super::{Factors, Hierarchical, Rough, Seen, told};
use crate::columns::total;
use crate::dense;
use crate::engine::{self, Built, Site};
use crate::groups::response;
use crate::krylov::Ended;
use crate::operator::Arriving;
use crate::surroundings::Escape;
use zonal_math::Grade;
use zonal_scene::{Bands, Estimate, Fields, Note, Scene, SceneError, Zones, bands};

/// Times that rays are shot anew because more are wanted.
const LOOKS: usize = 3;
/// Refinements at most.
const ROUNDS: usize = 6;
/// ε of the first refinement over the tolerance.
const FIRST: f64 = 0.6;
/// Zones above which rays alone answer, shot once; those that end close by go on.
const ONCE: usize = 200_000;
/// Zones above which links that are better than rays cost more than anyone waits for: as many rays as may be are shot instead.
const MOST_LINKED: usize = 60_000;
/// What to say where links that would meet the tolerance are not made.
pub const NO_LINKS: &str =
    "memory does not allow the links that would meet the tolerance: allow more (--max-memory)";
/// The estimate of links falls with ε to the power of one over this.
const STEEPNESS: f64 = 1.8;
/// Range of the factor by which ε falls at a time.
const STEP: [f64; 2] = [0.2, 0.7];
/// An estimate that a refinement leaves above so much of what it was has come to the errors of single pairs.
const LITTLE: f64 = 0.9;
/// Share of all pairs of zones above which links that do not serve cost more than every pair would.
const EVERY: f64 = 0.3;
/// Rays whose estimate is so many times that of the links cannot judge them, nor help.
const BLIND: f64 = 6.0;

/// What rays from every zone say.
struct Look<'a> {
    seeing: Seeing<'a>,
    /// Without their strengths, which are in `known`.
    ended: Vec<Ended>,
    /// In the unit of P.
    arriving: Seen,
    known: Rough,
    estimate: f64,
    /// Rays that were shot again.
    again: u64,
}

/// Builds the engine for all light groups of a scene: what rays from every zone say where that meets the tolerance, else links, refined
/// until their estimate meets it.
pub fn build<'a>(site: &Site<'a>, escape: &mut Escape) -> Result<Built<'a>, SceneError> {
    let (zones, tolerance) = (site.zones, site.scene.options().tolerance);
    if zones.is_empty() {
        return Err(SceneError::new("scene", "the scene has no zones; add a surface or a medium"));
    }
    let budget = Budget::new(site.scene, zones, site.transport, site.memory);
    let mut each = budget.each(zones, tolerance).ok_or_else(|| {
        SceneError::new("solve.patch_size", "memory allows too few rays; allow more (--max-memory)")
    })?;
    let mut look = Look::new(site, escape, each);
    let many = beyond_links(zones);
    let linked = within_links(zones);
    let barred = linked && !budget.holds_links(zones, tolerance);
    for _ in 1..if many { 1 } else { LOOKS } {
        let more = super::seeing::more(zones, each, look.estimate / tolerance, budget.rays, linked);
        if look.estimate <= tolerance || more == each {
            break;
        }
        each = more;
        // Its rays go first: both would not fit.
        drop(look);
        look = Look::new(site, escape, each);
    }
    let met = look.estimate <= tolerance;
    // Rays that lead to no finite light have nothing to say to links: the solve ends with what is wrong.
    let finite = |k: &(Vec<Bands>, Vec<Bands>)| k.1.iter().flatten().all(|x| x.is_finite());
    if met || !linked || barred || !look.known.iter().all(finite) {
        let closure = crate::closure::measure(&look.seeing, zones, escape);
        let [rays, onward] = look.seeing.rays();
        let counts =
            [("rays of views", rays), ("rays that went on", onward), ("rays shot again", look.again)];
        let counts = counts.map(|(k, v)| (k.to_string(), v)).to_vec();
        let arriving = Arriving { columns: look.arriving.columns, error: Some(look.arriving.error) };
        let mut ended = look.ended;
        ended.iter_mut().zip(look.known).for_each(|(e, k)| e.strengths = k.0);
        let (operator, solved) = (Box::new(look.seeing), Some((ended, arriving)));
        let mut warnings: Vec<Note> = budget.note(zones, tolerance, each).into_iter().collect();
        if !met {
            // No tolerance asks for more.
            let all = each == super::seeing::rays(zones, f64::MIN_POSITIVE, f64::INFINITY);
            warnings.push(unmet(look.estimate, tolerance, all && !linked));
            warnings.extend(barred.then(|| Note::warning("memory", NO_LINKS)));
        }
        return Ok(Built { operator, closure, counts, warnings, solved });
    }
    let note = budget.note(zones, tolerance, each);
    let mut built = links(site, escape, look, &budget)?;
    built.warnings.extend(note);
    Ok(built)
}

/// True where zones are so many that rays alone answer, shot once.
pub fn beyond_links(zones: &Zones) -> bool {
    zones.len() > ONCE
}

/// True where links are worth it if rays fall short.
pub fn within_links(zones: &Zones) -> bool {
    zones.len() <= MOST_LINKED
}

/// True where the rays of the views say what leaves the scene: they are the answer, and nothing comes in that way.
pub fn tells_escape(scene: &Scene, zones: &Zones) -> bool {
    beyond_links(zones) && !scene.surroundings().shine()
}

impl<'a> Look<'a> {
    fn new(site: &Site<'a>, escape: &mut Escape, each: [usize; 2]) -> Look<'a> {
        // Of few zones the answer is that of constant zones, as the dense engine's is; light followed so many times is counted by zones.
        let onward = beyond_links(site.zones) && site.scene.options().sweeps.is_none();
        let mut seeing = Seeing::new(site, each, onward);
        if tells_escape(site.scene, site.zones) {
            seeing.escape(escape);
        }
        let mut ended = seeing.solve(site, escape);
        let strengths: Vec<Vec<Bands>> = ended.iter_mut().map(|e| std::mem::take(&mut e.strengths)).collect();
        let Looked { arriving: Arriving { columns, error }, raw, even, again } = seeing.look(&strengths);
        let over = |i: usize, v: Bands| v.map(|x| x / response(site.zones, i).1);
        let field = |p: &Vec<Bands>| p.iter().enumerate().map(|(i, v)| over(i, *v)).collect();
        let arriving = Seen { columns, error: error.unwrap_or_default(), raw };
        let known: Rough = strengths.into_iter().zip(arriving.columns.iter().map(field)).collect();
        let value = total(site.zones.len(), known.iter().map(|k| &k.1));
        let error = arriving.error.iter().enumerate().map(|(i, e)| over(i, *e));
        let seen: Vec<Measured> =
            value.into_iter().zip(error).map(|(value, error)| Measured { value, error }).collect();
        // Lights may be turned up later: each alone is to be as good.
        let estimate = relative(site, escape, &seen).max(even);
        Look { seeing, ended, arriving, known, estimate, again }
    }
}

/// Estimated relative error with what comes in from the surroundings, the largest over kinds and bands.
fn relative(site: &Site, escape: &Escape, all: &[Measured]) -> f64 {
    let sky = site.scene.surroundings().radiosity();
    let whole = |(i, m): (usize, &Measured)| {
        let ([value, error], measure) = (escape.incoming(i, sky), response(site.zones, i).1);
        let error = bands(|b| m.error[b].hypot(error[b] / measure));
        (error, bands(|b| m.value[b] + value[b] / measure))
    };
    let (error, incident) = all.iter().enumerate().map(whole).unzip();
    let fields = Fields { error, incident, ..Fields::default() };
    let e = Estimate::of(&fields, site.zones.voxel_offset(), Grade::Estimated);
    e.patches.iter().chain(&e.volumes).fold(0.0, |m, x| m.max(*x))
}

/// What to say where the tolerance is missed; `all` where no more rays are ever shot.
fn unmet(estimate: f64, tolerance: f64, all: bool) -> Note {
    let mend = match all {
        true => {
            "no more rays are shot of so many zones; use fewer (patch_size, cells), or a larger tolerance"
        }
        false => "give a smaller tolerance",
    };
    let text = format!("the estimated error, {estimate:.1e}, is above the tolerance {tolerance}: {mend}");
    Note::warning("tolerance", text)
}

/// Whether memory holds a factor for every pair.
fn every_pair_fits(site: &Site) -> bool {
    let (_, groups) = dense::groups(site.scene, site.transport.has_panes_between());
    dense::bytes(site.zones.len(), site.zones.panes.len(), groups) <= site.memory
}

/// Every pair of zones, as the dense engine has them: what links come to in the end.
fn every_pair(site: &Site, escape: &mut Escape, views: u64) -> Built<'static> {
    let mut built = engine::dense(site, escape);
    let n = site.zones.len() as u64;
    built.counts.extend([("pairs of zones, all".into(), n * (n + 1) / 2), ("rays of views".into(), views)]);
    built
}

/// The engine by links, beside what the rays say.
fn links<'a>(
    site: &Site<'a>,
    escape: &mut Escape,
    look: Look<'a>,
    budget: &Budget,
) -> Result<Built<'a>, SceneError> {
    let (zones, tolerance) = (site.zones, site.scene.options().tolerance);
    let factors = Factors::new(site);
    // What rays say joins that of links where both follow light to its end.
    let whole = site.scene.options().sweeps.is_none();
    let [views, _] = look.seeing.rays();
    drop(look.seeing);
    let mut made = Hierarchical::new(site, look.known, &factors, FIRST * tolerance)
        .ok_or_else(|| SceneError::new("scene", "the scene has no zones; add a surface or a medium"))?;
    let mut warnings = Vec::new();
    let (mut before, mut joined) = (f64::INFINITY, whole);
    let mut held = 0;
    for round in 1.. {
        held = closure::hold(&mut made, zones, escape);
        made.solve_roughly(site, escape);
        let rough = made.rough();
        let errors = rough.error.iter().map(|e| told(*e));
        let alone = relative(site, escape, &made.measured(&rough.columns, errors));
        joined = whole && look.estimate < BLIND * alone;
        let estimate = match joined {
            true => {
                let both = made.joined(&look.arriving, rough);
                let errors = both.error.unwrap_or_default().into_iter();
                relative(site, escape, &made.measured(&both.columns, errors))
            }
            false => alone,
        };
        if estimate <= tolerance {
            break;
        }
        if made.links.len() as f64 > EVERY * (zones.len() as f64).powi(2) && every_pair_fits(site) {
            drop(made);
            return Ok(every_pair(site, escape, views));
        }
        if round >= ROUNDS || estimate > LITTLE * before {
            warnings.push(unmet(estimate, tolerance, false));
            break;
        }
        before = estimate;
        let step = (tolerance / estimate).powf(STEEPNESS).clamp(STEP[0], STEP[1]);
        if made.links.len() as f64 / step * budget.link > budget.links {
            warnings.extend([unmet(estimate, tolerance, false), Note::warning("memory", NO_LINKS)]);
            break;
        }
        made.epsilon *= step;
        made.refine(site, &factors);
    }
    made.seen = joined.then_some(look.arriving);
    let measured = crate::closure::measure(&made, zones, escape);
    let closure = match site.scene.restores_closure() {
        true => closure::restore(&mut made, site, escape, measured),
        false => measured,
    };
    let t = &made.tally;
    let list = [
        ("inner nodes", made.tree.inner as u64),
        ("links, each direction", made.links.len() as u64),
        ("bytes of links", made.links.bytes()),
        ("pairs of clusters looked at", t.visits),
        ("pairs that nothing can divide", t.clear),
        ("pairs split for what hides them", t.split_by_sight),
        ("pairs of near zones", t.near),
        ("pairs of zones in full", t.exact),
        ("rays between clusters", t.rays),
        ("rows of links held to closure", held as u64),
        ("rays of views", views),
    ];
    Ok(Built {
        operator: Box::new(made),
        closure,
        counts: list.into_iter().map(|(k, v)| (k.to_string(), v)).collect(),
        warnings,
        solved: None,
    })
}
