//! The scene while it is read: its parts so far, the files it may use, and the textures decoded so far.

use crate::files::FileSource;
use crate::input::images;
use crate::input::images::AlphaChannel;
use crate::input::images::alpha_map::AlphaMap;
use crate::input::mesh::model::{AlphaSource, ImageSource, LimitedImage, WeightedImage};
use crate::input::reading::error::{FileFault, InputError};
use crate::input::scene::quantities::gas_composition::SceneGas;
use crate::input::scene::quantities::medium_properties::MediumProperties;
use crate::input::scene::quantities::surface_properties::SurfaceProperties;
use crate::input::scene::thermal::SceneMode;
use crate::input::toml::node::TomlNode;
use crate::input::toml::source::SourceText;
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::rc::Rc;
use zonal_scene::{
    Bands, Diagnostic, EmissivityTable, Plate, SceneError, SceneParts, SideEmissivity, Sides, Surface,
    SurfaceEmissivity, Texture, ThermalCondition,
};

/// Files that a scene may refer to, and its largest medium.
#[derive(Clone, Copy)]
pub(crate) struct ReadContext<'a> {
    /// Folder of referenced files; none if they are refused.
    pub(crate) base: Option<&'a Path>,
    /// Storage of referenced files.
    pub(crate) files: FileSource<'a>,
    /// Largest number of voxels.
    pub(crate) max_cells: usize,
}

/// A closed body and the medium inside it.
pub(crate) struct InteriorFill {
    pub(crate) plates: Vec<Plate>,
    pub(crate) properties: MediumProperties,
}

/// The scene while it is read.
pub(crate) struct SceneReader<'a> {
    pub(crate) source: &'a SourceText<'a>,
    pub(crate) context: ReadContext<'a>,
    pub(crate) parts: SceneParts,
    /// True if the scene has a medium.
    pub(crate) has_medium: bool,
    /// The gas model of the medium.
    pub(crate) gas: Option<SceneGas>,
    /// Bodies of meshes that fill the medium, after its regions.
    pub(crate) interior_fills: Vec<InteriorFill>,
    /// Tables of emissivities by temperature.
    pub(crate) emissivity_tables: Vec<EmissivityTable>,
    texture_of_image: HashMap<String, usize>,
    /// The textures with pixels that were reduced to a limit.
    limited_textures: HashSet<usize>,
    /// Alpha of images already read.
    alpha_of_image: HashMap<(String, AlphaChannel), Rc<AlphaMap>>,
}

