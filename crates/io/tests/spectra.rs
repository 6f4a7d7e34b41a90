//! Spectra in the place of bands: tables, illuminants, black bodies, and what is refused.

use crate::support;

use support::Folder;
use zonal_scene::{Light, Scene};

const TABLE: &str = "wavelength,paint,lamp\n400,0.2,1\n500,0.4,3\n700,0.4,3\n";

fn scene_text(bands: &str, reflectance: &str, irradiance: &str) -> String {
    format!(
        "{bands}\n[[surface]]\nname = \"wall\"\nrectangle = {{ origin = [0,0,0], edge1 = [1,0,0], edge2 = [0,1,0] }}\nreflectance = {reflectance}\n[[light]]\nkind = \"sun\"\ndirection = [0,0,-1]\nirradiance = {irradiance}\n"
    )
}

const BANDS: &str = "bands = [[400, 500], [500, 600], [600, 650], [650, 700]]";

/// The values of the bands of a scene.
fn of_bands(scene: &Scene, value: impl Fn(&Scene) -> [f64; 3]) -> Vec<f64> {
    scene.blocks().flat_map(|b| value(&b)).take(scene.bands().count()).collect()
}

fn irradiance(scene: &Scene) -> [f64; 3] {
    match &scene.lights()[0] {
        Light::Sun { irradiance, .. } => irradiance.to_rgb(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn properties_are_means_and_fluxes_integrals() {
    let folder = Folder::new().with("s.csv", TABLE);
    let read =
        |reflectance: &str, irradiance: &str| folder.scene(&scene_text(BANDS, reflectance, irradiance));
    let s = read("{ spectrum = \"s.csv\" }", "{ spectrum = \"s.csv\", column = \"lamp\" }");
    let close = |a: &[f64], b: &[f64]| {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12 * b.abs().max(1.0))
    };
    let reflectances = of_bands(&s, |t| t.surfaces()[0].reflectance.to_rgb());
    assert!(close(&reflectances, &[0.3, 0.4, 0.4, 0.4]), "{reflectances:?}");
    assert!(close(&of_bands(&s, irradiance), &[200.0, 300.0, 150.0, 150.0]));
    let s = read("{ spectrum = \"s.csv\", scale = 0.5 }", "{ spectrum = \"s.csv\", column = 3, total = 16 }");
    assert!(close(&of_bands(&s, |t| t.surfaces()[0].reflectance.to_rgb()), &[0.15, 0.2, 0.2, 0.2]));
    assert!(close(&of_bands(&s, irradiance), &[4.0, 6.0, 3.0, 3.0]));
    // Daylight has more blue than a lamp.
    let ratio = |light: &str| {
        let all = of_bands(&read("0.5", &format!("{{ {light}, total = 10 }}")), irradiance);
        assert!((all.iter().sum::<f64>() - 10.0).abs() < 1e-12);
        all[0] / all[1]
    };
    assert!(ratio("illuminant = \"D65\"") > 0.9 && ratio("black_body = 2856") < 0.5);
}

#[test]
fn wrong_spectra_are_refused() {
    let folder = Folder::new()
        .with("s.csv", TABLE)
        .with("short.csv", "450,0.1\n700,0.2\n")
        .with("mixed.csv", "400,0.1\n700,0.2\n650,0.1\n")
        .with("bright.csv", "400,1.5\n700,1.5\n")
        .with("negative.csv", "400,0.1\n700,-0.1\n")
        .with("one.csv", "400,0.1\n");
    let file = |name: &str| format!("{{ spectrum = \"{name}\" }}");
    for (bands, reflectance, irradiance, words) in [
        (BANDS, file("none.csv"), "1", "none.csv"),
        (BANDS, file("short.csv"), "1", "reaches from 450 to 700"),
        (BANDS, file("mixed.csv"), "1", "do not ascend"),
        (BANDS, file("bright.csv"), "1", "at most 1"),
        (BANDS, file("negative.csv"), "1", "from 0"),
        (BANDS, file("one.csv"), "1", "two rows"),
        ("", file("s.csv"), "1", "no wavelengths"),
        (BANDS, "{ spectrum = \"s.csv\", column = \"pain\" }".into(), "1", "paint"),
        (BANDS, "{ spectrum = \"s.csv\", total = 3 }".into(), "1", "no total"),
        (BANDS, "{ spectrum = \"s.csv\", illuminant = \"D65\" }".into(), "1", "one source"),
        (BANDS, "0.5".into(), "{ illuminant = \"D65\" }", "give total"),
        (BANDS, "0.5".into(), "{ illuminant = \"D50\", total = 1 }", "D50"),
        (BANDS, "0.5".into(), "{ black_body = 5, total = 1 }", "out of range"),
        (BANDS, "0.5".into(), "{ black_body = 5000, total = 1, scale = 2 }", "total and scale"),
        ("bands = [[200, 300]]", "0.5".into(), "{ illuminant = \"D65\", total = 1 }", "reaches from 300"),
    ] {
        let message = folder.refusal(&scene_text(bands, &reflectance, irradiance));
        assert!(
            message.contains(words) && message.starts_with("test.toml:"),
            "'{words}' is not in: {message}"
        );
        assert!(message.contains(';') && !message.contains('\n'), "{message}");
    }
}
