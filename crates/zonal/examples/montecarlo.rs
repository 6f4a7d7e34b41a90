//! Compares solves of the Monte Carlo cases with their tables, at 10³ and 20³ voxels, and writes `docs/montecarlo.md`.
//!
//! `cargo run --release --example montecarlo -- [--cases c0,c9] [--sizes 10,20] [--reference FOLDER] [-o docs/montecarlo.md]`
//!
//! The comparison averages our zones down to the tables' 10×10 patches a wall and 10³ voxels and takes the root mean square of
//! the relative difference over all entries above zero, against `*_sym` where it exists.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use zonal::io::{input, output};
use zonal::scene::{Quiet, Solution};

struct Case {
    name: &'static str,
    file: &'static str,
    kappa: &'static str,
    albedo: f64,
    rho: f64,
    hot: f64,
    gas: f64,
    block: bool,
}

const CASES: [Case; 7] = [
    Case {
        name: "c0",
        file: "c0_K1_a0.90_r0.5",
        kappa: "1",
        albedo: 0.9,
        rho: 0.5,
        hot: 1.0,
        gas: 0.0,
        block: false,
    },
    Case {
        name: "c1",
        file: "c1_K0.1_a0_r0",
        kappa: "0.1",
        albedo: 0.0,
        rho: 0.0,
        hot: 1.0,
        gas: 0.0,
        block: false,
    },
    Case {
        name: "c3",
        file: "c3_K1_a0.50_r0",
        kappa: "1",
        albedo: 0.5,
        rho: 0.0,
        hot: 1.0,
        gas: 0.0,
        block: false,
    },
    Case {
        name: "c5",
        file: "c5_K5_a0.50_r0.5",
        kappa: "5",
        albedo: 0.5,
        rho: 0.5,
        hot: 1.0,
        gas: 0.0,
        block: false,
    },
    Case {
        name: "c8",
        file: "c8_het_a0.90_r0.5",
        kappa: "",
        albedo: 0.9,
        rho: 0.5,
        hot: 1.0,
        gas: 0.0,
        block: false,
    },
    Case {
        name: "c9",
        file: "c9_occ_K1_a0.50_r0.5",
        kappa: "1",
        albedo: 0.5,
        rho: 0.5,
        hot: 1.0,
        gas: 0.0,
        block: true,
    },
    Case {
        name: "c10",
        file: "c10_emitting_K1_a0.50_r0.5",
        kappa: "1",
        albedo: 0.5,
        rho: 0.5,
        hot: 0.0,
        gas: 1.0,
        block: false,
    },
];

fn scene_text(c: &Case, n: usize, reference: &Path) -> String {
    let mut t = format!(
        "name = \"{}\"\n[solve]\npatch_size = {}\nresidual = 1e-12\n[[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\nreflectance = {}\nfaces.x0 = {{ emission = {} }}\n",
        c.name,
        1.0 / n as f64,
        c.rho,
        c.hot
    );
    if c.block {
        // Twelve by twelve or sixteen: whole numbers of patches in each cell of the table.
        let size = 0.025;
        let _ = write!(
            t,
            "[[surface]]\nname = \"block\"\nbox = {{ min = [0.4,0.3,0.2], max = [0.7,0.6,0.6] }}\nreflectance = 0.5\npatch_size = {size}\n"
        );
    }
    let kappa = if c.kappa.is_empty() { "0" } else { c.kappa };
    let _ = write!(
        t,
        "[medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [{n},{n},{n}]\nextinction = {kappa}\nalbedo = {}\nemission = {}\n",
        c.albedo, c.gas
    );
    if c.kappa.is_empty() {
        let file = reference.join("sigma_t.npy");
        let _ = write!(
            t,
            "[[medium.region]]\ndensity = {{ file = {:?}, min = [0,0,0], max = [1,1,1], scale = 1.0 }}\nalbedo = {}\n",
            file.display().to_string(),
            c.albedo
        );
    }
    t
}

