//! The laws that every factor obeys, on random boxes and for every method with a proved radius: two numbers that a law calls equal
//! have intervals that meet, two that it orders have intervals that can be so ordered. Laws on fixed examples: `aligned_factors.rs`;
//! of whole systems: `zonal-solve`; additivity on thousands of pairs: `intervals.rs`.

use proptest::prelude::*;
use zonal_exchange::AccuracyRequest;
use zonal_exchange::aligned::lattice::GridTables;
use zonal_exchange::aligned::{Cuboid, FactorCache, geometric_factor};
use zonal_exchange::pair::{Exchange, PairCounts};
use zonal_math::{Bounded, Grade, Vec3, vec3};
use zonal_paper::{gauss_6d, point};
use zonal_scene::{Bands, Facet, Plate, Scene, SceneParts, SolveOptions, Surface, VoxelGrid};
use zonal_transport::{Transport, build_zones};

const TOLERANCE: f64 = 1e-7;

/// A method that takes any two boxes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum BoxMethod {
    Aligned,
    Cache,
    Point,
    SixGauss,
}

const METHODS: [BoxMethod; 4] = [BoxMethod::Aligned, BoxMethod::Cache, BoxMethod::Point, BoxMethod::SixGauss];

/// The factor.
fn method_factor(method: BoxMethod, a: &Cuboid, b: &Cuboid, kappa: f64) -> Bounded {
    let demand = AccuracyRequest { tolerance: TOLERANCE, max_evaluations: 5_000 };
    let f = match method {
        BoxMethod::Aligned => geometric_factor(a, b, kappa, TOLERANCE).bounded,
        BoxMethod::Cache => FactorCache::new(TOLERANCE).get(a, b, kappa),
        BoxMethod::Point => point::factor(a, b, kappa).bounded,
        BoxMethod::SixGauss => gauss_6d::factor(a, b, kappa, &demand).bounded,
    };
    assert_eq!(f.grade, Grade::Proved, "{method:?}");
    f
}

/// Intervals that meet; the law's own arithmetic is granted a few roundings of the values.
fn intervals_meet(x: Bounded, y: Bounded) -> bool {
    let slack = 16.0 * f64::EPSILON * x.value.abs().max(y.value.abs());
    (x.value - y.value).abs() <= x.radius + y.radius + slack
}

/// Boxes on a lattice of eighths, so that every method, the cache's key included, sees the very same lengths.
fn any_box() -> impl Strategy<Value = Cuboid> {
    let place = || prop::array::uniform3(-16i32..16);
    let length = || prop::array::uniform3(prop::sample::select(vec![1i32, 2, 4, 8]));
    (place(), length(), 0usize..9).prop_map(|(lo, len, shape)| {
        let lo = lo.map(|x| 0.125 * x as f64);
        let mut hi: [f64; 3] = std::array::from_fn(|k| lo[k] + 0.125 * len[k] as f64);
        let normal = (shape < 6).then_some((shape / 2, if shape % 2 == 0 { 1 } else { -1 }));
        if let Some((axis, _)) = normal {
            hi[axis] = lo[axis];
        }
        Cuboid { lo: Vec3::from_array(lo), hi: Vec3::from_array(hi), normal }
    })
}

fn any_kappa() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), (-3.0..1.7f64).prop_map(|e| 10f64.powf(e))]
}

/// Axis k of the image is axis p[k] of the box, reflected where `flip` says so, scaled and moved.
fn image(z: &Cuboid, p: [usize; 3], flip: [bool; 3], scale: f64, by: Vec3) -> Cuboid {
    let (mut lo, mut hi) = ([0.0; 3], [0.0; 3]);
    for k in 0..3 {
        let (l, h) = if flip[k] { (-z.hi[p[k]], -z.lo[p[k]]) } else { (z.lo[p[k]], z.hi[p[k]]) };
        (lo[k], hi[k]) = (scale * l + by[k], scale * h + by[k]);
    }
    let normal = z.normal.map(|(axis, sign)| {
        let k = p.iter().position(|&x| x == axis).unwrap();
        (k, if flip[k] { -sign } else { sign })
    });
    Cuboid { lo: Vec3::from_array(lo), hi: Vec3::from_array(hi), normal }
}

