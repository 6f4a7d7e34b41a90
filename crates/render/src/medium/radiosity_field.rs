//! The indirect radiosity of the medium, smooth across voxels and sharp at walls.
//!
//! Each volume zone has a mean B_ind = B − Ω G_dir/4. Its value at each corner of its cell comes from [`crate::interpolation::node_interpolation`] over the
//! zones that touch the corner and are connected with it: the segment between the two centres is free. Away from facets these are
//! all eight. A zone without extinction in a band has no value in that band. Inside the cell the corners are interpolated
//! trilinearly, plus a correction Π 4x(1−x) that reproduces a whole voxel's own value at its centre. Corner values are computed on first use.

use super::many_lights::ManyLights;
use crate::interpolation::lazy_values::LazyValues;
use crate::interpolation::node_interpolation::{BandGradients, GradientFit, NodeZone, node_value};
use zonal_math::Vec3;
use zonal_scene::{Band, Bands, PerBand, Solution, VoxelGrid, VoxelZone, VoxelZones};
use zonal_transport::Transport;

/// A field that is evaluated at points of its cells.
pub(crate) struct RadiosityField<'a> {
    map: &'a VoxelGrid,
    zones: &'a VoxelZones,
    interpolation: CornerInterpolation<'a>,
    corners: LazyValues<[PerBand<f32>; 8]>,
}

