//! Batches of tasks in one parallel loop: no thread waits for the end of a batch, and a batch is finished by the thread that computes its last task.

use std::sync::{Mutex, PoisonError};
use zonal_math::parallel;

/// A batch in progress: the results of its tasks so far, and the number of those that are missing.
struct OpenBatch<R> {
    results: Vec<Option<R>>,
    missing: usize,
}

/// Runs the tasks of all batches, which are in the order of their numbers, and gives the results of each batch, in the order of its tasks, to `finish`. Returns
/// what `finish` returns, batch by batch; `None` of a batch without tasks.
pub(crate) fn run<T: Sync, R: Send, B: Send>(
    batches: &[Vec<T>],
    run: impl Fn(&T) -> R + Sync,
    finish: impl Fn(usize, Vec<R>) -> B + Sync,
) -> Vec<Option<B>> {
    let open: Vec<Mutex<OpenBatch<R>>> = batches
        .iter()
        .map(|b| Mutex::new(OpenBatch { results: b.iter().map(|_| None).collect(), missing: b.len() }))
        .collect();
    let tasks: Vec<(usize, usize)> =
        batches.iter().enumerate().flat_map(|(b, tasks)| (0..tasks.len()).map(move |k| (b, k))).collect();
    let finished = parallel::collect_tasks(tasks.len(), |t| {
        let (b, k) = tasks[t];
        let result = run(&batches[b][k]);
        let mut batch = open[b].lock().unwrap_or_else(PoisonError::into_inner);
        batch.results[k] = Some(result);
        batch.missing -= 1;
        let complete = (batch.missing == 0).then(|| std::mem::take(&mut batch.results));
        drop(batch);
        complete.map(|results| (b, finish(b, results.into_iter().flatten().collect())))
    });
    let mut out: Vec<Option<B>> = batches.iter().map(|_| None).collect();
    finished.into_iter().flatten().for_each(|(b, made)| out[b] = Some(made));
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_are_finished_once_with_their_results_in_order() {
        let batches: Vec<Vec<usize>> = (0..7).map(|b| (0..b * 3).collect()).collect();
        let sums = run(&batches, |t| t * t, |b, squares| (b, squares));
        for (b, sum) in sums.into_iter().enumerate() {
            let wanted = (b > 0).then(|| (b, (0..3 * b).map(|t| t * t).collect::<Vec<_>>()));
            assert_eq!(sum, wanted);
        }
    }
}
