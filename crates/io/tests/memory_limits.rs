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
