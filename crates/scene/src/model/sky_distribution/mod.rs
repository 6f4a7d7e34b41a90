//! Distribution of the radiance of a sky over directions.
//!
//! The radiance from the unit direction ω is L(ω) = L₀ f(ω), with L₀ the unit radiance of the light, W/(m² sr), and f the relative radiance, band by band:
//!
//! | distribution | f |
//! |---|---|
//! | uniform | 1 in all directions, also from below |
//! | CIE standard general sky, Perez all-weather sky | formula above the horizon, the ground below (`sky_model`) |
//! | picture | that of the pixels (`sky_image`) |
//!
//! Directions are drawn with a density p close to f (`direction_table`): f/p is bounded wherever f is above 0.

mod direction_table;
mod sky_frame;
mod sky_image;
mod sky_model;

pub use sky_model::{SkyIrradiance, SkyPlacement};

use crate::{Bands, Texture};
use sky_frame::SkyFrame;
use sky_image::SkyImage;
use sky_model::SkyModel;
use std::f64::consts::PI;
use std::sync::Arc;
use zonal_math::Vec3;
use zonal_math::direction_sampling::uniform_sphere;

/// Relative radiance of a sky over directions, without unit.
///
/// ```
/// use zonal_math::vec3;
/// use zonal_scene::{SkyDistribution, SkyPlacement};
/// let up = vec3(0.0, 0.0, 1.0);
/// let at = SkyPlacement { sun: vec3(1.0, 0.0, 1.0), up, ground_reflectance: 0.2 };
/// let overcast = SkyDistribution::cie(1, at).unwrap();
/// let horizon = overcast.relative(vec3(1.0, 0.0, 1e-9)).first();
/// // The zenith of the overcast sky is about three times as bright as its horizon; the ground has its reflectance.
/// assert!((overcast.relative(up).first() / horizon - 2.986).abs() < 1e-3);
/// assert_eq!(overcast.relative(-up).first(), 0.2);
/// ```
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(try_from = "Vec<f64>", into = "Vec<f64>")]
pub struct SkyDistribution {
    form: SkyForm,
}

#[derive(Clone, Debug, PartialEq)]
enum SkyForm {
    Uniform,
    Model(Arc<SkyModel>),
    Image(Arc<SkyImage>),
    /// A picture that is still to be read.
    Frame(SkyFrame),
}

impl TryFrom<Vec<f64>> for SkyDistribution {
    type Error = &'static str;
    fn try_from(numbers: Vec<f64>) -> Result<SkyDistribution, &'static str> {
        SkyDistribution::from_numbers(&numbers).ok_or("the distribution of radiance is none")
    }
}

impl From<SkyDistribution> for Vec<f64> {
    fn from(d: SkyDistribution) -> Vec<f64> {
        d.numbers()
    }
}

impl SkyDistribution {
    /// The same radiance from all directions.
    #[must_use]
    pub fn uniform() -> SkyDistribution {
        SkyDistribution { form: SkyForm::Uniform }
    }

    /// The CIE standard general sky (ISO 15469:2004) of a type from 1, overcast, to 15, clear and turbid; f is normalized to ∫ f cos Z dω = π above the horizon.
    ///
    /// # Errors
    /// The type does not exist, the sun is below the horizon, or the reflectance of the ground is out of range.
    pub fn cie(kind: usize, placement: SkyPlacement) -> Result<SkyDistribution, String> {
        let model = SkyModel::cie(kind, placement)?;
        Ok(SkyDistribution { form: SkyForm::Model(Arc::new(model)) })
    }

