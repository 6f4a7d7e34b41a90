use super::*;
use std::f64::consts::TAU;
use zonal_math::low_discrepancy;

/// Intensities that vary with both angles.
fn table(symmetry: PlaneSymmetry, planes: &[f64]) -> IntensityTable {
    let gammas: Vec<f64> = (0..=18).map(|k| 10.0 * k as f64).collect();
    let value = |c: f64, g: f64| 1.0 + 0.5 * (2.0 * c.to_radians()).cos() * g.to_radians().sin() + 0.002 * g;
    let values: Vec<f64> =
        planes.iter().flat_map(|c| gammas.iter().map(|g| value(*c, *g)).collect::<Vec<_>>()).collect();
    IntensityTable::new(planes, &gammas, &values, symmetry).unwrap()
}

fn distributions() -> Vec<IntensityDistribution> {
    let axis = vec3(0.3, -0.5, -0.9);
    let full: Vec<f64> = (0..24).map(|k| 15.0 * k as f64).collect();
    vec![
        IntensityDistribution::isotropic(),
        IntensityDistribution::spot(axis, [0.2, 0.7]),
        IntensityDistribution::spot(axis, [0.4, 0.4]),
        IntensityDistribution::table(table(PlaneSymmetry::None, &full), axis, 0.4),
    ]
}

#[test]
fn integrals_equal_quadrature_and_samples_have_the_density() {
    let n = 1 << 18;
    for (k, d) in distributions().iter().enumerate() {
        let mean = |f: &dyn Fn(Vec3) -> f64| {
            (0..n).map(|i| f(uniform_sphere(low_discrepancy::r2(i, [0.1, 0.2])))).sum::<f64>() * 4.0 * PI
                / n as f64
        };
        let power = mean(&|w| d.relative(w));
        assert!((power / d.solid_angle_integral() - 1.0).abs() < 2e-3, "{k}: {power}");
        // First and second moments of the sampled directions.
        for m in [vec3(1.0, 0.2, -0.4), vec3(0.1, -0.9, 0.3)] {
            let moment = |w: Vec3| w.dot(m) + (w.dot(m)).powi(2);
            let sampled =
                (0..n).map(|i| moment(d.sample_direction(low_discrepancy::r2(i, [0.7, 0.4])))).sum::<f64>()
                    / n as f64;
            let exact = mean(&|w| moment(w) * d.relative(w)) / d.solid_angle_integral();
            assert!((sampled - exact).abs() < 3e-3, "{k}: {sampled} {exact}");
        }
    }
}

#[test]
fn symmetric_planes_are_those_of_the_full_table() {
    let full: Vec<f64> = (0..24).map(|k| 15.0 * k as f64).collect();
    let all = table(PlaneSymmetry::None, &full);
    for (symmetry, range) in [
        (PlaneSymmetry::Quadrants, 0..=6),
        (PlaneSymmetry::AboutC0, 0..=12),
        (PlaneSymmetry::AboutC90, 6..=18),
        (PlaneSymmetry::None, 0..=24),
    ] {
        let planes: Vec<f64> = range.map(|k| 15.0 * k as f64).collect();
        let own = table(symmetry, &planes);
        for i in 0..500 {
            let [g, c] = low_discrepancy::r2(i, [0.3, 0.8]);
            let (a, b) = (all.relative(g * PI, c * TAU), own.relative(g * PI, c * TAU));
            assert!((a - b).abs() < 1e-12, "{symmetry:?}: {a} {b}");
        }
    }
}