const PERMUTATIONS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];

/// Upper bound of a factor: a patch sends no more than its area, a point of a voxel 4π/π lines of at most the longest chord of the other box.
fn most(a: &Cuboid, b: &Cuboid) -> f64 {
    let one = |x: &Cuboid, y: &Cuboid| {
        let reach = if y.normal.is_some() { 1.0 } else { y.extent().length() };
        reach * x.measure() * if x.normal.is_some() { 1.0 } else { 4.0 }
    };
    one(a, b).min(one(b, a))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn factors_are_reciprocal(a in any_box(), b in any_box(), kappa in any_kappa()) {
        for m in METHODS {
            let (x, y) = (method_factor(m, &a, &b, kappa), method_factor(m, &b, &a, kappa));
            // To the bit where it is stored, within the radii elsewhere.
            prop_assert!(if m == BoxMethod::Cache { x == y } else { intervals_meet(x, y) }, "{m:?} {x:?} {y:?}");
        }
    }

    #[test]
    fn all_methods_agree(a in any_box(), b in any_box(), kappa in any_kappa()) {
        let x = method_factor(BoxMethod::Aligned, &a, &b, kappa);
        for m in METHODS {
            let y = method_factor(m, &a, &b, kappa);
            prop_assert!(intervals_meet(x, y), "{m:?} {x:?} {y:?}");
        }
    }

    #[test]
    fn factors_are_invariant_under_scaling_translation_and_the_48_symmetries(
        a in any_box(), b in any_box(), kappa in any_kappa(),
        p in 0usize..6, flip in any::<[bool; 3]>(), e in -3i32..4, by in prop::array::uniform3(-40i32..40),
    ) {
        let (s, by) = (2f64.powi(e), Vec3::from_array(by.map(|x| 0.5 * x as f64)));
        let to = |z: &Cuboid| image(z, PERMUTATIONS[p], flip, s, by);
        let patches = a.normal.is_some() as i32 + b.normal.is_some() as i32;
        for m in METHODS {
            let (x, y) = (method_factor(m, &a, &b, kappa), method_factor(m, &to(&a), &to(&b), kappa / s));
            let y = Bounded { value: y.value * s.powi(patches - 4), radius: y.radius * s.powi(patches - 4), ..y };
            prop_assert!(intervals_meet(x, y), "{m:?} {x:?} {y:?}");
            if m == BoxMethod::Cache && s == 1.0 {
                prop_assert_eq!(x, y);
            }
        }
    }

    #[test]
    fn factors_are_additive(a in any_box(), b in any_box(), kappa in any_kappa(), axis in 0usize..3) {
        prop_assume!(b.lo[axis] < b.hi[axis]);
        let cut = |upper: bool| {
            let mid = 0.5 * (b.lo[axis] + b.hi[axis]);
            let (mut lo, mut hi) = (b.lo.array(), b.hi.array());
            if upper { lo[axis] = mid } else { hi[axis] = mid }
            Cuboid { lo: Vec3::from_array(lo), hi: Vec3::from_array(hi), ..b }
        };
        for m in METHODS {
            let whole = method_factor(m, &a, &b, kappa);
            let parts = [false, true].map(|u| method_factor(m, &a, &cut(u), kappa));
            prop_assert!(intervals_meet(whole, parts[0] + parts[1]), "{m:?} {whole:?} {parts:?}");
        }
    }

    #[test]
    fn factors_are_bounded_and_decrease_with_extinction(
        a in any_box(), b in any_box(), kappa in any_kappa(), more in 0.01..3.0f64,
    ) {
        for m in METHODS {
            let (x, y) = (method_factor(m, &a, &b, kappa), method_factor(m, &a, &b, kappa + more));
            prop_assert!(x.value >= -x.radius && x.value - x.radius <= most(&a, &b) * (1.0 + 1e-12), "{m:?} {x:?}");
            prop_assert!(y.value - y.radius <= x.value + x.radius, "{m:?} {x:?} {y:?}");
            // e^{−κr} between its values at the nearest and the farthest points.
            let gap = |k: usize| (b.lo[k] - a.hi[k]).max(a.lo[k] - b.hi[k]).max(0.0);
            let far = |k: usize| (b.hi[k] - a.lo[k]).abs().max((a.hi[k] - b.lo[k]).abs());
            let norm = |f: &dyn Fn(usize) -> f64| f(0).hypot(f(1)).hypot(f(2));
            let (least, most) = ((-more * norm(&far)).exp(), (-more * norm(&gap)).exp());
            let (low, high) = ((x.value - x.radius) * least, (x.value + x.radius) * most);
            let slack = 1.0 + 1e-12;
            prop_assert!(y.value + y.radius >= low / slack && y.value - y.radius <= high * slack, "{m:?} {x:?} {y:?}");
        }
    }

    /// The rows of a random box, cut at random, close at any depth: a patch's to its area, a voxel's to 4V.
    #[test]
    fn divided_boxes_close(
        size in prop::array::uniform3(0.3..2.0f64), cut in prop::array::uniform3(0.1..0.9f64), kappa in any_kappa(), who in 0usize..32,
    ) {
        let at = |k: usize, i: usize| [0.0, cut[k] * size[k], size[k]][i];
        let mut zones = vec![];
        for c in 0..8usize {
            let ijk = [c >> 2, c >> 1 & 1, c & 1];
            let corner = |d: usize| vec3(at(0, ijk[0] + d), at(1, ijk[1] + d), at(2, ijk[2] + d));
            let v = Cuboid::voxel(corner(0), corner(1));
            zones.push(v);
            for (w, wall) in v.walls().into_iter().enumerate() {
                if w % 2 == ijk[w / 2] {
                    zones.push(wall);
                }
            }
        }
        prop_assert_eq!(zones.len(), 32);
        let a = &zones[who];
        let strength = |z: &Cuboid| if z.normal.is_some() { 1.0 } else { kappa };
        let sum = zones
            .iter()
            .map(|b| geometric_factor(a, b, kappa, 1e-10).bounded * strength(b))
            .fold(Bounded::ZERO, |s, f| s + f);
        let want = a.measure() * if a.normal.is_some() { 1.0 } else { 4.0 };
        if kappa > 0.0 || a.normal.is_some() {
            prop_assert!((sum.value - want).abs() <= sum.radius + 1e-13 * want, "{sum:?} {want}");
        }
    }

    /// gs of a box to one of its walls: κV times the emission of a point as κ → 0, the wall's area as κ → ∞.
    #[test]
    fn gas_to_wall_area_has_thin_and_thick_limits(size in prop::array::uniform3(0.2..2.0f64), wall in 0usize..6) {
        let gas = Cuboid::voxel(Vec3::ZERO, Vec3::from_array(size));
        let walls = gas.walls();
        let gs = |kappa: f64, w: &Cuboid| geometric_factor(w, &gas, kappa, 1e-10).bounded * kappa;
        let thin: Bounded = walls.iter().map(|w| gs(1e-8, w)).fold(Bounded::ZERO, |s, f| s + f);
        prop_assert!((thin.value / (4e-8 * gas.measure()) - 1.0).abs() < 1e-7, "{thin:?}");
        // All but a rim of the thickness of a mean free path.
        let w = &walls[wall];
        let thick = gs(1e5, w).value / w.measure();
        prop_assert!(thick < 1.0 && thick > 1.0 - 5e-5 / size.into_iter().fold(f64::INFINITY, f64::min), "{thick}");
    }

    /// The tables by offset are the pairs themselves.
    #[test]
    fn offset_tables_equal_pair_factors(e in prop::array::uniform3(prop::sample::select(vec![0.125, 0.5, 1.0])), kappa in any_kappa(), o in prop::array::uniform3(-3i64..4), axis in 0usize..3) {
        let cell = Vec3::from_array(e);
        let moved = |o: [i64; 3]| cell.scale(Vec3::from_array(o.map(|x| x as f64)));
        let v = Cuboid::voxel(Vec3::ZERO, cell);
        let w = Cuboid::voxel(moved(o), moved(o) + cell);
        let table = GridTables::new(e, [4; 3], kappa, TOLERANCE).voxels();
        let direct = method_factor(BoxMethod::Aligned, &v, &w, kappa);
        prop_assert!(intervals_meet(table.get(o), direct), "{:?} {direct:?}", table.get(o));
        prop_assert_eq!(table.get(o), table.get(o.map(|x| -x)));
        // The wall below the voxels on this axis, `up` cells away.
        let mut up = o;
        up[axis] = up[axis].abs();
        let wall = Cuboid { normal: Some((axis, 1)), ..v.walls()[2 * axis] };
        let high = Cuboid::voxel(moved(up), moved(up) + cell);
        let walls = GridTables::new(e, [4; 3], kappa, TOLERANCE).wall(axis);
        let direct = method_factor(BoxMethod::Aligned, &wall, &high, kappa);
        prop_assert!(intervals_meet(walls.get(up), direct), "{:?} {direct:?}", walls.get(up));
    }
}

