//! A baked solution as a glTF model.
//!
//! Materials are unlit; a viewer shows vertex colour × texture. With c the tone curve and T the texture of a surface, scaled so that its brightest values
//! (all but 2 %) are 1, with mean m,
//!
//! ```text
//!     without texture   colour = c(exposure (E + ρ H)/π)
//!     with texture      colour = min(1, c(exposure (E + ρ_max m H)/π)/m)        shown: colour · T
//! ```
//!
//! which is exact where the texture has its mean value, and in shadows everywhere. An unlit pane cannot tint its background; it shows the colour that it has
//! before the surroundings: colour = c(exposure ((1−τ) B/π + τ L)), opacity 1 − τ̄/4, with τ the transmittance at normal incidence and L the radiance of
//! surroundings and skies.

use super::options::{ColourQuantity, GlbOptions};
use serde_json::json;
use std::collections::HashMap;
use std::f64::consts::PI;
use std::path::Path;
use zonal_io::output::glb::{GlbCamera, GlbMaterial, GlbMesh, GlbModel, UpAxis};
use zonal_io::output::{self, FileError, NamedSingleArray, ToneCurve};
use zonal_render::bake::{BakedMedium, BakedSolution};
use zonal_scene::{Bands, Light, Scene, Solution, Texture};

/// Number of radiances, distributed by area, from which the exposure is measured.
const EXPOSURE_SAMPLES: usize = 20_000;
/// Fraction of the values of a texture that may exceed its white, so that few bright texels do not darken the others.
const CLIPPED_TEXEL_FRACTION: f64 = 0.02;
/// Width over height of the cameras.
const CAMERA_ASPECT: f64 = 4.0 / 3.0;

/// Exposure and tone curve.
#[derive(Clone, Copy)]
struct ExposedTone {
    exposure: f64,
    curve: ToneCurve,
}

impl ExposedTone {
    /// The colour of a radiance.
    fn colour(&self, radiance: Bands) -> [f64; 3] {
        self.curve.colour((self.exposure * radiance).to_rgb())
    }
}

/// The model of a solution.
pub(super) fn model(s: &Solution, baked: &BakedSolution, options: &GlbOptions) -> GlbModel {
    let scene = &s.scene;
    let quantity = options.colours.unwrap_or_default();
    let exposure =
        output::auto_exposure(&radiance_samples(s, quantity)) * options.stops.unwrap_or(0.0).exp2();
    let tone = ExposedTone { exposure, curve: options.curve.unwrap_or(ToneCurve::Filmic) };
    let mut model = GlbModel { name: scene.name().into(), up: up_axis(scene), ..GlbModel::default() };
    add_surfaces(scene, baked, tone, options, &mut model);
    add_panes(scene, baked, tone, &mut model);
    model.cameras = scene.cameras().iter().map(|c| glb_camera(c, scene)).collect();
    model.extras = metadata(s, baked, options, tone);
    model
}

/// Adds the surfaces, one mesh and one material each. A texture is embedded once.
fn add_surfaces(
    scene: &Scene,
    baked: &BakedSolution,
    tone: ExposedTone,
    options: &GlbOptions,
    model: &mut GlbModel,
) {
    let quantity = options.colours.unwrap_or_default();
    let textures: Vec<Option<ScaledTexture>> = scene.textures().iter().map(ScaledTexture::new).collect();
    let mut picture_of_texture = vec![None; textures.len()];
    let mut triangles_of_surface = vec![Vec::new(); scene.surfaces().len()];
    for t in &baked.surfaces.triangles {
        triangles_of_surface[baked.surfaces.surfaces[t[0] as usize] as usize].push(*t);
    }
    for (i, surface) in scene.surfaces().iter().enumerate() {
        // Embed the texture.
        let index = surface.reflectance_texture.filter(|_| quantity == ColourQuantity::Radiosity);
        let texture = index.and_then(|t| textures[t].as_ref().map(|p| (t, p)));
        let picture = texture.map(|(t, p)| {
            *picture_of_texture[t].get_or_insert_with(|| {
                model.pictures.push(p.png.clone());
                model.pictures.len() - 1
            })
        });
        model.materials.push(GlbMaterial {
            picture,
            unlit: true,
            ..GlbMaterial::diffuse(&surface.name, [1.0; 3])
        });
        // Colour the vertices.
        let reflectance = surface.scattered_fraction();
        let shading = VertexShading { tone, quantity, reflectance, texture: texture.map(|t| t.1) };
        let mut mesh = GlbMesh { name: surface.name.clone(), material: Some(i), ..GlbMesh::default() };
        let vertices = fill_mesh(&mut mesh, baked, &triangles_of_surface[i], &shading);
        if options.light_groups {
            add_light_groups(&mut mesh, baked, &vertices);
        }
        model.meshes.push(mesh);
    }
}

