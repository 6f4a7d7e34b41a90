//! Our zones averaged down to the cells of the tables.

use zonal_report::Failure;
use zonal_scene::Solution;

/// Mean over coarse cells of a field on fine rectangles or boxes: each fine zone is spread over the cells it overlaps.
struct CellMeans {
    shape: Vec<usize>,
    sum: Vec<f64>,
    weight: Vec<f64>,
}

impl CellMeans {
    fn new(shape: Vec<usize>) -> CellMeans {
        let n = shape.iter().product();
        CellMeans { shape, sum: vec![0.0; n], weight: vec![0.0; n] }
    }
    /// Adds a zone that spans `spans` (lower, upper in units of cells) on the last axes of the shape, below the index `head`.
    fn add(&mut self, head: usize, spans: &[(f64, f64)], value: f64) {
        let tail = &self.shape[self.shape.len() - spans.len()..].to_vec();
        let cells: usize = tail.iter().product();
        for cell in 0..cells {
            let mut rest = cell;
            let mut w = 1.0;
            for (k, &(lo, hi)) in spans.iter().enumerate().rev() {
                let i = (rest % tail[k]) as f64;
                rest /= tail[k];
                w *= (hi.min(i + 1.0) - lo.max(i)).max(0.0);
            }
            if w > 1e-9 {
                self.sum[head * cells + cell] += w * value;
                self.weight[head * cells + cell] += w;
            }
        }
    }
    fn means(&self) -> Vec<f64> {
        self.sum.iter().zip(&self.weight).map(|(s, w)| if *w > 0.0 { s / w } else { 0.0 }).collect()
    }
}

/// H on the walls (6×10×10), H on the block (6×4×4) and G (10×10×10), W/m².
pub(crate) type TableMeans = (Vec<f64>, Vec<f64>, Vec<f64>);

/// The means of a solution of one of the cubes.
pub(crate) fn cell_means(s: &Solution) -> Result<TableMeans, Failure> {
    let other =
        |what: &str| Failure::new(format!("{}: is none of the cubes of the tables: {what}", s.scene.name()));
    let mut walls = CellMeans::new(vec![6, 10, 10]);
    let mut block = CellMeans::new(vec![6, 4, 4]);
    let mut gas = CellMeans::new(vec![10, 10, 10]);
    let faces = ["x0", "x1", "y0", "y1", "z0", "z1"];
    for (i, p) in s.zones.patches.iter().enumerate() {
        let name = &s.scene.surfaces()[p.surface].name;
        let (lo, hi) = p.plate.bounds();
        let h = s.fields.incident[i].first();
        let is_block = name.starts_with("block");
        let n = p.normal.array();
        let axis = (0..3).max_by(|&a, &b| n[a].abs().total_cmp(&n[b].abs())).unwrap_or(0);
        let head = if is_block {
            2 * axis + (n[axis] > 0.0) as usize
        } else {
            faces.iter().position(|f| name.ends_with(f)).ok_or_else(|| other("a wall has another name"))?
        };
        let (origin, size, cells) =
            if is_block { ([0.4, 0.3, 0.2], [0.3, 0.3, 0.4], 4.0) } else { ([0.0; 3], [1.0; 3], 10.0) };
        let spans: Vec<(f64, f64)> = (0..3)
            .filter(|&k| k != axis)
            .map(|k| ((lo[k] - origin[k]) / size[k] * cells, (hi[k] - origin[k]) / size[k] * cells))
            .collect();
        if is_block { block.add(head, &spans, h) } else { walls.add(head, &spans, h) }
    }
    let map = s.scene.voxel_grid().ok_or_else(|| other("there is no medium"))?;
    for (k, z) in s.zones.voxels.iter().enumerate() {
        let c = map.coordinates(z.cell);
        let spans: Vec<(f64, f64)> = (0..3)
            .map(|a| {
                let n = map.dims()[a] as f64;
                (c[a] as f64 / n * 10.0, (c[a] + 1) as f64 / n * 10.0)
            })
            .collect();
        gas.add(0, &spans, s.fields.incident[s.zones.voxel_offset() + k].first());
    }
    Ok((walls.means(), block.means(), gas.means()))
}
