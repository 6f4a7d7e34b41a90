//! States of an iteration in a checkpoint: one stage of a process that has all unknowns, or one of each process that has some planes of voxels.
//!
//! A solve may resume on another number of processes: a process reads the stages that have planes of its own. Processes save one after the other, and a solve may
//! be killed between; a state counts only if all of its stages are of one iteration.

use crate::distribution::multivector::VectorEntry;
use crate::distribution::part_of;
use crate::distribution::sum_order::SumOrder;
use zonal_scene::CheckpointStore;

/// Number of the processes whose stages a checkpoint has.
fn parts_stage(stage: &str) -> String {
    format!("{stage}-parts")
}

/// Name of the stage of one of several processes.
fn part_stage(stage: &str, part: usize, parts: usize) -> String {
    format!("{stage}-part-{part}-of-{parts}")
}

/// Saves the state of this process.
pub(crate) fn save(store: &dyn CheckpointStore, stage: &str, sums: SumOrder, bytes: &[u8]) {
    if !sums.is_divided() {
        return store.save(stage, bytes);
    }
    let [part, parts] = sums.process();
    store.save(&part_stage(stage, part, parts), bytes);
    store.save(&parts_stage(stage), &(parts as u64).to_le_bytes());
}

/// A state of some unknowns: the vectors of every column one after the other, and what all processes have alike.
pub(crate) struct PartialState<E, S> {
    /// Vectors of as many entries as there are unknowns.
    pub vectors: Vec<Vec<E>>,
    /// The rest.
    pub shared: S,
    /// The next iteration.
    pub next: usize,
}

