//! Which facets pass through which cells.
//!
//! A convex plate and a box are apart if and only if they are apart along one of the box's axes, the plate's normal, or the cross
//! product of an edge with a box's axis (separating axes). A facet that lies in a cell's face touches the closed box but not one
//! that is smaller by 10⁻⁹ of its size; it does not cut the cell.

use rayon::prelude::*;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Plate, PlateKind, Scene, Voxmap};

/// Share of a cell by which boxes are shrunk or grown.
const SKIN: f64 = 1e-9;

/// How a cell is met by facets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Met {
    /// By none.
    Not,
    /// In its faces only.
    Touched,
    /// Inside.
    Cut,
}

/// How each cell is met, and the (cell, facet) pairs of the cut ones in ascending order.
pub(super) fn overlaps(scene: &Scene, map: &Voxmap, slack: f64) -> (Vec<Met>, Vec<(u32, u32)>) {
    let mut met = vec![Met::Not; map.len()];
    let found: Vec<(u32, u32, bool)> = scene
        .facets()
        .par_iter()
        .enumerate()
        .flat_map_iter(|(k, f)| {
            let mut out = Vec::new();
            through(map, &f.plate, slack, |cell, cuts| {
                out.push((cell as u32, k as u32, cuts));
            });
            out
        })
        .collect();
    let mut pairs = Vec::new();
    for (cell, facet, cuts) in found {
        let m = &mut met[cell as usize];
        if cuts {
            *m = Met::Cut;
            pairs.push((cell, facet));
        } else if *m == Met::Not {
            *m = Met::Touched;
        }
    }
    pairs.par_sort_unstable();
    (met, pairs)
}

/// Calls `each` with the cells that the plate meets and whether it cuts them. Columns of cells along the axis nearest to the
/// normal are taken one by one; in each the plate's height spans few cells.
fn through(map: &Voxmap, plate: &Plate, slack: f64, mut each: impl FnMut(usize, bool)) {
    let (lo, hi) = plate.bounds();
    let (min, h, dims) = (map.min(), map.cell(), map.dims());
    let range = |axis: usize, lo: f64, hi: f64| {
        let skin = SKIN + slack / h[axis];
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
    let grown = h * 0.5 + Vec3::splat(slack) + h * SKIN;
    let shrunk = h * (0.5 - SKIN) - Vec3::splat(slack);
    for i in p0..=p1 {
        for j in q0..=q1 {
            let mut c = [0; 3];
            (c[p], c[q]) = (i, j);
            let x = map.centre(c);
            let rise = n[p] * (x[p] - plate.origin[p]) + n[q] * (x[q] - plate.origin[q]);
            let level = plate.origin[m] - rise / n[m];
            let spread = ((n[p] * grown[p]).abs() + (n[q] * grown[q]).abs()) / n[m].abs();
            let (bottom, top) = ((level - spread).max(lo[m]), (level + spread).min(hi[m]));
            let (k0, Some(k1)) = range(m, bottom, top) else {
                continue;
            };
            for k in k0..=k1 {
                c[m] = k;
                let centre = map.centre(c);
                if overlap(plate, centre, grown) {
                    each(map.index(c), overlap(plate, centre, shrunk));
                }
            }
        }
    }
}

/// True when the plate meets the closed box with this centre and these half edges.
pub(super) fn overlap(plate: &Plate, centre: Vec3, half: Vec3) -> bool {
    let (mut c, n) = plate.corners();
    c.iter_mut().for_each(|x| *x = *x - centre);
    let apart = |axis: Vec3| {
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
    if axes.iter().any(|a| apart(*a)) || apart(plate.normal()) {
        return false;
    }
    let edges = [plate.e1, plate.e2, plate.e2 - plate.e1];
    let edges = if plate.kind == PlateKind::Triangle { &edges[..] } else { &edges[..2] };
    !edges.iter().any(|e| axes.iter().any(|a| apart(e.normalized().cross(*a))))
}
