//! Unit and upward axis of a model.
//!
//! glTF is in metres with y up. Other formats say neither, so both are guessed. *Unit*: a model of 0.3 to 300 m across is in metres; a larger one is in centimetres
//! if that makes it 1 to 100 m across, else in millimetres. *Axis*: floors and ceilings give the vertical the largest area seen along an axis, Σ A |n_k|. Where y and
//! z differ little, OBJ files have y up and all others z.

use std::path::Path;
use zonal_io::input::ModelSurvey;
use zonal_math::{Vec3, vec3};
use zonal_scene::Camera;

/// The upward axis of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum UpAxis {
    /// The first axis.
    X,
    /// The second axis.
    Y,
    /// The third axis.
    Z,
}

impl UpAxis {
    /// Rotations about x, y and z that turn the axis to z, degrees.
    pub(super) fn rotation_degrees(self) -> [i32; 3] {
        match self {
            UpAxis::X => [0, -90, 0],
            UpAxis::Y => [90, 0, 0],
            UpAxis::Z => [0, 0, 0],
        }
    }
    /// The name.
    pub fn name(self) -> &'static str {
        ["x", "y", "z"][self as usize]
    }
    /// A vector of the file in the axes of the scene.
    fn turned(self, v: Vec3) -> Vec3 {
        match self {
            UpAxis::X => vec3(-v.z, v.y, v.x),
            UpAxis::Y => vec3(v.x, -v.z, v.y),
            UpAxis::Z => v,
        }
    }
}

/// Units by name, metres each.
const UNITS: [(&str, f64); 6] =
    [("m", 1.0), ("cm", 0.01), ("mm", 0.001), ("km", 1000.0), ("inch", 0.0254), ("foot", 0.3048)];

/// A unit of lengths: a name, or metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LengthUnit {
    /// Metres.
    pub metres: f64,
}

impl LengthUnit {
    const METRE: LengthUnit = LengthUnit { metres: 1.0 };

    /// The unit of a name or of a number of metres.
    ///
    /// # Errors
    /// For other words and numbers.
    pub fn parse(text: &str) -> Result<LengthUnit, String> {
        let named = UNITS.iter().find(|u| u.0 == text).map(|u| u.1);
        let number = || text.parse::<f64>().ok().filter(|x| *x > 0.0 && x.is_finite());
        let metres = named.or_else(number).ok_or_else(|| {
            let names: Vec<&str> = UNITS.iter().map(|u| u.0).collect();
            format!("give {}, or a number of metres above 0", names.join(", "))
        })?;
        Ok(LengthUnit { metres })
    }
    /// The name, or the number of metres.
    pub fn name(self) -> String {
        let named = UNITS.iter().find(|u| u.1 == self.metres);
        named.map_or_else(|| format!("{} m", self.metres), |u| u.0.to_string())
    }
}

/// Largest extent of a model in metres, m.
const LARGEST_METRIC_EXTENT: f64 = 300.0;
/// Largest extent of a model in centimetres, m.
const LARGEST_CENTIMETRE_EXTENT: f64 = 100.0;
/// Area along the vertical over that along the other axis above which the areas decide.
const MIN_AREA_RATIO: f64 = 1.15;

/// How a file lies in the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelPlacement {
    /// Unit of the file.
    pub unit: LengthUnit,
    /// Why this unit.
    pub unit_reason: &'static str,
    /// Upward axis of the file.
    pub up: UpAxis,
    /// Why this axis.
    pub up_reason: &'static str,
}

/// Reason of a value of the command line.
const GIVEN: &str = "as given";

impl ModelPlacement {
    /// The placement of a model, with what is given in place of guesses.
    pub fn of(
        path: &Path,
        survey: &ModelSurvey,
        unit: Option<LengthUnit>,
        up: Option<UpAxis>,
    ) -> ModelPlacement {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        let is_gltf = matches!(extension.as_str(), "glb" | "gltf");
        let (low, high) = survey.bounds;
        let guessed_unit = if is_gltf {
            (LengthUnit::METRE, "glTF is in metres")
        } else {
            guess_unit((high - low).max_abs())
        };
        let guessed_up =
            if is_gltf { (UpAxis::Y, "glTF has y up") } else { guess_up(survey.axis_areas, &extension) };
        let (unit, unit_reason) = unit.map_or(guessed_unit, |u| (u, GIVEN));
        let (up, up_reason) = up.map_or(guessed_up, |u| (u, GIVEN));
        ModelPlacement { unit, unit_reason, up, up_reason }
    }

