//! Point classification: points in solid material, and points outside every closed room.
//!
//! **Material.** Follow a direction outward and count: a front (entering material) +1, a back (leaving it) −1. The count falls
//! below zero somewhere if and only if the point started in material. The count is right for overlapping solids, solids in a room
//! whose walls are solid, and faces that touch. Three skew directions vote, so that one through an edge or an open bottom is
//! outvoted.
//!
//! **Nesting.** The count runs over the facets of solids and of **cavities**: closed rooms (normals inward) whose innermost
//! container is a solid, such as the inner skin of a hollow shell. Rooms are classified from the largest to the smallest by the
//! count over the solids and the cavities found so far, a little way in front of some of their facets: a solid in a cavity in a
//! solid is material, a cavity in that again is not, and a room within a room remains a thin wall with a black back.
//!
//! **Outside.** Let w be the number of closed rooms, cavities aside, that contain a point: fronts of rooms less backs along a
//! direction. Where every other facet and pane has its free sides at w > 0 or in material, only the medium is outside the rooms. No
//! light passes from there into them, and this part of the medium has no zones.

use crate::bvh::Bvh;
use crate::intersect::Tolerance;
use zonal_math::{Vec3, vec3};
use zonal_scene::shells::{ShellKind, Shells};
use zonal_scene::{Plate, Scene, Sides};

/// Skew directions of the vote.
const VOTE_DIRECTIONS: [Vec3; 3] = [
    vec3(0.382_917_511, 0.267_410_983, 0.884_207_139),
    vec3(-0.711_309_127, 0.621_937_419, 0.327_514_807),
    vec3(0.287_631_903, -0.530_713_331, -0.797_279_619),
];
/// Corners of one-sided facets nearer than this fraction of their extent coincide.
const WELD_SHARE: f64 = 1e-8;
/// Most facets of a room that are tested for lying in a solid.
const ROOM_SAMPLES: usize = 16;
/// Distance of a sample from its facet, in units of [`Tolerance::plane`].
const LIFT_IN_TOLERANCES: f64 = 10.0;

/// The facets that bound material and rooms.
#[derive(Clone, Debug)]
pub(crate) struct Solids {
    /// Facets of solids and cavities.
    material: Bvh,
    /// Facets of the closed rooms that are not cavities.
    rooms: Bvh,
    /// True where the medium outside these rooms touches nothing else.
    exterior_is_inert: bool,
    tol: Tolerance,
    middle: Vec3,
    diagonal: f64,
}

/// Crossing of a direction with a facet: fraction of its length, +1 for a front or −1 for a back, facet.
type SignedCrossing = (f64, i32, u32);

