//! Plates in a medium and plates against boxes, in any position: against aligned factors, additivity, and the estimated general ones.

use zonal_exchange::AccuracyRequest;
use zonal_exchange::aligned::{Cuboid, geometric_factor};
use zonal_exchange::polygon::{plate_cuboid, plate_plate};
use zonal_exchange::solid_angle_quadrature;
use zonal_math::{Bounded, Grade, Vec3, low_discrepancy, vec3};
use zonal_scene::{Plate, Sides};

struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 += 1;
        low_discrepancy::hash_to_unit(self.0)
    }
    fn vector(&mut self) -> Vec3 {
        vec3(self.roll() - 0.5, self.roll() - 0.5, self.roll() - 0.5)
    }
    fn frame(&mut self) -> [Vec3; 3] {
        let x = self.vector().normalized();
        let y = x.cross(self.vector()).normalized();
        [x, y, x.cross(y)]
    }
}

fn turned(f: &[Vec3; 3], p: &Plate) -> Plate {
    let turn = |v: Vec3| f[0] * v.x + f[1] * v.y + f[2] * v.z;
    Plate { origin: turn(p.origin), e1: turn(p.e1), e2: turn(p.e2), kind: p.kind }
}

/// The rectangle as a plate and as two triangles.
fn plates(c: &Cuboid) -> (Plate, [Plate; 2]) {
    let (axis, sign) = c.normal.unwrap();
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let edge = |k: usize| {
        let mut e = [0.0; 3];
        e[k] = c.hi[k] - c.lo[k];
        Vec3::from_array(e)
    };
    let (e, f) = if sign > 0 { (edge(u), edge(v)) } else { (edge(v), edge(u)) };
    let o = c.lo;
    (
        Plate::parallelogram(o, e, f),
        [Plate::triangle(o, o + e, o + e + f), Plate::triangle(o, o + e + f, o + f)],
    )
}

fn agrees(got: Bounded, want: Bounded, what: &str) {
    assert_eq!(got.grade, Grade::Proved);
    assert!((got.value - want.value).abs() <= got.radius + want.radius, "{what}: {got:?} {want:?}");
}

fn random_patch(dice: &mut Dice) -> Cuboid {
    let axis = (3.0 * dice.roll()) as usize;
    let lo = dice.vector() * 2.0;
    let mut hi = lo + vec3(0.1 + dice.roll(), 0.1 + dice.roll(), 0.1 + dice.roll());
    match axis {
        0 => hi.x = lo.x,
        1 => hi.y = lo.y,
        _ => hi.z = lo.z,
    }
    Cuboid::patch(lo, hi, axis, if dice.roll() < 0.5 { 1 } else { -1 })
}

#[test]
fn plates_and_boxes_agree_with_aligned_factors() {
    let (mut dice, mut seen, mut met) = (Dice(11), 0, 0);
    for k in 0..60 {
        let patch = random_patch(&mut dice);
        let lo = dice.vector() * 5.0;
        let b = Cuboid::voxel(lo, lo + vec3(0.1 + dice.roll(), 0.1 + dice.roll(), 0.1 + dice.roll()));
        let kappa = [0.0, 0.3, 3.0][k % 3];
        let want = geometric_factor(&patch, &b, kappa, 1e-12).bounded;
        let tolerance = [1e-3, 1e-6, 1e-9][k / 3 % 3];
        let demand = AccuracyRequest { tolerance, max_evaluations: 3_000_000 };
        let (whole, parts) = plates(&patch);
        let got = plate_cuboid(&whole, b.lo, b.hi, kappa, demand).bounded;
        agrees(got, want, &format!("{patch:?} {b:?} {kappa} {tolerance}"));
        let sum = parts
            .iter()
            .map(|p| plate_cuboid(p, b.lo, b.hi, kappa, demand).bounded)
            .fold(Bounded::ZERO, |a, b| a + b);
        agrees(sum, want, "two triangles");
        seen += (want.value > 0.0) as usize;
        met += (want.value > 0.0 && got.radius <= tolerance * got.value) as usize;
    }
    assert!(seen > 25 && met * 10 > seen * 7, "{met} of {seen} met");
}

