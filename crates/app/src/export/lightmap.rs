//! A solution as a glTF model with a lightmap beside it.
//!
//! The model has the facets of the scene with lit materials and two sets of texture coordinates; the lightmap T is the irradiance in W/m². A viewer shows
//!
//! ```text
//!     L = E/π + ρ T/π        W/(m² sr)
//! ```
//!
//! with E/π the emissive colour and ρ the base colour times its texture: the rule of three.js for `lightMap`, whose texture is multiplied by the diffuse
//! reflectance over π. A pane is a blended sheet of the radiance ((1−τ) B/π + τ L), with L that of surroundings and skies, and the opacity 1 − τ̄/4.

use super::gltf::{ScaledTexture, exterior_radiance, glb_camera, radiance_samples, up_axis};
use super::options::{ColourQuantity, ExportOptions, LightmapSettings};
use serde_json::{Map, Value, json};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use zonal_io::output;
use zonal_io::output::glb::{GlbMaterial, GlbMesh, GlbModel};
use zonal_render::bake::lightmap::{AtlasTooSmall, Lightmap, LightmapMesh, LightmapOptions, bake_lightmap};
use zonal_report::{Failure, check_output};
use zonal_scene::{Bands, Progress, Scene, Solution};

/// Largest width and height of a lightmap whose texels are given, unless another is.
const DEFAULT_SIDE_WITH_TEXEL: usize = 8192;

/// The lightmap's file, and its sizes by name.
pub(super) struct WrittenLightmap {
    pub picture: PathBuf,
    pub sizes: Map<String, Value>,
}

/// Bakes and writes the model and its lightmap.
///
/// # Errors
/// For emissions by face, an atlas that is too small, and files that cannot be written.
pub(super) fn write(
    options: &ExportOptions,
    settings: &LightmapSettings,
    s: &Solution,
    progress: &dyn Progress,
) -> Result<WrittenLightmap, Failure> {
    let picture = options.output.with_extension("lightmap.exr");
    check_output(&picture, &["exr"])?;
    if s.scene.faces().values.iter().any(|v| v.emission.is_some()) {
        let message = "this solution has emissions by face, and the materials of a lightmap have one for each surface; leave out --lightmap";
        return Err(Failure::in_file(&options.source, message));
    }
    let defaults = LightmapOptions::default();
    let side = settings.texel.map_or(defaults.max_side, |_| DEFAULT_SIDE_WITH_TEXEL);
    let max_side = settings.atlas.unwrap_or(side);
    let baking = LightmapOptions { texel: settings.texel, max_side, ..defaults };
    let map = bake_lightmap(s, &baking, progress).map_err(|e| too_small(&e))?;
    output::write_exr(&picture, map.width, map.height, &map.irradiance)?;
    output::write_glb(&options.output, &model(s, &map, &picture, options.glb.stops.unwrap_or(0.0)))?;
    let sizes = [
        ("charts", json!(map.charts)),
        ("texel", json!(map.texel)),
        ("triangles", json!(map.mesh.triangles.len())),
        ("width", json!(map.width)),
        ("height", json!(map.height)),
    ];
    Ok(WrittenLightmap { picture, sizes: sizes.map(|(k, v)| (k.to_string(), v)).into_iter().collect() })
}

fn too_small(e: &AtlasTooSmall) -> Failure {
    Failure::new(format!(
        "--atlas: the {} charts of the surfaces take {:.3e} texels with their margins and do not fit into {side} x {side}; give a larger --atlas (up to 16384) or a larger --texel",
        e.charts,
        e.texels,
        side = e.max_side
    ))
}

/// The model.
fn model(s: &Solution, map: &Lightmap, picture: &Path, stops: f64) -> GlbModel {
    let scene = &s.scene;
    let mut model = GlbModel { name: scene.name().into(), up: up_axis(scene), ..GlbModel::default() };
    add_materials(scene, &mut model);
    for surface in 0..scene.surfaces().len() {
        model.meshes.push(mesh_of_surface(scene, &map.mesh, surface));
    }
    add_panes(s, &mut model);
    model.cameras = scene.cameras().iter().map(|c| glb_camera(c, scene)).collect();
    model.extras = metadata(s, map, picture, stops);
    model
}

/// Adds one lit material for each surface, and its textures.
fn add_materials(scene: &Scene, model: &mut GlbModel) {
    let scaled: Vec<Option<ScaledTexture>> = scene.textures().iter().map(ScaledTexture::new).collect();
    let mut picture_of_texture = vec![None; scaled.len()];
    let mut embed = |texture: Option<usize>| {
        let (t, p) = texture.and_then(|t| scaled[t].as_ref().map(|p| (t, p)))?;
        let picture = *picture_of_texture[t].get_or_insert_with(|| {
            model.pictures.push(p.png.clone());
            model.pictures.len() - 1
        });
        Some((picture, p.white))
    };
    let single = |x: Bands| x.to_rgb().map(|x| x as f32);
    for surface in scene.surfaces() {
        let (reflecting, emitting) = (embed(surface.reflectance_texture), embed(surface.emission_texture));
        let reflectance = surface.scattered_fraction() * reflecting.map_or(Bands::ONE, |t| t.1);
        let colour = single(reflectance.map(|x| x.clamp(0.0, 1.0)));
        model.materials.push(GlbMaterial {
            picture: reflecting.map(|t| t.0),
            emissive: single(surface.emission * emitting.map_or(Bands::ONE, |t| t.1) / PI),
            emissive_picture: emitting.map(|t| t.0),
            ..GlbMaterial::diffuse(&surface.name, colour)
        });
    }
}

