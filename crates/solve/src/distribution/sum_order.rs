//! Sums over zones, or over the unknowns of an engine, in an order that depends neither on threads nor on processes.
//!
//! Entries are summed in chunks of fixed length, chunks in their order. Where every cell of the voxel grid is one zone, chunks end with the planes of the
//! grid: the voxels of a plane have one sum, and the sum of all is that of the planes in their order. Processes that have the voxels of some planes each
//! ([`zonal_scene::VoxelZones::of_cells`]) exchange the sums of planes. Patches, and all zones of other scenes, are on every process.
//!
//! Unknowns are the zones, then the slopes of the patches, then those of the voxels, component by component.

use crate::distribution::multivector::{CHUNK_LENGTH, VectorEntry};
use crate::distribution::{Communicator, Message, SingleProcess};
use std::ops::{Deref, Range};
use zonal_math::parallel;
use zonal_scene::Zones;

/// About the operations of a term of a sum.
pub(crate) const OPERATIONS_OF_TERM: usize = 4;

/// The order of sums over vectors.
#[derive(Clone, Copy)]
pub(crate) struct SumOrder<'a> {
    communicator: &'a dyn Communicator,
    patches: usize,
    voxels: usize,
    panes: usize,
    /// Voxels of a plane; `None` if planes do not matter.
    plane: Option<usize>,
    /// First voxel of this process, and number of voxels of all.
    first: usize,
    total: usize,
    /// True if each process has some planes alone.
    is_divided: bool,
}

/// Entries that are summed plane by plane, or without planes.
struct SumSegment {
    entries: Range<usize>,
    plane: Option<usize>,
}

impl SumSegment {
    /// Entries of a plane, or all.
    fn group(&self) -> usize {
        self.plane.unwrap_or(self.entries.len()).max(1)
    }
    /// The chunks of each plane.
    fn planes(&self) -> impl Iterator<Item = Vec<Range<usize>>> + '_ {
        let end = self.entries.end;
        self.entries.clone().step_by(self.group()).map(move |first| {
            let last = (first + self.group()).min(end);
            (first..last).step_by(CHUNK_LENGTH).map(|c| c..(c + CHUNK_LENGTH).min(last)).collect()
        })
    }
}

