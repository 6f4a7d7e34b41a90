//! Colours of spectral bands: from radiances of bands with wavelengths to linear sRGB by the CIE 1931 observer of 2°.
//!
//! With L_b the radiance of the band [a, b], taken as uniform over its wavelengths, and x̄, ȳ, z̄ the colour matching functions,
//!
//! ```text
//!     X = Σ_b L_b 1/(b − a) ∫ x̄ dλ      (Y, Z likewise)           (R, G, B) = M (X, Y, Z)
//! ```
//!
//! Y is the luminance over 683 lm/W, in W/(m² sr). M is that of IEC 61966-2-1 (white point D65). The observer does not adapt: light of 2856 K is orange, and
//! D65 is white. Colours beyond sRGB have negative components.
//!
//! Source of the table: CIE 015:2018, colour matching functions of the 1931 standard observer, 380 to 780 nm by 5 nm.

use zonal_scene::{BandSet, Bands};

/// First wavelength of the table, and its step, nm.
const FIRST_WAVELENGTH: f64 = 380.0;
const WAVELENGTH_STEP: f64 = 5.0;

/// x̄, ȳ, z̄ at the wavelengths of the table.
#[rustfmt::skip]
const COLOUR_MATCHING: [[f64; 3]; 81] = [
    [0.001368, 0.000039, 0.00645],
    [0.002236, 0.000064, 0.01055],
    [0.004243, 0.00012, 0.02005],
    [0.00765, 0.000217, 0.03621],
    [0.01431, 0.000396, 0.06785],
    [0.02319, 0.00064, 0.1102],
    [0.04351, 0.00121, 0.2074],
    [0.07763, 0.00218, 0.3713],
    [0.13438, 0.004, 0.6456],
    [0.21477, 0.0073, 1.0390501],
    [0.2839, 0.0116, 1.3856],
    [0.3285, 0.01684, 1.62296],
    [0.34828, 0.023, 1.74706],
    [0.34806, 0.0298, 1.7826],
    [0.3362, 0.038, 1.77211],
    [0.3187, 0.048, 1.7441],
    [0.2908, 0.06, 1.6692],
    [0.2511, 0.0739, 1.5281],
    [0.19536, 0.09098, 1.28764],
    [0.1421, 0.1126, 1.0419],
    [0.09564, 0.13902, 0.8129501],
    [0.05795, 0.1693, 0.6162],
    [0.03201, 0.20802, 0.46518],
    [0.0147, 0.2586, 0.3533],
    [0.0049, 0.323, 0.272],
    [0.0024, 0.4073, 0.2123],
    [0.0093, 0.503, 0.1582],
    [0.0291, 0.6082, 0.1117],
    [0.06327, 0.71, 0.07825],
    [0.1096, 0.7932, 0.05725],
    [0.1655, 0.862, 0.04216],
    [0.2257499, 0.9148501, 0.02984],
    [0.2904, 0.954, 0.0203],
    [0.3597, 0.9803, 0.0134],
    [0.4334499, 0.9949501, 0.00875],
    [0.5120501, 1.0, 0.00575],
    [0.5945, 0.995, 0.0039],
    [0.6784, 0.9786, 0.00275],
    [0.7621, 0.952, 0.0021],
    [0.8425, 0.9154, 0.0018],
    [0.9163, 0.87, 0.00165],
    [0.9786, 0.8163, 0.0014],
    [1.0263, 0.757, 0.0011],
    [1.0567, 0.6949, 0.001],
    [1.0622, 0.631, 0.0008],
    [1.0456, 0.5668, 0.0006],
    [1.0026, 0.503, 0.00034],
    [0.9384, 0.4412, 0.00024],
    [0.8544499, 0.381, 0.00019],
    [0.7514, 0.321, 0.0001],
    [0.6424, 0.265, 0.00005],
    [0.5419, 0.217, 0.00003],
    [0.4479, 0.175, 0.00002],
    [0.3608, 0.1382, 0.00001],
    [0.2835, 0.107, -0.0],
    [0.2187, 0.0816, 0.0],
    [0.1649, 0.061, 0.0],
    [0.1212, 0.04458, 0.0],
    [0.0874, 0.032, 0.0],
    [0.0636, 0.0232, 0.0],
    [0.04677, 0.017, 0.0],
    [0.0329, 0.01192, 0.0],
    [0.0227, 0.00821, 0.0],
    [0.01584, 0.005723, 0.0],
    [0.0113592, 0.004102, 0.0],
    [0.0081109, 0.002929, 0.0],
    [0.0057903, 0.002091, 0.0],
    [0.0041095, 0.001484, 0.0],
    [0.0028993, 0.001047, 0.0],
    [0.0020492, 0.00074, 0.0],
    [0.00144, 0.00052, 0.0],
    [0.0009999, 0.0003611, 0.0],
    [0.0006901, 0.0002492, 0.0],
    [0.000476, 0.0001719, 0.0],
    [0.0003323, 0.00012, 0.0],
    [0.0002348, 0.0000848, 0.0],
    [0.0001662, 0.00006, 0.0],
    [0.0001174, 0.0000424, 0.0],
    [0.0000831, 0.00003, 0.0],
    [0.0000587, 0.0000212, 0.0],
    [0.0000415, 0.000015, 0.0],
];

