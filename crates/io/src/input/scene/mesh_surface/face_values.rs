//! `temperature = { file = "t.csv", column = "T" }` and the like: values of a surface by face of its mesh, or by material.
//!
//! By face, a file has one row for each polygon of the mesh file, in the order of that file; a polygon that is triangulated keeps its value. By material,
//! a CSV has a name and a value in each row, and stands for numbers in `materials`. Values that `materials` gives precede both.

use crate::input::mesh::missing_values::MAX_NAMED_MATERIALS;
use crate::input::mesh::model::{MeshData, MeshFace};
use crate::input::mesh::shells::ShellKind;
use crate::input::reading::error::InputError;
use crate::input::reading::notes::quoted_list;
use crate::input::reading::suggestion::suggest;
use crate::input::scene::quantities::surface_properties::SurfaceProperties;
use crate::input::scene::scene_reader::SceneReader;
use crate::input::scene::surface_keys::FACE_VALUE_KEYS;
use crate::input::tables::{Quantity, RowKeys, ValueTable, WantedColumn, read_column};
use crate::input::toml::node::{TomlNode, TomlTable};
use crate::input::toml::surface_keys::{SURFACE_PROPERTIES, VALUE_FILE, ValueFile};
use std::rc::Rc;
use zonal_scene::{Bands, FacetValues, ThermalCondition};

/// Materials that an error lists.
const MAX_LISTED_MATERIALS: usize = 40;

/// The quantity of each key of [`FACE_VALUE_KEYS`].
const QUANTITIES: [Quantity; 6] = [
    Quantity::Temperature,
    Quantity::HeatFlux,
    Quantity::NetPower,
    Quantity::Emissivity,
    Quantity::Reflectance,
    Quantity::Emission,
];

/// Values by face and by material of one mesh.
#[derive(Default)]
pub(crate) struct FaceValues {
    by_face: Vec<(Quantity, Vec<f64>)>,
    /// Properties of each material; empty without values by material.
    by_material: Vec<SurfaceProperties>,
}

/// Reads the files that the table of a surface names for its keys.
pub(crate) fn read_face_values(
    table: &TomlTable<'_>,
    mesh: &MeshData,
    reader: &SceneReader<'_>,
) -> Result<FaceValues, InputError> {
    let mut out = FaceValues::default();
    for (key, quantity) in FACE_VALUE_KEYS.into_iter().zip(QUANTITIES) {
        let Some(node) = table.get(key).filter(|n| n.is_value_file()) else { continue };
        if let (Quantity::Emissivity, Some(other)) = (quantity, table.get(&SURFACE_PROPERTIES.reflectance)) {
            return Err(
                other.error("emissivity and reflectance are both given, and sum to 1; keep one of them")
            );
        }
        let t = node.table(ValueFile::TABLE)?;
        let by_material = t.value(&VALUE_FILE.by)? == Some(1);
        let rows = if by_material { RowKeys::Name } else { RowKeys::Position };
        let file = t.require(&VALUE_FILE.file)?;
        let values = read_file(&t, &file, quantity, rows, reader)?;
        if by_material {
            out.add_by_material(&file, &values, quantity, mesh)?;
        } else if values.values().len() == mesh.face_count {
            out.by_face.push((quantity, values.values().to_vec()));
        } else {
            return Err(file.error(values.count_fault(mesh.face_count, "faces in the mesh").to_string()));
        }
    }
    Ok(out)
}

/// The column of a file that `t` describes.
fn read_file(
    t: &TomlTable<'_>,
    file: &TomlNode<'_>,
    quantity: Quantity,
    rows: RowKeys,
    reader: &SceneReader<'_>,
) -> Result<Rc<ValueTable>, InputError> {
    let column = t.value(&VALUE_FILE.column)?;
    let (path, _) = file.named_file()?;
    let wanted = WantedColumn { column: column.as_deref(), quantity, rows };
    file.once(|| {
        let read = read_column(reader.context.files, &path, &path.display().to_string(), wanted);
        read.map_err(|f| t.get(&VALUE_FILE.column).unwrap_or_else(|| file.clone()).error(f.to_string()))
    })
}

