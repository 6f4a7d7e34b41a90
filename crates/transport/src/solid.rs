//! Which points lie in solid material, and which lie outside every closed room.
//!
//! **Material.** Follow a direction outward and count: a front (entering material) +1, a back (leaving it) −1. The count falls below zero
//! somewhere if and only if the point started in material. Overlapping solids, solids in a room whose walls are solid, and faces that
//! touch all come out right. Three skew directions vote, so one that runs through an edge or an open bottom is outvoted.
//!
//! **Nesting.** Counted are the facets of solids and of **cavities**: closed rooms (normals inward) whose innermost container is a solid, such as the
//! inner skin of a hollow shell. Rooms are judged from the largest to the smallest by the count of the solids and of the cavities found so far, a
//! little way in front of some of their facets: a solid in a cavity in a solid is material, a cavity in that again is not, and a room within a room
//! remains a thin wall with a black back.
//!
//! **Outside.** Let w be the number of closed rooms, cavities aside, that contain a point: fronts of rooms less backs along a direction. Where every
//! other facet and pane has its free sides at w > 0 or in material, nothing but the medium is outside the rooms. No light passes from there
//! into them, and this part of the medium has no zones.

use crate::bvh::Bvh;
use crate::meet::Tolerance;
use zonal_math::{Vec3, vec3};
use zonal_scene::closed::{Shell, Shells};
use zonal_scene::{Plate, Scene, Sides};

const DIRECTIONS: [Vec3; 3] = [
    vec3(0.382_917_511, 0.267_410_983, 0.884_207_139),
    vec3(-0.711_309_127, 0.621_937_419, 0.327_514_807),
    vec3(0.287_631_903, -0.530_713_331, -0.797_279_619),
];
/// Corners of one-sided facets nearer than this share of their extent are one.
const WELD: f64 = 1e-8;
/// Facets of a room that are asked whether they look into a solid.
const ROOM_SAMPLES: usize = 16;
/// Distance of a sample from its facet, in [`Tolerance::plane`].
const LIFT: f64 = 10.0;

/// The facets that bound material and rooms.
#[derive(Clone, Debug)]
pub(crate) struct Solids {
    /// Facets of solids and cavities.
    material: Bvh,
    /// Facets of the closed rooms that are no cavities.
    rooms: Bvh,
    /// True where the medium outside these rooms touches nothing else.
    void_outside: bool,
    tol: Tolerance,
    middle: Vec3,
    diagonal: f64,
}

/// A facet that a direction crosses: share of the way, and +1 for a front.
type Crossing = (f64, i32, u32);

impl Solids {
    /// Sorts the facets of a scene.
    pub(crate) fn new(scene: &Scene, tol: &Tolerance) -> Solids {
        let bounds = scene.bounds();
        let surface = |k: usize| &scene.surfaces()[scene.facets()[k].surface];
        let listed = |facets: &dyn Fn(usize) -> bool| -> Vec<(u32, Plate)> {
            let all = scene.facets().iter().enumerate();
            all.filter(|(k, _)| facets(*k)).map(|(k, f)| (k as u32, f.plate)).collect()
        };
        let mut solids = Solids {
            material: Bvh::new(&listed(&|k| surface(k).solid), bounds),
            rooms: Bvh::new(&[], bounds),
            void_outside: false,
            tol: *tol,
            middle: (bounds.0 + bounds.1) * 0.5,
            diagonal: scene.diagonal(),
        };
        let walls = scene.surfaces().iter().any(|s| !s.solid && s.sides == Sides::Front);
        if !walls || scene.voxmap().is_none() && solids.material.len() == 0 {
            return solids;
        }
        let one_sided = listed(&|k| surface(k).solid || surface(k).sides == Sides::Front);
        let plates: Vec<Plate> = one_sided.iter().map(|x| x.1).collect();
        let shells = Shells::find(&plates, WELD);
        let mut rooms: Vec<Vec<(u32, Plate)>> = vec![Vec::new(); shells.components().len()];
        for (i, facet) in one_sided.iter().enumerate() {
            if shells.of(i) == Shell::Room && !surface(facet.0 as usize).solid {
                rooms[shells.component(i)].push(*facet);
            }
        }
        let mut order: Vec<usize> = (0..rooms.len()).filter(|r| !rooms[*r].is_empty()).collect();
        order.sort_by(|a, b| shells.components()[*a].volume.total_cmp(&shells.components()[*b].volume));
        let mut cavity = vec![false; rooms.len()];
        if solids.material.len() > 0 && !order.is_empty() {
            solids.find_cavities(scene, &rooms, &order, &mut cavity);
        }
        let outer: Vec<(u32, Plate)> =
            order.iter().filter(|r| !cavity[**r]).flat_map(|r| rooms[*r].iter().copied()).collect();
        if cavity.contains(&true) {
            let mut inner = vec![false; scene.facets().len()];
            let of_cavities = (0..rooms.len()).filter(|r| cavity[*r]).flat_map(|r| &rooms[r]);
            of_cavities.for_each(|f| inner[f.0 as usize] = true);
            solids.material = Bvh::new(&listed(&|k| surface(k).solid || inner[k]), bounds);
        }
        solids.rooms = Bvh::new(&outer, bounds);
        if let Some(map) = scene.voxmap().filter(|_| !outer.is_empty() && !scene.is_periodic()) {
            let holds_all = |r: &usize| !cavity[*r] && is_box_around(&rooms[*r], [map.min(), map.max()], tol);
            solids.void_outside = !order.iter().any(holds_all) && solids.nothing_outside(scene, &outer);
        }
        solids
    }

