//! What a walker meets: facets, cells of the medium, panes, the images of a periodic scene, and the backs of what touches.

use crate::Dice;
use crate::judge::space::{clip, walk};
use crate::judge::tree::{Met, Tree};
use zonal_math::{Vec3, vec3};
use zonal_scene::{Plate, Scene, Sides};

/// Points nearer than this share of the scene's diagonal coincide.
const NEAR: f64 = 1e-9;
/// Points nearer than this share of the diagonal to a facet in front of them lie under it.
const UNDER: f64 = 1e-7;
/// Points by which the free part of a cell is measured.
const SAMPLES: usize = 1000;
/// Points along an edge of a facet by which its free area is measured.
const GRID: usize = 64;
/// Images after which a flight in an empty periodic scene is given up.
const IMAGES: usize = 1_000_000;

/// Which surfaces enclose something.
#[derive(Clone, Debug, Default)]
pub struct Closed {
    /// Of each surface, whether it is a part of a closed mesh or solid.
    pub surfaces: Vec<bool>,
    /// True where a closed mesh with its fronts inward surrounds all that counts: there is nothing outside.
    pub room: bool,
}

/// How a flight ends.
#[derive(Clone, Copy, Debug)]
pub enum End {
    /// At nothing.
    Escaped,
    /// At a facet.
    Facet(Met, Vec3),
    /// In a cell of the medium.
    Cell(usize, Vec3),
    /// In a pane: its index, that of the plate among all plates of panes, and where.
    Pane(usize, usize, Vec3),
}

/// Where a flight begins.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// Position, m.
    pub at: Vec3,
    /// Facet that it lies on.
    pub facet: Option<u32>,
    /// Index of a pane's plate that it lies in, and the depth in it, m.
    pub pane: Option<(usize, f64)>,
}

/// A scene for walkers.
pub struct Ground<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The plates of all panes, and the pane of each.
    pub plates: Vec<(usize, Plate)>,
    facets: Tree,
    panes: Tree,
    closed: Option<Tree>,
    enclosing: &'a Closed,
    near: f64,
    size: f64,
}

