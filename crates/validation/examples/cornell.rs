//! Draws Mitsuba's Cornell box in vacuum and in haze from its own camera, compares with Mitsuba's pictures, and writes
//! `docs/cornell.md` with the pictures side by side.
//!
//! `cargo run --release --example cornell -- [--cases cbox_vacuum,cbox_smoke] [--data ../shared/data] [--size MM] [--cells N]
//! [--engine auto] [--tolerance 0.03] [-o docs]`
//!
//! Compared are the means of each channel, and 8×8 blocks: the root mean square of their relative difference over the blocks in
//! which every pixel, and every pixel around it, sees the same face, so that no silhouette or crease is inside. Of the smoke the means
//! below its dark band are reported as well: there Mitsuba's picture loses unoccluded light (`docs/path-tracer.md`).

#[path = "common/cornell.rs"]
mod boxes;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use zonal_io::{input, output};
use zonal_render::{Image, RenderOptions, render};
use zonal_scene::{Camera, NoProgress, Scene, Solution};
use zonal_transport::Transport;

/// Medium in the box.
enum MediumFilling {
    /// Nothing.
    Vacuum,
    /// Extinction in 1/mm and albedo.
    Haze(f64, &'static str),
    /// The smoke of `data/smoke-vdb`, without the boxes.
    Smoke,
}

struct CornellCase {
    reference: &'static str,
    filling: MediumFilling,
}

const CORNELL_CASES: [CornellCase; 4] = [
    CornellCase { reference: "cbox_vacuum", filling: MediumFilling::Vacuum },
    CornellCase { reference: "cbox_homog_st0.002_a08", filling: MediumFilling::Haze(0.002, "0.8") },
    CornellCase {
        reference: "cbox_homog_st0.001_argb",
        filling: MediumFilling::Haze(0.001, "[0.95, 0.6, 0.3]"),
    },
    CornellCase { reference: "cbox_smoke", filling: MediumFilling::Smoke },
];
/// The upper rows of Mitsuba's smoke, in which it loses the light of the lamp.
const SMOKE_ROWS: usize = 40;

fn scene_text(c: &CornellCase, data: &Path, solve: &str, cells: usize) -> String {
    let smoke = matches!(c.filling, MediumFilling::Smoke);
    let contents = if smoke { boxes::BoxContents::Empty } else { boxes::BoxContents::Boxes };
    let room = boxes::cornell(c.reference, &data.join("cornell/mitsuba-cbox/meshes"), contents, solve);
    room + &match c.filling {
        MediumFilling::Vacuum => String::new(),
        MediumFilling::Haze(extinction, albedo) => boxes::haze(extinction, albedo, cells),
        // The file's own cells; Mitsuba takes the nearest.
        MediumFilling::Smoke => format!(
            "[medium]\nmin = [141, 5, 145]\nmax = [411, 535, 415]\ncells = [28, 56, 29]\n[[medium.region]]\n\
             density = {{ file = {:?}, min = [141, 5, 145], max = [411, 535, 415], scale = 0.01 }}\nalbedo = 0.9\n",
            data.join("smoke-vdb/smoke_28x56x29.vol").display().to_string()
        ),
    }
}

const PICTURE_PIXELS: usize = 128;
const BLOCK_PIXELS: usize = 8;

/// The face that a pixel's centre sees, None beyond the scene.
fn faces(scene: &Scene, camera: &Camera) -> Vec<Option<(usize, [i64; 3])>> {
    let transport = Transport::new(scene);
    let forward = (camera.target - camera.origin).normalized();
    let right = forward.cross(camera.up).normalized();
    let up = right.cross(forward);
    let half = (camera.fov.to_radians() * 0.5).tan();
    (0..PICTURE_PIXELS * PICTURE_PIXELS)
        .map(|i| {
            let at = |k: usize| (2.0 * (k as f64 + 0.5) / PICTURE_PIXELS as f64 - 1.0) * half;
            let dir = (forward + right * at(i % PICTURE_PIXELS) - up * at(i / PICTURE_PIXELS)).normalized();
            let hit = transport.closest_hit(camera.origin, dir, 1e-6, 1e9)?;
            let f = &scene.facets()[hit.facet];
            Some((f.surface, f.plate.normal().array().map(|x| (x * 1e3).round() as i64)))
        })
        .collect()
}

/// By how much the means of the bands differ.
fn means(ours: &[[f32; 3]], theirs: &[[f32; 3]]) -> [f64; 3] {
    let sum = |p: &[[f32; 3]], b: usize| p.iter().map(|c| c[b] as f64).sum::<f64>();
    [0, 1, 2].map(|b| sum(ours, b) / sum(theirs, b) - 1.0)
}

struct PictureDifference {
    means: [f64; 3],
    blocks: [f64; 3],
    count: usize,
    noise: f64,
}

fn compare(
    ours: &Image,
    theirs: &[[f32; 3]],
    stderr: &[[f32; 3]],
    faces: &[Option<(usize, [i64; 3])>],
    lamp: usize,
) -> PictureDifference {
    let n = PICTURE_PIXELS / BLOCK_PIXELS;
    let means = means(&ours.pixels, theirs);
    let (mut squares, mut count, mut noise) = ([0.0; 3], 0, 0.0);
    for block in 0..n * n {
        let (bx, by) = (block % n * BLOCK_PIXELS, block / n * BLOCK_PIXELS);
        let pixels: Vec<usize> = (0..BLOCK_PIXELS * BLOCK_PIXELS)
            .map(|k| (by + k / BLOCK_PIXELS) * PICTURE_PIXELS + bx + k % BLOCK_PIXELS)
            .collect();
        let Some(first) = faces[pixels[0]] else { continue };
        // One pixel around the block as well: an edge within half a pixel of a pixel's centre is a silhouette in it.
        let ring = |at: usize| at.saturating_sub(1)..(at + BLOCK_PIXELS + 1).min(PICTURE_PIXELS);
        let same = ring(by).all(|y| ring(bx).all(|x| faces[y * PICTURE_PIXELS + x] == Some(first)));
        if first.0 == lamp || !same {
            continue;
        }
        count += 1;
        if std::env::var_os("ZONAL_BLOCKS").is_some() {
            let sum = |p: &[[f32; 3]]| {
                pixels.iter().map(|&i| p[i][0] as f64 + p[i][1] as f64 + p[i][2] as f64).sum::<f64>()
            };
            eprintln!(
                "block at ({bx}, {by}): {:+.2} % of {:.4}",
                100.0 * (sum(&ours.pixels) / sum(theirs) - 1.0),
                sum(theirs) / 192.0
            );
        }
        for b in 0..3 {
            let sum = |p: &[[f32; 3]]| pixels.iter().map(|&i| p[i][b] as f64).sum::<f64>();
            squares[b] += (sum(&ours.pixels) / sum(theirs) - 1.0).powi(2);
            let error: f64 = pixels.iter().map(|&i| (stderr[i][b] as f64).powi(2)).sum();
            noise += error / sum(theirs).powi(2) / 3.0;
        }
    }
    PictureDifference {
        means,
        blocks: squares.map(|s| (s / count.max(1) as f64).sqrt()),
        count,
        noise: (noise / count.max(1) as f64).sqrt(),
    }
}

/// Ours, theirs, and four times the difference about grey.
fn side_by_side(
    path: &Path,
    ours: &Image,
    theirs: &[[f32; 3]],
    exposure: f64,
) -> Result<(), Box<dyn std::error::Error>> {
    const MAGNIFICATION: usize = 2;
    let (w, h) = (3 * PICTURE_PIXELS * MAGNIFICATION, PICTURE_PIXELS * MAGNIFICATION);
    let pixels: Vec<[f32; 3]> = (0..w * h)
        .map(|i| {
            let (x, y) = (i % w / MAGNIFICATION, i / w / MAGNIFICATION);
            let k = y * PICTURE_PIXELS + x % PICTURE_PIXELS;
            match x / PICTURE_PIXELS {
                0 => ours.pixels[k],
                1 => theirs[k],
                _ => [0, 1, 2]
                    .map(|b| (0.18 / exposure as f32 + 4.0 * (ours.pixels[k][b] - theirs[k][b])).max(0.0)),
            }
        })
        .collect();
    Ok(output::write_png(path, w, h, &pixels, &output::ToneMapping::filmic(exposure))?)
}

fn signed_percent(x: f64) -> String {
    format!("{:+.2} %", 100.0 * x)
}

/// Compares a picture with the reference, apart from the lamp.
fn difference(
    solution: &Solution,
    image: &Image,
    theirs: &[[f32; 3]],
    stderr: &[[f32; 3]],
) -> PictureDifference {
    let camera = &solution.scene.cameras()[0];
    let lamp =
        solution.scene.surfaces().iter().position(|s| s.name.starts_with("luminaire")).unwrap_or(usize::MAX);
    compare(image, theirs, stderr, &faces(&solution.scene, camera), lamp)
}

fn table_line(c: &CornellCase, zones: usize, d: &PictureDifference) -> String {
    let percent = signed_percent;
    format!(
        "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n",
        c.reference,
        zones,
        percent(d.means[0]),
        percent(d.means[1]),
        percent(d.means[2]),
        percent(d.blocks[0]),
        percent(d.blocks[1]),
        percent(d.blocks[2]),
        percent(d.noise),
        d.count
    )
}

/// Title and head of the table of the page.
const PAGE_HEAD: &str = "# The Cornell box against Mitsuba 3\n\nWritten by `cargo run --release --example cornell -- -o docs`. The same camera, lamp, walls and medium; Mitsuba's pictures are path-traced.\nEach row of pictures: ours, Mitsuba's, and four times the difference about grey.\n\n| picture | zones | mean R | mean G | mean B | blocks R | blocks G | blocks B | blocks' own noise | blocks compared |\n|---|---|---|---|---|---|---|---|---|---|\n";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let option =
        |name: &str| arguments.iter().position(|a| a == name).and_then(|k| arguments.get(k + 1).cloned());
    let data = std::fs::canonicalize(option("--data").unwrap_or("../shared/data".into()))?;
    let size: f64 = option("--size").unwrap_or("40".into()).parse()?;
    let cells: usize = option("--cells").unwrap_or("14".into()).parse()?;
    let engine = option("--engine").unwrap_or("auto".into());
    let tolerance: f64 = option("--tolerance").unwrap_or("0.03".into()).parse()?;
    let solve =
        format!("patch_size = {size}\nclosure = \"restore\"\nengine = \"{engine}\"\ntolerance = {tolerance}");
    let chosen = option("--cases");
    let out = option("-o").map(PathBuf::from);
    let mut page = PAGE_HEAD.to_string();
    let mut pictures = String::new();
    print!("{page}");
    for c in CORNELL_CASES
        .iter()
        .filter(|c| chosen.as_ref().is_none_or(|l| l.split(',').any(|n| n == c.reference)))
    {
        let text = scene_text(c, &data, &solve, cells);
        let scene = input::parse_scene(&text, Some(&data), c.reference)?;
        let solution: Solution = zonal_solve::solve(scene, 16 << 30, &NoProgress)?;
        let camera = &solution.scene.cameras()[0];
        let options = RenderOptions {
            width: PICTURE_PIXELS,
            height: PICTURE_PIXELS,
            samples: 16,
            ..RenderOptions::default()
        };
        let image = render(&solution, camera, &options, &NoProgress);
        let refs = data.join("mitsuba-refs");
        let theirs = output::read_exr(&refs.join(format!("{}.exr", c.reference)))?;
        let stderr = output::read_exr(&refs.join(format!("{}_stderr.exr", c.reference)))?;
        let d = difference(&solution, &image, &theirs.pixels, &stderr.pixels);
        let line = table_line(c, solution.zones.len(), &d);
        print!("{line}");
        page.push_str(&line);
        if matches!(c.filling, MediumFilling::Smoke) {
            let first = SMOKE_ROWS * PICTURE_PIXELS;
            let below =
                means(&image.pixels[first..], &theirs.pixels[first..]).map(signed_percent).join(" | ");
            let rest = format!("| its lower {} rows | | {below} | | | | | |\n", PICTURE_PIXELS - SMOKE_ROWS);
            print!("{rest}");
            page.push_str(&rest);
        }
        if let Some(folder) = &out {
            let name = format!("cornell-{}.png", c.reference);
            side_by_side(&folder.join(&name), &image, &theirs.pixels, output::auto_exposure(&theirs.pixels))?;
            let _ = write!(pictures, "\n## {}\n\n![ours, Mitsuba's, difference]({name})\n", c.reference);
        }
    }
    if let Some(folder) = &out {
        output::write_bytes(&folder.join("cornell.md"), (page + &pictures).as_bytes())?;
    }
    Ok(())
}
