//! `zonal demo`: the main job on a scene of our own.

use super::{Context, render, solve};
use crate::failure::say;
use crate::{Failure, church, meter::Meter, table};
use std::path::{Path, PathBuf};
use zonal_io::{input, output};
use zonal_scene::Scene;

/// Solve a scene of our own with stained glass and dusty air, and draw it.
///
/// chapel: embedded, about a minute. church: built by parameters, at the size of the paper's pictures (a hundred thousand patches, a
/// million and a half voxels), which takes long; --size small is two bays of it.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Which scene.
    #[arg(value_enum, default_value_t = Which::Chapel)]
    pub scene: Which,
    /// How fine: zones and pixels.
    #[arg(long, value_enum, default_value_t = Size::Full)]
    pub size: Size,
    /// Formula for the exchange of two voxels, as in `zonal solve`.
    #[arg(long, value_enum, default_value_t = solve::Factors::Exact)]
    pub factors: solve::Factors,
    /// Folder for the solution and the pictures; made if it is not there.
    #[arg(long, short, default_value = "zonal-demo")]
    pub output: PathBuf,
    /// Write the scene to this file (.toml), with its mesh beside it (.glb) if it has one, and stop: a start for your own.
    #[arg(long)]
    pub write: Option<PathBuf>,
}

/// A scene of our own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Which {
    /// 6 m × 10 m, one room.
    Chapel,
    /// Nave, aisles and apse, 34 m long.
    Church,
}

/// How fine the demo is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Size {
    /// For tests: seconds for the chapel, two bays of the church.
    Small,
    /// The chapel as the paper's figure 10, the church as its figures 11 and 12.
    Full,
}

const TEMPLATE: &str = include_str!("../demo/chapel.toml.in");

/// The chapel as a scene file.
pub fn chapel_text(size: Size) -> String {
    let (patch, cells) = match size {
        Size::Small => ("0.9", "[7, 12, 5]"),
        Size::Full => ("0.5", "[14, 24, 10]"),
    };
    TEMPLATE.replace("PATCH", patch).replace("CELLS", cells)
}

impl Which {
    fn word(self) -> &'static str {
        match self {
            Which::Chapel => "chapel",
            Which::Church => "church",
        }
    }
    fn about(self) -> &'static str {
        match self {
            Which::Chapel => "A chapel of 6 m × 10 m: stained glass, dusty air, the sun falling in.",
            Which::Church => {
                "A church of nave, aisles and apse: ribbed vaults, stained glass, dusty air; sun, sky and candles."
            }
        }
    }
    /// Writes the scene as `path`, and its mesh beside it.
    fn write(self, size: Size, path: &Path) -> Result<(), Failure> {
        let text = match self {
            Which::Chapel => chapel_text(size),
            Which::Church => {
                let (plan, patch, cell) = match size {
                    Size::Small => (church::Plan::SMALL, 0.9, 0.75),
                    Size::Full => (church::Plan::FULL, 0.29, 0.179),
                };
                let mesh = path.with_extension("glb");
                super::check_output(&mesh, &["glb"])?;
                output::write_glb(&mesh, &church::glb_model(&church::build(&plan)))?;
                let name = mesh.file_name().unwrap_or_default().to_string_lossy().replace(['"', '\\'], "_");
                church::scene_text(&plan, &name, patch, cell)
            }
        };
        output::write_bytes(path, text.as_bytes())?;
        Ok(())
    }
    /// The scene, read as everyone's is; the church by way of its files in the folder.
    fn scene(self, size: Size, folder: &Path) -> Result<Scene, Failure> {
        match self {
            Which::Chapel => Ok(input::parse_scene(&chapel_text(size), None, "the embedded chapel")?),
            Which::Church => {
                let path = folder.join("church.toml");
                super::check_output(&path, &["toml"])?;
                self.write(size, &path)?;
                Ok(input::read_scene(&path)?)
            }
        }
    }
    fn picture_name(self, camera: &str) -> String {
        match self {
            Which::Chapel => format!("{camera}.png"),
            Which::Church => format!("church-{camera}.png"),
        }
    }
    /// How its pictures are developed: hazy air gets its depth back, windows glow a little.
    fn look(self) -> render::Look {
        match self {
            Which::Chapel => render::Look::default(),
            Which::Church => render::Look { contrast: 1.7, bloom: 0.06, stops: -0.4 },
        }
    }
    /// Pixels of the pictures.
    fn picture(self, size: Size) -> (usize, usize) {
        match (self, size) {
            (Which::Chapel, Size::Small) => (160, 120),
            (Which::Chapel, Size::Full) => (640, 480),
            (Which::Church, Size::Small) => (240, 150),
            (Which::Church, Size::Full) => (1280, 800),
        }
    }
}

