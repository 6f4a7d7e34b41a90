//! The faces of a mesh file moved into the scene, with the overrides that the scene file gives.

use super::closed::{Shell, Shells, shells};
use super::part::Part;
use super::{Face, Mesh, overrides};
use crate::input::build::Builder;
use crate::input::error::{Fault, InputError};
use crate::input::node::{Node, Table};
use crate::input::surface::Look;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Note, Plate};

/// x ↦ rotate(scale · x) + translate; turns about x, then y, then z.
struct Placement {
    scale: f64,
    axes: [Vec3; 3],
    translate: Vec3,
}

impl Placement {
    fn read(t: &Table<'_>) -> Result<Placement, InputError> {
        let scale = t.read("scale", |n| n.positive())?.unwrap_or(1.0);
        Ok(Placement {
            scale,
            axes: turned(t, scale)?,
            translate: t.read("translate", |n| n.vector())?.unwrap_or_default(),
        })
    }
    fn vector(&self, v: Vec3) -> Vec3 {
        self.axes[0] * v.x + self.axes[1] * v.y + self.axes[2] * v.z
    }
    fn plate(&self, p: &Plate) -> Plate {
        Plate {
            origin: self.vector(p.origin) + self.translate,
            e1: self.vector(p.e1),
            e2: self.vector(p.e2),
            kind: p.kind,
        }
    }
}

/// Vectors of this length along x, y, z after the turns of `rotate_degrees`, about x, then y, then z.
pub(crate) fn turned(t: &Table<'_>, length: f64) -> Result<[Vec3; 3], InputError> {
    let turn = t.read("rotate_degrees", |n| n.vector())?.unwrap_or_default();
    let [(sx, cx), (sy, cy), (sz, cz)] = turn.array().map(|a| a.to_radians().sin_cos());
    let rotate = |v: Vec3| {
        let v = vec3(v.x, cx * v.y - sx * v.z, sx * v.y + cx * v.z);
        let v = vec3(cy * v.x + sy * v.z, v.y, cy * v.z - sy * v.x);
        vec3(cz * v.x - sz * v.y, sz * v.x + cz * v.y, v.z)
    };
    Ok([vec3(length, 0.0, 0.0), vec3(0.0, length, 0.0), vec3(0.0, 0.0, length)].map(rotate))
}

/// Reads `{ file, scale, translate, rotate_degrees }`: the mesh in scene coordinates, and the factor of lengths.
/// Faces without area are dropped and counted in the notes.
pub(crate) fn load(node: &Node<'_>, b: &mut Builder<'_>) -> Result<(Mesh, f64), InputError> {
    let t = node.table(&["file", "scale", "translate", "rotate_degrees"])?;
    let file = t.need("file", "file = \"mesh.obj\" (or .glb, .gltf)")?;
    let path = b.resolve(&file)?;
    let placement = Placement::read(&t)?;
    let name = path.display().to_string();
    let refused = |f: Fault| file.error(f.to_string());
    let mut mesh = super::read(b.place.files, &path, &name).map_err(refused)?;
    for face in &mut mesh.faces {
        face.plate = placement.plate(&face.plate);
        if !(face.plate.origin.is_finite() && face.plate.area().is_finite()) {
            return Err(
                node.error("the placed mesh lies beyond all numbers; give a smaller scale or translate")
            );
        }
    }
    let before = mesh.faces.len();
    mesh.faces.retain(|f| {
        let p = &f.plate;
        p.area() > 1e-14 * p.e1.length2().max(p.e2.length2())
    });
    let dropped = before - mesh.faces.len();
    if mesh.faces.is_empty() {
        let what = format!("all {before} faces are without area; export the mesh again");
        return Err(refused(Fault::new(&name, "", what)));
    }
    if dropped > 0 {
        b.note(Note::new("faces-dropped", format!("{name}: {dropped} faces without area were dropped")));
    }
    for note in std::mem::take(&mut mesh.notes) {
        b.note(Note::new("mesh", note));
    }
    Ok((mesh, placement.scale))
}

