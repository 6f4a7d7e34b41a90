//! glTF materials as diffuse surfaces and panes.
//!
//! | glTF | here |
//! |---|---|
//! | base colour and its texture | reflectance; the metallic share is left aside |
//! | emissive factor × strength × texture | a radiance L; emission = π L |
//! | unlit | reflectance = base colour, at most 0.95; no emission |
//! | transmission with volume | pane, κ = −ln(attenuation colour)/attenuation distance, Ω = 0 |
//! | transmission without volume | pane, κ = −ln(base colour × factor)/thickness, Ω = 0 |
//! | alpha blend | pane, κ = −ln(1 − alpha)/thickness, Ω = base colour; alpha 1 is opaque |
//! | alpha mask, alpha of pictures | not read: told where the material is used |

use super::glb::{self, Buffers};
use super::{Glass, Loss, Material, Mesh, Picture};
use crate::input::error::Fault;
use crate::input::files::Files;
use crate::input::texture;
use gltf::Document;
use gltf::material::AlphaMode;
use std::collections::{HashMap, HashSet};
use std::f64::consts::PI;
use std::path::Path;
use std::rc::Rc;
use zonal_scene::{Bands, bands};

/// The most that an unlit material reflects.
const UNLIT: f64 = 0.95;
/// The least share that a colour lets pass, so that its extinction stays finite.
const LEAST: f64 = 1e-6;

/// How a material's picture is laid on: the TEXCOORD set and KHR_texture_transform.
#[derive(Clone, Copy)]
pub(crate) struct Map {
    pub(crate) used: bool,
    pub(crate) set: u32,
    offset: [f64; 2],
    scale: [f64; 2],
    sin_cos: (f64, f64),
}

impl Map {
    const NONE: Map = Map { used: false, set: 0, offset: [0.0; 2], scale: [1.0; 2], sin_cos: (0.0, 1.0) };
    fn new(info: &gltf::texture::Info<'_>) -> Map {
        let mut map = Map { used: true, set: info.tex_coord(), ..Map::NONE };
        if let Some(t) = info.texture_transform() {
            map.set = t.tex_coord().unwrap_or(map.set);
            map.offset = t.offset().map(f64::from);
            map.scale = t.scale().map(f64::from);
            map.sin_cos = f64::from(t.rotation()).sin_cos();
        }
        map
    }
    pub(crate) fn apply(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let (u, v) = (u * self.scale[0], v * self.scale[1]);
        let (sin, cos) = self.sin_cos;
        [cos * u + sin * v + self.offset[0], cos * v - sin * u + self.offset[1]]
    }
    fn same(&self, other: &Map) -> bool {
        (self.set, self.offset, self.scale, self.sin_cos)
            == (other.set, other.offset, other.scale, other.sin_cos)
    }
}

/// The maps of all materials; the default material comes into being when a primitive wants it.
pub(crate) struct Maps {
    maps: Vec<Map>,
    default: Option<usize>,
}

impl Maps {
    /// The index in `mesh.materials` of a primitive's material.
    pub(crate) fn of(&mut self, material: Option<usize>, mesh: &mut Mesh) -> usize {
        if let Some(i) = material.filter(|i| *i < mesh.materials.len()) {
            return i;
        }
        *self.default.get_or_insert_with(|| {
            mesh.materials.push(Material {
                reflectance: Some([1.0; 3]),
                both_sides: Some(false),
                ..Material::named("default")
            });
            self.maps.push(Map::NONE);
            mesh.materials.len() - 1
        })
    }
    pub(crate) fn map(&self, material: usize) -> Map {
        self.maps.get(material).copied().unwrap_or(Map::NONE)
    }
}

/// Reads all materials into `mesh.materials`, in the file's order.
pub(crate) fn read_all(
    document: &Document,
    files: Files<'_>,
    path: &Path,
    buffers: &Buffers<'_>,
    mesh: &mut Mesh,
) -> Result<Maps, Fault> {
    let mut maps = Vec::new();
    let mut names = HashSet::new();
    let mut pictures = Pictures { files, path, buffers, read: HashMap::new(), metallic: 0 };
    for (i, m) in document.materials().enumerate() {
        let mut name = m.name().unwrap_or("").trim().to_string();
        if name.is_empty() {
            name = format!("material{i}");
        }
        if !names.insert(name.clone()) {
            name = format!("{name}#{i}");
            names.insert(name.clone());
        }
        let (material, map) = read(&m, name, &mut pictures, &mut mesh.notes)?;
        mesh.materials.push(material);
        maps.push(map);
    }
    if pictures.metallic > 0 {
        let (file, n) = (buffers.file, pictures.metallic);
        mesh.notes.push(format!("{file}: {n} metallic materials were read as diffuse"));
    }
    Ok(Maps { maps, default: None })
}

