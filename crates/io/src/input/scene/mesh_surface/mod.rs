//! `mesh = { file, … }` of a surface: each material becomes surfaces, panes or a region of the medium.

pub(crate) mod face_values;
pub(crate) mod material_overrides;
pub(crate) mod material_part;
pub(crate) mod mesh_lights;
pub(crate) mod placement;
pub(crate) mod repeated_faces;
pub(crate) mod transparent_materials;

use crate::input::mesh::missing_values::refuse_missing;
use crate::input::mesh::model::{MeshData, MeshFace};
use crate::input::mesh::shells::{OpenSides, ShellKind, Shells, find_shells, turned_parts};
use crate::input::reading::error::InputError;
use crate::input::scene::mesh_surface::face_values::read_face_values;
use crate::input::scene::mesh_surface::material_overrides::MaterialOverride;
use crate::input::scene::mesh_surface::material_part::MaterialPart;
use crate::input::scene::mesh_surface::mesh_lights::add_lights;
use crate::input::scene::mesh_surface::placement::load_placed;
use crate::input::scene::mesh_surface::repeated_faces::drop_repeated_faces;
use crate::input::scene::mesh_surface::transparent_materials::cut_transparent_materials;
use crate::input::scene::quantities::surface_properties::SurfaceProperties;
use crate::input::scene::scene_reader::SceneReader;
use crate::input::scene::thermal::SceneMode;
use crate::input::toml::node::{TomlNode, TomlTable};
use crate::input::toml::surface_keys::{SURFACE, SurfaceMesh};
use std::collections::BTreeMap;
use zonal_scene::{Diagnostic, FaceMesh, Plate, Sides};

/// Thresholds of the warning about parts that are open at a few edges.
struct NearlyClosedParams {
    /// Length of the sum of the area vectors relative to the area, below which a part with free edges is nearly closed.
    max_open_area_fraction: f64,
    /// The same for a part that lacks one triangle, which is no opening by intention.
    max_missing_triangle_fraction: f64,
    /// Number of open edges of a nearly closed part.
    max_open_edges: usize,
    /// Length of the sum of the area vectors relative to the area, above which a part has one orientation and encloses nothing.
    max_one_sided_fraction: f64,
    /// Area relative to the mesh, below which a part gives no warning.
    min_area_fraction: f64,
    /// Number of open edges relative to the faces, above which a part with edges of three or more faces has borders of its own.
    max_open_edges_per_face: f64,
}

const NEARLY_CLOSED: NearlyClosedParams = NearlyClosedParams {
    max_open_area_fraction: 0.01,
    max_missing_triangle_fraction: 0.25,
    max_open_edges: 4,
    max_one_sided_fraction: 0.5,
    min_area_fraction: 0.1,
    max_open_edges_per_face: 0.1,
};

/// Reads the mesh of a surface and adds its parts to the scene.
pub(crate) fn read_mesh_surface(
    table: &TomlTable<'_>,
    node: &TomlNode<'_>,
    name: &str,
    properties: SurfaceProperties,
    reader: &mut SceneReader<'_>,
) -> Result<(), InputError> {
    let (mut mesh, scale) = load_placed(node, SurfaceMesh::TABLE, reader)?;
    add_lights(table, &mesh, name, reader)?;
    let overrides = material_overrides::read_overrides(table, &mesh, reader)?;
    let values = read_face_values(table, &mesh, reader)?;
    let first_face = reader.parts.faces.len();
    reader.parts.faces.meshes.push(FaceMesh { name: name.to_string(), faces: mesh.face_count });
    let kinds = MaterialUse::new(&mesh, &overrides).kinds();
    drop_repeated_faces(&mut mesh, &kinds, name, reader);
    cut_transparent_materials(&mut mesh, scale, properties.patch_size, &overrides, reader)
        .map_err(|f| node.error(f.to_string()))?;
    let materials = MaterialUse::new(&mesh, &overrides);
    let open_sides = read_open_sides(table, properties.sides)?;
    let shell_of_face = find_shells_of_faces(table, name, &materials, properties.sides, open_sides, reader)?;
    // Collect the materials in use.
    let overs: Vec<MaterialOverride> = (0..mesh.materials.len()).map(|m| materials.override_of(m)).collect();
    let several = materials.faces.iter().filter(|f| !f.is_empty()).count() > 1;
    let part = |(m, kind): (usize, MaterialKind)| {
        let material = &mesh.materials[m];
        let part = MaterialPart {
            table,
            node,
            name: if several { format!("{name}/{}", material.name) } else { name.to_string() },
            material,
            over: &overs[m],
            scale,
            first_face,
            open_sides,
            normals: &mesh.normals,
            values: &values,
            of_material: values.of_material(m),
        };
        let faces = materials.faces[m].iter().map(|i| (&mesh.faces[*i], shell_of_face[*i])).collect();
        UsedMaterial { part, kind, faces }
    };
    let used: Vec<UsedMaterial<'_, '_>> = materials.used().map(part).collect();
    // Check all, then add each.
    check_materials(&used, name, properties, reader)?;
    used.into_iter().try_for_each(|material| material.add(properties, reader))
}