impl<'a> Ground<'a> {
    /// Builds the trees.
    pub fn new(scene: &'a Scene, enclosing: &'a Closed) -> Ground<'a> {
        let (lo, hi) = scene.bounds();
        let size = scene.diagonal() + lo.max_abs().max(hi.max_abs());
        let plates: Vec<(usize, Plate)> = (scene.panes().iter().enumerate())
            .flat_map(|(k, p)| p.plates.iter().map(move |q| (k, *q)))
            .collect();
        let facets = || (0u32..).zip(scene.facets());
        let whole = |s: usize| scene.surfaces()[s].solid || enclosing.surfaces.get(s) == Some(&true);
        let any = facets().any(|(_, f)| whole(f.surface));
        let closed = Tree::new(facets().filter(|(_, f)| whole(f.surface)).map(|(k, f)| (k, f.plate)), size);
        Ground {
            scene,
            facets: Tree::new(facets().map(|(k, f)| (k, f.plate)), size),
            panes: Tree::new((0u32..).zip(plates.iter().map(|p| p.1)), size),
            plates,
            closed: any.then_some(closed),
            enclosing,
            near: NEAR * scene.diagonal(),
            size: scene.diagonal(),
        }
    }

    /// True where no facet lies between two points.
    pub fn sees(&self, a: Vec3, b: Vec3) -> bool {
        let r = (b - a).length();
        r <= self.near || !self.facets.any(a, (b - a) / r, 0.0..r, [None; 2])
    }

    /// True where a point lies outside all solids, and in the room if there is one: a ray from it leaves through as many backs as fronts,
    /// or meets one front more.
    pub fn free(&self, p: Vec3, dice: &mut Dice) -> bool {
        let Some(tree) = &self.closed else { return true };
        let wanted = if self.enclosing.room { -1 } else { 0 };
        let votes = (0..3).filter(|_| {
            let all = tree.all(p, dice.direction(), 0.0..f64::INFINITY);
            all.iter().map(|m| if m.front { -1 } else { 1 }).sum::<i32>() == wanted
        });
        votes.count() >= 2
    }

    /// True where a front at this point is covered by what stands on it.
    pub fn covered(&self, at: Vec3, normal: Vec3, facet: u32) -> bool {
        if self.closed.is_none() {
            return false;
        }
        let h = UNDER * self.size;
        let met = self.facets.nearest(at - normal * h, normal, 0.0..2.0 * h, Some(facet));
        met.is_some_and(|m| {
            let f = &self.scene.facets()[m.id as usize];
            !m.front && self.scene.surfaces()[f.surface].sides == Sides::Front
        })
    }

    /// The area of each surface, both sides where both take part, without what is covered by solids that touch it, m².
    pub fn areas(&self, seed: u64) -> Vec<f64> {
        let mut dice = Dice::new(seed);
        let mut out = vec![0.0; self.scene.surfaces().len()];
        for (k, f) in (0u32..).zip(self.scene.facets()) {
            let both = self.scene.surfaces()[f.surface].sides == Sides::Both;
            for normal in [f.plate.normal(), -f.plate.normal()].into_iter().take(1 + usize::from(both)) {
                let mut seen = GRID * GRID;
                if self.closed.is_some() {
                    let at = |i: usize, dice: &mut Dice| (i as f64 + dice.roll()) / GRID as f64;
                    seen = (0..GRID * GRID)
                        .filter(|i| {
                            let [u, v] = f.plate.warp([at(i / GRID, &mut dice), at(i % GRID, &mut dice)]);
                            !self.covered(f.plate.at(u, v), normal, k)
                        })
                        .count();
                }
                out[f.surface] += f.plate.area() * seen as f64 / (GRID * GRID) as f64;
            }
        }
        out
    }

    /// The free volume of each cell, m³.
    pub fn volumes(&self, seed: u64) -> Vec<f64> {
        let Some(map) = self.scene.voxmap() else { return Vec::new() };
        let mut dice = Dice::new(seed);
        let edge = map.cell();
        let mut free = |c: usize| {
            if self.closed.is_none() {
                return 1.0;
            }
            let lo = map.corner(map.coordinates(c));
            let inside = (0..SAMPLES)
                .filter(|_| {
                    let p = dice.in_box(lo, lo + edge);
                    self.free(p, &mut dice)
                })
                .count();
            inside as f64 / SAMPLES as f64
        };
        (0..map.len()).map(|c| free(c) * edge.product()).collect()
    }

    /// Flies from `start` along the unit vector `d` in band `b` until the optical depth `tau` is spent or something is met. `track` is told
    /// of every length in a cell (index, m) and, with an index beyond all cells, in a pane.
    pub fn fly(
        &self,
        start: &Start,
        d: Vec3,
        b: usize,
        tau: f64,
        track: &mut impl FnMut(Place, f64),
    ) -> End {
        let (mut o, mut rest, mut skip) = (start.at, tau, start.facet);
        if let Some((plate, height)) = start.pane {
            let (pane, q) = self.plates[plate];
            let (p, cos) = (&self.scene.panes()[pane], q.normal().dot(d));
            let way = if cos > 0.0 { p.thickness - height } else { height } / cos.abs().max(1e-12);
            if let Some(end) = self.through(pane, plate, o, way, b, &mut rest, track) {
                return end;
            }
        }
        let periodic = self.scene.periodic();
        for _ in 0..IMAGES {
            let met = self.facets.nearest(o, d, self.near..f64::INFINITY, skip);
            let mut limit = met.map_or(f64::INFINITY, |m| m.t);
            let mut leaves = None;
            if periodic != [false; 3]
                && let Some(map) = self.scene.voxmap()
            {
                for k in (0..3).filter(|&k| periodic[k] && d[k] != 0.0) {
                    let face = if d[k] > 0.0 { map.max()[k] } else { map.min()[k] };
                    let t = ((face - o[k]) / d[k]).max(0.0);
                    if t < limit {
                        (limit, leaves) = (t, Some(k));
                    }
                }
                // Beyond the box across the other axes there is nothing.
                for k in (0..3).filter(|&k| !periodic[k] && d[k] != 0.0) {
                    let face = if d[k] > 0.0 { map.max()[k] } else { map.min()[k] };
                    if ((face - o[k]) / d[k]) < limit - self.near {
                        leaves = None;
                    }
                }
            }
            if let Some(end) = self.stretch(o, d, limit, b, &mut rest, track) {
                return end;
            }
            match (leaves, met) {
                (Some(k), _) => {
                    let Some(map) = self.scene.voxmap() else { return End::Escaped };
                    let mut p = (o + d * limit).array();
                    p[k] = if d[k] > 0.0 { map.min()[k] } else { map.max()[k] };
                    (o, skip) = (Vec3::from_array(p), None);
                }
                (None, Some(met)) if met.t <= limit => return End::Facet(met, o + d * met.t),
                _ => return End::Escaped,
            }
        }
        End::Escaped
    }

    /// Cells and panes up to a distance.
    fn stretch(
        &self,
        o: Vec3,
        d: Vec3,
        limit: f64,
        b: usize,
        rest: &mut f64,
        track: &mut impl FnMut(Place, f64),
    ) -> Option<End> {
        let mut from = 0.0;
        if !self.panes.is_empty() {
            for met in self.panes.all(o, d, self.near..limit - self.near) {
                if let Some(end) = self.cells(o, d, [from, met.t], b, rest, track) {
                    return Some(end);
                }
                let plate = met.id as usize;
                let (pane, q) = self.plates[plate];
                let way = self.scene.panes()[pane].thickness / q.normal().dot(d).abs().max(1e-12);
                let at = o + d * met.t;
                if let Some(end) = self.through(pane, plate, at, way, b, rest, track) {
                    return Some(end);
                }
                from = met.t;
            }
        }
        self.cells(o, d, [from, limit], b, rest, track)
    }

    #[allow(clippy::too_many_arguments)]
    fn through(
        &self,
        pane: usize,
        plate: usize,
        at: Vec3,
        way: f64,
        b: usize,
        rest: &mut f64,
        track: &mut impl FnMut(Place, f64),
    ) -> Option<End> {
        let kappa = self.scene.panes()[pane].extinction[b];
        if kappa * way > *rest {
            track(Place::Pane(pane, plate, at), *rest / kappa);
            return Some(End::Pane(pane, plate, at));
        }
        track(Place::Pane(pane, plate, at), way);
        *rest -= kappa * way;
        None
    }

    fn cells(
        &self,
        o: Vec3,
        d: Vec3,
        [from, to]: [f64; 2],
        b: usize,
        rest: &mut f64,
        track: &mut impl FnMut(Place, f64),
    ) -> Option<End> {
        let map = self.scene.voxmap()?;
        let (from, to) = clip(map, o, d, from, to)?;
        let mut end = None;
        walk(map, o, d, from, to, |cell, a, z| {
            let kappa = map.extinction(cell)[b];
            if kappa * (z - a) > *rest {
                let way = *rest / kappa;
                track(Place::Cell(cell, o + d * (a + 0.5 * way)), way);
                end = Some(End::Cell(cell, o + d * (a + way)));
                return false;
            }
            track(Place::Cell(cell, o + d * (0.5 * (a + z))), z - a);
            *rest -= kappa * (z - a);
            true
        });
        end
    }

    /// Centre and radius of a ball around the scene, m.
    pub fn ball(&self) -> (Vec3, f64) {
        let (lo, hi) = self.scene.bounds();
        ((lo + hi) * 0.5, 0.501 * (hi - lo).length() + vec3(self.near, 0.0, 0.0).x)
    }
}

/// Where a length was flown.
#[derive(Clone, Copy, Debug)]
pub enum Place {
    /// In a cell; its middle.
    Cell(usize, Vec3),
    /// In a pane: index, plate, and where.
    Pane(usize, usize, Vec3),
}
