//! Draws published scenes with isotropic media from their own camera and compares with their reference pictures.
//!
//! `cargo run --release -p zonal-validation --example mitsuba_media -- [--data ../shared/data/mitsuba-media] [--only NAME] [--env 8] [--patch 0.55]
//! [--cell 0.15] [--engine dense] [--tolerance 0.01] [-o out/mitsuba-media]`
//!
//! The scenes are Mitsuba's test scenes of participating media, 48 × 48 pixels with paths of at most six segments. Five of the ten have
//! neither glass nor gloss: the others cannot be said here; of the five, two whose grids go on beyond their box are left out.
//! Their picture of a museum as the environment becomes a box far away, each of its patches with the mean radiance of its directions; it emits, so six segments are five sweeps and the one to the
//! camera. The focal length is the default, 50 mm on 36 mm × 24 mm: a diagonal of 46.8°, so 34.0° across a square.

use std::fmt::Write as _;
use std::path::Path;
use zonal_io::{input, output};
use zonal_math::{Vec3, vec3};
use zonal_render::{RenderOptions, render};
use zonal_scene::NoProgress;

const PICTURE_PIXELS: usize = 48;
const BLOCK_PIXELS: usize = 8;
/// Half the edge of the box that stands for the environment, m: seen from everywhere in the scene in the same directions, to 0.2°.
const ENVIRONMENT_HALF_EDGE: f64 = 1500.0;
/// tan 17.0°: half the diagonal of 36 mm × 24 mm over 50 mm, over √2.
const FIELD_OF_VIEW: f64 = 34.022_7;

/// Medium of a scene.
enum MediumFilling {
    /// Spheres of a medium with κ and Ω.
    Spheres(&'static str, &'static str),
    /// A cube of a medium on a diffuse foot: κ and Ω.
    Cube(&'static str, &'static str),
}

struct MediaCase {
    name: &'static str,
    filling: MediumFilling,
}

const MITSUBA_CASES: [MediaCase; 3] = [
    MediaCase { name: "homo_null_envmap", filling: MediumFilling::Spheres("3", "[0.99, 0.5, 0.5]") },
    MediaCase {
        name: "homo_spectral_sigmat",
        filling: MediumFilling::Spheres("[10, 2, 10]", "[0.5, 0.5, 0.99]"),
    },
    MediaCase {
        name: "hetero_spectral_sigmat_no_scattering",
        filling: MediumFilling::Cube("[2.5, 2, 1.5]", "0"),
    },
];

struct MediaSettings {
    env: usize,
    patch: f64,
    cell: f64,
    engine: String,
    tolerance: f64,
}

/// The museum, radiance by direction: u = atan2(x, −z)/2π, v = acos(y)/π.
struct EnvironmentMap(output::RgbImage);

impl EnvironmentMap {
    fn radiance(&self, d: Vec3) -> [f64; 3] {
        let (w, h) = (self.0.width, self.0.height);
        let u = d.x.atan2(-d.z) / std::f64::consts::TAU;
        let v = (d.y / d.length()).clamp(-1.0, 1.0).acos() / std::f64::consts::PI;
        let x = (((u - u.floor()) * w as f64) as usize).min(w - 1);
        let y = ((v * h as f64) as usize).min(h - 1);
        self.0.pixels[y * w + x].map(f64::from)
    }
    /// The mean over the directions towards a rectangle, by solid angle.
    fn mean(&self, o: Vec3, u: Vec3, v: Vec3) -> [f64; 3] {
        const N: usize = 24;
        let (mut sum, mut all) = ([0.0; 3], 0.0);
        for i in 0..N * N {
            let at = |k: usize| (k as f64 + 0.5) / N as f64;
            let p = o + u * at(i % N) + v * at(i / N);
            let weight = p.length().powi(-3);
            let l = self.radiance(p);
            (0..3).for_each(|b| sum[b] += weight * l[b]);
            all += weight;
        }
        sum.map(|s| s / all)
    }
    /// Six faces of n × n rectangles that look inward.
    fn surfaces(&self, n: usize) -> String {
        let mut t = String::new();
        let axes = [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0)];
        for face in 0..6 {
            let (a, b, c) = (axes[face % 3], axes[(face + 1) % 3], axes[(face + 2) % 3]);
            // On the lower side a × b looks up, on the upper side b × a down.
            let (a, b, c) = if face < 3 { (a, b, -c) } else { (b, a, c) };
            let (u, v) =
                (a * (2.0 * ENVIRONMENT_HALF_EDGE / n as f64), b * (2.0 * ENVIRONMENT_HALF_EDGE / n as f64));
            for k in 0..n * n {
                let o = (c - a - b) * ENVIRONMENT_HALF_EDGE + u * (k % n) as f64 + v * (k / n) as f64;
                let e = self.mean(o, u, v).map(|l| l * std::f64::consts::PI);
                if e == [0.0; 3] {
                    continue;
                }
                let _ = write!(
                    t,
                    "[[surface]]\nname = \"env {face} {k}\"\nrectangle = {{ origin = {:?}, edge1 = {:?}, edge2 = {:?} }}\n\
                     reflectance = 0\nemission = {e:?}\npatch_size = {}\n",
                    o.array(),
                    u.array(),
                    v.array(),
                    4.0 * ENVIRONMENT_HALF_EDGE
                );
            }
        }
        t
    }
}

