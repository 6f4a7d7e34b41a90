//! `[[surface]]`: one shape with its properties, inline or from a mesh file.

use crate::input::reading::error::InputError;
use crate::input::scene::mesh_surface::read_mesh_surface;
use crate::input::scene::quantities::surface_properties::{SurfaceProperties, SurfaceShape};
use crate::input::scene::scene_reader::SceneReader;
use crate::input::scene::shapes::{self, FACE_NAMES, Facing, UPRIGHT_UV};
use crate::input::scene::surface_keys::read_properties;
use crate::input::toml::node::{TomlNode, TomlTable};
use crate::input::toml::surface_keys::{
    Faces, SURFACE, Shapes, Surface as SurfaceKeys, SurfaceProperties as PropertyKeys,
};
use zonal_scene::{Facet, Plate};

/// Keys that belong to some shapes only.
const KEYS_OF_SHAPES: [(&str, &[&str]); 6] = [
    ("faces", &["box", "room"]),
    ("omit", &["room"]),
    ("materials", &["mesh"]),
    ("solid", &["mesh"]),
    ("open_sides", &["mesh"]),
    ("lights", &["mesh"]),
];

/// Reads entry `index` of `[[surface]]`.
pub(crate) fn read_surface(
    node: &TomlNode<'_>,
    index: usize,
    reader: &mut SceneReader<'_>,
) -> Result<(), InputError> {
    let (name, mut table) = node.named_table("surface", index)?;
    table.check(SurfaceKeys::TABLE)?;
    table.key = format!("surface '{name}'");
    table.record_place();
    // Find the one shape and refuse keys of other shapes.
    let shape = only_shape(&table)?;
    for (key, shapes) in KEYS_OF_SHAPES {
        if let Some(n) = table.get(key)
            && !shapes.contains(&shape)
        {
            return Err(
                n.error(format!("this key is for a {}; remove it from this {shape}", shapes.join(" or a ")))
            );
        }
    }
    // Read the properties, then the geometry.
    let properties = read_properties(&table, reader)?;
    let Some(shape_node) = table.get(shape) else { return Err(table.missing(shape, "a shape")) };
    match shape {
        "rectangle" => add_sheet(reader, &name, &properties, shapes::read_rectangle(&shape_node)?),
        "triangle" => add_sheet(reader, &name, &properties, shapes::read_triangle(&shape_node)?),
        "box" => {
            let plates = shapes::read_solid_box(&shape_node)?;
            let box_faces = BoxFaces { name: &name, properties, plates, shape: SurfaceShape::Solid };
            box_faces.read(&table, reader)
        }
        "room" => {
            let (min, max) = shapes::read_box_bounds(&shape_node)?;
            let plates = shapes::box_faces(min, max, Facing::Inward);
            let box_faces = BoxFaces { name: &name, properties, plates, shape: SurfaceShape::Sheet };
            box_faces.read(&table, reader)
        }
        _ => read_mesh_surface(&table, &shape_node, &name, properties, reader),
    }
}

/// The one shape that a table gives.
fn only_shape(table: &TomlTable<'_>) -> Result<&'static str, InputError> {
    let given: Vec<&str> = Shapes::ALL.iter().map(|s| s.name).filter(|s| table.get(s).is_some()).collect();
    match given.as_slice() {
        [shape] => Ok(shape),
        [] => {
            Err(table.error("this surface has no shape; write one of rectangle, triangle, box, room, mesh"))
        }
        several => Err(table.error(format!(
            "this surface has {} shapes ({}); keep one and move the others to surfaces of their own",
            several.len(),
            several.join(", ")
        ))),
    }
}

fn add_sheet(
    reader: &mut SceneReader<'_>,
    name: &str,
    properties: &SurfaceProperties,
    plate: Plate,
) -> Result<(), InputError> {
    let surface = properties.surface(name.to_string(), SurfaceShape::Sheet);
    let surface = reader.add_surface(surface, properties)?;
    reader.parts.facets.push(Facet { surface, plate, uv: UPRIGHT_UV });
    Ok(())
}

/// The faces of a box (one surface, except for faces with properties of their own) or of a room (a surface each).
struct BoxFaces<'a> {
    name: &'a str,
    /// Of all faces.
    properties: SurfaceProperties,
    plates: [Plate; 6],
    shape: SurfaceShape,
}

impl BoxFaces<'_> {
    /// Reads `omit` and `faces` of the table and adds the surfaces.
    fn read(&self, table: &TomlTable<'_>, reader: &mut SceneReader<'_>) -> Result<(), InputError> {
        let omitted = read_omitted(table)?;
        let own = self.read_own_properties(table, &omitted, reader)?;
        let mut common_surface = None;
        for i in (0..6).filter(|i| !omitted[*i]) {
            let face_name = format!("{}.{}", self.name, FACE_NAMES[i]);
            if self.shape == SurfaceShape::Sheet || own[i].is_some() {
                reader.inherit_surface_place(&face_name, self.name);
            }
            let surface = match (own[i], self.shape) {
                (Some(own), shape) => reader.add_surface(own.surface(face_name, shape), &own)?,
                (None, SurfaceShape::Sheet) => {
                    let surface = self.properties.surface(face_name, SurfaceShape::Sheet);
                    reader.add_surface(surface, &self.properties)?
                }
                (None, SurfaceShape::Solid) => match common_surface {
                    Some(surface) => surface,
                    None => {
                        let surface = self.properties.surface(self.name.to_string(), SurfaceShape::Solid);
                        *common_surface.insert(reader.add_surface(surface, &self.properties)?)
                    }
                },
            };
            reader.parts.facets.push(Facet { surface, plate: self.plates[i], uv: UPRIGHT_UV });
        }
        Ok(())
    }

    /// The properties of faces that have their own, with gaps filled from those of all faces.
    fn read_own_properties(
        &self,
        table: &TomlTable<'_>,
        omitted: &[bool; 6],
        reader: &mut SceneReader<'_>,
    ) -> Result<[Option<SurfaceProperties>; 6], InputError> {
        let mut own = [None; 6];
        let Some(node) = table.get(&SURFACE.faces) else { return Ok(own) };
        let faces = node.table(Faces::TABLE)?;
        for (i, face) in FACE_NAMES.into_iter().enumerate() {
            let Some(n) = faces.get(face) else { continue };
            if omitted[i] {
                return Err(n.error("this wall is left out; remove it here or from omit"));
            }
            let t = n.table(PropertyKeys::TABLE)?;
            t.source.record_place(format!("surface '{}.{face}'", self.name), t.offset());
            own[i] = Some(read_properties(&t, reader)?.or(self.properties));
        }
        Ok(own)
    }
}

/// The walls that `omit` lists.
fn read_omitted(table: &TomlTable<'_>) -> Result<[bool; 6], InputError> {
    let mut omitted = [false; 6];
    let Some(node) = table.get(&SURFACE.omit) else { return Ok(omitted) };
    for face in node.list()? {
        omitted[face.choice(&FACE_NAMES)?] = true;
    }
    if omitted == [true; 6] {
        return Err(node.error("all six walls are left out; keep at least one"));
    }
    Ok(omitted)
}
