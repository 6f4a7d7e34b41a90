//! Input files of View3D read right, with numbers, and wrong ones refused with their line.

use std::path::Path;
use zonal_io::input::{
    View3dControls, View3dFile, View3dOutput, View3dSurface, View3dSurfaceKind, read_view3d,
    read_view3d_from_bytes,
};
use zonal_math::{Vec3, vec3};

fn read(text: &str) -> Result<View3dFile, String> {
    read_view3d_from_bytes(text.as_bytes(), "t.vs3").map_err(|e| e.to_string())
}

fn accepted(text: &str) -> View3dFile {
    read(text).unwrap_or_else(|e| panic!("{e} in\n{text}"))
}

/// Unit normal of a surface from the order of its corners.
fn normal(s: &View3dSurface) -> Vec3 {
    let c = &s.corners;
    (c[1] - c[0]).cross(c[2] - c[0]).normalized()
}

/// Eight corners of a cube of side 2, and four of a square of side 1 in its floor.
const VERTICES: &str = "F 3\nV 1 0 0 0\nV 2 2 0 0\nV 3 2 2 0\nV 4 0 2 0\nV 5 0 0 2\nV 6 2 0 2\nV 7 2 2 2\nV 8 0 2 2\n\
    V 9 .5 .5 0\nV 10 1.5 .5 0\nV 11 1.5 1.5 0\nV 12 .5 1.5 0\n";

#[test]
fn titles_controls_and_surfaces_are_read() {
    let text = "\u{feff}T first\r\n  t A title ! with a mark\r\n! comment\r\n/ comment\r\n\
        C EPS = 1.e-5, out=2 maxD=96.0 row=2 col 1 ! encl=1\r\nc emit=1 maxU=8 list=3 encl=1 / out=0\r\n"
        .to_string()
        + &VERTICES.replace('\n', "\r\n")
        + "S 1, 1 2 3 4 0 0 0.9 floor ! comment\r\n\ts 2 9 10 11 12 1 1 0.5 12f\r\nm 3 12 11 10 9 1 0 0.5\r\n\
           N 4 12 11 9 0 2 0 .5 hole further words\r\nO 5 5 6 7 8 0 0 0 lid\r\nO 6 5 6 8 0\r\n\
           S 7 of no concern\r\n"
            .replace("S 7", "End S 7")
            .as_str();
    let file = accepted(&text);
    assert_eq!(file.title, "A title ! with a mark");
    let controls = View3dControls {
        output: View3dOutput::SparseText,
        enclosure: true,
        emittances: true,
        eps: 1e-5,
        max_distance: Some(96.0),
        row: Some(1),
        column: Some(0),
    };
    assert_eq!(file.controls, controls);
    use View3dSurfaceKind::{Mask, Null, Obstruction, Radiating};
    let kinds: Vec<View3dSurfaceKind> = file.surfaces.iter().map(|s| s.kind).collect();
    assert_eq!(kinds, [Radiating, Radiating, Mask, Null, Obstruction, Obstruction]);
    let names: Vec<&str> = file.surfaces.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["floor", "12f", "3", "hole", "lid", "6"]);
    let bases: Vec<Option<usize>> = file.surfaces.iter().map(|s| s.base).collect();
    assert_eq!(bases, [None, Some(0), Some(0), Some(1), None, None]);
    assert_eq!(file.surfaces[1].combined_with, Some(0));
    assert!(file.surfaces.iter().all(|s| s.combined_with.is_none() || s.name == "12f"));
    assert_eq!(file.surfaces.iter().map(|s| s.corners.len()).collect::<Vec<_>>(), [4, 4, 4, 3, 4, 3]);
    assert_eq!(file.surfaces[0].corners[2], vec3(2.0, 2.0, 0.0));
    assert_eq!(file.surfaces[0].emissivity, 0.9);
    assert!(file.notes.is_empty(), "{:?}", file.notes);
}

#[test]
fn defaults_are_those_of_view3d() {
    let file = accepted(&(VERTICES.to_string() + "S 1 1 2 3 4 0 0 0.5\nC row=0 col=0\n*\n"));
    assert_eq!(file.controls, View3dControls::default());
    let c = View3dControls::default();
    assert_eq!((c.output, c.eps, c.max_distance, c.row), (View3dOutput::Text, 1e-4, None, None));
    assert!(!c.enclosure && !c.emittances && file.title.is_empty());
}

