//! Whole solves with the paper's factors: cost and change of the radiosity.

use std::sync::Mutex;
use std::time::Instant;
use zonal_exchange::pair::PairSettings;
use zonal_io::{input, output};
use zonal_paper::VoxelFormula;
use zonal_render::RenderOptions;
use zonal_report::Failure;
use zonal_report::plot::{LOG_LOG, Plot, SeriesMark};
use zonal_report::{PageFolder, markdown, number, percent};
use zonal_scene::{Band, NoProgress, Progress, Solution};
use zonal_solve::SolveSettings;

/// The formula for two voxels, and its name: `None` is the exact one.
const FORMULAS: [(Option<VoxelFormula>, &str); 4] = [
    (None, "exact"),
    (Some(VoxelFormula::Series), "series"),
    (Some(VoxelFormula::Proposition1), "prop1"),
    (Some(VoxelFormula::Point), "point"),
];

/// The count of the report that holds the pairs by a formula of the paper.
const PAPER_PAIRS: &str = "voxel pairs by a formula of the paper";

/// Largest memory of a solve, bytes.
const MAX_MEMORY: u64 = 12 << 30;

/// A cube of grey walls, one of them hot, full of a medium that scatters: the case c0 of the Monte Carlo tables.
fn cube(n: usize) -> String {
    format!(
        "name = \"c0\"\n[solve]\npatch_size = {}\nresidual = 1e-12\n\
         [[surface]]\nname = \"room\"\nroom = {{ min = [0,0,0], max = [1,1,1] }}\nreflectance = 0.5\nfaces.x0 = {{ emission = 1 }}\n\
         [medium]\nmin = [0,0,0]\nmax = [1,1,1]\ncells = [{n},{n},{n}]\nextinction = 1\nalbedo = 0.9\n\
         [[camera]]\nname = \"inside\"\norigin = [0.9,0.9,0.8]\ntarget = [0.1,0.3,0.2]\nfov = 75\n",
        1.0 / n as f64
    )
}

/// Seconds spent in the stage of the exchange areas.
#[derive(Default)]
struct ExchangeStageTimer {
    since: Mutex<Option<Instant>>,
    seconds: Mutex<f64>,
}

impl Progress for ExchangeStageTimer {
    fn begin(&self, stage: &str, _total: u64) {
        if stage == "exchange areas"
            && let Ok(mut since) = self.since.lock()
        {
            *since = Some(Instant::now());
        }
    }
    fn advance(&self, _done: u64) {}
    fn end(&self) {
        if let (Ok(mut since), Ok(mut seconds)) = (self.since.lock(), self.seconds.lock())
            && let Some(start) = since.take()
        {
            *seconds += start.elapsed().as_secs_f64();
        }
    }
}

fn solve(text: &str, formula: Option<VoxelFormula>, progress: &dyn Progress) -> Result<Solution, Failure> {
    let scene = input::parse_scene(text, None, "the scene of the reproduction")?;
    let pair_settings =
        PairSettings { volume_factors: formula.map(VoxelFormula::method), ..PairSettings::default() };
    let settings = SolveSettings { pair_settings, ..SolveSettings::new(MAX_MEMORY, progress) };
    Ok(zonal_solve::solve_with_settings(scene, &settings)?)
}

/// Difference of B from that of the exact factors: RMS and largest relative difference, patches and volumes apart.
fn radiosity_difference(s: &Solution, exact: &Solution) -> [(f64, f64); 2] {
    let split = s.zones.voxel_offset();
    [0..split, split..s.zones.len()].map(|zones| {
        let (mut sum, mut count, mut most) = (0.0, 0.0f64, 0.0f64);
        for i in zones {
            for b in Band::all() {
                let e = exact.fields.radiosity[i][b];
                if e > 0.0 {
                    let d = s.fields.radiosity[i][b] / e - 1.0;
                    (sum, count, most) = (sum + d * d, count + 1.0, most.max(d.abs()));
                }
            }
        }
        ((sum / count.max(1.0)).sqrt(), most)
    })
}