/// Mean over coarse cells of a field on fine rectangles or boxes: each fine zone is spread over the cells it overlaps.
struct Binned {
    shape: Vec<usize>,
    sum: Vec<f64>,
    weight: Vec<f64>,
}

impl Binned {
    fn new(shape: Vec<usize>) -> Binned {
        let n = shape.iter().product();
        Binned { shape, sum: vec![0.0; n], weight: vec![0.0; n] }
    }
    /// Adds a zone that spans `spans` (lower, upper in units of cells) on the last axes of the shape, below the index `head`.
    fn add(&mut self, head: usize, spans: &[(f64, f64)], value: f64) {
        let tail = &self.shape[self.shape.len() - spans.len()..].to_vec();
        let cells: usize = tail.iter().product();
        for cell in 0..cells {
            let mut rest = cell;
            let mut w = 1.0;
            for (k, &(lo, hi)) in spans.iter().enumerate().rev() {
                let i = (rest % tail[k]) as f64;
                rest /= tail[k];
                w *= (hi.min(i + 1.0) - lo.max(i)).max(0.0);
            }
            if w > 1e-9 {
                self.sum[head * cells + cell] += w * value;
                self.weight[head * cells + cell] += w;
            }
        }
    }
    fn means(&self) -> Vec<f64> {
        self.sum.iter().zip(&self.weight).map(|(s, w)| if *w > 0.0 { s / w } else { 0.0 }).collect()
    }
}

/// H on the walls (6×10×10), H on the block (6×4×4) and G (10×10×10) of a solution.
fn averaged(s: &Solution) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let mut walls = Binned::new(vec![6, 10, 10]);
    let mut block = Binned::new(vec![6, 4, 4]);
    let mut gas = Binned::new(vec![10, 10, 10]);
    let faces = ["x0", "x1", "y0", "y1", "z0", "z1"];
    for (i, p) in s.zones.patches.iter().enumerate() {
        let name = &s.scene.surfaces()[p.surface].name;
        let (lo, hi) = p.plate.bounds();
        let h = s.fields.incident[i][0];
        let is_block = name.starts_with("block");
        let n = p.normal.array();
        let axis = (0..3).max_by(|&a, &b| n[a].abs().total_cmp(&n[b].abs())).unwrap_or(0);
        let head = if is_block {
            2 * axis + (n[axis] > 0.0) as usize
        } else {
            faces.iter().position(|f| name.ends_with(f)).expect("a wall of the room")
        };
        let (origin, size, cells) =
            if is_block { ([0.4, 0.3, 0.2], [0.3, 0.3, 0.4], 4.0) } else { ([0.0; 3], [1.0; 3], 10.0) };
        let spans: Vec<(f64, f64)> = (0..3)
            .filter(|&k| k != axis)
            .map(|k| ((lo[k] - origin[k]) / size[k] * cells, (hi[k] - origin[k]) / size[k] * cells))
            .collect();
        if is_block { block.add(head, &spans, h) } else { walls.add(head, &spans, h) }
    }
    let map = s.scene.voxmap().expect("a medium");
    for (k, z) in s.zones.voxels.iter().enumerate() {
        let c = map.coordinates(z.cell);
        let spans: Vec<(f64, f64)> = (0..3)
            .map(|a| {
                let n = map.dims()[a] as f64;
                (c[a] as f64 / n * 10.0, (c[a] + 1) as f64 / n * 10.0)
            })
            .collect();
        gas.add(0, &spans, s.fields.incident[s.zones.voxel_offset() + k][0]);
    }
    (walls.means(), block.means(), gas.means())
}

/// Root mean square and largest of the relative difference over entries above zero.
fn difference(ours: &[f64], table: &[f64]) -> (f64, f64) {
    let d: Vec<f64> = ours.iter().zip(table).filter(|(_, t)| **t > 0.0).map(|(o, t)| o / t - 1.0).collect();
    let rms = (d.iter().map(|x| x * x).sum::<f64>() / d.len().max(1) as f64).sqrt();
    (rms, d.iter().fold(0.0, |m, x| m.max(x.abs())))
}

