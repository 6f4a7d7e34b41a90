//! The church as a GLB: one mesh a material, its pictures embedded.

use super::model::{ChurchModel, MaterialMesh};
use super::scene::{GLASS_THICKNESS, appearance};
use std::f64::consts::PI;
use zonal_io::output::glb;

/// The GLB's contents; z is up in them and turned up in the file.
pub fn glb_model(model: &ChurchModel) -> glb::GlbModel {
    let mut out = glb::GlbModel { name: "church".into(), ..glb::GlbModel::default() };
    for (stuff, mesh) in &model.meshes {
        let look = appearance(*stuff);
        let colour =
            if look.transmittance.is_some() { [1.0; 3] } else { look.reflectance.to_rgb().map(|x| x as f32) };
        let side = look.texture.as_ref().map_or(1.0, |t| t.1);
        let mut material = glb::GlbMaterial::diffuse(&look.name, colour);
        material.double_sided = look.double_sided;
        material.emissive = look.emission.to_rgb().map(|e| (e / PI) as f32);
        if let Some((texture, _)) = &look.texture {
            material.picture = Some(out.pictures.len());
            out.pictures.push(
                zonal_io::output::encode_png(texture.width, texture.height, &texture.pixels)
                    .expect("a picture with pixels"),
            );
        }
        material.glass = look.transmittance.map(|transmittance| glb::GlbGlass {
            transmission: 1.0,
            thickness: GLASS_THICKNESS as f32,
            distance: GLASS_THICKNESS as f32,
            colour: transmittance.to_rgb().map(|x| x as f32),
        });
        out.meshes.push(part(look.name, out.materials.len(), mesh, side));
        out.materials.push(material);
    }
    out
}

fn part(name: String, material: usize, mesh: &MaterialMesh, side: f64) -> glb::GlbMesh {
    glb::GlbMesh {
        name,
        material: Some(material),
        positions: mesh.positions.iter().map(|p| p.array().map(|x| x as f32)).collect(),
        uvs: mesh.uv.iter().map(|t| t.map(|x| (x / side) as f32)).collect(),
        triangles: mesh.triangles.clone(),
        ..glb::GlbMesh::default()
    }
}
