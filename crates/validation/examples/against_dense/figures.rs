//! Output of the comparison: lines, table, plot.

use crate::scenes::NAMED_SCENES;
use std::ops::Range;
use std::path::Path;
use zonal_io::output;
use zonal_report::plot::{LOG_LOG, Plot, SeriesMark};
use zonal_scene::{Band, Bands, Fields, Report, Scene, ZoneRef, Zones};

/// A zone's estimate covers its error up to this factor.
const COVERED_FACTOR: f64 = 2.0;
/// Zones below this share of the mean do not count into the pointwise error.
const MIN_SHARE_OF_MEAN: f64 = 0.1;
const CSV_HEADER: &str = "scene,tolerance,quantity,band,zones,L2,estimate,pointwise,estimate_over_error,within_twice,processor_s,samples_a_zone,rays_a_zone,met\n";

/// Cost of a solve.
#[derive(Clone, Copy)]
pub(crate) struct SolveCost {
    /// Processor time of the solve, s.
    pub seconds: f64,
    /// Samples of the final gather over zones.
    pub samples: f64,
    /// Stored rays over zones.
    pub rays: f64,
    /// True if the engine's estimate meets the tolerance.
    pub met: bool,
}

impl SolveCost {
    /// From a report; `zones` of them.
    pub(crate) fn new(report: &Report, zones: usize, seconds: f64) -> SolveCost {
        let sum = |name: &str| {
            let all = report.counts.iter().filter(|c| c.0 == name);
            all.fold(0.0, |s, c| s + c.1 as f64) / zones as f64
        };
        SolveCost {
            seconds,
            samples: sum("samples of the final gather"),
            rays: sum("transport_rays"),
            met: !report.warnings.iter().any(|w| w.contains("above the tolerance")),
        }
    }
}

/// One quantity of one band.
pub(crate) struct ComparisonRow {
    quantity: &'static str,
    band: &'static str,
    zones: usize,
    l2: f64,
    estimate: f64,
    pointwise: f64,
    ratio: f64,
    within: f64,
}

impl ComparisonRow {
    /// The bands of a range of zones that differ; none of an empty range.
    pub(crate) fn all(
        quantity: &'static str,
        range: Range<usize>,
        ours: &Fields,
        dense: &Fields,
        of: Bands,
    ) -> Vec<ComparisonRow> {
        if range.is_empty() {
            return Vec::new();
        }
        let grey = range.clone().all(|i| dense.incident[i].is_grey());
        let bands: Vec<(Band, &str)> = match grey {
            true => vec![(Band::first(), "all")],
            false => Band::all().zip(["R", "G", "B"]).collect(),
        };
        bands
            .into_iter()
            .map(|(b, name)| ComparisonRow::new(quantity, (b, name), range.clone(), ours, dense, of[b]))
            .collect()
    }

