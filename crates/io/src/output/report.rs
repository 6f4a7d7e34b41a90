//! The report as JSON, and back: shared by `--json` and by the header of solution files.
//!
//! Lists over bands have three numbers. A number that is not finite is `null`.

use super::heat;
use super::notes::{note_in, notes_json};
use serde_json::{Value, json};
use zonal_math::Grade;
use zonal_scene::solution::{Closure, Energy};
use zonal_scene::{Bands, Estimate, Group, Kind, Note, Report, Solution, SolveStatus, Zoning, printable};

/// The report of a solution as a JSON document: zones, engine, status, residuals, estimate, closure, energy (W), light groups, counts,
/// warnings, provenance.
pub fn report_json(s: &Solution) -> Value {
    let mut v = encode(&s.report);
    v["groups"] = s.groups.iter().map(group_out).collect();
    v["scene"] = json!(s.scene.name());
    v["zones"] = json!({
        "patches": s.zones.patches.len(),
        "voxels": s.zones.voxels.len(),
        "panes": s.zones.panes.len(),
    });
    v["provenance"] = json!({
        "scene_hash": s.scene_hash,
        "scene_hash_function": "FNV-1a over 64-bit words, 128 bits",
        "version": s.version,
        "tolerance": s.scene.options().tolerance,
        "grade": s.report.grade.word(),
    });
    v
}

/// A light group without its fields.
fn group_out(g: &Group) -> Value {
    json!({
        "name": g.name, "of": kind_out(g.kind), "status": g.status.map(SolveStatus::word), "residual": g.residual,
        "incident_scale": g.incident_scale, "direct_scale": g.direct_scale, "energy": energy_out(&g.energy),
    })
}

/// The group in a JSON document that [`group_out`] wrote, without its fields.
pub(super) fn group_in(v: &Value) -> Result<Group, String> {
    Ok(Group {
        name: text(v, "name")?,
        kind: kind_in(&v["of"])?,
        incident_scale: factors(v, "incident_scale")?,
        direct_scale: factors(v, "direct_scale")?,
        energy: energy_in(&v["energy"])?,
        status: statuses(v)?,
        residual: report_bands(v, "residual")?,
        ..Group::default()
    })
}

/// What a group consists of: a word, and the number of a light or surface.
fn kind_out(k: Kind) -> Value {
    match k {
        Kind::Light(l) => json!(["light", l]),
        Kind::Surface(s) => json!(["surface", s]),
        Kind::Medium => json!(["medium"]),
        Kind::Panes => json!(["panes"]),
        Kind::Surroundings => json!(["surroundings"]),
        Kind::All => json!(["all"]),
    }
}

fn kind_in(v: &Value) -> Result<Kind, String> {
    let number = || v[1].as_u64().map(|n| n as usize).ok_or("of: a number is missing");
    match v[0].as_str() {
        Some("light") => Ok(Kind::Light(number()?)),
        Some("surface") => Ok(Kind::Surface(number()?)),
        Some("medium") => Ok(Kind::Medium),
        Some("panes") => Ok(Kind::Panes),
        Some("surroundings") => Ok(Kind::Surroundings),
        Some("all") => Ok(Kind::All),
        _ => Err("of: is not a kind of light group".into()),
    }
}

fn energy_out(e: &Energy) -> Value {
    let named: Vec<Value> = e.absorbed_surfaces.iter().map(|(n, p)| json!({"name": n, "power": p})).collect();
    json!({
        "unit": "W",
        "emitted": e.emitted, "incoming": e.incoming, "absorbed_surfaces": named,
        "absorbed_volumes": e.absorbed_volumes, "absorbed_panes": e.absorbed_panes,
        "escaped": e.escaped, "backs": e.backs, "residual": e.residual,
    })
}

