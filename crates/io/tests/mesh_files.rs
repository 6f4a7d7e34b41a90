//! OBJ, glTF and pictures read right, with numbers.

use crate::support;

use std::f64::consts::PI;
use support::{CUBE, Folder, Quad, png};
use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, PlateKind, Scene, Sides};

fn mesh(file: &str, more: &str) -> String {
    format!("[[surface]]\nname = 'm'\nmesh = {{ file = '{file}' }}\n{more}\n")
}

fn names(s: &Scene) -> Vec<&str> {
    s.surfaces().iter().map(|s| s.name.as_str()).collect()
}

#[test]
fn obj_polygons_materials_and_textures_are_read() {
    let obj = "mtllib a.mtl\nusemtl paint\nv 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0 0.5 0.5 0.5\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
               f 1/1 2/2 3/3 4/4\nusemtl lamp\nv 0 0 1\nv 2 0 1\nv 2 2 1\nv 1 2 1\nv 1 1 1\nv 0 1 1\n\
               f -6 -5 -4 -3 \\\n -2 -1\nf 1//1 2//1 3//1\n";
    let mtl = "newmtl paint\nKd 0.5 0.5 1\nmap_Kd red.png\nnewmtl lamp\n  Kd 0.25 # grey\nKe 1 2 3\n";
    let red = png(2, 1, &[255, 0, 0, 188, 188, 188]);
    let folder = Folder::new().with("a.obj", obj).with("a.mtl", mtl).with("red.png", red);
    let s = folder.scene(&mesh("a.obj", ""));
    assert_eq!(names(&s), ["m/paint", "m/lamp"]);
    // The last face names a normal that the file does not have.
    assert!(s.notes().iter().all(|n| n.code == "normals"), "{:?}", s.notes());
    assert_eq!(s.facets().len(), 1 + 4 + 1);
    assert_eq!(s.facets()[0].plate.kind, PlateKind::Parallelogram);
    assert_eq!(s.facets()[0].uv, [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]]);
    let area: f64 = s.facets()[1..5].iter().map(|f| f.plate.area()).sum();
    assert!((area - 3.0).abs() < 1e-12 && s.facets()[1..5].iter().all(|f| f.plate.normal().z > 0.9));
    // sRGB 188 is 0.5029 in linear light.
    assert_eq!(s.textures()[0].pixels[0], [1.0, 0.0, 0.0]);
    assert!((s.textures()[0].pixels[1][2] - 0.502886).abs() < 1e-5);
    let left = s.reflectance_at(0, 0.25, 0.5);
    assert_eq!(left, Bands::from_rgb([0.5, 0.0, 0.0]));
    let lamp = &s.surfaces()[1];
    assert_eq!((lamp.reflectance, lamp.sides, lamp.solid), (Bands::splat(0.25), Sides::Both, false));
    assert_eq!(lamp.emission, Bands::from_rgb([PI, 2.0 * PI, 3.0 * PI]));
}

#[test]
fn placement_scales_rotates_and_translates() {
    let folder = Folder::new().with("t.obj", "v 1 0 0\nv 2 0 0\nv 1 1 0\nf 1 2 3\n");
    let s = folder
        .scene("[[surface]]\nmesh={file='t.obj', scale=2, translate=[10,0,0], rotate_degrees=[90,0,90]}\n");
    let p = &s.facets()[0].plate;
    // x to y by the turn about z; y to z by the turn about x.
    assert!((p.origin - vec3(10.0, 2.0, 0.0)).length() < 1e-12, "{p:?}");
    assert!((p.e1 - vec3(0.0, 2.0, 0.0)).length() < 1e-12 && (p.e2 - vec3(0.0, 0.0, 2.0)).length() < 1e-12);
    assert_eq!(names(&s), ["surface1"]);
}

