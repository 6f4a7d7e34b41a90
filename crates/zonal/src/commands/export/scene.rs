//! A baked solution as a glTF model.
//!
//! Materials are unlit: what is seen is colour × picture. With x the exposed radiance, c the tone curve and T a surface's picture, scaled
//! so that its brightest values (all but 2 %) are 1, with mean m,
//!
//! ```text
//!     without picture   colour = c(exposure (E + ρ H)/π)
//!     with one          colour = min(1, c(exposure (E + ρ_max m H)/π)/m)        seen: colour · T
//! ```
//!
//! which is right where the picture has its mean colour, and in the shadows everywhere. A pane, which cannot tint what is behind it without
//! lights, is seen as before the surroundings: colour = c(exposure ((1−τ) B/π + τ L)), opacity 1 − τ̄/4, with τ square to it and L
//! the radiance of surroundings and skies.

use super::{Bake, Colours};
use serde_json::json;
use std::f64::consts::PI;
use std::path::Path;
use zonal_io::output::glb::{Material, Mesh, Model, Up, View};
use zonal_io::output::{self, Curve, FileError, NamedSingle};
use zonal_render::bake::{Baked, BakedMedium};
use zonal_scene::{Bands, Light, Scene, Solution, Texture, bands};

/// Places along the surface at which the exposure is measured.
const PROBES: usize = 20_000;
/// Share of a picture's values that may be brighter than its white: a few sparks must not darken all the rest, whose light then has no room.
const CLIPPED: f64 = 0.02;
/// Width over height of the cameras' pictures.
const ASPECT: f64 = 4.0 / 3.0;

/// How light becomes colour.
#[derive(Clone, Copy)]
struct Tone {
    exposure: f64,
    curve: Curve,
}

impl Tone {
    fn of(&self, radiance: Bands) -> Bands {
        self.curve.colour(radiance.map(|l| self.exposure * l))
    }
}

/// The model of a solution.
pub(super) fn model(s: &Solution, baked: &Baked, options: &Bake) -> Model {
    let scene = &s.scene;
    let what = options.colours.unwrap_or_default();
    let exposure = output::auto_exposure(&probes(s, what)) * options.stops.unwrap_or(0.0).exp2();
    let tone = Tone { exposure, curve: options.curve.unwrap_or_default().into() };
    let mut model = Model { name: scene.name().into(), up: up(scene), ..Model::default() };
    let pictures: Vec<Option<Picture>> = scene.textures().iter().map(Picture::new).collect();
    let mut used = vec![None; pictures.len()];
    let mut of_surface = vec![Vec::new(); scene.surfaces().len()];
    for t in &baked.surfaces.triangles {
        of_surface[baked.surfaces.surfaces[t[0] as usize] as usize].push(*t);
    }
    for (i, surface) in scene.surfaces().iter().enumerate() {
        let texture = surface.reflectance_texture.filter(|_| what == Colours::Radiosity);
        let picture = texture.and_then(|t| pictures[t].as_ref().map(|p| (t, p)));
        let picture = picture.map(|(t, p)| {
            let index = *used[t].get_or_insert_with(|| {
                model.pictures.push(p.png.clone());
                model.pictures.len() - 1
            });
            (index, p)
        });
        model.materials.push(Material {
            picture: picture.map(|p| p.0),
            unlit: true,
            ..Material::diffuse(&surface.name, [1.0; 3])
        });
        let shade = Shade { tone, what, reflectance: surface.reflectance, picture: picture.map(|p| p.1) };
        model.meshes.push(Mesh { name: surface.name.clone(), material: Some(i), ..Mesh::default() });
        let triangles = std::mem::take(&mut of_surface[i]);
        fill(model.meshes.last_mut().expect("just pushed"), baked, &triangles, &shade, options.light_groups);
    }
    panes(scene, baked, tone, &mut model);
    model.cameras = scene.cameras().iter().map(|c| view(c, scene)).collect();
    model.extras = about(s, baked, options, tone);
    model
}

/// A texture from 0 to 1 as PNG, the factor that brings it back, and its mean.
struct Picture {
    png: Vec<u8>,
    most: Bands,
    mean: Bands,
}

impl Picture {
    fn new(t: &Texture) -> Option<Picture> {
        let most = [0, 1, 2].map(|b| highest(t.pixels.iter().map(|p| p[b]).collect()));
        let scaled: Vec<[f32; 3]> =
            t.pixels.iter().map(|p| [0, 1, 2].map(|b| (p[b] / most[b]).min(1.0))).collect();
        let n = scaled.len().max(1) as f64;
        let mean = bands(|b| (scaled.iter().map(|p| p[b] as f64).sum::<f64>() / n).max(1e-3));
        let png = output::encode_png(t.width, t.height, &scaled)?;
        Some(Picture { png, most: most.map(f64::from), mean })
    }
}

