//! Invalid meshes and materials: each refusal names the file, the place and the mend.

use crate::support;

use support::{CUBE, Folder, Quad, check, png};

fn mesh(file: &str) -> String {
    format!("[[surface]]\nname='m'\nmesh={{file='{file}'}}\n")
}

/// Names, texts and errors of OBJ files.
fn invalid_obj_files() -> Vec<(&'static str, String, &'static str)> {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    vec![
        ("zero.obj", format!("{triangle}f 0 1 2\n"), "zero.obj:4: a vertex index is 0; OBJ counts from 1"),
        (
            "far.obj",
            format!("{triangle}f 1 2 9\n"),
            "far.obj:4: vertex index 9 is out of range: 3 are defined",
        ),
        ("back.obj", format!("{triangle}f -4 -2 -1\n"), "back.obj:4: vertex index -4 is out of range"),
        (
            "uv.obj",
            format!("{triangle}f 1/1 2/1 3/1\n"),
            "uv.obj:4: texture coordinate index 1 is out of range: 0 are",
        ),
        (
            "word.obj",
            format!("{triangle}f a b c\n"),
            "word.obj:4: 'a' is not a vertex index; give a whole number",
        ),
        ("nan.obj", "v 0 0 nan\n".into(), "nan.obj:1: 'nan' is not a finite number"),
        ("short.obj", "v 0 0\n".into(), "short.obj:1: this line has 2 of 3 numbers"),
        ("two.obj", format!("{triangle}f 1 2\n"), "two.obj:4: a face needs at least three corners, not 2"),
        ("flat.obj", format!("{triangle}f 1 1 2\n"), "flat.obj: all 1 faces are without area"),
        ("empty.obj", String::new(), "empty.obj: this mesh has no faces"),
        ("points.obj", triangle.into(), "points.obj: this mesh has no faces"),
        ("binary.obj", "v\0".into(), "binary.obj: this is not an OBJ text"),
        (
            "many.obj",
            format!("{triangle}f {}\n", "1 ".repeat(2000)),
            "many.obj:4: this face has more than 1024 corners; triangulate",
        ),
        (
            "mtl.obj",
            format!("mtllib bad.mtl\n{triangle}f 1 2 3\n"),
            "bad.mtl:2: 'blue' is not a colour value",
        ),
        ("cut.obj", format!("mtllib cut.mtl\nusemtl a\n{triangle}f 1 2 3\n"), "bad.png: this PNG is damaged"),
    ]
}

/// Files of other formats, and the command that converts them.
fn files_of_other_formats() -> Vec<(&'static str, String, &'static str)> {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    vec![
        (
            "mesh.xyz",
            triangle.into(),
            "mesh.xyz: this kind of mesh is not read; convert it to .obj, .stl, .ply",
        ),
        (
            "mesh.ifc",
            triangle.into(),
            "mesh.ifc: IFC files are not read; convert this one: IfcConvert in.ifc out.glb",
        ),
        (
            "MESH.STP",
            triangle.into(),
            "MESH.STP: STEP files are not read; convert this one: gmsh in.stp -2 -o out.msh",
        ),
        ("mesh.fbx", triangle.into(), "bpy.ops.import_scene.fbx(filepath='in.fbx')"),
    ]
}

#[test]
fn invalid_obj_files_are_refused() {
    let folder = Folder::new()
        .with("bad.mtl", "newmtl a\nKd blue\n")
        .with("cut.mtl", "newmtl a\nmap_Kd bad.png\n")
        .with("bad.png", &png(1, 1, &[0, 0, 0])[..40]);
    for (name, text, wanted) in invalid_obj_files().into_iter().chain(files_of_other_formats()) {
        folder.put(name, text);
        check(&folder, &[(&mesh(name), &["test.toml:3:", "surface 'm'", wanted])]);
    }
    check(
        &folder,
        &[
            (
                &mesh("none.obj"),
                &["test.toml:3:12: surface 'm'.mesh.file", "none.obj: there is no such file; check the path"],
            ),
            (&mesh("."), &["test.toml:3:12:", "convert it"]),
            (
                "[[surface]]\nmesh={scale=2}",
                &["test.toml:2:6:", "mesh.file: this key is missing; write file"],
            ),
            ("[[surface]]\nmesh={file='zero.obj',scale=0}", &["test.toml:2:29:", "above 0"]),
            ("[[surface]]\nmesh={file='zero.obj',size=1}", &["unknown key; did you mean 'file'?"]),
        ],
    );
}

