//! Models of others: white materials, parts of different kinds, broken textures, properties that are not read.

use crate::support;

use support::{CUBE, Folder, Quad, png};
use zonal_scene::{Bands, Scene, Sides};

fn mesh(file: &str, more: &str) -> String {
    format!("[[surface]]\nname = 'm'\nmesh = {{ file = '{file}' }}\n{more}\n")
}

/// A folder with the file `q.glb`.
fn quad(change: impl FnOnce(&mut Quad)) -> Folder {
    let mut q = Quad::default();
    change(&mut q);
    Folder::new().with("q.glb", q.glb())
}

fn notes(s: &Scene) -> Vec<String> {
    s.notes().iter().map(|n| n.text.clone()).collect()
}

fn has_note(s: &Scene, words: &[&str]) -> bool {
    s.notes().iter().any(|n| words.iter().all(|w| n.contains(w)))
}

// Guards (files): reflectances of models that are limited have notes with their names.
#[test]
fn reflectances_of_models_are_limited_by_name() {
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 2 0\nusemtl snow\nf 1 2 3\nusemtl chalk\nf 1 3 2\nusemtl grey\nf 2 4 3\n";
    let folder = Folder::new()
        .with("a.obj", obj)
        .with("a.mtl", "newmtl snow\nKd 1 1 1\nnewmtl chalk\nKd 0.97 0.5 0.2\nnewmtl grey\nKd 0.9 0.9 0.9\n");
    let s = folder.scene(&mesh("a.obj", ""));
    let of = |s: &Scene, k: usize| s.surfaces()[k].reflectance;
    assert_eq!(
        [0, 1, 2].map(|k| of(&s, k)),
        [Bands::splat(0.95), Bands::from_rgb([0.95, 0.5, 0.2]), Bands::splat(0.9)]
    );
    assert!(has_note(&s, &["'snow'", "'chalk'", "0.95"]) && !has_note(&s, &["'grey'"]), "{:?}", notes(&s));
    // The scene may say 1, without a note.
    let given = folder.scene(&mesh("a.obj", "reflectance = 1"));
    assert_eq!(of(&given, 0), Bands::ONE);
    assert!(!has_note(&given, &["0.95"]), "{:?}", notes(&given));
    // The default material of glTF is white.
    let s = quad(|q| q.primitive = r#"{"attributes":{"POSITION":0},"indices":2}"#.into())
        .scene(&mesh("q.glb", ""));
    assert_eq!(of(&s, 0), Bands::splat(0.95));
    assert!(has_note(&s, &["'default'"]), "{:?}", notes(&s));
}

#[test]
fn white_texels_and_sheets_are_limited_and_dark_texels_kept() {
    let textured = |grey: u8| {
        let picture = png(2, 1, &[grey, grey, grey, 128, 128, 128]);
        quad(|q| {
            let start = q.binary.len();
            q.binary.extend(&picture);
            q.views += &format!(r#",{{"buffer":0,"byteOffset":{start},"byteLength":{}}}"#, picture.len());
            q.more =
                r#","images":[{"bufferView":3,"mimeType":"image/png"}],"textures":[{"source":0}]"#.into();
            q.material =
                r#"{"name":"w","pbrMetallicRoughness":{"metallicFactor":0,"baseColorTexture":{"index":0}}}"#
                    .into();
        })
        .scene(&mesh("q.glb", ""))
    };
    let (white, grey) = (textured(255), textured(128));
    let pixels = |s: &Scene| [0, 1].map(|k| s.textures()[0].pixels[k][0]);
    assert_eq!(pixels(&white), [0.95, pixels(&grey)[1]]);
    assert!(has_note(&white, &["'w'", "0.95"]) && !has_note(&grey, &["0.95"]), "{:?}", notes(&grey));
    // ρ and τ of a white sheet together.
    let s = quad(|q| {
        q.material = r#"{"name":"veil","extensions":{"KHR_materials_diffuse_transmission":{"diffuseTransmissionFactor":0.25}}}"#.into();
    })
    .scene(&mesh("q.glb", ""));
    let surface = &s.surfaces()[0];
    let sum = surface.reflectance + surface.transmission.as_ref().unwrap().transmittance;
    assert!((sum.first() - 0.95).abs() < 1e-12, "{sum:?}");
}

/// A cube of [`CUBE`] scaled and shifted, with other orientation if `inward`.
fn cube(first: usize, (scale, shift): (f64, f64), inward: bool) -> String {
    let mut out = String::new();
    for line in CUBE.lines() {
        let n: Vec<f64> = line.split(' ').skip(1).map(|x| x.parse().unwrap()).collect();
        if line.starts_with('v') {
            let [x, y, z] = [0, 1, 2].map(|k| scale * n[k] + shift);
            out += &format!("v {x} {y} {z}\n");
        } else {
            let mut corners: Vec<usize> = n.iter().map(|i| *i as usize + first).collect();
            if inward {
                corners.reverse();
            }
            let corners: Vec<String> = corners.iter().map(usize::to_string).collect();
            out += &format!("f {}\n", corners.join(" "));
        }
    }
    out
}

#[test]
fn sides_are_decided_by_part() {
    // A solid beside a sheet: the sheet does not give the solid a second side.
    let parts = cube(0, (1.0, 0.0), false) + "v 4 0 0\nv 5 0 0\nv 4 1 0\nf 9 10 11\n";
    let folder = Folder::new().with("a.obj", &parts);
    let s = folder.scene(&mesh("a.obj", "open_sides = 'both'"));
    let sides =
        |s: &Scene| -> Vec<(Sides, bool)> { s.surfaces().iter().map(|s| (s.sides, s.solid)).collect() };
    assert_eq!(sides(&s), [(Sides::Both, false), (Sides::Front, true)]);
    // A room that is turned inside out counts as open, its contents stay solid.
    let turned = cube(0, (4.0, 0.0), false) + &cube(8, (1.0, 1.0), false);
    folder.put("b.obj", turned);
    let s = folder.scene(&mesh("b.obj", "open_sides = 'both'"));
    assert_eq!(sides(&s), [(Sides::Both, false), (Sides::Front, true)]);
    assert_eq!(s.facets().iter().filter(|f| s.surfaces()[f.surface].sides == Sides::Both).count(), 6);
    assert_eq!(sides(&folder.scene(&mesh("b.obj", ""))), [(Sides::Front, true)]);
    // A sheet of one side by its file.
    let sheet = quad(|_| {});
    assert_eq!(sides(&sheet.scene(&mesh("q.glb", ""))), [(Sides::Front, false)]);
    assert_eq!(sides(&sheet.scene(&mesh("q.glb", "open_sides = 'both'"))), [(Sides::Both, false)]);
    support::check(
        &folder,
        &[
            (
                "[[surface]]\nmesh={file='a.obj'}\nopen_sides='both'\nsides='front'\n",
                &["remove sides or open_sides"],
            ),
            ("[[surface]]\nmesh={file='a.obj'}\nopen_sides='front'\n", &["open_sides"]),
            ("[[surface]]\nSQUARE\nopen_sides='both'\n", &["open_sides", "mesh"]),
        ],
    );
}

/// A material without textures.
const PLAIN_WALL: &str =
    r#"{"name":"wall","pbrMetallicRoughness":{"metallicFactor":0,"baseColorFactor":[0.5,0.5,0.5,1]}}"#;
/// A material with texture 0.
const TEXTURED_WALL: &str =
    r#"{"name":"wall","pbrMetallicRoughness":{"metallicFactor":0,"baseColorTexture":{"index":0}}}"#;

/// A quad of a material in a document with more entries.
fn quad_with(material: &str, more: &str) -> Folder {
    quad(|q| {
        q.more = more.into();
        q.material = material.into();
    })
}

#[test]
fn unused_broken_textures_are_ignored_and_used_ones_refused() {
    let broken = [
        (r#","textures":[{"source":0}]"#, "texture 0 names image 0, which is not there"),
        (r#","textures":[{}]"#, "texture 0 names no image"),
        (r#","textures":[{"source":0}],"images":[{}]"#, "image 0 has neither data nor a file"),
        (
            r#","textures":[{"source":0}],"images":[{"bufferView":9,"mimeType":"image/png"}]"#,
            "image 0 names a buffer view",
        ),
        (
            r#","textures":[{"extensions":{"EXT_texture_webp":{"source":0}}}],"images":[{"uri":"a.webp"}]"#,
            "EXT_texture_webp alone",
        ),
    ];
    for (more, defect) in broken {
        let s = quad_with(PLAIN_WALL, more).scene(&mesh("q.glb", ""));
        // An image without data is valid by itself.
        let is_valid = more.contains("[{}]") && more.contains("source");
        assert!(is_valid || has_note(&s, &[defect, "it is not used"]), "{more}: {:?}", notes(&s));
        assert_eq!(s.surfaces()[0].reflectance, Bands::splat(0.5));
        let refusal = quad_with(TEXTURED_WALL, more).refusal(&mesh("q.glb", ""));
        assert!(refusal.contains(defect) && refusal.contains("'wall'"), "{more}: {refusal}");
    }
}

#[test]
fn broken_references_that_nothing_reads_are_notes() {
    // Materials that nothing shows, textures of properties that are not read, samplers.
    let unshown = format!(
        r#"{PLAIN_WALL},{{"name":"old","pbrMetallicRoughness":{{"baseColorTexture":{{"index":7}}}}}}"#
    );
    let s = quad_with(&unshown, "").scene(&mesh("q.glb", ""));
    assert!(has_note(&s, &["baseColorTexture names texture 7"]), "{:?}", notes(&s));
    let occluded = PLAIN_WALL.replace(r#""name""#, r#""occlusionTexture":{"index":3},"name""#);
    assert!(has_note(
        &quad_with(&occluded, "").scene(&mesh("q.glb", "")),
        &["occlusionTexture names texture 3"]
    ));
    for more in [
        r#","samplers":[{"magFilter":1}]"#,
        r#","samplers":[{}],"textures":[{"sampler":4,"source":0}],"images":[{"uri":"a.png"}]"#,
    ] {
        assert!(
            has_note(&quad_with(PLAIN_WALL, more).scene(&mesh("q.glb", "")), &["sampler", "it is not used"]),
            "{more}"
        );
    }
    let refusal = quad_with(&TEXTURED_WALL.replace(":0}}", ":5}}"), "").refusal(&mesh("q.glb", ""));
    assert!(refusal.contains("baseColorTexture names texture 5, which is not there"), "{refusal}");
    // A defect elsewhere keeps its own message.
    let refusal = quad_with(PLAIN_WALL, r#","textures":[{"source":0}],"cameras":[{"type":1}]"#)
        .refusal(&mesh("q.glb", ""));
    assert!(!refusal.contains("texture"), "{refusal}");
}

// Guards (files): contents of models that are not read have notes with their names.
#[test]
fn properties_that_are_not_read_have_notes_with_their_materials() {
    let material = |name: &str, more: &str| format!(r#"{{"name":"{name}",{more}}}"#);
    let extension = |name: &str, content: &str| {
        format!(
            r#""pbrMetallicRoughness":{{"metallicFactor":0,"baseColorFactor":[0.5,0.5,0.5,1]}},"extensions":{{"{name}":{{{content}}}}}"#
        )
    };
    let cases = [
        (
            material("gold", r#""pbrMetallicRoughness":{"baseColorFactor":[0.5,0.5,0.5,1]}"#),
            vec!["'gold'", "metallic"],
        ),
        (
            material("lacquer", r#""pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0}"#),
            vec!["'lacquer'", "gloss"],
        ),
        (material("velvet", &extension("KHR_materials_sheen", "")), vec!["'velvet'", "KHR_materials_sheen"]),
        (material("gem", &extension("KHR_materials_ior", r#""ior":2"#)), vec!["'gem'", "KHR_materials_ior"]),
        (material("soap", &extension("KHR_materials_iridescence", "")), vec!["'soap'", "iridescence"]),
        (material("hair", &extension("KHR_materials_anisotropy", "")), vec!["'hair'", "anisotropy"]),
        (material("car", &extension("KHR_materials_clearcoat", "")), vec!["'car'", "clearcoat"]),
        (material("wet", &extension("KHR_materials_specular", "")), vec!["'wet'", "KHR_materials_specular"]),
        (material("odd", &extension("ACME_glow", "")), vec!["'odd'", "ACME_glow"]),
    ];
    for (text, words) in &cases {
        let s = quad(|q| q.material = text.clone()).scene(&mesh("q.glb", ""));
        assert!(has_note(&s, words), "{words:?}: {:?}", notes(&s));
    }
    // One note for a property, with its materials.
    let s = quad(|q| {
        q.material = ["a", "b", "c"].map(|n| material(n, &extension("KHR_materials_sheen", ""))).join(",");
        q.primitive = [0, 1, 2]
            .map(|k| format!(r#"{{"attributes":{{"POSITION":0}},"indices":2,"material":{k}}}"#))
            .join(",");
    })
    .scene(&mesh("q.glb", ""));
    let sheen: Vec<String> = notes(&s).into_iter().filter(|n| n.contains("sheen")).collect();
    assert!(sheen.len() == 1 && ["'a'", "'b'", "'c'"].iter().all(|n| sheen[0].contains(n)), "{sheen:?}");
    // The colours of vertices, and the diffuse colour of another model of materials.
    let s = quad(|q| q.primitive = q.primitive.replace("{\"POSITION\":0", "{\"POSITION\":0,\"COLOR_0\":0"))
        .scene(&mesh("q.glb", ""));
    assert!(has_note(&s, &["'wall'", "vertices"]), "{:?}", notes(&s));
    let glossy = r#"{"name":"s","extensions":{"KHR_materials_pbrSpecularGlossiness":{"diffuseFactor":[0.25,0.5,0.75,1]}}}"#;
    let s = quad(|q| q.material = glossy.into()).scene(&mesh("q.glb", ""));
    assert_eq!(s.surfaces()[0].reflectance, Bands::from_rgb([0.25, 0.5, 0.75]));
    assert!(has_note(&s, &["'s'", "specular colour"]), "{:?}", notes(&s));
}

#[test]
fn extensions_that_are_not_read_have_notes() {
    let used = r#","extensionsUsed":["EXT_mesh_gpu_instancing","KHR_texture_transform","KHR_materials_ior","VENDOR_other"]"#;
    let s = quad_with(PLAIN_WALL, used).scene(&mesh("q.glb", ""));
    assert!(has_note(&s, &["EXT_mesh_gpu_instancing is not read", "instances"]), "{:?}", s.notes());
    assert!(has_note(&s, &["VENDOR_other is not read"]));
    assert!(
        notes(&s).iter().all(|n| !n.contains("KHR_texture_transform") && !n.contains("KHR_materials_ior is"))
    );
}

#[test]
fn white_walls_around_a_space_give_a_warning() {
    let folder = Folder::new();
    let has_warning = |text: &str| {
        let s = folder.scene(text);
        s.notes().iter().any(|n| n.code == "white-walls" && n.is_warning() && n.contains("'w"))
    };
    let open = "[[surface]]\nname='w'\nroom={min=[0,0,0],max=[1,1,1]}\nomit=['z1']\n";
    assert!(has_warning(&format!("{open}reflectance=1\nsides='both'\n")));
    assert!(!has_warning(&format!("{open}reflectance=0.95\nsides='both'\n")));
    assert!(!has_warning(&format!("{open}reflectance=1\n")));
    // One white plate traps nothing.
    assert!(!has_warning(
        "[[surface]]\nname='w'\nrectangle={origin=[0,0,0],edge1=[1,0,0],edge2=[0,1,0]}\nreflectance=1\nsides='both'\n"
    ));
    let closed = "[[surface]]\nname='w'\nroom={min=[0,0,0],max=[1,1,1]}\nreflectance=1\n";
    assert!(has_warning(closed));
    let block = "[[surface]]\nname='b'\nbox={min=[0.2,0.2,0.2],max=[0.4,0.4,0.4]}\n";
    assert!(!has_warning(&format!("{closed}{block}")));
    assert!(has_warning(&format!(
        "{closed}{}",
        block.replace("0.2,0.2,0.2", "3,3,3").replace("0.4,0.4,0.4", "4,4,4")
    )));
    let smoke = |albedo: f64| {
        format!("{closed}[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[2,2,2]\nextinction=1\nalbedo={albedo}\n")
    };
    assert!(has_warning(&smoke(1.0)) && !has_warning(&smoke(0.9)));
}
