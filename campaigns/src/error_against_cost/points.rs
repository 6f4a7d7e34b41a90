//! The points of the benchmark and their table, a CSV file of one row a point.

use super::measure::Measurement;
use crate::harness::Error;
use crate::harness::process::Cost;
use crate::harness::statistics::MeasuredError;
use std::collections::HashMap;
use std::path::Path;
use zonal_io::output;

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PointStatus {
    /// It was measured.
    Measured,
    /// It was ended at the limit of processor time.
    Limit,
    /// The solver refused it.
    Refused,
}

impl PointStatus {
    fn name(self) -> &'static str {
        match self {
            PointStatus::Measured => "measured",
            PointStatus::Limit => "limit",
            PointStatus::Refused => "refused",
        }
    }

    fn of(name: &str) -> Result<PointStatus, Error> {
        [PointStatus::Measured, PointStatus::Limit, PointStatus::Refused]
            .into_iter()
            .find(|s| s.name() == name)
            .ok_or_else(|| format!("status '{name}': give measured, limit or refused").into())
    }
}

/// One solve, measured.
#[derive(Clone, Debug)]
pub(crate) struct Point {
    /// Scene.
    pub scene: String,
    /// The engine asked for.
    pub engine: String,
    /// Tolerance.
    pub tolerance: f64,
    /// How it ended.
    pub status: PointStatus,
    /// Number of zones.
    pub zones: usize,
    /// The engine used, and the reason for it or for a refusal.
    pub used: String,
    /// The reason.
    pub reason: String,
    /// Cost of the whole process.
    pub cost: Cost,
    /// The estimate of the solver for patches and volumes, of the worst band.
    pub estimate: [f64; 2],
    /// The errors.
    pub measured: Measurement,
}

impl Point {
    /// L2 of the worse kind of zone.
    pub(crate) fn error(&self) -> MeasuredError {
        self.measured.patches.max(self.measured.volumes)
    }

    /// The discretization error that is left of the total one: √(total² − zonal²), at least 0.
    pub(crate) fn discretization(&self) -> Option<f64> {
        let total = self.measured.total?;
        Some((total.error.powi(2) - self.error().error.powi(2)).max(0.0).sqrt())
    }

    fn key(&self) -> (String, String, String) {
        (self.scene.clone(), self.engine.clone(), self.tolerance.to_string())
    }
}

/// A text without what ends a cell or a line.
fn cell(text: &str) -> String {
    text.replace([',', '"'], ";").replace(['\n', '\r'], " ")
}

