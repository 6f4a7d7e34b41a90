//! `zonal solve` as a separate process with its cost, reading, tables and writing included.

#[path = "watch.rs"]
pub(crate) mod watch;

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use watch::watched;
use zonal_io::output;

/// A folder that goes when it is no longer needed.
struct TemporaryFolder(PathBuf);

impl Drop for TemporaryFolder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Solves the scene of a text with more arguments, and asks `of` about the file written. With its answer the report, and wall time in s,
/// processor time in s and peak of the resident memory in MB.
pub(crate) fn solve<T>(
    command: &Path,
    text: &str,
    arguments: &[&str],
    of: impl FnOnce(&Path) -> Result<T, Box<dyn std::error::Error>>,
) -> Result<(Value, [f64; 3], T), Box<dyn std::error::Error>> {
    let folder = TemporaryFolder(std::env::temp_dir().join(format!("zonal-example-{}", std::process::id())));
    std::fs::create_dir_all(&folder.0)?;
    let (scene, run) = (folder.0.join("scene.toml"), folder.0.join("run.npz"));
    output::write_bytes(&scene, text.as_bytes())?;
    let mut solve = Command::new(command);
    solve.arg("solve").arg(&scene).arg("--json").args(arguments).arg("-o").arg(&run);
    let (said, took) = watched(&mut solve)?;
    Ok((serde_json::from_str(&said)?, took, of(&run)?))
}
