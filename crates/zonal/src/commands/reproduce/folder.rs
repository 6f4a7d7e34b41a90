//! Where the results of `zonal reproduce` go: tables as CSV, plots as SVG, the page as Markdown.

use crate::Failure;
use crate::plot::Plot;
use std::path::{Path, PathBuf};
use zonal_io::output;

/// The folder of a reproduction.
pub struct Folder(pub PathBuf);

impl Folder {
    /// The path of a file in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Writes a table.
    pub fn table(&self, name: &str, header: &[&str], rows: &[Vec<String>]) -> Result<(), Failure> {
        let path = self.path(name);
        let broken = |e: csv::Error| Failure::in_file(&path, e);
        let mut out = csv::Writer::from_writer(Vec::new());
        out.write_record(header).map_err(broken)?;
        rows.iter().try_for_each(|r| out.write_record(r)).map_err(broken)?;
        let bytes = out.into_inner().map_err(|e| Failure::in_file(&path, e))?;
        Ok(output::write_bytes(&path, &bytes)?)
    }

    /// Writes a plot.
    pub fn plot(&self, name: &str, plot: &Plot) -> Result<(), Failure> {
        plot.write(&self.path(name))
    }

    /// Writes the page.
    pub fn page(&self, text: &str) -> Result<(), Failure> {
        Ok(output::write_bytes(&self.path("README.md"), text.as_bytes())?)
    }

    /// Makes the folder and looks whether it can be written.
    pub fn make(path: &Path) -> Result<Folder, Failure> {
        std::fs::create_dir_all(path).map_err(|e| {
            Failure::new(format!(
                "{}: the folder cannot be made ({e}); choose another with --output",
                path.display()
            ))
        })?;
        let folder = Folder(path.to_path_buf());
        crate::commands::check_output(&folder.path("probe.csv"), &["csv"])?;
        output::remove_stale(path);
        Ok(folder)
    }
}

/// A table in Markdown.
pub fn markdown(header: &[&str], rows: &[Vec<String>]) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let mut out = line(&header.iter().map(|s| s.to_string()).collect::<Vec<_>>());
    out += &line(&vec!["---".to_string(); header.len()]);
    rows.iter().for_each(|r| out += &line(r));
    out
}

/// A number to so many significant digits, as one reads it.
pub fn number(x: f64, digits: usize) -> String {
    if x == 0.0 {
        return "0".into();
    }
    let power = x.abs().log10().floor() as i32;
    if !(-4..6).contains(&power) {
        return format!("{x:.*e}", digits - 1);
    }
    format!("{x:.*}", (digits as i32 - 1 - power).max(0) as usize)
}

/// A share in per cent.
pub(super) fn percent(x: f64) -> String {
    format!("{} %", number(100.0 * x, 3))
}
