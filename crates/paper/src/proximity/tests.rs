use super::development::{COEFFICIENT_ROUNDINGS, SUM_ROUNDINGS};
use super::error_constants::POINT_ROUNDINGS;
use super::surface::tests::one_of_each;
use super::*;
use std::f64::consts::PI;
use zonal_exchange::aligned::{Cuboid, geometric_factor};
use zonal_exchange::{AccuracyRequest, Factor, Method};
use zonal_math::{Grade, Vec3, vec3};
use zonal_scene::Plate;

/// A parallelogram in front of the middle of a surface, facing it.
fn onlooker(s: &SmoothSurface, [u, v]: [f64; 2]) -> Plate {
    let n = s.normal(u, v).normalized();
    let (t, b) = n.frame();
    let plate = Plate::parallelogram(s.at(u, v) + n * 1.5 + t * 0.3, b * 0.4, (t + b * 0.1 + n * 0.05) * 0.5);
    if plate.normal().dot(n) > 0.0 { plate.flipped() } else { plate }
}

/// All factors of a row; every cell must have one.
fn all(row: &MeshFactors) -> Vec<Factor> {
    let factor = |c: &CellFactor| if let CellFactor::Factor(f) = c { *f } else { panic!("{c:?}") };
    row.cells.iter().map(factor).collect()
}

#[test]
fn developments_meet_tolerance_and_cost_less_than_the_baseline() {
    for (s, at) in one_of_each() {
        let mesh = ParametricMesh::regular([at[0] - 0.4, at[1] - 0.3], [at[0] + 0.4, at[1] + 0.3], 24, 20);
        let whole = onlooker(&s, at);
        let (c, _) = whole.corners();
        for plate in [whole, Plate::triangle(c[0], c[1], c[3])] {
            let cell =
                |k: usize, n: usize| direct_integral(&s, mesh.patch(k / 20, k % 20), &plate, n).bounded.value;
            let want: Vec<f64> = (0..480).map(|k| cell(k, 8)).collect();
            let mut references = usize::MAX;
            for (order, tolerance) in [(4, 1e-3), (8, 1e-6), (12, 1e-9), (16, 1e-9)] {
                let demand = AccuracyRequest::relative(tolerance);
                let row = mesh_factors(&s, &mesh, &plate, order, &demand);
                let got = all(&row);
                for (f, want) in got.iter().zip(&want) {
                    assert_eq!((f.method, f.bounded.grade), (Method::Proximity, Grade::Proved));
                    assert!(f.bounded.radius <= demand.radius(f.bounded.value), "{s:?} {order}: {f:?}");
                    assert!(
                        (f.bounded.value - want).abs() <= f.bounded.radius + 2e-14 * want,
                        "{s:?}: {f:?} {want}"
                    );
                }
                // Cell by cell, with the fewest points that are good enough for every cell.
                let good = |n: &usize| (0..480).all(|k| (cell(k, *n) / want[k] - 1.0).abs() <= tolerance);
                let n = (1..8).find(|n| *n > 1 && good(n)).unwrap_or(8);
                let baseline = 480 * n.pow(4) as u64;
                assert!(row.evaluations < baseline, "{} series, {baseline} kernels", row.evaluations);
                assert!(order < 16 || row.references < references);
                references = row.references;
            }
        }
    }
}

/// A surface of one kind with random measures.
fn random_surface(kind: usize, x: &mut impl FnMut(f64, f64) -> f64) -> SmoothSurface {
    let mut vector = |s: f64| vec3(x(-s, s), x(-s, s), x(-s, s));
    let (o, axis) = (vector(1.0), vector(1.0).normalized());
    let (e1, e2, e3) = (vector(1.0), vector(1.0), vector(0.6));
    let s = match kind {
        0 => SmoothSurface::plane(o, e1, e2),
        1 => SmoothSurface::ruled(o, e1, e2, e3),
        2 => SmoothSurface::cylinder(o, axis, x(0.3, 2.0)),
        3 => SmoothSurface::cone(o, axis, x(0.1, 1.5)),
        _ => SmoothSurface::sphere(o, axis, x(0.3, 2.0)),
    };
    if x(0.0, 1.0) < 0.3 { s.turned() } else { s }
}

