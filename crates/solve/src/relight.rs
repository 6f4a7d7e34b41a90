//! Relighting: a solution with scaled lights, without a new solve, since the equations are linear in the sources.
//!
//! A relit solution is the solution of the scene with those lights scaled: scene, zones, fields, balance and report are those of that scene. Its groups
//! can be relit again; a group scaled to zero cannot. (A new solve of a scene whose surroundings were scaled to zero samples the escaping power with
//! fewer rays; the two agree to that error.)
//!
//! A change of reflectance or albedo is not linear. [`with_surface_colors`] gives the scene for a new solve; no factor depends on either.

use crate::distribution::sum_order::SharedZones;
use crate::errors::consistency;
use crate::errors::estimate::error_estimate;
use zonal_math::parallel;
use zonal_scene::{
    Band, Bands, Diagnostic, Fields, LightGroup, LightGroupKind, PerBand, Scene, SceneError, SceneParts,
    Solution, VoxelGrid, ZoneValues, Zones,
};

/// The factor of every group, 1 by default; an error for a group that is unknown, listed twice or scaled to zero.
fn factors(groups: &[LightGroup], wanted: &[(String, Bands)]) -> Result<Vec<Bands>, SceneError> {
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
        if factor.any(|f| !(f.is_finite() && f >= 0.0)) {
            return fail("a factor must be a number from 0".into());
        }
        if out[k].replace(*factor).is_some() {
            return fail("two factors are given; give one".into());
        }
        if groups[k].direct_scale == Bands::ZERO && groups[k].incident_scale == Bands::ZERO {
            return fail("it was scaled to zero in this solution; relight the original solution".into());
        }
    }
    Ok(out.into_iter().map(|f| f.unwrap_or(Bands::ONE)).collect())
}

/// Refuses factors that [`relight`] would refuse.
pub fn check(groups: &[LightGroup], wanted: &[(String, Bands)]) -> Result<(), SceneError> {
    factors(groups, wanted).map(|_| ())
}

/// The solution with the light groups of `wanted` scaled by a factor per band.
///
/// # Errors
/// For unknown, repeated or extinguished groups, and for factors that are negative or not finite.
pub fn relight(mut solution: Solution, wanted: &[(String, Bands)]) -> Result<Solution, SceneError> {
    let further = std::mem::take(&mut solution.further_blocks);
    if further.is_empty() {
        return relight_block(solution, wanted);
    }
    if let Some((name, _)) = wanted.iter().find(|(_, f)| !f.is_grey()) {
        let message = format!(
            "the solution has {} bands; give one factor for all of them",
            solution.scene.bands().count()
        );
        return Err(SceneError::new(name.as_str(), message));
    }
    solution.scene = solution.scene.first_block();
    let blocks = std::iter::once(solution).chain(further);
    let relit = blocks.map(|t| relight_block(t, wanted)).collect::<Result<Vec<_>, _>>()?;
    let scene = Scene::from_blocks(relit.iter().map(|s| s.scene.clone()).collect())?;
    Ok(Solution::of_blocks(scene, relit))
}

/// [`relight`] for one block of bands.
fn relight_block(solution: Solution, wanted: &[(String, Bands)]) -> Result<Solution, SceneError> {
    let factors = factors(&solution.groups, wanted)?;
    let Solution { scene, mut zones, fields: old, mut groups, mut report, version, .. } = solution;
    let mut parts = scene.into_parts();
    let known = sum_of_group_errors(&groups, zones.len());
    for (g, f) in groups.iter_mut().zip(&factors).filter(|(_, f)| **f != Bands::ONE) {
        g.scale(*f);
        scale_parts(&mut parts, g.kind, *f)?;
        scale_zones(&mut zones, g.kind, *f);
    }
    let scene = Scene::new(parts)?;
    let sky =
        groups.iter().position(|g| matches!(g.kind, LightGroupKind::Surroundings | LightGroupKind::All));
    let sky = sky.map_or(Bands::ONE, |k| factors[k]);
    let mut fields = sum_of_groups(&zones, &groups, &old, known, sky);
    report.discretization_error = None;
    report.energy = Default::default();
    groups.iter().for_each(|g| report.energy.add(&g.energy));
    report.residuals = PerBand::from_fn(|b| vec![groups.iter().fold(0.0f64, |m, g| m.max(g.residual[b]))]);
    report.energy_error =
        consistency::power_errors(SharedZones::alone(&zones), &report.energy, &fields, |i| {
            fields.total_error(i)
        });
    report.estimate = error_estimate(SharedZones::alone(&zones), &fields, report.estimate.grade);
    report.warnings.extend(wanted.iter().map(|(name, f)| {
        let text = if f.is_grey() {
            format!("relit: {name} × {}", f.first())
        } else {
            format!("relit: {name} × {}", f.iter().map(f64::to_string).collect::<Vec<_>>().join(", "))
        };
        Diagnostic::note("relit", text)
    }));
    crate::errors::finite::check_finite(&scene, &zones, &mut fields, &mut groups, &mut report)?;
    Ok(Solution {
        scene,
        zones,
        fields,
        groups,
        report,
        further_blocks: Vec::new(),
        scene_hash: String::new(),
        version,
    })
}

