//! The keys of lights, surroundings and spectra.

use super::band_kinds::{FLUX, FLUX_OF_LIGHT, SHARE_OF_BANDS};
use super::keys::{Kind, keys};
use super::kinds::{
    DEGREES, DIRECTION, FILE, KELVIN, LENGTH, NON_NEGATIVE, POINT, TEXT, degrees_within, limited, shown,
};
use super::sky_keys::{Efficacy, Photometry, Place};
use zonal_math::Vec3;
use zonal_scene::Bands;

/// Angular diameter of the sun.
const DIAMETER_OF_SUN: Kind<f64> = Kind::new("number in [0, 180)", |n| {
    limited(n, |x| (0.0..180.0).contains(&x), "degrees from 0 up to 180 (the sun has 0.53)")
})
.in_unit("degrees");
/// Angular diameter of a planet.
const DIAMETER: Kind<f64> =
    Kind::new("number in (0, 180)", |n| limited(n, |x| x > 0.0 && x < 180.0, "degrees above 0, below 180"))
        .in_unit("degrees");
/// Half-angle of a spot.
const HALF_ANGLE: Kind<f64> =
    Kind::new("number in [0.1, 180]", |n| degrees_within(n, 0.1..=180.0, " between axis and edge"))
        .in_unit("degrees");
keys! {
    /// `[[light]]` with `kind = "sun"`.
    SUN: Sun = [Sun, Place, Efficacy, Photometry] {
        kind: () = shown("\"sun\"", ""), "required", "distant light";
        name: String = TEXT, "light1, …", "name of the light group";
        direction: Vec3 = DIRECTION, "required without a place", "direction in which the light travels",
            "[x, y, z], the way along which the light travels";
        irradiance: Bands = FLUX_OF_LIGHT.in_unit("W/m2"), "required without illuminance", "irradiance of a plane normal to the direction";
        illuminance: f64 = NON_NEGATIVE.in_unit("lx"), "", "illuminance of that plane, in place of the irradiance";
        angular_diameter: f64 = DIAMETER_OF_SUN, "0.53", "angular diameter";
    }
    /// Every light without extent.
    PLACED_LIGHT: PlacedLight = [PlacedLight] {
        name: String = TEXT, "light1, …", "name of the light group";
        position: Vec3 = POINT, "required", "position", "[x, y, z] (m)";
    }
    /// The strength of a point or a spot.
    INTENSITY: Intensity = [Intensity] {
        intensity: Bands = FLUX_OF_LIGHT.in_unit("W/sr"), "required without the next three", "radiant intensity, of a spot on its axis";
        power: Bands = FLUX_OF_LIGHT.in_unit("W"), "", "radiant power, in place of the intensity";
        luminous_intensity: f64 = NON_NEGATIVE.in_unit("cd"), "", "luminous intensity, of a spot on its axis";
        luminous_flux: f64 = NON_NEGATIVE.in_unit("lm"), "", "luminous flux";
    }
    /// `[[light]]` with `kind = "point"`.
    POINT_LIGHT: PointLight = [PointLight, PlacedLight, Intensity, Efficacy, Photometry] {
        kind: () = shown("\"point\"", ""), "required", "light without extent, the same in all directions";
    }
    /// `[[light]]` with `kind = "spot"`.
    SPOT: Spot = [Spot, PlacedLight, Cone, Intensity, Efficacy, Photometry] {
        kind: () = shown("\"spot\"", ""), "required", "light without extent that fills a cone";
    }
    /// The cone of a spot.
    CONE: Cone = [Cone] {
        direction: Vec3 = DIRECTION, "required", "axis of the cone, the way along which light travels";
        inner_angle: f64 = DEGREES.described("number from 0 to outer_angle"), "0",
            "angle between the axis and the directions up to which the intensity is full";
        outer_angle: f64 = HALF_ANGLE, "required", "angle between the axis and the edge of the cone, where the intensity has fallen to 0",
            "40 (degrees between the axis and the edge of the cone)";
    }
    /// `[[light]]` with `kind = "tube"`.
    TUBE: Tube = [Tube, Efficacy, Photometry] {
        kind: () = shown("\"tube\"", ""), "required", "cylinder that emits diffusely (light mode)";
        name: String = TEXT, "light1, …", "name of the light group and of its surface";
        start: Vec3 = POINT, "required", "one end of the axis", "[x, y, z] (m)";
        end: Vec3 = POINT, "required", "the other end of the axis", "[x, y, z] (m)";
        radius: f64 = LENGTH, "required", "radius", "0.013 (m)";
        power: Bands = FLUX.in_unit("W"), "required without luminous_flux", "radiant power";
        luminous_flux: f64 = NON_NEGATIVE.in_unit("lm"), "", "luminous flux, in place of the power";
        reflectance: Bands = SHARE_OF_BANDS, "0.5", "diffuse reflectance of the tube";
    }
    /// `[[light]]` with `kind = "luminaire"`.
    LUMINAIRE: Luminaire = [LuminaireKind, PlacedLight, Luminaire, Efficacy, Photometry] {
        file: () = FILE, "required", "photometric file, .ies (IES LM-63) or .ldt (EULUMDAT)", "\"lamp.ies\" or \"lamp.ldt\"";
        direction: Vec3 = DIRECTION, "[0, 0, -1]", "direction of the angle 0 of the file";
        rotation: f64 = DEGREES, "0", "angle about the direction that turns the plane C = 0 towards C = 90";
        dimming: f64 = NON_NEGATIVE, "1", "factor of the intensities";
    }
    /// The kind of a luminaire.
    LUMINAIRE_KIND: LuminaireKind = [LuminaireKind] {
        kind: () = shown("\"luminaire\"", ""), "required", "light without extent with the intensities of a photometric file";
    }
    /// `[[light]]` with `kind = "emitter"`.
    EMITTER: Emitter = [Emitter] {
        kind: () = shown("\"emitter\"", ""), "required", "surface whose emission is direct light";
        name: String = TEXT, "the surface's", "name of the light group";
        surface: () = shown("text", ""), "required", "name of an emitting surface", "\"the name of an emitting surface\"";
    }
    /// `[[light]]` with `kind = "planet"`.
    PLANET: Planet = [Planet] {
        kind: () = shown("\"planet\"", ""), "required", "distant disc that emits and reflects uniformly (thermal mode)";
        name: String = TEXT, "light1, …", "name of the light group";
        direction: Vec3 = DIRECTION, "required", "direction in which its radiation travels";
        angular_diameter: f64 = DIAMETER, "required", "angular diameter",
            "140 (degrees; 2 arcsin(R/(R + h)) at the height h above a planet of radius R)";
        temperature: f64 = KELVIN, "", "black-body temperature of its infrared radiation";
        infrared_flux: f64 = NON_NEGATIVE.in_unit("W/m2"), "0", "infrared flux at its surface, in place of the temperature";
        reflected_flux: Bands = FLUX_OF_LIGHT.in_unit("W/m2").described("number from 0"), "0", "flux of reflected sunlight at its surface";
    }
    /// `[surroundings]`.
    SURROUNDINGS: Surroundings = [Surroundings] {
        name: String = TEXT, "\"surroundings\"", "name of the light group";
        radiance: Bands = FLUX.in_unit("W/(m2 sr)").described("bands"), "0", "radiance that enters from all directions (light mode)";
        temperature: f64 = KELVIN, "cold", "black-body temperature of the surroundings (thermal mode)";
    }
}
