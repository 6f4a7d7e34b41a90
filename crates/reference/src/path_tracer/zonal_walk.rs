//! Random walks on zones: the zonal equations solved for single zones, without factors and without a matrix.
//!
//! With F the exchange areas, m = A of a patch and 4κV of a volume zone,
//!
//! ```text
//! H_i or G_i = Σ_j (F_ij/m_i) B_j        B_j = E_j + r_j (H_j + H_dir,j)
//! ```
//!
//! A path that starts at a uniformly random point of zone i ends in zone j with the probability F_ij/m_i. If it goes on from a
//! uniformly random point of zone j in place of the point that it met, its next step has the probabilities of the row of j, independent
//! of what came before: its mean is the solution of the zonal equations, with no error but its standard error. The light of suns, skies
//! and emitters at that random point has the zone's mean H_dir.
//!
//! A walk may go on from the point that it met where a path from a surface ends on a patch close by. Its mean is then the solution of equations
//! that resolve the radiosity within such patches, as the rays of the rays engine do.

use super::detector::Detector;
use super::flight::PathVertex;
use zonal_math::Vec3;
use zonal_scene::Bands;

/// Tells in which zone a point lies; zones have global indices.
pub trait ZoneLocator: Sync {
    /// The zone on a side of a facet at plate parameters; `None` where the side has no zones.
    fn on_facet(&self, facet: u32, front: bool, uv: [f64; 2]) -> Option<usize>;
    /// The zone in the medium; `None` outside its zones.
    fn in_medium(&self, at: Vec3) -> Option<usize>;
    /// The zone of a pane.
    fn in_pane(&self, pane: usize, at: Vec3) -> Option<usize>;
}

/// The zones of walks.
pub struct WalkZones<'a> {
    /// The zones as detectors, in their global order.
    pub detectors: Vec<Detector>,
    /// The reflectance of each patch, the mean over it.
    pub reflectances: Vec<Bands>,
    /// A path from a surface goes on from the point that it meets where its length is below this many square roots of the area of the patch met;
    /// 0 for the zonal equations.
    pub max_continued_patch_sizes: f64,
    /// Tells where points lie.
    pub locator: &'a dyn ZoneLocator,
}

impl WalkZones<'_> {
    /// True where a path from `vertex` that meets patch `i` at a distance goes on from the point met.
    pub(super) fn continues(&self, vertex: &PathVertex, i: usize, distance: f64) -> bool {
        let Detector::Patch { plate, .. } = &self.detectors[i] else { return false };
        let from_surface = matches!(vertex, PathVertex::Surface { .. });
        from_surface && distance < self.max_continued_patch_sizes * plate.area().sqrt()
    }
}
