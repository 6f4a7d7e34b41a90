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
fn tilt_factors_belong_to_the_aim() {
    let file = |geometry: usize| IES.replace("NONE", &format!("INCLUDE\n{geometry}\n3\n0 45 90\n1 0.8 0.5"));
    let folder = Folder::new().with("along.ies", file(1)).with("across.ies", file(2));
    let text = |name: &str, aim: &str| {
        format!(
            "{WALL}[[light]]\nkind = \"luminaire\"\nposition = [0, 0, 2]\nfile = \"{name}.ies\"\ndirection = {aim}\n"
        )
    };
    let intensity = |name: &str, aim: &str| match &folder.scene(&text(name, aim)).lights()[0] {
        Light::Point { intensity, .. } => intensity.first(),
        other => panic!("{other:?}"),
    };
    // 2 W/sr at the aim without tilt; 30 degrees off straight down 1 − 0.2 · 30/45.
    let inclined = "[0.5, 0, -0.8660254037844386]";
    for (name, aim, expected) in [
        ("along", "[0, 0, -1]", 2.0),
        ("along", inclined, 2.0 * (1.0 - 0.2 * 30.0 / 45.0)),
        ("along", "[1, 0, 0]", 1.0),
        ("across", "[0, 0, -1]", 2.0),
    ] {
        let found = intensity(name, aim);
        assert!((found - expected).abs() < 1e-9, "{name} {aim}: {found}");
    }
    for (name, aim, word) in
        [("across", inclined, "30.0 degrees off straight down"), ("along", "[0, 0, 1]", "0 to 90 degrees")]
    {
        let e = folder.refusal(&text(name, aim));
        assert!(e.contains(word) && e.contains("TILT=NONE"), "{e}");
    }
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

/// A square with a directional light, a coloured point and a spot on nodes, as glTF.
fn lit_quad() -> Vec<u8> {
    let nodes = r#"{"mesh":0,"children":[1,2,3]},
        {"extensions":{"KHR_lights_punctual":{"light":0}},"rotation":[0.7071067811865476,0,0,0.7071067811865476]},
        {"extensions":{"KHR_lights_punctual":{"light":1}},"translation":[1,2,3]},
        {"extensions":{"KHR_lights_punctual":{"light":2}},"translation":[0,0,4]}"#;
    let more = r#","extensionsUsed":["KHR_lights_punctual"],"extensions":{"KHR_lights_punctual":{"lights":[
        {"type":"directional","intensity":6830,"name":"sun"},
        {"type":"point","intensity":683,"color":[1,0.5,0],"range":3},
        {"type":"spot","intensity":1366,"name":"spot","spot":{"innerConeAngle":0.25,"outerConeAngle":0.5}}]}}"#;
    let quad = support::Quad { nodes: nodes.into(), more: more.into(), ..support::Quad::default() };
    quad.glb()
}

#[test]
fn lights_of_gltf_meshes_are_lights_of_the_scene() {
    let folder = Folder::new().with("q.glb", lit_quad());
    let text = "[[surface]]\nname = \"q\"\nmesh = { file = \"q.glb\", scale = 2, translate = [0, 0, 1] }\n";
    let scene = folder.scene(text);
    let [sun, point, spot] = scene.lights() else { panic!("{:?}", scene.lights()) };
    let Light::Sun { name, direction, irradiance, angular_diameter } = sun else { panic!("{sun:?}") };
    // A quarter turn about x carries −z to +y.
    assert!((*direction - vec3(0.0, 1.0, 0.0)).length() < 1e-6, "{direction:?}");
    assert_eq!((name.as_str(), irradiance.first(), *angular_diameter), ("q/sun", 10.0, 0.0));
    let Light::Point { name, position, intensity, distribution } = point else { panic!("{point:?}") };
    assert_eq!(
        (name.as_str(), intensity.to_rgb(), *position),
        ("q/light2", [1.0, 0.5, 0.0], vec3(2.0, 4.0, 7.0))
    );
    assert_eq!(*distribution, IntensityDistribution::isotropic());
    let Light::Point { position, intensity, distribution, .. } = spot else { panic!("{spot:?}") };
    assert_eq!((intensity.first(), *position), (2.0, vec3(0.0, 0.0, 9.0)));
    let at = |angle: f64| distribution.relative(vec3(angle.sin(), 0.0, -angle.cos()));
    assert!(at(0.2) == 1.0 && at(0.4) > 0.0 && at(0.4) < 0.9 && at(0.51) == 0.0);
    assert!(scene.notes().iter().any(|n| n.contains("the range of 1 light(s) is not read")));
    assert!(folder.scene(&format!("{text}lights = false\n")).lights().is_empty());
    let thermal = folder.scene(&format!("mode = \"thermal\"\n{text}temperature = 300\nemissivity = 0.5\n"));
    assert!(thermal.lights().is_empty());
    // A cone that is none, and a light that is not there.
    for (from, to, part) in [
        ("\"outerConeAngle\":0.5", "\"outerConeAngle\":0.1", "node 3"),
        ("\"light\":2", "\"light\":7", "light"),
    ] {
        let mut bytes = lit_quad();
        let at = bytes.windows(from.len()).position(|w| w == from.as_bytes()).unwrap();
        bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
        folder.put("q.glb", bytes);
        let found = folder.refusal(text);
        assert!(found.contains(part), "{found}");
    }
}
