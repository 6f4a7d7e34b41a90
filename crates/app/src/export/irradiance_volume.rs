//! Incident radiance on a grid as arrays for numpy, or as a 3-D texture of 16-bit floats with a header for engines.
//!
//! The texture file has three blocks, red, green and blue; each has the coefficients c_00, c_1,−1, c_10 and c_11 of every point over `scale`, x fastest, then y,
//! then z: the order of 3-D textures of four channels. The irradiance of a surface with the unit normal n is
//!
//! ```text
//!     H = scale · max(0, 0.886227 c_00 + 1.023327 (c_1,−1 n_y + c_10 n_z + c_11 n_x))        W/m²
//! ```

use super::gltf::{radiance_samples, up_axis};
use super::options::{ColourQuantity, ExportOptions, VolumeSettings};
use crate::pages::viewer::pack::{half, scale_of};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use zonal_io::output::glb::UpAxis;
use zonal_io::output::{self, NamedSingleArray};
use zonal_render::bake::irradiance_volume::{
    IrradianceVolume, IrradianceVolumeOptions, SH_CONSTANT, SH_LINEAR, bake_irradiance_volume,
};
use zonal_report::{Failure, check_output};
use zonal_scene::{Progress, Solution};

/// Bakes and writes the volume; adds its files and sizes.
///
/// # Errors
/// For files that cannot be written.
pub(super) fn write(
    options: &ExportOptions,
    settings: &VolumeSettings,
    s: &Solution,
    progress: &dyn Progress,
) -> Result<(Vec<PathBuf>, Map<String, Value>), Failure> {
    let defaults = IrradianceVolumeOptions::default();
    let baking = IrradianceVolumeOptions {
        dims: settings.dims,
        rays: settings.rays.unwrap_or(defaults.rays),
        ..defaults
    };
    let is_texture = options.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    let texture = options.output.with_extension("bin");
    if is_texture {
        check_output(&texture, &["bin"])?;
    }
    let volume = bake_irradiance_volume(s, &baking, progress);
    let mut about = metadata(s, &volume, options.glb.stops.unwrap_or(0.0));
    let sizes = Map::from_iter([("grid".to_string(), json!(volume.dims))]);
    if !is_texture {
        write_arrays(&options.output, &volume, &about)?;
        return Ok((Vec::new(), sizes));
    }
    let values: Vec<f32> = volume.coefficients.iter().flatten().flatten().copied().collect();
    let scale = scale_of(&values);
    output::write_bytes(&texture, &texture_bytes(&volume, scale))?;
    about["scale"] = scale.into();
    about["file"] = json!(texture.file_name().map(|n| n.to_string_lossy()));
    about["contents"] =
        "16-bit floats, little-endian, value / scale: blocks red, green, blue, each [z][y][x][coefficient]"
            .into();
    let text = format!("{about:#}\n");
    output::write_bytes(&options.output, text.as_bytes())?;
    Ok((vec![texture], sizes))
}

/// The blocks of the three bands.
fn texture_bytes(v: &IrradianceVolume, scale: f32) -> Vec<u8> {
    let [nx, ny, nz] = v.dims;
    let mut out = Vec::with_capacity(24 * nx * ny * nz);
    for band in 0..3 {
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    let i = (x * ny + y) * nz + z;
                    let of = |c: &Vec<[f32; 3]>| half(c[i][band] / scale).to_le_bytes();
                    v.coefficients.iter().for_each(|c| out.extend(of(c)));
                }
            }
        }
    }
    out
}

/// Writes the arrays of an npz.
fn write_arrays(path: &Path, v: &IrradianceVolume, about: &Value) -> Result<(), Failure> {
    let points = v.is_outside.len();
    let coefficients: Vec<f32> =
        (0..points).flat_map(|i| v.coefficients.iter().flat_map(move |c| c[i])).collect();
    let outside: Vec<f32> = v.is_outside.iter().map(|o| f32::from(u8::from(*o))).collect();
    let shape = |last: &[usize]| [&v.dims[..], last].concat();
    let arrays = [
        NamedSingleArray { name: "coefficients", shape: shape(&[4, 3]), values: vec![&coefficients] },
        NamedSingleArray {
            name: "sampling_error",
            shape: shape(&[3]),
            values: vec![v.sampling_error.as_flattened()],
        },
        NamedSingleArray { name: "outside", shape: shape(&[]), values: vec![&outside] },
    ];
    Ok(output::write_single_arrays(path, &about.to_string(), &arrays)?)
}

/// Meaning and units of the numbers.
fn metadata(s: &Solution, v: &IrradianceVolume, stops: f64) -> Value {
    let exposure = output::auto_exposure(&radiance_samples(s, ColourQuantity::Radiosity)) * stops.exp2();
    let inside = v.is_outside.iter().filter(|o| !**o).count();
    let mut rms = [0.0f64; 3];
    for e in &v.sampling_error {
        (0..3).for_each(|k| rms[k] += f64::from(e[k]).powi(2) / inside.max(1) as f64);
    }
    let [cosine_constant, cosine_linear] =
        [std::f64::consts::PI * SH_CONSTANT, 2.0 / 3.0 * std::f64::consts::PI * SH_LINEAR];
    json!({
        "min": v.min.array(), "max": v.max.array(), "dims": v.dims, "length": "m",
        "up": if up_axis(&s.scene) == UpAxis::Y { [0, 1, 0] } else { [0, 0, 1] },
        "coefficients": ["Y_00", "Y_1-1 (y)", "Y_10 (z)", "Y_11 (x)"],
        "unit": "W/m2",
        "direction": "towards where light comes from, in the axes of the scene; points lie in the centres of their cells",
        "irradiance": format!("max(0, {cosine_constant:.6} c0 + {cosine_linear:.6} (c1 n.y + c2 n.z + c3 n.x))"),
        "fluence": format!("c0 / {SH_CONSTANT:.6}"),
        "vector flux": format!("(c3, c1, c2) / {SH_LINEAR:.6}; net flux is its negative"),
        "rms of the sampling error of the fluence, W/m2": rms.map(f64::sqrt),
        "points outside": v.is_outside.len() - inside,
        "exposure": exposure, "exposure unit": "m2 sr/W",
        "scene hash": s.scene_hash,
    })
}
