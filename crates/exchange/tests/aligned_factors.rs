//! Aligned boxes against references, closed forms and laws.

use std::f64::consts::PI;
use zonal_exchange::Method;
use zonal_exchange::aligned::{Cuboid, DistanceCumulants, FactorCache, geometric_factor};
use zonal_math::{Bounded, Grade, Vec3, low_discrepancy, vec3};

/// Relative error of the reference table.
const REFERENCE_TABLE_ERROR: f64 = 2e-14;

fn factor(a: &Cuboid, b: &Cuboid, kappa: f64, tolerance: f64) -> Bounded {
    let f = geometric_factor(a, b, kappa, tolerance).bounded;
    assert_eq!(f.grade, Grade::Proved);
    assert!(
        f.radius <= tolerance * f.value,
        "radius {} above {tolerance} of {}: {a:?} {b:?} {kappa}",
        f.radius,
        f.value
    );
    f
}

fn close(got: f64, want: f64, relative: f64, what: &str) {
    assert!(
        (got - want).abs() <= relative * want.abs(),
        "{what}: {got} against {want}, off by {:e}",
        got / want - 1.0
    );
}

fn cube(x: f64, y: f64, z: f64) -> Cuboid {
    Cuboid::voxel(vec3(x, y, z), vec3(x + 1.0, y + 1.0, z + 1.0))
}

struct Row {
    a: Cuboid,
    b: Cuboid,
    kappa: f64,
    want: f64,
}

fn rows() -> Vec<Row> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/direct_exchange.csv");
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().skip(1).map(row).collect()
}

fn row(line: &str) -> Row {
    let c: Vec<&str> = line.split(',').collect();
    let number = |i: usize| c[i].parse::<f64>().unwrap();
    let zone = |i: usize| {
        let (lo, hi) = (
            vec3(number(i), number(i + 2), number(i + 4)),
            vec3(number(i + 1), number(i + 3), number(i + 5)),
        );
        let normal = (!c[i + 6].is_empty()).then(|| {
            let sign = if c[i + 6].starts_with('-') { -1 } else { 1 };
            ("xyz".find(&c[i + 6][1..]).unwrap(), sign)
        });
        Cuboid { lo, hi, normal }
    };
    Row { a: zone(1), b: zone(8), kappa: number(15), want: number(16) }
}

// Guards (numbers): methods take a tolerance and return value, radius and grade; a proved radius contains the true value and meets the tolerance.
#[test]
fn reference_table_holds_at_every_tolerance() {
    let rows = rows();
    assert_eq!(rows.len(), 190);
    for tolerance in [1e-4, 1e-6, 1e-8, 1e-10, 1e-12] {
        for r in &rows {
            let f = factor(&r.a, &r.b, r.kappa, tolerance);
            let off = (f.value - r.want).abs();
            assert!(
                off <= f.radius + REFERENCE_TABLE_ERROR * r.want,
                "{:?} {:?} {}: {off:e}, {f:?}",
                r.a,
                r.b,
                r.kappa
            );
        }
    }
}

// Guards (numbers): the cached factor of a pair does not depend on the order of the pair, to the bit.
#[test]
fn cache_gives_reference_table_in_both_orders() {
    let cache = FactorCache::new(1e-10);
    for r in rows() {
        let (f, g) = (cache.get(&r.a, &r.b, r.kappa), cache.get(&r.b, &r.a, r.kappa));
        assert_eq!(f, g);
        assert!(f.radius <= 1e-10 * f.value);
        // The key rounds lengths to 42 bits.
        assert!((f.value - r.want).abs() <= f.radius + 3e-12 * r.want, "{f:?} {}", r.want);
    }
}

