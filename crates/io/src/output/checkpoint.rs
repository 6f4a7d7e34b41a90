//! Checkpoints: a folder with the stages of a solve, from which an interrupted or changed solve resumes.
//!
//! | file | contents |
//! |---|---|
//! | `zonal.key` | one line: the key of the stages |
//! | `NAME.stage` | `zonal stage 1\n`, the length of the key (u32) and the key, CRC-32 of the bytes (u32), the bytes |
//!
//! | `zonal.lock` | the process that uses the folder, which holds a lock on this file |
//!
//! A folder belongs to one process at a time ([`CheckpointFolder::claim`]); the lock ends with its process in every case. Pipes, devices and folders under these names count as
//! foreign: they are neither read nor written nor removed.
//!
//! Files are replaced atomically. A stage that is truncated, damaged or of another key counts as absent. There are two keys: that of the
//! whole scene for the states of solvers (names that begin with
//! [`STATE_STAGE_PREFIX`]), and that of all that the exchange factors depend on for other stages, which therefore serve a scene with other reflectances
//! too.

use super::atomic::{is_temporary, write_atomic};
use super::error::FileError;
use super::scene_hash::{factors_hash, numbers_hash, scene_hash};
use crate::files;
use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use zonal_scene::checkpoint_store::STATE_STAGE_PREFIX;
use zonal_scene::{CheckpointStore, Scene};

/// First bytes of a stage.
const MAGIC: &[u8] = b"zonal stage 1\n";

/// The file with the key of the stages.
const KEY_FILE: &str = "zonal.key";

/// The file that the process locks to which the folder belongs.
const LOCK_FILE: &str = "zonal.lock";
/// Number of times that a lock file is made again because the process before removed it.
const MAX_LOCK_ATTEMPTS: usize = 100;

/// Number of attempts, and the time between them, of a computation that shares a folder while another one empties it.
const MAX_SHARE_ATTEMPTS: usize = 50;
const SHARE_INTERVAL: Duration = Duration::from_millis(20);

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
    /// The locked file, if the folder belongs to this value.
    lock: Mutex<Option<File>>,
}