/// Scales the emission of a group in the scene.
fn scale_parts(parts: &mut SceneParts, kind: LightGroupKind, f: Bands) -> Result<(), SceneError> {
    let all = kind == LightGroupKind::All;
    for l in 0..parts.lights.len() {
        if all || kind == LightGroupKind::Light(l) {
            if let Some(strength) = parts.lights[l].strength_mut() {
                *strength *= f;
            }
            // Of all lights, the emission is scaled below with all surfaces.
            if let Some(surface) = parts.lights[l].surface().filter(|_| !all) {
                parts.surfaces[surface].emission *= f;
            }
        }
    }
    for (s, surface) in parts.surfaces.iter_mut().enumerate() {
        if all || kind == LightGroupKind::Surface(s) {
            surface.emission *= f;
        }
    }
    for (facet, values) in parts.facets.iter().zip(&mut parts.faces.values) {
        if all || kind == LightGroupKind::Surface(facet.surface) {
            values.emission = values.emission.map(|e| e * f);
        }
    }
    if all || kind == LightGroupKind::Medium {
        parts.voxel_grid = parts.voxel_grid.take().map(|v| edited(v, |v| v.scale_sources(f))).transpose()?;
    }
    if all || kind == LightGroupKind::Panes {
        parts.panes.iter_mut().for_each(|p| p.emission *= f);
    }
    if all || kind == LightGroupKind::Surroundings {
        parts.surroundings.radiance *= f;
    }
    Ok(())
}

fn edited(mut map: VoxelGrid, change: impl FnOnce(&mut VoxelGrid)) -> Result<VoxelGrid, SceneError> {
    change(&mut map);
    map.seal()
}

/// Scales the emission of a group in the zones.
fn scale_zones(zones: &mut Zones, kind: LightGroupKind, f: Bands) {
    let all = kind == LightGroupKind::All;
    for p in zones.patches.iter_mut().filter(|p| all || kind == LightGroupKind::Surface(p.surface)) {
        p.emission *= f;
    }
    if all || kind == LightGroupKind::Medium {
        zones.voxels.update_emission(|_, e| e * f);
        zones.voxels.update_source(|_, q| q * f);
    }
    if all || kind == LightGroupKind::Panes {
        zones.panes.iter_mut().for_each(|p| p.emission *= f);
    }
}

/// Sum of the errors of the groups, W/m²; `None` if those of a group are unknown.
fn sum_of_group_errors(groups: &[LightGroup], zones: usize) -> Option<Vec<Bands>> {
    groups.iter().all(|g| !g.error.is_empty() || g.incident.is_empty()).then(|| {
        let mut out = vec![Bands::ZERO; zones];
        groups.iter().for_each(|g| g.error.add_to(&mut out, g.incident_scale));
        out
    })
}

