//! Every reader, from memory. Refusals are one line that ends with what to do; nothing panics.

use super::{archive, solving};
use std::io::Cursor;
use std::path::PathBuf;
use zonal::commands::factors::values_from_bytes;
use zonal::io::input::{FilesInMemory, parse_flight, read_scene_from_bytes, volume_materials_from_bytes};
use zonal::io::output;
use zonal::math::vec3;
use zonal::scene::{Camera, Lens, Scene};

/// The most cells of a medium that is read here.
const CELLS: usize = 1 << 12;
/// The most rows of a table of pairs.
const PAIRS: usize = 8;
/// Flights of more frames are read only.
const FRAMES: f64 = 1000.0;

/// A closed cube, for scenes that name `a.obj`.
const CUBE: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nusemtl a\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nusemtl b\nf 3 4 8 7\nf 4 1 5 8\n";
const LIBRARY: &str = "newmtl a\nKd 0.5 0.4 0.3\nnewmtl b\nKd 0.1 0.1 0.1\nKe 1 2 3\nmap_Kd a.png\n";

fn put(files: &mut FilesInMemory, name: &str, bytes: impl Into<Vec<u8>>) {
    files.insert(PathBuf::from(name), bytes.into());
}

/// The files that scenes may name: `a.obj`, `a.mtl`, `a.npy`, `a.png`.
fn fixtures() -> FilesInMemory {
    let mut files = FilesInMemory::new();
    put(&mut files, "a.obj", CUBE);
    put(&mut files, "a.mtl", LIBRARY);
    put(&mut files, "a.npy", array([2, 2, 2], &[300.0, 400.0, 500.0, 600.0, 0.5, 1.0, 2.0, 3.0]));
    let grey: Vec<[f32; 3]> = (0..4).map(|i| [0.2 * i as f32; 3]).collect();
    put(&mut files, "a.png", output::encode_png(2, 2, &grey).unwrap_or_default());
    files
}