#[test]
fn invalid_overrides_and_placements_of_meshes_are_refused() {
    let folder = Folder::new();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    folder.put("good.obj", format!("{triangle}usemtl wall\nf 1 2 3\n"));
    folder.put("cube.obj", CUBE);
    let with = |more: &str| mesh("good.obj") + more;
    let (unknown, thin, dark) = (
        with("materials.wal.omit=true"),
        with("materials.wall.pane={extinction=1}"),
        with("materials.wall.pane.thickness=0.1"),
    );
    let (odd, region, far) = (
        with("materials.wall.omitt=true"),
        with("materials.wall.region=true"),
        "[[surface]]\nmesh={file='good.obj',scale=1e300,translate=[1e308,0,0]}",
    );
    let open = "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[1,1,1]\n[[medium.region]]\nmesh={file='good.obj'}\nextinction=1";
    let (small, opaque) = (
        "[medium]\nmin=[0,0,0]\nmax=[9,9,9]\ncells=[1,1,1]\n[[medium.region]]\nmesh={file='cube.obj'}\nextinction=1",
        mesh("cube.obj")
            + "materials.default={region=true}\n[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[1,1,1]\n",
    );
    check(
        &folder,
        &[
            (&unknown, &["test.toml:4:", "the mesh has no material 'wal'; did you mean 'wall'?"]),
            (&thin, &["test.toml:4:", "material 'wall'", "write materials.\"wall\".pane.thickness"]),
            (&dark, &["test.toml:4:", "write materials.\"wall\".pane.extinction"]),
            (&odd, &["did you mean 'omit'?"]),
            (&region, &["test.toml:4:", "material 'wall'", "add a [medium]"]),
            (far, &["test.toml:2:", "beyond all numbers; give a smaller scale"]),
            (open, &["test.toml:6:", "medium.region[0].mesh", "close the mesh"]),
            (small, &["test.toml:5:", "fills no cell", "use smaller cells"]),
            (&opaque, &["material 'default'", "pane.extinction"]),
        ],
    );
}

/// A GLB of a changed quad.
fn change(f: &dyn Fn(&mut Quad)) -> Vec<u8> {
    let mut q = Quad::default();
    f(&mut q);
    q.glb()
}

/// Refuses each file as a mesh of a scene.
fn check_glb_files(files: Vec<(&str, Vec<u8>, &str)>) {
    let folder = Folder::new();
    for (name, bytes, wanted) in files {
        let file = format!("{name}.glb");
        folder.put(&file, bytes);
        check(&folder, &[(&mesh(&file), &["test.toml:3:", "surface 'm'", wanted])]);
    }
}

#[test]
fn damaged_gltf_files_are_refused() {
    let good = Quad::default().glb();
    let mut version = good.clone();
    version[4] = 1;
    check_glb_files(vec![
        ("empty", Vec::new(), "JSON line 1 column 0"),
        ("text", b"{}".to_vec(), "missing field `asset`"),
        ("header", good[..10].to_vec(), ":header: this GLB is cut short; copy"),
        ("cut", good[..good.len() - 9].to_vec(), "this GLB is cut short"),
        ("version", version, ":header: this is glTF version 1; export it as glTF 2.0"),
    ]);
}

#[test]
fn invalid_gltf_accessors_are_refused() {
    let swap = |from: &'static str, to: &'static str| {
        change(&move |q: &mut Quad| {
            q.accessors = q.accessors.replacen(from, to, 1);
        })
    };
    let nan = change(&|q| q.binary[16..20].copy_from_slice(&f32::NAN.to_le_bytes()));
    let index = change(&|q| q.binary[82] = 77);
    check_glb_files(vec![
        ("nan", nan, ":accessor 0, element 1: this value is not a finite number"),
        ("index", index, ":mesh 0 primitive 0 of node 0: index 77 is out of range: there are 4 positions"),
        (
            "count",
            swap("\"count\":4", "\"count\":5"),
            ":accessor 0: this accessor reaches beyond its buffer view",
        ),
        (
            "giant",
            swap("\"count\":4", "\"count\":18446744073709551615"),
            ":accessor 0: this accessor reaches beyond",
        ),
        ("zeros", swap("\"bufferView\":0,", "").to_vec(), ""),
        ("vec2", swap("VEC3", "VEC2"), ":accessor 0: this accessor has another number of components"),
        ("type", swap("5126", "1234"), "accessors[0].componentType"),
        (
            "view",
            change(&|q| q.views = q.views.replacen("48", "4800", 1)),
            ":accessor 0: buffer view 0 reaches beyond its buffer",
        ),
        (
            "noview",
            swap("\"bufferView\":0", "\"bufferView\":99"),
            "accessors[0].bufferView: index out of bounds",
        ),
    ]);
}

