//! `[[surface]]` and `[[pane]]`: what they are made of, and their inline shapes.

use super::build::Builder;
use super::error::InputError;
use super::node::{Node, Table};
use super::shapes::{self, FACES, UPRIGHT};
use super::thermal;
use zonal_scene::{Bands, Facet, Known, Pane, Plate, Sides, Surface};

/// Reflectance where nothing says otherwise.
pub(crate) const REFLECTANCE: Bands = [0.5; 3];
/// The keys of a look, in every table that has one.
pub(crate) const LOOK: [&str; 9] = [
    "reflectance",
    "emission",
    "sides",
    "patch_size",
    "texture",
    "emissivity",
    "temperature",
    "heat_flux",
    "net_power",
];

/// What a table says about a surface; what it leaves out comes from elsewhere.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Look {
    pub(crate) reflectance: Option<Bands>,
    pub(crate) emission: Option<Bands>,
    pub(crate) sides: Option<Sides>,
    pub(crate) patch_size: Option<f64>,
    pub(crate) texture: Option<usize>,
    /// Temperature or net power, in thermal mode.
    pub(crate) heat: Option<Known>,
}

impl Look {
    pub(crate) fn read(table: &Table<'_>, b: &mut Builder<'_>) -> Result<Look, InputError> {
        thermal::check_mode(table, b.thermal())?;
        Ok(Look {
            heat: thermal::wall(table)?,
            reflectance: thermal::reflectance(table)?,
            emission: table.read("emission", |n| n.bands(f64::INFINITY))?,
            sides: table.read("sides", |n| Ok([Sides::Front, Sides::Both][n.choice(&["front", "both"])?]))?,
            patch_size: table.read("patch_size", |n| n.positive())?,
            texture: table.read("texture", |n| b.texture(&n))?,
        })
    }
    /// This look, with the gaps filled from `other`.
    pub(crate) fn or(self, other: Look) -> Look {
        Look {
            reflectance: self.reflectance.or(other.reflectance),
            emission: self.emission.or(other.emission),
            sides: self.sides.or(other.sides),
            patch_size: self.patch_size.or(other.patch_size),
            texture: self.texture.or(other.texture),
            heat: self.heat.or(other.heat),
        }
    }
    /// An inline surface that looks like this.
    fn surface(&self, name: String, solid: bool) -> Surface {
        let sides = self.sides.unwrap_or(Sides::Front);
        Surface {
            name,
            reflectance: self.reflectance.unwrap_or(REFLECTANCE),
            emission: self.emission.unwrap_or([0.0; 3]),
            reflectance_texture: self.texture,
            emission_texture: None,
            sides,
            patch_size: self.patch_size,
            // A body whose inside exchanges too is hollow.
            solid: solid && sides == Sides::Front,
        }
    }
}

/// One entry of `[[surface]]`.
pub(crate) fn read_surface(node: &Node<'_>, index: usize, b: &mut Builder<'_>) -> Result<(), InputError> {
    const SHAPES: [&str; 5] = ["rectangle", "triangle", "box", "room", "mesh"];
    let mut known = vec!["name", "faces", "omit", "materials", "solid"];
    known.extend(SHAPES.iter().chain(&LOOK));
    let (name, mut table) = named(node, "surface", index)?;
    table.check(&known)?;
    table.key = format!("surface '{name}'");
    table.remember();
    let given: Vec<&str> = SHAPES.into_iter().filter(|s| table.get(s).is_some()).collect();
    let [shape] = given.as_slice() else {
        return Err(table.error(if given.is_empty() {
            "this surface has no shape; write one of rectangle, triangle, box, room, mesh".to_string()
        } else {
            format!(
                "this surface has {} shapes ({}); keep one and move the others to surfaces of their own",
                given.len(),
                given.join(", ")
            )
        }));
    };
    for (key, of) in
        [("faces", &["box", "room"][..]), ("omit", &["room"]), ("materials", &["mesh"]), ("solid", &["mesh"])]
    {
        if let Some(n) = table.get(key)
            && !of.contains(shape)
        {
            return Err(
                n.error(format!("this key is for a {}; remove it from this {shape}", of.join(" or a ")))
            );
        }
    }
    let look = Look::read(&table, b)?;
    let shape_node = table.need(shape, "a shape")?;
    match *shape {
        "rectangle" => single(b, &name, &look, shapes::rectangle(&shape_node)?)?,
        "triangle" => single(b, &name, &look, shapes::triangle(&shape_node)?)?,
        "box" => {
            let plates = shapes::solid_box(&shape_node)?;
            read_faces(&table, b, &name, &look, &plates, true)?;
        }
        "room" => {
            let (min, max) = shapes::bounds(&shape_node, &[])?;
            read_faces(&table, b, &name, &look, &shapes::faces(min, max, true), false)?;
        }
        _ => super::mesh::place::read_surface(&table, &shape_node, &name, look, b)?,
    }
    Ok(())
}