impl<'a> SceneReader<'a> {
    pub(crate) fn new(source: &'a SourceText<'a>, context: ReadContext<'a>) -> SceneReader<'a> {
        SceneReader {
            source,
            context,
            parts: SceneParts::default(),
            has_medium: false,
            gas: None,
            interior_fills: Vec::new(),
            emissivity_tables: Vec::new(),
            texture_of_image: HashMap::new(),
            limited_textures: HashSet::new(),
            alpha_of_image: HashMap::new(),
        }
    }
    /// The mode of the scene.
    pub(crate) fn mode(&self) -> SceneMode {
        if self.parts.thermal.is_some() { SceneMode::Thermal } else { SceneMode::Light }
    }
    /// Adds a surface and returns its index. Thermal mode takes its boundary condition from the properties and requires an emissivity.
    pub(crate) fn add_surface(
        &mut self,
        mut surface: Surface,
        properties: &SurfaceProperties,
    ) -> Result<usize, InputError> {
        let (bands, block) = (&self.parts.bands, self.parts.block);
        if let Some(a) = properties.solar_absorptance {
            surface.reflectance = bands.with_solar_value(block, surface.reflectance, 1.0 - a);
        }
        if let Some(thermal) = &mut self.parts.thermal {
            let missing = |key: &str, message: &str| {
                let key = format!("surface '{}'.{key}", surface.name);
                Err(self.source.scene_error(&SceneError::new(key, message)))
            };
            // A surface with convection alone is adiabatic behind.
            let convective = properties.convection.map(|_| ThermalCondition::Flux(0.0));
            let Some(condition) = properties.condition.or(convective) else {
                return missing(
                    "temperature",
                    "nothing is known of this surface; write temperature (K), heat_flux (W/m2), net_power (W) or node; heat_flux = 0 is adiabatic",
                );
            };
            if let Some((key, message)) = missing_key(&surface, properties, condition) {
                return missing(key, message);
            }
            thermal.emissivities.push(emissivity_of(&self.emissivity_tables, properties));
            thermal.surfaces.push(condition);
            let network = thermal.network.get_or_insert_default();
            network.surface_nodes.push(properties.node);
            network.convection.push(properties.convection);
        }
        self.parts.surfaces.push(surface);
        Ok(self.parts.surfaces.len() - 1)
    }
    /// Adds the thermal condition of a pane in thermal mode: radiative equilibrium if none is given.
    pub(crate) fn add_pane_condition(&mut self, condition: Option<ThermalCondition>) {
        if let Some(thermal) = &mut self.parts.thermal {
            thermal.panes.push(condition.unwrap_or(ThermalCondition::Flux(0.0)));
        }
    }
    /// Places errors about surface `name` where surface `other` stands, unless `name` has a place already.
    pub(crate) fn inherit_surface_place(&self, name: &str, other: &str) {
        self.source.inherit_place(&format!("surface '{name}'"), &format!("surface '{other}'"));
    }
    pub(crate) fn note(&mut self, note: impl Into<Diagnostic>) {
        self.parts.notes.push(note.into());
    }
    /// The index of the texture that a value names.
    pub(crate) fn texture(&mut self, node: &TomlNode<'_>) -> Result<usize, InputError> {
        let (path, _) = node.named_file()?;
        self.image(&ImageSource::File(path)).map_err(|f| node.error(f.to_string()))
    }
    /// The bytes of an image.
    fn bytes_of<'i>(&self, image: &'i ImageSource) -> Result<Cow<'i, [u8]>, FileFault> {
        match image {
            ImageSource::Bytes { bytes, .. } => Ok(Cow::Borrowed(bytes)),
            ImageSource::File(path) => {
                let bytes = self.context.files.read(path, images::MAX_IMAGE_FILE_BYTES);
                bytes.map(Cow::Owned).map_err(|e| FileFault::new(&image.name(), "", e))
            }
            ImageSource::Limited(own) => self.bytes_of(&own.base),
            // Made of other images, without bytes of its own.
            ImageSource::Weighted(_) => Ok(Cow::Borrowed(&[])),
        }
    }
    /// The alpha of a material; every image is decoded once.
    pub(crate) fn alpha_map(&mut self, alpha: &AlphaSource) -> Result<Rc<AlphaMap>, FileFault> {
        let Some(image) = &alpha.image else { return Ok(Rc::new(AlphaMap::opaque())) };
        let key = (image.name(), alpha.channel);
        if let Some(map) = self.alpha_of_image.get(&key) {
            return Ok(map.clone());
        }
        let decode = || images::decode_alpha(&key.0, &self.bytes_of(image)?, alpha.channel);
        let map = self.source.once(format!("{} {:?}", key.0, key.1), decode)?;
        self.alpha_of_image.insert(key, map.clone());
        Ok(map)
    }
    /// The texture of an image.
    fn decoded(&self, image: &ImageSource) -> Result<Texture, FileFault> {
        let name = image.name();
        let decode = || match image {
            ImageSource::Weighted(own) => self.weighted(own),
            _ => images::decode(&name, &self.bytes_of(image)?),
        };
        self.source.once(name.as_str(), decode).map(Rc::unwrap_or_clone)
    }
    /// The texture of an image, weighted by another one.
    fn weighted(&self, own: &WeightedImage) -> Result<Texture, FileFault> {
        let weight = images::decode_alpha(&own.weight.name(), &self.bytes_of(&own.weight)?, own.channel)?;
        let base = own.base.as_ref().map(|image| self.decoded(image)).transpose()?;
        let size = |of_base: Option<usize>, of_weight: usize| of_base.unwrap_or(1).max(of_weight);
        let [width, height] = weight.size();
        let width = size(base.as_ref().map(|t| t.width), width);
        let height = size(base.as_ref().map(|t| t.height), height);
        let pixel = |i: usize| {
            let uv = [(i % width, width), (i / width, height)].map(|(k, n)| (k as f64 + 0.5) / n as f64);
            let w = own.factor * weight.at(uv);
            let colour = base.as_ref().map_or(Bands::ONE, |t| t.sample(uv));
            (colour * if own.complement { 1.0 - w } else { w }).to_rgb().map(|x| x.max(0.0) as f32)
        };
        Ok(Texture { width, height, pixels: (0..width * height).map(pixel).collect() })
    }
    /// The index of a normal map's texture, with its values as stored; every image is decoded once.
    pub(crate) fn normal_map(&mut self, image: &ImageSource) -> Result<usize, FileFault> {
        let name = format!("normal map {}", image.name());
        if let Some(i) = self.texture_of_image.get(&name) {
            return Ok(*i);
        }
        let decode = || images::decode_stored(&image.name(), &self.bytes_of(image)?);
        let texture = self.source.once(name.as_str(), decode).map(Rc::unwrap_or_clone)?;
        self.parts.textures.push(texture);
        self.texture_of_image.insert(name, self.parts.textures.len() - 1);
        Ok(self.parts.textures.len() - 1)
    }
    /// The index of an image's texture; every image is decoded once.
    pub(crate) fn image(&mut self, image: &ImageSource) -> Result<usize, FileFault> {
        if let ImageSource::Limited(own) = image {
            return self.limited_image(own, image.name());
        }
        let name = image.name();
        match self.texture_of_image.get(&name) {
            Some(i) => Ok(*i),
            None => self.add_texture(name, self.decoded(image)?),
        }
    }
    /// True if pixels of a texture were reduced to the limit of reflectances.
    pub(crate) fn is_limited(&self, texture: usize) -> bool {
        self.limited_textures.contains(&texture)
    }
    /// The texture of an image with limited pixels: that of the image itself where none exceeds the limit.
    fn limited_image(&mut self, own: &LimitedImage, name: String) -> Result<usize, FileFault> {
        if let Some(i) = self.texture_of_image.get(&name) {
            return Ok(*i);
        }
        let (mut texture, mut exceeds) = (self.decoded(&own.base)?, false);
        for pixel in &mut texture.pixels {
            exceeds |= (0..3).any(|k| pixel[k] > own.largest[k]);
            *pixel = std::array::from_fn(|k| pixel[k].min(own.largest[k]));
        }
        if !exceeds {
            let base_name = own.base.name();
            return match self.texture_of_image.get(&base_name) {
                Some(i) => Ok(*i),
                None => self.add_texture(base_name, texture),
            };
        }
        let index = self.add_texture(name, texture)?;
        self.limited_textures.insert(index);
        Ok(index)
    }
    /// Adds the texture of an image, in the bands of the scene.
    fn add_texture(&mut self, name: String, mut texture: Texture) -> Result<usize, FileFault> {
        let (bands, block) = (self.source.bands(), self.source.block());
        if !bands.is_rgb() {
            for pixel in &mut texture.pixels {
                let found = bands.from_rgb(block, pixel.map(f64::from)).ok_or_else(|| {
                    let message = "a picture in colour has no meaning in bands without wavelengths; give bands = [[from, to], …] in nm";
                    FileFault::new(&name, "", message)
                })?;
                *pixel = found.to_rgb().map(|x| x as f32);
            }
        }
        self.parts.textures.push(texture);
        self.texture_of_image.insert(name, self.parts.textures.len() - 1);
        Ok(self.parts.textures.len() - 1)
    }
}

