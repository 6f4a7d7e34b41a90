//! The medium on all paths between two zones: the extinction of a pair, if it has one.
//!
//! The paths of a pair fill the convex hull of its zones. The pair has one extinction
//!
//! - κ, where the hull lies in the grid and all cells that it may meet have the extinction κ;
//! - 0, where the hull meets no cell of the medium but empty ones.
//!
//! Cells that the hull may meet: those of its bounding box. A hull that leaves the grid is separated from the grid by its bounding box, by the plane of a
//! patch whose front the grid does not reach, or by a side of its shaft. Each test proves its result; a pair that fails all of them takes rays.
//! Other zones of the scene do not matter. A pane that may stand between the zones leaves no extinction of the pair.
//!
//! **Cost.** Sums of the changes of the extinction between neighbouring cells, over all boxes from the first cell (summed-area tables, Crow 1984), tell for
//! every range of cells whether the extinction varies there: eight numbers of three tables, 12 bytes a cell. Uniform grids need none.

use super::occlusion::shaft_end;
use crate::pair::prepared_zone::{PreparedShape, PreparedZone};
use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, Scene, VoxelGrid, Zones};
use zonal_transport::Transport;

/// Distance within which a zone on the boundary of a grid counts as inside, over the diagonal of the scene.
const BOUNDARY_SLACK: f64 = 1e-9;
/// Distance from a face between cells within which a hull counts as reaching no farther than that face, in edges of a cell.
const FACE_SLACK: f64 = 1e-6;

/// The media on the paths of all pairs of a scene.
pub(crate) struct PathMedia<'a> {
    transport: &'a Transport<'a>,
    grid: Option<&'a VoxelGrid>,
    /// A length below which points coincide, m.
    slack: f64,
    /// The extinction of every pair of the scene, if all have one.
    common: Option<Bands>,
    /// Where the extinction of the grid varies; `None` for a uniform grid.
    changes: Option<ExtinctionChanges>,
    /// Some pane can stand between two zones.
    panes_between: bool,
}

impl<'a> PathMedia<'a> {
    /// The media of a scene with its zones.
    pub(crate) fn new(scene: &'a Scene, zones: &Zones, transport: &'a Transport<'a>) -> PathMedia<'a> {
        let grid = scene.voxel_grid();
        let slack = BOUNDARY_SLACK * scene.diagonal();
        let panes_between = transport.has_interior_panes();
        let kappa = grid.map_or(Some(Bands::ZERO), VoxelGrid::uniform_extinction);
        let common =
            kappa.filter(|k| !panes_between && (*k == Bands::ZERO || all_inside(grid, zones, slack)));
        let changes = grid.filter(|g| g.uniform_extinction().is_none()).map(ExtinctionChanges::new);
        PathMedia { transport, grid, slack, common, changes, panes_between }
    }

    /// κ of the medium on all paths of a pair, 1/m; zero in vacuum, `None` where it varies, or where a pane may stand between.
    pub(crate) fn of_pair(&self, a: &PreparedZone, b: &PreparedZone) -> Option<Bands> {
        if self.common.is_some() {
            return self.common;
        }
        let kappa = self.extinction(a, b)?;
        let (mut p, mut q) = (Vec::new(), Vec::new());
        let dimmed = self.panes_between
            && self.transport.pane_may_intersect([shaft_end(a, &mut p), shaft_end(b, &mut q)]);
        (!dimmed).then_some(kappa)
    }

    /// The same without panes.
    fn extinction(&self, a: &PreparedZone, b: &PreparedZone) -> Option<Bands> {
        let Some(grid) = self.grid else { return Some(Bands::ZERO) };
        let (lo, hi) = (a.lo.min(b.lo), a.hi.max(b.hi));
        let (from, to) = (grid.min(), grid.max());
        let beyond = |k: usize| lo[k] < from[k] - self.slack || hi[k] > to[k] + self.slack;
        let apart = |k: usize| hi[k] <= from[k] + self.slack || lo[k] >= to[k] - self.slack;
        let leaves = (0..3).any(beyond);
        if leaves
            && ((0..3).any(apart)
                || is_behind_patch(a, from, to, self.slack)
                || is_behind_patch(b, from, to, self.slack))
        {
            return Some(Bands::ZERO);
        }
        let inside = match &self.changes {
            None => grid.uniform_extinction(),
            Some(changes) => changes.common_extinction(grid, lo, hi),
        };
        match inside {
            Some(kappa) if !leaves || kappa == Bands::ZERO => Some(kappa),
            _ if leaves && self.shaft_avoids(a, b, from, to) => Some(Bands::ZERO),
            _ => None,
        }
    }

    /// True where a side of the shaft separates the hull of a pair from the grid.
    fn shaft_avoids(&self, a: &PreparedZone, b: &PreparedZone, from: Vec3, to: Vec3) -> bool {
        let (mut p, mut q) = (Vec::new(), Vec::new());
        self.transport.shaft_avoids_box([shaft_end(a, &mut p), shaft_end(b, &mut q)], [from, to])
    }
}

/// True where all zones lie in the grid.
fn all_inside(grid: Option<&VoxelGrid>, zones: &Zones, slack: f64) -> bool {
    let Some(grid) = grid else { return true };
    let (lo, hi) = (grid.min() - Vec3::splat(slack), grid.max() + Vec3::splat(slack));
    let plates = zones.patches.iter().map(|p| &p.plate).chain(zones.panes.iter().map(|p| &p.plate));
    plates.map(|p| p.bounds()).all(|(a, b)| a.max(lo) == a && b.min(hi) == b)
}

/// True for a patch whose front faces no part of a box: what it exchanges with lies in front of its plane, and so do the paths.
fn is_behind_patch(z: &PreparedZone, from: Vec3, to: Vec3, slack: f64) -> bool {
    let PreparedShape::Plate { pane: None, plate } = &z.shape else { return false };
    let n = z.normal;
    let pick = |n: f64, l: f64, h: f64| if n > 0.0 { h } else { l };
    let highest = vec3(pick(n.x, from.x, to.x), pick(n.y, from.y, to.y), pick(n.z, from.z, to.z));
    n.dot(highest - plate.origin) <= slack
}

/// Counts of the faces between cells of different extinction.
struct ExtinctionChanges {
    dims: [usize; 3],
    /// For each axis the number of such faces, across it, of the cells before (x, y, z) in all three axes: entry (x, y, z) of a table of dims + 1 along each axis.
    counts: [Vec<u32>; 3],
}

impl ExtinctionChanges {
    fn new(grid: &VoxelGrid) -> ExtinctionChanges {
        let dims = grid.dims();
        ExtinctionChanges { dims, counts: [0, 1, 2].map(|axis| summed_changes(grid, axis)) }
    }

