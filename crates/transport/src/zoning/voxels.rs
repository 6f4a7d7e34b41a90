//! Volume zones of the voxmap.

use super::cells::{Gaps, Resolved, resolve};
use super::overlap::{Met, overlaps};
use crate::Transport;
use rayon::prelude::*;
use zonal_math::Vec3;
use zonal_scene::{Part, Scene, VoxelZone, Voxmap};

/// The voxel zones by ascending cell, and where each cell's begin.
pub(super) fn voxels(scene: &Scene, map: &Voxmap, transport: &Transport) -> (Vec<VoxelZone>, Vec<u32>) {
    let (met, pairs) = overlaps(scene, map, transport.tolerance().edge);
    let bare = whole_without_medium(map, transport, &met);
    let runs: Vec<&[(u32, u32)]> = pairs.chunk_by(|a, b| a.0 == b.0).collect();
    let cut: Vec<Resolved> = runs
        .par_iter()
        .map_init(Gaps::new, |gaps, run| {
            let facets: Vec<u32> = run.iter().map(|x| x.1).collect();
            resolve(transport, map, map.coordinates(run[0].0 as usize), &facets, gaps)
        })
        .collect();
    if runs.is_empty() && bare.is_empty() {
        return whole(map);
    }
    let parts = |r: &Resolved| if let Resolved::Parts(p) = r { p.len() } else { 1 };
    let whole = met.iter().filter(|m| **m != Met::Cut).count();
    let mut zones = Vec::with_capacity(whole + cut.iter().map(parts).sum::<usize>());
    let mut first = Vec::with_capacity(map.len() + 1);
    let mut cut = cut.into_iter();
    let volume = map.cell().product();
    for cell in 0..map.len() {
        first.push(zones.len() as u32);
        let whole = || zone(map, cell, map.centre(map.coordinates(cell)), volume, Part::default());
        match met[cell] {
            Met::Cut => match cut.next() {
                Some(Resolved::Parts(parts)) => {
                    zones.extend(parts.into_iter().map(|p| zone(map, cell, p.centre, p.volume, p.samples)))
                }
                _ => zones.push(whole()),
            },
            _ if !bare.is_empty() && bare[cell] => {}
            _ => zones.push(whole()),
        }
    }
    first.push(zones.len() as u32);
    (zones, first)
}

/// Every cell a zone.
fn whole(map: &Voxmap) -> (Vec<VoxelZone>, Vec<u32>) {
    let volume = map.cell().product();
    let one = |cell: usize| zone(map, cell, map.centre(map.coordinates(cell)), volume, Part::default());
    ((0..map.len()).into_par_iter().map(one).collect(), (0..=map.len() as u32).collect())
}

fn zone(map: &Voxmap, cell: usize, centre: Vec3, volume: f64, part: Part) -> VoxelZone {
    VoxelZone {
        cell,
        centre,
        volume,
        part,
        extinction: map.extinction(cell),
        albedo: map.albedo(cell),
        emission: map.emission(cell),
        source: map.source(cell),
    }
}

/// For each uncut cell: does it lie where no medium takes part? Empty when it takes part everywhere. Between neighbours that no facet touches nothing
/// changes, so few cells are asked.
fn whole_without_medium(map: &Voxmap, transport: &Transport, met: &[Met]) -> Vec<bool> {
    if !transport.has_places_without_medium() {
        return Vec::new();
    }
    let ask = |cell: usize| !transport.holds_medium(map.centre(map.coordinates(cell)));
    let mut bare: Vec<bool> =
        (0..map.len()).into_par_iter().map(|c| met[c] == Met::Touched && ask(c)).collect();
    let dims = map.dims();
    let stride = [dims[1] * dims[2], dims[2], 1];
    for cell in (0..map.len()).filter(|c| met[*c] == Met::Not) {
        let c = map.coordinates(cell);
        let known = (0..3).filter(|&k| c[k] > 0).map(|k| cell - stride[k]).find(|n| met[*n] == Met::Not);
        bare[cell] = known.map_or_else(|| ask(cell), |n| bare[n]);
    }
    bare
}
