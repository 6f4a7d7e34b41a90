//! Checkpoints: a folder with the stages of a solve, from which an interrupted or changed solve resumes.
//!
//! | file | contents |
//! |---|---|
//! | `zonal.key` | one line: the key of the stages |
//! | `NAME.stage` | `zonal stage 1\n`, the length of the key (u32) and the key, CRC-32 of the bytes (u32), the bytes |
//!
//! Files are replaced atomically. A stage that is truncated, damaged or of another key counts as absent. There are two keys: that of the
//! whole scene for the states of solvers (names that begin with
//! [`STATE_STAGE_PREFIX`]), and that of all that the exchange factors depend on for other stages, which therefore serve a scene with other reflectances
//! too.

use super::atomic::{is_temporary, write_atomic};
use super::error::FileError;
use super::scene_hash::{factors_hash, numbers_hash, scene_hash};
use crate::files;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use zonal_scene::checkpoint_store::STATE_STAGE_PREFIX;
use zonal_scene::{CheckpointStore, Scene};

/// First bytes of a stage.
const MAGIC: &[u8] = b"zonal stage 1\n";

/// The file with the key of the stages.
const KEY_FILE: &str = "zonal.key";

/// Hexadecimal digits of the name of a folder by its key.
const NAME_DIGITS: usize = 32;

/// Largest file of a key, bytes.
const MAX_KEY_BYTES: u64 = 1 << 16;

/// The stages in a folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CheckpointState {
    /// No stages.
    Empty,
    /// Stages of the same key.
    Matching,
    /// Stages of another key: another scene, other options, another version.
    Mismatched,
}

/// Keys of the stages: texts that differ if a stage must not be reused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CheckpointKeys {
    /// Of the whole scene and all settings.
    pub whole: String,
    /// Of all that factors and direct light depend on.
    pub factors: String,
}

impl CheckpointKeys {
    /// The method of the exact factors of voxel pairs, for [`of_solve`](Self::of_solve).
    pub const EXACT_METHOD: &str = "Exact";

    /// The keys of a solve of a scene by this version of the program, with a method for the factors of voxel pairs.
    pub fn of_solve(scene: &Scene, method: &str) -> CheckpointKeys {
        let key = |hash: String| format!("zonal {} {hash} {method}", env!("CARGO_PKG_VERSION"));
        CheckpointKeys { whole: key(scene_hash(scene)), factors: key(factors_hash(scene)) }
    }

    /// The key of a computation without a scene, by numbers that its stages depend on.
    pub fn of_numbers(what: &str, numbers: impl Iterator<Item = f64>) -> CheckpointKeys {
        let key = format!("zonal {} {} {what}", env!("CARGO_PKG_VERSION"), numbers_hash(numbers));
        CheckpointKeys { whole: key.clone(), factors: key }
    }
}

/// A folder of stages.
pub struct CheckpointFolder {
    path: PathBuf,
    keys: CheckpointKeys,
    failure: Mutex<Option<FileError>>,
}

impl CheckpointFolder {
    /// A folder at this path, which need not exist; nothing is written yet.
    pub fn new(path: &Path, keys: CheckpointKeys) -> CheckpointFolder {
        CheckpointFolder { path: path.into(), keys, failure: Mutex::new(None) }
    }

