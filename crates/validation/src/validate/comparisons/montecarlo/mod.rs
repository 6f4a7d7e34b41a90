//! The Monte Carlo cases: seven unit cubes with tables of irradiance and fluence, two with pictures.
//!
//! Our zones are averaged down to the tables' 10×10 patches a wall and 10³ voxels, and compared with `*_sym` where it exists.

mod binned;
pub mod cubes;
mod pictures;

use crate::validate::case::{AcceptanceLimit, CaseOutcome, CasePicture, ValidationCase};
use crate::validate::case_context::CaseContext;
use crate::validate::measures::rms;
use crate::validate::richardson::ResolutionSequence;
use cubes::{CUBES, MonteCarloCube};
use std::path::{Path, PathBuf};
use zonal_report::Failure;
use zonal_scene::Solution;

/// Where the tables are, below the reference folder.
pub(crate) const TABLES_FOLDER: &str = "reference/montecarlo";
/// Entries below this share of the mean do not count into the pointwise error.
const MIN_SHARE_OF_MEAN: f64 = 0.1;
/// Voxels along an edge.
const RESOLUTIONS: [usize; 4] = [10, 20, 40, 60];

/// Difference of a field from its table.
#[derive(Clone, Copy, Debug, Default)]
pub struct TableDifference {
    /// RMS of the difference over RMS of the table.
    pub l2: f64,
    /// RMS of the relative difference over entries above a tenth of the mean.
    pub pointwise: f64,
    /// RMS and largest modulus of the relative difference over all entries above zero.
    pub all: (f64, f64),
    /// The table's own RMS relative standard error.
    pub noise: f64,
}

impl TableDifference {
    /// Of values beside a table and its standard errors.
    pub fn new(ours: &[f64], table: &[f64], errors: &[f64]) -> TableDifference {
        let mean = table.iter().sum::<f64>() / table.len() as f64;
        let pairs = || ours.iter().zip(table).map(|(o, t)| (o - t, *t));
        let above = |least: f64| pairs().filter(move |p| p.1 > least).map(|(d, t)| d / t);
        let relative = errors.iter().zip(table).filter(|p| *p.1 > 0.0).map(|(e, t)| e / t);
        TableDifference {
            l2: rms(pairs().map(|p| p.0)) / rms(table.iter().copied()),
            pointwise: rms(above(MIN_SHARE_OF_MEAN * mean)),
            all: (rms(above(0.0)), above(0.0).fold(0.0, |m, x| m.max(x.abs()))),
            noise: rms(relative),
        }
    }
}

/// A solve beside its tables.
pub struct TableComparison {
    /// Irradiance of the walls.
    pub h: TableDifference,
    /// Fluence of the medium.
    pub g: TableDifference,
    /// Irradiance of the block, where there is one.
    pub block: Option<TableDifference>,
}

impl TableComparison {
    /// Compares a solution of a cube with the tables in a folder.
    pub fn new(s: &Solution, c: &MonteCarloCube, folder: &Path) -> Result<TableComparison, Failure> {
        let (walls, block, gas) = binned::cell_means(s)?;
        let difference = |ours: &[f64], q: &str| {
            let (table, errors) = c.read(folder, q)?;
            Ok::<_, Failure>(TableDifference::new(ours, &table, &errors))
        };
        Ok(TableComparison {
            h: difference(&walls, "H")?,
            g: difference(&gas, "G")?,
            block: if c.block { Some(difference(&block, "Hocc")?) } else { None },
        })
    }
}

const CASE_GROUP: &str = "Monte Carlo";

const fn case(
    name: &'static str,
    title: &'static str,
    about: &'static str,
    run: fn(&CaseContext) -> Result<CaseOutcome, Failure>,
) -> ValidationCase {
    ValidationCase { name, group: CASE_GROUP, title, about, quick: false, needs: Some(TABLES_FOLDER), run }
}