/// The facets of one surface.
fn mesh_of_surface(scene: &Scene, m: &LightmapMesh, surface: usize) -> GlbMesh {
    // The vertices of a triangle are its own facet's, in the order of the mesh.
    let own: Vec<usize> = (0..m.positions.len()).filter(|i| m.surfaces[*i] as usize == surface).collect();
    let new_index = |i: u32| own.binary_search(&(i as usize)).map_or(0, |k| k as u32);
    let mine = |t: &&[u32; 3]| m.surfaces[t[0] as usize] as usize == surface;
    GlbMesh {
        name: scene.surfaces()[surface].name.clone(),
        material: Some(surface),
        positions: own.iter().map(|i| m.positions[*i]).collect(),
        normals: own.iter().map(|i| m.normals[*i]).collect(),
        uvs: own.iter().map(|i| m.uvs[*i]).collect(),
        lightmap_uvs: own.iter().map(|i| m.lightmap_uvs[*i]).collect(),
        triangles: m.triangles.iter().filter(mine).map(|t| t.map(new_index)).collect(),
        ..GlbMesh::default()
    }
}

/// Adds the panes, one mesh and material each, in the mean colour of their pieces.
fn add_panes(s: &Solution, model: &mut GlbModel) {
    let (zones, exterior) = (&s.zones, exterior_radiance(&s.scene));
    for (k, pane) in s.scene.panes().iter().enumerate() {
        let pieces = || zones.panes.iter().enumerate().filter(move |(_, z)| z.pane == k);
        let area: f64 = pieces().map(|(_, z)| z.area).sum();
        let radiosity =
            pieces().map(|(i, z)| s.fields.radiosity[zones.pane_offset() + i] * z.area).sum::<Bands>();
        let tau = (-pane.extinction * pane.thickness).exp();
        let radiance = (1.0 - tau) * radiosity / (PI * area.max(f64::MIN_POSITIVE)) + tau * exterior;
        let material = GlbMaterial::diffuse(&pane.name, [0.0; 3]);
        let [r, g, b, _] = material.colour;
        model.materials.push(GlbMaterial {
            colour: [r, g, b, (1.0 - tau.sum() / 12.0) as f32],
            emissive: radiance.to_rgb().map(|x| x.max(0.0) as f32),
            double_sided: true,
            blend: true,
            ..material
        });
        let mut mesh = GlbMesh {
            name: pane.name.clone(),
            material: Some(model.materials.len() - 1),
            ..GlbMesh::default()
        };
        for plate in &pane.plates {
            let (corners, n) = plate.corners();
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(corners[..n].iter().map(|p| p.array().map(|x| x as f32)));
            mesh.normals.extend(std::iter::repeat_n(plate.normal().array().map(|x| x as f32), n));
            mesh.triangles.extend((2..n as u32).map(|k| [0, k - 1, k].map(|i| first + i)));
        }
        model.meshes.push(mesh);
    }
}

/// Meaning and units of the numbers in the files.
fn metadata(s: &Solution, map: &Lightmap, picture: &Path, stops: f64) -> Value {
    let exposure = output::auto_exposure(&radiance_samples(s, ColourQuantity::Radiosity)) * stops.exp2();
    let patches = &s.zones.patches;
    let area: f64 = patches.iter().map(|p| p.area).sum();
    let error = |i: usize| s.fields.total_error(i);
    let square: Bands = patches.iter().enumerate().map(|(i, p)| error(i) * error(i) * p.area).sum();
    let rms = (square / area.max(f64::MIN_POSITIVE)).map(f64::sqrt).to_rgb();
    let largest = (0..patches.len()).fold(Bands::ZERO, |m, i| m.max(error(i))).to_rgb();
    json!({
        "length": "m",
        "lightmap": {
            "file": picture.file_name().map(|n| n.to_string_lossy()),
            "quantity": "irradiance T, direct light included; linear",
            "unit": "W/m2",
            "texture coordinates": 1,
            "first row": "v = 0",
            "shown radiance": "emissive + base colour * T / pi, W/(m2 sr)",
            "width": map.width,
            "height": map.height,
            "texel": map.texel,
            "charts": map.charts,
            "estimated error of the irradiance of zones, W/m2": { "rms": rms, "largest": largest },
        },
        "emissive": "E / pi, W/(m2 sr)",
        "exposure": exposure,
        "exposure unit": "m2 sr/W",
        "zones": s.zones.len(),
        "scene hash": s.scene_hash,
    })
}