#[test]
fn looser_tolerance_takes_fewer_evaluations() {
    let (a, b) = (cube(0.0, 0.0, 0.0), cube(1.0, 0.0, 0.0));
    let cost = [1e-3, 1e-6, 1e-9, 1e-12].map(|t| geometric_factor(&a, &b, 1.0, t).evaluations);
    assert!(cost.is_sorted() && 4 * cost[0] < cost[3], "{cost:?}");
    assert!(cost[3] < 10_000, "{cost:?}");
    let far = geometric_factor(&a, &cube(30.0, 7.0, 2.0), 1.0, 1e-10);
    assert!(far.evaluations <= 1500, "{far:?}");
    assert_eq!(far.method, Method::Gauss);
}

/// K, gg, gs, ss opposite, ss adjacent: shared/VALIDATION.md section 3.
const CUBE: [[f64; 5]; 9] = [
    [0.01, 0.000178729152, 0.006636878475, 0.197619448773, 0.198935918188],
    [0.1, 0.017349084555, 0.063775152574, 0.178841767779, 0.189345769912],
    [0.2, 0.067181244627, 0.122136459229, 0.160077043920, 0.179446624213],
    [0.5, 0.382367763855, 0.269605372691, 0.114854762298, 0.153884966253],
    [1.0, 1.323835261269, 0.446027456455, 0.066163677717, 0.121952216457],
    [2.0, 4.119440045729, 0.646759992379, 0.022092805040, 0.082786800645],
    [3.0, 7.510213675499, 0.748297720750, 0.007432357363, 0.061067480472],
    [5.0, 14.946026253016, 0.842328957831, 0.000857392293, 0.039203412469],
    [10.0, 34.490219869614, 0.918296688398, 0.000004209023, 0.020424775645],
];

#[test]
fn unit_cube_matches_published_digits() {
    let gas = cube(0.0, 0.0, 0.0);
    let walls = gas.walls();
    for [k, gg, gs, opposite, adjacent] in CUBE {
        let print = |x: f64, want: f64| assert!((x - want).abs() <= 0.51e-12, "{k}: {x} {want}");
        print(k * k * factor(&gas, &gas, k, 1e-12).value, gg);
        print(k * factor(&walls[0], &gas, k, 1e-12).value, gs);
        print(factor(&walls[0], &walls[1], k, 1e-12).value, opposite);
        print(factor(&walls[0], &walls[2], k, 1e-12).value, adjacent);
    }
}

/// All zones of the box [0, size] cut into n cells per axis: voxels, then wall patches.
fn enclosure(size: Vec3, n: [usize; 3]) -> (Vec<Cuboid>, Vec<Cuboid>) {
    let at = |k: usize, i: usize| size[k] * i as f64 / n[k] as f64;
    let (mut voxels, mut patches) = (vec![], vec![]);
    for i in 0..n[0] {
        for j in 0..n[1] {
            for k in 0..n[2] {
                let v = Cuboid::voxel(
                    vec3(at(0, i), at(1, j), at(2, k)),
                    vec3(at(0, i + 1), at(1, j + 1), at(2, k + 1)),
                );
                voxels.push(v);
                for (w, wall) in v.walls().into_iter().enumerate() {
                    let ijk = [i, j, k][w / 2];
                    if (w % 2 == 0 && ijk == 0) || (w % 2 == 1 && ijk + 1 == n[w / 2]) {
                        patches.push(wall);
                    }
                }
            }
        }
    }
    (voxels, patches)
}

// Guards (numbers): factors of split boxes close.
#[test]
fn split_boxes_close() {
    let cases = [
        (Vec3::ONE, [2, 2, 2], 0.0),
        (Vec3::ONE, [2, 2, 2], 1.3),
        (vec3(1.0, 2.5, 0.3), [3, 2, 4], 0.0),
        (vec3(1.0, 2.5, 0.3), [3, 2, 4], 2.7),
    ];
    for (size, n, kappa) in cases {
        let (voxels, patches) = enclosure(size, n);
        let cache = FactorCache::new(1e-12);
        for a in &patches {
            let walls: f64 = patches.iter().map(|b| cache.get(a, b, kappa).value).sum();
            let gas: f64 = voxels.iter().map(|b| cache.get(a, b, kappa).value).sum();
            close(walls + kappa * gas, a.measure(), 2e-11, "a patch's closure");
            if kappa == 0.0 {
                close(walls, a.measure(), 2e-11, "walls alone");
            }
        }
        for a in voxels.iter().filter(|_| kappa > 0.0) {
            let walls: f64 = patches.iter().map(|b| cache.get(a, b, kappa).value).sum();
            let gas: f64 = voxels.iter().map(|b| cache.get(a, b, kappa).value).sum();
            close(walls + kappa * gas, 4.0 * a.measure(), 2e-11, "a voxel's closure");
        }
    }
}

