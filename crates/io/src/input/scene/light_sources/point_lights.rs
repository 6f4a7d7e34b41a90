//! `[[light]]` without extent: points, spots and luminaires.
//!
//! A light of power Φ has the unit intensity I₀ = Φ/∫f dω, with f its relative intensity. That of a luminaire is its largest luminous intensity times the dimming factor
//! and the tilt factor of the file at its aim, over the luminous efficacy.

use crate::input::light_files::photometry::read_luminaire;
use crate::input::reading::error::InputError;
use crate::input::scene::quantities::light_quantities::{
    in_bands, read_direction, read_quantity, unit_vector,
};
use crate::input::toml::node::{TomlNode, TomlTable};
use std::rc::Rc;
use zonal_math::vec3;
use zonal_scene::{Bands, IntensityDistribution, Light};

/// Range of the half-angles of a spot, degrees.
const MIN_OUTER_ANGLE: f64 = 0.1;
const MAX_OUTER_ANGLE: f64 = 180.0;

/// An isotropic light.
pub(crate) fn read_point(t: &TomlTable<'_>, name: String) -> Result<Light, InputError> {
    let distribution = IntensityDistribution::isotropic();
    let intensity = read_unit_intensity(t, &distribution)?;
    let position = t.require("position", "position = [x, y, z] (m)")?.vector()?;
    Ok(Light::Point { name, position, intensity, distribution })
}

/// A cone of light.
pub(crate) fn read_spot(t: &TomlTable<'_>, name: String) -> Result<Light, InputError> {
    let outer =
        t.require("outer_angle", "outer_angle = 40 (degrees between the axis and the edge of the cone)")?;
    let outer_angle = match outer.number()? {
        x if (MIN_OUTER_ANGLE..=MAX_OUTER_ANGLE).contains(&x) => x,
        x => {
            return Err(outer.error(format!(
                "{x} is out of range; give degrees from {MIN_OUTER_ANGLE} to {MAX_OUTER_ANGLE} between axis and edge"
            )));
        }
    };
    let inner = |n: TomlNode<'_>| match n.number()? {
        x if (0.0..=outer_angle).contains(&x) => Ok(x),
        x => Err(
            n.error(format!("{x} is out of range; give degrees from 0 up to the outer angle, {outer_angle}"))
        ),
    };
    let inner_angle = t.read("inner_angle", inner)?.unwrap_or(0.0);
    let half_angles = [inner_angle, outer_angle].map(f64::to_radians);
    let distribution = IntensityDistribution::spot(read_direction(t)?, half_angles);
    let intensity = read_unit_intensity(t, &distribution)?;
    let position = t.require("position", "position = [x, y, z] (m)")?.vector()?;
    Ok(Light::Point { name, position, intensity, distribution })
}

/// A light with the intensities of a photometric file.
pub(crate) fn read_luminaire_light(t: &TomlTable<'_>, name: String) -> Result<Light, InputError> {
    let node = t.require("file", "file = \"lamp.ies\" or \"lamp.ldt\"")?;
    let Some((folder, files)) = t.source.files() else {
        return Err(
            node.error("this scene is a text without a folder and cannot refer to files; save it as a file")
        );
    };
    let path = folder.join(node.text()?);
    let luminaire = node.once(|| read_luminaire(files, &path).map_err(|f| node.error(f.to_string())))?;
    let luminaire = Rc::unwrap_or_clone(luminaire);
    let dimming = t.read("dimming", |n| n.non_negative())?.unwrap_or(1.0);
    let aim = t.read("direction", unit_vector)?.unwrap_or(vec3(0.0, 0.0, -1.0));
    let off_straight_down = (-aim.z).clamp(-1.0, 1.0).acos().to_degrees();
    let tilt = luminaire.tilt.map_or(Ok(1.0), |t| t.at(off_straight_down)).map_err(|e| node.error(e))?;
    if tilt == 0.0 {
        return Err(node.error("the tilt factor of the file at this direction is 0; the luminaire is dark"));
    }
    let intensity = in_bands(t, luminaire.peak * dimming * tilt)?;
    let rotation = t.read("rotation", |n| n.number())?.unwrap_or(0.0).to_radians();
    let distribution = IntensityDistribution::table(luminaire.table, aim, rotation);
    let position = t.require("position", "position = [x, y, z] (m)")?.vector()?;
    Ok(Light::Point { name, position, intensity, distribution })
}

/// The unit intensity, W/sr, from an intensity or a power.
fn read_unit_intensity(t: &TomlTable<'_>, distribution: &IntensityDistribution) -> Result<Bands, InputError> {
    let keys = [["intensity", "luminous_intensity"], ["power", "luminous_flux"]];
    let example = "intensity = 10 (W/sr, number or [r, g, b]), power in W, luminous_intensity in cd or luminous_flux in lm";
    Ok(match read_quantity(t, &keys, example)? {
        ("power", flux) => flux / distribution.solid_angle_integral(),
        (_, intensity) => intensity,
    })
}
