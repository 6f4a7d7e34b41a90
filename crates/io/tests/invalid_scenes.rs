//! Wrong inputs: each refusal names the file, the place and the mend.

mod support;

use support::{CUBE, Folder, NpyOrder, Quad, f32s, npy, png};

/// A scene text and what its refusal must contain.
type RefusedScene<'a> = (&'a str, &'a [&'a str]);

const SQUARE: &str = "rectangle={origin=[0,0,0],edge1=[1,0,0],edge2=[0,1,0]}";

fn check(folder: &Folder, cases: &[RefusedScene<'_>]) {
    for (text, wanted) in cases {
        let text = text.replace("SQUARE", SQUARE);
        let message = folder.refusal(&text);
        for w in *wanted {
            assert!(message.contains(w), "'{w}' is not in:\n{message}\nfor\n{text}");
        }
        assert!(message.contains([';', '?']), "no mend in:\n{message}");
        assert!(!message.contains('\n'), "several lines:\n{message}");
    }
}

#[test]
fn syntax_and_types_are_checked() {
    check(
        &Folder::new(),
        &[
            ("", &["test.toml:1:1:", "empty", "add a [[surface]]"]),
            ("name = 'x'\n", &["test.toml:1:1:", "empty"]),
            ("name = \"x", &["test.toml:1:", "not TOML"]),
            ("[solve]\ntolerance = = 1", &["test.toml:2:", "not TOML", "mend the syntax"]),
            ("[solve\n", &["test.toml:1:", "not TOML"]),
            ("a = [1, 2\nb = 3", &["test.toml:", "not TOML"]),
            ("name = 'a'\nname = 'b'", &["test.toml:2:1:", "duplicate key"]),
            ("name = 3", &["test.toml:1:8:", "name: this is a number; give a text"]),
            ("name = ''", &["test.toml:1:8:", "empty"]),
            ("nmae = 'x'", &["test.toml:1:1: nmae: unknown key; did you mean 'name'?"]),
            ("[wibble]\nx=1", &["test.toml:1:2:", "unknown key; known here: name, mode, thermal, solve"]),
            ("[surface]\nSQUARE", &["test.toml:1:", "write [[surface]]"]),
            ("surface = [1]", &["test.toml:1:12:", "surface[0]", "this is a number; give a table"]),
            ("[[medium]]\nmin=[0,0,0]", &["test.toml:1:", "medium", "this is a list; give a table"]),
            (
                "[solve]\ntolerance = 'fine'",
                &["test.toml:2:13: solve.tolerance: this is a text; give a number"],
            ),
            ("[solve]\ntolerance = 1.5", &["test.toml:2:13: solve.tolerance", "above 0 and below 1"]),
            ("[solve]\ntolerance = nan", &["test.toml:2:13:", "not finite"]),
            ("[solve]\nresidual = 0", &["test.toml:2:12: solve.residual"]),
            (
                "[solve]\npatch_size = -1",
                &["test.toml:2:14: solve.patch_size: -1 is out of range; give a number above 0"],
            ),
            (
                "[solve]\nclosure = 'mesure'",
                &["test.toml:2:11: solve.closure: 'mesure' is not known; did you mean 'measure'?"],
            ),
            ("[solve]\nmax_iterations = 2.5", &["test.toml:2:18:", "give a whole number"]),
            ("[solve]\nscattering_orders = 0", &["test.toml:2:21:", "whole number from 1"]),
            ("[solve]\nengine = 'dens'", &["solve.engine: 'dens' is not known; did you mean 'dense'?"]),
            ("[solve]\nlight_groups = 'every'", &["solve.light_groups", "each"]),
            ("[solve]\nmax_iterations = 0", &["test.toml:2:18:", "whole number from 1"]),
            ("[solve]\nmax_iteration = 5", &["test.toml:2:1:", "did you mean 'max_iterations'?"]),
        ],
    );
}

/// Invalid surfaces and panes; SQUARE stands for a rectangle.
const INVALID_SURFACES: &[RefusedScene<'static>] = &[
    ("[[surface]]\nname='a'", &["test.toml:1:1: surface 'a'", "no shape; write one of rectangle"]),
    (
        "[[surface]]\nSQUARE\nbox={min=[0,0,0],max=[1,1,1]}",
        &["surface 'surface1'", "2 shapes (rectangle, box); keep one"],
    ),
    (
        "[[surface]]\nrectangle={origin=[0,0,0],edge1=[1,0,0]}",
        &["test.toml:2:11: surface 'surface1'.rectangle.edge2: this key is missing; write edge2"],
    ),
    (
        "[[surface]]\nrectangle={origin=[0,0],edge1=[1,0,0],edge2=[0,1,0]}",
        &["test.toml:2:19:", "this list has 2 values; give [x, y, z]"],
    ),
    (
        "[[surface]]\nrectangle={origin=[0,0,0],edge1=[1,0,0],edge2=[2,0,0]}",
        &["test.toml:2:11:", "no area; move its corners"],
    ),
    (
        "[[surface]]\nrectangle={origin=[0,0,0],edge1=[1,0,inf],edge2=[2,0,0]}",
        &["test.toml:2:38:", "edge1[2]", "not finite"],
    ),
    ("[[surface]]\nrectangle={orign=[0,0,0]}", &["orign: unknown key; did you mean 'origin'?"]),
    ("[[surface]]\ntriangle={corners=[[0,0,0],[1,0,0]]}", &["three corners, not 2"]),
    (
        "[[surface]]\nbox={min=[0,0,0],max=[1,0,1]}",
        &["test.toml:2:22: surface 'surface1'.box.max: max is not above min along y"],
    ),
    (
        "[[surface]]\nSQUARE\nreflectance=1.2",
        &["test.toml:3:13: surface 'surface1'.reflectance: 1.2 is out of range; give a value from 0 to 1"],
    ),
    (
        "[[surface]]\nSQUARE\nreflectance=[0.1,0.2]",
        &["test.toml:3:13:", "give a number or [red, green, blue]"],
    ),
    (
        "[[surface]]\nSQUARE\nreflectance=[0.1,-0.2,0]",
        &["test.toml:3:18:", "reflectance[1]", "-0.2 is out of range"],
    ),
    ("[[surface]]\nSQUARE\nreflectanse=0.1", &["test.toml:3:1:", "did you mean 'reflectance'?"]),
    ("[[surface]]\nSQUARE\nemission=-1", &["test.toml:3:10:", "negative; give 0 or more"]),
    ("[[surface]]\nSQUARE\nsides='bth'", &["test.toml:3:7:", "did you mean 'both'?"]),
    ("[[surface]]\nSQUARE\nomit=['x0']", &["test.toml:3:6:", "this key is for a room; remove it"]),
    ("[[surface]]\nSQUARE\nmaterials.a.omit=true", &["test.toml:3:", "this key is for a mesh"]),
    (
        "[[surface]]\nroom={min=[0,0,0],max=[1,1,1]}\nomit=['z2']",
        &["test.toml:3:7:", "'z2' is not known; did you mean"],
    ),
    ("[[surface]]\nroom={min=[0,0,0],max=[1,1,1]}\nomit=['x0','x1','y0','y1','z0','z1']", &["all six walls"]),
    (
        "[[surface]]\nroom={min=[0,0,0],max=[1,1,1]}\nfaces.q={emission=1}",
        &["test.toml:3:7:", "known here: x0, x1"],
    ),
    (
        "[[surface]]\nroom={min=[0,0,0],max=[1,1,1]}\nomit=['x0']\nfaces.x0={emission=1}",
        &["test.toml:4:", "left out"],
    ),
    (
        "[[surface]]\nname='a'\nSQUARE\n[[surface]]\nname='a'\nSQUARE",
        &["test.toml:5:6: surface 'a'.name: two surfaces have this name; rename one"],
    ),
    (
        "[[surface]]\nname='a.x0'\nSQUARE\n[[surface]]\nname='a'\nroom={min=[0,0,0],max=[1,1,1]}",
        &["test.toml:", "surface 'a.x0'.name", "rename one"],
    ),
    (
        "[[pane]]\nname='w'\npolygon=[[0,0,0],[1,0,0],[1,1,0]]\nextinction=1",
        &["test.toml:1:1: pane 'w'.thickness: this key is missing; write thickness = 0.01"],
    ),
    (
        "[[pane]]\npolygon=[[0,0,0],[1,0,0],[1,1,0]]\nthickness=0.1",
        &["extinction: this key is missing; write extinction"],
    ),
    (
        "[[pane]]\npolygon=[[0,0,0],[1,0,0],[1,1,0]]\nthickness=0\nextinction=1",
        &["test.toml:3:11:", "above 0"],
    ),
    (
        "[[pane]]\npolygon=[[0,0,0],[1,0,0]]\nthickness=1\nextinction=1",
        &["test.toml:2:9:", "three corners, not 2"],
    ),
    (
        "[[pane]]\npolygon=[[0,0,0],[1,0,0],[1,1,0.5],[0,1,0]]\nthickness=1\nextinction=1",
        &["test.toml:2:9:", "off the plane"],
    ),
    (
        "[[pane]]\npolygon=[[0,0,0],[2,0,0],[0.5,0.5,0],[0,2,0]]\nthickness=1\nextinction=1",
        &["not convex at corner 3; split it"],
    ),
    ("[[pane]]\npolygon=[[0,0,0],[1,0,0],[2,0,0]]\nthickness=1\nextinction=1", &["no area"]),
];

#[test]
fn invalid_surfaces_and_panes_are_refused() {
    check(&Folder::new(), INVALID_SURFACES);
}

#[test]
fn invalid_media_lights_and_cameras_are_refused() {
    let medium = |rest: &str| format!("[medium]\nmin=[0,0,0]\nmax=[1,1,1]\n{rest}");
    let (none, both) = (medium("extinction=1"), medium("cells=[1,1,1]\ncell_size=1"));
    let (huge, tiny) =
        (medium("cells=[10000,10000,10000]\nextinction=1"), medium("cell_size=1e-9\nextinction=1"));
    let (empty, zero) = (medium("cells=[2,2,2]"), medium("cells=[2,0,2]\nextinction=1"));
    let outside = medium("cells=[2,2,2]\n[[medium.region]]\nbox={min=[5,5,5],max=[6,6,6]}\nextinction=1");
    let shapeless = medium("cells=[2,2,2]\n[[medium.region]]\nextinction=1");
    let source = medium("cells=[2,2,2]\nextinction=0\nsource=1");
    let sun = |rest: &str| format!("[[surface]]\nname='a'\nSQUARE\n[[light]]\n{rest}");
    let direction = sun("kind='sun'\nirradiance=1\ndirection=[0,0,0]");
    let (no_kind, odd_kind) = (sun("radiance=1"), sun("kind='sunn'\nradiance=1"));
    let (wide, other) = (
        sun("kind='sun'\ndirection=[0,0,1]\nirradiance=1\nangular_diameter=400"),
        sun("kind='sky'\nradiance=1\ndirection=[0,0,1]"),
    );
    let (dark, lost) = (sun("kind='emitter'\nsurface='a'"), sun("kind='emitter'\nsurface='A1'"));
    let part =
        "[[surface]]\nname='hall'\nroom={min=[0,0,0],max=[1,1,1]}\n[[light]]\nkind='emitter'\nsurface='hall'";
    let camera = |rest: &str| format!("[[surface]]\nSQUARE\n[[camera]]\nname='c'\norigin=[0,0,0]\n{rest}");
    let (aim, up) = (camera("target=[0,0,0]"), camera("target=[0,0,1]"));
    let (lens, focus) = (camera("target=[1,0,0]\naperture=-1"), camera("target=[1,0,0]\nfocus=0"));
    let (fov, two) = (
        camera("target=[1,0,0]\nfov=180"),
        camera("target=[1,0,0]\n[[camera]]\nname='c'\norigin=[0,0,0]\ntarget=[1,0,0]"),
    );
    check(
        &Folder::new(),
        &[
            (&none, &["test.toml:1:1: medium: neither cells nor cell_size", "write cells"]),
            (&both, &["test.toml:5:11: medium.cell_size", "keep one"]),
            (&huge, &["test.toml:4:7: medium.cells", "1000", "use fewer"]),
            (&tiny, &["test.toml:4:11: medium.cells", "use fewer"]),
            (&empty, &["test.toml:1:1: medium: nothing fills the medium; write extinction"]),
            (&zero, &["test.toml:4:10: medium.cells[1]: 0 is out of range; give a whole number from 1"]),
            (&outside, &["test.toml:5:", "medium.region[0]", "move it inside"]),
            (&shapeless, &["test.toml:5:", "write one of box, mesh, density"]),
            (&source, &["test.toml:6:8: medium.source", "needs a medium"]),
            (
                "[medium]\nmin=[0,0,0]\nmax=[1,1,-1]\ncells=[1,1,1]",
                &["test.toml:3:5: medium.max: max is not above min along z"],
            ),
            (
                "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[1,1,1]\nalbedo=2",
                &["test.toml:5:8: medium.albedo", "from 0 to 1"],
            ),
            (&direction, &["test.toml:7:11: light 'light1'.direction: this direction has no length"]),
            (&no_kind, &["kind: this key is missing; write kind"]),
            (&odd_kind, &["test.toml:5:6:", "did you mean 'sun'?"]),
            (&wide, &["test.toml:8:18:", "degrees"]),
            (&other, &["test.toml:7:1:", "direction: unknown key"]),
            (&dark, &["test.toml:6:9:", "does not emit; give it an emission"]),
            (&lost, &["test.toml:6:9:", "no surface has the name 'A1'; did you mean 'a'?"]),
            (part, &["test.toml:6:9:", "name one of its parts: hall.x0"]),
            ("[[surface]]\nSQUARE\n[surroundings]\nradiance=-1", &["test.toml:4:10: surroundings.radiance"]),
            (&aim, &["test.toml:6:8: camera 'c'.target", "apart"]),
            (&up, &["test.toml:3:1: camera 'c'.up", "line of sight"]),
            (&fov, &["test.toml:7:5: camera 'c'.fov", "below 180"]),
            (&lens, &["camera 'c'.aperture", "diameter in metres, from 0"]),
            (&focus, &["camera 'c'.focus", "above 0"]),
            (&two, &["test.toml:8:6: camera 'c'.name: two cameras have this name; rename one"]),
        ],
    );
}

fn mesh(file: &str) -> String {
    format!("[[surface]]\nname='m'\nmesh={{file='{file}'}}\n")
}

#[test]
fn invalid_obj_files_are_refused() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let files = [
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
        ("mesh.stl", triangle.into(), "mesh.stl: this kind of mesh is not read; convert it to .obj"),
    ];
    let folder = Folder::new()
        .with("bad.mtl", "newmtl a\nKd blue\n")
        .with("cut.mtl", "newmtl a\nmap_Kd bad.png\n")
        .with("bad.png", &png(1, 1, &[0, 0, 0])[..40]);
    for (name, text, wanted) in &files {
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

/// Refuses each file, as a mesh of a scene and as a source of volume materials.
fn check_glb_files(files: Vec<(&str, Vec<u8>, &str)>) {
    let folder = Folder::new();
    for (name, bytes, wanted) in files {
        let file = format!("{name}.glb");
        folder.put(&file, bytes);
        check(&folder, &[(&mesh(&file), &["test.toml:3:", "surface 'm'", wanted])]);
        let direct = zonal_io::input::volume_materials(&folder.path().join(&file));
        if let Err(e) = direct {
            assert!(e.to_string().contains(&file), "{e}");
        }
    }
}

#[test]
fn invalid_gltf_files_are_refused() {
    let good = Quad::default().glb();
    let mut version = good.clone();
    version[4] = 1;
    let swap = |from: &'static str, to: &'static str| {
        change(&move |q: &mut Quad| {
            q.accessors = q.accessors.replacen(from, to, 1);
        })
    };
    let nan = change(&|q| q.binary[16..20].copy_from_slice(&f32::NAN.to_le_bytes()));
    let index = change(&|q| q.binary[82] = 77);
    let files: Vec<(&str, Vec<u8>, &str)> = vec![
        ("empty", Vec::new(), "JSON line 1 column 0"),
        ("text", b"{}".to_vec(), "missing field `asset`"),
        ("header", good[..10].to_vec(), ":header: this GLB is cut short; copy"),
        ("cut", good[..good.len() - 9].to_vec(), "this GLB is cut short"),
        ("version", version, ":header: this is glTF version 1; export it as glTF 2.0"),
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
    ];
    check_glb_files(files);
}

#[test]
fn unsupported_gltf_contents_are_refused() {
    let files: Vec<(&str, Vec<u8>, &str)> = vec![
        (
            "draco",
            change(&|q| q.more = r#","extensionsRequired":["KHR_draco_mesh_compression"]"#.into()),
            "extension KHR_draco_mesh_compression, which is not read; export it without",
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

#[test]
fn invalid_arrays_are_refused() {
    let region = |file: &str| {
        format!(
            "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[1,1,1]\n[[medium.region]]\ndensity={{file='{file}',min=[0,0,0],max=[1,1,1]}}\n"
        )
    };
    let data = f32s(&[1.0, 2.0, f32::NAN, 4.0]);
    let good = npy("<f4", NpyOrder::C, "(1, 2, 2)", &f32s(&[1.0, 2.0, 3.0, 4.0]));
    let mut version = good.clone();
    version[6] = 9;
    let arrays = [
        ("empty", Vec::new(), "not an npy array; save it with numpy.save"),
        ("magic", b"hello".to_vec(), "not an npy array"),
        ("cut", good[..50].to_vec(), "cut short"),
        (
            "data",
            good[..good.len() - 1].to_vec(),
            "the shape (1, 2, 2) does not agree with the 15 bytes of data",
        ),
        ("version", version, "this npy version is not read"),
        ("huge", npy("<f8", NpyOrder::C, "(10000, 10000, 10000)", &data), "does not agree with the 16 bytes"),
        (
            "overflow",
            npy("<f8", NpyOrder::C, "(9999999999, 9999999999, 9999999999)", &data),
            "does not agree",
        ),
        (
            "axes",
            npy("<f4", NpyOrder::C, "(4,)", &data),
            "the array has 1 axes; give one of shape [nx, ny, nz]",
        ),
        ("none", npy("<f4", NpyOrder::C, "(0, 2, 2)", &[]), "has no elements"),
        ("minus", npy("<f4", NpyOrder::C, "(-1, 2, 2)", &data), "the shape cannot be read"),
        (
            "complex",
            npy("<c8", NpyOrder::C, "(1, 1, 2)", &data),
            "elements of type '<c8' are not read; convert with array.astype",
        ),
        (
            "nan",
            npy("<f4", NpyOrder::C, "(1, 2, 2)", &data),
            "nan.npy:[0, 1, 0]: NaN is no density; give finite values from 0",
        ),
        ("negative", npy("|i1", NpyOrder::C, "(1, 1, 2)", &[1, 255]), "[0, 0, 1]: -1 is no density"),
    ];
    let folder = Folder::new();
    for (name, bytes, wanted) in arrays {
        let file = format!("{name}.npy");
        folder.put(&file, bytes);
        check(
            &folder,
            &[(&region(&file), &["test.toml:6:15: medium.region[0].density.file", &file, wanted])],
        );
    }
    folder.put("good.npy", &good);
    let double = region("good.npy") + "extinction = 1";
    check(
        &folder,
        &[
            (&region("no.npy"), &["no.npy: there is no such file"]),
            (&double, &["test.toml:7:14:", "set density.scale"]),
        ],
    );
}

#[test]
fn invalid_images_are_refused() {
    let folder = Folder::new();
    let mut bomb = png(1, 1, &[0, 0, 0]);
    bomb[16..24].copy_from_slice(&[0, 1, 0, 0, 0, 1, 0, 0]);
    let images = [
        ("empty.png", Vec::new(), "this picture is empty"),
        ("text.png", b"hello".to_vec(), "neither a PNG nor a JPEG picture; convert it to PNG"),
        ("cut.png", png(9, 9, &[9; 243])[..60].to_vec(), "this PNG is damaged"),
        ("bomb.png", bomb, "bomb.png"),
        ("cut.jpg", vec![0xff, 0xd8, 0xff, 0xe0, 0, 16], "this JPEG is damaged"),
    ];
    for (file, bytes, wanted) in images {
        folder.put(file, bytes);
        let text = format!("[[surface]]\nSQUARE\ntexture='{file}'");
        check(&folder, &[(&text, &["test.toml:3:9: surface 'surface1'.texture", file, wanted])]);
    }
    check(
        &folder,
        &[("[[surface]]\nSQUARE\ntexture='no.png'", &["no.png: there is no such file; check the path"])],
    );
}

#[test]
fn unreadable_scene_files_are_refused() {
    let folder = Folder::new().with("latin.toml", b"name = 'x'\nname2 = '\xe9'").with("dir.txt", "");
    let read = |name: &str| zonal_io::input::read_scene(&folder.path().join(name)).unwrap_err().to_string();
    assert!(
        read("no.toml").ends_with("no.toml: there is no such file; check the path"),
        "{}",
        read("no.toml")
    );
    assert!(read("latin.toml").ends_with("latin.toml:2:1: this is not UTF-8 text; save the file as UTF-8"));
    assert!(read(".").contains("this is not a file"), "{}", read("."));
    assert!(read("dir.txt").contains("dir.txt:1:1: the scene is empty"));
    let text = format!("[[surface]]\n{SQUARE}\ntexture = 'a.png'");
    let e = zonal_io::input::parse_scene(&text, None, "demo").unwrap_err().to_string();
    assert!(e.starts_with("demo:3:11: surface 'surface1'.texture") && e.contains("save it as a file"), "{e}");
}
