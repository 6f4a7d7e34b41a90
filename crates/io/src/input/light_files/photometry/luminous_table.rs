//! Luminous intensities over angles as the readers find them, and with the largest one apart.

use zonal_scene::{IntensityTable, PlaneSymmetry};

/// Largest number of angles of a table along each axis.
pub(super) const MAX_ANGLES: usize = 10_000;

/// Angles that differ by this are equal, degrees.
const TILT_ROUNDING: f64 = 1e-6;

/// The intensities of a luminaire.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LuminousTable {
    /// Largest intensity, cd.
    pub(crate) peak: f64,
    /// Intensities over the largest one.
    pub(crate) table: IntensityTable,
    /// Factors of the intensities of a tilted luminaire, if the file has some.
    pub(crate) tilt: Option<TiltFactors>,
}

/// Factors of the intensities over the angle between the aim of a luminaire and straight down.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TiltFactors {
    /// True if the lamp lies along the aim, so that the angle alone determines its position.
    is_along_aim: bool,
    /// Angles, degrees, ascending.
    angles: Vec<f64>,
    factors: Vec<f64>,
}

impl TiltFactors {
    /// Factors of a lamp along the aim, or of another one, at some angles in degrees.
    pub(super) fn new(
        is_along_aim: bool,
        angles: Vec<f64>,
        factors: Vec<f64>,
    ) -> Result<TiltFactors, String> {
        if angles.windows(2).any(|w| w[1] <= w[0]) {
            return Err("the tilt angles do not ascend; sort them with their factors".into());
        }
        if let Some(f) = factors.iter().find(|f| !(f.is_finite() && **f >= 0.0)) {
            return Err(format!("the tilt factor {f} is no number from 0; correct it"));
        }
        Ok(TiltFactors { is_along_aim, angles, factors })
    }

    /// The factor at an angle in degrees, linear between the angles of the file.
    pub(crate) fn at(&self, angle: f64) -> Result<f64, String> {
        if !self.is_along_aim && angle > TILT_ROUNDING {
            return Err(format!(
                "the file has factors for tilted lamps (TILT=INCLUDE) that depend on the side to which a lamp across the luminaire tilts, and this luminaire aims {angle:.1} degrees off straight down; write TILT=NONE in the file, and the factor as dimming"
            ));
        }
        let (angles, factors) = (&self.angles, &self.factors);
        let last = angles.len() - 1;
        if angle < angles[0] - TILT_ROUNDING || angle > angles[last] + TILT_ROUNDING {
            return Err(format!(
                "the file has factors for lamps tilted by {} to {} degrees (TILT=INCLUDE), and this luminaire aims {angle:.1} degrees off straight down; add factors, or write TILT=NONE in the file",
                angles[0], angles[last]
            ));
        }
        let k = angles.partition_point(|a| *a <= angle).clamp(1, last.max(1));
        if last == 0 {
            return Ok(factors[0]);
        }
        let place = ((angle - angles[k - 1]) / (angles[k] - angles[k - 1])).clamp(0.0, 1.0);
        Ok(factors[k - 1] + (factors[k] - factors[k - 1]) * place)
    }
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
        Ok(LuminousTable { peak, table, tilt: None })
    }
}
