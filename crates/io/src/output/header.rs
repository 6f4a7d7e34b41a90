//! The JSON document inside a solution file: everything that is not an array over zones, facets or cells.

use super::heat;
use super::report::{self, bands, list, real, text};
use serde_json::{Value, json};
use zonal_math::Vec3;
use zonal_scene::scene::{Options, PatchRule, ThickZones};
use zonal_scene::{Camera, Engine, Groups, Lens, Light, Pane, Scene, Sides, Solution, Surface, Surroundings};

/// The version of the format; readers refuse others.
pub(super) const FORMAT_VERSION: u64 = 5;

const HOW_TO_READ: &str =
    "import json, numpy as np; z = np.load(file); header = json.loads(bytes(z['header.json']))";

pub(super) fn encode(s: &Solution) -> Value {
    let scene = &s.scene;
    let mut report = report::report_json(s);
    let provenance = report["provenance"].take();
    json!({
        "format": "zonal solution",
        "format_version": FORMAT_VERSION,
        "how_to_read": HOW_TO_READ,
        "units": {
            "lengths": "m", "extinction": "1/m", "radiosity, incident, direct, error, direct_error, group_*": "W/m² per band",
            "temperature, temperature_error": "K", "net, net_error": "W/m² of patches, W/m³ of voxels and panes",
            "source": "W/m³ per band", "radiance": "W/(m² sr) per band", "angles": "rad, fov in degrees",
        },
        "order_of_fields": "patches, then voxel zones, then pane zones",
        "name": scene.name(),
        "notes": super::notes::notes_json(scene.notes()),
        "surfaces": scene.surfaces().iter().map(surface_out).collect::<Vec<_>>(),
        "panes": scene.panes().iter().map(pane_out).collect::<Vec<_>>(),
        "textures": scene.textures().len(),
        "voxmap": scene.voxmap().map(|v| json!({"min": v.min().array(), "cell": v.cell().array(), "dims": v.dims()})),
        "lights": scene.lights().iter().map(light_out).collect::<Vec<_>>(),
        "surroundings": {"name": scene.surroundings().name, "radiance": scene.surroundings().radiance},
        "periodic": scene.periodic(),
        "mode": if scene.thermal().is_some() { "thermal" } else { "light" },
        "thermal": heat::thermal_out(scene),
        "cameras": scene.cameras().iter().map(camera_out).collect::<Vec<_>>(),
        "options": options_out(scene),
        "report": report,
        "provenance": provenance,
    })
}

fn surface_out(s: &Surface) -> Value {
    json!({
        "name": s.name, "reflectance": s.reflectance, "emission": s.emission,
        "reflectance_texture": s.reflectance_texture, "emission_texture": s.emission_texture,
        "sides": if s.sides == Sides::Both { "both" } else { "front" },
        "patch_size": s.patch_size, "solid": s.solid,
    })
}

fn pane_out(p: &Pane) -> Value {
    json!({
        "name": p.name, "thickness": p.thickness, "extinction": p.extinction, "albedo": p.albedo, "emission": p.emission,
    })
}

fn light_out(l: &Light) -> Value {
    match l {
        Light::Sun { name, direction, irradiance, angular_diameter } => json!({
            "kind": "sun", "name": name, "direction": direction.array(), "irradiance": irradiance,
            "angular_diameter": angular_diameter,
        }),
        Light::Sky { name, radiance } => json!({"kind": "sky", "name": name, "radiance": radiance}),
        Light::Emitter { name, surface } => json!({"kind": "emitter", "name": name, "surface": surface}),
    }
}

fn camera_out(c: &Camera) -> Value {
    json!({
        "name": c.name, "origin": c.origin.array(), "target": c.target.array(), "up": c.up.array(), "fov": c.fov,
        "aperture": c.lens.aperture, "focus": c.lens.focus,
    })
}

fn options_out(scene: &Scene) -> Value {
    let o = scene.options();
    json!({
        "tolerance": o.tolerance, "patch_size": o.patch_size, "patch_rule": o.patch_rule.word(), "restore_closure": o.restore_closure,
        "max_iterations": o.max_iterations, "residual": o.residual, "sweeps": o.sweeps,
        "engine": o.engine.word(), "groups": o.groups.word(), "thick_zones": o.thick_zones.word(),
        "zoning_error": o.zoning_error,
    })
}

/// Each entry of the list at `key`, decoded; the error names key and number.
pub(super) fn each<T>(
    v: &Value,
    key: &str,
    one: impl Fn(&Value) -> Result<T, String>,
) -> Result<Vec<T>, String> {
    let entries = list(v, key)?.iter().enumerate();
    entries.map(|(i, x)| one(x).map_err(|e| format!("{key}[{i}].{e}"))).collect()
}

/// A whole number at a key.
pub(super) fn int(v: &Value, key: &str) -> Result<usize, String> {
    v[key].as_u64().map(|n| n as usize).ok_or_else(|| format!("{key}: a whole number is missing"))
}