#[test]
fn split_boxes_close_without_cache() {
    let (voxels, patches) = enclosure(vec3(0.7, 1.0, 1.6), [2, 1, 2]);
    let kappa = 0.9;
    for a in voxels.iter().chain(&patches) {
        let sum = |zones: &[Cuboid]| {
            zones.iter().map(|b| geometric_factor(a, b, kappa, 1e-12).bounded.value).sum::<f64>()
        };
        let want = if a.normal.is_some() { 1.0 } else { 4.0 } * a.measure();
        close(sum(&patches) + kappa * sum(&voxels), want, 1e-11, "closure");
    }
}

/// The box cut at its midplanes.
fn pieces(b: &Cuboid) -> Vec<Cuboid> {
    let mid = 0.5 * (b.lo + b.hi);
    let mut out = vec![];
    for i in 0..8 {
        let pick = |k: usize| {
            let upper = i >> k & 1 == 1;
            if b.lo[k] == b.hi[k] {
                (!upper).then_some((b.lo[k], b.lo[k]))
            } else if upper {
                Some((mid[k], b.hi[k]))
            } else {
                Some((b.lo[k], mid[k]))
            }
        };
        if let (Some(x), Some(y), Some(z)) = (pick(0), pick(1), pick(2)) {
            out.push(Cuboid { lo: vec3(x.0, y.0, z.0), hi: vec3(x.1, y.1, z.1), normal: b.normal });
        }
    }
    out
}

fn additive(a: &Cuboid, b: &Cuboid, kappa: f64, tolerance: f64) {
    let whole = factor(a, b, kappa, tolerance);
    let sum = pieces(b)
        .iter()
        .map(|p| geometric_factor(a, p, kappa, tolerance).bounded)
        .fold(Bounded::ZERO, |s, f| s + f);
    assert!((sum.value - whole.value).abs() <= sum.radius + whole.radius, "{whole:?} {sum:?}: {a:?} {b:?}");
}

fn wall(lo: Vec3, hi: Vec3, axis: usize, sign: i8) -> Cuboid {
    Cuboid::patch(lo, hi, axis, sign)
}

// Guards (numbers): factors are additive over split boxes.
#[test]
fn factors_are_additive_over_split_box() {
    let floor = wall(vec3(-0.3, 0.1, 0.0), vec3(0.9, 1.4, 0.0), 2, 1);
    let side = wall(vec3(0.9, 0.2, -0.4), vec3(0.9, 1.1, 1.3), 0, -1);
    let lid = wall(vec3(0.2, -0.5, 0.8), vec3(1.7, 0.6, 0.8), 2, -1);
    let (a, b) = (
        Cuboid::voxel(vec3(0.0, 0.0, 0.0), vec3(0.7, 1.1, 1.9)),
        Cuboid::voxel(vec3(0.3, 0.9, -0.5), vec3(1.3, 1.6, 0.4)),
    );
    for kappa in [0.0, 0.8, 6.0, 40.0] {
        for x in [a, b, floor, side, lid] {
            for y in [a, b, floor, side, lid] {
                if geometric_factor(&x, &y, kappa, 1e-3).evaluations > 0 {
                    additive(&x, &y, kappa, 1e-11);
                }
            }
        }
    }
}

