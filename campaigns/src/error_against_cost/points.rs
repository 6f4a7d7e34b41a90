//! The points of the benchmark and their table, a CSV file of one row a point.

use super::halves::TotalError;
use super::measure::{KindErrors, Measurement};
use crate::harness::Error;
use crate::harness::process::Cost;
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
    /// The total error of the worse kind of zones, by the worse weighting.
    pub(crate) fn total(&self) -> TotalError {
        self.measured.patches.worst().max(self.measured.volumes.worst())
    }

    fn key(&self) -> (String, String, String) {
        (self.scene.clone(), self.engine.clone(), self.tolerance.to_string())
    }
}

/// A text without what ends a cell or a line.
fn cell(text: &str) -> String {
    text.replace([',', '"'], ";").replace(['\n', '\r'], " ")
}

/// Columns of the errors of [`errors`] and of their upper bounds.
const COLUMNS_OF_ERRORS: [[&str; 2]; 4] = [
    ["total_H", "total_H_upper"],
    ["total_H_by_area", "total_H_by_area_upper"],
    ["total_G", "total_G_upper"],
    ["total_G_by_volume", "total_G_by_volume_upper"],
];

/// The errors of both kinds, by count and by size.
fn errors(m: &Measurement) -> [TotalError; 4] {
    [m.patches.by_count, m.patches.by_size, m.volumes.by_count, m.volumes.by_size]
}

/// The columns with the cells of a point, in their order; a number that is not known is empty.
fn record(p: &Point) -> Vec<(&'static str, String)> {
    let (m, total) = (&p.measured, p.total());
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
        ("total", Some(total.error)),
        ("total_upper", Some(total.upper)),
    ]));
    for (names, e) in COLUMNS_OF_ERRORS.into_iter().zip(errors(m)) {
        cells.extend(numbers(&[(names[0], Some(e.error)), (names[1], Some(e.upper))]));
    }
    cells.extend(numbers(&[
        ("matched", Some(m.matched)),
        ("estimate_over_error", m.ratio),
        ("within_twice", m.within),
        ("names_within", m.names_within),
        ("within_twice_relit", m.within_relit),
        ("names_within_twice_relit", m.names_within_relit),
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
    let error = |k: usize| -> Result<TotalError, Error> {
        let [error, upper] = COLUMNS_OF_ERRORS[k].map(value);
        Ok(TotalError { error: error?, upper: upper? })
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
            patches: KindErrors { by_count: error(0)?, by_size: error(1)? },
            volumes: KindErrors { by_count: error(2)?, by_size: error(3)? },
            matched: value("matched")?,
            ratio: maybe("estimate_over_error")?,
            within: maybe("within_twice")?,
            names_within: maybe("names_within")?,
            within_relit: maybe("within_twice_relit")?,
            names_within_relit: maybe("names_within_twice_relit")?,
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
    let error = TotalError { error, upper: 1.2 * error };
    let errors = KindErrors { by_count: error, by_size: error };
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
            patches: errors,
            ratio: Some(2.0),
            within: Some(0.99),
            names_within: Some(1.0),
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
        assert_eq!((back[1].cost.processor, back[1].total().error), (3.0, 0.04));
        assert_eq!(back[1].reason, "few; zones");
        assert_eq!(back[1].measured, points[1].measured);
        assert_eq!(series(&back, "room", "auto").len(), 2);
    }
}
