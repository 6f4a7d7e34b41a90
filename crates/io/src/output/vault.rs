//! A folder that keeps the stages of a solve, so that a killed one can go on and a changed one need not begin anew.
//!
//! | file | what |
//! |---|---|
//! | `zonal.key` | one line: what the stages belong to |
//! | `NAME.stage` | `zonal stage 1\n`, the length of the key (u32) and the key, CRC-32 of the bytes (u32), the bytes |
//!
//! Every file is written beside its target and renamed, so that a kill at any moment leaves the old one or the new one. A stage that is
//! torn, damaged or of another key is not there. Two keys: that of the whole scene for the states of solvers (names that begin with
//! [`STATE`]), and that of what factors depend on for everything else, which therefore serves a scene with other reflectances too.

use super::FileError;
use super::atomic::{is_partial, write_atomic};
use crate::input::files;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use zonal_scene::Vault;
use zonal_scene::vault::STATE;

const MAGIC: &[u8] = b"zonal stage 1\n";

/// The file that says what the stages belong to.
const KEY: &str = "zonal.key";

/// The most bytes of that file.
const LARGEST_KEY: u64 = 1 << 16;

/// What a folder was found to hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Held {
    /// Nothing.
    Nothing,
    /// Stages of the same key.
    Same,
    /// Stages of another key: another scene, other options, another version.
    Other,
}

/// Keys of the stages: texts that differ where a stage must not be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Keys {
    /// Of the whole scene and all settings.
    pub whole: String,
    /// Of what factors and direct light depend on.
    pub factors: String,
}

/// A folder of stages.
pub struct Folder {
    path: PathBuf,
    keys: Keys,
    failure: Mutex<Option<FileError>>,
}