/// A table with its name; `surface2` and the like where it has none.
pub(crate) fn named<'a>(
    node: &Node<'a>,
    kind: &str,
    index: usize,
) -> Result<(String, Table<'a>), InputError> {
    let mut table = node.any_table()?;
    table.key = format!("{kind} #{}", index + 1);
    let name = table.read("name", |n| n.text())?;
    let name = name.map_or_else(|| format!("{kind}{}", index + 1), str::to_string);
    Ok((name, table))
}

fn single(b: &mut Builder<'_>, name: &str, look: &Look, plate: Plate) -> Result<(), InputError> {
    let surface = b.add_surface(look.surface(name.to_string(), false), look)?;
    b.parts.facets.push(Facet { surface, plate, uv: UPRIGHT });
    Ok(())
}

/// The faces of a box (one surface, apart from the faces with a look of their own) or of a room (a surface each).
fn read_faces(
    table: &Table<'_>,
    b: &mut Builder<'_>,
    name: &str,
    look: &Look,
    plates: &[Plate; 6],
    solid: bool,
) -> Result<(), InputError> {
    let mut omitted = [false; 6];
    if let Some(node) = table.get("omit") {
        for face in node.list()? {
            omitted[face.choice(&FACES)?] = true;
        }
        if omitted == [true; 6] {
            return Err(node.error("all six walls are left out; keep at least one"));
        }
    }
    let mut own: [Option<Look>; 6] = [None; 6];
    if let Some(node) = table.get("faces") {
        let faces = node.table(&FACES)?;
        for (i, face) in FACES.into_iter().enumerate() {
            let Some(n) = faces.get(face) else { continue };
            if omitted[i] {
                return Err(n.error("this wall is left out; remove it here or from omit"));
            }
            let t = n.table(&LOOK)?;
            t.source.remember(format!("surface '{name}.{face}'"), t.offset());
            own[i] = Some(Look::read(&t, b)?.or(*look));
        }
    }
    let mut rest = None;
    for i in 0..6 {
        if omitted[i] {
            continue;
        }
        let face_name = format!("{name}.{}", FACES[i]);
        if !solid || own[i].is_some() {
            b.alias(&face_name, name);
        }
        let surface = match (own[i], solid) {
            (Some(own), _) => b.add_surface(own.surface(face_name, solid), &own)?,
            (None, false) => b.add_surface(look.surface(face_name, false), look)?,
            (None, true) => match rest {
                Some(surface) => surface,
                None => *rest.insert(b.add_surface(look.surface(name.to_string(), true), look)?),
            },
        };
        b.parts.facets.push(Facet { surface, plate: plates[i], uv: UPRIGHT });
    }
    Ok(())
}

/// One entry of `[[pane]]`.
pub(crate) fn read_pane(node: &Node<'_>, index: usize, b: &mut Builder<'_>) -> Result<(), InputError> {
    let (name, mut table) = named(node, "pane", index)?;
    table.check(&PANE)?;
    table.key = format!("pane '{name}'");
    table.remember();
    thermal::check_mode(&table, b.thermal())?;
    let plates = shapes::polygon(&table.need("polygon", "polygon = [[x, y, z], [x, y, z], [x, y, z]]")?)?;
    let thickness = table.need("thickness", "thickness = 0.01 (metres)")?.positive()?;
    let [extinction, albedo] = thermal::extinction(&table)?;
    let Some(extinction) = extinction else {
        let example =
            "extinction = [red, green, blue] (1/m; the share that passes is exp(-extinction × thickness))";
        return Err(match table.need("extinction", example) {
            Err(e) => e,
            Ok(n) => n.error("this key is missing"),
        });
    };
    b.add_pane_heat(thermal::volume(&table)?);
    b.parts.panes.push(Pane {
        name,
        plates,
        thickness,
        extinction,
        albedo: albedo.unwrap_or([0.0; 3]),
        emission: table.read("emission", |n| n.bands(f64::INFINITY))?.unwrap_or([0.0; 3]),
    });
    Ok(())
}

/// The keys of a pane.
const PANE: [&str; 9] = [
    "name",
    "polygon",
    "thickness",
    "extinction",
    "albedo",
    "emission",
    "absorption",
    "temperature",
    "heat_source",
];
