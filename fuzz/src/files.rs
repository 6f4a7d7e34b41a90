//! Readers of files that scenes refer to, from memory: meshes, tables, arrays of gases, lights. A refusal is one line that begins with the name of the
//! scene; no reader panics. These functions need the crates of scenes and files only, so that `crates/io/tests/mutated_files.rs` runs them, too.

use std::path::PathBuf;
use zonal_io::input::{FilesInMemory, read_scene_from_bytes};
use zonal_io::output;
use zonal_math::vec3;
use zonal_scene::{Light, Scene};

/// Most cells of a medium.
const MAX_CELLS: usize = 1 << 12;
/// A closed cube, for scenes that refer to `a.obj`.
const CUBE_OBJ: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nusemtl a\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nusemtl b\nf 3 4 8 7\nf 4 1 5 8\n";
/// The material library of the cube.
const CUBE_MTL: &str = "newmtl a\nKd 0.5 0.4 0.3\nnewmtl b\nKd 0.1 0.1 0.1\nKe 1 2 3\nmap_Kd a.png\n";

/// Adds a file in memory.
pub fn insert_file(files: &mut FilesInMemory, name: &str, bytes: impl Into<Vec<u8>>) {
    files.insert(PathBuf::from(name), bytes.into());
}

/// The files that scenes may refer to: `a.obj`, `a.mtl`, `a.npy`, `a.png`.
pub fn fixture_files() -> FilesInMemory {
    let mut files = FilesInMemory::new();
    insert_file(&mut files, "a.obj", CUBE_OBJ);
    insert_file(&mut files, "a.mtl", CUBE_MTL);
    insert_file(&mut files, "a.npy", npy_file([2, 2, 2], &[300.0, 400.0, 500.0, 600.0, 0.5, 1.0, 2.0, 3.0]));
    let grey: Vec<[f32; 3]> = (0..4).map(|i| [0.2 * i as f32; 3]).collect();
    insert_file(&mut files, "a.png", output::encode_png(2, 2, &grey).unwrap_or_default());
    files
}

/// An npy file of single-precision numbers.
pub fn npy_file(shape: [usize; 3], values: &[f32]) -> Vec<u8> {
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

/// A scene with a mesh as surfaces and as a region of the medium.
const MESH_SCENE: &str = "[[surface]]\nname='m'\nmesh={file='FILE'}\n[medium]\nmin=[-2,-2,-2]\nmax=[2,2,2]\ncells=[3,3,3]\nextinction=1\n\
    [[medium.region]]\nmesh={file='FILE',rotate_degrees=[90,0,10]}\nextinction=2\n";

/// Reads a mesh as surfaces, and as surfaces and a region.
pub fn read_mesh(name: &str, files: &FilesInMemory) {
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

/// Target: a file of VTK, as an unstructured grid or as polygons, and as temperatures of the faces of a cube.
pub fn vtk(data: &[u8]) {
    for name in ["a.vtu", "a.vtp"] {
        let mut files = fixture_files();
        insert_file(&mut files, name, data);
        read_mesh(name, &files);
        read_scene(FACE_SCENE.replace("FILE", name).as_bytes(), &files);
    }
}

/// A cube with a temperature by face.
const FACE_SCENE: &str = "mode='thermal'\n[[surface]]\nname='m'\nmesh={file='a.obj'}\nemissivity=0.5\ntemperature={file='FILE',column='T'}\n";

/// Target: a table of temperatures, by face or by material of a cube; the first byte chooses the kind of the file.
pub fn face_table(data: &[u8]) {
    let Some((kind, data)) = data.split_first() else { return };
    let mut files = fixture_files();
    let name = ["t.csv", "t.npy", "t.txt", "t.vtp"][usize::from(kind % 4)];
    insert_file(&mut files, name, data);
    let by_face = FACE_SCENE.replace("FILE", name);
    read_scene(by_face.as_bytes(), &files);
    read_scene(by_face.replace("column='T'", "column=1").as_bytes(), &files);
    read_scene(by_face.replace("column='T'", "by='material'").as_bytes(), &files);
    read_scene(
        by_face
            .replace("temperature=", "emissivity=")
            .replace("emissivity=0.5", "temperature=300")
            .as_bytes(),
        &files,
    );
}

/// A gas whose composition, pressure and temperature are arrays.
const GAS_SCENE: &str = "mode='thermal'\n[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[2,2,3]\ntemperature={file='t.npy',scale=900}\n\
    gas={model='wsgg-bordbar-2020',h2o={file='a.npy'},co2={file='a.npy',scale=0.5},soot={file='a.npy',scale=1e-7},pressure={file='t.npy',scale=1e5}}\n";

/// Target: a numpy array as the composition, the pressure and the temperature of a gas.
pub fn gas_array(data: &[u8]) {
    if data.starts_with(b"VOL") || data.starts_with(&[0x20, 0x42, 0x44, 0x56]) {
        return;
    }
    let one = npy_file([1, 1, 1], &[1.0]);
    for (a, t) in [(data, one.as_slice()), (one.as_slice(), data), (data, data)] {
        let mut files = FilesInMemory::new();
        insert_file(&mut files, "a.npy", a);
        insert_file(&mut files, "t.npy", t);
        read_scene(GAS_SCENE.as_bytes(), &files);
    }
}

/// Target: a photometric file, as IES LM-63 and as EULUMDAT, aimed down and to the side.
pub fn luminaire(data: &[u8]) {
    for name in ["a.ies", "a.ldt"] {
        let mut files = FilesInMemory::new();
        insert_file(&mut files, name, data);
        for direction in ["[0,0,-1]", "[1,0.2,-0.3]"] {
            let text = format!(
                "[[surface]]\nrectangle={{origin=[0,0,0],edge1=[1,0,0],edge2=[0,1,0]}}\n[[light]]\nkind='luminaire'\nfile='{name}'\nposition=[0,0,2]\ndirection={direction}\nrotation=30\n"
            );
            if let Some(scene) = read_scene(text.as_bytes(), &files) {
                check_point_lights(&scene);
            }
        }
    }
}

/// Relative intensities are finite and at least 0 in all directions.
fn check_point_lights(scene: &Scene) {
    for light in scene.lights() {
        let Light::Point { distribution, .. } = light else { continue };
        for k in 0..24 {
            let (turn, height) = (2.4 * f64::from(k), f64::from(k) / 11.5 - 1.0);
            let across = (1.0 - height * height).max(0.0).sqrt();
            let x = distribution.relative(vec3(across * turn.cos(), across * turn.sin(), height));
            assert!(x.is_finite() && x >= 0.0, "a relative intensity is {x}");
        }
    }
}

/// Target: a picture of Radiance as a sky.
pub fn hdr(data: &[u8]) {
    let mut files = FilesInMemory::new();
    insert_file(&mut files, "a.hdr", data);
    let text = "[[surface]]\nrectangle={origin=[0,0,0],edge1=[1,0,0],edge2=[0,1,0]}\n[[light]]\nkind='image-sky'\nimage='a.hdr'\n";
    if let Some(scene) = read_scene(text.as_bytes(), &files) {
        for light in scene.lights() {
            let Light::Sky { distribution, .. } = light else { continue };
            let x = distribution.relative(vec3(0.3, 0.4, 0.5).normalized());
            assert!(x.into_iter().all(|x| x.is_finite() && x >= 0.0), "a relative radiance is {x:?}");
        }
    }
}
