//! Materials whose alpha varies over a picture: their faces are cut into pieces of one class of alpha ([`crate::input::mesh::cut_outs`]).
//!
//! | rule | pieces |
//! |---|---|
//! | mask | opaque where alpha ≥ the cutoff, nothing elsewhere |
//! | blend | nothing below the first of [`BLEND_LEVELS`], opaque above the last, between two of them a pane of the mean transmittance 1 − ᾱ |
//!
//! All methods then see opaque plates and panes only: their zones have the opaque area, and rays meet the contours. Cells are a fraction of a patch
//! and no smaller than a fraction of a pixel, or some pixels of a blended picture; where a material would have more than [`MAX_PIECES`] pieces, or take more than
//! [`MAX_MATERIAL_WORK`], as where a picture repeats a thousand times over a face, the cells are doubled until it does not.

use super::material_overrides::MaterialOverride;
use crate::input::images::alpha_map::AlphaClasses;
use crate::input::mesh::cut_outs::{CutLimits, CutPiece, TexturedPlate, cut};
use crate::input::mesh::model::{
    AlphaRule, GlassAttenuation, GlassProperties, MeshData, MeshFace, MeshMaterial,
};
use crate::input::reading::error::FileFault;
use crate::input::scene::scene_reader::SceneReader;
use crate::input::scene::thermal::SceneMode;
use std::collections::BTreeMap;
use zonal_math::Vec3;
use zonal_scene::{Bands, CornerNormals, Diagnostic};

/// Edge of a patch over that of a cell of a cut face.
const CELLS_PER_PATCH: f64 = 8.0;
/// Smallest cells of a mask and of a blended picture, pixels. At the edge of a hole a blended picture falls from 1 to 0 within a pixel or two, and larger cells
/// take this for a line.
const MASK_PIXELS: f64 = 0.5;
const BLEND_PIXELS: f64 = 3.0;
/// Patches of the mesh's diagonal, if no patch size is given: those of a scene's.
const PATCHES_PER_DIAGONAL: f64 = 30.0;
/// Largest number of pieces of a material, and doublings of the cells after which each face is one cell.
const MAX_PIECES: usize = 400_000;
const MAX_DOUBLINGS: u32 = 30;
/// Most work of the cuts of a material and of a mesh: some seconds, and some ten. A material whose pictures have little repetition takes up to 3e7.
const MAX_MATERIAL_WORK: u64 = 80_000_000;
const MAX_MESH_WORK: u64 = 300_000_000;
/// Values of alpha that bound the levels of a blended picture: below the first nothing is left, above the last the surface is opaque.
const BLEND_LEVELS: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];
/// Thickness of the panes of a level, m. Their optical depth is that of 1 − ᾱ for any thickness.
const LEVEL_THICKNESS: f64 = 1e-3;
/// Largest alpha of a pane.
const MAX_PANE_ALPHA: f64 = 1.0 - 1e-6;

