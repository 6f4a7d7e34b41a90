//! Final gather against interpolated pictures.
//!
//! Guards (pictures): approximations of the renderer agree with exact evaluation: many lights, adaptive pictures, final gather.

use crate::support;

use support::Folder;

const CLOSED: &str = "name = 'closed'
[solve]
patch_size = 0.2
[[surface]]
name = 'room'
room = { min = [0, 0, 0], max = [2, 2, 1.5] }
reflectance = [0.6, 0.5, 0.4]
faces.z1 = { emission = 100 }
[medium]
min = [0, 0, 0]
max = [2, 2, 1.5]
cells = [10, 10, 8]
extinction = 0.3
albedo = 0.7
[[camera]]
name = 'corner'
origin = [0.3, 0.4, 1.1]
target = [1.6, 1.5, 0.4]
fov = 80
";

/// Means of blocks of 8 × 8 pixels, all bands together.
fn blocks(f: &Folder, name: &str) -> Vec<f64> {
    let picture = zonal_io::output::read_exr(&f.path().join(name)).unwrap();
    let across = picture.width / 8;
    let mut out = vec![0.0; across * (picture.height / 8)];
    for (i, p) in picture.pixels.iter().enumerate() {
        let (x, y) = (i % picture.width, i / picture.width);
        out[y / 8 * across + x / 8] += p.iter().sum::<f32>() as f64 / 192.0;
    }
    out
}

#[test]
fn final_gather_keeps_block_means_of_a_closed_room() {
    let f = Folder::new();
    f.put("closed.toml", CLOSED);
    f.done(&["solve", "closed.toml", "-o", "closed.npz"]);
    let draw = |more: &[&str], name: &str| {
        let args = ["render", "closed.npz", "--size", "64x48", "-o", name];
        f.done(&[&args, more].concat());
        blocks(&f, name)
    };
    let interpolated = draw(&[], "plain.exr");
    let gathered = draw(&["--gather", "256"], "gathered.exr");
    let with_threads = draw(&["--gather", "256", "--threads", "3"], "again.exr");
    assert_eq!(gathered, with_threads);
    let differences: Vec<f64> =
        interpolated.iter().zip(&gathered).map(|(p, g)| (g / p - 1.0).abs()).collect();
    let mean = differences.iter().sum::<f64>() / differences.len() as f64;
    let worst = differences.iter().fold(0.0f64, |m, d| m.max(*d));
    assert!(mean < 0.005 && worst < 0.02, "{mean} {worst}");
    assert_ne!(interpolated, gathered);
}
