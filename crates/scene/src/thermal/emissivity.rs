//! Emissivity of the sides of a surface in thermal mode: a number for each band, or a table of the temperature.
//!
//! A table is piecewise linear in the temperature and constant beyond its ends, and holds for all bands but that of sunlight, whose reflectance does
//! not depend on the temperature of the surface.

use crate::bands::Bands;
use crate::bands::band_set::BandSet;
use crate::bands::encoding::nan_bands;
use crate::base::limits::MAX_TEMPERATURE;
use crate::base::scene_error::{SceneError, invalid};
use std::sync::Arc;

/// Emissivity by temperature: points (T in K, ε), linear between them and constant beyond.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(try_from = "Vec<[f64; 2]>", into = "Vec<[f64; 2]>")]
pub struct EmissivityTable {
    points: Arc<[[f64; 2]]>,
}

impl TryFrom<Vec<[f64; 2]>> for EmissivityTable {
    type Error = SceneError;
    fn try_from(points: Vec<[f64; 2]>) -> Result<EmissivityTable, SceneError> {
        EmissivityTable::new(&points)
    }
}

impl From<EmissivityTable> for Vec<[f64; 2]> {
    fn from(table: EmissivityTable) -> Vec<[f64; 2]> {
        table.points.to_vec()
    }
}

impl EmissivityTable {
    /// From points (T in K, ε) by ascending temperature.
    ///
    /// ```
    /// use zonal_scene::EmissivityTable;
    /// let steel = EmissivityTable::new(&[[300.0, 0.1], [900.0, 0.4]])?;
    /// assert_eq!([200.0, 600.0, 2000.0].map(|t| steel.at(t)), [0.1, 0.25, 0.4]);
    /// # Ok::<(), zonal_scene::SceneError>(())
    /// ```
    ///
    /// # Errors
    /// If there is no point, a temperature is out of range or does not ascend, or an emissivity is not in \[0, 1\].
    pub fn new(points: &[[f64; 2]]) -> Result<EmissivityTable, SceneError> {
        if points.is_empty() {
            return invalid("emissivity", "the table has no rows; give temperatures (K) and emissivities");
        }
        for (k, [t, e]) in points.iter().enumerate() {
            if !(*t > 0.0 && *t <= MAX_TEMPERATURE) {
                let what = format!("{t} K is out of range; give kelvin above 0, up to {MAX_TEMPERATURE:e}");
                return invalid("emissivity", what);
            }
            if k > 0 && *t <= points[k - 1][0] {
                let what = format!("{t} K follows {} K; give ascending temperatures", points[k - 1][0]);
                return invalid("emissivity", what);
            }
            if !(0.0..=1.0).contains(e) {
                return invalid("emissivity", format!("{e} is no emissivity; give a value from 0 to 1"));
            }
        }
        Ok(EmissivityTable { points: points.into() })
    }

    /// The points (T in K, ε).
    #[must_use]
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// ε at `t` kelvin; the first value for NaN.
    #[must_use]
    pub fn at(&self, t: f64) -> f64 {
        let after = self.points.partition_point(|p| p[0] <= t);
        match (after.checked_sub(1).map(|k| self.points[k]), self.points.get(after)) {
            (Some([a, low]), Some([b, high])) => low + (high - low) * (t - a) / (b - a),
            (Some([_, last]), None) => last,
            (None, _) => self.points[0][1],
        }
    }
}

/// Reflectance of one side of a surface.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
pub struct SideEmissivity {
    /// ρ of each band; of the band of sunlight alone if there is a table.
    #[serde(deserialize_with = "nan_bands")]
    pub reflectance: Bands,
    /// ε by temperature.
    pub table: Option<EmissivityTable>,
}

impl SideEmissivity {
    /// ρ at `t` kelvin in the bands of a block.
    #[must_use]
    pub fn reflectance_at(&self, bands: &BandSet, block: usize, t: f64) -> Bands {
        match &self.table {
            Some(table) => {
                let in_sunlight = bands.with_solar_value(block, Bands::ZERO, 1.0);
                let own = Bands::splat(1.0 - table.at(t));
                in_sunlight * self.reflectance + (1.0 - in_sunlight) * own
            }
            None => self.reflectance,
        }
    }
}

/// Emissivities of the sides of a surface, in place of its reflectance.
#[derive(Clone, Debug, Default, PartialEq, serde::Deserialize, serde::Serialize)]
pub struct SurfaceEmissivity {
    /// ε of the front, and of the back where that has none of its own, by temperature.
    pub table: Option<EmissivityTable>,
    /// The back side, if it differs.
    pub back: Option<SideEmissivity>,
}

impl SurfaceEmissivity {
    /// True if an emissivity depends on temperature.
    #[must_use]
    pub fn depends_on_temperature(&self) -> bool {
        self.table.is_some() || self.back.as_ref().is_some_and(|b| b.table.is_some())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_out_of_range_are_refused() {
        for points in [
            &[][..],
            &[[0.0, 0.5]],
            &[[300.0, 1.1]],
            &[[300.0, 0.5], [300.0, 0.6]],
            &[[300.0, f64::NAN]],
            &[[f64::INFINITY, 0.5]],
        ] {
            assert!(EmissivityTable::new(points).is_err(), "{points:?}");
        }
    }

    #[test]
    fn sunlight_has_its_own_reflectance() {
        let bands = BandSet::numbered(1).unwrap().with_solar_band().unwrap();
        let table = EmissivityTable::new(&[[300.0, 0.2], [500.0, 0.6]]).unwrap();
        let side = SideEmissivity { reflectance: Bands::from_rgb([0.0, 0.9, 0.9]), table: Some(table) };
        assert_eq!(side.reflectance_at(&bands, 0, 400.0).to_rgb(), [0.6, 0.9, 0.9]);
    }
}