/// A texture scaled to [0, 1].
pub(super) struct ScaledTexture {
    /// The file.
    pub png: Vec<u8>,
    /// The value of 1.
    pub white: Bands,
    /// Mean of the scaled values.
    mean: Bands,
}

impl ScaledTexture {
    /// `None` for a texture without texels.
    pub(super) fn new(t: &Texture) -> Option<ScaledTexture> {
        let white = [0, 1, 2].map(|b| white_level(t.pixels.iter().map(|p| p[b]).collect()));
        let scaled: Vec<[f32; 3]> =
            t.pixels.iter().map(|p| [0, 1, 2].map(|b| (p[b] / white[b]).min(1.0))).collect();
        let n = scaled.len().max(1) as f64;
        let mean = [0, 1, 2].map(|k| (scaled.iter().map(|p| p[k] as f64).sum::<f64>() / n).max(1e-3));
        let png = output::encode_png(t.width, t.height, &scaled)?;
        Some(ScaledTexture { png, white: Bands::from_rgb(white.map(f64::from)), mean: Bands::from_rgb(mean) })
    }
}

/// The quantile of values that all but [`CLIPPED_TEXEL_FRACTION`] of them do not exceed; above 0.
fn white_level(mut values: Vec<f32>) -> f32 {
    let k = ((1.0 - CLIPPED_TEXEL_FRACTION) * values.len().saturating_sub(1) as f64) as usize;
    if values.is_empty() {
        return 1.0;
    }
    values.select_nth_unstable_by(k, f32::total_cmp).1.max(1e-6)
}

/// Vertex colours of one surface.
struct VertexShading<'a> {
    tone: ExposedTone,
    quantity: ColourQuantity,
    reflectance: Bands,
    texture: Option<&'a ScaledTexture>,
}

impl VertexShading<'_> {
    fn colour(&self, h: Bands, e: Bands) -> [f32; 4] {
        let displayed = match (self.quantity, self.texture) {
            (ColourQuantity::Irradiance, _) => self.tone.colour(h / PI),
            (ColourQuantity::Radiosity, None) => self.tone.colour((e + self.reflectance * h) / PI),
            (ColourQuantity::Radiosity, Some(p)) => {
                let mean = (e + self.reflectance * p.white * p.mean * h) / PI;
                (Bands::from_rgb(self.tone.colour(mean)) / p.mean).to_rgb()
            }
        };
        let [r, g, b] = displayed.map(|x| x.min(1.0) as f32);
        [r, g, b, 1.0]
    }
}

