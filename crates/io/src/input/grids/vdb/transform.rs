//! Linear transforms from voxel indices to positions.
//!
//! A transform takes the index (i, j, k) to o + i a₀ + j a₁ + k a₂ in the file's length unit; a voxel's value belongs to the
//! parallelepiped around that point, from −½ to +½ in each index.

use super::bytes::{ByteCursor, SAVE_AGAIN};
use crate::input::reading::error::FileFault;
use zonal_math::Vec3;

/// A linear transform of indices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinearTransform {
    /// The image of index 0, file units.
    pub(crate) origin: Vec3,
    /// The images of one step along each index, file units.
    pub(crate) axes: [Vec3; 3],
}

impl LinearTransform {
    /// Reads a transform's name and numbers.
    pub(crate) fn read(c: &mut ByteCursor<'_>) -> Result<LinearTransform, FileFault> {
        let name = c.text()?;
        let transform = match name.as_str() {
            "UniformScaleMap" | "ScaleMap" => read_scaled(c, [0.0; 3])?,
            "UniformScaleTranslateMap" | "ScaleTranslateMap" => {
                let origin = c.vector()?;
                read_scaled(c, origin)?
            }
            "TranslationMap" => axis_aligned(c.vector()?, [1.0; 3]),
            "AffineMap" | "UnitaryMap" => read_affine(c)?,
            _ => {
                return Err(c.fault(format!(
                    "the transform {name:.40} is not read; resample the grid to a linear transform"
                )));
            }
        };
        let finite = transform.origin.is_finite() && transform.axes.iter().all(|a| a.is_finite());
        let volume = transform.axes[0].cross(transform.axes[1]).dot(transform.axes[2]);
        if finite && volume.is_normal() {
            return Ok(transform);
        }
        Err(c.fault(format!("the transform gives voxels no volume; {SAVE_AGAIN}")))
    }
}

/// A transform along the axes.
fn axis_aligned(origin: [f64; 3], scale: [f64; 3]) -> LinearTransform {
    let axis = |k: usize| Vec3::from_array(std::array::from_fn(|i| if i == k { scale[k] } else { 0.0 }));
    LinearTransform { origin: Vec3::from_array(origin), axes: [axis(0), axis(1), axis(2)] }
}

/// Reads a scale, and skips four vectors that follow from it.
fn read_scaled(c: &mut ByteCursor<'_>, origin: [f64; 3]) -> Result<LinearTransform, FileFault> {
    let scale = c.vector()?;
    for _ in 0..4 {
        c.vector()?;
    }
    Ok(axis_aligned(origin, scale))
}

/// Reads a 4 × 4 matrix of row vectors: its rows are the images of the axes and of the origin.
fn read_affine(c: &mut ByteCursor<'_>) -> Result<LinearTransform, FileFault> {
    let mut rows = [Vec3::default(); 4];
    for row in &mut rows {
        *row = Vec3::from_array(c.vector()?);
        c.f64()?;
    }
    Ok(LinearTransform { origin: rows[3], axes: [rows[0], rows[1], rows[2]] })
}
