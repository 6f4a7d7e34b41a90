//! Groups of neighbouring facets whose patches are merged in the second solve, where patches cannot be larger than their facets.
//!
//! Facets that have the same patches in both solves are grouped with neighbours across edges, of the same surface, whose normals deviate from that of the
//! first facet by at most [`MIN_COSINE`]: a smooth surface of many facets gets zones about twice as large. Facets beyond an edge of a body have other
//! radiosities by the shape of the body, not by the size of their zones, and stay apart.
//!
//! **Cost:** O(n log n) for n patches.

use std::collections::{HashMap, HashSet};
use zonal_math::Vec3;
use zonal_scene::shells::{WELD_TOLERANCE, edge_neighbours};
use zonal_scene::{MergedPatches, Patch, Plate, Zones};

/// Number of patches of a full group: twice the length along both directions.
const FULL_GROUP: usize = 4;
/// Smallest cosine between the normals of a group, of 45°: neighbours on a ball of 20 facets differ by 42°.
const MIN_COSINE: f64 = 0.7;

/// Number of groups below which a smooth surface has few zones.
const MIN_GROUPS: usize = 4;

/// Groups of patches, and how far they are to be relied on.
pub(super) struct MergedFacets {
    /// The groups.
    pub merged: MergedPatches,
    /// Share of the area of all patches that lies on merged smooth surfaces of fewer than [`MIN_GROUPS`] groups.
    pub few_groups_share: f64,
}

/// Groups of the patches of facets that have as many patches in both lists of zones.
pub(super) fn merge_unchanged(zones: &Zones, others: &Zones) -> MergedFacets {
    let counts = [zones, others].map(|z| patches_of_facets(&z.patches));
    let is_unchanged = |p: &Patch| counts[0].get(&p.facet) == counts[1].get(&p.facet);
    let kept: Vec<u32> =
        (0..others.patches.len() as u32).filter(|&i| is_unchanged(&others.patches[i as usize])).collect();
    let neighbours = smooth_neighbours(&others.patches, &kept);
    let mut group_of = vec![usize::MAX; kept.len()];
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for first in 0..kept.len() {
        if group_of[first] != usize::MAX {
            continue;
        }
        let mut group = vec![first];
        group_of[first] = groups.len();
        let mut next = 0;
        while next < group.len() && group.len() < FULL_GROUP {
            for &k in &neighbours[group[next]] {
                let fits = group_of[k] == usize::MAX && group.len() < FULL_GROUP;
                if fits && is_smooth(normal(others, &kept, first), normal(others, &kept, k)) {
                    group_of[k] = groups.len();
                    group.push(k);
                }
            }
            next += 1;
        }
        groups.push(group);
    }
    join_single_patches(&mut groups, &mut group_of, &neighbours);
    let area = |k: usize| others.patches[kept[k] as usize].area;
    let few = area_of_few_groups(&groups, &group_of, &neighbours, &area);
    let all: f64 = others.patches.iter().map(|p| p.area).sum();
    let patches = |g: Vec<usize>| g.into_iter().map(|k| kept[k]).collect();
    let merged = MergedPatches::new(groups.into_iter().filter(|g| g.len() > 1).map(patches).collect());
    MergedFacets { merged, few_groups_share: if few > 0.0 { few / all } else { 0.0 } }
}

/// Area of the merged patches on smooth surfaces of few groups, m².
fn area_of_few_groups(
    groups: &[Vec<usize>],
    group_of: &[usize],
    neighbours: &[Vec<usize>],
    area: &dyn Fn(usize) -> f64,
) -> f64 {
    let (mut seen, mut few) = (vec![false; group_of.len()], 0.0);
    for first in 0..group_of.len() {
        if seen[first] {
            continue;
        }
        // Collect the patches of the smooth surface.
        let mut surface = vec![first];
        seen[first] = true;
        let mut next = 0;
        while next < surface.len() {
            for &k in &neighbours[surface[next]] {
                if !std::mem::replace(&mut seen[k], true) {
                    surface.push(k);
                }
            }
            next += 1;
        }
        let own: HashSet<usize> = surface.iter().map(|&k| group_of[k]).collect();
        let is_merged = |k: &&usize| groups[group_of[**k]].len() > 1;
        if own.len() < MIN_GROUPS {
            few += surface.iter().filter(is_merged).map(|&k| area(k)).sum::<f64>();
        }
    }
    few
}

/// Joins each patch that is left alone to its smallest neighbouring group.
fn join_single_patches(groups: &mut [Vec<usize>], group_of: &mut [usize], neighbours: &[Vec<usize>]) {
    for g in 0..groups.len() {
        let &[k] = &groups[g][..] else { continue };
        let others = neighbours[k].iter().map(|&n| group_of[n]).filter(|&other| other != g);
        if let Some(other) = others.min_by_key(|&other| (groups[other].len(), other)) {
            groups[g].clear();
            groups[other].push(k);
            group_of[k] = other;
        }
    }
}

fn normal(zones: &Zones, kept: &[u32], k: usize) -> Vec3 {
    zones.patches[kept[k] as usize].normal
}

fn is_smooth(a: Vec3, b: Vec3) -> bool {
    a.dot(b) >= MIN_COSINE
}

/// Number of patches of each facet.
fn patches_of_facets(patches: &[Patch]) -> HashMap<usize, usize> {
    let mut out = HashMap::new();
    patches.iter().for_each(|p| *out.entry(p.facet).or_insert(0) += 1);
    out
}

/// For each patch of `kept`, its neighbours across edges of the same surface with a similar normal, as indices into `kept`.
fn smooth_neighbours(patches: &[Patch], kept: &[u32]) -> Vec<Vec<usize>> {
    let patch = |k: u32| &patches[kept[k as usize] as usize];
    let plates: Vec<Plate> = (0..kept.len() as u32).map(|k| patch(k).plate).collect();
    let mut out = vec![Vec::new(); kept.len()];
    for [a, b] in edge_neighbours(&plates, WELD_TOLERANCE) {
        let (p, q) = (patch(a), patch(b));
        if p.surface == q.surface && is_smooth(p.normal, q.normal) {
            out[a as usize].push(b as usize);
            out[b as usize].push(a as usize);
        }
    }
    out.iter_mut().for_each(|list| {
        list.sort_unstable();
        list.dedup();
    });
    out
}
