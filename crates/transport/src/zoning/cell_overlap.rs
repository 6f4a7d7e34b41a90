//! Overlap of facets with the cells of the voxel grid.
//!
//! A convex plate and a box are disjoint if and only if they are separated along one of the box's axes, the plate's normal, or the
//! cross product of an edge with a box's axis (separating axis theorem; Akenine-Möller 2001). A facet in a face of a cell touches
//! the closed box but not one that is smaller by 10⁻⁹ of its size; it does not intersect the cell.

use super::work_sharing::WorkSharing;
use crate::transport::Transport;
use rayon::prelude::*;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Plate, PlateKind, SUBCELLS, Scene, VoxelGrid};

/// Fraction of a cell by which boxes are shrunk or grown.
const SKIN_SHARE_OF_CELL: f64 = 1e-9;

/// Facets whose contacts one process finds together.
const FACETS_PER_BLOCK: usize = 256;

/// The contact of one facet with one cell.
pub(super) struct FacetContact {
    pub(super) cell: u32,
    pub(super) facet: u32,
    /// True if the facet intersects the interior of the cell.
    pub(super) intersects: bool,
}

impl FacetContact {
    /// The contact as one number: facet · 2³³ + cell · 2 + (1 if the facet intersects the interior).
    fn word(&self) -> u64 {
        u64::from(self.facet) << 33 | u64::from(self.cell) << 1 | u64::from(self.intersects)
    }
    fn from_word(word: u64) -> FacetContact {
        FacetContact { cell: (word >> 1) as u32, facet: (word >> 33) as u32, intersects: word & 1 == 1 }
    }
}

/// Contact of a cell with facets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CellContact {
    /// No facet touches the cell.
    Separate,
    /// Facets touch its faces only.
    Touched,
    /// A facet intersects its interior.
    Intersected,
}

/// The contact of each cell, and the (cell, facet) pairs of the intersected cells in ascending order. `slack` (m) grows the boxes.
pub(super) fn overlaps(
    scene: &Scene,
    grid: &VoxelGrid,
    slack: f64,
    sharing: Option<&dyn WorkSharing>,
) -> (Vec<CellContact>, Vec<(u32, u32)>) {
    let mut contact = vec![CellContact::Separate; grid.len()];
    let mut pairs = Vec::new();
    for FacetContact { cell, facet, intersects } in facet_contacts(scene, grid, slack, sharing) {
        let m = &mut contact[cell as usize];
        if intersects {
            *m = CellContact::Intersected;
            pairs.push((cell, facet));
        } else if *m == CellContact::Separate {
            *m = CellContact::Touched;
        }
    }
    pairs.par_sort_unstable();
    (contact, pairs)
}

/// The contacts of all facets, by ascending facet.
fn facet_contacts(
    scene: &Scene,
    grid: &VoxelGrid,
    slack: f64,
    sharing: Option<&dyn WorkSharing>,
) -> Vec<FacetContact> {
    let of_facet = |k: usize| {
        let mut out = Vec::new();
        visit_cells(grid, &scene.facets()[k].plate, slack, |cell, intersects| {
            out.push(FacetContact { cell: cell as u32, facet: k as u32, intersects });
        });
        out
    };
    let count = scene.facets().len();
    let Some(sharing) = sharing else {
        return (0..count).into_par_iter().flat_map_iter(of_facet).collect();
    };
    let of_block = |b: usize| {
        let facets = b * FACETS_PER_BLOCK..((b + 1) * FACETS_PER_BLOCK).min(count);
        facets.flat_map(of_facet).map(|c| c.word()).collect()
    };
    let words = sharing.map_lists(count.div_ceil(FACETS_PER_BLOCK), &of_block);
    words.into_iter().flatten().map(FacetContact::from_word).collect()
}

/// The cells of the voxel grid whose interior facets cross, in ascending order.
pub fn crossed_cells(scene: &Scene, grid: &VoxelGrid) -> Vec<usize> {
    let mut cells: Vec<usize> =
        overlaps(scene, grid, 0.0, None).1.into_iter().map(|(cell, _)| cell as usize).collect();
    cells.dedup();
    cells
}

