//! Check of a finished solution for values that are not finite.
//!
//! A NaN passes every test of the form x > limit, and `max` and `min` drop it. Values (radiosity, incident fields, powers, temperatures, closure)
//! must be finite; otherwise the solution is refused with the first value that is not. An error that is NaN becomes infinite, which stands for
//! an unknown error.

use crate::distribution::Communicator;
use zonal_math::parallel;
use zonal_scene::{
    Bands, EnergyBalance, Fields, LightGroup, Report, Scene, SceneError, ThermalFields, ZoneRef, ZoneValues,
    Zones,
};

/// Refuses a solution with a value that is not finite; errors that are NaN become infinite.
pub(crate) fn check_finite(
    scene: &Scene,
    zones: &Zones,
    fields: &mut Fields,
    groups: &mut [LightGroup],
    report: &mut Report,
) -> Result<(), SceneError> {
    for list in Fields::LISTS {
        let values = (list.of_mut)(fields);
        if list.is_error {
            parallel::for_each(values, |_, e| nan_to_infinity(e));
        } else if let Some(i) = parallel::first(values.len(), |i| !values[i].is_finite()) {
            return Err(not_finite(&format!("the field '{}' {}", list.name, describe_zone(scene, zones, i))));
        }
    }
    if let Some(heat) = &mut fields.heat {
        check_heat(scene, zones, heat)?;
    }
    for g in groups.iter_mut() {
        if !(is_finite(&g.incident) && is_finite(&g.direct) && powers(&g.energy).all(f64::is_finite)) {
            return Err(not_finite(&format!("a value of the light group '{}'", g.name)));
        }
        for errors in [&mut g.error, &mut g.direct_error] {
            match errors {
                ZoneValues::Double(v) => parallel::for_each(v, |_, e| nan_to_infinity(e)),
                ZoneValues::Single(v) => parallel::for_each(v, |_, e| {
                    e.iter_mut().filter(|e| e.is_nan()).for_each(|e| *e = f32::INFINITY);
                }),
            }
        }
    }
    check_report(report)
}

/// The check of all processes where each has some zones: the fault of the first one that found any.
pub(crate) fn agree(
    checked: Result<(), SceneError>,
    zones: &Zones,
    communicator: &dyn Communicator,
) -> Result<(), SceneError> {
    if !zones.voxels.is_divided() {
        return checked;
    }
    let own = checked.err().map(|e| e.message().to_string()).unwrap_or_default();
    let all = communicator.all_gather(own.into_bytes());
    match all.iter().find(|message| !message.is_empty()) {
        Some(message) => Err(SceneError::new("solve", String::from_utf8_lossy(message))),
        None => Ok(()),
    }
}

/// Refuses temperatures and net powers that are not finite; an undefined temperature is NaN.
fn check_heat(scene: &Scene, zones: &Zones, heat: &mut ThermalFields) -> Result<(), SceneError> {
    let off = |x: &[f64], undefined: bool| x.iter().position(|x| !(x.is_finite() || undefined && x.is_nan()));
    for (what, at) in
        [("the temperature", off(&heat.temperature, true)), ("the net power", off(&heat.net, false))]
    {
        if let Some(i) = at {
            return Err(not_finite(&format!("{what} {}", describe_zone(scene, zones, i))));
        }
    }
    heat.net_error.iter_mut().for_each(|e| *e = or_infinity(*e));
    let defined = heat.temperature.iter().zip(&mut heat.temperature_error).filter(|(t, _)| t.is_finite());
    defined.for_each(|(_, e)| *e = or_infinity(*e));
    Ok(())
}

fn check_report(r: &mut Report) -> Result<(), SceneError> {
    let c = &r.closure;
    let closure = [c.worst, c.rms, c.largest_change, c.residual_defect];
    let (mut heat, mut rows) = (Vec::new(), &[][..]);
    if let Some(h) = &r.heat {
        (heat, rows) = (vec![h.surroundings, h.absorbed_backfaces], &h.rows[..]);
    }
    let of_rows = rows.iter().flat_map(|r| [r.size, r.power, r.temperature.unwrap_or(0.0)]);
    for (what, fine) in [
        ("the balance of power", powers(&r.energy).all(f64::is_finite)),
        ("the closure of the exchange areas", closure.into_iter().all(Bands::is_finite)),
        ("the residual of the solver", r.residuals.iter().flatten().all(|x| x.is_finite())),
        ("the balance of heat", heat.into_iter().chain(of_rows).all(f64::is_finite)),
    ] {
        if !fine {
            return Err(not_finite(what));
        }
    }
    [&mut r.estimate.patches, &mut r.estimate.volumes].into_iter().for_each(nan_to_infinity);
    for row in r.heat.iter_mut().flat_map(|h| &mut h.rows) {
        row.power_error = or_infinity(row.power_error);
        row.temperature_error = row.temperature_error.map(or_infinity);
    }
    Ok(())
}

