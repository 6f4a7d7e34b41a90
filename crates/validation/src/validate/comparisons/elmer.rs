//! Elmer: radiators above an open slab, and conduction coupled to grey diffuse radiation in a cavity.

use crate::validate::case::{AcceptanceLimit, CaseOutcome, ValidationCase};
use crate::validate::case_context::CaseContext;
use crate::validate::exact::conduction::{SquareMatrix, TetrahedralMesh, dot, net_fluxes};
use std::fmt::Write as _;
use std::path::Path;
use zonal_exchange::pair::{Exchange, PairCounts, PairSettings, scaled_radiosity_coefficient};
use zonal_report::Failure;
use zonal_scene::Solution;
use zonal_transport::{Transport, build_zones};

const TESTS_FOLDER: &str = "data/thermal-elmer/fem/tests";

/// The cases.
pub(crate) const CASES: [ValidationCase; 2] = [
    ValidationCase {
        name: "elmer-open",
        group: "Other solvers",
        title: "Elmer, radiator3d_open: absorption of two radiators by a slab",
        about: "Two points of 10 and 20 kW stand 0.2 m above a black slab of 1 m², an open scene; Elmer's reference norm is the power that the slab takes, 6830.46770 W (its tolerance 10⁻⁴). Ours: voxels of 1 mm that \
            scatter all and give that power, and 40 × 40 patches. Limit 2·10⁻⁴: Elmer's view factor of a point is that of the middle of each of its elements.",
        quick: true,
        needs: None,
        run: open,
    },
    ValidationCase {
        name: "elmer-cavity",
        group: "Other solvers",
        title: "Elmer, radiation3d: conduction and radiation in a closed cavity",
        about: "A heated ring in a cylindrical shell, ε = 0.6, on Elmer's own mesh of 749 tetrahedra; outside held at 100 K. Our exchange areas between the 288 triangles, hidden ones included, with linear elements for \
            the conduction (`conduction.rs`). Elmer's reference norm is the root mean square of the temperatures of the 272 nodes, 180.4353 K, its own tolerance 10⁻³, its view factors asked to 10⁻² to 10⁻³. \
            Limit 1 %.",
        quick: true,
        needs: Some("data/thermal-elmer/fem/tests/radiation3d/radiation/mesh.nodes"),
        run: cavity,
    },
];

/// Power absorbed by the black top of the slab from a radiator of `power` W at the point `at`, W.
fn absorbed(bench: &CaseContext, name: &str, at: [f64; 3], power: f64) -> Result<f64, Failure> {
    const RADIATOR_EDGE: f64 = 1e-3;
    let corner = |s: f64| at.map(|x| x + s * 0.5 * RADIATOR_EDGE);
    let text = format!(
        "name = \"{name}\"\n\n[solve]\nengine = \"dense\"\npatch_size = 0.025\n\n[medium]\nmin = {:?}\nmax = {:?}\ncells = [1, 1, 1]\nextinction = 1e-3\nalbedo = 1\nsource = {:?}\n\n\
         [[surface]]\nname = \"slab\"\nrectangle = {{ origin = [0, 0, 0.1], edge1 = [1, 0, 0], edge2 = [0, 1, 0] }}\nreflectance = 0\n",
        corner(-1.0),
        corner(1.0),
        power / RADIATOR_EDGE.powi(3)
    );
    let s: Solution = bench.solve(name, &text)?;
    let taken = &s.report.energy.absorbed_surfaces;
    Ok(taken.iter().map(|t| t.1.first()).sum())
}

fn open(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let first = absorbed(bench, "elmer-open-1", [0.15, 0.15, 0.3], 1e4)?;
    let second = absorbed(bench, "elmer-open-2", [0.85, 0.85, 0.3], 2e4)?;
    out.check("power absorbed by the slab, W", 6830.46770, first + second, AcceptanceLimit::Relative(2e-4));
    // A rectangle of sides a, b seen from a height h above its corner fills atan(ab/(h√(a²+b²+h²))).
    let angle = |a: f64, b: f64| (a * b / (0.2 * (a * a + b * b + 0.04f64).sqrt())).atan();
    let whole = angle(0.15, 0.15) + 2.0 * angle(0.15, 0.85) + angle(0.85, 0.85);
    let exact = 3e4 * whole / (4.0 * std::f64::consts::PI);
    out.check(
        "the same from points, by the solid angle, W",
        exact,
        first + second,
        AcceptanceLimit::Relative(1e-5),
    );
    Ok(out)
}

/// Elmer's lines of numbers.
fn lines(path: &Path) -> Result<Vec<Vec<f64>>, Failure> {
    let text = std::fs::read_to_string(path).map_err(|e| Failure::in_file(path, e))?;
    let wrong = |line: &str| Failure::in_file(path, format!("'{line}' is no line of numbers"));
    text.lines().map(|l| l.split_whitespace().map(|w| w.parse().map_err(|_| wrong(l))).collect()).collect()
}