impl FaceValues {
    /// Adds the values of a table by material.
    fn add_by_material(
        &mut self,
        file: &TomlNode<'_>,
        table: &ValueTable,
        quantity: Quantity,
        mesh: &MeshData,
    ) -> Result<(), InputError> {
        let refused = |row: usize, message: String| file.error(table.fault(row, message).to_string());
        let names: Vec<&str> = mesh.materials.iter().map(|m| m.name.as_str()).collect();
        self.by_material.resize(names.len(), SurfaceProperties::default());
        let mut given = vec![false; names.len()];
        for (row, (name, value)) in table.names().unwrap_or_default().iter().zip(table.values()).enumerate() {
            let Some(m) = names.iter().position(|n| n == name) else {
                let hint = suggest(name, &names[..names.len().min(MAX_LISTED_MATERIALS)]);
                return Err(refused(row, format!("the mesh has no material '{name}'; {hint}")));
            };
            if std::mem::replace(&mut given[m], true) {
                return Err(refused(row, format!("material '{name}' has two rows; keep one")));
            }
            let own = properties(facet_values(quantity, *value));
            self.by_material[m] = self.by_material[m].or(own);
        }
        let missing = names.iter().zip(&given).filter(|(_, given)| !**given);
        let missing: Vec<&str> = missing.map(|(name, _)| *name).collect();
        let last = table.values().len().saturating_sub(1);
        match missing.as_slice() {
            [] => Ok(()),
            [name] => Err(refused(last, format!("material '{name}' has no row; add one"))),
            list => Err(refused(
                last,
                format!("materials {} have no row; add one for each", quoted_list(list, MAX_NAMED_MATERIALS)),
            )),
        }
    }

    /// True without values by face.
    pub(crate) fn is_empty(&self) -> bool {
        self.by_face.is_empty()
    }

    /// The properties of a material by a file; none where there are no values by material.
    pub(crate) fn of_material(&self, material: usize) -> SurfaceProperties {
        self.by_material.get(material).copied().unwrap_or_default()
    }

    /// The values of a face that the properties `given` for its material do not give.
    pub(crate) fn of_face(&self, face: usize, given: &SurfaceProperties) -> FacetValues {
        let mut out = FacetValues::default();
        for (quantity, values) in &self.by_face {
            let own = facet_values(*quantity, values[face]);
            out.condition = out.condition.or(own.condition.filter(|_| given.condition.is_none()));
            out.reflectance = out.reflectance.or(own.reflectance.filter(|_| given.reflectance.is_none()));
            out.emission = out.emission.or(own.emission.filter(|_| given.emission.is_none()));
        }
        out
    }

    /// Properties that stand for the values of these faces: those of the largest temperature, modulus of power or emission, and the largest emissivity.
    pub(crate) fn representative(&self, faces: &[(&MeshFace, ShellKind)]) -> SurfaceProperties {
        let mut out = SurfaceProperties::default();
        for (quantity, values) in &self.by_face {
            let size = |face: usize| match quantity {
                Quantity::Reflectance => -values[face],
                _ => values[face].abs(),
            };
            let largest = faces.iter().map(|(f, _)| f.face).max_by(|a, b| size(*a).total_cmp(&size(*b)));
            if let Some(face) = largest {
                out = out.or(properties(facet_values(*quantity, values[face])));
            }
        }
        out
    }
}

/// The values of a facet that a quantity gives.
fn facet_values(quantity: Quantity, x: f64) -> FacetValues {
    let none = FacetValues::default();
    let condition = |c: ThermalCondition| FacetValues { condition: Some(c), ..none };
    match quantity {
        Quantity::Temperature => condition(ThermalCondition::Temperature(x)),
        Quantity::HeatFlux => condition(ThermalCondition::Flux(x)),
        Quantity::NetPower => condition(ThermalCondition::Power(x)),
        Quantity::Emissivity => FacetValues { reflectance: Some(Bands::splat(1.0 - x)), ..none },
        Quantity::Reflectance => FacetValues { reflectance: Some(Bands::splat(x)), ..none },
        Quantity::Emission => FacetValues { emission: Some(Bands::splat(x)), ..none },
        // Spectra belong to a whole surface.
        Quantity::Spectral => none,
    }
}

fn properties(v: FacetValues) -> SurfaceProperties {
    let FacetValues { condition, reflectance, emission } = v;
    SurfaceProperties { condition, reflectance, emission, ..SurfaceProperties::default() }
}