/// The cases.
pub(crate) const CASES: [ValidationCase; 8] = [
    case(
        "mc-c0",
        "κL = 1, albedo 0.9, walls 0.5, one hot; and its picture",
        "RMS of the relative difference over all entries of the table, the table's own noise (s.e.) left in: at most 0.25 % at 40³. The picture is drawn at 64×64 from the solution of 40³: √(⟨d²⟩ − ⟨σ²⟩) at most 1 % of \
        the mean, blocks of 8 × 8 pixels at most 0.7 % RMS.",
        |b| uniform(b, "c0"),
    ),
    case("mc-c1", "κL = 0.1, no scattering, black walls, one hot", SAME_LIMIT_AS_C0, |b| uniform(b, "c1")),
    case("mc-c3", "κL = 1, albedo 0.5, black walls, one hot", SAME_LIMIT_AS_C0, |b| uniform(b, "c3")),
    case(
        "mc-c5",
        "κL = 5, albedo 0.5, walls 0.5, one hot",
        "As c0. Zones are thick here, a quarter of a mean free path at 20³, and one radiosity a zone (`zone_basis = \"constant\"`) converges slowly: at most 0.8 % at 40³. With slopes: `thick-tables`.",
        |b| uniform(b, "c5"),
    ),
    case("mc-c10", "κL = 1, albedo 0.5, hot medium between cold walls 0.5", SAME_LIMIT_AS_C0, |b| {
        uniform(b, "c10")
    }),
    case(
        "mc-c8",
        "extinction that varies, albedo 0.9, one hot wall",
        "The dense engine at 10³: zones as coarse as the table's, so that the difference is that of the zones: informational; `cargo run --release -p zonal-campaigns -- montecarlo` goes finer.",
        |b| coarse(b, "c8"),
    ),
    case(
        "mc-c9",
        "κL = 1, a block inside",
        "The dense engine at 10³, with the occlusion of the block; informational, as c8.",
        |b| coarse(b, "c9"),
    ),
    case(
        "mc-order",
        "c0: means of H and G against resolution, and the z-test",
        "Convergence of the zones' values below the noise of the tables. The mean irradiance of the wall opposite the hot one and the fluence of the medium, extrapolated.",
        order,
    ),
];

const SAME_LIMIT_AS_C0: &str = "As c0: at most 0.25 % at 40³.";

fn cube(name: &str) -> Result<&'static MonteCarloCube, Failure> {
    CUBES.iter().find(|c| c.name == name).ok_or_else(|| Failure::new(format!("there is no cube {name}")))
}

fn solve(bench: &CaseContext, c: &MonteCarloCube, n: usize, lines: &str) -> Result<Solution, Failure> {
    let name = format!("{}-{n}", c.name);
    let density = if c.varies() {
        let (shape, values) = c.extinction(&tables(bench))?;
        bench.array(&name, &shape, &values)?
    } else {
        String::new()
    };
    bench.solve(&name, &c.text(n, lines, &density))
}

fn tables(bench: &CaseContext) -> PathBuf {
    bench.reference.join(TABLES_FOLDER)
}

/// RMS of the relative difference that a cube is held to at 40³.
fn limit(name: &str) -> f64 {
    if name == "c5" { 0.8e-2 } else { 0.25e-2 }
}

/// A cube of uniform extinction by the spectral engine, `settings` more lines of its `[solve]`.
pub(crate) fn spectral(
    bench: &CaseContext,
    name: &str,
    n: usize,
    settings: &str,
) -> Result<(Solution, TableComparison), Failure> {
    let c = cube(name)?;
    let s = solve(bench, c, n, &format!("engine = \"spectral\"\npatch_rule = \"voxels\"\n{settings}"))?;
    let compared = TableComparison::new(&s, c, &tables(bench))?;
    Ok((s, compared))
}

fn uniform(bench: &CaseContext, name: &str) -> Result<CaseOutcome, Failure> {
    let c = cube(name)?;
    let mut out = CaseOutcome::default();
    let (mut h, mut g) = (Vec::new(), Vec::new());
    let mut noise = [0.0; 2];
    for n in RESOLUTIONS {
        let (s, d) = spectral(bench, name, n, crate::validate::exact::cube::CONSTANT_BASIS)?;
        h.push((n as f64, d.h.all.0));
        g.push((n as f64, d.g.all.0));
        noise = [d.h.noise, d.g.noise];
        for (what, d) in [("H", d.h), ("G", d.g)] {
            if n == 40 {
                out.error(format!("{n}³: {what}, RMS of the relative difference"), d.all.0, limit(name));
                out.informational(format!("{n}³: {what}, RMS difference over RMS"), 0.0, d.l2);
                out.informational(format!("{n}³: {what}, largest relative difference"), 0.0, d.all.1);
                out.informational(format!("{what}: standard error of the table"), 0.0, d.noise);
            } else {
                out.informational(format!("{n}³: {what}, RMS of the relative difference"), 0.0, d.all.0);
            }
        }
        if c.picture && n == 40 {
            picture(bench, &mut out, &s, c)?;
        }
    }
    for (what, steps, noise) in [("H", h, noise[0]), ("G", g, noise[1])] {
        let limit = Err("the tables' noise is left when the zones' own error is gone".into());
        let name = format!("{what}, RMS of the relative difference");
        out.sequences.push(ResolutionSequence { name, steps, reference: Some((0.0, noise)), limit });
    }
    Ok(out)
}

