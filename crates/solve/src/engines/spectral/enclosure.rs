//! Applicability of the spectral engine: a box on the grid of its medium.
//!
//! The extinction of the medium is uniform (albedo, emission and sources may vary), every cell is one whole voxel zone, and every patch is
//! a face of a cell on the boundary of the box that faces inwards, or lies beyond a side of the box (`outside`). Faces without a patch are
//! openings. A periodic axis has no patches at its ends.
//!
//! Patches outside add rows of their own (`bordered_operator.rs`): few of them, beside a box that is not periodic, and no zone may see the black back of a
//! surface, since the rest of a row is its exchange with the surroundings.

use crate::device::grid::{BoxGrid, OTHER_AXES};
use crate::engines::dense::band_groups::BandGroups;
use zonal_math::{Vec3, vec3};
use zonal_scene::{
    Band, Bands, Patch, PatchRule, PerBand, Plate, PlateKind, Scene, Sides, VoxelGrid, ZoneBasis, Zones,
};

/// Largest deviation of a patch from the grid, in edges of a cell.
const GRID_TOLERANCE: f64 = 1e-6;

/// Index of an opening in place of a zone.
pub(crate) const OPENING: u32 = u32::MAX;

/// A box on the grid of its medium.
#[derive(Clone, Debug)]
pub struct BoxEnclosure {
    /// The grid.
    pub(crate) grid: BoxGrid,
    /// Extinction, 1/m.
    pub(crate) kappa: Bands,
    /// The zone of every patch of the walls, low and high across each axis, by `[i_b][i_c]`; [`OPENING`] where there is none.
    pub(crate) faces: [[Vec<u32>; 2]; 3],
    /// The patches beyond the sides of the box, in ascending order: they stand in no path between its zones.
    pub(crate) outside: Vec<u32>,
}

/// Pairs of a patch outside and a zone, at most: some ten seconds of one core of 2023.
const MAX_OUTSIDE_PAIRS: usize = 5_000_000;

impl BoxEnclosure {
    /// The box enclosure of a scene, or the reason why it is none.
    pub fn find(scene: &Scene, zones: &Zones) -> Result<BoxEnclosure, String> {
        let map = scene.voxel_grid().ok_or("there is no medium")?;
        if !scene.panes().is_empty() {
            return Err("there are panes".into());
        }
        let kappa = map.uniform_extinction().ok_or_else(|| {
            let varies = |b: &Band| (0..map.len()).any(|i| map.extinction(i)[*b] != map.extinction(0)[*b]);
            format!("the extinction varies in band {}", Band::all().find(varies).map_or(0, Band::index))
        })?;
        let found = BoxEnclosure::locate(scene, zones, kappa)?;
        if !found.outside.is_empty() {
            check_outside(scene, zones, &found.outside)?;
        }
        Ok(found)
    }

    /// The box on the grid of the medium of a scene, whatever its extinction, with the extinction `kappa` of the result; or the reason why there is
    /// none.
    fn locate(scene: &Scene, zones: &Zones, kappa: Bands) -> Result<BoxEnclosure, String> {
        let map = scene.voxel_grid().ok_or("there is no medium")?;
        let whole = zones.voxels.total() == map.len() && zones.voxels.cut_count() == 0;
        if !whole {
            return Err("surfaces cut or fill voxels, or voxels lie outside the walls".into());
        }
        let grid = BoxGrid::new(map.dims(), map.cell().array(), scene.periodic());
        let mut faces = [0, 1, 2].map(|a| {
            let size = if grid.periodic[a] { 0 } else { grid.patches(a) };
            [vec![OPENING; size], vec![OPENING; size]]
        });
        let mut outside = Vec::new();
        for (i, patch) in zones.patches.iter().enumerate() {
            let name = &scene.surfaces()[patch.surface].name;
            let face = locate_face(map, &grid, patch);
            if face.is_none() && lies_beyond_a_side(map, patch) {
                outside.push(i as u32);
                continue;
            }
            let (axis, side, at) = face.ok_or_else(|| {
                let advice = match scene.options().patch_rule {
                    PatchRule::Voxels => "it lies off the medium's boundary or looks away from it: let the walls be the box of the medium",
                    _ => "patch_rule = \"voxels\" cuts walls along the voxels",
                };
                format!("a patch of surface '{name}' is no face of a voxel on the medium's boundary that looks inwards, nor beyond a side of the medium; {advice}")
            })?;
            let slot = faces[axis][side].get_mut(at).ok_or_else(|| {
                format!("surface '{name}' stands across an axis along which the scene is periodic")
            })?;
            if *slot != OPENING {
                return Err(format!("a patch of surface '{name}' lies on another"));
            }
            *slot = i as u32;
        }
        Ok(BoxEnclosure { grid, kappa, faces, outside })
    }

    /// As [`BoxEnclosure::find`], whatever the extinction of the medium, without patches outside.
    pub(crate) fn without_outside(
        scene: &Scene,
        zones: &Zones,
        kappa: Bands,
    ) -> Result<BoxEnclosure, String> {
        let found = BoxEnclosure::locate(scene, zones, kappa)?;
        match found.outside.first() {
            Some(&i) => {
                let surface = zones.patches[i as usize].surface;
                Err(format!("surface '{}' lies outside the medium", scene.surfaces()[surface].name))
            }
            None => Ok(found),
        }
    }

