//! The keys of skies, and of place and time.

use super::keys::{KeyGroups, KeySpec, key};

/// Place and time of a sun, in place of its direction.
pub(crate) const PLACE_KEYS: &[KeySpec] = &[
    key(
        "latitude",
        "number in [-90, 90]",
        "degrees",
        "",
        "latitude, positive in the north, in place of the direction",
    ),
    key("longitude", "number in [-180, 180]", "degrees", "", "longitude, positive in the east"),
    key(
        "time",
        "date and time with offset",
        "",
        "",
        "moment, such as \"2026-06-21T12:00:00+02:00\", or with Z for universal time",
    ),
    key("north", "direction", "", "[0, 1, 0]", "direction towards north"),
    key("up", "direction", "", "[0, 0, 1]", "direction towards the zenith"),
];
/// Luminous efficacy and colour of a photometric quantity.
pub(crate) const PHOTOMETRIC_KEYS: &[KeySpec] = &[
    key(
        "efficacy",
        "number above 0",
        "lm/W",
        "683",
        "lumens of a watt of radiant power, with a photometric quantity",
    ),
    TINT,
];
/// Colour of a number.
const TINT: KeySpec = key("tint", "bands of mean 1", "", "1", "relative power of the bands (light mode)");
const NAME: KeySpec = key("name", "text", "", "light1, …", "name of the light group");
const GROUND: KeySpec = key(
    "ground_reflectance",
    "number in [0, 1]",
    "",
    "0",
    "reflectance of the ground below the horizon, which the sky lights",
);

/// `[[light]]` with `kind = "sky"`.
pub(crate) const SKY: KeyGroups = &[
    &[
        key("kind", "\"sky\"", "", "required", "uniform sky"),
        NAME,
        key(
            "radiance",
            "bands from 0; a number in thermal mode",
            "W/(m2 sr)",
            "required without luminance",
            "radiance",
        ),
        key("luminance", "number from 0", "cd/m2", "", "luminance, in place of the radiance"),
    ],
    PHOTOMETRIC_KEYS,
];
/// `[[light]]` with `kind = "cie-sky"`.
pub(crate) const CIE_SKY: KeyGroups = &[
    &[
        key("kind", "\"cie-sky\"", "", "required", "CIE standard general sky (ISO 15469)"),
        NAME,
        key(
            "type",
            "integer from 1 to 15",
            "",
            "required",
            "type of the sky: 1 overcast, 12 clear, 15 clear and turbid",
        ),
        key(
            "horizontal_irradiance",
            "bands from 0; a number in thermal mode",
            "W/m2",
            "required without the next three",
            "irradiance of an unobstructed horizontal plane",
        ),
        key(
            "zenith_radiance",
            "bands from 0; a number in thermal mode",
            "W/(m2 sr)",
            "",
            "radiance of the zenith, in place of the irradiance",
        ),
        key(
            "horizontal_illuminance",
            "number from 0",
            "lx",
            "",
            "illuminance of an unobstructed horizontal plane",
        ),
        key("zenith_luminance", "number from 0", "cd/m2", "", "luminance of the zenith"),
        key(
            "direction",
            "direction",
            "",
            "required without a place; no sun in types 1, 3 and 5",
            "direction in which the light of the sun travels",
        ),
        GROUND,
    ],
    PLACE_KEYS,
    PHOTOMETRIC_KEYS,
];
/// `[[light]]` with `kind = "perez-sky"`.
pub(crate) const PEREZ_SKY: KeyGroups = &[
    &[
        key("kind", "\"perez-sky\"", "", "required", "Perez all-weather sky, without the sun"),
        NAME,
        key(
            "direct_normal",
            "number from 0",
            "W/m2",
            "required",
            "irradiance by the sun of a plane normal to its light, on which the sky depends",
        ),
        key(
            "diffuse_horizontal",
            "number above 0",
            "W/m2",
            "required",
            "irradiance of an unobstructed horizontal plane by the sky",
        ),
        key(
            "direction",
            "direction",
            "",
            "required without a place",
            "direction in which the light of the sun travels",
        ),
        GROUND,
        TINT,
    ],
    PLACE_KEYS,
];
/// `[[light]]` with `kind = "image-sky"`.
pub(crate) const IMAGE_SKY: KeyGroups = &[
    &[
        key("kind", "\"image-sky\"", "", "required", "sky from a picture"),
        NAME,
        key(
            "image",
            "file name",
            "",
            "required",
            "equirectangular picture, .exr (OpenEXR) or .hdr (Radiance), twice as wide as high",
        ),
        key(
            "radiance",
            "bands from 0; a number in thermal mode",
            "W/(m2 sr)",
            "1",
            "radiance of the pixel value 1",
        ),
        key(
            "luminance",
            "number from 0",
            "cd/m2",
            "",
            "luminance of the pixel value 1, in place of the radiance",
        ),
        key("up", "direction", "", "[0, 0, 1]", "direction of the upper edge of the picture"),
        key(
            "rotation",
            "number",
            "degrees",
            "0",
            "turn of the picture about up, counterclockwise from above; at 0 its middle looks along x",
        ),
    ],
    PHOTOMETRIC_KEYS,
];
