//! Files of Gmsh of all versions read as the same mesh in other formats, and damaged ones refused.

use crate::support;

use std::fmt::Write;
use support::{Folder, check, read_faces as read};
use zonal_io::input::{FacetFile, FilesInMemory, read_scene_from_bytes};

/// Corners of two faces over one another: a quadrilateral and two triangles.
const POSITIONS: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.25],
];
/// The same faces as OBJ.
const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1.25\nusemtl floor and wall\nf 1 2 3 4\n\
    usemtl physical-9\nf 7 6 5\nusemtl ungrouped\nf 7 5 8\n";

/// Elements of the faces and of their surroundings: dimension, entity, type, corners.
const ELEMENTS: [(i64, i64, i64, &[i64]); 5] = [
    (0, 1, 15, &[1]),
    (1, 1, 1, &[1, 2]),
    (2, 1, 3, &[1, 2, 3, 4]),
    (2, 2, 2, &[7, 6, 5]),
    (2, 3, 2, &[7, 5, 8]),
];
/// Physical group of each entity of dimension 2.
const GROUPS: [i64; 3] = [4, 9, 0];

/// Encoding of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Encoding {
    Text,
    Little,
    Big,
}

/// Writes numbers of a file.
struct Writer {
    encoding: Encoding,
    out: Vec<u8>,
}

impl Writer {
    fn new(version: &str, encoding: Encoding) -> Writer {
        let mut w = Writer { encoding, out: Vec::new() };
        w.text(&format!("$MeshFormat\n{version} {} 8\n", u8::from(encoding != Encoding::Text)));
        if encoding != Encoding::Text {
            w.int(1);
            w.text("\n");
        }
        w.text("$EndMeshFormat\n$Comments\nmade by a test\n$EndComments\n");
        w
    }
    fn text(&mut self, text: &str) {
        self.out.extend(text.bytes());
    }
    fn bytes(&mut self, mut little: Vec<u8>, text: String) {
        match self.encoding {
            Encoding::Text => return self.text(&(text + " ")),
            Encoding::Little => {}
            Encoding::Big => little.reverse(),
        }
        self.out.extend(little);
    }
    fn int(&mut self, x: i64) {
        self.bytes((x as i32).to_le_bytes().to_vec(), x.to_string());
    }
    fn size(&mut self, x: i64) {
        self.bytes(x.to_le_bytes().to_vec(), x.to_string());
    }
    fn double(&mut self, x: f64) {
        self.bytes(x.to_le_bytes().to_vec(), x.to_string());
    }
    fn ints(&mut self, list: &[i64]) {
        list.iter().for_each(|x| self.int(*x));
    }
    fn position(&mut self, k: usize) {
        POSITIONS[k].iter().for_each(|x| self.double(*x));
    }
}

const NAMES: &str = "$PhysicalNames\n2\n1 9 \"a line\"\n2 4 \"floor and wall\"\n$EndPhysicalNames\n";

/// A file of version 2.x.
fn version_2(version: &str, encoding: Encoding) -> Vec<u8> {
    let mut w = Writer::new(version, encoding);
    w.text(NAMES);
    w.text("$Nodes\n8\n");
    for k in 0..8 {
        w.int(k as i64 + 1);
        w.position(k);
    }
    w.text("\n$EndNodes\n$Elements\n5\n");
    for (number, (dimension, entity, kind, nodes)) in (1..).zip(ELEMENTS) {
        let group = if dimension == 2 { GROUPS[entity as usize - 1] } else { 9 };
        match encoding {
            Encoding::Text => w.ints(&[number, kind, 3, group, entity, 0]),
            _ => w.ints(&[kind, 1, 3, number, group, entity, 0]),
        }
        w.ints(nodes);
        if encoding == Encoding::Text {
            w.text("\n");
        }
    }
    w.text("\n$EndElements\n");
    w.out
}

