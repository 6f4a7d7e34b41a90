//! Nested solids and rooms, and medium outside of rooms.
//!
//! Guards (numbers): solids, cavities and rooms are classified as by brute force; no emitting surface and no medium is dropped silently; medium
//!     outside closed rooms has no zones; coincident surfaces and rooms inside out are reported.
use crate::common;
use common::*;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, Facet, Plate, Scene, Sides, Surface, VoxelGrid};
use zonal_transport::zoning::excluded_parts;
use zonal_transport::{Transport, build_zones};

fn solid(name: &str) -> Surface {
    Surface { solid: true, ..surface(name) }
}

/// A box as (lower corner, upper corner, inward normals).
type Skin = (Vec3, Vec3, bool);

fn skins(list: &[Skin], angle: f64) -> Vec<Vec<Plate>> {
    let one = |(lo, hi, inward): &Skin| if *inward { room(*lo, *hi) } else { solid_box(*lo, *hi) };
    list.iter().map(|s| turned(&one(s), Vec3::splat(0.5), angle)).collect()
}

fn cube(lo: f64, hi: f64, inward: bool) -> Skin {
    (Vec3::splat(lo), Vec3::splat(hi), inward)
}

fn nested(list: &[Skin], angle: f64) -> Scene {
    let surfaces = list.iter().enumerate().map(|(k, s)| Surface { solid: !s.2, ..surface(&format!("s{k}")) });
    let facets: Vec<Facet> = skins(list, angle)
        .iter()
        .enumerate()
        .flat_map(|(k, plates)| plates.iter().map(move |p| facet(k, *p)))
        .collect();
    scene(surfaces.collect(), facets, None)
}

/// Whether a point is in material, by brute force: the smallest skin around it decides; a room counts where its own smallest
/// container is a body.
fn brute_force(list: &[Skin], plates: &[Vec<Plate>], p: Vec3) -> bool {
    let within = |k: usize, p: Vec3| {
        let sign = if list[k].2 { 1.0 } else { -1.0 };
        plates[k].iter().all(|f| sign * (p - f.origin).dot(f.normal()) > 0.0)
    };
    let volume = |k: usize| (list[k].1 - list[k].0).product();
    let smallest = |around: &mut dyn Iterator<Item = usize>| {
        // Of coincident skins the cavity is the inner one.
        around.min_by(|a, b| volume(*a).total_cmp(&volume(*b)).then(list[*b].2.cmp(&list[*a].2)))
    };
    let cavity = |k: usize| {
        let centre =
            plates[k].iter().fold(Vec3::ZERO, |s, f| s + f.centre()) * (1.0 / plates[k].len() as f64);
        let holds = |j: &usize| *j != k && volume(*j) >= volume(k) && within(*j, centre);
        smallest(&mut (0..list.len()).filter(holds)).is_some_and(|j| !list[j].2)
    };
    let counts = |k: &usize| within(*k, p) && (!list[*k].2 || cavity(*k));
    smallest(&mut (0..list.len()).filter(counts)).is_some_and(|k| !list[k].2)
}

#[test]
fn solid_classification_matches_brute_force() {
    let beside = (vec3(1.0, 0.2, 0.2), vec3(1.4, 0.6, 0.6), false);
    let cases: [&[Skin]; 7] = [
        // A hollow shell around a body, in a room: four skins.
        &[cube(0.4, 0.6, false), cube(0.3, 0.7, true), cube(0.2, 0.8, false), cube(0.0, 1.0, true)],
        // An object inside a cavity inside an object, without a room; and the same with the inner object hollow.
        &[cube(0.0, 1.0, false), cube(0.1, 0.9, true), cube(0.2, 0.8, false)],
        &[cube(0.0, 1.0, false), cube(0.1, 0.9, true), cube(0.2, 0.8, false), cube(0.3, 0.7, true)],
        // A room in a room; the same in a cavity.
        &[cube(0.0, 1.0, true), cube(0.3, 0.7, true), cube(0.4, 0.5, false)],
        &[cube(-0.2, 1.2, false), cube(0.0, 1.0, true), cube(0.3, 0.7, true), cube(0.4, 0.5, false)],
        // Solids that touch, one of them hollow.
        &[cube(0.0, 1.0, false), cube(0.1, 0.9, true), beside],
        // Coincident skins.
        &[cube(0.0, 1.0, true), cube(0.2, 0.8, false), cube(0.2, 0.8, true), cube(0.4, 0.6, false)],
    ];
    for (case, list) in cases.iter().enumerate() {
        for angle in [0.0, 0.43] {
            let s = nested(list, angle);
            let t = Transport::new(&s);
            let plates = skins(list, angle);
            let mut rng = TestRng(77);
            for _ in 0..3000 {
                let p = rng.point() * 1.6 - Vec3::splat(0.3);
                assert_eq!(t.inside_solid(p), brute_force(list, &plates, p), "case {case}, {angle}: {p:?}");
            }
        }
    }
}

