//! Wrong inputs: each refusal names the file, the place and the mend.

use crate::support;

use support::{Folder, NpyOrder, RefusedScene, UNIT_SQUARE, check, f32s, npy, png};

// Guards (files): bad input is an `Err` that names file, place and remedy in one line; the command ends with 2.
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
            (
                "[wibble]\nx=1",
                &["test.toml:1:2:", "unknown key; known here: name, mode, bands, thermal, solve"],
            ),
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

#[test]
fn renamed_words_are_refused_with_the_new_word() {
    check(
        &Folder::new(),
        &[
            (
                "[solve]\nengine = 'hierarchical'",
                &["solve.engine: 'hierarchical' has another name; write \"rays\""],
            ),
            (
                "[boundary]\nx0 = 'mirror'\n[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[1,1,1]\nextinction=1",
                &["boundary.x0: 'mirror' has another name; write \"symmetry\""],
            ),
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
fn invalid_media_are_refused() {
    let medium = |rest: &str| format!("[medium]\nmin=[0,0,0]\nmax=[1,1,1]\n{rest}");
    let (none, both) = (medium("extinction=1"), medium("cells=[1,1,1]\ncell_size=1"));
    let (huge, tiny) =
        (medium("cells=[10000,10000,10000]\nextinction=1"), medium("cell_size=1e-9\nextinction=1"));
    let (empty, zero) = (medium("cells=[2,2,2]"), medium("cells=[2,0,2]\nextinction=1"));
    let outside = medium("cells=[2,2,2]\n[[medium.region]]\nbox={min=[5,5,5],max=[6,6,6]}\nextinction=1");
    let shapeless = medium("cells=[2,2,2]\n[[medium.region]]\nextinction=1");
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
            (
                "[medium]\nmin=[0,0,0]\nmax=[1,1,-1]\ncells=[1,1,1]",
                &["test.toml:3:5: medium.max: max is not above min along z"],
            ),
            (
                "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[1,1,1]\nalbedo=2",
                &["test.toml:5:8: medium.albedo", "from 0 to 1"],
            ),
        ],
    );
}

#[test]
fn invalid_lights_and_surroundings_are_refused() {
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
    check(
        &Folder::new(),
        &[
            (&direction, &["test.toml:7:11: light 'light1'.direction: this direction has no length"]),
            (&no_kind, &["kind: this key is missing; write kind"]),
            (&odd_kind, &["test.toml:5:6:", "did you mean 'sun'?"]),
            (&wide, &["test.toml:8:18:", "degrees"]),
            (&other, &["test.toml:7:1:", "direction: unknown key"]),
            (&dark, &["test.toml:6:9:", "does not emit; give it an emission"]),
            (&lost, &["test.toml:6:9:", "no surface has the name 'A1'; did you mean 'a'?"]),
            (part, &["test.toml:6:9:", "name one of its parts: hall.x0"]),
            ("[[surface]]\nSQUARE\n[surroundings]\nradiance=-1", &["test.toml:4:10: surroundings.radiance"]),
        ],
    );
}

#[test]
fn invalid_cameras_are_refused() {
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
            (&aim, &["test.toml:6:8: camera 'c'.target", "apart"]),
            (&up, &["test.toml:3:1: camera 'c'.up", "line of sight"]),
            (&fov, &["test.toml:7:5: camera 'c'.fov", "below 180"]),
            (&lens, &["camera 'c'.aperture", "diameter in metres, from 0"]),
            (&focus, &["camera 'c'.focus", "above 0"]),
            (&two, &["test.toml:8:6: camera 'c'.name: two cameras have this name; rename one"]),
        ],
    );
}

/// Names, bytes and errors of damaged or unsuitable arrays.
fn invalid_arrays() -> Vec<(&'static str, Vec<u8>, &'static str)> {
    let data = f32s(&[1.0, 2.0, f32::NAN, 4.0]);
    let good = npy("<f4", NpyOrder::C, "(1, 2, 2)", &f32s(&[1.0, 2.0, 3.0, 4.0]));
    let mut version = good.clone();
    version[6] = 9;
    vec![
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
    ]
}

#[test]
fn invalid_arrays_are_refused() {
    let region = |file: &str| {
        format!(
            "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[1,1,1]\n[[medium.region]]\ndensity={{file='{file}',min=[0,0,0],max=[1,1,1]}}\n"
        )
    };
    let folder = Folder::new();
    for (name, bytes, wanted) in invalid_arrays() {
        let file = format!("{name}.npy");
        folder.put(&file, bytes);
        check(
            &folder,
            &[(&region(&file), &["test.toml:6:15: medium.region[0].density.file", &file, wanted])],
        );
    }
    folder.put("good.npy", npy("<f4", NpyOrder::C, "(1, 2, 2)", &f32s(&[1.0, 2.0, 3.0, 4.0])));
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
    let read = |name: &str| zonal_io::input::read_scene(folder.path().join(name)).unwrap_err().to_string();
    assert!(
        read("no.toml").ends_with("no.toml: there is no such file; check the path"),
        "{}",
        read("no.toml")
    );
    assert!(read("latin.toml").ends_with("latin.toml:2:1: this is not UTF-8 text; save the file as UTF-8"));
    assert!(read(".").contains("this is not a file"), "{}", read("."));
    assert!(read("dir.txt").contains("dir.txt:1:1: the scene is empty"));
    let text = format!("[[surface]]\n{UNIT_SQUARE}\ntexture = 'a.png'");
    let e = zonal_io::input::parse_scene(&text, None, "demo").unwrap_err().to_string();
    assert!(e.starts_with("demo:3:11: surface 'surface1'.texture") && e.contains("save it as a file"), "{e}");
}