/// Runs the command.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    let which = args.scene;
    if let Some(path) = &args.write {
        super::check_output(path, &["toml"])?;
        which.write(args.size, path)?;
        say(&format!("scene written: {}", path.display()))?;
        return Ok(());
    }
    std::fs::create_dir_all(&args.output).map_err(|e| {
        Failure::new(format!(
            "{}: the folder cannot be made ({e}); choose another with --output",
            args.output.display()
        ))
    })?;
    let run = args.output.join(format!("{}.npz", which.word()));
    super::check_output(&run, &["npz"])?;
    let start = std::time::Instant::now();
    let scene = which.scene(args.size, &args.output)?;
    let picture = |camera: &str| args.output.join(which.picture_name(camera));
    scene.cameras().iter().try_for_each(|c| super::check_output(&picture(&c.name), &["png"]))?;
    let meter = Meter::new(context.quiet);
    let solution = solve::solved(scene, 12 << 30, args.factors.settings(), &meter)?;
    let solved = start.elapsed().as_secs_f64();
    output::write_solution(&run, &solution)?;
    let pixels = which.picture(args.size);
    let mut pictures = Vec::new();
    for camera in solution.scene.cameras() {
        let path = picture(&camera.name);
        let image = render::draw(&solution, camera, pixels, render::ADAPTIVE, &meter);
        render::save(&path, image, &which.look())?;
        pictures.push(path.display().to_string());
    }
    output::remove_stale(&args.output);
    let total = start.elapsed().as_secs_f64();
    if context.json {
        let mut json = output::report_json(&solution);
        json["pictures"] = pictures.into();
        json["solution"] = run.display().to_string().into();
        json["seconds"] = serde_json::json!({ "solve": solved, "total": total });
        say(&format!("{json:#}"))?;
        return Ok(());
    }
    say(&format!("{}\n", which.about()))?;
    say(table::report(&solution).trim_end())?;
    say(&format!("time\n  solve {solved:.1} s, with pictures {total:.1} s\nwritten"))?;
    say(&format!("  {}   (numpy opens it)", run.display()))?;
    pictures.iter().try_for_each(|p| say(&format!("  {p}")))?;
    let (look, plain) = (which.look(), render::Look::default());
    let flags = [
        (look.contrast, plain.contrast, "--contrast"),
        (look.bloom, plain.bloom, "--bloom"),
        (look.stops, plain.stops, "--stops"),
    ];
    let flags = flags.into_iter().filter(|(x, plain, _)| x != plain);
    let flags: String = flags.map(|(x, _, flag)| format!(" {flag} {x}")).collect();
    say(&format!(
        "\nnext\n  zonal render {} --camera aisle --size 1280x960{flags} -o aisle.png",
        run.display()
    ))?;
    say(&format!(
        "  zonal demo {} --write {}.toml    the scene, to change; then zonal check, solve, render",
        which.word(),
        which.word()
    ))?;
    say(&format!("  zonal export {} -o zones.csv", run.display()))?;
    Ok(())
}
