//! Arguments of `zonal export`.

use clap::ValueEnum;
use std::path::PathBuf;
use zonal_app::export::{ATLAS_RANGE, ColourQuantity, GRID_RANGE, VERTEX_RANGE, VOLUME_RAY_RANGE};
use zonal_io::output::ToneCurve;

/// Formats by extension.
const FORMATS: &str = "\
The extension selects the format:
  .csv  one line per zone, for spreadsheets
  .html the page of `zonal view` with its data: one file that opens without a server or a network
  .glb  the scene with its light baked into vertex colours, for Blender, web viewers and engines; the light of the
        medium is written beside it, as NAME.medium.npz
        with --lightmap one texture of irradiances in place of vertex colours, NAME.lightmap.exr
  .vtu  patches and panes with all fields, for ParaView; with --points also values at their corners
  .vti  the medium on its grid with all fields, for ParaView
With --irradiance-volume, the incident radiance on a grid of points, in spherical harmonics of degree 0 and 1, for objects that move through the scene:
  .npz  arrays for numpy
  .json header of a 3-D texture of 16-bit floats, NAME.bin, for three.js and other engines
With --faces, one row for each face of the meshes: .csv, .npy, or .vtu (one cell for each facet)
docs/how-to/export.md describes the contents and how to open them.";

/// Write a solution for other programs.
#[derive(clap::Args, Debug)]
#[command(after_long_help = FORMATS)]
pub struct Args {
    /// Solution (.npz).
    pub run: PathBuf,
    /// File to write: .csv, .html, .glb, .vtu or .vti; with --faces .csv, .npy or .vtu; with --irradiance-volume .npz or .json.
    #[arg(long, short, value_name = "FILE")]
    pub output: PathBuf,
    /// Write results by face of the meshes in place of zones (.csv, .npy, .vtu): one row for each face, in the order of the mesh files.
    #[arg(long)]
    pub faces: bool,
    /// Add point data to a .vtu: radiosity and irradiance at the corners of patches and panes, by the same function as vertex colours.
    #[arg(long, conflicts_with_all = ["faces", "irradiance_volume"])]
    pub points: bool,
    /// Write illuminances in lx (.csv), and print those of the surfaces: the mean over the bands times the luminous efficacy, lm/W.
    #[arg(long, value_name = "EFFICACY", num_args = 0..=1, default_missing_value = "683", conflicts_with = "faces")]
    pub photometric: Option<f64>,
    /// First of the three bands that stand for red, green and blue in .html and .glb, where the solution has other bands: 0, 3, 6, ….
    #[arg(long, value_name = "B")]
    pub first_band: Option<u32>,
    /// Settings of the .glb.
    #[command(flatten)]
    pub glb: GlbArgs,
    /// Settings of the lightmap.
    #[command(flatten)]
    pub lightmap: LightmapArgs,
    /// Settings of the irradiance volume.
    #[command(flatten)]
    pub irradiance_volume: IrradianceVolumeArgs,
}

/// Settings of the .glb.
#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Settings of the .glb")]
pub struct GlbArgs {
    /// Quantity of the vertex colours [default: radiosity].
    #[arg(long, value_name = "QUANTITY")]
    pub colours: Option<ColourQuantity>,
    /// Tone curve from exposed light to colour [default: filmic].
    #[arg(long, value_name = "CURVE")]
    pub curve: Option<CurveName>,
    /// Exposure relative to the automatic one, stops, -30 to 30 [default: 0]; with --lightmap and --irradiance-volume the one that their file states.
    #[arg(long, allow_hyphen_values = true)]
    pub stops: Option<f64>,
    /// Smallest edge that is halved at shadow edges, m [default: a thousandth of the diagonal of the scene].
    #[arg(long, value_name = "METRES")]
    pub finest: Option<f64>,
    /// Largest number of vertices [default: 2000000]. The largest differences of light are refined first.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(VERTEX_RANGE))]
    pub vertices: Option<u64>,
    /// Write the irradiance of each light group, W/m2, as vertex attributes _IRRADIANCE_0, _IRRADIANCE_1, …
    #[arg(long)]
    pub light_groups: bool,
}

/// Settings of the lightmap.
#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Lightmap of the .glb")]
pub struct LightmapArgs {
    /// Write the irradiance as a texture, NAME.lightmap.exr, for the second texture coordinates of the .glb, in place of vertex colours.
    #[arg(long)]
    pub lightmap: bool,
    /// Edge of a texel, m [default: the finest for which the lightmap fits into --atlas].
    #[arg(long, value_name = "METRES", requires = "lightmap")]
    pub texel: Option<f64>,
    /// Largest width and height of the lightmap, texels [default: 1024; with --texel 8192].
    #[arg(long, value_name = "TEXELS", requires = "lightmap", value_parser = clap::value_parser!(u64).range(ATLAS_RANGE))]
    pub atlas: Option<u64>,
}

/// Settings of the irradiance volume.
#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Irradiance volume (.npz, .json)")]
pub struct IrradianceVolumeArgs {
    /// Write the incident radiance on a grid of points, in spherical harmonics.
    #[arg(long, conflicts_with_all = ["faces", "lightmap"])]
    pub irradiance_volume: bool,
    /// Points along x, y and z, in the centres of equal parts of the scene's bounds [default: 32 along the longest edge].
    #[arg(long, value_name = "NX,NY,NZ", value_delimiter = ',', requires = "irradiance_volume", value_parser = clap::value_parser!(u64).range(GRID_RANGE))]
    pub grid: Vec<u64>,
    /// Rays of each point, 16 to 100000 [default: 512].
    #[arg(long, value_name = "N", requires = "irradiance_volume", value_parser = clap::value_parser!(u64).range(VOLUME_RAY_RANGE))]
    pub rays: Option<u64>,
}

/// Tone curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum CurveName {
    /// Rolls off highlights, as in pictures.
    #[default]
    Filmic,
    /// Clips at white.
    Linear,
}

impl From<CurveName> for ToneCurve {
    fn from(c: CurveName) -> ToneCurve {
        match c {
            CurveName::Filmic => ToneCurve::Filmic,
            CurveName::Linear => ToneCurve::Linear,
        }
    }
}
