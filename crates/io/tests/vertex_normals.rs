//! Vertex normals and normal maps of mesh files, for the shading of pictures.

use crate::support;

use support::{Folder, f32s, glb, png};
use zonal_math::{Vec3, vec3};
use zonal_scene::Scene;

/// A triangle in the plane z = 0 and the normals at its corners.
const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
const NORMALS: [[f32; 3]; 3] = [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, 0.6, 0.8]];

fn obj(normals: &[[f32; 3]]) -> String {
    let lines = |word: &str, list: &[[f32; 3]]| {
        list.iter().map(|[x, y, z]| format!("{word} {x} {y} {z}\n")).collect::<String>()
    };
    format!("{}{}f 1//1 2//2 3//3\n", lines("v", &CORNERS), lines("vn", normals))
}

fn ply() -> String {
    let rows = CORNERS.iter().zip(NORMALS).map(|([x, y, z], [a, b, c])| format!("{x} {y} {z} {a} {b} {c}\n"));
    format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         property float nx\nproperty float ny\nproperty float nz\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n{}3 0 1 2\n",
        rows.collect::<String>()
    )
}

/// A file of the triangle with a normal map, its node scaled along x and mirrored along y.
fn gltf(node: &str, texture: &str) -> Vec<u8> {
    let uvs = [[0.0f32, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let picture = png(1, 1, &[204, 128, 230]);
    let mut binary = f32s(CORNERS.as_flattened());
    binary.extend(f32s(NORMALS.as_flattened()));
    binary.extend(f32s(uvs.as_flattened()));
    binary.extend(&picture);
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0{node}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2}},"material":0}}]}}],
        "materials":[{{"name":"m","normalTexture":{texture}}}],"textures":[{{"source":0}}],"images":[{{"bufferView":3,"mimeType":"image/png"}}],
        "buffers":[{{"byteLength":{}}}],
        "bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":36}},
            {{"buffer":0,"byteOffset":72,"byteLength":24}},{{"buffer":0,"byteOffset":96,"byteLength":{}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
            {{"bufferView":1,"componentType":5126,"count":3,"type":"VEC3"}},{{"bufferView":2,"componentType":5126,"count":3,"type":"VEC2"}}]}}"#,
        binary.len(),
        picture.len()
    );
    glb(&json, &binary)
}

fn folder() -> Folder {
    let nan = obj(&NORMALS).replace("vn 0.6 0 0.8", "vn nan nan nan");
    Folder::new()
        .with("a.obj", obj(&NORMALS))
        .with("nan.obj", nan)
        .with("flat.obj", obj(&[[0.0, 0.0, 1.0]; 3]))
        .with("wrong.obj", obj(&[[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
        .with("a.ply", ply())
        .with("a.glb", gltf("", r#"{"index":0,"scale":0.5}"#))
        .with("scaled.glb", gltf(r#","scale":[2,-1,1]"#, r#"{"index":0}"#))
        .with("dangling.glb", gltf("", r#"{"index":7}"#))
}

fn scene(folder: &Folder, file: &str, more: &str) -> Scene {
    folder.scene(&format!("[[surface]]\nname = 'm'\nreflectance = 0.5\nmesh = {{ file = '{file}'{more} }}\n"))
}

fn normals(s: &Scene) -> Vec<Vec3> {
    s.shading().of_facet(0).map(|n| n[..3].to_vec()).unwrap_or_default()
}

#[test]
fn normals_of_vertices_are_read_from_every_format_that_has_them() {
    let folder = folder();
    for file in ["a.obj", "a.ply", "a.glb"] {
        let s = scene(&folder, file, "");
        let read = normals(&s);
        assert_eq!(read.len(), 3, "{file}");
        for (n, wanted) in read.iter().zip(NORMALS) {
            assert!((*n - Vec3::from_array(wanted.map(f64::from))).length() < 1e-6, "{file}: {n:?}");
        }
        // Turned about x by 90 degrees: z to −y.
        let turned = scene(&folder, file, ", rotate_degrees = [90, 0, 0], scale = 3");
        assert!((normals(&turned)[0] - vec3(0.0, -1.0, 0.0)).length() < 1e-6, "{file}");
        assert!(scene(&folder, file, ", normals = 'flat'").shading().is_empty());
    }
}

#[test]
fn flat_and_wrong_normals_leave_faces_flat() {
    let folder = folder();
    assert!(scene(&folder, "flat.obj", "").shading().is_empty());
    for file in ["wrong.obj", "nan.obj"] {
        let s = scene(&folder, file, "");
        let told =
            s.notes().iter().any(|n| n.to_string().contains("1 vertex normals are more than 80° from"));
        assert!(told, "{file}: {:?}", s.notes());
    }
}

#[test]
fn normals_of_scaled_and_mirrored_nodes_stay_normal() {
    let s = scene(&folder(), "scaled.glb", "");
    let plate = s.facets()[0].plate;
    // The mirrored triangle keeps its front, and the second corner is now the third.
    assert!(plate.normal().z > 0.99, "{plate:?}");
    let wanted = [vec3(0.0, 0.0, 1.0), vec3(0.0, -0.6, 0.8), vec3(0.3, 0.0, 0.8)];
    for (n, wanted) in normals(&s).iter().zip(wanted) {
        assert!((*n - wanted.normalized()).length() < 1e-6, "{n:?} {wanted:?}");
    }
}

#[test]
fn normal_maps_are_read_as_numbers_with_their_scale() {
    let folder = folder();
    let s = scene(&folder, "a.glb", "");
    let map = s.shading().map_of(0).unwrap();
    assert_eq!(map.scale, 0.5);
    let value = s.textures()[map.texture].pixels[0];
    assert!((value[0] - 0.8).abs() < 1e-6, "not decoded as a colour: {value:?}");
    assert!(scene(&folder, "a.glb", ", normals = 'flat'").textures().is_empty());
    // A map without a picture was never needed to read the file.
    let s = scene(&folder, "dangling.glb", "");
    assert!(s.shading().maps.is_empty());
    assert!(s.notes().iter().any(|n| n.to_string().contains("normal map")), "{:?}", s.notes());
}
