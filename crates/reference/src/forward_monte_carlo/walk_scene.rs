//! Flights of random walks through facets, cells of the medium, panes and the images of a periodic scene.

use crate::path_tracer::bvh::{BinaryBvh, RayHit};
use crate::path_tracer::flight::{clip_to_grid, traverse_grid};
use crate::rng::Rng;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Band, Plate, Scene, Sides};

/// Points nearer than this fraction of the scene's diagonal coincide.
const COINCIDENCE_SHARE_OF_DIAGONAL: f64 = 1e-9;
/// A facet is covered where another lies face to face within this fraction of the scene's diagonal.
const COVER_SHARE_OF_DIAGONAL: f64 = 1e-7;
/// Sample points that measure the free volume of a cell.
const VOLUME_SAMPLES: usize = 1000;
/// Sample points along an edge of a facet that measure its free area.
const AREA_SAMPLES_PER_SIDE: usize = 64;
/// Images after which a flight in an empty periodic scene is abandoned.
const MAX_IMAGES: usize = 1_000_000;

/// The closed surfaces of a scene.
#[derive(Clone, Debug, Default)]
pub struct ClosedSurfaces {
    /// For each surface, whether it belongs to a closed mesh or solid.
    pub surfaces: Vec<bool>,
    /// True where a closed mesh with inward fronts encloses the whole problem: there is nothing outside.
    pub room: bool,
}

/// The end of a flight.
#[derive(Clone, Copy, Debug)]
pub(super) enum WalkEnd {
    /// The ray leaves the scene.
    Escaped,
    /// At a facet: position, and the length of the flight, m.
    Facet(RayHit, Vec3, f64),
    /// At a collision in a cell of the medium.
    Cell(usize, Vec3),
    /// At a collision in a pane: index of the pane, index of its plate among all pane plates, position.
    Pane(usize, usize, Vec3),
}

/// The start of a flight.
#[derive(Clone, Copy, Debug)]
pub(super) struct WalkStart {
    /// Position, m.
    pub at: Vec3,
    /// The facet that holds the point.
    pub facet: Option<u32>,
    /// The pane plate that holds the point, and the depth in the pane, m.
    pub pane: Option<(usize, f64)>,
}

/// The location of a flown length.
#[derive(Clone, Copy, Debug)]
pub(super) enum TrackLocation {
    /// In a cell; the middle of the length.
    Cell(usize, Vec3),
    /// In a pane: index of the pane, position.
    Pane(usize, Vec3),
}

/// The remaining optical depth of a flight in a band, and the callback for its lengths.
struct FlightTracker<'t, F> {
    band: Band,
    rest: f64,
    track: &'t mut F,
}

/// A scene prepared for random walks.
pub(super) struct WalkScene<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The plates of all panes, and the pane of each.
    pub plates: Vec<(usize, Plate)>,
    facets: BinaryBvh,
    panes: BinaryBvh,
    closed: Option<BinaryBvh>,
    enclosing: &'a ClosedSurfaces,
    near: f64,
    size: f64,
}