/// `mesh = { file, … }` of a surface.
pub(crate) fn read_surface(
    table: &Table<'_>,
    node: &Node<'_>,
    name: &str,
    look: Look,
    b: &mut Builder<'_>,
) -> Result<(), InputError> {
    let (mesh, scale) = load(node, b)?;
    let overrides = overrides::read(table, &mesh, b)?;
    let solid = table.read("solid", |n| n.boolean())?.unwrap_or(true);
    let mut by_material: Vec<Vec<usize>> = vec![Vec::new(); mesh.materials.len()];
    for (i, f) in mesh.faces.iter().enumerate() {
        by_material[f.material].push(i);
    }
    let several = by_material.iter().filter(|f| !f.is_empty()).count() > 1;
    let of = |m: usize| overrides.get(&m).cloned().unwrap_or_default();
    let is_pane = |m: usize| match of(m).pane {
        Some(pane) => pane.is_some(),
        None => mesh.materials[m].glass.is_some(),
    };
    // Panes and what is left out close nothing.
    let mut kinds = vec![Shell::Open; mesh.faces.len()];
    if solid {
        let is_wall = |m: usize| !is_pane(m) && !of(m).omit && !of(m).region;
        let wall_materials: Vec<bool> = (0..mesh.materials.len()).map(is_wall).collect();
        let walls: Vec<usize> =
            (0..mesh.faces.len()).filter(|i| wall_materials[mesh.faces[*i].material]).collect();
        let plates: Vec<Plate> = walls.iter().map(|i| mesh.faces[*i].plate).collect();
        let shells = shells(&plates);
        if look.sides.is_none() {
            nearly_closed(&shells, name, b);
        }
        for (k, i) in walls.into_iter().enumerate() {
            kinds[i] = shells.of(k);
        }
    }
    for (m, material) in mesh.materials.iter().enumerate() {
        let over = of(m);
        if by_material[m].is_empty() || over.omit {
            continue;
        }
        let part = Part {
            table,
            node,
            name: if several { format!("{name}/{}", material.name) } else { name.to_string() },
            material,
            over: &over,
            scale,
        };
        if let Some(offset) = over.offset {
            table.source.remember(format!("surface '{}'", part.name), offset);
            table.source.remember(format!("pane '{}'", part.name), offset);
        } else {
            b.alias(&part.name, name);
        }
        if over.region || is_pane(m) {
            part.check_glass(b.thermal())?;
        }
        let faces: Vec<&Face> = by_material[m].iter().map(|i| &mesh.faces[*i]).collect();
        if over.region {
            part.region(faces, b)?;
        } else if is_pane(m) {
            part.panes(faces, b)?;
        } else {
            let own = by_material[m].iter().map(|i| (&mesh.faces[*i], kinds[*i]));
            part.surfaces(own.collect(), look, b)?;
        }
    }
    Ok(())
}

/// Area vectors of a nearly closed part add up to less than this share of its area, and it is open by so many edges at most.
const NEARLY_CLOSED: f64 = 0.01;
const FEW_EDGES: usize = 4;
/// A part whose area vectors add up to more than this share of its area looks one way, and encloses nothing.
const MOST_ONE_WAY: f64 = 0.5;
/// Parts smaller than this share of the mesh's area are details of which nothing is said.
const DETAIL: f64 = 0.1;

/// Notes the parts of a mesh that are open by a few edges only: their insides exchange, and medium inside them takes part.
fn nearly_closed(shells: &Shells, name: &str, b: &mut Builder<'_>) {
    let mut found = [(0, 0); 2];
    let all: f64 = shells.components().iter().map(|c| c.area).sum();
    for c in shells.components() {
        if c.turned_edges + c.free_edges > FEW_EDGES || c.area < DETAIL * all {
            continue;
        }
        let round = c.area_vector.length() < MOST_ONE_WAY * c.area;
        let turned = c.turned_edges > 0 && c.free_edges == 0 && round;
        let holes = c.free_edges > 0 && c.area_vector.length() < NEARLY_CLOSED * c.area;
        if turned || holes {
            let f = &mut found[usize::from(holes)];
            *f = (f.0 + 1, f.1 + c.turned_edges + c.free_edges);
        }
    }
    for ((parts, edges), why) in found.into_iter().zip(["neighbours that look opposite ways", "no neighbour"])
    {
        if parts > 0 {
            let text = format!(
                "mesh of surface '{name}': {parts} part(s) would be closed but for {edges} edge(s) whose faces have {why}; they count as open, so that both sides exchange and a medium inside takes part: mend the mesh, or write sides"
            );
            b.note(Note::warning("open-mesh", text));
        }
    }
}
