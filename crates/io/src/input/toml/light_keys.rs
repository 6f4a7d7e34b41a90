//! The keys of lights, surroundings and spectra.

use super::keys::{KeyGroups, KeySpec, key};
use super::sky_keys::{PHOTOMETRIC_KEYS, PLACE_KEYS};

/// `[[light]]` with `kind = "sun"`.
pub(crate) const SUN: KeyGroups = &[
    &[
        key("kind", "\"sun\"", "", "required", "distant light"),
        key("name", "text", "", "light1, …", "name of the light group"),
        key("direction", "direction", "", "required without a place", "direction in which the light travels"),
        key(
            "irradiance",
            "bands from 0; a number in thermal mode",
            "W/m2",
            "required without illuminance",
            "irradiance of a plane normal to the direction",
        ),
        key(
            "illuminance",
            "number from 0",
            "lx",
            "",
            "illuminance of that plane, in place of the irradiance",
        ),
        key("angular_diameter", "number in [0, 180)", "degrees", "0.53", "angular diameter"),
    ],
    PLACE_KEYS,
    PHOTOMETRIC_KEYS,
];
/// Keys of every light without extent.
const PLACED_LIGHT_KEYS: &[KeySpec] = &[
    key("name", "text", "", "light1, …", "name of the light group"),
    key("position", "point", "m", "required", "position"),
];
/// Keys of the strength of a point or a spot.
const INTENSITY_KEYS: &[KeySpec] = &[
    key(
        "intensity",
        "bands from 0; a number in thermal mode",
        "W/sr",
        "required without the next three",
        "radiant intensity, of a spot on its axis",
    ),
    key(
        "power",
        "bands from 0; a number in thermal mode",
        "W",
        "",
        "radiant power, in place of the intensity",
    ),
    key("luminous_intensity", "number from 0", "cd", "", "luminous intensity, of a spot on its axis"),
    key("luminous_flux", "number from 0", "lm", "", "luminous flux"),
];
/// `[[light]]` with `kind = "point"`.
pub(crate) const POINT: KeyGroups = &[
    &[key("kind", "\"point\"", "", "required", "light without extent, the same in all directions")],
    PLACED_LIGHT_KEYS,
    INTENSITY_KEYS,
    PHOTOMETRIC_KEYS,
];
/// `[[light]]` with `kind = "spot"`.
pub(crate) const SPOT: KeyGroups = &[
    &[key("kind", "\"spot\"", "", "required", "light without extent that fills a cone")],
    PLACED_LIGHT_KEYS,
    &[
        key("direction", "direction", "", "required", "axis of the cone, the way along which light travels"),
        key(
            "inner_angle",
            "number from 0 to outer_angle",
            "degrees",
            "0",
            "angle between the axis and the directions up to which the intensity is full",
        ),
        key(
            "outer_angle",
            "number in [0.1, 180]",
            "degrees",
            "required",
            "angle between the axis and the edge of the cone, where the intensity has fallen to 0",
        ),
    ],
    INTENSITY_KEYS,
    PHOTOMETRIC_KEYS,
];
/// `[[light]]` with `kind = "tube"`.
pub(crate) const TUBE: KeyGroups = &[
    &[
        key("kind", "\"tube\"", "", "required", "cylinder that emits diffusely (light mode)"),
        key("name", "text", "", "light1, …", "name of the light group and of its surface"),
        key("start", "point", "m", "required", "one end of the axis"),
        key("end", "point", "m", "required", "the other end of the axis"),
        key("radius", "number above 0", "m", "required", "radius"),
        key("power", "bands from 0", "W", "required without luminous_flux", "radiant power"),
        key("luminous_flux", "number from 0", "lm", "", "luminous flux, in place of the power"),
        key("reflectance", "bands in [0, 1]", "", "0.5", "diffuse reflectance of the tube"),
    ],
    PHOTOMETRIC_KEYS,
];
/// `[[light]]` with `kind = "luminaire"`.
pub(crate) const LUMINAIRE: KeyGroups = &[
    &[key(
        "kind",
        "\"luminaire\"",
        "",
        "required",
        "light without extent with the intensities of a photometric file",
    )],
    PLACED_LIGHT_KEYS,
    &[
        key("file", "file name", "", "required", "photometric file, .ies (IES LM-63) or .ldt (EULUMDAT)"),
        key("direction", "direction", "", "[0, 0, -1]", "direction of the angle 0 of the file"),
        key(
            "rotation",
            "number",
            "degrees",
            "0",
            "angle about the direction that turns the plane C = 0 towards C = 90",
        ),
        key("dimming", "number from 0", "", "1", "factor of the intensities"),
    ],
    PHOTOMETRIC_KEYS,
];
/// `[[light]]` with `kind = "emitter"`.
pub(crate) const EMITTER: KeyGroups = &[&[
    key("kind", "\"emitter\"", "", "required", "surface whose emission is direct light"),
    key("name", "text", "", "the surface's", "name of the light group"),
    key("surface", "text", "", "required", "name of an emitting surface"),
]];
/// `[[light]]` with `kind = "planet"`.
pub(crate) const PLANET: KeyGroups = &[&[
    key(
        "kind",
        "\"planet\"",
        "",
        "required",
        "distant disc that emits and reflects uniformly (thermal mode)",
    ),
    key("name", "text", "", "light1, …", "name of the light group"),
    key("direction", "direction", "", "required", "direction in which its radiation travels"),
    key("angular_diameter", "number in (0, 180)", "degrees", "required", "angular diameter"),
    key("temperature", "number above 0", "K", "", "black-body temperature of its infrared radiation"),
    key(
        "infrared_flux",
        "number from 0",
        "W/m2",
        "0",
        "infrared flux at its surface, in place of the temperature",
    ),
    key("reflected_flux", "number from 0", "W/m2", "0", "flux of reflected sunlight at its surface"),
]];
/// A spectrum in the place of bands.
pub(crate) const SPECTRUM: KeyGroups = &[&[
    key("spectrum", "file name", "", "", ".csv with wavelengths in nm and values"),
    key("column", "text | integer from 1", "", "2", "column of the values"),
    key("illuminant", "\"D65\"", "", "", "standard illuminant, in place of a file"),
    key("black_body", "number above 0", "K", "", "light of a black body, in place of a file"),
    key("scale", "number from 0", "", "1", "factor of the values"),
    key("total", "number from 0", "that of the quantity", "", "sum of a flux over the bands of the scene"),
]];
/// `[surroundings]`.
pub(crate) const SURROUNDINGS: KeyGroups = &[&[
    key("name", "text", "", "\"surroundings\"", "name of the light group"),
    key("radiance", "bands", "W/(m2 sr)", "0", "radiance that enters from all directions (light mode)"),
    key(
        "temperature",
        "number above 0",
        "K",
        "cold",
        "black-body temperature of the surroundings (thermal mode)",
    ),
]];
