//! Repeated faces, inverted and crowded edges of mesh files of every format.

use crate::support;

use support::Folder;
use zonal_scene::{Scene, Sides};

const CORNERS: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [0.0, 1.0, 1.0],
    [1.0, 1.0, 1.0],
];
/// The faces of a room, normals inward.
const ROOM: [[usize; 4]; 6] =
    [[1, 3, 2, 0], [6, 7, 5, 4], [2, 6, 4, 0], [5, 7, 3, 1], [4, 5, 1, 0], [3, 7, 6, 2]];

fn triangles(quads: &[[usize; 4]]) -> Vec<[usize; 3]> {
    quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect()
}

fn scene_of(name: &str, bytes: impl AsRef<[u8]>) -> Scene {
    Folder::new()
        .with(name, bytes)
        .scene(&format!("[[surface]]\nname = 'room'\nmesh = {{ file = '{name}' }}\nreflectance = 0.5\n"))
}

fn lines(rows: impl IntoIterator<Item = String>) -> String {
    rows.into_iter().map(|r| r + "\n").collect()
}

fn obj(faces: &[Vec<usize>]) -> String {
    let vertices = CORNERS.iter().map(|[x, y, z]| format!("v {x} {y} {z}"));
    let faces = faces.iter().map(|f| {
        let corners: Vec<String> = f.iter().map(|k| (k + 1).to_string()).collect();
        format!("f {}", corners.join(" "))
    });
    lines(vertices.chain(faces))
}

fn stl(faces: &[[usize; 3]], shift: impl Fn(usize) -> f64) -> Vec<u8> {
    let mut out = vec![0; 80];
    out.extend((faces.len() as u32).to_le_bytes());
    for (k, f) in faces.iter().enumerate() {
        out.extend([0; 12]);
        for corner in f {
            CORNERS[*corner].iter().for_each(|x| out.extend(((x + shift(k)) as f32).to_le_bytes()));
        }
        out.extend([0; 2]);
    }
    out
}

fn ply(faces: &[Vec<usize>]) -> String {
    let head = format!(
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header",
        faces.len()
    );
    let vertices = CORNERS.iter().map(|[x, y, z]| format!("{x} {y} {z}"));
    let faces = faces.iter().map(|f| {
        let corners: Vec<String> = f.iter().map(usize::to_string).collect();
        format!("{} {}", f.len(), corners.join(" "))
    });
    lines(std::iter::once(head).chain(vertices).chain(faces))
}

fn vtp(faces: &[Vec<usize>]) -> String {
    let flat = |list: &mut dyn Iterator<Item = String>| list.collect::<Vec<_>>().join(" ");
    let points = flat(&mut CORNERS.iter().flatten().map(f64::to_string));
    let corners = flat(&mut faces.iter().flatten().map(usize::to_string));
    let mut end = 0;
    let ends = flat(&mut faces.iter().map(|f| {
        end += f.len();
        end.to_string()
    }));
    format!(
        "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"8\" NumberOfPolys=\"{}\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">{points}</DataArray></Points><Polys><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">{corners}</DataArray><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">{ends}</DataArray></Polys></Piece></PolyData></VTKFile>",
        faces.len()
    )
}

/// Six walls and two that repeat one of them, from another corner.
fn walls_twice() -> Vec<Vec<usize>> {
    let mut faces: Vec<Vec<usize>> = ROOM.iter().map(|f| f.to_vec()).collect();
    faces.push(ROOM[1].to_vec());
    let [a, b, c, d] = ROOM[3];
    faces.push(vec![b, c, d, a]);
    faces
}

fn assert_is_closed_room(s: &Scene, facets: usize, dropped: usize) {
    let kinds: Vec<(&str, Sides, bool)> =
        s.surfaces().iter().map(|s| (s.name.as_str(), s.sides, s.solid)).collect();
    assert_eq!(kinds, [("room", Sides::Front, false)], "{:?}", s.notes());
    assert_eq!(s.facets().len(), facets);
    let note = s.notes().iter().find(|n| n.code == "repeated-faces").expect("a note");
    assert!(!note.is_warning() && note.contains(&format!("{dropped} repeated face(s)")), "{note}");
}

