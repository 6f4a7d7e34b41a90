//! Windows of neighbouring zones with similar incident radiation, and the weights of a linear fit over them.
//!
//! The window of a volume zone holds the cells up to a number of steps away that are connected to it from face to face without a wall
//! between the centres. Where all of them are unobstructed they form a cube, and by symmetry the linear fit at its centre is the mean.
//! The window of a patch holds the patches in the same plane with about the same normal, within a radius proportional to its own size.

use crate::settings::unobstructed_cells::UnobstructedCells;
use std::ops::Range;
use zonal_math::Vec3;
use zonal_math::parallel;
use zonal_scene::{Scene, VoxelGrid, Zones};
use zonal_transport::Transport;
use zonal_transport::point_grids::PointGrids;

// Sizes of the windows.

/// Steps from cell to cell of the windows of a volume zone.
const VOXEL_STEPS: [usize; 2] = [1, 2];
/// Radii of the windows of a patch, in square roots of its area.
const PATCH_RADII: [f64; 3] = [1.6, 3.2, 6.4];
/// Fewest zones of a window: fewer do not determine a slope.
const MIN_ZONES: usize = 4;
/// Most patches of a window; the nearest are kept.
const MAX_PATCHES: usize = 96;
/// Smallest cosine between the normals of patches of a window.
const MIN_NORMAL_COSINE: f64 = 0.97;
/// Largest height of a patch over the plane of the window, relative to its distance.
const MAX_HEIGHT_OVER_DISTANCE: f64 = 0.12;

/// Volume zones of one task.
const ZONES_PER_TASK: usize = 1024;
/// Ridge added to the covariance of patches, over its trace: a plane has no extent along its normal.
const PLANE_RIDGE: f64 = 1e-3;
/// Ridge added to the covariance of volume zones, over its trace.
const VOLUME_RIDGE: f64 = 1e-6;

/// Zones and their weights in a linear fit at the central zone. The weights add up to one.
pub(crate) enum RegressionWindow {
    /// Each zone with its weight.
    Weighted(Vec<(u32, f64)>),
    /// Runs of zones of equal weight.
    Cube(Vec<Range<usize>>),
}

impl RegressionWindow {
    /// Number of zones.
    pub(crate) fn len(&self) -> usize {
        match self {
            RegressionWindow::Weighted(list) => list.len(),
            RegressionWindow::Cube(rows) => rows.iter().map(|r| r.len()).sum(),
        }
    }

    /// Calls `f` with every zone and its weight.
    #[inline]
    pub(crate) fn for_each(&self, mut f: impl FnMut(usize, f64)) {
        match self {
            RegressionWindow::Weighted(list) => list.iter().for_each(|(j, l)| f(*j as usize, *l)),
            RegressionWindow::Cube(rows) => {
                let l = 1.0 / self.len() as f64;
                rows.iter().cloned().flatten().for_each(|j| f(j, l));
            }
        }
    }
}

/// The neighbours of every zone.
pub(crate) struct RegressionWindows<'a> {
    zones: &'a Zones,
    voxels: Option<VoxelAdjacency<'a>>,
    /// Centre and normal of every patch.
    patches: Vec<[Vec3; 2]>,
    grids: PointGrids,
}

impl<'a> RegressionWindows<'a> {
    /// Sorts the patches into grids and connects the volume zones.
    pub(crate) fn new(scene: &'a Scene, zones: &'a Zones, transport: &Transport) -> RegressionWindows<'a> {
        let patches: Vec<[Vec3; 2]> = zones.patches.iter().map(|p| [p.plate.centre(), p.normal]).collect();
        let largest = zones.patches.iter().fold(0.0f64, |m, p| m.max(p.area)).sqrt();
        let centres: Vec<Vec3> = patches.iter().map(|p| p[0]).collect();
        let radii = &PATCH_RADII;
        RegressionWindows {
            zones,
            voxels: scene.voxel_grid().map(|grid| VoxelAdjacency::new(grid, zones, transport)),
            grids: PointGrids::new(&centres, radii[radii.len() - 1] * largest),
            patches,
        }
    }

    /// Number of windows of zone `i`.
    pub(crate) fn levels(&self, i: usize) -> usize {
        if i < self.zones.patches.len() { PATCH_RADII.len() } else { VOXEL_STEPS.len() }
    }

    /// A window of zone `i`, wider for a higher `level`; `None` where it has too few zones.
    pub(crate) fn window(&self, i: usize, level: usize) -> Option<RegressionWindow> {
        match i.checked_sub(self.zones.patches.len()) {
            Some(z) => self.voxels.as_ref()?.window(z, VOXEL_STEPS[level]),
            None => linear_fit(&self.similar_patches(i, PATCH_RADII[level]), PLANE_RIDGE),
        }
    }

    /// Patches in the plane of patch `i` within `radius` of its own size.
    fn similar_patches(&self, i: usize, radius: f64) -> Vec<WindowMember> {
        let ([x, normal], r) = (self.patches[i], radius * self.zones.patches[i].area.sqrt());
        let mut out: Vec<(f64, WindowMember)> = Vec::new();
        self.grids.for_each_near(x, normal, r, MAX_HEIGHT_OVER_DISTANCE, |j| {
            let [centre, other_normal] = self.patches[j];
            let offset = centre - x;
            let d2 = offset.length2();
            if d2 > r * r || normal.dot(other_normal) <= MIN_NORMAL_COSINE {
                return;
            }
            if normal.dot(offset).abs() <= MAX_HEIGHT_OVER_DISTANCE * d2.sqrt() {
                out.push((d2, WindowMember { zone: j as u32, offset }));
            }
        });
        if out.len() > MAX_PATCHES {
            out.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.zone.cmp(&b.1.zone)));
            out.truncate(MAX_PATCHES);
        }
        out.into_iter().map(|x| x.1).collect()
    }
}

