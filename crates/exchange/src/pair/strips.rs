//! The paper's algorithm `Formfact` for a voxel of the scene.

use super::Exchange;
use zonal_math::Bounded;

impl Exchange<'_> {
    /// 𝓕 of voxel zone `i` with every cell of the voxmap, m⁴, by cell.
    pub(super) fn strips(&self, i: usize) -> Vec<Bounded> {
        let own = self.items[i].aligned.expect("a voxel is aligned");
        let mut out = vec![Bounded::ZERO; self.zones.voxels.iter().map(|z| z.cell + 1).max().unwrap_or(0)];
        for (z, item) in self.zones.voxels.iter().zip(&self.items[self.zones.voxel_offset()..]) {
            if let Some(other) = item.aligned {
                out[z.cell] = self.cache.get(&own, &other, 0.0);
            }
        }
        out
    }
}