/// Cuts the faces of all materials with an alpha of their own; levels of blended pictures become materials of their own. `scale` is the factor of lengths of the
/// file, `surface_patch_size` the patch size of the whole mesh, m.
pub(crate) fn cut_transparent_materials(
    mesh: &mut MeshData,
    scale: f64,
    surface_patch_size: Option<f64>,
    overrides: &BTreeMap<usize, MaterialOverride>,
    reader: &mut SceneReader<'_>,
) -> Result<(), FileFault> {
    let diagonal = mesh_diagonal(&mesh.faces);
    let mut work_left = MAX_MESH_WORK;
    for m in 0..mesh.materials.len() {
        let over = overrides.get(&m).cloned().unwrap_or_default();
        // A pane, a region or an opaque surface of the scene takes the place of the file's transparency.
        if over.pane.is_some() || over.omit || over.region {
            mesh.materials[m].alpha = None;
        }
        let Some(alpha) = mesh.materials[m].alpha.clone() else { continue };
        let patch_size =
            over.properties.patch_size.or(surface_patch_size).or(reader.parts.options.patch_size);
        let cell = patch_size.unwrap_or(diagonal / PATCHES_PER_DIAGONAL) / CELLS_PER_PATCH;
        let map = reader.alpha_map(&alpha)?;
        let thresholds = match alpha.rule {
            AlphaRule::Mask { cutoff } => vec![cutoff],
            AlphaRule::Blend => BLEND_LEVELS.to_vec(),
        };
        let classes = AlphaClasses::new(&map, alpha.factor, thresholds);
        let own: Vec<MeshFace> = mesh.faces.iter().filter(|f| f.material == m).copied().collect();
        let pixels = if alpha.rule == AlphaRule::Blend { BLEND_PIXELS } else { MASK_PIXELS };
        let (pieces, doublings) = cut_faces(&own, &classes, [cell, pixels], &mut work_left);
        note_cut_outs(mesh, m, own.len(), pieces.len(), doublings, reader);
        mesh.faces.retain(|f| f.material != m);
        let opaque = pieces.iter().filter(|p| p.1.class == classes.top());
        let opaque = opaque.map(|(f, piece)| face_of(f, piece, m, &mut mesh.normals));
        mesh.faces.extend(opaque);
        if alpha.rule == AlphaRule::Blend {
            add_levels(mesh, m, scale, &over, &pieces, &classes, reader)?;
        }
    }
    Ok(())
}

fn mesh_diagonal(faces: &[MeshFace]) -> f64 {
    let bounds = faces.iter().map(|f| f.plate.bounds());
    let (lo, hi) = bounds.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or((Vec3::ZERO, Vec3::ONE));
    (hi - lo).length()
}

/// A piece of a face; its normals are those of the face at its corners.
fn face_of(of: &MeshFace, piece: &CutPiece, material: usize, normals: &mut Vec<CornerNormals>) -> MeshFace {
    let own = of.normals.and_then(|k| normals.get(k as usize)).copied();
    let index = own.and_then(|own| {
        let at = |c: Vec3| of.interpolated_normal(&own, of.plate.parameters(c)).array().map(|x| x as f32);
        normals.push(piece.plate.corners().0.map(at));
        u32::try_from(normals.len() - 1).ok()
    });
    MeshFace { material, plate: piece.plate, uv: piece.uv, normals: index, ..*of }
}

/// A piece of a face as part of a pane, which has no normals.
fn pane_of(of: &MeshFace, piece: &CutPiece, material: usize) -> MeshFace {
    MeshFace { material, plate: piece.plate, uv: piece.uv, normals: None, ..*of }
}

