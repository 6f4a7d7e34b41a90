//! Plates in any position against closed forms, references and laws.

use std::f64::consts::PI;
use zonal_exchange::aligned::{Cuboid, geometric_factor};
use zonal_exchange::polygon::{PreparedPlates, plate_plate};
use zonal_exchange::solid_angle::projected_solid_angle;
use zonal_exchange::{AccuracyRequest, Factor, Method};
use zonal_math::{Bounded, Grade, Vec3, gauss_jacobi, gauss_legendre, vec3};
use zonal_scene::{Plate, PlateKind};

/// Relative error of the reference table, and of the rounding of its rotated corners.
const REFERENCE_TABLE_ERROR: f64 = 2e-14;

struct SplitMix64(u64);

impl SplitMix64 {
    /// Uniform in [0, 1) (splitmix64).
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
    fn vector(&mut self) -> Vec3 {
        vec3(self.roll() - 0.5, self.roll() - 0.5, self.roll() - 0.5)
    }
    fn frame(&mut self) -> Frame {
        let x = self.vector().normalized();
        let y = x.cross(self.vector()).normalized();
        Frame { axes: [x, y, x.cross(y)], shift: self.vector() }
    }
}

/// A rotation and a shift.
#[derive(Clone, Copy)]
struct Frame {
    axes: [Vec3; 3],
    shift: Vec3,
}

impl Frame {
    fn turn(&self, v: Vec3) -> Vec3 {
        self.axes[0] * v.x + self.axes[1] * v.y + self.axes[2] * v.z
    }
    fn at(&self, v: Vec3) -> Vec3 {
        self.turn(v) + self.shift
    }
    fn plate(&self, p: &Plate) -> Plate {
        Plate { origin: self.at(p.origin), e1: self.turn(p.e1), e2: self.turn(p.e2), kind: p.kind }
    }
}

fn wall(c: &Cuboid) -> Plate {
    let (axis, sign) = c.normal.unwrap();
    let (e, mut edges) = (c.extent().array(), [[0.0; 3]; 2]);
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    edges[0][u] = e[u];
    edges[1][v] = e[v];
    let p = Plate::parallelogram(c.lo, Vec3::from_array(edges[0]), Vec3::from_array(edges[1]));
    if sign > 0 { p } else { p.flipped() }
}

/// The factor, checked to meet its request and to be proved.
fn checked_factor(a: &Plate, b: &Plate, kappa: f64, tolerance: f64) -> Factor {
    let f = plate_plate(a, b, kappa, AccuracyRequest::relative(tolerance));
    assert_eq!(f.bounded.grade, Grade::Proved);
    let Factor { bounded, method, .. } = f;
    assert!(
        bounded.radius <= tolerance * bounded.value,
        "{bounded:?} at {tolerance} by {method:?}: {a:?} {b:?}"
    );
    f
}

fn c11(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / c, b / c);
    let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    let log = 0.5 * (p * p * q * q / (1.0 + x * x + y * y)).ln();
    let arcs = x * q * (x / q).atan() + y * p * (y / p).atan() - x * x.atan() - y * y.atan();
    2.0 / (PI * x * y) * (log + arcs)
}

fn c14(h: f64, w: f64, l: f64) -> f64 {
    let (h, w) = (h / l, w / l);
    let (h2, w2) = (h * h, w * w);
    let s = 1.0 + h2 + w2;
    let arcs =
        w * (1.0 / w).atan() + h * (1.0 / h).atan() - (h2 + w2).sqrt() * (1.0 / (h2 + w2).sqrt()).atan();
    let logs = ((1.0 + w2) * (1.0 + h2) / s).ln()
        + w2 * (w2 * s / ((1.0 + w2) * (w2 + h2))).ln()
        + h2 * (h2 * s / ((1.0 + h2) * (h2 + w2))).ln();
    (arcs + 0.25 * logs) / (PI * w)
}

#[test]
fn opposed_and_perpendicular_rectangles_match_closed_forms() {
    let mut rng = SplitMix64(1);
    check_opposed_rectangles(&mut rng);
    check_perpendicular_rectangles(&mut rng);
}