#[test]
fn replaced_and_ignored_contents_are_notes() {
    let text = VERTICES.replace("V 7 2 2 2", "V 7 2 2 2.00002")
        + "C size=3 colour=7\nC out=1\nQ 1\n7 8\nS 1 1 2 3 4 0 0 0\nS 2 5 8 7 6 0 0 1.0 lid\n";
    let file = accepted(&text);
    assert_eq!(file.surfaces.iter().map(|s| s.emissivity).collect::<Vec<_>>(), [0.001, 0.999]);
    let wanted = [
        "t.vs3:16: 2 lines from here begin with no letter of View3D and were ignored",
        "t.vs3: 2 emissivities below 0.001 or above 0.999 were replaced",
        "t.vs3: the corners of 1 surfaces lie a little out of a plane",
        "t.vs3:14: control 'size' is unknown and was ignored",
        "t.vs3:14: control 'colour' is unknown and was ignored",
        "t.vs3: there is no end line (E or *); all lines were read",
    ];
    assert_eq!(file.notes.len(), wanted.len(), "{:?}", file.notes);
    for (note, wanted) in file.notes.iter().zip(wanted) {
        assert!(note.starts_with(wanted), "{note}");
    }
}

#[test]
fn planes_of_form_3a_face_their_azimuth_and_tilt() {
    let text = "F 3A\nS 1 R 0 0 0.9 south\n 3. 0. 0. 0 90 3. 2.\nS 2 r 0 0 .9\n1 2 3\n\n270 90 ! west\n/ a comment\n1 2\n\
        S 3 T 0 0 .9 tri\n0 0 0 30 60 0 0 2 0\n0 2 beyond\nS 4 Q 0 0 .9 floor\n0 0 0 180 0 0 0 1 0 1 1 0 1\n\
        O 5 R anything\n0 0 9 0 180 1 1\nV 1 0 0 0\nE\n";
    let file = accepted(text);
    let degrees = |azimuth: f64, tilt: f64| {
        let (a, t) = (azimuth.to_radians(), tilt.to_radians());
        vec3(t.sin() * a.sin(), t.sin() * a.cos(), t.cos())
    };
    let wanted = [(0.0, 90.0), (270.0, 90.0), (30.0, 60.0), (180.0, 0.0), (0.0, 180.0)];
    for (s, (azimuth, tilt)) in file.surfaces.iter().zip(wanted) {
        assert!((normal(s) - degrees(azimuth, tilt)).length() < 1e-12, "{s:?}");
    }
    // The wall south of a room: its lower left corner, seen from the room, is the eastern one.
    let south = [vec3(3.0, 0.0, 2.0), vec3(3.0, 0.0, 0.0), vec3(0.0, 0.0, 0.0), vec3(0.0, 0.0, 2.0)];
    assert_eq!(file.surfaces[0].corners, south);
    assert_eq!(file.surfaces[3].corners[2], vec3(1.0, 1.0, 0.0));
    assert_eq!(file.surfaces[2].corners.len(), 3);
    // The triangle's upper corner: two metres up the slope of 60 degrees.
    assert!((file.surfaces[2].corners[2].z - 3f64.sqrt()).abs() < 1e-12);
    assert_eq!(
        file.surfaces.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(),
        ["south", "2", "tri", "floor", "5"]
    );
    assert_eq!(file.notes.len(), 1, "{:?}", file.notes);
}

