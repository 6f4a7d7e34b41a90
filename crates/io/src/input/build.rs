//! From the document to the scene: settings, lights, cameras, and the order in which everything is read.

use super::error::{Fault, InputError};
use super::files::Files;
use super::medium::Matter;
use super::mesh::Picture;
use super::node::{Node, Table};
use super::source::Source;
use super::surface::Look;
use super::{medium, surface, texture, thermal};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use zonal_math::vec3;
use zonal_scene::scene::{PatchRule, ThickZones};
use zonal_scene::{
    Camera, Engine, Groups, Known, Lens, Light, Note, Options, Plate, Scene, SceneError, SceneParts, Surface,
    Surroundings,
};

/// The scene while it is read.
pub(crate) struct Builder<'a> {
    pub(crate) source: &'a Source<'a>,
    pub(crate) place: Place<'a>,
    pub(crate) parts: SceneParts,
    /// True where the scene has a medium.
    pub(crate) has_medium: bool,
    /// Bodies of meshes that fill the medium, after its regions.
    pub(crate) fills: Vec<Fill>,
    pictures: HashMap<String, usize>,
}

/// Where a scene is read, and how much it may be.
#[derive(Clone, Copy)]
pub(crate) struct Place<'a> {
    /// Folder of referenced files.
    pub(crate) base: Option<&'a Path>,
    /// Where they are read from.
    pub(crate) files: Files<'a>,
    /// The most cells of the medium.
    pub(crate) most_cells: usize,
}

/// A closed body and what fills it.
pub(crate) struct Fill {
    pub(crate) plates: Vec<Plate>,
    pub(crate) matter: Matter,
}

impl Builder<'_> {
    /// Adds a surface and gives its index. In thermal mode its look says what is known of it.
    pub(crate) fn add_surface(&mut self, surface: Surface, look: &Look) -> Result<usize, InputError> {
        if let Some(thermal) = &mut self.parts.thermal {
            let lacks = |key: &str, what: &str| {
                let key = format!("surface '{}'.{key}", surface.name);
                Err(self.source.scene_error(&SceneError::new(key, what)))
            };
            let Some(known) = look.heat else {
                return lacks(
                    "temperature",
                    "nothing is known of this surface; write temperature (K), heat_flux (W/m2) or net_power (W); heat_flux = 0 is adiabatic",
                );
            };
            if look.reflectance.is_none() {
                return lacks(
                    "emissivity",
                    "this key is missing; write emissivity = 0.9, or 1 for a black surface",
                );
            }
            thermal.surfaces.push(known);
        }
        self.parts.surfaces.push(surface);
        Ok(self.parts.surfaces.len() - 1)
    }
    /// True in thermal mode.
    pub(crate) fn thermal(&self) -> bool {
        self.parts.thermal.is_some()
    }
    /// Adds what is known of a pane in thermal mode: equilibrium where nothing is said.
    pub(crate) fn add_pane_heat(&mut self, known: Option<Known>) {
        if let Some(thermal) = &mut self.parts.thermal {
            thermal.panes.push(known.unwrap_or(Known::Flux(0.0)));
        }
    }
    /// An error about surface `name` belongs where surface `at` stands, unless it has a place of its own.
    pub(crate) fn alias(&self, name: &str, at: &str) {
        self.source.alias(&format!("surface '{name}'"), &format!("surface '{at}'"));
    }
    pub(crate) fn note(&mut self, note: impl Into<Note>) {
        self.parts.notes.push(note.into());
    }
    /// The path of the file that a node names.
    pub(crate) fn resolve(&self, node: &Node<'_>) -> Result<PathBuf, InputError> {
        let name = node.text()?;
        match self.place.base {
            Some(base) => Ok(base.join(name)),
            None => Err(node
                .error("this scene is a text without a folder and cannot refer to files; save it as a file")),
        }
    }
    /// The texture that a node names.
    pub(crate) fn texture(&mut self, node: &Node<'_>) -> Result<usize, InputError> {
        let path = self.resolve(node)?;
        self.picture(&Picture::File(path)).map_err(|f| node.error(f.to_string()))
    }
    /// The texture of a picture, decoded once.
    pub(crate) fn picture(&mut self, picture: &Picture) -> Result<usize, Fault> {
        let name = match picture {
            Picture::File(path) => path.display().to_string(),
            Picture::Bytes { name, .. } => name.clone(),
        };
        if let Some(i) = self.pictures.get(&name) {
            return Ok(*i);
        }
        let texture = match picture {
            Picture::Bytes { bytes, .. } => texture::decode(&name, bytes)?,
            Picture::File(path) => {
                let bytes = self.place.files.read(path, texture::MAX_FILE);
                texture::decode(&name, &bytes.map_err(|what| Fault::new(&name, "", what))?)?
            }
        };
        self.parts.textures.push(texture);
        self.pictures.insert(name, self.parts.textures.len() - 1);
        Ok(self.parts.textures.len() - 1)
    }
}