    /// Marks the rooms that are cavities, in this order.
    fn find_cavities(
        &self,
        scene: &Scene,
        rooms: &[Vec<(u32, Plate)>],
        order: &[usize],
        cavity: &mut [bool],
    ) {
        let bounds = scene.bounds();
        let mut room_of = vec![u32::MAX; scene.facets().len()];
        for &r in order {
            rooms[r].iter().for_each(|f| room_of[f.0 as usize] = r as u32);
        }
        let solid = |k: usize| scene.surfaces()[scene.facets()[k].surface].solid;
        let facets = scene.facets().iter().enumerate();
        let counted: Vec<(u32, Plate)> = facets
            .filter(|(k, _)| solid(*k) || room_of[*k] != u32::MAX)
            .map(|(k, f)| (k as u32, f.plate))
            .collect();
        let tree = Bvh::new(&counted, bounds);
        for &r in order {
            let samples = rooms[r].len().min(ROOM_SAMPLES);
            cavity[r] = (0..samples).all(|i| {
                let plate = &rooms[r][i * rooms[r].len() / samples].1;
                let p = self.before(plate);
                let known = |facet: u32| {
                    let room = room_of[facet as usize];
                    room == u32::MAX || cavity[room as usize]
                };
                self.vote(|k| starts_inside(self.crossings(&tree, p, k, known)).is_some())
            });
        }
    }

    /// A point a little way in front of a plate.
    fn before(&self, plate: &Plate) -> Vec3 {
        plate.centre() + plate.normal() * (LIFT * self.tol.plane)
    }

    /// True where no facet but those of the outer rooms, and no pane, has a free side outside these rooms.
    fn nothing_outside(&self, scene: &Scene, outer: &[(u32, Plate)]) -> bool {
        let mut is_outer = vec![false; scene.facets().len()];
        outer.iter().for_each(|f| is_outer[f.0 as usize] = true);
        let free = |p: Vec3| self.outside_rooms(p) && !self.inside(p);
        let facets = scene.facets().iter().enumerate().filter(|(k, _)| !is_outer[*k]);
        let mut open = facets.flat_map(|(_, f)| {
            let both = scene.surfaces()[f.surface].sides == Sides::Both;
            [Some(self.before(&f.plate)), both.then(|| self.before(&f.plate.flipped()))]
        });
        let panes = scene.panes().iter().flat_map(|p| &p.plates);
        !open.any(|p| p.is_some_and(free)) && !panes.map(Plate::centre).any(free)
    }

    /// What most of the three directions say.
    fn vote(&self, says: impl Fn(usize) -> bool) -> bool {
        let (x, y) = (says(0), says(1));
        if x == y { x } else { says(2) }
    }

    /// The facets of a tree that a direction crosses, those at one point with fronts first.
    fn crossings(&self, tree: &Bvh, p: Vec3, k: usize, wanted: impl Fn(u32) -> bool) -> Vec<Crossing> {
        let reach = (self.middle - p).length() + 2.0 * self.diagonal;
        let mut hits: Vec<Crossing> = Vec::new();
        if tree.len() == 0 {
            return hits;
        }
        tree.all(p, p + DIRECTIONS[k] * reach, &self.tol, |id, [t, ..], along| {
            if wanted(id) {
                hits.push((t, if along < 0.0 { 1 } else { -1 }, id));
            }
        });
        hits.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)).then(a.2.cmp(&b.2)));
        // Faces that touch are met at lengths that differ by rounding.
        let near = self.tol.rounding / reach;
        for together in hits.chunk_by_mut(|a, b| b.0 - a.0 <= near) {
            together.sort_by(|a, b| b.1.cmp(&a.1).then(a.2.cmp(&b.2)));
        }
        hits
    }

    /// True when some facet bounds material.
    pub(crate) fn any(&self) -> bool {
        self.material.len() > 0
    }
    /// True when `p` lies in material.
    pub(crate) fn inside(&self, p: Vec3) -> bool {
        self.any() && self.vote(|k| starts_inside(self.crossings(&self.material, p, k, |_| true)).is_some())
    }
    /// The facet through which a way leaves the material in which `p` lies.
    pub(crate) fn around(&self, p: Vec3) -> Option<usize> {
        let exit = |k| starts_inside(self.crossings(&self.material, p, k, |_| true));
        (0..3).find_map(exit).map(|f| f as usize)
    }
    /// True where nothing but the medium is outside the closed rooms.
    pub(crate) fn void_outside(&self) -> bool {
        self.void_outside
    }
    /// True when `p` lies in no closed room; cavities of solids are none.
    pub(crate) fn outside_rooms(&self, p: Vec3) -> bool {
        let count = |k| self.crossings(&self.rooms, p, k, |_| true).iter().map(|h| h.1).sum::<i32>();
        self.vote(|k| count(k) <= 0)
    }
}

/// The facet at which the count falls below zero, if it does.
fn starts_inside(hits: Vec<Crossing>) -> Option<u32> {
    let mut count = 0;
    let below = |h: &&Crossing| {
        count += h.1;
        count < 0
    };
    hits.iter().find(below).map(|h| h.2)
}

/// True where the facets are those of a box along the axes that holds the medium.
fn is_box_around(facets: &[(u32, Plate)], [min, max]: [Vec3; 2], tol: &Tolerance) -> bool {
    let empty = (Vec3::splat(f64::INFINITY), Vec3::splat(f64::NEG_INFINITY));
    let (lo, hi) = facets.iter().map(|f| f.1.bounds()).fold(empty, |(a, b), (x, y)| (a.min(x), b.max(y)));
    let on_faces = facets.iter().all(|f| {
        let (a, b) = f.1.bounds();
        (0..3).any(|k| b[k] - lo[k] <= tol.plane || hi[k] - a[k] <= tol.plane)
    });
    on_faces && (0..3).all(|k| min[k] >= lo[k] - tol.plane && max[k] <= hi[k] + tol.plane)
}
