//! Spectra: tables over wavelength, standard illuminants and black bodies, as values of bands.
//!
//! A table is piecewise linear. A property such as a reflectance has its mean in each band, a flux its integral:
//!
//! ```text
//!     ρ_b = 1/(b − a) ∫ ρ dλ          E_b = ∫ E dλ,  or  E_b = total ∫_b S dλ / Σ_c ∫_c S dλ
//! ```

use crate::files::FileSource;
use crate::input::reading::error::FileFault;
use crate::input::tables::{ColumnFile, Quantity, RowKeys, WantedColumn};
use std::path::Path;

/// First wavelength and step of the table of D65, nm.
const D65_RANGE: [f64; 2] = [300.0, 5.0];

/// Relative spectral power of the standard illuminant D65 (CIE 015:2018).
#[rustfmt::skip]
const D65: [f64; 107] = [
    0.0341, 1.6643, 3.2945, 11.7652, 20.236, 28.6447, 37.0535, 38.5011, 39.9488, 42.4302, 44.9117, 45.775, 46.6383, 49.3637, 52.0891, 51.0323, 49.9755, 52.3118, 54.6482, 68.7015, 82.7549, 87.1204, 91.486, 92.4589, 93.4318, 90.057, 86.6823, 95.7736, 104.865, 110.936, 117.008, 117.41, 117.812, 116.336, 114.861, 115.392, 115.923, 112.367, 108.811, 109.082, 109.354, 108.578, 107.802, 106.296, 104.79, 106.239, 107.689, 106.047, 104.405, 104.225, 104.046, 102.023, 100.0, 98.1671, 96.3342, 96.0611, 95.788, 92.2368, 88.6856, 89.3459, 90.0062, 89.8026, 89.5991, 88.6489, 87.6987, 85.4936, 83.2886, 83.4939, 83.6992, 81.863, 80.0268, 80.1207, 80.2146, 81.2462, 82.2778, 80.281, 78.2842, 74.0027, 69.7213, 70.6652, 71.6091, 72.979, 74.349, 67.9765, 61.604, 65.7448, 69.8856, 72.4863, 75.087, 69.3398, 63.5927, 55.0054, 46.4182, 56.6118, 66.8054, 65.0941, 63.3828, 63.3828, 63.3828, 63.3828, 63.3828, 63.3828, 63.3828, 63.3828, 63.3828, 63.3828, 63.3828,
];

/// hc/k, nm K (CODATA 2018).
const SECOND_RADIATION_CONSTANT: f64 = 1.438_776_877e7;
/// Wavelengths of the table of a black body, nm, and its number of steps.
const BLACK_BODY_RANGE: [f64; 2] = [100.0, 3000.0];
const BLACK_BODY_STEPS: usize = 2900;

/// A piecewise linear function of the wavelength.
#[derive(Clone, Debug)]
pub(crate) struct Spectrum {
    /// Wavelength in nm, ascending, and value.
    points: Vec<[f64; 2]>,
}

impl Spectrum {
    /// Two columns of a table: wavelengths in nm, ascending, and the column `values` (name, or number from 1).
    pub(crate) fn read(files: FileSource<'_>, path: &Path, values: &str) -> Result<Spectrum, FileFault> {
        let file = path.display().to_string();
        let table = ColumnFile::read(files, path, &file)?;
        let column = |column: &str| {
            table.column(WantedColumn {
                column: Some(column),
                quantity: Quantity::Spectral,
                rows: RowKeys::Position,
            })
        };
        let (wavelengths, values) = (column("1")?, column(values)?);
        for (row, pair) in wavelengths.values().windows(2).enumerate() {
            if pair[1] <= pair[0] {
                return Err(wavelengths.fault(
                    row + 1,
                    "the wavelengths of the first column do not ascend; sort the rows, and give nanometres",
                ));
            }
        }
        if wavelengths.values().len() < 2 {
            return Err(FileFault::new(
                &file,
                "",
                "a spectrum has at least two rows; add wavelengths and values",
            ));
        }
        let points = wavelengths.values().iter().zip(values.values()).map(|(w, v)| [*w, *v]).collect();
        Ok(Spectrum { points })
    }

    /// The standard illuminant D65, relative.
    pub(crate) fn d65() -> Spectrum {
        let [first, step] = D65_RANGE;
        Spectrum { points: D65.iter().enumerate().map(|(k, v)| [first + step * k as f64, *v]).collect() }
    }

    /// Light of a black body at `kelvin`, relative to its largest value.
    pub(crate) fn black_body(kelvin: f64) -> Spectrum {
        let [first, last] = BLACK_BODY_RANGE;
        let peak = SECOND_RADIATION_CONSTANT / (4.965_114_231_744_276 * kelvin);
        let planck = |w: f64| w.powi(-5) / (SECOND_RADIATION_CONSTANT / (w * kelvin)).exp_m1();
        let largest = planck(peak.clamp(first, last));
        let point = |k: usize| {
            let w = first + (last - first) * k as f64 / BLACK_BODY_STEPS as f64;
            [w, planck(w) / largest]
        };
        Spectrum { points: (0..=BLACK_BODY_STEPS).map(point).collect() }
    }

    /// First and last wavelength, nm.
    pub(crate) fn range(&self) -> [f64; 2] {
        [self.points[0][0], self.points[self.points.len() - 1][0]]
    }

    /// ∫ over a band within the range, in the unit of the values times nm.
    pub(crate) fn integral(&self, [from, to]: [f64; 2]) -> f64 {
        let one = |pair: &[[f64; 2]]| {
            let ([a, u], [b, v]) = (pair[0], pair[1]);
            let (low, high) = (from.max(a), to.min(b));
            if low >= high {
                return 0.0;
            }
            let at = |w: f64| u + (v - u) * (w - a) / (b - a);
            0.5 * (at(low) + at(high)) * (high - low)
        };
        self.points.windows(2).map(one).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrals_of_pieces_add_up() {
        let s = Spectrum { points: vec![[400.0, 1.0], [500.0, 3.0], [600.0, 3.0]] };
        assert_eq!(s.integral([400.0, 600.0]), 500.0);
        assert_eq!(s.integral([450.0, 550.0]), 0.5 * (2.0 + 3.0) * 50.0 + 150.0);
        assert_eq!((s.range(), s.integral([700.0, 800.0])), ([400.0, 600.0], 0.0));
    }

    #[test]
    fn illuminants_have_their_values() {
        let at = |s: &Spectrum, w: f64| s.points.iter().find(|p| p[0] == w).unwrap()[1];
        assert_eq!(at(&Spectrum::d65(), 560.0), 100.0);
        // Illuminant A, 2856 K: 100 at 560 nm and 129.0432 at 600 nm (CIE 015:2018).
        let a = Spectrum::black_body(2855.54);
        assert!((at(&a, 600.0) / at(&a, 560.0) - 1.290432).abs() < 2e-4);
    }
}
