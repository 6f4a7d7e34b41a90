//! Processes of a test that are threads. The unit tests of the library take this file too: both have the trait `Communicator` in scope.

use super::Communicator;
use std::sync::{Condvar, Mutex};

/// Ranks that are threads of one process.
pub(crate) struct ThreadRanks {
    meeting: Mutex<Meeting>,
    changed: Condvar,
    mail: Mutex<Vec<Vec<Vec<u8>>>>,
}

/// How many ranks wait for the others, how often all have met, and whether one has failed.
#[derive(Default)]
struct Meeting {
    waiting: usize,
    round: usize,
    failed: bool,
}

impl ThreadRanks {
    /// Waits for all ranks; panics if one has failed, so that a failed test ends.
    fn meet(&self, size: usize) {
        let mut meeting = self.meeting.lock().unwrap();
        let round = meeting.round;
        meeting.waiting += 1;
        if meeting.waiting == size {
            (meeting.waiting, meeting.round) = (0, round + 1);
            self.changed.notify_all();
        }
        while meeting.round == round && !meeting.failed {
            meeting = self.changed.wait(meeting).unwrap();
        }
        let failed = meeting.failed;
        drop(meeting);
        assert!(!failed, "another rank has failed");
    }
}

impl Drop for ThreadRank<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.shared.meeting.lock().unwrap().failed = true;
            self.shared.changed.notify_all();
        }
    }
}

/// One of them.
pub(crate) struct ThreadRank<'a> {
    rank: usize,
    size: usize,
    shared: &'a ThreadRanks,
}

impl Communicator for ThreadRank<'_> {
    fn rank(&self) -> usize {
        self.rank
    }
    fn size(&self) -> usize {
        self.size
    }
    fn all_gather(&self, own: Vec<u8>) -> Vec<Vec<u8>> {
        self.all_to_all(vec![own; self.size])
    }
    fn all_to_all(&self, parts: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        self.shared.mail.lock().unwrap()[self.rank] = parts;
        self.shared.meet(self.size);
        let received = self.shared.mail.lock().unwrap().iter().map(|of| of[self.rank].clone()).collect();
        self.shared.meet(self.size);
        received
    }
}

/// `f` on every rank of `size`, each with a pool of one thread; the results in the order of the ranks.
pub(crate) fn on_ranks<T: Send>(size: usize, f: impl Fn(&dyn Communicator) -> T + Sync) -> Vec<T> {
    let results: Vec<Mutex<Option<T>>> = (0..size).map(|_| Mutex::new(None)).collect();
    run_ranks(size, &|c| {
        let result = f(c);
        *results[c.rank()].lock().unwrap() = Some(result);
    });
    results.into_iter().map(|result| result.into_inner().unwrap().expect("every rank has run")).collect()
}

/// Threads and pools are compiled here, once, whatever the ranks return.
fn run_ranks(size: usize, f: &(dyn Fn(&dyn Communicator) + Sync)) {
    let shared = ThreadRanks {
        meeting: Mutex::default(),
        changed: Condvar::new(),
        mail: Mutex::new(vec![Vec::new(); size]),
    };
    let one = |rank: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        pool.install(|| f(&ThreadRank { rank, size, shared: &shared }));
    };
    let one = &one;
    std::thread::scope(|s| {
        let ranks: Vec<_> = (0..size).map(|rank| s.spawn(move || one(rank))).collect();
        ranks.into_iter().for_each(|r| r.join().unwrap());
    });
}
