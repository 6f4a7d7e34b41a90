//! Surfaces, their facets and textures, and panes.

use crate::bands::Bands;
use crate::geometry::plate::Plate;

/// The sides of a surface that take part in the exchange. A side that does not is black, cold and opaque.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Sides {
    /// The front only.
    Front,
    /// Both sides, each with zones of its own.
    Both,
}

/// Reflectance of a surface without a given one.
pub const DEFAULT_REFLECTANCE: Bands = Bands::splat(0.5);

/// A named surface: a diffuse material and the size of its patches.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
pub struct Surface {
    /// Unique name.
    pub name: String,
    /// Diffuse reflectance ρ; multiplies the reflectance texture, if any.
    pub reflectance: Bands,
    /// Emitted flux E, W/m²; multiplies the emission texture, if any.
    pub emission: Bands,
    /// Index of the texture of ρ.
    pub reflectance_texture: Option<usize>,
    /// Index of the texture of E.
    pub emission_texture: Option<usize>,
    /// Diffuse transmission; `None` for an opaque surface.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transmission: Option<Transmission>,
    /// The sides that exchange.
    pub sides: Sides,
    /// Largest patch edge, m; that of the scene if `None`.
    pub patch_size: Option<f64>,
    /// True if the surface bounds a closed solid: no medium behind its fronts.
    pub solid: bool,
}

impl Default for Surface {
    /// An opaque surface without name, light or texture, of the default reflectance, whose front exchanges.
    fn default() -> Surface {
        Surface {
            name: String::new(),
            reflectance: DEFAULT_REFLECTANCE,
            emission: Bands::ZERO,
            reflectance_texture: None,
            emission_texture: None,
            transmission: None,
            sides: Sides::Front,
            patch_size: None,
            solid: false,
        }
    }
}

impl Surface {
    /// ρ + τ without textures: the baked light of a sheet that transmits is the mean of both sides by ρ and τ.
    #[must_use]
    pub fn scattered_fraction(&self) -> Bands {
        self.transmission.map_or(self.reflectance, |t| self.reflectance + t.transmittance)
    }
}

/// Diffuse transmission of a thin sheet, such as a leaf, paper or frosted glass: of the light that arrives at either side the fraction τ leaves the other
/// with the same radiance in all directions. Both directions have one τ, as reciprocity demands.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
pub struct Transmission {
    /// Diffuse transmittance τ; multiplies the texture, if any. ρ + τ is at most 1.
    pub transmittance: Bands,
    /// Index of the texture of τ.
    pub texture: Option<usize>,
}

/// A plate of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// Index of the surface.
    pub surface: usize,
    /// Geometry.
    pub plate: Plate,
    /// Texture coordinates at (u, v) = (0,0), (1,0) and (0,1); linear in between.
    pub uv: [[f64; 2]; 3],
}

impl Facet {
    /// Texture coordinates at plate parameters (u, v).
    pub fn uv_at(&self, u: f64, v: f64) -> [f64; 2] {
        [0, 1].map(|k| {
            self.uv[0][k] + u * (self.uv[1][k] - self.uv[0][k]) + v * (self.uv[2][k] - self.uv[0][k])
        })
    }
}

/// A linear RGB image with row 0 on top, repeated beyond [0,1)²; v points down (the convention of glTF).
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Pixels along u.
    pub width: usize,
    /// Pixels along v.
    pub height: usize,
    /// Linear values, row by row.
    pub pixels: Vec<[f32; 3]>,
}

impl Texture {
    /// The largest value of each channel.
    pub fn upper_bound(&self) -> Bands {
        self.pixels.iter().map(|p| Bands::from_rgb(p.map(f64::from))).fold(Bands::ZERO, Bands::max)
    }
    /// The bilinearly interpolated value at texture coordinates (u, v).
    pub fn sample(&self, uv: [f64; 2]) -> Bands {
        let (w, h) = (self.width as f64, self.height as f64);
        let wrap = |t: f64| if t.is_finite() { t - t.floor() } else { 0.0 };
        let (x, y) = (wrap(uv[0]) * w - 0.5, wrap(uv[1]) * h - 0.5);
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let pixel = |dx: i64, dy: i64| {
            let i = (x.floor() as i64 + dx).rem_euclid(self.width as i64) as usize;
            let j = (y.floor() as i64 + dy).rem_euclid(self.height as i64) as usize;
            Bands::from_rgb(self.pixels[j * self.width + i].map(f64::from))
        };
        let (a, b, c, d) = (pixel(0, 0), pixel(1, 0), pixel(0, 1), pixel(1, 1));
        let top = a * (1.0 - fx) + b * fx;
        let bottom = c * (1.0 - fx) + d * fx;
        top * (1.0 - fy) + bottom * fy
    }
}

/// A pane: a thin sheet of absorbing and scattering material, a volume zone outside the voxel grid.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
pub struct Pane {
    /// Name.
    pub name: String,
    /// The plates of its polygon, all in one plane.
    #[serde(skip)]
    pub plates: Vec<Plate>,
    /// Thickness t, m.
    pub thickness: f64,
    /// Extinction κ, 1/m.
    pub extinction: Bands,
    /// Scattering albedo Ω.
    pub albedo: Bands,
    /// Blackbody emissive power E, W/m².
    pub emission: Bands,
}
