//! The quantity that a file of voxel values stands for.

use crate::input::scene::quantities::medium_properties::MediumProperties;
use zonal_math::Vec3;
use zonal_scene::Bands;

/// How the values of a file become properties of the medium: voxels get the mean over their volume of `averaged`(value), times
/// `scale`^`scale_exponent`, through `properties`.
pub(crate) struct VoxelField<'a> {
    /// The function of a value that is averaged.
    pub(crate) averaged: fn(f64) -> f64,
    /// Exponent of the scale of `averaged`.
    pub(crate) scale_exponent: i32,
    /// The properties of a scaled mean.
    pub(crate) properties: &'a dyn Fn(Bands) -> MediumProperties,
    /// True if the quantity may differ from band to band.
    pub(crate) has_bands: bool,
    /// The box of an array without one.
    pub(crate) default_bounds: Option<(Vec3, Vec3)>,
    /// True of a density, whose values are samples of a field that is interpolated.
    pub(crate) is_density: bool,
    /// The noun for a value in messages.
    pub(crate) noun: &'static str,
}

impl<'a> VoxelField<'a> {
    /// A density: values are averaged themselves.
    pub(crate) fn density(properties: &'a dyn Fn(Bands) -> MediumProperties) -> VoxelField<'a> {
        VoxelField {
            averaged: |x| x,
            scale_exponent: 1,
            properties,
            has_bands: true,
            default_bounds: None,
            is_density: true,
            noun: "density",
        }
    }
}