/// Loads the state of the `n` unknowns of this process; `decode` decodes a stage of a number of unknowns. `None` on all processes if there is none.
pub(crate) fn load<E: VectorEntry, S>(
    store: &dyn CheckpointStore,
    stage: &str,
    sums: SumOrder,
    n: usize,
    decode: impl Fn(&[u8], usize) -> Option<PartialState<E, S>>,
) -> Option<PartialState<E, S>> {
    let found = load_own(store, stage, sums, n, decode);
    // All processes go on from one iteration, or none.
    let next = found.as_ref().map_or(0, |state| state.next as u64);
    let [least, most] = sums.over_processes([next, next], |a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    found.filter(|_| least == most)
}

fn load_own<E: VectorEntry, S>(
    store: &dyn CheckpointStore,
    stage: &str,
    sums: SumOrder,
    n: usize,
    decode: impl Fn(&[u8], usize) -> Option<PartialState<E, S>>,
) -> Option<PartialState<E, S>> {
    let whole = || if sums.is_divided() { None } else { store.load(stage) };
    if let Some(bytes) = whole() {
        return decode(&bytes, n);
    }
    let parts = store.load(&parts_stage(stage)).and_then(|b| b.try_into().ok()).map(u64::from_le_bytes);
    let parts = parts.unwrap_or(1) as usize;
    let own = sums.own_planes();
    let mut state: Option<PartialState<E, S>> = None;
    for part in 0..parts {
        let planes = part_of(sums.planes(), part, parts);
        let start = own.start.max(planes.start);
        let common = start..own.end.min(planes.end).max(start);
        // A process without planes takes the patches of the first stage.
        if common.is_empty() && !(own.is_empty() && part == 0) {
            continue;
        }
        let name = if parts == 1 { stage.to_string() } else { part_stage(stage, part, parts) };
        let found = decode(&store.load(&name)?, sums.length_of_part(n, planes.len()))?;
        let target = state.get_or_insert_with(|| PartialState {
            vectors: vec![vec![E::ZERO; n]; found.vectors.len()],
            shared: found.shared,
            next: found.next,
        });
        if target.next != found.next || target.vectors.len() != found.vectors.len() {
            return None;
        }
        for (to, from) in target.vectors.iter_mut().zip(&found.vectors) {
            sums.copy_planes(to, from, &planes, &common);
        }
    }
    state
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::sum_order::SharedZones;
    use crate::distribution::sum_order::tests::{part_of_rank, zones};
    use crate::distribution::thread_ranks::on_ranks;
    use std::collections::HashMap;
    use std::sync::Mutex;

    #[derive(Default)]
    struct InMemory(Mutex<HashMap<String, Vec<u8>>>);
    impl CheckpointStore for InMemory {
        fn load(&self, stage: &str) -> Option<Vec<u8>> {
            self.0.lock().unwrap().get(stage).cloned()
        }
        fn save(&self, stage: &str, bytes: &[u8]) {
            self.0.lock().unwrap().insert(stage.into(), bytes.into());
        }
    }

    /// A state of one vector: its entries, then the next iteration.
    fn decode(bytes: &[u8], n: usize) -> Option<PartialState<f64, ()>> {
        let numbers: Vec<f64> =
            bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect();
        let (next, vector) = numbers.split_last()?;
        (vector.len() == n).then(|| PartialState {
            vectors: vec![vector.to_vec()],
            shared: (),
            next: *next as usize,
        })
    }

    fn encode(values: impl Iterator<Item = usize>, next: usize) -> Vec<u8> {
        values.chain([next]).flat_map(|x| (x as f64).to_le_bytes()).collect()
    }

    /// Entries of a vector of some voxels beside five patches.
    fn length(voxels: usize, has_slopes: bool) -> usize {
        let patches = zones([1, 1, 1]).patches.len();
        patches + voxels + if has_slopes { 2 * patches + 3 * voxels } else { 0 }
    }

    /// Saves a state whose entries are their numbers, on some processes.
    fn save_numbers(store: &InMemory, dims: [usize; 3], has_slopes: bool, processes: usize) {
        let all = zones(dims);
        if processes == 1 {
            let numbers = 0..length(all.voxels.len(), has_slopes);
            return save(store, "state", SharedZones::alone(&all).order(), &encode(numbers, 11));
        }
        on_ranks(processes, |c| {
            let (part, global) = part_of_rank(&all, dims, [c.rank(), processes]);
            let numbers = (0..length(part.voxels.len(), has_slopes)).map(global);
            save(store, "state", SharedZones::new(&part, c).order(), &encode(numbers, 11));
        });
    }

    /// Loads the state on some processes and compares it, or expects none.
    fn check(store: &InMemory, dims: [usize; 3], has_slopes: bool, processes: usize, is_whole: bool) {
        let all = zones(dims);
        on_ranks(processes, |c| {
            let (part, global) = part_of_rank(&all, dims, [c.rank(), processes]);
            let (order, n) = (SharedZones::new(&part, c).order(), length(part.voxels.len(), has_slopes));
            let found = load(store, "state", order, n, decode);
            assert_eq!(found.is_some(), is_whole);
            let Some(found) = found else { return };
            let want: Vec<f64> = (0..n).map(|i| global(i) as f64).collect();
            assert_eq!((found.next, &found.vectors[..]), (11, &[want][..]), "{dims:?} on {processes}");
        });
    }

    #[test]
    fn states_resume_on_any_number_of_processes() {
        for (dims, has_slopes) in
            [([7, 3, 2], false), ([7, 3, 2], true), ([2, 2, 2], false), ([2, 2, 2], true)]
        {
            for [saved_by, loaded_by] in [[4, 3], [3, 4], [1, 3], [2, 2]] {
                let store = InMemory::default();
                save_numbers(&store, dims, has_slopes, saved_by);
                check(&store, dims, has_slopes, loaded_by, true);
                if saved_by > 1 {
                    // A stage of another iteration: no process goes on from it.
                    let planes = part_of(dims[0], 0, saved_by).len() * dims[1] * dims[2];
                    let stage = part_stage("state", 0, saved_by);
                    store.save(&stage, &encode(0..length(planes, has_slopes), 21));
                    check(&store, dims, has_slopes, loaded_by, false);
                }
            }
            // One process that has all zones.
            let (all, store) = (zones(dims), InMemory::default());
            save_numbers(&store, dims, has_slopes, 4);
            let n = length(all.voxels.len(), has_slopes);
            let found = load(&store, "state", SharedZones::alone(&all).order(), n, decode).unwrap();
            assert_eq!(found.vectors, [(0..n).map(|i| i as f64).collect::<Vec<_>>()]);
        }
    }
}