impl Solids {
    /// Classifies the facets of a scene.
    pub(crate) fn new(scene: &Scene, tol: &Tolerance) -> Solids {
        let (lo, hi) = scene.bounds();
        let surface = |k: usize| &scene.surfaces()[scene.facets()[k].surface];
        let select = |wanted: &dyn Fn(usize) -> bool| -> Vec<(u32, Plate)> {
            let all = scene.facets().iter().enumerate();
            all.filter(|(k, _)| wanted(*k)).map(|(k, f)| (k as u32, f.plate)).collect()
        };
        let mut solids = Solids {
            material: Bvh::new(&select(&|k| surface(k).solid), lo, hi),
            rooms: Bvh::new(&[], lo, hi),
            exterior_is_inert: false,
            tol: *tol,
            middle: (lo + hi) * 0.5,
            diagonal: scene.diagonal(),
        };
        let walls = scene.surfaces().iter().any(|s| !s.solid && s.sides == Sides::Front);
        if !walls || scene.voxel_grid().is_none() && solids.material.len() == 0 {
            return solids;
        }
        let one_sided = select(&|k| surface(k).solid || surface(k).sides == Sides::Front);
        // Group the one-sided facets into closed rooms.
        let (rooms, order) = closed_rooms(&one_sided, &|k| surface(k as usize).solid);
        // Count cavities as material; the other rooms are outer rooms.
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
            solids.material = Bvh::new(&select(&|k| surface(k).solid || inner[k]), lo, hi);
        }
        // Test whether the medium outside the outer rooms exchanges with anything.
        solids.rooms = Bvh::new(&outer, lo, hi);
        if let Some(grid) = scene.voxel_grid().filter(|_| !outer.is_empty() && !scene.is_periodic()) {
            let holds_all =
                |r: &usize| !cavity[*r] && is_box_around(&rooms[*r], [grid.min(), grid.max()], tol);
            solids.exterior_is_inert =
                !order.iter().any(holds_all) && solids.exterior_is_empty(scene, &outer);
        }
        solids
    }

    /// Marks the rooms that are cavities, in the given order.
    fn find_cavities(
        &self,
        scene: &Scene,
        rooms: &[Vec<(u32, Plate)>],
        order: &[usize],
        cavity: &mut [bool],
    ) {
        let (lo, hi) = scene.bounds();
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
        let tree = Bvh::new(&counted, lo, hi);
        for &r in order {
            let samples = rooms[r].len().min(ROOM_SAMPLES);
            cavity[r] = (0..samples).all(|i| {
                let plate = &rooms[r][i * rooms[r].len() / samples].1;
                let p = self.in_front_of(plate);
                let known = |facet: u32| {
                    let room = room_of[facet as usize];
                    room == u32::MAX || cavity[room as usize]
                };
                self.majority(|k| exit_facet(self.crossings(&tree, p, k, known)).is_some())
            });
        }
    }

    /// A point a little way in front of a plate.
    fn in_front_of(&self, plate: &Plate) -> Vec3 {
        plate.centre() + plate.normal() * (LIFT_IN_TOLERANCES * self.tol.plane)
    }

    /// True where no facet other than those of the outer rooms, and no pane, has a free side outside these rooms.
    fn exterior_is_empty(&self, scene: &Scene, outer: &[(u32, Plate)]) -> bool {
        let mut is_outer = vec![false; scene.facets().len()];
        outer.iter().for_each(|f| is_outer[f.0 as usize] = true);
        let free = |p: Vec3| self.is_outside_rooms(p) && !self.contains(p);
        let facets = scene.facets().iter().enumerate().filter(|(k, _)| !is_outer[*k]);
        let mut open = facets.flat_map(|(_, f)| {
            let both = scene.surfaces()[f.surface].sides == Sides::Both;
            [Some(self.in_front_of(&f.plate)), both.then(|| self.in_front_of(&f.plate.flipped()))]
        });
        let panes = scene.panes().iter().flat_map(|p| &p.plates);
        !open.any(|p| p.is_some_and(free)) && !panes.map(Plate::centre).any(free)
    }

    /// Majority of the three directions.
    fn majority(&self, test: impl Fn(usize) -> bool) -> bool {
        let (x, y) = (test(0), test(1));
        if x == y { x } else { test(2) }
    }

    /// The facets of a tree that direction number `k` from `p` crosses, in order; fronts first among those at one point.
    fn crossings(&self, tree: &Bvh, p: Vec3, k: usize, wanted: impl Fn(u32) -> bool) -> Vec<SignedCrossing> {
        let reach = (self.middle - p).length() + 2.0 * self.diagonal;
        let mut hits: Vec<SignedCrossing> = Vec::new();
        if tree.len() == 0 {
            return hits;
        }
        tree.all(p, p + VOTE_DIRECTIONS[k] * reach, &self.tol, &mut |id, [t, ..], along| {
            if wanted(id) {
                hits.push((t, if along < 0.0 { 1 } else { -1 }, id));
            }
        });
        hits.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)).then(a.2.cmp(&b.2)));
        // Touching faces are crossed at lengths that differ by rounding: put their fronts first.
        let near = self.tol.rounding / reach;
        for touching in hits.chunk_by_mut(|a, b| b.0 - a.0 <= near) {
            touching.sort_by(|a, b| b.1.cmp(&a.1).then(a.2.cmp(&b.2)));
        }
        hits
    }

    /// True when some facet bounds material.
    pub(crate) fn has_material(&self) -> bool {
        self.material.len() > 0
    }
    /// True when `p` lies in material.
    pub(crate) fn contains(&self, p: Vec3) -> bool {
        self.has_material()
            && self.majority(|k| exit_facet(self.crossings(&self.material, p, k, |_| true)).is_some())
    }
    /// The facet through which a ray leaves the material that holds `p`.
    pub(crate) fn enclosing_facet(&self, p: Vec3) -> Option<usize> {
        let exit = |k| exit_facet(self.crossings(&self.material, p, k, |_| true));
        (0..3).find_map(exit).map(|f| f as usize)
    }
    /// True where only the medium is outside the closed rooms.
    pub(crate) fn exterior_is_inert(&self) -> bool {
        self.exterior_is_inert
    }
    /// True when no closed room holds `p`; cavities of solids are not rooms.
    pub(crate) fn is_outside_rooms(&self, p: Vec3) -> bool {
        let count = |k| self.crossings(&self.rooms, p, k, |_| true).iter().map(|h| h.1).sum::<i32>();
        self.majority(|k| count(k) <= 0)
    }
}

/// The one-sided facets of each closed room, with empty lists for other shells, and the rooms in the order of their classification.
fn closed_rooms(
    one_sided: &[(u32, Plate)],
    is_solid: &dyn Fn(u32) -> bool,
) -> (Vec<Vec<(u32, Plate)>>, Vec<usize>) {
    let plates: Vec<Plate> = one_sided.iter().map(|x| x.1).collect();
    let shells = Shells::find(&plates, WELD_SHARE);
    let mut rooms: Vec<Vec<(u32, Plate)>> = vec![Vec::new(); shells.shells().len()];
    for (i, facet) in one_sided.iter().enumerate() {
        if shells.of(i) == ShellKind::Enclosure && !is_solid(facet.0) {
            rooms[shells.shell_index(i)].push(*facet);
        }
    }
    let mut order: Vec<usize> = (0..rooms.len()).filter(|r| !rooms[*r].is_empty()).collect();
    order.sort_by(|a, b| shells.shells()[*a].volume.total_cmp(&shells.shells()[*b].volume));
    (rooms, order)
}

/// The facet at which the count falls below zero.
fn exit_facet(hits: Vec<SignedCrossing>) -> Option<u32> {
    let mut count = 0;
    let below = |h: &&SignedCrossing| {
        count += h.1;
        count < 0
    };
    hits.iter().find(below).map(|h| h.2)
}

/// True where the facets are those of an axis-aligned box that holds the medium.
fn is_box_around(facets: &[(u32, Plate)], [min, max]: [Vec3; 2], tol: &Tolerance) -> bool {
    let empty_box = (Vec3::splat(f64::INFINITY), Vec3::splat(f64::NEG_INFINITY));
    let (lo, hi) = facets.iter().map(|f| f.1.bounds()).fold(empty_box, |(a, b), (x, y)| (a.min(x), b.max(y)));
    let on_faces = facets.iter().all(|f| {
        let (a, b) = f.1.bounds();
        (0..3).any(|k| b[k] - lo[k] <= tol.plane || hi[k] - a[k] <= tol.plane)
    });
    on_faces && (0..3).all(|k| min[k] >= lo[k] - tol.plane && max[k] <= hi[k] + tol.plane)
}
