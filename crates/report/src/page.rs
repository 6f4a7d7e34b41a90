//! A folder of results: a page in Markdown, tables as CSV, plots as SVG.

use crate::Failure;
use crate::plot::Plot;
use std::path::{Path, PathBuf};
use zonal_io::output;

/// A folder with a page, its tables and plots.
pub struct PageFolder(pub PathBuf);

impl PageFolder {
    /// The path of a file in the folder.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Writes a table as CSV.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn table(&self, name: &str, header: &[&str], rows: &[Vec<String>]) -> Result<(), Failure> {
        let path = self.path(name);
        let write_error = |e: csv::Error| Failure::in_file(&path, e);
        let mut out = csv::Writer::from_writer(Vec::new());
        out.write_record(header).map_err(write_error)?;
        rows.iter().try_for_each(|r| out.write_record(r)).map_err(write_error)?;
        let bytes = out.into_inner().map_err(|e| Failure::in_file(&path, e))?;
        Ok(output::write_bytes(&path, &bytes)?)
    }

    /// Writes a plot as SVG.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn plot(&self, name: &str, plot: &Plot) -> Result<(), Failure> {
        plot.write(&self.path(name))
    }

    /// Writes the page as README.md.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn page(&self, text: &str) -> Result<(), Failure> {
        Ok(output::write_bytes(&self.path("README.md"), text.as_bytes())?)
    }

    /// Creates the folder, checks that it can be written, and removes stale temporary files.
    ///
    /// # Errors
    /// If the folder cannot be created or written.
    pub fn create(path: &Path) -> Result<PageFolder, Failure> {
        std::fs::create_dir_all(path).map_err(|e| {
            Failure::new(format!(
                "{}: the folder cannot be created ({e}); choose another with --output",
                path.display()
            ))
        })?;
        let folder = PageFolder(path.to_path_buf());
        crate::check_output(&folder.path("probe.csv"), &["csv"])?;
        output::remove_stale_temporaries(path);
        Ok(folder)
    }
}

/// A table in Markdown.
#[must_use]
pub fn markdown(header: &[&str], rows: &[Vec<String>]) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let mut out = line(&header.iter().map(|s| s.to_string()).collect::<Vec<_>>());
    out += &line(&vec!["---".to_string(); header.len()]);
    rows.iter().for_each(|r| out += &line(r));
    out
}

/// A number with `digits` significant digits.
#[must_use]
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

/// A fraction in per cent, with three significant digits.
#[must_use]
pub fn percent(x: f64) -> String {
    format!("{} %", number(100.0 * x, 3))
}
