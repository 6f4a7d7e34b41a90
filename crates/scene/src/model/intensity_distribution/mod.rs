//! Distribution of the radiant intensity of a point light over directions.
//!
//! The radiant intensity in a unit direction ω is I(ω) = I₀ f(ω), with I₀ the unit intensity of the light, W/sr, and f the relative intensity:
//!
//! | distribution | f |
//! |---|---|
//! | isotropic | 1 |
//! | spot with axis a, half-angles α < β | clamp((cosθ − cosβ)/(cosα − cosβ))² with cosθ = ω·a (glTF, KHR_lights_punctual) |
//! | table | bilinear in the C-plane and in the angle γ from the aim ([`IntensityTable`]; CIE 121:1996, EN 13032-1) |
//!
//! The power of a light is I₀ ∫ f dω. Directions are drawn with the density f/∫ f dω, exactly, so that all rays of a light have one power.

mod intensity_table;
mod luminaire_frame;
mod spot_cone;

pub use intensity_table::{IntensityTable, PlaneSymmetry};

use luminaire_frame::LuminaireFrame;
use spot_cone::SpotCone;
use std::f64::consts::PI;
use std::sync::Arc;
use zonal_math::direction_sampling::uniform_sphere;
use zonal_math::{Vec3, vec3};

/// Relative radiant intensity over directions, without unit.
///
/// ```
/// use zonal_math::vec3;
/// use zonal_scene::IntensityDistribution;
/// let down = vec3(0.0, 0.0, -1.0);
/// let spot = IntensityDistribution::spot(down, [20f64.to_radians(), 40f64.to_radians()]);
/// assert_eq!((spot.relative(down), spot.relative(-down)), (1.0, 0.0));
/// let all = IntensityDistribution::isotropic();
/// assert!((all.solid_angle_integral() - 4.0 * std::f64::consts::PI).abs() < 1e-14);
/// ```
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(try_from = "Vec<f64>", into = "Vec<f64>")]
pub struct IntensityDistribution {
    form: DistributionForm,
}

#[derive(Clone, Debug, PartialEq)]
enum DistributionForm {
    Isotropic,
    Spot(SpotCone),
    Table(Arc<IntensityTable>, LuminaireFrame),
}

impl TryFrom<Vec<f64>> for IntensityDistribution {
    type Error = &'static str;
    fn try_from(numbers: Vec<f64>) -> Result<IntensityDistribution, &'static str> {
        IntensityDistribution::from_defining_numbers(&numbers).ok_or("the distribution of intensity is none")
    }
}

impl From<IntensityDistribution> for Vec<f64> {
    fn from(d: IntensityDistribution) -> Vec<f64> {
        d.defining_numbers()
    }
}

impl IntensityDistribution {
    /// The same intensity in all directions.
    #[must_use]
    pub fn isotropic() -> IntensityDistribution {
        IntensityDistribution { form: DistributionForm::Isotropic }
    }

    /// A cone about `axis` (any length) with its half-angles in radians: full intensity up to the inner one, none beyond the outer one.
    #[must_use]
    pub fn spot(axis: Vec3, half_angles: [f64; 2]) -> IntensityDistribution {
        let cone = SpotCone { axis: axis.normalized(), cosines: half_angles.map(f64::cos) };
        IntensityDistribution { form: DistributionForm::Spot(cone) }
    }

    /// A table whose direction γ = 0 is `aim` (any length), turned by `rotation` radians about it.
    ///
    /// With the aim straight down, [0, 0, −1], the plane C = 0° lies along x and C = 90° along y; other aims turn this frame by the smallest
    /// rotation. The rotation turns C = 0° towards C = 90°.
    #[must_use]
    pub fn table(table: IntensityTable, aim: Vec3, rotation: f64) -> IntensityDistribution {
        let frame = LuminaireFrame::new(aim.normalized(), rotation);
        IntensityDistribution { form: DistributionForm::Table(Arc::new(table), frame) }
    }

    /// Relative intensity f in the unit direction `direction` from the light.
    #[must_use]
    pub fn relative(&self, direction: Vec3) -> f64 {
        match &self.form {
            DistributionForm::Isotropic => 1.0,
            DistributionForm::Spot(cone) => cone.relative(cone.axis.dot(direction)),
            DistributionForm::Table(table, frame) => {
                let [gamma, c] = frame.angles(direction);
                table.relative(gamma, c)
            }
        }
    }

