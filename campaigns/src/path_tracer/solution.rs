//! A solution's zones against paths of light.

use super::PathTracerOptions;
use crate::harness::statistics::{ComparedValue, median_ratio};
use crate::harness::zone_sampling::{detector, pick};
use crate::harness::{Outcome, or_dash, percent};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::Path;
use zonal_io::{input, output};
use zonal_reference::path_tracer::{Detector, DetectorReading, PathTracer, TracingAccuracy};
use zonal_scene::{Band, Scene, Solution};

/// Zones below this share of the mean do not count into the pointwise error.
const MIN_SHARE_OF_MEAN: f64 = 0.1;

/// Zones of one kind that were picked, by their global index.
struct SampledZones {
    quantity: &'static str,
    zones: Vec<usize>,
    readings: Vec<DetectorReading>,
}

impl PathTracerOptions {
    /// Picks, measures, compares.
    pub(super) fn measure_solution(&self, file: &Path) -> Outcome {
        let solution = output::read_solution(file)?;
        let own = self.scene.as_deref().map(input::read_scene).transpose()?;
        let scene = own.as_ref().unwrap_or(&solution.scene);
        let counts = |s: &Scene| (s.facets().len(), s.panes().len(), s.voxel_grid().map(|m| m.dims()));
        if counts(scene) != counts(&solution.scene) {
            let file = file.display();
            return Err(format!("{file}: its facets, panes or cells are not the scene's; solve again").into());
        }
        let accuracy = TracingAccuracy {
            relative: self.error.unwrap_or(0.01),
            floor: MIN_SHARE_OF_MEAN,
            max_paths: self.max_paths.unwrap_or(TracingAccuracy::default().max_paths),
        };
        let (tracer, zones) = (PathTracer::new(scene), &solution.zones);
        let kinds = [
            ("H", 0..zones.voxel_offset(), self.patches),
            ("G", zones.voxel_offset()..zones.pane_offset(), self.voxels),
            ("G pane", zones.pane_offset()..zones.len(), self.panes),
        ];
        let mut groups = Vec::new();
        for (k, (quantity, range, count)) in kinds.into_iter().enumerate() {
            let seed = self.seed.wrapping_mul(8).wrapping_add(k as u64);
            let picked = pick(range, count, seed);
            let receivers: Vec<Detector> = picked.iter().map(|&i| detector(scene, zones, i)).collect();
            let readings = tracer.measure(&receivers, &accuracy, seed.wrapping_add(4));
            if !picked.is_empty() {
                groups.push(SampledZones { quantity, zones: picked, readings });
            }
        }
        let rows = groups.iter().flat_map(|g| [false, true].map(|total| ZoneRow::new(&solution, g, total)));
        let rows: Vec<ZoneRow> = rows.collect();
        if self.json {
            println!("{:#}", Value::Array(rows.iter().map(ZoneRow::json).collect()));
        } else {
            println!(
                "quantity       zones       L2  of noise  pointwise     bias  mean s.e.  covered  (+noise)  est/err     paths"
            );
            rows.iter().for_each(|r| println!("{}", r.line()));
        }
        if let Some(path) = &self.table {
            output::write_bytes(path, listing(&solution, &groups).as_bytes())?;
        }
        Ok(true)
    }
}

/// A compared kind of zone.
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
        let (mut values, mut lit) = (Vec::new(), Vec::new());
        for b in Band::all() {
            let of_zone = |(&i, r): (&usize, &DetectorReading)| {
                let direct = if total { s.fields.direct_light(i)[b] } else { 0.0 };
                let truth = if total { r.total[b] } else { r.incident[b] };
                let (value, stated) = (s.fields.incident[i][b] + direct, s.fields.error[i][b]);
                ComparedValue { value, reference: truth.value, noise: truth.error, stated }
            };
            let of_band: Vec<ComparedValue> = g.zones.iter().zip(&g.readings).map(of_zone).collect();
            let mean = of_band.iter().map(|v| v.reference).sum::<f64>() / of_band.len() as f64;
            if mean > 0.0 {
                lit.extend(of_band.iter().copied().filter(|v| v.reference > MIN_SHARE_OF_MEAN * mean));
                values.extend(of_band);
            }
        }
        let sum = |of: fn(&ComparedValue) -> f64| values.iter().map(of).sum::<f64>();
        let lit_mean =
            |of: fn(&ComparedValue) -> f64| lit.iter().map(of).sum::<f64>() / lit.len().max(1) as f64;
        let share = |within: fn(&ComparedValue) -> bool| {
            let count = values.iter().filter(|v| within(v)).count();
            (!total && !values.is_empty()).then(|| count as f64 / values.len() as f64)
        };
        let squares = sum(|v| v.reference.powi(2));
        ZoneRow {
            quantity: format!("{} {}", g.quantity, if total { "total" } else { "incident" }),
            zones: g.zones.len(),
            l2: (sum(|v| v.difference().powi(2)) / squares).sqrt(),
            noise: (sum(|v| v.noise.powi(2)) / squares).sqrt(),
            pointwise: lit_mean(|v| (v.difference() / v.reference).powi(2)).sqrt(),
            bias: sum(|v| v.value) / sum(|v| v.reference) - 1.0,
            error: lit_mean(|v| v.noise / v.reference),
            covered: share(|v| v.difference() <= 2.0 * v.stated),
            covered_with_noise: share(|v| v.difference() <= 2.0 * (v.stated + v.noise)),
            ratio: median_ratio(&values).filter(|_| !total),
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

    fn line(&self) -> String {
        let [l2, noise, pointwise, bias, error] =
            [self.l2, self.noise, self.pointwise, self.bias, self.error].map(percent);
        let share = |x| or_dash(x, |x| format!("{:.1} %", 100.0 * x));
        let [covered, with_noise] = [self.covered, self.covered_with_noise].map(share);
        let ratio = or_dash(self.ratio, |x| format!("{x:.2}"));
        let ZoneRow { quantity, zones, paths, .. } = self;
        format!(
            "{quantity:<14} {zones:>5} {l2:>8} {noise:>9} {pointwise:>10} {bias:>8} {error:>10} {covered:>8} {with_noise:>9} {ratio:>8} {paths:>9.2e}"
        )
    }
}

/// One line a zone and band.
fn listing(s: &Solution, groups: &[SampledZones]) -> String {
    let mut t = String::from(
        "quantity,zone,x,y,z,size,band,incident,error,direct,mc_incident,mc_incident_se,mc_total,mc_total_se,paths\n",
    );
    for (g, (&i, r)) in groups.iter().flat_map(|g| g.zones.iter().zip(&g.readings).map(move |z| (g, z))) {
        let (zone, f) = (s.zones.zone(i), &s.fields);
        let (c, size, direct) = (zone.centre(), zone.size(), f.direct_light(i));
        for b in Band::all() {
            let (incident, total) = (r.incident[b], r.total[b]);
            let _ = writeln!(
                t,
                "{},{i},{},{},{},{size},{},{},{},{},{},{},{},{},{}",
                g.quantity,
                c.x,
                c.y,
                c.z,
                b.index(),
                f.incident[i][b],
                f.error[i][b],
                direct[b],
                incident.value,
                incident.error,
                total.value,
                total.error,
                r.paths
            );
        }
    }
    t
}
