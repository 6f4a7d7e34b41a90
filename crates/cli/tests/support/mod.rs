//! Runs of the command in temporary folders, and small generated inputs.
#![allow(dead_code, unused_imports)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

static NEXT_FOLDER: AtomicUsize = AtomicUsize::new(0);

/// A temporary folder with an empty folder `out` in it, removed when dropped.
pub(crate) struct Folder(PathBuf);

impl Folder {
    pub(crate) fn new() -> Folder {
        let n = NEXT_FOLDER.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("zonal-command-{}-{n}", std::process::id()));
        std::fs::create_dir_all(path.join("out")).unwrap();
        Folder(path)
    }
    pub(crate) fn path(&self) -> &Path {
        &self.0
    }
    pub(crate) fn put(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.0.join(name), bytes).unwrap();
    }
    pub(crate) fn get(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.0.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }
    /// Runs `zonal` in the folder.
    pub(crate) fn zonal(&self, args: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_zonal")).args(args).current_dir(&self.0).output().unwrap()
    }
    /// Runs `zonal`, which must succeed; returns its standard output.
    pub(crate) fn done(&self, args: &[&str]) -> String {
        let o = self.zonal(args);
        assert!(o.status.success(), "zonal {}: {:?}\n{}", args.join(" "), o.status, text(&o.stderr));
        text(&o.stdout)
    }
    /// Names and contents of everything in the folder; folders have no contents.
    pub(crate) fn listing(&self) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
        let mut all = BTreeMap::new();
        let mut folders = vec![self.0.clone()];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path.clone());
                    all.insert(path, None);
                } else {
                    let bytes = std::fs::read(&path).unwrap();
                    all.insert(path, Some(bytes));
                }
            }
        }
        all
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Origin of a refusal: the program, with one line, or the parser of the command line, which adds the usage.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum By {
    Program,
    Parser,
}
pub(crate) use By::{Parser, Program};

/// Runs a command that must be refused with a message that contains `named`.
pub(crate) fn refused(f: &Folder, by: By, args: &[&str], named: &str) {
    let before = f.listing();
    let o = f.zonal(args);
    let command = format!("zonal {}", args.join(" "));
    // Commands that take seconds print their progress.
    let lines = text(&o.stderr);
    let err: String =
        lines.lines().filter(|l| !l.starts_with("progress: ")).map(|l| format!("{l}\n")).collect();
    let out = text(&o.stdout);
    assert_eq!(o.status.code(), Some(2), "{command}: {:?}\n{out}\n{err}", o.status);
    assert!(err.starts_with("error: "), "{command}: {err}");
    assert!(by == Parser || err.lines().count() == 1, "{command}: several lines:\n{err}");
    assert!(err.contains(named), "{command}: '{named}' is not named in\n{err}");
    assert!(err.len() < 2000, "{command}: a message of {} bytes", err.len());
    assert!(out.is_empty(), "{command}: on standard output:\n{out}");
    let after = f.listing();
    let changed: Vec<_> = after.iter().filter(|(k, v)| before.get(*k) != Some(v)).map(|e| e.0).collect();
    assert!(changed.is_empty() && before.len() == after.len(), "{command}: new or changed: {changed:?}");
}

/// Bytes as text.
pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A room of one metre with an emitting wall, eight voxels of smoke and a camera.
pub(crate) const ROOM: &str = "name = 'room'
[solve]
patch_size = 1.0
[[surface]]
name = 'room'
room = { min = [0, 0, 0], max = [1, 1, 1] }
faces.x0 = { emission = 100 }
[medium]
min = [0, 0, 0]
max = [1, 1, 1]
cells = [2, 2, 2]
extinction = 0.5
albedo = 0.5
[[camera]]
name = 'door'
origin = [0.9, 0.5, 0.5]
target = [0, 0.5, 0.5]
";

/// The solution of [`ROOM`], solved once.
pub(crate) fn solution() -> &'static [u8] {
    static SOLVED: OnceLock<Vec<u8>> = OnceLock::new();
    SOLVED.get_or_init(|| {
        let f = Folder::new();
        f.put("room.toml", ROOM);
        f.done(&["solve", "room.toml", "-o", "room.npz"]);
        f.get("room.npz")
    })
}

/// An npy file, version 1.0, with these header entries.
pub(crate) fn npy(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    while !(11 + header.len()).is_multiple_of(64) {
        header.push(' ');
    }
    header.push('\n');
    let mut out = b"\x93NUMPY\x01\x00".to_vec();
    out.extend((header.len() as u16).to_le_bytes());
    out.extend(header.bytes());
    out.extend(data);
    out
}

/// A GLB of one JSON chunk.
pub(crate) fn glb(json: &str) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend((20 + json.len() as u32).to_le_bytes());
    out.extend((json.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(json);
    out
}

/// The header line of a table of pairs.
pub(crate) const COLUMNS: &str =
    "kind,a_x0,a_x1,a_y0,a_y1,a_z0,a_z1,a_normal,b_x0,b_x1,b_y0,b_y1,b_z0,b_z1,b_normal,kappa";
/// Two voxels that touch.
pub(crate) const VOXELS: &str = "vv,0,1,0,1,0,1,,1,2,0,1,0,1,,0.5";
