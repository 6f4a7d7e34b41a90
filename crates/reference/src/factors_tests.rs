use super::*;
use crate::closed_form::rectangles;

fn cube(x: f64, y: f64, z: f64) -> AlignedBox {
    AlignedBox { lo: [x, y, z], hi: [x + 1.0, y + 1.0, z + 1.0], normal: None }
}

fn wall(lo: [f64; 3], hi: [f64; 3], axis: usize, sign: i8) -> AlignedBox {
    AlignedBox { lo, hi, normal: Some((axis, sign)) }
}

#[test]
fn unit_voxels_match_the_reference_table() {
    // Transparent unit voxels at integer offsets.
    for (at, want) in [
        ([0.0, 0.0, 0.0], 1.79326723077820),
        ([1.0, 0.0, 0.0], 0.38048216172724),
        ([1.0, 1.0, 1.0], 0.11453209119428),
        ([2.0, 1.0, 0.0], 0.06593039107507),
        ([10.0, 0.0, 0.0], 0.00318839340356),
    ] {
        let f = factor(&cube(0.0, 0.0, 0.0), &cube(at[0], at[1], at[2]), 0.0);
        assert!((f.value - want).abs() < 0.6e-14, "{at:?} {f:?} {want}");
        assert!(f.error < 3e-14 * f.value, "{f:?}");
    }
    // κ = 1: the self pair and the pair at offset (5, 0, 0).
    let own = factor(&cube(0.0, 0.0, 0.0), &cube(0.0, 0.0, 0.0), 1.0);
    assert!((own.value - 1.323835261269).abs() < 0.51e-12, "{own:?}");
    let far = factor(&cube(0.0, 0.0, 0.0), &cube(5.0, 0.0, 0.0), 1.0);
    assert!((far.value / 9.6792433725516e-05 - 1.0).abs() < 1e-13, "{far:?}");
}

#[test]
fn ray_integrals_match_corner_sums() {
    let floor = wall([0.0, 0.0, 0.0], [1.0, 2.0, 0.0], 2, 1);
    let mut pairs = vec![];
    for gap in [1e-12, 1e-6, 1e-2, 0.3, 1.0, 7.0, 300.0] {
        pairs.push((floor, wall([0.25, -0.5, gap], [1.5, 2.0, gap], 2, -1)));
        pairs.push((floor, wall([1.0 + gap, 0.5, 0.0], [1.0 + gap, 3.0, 0.001], 0, -1)));
        pairs.push((floor, wall([1.0 + gap, 0.5, gap], [1.0 + gap, 1.5, 2.0 + gap], 0, -1)));
    }
    pairs.push((floor, wall([1.0, 0.0, 0.0], [1.0, 2.0, 1.0], 0, -1)));
    pairs.push((floor, wall([1.0, 2.0, 0.0], [1.0, 2.5, 1.0], 0, -1)));
    pairs.push((
        wall([0.0, 0.0, 0.0], [1e-3, 1.0, 0.0], 2, 1),
        wall([0.0, 0.0, 0.1], [1.0, 1e-3, 0.1], 2, -1),
    ));
    for (a, b) in pairs {
        let (f, g) = (factor(&a, &b, 0.0), rectangles(&a, &b).unwrap());
        assert!((f.value - g.value).abs() <= f.error + g.error, "{f:?} {g:?} {a:?} {b:?}");
        assert!(f.error < 5e-14 * f.value, "{f:?} {g:?} {a:?} {b:?}");
        // Corner sums of small distant rectangles cancel, and their error shows it.
        assert!(g.error < 1e-14 * g.value || f.value < 1e-9, "{f:?} {g:?} {a:?} {b:?}");
    }
}

#[test]
fn factors_of_a_cube_close_at_any_optical_depth() {
    let gas = cube(0.0, 0.0, 0.0);
    for kappa in [1e-3, 0.7, 5.0, 50.0] {
        let own = factor(&gas, &gas, kappa);
        let walls = [
            wall([0.0; 3], [1.0, 1.0, 0.0], 2, 1),
            wall([0.0, 0.0, 1.0], [1.0; 3], 2, -1),
            wall([0.0; 3], [1.0, 0.0, 1.0], 1, 1),
            wall([0.0; 3], [0.0, 1.0, 1.0], 0, 1),
        ];
        let w = walls.map(|w| factor(&w, &gas, kappa).value);
        let sum = kappa * own.value + w[0] + w[1] + 2.0 * (w[2] + w[3]);
        assert!((sum / 4.0 - 1.0).abs() < 3e-14, "{kappa}: {sum}");
        let floor: f64 = walls[1..].iter().map(|x| factor(&walls[0], x, kappa).value).sum::<f64>()
            + factor(&walls[0], &walls[2], kappa).value
            + factor(&walls[0], &walls[3], kappa).value;
        let all = floor + kappa * w[0];
        assert!((all - 1.0).abs() < 3e-14, "{kappa}: {all}");
    }
}

#[test]
fn ray_integral_matches_quadrature() {
    // On both sides of the switch between series and closed form.
    for z in [1e-6, 0.0099, 0.0101, 0.19, 0.21, 0.99, 1.01, 2.9999999, 3.0000001, 8.0, 60.0] {
        for (from, to) in [([1.0, 1.0, 1.0], [0.0, 0.0, 0.0]), ([0.0, 1.0, 0.3], [2.0, 0.0, 1.0])] {
            let line = SingularInterval { lo: 0.0, len: 1.0, away: 1.0, longest: 8.0 / z };
            let want = line.integrate(rule(6), |s| {
                (0..3).map(|k| s.above * from[k] + s.below * to[k]).product::<f64>() * (-z * s.x).exp()
            });
            let got = ray_integral(from, to, 0.5, z) * 0.5f64.exp();
            assert!((got / want - 1.0).abs() < 1e-14, "{z} {got} {want}");
        }
    }
}
