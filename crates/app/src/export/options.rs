//! Kinds of exports, and their settings.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use zonal_io::output::ToneCurve;
use zonal_report::{Failure, check_output};

/// Vertices of a .glb.
pub const VERTEX_RANGE: RangeInclusive<u64> = 1..=100_000_000;
/// Largest width and height of a lightmap, texels.
pub const ATLAS_RANGE: RangeInclusive<u64> = 16..=16_384;
/// Points of an irradiance volume along an axis.
pub const GRID_RANGE: RangeInclusive<u64> = 1..=512;
/// Rays of a point of an irradiance volume.
pub const VOLUME_RAY_RANGE: RangeInclusive<u64> = 16..=100_000;

/// Most points of an irradiance volume: 100 MB of texture.
const MAX_VOLUME_POINTS: usize = 4_000_000;

/// An export; the extension of the file selects the format.
#[derive(Clone, Debug, Default)]
pub struct ExportOptions {
    /// The file of the solution, which messages name and which is not replaced.
    pub source: PathBuf,
    /// File to write.
    pub output: PathBuf,
    /// Results by face of the meshes in place of zones (.csv, .npy, .vtu).
    pub faces: bool,
    /// Adds values at the corners of patches and panes (.vtu).
    pub points: bool,
    /// Illuminances in lx (.csv), by this luminous efficacy, lm/W.
    pub photometric: Option<f64>,
    /// First of the three bands that stand for red, green and blue.
    pub first_band: Option<usize>,
    /// Settings of the .glb.
    pub glb: GlbOptions,
    /// A lightmap in place of vertex colours (.glb).
    pub lightmap: Option<LightmapSettings>,
    /// The incident radiance on a grid (.npz, .json).
    pub irradiance_volume: Option<VolumeSettings>,
}

/// Settings of a .glb with vertex colours; with a lightmap or an irradiance volume, `stops` alone applies, to the exposure that the file states.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GlbOptions {
    /// Quantity of the vertex colours; radiosity if `None`.
    pub colours: Option<ColourQuantity>,
    /// Tone curve; filmic if `None`.
    pub curve: Option<ToneCurve>,
    /// Exposure relative to the automatic one, stops, −30 to 30.
    pub stops: Option<f64>,
    /// Smallest edge that is halved at shadow edges, m; a thousandth of the diagonal of the scene if `None`.
    pub finest: Option<f64>,
    /// Largest number of vertices.
    pub vertices: Option<usize>,
    /// Writes the irradiance of each light group as vertex attributes.
    pub light_groups: bool,
}

/// Quantity of the vertex colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum ColourQuantity {
    /// Radiosity: the light that leaves the surfaces.
    #[default]
    Radiosity,
    /// Irradiance: the light that arrives, as on white plaster.
    Irradiance,
}

impl ColourQuantity {
    /// The names in options, in the order of [`ColourQuantity::VARIANTS`].
    pub const NAMES: [&str; 2] = ["radiosity", "irradiance"];
    /// All quantities.
    pub const VARIANTS: [ColourQuantity; 2] = [ColourQuantity::Radiosity, ColourQuantity::Irradiance];
}

/// Settings of a lightmap.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightmapSettings {
    /// Edge of a texel, m; the finest for which the lightmap fits if `None`.
    pub texel: Option<f64>,
    /// Largest width and height, texels.
    pub atlas: Option<usize>,
}

/// Settings of an irradiance volume.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VolumeSettings {
    /// Points along each axis; 32 along the longest edge if `None`.
    pub dims: Option<[usize; 3]>,
    /// Rays of each point.
    pub rays: Option<usize>,
}