/// A box with black walls and a voxel grid; κ of each cell from `kappa`.
fn room(kappa: impl Fn(usize) -> f64) -> Scene {
    let mut map = VoxelGrid::new(Vec3::ZERO, vec3(0.5, 0.4, 0.6), [2, 3, 2]).unwrap();
    for i in 0..map.len() {
        map.set(i, Bands::splat(kappa(i)), Bands::splat(0.5), Bands::ZERO, Bands::ZERO);
    }
    let (x, y, z) = (vec3(1.0, 0.0, 0.0), vec3(0.0, 1.2, 0.0), vec3(0.0, 0.0, 1.2));
    let surface = Surface {
        name: "wall".into(),
        reflectance: Bands::ZERO,
        patch_size: Some(0.6),
        ..Surface::default()
    };
    let plates =
        [(Vec3::ZERO, x, y), (z, y, x), (Vec3::ZERO, y, z), (x, z, y), (Vec3::ZERO, z, x), (y, x, z)];
    let facets = plates
        .map(|(o, u, v)| Facet { surface: 0, plate: Plate::parallelogram(o, u, v), uv: [[0.0; 2]; 3] })
        .to_vec();
    Scene::new(SceneParts {
        surfaces: vec![surface],
        facets,
        voxel_grid: Some(map.seal().unwrap()),
        options: SolveOptions { patch_size: Some(0.6), ..SolveOptions::default() },
        ..SceneParts::default()
    })
    .unwrap()
}