/// Sum of the fields of all groups. The error of the incoming radiation is scaled by the factor `sky` of the surroundings. The rest of the estimated
/// error is that of the groups, whose sum before was `known`; the excess over that sum, or all of it if it is unknown, stays the same fraction of
/// the incident field of a zone.
fn sum_of_groups(
    zones: &Zones,
    groups: &[LightGroup],
    old: &Fields,
    known: Option<Vec<Bands>>,
    sky: Bands,
) -> Fields {
    let n = zones.len();
    let added = |pick: fn(&LightGroup) -> (&ZoneValues, Bands)| {
        let mut out = vec![Bands::ZERO; n];
        groups.iter().map(pick).for_each(|(v, scale)| v.add_to(&mut out, scale));
        out
    };
    let incident = added(|g| (&g.incident, g.incident_scale));
    let added_if_any = |pick: fn(&LightGroup) -> (&ZoneValues, Bands)| {
        if groups.iter().all(|g| pick(g).0.is_empty()) { Vec::new() } else { added(pick) }
    };
    let direct = Fields::direct_unless_zero(added_if_any(|g| (&g.direct, g.direct_scale)));
    let direct_error = added_if_any(|g| (&g.direct_error, g.direct_scale));
    let radiosity = |i: usize| {
        let arrives = |k: usize| incident[k] + direct.get(k).copied().unwrap_or_default();
        zones.emission(i) + zones.scattered(i, arrives)
    };
    // Errors of the groups before and after scaling.
    let own = known.map(|before| (before, added(|g| (&g.error, g.incident_scale))));
    let error = |i: usize| {
        let grown =
            |b: Band| if old.incident[i][b] > 0.0 { incident[i][b] / old.incident[i][b] } else { 0.0 };
        let part = old.surroundings_error.get(i).copied().unwrap_or_default();
        let rest = |b: Band| {
            let all = (old.error[i][b].powi(2) - part[b].powi(2)).max(0.0).sqrt();
            match &own {
                // Errors that add up by squares are less than the sum of the groups; they stay where no group of the zone was scaled.
                Some((before, after)) if after[i][b] == before[i][b] => all,
                Some((before, after)) => after[i][b] + excess(all, before[i][b]) * grown(b),
                None => all * grown(b),
            }
        };
        Bands::from_fn(|b| rest(b).hypot(part[b] * sky[b]))
    };
    Fields {
        surroundings_error: parallel::map(&old.surroundings_error, |e| *e * sky),
        radiosity: parallel::collect(n, radiosity),
        error: parallel::collect(n, error),
        incident,
        direct,
        direct_error,
        heat: None,
    }
}

/// The excess of an error over its `known` part, except for rounding.
fn excess(all: f64, known: f64) -> f64 {
    const ROUNDING_OF_SUM: f64 = 1e-6;
    if all > known * (1.0 + ROUNDING_OF_SUM) { all - known } else { 0.0 }
}

/// The scene with other reflectances of surfaces (by name, or by the part of the name before a dot or a slash) and, if given, a uniform albedo of the
/// medium.
///
/// # Errors
/// For unknown surfaces, for an albedo without a medium, and for values out of range.
pub fn with_surface_colors(
    scene: Scene,
    reflectances: &[(String, Bands)],
    albedo: Option<Bands>,
) -> Result<Scene, SceneError> {
    if scene.bands().block_count() == 1 {
        return with_colors_of_block(scene, reflectances, albedo);
    }
    if !reflectances.iter().map(|r| r.1).chain(albedo).all(Bands::is_grey) {
        let message =
            format!("the scene has {} bands; give one number for all of them", scene.bands().count());
        return Err(SceneError::new("reflectance", message));
    }
    scene.map_blocks(|block| with_colors_of_block(block, reflectances, albedo))
}

/// [`with_surface_colors`] for one block of bands.
fn with_colors_of_block(
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
        for (facet, values) in parts.facets.iter().zip(&mut parts.faces.values) {
            if belongs(&parts.surfaces[facet.surface].name) {
                values.reflectance = None;
            }
        }
        if !found {
            const MAX_LISTED_NAMES: usize = 24;
            let names: Vec<&str> =
                parts.surfaces.iter().take(MAX_LISTED_NAMES).map(|s| s.name.as_str()).collect();
            return Err(SceneError::new(
                format!("surface '{name}'"),
                format!("there is none of this name; there are: {}", names.join(", ")),
            ));
        }
    }
    if let Some(albedo) = albedo {
        let Some(map) = parts.voxel_grid.take() else {
            return Err(SceneError::new("albedo", "the scene has no medium whose albedo could change"));
        };
        parts.voxel_grid = Some(edited(map, |v| v.set_albedo(albedo))?);
    }
    Scene::new(parts)
}
