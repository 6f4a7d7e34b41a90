//! Where a grid's voxels lie: the file's linear maps.
//!
//! A map takes the index (i, j, k) to o + i a₀ + j a₁ + k a₂ in the file's length unit; a voxel's value belongs to the
//! parallelepiped around that point, from −½ to +½ in each index.

use super::bytes::{Cursor, SAVE_AGAIN};
use crate::input::error::Fault;
use zonal_math::Vec3;

/// A linear map of indices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Map {
    /// The image of index 0, file units.
    pub(crate) origin: Vec3,
    /// The images of one step along each index, file units.
    pub(crate) axes: [Vec3; 3],
}

impl Map {
    /// Reads a map's name and numbers.
    pub(crate) fn read(c: &mut Cursor<'_>) -> Result<Map, Fault> {
        let name = c.text()?;
        let map = match name.as_str() {
            "UniformScaleMap" | "ScaleMap" => scaled(c, [0.0; 3])?,
            "UniformScaleTranslateMap" | "ScaleTranslateMap" => {
                let origin = c.vector()?;
                scaled(c, origin)?
            }
            "TranslationMap" => unit(c.vector()?, [1.0; 3]),
            "AffineMap" | "UnitaryMap" => affine(c)?,
            _ => {
                return Err(c.fault(format!(
                    "the transform {name:.40} is not read; resample the grid to a linear transform"
                )));
            }
        };
        let finite = map.origin.is_finite() && map.axes.iter().all(|a| a.is_finite());
        let volume = map.axes[0].cross(map.axes[1]).dot(map.axes[2]);
        if finite && volume.is_normal() {
            return Ok(map);
        }
        Err(c.fault(format!("the transform gives voxels no volume; {SAVE_AGAIN}")))
    }
}

fn unit(origin: [f64; 3], scale: [f64; 3]) -> Map {
    let axis = |k: usize| Vec3::from_array(std::array::from_fn(|i| if i == k { scale[k] } else { 0.0 }));
    Map { origin: Vec3::from_array(origin), axes: [axis(0), axis(1), axis(2)] }
}

/// Scale, then four vectors that follow from it.
fn scaled(c: &mut Cursor<'_>, origin: [f64; 3]) -> Result<Map, Fault> {
    let scale = c.vector()?;
    for _ in 0..4 {
        c.vector()?;
    }
    Ok(unit(origin, scale))
}

/// A 4 × 4 matrix that rows are multiplied with: its rows are the images of the axes and of the origin.
fn affine(c: &mut Cursor<'_>) -> Result<Map, Fault> {
    let mut rows = [Vec3::default(); 4];
    for row in &mut rows {
        *row = Vec3::from_array(c.vector()?);
        c.f64()?;
    }
    Ok(Map { origin: rows[3], axes: [rows[0], rows[1], rows[2]] })
}
