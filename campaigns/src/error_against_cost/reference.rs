//! References on zones of a scene, and their files.
//!
//! | array | shape | content |
//! |---|---|---|
//! | `zones` | [zones, 7] | global index; 0 patch, 1 voxel zone, 2 pane zone; 1 at a contact; m² or m³; centre, m |
//! | `group_0_value`, `group_0_error`, … | [zones, 3] | zonal reference of each light group, W/m², and its standard error |
//! | `traced_value`, `traced_error` | [zones, 3] | path-traced mean over the zone of all indirect light |
//!
//! `about` is a JSON text with the scene, the names of the groups, and the method.

use super::zones::at_contact;
use crate::harness::Error;
use crate::harness::statistics::ComparedValue;
use serde_json::json;
use std::path::{Path, PathBuf};
use zonal_io::output::{ArrayFile, NamedArray, write_arrays};
use zonal_math::{Vec3, vec3};
use zonal_reference::path_tracer::DetectorReading;
use zonal_scene::{Band, Bands, Scene, ZoneKind, Zones};

/// A zone of a reference.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReferenceZone {
    /// Global index.
    pub index: usize,
    /// Kind.
    pub kind: ZoneKind,
    /// Centre, m.
    pub centre: Vec3,
    /// Area or volume, m² or m³.
    pub size: f64,
    /// True for a patch at a contact.
    pub contact: bool,
}

impl ReferenceZone {
    /// Zone `i` of a scene.
    pub(crate) fn new(scene: &Scene, zones: &Zones, i: usize) -> ReferenceZone {
        let zone = zones.zone(i);
        ReferenceZone {
            index: i,
            kind: zone.kind(),
            centre: zone.centre(),
            size: zone.size(),
            contact: zones.patches.get(i).is_some_and(|p| at_contact(scene, p)),
        }
    }

    /// The row of a file.
    fn numbers(&self) -> [f64; 7] {
        let contact = f64::from(u8::from(self.contact));
        let [x, y, z] = self.centre.array();
        [self.index as f64, f64::from(self.kind as u8), contact, self.size, x, y, z]
    }

    fn of_numbers(row: &[f64]) -> ReferenceZone {
        ReferenceZone {
            index: row[0] as usize,
            kind: [ZoneKind::Patch, ZoneKind::Voxel, ZoneKind::Pane][(row[1] as usize).min(2)],
            contact: row[2] > 0.0,
            size: row[3],
            centre: vec3(row[4], row[5], row[6]),
        }
    }
}

/// Values with standard errors on the zones of a reference, W/m².
#[derive(Clone, Debug, Default)]
pub(crate) struct ReferenceField {
    /// Values.
    pub value: Vec<Bands>,
    /// Standard errors.
    pub error: Vec<Bands>,
}

impl ReferenceField {
    /// The indirect light of readings.
    pub(crate) fn of_readings(readings: &[DetectorReading]) -> ReferenceField {
        let of = |f: fn(&DetectorReading, Band) -> f64| {
            readings.iter().map(|r| Bands::from_fn(|b| f(r, b))).collect::<Vec<_>>()
        };
        ReferenceField { value: of(|r, b| r.incident[b].value), error: of(|r, b| r.incident[b].error) }
    }

    /// The sum of independent fields, each times a factor.
    pub(crate) fn sum<'a>(
        parts: impl Iterator<Item = (&'a ReferenceField, f64)>,
        zones: usize,
    ) -> ReferenceField {
        let mut out = ReferenceField { value: vec![Bands::ZERO; zones], error: vec![Bands::ZERO; zones] };
        for (field, factor) in parts {
            for i in 0..zones {
                out.value[i] += field.value[i] * factor;
                out.error[i] += (field.error[i] * factor) * (field.error[i] * factor);
            }
        }
        out.error.iter_mut().for_each(|e| *e = e.map(f64::sqrt));
        out
    }

    /// The reference at zone `k` in a band, beside a value and its stated error.
    pub(crate) fn compared(&self, k: usize, b: Band, value: f64, stated: f64) -> ComparedValue {
        ComparedValue { value, reference: self.value[k][b], noise: self.error[k][b], stated }
    }
}

/// A reference of a scene.
#[derive(Clone, Debug)]
pub(crate) struct Reference {
    /// Its zones, ascending.
    pub zones: Vec<ReferenceZone>,
    /// Number of zones of the scene.
    pub zone_count: usize,
    /// Names of the light groups.
    pub groups: Vec<String>,
    /// The zonal reference of each group.
    pub fields: Vec<ReferenceField>,
    /// Path-traced means.
    pub traced: Option<ReferenceField>,
    /// How the zonal reference was found.
    pub method: String,
}

impl Reference {
    /// The file of a scene's reference by a method, `walks`, `continued` or `dense`.
    pub(crate) fn file(folder: &Path, scene: &str, method: &str) -> PathBuf {
        folder.join(format!("{scene}-{method}.npz"))
    }

