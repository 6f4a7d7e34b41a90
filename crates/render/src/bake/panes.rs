//! Panes as triangles.
//!
//! Each piece of a pane is a regular grid of triangles with the radiosity of each group at its points, interpolated by
//! [`TileField`].

use super::baked::{PaneMesh, single_vector};
use super::group_fields::GroupField;
use crate::image::to_single_precision;
use crate::surface::patch_field::{TileField, TileTopology};
use crate::surface::tiles::pane_tiles;
use zonal_math::parallel;
use zonal_scene::{Bands, PlateKind, Solution};
use zonal_transport::patch_locator::pane_plates;

/// Largest number of points on panes, unless two intervals an edge need more.
const MAX_PANE_POINTS: usize = 200_000;

/// Intervals of an edge of a piece, fewer where there are many pieces: the field within a piece is curved, and linear interpolation
/// between a few points would miss its mean.
fn intervals_per_edge(pieces: usize) -> u32 {
    [8u32, 4].into_iter().find(|n| pieces * (*n as usize + 1).pow(2) <= MAX_PANE_POINTS).unwrap_or(2)
}

/// The points of a piece in its parameters, and the triangles between them, counter-clockwise.
fn triangulate_piece(kind: PlateKind, n: u32) -> (Vec<[f64; 2]>, Vec<[u32; 3]>) {
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
pub(super) fn mesh_panes(s: &Solution, groups: &[GroupField]) -> PaneMesh {
    let mut mesh = PaneMesh::default();
    let mut places = Vec::new();
    let n = intervals_per_edge(s.zones.panes.len());
    let [square, triangle] =
        [PlateKind::Parallelogram, PlateKind::Triangle].map(|kind| triangulate_piece(kind, n));
    for (i, z) in s.zones.panes.iter().enumerate() {
        let (points, triangles) = if z.plate.kind == PlateKind::Triangle { &triangle } else { &square };
        let first = mesh.positions.len() as u32;
        for &[u, v] in points {
            places.push((i, [u, v]));
            mesh.positions.push(single_vector(z.plate.at(u, v)));
            mesh.normals.push(single_vector(z.normal));
            mesh.panes.push(z.pane as u32);
            mesh.depth.push(to_single_precision(z.extinction * z.thickness));
            mesh.error.push(to_single_precision(s.fields.total_error(s.zones.pane_index(i))));
        }
        for t in triangles {
            mesh.triangles.push(t.map(|k| first + k));
            mesh.zones.push(s.zones.pane_index(i) as u32);
        }
    }
    let (_, _, of) = pane_plates(&s.scene, &s.zones);
    let topology = TileTopology::new(pane_tiles(s, &of), None);
    let field = |group: &GroupField| {
        let radiosity = |i: usize| group.radiosity(s.zones.pane_index(i));
        let values: Vec<Bands> = parallel::collect(s.zones.panes.len(), radiosity);
        let field = TileField::new(values);
        parallel::map(&places, |&(i, uv)| to_single_precision(field.at(&topology, i, uv)))
    };
    mesh.radiosity = groups.iter().map(field).collect();
    mesh
}