/// The sub-cells of a cell of the voxel grid that facets meet: bit (i·s + j)·s + k of s = [`SUBCELLS`] along each axis.
pub fn crossed_subcells(transport: &Transport, grid: &VoxelGrid, cell: usize) -> u64 {
    let (scene, lower) = (transport.scene(), grid.corner(grid.coordinates(cell)));
    let facets = transport.facets_overlapping(lower, lower + grid.cell());
    let edges = grid.cell() * (1.0 / SUBCELLS as f64);
    let half = edges * (0.5 + SKIN_SHARE_OF_CELL);
    let s = SUBCELLS;
    let meets = |k: usize| {
        let at = vec3((k / (s * s)) as f64 + 0.5, (k / s % s) as f64 + 0.5, (k % s) as f64 + 0.5);
        let centre = lower + edges.scale(at);
        facets.iter().any(|&f| overlaps_box(&scene.facets()[f as usize].plate, centre, half))
    };
    (0..s * s * s).filter(|&k| meets(k)).fold(0, |mask, k| mask | 1 << k)
}

/// Calls `each` with the cells that the plate meets and whether it intersects their interior. The cells are visited by columns along
/// the axis nearest to the normal; in each column the plate spans few cells.
fn visit_cells(grid: &VoxelGrid, plate: &Plate, slack: f64, mut each: impl FnMut(usize, bool)) {
    let (lo, hi) = plate.bounds();
    let (min, h, dims) = (grid.min(), grid.cell(), grid.dims());
    let range = |axis: usize, lo: f64, hi: f64| {
        let skin = SKIN_SHARE_OF_CELL + slack / h[axis];
        let a = ((lo - min[axis]) / h[axis] - skin).floor().max(0.0);
        let b = ((hi - min[axis]) / h[axis] + skin).floor().min(dims[axis] as f64 - 1.0);
        (a as usize, if b < a { None } else { Some(b as usize) })
    };
    let n = plate.normal();
    let m = (0..3).fold(0, |m, k| if n[k].abs() > n[m].abs() { k } else { m });
    let (p, q) = ((m + 1) % 3, (m + 2) % 3);
    let ((p0, Some(p1)), (q0, Some(q1))) = (range(p, lo[p], hi[p]), range(q, lo[q], hi[q])) else {
        return;
    };
    let grown = h * 0.5 + Vec3::splat(slack) + h * SKIN_SHARE_OF_CELL;
    let shrunk = h * (0.5 - SKIN_SHARE_OF_CELL) - Vec3::splat(slack);
    for i in p0..=p1 {
        for j in q0..=q1 {
            let mut c = [0; 3];
            (c[p], c[q]) = (i, j);
            let x = grid.centre(c);
            let rise = n[p] * (x[p] - plate.origin[p]) + n[q] * (x[q] - plate.origin[q]);
            let level = plate.origin[m] - rise / n[m];
            let spread = ((n[p] * grown[p]).abs() + (n[q] * grown[q]).abs()) / n[m].abs();
            let (bottom, top) = ((level - spread).max(lo[m]), (level + spread).min(hi[m]));
            let (k0, Some(k1)) = range(m, bottom, top) else {
                continue;
            };
            for k in k0..=k1 {
                c[m] = k;
                let centre = grid.centre(c);
                if overlaps_box(plate, centre, grown) {
                    each(grid.index(c), overlaps_box(plate, centre, shrunk));
                }
            }
        }
    }
}

/// True when the plate meets the closed box with this centre and these half edges, m.
fn overlaps_box(plate: &Plate, centre: Vec3, half: Vec3) -> bool {
    let (mut c, n) = plate.corners();
    c.iter_mut().for_each(|x| *x = *x - centre);
    let separated = |axis: Vec3| {
        let reach = half.x * axis.x.abs() + half.y * axis.y.abs() + half.z * axis.z.abs();
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        for x in &c[..n] {
            let y = axis.dot(*x);
            lo = lo.min(y);
            hi = hi.max(y);
        }
        lo > reach || hi < -reach
    };
    let axes = [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0)];
    if axes.iter().any(|a| separated(*a)) || separated(plate.normal()) {
        return false;
    }
    let edges = [plate.e1, plate.e2, plate.e2 - plate.e1];
    let edges = if plate.kind == PlateKind::Triangle { &edges[..] } else { &edges[..2] };
    !edges.iter().any(|e| axes.iter().any(|a| separated(e.normalized().cross(*a))))
}