#[test]
fn radii_hold_for_random_surfaces_plates_and_orders() {
    let mut rng = zonal_reference::Rng::new(11);
    let mut x = |lo: f64, hi: f64| rng.uniform_in(lo, hi);
    let (mut checked, mut stated, mut closest) = (0, 0, 0.0f64);
    for k in 0..200 {
        let s = random_surface(k % 5, &mut x);
        let (u, v) = (x(-2.0, 2.0), if k % 5 == 3 { x(0.3, 2.0) } else { x(-1.2, 1.2) });
        let (n, away) = (s.normal(u, v).normalized(), 10f64.powf(x(-0.7, 0.7)));
        let mut vector = |r: f64| vec3(x(-r, r), x(-r, r), x(-r, r));
        let (shift, e1, e2) = (vector(0.3 * away), vector(0.5), vector(0.5));
        let mut plate = Plate::parallelogram(s.at(u, v) + n * away + shift, e1, e2);
        if k.is_multiple_of(3) {
            plate = Plate::triangle(plate.origin, plate.origin + e1, plate.origin + e2);
        }
        if plate.normal().dot(n) > 0.0 {
            plate = plate.flipped();
        }
        let size = 0.3 * away.min(1.0);
        let mesh = ParametricMesh::regular(
            [u - size * x(0.2, 1.0), v - size * x(0.2, 0.8)],
            [u + size, v + 0.8 * size],
            4,
            4,
        );
        let order = x(1.0, 20.99) as usize;
        let row =
            mesh_factors(&s, &mesh, &plate, order, &AccuracyRequest::relative(10f64.powf(x(-10.0, -1.0))));
        for (at, c) in row.cells.iter().enumerate() {
            let want = direct_integral(&s, mesh.patch(at / 4, at % 4), &plate, 10).bounded;
            let CellFactor::Factor(f) = c else {
                stated += 1;
                continue;
            };
            let slack = 10.0 * want.radius + 1e-13 * want.value;
            let off = (f.bounded.value - want.value).abs() - slack;
            assert!(off <= f.bounded.radius, "{k} {at}: {f:?} against {want:?}");
            if f.method == Method::Proximity && slack < 0.01 * f.bounded.radius {
                checked += 1;
                closest = closest.max(off / f.bounded.radius);
            }
        }
    }
    assert!(checked > 1500 && stated < 2000 && closest > 1e-3, "{checked} {stated} {closest}");
}

