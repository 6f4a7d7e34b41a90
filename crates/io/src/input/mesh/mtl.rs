//! Material libraries of OBJ files: Kd is the reflectance, map_Kd its picture, Ke a radiance (emission = π Ke).

use super::{Material, Picture};
use crate::input::error::Fault;
use crate::input::files::Files;
use std::f64::consts::PI;
use std::path::Path;

const MAX_FILE: u64 = 64 << 20;

/// Reads a library; what is mended or left aside goes into `notes`.
pub(crate) fn read(files: Files<'_>, path: &Path, notes: &mut Vec<String>) -> Result<Vec<Material>, Fault> {
    let file = path.display().to_string();
    let bytes = files.read(path, MAX_FILE).map_err(|what| Fault::new(&file, "", what))?;
    let text = String::from_utf8_lossy(&bytes);
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut materials: Vec<Material> = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let number = number + 1;
        let line = line.split('#').next().unwrap_or("").trim();
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        if word == "newmtl" {
            materials.push(Material::named(if rest.is_empty() { "default" } else { rest }));
            continue;
        }
        let Some(m) = materials.last_mut() else { continue };
        match word {
            "Kd" => {
                let kd = colour(&file, number, rest)?;
                if kd.iter().any(|x| *x > 1.0) {
                    notes.push(format!("{file}:{number}: Kd above 1 was cut to 1"));
                }
                m.reflectance = Some(kd.map(|x| x.min(1.0)));
            }
            "Ke" => m.emission = colour(&file, number, rest)?.map(|x| x * PI),
            "map_Kd" => {
                // Options come before the name, which may hold spaces when there are none.
                let name = match rest.starts_with('-') {
                    true => rest.split_whitespace().last().unwrap_or(rest),
                    false => rest,
                };
                let picture = folder.join(name.replace('\\', "/"));
                if files.has(&picture) {
                    m.texture = Some(Picture::File(picture));
                } else {
                    notes.push(format!("{file}:{number}: there is no picture '{name}'; Kd alone was used"));
                }
            }
            "d" if rest.parse().is_ok_and(|d: f64| d < 1.0) => {
                m.lost_opaque = Some(format!(
                    "{file}:{number}: material '{0}' is transparent and was read as opaque; give it a pane in the scene to change that",
                    m.name
                ));
            }
            "map_d" => {
                m.lost_opaque = Some(format!(
                    "{file}:{number}: material '{0}' is transparent by a picture (map_d), which is not read: it is opaque; give it a pane in the scene, or leave it out by materials.\"{0}\".omit = true",
                    m.name
                ));
            }
            _ => {}
        }
    }
    // Some exporters write a black Kd beside a picture, and mean the picture.
    for m in &mut materials {
        if m.texture.is_some() && m.reflectance.is_none_or(|r| r == [0.0; 3]) {
            m.reflectance = Some([1.0; 3]);
        }
    }
    Ok(materials)
}

/// One number for all bands, or three.
fn colour(file: &str, line: usize, text: &str) -> Result<[f64; 3], Fault> {
    let bad =
        |word: &str| Fault::new(file, line, format!("'{word}' is not a colour value; give numbers from 0"));
    let mut values = Vec::new();
    for word in text.split_whitespace().take(3) {
        match word.parse::<f64>() {
            Ok(x) if x.is_finite() && x >= 0.0 => values.push(x),
            _ => return Err(bad(word)),
        }
    }
    match values.as_slice() {
        [r, g, b] => Ok([*r, *g, *b]),
        [grey] => Ok([*grey; 3]),
        _ => Err(bad(text)),
    }
}
