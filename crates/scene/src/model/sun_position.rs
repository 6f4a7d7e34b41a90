//! Position of the sun by place and time.
//!
//! The ecliptic longitude λ follows from the mean longitude and anomaly of the sun and the equation of its centre, with aberration and the main term of nutation (J. Meeus,
//! Astronomical Algorithms, 2nd edition, chapter 25, low accuracy: 0.01° between 1900 and 2100). With the obliquity ε, right ascension and declination are
//!
//! ```text
//! tan α = cos ε tan λ      sin δ = sin ε sin λ
//! ```
//!
//! and the hour angle H is the sidereal time at Greenwich (chapter 12) plus the eastern longitude less α. At the latitude φ, with components towards east, north and up,
//!
//! ```text
//! s = (−cos δ sin H,  sin δ cos φ − cos δ cos H sin φ,  sin δ sin φ + cos δ cos H cos φ)
//! ```
//!
//! Positions are geometric, without refraction, which lifts the sun by 0.5° at the horizon and by less than 0.02° above 45°. Universal time stands for terrestrial time: the
//! difference of about a minute moves the sun by 0.001°.

use zonal_math::{Vec3, vec3};

/// Julian date of 2000 January 1, 12 h.
const EPOCH: f64 = 2_451_545.0;
/// Days of a Julian century.
const CENTURY: f64 = 36_525.0;

/// A moment in universal time of the Gregorian calendar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UniversalTime {
    /// Year, 1900 to 2100 for the stated accuracy.
    pub year: i32,
    /// Month, 1 to 12.
    pub month: u32,
    /// Day of the month, from 1.
    pub day: u32,
    /// Hours of the day; others than 0 to 24 belong to other days.
    pub hours: f64,
}

impl UniversalTime {
    /// Days since 2000 January 1, 12 h.
    fn days(&self) -> f64 {
        // January and February count as months 13 and 14 of the year before (Meeus, chapter 7).
        let (y, m) = match self.month {
            1 | 2 => (self.year - 1, self.month + 12),
            m => (self.year, m),
        };
        let (y, m) = (f64::from(y), f64::from(m));
        let century = (y / 100.0).floor();
        let leap = 2.0 - century + (century / 4.0).floor();
        let date = (365.25 * (y + 4716.0)).floor() + (30.6001 * (m + 1.0)).floor() + f64::from(self.day);
        date + leap - 1524.5 - EPOCH + self.hours / 24.0
    }
}

/// The sun as seen from a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunPosition {
    /// Unit vector towards the sun: components towards east, north and up.
    pub direction: Vec3,
    /// Distance of the sun, astronomical units.
    pub distance: f64,
}

impl SunPosition {
    /// The sun at a latitude (north) and a longitude (east), degrees.
    ///
    /// ```
    /// use zonal_scene::{SunPosition, UniversalTime};
    /// // Noon of the summer solstice on the tropic of Cancer: the sun is close to the zenith.
    /// let time = UniversalTime { year: 2024, month: 6, day: 20, hours: 12.03 };
    /// assert!(SunPosition::new(23.44, 0.0, time).direction.z > 0.99999);
    /// ```
    #[must_use]
    pub fn new(latitude: f64, longitude: f64, time: UniversalTime) -> SunPosition {
        let days = time.days();
        let t = days / CENTURY;
        // Mean longitude, mean anomaly and eccentricity.
        let mean_longitude = 280.46646 + t * (36_000.769_83 + t * 0.000_303_2);
        let anomaly = (357.52911 + t * (35_999.050_29 - t * 0.000_153_7)).to_radians();
        let eccentricity = 0.016_708_634 - t * (0.000_042_037 + t * 0.000_000_126_7);
        // Equation of the centre, and the apparent longitude with aberration and nutation.
        let centre = (1.914_602 - t * (0.004_817 + t * 0.000_014)) * anomaly.sin()
            + (0.019_993 - t * 0.000_101) * (2.0 * anomaly).sin()
            + 0.000_289 * (3.0 * anomaly).sin();
        let node = (125.04 - 1934.136 * t).to_radians();
        let longitude_of_sun =
            (mean_longitude + centre - 0.005_69 - 0.004_78 * node.sin()).rem_euclid(360.0).to_radians();
        let obliquity =
            (23.439_291 - t * (0.013_004_2 + t * 0.000_000_16) + 0.002_56 * node.cos()).to_radians();
        let distance = 1.000_001_018 * (1.0 - eccentricity * eccentricity)
            / (1.0 + eccentricity * (anomaly + centre.to_radians()).cos());
        // Right ascension, declination and hour angle.
        let (sin, cos) = longitude_of_sun.sin_cos();
        let ascension = (obliquity.cos() * sin).atan2(cos);
        let declination = (obliquity.sin() * sin).asin();
        let sidereal = 280.460_618_37 + 360.985_647_366_29 * days + t * t * 0.000_387_933;
        // The main term of nutation in right ascension moves the sidereal time as it moves the longitude.
        let nutation = -0.004_78 * node.sin() * obliquity.cos();
        let hour = (sidereal + nutation + longitude).rem_euclid(360.0).to_radians() - ascension;
        let ((sin_d, cos_d), (sin_h, cos_h)) = (declination.sin_cos(), hour.sin_cos());
        let (sin_l, cos_l) = latitude.to_radians().sin_cos();
        let direction = vec3(
            -cos_d * sin_h,
            sin_d * cos_l - cos_d * cos_h * sin_l,
            sin_d * sin_l + cos_d * cos_h * cos_l,
        );
        SunPosition { direction, distance }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Azimuth from north over east and elevation, degrees.
    fn angles(d: Vec3) -> [f64; 2] {
        [d.x.atan2(d.y).to_degrees().rem_euclid(360.0), d.z.asin().to_degrees()]
    }

    #[test]
    fn positions_agree_with_tabulated_ones() {
        // Reda and Andreas, Solar Energy 76 (2004) 577, table A5.1 (Golden, elevation without refraction).
        let time = UniversalTime { year: 2003, month: 10, day: 17, hours: 19.5 + 30.0 / 3600.0 };
        let [azimuth, elevation] = angles(SunPosition::new(39.742476, -105.1786, time).direction);
        assert!((azimuth - 194.34024).abs() < 0.01, "{azimuth}");
        assert!((elevation - 39.872046).abs() < 0.01, "{elevation}");
        // Meeus, example 25.a: declination −7.78507° and distance 0.99766 at 1992 October 13, 0 h. At the pole the elevation is the declination.
        let time = UniversalTime { year: 1992, month: 10, day: 13, hours: 0.0 };
        let at_pole = SunPosition::new(90.0, 0.0, time);
        assert!((angles(at_pole.direction)[1] + 7.78507).abs() < 0.002, "{at_pole:?}");
        assert!((at_pole.distance - 0.99766).abs() < 1e-5, "{at_pole:?}");
    }

    #[test]
    fn equal_moments_have_equal_positions() {
        let at = |day: u32, hours: f64| {
            SunPosition::new(48.1, 11.6, UniversalTime { year: 2024, month: 3, day, hours }).direction
        };
        assert!((at(1, 1.5) - at(0, 25.5)).length() < 1e-12);
        assert!((at(20, 12.0) - at(21, 12.0)).length() > 1e-3);
    }
}