// Guards (files): repeated faces of meshes are dropped in every format.
#[test]
fn repeated_faces_are_dropped_in_every_format() {
    let faces = walls_twice();
    assert_is_closed_room(&scene_of("a.obj", obj(&faces)), 6, 2);
    assert_is_closed_room(&scene_of("a.ply", ply(&faces)), 6, 2);
    assert_is_closed_room(&scene_of("a.vtp", vtp(&faces)), 6, 2);
    let mut soup = triangles(&ROOM);
    let [a, b, c] = soup[4];
    soup.extend([[a, b, c], [b, c, a], soup[7]]);
    assert_is_closed_room(&scene_of("a.stl", stl(&soup, |_| 0.0)), 12, 3);
    // Corners that differ by rounding, at a place where a grid of cells would separate them.
    for k in 0..40 {
        let offset = 0.123_456 + 1e-7 * f64::from(k);
        let noisy = stl(&soup, |face| offset + if face >= 12 { 1e-7 } else { 0.0 });
        assert_is_closed_room(&scene_of("a.stl", noisy), 12, 3);
    }
}

#[test]
fn polygons_that_begin_at_another_corner_are_repeated() {
    // A quadrilateral that is no parallelogram is cut along another diagonal.
    let text = "v 0 0 0\nv 2 0 0\nv 3 2 0\nv 0 1 0\nf 1 2 3 4\nf 2 3 4 1\nf 4 3 2 1\n";
    let s = scene_of("a.obj", text);
    // The third is the other side of the first: an open sheet whose two sides exchange.
    assert_eq!((s.facets().len(), s.surfaces()[0].sides), (2, Sides::Both), "{:?}", s.notes());
    assert!(s.notes().iter().any(|n| n.code == "opposite-faces"), "{:?}", s.notes());
    let one_sided = Folder::new()
        .with("a.obj", text)
        .scene("[[surface]]\nmesh = { file = 'a.obj' }\nreflectance = 0.5\nsides = 'front'\n");
    assert_eq!(one_sided.facets().len(), 4);
    let survey = zonal_scene::topology::survey(&one_sided);
    assert!(survey[0].contains("1 faces with the corners of another in reverse"), "{survey:?}");
}

#[test]
fn repeated_faces_of_other_materials_give_a_warning() {
    let faces = obj(&ROOM.map(|f| f.to_vec()));
    let s = scene_of("a.obj", format!("{faces}usemtl paint\nf 7 8 6 5\n"));
    let note = s.notes().iter().find(|n| n.code == "repeated-faces").expect("a warning");
    assert!(note.is_warning() && note.contains("'paint' over") && note.contains("omit"), "{note}");
    assert_eq!(s.facets().len(), 6);
    // A material that is left out repeats nothing.
    let folder = Folder::new().with("a.obj", format!("{faces}usemtl paint\nf 7 8 6 5\n"));
    let s = folder.scene(
        "[[surface]]\nname = 'room'\nmesh = { file = 'a.obj' }\nmaterials.paint.omit = true\nreflectance = 0.5\n",
    );
    assert!(s.notes().iter().all(|n| n.code != "repeated-faces"), "{:?}", s.notes());
}

#[test]
fn walls_on_walls_are_reported_and_t_junctions_close() {
    let open = |s: &Scene| {
        s.notes().iter().filter(|n| n.code == "open-mesh").map(|n| n.text.clone()).collect::<Vec<_>>()
    };
    // A partition whose edges are those of the walls.
    let mut faces: Vec<Vec<usize>> = ROOM.iter().map(|f| f.to_vec()).collect();
    faces.push(vec![0, 1, 7, 6]);
    let found = open(&scene_of("a.obj", obj(&faces)));
    assert!(found.len() == 1 && found[0].contains("two or more neighbours"), "{found:?}");
    // A wall of two halves beside a wall of one.
    let halves = "v 0.5 0 0\nv 0.5 1 0\nf 2 4 10 9\nf 9 10 3 1\n";
    let text = obj(&ROOM[1..].iter().map(|f| f.to_vec()).collect::<Vec<_>>()) + halves;
    let scene = scene_of("a.obj", text);
    assert!(open(&scene).is_empty() && scene.surfaces().len() == 1, "{:?}", scene.notes());
    assert_eq!(scene.surfaces()[0].sides, zonal_scene::Sides::Front);
    let survey = zonal_scene::topology::survey(&scene);
    assert!(survey[0].contains("T-junctions"), "{survey:?}");
    assert!(open(&scene_of("a.obj", obj(&walls_twice()))).is_empty());
}
