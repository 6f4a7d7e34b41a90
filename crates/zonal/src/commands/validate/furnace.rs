//! Section 9: a furnace of 2 × 2 × 4 m with a source, after Mengüç and Viskanta.

use super::bench::{Bench, Room, Wall, voxel};
use super::case::{Case, Limit, Outcome};
use super::data::{Row, table};
use super::factors::SIGMA;
use super::richardson::Sequence;
use crate::Failure;
use zonal_scene::Solution;

/// Extinction, 1/m.
const BETA: f64 = 0.5;
/// Source, W/m³.
const SOURCE: f64 = 5000.0;
/// Temperature (K) and emissivity of the walls: z = 0, z = 4, the sides.
const WALLS: [(f64, f64); 3] = [(1200.0, 0.85), (400.0, 0.70), (900.0, 0.70)];
/// Zones a metre of the sequence; the first four are those of the table.
const SIZES: [usize; 8] = [2, 4, 5, 6, 8, 12, 16, 24];

/// The cases.
pub const CASES: [Case; 1] = [Case {
    name: "furnace",
    group: "9 Furnace with a source",
    title: "net wall fluxes and gas temperatures",
    about: "2 × 2 × 4 m, extinction 0.5 1/m, source 5 kW/m³, z = 0 at 1200 K (ε 0.85), z = 4 at 400 K (0.70), sides at 900 K (0.70). With its source a medium in balance sends on all that it takes: it \
        is solved as one that scatters all and has a source, and the temperatures follow from E_b = Q/(4κ) + (S − Q/(4β)). Zones of 1/m of one radiosity each: all printed digits; \
        extrapolated: within the reference's brackets; temperatures on the axis ± 1 K as stated; zone values and the side wall's fluxes to the digits printed.",
    quick: false,
    needs: None,
    run,
}];

fn emission((t, e): (f64, f64)) -> f64 {
    e * SIGMA * t.powi(4)
}

fn solve(bench: &Bench, m: usize) -> Result<Solution, Failure> {
    let name = format!("furnace-{m}");
    let mut room = Room::new([2.0, 2.0, 4.0], [2 * m, 2 * m, 4 * m], BETA)
        .medium(&format!("albedo = 1\nsource = {SOURCE:?}"))
        .solve(&format!("engine = \"spectral\"\n{}", super::cube::PLAIN));
    for face in 0..6 {
        let wall = WALLS[if face < 4 { 2 } else { face - 4 }];
        room = room.wall(face, 1.0 - wall.1, emission(wall));
    }
    bench.solve(&name, &room.text(&name))
}

/// Mean net fluxes into z = 0, z = 4 and the sides, kW/m².
fn fluxes(s: &Solution) -> [f64; 3] {
    let into = |face: &str| -Wall::of(s, face).net() / 1e3;
    let sides = ["x0", "x1", "y0", "y1"].map(into);
    [into("z0"), into("z1"), sides.iter().sum::<f64>() / 4.0]
}

/// The temperature of gas of the source function S, K.
fn temperature(s: f64, albedo: f64) -> f64 {
    let black = SOURCE / (4.0 * BETA * (1.0 - albedo)) + (s - SOURCE / (4.0 * BETA));
    (black / SIGMA).powf(0.25)
}

/// The source function of the four zones about the axis in layer k.
fn axis(s: &Solution, m: usize, k: usize) -> f64 {
    let four = [[m - 1, m - 1], [m, m - 1], [m - 1, m], [m, m]];
    four.iter().map(|&[i, j]| voxel(s, &s.fields.radiosity, [i, j, k])).sum::<f64>() / 4.0
}

/// The source function on the axis at the height z: a parabola through three layers, across and along.
fn on_axis(s: &Solution, m: usize, z: f64) -> f64 {
    let layers: Vec<f64> = (0..4 * m)
        .map(|k| {
            // An even function across: from the two zones nearest the axis to the axis itself.
            let at = |d: usize| {
                let c = |i: usize, j: usize| voxel(s, &s.fields.radiosity, [i, j, k]);
                [c(m - 1 - d, m - 1 - d), c(m + d, m - 1 - d), c(m - 1 - d, m + d), c(m + d, m + d)]
                    .iter()
                    .sum::<f64>()
                    / 4.0
            };
            at(0) + (at(0) - at(1)) / 8.0
        })
        .collect();
    super::square::between(&layers, z / 4.0)
}

