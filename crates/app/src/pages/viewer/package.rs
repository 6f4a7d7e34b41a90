//! The data of the page, from a solution.
//!
//! Positions are relative to `origin`, the centre of the scene, so that 32-bit floats suffice far from zero. Light is stored by light group: the page draws
//! Σ_g f_g (E_g + ρ H_g) with its own factors f_g. Fields on the mesh, the panes and the medium are 16-bit floats times a scale; values of zones for the probe
//! are 32-bit floats. Units of the header: m, 1/m, W/m², W/(m² sr).
//!
//! | arrays | per | contents |
//! |---|---|---|
//! | `position`, `uv`, `surface`, `indirectG`, `directG`, `error` | vertex | mesh of the patches; indirect and direct irradiance of group G |
//! | `curve` | vertex | unit normal of a curved surface and its height above the facet, m; zero on flat facets; absent without vertex normals |
//! | `index`, `triangleZone` | triangle | corners; patch zone |
//! | `zoneIndirectG`, `zoneDirectG`, `zoneError`, `zoneReflectance`, `zoneEmission`, `zoneSurface` | patch | values of the solution |
//! | `panePosition`, `paneNormal`, `paneOf`, `paneG`, `paneIndex` | vertex, triangle | panes with their radiosity |
//! | `extinction`, `albedo`, `volumeG` | point of the medium | extinction and scattering albedo if they vary; radiosity |
//! | `sunDepthK` | node of the medium | optical depth towards sun K |
//! | `textureN` | | PNG |
//!
//! The direct light of suns is in none of these fields but `paneG` and `zoneDirectG`: the page draws it with a shadow map, by the direction, irradiance and
//! optical depth of each sun in `suns` of the header. Wide suns and suns of scenes with symmetry planes are part of `directG` and `volumeG`.

use super::notes::{ShownStage, notes};
use super::pack::{Pack, scale_of};
use rayon::prelude::*;
use serde_json::{Value, json};
use zonal_io::output::encode_texture_png;
use zonal_math::Vec3;
use zonal_render::bake::volume_grid::{VolumeGrid, VolumeGridOptions, bake_volume_grid};
use zonal_render::bake::{
    BakeOptions, BakedSolution, BakedSun, PaneMesh, SunDepths, SunlightMode, SurfaceMesh, bake_in_steps,
};
use zonal_report::Failure;
use zonal_scene::{Bands, ErrorEstimate, LightGroup, LightGroupKind, Progress, SidedFacet, Solution};

/// Largest side of a texture, pixels; larger ones are halved.
const MAX_TEXTURE_SIDE: usize = 2048;

/// Effort of compression of data for a file or a solution that is there, and of those that a page on the same machine waits for.
const FILE_EFFORT: u32 = 5;
const LIVE_EFFORT: u32 = 1;

/// Diagonal of the scene over the smallest edge that is halved.
const DIAGONAL_OVER_MIN_EDGE: f64 = 3000.0;
/// Relative tolerance of linear interpolation of direct light within a triangle.
const BAKE_TOLERANCE: f64 = 0.02;

/// Resolution of the baked light, and the place of the solution in a series.
#[derive(Clone, Debug, PartialEq)]
pub struct PackageDetail {
    /// Largest number of vertices on patches.
    pub max_vertices: usize,
    /// The place of the solution.
    pub stage: ShownStage,
    /// Error estimates of the earlier solutions of the series, the first one first.
    pub earlier: Vec<ErrorEstimate>,
}

impl Default for PackageDetail {
    fn default() -> Self {
        PackageDetail { max_vertices: 400_000, stage: ShownStage::Only, earlier: Vec::new() }
    }
}

/// Bakes a solution into a compressed data file.
///
/// # Errors
/// If the scene has more than 65,536 surfaces or panes, or a texture without pixels.
pub fn package(s: &Solution, detail: &PackageDetail, progress: &dyn Progress) -> Result<Vec<u8>, Failure> {
    let mut last = Vec::new();
    package_in_steps(s, detail, &encode_textures(s)?, &[], progress, |bytes| {
        last = bytes;
        Ok(())
    })?;
    Ok(last)
}

/// The textures of a solution as PNG, which solutions of the same scene share.
///
/// # Errors
/// If a texture has no pixels.
pub fn encode_textures(s: &Solution) -> Result<Vec<Vec<u8>>, Failure> {
    let encode =
        |t| encode_texture_png(t, MAX_TEXTURE_SIDE).ok_or_else(|| Failure::new("a texture has no pixels"));
    s.scene.textures().par_iter().map(encode).collect()
}

