//! Layers against exponential integrals, closure, and thin layers against their limits.

use super::*;
use zonal_math::exponential_integral::e1;

/// All factors, symmetric.
fn matrix(extinction: &[f64], thickness: &[f64]) -> (Vec<Vec<f64>>, f64) {
    let f = LayerFactors::new(extinction, thickness);
    let n = f.elements();
    let mut out = vec![vec![0.0; n]; n];
    for i in 0..n {
        let mut row = vec![0.0; i + 1];
        f.row(i, &mut row);
        for (j, x) in row.into_iter().enumerate() {
            (out[i][j], out[j][i]) = (x, x);
        }
    }
    (out, f.relative_radius())
}

#[test]
fn thick_layers_equal_differences_of_exponential_integrals() {
    let (k, d) = ([2.0, 0.7, 5.0], [0.5, 2.0, 0.3]);
    let (g, radius) = matrix(&k, &d);
    let [a, b, c] = [0, 1, 2].map(|i| k[i] * d[i]);
    let wants = [
        (0, 4, 2.0 * e3(a + b + c)),
        (0, 1, 2.0 * (0.5 - e3(a)) / k[0]),
        (0, 3, 2.0 * (e3(a + b) - e3(a + b + c)) / k[2]),
        (1, 2, 2.0 * (0.5 - e3(a) - e3(b) + e3(a + b)) / (k[0] * k[1])),
        (1, 3, 2.0 * (e3(b) - e3(a + b) - e3(b + c) + e3(a + b + c)) / (k[0] * k[2])),
        (2, 2, 4.0 * (b - 0.5 + e3(b)) / (k[1] * k[1])),
    ];
    for (i, j, want) in wants {
        assert!((g[i][j] / want - 1.0).abs() < radius + 1e-12, "{i} {j}: {} {want}", g[i][j]);
    }
}

// Guards (numbers): the operator of the layered engine is symmetric, and its rows close to 1e-12.
#[test]
fn rows_close_at_every_extinction() {
    for k in [0.0, 1e-300, 1e-200, 1e-30, 1e-12, 1e-6, 1e-3, 0.1, 1.0, 30.0, 1e3, 1e6] {
        let extinction = [0.3, k, 2.0 * k, 0.0, k, 7.0, 1e-9];
        let thickness = [0.5, 1.0, 0.01, 0.2, 3.0, 0.1, 0.4];
        let (g, radius) = matrix(&extinction, &thickness);
        let n = thickness.len();
        assert!(radius < 1e-12);
        for i in 0..n + 2 {
            let inner: f64 = (0..n).map(|j| g[i][j + 1] * extinction[j]).sum();
            let want = if i == 0 || i == n + 1 { 1.0 } else { 4.0 * thickness[i - 1] };
            let defect = (inner + g[i][0] + g[i][n + 1]) / want - 1.0;
            assert!(defect.abs() < radius, "{k:e} {i}: {defect:e} {radius:e}");
        }
    }
}

#[test]
fn thin_layers_keep_their_digits() {
    // A thin layer at the optical depth x from a plane and from a thin layer: 2 d E₂(x), 2 d² E₁(x).
    let (k, d) = ([1e-11, 0.8, 1e-13], [1e-3, 1.0, 1e-3]);
    let (g, _) = matrix(&k, &d);
    let e2 = (-0.8f64).exp() - 0.8 * e1(0.8);
    assert!((g[0][3] / (2e-3 * e2) - 1.0).abs() < 1e-12, "{}", g[0][3]);
    assert!((g[1][3] / (2e-6 * e1(0.8)) - 1.0).abs() < 1e-12, "{}", g[1][3]);
    // Adjacent transparent layers do not exchange; each plane is half of the surroundings of such a layer.
    let (g, _) = matrix(&[0.0; 3], &[0.5, 1.0, 0.25]);
    assert_eq!((g[1][2], g[2][2]), (0.0, 0.0));
    assert!((g[0][2] / 2.0 - 1.0).abs() < 1e-14 && (g[0][4] - 1.0).abs() < 1e-14, "{g:?}");
}

#[test]
fn layers_cut_in_two_have_the_factors_of_the_whole() {
    let (whole, radius) = matrix(&[0.4, 3.0], &[1.0, 0.5]);
    let (parts, _) = matrix(&[0.4, 0.4, 3.0, 3.0], &[0.3, 0.7, 0.499, 0.001]);
    let element = [0, 1, 1, 2, 2, 3];
    let mut sums = vec![vec![0.0; 4]; 4];
    for i in 0..6 {
        (0..6).for_each(|j| sums[element[i]][element[j]] += parts[i][j]);
    }
    for i in 0..4 {
        for j in 0..4 {
            assert!((sums[i][j] - whole[i][j]).abs() <= 2.0 * radius * whole[i][j], "{i} {j}");
        }
    }
}

#[test]
fn kernel_mean_is_continuous_between_series_and_closed_form() {
    let [below, above] = [1.0, 1.0 + 1e-14].map(mean_kernel);
    assert!((below / above - 1.0).abs() < 3e-14, "{below} {above}");
    assert!((mean_kernel(1.0) - 2.0 * (0.5 + e3(1.0))).abs() < 1e-14);
}
