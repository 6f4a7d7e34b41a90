//! `zonal demo`: the main job on an embedded scene.

use super::{Context, render, solve};
use crate::failure::say;
use crate::{Failure, meter::Meter, table};
use std::path::PathBuf;
use zonal_io::{input, output};

/// Solve an embedded chapel with stained glass and dusty air, and draw it.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// How fine: zones and pixels.
    #[arg(long, value_enum, default_value_t = Size::Full)]
    pub size: Size,
    /// Formula for the exchange of two voxels, as in `zonal solve`.
    #[arg(long, value_enum, default_value_t = solve::Factors::Exact)]
    pub factors: solve::Factors,
    /// Folder for the solution and the pictures; made if it is not there.
    #[arg(long, short, default_value = "zonal-demo")]
    pub output: PathBuf,
    /// Write the scene to this file (.toml) and stop: a start for your own.
    #[arg(long)]
    pub write: Option<PathBuf>,
}

/// How fine the demo is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Size {
    /// For tests: a few seconds.
    Small,
    /// As the paper's figure 10: about a minute on two cores.
    Full,
}

const TEMPLATE: &str = include_str!("../demo/chapel.toml.in");

/// The demo's scene as a scene file.
pub fn scene_text(size: Size) -> String {
    let (patch, cells) = match size {
        Size::Small => ("0.9", "[7, 12, 5]"),
        Size::Full => ("0.5", "[14, 24, 10]"),
    };
    TEMPLATE.replace("PATCH", patch).replace("CELLS", cells)
}

/// Runs the command.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let text = scene_text(args.size);
    if let Some(path) = &args.write {
        super::check_output(path, &["toml"])?;
        output::write_bytes(path, text.as_bytes())?;
        say(&format!("scene written: {}", path.display()))?;
        return Ok(());
    }
    std::fs::create_dir_all(&args.output).map_err(|e| {
        Failure::new(format!(
            "{}: the folder cannot be made ({e}); choose another with --output",
            args.output.display()
        ))
    })?;
    let run = args.output.join("chapel.npz");
    super::check_output(&run, &["npz"])?;
    let scene = input::parse_scene(&text, None, "the embedded chapel")?;
    let picture = |camera: &str| args.output.join(format!("{camera}.png"));
    scene.cameras().iter().try_for_each(|c| super::check_output(&picture(&c.name), &["png"]))?;
    let meter = Meter::new(context.quiet);
    let start = std::time::Instant::now();
    let solution = solve::solved(scene, 12 << 30, args.factors.settings(), &meter)?;
    let solved = start.elapsed().as_secs_f64();
    output::write_solution(&run, &solution)?;
    let (pixels, samples) = match args.size {
        Size::Small => ((160, 120), 4),
        Size::Full => ((640, 480), 6),
    };
    let mut pictures = Vec::new();
    for camera in solution.scene.cameras() {
        let path = picture(&camera.name);
        let image = render::draw(&solution, camera, pixels, samples, &meter);
        render::save(&path, &image, 0.0)?;
        pictures.push(path.display().to_string());
    }
    let total = start.elapsed().as_secs_f64();
    if context.json {
        let mut json = output::report_json(&solution);
        json["pictures"] = pictures.into();
        json["solution"] = run.display().to_string().into();
        json["seconds"] = serde_json::json!({ "solve": solved, "total": total });
        say(&format!("{json:#}"))?;
        return Ok(());
    }
    say("A chapel of 6 m × 10 m: stained glass, dusty air, the sun falling in.\n")?;
    say(table::report(&solution).trim_end())?;
    say(&format!("time\n  solve {solved:.1} s, with pictures {total:.1} s\nwritten"))?;
    say(&format!("  {}   (numpy opens it)", run.display()))?;
    pictures.iter().try_for_each(|p| say(&format!("  {p}")))?;
    say(&format!("\nnext\n  zonal render {} --camera aisle --size 1280x960 -o aisle.png", run.display()))?;
    say("  zonal demo --write chapel.toml    the scene, to change; then zonal check, solve, render")?;
    say(&format!("  zonal export {} -o zones.csv", run.display()))?;
    Ok(())
}