/// Bakes a solution with `textures` ([`encode_textures`]) into data files on finer and finer meshes: with about as many vertices as each of `steps` allows, and last with all
/// ([`bake_in_steps`]). `publish` gets each file.
///
/// # Errors
/// If the scene has more than 65,536 surfaces or panes, and those of `publish`.
pub fn package_in_steps(
    s: &Solution,
    detail: &PackageDetail,
    textures: &[Vec<u8>],
    steps: &[usize],
    progress: &dyn Progress,
    mut publish: impl FnMut(Vec<u8>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let too_many =
        |parts: &str| Failure::new(format!("the viewer shows at most 65,536 {parts}; join some of them"));
    if s.scene.surfaces().len() > 1 << 16 {
        return Err(too_many("surfaces"));
    }
    if s.scene.panes().len() > 1 << 16 {
        return Err(too_many("panes"));
    }
    let options = BakeOptions {
        max_vertices: detail.max_vertices,
        tolerance: BAKE_TOLERANCE,
        min_edge: Some(s.scene.diagonal() / DIAGONAL_OVER_MIN_EDGE),
        sunlight: SunlightMode::Separate,
        ..BakeOptions::default()
    };
    let volume = VolumeGridOptions { sunlight: SunlightMode::Separate, ..VolumeGridOptions::default() };
    let medium = bake_volume_grid(s, &volume, progress);
    bake_in_steps(s, &options, steps, progress, |baked, _| {
        publish(pack(s, detail, textures, &baked, medium.as_ref())?)
    })
}

/// The compressed data file of a solution.
fn pack(
    s: &Solution,
    detail: &PackageDetail,
    textures: &[Vec<u8>],
    baked: &BakedSolution,
    medium: Option<&VolumeGrid>,
) -> Result<Vec<u8>, Failure> {
    let (low, high) = s.scene.bounds();
    let origin = (low + high) * 0.5;
    let mut pack = Pack::default();
    let mut scales = vec![json!({}); baked.groups.len()];
    add_header(&mut pack, s, baked, detail, origin);
    add_mesh(&mut pack, &baked.surfaces, origin, &mut scales);
    add_curves(&mut pack, &baked.surfaces, s);
    add_zones(&mut pack, s);
    add_panes(&mut pack, s, &baked.panes, origin, &mut scales);
    add_volume(&mut pack, medium, origin, &mut scales);
    add_suns(&mut pack, &baked.suns);
    pack.set("groups", light_groups(s, baked, &scales));
    for (i, png) in textures.iter().enumerate() {
        pack.u8(&format!("texture{i}"), png);
    }
    let effort = if detail.stage == ShownStage::Only { FILE_EFFORT } else { LIVE_EFFORT };
    pack.finish(effort).map_err(|e| Failure::new(format!("the solution cannot be packed ({e})")))
}

fn array(v: Vec3) -> Value {
    json!(v.array())
}

/// Names, counts, cameras, surfaces, report.
fn add_header(pack: &mut Pack, s: &Solution, baked: &BakedSolution, detail: &PackageDetail, origin: Vec3) {
    let (scene, report) = (&s.scene, &s.report);
    let (low, high) = scene.bounds();
    pack.set("name", scene.name().into());
    pack.set("version", s.version.clone().into());
    pack.set("origin", array(origin));
    pack.set("bounds", json!([array(low - origin), array(high - origin)]));
    pack.set("textures", scene.textures().len().into());
    let z = &s.zones;
    pack.set(
        "counts",
        json!({ "patches": z.patches.len(), "voxels": z.voxels.len(), "panes": z.panes.len() }),
    );
    // An unknown error is infinite, which JSON writes as null.
    let estimate =
        |e: &ErrorEstimate| json!({ "patches": e.patches.as_slice(), "volumes": e.volumes.as_slice() });
    let mut status: Vec<&str> = report.status.iter().map(|x| x.name()).collect();
    status.dedup();
    pack.set(
        "report",
        json!({
            "engine": report.engine, "status": status.join(", "), "grade": report.estimate.grade.name(),
            "estimates": detail.earlier.iter().chain([&report.estimate]).map(estimate).collect::<Vec<_>>(),
            "residual": report.energy.residual.as_slice(), "notes": notes(report, detail.stage), "stage": detail.stage.name(),
        }),
    );
    let camera = |c: &zonal_scene::Camera| json!({ "name": c.name, "origin": array(c.origin - origin), "target": array(c.target - origin), "up": array(c.up), "fov": c.fov });
    pack.set("cameras", scene.cameras().iter().map(camera).collect());
    let surface = |(i, x): (usize, &zonal_scene::Surface)| {
        json!({
            "name": x.name, "reflectance": x.scattered_fraction().as_slice(), "emission": x.emission.as_slice(), "group": baked.emission_groups[i],
            "texture": x.reflectance_texture, "emissionTexture": x.emission_texture, "both": x.sides == zonal_scene::Sides::Both,
        })
    };
    pack.set("surfaces", scene.surfaces().iter().enumerate().map(surface).collect());
    let pane =
        |p: &zonal_scene::Pane| json!({ "name": p.name, "depth": (p.extinction * p.thickness).as_slice() });
    pack.set("panes", scene.panes().iter().map(pane).collect());
}

/// Adds a field as 16-bit floats; returns the scale by which they are multiplied.
fn add_field(pack: &mut Pack, name: &str, values: &[[f32; 3]]) -> f32 {
    let scale = scale_of(values.as_flattened());
    pack.f16(name, values.as_flattened(), scale);
    scale
}

/// Adds a field of every light group that has it; `scales` gets the scale of each under the name of the field.
fn add_group_fields(pack: &mut Pack, stem: &str, groups: &[Vec<[f32; 3]>], scales: &mut [Value]) {
    for (g, values) in groups.iter().enumerate().filter(|(_, v)| !v.is_empty()) {
        scales[g][stem] = add_field(pack, &format!("{stem}{g}"), values).into();
    }
}

fn positions(points: &[[f32; 3]], origin: Vec3) -> Vec<f32> {
    points.iter().flat_map(|p| [0, 1, 2].map(|k| (p[k] as f64 - origin[k]) as f32)).collect()
}

fn add_mesh(pack: &mut Pack, m: &SurfaceMesh, origin: Vec3, scales: &mut [Value]) {
    pack.f32("position", &positions(&m.positions, origin));
    pack.f32("uv", m.uvs.as_flattened());
    pack.u16("surface", &m.surfaces.iter().map(|s| *s as u16).collect::<Vec<_>>());
    let indirect = |(all, direct): (&Vec<[f32; 3]>, &Vec<[f32; 3]>)| -> Vec<[f32; 3]> {
        let part = |(i, h): (usize, &[f32; 3])| {
            let d = direct.get(i).copied().unwrap_or_default();
            [0, 1, 2].map(|b| (h[b] - d[b]).max(0.0))
        };
        all.iter().enumerate().map(part).collect()
    };
    let indirect: Vec<Vec<[f32; 3]>> = m.irradiance.iter().zip(&m.direct).map(indirect).collect();
    add_group_fields(pack, "indirect", &indirect, scales);
    add_group_fields(pack, "direct", &m.direct, scales);
    let error = add_field(pack, "error", &m.error);
    pack.u32("index", m.triangles.as_flattened());
    pack.u32("triangleZone", &m.zones);
    pack.set("mesh", json!({ "vertices": m.positions.len(), "errorScale": error }));
}

/// The normals of vertices of curved surfaces, by which the page shades sunlight.
fn add_curves(pack: &mut Pack, m: &SurfaceMesh, s: &Solution) {
    let scene = &s.scene;
    if scene.shading().facets().len() == 0 {
        return;
    }
    let mut curves = vec![[0.0f32; 4]; m.positions.len()];
    for (triangle, zone) in m.triangles.iter().zip(&m.zones) {
        let patch = &s.zones.patches[*zone as usize];
        let plate = &scene.facets()[patch.facet].plate;
        let side = SidedFacet { facet: patch.facet, front: plate.normal().dot(patch.normal) > 0.0 };
        let centre = plate.parameters(plate.centre());
        let Some(at) = scene.curved_point(side, centre, 0.0) else { continue };
        let rise = (at.point - plate.centre()).dot(patch.normal).max(0.0) as f32;
        for v in triangle.map(|v| v as usize) {
            let [x, y, z] = m.normals[v];
            curves[v] = [x, y, z, rise];
        }
    }
    pack.f32("curve", curves.as_flattened());
}

/// Values of the patches in the solution, for the probe.
fn add_zones(pack: &mut Pack, s: &Solution) {
    let n = s.zones.patches.len();
    let list = |value: &dyn Fn(usize) -> Bands| -> Vec<f32> {
        (0..n).flat_map(|i| value(i).to_rgb().map(|x| x as f32)).collect()
    };
    let whole = [LightGroup::default()];
    let groups = if s.groups.is_empty() { &whole[..] } else { &s.groups };
    for (g, group) in groups.iter().enumerate() {
        let is_whole = s.groups.is_empty();
        let incident = |i: usize| if is_whole { s.fields.incident[i] } else { group.incident_at(i) };
        let direct = |i: usize| if is_whole { s.fields.direct_light(i) } else { group.direct_at(i) };
        pack.f32(&format!("zoneIndirect{g}"), &list(&incident));
        pack.f32(&format!("zoneDirect{g}"), &list(&direct));
    }
    pack.f32("zoneError", &list(&|i| s.fields.total_error(i)));
    pack.f32("zoneReflectance", &list(&|i| s.zones.patches[i].reflectance));
    pack.f32("zoneEmission", &list(&|i| s.zones.patches[i].emission));
    pack.u16("zoneSurface", &s.zones.patches.iter().map(|p| p.surface as u16).collect::<Vec<_>>());
}

fn add_panes(pack: &mut Pack, s: &Solution, m: &PaneMesh, origin: Vec3, scales: &mut [Value]) {
    if s.zones.panes.is_empty() {
        return;
    }
    pack.f32("panePosition", &positions(&m.positions, origin));
    pack.f32("paneNormal", m.normals.as_flattened());
    pack.u16("paneOf", &m.panes.iter().map(|p| *p as u16).collect::<Vec<_>>());
    add_group_fields(pack, "pane", &m.radiosity, scales);
    pack.u32("paneIndex", m.triangles.as_flattened());
}

fn add_volume(pack: &mut Pack, medium: Option<&VolumeGrid>, origin: Vec3, scales: &mut [Value]) {
    let Some(m) = medium else {
        return;
    };
    let mut head = json!({ "min": array(m.min - origin), "max": array(m.max - origin), "dims": m.dims });
    match &m.extinction[..] {
        [one] => head["extinction"] = json!(one),
        many => head["extinctionScale"] = add_field(pack, "extinction", many).into(),
    }
    match &m.albedo[..] {
        [one] => head["albedo"] = json!(one),
        many => head["albedoScale"] = add_field(pack, "albedo", many).into(),
    }
    add_group_fields(pack, "volume", &m.radiosity, scales);
    pack.set("volume", head);
}

/// The suns whose direct light the page draws.
fn add_suns(pack: &mut Pack, suns: &[BakedSun]) {
    let mut list = Vec::new();
    for (k, sun) in suns.iter().enumerate() {
        let mut head = json!({
            "group": sun.group, "towards": array(sun.towards), "irradiance": sun.irradiance, "angularDiameter": sun.angular_diameter,
        });
        if let Some(SunDepths { dims, values }) = &sun.depths {
            head["depthDims"] = json!(dims);
            head["depthScale"] = add_field(pack, &format!("sunDepth{k}"), values).into();
        }
        list.push(head);
    }
    pack.set("suns", Value::Array(list));
}

/// Light groups: name, radiance of the background, scales of the fields.
fn light_groups(s: &Solution, baked: &BakedSolution, scales: &[Value]) -> Value {
    let kind = |g: usize| s.groups.get(g).map_or(LightGroupKind::All, |x| x.kind);
    let background = |g: usize| {
        let surroundings = match kind(g) {
            LightGroupKind::All | LightGroupKind::Surroundings => s.scene.surroundings().radiance,
            _ => Bands::ZERO,
        };
        let own = s.scene.lights().iter().enumerate().filter(|(l, _)| kind(g).has_light(*l));
        let skies = own.filter_map(|(_, light)| light.sky());
        skies.fold(surroundings, |sum, (radiance, d)| sum + radiance * d.mean()).to_rgb()
    };
    let one = |(g, name): (usize, &String)| json!({ "name": name, "background": background(g), "scales": scales[g] });
    baked.groups.iter().enumerate().map(one).collect()
}
