//! One camera ray: where it ends, what it passes, what it sees.
//!
//! L = τ L_end + what the path adds: indirect emission and scattering of its pieces, panes, and shafts of direct light. L_end is
//! B/π of the surface point, with B = E(x) + ρ(x)(H + H_dir), zero on the black back of a one-sided surface, and the radiance
//! of surroundings and skies where there is no surface.

use crate::columns::Columns;
use crate::lamplight::Even;
use crate::patch_field::{PatchField, Tile};
use crate::path::{Path, Piece, emitted};
use crate::shadow::Shadows;
use crate::shafts::Shafts;
use crate::voxel_field::VoxelField;
use std::f64::consts::PI;
use zonal_math::{Vec3, sequence};
use zonal_scene::{Bands, Light, Plate, Sides, Solution, bands};
use zonal_transport::direct::{Lamp, Receiver, Source};
use zonal_transport::sheets::pane_sheets;
use zonal_transport::{Hit, Transport};

/// The two Gauss points on [0,1].
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// A sky takes this many times the samples of other lights: it fills the hemisphere.
const SKY: usize = 4;

/// Everything about a solution that rays ask for.
pub(crate) struct View<'a> {
    s: &'a Solution,
    transport: &'a Transport<'a>,
    patches: PatchField<'a>,
    panes: PatchField<'a>,
    /// Index of the first plate of each pane among all plates.
    pane_first: Vec<usize>,
    voxels: Option<VoxelField<'a>>,
    lamps: Vec<Lamp<'a>>,
    /// For each lamp what the medium needs of it where its light is known in closed form.
    even: Vec<Option<Even>>,
    /// For each lamp its columns, where it is a sun with an extent.
    columns: Vec<Option<Columns<'a>>>,
    shafts: Shafts<'a>,
    background: Bands,
}

/// Which samples of the lights a ray takes: `first..first + count`, shifted.
#[derive(Clone, Copy)]
pub(crate) struct Draw {
    pub first: usize,
    pub count: usize,
    pub shift: [f64; 3],
}

impl Draw {
    /// The same ray's samples where each ray takes `n`.
    fn rescaled(&self, n: usize) -> Draw {
        Draw { first: self.first / self.count * n, count: n, ..*self }
    }
    fn at(&self, i: usize) -> [f64; 3] {
        sequence::r3(self.first + i, self.shift)
    }
}

impl<'a> View<'a> {
    /// Prepares fields, lights and shadows.
    pub fn new(s: &'a Solution, transport: &'a Transport<'a>) -> View<'a> {
        let scene = &s.scene;
        let mut background = scene.surroundings().radiance;
        for light in scene.lights() {
            if let Light::Sky { radiance, .. } = light {
                background = bands(|b| background[b] + radiance[b]);
            }
        }
        let step = scene.voxmap().map_or(1.0, |v| 1.5 * v.cell().product().cbrt());
        let (panes, pane_first) = pane_field(s);
        let lamps: Vec<Lamp> = scene.lights().iter().map(|l| Lamp::new(scene, l)).collect();
        View {
            s,
            transport,
            patches: surface_field(s, transport),
            panes,
            pane_first,
            voxels: VoxelField::new(s, transport),
            even: lamps.iter().map(|l| Even::new(scene, l)).collect(),
            columns: lamps.iter().map(|l| columns(transport, l)).collect(),
            lamps,
            shafts: Shafts { scene, transport, shadows: Shadows::new(scene), step },
            background,
        }
    }

    /// The same with every lamp sampled only, to compare with.
    #[cfg(test)]
    pub fn sampled_only(mut self) -> View<'a> {
        self.even.fill_with(|| None);
        self
    }

    /// Direct light scattered between two points, from many samples.
    #[cfg(test)]
    pub fn scattered(&self, from: Vec3, to: Vec3, count: usize) -> Bands {
        let path = self.path(from, (to - from).normalized(), to);
        let (first, shift) = (0, [0.3, 0.6, 0.9]);
        self.direct(from, (to - from).normalized(), &path, Draw { first, count, shift })
    }

    /// Light of suns by their columns, scattered between two points.
    #[cfg(test)]
    pub fn scattered_by_suns(&self, from: Vec3, to: Vec3, first: usize, shift: [f64; 3]) -> Bands {
        let dir = (to - from).normalized();
        let path = self.path(from, dir, to);
        let one = |c: &Columns| c.scattered(&self.shafts, (from, dir), &path, (first, shift));
        self.columns.iter().flatten().map(one).fold([0.0; 3], |s, l| bands(|b| s[b] + l[b]))
    }

    /// Light of one point of a lamp, scattered between two points.
    #[cfg(test)]
    pub fn scattered_exactly(&self, from: Vec3, to: Vec3, source: &Source) -> Bands {
        let dir = (to - from).normalized();
        self.shafts.scattered(from, dir, &self.path(from, dir, to), source)
    }