/// Three coordinates at a key.
pub(super) fn vector(v: &Value, key: &str) -> Result<Vec3, String> {
    bands(v, key).map(Vec3::from_array)
}

fn flag(v: &Value, key: &str) -> Result<bool, String> {
    v[key].as_bool().ok_or_else(|| format!("{key}: true or false is missing"))
}

fn maybe<T>(v: &Value, key: &str, get: fn(&Value, &str) -> Result<T, String>) -> Result<Option<T>, String> {
    if v[key].is_null() { Ok(None) } else { get(v, key).map(Some) }
}

/// The number of the word at a key among those known.
fn choice(v: &Value, key: &str, words: &[&str]) -> Result<usize, String> {
    let found = v[key].as_str().and_then(|w| words.iter().position(|x| *x == w));
    found.ok_or_else(|| format!("{key}: must be one of {}", words.join(", ")))
}

pub(super) fn surface_in(v: &Value) -> Result<Surface, String> {
    Ok(Surface {
        name: text(v, "name")?,
        reflectance: bands(v, "reflectance")?,
        emission: bands(v, "emission")?,
        reflectance_texture: maybe(v, "reflectance_texture", int)?,
        emission_texture: maybe(v, "emission_texture", int)?,
        sides: match v["sides"].as_str() {
            Some("both") => Sides::Both,
            Some("front") => Sides::Front,
            _ => return Err("sides: must be front or both".into()),
        },
        patch_size: maybe(v, "patch_size", real)?,
        solid: flag(v, "solid")?,
    })
}

/// A pane, without its plates.
pub(super) fn pane_in(v: &Value) -> Result<Pane, String> {
    Ok(Pane {
        name: text(v, "name")?,
        plates: Vec::new(),
        thickness: real(v, "thickness")?,
        extinction: bands(v, "extinction")?,
        albedo: bands(v, "albedo")?,
        emission: bands(v, "emission")?,
    })
}

pub(super) fn light_in(v: &Value) -> Result<Light, String> {
    match v["kind"].as_str() {
        Some("sun") => Ok(Light::Sun {
            name: text(v, "name")?,
            direction: vector(v, "direction")?,
            irradiance: bands(v, "irradiance")?,
            angular_diameter: real(v, "angular_diameter")?,
        }),
        Some("sky") => Ok(Light::Sky { name: text(v, "name")?, radiance: bands(v, "radiance")? }),
        Some("emitter") => Ok(Light::Emitter { name: maybe(v, "name", text)?, surface: int(v, "surface")? }),
        _ => Err("kind: must be sun, sky or emitter".into()),
    }
}

pub(super) fn camera_in(v: &Value) -> Result<Camera, String> {
    Ok(Camera {
        name: text(v, "name")?,
        origin: vector(v, "origin")?,
        target: vector(v, "target")?,
        up: vector(v, "up")?,
        fov: real(v, "fov")?,
        lens: Lens { aperture: maybe(v, "aperture", real)?.unwrap_or(0.0), focus: maybe(v, "focus", real)? },
    })
}

/// Periodic axes; none in files that do not say.
pub(super) fn periodic_in(v: &Value) -> Result<[bool; 3], String> {
    if v["periodic"].is_null() {
        return Ok([false; 3]);
    }
    let list: Option<Vec<bool>> = list(v, "periodic")?.iter().map(Value::as_bool).collect();
    list.and_then(|l| l.try_into().ok()).ok_or("periodic: three times true or false are missing".into())
}

fn patch_rule(v: &Value) -> Result<PatchRule, String> {
    let word = text(v, "patch_rule")?;
    PatchRule::ALL
        .into_iter()
        .find(|r| r.word() == word)
        .ok_or(format!("the patch rule '{word}' is not known"))
}

pub(super) fn options_in(v: &Value) -> Result<Options, String> {
    Ok(Options {
        tolerance: real(v, "tolerance")?,
        patch_size: maybe(v, "patch_size", real)?,
        patch_rule: patch_rule(v)?,
        restore_closure: maybe(v, "restore_closure", flag)?,
        max_iterations: int(v, "max_iterations")?,
        residual: real(v, "residual")?,
        sweeps: maybe(v, "sweeps", int)?,
        engine: choice(v, "engine", &Engine::WORDS).map(|i| Engine::ALL[i])?,
        groups: choice(v, "groups", &Groups::WORDS).map(|i| Groups::ALL[i])?,
        thick_zones: choice(v, "thick_zones", &ThickZones::WORDS).map(|i| ThickZones::ALL[i])?,
        zoning_error: maybe(v, "zoning_error", flag)?,
    })
}

pub(super) fn surroundings_in(v: &Value) -> Result<Surroundings, String> {
    Ok(Surroundings { name: maybe(v, "name", text)?, radiance: bands(v, "radiance")? })
}