impl Folder {
    /// A folder at this path, which need not exist; nothing is written yet.
    pub fn new(path: &Path, keys: Keys) -> Folder {
        Folder { path: path.into(), keys, failure: Mutex::new(None) }
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether it holds stages, and whose: `key` is the one that the folder should have.
    fn held_by(&self, key: &str) -> Held {
        let found = files::read(&self.path.join(KEY), LARGEST_KEY).map(String::from_utf8);
        match found {
            Ok(Ok(text)) if text.trim_end() == key => Held::Same,
            Ok(_) => Held::Other,
            Err(_) if self.stages().is_empty() => Held::Nothing,
            Err(_) => Held::Other,
        }
    }

    /// What it holds, for a solve of the same scene.
    pub fn held(&self) -> Held {
        self.held_by(&self.keys.whole)
    }

    /// What it holds, for a solve that needs the same factors.
    pub fn held_factors(&self) -> Held {
        self.held_by(&self.keys.factors)
    }

    /// Makes the folder and puts its key there; stages that are there stay.
    pub fn begin(&self) -> Result<(), FileError> {
        fs::create_dir_all(&self.path).map_err(|e| {
            FileError::new(&self.path, "", format!("cannot be made ({e}); choose another folder"))
        })?;
        self.put_key(&self.keys.whole)
    }

    fn put_key(&self, key: &str) -> Result<(), FileError> {
        write_atomic(&self.path.join(KEY), |out| writeln!(out, "{key}"))
    }

    /// Our own files in it, whole and unfinished.
    fn stages(&self) -> Vec<PathBuf> {
        let Ok(entries) = fs::read_dir(&self.path) else { return Vec::new() };
        let ours = |p: &PathBuf| {
            let name = p.file_name().and_then(|n| n.to_str()).unwrap_or("");
            let partial = p.file_name().is_some_and(is_partial);
            name.ends_with(".stage")
                || (partial && (name.contains(".stage.") || name.starts_with(".zonal.key.")))
        };
        entries.filter_map(|e| Some(e.ok()?.path())).filter(ours).collect()
    }

    /// Removes our own files, and the folder when nothing else is in it.
    pub fn remove(&self) {
        for p in self.stages() {
            let _ = fs::remove_file(p);
        }
        let _ = fs::remove_file(self.path.join(KEY));
        let _ = fs::remove_dir(&self.path);
    }

    /// Makes it a folder of factors at `target`, in place of an earlier one, without the states of solvers.
    pub fn keep_factors(self, target: &Path) -> Result<(), FileError> {
        let name = |p: &Path| p.file_name().and_then(|n| n.to_str()).map(String::from).unwrap_or_default();
        let unwanted = |p: &&PathBuf| name(p).starts_with(STATE) || name(p).starts_with('.');
        self.stages().iter().filter(unwanted).for_each(|p| {
            let _ = fs::remove_file(p);
        });
        self.put_key(&self.keys.factors)?;
        Folder::new(target, self.keys.clone()).remove();
        fs::rename(&self.path, target)
            .map_err(|e| FileError::new(target, "", format!("cannot take the factors ({e}); remove it")))
    }

    /// The first stage that could not be kept, if any.
    pub fn failure(&self) -> Option<FileError> {
        self.failure.lock().ok().and_then(|f| f.clone())
    }

    fn file(&self, stage: &str) -> PathBuf {
        self.path.join(format!("{stage}.stage"))
    }

    fn key_of(&self, stage: &str) -> &str {
        if stage.starts_with(STATE) { &self.keys.whole } else { &self.keys.factors }
    }
}

impl Vault for Folder {
    fn load(&self, stage: &str) -> Option<Vec<u8>> {
        let mut bytes = files::read(&self.file(stage), u64::MAX).ok()?;
        let rest = bytes.strip_prefix(MAGIC)?;
        let (length, rest) = rest.split_first_chunk::<4>()?;
        let (key, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        let (sum, data) = rest.split_first_chunk::<4>()?;
        let sound = key == self.key_of(stage).as_bytes() && crc32fast::hash(data) == u32::from_le_bytes(*sum);
        let start = bytes.len() - data.len();
        sound.then(|| bytes.split_off(start))
    }

    fn save(&self, stage: &str, bytes: &[u8]) {
        let key = self.key_of(stage);
        let written = write_atomic(&self.file(stage), |out| {
            out.write_all(MAGIC)?;
            out.write_all(&(key.len() as u32).to_le_bytes())?;
            out.write_all(key.as_bytes())?;
            out.write_all(&crc32fast::hash(bytes).to_le_bytes())?;
            out.write_all(bytes)
        });
        if let (Err(e), Ok(mut first)) = (written, self.failure.lock()) {
            first.get_or_insert(e);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn torn_and_foreign_stages_are_not_there() {
        let dir = std::env::temp_dir().join(format!("zonal-vault-{}", std::process::id()));
        let keys = |w: &str, f: &str| Keys { whole: w.into(), factors: f.into() };
        let folder = |w, f| Folder::new(&dir.join("a"), keys(w, f));
        let a = folder("w", "f");
        assert_eq!(a.held(), Held::Nothing);
        a.begin().unwrap();
        a.save("rows-0", b"123");
        a.save("state-krylov", b"abc");
        assert_eq!((a.held(), a.load("rows-0"), a.load("rows-1")), (Held::Same, Some(b"123".to_vec()), None));
        // Another scene with the same factors, and one with others.
        let (b, c) = (folder("x", "f"), folder("w", "x"));
        assert_eq!(
            (b.held(), b.load("rows-0"), b.load("state-krylov")),
            (Held::Other, Some(b"123".to_vec()), None)
        );
        assert_eq!((c.load("rows-0"), c.load("state-krylov")), (None, Some(b"abc".to_vec())));
        let whole = fs::read(a.file("rows-0")).unwrap();
        for cut in 0..whole.len() {
            fs::write(a.file("rows-0"), &whole[..cut]).unwrap();
            assert_eq!(a.load("rows-0"), None, "{cut}");
        }
        for i in 0..whole.len() {
            let mut hurt = whole.clone();
            hurt[i] ^= 4;
            fs::write(a.file("rows-0"), hurt).unwrap();
            assert_eq!(a.load("rows-0"), None, "{i}");
        }
        // What is not ours stays.
        fs::write(dir.join("a/mine.txt"), "mine").unwrap();
        fs::write(a.file("rows-0"), &whole).unwrap();
        a.keep_factors(&dir.join("b")).unwrap();
        let kept = Folder::new(&dir.join("b"), keys("y", "f"));
        assert_eq!((kept.held_factors(), kept.load("rows-0")), (Held::Same, Some(b"123".to_vec())));
        assert!(!kept.file("state-krylov").exists());
        kept.remove();
        assert!(dir.join("b/mine.txt").exists());
        assert_eq!(fs::read_dir(dir.join("b")).unwrap().count(), 1);
        fs::remove_dir_all(&dir).unwrap();
    }
}