/// Printed values, and the formula for the digits beyond.
fn check_opposed_rectangles(rng: &mut SplitMix64) {
    let printed = [
        ([1., 1., 1.], 0.19982489569839),
        ([1., 1., 2.], 0.068589588818552),
        ([2., 2., 1.], 0.41525328357715),
        ([1., 2., 1.], 0.28587538485071),
        ([1., 1., 5.], 0.012403977313245),
        ([1., 1., 10.], 0.0031620568387576),
        ([10., 10., 1.], 0.82699452239726),
        ([3., 2., 1.], 0.47557643653295),
    ];
    for ([a, b, c], want) in printed {
        let (u, v) = (vec3(a, 0.0, 0.0), vec3(0.0, b, 0.0));
        let (p, q) = (Plate::parallelogram(Vec3::ZERO, u, v), Plate::parallelogram(vec3(0.0, 0.0, c), v, u));
        // The formula of the test itself cancels by (c/a)⁴.
        assert!((c11(a, b, c) / want - 1.0).abs() < 1e-13 * (10.0 + c.powi(4)));
        let frame = rng.frame();
        for (p, q) in [(p, q), (frame.plate(&p), frame.plate(&q))] {
            // The closed form itself cancels by (c/a)⁴.
            let f = checked_factor(&p, &q, 0.0, 1e-12_f64.max(1e-14 * c.powi(4))).bounded;
            let off = (f.value / (a * b) - want).abs();
            assert!(
                off <= f.radius / (a * b) + 1e-13 * want + 1e-15 * c.powi(2),
                "C-11 {a} {b} {c}: {off:e} {f:?}"
            );
        }
    }
}

/// Printed values, and the formula for the digits beyond.
fn check_perpendicular_rectangles(rng: &mut SplitMix64) {
    let printed = [
        ([1., 1., 1.], 0.2000437760754),
        ([1., 2., 1.], 0.11642630139768),
        ([2., 1., 1.], 0.23285260279536),
        ([2., 2., 1.], 0.14929979588676),
        ([0.5, 1., 1.], 0.14618667910571),
        ([1., 1., 2.], 0.24063600617696),
        ([1., 1., 10.], 0.2818878067879),
        ([3., 2., 1.], 0.16169401433303),
    ];
    for ([h, w, l], want) in printed {
        let (x, y, z) = (vec3(l, 0.0, 0.0), vec3(0.0, w, 0.0), vec3(0.0, 0.0, h));
        let (p, q) = (Plate::parallelogram(Vec3::ZERO, x, y), Plate::parallelogram(Vec3::ZERO, z, x));
        let (exact, frame) = (c14(h, w, l), rng.frame());
        assert!((exact / want - 1.0).abs() < 4e-13);
        for (p, q) in [(p, q), (frame.plate(&p), frame.plate(&q))] {
            let f = checked_factor(&p, &q, 0.0, 2e-11).bounded;
            let off = (f.value / (w * l) - exact).abs();
            assert!(off <= 1e-13 * exact, "C-14 {h} {w} {l}: {off:e} {f:?}");
        }
    }
}

struct Row {
    a: Cuboid,
    b: Cuboid,
    kappa: f64,
    want: f64,
}

/// Rows of the reference table of one kind.
fn rows(kind: &str) -> Vec<Row> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/direct_exchange.csv");
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().skip(1).filter(|l| l.starts_with(kind)).map(row).collect()
}

fn row(line: &str) -> Row {
    let c: Vec<&str> = line.split(',').collect();
    let number = |i: usize| c[i].parse::<f64>().unwrap();
    let zone = |i: usize| {
        let lo = vec3(number(i), number(i + 2), number(i + 4));
        let hi = vec3(number(i + 1), number(i + 3), number(i + 5));
        let normal = (!c[i + 6].is_empty()).then(|| {
            let sign = if c[i + 6].starts_with('-') { -1 } else { 1 };
            ("xyz".find(&c[i + 6][1..]).unwrap(), sign)
        });
        Cuboid { lo, hi, normal }
    };
    Row { a: zone(1), b: zone(8), kappa: number(15), want: number(16) }
}

#[test]
fn rotated_reference_rows_match() {
    let mut rng = SplitMix64(2);
    let rows = rows("ss");
    assert!(rows.len() >= 10);
    for r in rows.iter().filter(|r| r.kappa == 0.0) {
        for tolerance in [1e-3, 1e-6, 1e-9] {
            let frame = rng.frame();
            let (a, b) = (frame.plate(&wall(&r.a)), frame.plate(&wall(&r.b)));
            let f = checked_factor(&a, &b, 0.0, tolerance).bounded;
            let off = (f.value - r.want).abs();
            assert!(off <= f.radius + REFERENCE_TABLE_ERROR * r.want, "{:?} {:?}: {off:e} {f:?}", r.a, r.b);
        }
    }
}

fn random_triangle(rng: &mut SplitMix64, at: Vec3, size: f64) -> Plate {
    let c = [0, 1, 2].map(|_| at + rng.vector() * size);
    Plate::triangle(c[0], c[1], c[2])
}

