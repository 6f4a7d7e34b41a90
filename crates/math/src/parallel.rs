//! Parallel loops over indices and slices. The machinery of a loop is compiled once for each type of item, not for each loop: the body is called through a
//! reference to a function. Items keep their order, so that results do not depend on the number of threads.

use rayon::prelude::*;

/// Most tasks of a loop over single items.
const MAX_TASKS: usize = 512;

/// The values of `of` at 0 … n − 1.
///
/// ```
/// assert_eq!(zonal_math::parallel::collect(3, |i| i * i), [0, 1, 4]);
/// ```
pub fn collect<T: Send>(n: usize, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
    fn erased<T: Send>(n: usize, of: &(dyn Fn(usize) -> T + Sync)) -> Vec<T> {
        (0..n).into_par_iter().map(of).collect()
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
    let length = items.len().div_ceil(MAX_TASKS).max(1);
    chunks(items, length, |c, chunk| {
        for (k, item) in chunk.iter_mut().enumerate() {
            each(c * length + k, item);
        }
    });
}

/// Calls `each` with the items of two slices of one length.
///
/// # Panics
/// If the second slice is shorter.
pub fn for_each_pair<T: Send, U: Sync>(items: &mut [T], others: &[U], each: impl Fn(&mut T, &U) + Sync) {
    let length = items.len().div_ceil(MAX_TASKS).max(1);
    chunks(items, length, |c, chunk| {
        let others = &others[c * length..][..chunk.len()];
        for (item, other) in chunk.iter_mut().zip(others) {
            each(item, other);
        }
    });
}

/// Calls `each` with the number and the items of every chunk of `length` items; the last one may be shorter.
pub fn chunks<T: Send>(items: &mut [T], length: usize, each: impl Fn(usize, &mut [T]) + Sync) {
    fn erased<T: Send>(items: &mut [T], length: usize, each: &(dyn Fn(usize, &mut [T]) + Sync)) {
        items.par_chunks_mut(length).enumerate().for_each(|(c, chunk)| each(c, chunk));
    }
    erased(items, length, &each);
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
            assert_eq!(map(&squares, |x| x + 1), squares.iter().map(|x| x + 1).collect::<Vec<_>>());
            let mut out = vec![0; n];
            for_each(&mut out, |i, x| *x += i);
            for_each_pair(&mut out, &squares, |x, s| *x += s);
            chunks(&mut out, 7, |c, chunk| chunk.iter_mut().enumerate().for_each(|(k, x)| *x -= 7 * c + k));
            assert_eq!(out, squares);
            assert_eq!(any(n, |i| i == 511), n > 511);
            assert_eq!(all(&squares, |s| *s != 1), n < 2);
        }
    }
}