/// Reads a parsed document into a scene.
pub(crate) fn scene(root: &Table<'_>, place: Place<'_>, default_name: &str) -> Result<Scene, InputError> {
    root.check(&[
        "name",
        "mode",
        "thermal",
        "solve",
        "surface",
        "pane",
        "medium",
        "boundary",
        "light",
        "surroundings",
        "camera",
    ])?;
    let mut b = Builder {
        source: root.source,
        place,
        parts: SceneParts::default(),
        has_medium: root.get("medium").is_some(),
        fills: Vec::new(),
        pictures: HashMap::new(),
    };
    b.parts.thermal = thermal::mode(root)?;
    if let Some(t) = &b.parts.thermal {
        // Before anything is computed with them.
        t.shares.check().map_err(|e| b.source.scene_error(&e))?;
    }
    let name = root.read("name", |n| n.text())?;
    b.parts.name = name.unwrap_or(default_name).to_string();
    b.parts.options = root.read("solve", |n| options(&n))?.unwrap_or_default();
    let surfaces = root.list("surface")?;
    for (i, node) in surfaces.iter().enumerate() {
        surface::read_surface(node, i, &mut b)?;
    }
    for (i, node) in root.list("pane")?.iter().enumerate() {
        surface::read_pane(node, i, &mut b)?;
    }
    let medium_node = root.get("medium");
    if surfaces.is_empty() && b.parts.panes.is_empty() && medium_node.is_none() {
        return Err(root.error("the scene is empty; add a [[surface]], a [[pane]] or a [medium]"));
    }
    if b.parts.options.patch_rule == PatchRule::Voxels && medium_node.is_none() {
        let at = root.get("solve").map(|n| n.any_table()).transpose()?.and_then(|t| t.get("patch_rule"));
        let what = "there is no medium whose voxels walls could follow; add a [medium], or remove this key";
        return Err(at.map_or_else(|| root.error(what), |n| n.error(what)));
    }
    if let Some(node) = medium_node {
        let voxmap = medium::read_medium(&node, &mut b)?;
        b.parts.voxmap = Some(voxmap);
    }
    if let Some(node) = root.get("boundary") {
        b.parts.periodic = boundary(&node)?;
    }
    for (i, node) in root.list("light")?.iter().enumerate() {
        if b.thermal() {
            return Err(node.error("lights belong to mode = \"light\"; in thermal mode give temperatures, or heat_flux to what is warmed"));
        }
        let light = light(node, i, &b.parts.surfaces)?;
        b.parts.lights.push(light);
    }
    if let Some(node) = root.get("surroundings") {
        let t = node.table(&["name", "radiance", "temperature"])?;
        thermal::check_mode(&t, b.thermal())?;
        let name = t.read("name", |n| Ok(n.text()?.to_string()))?;
        let mut radiance = t.read("radiance", |n| n.bands(f64::INFINITY))?;
        if let Some(thermal) = &mut b.parts.thermal {
            thermal.surroundings = t.read("temperature", thermal::kelvin)?;
            radiance = Some(thermal.surroundings_radiance());
        }
        b.parts.surroundings = Surroundings { name, radiance: radiance.unwrap_or_default() };
    }
    for (i, node) in root.list("camera")?.iter().enumerate() {
        let camera = camera(node, i)?;
        b.parts.cameras.push(camera);
    }
    b.parts.notes = merged(std::mem::take(&mut b.parts.notes));
    Scene::new(b.parts).map_err(|e| root.source.scene_error(&e))
}

/// Names in a note that stands for several.
const NAMED: usize = 3;

