//! What campaigns share: processes with their cost, samples of zones, statistics against noisy references, and pictures compared in blocks.

pub(crate) mod pictures;
pub(crate) mod process;
pub(crate) mod statistics;
pub(crate) mod zone_sampling;

use std::path::{Path, PathBuf};

/// Any error, in a sentence.
pub(crate) type Error = Box<dyn std::error::Error>;

/// Whether the requirements of a campaign hold.
pub(crate) type Outcome = Result<bool, Error>;

/// Data that are not part of the project.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct SharedData {
    /// Folder of reference data
    #[arg(long, default_value = "../shared")]
    pub shared: PathBuf,
}

/// A temporary folder, removed when it is dropped.
pub(crate) struct ScratchFolder(PathBuf);

impl ScratchFolder {
    /// A new folder; `name` is part of its path.
    pub(crate) fn new(name: &str) -> std::io::Result<ScratchFolder> {
        let path = std::env::temp_dir().join(format!("zonal-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path)?;
        Ok(ScratchFolder(path))
    }
}

impl std::ops::Deref for ScratchFolder {
    type Target = Path;
    fn deref(&self) -> &Path {
        &self.0
    }
}

impl Drop for ScratchFolder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A share in per cent, with two decimals.
pub(crate) fn percent(x: f64) -> String {
    format!("{:.2} %", 100.0 * x)
}

/// A difference in per cent, with its sign.
pub(crate) fn signed_percent(x: f64) -> String {
    format!("{:+.2} %", 100.0 * x)
}

/// A cell of a table, or a dash.
pub(crate) fn or_dash(x: Option<f64>, format: impl Fn(f64) -> String) -> String {
    x.map_or("–".into(), format)
}

/// Whether a case is wanted: all are without a list.
pub(crate) fn is_wanted(list: &[String], name: &str) -> bool {
    list.is_empty() || list.iter().any(|n| n == name)
}
