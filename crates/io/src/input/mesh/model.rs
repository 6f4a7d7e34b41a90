//! A mesh as its file gives it: faces with materials, in the file's unit and axes.

use crate::input::images::AlphaChannel;
use std::path::PathBuf;
use std::rc::Rc;
use zonal_math::Vec3;
use zonal_scene::{Bands, Camera, CornerNormals, Plate, PlateKind};

/// A mesh file as read.
#[derive(Clone, Default)]
pub(crate) struct MeshData {
    pub(crate) materials: Vec<MeshMaterial>,
    pub(crate) faces: Vec<MeshFace>,
    /// Corner normals of faces that stand for curved surfaces, of any length.
    pub(crate) normals: Vec<CornerNormals>,
    /// Number of polygons of the file.
    pub(crate) face_count: usize,
    /// The cameras of the file.
    pub(crate) cameras: Vec<Camera>,
    /// Lights of the file.
    pub(crate) lights: Vec<MeshLight>,
    /// Repairs and ignored contents.
    pub(crate) notes: Vec<String>,
}

/// A plate with its material.
#[derive(Clone, Copy)]
pub(crate) struct MeshFace {
    pub(crate) material: usize,
    pub(crate) plate: Plate,
    pub(crate) uv: [[f64; 2]; 3],
    /// Factor by which the face's node scales lengths.
    pub(crate) scale: f64,
    /// Index of its polygon in the file.
    pub(crate) face: usize,
    /// Index of its normals in the mesh; `None` of a flat face.
    pub(crate) normals: Option<u32>,
}

impl MeshFace {
    /// A face of a polygon of the file, without geometry yet, at a node that does not scale.
    pub(crate) fn template(material: usize, face: usize) -> MeshFace {
        let plate = Plate::triangle(Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
        MeshFace { material, plate, uv: [[0.0; 2]; 3], scale: 1.0, face, normals: None }
    }

    /// The unit normal at parameters of the plate between the normals of its corners.
    pub(crate) fn interpolated_normal(&self, corners: &CornerNormals, [u, v]: [f64; 2]) -> Vec3 {
        let weights = match self.plate.kind {
            PlateKind::Triangle => [1.0 - u - v, u, v, 0.0],
            PlateKind::Parallelogram => [(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v],
        };
        let of = |(n, w): (&[f32; 3], f64)| Vec3::from_array(n.map(f64::from)) * w;
        corners.iter().zip(weights).map(of).fold(Vec3::ZERO, |a, b| a + b).normalized()
    }
}

/// A light of a mesh file.
#[derive(Clone, Debug)]
pub(crate) struct MeshLight {
    pub(crate) name: String,
    pub(crate) position: Vec3,
    /// The way along which it shines, of any length.
    pub(crate) direction: Vec3,
    /// Luminous intensity, cd, or illuminance of a directional light, lx.
    pub(crate) intensity: Bands,
    pub(crate) kind: MeshLightKind,
}

/// The kind of a light of a mesh file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum MeshLightKind {
    Directional,
    Point,
    /// Inner and outer half-angle, radians.
    Spot([f64; 2]),
}

/// An image; it is decoded only if it is used.
#[derive(Clone)]
pub(crate) enum ImageSource {
    File(PathBuf),
    Bytes {
        name: String,
        bytes: Rc<[u8]>,
    },
    /// A picture, white without one, times a weight by another picture.
    Weighted(Rc<WeightedImage>),
    /// A picture whose pixels are at most a limit.
    Limited(Rc<LimitedImage>),
}

/// A picture and the largest value of its pixels by channel.
pub(crate) struct LimitedImage {
    pub(crate) base: ImageSource,
    pub(crate) largest: [f32; 3],
}

/// A picture times w or 1 − w, w = factor × a channel of another picture.
pub(crate) struct WeightedImage {
    pub(crate) base: Option<ImageSource>,
    pub(crate) weight: ImageSource,
    pub(crate) channel: AlphaChannel,
    pub(crate) factor: f64,
    /// True for 1 − w.
    pub(crate) complement: bool,
}

impl ImageSource {
    /// Name of the image, for messages.
    pub(crate) fn name(&self) -> String {
        match self {
            ImageSource::File(path) => path.display().to_string(),
            ImageSource::Bytes { name, .. } => name.clone(),
            ImageSource::Weighted(w) => {
                let base = w.base.as_ref().map_or(String::new(), ImageSource::name);
                format!("{base}*{}*{}{}{:?}", w.weight.name(), w.factor, w.complement, w.channel)
            }
            ImageSource::Limited(own) => format!("{}<{:?}", own.base.name(), own.largest),
        }
    }
}

/// Alpha that varies over a material, or cuts it out.
#[derive(Clone)]
pub(crate) struct AlphaSource {
    /// The image; without one alpha is the factor.
    pub(crate) image: Option<ImageSource>,
    pub(crate) channel: AlphaChannel,
    /// Multiplies the alpha of the image.
    pub(crate) factor: f64,
    pub(crate) rule: AlphaRule,
}

/// Effect of alpha.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum AlphaRule {
    /// Opaque where alpha is at least the cutoff, nothing elsewhere.
    Mask { cutoff: f64 },
    /// The fraction 1 − alpha of light passes.
    Blend,
}

