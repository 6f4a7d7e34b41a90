//! glTF materials as diffuse surfaces and panes.
//!
//! | glTF | this program |
//! |---|---|
//! | base colour and its texture, or the diffuse ones of KHR_materials_pbrSpecularGlossiness | reflectance, at most 0.95; the metallic factor is ignored |
//! | emissive factor × strength × texture | a radiance L; emission = π L |
//! | normal texture and its scale | normal map, for pictures |
//! | unlit | reflectance = base colour, at most 0.95; no emission |
//! | diffuse transmission, rough transmission without volume | sheet of two sides (`sheets`) |
//! | transmission with volume | pane, κ = −ln(attenuation colour)/attenuation distance, Ω = 0 |
//! | transmission without volume | pane, κ = −ln(base colour × factor)/thickness, Ω = 0 |
//! | alpha blend | pane, κ = −ln(1 − alpha)/thickness, Ω = base colour; alpha 1 is opaque |
//! | alpha mask; alpha blend by the alpha of a texture | faces cut along their alpha (`mesh::transparent_materials`) |

use super::accessors::Buffers;
use super::broken_textures::BROKEN_IMAGE;
use super::container::{path_beside, resolve_uri};
use super::material_notes::ignored_properties;
use super::nodes::NodeInstance;
use super::sheets::SheetFactors;
use super::specular_glossiness::DiffuseFactors;
use super::texture_mapping::TextureMapping;
use crate::files::FileSource;
use crate::input::images;
use crate::input::images::AlphaChannel;
use crate::input::mesh::model::{
    AlphaRule, AlphaSource, GlassAttenuation, GlassProperties, ImageSource, MIN_TRANSMITTANCE, MeshData,
    MeshMaterial, WeightedImage,
};
use crate::input::reading::error::FileFault;
use gltf::Document;
use gltf::material::AlphaMode;
use std::collections::{HashMap, HashSet};
use std::f64::consts::PI;
use std::path::Path;
use std::rc::Rc;
use zonal_scene::Bands;

/// Largest reflectance of an unlit material.
const MAX_UNLIT_REFLECTANCE: f64 = 0.95;

/// Largest factor of a normal map.
const MAX_NORMAL_SCALE: f64 = 100.0;

/// Cutoff of a mask without one.
const DEFAULT_CUTOFF: f32 = 0.5;

/// The texture mappings of all materials; the default material is added when a primitive uses it.
pub(super) struct MaterialTable {
    mappings: Vec<TextureMapping>,
    default: Option<usize>,
}

impl MaterialTable {
    /// The index in `mesh.materials` of a primitive's material.
    pub(super) fn index_of(&mut self, material: Option<usize>, mesh: &mut MeshData) -> usize {
        if let Some(i) = material.filter(|i| *i < mesh.materials.len()) {
            return i;
        }
        *self.default.get_or_insert_with(|| {
            mesh.materials.push(MeshMaterial {
                reflectance: Some(Bands::ONE),
                double_sided: Some(false),
                ..MeshMaterial::named("default")
            });
            self.mappings.push(TextureMapping::NO_TEXTURE);
            mesh.materials.len() - 1
        })
    }
    /// The texture mapping of a material.
    pub(super) fn mapping(&self, material: usize) -> TextureMapping {
        self.mappings.get(material).copied().unwrap_or(TextureMapping::NO_TEXTURE)
    }
}

/// Reads all materials into `mesh.materials`, in the file's order; of those that no instance shows, which may be broken, the name only.
pub(super) fn read_materials(
    document: &Document,
    instances: &[NodeInstance],
    files: FileSource<'_>,
    path: &Path,
    buffers: &Buffers<'_>,
    mesh: &mut MeshData,
) -> Result<MaterialTable, FileFault> {
    let mut mappings = Vec::new();
    let mut names = HashSet::new();
    let shown = shown_materials(document, instances);
    let mut images = ImageReader { files, path, buffers, image_cache: HashMap::new() };
    for (i, m) in document.materials().enumerate() {
        let mut name = m.name().unwrap_or("").trim().to_string();
        if name.is_empty() {
            name = format!("material{i}");
        }
        if !names.insert(name.clone()) {
            name = format!("{name}#{i}");
            names.insert(name.clone());
        }
        if !shown.contains(&i) {
            mesh.materials.push(MeshMaterial::named(&name));
            mappings.push(TextureMapping::NO_TEXTURE);
            continue;
        }
        let ignored = ignored_properties(&m).into_iter();
        mesh.notes.extend(ignored.map(|text| format!("{}: material '{name}': {text}", buffers.file)));
        let (material, mapping) = images.read_material(&m, name, &mut mesh.notes)?;
        mesh.materials.push(material);
        mappings.push(mapping);
    }
    Ok(MaterialTable { mappings, default: None })
}

