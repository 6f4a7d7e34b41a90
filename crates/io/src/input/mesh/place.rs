//! The faces of a mesh file moved into the scene, with the overrides that the scene file gives.

use super::closed::{Shell, shells};
use super::{Face, Loss, Material, Mesh, Picture};
use crate::input::build::{Builder, Fill};
use crate::input::error::{Fault, InputError};
use crate::input::medium::Matter;
use crate::input::node::{Node, Table, suggestion};
use crate::input::surface::{LOOK, Look, REFLECTANCE};
use std::collections::BTreeMap;
use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, Facet, Pane, Plate, Sides, Surface, bands};

/// x ↦ rotate(scale · x) + translate; turns about x, then y, then z.
struct Placement {
    scale: f64,
    axes: [Vec3; 3],
    translate: Vec3,
}

impl Placement {
    fn read(t: &Table<'_>) -> Result<Placement, InputError> {
        let turn = t.read("rotate_degrees", |n| n.vector())?.unwrap_or_default();
        let [(sx, cx), (sy, cy), (sz, cz)] = turn.array().map(|a| a.to_radians().sin_cos());
        let rotate = |v: Vec3| {
            let v = vec3(v.x, cx * v.y - sx * v.z, sx * v.y + cx * v.z);
            let v = vec3(cy * v.x + sy * v.z, v.y, cy * v.z - sy * v.x);
            vec3(cz * v.x - sz * v.y, sz * v.x + cz * v.y, v.z)
        };
        let scale = t.read("scale", |n| n.positive())?.unwrap_or(1.0);
        Ok(Placement {
            scale,
            axes: [0, 1, 2].map(|k| {
                let mut e = [0.0; 3];
                e[k] = scale;
                rotate(Vec3::from_array(e))
            }),
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

/// Reads `{ file, scale, translate, rotate_degrees }`: the mesh in scene coordinates, and the factor of lengths.
/// Faces without area are dropped and counted in the notes.
pub(crate) fn load(node: &Node<'_>, b: &mut Builder<'_>) -> Result<(Mesh, f64), InputError> {
    let t = node.table(&["file", "scale", "translate", "rotate_degrees"])?;
    let file = t.need("file", "file = \"mesh.obj\" (or .glb, .gltf)")?;
    let path = b.resolve(&file)?;
    let placement = Placement::read(&t)?;
    let name = path.display().to_string();
    let refused = |f: Fault| file.error(f.to_string());
    let mut mesh = super::read(&path, &name).map_err(refused)?;
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
        b.note(format!("{name}: {dropped} faces without area were dropped"));
    }
    for note in std::mem::take(&mut mesh.notes) {
        b.note(note);
    }
    Ok((mesh, placement.scale))
}

/// What `materials."X"` says.
#[derive(Clone, Default)]
struct Override {
    look: Look,
    omit: bool,
    region: bool,
    /// None: as the file says; Some(None): opaque.
    pane: Option<Option<PaneKeys>>,
    offset: Option<usize>,
}

#[derive(Clone, Copy, Default)]
struct PaneKeys {
    thickness: Option<f64>,
    extinction: Option<Bands>,
    albedo: Option<Bands>,
    emission: Option<Bands>,
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
    let overrides = read_overrides(table, &mesh, b)?;
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
        let walls: Vec<usize> = (0..mesh.faces.len())
            .filter(|i| wall_materials[mesh.faces[*i].material])
            .collect();
        let plates: Vec<Plate> = walls.iter().map(|i| mesh.faces[*i].plate).collect();
        for (i, kind) in walls.into_iter().zip(shells(&plates)) {
            kinds[i] = kind;
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
            name: if several {
                format!("{name}/{}", material.name)
            } else {
                name.to_string()
            },
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

fn read_overrides(
    table: &Table<'_>,
    mesh: &Mesh,
    b: &mut Builder<'_>,
) -> Result<BTreeMap<usize, Override>, InputError> {
    let mut out = BTreeMap::new();
    let Some(node) = table.get("materials") else {
        return Ok(out);
    };
    for (name, node) in node.any_table()?.entries() {
        let Some(index) = mesh.materials.iter().position(|m| m.name == name) else {
            let names: Vec<&str> = mesh.materials.iter().map(|m| m.name.as_str()).collect();
            let hint = suggestion(name, &names[..names.len().min(40)]);
            return Err(node.error(format!("the mesh has no material '{name}'; {hint}")));
        };
        let mut known = vec!["pane", "omit", "region"];
        known.extend(LOOK);
        let t = node.table(&known)?;
        let pane = t.read("pane", |n| {
            if !n.is_table() {
                return match n.boolean()? {
                    false => Ok(None),
                    true => Ok(Some(PaneKeys::default())),
                };
            }
            let t = n.table(&["thickness", "extinction", "albedo", "emission"])?;
            Ok(Some(PaneKeys {
                thickness: t.read("thickness", |n| n.positive())?,
                extinction: t.read("extinction", |n| n.bands(f64::INFINITY))?,
                albedo: t.read("albedo", |n| n.bands(1.0))?,
                emission: t.read("emission", |n| n.bands(f64::INFINITY))?,
            }))
        })?;
        let over = Override {
            look: Look::read(&t, b)?,
            omit: t.read("omit", |n| n.boolean())?.unwrap_or(false),
            region: t.read("region", |n| n.boolean())?.unwrap_or(false),
            pane,
            offset: Some(node.offset()),
        };
        out.insert(index, over);
    }
    Ok(out)
}

/// One material of a mesh on its way into the scene.
struct Part<'a, 'n> {
    table: &'a Table<'n>,
    node: &'a Node<'n>,
    name: String,
    material: &'a Material,
    over: &'a Override,
    /// The factor from the file's unit to metres.
    scale: f64,
}

impl Part<'_, '_> {
    fn error(&self, what: impl Into<String>) -> InputError {
        let offset = self.over.offset.unwrap_or(self.node.offset());
        self.table.source.error(offset, &self.table.key, what)
    }

    /// The picture's index, where there is one.
    fn picture(&self, picture: &Option<Picture>, b: &mut Builder<'_>) -> Result<Option<usize>, InputError> {
        let read = picture.as_ref().map(|p| b.picture(p));
        read.transpose().map_err(|f| self.error(f.to_string()))
    }

    /// One surface a kind of shell: open, body, room.
    fn surfaces(
        &self,
        faces: Vec<(&Face, Shell)>,
        look: Look,
        b: &mut Builder<'_>,
    ) -> Result<(), InputError> {
        let m = self.material;
        let look = self.over.look.or(look);
        // A reflectance or picture of the scene file replaces the material's picture.
        let own_picture = look.reflectance.is_none() && look.texture.is_none();
        let texture = match own_picture {
            true => self.picture(&m.texture, b)?,
            false => look.texture,
        };
        let emission_texture = match look.emission {
            None => self.picture(&m.emission_texture, b)?,
            Some(_) => None,
        };
        let kinds = [
            (Shell::Open, ""),
            (Shell::Body, " (solid)"),
            (Shell::Room, " (room)"),
        ];
        let present = |kind: Shell| faces.iter().any(|(_, s)| *s == kind);
        let mixed = kinds.iter().filter(|(k, _)| present(*k)).count() > 1;
        for (kind, suffix) in kinds {
            if !present(kind) {
                continue;
            }
            let default = match (kind, m.both_sides) {
                (Shell::Open, Some(false)) => Sides::Front,
                (Shell::Open, _) => Sides::Both,
                _ => Sides::Front,
            };
            let sides = look.sides.unwrap_or(default);
            let name = match mixed {
                true => format!("{}{suffix}", self.name),
                false => self.name.clone(),
            };
            b.alias(&name, &self.name);
            let surface = b.add_surface(Surface {
                name,
                reflectance: look.reflectance.or(m.reflectance).unwrap_or(REFLECTANCE),
                emission: look.emission.unwrap_or(m.emission),
                reflectance_texture: texture,
                emission_texture,
                sides,
                patch_size: look.patch_size,
                solid: kind == Shell::Body && sides == Sides::Front,
            });
            b.parts
                .facets
                .extend(faces.iter().filter(|(_, s)| *s == kind).map(|(f, _)| Facet {
                    surface,
                    plate: f.plate,
                    uv: f.uv,
                }));
        }
        Ok(())
    }

    /// One pane a thickness: nodes of different scales show the same glass in different thicknesses.
    fn panes(&self, faces: Vec<&Face>, b: &mut Builder<'_>) -> Result<(), InputError> {
        let plates: Vec<Plate> = faces.iter().map(|f| f.plate).collect();
        if shells(&plates).iter().any(|s| *s != Shell::Open) {
            b.note(format!(
                "pane '{}' is a closed slab: light goes through both its faces and the glass counts twice; give half the thickness, or region = true",
                self.name
            ));
        }
        let mut groups: BTreeMap<u64, Vec<Plate>> = BTreeMap::new();
        for f in faces {
            let t = self.thickness(f.scale)?;
            groups.entry(t.to_bits()).or_default().push(f.plate);
        }
        for (i, (bits, plates)) in groups.into_iter().enumerate() {
            let thickness = f64::from_bits(bits);
            let (extinction, albedo, emission) = self.matter(Some(thickness))?;
            b.parts.panes.push(Pane {
                name: match i {
                    0 => self.name.clone(),
                    _ => format!("{}#{}", self.name, i + 1),
                },
                plates,
                thickness,
                extinction,
                albedo,
                emission,
            });
        }
        Ok(())
    }

    fn keys(&self) -> PaneKeys {
        self.over.pane.flatten().unwrap_or_default()
    }

    fn thickness(&self, node_scale: f64) -> Result<f64, InputError> {
        let name = &self.material.name;
        let of_file = self.material.glass.and_then(|g| g.thickness);
        let of_file = of_file.map(|t| t * node_scale * self.scale);
        match self.keys().thickness.or(of_file) {
            Some(t) if t > 0.0 && t.is_finite() => Ok(t),
            _ => Err(self.error(format!(
                "material '{name}' lets light through, but its thickness is not known; write materials.\"{name}\".pane.thickness = 0.01 (metres), or materials.\"{name}\".pane = false for an opaque surface"
            ))),
        }
    }

    /// Extinction, albedo, emission of the glass, overrides first.
    fn matter(&self, thickness: Option<f64>) -> Result<(Bands, Bands, Bands), InputError> {
        let keys = self.keys();
        let name = &self.material.name;
        let of_file = self.material.glass.and_then(|g| match (g.loss, thickness) {
            (Loss::PerMetre(k), _) => Some(k.map(|x| x / self.scale)),
            (Loss::Passed(share), Some(t)) => Some(bands(|b| (-share[b].ln() / t).max(0.0))),
            (Loss::Passed(_), None) => None,
        });
        let extinction = keys.extinction.or(of_file).ok_or_else(|| {
            self.error(format!(
                "the extinction of material '{name}' is not known; write materials.\"{name}\".pane.extinction = [red, green, blue] (1/m)"
            ))
        })?;
        let albedo = keys.albedo.or(self.material.glass.map(|g| g.albedo));
        Ok((
            extinction,
            albedo.unwrap_or([0.0; 3]),
            keys.emission.unwrap_or([0.0; 3]),
        ))
    }

    /// A closed mesh that fills the voxmap.
    fn region(&self, faces: Vec<&Face>, b: &mut Builder<'_>) -> Result<(), InputError> {
        if !b.has_medium {
            return Err(self.error(format!(
                "material '{}' is to fill the medium, but there is none; add a [medium] around it",
                self.material.name
            )));
        }
        let thickness = faces.first().and_then(|f| self.thickness(f.scale).ok());
        let (extinction, albedo, emission) = self.matter(thickness)?;
        let plates: Vec<Plate> = faces.iter().map(|f| f.plate).collect();
        check_closed(&plates).map_err(|what| self.error(what))?;
        b.fills.push(Fill {
            plates,
            matter: Matter {
                extinction: Some(extinction),
                albedo: Some(albedo),
                emission: Some(emission),
                source: None,
            },
        });
        Ok(())
    }
}

/// Refuses plates that do not bound a body.
pub(crate) fn check_closed(plates: &[Plate]) -> Result<(), String> {
    let open = shells(plates).iter().filter(|s| **s == Shell::Open).count();
    match open {
        0 => Ok(()),
        n => Err(format!(
            "{n} of the {} faces belong to no closed body, so that nothing is inside; close the mesh",
            plates.len()
        )),
    }
}
