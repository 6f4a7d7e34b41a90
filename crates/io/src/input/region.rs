//! `[[medium.region]]`: boxes, densities from files, and the insides of closed meshes.

use super::build::Builder;
use super::density::Filling;
use super::error::InputError;
use super::medium::{Grid, MATTER, Matter};
use super::mesh::{closed, place as placed};
use super::node::Node;
use super::{arrays, density, shapes};
use zonal_math::Vec3;
use zonal_scene::{Bands, Plate};

/// Reads one region and fills it in.
pub(crate) fn read_region(node: &Node<'_>, grid: &mut Grid, b: &mut Builder<'_>) -> Result<(), InputError> {
    let mut known = vec!["box", "mesh", "density"];
    known.extend(MATTER);
    let t = node.table(&known)?;
    let matter = Matter::read(&t, b)?;
    let mut place = grid.bounds();
    let cells = match (t.get("box"), t.get("mesh"), t.get("density")) {
        (Some(n), None, None) => {
            let (min, max) = shapes::bounds(&n, &[])?;
            place = (min, max);
            grid.fill_box(min, max, &matter)
        }
        (None, Some(n), None) => {
            let (mesh, _) = placed::load(&n, b)?;
            let plates: Vec<Plate> = mesh.faces.iter().map(|f| f.plate).collect();
            closed::check_closed(&plates).map_err(|what| n.error(what))?;
            fill_inside(grid, &plates, &matter)
        }
        (None, None, Some(n)) => {
            if let Some(e) = t.get("extinction").or_else(|| t.get("absorption")) {
                return Err(e.error(
                    "a density brings its own extinction; remove this key and set density.scale and albedo",
                ));
            }
            let smoke = |k: Bands| density::smoke(&matter, k);
            density::read_density(&n, grid, &Filling::plain(&smoke), b)?
        }
        (None, None, None) if arrays::given(&t) => {
            if let Some(n) = MATTER.iter().filter_map(|k| t.get(k)).find(|n| !n.is_table()) {
                return Err(n.error(
                    "a region without a shape has arrays alone, and a number fills nothing; write box = { min, max }, or move this key to [medium]",
                ));
            }
            1
        }
        _ => {
            return Err(node.error("this region needs exactly one shape; write one of box, mesh, density"));
        }
    };
    if cells == 0 {
        return Err(node.error(
            "this region fills no cell of the medium; move it inside, enlarge it, or use smaller cells",
        ));
    }
    arrays::read_arrays(&t, grid, place, b)
}

/// Fills the cells whose centre lies inside closed plates; gives their number.
pub(crate) fn fill_inside(grid: &mut Grid, plates: &[Plate], matter: &Matter) -> usize {
    let [nx, ny, nz] = grid.dims;
    // A hair off the centre, so that no line runs along an edge of a mesh drawn on the grid.
    let (hx, hy) = (0.5 + 1.234e-7, 0.5 + 2.718e-7);
    let x_of = |i: usize| grid.min.x + (i as f64 + hx) * grid.cell.x;
    let y_of = |j: usize| grid.min.y + (j as f64 + hy) * grid.cell.y;
    let mut columns: Vec<Vec<(f64, i32)>> = vec![Vec::new(); nx * ny];
    let triangles = plates.iter().flat_map(|p| {
        let (c, n) = p.corners();
        (1..n - 1).map(move |k| [c[0], c[k], c[k + 1]])
    });
    for t in triangles {
        let [a, b, c] = t;
        let (lo, hi) = (a.min(b).min(c), a.max(b).max(c));
        let range = |lo: f64, hi: f64, min: f64, size: f64, n: usize| {
            let clamp = |x: f64| x.clamp(0.0, n as f64) as usize;
            clamp(((lo - min) / size).floor() - 1.0)..clamp(((hi - min) / size).ceil() + 1.0)
        };
        let up = (b - a).cross(c - a).z;
        if up == 0.0 {
            continue;
        }
        for i in range(lo.x, hi.x, grid.min.x, grid.cell.x, nx) {
            for j in range(lo.y, hi.y, grid.min.y, grid.cell.y, ny) {
                if let Some(z) = height(t, x_of(i), y_of(j)) {
                    columns[i * ny + j].push((z, if up > 0.0 { 1 } else { -1 }));
                }
            }
        }
    }
    let mut filled = 0;
    for (column, crossings) in columns.iter_mut().enumerate() {
        crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
        // The winding number says how many bodies a point lies in, whichever way they look.
        let (mut winding, mut next) = (0, 0);
        for k in 0..nz {
            let z = grid.min.z + (k as f64 + 0.5) * grid.cell.z;
            while next < crossings.len() && crossings[next].0 <= z {
                winding += crossings[next].1;
                next += 1;
            }
            if winding != 0 {
                grid.fill([column / ny, column % ny, k], 1.0, matter);
                filled += 1;
            }
        }
    }
    filled
}

/// Where the vertical line at (x, y) meets a triangle. An edge shared by two triangles belongs to exactly one of them,
/// because each edge is judged from its smaller end.
fn height([a, b, c]: [Vec3; 3], x: f64, y: f64) -> Option<f64> {
    let side = |p: Vec3, q: Vec3| {
        let swap = (q.x, q.y) < (p.x, p.y);
        let (p, q) = if swap { (q, p) } else { (p, q) };
        let s = (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x);
        (s >= 0.0) != swap
    };
    let s = side(a, b);
    if s != side(b, c) || s != side(c, a) {
        return None;
    }
    let n = (b - a).cross(c - a);
    Some(a.z - (n.x * (x - a.x) + n.y * (y - a.y)) / n.z)
}
