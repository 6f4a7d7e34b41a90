//! PLY files read as the same mesh in other formats, and damaged ones refused.

use crate::support;

use support::{CUBE, Folder, check, read_faces as read};
use zonal_io::input::{FilesInMemory, read_scene_from_bytes};

/// The faces of the cube of `CUBE`, from 0.
const CUBE_FACES: [[u32; 4]; 6] =
    [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
/// The corners of the cube of `CUBE`.
const CUBE_CORNERS: [[i8; 3]; 8] =
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];

/// Header of a cube: types of coordinates, of lengths and of indices; a foreign element stands between vertices and faces.
fn header(format: &str, [coordinate, length, index]: [&str; 3]) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment a cube\nobj_info of a test\nelement vertex 8\nproperty uchar flags\n\
         property {coordinate} x\nproperty {coordinate} y\nproperty {coordinate} z\n\
         element edge 2\nproperty int vertex1\nproperty list uchar short marks\n\
         element face 6\nproperty list {length} {index} vertex_indices\nproperty double quality\nend_header\n"
    )
}

/// The bytes of a number of a type of PLY.
fn number(kind: &str, big_endian: bool, x: f64) -> Vec<u8> {
    let mut bytes = match kind {
        "char" | "int8" | "uchar" | "uint8" => vec![x as i64 as u8],
        "short" | "int16" | "ushort" | "uint16" => (x as i16).to_le_bytes().to_vec(),
        "int" | "int32" | "uint" | "uint32" => (x as i32).to_le_bytes().to_vec(),
        "float" | "float32" => (x as f32).to_le_bytes().to_vec(),
        _ => x.to_le_bytes().to_vec(),
    };
    if big_endian {
        bytes.reverse();
    }
    bytes
}

fn binary_cube(big_endian: bool, types: [&str; 3]) -> Vec<u8> {
    let [coordinate, length, index] = types;
    let format = if big_endian { "binary_big_endian" } else { "binary_little_endian" };
    let mut out = header(format, types).into_bytes();
    for corner in CUBE_CORNERS {
        // A flag of 10 is a line end behind the header.
        out.push(10);
        corner.iter().for_each(|x| out.extend(number(coordinate, big_endian, f64::from(*x))));
    }
    for marks in [0u8, 3] {
        out.extend([0, 0, 0, 1, marks]);
        out.extend(vec![7; 2 * usize::from(marks)]);
    }
    for face in CUBE_FACES {
        out.extend(number(length, big_endian, 4.0));
        face.iter().for_each(|k| out.extend(number(index, big_endian, f64::from(*k))));
        out.extend(number("double", big_endian, f64::NAN));
    }
    out
}

fn text_cube() -> String {
    let corners: String = CUBE_CORNERS.iter().map(|[x, y, z]| format!("10 {x} {y} {z}\n")).collect();
    let faces: String = CUBE_FACES.iter().map(|[a, b, c, d]| format!("4 {a} {b} {c} {d} nan\n")).collect();
    header("ascii", ["float", "uchar", "int"]) + &corners + "1 0\n2 3 7 7 7\n" + &faces
}

#[test]
fn all_encodings_and_types_give_the_faces_of_the_obj() {
    let wanted = read("a.obj", CUBE).unwrap();
    let read = |bytes: Vec<u8>| read("a.ply", bytes).unwrap();
    let text = text_cube();
    let one_line = text.replace("end_header\n", "end_header\r").replace('\n', " ").replace('\r', "\n");
    assert_eq!(read(text.clone().into_bytes()), wanted);
    assert_eq!(read(text.replace('\n', "\r\n").into_bytes()), wanted);
    assert!(support::read_faces("a.ply", one_line).unwrap_err().contains("first line is not ply"));
    for types in [
        ["float", "uchar", "int"],
        ["double", "uint8", "uint32"],
        ["char", "int", "ushort"],
        ["int16", "int16", "uint8"],
        ["float32", "uint", "float"],
        ["float64", "char", "int8"],
    ] {
        for big_endian in [false, true] {
            assert_eq!(read(binary_cube(big_endian, types)), wanted, "{types:?} {big_endian}");
        }
    }
    // Line ends of other systems, and the other name of the list.
    let whole = binary_cube(false, ["float", "uchar", "int"]);
    let end = header("binary_little_endian", ["float", "uchar", "int"]).len();
    for line_end in ["\r\n", "\r"] {
        let head = String::from_utf8(whole[..end].to_vec()).unwrap().replace('\n', line_end);
        let head = head.replace("vertex_indices", "vertex_index");
        assert_eq!(read([head.as_bytes(), &whole[end..]].concat()), wanted);
    }
}