    /// The Perez all-weather sky, normalized likewise.
    ///
    /// # Errors
    /// An irradiance is out of range, the sun is below the horizon, or the reflectance of the ground is out of range.
    ///
    /// ```
    /// use zonal_math::vec3;
    /// use zonal_scene::{SkyDistribution, SkyIrradiance, SkyPlacement};
    /// let at = SkyPlacement { sun: vec3(0.0, -1.0, 1.0), up: vec3(0.0, 0.0, 1.0), ground_reflectance: 0.0 };
    /// let clear = SkyIrradiance { direct_normal: 850.0, diffuse_horizontal: 90.0, extraterrestrial: 1361.0 };
    /// let sky = SkyDistribution::perez(clear, at).unwrap();
    /// assert!(sky.relative(at.sun.normalized()).first() > 10.0 * sky.relative(vec3(0.0, 0.6, 0.8)).first());
    /// ```
    pub fn perez(irradiance: SkyIrradiance, placement: SkyPlacement) -> Result<SkyDistribution, String> {
        let model = SkyModel::perez(irradiance, placement)?;
        Ok(SkyDistribution { form: SkyForm::Model(Arc::new(model)) })
    }

    /// An equirectangular picture, row 0 towards `up` (any length). Its middle column looks along x, under the smallest rotation that takes z to `up`, turned by
    /// `rotation` radians about `up`, counterclockwise as seen from above.
    ///
    /// # Errors
    /// The picture is not twice as wide as high, too large or black, or a value is negative or not finite.
    pub fn picture(picture: Texture, up: Vec3, rotation: f64) -> Result<SkyDistribution, String> {
        let frame = SkyFrame::new(up.normalized(), rotation);
        if !frame.is_valid() {
            return Err("the vector up needs a length, the rotation must be a finite angle".into());
        }
        let image = SkyImage::new(picture, frame)?;
        Ok(SkyDistribution { form: SkyForm::Image(Arc::new(image)) })
    }

    /// True if f is 1 in all directions.
    #[must_use]
    pub fn is_uniform(&self) -> bool {
        self.form == SkyForm::Uniform
    }

    /// True if the bands of f are equal.
    #[must_use]
    pub fn is_grey(&self) -> bool {
        match &self.form {
            SkyForm::Image(image) => image.picture().pixels.iter().all(|p| p[0] == p[1] && p[0] == p[2]),
            _ => true,
        }
    }

    /// Relative radiance f from the unit direction `direction` towards the sky.
    #[must_use]
    pub fn relative(&self, direction: Vec3) -> Bands {
        match &self.form {
            SkyForm::Uniform => Bands::ONE,
            SkyForm::Model(model) => Bands::splat(model.relative(direction)),
            SkyForm::Image(image) => image.relative(direction),
            SkyForm::Frame(_) => Bands::ZERO,
        }
    }

    /// Relative radiance at the zenith of a model; 1 of other skies.
    #[must_use]
    pub fn zenith(&self) -> f64 {
        match &self.form {
            SkyForm::Model(model) => model.zenith(),
            _ => 1.0,
        }
    }

    /// ∫ f dω over all directions, sr.
    #[must_use]
    pub fn solid_angle_integral(&self) -> Bands {
        match &self.form {
            SkyForm::Uniform => Bands::splat(4.0 * PI),
            SkyForm::Model(model) => Bands::splat(model.solid_angle_integral()),
            SkyForm::Image(image) => image.solid_angle_integral(),
            SkyForm::Frame(_) => Bands::ZERO,
        }
    }

    /// The mean of f over all directions.
    #[must_use]
    pub fn mean(&self) -> Bands {
        self.solid_angle_integral() * (0.25 / PI)
    }

    /// An upper bound of f.
    #[must_use]
    pub fn upper_bound(&self) -> Bands {
        match &self.form {
            SkyForm::Uniform => Bands::ONE,
            SkyForm::Model(model) => Bands::splat(model.upper_bound()),
            SkyForm::Image(image) => image.upper_bound(),
            SkyForm::Frame(_) => Bands::ZERO,
        }
    }

    /// An upper bound of ∫ f cosθ⁺ dω, sr, with θ the angle to the unit vector `normal`; zero where no light comes from the front of the plane of `normal`.
    #[must_use]
    pub fn irradiance_bound(&self, normal: Vec3) -> Bands {
        match &self.form {
            SkyForm::Uniform => Bands::splat(PI),
            SkyForm::Model(model) => Bands::splat(model.irradiance_bound(normal)),
            SkyForm::Image(image) => Bands::splat(image.irradiance_bound(normal)),
            SkyForm::Frame(_) => Bands::ZERO,
        }
    }