/// Kind of the part of the scene that a material gives.
#[derive(Clone, Copy, PartialEq, Eq)]
enum MaterialKind {
    Opaque,
    Pane,
    Region,
}

/// A material in use with its faces.
struct UsedMaterial<'a, 'n> {
    part: MaterialPart<'a, 'n>,
    kind: MaterialKind,
    faces: Vec<(&'a MeshFace, ShellKind)>,
}

impl UsedMaterial<'_, '_> {
    /// Adds its part to the scene.
    fn add(self, properties: SurfaceProperties, reader: &mut SceneReader<'_>) -> Result<(), InputError> {
        let UsedMaterial { part, kind, faces } = self;
        match kind {
            MaterialKind::Region => part.add_region(faces.into_iter().map(|(f, _)| f).collect(), reader),
            MaterialKind::Pane => part.add_panes(faces.into_iter().map(|(f, _)| f).collect(), reader),
            MaterialKind::Opaque => part.add_surfaces(faces, properties, reader),
        }
    }
}

/// Records the places of materials, and refuses those with keys of surfaces on glass or without values that they need.
fn check_materials(
    used: &[UsedMaterial<'_, '_>],
    name: &str,
    properties: SurfaceProperties,
    reader: &SceneReader<'_>,
) -> Result<(), InputError> {
    let mut missing = Vec::new();
    for UsedMaterial { part, kind, faces } in used {
        if let Some(offset) = part.over.offset {
            part.table.source.record_place(format!("surface '{}'", part.name), offset);
            part.table.source.record_place(format!("pane '{}'", part.name), offset);
        } else {
            reader.inherit_surface_place(&part.name, name);
        }
        let gaps = match kind {
            MaterialKind::Opaque if reader.mode() == SceneMode::Light => Vec::new(),
            MaterialKind::Opaque => part.missing_of_surfaces(faces, properties),
            _ => {
                part.check_glass(reader.mode())?;
                part.missing_of_glass(faces).into_iter().collect()
            }
        };
        missing.extend(gaps.into_iter().map(|value| (part.material.name.as_str(), value)));
    }
    match used.first() {
        Some(first) => refuse_missing(first.part.table, &missing),
        None => Ok(()),
    }
}

/// Reads `open_sides`, which has no effect beside `sides`.
fn read_open_sides(table: &TomlTable<'_>, sides: Option<Sides>) -> Result<OpenSides, InputError> {
    let Some(node) = table.get(&SURFACE.open_sides) else { return Ok(OpenSides::OfFile) };
    if sides.is_some() {
        return Err(node.error("sides gives the sides of all parts of this mesh; remove sides or open_sides"));
    }
    Ok([OpenSides::OfFile, OpenSides::Both][node.choice(&["file", "both"])?])
}

/// The kind of shell of each face, found by part of the mesh among the opaque faces; `solid = false` makes all parts open. Parts that are turned inside
/// out are open where open parts exchange on both sides.
fn find_shells_of_faces(
    table: &TomlTable<'_>,
    name: &str,
    materials: &MaterialUse<'_>,
    sides: Option<Sides>,
    open_sides: OpenSides,
    reader: &mut SceneReader<'_>,
) -> Result<Vec<ShellKind>, InputError> {
    let all = &materials.mesh.faces;
    let mut shell_of_face = vec![ShellKind::Open; all.len()];
    if !table.or_default(&SURFACE.solid)? {
        return Ok(shell_of_face);
    }
    let (faces, plates, shells) = materials.opaque_shells();
    if sides.is_none() {
        warn_nearly_closed(&shells, name, reader);
    }
    let turned = match open_sides {
        OpenSides::OfFile => vec![None; shells.shells().len()],
        OpenSides::Both => {
            let bounds = all.iter().map(|f| f.plate.bounds());
            let bounds = bounds.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or_default();
            turned_parts(&plates, &shells, bounds.0, bounds.1)
        }
    };
    for (k, i) in faces.into_iter().enumerate() {
        let is_turned = turned[shells.shell_index(k)].is_some();
        shell_of_face[i] = if is_turned { ShellKind::Open } else { shells.of(k) };
    }
    Ok(shell_of_face)
}

/// The materials of a mesh with their faces and overrides.
struct MaterialUse<'a> {
    mesh: &'a MeshData,
    overrides: &'a BTreeMap<usize, MaterialOverride>,
    /// Indices of the faces of each material.
    faces: Vec<Vec<usize>>,
}

