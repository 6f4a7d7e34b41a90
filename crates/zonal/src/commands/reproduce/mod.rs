//! `zonal reproduce`: the paper's claims, computed afresh, each as a plot, a table and a sentence.
//!
//! | file | what of the paper |
//! |---|---|
//! | `constants` | section 2: C(u) of Proposition 1; "< 1 %"; e = C/N for pairs |
//! | `point` | formula (3) against distance |
//! | `series` | figure 8; "N = 20 or 30 and a ratio of 0.5" |
//! | `timing` | section 4.2: the table, and "3 to 20 times faster" |
//! | `solves` | e = C/N in the solved radiosity; the whole system on the paper's own factors |

mod constants;
mod folder;
mod point;
mod series;
mod solves;
mod timing;

use super::{Context, demo};
use crate::Failure;
use crate::failure::say;
pub use folder::{Folder, markdown, number};
use std::path::PathBuf;

/// Reproduce the paper's figures, table and claims.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Folder for plots, tables and the page README.md; made if it is not there.
    #[arg(long, short, default_value = "docs/reproduction")]
    pub output: PathBuf,
    /// How fine: `small` takes seconds, `full` minutes.
    #[arg(long, value_enum, default_value_t = demo::Size::Full)]
    pub size: demo::Size,
}

const HEAD: &str = include_str!("head.md");

/// Runs the command.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let folder = Folder::make(&args.output)?;
    let sizes = match args.size {
        demo::Size::Small => solves::Sizes { divisions: &[3, 4, 6], chapel: None, pixels: (160, 120) },
        demo::Size::Full => solves::Sizes {
            divisions: &[4, 6, 8, 10, 13, 16],
            chapel: Some(demo::Size::Full),
            pixels: (480, 360),
        },
    };
    let mut page = HEAD.to_string();
    let step = |name: &str| if context.quiet || context.json { Ok(()) } else { say(&format!("{name} …")) };
    step("constants")?;
    page += &constants::write(&folder)?;
    step("formula (3)")?;
    page += &point::write(&folder)?;
    step("series")?;
    page += &series::write(&folder)?;
    step("times")?;
    page += &timing::write(&folder, args.size == demo::Size::Small)?;
    step("whole solves")?;
    page += &solves::write(&folder, sizes)?;
    folder.page(&page)?;
    let written = folder.path("README.md");
    if context.json {
        return say(&serde_json::json!({ "page": written.display().to_string() }).to_string());
    }
    say(&format!("written: {}", written.display()))
}
