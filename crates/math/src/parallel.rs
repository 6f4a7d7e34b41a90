//! Parallel loops over indices and slices. The machinery of a loop is compiled once for each type of item, not for each loop: the body is called through a
//! reference to a function. Items keep their order, so that results do not depend on the number of threads.

use rayon::prelude::*;

/// Number of tasks of a long loop. By itself rayon makes about 2n tasks for n threads, and does not divide a task that has begun: threads would wait at the end
/// of a loop with unequal items.
const TASKS: usize = 128;
/// Number of single items up to which rayon alone divides a task: the items of short loops are cheap.
const MIN_TASK_ITEMS: usize = 8;
/// Pairs of items of a task, at least.
const MIN_PAIRS_OF_TASK: usize = 1 << 10;
/// Operations of a task of a loop with a known number of them, at least: some ten microseconds.
const MIN_TASK_OPERATIONS: usize = 1 << 15;
/// Items of a block of a reduction.
const BLOCK_LENGTH: usize = 4096;

/// Items of a chunk of a loop over n.
fn chunk_length(n: usize) -> usize {
    n.div_ceil(4 * TASKS).max(1)
}

/// Most items of a task of a loop over n.
fn task_items(n: usize) -> usize {
    n.div_ceil(TASKS).max(MIN_TASK_ITEMS)
}

/// The values of `of` at 0 … n − 1.
///
/// ```
/// assert_eq!(zonal_math::parallel::collect(3, |i| i * i), [0, 1, 4]);
/// ```
pub fn collect<T: Send>(n: usize, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
    fn erased<T: Send>(n: usize, of: &(dyn Fn(usize) -> T + Sync)) -> Vec<T> {
        (0..n).into_par_iter().with_max_len(task_items(n)).map(of).collect()
    }
    erased(n, &of)
}

/// As [`collect`], each value as a task of its own: for few values that take long.
pub fn collect_tasks<T: Send>(n: usize, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
    fn erased<T: Send>(n: usize, of: &(dyn Fn(usize) -> T + Sync)) -> Vec<T> {
        (0..n).into_par_iter().with_max_len(1).map(of).collect()
    }
    erased(n, &of)
}

/// As [`collect`], for values that take about a number of operations each: too few for a task run on the calling thread.
pub fn collect_short<T: Send>(n: usize, operations: usize, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
    fn erased<T: Send>(n: usize, least: usize, of: &(dyn Fn(usize) -> T + Sync)) -> Vec<T> {
        (0..n).into_par_iter().with_max_len(task_items(n)).with_min_len(least).map(of).collect()
    }
    erased(n, least_items(operations), &of)
}

/// Least items of a task if each takes about a number of operations: to start a task, and to wake a thread for it, takes some microseconds.
pub fn least_items(operations: usize) -> usize {
    (MIN_TASK_OPERATIONS / operations.max(1)).max(1)
}

/// The values of `of` at the items of a slice.
pub fn map<A: Sync, T: Send>(items: &[A], of: impl Fn(&A) -> T + Sync) -> Vec<T> {
    collect(items.len(), |i| of(&items[i]))
}

/// True if `holds` is true at an index below n.
pub fn any(n: usize, holds: impl Fn(usize) -> bool + Sync) -> bool {
    fn erased(n: usize, holds: &(dyn Fn(usize) -> bool + Sync)) -> bool {
        (0..n).into_par_iter().any(holds)
    }
    erased(n, &holds)
}

/// The first index below n at which `holds` is true.
///
/// ```
/// assert_eq!(zonal_math::parallel::first(9, |i| i * i > 20), Some(5));
/// ```
pub fn first(n: usize, holds: impl Fn(usize) -> bool + Sync) -> Option<usize> {
    fn erased(n: usize, holds: &(dyn Fn(usize) -> bool + Sync)) -> Option<usize> {
        (0..n).into_par_iter().find_first(|i| holds(*i))
    }
    erased(n, &holds)
}

/// `both` over `start` and the values of `of` at 0 … n − 1, block by block: the order does not depend on the number of threads. `start` counts once for each block,
/// so that it must not change a value: 0 of a sum.
///
/// ```
/// let largest = zonal_math::parallel::reduce(5000, 0.0, |i| (i as f64).sin(), f64::max);
/// assert!(largest > 0.99 && largest <= 1.0);
/// ```
pub fn reduce<T: Clone + Send + Sync>(
    n: usize,
    start: T,
    of: impl Fn(usize) -> T + Sync,
    both: impl Fn(T, T) -> T + Sync,
) -> T {
    let block = |b: usize| {
        let items = b * BLOCK_LENGTH..((b + 1) * BLOCK_LENGTH).min(n);
        items.fold(start.clone(), |sum, i| both(sum, of(i)))
    };
    let blocks = collect(n.div_ceil(BLOCK_LENGTH), block);
    blocks.into_iter().fold(start.clone(), &both)
}

