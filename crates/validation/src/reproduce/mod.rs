//! `zonal reproduce`: the paper's claims, computed afresh, each as a plot, a table and a sentence.
//!
//! | file | part of the paper |
//! |---|---|
//! | `constants` | section 2: C(u) of Proposition 1; "< 1 %"; e = C/N for pairs |
//! | `point` | formula (3) against distance |
//! | `series` | figure 8; "N = 20 or 30 and a ratio of 0.5" |
//! | `timing` | section 4.2: the table, and "3 to 20 times faster" |
//! | `solves` | e = C/N in the solved radiosity; the whole system on the paper's own factors |

mod constants;
mod point_kernel;
mod series;
mod solves;
mod timing;

use std::path::PathBuf;
use zonal_demo::Size;
use zonal_report::{Failure, PageFolder, say};

/// Options of a reproduction.
#[derive(Clone, Debug)]
pub struct ReproductionOptions {
    /// Folder for plots, tables and the page README.md; made if it is not there.
    pub output: PathBuf,
    /// `Small` takes seconds, `Full` minutes.
    pub size: Size,
    /// Print JSON instead of lines.
    pub json: bool,
    /// Print no line for a section.
    pub quiet: bool,
}

const PAGE_HEAD: &str = include_str!("head.md");

/// Computes all sections and writes the page.
///
/// # Errors
/// A folder or file that cannot be written; a solve that is refused.
pub fn run(options: &ReproductionOptions) -> Result<(), Failure> {
    let folder = PageFolder::create(&options.output)?;
    let sizes = match options.size {
        Size::Small => solves::SolveSizes { divisions: &[3, 4, 6], chapel: None, pixels: (160, 120) },
        Size::Full => solves::SolveSizes {
            divisions: &[4, 6, 8, 10, 13, 16],
            chapel: Some(Size::Full),
            pixels: (480, 360),
        },
    };
    let mut page = PAGE_HEAD.to_string();
    let step = |name: &str| if options.quiet || options.json { Ok(()) } else { say(&format!("{name} …")) };
    step("constants")?;
    page += &constants::write(&folder)?;
    step("formula (3)")?;
    page += &point_kernel::write(&folder)?;
    step("series")?;
    page += &series::write(&folder)?;
    step("times")?;
    page += &timing::write(&folder, options.size)?;
    step("whole solves")?;
    page += &solves::write(&folder, sizes)?;
    folder.page(&page)?;
    let written = folder.path("README.md");
    if options.json {
        return say(&serde_json::json!({ "page": written.display().to_string() }).to_string());
    }
    say(&format!("written: {}", written.display()))
}
