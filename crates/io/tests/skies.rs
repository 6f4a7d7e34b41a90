//! Skies, suns by place and time, and photometric quantities of scene files, and what is refused.

use crate::support;

use std::f64::consts::PI;
use support::Folder;
use zonal_io::output::write_exr;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, Light, SkyDistribution};

const WALL: &str =
    "[[surface]]\nname = \"wall\"\nrectangle = { origin = [0,0,0], edge1 = [1,0,0], edge2 = [0,1,0] }\n";
/// A picture of 2 × 1 pixels, red on the left, green on the right, in the format of Radiance.
const HDR: &[u8] = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x00\x00\x81\x00\x80\x00\x81";

fn folder() -> Folder {
    let folder = Folder::new().with("sky.hdr", HDR).with("not.hdr", "text");
    write_exr(&folder.path().join("sky.exr"), 2, 1, &[[1.0, 0.0, 0.0], [0.0, 3.0, 0.0]]).unwrap();
    folder
}

/// Unit radiance and distribution of the only light.
fn sky(light: &str) -> (Bands, SkyDistribution) {
    match &folder().scene(&format!("{WALL}[[light]]\n{light}")).lights()[0] {
        Light::Sky { radiance, distribution, .. } => (*radiance, distribution.clone()),
        other => panic!("{other:?}"),
    }
}

fn near(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-9 * b.abs().max(1.0), "{a} {b}");
}

#[test]
fn skies_are_given_by_irradiance_radiance_or_photometric_quantities() {
    let up = vec3(0.0, 0.0, 1.0);
    let overcast = "kind = \"cie-sky\"\ntype = 1\n";
    let (radiance, f) = sky(&format!("{overcast}zenith_radiance = [6, 5, 4]\n"));
    near(radiance.first() * f.relative(up).first(), 6.0);
    let (radiance, _) = sky(&format!("{overcast}horizontal_irradiance = 3\nground_reflectance = 0.2\n"));
    near(radiance.first(), 3.0 / PI);
    let (radiance, _) = sky(&format!("{overcast}horizontal_illuminance = 13660\ntint = [1.5, 1, 0.5]\n"));
    assert_eq!(radiance.to_rgb().map(|x| (x * PI * 1e9).round() / 1e9), [30.0, 20.0, 10.0]);
    let (radiance, f) = sky(&format!("{overcast}zenith_luminance = 500\nefficacy = 100\n"));
    near(radiance.first() * f.relative(up).first(), 5.0);
    let (radiance, f) = sky("kind = \"sky\"\nluminance = 683\n");
    assert!(f.is_uniform() && radiance.first() == 1.0);
    let clear = "kind = \"cie-sky\"\ntype = 12\nzenith_radiance = 1\ndirection = [0, 1, -1]\n";
    let (radiance, f) = sky(clear);
    assert!(radiance.first() * f.relative(vec3(0.0, -0.7, 0.7).normalized()).first() > 3.0);
}

#[test]
fn suns_and_skies_have_places_and_times() {
    // Golden, 17 October 2003, 12:30:30: azimuth 194.34° from north over east, elevation 39.87° (Reda, Andreas 2004).
    let place = "latitude = 39.742476\nlongitude = -105.1786\ntime = 2003-10-17T12:30:30-07:00\n";
    let [azimuth, elevation] = [194.34024f64, 39.872046].map(f64::to_radians);
    let expected = vec3(azimuth.sin() * elevation.cos(), azimuth.cos() * elevation.cos(), elevation.sin());
    let sun = |keys: &str| match &folder()
        .scene(&format!("{WALL}[[light]]\nkind = \"sun\"\nirradiance = 1\n{keys}"))
        .lights()[0]
    {
        Light::Sun { direction, .. } => -*direction,
        other => panic!("{other:?}"),
    };
    let off = |d: Vec3, e: Vec3| (d - e).length().to_degrees();
    assert!(off(sun(place), expected) < 0.015, "{:?} {expected:?}", sun(place));
    // As a text, in universal time, with north along x, and with y up.
    let text = place.replace("2003-10-17T12:30:30-07:00", "\"2003-10-17T19:30:30Z\"");
    assert!(off(sun(&text), expected) < 0.015);
    let turned = vec3(expected.y, -expected.x, expected.z);
    assert!(off(sun(&format!("{text}north = [2, 0, 0.5]\n")), turned) < 0.015);
    let y_up = vec3(expected.x, expected.z, -expected.y);
    assert!(off(sun(&format!("{text}north = [0, 0, -1]\nup = [0, 1, 0]\n")), y_up) < 0.015);
    // The brightest direction of a clear sky is the sun.
    let perez = format!("kind = \"perez-sky\"\ndirect_normal = 850\ndiffuse_horizontal = 90\n{place}");
    let (radiance, f) = sky(&perez);
    near(radiance.first(), 90.0 / PI);
    assert!(f.relative(expected).first() > 3.0 * f.relative(vec3(0.0, 0.6, 0.8)).first());
}