/// Sizes of the solves.
#[derive(Clone, Copy, Debug)]
pub(super) struct SolveSizes {
    /// Voxels along an edge of the cube, a solve each.
    pub divisions: &'static [usize],
    /// The chapel's size, where it is to be solved.
    pub chapel: Option<zonal_demo::Size>,
    /// Pixels of the pictures.
    pub pixels: (usize, usize),
}

/// The page's sections.
pub(super) fn write(folder: &PageFolder, sizes: SolveSizes) -> Result<String, Failure> {
    Ok(against_divisions(folder, sizes.divisions)? + &formulas(folder, sizes)?)
}

fn against_divisions(folder: &PageFolder, divisions: &[usize]) -> Result<String, Failure> {
    let mut rows = Vec::new();
    let (mut rms, mut most) = (Vec::new(), Vec::new());
    for &n in divisions {
        let text = cube(n);
        let exact = solve(&text, None, &NoProgress)?;
        let [(pr, pm), (vr, vm)] =
            radiosity_difference(&solve(&text, Some(VoxelFormula::Proposition1), &NoProgress)?, &exact);
        rows.push(vec![n.to_string(), number(pr, 6), number(pm, 6), number(vr, 6), number(vm, 6)]);
        rms.push((n as f64, vr));
        most.push((n as f64, vm));
    }
    folder.table("radiosity.csv", &["N", "patches_rms", "patches_max", "voxels_rms", "voxels_max"], &rows)?;
    let mut plot = Plot::new(
        "Proposition 1 in the solved radiosity (cube c0, κ = 1/L)",
        "N, voxels along an edge",
        "relative difference of B from exact factors, voxels",
        LOG_LOG,
    );
    let [.., (n0, first), (nl, last)] = rms[..] else {
        return Err(Failure::new("two solves at least are compared"));
    };
    let rate = (first / last).ln() / (nl / n0).ln();
    plot.add("largest", SeriesMark::LineWithPoints, 1, most);
    plot.add("RMS", SeriesMark::LineWithPoints, 0, rms.clone());
    plot.add("1/N", SeriesMark::Dashed, 7, rms.iter().map(|&(n, _)| (n, last * nl / n)).collect());
    folder.plot("radiosity.svg", &plot)?;
    let shown: Vec<Vec<String>> = rows
        .iter()
        .map(|r| {
            let p = |k: usize| percent(r[k].parse().unwrap_or(f64::NAN));
            vec![r[0].clone(), p(1), p(2), p(3), p(4)]
        })
        .collect();
    Ok(format!(
        "## 8. “e = C/N” in the solved radiosity\n\n\
Geometry: a unit cube, grey walls of reflectance 0.5, one of them emitting, N³ voxels and N×N patches a wall, κ = 1/L, albedo 0.9; all pairs of voxels \
by Proposition 1 (uncorrected), all other pairs exact. Difference of B from the same solve with exact factors.\n\n\
![radiosity](radiosity.svg) · [radiosity.csv](radiosity.csv)\n\n{}\n\
Between the last two N the RMS difference over the voxels falls like N^−{:.2}; C/N is its order. It is much smaller than the errors of the pairs in section 2: the \
factor of a voxel with itself is too large and those with its neighbours are too small, and the sum over all zones, which is what the equations take, sees the \
difference of the two. On coarse grids the two all but cancel.\n\n",
        markdown(&["N", "patches, RMS", "patches, largest", "voxels, RMS", "voxels, largest"], &shown),
        rate
    ))
}

/// A scene of the comparison.
struct ComparedScene {
    name: &'static str,
    text: String,
    camera: &'static str,
}

