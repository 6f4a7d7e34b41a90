//! Optical depths and transmittances along segments.
//!
//! ```text
//! τ = e^{−δ},   δ = Σ_cells κ ℓ + Σ_panes κ t/|cosθ|
//! ```
//!
//! The sum over cells is exact because the extinction κ (1/m) is constant in each cell; ℓ is the length in the cell (m), t the
//! thickness of the pane (m). A closed solid holds no medium, and no free segment runs through one, so the traversal does not test
//! for solids.

use crate::bvh::Bvh;
use crate::grid_traversal;
use crate::transport::{PaneHit, Transport};
use zonal_math::Vec3;
use zonal_scene::Bands;

/// A crossing this near to an edge of its plate, in plate parameters, may be met on the neighbouring plate too.
const EDGE_PARAMETER_TOLERANCE: f64 = 1e-9;

impl Transport<'_> {
    /// Calls `each` with the panes that the segment a–b crosses, by ascending t. A pane that holds an end is not crossed.
    pub fn pane_crossings(&self, a: Vec3, b: Vec3, each: &mut dyn FnMut(PaneHit)) {
        self.crossings(self.panes(), a, b, each);
    }

    fn crossings(&self, panes: &Bvh, a: Vec3, b: Vec3, each: &mut dyn FnMut(PaneHit)) {
        if panes.len() == 0 {
            return;
        }
        let length = (b - a).length();
        let mut hits: Vec<(PaneHit, bool)> = Vec::new();
        panes.all(a, b, self.tolerance(), &mut |id, [t, u, v], along| {
            let (pane, plate) = self.pane_plate(id);
            let hit = PaneHit {
                t: t * length,
                pane: pane as usize,
                plate: plate as usize,
                cos: along.abs() / length,
            };
            let edges = [u, v, 1.0 - u, 1.0 - v, 1.0 - u - v];
            hits.push((hit, edges.iter().any(|e| e.abs() < EDGE_PARAMETER_TOLERANCE)));
        });
        hits.sort_by(|x, y| {
            let order = x.0.t.total_cmp(&y.0.t);
            order.then((x.0.pane, x.0.plate).cmp(&(y.0.pane, y.0.plate)))
        });
        // Report a crossing of a shared edge once.
        let mut last: Option<(PaneHit, bool)> = None;
        for h in hits {
            let same = last.is_some_and(|l| {
                l.1 && h.1
                    && h.0.t - l.0.t <= self.tolerance().plane / h.0.cos
                    && (h.0.cos - l.0.cos).abs() < 1e-9
            });
            if !same {
                each(h.0);
            }
            last = Some(h);
        }
    }

    /// ∫ κ ds over medium and panes along a–b, per band. A pane adds κ t/|cosθ|, unless it holds a or b.
    pub fn optical_depth(&self, a: Vec3, b: Vec3) -> Bands {
        self.total_depth(self.panes(), a, b)
    }
    /// [`Transport::optical_depth`] for two points of the scene itself: tests only the panes that can lie between such points.
    pub fn optical_depth_inside(&self, a: Vec3, b: Vec3) -> Bands {
        self.total_depth(self.interior_panes(), a, b)
    }

    /// ∫ κ ds over the panes alone that lie between two points of the scene itself, per band.
    pub fn pane_depth_inside(&self, a: Vec3, b: Vec3) -> Bands {
        self.pane_depth(self.interior_panes(), a, b)
    }

    fn total_depth(&self, panes: &Bvh, a: Vec3, b: Vec3) -> Bands {
        self.medium_depth(a, b) + self.pane_depth(panes, a, b)
    }

    fn pane_depth(&self, panes: &Bvh, a: Vec3, b: Vec3) -> Bands {
        let mut sum = Bands::ZERO;
        self.crossings(panes, a, b, &mut |h| {
            sum += self.slant_depth(&h);
        });
        sum
    }

    /// Optical depth κt/c of a pane along a segment that crosses it at cosine c, per band.
    #[inline]
    pub fn slant_depth(&self, hit: &PaneHit) -> Bands {
        let p = &self.scene().panes()[hit.pane];
        p.extinction * p.thickness / hit.cos
    }

    /// ∫ κ ds over the medium alone, per band.
    pub fn medium_depth(&self, a: Vec3, b: Vec3) -> Bands {
        let mut sum = Bands::ZERO;
        if self.scene().voxel_grid().is_none_or(|g| g.uniform_extinction() == Some(Bands::ZERO)) {
            return sum;
        }
        self.traverse_extinction(a, b, &mut |kappa, t0, t1| sum += kappa * (t1 - t0));
        sum
    }

    /// Calls `each` with extinction (1/m), t0 and t1 of the pieces of a–b inside the grid, in order, t in metres from a. A piece has one extinction, as its
    /// neighbours may have.
    #[inline]
    pub fn traverse_extinction(&self, a: Vec3, b: Vec3, each: &mut impl FnMut(Bands, f64, f64)) {
        let Some(grid) = self.scene().voxel_grid() else { return };
        if let Some(kappa) = grid.uniform_extinction() {
            if let Some((_, t0, t1)) = grid_traversal::clip_to_grid(grid, a, b) {
                each(kappa, t0, t1);
            }
            return;
        }
        match self.uniform_blocks() {
            Some(blocks) => blocks.traverse(grid, a, b, each),
            None => grid_traversal::traverse(grid, a, b, &mut |cell, t0, t1| {
                each(grid.extinction(cell), t0, t1);
            }),
        }
    }

    /// Transmittance e^{−δ} along a–b, per band; `None` when a facet occludes.
    pub fn transmittance(&self, a: Vec3, b: Vec3) -> Option<Bands> {
        if self.occluded(a, b) {
            return None;
        }
        Some((-self.optical_depth(a, b)).exp())
    }
    /// [`Transport::transmittance`] for two points of the scene itself.
    pub fn transmittance_inside(&self, a: Vec3, b: Vec3) -> Option<Bands> {
        if self.occluded_inside(a, b) {
            return None;
        }
        Some((-self.optical_depth_inside(a, b)).exp())
    }
}
