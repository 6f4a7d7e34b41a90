//! One camera ray: where it ends, what it passes, what it sees.
//!
//! L = τ L_end + what the path adds: indirect emission and scattering of its pieces, panes, and shafts of direct light. L_end is
//! B/π of the surface point, with B = E(x) + ρ(x)(H + H_dir), zero on the black back of a one-sided surface, and the radiance
//! of surroundings and skies where there is no surface.

use crate::calm::calmed;
use crate::columns::{Columns, STEPS};
use crate::crowd::Crowds;
use crate::gather::Gather;
use crate::lamplight::Even;
use crate::patch_field::{PatchField, Tile};
use crate::path::{Path, Piece, emitted};
use crate::shadow::Shadows;
use crate::shafts::Shafts;
use crate::towards::Towards;
use crate::voxel_field::VoxelField;
use std::f64::consts::PI;
use zonal_math::{Vec3, sequence};
use zonal_scene::{Bands, Light, Plate, Sides, Solution, bands};
use zonal_transport::direct::{Lamp, Receiver, Source};
use zonal_transport::sheets::pane_sheets;
use zonal_transport::{Hit, PaneHit, Transport};

/// The two Gauss points on [0,1].
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// A sky takes this many times the samples of other lights: it fills the hemisphere.
const SKY: usize = 4;

/// A sun is wide from this angular diameter on, rad.
const NARROW: f64 = 0.1;
/// Where a sun may be hidden in part, it takes this many times the samples.
const SOFT: usize = 4;

/// A lamp that gives less than this share of the irradiance has one ray.
const FAINT: f64 = 0.04;
/// Places at which the medium is asked on the way to it.
const PLACES: usize = 4;
/// … and seldom one, if less than this.
const UNSEEN: f64 = 0.015;

/// Everything about a solution that rays ask for.
pub(crate) struct View<'a> {
    pub(crate) s: &'a Solution,
    pub(crate) transport: &'a Transport<'a>,
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
    /// For each lamp the depths towards it, where it is a sun without.
    depths: Vec<Option<Towards<'a>>>,
    shafts: Shafts<'a>,
    background: Bands,
    gather: Option<Gather<'a>>,
    /// True where lamps of many facets light surfaces about as they do.
    rough: bool,
}

/// Where a ray ends.
pub(crate) struct Seen {
    hit: Option<Hit>,
    /// Distance to the end, m; far outside where nothing is hit.
    end: f64,
    panes: Vec<PaneHit>,
}

impl Seen {
    /// Distance to the first pane, or to the end, m: before it there is but medium.
    pub(crate) fn front(&self) -> f64 {
        self.panes.first().map_or(self.end, |p| p.t)
    }
}

/// What the medium does before the first pane or surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Front {
    /// Length, m.
    pub t: f64,
    /// Radiance that it adds, W/(m² sr).
    pub glow: Bands,
    /// Transmittance.
    pub tau: Bands,
    /// Extinction at its end, 1/m.
    pub kappa: Bands,
    /// What a metre more would add at its end, not dimmed, without direct light, W/(m² sr)/m.
    pub source: Bands,
}

impl Front {
    /// Radiance of this front before a radiance at its end.
    pub(crate) fn before(&self, back: Bands) -> Bands {
        bands(|b| self.glow[b] + self.tau[b] * back[b])
    }
}

/// Which samples of the lights a ray takes: `first..first + count`, shifted.
#[derive(Clone, Copy)]
pub(crate) struct Draw {
    pub first: usize,
    pub count: usize,
    pub shift: [f64; 3],
    /// Steps along the ray for suns, at most, and how often they are taken.
    pub steps: usize,
    pub rounds: usize,
}

impl Draw {
    /// Of ray number `i` of a pixel of several.
    pub(crate) fn of_ray(i: usize, count: usize, shift: [f64; 3]) -> Draw {
        Draw { first: i * count, count, shift, steps: STEPS, rounds: 1 }
    }
}

impl Draw {
    /// The same ray's samples where each ray takes `n`.
    fn rescaled(&self, n: usize) -> Draw {
        Draw { first: self.first / self.count * n, count: n, ..*self }
    }
    fn at(&self, i: usize) -> [f64; 3] {
        sequence::r3(self.first + i, self.shift)
    }
    /// One more number in [0,1), of its own for each ray of the pixel.
    fn chance(&self) -> f64 {
        sequence::r1(self.first / self.count, (self.shift[0] * 4096.0 + self.shift[1]).fract())
    }
}

