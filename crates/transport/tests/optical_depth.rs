//! Grid traversal and optical depths against sampling and closed forms.
use crate::common;
use common::*;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, Pane, Plate, Scene, SceneParts, VoxelGrid};
use zonal_transport::patch_locator::pane_piece_locator;
use zonal_transport::{Transport, build_zones};

fn map_scene(map: VoxelGrid) -> Scene {
    scene(vec![], vec![], Some(map))
}

/// Total length and number of the pieces of a segment; checks that the pieces tile the segment and lie in their cells.
fn traversed(t: &Transport, map: &VoxelGrid, a: Vec3, b: Vec3) -> (f64, usize) {
    let dir = (b - a).normalized();
    let mut last: Option<f64> = None;
    let (mut total, mut pieces) = (0.0, 0);
    t.traverse_grid(a, b, &mut |c, t0, t1| {
        assert!(c < map.len() && t0 < t1);
        assert!(last.is_none_or(|l| l == t0), "pieces tile the segment");
        last = Some(t1);
        total += t1 - t0;
        pieces += 1;
        let lo = map.corner(map.coordinates(c));
        for x in [t0 + 1e-9 * (t1 - t0), 0.5 * (t0 + t1), t1 - 1e-9 * (t1 - t0)] {
            let p = a + dir * x - lo;
            let excess = (0..3).map(|k| (-p[k]).max(p[k] - map.cell()[k])).fold(f64::MIN, f64::max);
            assert!(excess < 1e-12, "{excess} outside its cell");
        }
    });
    (total, pieces)
}

#[test]
fn traversal_visits_the_cells_that_hold_its_points() {
    let mut rng = TestRng(1);
    for case in 0..60 {
        let dims = [0, 1, 2].map(|_| 1 + (rng.uniform() * 9.0) as usize);
        let cell = rng.point() * 0.3 + Vec3::splat(0.05);
        let min = rng.point() * 10.0 - Vec3::splat(5.0);
        let s = map_scene(VoxelGrid::new(min, cell, dims).unwrap());
        let (map, t) = (s.voxel_grid().unwrap(), Transport::new(&s));
        let size = map.max() - min;
        for k in 0..60 {
            let around = |rng: &mut TestRng| min + size.scale(rng.point() * 1.6 - Vec3::splat(0.3));
            let (mut a, mut b) = (around(&mut rng), around(&mut rng));
            if k % 4 == 1 {
                b = vec3(a.x, a.y, b.z);
            }
            if k % 4 == 2 {
                // From grid point to grid point, along faces and edges.
                let snap = |rng: &mut TestRng| {
                    let i = [0, 1, 2].map(|k| (rng.uniform() * (dims[k] + 1) as f64) as usize);
                    map.corner(i)
                };
                (a, b) = (snap(&mut rng), snap(&mut rng));
            }
            let length = (b - a).length();
            let (total, pieces) = traversed(&t, map, a, b);
            assert!(pieces <= dims.iter().sum::<usize>());
            let lattice = k % 4 == 2;
            // Compare with the clipped length from the fraction of midpoints inside; rounding decides in the outermost faces.
            let n = 400;
            let inside = (0..n)
                .filter(|i| map.cell_at(a + (b - a) * ((*i as f64 + 0.5) / n as f64)).is_some())
                .count();
            let want = inside as f64 / n as f64 * length;
            assert!(
                lattice || (total - want).abs() <= 1.01 * length / n as f64,
                "case {case}: {total} against {want}"
            );
            if lattice || (map.cell_at(a).is_some() && map.cell_at(b).is_some()) {
                assert!((total - length).abs() <= 1e-12 * (1.0 + length));
            }
        }
    }
}