impl<'a> SumOrder<'a> {
    /// The order of vectors that have no planes.
    pub(crate) fn plain() -> SumOrder<'static> {
        SumOrder { plane: None, ..SumOrder::of_zones(&Zones::default(), &SingleProcess) }
    }

    /// The order of vectors over zones.
    pub(crate) fn of_zones(zones: &Zones, communicator: &'a dyn Communicator) -> SumOrder<'a> {
        SumOrder {
            communicator,
            patches: zones.patches.len(),
            voxels: zones.voxels.len(),
            panes: zones.panes.len(),
            plane: zones.voxels.plane_size(),
            first: zones.voxels.first_cell(),
            total: zones.voxels.total(),
            is_divided: zones.voxels.is_divided(),
        }
    }

    /// True if each process has some planes alone.
    pub(crate) fn is_divided(&self) -> bool {
        self.is_divided
    }
    /// The processes, if each has some planes alone.
    pub(crate) fn shared_by(&self) -> Option<&'a dyn Communicator> {
        self.is_divided.then_some(self.communicator)
    }
    /// Number of this process, and number of processes.
    pub(crate) fn process(&self) -> [usize; 2] {
        [self.communicator.rank(), self.communicator.size()]
    }
    /// Number of planes of all processes.
    pub(crate) fn planes(&self) -> usize {
        self.total / self.plane.unwrap_or(usize::MAX).max(1)
    }
    /// The planes of this process.
    pub(crate) fn own_planes(&self) -> Range<usize> {
        let plane = self.plane.unwrap_or(usize::MAX).max(1);
        self.first / plane..(self.first + self.voxels) / plane
    }
    /// The order of a process with other planes.
    fn with_planes(self, planes: usize) -> SumOrder<'a> {
        SumOrder { voxels: planes * self.plane.unwrap_or(0), ..self }
    }
    /// Number of components of the voxels in a vector of `n` entries.
    fn components(&self, n: usize) -> usize {
        if n > self.patches + self.voxels + self.panes { 4 } else { 1 }
    }
    /// Length of a vector of a process with `planes` planes, where one of this process has `n` entries.
    pub(crate) fn length_of_part(&self, n: usize, planes: usize) -> usize {
        let components = self.components(n);
        n - components * self.voxels + components * planes * self.plane.unwrap_or(0)
    }
    /// Copies the planes `common` of a vector `from` over the planes `part` to a vector `to` over the planes of this process, and what has no planes.
    pub(crate) fn copy_planes<T: Copy>(
        &self,
        to: &mut [T],
        from: &[T],
        part: &Range<usize>,
        common: &Range<usize>,
    ) {
        let (own, plane) = (self.own_planes(), self.plane.unwrap_or(0));
        let segments = self.with_planes(part.len()).segments(from.len());
        for (source, target) in segments.into_iter().zip(self.segments(to.len())) {
            let (from, to) = (&from[source.entries.clone()], &mut to[target.entries.clone()]);
            match target.plane {
                Some(_) if common.is_empty() => {}
                Some(_) => {
                    let at = |first: usize| (common.start - first) * plane..(common.end - first) * plane;
                    to[at(own.start)].copy_from_slice(&from[at(part.start)]);
                }
                None => to.copy_from_slice(from),
            }
        }
    }

    /// The segments of a vector of `n` entries: the zones, or all unknowns.
    fn segments(&self, n: usize) -> Vec<SumSegment> {
        let zones = self.patches + self.voxels + self.panes;
        if self.plane.is_none() || n < zones {
            return vec![SumSegment { entries: 0..n, plane: None }];
        }
        // A linear basis has two slopes of a patch and three of a voxel.
        let slopes = if n > zones { vec![(2 * self.patches, false); 1] } else { Vec::new() };
        let of_voxels = if n > zones { vec![(self.voxels, true); 3] } else { Vec::new() };
        let all = [(self.patches, false), (self.voxels, true), (self.panes, false)].into_iter();
        let mut next = 0;
        let segment = |(length, has_planes): (usize, bool)| {
            next += length;
            SumSegment { entries: next - length..next, plane: self.plane.filter(|_| has_planes) }
        };
        all.chain(slopes).chain(of_voxels).map(segment).collect()
    }

    /// The chunks of a vector of `n` entries.
    pub(crate) fn chunks(&self, n: usize) -> Vec<Range<usize>> {
        self.segments(n).iter().flat_map(SumSegment::planes).flatten().collect()
    }

    /// The sum of all processes from the sums of the chunks of this one.
    pub(crate) fn combine<T: VectorEntry + Message>(&self, n: usize, of_chunks: &[T]) -> T {
        let (segments, mut next) = (self.segments(n), 0);
        let sum = |list: &[T]| list.iter().fold(T::ZERO, |a, b| a.plus(*b));
        let mut of_planes = |segment: &SumSegment| -> Vec<T> {
            let one = |chunks: Vec<Range<usize>>| {
                next += chunks.len();
                sum(&of_chunks[next - chunks.len()..next])
            };
            segment.planes().map(one).collect()
        };
        let mut sums: Vec<Vec<T>> = segments.iter().map(&mut of_planes).collect();
        if self.is_divided {
            let mut bytes = Vec::new();
            let divided = |k: &usize| segments[*k].plane.is_some();
            for k in (0..sums.len()).filter(divided) {
                (sums[k].len() as u64).put(&mut bytes);
                sums[k].iter().for_each(|x| x.put(&mut bytes));
            }
            let all = self.communicator.all_gather(bytes);
            let mut read: Vec<&[u8]> = all.iter().map(Vec::as_slice).collect();
            for k in (0..sums.len()).filter(divided) {
                sums[k].clear();
                for bytes in &mut read {
                    let (length, rest) = bytes.split_at(8);
                    let (own, rest) = rest.split_at(u64::get(length) as usize * T::size());
                    sums[k].extend(own.chunks_exact(T::size()).map(T::get));
                    *bytes = rest;
                }
            }
        }
        sums.iter().fold(T::ZERO, |all, list| all.plus(sum(list)))
    }

    /// Σ term(i) over the `n` entries of a vector, those of the other processes included.
    pub(crate) fn sum<T: VectorEntry + Message>(&self, n: usize, term: impl Fn(usize) -> T + Sync) -> T {
        let of_chunk = |chunk: &Range<usize>| chunk.clone().fold(T::ZERO, |s, i| s.plus(term(i)));
        let chunks = self.chunks(n);
        let operations = OPERATIONS_OF_TERM * n / chunks.len().max(1);
        let partial: Vec<T> = parallel::collect_short(chunks.len(), operations, |k| of_chunk(&chunks[k]));
        self.combine(n, &partial)
    }

    /// `fold` over the values of all processes if they have different zones, in the order of the processes.
    pub(crate) fn over_processes<T: Message>(&self, own: T, fold: impl Fn(T, T) -> T) -> T {
        if !self.is_divided {
            return own;
        }
        let mut bytes = Vec::new();
        own.put(&mut bytes);
        let all = self.communicator.all_gather(bytes);
        all.iter().map(|bytes| T::get(bytes)).reduce(fold).unwrap_or(own)
    }
}

/// The zones of this process, with the processes that have the others.
#[derive(Clone, Copy)]
pub(crate) struct SharedZones<'a> {
    zones: &'a Zones,
    communicator: &'a dyn Communicator,
}

impl Deref for SharedZones<'_> {
    type Target = Zones;
    fn deref(&self) -> &Zones {
        self.zones
    }
}