fn formulas(folder: &PageFolder, sizes: SolveSizes) -> Result<String, Failure> {
    let n = *sizes.divisions.last().unwrap_or(&10);
    let mut scenes = vec![ComparedScene { name: "c0", text: cube(n), camera: "inside" }];
    scenes.extend(sizes.chapel.map(|size| ComparedScene {
        name: "chapel",
        text: zonal_demo::chapel_text(size),
        camera: "nave",
    }));
    let (mut rows, mut pictures) = (Vec::new(), String::new());
    let (width, height) = sizes.pixels;
    for scene in &scenes {
        rows.extend(compare_formulas(folder, scene, width, height)?);
        let name = scene.name;
        let cell = |w: &str| format!("![{name}, {w}]({name}-{w}.png)");
        pictures += &markdown(
            &["exact", "series", "Proposition 1", "formula (3)"],
            &[["exact", "series", "prop1", "point"].map(cell).to_vec()],
        );
        pictures.push('\n');
    }
    let header = [
        "scene",
        "factors",
        "voxel pairs by it",
        "exchange areas, s",
        "patches, RMS",
        "patches, largest",
        "voxels, RMS",
        "voxels, largest",
    ];
    folder.table("formulas.csv", &header, &rows)?;
    Ok(format!(
        "## 9. The whole system on the paper's own factors\n\n\
`zonal solve SCENE --factors exact|series|prop1|point -o RUN.npz` runs the whole pipeline with the pairs of whole voxels by the \
named formula (formula (3) has none for a voxel with itself); all pairs with a surface, a pane or a cut voxel stay exact, since the paper has no formula \
of its own for them. `series` is the algorithm `Formfact` for each voxel over the whole voxel grid. Times are those of the whole stage of the exchange areas, rays \
included, on the machine that wrote this page. c0 is the cube above with N = {n}.\n\n{}\n\
The difference between `series` and `prop1` is that of the truncated series alone; that between `prop1` and `exact` is the transmittance taken \
out of the integral. The same exposure for all four pictures of a scene:\n\n{pictures}[formulas.csv](formulas.csv)\n\n",
        markdown(&header, &rows)
    ))
}

/// Solves a scene with every formula, draws it with the exposure of the exact one, and returns a row each.
fn compare_formulas(
    folder: &PageFolder,
    scene: &ComparedScene,
    width: usize,
    height: usize,
) -> Result<Vec<Vec<String>>, Failure> {
    let ComparedScene { name, text, camera } = scene;
    let mut rows = Vec::new();
    let mut exact: Option<(Solution, f64)> = None;
    for (factors, word) in FORMULAS {
        let clock = ExchangeStageTimer::default();
        let s = solve(text, factors, &clock)?;
        let seconds = clock.seconds.lock().map_or(0.0, |s| *s);
        let found = s.scene.cameras().iter().find(|c| c.name == *camera);
        let camera = found.ok_or_else(|| Failure::new(format!("{name}: there is no camera '{camera}'")))?;
        let options = RenderOptions { width, height, samples: 4, ..RenderOptions::default() };
        let image = zonal_render::render(&s, camera, &options, &NoProgress);
        let exposure = match &exact {
            Some((_, e)) => *e,
            None => output::auto_exposure(&image.pixels),
        };
        let file = format!("{name}-{word}.png");
        let tone = output::ToneMapping::filmic(exposure);
        output::write_png(&folder.path(&file), image.width, image.height, &image.pixels, &tone)?;
        let d = exact.as_ref().map(|(e, _)| radiosity_difference(&s, e));
        let paper = s.report.counts.iter().find(|c| c.0 == PAPER_PAIRS);
        let text = |d: Option<f64>| d.map_or("–".into(), percent);
        rows.push(vec![
            name.to_string(),
            word.to_string(),
            paper.map_or(0, |p| p.1).to_string(),
            number(seconds, 3),
            text(d.map(|d| d[0].0)),
            text(d.map(|d| d[0].1)),
            text(d.map(|d| d[1].0)),
            text(d.map(|d| d[1].1)),
        ]);
        if exact.is_none() {
            exact = Some((s, exposure));
        }
    }
    Ok(rows)
}