#[test]
fn traversal_of_degenerate_segments_terminates() {
    let s = map_scene(VoxelGrid::new(Vec3::ZERO, Vec3::ONE, [3, 4, 5]).unwrap());
    let t = Transport::new(&s);
    let values = [
        0.0,
        -0.0,
        1.0,
        3.0,
        1e-300,
        -1e-300,
        1e300,
        -1e300,
        f64::MAX,
        f64::NAN,
        f64::INFINITY,
        1.0 + f64::EPSILON,
        5e-324,
    ];
    let mut rng = TestRng(2);
    for _ in 0..20_000 {
        let mut pick = || values[(rng.uniform() * values.len() as f64) as usize];
        let a = vec3(pick(), pick(), pick());
        let b = vec3(pick(), pick(), pick());
        let mut pieces = 0;
        t.traverse_grid(a, b, &mut |_, t0, t1| {
            pieces += 1;
            assert!(t1 > t0);
        });
        assert!(pieces <= 12);
        t.optical_depth(a, b);
        t.occluded(a, b);
    }
}

// Guards (numbers): a constant voxel grid equals a uniform medium.
#[test]
fn uniform_grid_matches_its_closed_form() {
    let uniform = map_scene(fog(7, 0.8));
    let mut other = fog(7, 0.8);
    // One cell in the far corner differs, which disables the shortcut of uniform grids.
    let last = other.len() - 1;
    other.set(last, Bands::splat(9.0), Bands::ZERO, Bands::ZERO, Bands::ZERO);
    let general = map_scene(other.seal().unwrap());
    let (u, g) = (Transport::new(&uniform), Transport::new(&general));
    let mut rng = TestRng(4);
    for _ in 0..2000 {
        let a = rng.point() * 1.6 - Vec3::splat(0.8);
        let b = vec3(rng.uniform() * 0.8, rng.uniform() * 2.0 - 0.5, rng.uniform() * 0.8);
        let (x, y) = (u.optical_depth(a, b), g.optical_depth(a, b));
        assert!((x - y).abs().all(|d| d < 1e-13));
        assert_eq!(x.to_rgb()[2], 0.0);
    }
    let d = u.optical_depth(vec3(-1.0, 0.5, 0.5), vec3(2.0, 0.5, 0.5)).to_rgb();
    assert!((d[0] - 0.8).abs() < 1e-15 && (d[1] - 1.6).abs() < 1e-15);
}

fn glazed(plates: Vec<Plate>) -> Scene {
    Scene::new(SceneParts {
        voxel_grid: Some(VoxelGrid::new(Vec3::splat(-1.0), Vec3::splat(2.0), [1; 3]).unwrap()),
        panes: vec![Pane {
            name: "glass".into(),
            plates,
            thickness: 0.01,
            extinction: Bands::from_rgb([30.0, 60.0, 0.0]),
            albedo: Bands::splat(0.2),
            emission: Bands::ZERO,
        }],
        ..SceneParts::default()
    })
    .unwrap()
}

