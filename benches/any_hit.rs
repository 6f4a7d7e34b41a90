//! Any-hit rate on triangles, with the queries as files for a comparison: see `peers/embree`.
//!
//! `cargo run --release -p zonal-benches --bin any_hit -- FOLDER [TRIANGLES]` writes `NAME.tri` (nine doubles a triangle),
//! `NAME.volume` and `NAME.surface` (six doubles a segment, from and to) and the results (`.ours`, a byte each) into the folder. The
//! scene is a hall with columns, all regular meshes; or the triangles of a file of the same format.

mod hall;

use std::io::Write as _;
use std::path::Path;
use zonal_math::{Vec3, vec3};
use zonal_scene::Plate;
use zonal_transport::Transport;

/// Timed repetitions, of which the fastest counts.
const REPEAT_COUNT: usize = 5;

fn main() -> std::io::Result<()> {
    let mut args = std::env::args().skip(1);
    let folder = args.next().expect("a folder for the files");
    let (name, plates) = match args.next() {
        None => ("room".to_string(), hall::plates()),
        Some(file) => {
            let name = Path::new(&file).file_stem().expect("a file").to_string_lossy().into_owned();
            (name, triangles(&std::fs::read(&file)?))
        }
    };
    let scene = hall::scene(&plates, None);
    let t = Transport::new(&scene);
    let path = |end: &str| Path::new(&folder).join(format!("{name}.{end}"));
    write(&path("tri"), plates.iter().flat_map(|p| p.corners().0.into_iter().take(3)))?;
    for (kind, points) in [("volume", hall::in_volume(&scene)), ("surface", hall::on_surfaces(&plates))] {
        write(&path(kind), points.iter().copied())?;
        let mut answers = vec![0u8; hall::SEGMENT_COUNT];
        let mut best = f64::INFINITY;
        for _ in 0..REPEAT_COUNT {
            let start = processor_time();
            for (answer, x) in answers.iter_mut().zip(points.chunks_exact(2)) {
                *answer = u8::from(t.occluded(x[0], x[1]));
            }
            best = best.min(processor_time() - start);
        }
        std::fs::write(path(&format!("{kind}.ours")), &answers)?;
        let (rate, occluded) =
            (1e-6 * hall::SEGMENT_COUNT as f64 / best, answers.iter().filter(|x| **x == 1));
        println!("ours   {name:<8} {kind:<8} {rate:6.3} M/s  {} occluded", occluded.count());
    }
    Ok(())
}

/// Processor time of this thread, s, on Linux.
fn processor_time() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux");
    1e-9 * text.split(' ').next().and_then(|ns| ns.parse::<f64>().ok()).expect("nanoseconds")
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
