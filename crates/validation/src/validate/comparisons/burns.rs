//! Section 8: the cube of Burns and Christon, whose extinction varies.

use crate::validate::box_scene::WALL_NAMES;
use crate::validate::case::{AcceptanceLimit, CaseOutcome, ProfilePlot, ValidationCase};
use crate::validate::case_context::CaseContext;
use crate::validate::data::table;
use crate::validate::exact::square::interpolate;
use crate::validate::measures::voxel_value;
use crate::validate::richardson::ResolutionSequence;
use std::fmt::Write as _;
use zonal_report::Failure;
use zonal_scene::Solution;

/// Odd, so that a zone stands in the middle.
const RESOLUTIONS: [usize; 4] = [5, 7, 11, 21];

/// The cases.
pub(crate) const CASES: [ValidationCase; 1] = [ValidationCase {
    name: "burns-christon",
    group: "8 Cube of varying extinction",
    title: "Burns and Christon (1997), divergence of the flux",
    about: "κ = 0.9(1−2|x|)(1−2|y|)(1−2|z|) + 0.1 in a unit cube about the origin, σT⁴ = 1 throughout, cold black walls: 21³ voxels with the volume means of κ, every pair by the dense engine \
        through what lies between. Divergence κ(x)(4 − G) at (x, 0, 0) with κ at the point and the fluence G between the centres of the zones; the flux at the middle of a wall as the mean over the \
        patch there. Limit: 1 %.",
    quick: false,
    needs: None,
    run,
}];

/// Mean of 1 − 2|x| over the cell i of n in [−½, ½].
fn tent(i: usize, n: usize) -> f64 {
    let h = 1.0 / n as f64;
    let (a, b) = (i as f64 * h - 0.5, (i + 1) as f64 * h - 0.5);
    // ∫ (1 − 2|x|) = x − x|x|.
    let f = |x: f64| x - x * x.abs();
    (f(b) - f(a)) / h
}

fn scene(bench: &CaseContext, n: usize) -> Result<String, Failure> {
    let mut kappa = Vec::with_capacity(n.pow(3));
    for i in 0..n {
        for j in 0..n {
            kappa.extend((0..n).map(|k| 0.9 * tent(i, n) * tent(j, n) * tent(k, n) + 0.1));
        }
    }
    let file = bench.array(&format!("burns-christon-{n}"), &[n; 3], &kappa)?;
    let bounds = "min = [-0.5, -0.5, -0.5]\nmax = [0.5, 0.5, 0.5]";
    let inline = bounds.replace('\n', ", ");
    let mut t =
        String::from("name = \"burns-christon\"\n\n[solve]\npatch_rule = \"voxels\"\nengine = \"dense\"\n");
    let _ = write!(
        t,
        "\n[medium]\n{bounds}\ncells = [{n}, {n}, {n}]\n\n[[medium.region]]\ndensity = {{ file = {file:?}, {inline} }}\nemission = 1\n"
    );
    let _ = write!(t, "\n[[surface]]\nname = \"walls\"\nroom = {{ {inline} }}\nreflectance = 0\n");
    Ok(t)
}

/// Irradiance in the middle of the walls, their mean.
fn middle(s: &Solution) -> f64 {
    let at = |face: &str| {
        let all = s.zones.patches.iter().enumerate();
        let of = all.filter(|(_, p)| s.scene.surfaces()[p.surface].name.ends_with(face));
        let centre = |p: &zonal_scene::Patch| {
            let c = p.plate.centre();
            c.x * c.x + c.y * c.y + c.z * c.z
        };
        let best = of.min_by(|a, b| centre(a.1).total_cmp(&centre(b.1)));
        best.map_or(f64::NAN, |(i, _)| s.fields.incident[i].first())
    };
    WALL_NAMES.iter().map(|f| at(f)).sum::<f64>() / 6.0
}

fn run(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let (mut centre, mut wall) = (Vec::new(), Vec::new());
    for n in RESOLUTIONS {
        let s = bench.solve(&format!("burns-christon-{n}"), &scene(bench, n)?)?;
        let line: Vec<f64> = (0..n).map(|k| voxel_value(&s, &s.fields.incident, [k, n / 2, n / 2])).collect();
        let divergence = |x: f64| (0.9 * (1.0 - 2.0 * x.abs()) + 0.1) * (4.0 - interpolate(&line, x + 0.5));
        centre.push((n as f64, divergence(0.0)));
        wall.push((n as f64, middle(&s)));
        if n != RESOLUTIONS[RESOLUTIONS.len() - 1] {
            continue;
        }
        let curve = (0..=40).map(|k| 0.0125 * k as f64).map(|x| (x, divergence(x))).collect();
        let mut profile = ProfilePlot {
            file: "burns-christon-line".into(),
            title: "Burns and Christon: divergence of the flux along the axis".into(),
            x: "x, m".into(),
            y: "div q / σT⁴, 1/m".into(),
            ours: vec![(format!("ours, {n}³"), curve)],
            reference: vec![("reference".into(), Vec::new())],
        };
        for row in table!("burns_christon.csv")?.rows() {
            let x = row.number("x")?;
            profile.reference[0].1.push((x.abs(), row.number("value")?));
            out.check(
                format!("x = {x}: div q"),
                row.number("value")?,
                divergence(x),
                AcceptanceLimit::Relative(0.01),
            );
        }
        out.profiles.push(profile);
        out.check("flux at the middle of a wall", 0.18801393, middle(&s), AcceptanceLimit::Relative(0.01));
        out.note(format!(
            "{} zones; the engine's own estimate of the error of G: {:.2} %.",
            s.zones.len(),
            100.0 * s.report.estimate.volumes.first()
        ));
    }
    out.sequences.push(ResolutionSequence::new("div q in the middle", centre, Some((3.07560844, 5e-9))));
    out.sequences.push(ResolutionSequence::new(
        "flux at the middle of a wall",
        wall,
        Some((0.18801393, 5e-9)),
    ));
    Ok(out)
}