/// The materials of the meshes that instances show.
fn shown_materials(document: &Document, instances: &[NodeInstance]) -> HashSet<usize> {
    let meshes: HashSet<usize> = instances.iter().filter_map(|n| n.mesh).collect();
    let json = &document.as_json().meshes;
    let primitives = meshes.iter().filter_map(|i| json.get(*i)).flat_map(|m| &m.primitives);
    primitives.filter_map(|p| Some(p.material?.value())).collect()
}

/// The alpha of a material that is cut out, or blends by the alpha of its texture.
fn read_alpha(m: &gltf::Material<'_>, factor: f64, textured: Option<&ImageSource>) -> Option<AlphaSource> {
    let rule = match m.alpha_mode() {
        AlphaMode::Opaque => return None,
        AlphaMode::Mask => AlphaRule::Mask { cutoff: f64::from(m.alpha_cutoff().unwrap_or(DEFAULT_CUTOFF)) },
        AlphaMode::Blend => AlphaRule::Blend,
    };
    let cut_out = matches!(rule, AlphaRule::Mask { cutoff } if factor < cutoff);
    let image = textured.cloned();
    (image.is_some() || cut_out).then_some(AlphaSource { image, channel: AlphaChannel::Alpha, factor, rule })
}

/// True if an image may have an alpha channel; one that cannot be read is refused where it is used.
fn has_alpha(files: FileSource<'_>, image: &ImageSource) -> bool {
    match image {
        ImageSource::Bytes { bytes, .. } => images::has_alpha(bytes),
        ImageSource::Weighted(own) => own.base.as_ref().is_some_and(|image| has_alpha(files, image)),
        ImageSource::Limited(own) => has_alpha(files, &own.base),
        ImageSource::File(path) => {
            files.read(path, images::MAX_IMAGE_FILE_BYTES).is_ok_and(|b| images::has_alpha(&b))
        }
    }
}

/// A place in a file, for messages.
#[derive(Clone, Copy)]
struct FilePlace<'a> {
    file: &'a str,
    place: &'a str,
}

/// The glass of a material that transmits or blends; none of an opaque one.
fn read_glass(
    m: &gltf::Material<'_>,
    base: Bands,
    alpha: f64,
    at: FilePlace<'_>,
    notes: &mut Vec<String>,
) -> Result<Option<GlassProperties>, FileFault> {
    let FilePlace { file, place } = at;
    let transmission = m.transmission().map_or(0.0, |t| f64::from(t.transmission_factor()));
    let volume = m.volume();
    let thickness = volume.as_ref().map(|v| f64::from(v.thickness_factor())).filter(|t| *t > 0.0);
    let cover = if m.alpha_mode() == AlphaMode::Blend { alpha.min(1.0) } else { 1.0 };
    if transmission > 0.0 {
        let attenuation = match &volume {
            Some(v) => GlassAttenuation::Coefficient(absorption_coefficient(v).ok_or_else(|| {
                let message = "the attenuation is negative or not a number; export the file again";
                FileFault::new(file, place, message)
            })?),
            // Alpha is the fraction of the area that the material covers.
            None => GlassAttenuation::Transmittance(
                base.map(|x| (1.0 - cover + cover * x * transmission).clamp(MIN_TRANSMITTANCE, 1.0)),
            ),
        };
        if volume.is_some() && base != Bands::ONE {
            notes.push(format!("{file}: {place}: the base colour of a material with a volume was ignored"));
        }
        return Ok(Some(GlassProperties { thickness, attenuation, albedo: Bands::ZERO }));
    }
    if m.alpha_mode() == AlphaMode::Blend && alpha < 1.0 {
        return Ok(Some(GlassProperties {
            thickness,
            attenuation: GlassAttenuation::Transmittance(Bands::splat(
                (1.0 - alpha).clamp(MIN_TRANSMITTANCE, 1.0),
            )),
            albedo: base.map(|x| x.min(1.0)),
        }));
    }
    Ok(None)
}

/// σ_a = −ln(colour)/distance, in 1/(unit of the file); zero for an infinite distance.
pub(super) fn absorption_coefficient(v: &gltf::material::Volume<'_>) -> Option<Bands> {
    let distance = f64::from(v.attenuation_distance());
    let colour = Bands::from_rgb(v.attenuation_color().map(f64::from));
    if !(distance > 0.0 && colour.all(|c| c.is_finite() && c >= 0.0)) {
        return None;
    }
    Some(colour.map(|c| (-c.clamp(MIN_TRANSMITTANCE, 1.0).ln() / distance).max(0.0)))
}

