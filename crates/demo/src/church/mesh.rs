//! The church as a GLB: one mesh a material, its pictures embedded.

use super::model::{ChurchModel, MaterialMesh};
use super::scene::{GLASS_THICKNESS, appearance};
use std::f64::consts::PI;
use zonal_io::output::glb;
use zonal_math::parallel;

/// The GLB's contents; z is up in them and turned up in the file.
pub fn glb_model(model: &ChurchModel) -> glb::GlbModel {
    let mut out = glb::GlbModel { name: "church".into(), ..glb::GlbModel::default() };
    // Textures and their compression take most of the time.
    let materials: Vec<_> = model.meshes.keys().copied().collect();
    let looks = parallel::collect_tasks(materials.len(), |k| {
        let look = appearance(materials[k]);
        let picture = look.texture.as_ref().map(|(t, _)| {
            zonal_io::output::encode_png(t.width, t.height, &t.pixels).expect("a picture with pixels")
        });
        (look, picture)
    });
    for (mesh, (look, picture)) in model.meshes.values().zip(looks) {
        let colour =
            if look.transmittance.is_some() { [1.0; 3] } else { look.reflectance.to_rgb().map(|x| x as f32) };
        let side = look.texture.as_ref().map_or(1.0, |t| t.1);
        let mut material = glb::GlbMaterial::diffuse(&look.name, colour);
        material.double_sided = look.double_sided;
        material.emissive = look.emission.to_rgb().map(|e| (e / PI) as f32);
        if let Some(picture) = picture {
            material.picture = Some(out.pictures.len());
            out.pictures.push(picture);
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
