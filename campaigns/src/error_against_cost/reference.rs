//! References of scenes: path-traced means over zones and over surfaces, without any zoning, and their files.
//!
//! | array | shape | content |
//! |---|---|---|
//! | `zones` | [zones, 9] | global index; 0 patch, 1 voxel zone, 2 pane zone; m² or m³; centre, m; normal, 0 of a voxel zone |
//! | `group_0_first`, `group_0_second`, … | [zones + surfaces, 3] | two independent means for each light group alone, W/m² |
//! | `group_0_error`, … | [zones + surfaces, 3] | standard error of their mean |
//!
//! A zone has its indirect light, a surface all light on its exchanging sides. `about` is a JSON text with the scene, its number of zones, the names of
//! the groups and of the surfaces, and the method.

use crate::harness::Error;
use serde_json::json;
use std::path::{Path, PathBuf};
use zonal_io::output::{ArrayFile, NamedArray, write_arrays};
use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, ZoneKind, ZoneRef, Zones};

/// A zone as references know it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ReferenceZone {
    /// Global index.
    pub index: usize,
    /// Kind.
    pub kind: ZoneKind,
    /// Area of a patch, m²; volume of others, m³.
    pub size: f64,
    /// Centre, m.
    pub centre: Vec3,
    /// Unit normal of a patch or pane; zero of a voxel zone.
    pub normal: Vec3,
}

impl ReferenceZone {
    /// Zone `i`.
    pub(crate) fn new(zones: &Zones, i: usize) -> ReferenceZone {
        let zone = zones.zone(i);
        let normal = match zone {
            ZoneRef::Patch(p) => p.normal,
            ZoneRef::Voxel(..) => Vec3::ZERO,
            ZoneRef::Pane(_, p) => p.normal,
        };
        let size = zones.response(i).1;
        ReferenceZone { index: i, kind: zone.kind(), size, centre: zone.centre(), normal }
    }

    /// The row of a file.
    fn numbers(&self) -> [f64; 9] {
        let ([x, y, z], [u, v, w]) = (self.centre.array(), self.normal.array());
        [self.index as f64, f64::from(self.kind as u8), self.size, x, y, z, u, v, w]
    }

    fn of_numbers(row: &[f64]) -> ReferenceZone {
        ReferenceZone {
            index: row[0] as usize,
            kind: [ZoneKind::Patch, ZoneKind::Voxel, ZoneKind::Pane][(row[1] as usize).min(2)],
            size: row[2],
            centre: vec3(row[3], row[4], row[5]),
            normal: vec3(row[6], row[7], row[8]),
        }
    }
}

/// Means over zones, then over surfaces, W/m².
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ReferenceField {
    /// Two independent means.
    pub halves: [Vec<Bands>; 2],
    /// Standard errors of the mean of both.
    pub error: Vec<Bands>,
}

impl ReferenceField {
    /// The sum of independent fields, each times a factor.
    pub(crate) fn sum<'a>(parts: impl Iterator<Item = (&'a ReferenceField, f64)>) -> ReferenceField {
        let mut out = ReferenceField::default();
        for (field, factor) in parts {
            let n = field.error.len();
            out.halves.iter_mut().for_each(|h| h.resize(n, Bands::ZERO));
            out.error.resize(n, Bands::ZERO);
            for i in 0..n {
                (0..2).for_each(|h| out.halves[h][i] += field.halves[h][i] * factor);
                out.error[i] = out.error[i].hypot(field.error[i] * factor);
            }
        }
        out
    }

    /// Adds the means of another field behind those of this one.
    pub(crate) fn append(&mut self, mut other: ReferenceField) {
        self.halves.iter_mut().zip(&mut other.halves).for_each(|(own, more)| own.append(more));
        self.error.append(&mut other.error);
    }
}

/// A reference of a scene.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Reference {
    /// Its zones, patches before others.
    pub zones: Vec<ReferenceZone>,
    /// Names of its surfaces.
    pub surfaces: Vec<String>,
    /// Number of zones of the scene.
    pub zone_count: usize,
    /// Names of the light groups.
    pub groups: Vec<String>,
    /// The means of each group.
    pub fields: Vec<ReferenceField>,
    /// How they were found.
    pub method: String,
}

/// The names of the arrays of a group.
fn arrays_of_group(k: usize) -> [String; 3] {
    ["first", "second", "error"].map(|part| format!("group_{k}_{part}"))
}

impl Reference {
    /// The file of a scene's reference.
    pub(crate) fn file(folder: &Path, scene: &str) -> PathBuf {
        folder.join(format!("{scene}.npz"))
    }