struct ImageReader<'a> {
    files: FileSource<'a>,
    path: &'a Path,
    buffers: &'a Buffers<'a>,
    /// Images already read, by index.
    image_cache: HashMap<usize, ImageSource>,
}

impl ImageReader<'_> {
    /// Reads one material, and the mapping of its textures.
    fn read_material(
        &mut self,
        m: &gltf::Material<'_>,
        name: String,
        notes: &mut Vec<String>,
    ) -> Result<(MeshMaterial, TextureMapping), FileFault> {
        let file = self.buffers.file;
        let place = format!("material '{name}'");
        let pbr = m.pbr_metallic_roughness();
        let diffuse = DiffuseFactors::of(m);
        let factor = diffuse.as_ref().map_or(pbr.base_color_factor().map(f64::from), |d| d.colour);
        let [r, g, b, alpha] = factor;
        let base = Bands::from_rgb([r, g, b]);
        let emissive = Bands::from_rgb(m.emissive_factor().map(f64::from));
        let strength = m.emissive_strength().map_or(1.0, f64::from);
        let valid = |x: f64| x.is_finite() && x >= 0.0;
        if !(base.into_iter().chain(emissive).all(valid) && valid(alpha) && valid(strength)) {
            let message = "a colour or strength is negative or not a number; export the file again";
            return Err(FileFault::new(file, place, message));
        }
        let mut out = MeshMaterial::named(&name);
        out.double_sided = Some(m.double_sided());
        out.reflectance = Some(base.map(|x| x.min(if m.unlit() { MAX_UNLIT_REFLECTANCE } else { 1.0 })));
        let mut mapping = TextureMapping::NO_TEXTURE;
        let of_base = || pbr.base_color_texture().map(|t| (t.texture().index(), TextureMapping::new(&t)));
        if let Some((texture, own)) = diffuse.map_or_else(of_base, |d| d.texture) {
            out.texture = Some(self.image_of(texture, &place)?);
            mapping = own;
        }
        if m.unlit() {
            notes.push(format!(
                "{file}: {place} is unlit; its base colour was taken as reflectance, at most {MAX_UNLIT_REFLECTANCE}, and it does not emit"
            ));
            if out.texture.is_some() {
                out.reflectance = Some(base.map(|x| x.min(1.0) * MAX_UNLIT_REFLECTANCE));
            }
        } else {
            out.emission = emissive.map(|x| x * strength * PI);
            self.read_emissive_texture(m, &place, &mut mapping, &mut out, notes)?;
        }
        self.read_transparency(m, factor, &place, &mut out, &mut mapping, notes)?;
        self.read_normal_map(m, &place, &mut out, &mut mapping, notes);
        Ok((out, mapping))
    }

    /// Reads the transmission of a sheet, the alpha and the glass of a material, whose base colour has four components.
    fn read_transparency(
        &mut self,
        m: &gltf::Material<'_>,
        base_colour: [f64; 4],
        place: &str,
        out: &mut MeshMaterial,
        mapping: &mut TextureMapping,
        notes: &mut Vec<String>,
    ) -> Result<(), FileFault> {
        let [r, g, b, alpha] = base_colour;
        let base = Bands::from_rgb([r, g, b]);
        let base_texture = out.texture.clone();
        let sheet = SheetFactors::of(m);
        if let Some(sheet) = &sheet {
            self.read_sheet(sheet, place, out, base)?;
            if let Some(own) = sheet.mapping.filter(|_| !mapping.used) {
                *mapping = own;
            }
        }
        if sheet.is_some() || m.transmission().is_none_or(|t| t.transmission_factor() <= 0.0) {
            // Decode textures only if their alpha matters.
            let image = base_texture.as_ref().filter(|_| m.alpha_mode() != AlphaMode::Opaque);
            out.alpha = read_alpha(m, alpha, image.filter(|image| has_alpha(self.files, image)));
        }
        if out.alpha.is_none() {
            out.glass = read_glass(m, base, alpha, FilePlace { file: self.buffers.file, place }, notes)?;
        }
        Ok(())
    }

    /// Reads the emissive texture of a material that emits. Both textures share one mapping: that of the base colour, if it has one.
    fn read_emissive_texture(
        &mut self,
        m: &gltf::Material<'_>,
        place: &str,
        mapping: &mut TextureMapping,
        out: &mut MeshMaterial,
        notes: &mut Vec<String>,
    ) -> Result<(), FileFault> {
        let Some(info) = m.emissive_texture().filter(|_| out.emission != Bands::ZERO) else { return Ok(()) };
        let own = TextureMapping::new(&info);
        if mapping.used && !mapping.is_same_as(&own) {
            notes.push(format!(
                "{}: {place} maps its emissive texture in another way than its base colour; the latter's was used for both",
                self.buffers.file
            ));
        } else {
            *mapping = own;
        }
        out.emission_texture = Some(self.image_of(info.texture().index(), place)?);
        Ok(())
    }

    /// Reads the normal map of a material. It shares the mapping of the other textures, if there are any. Tangents follow from the texture coordinates.
    fn read_normal_map(
        &mut self,
        m: &gltf::Material<'_>,
        place: &str,
        out: &mut MeshMaterial,
        mapping: &mut TextureMapping,
        notes: &mut Vec<String>,
    ) {
        let Some(info) = m.normal_texture() else { return };
        let own = TextureMapping::of_normal_map(&info);
        if mapping.used && !mapping.is_same_as(&own) {
            notes.push(format!(
                "{}: {place} maps its normal map in another way than its colours; the normal map was not read",
                self.buffers.file
            ));
            return;
        }
        match self.image_of(info.texture().index(), place) {
            Ok(image) => {
                *mapping = own;
                let scale = f64::from(info.scale()).clamp(-MAX_NORMAL_SCALE, MAX_NORMAL_SCALE);
                out.normal_map = Some((image, scale));
            }
            Err(e) => notes.push(format!("the normal map of {place} is not read ({e})")),
        }
    }

    /// Turns a material into a sheet that transmits diffusely.
    fn read_sheet(
        &mut self,
        sheet: &SheetFactors,
        place: &str,
        out: &mut MeshMaterial,
        base: Bands,
    ) -> Result<(), FileFault> {
        let base = base.map(|x| x.min(1.0));
        let (mut colour, mut colour_image) = (sheet.colour, None);
        if let Some(texture) = sheet.colour_texture {
            colour_image = Some(self.image_of(texture, place)?);
        }
        if sheet.base_colour {
            (colour, colour_image) = (base, out.texture.clone());
        }
        let Some(texture) = sheet.factor_texture else {
            out.reflectance = Some(base * (1.0 - sheet.factor));
            out.transmittance = Some((colour * sheet.factor, colour_image));
            return Ok(());
        };
        let weight = self.image_of(texture, place)?;
        let channel = if sheet.factor_in_red { AlphaChannel::Red } else { AlphaChannel::Alpha };
        let weighted = |image: Option<ImageSource>, complement: bool| {
            let weight = weight.clone();
            let own = WeightedImage { base: image, weight, channel, factor: sheet.factor, complement };
            Some(ImageSource::Weighted(Rc::new(own)))
        };
        out.reflectance = Some(base);
        out.texture = weighted(out.texture.take(), true);
        out.transmittance = Some((colour, weighted(colour_image, false)));
        Ok(())
    }

    /// The image of the texture of an index.
    fn image_of(&mut self, texture: usize, place: &str) -> Result<ImageSource, FileFault> {
        let file = self.buffers.file;
        let root = self.buffers.root;
        let fault =
            |message: String| Err(FileFault::new(file, place, format!("{message}; export the file again")));
        let index = root.textures.get(texture).map(|t| t.source.value());
        let Some((index, image)) = index.and_then(|i| Some((i, root.images.get(i)?))) else {
            return fault(format!("its texture {texture} has no image"));
        };
        if let Some(defect) = image.name.as_deref().and_then(|name| name.strip_prefix(BROKEN_IMAGE)) {
            return fault(defect.to_string());
        }
        if let Some(p) = self.image_cache.get(&index) {
            return Ok(p.clone());
        }
        let label = format!("image {index}");
        let bytes = match (image.buffer_view, &image.uri) {
            (Some(view), _) => self.buffers.view(view, &label)?.to_vec(),
            (None, Some(uri)) if uri.starts_with("data:") => {
                resolve_uri(self.files, file, self.path, &label, uri)?
            }
            (None, Some(uri)) => {
                let image_source = ImageSource::File(path_beside(self.path, uri));
                self.image_cache.insert(index, image_source.clone());
                return Ok(image_source);
            }
            (None, None) => return fault(format!("{label} has neither data nor a file")),
        };
        let image_source = ImageSource::Bytes { name: format!("{file}:{label}"), bytes: Rc::from(bytes) };
        self.image_cache.insert(index, image_source.clone());
        Ok(image_source)
    }
}
