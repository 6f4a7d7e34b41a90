//! Walks and optical depths against sampling and closed forms.
#![allow(missing_docs)]

mod common;
use common::*;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Pane, Plate, Scene, SceneParts, Voxmap};
use zonal_transport::Transport;

fn map_scene(map: Voxmap) -> Scene {
    scene(vec![], vec![], Some(map))
}

#[test]
fn the_walk_visits_the_cells_that_hold_its_points() {
    let mut dice = Dice(1);
    for case in 0..60 {
        let dims = [0, 1, 2].map(|_| 1 + (dice.roll() * 9.0) as usize);
        let cell = dice.point() * 0.3 + Vec3::splat(0.05);
        let min = dice.point() * 10.0 - Vec3::splat(5.0);
        let s = map_scene(Voxmap::new(min, cell, dims).unwrap());
        let (map, t) = (s.voxmap().unwrap(), Transport::new(&s));
        let size = map.max() - min;
        for k in 0..60 {
            let around = |d: &mut Dice| min + size.scale(d.point() * 1.6 - Vec3::splat(0.3));
            let (mut a, mut b) = (around(&mut dice), around(&mut dice));
            if k % 4 == 1 {
                b = vec3(a.x, a.y, b.z);
            }
            if k % 4 == 2 {
                // From lattice point to lattice point, along faces and edges.
                let snap = |d: &mut Dice| {
                    let i = [0, 1, 2].map(|k| (d.roll() * (dims[k] + 1) as f64) as usize);
                    map.corner(i)
                };
                (a, b) = (snap(&mut dice), snap(&mut dice));
            }
            let (dir, length) = ((b - a).normalized(), (b - a).length());
            let mut last: Option<f64> = None;
            let (mut total, mut pieces) = (0.0, 0);
            t.walk(a, b, &mut |c, t0, t1| {
                assert!(c < map.len() && t0 < t1);
                assert!(last.is_none_or(|l| l == t0), "pieces tile the segment");
                last = Some(t1);
                total += t1 - t0;
                pieces += 1;
                let lo = map.corner(map.coordinates(c));
                for x in [t0 + 1e-9 * (t1 - t0), 0.5 * (t0 + t1), t1 - 1e-9 * (t1 - t0)] {
                    let p = a + dir * x - lo;
                    let off = (0..3).map(|k| (-p[k]).max(p[k] - cell[k])).fold(f64::MIN, f64::max);
                    assert!(off < 1e-12, "{off} outside its cell");
                }
            });
            assert!(pieces <= dims.iter().sum::<usize>());
            let lattice = k % 4 == 2;
            // The clipped length by the share of midpoints inside; rounding decides in the outermost faces.
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
fn odd_segments_end() {
    let s = map_scene(Voxmap::new(Vec3::ZERO, Vec3::ONE, [3, 4, 5]).unwrap());
    let t = Transport::new(&s);
    let odd = [
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
    let mut dice = Dice(2);
    for _ in 0..20_000 {
        let mut pick = || odd[(dice.roll() * odd.len() as f64) as usize];
        let a = vec3(pick(), pick(), pick());
        let b = vec3(pick(), pick(), pick());
        let mut pieces = 0;
        t.walk(a, b, &mut |_, t0, t1| {
            pieces += 1;
            assert!(t1 > t0);
        });
        assert!(pieces <= 12);
        t.optical_depth(a, b);
        t.blocked(a, b);
    }
}

#[test]
fn a_constant_map_equals_a_uniform_one() {
    let uniform = map_scene(fog(7, 0.8));
    let mut other = fog(7, 0.8);
    // One cell in the far corner differs, so that the fast path is closed.
    let last = other.len() - 1;
    other.set(last, [9.0; 3], [0.0; 3], [0.0; 3], [0.0; 3]);
    let general = map_scene(other.seal().unwrap());
    let (u, g) = (Transport::new(&uniform), Transport::new(&general));
    let mut dice = Dice(4);
    for _ in 0..2000 {
        let a = dice.point() * 1.6 - Vec3::splat(0.8);
        let b = vec3(dice.roll() * 0.8, dice.roll() * 2.0 - 0.5, dice.roll() * 0.8);
        let (x, y) = (u.optical_depth(a, b), g.optical_depth(a, b));
        for k in 0..3 {
            assert!((x[k] - y[k]).abs() < 1e-13);
        }
        assert_eq!(x[2], 0.0);
    }
    let d = u.optical_depth(vec3(-1.0, 0.5, 0.5), vec3(2.0, 0.5, 0.5));
    assert!((d[0] - 0.8).abs() < 1e-15 && (d[1] - 1.6).abs() < 1e-15);
}

fn glazed(plates: Vec<Plate>) -> Scene {
    Scene::new(SceneParts {
        voxmap: Some(Voxmap::new(Vec3::splat(-1.0), Vec3::splat(2.0), [1; 3]).unwrap()),
        panes: vec![Pane {
            name: "glass".into(),
            plates,
            thickness: 0.01,
            extinction: [30.0, 60.0, 0.0],
            albedo: [0.2; 3],
            emission: [0.0; 3],
        }],
        ..SceneParts::default()
    })
    .unwrap()
}

#[test]
fn a_pane_dims_by_beers_law() {
    let pane = Plate::parallelogram(vec3(-0.5, -0.5, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
    let s = glazed(vec![pane]);
    let t = Transport::new(&s);
    let straight = t.transmittance(vec3(0.1, 0.2, -0.5), vec3(0.1, 0.2, 0.5)).unwrap();
    assert!((straight[0] - (-0.3f64).exp()).abs() < 1e-14 && (straight[1] - (-0.6f64).exp()).abs() < 1e-14);
    assert_eq!(straight[2], 1.0);
    let tilt = 60f64.to_radians().tan() * 0.2;
    let (a, b) = (vec3(-tilt, 0.0, -0.2), vec3(tilt, 0.0, 0.2));
    let oblique = t.transmittance(a, b).unwrap();
    assert!((oblique[0] - (-0.6f64).exp()).abs() < 1e-14);
    // Ends on the pane do not count, and beside it is nothing.
    assert_eq!(t.optical_depth(a, vec3(0.0, 0.0, 0.0)), [0.0; 3]);
    assert_eq!(t.optical_depth(vec3(0.6, 0.0, -0.5), vec3(0.6, 0.0, 0.5)), [0.0; 3]);
    assert!(t.has_panes_between());
    assert_eq!(t.optical_depth(a, b), t.optical_depth_inside(a, b));
}

#[test]
fn pane_crossings_come_in_order_and_once() {
    let square = |z: f64| Plate::parallelogram(vec3(-0.5, -0.5, z), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
    let mut plates = mesh(&square(0.3), 2);
    plates.extend(mesh(&square(-0.3), 3));
    let s = glazed(plates);
    let t = Transport::new(&s);
    // Through vertices and edges of both meshes as well.
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
