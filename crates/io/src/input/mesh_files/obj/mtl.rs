//! Material libraries of OBJ files.
//!
//! | library | scene |
//! |---|---|
//! | Kd and map_Kd | reflectance and its texture |
//! | Ke | a radiance L; emission = π L |
//! | map_d | an alpha that blends |
//! | d < 1, or Tr = 1 − d > 0 where d is missing | a pane of transmittance 1 − d |
//! | Tf with illum 4, 6, 7 or 9, the models of glass | a pane of transmittance Tf |
//! | map_Bump, norm, disp | not read, which a note says |
//! | Ks with illum 3 to 9, the models of mirrors and glass | not read: its light is absorbed, which a note says |

use crate::files::FileSource;
use crate::input::images::AlphaChannel;
use crate::input::mesh::model::{
    AlphaRule, AlphaSource, GlassAttenuation, GlassProperties, ImageSource, MIN_TRANSMITTANCE, MeshMaterial,
};
use crate::input::reading::error::FileFault;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use zonal_scene::Bands;

/// Largest library, bytes.
const MAX_LIBRARY_BYTES: u64 = 64 << 20;

/// Reads a library; repairs and ignored contents go into `notes`.
pub(super) fn read_library(
    files: FileSource<'_>,
    path: &Path,
    notes: &mut Vec<String>,
) -> Result<Vec<MeshMaterial>, FileFault> {
    let file = path.display().to_string();
    let bytes = files.read(path, MAX_LIBRARY_BYTES).map_err(|e| FileFault::new(&file, "", e))?;
    let text = String::from_utf8_lossy(&bytes);
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut materials: Vec<MeshMaterial> = Vec::new();
    let mut optics: Vec<MtlOptics> = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let number = number + 1;
        let line = line.split('#').next().unwrap_or("").trim();
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        if word == "newmtl" {
            materials.push(MeshMaterial::named(if rest.is_empty() { "default" } else { rest }));
            optics.push(MtlOptics::default());
            continue;
        }
        let (Some(m), Some(optics)) = (materials.last_mut(), optics.last_mut()) else { continue };
        let line = MtlLine { files, folder, file: &file, number, word, rest };
        line.apply(m, notes)?;
        line.read_optics(optics)?;
    }
    materials.iter_mut().zip(&optics).for_each(|(m, optics)| optics.apply(m, &file, notes));
    // Some exporters write a black Kd beside a texture and mean the texture.
    for m in &mut materials {
        if m.texture.is_some() && m.reflectance.is_none_or(|r| r == Bands::ZERO) {
            m.reflectance = Some(Bands::ONE);
        }
    }
    Ok(materials)
}

/// Thickness of panes whose transmittance the library gives, in its unit. Their optical depth is the same for any thickness.
const PANE_THICKNESS: f64 = 1e-3;
/// Specular reflectance below which a material is taken as diffuse.
const MIN_SPECULAR: f64 = 0.05;

/// Transmission and specular reflection of a material.
#[derive(Default)]
struct MtlOptics {
    /// d, 1 for an opaque material.
    dissolve: Option<f64>,
    /// Tr = 1 − d.
    transparency: Option<f64>,
    /// Tf.
    filter: Option<Bands>,
    /// illum.
    model: u32,
    /// Ks.
    specular: Bands,
}

impl MtlOptics {
    /// True for the models of glass.
    fn is_glass(&self) -> bool {
        matches!(self.model, 4 | 6 | 7 | 9)
    }

    /// The transmittance of the material; `None` if it is opaque.
    fn transmittance(&self) -> Option<Bands> {
        let of_dissolve = match (self.dissolve, self.transparency) {
            (Some(d), _) => 1.0 - d,
            // Some exporters write the dissolve as Tr, and 1 for an opaque material.
            (None, Some(t)) if t < 1.0 => t,
            _ => 0.0,
        };
        if of_dissolve > 0.0 && of_dissolve <= 1.0 {
            return Some(Bands::splat(of_dissolve));
        }
        let filter = self.filter.filter(|_| self.is_glass())?;
        Some(filter.map(|x| x.min(1.0)))
    }

