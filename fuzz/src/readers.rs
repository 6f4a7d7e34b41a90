//! Every reader, from memory. A refusal is one line that ends with a remedy; no reader panics.

use super::archive;
use super::drawing::{Packing, use_solution};
use std::io::Cursor;
use std::path::PathBuf;
use zonal_cli::commands::factors::factors_from_bytes;
use zonal_io::input::{
    FilesInMemory, parse_camera_path, read_scene_from_bytes, read_view3d_from_bytes,
    volume_materials_from_bytes,
};
use zonal_io::output;
use zonal_math::vec3;
use zonal_scene::{Camera, Lens, Scene};

/// Most cells of a medium.
const MAX_CELLS: usize = 1 << 12;
/// Most rows of a table of pairs.
const MAX_PAIRS: usize = 8;
/// Most frames of a flight whose shots are computed.
const MAX_FLIGHT_FRAMES: f64 = 1000.0;

/// A closed cube, for scenes that refer to `a.obj`.
const CUBE_OBJ: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nusemtl a\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nusemtl b\nf 3 4 8 7\nf 4 1 5 8\n";
/// The material library of the cube.
const CUBE_MTL: &str = "newmtl a\nKd 0.5 0.4 0.3\nnewmtl b\nKd 0.1 0.1 0.1\nKe 1 2 3\nmap_Kd a.png\n";

fn insert_file(files: &mut FilesInMemory, name: &str, bytes: impl Into<Vec<u8>>) {
    files.insert(PathBuf::from(name), bytes.into());
}

/// The files that scenes may refer to: `a.obj`, `a.mtl`, `a.npy`, `a.png`.
fn fixture_files() -> FilesInMemory {
    let mut files = FilesInMemory::new();
    insert_file(&mut files, "a.obj", CUBE_OBJ);
    insert_file(&mut files, "a.mtl", CUBE_MTL);
    insert_file(&mut files, "a.npy", npy_file([2, 2, 2], &[300.0, 400.0, 500.0, 600.0, 0.5, 1.0, 2.0, 3.0]));
    let grey: Vec<[f32; 3]> = (0..4).map(|i| [0.2 * i as f32; 3]).collect();
    insert_file(&mut files, "a.png", output::encode_png(2, 2, &grey).unwrap_or_default());
    files
}

/// An npy file of single-precision numbers.
fn npy_file(shape: [usize; 3], values: &[f32]) -> Vec<u8> {
    let mut text = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape:?}, }}")
        .replace('[', "(")
        .replace(']', ")");
    while (10 + text.len() + 1) % 64 != 0 {
        text.push(' ');
    }
    text.push('\n');
    let mut out = b"\x93NUMPY\x01\0".to_vec();
    out.extend((text.len() as u16).to_le_bytes());
    out.extend(text.as_bytes());
    values.iter().for_each(|v| out.extend(v.to_le_bytes()));
    out
}

/// Reads a scene; the message of a refusal must begin with the file name.
pub fn read_scene(text: &[u8], files: &FilesInMemory) -> Option<Scene> {
    match read_scene_from_bytes(text, files, "fuzz.toml", MAX_CELLS) {
        Ok(scene) => Some(scene),
        Err(e) => {
            let message = e.to_string();
            assert!(message.starts_with("fuzz.toml"), "a refusal without the file name: {message}");
            None
        }
    }
}

/// Reads a scene with fixtures beside it.
pub fn read_with_fixtures(text: &[u8]) -> Option<Scene> {
    read_scene(text, &fixture_files())
}

/// Target: the text of a scene.
pub fn scene(data: &[u8]) {
    if let Some(scene) = read_with_fixtures(data) {
        output::scene_hash(&scene);
    }
}

/// A scene with a mesh as surfaces and as a region of the medium.
const MESH_SCENE: &str = "[[surface]]\nname='m'\nmesh={file='FILE'}\n[medium]\nmin=[-2,-2,-2]\nmax=[2,2,2]\ncells=[3,3,3]\nextinction=1\n\
    [[medium.region]]\nmesh={file='FILE',rotate_degrees=[90,0,10]}\nextinction=2\n";

