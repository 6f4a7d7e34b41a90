//! Arguments of `zonal view-factors`.

use std::path::PathBuf;
use zonal_io::input::mesh_extensions;
use zonal_io::output::ViewFactorFormat;

/// Compute view factors of facets that hide each other, without a medium.
///
/// F_ij is the share of the diffuse radiation of facet i that facet j receives; facets radiate from their fronts (corners counter-clockwise). Rows are in the
/// order of the file and sum to one with the sky (directions above the horizon that meet nothing) and the ground (those below it). Each factor has an error
/// radius in .npz and .csv files. Lengths in metres.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// The facets; the help takes the list of formats from the reader of meshes.
    #[arg(help = format!("Facets: an input file of View3D (.vs3), or a mesh ({})", mesh_extensions()))]
    pub input: PathBuf,
    /// File to write: .npz (scipy.sparse.load_npz reads it; with radii, sky and areas), .csv, .mtx (MatrixMarket), .bin (View3D's binary format), or .txt and
    /// .out (View3D's text formats: see --format).
    #[arg(long, short, value_name = "FACTORS")]
    pub output: PathBuf,
    /// Tolerance T, 0 < T < 1: the error radius of a factor F is at most about max(T F, T/50), that of a row's sum of the order of T.
    #[arg(long, default_value_t = 1e-3, value_name = "T")]
    pub tolerance: f64,
    /// Mesh whose facets hide from both sides and have no factors.
    #[arg(long, value_name = "MESH")]
    pub obstructions: Option<PathBuf>,
    /// Sides that exchange. With `both`, the rows of the backs follow those of the fronts in the same order.
    #[arg(long, value_enum, default_value_t = FacetSides::Front)]
    pub sides: FacetSides,
    /// View3D's format of a .txt or .out file [default: `out` of the .vs3 file, else text].
    #[arg(long, value_enum)]
    pub format: Option<OutputFormat>,
    /// Write the sky view factors, one for each line (.txt).
    #[arg(long, value_name = "SKY.txt")]
    pub sky: Option<PathBuf>,
    /// Period along x, m: the geometry repeats without end.
    #[arg(long, value_name = "LENGTH")]
    pub period_x: Option<f64>,
    /// Period along y, m.
    #[arg(long, value_name = "LENGTH")]
    pub period_y: Option<f64>,
    /// Axis that points to the zenith.
    #[arg(long, value_enum, default_value_t = ZenithAxis::Z)]
    pub up: ZenithAxis,
    /// The facets form an enclosure: leave out sky and ground. `encl = 1` in a .vs3 file does the same.
    #[arg(long)]
    pub enclosure: bool,
    /// Keep the computed factors instead of making rows sum to one.
    #[arg(long)]
    pub no_closing: bool,
    /// Write total exchange factors of grey facets (script F) by the emissivities of the .vs3 file. `emit = 1` in the file does the same.
    #[arg(long)]
    pub script_f: bool,
    /// Folder of finished batches: a run that was stopped resumes, and a run with the same facets and settings reads them.
    #[arg(long, value_name = "FOLDER")]
    pub cache: Option<PathBuf>,
    /// Memory limit of the factors, GB.
    #[arg(long, default_value_t = 12.0, value_name = "GB")]
    pub max_memory: f64,
}

/// Sides of facets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum FacetSides {
    /// The side from which the corners run counter-clockwise.
    Front,
    /// Both sides, each with a row of its own.
    Both,
}

/// Formats of View3D.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum OutputFormat {
    /// Header, areas, all n × n factors with six decimals, emissivities (out = 0).
    Text,
    /// The same in single precision (out = 1).
    Binary,
    /// Lines of row, column and factor above zero, from 1 (out = 2 of uDALES's View3D).
    Sparse,
}

impl From<OutputFormat> for ViewFactorFormat {
    fn from(f: OutputFormat) -> ViewFactorFormat {
        match f {
            OutputFormat::Text => ViewFactorFormat::View3dText,
            OutputFormat::Binary => ViewFactorFormat::View3dBinary,
            OutputFormat::Sparse => ViewFactorFormat::SparseText,
        }
    }
}

/// The axis of the zenith.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ZenithAxis {
    /// x
    X,
    /// y
    Y,
    /// z
    Z,
}