/// Notes that differ in one quoted name, or in nothing, as one: with the first three names and a count.
fn merged(notes: Vec<Note>) -> Vec<Note> {
    let mut out: Vec<(Note, Vec<String>, usize)> = Vec::new();
    let mut known: HashMap<String, usize> = HashMap::new();
    for note in notes {
        // The first quoted name, wherever it stands in the note.
        let text = &note.text;
        let name = text.split('\'').nth(1).filter(|n| !n.is_empty() && text.matches('\'').count() >= 2);
        let name = name.unwrap_or_default().to_string();
        let key = if name.is_empty() { text.clone() } else { text.replace(&name, "\0") };
        // Lines of a file are no difference.
        let line = |part: &&str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
        let key: Vec<&str> = key.split(':').filter(|part| !line(part)).collect();
        let key = format!("{} {}", note.code, key.join(":"));
        let at = *known.entry(key).or_insert_with(|| {
            out.push((note, Vec::new(), 0));
            out.len() - 1
        });
        let (_, names, count) = &mut out[at];
        *count += 1;
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let tell = |(note, names, count): (Note, Vec<String>, usize)| {
        let more = match (count, names.len()) {
            (1, _) => String::new(),
            (n, 1) => format!(" ({n} times)"),
            (_, n) => {
                let first: Vec<String> =
                    names[1..].iter().take(NAMED - 1).map(|x| format!("'{x}'")).collect();
                let more = if n > NAMED { format!(" and {} more", n - NAMED) } else { String::new() };
                format!(" (likewise {}{more})", first.join(", "))
            }
        };
        Note { text: note.text + &more, ..note }
    };
    out.into_iter().map(tell).collect()
}

fn options(node: &Node<'_>) -> Result<Options, InputError> {
    let t = node.table(&[
        "tolerance",
        "patch_size",
        "patch_rule",
        "closure",
        "residual",
        "max_iterations",
        "sweeps",
        "engine",
        "groups",
        "thick_zones",
        "zoning_error",
    ])?;
    let mut o = Options::default();
    let between = |n: Node<'_>| match n.number()? {
        x if x > 0.0 && x < 1.0 => Ok(x),
        x => Err(n.error(format!("{x} is out of range; give a number above 0 and below 1"))),
    };
    if let Some(x) = t.read("tolerance", between)? {
        o.tolerance = x;
    }
    o.patch_size = t.read("patch_size", |n| n.positive())?;
    if let Some(i) = t.read("patch_rule", |n| n.choice(&PatchRule::WORDS))? {
        o.patch_rule = PatchRule::ALL[i];
    }
    if let Some(i) = t.read("closure", |n| n.choice(&["measure", "restore"]))? {
        o.restore_closure = Some(i == 1);
    }
    if let Some(x) = t.read("residual", between)? {
        o.residual = x;
    }
    if let Some(n) = t.read("max_iterations", |n| n.count())? {
        o.max_iterations = n;
    }
    o.sweeps = t.read("sweeps", |n| n.count())?;
    if let Some(i) = t.read("engine", |n| n.choice(&Engine::WORDS))? {
        o.engine = Engine::ALL[i];
    }
    if let Some(i) = t.read("groups", |n| n.choice(&Groups::WORDS))? {
        o.groups = Groups::ALL[i];
    }
    if let Some(i) = t.read("thick_zones", |n| n.choice(&ThickZones::WORDS))? {
        o.thick_zones = ThickZones::ALL[i];
    }
    o.zoning_error = t.read("zoning_error", |n| n.boolean())?;
    Ok(o)
}

/// Axes along which the scene repeats itself.
fn boundary(node: &Node<'_>) -> Result<[bool; 3], InputError> {
    const AXES: [&str; 3] = ["x", "y", "z"];
    let t = node.table(&AXES)?;
    let mut periodic = [false; 3];
    for (axis, periodic) in AXES.into_iter().zip(&mut periodic) {
        *periodic = t.read(axis, |n| n.choice(&["scene", "periodic"]))? == Some(1);
    }
    Ok(periodic)
}