    /// All groups together.
    pub(crate) fn total(&self) -> ReferenceField {
        ReferenceField::sum(self.fields.iter().map(|f| (f, 1.0)), self.zones.len())
    }

    /// Writes the file.
    pub(crate) fn write(&self, file: &Path, scene: &str) -> Result<(), Error> {
        let n = self.zones.len();
        let mut all =
            vec![("zones".to_string(), 7, self.zones.iter().flat_map(ReferenceZone::numbers).collect())];
        let named = self.fields.iter().enumerate().map(|(k, f)| (format!("group_{k}"), f));
        for (name, field) in named.chain(self.traced.iter().map(|f| ("traced".to_string(), f))) {
            for (part, values) in [("value", &field.value), ("error", &field.error)] {
                all.push((
                    format!("{name}_{part}"),
                    3,
                    values.iter().flat_map(|b| b.to_rgb()).collect::<Vec<f64>>(),
                ));
            }
        }
        let about =
            json!({"scene": scene, "groups": self.groups, "zones": self.zone_count, "method": self.method});
        let array = |(name, width, values): &'_ (String, usize, Vec<f64>)| {
            (name.clone(), vec![n, *width], values.clone())
        };
        let arrays: Vec<_> = all.iter().map(array).collect();
        let arrays: Vec<NamedArray> = arrays
            .iter()
            .map(|(name, shape, values)| NamedArray { name, shape: shape.clone(), values })
            .collect();
        Ok(write_arrays(file, Some(&about.to_string()), &arrays)?)
    }

    /// Reads the file.
    pub(crate) fn read(path: &Path) -> Result<Reference, Error> {
        let mut file = ArrayFile::open(path)?;
        let about = file.about()?;
        let has_traced = file.has("traced_value");
        let zones: Vec<ReferenceZone> =
            file.array("zones")?.1.chunks_exact(7).map(ReferenceZone::of_numbers).collect();
        let mut field = |name: &str| -> Result<ReferenceField, Error> {
            let [value, error] = ["value", "error"].map(|part| -> Result<Vec<Bands>, Error> {
                let values = file.array(&format!("{name}_{part}"))?.1;
                if values.len() != 3 * zones.len() {
                    return Err(
                        format!("{}: {name}_{part} has not three bands a zone", path.display()).into()
                    );
                }
                Ok(values.chunks_exact(3).map(|c| Bands::from_rgb([c[0], c[1], c[2]])).collect())
            });
            Ok(ReferenceField { value: value?, error: error? })
        };
        let groups: Vec<String> = serde_json::from_value(about["groups"].clone())?;
        Ok(Reference {
            fields: (0..groups.len()).map(|k| field(&format!("group_{k}"))).collect::<Result<_, _>>()?,
            traced: if has_traced { Some(field("traced")?) } else { None },
            zones,
            zone_count: about["zones"].as_u64().unwrap_or(0) as usize,
            groups,
            method: about["method"].as_str().unwrap_or_default().to_string(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_groups_add_in_quadrature() {
        let field =
            |v: f64, e: f64| ReferenceField { value: vec![Bands::splat(v)], error: vec![Bands::splat(e)] };
        let sum = ReferenceField::sum([(&field(1.0, 0.3), 10.0), (&field(2.0, 4.0), 1.0)].into_iter(), 1);
        assert_eq!(sum.value[0], Bands::splat(12.0));
        assert!((sum.error[0].first() - 5.0).abs() < 1e-12);
    }

    #[test]
    fn a_reference_survives_its_file() {
        let zone = ReferenceZone {
            index: 7,
            kind: ZoneKind::Pane,
            centre: vec3(1.0, 2.0, 3.0),
            size: 0.5,
            contact: true,
        };
        let field =
            ReferenceField { value: vec![Bands::from_rgb([1.0, 2.0, 3.0])], error: vec![Bands::splat(0.1)] };
        let reference = Reference {
            zones: vec![zone],
            zone_count: 9,
            groups: vec!["sun".into()],
            fields: vec![field.clone()],
            traced: Some(field),
            method: "walks".into(),
        };
        let file = std::env::temp_dir().join(format!("zonal-reference-{}.npz", std::process::id()));
        reference.write(&file, "scene").unwrap();
        let back = Reference::read(&file).unwrap();
        std::fs::remove_file(&file).unwrap();
        assert_eq!(
            (back.zones[0].index, back.zones[0].kind, back.zones[0].contact),
            (7, ZoneKind::Pane, true)
        );
        assert_eq!((back.zones[0].centre, back.zone_count), (vec3(1.0, 2.0, 3.0), 9));
        assert_eq!(back.fields[0].value[0].to_rgb(), [1.0, 2.0, 3.0]);
        assert_eq!(back.groups, ["sun"]);
        assert!(back.traced.is_some());
    }
}