/// (1/π) ∫_a ω⊥(x; b) dA by rules of high order on parts of a; b wholly in front of a's plane, a of b's.
fn by_solid_angle(a: &Plate, b: &Plate) -> f64 {
    let (first, second, mut sum) = (gauss_jacobi::rule(16), gauss_legendre::rule(16), 0.0);
    for p in a.quarters().iter().flat_map(|q| q.quarters()) {
        assert_eq!(p.kind, PlateKind::Triangle);
        for (u, wu) in first.nodes.iter().zip(&first.weights) {
            for (v, wv) in second.nodes.iter().zip(&second.weights) {
                let x = p.at(*u, (1.0 - u) * v);
                sum += wu * wv * p.area() * projected_solid_angle(b, x, a.normal());
            }
        }
    }
    sum / PI
}

fn in_front(a: &Plate, b: &Plate) -> bool {
    let (c, n) = b.corners();
    c[..n].iter().all(|c| a.normal().dot(*c - a.origin) > 0.02)
}

#[test]
fn random_triangles_match_solid_angle_integrals() {
    let mut rng = SplitMix64(3);
    let (mut far, mut near) = (0, 0);
    while far < 40 || near < 40 {
        let a = random_triangle(&mut rng, Vec3::ZERO, 1.0);
        let at = rng.vector() * 4.0;
        let size = 0.2 + rng.roll();
        let b = random_triangle(&mut rng, at, size);
        if !(in_front(&a, &b) && in_front(&b, &a)) || a.area().min(b.area()) < 0.02 {
            continue;
        }
        let want = by_solid_angle(&a, &b);
        for tolerance in [1e-2, 1e-5, 1e-9] {
            let f = plate_plate(&a, &b, 0.0, AccuracyRequest::relative(tolerance));
            let off = (f.bounded.value - want).abs();
            assert!(off <= f.bounded.radius + 1e-12 * want, "{off:e} {f:?}: {a:?} {b:?}");
            assert!(f.bounded.radius <= tolerance * f.bounded.value, "{tolerance} {f:?}");
            match f.method {
                Method::Oblique => far += 1,
                Method::Contour => near += 1,
                m => panic!("{m:?}"),
            }
        }
    }
}

#[test]
fn plate_factors_are_symmetric_to_the_bit() {
    let mut rng = SplitMix64(4);
    let mut seen = 0;
    for _ in 0..300 {
        let a = random_triangle(&mut rng, Vec3::ZERO, 1.0);
        let at = rng.vector() * 2.0;
        let b = random_triangle(&mut rng, at, 1.0);
        let demand = AccuracyRequest::relative(1e-7);
        let (f, g) = (plate_plate(&a, &b, 0.0, demand), plate_plate(&b, &a, 0.0, demand));
        assert_eq!(f, g);
        seen += (f.bounded.value > 0.0) as usize;
    }
    assert!(seen > 50, "{seen}");
}

#[test]
fn plate_factors_are_additive_across_plane_cuts() {
    let mut rng = SplitMix64(5);
    let mut cut = 0;
    for _ in 0..400 {
        let a = random_triangle(&mut rng, Vec3::ZERO, 1.0);
        let at = rng.vector();
        let b = random_triangle(&mut rng, at, 1.0);
        if a.area().min(b.area()) < 0.01 {
            continue;
        }
        let demand = AccuracyRequest::relative(1e-8);
        let whole = plate_plate(&a, &b, 0.0, demand).bounded;
        let (c, _) = a.corners();
        let middle = c[0] * 0.3 + c[1] * 0.7;
        let parts = [Plate::triangle(c[0], middle, c[2]), Plate::triangle(middle, c[1], c[2])];
        let [p, q] = parts.map(|p| plate_plate(&p, &b, 0.0, demand).bounded);
        let off = (whole.value - p.value - q.value).abs();
        // The middle is rounded.
        assert!(
            off <= whole.radius + p.radius + q.radius + 1e-15,
            "{off:e} {whole:?} {p:?} {q:?}: {a:?} {b:?}"
        );
        cut += (whole.value > 0.0 && !(in_front(&a, &b) && in_front(&b, &a))) as usize;
    }
    assert!(cut > 50, "{cut}");
}

/// The walls of a box in triangles that look inwards.
fn box_of_triangles(rng: &mut SplitMix64, edges: Vec3) -> Vec<Plate> {
    let frame = rng.frame();
    let mut out = Vec::new();
    for w in Cuboid::voxel(Vec3::ZERO, edges).walls() {
        let p = frame.plate(&wall(&w));
        let (s, t) = (0.2 + 0.6 * rng.roll(), 0.2 + 0.6 * rng.roll());
        let (inner, (c, _)) = (p.at(s, t), p.corners());
        out.extend((0..4).map(|k| Plate::triangle(c[k], c[(k + 1) % 4], inner)));
    }
    out
}

