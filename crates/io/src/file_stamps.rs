//! Files that a scene was read from, with stamps by which a change is found afterwards.
//!
//! The stamp of a file is taken before the file is opened: a change during the reading, or after it, gives another stamp. A stamp holds length, time of modification and, where
//! the system has them, the number of the file and the time of its last change of any kind, which no program can set back. Files that are not there have a stamp, too.
//!
//! The clock of a file system advances in steps. A file that changed less than [`TIME_STEP`] ago may change again within the same step, with the same length; its
//! stamp waits until the step has passed.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs::Metadata;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Longest step of the times of files on the disks of a machine.
const TIME_STEP: Duration = Duration::from_millis(20);

/// The state of a file by which it is known again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct FileStamp {
    length: u64,
    modified: Option<SystemTime>,
    /// Device, number, and time of the last change in seconds and nanoseconds.
    identity: [i64; 4],
}

impl FileStamp {
    /// The stamp of a file; `None` where there is none.
    fn of(path: &Path) -> Option<FileStamp> {
        let meta = std::fs::metadata(path).ok()?;
        Some(FileStamp { length: meta.len(), modified: meta.modified().ok(), identity: identity(&meta) })
    }

    /// Time since the last change of any kind, as far as the system tells it.
    fn age(&self) -> Option<Duration> {
        let [_, _, seconds, nanoseconds] = self.identity;
        let since_epoch = u64::try_from(seconds).ok().zip(u32::try_from(nanoseconds).ok());
        let changed = since_epoch.map(|(s, n)| SystemTime::UNIX_EPOCH + Duration::new(s, n));
        self.modified.max(changed)?.elapsed().ok()
    }

    /// As [`FileStamp::of`], of a file that has not changed within the last step of the clock.
    fn settled(path: &Path) -> Option<FileStamp> {
        let stamp = FileStamp::of(path)?;
        match stamp.age().and_then(|age| TIME_STEP.checked_sub(age)) {
            Some(rest) if rest > Duration::ZERO => {
                std::thread::sleep(rest);
                FileStamp::of(path)
            }
            _ => Some(stamp),
        }
    }
}

#[cfg(unix)]
fn identity(meta: &Metadata) -> [i64; 4] {
    use std::os::unix::fs::MetadataExt;
    [meta.dev().cast_signed(), meta.ino().cast_signed(), meta.ctime(), meta.ctime_nsec()]
}

#[cfg(not(unix))]
fn identity(_: &Metadata) -> [i64; 4] {
    [0; 4]
}

/// A file that was read or looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct ReadFile {
    /// Before the first reading; `None` of a missing file.
    stamp: Option<FileStamp>,
    openings: usize,
}

/// The files that were read or looked for, as they were before the first reading.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FilesRead {
    files: BTreeMap<PathBuf, ReadFile>,
}

impl FilesRead {
    /// True where a file has changed, is gone or has appeared since it was read.
    #[must_use]
    pub fn have_changed(&self) -> bool {
        self.files.iter().any(|(path, file)| FileStamp::of(path) != file.stamp)
    }

    /// The files, and how often each was opened.
    pub fn openings(&self) -> impl Iterator<Item = (&Path, usize)> {
        self.files.iter().map(|(path, file)| (path.as_path(), file.openings))
    }
}

/// Reads scenes and models from files, and keeps a record of all files that it opens or looks for.
///
/// ```
/// use zonal_io::input::FileRecord;
/// let path = std::env::temp_dir().join(format!("zonal-doc-files-{}.toml", std::process::id()));
/// std::fs::write(&path, "[medium]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\ncells = [2, 2, 2]\nextinction = 0.5")?;
/// let record = FileRecord::default();
/// assert!(record.read_scene(&path).is_ok());
/// let files = record.into_files();
/// assert!(files.openings().eq([(path.as_path(), 1)]) && !files.have_changed());
/// std::fs::remove_file(&path)?;
/// assert!(files.have_changed());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct FileRecord {
    read: RefCell<FilesRead>,
}

impl FileRecord {
    /// The files.
    #[must_use]
    pub fn into_files(self) -> FilesRead {
        self.read.into_inner()
    }

    /// Adds a file that is looked for.
    pub(crate) fn add(&self, path: &Path) {
        self.count(path, 0);
    }

    /// Adds a file before it is opened.
    pub(crate) fn add_opening(&self, path: &Path) {
        self.count(path, 1);
    }