/// Fills a mesh with the triangles of one surface; returns the indices of its vertices in the baked mesh.
fn fill_mesh(
    mesh: &mut GlbMesh,
    baked: &BakedSolution,
    triangles: &[[u32; 3]],
    shading: &VertexShading,
) -> Vec<usize> {
    let m = &baked.surfaces;
    let mut new_index = HashMap::new();
    let mut vertices = Vec::new();
    for t in triangles {
        mesh.triangles.push(t.map(|i| {
            *new_index.entry(i).or_insert_with(|| {
                vertices.push(i as usize);
                vertices.len() as u32 - 1
            })
        }));
    }
    mesh.positions = vertices.iter().map(|i| m.positions[*i]).collect();
    mesh.normals = vertices.iter().map(|i| m.normals[*i]).collect();
    if shading.texture.is_some() {
        mesh.uvs = vertices.iter().map(|i| m.uvs[*i]).collect();
    }
    let colour = |i: &usize| {
        let h = Bands::from_rgb([0, 1, 2].map(|k| m.irradiance.iter().map(|g| g[*i][k] as f64).sum()));
        shading.colour(h, Bands::from_rgb(m.emission[*i].map(f64::from)))
    };
    mesh.colours = vertices.iter().map(colour).collect();
    vertices
}

/// Adds the irradiance of each light group as a vertex attribute.
fn add_light_groups(mesh: &mut GlbMesh, baked: &BakedSolution, vertices: &[usize]) {
    for (k, group) in baked.surfaces.irradiance.iter().enumerate() {
        mesh.values.push((group_attribute(k), vertices.iter().map(|i| group[*i]).collect()));
    }
}

/// Name of the vertex attribute of a light group.
fn group_attribute(group: usize) -> String {
    format!("IRRADIANCE_{group}")
}

/// Adds the panes, one mesh each. Vertices and triangles of a pane are contiguous.
fn add_panes(scene: &Scene, baked: &BakedSolution, tone: ExposedTone, model: &mut GlbModel) {
    let m = &baked.panes;
    let exterior = exterior_radiance(scene);
    for triangles in m.triangles.chunk_by(|s, t| m.panes[s[0] as usize] == m.panes[t[0] as usize]) {
        let pane = &scene.panes()[m.panes[triangles[0][0] as usize] as usize];
        let ids = || triangles.iter().flatten().copied();
        let (first, last) = (ids().min().unwrap_or(0), ids().max().unwrap_or(0));
        let own = first as usize..=last as usize;
        let colour = |i: usize| {
            let b = Bands::from_rgb([0, 1, 2].map(|k| m.radiosity.iter().map(|g| g[i][k] as f64).sum()));
            let tau = Bands::from_rgb(m.depth[i].map(|d| (-d as f64).exp()));
            let [r, g, b] = tone.colour((1.0 - tau) * b / PI + tau * exterior);
            [r, g, b, 1.0 - tau.sum() / 12.0].map(|x| x as f32)
        };
        model.materials.push(GlbMaterial {
            unlit: true,
            double_sided: true,
            blend: true,
            ..GlbMaterial::diffuse(&pane.name, [1.0; 3])
        });
        model.meshes.push(GlbMesh {
            name: pane.name.clone(),
            material: Some(model.materials.len() - 1),
            positions: m.positions[own.clone()].to_vec(),
            normals: m.normals[own.clone()].to_vec(),
            colours: own.map(colour).collect(),
            triangles: triangles.iter().map(|t| t.map(|i| i - first)).collect(),
            ..GlbMesh::default()
        });
    }
}

/// Radiance of surroundings and skies, W/(m² sr): the mean over all directions.
pub(super) fn exterior_radiance(scene: &Scene) -> Bands {
    let skies = scene.lights().iter().filter_map(Light::sky);
    skies.fold(scene.surroundings().radiance, |sum, (radiance, d)| sum + radiance * d.mean())
}

/// Radiances of the patches, each as often as its share of the area, for the automatic exposure.
pub(super) fn radiance_samples(s: &Solution, quantity: ColourQuantity) -> Vec<[f32; 3]> {
    let patches = &s.zones.patches;
    let area: f64 = patches.iter().map(|p| p.area).sum();
    let (mut out, mut sum) = (Vec::with_capacity(EXPOSURE_SAMPLES), 0.0);
    for (i, p) in patches.iter().enumerate() {
        sum += p.area;
        let f = &s.fields;
        let light = match quantity {
            ColourQuantity::Radiosity => f.radiosity[i],
            ColourQuantity::Irradiance => f.incident[i] + f.direct_light(i),
        };
        let until = (EXPOSURE_SAMPLES as f64 * sum / area).round() as usize;
        out.resize(until.clamp(out.len(), EXPOSURE_SAMPLES), light.to_rgb().map(|x| (x / PI) as f32));
    }
    out
}

