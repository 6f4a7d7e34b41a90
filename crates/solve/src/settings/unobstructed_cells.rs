//! Unobstructed cells of the voxel grid: cells that no facet cuts, with neither facet nor pane between one and the next.
//!
//! In a cube of (2r + 1)³ unobstructed cells fields are smooth, and sums over it need no traversal from cell to cell: a row of the cube is a
//! range of successive volume zones.

use std::ops::Range;
use zonal_math::parallel;
use zonal_scene::{VoxelGrid, Zones};
use zonal_transport::Transport;

/// Free passage between the volume zones of a voxel grid.
#[derive(Clone, Debug)]
pub(crate) struct UnobstructedCells<'a> {
    grid: &'a VoxelGrid,
    zones: &'a Zones,
    /// For each volume zone, bit k: the zone is a whole cell, and nothing lies between its centre and that of the next whole cell along axis k.
    free: Vec<u8>,
}

/// A row of cells of a cube, along the third axis.
pub(crate) struct CellRow {
    /// Indices into `zones.voxels`.
    pub zones: Range<usize>,
    /// Offset in cells from the centre of the cube along the first two axes.
    pub offset: [i32; 2],
}

impl<'a> UnobstructedCells<'a> {
    /// Tests all cells of a voxel grid.
    pub(crate) fn new(grid: &'a VoxelGrid, zones: &'a Zones, transport: &Transport) -> UnobstructedCells<'a> {
        let dims = grid.dims();
        let stride = [dims[1] * dims[2], dims[2], 1];
        let whole = |cell: usize| {
            let of = zones.voxel_zones_of_cell(cell);
            (of.len() == 1 && zones.voxels.at(of.start).samples.is_empty()).then(|| zones.voxels.at(of.start))
        };
        let bits = |i: usize| {
            let z = zones.voxels.at(i);
            let c = grid.coordinates(z.cell);
            let free = |k: &usize| {
                z.samples.is_empty()
                    && c[*k] + 1 < dims[*k]
                    && whole(z.cell + stride[*k])
                        .is_some_and(|next| !transport.separated_inside(z.centre, next.centre))
            };
            (0..3).filter(free).map(|k| 1 << k).sum()
        };
        UnobstructedCells { grid, zones, free: parallel::collect(zones.voxels.len(), bits) }
    }

    /// True if whole zone `z` is connected to the next whole cell along axis `k`.
    pub(crate) fn is_connected(&self, z: usize, k: usize) -> bool {
        self.free[z] >> k & 1 == 1
    }

    /// The rows of the cube of cells up to `reach` ≥ 1 away from volume zone `z` along each axis; `None` unless all of them are unobstructed and
    /// inside the grid.
    pub(crate) fn cube(
        &self,
        z: usize,
        reach: usize,
    ) -> Option<impl Iterator<Item = CellRow> + Clone + use<'a>> {
        let (c, dims, side) =
            (self.grid.coordinates(self.zones.voxels.at(z).cell), self.grid.dims(), 2 * reach + 1);
        if (0..3).any(|k| c[k] < reach || c[k] + reach >= dims[k]) {
            return None;
        }
        let (grid, zones) = (self.grid, self.zones);
        let rows = (0..side * side).map(move |n| {
            let (x, y) = (n / side, n % side);
            let cell = grid.index([c[0] + x - reach, c[1] + y - reach, c[2] - reach]);
            let of = zones.voxel_zones_of_cell(cell);
            let offset = [x as i32 - reach as i32, y as i32 - reach as i32];
            CellRow { zones: of.start..of.start + if of.len() == 1 { side } else { 0 }, offset }
        });
        // Connected cells are whole, so the cells of a connected row have successive zones.
        let holds = |row: CellRow| {
            let [x, y] = row.offset.map(|s| u8::from(s < reach as i32));
            let need = |z: usize| x | y << 1 | u8::from(z + 1 < row.zones.end) << 2;
            row.zones.len() == side
                && row.zones.clone().all(|z| self.free.get(z).is_some_and(|f| f & need(z) == need(z)))
        };
        rows.clone().all(holds).then_some(rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_transport::build_zones;

    /// A room of 9³ cells with a block and, on a face between cells, a sheet that cuts none.
    const ROOM: &str = "[solve]\npatch_size = 0.5\n[[surface]]\nname = \"room\"\nroom = { min = [0, 0, 0], max = [9, 9, 9] }\n\
        [[surface]]\nname = \"block\"\nbox = { min = [1.2, 1.2, 1.2], max = [3.6, 2.8, 2.6] }\n\
        [[surface]]\nname = \"sheet\"\nrectangle = { origin = [5, 4, 0], edge1 = [0, 5, 0], edge2 = [0, 0, 9] }\nsides = \"both\"\n\
        [medium]\nmin = [0, 0, 0]\nmax = [9, 9, 9]\ncells = [9, 9, 9]\nextinction = 0.1\nalbedo = 0.5\n";

    #[test]
    fn cubes_of_cells_are_unobstructed_away_from_facets() {
        let scene = zonal_io::input::parse_scene(ROOM, None, "room").unwrap();
        let transport = Transport::new(&scene);
        let zones = build_zones(&scene, &transport).unwrap();
        let grid = scene.voxel_grid().unwrap();
        let open = UnobstructedCells::new(grid, &zones, &transport);
        let mut found = [0; 2];
        for z in 0..zones.voxels.len() {
            let c = grid.coordinates(zones.voxels.at(z).cell).map(|c| c as i64);
            for reach in [1, 2] {
                let r = reach as i64;
                let near = |k: usize, lo: i64, hi: i64| c[k] + r >= lo && c[k] - r <= hi;
                let inside = (0..3).all(|k| c[k] >= r && c[k] + r < 9);
                // The block lies in the cells 1 to 3, 1 to 2, 1 to 2; the sheet between the cells 4 and 5 along x, from 4 on along y.
                let block = near(0, 1, 3) && near(1, 1, 2) && near(2, 1, 2);
                let sheet = c[0] - r <= 4 && c[0] + r >= 5 && c[1] + r >= 4;
                let cube = open.cube(z, reach);
                assert_eq!(cube.is_some(), inside && !block && !sheet, "{c:?} {reach}");
                let Some(rows) = cube else { continue };
                found[reach - 1] += 1;
                for row in rows {
                    for (z, step) in row.zones.zip(-r..) {
                        let want =
                            [c[0] + i64::from(row.offset[0]), c[1] + i64::from(row.offset[1]), c[2] + step];
                        assert_eq!(grid.coordinates(zones.voxels.at(z).cell).map(|c| c as i64), want);
                    }
                }
            }
        }
        assert!(found[0] > 50 && found[1] > 5, "{found:?}");
    }
}
