//! A solved scene: fields and places of its zones, from a solution file of any version, and its report.

use crate::scenes::Error;
use serde_json::Value;
use std::path::Path;
use zonal_io::output::{self, ArrayFile};
use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, Solution, ZoneKind};

/// Kind, centre (m), and area or volume (m², m³) of a zone.
pub(crate) type ZonePlace = (ZoneKind, Vec3, f64);

/// A solved scene.
pub(crate) struct SolvedScene {
    /// H or G of each zone without direct light, W/m².
    pub incident: Vec<Bands>,
    /// Its stated error.
    pub error: Vec<Bands>,
    /// Where the zones are.
    pub places: Vec<ZonePlace>,
    /// The whole solution, where this version can read it.
    pub solution: Option<Solution>,
}

/// The engine of a report and its estimated error.
pub(crate) struct ReportSummary {
    /// The engine.
    pub engine: String,
    /// Why it was chosen.
    pub reason: String,
    /// Estimated L2 error for patches and volumes, of the worst band.
    pub estimate: [f64; 2],
}

impl ReportSummary {
    /// Of the JSON that a solve printed.
    pub(crate) fn new(text: &str) -> Result<ReportSummary, Error> {
        let report: Value = serde_json::from_str(text)?;
        let word = |name: &str| report[name].as_str().unwrap_or_default().to_string();
        // An unknown error is no number in JSON.
        let largest = |name: &str| {
            let bands = report["estimate"][name].as_array().into_iter().flatten();
            bands.map(|x| x.as_f64().unwrap_or(f64::INFINITY)).fold(0.0, f64::max)
        };
        Ok(ReportSummary {
            engine: word("engine"),
            reason: word("reason"),
            estimate: [largest("patches"), largest("volumes")],
        })
    }
}

impl SolvedScene {
    /// Reads a solution.
    pub(crate) fn read(file: &Path) -> Result<SolvedScene, Error> {
        match output::read_solution(file) {
            Ok(solution) => Ok(SolvedScene::of_solution(solution)),
            // Of another version: its arrays have the same names.
            Err(_) => SolvedScene::of_arrays(&mut ArrayFile::open(file)?),
        }
    }

    fn of_solution(s: Solution) -> SolvedScene {
        let zones = &s.zones;
        let of = |i: usize| {
            let zone = zones.zone(i);
            (zone.kind(), zone.centre(), zone.size())
        };
        SolvedScene {
            incident: s.fields.incident.clone(),
            error: s.fields.error.clone(),
            places: (0..zones.len()).map(of).collect(),
            solution: Some(s),
        }
    }

    /// The fields of a solution alone.
    pub(crate) fn of_fields(s: &Solution) -> SolvedScene {
        let (incident, error) = (s.fields.incident.clone(), s.fields.error.clone());
        SolvedScene { incident, error, places: Vec::new(), solution: None }
    }

    fn of_arrays(file: &mut ArrayFile) -> Result<SolvedScene, Error> {
        let mut places = plates(file, "patch", ZoneKind::Patch)?;
        let centres = vectors(&file.array("voxel_centre")?.1);
        let volumes = file.array("voxel_volume")?.1;
        let volume = |k: usize| volumes[if volumes.len() == 1 { 0 } else { k }];
        places.extend(centres.into_iter().enumerate().map(|(k, c)| (ZoneKind::Voxel, c, volume(k))));
        places.extend(plates(file, "pane_zone", ZoneKind::Pane)?);
        let n = places.len();
        let mut field = |name: &str| -> Result<Vec<Bands>, Error> {
            let rows = file.array(name)?.1;
            match rows.len() {
                l if l == 3 * n => {
                    Ok(rows.chunks_exact(3).map(|c| Bands::from_rgb([c[0], c[1], c[2]])).collect())
                }
                3 => Ok(vec![Bands::from_rgb([rows[0], rows[1], rows[2]]); n]),
                l => Err(format!("{name}: {l} numbers for {n} zones of three bands").into()),
            }
        };
        Ok(SolvedScene { incident: field("incident")?, error: field("error")?, places, solution: None })
    }
}

fn vectors(values: &[f64]) -> Vec<Vec3> {
    values.chunks_exact(3).map(|c| vec3(c[0], c[1], c[2])).collect()
}

/// Zones that are plates, of the arrays of a prefix. A plate of half the area that its edges span is a triangle. An array of one row stands for
/// equal rows.
fn plates(file: &mut ArrayFile, prefix: &str, kind: ZoneKind) -> Result<Vec<ZonePlace>, Error> {
    let mut rows = |name: &str| -> Result<Vec<f64>, Error> { Ok(file.array(&format!("{prefix}_{name}"))?.1) };
    let (origin, e1, e2) = (vectors(&rows("origin")?), vectors(&rows("e1")?), vectors(&rows("e2")?));
    let areas = rows("area")?;
    let one = |k: usize, n: usize| if n == 1 { 0 } else { k };
    let of = |k: usize| {
        let (a, b) = (e1[one(k, e1.len())], e2[one(k, e2.len())]);
        let area = areas[one(k, areas.len())];
        let share = if area < 0.75 * a.cross(b).length() { 1.0 / 3.0 } else { 0.5 };
        (kind, origin[one(k, origin.len())] + (a + b) * share, area)
    };
    Ok((0..origin.len().max(areas.len())).map(of).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_io::output::{NamedArray, write_arrays};

    #[test]
    fn solutions_of_other_versions_are_read_by_their_arrays() {
        let file = std::env::temp_dir().join(format!("zonal-solved-{}.npz", std::process::id()));
        let array = |name, shape, values| NamedArray { name, shape, values };
        let (none, one) = ([0.0; 0], [2.0]);
        write_arrays(
            &file,
            None,
            &[
                array("patch_origin", vec![1, 3], &[1.0, 0.0, 0.0]),
                array("patch_e1", vec![1, 3], &[3.0, 0.0, 0.0]),
                array("patch_e2", vec![1, 3], &[0.0, 3.0, 0.0]),
                array("patch_area", vec![1], &[4.5]),
                array("voxel_centre", vec![1, 3], &[0.0, 0.0, 7.0]),
                array("voxel_volume", vec![1], &one),
                array("pane_zone_origin", vec![0, 3], &none),
                array("pane_zone_e1", vec![0, 3], &none),
                array("pane_zone_e2", vec![0, 3], &none),
                array("pane_zone_area", vec![0], &none),
                array("incident", vec![2, 3], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
                array("error", vec![1, 3], &[0.1, 0.1, 0.1]),
            ],
        )
        .unwrap();
        let s = SolvedScene::read(&file).unwrap();
        std::fs::remove_file(&file).unwrap();
        assert_eq!(
            s.places,
            [(ZoneKind::Patch, vec3(2.0, 1.0, 0.0), 4.5), (ZoneKind::Voxel, vec3(0.0, 0.0, 7.0), 2.0),]
        );
        assert_eq!((s.incident[1].to_rgb(), s.error[1].first()), ([4.0, 5.0, 6.0], 0.1));
        assert!(s.solution.is_none());
    }

    #[test]
    fn unknown_estimates_are_infinite() {
        let text = r#"{"engine": "dense", "reason": "asked", "estimate": {"patches": [0.1, 0.2], "volumes": [null]}}"#;
        let report = ReportSummary::new(text).unwrap();
        assert_eq!((report.engine.as_str(), report.estimate), ("dense", [0.2, f64::INFINITY]));
    }
}
