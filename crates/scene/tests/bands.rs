//! Band-indexed values: operators act element by element, sums ascend, lengths are checked.

use std::collections::HashSet;
use zonal_scene::{Band, BandCountError, Bands, PerBand};

/// Values whose sums and products round, with signed zeros, infinities and NaN.
const VALUES: [f64; 8] = [0.1, -0.7, 1.0 / 3.0, 0.0, -0.0, f64::INFINITY, f64::NAN, 1e-300];

fn bits(b: Bands) -> Vec<u64> {
    b.iter().map(|x| x.to_bits()).collect()
}

fn blocks() -> impl Iterator<Item = [f64; 3]> {
    (0..VALUES.len()).map(|k| [VALUES[k], VALUES[(k + 1) % 8], VALUES[(k + 3) % 8]])
}

/// Asserts equal bits of all bands; NaN equals NaN.
fn assert_same(got: Bands, want: impl Fn(usize) -> f64) {
    for band in Band::all() {
        let (g, w) = (got[band], want(band.index()));
        assert!(g.to_bits() == w.to_bits() || (g.is_nan() && w.is_nan()), "{g:?} {w:?}");
    }
}

#[test]
fn operators_act_element_by_element() {
    for x in blocks() {
        for y in blocks() {
            let (a, b) = (Bands::from_rgb(x), Bands::from_rgb(y));
            assert_same(a + b, |k| x[k] + y[k]);
            assert_same(a - b, |k| x[k] - y[k]);
            assert_same(a * b, |k| x[k] * y[k]);
            assert_same(a / b, |k| x[k] / y[k]);
            assert_same(a + y[0], |k| x[k] + y[0]);
            assert_same(a - y[0], |k| x[k] - y[0]);
            assert_same(a * y[0], |k| x[k] * y[0]);
            assert_same(a / y[0], |k| x[k] / y[0]);
            assert_same(y[0] - a, |k| y[0] - x[k]);
            assert_same(y[0] / a, |k| y[0] / x[k]);
            assert_same(a.max(b), |k| x[k].max(y[k]));
            assert_same(a.min(b), |k| x[k].min(y[k]));
        }
        assert_same(-Bands::from_rgb(x), |k| -x[k]);
        assert_same(Bands::from_rgb(x).abs(), |k| x[k].abs());
    }
}

#[test]
fn assigning_operators_equal_the_binary_ones() {
    let (a, b) = (Bands::from_rgb([0.1, 0.2, -0.3]), Bands::from_rgb([0.7, -0.6, 0.9]));
    let assigned = |f: &dyn Fn(&mut Bands)| {
        let mut out = a;
        f(&mut out);
        bits(out)
    };
    assert_eq!(assigned(&|x| *x += b), bits(a + b));
    assert_eq!(assigned(&|x| *x -= b), bits(a - b));
    assert_eq!(assigned(&|x| *x *= b), bits(a * b));
    assert_eq!(assigned(&|x| *x /= b), bits(a / b));
    assert_eq!(assigned(&|x| *x += 0.3), bits(a + 0.3));
    assert_eq!(assigned(&|x| *x -= 0.3), bits(a - 0.3));
    assert_eq!(assigned(&|x| *x *= 0.3), bits(a * 0.3));
    assert_eq!(assigned(&|x| *x /= 0.3), bits(a / 0.3));
}

#[test]
fn sums_add_in_ascending_order() {
    let x = [1e16, 1.0, -1e16];
    assert_eq!(Bands::from_rgb(x).sum(), x.iter().sum::<f64>());
    assert_eq!(Bands::from_rgb([1.0, 2.0, 4.0]).mean(), 7.0 / 3.0);
    let terms = [Bands::splat(1e16), Bands::ONE, Bands::splat(-1e16)];
    let total: Bands = terms.iter().sum();
    assert_eq!(total, Bands::splat((1e16 + 1.0) - 1e16));
    assert_eq!(std::iter::empty::<Bands>().sum::<Bands>(), Bands::ZERO);
}

#[test]
fn reductions_and_predicates_cover_all_bands() {
    let b = Bands::from_rgb([2.0, -3.0, 0.5]);
    assert_eq!((b.max_element(), b.min_element()), (2.0, -3.0));
    assert!(b.is_finite() && b.any(|x| x < 0.0) && !b.all(|x| x < 0.0));
    for k in 0..3 {
        let mut x = [1.0; 3];
        x[k] = f64::NAN;
        assert!(!Bands::from_rgb(x).is_finite());
        assert_eq!(Bands::from_rgb(x).max_element(), 1.0);
    }
}

#[test]
fn bands_are_ordered_indices() {
    let all: Vec<Band> = Band::all().collect();
    assert!(all.is_sorted() && all.len() == Band::count());
    assert_eq!(all.iter().collect::<HashSet<_>>().len(), all.len());
    assert_eq!(Band::all().next_back().map(Band::index), Some(Band::count() - 1));
    assert_eq!(Band::new(Band::count()), None);
    let mut b = Bands::ZERO;
    b[all[1]] = 5.0;
    assert_eq!(b.to_rgb(), [0.0, 5.0, 0.0]);
}

#[test]
fn slices_of_other_lengths_are_refused() {
    assert_eq!(Bands::try_from(&[0.0; 4][..]), Err(BandCountError { found: 4, expected: 3 }));
    assert_eq!(PerBand::<u8>::try_from(&[][..]), Err(BandCountError { found: 0, expected: 3 }));
    assert_eq!(Bands::try_from(Bands::ONE.as_slice()), Ok(Bands::ONE));
    assert_eq!(PerBand::try_from(&["r", "g", "b"][..]).map(PerBand::into_rgb), Ok(["r", "g", "b"]));
}

#[test]
fn per_band_values_map_zip_and_iterate_in_order() {
    let mut names = PerBand::from_fn(|band| band.index().to_string());
    names.iter_mut().for_each(|n| n.push('!'));
    assert_eq!(names.as_ref().map(String::as_str).into_rgb(), ["0!", "1!", "2!"]);
    let joined = names.clone().zip_map(PerBand::from_rgb([1, 2, 3]), |n, k| n.repeat(k));
    assert_eq!(joined.into_iter().collect::<Vec<_>>(), ["0!", "1!1!", "2!2!2!"]);
    *names.as_mut()[Band::all().next().unwrap()] = "first".into();
    assert!(names.as_ref().any(|n| n == "first") && names.as_ref().all(|n| !n.is_empty()));
    assert_eq!(PerBand::splat(7).as_slice(), [7; 3]);
}
