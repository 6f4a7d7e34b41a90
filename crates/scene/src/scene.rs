//! The scene: validated once, read-only ever after.

pub use crate::options::{Engine, Groups, Options, PatchRule, ThickZones};
use crate::printable::printable;
use crate::{Bands, Camera, Light, Note, Plate, Surroundings, Thermal, Voxmap};
use std::borrow::Cow;
use std::fmt;
use zonal_math::Vec3;

/// What is wrong with a scene: the key at fault and what to do about it.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneError {
    key: String,
    what: String,
}

impl SceneError {
    /// An error at `key` (dotted, as in the scene file) that says `what` is wrong and how to mend it.
    pub fn new(key: impl Into<String>, what: impl Into<String>) -> SceneError {
        SceneError { key: key.into(), what: what.into() }
    }
    /// The key at fault.
    pub fn key(&self) -> &str {
        &self.key
    }
    /// What is wrong.
    pub fn what(&self) -> &str {
        &self.what
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.key, self.what)
    }
}

impl std::error::Error for SceneError {}

/// Which sides of a surface take part in the exchange. A side that does not is black, cold and opaque.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// The front only.
    Front,
    /// Both, each a zone of its own.
    Both,
}

/// A named surface: a diffuse material, and how fine to cut it.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Unique name.
    pub name: String,
    /// Diffuse reflectance ρ; multiplies the texture where there is one.
    pub reflectance: Bands,
    /// Emitted flux E, W/m²; multiplies the emission texture where there is one.
    pub emission: Bands,
    /// Index of the texture of ρ.
    pub reflectance_texture: Option<usize>,
    /// Index of the texture of E.
    pub emission_texture: Option<usize>,
    /// Which sides exchange.
    pub sides: Sides,
    /// Wanted patch edge, m; the scene's where not given.
    pub patch_size: Option<f64>,
    /// True where the surface bounds a closed solid: no medium behind its fronts.
    pub solid: bool,
}

/// A piece of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// Index of the surface.
    pub surface: usize,
    /// Shape.
    pub plate: Plate,
    /// Texture coordinates at (u, v) = (0,0), (1,0) and (0,1); linear in between.
    pub uv: [[f64; 2]; 3],
}

impl Facet {
    /// Texture coordinates at plate parameters (u, v).
    pub fn uv_at(&self, u: f64, v: f64) -> [f64; 2] {
        [0, 1].map(|k| {
            self.uv[0][k] + u * (self.uv[1][k] - self.uv[0][k]) + v * (self.uv[2][k] - self.uv[0][k])
        })
    }
}

/// A linear RGB picture, row 0 on top, repeated beyond [0,1)²; v runs down (the glTF convention).
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// Linear values, row by row.
    pub pixels: Vec<[f32; 3]>,
}

impl Texture {
    /// Bilinear value at texture coordinates (u, v).
    pub fn sample(&self, uv: [f64; 2]) -> Bands {
        let (w, h) = (self.width as f64, self.height as f64);
        let wrap = |t: f64| if t.is_finite() { t - t.floor() } else { 0.0 };
        let (x, y) = (wrap(uv[0]) * w - 0.5, wrap(uv[1]) * h - 0.5);
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let at = |dx: i64, dy: i64| {
            let i = (x.floor() as i64 + dx).rem_euclid(self.width as i64) as usize;
            let j = (y.floor() as i64 + dy).rem_euclid(self.height as i64) as usize;
            self.pixels[j * self.width + i]
        };
        let (a, b, c, d) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1));
        crate::bands(|k| {
            let top = a[k] as f64 * (1.0 - fx) + b[k] as f64 * fx;
            let bottom = c[k] as f64 * (1.0 - fx) + d[k] as f64 * fx;
            top * (1.0 - fy) + bottom * fy
        })
    }
}

/// A pane: a thin sheet of absorbing and scattering material, a volume zone off the voxmap.
#[derive(Clone, Debug, PartialEq)]
pub struct Pane {
    /// Name.
    pub name: String,
    /// The plates its polygon is made of, all in one plane.
    pub plates: Vec<Plate>,
    /// Thickness t, m.
    pub thickness: f64,
    /// Extinction κ, 1/m.
    pub extinction: Bands,
    /// Scattering albedo Ω.
    pub albedo: Bands,
    /// Black emissive power E, W/m².
    pub emission: Bands,
}