    /// True where a wall has an opening.
    pub(crate) fn is_open(&self) -> bool {
        self.faces.iter().flatten().flatten().any(|z| *z == OPENING)
    }

    /// The groups of bands with equal extinctions.
    pub(crate) fn extinction_groups(&self) -> (PerBand<usize>, Vec<f64>) {
        let BandGroups { group, firsts } = BandGroups::of(|a, b| self.kappa[a] == self.kappa[b]);
        (group, firsts.into_iter().map(|b| self.kappa[b]).collect())
    }
}

/// True for a patch in the half space beyond a side of the box; in the plane of the side if it looks away.
fn lies_beyond_a_side(map: &VoxelGrid, patch: &Patch) -> bool {
    let (lo, hi) = patch.plate.bounds();
    (0..3).any(|k| {
        let slack = GRID_TOLERANCE * map.cell()[k];
        let (below, above) = (map.min()[k] - hi[k], lo[k] - map.max()[k]);
        below > slack
            || above > slack
            || (below >= -slack && patch.normal[k] < 0.0)
            || (above >= -slack && patch.normal[k] > 0.0)
    })
}

/// The reason why patches outside a box cannot have rows of their own.
fn check_outside(scene: &Scene, zones: &Zones, outside: &[u32]) -> Result<(), String> {
    let beside = |why: &str| Err(format!("surfaces lie outside the medium, {why}"));
    if scene.is_periodic() || scene.has_symmetry_planes() {
        return beside("which has images");
    }
    if scene.options().zone_basis == ZoneBasis::Linear {
        return beside("with which slopes do not exchange");
    }
    if !zones.sheets.is_empty() || scene.lights().iter().any(|l| l.surface().is_some()) {
        return beside("and some transmit or are lamps");
    }
    if outside.len().saturating_mul(zones.total()) > MAX_OUTSIDE_PAIRS {
        return beside("and are many");
    }
    // No zone may see the back of a surface with one side.
    let map = scene.voxel_grid().ok_or("there is no medium")?;
    let (from, to) = (map.min(), map.max());
    let slack = GRID_TOLERANCE * scene.diagonal();
    let corner = |k: usize| {
        let pick = |axis: usize| if k >> axis & 1 == 0 { from[axis] } else { to[axis] };
        vec3(pick(0), pick(1), pick(2))
    };
    let mut points: Vec<Vec3> = (0..8).map(corner).collect();
    for &i in outside {
        let (corners, count) = zones.patches[i as usize].plate.corners();
        points.extend(&corners[..count]);
    }
    let is_seen_from_behind = |p: &Plate| {
        let n = p.normal();
        points.iter().any(|x| n.dot(*x - p.origin) < -slack)
    };
    let one_sided = scene.facets().iter().filter(|f| scene.surfaces()[f.surface].sides == Sides::Front);
    match one_sided.take(MAX_OUTSIDE_PAIRS / points.len()).find(|f| is_seen_from_behind(&f.plate)) {
        Some(f) => {
            let name = &scene.surfaces()[f.surface].name;
            beside(&format!("and see the back of '{name}', which has one side"))
        }
        None if scene.facets().len() > MAX_OUTSIDE_PAIRS / points.len() => beside("and are many"),
        None => Ok(()),
    }
}

/// Axis, side and number of the face of a patch.
fn locate_face(map: &VoxelGrid, grid: &BoxGrid, patch: &Patch) -> Option<(usize, usize, usize)> {
    if patch.plate.kind != PlateKind::Parallelogram {
        return None;
    }
    let (lo, hi) = patch.plate.bounds();
    let at = |p: Vec3, k: usize| (p[k] - map.min()[k]) / grid.edges[k];
    // The corner in whole cells, if it lies on the grid.
    let whole = |p: Vec3, k: usize| {
        let x = at(p, k);
        ((x - x.round()).abs() <= GRID_TOLERANCE && x.round() >= 0.0).then(|| x.round() as usize)
    };
    let axis = (0..3).find(|&k| at(hi, k) - at(lo, k) <= GRID_TOLERANCE)?;
    let plane = whole(lo, axis)?;
    let side = match patch.normal[axis] {
        n if n > 0.5 && plane == 0 => 0,
        n if n < -0.5 && plane == grid.cells[axis] => 1,
        _ => return None,
    };
    let [b, c] = OTHER_AXES[axis].map(|k| {
        let (from, to) = (whole(lo, k)?, whole(hi, k)?);
        (to == from + 1 && to <= grid.cells[k]).then_some(from)
    });
    // A parallelogram that fills its bounds is an axis-aligned rectangle.
    let [kb, kc] = OTHER_AXES[axis];
    let full = (patch.area - grid.edges[kb] * grid.edges[kc]).abs() <= 4.0 * GRID_TOLERANCE * patch.area;
    full.then_some((axis, side, b? * grid.cells[kc] + c?))
}
