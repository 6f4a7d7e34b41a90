//! Scenes and files in memory, and files that would take more memory than they pay for.

use crate::support;

use std::path::PathBuf;
use support::png;
use zonal_io::input::{FilesInMemory, read_scene_from_bytes};

fn read(text: &str, files: &[(&str, &[u8])], most_cells: usize) -> Result<usize, String> {
    let files: FilesInMemory = files.iter().map(|(n, b)| (PathBuf::from(n), b.to_vec())).collect();
    let scene = read_scene_from_bytes(text.as_bytes(), &files, "m.toml", most_cells);
    scene.map(|s| s.facets().len()).map_err(|e| e.to_string())
}

const MESH: &str = "[[surface]]\nmesh={file='sub/a.obj'}\n";
const OBJ: &[u8] = b"mtllib a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n";

#[test]
fn files_in_memory_are_read_and_those_on_disk_are_not() {
    assert_eq!(read(MESH, &[("sub/a.obj", OBJ), ("sub/a.mtl", b"newmtl a\nKd 1 1 1\n")], 1), Ok(1));
    let missing = read(MESH, &[("a.obj", OBJ)], 1).unwrap_err();
    assert!(missing.starts_with("m.toml:2:12") && missing.contains("no such file"), "{missing}");
    // A file on disk is not one in memory.
    let here = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
    let e = read(&format!("[[surface]]\nmesh={{file='{here}.obj'}}"), &[], 1).unwrap_err();
    assert!(e.contains("no such file"), "{e}");
    let e = read_scene_from_bytes(b"name = \"\xff\"", &FilesInMemory::new(), "m.toml", 1).unwrap_err();
    assert!(e.to_string().contains("UTF-8"), "{e}");
}

#[test]
fn the_number_of_cells_is_bounded() {
    let text = "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[3,3,3]\nextinction=1\n";
    assert_eq!(read(text, &[], 27), Ok(0));
    let e = read(text, &[], 26).unwrap_err();
    assert!(e.starts_with("m.toml:4:7: medium.cells") && e.contains("more than the 26"), "{e}");
}

/// A glTF text of so many nodes that show one mesh, whose positions are so many zeros, of which one has data.
fn zeros(nodes: usize, count: usize) -> String {
    let list = vec![r#"{"mesh":0}"#; nodes].join(",");
    format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{list}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "buffers":[{{"byteLength":12,"uri":"data:;base64,AAAAAAAAAAAAAAAA"}}],
        "bufferViews":[{{"buffer":0,"byteLength":12}}],
        "accessors":[{{"componentType":5126,"type":"VEC3","count":{count},"sparse":{{"count":1,
        "indices":{{"bufferView":0,"componentType":5121}},"values":{{"bufferView":0}}}}}}]}}"#
    )
}

// Guards (files): no file makes the program allocate memory out of proportion to its size.
#[test]
fn memory_of_meshes_is_bounded_by_their_size() {
    let text = "[[surface]]\nmesh={file='a.gltf'}\n";
    // Six hundred bytes that stand for 1.6 GB of positions, and 12 GB of faces.
    let e = read(text, &[("a.gltf", zeros(1, 60_000_000).as_bytes())], 1).unwrap_err();
    assert!(e.contains("accessor 0") && e.contains("too large"), "{e}");
    // As many zeros as bytes are read, and the faces without area that they make.
    let e = read(text, &[("a.gltf", zeros(1, 30).as_bytes())], 1).unwrap_err();
    assert!(e.contains("without area"), "{e}");
    // Sixty kilobytes whose nodes show 250 million corners.
    let e = read(text, &[("a.gltf", zeros(5000, 50_000).as_bytes())], 1).unwrap_err();
    assert!(e.contains("more than are read"), "{e}");
}

// Guards (files): no file makes the program allocate memory out of proportion to its size.
#[test]
fn memory_of_images_is_bounded_by_their_size() {
    let text = "[[surface]]\nrectangle={origin=[0,0,0],edge1=[1,0,0],edge2=[0,1,0]}\ntexture='a'\n";
    let small = png(4, 4, &[200; 48]);
    assert_eq!(read(text, &[("a", &small)], 1), Ok(1));
    // The header alone says 8000 × 8000; its checksum is that of the header.
    let mut header = small[..33].to_vec();
    header[16..24].copy_from_slice(&[0, 0, 0x1f, 0x40, 0, 0, 0x1f, 0x40]);
    let mut sum = flate2::Crc::new();
    sum.update(&header[12..29]);
    header[29..33].copy_from_slice(&sum.sum().to_be_bytes());
    let e = read(text, &[("a", &[&header[..], &small[33..]].concat())], 1).unwrap_err();
    assert!(e.contains("64000000 pixels") && e.contains("cannot hold"), "{e}");
    let mut jpeg = include_bytes!("../../../fuzz/corpus/jpeg/base.jpg").to_vec();
    assert_eq!(read(text, &[("a", &jpeg)], 1), Ok(1));
    let frame = jpeg.windows(2).position(|w| w == [0xff, 0xc0]).unwrap();
    jpeg[frame + 5..frame + 9].copy_from_slice(&[0x1f, 0x40, 0x1f, 0x40]);
    let e = read(text, &[("a", &jpeg)], 1).unwrap_err();
    assert!(e.contains("64000000 pixels") && e.contains("cannot hold"), "{e}");
}