#[test]
fn closed_parts_become_solids_and_rooms() {
    let turned: String = CUBE
        .lines()
        .map(|l| match l.strip_prefix("f ") {
            Some(f) => format!("f {}\n", f.split(' ').rev().collect::<Vec<_>>().join(" ")),
            None => format!("{l}\n"),
        })
        .collect();
    let sheet = format!("{CUBE}v 5 5 5\nv 6 5 5\nv 5 6 5\nf 9 10 11\n");
    let folder = Folder::new()
        .with("body.obj", CUBE)
        .with("room.obj", &turned)
        .with("both.obj", &sheet)
        .with("open.obj", CUBE.replace("f 4 3 2 1\n", ""));
    let read = |file: &str, more: &str| folder.scene(&mesh(file, more));
    let body = read("body.obj", "");
    assert_eq!(body.facets().len(), 6);
    assert!(body.surfaces()[0].solid && body.surfaces()[0].sides == Sides::Front);
    let hollow = read("body.obj", "sides = 'both'");
    assert!(!hollow.surfaces()[0].solid);
    let shell = read("body.obj", "solid = false");
    assert!(!shell.surfaces()[0].solid && shell.surfaces()[0].sides == Sides::Both);
    let room = read("room.obj", "");
    assert!(!room.surfaces()[0].solid && room.surfaces()[0].sides == Sides::Front);
    let centre = Vec3::splat(0.5);
    assert!(room.facets().iter().all(|f| (centre - f.plate.centre()).dot(f.plate.normal()) > 0.0));
    let open = read("open.obj", "");
    assert!(!open.surfaces()[0].solid && open.surfaces()[0].sides == Sides::Both);
    let both = read("both.obj", "reflectance = 0.3");
    assert_eq!(names(&both), ["m", "m (solid)"]);
    assert_eq!((both.surfaces()[0].sides, both.surfaces()[0].solid), (Sides::Both, false));
    assert_eq!((both.surfaces()[1].sides, both.surfaces()[1].solid), (Sides::Front, true));
    assert_eq!(both.surfaces()[1].reflectance, Bands::splat(0.3));
}

#[test]
fn overrides_take_precedence_over_the_file() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 4\nusemtl c\nf 1 3 4\n";
    let folder = Folder::new().with("a.obj", obj);
    let s = folder.scene(&mesh(
        "a.obj",
        "reflectance=0.9\nmaterials.a={reflectance=[0.1,0.2,0.3],emission=4,sides='front',patch_size=0.1}\n\
         materials.b.omit=true\nmaterials.c.pane={thickness=0.02,extinction=[1,2,3],albedo=0.5,emission=6}",
    ));
    assert_eq!(names(&s), ["m/a"]);
    let a = &s.surfaces()[0];
    assert_eq!(
        (a.reflectance, a.emission, a.sides),
        (Bands::from_rgb([0.1, 0.2, 0.3]), Bands::splat(4.0), Sides::Front)
    );
    assert_eq!(a.patch_size, Some(0.1));
    let c = &s.panes()[0];
    assert_eq!((c.name.as_str(), c.thickness, c.extinction), ("m/c", 0.02, Bands::from_rgb([1.0, 2.0, 3.0])));
    assert_eq!((c.albedo, c.emission, c.plates.len()), (Bands::splat(0.5), Bands::splat(6.0), 1));
    // No library, but nothing of these materials takes its place.
    assert!(s.notes().is_empty(), "{:?}", s.notes());
}

#[test]
fn faces_without_area_are_dropped_and_counted() {
    let folder =
        Folder::new().with("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\nf 1 1 2\n");
    let s = folder.scene(&mesh("a.obj", ""));
    assert_eq!(s.facets().len(), 1);
    assert!(s.notes()[0].contains("a.obj: 2 faces without area"), "{:?}", s.notes());
}

fn quad(change: impl FnOnce(&mut Quad)) -> (Folder, Quad) {
    let mut q = Quad::default();
    change(&mut q);
    (Folder::new().with("q.glb", q.glb()), q)
}