#[test]
fn values_at_nodes_and_the_frame_are_those_of_the_table() {
    let values = [4.0, 3.0, 2.0, 8.0, 6.0, 1.0];
    let t = IntensityTable::new(&[0.0, 90.0], &[0.0, 45.0, 90.0], &values, PlaneSymmetry::Quadrants).unwrap();
    let down = IntensityDistribution::table(t.clone(), vec3(0.0, 0.0, -1.0), 0.0);
    let at = |d: &IntensityDistribution, v: Vec3| d.relative(v.normalized());
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} {b}");
    near(at(&down, vec3(1.0, 0.0, -1.0)), 3.0);
    near(at(&down, vec3(-1.0, 0.0, 0.0)), 2.0);
    near(at(&down, vec3(0.0, 1.0, -1.0)), 6.0);
    near(at(&down, vec3(0.0, -1.0, -1e-12)), 1.0);
    near(at(&down, vec3(0.0, 0.0, 1.0)), 0.0);
    // A quarter turn carries C = 0 to C = 90.
    let turned = IntensityDistribution::table(t.clone(), vec3(0.0, 0.0, -1.0), 0.5 * PI);
    near(at(&turned, vec3(0.0, 1.0, -1.0)), 3.0);
    // Aimed along x, C = 0 points up: the smallest rotation from straight down.
    let aimed = IntensityDistribution::table(t, vec3(1.0, 0.0, 0.0), 0.0);
    near(at(&aimed, vec3(1.0, 0.0, 1.0)), 3.0);
    near(at(&aimed, vec3(1.0, 1.0, 0.0)), 6.0);
    let mirrored = aimed.reflected(|v| vec3(-v.x, v.y, v.z));
    near(at(&mirrored, vec3(-1.0, 1.0, 0.0)), 6.0);
}

#[test]
fn defining_numbers_give_the_distribution_to_the_bit() {
    for d in distributions() {
        let mut numbers = d.defining_numbers();
        assert_eq!(IntensityDistribution::from_defining_numbers(&numbers), Some(d));
        // Damaged lists are refused, not read.
        numbers.push(1.0);
        assert_eq!(IntensityDistribution::from_defining_numbers(&numbers), None);
        numbers.truncate(numbers.len() - 2);
        assert_eq!(IntensityDistribution::from_defining_numbers(&numbers), None);
    }
    assert_eq!(IntensityDistribution::from_defining_numbers(&[]), None);
    let huge = [vec![2.0], vec![0.0; 9], vec![1e300]].concat();
    assert_eq!(IntensityDistribution::from_defining_numbers(&huge), None);
}

#[test]
fn upper_bounds_hold() {
    for d in distributions() {
        for i in 0..2000 {
            let [a, b, c] = low_discrepancy::r3(i, [0.5; 3]);
            let (w, half) = (uniform_sphere([a, b]), 0.5 * c);
            let bound = d.upper_bound(w, half);
            let (t, s) = w.frame();
            for k in 0..8 {
                let (sin, cos) = (k as f64).sin_cos();
                let tilt = half * (k as f64 + 1.0) / 8.0;
                let v = (w * tilt.cos() + (t * cos + s * sin) * tilt.sin()).normalized();
                assert!(d.relative(v) <= bound + 1e-9, "{} {bound}", d.relative(v));
            }
        }
    }
}

#[test]
fn wrong_tables_are_refused() {
    let bad =
        |c: &[f64], g: &[f64], v: &[f64]| IntensityTable::new(c, g, v, PlaneSymmetry::None).unwrap_err();
    assert!(bad(&[], &[0.0, 90.0], &[]).contains("no angles"));
    assert!(bad(&[0.0], &[0.0, 90.0], &[1.0]).contains("product"));
    assert!(bad(&[0.0], &[90.0, 0.0], &[1.0, 1.0]).contains("ascend"));
    assert!(bad(&[0.0], &[0.0, 190.0], &[1.0, 1.0]).contains("outside"));
    assert!(bad(&[0.0], &[0.0, f64::NAN], &[1.0, 1.0]).contains("outside"));
    assert!(bad(&[0.0], &[0.0, 90.0], &[1.0, -1.0]).contains("from 0"));
    assert!(bad(&[0.0], &[0.0, 90.0], &[0.0, 0.0]).contains("zero"));
}