#[test]
fn pane_attenuates_by_beers_law() {
    let pane = Plate::parallelogram(vec3(-0.5, -0.5, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
    let s = glazed(vec![pane]);
    let t = Transport::new(&s);
    let straight = t.transmittance(vec3(0.1, 0.2, -0.5), vec3(0.1, 0.2, 0.5)).unwrap().to_rgb();
    assert!((straight[0] - (-0.3f64).exp()).abs() < 1e-14 && (straight[1] - (-0.6f64).exp()).abs() < 1e-14);
    assert_eq!(straight[2], 1.0);
    let tilt = 60f64.to_radians().tan() * 0.2;
    let (a, b) = (vec3(-tilt, 0.0, -0.2), vec3(tilt, 0.0, 0.2));
    let oblique = t.transmittance(a, b).unwrap();
    assert!((oblique.first() - (-0.6f64).exp()).abs() < 1e-14);
    // Ends on the pane do not count, and segments beside it are unattenuated.
    assert_eq!(t.optical_depth(a, vec3(0.0, 0.0, 0.0)), Bands::ZERO);
    assert_eq!(t.optical_depth(vec3(0.6, 0.0, -0.5), vec3(0.6, 0.0, 0.5)), Bands::ZERO);
    assert!(t.has_interior_panes());
    assert_eq!(t.optical_depth(a, b), t.optical_depth_inside(a, b));
}

#[test]
fn pane_crossings_are_ordered_and_unique() {
    let square = |z: f64| Plate::parallelogram(vec3(-0.5, -0.5, z), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
    let mut plates = mesh(&square(0.3), 2);
    plates.extend(mesh(&square(-0.3), 3));
    let s = glazed(plates);
    let t = Transport::new(&s);
    // Also through vertices and edges of both meshes.
    for x in [0.0, 1.0 / 6.0, -1.0 / 6.0, 0.123] {
        for y in [0.0, 1.0 / 6.0, 0.3] {
            for (a, b) in [(vec3(x, y, 0.9), vec3(x, y, -0.9)), (vec3(x, y, -0.9), vec3(0.0, 0.0, 0.9))] {
                let mut seen = Vec::new();
                t.pane_crossings(a, b, &mut |h| seen.push(h));
                assert_eq!(seen.len(), 2, "{a:?} → {b:?}");
                let length = (b - a).length();
                assert!((seen[0].t / length - 1.0 / 3.0).abs() < 1e-12);
                assert!((seen[1].t / length - 2.0 / 3.0).abs() < 1e-12);
                assert!((seen[0].cos - 1.8 / length).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn blocks_of_one_extinction_have_the_depth_of_their_cells() {
    // Smoke in a part of the grid, of which blocks of eight cells hold the border, and one denser cell.
    let mut map = VoxelGrid::new(vec3(-1.0, 0.5, 2.0), vec3(0.1, 0.13, 0.09), [37, 21, 50]).unwrap();
    for k in 0..map.len() {
        let [x, y, z] = map.coordinates(k);
        let extinction = if (x, y, z) == (20, 9, 30) {
            Bands::splat(7.0)
        } else if x > 10 && z < 33 {
            Bands::from_rgb([0.3, 0.2, 0.1])
        } else {
            Bands::ZERO
        };
        map.set(k, extinction, Bands::ZERO, Bands::ZERO, Bands::ZERO);
    }
    let s = map_scene(map.seal().unwrap());
    let (map, t) = (s.voxel_grid().unwrap(), Transport::new(&s));
    let (size, mut rng) = (map.max() - map.min(), TestRng(11));
    let mut point = || map.min() + size.scale(rng.point() * 1.4 - Vec3::splat(0.2));
    for _ in 0..500 {
        let (a, b) = (point(), point());
        let (mut by_cells, mut pieces, mut last) = (Bands::ZERO, 0, 0.0);
        t.traverse_grid(a, b, &mut |cell, t0, t1| by_cells += map.extinction(cell) * (t1 - t0));
        t.traverse_extinction(a, b, &mut |_, t0, t1| {
            assert!(t0 >= last && t1 > t0, "pieces are in order");
            (pieces, last) = (pieces + 1, t1);
        });
        let depth = t.medium_depth(a, b);
        assert!((depth - by_cells).abs().max_element() < 1e-12, "{depth:?} {by_cells:?}");
        assert!(pieces <= 60, "{pieces}");
    }
}

#[test]
fn pieces_of_a_pane_of_two_triangles_are_found_where_they_lie() {
    // The triangles of a square: their centres have parameters between 0 and 1 on both.
    let (a, b) = (vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
    let s = glazed(vec![Plate::triangle(Vec3::ZERO, a, b), Plate::triangle(a + b, b, a)]);
    let t = Transport::new(&s);
    let zones = build_zones(&s, &t).unwrap();
    let (first, locator) = pane_piece_locator(&s, &zones);
    assert!(zones.panes.len() >= 2);
    let (mut found, mut rng) = (0, TestRng(5));
    for _ in 0..400 {
        let p = rng.point();
        let (x, y) = (vec3(p.x, p.y, -1.0), vec3(p.x, p.y, 1.0));
        t.pane_crossings(x, y, &mut |hit| {
            let point = vec3(p.x, p.y, 0.0);
            let uv = s.panes()[hit.pane].plates[hit.plate].parameters(point);
            let piece = locator.locate(first[hit.pane] + hit.plate, uv).expect("the point lies on a piece");
            let [u, v] = zones.panes[piece as usize].plate.parameters(point);
            assert!(u.min(v).min(1.0 - u - v) > -1e-5, "{u} {v}");
            found += 1;
        });
    }
    assert_eq!(found, 400);
}
