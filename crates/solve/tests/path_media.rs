//! The medium of a pair is that of its own paths, whatever other zones of the scene do.

use crate::common;

use common::read;
use zonal_exchange::pair::{Exchange, PairCounts, PairFactor};
use zonal_scene::Bands;
use zonal_transport::{Transport, build_zones};

const CUBE: &str =
    "name = 'cube'\n[solve]\npatch_size = 1\n[medium]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\ncells = [3, 3, 3]\n";

fn patch(name: &str, origin: [f64; 3], edges: [[f64; 3]; 2]) -> String {
    let [a, b] = edges;
    format!(
        "[[surface]]\nname = '{name}'\nrectangle = {{ origin = {origin:?}, edge1 = {a:?}, edge2 = {b:?} }}\nreflectance = 0.5\nsides = 'both'\n"
    )
}

/// The factors of all pairs of voxels, row by row, and the number of rays.
fn voxel_pairs(text: &str) -> (Vec<PairFactor>, u64) {
    let scene = read(text);
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport).unwrap();
    let exchange = Exchange::new(&scene, &zones, &transport);
    let mut counts = PairCounts::default();
    let voxels = zones.voxel_offset()..zones.pane_offset();
    let mut out = Vec::new();
    for i in voxels.clone() {
        out.extend((voxels.start..=i).map(|j| exchange.pair(i, j, &mut counts)));
    }
    (out, counts.rays)
}

/// The factor of the first zones of two surfaces, and the number of rays.
fn surface_pair(text: &str, names: [&str; 2]) -> (PairFactor, u64) {
    let scene = read(text);
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport).unwrap();
    let exchange = Exchange::new(&scene, &zones, &transport);
    let mut counts = PairCounts::default();
    let patches = &zones.patches;
    let of = |name: &str| {
        let surface = scene.surfaces().iter().position(|s| s.name == name).expect("a surface");
        (0..zones.voxel_offset()).filter(move |&i| patches[i].surface == surface).collect::<Vec<_>>()
    };
    let (a, b) = (of(names[0]), of(names[1]));
    let mut best = PairFactor::default();
    for f in
        a.iter().flat_map(|&i| b.iter().map(move |&j| (i, j))).map(|(i, j)| exchange.pair(i, j, &mut counts))
    {
        if f.value.first() > best.value.first() {
            best = f;
        }
    }
    (best, counts.rays)
}

fn same(a: &[PairFactor], b: &[PairFactor]) -> bool {
    let near = |a: &PairFactor, b: &PairFactor| {
        ((a.value - b.value).abs() - (a.radius + b.radius)).all(|excess| excess <= 0.0)
    };
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| near(a, b))
}

// Guards (numbers): the exact factor of a pair does not depend on other zones.
#[test]
fn voxel_pairs_do_not_depend_on_surfaces_outside() {
    let cube = format!("{CUBE}extinction = 20\nalbedo = 1\n");
    let (alone, _) = voxel_pairs(&cube);
    let outside = [
        patch("far", [3.0, 3.0, 0.0], [[0.01, 0.0, 0.0], [0.0, 0.01, 0.0]]),
        patch("below", [0.0, 0.0, -0.5], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
        patch("tilted", [2.0, 0.2, 0.4], [[0.1, 0.1, 0.0], [0.0, 0.1, 0.2]]),
    ];
    for other in outside {
        let (pairs, rays) = voxel_pairs(&format!("{cube}{other}"));
        assert!(same(&alone, &pairs) && rays == 0, "{other}: {rays} rays");
    }
}

/// Pairs within a region of one extinction have the factors of a uniform medium; pairs across regions take rays.
#[test]
fn pairs_within_a_region_are_those_of_a_uniform_medium() {
    let region =
        "extinction = 20\n[[medium.region]]\nbox = { min = [0.7, 0, 0], max = [1, 1, 1] }\nextinction = 2\n";
    let (uniform, _) = voxel_pairs(&format!("{CUBE}extinction = 20\n"));
    let (varied, rays) = voxel_pairs(&format!("{CUBE}{region}"));
    // Cells are numbered with z fastest: the first eighteen lie below x = 2/3.
    let within = 18 * 19 / 2;
    assert!(same(&uniform[..within], &varied[..within]) && rays > 0);
    assert!(!same(&uniform, &varied));
}

#[test]
fn pairs_beside_a_medium_see_each_other_through_vacuum() {
    // A room whose upper half has smoke; two patches whose bounding box holds the medium, seen past its edge.
    let room = "name = 'room'\n[solve]\npatch_size = 1\n[[surface]]\nname = 'walls'\nroom = { min = [0, 0, 0], max = [2, 2, 2] }\nreflectance = 0.5\n[medium]\nmin = [0, 0, 1]\nmax = [2, 2, 2]\ncells = [2, 2, 1]\nextinction = 3\n";
    let empty = room.replace("extinction = 3", "extinction = 0");
    let names = ["walls.z0", "walls.x0"];
    let [(smoky, _), (clear, _)] = [room, &empty].map(|text| surface_pair(text, names));
    assert_eq!(smoky.value, clear.value);
    let corner = patch("a", [3.0, 0.0, 0.4], [[0.0, 0.1, 0.0], [0.0, 0.0, 0.1]])
        + &patch("b", [0.0, 3.0, 0.4], [[0.1, 0.0, 0.0], [0.0, 0.0, 0.1]]);
    let [(dim, rays), (clear, _)] =
        [5, 0].map(|k| surface_pair(&format!("{CUBE}extinction = {k}\n{corner}"), ["a", "b"]));
    assert!(clear.value.first() > 0.0 && dim.value == clear.value && rays == 0, "{dim:?} {clear:?} {rays}");
    // Through the medium they take rays.
    let across = patch("a", [-1.0, 0.4, 0.4], [[0.0, 0.1, 0.0], [0.0, 0.0, 0.1]])
        + &patch("b", [2.0, 0.4, 0.4], [[0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]);
    let (dim, rays) = surface_pair(&format!("{CUBE}extinction = 5\n{across}"), ["a", "b"]);
    assert!(rays > 0 && dim.value.first() < 0.01 * 0.1f64.powi(2) && dim.value != Bands::ZERO);
}