/// A file of VTK with one compressed array of `points` points of one byte: `blocks` blocks of `block` zeros.
fn zlib_bomb(points: usize, blocks: usize, block: usize) -> Vec<u8> {
    use std::io::Write;
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    encoder.write_all(&vec![0; block]).unwrap();
    let packed = encoder.finish().unwrap();
    let head = format!(
        "<VTKFile type=\"UnstructuredGrid\" header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"><UnstructuredGrid><Piece NumberOfPoints=\"{points}\" NumberOfCells=\"1\"><Points><DataArray type=\"UInt8\" NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/></Points><Cells><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 2</DataArray><DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">3</DataArray><DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">5</DataArray></Cells></Piece></UnstructuredGrid><AppendedData encoding=\"raw\">_"
    );
    let mut out = head.into_bytes();
    let words = [blocks, block, 0].into_iter().chain(vec![packed.len(); blocks]);
    words.for_each(|n| out.extend((n as u64).to_le_bytes()));
    (0..blocks).for_each(|_| out.extend(&packed));
    out
}

// Guards (files): no file makes the program allocate memory out of proportion to its size.
#[test]
fn memory_of_compressed_arrays_is_bounded_by_their_size() {
    let text = "[[surface]]\nmesh={file='a.vtu'}\n";
    // Declared and stored sizes differ: refused before a block is unpacked.
    let e = read(text, &[("a.vtu", &zlib_bomb(3, 50, 1 << 20))], 1).unwrap_err();
    assert!(e.contains("52428800 values where 9 are declared"), "{e}");
    // Consistent sizes that the file cannot justify.
    let points = (50 << 20) / 3 + 1;
    let e = read(text, &[("a.vtu", &zlib_bomb(points, 50, 1 << 20))], 1).unwrap_err();
    assert!(e.contains("more than the") && e.contains("can justify"), "{e}");
}

#[test]
fn whole_numbers_out_of_range_are_refused() {
    let file = |corners: [u64; 3], ends: u64| {
        let bytes = |list: &[u64]| -> Vec<u8> {
            let length = (8 * list.len() as u32).to_le_bytes();
            length.into_iter().chain(list.iter().flat_map(|n| n.to_le_bytes())).collect()
        };
        let (corners, ends) = (bytes(&corners), bytes(&[ends]));
        let head = format!(
            "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"3\" NumberOfCells=\"1\"><Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0</DataArray></Points><Cells><DataArray type=\"UInt64\" Name=\"connectivity\" format=\"appended\" offset=\"0\"/><DataArray type=\"UInt64\" Name=\"offsets\" format=\"appended\" offset=\"{}\"/><DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">5</DataArray></Cells></Piece></UnstructuredGrid><AppendedData encoding=\"raw\">_",
            corners.len()
        );
        [head.into_bytes(), corners, ends].concat()
    };
    let text = "[[surface]]\nmesh={file='a.vtu'}\n";
    let read_one = |bytes: Vec<u8>| read(text, &[("a.vtu", &bytes)], 1);
    assert_eq!(read_one(file([0, 1, 2], 3)), Ok(1));
    // 3 · (2⁶⁴/3 + 1) wraps to a small number.
    for index in [3, 1 << 53, 1 << 62, u64::MAX / 3 + 1, u64::MAX] {
        let e = read_one(file([0, 1, index], 3)).unwrap_err();
        assert!(e.contains("out of range") || e.contains("none of the 3 points"), "{index}: {e}");
        assert!(read_one(file([0, 1, 2], index.max(4))).is_err());
    }
}

#[test]
fn bytes_behind_a_file_are_notes() {
    let mut array = npy_of_ones();
    let text = "mode='thermal'\n[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[1,1,1]\nextinction=1\ntemperature={file='a.npy',scale=300}\n";
    let notes = |array: &[u8]| {
        let files: FilesInMemory = [(PathBuf::from("a.npy"), array.to_vec())].into_iter().collect();
        let scene = read_scene_from_bytes(text.as_bytes(), &files, "m.toml", 8).unwrap();
        scene.notes().iter().map(|n| n.to_string()).collect::<Vec<_>>()
    };
    assert!(notes(&array).is_empty());
    array.extend([1, 2, 3]);
    assert_eq!(notes(&array), ["a.npy: 3 byte(s) behind the elements of the array were not read"]);
}

/// An array of one element, 1.
fn npy_of_ones() -> Vec<u8> {
    let mut text = "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 1, 1), }".to_string();
    while !(10 + text.len() + 1).is_multiple_of(64) {
        text.push(' ');
    }
    text.push('\n');
    let length = (text.len() as u16).to_le_bytes();
    [b"\x93NUMPY\x01\0", &length[..], text.as_bytes(), &1.0f32.to_le_bytes()].concat()
}