/// Entities of versions 4.x: a point, a curve, three surfaces.
fn entities(w: &mut Writer, is_40: bool) {
    w.text("$Entities\n");
    [1, 1, 3, 0].iter().for_each(|n| w.size(*n));
    w.int(1);
    (0..if is_40 { 6 } else { 3 }).for_each(|_| w.double(0.5));
    w.size(0);
    w.int(1);
    (0..6).for_each(|_| w.double(0.5));
    w.size(1);
    w.int(9);
    w.size(2);
    w.ints(&[1, -1]);
    for (entity, group) in (1..).zip(GROUPS) {
        w.int(entity);
        (0..6).for_each(|_| w.double(0.5));
        w.size(i64::from(group != 0));
        if group != 0 {
            w.int(group);
        }
        w.size(0);
    }
    w.text("\n$EndEntities\n");
}

/// A file of version 4.0.
fn version_40(encoding: Encoding) -> Vec<u8> {
    let mut w = Writer::new("4", encoding);
    w.text(NAMES);
    entities(&mut w, true);
    w.text("$Nodes\n");
    [2, 8].iter().for_each(|n| w.size(*n));
    for (entity, nodes) in [(1, 0..3), (2, 3..8)] {
        // Nodes of the second block have two parameters.
        w.ints(&[entity, 2, entity - 1]);
        w.size(nodes.len() as i64);
        for k in nodes {
            w.int(k as i64 + 1);
            w.position(k);
            (0..2 * (entity - 1)).for_each(|_| w.double(0.25));
        }
    }
    w.text("\n$EndNodes\n$Elements\n");
    [5, 5].iter().for_each(|n| w.size(*n));
    for (number, (dimension, entity, kind, nodes)) in (1..).zip(ELEMENTS) {
        w.ints(&[entity, dimension, kind]);
        w.size(1);
        w.int(number);
        w.ints(nodes);
    }
    w.text("\n$EndElements\n");
    w.out
}

/// A file of version 4.1.
fn version_41(encoding: Encoding) -> Vec<u8> {
    let mut w = Writer::new("4.1", encoding);
    w.text(NAMES);
    entities(&mut w, false);
    w.text("$Nodes\n");
    [2, 8, 1, 8].iter().for_each(|n| w.size(*n));
    for (entity, nodes) in [(1, 0..3), (2, 3..8)] {
        w.ints(&[2, entity, entity - 1]);
        w.size(nodes.len() as i64);
        nodes.clone().for_each(|k| w.size(k as i64 + 1));
        for k in nodes {
            w.position(k);
            (0..2 * (entity - 1)).for_each(|_| w.double(0.25));
        }
    }
    w.text("\n$EndNodes\n$Elements\n");
    [5, 5, 1, 5].iter().for_each(|n| w.size(*n));
    for (number, (dimension, entity, kind, nodes)) in (1..).zip(ELEMENTS) {
        w.ints(&[dimension, entity, kind]);
        w.size(1);
        w.size(number);
        nodes.iter().for_each(|n| w.size(*n));
    }
    w.text("\n$EndElements\n$Periodic\n0\n$EndPeriodic\n");
    w.out
}

fn all_versions() -> Vec<Vec<u8>> {
    let mut out = Vec::new();
    for encoding in [Encoding::Text, Encoding::Little, Encoding::Big] {
        out.extend([version_2("2.2", encoding), version_2("2", encoding)]);
        out.extend([version_40(encoding), version_41(encoding)]);
    }
    out
}

/// A text of version 2.2 with these nodes and elements, each `type group nodes`.
fn text_file(nodes: &[[f64; 3]], elements: &[&str]) -> String {
    let mut out = format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n{NAMES}$Nodes\n{}\n", nodes.len());
    for (k, [x, y, z]) in nodes.iter().enumerate() {
        writeln!(out, "{} {x} {y} {z}", 10 * (k + 1)).unwrap();
    }
    write!(out, "$EndNodes\n$Elements\n{}\n", elements.len()).unwrap();
    for (k, element) in elements.iter().enumerate() {
        let (kind, rest) = element.split_once(' ').unwrap();
        let (group, nodes) = rest.split_once(' ').unwrap();
        let nodes: Vec<String> =
            nodes.split(' ').map(|n| (10 * n.parse::<u32>().unwrap()).to_string()).collect();
        writeln!(out, "{} {kind} 2 {group} 1 {}", k + 1, nodes.join(" ")).unwrap();
    }
    out + "$EndElements\n"
}