#[test]
fn polygons_are_cut_as_those_of_obj() {
    let corners = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]];
    let rows: String = corners.iter().map(|[x, y]| format!("{x} {y} 0\n")).collect();
    let ply = format!(
        "ply\nformat ascii 1.0\nelement face 2\nproperty list uchar int vertex_index\nelement vertex 6\nproperty float x\n\
         property float y\nproperty float z\nend_header\n6 0 1 2 3 4 5\n3 0 1 2\n{rows}"
    );
    let obj: String = corners.iter().map(|[x, y]| format!("v {x} {y} 0\n")).collect();
    let obj = obj + "f 1 2 3 4 5 6\nf 1 2 3\n";
    let mesh = read("a.ply", &ply).unwrap();
    assert_eq!(mesh, read("a.obj", obj).unwrap());
    assert_eq!((mesh.facets.len(), mesh.facets[0].len()), (2, 4));
}

#[test]
fn texture_coordinates_are_read_and_colours_are_not() {
    let head = "ply\nformat ascii 1.0\ncomment TextureFile my wall.png\nelement vertex 4\nproperty float x\nproperty float y\n\
                property float z\nproperty float S\nproperty float T\nproperty uchar red\nproperty uchar green\n\
                property uchar blue\nelement face 1\nproperty list uchar int vertex_indices\n";
    let rows = "0 0 0 0 0 1 2 3\n1 0 0 1 0 1 2 3\n1 1 0 1 1 1 2 3\n0 1 0 0 1 1 2 3\n4 0 1 2 3";
    let scene = |ply: String| Folder::new().with("a.ply", ply).scene("[[surface]]\nmesh={file='a.ply'}\n");
    for [s, t] in [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]] {
        let names = head.replace(" S\n", &format!(" {s}\n")).replace(" T\n", &format!(" {t}\n"));
        let read = scene(format!("{names}end_header\n{rows}\n"));
        assert_eq!(read.facets()[0].uv, [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]]);
        let notes: Vec<&str> = read.notes().iter().map(|n| n.text.as_str()).collect();
        assert!(
            notes.iter().any(|n| n.contains("the colours of its vertices are not read; write reflectance"))
        );
        assert!(notes.iter().any(|n| n.contains("write texture = \"my wall.png\"")), "{notes:?}");
    }
    let by_corner =
        format!("{head}property list uchar float texcoord\nend_header\n{rows} 8 0 0 0.5 0 0.5 0.5 0 0.5\n");
    assert_eq!(scene(by_corner).facets()[0].uv, [[0.0, 1.0], [0.5, 1.0], [0.0, 0.5]]);
}

/// Changes of a text, and what refuses the file.
const CHANGES: [(&str, &str, &str); 21] = [
    ("format ascii 1.0\n", "", "the line format is missing; export"),
    ("ascii", "binary", "a.ply:2: the format 'binary' is not read; export as ascii"),
    ("ascii 1.0", "ascii 2.0", "a.ply:2: 'format ascii 2.0' is no line of a PLY 1.0 header"),
    ("vertex 8", "vertex eight", "a.ply:5: 'eight' is no number of rows; export"),
    ("vertex 8", "vertex -8", "a.ply:5: '-8' is no number of rows; export"),
    ("element edge", "element vertex", "a.ply:10: the element vertex is declared twice"),
    ("float x", "half x", "a.ply:7: 'half' is no type of PLY; export"),
    ("element vertex 8\n", "", "a.ply:5: a property stands before any element; export"),
    ("element vertex", "element point", "a.ply:header: this file has no element vertex"),
    ("float z", "float w", "a.ply:header: its vertices have no x, y and z; export"),
    ("vertex_indices", "corners", "a.ply:header: its faces have no list vertex_indices; export"),
    ("list uchar int vertex_indices", "int vertex_indices", "its faces have no list vertex_indices"),
    ("vertex 8", "vertex 80000000000", "80000000000 rows of vertex take at least 640000000000 bytes, but"),
    ("10 0 0 0", "10 0 zero 0", "a.ply:17: 'zero' stands where a number is expected; mend"),
    ("10 1 0 0", "10 1 inf 0", "a.ply:18: vertex 1 has a number that is not finite; mend"),
    ("4 3 2 1 0", "4 3 2 1 8", "a.ply:face 0: vertex index 8 is out of range: there are 8 vertices"),
    ("4 3 2 1 0", "4 3 2 1 -1", "a.ply:27: face 0: -1 is no index of a vertex; export"),
    ("4 3 2 1 0", "4 3 2 1 0.5", "a.ply:27: face 0: 0.5 is no index of a vertex; export"),
    ("4 3 2 1 0 nan", "2 3 2 nan", "a.ply:face 0: a face needs at least three corners, not 2"),
    ("4 3 2 1 0", "-4 3 2 1 0", "a.ply:27: -4 stands where a number from 0 is expected"),
    ("4 3 2 1 0", "4000000000 3 2 1 0", "this file is cut short: numbers are missing; copy"),
];