impl<'a> SharedZones<'a> {
    /// Zones that processes may share.
    pub(crate) fn new(zones: &'a Zones, communicator: &'a dyn Communicator) -> SharedZones<'a> {
        SharedZones { zones, communicator }
    }

    /// Zones of one process.
    pub(crate) fn alone(zones: &'a Zones) -> SharedZones<'a> {
        SharedZones { zones, communicator: &SingleProcess }
    }

    /// The zones.
    pub(crate) fn zones(self) -> &'a Zones {
        self.zones
    }

    /// The order of sums over them.
    pub(crate) fn order(&self) -> SumOrder<'a> {
        SumOrder::of_zones(self.zones, self.communicator)
    }

    /// Σ term(i) over all zones.
    pub(crate) fn sum<T: VectorEntry + Message>(&self, term: impl Fn(usize) -> T + Sync) -> T {
        self.order().sum(self.zones.len(), term)
    }

    /// Σ term(k) over the voxel zones, numbered from 0.
    pub(crate) fn sum_voxels<T: VectorEntry + Message>(&self, term: impl Fn(usize) -> T + Sync) -> T {
        let order = SumOrder { patches: 0, panes: 0, ..self.order() };
        order.sum(self.zones.voxels.len(), term)
    }

    /// True if some zone has a negative source, so that its incident flux may be negative.
    pub(crate) fn has_negative_source(self) -> bool {
        self.any(|i| self.emission(i).any(|e| e < 0.0))
    }
    /// True if `holds` for some zone.
    pub(crate) fn any(&self, holds: impl Fn(usize) -> bool + Sync) -> bool {
        let own = parallel::any(self.zones.len(), &holds);
        self.order().over_processes(own, |a, b| a || b)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::distribution::thread_ranks::on_ranks;
    use zonal_math::{Vec3, vec3};
    use zonal_scene::{Patch, VoxelGrid, VoxelZones};

    /// Zones of a grid with five patches.
    pub(crate) fn zones(dims: [usize; 3]) -> Zones {
        let grid = VoxelGrid::new(Vec3::ZERO, vec3(1.0, 1.0, 1.0), dims).unwrap();
        let plate = zonal_scene::Plate::parallelogram(Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
        let patch = Patch {
            facet: 0,
            surface: 0,
            plate,
            normal: vec3(0.0, 0.0, 1.0),
            area: 1.0,
            reflectance: Default::default(),
            emission: Default::default(),
        };
        Zones { patches: vec![patch; 5], voxels: VoxelZones::whole(&grid), ..Zones::default() }
    }

    /// The zones of a rank, and the number of a local unknown among those of all ranks.
    pub(crate) fn part_of_rank(
        all: &Zones,
        dims: [usize; 3],
        [rank, size]: [usize; 2],
    ) -> (Zones, impl Fn(usize) -> usize + Sync + use<>) {
        let own = crate::distribution::part_of(dims[0], rank, size);
        let plane = dims[1] * dims[2];
        let (patches, voxels, local, first) =
            (all.patches.len(), all.voxels.len(), own.len() * plane, own.start * plane);
        let part = all.voxels.of_cells(first..first + local).unwrap();
        let global = move |i: usize| match i {
            i if i < patches => i,
            i if i < patches + local => i + first,
            i if i < 3 * patches + local => i - local + voxels,
            i => {
                let (component, k) = ((i - 3 * patches - local) / local, (i - 3 * patches) % local);
                3 * patches + voxels * (component + 1) + first + k
            }
        };
        (Zones { voxels: part, ..all.clone() }, global)
    }

    // Guards (determinism): sums do not depend on the division among processes.
    #[test]
    fn sums_do_not_depend_on_the_division() {
        for dims in [[7, 3, 2], [5, 70, 70], [1, 2, 2]] {
            let all = zones(dims);
            let term = |i: usize| 1.0 / (i as f64 + 0.3);
            let (patches, n) = (all.patches.len(), all.len());
            let unknowns = n + 2 * patches + 3 * all.voxels.len();
            let order = SharedZones::alone(&all).order();
            let want = [order.sum(n, term), order.sum(unknowns, term)];
            for size in [1, 2, 3, 7] {
                let found = on_ranks(size, |c| {
                    let (part, global) = part_of_rank(&all, dims, [c.rank(), size]);
                    let cells = part.voxels.len();
                    let order = SharedZones::new(&part, c).order();
                    let slopes = 2 * patches + 3 * cells;
                    [
                        order.sum(part.len(), |i| term(global(i))),
                        order.sum(part.len() + slopes, |i| term(global(i))),
                    ]
                });
                for found in found {
                    assert_eq!(found.map(f64::to_bits), want.map(f64::to_bits), "{dims:?} on {size}");
                }
            }
        }
    }

    #[test]
    fn chunks_cover_all_entries_once() {
        let all = zones([3, 90, 50]);
        for order in [SumOrder::plain(), SharedZones::alone(&all).order()] {
            for n in [all.len(), all.len() + 10 + 3 * all.voxels.len()] {
                let chunks = order.chunks(n);
                assert_eq!(chunks.iter().cloned().flatten().collect::<Vec<_>>(), (0..n).collect::<Vec<_>>());
                assert!(chunks.iter().all(|c| c.len() <= CHUNK_LENGTH));
            }
        }
    }
}
