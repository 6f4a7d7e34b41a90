//! A solution's zones against paths of light.

use crate::zone_sampling::{self, detector};
use crate::{CommandArguments, CommandOutcome};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::Path;
use zonal_io::{input, output};
use zonal_reference::Rng;
use zonal_reference::path_tracer::{Detector, DetectorReading, PathTracer, TracingAccuracy};
use zonal_scene::{Band, Bands, Scene, Solution, Zones};

/// Zones below this share of the mean do not count into the pointwise error.
const MIN_SHARE_OF_MEAN: f64 = 0.1;

/// Zones of one kind that were picked, by their global index.
struct SampledZones {
    quantity: &'static str,
    zones: Vec<usize>,
    readings: Vec<DetectorReading>,
}

/// Picks, measures, compares.
pub(crate) fn run(arguments: &CommandArguments) -> CommandOutcome {
    let file = arguments.text("--solution").ok_or("give --solution RUN.npz")?;
    let solution = output::read_solution(Path::new(file))?;
    let own = arguments.plain().map(|p| input::read_scene(Path::new(p))).transpose()?;
    let scene = own.as_ref().unwrap_or(&solution.scene);
    if !same(scene, &solution.scene) {
        return Err(
            format!("{file}: its facets, panes or cells are not the scene's; solve the scene again").into()
        );
    }
    let tracer = PathTracer::new(scene);
    let accuracy = TracingAccuracy {
        relative: arguments.number("--error", 0.01)?,
        floor: MIN_SHARE_OF_MEAN,
        max_paths: arguments.number("--max-paths", TracingAccuracy::default().max_paths)?,
    };
    let seed: u64 = arguments.number("--seed", 1)?;
    let by_size = match arguments.text("--pick").unwrap_or("uniform") {
        "uniform" => false,
        "area" => true,
        other => return Err(format!("--pick {other}: give uniform or area").into()),
    };
    let zones = &solution.zones;
    let kinds = [
        ("H", 0..zones.voxel_offset(), arguments.number("--patches", 200)?),
        ("G", zones.voxel_offset()..zones.pane_offset(), arguments.number("--voxels", 200)?),
        ("G pane", zones.pane_offset()..zones.len(), arguments.number("--panes", 0)?),
    ];
    let mut groups = Vec::new();
    for (k, (quantity, range, count)) in kinds.into_iter().enumerate() {
        let picked = pick(zones, range, count, by_size, seed.wrapping_mul(8).wrapping_add(k as u64));
        let receivers: Vec<Detector> = picked.iter().map(|&i| detector(scene, zones, i)).collect();
        let readings = tracer.measure(&receivers, &accuracy, seed.wrapping_mul(8).wrapping_add(4 + k as u64));
        if !picked.is_empty() {
            groups.push(SampledZones { quantity, zones: picked, readings });
        }
    }
    let rows: Vec<ZoneRow> = groups
        .iter()
        .flat_map(|g| [ZoneRow::new(&solution, g, false), ZoneRow::new(&solution, g, true)])
        .collect();
    if arguments.flag("--json") {
        println!("{:#}", Value::Array(rows.iter().map(ZoneRow::json).collect()));
    } else {
        print!("{}", table(&rows));
    }
    if let Some(path) = arguments.text("--table") {
        output::write_bytes(Path::new(path), listing(&solution, &groups).as_bytes())?;
    }
    Ok(true)
}

/// True when zones of one scene are zones of the other.
fn same(a: &Scene, b: &Scene) -> bool {
    let dims = |s: &Scene| s.voxel_grid().map(|m| m.dims());
    (a.facets().len(), a.panes().len(), dims(a)) == (b.facets().len(), b.panes().len(), dims(b))
}

/// Zones at random: each at most once with equal chances, or by size with repetition.
fn pick(zones: &Zones, range: std::ops::Range<usize>, count: usize, by_size: bool, seed: u64) -> Vec<usize> {
    if !by_size {
        return zone_sampling::pick(range, count, seed);
    }
    let mut rng = Rng::new(seed);
    let all: Vec<usize> = range.collect();
    if all.is_empty() {
        return Vec::new();
    }
    let mut sum = 0.0;
    let cumulative: Vec<f64> = all
        .iter()
        .map(|&i| {
            sum += zones.zone(i).size();
            sum
        })
        .collect();
    let at = |u: f64| all[cumulative.partition_point(|&c| c <= u * sum).min(all.len() - 1)];
    (0..count).map(|_| at(rng.uniform())).collect()
}

/// A compared zone.
struct ZoneRow {
    quantity: String,
    zones: usize,
    l2: f64,
    noise: f64,
    pointwise: f64,
    bias: f64,
    error: f64,
    covered: Option<f64>,
    covered_with_noise: Option<f64>,
    ratio: Option<f64>,
    paths: f64,
}