#[test]
fn skins_of_a_hollow_shell_keep_their_areas() {
    let list = [cube(0.4, 0.6, false), cube(0.3, 0.7, true), cube(0.2, 0.8, false), cube(0.0, 1.0, true)];
    for angle in [0.0, 0.43] {
        let s = nested(&list, angle);
        let t = Transport::new(&s);
        let z = build_zones(&s, &t).unwrap();
        for (k, (lo, hi, _)) in list.iter().enumerate() {
            let area: f64 = z.patches.iter().filter(|p| p.surface == k).map(|p| p.area).sum();
            assert!((area - 6.0 * (hi.x - lo.x).powi(2)).abs() < 1e-9, "skin {k}: {area}");
        }
        assert_eq!(excluded_parts(&s, &t, &z).unwrap(), []);
    }
}

#[test]
fn surface_inside_solid_is_refused_if_emitting_else_reported() {
    let build = |emission: f64| {
        let mut parts = nested(&[cube(0.3, 0.7, false), cube(0.0, 1.0, false)], 0.2).into_parts();
        parts.surfaces[0].emission = Bands::splat(emission);
        parts.surfaces[1].emission = Bands::ZERO;
        Scene::new(parts).unwrap()
    };
    let s = build(5.0);
    let t = Transport::new(&s);
    let e = excluded_parts(&s, &t, &build_zones(&s, &t).unwrap()).unwrap_err();
    assert!(e.key().contains("'s0'") && e.message().contains("'s1'"), "{} {}", e.key(), e.message());
    let s = build(0.0);
    let t = Transport::new(&s);
    let out = excluded_parts(&s, &t, &build_zones(&s, &t).unwrap()).unwrap();
    assert!(out.len() == 1 && out[0].is_warning(), "{out:?}");
    assert!(out[0].location.contains("'s0'") && out[0].contains("'s1'"), "{out:?}");
}

#[test]
fn parts_inside_solids_are_reported() {
    // A leg that reaches 5 cm into a floor slab.
    let leg = solid_box(vec3(0.4, 0.4, -0.05), vec3(0.6, 0.6, 0.4));
    let slab = solid_box(vec3(0.0, 0.0, -0.2), vec3(1.0, 1.0, 0.0));
    let facets = leg.iter().map(|p| facet(0, *p)).chain(slab.iter().map(|p| facet(1, *p)));
    let s = scene(vec![solid("leg"), solid("slab")], facets.collect(), None);
    let t = Transport::new(&s);
    let z = build_zones(&s, &t).unwrap();
    let out = excluded_parts(&s, &t, &z).unwrap();
    assert!(out.len() == 1 && !out[0].is_warning(), "{out:?}");
    assert!(out[0].contains("of 'leg'") && out[0].contains("of 'slab'"), "{out:?}");
}

/// Volume of the medium's zones in 8³ cells from 0 to 1.
fn medium(plates: &[(Surface, Vec<Plate>)]) -> (f64, usize) {
    let surfaces = plates.iter().map(|p| p.0.clone()).collect();
    let facets = plates.iter().enumerate().flat_map(|(k, p)| p.1.iter().map(move |q| facet(k, *q)));
    let s = scene(surfaces, facets.collect(), Some(fog(8, 1.0)));
    let t = Transport::new(&s);
    let z = build_zones(&s, &t).unwrap();
    let notes = excluded_parts(&s, &t, &z).unwrap();
    let outside = notes.iter().filter(|n| !n.is_warning() && n.contains("outside the closed rooms")).count();
    (z.voxels.iter().map(|v| v.volume).sum(), outside)
}

