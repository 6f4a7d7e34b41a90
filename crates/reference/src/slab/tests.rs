//! Closed forms, conservation and invariance of the slab.

use super::*;
use zonal_math::exponential_integral::{e1, e3};

const NO_WALL_EMISSION: [f64; 2] = [0.0; 2];

/// A grey slab of optical thickness `tau` in `n` layers.
fn grey(tau: f64, n: usize, albedo: f64, wall_emissivity: [f64; 2]) -> Slab {
    let band = SlabBand { extinction: vec![2.0 * tau; n], albedo: vec![albedo; n], wall_emissivity };
    Slab { thickness: vec![0.5 / n as f64; n], bands: vec![band] }
}

fn uniform(n: usize, layers: f64, walls: [f64; 2]) -> BandEmission {
    BandEmission { layers: vec![layers; n], walls }
}

#[test]
fn isothermal_slab_has_the_flux_of_the_third_exponential_integral() {
    for tau in [1e-6, 1e-3, 0.1, 1.0, 3.0, 40.0] {
        for n in [1, 7] {
            let s = &grey(tau, n, 0.0, [1.0; 2]).solve(&[uniform(n, 1.0, NO_WALL_EMISSION)])[0];
            let want = 1.0 - 2.0 * e3(tau);
            assert!((s.flux[n] - want).abs() < 1e-12 && (s.flux[0] + want).abs() < 1e-12, "{tau} {n}: {s:?}");
            // Power that leaves is emitted and not absorbed.
            let lost: f64 = s.source.iter().map(|q| -q * 0.5 / n as f64).sum();
            assert!((lost - 2.0 * want).abs() < 1e-12, "{tau} {n}: {lost} {want}");
        }
    }
}

#[test]
fn walls_through_unequal_layers_follow_exponential_integrals() {
    let extinction = vec![0.3, 0.0, 7.0, 1e-9];
    let thickness = vec![1.0, 2.0, 0.05, 3.0];
    let tau: f64 = extinction.iter().zip(&thickness).map(|(k, d)| k * d).sum();
    let band = SlabBand { extinction, albedo: vec![0.0; 4], wall_emissivity: [1.0; 2] };
    let s = &Slab { thickness, bands: vec![band] }.solve(&[uniform(4, 0.0, [1.0, 0.0])])[0];
    assert!((s.wall_incident[1] - 2.0 * e3(tau)).abs() < 1e-12);
    // The transparent layer has G = 2 E₂(0.3) of a hemisphere of unit emission.
    let e2 = (-0.3f64).exp() - 0.3 * e1(0.3);
    assert!((s.incident[1] - 2.0 * e2).abs() < 1e-12, "{:?}", s.incident);
}

/// Ψ_b of the problem of Heaslet and Warming (1965) to eight digits, by Richardson extrapolation of the square of the cell size.
#[test]
fn equilibrium_between_black_plates_matches_the_table() {
    for (tau, want) in [(0.1, 0.91570287), (1.0, 0.55340599), (3.0, 0.30164472)] {
        let flux = |n: usize| equilibrium_flux(&grey(tau, n, 0.0, [1.0; 2]), &|_, _, _| 1.0);
        let extrapolated = (4.0 * flux(60) - flux(30)) / 3.0;
        assert!((extrapolated - want).abs() < 5e-6, "{tau}: {extrapolated}");
    }
}

/// Net flux over σ(T₁⁴ − T₂⁴) of layers without net power between plates of 1000 and 500 K; it is the same at every boundary.
fn equilibrium_flux(slab: &Slab, weight: &dyn Fn(usize, usize, f64) -> f64) -> f64 {
    let walls = [1000.0, 500.0].map(SlabCondition::Temperature);
    let free = vec![SlabCondition::NetPower(0.0); slab.thickness.len()];
    let s = slab.equilibrium(&free, walls, weight).expect("a solution");
    let q = total_flux(&s.bands);
    q.iter().for_each(|x| assert!((x / q[0] - 1.0).abs() < 1e-11, "{q:?}"));
    q[0] / (STEFAN_BOLTZMANN * (1e12 - 500f64.powi(4)))
}

#[test]
fn equilibrium_scattering_and_grey_plates_agree() {
    let n = 12;
    let black = equilibrium_flux(&grey(1.0, n, 0.0, [1.0; 2]), &|_, _, _| 1.0);
    let partly = equilibrium_flux(&grey(1.0, n, 0.7, [1.0; 2]), &|_, _, _| 1.0);
    assert!((partly - black).abs() < 1e-12, "{partly} {black}");
    let scattered = &grey(1.0, n, 1.0, [1.0; 2]).solve(&[uniform(n, 0.0, [1.0, 0.0])])[0];
    assert!((scattered.flux[n] - black).abs() < 1e-12);
    let plates = equilibrium_flux(&grey(1.0, n, 0.0, [0.8, 0.5]), &|_, _, _| 1.0);
    let want = black / (1.0 + black * (1.0 / 0.8 + 1.0 / 0.5 - 2.0));
    assert!((plates - want).abs() < 1e-12, "{plates} {want}");
}

/// A clear window of constant weight adds its own flux to that of the grey gas.
#[test]
fn window_gas_in_equilibrium_is_the_sum_of_its_bands() {
    let n = 12;
    let gas = grey(1.0, n, 0.0, [1.0; 2]);
    let black = equilibrium_flux(&gas, &|_, _, _| 1.0);
    let clear = SlabBand { extinction: vec![0.0; n], ..gas.bands[0].clone() };
    let two = Slab { bands: vec![clear, gas.bands[0].clone()], ..gas };
    let flux = equilibrium_flux(&two, &|_, b, _| [0.3, 0.7][b]);
    assert!((flux - (0.3 + 0.7 * black)).abs() < 1e-12, "{flux}");
}

/// Weights that depend on the temperature, an adiabatic wall and heated layers: the power of the layers leaves through the other wall.
#[test]
fn heated_gas_with_an_adiabatic_wall_conserves_power() {
    let n = 10;
    let of = |k: f64| SlabBand { extinction: vec![k; n], albedo: vec![0.2; n], wall_emissivity: [0.6, 0.9] };
    let slab = Slab { thickness: vec![0.1; n], bands: [0.0, 0.4, 5.0].map(of).to_vec() };
    let weight = |_: usize, b: usize, t: f64| {
        let a = [0.5 - 1e-4 * t, 0.3 - 5e-5 * t];
        if b == 0 { 1.0 - a[0] - a[1] } else { a[b - 1] }
    };
    let walls = [SlabCondition::NetPower(0.0), SlabCondition::Temperature(600.0)];
    let heat: Vec<SlabCondition> = (0..n).map(|i| SlabCondition::NetPower(1e4 * i as f64)).collect();
    let s = slab.equilibrium(&heat, walls, &weight).expect("a solution");
    let q = total_flux(&s.bands);
    assert!(q[0].abs() < 1e-6 && (q[n] / 45_000.0 - 1.0).abs() < 1e-11, "{q:?}");
    for (i, source) in total_source(&s.bands).iter().enumerate() {
        assert!((source + 1e4 * i as f64).abs() < 1e-5, "{i}: {source}");
    }
    assert!(s.layer_temperatures.iter().all(|t| (600.0..2000.0).contains(t)), "{s:?}");
}
