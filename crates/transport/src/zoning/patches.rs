//! Surface zones and pane zones.

use super::{cut, split};
use crate::Transport;
use rayon::prelude::*;
use zonal_scene::scene::PatchRule;
use zonal_scene::{Bands, PaneZone, Patch, Plate, Scene, SceneError, Sides, bands};

/// The most patches that a scene may be cut into.
pub const MAX_PATCHES: usize = 1 << 22;

/// By area, a wall cuts no smaller share of size² off a patch.
const SMALLEST: f64 = 0.1;

/// Texture samples along each parameter.
const TEXELS: usize = 4;

fn check(count: f64, key: String) -> Result<(), SceneError> {
    if count <= MAX_PATCHES as f64 {
        return Ok(());
    }
    Err(SceneError::new(
        key,
        format!(
            "this patch size makes about {count:.1e} patches, more than the {MAX_PATCHES} allowed; use a larger one"
        ),
    ))
}

/// The patches, by ascending facet.
pub(super) fn patches(scene: &Scene, transport: &Transport) -> Result<Vec<Patch>, SceneError> {
    let size = |surface: usize| scene.surfaces()[surface].patch_size.unwrap_or(scene.patch_size());
    let rule = scene.options().patch_rule;
    let map = scene.voxmap().filter(|_| rule == PatchRule::Voxels);
    let own = |surface: usize| scene.surfaces()[surface].patch_size;
    let by_voxels = |p: &Plate, surface: usize| map.and_then(|m| cut::by_voxels(p, m, own(surface)));
    let mut total = 0.0;
    for f in scene.facets() {
        let s = &scene.surfaces()[f.surface];
        total += match by_voxels(&f.plate, f.surface) {
            Some([u, v]) => (u.len() * v.len()) as f64,
            None => cut::estimate(&f.plate, size(f.surface), rule),
        };
        let key = match s.patch_size {
            Some(_) => format!("surface '{}'.patch_size", s.name),
            None => "solve.patch_size".into(),
        };
        check(total, key)?;
    }
    let raw: Vec<(usize, Plate)> = scene
        .facets()
        .par_iter()
        .enumerate()
        .flat_map_iter(|(k, f)| {
            let mut out = Vec::new();
            match by_voxels(&f.plate, f.surface) {
                Some(cuts) => cut::between(&f.plate, &cuts, &mut out),
                None => cut::pieces(&f.plate, size(f.surface), rule, &mut out),
            }
            out.into_iter().map(move |p| (k, p))
        })
        .collect();
    let direct: Vec<bool> = (0..scene.surfaces().len()).map(|s| scene.is_direct_emitter(s)).collect();
    let patches: Vec<Patch> = raw
        .par_iter()
        .flat_map_iter(|&(k, plate)| {
            let surface = scene.facets()[k].surface;
            let s = &scene.surfaces()[surface];
            let smallest = if rule == PatchRule::Area { SMALLEST * size(surface).powi(2) } else { 0.0 };
            let both = s.sides == Sides::Both && !s.solid;
            let sides = [Some(plate), both.then(|| plate.flipped())];
            let pieces = sides.into_iter().flatten().flat_map(|p| split::split(transport, k, &p, smallest));
            let open = pieces.filter(|p| !split::covered(transport, k, p));
            open.map(|p| patch(scene, &direct, k, p)).collect::<Vec<_>>()
        })
        .collect();
    check(patches.len() as f64, "solve.patch_size".into())?;
    Ok(patches)
}

fn patch(scene: &Scene, direct: &[bool], facet: usize, plate: Plate) -> Patch {
    let surface = scene.facets()[facet].surface;
    let s = &scene.surfaces()[surface];
    let reflectance =
        mean(scene, facet, &plate, s.reflectance_texture.is_some(), |u, v| scene.reflectance_at(facet, u, v));
    let emission = if direct[surface] {
        [0.0; 3]
    } else {
        mean(scene, facet, &plate, s.emission_texture.is_some(), |u, v| scene.emission_at(facet, u, v))
    };
    Patch { facet, surface, plate, normal: plate.normal(), area: plate.area(), reflectance, emission }
}

/// The mean of `value(u, v)` over the patch, (u, v) on the facet's plate.
fn mean(
    scene: &Scene,
    facet: usize,
    plate: &Plate,
    textured: bool,
    value: impl Fn(f64, f64) -> Bands,
) -> Bands {
    if !textured {
        return value(0.5, 0.5);
    }
    let whole = &scene.facets()[facet].plate;
    let mut sum = [0.0; 3];
    for i in 0..TEXELS * TEXELS {
        let cell = |k: usize| (k as f64 + 0.5) / TEXELS as f64;
        // On the folding diagonal a triangle's samples would lie on its edge: move them off it.
        let [u, v] = plate.warp([cell(i / TEXELS), cell(i % TEXELS) * 0.98 + 0.007]);
        let [u, v] = whole.parameters(plate.at(u, v));
        let x = value(u.clamp(0.0, 1.0), v.clamp(0.0, 1.0));
        sum = bands(|k| sum[k] + x[k]);
    }
    sum.map(|x| x / (TEXELS * TEXELS) as f64)
}

/// The pane zones, by ascending pane.
pub(super) fn panes(scene: &Scene) -> Result<Vec<PaneZone>, SceneError> {
    let (size, rule) = (scene.patch_size(), scene.options().patch_rule);
    let plates = || scene.panes().iter().flat_map(|p| &p.plates);
    check(plates().map(|p| cut::estimate(p, size, rule)).sum(), "solve.patch_size".into())?;
    let mut out = Vec::new();
    for (k, pane) in scene.panes().iter().enumerate() {
        let mut pieces = Vec::new();
        pane.plates.iter().for_each(|p| cut::pieces(p, size, rule, &mut pieces));
        out.extend(pieces.into_iter().map(|plate| PaneZone {
            pane: k,
            plate,
            normal: plate.normal(),
            area: plate.area(),
            thickness: pane.thickness,
            extinction: pane.extinction,
            albedo: pane.albedo,
            emission: pane.emission,
        }));
    }
    Ok(out)
}
