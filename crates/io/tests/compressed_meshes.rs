//! glTF files whose geometry Draco or meshopt compresses, against what glTF Transform decodes of them.
//!
//! `data/draco.glb`, `draco_sequential.glb` and `meshopt.glb` are a box and a cone, written by `gltf-transform draco`, `draco --method sequential` and
//! `meshopt`; `draco_decoded.glb` and `meshopt_decoded.glb` are what `gltf-transform copy` makes of the first and the last.

use std::path::Path;
use zonal_io::input::{FacetFile, FilesInMemory, read_facets, read_scene_from_bytes};
use zonal_math::Vec3;

/// Largest distance of two decoders' corners: one rounding of single precision at the size of the scene, m.
const CORNER_TOLERANCE: f64 = 1e-6;

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)).unwrap()
}

fn facets(name: &str) -> FacetFile {
    read_facets(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)).unwrap()
}

/// The corners of every face, the first being the smallest, and faces in ascending order: decoders may number points in another way.
fn canonical(file: &FacetFile) -> Vec<(String, Vec<Vec3>)> {
    let key = |p: &Vec3| p.array().map(|x| (x / CORNER_TOLERANCE / 16.0).round() as i64);
    let mut out = Vec::new();
    for (parts, name) in file.facets.iter().zip(&file.names) {
        for corners in parts {
            let first = (0..corners.len()).min_by_key(|k| key(&corners[*k])).unwrap();
            let mut turned = corners.clone();
            turned.rotate_left(first);
            out.push((name.clone(), turned));
        }
    }
    out.sort_by_key(|(name, corners)| (name.clone(), corners.iter().map(key).collect::<Vec<_>>()));
    out
}

#[test]
fn compressed_files_have_the_faces_of_the_decoded_ones() {
    for (name, decoded) in [
        ("draco.glb", "draco_decoded.glb"),
        ("draco_sequential.glb", "draco_decoded.glb"),
        ("meshopt.glb", "meshopt_decoded.glb"),
    ] {
        let (found, wanted) = (canonical(&facets(name)), canonical(&facets(decoded)));
        assert_eq!(found.len(), wanted.len(), "{name}");
        for ((material, corners), (wanted_material, wanted_corners)) in found.iter().zip(&wanted) {
            let distance =
                corners.iter().zip(wanted_corners).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max);
            assert!(
                material == wanted_material && distance < CORNER_TOLERANCE,
                "{name}: {corners:?} {wanted_corners:?}"
            );
        }
    }
}

/// The message that refuses a file, after a change of its JSON; spaces keep its length.
fn refusal(name: &str, from: &str, to: &str) -> String {
    let mut file = bytes(name);
    let at = file.windows(from.len()).position(|w| w == from.as_bytes()).unwrap_or_else(|| panic!("{from}"));
    file[at..at + from.len()].copy_from_slice(format!("{to:<width$}", width = from.len()).as_bytes());
    let files = FilesInMemory::from([("a.glb".into(), file)]);
    read_scene_from_bytes(b"[[surface]]\nmesh={file='a.glb'}\n", &files, "t.toml", 1).unwrap_err().to_string()
}

#[test]
fn wrong_extensions_are_refused() {
    let view = r#""byteOffset":84,"byteLength":151,"mode":"ATTRIBUTES","byteStride":8,"count":26"#;
    let huge = r#""byteLength":151,"mode":"ATTRIBUTES","byteStride":8,"count":268435455"#;
    for (name, from, to, wanted) in [
        (
            "draco.glb",
            r#"compression":{"bufferView":0"#,
            r#"compression":{"bufferView":9"#,
            "index out of bounds; export",
        ),
        (
            "draco.glb",
            r#"compression":{"bufferView":0"#,
            r#"compression":{"bufferWiew":0"#,
            "missing data; export",
        ),
        (
            "draco.glb",
            r#""POSITION":0}}"#,
            r#""POSITION":7}}"#,
            "its Draco data have no attribute POSITION; export",
        ),
        ("draco.glb", "DRACO", "DRACX", "its Draco data cannot be decoded ("),
        ("meshopt.glb", "TRIANGLES", "TRIANGLEX", "its EXT_meshopt_compression has no known mode; export"),
        ("meshopt.glb", r#""byteStride":2"#, r#""byteStride":3"#, "has a wrong layout ("),
        ("meshopt.glb", r#""count":192"#, r#""count":999"#, "cannot be decoded ("),
        ("meshopt.glb", r#""byteOffset":236"#, r#""byteOffset":999"#, "reaches beyond its buffer; export"),
        (
            "meshopt.glb",
            view,
            huge,
            "buffer view 1: its EXT_meshopt_compression declares 2147483640 bytes, more than 151 can",
        ),
        ("meshopt.glb", r#""fallback":true"#, r#""fallback":0"#, "buffer 1: this buffer has no data; export"),
    ] {
        let message = refusal(name, from, to);
        assert!(message.starts_with("t.toml:2:12: ") && message.contains(wanted), "{message}");
        assert!(message.contains(';') && !message.contains('\n'), "{message}");
    }
}

#[test]
fn altered_files_do_not_panic() {
    for name in ["draco.glb", "draco_sequential.glb", "meshopt.glb"] {
        let whole = bytes(name);
        let json = u32::from_le_bytes([whole[12], whole[13], whole[14], whole[15]]) as usize;
        let read = |bytes: &[u8]| {
            let files = FilesInMemory::from([("a.glb".into(), bytes.to_vec())]);
            read_scene_from_bytes(b"[[surface]]\nmesh={file='a.glb'}\n", &files, "t.toml", 1).is_ok()
        };
        assert!(read(&whole));
        for cut in 0..whole.len() {
            read(&whole[..cut]);
        }
        for at in 20 + json..whole.len() {
            for value in [0, 0xff, whole[at] ^ 1, whole[at] ^ 0x80] {
                let mut altered = whole.clone();
                altered[at] = value;
                read(&altered);
            }
        }
    }
}
