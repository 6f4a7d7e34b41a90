//! Scenes of many bands: blocks of up to three bands that share one geometry.
//!
//! Block b holds the bands 3b, 3b + 1 and 3b + 2. A block is a scene of its own, two pointers wide: functions that work on three bands take a block, and
//! what depends on the geometry alone is computed once for all blocks.

use crate::bands::band::Band;
use crate::base::scene_error::{SceneError, invalid};
use crate::scene::Scene;
use crate::scene::thermal_validation::check_heat_sources;
use crate::thermal::{BandFractions, Thermal, ThermalCondition, check_sum};
use std::ops::Range;
use std::sync::Arc;

impl Scene {
    /// A scene of any number of bands from its blocks of up to three, in order; they differ in optical properties only. The geometry of the first is kept.
    ///
    /// # Errors
    /// If a block is missing or has another geometry, or if the band fractions of thermal mode are out of range.
    pub fn from_blocks(blocks: Vec<Scene>) -> Result<Scene, SceneError> {
        check_blocks(&blocks)?;
        let geometry = blocks[0].geometry.clone();
        Ok(Scene { geometry, optics: blocks.into_iter().map(|mut b| b.optics.swap_remove(0)).collect() })
    }

    /// The bands that this block holds.
    pub fn window(&self) -> Range<usize> {
        self.geometry.bands.window(self.block())
    }
    /// The number of this block.
    pub fn block(&self) -> usize {
        self.own().block
    }
    /// True if both have the same bands and facets: at once if they share them.
    pub(crate) fn shares_geometry(&self, other: &Scene) -> bool {
        let (own, other) = (&self.geometry, &other.geometry);
        let facets = || {
            own.facets
                .iter()
                .map(|f| (f.surface, f.plate))
                .eq(other.facets.iter().map(|f| (f.surface, f.plate)))
        };
        Arc::ptr_eq(own, other) || own.bands == other.bands && facets()
    }
    /// The blocks of up to three bands, as scenes of their own that share the geometry.
    pub fn blocks(&self) -> impl ExactSizeIterator<Item = Scene> + Clone + '_ {
        self.optics.iter().map(|o| Scene { geometry: self.geometry.clone(), optics: vec![o.clone()] })
    }
    /// The first block of bands as a scene of its own.
    pub fn first_block(&self) -> Scene {
        Scene { geometry: self.geometry.clone(), optics: vec![self.optics[0].clone()] }
    }
    /// Changes every block of bands.
    ///
    /// # Errors
    /// Those of `change`, and those of [`Scene::from_blocks`].
    pub fn map_blocks(
        &self,
        change: impl Fn(Scene) -> Result<Scene, SceneError>,
    ) -> Result<Scene, SceneError> {
        Scene::from_blocks(self.blocks().map(change).collect::<Result<_, _>>()?)
    }
}

/// Validates that scenes are the blocks of bands of one scene.
fn check_blocks(blocks: &[Scene]) -> Result<(), SceneError> {
    let Some(first) = blocks.first() else {
        return invalid("bands", "the scene has no bands; give at least one");
    };
    if blocks.len() != first.bands().block_count() {
        let (found, wanted) = (blocks.len(), first.bands().block_count());
        return invalid(
            "bands",
            format!("{found} blocks of bands are given where {wanted} are needed; give all"),
        );
    }
    let grid = |s: &Scene| s.voxel_grid().map(|g| *g.geometry());
    for (b, s) in blocks.iter().enumerate() {
        let same = s.shares_geometry(first)
            && s.block() == b
            && s.surfaces().len() == first.surfaces().len()
            && s.panes().len() == first.panes().len()
            && s.lights().len() == first.lights().len()
            && grid(s) == grid(first)
            && s.thermal().is_some() == first.thermal().is_some();
        if !same {
            return invalid(
                "bands",
                format!("block {b} of the bands has another geometry; use one geometry for all bands"),
            );
        }
    }
    check_thermal_blocks(blocks)
}

/// Validates the band fractions and powers of the blocks of bands of a scene together.
fn check_thermal_blocks(blocks: &[Scene]) -> Result<(), SceneError> {
    let thermal: Vec<&Thermal> = blocks.iter().filter_map(Scene::thermal).collect();
    let [first, _, ..] = thermal.as_slice() else { return Ok(()) };
    for (i, condition) in first.surfaces.iter().enumerate().filter(|(_, c)| c.prescribed_power() != 0.0) {
        let gives = |s: &Scene, t: &Thermal| {
            let (emitting, reflectance) = (t.band_fractions.emitting_bands(), s.surfaces()[i].reflectance);
            Band::all().any(|b| emitting[b] && reflectance[b] < 1.0)
        };
        if !blocks.iter().zip(&thermal).any(|(s, t)| gives(s, t)) {
            let power_key =
                if matches!(condition, ThermalCondition::Power(_)) { "net_power" } else { "heat_flux" };
            return invalid(
                format!("surface '{}'.{power_key}", blocks[0].surfaces()[i].name),
                "the emissivity is 0 in every band that has a fraction of the emission, so that the surface can give no power; raise it in one of them, or give 0",
            );
        }
    }
    let media: Vec<_> = blocks.iter().filter_map(|s| Some((s.thermal()?, s.voxel_grid()?))).collect();
    check_heat_sources(&media)?;
    for k in 0..first.all_fractions().count() {
        let of_blocks: Option<Vec<&BandFractions>> =
            thermal.iter().map(|t| t.all_fractions().nth(k)).collect();
        match of_blocks {
            Some(list) => check_sum(&list)?,
            None => {
                return invalid(
                    "thermal.band_fractions",
                    "the blocks of bands have different kinds of cells; give all the same",
                );
            }
        }
    }
    Ok(())
}
