//! Cost of the spectral engine by size: runs `zonal solve` on a cube of n³ voxels and 6n² wall patches, and writes a table and a plot with the
//! floor beside it.
//!
//! ```text
//! spectral [--scene scenes/cube.toml] [--cells 32,48,64,96,115,160,256] [--command target/release/zonal]
//!          [--csv docs/spectral.csv] [--plot docs/spectral.svg]
//! ```
//!
//! Wall time, processor time and peak memory are those of the command as a whole, reading, tables and writing included. The floor is what no
//! engine of this kind goes below, with P products of n³ voxels padded to N = 2n and h = N/2 + 1:
//!
//! ```text
//!     operations   2P [2.5 n² N + 5 n h N + 5 N h N] log₂N        lines of zeros left out, at the rate of transforms in the cache, of the power of two above N
//!     bytes        16 n h N + the solution as written             one spectrum, and the requested output
//! ```

#[path = "common/command.rs"]
mod command;
#[path = "common/sized.rs"]
mod sized;

use std::path::{Path, PathBuf};
use std::time::Instant;
use zonal_io::output;
use zonal_report::plot::{LOG_LOG, LegendPlacement, Plot, SeriesMark};

const CSV_HEADER: &str =
    "cells,zones,wall_s,processor_s,peak_MB,products,floor_s,floor_MB,time_over_floor,memory_over_floor\n";

/// Cost of a size.
struct SpectralTiming {
    cells: usize,
    zones: f64,
    /// Wall time and processor time, s; peak memory, MB.
    took: [f64; 3],
    products: f64,
    floor: [f64; 2],
}

impl SpectralTiming {
    fn record(&self) -> String {
        let ([time, memory], [wall, processor, peak]) = (self.floor, self.took);
        format!(
            "{},{},{wall:.2},{processor:.2},{peak:.0},{},{time:.3},{memory:.0},{:.1},{:.1}\n",
            self.cells,
            self.zones,
            self.products,
            wall / time,
            peak / memory
        )
    }
}

/// Operations a second of one thread: complex transforms of this length, sixteen lines at a time, 5 N log₂N each.
fn rate(length: usize) -> f64 {
    const LINES_AT_A_TIME: usize = 16;
    let plan = rustfft::FftPlanner::<f64>::new().plan_fft_forward(length);
    let mut lines = vec![rustfft::num_complex::Complex64::default(); LINES_AT_A_TIME * length];
    let mut scratch = vec![Default::default(); plan.get_inplace_scratch_len()];
    let (mut best, mut done) = (f64::INFINITY, 0.0);
    while done < 0.2 {
        let start = Instant::now();
        plan.process_with_scratch(&mut lines, &mut scratch);
        let seconds = start.elapsed().as_secs_f64();
        (best, done) = (best.min(seconds), done + seconds);
    }
    (LINES_AT_A_TIME * length) as f64 * 5.0 * (length as f64).log2() / best
}

/// Operations of one product, there and back.
fn operations(n: f64) -> f64 {
    let (long, half) = (2.0 * n, n + 1.0);
    2.0 * (2.5 * n * n * long + 5.0 * n * half * long + 5.0 * long * half * long) * long.log2()
}

fn solve(command: &Path, text: &str, cells: usize) -> Result<SpectralTiming, Box<dyn std::error::Error>> {
    let size = |run: &Path| Ok(std::fs::metadata(run).map_or(0, |m| m.len()));
    let (report, took, written) = command::solve(
        command,
        &sized::with(text, "cells", |_| Ok(format!("{:?}", [cells; 3])))?,
        &["--engine", "spectral"],
        size,
    )?;
    let zones = ["patches", "voxels"].iter().filter_map(|k| report["zones"][k].as_f64()).sum();
    let steps = report["residuals"][0].as_array().map_or(0, Vec::len);
    // One a step and one to begin with, closure, and what arrives in the end.
    let products = (steps + 2) as f64;
    let n = cells as f64;
    let threads = std::thread::available_parallelism()?.get() as f64;
    let time = products * operations(n) / (rate((2 * cells).next_power_of_two()) * threads);
    let memory = (16.0 * n * (n + 1.0) * 2.0 * n + written as f64) / 1e6;
    Ok(SpectralTiming { cells, zones, took, products, floor: [time, memory] })
}

fn draw(rows: &[SpectralTiming], path: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let mut p =
        Plot::new("The spectral engine: a cube of n³ voxels and its walls", "zones", "s, GB", LOG_LOG);
    p.legend = LegendPlacement::LowerRight;
    let curve = |of: &dyn Fn(&SpectralTiming) -> f64| rows.iter().map(|r| (r.zones, of(r))).collect();
    p.add("wall time of the command, s", SeriesMark::LineWithPoints, 0, curve(&|r| r.took[0]))
        .add("its floor: transforms alone, s", SeriesMark::Dashed, 0, curve(&|r| r.floor[0]))
        .add("peak memory, GB", SeriesMark::LineWithPoints, 1, curve(&|r| r.took[2] / 1e3))
        .add(
            "its floor: one spectrum, the solution, GB",
            SeriesMark::Dashed,
            1,
            curve(&|r| r.floor[1] / 1e3),
        );
    Ok(p.write(path).map_err(|e| e.to_string())?)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let option = |name: &str| arguments.iter().position(|a| a == name).and_then(|k| arguments.get(k + 1));
    let named = |name: &str, or: &str| option(name).map_or(or, |s| s.as_str()).to_string();
    let command = PathBuf::from(named("--command", "target/release/zonal"));
    let text = std::fs::read_to_string(named("--scene", "scenes/cube.toml"))?;
    let (csv, plot) = (named("--csv", "docs/spectral.csv"), named("--plot", "docs/spectral.svg"));
    let (mut rows, mut table) = (Vec::new(), CSV_HEADER.to_string());
    print!("{CSV_HEADER}");
    for cells in named("--cells", "32,48,64,96,115,160,256").split(',') {
        let row = solve(&command, &text, cells.trim().parse()?)?;
        print!("{}", row.record());
        table += &row.record();
        output::write_bytes(Path::new(&csv), table.as_bytes())?;
        rows.push(row);
    }
    draw(&rows, Path::new(&plot))
}