/// The columns with the cells of a point, in their order; a number that is not known is empty.
fn record(p: &Point) -> Vec<(&'static str, String)> {
    let (m, e) = (&p.measured, p.error());
    let numbers = |list: &[(&'static str, Option<f64>)]| {
        list.iter().map(|(n, x)| (*n, x.map(|x| format!("{x:.4e}")).unwrap_or_default())).collect::<Vec<_>>()
    };
    let mut cells = vec![
        ("scene", p.scene.clone()),
        ("engine", p.engine.clone()),
        ("tolerance", p.tolerance.to_string()),
        ("status", p.status.name().into()),
        ("zones", p.zones.to_string()),
        ("engine_used", cell(&p.used)),
        ("reason", cell(&p.reason)),
    ];
    cells.extend(numbers(&[
        ("wall_s", Some(p.cost.wall)),
        ("processor_s", Some(p.cost.processor)),
        ("memory_MB", Some(p.cost.memory)),
        ("estimate_H", Some(p.estimate[0])),
        ("estimate_G", Some(p.estimate[1])),
        ("L2", Some(e.error)),
        ("noise", Some(e.noise)),
    ]));
    cells.push(("noisy", e.is_noisy().to_string()));
    cells.extend(numbers(&[
        ("L2_H", Some(m.patches.error)),
        ("noise_H", Some(m.patches.noise)),
        ("L2_G", Some(m.volumes.error)),
        ("noise_G", Some(m.volumes.noise)),
        ("L2_total", m.total.map(|t| t.error)),
        ("noise_total", m.total.map(|t| t.noise)),
        ("L2_discretization", p.discretization()),
        ("estimate_over_error", m.ratio),
        ("within_twice", m.within),
        ("within_twice_contacts", m.within_at_contacts),
        ("within_twice_relit", m.within_relit),
    ]));
    cells
}

/// The table as text, by scene in the order of `scenes`, then by engine and from coarse to fine.
fn table(points: &[Point], scenes: &[&str]) -> String {
    let place = |p: &Point| scenes.iter().position(|s| *s == p.scene).unwrap_or(scenes.len());
    let mut sorted: Vec<&Point> = points.iter().collect();
    sorted.sort_by(|a, b| {
        (place(a), &a.scene, &a.engine)
            .cmp(&(place(b), &b.scene, &b.engine))
            .then(b.tolerance.total_cmp(&a.tolerance))
    });
    let line = |cells: Vec<String>| cells.join(",") + "\n";
    let names = |p: &&Point| line(record(p).into_iter().map(|c| c.0.to_string()).collect());
    let row = |p: &&Point| line(record(p).into_iter().map(|c| c.1).collect());
    sorted.iter().take(1).map(names).chain(sorted.iter().map(row)).collect()
}

/// Reads a table; an empty one where the file is absent.
pub(crate) fn read(file: &Path) -> Result<Vec<Point>, Error> {
    if !file.exists() {
        return Ok(Vec::new());
    }
    let text = std::fs::read_to_string(file)?;
    let mut lines = text.lines();
    let header: HashMap<&str, usize> =
        lines.next().unwrap_or_default().split(',').enumerate().map(|(k, c)| (c, k)).collect();
    lines
        .enumerate()
        .map(|(k, l)| parse(&header, l).map_err(|e| format!("{}:{}: {e}", file.display(), k + 2).into()))
        .collect()
}

fn parse(header: &HashMap<&str, usize>, line: &str) -> Result<Point, Error> {
    let cells: Vec<&str> = line.split(',').collect();
    let text = |name: &str| -> Result<&str, Error> {
        let k = header.get(name).ok_or_else(|| format!("there is no column '{name}'"))?;
        Ok(cells.get(*k).copied().ok_or_else(|| format!("there is no cell of '{name}'"))?)
    };
    let value = |name: &str| -> Result<f64, Error> {
        let cell = text(name)?;
        cell.parse().map_err(|_| format!("{name}: '{cell}' is no number").into())
    };
    let maybe = |name: &str| -> Result<Option<f64>, Error> {
        if text(name)?.is_empty() { Ok(None) } else { value(name).map(Some) }
    };
    let error = |of: &str, noise: &str| -> Result<MeasuredError, Error> {
        Ok(MeasuredError { error: value(of)?, noise: value(noise)? })
    };
    Ok(Point {
        scene: text("scene")?.into(),
        engine: text("engine")?.into(),
        tolerance: value("tolerance")?,
        status: PointStatus::of(text("status")?)?,
        zones: value("zones")? as usize,
        used: text("engine_used")?.into(),
        reason: text("reason")?.into(),
        cost: Cost { wall: value("wall_s")?, processor: value("processor_s")?, memory: value("memory_MB")? },
        estimate: [value("estimate_H")?, value("estimate_G")?],
        measured: Measurement {
            patches: error("L2_H", "noise_H")?,
            volumes: error("L2_G", "noise_G")?,
            total: if text("L2_total")?.is_empty() { None } else { Some(error("L2_total", "noise_total")?) },
            ratio: maybe("estimate_over_error")?,
            within: maybe("within_twice")?,
            within_at_contacts: maybe("within_twice_contacts")?,
            within_relit: maybe("within_twice_relit")?,
        },
    })
}

/// Puts a point into the place of an older one of the same scene, engine and tolerance.
pub(crate) fn put(points: &mut Vec<Point>, point: Point) {
    points.retain(|p| p.key() != point.key());
    points.push(point);
}

/// Writes the table.
pub(crate) fn write(file: &Path, points: &[Point], scenes: &[&str]) -> Result<(), Error> {
    Ok(output::write_bytes(file, table(points, scenes).as_bytes())?)
}

/// The points of a scene and an engine that were measured, from coarse to fine.
pub(crate) fn series<'a>(points: &'a [Point], scene: &str, engine: &str) -> Vec<&'a Point> {
    let mut out: Vec<&Point> = points
        .iter()
        .filter(|p| p.scene == scene && p.engine == engine && p.status == PointStatus::Measured)
        .collect();
    out.sort_by(|a, b| b.tolerance.total_cmp(&a.tolerance));
    out
}

/// Names in the order of their first appearance.
pub(crate) fn names(points: &[Point], of: fn(&Point) -> &str) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    for p in points {
        if !out.iter().any(|n| n == of(p)) {
            out.push(of(p).into());
        }
    }
    out
}

/// A measured point for tests.
#[cfg(test)]
pub(crate) fn example(engine: &str, tolerance: f64, seconds: f64, error: f64) -> Point {
    let error = MeasuredError { error, noise: 0.1 * error };
    Point {
        scene: "room".into(),
        engine: engine.into(),
        tolerance,
        status: PointStatus::Measured,
        zones: 5,
        used: "dense".into(),
        reason: "few, zones".into(),
        cost: Cost { wall: seconds, processor: seconds, memory: 1.0 },
        estimate: [tolerance; 2],
        measured: Measurement {
            patches: error,
            total: Some(error),
            ratio: Some(2.0),
            within: Some(0.99),
            ..Measurement::default()
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_survives_its_file_and_is_sorted() {
        let mut points = vec![example("auto", 0.1, 2.0, 0.05), example("auto", 0.3, 1.0, 0.2)];
        put(&mut points, example("auto", 0.1, 3.0, 0.04));
        assert_eq!(points.len(), 2);
        let file = std::env::temp_dir().join(format!("zonal-points-{}.csv", std::process::id()));
        write(&file, &points, &["room"]).unwrap();
        let back = read(&file).unwrap();
        std::fs::remove_file(&file).unwrap();
        assert_eq!(back.iter().map(|p| p.tolerance).collect::<Vec<_>>(), [0.3, 0.1]);
        assert_eq!((back[1].cost.processor, back[1].error().error), (3.0, 0.04));
        assert_eq!(back[1].reason, "few; zones");
        assert_eq!((back[1].measured.ratio, back[1].measured.within_relit), (Some(2.0), None));
        assert_eq!(back[1].discretization(), Some(0.0));
        assert_eq!(series(&back, "room", "auto").len(), 2);
    }
}