/// Reads a mesh as surfaces, and as surfaces and a region.
fn read_mesh(name: &str, files: &FilesInMemory) {
    let all = MESH_SCENE.replace("FILE", name);
    let surfaces = &all[..all.find("[medium]").unwrap_or(all.len())];
    if read_scene(surfaces.as_bytes(), files).is_some() {
        read_scene(all.as_bytes(), files);
    }
}

/// Target: an OBJ file, and behind a line `#mtl` its material library.
pub fn obj(data: &[u8]) {
    let mark = b"\n#mtl\n";
    let cut = data.windows(mark.len()).position(|w| w == mark);
    let (text, library) = match cut {
        Some(at) => (&data[..at], &data[at + mark.len()..]),
        None => (data, CUBE_MTL.as_bytes()),
    };
    let mut files = fixture_files();
    insert_file(&mut files, "a.obj", text);
    insert_file(&mut files, "a.mtl", library);
    read_mesh("a.obj", &files);
}

/// Target: an STL file, as it is; its length decides whether it is text.
pub fn stl(data: &[u8]) {
    let mut files = fixture_files();
    insert_file(&mut files, "a.stl", data);
    read_mesh("a.stl", &files);
}

/// Target: a PLY file.
pub fn ply(data: &[u8]) {
    let mut files = fixture_files();
    insert_file(&mut files, "a.ply", data);
    read_mesh("a.ply", &files);
}

/// Target: a file of Gmsh.
pub fn msh(data: &[u8]) {
    let mut files = fixture_files();
    insert_file(&mut files, "a.msh", data);
    read_mesh("a.msh", &files);
}

/// Target: an input file of View3D.
pub fn view3d(data: &[u8]) {
    let file = match read_view3d_from_bytes(data, "fuzz.vs3") {
        Ok(file) => file,
        Err(e) => {
            let message = e.to_string();
            assert!(
                message.starts_with("fuzz.vs3") && message.contains(';'),
                "no place or remedy: {message}"
            );
            return;
        }
    };
    let n = file.surfaces.len();
    for s in &file.surfaces {
        assert!(matches!(s.corners.len(), 3 | 4) && s.corners.iter().all(|p| p.is_finite()), "{s:?}");
        assert!(s.emissivity > 0.0 && s.emissivity < 1.0, "{s:?}");
        assert!(s.base.into_iter().chain(s.combined_with).all(|k| k < n), "{s:?}");
    }
}

/// Target: a glTF or GLB file.
pub fn gltf(data: &[u8]) {
    let mut files = fixture_files();
    insert_file(&mut files, "a.bin", [0, 0, 128, 63].repeat(64));
    insert_file(&mut files, "a.glb", data);
    let _ = volume_materials_from_bytes(data);
    read_mesh("a.glb", &files);
}

/// A scene with a density array.
const DENSITY_SCENE: &str = "[medium]\nmin=[0,0,0]\nmax=[8,4,4]\ncells=[8,4,4]\nextinction=0.5\n[[medium.region]]\n\
    density={file='a.data',MORE}\n";
/// Keys that place a density array in a box.
const DENSITY_PLACEMENT: &str = "min=[0.5,-1,0],max=[7,5,1],scale=[1,2,0.5]";

/// Reads an array as a density, with each of several placements.
fn read_density(data: &[u8], more: &[&str]) {
    let mut files = FilesInMemory::new();
    insert_file(&mut files, "a.data", data);
    for more in more {
        read_scene(DENSITY_SCENE.replace("MORE", more).as_bytes(), &files);
    }
}

/// Target: an OpenVDB file, as it is and rotated about its own axes.
pub fn vdb(data: &[u8]) {
    if !data.starts_with(&[0x20, 0x42, 0x44, 0x56]) {
        return;
    }
    read_density(data, &["", "rotate_degrees=[10,20,30],translate=[1,0,0],level_set=true"]);
}

/// Target: a numpy array, as a density and as temperatures.
pub fn npy(data: &[u8]) {
    if data.starts_with(b"VOL") || data.starts_with(&[0x20, 0x42, 0x44, 0x56]) {
        return;
    }
    read_density(data, &[DENSITY_PLACEMENT]);
    let mut files = FilesInMemory::new();
    insert_file(&mut files, "a.npy", data);
    let text = "mode='thermal'\n[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[2,2,3]\nextinction=1\n\
                temperature={file='a.npy'}\n";
    read_scene(text.as_bytes(), &files);
}