#[test]
fn gltf_transformations_keep_orientation() {
    let (folder, q) = quad(|q| {
        q.nodes = r#"{"children":[1],"translation":[0,0,5]},{"mesh":0,"scale":[-2,1,1]}"#.into();
    });
    let s = folder.scene(&mesh("q.glb", ""));
    assert_eq!((s.facets().len(), names(&s)), (2, vec!["m"]));
    // Mirrored, yet its front still looks along +z.
    for f in s.facets() {
        assert_eq!(f.plate.normal(), vec3(0.0, 0.0, 1.0));
        assert_eq!(f.plate.origin.z, 5.0);
    }
    assert!((s.bounds().0 - vec3(-2.0, 0.0, 5.0)).length() < 1e-12);
    let wall = &s.surfaces()[0];
    assert!((wall.reflectance.to_rgb()[1] - 0.4).abs() < 1e-7 && wall.sides == Sides::Front);
    // The same as a .gltf with its buffer beside it.
    let text = q.json().replacen("\"byteLength\":88", "\"uri\":\"my%20data.bin\",\"byteLength\":88", 1);
    folder.put("q.gltf", text);
    folder.put("my data.bin", &q.binary);
    assert_eq!(folder.scene(&mesh("q.gltf", "")).facets(), s.facets());
}

#[test]
fn gltf_strips_fans_and_missing_indices_are_read() {
    for (mode, indices, count, area) in
        [(5, r#","indices":2"#, 2, 1.0), (6, r#","indices":2"#, 2, 1.0), (4, "", 1, 0.5)]
    {
        let (folder, _) = quad(|q| {
            q.primitive = format!(r#"{{"attributes":{{"POSITION":0}},"mode":{mode}{indices}}}"#);
            q.accessors = q.accessors.replace("\"count\":6", "\"count\":4");
            let strip = if mode == 5 { [0, 1, 3, 2] } else { [0, 1, 2, 3] };
            q.binary[80..84].copy_from_slice(&strip);
        });
        let s = folder.scene(&mesh("q.glb", ""));
        assert_eq!(s.facets().len(), count, "mode {mode}");
        let sum: f64 = s.facets().iter().map(|f| f.plate.area()).sum();
        assert!((sum - area).abs() < 1e-12);
        assert!(s.facets().iter().all(|f| f.plate.normal().z == 1.0), "mode {mode}");
        // The default material of glTF is white, of which 0.95 is taken, and one-sided.
        let surface = &s.surfaces()[0];
        assert_eq!((surface.reflectance, surface.sides), (Bands::splat(0.95), Sides::Front));
    }
}

#[test]
fn gltf_materials_are_converted() {
    let with = |material: &str, more: &str| {
        let (folder, _) = quad(|q| q.material = material.into());
        folder.scene(&mesh("q.glb", more))
    };
    let lamp = with(
        r#"{"name":"lamp","doubleSided":true,"emissiveFactor":[1,0.5,0],
            "extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":10}}}"#,
        "",
    );
    assert_eq!(lamp.surfaces()[0].emission, Bands::from_rgb([10.0 * PI, 5.0 * PI, 0.0]));
    assert_eq!(lamp.surfaces()[0].sides, Sides::Both);
    let unlit = with(
        r#"{"emissiveFactor":[1,1,1],"pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0.25,1]},"extensions":{"KHR_materials_unlit":{}}}"#,
        "",
    );
    assert_eq!(
        (unlit.surfaces()[0].reflectance, unlit.surfaces()[0].emission),
        (Bands::from_rgb([0.95, 0.5, 0.25]), Bands::ZERO)
    );
    let blend = with(
        r#"{"name":"g","alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0.25,0.75]}}"#,
        "materials.g.pane.thickness = 0.5",
    );
    let p = &blend.panes()[0];
    assert!(
        (p.extinction.to_rgb()[2] - 2.0 * 4f64.ln()).abs() < 1e-12
            && p.albedo == Bands::from_rgb([1.0, 0.5, 0.25])
    );
    assert_eq!((p.plates.len(), blend.facets().len()), (2, 0));
    let opaque = with(
        r#"{"name":"g","alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0.25,0.75]}}"#,
        "materials.g.pane = false",
    );
    assert_eq!(
        (opaque.panes().len(), opaque.surfaces()[0].reflectance),
        (0, Bands::from_rgb([0.95, 0.5, 0.25]))
    );
}