impl ZoneRow {
    /// Compares `incident`, or all light where `total`.
    fn new(s: &Solution, g: &SampledZones, total: bool) -> ZoneRow {
        let ours = |i: usize| -> Bands {
            let (a, d) = (s.fields.incident[i], s.fields.direct_light(i));
            if total { a + d } else { a }
        };
        let truth = |r: &DetectorReading| if total { r.total } else { r.incident };
        let n = g.zones.len() as f64;
        let mean = Bands::from_fn(|b| g.readings.iter().map(|r| truth(r)[b].value).sum::<f64>() / n);
        let (mut d2, mut r2, mut e2, mut sum) = (0.0, 0.0, 0.0, [0.0; 2]);
        let (mut relative, mut errors, mut lit) = (0.0, 0.0, 0.0f64);
        let (mut inside, mut inside_noise, mut count, mut ratios) = (0.0, 0.0, 0.0, Vec::new());
        for (&i, r) in g.zones.iter().zip(&g.readings) {
            for b in Band::all().filter(|&b| mean[b] > 0.0) {
                let (x, t) = (ours(i)[b], truth(r)[b]);
                let d = (x - t.value).abs();
                d2 += d * d;
                r2 += t.value * t.value;
                e2 += t.error * t.error;
                sum = [sum[0] + x, sum[1] + t.value];
                if t.value > MIN_SHARE_OF_MEAN * mean[b] {
                    relative += (d / t.value).powi(2);
                    errors += t.error / t.value;
                    lit += 1.0;
                }
                let own = s.fields.error[i][b];
                inside += f64::from(u8::from(d <= 2.0 * own));
                inside_noise += f64::from(u8::from(d <= 2.0 * (own + t.error)));
                count += 1.0;
                if d > 0.0 {
                    ratios.push(own / d);
                }
            }
        }
        ratios.sort_by(f64::total_cmp);
        let estimated = !total && !ratios.is_empty();
        ZoneRow {
            quantity: format!("{} {}", g.quantity, if total { "total" } else { "incident" }),
            zones: g.zones.len(),
            l2: (d2 / r2).sqrt(),
            noise: (e2 / r2).sqrt(),
            pointwise: (relative / lit.max(1.0)).sqrt(),
            bias: sum[0] / sum[1] - 1.0,
            error: errors / lit.max(1.0),
            covered: estimated.then_some(inside / count),
            covered_with_noise: estimated.then_some(inside_noise / count),
            ratio: estimated.then(|| ratios[ratios.len() / 2]),
            paths: g.readings.iter().map(|r| r.paths as f64).sum(),
        }
    }

    fn json(&self) -> Value {
        json!({
            "quantity": self.quantity, "zones": self.zones, "l2": self.l2, "l2_of_noise": self.noise,
            "pointwise": self.pointwise, "bias": self.bias, "mean_standard_error": self.error,
            "covered": self.covered, "covered_with_noise": self.covered_with_noise,
            "median_estimate_over_error": self.ratio, "paths": self.paths,
        })
    }
}

fn table(rows: &[ZoneRow]) -> String {
    let mut t = String::from(
        "quantity       zones       L2  of noise  pointwise     bias  mean s.e.  covered  (+noise)  est/err     paths\n",
    );
    let percent = |x: f64| format!("{:.2} %", 100.0 * x);
    let maybe = |x: Option<f64>| x.map_or("–".into(), |x| format!("{:.1} %", 100.0 * x));
    for r in rows {
        let _ = writeln!(
            t,
            "{:<14} {:>5} {:>8} {:>9} {:>10} {:>8} {:>10} {:>8} {:>9} {:>8} {:>9.2e}",
            r.quantity,
            r.zones,
            percent(r.l2),
            percent(r.noise),
            percent(r.pointwise),
            percent(r.bias),
            percent(r.error),
            maybe(r.covered),
            maybe(r.covered_with_noise),
            r.ratio.map_or("–".into(), |x| format!("{x:.2}")),
            r.paths
        );
    }
    t
}

/// One line a zone.
fn listing(s: &Solution, groups: &[SampledZones]) -> String {
    let mut t = String::from(
        "quantity,zone,x,y,z,size,band,incident,error,direct,mc_incident,mc_incident_se,mc_total,mc_total_se,paths\n",
    );
    for g in groups {
        for (&i, r) in g.zones.iter().zip(&g.readings) {
            let zone = s.zones.zone(i);
            let c = zone.centre();
            for b in Band::all() {
                let f = &s.fields;
                let _ = writeln!(
                    t,
                    "{},{i},{},{},{},{},{},{},{},{},{},{},{},{},{}",
                    g.quantity,
                    c.x,
                    c.y,
                    c.z,
                    zone.size(),
                    b.index(),
                    f.incident[i][b],
                    f.error[i][b],
                    f.direct_light(i)[b],
                    r.incident[b].value,
                    r.incident[b].error,
                    r.total[b].value,
                    r.total[b].error,
                    r.paths
                );
            }
        }
    }
    t
}
