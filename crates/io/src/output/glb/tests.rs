//! Models survive a round trip through the glTF reader.

use super::*;
use crate::files::FileSource;
use crate::input::read_gltf;

fn folder(name: &str) -> std::path::PathBuf {
    let dir = std::env::temp_dir().join(format!("zonal-glb-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&dir).unwrap();
    dir
}

fn model() -> GlbModel {
    let mesh = GlbMesh {
        name: "floor \"a\"\n".into(),
        material: Some(0),
        positions: vec![[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [2.0, 3.0, 1.0], [0.0, 3.0, 1.5]],
        normals: vec![[0.0, 0.0, 1.0]; 4],
        uvs: vec![[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]],
        lightmap_uvs: vec![[0.0, 0.0], [0.5, 0.0], [0.5, 1.0], [0.0, 1.0]],
        colours: vec![[0.25, 0.5, 2.0, 1.0]; 4],
        values: vec![("IRRADIANCE_0".into(), vec![[300.0, 0.0, 1e-9]; 4])],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let picture = crate::output::encode_png(2, 1, &[[0.2, 0.4, 0.6], [1.0, 0.0, 0.5]]).unwrap();
    let glass = GlbGlass { transmission: 1.0, thickness: 0.01, distance: 0.02, colour: [0.5, 0.1, 0.9] };
    GlbModel {
        name: "room".into(),
        meshes: vec![mesh, GlbMesh { name: "empty".into(), ..GlbMesh::default() }],
        materials: vec![
            GlbMaterial { picture: Some(0), unlit: true, ..GlbMaterial::diffuse("stone", [0.5; 3]) },
            GlbMaterial {
                emissive: [3.0, 1.0, 0.0],
                glass: Some(glass),
                ..GlbMaterial::diffuse("glass", [1.0; 3])
            },
        ],
        pictures: vec![picture],
        cameras: vec![GlbCamera {
            name: "door".into(),
            origin: [0.0, -5.0, 1.0],
            target: [0.0, 0.0, 1.0],
            up: [0.0, 0.0, 1.0],
            fov: 60.0,
            aspect: 4.0 / 3.0,
            range: [0.01, 100.0],
        }],
        ..GlbModel::default()
    }
}

#[test]
fn geometry_and_materials_round_trip() {
    let dir = folder("back");
    let path = dir.join("a.glb");
    for (up, axis) in [(UpAxis::Y, [0.0, 0.0, 1.0]), (UpAxis::Z, [0.0, 1.0, 0.0])] {
        write_glb(&path, &GlbModel { up, ..model() }).unwrap();
        let back = read_gltf(FileSource::DISK, &path, "a.glb").unwrap();
        let area: f64 = back.faces.iter().map(|f| f.plate.area()).sum();
        let wanted = 3.0 + 0.5 * (1.5f64 * 1.5 + 1.0 + 36.0).sqrt();
        assert!((area - wanted).abs() < 1e-5, "{area} {wanted}");
        let n = back.faces[0].plate.normal().array();
        assert!((0..3).all(|k| (n[k] - axis[k]).abs() < 1e-6), "{n:?}");
        assert_eq!(back.faces[0].uv[1], [4.0, 0.0]);
        assert_eq!(back.materials.len(), 2);
        assert_eq!(back.materials[0].name, "stone");
    }
    std::fs::remove_dir_all(&dir).unwrap();
}

#[test]
fn invalid_models_are_refused_and_leave_no_file() {
    let dir = folder("refused");
    let path = dir.join("a.glb");
    let refuse = |change: &dyn Fn(&mut GlbModel), says: &str| {
        let mut m = model();
        change(&mut m);
        let e = write_glb(&path, &m).unwrap_err().to_string();
        assert!(e.contains(says), "{e}");
        assert_eq!(std::fs::read_dir(&dir).unwrap().count(), 0);
    };
    refuse(&|m| m.meshes[0].triangles[1][2] = 4, "names vertex 4, but there are 4");
    refuse(&|m| m.meshes[0].positions[0][1] = f32::NAN, "not finite");
    refuse(&|m| m.meshes[0].normals[2] = [0.0, 2.0, 0.0], "length 1");
    refuse(&|m| m.meshes[0].uvs.truncate(3), "3 uvs for 4 positions");
    refuse(&|m| m.meshes[0].lightmap_uvs.truncate(3), "3 lightmap_uvs for 4 positions");
    refuse(&|m| m.meshes[0].uvs.clear(), "give both");
    refuse(&|m| m.meshes[0].material = Some(7), "names material 7");
    refuse(&|m| m.meshes[0].values[0].0 = "a b".into(), "no name for values");
    refuse(&|m| m.materials[0].picture = Some(1), "names picture 1");
    refuse(&|m| m.materials[0].colour[0] = 1.5, "between 0 and 1");
    refuse(&|m| m.pictures[0] = b"GIF".to_vec(), "no PNG");
    refuse(&|m| m.cameras[0].target = m.cameras[0].origin, "not the origin");
    refuse(&|m| m.cameras[0].range = [1.0, 0.5], "range");
    write_glb(&path, &GlbModel::default()).unwrap();
    std::fs::remove_dir_all(&dir).unwrap();
}
