//! Diagnostics of unbalanced power: reported once, relative to the exchanged power.
//!
//! Guards (numbers): an imbalance is reported once; for heat relative to the exchanged power.

use crate::common;

use common::solved;
use zonal_scene::{Diagnostic, PerBand, Solution, SolveStatus};

fn notes<'a>(s: &'a Solution, word: &str) -> Vec<&'a Diagnostic> {
    s.report.warnings.iter().filter(|w| w.contains(word)).collect()
}

/// A room of 1000 K with a floor of `floor` K and a shelf that occludes some pairs.
fn warm(floor: f64, closure: &str) -> Solution {
    solved(&format!(
        "mode = 'thermal'\n[solve]\npatch_size = 0.34\nclosure = '{closure}'\n[[surface]]\nname = 'room'\nroom = {{ min = [0,0,0], max = [1,1,1] }}\ntemperature = 1000\nemissivity = 0.8\nfaces.z0.temperature = {floor}\n[[surface]]\nname = 'shelf'\nrectangle = {{ origin = [0.2,0.2,0.3], edge1 = [0.5,0,0.1], edge2 = [0,0.5,0] }}\nsides = 'both'\ntemperature = 1000\nemissivity = 0.8\n"
    ))
}

/// Walls at nearly equal temperatures exchange a few hundred-thousandths of their emission; the imbalance is relative to the exchange.
#[test]
fn heat_imbalance_is_relative_to_the_exchanged_power() {
    let s = warm(1000.05, "measure");
    let table = s.report.heat.as_ref().unwrap();
    let given: f64 = table.rows.iter().map(|r| r.power.max(0.0)).sum();
    let off = table.balance().abs() / given;
    let of_emission = s.report.energy.residual.iter().fold(0.0f64, |m, r| m.max(r.abs()));
    assert!(
        of_emission < 1e-3 && off > 0.1,
        "{of_emission:e} of what is emitted, {off} of what is exchanged"
    );
    let stated = notes(&s, "balance is off");
    assert_eq!(stated.len(), 1, "{:?}", s.report.warnings);
    assert!(stated[0].contains("heat balance") && stated[0].contains("restore closure"), "{}", stated[0]);
    // No diagnostic with restored closure, also for equal temperatures without net power.
    for s in [warm(1000.05, "restore"), warm(1000.0, "restore")] {
        assert!(notes(&s, "balance").is_empty(), "{:?}", s.report.warnings);
    }
}

#[test]
fn reached_maximum_of_iterations_is_reported_once() {
    let duct = |mode: &str, look: &str| {
        solved(&format!(
            "{mode}[solve]\npatch_size = 0.5\nmax_iterations = 1\n[[surface]]\nname = 'duct'\nroom = {{ min = [0,0,0], max = [1,1,8] }}\n{look}\n"
        ))
    };
    let light = duct("", "reflectance = 0.9\nfaces.z0 = { emission = 1 }");
    let heat = duct(
        "mode = 'thermal'\n",
        "heat_flux = 0\nemissivity = 0.5\nfaces.z0.heat_flux = 5000\nfaces.z1.temperature = 400",
    );
    for (s, balance) in [(light, "energy balance is off"), (heat, "heat balance is off")] {
        assert_eq!(s.report.status, PerBand::splat(SolveStatus::MaxIterations));
        let stated = notes(&s, "max_iterations");
        assert_eq!(stated.len(), 1, "{:?}", s.report.warnings);
        assert!(
            stated[0].contains("maximum number of iterations") && stated[0].contains("max_iterations"),
            "{}",
            stated[0]
        );
        assert_eq!((notes(&s, "balance").len(), notes(&s, balance)), (1, stated));
    }
}

/// A plate of 300 K radiates onto the black back of the plate above; the diagnostic names that plate and the power.
#[test]
fn power_on_black_backs_is_reported_by_surface() {
    let plate = |name: &str, z: f64, sides: &str| {
        format!(
            "[[surface]]\nname = '{name}'\nrectangle = {{ origin = [0,0,{z}], edge1 = [1,0,0], edge2 = [0,1,0] }}\nemissivity = 0.9\ntemperature = 300\n{sides}\n"
        )
    };
    let plates = |sides: &str| {
        let head = "mode = 'thermal'\n[solve]\npatch_size = 0.25\ndiscretization_error = false\n[surroundings]\ntemperature = 300\n";
        solved(&format!("{head}{}{}", plate("low", 0.0, sides), plate("high", 1.0, sides)))
    };
    let s = plates("");
    let lost = s.report.heat.as_ref().unwrap().absorbed_backfaces;
    assert!(lost > 70.0 && lost < 95.0, "{lost} W");
    let [note] = notes(&s, "backs of one-sided surfaces")[..] else { panic!("{:?}", s.report.warnings) };
    assert!(
        note.is_warning() && note.contains("high (about") && note.contains("sides = \"both\""),
        "{note:?}"
    );
    assert!(note.contains(&format!("{lost:.4} W")), "{note:?}");
    let open = plates("sides = 'both'");
    assert!(notes(&open, "backs of").is_empty(), "{:?}", open.report.warnings);
}