impl<'a> View<'a> {
    /// Prepares fields, lights and shadows.
    pub(crate) fn new(s: &'a Solution, transport: &'a Transport<'a>) -> View<'a> {
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
            voxels: VoxelField::new(s, transport, Crowds::new(s, transport, &lamps)),
            even: lamps.iter().map(|l| Even::new(scene, l)).collect(),
            columns: lamps.iter().map(|l| columns(transport, l)).collect(),
            depths: lamps.iter().map(|l| depths(transport, l)).collect(),
            lamps,
            shafts: Shafts { scene, transport, shadows: Shadows::new(scene), step },
            background,
            gather: None,
            rough: false,
        }
    }

    /// The same with lamps of many facets that light surfaces about as they do.
    pub(crate) fn roughly(mut self) -> View<'a> {
        self.rough = true;
        self
    }

    /// The same with indirect light of surfaces gathered by so many rays; 0: interpolated.
    pub(crate) fn gathering(mut self, rays: usize) -> View<'a> {
        self.gather = (rays > 0).then(|| Gather::new(self.s, self.transport, rays));
        self
    }

    /// The same with every lamp sampled only, to compare with.
    #[cfg(test)]
    pub(crate) fn sampled_only(mut self) -> View<'a> {
        self.even.fill_with(|| None);
        self.voxels = VoxelField::new(self.s, self.transport, None);
        self
    }

    #[cfg(test)]
    fn path_between(&self, from: Vec3, to: Vec3) -> Path {
        let way = to - from;
        self.path((from, way.normalized()), (0.0, way.length()), self.panes_between(from, to))
    }

    /// Direct light scattered between two points, from many samples; with the indirect light of the medium.
    #[cfg(test)]
    pub(crate) fn scattered(&self, from: Vec3, to: Vec3, count: usize) -> Bands {
        let (path, dir) = (self.path_between(from, to), (to - from).normalized());
        let direct = self.direct(from, dir, &path, Draw::of_ray(0, count, [0.3, 0.6, 0.9]));
        let medium = self.indirect(from, dir, &path);
        bands(|b| direct[b] + medium[b])
    }

    /// Light of suns by their columns, scattered between two points.
    #[cfg(test)]
    pub(crate) fn scattered_by_suns(&self, from: Vec3, to: Vec3, first: usize, shift: [f64; 3]) -> Bands {
        let dir = (to - from).normalized();
        let path = self.path_between(from, to);
        let one = |c: &Columns| c.scattered(&self.shafts, (from, dir), &path, (first, shift, STEPS));
        self.columns.iter().flatten().map(one).fold([0.0; 3], |s, l| bands(|b| s[b] + l[b]))
    }

    /// Light of one point of a lamp, scattered between two points.
    #[cfg(test)]
    pub(crate) fn scattered_exactly(&self, from: Vec3, to: Vec3, source: &Source) -> Bands {
        let dir = (to - from).normalized();
        self.shafts.scattered((from, dir), &self.path_between(from, to), source, None)
    }

    /// The scene.
    pub(crate) fn scene(&self) -> &'a zonal_scene::Scene {
        &self.s.scene
    }

    /// Where a ray ends, and the panes before.
    pub(crate) fn seen(&self, origin: Vec3, dir: Vec3) -> Seen {
        let hit = self.transport.nearest(origin, dir, 0.0, f64::INFINITY);
        let end = match &hit {
            Some(h) => h.t,
            None => (self.transport.beyond(origin, dir) - origin).length(),
        };
        let panes = self.panes_between(origin, origin + dir * end);
        Seen { hit, end, panes }
    }

    /// What the medium alone does up to `t` metres from the eye.
    pub(crate) fn front(&self, origin: Vec3, dir: Vec3, t: f64, draw: Draw) -> Front {
        let path = self.path((origin, dir), (0.0, t), Vec::new());
        let (medium, shafts) = (self.indirect(origin, dir, &path), self.direct(origin, dir, &path, draw));
        let last = path.pieces.last().filter(|p| p.t1 >= t * (1.0 - 1e-9));
        let kappa = last.map_or([0.0; 3], |p| p.kappa);
        let field = self.voxels.as_ref().zip(last).map(|(v, p)| v.at(p.zone, origin + dir * t));
        let source = field.map_or([0.0; 3], |f| bands(|b| kappa[b] * f[b] / PI));
        Front { t, glow: bands(|b| medium[b] + shafts[b]), tau: path.tau, kappa, source }
    }

    /// Radiance, W/(m² sr), that arrives where the front of a ray ends.
    pub(crate) fn back(&self, origin: Vec3, dir: Vec3, seen: &Seen, draw: Draw) -> Bands {
        let end = match &seen.hit {
            Some(h) => self.surface(h, origin + dir * h.t, draw),
            None => self.background,
        };
        if seen.panes.is_empty() {
            return end;
        }
        let path = self.path((origin, dir), (seen.front(), seen.end), seen.panes.clone());
        let (medium, shafts) = (self.indirect(origin, dir, &path), self.direct(origin, dir, &path, draw));
        bands(|b| path.tau[b] * end[b] + path.glow[b] + medium[b] + shafts[b])
    }

    /// Radiance, W/(m² sr), that arrives at `origin` from the unit direction `dir`.
    pub(crate) fn radiance(&self, origin: Vec3, dir: Vec3, draw: Draw) -> Bands {
        let seen = self.seen(origin, dir);
        self.front(origin, dir, seen.front(), draw).before(self.back(origin, dir, &seen, draw))
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
        let indirect = match &self.gather {
            Some(gather) => self.gathered(gather, point, normal, draw),
            None => self.patches.at(sheet, [hit.u, hit.v], point).unwrap_or([0.0; 3]),
        };
        let direct = self.irradiance(point, normal, indirect, draw);
        bands(|b| (emission[b] + rho[b] * (indirect[b] + direct[b])) / PI)
    }

    /// H_dir at a surface point that has H besides. Where all of a lamp of many facets would hardly show, one ray asks for it.
    fn irradiance(&self, point: Vec3, normal: Vec3, besides: Bands, draw: Draw) -> Bands {
        let mut sum = [0.0; 3];
        for (k, (lamp, columns)) in self.lamps.iter().zip(&self.columns).enumerate() {
            if columns.as_ref().is_some_and(|c| c.are_dark(point)) {
                continue;
            }
            let n = match lamp.light() {
                _ if lamp.is_single() => 1,
                Light::Sky { .. } => SKY * draw.count,
                _ => draw.count,
            };
            let partly = || columns.as_ref().is_some_and(|c| c.may_be_partly_lit(point, draw.shift));
            let own = draw.rescaled(if n > 1 && partly() { SOFT * n } else { n });
            let light = match self.towards(k) {
                Some(towards) => self.sunlight(lamp, towards, point, normal, &own),
                None if self.rough && lamp.is_crowd() => self.crowdlight(lamp, point, normal, besides, &own),
                None => lamp.gather_at(self.transport, point, Receiver::Surface(normal), n, |i| own.at(i)),
            };
            sum = bands(|b| sum[b] + light[b]);
        }
        sum
    }

    /// H_dir of a lamp of many facets, each cluster in its middle. Where even all of it would hardly show, one ray asks for it, and not
    /// always: with the chance p, and then counted 1/p times.
    fn crowdlight(&self, lamp: &Lamp, point: Vec3, normal: Vec3, besides: Bands, own: &Draw) -> Bands {
        let receiver = Receiver::Surface(normal);
        let most = lamp.estimate(point, receiver);
        let share = (0..3).fold(0.0, |s: f64, b| s.max(most[b] / besides[b].max(1e-300)));
        let (n, chance) = if share > FAINT { (own.count, 1.0) } else { (1, (share / UNSEEN).min(1.0)) };
        let mut sum = [0.0; 3];
        if own.chance() >= chance {
            return sum;
        }
        for i in 0..n {
            let beam = lamp.rough_beam(self.transport, point, receiver, own.at(i));
            let Some((beam, _)) = beam.filter(|b| !self.transport.blocked(point, b.0.end)) else {
                continue;
            };
            let depth = self.rough_depth(point, beam.end);
            sum = bands(|b| sum[b] + beam.flux[b] * (-depth[b]).exp() / (chance * n as f64));
        }
        sum
    }

    /// About the optical depth between two points: the extinction at a few places between them, and the panes.
    fn rough_depth(&self, a: Vec3, b: Vec3) -> Bands {
        let mut sum = self.transport.pane_depth_inside(a, b);
        if let Some(map) = self.s.scene.voxmap() {
            let part = (b - a).length() / PLACES as f64;
            for k in 0..PLACES {
                let at = map.cell_at(a + (b - a) * ((k as f64 + 0.5) / PLACES as f64));
                let kappa = at.map_or([0.0; 3], |c| map.extinction(map.index(c)));
                sum = bands(|i| sum[i] + kappa[i] * part);
            }
        }
        sum
    }

    /// Optical depths towards lamp number `k`, a sun that is not too wide for one direction to stand for all.
    fn towards(&self, k: usize) -> Option<&Towards<'a>> {
        let narrow = matches!(self.lamps[k].light(), Light::Sun { angular_diameter, .. } if *angular_diameter < NARROW);
        let depths = self.columns[k].as_ref().map(Columns::depths).or(self.depths[k].as_ref());
        depths.filter(|_| narrow)
    }

    /// H_dir of a sun at a surface point, with the medium's depth in the direction of its middle.
    fn sunlight(&self, lamp: &Lamp, towards: &Towards, point: Vec3, normal: Vec3, own: &Draw) -> Bands {
        let (mut sum, mut seen) = ([0.0; 3], false);
        for i in 0..own.count {
            let Some(beam) = lamp.beam(self.transport, point, Receiver::Surface(normal), own.at(i)) else {
                continue;
            };
            if self.transport.blocked(point, beam.end) {
                continue;
            }
            seen = true;
            let mut passed = [1.0; 3];
            self.transport.pane_crossings(point, beam.end, &mut |h| {
                let pane = &self.s.scene.panes()[h.pane];
                passed = bands(|b| passed[b] * (-pane.extinction[b] * pane.thickness / h.cos).exp());
            });
            sum = bands(|b| sum[b] + passed[b] * beam.flux[b] / own.count as f64);
        }
        if !seen {
            return sum;
        }
        let depth = towards.depth(point);
        bands(|b| sum[b] * (-depth[b]).exp())
    }

    pub(crate) fn panes_between(&self, a: Vec3, b: Vec3) -> Vec<PaneHit> {
        let mut panes = Vec::new();
        self.transport.pane_crossings(a, b, &mut |h| panes.push(h));
        panes
    }

    /// Pieces, panes and transmittance of a part of a ray.
    pub(crate) fn path(
        &self,
        (origin, dir): (Vec3, Vec3),
        (from, to): (f64, f64),
        panes: Vec<PaneHit>,
    ) -> Path {
        let mut cells = Vec::with_capacity(64);
        self.transport.walk(origin + dir * from, origin + dir * to, &mut |cell, t0, t1| {
            cells.push((cell, from + t0, from + t1));
        });
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

    fn pane(&self, path: &mut Path, hit: &PaneHit, point: Vec3) {
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
            if let Some(crowds) = field.crowds() {
                let near = crowds.near(origin, dir, p);
                (0..3).for_each(|b| out[b] += near[b]);
            }
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
        let crowds = self.voxels.as_ref().is_some_and(|v| v.crowds().is_some());
        for (k, (lamp, even)) in self.lamps.iter().zip(&self.even).enumerate() {
            if crowds && lamp.is_crowd() {
                continue;
            }
            if let Some(columns) = &self.columns[k] {
                for i in 0..draw.rounds {
                    let which = (draw.first * draw.rounds + i, draw.shift, draw.steps);
                    let light = columns.scattered(&self.shafts, (origin, dir), path, which);
                    (0..3).for_each(|b| out[b] += light[b] / draw.rounds as f64);
                }
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
                    let light = self.shafts.scattered((origin, dir), path, &source, self.depths[k].as_ref());
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

/// Optical depths towards a sun without extent.
fn depths<'a>(transport: &'a Transport<'a>, lamp: &Lamp) -> Option<Towards<'a>> {
    match lamp.source([0.0; 3])? {
        Source::Distant { towards, .. } if lamp.is_single() => Some(Towards::new(transport, towards)),
        _ => None,
    }
}

/// H of the patches without the noise that they tell of, interpolated.
fn surface_field<'a>(s: &Solution, transport: &'a Transport<'a>) -> PatchField<'a> {
    patch_field(s, transport, &calmed(&s.zones.patches, &s.fields.incident, &s.fields.error))
}

/// A field on the patches, interpolated; `values` has one entry a zone.
pub(crate) fn patch_field<'a>(
    s: &Solution,
    transport: &'a Transport<'a>,
    values: &[Bands],
) -> PatchField<'a> {
    let sheets: Vec<Plate> = s.scene.facets().iter().flat_map(|f| [f.plate, f.plate]).collect();
    let tiles = patch_tiles(s);
    let values = values[..tiles.len()].to_vec();
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