    /// Writes the file.
    pub(crate) fn write(&self, file: &Path, scene: &str) -> Result<(), Error> {
        let zones: Vec<f64> = self.zones.iter().flat_map(ReferenceZone::numbers).collect();
        let numbers = |list: &[Bands]| list.iter().flat_map(|b| b.to_rgb()).collect::<Vec<f64>>();
        let of_group = |(k, f): (usize, &ReferenceField)| {
            let lists = [&f.halves[0], &f.halves[1], &f.error].map(|list| numbers(list));
            arrays_of_group(k).into_iter().zip(lists).collect::<Vec<_>>()
        };
        let fields: Vec<(String, Vec<f64>)> = self.fields.iter().enumerate().flat_map(of_group).collect();
        let mut arrays = vec![NamedArray { name: "zones", shape: vec![self.zones.len(), 9], values: &zones }];
        let of_field = |(name, values): &'_ (String, Vec<f64>)| (name.clone(), vec![values.len() / 3, 3]);
        let shapes: Vec<_> = fields.iter().map(of_field).collect();
        arrays.extend(shapes.iter().zip(&fields).map(|((name, shape), (_, values))| NamedArray {
            name,
            shape: shape.clone(),
            values,
        }));
        let about = json!({
            "scene": scene, "zones": self.zone_count, "groups": self.groups, "surfaces": self.surfaces, "method": self.method,
        });
        Ok(write_arrays(file, Some(&about.to_string()), &arrays)?)
    }

    /// Reads the file.
    pub(crate) fn read(path: &Path) -> Result<Reference, Error> {
        let mut file = ArrayFile::open(path)?;
        let about = file.about()?;
        let zones: Vec<ReferenceZone> =
            file.array("zones")?.1.chunks_exact(9).map(ReferenceZone::of_numbers).collect();
        let names = |key: &str| serde_json::from_value::<Vec<String>>(about[key].clone());
        let (groups, surfaces) = (names("groups")?, names("surfaces")?);
        let length = 3 * (zones.len() + surfaces.len());
        let mut list = |name: String| -> Result<Vec<Bands>, Error> {
            let values = file.array(&name)?.1;
            if values.len() != length {
                return Err(format!("{}: {name} has not three bands a zone", path.display()).into());
            }
            Ok(values.chunks_exact(3).map(|c| Bands::from_rgb([c[0], c[1], c[2]])).collect())
        };
        let mut field = |k: usize| -> Result<ReferenceField, Error> {
            let [first, second, error] = arrays_of_group(k).map(&mut list);
            Ok(ReferenceField { halves: [first?, second?], error: error? })
        };
        Ok(Reference {
            fields: (0..groups.len()).map(&mut field).collect::<Result<_, _>>()?,
            zones,
            surfaces,
            zone_count: about["zones"].as_u64().unwrap_or(0) as usize,
            groups,
            method: about["method"].as_str().unwrap_or_default().to_string(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(first: f64, error: f64) -> ReferenceField {
        let list = |x: f64| vec![Bands::from_rgb([x, 2.0 * x, 3.0 * x]); 2];
        ReferenceField { halves: [list(first), list(first + 1.0)], error: list(error) }
    }

    #[test]
    fn halves_of_groups_add_and_their_errors_in_quadrature() {
        let sum = ReferenceField::sum([(&field(1.0, 0.3), 10.0), (&field(2.0, 4.0), 1.0)].into_iter());
        assert_eq!([sum.halves[0][1].first(), sum.halves[1][1].first()], [12.0, 23.0]);
        assert!((sum.error[0].first() - 5.0).abs() < 1e-12);
        let mut both = field(1.0, 0.3);
        both.append(field(2.0, 4.0));
        assert_eq!((both.halves[1].len(), both.halves[1][3].first(), both.error[3].first()), (4, 3.0, 4.0));
    }

    #[test]
    fn a_reference_survives_its_file() {
        let zone = ReferenceZone {
            index: 7,
            kind: ZoneKind::Pane,
            size: 0.5,
            centre: vec3(1.0, 2.0, 3.0),
            normal: vec3(0.0, -1.0, 0.0),
        };
        let reference = Reference {
            zones: vec![zone],
            surfaces: vec!["floor".into()],
            zone_count: 9,
            groups: vec!["sun".into(), "lamp".into()],
            fields: vec![field(1.0, 0.1), field(5.0, 0.2)],
            method: "paths".into(),
        };
        let file = std::env::temp_dir().join(format!("zonal-reference-{}.npz", std::process::id()));
        reference.write(&file, "scene").unwrap();
        let back = Reference::read(&file).unwrap();
        std::fs::remove_file(&file).unwrap();
        assert_eq!(back, reference);
    }
}
