//! Memory of the rays engine, estimated beforehand, and the rays that fit into the limit.
//!
//! ```text
//! bytes = program + zones + cut · (cut voxels) + n (zone + lights · light + groups · group) + rays (4, +12 where bands differ, + vertices)
//! ```

use crate::engines::dense::band_groups::{BandGroups, InteriorPanes};
use crate::engines::problem_size::zone_bytes;
use crate::engines::rays::stored_rays::path_continuation::VERTEX_BYTES;
use crate::engines::rays::stored_rays::ray_sampling::{RaysPerZone, rays_per_zone, volume_to_patch_ratio};
use crate::right_hand_side::light_groups::select_groups;
use zonal_scene::{Diagnostic, Scene, Zones};
use zonal_transport::Transport;

/// Bytes of the program itself: the resident memory at the end of a solve of six zones (14.5 MB), and a reserve.
pub(crate) const PROGRAM_BYTES: u64 = 16_000_000;

// Bytes and numbers of the parts of a solve.
//
// The bytes of zones, lights and groups were measured as the growth of the peak resident memory (smoothing, and the fields of the solution)
// over 58,475, 10,376 and 1,966,188 zones.

/// Bytes of a cut voxel while zones are made and rays traced, beside its samples. Measured on a sphere of 528 triangles in 40³ cells and,
/// with a pane, in 32³.
const CUT_VOXEL_BYTES: u64 = 2_000;
/// Bytes of a zone at the peak.
const ZONE_BYTES: u64 = 330;
/// Bytes of a zone for each light.
const LIGHT_BYTES: u64 = 108;
/// Bytes of a zone for each light group.
const GROUP_BYTES: u64 = 80;
/// Bytes of the end of a ray.
const RAY_BYTES: f64 = 4.0;
/// Bytes of its weights, where bands differ.
const WEIGHT_BYTES: f64 = 12.0;
/// Path vertices of a ray where paths continue.
const VERTICES_PER_RAY: f64 = 0.25;
/// Fewest rays of a patch with which a solve begins.
const MIN_RAYS_OF_PATCH: f64 = 8.0;

/// Memory of the parts of a solve by the rays engine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MemoryBudget {
    /// Bytes without rays.
    pub fixed: u64,
    /// Bytes of a ray without path vertices.
    pub ray: f64,
    /// Bytes of a ray with the expected path vertices.
    pub continued_ray: f64,
    /// The largest number of rays that fits beside the rest.
    pub max_rays: f64,
}

impl MemoryBudget {
    /// For a solve within `memory` bytes.
    pub(crate) fn new(scene: &Scene, zones: &Zones, transport: &Transport, memory: u64) -> MemoryBudget {
        let n = zones.len();
        let groups = select_groups(scene, zones).0.len();
        let each = ZONE_BYTES + LIGHT_BYTES * scene.lights().len() as u64 + GROUP_BYTES * groups as u64;
        let cut = zones.voxels.cut_count() as u64;
        let fixed = PROGRAM_BYTES + zone_bytes(zones) + CUT_VOXEL_BYTES * cut + n as u64 * each;
        let bands = BandGroups::of_scene(scene, InteriorPanes::of(transport)).firsts.len();
        let grey = bands == 1 && scene.panes().is_empty();
        let vertices = VERTICES_PER_RAY * VERTEX_BYTES as f64;
        let ray = RAY_BYTES + if grey { 0.0 } else { WEIGHT_BYTES };
        let continued_ray = ray + vertices;
        let left = memory.saturating_sub(fixed) as f64;
        MemoryBudget { fixed, ray, continued_ray, max_rays: left / continued_ray }
    }

    /// Bytes without which no solve begins: everything except rays, and the fewest rays.
    pub(crate) fn min_bytes(&self, zones: &Zones) -> u64 {
        let (patches, n) = (zones.patches.len() as f64, zones.len() as f64);
        let rays = n + MIN_RAYS_OF_PATCH * (patches + volume_to_patch_ratio(zones) * (n - patches));
        self.fixed + (self.continued_ray * rays).ceil() as u64
    }

    /// Rays of a patch and of a volume zone for a tolerance; `None` where memory allows too few.
    pub(crate) fn affordable_rays(&self, zones: &Zones, tolerance: f64) -> Option<RaysPerZone> {
        let suffices = self.min_bytes(zones) <= self.fixed + (self.max_rays * self.continued_ray) as u64;
        suffices.then(|| rays_per_zone(zones, tolerance, self.max_rays))
    }

    /// A warning where memory allows fewer rays than the tolerance requires.
    pub(crate) fn ray_warning(&self, zones: &Zones, tolerance: f64, rays: RaysPerZone) -> Option<Diagnostic> {
        let wanted = rays_per_zone(zones, tolerance, f64::INFINITY);
        (rays[0] < wanted[0] || rays[1] < wanted[1]).then(|| {
            let text = format!(
                "memory allows {} rays of a patch and {} of a volume zone in place of {} and {}: the tolerance may be missed; allow more (--max-memory)",
                rays[0], rays[1], wanted[0], wanted[1]
            );
            Diagnostic::warning("memory", text)
        })
    }

    /// Bytes with this number of rays and path vertices.
    pub(crate) fn with_rays_and_vertices(&self, rays: u64, vertices: f64) -> u64 {
        self.fixed + (self.ray * rays as f64 + VERTEX_BYTES as f64 * vertices) as u64
    }
}