fn energy_in(e: &Value) -> Result<Energy, String> {
    Ok(Energy {
        emitted: report_bands(e, "emitted")?,
        incoming: report_bands(e, "incoming")?,
        absorbed_surfaces: list(e, "absorbed_surfaces")?
            .iter()
            .map(|x| Ok((text(x, "name")?, report_bands(x, "power")?)))
            .collect::<Result<_, String>>()?,
        absorbed_volumes: report_bands(e, "absorbed_volumes")?,
        absorbed_panes: report_bands(e, "absorbed_panes")?,
        escaped: report_bands(e, "escaped")?,
        backs: report_bands(e, "backs")?,
        residual: report_bands(e, "residual")?,
    })
}

pub(super) fn encode(r: &Report) -> Value {
    let (c, e) = (&r.closure, &r.estimate);
    let counts: Vec<Value> = r.counts.iter().map(|(n, k)| json!({"name": n, "count": k})).collect();
    json!({
        "engine": r.engine,
        "reason": r.reason,
        "status": r.status.map(SolveStatus::word),
        "residuals": r.residuals,
        "estimate": {"patches": e.patches, "volumes": e.volumes, "grade": e.grade.word()},
        "closure": {
            "worst": c.worst, "rms": c.rms, "largest_change": c.largest_change, "after": c.after, "restored": c.restored,
        },
        "energy": energy_out(&r.energy),
        "energy_error": energy_out(&r.energy_error),
        "heat": heat::report_out(r.heat.as_ref(), r.zoning.as_ref()),
        "zoning": r.zoning.as_ref().map(|z| json!({
            "zones": z.zones, "ratio": z.ratio, "energy": energy_out(&z.energy), "grade": Grade::Estimated.word(),
            "notes": notes_json(&z.notes),
        })),
        "counts": counts,
        "warnings": notes_json(&r.warnings),
        "grade": r.grade.word(),
    })
}

/// The report in a JSON document that [`encode`] wrote; the error names the key.
pub(super) fn decode(v: &Value) -> Result<Report, String> {
    let (c, e) = (&v["closure"], &v["estimate"]);
    let residuals = list(v, "residuals")?;
    if residuals.len() != 3 {
        return Err("report.residuals: there must be one entry a band".into());
    }
    Ok(Report {
        engine: text(v, "engine")?,
        reason: text(v, "reason")?,
        status: statuses(v)?,
        estimate: Estimate {
            patches: report_bands(e, "patches")?.map(unknown),
            volumes: report_bands(e, "volumes")?.map(unknown),
            grade: grade_of(e)?,
        },
        residuals: [reals(&residuals[0])?, reals(&residuals[1])?, reals(&residuals[2])?],
        closure: Closure {
            worst: report_bands(c, "worst")?,
            rms: report_bands(c, "rms")?,
            largest_change: report_bands(c, "largest_change")?,
            after: report_bands(c, "after")?,
            restored: c["restored"].as_bool().ok_or("report.closure.restored: is missing")?,
        },
        energy: energy_in(&v["energy"])?,
        energy_error: errors_in(&v["energy_error"])?,
        heat: heat::report_in(&v["heat"]).map_err(|e| format!("report.heat.{e}"))?,
        zoning: zoning_in(v)?,
        counts: list(v, "counts")?
            .iter()
            .map(|x| Ok((text(x, "name")?, x["count"].as_u64().ok_or("report.counts: a count is missing")?)))
            .collect::<Result<_, String>>()?,
        warnings: notes(v, "warnings")?,
        grade: grade_of(v)?,
    })
}

/// An error that was written as null is not known.
fn unknown(error: f64) -> f64 {
    if error.is_nan() { f64::INFINITY } else { error }
}

/// Errors of the powers of a balance, infinite where they are not known, which was written as null.
fn errors_in(v: &Value) -> Result<Energy, String> {
    let errors = energy_in(v)?;
    Ok(errors.compared(&errors, |x, _| unknown(x)))
}