    /// The extinction of all cells that the box from `lo` to `hi` reaches into; `None` where it varies. The box meets the grid.
    fn common_extinction(&self, grid: &VoxelGrid, lo: Vec3, hi: Vec3) -> Option<Bands> {
        let (mut first, mut end) = ([0; 3], [0; 3]);
        for k in 0..3 {
            let along = |x: f64| (x - grid.min()[k]) / grid.cell()[k];
            let last = self.dims[k] - 1;
            first[k] = ((along(lo[k]) + FACE_SLACK).max(0.0) as usize).min(last);
            end[k] = ((along(hi[k]) - FACE_SLACK).max(0.0).ceil() as usize).clamp(first[k] + 1, last + 1);
        }
        let is_uniform = (0..3).all(|axis| {
            // The faces across an axis between two cells of the range.
            let mut from = first;
            from[axis] += 1;
            from[axis] >= end[axis] || self.sum(axis, from, end) == 0
        });
        is_uniform.then(|| grid.extinction(grid.index(first)))
    }

    /// Number of faces, counted at the cell behind each, of the cells from `from` to before `end`.
    fn sum(&self, axis: usize, from: [usize; 3], end: [usize; 3]) -> i64 {
        let at = |x: usize, y: usize, z: usize| {
            i64::from(self.counts[axis][(x * (self.dims[1] + 1) + y) * (self.dims[2] + 1) + z])
        };
        let ([a, b, c], [p, q, r]) = (from, end);
        at(p, q, r) - at(a, q, r) - at(p, b, r) - at(p, q, c) + at(a, b, r) + at(a, q, c) + at(p, b, c)
            - at(a, b, c)
    }
}

/// The table of one axis of [`ExtinctionChanges`].
fn summed_changes(grid: &VoxelGrid, axis: usize) -> Vec<u32> {
    let [nx, ny, nz] = grid.dims();
    let index = |x: usize, y: usize, z: usize| (x * (ny + 1) + y) * (nz + 1) + z;
    let changes = |cell: [usize; 3]| {
        let mut before = cell;
        if cell[axis] == 0 {
            return 0;
        }
        before[axis] -= 1;
        u32::from(grid.extinction(grid.index(cell)) != grid.extinction(grid.index(before)))
    };
    let mut out = vec![0; (nx + 1) * (ny + 1) * (nz + 1)];
    for x in 0..nx {
        for y in 0..ny {
            let mut line = 0;
            for z in 0..nz {
                line += changes([x, y, z]);
                let plane = out[index(x + 1, y, z + 1)] - out[index(x, y, z + 1)];
                out[index(x + 1, y + 1, z + 1)] = out[index(x, y + 1, z + 1)] + plane + line;
            }
        }
    }
    out
}
