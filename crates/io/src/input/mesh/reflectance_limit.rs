//! Limit of the reflectances that mesh files give: ρ ≤ 0.95, and ρ + τ ≤ 0.95 of sheets that transmit.
//!
//! The white of a file (1, the default of glTF) is that of a picture. No wall reflects all light: between walls of reflectance 1 light ends nowhere, and any
//! error of exchange is amplified without bound. Fresh white paint has about 0.9. The texels of a texture are limited one by one, so that darker ones keep
//! their value. Reflectances of the scene file are not limited.

use super::model::{ImageSource, LimitedImage, MeshMaterial};
use std::rc::Rc;
use zonal_scene::Bands;

/// Largest reflectance of a material of a mesh file.
pub(crate) const MAX_MODEL_REFLECTANCE: f64 = 0.95;

/// Limits the reflectance of a material, and that with its transmittance.
pub(crate) fn limit_reflectance(material: &mut MeshMaterial) {
    let Some(own) = material.reflectance else { return };
    if let Some((transmittance, _)) = &mut material.transmittance {
        // A weighted texture shares the light between both sides: the sum is at most the larger factor.
        let is_shared = matches!(material.texture, Some(ImageSource::Weighted(_)));
        let sum = if is_shared { own.max(*transmittance) } else { own + *transmittance };
        let scale = sum.map(|s| if s > MAX_MODEL_REFLECTANCE { MAX_MODEL_REFLECTANCE / s } else { 1.0 });
        material.reflectance = Some(own * scale);
        *transmittance *= scale;
        material.is_limited = scale != Bands::ONE;
        return;
    }
    match &material.texture {
        None => {
            material.reflectance = Some(own.map(|x| x.min(MAX_MODEL_REFLECTANCE)));
            material.is_limited = own.any(|x| x > MAX_MODEL_REFLECTANCE);
        }
        Some(image) if own.any(|x| x > MAX_MODEL_REFLECTANCE) => {
            let largest = own.map(|x| (MAX_MODEL_REFLECTANCE / x.max(MAX_MODEL_REFLECTANCE)).min(1.0));
            let limited = LimitedImage { base: image.clone(), largest: largest.to_rgb().map(|x| x as f32) };
            material.texture = Some(ImageSource::Limited(Rc::new(limited)));
        }
        Some(_) => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limited(reflectance: f64, transmittance: Option<f64>) -> (MeshMaterial, f64, f64) {
        let mut m = MeshMaterial::named("m");
        m.reflectance = Some(Bands::splat(reflectance));
        m.transmittance = transmittance.map(|t| (Bands::splat(t), None));
        limit_reflectance(&mut m);
        let own = m.reflectance.map_or(0.0, Bands::max_element);
        let other = m.transmittance.as_ref().map_or(0.0, |t| t.0.max_element());
        (m, own, other)
    }

    #[test]
    fn reflectance_and_transmittance_sum_to_the_limit_at_most() {
        let (m, own, _) = limited(1.0, None);
        assert!(m.is_limited && own == MAX_MODEL_REFLECTANCE);
        let (m, own, _) = limited(0.9, None);
        assert!(!m.is_limited && own == 0.9);
        let (m, own, other) = limited(0.25, Some(0.75));
        assert!(m.is_limited && (own + other - MAX_MODEL_REFLECTANCE).abs() < 1e-12);
        assert!((other / own - 3.0).abs() < 1e-12);
        let (m, own, other) = limited(0.25, Some(0.5));
        assert!(!m.is_limited && (own, other) == (0.25, 0.5));
    }
}