fn table_of(file: &Path, name: &str) -> Option<Vec<f64>> {
    output::read_array(file, name).ok().map(|a| a.1)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let option =
        |name: &str| arguments.iter().position(|a| a == name).and_then(|k| arguments.get(k + 1).cloned());
    let reference = PathBuf::from(option("--reference").unwrap_or("../shared/reference/montecarlo".into()));
    let chosen = option("--cases");
    let sizes: Vec<usize> =
        option("--sizes").unwrap_or("10,20".into()).split(',').map(str::parse).collect::<Result<_, _>>()?;
    let mut page = String::from(
        "# Against Monte Carlo\n\nWritten by `cargo run --release --example montecarlo`. RMS and largest relative difference of irradiance H and fluence G\nfrom the tables, our zones averaged down to theirs; `s.e.` is the tables' own RMS standard error. Dense engine, closure as measured.\n\n| case | n³ | zones | H rms | H max | G rms | G max | block H rms | block H max | s.e. H | s.e. G | closure rms |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    print!("{page}");
    for c in CASES.iter().filter(|c| chosen.as_ref().is_none_or(|l| l.split(',').any(|n| n == c.name))) {
        let file = reference.join(format!("{}.npz", c.file));
        let pick =
            |q: &str| table_of(&file, &format!("{q}_sym")).or_else(|| table_of(&file, &format!("{q}_exp")));
        let pick_se = |q: &str| {
            table_of(&file, &format!("{q}_sym_se")).or_else(|| table_of(&file, &format!("{q}_exp_se")))
        };
        let (Some(h), Some(g), Some(hs), Some(gs)) = (pick("H"), pick("G"), pick_se("H"), pick_se("G"))
        else {
            return Err(format!("{}: no such table; give --reference FOLDER", file.display()).into());
        };
        let folder = std::env::temp_dir().join(format!("zonal-montecarlo-{}", std::process::id()));
        std::fs::create_dir_all(&folder)?;
        if c.kappa.is_empty() {
            let (shape, values) = output::read_array(&file, "sigma_t")?;
            output::write_array(&folder.join("sigma_t.npy"), &shape, &values)?;
        }
        for &n in &sizes {
            let scene = input::parse_scene(&scene_text(c, n, &folder), Some(&folder), c.name)?;
            let s = zonal::solve::solve(scene, 16 << 30, &Quiet)?;
            let (walls, block, gas) = averaged(&s);
            let ((hr, hm), (gr, gm)) = (difference(&walls, &h), difference(&gas, &g));
            let percent = |x: f64| format!("{:.2} %", 100.0 * x);
            let relative = |se: &[f64], v: &[f64]| {
                let d: Vec<f64> =
                    se.iter().zip(v).filter(|x| *x.1 > 0.0).map(|x| (x.0 / x.1).powi(2)).collect();
                (d.iter().sum::<f64>() / d.len() as f64).sqrt()
            };
            let on_block = if c.block {
                let table = table_of(&file, "Hocc_exp").ok_or("the table of the block is missing")?;
                let (r, m) = difference(&block, &table);
                format!("{} | {}", percent(r), percent(m))
            } else {
                "– | –".into()
            };
            let line = format!(
                "| {} | {n} | {} | {} | {} | {} | {} | {on_block} | {} | {} | {:.1e} |\n",
                c.name,
                s.zones.len(),
                percent(hr),
                percent(hm),
                percent(gr),
                percent(gm),
                percent(relative(&hs, &h)),
                percent(relative(&gs, &g)),
                s.report.closure.rms[0]
            );
            print!("{line}");
            page.push_str(&line);
        }
        std::fs::remove_dir_all(&folder)?;
    }
    if let Some(out) = option("-o") {
        output::write_bytes(Path::new(&out), page.as_bytes())?;
    }
    Ok(())
}
