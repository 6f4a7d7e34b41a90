//! Where the medium is open: cells that no facet cuts, and no facet between one and the next.
//!
//! In a cube of (2r + 1)³ such cells fields are smooth, and sums over it need no walk from cell to cell: a row of the cube is a run of
//! volume zones that follow each other.

use rayon::prelude::*;
use std::ops::Range;
use zonal_scene::{VoxelZone, Voxmap, Zones};
use zonal_transport::Transport;

/// What is open about each volume zone.
#[derive(Clone, Debug)]
pub struct Open<'a> {
    map: &'a Voxmap,
    zones: &'a Zones,
    /// For each volume zone, bit k: whole, and nothing between its centre and that of the whole next cell along axis k.
    free: Vec<u8>,
}

/// A row of a cube: its volume zones, and how far its cells lie from the middle along the first two axes.
pub struct Row {
    /// Indices into `zones.voxels`.
    pub zones: Range<usize>,
    /// Steps from the middle.
    pub steps: [i32; 2],
}

impl<'a> Open<'a> {
    /// Looks at all cells of the scene's voxmap.
    pub fn new(map: &'a Voxmap, zones: &'a Zones, transport: &Transport) -> Open<'a> {
        let dims = map.dims();
        let stride = [dims[1] * dims[2], dims[2], 1];
        let whole = |cell: usize| {
            let of = zones.of_cell(cell);
            (of.len() == 1 && zones.voxels[of.start].part.is_empty()).then(|| &zones.voxels[of.start])
        };
        let bits = |z: &VoxelZone| {
            let c = map.coordinates(z.cell);
            let free = |k: &usize| {
                z.part.is_empty()
                    && c[*k] + 1 < dims[*k]
                    && whole(z.cell + stride[*k])
                        .is_some_and(|next| !transport.blocked_inside(z.centre, next.centre))
            };
            (0..3).filter(free).map(|k| 1 << k).sum()
        };
        Open { map, zones, free: zones.voxels.par_iter().map(bits).collect() }
    }

    /// True where one can pass from whole zone `z` to the whole cell next along axis `k`.
    pub fn leads_on(&self, z: usize, k: usize) -> bool {
        self.free[z] >> k & 1 == 1
    }

    /// The rows of the cells up to `reach` ≥ 1 steps from volume zone `z` along each axis, itself among them; `None` unless all of them
    /// are open and lie in the grid.
    pub fn cube(&self, z: usize, reach: usize) -> Option<impl Iterator<Item = Row> + Clone + use<'a>> {
        let (c, dims, side) =
            (self.map.coordinates(self.zones.voxels[z].cell), self.map.dims(), 2 * reach + 1);
        if (0..3).any(|k| c[k] < reach || c[k] + reach >= dims[k]) {
            return None;
        }
        let (map, zones) = (self.map, self.zones);
        let rows = (0..side * side).map(move |n| {
            let (x, y) = (n / side, n % side);
            let cell = map.index([c[0] + x - reach, c[1] + y - reach, c[2] - reach]);
            let of = zones.of_cell(cell);
            let steps = [x as i32 - reach as i32, y as i32 - reach as i32];
            Row { zones: of.start..of.start + if of.len() == 1 { side } else { 0 }, steps }
        });
        // A cell whose neighbour leads on to it is whole, so cells of a row that lead on have zones that follow each other.
        let holds = |row: Row| {
            let [x, y] = row.steps.map(|s| u8::from(s < reach as i32));
            let need = |z: usize| x | y << 1 | u8::from(z + 1 < row.zones.end) << 2;
            row.zones.len() == side
                && row.zones.clone().all(|z| self.free.get(z).is_some_and(|f| f & need(z) == need(z)))
        };
        rows.clone().all(holds).then_some(rows)
    }
}