#[test]
fn narrow_gaps_and_thin_zones_keep_radius() {
    for gap in [1e-3, 1e-4, 1e-6] {
        for kappa in [0.0, 1.0] {
            additive(&cube(0.0, 0.0, 0.0), &cube(1.0 + gap, 0.3, 0.0), kappa, 1e-10);
            let floor = wall(vec3(0.0, 0.0, -gap), vec3(1.0, 1.0, -gap), 2, 1);
            let lid = wall(vec3(0.0, 0.0, 0.0), vec3(1.0, 1.0, 0.0), 2, -1);
            let side = wall(vec3(1.0 + gap, 0.0, 0.0), vec3(1.0 + gap, 1.0, 1.0), 0, -1);
            additive(&floor, &lid, kappa, 1e-10);
            additive(&floor, &side, kappa, 1e-10);
            additive(&floor, &cube(0.0, 0.0, 0.0), kappa, 1e-10);
        }
    }
    let sheet = Cuboid::voxel(Vec3::ZERO, vec3(1.0, 1.0, 1e-3));
    let needle = Cuboid::voxel(vec3(0.2, 0.3, 1e-3), vec3(0.201, 0.301, 1.0));
    let strip = wall(vec3(0.0, 0.0, 1e-3), vec3(1e-3, 1.0, 1e-3), 2, 1);
    for (a, b) in [(sheet, sheet), (sheet, needle), (needle, needle), (strip, needle), (needle, strip)] {
        additive(&a, &b, 0.5, 1e-10);
    }
}

// Guards (numbers): factors scale with the length.
#[test]
fn factors_scale_with_length() {
    let f = wall(vec3(0.0, 0.0, 0.0), vec3(1.0, 2.0, 0.0), 2, 1);
    let g = wall(vec3(1.0, 0.0, 0.0), vec3(1.0, 2.0, 1.5), 0, -1);
    let v = Cuboid::voxel(vec3(0.0, 0.5, 0.1), vec3(1.0, 1.5, 0.7));
    for s in [1e-6, 0.37, 1e5] {
        for (a, b, power) in [(v, v, 4), (f, v, 3), (f, g, 2)] {
            let big = |z: Cuboid| Cuboid { lo: z.lo * s, hi: z.hi * s, ..z };
            let x = factor(&a, &b, 1.2, 1e-11);
            let y = factor(&big(a), &big(b), 1.2 / s, 1e-11);
            close(y.value / s.powi(power), x.value, 2.1e-11, "scaling");
        }
    }
}

/// Axis k of the image is axis p[k] of the box, reflected where `flip` says so.
fn image(z: &Cuboid, p: [usize; 3], flip: [bool; 3]) -> Cuboid {
    let (mut lo, mut hi) = ([0.0; 3], [0.0; 3]);
    for k in 0..3 {
        (lo[k], hi[k]) = if flip[k] { (-z.hi[p[k]], -z.lo[p[k]]) } else { (z.lo[p[k]], z.hi[p[k]]) };
    }
    let normal = z.normal.map(|(axis, sign)| {
        let k = p.iter().position(|&x| x == axis).unwrap();
        (k, if flip[k] { -sign } else { sign })
    });
    Cuboid { lo: Vec3::from_array(lo), hi: Vec3::from_array(hi), normal }
}

// Guards (numbers): factors have the 48 symmetries of the cube.
#[test]
fn factors_have_48_cube_symmetries() {
    let floor = wall(vec3(0.0, 0.0, 0.0), vec3(1.0, 0.5, 0.0), 2, 1);
    let side = wall(vec3(1.25, 0.125, 0.0), vec3(1.25, 1.0, 0.75), 0, -1);
    let lid = wall(vec3(0.25, 0.125, 0.5), vec3(1.25, 1.0, 0.5), 2, -1);
    let (v, w) = (Cuboid::voxel(vec3(0.25, 0.5, 0.0), vec3(0.75, 1.5, 2.0)), cube(1.0, 0.25, -0.5));
    let cache = FactorCache::new(1e-9);
    for (a, b) in [(floor, side), (floor, lid), (floor, v), (side, w), (v, w)] {
        let direct = factor(&a, &b, 0.6, 1e-9);
        let kept = cache.get(&a, &b, 0.6);
        for p in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            for f in 0..8 {
                let flip = [f & 1 != 0, f & 2 != 0, f & 4 != 0];
                let (a, b) = (image(&a, p, flip), image(&b, p, flip));
                let again = factor(&a, &b, 0.6, 1e-9);
                assert!((again.value - direct.value).abs() <= again.radius + direct.radius);
                assert_eq!(cache.get(&a, &b, 0.6), kept);
            }
        }
    }
    assert_eq!(cache.len(), 5);
}

