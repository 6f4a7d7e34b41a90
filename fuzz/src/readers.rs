//! Every reader, from memory. A refusal is one line that ends with a remedy; no reader panics.

use super::archive;
use super::drawing::{Packing, use_solution};
use super::files::{fixture_files, insert_file, read_mesh, read_scene, read_with_fixtures};
use std::io::Cursor;
use std::sync::atomic::{AtomicUsize, Ordering};
use zonal_app::pages::viewer::request;
use zonal_app::pairs::pair_table::factors_from_bytes;
use zonal_app::pictures::animation_frames;
use zonal_app::scene_proposal::{ModelOptions, propose};
use zonal_io::input::{FilesInMemory, parse_camera_path, read_view3d_from_bytes};
use zonal_io::output;
use zonal_scene::{Camera, Lens};

/// Most rows of a table of pairs.
const MAX_PAIRS: usize = 8;
/// Most frames of a flight whose shots are computed.
const MAX_FLIGHT_FRAMES: f64 = 1000.0;

/// Target: the text of a scene.
pub fn scene(data: &[u8]) {
    if let Some(scene) = read_with_fixtures(data) {
        output::scene_hash(&scene);
    }
}

/// Extensions of mesh files.
const MESH_EXTENSIONS: [&str; 8] = ["obj", "stl", "ply", "glb", "gltf", "msh", "vtu", "vtp"];

/// Target: the scene that `zonal init` proposes for a mesh file; the first byte chooses its format. The file is written to the folder of temporary files.
pub fn init(data: &[u8]) {
    let Some((kind, data)) = data.split_first() else { return };
    let extension = MESH_EXTENSIONS[usize::from(kind % 8)];
    // Several threads of one process may run the target at the same time.
    static RUNS: AtomicUsize = AtomicUsize::new(0);
    let run = RUNS.fetch_add(1, Ordering::Relaxed);
    let folder = std::env::temp_dir().join(format!("zonal-fuzz-{}-{run}", std::process::id()));
    let path = folder.join(format!("a.{extension}"));
    std::fs::create_dir_all(&folder).expect("a temporary folder");
    std::fs::write(&path, data).expect("a temporary file");
    let options = ModelOptions { unit: None, up: None, patches: 100 };
    match propose(&path, &folder, &options) {
        Ok(p) => assert!(p.scene.facets().iter().all(|f| f.plate.area().is_finite())),
        Err(e) => {
            let message = e.to_string();
            assert!(message.contains("a."), "a refusal without the file name: {message}");
        }
    }
    let _ = std::fs::remove_file(&path);
    let _ = std::fs::remove_dir(&folder);
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

/// Target: an OpenEXR picture of light.
pub fn exr(data: &[u8]) {
    if data.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        let _ = output::read_exr_from_bytes(data);
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
        fov: 50.0,
        lens: Lens { aperture: 0.1, focus: Some(4.0) },
        ..Camera::look_at([1.0, 2.0, 3.0], [0.0, 9.0, 3.0]).name("door")
    };
    match parse_camera_path(text, "fuzz.toml", &[camera], &["sun", "lamp"]) {
        Ok(flight) => {
            let seconds = flight.keys.last().map_or(0.0, |k| k.time) - flight.keys[0].time;
            if seconds * flight.frames_per_second >= MAX_FLIGHT_FRAMES {
                return;
            }
            let shots = animation_frames(&flight);
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
    if let Some(end) = request::header_length(data) {
        let _ = request::parse(&data[..end.min(data.len())], 8000);
    }
}
