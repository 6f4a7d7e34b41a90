//! Validation of scene parts: ranges of values, indices, unique names.

use crate::base::limits::{MAX_COORDINATE, MAX_EXTINCTION, MAX_FACES, MAX_FLUX, MIN_PLATE_AREA};
use crate::base::scene_error::{SceneError, invalid};
use crate::geometry::plate::Plate;
use crate::model::options::SolveOptions;
use crate::model::surface::{Pane, Sides, Surface};
use crate::scene::scene_parts::SceneParts;
use crate::scene::symmetry_validation::check_boundary;
use crate::scene::thermal_validation::check_thermal;
use std::collections::HashSet;
use zonal_math::parallel;

/// Validates all parts of a scene.
pub(crate) fn check_parts(parts: &SceneParts) -> Result<(), SceneError> {
    if parts.facets.is_empty() && parts.panes.is_empty() && parts.voxel_grid.is_none() {
        return invalid("scene", "the scene is empty; add a surface or a medium");
    }
    check_surfaces(parts)?;
    check_textures(parts)?;
    check_facets(parts)?;
    check_faces(parts)?;
    parts.panes.iter().try_for_each(check_pane)?;
    check_lights(parts)?;
    parts.surroundings.radiance.check("surroundings.radiance", f64::INFINITY)?;
    check_boundary(parts)?;
    check_cameras(parts)?;
    check_options(&parts.options)?;
    match &parts.thermal {
        Some(thermal) => check_thermal(thermal, parts),
        None if parts.voxel_grid.as_ref().is_some_and(|g| g.is_thermal()) => {
            invalid("medium.temperature", "temperatures belong to mode = \"thermal\"")
        }
        None => Ok(()),
    }
}

fn check_plate(key: &str, p: &Plate) -> Result<(), SceneError> {
    if !(p.origin.is_finite() && p.e1.is_finite() && p.e2.is_finite()) {
        return invalid(key, "a corner is not a finite number");
    }
    let (lo, hi) = p.bounds();
    if lo.max_abs().max(hi.max_abs()) > MAX_COORDINATE {
        return invalid(
            key,
            format!(
                "a corner lies beyond {MAX_COORDINATE:e} m; give corners, edges, min and max within that"
            ),
        );
    }
    if p.area() >= MIN_PLATE_AREA {
        return Ok(());
    }
    invalid(key, "a plate has no area; remove it or move its corners apart")
}

fn check_surfaces(parts: &SceneParts) -> Result<(), SceneError> {
    let mut names = HashSet::new();
    for s in &parts.surfaces {
        let key = |k: &str| format!("surface '{}'.{k}", s.name);
        if !names.insert(s.name.as_str()) {
            return invalid(key("name"), "two surfaces have this name; rename one");
        }
        s.reflectance.check(&key("reflectance"), 1.0)?;
        s.emission.check(&key("emission"), MAX_FLUX)?;
        if s.patch_size.is_some_and(|p| !(p.is_finite() && p > 0.0)) {
            return invalid(key("patch_size"), "the patch size must be a positive length");
        }
        check_transmission(parts, s)?;
        let of_transmission = s.transmission.and_then(|t| t.texture);
        for t in [s.reflectance_texture, s.emission_texture, of_transmission].into_iter().flatten() {
            if t >= parts.textures.len() {
                return invalid(key("texture"), "there is no such texture");
            }
        }
    }
    Ok(())
}

/// Largest excess of ρ + τ over 1 by rounding.
const TRANSMITTANCE_ROUNDING: f64 = 1e-12;

/// Validates the diffuse transmission of a surface.
fn check_transmission(parts: &SceneParts, s: &Surface) -> Result<(), SceneError> {
    let Some(own) = s.transmission else { return Ok(()) };
    let key = format!("surface '{}'.transmittance", s.name);
    own.transmittance.check(&key, 1.0)?;
    // Textures are limited to 1 − ρ at each point.
    let untextured = own.texture.is_none() && s.reflectance_texture.is_none();
    if untextured && (s.reflectance + own.transmittance).any(|x| x > 1.0 + TRANSMITTANCE_ROUNDING) {
        return invalid(
            key,
            "reflectance + transmittance exceeds 1, so that the sheet would create light; lower one of them",
        );
    }
    if s.sides != Sides::Both || s.solid {
        return invalid(
            key,
            "light passes to the back of this surface, which does not exchange; write sides = \"both\"",
        );
    }
    if parts.thermal.is_some() {
        return invalid(
            key,
            "in thermal mode sheets that transmit diffusely are not solved; remove this key, or use a pane",
        );
    }
    if parts.periodic != [false; 3] {
        return invalid(
            key,
            "periodic scenes have no sheets that transmit diffusely; remove this key, or the period",
        );
    }
    Ok(())
}