/// What the size of the zones costs; none in files that do not say.
fn zoning_in(v: &Value) -> Result<Option<Zoning>, String> {
    let z = &v["zoning"];
    if z.is_null() {
        return Ok(None);
    }
    Ok(Some(Zoning {
        zones: z["zones"].as_u64().ok_or("report.zoning.zones: a whole number is missing")? as usize,
        // Written as null where there was no second solve, as are errors that are unknown.
        ratio: z["ratio"].as_f64().unwrap_or(f64::INFINITY),
        heat: heat::zoning_in(&v["heat"])?,
        energy: errors_in(&z["energy"])?,
        notes: notes(z, "notes")?,
    }))
}

/// The notes of a list.
fn notes(v: &Value, key: &str) -> Result<Vec<Note>, String> {
    let one = |w: &Value| note_in(w).map_err(|e| format!("report.{key}: {e}"));
    list(v, key)?.iter().map(one).collect()
}

fn statuses(v: &Value) -> Result<[SolveStatus; 3], String> {
    match list(v, "status")?.as_slice() {
        [a, b, c] => Ok([status_of(a)?, status_of(b)?, status_of(c)?]),
        _ => Err("report.status: there must be one entry a band".into()),
    }
}

fn status_of(v: &Value) -> Result<SolveStatus, String> {
    SolveStatus::ALL
        .into_iter()
        .find(|s| v.as_str() == Some(s.word()))
        .ok_or_else(|| format!("report.status: {v} is not a status"))
}

fn grade_of(v: &Value) -> Result<Grade, String> {
    [Grade::Proved, Grade::Estimated, Grade::Statistical]
        .into_iter()
        .find(|g| v["grade"].as_str() == Some(g.word()))
        .ok_or_else(|| "report.grade: is not a grade".into())
}

/// The list at a key.
pub(super) fn list<'a>(v: &'a Value, key: &str) -> Result<&'a Vec<Value>, String> {
    v[key].as_array().ok_or_else(|| format!("{key}: a list is missing"))
}

/// The text at a key.
pub(super) fn text(v: &Value, key: &str) -> Result<String, String> {
    // A file may say anything; what would steer a terminal is spelled out.
    let text = v[key].as_str().map(|t| printable(t).into_owned());
    text.ok_or_else(|| format!("{key}: a text is missing"))
}

/// The number at a key.
pub(super) fn real(v: &Value, key: &str) -> Result<f64, String> {
    v[key].as_f64().ok_or_else(|| format!("{key}: a number is missing"))
}

/// Three numbers at a key.
pub(super) fn bands(v: &Value, key: &str) -> Result<Bands, String> {
    let list = list(v, key)?;
    match list.as_slice() {
        [a, b, c] => match (a.as_f64(), b.as_f64(), c.as_f64()) {
            (Some(a), Some(b), Some(c)) => Ok([a, b, c]),
            _ => Err(format!("{key}: an entry is not a number")),
        },
        _ => Err(format!("{key}: there must be three numbers")),
    }
}

/// As [`bands`], none below 0.
fn factors(v: &Value, key: &str) -> Result<Bands, String> {
    match bands(v, key)? {
        f if f.iter().all(|x| x.is_finite() && *x >= 0.0) => Ok(f),
        _ => Err(format!("{key}: a factor is below 0 or not finite")),
    }
}

fn reals(v: &Value) -> Result<Vec<f64>, String> {
    let list = v.as_array().ok_or("report.residuals: a list is missing")?;
    Ok(list.iter().map(|x| x.as_f64().unwrap_or(f64::NAN)).collect())
}

/// As [`bands`], with null for numbers that were not finite.
fn report_bands(v: &Value, key: &str) -> Result<Bands, String> {
    match list(v, key)?.as_slice() {
        [a, b, c] => Ok([a, b, c].map(|x| x.as_f64().unwrap_or(f64::NAN))),
        _ => Err(format!("report.{key}: there must be three numbers")),
    }
}