fn read(
    m: &gltf::Material<'_>,
    name: String,
    pictures: &mut Pictures<'_>,
    notes: &mut Vec<String>,
) -> Result<(Material, Map), Fault> {
    let file = pictures.buffers.file;
    let place = format!("material '{name}'");
    let pbr = m.pbr_metallic_roughness();
    let [r, g, b, alpha] = pbr.base_color_factor().map(f64::from);
    let base = [r, g, b];
    let emissive = m.emissive_factor().map(f64::from);
    let strength = m.emissive_strength().map_or(1.0, f64::from);
    let sane = |x: f64| x.is_finite() && x >= 0.0;
    if !(base.into_iter().chain(emissive).all(sane) && sane(alpha) && sane(strength)) {
        let what = "a colour or strength is negative or not a number; export the file again";
        return Err(Fault::new(file, place, what));
    }
    let mut out = Material::named(&name);
    out.both_sides = Some(m.double_sided());
    out.reflectance = Some(base.map(|x| x.min(if m.unlit() { UNLIT } else { 1.0 })));
    let mut map = Map::NONE;
    if let Some(info) = pbr.base_color_texture() {
        out.texture = pictures.of(&info.texture(), &place)?;
        map = Map::new(&info);
    }
    if m.unlit() {
        notes.push(format!(
            "{file}: {place} is unlit; its base colour was taken as reflectance, at most {UNLIT}, and it does not emit"
        ));
        if out.texture.is_some() {
            out.reflectance = Some(base.map(|x| x.min(1.0) * UNLIT));
        }
    } else {
        out.emission = emissive.map(|x| x * strength * PI);
        if let Some(info) = m.emissive_texture().filter(|_| out.emission != [0.0; 3]) {
            let own = Map::new(&info);
            if map.used && !map.same(&own) {
                notes.push(format!(
                    "{file}: {place} lays its emissive picture in another way than its base colour; the latter's was used for both"
                ));
            } else {
                map = own;
            }
            out.emission_texture = pictures.of(&info.texture(), &place)?;
        }
        if pbr.metallic_factor() > 0.0 && pbr.metallic_roughness_texture().is_none() {
            pictures.metallic += 1;
        }
    }
    out.glass = glass(m, base, alpha, file, &place, notes)?;
    if m.transmission().is_none_or(|t| t.transmission_factor() <= 0.0) {
        // Pictures are looked into only where their alpha counts.
        let in_picture = m.alpha_mode() != AlphaMode::Opaque
            && out.texture.as_ref().is_some_and(|picture| has_alpha(pictures.files, picture));
        lost_alpha(
            (m.alpha_mode(), in_picture),
            alpha,
            m.alpha_cutoff(),
            &format!("{file}: {place}"),
            &mut out,
        );
    }
    Ok((out, map))
}

/// Says what of a material's alpha is not read: that of its picture, and cut-outs.
fn lost_alpha(
    (mode, in_picture): (AlphaMode, bool),
    alpha: f64,
    cutoff: Option<f32>,
    place: &str,
    out: &mut Material,
) {
    let name = out.name.clone();
    let mend = format!("leave it out by materials.\"{name}\".omit = true, or cut its holes into the mesh");
    match mode {
        AlphaMode::Mask if in_picture => {
            out.lost_opaque = Some(format!(
                "{place} has holes in the alpha of its picture (alphaMode MASK), which are not read: it is opaque all over; {mend}"
            ));
        }
        AlphaMode::Mask if alpha < f64::from(cutoff.unwrap_or(0.5)) => {
            out.lost_opaque = Some(format!(
                "{place} is cut out all over (alphaMode MASK, alpha below the cutoff), which is not read: it is opaque; {mend}"
            ));
        }
        AlphaMode::Blend if in_picture && alpha >= 1.0 => {
            out.lost_opaque = Some(format!(
                "{place} blends by the alpha of its picture, which is not read: it is opaque; write materials.\"{name}\".pane = {{ … }} for a pane, or pane = false and a look of its own"
            ));
        }
        AlphaMode::Blend if in_picture => {
            out.lost_pane = Some(format!(
                "{place} blends by the alpha of its picture too, which is not read: its alpha factor alone was used"
            ));
        }
        _ => {}
    }
}