#[test]
fn glass_thickness_scales_with_its_node() {
    let (folder, _) = quad(|q| {
        q.nodes = r#"{"mesh":0,"scale":[3,3,3]},{"mesh":0}"#.into();
        q.scene = "[0,1]".into();
        q.material = r#"{"name":"g","extensions":{"KHR_materials_transmission":{"transmissionFactor":1},
            "KHR_materials_volume":{"thicknessFactor":0.25,"attenuationDistance":2,"attenuationColor":[0.5,1,0]}}}"#
            .into();
    });
    let s = folder.scene("[[surface]]\nname='m'\nmesh={file='q.glb', scale=0.5}\n");
    let panes: Vec<(&str, f64)> = s.panes().iter().map(|p| (p.name.as_str(), p.thickness)).collect();
    assert_eq!(panes[0], ("m", 0.125));
    assert!(panes[1].0 == "m#2" && (panes[1].1 - 0.375).abs() < 1e-12);
    let [red, green, blue] = s.panes()[0].extinction.to_rgb();
    // ln 2 over two units of half a metre; a colour of 0 is a millionth.
    assert!((red - 2f64.ln()).abs() < 1e-12 && green == 0.0, "{red} {green}");
    assert!((blue - 1e6f64.ln()).abs() < 1e-9, "{blue}");
}