#[test]
fn skies_are_pictures_of_two_formats() {
    let (radiance, f) = sky("kind = \"image-sky\"\nimage = \"sky.hdr\"\n");
    assert_eq!(radiance, Bands::ONE);
    // The left half of the picture is on the left of x.
    let [left, right] = [1.0, -1.0].map(|y| f.relative(vec3(0.6, 0.8 * y, 0.0)).to_rgb());
    assert!(left[0] > 0.9 && left[1] < 0.01 && right[1] > 0.9, "{left:?} {right:?}");
    let (radiance, f) = sky("kind = \"image-sky\"\nimage = \"sky.exr\"\nluminance = 1366\nrotation = 180\n");
    near(radiance.first(), 2.0);
    let [left, right] = [1.0, -1.0].map(|y| f.relative(vec3(0.6, 0.8 * y, 0.0)).to_rgb());
    assert_eq!((left, right), ([0.0, 3.0, 0.0], [1.0, 0.0, 0.0]));
    // Bands that are not red, green and blue have the mean of the channels.
    let scene = folder().scene(&format!(
        "bands = 5\n{WALL}[[light]]\nkind = \"image-sky\"\nimage = \"sky.exr\"\nradiance = [1, 2, 3, 4, 5]\n"
    ));
    for block in scene.blocks() {
        let Light::Sky { distribution, .. } = &block.lights()[0] else { panic!() };
        assert_eq!(distribution.relative(vec3(0.0, -1.0, 0.1).normalized()), Bands::ONE);
    }
}

#[test]
fn wrong_skies_are_refused_with_their_place_and_remedy() {
    let cie = "kind = \"cie-sky\"\ntype = 12\n";
    let sun = "kind = \"sun\"\nirradiance = 1\n";
    let place = "latitude = 48\nlongitude = 11\n";
    for (light, part) in [
        (format!("{cie}direction = [0, 0, -1]\n"), "horizontal_irradiance = 100"),
        (format!("{cie}zenith_radiance = 1\n"), "direction = [x, y, z]"),
        (format!("{cie}zenith_radiance = 1\ndirection = [0, 0, 1]\n"), "below the horizon"),
        (
            format!("{cie}zenith_radiance = 1\ndirection = [0, 0, -1]\nzenith_luminance = 5\n"),
            "both given; keep one",
        ),
        (format!("{cie}zenith_radiance = 1\ndirection = [0, 0, -1]\nefficacy = 100\n"), "it belongs to"),
        (cie.replace("12", "16"), "from 1 to 15"),
        (format!("{sun}{place}direction = [0, 0, -1]\n"), "keep the direction"),
        (format!("{sun}up = [0, 1, 0]\ndirection = [0, 0, -1]\n"), "up belongs to latitude"),
        (format!("{sun}{place}"), "time = \"2026-06-21T12:00:00+02:00\""),
        (format!("{sun}{place}time = \"noon\"\n"), "'noon' is no moment"),
        (format!("{sun}{place}time = 2026-06-21T12:00:00\n"), "offset from universal time"),
        (format!("{sun}{place}time = 2026-06-21T23:30:00Z\n"), "below the horizon at this time"),
        (format!("{sun}{place}time = 2206-06-21T12:00:00Z\n"), "1900 to 2100"),
        (format!("{sun}{place}time = 2026-06-21T12:00:00Z\nnorth = [0, 0, 1]\n"), "north lies along up"),
        (
            "kind = \"perez-sky\"\ndirect_normal = 1\ndiffuse_horizontal = 0\ndirection = [0, 0, -1]\n"
                .into(),
            "above 0",
        ),
        ("kind = \"image-sky\"\nimage = \"none.hdr\"\n".into(), "none.hdr"),
        ("kind = \"image-sky\"\nimage = \"not.hdr\"\n".into(), "neither an OpenEXR nor a Radiance picture"),
    ] {
        let found = folder().refusal(&format!("{WALL}[[light]]\n{light}"));
        assert!(found.contains(part), "{light}: {found}");
    }
}