/// Volume zones and the connections across the faces of their cells.
struct VoxelAdjacency<'a> {
    unobstructed: UnobstructedCells<'a>,
    offset: usize,
    /// Cell and centre of each zone, apart from the zones themselves, which are large.
    places: Vec<([u32; 3], Vec3)>,
    /// The zones connected to zone z are `neighbours[first[z]..first[z + 1]]`.
    first: Vec<u32>,
    neighbours: Vec<u32>,
}

impl<'a> VoxelAdjacency<'a> {
    fn new(grid: &'a VoxelGrid, zones: &'a Zones, transport: &Transport) -> VoxelAdjacency<'a> {
        let unobstructed = UnobstructedCells::new(grid, zones, transport);
        let n = zones.voxels.len();
        let faces = FaceNeighbours { zones, grid, transport, unobstructed: &unobstructed };
        let tasks: Vec<(Vec<u32>, Vec<u32>)> = parallel::collect(n.div_ceil(ZONES_PER_TASK), |task| {
            let (mut ends, mut all) = (Vec::new(), Vec::new());
            for z in task * ZONES_PER_TASK..((task + 1) * ZONES_PER_TASK).min(n) {
                faces.append(z, &mut all);
                ends.push(all.len() as u32);
            }
            (ends, all)
        });
        let (mut first, mut all) = (vec![0u32], Vec::new());
        for (ends, list) in tasks {
            first.extend(ends.iter().map(|e| e + all.len() as u32));
            all.extend(list);
        }
        let coordinates = |cell: usize| grid.coordinates(cell).map(|c| c as u32);
        let place = |i: usize| {
            let v = zones.voxels.at(i);
            (coordinates(v.cell), v.centre)
        };
        let places = parallel::collect(zones.voxels.len(), place);
        VoxelAdjacency { unobstructed, offset: zones.voxel_offset(), places, first, neighbours: all }
    }

    fn window(&self, z: usize, steps: usize) -> Option<RegressionWindow> {
        if let Some(rows) = self.unobstructed.cube(z, steps) {
            let run = |r: Range<usize>| r.start + self.offset..r.end + self.offset;
            return Some(RegressionWindow::Cube(rows.map(|row| run(row.zones)).collect()));
        }
        linear_fit(&self.connected(z, steps as i32), VOLUME_RIDGE)
    }

    /// Volume zones up to `steps` cells away that are connected to zone `z`, by breadth-first search.
    fn connected(&self, z: usize, steps: i32) -> Vec<WindowMember> {
        let (here, x) = self.places[z];
        let side = 2 * steps + 1;
        // At most 5³ cells.
        let mut visited = [0u64; 2];
        let slot = |c: [u32; 3]| {
            let d = [0, 1, 2].map(|k| c[k] as i32 - here[k] as i32 + steps);
            let inside = d.iter().all(|d| (0..side).contains(d));
            inside.then(|| ((d[0] * side + d[1]) * side + d[2]) as usize)
        };
        let mut out = vec![WindowMember { zone: z as u32, offset: Vec3::ZERO }];
        if let Some(s) = slot(here) {
            visited[s / 64] |= 1 << (s % 64);
        }
        let mut next = 0;
        while next < out.len() {
            let from = out[next].zone as usize;
            next += 1;
            for &to in &self.neighbours[self.first[from] as usize..self.first[from + 1] as usize] {
                let (cell, centre) = self.places[to as usize];
                let Some(s) = slot(cell) else { continue };
                if visited[s / 64] >> (s % 64) & 1 == 0 {
                    visited[s / 64] |= 1 << (s % 64);
                    out.push(WindowMember { zone: to, offset: centre - x });
                }
            }
        }
        out.iter_mut().for_each(|m| m.zone += self.offset as u32);
        out
    }
}