/// The pieces of all faces above the lowest class, each with its face, and the doublings of the cells. The work is taken from `work_left`.
fn cut_faces<'f>(
    faces: &'f [MeshFace],
    classes: &AlphaClasses<'_>,
    [cell, pixels]: [f64; 2],
    work_left: &mut u64,
) -> (Vec<(&'f MeshFace, CutPiece)>, u32) {
    let mut out = Vec::new();
    let mut own_work = MAX_MATERIAL_WORK.min(*work_left);
    let mut doublings = 0;
    loop {
        out.clear();
        // Without work left, each face is one cell.
        doublings = if own_work == 0 { MAX_DOUBLINGS } else { doublings.min(MAX_DOUBLINGS) };
        let last = doublings == MAX_DOUBLINGS;
        let mut stopped_at = None;
        for (k, f) in faces.iter().enumerate() {
            let face = TexturedPlate { plate: f.plate, uv: f.uv };
            let halvings = face.halvings(cell, pixels, classes).saturating_sub(doublings);
            let limits = if last {
                CutLimits { pieces: usize::MAX, work: u64::MAX }
            } else {
                // A try takes half the work at most, so that coarser cells have a turn.
                CutLimits { pieces: MAX_PIECES - out.len(), work: own_work.div_ceil(2) }
            };
            let found = cut(&face, classes, halvings, limits);
            own_work = own_work.saturating_sub(found.work);
            *work_left = work_left.saturating_sub(found.work);
            match found.pieces {
                Ok(pieces) => out.extend(pieces.into_iter().filter(|p| p.class > 0).map(|p| (f, p))),
                Err(done) => stopped_at = Some(k as f64 + done),
            }
            if !last && out.len() > MAX_PIECES {
                stopped_at = Some(k as f64 + 1.0);
            }
            if stopped_at.is_some() {
                break;
            }
        }
        let Some(done) = stopped_at else { return (out, doublings) };
        // A doubling leaves a quarter of the pieces at least.
        let excess = faces.len() as f64 / done.max(1e-9 * faces.len() as f64);
        doublings += (excess.log2() / 2.0).floor().clamp(1.0, f64::from(MAX_DOUBLINGS)) as u32;
    }
}

/// Reports that faces were cut.
fn note_cut_outs(
    mesh: &MeshData,
    material: usize,
    faces: usize,
    pieces: usize,
    doublings: u32,
    reader: &mut SceneReader<'_>,
) {
    if faces == 0 {
        return;
    }
    let name = &mesh.materials[material].name;
    let mut text = match pieces {
        0 => format!("material '{name}' is entirely cut out by its alpha, and left out"),
        _ => format!("material '{name}': {faces} face(s) were cut along their alpha into {pieces} plates"),
    };
    if doublings > 0 && pieces > 0 {
        text += "; details are coarse, their areas are kept";
    }
    if pieces > 0 && mesh.materials[material].emission != Bands::ZERO {
        text += "; only their opaque parts emit";
    }
    reader.note(Diagnostic::note("cut-outs", text));
}

/// Adds the panes of the levels between the lowest and the highest class as materials.
fn add_levels(
    mesh: &mut MeshData,
    material: usize,
    scale: f64,
    over: &MaterialOverride,
    pieces: &[(&MeshFace, CutPiece)],
    classes: &AlphaClasses<'_>,
    reader: &mut SceneReader<'_>,
) -> Result<(), FileFault> {
    let base = mesh.materials[material].clone();
    let factor = over.properties.reflectance.or(base.reflectance).unwrap_or(Bands::ONE);
    let textured = over.properties.reflectance.is_none() && reader.mode() == SceneMode::Light;
    let texture = match &base.texture {
        Some(image) if textured => Some(reader.image(image)?),
        _ => None,
    };
    for class in 1..classes.top() {
        let own: Vec<_> = pieces.iter().filter(|p| p.1.class == class).collect();
        let area: f64 = own.iter().map(|p| p.1.plate.area()).sum();
        if own.is_empty() {
            continue;
        }
        // Means over the area, by the centres of the pieces.
        let (mut alpha, mut albedo) = (0.0, Bands::ZERO);
        for (_, piece) in &own {
            let (centre, weight) = (piece.centre_uv(), piece.plate.area() / area);
            alpha += weight * classes.alpha(centre);
            let colour = texture.map_or(Bands::ONE, |t| reader.parts.textures[t].sample(centre));
            albedo += weight * (factor * colour).map(|x| x.min(1.0));
        }
        let transmittance = Bands::splat(1.0 - alpha.min(MAX_PANE_ALPHA));
        let index = mesh.materials.len();
        mesh.materials.push(MeshMaterial {
            glass: Some(GlassProperties {
                thickness: Some(LEVEL_THICKNESS / scale),
                attenuation: GlassAttenuation::Transmittance(transmittance),
                albedo,
            }),
            ..MeshMaterial::named(&format!("{} (alpha {alpha:.2})", base.name))
        });
        mesh.faces.extend(own.iter().map(|(f, piece)| MeshFace { scale: 1.0, ..pane_of(f, piece, index) }));
    }
    Ok(())
}