    fn new(
        quantity: &'static str,
        (b, band): (Band, &'static str),
        range: Range<usize>,
        ours: &Fields,
        dense: &Fields,
        estimate: f64,
    ) -> ComparisonRow {
        let (h, t, e) =
            (|i: usize| ours.incident[i][b], |i: usize| dense.incident[i][b], |i: usize| ours.error[i][b]);
        let n = range.len() as f64;
        let off = |i: usize| (h(i) - t(i)).abs();
        let mean = range.clone().map(t).sum::<f64>() / n;
        let squares = |f: &dyn Fn(usize) -> f64| range.clone().map(|i| f(i) * f(i)).sum::<f64>();
        let lit: Vec<usize> = range.clone().filter(|&i| t(i) > MIN_SHARE_OF_MEAN * mean).collect();
        let relative = lit.iter().map(|&i| (off(i) / t(i)).powi(2)).sum::<f64>();
        let mut ratio: Vec<f64> = range.clone().filter(|&i| off(i) > 0.0).map(|i| e(i) / off(i)).collect();
        ratio.sort_by(f64::total_cmp);
        ComparisonRow {
            quantity,
            band,
            zones: range.len(),
            l2: (squares(&off) / squares(&t)).sqrt(),
            estimate,
            pointwise: (relative / lit.len().max(1) as f64).sqrt(),
            ratio: ratio.get(ratio.len() / 2).copied().unwrap_or(0.0),
            within: range.clone().filter(|&i| off(i) <= COVERED_FACTOR * e(i)).count() as f64 / n,
        }
    }

    /// Violated requirements; empty if all are met.
    fn verdict(&self, tolerance: f64) -> String {
        let mut out = Vec::new();
        if self.l2 > tolerance {
            out.push("above the tolerance");
        }
        if self.l2 > self.estimate {
            out.push("above the estimate");
        }
        if !(1.0..=10.0).contains(&self.ratio) {
            out.push("estimate/error not in 1 to 10");
        }
        if self.within < 0.95 {
            out.push("fewer than 95 % within twice their estimate");
        }
        if out.is_empty() { String::new() } else { format!("  <- {}", out.join(", ")) }
    }

    /// For people.
    pub(crate) fn line(&self, tolerance: f64) -> String {
        format!(
            "    {:<6} {:<3}: L2 {:.3} % (estimated {:.3} %), pointwise {:.3} %; estimate/error {:.1} in the median, {:.1} % within twice{}",
            self.quantity,
            self.band,
            100.0 * self.l2,
            100.0 * self.estimate,
            100.0 * self.pointwise,
            self.ratio,
            100.0 * self.within,
            self.verdict(tolerance)
        )
    }

    /// For tables.
    pub(crate) fn record(&self, scene: &str, tolerance: f64, cost: &SolveCost) -> String {
        format!(
            "{scene},{tolerance},{},{},{},{:.3e},{:.3e},{:.3e},{:.2},{:.4},{:.2},{:.1},{:.1},{}\n",
            self.quantity,
            self.band,
            self.zones,
            self.l2,
            self.estimate,
            self.pointwise,
            self.ratio,
            self.within,
            cost.seconds,
            cost.samples,
            cost.rays,
            cost.met
        )
    }
}

/// Lists the patches and the volume zones with the largest differences of the first band, and their shares of the sum of squares.
pub(crate) fn list_worst(scene: &Scene, zones: &Zones, ours: &Fields, dense: &Fields, count: usize) {
    let off = |i: usize| ours.incident[i].first() - dense.incident[i].first();
    for range in [0..zones.voxel_offset(), zones.voxel_offset()..zones.len()] {
        let all: f64 = range.clone().map(|i| off(i) * off(i)).sum();
        let mut order: Vec<usize> = range.collect();
        order.sort_by(|a, b| off(*b).abs().total_cmp(&off(*a).abs()));
        for &i in order.iter().take(count) {
            println!(
                "      {}: {:.5} for {:.5}, estimated error {:.5}, {:.1} % of the squares",
                place(scene, zones, i),
                ours.incident[i].first(),
                dense.incident[i].first(),
                ours.error[i].first(),
                100.0 * off(i) * off(i) / all
            );
        }
    }
}

fn place(scene: &Scene, zones: &Zones, i: usize) -> String {
    let point = |p: [f64; 3]| format!("({:.3}, {:.3}, {:.3})", p[0], p[1], p[2]);
    match zones.zone(i) {
        ZoneRef::Patch(p) => {
            let (lo, hi) = p.plate.bounds();
            let name = &scene.surfaces()[p.surface].name;
            format!("patch {i} of {name}, {:.1e} m² at {}", p.area, point(((lo + hi) * 0.5).array()))
        }
        ZoneRef::Voxel(_, v) => {
            let whole = if v.samples.is_empty() { "whole" } else { "cut" };
            format!("{whole} voxel {i}, {:.1e} m³ at {}", v.volume, point(v.centre.array()))
        }
        ZoneRef::Pane(..) => format!("piece {i} of a pane"),
    }
}

/// The table of a file with the records of a scene and a tolerance put in the place of older ones; by scene, then from coarse to fine.
pub(crate) fn merged(
    file: &Path,
    scene: &str,
    tolerance: f64,
    records: &str,
) -> Result<String, Box<dyn std::error::Error>> {
    let old = if file.exists() { std::fs::read_to_string(file)? } else { String::new() };
    let key = format!("{scene},{tolerance},");
    let mut lines: Vec<&str> = old.lines().skip(1).filter(|l| !l.starts_with(&key)).collect();
    lines.extend(records.lines());
    let of = |line: &str| {
        let mut cells = line.split(',');
        let name = cells.next().unwrap_or("");
        let coarse = cells.next().and_then(|t| t.parse::<f64>().ok()).unwrap_or(0.0);
        let place = NAMED_SCENES.iter().position(|s| s.0 == name).unwrap_or(NAMED_SCENES.len());
        (place, name.to_string(), coarse)
    };
    lines.sort_by(|a, b| {
        let ((p, n, x), (q, m, y)) = (of(a), of(b));
        (p, n).cmp(&(q, m)).then(y.total_cmp(&x))
    });
    Ok(CSV_HEADER.to_string() + &lines.join("\n") + "\n")
}

/// Draws error against processor time from a table: of each scene the largest L2 error over quantities and bands, and dashed its estimate.
pub(crate) fn draw(table: &Path, plot: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let text = std::fs::read_to_string(table)?;
    let mut scenes: Vec<&str> = text.lines().skip(1).filter_map(|l| l.split(',').next()).collect();
    scenes.dedup();
    let mut p = Plot::new(
        "Error against cost: the rays engine beside the dense one (dashed: its own estimate)",
        "processor time, s",
        "L2 error, %",
        LOG_LOG,
    );
    for (k, scene) in scenes.iter().enumerate() {
        let lines = text.lines().skip(1).filter(|l| l.split(',').next() == Some(scene));
        // Of each tolerance: cost, error, estimate.
        let mut points: Vec<(&str, [f64; 3])> = Vec::new();
        for cells in lines.map(|l| l.split(',').collect::<Vec<_>>()) {
            let number = |k: usize| cells.get(k).and_then(|c| c.parse::<f64>().ok()).unwrap_or(0.0);
            let (tolerance, row) =
                (cells.get(1).copied().unwrap_or(""), [number(10), 100.0 * number(5), 100.0 * number(6)]);
            match points.last_mut().filter(|p| p.0 == tolerance) {
                Some(p) => (0..3).for_each(|k| p.1[k] = p.1[k].max(row[k])),
                None => points.push((tolerance, row)),
            }
        }
        let of = |k: usize| points.iter().map(|p| (p.1[0], p.1[k])).collect();
        p.add(scene, SeriesMark::LineWithPoints, k, of(1)).add("", SeriesMark::Dashed, k, of(2));
    }
    Ok(p.write(plot).map_err(|e| format!("{e}"))?)
}

/// Writes a table.
pub(crate) fn write(file: &Path, text: &str) -> Result<(), Box<dyn std::error::Error>> {
    Ok(output::write_bytes(file, text.as_bytes())?)
}