impl<'a> RadiosityField<'a> {
    /// The field of a solution, with the far part of the light of `many_lights`; `None` without a medium.
    pub(crate) fn new(
        s: &'a Solution,
        transport: &'a Transport,
        many_lights: Option<ManyLights<'a>>,
    ) -> Option<RadiosityField<'a>> {
        let indirect = |(k, z): (usize, VoxelZone)| {
            let i = s.zones.voxel_index(k);
            s.fields.radiosity[i] - z.albedo * s.fields.direct_light(i) / 4.0
        };
        let means = s.zones.voxels.iter().enumerate().map(indirect).collect();
        let mut field = RadiosityField::from_means(s, transport, means)?;
        field.interpolation.many_lights = many_lights.map(|c| (c, LazyValues::new(s.zones.voxels.len())));
        Some(field)
    }

    /// Adds `more` to the mean of every voxel zone, W/m²; before the field is evaluated.
    pub(crate) fn add_radiosity(&mut self, more: impl Fn(usize) -> Bands) {
        self.interpolation.values.iter_mut().enumerate().for_each(|(i, v)| *v += more(i));
    }

    /// The emitters whose far part is in the field.
    pub(crate) fn many_lights(&self) -> Option<&ManyLights<'a>> {
        self.interpolation.many_lights.as_ref().map(|c| &c.0)
    }

    /// The field with these means, one per voxel zone, W/m²; negative means count as zero. `None` without a medium.
    pub(crate) fn from_means(
        s: &'a Solution,
        transport: &'a Transport,
        mut values: Vec<Bands>,
    ) -> Option<RadiosityField<'a>> {
        let map = s.scene.voxel_grid()?;
        values.iter_mut().flatten().for_each(|x| *x = x.max(0.0));
        let (corners, fits) = (LazyValues::new(values.len()), LazyValues::new(values.len()));
        let near_facet = cells_near_facets(s, map);
        let interpolation =
            CornerInterpolation { s, map, transport, values, near_facet, fits, many_lights: None };
        Some(RadiosityField { map, zones: &s.zones.voxels, interpolation, corners })
    }

    /// B_ind, W/m², at a point of the zone.
    pub(crate) fn at(&self, zone: usize, p: Vec3) -> Bands {
        let z = self.zones.at(zone);
        let (corner, cell) = (self.map.corner(self.map.coordinates(z.cell)), self.map.cell());
        let [x, y, w] = [0, 1, 2].map(|k| ((p[k] - corner[k]) / cell[k]).clamp(0.0, 1.0));
        let c = self.corners.get(zone, || self.interpolation.corner_values(zone));
        let bump =
            if z.samples.is_empty() { 64.0 * x * (1.0 - x) * y * (1.0 - y) * w * (1.0 - w) } else { 0.0 };
        let own = if bump > 0.0 { self.interpolation.value(zone) } else { Bands::ZERO };
        Bands::from_fn(|b| {
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
fn cells_near_facets(s: &Solution, map: &VoxelGrid) -> Vec<bool> {
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

/// Corner values of the cells.
struct CornerInterpolation<'a> {
    s: &'a Solution,
    map: &'a VoxelGrid,
    transport: &'a Transport<'a>,
    values: Vec<Bands>,
    /// Cells that a facet touches or runs along.
    near_facet: Vec<bool>,
    fits: LazyValues<VoxelFit>,
    /// Emitters of many facets and their far part at each zone.
    many_lights: Option<(ManyLights<'a>, LazyValues<Bands>)>,
}

/// The gradients of a zone, and the smallest and largest value among it and its neighbours, band by band.
type VoxelFit = (BandGradients, PerBand<(f64, f64)>);

/// A zone that is connected with another, and the corners of the other's cell that its cell touches: bit 4i + 2j + k.
type ConnectedZone = (u32, u8);

impl CornerInterpolation<'_> {
    /// The mean of a zone.
    fn value(&self, i: usize) -> Bands {
        let (own, Some((many_lights, far))) = (self.values[i], &self.many_lights) else {
            return self.values[i];
        };
        let far = far.get(i, || many_lights.far_radiosity(i, own));
        own + far
    }

    fn fit(&self, i: usize) -> &VoxelFit {
        self.fits.get(i, || self.fit_gradients(i))
    }

    /// The zone itself and the connected zones around it.
    fn connected(&self, i: usize) -> Vec<ConnectedZone> {
        let zones = &self.s.zones;
        let own = zones.voxels.at(i);
        let c = self.map.coordinates(own.cell);
        let dims = self.map.dims();
        let mut list = Vec::with_capacity(32);
        list.push((i as u32, u8::MAX));
        // Bit masks of the corners on the lower side, of all corners, and of those on the upper side of each axis.
        const CORNER_MASKS: [[u8; 3]; 3] = [[0x0f, 0xff, 0xf0], [0x33, 0xff, 0xcc], [0x55, 0xff, 0xaa]];
        for n in (0..27).filter(|n| *n != 13) {
            let d: [usize; 3] = [n / 9, n / 3 % 3, n % 3];
            if (0..3).any(|k| c[k] + d[k] == 0 || c[k] + d[k] > dims[k]) {
                continue;
            }
            let cell = self.map.index([0, 1, 2].map(|k| c[k] + d[k] - 1));
            let corners = CORNER_MASKS[0][d[0]] & CORNER_MASKS[1][d[1]] & CORNER_MASKS[2][d[2]];
            let free = !self.near_facet[cell] && !self.near_facet[own.cell];
            let seen = |j: usize| free || !self.transport.occluded(own.centre, zones.voxels.at(j).centre);
            list.extend(zones.voxel_zones_of_cell(cell).filter(|&j| seen(j)).map(|j| (j as u32, corners)));
        }
        list
    }

    fn fit_gradients(&self, i: usize) -> VoxelFit {
        let voxels = &self.s.zones.voxels;
        let list = self.connected(i);
        let mut fits = PerBand::<GradientFit>::default();
        let mut ranges = PerBand::splat((f64::INFINITY, f64::NEG_INFINITY));
        let own = self.value(i);
        for j in list.iter().map(|&(j, _)| j as usize) {
            let (from, to) = (voxels.at(i), voxels.at(j));
            let (d, value) = (to.centre - from.centre, self.value(j));
            for b in Band::all().filter(|&b| from.extinction[b] > 0.0 && to.extinction[b] > 0.0) {
                if j != i {
                    fits[b].add(d, value[b] - own[b]);
                }
                ranges[b] = (ranges[b].0.min(value[b]), ranges[b].1.max(value[b]));
            }
        }
        (fits.map(|f| f.gradient()), ranges)
    }

    fn corner_values(&self, i: usize) -> [PerBand<f32>; 8] {
        let voxels = &self.s.zones.voxels;
        let list = self.connected(i);
        let c = self.map.coordinates(voxels.at(i).cell);
        let whole = self.map.cell().product();
        let mut here: Vec<(VoxelZone, Bands, &VoxelFit)> = Vec::with_capacity(8);
        std::array::from_fn(|corner| {
            let at = [c[0] + (corner >> 2 & 1), c[1] + (corner >> 1 & 1), c[2] + (corner & 1)];
            let v = self.map.corner(at);
            here.clear();
            let touching = list.iter().filter(|n| n.1 >> corner & 1 == 1).map(|n| n.0 as usize);
            here.extend(touching.map(|j| (voxels.at(j), self.value(j), self.fit(j))));
            Bands::from_fn(|b| {
                let zones = here.iter().filter(|h| h.0.extinction[b] > 0.0).map(|(z, value, fit)| NodeZone {
                    weight: z.volume / whole + 1e-3,
                    centre: z.centre,
                    value: value[b],
                    gradient: fit.0[b],
                    range: fit.1[b],
                });
                node_value(v, zones).unwrap_or(0.0)
            })
            .map(|x| x as f32)
        })
    }
}
