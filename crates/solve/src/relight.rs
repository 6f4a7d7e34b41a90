//! Lights turned up and down in a solution, without solving: the equations are linear in what shines.
//!
//! A relit solution is the solution of the scene with those lights changed, and says so: its scene, zones, fields, balance and report are
//! those of that scene. Its groups can be relit again; one that was put out stays out. (Solved afresh, a scene whose surroundings were
//! put out measures what escapes with fewer rays: there the two agree to the error of that.)
//!
//! A change of reflectance or albedo is not linear. [`repainted`] gives the scene to solve then; no factor depends on either.

use crate::consistency;
use crate::groups::{emission, response};
use rayon::prelude::*;
use zonal_scene::{
    Bands, Estimate, Fields, Group, Kind, Light, Note, Scene, SceneError, SceneParts, Solution, Values,
    Voxmap, Zones, bands,
};

fn times(a: Bands, f: Bands) -> Bands {
    bands(|b| a[b] * f[b])
}

/// The factor of every group, 1 where none is given; the error names a group that is unknown, named twice or out.
fn factors(groups: &[Group], wanted: &[(String, Bands)]) -> Result<Vec<Bands>, SceneError> {
    let names = || groups.iter().map(|g| g.name.as_str()).collect::<Vec<_>>().join(", ");
    if groups.is_empty() {
        return Err(SceneError::new("groups", "this solution keeps no light groups; solve the scene again"));
    }
    let mut out: Vec<Option<Bands>> = vec![None; groups.len()];
    for (name, factor) in wanted {
        let fail = |what: String| Err(SceneError::new(format!("light group '{name}'"), what));
        let Some(k) = groups.iter().position(|g| g.name == *name) else {
            return fail(format!("there is none of this name; the groups are: {}", names()));
        };
        if factor.iter().any(|f| !(f.is_finite() && *f >= 0.0)) {
            return fail("a factor must be a number from 0".into());
        }
        if out[k].replace(*factor).is_some() {
            return fail("two factors are given; give one".into());
        }
        let scale = &groups[k].direct_scale;
        if scale.iter().zip(&groups[k].incident_scale).all(|(d, i)| *d == 0.0 && *i == 0.0) {
            return fail("it was put out in this solution; relight the one that this came from".into());
        }
    }
    Ok(out.into_iter().map(|f| f.unwrap_or([1.0; 3])).collect())
}

/// Refuses factors that [`relight`] would refuse.
pub fn check(groups: &[Group], wanted: &[(String, Bands)]) -> Result<(), SceneError> {
    factors(groups, wanted).map(|_| ())
}

/// The solution for lights that shine so many times as strongly, group by group, a band.
pub fn relight(solution: Solution, wanted: &[(String, Bands)]) -> Result<Solution, SceneError> {
    let factors = factors(&solution.groups, wanted)?;
    let Solution { scene, mut zones, fields: old, mut groups, mut report, version, .. } = solution;
    let mut parts = scene.into_parts();
    let known = own_errors(&groups, zones.len());
    for (g, f) in groups.iter_mut().zip(&factors).filter(|(_, f)| **f != [1.0; 3]) {
        g.scale(*f);
        turn_parts(&mut parts, g.kind, *f)?;
        turn_zones(&mut zones, g.kind, *f);
    }
    let scene = Scene::new(parts)?;
    let sky = groups.iter().position(|g| matches!(g.kind, Kind::Surroundings | Kind::All));
    let sky = sky.map_or([1.0; 3], |k| factors[k]);
    let mut fields = sum(&zones, &groups, &old, (known, sky));
    report.zoning = None;
    report.energy = Default::default();
    groups.iter().for_each(|g| report.energy.add(&g.energy));
    report.residuals = [0, 1, 2].map(|b| vec![groups.iter().fold(0.0f64, |m, g| m.max(g.residual[b]))]);
    report.energy_error = consistency::of_powers(&zones, &report.energy, &fields, |i| fields.error_of_all(i));
    report.estimate = Estimate::of(&fields, zones.voxel_offset(), report.estimate.grade);
    report.warnings.extend(wanted.iter().map(|(name, f)| {
        let text = match f {
            [a, b, c] if a == b && b == c => format!("relit: {name} × {a}"),
            [a, b, c] => format!("relit: {name} × {a}, {b}, {c}"),
        };
        Note::new("relit", text)
    }));
    crate::finite::check(&scene, &zones, &mut fields, &mut groups, &mut report)?;
    Ok(Solution { scene, zones, fields, groups, report, scene_hash: String::new(), version })
}

/// The scene with what belongs to a group turned up or down.
fn turn_parts(parts: &mut SceneParts, kind: Kind, f: Bands) -> Result<(), SceneError> {
    let all = kind == Kind::All;
    for l in 0..parts.lights.len() {
        if all || kind == Kind::Light(l) {
            match &mut parts.lights[l] {
                Light::Sun { irradiance, .. } => *irradiance = times(*irradiance, f),
                Light::Sky { radiance, .. } => *radiance = times(*radiance, f),
                // Turned below where everything is.
                Light::Emitter { surface, .. } if !all => {
                    let e = &mut parts.surfaces[*surface].emission;
                    *e = times(*e, f);
                }
                Light::Emitter { .. } => {}
            }
        }
    }
    for (s, surface) in parts.surfaces.iter_mut().enumerate() {
        if all || kind == Kind::Surface(s) {
            surface.emission = times(surface.emission, f);
        }
    }
    if all || kind == Kind::Medium {
        parts.voxmap = parts.voxmap.take().map(|v| edited(v, |v| v.scale_sources(f))).transpose()?;
    }
    if all || kind == Kind::Panes {
        parts.panes.iter_mut().for_each(|p| p.emission = times(p.emission, f));
    }
    if all || kind == Kind::Surroundings {
        parts.surroundings.radiance = times(parts.surroundings.radiance, f);
    }
    Ok(())
}

