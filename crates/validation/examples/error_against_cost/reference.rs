//! References on zones of a scene, and their files.
//!
//! | array | shape | content |
//! |---|---|---|
//! | `zones`, `kind`, `contact` | \[zones\] | global index; 0 patch, 1 voxel zone, 2 pane zone; 1 at a contact |
//! | `surface` | \[zones\] | index of the patch's surface |
//! | `centre`, `size` | [zones, 3], \[zones\] | m; m² or m³ |
//! | `group_0_value`, `group_0_error`, … | [zones, 3] | zonal reference of each light group, W/m², and its standard error |
//! | `traced_value`, `traced_error` | [zones, 3] | path-traced mean over the zone of all indirect light |
//!
//! `about` is a JSON text with the scene, the names of the groups and surfaces, and the method.

use crate::scenes::Error;
use crate::statistics::ComparedValue;
use crate::zones::at_contact;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use zonal_io::output::{ArrayFile, NamedArray, write_arrays};
use zonal_math::{Vec3, vec3};
use zonal_reference::path_tracer::DetectorReading;
use zonal_scene::{Band, Bands, Scene, ZoneKind, Zones};

/// The kind of a zone from its number in a file.
fn kind_from_number(x: f64) -> ZoneKind {
    match x {
        0.0 => ZoneKind::Patch,
        1.0 => ZoneKind::Voxel,
        _ => ZoneKind::Pane,
    }
}

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
    /// Surface of a patch.
    pub surface: usize,
    /// True for a patch at a contact.
    pub contact: bool,
}

impl ReferenceZone {
    /// Zone `i` of a scene.
    pub(crate) fn new(scene: &Scene, zones: &Zones, i: usize) -> ReferenceZone {
        let zone = zones.zone(i);
        let patch = zones.patches.get(i);
        ReferenceZone {
            index: i,
            kind: zone.kind(),
            centre: zone.centre(),
            size: zone.size(),
            surface: patch.map_or(0, |p| p.surface),
            contact: patch.is_some_and(|p| at_contact(scene, p)),
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
    /// Names of the surfaces.
    pub surfaces: Vec<String>,
    /// How the zonal reference was found.
    pub method: String,
}

/// A named column of numbers.
type NamedColumn = (String, Vec<usize>, Vec<f64>);

fn flat(values: &[Bands]) -> Vec<f64> {
    values.iter().flat_map(|b| b.to_rgb()).collect()
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
        let column = |name: &str, of: &dyn Fn(&ReferenceZone) -> f64| -> NamedColumn {
            (name.to_string(), vec![n], self.zones.iter().map(of).collect())
        };
        let mut all = vec![
            column("zones", &|z| z.index as f64),
            column("kind", &|z| f64::from(z.kind as u8)),
            column("contact", &|z| f64::from(u8::from(z.contact))),
            column("surface", &|z| z.surface as f64),
            column("size", &|z| z.size),
            ("centre".into(), vec![n, 3], self.zones.iter().flat_map(|z| z.centre.array()).collect()),
        ];
        let named = self.fields.iter().enumerate().map(|(k, f)| (format!("group_{k}"), f));
        for (name, field) in named.chain(self.traced.iter().map(|f| ("traced".to_string(), f))) {
            all.push((format!("{name}_value"), vec![n, 3], flat(&field.value)));
            all.push((format!("{name}_error"), vec![n, 3], flat(&field.error)));
        }
        let about = json!({
            "scene": scene, "groups": self.groups, "surfaces": self.surfaces, "zones": self.zone_count, "method": self.method,
        });
        let arrays: Vec<NamedArray> = all
            .iter()
            .map(|(name, shape, values)| NamedArray { name, shape: shape.clone(), values })
            .collect();
        Ok(write_arrays(file, Some(&about.to_string()), &arrays)?)
    }

    /// Reads the file.
    pub(crate) fn read(path: &Path) -> Result<Reference, Error> {
        let mut file = ArrayFile::open(path)?;
        let about = file.about()?;
        let names = |v: &Value| -> Vec<String> {
            v.as_array().into_iter().flatten().filter_map(|x| x.as_str().map(String::from)).collect()
        };
        let zones = read_zones(&mut file)?;
        let n = zones.len();
        let mut field = |name: &str| -> Result<ReferenceField, Error> {
            let mut bands = |part: &str| -> Result<Vec<Bands>, Error> {
                let values = file.array(&format!("{name}_{part}"))?.1;
                if values.len() != 3 * n {
                    return Err(format!(
                        "{}: {name}_{part}: {} values for {n} zones",
                        path.display(),
                        values.len()
                    )
                    .into());
                }
                Ok(values.chunks_exact(3).map(|c| Bands::from_rgb([c[0], c[1], c[2]])).collect())
            };
            Ok(ReferenceField { value: bands("value")?, error: bands("error")? })
        };
        let groups = names(&about["groups"]);
        let fields =
            (0..groups.len()).map(|k| field(&format!("group_{k}"))).collect::<Result<Vec<_>, _>>()?;
        let has_traced = ArrayFile::open(path)?.has("traced_value");
        let traced = if has_traced { Some(field("traced")?) } else { None };
        Ok(Reference {
            zones,
            zone_count: about["zones"].as_u64().unwrap_or(0) as usize,
            groups,
            fields,
            traced,
            surfaces: names(&about["surfaces"]),
            method: about["method"].as_str().unwrap_or_default().to_string(),
        })
    }
}

fn read_zones(file: &mut ArrayFile) -> Result<Vec<ReferenceZone>, Error> {
    let mut column = |name: &str| -> Result<Vec<f64>, Error> { Ok(file.array(name)?.1) };
    let (index, kind, contact) = (column("zones")?, column("kind")?, column("contact")?);
    let (surface, size, centre) = (column("surface")?, column("size")?, column("centre")?);
    let n = index.len();
    if [kind.len(), contact.len(), surface.len(), size.len(), centre.len() / 3].iter().any(|l| *l != n) {
        return Err("the columns of the reference differ in length".into());
    }
    let zone = |k: usize| ReferenceZone {
        index: index[k] as usize,
        kind: kind_from_number(kind[k]),
        centre: vec3(centre[3 * k], centre[3 * k + 1], centre[3 * k + 2]),
        size: size[k],
        surface: surface[k] as usize,
        contact: contact[k] > 0.0,
    };
    Ok((0..n).map(zone).collect())
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
            surface: 2,
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
            surfaces: vec!["floor".into()],
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