impl ExportOptions {
    /// Refuses outputs that cannot be written, and settings that are out of range or do not apply.
    ///
    /// # Errors
    /// The setting, and what to do.
    pub fn check(&self) -> Result<(), Failure> {
        let formats: &[&str] = match (self.faces, &self.irradiance_volume) {
            (true, _) => &["csv", "npy", "vtu"],
            (_, Some(_)) => &["npz", "json"],
            _ => &["csv", "html", "glb", "vtu", "vti"],
        };
        check_output(&self.output, formats)?;
        let same =
            |a: &Path, b: &Path| a.canonicalize().is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b));
        if same(&self.source, &self.output) {
            return Err(Failure::new("--output: this would replace the solution; give another name"));
        }
        let extension = self.extension();
        if self.first_band.is_some() && !self.shows_colours() {
            return Err(Failure::new(
                "--first-band: this format has all bands; remove the option, or write .html or .glb",
            ));
        }
        if self.points && extension != "vtu" {
            return Err(Failure::new("--points: values at points are written as .vtu; give this extension"));
        }
        if self.photometric.is_some() && extension != "csv" {
            return Err(Failure::new("--photometric: illuminances are written as .csv; give this extension"));
        }
        let alone = self.points || self.photometric.is_some() || self.lightmap.is_some();
        if self.faces && (alone || self.irradiance_volume.is_some()) {
            let list = "--points, --photometric, --lightmap and --irradiance-volume";
            return Err(Failure::new(format!("{list} apply to zones; leave them out for --faces")));
        }
        match (&self.lightmap, &self.irradiance_volume) {
            (Some(_), Some(_)) => {
                Err(Failure::new("--lightmap applies to .glb; leave it out for --irradiance-volume"))
            }
            (Some(lightmap), None) => lightmap.check(&extension, &self.glb),
            (None, Some(volume)) => volume.check(&self.glb),
            (None, None) => self.glb.check(&extension),
        }
    }

    /// True for outputs that show three bands as red, green and blue.
    #[must_use]
    pub fn shows_colours(&self) -> bool {
        matches!(self.extension().as_str(), "html" | "glb") || self.irradiance_volume.is_some()
    }

    /// The extension of the output, in lower case.
    pub(super) fn extension(&self) -> String {
        self.output.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
    }
}

impl VolumeSettings {
    fn check(&self, glb: &GlbOptions) -> Result<(), Failure> {
        if !glb.has_only_stops() {
            return Err(Failure::new(format!(
                "{COLOUR_SETTINGS} apply to .glb; leave them out for --irradiance-volume"
            )));
        }
        for points in self.dims.into_iter().flatten() {
            check_count("--grid", Some(points), &GRID_RANGE)?;
        }
        check_count("--rays", self.rays, &VOLUME_RAY_RANGE)?;
        if self.dims.is_some_and(|n| n.iter().product::<usize>() > MAX_VOLUME_POINTS) {
            return Err(Failure::new(format!("--grid: give at most {MAX_VOLUME_POINTS} points together")));
        }
        glb.check_stops()
    }
}

impl LightmapSettings {
    fn check(&self, extension: &str, glb: &GlbOptions) -> Result<(), Failure> {
        if extension != "glb" {
            return Err(Failure::new(format!("--lightmap applies to .glb; leave it out for .{extension}")));
        }
        if !glb.has_only_stops() {
            return Err(Failure::new(format!(
                "{COLOUR_SETTINGS} apply to vertex colours; leave them out for --lightmap"
            )));
        }
        if self.texel.is_some_and(|t| !(t.is_finite() && t > 0.0)) {
            return Err(Failure::new("--texel: give a length above 0, in metres"));
        }
        check_count("--atlas", self.atlas, &ATLAS_RANGE)?;
        glb.check_stops()
    }
}

/// Settings of vertex colours.
const COLOUR_SETTINGS: &str = "--colours, --curve, --finest, --vertices and --light-groups";

impl GlbOptions {
    fn check(&self, extension: &str) -> Result<(), Failure> {
        if extension != "glb" && *self != GlbOptions::default() {
            let list = "--colours, --curve, --stops, --finest, --vertices and --light-groups";
            return Err(Failure::new(format!("{list} apply to .glb; leave them out for .{extension}")));
        }
        self.check_stops()?;
        if self.finest.is_some_and(|f| !(f.is_finite() && f > 0.0)) {
            return Err(Failure::new("--finest: give a length above 0, in metres"));
        }
        check_count("--vertices", self.vertices, &VERTEX_RANGE)
    }

    fn has_only_stops(&self) -> bool {
        *self == GlbOptions { stops: self.stops, ..GlbOptions::default() }
    }

    fn check_stops(&self) -> Result<(), Failure> {
        if self.stops.is_some_and(|s| !(s.is_finite() && s.abs() <= 30.0)) {
            return Err(Failure::new("--stops: give a number between -30 and 30"));
        }
        Ok(())
    }
}

fn check_count(flag: &str, count: Option<usize>, range: &RangeInclusive<u64>) -> Result<(), Failure> {
    match count.map(|n| n as u64).filter(|n| !range.contains(n)) {
        None => Ok(()),
        Some(n) => {
            let (low, high) = (range.start(), range.end());
            Err(Failure::new(format!("{flag}: {n} is out of range; give a number from {low} to {high}")))
        }
    }
}