/// Exchange of pairs: a nearly constant field gives the factors of the uniform medium, symmetric to the bit; rows close.
#[test]
fn constant_field_equals_uniform_medium() {
    for kappa in [0.02, 0.3, 1.0] {
        let scenes = [room(|_| kappa), room(|i| kappa * (1.0 + 1e-12 * i as f64))];
        let rows = scenes.each_ref().map(|scene| {
            let transport = Transport::new(scene);
            let zones = build_zones(scene, &transport).unwrap();
            let exchange = Exchange::new(scene, &zones, &transport);
            let mut counts = PairCounts::default();
            let n = zones.len();
            let mut g = vec![0.0; n * n];
            for i in 0..n {
                for j in 0..n {
                    g[i * n + j] = exchange.pair(i, j, &mut counts).value.first();
                }
            }
            for i in 0..n {
                assert!((0..n).all(|j| g[i * n + j] == g[j * n + i]));
                let c = |j: usize| if j < zones.voxel_offset() { 1.0 } else { kappa };
                let sum: f64 = (0..n).map(|j| g[i * n + j] * c(j)).sum();
                let want = zonal_exchange::pair::closure_target(&zones, i);
                assert!((sum / want - 1.0).abs() < 2e-3, "{kappa} zone {i}: {sum} {want}");
            }
            g
        });
        let largest = rows[0].iter().fold(0.0f64, |m, &x| m.max(x));
        for (x, y) in rows[0].iter().zip(&rows[1]) {
            assert!((x - y).abs() <= 2e-3 * x.max(1e-3 * largest), "{kappa}: {x} {y}");
        }
    }
}