impl CheckpointFolder {
    /// A folder at this path, which need not exist; nothing is written yet.
    pub fn new(path: &Path, keys: CheckpointKeys) -> CheckpointFolder {
        CheckpointFolder { path: path.into(), keys, failure: Mutex::new(None), lock: Mutex::new(None) }
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

    /// Creates the folder and takes it for this value until it is removed or dropped; stages in it stay.
    ///
    /// # Errors
    ///
    /// The folder cannot be created, or belongs to another process, or to another computation of this one.
    pub fn claim(&self) -> Result<(), FileError> {
        self.take(File::try_lock)
    }

    /// Opens the folder for a computation that others with the same key may run at the same time, and returns the stages found; those of another key are removed.
    ///
    /// # Errors
    ///
    /// As [`claim`](Self::claim), if a computation with another key uses the folder.
    pub fn open_shared(&self) -> Result<CheckpointState, FileError> {
        let mut refused = None;
        for _ in 0..MAX_SHARE_ATTEMPTS {
            let found = self.state();
            let taken = match found {
                CheckpointState::Matching => self.take(File::try_lock_shared),
                _ => self.claim(),
            };
            match taken {
                // Another process may have changed the folder before the lock.
                Ok(()) if self.state() != found => self.release(),
                Ok(()) if found == CheckpointState::Matching => return Ok(found),
                Ok(()) => {
                    self.clear();
                    self.write_key(&self.keys.whole)?;
                    let own = self.lock.lock().unwrap_or_else(PoisonError::into_inner);
                    own.iter().for_each(|f| _ = f.try_lock_shared());
                    return Ok(found);
                }
                Err(e) => {
                    refused = Some(e);
                    std::thread::sleep(SHARE_INTERVAL);
                }
            }
        }
        Err(refused.unwrap_or_else(|| self.in_use(&self.path.join(LOCK_FILE))))
    }

    /// Creates the folder and locks its lock file.
    fn take(&self, lock: fn(&File) -> Result<(), TryLockError>) -> Result<(), FileError> {
        let mut own = self.lock.lock().unwrap_or_else(PoisonError::into_inner);
        let path = self.path.join(LOCK_FILE);
        for _ in 0..MAX_LOCK_ATTEMPTS {
            if own.is_some() {
                return Ok(());
            }
            fs::create_dir_all(&self.path).map_err(|e| {
                FileError::new(&self.path, "", format!("cannot be made ({e}); choose another folder"))
            })?;
            if fs::symlink_metadata(&path).is_ok_and(|m| !m.is_file()) {
                return Err(FileError::new(&path, "", "is not a file; remove it, or choose another folder"));
            }
            let mut file =
                match File::options().create(true).truncate(false).read(true).write(true).open(&path) {
                    Ok(file) => file,
                    // The process before has removed the folder just now.
                    Err(e) if e.kind() == io::ErrorKind::NotFound => continue,
                    Err(e) => {
                        let message = format!("cannot be written ({e}); choose another folder");
                        return Err(FileError::new(&path, "", message));
                    }
                };
            if matches!(lock(&file), Err(TryLockError::WouldBlock)) {
                return Err(self.in_use(&path));
            }
            // The process before may have removed the file before this lock.
            if is_at(&file, &path) {
                let owner = format!("process {}\n", std::process::id());
                let _ = file.set_len(0).and_then(|()| file.write_all(owner.as_bytes()));
                *own = Some(file);
            }
        }
        Err(self.in_use(&path))
    }

    /// The error of a folder of another process.
    fn in_use(&self, lock: &Path) -> FileError {
        let owner = files::read(lock, MAX_KEY_BYTES).ok().and_then(|bytes| String::from_utf8(bytes).ok());
        let is_name = |c: char| c.is_ascii_alphanumeric() || c == ' ';
        let owner = owner.as_deref().map(str::trim_end).filter(|o| !o.is_empty() && o.chars().all(is_name));
        let owner = owner.unwrap_or("another process");
        FileError::new(
            &self.path,
            "",
            format!("is in use by {owner}, which is not finished; wait for it, or choose another folder"),
        )
    }

    /// Takes the folder ([`claim`](Self::claim)) and writes its key; stages in it stay.
    ///
    /// # Errors
    ///
    /// The folder cannot be created or written, or is in use.
    pub fn begin(&self) -> Result<(), FileError> {
        self.claim()?;
        self.write_key(&self.keys.whole)
    }

    fn write_key(&self, key: &str) -> Result<(), FileError> {
        let path = self.path.join(KEY_FILE);
        check_regular(&path)?;
        write_atomic(&path, |out| writeln!(out, "{key}"))
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
        let is_regular = |e: &fs::DirEntry| e.file_type().is_ok_and(|t| t.is_file());
        entries.filter_map(Result::ok).filter(is_regular).map(|e| e.path()).filter(is_stage).collect()
    }

    /// Removes the stages and the key; the folder still belongs to this value.
    pub fn clear(&self) {
        for p in self.stages() {
            let _ = fs::remove_file(p);
        }
        let key = self.path.join(KEY_FILE);
        if check_regular(&key).is_ok() {
            let _ = fs::remove_file(key);
        }
    }

    /// Removes the files of this module, and the folder if nothing else is in it. A folder of another process stays.
    pub fn remove(&self) {
        if self.path.is_dir() && self.claim().is_ok() {
            self.clear();
            self.release();
            let _ = fs::remove_dir(&self.path);
        }
    }

    /// Removes the lock and, if no other process shares it, the lock file.
    fn release(&self) {
        let mut own = self.lock.lock().unwrap_or_else(PoisonError::into_inner);
        if own.as_ref().is_some_and(|f| f.try_lock().is_ok()) {
            let _ = fs::remove_file(self.path.join(LOCK_FILE));
        }
        *own = None;
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
        self.release();
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
        let (key, path) = (self.key_of(stage), self.file(stage));
        let written = check_regular(&path).and_then(|()| {
            write_atomic(&path, |out| {
                out.write_all(MAGIC)?;
                out.write_all(&(key.len() as u32).to_le_bytes())?;
                out.write_all(key.as_bytes())?;
                out.write_all(&crc32fast::hash(bytes).to_le_bytes())?;
                out.write_all(bytes)
            })
        });
        if let (Err(e), Ok(mut first)) = (written, self.failure.lock()) {
            first.get_or_insert(e);
        }
    }
}

/// Releases the folder; its stages stay for a later solve.
impl Drop for CheckpointFolder {
    fn drop(&mut self) {
        self.release();
    }
}

/// Refuses a path at which something other than a regular file is: a pipe would block, and a device has no end.
fn check_regular(path: &Path) -> Result<(), FileError> {
    match fs::metadata(path) {
        Ok(m) if !m.is_file() => {
            Err(FileError::new(path, "", "is not a file; remove it, or choose another folder"))
        }
        _ => Ok(()),
    }
}

/// True if an open file is the one at a path.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let id = |m: fs::Metadata| (m.dev(), m.ino());
    file.metadata().map(id).ok().is_some_and(|own| fs::metadata(path).map(id).is_ok_and(|there| own == there))
}

