//! Arguments of `zonal export`.

use clap::ValueEnum;
use std::path::PathBuf;
use zonal_io::output::ToneCurve;
use zonal_report::Failure;

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

/// Most points of an irradiance volume: 100 MB of texture.
const MAX_VOLUME_POINTS: usize = 4_000_000;

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
#[derive(clap::Args, Debug, Default, PartialEq)]
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
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    pub vertices: Option<u64>,
    /// Write the irradiance of each light group, W/m2, as vertex attributes _IRRADIANCE_0, _IRRADIANCE_1, …
    #[arg(long)]
    pub light_groups: bool,
}

/// Settings of the lightmap.
#[derive(clap::Args, Debug, Default, PartialEq)]
#[command(next_help_heading = "Lightmap of the .glb")]
pub struct LightmapArgs {
    /// Write the irradiance as a texture, NAME.lightmap.exr, for the second texture coordinates of the .glb, in place of vertex colours.
    #[arg(long)]
    pub lightmap: bool,
    /// Edge of a texel, m [default: the finest for which the lightmap fits into --atlas].
    #[arg(long, value_name = "METRES", requires = "lightmap")]
    pub texel: Option<f64>,
    /// Largest width and height of the lightmap, texels [default: 1024; with --texel 8192].
    #[arg(long, value_name = "TEXELS", requires = "lightmap", value_parser = clap::value_parser!(u64).range(16..=16_384))]
    pub atlas: Option<u64>,
}

/// Settings of the irradiance volume.
#[derive(clap::Args, Debug, Default, PartialEq)]
#[command(next_help_heading = "Irradiance volume (.npz, .json)")]
pub struct IrradianceVolumeArgs {
    /// Write the incident radiance on a grid of points, in spherical harmonics.
    #[arg(long, conflicts_with_all = ["faces", "lightmap"])]
    pub irradiance_volume: bool,
    /// Points along x, y and z, in the centres of equal parts of the scene's bounds [default: 32 along the longest edge].
    #[arg(long, value_name = "NX,NY,NZ", value_delimiter = ',', requires = "irradiance_volume", value_parser = clap::value_parser!(u64).range(1..=512))]
    pub grid: Vec<u64>,
    /// Rays of each point, 16 to 100000 [default: 512].
    #[arg(long, value_name = "N", requires = "irradiance_volume", value_parser = clap::value_parser!(u64).range(16..=100_000))]
    pub rays: Option<u64>,
}

impl IrradianceVolumeArgs {
    /// Points along each axis.
    #[must_use]
    pub fn dims(&self) -> Option<[usize; 3]> {
        let [x, y, z] = self.grid[..] else { return None };
        Some([x, y, z].map(|n| n as usize))
    }

    /// Refuses settings that are out of range.
    ///
    /// # Errors
    /// The flag and its range.
    pub fn check(&self, glb: &GlbArgs) -> Result<(), Failure> {
        if !self.irradiance_volume {
            return Ok(());
        }
        if *glb != (GlbArgs { stops: glb.stops, ..GlbArgs::default() }) {
            let list = "--colours, --curve, --finest, --vertices and --light-groups";
            return Err(Failure::new(format!(
                "{list} apply to .glb; leave them out for --irradiance-volume"
            )));
        }
        if !self.grid.is_empty() && self.dims().is_none() {
            return Err(Failure::new("--grid: give three numbers of points, as 32,32,16"));
        }
        if self.dims().is_some_and(|n| n.iter().product::<usize>() > MAX_VOLUME_POINTS) {
            return Err(Failure::new(format!("--grid: give at most {MAX_VOLUME_POINTS} points together")));
        }
        glb.check_stops()
    }
}

/// Quantity of the vertex colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ColourQuantity {
    /// Radiosity: the light that leaves the surfaces.
    #[default]
    Radiosity,
    /// Irradiance: the light that arrives, as on white plaster.
    Irradiance,
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

impl LightmapArgs {
    /// Refuses settings that are out of range, or that do not apply to a format or to a lightmap.
    ///
    /// # Errors
    /// The flag and its range.
    pub fn check(&self, extension: &str, glb: &GlbArgs) -> Result<(), Failure> {
        if !self.lightmap {
            return Ok(());
        }
        if extension != "glb" {
            return Err(Failure::new(format!("--lightmap applies to .glb; leave it out for .{extension}")));
        }
        if *glb != (GlbArgs { stops: glb.stops, ..GlbArgs::default() }) {
            let list = "--colours, --curve, --finest, --vertices and --light-groups";
            return Err(Failure::new(format!(
                "{list} apply to vertex colours; leave them out for --lightmap"
            )));
        }
        if self.texel.is_some_and(|t| !(t.is_finite() && t > 0.0)) {
            return Err(Failure::new("--texel: give a length above 0, in metres"));
        }
        Ok(())
    }
}

impl GlbArgs {
    /// Refuses settings that are out of range, or that do not apply to a format.
    ///
    /// # Errors
    /// The flag and its range.
    pub fn check(&self, extension: &str) -> Result<(), Failure> {
        if extension != "glb" && *self != GlbArgs::default() {
            let list = "--colours, --curve, --stops, --finest, --vertices and --light-groups";
            return Err(Failure::new(format!("{list} apply to .glb; leave them out for .{extension}")));
        }
        self.check_stops()?;
        if self.finest.is_some_and(|f| !(f.is_finite() && f > 0.0)) {
            return Err(Failure::new("--finest: give a length above 0, in metres"));
        }
        Ok(())
    }

    fn check_stops(&self) -> Result<(), Failure> {
        match self.stops.is_some_and(|s| !(s.is_finite() && s.abs() <= 30.0)) {
            true => Err(Failure::new("--stops: give a number between -30 and 30")),
            false => Ok(()),
        }
    }
}