/// C-11: opposed rectangles x × y at distance c, the factor times the area.
fn opposed(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / c, b / c);
    let (x1, y1) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    let log = (x1 * y1 / (1.0 + x * x + y * y).sqrt()).ln();
    let arcs = x * y1 * (x / y1).atan() + y * x1 * (y / x1).atan() - x * x.atan() - y * y.atan();
    2.0 / (PI * x * y) * (log + arcs) * a * b
}

/// C-14: from w × l to h × l with the common edge l, times the area.
fn adjacent(h: f64, w: f64, l: f64) -> f64 {
    let (hh, ww) = (h / l, w / l);
    let (h2, w2) = (hh * hh, ww * ww);
    let d = (h2 + w2).sqrt();
    let arcs = ww * (1.0 / ww).atan() + hh * (1.0 / hh).atan() - d * (1.0 / d).atan();
    let all = 1.0 + h2 + w2;
    let logs = ((1.0 + w2) * (1.0 + h2) / all).ln()
        + w2 * (w2 * all / ((1.0 + w2) * d * d)).ln()
        + h2 * (h2 * all / ((1.0 + h2) * d * d)).ln();
    (arcs + 0.25 * logs) / (PI * ww) * w * l
}

#[test]
fn view_factors_match_closed_forms() {
    close(opposed(3.0, 2.0, 1.0) / 6.0, 0.47557643653295, 1e-13, "C-11");
    close(adjacent(2.0, 1.0, 1.0), 0.23285260279536, 1e-13, "C-14");
    for (a, b, c) in [
        (1.0, 1.0, 1.0),
        (10.0, 10.0, 1.0),
        (3.0, 2.0, 1.0),
        (1.0, 1.0, 10.0),
        (0.01, 5.0, 0.2),
        (1.0, 1.0, 1e-3),
    ] {
        let floor = wall(Vec3::ZERO, vec3(a, b, 0.0), 2, 1);
        let lid = wall(vec3(0.0, 0.0, c), vec3(a, b, c), 2, -1);
        // The closed form loses digits to cancellation at large distances.
        close(factor(&floor, &lid, 0.0, 1e-12).value, opposed(a, b, c), 1e-11, "C-11");
    }
    for (h, w, l) in [
        (1.0, 1.0, 1.0),
        (0.5, 1.0, 1.0),
        (2.0, 1.0, 1.0),
        (1.0, 1.0, 10.0),
        (3.0, 2.0, 1.0),
        (1.0, 1.0, 0.01),
        (1e-3, 1.0, 1.0),
    ] {
        let floor = wall(Vec3::ZERO, vec3(w, l, 0.0), 2, 1);
        let side = wall(Vec3::ZERO, vec3(0.0, l, h), 0, 1);
        close(factor(&floor, &side, 0.0, 1e-12).value, adjacent(h, w, l), 1e-10, "C-14");
    }
}

#[test]
fn weak_attenuation_tends_to_vacuum_factor() {
    let floor = wall(Vec3::ZERO, vec3(1.0, 1.0, 0.0), 2, 1);
    let side = wall(Vec3::ZERO, vec3(0.0, 1.0, 1.0), 0, 1);
    let v = cube(0.0, 0.0, 0.0);
    for (a, b) in [(v, v), (v, cube(2.0, 1.0, 0.0)), (floor, side), (floor, v)] {
        let none = factor(&a, &b, 0.0, 1e-12).value;
        let cumulants: DistanceCumulants = FactorCache::new(1e-12).get_cumulants(&a, &b);
        close(cumulants.factor.value, none, 2e-12, "the cumulants' factor");
        let weak = factor(&a, &b, 1e-9, 1e-12).value;
        assert!(weak < none);
        close(weak, none, 4e-9, "continuity");
        let some = factor(&a, &b, 1e-3, 1e-12).value;
        let mean = cumulants.mean_distance;
        close((none - some) / none, 1e-3 * mean, 1e-3 * mean, "the mean distance");
    }
}