/// The up axis of most cameras; z if they are undecided.
pub(super) fn up_axis(scene: &Scene) -> UpAxis {
    let y = scene.cameras().iter().filter(|c| c.up.y.abs() > c.up.z.abs()).count();
    if 2 * y > scene.cameras().len() { UpAxis::Y } else { UpAxis::Z }
}

pub(super) fn glb_camera(c: &zonal_scene::Camera, scene: &Scene) -> GlbCamera {
    let d = scene.diagonal().max(1e-3);
    GlbCamera {
        name: c.name.clone(),
        origin: c.origin.array(),
        target: c.target.array(),
        up: c.up.array(),
        fov: c.fov,
        aspect: CAMERA_ASPECT,
        range: [1e-3 * d, 10.0 * d],
    }
}

/// Meaning and units of the numbers in the file.
fn metadata(
    s: &Solution,
    baked: &BakedSolution,
    options: &GlbOptions,
    tone: ExposedTone,
) -> serde_json::Value {
    let formula = match options.colours.unwrap_or_default() {
        ColourQuantity::Radiosity => {
            "curve(exposure * B / pi), B the radiosity in W/m2; divided by the picture's mean where there is one"
        }
        ColourQuantity::Irradiance => {
            "curve(exposure * H / pi), H the irradiance in W/m2, direct light included"
        }
    };
    let groups: Vec<serde_json::Value> = (baked.groups.iter().enumerate())
        .map(|(k, g)| {
            if options.light_groups {
                json!({ "name": g, "attribute": format!("_{}", group_attribute(k)), "unit": "W/m2" })
            } else {
                json!({ "name": g })
            }
        })
        .collect();
    json!({
        "length": "m",
        "COLOR_0": formula,
        "exposure": tone.exposure,
        "exposure unit": "m2 sr/W",
        "curve": tone.curve.name(),
        "light groups": groups,
        "zones": s.zones.len(),
        "scene hash": s.scene_hash,
    })
}

/// Writes the light of the medium as arrays [x, y, z, 3], with a first axis for the light groups.
pub(super) fn write_medium(path: &Path, groups: &[String], m: &BakedMedium) -> Result<(), FileError> {
    let metadata = json!({
        "min": m.min.array(), "cell": m.cell.array(), "dims": m.dims, "groups": groups,
        "units": { "min": "m", "cell": "m", "volume": "m3", "extinction": "1/m", "radiosity": "W/m2", "fluence": "W/m2" },
        "order": "[x, y, z, band], for radiosity and fluence [group, x, y, z, band]",
    });
    let grid = m.dims.to_vec();
    let bands = [&m.dims[..], &[3]].concat();
    let of_groups = [&[groups.len()], &bands[..]].concat();
    let arrays = [
        NamedSingleArray { name: "volume", shape: grid, values: vec![&m.volume] },
        NamedSingleArray {
            name: "extinction",
            shape: bands.clone(),
            values: vec![m.extinction.as_flattened()],
        },
        NamedSingleArray { name: "albedo", shape: bands, values: vec![m.albedo.as_flattened()] },
        NamedSingleArray {
            name: "radiosity",
            shape: of_groups.clone(),
            values: m.radiosity.iter().map(|x| x.as_flattened()).collect(),
        },
        NamedSingleArray {
            name: "fluence",
            shape: of_groups,
            values: m.fluence.iter().map(|x| x.as_flattened()).collect(),
        },
    ];
    output::write_single_arrays(path, &metadata.to_string(), &arrays)
}