/// What all but [`CLIPPED`] of the values do not exceed; above 0.
fn highest(mut values: Vec<f32>) -> f32 {
    let k = ((1.0 - CLIPPED) * values.len().saturating_sub(1) as f64) as usize;
    if values.is_empty() {
        return 1.0;
    }
    values.select_nth_unstable_by(k, f32::total_cmp).1.max(1e-6)
}

/// How the vertices of one surface are coloured.
struct Shade<'a> {
    tone: Tone,
    what: Colours,
    reflectance: Bands,
    picture: Option<&'a Picture>,
}

impl Shade<'_> {
    fn colour(&self, h: Bands, e: Bands) -> [f32; 4] {
        let seen = match (self.what, self.picture) {
            (Colours::Irradiance, _) => self.tone.of(h.map(|h| h / PI)),
            (Colours::Radiosity, None) => self.tone.of(bands(|b| (e[b] + self.reflectance[b] * h[b]) / PI)),
            (Colours::Radiosity, Some(p)) => {
                let mean = bands(|b| (e[b] + self.reflectance[b] * p.most[b] * p.mean[b] * h[b]) / PI);
                let seen = self.tone.of(mean);
                bands(|b| seen[b] / p.mean[b])
            }
        };
        let [r, g, b] = seen.map(|x| x.min(1.0) as f32);
        [r, g, b, 1.0]
    }
}

/// Gives a mesh the triangles of one surface.
fn fill(mesh: &mut Mesh, baked: &Baked, triangles: &[[u32; 3]], shade: &Shade, groups: bool) {
    let m = &baked.surfaces;
    let mut numbers = std::collections::HashMap::new();
    let mut own = Vec::new();
    for t in triangles {
        mesh.triangles.push(t.map(|i| {
            *numbers.entry(i).or_insert_with(|| {
                own.push(i as usize);
                own.len() as u32 - 1
            })
        }));
    }
    mesh.positions = own.iter().map(|i| m.positions[*i]).collect();
    mesh.normals = own.iter().map(|i| m.normals[*i]).collect();
    if shade.picture.is_some() {
        mesh.uvs = own.iter().map(|i| m.uvs[*i]).collect();
    }
    let colour = |i: &usize| {
        let h = bands(|b| m.irradiance.iter().map(|g| g[*i][b] as f64).sum());
        shade.colour(h, m.emission[*i].map(f64::from))
    };
    mesh.colours = own.iter().map(colour).collect();
    if groups {
        let values = |(k, g): (usize, &Vec<[f32; 3]>)| (attribute(k), own.iter().map(|i| g[*i]).collect());
        mesh.values = m.irradiance.iter().enumerate().map(values).collect();
    }
}

fn attribute(group: usize) -> String {
    format!("IRRADIANCE_{group}")
}

/// The panes, one mesh each. The vertices and triangles of a pane follow each other.
fn panes(scene: &Scene, baked: &Baked, tone: Tone, model: &mut Model) {
    let m = &baked.panes;
    let beyond = beyond(scene);
    for triangles in m.triangles.chunk_by(|s, t| m.panes[s[0] as usize] == m.panes[t[0] as usize]) {
        let pane = &scene.panes()[m.panes[triangles[0][0] as usize] as usize];
        let ids = || triangles.iter().flatten().copied();
        let (first, last) = (ids().min().unwrap_or(0), ids().max().unwrap_or(0));
        let own = first as usize..=last as usize;
        let colour = |i: usize| {
            let b: Bands = bands(|k| m.radiosity.iter().map(|g| g[i][k] as f64).sum());
            let tau = m.depth[i].map(|d| (-d as f64).exp());
            let [r, g, b] = tone.of(bands(|k| (1.0 - tau[k]) * b[k] / PI + tau[k] * beyond[k]));
            [r, g, b, 1.0 - tau.iter().sum::<f64>() / 12.0].map(|x| x as f32)
        };
        model.materials.push(Material {
            unlit: true,
            double_sided: true,
            blend: true,
            ..Material::diffuse(&pane.name, [1.0; 3])
        });
        model.meshes.push(Mesh {
            name: pane.name.clone(),
            material: Some(model.materials.len() - 1),
            positions: m.positions[own.clone()].to_vec(),
            normals: m.normals[own.clone()].to_vec(),
            colours: own.map(colour).collect(),
            triangles: triangles.iter().map(|t| t.map(|i| i - first)).collect(),
            ..Mesh::default()
        });
    }
}

