//! Any-hit rate on 200,000 triangles, with the queries as files for a comparison: see benches/peers/embree.
//!
//! `cargo run --release -p zonal-transport --example rays -- FOLDER [TRIANGLES]` writes `NAME.tri` (nine doubles a triangle),
//! `NAME.volume` and `NAME.surface` (six doubles a segment, from and to) and the results (`.ours`, a byte each) into the folder. The
//! scene is a room with columns, all regular meshes; or, subdivided to 200,000, the triangles of a file of the same format.

use std::io::Write;
use std::path::Path;
use std::time::Instant;
use zonal_math::{Vec3, low_discrepancy::hash_to_unit, vec3};
use zonal_scene::{Bands, Facet, Plate, Scene, SceneParts, Sides, Surface};
use zonal_transport::Transport;

/// Triangles of a subdivided scene.
const TRIANGLE_COUNT: usize = 200_000;
/// Segments of each query set.
const SEGMENT_COUNT: usize = 400_000;
/// Timed repetitions, of which the fastest counts.
const REPEAT_COUNT: usize = 5;

fn main() -> std::io::Result<()> {
    let mut args = std::env::args().skip(1);
    let folder = args.next().expect("a folder for the files");
    let (name, plates) = match args.next() {
        None => ("room".to_string(), room()),
        Some(file) => {
            let name = Path::new(&file).file_stem().expect("a file").to_string_lossy().into_owned();
            (name, subdivided(triangles(&std::fs::read(&file)?)))
        }
    };
    let facets = plates.iter().map(|p| Facet { surface: 0, plate: *p, uv: [[0.0; 2]; 3] }).collect();
    let surface = Surface {
        name: "all".into(),
        reflectance: Bands::splat(0.5),
        emission: Bands::ZERO,
        reflectance_texture: None,
        emission_texture: None,
        transmission: None,
        sides: Sides::Front,
        patch_size: None,
        solid: false,
    };
    let scene = Scene::new(SceneParts { surfaces: vec![surface], facets, ..SceneParts::default() });
    let scene = scene.expect("a scene");
    let start = Instant::now();
    let t = Transport::new(&scene);
    println!("{name}: {} triangles, trees in {:.2} s", plates.len(), start.elapsed().as_secs_f64());
    let path = |end: &str| Path::new(&folder).join(format!("{name}.{end}"));
    let corners = plates.iter().flat_map(|p| p.corners().0.into_iter().take(3));
    write(&path("tri"), corners)?;
    for (kind, points) in [("volume", in_volume(&scene)), ("surface", on_surfaces(&plates))] {
        write(&path(kind), points.iter().copied())?;
        let mut answers = vec![0u8; SEGMENT_COUNT];
        let mut best = f64::INFINITY;
        for _ in 0..REPEAT_COUNT {
            let start = cpu_time();
            for (answer, x) in answers.iter_mut().zip(points.chunks_exact(2)) {
                *answer = u8::from(t.occluded(x[0], x[1]));
            }
            best = best.min(cpu_time() - start);
        }
        std::fs::write(path(&format!("{kind}.ours")), &answers)?;
        let occluded = answers.iter().filter(|x| **x == 1).count();
        println!(
            "ours   {name:<8} {kind:<8} {:6.3} M/s  {occluded} occluded",
            SEGMENT_COUNT as f64 / best * 1e-6
        );
    }
    Ok(())
}

/// CPU time of this thread, s; wall-clock time where the system does not report it.
fn cpu_time() -> f64 {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let stat = stat.and_then(|s| s.split(' ').next()?.parse::<f64>().ok());
    match stat {
        Some(ns) => ns * 1e-9,
        None => std::time::SystemTime::UNIX_EPOCH.elapsed().map_or(0.0, |d| d.as_secs_f64()),
    }
}

fn write(path: &Path, points: impl Iterator<Item = Vec3>) -> std::io::Result<()> {
    let mut out = std::io::BufWriter::new(std::fs::File::create(path)?);
    for x in points.flat_map(Vec3::array) {
        out.write_all(&x.to_le_bytes())?;
    }
    out.flush()
}

fn triangles(bytes: &[u8]) -> Vec<Plate> {
    let number = |c: &[u8]| f64::from_le_bytes(c.try_into().expect("eight bytes"));
    let numbers: Vec<f64> = bytes.chunks_exact(8).map(number).collect();
    let point = |c: &[f64]| vec3(c[0], c[1], c[2]);
    let all = numbers.chunks_exact(9).map(|c| Plate::triangle(point(c), point(&c[3..]), point(&c[6..])));
    all.filter(|p| p.area() > 1e-12).collect()
}