/// The box of the spheres' medium.
const SPHERES_MIN: [f64; 3] = [-0.95, -1.04, -0.95];
const SPHERES_MAX: f64 = 0.95;
/// Cells along an edge of the picture of the spheres' insides, from which the medium's cells take their share.
const MASK_CELLS: usize = 200;

/// Writes 1 inside of the spheres and 0 outside.
fn spheres(path: &Path, scenes: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let mut t = format!(
        "[medium]\nmin = {SPHERES_MIN:?}\nmax = {:?}\ncells = {:?}\n",
        [SPHERES_MAX; 3], [MASK_CELLS; 3]
    );
    for name in ["sphere_tiny", "sphere_base"] {
        let file = scenes.join(format!("meshes/{name}.obj")).display().to_string();
        let _ = write!(t, "[[medium.region]]\nmesh = {{ file = {file:?} }}\nextinction = 1\n");
    }
    let scene = input::parse_scene(&t, Some(scenes), "spheres")?;
    let map = scene.voxel_grid().ok_or("no medium")?;
    let at = |i: usize| {
        map.extinction(map.index([
            i / (MASK_CELLS * MASK_CELLS),
            i / MASK_CELLS % MASK_CELLS,
            i % MASK_CELLS,
        ]))
        .first()
    };
    let values: Vec<f64> = (0..MASK_CELLS.pow(3)).map(at).collect();
    Ok(output::write_array(path, &[MASK_CELLS; 3], &values)?)
}

/// Corners of the floor and the wall, and their texture coordinates there, from meshes/background.obj.
const BOX_X: f64 = 4.684_556;
const BOX_Y: [f64; 2] = [-1.044_930, 4.445_930];
const BOX_Z: [f64; 2] = [-3.122_140, 3.122_140];
const TEXTURE: [f64; 2] = [0.000_073, 0.532_096];
const FLOOR_V: [f64; 2] = [0.467_904, 0.999_927];

/// Texels a metre: the reader filters, so that a check's edge is off by a hundredth of its width at most.
const TEXELS_PER_METRE: f64 = 120.0;

/// Two codes of a picture whose radiances are as 1 : 2, and the lighter one.
fn codes() -> ([f32; 2], f64) {
    let linear = |c: usize| {
        let x = c as f64 / 255.0;
        if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    };
    let off = |&(a, b): &(usize, usize)| (linear(b) / linear(a) - 2.0).abs();
    let pairs = (60..200).flat_map(|a| (a + 1..256).map(move |b| (a, b)));
    let (a, b) = pairs.min_by(|x, y| off(x).total_cmp(&off(y))).unwrap_or((124, 170));
    ([linear(a) as f32, linear(b) as f32], linear(b))
}

