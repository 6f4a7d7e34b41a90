//! A mesh file placed in the scene: x ↦ rotate(scale · x) + translate, rotations about x, then y, then z.

use crate::input::mesh::model::{GlassAttenuation, GlassProperties, MeshData, MeshMaterial};
use crate::input::mesh::rotation::rotated_axes;
use crate::input::mesh_files::load::read_mesh_file;
use crate::input::reading::error::{FileFault, InputError};
use crate::input::scene::scene_reader::SceneReader;
use crate::input::toml::key_specs::KeyGroups;
use crate::input::toml::node::{TomlNode, TomlTable};
use crate::input::toml::surface_keys::{PLACED_MESH, SURFACE_MESH};
use std::rc::Rc;
use zonal_math::Vec3;
use zonal_scene::{Bands, Diagnostic, Plate};

/// Smallest area of a face relative to the square of its longer edge.
const MIN_RELATIVE_FACE_AREA: f64 = 1e-14;

struct MeshPlacement {
    scale: f64,
    /// Images of the unit vectors.
    axes: [Vec3; 3],
    translate: Vec3,
}

impl MeshPlacement {
    fn read(t: &TomlTable<'_>) -> Result<MeshPlacement, InputError> {
        let scale = t.or_default(&PLACED_MESH.scale)?;
        Ok(MeshPlacement {
            scale,
            axes: rotated_axes(t.or_default(&PLACED_MESH.rotate_degrees)?, scale),
            translate: t.or_default(&PLACED_MESH.translate)?,
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
    /// Places the faces, normals and lights of a mesh; an error if a face is then without finite coordinates.
    fn place(&self, mesh: &mut MeshData) -> Result<(), &'static str> {
        for face in &mut mesh.faces {
            face.plate = self.plate(&face.plate);
            if !(face.plate.origin.is_finite() && face.plate.area().is_finite()) {
                return Err("the placed mesh lies beyond all numbers; give a smaller scale or translate");
            }
        }
        for normals in &mut mesh.normals {
            let placed = |n: [f32; 3]| self.vector(Vec3::from_array(n.map(f64::from))).normalized();
            *normals = normals.map(|n| placed(n).array().map(|x| x as f32));
        }
        for light in &mut mesh.lights {
            light.position = self.vector(light.position) + self.translate;
            light.direction = self.vector(light.direction);
        }
        Ok(())
    }
}

/// Reads `{ file, scale, translate, rotate_degrees }`, of the keys `keys`: the mesh in scene coordinates, and the factor of lengths.
/// Faces without area are dropped and counted in the notes.
pub(crate) fn load_placed(
    node: &TomlNode<'_>,
    keys: KeyGroups,
    reader: &mut SceneReader<'_>,
) -> Result<(MeshData, f64), InputError> {
    let t = node.table(keys)?;
    let file = t.require(&PLACED_MESH.file)?;
    let (path, _) = file.named_file()?;
    let placement = MeshPlacement::read(&t)?;
    let name = path.display().to_string();
    let refused = |f: FileFault| file.error(f.to_string());
    let is_flat = t.value(&SURFACE_MESH.normals)? == Some(1);
    let read = || -> Result<(MeshData, usize), InputError> {
        let mut mesh = read_mesh_file(reader.context.files, &path, &name).map_err(refused)?;
        if is_flat {
            mesh.faces.iter_mut().for_each(|f| f.normals = None);
            mesh.materials.iter_mut().for_each(|m| m.normal_map = None);
        }
        placement.place(&mut mesh).map_err(|message| node.error(message))?;
        let before = mesh.faces.len();
        mesh.faces.retain(|f| {
            let p = &f.plate;
            p.area() > MIN_RELATIVE_FACE_AREA * p.e1.length2().max(p.e2.length2())
        });
        if mesh.faces.is_empty() {
            let message = format!("all {before} faces are without area; export the mesh again");
            return Err(refused(FileFault::new(&name, "", message)));
        }
        let dropped = before - mesh.faces.len();
        Ok((mesh, dropped))
    };
    let (mut mesh, dropped) = Rc::unwrap_or_clone(file.once(read)?);
    mesh.materials.iter_mut().for_each(|m| to_scene_bands(m, reader));
    if dropped > 0 {
        let text = format!("{name}: {dropped} faces without area were dropped");
        reader.note(Diagnostic::note("faces-dropped", text));
    }
    for note in std::mem::take(&mut mesh.notes) {
        reader.note(Diagnostic::note("mesh", note));
    }
    Ok((mesh, placement.scale))
}

/// Turns the colours of a material into values of the scene's bands. Without wavelengths only grey ones are known; the others are as if the file had
/// none.
fn to_scene_bands(material: &mut MeshMaterial, reader: &SceneReader<'_>) {
    let (bands, block) = (reader.source.bands(), reader.source.block());
    if bands.is_rgb() {
        return;
    }
    let convert = |colour: Bands| bands.from_rgb(block, colour.to_rgb());
    let unknown = "its colour is unknown in bands without wavelengths, and left out; give the bands wavelengths, or the material a value for each band";
    if let Some(colour) = material.reflectance {
        material.reflectance = convert(colour);
        if material.reflectance.is_none() {
            material.missing_warning = Some(unknown.into());
        }
    }
    match convert(material.emission) {
        Some(emission) => material.emission = emission,
        None => (material.emission, material.missing_warning) = (Bands::ZERO, Some(unknown.into())),
    }
    material.transmittance = material.transmittance.take().and_then(|(t, image)| Some((convert(t)?, image)));
    let converted = material.glass.map(|glass| {
        let attenuation = match glass.attenuation {
            GlassAttenuation::Coefficient(k) => convert(k).map(GlassAttenuation::Coefficient),
            GlassAttenuation::Transmittance(t) => convert(t).map(GlassAttenuation::Transmittance),
        };
        Some(GlassProperties { attenuation: attenuation?, albedo: convert(glass.albedo)?, ..glass })
    });
    if let Some(glass) = converted {
        material.glass = glass;
        if glass.is_none() {
            material.opaque_warning = Some(unknown.into());
        }
    }
}
