//! The church as a GLB: one mesh a material, its pictures embedded.

use super::model::{Mesh, Model};
use super::scene::{GLASS, look};
use std::f64::consts::PI;
use zonal_io::output::glb;

/// The GLB's contents; z is up in them and turned up in the file.
pub fn glb_model(model: &Model) -> glb::Model {
    let mut out = glb::Model { name: "church".into(), ..glb::Model::default() };
    for (stuff, mesh) in &model.meshes {
        let look = look(*stuff);
        let colour = if look.passes.is_some() { [1.0; 3] } else { look.reflectance.map(|x| x as f32) };
        let side = look.texture.as_ref().map_or(1.0, |t| t.1);
        let mut material = glb::Material::diffuse(&look.name, colour);
        material.double_sided = look.both;
        material.emissive = look.emission.map(|e| (e / PI) as f32);
        if let Some((texture, _)) = &look.texture {
            material.picture = Some(out.pictures.len());
            out.pictures.push(
                zonal_io::output::encode_png(texture.width, texture.height, &texture.pixels)
                    .expect("a picture with pixels"),
            );
        }
        material.glass = look.passes.map(|passes| glb::Glass {
            transmission: 1.0,
            thickness: GLASS as f32,
            distance: GLASS as f32,
            colour: passes.map(|x| x as f32),
        });
        out.meshes.push(part(look.name, out.materials.len(), mesh, side));
        out.materials.push(material);
    }
    out
}

fn part(name: String, material: usize, mesh: &Mesh, side: f64) -> glb::Mesh {
    glb::Mesh {
        name,
        material: Some(material),
        positions: mesh.positions.iter().map(|p| p.array().map(|x| x as f32)).collect(),
        uvs: mesh.uv.iter().map(|t| t.map(|x| (x / side) as f32)).collect(),
        triangles: mesh.triangles.clone(),
        ..glb::Mesh::default()
    }
}