    /// The unit direction at a point of the unit square, and its density p, 1/sr.
    #[must_use]
    pub fn sample_direction(&self, u: [f64; 2]) -> (Vec3, f64) {
        match &self.form {
            SkyForm::Uniform | SkyForm::Frame(_) => (uniform_sphere(u), 0.25 / PI),
            SkyForm::Model(model) => model.sample(u),
            SkyForm::Image(image) => image.sample(u),
        }
    }

    /// The density p with which [`SkyDistribution::sample_direction`] draws a unit direction, 1/sr.
    #[must_use]
    pub fn density(&self, direction: Vec3) -> f64 {
        match &self.form {
            SkyForm::Uniform | SkyForm::Frame(_) => 0.25 / PI,
            SkyForm::Model(model) => model.density(direction),
            SkyForm::Image(image) => image.density(direction),
        }
    }

    /// The pixels of a picture.
    #[must_use]
    pub fn pixels(&self) -> Option<&Texture> {
        match &self.form {
            SkyForm::Image(image) => Some(image.picture()),
            _ => None,
        }
    }

    /// True for a distribution of [`SkyDistribution::from_numbers`] whose picture is missing.
    #[must_use]
    pub fn lacks_pixels(&self) -> bool {
        matches!(self.form, SkyForm::Frame(_))
    }

    /// The same distribution with the pixels of its picture.
    ///
    /// # Errors
    /// As [`SkyDistribution::picture`].
    pub fn with_pixels(&self, picture: Texture) -> Result<SkyDistribution, String> {
        let SkyForm::Frame(frame) = &self.form else { return Ok(self.clone()) };
        let image = SkyImage::new(picture, *frame)?;
        Ok(SkyDistribution { form: SkyForm::Image(Arc::new(image)) })
    }

    /// The numbers that determine the distribution but for the pixels of a picture, those of different kinds never alike; none of a uniform sky.
    #[must_use]
    pub fn numbers(&self) -> Vec<f64> {
        match &self.form {
            SkyForm::Uniform => Vec::new(),
            SkyForm::Model(model) => [vec![1.0], model.numbers()].concat(),
            SkyForm::Image(image) => std::iter::once(2.0).chain(image.frame().numbers()).collect(),
            SkyForm::Frame(frame) => std::iter::once(2.0).chain(frame.numbers()).collect(),
        }
    }

    /// The distribution of [`SkyDistribution::numbers`], to the bit; `None` for other numbers. A picture lacks its pixels.
    ///
    /// ```
    /// use zonal_math::vec3;
    /// use zonal_scene::{SkyDistribution, SkyPlacement};
    /// let at = SkyPlacement { sun: vec3(0.3, 0.1, 1.0), up: vec3(0.0, 0.0, 1.0), ground_reflectance: 0.1 };
    /// let sky = SkyDistribution::cie(12, at).unwrap();
    /// assert_eq!(SkyDistribution::from_numbers(&sky.numbers()), Some(sky));
    /// assert_eq!(SkyDistribution::from_numbers(&[1.0, f64::NAN]), None);
    /// ```
    #[must_use]
    pub fn from_numbers(numbers: &[f64]) -> Option<SkyDistribution> {
        let form = match numbers.split_first() {
            None => SkyForm::Uniform,
            Some((1.0, rest)) => SkyForm::Model(Arc::new(SkyModel::from_numbers(rest)?)),
            Some((2.0, rest)) => SkyForm::Frame(SkyFrame::from_numbers(rest)?),
            Some(_) => return None,
        };
        Some(SkyDistribution { form })
    }
}

impl Default for SkyDistribution {
    fn default() -> SkyDistribution {
        SkyDistribution::uniform()
    }
}

#[cfg(test)]
mod tests;