/// Triangles halved at their longest edges, as in zoning, to about [`TRIANGLE_COUNT`].
fn subdivided(mut plates: Vec<Plate>) -> Vec<Plate> {
    let edges = |p: &Plate| {
        let c = p.corners().0;
        [0, 1, 2].map(|k| (c[(k + 1) % 3] - c[k]).length())
    };
    let longest = |p: &Plate| edges(p).into_iter().fold(0.0, f64::max);
    // Bisect the limit of the edge length, in which the number of triangles is monotone.
    let subdivide = |limit: f64, plates: &[Plate]| -> Vec<Plate> {
        let (mut open, mut done) = (plates.to_vec(), Vec::new());
        while let Some(p) = open.pop() {
            if longest(&p) <= limit || done.len() + open.len() > 2 * TRIANGLE_COUNT {
                done.push(p);
                continue;
            }
            let (c, e) = (p.corners().0, edges(&p));
            let k = (0..3).max_by(|i, j| e[*i].total_cmp(&e[*j])).unwrap_or(0);
            let (a, b, o) = (c[k], c[(k + 1) % 3], c[(k + 2) % 3]);
            let m = (a + b) * 0.5;
            open.extend([Plate::triangle(o, a, m), Plate::triangle(o, m, b)]);
        }
        done
    };
    let (mut low, mut high) = (0.0, plates.iter().map(longest).fold(0.0, f64::max));
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if subdivide(middle, &plates).len() > TRIANGLE_COUNT { low = middle } else { high = middle }
    }
    plates = subdivide(high, &plates);
    plates
}

/// A rectangle as n × m × 2 triangles.
fn mesh(o: Vec3, u: Vec3, v: Vec3, n: usize, m: usize, out: &mut Vec<Plate>) {
    let (u, v) = (u / n as f64, v / m as f64);
    for i in 0..n {
        for j in 0..m {
            let q = o + u * i as f64 + v * j as f64;
            out.push(Plate::triangle(q, q + u, q + u + v));
            out.push(Plate::triangle(q, q + u + v, q + v));
        }
    }
}

/// A hall of 40 m × 20 m × 12 m with two rows of ten columns, twelve-sided.
fn room() -> Vec<Plate> {
    let mut out = Vec::new();
    let (x, y, z) = (vec3(40.0, 0.0, 0.0), vec3(0.0, 20.0, 0.0), vec3(0.0, 0.0, 12.0));
    let (o, e) = (Vec3::ZERO, x + y + z);
    let (nx, ny, nz) = (168, 84, 50);
    mesh(o, x, y, nx, ny, &mut out);
    mesh(o, y, z, ny, nz, &mut out);
    mesh(o, z, x, nz, nx, &mut out);
    mesh(e, -y, -x, ny, nx, &mut out);
    mesh(e, -z, -y, nz, ny, &mut out);
    mesh(e, -x, -z, nx, nz, &mut out);
    let sides = 12;
    for k in 0..20 {
        let centre = vec3(2.0 + 4.0 * (k % 10) as f64, if k < 10 { 6.0 } else { 14.0 }, 0.0);
        let corner = |s: usize| {
            let angle = std::f64::consts::TAU * s as f64 / sides as f64;
            centre + vec3(0.7 * angle.cos(), 0.7 * angle.sin(), 0.0)
        };
        for s in 0..sides {
            mesh(corner(s), corner(s + 1) - corner(s), z, 4, 49, &mut out);
        }
    }
    out
}

fn in_volume(scene: &Scene) -> Vec<Vec3> {
    let (lo, hi) = scene.bounds();
    let point = |i: u64| {
        lo + vec3(hash_to_unit(3 * i), hash_to_unit(3 * i + 1), hash_to_unit(3 * i + 2)).scale(hi - lo)
    };
    (0..2 * SEGMENT_COUNT as u64).map(point).collect()
}

fn on_surfaces(plates: &[Plate]) -> Vec<Vec3> {
    let point = |i: u64| {
        let p = &plates[(hash_to_unit(3 * i) * plates.len() as f64) as usize];
        let [u, v] = p.warp([hash_to_unit(3 * i + 1), hash_to_unit(3 * i + 2)]);
        p.at(u, v)
    };
    (0..2 * SEGMENT_COUNT as u64).map(point).collect()
}