fn or_infinity(e: f64) -> f64 {
    if e.is_nan() { f64::INFINITY } else { e }
}

fn nan_to_infinity(e: &mut Bands) {
    *e = e.map(or_infinity);
}

fn is_finite(v: &ZoneValues) -> bool {
    match v {
        ZoneValues::Double(v) => parallel::all(v, |x| x.is_finite()),
        ZoneValues::Single(v) => parallel::all(v, |x| x.iter().all(|x| x.is_finite())),
    }
}

fn powers(e: &EnergyBalance) -> impl Iterator<Item = f64> {
    [e.emitted, e.incoming, e.absorbed_volumes, e.absorbed_panes, e.escaped, e.absorbed_backfaces, e.residual]
        .into_iter()
        .chain(e.absorbed_surfaces.iter().map(|s| s.1))
        .flatten()
}

fn not_finite(what: &str) -> SceneError {
    SceneError::new(
        "solve",
        format!(
            "{what} is not a finite number: lengths, extinctions or emissions of this scene differ by too many orders of magnitude for double precision; bring them closer together"
        ),
    )
}

/// Describes zone `i` in a message.
fn describe_zone(scene: &Scene, zones: &Zones, i: usize) -> String {
    match zones.zone(i) {
        ZoneRef::Patch(p) => format!("on zone {i} of surface '{}'", scene.surfaces()[p.surface].name),
        ZoneRef::Voxel(k, v) => {
            // The number among the zones of all processes.
            let number = if zones.voxels.is_divided() { v.cell } else { k };
            format!("in zone {} of the medium", zones.voxel_index(number))
        }
        ZoneRef::Pane(_, p) => format!("in zone {i} of pane '{}'", scene.panes()[p.pane].name),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;
    use zonal_scene::{Band, Facet, Patch, Plate, SceneParts, Surface};

    fn parts() -> (Scene, Zones, Fields, Report) {
        let plate = Plate::parallelogram(vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        let surface = Surface { name: "floor".into(), emission: Bands::ONE, ..Surface::default() };
        let facet = Facet { surface: 0, plate, uv: [[0.0; 2]; 3] };
        let scene = SceneParts { surfaces: vec![surface], facets: vec![facet], ..SceneParts::default() };
        let patch = Patch {
            facet: 0,
            surface: 0,
            plate,
            normal: vec3(0.0, 0.0, 1.0),
            area: 1.0,
            reflectance: Bands::splat(0.5),
            emission: Bands::ONE,
        };
        let zones = Zones { patches: vec![patch], ..Zones::default() };
        let one = || vec![Bands::ONE];
        let fields =
            Fields { radiosity: one(), incident: one(), direct: one(), error: one(), ..Fields::default() };
        (Scene::new(scene).unwrap(), zones, fields, Report::default())
    }

    // Guards (numbers): results are finite numbers, and an unknown error is infinite.
    #[test]
    fn non_finite_values_are_refused_and_nan_errors_become_infinite() {
        let (scene, zones, fields, report) = parts();
        let checked = |change: &dyn Fn(&mut Fields, &mut Report)| {
            let (mut f, mut r) = (fields.clone(), report.clone());
            change(&mut f, &mut r);
            check_finite(&scene, &zones, &mut f, &mut [], &mut r).map(|()| (f, r)).map_err(|e| e.to_string())
        };
        assert!(checked(&|_, _| ()).is_ok());
        let b = Band::first();
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let e = checked(&|f, _| f.incident[0][b] = bad).unwrap_err();
            assert!(
                e.contains("the field 'incident' on zone 0 of surface 'floor' is not a finite number"),
                "{e}"
            );
            assert!(checked(&|f, _| f.radiosity[0][b] = bad).is_err());
            assert!(checked(&|f, _| f.direct[0][b] = bad).is_err());
            assert!(checked(&|_, r| r.closure.rms[b] = bad).unwrap_err().contains("closure"));
            assert!(checked(&|_, r| r.energy.escaped[b] = bad).unwrap_err().contains("balance"));
            assert!(checked(&|_, r| r.residuals[b].push(bad)).unwrap_err().contains("residual"));
        }
        let (f, r) = checked(&|f, r| (f.error[0][b], r.estimate.patches[b]) = (f64::NAN, f64::NAN)).unwrap();
        assert_eq!(
            (f.error[0], r.estimate.patches),
            (Bands::from_rgb([f64::INFINITY, 1.0, 1.0]), Bands::from_rgb([f64::INFINITY, 0.0, 0.0]))
        );
    }
}