    /// Makes a transparent material a pane, and notes what is not read.
    fn apply(&self, m: &mut MeshMaterial, file: &str, notes: &mut Vec<String>) {
        if let Some(transmittance) = self.transmittance().filter(|_| m.alpha.is_none()) {
            m.glass = Some(GlassProperties {
                thickness: Some(PANE_THICKNESS),
                attenuation: GlassAttenuation::Transmittance(transmittance.map(|t| t.max(MIN_TRANSMITTANCE))),
                albedo: if self.is_glass() { Bands::ZERO } else { m.reflectance.unwrap_or_default() },
            });
        }
        if (3..=9).contains(&self.model) && self.specular.any(|s| s >= MIN_SPECULAR) {
            notes.push(format!(
                "{file}: material '{0}': its specular reflectance (Ks, illum {1}) is not read, and that light is absorbed; give materials.\"{0}\".reflectance to keep it",
                m.name, self.model
            ));
        }
    }
}

/// A line of a library: its keyword and the rest.
struct MtlLine<'a> {
    files: FileSource<'a>,
    folder: &'a Path,
    file: &'a str,
    /// From 1.
    number: usize,
    word: &'a str,
    rest: &'a str,
}

impl MtlLine<'_> {
    /// The path of the picture that the line names; its name where there is none.
    fn picture(&self) -> Result<PathBuf, &str> {
        // Skip options; a name without options may hold spaces.
        let name = if self.rest.starts_with('-') {
            self.rest.split_whitespace().last().unwrap_or(self.rest)
        } else {
            self.rest
        };
        let image = self.folder.join(name.replace('\\', "/"));
        if self.files.contains(&image) { Ok(image) } else { Err(name) }
    }

    /// Reads transmission and specular reflection.
    fn read_optics(&self, optics: &mut MtlOptics) -> Result<(), FileFault> {
        // A word before the number is an option ("d -halo 0.5").
        let number = || self.rest.split_whitespace().last().and_then(|w| w.parse::<f64>().ok());
        match self.word {
            "d" => optics.dissolve = number(),
            "Tr" => optics.transparency = number(),
            "illum" => optics.model = number().unwrap_or(0.0) as u32,
            "Tf" => optics.filter = colour(self.file, self.number, self.rest).ok(),
            "Ks" => optics.specular = colour(self.file, self.number, self.rest)?,
            _ => {}
        }
        Ok(())
    }

    /// Sets the property that the line gives.
    fn apply(&self, m: &mut MeshMaterial, notes: &mut Vec<String>) -> Result<(), FileFault> {
        let MtlLine { file, number, word, rest, .. } = *self;
        match word {
            "Kd" => {
                let kd = colour(file, number, rest)?;
                if kd.any(|x| x > 1.0) {
                    notes.push(format!("{file}:{number}: Kd above 1 was cut to 1"));
                }
                m.reflectance = Some(kd.map(|x| x.min(1.0)));
            }
            "Ke" => m.emission = colour(file, number, rest)? * PI,
            "map_Kd" => match self.picture() {
                Ok(image) => m.texture = Some(ImageSource::File(image)),
                Err(name) => {
                    notes.push(format!("{file}:{number}: there is no picture '{name}'; Kd alone was used"));
                }
            },
            "map_d" => {
                let image = self.picture().map(ImageSource::File);
                match image {
                    Ok(image) => {
                        m.opaque_warning = None;
                        m.alpha = Some(AlphaSource {
                            image: Some(image),
                            channel: AlphaChannel::AlphaOrGrey,
                            factor: 1.0,
                            rule: AlphaRule::Blend,
                        });
                    }
                    Err(name) => {
                        m.opaque_warning = Some(format!(
                            "{file}:{number}: there is no picture '{name}' of the transparency of material '{0}': it is opaque; put the picture there, or leave the material out by materials.\"{0}\".omit = true",
                            m.name
                        ));
                    }
                }
            }
            "norm" | "map_Kn" | "map_Bump" | "map_bump" | "bump" | "disp" => notes.push(format!(
                "{file}:{number}: the relief of material '{}' ({word}) is not read: pictures show it smooth; a normal map of a .glb is",
                m.name
            )),
            _ => {}
        }
        Ok(())
    }
}

/// One number for all bands, or three.
fn colour(file: &str, line: usize, text: &str) -> Result<Bands, FileFault> {
    let bad = |word: &str| {
        FileFault::new(file, line, format!("'{word}' is not a colour value; give numbers from 0"))
    };
    let mut values = Vec::new();
    for word in text.split_whitespace().take(3) {
        match word.parse::<f64>() {
            Ok(x) if x.is_finite() && x >= 0.0 => values.push(x),
            _ => return Err(bad(word)),
        }
    }
    match values.as_slice() {
        [r, g, b] => Ok(Bands::from_rgb([*r, *g, *b])),
        [grey] => Ok(Bands::splat(*grey)),
        _ => Err(bad(text)),
    }
}
