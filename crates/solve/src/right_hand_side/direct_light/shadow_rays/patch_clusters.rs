//! Clusters of neighbouring patches, whose samples support one another in scenes without a voxel grid.
//!
//! If all N samples of the K patches of a cluster agree, then by the rule of succession the mean over the patches of the fraction of the light that
//! differs has the error ½/(N+1). It may all be on one patch; the root mean square over the patches is then √K times that mean:
//!
//! ```text
//! e = ½ √K/(N+1)
//! ```
//!
//! so that each patch needs 1/√K of the samples that it needs alone. Clusters form trees: the patches that face the same of six directions and have areas
//! within a factor of four are halved across their longest extent until at most [`PATCHES_PER_CLUSTER`] are together. A patch has the support of the largest
//! cluster around it whose samples agree, of at most [`MAX_PATCHES_PER_CLUSTER`]. Patches that the light does not face do not count.

use super::params::{MAX_PATCHES_PER_CLUSTER, PATCHES_PER_CLUSTER};
use super::zone_sampler::{DirectLightEstimate, largest};
use zonal_math::Vec3;
use zonal_scene::Patch;

/// The clusters of the patches of a scene.
pub(super) struct PatchClusters {
    /// The smallest cluster of each patch.
    cluster_of: Vec<u32>,
    /// The cluster that was halved into each; those of all patches of a kind are their own. Clusters follow those that hold them.
    parents: Vec<u32>,
}

impl PatchClusters {
    pub(super) fn new(patches: &[Patch]) -> PatchClusters {
        let centres: Vec<Vec3> = patches.iter().map(|p| p.plate.centre()).collect();
        let kind = |i: &u32| {
            let p = &patches[*i as usize];
            let n = p.normal;
            let axis = Vec3::from_array(n.array().map(f64::abs)).largest_axis();
            // Areas of a kind are within a factor of four.
            (axis, n[axis] > 0.0, (0.5 * p.area.log2()).floor() as i32)
        };
        let mut order: Vec<u32> = (0..patches.len() as u32).collect();
        order.sort_by_cached_key(kind);
        let mut clusters = PatchClusters { cluster_of: vec![0; patches.len()], parents: Vec::new() };
        for list in order.chunk_by_mut(|i, j| kind(i) == kind(j)) {
            let root = clusters.parents.len() as u32;
            clusters.divide(list, &centres, root);
        }
        clusters
    }

    /// Adds the cluster of some patches, within the cluster `parent`, and those that it is halved into.
    fn divide(&mut self, list: &mut [u32], centres: &[Vec3], parent: u32) {
        let own = self.parents.len() as u32;
        self.parents.push(parent);
        if list.len() <= PATCHES_PER_CLUSTER {
            list.iter().for_each(|i| self.cluster_of[*i as usize] = own);
            return;
        }
        let centre = |i: &u32| centres[*i as usize];
        let low = list.iter().map(centre).fold(Vec3::splat(f64::INFINITY), Vec3::min);
        let high = list.iter().map(centre).fold(Vec3::splat(f64::NEG_INFINITY), Vec3::max);
        let axis = (high - low).largest_axis();
        let along = |i: &u32| centre(i)[axis];
        let (below, _, _) =
            list.select_nth_unstable_by(list.len() / 2, |i, j| along(i).total_cmp(&along(j)).then(i.cmp(j)));
        let half = below.len();
        let (below, above) = list.split_at_mut(half);
        self.divide(below, centres, own);
        self.divide(above, centres, own);
    }

    /// The agreement of the estimates of all patches within each cluster.
    pub(super) fn agreement<'a>(&'a self, estimates: &[DirectLightEstimate]) -> ClusterAgreement<'a> {
        let mut tallies = vec![ClusterTally::default(); self.parents.len()];
        for (c, one) in self.cluster_of.iter().zip(estimates) {
            if largest(one.unoccluded) > 0.0 {
                let (bits, samples) = (one.visibility_bits(), u32::from(one.count));
                tallies[*c as usize].add(ClusterTally { bits, samples, patches: 1 });
            }
        }
        for (c, parent) in self.parents.iter().enumerate().rev().filter(|(c, p)| *c != **p as usize) {
            let own = tallies[c];
            tallies[*parent as usize].add(own);
        }
        ClusterAgreement { clusters: self, tallies }
    }
}

/// Samples of the patches of a cluster that the light faces.
#[derive(Clone, Copy, Default)]
struct ClusterTally {
    /// [`DirectLightEstimate::visibility_bits`] of all of them.
    bits: u8,
    samples: u32,
    patches: u32,
}

impl ClusterTally {
    fn add(&mut self, other: ClusterTally) {
        self.bits |= other.bits;
        self.samples += other.samples;
        self.patches += other.patches;
    }
}