    fn count(&self, path: &Path, openings: usize) {
        let files = &mut self.read.borrow_mut().files;
        if let Some(file) = files.get_mut(path) {
            file.openings += openings;
            return;
        }
        files.insert(path.to_path_buf(), ReadFile { stamp: FileStamp::settled(path), openings });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::FileSource;

    #[test]
    fn every_kind_of_save_is_a_change() {
        let dir = std::env::temp_dir().join(format!("zonal-stamps-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let path = dir.join("a.txt");
        let written = |text: &str| std::fs::write(&path, text).unwrap();
        let read = || {
            let record = FileRecord::default();
            _ = FileSource::recorded(&record).read(&path, 100);
            record.into_files()
        };
        written("one");
        let first = read();
        assert!(!first.have_changed());
        // The same length, and the time of modification set back.
        let time = std::fs::metadata(&path).unwrap().modified().unwrap();
        written("two");
        std::fs::File::options().write(true).open(&path).unwrap().set_modified(time).unwrap();
        assert!(first.have_changed());
        // Another file renamed over it.
        let second = read();
        std::fs::write(dir.join("b.txt"), "two").unwrap();
        std::fs::rename(dir.join("b.txt"), &path).unwrap();
        assert!(second.have_changed());
        // A file that is deleted, and one that appears.
        let third = read();
        std::fs::remove_file(&path).unwrap();
        assert!(third.have_changed());
        let missing = read();
        assert!(!missing.have_changed());
        written("two");
        assert!(missing.have_changed());
        std::fs::remove_dir_all(&dir).unwrap();
    }

    // Guards (pictures): a live page shows the last save of every file of its scene.
    #[test]
    fn a_save_during_the_reading_is_a_change() {
        let path = std::env::temp_dir().join(format!("zonal-stamps-race-{}", std::process::id()));
        std::fs::write(&path, "one").unwrap();
        let record = FileRecord::default();
        let source = FileSource::recorded(&record);
        source.read(&path, 100).unwrap();
        std::fs::write(&path, "two").unwrap();
        source.read(&path, 100).unwrap();
        let files = record.into_files();
        assert!(files.have_changed());
        std::fs::remove_file(&path).unwrap();
    }

    /// Saves of three files in random order and kind, some of them between the reading of one file and the next.
    struct RandomSaves {
        dir: PathBuf,
        random: u64,
        saves: usize,
    }

    impl RandomSaves {
        const FILES: u64 = 3;

        fn below(&mut self, n: u64) -> u64 {
            // Knuth's linear congruential generator.
            self.random =
                self.random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.random >> 33) % n
        }

        fn path(&self, k: u64) -> PathBuf {
            self.dir.join(format!("{k}.txt"))
        }

        fn save(&mut self) {
            let k = self.below(Self::FILES);
            let path = self.path(k);
            let time = std::fs::metadata(&path).and_then(|m| m.modified());
            // All texts have one length.
            let text = format!("{:08}", self.saves);
            self.saves += 1;
            match self.below(6) {
                0 => drop(std::fs::remove_file(&path)),
                1 | 2 => {
                    let other = self.dir.join("new");
                    std::fs::write(&other, text).unwrap();
                    if let Ok(time) = time {
                        std::fs::File::options()
                            .write(true)
                            .open(&other)
                            .unwrap()
                            .set_modified(time)
                            .unwrap();
                    }
                    std::fs::rename(&other, &path).unwrap();
                }
                3 => {
                    std::fs::write(&path, text).unwrap();
                    if let Ok(time) = time {
                        std::fs::File::options().write(true).open(&path).unwrap().set_modified(time).unwrap();
                    }
                }
                _ => std::fs::write(&path, text).unwrap(),
            }
        }

        fn contents(&self) -> Vec<Option<Vec<u8>>> {
            (0..Self::FILES).map(|k| std::fs::read(self.path(k)).ok()).collect()
        }

        /// Reads all files with saves in between; the contents and the record.
        fn read(&mut self) -> (Vec<Option<Vec<u8>>>, FilesRead) {
            let record = FileRecord::default();
            let one = |k: u64| {
                if self.below(4) == 0 {
                    self.save();
                }
                let text = FileSource::recorded(&record).read(&self.path(k), 100).ok();
                if self.below(6) == 0 {
                    self.save();
                }
                text
            };
            let all = (0..Self::FILES).map(one).collect();
            (all, record.into_files())
        }
    }

    #[test]
    fn random_saves_are_never_missed() {
        let steps = if std::env::var("ZONAL_TEST_CASES").is_ok_and(|v| v == "all") { 20_000 } else { 60 };
        let dir = std::env::temp_dir().join(format!("zonal-saves-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let mut saves = RandomSaves { dir: dir.clone(), random: 7, saves: 0 };
        let (mut unchanged, mut changed) = (0, 0);
        for step in 0..steps {
            let (seen, record) = saves.read();
            if saves.below(3) == 0 {
                saves.save();
            }
            // As the live page: done only where nothing has changed, else read again.
            if record.have_changed() {
                changed += 1;
                continue;
            }
            unchanged += 1;
            assert_eq!(seen, saves.contents(), "step {step}: a save was missed");
        }
        assert!(unchanged > steps / 20 && changed > steps / 5, "{unchanged} {changed}");
        std::fs::remove_dir_all(&dir).unwrap();
    }
}
