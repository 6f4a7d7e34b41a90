//! Luminous intensities over angles as the readers find them, and with the largest one apart.

use zonal_scene::{IntensityTable, PlaneSymmetry};

/// Largest number of angles of a table along each axis.
pub(super) const MAX_ANGLES: usize = 10_000;

/// The intensities of a luminaire.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LuminousTable {
    /// Largest intensity, cd.
    pub(crate) peak: f64,
    /// Intensities over the largest one.
    pub(crate) table: IntensityTable,
}

/// Angles in degrees and intensities in cd, those of one plane together, as a file lists them.
#[derive(Clone, Debug, Default)]
pub(super) struct AngleTable {
    pub(super) planes: Vec<f64>,
    pub(super) gammas: Vec<f64>,
    pub(super) candelas: Vec<f64>,
}

impl AngleTable {
    /// The table with the largest intensity apart.
    pub(super) fn normalized(self, symmetry: PlaneSymmetry) -> Result<LuminousTable, String> {
        let peak = self.candelas.iter().fold(0.0f64, |m, v| m.max(*v));
        if !(peak.is_finite() && peak > 0.0) {
            return Err("the largest intensity is no positive number; give a luminaire that emits".into());
        }
        let relative: Vec<f64> = self.candelas.iter().map(|v| v / peak).collect();
        let table = IntensityTable::new(&self.planes, &self.gammas, &relative, symmetry)?;
        Ok(LuminousTable { peak, table })
    }
}