#[test]
fn rotated_boxes_close() {
    let mut rng = SplitMix64(6);
    for edges in [vec3(1.0, 1.0, 1.0), vec3(1.0, 3.0, 0.2), vec3(40.0, 1.0, 1.0), vec3(1e-4, 2e-4, 3e-4)] {
        let plates = box_of_triangles(&mut rng, edges);
        let ready = PreparedPlates::new(&plates);
        for (i, p) in plates.iter().enumerate() {
            let others = (0..plates.len()).filter(|j| *j != i);
            let s = others.fold(Bounded::ZERO, |s, j| s + ready.pair(i, j, 1e-9, 1e-12).bounded);
            assert_eq!(s.grade, Grade::Proved);
            assert!(
                (s.value - p.area()).abs() <= s.radius + 2e-14 * p.area(),
                "{edges:?} {s:?} {}",
                p.area()
            );
            assert!(s.radius <= 1e-8 * p.area(), "{edges:?} {s:?} {}", p.area());
        }
    }
}

#[test]
fn rotated_rectangles_match_reduced_integral() {
    let mut rng = SplitMix64(8);
    for _ in 0..60 {
        let size = |d: &mut SplitMix64| 10f64.powf(-2.0 + 2.5 * d.roll());
        let lo = [vec3(0.0, 0.0, 0.0), rng.vector() * 2.0 + vec3(0.0, 0.0, 1.2)];
        let floor = Cuboid::patch(lo[0], vec3(size(&mut rng), size(&mut rng), 0.0), 2, 1);
        let (x, y) = (size(&mut rng), size(&mut rng));
        let other = if rng.roll() < 0.5 {
            Cuboid::patch(lo[1], lo[1] + vec3(x, y, 0.0), 2, -1)
        } else {
            let sign = if rng.roll() < 0.5 { 1 } else { -1 };
            Cuboid::patch(lo[1], lo[1] + vec3(0.0, x, y), 0, sign)
        };
        let want = geometric_factor(&floor, &other, 0.0, 1e-11).bounded;
        let frame = rng.frame();
        let f = plate_plate(
            &frame.plate(&wall(&floor)),
            &frame.plate(&wall(&other)),
            0.0,
            AccuracyRequest::relative(1e-7),
        );
        let off = (f.bounded.value - want.value).abs();
        let slack = 1e-15 * wall(&floor).diameter().max(wall(&other).diameter());
        assert!(off <= f.bounded.radius + want.radius + slack, "{off:e} {f:?} {want:?} {floor:?} {other:?}");
    }
}

/// Needles, plates nearly parallel and nearly touching, sizes far apart: the whole and its four quarters have other edges and take other branches.
#[test]
fn extreme_pairs_are_additive_over_quarters() {
    let mut rng = SplitMix64(9);
    let (mut seen, mut exact) = (0, 0);
    for _ in 0..1_500 {
        let power = |d: &mut SplitMix64, lo: f64| 10f64.powf(lo * d.roll());
        let (aspect, gap, tilt) = (power(&mut rng, -4.0), power(&mut rng, -8.0), power(&mut rng, -12.0));
        let a = Plate::triangle(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(rng.roll(), aspect, 0.0));
        let turned = vec3(tilt * (rng.roll() - 0.5), tilt * (rng.roll() - 0.5), 1.0);
        let size = power(&mut rng, -4.0);
        let on = |x: f64, y: f64| {
            let (x, y) = (0.2 + size * x, size * y);
            vec3(x, y, gap - (turned.x * x + turned.y * y))
        };
        let b = Plate::triangle(on(0.0, 0.0), on(rng.roll(), 1.0), on(1.0, rng.roll() - 0.5));
        let b = if b.normal().z > 0.0 { b.flipped() } else { b };
        let frame = rng.frame();
        let (a, b) = (frame.plate(&a), frame.plate(&b));
        let demand = AccuracyRequest::relative(1e-6);
        let whole = plate_plate(&a, &b, 0.0, demand).bounded;
        let parts = b.quarters().map(|q| plate_plate(&a, &q, 0.0, demand).bounded);
        let (sum, radii) = parts.iter().fold((0.0, 0.0), |(s, r), p| (s + p.value, r + p.radius));
        let off = (whole.value - sum).abs();
        // Quarters' corners are rounded about one unit in the last place of the coordinates.
        let slack = 4e-16 * (a.diameter() + 4.0 * b.diameter());
        assert!(off <= whole.radius + radii + slack, "{off:e} {whole:?} {radii:e}: {a:?} {b:?}");
        seen += (whole.value > 0.0) as usize;
        exact += (whole.radius <= 1e-6 * whole.value) as usize;
    }
    assert!(seen > 1_000 && exact > seen / 2, "{exact} of {seen}");
}