#[test]
fn medium_outside_a_closed_room_has_no_zones() {
    let walls = |lo: f64, hi: f64| room(Vec3::splat(lo), Vec3::splat(hi));
    let turned_walls = turned(&walls(0.3125, 0.6875), Vec3::splat(0.5), 0.37);
    let inner = (solid("box"), solid_box(Vec3::splat(0.4375), Vec3::splat(0.5625)));
    let free = 0.375f64.powi(3) - 0.125f64.powi(3);
    // On the grid, across cells, and turned; with an object in it.
    let (volume, notes) = medium(&[(surface("room"), walls(0.25, 0.75))]);
    assert!((volume - 0.125).abs() < 1e-12 && notes == 1, "{volume}");
    let (volume, notes) = medium(&[(surface("room"), walls(0.3125, 0.6875)), inner.clone()]);
    assert!((volume - free).abs() < 1e-6 && notes == 1, "{volume}");
    let (volume, notes) = medium(&[(surface("room"), turned_walls), inner.clone()]);
    assert!((volume - free).abs() < 0.02 * free && notes == 1, "{volume}");
    // Two rooms side by side, and one in the other.
    let two = [walls(0.125, 0.375), walls(0.625, 0.875)].concat();
    let (volume, _) = medium(&[(surface("rooms"), two)]);
    assert!((volume - 2.0 / 64.0).abs() < 1e-12, "{volume}");
    let (volume, _) =
        medium(&[(surface("outer"), walls(0.125, 0.875)), (surface("inner"), walls(0.25, 0.5))]);
    assert!((volume - 27.0 / 64.0).abs() < 1e-12, "{volume}");
}

#[test]
fn medium_in_the_open_and_around_a_room_with_surfaces_outside_stays() {
    let body = (solid("body"), solid_box(Vec3::splat(0.25), Vec3::splat(0.75)));
    let (volume, notes) = medium(&[body]);
    assert!((volume - 0.875).abs() < 1e-12 && notes == 0, "{volume}");
    // The room's own outer skin, a plate beside the room, and a room that misses a wall.
    let walls = (surface("room"), room(Vec3::splat(0.25), Vec3::splat(0.5)));
    let skin = (solid("skin"), solid_box(Vec3::splat(0.125), Vec3::splat(0.625)));
    let (volume, notes) = medium(&[walls.clone(), skin]);
    assert!((volume - (1.0 - 0.125 + 1.0 / 64.0)).abs() < 1e-12 && notes == 0, "{volume}");
    let plate = Plate::parallelogram(vec3(0.8, 0.1, 0.9), vec3(0.1, 0.0, 0.0), vec3(0.0, 0.1, 0.0));
    let plate = (Surface { sides: Sides::Both, ..surface("plate") }, vec![plate]);
    let (volume, notes) = medium(&[walls.clone(), plate]);
    assert!((volume - 1.0).abs() < 1e-12 && notes == 0, "{volume}");
    let open = (walls.0, walls.1[1..].to_vec());
    let (volume, notes) = medium(&[open]);
    assert!((volume - 1.0).abs() < 1e-12 && notes == 0, "{volume}");
}

/// Warnings of a scene by code.
fn warnings(s: &Scene) -> Vec<zonal_scene::Diagnostic> {
    let transport = Transport::new(s);
    let z = build_zones(s, &transport).unwrap();
    let all = zonal_transport::zoning::excluded_parts(s, &transport, &z).unwrap();
    all.into_iter().filter(|d| d.is_warning()).collect()
}