#[test]
fn invalid_gltf_nodes_and_primitives_are_refused() {
    check_glb_files(vec![
        ("mesh", change(&|q| q.nodes = r#"{"mesh":7}"#.into()), "nodes[0].mesh: index out of bounds"),
        ("node", change(&|q| q.scene = "[3]".into()), "scenes[0].nodes[0]: index out of bounds"),
        (
            "cycle",
            change(&|q| q.nodes = r#"{"children":[1],"mesh":0},{"children":[0]}"#.into()),
            ":node 0: this node hangs in two places",
        ),
        ("bare", change(&|q| q.primitive = r#"{"attributes":{"NORMAL":0}}"#.into()), "POSITION"),
        (
            "points",
            change(&|q| q.primitive = q.primitive.replacen('{', "{\"mode\":0,", 1)),
            "this file shows no triangles",
        ),
    ]);
}

#[test]
fn unsupported_gltf_contents_are_refused() {
    let files: Vec<(&str, Vec<u8>, &str)> = vec![
        (
            "draco",
            change(&|q| q.more = r#","extensionsRequired":["EXT_texture_webp"]"#.into()),
            "extension EXT_texture_webp, which is not read; convert it: npx @gltf-transform/cli png in.glb",
        ),
        (
            "colour",
            change(&|q| q.material = q.material.replace("0.2", "-0.2")),
            "material 'wall': a colour or strength is negative",
        ),
        (
            "glass",
            change(&|q| {
                q.material = r#"{"name":"glass","alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.5]}}"#.into()
            }),
            "write materials.\"glass\".pane.thickness",
        ),
    ];
    check_glb_files(files);
}

#[test]
fn missing_gltf_buffers_and_images_are_refused() {
    let files: Vec<(&str, Vec<u8>, &str)> = vec![
        (
            "nobuffer",
            change(&|q| q.more = r#","x":0"#.into()).iter().copied().take(20).collect(),
            "cut short",
        ),
        (
            "uri",
            Quad::default()
                .json()
                .replacen("\"byteLength\":88", "\"uri\":\"no.bin\",\"byteLength\":88", 1)
                .into_bytes(),
            ":buffer 0: '",
        ),
        (
            "base64",
            Quad::default()
                .json()
                .replacen("\"byteLength\":88", "\"uri\":\"data:;base64,!!\",\"byteLength\":88", 1)
                .into_bytes(),
            ":buffer 0: this data URI is not base64",
        ),
        (
            "picture",
            change(&|q| {
                q.more = r#","images":[{"bufferView":0}],"textures":[{"source":0}]"#.into();
                q.material = r#"{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}"#.into();
            }),
            "image 0: this is neither a PNG nor a JPEG picture; convert it to PNG",
        ),
        (
            "nopicture",
            change(&|q| {
                q.more = r#","images":[{"uri":"no.png"}],"textures":[{"source":0}]"#.into();
                q.material = r#"{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}"#.into();
            }),
            "no.png: there is no such file",
        ),
    ];
    check_glb_files(files);
}

/// A strip of triangles, each of a material of its own: `m0`, `m1`, …
fn many_materials(count: usize) -> String {
    let part = |k: usize| format!("v {k} 0 0\nv {k} 1 0\nv {k}.5 0 0\nusemtl m{k}\nf -3 -2 -1\n");
    (0..count).map(part).collect()
}

#[test]
fn all_materials_that_lack_values_are_named_at_once() {
    let folder = Folder::new().with("a.obj", many_materials(30)).with("b.obj", many_materials(2));
    let scene = |file: &str, more: &str| format!("mode='thermal'\n{}{more}", mesh(file));
    let all = "these values of materials are missing: the temperature or heat of 'm0', 'm1', 'm2'";
    let names =
        |range: std::ops::Range<usize>| range.map(|k| format!("'m{k}'")).collect::<Vec<_>>().join(", ");
    let rest = format!("{} and 6 more; the emissivity of 'm0', ", names(20..24));
    let without_one =
        format!("emissivity of {} and 5 more; write emissivity in materials.\"m0\"", names(0..24));
    let glass = "materials.m0.pane=true\nmaterials.m1.pane={thickness=0.1}\n";
    let cases: [(String, &[&str]); 5] = [
        (scene("a.obj", ""), &["test.toml:2:1: surface 'm': ", all, &rest, "in materials.\"m0\" and so on"]),
        (scene("a.obj", "temperature=300\nmaterials.m29.emissivity=1\n"), &[&without_one]),
        (
            scene("b.obj", "emissivity=1\nmaterials.m0.temperature=300\n"),
            &["surface 'm/m1'.temperature", "nothing is known"],
        ),
        (scene("b.obj", "temperature=300\n"), &["the emissivity of 'm0', 'm1'; write emissivity"]),
        (
            mesh("b.obj") + glass,
            &[
                "the thickness of the glass of 'm0'; the extinction of the glass of 'm1'; write pane.thickness (m), pane.extinction",
            ],
        ),
    ];
    for (text, wanted) in &cases {
        check(&folder, &[(text, wanted)]);
    }
    folder.put("t.csv", "material,T\nm1,300\n");
    let by_material = scene("a.obj", "emissivity=1\ntemperature={file='t.csv',by='material'}\n");
    let wanted =
        format!("t.csv:2: materials 'm0', {} and 5 more have no row; add one for each", names(2..25));
    check(&folder, &[(&by_material, &[&wanted])]);
    let notes = folder.scene(&mesh("a.obj"));
    let warning = notes.notes().iter().find(|n| n.code == "default-material").map(|n| n.text.as_str());
    assert!(warning.is_some_and(|w| w.contains("'m23' and 6 more")), "{warning:?}");
}
