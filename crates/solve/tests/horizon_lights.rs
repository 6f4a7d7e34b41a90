//! Lights that the plane of a patch cuts, and lights that no sample finds.

use crate::common;

use common::{read, solve, solved};
use zonal_math::{Vec3, vec3};
use zonal_scene::{Bands, Light, SceneParts, SkyDistribution, Solution, Texture};

/// A square of 1 m² that turns its front to (cos e, 0, sin e) in the sun's coordinates, in a sun of this diameter (degrees) from the zenith.
fn tilted(elevation: f64, diameter: f64, rest: &str) -> String {
    let (sin, cos) = elevation.to_radians().sin_cos();
    format!(
        "[solve]\ntolerance = 0.01\npatch_size = 0.2\n{rest}[[surface]]\nname = 'plate'\nreflectance = 0\n\
         rectangle = {{ origin = [0,0,0], edge1 = [{sin}, 0, {}], edge2 = [0,1,0] }}\n\
         [[light]]\nkind = 'sun'\ndirection = [0,0,-1]\nangular_diameter = {diameter}\nirradiance = 1\n",
        -cos
    )
}

/// ∫ cos⁺ dω over the disc about the zenith on a plane of this normal, over π sin²α: midpoints of rings and turns.
fn summed(normal: Vec3, alpha: f64) -> f64 {
    let (rings, turns) = (4000, 2000);
    let mut sum = 0.0;
    for r in 0..rings {
        let (sin, cos) = (alpha * (r as f64 + 0.5) / rings as f64).sin_cos();
        for t in 0..turns {
            let turn = std::f64::consts::TAU * (t as f64 + 0.5) / turns as f64;
            sum += normal.dot(vec3(sin * turn.cos(), sin * turn.sin(), cos)).max(0.0) * sin;
        }
    }
    2.0 * sum * alpha / (rings * turns) as f64 / alpha.sin().powi(2)
}

// Guards (numbers): a sun that is partly below a patch has its exact irradiance.
#[test]
fn suns_partly_below_a_patch_have_their_exact_irradiance() {
    for (elevation, diameter) in
        [(-25.0, 106.2602047083), (-0.2, 0.5), (20.0, 170.0), (-52.0, 106.0), (3.0, 12.0)]
    {
        let s = solved(&tilted(elevation, diameter, ""));
        let normal = s.zones.patches[0].normal;
        assert!((normal.z - elevation.to_radians().sin()).abs() < 1e-12);
        let exact = summed(normal, diameter.to_radians() / 2.0);
        for (i, h) in s.fields.direct.iter().enumerate().take(s.zones.patches.len()) {
            let off = h.first() / exact - 1.0;
            assert!(off.abs() < 2e-4 * (1.0 + 1e-3 / exact), "{elevation} {diameter}: {} {exact}", h.first());
            assert!(s.fields.direct_error[i].first() > 0.0, "{elevation} {diameter}: patch {i}");
        }
    }
    // The trial: 0.055453 W.
    let s = solved(&tilted(-25.0, 106.2602047083, ""));
    assert!(s.fields.direct.iter().all(|h| (h.first() - 0.055453).abs() < 1e-6), "{:?}", s.fields.direct[0]);
}

#[test]
fn blocked_parts_of_a_cut_sun_are_within_the_stated_error() {
    // A wall hides the part of the disc with x above 0, half of the light by symmetry in x for a plate that looks along y.
    let text = "[solve]\ntolerance = 0.02\npatch_size = 0.5\n\
        [[surface]]\nname = 'plate'\nreflectance = 0\nrectangle = { origin = [0,0,0], edge1 = [0,0,1], edge2 = [1,0,0] }\n\
        [[surface]]\nname = 'wall'\nreflectance = 0\nsides = 'both'\nrectangle = { origin = [1.0001,-1e3,-1e3], edge1 = [0,2e3,0], edge2 = [0,0,2e3] }\npatch_size = 1000\n\
        [[light]]\nkind = 'sun'\ndirection = [0,0.2,-1]\nangular_diameter = 100\nirradiance = 1\n";
    let s = solved(text);
    let patches: Vec<usize> = (0..s.zones.patches.len()).filter(|i| s.zones.patches[*i].area < 1.0).collect();
    let open = summed_about(
        s.zones.patches[patches[0]].normal,
        vec3(0.0, -0.2, 1.0).normalized(),
        50f64.to_radians(),
    );
    for i in patches {
        let (h, e) = (s.fields.direct[i].first(), s.fields.direct_error[i].first());
        let off = (h - 0.5 * open).abs();
        assert!(off < 3.0 * e + 2e-3 * open && e > 0.0 && e < 0.1 * open, "{h} ± {e} of {open}");
    }
}

/// As `summed`, with the disc about any axis.
fn summed_about(normal: Vec3, axis: Vec3, alpha: f64) -> f64 {
    let (t, b) = axis.frame();
    summed(vec3(normal.dot(t), normal.dot(b), normal.dot(axis)), alpha)
}

/// A plate under a picture that is black but for one pixel, of which `above` degrees are above the plane of the plate.
fn under_a_pixel(above: f64) -> Solution {
    // Pixel (32, 8) of 64 × 32 looks forward along x, 39.4° to 45° above the horizon of the picture.
    let mut pixels = vec![[0.0; 3]; 64 * 32];
    pixels[8 * 64 + 32] = [1.0; 3];
    let picture = Texture { width: 64, height: 32, pixels };
    let distribution = SkyDistribution::picture(picture, vec3(0.0, 0.0, 1.0), 0.0).unwrap();
    let elevation = 45.0 - above;
    let (sin, cos) = elevation.to_radians().sin_cos();
    let text = format!(
        "[solve]\ntolerance = 0.05\npatch_size = 0.25\n[[surface]]\nname = 'plate'\nreflectance = 0\n\
         rectangle = {{ origin = [0,0,0], edge1 = [{cos}, 0, {sin}], edge2 = [0,1,0] }}\n[[light]]\nkind = 'sky'\nradiance = 1\n"
    );
    let scene = read(&text);
    let light = Light::Sky { name: "sky".into(), radiance: Bands::splat(1e4), distribution };
    let parts = SceneParts { lights: vec![light], ..scene.into_parts() };
    solve(zonal_scene::Scene::new(parts).unwrap())
}

// Guards (numbers): light that no sample finds is no proof of darkness: the stated error has an upper bound of it.
#[test]
fn light_that_no_sample_finds_is_no_proof_of_darkness() {
    let s = under_a_pixel(0.02);
    assert!(s.zones.patches[0].normal.z > 0.0);
    for (h, e) in s.fields.direct.iter().zip(&s.fields.direct_error) {
        assert!(h.first() > 0.0 || e.first() > 0.0, "{h:?} ± {e:?}");
    }
    // Behind the plate the darkness is proved.
    let s = under_a_pixel(-6.0);
    assert!(s.fields.direct.iter().chain(&s.fields.direct_error).all(|h| *h == Bands::ZERO));
}