fn light(node: &Node<'_>, index: usize, surfaces: &[Surface]) -> Result<Light, InputError> {
    const KINDS: [&str; 3] = ["sun", "sky", "emitter"];
    let (name, mut t) = surface::named(node, "light", index)?;
    let kind = t.need("kind", "kind = \"sun\", \"sky\" or \"emitter\"")?.choice(&KINDS)?;
    match kind {
        0 => {
            t.check(&["kind", "name", "direction", "irradiance", "angular_diameter"])?;
            t.key = format!("light '{name}'");
            let direction =
                t.need("direction", "direction = [x, y, z], the way along which the light travels")?;
            let d = direction.vector()?;
            // Divide by the largest component first, so that the square neither overflows nor vanishes.
            let unit = (d / d.max_abs()).normalized();
            if !unit.is_finite() {
                return Err(direction
                    .error("this direction has no length; give the way along which the light travels"));
            }
            let irradiance = t.need("irradiance", "irradiance = 1000 (W/m2, number or [r, g, b])")?;
            let diameter = |n: Node<'_>| match n.number()? {
                x if (0.0..180.0).contains(&x) => Ok(x),
                x => Err(
                    n.error(format!("{x} is out of range; give degrees from 0 up to 180 (the sun has 0.53)"))
                ),
            };
            Ok(Light::Sun {
                direction: unit,
                irradiance: irradiance.bands(f64::INFINITY)?,
                angular_diameter: t.read("angular_diameter", diameter)?.unwrap_or(0.53).to_radians(),
                name,
            })
        }
        1 => {
            t.check(&["kind", "name", "radiance"])?;
            t.key = format!("light '{name}'");
            let radiance = t.need("radiance", "radiance = 100 (W/(m2 sr), number or [r, g, b])")?;
            Ok(Light::Sky { radiance: radiance.bands(f64::INFINITY)?, name })
        }
        _ => {
            t.check(&["kind", "name", "surface"])?;
            let surface = t.need("surface", "surface = \"the name of an emitting surface\"")?;
            Ok(Light::Emitter { name: t.get("name").map(|_| name), surface: emitter(&surface, surfaces)? })
        }
    }
}

fn emitter(node: &Node<'_>, surfaces: &[Surface]) -> Result<usize, InputError> {
    let wanted = node.text()?;
    let Some(surface) = surfaces.iter().position(|s| s.name == wanted) else {
        let names: Vec<&str> = surfaces.iter().map(|s| s.name.as_str()).collect();
        let part_of = |s: &&&str| s.strip_prefix(wanted).is_some_and(|rest| rest.starts_with(['.', '/']));
        let parts: Vec<&str> = names.iter().filter(part_of).take(12).copied().collect();
        let hint = match parts.is_empty() {
            false => format!("name one of its parts: {}", parts.join(", ")),
            true if names.is_empty() => "add a [[surface]] with this name".to_string(),
            true => super::node::suggestion(wanted, &names[..names.len().min(24)]),
        };
        return Err(node.error(format!("no surface has the name '{wanted}'; {hint}")));
    };
    let s = &surfaces[surface];
    if s.emission == [0.0; 3] {
        return Err(node.error(format!(
            "surface '{wanted}' does not emit; give it an emission above 0 or remove this light"
        )));
    }
    Ok(surface)
}

/// Keys of a camera that say where it stands and how it sees.
pub(super) const VIEW: [&str; 6] = ["origin", "target", "up", "fov", "aperture", "focus"];

/// Degrees across the picture.
pub(super) fn fov(n: Node<'_>) -> Result<f64, InputError> {
    match n.number()? {
        x if x > 0.0 && x < 180.0 => Ok(x),
        x => Err(n.error(format!("{x} is out of range; give degrees above 0 and below 180"))),
    }
}

/// Metres from 0.
pub(super) fn aperture(n: Node<'_>) -> Result<f64, InputError> {
    match n.number()? {
        x if x >= 0.0 => Ok(x),
        x => Err(n.error(format!("{x} is out of range; give the lens's diameter in metres, from 0"))),
    }
}

fn camera(node: &Node<'_>, index: usize) -> Result<Camera, InputError> {
    let (name, mut t) = surface::named(node, "camera", index)?;
    t.check(&[["name"].as_slice(), &VIEW].concat())?;
    t.key = format!("camera '{name}'");
    t.remember();
    Ok(Camera {
        origin: t.need("origin", "origin = [x, y, z]")?.vector()?,
        target: t.need("target", "target = [x, y, z]")?.vector()?,
        up: t.read("up", |n| n.vector())?.unwrap_or(vec3(0.0, 0.0, 1.0)),
        fov: t.read("fov", fov)?.unwrap_or(60.0),
        lens: Lens {
            aperture: t.read("aperture", aperture)?.unwrap_or(0.0),
            focus: t.read("focus", |n| n.positive())?,
        },
        name,
    })
}
