//! The solution: data that solvers write and that pictures, tables and files read.

pub(crate) mod energy_balance;
pub(crate) mod face_results;
pub(crate) mod fields;
pub(crate) mod heat_report;
pub mod light_group;
pub(crate) mod photometry;
pub(crate) mod report;
pub(crate) mod results;
pub(crate) mod solve_status;

use crate::bands::Bands;
use crate::scene::Scene;
use crate::solution::fields::Fields;
use crate::solution::light_group::{LightGroup, LightGroupKind};
use crate::solution::report::Report;
use crate::zones::Zones;

/// A solved scene.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The scene.
    pub scene: Scene,
    /// Its zones.
    pub zones: Zones,
    /// Fields on the zones, for all lights together.
    pub fields: Fields,
    /// Fields of each light group; empty if the lights were solved in one sum.
    pub groups: Vec<LightGroup>,
    /// The report.
    pub report: Report,
    /// Solutions of the further blocks of bands, on the same zones; empty for up to three bands. Their reports hold what belongs to their bands.
    pub further_blocks: Vec<Solution>,
    /// Hash of the scene, at most 64 hexadecimal digits.
    pub scene_hash: String,
    /// Version of the program.
    pub version: String,
}

impl Solution {
    /// The solution of a scene from the solutions of its blocks of bands, in order, whose scenes become blocks of this one. There is at least one.
    #[must_use]
    pub fn of_blocks(scene: Scene, mut blocks: Vec<Solution>) -> Solution {
        blocks.iter_mut().zip(scene.blocks()).for_each(|(s, own)| s.scene = own);
        let further_blocks = blocks.split_off(1);
        Solution { scene, further_blocks, ..blocks.swap_remove(0) }
    }
    /// This solution and those of the further blocks of bands.
    pub fn blocks(&self) -> impl Iterator<Item = &Solution> + Clone {
        std::iter::once(self).chain(self.further_blocks.iter())
    }
    /// The light group of light number `light` alone, if its direct light is stored.
    pub fn group_with_direct_light(&self, light: usize) -> Option<&LightGroup> {
        self.groups.iter().find(|g| g.kind == LightGroupKind::Light(light) && !g.direct.is_empty())
    }
    /// The values of all bands of a quantity that is stored by blocks, ascending by band.
    ///
    /// ```no_run
    /// # fn radiosities(solution: &zonal_scene::Solution) -> Vec<f64> {
    /// solution.all_bands(|block| block.fields.radiosity[0])
    /// # }
    /// ```
    pub fn all_bands(&self, value: impl Fn(&Solution) -> Bands) -> Vec<f64> {
        let of_block = |s: &Solution| value(s).into_iter().take(s.scene.window().len()).collect::<Vec<_>>();
        self.blocks().flat_map(of_block).collect()
    }
}
