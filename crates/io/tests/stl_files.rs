//! STL files read right, with numbers, and damaged ones refused.

use crate::support;

use support::{Folder, check};
use zonal_io::input::{FilesInMemory, StlFacet, StlFile, read_scene_from_bytes, read_stl};
use zonal_math::{Vec3, vec3};
use zonal_scene::{Scene, Sides};

/// Corners of the triangles of the unit cube, counter-clockwise from outside; floor first.
fn cube() -> Vec<[Vec3; 3]> {
    let corner = |k: usize| vec3((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];
    sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).map(|t| t.map(corner)).collect()
}

/// A solid as text.
fn text(name: &str, triangles: &[[Vec3; 3]]) -> String {
    let vertex = |p: &Vec3| format!("   vertex {} {} {}\n", p.x, p.y, p.z);
    let facet = |t: &[Vec3; 3]| {
        let corners: String = t.iter().map(vertex).collect();
        format!(" facet normal 0 0 0\n  outer loop\n{corners}  endloop\n endfacet\n")
    };
    let facets: String = triangles.iter().map(facet).collect();
    format!("solid {name}\n{facets}endsolid {name}\n")
}

/// A binary file.
fn binary(header: &str, triangles: &[[Vec3; 3]]) -> Vec<u8> {
    let mut out = header.as_bytes().to_vec();
    out.resize(80, b' ');
    out.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        let numbers = [0.0; 3].into_iter().chain(t.iter().flat_map(|p| p.array()));
        numbers.for_each(|x| out.extend((x as f32).to_le_bytes()));
        out.extend([0x1f, 0x7c]);
    }
    out
}

fn read(bytes: impl AsRef<[u8]>) -> Result<StlFile, String> {
    let folder = Folder::new().with("a.stl", bytes);
    let path = folder.path().join("a.stl");
    read_stl(&path).map_err(|e| e.to_string().replace(&path.display().to_string(), "a.stl"))
}

fn names(s: &Scene) -> Vec<&str> {
    s.surfaces().iter().map(|s| s.name.as_str()).collect()
}

#[test]
fn text_and_binary_files_have_the_same_facets() {
    let triangles = cube();
    let facet = |(number, t): (usize, &[Vec3; 3])| StlFacet { corners: *t, part: 0, number };
    let wanted: Vec<StlFacet> = triangles.iter().enumerate().map(facet).collect();
    let headers = ["exported", "solid header of a binary file", "solid\n facet normal"];
    for header in headers {
        let stl = read(binary(header, &triangles)).unwrap();
        assert_eq!((&stl.facets, &stl.parts, stl.facet_count), (&wanted, &vec!["default".to_string()], 12));
        assert!(stl.notes.is_empty(), "{:?}", stl.notes);
    }
    let upper = text("box", &triangles).to_uppercase().replace('\n', "\r\n");
    let one_line = text("box", &triangles).replacen('\n', "\r", 1).replace('\n', " ").replacen('\r', "\n", 1);
    for (file, name) in [(text("box", &triangles), "box"), (upper, "BOX"), (one_line, "box")] {
        let stl = read(file).unwrap();
        assert_eq!((&stl.facets, &stl.parts), (&wanted, &vec![name.to_string()]));
    }
}

#[test]
fn each_name_of_a_solid_is_a_material() {
    let t = cube();
    let parts = [text("floor", &t[..2]), text("walls and lid", &t[2..11]), text("floor", &t[11..])].concat();
    let folder =
        Folder::new().with("c.stl", parts).with("t.csv", "material,T\nfloor,300\nwalls and lid,400\n");
    let s = folder.scene(
        "mode='thermal'\n[[surface]]\nname='m'\nmesh={file='c.stl',scale=2}\ntemperature={file='t.csv',by='material'}\n\
         emissivity=0.9\n",
    );
    assert_eq!(names(&s), ["m/floor", "m/walls and lid"]);
    assert_eq!(s.facets().iter().map(|f| f.surface).filter(|k| *k == 0).count(), 3);
    assert!(s.surfaces().iter().all(|f| f.solid && f.sides == Sides::Front));
    let area: f64 = s.facets().iter().map(|f| f.plate.area()).sum();
    assert!((area - 24.0).abs() < 1e-12, "{area}");
    // Outward normals: the first facet is a half of the floor.
    assert!(s.facets()[0].plate.normal().z < -0.9);
}

#[test]
fn facets_without_area_are_dropped_and_keep_their_number() {
    let mut t = cube();
    t.insert(1, [t[0][0], t[0][1], t[0][0]]);
    let stl = read(binary("", &t)).unwrap();
    assert_eq!((stl.facet_count, stl.facets.len(), stl.facets[1].number), (13, 12, 2));
    assert_eq!(stl.notes.len(), 1);
    assert!(stl.notes[0].ends_with("a.stl: 1 facets without area were dropped"), "{:?}", stl.notes);
    // Values by face count the dropped facet.
    let rows: String = (0..13).map(|k| format!("{}\n", 300 + k)).collect();
    let folder = Folder::new().with("c.stl", text("", &t)).with("t.csv", rows);
    let s = folder.scene(
        "mode='thermal'\n[[surface]]\nmesh={file='c.stl'}\nemissivity=0.9\ntemperature={file='t.csv'}\n",
    );
    assert_eq!((s.facets().len(), names(&s)), (12, vec!["surface1"]));
    assert!(s.notes().iter().any(|n| n.text.contains("1 facets without area")), "{:?}", s.notes());
    let turned = text("a", &t[..1]).replace("normal 0 0 0", "normal 0 0 0.5");
    let notes = read(turned).unwrap().notes;
    assert!(notes[0].contains("the normals of 1 facets oppose the order"), "{notes:?}");
    assert!(read(text("a", &t[..1]).replace("normal 0 0 0", "normal nan 0 0")).unwrap().notes.is_empty());
}

