//! Scenes with symmetry planes through the command: files and pictures of the part, and of the whole that it stands for.

use crate::support;

use support::{Folder, Program, refused};

/// A roofless room of smoke with a lamp and suns, or its half beside the symmetry plane x0.
fn room(is_half: bool) -> String {
    let low = if is_half { 0 } else { -1 };
    let (plane, omit) = if is_half { ("x0 = 'symmetry'", ", 'x0'") } else { ("", "") };
    let cells = if is_half { 2 } else { 4 };
    let sun = |name: &str, x: f64| {
        format!("[[light]]\nkind = 'sun'\nname = '{name}'\ndirection = [{x}, 0.2, -1]\nirradiance = 3\n")
    };
    let suns = if is_half { sun("sun", -0.4) } else { sun("sun", -0.4) + &sun("other", 0.4) };
    format!(
        "name = 'room'
[solve]
patch_size = 0.5
engine = 'dense'
[boundary]
{plane}
[[surface]]
name = 'room'
room = {{ min = [{low}, 0, 0], max = [1, 1, 1] }}
omit = ['z1'{omit}]
reflectance = 0.6
[[surface]]
name = 'lamp'
rectangle = {{ origin = [{low}, 0.4, 0.7], edge1 = [0, 0.2, 0], edge2 = [{}, 0, 0] }}
emission = 20
reflectance = 0
[[light]]
kind = 'emitter'
surface = 'lamp'
{suns}[medium]
min = [{low}, 0, 0]
max = [1, 1, 1]
cells = [{cells}, 2, 2]
extinction = 0.4
albedo = 0.8
[[camera]]
name = 'door'
origin = [0.8, 0.1, 0.5]
target = [-0.5, 0.8, 0.3]
",
        // The lamp hangs over the half of the symmetry plane.
        if is_half { 0.5 } else { 1.5 }
    )
    .replace("origin = [-1, 0.4, 0.7]", "origin = [-0.5, 0.4, 0.7]")
    .replace("edge2 = [1.5, 0, 0]", "edge2 = [1, 0, 0]")
}

fn pixels(f: &Folder, name: &str) -> Vec<f32> {
    let picture = zonal_io::output::read_exr(&f.path().join(name)).unwrap();
    picture.pixels.iter().flatten().copied().collect()
}

#[test]
fn pictures_of_a_part_show_the_whole() {
    let f = Folder::new();
    for (name, is_half) in [("half", true), ("whole", false)] {
        f.put(&format!("{name}.toml"), room(is_half));
        f.done(&["solve", &format!("{name}.toml"), "-o", &format!("{name}.npz")]);
        f.done(&[
            "render",
            &format!("{name}.npz"),
            "--size",
            "12x9",
            "--samples",
            "4",
            "-o",
            &format!("{name}.exr"),
        ]);
    }
    let (half, whole) = (pixels(&f, "half.exr"), pixels(&f, "whole.exr"));
    let mean = whole.iter().map(|x| f64::from(*x)).sum::<f64>() / whole.len() as f64;
    let off =
        half.iter().zip(&whole).map(|(x, y)| f64::from((x - y).abs())).sum::<f64>() / whole.len() as f64;
    assert!(mean > 0.1 && off < 0.02 * mean, "{off} of {mean}");
}

#[test]
fn files_hold_the_part_alone() {
    let f = Folder::new();
    f.put("half.toml", room(true));
    let told = f.done(&["solve", "half.toml", "-o", "half.npz"]);
    assert!(told.contains("symmetry planes at x0"), "{told}");
    let told = f.done(&["check", "half.toml"]);
    assert!(told.contains("symmetry planes at x0") && told.contains(" 8 voxel zones"), "{told}");
    for name in ["half.vtu", "half.vti", "half.csv"] {
        f.done(&["export", "half.npz", "-o", name]);
    }
    assert_eq!(String::from_utf8_lossy(&f.get("half.csv")).matches(",voxel,").count(), 8);
    f.done(&["render", "half.npz", "--show", "irradiance", "--size", "12x9", "-o", "half.png"]);
    f.done(&["relight", "half.npz", "sun=2", "-o", "relit.npz"]);
    f.done(&["exchange", "half.toml", "--direct-only", "-o", "areas.npz"]);
    f.put("bad.toml", room(true).replace("omit = ['z1', 'x0']", "omit = ['z1']"));
    refused(&f, Program, &["check", "bad.toml"], "lies in the symmetry plane boundary.x0");
    refused(&f, Program, &["solve", "half.toml", "--factors", "point", "-o", "x.npz"], "symmetry planes");
}