fn edited(mut map: Voxmap, change: impl FnOnce(&mut Voxmap)) -> Result<Voxmap, SceneError> {
    change(&mut map);
    map.seal()
}

fn turn_zones(zones: &mut Zones, kind: Kind, f: Bands) {
    let all = kind == Kind::All;
    for p in zones.patches.iter_mut().filter(|p| all || kind == Kind::Surface(p.surface)) {
        p.emission = times(p.emission, f);
    }
    if all || kind == Kind::Medium {
        for v in &mut zones.voxels {
            (v.emission, v.source) = (times(v.emission, f), times(v.source, f));
        }
    }
    if all || kind == Kind::Panes {
        zones.panes.iter_mut().for_each(|p| p.emission = times(p.emission, f));
    }
}

/// The sum of the errors that are known of each group, W/m²; none where one's are not.
fn own_errors(groups: &[Group], zones: usize) -> Option<Vec<Bands>> {
    groups.iter().all(|g| !g.error.is_empty() || g.incident.is_empty()).then(|| {
        let mut out = vec![[0.0; 3]; zones];
        groups.iter().for_each(|g| g.error.add_to(&mut out, g.incident_scale));
        out
    })
}

/// The fields of all groups together. What comes in from the surroundings errs by as much as they are turned up, by `sky`. The rest of
/// the estimated error is that of the groups, whose sum was `known`; what it has beyond that, and all of it where it is not known of each group, stays
/// the same share of what arrives at a zone.
fn sum(zones: &Zones, groups: &[Group], old: &Fields, (known, sky): (Option<Vec<Bands>>, Bands)) -> Fields {
    let n = zones.len();
    let added = |pick: fn(&Group) -> (&Values, Bands)| {
        let mut out = vec![[0.0; 3]; n];
        groups.iter().map(pick).for_each(|(v, scale)| v.add_to(&mut out, scale));
        out
    };
    let incident = added(|g| (&g.incident, g.incident_scale));
    let direct = added(|g| (&g.direct, g.direct_scale));
    let direct_error = match groups.iter().any(|g| !g.direct_error.is_empty()) {
        true => added(|g| (&g.direct_error, g.direct_scale)),
        false => Vec::new(),
    };
    let radiosity = |i: usize| {
        let (e, (rho, _)) = (emission(zones, i), response(zones, i));
        bands(|b| e[b] + rho[b] * (incident[i][b] + direct[i][b]))
    };
    // The groups' own errors before they were turned, and after.
    let own = known.map(|before| (before, added(|g| (&g.error, g.incident_scale))));
    let error = |i: usize| {
        let grown =
            |b: usize| if old.incident[i][b] > 0.0 { incident[i][b] / old.incident[i][b] } else { 0.0 };
        let part = old.surroundings_error.get(i).copied().unwrap_or_default();
        let rest = |b: usize| {
            let all = (old.error[i][b].powi(2) - part[b].powi(2)).max(0.0).sqrt();
            match &own {
                Some((before, after)) => after[i][b] + beyond(all, before[i][b]) * grown(b),
                None => all * grown(b),
            }
        };
        bands(|b| rest(b).hypot(part[b] * sky[b]))
    };
    let part = |e: &Bands| times(*e, sky);
    Fields {
        surroundings_error: old.surroundings_error.par_iter().map(part).collect(),
        radiosity: (0..n).into_par_iter().map(radiosity).collect(),
        error: (0..n).into_par_iter().map(error).collect(),
        incident,
        direct,
        direct_error,
        heat: None,
    }
}

/// What an error has beyond the part of it that is `known`, rounding aside.
fn beyond(all: f64, known: f64) -> f64 {
    const ROUNDING: f64 = 1e-6;
    if all > known * (1.0 + ROUNDING) { all - known } else { 0.0 }
}

/// The scene with other reflectances of surfaces (by name, or the part of it before a dot or a slash) and, if given, one albedo of
/// all the medium.
pub fn repainted(
    scene: Scene,
    reflectances: &[(String, Bands)],
    albedo: Option<Bands>,
) -> Result<Scene, SceneError> {
    let mut parts = scene.into_parts();
    for (name, value) in reflectances {
        let belongs = |s: &str| {
            s.strip_prefix(name.as_str()).is_some_and(|r| r.is_empty() || r.starts_with(['.', '/']))
        };
        let mut found = false;
        for s in parts.surfaces.iter_mut().filter(|s| belongs(&s.name)) {
            (s.reflectance, found) = (*value, true);
        }
        if !found {
            const MOST: usize = 24;
            let names: Vec<&str> = parts.surfaces.iter().take(MOST).map(|s| s.name.as_str()).collect();
            return Err(SceneError::new(
                format!("surface '{name}'"),
                format!("there is none of this name; there are: {}", names.join(", ")),
            ));
        }
    }
    if let Some(albedo) = albedo {
        let Some(map) = parts.voxmap.take() else {
            return Err(SceneError::new("albedo", "the scene has no medium whose albedo could change"));
        };
        parts.voxmap = Some(edited(map, |v| v.set_albedo(albedo))?);
    }
    Scene::new(parts)
}