    /// Radiance, W/(m² sr), that arrives at `origin` from the unit direction `dir`.
    pub fn radiance(&self, origin: Vec3, dir: Vec3, draw: Draw) -> Bands {
        let hit = self.transport.nearest(origin, dir, 0.0, f64::INFINITY);
        let end = match &hit {
            Some(h) => origin + dir * h.t,
            None => self.transport.beyond(origin, dir),
        };
        let path = self.path(origin, dir, end);
        let seen = match hit {
            Some(h) => self.surface(&h, origin + dir * h.t, draw),
            None => self.background,
        };
        let medium = self.indirect(origin, dir, &path);
        let shafts = self.direct(origin, dir, &path, draw);
        bands(|b| path.tau[b] * seen[b] + path.glow[b] + medium[b] + shafts[b])
    }

    /// Radiance of a surface point.
    fn surface(&self, hit: &Hit, point: Vec3, draw: Draw) -> Bands {
        let scene = &self.s.scene;
        let facet = &scene.facets()[hit.facet];
        if !hit.front && scene.surfaces()[facet.surface].sides == Sides::Front {
            return [0.0; 3];
        }
        let normal = if hit.front { facet.plate.normal() } else { -facet.plate.normal() };
        let point = facet.plate.at(hit.u, hit.v) * 0.5 + point * 0.5;
        let emission = scene.emission_at(hit.facet, hit.u, hit.v);
        let rho = scene.reflectance_at(hit.facet, hit.u, hit.v);
        if rho == [0.0; 3] {
            return emission.map(|e| e / PI);
        }
        let sheet = 2 * hit.facet + usize::from(!hit.front);
        let indirect = self.patches.at(sheet, [hit.u, hit.v], point).unwrap_or([0.0; 3]);
        let direct = self.irradiance(point, normal, draw);
        bands(|b| (emission[b] + rho[b] * (indirect[b] + direct[b])) / PI)
    }

    /// H_dir at a surface point.
    fn irradiance(&self, point: Vec3, normal: Vec3, draw: Draw) -> Bands {
        let mut sum = [0.0; 3];
        for (lamp, columns) in self.lamps.iter().zip(&self.columns) {
            if columns.as_ref().is_some_and(|c| c.are_dark(point)) {
                continue;
            }
            let n = match lamp.light() {
                _ if lamp.is_single() => 1,
                Light::Sky { .. } => SKY * draw.count,
                _ => draw.count,
            };
            let own = draw.rescaled(n);
            let light = lamp.gather_at(self.transport, point, Receiver::Surface(normal), n, |i| own.at(i));
            sum = bands(|b| sum[b] + light[b]);
        }
        sum
    }

    /// Pieces, panes and transmittance between the eye and the end.
    fn path(&self, origin: Vec3, dir: Vec3, end: Vec3) -> Path {
        let mut cells = Vec::new();
        self.transport.walk(origin, end, &mut |cell, t0, t1| cells.push((cell, t0, t1)));
        let mut panes = Vec::new();
        self.transport.pane_crossings(origin, end, &mut |h| panes.push(h));
        let mut path =
            Path { tau: [1.0; 3], pieces: Vec::with_capacity(cells.len() + panes.len()), ..Path::default() };
        let mut panes = panes.into_iter().peekable();
        for (cell, mut t0, t1) in cells {
            while let Some(p) = panes.next_if(|p| p.t < t1) {
                self.piece(&mut path, cell, (t0, p.t.max(t0)), origin, dir);
                t0 = p.t.max(t0);
                self.pane(&mut path, &p, origin + dir * p.t);
            }
            self.piece(&mut path, cell, (t0, t1), origin, dir);
        }
        panes.for_each(|p| self.pane(&mut path, &p, origin + dir * p.t));
        path
    }

    fn piece(&self, path: &mut Path, cell: usize, (t0, t1): (f64, f64), origin: Vec3, dir: Vec3) {
        if t1 <= t0 {
            return;
        }
        let Some(zone) = self.transport.zone_in(&self.s.zones, cell, origin + dir * (0.5 * (t0 + t1))) else {
            return;
        };
        let z = &self.s.zones.voxels[zone];
        path.pieces.push(Piece {
            t0,
            t1,
            zone,
            kappa: z.extinction,
            scatter: bands(|b| z.extinction[b] * z.albedo[b]),
            tau: path.tau,
        });
        if z.extinction != [0.0; 3] {
            (0..3).for_each(|b| path.tau[b] *= (-z.extinction[b] * (t1 - t0)).exp());
        }
    }

