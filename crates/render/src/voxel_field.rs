//! The indirect radiosity of the medium, smooth across voxels and sharp at walls.
//!
//! Each volume zone has a mean B_ind = B − Ω G_dir/4. Its value at each corner of its cell is that of [`crate::fit`] over the zones
//! that touch the corner and are connected with it: the segment between the two centres is free. Where no facet comes near
//! that is all eight. A zone without extinction in a band says nothing about that band. Inside the cell the corners are
//! interpolated trilinearly, plus a correction Π 4x(1−x) that keeps a whole voxel's own value at its centre.

use crate::fit::{Fit, Slope, Touch, node_value};
use rayon::prelude::*;
use zonal_math::Vec3;
use zonal_scene::{Bands, Solution, VoxelZone, Voxmap, bands};
use zonal_transport::Transport;

/// The field, ready to be asked at points of its cells.
pub(crate) struct VoxelField<'a> {
    map: &'a Voxmap,
    zones: &'a [VoxelZone],
    values: Vec<Bands>,
    corners: Vec<[[f32; 3]; 8]>,
}

impl<'a> VoxelField<'a> {
    /// The field of a solution; `None` without a voxmap.
    pub fn new(s: &'a Solution, transport: &'a Transport) -> Option<VoxelField<'a>> {
        let map = s.scene.voxmap()?;
        let offset = s.zones.voxel_offset();
        let values: Vec<Bands> = s
            .zones
            .voxels
            .iter()
            .enumerate()
            .map(|(i, z)| {
                let (b, direct) = (s.fields.radiosity[offset + i], s.fields.direct[offset + i]);
                bands(|k| (b[k] - z.albedo[k] * direct[k] / 4.0).max(0.0))
            })
            .collect();
        let builder = Builder { s, map, transport, values: &values, near_facet: cells_near_facets(s, map) };
        let corners = builder.corners();
        Some(VoxelField { map, zones: &s.zones.voxels, values, corners })
    }

    /// B_ind, W/m², at a point of the zone.
    pub fn at(&self, zone: usize, p: Vec3) -> Bands {
        let z = &self.zones[zone];
        let (corner, cell) = (self.map.corner(self.map.coordinates(z.cell)), self.map.cell());
        let [x, y, w] = [0, 1, 2].map(|k| ((p[k] - corner[k]) / cell[k]).clamp(0.0, 1.0));
        let c = &self.corners[zone];
        let bump = if z.part.is_empty() { 64.0 * x * (1.0 - x) * y * (1.0 - y) * w * (1.0 - w) } else { 0.0 };
        bands(|b| {
            let lerp = |i: usize, j: usize, t: f64| c[i][b] as f64 * (1.0 - t) + c[j][b] as f64 * t;
            let (near, far) = (
                lerp(0, 4, x) * (1.0 - y) + lerp(2, 6, x) * y,
                lerp(1, 5, x) * (1.0 - y) + lerp(3, 7, x) * y,
            );
            let mean = (0..8).map(|i| c[i][b] as f64).sum::<f64>() / 8.0;
            (near * (1.0 - w) + far * w + bump * (self.values[zone][b] - mean)).max(0.0)
        })
    }
}

/// True for cells that a facet touches or runs along.
fn cells_near_facets(s: &Solution, map: &Voxmap) -> Vec<bool> {
    let mut near = vec![false; map.len()];
    let (cell, dims) = (map.cell(), map.dims());
    for f in s.scene.facets() {
        let (lo, hi) = f.plate.bounds();
        let n = f.plate.normal();
        let pad = 1e-6;
        let first = |k: usize| ((lo[k] - map.min()[k]) / cell[k] - pad).floor().max(0.0) as usize;
        let past = |k: usize| (((hi[k] - map.min()[k]) / cell[k] + pad).floor() + 1.0).max(0.0) as usize;
        let reach = 0.5 * (1.0 + pad) * (0..3).map(|k| n[k].abs() * cell[k]).sum::<f64>();
        for x in first(0)..past(0).min(dims[0]) {
            for y in first(1)..past(1).min(dims[1]) {
                for z in first(2)..past(2).min(dims[2]) {
                    let distance = n.dot(map.centre([x, y, z]) - f.plate.origin).abs();
                    if distance <= reach {
                        near[map.index([x, y, z])] = true;
                    }
                }
            }
        }
    }
    near
}