/// The search for volume zones across the faces of a cell.
struct FaceNeighbours<'a> {
    zones: &'a Zones,
    grid: &'a VoxelGrid,
    transport: &'a Transport<'a>,
    unobstructed: &'a UnobstructedCells<'a>,
}

impl FaceNeighbours<'_> {
    /// Appends the volume zones across the faces of the cell of `z` whose centre is visible from its own.
    fn append(&self, z: usize, out: &mut Vec<u32>) {
        let (own, dims) = (self.zones.voxels.at(z), self.grid.dims());
        let c = self.grid.coordinates(own.cell);
        for face in 0..6 {
            let (k, up) = (face / 2, face % 2 == 1);
            if if up { c[k] + 1 >= dims[k] } else { c[k] == 0 } {
                continue;
            }
            let mut to = c;
            to[k] = if up { c[k] + 1 } else { c[k] - 1 };
            for other in self.zones.voxel_zones_of_cell(self.grid.index(to)) {
                let next = self.zones.voxels.at(other);
                let passes = if own.samples.is_empty() && next.samples.is_empty() {
                    self.unobstructed.is_connected(if up { z } else { other }, k)
                } else {
                    !self.transport.separated_inside(own.centre, next.centre)
                };
                if passes {
                    out.push(other as u32);
                }
            }
        }
    }
}

/// A zone of a window.
struct WindowMember {
    zone: u32,
    /// x_j − x_i.
    offset: Vec3,
}

/// The weights of a linear fit at the origin; `None` where the members are too few or do not span. `ridge` is added to the diagonal of
/// their covariance, relative to its trace.
fn linear_fit(members: &[WindowMember], ridge: f64) -> Option<RegressionWindow> {
    // Lengths are relative to the window's own size.
    let size = members.iter().fold(0.0f64, |m, x| m.max(x.offset.length2())).sqrt();
    if members.len() < MIN_ZONES || size <= 0.0 {
        return None;
    }
    let n = members.len() as f64;
    let mean = members.iter().fold(Vec3::ZERO, |s, m| s + m.offset) / (n * size);
    let mut c = [[0.0; 3]; 3];
    for m in members {
        let d = m.offset / size - mean;
        for (r, row) in c.iter_mut().enumerate() {
            (0..3).for_each(|k| row[k] += d[r] * d[k] / n);
        }
    }
    // The ridge also regularises members in a line.
    let trace = c[0][0] + c[1][1] + c[2][2];
    let ridge = ridge * trace;
    (0..3).for_each(|k| c[k][k] += ridge);
    let g = solve_symmetric(c, mean)?;
    let weight = |m: &WindowMember| (m.zone, (1.0 - (m.offset / size - mean).dot(g)) / n);
    Some(RegressionWindow::Weighted(members.iter().map(weight).collect()))
}

/// C⁻¹ v of a symmetric positive definite matrix, by Cramer's rule.
fn solve_symmetric(c: [[f64; 3]; 3], v: Vec3) -> Option<Vec3> {
    let row = |k: usize| Vec3::from_array(c[k]);
    let (a, b, d) = (row(0), row(1), row(2));
    let det = a.dot(b.cross(d));
    if det.is_nan() || det <= 0.0 {
        return None;
    }
    Some((b.cross(d) * v.x + d.cross(a) * v.y + a.cross(b) * v.z) / det)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;

    #[test]
    fn linear_fit_reproduces_linear_fields() {
        let mut members = Vec::new();
        for k in 0..20 {
            let [x, y, z] = zonal_math::low_discrepancy::r3(k, [0.3, 0.1, 0.7]);
            members.push(WindowMember { zone: k as u32, offset: vec3(x - 0.2, 2.0 * y, z - 1.0) });
        }
        let window = linear_fit(&members, VOLUME_RIDGE).unwrap();
        let field = |p: Vec3| 3.0 + 2.0 * p.x - p.y + 0.5 * p.z;
        let (mut found, mut sum) = (0.0, 0.0);
        window.for_each(|j, l| {
            found += l * field(members[j].offset);
            sum += l;
        });
        assert!((sum - 1.0).abs() < 1e-12);
        assert!((found - 3.0).abs() < 1e-4, "{found}");
        assert!(linear_fit(&members[..3], VOLUME_RIDGE).is_none());
    }
}
