//! Pictures of skies: linear values from OpenEXR or Radiance files.

use super::radiance_hdr;
use crate::files::FileSource;
use crate::input::reading::error::FileFault;
use crate::output::read_exr_from_bytes;
use std::path::Path;
use zonal_scene::Texture;

/// Largest file of a sky, bytes.
const MAX_SKY_FILE_BYTES: u64 = 512 << 20;

/// Reads a picture by its first bytes.
pub(crate) fn read_sky_picture(files: FileSource<'_>, path: &Path) -> Result<Texture, FileFault> {
    let file = path.display().to_string();
    let fault = |message: String| FileFault::new(&file, "", message);
    let bytes = files.read(path, MAX_SKY_FILE_BYTES).map_err(fault)?;
    if bytes.starts_with(b"#?") {
        return radiance_hdr::decode(&bytes).map_err(fault);
    }
    if !bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        return Err(fault(
            "this is neither an OpenEXR nor a Radiance picture; convert it to .exr or .hdr, whose values are linear".into(),
        ));
    }
    let picture = read_exr_from_bytes(&bytes).map_err(|e| fault(e.message().to_string()))?;
    Ok(Texture { width: picture.width, height: picture.height, pixels: picture.pixels })
}
