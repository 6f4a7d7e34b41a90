//! Photometric files: luminous intensities of luminaires by direction.
//!
//! | module | contents |
//! |---|---|
//! | `ies` | ANSI/IES LM-63 (.ies), of 1986, 1991, 1995, 2002 and 2019 |
//! | `eulumdat` | EULUMDAT (.ldt) |
//! | `type_c` | tables of type A and B as tables of type C |
//!
//! Both formats list the intensity over half-planes C and angles γ from the axis of the luminaire, straight down as it usually hangs. What the
//! luminaire sends at the operating point of the file follows from the intensities alone: lumens of lamps and light output ratios are not applied again.

mod eulumdat;
mod ies;
mod type_c;

use super::error::FileFault;
use crate::files::FileSource;
use std::path::Path;
use zonal_scene::{IntensityTable, PlaneSymmetry};

/// Largest photometric file, bytes.
const MAX_FILE_BYTES: u64 = 8 << 20;
/// Largest number of angles of a table along each axis.
const MAX_ANGLES: usize = 10_000;

/// The intensities of a luminaire.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LuminousTable {
    /// Largest intensity, cd.
    pub(crate) peak: f64,
    /// Intensities over the largest one.
    pub(crate) table: IntensityTable,
}

/// Angles in degrees and intensities in cd, those of one plane together, as a file lists them.
#[derive(Clone, Debug, Default)]
struct AngleTable {
    planes: Vec<f64>,
    gammas: Vec<f64>,
    candelas: Vec<f64>,
}

impl AngleTable {
    /// The table with the largest intensity apart.
    fn normalized(self, symmetry: PlaneSymmetry) -> Result<LuminousTable, String> {
        let peak = self.candelas.iter().fold(0.0f64, |m, v| m.max(*v));
        if !(peak.is_finite() && peak > 0.0) {
            return Err("the largest intensity is no positive number; give a luminaire that emits".into());
        }
        let relative: Vec<f64> = self.candelas.iter().map(|v| v / peak).collect();
        let table = IntensityTable::new(&self.planes, &self.gammas, &relative, symmetry)?;
        Ok(LuminousTable { peak, table })
    }
}

/// Reads an .ies or an .ldt file.
pub(crate) fn read_luminaire(files: FileSource<'_>, path: &Path) -> Result<LuminousTable, FileFault> {
    let file = path.display().to_string();
    let fault = |message: String| FileFault::new(&file, "", message);
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let read: fn(&str, &str) -> Result<LuminousTable, FileFault> = match extension.as_str() {
        "ies" => ies::parse,
        "ldt" => eulumdat::parse,
        other => {
            return Err(fault(format!("'.{other}' is no photometric format; give a file .ies or .ldt")));
        }
    };
    let bytes = files.read(path, MAX_FILE_BYTES).map_err(fault)?;
    // Texts of these formats are often in a code page; numbers are ASCII.
    read(&file, &String::from_utf8_lossy(&bytes))
}

#[cfg(test)]
mod tests;
