//! `[[light]]` from infinitely far away and from all sides: uniform skies, the CIE standard general sky, the Perez all-weather sky, and pictures.

use super::sun_place::SunPlace;
use crate::input::light_files::sky_picture::read_sky_picture;
use crate::input::reading::error::InputError;
use crate::input::scene::quantities::light_quantities::{in_solar_band, read_quantity, with_tint};
use crate::input::toml::node::TomlTable;
use crate::input::toml::sky_keys::{CIE_SKY, GROUND, IMAGE_SKY, PEREZ_SKY, PLACE};
use std::f64::consts::PI;
use std::rc::Rc;
use zonal_scene::{Bands, Light, SkyDistribution, SkyIrradiance, SkyPlacement, Texture};

/// Irradiance of a plane normal to the sun outside of the atmosphere at the mean distance of the earth, W/m² (World Meteorological Organization).
const SOLAR_CONSTANT: f64 = 1367.0;
/// Types of the CIE sky that do not depend on the sun.
const TYPES_WITHOUT_SUN: [usize; 3] = [1, 3, 5];

/// A sky of one radiance.
pub(crate) fn read_uniform_sky(t: &TomlTable<'_>, name: String) -> Result<Light, InputError> {
    let example = "radiance = 100 (W/(m2 sr), number or [r, g, b]), or luminance in cd/m2";
    let (_, radiance) = read_quantity(t, &[["radiance", "luminance"]], example)?;
    Ok(Light::Sky { name, radiance, distribution: SkyDistribution::uniform() })
}

/// The CIE standard general sky.
pub(crate) fn read_cie_sky(t: &TomlTable<'_>, name: String) -> Result<Light, InputError> {
    let kind = t.require(&CIE_SKY.r#type)?;
    let number = match kind.count()? {
        k if k <= 15 => k,
        k => return Err(kind.error(format!("{k} is out of range; give a type from 1 to 15"))),
    };
    let up = t.or_default(&PLACE.up)?;
    let sun = if SunPlace::is_missing(t) && TYPES_WITHOUT_SUN.contains(&number) {
        SunPlace { towards: up, up, distance: 1.0 }
    } else {
        SunPlace::read(t)?
    };
    let placement = read_placement(t, &sun)?;
    let distribution = SkyDistribution::cie(number, placement).map_err(|e| t.error(e))?;
    let example = "horizontal_irradiance = 100 (W/m2), zenith_radiance (W/(m2 sr)), horizontal_illuminance (lx) or zenith_luminance (cd/m2)";
    let keys = [["horizontal_irradiance", "horizontal_illuminance"], ["zenith_radiance", "zenith_luminance"]];
    let radiance = match read_quantity(t, &keys, example)? {
        ("zenith_radiance", zenith) => zenith / distribution.zenith(),
        (_, horizontal) => horizontal / PI,
    };
    Ok(Light::Sky { name, radiance, distribution })
}

/// The Perez all-weather sky.
pub(crate) fn read_perez_sky(t: &TomlTable<'_>, name: String) -> Result<Light, InputError> {
    let direct = t.required(&PEREZ_SKY.direct_normal)?;
    let diffuse = t.required(&PEREZ_SKY.diffuse_horizontal)?;
    let sun = SunPlace::read(t)?;
    let irradiance = SkyIrradiance {
        direct_normal: direct,
        diffuse_horizontal: diffuse,
        extraterrestrial: SOLAR_CONSTANT / (sun.distance * sun.distance),
    };
    let placement = read_placement(t, &sun)?;
    let distribution = SkyDistribution::perez(irradiance, placement).map_err(|e| t.error(e))?;
    Ok(Light::Sky { name, radiance: with_tint(t, diffuse)? / PI, distribution })
}

fn read_placement(t: &TomlTable<'_>, sun: &SunPlace) -> Result<SkyPlacement, InputError> {
    let ground_reflectance = t.or_default(&GROUND.ground_reflectance)?;
    Ok(SkyPlacement { sun: sun.towards, up: sun.up, ground_reflectance })
}

/// A sky from an equirectangular picture.
pub(crate) fn read_image_sky(t: &TomlTable<'_>, name: String) -> Result<Light, InputError> {
    let node = t.require(&IMAGE_SKY.image)?;
    let (path, files) = node.named_file()?;
    let picture = node.once(|| read_sky_picture(files, &path).map_err(|f| node.error(f.to_string())))?;
    let mut picture = Rc::unwrap_or_clone(picture);
    if !t.source.bands().is_rgb() {
        to_grey(&mut picture);
    }
    let up = t.or_default(&PLACE.up)?;
    let rotation = t.or_default(&IMAGE_SKY.rotation)?.to_radians();
    let distribution = SkyDistribution::picture(picture, up, rotation).map_err(|e| node.error(e))?;
    let keys = [["radiance", "luminance"]];
    let is_scaled = ["radiance", "luminance", "tint", "efficacy"].iter().any(|k| t.get(k).is_some());
    let radiance = if is_scaled {
        read_quantity(t, &keys, "radiance = 1 (W/(m2 sr) of the pixel value 1)")?.1
    } else {
        in_solar_band(t, 1.0).unwrap_or(Bands::ONE)
    };
    Ok(Light::Sky { name, radiance, distribution })
}

/// The mean of the channels in all three: bands that are not red, green and blue have one picture.
fn to_grey(picture: &mut Texture) {
    picture.pixels.iter_mut().for_each(|p| *p = [p.iter().sum::<f32>() / 3.0; 3]);
}