/// Writes the checks of a plane of width × height metres whose texture coordinates run as given, the picture's top last.
fn checks(path: &Path, height: f64, v: [f64; 2]) -> Result<(), Box<dyn std::error::Error>> {
    let (colours, _) = codes();
    let (w, h) = ((2.0 * BOX_X * TEXELS_PER_METRE) as usize, (height * TEXELS_PER_METRE) as usize);
    let at = |k: usize, n: usize, [a, b]: [f64; 2]| 16.0 * (a + (b - a) * (k as f64 + 0.5) / n as f64);
    let pixels: Vec<[f32; 3]> = (0..w * h)
        .map(|i| {
            // u runs against x; the reader of the original turns v upside down.
            let (u, v) = (at(w - 1 - i % w, w, TEXTURE), 16.0 - at(h - 1 - i / w, h, v));
            let same = (u.fract() > 0.5) == (v.fract() > 0.5);
            [colours[usize::from(!same)]; 3]
        })
        .collect();
    Ok(output::write_png(path, w, h, &pixels, &output::ToneMapping::linear(1.0))?)
}

fn scene_text(
    c: &MediaCase,
    data: &Path,
    folder: &Path,
    museum: &EnvironmentMap,
    s: &MediaSettings,
) -> String {
    let scenes = data.join("tests/scenes/participating_media");
    let path = |p: &Path| format!("{:?}", p.display().to_string());
    let mesh = |name: &str| path(&scenes.join(format!("meshes/{name}.obj")));
    let reflectance = 0.4 / codes().1;
    let (depth, height) = (BOX_Z[1] - BOX_Z[0], BOX_Y[1] - BOX_Y[0]);
    let mut t = format!(
        "name = \"{}\"\n[solve]\npatch_size = {}\nscattering_orders = 5\nengine = \"{}\"\ntolerance = {}\nclosure = \"measure\"\n\
         [[camera]]\nname = \"front\"\norigin = [0, 0.5, 4]\ntarget = [0, -0.5, 0]\nup = [0, 1, 0]\nfov = {FIELD_OF_VIEW}\n\
         [[surface]]\nname = \"floor\"\nrectangle = {{ origin = [{}, {}, {}], edge1 = [{}, 0, 0], edge2 = [0, 0, {}] }}\n\
         reflectance = {reflectance}\nsides = \"both\"\ntexture = {}\n\
         [[surface]]\nname = \"wall\"\nrectangle = {{ origin = [{}, {}, {}], edge1 = [{}, 0, 0], edge2 = [0, {height}, 0] }}\n\
         reflectance = {reflectance}\nsides = \"both\"\ntexture = {}\n",
        c.name,
        s.patch,
        s.engine,
        s.tolerance,
        -BOX_X,
        BOX_Y[0],
        BOX_Z[1],
        2.0 * BOX_X,
        -depth,
        path(&folder.join("floor.png")),
        -BOX_X,
        BOX_Y[0],
        BOX_Z[0],
        2.0 * BOX_X,
        path(&folder.join("wall.png")),
    );
    t += &medium_text(c, &mesh("sphere_base"), &path(&folder.join("spheres.npy")), s);
    t + &museum.surfaces(s.env)
}

/// The medium of a case, with the foot that stands beside the cube; `mesh` and `spheres` are quoted paths.
fn medium_text(c: &MediaCase, mesh: &str, spheres: &str, s: &MediaSettings) -> String {
    let mut t = String::new();
    let foot = format!("[[surface]]\nname = \"foot\"\nmesh = {{ file = {} }}\nreflectance = 0.5\n", mesh);
    // The box of 1.5 m is a boundary only: the constant volume in it fills a unit cube.
    let half = 0.5;
    match c.filling {
        MediumFilling::Spheres(extinction, albedo) => {
            let cells = SPHERES_MIN.map(|l| ((SPHERES_MAX - l) / s.cell).round() as usize);
            let _ = write!(
                t,
                "[medium]\nmin = {SPHERES_MIN:?}\nmax = {:?}\ncells = {cells:?}\n[[medium.region]]\n\
                 density = {{ file = {}, min = {SPHERES_MIN:?}, max = {:?}, scale = {extinction} }}\nalbedo = {albedo}\n",
                [SPHERES_MAX; 3], spheres, [SPHERES_MAX; 3]
            );
        }
        MediumFilling::Cube(extinction, albedo) => {
            let _ = write!(
                t,
                "{foot}[medium]\nmin = [-{half}, -{half}, -{half}]\nmax = [{half}, {half}, {half}]\ncells = [2, 2, 2]\n\
                 extinction = {extinction}\nalbedo = {albedo}\n"
            );
        }
    }
    t
}