    /// A folder within `parent` whose name follows from the key, so that one parent holds several computations.
    pub fn within(parent: &Path, keys: CheckpointKeys) -> CheckpointFolder {
        let name = blake3::hash(keys.whole.as_bytes()).to_hex();
        CheckpointFolder::new(&parent.join(&name.as_str()[..NAME_DIGITS]), keys)
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The stages in it, compared with a key.
    fn state_for(&self, key: &str) -> CheckpointState {
        let found = files::read(&self.path.join(KEY_FILE), MAX_KEY_BYTES).map(String::from_utf8);
        match found {
            Ok(Ok(text)) if text.trim_end() == key => CheckpointState::Matching,
            Ok(_) => CheckpointState::Mismatched,
            Err(_) if self.stages().is_empty() => CheckpointState::Empty,
            Err(_) => CheckpointState::Mismatched,
        }
    }

    /// The stages in it, for a solve of the whole scene.
    pub fn state(&self) -> CheckpointState {
        self.state_for(&self.keys.whole)
    }

    /// The stages in it, for a solve with the same factors.
    pub fn factors_state(&self) -> CheckpointState {
        self.state_for(&self.keys.factors)
    }

    /// Creates the folder and writes its key; stages in it stay.
    ///
    /// # Errors
    ///
    /// The folder cannot be created or written.
    pub fn begin(&self) -> Result<(), FileError> {
        fs::create_dir_all(&self.path).map_err(|e| {
            FileError::new(&self.path, "", format!("cannot be made ({e}); choose another folder"))
        })?;
        self.write_key(&self.keys.whole)
    }

    fn write_key(&self, key: &str) -> Result<(), FileError> {
        write_atomic(&self.path.join(KEY_FILE), |out| writeln!(out, "{key}"))
    }

    /// The files of this module in it, complete and temporary.
    fn stages(&self) -> Vec<PathBuf> {
        let Ok(entries) = fs::read_dir(&self.path) else { return Vec::new() };
        let is_stage = |p: &PathBuf| {
            let name = p.file_name().and_then(|n| n.to_str()).unwrap_or("");
            let temporary = p.file_name().is_some_and(is_temporary);
            name.ends_with(".stage")
                || (temporary && (name.contains(".stage.") || name.starts_with(".zonal.key.")))
        };
        entries.filter_map(|e| Some(e.ok()?.path())).filter(is_stage).collect()
    }

    /// Removes the files of this module, and the folder if nothing else is in it.
    pub fn remove(&self) {
        for p in self.stages() {
            let _ = fs::remove_file(p);
        }
        let _ = fs::remove_file(self.path.join(KEY_FILE));
        let _ = fs::remove_dir(&self.path);
    }

    /// Moves it to `target` as a folder of factors, without the states of solvers; replaces an earlier one.
    ///
    /// # Errors
    ///
    /// The key cannot be written or the folder cannot be moved.
    pub fn keep_factors(self, target: &Path) -> Result<(), FileError> {
        let name = |p: &Path| p.file_name().and_then(|n| n.to_str()).map(String::from).unwrap_or_default();
        let is_dropped = |p: &&PathBuf| name(p).starts_with(STATE_STAGE_PREFIX) || name(p).starts_with('.');
        self.stages().iter().filter(is_dropped).for_each(|p| {
            let _ = fs::remove_file(p);
        });
        self.write_key(&self.keys.factors)?;
        CheckpointFolder::new(target, self.keys.clone()).remove();
        fs::rename(&self.path, target)
            .map_err(|e| FileError::new(target, "", format!("cannot take the factors ({e}); remove it")))
    }

    /// The error of the first stage that could not be written, if any.
    pub fn failure(&self) -> Option<FileError> {
        self.failure.lock().ok().and_then(|f| f.clone())
    }

    fn file(&self, stage: &str) -> PathBuf {
        self.path.join(format!("{stage}.stage"))
    }

    fn key_of(&self, stage: &str) -> &str {
        if stage.starts_with(STATE_STAGE_PREFIX) { &self.keys.whole } else { &self.keys.factors }
    }
}

impl CheckpointStore for CheckpointFolder {
    fn load(&self, stage: &str) -> Option<Vec<u8>> {
        let mut bytes = files::read(&self.file(stage), u64::MAX).ok()?;
        let rest = bytes.strip_prefix(MAGIC)?;
        let (length, rest) = rest.split_first_chunk::<4>()?;
        let (key, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        let (sum, data) = rest.split_first_chunk::<4>()?;
        let valid = key == self.key_of(stage).as_bytes() && crc32fast::hash(data) == u32::from_le_bytes(*sum);
        let start = bytes.len() - data.len();
        valid.then(|| bytes.split_off(start))
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
    fn truncated_damaged_and_foreign_stages_are_absent() {
        let dir = std::env::temp_dir().join(format!("zonal-checkpoint-{}", std::process::id()));
        let keys = |w: &str, f: &str| CheckpointKeys { whole: w.into(), factors: f.into() };
        let folder = |w, f| CheckpointFolder::new(&dir.join("a"), keys(w, f));
        let a = folder("w", "f");
        assert_eq!(a.state(), CheckpointState::Empty);
        a.begin().unwrap();
        a.save("rows-0", b"123");
        a.save("state-krylov", b"abc");
        assert_eq!(
            (a.state(), a.load("rows-0"), a.load("rows-1")),
            (CheckpointState::Matching, Some(b"123".to_vec()), None)
        );
        // Another scene with the same factors, and one with others.
        let (b, c) = (folder("x", "f"), folder("w", "x"));
        assert_eq!(
            (b.state(), b.load("rows-0"), b.load("state-krylov")),
            (CheckpointState::Mismatched, Some(b"123".to_vec()), None)
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
        // Foreign files stay.
        fs::write(dir.join("a/mine.txt"), "mine").unwrap();
        fs::write(a.file("rows-0"), &whole).unwrap();
        a.keep_factors(&dir.join("b")).unwrap();
        let kept = CheckpointFolder::new(&dir.join("b"), keys("y", "f"));
        assert_eq!(
            (kept.factors_state(), kept.load("rows-0")),
            (CheckpointState::Matching, Some(b"123".to_vec()))
        );
        assert!(!kept.file("state-krylov").exists());
        kept.remove();
        assert!(dir.join("b/mine.txt").exists());
        assert_eq!(fs::read_dir(dir.join("b")).unwrap().count(), 1);
        fs::remove_dir_all(&dir).unwrap();
    }
}