    /// An upper bound of f over the directions within `half_angle` (radians) of the unit direction `direction`.
    #[must_use]
    pub fn upper_bound(&self, direction: Vec3, half_angle: f64) -> f64 {
        match &self.form {
            DistributionForm::Isotropic => 1.0,
            DistributionForm::Spot(cone) => cone.upper_bound(direction, half_angle),
            DistributionForm::Table(table, frame) => {
                let gamma = frame.angles(direction)[0];
                table.upper_bound(gamma - half_angle, gamma + half_angle)
            }
        }
    }

    /// ∫ f dω, sr: the power of a light over its unit intensity.
    #[must_use]
    pub fn solid_angle_integral(&self) -> f64 {
        match &self.form {
            DistributionForm::Isotropic => 4.0 * PI,
            DistributionForm::Spot(cone) => cone.solid_angle_integral(),
            DistributionForm::Table(table, _) => table.solid_angle_integral(),
        }
    }

    /// The unit direction of density f/∫ f dω at a point of the unit square.
    #[must_use]
    pub fn sample_direction(&self, u: [f64; 2]) -> Vec3 {
        match &self.form {
            DistributionForm::Isotropic => uniform_sphere(u),
            DistributionForm::Spot(cone) => cone.sample_direction(u),
            DistributionForm::Table(table, frame) => frame.direction(table.sample_angles(u)),
        }
    }

    /// Angle over which f may change by much, radians: the width of the falloff of a spot, the finest step in γ of a table; 2π if f is constant.
    #[must_use]
    pub fn angular_resolution(&self) -> f64 {
        match &self.form {
            DistributionForm::Isotropic => 2.0 * PI,
            DistributionForm::Spot(cone) => {
                let [inner, outer] = cone.cosines.map(f64::acos);
                outer - inner
            }
            DistributionForm::Table(table, _) => table.finest_gamma_step(),
        }
    }

    /// The distribution after the reflection `reflect` of vectors.
    #[must_use]
    pub fn reflected(&self, reflect: impl Fn(Vec3) -> Vec3) -> IntensityDistribution {
        let form = match &self.form {
            DistributionForm::Isotropic => DistributionForm::Isotropic,
            DistributionForm::Spot(cone) => {
                DistributionForm::Spot(SpotCone { axis: reflect(cone.axis), ..*cone })
            }
            DistributionForm::Table(table, frame) => {
                DistributionForm::Table(table.clone(), frame.reflected(reflect))
            }
        };
        IntensityDistribution { form }
    }

    /// The numbers that determine the distribution, those of different kinds never alike.
    #[must_use]
    pub(crate) fn defining_numbers(&self) -> Vec<f64> {
        match &self.form {
            DistributionForm::Isotropic => vec![0.0],
            DistributionForm::Spot(SpotCone { axis, cosines: [inner, outer] }) => {
                vec![1.0, axis.x, axis.y, axis.z, *inner, *outer]
            }
            DistributionForm::Table(table, frame) => {
                let mut out = vec![2.0];
                out.extend(frame.numbers());
                table.append_numbers(&mut out);
                out
            }
        }
    }

    /// The distribution of [`IntensityDistribution::defining_numbers`], to the bit; `None` for other numbers.
    #[must_use]
    pub(crate) fn from_defining_numbers(numbers: &[f64]) -> Option<IntensityDistribution> {
        let (kind, rest) = numbers.split_first()?;
        let form = match (*kind as u8, rest) {
            (0, []) => DistributionForm::Isotropic,
            (1, [x, y, z, inner, outer]) => {
                DistributionForm::Spot(SpotCone { axis: vec3(*x, *y, *z), cosines: [*inner, *outer] })
            }
            (2, _) => {
                let (frame, table) = rest.split_at_checked(LuminaireFrame::NUMBERS)?;
                let table = IntensityTable::from_numbers(table)?;
                DistributionForm::Table(Arc::new(table), LuminaireFrame::from_numbers(frame)?)
            }
            _ => return None,
        };
        let out = IntensityDistribution { form };
        out.check().is_ok().then_some(out)
    }

    /// What is wrong with the numbers of the distribution, and the remedy.
    pub(crate) fn check(&self) -> Result<(), &'static str> {
        match &self.form {
            DistributionForm::Isotropic => Ok(()),
            DistributionForm::Spot(cone) => cone.check(),
            DistributionForm::Table(_, frame) if frame.is_valid() => Ok(()),
            DistributionForm::Table(..) => {
                Err("the aim must be a vector with a length, the rotation a finite angle")
            }
        }
    }
}

#[cfg(test)]
mod tests;