/// True if an open file is the one at a path: an open file cannot be removed.
#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.is_file()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder_of_test(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("zonal-checkpoint-{name}-{}", std::process::id()))
    }

    // Guards (files): a checkpoint folder belongs to one solve at a time.
    #[test]
    fn a_folder_belongs_to_one_solve_at_a_time() {
        let dir = folder_of_test("claim");
        let keys = |w: &str| CheckpointKeys { whole: w.into(), factors: w.into() };
        let (a, b) = (CheckpointFolder::new(&dir, keys("a")), CheckpointFolder::new(&dir, keys("b")));
        a.begin().unwrap();
        a.save("rows-0", b"123");
        let told = b.begin().unwrap_err().to_string();
        assert!(told.contains(&format!("is in use by process {}", std::process::id())), "{told}");
        b.remove();
        assert_eq!(a.load("rows-0").as_deref(), Some(&b"123"[..]), "a folder of another solve stays");
        assert!(a.failure().is_none());
        drop(a);
        // The stages of an interrupted solve stay, its lock does not.
        b.claim().unwrap();
        assert_eq!(b.state(), CheckpointState::Mismatched);
        b.remove();
        assert!(!dir.exists());
        // Many solves at once: one has the folder at any time, and none fails otherwise.
        let done = std::sync::atomic::AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..50 {
                        let own = CheckpointFolder::new(&dir, keys("c"));
                        match own.begin() {
                            Ok(()) => {
                                own.save("rows-0", b"1");
                                assert!(own.failure().is_none(), "{:?}", own.failure());
                                own.remove();
                                done.fetch_add(1, std::sync::atomic::Ordering::SeqCst);
                            }
                            Err(e) => assert!(e.to_string().contains("is in use by"), "{e}"),
                        }
                    }
                });
            }
        });
        assert!(done.into_inner() > 0 && !dir.exists());
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_under_the_name_of_a_stage_is_foreign() {
        let dir = folder_of_test("pipe");
        fs::create_dir_all(&dir).unwrap();
        for name in ["rows-0.stage", "other.stage"] {
            assert!(std::process::Command::new("mkfifo").arg(dir.join(name)).status().unwrap().success());
        }
        let a = CheckpointFolder::new(&dir, CheckpointKeys { whole: "w".into(), factors: "f".into() });
        assert_eq!(a.state(), CheckpointState::Empty);
        a.begin().unwrap();
        assert_eq!(a.load("rows-0"), None);
        a.save("rows-0", b"123");
        let told = a.failure().unwrap().to_string();
        assert!(told.contains("rows-0.stage") && told.contains("is not a file"), "{told}");
        a.remove();
        assert_eq!(fs::read_dir(&dir).unwrap().count(), 2);
        fs::remove_dir_all(&dir).unwrap();
    }

    // Guards (files): a truncated, damaged or foreign checkpoint stage counts as absent; foreign files in its folder stay.
    #[test]
    fn truncated_damaged_and_foreign_stages_are_absent() {
        let dir = std::env::temp_dir().join(format!("zonal-checkpoint-{}", std::process::id()));
        let keys = |w: &str, f: &str| CheckpointKeys { whole: w.into(), factors: f.into() };
        let folder = |w, f| CheckpointFolder::new(&dir.join("a"), keys(w, f));
        let a = folder("w", "f");
        assert_eq!(a.state(), CheckpointState::Empty);
        a.begin().unwrap();
        a.save("rows-0", b"123");
        a.save("state-gradients", b"abc");
        assert_eq!(
            (a.state(), a.load("rows-0"), a.load("rows-1")),
            (CheckpointState::Matching, Some(b"123".to_vec()), None)
        );
        // Another scene with the same factors, and one with others.
        let (b, c) = (folder("x", "f"), folder("w", "x"));
        assert_eq!(
            (b.state(), b.load("rows-0"), b.load("state-gradients")),
            (CheckpointState::Mismatched, Some(b"123".to_vec()), None)
        );
        assert_eq!((c.load("rows-0"), c.load("state-gradients")), (None, Some(b"abc".to_vec())));
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
        assert!(!kept.file("state-gradients").exists());
        kept.remove();
        assert!(dir.join("b/mine.txt").exists());
        assert_eq!(fs::read_dir(dir.join("b")).unwrap().count(), 1);
        fs::remove_dir_all(&dir).unwrap();
    }
}
