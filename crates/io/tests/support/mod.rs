//! Small files made on the spot: a folder that vanishes, PNG, npy, GLB.
#![allow(dead_code)]

pub(crate) mod vdb;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use zonal_io::input::{FacetFile, parse_scene, read_facets};
use zonal_scene::Scene;

static FOLDER_COUNTER: AtomicUsize = AtomicUsize::new(0);

/// A temporary folder, removed when dropped.
pub(crate) struct Folder(PathBuf);

impl Folder {
    pub(crate) fn new() -> Folder {
        let n = FOLDER_COUNTER.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("zonal-input-{}-{n}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Folder(path)
    }
    pub(crate) fn path(&self) -> &Path {
        &self.0
    }
    pub(crate) fn with(self, name: &str, bytes: impl AsRef<[u8]>) -> Folder {
        self.put(name, bytes);
        self
    }
    pub(crate) fn put(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.0.join(name), bytes).unwrap();
    }
    pub(crate) fn scene(&self, text: &str) -> Scene {
        parse_scene(text, Some(&self.0), "test.toml").unwrap_or_else(|e| panic!("{e}"))
    }
    pub(crate) fn refusal(&self, text: &str) -> String {
        match parse_scene(text, Some(&self.0), "test.toml") {
            Ok(_) => panic!("this was not refused:\n{text}"),
            Err(e) => e.to_string(),
        }
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A square picture of 8-bit grey and alpha.
pub(crate) fn grey_alpha_png(side: u32, pixels: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, side, side);
    encoder.set_color(png::ColorType::GrayscaleAlpha);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(pixels).unwrap();
    writer.finish().unwrap();
    out
}

/// An 8-bit RGB picture.
pub(crate) fn png(width: u32, height: u32, rgb: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(rgb).unwrap();
    writer.finish().unwrap();
    out
}

/// Order of the elements of an npy file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NpyOrder {
    C,
    Fortran,
}

/// An npy file, version 1.0.
pub(crate) fn npy(descr: &str, order: NpyOrder, shape: &str, data: &[u8]) -> Vec<u8> {
    let order = if order == NpyOrder::Fortran { "True" } else { "False" };
    let mut text = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}");
    while !(11 + text.len()).is_multiple_of(64) {
        text.push(' ');
    }
    text.push('\n');
    let mut out = b"\x93NUMPY\x01\x00".to_vec();
    out.extend((text.len() as u16).to_le_bytes());
    out.extend(text.bytes());
    out.extend(data);
    out
}

pub(crate) fn f32s(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// A GLB of a JSON text and a binary chunk.
pub(crate) fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
    let pad = |mut b: Vec<u8>, with: u8| {
        while !b.len().is_multiple_of(4) {
            b.push(with);
        }
        b
    };
    let (json, binary) = (pad(json.as_bytes().to_vec(), b' '), pad(binary.to_vec(), 0));
    let mut out = b"glTF".to_vec();
    out.extend(2u32.to_le_bytes());
    out.extend(((28 + json.len() + binary.len()) as u32).to_le_bytes());
    out.extend((json.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(json);
    out.extend((binary.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(binary);
    out
}

/// The parts of a one-primitive glTF, each of which a test may change.
pub(crate) struct Quad {
    pub nodes: String,
    pub scene: String,
    pub material: String,
    pub primitive: String,
    pub more: String,
    pub accessors: String,
    pub views: String,
    pub binary: Vec<u8>,
}

impl Default for Quad {
    /// The unit square in z = 0 as two triangles with texture coordinates (x, y), indices in bytes, one material "wall".
    fn default() -> Quad {
        let corners = [[0.0f32, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut binary = Vec::new();
        for [x, y] in corners {
            binary.extend(f32s(&[x, y, 0.0]));
        }
        for [x, y] in corners {
            binary.extend(f32s(&[x, y]));
        }
        binary.extend([0u8, 1, 2, 0, 2, 3, 0, 0]);
        Quad {
            nodes: r#"{"mesh":0}"#.into(),
            scene: "[0]".into(),
            material: r#"{"name":"wall","pbrMetallicRoughness":{"baseColorFactor":[0.2,0.4,0.6,1],"metallicFactor":0}}"#.into(),
            primitive: r#"{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2,"material":0}"#.into(),
            more: String::new(),
            accessors: r#"{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
                {"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"},
                {"bufferView":2,"componentType":5121,"count":6,"type":"SCALAR"}"#.into(),
            views: r#"{"buffer":0,"byteOffset":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":32},
                {"buffer":0,"byteOffset":80,"byteLength":8}"#.into(),
            binary,
        }
    }
}

impl Quad {
    pub(crate) fn json(&self) -> String {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":{}}}],"nodes":[{}],
            "meshes":[{{"primitives":[{}]}}],"materials":[{}],"accessors":[{}],"bufferViews":[{}],
            "buffers":[{{"byteLength":{}}}]{}}}"#,
            self.scene,
            self.nodes,
            self.primitive,
            self.material,
            self.accessors,
            self.views,
            self.binary.len(),
            self.more
        )
    }
    pub(crate) fn glb(&self) -> Vec<u8> {
        glb(&self.json(), &self.binary)
    }
}

/// A cube from (0,0,0) to (1,1,1) as OBJ quadrilaterals with outward normals.
pub(crate) const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// A scene text and what its refusal must contain.
pub(crate) type RefusedScene<'a> = (&'a str, &'a [&'a str]);

/// A unit square, for `SQUARE` in a scene text.
pub(crate) const UNIT_SQUARE: &str = "rectangle={origin=[0,0,0],edge1=[1,0,0],edge2=[0,1,0]}";

/// Checks that each scene is refused by one line that contains the wanted texts and a mend.
pub(crate) fn check(folder: &Folder, cases: &[RefusedScene<'_>]) {
    for (text, wanted) in cases {
        let text = text.replace("SQUARE", UNIT_SQUARE);
        let message = folder.refusal(&text);
        for w in *wanted {
            assert!(message.contains(w), "'{w}' is not in:\n{message}\nfor\n{text}");
        }
        assert!(message.contains([';', '?']), "no mend in:\n{message}");
        assert!(!message.contains('\n'), "several lines:\n{message}");
    }
}

/// The faces of a file of this name and content; an error names it without its folder.
pub(crate) fn read_faces(name: &str, bytes: impl AsRef<[u8]>) -> Result<FacetFile, String> {
    let folder = Folder::new().with(name, bytes);
    let path = folder.path().join(name);
    read_facets(&path).map_err(|e| e.to_string().replace(&path.display().to_string(), name))
}