/// Target: a Mitsuba grid volume.
pub fn vol(data: &[u8]) {
    if data.starts_with(b"VOL") {
        read_density(data, &["", DENSITY_PLACEMENT]);
    }
}

fn read_texture(data: &[u8]) {
    let mut files = FilesInMemory::new();
    insert_file(&mut files, "a.png", data);
    let text = "[[surface]]\nrectangle={origin=[0,0,0],edge1=[1,0,0],edge2=[0,1,0]}\ntexture='a.png'\n";
    if let Some(scene) = read_scene(text.as_bytes(), &files) {
        scene.reflectance_at(0, 0.3, 0.7);
    }
}

/// Target: a PNG picture, with its checksums corrected.
pub fn png(data: &[u8]) {
    if data.starts_with(b"\x89PNG") {
        let repaired = archive::repair_png(data);
        read_texture(&repaired);
        output::read_png_text_from(Cursor::new(repaired), "exposure");
    }
}

/// Target: a JPEG picture.
pub fn jpeg(data: &[u8]) {
    if data.starts_with(b"\xff\xd8") {
        read_texture(data);
    }
}

/// Target: an OpenEXR picture, of light and of one field.
pub fn exr(data: &[u8]) {
    if data.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        let _ = output::read_exr_from_bytes(data);
        let _ = output::read_exr_field_from_bytes(data);
    }
}

/// Target: a solution, as it is and as a zip rewritten around its entries. An accepted solution is used.
pub fn npz(data: &[u8]) {
    // Packing takes a hundred times as long as the rest.
    let packing = if data.iter().fold(0u8, |n, b| n.rotate_left(1) ^ b) % 64 == 0 {
        Packing::Packed
    } else {
        Packing::Skipped
    };
    if let Ok(solution) = output::read_solution_from_bytes(data) {
        use_solution(solution, packing);
        return;
    }
    let Some(repaired) = archive::repair_zip(data) else { return };
    if let Ok(solution) = output::read_solution_from_bytes(&repaired) {
        use_solution(solution, packing);
    }
}

/// Target: key frames of a flight through a scene with one camera and two light groups.
pub fn flight(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let camera = Camera {
        name: "door".into(),
        origin: vec3(1.0, 2.0, 3.0),
        target: vec3(0.0, 9.0, 3.0),
        up: vec3(0.0, 0.0, 1.0),
        fov: 50.0,
        lens: Lens { aperture: 0.1, focus: Some(4.0) },
    };
    match parse_camera_path(text, "fuzz.toml", &[camera], &["sun", "lamp"]) {
        Ok(flight) => {
            let seconds = flight.keys.last().map_or(0.0, |k| k.time) - flight.keys[0].time;
            if seconds * flight.frames_per_second >= MAX_FLIGHT_FRAMES {
                return;
            }
            let shots = zonal_cli::camera_animation::animation_frames(&flight);
            assert!(shots.len() <= zonal_io::input::MAX_FRAMES);
        }
        Err(e) => assert!(e.to_string().starts_with("fuzz.toml"), "a refusal without the file name: {e}"),
    }
}

/// Target: a table of pairs, with the values of its first rows.
pub fn factors(data: &[u8]) {
    let rows: Vec<&[u8]> = data.split_inclusive(|b| *b == b'\n').take(MAX_PAIRS + 1).collect();
    let Ok(table) = factors_from_bytes(&rows.concat(), 1e-3) else { return };
    let text = String::from_utf8_lossy(&table.csv).into_owned();
    // A quoted name may contain line ends.
    let mut quoted = false;
    let rows = text.split(|c| {
        quoted ^= c == '"';
        c == '\n' && !quoted
    });
    for row in rows.skip(1) {
        let mut cells = row.trim_end().rsplit(',').skip(2);
        let (bound, value) = (cells.next().unwrap_or(""), cells.next().unwrap_or(""));
        if let (Ok(bound), Ok(value)) = (bound.parse::<f64>(), value.parse::<f64>()) {
            assert!(value.is_finite() && value >= 0.0 && bound >= 0.0, "{row}");
        }
    }
}

/// Target: a browser's request to the viewer.
pub fn request(data: &[u8]) {
    if let Some(end) = zonal_cli::viewer::request::header_length(data) {
        let _ = zonal_cli::viewer::request::parse(&data[..end.min(data.len())], 8000);
    }
}