/// Radiance of surroundings and skies, W/(m² sr).
fn beyond(scene: &Scene) -> Bands {
    scene.lights().iter().fold(scene.surroundings().radiance, |sum, l| match l {
        Light::Sky { radiance, .. } => bands(|b| sum[b] + radiance[b]),
        _ => sum,
    })
}

/// Radiances of patches, evenly by area, from which the exposure is found.
fn probes(s: &Solution, what: Colours) -> Vec<[f32; 3]> {
    let patches = &s.zones.patches;
    let area: f64 = patches.iter().map(|p| p.area).sum();
    let (mut out, mut sum) = (Vec::with_capacity(PROBES), 0.0);
    for (i, p) in patches.iter().enumerate() {
        sum += p.area;
        let f = &s.fields;
        let light = match what {
            Colours::Radiosity => f.radiosity[i],
            Colours::Irradiance => bands(|b| f.incident[i][b] + f.direct[i][b]),
        };
        let until = (PROBES as f64 * sum / area).round() as usize;
        out.resize(until.clamp(out.len(), PROBES), light.map(|x| (x / PI) as f32));
    }
    out
}

/// z, unless the cameras say y.
fn up(scene: &Scene) -> Up {
    let y = scene.cameras().iter().filter(|c| c.up.y.abs() > c.up.z.abs()).count();
    if 2 * y > scene.cameras().len() { Up::Y } else { Up::Z }
}

fn view(c: &zonal_scene::Camera, scene: &Scene) -> View {
    let d = scene.diagonal().max(1e-3);
    View {
        name: c.name.clone(),
        origin: c.origin.array(),
        target: c.target.array(),
        up: c.up.array(),
        fov: c.fov,
        aspect: ASPECT,
        range: [1e-3 * d, 10.0 * d],
    }
}

/// What the numbers of the file mean.
fn about(s: &Solution, baked: &Baked, options: &Bake, tone: Tone) -> serde_json::Value {
    let what = match options.colours.unwrap_or_default() {
        Colours::Radiosity => {
            "curve(exposure * B / pi), B the radiosity in W/m2; divided by the picture's mean where there is one"
        }
        Colours::Irradiance => "curve(exposure * H / pi), H the irradiance in W/m2, direct light included",
    };
    let groups: Vec<serde_json::Value> = (baked.groups.iter().enumerate())
        .map(|(k, g)| match options.light_groups {
            true => json!({ "name": g, "attribute": format!("_{}", attribute(k)), "unit": "W/m2" }),
            false => json!({ "name": g }),
        })
        .collect();
    json!({
        "length": "m",
        "COLOR_0": what,
        "exposure": tone.exposure,
        "exposure unit": "m2 sr/W",
        "curve": tone.curve.word(),
        "light groups": groups,
        "zones": s.zones.len(),
        "scene hash": s.scene_hash,
    })
}

/// Writes the light of the medium: arrays [x, y, z, 3], one more axis in front for the groups.
pub(super) fn write_medium(path: &Path, groups: &[String], m: &BakedMedium) -> Result<(), FileError> {
    let about = json!({
        "min": m.min.array(), "cell": m.cell.array(), "dims": m.dims, "groups": groups,
        "units": { "min": "m", "cell": "m", "volume": "m3", "extinction": "1/m", "radiosity": "W/m2", "fluence": "W/m2" },
        "order": "[x, y, z, band], for radiosity and fluence [group, x, y, z, band]",
    });
    let grid = m.dims.to_vec();
    let bands = [&m.dims[..], &[3]].concat();
    let of_groups = [&[groups.len()], &bands[..]].concat();
    let arrays = [
        NamedSingle { name: "volume", shape: grid, values: vec![&m.volume] },
        NamedSingle { name: "extinction", shape: bands.clone(), values: vec![m.extinction.as_flattened()] },
        NamedSingle { name: "albedo", shape: bands, values: vec![m.albedo.as_flattened()] },
        NamedSingle {
            name: "radiosity",
            shape: of_groups.clone(),
            values: m.radiosity.iter().map(|x| x.as_flattened()).collect(),
        },
        NamedSingle {
            name: "fluence",
            shape: of_groups,
            values: m.fluence.iter().map(|x| x.as_flattened()).collect(),
        },
    ];
    output::write_single_arrays(path, &about.to_string(), &arrays)
}
