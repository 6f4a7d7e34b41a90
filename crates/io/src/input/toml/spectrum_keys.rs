//! The keys of a spectrum in the place of bands.

use super::keys::{Kind, keys};
use super::kinds::{COLUMN, FILE, NON_NEGATIVE, words};

/// Temperature of a black body whose light has a colour.
const BLACK_BODY: Kind<f64> = Kind::new("number in [100, 100000]", |n| match n.positive()? {
    t if (100.0..=1e5).contains(&t) => Ok(t),
    t => Err(n.error(format!("{t} K is out of range; give 100 to 100000"))),
})
.in_unit("K");

keys! {
    /// A spectrum in the place of bands.
    SPECTRUM: Spectrum = [Spectrum] {
        spectrum: () = FILE, "", ".csv with wavelengths in nm and values", "\"paint.csv\"";
        column: String = COLUMN, "\"2\"", "column of the values";
        illuminant: usize = words!("D65"), "", "standard illuminant, in place of a file";
        black_body: f64 = BLACK_BODY, "", "light of a black body, in place of a file";
        scale: f64 = NON_NEGATIVE, "1", "factor of the values";
        total: f64 = NON_NEGATIVE.in_unit("that of the quantity"), "", "sum of a flux over the bands of the scene";
    }
}
