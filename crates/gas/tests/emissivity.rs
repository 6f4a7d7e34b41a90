//! Total emissivities that papers, RadLib or other codes state, and the laws of weighted sums of grey gases.

use zonal_gas::{GasModel, GasState};

const TEMPERATURES: [f64; 3] = [600.0, 1200.0, 2000.0];

fn state(temperature: f64, h2o: f64, co2: f64) -> GasState {
    GasState { temperature, h2o, co2, ..GasState::default() }
}

/// Emissivity of 1 m of 20 % H2O and 10 % CO2 at one atmosphere to six digits, by RadLib (Bordbar) and by the superposition of Cassol's paper.
#[test]
fn emissivities_have_the_published_digits() {
    for (model, published) in [
        (GasModel::Bordbar2020, [0.404920, 0.311102, 0.172756]),
        (GasModel::Bordbar2014, [0.404920, 0.311102, 0.172756]),
        (GasModel::Cassol2014, [0.372659, 0.314284, 0.188557]),
    ] {
        for (t, want) in TEMPERATURES.into_iter().zip(published) {
            let got = model.evaluate(&state(t, 0.2, 0.1)).unwrap().emissivity(1.0);
            assert!((got - want).abs() < 5e-7, "{} at {t} K: {got} instead of {want}", model.name());
        }
    }
}

#[test]
fn fourth_absorption_coefficient_of_kangwanpongpan_has_its_stated_value() {
    // At a mole ratio of 0 the coefficient is 105.31 1/(atm m); the range begins at 0.125.
    let mixture = GasModel::Kangwanpongpan2012.evaluate(&state(1000.0, 0.125 / 1.125, 1.0 / 1.125)).unwrap();
    let want = 105.31 - 39.265 * 0.125 + 6.0877 * 0.125 * 0.125;
    assert!((mixture.gases[4].absorption / want - 1.0).abs() < 1e-12, "{mixture:?}");
}

/// Independent models of the same gas differ by what the fits of different years differ.
#[test]
fn models_agree_on_a_flue_gas() {
    for (h2o, co2) in [(0.1, 0.1), (0.2, 0.1)] {
        for t in [800.0, 1200.0, 1600.0, 2000.0] {
            let all: Vec<f64> = GasModel::VARIANTS
                .into_iter()
                .filter(|m| *m != GasModel::GreySoot)
                .map(|m| m.evaluate(&state(t, h2o, co2)).unwrap().emissivity(2.0))
                .collect();
            let mean = all.iter().sum::<f64>() / all.len() as f64;
            assert!(all.iter().all(|e| (e / mean - 1.0).abs() < 0.25), "{h2o} {co2} {t} K: {all:?}");
        }
    }
}

#[test]
fn weights_sum_to_one_and_emissivity_grows_with_length() {
    for model in GasModel::VARIANTS {
        for t in [450.0, 1000.0, 2300.0] {
            for soot in [0.0, 1e-6] {
                let mixture = model.evaluate(&GasState { soot, ..state(t, 0.12, 0.1) }).unwrap();
                let sum: f64 = mixture.gases.iter().map(|g| g.weight).sum();
                assert!((sum - 1.0).abs() < 1e-14, "{} {t} K: {sum}", model.name());
                assert!(mixture.gases.iter().all(|g| g.absorption >= 0.0));
                let lengths = [0.0, 0.1, 1.0, 10.0, 1e3, 1e9];
                let e = lengths.map(|l| mixture.emissivity(l));
                // A negative weight, which has a note, lets the emissivity fall by as much.
                let slack: f64 = mixture.gases.iter().map(|g| (-g.weight).max(0.0)).sum();
                assert_eq!(slack > 0.0, mixture.notes.iter().any(|n| n.contains("negative")));
                assert!(
                    e[0] == 0.0 && e.windows(2).all(|w| w[0] <= w[1] + slack),
                    "{} {t} K: {e:?}",
                    model.name()
                );
                assert!(e[5] <= 1.0 + 1e-14 && (soot == 0.0 || e[5] > 1.0 - 1e-9), "{} {e:?}", model.name());
            }
        }
    }
}