    /// A camera of the file in the scene.
    pub(super) fn camera(&self, c: &Camera) -> Camera {
        let point = |p: Vec3| self.up.turned(p) * self.unit.metres;
        let origin = point(c.origin);
        let target = origin + self.up.turned(c.target - c.origin);
        Camera { origin, target, up: self.up.turned(c.up), ..c.clone() }
    }
}

fn guess_unit(extent: f64) -> (LengthUnit, &'static str) {
    if extent <= LARGEST_METRIC_EXTENT {
        return (LengthUnit::METRE, "guessed by the extent");
    }
    let metres = if extent <= 100.0 * LARGEST_CENTIMETRE_EXTENT { 0.01 } else { 0.001 };
    (LengthUnit { metres }, "guessed by the extent")
}

fn guess_up([_, y, z]: [f64; 3], extension: &str) -> (UpAxis, &'static str) {
    if y > MIN_AREA_RATIO * z {
        return (UpAxis::Y, "guessed by the area of floors and ceilings");
    }
    if z > MIN_AREA_RATIO * y {
        return (UpAxis::Z, "guessed by the area of floors and ceilings");
    }
    match extension {
        "obj" => (UpAxis::Y, "usual in OBJ files"),
        _ => (UpAxis::Z, "usual in such files"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_and_axes_are_guessed() {
        let of = |file: &str, extent: f64, areas: [f64; 3]| {
            let survey = ModelSurvey {
                bounds: (Vec3::ZERO, Vec3::splat(extent)),
                axis_areas: areas,
                ..ModelSurvey::default()
            };
            let p = ModelPlacement::of(Path::new(file), &survey, None, None);
            (p.unit.name(), p.up)
        };
        assert_eq!(of("a.glb", 4000.0, [1.0, 1.0, 9.0]), ("m".into(), UpAxis::Y));
        assert_eq!(of("a.obj", 5.0, [1.0, 1.0, 1.0]), ("m".into(), UpAxis::Y));
        assert_eq!(of("a.stl", 5.0, [1.0, 1.0, 1.0]), ("m".into(), UpAxis::Z));
        assert_eq!(of("a.stl", 559.0, [1.0, 2.0, 1.0]), ("cm".into(), UpAxis::Y));
        assert_eq!(of("a.obj", 12_000.0, [1.0, 1.0, 2.0]), ("mm".into(), UpAxis::Z));
    }

    #[test]
    fn cameras_turn_as_the_rotation_of_the_mesh() {
        for up in [UpAxis::X, UpAxis::Y, UpAxis::Z] {
            let [rx, ry, rz] = up.rotation_degrees().map(|d| f64::from(d).to_radians());
            let axis = Vec3::from_array(std::array::from_fn(|k| f64::from(u8::from(k == up as usize))));
            for v in [axis, vec3(0.3, -0.7, 0.2)] {
                let a = vec3(v.x, rx.cos() * v.y - rx.sin() * v.z, rx.sin() * v.y + rx.cos() * v.z);
                let b = vec3(ry.cos() * a.x + ry.sin() * a.z, a.y, ry.cos() * a.z - ry.sin() * a.x);
                assert!((up.turned(v) - b).length() < 1e-12 && rz == 0.0);
            }
            assert!((up.turned(axis) - vec3(0.0, 0.0, 1.0)).length() < 1e-12);
        }
    }

    #[test]
    fn units_are_read() {
        assert_eq!(LengthUnit::parse("inch").map(|u| u.metres), Ok(0.0254));
        assert_eq!(LengthUnit::parse("0.05").map(|u| u.name()), Ok("0.05 m".into()));
        assert!(LengthUnit::parse("-1").is_err() && LengthUnit::parse("mile").is_err());
    }
}