/// Lines behind the vertices and what their refusal must contain; the first line is 14.
const REFUSED: &[(&str, &str)] = &[
    ("V 14 0 0 0", "t.vs3:14: vertex 14 is out of sequence; number vertices from 1: 13 is next"),
    ("V 13 0 0", "t.vs3:14: the coordinate z is missing; write it"),
    ("V 13 0 0 nan", "t.vs3:14: 'nan' is no coordinate z; give a finite number"),
    ("V x 0 0 0", "t.vs3:14: 'x' is no number of the vertex; give a whole number"),
    ("S 2 1 2 3 4 0 0 .5", "t.vs3:14: surface 2 is out of sequence; number surfaces from 1: 1 is next"),
    ("S 1 1 2 3 13 0 0 .5", "t.vs3:14: vertex 13 is none of the 12 defined above; mend column v4"),
    ("S 1 0 2 3 4 0 0 .5", "t.vs3:14: vertex 0 is none of the 12 defined above; mend column v1"),
    ("S 1 1 2 3 -4 0 0 .5", "t.vs3:14: '-4' is no number of a vertex; give"),
    ("S 1 1 2 3 4 0 0 ! .5", "t.vs3:14: the emissivity is missing; write it"),
    ("S 1 1 2 3 4 0 0 much", "t.vs3:14: 'much' is no emissivity; give a finite number"),
    ("S 1 1 2 2 0 0 0 .5", "t.vs3:14: surface 1: three of its corners lie on a line, or cross; mend"),
    ("S 1 1 2 3 3 0 0 .5", "t.vs3:14: surface 1: three of its corners lie on a line"),
    ("S 1 1 2 7 4 0 0 .5", "t.vs3:14: surface 1: its four corners are not in a plane; cut it"),
    ("S 1 1 3 2 4 0 0 .5", "t.vs3:14: surface 1: three of its corners lie on a line, or cross"),
    ("V 13 .2 .3 0\nS 1 1 2 13 4 0 0 .5", "t.vs3:15: surface 1: it is not convex; order"),
    ("O 1 1 2 3 4\nS 2 5 8 7 6 0 0 .5", "t.vs3:15: surface 2 follows an obstruction; put all"),
    ("O 1 1 2 3 4", "t.vs3: there is no radiating surface; write S lines"),
    ("F 4", "t.vs3:14: geometry '4' is not read; write F 3 or F 3a"),
    ("F", "t.vs3:14: the form of geometry is missing; write"),
    ("F 3a", "t.vs3:14: a second geometry follows the first; keep one"),
    ("C out=3", "t.vs3:14: out = 3 is no control; give 0 (text), 1"),
    ("C eps=0", "t.vs3:14: eps = 0 is no control; give a number above 0"),
    ("C maxD=inf", "t.vs3:14: maxD = inf is no control; give a number above 0"),
    ("C encl", "t.vs3:14: the value of encl is missing; give a whole number"),
    ("C maxU=1e3", "t.vs3:14: maxU = 1e3 is no control; give a whole number"),
    ("C list=99999", "t.vs3:14: list = 99999 is no control; give a whole number up to 32767"),
    ("C col=1", "t.vs3:14: col selects a column of no row; write row"),
];

/// The same behind a surface 1 that covers the floor, on line 14.
const REFUSED_BEHIND_FLOOR: &[(&str, &str)] = &[
    ("C row=2", "t.vs3:15: row = 2 is none of the 1 surfaces; give"),
    ("C row=1 col=9", "t.vs3:15: col = 9 is none of the 1 surfaces; give"),
    ("S 2 9 10 11 12 3 0 .5", "t.vs3:15: surface 2: base 3 is none of the 2 surfaces; mend"),
    ("S 2 9 10 11 12 2 0 .5", "t.vs3:15: surface 2: base 2 does not precede it; put"),
    ("S 2 9 10 11 12 3 0 .5\nS 3 1 2 3 4 0 0 .5", "t.vs3:15: surface 2: base 3 does not precede it"),
    ("S 2 5 6 7 8 1 0 .5", "t.vs3:15: surface 2: it is not in the plane of its base 1; mend"),
    ("S 2 12 11 10 9 1 0 .5", "t.vs3:15: surface 2: it faces away from its base 1; reverse"),
    ("M 2 9 10 11 12 1 0 .5", "t.vs3:15: surface 2: a mask or null surface faces its base 1; reverse"),
    ("N 2 12 11 10 9 0 0 .5", "t.vs3:15: surface 2: a mask or null surface has a base; write"),
    ("M 2 12 11 10 9 1 1 .5", "t.vs3:15: surface 2: masks and null surfaces are not combined; write 0"),
    ("V 13 3 .5 0\nS 2 9 13 11 12 1 0 .5", "t.vs3:16: surface 2: it reaches beyond its base 1; mend"),
    ("S 2 5 8 7 6 0 2 .5", "t.vs3:15: surface 2: it is combined with surface 2, which does not precede"),
    (
        "S 2 5 8 7 6 0 1 .5\nS 3 1 4 8 5 0 2 .5",
        "t.vs3:16: surface 3: it is combined with surface 2, which is combined itself; combine both with surface 1",
    ),
    (
        "M 2 12 11 10 9 1 0 .5\nS 3 1 4 8 5 0 2 .5",
        "t.vs3:16: surface 3: it is combined with surface 2, which does not radiate",
    ),
];

