//! Surface zones and pane zones: facets and panes subdivided to the patch size, split along walls, with their mean properties.

use super::plate_subdivision::{self, MAX_PATCHES};
use super::wall_splitting;
use crate::transport::Transport;
use rayon::prelude::*;
use zonal_math::parallel;
use zonal_scene::PatchRule;
use zonal_scene::{Bands, PaneZone, Patch, Plate, Scene, SceneError, Sides};

/// Under `PatchRule::Area` a wall cuts off no piece smaller than this fraction of the squared patch size.
const MIN_PIECE_SHARE_OF_SIZE2: f64 = 0.1;

/// Texture samples of a patch along each parameter.
const TEXTURE_SAMPLES_PER_SIDE: usize = 4;

/// Pieces that are split along walls before their number is compared with the limit.
const PIECES_PER_BLOCK: usize = 1 << 16;

/// Number of pieces of a scene by surface, while it is counted.
struct PieceCounter<'a> {
    scene: &'a Scene,
    total: f64,
    of_surface: Vec<f64>,
}

impl<'a> PieceCounter<'a> {
    fn new(scene: &'a Scene) -> PieceCounter<'a> {
        PieceCounter { scene, total: 0.0, of_surface: vec![0.0; scene.surfaces().len()] }
    }

    /// Adds pieces of a surface.
    ///
    /// # Errors
    /// When the scene has more than [`MAX_PATCHES`].
    fn add(&mut self, surface: usize, count: f64) -> Result<(), SceneError> {
        self.total += count;
        self.of_surface[surface] += count;
        if self.total <= MAX_PATCHES as f64 {
            return Ok(());
        }
        // The surface with most pieces so far.
        let most = (0..self.of_surface.len())
            .fold(0, |a, b| if self.of_surface[b] > self.of_surface[a] { b } else { a });
        let s = &self.scene.surfaces()[most];
        let key = match s.patch_size {
            Some(_) => format!("surface '{}'.patch_size", s.name),
            None => "solve.patch_size".into(),
        };
        let size = s.patch_size.unwrap_or(self.scene.patch_size());
        Err(too_many(key, &format!("surface '{}'", s.name), self.of_surface[most], size))
    }
}

/// The error of a surface or pane that the patch size `size`, m, cuts into too many pieces.
fn too_many(key: String, subject: &str, count: f64, size: f64) -> SceneError {
    let message = format!(
        "patches of {size:.3e} m cut {subject} into {count:.1e} or more, and a scene has at most {MAX_PATCHES}; use a larger patch_size, or a smaller or less slender shape"
    );
    SceneError::new(key, message)
}

/// The patches, by ascending facet.
///
/// # Errors
///
/// When there are more than [`MAX_PATCHES`].
pub(super) fn patches(scene: &Scene, transport: &Transport) -> Result<Vec<Patch>, SceneError> {
    let size = |surface: usize| scene.surfaces()[surface].patch_size.unwrap_or(scene.patch_size());
    let rule = scene.options().patch_rule;
    let grid = scene.voxel_grid().filter(|_| rule == PatchRule::Voxels);
    let voxel_cuts = |p: &Plate, surface: usize| {
        if let Some(axis) = scene.strip_axis() {
            return Some(plate_subdivision::strip_cuts(p, axis, size(surface)));
        }
        grid.and_then(|g| plate_subdivision::voxel_cuts(p, g, scene.surfaces()[surface].patch_size))
    };
    // Count the pieces before making any.
    let mut counter = PieceCounter::new(scene);
    for f in scene.facets() {
        let count = match voxel_cuts(&f.plate, f.surface) {
            Some([u, v]) => (u.len() - 1) as f64 * (v.len() - 1) as f64,
            None => plate_subdivision::piece_count(&f.plate, size(f.surface), rule),
        };
        counter.add(f.surface, count)?;
    }
    // Subdivide the facets to the patch size.
    let subdivided: Vec<(usize, Plate)> = scene
        .facets()
        .par_iter()
        .enumerate()
        .flat_map_iter(|(k, f)| {
            let mut out = Vec::new();
            match voxel_cuts(&f.plate, f.surface) {
                Some(cuts) => plate_subdivision::cut_at(&f.plate, &cuts, &mut out),
                None => plate_subdivision::subdivide(&f.plate, size(f.surface), rule, &mut out),
            }
            out.into_iter().map(move |p| (k, p))
        })
        .collect();
    // Split the pieces along walls and remove covered ones.
    let mut patches = Vec::new();
    let mut counter = PieceCounter::new(scene);
    for block in subdivided.chunks(PIECES_PER_BLOCK) {
        let made = split_and_filter(scene, transport, block);
        made.iter().try_for_each(|p| counter.add(p.surface, 1.0))?;
        patches.extend(made);
    }
    Ok(patches)
}

/// The patches of the subdivided facets: split along walls, without the covered ones.
fn split_and_filter(scene: &Scene, transport: &Transport, subdivided: &[(usize, Plate)]) -> Vec<Patch> {
    let size = |surface: usize| scene.surfaces()[surface].patch_size.unwrap_or(scene.patch_size());
    let rule = scene.options().patch_rule;
    let direct = direct_emitters(scene);
    subdivided
        .par_iter()
        .flat_map_iter(|&(k, plate)| {
            let surface = scene.facets()[k].surface;
            let s = &scene.surfaces()[surface];
            let min_area = match rule {
                PatchRule::Area => MIN_PIECE_SHARE_OF_SIZE2 * size(surface).powi(2),
                _ => 0.0,
            };
            let two_sided = s.sides == Sides::Both && !s.solid;
            let sides = [Some(plate), two_sided.then(|| plate.flipped())];
            let split = |p: Plate| wall_splitting::split_along_walls(transport, k, &p, min_area);
            let pieces: Vec<Plate> = match s.transmission {
                None => sides.into_iter().flatten().flat_map(split).collect(),
                // The two sides of a piece are congruent and follow one another.
                Some(_) => {
                    let backs = split(plate).into_iter().flat_map(|p| split(p.flipped()));
                    backs.flat_map(|back| [back.flipped(), back]).collect()
                }
            };
            let open = pieces.into_iter().filter(|p| !wall_splitting::is_covered(transport, k, p));
            open.map(|p| patch(scene, &direct, k, p)).collect::<Vec<_>>()
        })
        .collect()
}

/// The patch `plate` of a facet with its mean reflectance and emission; `direct` marks the surfaces whose emission is direct light.
fn patch(scene: &Scene, direct: &[bool], facet: usize, plate: Plate) -> Patch {
    let surface = scene.facets()[facet].surface;
    let [reflectance, emission] = optics(scene, direct, facet, &plate);
    Patch { facet, surface, plate, normal: plate.normal(), area: plate.area(), reflectance, emission }
}

/// Mean reflectance and emission of the patch `plate` of a facet.
fn optics(scene: &Scene, direct: &[bool], facet: usize, plate: &Plate) -> [Bands; 2] {
    let surface = scene.facets()[facet].surface;
    let s = &scene.surfaces()[surface];
    let mean = |texture: Option<usize>, value: &dyn Fn(f64, f64) -> Bands| match texture {
        Some(_) => textured_mean(&scene.facets()[facet].plate, plate, value),
        None => value(0.5, 0.5),
    };
    let reflectance = mean(s.reflectance_texture, &|u, v| scene.reflectance_at(facet, u, v));
    let emission = if direct[surface] {
        Bands::ZERO
    } else {
        mean(s.emission_texture, &|u, v| scene.emission_at(facet, u, v))
    };
    [reflectance, emission]
}

/// Patches with the reflectance and emission of the bands of `scene`, whose geometry is theirs.
pub(super) fn patches_of_bands(scene: &Scene, patches: &[Patch]) -> Vec<Patch> {
    let direct = direct_emitters(scene);
    let of_bands = |p: &Patch| {
        let [reflectance, emission] = optics(scene, &direct, p.facet, &p.plate);
        Patch { reflectance, emission, ..p.clone() }
    };
    parallel::map(patches, of_bands)
}

/// For each surface, whether its emission is direct light.
fn direct_emitters(scene: &Scene) -> Vec<bool> {
    (0..scene.surfaces().len()).map(|s| scene.is_direct_emitter(s)).collect()
}

/// The mean of `value(u, v)` over a patch, with (u, v) on the facet's plate.
fn textured_mean(facet: &Plate, patch: &Plate, value: &dyn Fn(f64, f64) -> Bands) -> Bands {
    let n = TEXTURE_SAMPLES_PER_SIDE;
    let mut sum = Bands::ZERO;
    for i in 0..n * n {
        let cell = |k: usize| (k as f64 + 0.5) / n as f64;
        // The factors move samples of a triangle off its folding diagonal, where they would lie on its edge.
        let [u, v] = patch.warp([cell(i / n), cell(i % n) * 0.98 + 0.007]);
        let [u, v] = facet.parameters(patch.at(u, v));
        sum += value(u.clamp(0.0, 1.0), v.clamp(0.0, 1.0));
    }
    sum / (n * n) as f64
}

/// The pane zones, by ascending pane.
///
/// # Errors
///
/// When there are more than [`MAX_PATCHES`].
pub(super) fn panes(scene: &Scene) -> Result<Vec<PaneZone>, SceneError> {
    let (size, rule) = (scene.patch_size(), scene.options().patch_rule);
    let mut total = 0.0;
    for pane in scene.panes() {
        let count: f64 = pane.plates.iter().map(|p| plate_subdivision::piece_count(p, size, rule)).sum();
        total += count;
        if total > MAX_PATCHES as f64 {
            return Err(too_many("solve.patch_size".into(), &format!("pane '{}'", pane.name), count, size));
        }
    }
    let mut out = Vec::new();
    for (k, pane) in scene.panes().iter().enumerate() {
        let mut pieces = Vec::new();
        pane.plates.iter().for_each(|p| plate_subdivision::subdivide(p, size, rule, &mut pieces));
        out.extend(pieces.into_iter().map(|plate| pane_zone(scene, k, plate)));
    }
    Ok(out)
}

/// The piece `plate` of a pane with its optical properties.
pub(super) fn pane_zone(scene: &Scene, pane: usize, plate: Plate) -> PaneZone {
    let own = &scene.panes()[pane];
    PaneZone {
        pane,
        plate,
        normal: plate.normal(),
        area: plate.area(),
        thickness: own.thickness,
        extinction: own.extinction,
        albedo: own.albedo,
        emission: own.emission,
    }
}
