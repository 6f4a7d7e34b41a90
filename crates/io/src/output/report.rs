//! The report as JSON, and back: shared by `--json` and by the header of solution files.
//!
//! Lists over bands have three numbers. A number that is not finite is `null`.

use serde_json::{Value, json};
use zonal_math::Grade;
use zonal_scene::solution::{Closure, Energy};
use zonal_scene::{Bands, Report, Solution, SolveStatus};

/// The report of a solution as a JSON document: zones, status, residuals, closure, energy (W), counts, warnings, provenance.
pub fn report_json(s: &Solution) -> Value {
    let mut v = encode(&s.report);
    v["scene"] = json!(s.scene.name());
    v["zones"] = json!({
        "patches": s.zones.patches.len(),
        "voxels": s.zones.voxels.len(),
        "panes": s.zones.panes.len(),
    });
    v["provenance"] = json!({
        "scene_hash": s.scene_hash,
        "scene_hash_function": "FNV-1a, 128 bits",
        "version": s.version,
        "tolerance": s.scene.options().tolerance,
        "grade": s.report.grade.word(),
    });
    v
}

pub(super) fn encode(r: &Report) -> Value {
    let (c, e) = (&r.closure, &r.energy);
    let named: Vec<Value> = e.absorbed_surfaces.iter().map(|(n, p)| json!({"name": n, "power": p})).collect();
    let counts: Vec<Value> = r.counts.iter().map(|(n, k)| json!({"name": n, "count": k})).collect();
    json!({
        "status": r.status.map(SolveStatus::word),
        "residuals": r.residuals,
        "closure": {
            "worst": c.worst, "rms": c.rms, "largest_change": c.largest_change, "after": c.after, "restored": c.restored,
        },
        "energy": {
            "unit": "W",
            "emitted": e.emitted, "incoming": e.incoming, "absorbed_surfaces": named,
            "absorbed_volumes": e.absorbed_volumes, "absorbed_panes": e.absorbed_panes,
            "escaped": e.escaped, "backs": e.backs, "residual": e.residual,
        },
        "counts": counts,
        "warnings": r.warnings,
        "grade": r.grade.word(),
    })
}

/// The report in a JSON document that [`encode`] wrote; the error names the key.
pub(super) fn decode(v: &Value) -> Result<Report, String> {
    let (c, e) = (&v["closure"], &v["energy"]);
    let status = list(v, "status")?;
    let residuals = list(v, "residuals")?;
    if status.len() != 3 || residuals.len() != 3 {
        return Err("report.status: there must be one entry a band".into());
    }
    Ok(Report {
        status: [status_of(&status[0])?, status_of(&status[1])?, status_of(&status[2])?],
        residuals: [reals(&residuals[0])?, reals(&residuals[1])?, reals(&residuals[2])?],
        closure: Closure {
            worst: report_bands(c, "worst")?,
            rms: report_bands(c, "rms")?,
            largest_change: report_bands(c, "largest_change")?,
            after: report_bands(c, "after")?,
            restored: c["restored"].as_bool().ok_or("report.closure.restored: is missing")?,
        },
        energy: Energy {
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
        },
        counts: list(v, "counts")?
            .iter()
            .map(|x| Ok((text(x, "name")?, x["count"].as_u64().ok_or("report.counts: a count is missing")?)))
            .collect::<Result<_, String>>()?,
        warnings: list(v, "warnings")?
            .iter()
            .map(|w| w.as_str().map(String::from).ok_or("report.warnings: an entry is no text".into()))
            .collect::<Result<_, String>>()?,
        grade: grade_of(v)?,
        ..Report::default()
    })
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
    v[key].as_str().map(String::from).ok_or_else(|| format!("{key}: a text is missing"))
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