/// Gives a vector `n` entries of any value, for a loop that writes all of them. Memory that is new is touched by the threads of that loop first.
pub fn set_length(items: &mut Vec<f64>, n: usize) {
    if n > items.capacity() {
        // Free the old memory first. Zeros from the system take no time until they are written.
        *items = Vec::new();
        *items = vec![0.0; n];
    }
    items.resize(n, 0.0);
}

/// True if `holds` is true at all items of a slice.
pub fn all<A: Sync>(items: &[A], holds: impl Fn(&A) -> bool + Sync) -> bool {
    !any(items.len(), |i| !holds(&items[i]))
}

/// Calls `each` with the index and the item of every item.
///
/// ```
/// let mut squares = [0; 3];
/// zonal_math::parallel::for_each(&mut squares, |i, x| *x = i * i);
/// assert_eq!(squares, [0, 1, 4]);
/// ```
pub fn for_each<T: Send>(items: &mut [T], each: impl Fn(usize, &mut T) + Sync) {
    let length = chunk_length(items.len());
    chunks_in_tasks(items, length, task_items(items.len()).div_ceil(length), |c, chunk| {
        for (k, item) in chunk.iter_mut().enumerate() {
            each(c * length + k, item);
        }
    });
}

/// Calls `each` with the items of two slices of one length, for arithmetic: short slices are no task.
///
/// # Panics
/// If the second slice is shorter.
pub fn for_each_pair<T: Send, U: Sync>(items: &mut [T], others: &[U], each: impl Fn(&mut T, &U) + Sync) {
    let length = chunk_length(items.len()).max(MIN_PAIRS_OF_TASK);
    chunks_in_tasks(items, length, task_items(items.len()).div_ceil(length), |c, chunk| {
        let others = &others[c * length..][..chunk.len()];
        for (item, other) in chunk.iter_mut().zip(others) {
            each(item, other);
        }
    });
}

/// Calls `each` with the number and the items of every chunk of `length` items; the last one may be shorter.
pub fn chunks<T: Send>(items: &mut [T], length: usize, each: impl Fn(usize, &mut [T]) + Sync) {
    let count = items.len().div_ceil(length);
    chunks_in_tasks(items, length, count.div_ceil(TASKS).max(1), each);
}

/// As [`chunks`], with at most some chunks in a task.
fn chunks_in_tasks<T: Send>(
    items: &mut [T],
    length: usize,
    chunks_of_task: usize,
    each: impl Fn(usize, &mut [T]) + Sync,
) {
    fn erased<T: Send>(
        items: &mut [T],
        length: usize,
        chunks_of_task: usize,
        each: &(dyn Fn(usize, &mut [T]) + Sync),
    ) {
        let chunks = items.par_chunks_mut(length).enumerate().with_max_len(chunks_of_task);
        chunks.for_each(|(c, chunk)| each(c, chunk));
    }
    erased(items, length, chunks_of_task, &each);
}

/// The values of two functions, which may run at the same time.
pub fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    rayon::join(a, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loops_visit_every_item_once_in_its_place() {
        for n in [0, 1, 2, 511, 512, 513, 5000] {
            let squares = collect(n, |i| i * i);
            assert_eq!(squares, (0..n).map(|i| i * i).collect::<Vec<_>>());
            assert_eq!(collect_tasks(n, |i| i * i), squares);
            assert_eq!(collect_short(n, 1000, |i| i * i), squares);
            assert_eq!(map(&squares, |x| x + 1), squares.iter().map(|x| x + 1).collect::<Vec<_>>());
            let mut out = vec![0; n];
            for_each(&mut out, |i, x| *x += i);
            for_each_pair(&mut out, &squares, |x, s| *x += s);
            chunks(&mut out, 7, |c, chunk| chunk.iter_mut().enumerate().for_each(|(k, x)| *x -= 7 * c + k));
            assert_eq!(out, squares);
            assert_eq!(any(n, |i| i == 511), n > 511);
            assert_eq!(first(n, |i| i == 511 || i == 3000), (n > 511).then_some(511));
            assert_eq!(reduce(n, 0, |i| i, |a, b| a + b), (0..n).sum());
            let mut sized = vec![1.0; 600];
            set_length(&mut sized, n);
            assert_eq!(sized.len(), n);
            assert_eq!(all(&squares, |s| *s != 1), n < 2);
        }
    }
}