/// A scene's ingredients, not yet validated.
#[derive(Clone, Debug, Default)]
pub struct SceneParts {
    /// Name.
    pub name: String,
    /// Surfaces.
    pub surfaces: Vec<Surface>,
    /// Their facets.
    pub facets: Vec<Facet>,
    /// Textures.
    pub textures: Vec<Texture>,
    /// Panes.
    pub panes: Vec<Pane>,
    /// The medium; `None` for vacuum.
    pub voxmap: Option<Voxmap>,
    /// Direct lights.
    pub lights: Vec<Light>,
    /// Beyond the scene.
    pub surroundings: Surroundings,
    /// Axes along which the scene repeats itself, with the medium's extent as its period.
    pub periodic: [bool; 3],
    /// What is known of temperatures and heat; none in light mode.
    pub thermal: Option<Thermal>,
    /// Cameras.
    pub cameras: Vec<Camera>,
    /// Settings.
    pub options: Options,
    /// What the reader noticed and mended, such as dropped triangles.
    pub notes: Vec<Note>,
}

/// A validated scene.
#[derive(Clone, Debug)]
pub struct Scene {
    parts: SceneParts,
    bounds: (Vec3, Vec3),
}

/// Coordinates reach no farther than this from the origin, m.
pub const LARGEST_LENGTH: f64 = 1e8;
/// The smallest area of a plate, m².
pub const SMALLEST_AREA: f64 = 1e-24;
/// The largest extinction, 1/m.
pub const LARGEST_EXTINCTION: f64 = 1e8;
/// The largest emission, irradiance or radiance, W/m² (and W/m³ for sources).
pub const LARGEST_FLUX: f64 = 1e30;

impl SceneParts {
    /// All names.
    fn names(&mut self) -> impl Iterator<Item = &mut String> {
        let lights = self.lights.iter_mut().filter_map(|l| match l {
            Light::Sun { name, .. } | Light::Sky { name, .. } => Some(name),
            Light::Emitter { name, .. } => name.as_mut(),
        });
        let others = self.surroundings.name.as_mut().into_iter();
        std::iter::once(&mut self.name)
            .chain(self.surfaces.iter_mut().map(|s| &mut s.name))
            .chain(self.panes.iter_mut().map(|p| &mut p.name))
            .chain(self.cameras.iter_mut().map(|c| &mut c.name))
            .chain(lights)
            .chain(others)
    }
}

fn spell_out(name: &mut String) {
    if let Cow::Owned(spelled) = printable(name) {
        *name = spelled;
    }
}

fn fail<T>(key: impl Into<String>, what: impl Into<String>) -> Result<T, SceneError> {
    Err(SceneError::new(key, what))
}

fn check_bands(key: &str, v: Bands, max: f64) -> Result<(), SceneError> {
    match v.iter().find(|x| !(0.0..=max).contains(*x)) {
        Some(x) => fail(key, format!("{x:e} is out of range; give values from 0 to {max:e}")),
        None => Ok(()),
    }
}

/// A scene that repeats itself needs a medium whose extent is the period.
fn check_periodic(parts: &SceneParts) -> Result<(), SceneError> {
    let Some(axis) = (0..3).find(|&k| parts.periodic[k]) else { return Ok(()) };
    let key = |k: usize| format!("boundary.{}", ["x", "y", "z"][k]);
    let Some(map) = &parts.voxmap else {
        return fail(key(axis), "the period is the extent of the medium; add a [medium]");
    };
    if parts.periodic == [true; 3] {
        return fail(key(2), "no more than two axes can be periodic: light has to end somewhere");
    }
    if let Some(l) = parts.lights.first() {
        let key = match l {
            Light::Sun { name, .. } | Light::Sky { name, .. } => format!("light '{name}'"),
            Light::Emitter { .. } => "light.surface".into(),
        };
        return fail(
            key,
            "direct light knows no images of a periodic scene; let a surface emit as zones instead",
        );
    }
    if map.uniform_extinction().is_none() {
        return fail(key(axis), "a periodic scene needs one extinction everywhere");
    }
    Ok(())
}

fn check_plate(key: &str, p: &Plate) -> Result<(), SceneError> {
    if !(p.origin.is_finite() && p.e1.is_finite() && p.e2.is_finite()) {
        return fail(key, "a corner is not a finite number");
    }
    let (lo, hi) = p.bounds();
    if lo.max_abs().max(hi.max_abs()) > LARGEST_LENGTH {
        return fail(
            key,
            format!(
                "a corner lies beyond {LARGEST_LENGTH:e} m; give corners, edges, min and max within that"
            ),
        );
    }
    if p.area() >= SMALLEST_AREA {
        return Ok(());
    }
    fail(key, "a plate has no area; remove it or move its corners apart")
}