fn check_textures(parts: &SceneParts) -> Result<(), SceneError> {
    for t in &parts.textures {
        if t.width == 0 || t.height == 0 || t.pixels.len() != t.width * t.height {
            return invalid("texture", "a texture has no pixels");
        }
        if !parallel::all(&t.pixels, |p| p.iter().all(|x| x.is_finite() && *x >= 0.0)) {
            return invalid("texture", "a texture has a pixel that is negative or not a number");
        }
    }
    Ok(())
}

fn check_facets(parts: &SceneParts) -> Result<(), SceneError> {
    for f in &parts.facets {
        let Some(s) = parts.surfaces.get(f.surface) else {
            return invalid("facet", "a facet belongs to no surface");
        };
        check_plate(&format!("surface '{}'", s.name), &f.plate)?;
    }
    if !parts.shading.is_valid(&parts.facets, parts.surfaces.len(), parts.textures.len()) {
        return invalid(
            "normals",
            "a normal for shading is no unit vector before its facet, or belongs to nothing; solve the scene again",
        );
    }
    Ok(())
}

/// Validates the faces of mesh files and the values by face, except conditions.
fn check_faces(parts: &SceneParts) -> Result<(), SceneError> {
    let (table, facets) = (&parts.faces, &parts.facets);
    let faces = table.meshes.iter().try_fold(0usize, |n, m| n.checked_add(m.faces));
    if faces.is_none_or(|n| n > MAX_FACES) {
        return invalid("mesh", format!("the meshes have more than {MAX_FACES} faces; use coarser meshes"));
    }
    let lists_fit = table.face_of_facet.len() <= facets.len() && table.values.len() <= facets.len();
    if !lists_fit || table.face_of_facet.iter().flatten().any(|f| *f >= table.len()) {
        return invalid("mesh", "a facet belongs to a face that does not exist");
    }
    for (facet, v) in facets.iter().zip(&table.values) {
        let (surface, key) =
            (facet.surface, |k: &str| format!("surface '{}'.{k}", parts.surfaces[facet.surface].name));
        if let Some(r) = v.reflectance {
            r.check(&key("reflectance"), 1.0)?;
        }
        let Some(e) = v.emission else { continue };
        e.check(&key("emission"), MAX_FLUX)?;
        if parts.lights.iter().any(|l| l.surface() == Some(surface)) {
            return invalid(
                key("emission"),
                "a light has one emission, and this surface has one by face; give it one value, or remove the light: surfaces that emit need none",
            );
        }
    }
    Ok(())
}

fn check_pane(p: &Pane) -> Result<(), SceneError> {
    let key = |k: &str| format!("pane '{}'.{k}", p.name);
    for q in &p.plates {
        check_plate(&key("corners"), q)?;
    }
    if !(p.thickness.is_finite() && p.thickness > 0.0) {
        return invalid(key("thickness"), "the thickness must be a positive length in metres");
    }
    p.extinction.check(&key("extinction"), MAX_EXTINCTION)?;
    p.albedo.check(&key("albedo"), 1.0)?;
    p.emission.check(&key("emission"), MAX_FLUX)
}

fn check_lights(parts: &SceneParts) -> Result<(), SceneError> {
    let mut emitters = HashSet::new();
    for l in &parts.lights {
        l.check(parts.surfaces.len())?;
        if l.surface().is_some_and(|s| !emitters.insert(s)) {
            return invalid(l.key(), "this surface is an emitter already; list it once");
        }
    }
    Ok(())
}

fn check_cameras(parts: &SceneParts) -> Result<(), SceneError> {
    let mut names = HashSet::new();
    for c in &parts.cameras {
        if !names.insert(c.name.as_str()) {
            return invalid(format!("camera '{}'.name", c.name), "two cameras have this name; rename one");
        }
        c.check()?;
    }
    Ok(())
}

fn check_options(o: &SolveOptions) -> Result<(), SceneError> {
    if !(o.tolerance > 0.0 && o.tolerance < 1.0) {
        return invalid("solve.tolerance", "the tolerance must lie between 0 and 1");
    }
    if o.patch_size.is_some_and(|p| !(p.is_finite() && p > 0.0)) {
        return invalid("solve.patch_size", "the patch size must be a positive length");
    }
    if !(o.residual > 0.0 && o.residual < 1.0) || o.max_iterations == 0 {
        return invalid(
            "solve.residual",
            "the residual must lie between 0 and 1, with at least one iteration",
        );
    }
    if o.scattering_orders == Some(0) {
        return invalid("solve.scattering_orders", "give at least one scattering order");
    }
    Ok(())
}