/// Absorption is proportional to the pressure at a fixed composition, and the Planck mean is the slope of the emissivity.
#[test]
fn absorption_is_proportional_to_pressure() {
    for model in
        [GasModel::Kangwanpongpan2012, GasModel::Dorigon2013, GasModel::Bordbar2020, GasModel::Cassol2014]
    {
        let at = |pressure| model.evaluate(&GasState { pressure, ..state(1100.0, 0.1, 0.1) }).unwrap();
        let (one, two) = (at(101_325.0), at(202_650.0));
        for (a, b) in one.gases.iter().zip(&two.gases) {
            assert!(
                (b.absorption - 2.0 * a.absorption).abs() <= 1e-12 * b.absorption && a.weight == b.weight
            );
        }
        let slope = one.emissivity(1e-7) / 1e-7;
        assert!((slope / one.planck_mean() - 1.0).abs() < 1e-4, "{} {slope}", model.name());
    }
}

#[test]
fn gas_without_absorbing_species_is_clear() {
    for model in GasModel::VARIANTS {
        let mixture = model.evaluate(&GasState::default()).unwrap();
        assert_eq!(mixture.emissivity(1e6), 0.0, "{}", model.name());
        assert!(
            mixture.gases.iter().all(|g| g.absorption == 0.0 && g.weight.is_finite()),
            "{}",
            model.name()
        );
    }
    let soot = GasModel::GreySoot.evaluate(&GasState { soot: 1e-6, ..GasState::default() }).unwrap();
    assert!((soot.gases[0].absorption - 1.817).abs() < 1e-12);
}

/// Pure gases and mixtures next to them have nearly the same emissivity.
#[test]
fn limits_of_the_composition_are_continuous() {
    for model in [GasModel::Smith1982, GasModel::Bordbar2020] {
        let e = |h2o: f64, co2: f64| model.evaluate(&state(1200.0, h2o, co2)).unwrap().emissivity(1.0);
        for [a, b] in
            [[e(0.0, 0.2), e(1e-9, 0.2)], [e(1e-3, 0.1), e(1.0001e-3, 0.1)], [e(0.1, 0.1), e(0.1000001, 0.1)]]
        {
            assert!((a / b - 1.0).abs() < 1e-4, "{}: {a} {b}", model.name());
        }
    }
    let e =
        |h2o: f64, co2: f64| GasModel::Smith1982.evaluate(&state(1200.0, h2o, co2)).unwrap().emissivity(1.0);
    assert!((e(0.2, 0.0) / e(0.2, 1e-9) - 1.0).abs() < 1e-6);
}

#[test]
fn states_outside_the_fit_are_noted_and_others_refused() {
    let notes = |model: GasModel, s: &GasState| model.evaluate(s).unwrap().notes.join("; ");
    assert!(notes(GasModel::Smith1982, &state(500.0, 0.1, 0.1)).contains("500"));
    assert!(notes(GasModel::Bordbar2014, &state(1000.0, 0.2, 0.0)).contains("mole ratio"));
    assert!(notes(GasModel::Bordbar2020, &state(1000.0, 0.2, 0.0)).is_empty());
    assert!(notes(GasModel::Dorigon2013, &state(1000.0, 0.15, 0.1)).contains("1.5"));
    assert!(notes(GasModel::Dorigon2013, &state(1000.0, 0.2, 0.1)).is_empty());
    for (bad, property) in [
        (state(-1.0, 0.1, 0.1), "temperature"),
        (state(f64::NAN, 0.1, 0.1), "temperature"),
        (state(1000.0, 1.2, 0.0), "h2o"),
        (state(1000.0, 0.6, 0.6), "h2o"),
        (state(1000.0, 0.1, -0.1), "co2"),
        (GasState { soot: 2.0, ..state(1000.0, 0.1, 0.1) }, "soot"),
        (GasState { pressure: 0.0, ..state(1000.0, 0.1, 0.1) }, "pressure"),
    ] {
        let e = GasModel::Bordbar2020.evaluate(&bad).unwrap_err();
        assert_eq!(e.property(), property, "{e}");
    }
}