fn picture(
    bench: &CaseContext,
    out: &mut CaseOutcome,
    s: &Solution,
    c: &MonteCarloCube,
) -> Result<(), Failure> {
    let p = pictures::compare(s, c.file, &tables(bench), bench.progress)?;
    out.error("picture: √(⟨d²⟩ − ⟨σ²⟩) over the mean", p.difference, 1e-2);
    out.error("picture: blocks of 8 × 8 pixels, RMS", p.blocks, 0.7e-2);
    out.informational("picture: mean, relative difference", 0.0, p.mean);
    out.informational("picture: noise of the reference", 0.0, p.noise);
    if let Some(folder) = bench.pictures {
        let file = format!("picture-{}.png", c.name);
        p.write(&folder.join(&file))?;
        let caption = "ours at 40³, the reference, four times the difference about grey".into();
        out.pictures.push(CasePicture { file, caption });
    }
    Ok(())
}

fn coarse(bench: &CaseContext, name: &str) -> Result<CaseOutcome, Failure> {
    let (c, folder) = (cube(name)?, tables(bench));
    let mut out = CaseOutcome::default();
    let s = solve(bench, c, 10, "engine = \"dense\"")?;
    let d = TableComparison::new(&s, c, &folder)?;
    for (what, d) in [("H", Some(d.h)), ("G", Some(d.g)), ("H of the block", d.block)] {
        let Some(d) = d else { continue };
        out.informational(format!("10³: {what}, RMS of the relative difference"), 0.0, d.all.0);
        out.informational(format!("10³: {what}, RMS difference over RMS"), 0.0, d.l2);
        out.informational(format!("{what}: standard error of the table"), 0.0, d.noise);
    }
    Ok(out)
}

fn order(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let c = cube("c0")?;
    let mut out = CaseOutcome::default();
    let (mut h, mut g) = (Vec::new(), Vec::new());
    for n in [10, 16, 24, 32, 48, 64] {
        let (s, _) = spectral(bench, "c0", n, crate::validate::exact::cube::CONSTANT_BASIS)?;
        let voxels = &s.fields.incident[s.zones.voxel_offset()..];
        h.push((n as f64, crate::validate::measures::WallMeans::of(&s, "x1").incident));
        g.push((n as f64, voxels.iter().map(|v| v.first()).sum::<f64>() / voxels.len() as f64));
    }
    // The tables' means and their standard errors, those of independent entries.
    let means = |quantity: &str, from: usize, count: usize| -> Result<(f64, f64), Failure> {
        let (values, errors) = c.read(&tables(bench), quantity)?;
        let n = count as f64;
        let mean = values[from..from + count].iter().sum::<f64>() / n;
        Ok((mean, errors[from..from + count].iter().map(|e| e * e).sum::<f64>().sqrt() / n))
    };
    for (what, steps, (mean, se)) in
        [("mean H of the wall x1", h, means("H", 100, 100)?), ("mean G", g, means("G", 0, 1000)?)]
    {
        let sequence = ResolutionSequence::new(what, steps, Some((mean, se)));
        // Entries of a symmetrised table repeat: eight share a noise at most, so that their mean has √8 of this error at most.
        let most = 4.0 * 8f64.sqrt() * se;
        out.check(
            format!("{what}, extrapolated; limit 4 s.e."),
            mean,
            sequence.value(),
            AcceptanceLimit::Absolute(most),
        );
        out.sequences.push(sequence);
    }
    Ok(out)
}