struct Builder<'a> {
    s: &'a Solution,
    map: &'a Voxmap,
    transport: &'a Transport<'a>,
    values: &'a [Bands],
    near_facet: Vec<bool>,
}

impl Builder<'_> {
    fn corners(&self) -> Vec<[[f32; 3]; 8]> {
        let n = self.values.len();
        let fits: Vec<(Slope, [(f64, f64); 3])> = (0..n).into_par_iter().map(|i| self.slope(i)).collect();
        (0..n).into_par_iter().map(|i| self.corner_values(i, &fits)).collect()
    }

    /// The zone itself and those around it that are connected with it.
    fn connected(&self, i: usize) -> Vec<u32> {
        let zones = &self.s.zones;
        let own = &zones.voxels[i];
        let c = self.map.coordinates(own.cell);
        let dims = self.map.dims();
        let mut list = vec![i as u32];
        for x in c[0].saturating_sub(1)..(c[0] + 2).min(dims[0]) {
            for y in c[1].saturating_sub(1)..(c[1] + 2).min(dims[1]) {
                for z in c[2].saturating_sub(1)..(c[2] + 2).min(dims[2]) {
                    let cell = self.map.index([x, y, z]);
                    if cell == own.cell {
                        continue;
                    }
                    let free = !self.near_facet[cell] && !self.near_facet[own.cell];
                    let seen = |j: usize| free || !self.transport.blocked(own.centre, zones.voxels[j].centre);
                    list.extend(zones.of_cell(cell).filter(|&j| seen(j)).map(|j| j as u32));
                }
            }
        }
        list
    }

    fn slope(&self, i: usize) -> (Slope, [(f64, f64); 3]) {
        let voxels = &self.s.zones.voxels;
        let list = self.connected(i);
        let mut fits = [Fit::default(); 3];
        let mut ranges = [(f64::INFINITY, f64::NEG_INFINITY); 3];
        for b in (0..3).filter(|&b| voxels[i].extinction[b] > 0.0) {
            for j in list.iter().map(|&j| j as usize).filter(|&j| voxels[j].extinction[b] > 0.0) {
                if j != i {
                    let d = voxels[j].centre - voxels[i].centre;
                    fits[b].add(d, self.values[j][b] - self.values[i][b]);
                }
                ranges[b] = (ranges[b].0.min(self.values[j][b]), ranges[b].1.max(self.values[j][b]));
            }
        }
        (fits.map(|f| f.slope()), ranges)
    }

    fn corner_values(&self, i: usize, fits: &[(Slope, [(f64, f64); 3])]) -> [[f32; 3]; 8] {
        let voxels = &self.s.zones.voxels;
        let list = self.connected(i);
        let c = self.map.coordinates(voxels[i].cell);
        let whole = self.map.cell().product();
        std::array::from_fn(|corner| {
            let at = [c[0] + (corner >> 2 & 1), c[1] + (corner >> 1 & 1), c[2] + (corner & 1)];
            let touches = |j: usize| {
                let d = self.map.coordinates(voxels[j].cell);
                (0..3).all(|k| d[k] == at[k] || d[k] + 1 == at[k])
            };
            let here: Vec<usize> = list.iter().map(|&j| j as usize).filter(|&j| touches(j)).collect();
            let v = self.map.corner(at);
            bands(|b| {
                let with = here.iter().filter(|&&j| voxels[j].extinction[b] > 0.0).map(|&j| Touch {
                    weight: voxels[j].volume / whole + 1e-3,
                    centre: voxels[j].centre,
                    value: self.values[j][b],
                    slope: fits[j].0[b],
                    range: fits[j].1[b],
                });
                node_value(v, with).unwrap_or(0.0)
            })
            .map(|x| x as f32)
        })
    }
}