fn mean(p: &[[f32; 3]], b: usize) -> f64 {
    p.iter().map(|c| f64::from(c[b])).sum::<f64>() / p.len() as f64
}

/// The root mean square of the relative differences of 8 × 8 blocks.
fn blocks(ours: &[[f32; 3]], theirs: &[[f32; 3]], b: usize) -> f64 {
    let n = PICTURE_PIXELS / BLOCK_PIXELS;
    let sum = |p: &[[f32; 3]], block: usize| -> f64 {
        let at = |k: usize| {
            (block / n * BLOCK_PIXELS + k / BLOCK_PIXELS) * PICTURE_PIXELS
                + block % n * BLOCK_PIXELS
                + k % BLOCK_PIXELS
        };
        (0..BLOCK_PIXELS * BLOCK_PIXELS).map(|k| f64::from(p[at(k)][b])).sum()
    };
    let squares: f64 = (0..n * n).map(|k| (sum(ours, k) / sum(theirs, k) - 1.0).powi(2)).sum();
    (squares / (n * n) as f64).sqrt()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let option =
        |name: &str| arguments.iter().position(|a| a == name).and_then(|k| arguments.get(k + 1).cloned());
    let data = std::fs::canonicalize(option("--data").unwrap_or("../shared/data/mitsuba-media".into()))?;
    let out = std::path::PathBuf::from(option("-o").unwrap_or("out/mitsuba-media".into()));
    std::fs::create_dir_all(&out)?;
    let out = std::fs::canonicalize(out)?;
    let settings = MediaSettings {
        env: option("--env").unwrap_or("8".into()).parse()?,
        patch: option("--patch").unwrap_or("0.55".into()).parse()?,
        cell: option("--cell").unwrap_or("0.15".into()).parse()?,
        engine: option("--engine").unwrap_or("dense".into()),
        tolerance: option("--tolerance").unwrap_or("0.01".into()).parse()?,
    };
    checks(&out.join("floor.png"), BOX_Z[1] - BOX_Z[0], [FLOOR_V[1], FLOOR_V[0]])?;
    checks(&out.join("wall.png"), BOX_Y[1] - BOX_Y[0], [FLOOR_V[0], TEXTURE[0]])?;
    spheres(&out.join("spheres.npy"), &data.join("tests/scenes/participating_media"))?;
    let museum = EnvironmentMap(output::read_exr(&data.join("common/textures/museum.exr"))?);
    println!(
        "| scene | zones | mean R | mean G | mean B | blocks R | blocks G | blocks B |\n|---|---|---|---|---|---|---|---|"
    );
    for c in &MITSUBA_CASES {
        if option("--only").is_some_and(|name| name != c.name) {
            continue;
        }
        let text = scene_text(c, &data, &out, &museum, &settings);
        std::fs::write(out.join(format!("{}.toml", c.name)), &text)?;
        let scene = input::parse_scene(&text, Some(&data), c.name)?;
        let solution = zonal_solve::solve(scene, 16 << 30, &NoProgress)?;
        let options = RenderOptions {
            width: PICTURE_PIXELS,
            height: PICTURE_PIXELS,
            samples: 16,
            ..RenderOptions::default()
        };
        let image = render(&solution, &solution.scene.cameras()[0], &options, &NoProgress);
        let refs = data.join("tests/scenes/participating_media/refs");
        let theirs = output::read_exr(&refs.join(format!("test_{}_ref_rgb.exr", c.name)))?.pixels;
        output::write_exr(
            &out.join(format!("{}.exr", c.name)),
            PICTURE_PIXELS,
            PICTURE_PIXELS,
            &image.pixels,
        )?;
        let mut line = format!("| {} | {} |", c.name, solution.zones.len());
        for b in 0..3 {
            let _ = write!(line, " {:+.2} % |", 100.0 * (mean(&image.pixels, b) / mean(&theirs, b) - 1.0));
        }
        for b in 0..3 {
            let _ = write!(line, " {:.2} % |", 100.0 * blocks(&image.pixels, &theirs, b));
        }
        println!("{line}");
    }
    Ok(())
}
