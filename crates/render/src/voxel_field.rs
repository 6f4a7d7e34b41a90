//! The indirect radiosity of the medium, smooth across voxels and sharp at walls.
//!
//! Each volume zone has a mean B_ind = B − Ω G_dir/4. Its value at each corner of its cell is that of [`crate::fit`] over the zones
//! that touch the corner and are connected with it: the segment between the two centres is free. Where no facet comes near
//! that is all eight. A zone without extinction in a band says nothing about that band. Inside the cell the corners are
//! interpolated trilinearly, plus a correction Π 4x(1−x) that keeps a whole voxel's own value at its centre.

use crate::crowd::Crowds;
use crate::fit::{Fit, Slope, Touch, node_value};
use crate::lazy::Lazy;
use zonal_math::Vec3;
use zonal_scene::{Bands, Solution, VoxelZone, Voxmap, bands};
use zonal_transport::Transport;

/// The field, ready to be asked at points of its cells.
pub(crate) struct VoxelField<'a> {
    map: &'a Voxmap,
    zones: &'a [VoxelZone],
    builder: Builder<'a>,
    corners: Lazy<[[f32; 3]; 8]>,
}

impl<'a> VoxelField<'a> {
    /// The field of a solution, with the smooth part of the light of `crowds`; `None` without a voxmap.
    pub(crate) fn new(
        s: &'a Solution,
        transport: &'a Transport,
        crowds: Option<Crowds<'a>>,
    ) -> Option<VoxelField<'a>> {
        let offset = s.zones.voxel_offset();
        let rest = |(i, z): (usize, &VoxelZone)| {
            let (b, direct) = (s.fields.radiosity[offset + i], s.fields.direct[offset + i]);
            bands(|k| b[k] - z.albedo[k] * direct[k] / 4.0)
        };
        let mut field = VoxelField::of(s, transport, s.zones.voxels.iter().enumerate().map(rest).collect())?;
        field.builder.crowds = crowds.map(|c| (c, Lazy::new(s.zones.voxels.len())));
        Some(field)
    }

    /// The lamps whose light is in the field, but for what is close to them.
    pub(crate) fn crowds(&self) -> Option<&Crowds<'a>> {
        self.builder.crowds.as_ref().map(|c| &c.0)
    }

    /// The field with these means, one a voxel zone, W/m²; those below zero count as zero. `None` without a voxmap.
    pub(crate) fn of(
        s: &'a Solution,
        transport: &'a Transport,
        mut values: Vec<Bands>,
    ) -> Option<VoxelField<'a>> {
        let map = s.scene.voxmap()?;
        values.iter_mut().flatten().for_each(|x| *x = x.max(0.0));
        let (corners, fits) = (Lazy::new(values.len()), Lazy::new(values.len()));
        let builder =
            Builder { s, map, transport, values, near_facet: cells_near_facets(s, map), fits, crowds: None };
        Some(VoxelField { map, zones: &s.zones.voxels, builder, corners })
    }

    /// B_ind, W/m², at a point of the zone.
    pub(crate) fn at(&self, zone: usize, p: Vec3) -> Bands {
        let z = &self.zones[zone];
        let (corner, cell) = (self.map.corner(self.map.coordinates(z.cell)), self.map.cell());
        let [x, y, w] = [0, 1, 2].map(|k| ((p[k] - corner[k]) / cell[k]).clamp(0.0, 1.0));
        let c = self.corners.get(zone, || self.builder.corner_values(zone));
        let bump = if z.part.is_empty() { 64.0 * x * (1.0 - x) * y * (1.0 - y) * w * (1.0 - w) } else { 0.0 };
        let own = if bump > 0.0 { self.builder.value(zone) } else { [0.0; 3] };
        bands(|b| {
            let lerp = |i: usize, j: usize, t: f64| c[i][b] as f64 * (1.0 - t) + c[j][b] as f64 * t;
            let (near, far) = (
                lerp(0, 4, x) * (1.0 - y) + lerp(2, 6, x) * y,
                lerp(1, 5, x) * (1.0 - y) + lerp(3, 7, x) * y,
            );
            let mean = (0..8).map(|i| c[i][b] as f64).sum::<f64>() / 8.0;
            (near * (1.0 - w) + far * w + bump * (own[b] - mean)).max(0.0)
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
    values: Vec<Bands>,
    near_facet: Vec<bool>,
    fits: Lazy<Fitted>,
    crowds: Option<(Crowds<'a>, Lazy<Bands>)>,
}

/// The gradient of a zone, and the smallest and largest value among it and its neighbours, a band.
type Fitted = (Slope, [(f64, f64); 3]);

/// A zone that is connected with another, and the corners of the other's cell that its cell touches: bit 4i + 2j + k.
type Neighbour = (u32, u8);

impl Builder<'_> {
    /// The mean of a zone.
    fn value(&self, i: usize) -> Bands {
        let (own, Some((crowds, more))) = (self.values[i], &self.crowds) else {
            return self.values[i];
        };
        let more = more.get(i, || crowds.far(i, own));
        bands(|b| own[b] + more[b])
    }

    fn fit(&self, i: usize) -> &Fitted {
        self.fits.get(i, || self.slope(i))
    }

    /// The zone itself and those around it that are connected with it.
    fn connected(&self, i: usize) -> Vec<Neighbour> {
        let zones = &self.s.zones;
        let own = &zones.voxels[i];
        let c = self.map.coordinates(own.cell);
        let dims = self.map.dims();
        let mut list = Vec::with_capacity(32);
        list.push((i as u32, u8::MAX));
        // Corners on the lower side, all, and on the upper side of each axis.
        const SIDES: [[u8; 3]; 3] = [[0x0f, 0xff, 0xf0], [0x33, 0xff, 0xcc], [0x55, 0xff, 0xaa]];
        for n in (0..27).filter(|n| *n != 13) {
            let d: [usize; 3] = [n / 9, n / 3 % 3, n % 3];
            if (0..3).any(|k| c[k] + d[k] == 0 || c[k] + d[k] > dims[k]) {
                continue;
            }
            let cell = self.map.index([0, 1, 2].map(|k| c[k] + d[k] - 1));
            let corners = SIDES[0][d[0]] & SIDES[1][d[1]] & SIDES[2][d[2]];
            let free = !self.near_facet[cell] && !self.near_facet[own.cell];
            let seen = |j: usize| free || !self.transport.blocked(own.centre, zones.voxels[j].centre);
            list.extend(zones.of_cell(cell).filter(|&j| seen(j)).map(|j| (j as u32, corners)));
        }
        list
    }

    fn slope(&self, i: usize) -> Fitted {
        let voxels = &self.s.zones.voxels;
        let list = self.connected(i);
        let mut fits = [Fit::default(); 3];
        let mut ranges = [(f64::INFINITY, f64::NEG_INFINITY); 3];
        let own = self.value(i);
        for j in list.iter().map(|&(j, _)| j as usize) {
            let (d, value) = (voxels[j].centre - voxels[i].centre, self.value(j));
            for b in (0..3).filter(|&b| voxels[i].extinction[b] > 0.0 && voxels[j].extinction[b] > 0.0) {
                if j != i {
                    fits[b].add(d, value[b] - own[b]);
                }
                ranges[b] = (ranges[b].0.min(value[b]), ranges[b].1.max(value[b]));
            }
        }
        (fits.map(|f| f.slope()), ranges)
    }

    fn corner_values(&self, i: usize) -> [[f32; 3]; 8] {
        let voxels = &self.s.zones.voxels;
        let list = self.connected(i);
        let c = self.map.coordinates(voxels[i].cell);
        let whole = self.map.cell().product();
        let mut here: Vec<(&VoxelZone, Bands, &Fitted)> = Vec::with_capacity(8);
        std::array::from_fn(|corner| {
            let at = [c[0] + (corner >> 2 & 1), c[1] + (corner >> 1 & 1), c[2] + (corner & 1)];
            let v = self.map.corner(at);
            here.clear();
            let touching = list.iter().filter(|n| n.1 >> corner & 1 == 1).map(|n| n.0 as usize);
            here.extend(touching.map(|j| (&voxels[j], self.value(j), self.fit(j))));
            bands(|b| {
                let with = here.iter().filter(|h| h.0.extinction[b] > 0.0).map(|(z, value, fit)| Touch {
                    weight: z.volume / whole + 1e-3,
                    centre: z.centre,
                    value: value[b],
                    slope: fit.0[b],
                    range: fit.1[b],
                });
                node_value(v, with).unwrap_or(0.0)
            })
            .map(|x| x as f32)
        })
    }
}