fn run(bench: &Bench) -> Result<Outcome, Failure> {
    let mut out = Outcome::default();
    let table = table!("furnace.csv")?;
    let rows: Vec<Row> = table.rows().collect();
    let mut steps = [const { Vec::new() }; 3];
    for m in SIZES {
        let s = solve(bench, m)?;
        let found = fluxes(&s);
        steps.iter_mut().zip(found).for_each(|(s, q)| s.push((m as f64, q)));
        if let Some(row) = rows.iter().find(|r| r.number("m").is_ok_and(|n| n == m as f64)) {
            for (column, q) in ["z0", "z4", "sides"].into_iter().zip(found) {
                let p = row.printed(column)?;
                out.check(format!("m = {m}: net q, {column}, kW/m²"), p.value, q, Limit::Absolute(p.half));
            }
            let total = 4.0 * (found[0] + found[1]) + 32.0 * found[2];
            out.check(format!("m = {m}: total, kW"), 80.0, total, Limit::Absolute(1e-6));
        }
        if m == 6 {
            profile(&mut out, &s, m)?;
        }
        if m == SIZES[SIZES.len() - 1] {
            gas(&mut out, &s, m)?;
        }
    }
    let last = rows.iter().find(|r| r.number("m").is_ok_and(|n| n == 0.0));
    for ((steps, column), bracket) in steps.into_iter().zip(["z0", "z4", "sides"]).zip([0.01, 0.003, 0.001]) {
        let Some(row) = last else { continue };
        let p = row.number(column)?;
        let sequence = Sequence::new(format!("net q, {column}, kW/m²"), steps, Some((p, bracket)));
        out.check(
            format!("extrapolated: net q, {column}, kW/m²"),
            p,
            sequence.value(),
            Limit::Absolute(bracket),
        );
        out.sequences.push(sequence);
    }
    Ok(out)
}

/// Zone values beside the axis and along the side wall.
fn profile(out: &mut Outcome, s: &Solution, m: usize) -> Result<(), Failure> {
    for row in table!("furnace_gas.csv")?.rows() {
        let (z, p) = (row.number("z")?, row.printed("value")?);
        let k = (z * m as f64) as usize;
        match row.text("kind")? {
            "zone" => {
                let t = temperature(axis(s, m, k), 0.0);
                out.check(format!("m = 6: T of the zone at z = {z}, K"), p.value, t, Limit::Absolute(p.half));
            }
            "side" => {
                let q = side(s, m, z);
                out.check(format!("m = 6: side wall, z = {z}, kW/m²"), p.value, q, Limit::Absolute(p.half));
            }
            _ => {}
        }
    }
    Ok(())
}

/// Net flux into the two patches beside the middle of the wall x = 0 at the height z, kW/m².
fn side(s: &Solution, m: usize, z: f64) -> f64 {
    let half = 0.5 / m as f64;
    let near = s.zones.patches.iter().enumerate().filter(|(_, p)| {
        let c = p.plate.centre();
        s.scene.surfaces()[p.surface].name.ends_with("x0")
            && (c.y - 1.0).abs() < 2.0 * half
            && (c.z - z).abs() < half
    });
    let net = near.map(|(i, _)| (s.fields.incident[i][0] - s.fields.radiosity[i][0]) / 1e3);
    let (count, sum) = net.fold((0.0, 0.0), |(n, s), q| (n + 1.0, s + q));
    sum / count
}

/// Temperatures on the axis.
fn gas(out: &mut Outcome, s: &Solution, m: usize) -> Result<(), Failure> {
    for row in table!("furnace_gas.csv")?.rows() {
        let Some(albedo) = row.text("kind")?.strip_prefix("axis ") else { continue };
        let omega: f64 = albedo.parse().unwrap_or(f64::NAN);
        let (z, p) = (row.number("z")?, row.printed("value")?);
        let t = temperature(on_axis(s, m, z), omega);
        out.check(format!("albedo {albedo}: T on the axis at z = {z}, K"), p.value, t, Limit::Absolute(1.0));
    }
    Ok(())
}