/// Agreement of samples within clusters.
pub(super) struct ClusterAgreement<'a> {
    clusters: &'a PatchClusters,
    tallies: Vec<ClusterTally>,
}

impl ClusterAgreement<'_> {
    /// The tally of the largest cluster around patch `i` whose samples all agree with the patch's own; `None` where there is none.
    fn agreeing(&self, i: usize, one: &DirectLightEstimate) -> Option<&ClusterTally> {
        let agrees = |t: &&ClusterTally| {
            t.bits == one.visibility_bits() && t.patches as usize <= MAX_PATCHES_PER_CLUSTER
        };
        let within = |c: &usize| {
            let parent = self.clusters.parents[*c] as usize;
            (parent != *c).then_some(parent)
        };
        let first = one.agrees().then_some(self.clusters.cluster_of[i] as usize);
        let clusters = std::iter::successors(first, within).map(|c| &self.tallies[c]);
        clusters.take_while(agrees).last()
    }

    /// Number of samples that the cluster around patch `i` adds to those of its own, and √K: the number of samples that the patch needs alone over that with its
    /// cluster. 0 and 1 where no cluster agrees.
    pub(super) fn support(&self, i: usize, one: &DirectLightEstimate) -> (u32, f64) {
        let Some(tally) = self.agreeing(i, one) else { return (0, 1.0) };
        let root = f64::from(tally.patches.max(1)).sqrt();
        let added = f64::from(tally.samples + 1) / root - 1.0 - f64::from(one.count);
        (added.max(0.0) as u32, root)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zonal_math::vec3;
    use zonal_scene::{Bands, Plate};

    /// A row of unit squares in the plane z = 0, every third turned down.
    fn row(n: usize) -> Vec<Patch> {
        let square = |k: usize| {
            let (e1, e2) = (vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
            let [e1, e2] = if k.is_multiple_of(3) { [e2, e1] } else { [e1, e2] };
            let plate = Plate::parallelogram(vec3(k as f64, 0.0, 0.0), e1, e2);
            let (normal, area) = (plate.normal(), plate.area());
            let (reflectance, emission) = (Bands::ZERO, Bands::ZERO);
            Patch { facet: k, surface: 0, plate, normal, area, reflectance, emission }
        };
        (0..n).map(square).collect()
    }

    fn estimate(visible: f32) -> DirectLightEstimate {
        let unoccluded = Bands::splat(1.0);
        DirectLightEstimate { unoccluded, visible, count: 8, ..DirectLightEstimate::default() }
    }

    /// The patches of a cluster.
    fn patches_of(clusters: &PatchClusters, c: usize) -> Vec<usize> {
        let holds = |i: &usize| {
            let mut at = clusters.cluster_of[*i] as usize;
            while at != c && clusters.parents[at] as usize != at {
                at = clusters.parents[at] as usize;
            }
            at == c
        };
        (0..clusters.cluster_of.len()).filter(holds).collect()
    }

    #[test]
    fn clusters_face_one_direction_and_hold_neighbours() {
        let patches = row(1000);
        let clusters = PatchClusters::new(&patches);
        for c in 0..clusters.parents.len() {
            let of = patches_of(&clusters, c);
            assert!(of.iter().all(|i| patches[*i].normal == patches[of[0]].normal), "{of:?}");
            assert!(of.last().unwrap() - of[0] < 3 * of.len(), "{of:?}");
        }
        let smallest = clusters.cluster_of.iter().map(|c| patches_of(&clusters, *c as usize).len());
        assert!(smallest.into_iter().all(|n| (PATCHES_PER_CLUSTER / 2..=PATCHES_PER_CLUSTER).contains(&n)));
    }

    #[test]
    fn patches_have_the_support_of_the_largest_cluster_that_agrees() {
        let patches = row(1000);
        let clusters = PatchClusters::new(&patches);
        let mut list = vec![estimate(0.0); 1000];
        list[500] = estimate(0.5);
        let agreement = clusters.agreement(&list);
        let mut largest = 0;
        for (i, one) in list.iter().enumerate() {
            let smallest = patches_of(&clusters, clusters.cluster_of[i] as usize);
            if smallest.contains(&500) {
                assert_eq!(agreement.support(i, one), (0, 1.0));
                continue;
            }
            let (support, saving) = agreement.support(i, one);
            let k = saving.powi(2);
            assert!(k > smallest.len() as f64 - 0.5 && k < MAX_PATCHES_PER_CLUSTER as f64 + 0.5, "{k}");
            let supported = DirectLightEstimate { support, ..*one };
            let error = 0.5 * k.sqrt() / (8.0 * k + 1.0);
            let stated = supported.relative_error();
            assert!(stated >= error && stated < 1.1 * error, "{stated} {error}");
            largest = largest.max(k.round() as usize);
        }
        assert!(largest > MAX_PATCHES_PER_CLUSTER / 2, "{largest}");
    }
}