#[test]
fn all_versions_give_the_faces_of_the_obj() {
    let wanted = read("a.obj", OBJ).unwrap();
    for file in all_versions() {
        assert_eq!(read("a.msh", &file).unwrap(), wanted, "{}", String::from_utf8_lossy(&file[..40]));
    }
    let text = String::from_utf8(version_41(Encoding::Text)).unwrap();
    assert_eq!(read("a.msh", text.replace('\n', "\r\n")).unwrap(), wanted);
    let folder = Folder::new().with("a.msh", text);
    let scene =
        folder.scene("[[surface]]\nname='m'\nmesh={file='a.msh'}\nmaterials.'physical-9'.omit=true\n");
    let names: Vec<&str> = scene.surfaces().iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["m/floor and wall", "m/ungrouped"]);
}

#[test]
fn groups_with_a_minus_sign_turn_their_faces() {
    let text = String::from_utf8(version_41(Encoding::Text)).unwrap();
    let turned = read("a.msh", text.replace(" 1 4 ", " 1 -4 ")).unwrap();
    assert_eq!(turned.names[0], "floor and wall");
    let (mine, other) = (&turned.facets[0][0], &read("a.msh", text).unwrap().facets[0][0]);
    let normal = |c: &[zonal_math::Vec3]| (c[1] - c[0]).cross(c[2] - c[0]);
    assert_eq!(normal(mine).z, -normal(other).z);
}

#[test]
fn elements_of_higher_order_are_flat_and_repeated_ones_are_read_once() {
    let nodes: Vec<[f64; 3]> = (0..9).map(|k| POSITIONS[k % 8]).collect();
    let file = text_file(
        &nodes,
        &["16 4 1 2 3 4 5 6 7 8", "10 9 5 6 7 8 1 2 3 4 9", "9 4 1 2 7 4 5 6", "2 9 7 1 2"],
    );
    let mesh = read("a.msh", file).unwrap();
    assert_eq!(mesh.names, ["floor and wall", "physical-9", "floor and wall"]);
    assert_eq!(mesh.facets[0][0].len(), 4);
    // Nodes with their place on a curve, a surface and a volume.
    let parametric = text_file(&nodes[..3], &["2 9 1 2 3"]).replace("Nodes", "ParametricNodes");
    let lines = [
        ("10 0 0 0\n", "10 0 0 0 1 4 0.5\n"),
        ("20 1 0 0\n", "20 1 0 0 2 4 0.5 0.5\n"),
        ("30 1 1 0\n", "30 1 1 0 3 4\n"),
    ];
    let parametric = lines.iter().fold(parametric, |text, (from, to)| text.replace(from, to));
    assert_eq!(read("a.msh", parametric).unwrap().facets[0][0][2], zonal_math::vec3(1.0, 1.0, 0.0));
    assert!(
        mesh.notes.iter().any(|n| n.contains("3 faces are of higher order; they were read as flat")),
        "{:?}",
        mesh.notes
    );
    assert!(mesh.notes.iter().any(|n| n.contains("1 faces stand in the file twice")), "{:?}", mesh.notes);
}

/// Both sides of a sheet, of two groups, are two faces, as in every other format.
#[test]
fn opposite_faces_are_two() {
    let file = text_file(&POSITIONS[..4], &["3 4 1 2 3 4", "3 9 4 3 2 1", "3 9 2 1 4 3", "3 4 3 4 1 2"]);
    let mesh = read("a.msh", file).unwrap();
    assert_eq!(mesh.names, ["floor and wall", "physical-9"]);
    let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl floor and wall\nf 1 2 3 4\nusemtl physical-9\nf 4 3 2 1\n";
    assert_eq!(mesh.facets, read("a.obj", obj).unwrap().facets);
    assert!(mesh.notes.iter().any(|n| n.contains("2 faces stand in the file twice")), "{:?}", mesh.notes);
}

/// The area vectors of all facets and their volume, by the divergence theorem.
fn volume(mesh: &FacetFile) -> (zonal_math::Vec3, f64) {
    let (mut sum, mut volume) = (zonal_math::Vec3::ZERO, 0.0);
    for corners in mesh.facets.iter().flatten() {
        for k in 1..corners.len() - 1 {
            let area = (corners[k] - corners[0]).cross(corners[k + 1] - corners[0]) * 0.5;
            sum += area;
            volume += area.dot(corners[0]) / 3.0;
        }
    }
    (sum, volume)
}