#[test]
fn medium_in_a_room_that_is_inside_out_is_reported() {
    let walls = room(Vec3::ZERO, Vec3::ONE);
    let inside_out: Vec<Plate> = walls.iter().map(Plate::flipped).collect();
    let with = |plates: &[Plate], solid: bool| {
        let s = Surface { solid, ..surface("room") };
        scene(vec![s], plates.iter().map(|p| facet(0, *p)).collect(), Some(fog(4, 0.5)))
    };
    assert!(warnings(&with(&walls, false)).is_empty());
    let found = warnings(&with(&inside_out, true));
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].code == "inverted-room" && found[0].to_string().contains("invert()"), "{found:?}");
    // The same medium is kept in another room: the first is reported all the same.
    let far = |p: &Plate| Plate { origin: p.origin + vec3(3.0, 0.0, 0.0), ..*p };
    let mut grid = VoxelGrid::new(Vec3::ZERO, vec3(0.5, 0.5, 0.5), [8, 2, 2]).unwrap();
    for c in 0..grid.len() {
        if [0, 1, 6, 7].contains(&grid.coordinates(c)[0]) {
            grid.set(c, Bands::ONE, Bands::ZERO, Bands::ZERO, Bands::ZERO);
        }
    }
    let facets = inside_out.iter().map(|p| facet(0, *p)).chain(walls.iter().map(|p| facet(1, far(p))));
    let both = scene(vec![solid("first"), surface("second")], facets.collect(), Some(grid.seal().unwrap()));
    let found = warnings(&both);
    assert!(found.len() == 1 && found[0].location == "surface 'first'", "{found:?}");
}

#[test]
fn solids_within_a_medium_give_no_warning() {
    let body: Vec<Plate> = room(Vec3::splat(0.3), Vec3::splat(0.7)).iter().map(Plate::flipped).collect();
    let facets = room(Vec3::ZERO, Vec3::ONE).into_iter().map(|p| facet(0, p));
    let s = scene(
        vec![surface("walls"), solid("body")],
        facets.chain(body.iter().map(|p| facet(1, *p))).collect(),
        Some(fog(4, 0.5)),
    );
    assert!(warnings(&s).is_empty());
}

#[test]
fn medium_of_a_region_within_a_solid_is_reported() {
    let body: Vec<Plate> = room(Vec3::splat(0.2), Vec3::splat(0.8)).iter().map(Plate::flipped).collect();
    let facets = room(Vec3::ZERO, Vec3::ONE).into_iter().map(|p| facet(0, p));
    let mut grid = VoxelGrid::new(Vec3::ZERO, Vec3::splat(0.25), [4; 3]).unwrap();
    for c in 0..grid.len() {
        let inner = grid.coordinates(c).iter().all(|k| (1..3).contains(k));
        let extinction = Bands::splat(if inner { 2.0 } else { 0.1 });
        grid.set(c, extinction, Bands::ZERO, Bands::ZERO, Bands::ZERO);
    }
    let s = scene(
        vec![surface("walls"), solid("body")],
        facets.chain(body.iter().map(|p| facet(1, *p))).collect(),
        Some(grid.seal().unwrap()),
    );
    let found = warnings(&s);
    assert!(found.len() == 1 && found[0].code == "medium-left-out", "{found:?}");
    assert!(found[0].contains("inside the solid 'body'"), "{found:?}");
}

#[test]
fn surfaces_at_one_place_are_reported() {
    let floor = Plate::parallelogram(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
    let half = Plate::triangle(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
    let two = |first: Plate, second: Plate, sides: Sides| {
        let surfaces = vec![surface("a"), Surface { sides, ..surface("b") }];
        warnings(&scene(surfaces, vec![facet(0, first), facet(1, second)], None))
    };
    for second in [floor, half] {
        let found = two(floor, second, Sides::Front);
        assert!(found.len() == 1 && found[0].code == "surfaces-coincide", "{found:?}");
        assert!(found[0].to_string().contains("surface 'b'"), "{found:?}");
    }
    // Back to back, with fronts on both sides, nothing counts twice; a sheet whose two sides exchange counts its front twice.
    assert!(two(floor, floor.flipped(), Sides::Front).is_empty());
    assert_eq!(two(floor, floor.flipped(), Sides::Both).len(), 1);
    let beside = Plate { origin: vec3(1.0, 0.0, 0.0), ..floor };
    assert!(two(floor, beside, Sides::Both).is_empty());
}