#[test]
fn wrong_lines_are_refused_with_a_remedy() {
    let floor = VERTICES.to_string() + "S 1 1 2 3 4 0 0 0.5\n";
    let cases = REFUSED.iter().map(|(lines, wanted)| (VERTICES.to_string() + lines + "\n", *wanted));
    let behind = REFUSED_BEHIND_FLOOR.iter().map(|(lines, wanted)| (floor.clone() + lines + "\n", *wanted));
    let others = [
        ("V 1 0 0 0\n", "t.vs3:1: the geometry is not known; write F 3 or F 3a above"),
        ("T x\nS 1 1 2 3 4\n", "t.vs3:2: the geometry is not known; write"),
        ("", "t.vs3: there is no radiating surface; write"),
        ("solid a\0", "t.vs3: this is not a text of View3D; give a .vs3 file"),
        (
            "F 3a\nS 1 R 0 0 .5 a\n0 0 0 0 90 3\nEnd\n",
            "t.vs3:4: 'End' is no number of the surface's plane; give",
        ),
        ("F 3a\nS 1 R 0 0 .5 a\n0 0 0 0 90 3\n", "t.vs3:3: the file ends within a surface; write origin"),
        (
            "F 3a\nS 1 R 0 0 .5 a\n0 0 0 0 90 3 -1\n",
            "t.vs3:3: a rectangle of 3 by -1 has no area; give positive",
        ),
        ("F 3a\nS 1 X 0 0 .5 a\n0 0 0 0 90 3 1\n", "t.vs3:2: 'X' is no shape; write R (rectangle)"),
        ("F 3a\nS 1\n", "t.vs3:2: the shape (R, T or Q) is missing; write"),
        (
            "F 3a\nS 1 T 0 0 .5\n0 0 0 0 90 0 0 1 0 2 0\n",
            "t.vs3:2: surface 1: three of its corners lie on a line",
        ),
    ];
    let others = others.iter().map(|(text, wanted)| (text.to_string(), *wanted));
    for (text, wanted) in cases.chain(behind).chain(others) {
        let message = read(&text).map(|f| f.surfaces).unwrap_err();
        assert!(message.starts_with(wanted) && !message.contains('\n'), "'{wanted}' is not in\n{message}");
    }
    let long = format!("{VERTICES}S 1 1 2 3 4 0 0 .5 {}\n", "n".repeat(300));
    assert!(read(&long).unwrap_err().contains("more than 256 characters; shorten it"));
    assert!(read_view3d(Path::new("none.vs3")).unwrap_err().to_string().contains("no such file; check"));
}

#[test]
fn parts_of_an_obstruction_may_precede_it() {
    let file = accepted(&(VERTICES.to_string() + "S 1 9 10 11 12 2 0 0.5 a\nO 2 1 2 3 4\nE\n"));
    assert_eq!(file.surfaces[0].base, Some(1));
}

#[test]
fn altered_files_do_not_panic() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus/view3d");
    for name in ["vertices.vs3", "planes.vs3"] {
        let whole = std::fs::read(corpus.join(name)).unwrap();
        assert!(read_view3d(&corpus.join(name)).is_ok());
        for cut in 0..whole.len() {
            let _ = read_view3d_from_bytes(&whole[..cut], "t.vs3");
            let mut altered = whole.clone();
            altered[cut] ^= 0x15;
            let _ = read_view3d_from_bytes(&altered, "t.vs3");
        }
    }
}