/// A material of a mesh file.
#[derive(Clone)]
pub(crate) struct MeshMaterial {
    pub(crate) name: String,
    /// None if the file gives none.
    pub(crate) reflectance: Option<Bands>,
    pub(crate) texture: Option<ImageSource>,
    /// True if the file's reflectance is above the limit, and was reduced to it.
    pub(crate) is_limited: bool,
    /// W/m².
    pub(crate) emission: Bands,
    pub(crate) emission_texture: Option<ImageSource>,
    /// Diffuse transmittance of a sheet, and its texture.
    pub(crate) transmittance: Option<(Bands, Option<ImageSource>)>,
    /// glTF's doubleSided; none for OBJ.
    pub(crate) double_sided: Option<bool>,
    pub(crate) glass: Option<GlassProperties>,
    /// Warning if the material is used without a reflectance from the scene: its file has none.
    pub(crate) missing_warning: Option<String>,
    /// Warning if the material is an opaque surface: transparency that is not read.
    pub(crate) opaque_warning: Option<String>,
    /// Normal map, and the factor of its components along the surface.
    pub(crate) normal_map: Option<(ImageSource, f64)>,
    /// Alpha that varies, or cuts the material out.
    pub(crate) alpha: Option<AlphaSource>,
}

impl MeshMaterial {
    /// True of a pane, unless the scene says otherwise; the glass of a sheet that transmits diffusely serves a pane of the scene.
    pub(crate) fn is_glass(&self) -> bool {
        self.glass.is_some() && self.transmittance.is_none()
    }
    /// A material with a name and nothing else.
    pub(crate) fn named(name: &str) -> MeshMaterial {
        MeshMaterial {
            name: name.to_string(),
            reflectance: None,
            texture: None,
            is_limited: false,
            emission: Bands::ZERO,
            emission_texture: None,
            transmittance: None,
            double_sided: None,
            glass: None,
            missing_warning: None,
            opaque_warning: None,
            normal_map: None,
            alpha: None,
        }
    }
}

/// Smallest transmittance of a material; it keeps the extinction finite.
pub(crate) const MIN_TRANSMITTANCE: f64 = 1e-6;

/// A transmitting material.
#[derive(Clone, Copy)]
pub(crate) struct GlassProperties {
    /// In the unit of the node that shows it.
    pub(crate) thickness: Option<f64>,
    pub(crate) attenuation: GlassAttenuation,
    pub(crate) albedo: Bands,
}

/// Attenuation of a glass.
#[derive(Clone, Copy)]
pub(crate) enum GlassAttenuation {
    /// Extinction coefficient κ, in 1/(unit of the file).
    Coefficient(Bands),
    /// Transmittance of the whole thickness.
    Transmittance(Bands),
}
