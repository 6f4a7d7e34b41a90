//! `zonal demo`: solves and draws a built-in scene.

use crate::commands::context::Context;
use crate::table;
use std::path::{Path, PathBuf};
use std::time::Instant;
use zonal_app::pictures::{PictureStyle, save};
use zonal_app::quality::Quality;
use zonal_app::solving::{VoxelFactors, solve_and_hash};
use zonal_app::timeline::{READING, WRITING};
use zonal_demo::{chapel_text, church};
use zonal_io::{input, output};
use zonal_report::{Failure, check_output, say};
use zonal_scene::{Scene, Solution};
use zonal_solve::SolveSettings;
use zonal_solve::settings::DEFAULT_MEMORY_LIMIT;

/// Solve and draw a built-in scene with stained glass and dusty air.
///
/// bays, two bays of a church, takes less than a minute. chapel is one room, and its scene file has no mesh. church is generated at the size of the paper's
/// pictures (a hundred thousand patches, one and a half million voxels) and takes long; with --size small it has two bays.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Scene.
    #[arg(value_enum, default_value_t = DemoScene::Bays)]
    pub scene: DemoScene,
    /// Resolution of zones and pictures.
    #[arg(long, value_enum, default_value_t = DemoSize::Full)]
    pub size: DemoSize,
    /// Formula of the exchange factor of two voxels, as of `zonal solve`.
    #[arg(long, value_enum, default_value_t = VoxelFactors::Exact, value_name = "FORMULA")]
    pub factors: VoxelFactors,
    /// Folder of the solution and the pictures; created if missing.
    #[arg(long, short, default_value = "zonal-demo", value_name = "DIR")]
    pub output: PathBuf,
    /// Write the scene (.toml) and its mesh (.glb beside it, if it has one) without solving: a template for scenes of your own.
    #[arg(long, value_name = "SCENE.toml")]
    pub write: Option<PathBuf>,
}

/// A built-in scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum DemoScene {
    /// Two bays of the church.
    Bays,
    /// One room of 6 m × 10 m.
    Chapel,
    /// Nave, aisles and apse, 34 m long.
    Church,
}

/// Resolution of a built-in scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum DemoSize {
    /// For tests: seconds for bays and chapel, two bays of the church.
    Small,
    /// Pictures to look at; those of the chapel as figure 10 of the paper, those of the church as its figures 11 and 12.
    Full,
}

impl From<DemoSize> for zonal_demo::Size {
    fn from(size: DemoSize) -> zonal_demo::Size {
        match size {
            DemoSize::Small => zonal_demo::Size::Small,
            DemoSize::Full => zonal_demo::Size::Full,
        }
    }
}

impl DemoScene {
    fn name(self) -> &'static str {
        match self {
            DemoScene::Bays => "bays",
            DemoScene::Chapel => "chapel",
            DemoScene::Church => "church",
        }
    }
    fn description(self) -> &'static str {
        match self {
            DemoScene::Bays => {
                "Two bays of a church with aisles and apse, stained glass and dusty air; sun, sky and candles."
            }
            DemoScene::Chapel => "A chapel of 6 m × 10 m with stained glass, dusty air and sunlight.",
            DemoScene::Church => {
                "A church of nave, aisles and apse with ribbed vaults, stained glass and dusty air; sun, sky and candles."
            }
        }
    }
    /// Plan of a church and size of its zones; `None` for a scene without a mesh.
    fn plan(self, size: DemoSize) -> Option<(church::ChurchPlan, church::ChurchResolution)> {
        let resolution =
            |patch, cell, tolerance, closure| church::ChurchResolution { patch, cell, tolerance, closure };
        match (self, size) {
            (DemoScene::Chapel, _) => None,
            (DemoScene::Bays, DemoSize::Small) => {
                Some((church::ChurchPlan::TWO_BAYS, resolution(1.2, 1.0, 0.25, "restore")))
            }
            (DemoScene::Church, DemoSize::Small) => {
                Some((church::ChurchPlan::TWO_BAYS, resolution(0.9, 0.75, 0.12, "measure")))
            }
            (DemoScene::Bays, DemoSize::Full) => {
                Some((church::ChurchPlan::TWO_FINE_BAYS, resolution(0.45, 0.5, 0.25, "restore")))
            }
            (DemoScene::Church, DemoSize::Full) => {
                Some((church::ChurchPlan::SIX_BAYS, resolution(0.29, 0.179, 0.12, "measure")))
            }
        }
    }
    /// Writes the scene as `path`, and its mesh beside it.
    fn write(self, size: DemoSize, path: &Path) -> Result<(), Failure> {
        let text = match self.plan(size) {
            None => chapel_text(size.into()),
            Some((plan, resolution)) => {
                let mesh = path.with_extension("glb");
                check_output(&mesh, &["glb"])?;
                output::write_glb(&mesh, &church::glb_model(&church::build(&plan)))?;
                let name = mesh.file_name().unwrap_or_default().to_string_lossy().replace(['"', '\\'], "_");
                church::scene_text(&plan, &name, &resolution)
            }
        };
        Ok(output::write_bytes(path, text.as_bytes())?)
    }
    /// The scene; that of a church is read from its files in the folder.
    fn read(self, size: DemoSize, folder: &Path) -> Result<Scene, Failure> {
        if self == DemoScene::Chapel {
            return Ok(input::parse_scene(&chapel_text(size.into()), None, "the embedded chapel")?);
        }
        let path = folder.join(format!("{}.toml", self.name()));
        check_output(&path, &["toml"])?;
        self.write(size, &path)?;
        Ok(input::read_scene(&path)?)
    }
    fn picture_name(self, camera: &str) -> String {
        match self {
            DemoScene::Chapel => format!("{camera}.png"),
            DemoScene::Bays | DemoScene::Church => format!("{}-{camera}.png", self.name()),
        }
    }
    /// Number of cameras whose pictures are drawn, at most.
    fn picture_count(self) -> usize {
        if self == DemoScene::Bays { 2 } else { usize::MAX }
    }
    /// Tone of the pictures: contrast against haze, bloom of the windows.
    fn picture_style(self) -> PictureStyle {
        match self {
            DemoScene::Chapel => PictureStyle::default(),
            DemoScene::Bays | DemoScene::Church => PictureStyle { contrast: 1.7, bloom: 0.06, stops: -0.4 },
        }
    }
    /// Pixels across and down of the pictures.
    fn picture_size(self, size: DemoSize) -> (usize, usize) {
        match (self, size) {
            (DemoScene::Chapel, DemoSize::Small) => (160, 120),
            (DemoScene::Chapel, DemoSize::Full) => (640, 480),
            (DemoScene::Bays | DemoScene::Church, DemoSize::Small) => (240, 150),
            (DemoScene::Bays, DemoSize::Full) => (800, 500),
            (DemoScene::Church, DemoSize::Full) => (1280, 800),
        }
    }
}

