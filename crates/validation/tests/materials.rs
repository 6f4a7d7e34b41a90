//! The scene of `scenes/leaf.toml` (a leaf with the alpha of a picture that transmits diffusely, a lattice, frosted glass) against the path tracer.

use std::path::Path;
use zonal_io::input::read_scene;
use zonal_reference::path_tracer::PathTracer;
use zonal_render::{RenderOptions, render};
use zonal_scene::{Bands, NoProgress, Scene, SolveOptions};

const SIZE: [usize; 2] = [48, 32];
const BLOCK: usize = 8;
/// Paths of a pixel; 64 pixels make a block.
const PATHS: usize = 128;

fn leaf() -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/leaf.toml");
    read_scene(path).unwrap_or_else(|e| panic!("{e}"))
}

/// Sums over blocks of pixels.
fn blocks(value: impl Fn(usize) -> Bands) -> Vec<Bands> {
    let across = SIZE[0] / BLOCK;
    let mut out = vec![Bands::ZERO; across * (SIZE[1] / BLOCK)];
    for i in 0..SIZE[0] * SIZE[1] {
        let (x, y) = (i % SIZE[0], i / SIZE[0]);
        out[y / BLOCK * across + x / BLOCK] += value(i);
    }
    out
}

#[test]
fn a_leaf_and_frosted_glass_agree_with_the_path_tracer() {
    let scene = leaf();
    let camera = scene.cameras()[0].clone();
    // A coarser solve than the scene asks for, for the time of the test.
    let options = SolveOptions { tolerance: 0.05, ..scene.options().clone() };
    let scene = scene.with_options(options).unwrap_or_else(|e| panic!("{e}"));
    let solution = zonal_solve::solve(scene.clone(), 4 << 30, &NoProgress).unwrap_or_else(|e| panic!("{e}"));
    let options = RenderOptions { width: SIZE[0], height: SIZE[1], samples: 16, ..RenderOptions::default() };
    let drawn = render(&solution, &camera, &options, &NoProgress);
    let traced = PathTracer::new(&scene).picture(&camera, SIZE[0], SIZE[1], PATHS, 5);
    let ours = blocks(|i| Bands::from_rgb(drawn.pixels[i].map(f64::from)));
    let theirs = blocks(|i| traced.mean[i]);
    let squares = blocks(|i| traced.error[i] * traced.error[i]);
    let (mut beyond, mut worst) = (0, 0.0f64);
    for ((a, b), square) in ours.iter().zip(&theirs).zip(squares) {
        // All bands together: the noise of the bands of a path is common.
        let (a, b, sigma) = (a.mean(), b.mean(), square.sqrt().mean());
        let off = (a - b).abs() - 2.0 * sigma;
        worst = worst.max(off / b);
        beyond += usize::from(off > 0.02 * b);
    }
    println!("{beyond} of {} blocks beyond 2 % + 2 σ, the worst by {worst:.4}", ours.len());
    assert!(beyond <= 1 && worst < 0.03, "{beyond} blocks, {worst}");
    let energy = &solution.report.energy;
    assert!(energy.residual.all(|r| r.abs() < 0.02), "{:?}", energy.residual);
}
