//! Pictures of solutions against reference pictures with standard errors.
//!
//! `cornell` draws Mitsuba's Cornell box in vacuum and in haze from its own camera, compares with Mitsuba's pictures, and writes `cornell.md` with
//! the pictures side by side. Compared are the means of each channel, and 8×8 blocks: the root mean square of their relative difference over
//! the blocks in which every pixel, and every pixel around it, sees the same face, so that no silhouette or crease is inside. Of the smoke the
//! means below its dark band are reported as well: there Mitsuba's picture loses unoccluded light (`docs/path-tracer.md`).
//!
//! `picture` draws a solution, or takes a picture, and compares its means and blocks.

use crate::harness::pictures::{BLOCK_PIXELS, MeasuredPicture, PictureBlock};
use crate::harness::{Error, Outcome, SharedData, is_wanted, signed_percent};
use crate::scenes::cornell::{self, BoxMedium, CORNELL_BOXES, SMOKE_ROWS};
use std::path::PathBuf;
use zonal_io::{input, output};
use zonal_render::{Image, RenderOptions, render};
use zonal_scene::{NoProgress, Scene, Solution};
use zonal_transport::Transport;

/// Pixels along an edge of Mitsuba's pictures of the Cornell box.
const CORNELL_PIXELS: usize = 128;
/// The largest memory of a solve, bytes.
const MAX_MEMORY: u64 = 16 << 30;

#[derive(clap::Args)]
pub(crate) struct CornellCampaign {
    #[command(flatten)]
    data: SharedData,
    /// Names of boxes; all by default
    #[arg(long, value_delimiter = ',')]
    cases: Vec<String>,
    /// Largest patch, mm
    #[arg(long, default_value_t = 40.0)]
    size: f64,
    /// Cells of haze along an edge
    #[arg(long, default_value_t = 14)]
    cells: usize,
    #[arg(long, default_value = "auto")]
    engine: String,
    #[arg(long, default_value_t = 0.03)]
    tolerance: f64,
    /// Folder of the page and its pictures
    #[arg(short)]
    output: Option<PathBuf>,
}

const PAGE_HEAD: &str = "# The Cornell box against Mitsuba 3\n\nWritten by `cargo run --release -p zonal-campaigns -- cornell -o docs`. The same camera, lamp, walls and medium; Mitsuba's pictures are path-traced.\nEach row of pictures: ours, Mitsuba's, and four times the difference about grey.\n\n| picture | zones | mean R | mean G | mean B | blocks R | blocks G | blocks B | blocks' own noise | blocks compared |\n|---|---|---|---|---|---|---|---|---|---|\n";

impl CornellCampaign {
    pub(crate) fn run(&self) -> Outcome {
        let data = self.data.shared.join("data").canonicalize()?;
        let (mut page, mut pictures) = (PAGE_HEAD.to_string(), String::new());
        print!("{page}");
        for (name, medium) in CORNELL_BOXES.iter().filter(|c| is_wanted(&self.cases, c.0)) {
            let settings = format!(
                "patch_size = {}\nclosure = \"restore\"\nengine = \"{}\"\ntolerance = {}",
                self.size, self.engine, self.tolerance
            );
            let text = cornell::room(name, &data, *medium, &settings, cornell::FRONT_WALLS)
                + cornell::LAMP
                + &cornell::medium(*medium, &data, self.cells, cornell::SMOKE_FILE_CELLS);
            let scene = input::parse_scene(&text, Some(&data), name)?;
            let solution = zonal_solve::solve(scene, MAX_MEMORY, &NoProgress)?;
            let theirs = MeasuredPicture::read(&data.join("mitsuba-refs").join(name))?;
            let options = RenderOptions { samples: 16, ..RenderOptions::default() };
            let ours = draw(&solution, &theirs, None, options)?;
            let rows = table_rows(name, *medium, &solution, &ours, &theirs);
            print!("{rows}");
            page += &rows;
            if let Some(folder) = &self.output {
                let file = format!("cornell-{name}.png");
                theirs.write_side_by_side(&folder.join(&file), &ours.pixels, 1)?;
                pictures += &format!("\n## {name}\n\n![ours, Mitsuba's, difference]({file})\n");
            }
        }
        if let Some(folder) = &self.output {
            output::write_bytes(&folder.join("cornell.md"), (page + &pictures).as_bytes())?;
        }
        Ok(true)
    }
}