impl Scene {
    /// Validates the parts. Names lose what would steer a terminal or break a line.
    pub fn new(mut parts: SceneParts) -> Result<Scene, SceneError> {
        parts.names().for_each(spell_out);
        if parts.facets.is_empty() && parts.panes.is_empty() && parts.voxmap.is_none() {
            return fail("scene", "the scene is empty; add a surface or a medium");
        }
        let mut names = std::collections::HashSet::new();
        for s in &parts.surfaces {
            let key = |k: &str| format!("surface '{}'.{k}", s.name);
            if !names.insert(s.name.as_str()) {
                return fail(key("name"), "two surfaces have this name; rename one");
            }
            check_bands(&key("reflectance"), s.reflectance, 1.0)?;
            check_bands(&key("emission"), s.emission, LARGEST_FLUX)?;
            if s.patch_size.is_some_and(|p| !(p.is_finite() && p > 0.0)) {
                return fail(key("patch_size"), "the patch size must be a positive length");
            }
            for t in [s.reflectance_texture, s.emission_texture].into_iter().flatten() {
                if t >= parts.textures.len() {
                    return fail(key("texture"), "there is no such texture");
                }
            }
        }
        for t in &parts.textures {
            if t.width == 0 || t.height == 0 || t.pixels.len() != t.width * t.height {
                return fail("texture", "a texture has no pixels");
            }
            if t.pixels.iter().flatten().any(|x| !(x.is_finite() && *x >= 0.0)) {
                return fail("texture", "a texture has a pixel that is negative or not a number");
            }
        }
        for f in &parts.facets {
            let Some(s) = parts.surfaces.get(f.surface) else {
                return fail("facet", "a facet belongs to no surface");
            };
            check_plate(&format!("surface '{}'", s.name), &f.plate)?;
        }
        for p in &parts.panes {
            let key = |k: &str| format!("pane '{}'.{k}", p.name);
            for q in &p.plates {
                check_plate(&key("corners"), q)?;
            }
            if !(p.thickness.is_finite() && p.thickness > 0.0) {
                return fail(key("thickness"), "the thickness must be a positive length in metres");
            }
            check_bands(&key("extinction"), p.extinction, LARGEST_EXTINCTION)?;
            check_bands(&key("albedo"), p.albedo, 1.0)?;
            check_bands(&key("emission"), p.emission, LARGEST_FLUX)?;
        }
        let mut emitters = std::collections::HashSet::new();
        for l in &parts.lights {
            match l {
                Light::Sun { name, direction, irradiance, angular_diameter } => {
                    let key = |k: &str| format!("light '{name}'.{k}");
                    if !(direction.is_finite() && (direction.length() - 1.0).abs() < 1e-9) {
                        return fail(key("direction"), "the direction must be a vector with a length");
                    }
                    check_bands(&key("irradiance"), *irradiance, LARGEST_FLUX)?;
                    if !(*angular_diameter >= 0.0 && *angular_diameter < std::f64::consts::PI) {
                        return fail(
                            key("angular_diameter"),
                            "the angular diameter must lie between 0 and 180 degrees",
                        );
                    }
                }
                Light::Sky { name, radiance } => {
                    check_bands(&format!("light '{name}'.radiance"), *radiance, LARGEST_FLUX)?;
                }
                Light::Emitter { surface, .. } => {
                    if *surface >= parts.surfaces.len() {
                        return fail("light.surface", "there is no such surface");
                    }
                    if !emitters.insert(*surface) {
                        return fail("light.surface", "this surface is an emitter already; list it once");
                    }
                }
            }
        }
        check_bands("surroundings.radiance", parts.surroundings.radiance, f64::INFINITY)?;
        check_periodic(&parts)?;
        let mut names = std::collections::HashSet::new();
        for c in &parts.cameras {
            if !names.insert(c.name.as_str()) {
                return fail(format!("camera '{}'.name", c.name), "two cameras have this name; rename one");
            }
            c.check()?;
        }
        let o = &parts.options;
        if !(o.tolerance > 0.0 && o.tolerance < 1.0) {
            return fail("solve.tolerance", "the tolerance must lie between 0 and 1");
        }
        if o.patch_size.is_some_and(|p| !(p.is_finite() && p > 0.0)) {
            return fail("solve.patch_size", "the patch size must be a positive length");
        }
        if !(o.residual > 0.0 && o.residual < 1.0) || o.max_iterations == 0 {
            return fail(
                "solve.residual",
                "the residual must lie between 0 and 1, with at least one iteration",
            );
        }
        if o.sweeps == Some(0) {
            return fail("solve.sweeps", "there must be at least one sweep");
        }
        let mut bounds = (Vec3::splat(f64::INFINITY), Vec3::splat(f64::NEG_INFINITY));
        let plates = parts.facets.iter().map(|f| &f.plate).chain(parts.panes.iter().flat_map(|p| &p.plates));
        for (lo, hi) in plates.map(Plate::bounds).chain(parts.voxmap.iter().map(|v| (v.min(), v.max()))) {
            bounds = (bounds.0.min(lo), bounds.1.max(hi));
        }
        let scene = Scene { parts, bounds };
        match scene.thermal() {
            Some(thermal) => thermal.check(&scene)?,
            None if scene.voxmap().is_some_and(Voxmap::is_thermal) => {
                return fail("medium.temperature", "temperatures belong to mode = \"thermal\"");
            }
            None => {}
        }
        Ok(scene)
    }