#[test]
fn distant_pairs_tend_to_point_formula() {
    // F = (1/pi) (l^6/r^2) (1 + l^2/(6 r^2) + O(r^-4)) for cubes.
    for r in [1e2, 1e3, 1e4, 1e6] {
        let f = factor(&cube(0.0, 0.0, 0.0), &cube(0.6 * r, 0.8 * r, 0.0), 0.0, 1e-11);
        close(f.value * PI * r * r, 1.0 + 1.0 / (6.0 * r * r), 1e-11 + r.powi(-4), "far cubes");
    }
    let d = 1e4;
    let floor = wall(Vec3::ZERO, vec3(1.0, 1.0, 0.0), 2, 1);
    let lid = wall(vec3(0.0, 0.0, d), vec3(1.0, 1.0, d), 2, -1);
    close(factor(&floor, &lid, 1e-4, 1e-12).value, (-1.0f64).exp() / (PI * d * d), 1e-7, "far plates");
    let extinct = geometric_factor(&floor, &lid, 1.0, 1e-6).bounded;
    assert!(extinct.value == 0.0 && extinct.radius > 0.0 && extinct.radius < 1e-300);
}

#[test]
fn optically_thick_pairs_follow_beer_law() {
    // Self-absorption of a thick voxel: κ² F → 4 κ V − (surface)/1 + ..., closure with its six walls.
    let gas = cube(0.0, 0.0, 0.0);
    for kappa in [50.0, 300.0, 2000.0] {
        let own = factor(&gas, &gas, kappa, 1e-10).value;
        let walls: f64 = gas.walls().iter().map(|w| factor(&gas, w, kappa, 1e-10).value).sum();
        close(kappa * own + walls, 4.0, 1e-9, "closure of a thick voxel");
    }
}

#[test]
fn pairs_facing_away_are_exactly_zero() {
    let floor = wall(Vec3::ZERO, vec3(1.0, 1.0, 0.0), 2, 1);
    let beside = wall(vec3(1.0, 0.0, 0.0), vec3(2.0, 1.0, 0.0), 2, 1);
    let facing_away = wall(vec3(0.0, 0.0, 1.0), vec3(1.0, 1.0, 1.0), 2, 1);
    let back_to_back = wall(vec3(0.0, 0.0, -1.0), vec3(1.0, 1.0, -1.0), 2, -1);
    let below = wall(vec3(1.0, 0.0, -1.0), vec3(1.0, 1.0, 0.0), 0, -1);
    let cache = FactorCache::new(1e-8);
    for b in [floor, beside, facing_away, back_to_back, below, cube(0.0, 0.0, -1.0)] {
        assert_eq!(geometric_factor(&floor, &b, 0.5, 1e-8).bounded, Bounded::ZERO, "{b:?}");
        assert_eq!(geometric_factor(&b, &floor, 0.5, 1e-8).method, Method::NotVisible);
        assert_eq!(cache.get(&floor, &b, 0.5), Bounded::ZERO);
        assert_eq!(cache.get_cumulants(&b, &floor).factor, Bounded::ZERO);
    }
    assert!(cache.is_empty());
}

