//! The kinds of values of bands.

use super::keys::Kind;
use zonal_scene::Bands;

/// One number for all bands or one for each, each from 0 to 1.
pub(crate) const SHARE_OF_BANDS: Kind<Bands> = Kind::new("bands in [0, 1]", |n| n.bands(1.0));
/// One number for all bands or one for each, each from 0.
pub(crate) const BANDS: Kind<Bands> = Kind::new("bands from 0", |n| n.bands(f64::INFINITY));
/// A coefficient, which may lack the value of the band of sunlight: NaN there.
pub(crate) const COEFFICIENT: Kind<Bands> =
    Kind::new("bands from 0", |n| n.bands_or_infrared(f64::INFINITY, f64::NAN)).in_unit("1/m");
/// A flux by bands, or the integrals of a spectrum.
pub(crate) const FLUX: Kind<Bands> = Kind::new("bands from 0", |n| n.flux_bands());
/// A flux of light: in the bands of the scene, or a number in the band of sunlight.
pub(crate) const FLUX_OF_LIGHT: Kind<Bands> =
    Kind::new("bands from 0; a number in thermal mode", |n| n.light());