#[test]
fn planes_agree_with_the_reduced_integral() {
    // Parallel at height one, and perpendicular beside it.
    let plate = Plate::parallelogram(vec3(0.0, 0.0, 1.0), vec3(0.0, 0.5, 0.0), vec3(0.75, 0.0, 0.0));
    let b = Cuboid::patch(vec3(0.0, 0.0, 1.0), vec3(0.75, 0.5, 1.0), 2, -1);
    let parallel = SmoothSurface::plane(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
    let beside = SmoothSurface::plane(vec3(-1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
    let mesh = ParametricMesh::regular([-0.5, -0.5], [1.5, 0.5], 16, 8);
    for (s, upright) in [(parallel, false), (beside, true)] {
        let row = mesh_factors(&s, &mesh, &plate, 14, &AccuracyRequest::relative(1e-9));
        for (k, f) in all(&row).iter().enumerate() {
            let [u, v] = mesh.patch(k / 8, k % 8);
            let a = if upright {
                Cuboid::patch(vec3(-1.0, u[0], v[0]), vec3(-1.0, u[1], v[1]), 0, 1)
            } else {
                Cuboid::patch(vec3(u[0], v[0], 0.0), vec3(u[1], v[1], 0.0), 2, 1)
            };
            let want = geometric_factor(&a, &b, 0.0, 1e-12).bounded;
            assert!(
                (f.bounded.value - want.value).abs() <= f.bounded.radius + want.radius,
                "{k}: {f:?} {want:?}"
            );
            assert!(f.bounded.radius <= 1e-9 * f.bounded.value);
        }
    }
}

/// Σ over a mesh, cells on the horizon by the baseline.
fn total(s: &SmoothSurface, mesh: &ParametricMesh, plate: &Plate) -> (f64, usize) {
    let row = mesh_factors(s, mesh, plate, 10, &AccuracyRequest::relative(1e-7));
    let m = mesh.cells()[1];
    let value = |(k, c): (usize, &CellFactor)| match c {
        CellFactor::Factor(f) => f.bounded.value,
        _ => direct_integral(s, mesh.patch(k / m, k % m), plate, 12).bounded.value,
    };
    let whole = row.cells.iter().filter(|c| matches!(c, CellFactor::Factor(_))).count();
    (row.cells.iter().enumerate().map(value).sum(), whole)
}

#[test]
fn sphere_and_cylinder_match_closed_forms() {
    // A sphere that an element faces at h from its centre: (R/h)².
    let side = 2e-3;
    let s = SmoothSurface::sphere(Vec3::ZERO, vec3(0.0, 0.0, 1.0), 0.8);
    let plate =
        Plate::parallelogram(vec3(-0.5 * side, -0.5 * side, 2.0), vec3(0.0, side, 0.0), vec3(side, 0.0, 0.0));
    let (rim, pole) = (0.4f64.asin(), 0.5 * PI);
    let mesh = ParametricMesh::regular([0.0, rim], [2.0 * PI, pole], 36, 24);
    let (sum, whole) = total(&s, &mesh, &plate);
    let want = 0.16 * plate.area();
    assert!((sum / want - 1.0).abs() < 1e-5 && whole > 780, "{} {whole}", sum / want);
    // A cylinder of radius r and length l from an element at h from its axis, level with its end, that looks at the axis
    // (catalogue of configuration factors, plane element to right circular cylinder).
    let (r, l, h) = (0.5, 2.0, 1.25);
    let s = SmoothSurface::cylinder(Vec3::ZERO, vec3(0.0, 0.0, 1.0), r);
    let x = s.at(0.0, 0.0).normalized();
    let (y, z) = (vec3(0.0, 0.0, 1.0).cross(x), vec3(0.0, 0.0, 1.0));
    let plate = Plate::parallelogram(x * h - (y + z) * (0.5 * side), z * side, y * side);
    assert!(plate.normal().dot(x) < 0.0);
    let rim = (r / h).acos();
    let mesh = ParametricMesh::regular([-rim, 0.0], [rim, l], 24, 24);
    let (sum, whole) = total(&s, &mesh, &plate);
    let (l, h) = (l / r, h / r);
    let (x, y) = ((1.0 + h).powi(2) + l * l, (1.0 - h).powi(2) + l * l);
    let ratio = ((h - 1.0) / (h + 1.0)).sqrt();
    let want = (l / (h * h - 1.0).sqrt()).atan() / (PI * h)
        + l / PI
            * ((x - 2.0 * h) / (h * (x * y).sqrt()) * ((x / y).sqrt() * ratio).atan() - ratio.atan() / h);
    assert!(
        (sum / (want * plate.area()) - 1.0).abs() < 1e-3 && whole > 500,
        "{} {want} {whole}",
        sum / plate.area()
    );
}

#[test]
fn horizon_back_side_and_contact_are_classified() {
    let s = SmoothSurface::sphere(Vec3::ZERO, vec3(0.0, 0.0, 1.0), 1.0);
    let plate = Plate::parallelogram(vec3(2.0, -0.2, -0.2), vec3(0.0, 0.0, 0.4), vec3(0.0, 0.4, 0.0));
    let mesh = ParametricMesh::regular([-PI, -0.5], [PI, 0.5], 48, 8);
    let row = mesh_factors(&s, &mesh, &plate, 8, &AccuracyRequest::relative(1e-4));
    let mut counts = [0; 3];
    for (k, c) in row.cells.iter().enumerate() {
        let patch = mesh.patch(k / 8, k % 8);
        let clamped = direct_integral(&s, patch, &plate, 6).bounded.value;
        match c {
            CellFactor::Factor(f) if f.method == Method::NotVisible => {
                assert_eq!(clamped, 0.0);
                counts[0] += 1;
            }
            CellFactor::Factor(f) => {
                assert!((f.bounded.value - clamped).abs() <= f.bounded.radius + 1e-6 * clamped);
                counts[1] += 1;
            }
            _ => counts[2] += 1,
        }
    }
    assert!(counts[0] > 150 && counts[1] > 80 && counts[2] > 10 && counts[2] < 80, "{counts:?}");
}

/// The cells at the foot of a wall on the mesh are too near, those behind it are not seen.
#[test]
fn wall_that_stands_on_the_mesh_is_classified() {
    let floor = SmoothSurface::plane(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
    let wall = Plate::parallelogram(Vec3::ZERO, vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
    let row = mesh_factors(
        &floor,
        &ParametricMesh::regular([-1.0, 0.0], [4.0, 1.0], 10, 2),
        &wall,
        12,
        &AccuracyRequest::relative(1e-6),
    );
    assert!(row.cells[..2].iter().all(|c| *c == CellFactor::Factor(Factor::NOT_VISIBLE)));
    assert!(
        row.cells[2..6].iter().all(|c| matches!(c, CellFactor::PartlyVisible | CellFactor::Near)),
        "{:?}",
        &row.cells[2..6]
    );
    for c in &row.cells[12..] {
        assert!(matches!(c, CellFactor::Factor(f) if f.bounded.radius <= 1e-5 * f.bounded.value), "{c:?}");
    }
    // From behind, nothing.
    let row = mesh_factors(
        &floor,
        &ParametricMesh::regular([0.5, 0.0], [4.0, 1.0], 10, 2),
        &wall.flipped(),
        12,
        &AccuracyRequest::relative(1e-6),
    );
    assert!(row.cells.iter().all(|c| *c == CellFactor::Factor(Factor::NOT_VISIBLE)) && row.evaluations == 0);
}

#[test]
fn radius_grows_with_rounding_far_from_the_origin() {
    // All coordinates are exact in binary: moving by 2²⁰ changes nothing but the roundings.
    let far = Vec3::splat(1_048_576.0);
    let (e1, e2, e3) = (vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 0.25));
    let mesh = ParametricMesh::regular([0.0, 0.0], [1.0, 1.0], 8, 8);
    let at = |o: Vec3| {
        let plate = Plate::parallelogram(o + vec3(0.25, 0.25, 1.5), vec3(0.0, 0.5, 0.0), vec3(0.5, 0.0, 0.0));
        all(&mesh_factors(
            &SmoothSurface::ruled(o, e1, e2, e3),
            &mesh,
            &plate,
            18,
            &AccuracyRequest::relative(1e-7),
        ))
    };
    let (near, away) = (at(Vec3::ZERO), at(far));
    let mut grown = 0;
    for (f, g) in near.iter().zip(&away) {
        assert!((f.bounded.value - g.bounded.value).abs() <= f.bounded.radius + g.bounded.radius);
        grown += usize::from(g.bounded.radius > 1e-12 * g.bounded.value);
    }
    assert_eq!(grown, 64);
}

#[test]
fn spent_evaluations_leave_cells_near() {
    let (s, at) = one_of_each()[4];
    let mesh = ParametricMesh::regular([at[0] - 0.4, at[1] - 0.3], [at[0] + 0.4, at[1] + 0.3], 24, 20);
    let demand = AccuracyRequest { tolerance: 1e-9, max_evaluations: 100 };
    let row = mesh_factors(&s, &mesh, &onlooker(&s, at), 10, &demand);
    assert!(row.cells.contains(&CellFactor::Near) && row.evaluations < 400);
}

#[test]
fn rounding_bounds_count_their_operations() {
    let (sine, sums, products, node, second_orders) = (2.0, 4.0, 4.0, 2.0, 2.0);
    assert_eq!(POINT_ROUNDINGS, 2.0 * sine + products + sums + node + second_orders);
    let (vector, powers, product, terms) = (10.0, 2.0, 2.0, 8.0);
    assert_eq!(COEFFICIENT_ROUNDINGS, vector + powers + product + terms);
    let (factors, weight, pi, area) = (2.0, 4.0, 2.0, 2.0);
    assert_eq!(SUM_ROUNDINGS, factors + weight + pi + area + second_orders);
}