/// From X, Y, Z to linear sRGB (IEC 61966-2-1).
const XYZ_TO_RGB: [[f64; 3]; 3] = [
    [3.240_625_5, -1.537_208, -0.498_628_6],
    [-0.968_930_7, 1.875_756_1, 0.041_517_5],
    [0.055_710_1, -0.204_021_1, 1.056_995_9],
];

/// ∫ x̄, ȳ, z̄ dλ from the beginning of the table to a wavelength, nm, by linear interpolation.
fn integral_to(wavelength: f64) -> [f64; 3] {
    let at =
        ((wavelength - FIRST_WAVELENGTH) / WAVELENGTH_STEP).clamp(0.0, (COLOUR_MATCHING.len() - 1) as f64);
    let whole = (at as usize).min(COLOUR_MATCHING.len() - 2);
    let part = at - whole as f64;
    let of = |c: usize| {
        let value = |k: usize| COLOUR_MATCHING[k][c];
        let before: f64 = (0..whole).map(|k| 0.5 * (value(k) + value(k + 1))).sum();
        let end = value(whole) + part * (value(whole + 1) - value(whole));
        WAVELENGTH_STEP * (before + 0.5 * part * (value(whole) + end))
    };
    [of(0), of(1), of(2)]
}

/// The linear sRGB colour of a radiance of 1 W/(m² sr) in each band; `None` for bands without wavelengths.
fn band_colours(bands: &BandSet) -> Option<Vec<[f64; 3]>> {
    let of_band = |[from, to]: &[f64; 2]| {
        let [low, high] = [integral_to(*from), integral_to(*to)];
        let xyz: [f64; 3] = std::array::from_fn(|c| (high[c] - low[c]) / (to - from));
        XYZ_TO_RGB.map(|row| (0..3).map(|c| row[c] * xyz[c]).sum())
    };
    Some(bands.wavelengths()?.iter().map(of_band).collect())
}

/// The colours of the bands of each block: what fills up the last block has none.
pub(crate) fn block_colours(bands: &BandSet) -> Option<Vec<[[f64; 3]; 3]>> {
    let all = band_colours(bands)?;
    let of_block = |t: usize| {
        let window = bands.window(t);
        std::array::from_fn(|k| window.clone().nth(k).map_or([0.0; 3], |b| all[b]))
    };
    Some((0..bands.block_count()).map(of_block).collect())
}

/// The colour of the radiances of a block.
pub(crate) fn colour_of(colours: &[[f64; 3]; 3], radiance: Bands) -> [f64; 3] {
    let values = radiance.to_rgb();
    std::array::from_fn(|c| (0..3).map(|k| colours[k][c] * values[k]).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrals_over_all_wavelengths_are_those_of_the_table() {
        let all = integral_to(1e6);
        // The sums of the table times its step; the ends are almost 0.
        for (found, wanted) in all.into_iter().zip([21.371524, 21.371327, 21.371540]) {
            assert!((found / (5.0 * wanted) - 1.0).abs() < 1e-3, "{found}");
        }
        assert_eq!(integral_to(100.0), [0.0; 3]);
        let parts = BandSet::by_wavelength(vec![[380.0, 447.0], [447.0, 612.5], [612.5, 780.0]]).unwrap();
        let one = BandSet::by_wavelength(vec![[380.0, 780.0]]).unwrap();
        let whole = band_colours(&one).unwrap()[0];
        let sum = band_colours(&parts)
            .unwrap()
            .iter()
            .zip([67.0, 165.5, 167.5])
            .fold([0.0; 3], |s, (c, w)| std::array::from_fn(|k| s[k] + c[k] * w / 400.0));
        assert!((0..3).all(|k| (sum[k] - whole[k]).abs() < 1e-12), "{sum:?} {whole:?}");
    }

    #[test]
    fn long_waves_are_red_and_short_ones_blue() {
        let bands = BandSet::by_wavelength(vec![[400.0, 500.0], [500.0, 600.0], [600.0, 700.0]]).unwrap();
        let [blue, green, red] = <[[f64; 3]; 3]>::try_from(band_colours(&bands).unwrap()).unwrap();
        assert!(blue[2] > blue[1] && green[1] > green[2] && red[0] > red[1]);
        assert!(band_colours(&BandSet::default()).is_none());
    }

    #[test]
    fn bands_that_fill_up_a_triple_have_no_colour() {
        let four =
            BandSet::by_wavelength(vec![[400.0, 450.0], [450.0, 500.0], [500.0, 600.0], [600.0, 700.0]])
                .unwrap();
        let blocks = block_colours(&four).unwrap();
        assert_eq!((blocks.len(), blocks[1][1], blocks[1][2]), (2, [0.0; 3], [0.0; 3]));
        let red = colour_of(&blocks[1], Bands::ONE);
        assert_eq!(red, blocks[1][0]);
    }
}
