//! Photometric files: luminous intensities of luminaires by direction.
//!
//! | module | contents |
//! |---|---|
//! | `ies` | ANSI/IES LM-63 (.ies), of 1986, 1991, 1995, 2002 and 2019 |
//! | `eulumdat` | EULUMDAT (.ldt) |
//! | `luminous_table` | intensities with the largest one apart |
//! | `type_c` | tables of type A and B as tables of type C |
//!
//! Both formats list the intensity over half-planes C and angles γ from the axis of the luminaire, straight down as it usually hangs. What the
//! luminaire sends at the operating point of the file follows from the intensities alone: lumens of lamps and light output ratios are not applied again.

mod eulumdat;
mod ies;
mod luminous_table;
mod type_c;

pub(crate) use luminous_table::LuminousTable;

use crate::files::FileSource;
use crate::input::reading::error::FileFault;
use std::path::Path;

/// Largest photometric file, bytes.
const MAX_FILE_BYTES: u64 = 8 << 20;

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