#[test]
fn damaged_files_are_refused() {
    let good = text("a", &cube());
    let bin = binary("x", &cube());
    let with_float = |at: usize, x: f32| {
        let mut out = bin.clone();
        out[at..at + 4].copy_from_slice(&x.to_le_bytes());
        out
    };
    let absurd = [&bin[..80], &[0xff; 4], &bin[84..]].concat();
    let flat = text("a", &[[Vec3::ZERO; 3]]);
    let cases: Vec<(Vec<u8>, &str)> = vec![
        (Vec::new(), "a.stl: this is no STL: neither a text"),
        (b"solid".to_vec(), "a.stl:1: this file is cut short: facet or endsolid is missing; export"),
        (b"solid a\nendsolid a\n".to_vec(), "a.stl: this mesh has no facets; export"),
        (bin[..84].to_vec(), "a.stl:byte 80: 12 facets take 684 bytes, but the file has 84; it is cut short"),
        (bin[..600].to_vec(), "a.stl:byte 80: 12 facets take 684 bytes, but the file has 600"),
        (absurd, "a.stl:byte 80: 4294967295 facets take 214748364834 bytes, but the file has 684"),
        (with_float(84 + 12, f32::NAN), "a.stl:byte 96: a corner of facet 1 is not finite; mend it"),
        (with_float(84 + 50 + 44, f32::INFINITY), "a.stl:byte 170: a corner of facet 2 is not finite"),
        (flat.into_bytes(), "a.stl: all 1 faces are without area; export"),
        (good.replacen("vertex 0 0 0", "vertex 0 inf 0", 1).into(), "a.stl:4: a vertex is not finite; mend"),
        (
            good.replacen("vertex 0 0 0", "vertex 0 x 0", 1).into(),
            "a.stl:4: 'x' stands where STL has a number",
        ),
        (
            good.replacen("vertex 0 0 0\n", "", 1).into(),
            "a.stl:6: 'endloop' stands where STL has vertex; mend",
        ),
        (good.replacen("outer", "inner", 1).into(), "a.stl:3: 'inner' stands where STL has outer"),
        (good.replacen("endfacet", "solid", 1).into(), "a.stl:8: 'solid' stands where STL has endfacet"),
        (good[..100].into(), "this file is cut short"),
        (good.replace("endsolid a", "").into(), "this file is cut short: facet or endsolid is missing"),
        ((good.clone() + "more").into(), "'more' stands where STL has solid"),
    ];
    for (bytes, wanted) in cases {
        let message = read(&bytes).unwrap_err();
        assert!(message.contains(wanted) && message.contains(';'), "'{wanted}' is not in {message}");
        let folder = Folder::new().with("a.stl", bytes);
        let scene = "[[surface]]\nname='m'\nmesh={file='a.stl'}\n";
        check(&folder, &[(scene, &["test.toml:3:12: surface 'm'.mesh.file", wanted])]);
    }
    assert!(read_stl(std::path::Path::new("none.stl")).unwrap_err().to_string().contains("no such file"));
}

#[test]
fn altered_files_do_not_panic() {
    let read = |bytes: &[u8]| {
        let files = FilesInMemory::from([("a.stl".into(), bytes.to_vec())]);
        let scene = read_scene_from_bytes(b"[[surface]]\nmesh={file='a.stl'}\n", &files, "t.toml", 1);
        scene.is_ok()
    };
    for whole in [text("a", &cube()).into_bytes(), binary("solid", &cube())] {
        assert!(read(&whole));
        for cut in 0..whole.len() {
            read(&whole[..cut]);
            let mut altered = whole.clone();
            altered[cut] ^= 0x15;
            read(&altered);
        }
    }
}

#[test]
fn bytes_behind_the_declared_facets_are_left_out_with_a_note() {
    let triangles = cube();
    for excess in [1, 7, 50, 123] {
        let mut bytes = binary("exported", &triangles);
        bytes.extend(vec![0xaa; excess]);
        let stl = read(&bytes).unwrap();
        assert_eq!((stl.facets.len(), stl.facet_count), (12, 12));
        let wanted = format!("a.stl: {excess} byte(s) behind the 12 declared facets were not read");
        assert!(stl.notes.len() == 1 && stl.notes[0].ends_with(&wanted), "{:?}", stl.notes);
    }
    // A header alone that declares no facets is no STL, whatever follows.
    let mut empty = binary("exported", &[]);
    empty.extend([0; 50]);
    assert!(read(&empty).unwrap_err().contains("0 facets take 84 bytes"));
}
