//! The direction of the sun: as a vector, or by place and time.

use crate::input::reading::error::InputError;
use crate::input::toml::light_keys::SUN;
use crate::input::toml::node::{TomlNode, TomlTable};
use crate::input::toml::sky_keys::PLACE;
use toml_datetime::Offset;
use zonal_math::Vec3;
use zonal_scene::{SunPosition, UniversalTime};

/// Years for which the position of the sun is known to 0.01°.
const YEARS: std::ops::RangeInclusive<u16> = 1900..=2100;
/// Largest cosine of the angle between up and north, beyond which no horizon is left.
const MAX_ALIGNMENT: f64 = 1.0 - 1e-9;
/// The keys of place and time.
const PLACE_KEYS: [&str; 4] =
    [PLACE.latitude.spec.name, PLACE.longitude.spec.name, PLACE.time.spec.name, PLACE.north.spec.name];

/// The sun of a light.
pub(crate) struct SunPlace {
    /// Unit vector towards the sun.
    pub(crate) towards: Vec3,
    /// Unit vector towards the zenith.
    pub(crate) up: Vec3,
    /// Distance of the sun, astronomical units; 1 without a time.
    pub(crate) distance: f64,
}

impl SunPlace {
    /// The sun of a light whose direction or place and time must be given, as must a sun above the horizon in the latter case.
    pub(crate) fn read(t: &TomlTable<'_>) -> Result<SunPlace, InputError> {
        let up = t.or_default(&PLACE.up)?;
        let place = PLACE_KEYS.iter().find_map(|k| t.get(k));
        match (t.get(&SUN.direction), place) {
            (Some(_), Some(n)) => {
                Err(n.error("the direction and a place are both given; keep the direction, or latitude, longitude and time"))
            }
            (None, Some(_)) => SunPlace::of_place(t, up),
            _ => Ok(SunPlace { towards: -t.required(&SUN.direction)?, up, distance: 1.0 }),
        }
    }

    /// True if neither a direction nor a place is given.
    pub(crate) fn is_missing(t: &TomlTable<'_>) -> bool {
        t.get(&SUN.direction).is_none() && PLACE_KEYS.iter().all(|k| t.get(k).is_none())
    }

    fn of_place(t: &TomlTable<'_>, up: Vec3) -> Result<SunPlace, InputError> {
        let (latitude, longitude) = (t.required(&PLACE.latitude)?, t.required(&PLACE.longitude)?);
        let moment = t.require(&PLACE.time)?;
        let time = universal_time(&moment)?;
        let north = t.or_default(&PLACE.north)?;
        if north.dot(up).abs() > MAX_ALIGNMENT {
            return Err(t.error("north lies along up; give north a horizontal direction, such as [0, 1, 0]"));
        }
        let north = (north - up * north.dot(up)).normalized();
        let sun = SunPosition::new(latitude, longitude, time);
        if sun.direction.z <= 0.0 {
            return Err(moment.error(format!(
                "the sun stands {:.2} degrees below the horizon at this time; give another one",
                -sun.direction.z.asin().to_degrees()
            )));
        }
        let east = north.cross(up);
        let towards = east * sun.direction.x + north * sun.direction.y + up * sun.direction.z;
        Ok(SunPlace { towards: towards.normalized(), up, distance: sun.distance })
    }
}

/// A moment with its offset in universal time.
fn universal_time(n: &TomlNode<'_>) -> Result<UniversalTime, InputError> {
    let moment = n.date_time()?;
    let (Some(date), Some(time), Some(offset)) = (moment.date, moment.time, moment.offset) else {
        return Err(n.error(
            "a date, a time and the offset from universal time are needed; write them like \"2026-06-21T12:00:00+02:00\", or Z for universal time",
        ));
    };
    if !YEARS.contains(&date.year) {
        return Err(n.error(format!("the year {} is out of range; give 1900 to 2100", date.year)));
    }
    let minutes = match offset {
        Offset::Z => 0,
        Offset::Custom { minutes } => minutes,
    };
    let seconds = f64::from(time.second.unwrap_or(0)) + f64::from(time.nanosecond.unwrap_or(0)) * 1e-9;
    Ok(UniversalTime {
        year: i32::from(date.year),
        month: u32::from(date.month),
        day: u32::from(date.day),
        hours: f64::from(time.hour) + f64::from(time.minute) / 60.0 + seconds / 3600.0
            - f64::from(minutes) / 60.0,
    })
}