/// An npy file of singles.
fn array(shape: [usize; 3], values: &[f32]) -> Vec<u8> {
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

/// Reads a scene; a refusal has to name the file and to be one line.
pub fn read(text: &[u8], files: &FilesInMemory) -> Option<Scene> {
    match read_scene_from_bytes(text, files, "fuzz.toml", CELLS) {
        Ok(scene) => Some(scene),
        Err(e) => {
            let message = e.to_string();
            assert!(message.starts_with("fuzz.toml"), "a refusal without its file: {message}");
            None
        }
    }
}

/// Reads a scene with fixtures beside it.
pub fn read_with_fixtures(text: &[u8]) -> Option<Scene> {
    read(text, &fixtures())
}

/// A scene's text.
pub fn scene(data: &[u8]) {
    if let Some(scene) = read_with_fixtures(data) {
        output::scene_hash(&scene);
    }
}

const MESH: &str = "[[surface]]\nname='m'\nmesh={file='FILE'}\n[medium]\nmin=[-2,-2,-2]\nmax=[2,2,2]\ncells=[3,3,3]\nextinction=1\n\
    [[medium.region]]\nmesh={file='FILE',rotate_degrees=[90,0,10]}\nextinction=2\n";

/// The mesh as surfaces, and as surfaces beside a region.
fn mesh(name: &str, files: &FilesInMemory) {
    let all = MESH.replace("FILE", name);
    let surfaces = &all[..all.find("[medium]").unwrap_or(all.len())];
    if read(surfaces.as_bytes(), files).is_some() {
        read(all.as_bytes(), files);
    }
}

/// An OBJ file, and behind a line `#mtl` its material library.
pub fn obj(data: &[u8]) {
    let mark = b"\n#mtl\n";
    let cut = data.windows(mark.len()).position(|w| w == mark);
    let (text, library) = match cut {
        Some(at) => (&data[..at], &data[at + mark.len()..]),
        None => (data, LIBRARY.as_bytes()),
    };
    let mut files = fixtures();
    put(&mut files, "a.obj", text);
    put(&mut files, "a.mtl", library);
    mesh("a.obj", &files);
}

/// A glTF or GLB file.
pub fn gltf(data: &[u8]) {
    let mut files = fixtures();
    put(&mut files, "a.bin", [0, 0, 128, 63].repeat(64));
    put(&mut files, "a.glb", data);
    let _ = volume_materials_from_bytes(data);
    mesh("a.glb", &files);
}

const ARRAY: &str = "[medium]\nmin=[0,0,0]\nmax=[8,4,4]\ncells=[8,4,4]\nextinction=0.5\n[[medium.region]]\n\
    density={file='a.data',MORE}\n";
const PLACED: &str = "min=[0.5,-1,0],max=[7,5,1],scale=[1,2,0.5]";

fn field(data: &[u8], more: &[&str]) {
    let mut files = FilesInMemory::new();
    put(&mut files, "a.data", data);
    for more in more {
        read(ARRAY.replace("MORE", more).as_bytes(), &files);
    }
}

/// An OpenVDB file: as it lies, and turned about its own axes.
pub fn vdb(data: &[u8]) {
    if !data.starts_with(&[0x20, 0x42, 0x44, 0x56]) {
        return;
    }
    field(data, &["", "rotate_degrees=[10,20,30],translate=[1,0,0],level_set=true"]);
}

/// A numpy array, as a density and as temperatures.
pub fn npy(data: &[u8]) {
    if data.starts_with(b"VOL") || data.starts_with(&[0x20, 0x42, 0x44, 0x56]) {
        return;
    }
    field(data, &[PLACED]);
    let mut files = FilesInMemory::new();
    put(&mut files, "a.npy", data);
    let text = "mode='thermal'\n[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[2,2,3]\nextinction=1\n\
                temperature={file='a.npy'}\n";
    read(text.as_bytes(), &files);
}

/// A grid volume of Mitsuba's.
pub fn vol(data: &[u8]) {
    if data.starts_with(b"VOL") {
        field(data, &["", PLACED]);
    }
}

fn picture(data: &[u8]) {
    let mut files = FilesInMemory::new();
    put(&mut files, "a.png", data);
    let text = "[[surface]]\nrectangle={origin=[0,0,0],edge1=[1,0,0],edge2=[0,1,0]}\ntexture='a.png'\n";
    if let Some(scene) = read(text.as_bytes(), &files) {
        scene.reflectance_at(0, 0.3, 0.7);
    }
}

/// A PNG picture, with its checksums put right.
pub fn png(data: &[u8]) {
    if data.starts_with(b"\x89PNG") {
        let mended = archive::png(data);
        picture(&mended);
        output::png_note_from(Cursor::new(mended), "exposure");
    }
}

/// A JPEG picture.
pub fn jpeg(data: &[u8]) {
    if data.starts_with(b"\xff\xd8") {
        picture(data);
    }
}

/// An OpenEXR picture, of light and of one field.
pub fn exr(data: &[u8]) {
    if data.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        let _ = output::read_exr_from_bytes(data);
        let _ = output::read_exr_field_from_bytes(data);
    }
}

/// A solution: as it is, and as a zip written anew around its entries. What is accepted is used.
pub fn npz(data: &[u8]) {
    // Packing takes a hundred times as long as all else.
    let packed = data.iter().fold(0u8, |n, b| n.rotate_left(1) ^ b) % 64 == 0;
    if let Ok(solution) = output::read_solution_from_bytes(data) {
        solving::use_solution(solution, packed);
        return;
    }
    let Some(mended) = archive::zip(data) else { return };
    if let Ok(solution) = output::read_solution_from_bytes(&mended) {
        solving::use_solution(solution, packed);
    }
}

/// Key frames of a flight through a scene with one camera and two light groups.
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
    match parse_flight(text, "fuzz.toml", &[camera], &["sun", "lamp"]) {
        Ok(flight) => {
            let seconds = flight.keys.last().map_or(0.0, |k| k.time) - flight.keys[0].time;
            if seconds * flight.frames_per_second >= FRAMES {
                return;
            }
            let shots = zonal::flight::shots(&flight);
            assert!(shots.len() <= zonal::io::input::MAX_FRAMES);
        }
        Err(e) => assert!(e.to_string().starts_with("fuzz.toml"), "a refusal without its file: {e}"),
    }
}

/// A table of pairs, with the values of the first few.
pub fn factors(data: &[u8]) {
    let rows: Vec<&[u8]> = data.split_inclusive(|b| *b == b'\n').take(PAIRS + 1).collect();
    let Ok(table) = values_from_bytes(&rows.concat(), 1e-3) else { return };
    let text = String::from_utf8_lossy(&table.csv).into_owned();
    // A name between quotation marks may hold line ends.
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

/// What a browser sends to the viewer.
pub fn request(data: &[u8]) {
    if let Some(end) = zonal::viewer::request::end_of(data) {
        let _ = zonal::viewer::request::parse(&data[..end.min(data.len())], 8000);
    }
}