#[test]
fn embedded_textures_and_their_transforms_are_read() {
    let picture = png(2, 2, &[255, 255, 255, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    let (folder, _) = quad(|q| {
        let start = q.binary.len();
        q.binary.extend(&picture);
        q.views += &format!(r#",{{"buffer":0,"byteOffset":{start},"byteLength":{}}}"#, picture.len());
        q.more = r#","images":[{"bufferView":3,"mimeType":"image/png"}],"textures":[{"source":0}]"#.into();
        q.primitive = r#"{"attributes":{"POSITION":0,"TEXCOORD_1":1},"indices":2,"material":0}"#.into();
        q.material = r#"{"name":"w","pbrMetallicRoughness":{"metallicFactor":0,"baseColorTexture":{"index":0,"texCoord":1,
            "extensions":{"KHR_texture_transform":{"offset":[0.5,0],"scale":[0.5,1]}}}}}"#
            .into();
    });
    let s = folder.scene(&mesh("q.glb", ""));
    assert_eq!(s.facets()[0].uv, [[0.5, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    assert_eq!(s.textures()[0].pixels[..2], [[0.95; 3], [0.0; 3]]);
    // A reflectance of the scene replaces the picture.
    let flat = folder.scene(&mesh("q.glb", "reflectance = 0.3"));
    assert_eq!(
        (flat.surfaces()[0].reflectance_texture, flat.surfaces()[0].reflectance),
        (None, Bands::splat(0.3))
    );
    let painted = folder.scene(&mesh("q.glb", ""));
    assert!(painted.surfaces()[0].reflectance_texture.is_some());
}

#[test]
fn sparse_accessors_are_read() {
    let (folder, _) = quad(|q| {
        let start = q.binary.len();
        q.binary.extend([2u8, 0, 0, 0]);
        q.binary.extend(support::f32s(&[1.0, 1.0, 7.0]));
        q.views += &format!(
            r#",{{"buffer":0,"byteOffset":{start},"byteLength":4}},{{"buffer":0,"byteOffset":{},"byteLength":12}}"#,
            start + 4
        );
        q.accessors = q.accessors.replacen(
            r#""type":"VEC3""#,
            r#""type":"VEC3","sparse":{"count":1,"indices":{"bufferView":3,"componentType":5121},"values":{"bufferView":4}}"#,
            1,
        );
    });
    let s = folder.scene(&mesh("q.glb", ""));
    assert_eq!(s.bounds().1, vec3(1.0, 1.0, 7.0));
}

#[test]
fn textures_on_walls_are_upright() {
    // White above, black below.
    let picture = png(1, 2, &[255, 255, 255, 0, 0, 0]);
    let folder = Folder::new().with("p.png", picture);
    let s = folder
        .scene("[[surface]]\nname='r'\nroom={min=[0,0,0],max=[1,1,1]}\ntexture='p.png'\nreflectance=0.8\n");
    assert_eq!(s.textures().len(), 1);
    for (i, f) in s.facets().iter().enumerate() {
        if f.plate.normal().z == 0.0 {
            let up = f.plate.parameters(vec3(0.5, 0.5, 0.75));
            let down = f.plate.parameters(vec3(0.5, 0.5, 0.25));
            assert!((s.reflectance_at(i, 0.5, up[1]).first() - 0.8).abs() < 1e-6);
            assert!(s.reflectance_at(i, 0.5, down[1]).first() < 1e-6);
        }
    }
}

#[test]
fn notes_that_differ_in_a_name_are_merged() {
    let mut obj = String::new();
    for k in 0..400 {
        obj += &format!("v {k} 0 0\nv {k} 1 0\nv {k} 0 1\nusemtl m{k}\nf -3 -2 -1\n");
    }
    let folder = Folder::new().with("a.obj", obj);
    let s = folder.scene(&mesh("a.obj", ""));
    let stated: Vec<_> = s.notes().iter().filter(|n| n.code == "default-material").collect();
    assert_eq!(stated.len(), 1, "{:?}", s.notes());
    let note = stated[0];
    assert!(note.contains("'m0' is in no library") && note.contains("'m22', 'm23' and 376 more"), "{note}");
    // What the scene gives is no default.
    let given = folder.scene(&mesh("a.obj", "reflectance = 0.2"));
    assert!(given.notes().is_empty(), "{:?}", given.notes());
}

#[test]
fn nearly_closed_parts_give_a_warning() {
    let mut mesh_text =
        String::from("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n");
    mesh_text += "f 1 2 3 4\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let folder =
        Folder::new().with("turned.obj", mesh_text).with("open.obj", CUBE.replace("f 4 3 2 1\n", ""));
    let s = folder.scene(&mesh("turned.obj", ""));
    assert_eq!(s.notes().len(), 1, "{:?}", s.notes());
    assert!(s.notes()[0].contains("4 edge(s) whose faces have neighbours of opposite orientation"));
    assert!(folder.scene(&mesh("turned.obj", "sides = 'front'")).notes().is_empty());
    // A triangle that is missing is no opening.
    let quads = CUBE.lines().filter(|l| l.starts_with('f')).map(|l| l.split(' ').skip(1).collect::<Vec<_>>());
    let mut faces: Vec<String> = quads
        .flat_map(|q| [format!("f {} {} {}", q[0], q[1], q[2]), format!("f {} {} {}", q[0], q[2], q[3])])
        .collect();
    faces.pop();
    let corners = CUBE.lines().filter(|l| l.starts_with('v')).collect::<Vec<_>>().join("\n");
    let missing = Folder::new().with("missing.obj", format!("{corners}\n{}\n", faces.join("\n")));
    let s = missing.scene(&mesh("missing.obj", ""));
    assert!(
        s.notes().iter().any(|n| n.contains("3 edge(s) whose faces have no neighbour")),
        "{:?}",
        s.notes()
    );
    assert!(missing.scene(&mesh("missing.obj", "sides = 'both'")).notes().is_empty());
    // A box without a lid is meant to be open.
    assert!(folder.scene(&mesh("open.obj", "")).notes().is_empty());
}

#[test]
fn touching_bodies_are_separate_solids() {
    let mut two = CUBE.to_string();
    for line in CUBE.lines() {
        let n: Vec<f64> = line.split(' ').skip(1).map(|x| x.parse().unwrap()).collect();
        two += &match line.starts_with('v') {
            true => format!("v {} {} {}\n", n[0] + 1.0, n[1] + 1.0, n[2]),
            false => format!("f {} {} {} {}\n", n[0] + 8.0, n[1] + 8.0, n[2] + 8.0, n[3] + 8.0),
        };
    }
    let folder = Folder::new().with("two.obj", two);
    let s = folder.scene(&mesh("two.obj", ""));
    assert!(s.surfaces().len() == 1 && s.surfaces()[0].solid, "{:?}", s.surfaces());
}