impl<'a> MaterialUse<'a> {
    fn new(mesh: &'a MeshData, overrides: &'a BTreeMap<usize, MaterialOverride>) -> MaterialUse<'a> {
        let mut faces: Vec<Vec<usize>> = vec![Vec::new(); mesh.materials.len()];
        for (i, f) in mesh.faces.iter().enumerate() {
            faces[f.material].push(i);
        }
        MaterialUse { mesh, overrides, faces }
    }
    fn override_of(&self, material: usize) -> MaterialOverride {
        self.overrides.get(&material).cloned().unwrap_or_default()
    }
    fn is_pane(&self, material: usize) -> bool {
        match self.override_of(material).pane {
            Some(pane) => pane.is_some(),
            None => self.mesh.materials[material].is_glass(),
        }
    }
    /// The materials that have faces and are not omitted, and what each becomes.
    fn used(&self) -> impl Iterator<Item = (usize, MaterialKind)> + '_ {
        let is_used = |m: &usize| !self.faces[*m].is_empty() && !self.override_of(*m).omit;
        (0..self.faces.len()).filter(is_used).map(|m| {
            let kind = if self.override_of(m).region {
                MaterialKind::Region
            } else if self.is_pane(m) {
                MaterialKind::Pane
            } else {
                MaterialKind::Opaque
            };
            (m, kind)
        })
    }
    /// Of each material the number of its kind; `None` for one that is not used.
    fn kinds(&self) -> Vec<Option<usize>> {
        let mut out = vec![None; self.faces.len()];
        self.used().for_each(|(m, kind)| out[m] = Some(kind as usize));
        out
    }
    /// The faces of opaque materials, their plates and shells: panes, cut-outs, regions and omitted materials close nothing.
    fn opaque_shells(&self) -> (Vec<usize>, Vec<Plate>, Shells) {
        let is_opaque = |m: usize| {
            let over = self.override_of(m);
            !self.is_pane(m) && !over.omit && !over.region && self.mesh.materials[m].alpha.is_none()
        };
        let opaque: Vec<bool> = (0..self.mesh.materials.len()).map(is_opaque).collect();
        let all = &self.mesh.faces;
        let faces: Vec<usize> = (0..all.len()).filter(|i| opaque[all[*i].material]).collect();
        let plates: Vec<Plate> = faces.iter().map(|i| all[*i].plate).collect();
        let shells = find_shells(&plates);
        (faces, plates, shells)
    }
}

/// Warns about the parts of a mesh that are open at a few edges only: their insides exchange, and a medium inside them takes part.
fn warn_nearly_closed(shells: &Shells, name: &str, reader: &mut SceneReader<'_>) {
    let limits = NEARLY_CLOSED;
    let mut found = [(0, 0); 3];
    let all: f64 = shells.shells().iter().map(|c| c.area).sum();
    for c in shells.shells().iter().filter(|c| c.area >= limits.min_area_fraction * all) {
        let encloses = c.area_vector.length() < limits.max_one_sided_fraction * c.area;
        let few = c.flipped_edges + c.free_edges <= limits.max_open_edges;
        let borders = limits.max_open_edges_per_face * c.plates as f64;
        let turned = c.flipped_edges > 0 && c.free_edges + c.crowded_edges == 0;
        let crowded = c.crowded_edges > 0 && encloses && (few || c.free_edges as f64 <= borders);
        let most = match (c.free_edges, c.flipped_edges) {
            (3, 0) => limits.max_missing_triangle_fraction,
            _ => limits.max_open_area_fraction,
        };
        let holes = few && c.crowded_edges == 0 && c.free_edges > 0 && c.area_vector.length() < most * c.area;
        let edges = c.flipped_edges + c.free_edges + c.crowded_edges;
        for (f, applies) in found.iter_mut().zip([turned, holes, crowded]) {
            *f = (f.0 + usize::from(applies), f.1 + if applies { edges } else { 0 });
        }
    }
    let reasons = ["neighbours of opposite orientation", "no neighbour", "two or more neighbours"];
    for ((parts, edges), reason) in found.into_iter().zip(reasons) {
        if parts > 0 {
            let text = format!(
                "mesh of surface '{name}': {parts} part(s) would be closed but for {edges} edge(s) whose faces have {reason}; they count as open, so that both sides exchange and a medium inside takes part: mend the mesh, or write sides"
            );
            reader.note(Diagnostic::warning("open-mesh", text));
        }
    }
}
