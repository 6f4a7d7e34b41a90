//! Material libraries of OBJ files: Kd is the reflectance, map_Kd its texture, Ke a radiance (emission = π Ke), map_d an alpha that blends.

use crate::files::FileSource;
use crate::input::error::FileFault;
use crate::input::mesh::model::{AlphaChannel, AlphaRule, AlphaSource, ImageSource, MeshMaterial};
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
    for (number, line) in text.lines().enumerate() {
        let number = number + 1;
        let line = line.split('#').next().unwrap_or("").trim();
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        if word == "newmtl" {
            materials.push(MeshMaterial::named(if rest.is_empty() { "default" } else { rest }));
            continue;
        }
        let Some(m) = materials.last_mut() else { continue };
        let line = MtlLine { files, folder, file: &file, number, word, rest };
        line.apply(m, notes)?;
    }
    // Some exporters write a black Kd beside a texture and mean the texture.
    for m in &mut materials {
        if m.texture.is_some() && m.reflectance.is_none_or(|r| r == Bands::ZERO) {
            m.reflectance = Some(Bands::ONE);
        }
    }
    Ok(materials)
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
        let name = match self.rest.starts_with('-') {
            true => self.rest.split_whitespace().last().unwrap_or(self.rest),
            false => self.rest,
        };
        let image = self.folder.join(name.replace('\\', "/"));
        if self.files.contains(&image) { Ok(image) } else { Err(name) }
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
            "d" if rest.parse().is_ok_and(|d: f64| d < 1.0) => {
                m.opaque_warning = Some(format!(
                    "{file}:{number}: material '{0}' is transparent and was read as opaque; give it a pane in the scene to change that",
                    m.name
                ));
            }
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
