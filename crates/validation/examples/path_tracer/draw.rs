//! A camera's picture with its standard error.

use crate::{CommandArguments, CommandOutcome};
use std::path::Path;
use zonal_io::{input, output};
use zonal_reference::path_tracer::PathTracer;
use zonal_scene::Bands;

/// Draws the picture.
pub(crate) fn draw(arguments: &CommandArguments) -> CommandOutcome {
    let file =
        arguments.plain().ok_or("give the scene: path_tracer SCENE.toml --picture CAMERA -o OUT.exr")?;
    let out = Path::new(arguments.text("-o").ok_or("give -o OUT.exr")?);
    let scene = input::read_scene(Path::new(file))?;
    let name = arguments.text("--picture").unwrap_or_default();
    let camera = scene
        .cameras()
        .iter()
        .find(|c| c.name == name)
        .ok_or_else(|| format!("{file}: there is no camera '{name}'"))?;
    let size = arguments.text("--size").unwrap_or("320x240");
    let (width, height) = size
        .split_once('x')
        .and_then(|(w, h)| Some((w.parse::<usize>().ok()?, h.parse::<usize>().ok()?)))
        .filter(|(w, h)| (1..=1 << 14).contains(w) && (1..=1 << 14).contains(h))
        .ok_or_else(|| format!("--size {size}: give WIDTHxHEIGHT"))?;
    let mut tracer = PathTracer::new(&scene);
    if arguments.text("--max-bounces").is_some() {
        tracer = tracer.with_max_bounces(arguments.number("--max-bounces", 0)?);
    }
    let samples = arguments.number("--samples", 64)?;
    let picture = tracer.picture(camera, width, height, samples, arguments.number("--seed", 1)?);
    let narrow = |p: &[Bands]| p.iter().map(|c| c.to_rgb().map(|x| x as f32)).collect::<Vec<_>>();
    output::write_exr(out, width, height, &narrow(&picture.mean))?;
    let stem = out.file_stem().and_then(|s| s.to_str()).unwrap_or("picture");
    output::write_exr(
        &out.with_file_name(format!("{stem}_stderr.exr")),
        width,
        height,
        &narrow(&picture.error),
    )?;
    let mean = |p: &[Bands]| (p.iter().sum::<Bands>() / p.len() as f64).to_rgb();
    let (m, e) = (mean(&picture.mean), mean(&picture.error));
    println!("mean {m:.6?}, mean standard error {e:.6?} W/(m² sr)");
    Ok(true)
}
