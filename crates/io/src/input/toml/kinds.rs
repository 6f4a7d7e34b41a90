//! The kinds of values that keys have: description, unit and reader.

use super::key_specs::ValueType;
use super::keys::Kind;
use super::node::TomlNode;
use crate::input::reading::error::InputError;
use std::ops::RangeInclusive;
use zonal_math::Vec3;
use zonal_scene::limits::{MAX_NET_POWER, MAX_TEMPERATURE};
use zonal_scene::thermal::power_out_of_range;

/// A value of several forms, which its reader tells apart.
pub(crate) const fn shown(value: &'static str, unit: &'static str) -> Kind<()> {
    Kind { value: ValueType::Described(value), unit, read: |_| Ok(()) }
}

/// One of some words, by its index.
macro_rules! words {
    ($($word:literal),*) => {
        $crate::input::toml::keys::Kind {
            value: $crate::input::toml::key_specs::ValueType::OneOf(&[$($word),*]),
            unit: "",
            read: |n| n.choice(&[$($word),*]),
        }
    };
}
pub(crate) use words;

/// One of the names of an enumeration.
macro_rules! one_of {
    ($type:ident) => {
        $crate::input::toml::keys::Kind {
            value: $crate::input::toml::key_specs::ValueType::OneOf(&$type::NAMES),
            unit: "",
            read: |n| Ok($type::VARIANTS[n.choice(&$type::NAMES)?]),
        }
    };
}
pub(crate) use one_of;

pub(crate) const TABLE: Kind<()> = shown("table", "");
pub(crate) const TABLES: Kind<()> = shown("list of tables", "");
pub(crate) const FILE: Kind<()> = shown("file name", "");
pub(crate) const TEXT: Kind<String> = Kind::new("text", |n| n.text().map(str::to_string));
pub(crate) const BOOLEAN: Kind<bool> = Kind::new("boolean", |n| n.boolean());
pub(crate) const COUNT: Kind<usize> = Kind::new("integer from 1", |n| n.count());
/// A column of a table by its name or its number.
pub(crate) const COLUMN: Kind<String> = Kind::new("text | integer from 1", |n| {
    if n.is_text() { n.text().map(String::from) } else { n.count().map(|k| k.to_string()) }
});

pub(crate) const NUMBER: Kind<f64> = Kind::new("number", |n| n.number());
pub(crate) const DEGREES: Kind<f64> = NUMBER.in_unit("degrees");
pub(crate) const POSITIVE: Kind<f64> = Kind::new("number above 0", |n| n.positive());
pub(crate) const LENGTH: Kind<f64> = POSITIVE.in_unit("m");
pub(crate) const NON_NEGATIVE: Kind<f64> = Kind::new("number from 0", |n| n.non_negative());
pub(crate) const UP_TO_ONE: Kind<f64> = Kind::new("number in [0, 1]", |n| n.number_up_to(1.0));
pub(crate) const FRACTION: Kind<f64> =
    Kind::new("number in (0, 1)", |n| limited(n, |x| x > 0.0 && x < 1.0, "a number above 0 and below 1"));
/// A temperature.
pub(crate) const KELVIN: Kind<f64> = Kind::new("number above 0", |n| match n.number()? {
    t if t > 0.0 && t <= MAX_TEMPERATURE => Ok(t),
    t => Err(n.error(format!("{t} K is out of range; give kelvin above 0 (0 °C is 273.15)"))),
})
.in_unit("K");
/// A net power in W, W/m² or W/m³.
pub(crate) const NET_POWER: Kind<f64> = Kind::new("number", |n| match n.number()? {
    q if q.abs() <= MAX_NET_POWER => Ok(q),
    q => Err(n.error(power_out_of_range(q))),
});
pub(crate) const NUMBERS: Kind<Vec<f64>> =
    Kind::new("list of numbers", |n| n.list()?.iter().map(TomlNode::number).collect());

pub(crate) const POINT: Kind<Vec3> = Kind::new("point", |n| n.vector()).in_unit("m");
pub(crate) const VECTOR: Kind<Vec3> = Kind::new("direction", |n| n.vector());
pub(crate) const EDGE: Kind<Vec3> = VECTOR.in_unit("m");
/// A unit vector.
pub(crate) const DIRECTION: Kind<Vec3> = Kind::new("direction", |n| n.unit_vector());
pub(crate) const ROTATIONS: Kind<Vec3> =
    Kind::new("[number, number, number]", |n| n.vector()).in_unit("degrees");
pub(crate) const POINTS: Kind<Vec<Vec3>> =
    Kind::new("list of points", |n| n.list()?.iter().map(TomlNode::vector).collect()).in_unit("m");

/// A number that a condition admits; `wanted` completes "give …".
pub(crate) fn limited(n: &TomlNode<'_>, admits: fn(f64) -> bool, wanted: &str) -> Result<f64, InputError> {
    match n.number()? {
        x if admits(x) => Ok(x),
        x => Err(n.error(format!("{x} is out of range; give {wanted}"))),
    }
}

/// A number within limits, in degrees; `more` follows the limits in the message.
pub(crate) fn degrees_within(
    n: &TomlNode<'_>,
    limits: RangeInclusive<f64>,
    more: &str,
) -> Result<f64, InputError> {
    let x = n.number()?;
    let (low, high) = (limits.start(), limits.end());
    let refused = || n.error(format!("{x} is out of range; give degrees from {low} to {high}{more}"));
    limits.contains(&x).then_some(x).ok_or_else(refused)
}