/// The mesh with its loads, as the case's .sif says.
fn mesh(folder: &Path) -> Result<TetrahedralMesh, Failure> {
    let file = |name: &str| folder.join(name);
    let short = |name: &str| Failure::in_file(&file(name), "a line is too short or has an invalid index");
    let nodes: Vec<[f64; 3]> = lines(&file("mesh.nodes"))?
        .iter()
        .map(|l| l.get(2..5).and_then(|x| x.try_into().ok()).ok_or_else(|| short("mesh.nodes")))
        .collect::<Result<_, _>>()?;
    let count = nodes.len();
    let index = |x: f64| (x as usize).checked_sub(1).filter(|i| *i < count);
    let corners =
        |l: &[f64], from: usize| -> Option<Vec<usize>> { l.get(from..)?.iter().map(|x| index(*x)).collect() };
    let mut bodies = Vec::new();
    for l in lines(&file("mesh.elements"))? {
        let c: Option<[usize; 4]> = corners(&l, 3).and_then(|c| c.try_into().ok());
        let c = c.ok_or_else(|| short("mesh.elements"))?;
        // The shell, body 1, conducts 1 W/(m K); the ring, body 2, conducts 10 and has a source of 10 kW/m³.
        bodies.push(if l[1] == 1.0 { (c, 1.0, 0.0) } else { (c, 10.0, 1e4) });
    }
    let mut mesh = TetrahedralMesh { nodes, bodies, fixed: Vec::new(), radiating: Vec::new() };
    let mut cold = vec![false; count];
    for l in lines(&file("mesh.boundary"))? {
        let c: Option<[usize; 3]> = corners(&l, 5).and_then(|c| c.try_into().ok());
        let c = c.ok_or_else(|| short("mesh.boundary"))?;
        if l[1] == 1.0 {
            c.iter().for_each(|&i| cold[i] = true);
            continue;
        }
        let parent = (l[2].max(l[3]) as usize).wrapping_sub(1);
        let parent = mesh.bodies.get(parent).ok_or_else(|| short("mesh.boundary"))?;
        // The front looks away from the solid.
        let inside = [0, 1, 2].map(|k| parent.0.iter().map(|&i| mesh.nodes[i][k]).sum::<f64>() / 4.0);
        let out = [0, 1, 2].map(|k| mesh.nodes[c[0]][k] - inside[k]);
        let front = dot(mesh.normal(c), out) > 0.0;
        mesh.radiating.push(if front { c } else { [c[0], c[2], c[1]] });
    }
    mesh.fixed = (0..count).filter(|&i| cold[i]).map(|i| (i, 100.0)).collect();
    Ok(mesh)
}

/// A⁻¹F of the radiating triangles, rows brought to a sum of 1 by a symmetric scaling, and the largest defect before.
fn shares(bench: &CaseContext, mesh: &TetrahedralMesh) -> Result<(SquareMatrix, f64), Failure> {
    let mut text = String::from(
        "name = \"elmer-cavity\"\n\n[solve]\nengine = \"dense\"\npatch_size = 10\npatch_rule = \"area\"\ntolerance = 0.002\n",
    );
    for (k, t) in mesh.radiating.iter().enumerate() {
        let corner = |i: usize| format!("{:?}", mesh.nodes[t[i]]);
        let _ = write!(
            text,
            "\n[[surface]]\nname = \"{k}\"\ntriangle = {{ corners = [{}, {}, {}] }}\nreflectance = 0.4\n",
            corner(0),
            corner(1),
            corner(2)
        );
    }
    let scene = bench.scene("elmer-cavity", &text)?;
    let transport = Transport::new(&scene);
    let zones = build_zones(&scene, &transport)?;
    let n = mesh.radiating.len();
    // Several zones a triangle where others stand on it: their areas are summed.
    let of = |i: usize| scene.surfaces()[zones.patches[i].surface].name.parse::<usize>().unwrap_or(0);
    let exchange = Exchange::with_settings(&scene, &zones, &transport, PairSettings::default());
    let mut f = SquareMatrix::new(n);
    let mut counts = PairCounts::default();
    for i in 0..zones.len() {
        let row = exchange.row(i);
        for j in 0..i {
            let area = exchange.pair_in_row(&row, j, &mut counts).value.first()
                * scaled_radiosity_coefficient(&zones, i).first()
                * scaled_radiosity_coefficient(&zones, j).first();
            f.add(of(i), of(j), area);
            f.add(of(j), of(i), area);
        }
    }
    let areas: Vec<f64> = mesh.radiating.iter().map(|t| mesh.area(*t)).collect();
    let sum = |f: &SquareMatrix, d: &[f64], i: usize| (0..n).map(|j| d[i] * f.get(i, j) * d[j]).sum::<f64>();
    let mut scale = vec![1.0; n];
    let defect = (0..n).fold(0.0f64, |m, i| m.max((sum(&f, &scale, i) / areas[i] - 1.0).abs()));
    for _ in 0..60 {
        let next: Vec<f64> = (0..n).map(|i| scale[i] * (areas[i] / sum(&f, &scale, i)).sqrt()).collect();
        scale = next;
    }
    let mut out = SquareMatrix::new(n);
    for i in 0..n {
        (0..n).for_each(|j| out.add(i, j, scale[i] * f.get(i, j) * scale[j] / areas[i]));
    }
    Ok((out, defect))
}

fn cavity(bench: &CaseContext) -> Result<CaseOutcome, Failure> {
    let mut out = CaseOutcome::default();
    let mesh = mesh(&bench.reference.join(TESTS_FOLDER).join("radiation3d/radiation"))?;
    let (shares, defect) = shares(bench, &mesh)?;
    let flux =
        net_fluxes(&shares, 0.6).ok_or_else(|| Failure::new("the cavity's radiosities have no solution"))?;
    let t = mesh.temperatures(&flux, 250.0)?;
    let norm = crate::validate::measures::rms(t.iter().copied());
    out.check(
        "root mean square of the nodes' temperatures, K",
        180.435264497,
        norm,
        AcceptanceLimit::Relative(0.01),
    );
    out.error("largest row defect of our exchange areas, before closure", defect, 0.02);
    let hottest = t.iter().fold(0.0f64, |m, x| m.max(*x));
    out.note(format!("{} triangles radiate; the hottest node has {hottest:.1} K.", mesh.radiating.len()));
    Ok(out)
}
