//! Memory of the hierarchical engine beforehand, and how many rays and links fit into what is allowed.
//!
//! ```text
//! bytes = PROGRAM + zones + CUT (cut voxels) + n (ZONE + lights LIGHT + groups GROUP) + rays (4, +12 where bands differ, + those that go on)
//! ```
//!
//! The constants were measured as the growth of the resident memory at its peak (smoothing and the fields of the solution) over 58,475,
//! 10,376 and 1,966,188 zones.

use super::build::beyond_links;
use super::onward;
use super::seeing;
use crate::{dense, groups};
use zonal_scene::{Note, Scene, Zones};
use zonal_transport::Transport;

/// Bytes of the program itself: what is resident at the end of a solve of six zones (14.5 MB), and a reserve.
pub const PROGRAM: u64 = 16_000_000;
/// Bytes of a cut voxel while zones are made and rays shot, beside its samples: a sphere of 528 triangles in 40³ and, with a pane, in 32³ cells.
const CUT: u64 = 2_000;
/// Bytes a zone at the peak, whatever shines.
const ZONE: u64 = 330;
/// The same for each light, and for each light group.
const LIGHT: u64 = 108;
const GROUP: u64 = 80;
/// Bytes of a ray: the zone it meets; and what it counts in each band, where bands differ.
const RAY: f64 = 4.0;
const WORTH: f64 = 12.0;
/// Places a ray from which it goes on, about, where rays do.
const ONWARD: f64 = 0.25;
/// The fewest rays of a patch that are worth shooting.
const LEAST: f64 = 8.0;
/// Links in each direction: so many a zone over the tolerance where rays fall short of it, no more than a share of all pairs. Measured on
/// rooms with a block.
const LINKS: f64 = 2.5;
const MOST_LINKS: f64 = 0.75;
/// Bytes of a link while links are found: pairs, and links in the order of their zones; and for each distinct band.
const LINK: f64 = 16.0;
const LINK_BAND: f64 = 32.0;

/// What the memory of a hierarchical solve goes into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Bytes without rays and links.
    pub fixed: u64,
    /// Bytes of a ray that goes nowhere on.
    pub plain: f64,
    /// Bytes of a ray, its going on included.
    pub ray: f64,
    /// Bytes of a link.
    pub link: f64,
    /// The largest number of rays that fit beside the rest.
    pub rays: f64,
    /// Bytes for links once the rays are gone.
    pub links: f64,
}

impl Budget {
    /// For a solve within `memory` bytes.
    pub fn new(scene: &Scene, zones: &Zones, transport: &Transport, memory: u64) -> Budget {
        let n = zones.len();
        let groups = groups::chosen(scene, zones).0.len();
        let each = ZONE + LIGHT * scene.lights().len() as u64 + GROUP * groups as u64;
        let cut = zones.voxels.iter().filter(|z| !z.part.is_empty()).count() as u64;
        let fixed = PROGRAM + crate::forecast::zone_bytes(zones) + CUT * cut + n as u64 * each;
        let bands = dense::groups(scene, transport.has_panes_between()).1;
        let grey = bands == 1 && scene.panes().is_empty();
        let onward = if beyond_links(zones) { ONWARD * onward::BYTES as f64 } else { 0.0 };
        let plain = RAY + if grey { 0.0 } else { WORTH };
        let ray = plain + onward;
        let left = memory.saturating_sub(fixed) as f64;
        Budget { fixed, plain, ray, link: LINK + LINK_BAND * bands as f64, rays: left / ray, links: left }
    }

    /// Bytes without which there is nothing to begin with: everything but rays, and the fewest of these.
    pub fn least(&self, zones: &Zones) -> u64 {
        let (patches, n) = (zones.voxel_offset() as f64, zones.len() as f64);
        self.fixed
            + (self.ray * (n + LEAST * (patches + seeing::volume(zones) * (n - patches)))).ceil() as u64
    }

    /// Rays of a patch and of a volume zone for a tolerance; `None` where memory allows too few to be worth it.
    pub fn each(&self, zones: &Zones, tolerance: f64) -> Option<[usize; 2]> {
        let enough = self.least(zones) <= self.fixed + (self.rays * self.ray) as u64;
        enough.then(|| seeing::rays(zones, tolerance, self.rays))
    }

    /// True where the links to expect fit beside the rest.
    pub fn holds_links(&self, zones: &Zones, tolerance: f64) -> bool {
        links(zones, tolerance) * self.link <= self.links
    }

    /// What to say where memory allows fewer rays than the tolerance asks for.
    pub fn note(&self, zones: &Zones, tolerance: f64, each: [usize; 2]) -> Option<Note> {
        let wanted = seeing::rays(zones, tolerance, f64::INFINITY);
        (each[0] < wanted[0] || each[1] < wanted[1]).then(|| {
            let text = format!(
                "memory allows {} rays of a patch and {} of a volume zone in place of {} and {}: the tolerance may be missed; allow more (--max-memory)",
                each[0], each[1], wanted[0], wanted[1]
            );
            Note::warning("memory", text)
        })
    }

    /// Bytes with so many rays of every patch and volume zone.
    pub fn with_rays(&self, zones: &Zones, each: [usize; 2]) -> u64 {
        self.fixed + (self.ray * seeing::count(zones, each) as f64) as u64
    }

    /// Bytes with so many links in each direction.
    pub fn with_links(&self, links: f64) -> u64 {
        self.fixed + (self.link * links) as u64
    }
}

/// Links in each direction to expect where rays do not meet the tolerance.
pub fn links(zones: &Zones, tolerance: f64) -> f64 {
    let n = zones.len() as f64;
    (LINKS * n / tolerance).min(MOST_LINKS * n * n)
}