impl<'a> WalkScene<'a> {
    /// Builds the trees.
    pub(super) fn new(scene: &'a Scene, enclosing: &'a ClosedSurfaces) -> WalkScene<'a> {
        let (lo, hi) = scene.bounds();
        let size = scene.diagonal() + lo.max_abs().max(hi.max_abs());
        let plates: Vec<(usize, Plate)> = (scene.panes().iter().enumerate())
            .flat_map(|(k, p)| p.plates.iter().map(move |q| (k, *q)))
            .collect();
        let facets = || (0u32..).zip(scene.facets());
        let is_closed = |s: usize| scene.surfaces()[s].solid || enclosing.surfaces.get(s) == Some(&true);
        let any = facets().any(|(_, f)| is_closed(f.surface));
        let closed_facets = facets().filter(|(_, f)| is_closed(f.surface)).map(|(k, f)| (k, f.plate));
        let closed = BinaryBvh::new(closed_facets, size);
        WalkScene {
            scene,
            facets: BinaryBvh::new(facets().map(|(k, f)| (k, f.plate)), size),
            panes: BinaryBvh::new((0u32..).zip(plates.iter().map(|p| p.1)), size),
            plates,
            closed: any.then_some(closed),
            enclosing,
            near: COINCIDENCE_SHARE_OF_DIAGONAL * scene.diagonal(),
            size: scene.diagonal(),
        }
    }

    /// True where no facet lies between two points.
    pub(super) fn visible(&self, a: Vec3, b: Vec3) -> bool {
        let r = (b - a).length();
        r <= self.near || !self.facets.any(a, (b - a) / r, 0.0..r, [None; 2])
    }

    /// True where a point lies outside all solids, and in the room if there is one: a ray from it leaves through as many backs as
    /// fronts, or, in a room, hits one front more. Three random directions vote.
    pub(super) fn is_free(&self, p: Vec3, rng: &mut Rng) -> bool {
        let Some(tree) = &self.closed else { return true };
        let wanted = if self.enclosing.room { -1 } else { 0 };
        let votes = (0..3).filter(|_| {
            let all = tree.all(p, rng.unit_vector(), 0.0..f64::INFINITY);
            all.iter().map(|m| if m.front { -1 } else { 1 }).sum::<i32>() == wanted
        });
        votes.count() >= 2
    }

    /// True where a front at this point is covered: another front lies on it, face to face.
    pub(super) fn is_covered(&self, at: Vec3, normal: Vec3, facet: u32) -> bool {
        if self.closed.is_none() {
            return false;
        }
        let h = COVER_SHARE_OF_DIAGONAL * self.size;
        let hit = self.facets.nearest(at - normal * h, normal, 0.0..2.0 * h, Some(facet));
        hit.is_some_and(|m| m.front)
    }

    /// True where a front at this point exchanges with nothing: it is covered, or lies in a solid that crosses it.
    pub(super) fn is_excluded(&self, at: Vec3, normal: Vec3, facet: u32) -> bool {
        if self.closed.is_none() {
            return false;
        }
        let p = at + normal * (COVER_SHARE_OF_DIAGONAL * self.size);
        let seed = p.array().into_iter().fold(0u64, |s, x| s.rotate_left(21) ^ x.to_bits());
        self.is_covered(at, normal, facet) || !self.is_free(p, &mut Rng::new(seed))
    }

    /// The area of each surface, both sides where both exchange, without the part that solids cover, m².
    pub(super) fn areas(&self, seed: u64) -> Vec<f64> {
        let mut rng = Rng::new(seed);
        let n = AREA_SAMPLES_PER_SIDE;
        let mut out = vec![0.0; self.scene.surfaces().len()];
        for (k, f) in (0u32..).zip(self.scene.facets()) {
            let two_sided = self.scene.surfaces()[f.surface].sides == Sides::Both;
            let sides = [f.plate.normal(), -f.plate.normal()];
            for normal in sides.into_iter().take(1 + usize::from(two_sided)) {
                let mut free = n * n;
                if self.closed.is_some() {
                    let at = |i: usize, rng: &mut Rng| (i as f64 + rng.uniform()) / n as f64;
                    free = (0..n * n)
                        .filter(|i| {
                            let [u, v] = f.plate.warp([at(i / n, &mut rng), at(i % n, &mut rng)]);
                            !self.is_excluded(f.plate.at(u, v), normal, k)
                        })
                        .count();
                }
                out[f.surface] += f.plate.area() * free as f64 / (n * n) as f64;
            }
        }
        out
    }

    /// The free volume of each cell, m³.
    pub(super) fn volumes(&self, seed: u64) -> Vec<f64> {
        let Some(grid) = self.scene.voxel_grid() else { return Vec::new() };
        let mut rng = Rng::new(seed);
        let edge = grid.cell();
        let mut free_share = |c: usize| {
            if self.closed.is_none() {
                return 1.0;
            }
            let lo = grid.corner(grid.coordinates(c));
            let free = (0..VOLUME_SAMPLES)
                .filter(|_| {
                    let p = rng.point_in_box(lo, lo + edge);
                    self.is_free(p, &mut rng)
                })
                .count();
            free as f64 / VOLUME_SAMPLES as f64
        };
        (0..grid.len()).map(|c| free_share(c) * edge.product()).collect()
    }

    /// Flies from `start` along the unit vector `d` in band `band` until the optical depth `tau` is spent or a facet is hit. `track`
    /// receives every length in a cell and in a pane.
    pub(super) fn fly(
        &self,
        start: &WalkStart,
        d: Vec3,
        band: Band,
        tau: f64,
        track: &mut impl FnMut(TrackLocation, f64),
    ) -> WalkEnd {
        let (mut o, mut skip) = (start.at, start.facet);
        let mut tracker = FlightTracker { band, rest: tau, track };
        let mut flown = 0.0;
        // Leave the pane that holds the start.
        if let Some((plate, height)) = start.pane {
            let (pane, q) = self.plates[plate];
            let (p, cos) = (&self.scene.panes()[pane], q.normal().dot(d));
            let length = if cos > 0.0 { p.thickness - height } else { height } / cos.abs().max(1e-12);
            if let Some(end) = self.cross_pane(plate, o, length, &mut tracker) {
                return end;
            }
        }
        for _ in 0..MAX_IMAGES {
            let hit = self.facets.nearest(o, d, self.near..f64::INFINITY, skip);
            let (limit, exit_axis) = self.periodic_exit(o, d, hit.map_or(f64::INFINITY, |m| m.t));
            if let Some(end) = self.cross_media(o, d, limit, &mut tracker) {
                return end;
            }
            match (exit_axis, hit) {
                // Continue in the next periodic image.
                (Some(k), _) => {
                    let Some(grid) = self.scene.voxel_grid() else { return WalkEnd::Escaped };
                    let mut p = (o + d * limit).array();
                    p[k] = if d[k] > 0.0 { grid.min()[k] } else { grid.max()[k] };
                    (o, skip, flown) = (Vec3::from_array(p), None, flown + limit);
                }
                (None, Some(hit)) if hit.t <= limit => {
                    return WalkEnd::Facet(hit, o + d * hit.t, flown + hit.t);
                }
                _ => return WalkEnd::Escaped,
            }
        }
        WalkEnd::Escaped
    }

    /// The distance at which a ray leaves the periodic box, at most `limit`, and the periodic axis that it leaves along.
    fn periodic_exit(&self, o: Vec3, d: Vec3, mut limit: f64) -> (f64, Option<usize>) {
        let periodic = self.scene.periodic();
        let mut exit_axis = None;
        if periodic != [false; 3]
            && let Some(grid) = self.scene.voxel_grid()
        {
            for k in (0..3).filter(|&k| periodic[k] && d[k] != 0.0) {
                let face = if d[k] > 0.0 { grid.max()[k] } else { grid.min()[k] };
                let t = ((face - o[k]) / d[k]).max(0.0);
                if t < limit {
                    (limit, exit_axis) = (t, Some(k));
                }
            }
            // Beyond the box across the other axes is empty space.
            for k in (0..3).filter(|&k| !periodic[k] && d[k] != 0.0) {
                let face = if d[k] > 0.0 { grid.max()[k] } else { grid.min()[k] };
                if ((face - o[k]) / d[k]) < limit - self.near {
                    exit_axis = None;
                }
            }
        }
        (limit, exit_axis)
    }

    /// Crosses cells and panes up to a distance; returns the end of the flight when the optical depth is spent.
    fn cross_media<F: FnMut(TrackLocation, f64)>(
        &self,
        o: Vec3,
        d: Vec3,
        limit: f64,
        tracker: &mut FlightTracker<F>,
    ) -> Option<WalkEnd> {
        let mut from = 0.0;
        if !self.panes.is_empty() {
            for hit in self.panes.all(o, d, self.near..limit - self.near) {
                if let Some(end) = self.cross_cells(o, d, [from, hit.t], tracker) {
                    return Some(end);
                }
                let plate = hit.id as usize;
                let (pane, q) = self.plates[plate];
                let length = self.scene.panes()[pane].thickness / q.normal().dot(d).abs().max(1e-12);
                if let Some(end) = self.cross_pane(plate, o + d * hit.t, length, tracker) {
                    return Some(end);
                }
                from = hit.t;
            }
        }
        self.cross_cells(o, d, [from, limit], tracker)
    }

    /// Crosses `length` of the pane of a plate.
    fn cross_pane<F: FnMut(TrackLocation, f64)>(
        &self,
        plate: usize,
        at: Vec3,
        length: f64,
        tracker: &mut FlightTracker<F>,
    ) -> Option<WalkEnd> {
        let pane = self.plates[plate].0;
        let kappa = self.scene.panes()[pane].extinction[tracker.band];
        if kappa * length > tracker.rest {
            (tracker.track)(TrackLocation::Pane(pane, at), tracker.rest / kappa);
            return Some(WalkEnd::Pane(pane, plate, at));
        }
        (tracker.track)(TrackLocation::Pane(pane, at), length);
        tracker.rest -= kappa * length;
        None
    }

    /// Crosses the cells between two distances.
    fn cross_cells<F: FnMut(TrackLocation, f64)>(
        &self,
        o: Vec3,
        d: Vec3,
        [from, to]: [f64; 2],
        tracker: &mut FlightTracker<F>,
    ) -> Option<WalkEnd> {
        let grid = self.scene.voxel_grid()?;
        let (from, to) = clip_to_grid(grid, o, d, from, to)?;
        let mut end = None;
        traverse_grid(grid, o, d, [from, to], |cell, a, z| {
            let kappa = grid.extinction(cell)[tracker.band];
            if kappa * (z - a) > tracker.rest {
                let length = tracker.rest / kappa;
                (tracker.track)(TrackLocation::Cell(cell, o + d * (a + 0.5 * length)), length);
                end = Some(WalkEnd::Cell(cell, o + d * (a + length)));
                return false;
            }
            (tracker.track)(TrackLocation::Cell(cell, o + d * (0.5 * (a + z))), z - a);
            tracker.rest -= kappa * (z - a);
            true
        });
        end
    }

    /// Centre and radius of a sphere around the scene, m.
    pub(super) fn bounding_sphere(&self) -> (Vec3, f64) {
        let (lo, hi) = self.scene.bounds();
        ((lo + hi) * 0.5, 0.501 * (hi - lo).length() + vec3(self.near, 0.0, 0.0).x)
    }
}
