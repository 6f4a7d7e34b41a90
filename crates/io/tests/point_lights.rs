//! Point lights, spots and luminaires of scene files, and what is refused.

use crate::support;

use std::f64::consts::PI;
use support::Folder;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, IntensityDistribution, Light};

const WALL: &str =
    "[[surface]]\nname = \"wall\"\nrectangle = { origin = [0,0,0], edge1 = [1,0,0], edge2 = [0,1,0] }\n";
const IES: &str = "IESNA91\nTILT=NONE\n1 1000 1 3 1 1 2 0 0 0\n1 1 30\n0 45 90\n0\n1366 683 0\n";

/// Position, unit intensity and distribution of the only light.
fn lamp(light: &str) -> (Vec3, Bands, IntensityDistribution) {
    let folder = Folder::new().with("lamp.ies", IES);
    let scene = folder.scene(&format!("{WALL}[[light]]\n{light}"));
    match &scene.lights()[0] {
        Light::Point { position, intensity, distribution, .. } => {
            (*position, *intensity, distribution.clone())
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn strengths_are_intensities_or_powers() {
    let (at, intensity, d) = lamp("kind = \"point\"\nposition = [0, 1, 2]\nintensity = [1, 2, 3]\n");
    assert_eq!((at, intensity.to_rgb()), (vec3(0.0, 1.0, 2.0), [1.0, 2.0, 3.0]));
    assert_eq!(d, IntensityDistribution::isotropic());
    let (_, intensity, _) = lamp("kind = \"point\"\nposition = [0, 1, 2]\npower = 8\n");
    assert!((intensity.first() - 2.0 / PI).abs() < 1e-12);
    let spot = "kind = \"spot\"\nposition = [0, 0, 2]\ndirection = [0, 0, -3]\nouter_angle = 60\n";
    let (_, intensity, d) = lamp(&format!("{spot}inner_angle = 60\npower = 5\n"));
    // A cone of 60 degrees has π sr.
    assert!((intensity.first() - 5.0 / PI).abs() < 1e-12, "{intensity:?}");
    assert_eq!(d.relative(vec3(0.6, 0.0, -0.8)), 1.0);
    let (_, _, d) = lamp(&format!("{spot}intensity = 5\n"));
    assert!((d.relative(vec3(0.6, 0.0, -0.8)) - 0.36).abs() < 1e-12);
}

#[test]
fn luminaires_have_the_watts_of_their_candelas() {
    let text = "kind = \"luminaire\"\nposition = [0, 0, 2]\nfile = \"lamp.ies\"\n";
    let (_, intensity, d) = lamp(text);
    assert!((intensity.first() - 2.0).abs() < 1e-12, "{intensity:?}");
    let s = 0.5f64.sqrt();
    assert!((d.relative(vec3(s, 0.0, -s)) - 0.5).abs() < 1e-12 && d.relative(vec3(0.0, 0.0, 1.0)) == 0.0);
    let keys =
        "direction = [1, 0, 0]\nrotation = 30\ndimming = 0.5\nefficacy = 341.5\ntint = [1.5, 1, 0.5]\n";
    let (_, intensity, d) = lamp(&format!("{text}{keys}"));
    assert_eq!(intensity.to_rgb().map(|x| (x * 1e9).round() / 1e9), [3.0, 2.0, 1.0]);
    assert!((d.relative(vec3(1.0, 0.0, 0.0)) - 1.0).abs() < 1e-12);
}

#[test]
fn wrong_lights_are_refused_with_their_place_and_remedy() {
    let folder = Folder::new().with("lamp.ies", IES).with("bad.ies", "IESNA91\nTILT=NONE\n1 x\n");
    let point = "kind = \"point\"\nposition = [0, 1, 2]\n";
    let spot = "kind = \"spot\"\nposition = [0, 0, 2]\ndirection = [0, 0, -3]\nintensity = 1\n";
    let luminaire = "kind = \"luminaire\"\nposition = [0, 0, 2]\n";
    for (light, part) in [
        (point.to_string(), "intensity = 10"),
        (format!("{point}intensity = 1\npower = 2\n"), "both given; keep one"),
        (format!("{point}intensity = -1\n"), "-1"),
        ("kind = \"point\"\nintensity = 1\n".into(), "position = [x, y, z]"),
        (format!("{spot}outer_angle = 0\n"), "from 0.1 to 180"),
        (format!("{spot}outer_angle = 20\ninner_angle = 30\n"), "up to the outer angle, 20"),
        (spot.replace("[0, 0, -3]", "[0, 0, 0]") + "outer_angle = 20\n", "no length"),
        (luminaire.to_string(), "file = \"lamp.ies\""),
        (format!("{luminaire}file = \"none.ies\"\n"), "none.ies"),
        (
            format!("{luminaire}file = \"bad.ies\"\n"),
            "bad.ies:3: 'x' stands where the lumens per lamp belongs",
        ),
        (format!("{luminaire}file = \"lamp.ies\"\ntint = [1, 1, 4]\n"), "the mean of the bands is 2"),
        (format!("{luminaire}file = \"lamp.ies\"\nefficacy = 0\n"), "efficacy"),
        (format!("{luminaire}file = \"lamp.ies\"\npower = 5\n"), "power"),
        ("kind = \"lamp\"\n".into(), "luminaire"),
    ] {
        let found = folder.refusal(&format!("{WALL}[[light]]\n{light}"));
        assert!(found.contains(part), "{light}: {found}");
    }
}