#[test]
fn rotated_plates_in_medium_agree_with_aligned_factors() {
    let (mut dice, mut seen, mut met) = (Dice(21), 0, 0);
    for k in 0..60 {
        let (mut p, mut q) = (random_patch(&mut dice), random_patch(&mut dice));
        let away = dice.vector() * 4.0;
        (q.lo, q.hi) = (q.lo + away, q.hi + away);
        if let (Some((n, s)), true) = (p.normal, k % 2 == 0) {
            // Facing each other.
            let far = 1.0 + dice.roll();
            let up = |c: &Cuboid, h: f64| {
                let (mut lo, mut hi) = (c.lo.array(), c.hi.array());
                (lo[n], hi[n]) = (h, h);
                (Vec3::from_array(lo), Vec3::from_array(hi))
            };
            let (lo, hi) = up(&p, 0.0);
            q = Cuboid::patch(up(&p, s as f64 * far).0, up(&p, s as f64 * far).1, n, -s);
            p = Cuboid::patch(lo, hi, n, s);
        }
        let kappa = [0.3, 1.0, 4.0][k % 3];
        let want = geometric_factor(&p, &q, kappa, 1e-12).bounded;
        let tolerance = [1e-3, 1e-6, 1e-9][k / 3 % 3];
        let f = dice.frame();
        let (a, b) = (turned(&f, &plates(&p).0), turned(&f, &plates(&q).0));
        let demand = AccuracyRequest { tolerance, max_evaluations: 3_000_000 };
        let got = plate_plate(&a, &b, kappa, demand).bounded;
        agrees(got, want, &format!("{p:?} {q:?} {kappa} {tolerance}"));
        let back = plate_plate(&b, &a, kappa, demand).bounded;
        assert_eq!(got, back);
        seen += (want.value > 0.0) as usize;
        met += (want.value > 0.0 && got.radius <= tolerance * got.value) as usize;
    }
    assert!(seen > 25 && met * 10 > seen * 8, "{met} of {seen} met");
}

#[test]
fn parts_of_box_sum_to_whole_and_to_estimate() {
    let mut dice = Dice(31);
    for _ in 0..25 {
        let plate = Plate::triangle(dice.vector(), dice.vector(), dice.vector());
        let lo = dice.vector() * 3.0;
        let (middle, edge) = (lo + vec3(0.2, 0.5, 0.4), vec3(0.5, 0.5, 0.4));
        let demand = AccuracyRequest { tolerance: 1e-4, max_evaluations: 2_000_000 };
        for kappa in [0.0, 1.0] {
            let f = |lo: Vec3, hi: Vec3| plate_cuboid(&plate, lo, hi, kappa, demand).bounded;
            let whole = f(lo, lo + edge);
            let cut = vec3(middle.x, lo.y + edge.y, lo.z + edge.z);
            let parts = f(lo, cut) + f(vec3(middle.x, lo.y, lo.z), lo + edge);
            agrees(parts, whole, "parts");
            if kappa == 0.0 {
                let m = solid_angle_quadrature::plate_cuboid(&plate, lo, lo + edge, Sides::Front, 1e-3);
                let off = (m.factor.value - whole.value).abs();
                assert!(off <= 0.02 * whole.value + whole.radius + 1e-6, "{m:?} {whole:?}");
            }
        }
    }
}

#[test]
fn box_behind_plate_is_zero_and_touching_box_has_finite_radius() {
    let plate = Plate::parallelogram(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
    let demand = AccuracyRequest { tolerance: 1e-3, max_evaluations: 1_000_000 };
    let f = |lo: Vec3, hi: Vec3, kappa: f64| plate_cuboid(&plate, lo, hi, kappa, demand).bounded;
    let behind = f(vec3(0.0, 0.0, -1.0), vec3(1.0, 1.0, -0.1), 0.0);
    assert_eq!((behind.value, behind.radius), (0.0, 0.0));
    let flush = f(vec3(0.0, 0.0, -1.0), vec3(1.0, 1.0, 0.0), 0.0);
    assert!(flush.value == 0.0 && flush.radius < 1e-10, "{flush:?}");
    for kappa in [0.0, 2.0] {
        let patch = Cuboid::patch(Vec3::ZERO, vec3(1.0, 1.0, 0.0), 2, 1);
        let want = geometric_factor(&patch, &Cuboid::voxel(Vec3::ZERO, Vec3::ONE), kappa, 1e-12).bounded;
        let touching = f(Vec3::ZERO, Vec3::ONE, kappa);
        agrees(touching, want, "touching");
        // Face to face takes more cells than the budget allows: the interval is wide, and says so.
        assert!(touching.radius > 1e-3 * touching.value, "{touching:?}");
    }
}