    fn pane(&self, path: &mut Path, hit: &zonal_transport::PaneHit, point: Vec3) {
        let pane = &self.s.scene.panes()[hit.pane];
        let plate = &pane.plates[hit.plate];
        let sheet = self.pane_first[hit.pane] + hit.plate;
        let radiosity = self.panes.at(sheet, plate.parameters(point), point).unwrap_or([0.0; 3]);
        for b in 0..3 {
            let passed = (-pane.extinction[b] * pane.thickness / hit.cos).exp();
            path.glow[b] += path.tau[b] * (1.0 - passed) * radiosity[b] / PI;
            path.tau[b] *= passed;
        }
    }

    /// Radiance of the medium without direct light.
    fn indirect(&self, origin: Vec3, dir: Vec3, path: &Path) -> Bands {
        let mut out = [0.0; 3];
        let Some(field) = &self.voxels else {
            return out;
        };
        for p in path.pieces.iter().filter(|p| p.kappa != [0.0; 3]) {
            let length = p.t1 - p.t0;
            let [x, y] = GAUSS.map(|g| field.at(p.zone, origin + dir * (p.t0 + g * length)));
            for b in 0..3 {
                let slope = (y[b] - x[b]) / (length * (GAUSS[1] - GAUSS[0]));
                let start = x[b] - slope * GAUSS[0] * length;
                out[b] += p.tau[b] * emitted(p.kappa[b], length, start, slope) / PI;
            }
        }
        out
    }

    /// Radiance of direct light scattered on the way.
    fn direct(&self, origin: Vec3, dir: Vec3, path: &Path, draw: Draw) -> Bands {
        let mut out = [0.0; 3];
        if path.pieces.iter().all(|p| p.scatter == [0.0; 3]) {
            return out;
        }
        for ((lamp, even), columns) in self.lamps.iter().zip(&self.even).zip(&self.columns) {
            if let Some(columns) = columns {
                let light = columns.scattered(&self.shafts, (origin, dir), path, (draw.first, draw.shift));
                (0..3).for_each(|b| out[b] += light[b]);
                continue;
            }
            let n = match lamp.light() {
                Light::Sun { .. } => 1,
                _ => draw.count.div_ceil(2),
            };
            let own = draw.rescaled(n);
            if let Some(even) = even {
                let points: Vec<Source> = (0..n).filter_map(|i| lamp.source(own.at(i))).collect();
                let light = even.scattered(&self.shafts, lamp, (origin, dir), path, &points);
                (0..3).for_each(|b| out[b] += light[b]);
                continue;
            }
            for i in 0..n {
                if let Some(source) = lamp.source(own.at(i)) {
                    let light = self.shafts.scattered(origin, dir, path, &source);
                    (0..3).for_each(|b| out[b] += light[b] / n as f64);
                }
            }
        }
        out
    }
}

/// The columns of a sun that has an extent; shadows of one without are exact otherwise.
fn columns<'a>(transport: &'a Transport<'a>, lamp: &Lamp) -> Option<Columns<'a>> {
    match (lamp.light(), lamp.source([0.0; 3])?) {
        (Light::Sun { direction, angular_diameter, .. }, Source::Distant { fluence, .. })
            if *angular_diameter > 0.0 =>
        {
            Some(Columns::new(transport, -*direction, *angular_diameter, fluence))
        }
        _ => None,
    }
}

/// H of the patches, interpolated.
fn surface_field<'a>(s: &Solution, transport: &'a Transport<'a>) -> PatchField<'a> {
    let sheets: Vec<Plate> = s.scene.facets().iter().flat_map(|f| [f.plate, f.plate]).collect();
    let tiles = patch_tiles(s);
    let values = s.fields.incident[..tiles.len()].to_vec();
    PatchField::new(tiles, values, &sheets, Some(transport))
}

/// The patches as tiles of sheets: sheet 2f is the front of facet f, 2f + 1 its back.
pub(crate) fn patch_tiles(s: &Solution) -> Vec<Tile> {
    let facets = s.scene.facets();
    let tile = |p: &zonal_scene::Patch| Tile {
        plate: p.plate,
        normal: p.normal,
        sheet: 2 * p.facet + usize::from(p.normal.dot(facets[p.facet].plate.normal()) < 0.0),
    };
    s.zones.patches.iter().map(tile).collect()
}

/// B of the panes, direct light included, interpolated; with the index of each pane's first plate.
fn pane_field(s: &Solution) -> (PatchField<'static>, Vec<usize>) {
    let (first, sheets, of) = pane_sheets(&s.scene, &s.zones);
    let tiles = pane_tiles(s, &of);
    let values = s.fields.radiosity[s.zones.pane_offset()..].to_vec();
    (PatchField::new(tiles, values, &sheets, None), first)
}

/// The pieces of panes as tiles of the plates `of` which they are cut.
pub(crate) fn pane_tiles(s: &Solution, of: &[usize]) -> Vec<Tile> {
    let tile =
        |(z, &sheet): (&zonal_scene::PaneZone, &usize)| Tile { plate: z.plate, normal: z.normal, sheet };
    s.zones.panes.iter().zip(of).map(tile).collect()
}