/// Files and times of a demo.
struct DemoRun {
    solution: Solution,
    solution_path: PathBuf,
    pictures: Vec<String>,
    solve_seconds: f64,
    total_seconds: f64,
}

/// Runs the command.
///
/// # Errors
/// If an output cannot be written.
pub fn run(args: &Args, context: Context) -> Result<(), Failure> {
    if let Some(path) = &args.write {
        check_output(path, &["toml"])?;
        args.scene.write(args.size, path)?;
        return say(&format!("scene written: {}", path.display()));
    }
    let run = solve_and_draw(args, context)?;
    if context.json {
        let mut json = output::report_json(&run.solution);
        json["pictures"] = run.pictures.into();
        json["solution"] = run.solution_path.display().to_string().into();
        json["seconds"] = serde_json::json!({ "solve": run.solve_seconds, "total": run.total_seconds });
        return context.say_json(json);
    }
    print_report(args.scene, &run)
}

/// Solves the scene and draws it from all of its cameras.
fn solve_and_draw(args: &Args, context: Context) -> Result<DemoRun, Failure> {
    // Check all outputs before the solve.
    std::fs::create_dir_all(&args.output).map_err(|e| {
        Failure::new(format!(
            "{}: the folder cannot be created ({e}); choose another with --output",
            args.output.display()
        ))
    })?;
    let solution_path = args.output.join(format!("{}.npz", args.scene.name()));
    check_output(&solution_path, &["npz"])?;
    let start = Instant::now();
    let scene = context.in_stage(READING, || args.scene.read(args.size, &args.output))?;
    let picture_path = |camera: &str| args.output.join(args.scene.picture_name(camera));
    let mut drawn = scene.cameras().iter().take(args.scene.picture_count());
    drawn.try_for_each(|c| check_output(&picture_path(&c.name), &["png"]))?;
    // Solve.
    let progress = context.progress();
    let settings = SolveSettings {
        pair_settings: args.factors.pair_settings(),
        ..SolveSettings::new(DEFAULT_MEMORY_LIMIT, &progress)
    };
    let solution = solve_and_hash(scene, &settings)?;
    let solve_seconds = start.elapsed().as_secs_f64();
    context.in_stage(WRITING, || output::write_solution(&solution_path, &solution))?;
    // Draw.
    let mut pictures = Vec::new();
    for camera in solution.scene.cameras().iter().take(args.scene.picture_count()) {
        let path = picture_path(&camera.name);
        let size = args.scene.picture_size(args.size);
        let image = zonal_render::render(&solution, camera, &Quality::Normal.of_picture(size), &progress);
        save(&path, image, &args.scene.picture_style())?;
        pictures.push(path.display().to_string());
    }
    output::remove_stale_temporaries(&args.output);
    let total_seconds = start.elapsed().as_secs_f64();
    Ok(DemoRun { solution, solution_path, pictures, solve_seconds, total_seconds })
}

/// Prints the report, the files and some commands to go on with.
fn print_report(scene: DemoScene, run: &DemoRun) -> Result<(), Failure> {
    let (name, path) = (scene.name(), run.solution_path.display());
    say(&format!("{}\n", scene.description()))?;
    say(table::report(&run.solution).trim_end())?;
    say(&format!(
        "time\n  solve {:.1} s, with pictures {:.1} s\nwritten",
        run.solve_seconds, run.total_seconds
    ))?;
    say(&format!("  {path}   (numpy.load opens it)"))?;
    run.pictures.iter().try_for_each(|p| say(&format!("  {p}")))?;
    let (style, plain) = (scene.picture_style(), PictureStyle::default());
    let flags = [
        (style.contrast, plain.contrast, "--contrast"),
        (style.bloom, plain.bloom, "--bloom"),
        (style.stops, plain.stops, "--stops"),
    ];
    let flags = flags.into_iter().filter(|(x, plain, _)| x != plain);
    let flags: String = flags.map(|(x, _, flag)| format!(" {flag} {x}")).collect();
    say(&format!("\nnext\n  zonal render {path} --camera aisle --size 1280x960{flags} -o aisle.png"))?;
    say(&format!(
        "  zonal demo {name} --write {name}.toml    the scene, to edit; then zonal check, solve, render"
    ))?;
    say(&format!("  zonal export {path} -o zones.csv"))
}