/// Draws a camera of a solution, by default the first, at the size of a reference.
fn draw(
    s: &Solution,
    theirs: &MeasuredPicture,
    camera: Option<&str>,
    options: RenderOptions,
) -> Result<Image, Error> {
    let camera = s.scene.cameras().iter().find(|c| camera.is_none_or(|name| name == c.name));
    let options = RenderOptions { width: theirs.mean.width, height: theirs.mean.height, ..options };
    Ok(render(s, camera.ok_or("the solution has no such camera")?, &options, &NoProgress))
}

/// The row of a box, and of the smoke's lower part.
fn table_rows(name: &str, medium: BoxMedium, s: &Solution, ours: &Image, theirs: &MeasuredPicture) -> String {
    let lamp = s.scene.surfaces().iter().position(|s| s.name.starts_with("luminaire"));
    let faces = faces(&s.scene);
    let even = |b: &&PictureBlock| {
        // One pixel around the block as well: an edge within half a pixel of a pixel's centre is a silhouette in it.
        let [xs, ys] = b.corner.map(|at| at.saturating_sub(1)..(at + BLOCK_PIXELS + 1).min(CORNELL_PIXELS));
        let seen = faces[b.corner[1] * CORNELL_PIXELS + b.corner[0]];
        seen.is_some_and(|f| Some(f.0) != lamp)
            && ys.into_iter().all(|y| xs.clone().all(|x| faces[y * CORNELL_PIXELS + x] == seen))
    };
    let blocks = theirs.blocks(&ours.pixels);
    let blocks: Vec<&PictureBlock> = blocks.iter().filter(even).collect();
    let rms = |of: &dyn Fn(&PictureBlock) -> f64| {
        (blocks.iter().map(|b| of(b)).sum::<f64>() / blocks.len().max(1) as f64).sqrt()
    };
    let of_band = [0, 1, 2].map(|k| rms(&|b| (b.ours[k] / b.theirs[k] - 1.0).powi(2)));
    let noise = rms(&|b| (0..3).map(|k| b.variance[k] / b.theirs[k].powi(2) / 3.0).sum());
    let cells = |x: [f64; 3]| x.map(signed_percent).join(" | ");
    let row = format!(
        "| {name} | {} | {} | {} | {} | {} |\n",
        s.zones.len(),
        cells(theirs.means(&ours.pixels, 0)),
        cells(of_band),
        signed_percent(noise),
        blocks.len()
    );
    if medium != BoxMedium::Smoke {
        return row;
    }
    let below = cells(theirs.means(&ours.pixels, SMOKE_ROWS * CORNELL_PIXELS));
    row + &format!("| its lower {} rows | | {below} | | | | | |\n", CORNELL_PIXELS - SMOKE_ROWS)
}

/// Surface and rounded normal of the face that the centre of each pixel sees; none beyond the scene.
fn faces(scene: &Scene) -> Vec<Option<(usize, [i64; 3])>> {
    let (transport, camera) = (Transport::new(scene), &scene.cameras()[0]);
    let forward = (camera.target - camera.origin).normalized();
    let right = forward.cross(camera.up).normalized();
    let up = right.cross(forward);
    let half = (camera.fov.to_radians() * 0.5).tan();
    let face = |i: usize| {
        let at = |k: usize| (2.0 * (k as f64 + 0.5) / CORNELL_PIXELS as f64 - 1.0) * half;
        let dir = (forward + right * at(i % CORNELL_PIXELS) - up * at(i / CORNELL_PIXELS)).normalized();
        let f = &scene.facets()[transport.closest_hit(camera.origin, dir, 1e-6, 1e9)?.facet];
        Some((f.surface, f.plate.normal().array().map(|x| (x * 1e3).round() as i64)))
    };
    (0..CORNELL_PIXELS * CORNELL_PIXELS).map(face).collect()
}