    /// What is known of temperatures and heat; none in light mode.
    pub fn thermal(&self) -> Option<&Thermal> {
        self.parts.thermal.as_ref()
    }

    /// Name.
    pub fn name(&self) -> &str {
        &self.parts.name
    }
    /// Surfaces.
    pub fn surfaces(&self) -> &[Surface] {
        &self.parts.surfaces
    }
    /// Facets of all surfaces.
    pub fn facets(&self) -> &[Facet] {
        &self.parts.facets
    }
    /// Textures.
    pub fn textures(&self) -> &[Texture] {
        &self.parts.textures
    }
    /// Panes.
    pub fn panes(&self) -> &[Pane] {
        &self.parts.panes
    }
    /// The medium, if there is one.
    pub fn voxmap(&self) -> Option<&Voxmap> {
        self.parts.voxmap.as_ref()
    }
    /// Direct lights.
    pub fn lights(&self) -> &[Light] {
        &self.parts.lights
    }
    /// Beyond the scene.
    pub fn surroundings(&self) -> &Surroundings {
        &self.parts.surroundings
    }
    /// True where the scene repeats itself.
    pub fn is_periodic(&self) -> bool {
        self.periodic() != [false; 3]
    }
    /// Axes along which the scene repeats itself, with the medium's extent as its period.
    pub fn periodic(&self) -> [bool; 3] {
        self.parts.periodic
    }
    /// Cameras.
    pub fn cameras(&self) -> &[Camera] {
        &self.parts.cameras
    }
    /// Settings.
    pub fn options(&self) -> &Options {
        &self.parts.options
    }
    /// Whether closure is restored: as the settings say, else in thermal mode alone, where missing closure is missing heat.
    pub fn restores_closure(&self) -> bool {
        self.options().restore_closure.unwrap_or(self.thermal().is_some())
    }
    /// What the reader noticed and mended.
    pub fn notes(&self) -> &[Note] {
        &self.parts.notes
    }
    /// Smallest and largest coordinates of everything in the scene, m.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }
    /// Length of the diagonal of the bounds, m.
    pub fn diagonal(&self) -> f64 {
        (self.bounds.1 - self.bounds.0).length()
    }
    /// Reflectance of a facet at plate parameters (u, v): the texture times the surface's factor, at most 1.
    pub fn reflectance_at(&self, facet: usize, u: f64, v: f64) -> Bands {
        let f = &self.parts.facets[facet];
        let s = &self.parts.surfaces[f.surface];
        self.textured(s.reflectance, s.reflectance_texture, f, u, v).map(|x| x.min(1.0))
    }
    /// Emitted flux of a facet at plate parameters (u, v), W/m².
    pub fn emission_at(&self, facet: usize, u: f64, v: f64) -> Bands {
        let f = &self.parts.facets[facet];
        let s = &self.parts.surfaces[f.surface];
        self.textured(s.emission, s.emission_texture, f, u, v)
    }
    fn textured(&self, factor: Bands, texture: Option<usize>, f: &Facet, u: f64, v: f64) -> Bands {
        match texture {
            None => factor,
            Some(t) => {
                let c = self.parts.textures[t].sample(f.uv_at(u, v));
                crate::bands(|b| factor[b] * c[b])
            }
        }
    }
    /// Wanted patch edge of surfaces that have none of their own, m.
    pub fn patch_size(&self) -> f64 {
        self.parts.options.patch_size.unwrap_or(self.diagonal() / 30.0)
    }
    /// True when the emission of this surface is treated as direct light.
    pub fn is_direct_emitter(&self, surface: usize) -> bool {
        self.parts.lights.iter().any(|l| matches!(l, Light::Emitter { surface: s, .. } if *s == surface))
    }
    /// The same scene with other settings.
    pub fn with_options(mut self, options: Options) -> Result<Scene, SceneError> {
        self.parts.options = options;
        Scene::new(self.parts)
    }
    /// The parts, given back.
    pub fn into_parts(self) -> SceneParts {
        self.parts
    }
}