/// Files that are refused, each with the reason.
fn invalid_files() -> Vec<(Vec<u8>, &'static str)> {
    let good = text_cube();
    let with = |from: &str, to: &str| good.replacen(from, to, 1).into_bytes();
    let bin = binary_cube(false, ["float", "uchar", "int"]);
    let start = header("binary_little_endian", ["float", "uchar", "int"]).len();
    let mut negative = bin.clone();
    let length = bin.len();
    negative[length - 12..length - 8].copy_from_slice(&(-1i32).to_le_bytes());
    let mut infinite = bin.clone();
    infinite[start + 1..start + 5].copy_from_slice(&f32::INFINITY.to_le_bytes());
    let head = String::from_utf8_lossy(&bin[..start]).replace("edge 2", "edge 18446744073709551615");
    let huge = [head.as_bytes(), &bin[start..]].concat();
    let long_list = [&with("list uchar", "list uint")[..], b""].concat();
    let cloud = good.split("element edge").next().unwrap().to_string() + "end_header\n";
    let strips =
        cloud.replace("end_header", "element tristrips 1\nproperty list int int vertex_indices\nend_header");
    vec![
        (Vec::new(), "a.ply: this is no PLY: its first line is not ply; export"),
        (b"plyx\n".to_vec(), "a.ply: this is no PLY"),
        (b"ply\nformat ascii 1.0\n".to_vec(), "a.ply:2: this file is cut short: end_header is missing; copy"),
        (cloud.into_bytes(), "this file is a cloud of 8 points without faces; reconstruct its surface"),
        (strips.into_bytes(), "strips of triangles, which are not read; open it in MeshLab"),
        (long_list[..long_list.len() - 9].to_vec(), "this file is cut short: numbers are missing; copy"),
        (bin[..length - 1].to_vec(), "this file is cut short: numbers are missing; copy"),
        (
            bin[..start + 4].to_vec(),
            "8 rows of vertex take at least 104 bytes, but 4 are left; the file is cut",
        ),
        (huge, "18446744073709551615 rows of edge take at least 18446744073709551615 bytes, but"),
        (negative, "face 5: -1 is no index of a vertex; export"),
        (infinite, "vertex 0 has a number that is not finite; mend"),
    ]
}

#[test]
fn damaged_files_are_refused() {
    let good = text_cube();
    let changed = CHANGES.map(|(from, to, wanted)| (good.replacen(from, to, 1).into_bytes(), wanted));
    let cases = invalid_files().into_iter().chain(changed);
    for (bytes, wanted) in cases {
        let message = read("a.ply", &bytes).unwrap_err();
        assert!(message.contains(wanted) && message.contains([';', ':']), "'{wanted}' is not in {message}");
        let folder = Folder::new().with("a.ply", bytes);
        let scene = "[[surface]]\nname='m'\nmesh={file='a.ply'}\n";
        check(&folder, &[(scene, &["test.toml:3:12: surface 'm'.mesh.file", wanted])]);
    }
    let rows = "4 ".to_string() + &"0 1 2 ".repeat(700);
    let many =
        good.replacen("list uchar", "list int", 1).replacen("4 3 2 1 0", &rows.replacen('4', "2100", 1), 1);
    assert!(
        read("a.ply", many)
            .unwrap_err()
            .contains("face 0: this face has more than 1024 corners; triangulate")
    );
}

#[test]
fn altered_files_do_not_panic() {
    let read = |bytes: &[u8]| {
        let files = FilesInMemory::from([("a.ply".into(), bytes.to_vec())]);
        read_scene_from_bytes(b"[[surface]]\nmesh={file='a.ply'}\n", &files, "t.toml", 1).is_ok()
    };
    let types = ["float", "uchar", "int"];
    for whole in [text_cube().into_bytes(), binary_cube(false, types), binary_cube(true, types)] {
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
