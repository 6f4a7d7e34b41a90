//! The keys of skies, and of place and time.

use super::band_kinds::FLUX_OF_LIGHT;
use super::keys::{Kind, keys};
use super::kinds::{
    DEGREES, DIRECTION, FILE, NON_NEGATIVE, POSITIVE, TEXT, UP_TO_ONE, degrees_within, shown,
};
use zonal_math::Vec3;
use zonal_scene::Bands;

const LATITUDE: Kind<f64> =
    Kind::new("number in [-90, 90]", |n| degrees_within(n, -90.0..=90.0, "")).in_unit("degrees");
const LONGITUDE: Kind<f64> =
    Kind::new("number in [-180, 180]", |n| degrees_within(n, -180.0..=180.0, "")).in_unit("degrees");

keys! {
    /// Place and time of a sun, in place of its direction.
    PLACE: Place = [Place] {
        latitude: f64 = LATITUDE, "", "latitude, positive in the north, in place of the direction", "48.1 (degrees north)";
        longitude: f64 = LONGITUDE, "", "longitude, positive in the east", "11.6 (degrees east)";
        time: () = shown("date and time with offset", ""), "",
            "moment, such as \"2026-06-21T12:00:00+02:00\", or with Z for universal time", "\"2026-06-21T12:00:00+02:00\"";
        north: Vec3 = DIRECTION, "[0, 1, 0]", "direction towards north";
        up: Vec3 = DIRECTION, "[0, 0, 1]", "direction towards the zenith";
    }
    /// Luminous efficacy of a photometric quantity, and the colour of a number.
    PHOTOMETRY: Photometry = [Efficacy, Photometry] {
        tint: () = shown("bands of mean 1", ""), "1", "relative power of the bands (light mode)";
    }
    /// Luminous efficacy of a photometric quantity.
    EFFICACY: Efficacy = [Efficacy] {
        efficacy: f64 = POSITIVE.in_unit("lm/W"), "683", "lumens of a watt of radiant power, with a photometric quantity";
    }
    /// The ground below a sky.
    GROUND: Ground = [Ground] {
        ground_reflectance: f64 = UP_TO_ONE, "0", "reflectance of the ground below the horizon, which the sky lights";
    }
    /// `[[light]]` with `kind = "sky"`.
    SKY: Sky = [Sky, Efficacy, Photometry] {
        kind: () = shown("\"sky\"", ""), "required", "uniform sky";
        name: String = TEXT, "light1, …", "name of the light group";
        radiance: Bands = FLUX_OF_LIGHT.in_unit("W/(m2 sr)"), "required without luminance", "radiance";
        luminance: f64 = NON_NEGATIVE.in_unit("cd/m2"), "", "luminance, in place of the radiance";
    }
    /// `[[light]]` with `kind = "cie-sky"`.
    CIE_SKY: CieSky = [CieSky, Ground, Place, Efficacy, Photometry] {
        kind: () = shown("\"cie-sky\"", ""), "required", "CIE standard general sky (ISO 15469)";
        name: String = TEXT, "light1, …", "name of the light group";
        r#type: () = shown("integer from 1 to 15", ""), "required", "type of the sky: 1 overcast, 12 clear, 15 clear and turbid",
            "1 (1 to 15; 1 is overcast, 12 clear)";
        horizontal_irradiance: Bands = FLUX_OF_LIGHT.in_unit("W/m2"), "required without the next three",
            "irradiance of an unobstructed horizontal plane";
        zenith_radiance: Bands = FLUX_OF_LIGHT.in_unit("W/(m2 sr)"), "", "radiance of the zenith, in place of the irradiance";
        horizontal_illuminance: f64 = NON_NEGATIVE.in_unit("lx"), "", "illuminance of an unobstructed horizontal plane";
        zenith_luminance: f64 = NON_NEGATIVE.in_unit("cd/m2"), "", "luminance of the zenith";
        direction: Vec3 = DIRECTION, "required without a place; no sun in types 1, 3 and 5", "direction in which the light of the sun travels";
    }
    /// `[[light]]` with `kind = "perez-sky"`.
    PEREZ_SKY: PerezSky = [PerezSky, Ground, Photometry, Place] {
        kind: () = shown("\"perez-sky\"", ""), "required", "Perez all-weather sky, without the sun";
        name: String = TEXT, "light1, …", "name of the light group";
        direct_normal: f64 = NON_NEGATIVE.in_unit("W/m2"), "required",
            "irradiance by the sun of a plane normal to its light, on which the sky depends", "800 (W/m2)";
        diffuse_horizontal: f64 = POSITIVE.in_unit("W/m2"), "required", "irradiance of an unobstructed horizontal plane by the sky",
            "100 (W/m2)";
        direction: Vec3 = DIRECTION, "required without a place", "direction in which the light of the sun travels";
    }
    /// `[[light]]` with `kind = "image-sky"`.
    IMAGE_SKY: ImageSky = [ImageSky, Efficacy, Photometry] {
        kind: () = shown("\"image-sky\"", ""), "required", "sky from a picture";
        name: String = TEXT, "light1, …", "name of the light group";
        image: () = FILE, "required", "equirectangular picture, .exr (OpenEXR) or .hdr (Radiance), twice as wide as high",
            "\"sky.exr\" or \"sky.hdr\"";
        radiance: Bands = FLUX_OF_LIGHT.in_unit("W/(m2 sr)"), "1", "radiance of the pixel value 1";
        luminance: f64 = NON_NEGATIVE.in_unit("cd/m2"), "", "luminance of the pixel value 1, in place of the radiance";
        up: Vec3 = DIRECTION, "[0, 0, 1]", "direction of the upper edge of the picture";
        rotation: f64 = DEGREES, "0", "turn of the picture about up, counterclockwise from above; at 0 its middle looks along x";
    }
}