/// The emissivities of a surface by temperature and side, out of the tables of a reader.
fn emissivity_of(tables: &[EmissivityTable], properties: &SurfaceProperties) -> SurfaceEmissivity {
    let back = properties
        .back
        .map(|b| SideEmissivity { reflectance: b.reflectance, table: b.table.map(|k| tables[k].clone()) });
    SurfaceEmissivity { table: properties.emissivity_table.map(|k| tables[k].clone()), back }
}

/// The key that a surface lacks or should not have in thermal mode, and what to do.
fn missing_key(
    surface: &Surface,
    properties: &SurfaceProperties,
    condition: ThermalCondition,
) -> Option<(&'static str, &'static str)> {
    if properties.reflectance.is_none() {
        return Some(("emissivity", "this key is missing; write emissivity = 0.9, or 1 for a black surface"));
    }
    if surface.reflectance.any(f64::is_nan) {
        return Some((
            "solar_absorptance",
            "the list for the infrared bands has no value for sunlight; write solar_absorptance = 0.3",
        ));
    }
    let is_known = matches!(condition, ThermalCondition::Temperature(_));
    if is_known && properties.node.is_none() && properties.convection.is_some() {
        return Some((
            "heat_transfer_coefficient",
            "convection does not change a given temperature; give heat_flux or a node instead of the temperature, or remove the convection",
        ));
    }
    if properties.back.is_some() && (surface.sides == Sides::Front || surface.solid) {
        return Some((
            "back",
            "the back of this surface takes no part in the exchange; write sides = \"both\", or remove back",
        ));
    }
    None
}
