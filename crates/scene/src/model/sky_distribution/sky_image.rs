//! A sky from an equirectangular picture.
//!
//! The rows of the picture divide the angle from the zenith, from up at the top to down at the bottom, its columns the turn about the axis: the middle of the picture
//! looks forward, its right half to the right. The radiance is constant over each pixel, and a pixel is drawn with its share of radiance × solid angle.

use super::direction_table::{DirectionTable, TableSample};
use super::sky_frame::SkyFrame;
use crate::{Bands, Texture};
use zonal_math::Vec3;

/// Largest number of pixels of a sky: 4096 × 2048.
const MAX_SKY_PIXELS: usize = 1 << 23;

/// A picture and its place about the scene.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SkyImage {
    frame: SkyFrame,
    picture: Texture,
    table: DirectionTable,
}

impl SkyImage {
    /// The sky of a picture.
    pub(super) fn new(picture: Texture, frame: SkyFrame) -> Result<SkyImage, String> {
        let Texture { width, height, pixels } = &picture;
        let (w, h) = (*width, *height);
        if h == 0 || w != 2 * h || pixels.len() != w * h {
            return Err(format!(
                "an equirectangular picture is twice as wide as high; this one has {w} × {h} pixels"
            ));
        }
        if pixels.len() > MAX_SKY_PIXELS {
            return Err(format!("this picture has {w} × {h} pixels, more than 4096 × 2048; make it smaller"));
        }
        let valid = |p: &[f32; 3]| p.iter().all(|v| v.is_finite() && *v >= 0.0);
        if let Some(k) = pixels.iter().position(|p| !valid(p)) {
            return Err(format!(
                "pixel {} of row {} has the values {:?}; radiances are finite numbers from 0",
                k % w,
                k / w,
                pixels[k]
            ));
        }
        let edges = DirectionTable::edges_of_equal_angles(h);
        let table = DirectionTable::new(edges, w, |r, c| value(&pixels[r * w + c]).mean());
        if table.total() > 0.0 {
            Ok(SkyImage { frame, picture, table })
        } else {
            Err("this picture is black; give a sky that shines".into())
        }
    }

    /// The place of a direction: height, and the turn from the left edge of the picture to the right.
    fn place(&self, direction: Vec3) -> (f64, f64) {
        let (z, turn) = self.frame.coordinates(direction);
        (z, if turn <= 0.5 { 0.5 - turn } else { 1.5 - turn })
    }

    /// Radiance in the unit direction `direction`.
    pub(super) fn relative(&self, direction: Vec3) -> Bands {
        let (z, across) = self.place(direction);
        let [r, c] = self.table.locate(z, across);
        value(&self.picture.pixels[r * self.picture.width + c])
    }

    /// An upper bound of ∫ f cosθ⁺ dω about a unit vector, sr, in each of the three bands: three times that of their mean.
    pub(super) fn irradiance_bound(&self, normal: Vec3) -> f64 {
        let (z, across) = self.place(normal);
        3.0 * self.table.cosine_bound(z, across)
    }

    /// The direction at a point of the unit square and its density, 1/sr.
    pub(super) fn sample(&self, u: [f64; 2]) -> (Vec3, f64) {
        let TableSample { z, turn: across, density } = self.table.sample(u);
        (self.frame.direction(z, 0.5 - across), density)
    }

    /// Density of a direction, 1/sr.
    pub(super) fn density(&self, direction: Vec3) -> f64 {
        let (z, across) = self.place(direction);
        self.table.density(z, across)
    }

    /// ∫ f dω over all directions, sr.
    pub(super) fn solid_angle_integral(&self) -> Bands {
        let rows = self.picture.pixels.chunks(self.picture.width).enumerate();
        rows.map(|(r, row)| row.iter().map(value).sum::<Bands>() * self.table.cell_solid_angle(r)).sum()
    }

    /// The largest value of each band.
    pub(super) fn upper_bound(&self) -> Bands {
        self.picture.pixels.iter().map(value).fold(Bands::ZERO, Bands::max)
    }

    pub(super) fn frame(&self) -> &SkyFrame {
        &self.frame
    }

    pub(super) fn picture(&self) -> &Texture {
        &self.picture
    }
}

fn value(p: &[f32; 3]) -> Bands {
    Bands::from_rgb(p.map(f64::from))
}