#[test]
fn cache_agrees_with_direct_value_on_rounded_lattice() {
    // Edges of 0.1 m at 3.7 m: every coordinate is rounded, but a 5³ grid still has 56 offsets.
    let at = |i: usize| 3.7 + 0.1 * i as f64;
    let grid: Vec<Cuboid> = (0..125)
        .map(|c| {
            let [i, j, k] = [c % 5, c / 5 % 5, c / 25];
            Cuboid::voxel(vec3(at(i), at(j), at(k)), vec3(at(i + 1), at(j + 1), at(k + 1)))
        })
        .collect();
    let cache = FactorCache::new(1e-9);
    for a in &grid {
        for b in &grid {
            let kept = cache.get(a, b, 1.0);
            assert_eq!(kept, cache.get(b, a, 1.0));
        }
    }
    assert!((35..=70).contains(&cache.len()), "{}", cache.len());
    for b in grid.iter().step_by(7) {
        let (kept, direct) = (cache.get(&grid[3], b, 1.0), factor(&grid[3], b, 1.0, 1e-9));
        assert!((kept.value - direct.value).abs() <= kept.radius + direct.radius + 3e-12 * direct.value);
    }
}

// Guards (determinism): factors do not depend on the number of threads.
#[test]
fn cache_does_not_depend_on_threads() {
    let zones: Vec<Cuboid> =
        (0..6).flat_map(|i| [cube(i as f64, 0.5 * i as f64, 0.0), cube(0.0, i as f64, 2.0)]).collect();
    let fill = |cache: &FactorCache| {
        zones.iter().map(|z| cache.get(&zones[0], z, 0.7).value.to_bits()).collect::<Vec<_>>()
    };
    let alone = fill(&FactorCache::new(1e-8));
    let shared = FactorCache::new(1e-8);
    std::thread::scope(|s| {
        let all: Vec<_> = (0..4).map(|_| s.spawn(|| fill(&shared))).collect();
        for t in all {
            assert_eq!(t.join().unwrap(), alone);
        }
    });
}

/// A box or patch from hashed numbers: on a lattice, at random, or of extreme aspect ratio, near or far.
fn any_zone(seed: u64) -> Cuboid {
    let u = |i: u64| low_discrepancy::hash_to_unit(seed * 16 + i);
    let style = seed / 2 % 3;
    let length = |i: u64| match style {
        0 => 0.1 * (1.0 + (3.0 * u(i)).floor()),
        1 => 0.2 + u(i),
        _ => 10f64.powf(-4.0 * u(i)),
    };
    let place = |i: u64| match style {
        0 => 0.1 * (7.0 * u(i)).floor() - 0.3,
        1 => 3.0 * u(i) - 1.5,
        _ if u(i) < 0.4 => 0.0,
        _ => (u(i + 3) - 0.5) * 10f64.powf(11.0 * u(i) - 9.0),
    };
    let lo = vec3(place(3), place(4), place(5));
    let hi = lo + vec3(length(0), length(1), length(2));
    if u(9) < 0.5 {
        return Cuboid::voxel(lo, hi);
    }
    let axis = (3.0 * u(10)) as usize;
    let mut corner = hi.array();
    corner[axis] = lo[axis];
    Cuboid::patch(lo, Vec3::from_array(corner), axis, if u(11) < 0.5 { 1 } else { -1 })
}

// Guards (numbers): methods take a tolerance and return value, radius and grade; a proved radius contains the true value and meets the tolerance.
#[test]
fn radii_hold_for_extreme_aspect_ratios() {
    let cache = FactorCache::new(1e-5);
    let mut seen = 0;
    for i in 0..1500u64 {
        let (a, b) = (any_zone(2 * i), any_zone(2 * i + 1));
        let kappa = [0.0, 10f64.powf(5.0 * low_discrepancy::hash_to_unit(i) - 3.0)][(i / 3 % 2) as usize];
        assert_eq!(cache.get(&a, &b, kappa), cache.get(&b, &a, kappa));
        let fine = geometric_factor(&a, &b, kappa, 1e-11).bounded;
        if fine.value < 1e-280 {
            continue;
        }
        seen += 1;
        for tolerance in [1e-2, 1e-4, 1e-7, 1e-9] {
            let rough = factor(&a, &b, kappa, tolerance);
            assert!(
                (rough.value - fine.value).abs() <= rough.radius + fine.radius,
                "{i}: {rough:?} {fine:?} {a:?} {b:?} {kappa}"
            );
        }
    }
    assert!(seen > 600, "{seen}");
}