#[test]
fn volumes_without_faces_have_their_boundary() {
    let mut nodes = POSITIONS;
    nodes[7][2] = 1.0;
    let apex =
        [nodes.to_vec(), vec![[0.5, 0.5, 2.0], [2.0, 0.0, 0.0], [2.0, 0.0, 1.0], [3.0, 0.0, 0.0]]].concat();
    // A cube under a pyramid, beside a prism and a tetrahedron; one hexahedron is turned inside out.
    let elements = ["5 4 1 2 3 4 5 6 7 8", "7 5 5 6 7 8 9", "6 6 2 10 3 6 11 7", "4 0 10 12 3 11"];
    let turned = ["5 4 5 6 7 8 1 2 3 4", elements[1], elements[2], elements[3]];
    for elements in [elements, turned] {
        let mesh = read("a.msh", text_file(&apex, &elements)).unwrap();
        let (sum, volume) = volume(&mesh);
        assert!(
            sum.length() < 1e-12 && (volume - (1.0 + 1.0 / 3.0 + 0.5 + 1.0 / 6.0)).abs() < 1e-12,
            "{volume}"
        );
        let count = |name: &str| mesh.names.iter().filter(|n| *n == name).count();
        // The name of group 4 is of dimension 2.
        assert_eq!((count("physical-4"), count("physical-5"), count("physical-6")), (4, 4, 4));
        assert!(
            mesh.notes[0].contains("its 4 volume elements have no faces of their own"),
            "{:?}",
            mesh.notes
        );
    }
    let both = read("a.msh", text_file(&apex, &["4 4 1 2 3 9", "2 4 1 2 3"])).unwrap();
    assert_eq!(both.facets.len(), 1);
    assert!(both.notes[0].contains("1 volume elements are not read"), "{:?}", both.notes);
}

/// Changes of a text of version 2.2, and what refuses the file.
const CHANGES: [(&str, &str, &str); 19] = [
    ("2.2 0 8", "3.0 0 8", "a.msh:3: version '3.0' is not read, only 2.x, 4.0 and 4.1; convert it: gmsh"),
    ("2.2 0 8", "", "version '' is not read"),
    ("2.2 0 8", "2.2 2 8", "the line of the format is not VERSION 0 8 or VERSION 1 8; convert"),
    ("2.2 0 8", "2.2 1 4", "the line of the format is not VERSION 0 8 or VERSION 1 8; convert"),
    ("$EndNodes", "$EndNode", "the section $Nodes does not end where its count says; it is cut short"),
    ("$Nodes\n8", "$Nodes\n7", "the section $Nodes does not end where its count says"),
    ("$Nodes\n8", "$Nodes\n9", "'$EndNodes' stands where a number is expected; mend"),
    ("$Nodes\n8", "$Nodes\nmany", "'many' stands where a count is expected; export"),
    ("$Nodes\n8", "$Nodes\n-8", "'-8' stands where a count is expected; export"),
    ("$Nodes\n8", "$Nodes\n18446744073709551615", "'$EndNodes' stands where a number is expected"),
    ("2 4 \"floor", "two \"floor", "is no name of a physical group (dimension, number, \"name\"); mend"),
    ("2 4 \"floor", "1 2 3 \"floor", "is no name of a physical group"),
    ("$EndComments", "$End", "the section $Comments has no end; the file is cut short"),
    ("1 0 0 0 ", "1 nan 0 0 ", "node 1 has a coordinate that is not finite; mend"),
    ("2 1 0 0 ", "1 1 0 0 ", "node 1 is given twice; export"),
    (
        "3 3 3 4 1",
        "3 34 3 4 1",
        "elements of type 34 are not read; write the mesh with elements of first order",
    ),
    ("7 6 5", "7 6 50", "a.msh:face or volume 2: its node 50 is none of the 8 nodes; export"),
    ("7 6 5", "7 6 5.5", "5.5 stands where a whole number is expected; export"),
    ("7 6 5", "7 6 -5", "-5 stands where a number from 0 is expected; export"),
];