#[derive(clap::Args)]
pub(crate) struct ReferencePicture {
    /// Solution, or picture (.exr)
    run: PathBuf,
    /// Reference: radiances X.exr and their standard errors X_stderr.exr
    #[arg(long, value_name = "X")]
    against: PathBuf,
    #[arg(long)]
    camera: Option<String>,
    /// Samples a pixel
    #[arg(long, default_value_t = 4)]
    samples: usize,
    /// Samples of lights
    #[arg(long, default_value_t = 4)]
    lights: usize,
    /// Rays of the final gather
    #[arg(long, default_value_t = 0)]
    gather: usize,
    /// Blocks to list, by the size of their difference
    #[arg(long, default_value_t = 0)]
    worst: usize,
    /// Picture of both and of four times their difference in tiles of 4 × 4 pixels (.png)
    #[arg(short)]
    output: Option<PathBuf>,
}

impl ReferencePicture {
    pub(crate) fn run(&self) -> Outcome {
        let theirs = MeasuredPicture::read(&self.against)?;
        let (ours, size) = if self.run.extension().is_some_and(|e| e == "exr") {
            let p = output::read_exr(&self.run)?;
            (p.pixels, (p.width, p.height))
        } else {
            let options = RenderOptions {
                samples: self.samples,
                light_samples: self.lights,
                gather: self.gather,
                ..RenderOptions::default()
            };
            let solution = output::read_solution(&self.run)?;
            let p = draw(&solution, &theirs, self.camera.as_deref(), options)?;
            (p.pixels, (p.width, p.height))
        };
        if size != (theirs.mean.width, theirs.mean.height) {
            return Err("the two pictures differ in size".into());
        }
        print!("{}", self.lines(&ours, &theirs));
        if let Some(path) = &self.output {
            theirs.write_side_by_side(path, &ours, 4)?;
        }
        Ok(true)
    }

    /// Means, and blocks of all bands together.
    fn lines(&self, ours: &[[f32; 3]], theirs: &MeasuredPicture) -> String {
        struct Difference {
            corner: [usize; 2],
            relative: f64,
            sigma: f64,
        }
        let sum = |x: [f64; 3]| x.iter().sum::<f64>();
        let mut blocks: Vec<Difference> = (theirs.blocks(ours).into_iter())
            .filter(|b| sum(b.theirs) > 0.0)
            .map(|b| Difference {
                corner: b.corner,
                relative: sum(b.ours) / sum(b.theirs) - 1.0,
                sigma: sum(b.variance).sqrt() / sum(b.theirs),
            })
            .collect();
        blocks.sort_by(|a, b| a.relative.abs().total_cmp(&b.relative.abs()));
        let percentile = |p: f64| {
            let last = blocks.len().saturating_sub(1);
            100.0 * blocks.get((last as f64 * p).round() as usize).map_or(0.0, |b| b.relative.abs())
        };
        let count = |far: &dyn Fn(&Difference) -> bool| blocks.iter().filter(|b| far(b)).count();
        let noise = (blocks.iter().map(|b| b.sigma.powi(2)).sum::<f64>() / blocks.len().max(1) as f64).sqrt();
        let bands = |x: [f64; 3]| x.map(signed_percent).join(" ");
        let worst = blocks.iter().rev().take(self.worst).map(|b| {
            let sigmas = b.relative.abs() / b.sigma;
            format!(
                "  block at {:?}: {:+.1} %, {sigmas:.1} σ of the reference\n",
                b.corner,
                100.0 * b.relative
            )
        });
        format!(
            "means {}\n{} blocks of {BLOCK_PIXELS}×{BLOCK_PIXELS}: median {:.2} %, 95th percentile {:.2} %, largest {}, the reference's own noise {:.2} %\n{} beyond 5 % and two σ of the reference, {} beyond four σ\n{}",
            bands(theirs.means(ours, 0)),
            blocks.len(),
            percentile(0.5),
            percentile(0.95),
            signed_percent(blocks.last().map_or(0.0, |b| b.relative)),
            100.0 * noise,
            count(&|b| b.relative.abs() > 0.05 + 2.0 * b.sigma),
            count(&|b| b.relative.abs() > 4.0 * b.sigma),
            worst.collect::<String>()
        )
    }
}