/// True where a picture may have an alpha channel; one that cannot be read is refused where it is used.
fn has_alpha(files: Files<'_>, picture: &Picture) -> bool {
    match picture {
        Picture::Bytes { bytes, .. } => texture::has_alpha(bytes),
        Picture::File(path) => files.read(path, texture::MAX_FILE).is_ok_and(|b| texture::has_alpha(&b)),
    }
}

fn glass(
    m: &gltf::Material<'_>,
    base: Bands,
    alpha: f64,
    file: &str,
    place: &str,
    notes: &mut Vec<String>,
) -> Result<Option<Glass>, Fault> {
    let transmission = m.transmission().map_or(0.0, |t| f64::from(t.transmission_factor()));
    let volume = m.volume();
    let thickness = volume.as_ref().map(|v| f64::from(v.thickness_factor())).filter(|t| *t > 0.0);
    if transmission > 0.0 {
        let loss = match &volume {
            Some(v) => Loss::PerMetre(absorption(v).ok_or_else(|| {
                let what = "the attenuation is negative or not a number; export the file again";
                Fault::new(file, place, what)
            })?),
            None => Loss::Passed(base.map(|x| (x * transmission).clamp(LEAST, 1.0))),
        };
        if volume.is_some() && base != [1.0; 3] {
            notes
                .push(format!("{file}: {place}: the base colour of a material with a volume was left aside"));
        }
        return Ok(Some(Glass { thickness, loss, albedo: [0.0; 3] }));
    }
    if m.alpha_mode() == AlphaMode::Blend {
        if alpha >= 1.0 {
            return Ok(None);
        }
        return Ok(Some(Glass {
            thickness,
            loss: Loss::Passed([(1.0 - alpha).clamp(LEAST, 1.0); 3]),
            albedo: base.map(|x| x.min(1.0)),
        }));
    }
    Ok(None)
}

/// σ_a = −ln(colour)/distance, in 1/(unit of the file); zero where the distance is infinite.
pub(crate) fn absorption(v: &gltf::material::Volume<'_>) -> Option<Bands> {
    let distance = f64::from(v.attenuation_distance());
    let colour = v.attenuation_color().map(f64::from);
    if !(distance > 0.0 && colour.iter().all(|c| c.is_finite() && *c >= 0.0)) {
        return None;
    }
    Some(bands(|k| -colour[k].clamp(LEAST, 1.0).ln() / distance).map(|x| x.max(0.0)))
}

struct Pictures<'a> {
    files: Files<'a>,
    path: &'a Path,
    buffers: &'a Buffers<'a>,
    read: HashMap<usize, Picture>,
    /// How many materials are metallic.
    metallic: usize,
}

impl Pictures<'_> {
    fn of(&mut self, texture: &gltf::Texture<'_>, place: &str) -> Result<Option<Picture>, Fault> {
        let file = self.buffers.file;
        let root = self.buffers.root;
        let index = root.textures.get(texture.index()).map(|t| t.source.value());
        let Some((index, image)) = index.and_then(|i| Some((i, root.images.get(i)?))) else {
            let what = "its texture has no image; export the file again";
            return Err(Fault::new(file, place, what));
        };
        if let Some(p) = self.read.get(&index) {
            return Ok(Some(p.clone()));
        }
        let label = format!("image {index}");
        let bytes = match (image.buffer_view, &image.uri) {
            (Some(view), _) => self.buffers.view(view, &label)?.to_vec(),
            (None, Some(uri)) if uri.starts_with("data:") => {
                glb::resolve(self.files, file, self.path, &label, uri)?
            }
            (None, Some(uri)) => {
                let picture = Picture::File(glb::beside(self.path, uri));
                self.read.insert(index, picture.clone());
                return Ok(Some(picture));
            }
            (None, None) => {
                let what = "this image has neither data nor a file; export the file again";
                return Err(Fault::new(file, label, what));
            }
        };
        let picture = Picture::Bytes { name: format!("{file}:{label}"), bytes: Rc::from(bytes) };
        self.read.insert(index, picture.clone());
        Ok(Some(picture))
    }
}