/// Changes of a text of version 4.1, and what refuses the file.
const CHANGES_OF_41: [(&str, &str, &str); 5] = [
    ("Comments", "PartitionedEntities", "meshes in partitions are not read; join them: gmsh in.msh"),
    ("5 5 1 5", "6 5 1 5", "'$EndElements' stands where a number is expected; mend"),
    ("5 5 1 5", "9007199254740993 5 1 5", "'$EndElements' stands where a number is expected"),
    ("5 5 1 5", "1e300 5 1 5", "stands where a whole number is expected; export"),
    ("$Entities\n1 1 3 0", "$Entities\n1 1 4 0", "'$EndEntities' stands where a number is expected"),
];

/// Files that are refused, each with the reason.
fn invalid_files() -> Vec<(Vec<u8>, &'static str)> {
    let good = String::from_utf8(version_2("2.2", Encoding::Text)).unwrap();
    let binary = version_41(Encoding::Little);
    let at = |name: &[u8]| binary.windows(name.len()).position(|w| w == name).unwrap() + name.len();
    let mut huge = binary.clone();
    let elements = at(b"$Elements\n");
    huge[elements..elements + 8].copy_from_slice(&[0xff; 8]);
    let mut order = binary.clone();
    order[at(b"$MeshFormat\n4.1 1 8\n")] = 2;
    vec![
        (Vec::new(), "a.msh:1: this is no file of Gmsh: $MeshFormat is missing; export"),
        (b"hello\n".to_vec(), "a.msh:2: 'hello' stands where a section begins, as $Nodes; export"),
        (b"$Nodes\n".to_vec(), "this is no file of Gmsh: it does not begin with $MeshFormat; export"),
        (b"$NOD\n3\n".to_vec(), "a file of version 1, which is not read; convert it: gmsh in.msh -save"),
        (
            b"(1 \"a mesh\")\n".to_vec(),
            "a.msh:1: this is a mesh of Ansys Fluent, which is not read; convert it: meshio",
        ),
        (order, "the byte order of this binary file is not known; export"),
        (
            good.split("$Elements").next().unwrap().into(),
            "this file has no nodes or no $Elements; it is cut short",
        ),
        (
            text_file(&POSITIONS, &["1 4 1 2"]).into_bytes(),
            "this file has no triangles, quadrilaterals or volume elements; mesh",
        ),
        (huge, "stands where a whole number is expected; export"),
        (binary[..elements + 40].to_vec(), "this file is cut short: numbers are missing; copy"),
    ]
}

#[test]
fn damaged_files_are_refused() {
    let good = String::from_utf8(version_2("2.2", Encoding::Text)).unwrap();
    let new = String::from_utf8(version_41(Encoding::Text)).unwrap();
    let changed = CHANGES.map(|(from, to, wanted)| (good.replacen(from, to, 1).into_bytes(), wanted));
    let changed_new =
        CHANGES_OF_41.map(|(from, to, wanted)| (new.replacen(from, to, 1).into_bytes(), wanted));
    let cases = invalid_files().into_iter().chain(changed).chain(changed_new);
    for (bytes, wanted) in cases {
        let message = read("a.msh", &bytes).unwrap_err();
        assert!(message.contains(wanted) && message.contains([';', ':']), "'{wanted}' is not in {message}");
        let folder = Folder::new().with("a.msh", bytes);
        let scene = "[[surface]]\nname='m'\nmesh={file='a.msh'}\n";
        check(&folder, &[(scene, &["test.toml:3:12: surface 'm'.mesh.file", wanted])]);
    }
}

#[test]
fn altered_files_do_not_panic() {
    let read = |bytes: &[u8]| {
        let files = FilesInMemory::from([("a.msh".into(), bytes.to_vec())]);
        read_scene_from_bytes(b"[[surface]]\nmesh={file='a.msh'}\n", &files, "t.toml", 1).is_ok()
    };
    let volumes = text_file(&POSITIONS, &["5 4 1 2 3 4 5 6 7 8"]).into_bytes();
    for whole in all_versions().into_iter().chain([volumes]) {
        assert!(read(&whole));
        for cut in 0..whole.len() {
            read(&whole[..cut]);
            for mask in [0x15, 0xff] {
                let mut altered = whole.clone();
                altered[cut] ^= mask;
                read(&altered);
            }
        }
    }
}
