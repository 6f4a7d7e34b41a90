//! Panes as triangles, and the medium on its grid.
//!
//! A cell's values are means over its zones j by volume, B = Σ B_j V_j / Σ V_j; with the free volume V = Σ V_j the sums of κBV and κGV over
//! the cells are those over the zones, since κ is one number a cell.

use super::share::Share;
use super::{BakedMedium, PaneMesh, single};
use crate::march::pane_tiles;
use crate::patch_field::{Layer, Shape};
use rayon::prelude::*;
use zonal_scene::{Bands, PlateKind, Solution, bands};
use zonal_transport::sheets::pane_sheets;

/// The most points on panes, unless two parts of an edge are more.
const POINTS: usize = 200_000;

/// Parts of an edge of a piece, fewer where there are many pieces: the field within one is a curve, and straight lines between a few
/// points would miss its mean.
fn parts_of(pieces: usize) -> u32 {
    [8u32, 4].into_iter().find(|n| pieces * (*n as usize + 1).pow(2) <= POINTS).unwrap_or(2)
}

/// The points of a piece in its parameters, and the triangles between them, counter-clockwise.
fn parts(kind: PlateKind, n: u32) -> (Vec<[f64; 2]>, Vec<[u32; 3]>) {
    let inside = |i: u32, j: u32| kind == PlateKind::Parallelogram || i + j <= n;
    let cells = (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j)));
    let places: Vec<(u32, u32)> = cells.filter(|(i, j)| inside(*i, *j)).collect();
    let at = |i: u32, j: u32| places.iter().position(|p| *p == (i, j)).map(|k| k as u32);
    let mut triangles = Vec::new();
    for &(i, j) in &places {
        let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        match corners {
            [Some(a), Some(b), Some(c), Some(d)] => triangles.extend([[a, b, d], [b, c, d]]),
            [Some(a), Some(b), None, Some(d)] => triangles.push([a, b, d]),
            _ => {}
        }
    }
    (places.iter().map(|&(i, j)| [i, j].map(|k| k as f64 / n as f64)).collect(), triangles)
}

/// The panes.
pub(super) fn panes(s: &Solution, shares: &[Share]) -> PaneMesh {
    let offset = s.zones.pane_offset();
    let mut mesh = PaneMesh::default();
    let mut places = Vec::new();
    let n = parts_of(s.zones.panes.len());
    let [square, triangle] = [PlateKind::Parallelogram, PlateKind::Triangle].map(|kind| parts(kind, n));
    for (i, z) in s.zones.panes.iter().enumerate() {
        let (points, triangles) = if z.plate.kind == PlateKind::Triangle { &triangle } else { &square };
        let first = mesh.positions.len() as u32;
        for &[u, v] in points {
            places.push((i, [u, v]));
            mesh.positions.push(single(z.plate.at(u, v)));
            mesh.normals.push(single(z.normal));
            mesh.panes.push(z.pane as u32);
            mesh.depth.push(z.extinction.map(|k| (k * z.thickness) as f32));
            mesh.error.push(s.fields.error_of_all(offset + i).map(|x| x as f32));
        }
        for t in triangles {
            mesh.triangles.push(t.map(|k| first + k));
            mesh.zones.push((offset + i) as u32);
        }
    }
    let (_, _, of) = pane_sheets(&s.scene, &s.zones);
    let shape = Shape::new(pane_tiles(s, &of), None);
    let field = |share: &Share| {
        let values: Vec<Bands> =
            (0..s.zones.panes.len()).into_par_iter().map(|i| share.radiosity(offset + i)).collect();
        let layer = Layer::new(values);
        places.par_iter().map(|&(i, uv)| layer.at(&shape, i, uv).map(|x| x as f32)).collect()
    };
    mesh.radiosity = shares.iter().map(field).collect();
    mesh
}

/// The medium, where there is one.
pub(super) fn medium(s: &Solution, shares: &[Share]) -> Option<BakedMedium> {
    let (map, zones) = (s.scene.voxmap()?, &s.zones);
    let offset = zones.voxel_offset();
    let cells = map.len();
    let volume = |c: usize| zones.of_cell(c).map(|i| zones.voxels[i].volume).sum::<f64>();
    let mean = |c: usize, value: &(dyn Fn(usize) -> Bands + Sync)| {
        let whole = volume(c);
        let mut sum = [0.0; 3];
        for i in zones.of_cell(c) {
            let (x, share) = (value(i), zones.voxels[i].volume / whole);
            sum = bands(|b| sum[b] + share * x[b]);
        }
        sum.map(|x| x as f32)
    };
    let grid = |value: &(dyn Fn(usize) -> Bands + Sync)| -> Vec<[f32; 3]> {
        (0..cells).into_par_iter().map(|c| mean(c, value)).collect()
    };
    Some(BakedMedium {
        min: map.min(),
        cell: map.cell(),
        dims: map.dims(),
        volume: (0..cells).into_par_iter().map(|c| volume(c) as f32).collect(),
        extinction: grid(&|i| zones.voxels[i].extinction),
        albedo: grid(&|i| zones.voxels[i].albedo),
        radiosity: shares.iter().map(|g| grid(&|i| g.radiosity(offset + i))).collect(),
        fluence: shares.iter().map(|g| grid(&|i| g.fluence(offset + i))).collect(),
    })
}
